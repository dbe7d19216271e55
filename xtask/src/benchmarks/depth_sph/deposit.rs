//! Flows that come to rest by basal resistance (sheet: depth-sph §5.2, B2; §5.5, V23, V23b).

use colluvium::case::{Case, Solver};
use colluvium::plots::{Series, Style};
use serde_json::{Value, json};

use crate::analysis::MaxOrNan;
use crate::benchmarks::depth_sph::common_cases::{
    NodeProfile, cell_centres, chart, closed_form_series, load, start, step_until,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, scalars, set_method_option, vectors};

/// Benchmark of the dam break of a Bingham fluid and of its deposit.
pub const MUD: Benchmark = Benchmark {
    id: "depth-sph/yield-stress",
    title: "Dam break of a Bingham fluid and its deposit, depth-integrated",
    source: "sheet: depth-sph §5.5, V23",
    short_seconds: None,
    full_seconds: 10,
    run: mud,
};

/// Benchmark of the dam break of grains, dry and saturated.
pub const SATURATED_DEPOSIT: Benchmark = Benchmark {
    id: "depth-sph/saturated-dam",
    title: "Dam break of a frictional saturated material, depth-integrated",
    source: "Pastor and others 2020, §6.2; sheet: depth-sph §5.2, B2; §5.5, V23b",
    short_seconds: Some(15),
    full_seconds: 50,
    run: run_saturated,
};

/// Checks the deposit of mud that its yield stress brings to rest (V23).
fn mud(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut solver = start(&load("yield-stress")?)?;
    let mut stopped = f64::NAN;
    while stopped.is_nan() && solver.time() < 300.0 {
        let end = solver.time() + 1.0;
        step_until(&mut *solver, end)?;
        stopped = reading(&*solver, "stopped");
    }
    let reason = "not judged: the sheet runs until the stopping criterion holds";
    outcome.info("V23: time at which it has stopped (s)", "", stopped, reason);
    let profile = NodeProfile::from_snapshot(&solver.snapshot(), 0, &[0.0]);
    // The square of the depth in limit equilibrium decreases linearly towards the front.
    let (front, wall) = (25.1417, 1.193_237);
    let found = solver.snapshot().positions.iter().map(|x| x[0]).max_or_nan();
    let reason = "V23: a run with inertia stops at or beyond the profile that is just held; 4 %";
    outcome.assert_within("V23: last node (m)", "≥ 25.1417", found, (0.96 * front, f64::INFINITY), reason);
    let reason = "not judged: the ±4 % of the sheet are of a creeping flow, and its 50 Pa s let this one run";
    outcome.info(
        "V23: depth at the wall (m)",
        &format!("{wall}"),
        profile.height_and_velocity_at(0.0).0,
        reason,
    );
    let steepest = cell_centres(1.0, found - 2.0).map(|x| {
        let (h, ahead) =
            (profile.height_and_velocity_at(x - 0.25).0, profile.height_and_velocity_at(x + 0.25).0);
        0.5 * (h + ahead) * (h - ahead) / 0.5 * 1800.0 * 9.81 / 500.0
    });
    let reason = "not judged: by the stopping criterion one node in a hundred may still move";
    outcome.info(
        "V23: largest weight along the bed over the yield stress",
        "1",
        steepest.max_or_nan(),
        reason,
    );
    let depth = |x: f64| (2.0 * 500.0 / (1800.0 * 9.81) * (front - x).max(0.0)).sqrt();
    let mut shown = chart("Deposit of a Bingham fluid", "depth (m)");
    shown.series.push(closed_form_series("just held by the yield stress", 0.0, 45.0, depth));
    shown.series.push(Series::new("nodes", profile.heights(0.0, 45.0), Style::Line));
    outcome
        .svg("V23: the profile that the yield stress just holds (broken), and what comes to rest.", &shown)?;
    Ok(outcome)
}

/// Scalar output of a solver.
fn reading(solver: &dyn Solver, name: &str) -> f64 {
    solver
        .scalar_outputs()
        .into_iter()
        .find(|(own, _, _)| own == name)
        .map_or(f64::NAN, |(_, _, value)| value)
}

/// Kind of material of a run of the saturated dam break (B2).
#[derive(Clone, Copy, PartialEq)]
enum BedStopRun {
    /// Dry grains, one phase.
    Dry,
    /// Saturated mixture in one phase, without excess pore pressure.
    Drained,
    /// Grains and fluid as two phases, with excess pore pressure.
    Full,
    /// Grains and fluid as two phases, without excess pore pressure.
    NoColumn,
}

