//! Dam break on a dry bed (sheet: depth-sph §5.3, V5; §5.5, V17).

use colluvium::case::Case;
use colluvium::depth_sph::analytical_solutions::ritter;
use colluvium::plots::{Series, Style};
use serde_json::{Value, json};

use crate::benchmarks::depth_sph::common_cases::{
    NodeProfile, chart, closed_form_series, load, start, step_until,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, set_material, set_method_option};

/// Benchmark of a dam break on a dry bed.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/dry-bed",
    title: "Dam break on a dry bed, depth-integrated",
    source: "Ritter 1892; sheet: depth-sph §5.3, V5; §5.5, V17",
    short_seconds: Some(3),
    full_seconds: 12,
    run,
};

/// Depth of the reservoir (m).
const DEPTH: f64 = 10.0;
/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;

/// Checks the dam break on a dry bed, of one phase and of two, against Ritter's solution.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    run_single_phase(&mut outcome, quick)?;
    run_two_phases(&mut outcome, quick)?;
    Ok(outcome)
}

/// Errors of a dam break against Ritter's solution, and the lag of the front.
struct RitterErrors {
    height: f64,
    velocity: f64,
    discharge: f64,
    front_lag: f64,
    profile: NodeProfile,
}

/// Errors of depth and velocity of a phase after one second; `share` is the part of the depth that the phase has.
fn measure(case: &Case, phase: usize, share: f64) -> Result<RitterErrors, String> {
    let mut solver = start(case)?;
    let before = solver.totals().mass;
    step_until(&mut *solver, 1.0)?;
    let after = solver.totals().mass;
    if after != before {
        return Err(format!("mass {after} kg of {before} kg"));
    }
    let profile = NodeProfile::from_snapshot(&solver.snapshot(), phase, &[-20.0]);
    let celerity = (GRAVITY * DEPTH).sqrt();
    let exact = |x: f64| {
        let (h, u) = ritter(GRAVITY, DEPTH, x, 1.0);
        (share * h, u)
    };
    let height = profile.errors(-20.0, 2.0 * celerity, exact).0 / (share * DEPTH);
    let velocity = profile.errors(-20.0, 10.0, exact).1 / celerity;
    let (h, u) = profile.height_and_velocity_at(0.0);
    let front = solver.snapshot().positions.iter().map(|x| x[0]).fold(f64::MIN, f64::max);
    Ok(RitterErrors {
        height,
        velocity,
        discharge: h * u / share,
        front_lag: 2.0 * celerity - front,
        profile,
    })
}

/// Checks the dam break of one phase against Ritter's solution (V5).
fn run_single_phase(outcome: &mut BenchmarkOutcome, quick: bool) -> Result<(), String> {
    let counts: &[u32] = if quick { &[200, 400] } else { &[100, 200, 400, 800] };
    let mut before = f64::INFINITY;
    let mut depths = chart("Water from a reservoir after 1 s", "depth (m)");
    let mut speeds = chart("Its velocity", "velocity (m/s)");
    let end = 2.0 * (GRAVITY * DEPTH).sqrt();
    depths.series.push(closed_form_series("Ritter", -20.0, end, |x| ritter(GRAVITY, DEPTH, x, 1.0).0));
    speeds.series.push(closed_form_series("Ritter", -20.0, end, |x| ritter(GRAVITY, DEPTH, x, 1.0).1));
    for &count in counts {
        let mut case = load("dry-bed")?;
        set_method_option(&mut case, "depth-sph", "spacing", 20.0 / f64::from(count));
        let found = measure(&case, 0, 1.0)?;
        let name = |what: &str| format!("V5, {count} nodes: {what}");
        if count == 400 {
            let reason = "V5: below 0.6 %";
            outcome.assert_below(
                name("mean error of depth over the first depth"),
                "0",
                found.height,
                0.006,
                reason,
            );
            let reason = "V5: below 0.7 %, x < 10 m";
            outcome.assert_below(
                name("mean error of velocity over celerity"),
                "0",
                found.velocity,
                0.007,
                reason,
            );
            outcome.assert_close(
                name("discharge at the dam (m²/s)"),
                29.346_798,
                0.01,
                found.discharge,
                "V5: 1 %",
            );
            depths.series.push(Series::new("400 nodes", found.profile.heights(-20.0, end), Style::Line));
            speeds.series.push(Series::new("400 nodes", found.profile.velocities(-20.0, end), Style::Line));
        }
        let area: f64 = 0.5 * DEPTH * 20.0 / f64::from(count);
        let reason = "not judged: the last node stands where half of its volume is ahead, (27 g t² A)^⅓ behind the front";
        let lag = (27.0 * GRAVITY * area).cbrt();
        outcome.info(name("lag of the last node (m)"), &format!("{lag:.3}"), found.front_lag, reason);
        let reason = "V5: the error falls with the number of nodes";
        outcome.assert_below(
            name("mean error of depth, falling"),
            "less than with fewer",
            found.height,
            before,
            reason,
        );
        before = found.height;
    }
    outcome.svg("V5: depth after 1 s, by sums over the nodes, and the closed form of Ritter.", &depths)?;
    outcome.svg("V5: velocity after 1 s.", &speeds)
}

/// Checks that two phases of equal porosity everywhere move as one phase, with any drag (V17).
fn run_two_phases(outcome: &mut BenchmarkOutcome, quick: bool) -> Result<(), String> {
    let drags: &[(&str, Value)] = &[
        ("V_T = 1 mm/s", json!({ "law": "anderson", "settling_velocity": 1e-3 })),
        ("V_T = 1 m/s", json!({ "law": "anderson", "settling_velocity": 1.0 })),
        ("no drag", json!({ "law": "none" })),
    ];
    for (name, drag) in drags.iter().take(if quick { 1 } else { 3 }) {
        let mut case = load("dry-bed")?;
        set_material(&mut case, "water", &[("density", json!(1900.0))])?;
        set_method_option(&mut case, "depth-sph", "phases", "two");
        let mixture = json!({ "grain_density": 2500, "fluid_density": 1000, "porosity": 0.4, "drag": drag });
        set_method_option(&mut case, "depth-sph", "mixture", mixture);
        let [solid, fluid] = [measure(&case, 0, 0.6)?, measure(&case, 1, 0.4)?];
        for (phase, found) in [("grains", &solid), ("fluid", &fluid)] {
            let label = |what: &str| format!("V17, {name}, {phase}: {what}");
            let reason = "V17: as V5, 0.6 %";
            outcome.assert_below(
                label("mean error of height over the first one"),
                "0",
                found.height,
                0.006,
                reason,
            );
            let reason = "V17: as V5, 0.7 %";
            outcome.assert_below(
                label("mean error of velocity over celerity"),
                "0",
                found.velocity,
                0.007,
                reason,
            );
        }
        let apart = crate::benchmarks::depth_sph::common_cases::cell_centres(-18.0, 14.0).map(|x| {
            let (solid, fluid) =
                (solid.profile.height_and_velocity_at(x).0, fluid.profile.height_and_velocity_at(x).0);
            (fluid / (solid + fluid) - 0.4).abs()
        });
        let worst = apart.fold(0.0, f64::max);
        outcome.assert_below(
            format!("V17, {name}: largest change of porosity inside"),
            "0",
            worst,
            0.01,
            "V17: below 0.01",
        );
    }
    Ok(())
}