impl BedStopRun {
    /// Shortest duration of the run (s).
    fn min_duration(self) -> f64 {
        match self {
            Self::Full => 4.5,
            Self::Dry => AT_REST,
            Self::Drained | Self::NoColumn => 0.0,
        }
    }
}

/// Result of a run of the dam break.
struct DepositResult {
    /// Run-out of the last node of grains, and of fluid where there is one (m).
    runout: [f64; 2],
    /// Time at which the last node stops (s).
    stopping_time: f64,
    /// Time (s), excess head (m) and depth (m) of the node in the middle of the reservoir.
    reservoir_middle: Vec<[f64; 3]>,
    /// Change of the volume over the volume.
    volume_change: f64,
    /// The front over time (s, m).
    front: Vec<(f64, f64)>,
    /// Depth of the deposit over the position (m).
    profile: Vec<(f64, f64)>,
}

impl DepositResult {
    /// Time (s), excess head (m) and depth (m) in the middle of the reservoir, interpolated between its records.
    fn middle_at(&self, time: f64) -> [f64; 3] {
        let after = self
            .reservoir_middle
            .partition_point(|row| row[0] < time)
            .clamp(1, self.reservoir_middle.len() - 1);
        let (a, b) = (self.reservoir_middle[after - 1], self.reservoir_middle[after]);
        let share = (time - a[0]) / (b[0] - a[0]);
        std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))
    }
}

/// Case of a dam break that basal friction stops.
fn case(run: BedStopRun, angle: f64, spacing: f64) -> Result<Case, String> {
    let mut case = load("saturated-dam")?;
    set_method_option(&mut case, "depth-sph", "spacing", spacing);
    set_method_option(
        &mut case,
        "depth-sph",
        "basal",
        json!({ "model": "coulomb", "friction_angle": angle }),
    );
    let mut without = |keys: &[&str]| {
        keys.iter().for_each(|key| set_method_option(&mut case, "depth-sph", key, Value::Null));
    };
    match run {
        BedStopRun::Dry => without(&["mixture", "column"]),
        BedStopRun::Drained | BedStopRun::NoColumn => without(&["column"]),
        BedStopRun::Full => {}
    }
    if matches!(run, BedStopRun::Dry | BedStopRun::Drained) {
        set_method_option(&mut case, "depth-sph", "phases", "one");
    }
    Ok(case)
}

/// Time at which all dry material is at rest (s). Its shoulder moves for a while after the front has stopped.
const AT_REST: f64 = 5.0;

/// Runs a dam break until the first node of grains at the front has stopped, and on to `end` (s).
fn compute(run: BedStopRun, angle: f64, spacing: f64, end: f64) -> Result<DepositResult, String> {
    let mut solver = start(&case(run, angle, spacing)?)?;
    let first = solver.snapshot();
    let near = |x: f64| (x - 5.0).abs();
    let closest = (0..first.positions.len())
        .min_by(|a, b| near(first.positions[*a][0]).total_cmp(&near(first.positions[*b][0])));
    let middle = closest.unwrap_or(0);
    let before: f64 = scalars(&first, "volume").iter().sum();
    let mut found = DepositResult {
        runout: [0.0; 2],
        stopping_time: f64::NAN,
        reservoir_middle: Vec::new(),
        volume_change: 0.0,
        front: Vec::new(),
        profile: Vec::new(),
    };
    while found.stopping_time.is_nan() || solver.time() < end {
        let next = solver.time() + 0.01;
        step_until(&mut *solver, next)?;
        let snapshot = solver.snapshot();
        let (phase, velocity) = (scalars(&snapshot, "phase"), vectors(&snapshot, "velocity"));
        let mut speed = 0.0;
        found.runout = [f64::MIN; 2];
        for (i, x) in snapshot.positions.iter().enumerate() {
            let own = usize::from(phase.get(i).is_some_and(|phase| *phase > 0.5));
            if x[0] - 10.0 > found.runout[own] {
                found.runout[own] = x[0] - 10.0;
                speed = if own == 0 { velocity[i][0] } else { speed };
            }
        }
        found.front.push((snapshot.time, found.runout[0]));
        // A node that settles by a millimetre in ten seconds counts as stopped.
        if found.stopping_time.is_nan() && snapshot.time > 0.5 && speed.abs() < 1e-4 {
            found.stopping_time = snapshot.time;
        }
        let depth = scalars(&snapshot, "depth")[middle];
        let ratio = snapshot.scalars("liquefaction").map_or(f64::NAN, |ratio| ratio[middle]);
        found.reservoir_middle.push([snapshot.time, ratio * depth, depth]);
        if snapshot.time > 15.0 {
            return Err(format!("the front still moves at {speed:.2e} m/s after 15 s"));
        }
    }
    let last = solver.snapshot();
    found.volume_change = (scalars(&last, "volume").iter().sum::<f64>() / before - 1.0).abs();
    let profiles = [0, 1].map(|phase| NodeProfile::from_snapshot(&last, phase, &[0.0]));
    let sets = if matches!(run, BedStopRun::Dry | BedStopRun::Drained) { 1 } else { 2 };
    let depth = |x: f64| profiles[..sets].iter().map(|profile| profile.height_and_velocity_at(x).0).sum();
    found.profile = cell_centres(0.0, 45.0).map(|x| (x, depth(x))).collect();
    Ok(found)
}

/// Friction angle (degrees) at which the run-out of the dry material is 11.8 m.
fn calibrated_friction_angle(spacing: f64) -> Result<f64, String> {
    let (mut low, mut high) = (40.0, 60.0);
    for _ in 0..7 {
        let angle = 0.5 * (low + high);
        if compute(BedStopRun::Dry, angle, spacing, 0.0)?.runout[0] > 11.8 {
            low = angle;
        } else {
            high = angle;
        }
    }
    Ok(0.5 * (low + high))
}

/// Checks four run-outs of the saturated dam break, with the friction angle that gives the first one (B2).
fn run_saturated(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let spacing = if quick { 0.08 } else { 0.04 };
    let angle = calibrated_friction_angle(spacing)?;
    let reason =
        "not judged: the source gives none; the sheet expects 49.8° on 250 nodes, the short form has 125";
    outcome.info("B2: angle of friction that gives (a) (degrees)", "49.8", angle, reason);
    let runs = [BedStopRun::Dry, BedStopRun::Drained, BedStopRun::Full, BedStopRun::NoColumn];
    let mut found = Vec::new();
    for run in runs {
        found.push(compute(run, angle, spacing, run.min_duration())?);
    }
    let [dry, drained, full, plain] = &found[..] else { return Err("four runs".to_owned()) };
    run_outs(&mut outcome, [dry, drained, full, plain]);
    check_fronts_and_middle(&mut outcome, full);
    let change = found.iter().map(|run| run.volume_change).max_or_nan();
    outcome.assert_below("B2: change of the volume", "0", change, 0.0, "B2: exact");
    check_surface_slope(&mut outcome, dry, angle, quick)?;
    draw(&mut outcome, &found)?;
    Ok(outcome)
}

/// Checks run-outs and stopping times of the four runs.
fn run_outs(outcome: &mut BenchmarkOutcome, [dry, drained, full, plain]: [&DepositResult; 4]) {
    outcome.info("B2 (a) dry: run-out (m)", "11.80", dry.runout[0], "not judged: it sets the angle");
    outcome.assert_close("B2 (b) saturated, drained: run-out (m)", 24.5, 0.08, drained.runout[0], "B2: ±8 %");
    let name = "B2 (c) two phases and pore pressure: run-out (m)";
    outcome.assert_close(name, 31.6, 0.18, full.runout[0], "B2: ±18 %");
    let reason = "B2: (c) > (b) > (a)";
    outcome.assert_above("B2: (b) over (a)", "> 1", drained.runout[0] / dry.runout[0], 1.0, reason);
    outcome.assert_above("B2: (c) over (b)", "> 1", full.runout[0] / drained.runout[0], 1.0, reason);
    let reason = "B2: (d) stops before (c), in place and time";
    for (name, ratio) in [
        ("B2: run-out of (d), no column, over (c)", plain.runout[0] / full.runout[0]),
        ("B2: stop of (d), no column, over (c)", plain.stopping_time / full.stopping_time),
    ] {
        outcome.assert_below(name, "< 1", ratio, 1.0, reason);
    }
    let stops = [("(a)", dry, 1.75), ("(b)", drained, 3.0), ("(c)", full, 3.5)].map(|(name, run, exact)| {
        (format!("B2 {name}: time at which the front stops (s)"), exact, run.stopping_time)
    });
    outcome.assert_all_close(stops, 0.2, "B2: ±20 %");
}

/// Checks the fronts of grains and fluid, and the column that began in the middle of the reservoir (B2 (c)).
fn check_fronts_and_middle(outcome: &mut BenchmarkOutcome, full: &DepositResult) {
    let apart = (full.runout[0] - full.runout[1]).abs() / full.runout[0];
    outcome.assert_below(
        "B2 (c): distance of the fronts over the run-out",
        "together",
        apart,
        0.01,
        "B2: 1 %",
    );
    let reason = "B2: the column of the middle drains under a constant depth until the wave is there";
    outcome.assert_within(
        "B2 (c): head in the middle at 0.5 s (m)",
        "8.637",
        full.middle_at(0.5)[1],
        (8.4, 8.8),
        reason,
    );
    outcome.assert_below(
        "B2 (c): head in the middle at 3.2 s (m)",
        "0",
        full.middle_at(3.2)[1],
        1.0,
        "B2: below 10 % of h₀",
    );
    let depths = full
        .reservoir_middle
        .iter()
        .filter(|row| row[0] > 3.6)
        .map(|row| (row[2] / full.middle_at(3.6)[2] - 1.0).abs());
    outcome.assert_below(
        "B2 (c): change of depth in the middle after 3.6 s",
        "constant",
        depths.max_or_nan(),
        0.01,
        "B2: 1 %",
    );
}

/// Checks that no surface of a deposit is steeper than its friction angle (V23b). At the shoulder, where the slope begins, it is less steep
/// with finer nodes. Judged in the full form: the short form has the friction angle fitted with half as many nodes.
fn check_surface_slope(
    outcome: &mut BenchmarkOutcome,
    dry: &DepositResult,
    angle: f64,
    quick: bool,
) -> Result<(), String> {
    let name = |nodes: &str, what: &str| format!("V23b, {nodes}: {what}");
    let reason = "not judged: resolution, beside the finer nodes below";
    let coarse = steepest(&dry.profile);
    outcome.info(
        name("as B2", "steepest surface of (a) (degrees)"),
        &format!("{angle:.2}"),
        coarse[0],
        reason,
    );
    let fine = steepest(&compute(BedStopRun::Dry, angle, 0.02, AT_REST)?.profile);
    let (title, angles) = (name("500 nodes", "steepest surface of (a) (degrees)"), format!("{angle:.2}"));
    if quick {
        let reason = "not judged: the friction that half of the nodes of B2 ask for; the full form judges";
        outcome.info(title, &angles, fine[0], reason);
    } else {
        let reason = "V23b: 2°; over 0.45 m, where the deposit is deeper than 0.3 m";
        outcome.assert_below(title, &angles, fine[0], angle + 2.0, reason);
    }
    let reason = "not judged: where the surface is steepest";
    outcome.info(name("500 nodes", "place of it (m)"), "", fine[1], reason);
    outcome.info(name("500 nodes", "depth there (m)"), "", fine[2], reason);
    Ok(())
}

/// Steepest slope of a deposit (degrees), its position and its depth (m).
fn steepest(profile: &[(f64, f64)]) -> [f64; 3] {
    // The edge itself is as wide as a kernel.
    let end = profile.iter().rfind(|(_, h)| *h > 0.3).map_or(0.0, |(x, _)| *x);
    let inside: Vec<_> = profile.iter().filter(|(x, _)| *x < end).collect();
    let slope = |w: &[&(f64, f64)]| (w[0].1 - w[5].1) / (w[5].0 - w[0].0);
    let found = inside.windows(6).max_by(|a, b| slope(a).total_cmp(&slope(b)));
    found.map_or([f64::NAN; 3], |w| {
        [slope(w).atan().to_degrees(), 0.5 * (w[0].0 + w[5].0), 0.5 * (w[0].1 + w[5].1)]
    })
}

/// Draws the deposits and the positions of the fronts.
fn draw(outcome: &mut BenchmarkOutcome, found: &[DepositResult]) -> Result<(), String> {
    let names =
        ["(a) dry", "(b) saturated, drained", "(c) two phases, pore pressure", "(d) two phases, no column"];
    let mut shown = chart("Deposits of four dam breaks", "depth (m)");
    let mut fronts = chart("Front over time", "run-out (m)");
    fronts.x_label = "time (s)".to_owned();
    for (run, name) in found.iter().zip(names) {
        shown.series.push(Series::new(name, run.profile.clone(), Style::Line));
        fronts.series.push(Series::new(name, run.front.clone(), Style::Line));
    }
    outcome.svg("B2: depths when the fronts have stopped; (a) after 5 s, (c) after 4.5 s.", &shown)?;
    outcome
        .svg("B2: last nodes of the grains; the source has 11.8, 24.5 and 31.6 m for (a) to (c).", &fronts)?;
    let mut heads = chart("Excess head at the base in the middle of the reservoir", "head (m)");
    heads.x_label = "time (s)".to_owned();
    let full = &found[2].reservoir_middle;
    heads.series.push(Series::new(
        "excess head",
        full.iter().map(|row| (row[0], row[1])).collect(),
        Style::Line,
    ));
    heads.series.push(Series::new("depth", full.iter().map(|row| (row[0], row[2])).collect(), Style::Line));
    outcome.svg("B2 (c): the column that began in the middle of the reservoir.", &heads)
}
