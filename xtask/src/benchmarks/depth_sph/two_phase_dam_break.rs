//! Dam break of a two-phase mixture between walls, with strong drag and without (sheet: depth-sph §5.2, B1, B1b).

use colluvium::case::{Snapshot, Solver};
use colluvium::depth_sph::analytical_solutions::LockedDam;
use colluvium::plots::{Series, Style};
use serde_json::{Value, json};

use crate::benchmarks::depth_sph::common_cases::{
    NodeProfile, cell_centres, chart, closed_form_series, load, start, step_until,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, patched_case, scalars};

/// Benchmark of a dam break of grains and fluid, with strong drag and without drag.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/two-phase-dam",
    title: "Dam break of grains and fluid with strong drag and without, depth-integrated",
    source: "Pastor and others 2020, §6.1; sheet: depth-sph §5.2, B1, B1b",
    short_seconds: Some(8),
    full_seconds: 45,
    run,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Half of the distance of the walls (m).
const HALF_LENGTH: f64 = 10.0;
/// Positions of the walls (m).
const WALLS: [f64; 2] = [-HALF_LENGTH, HALF_LENGTH];

/// Checks the dam break of a mixture against closed forms: with strong drag and without drag.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    check_strong_drag(&mut outcome, 0.3, if quick { 2.0 } else { 6.0 })?;
    if !quick {
        check_strong_drag(&mut outcome, 0.03, 2.0)?;
    }
    check_no_drag(&mut outcome, "node", 0.03)?;
    if !quick {
        check_no_drag(&mut outcome, "symmetric", 0.07)?;
    }
    Ok(outcome)
}

/// Solver of the case with another drag law, form of the pressure force and Courant number.
fn solver(changes: &[(&str, Value)]) -> Result<Box<dyn Solver>, String> {
    let keys: Vec<(String, Value)> =
        changes.iter().map(|(key, value)| (format!("/methods/depth-sph/{key}"), value.clone())).collect();
    let changes: Vec<(&str, Value)> = keys.iter().map(|(key, value)| (key.as_str(), value.clone())).collect();
    start(&patched_case(&load("two-phase-dam")?, &changes)?)
}

/// Volumes of grains and fluid (m²).
fn volumes(snapshot: &Snapshot) -> [f64; 2] {
    let (volume, phase) = (scalars(snapshot, "volume"), scalars(snapshot, "phase"));
    [0.0, 1.0].map(|own| volume.iter().zip(&phase).filter(|(_, phase)| **phase == own).map(|(v, _)| v).sum())
}

/// Profiles of both phases by SPH sums over their nodes.
struct PhaseProfiles([NodeProfile; 2]);

impl PhaseProfiles {
    /// Profiles of grains and fluid.
    fn from_snapshot(snapshot: &Snapshot) -> Self {
        Self([0, 1].map(|phase| NodeProfile::from_snapshot(snapshot, phase, &WALLS)))
    }

    /// Total depth at a position (m).
    fn depth(&self, x: f64) -> f64 {
        self.0[0].height_and_velocity_at(x).0 + self.0[1].height_and_velocity_at(x).0
    }

    /// Velocities of grains and fluid at a position (m/s).
    fn velocities(&self, x: f64) -> [f64; 2] {
        [self.0[0].height_and_velocity_at(x).1, self.0[1].height_and_velocity_at(x).1]
    }

    /// Share of the fluid in the depth at a position.
    fn porosity(&self, x: f64) -> f64 {
        self.0[1].height_and_velocity_at(x).0 / self.depth(x)
    }

    /// First position between `low` and `high` (m) at which `value` passes `level`, upward or downward.
    fn first_crossing(low: f64, high: f64, level: f64, value: impl Fn(f64) -> f64) -> f64 {
        let count = 4000;
        let place = |k: i32| low + (high - low) * f64::from(k) / f64::from(count);
        let mut before = value(low);
        for k in 1..=count {
            let now = value(place(k));
            if (before - level) * (now - level) <= 0.0 && before != now {
                return place(k - 1) + (high - low) / f64::from(count) * (level - before) / (now - before);
            }
            before = now;
        }
        f64::NAN
    }
}

/// Checks a dam break in which the drag of a settling velocity of 1 mm/s locks the phases (B1).
fn check_strong_drag(outcome: &mut BenchmarkOutcome, courant: f64, end: f64) -> Result<(), String> {
    let exact = LockedDam::new(GRAVITY, [1360.0 / 1.04, 2220.0 / 1.38], [1.04, 1.38]);
    let mut solver = solver(&[("courant", json!(courant))])?;
    let volumes_before = volumes(&solver.snapshot());
    for time in [0.5, 1.0, 1.5, 2.0] {
        step_until(&mut *solver, time)?;
        let both = PhaseProfiles::from_snapshot(&solver.snapshot());
        let name = |what: &str| format!("B1, Courant number {courant}, {time} s: {what}");
        mean_errors(outcome, &both, &exact, time, &name);
        wave_positions(outcome, &both, &exact, time, &name);
    }
    draw(outcome, &solver.snapshot(), &exact, courant)?;
    if end > 2.0 {
        check_reflection(outcome, &mut *solver)?;
    }
    let volumes_after = volumes(&solver.snapshot());
    for (phase, (before, after)) in volumes_before.into_iter().zip(volumes_after).enumerate() {
        let exact = [11.6, 12.6][phase];
        let name = format!("B1, Courant number {courant}: volume of phase {phase} (m²)");
        outcome.assert_close(name, exact, 1e-12, if after == before { after } else { f64::NAN }, "B1: 1e-12");
    }
    Ok(())
}

/// Checks depth, velocity and slip of the phases against the closed form.
fn mean_errors(
    outcome: &mut BenchmarkOutcome,
    both: &PhaseProfiles,
    exact: &LockedDam,
    time: f64,
    name: &dyn Fn(&str) -> String,
) {
    let (mut depth, mut velocity, mut slip) = (0.0, 0.0, 0.0f64);
    for x in cell_centres(-HALF_LENGTH, HALF_LENGTH) {
        let ((h, u), [solid, fluid]) = (exact.state_at(x, time), both.velocities(x));
        depth += (both.depth(x) - h).abs() / 500.0;
        velocity += (solid - u).abs() / 500.0;
        slip = slip.max((fluid - solid).abs());
    }
    let speed = exact.velocity.abs();
    outcome.assert_below(name("mean error of depth over 1.2 m"), "0", depth / 1.2, 0.015, "B1: 1.5 %");
    let title = name("mean error of velocity over that between the waves");
    outcome.assert_below(title, "0", velocity / speed, 0.03, "B1: 3 %");
    outcome.assert_below(name("largest slip over that velocity"), "0", slip / speed, 0.02, "B1: 2 %");
}

/// Checks the positions of bore, contact and rarefaction against the closed form.
fn wave_positions(
    outcome: &mut BenchmarkOutcome,
    both: &PhaseProfiles,
    exact: &LockedDam,
    time: f64,
    name: &dyn Fn(&str) -> String,
) {
    let mut near = |title: &str, place: f64, found: f64, width: f64, reason: &str| {
        let range = (place - width, place + width);
        outcome.assert_within(name(title), &format!("{place:.4}"), found, range, reason);
    };
    let [bore, _, contact, tail, head] = exact.waves().map(|wave| wave * time);
    let found =
        PhaseProfiles::first_crossing(-HALF_LENGTH, contact, 0.5 * (1.04 + exact.contact_depths[0]), |x| {
            both.depth(x)
        });
    near("bore (m)", bore, found, 0.15, "B1: ±0.15 m");
    let found = PhaseProfiles::first_crossing(bore, tail, 0.541_8, |x| both.porosity(x));
    near("contact (m)", contact, found, 0.1, "B1: ±0.1 m");
    // In the fan the velocity is linear: from the positions with a quarter and three quarters of that between the waves.
    let at = |share: f64| {
        PhaseProfiles::first_crossing(tail - 0.3, HALF_LENGTH, share * exact.velocity, |x| {
            both.velocities(x)[0]
        })
    };
    let (inner, outer) = (at(0.75), at(0.25));
    let found = outer + 0.5 * (outer - inner);
    let reason = "B1: ±0.15 m; velocities at a quarter and three quarters of the fan, extended to rest";
    near("head of the rarefaction (m)", head, found, 0.15, reason);
}

/// Draws depth, velocity and porosity after two seconds beside the closed form.
fn draw(
    outcome: &mut BenchmarkOutcome,
    snapshot: &Snapshot,
    exact: &LockedDam,
    courant: f64,
) -> Result<(), String> {
    let both = PhaseProfiles::from_snapshot(snapshot);
    let mut shown = chart("Grains and fluid after 2 s, strong drag", "m, m/s, –");
    shown.series.push(closed_form_series("depth, closed form", -HALF_LENGTH, HALF_LENGTH, |x| {
        exact.state_at(x, 2.0).0
    }));
    shown.series.push(closed_form_series("velocity, closed form", -HALF_LENGTH, HALF_LENGTH, |x| {
        exact.state_at(x, 2.0).1
    }));
    let over =
        |value: &dyn Fn(f64) -> f64| cell_centres(-HALF_LENGTH, HALF_LENGTH).map(|x| (x, value(x))).collect();
    shown.series.push(Series::new("depth", over(&|x| both.depth(x)), Style::Line));
    shown.series.push(Series::new("velocity", over(&|x| both.velocities(x)[0]), Style::Line));
    shown.series.push(Series::new("porosity", over(&|x| both.porosity(x)), Style::Line));
    outcome.svg(&format!("B1, Courant number {courant}: a bore, a contact and a rarefaction."), &shown)
}

/// Checks the state after the waves have reached the walls against a finite-volume computation of the sheet.
fn check_reflection(outcome: &mut BenchmarkOutcome, solver: &mut dyn Solver) -> Result<(), String> {
    let places = [-9.0, -6.0, -4.0, -2.0, 0.0, 4.0, 6.0, 8.0, 9.0];
    let rows = [
        (3.5, 0.03, [1.5159, 1.2667, 1.2667, 1.146, 1.1421, 1.1421, 1.1421, 1.0759, 1.0172]),
        (6.0, 0.05, [1.5159, 1.5227, 1.5227, 1.3332, 1.2521, 0.9267, 0.9267, 0.9267, 0.9267]),
    ];
    for (time, bound, table) in rows {
        step_until(solver, time)?;
        let both = PhaseProfiles::from_snapshot(&solver.snapshot());
        let error: f64 = places.iter().zip(table).map(|(x, h)| (both.depth(*x) - h).abs() / 9.0).sum();
        let reason = "B1: 3 % at 3.5 s, 5 % at 6 s; the places of the sheet's table";
        let name = format!("B1, {time} s: mean difference of depth from finite volumes over 1.2 m");
        outcome.assert_below(name, "0", error / 1.2, bound, reason);
    }
    Ok(())
}

/// Checks a dam break of phases without mutual drag (B1b).
fn check_no_drag(outcome: &mut BenchmarkOutcome, momentum: &str, bound: f64) -> Result<(), String> {
    let none = json!({ "law": "none" });
    let mut solver = solver(&[("mixture/drag", none), ("momentum", json!(momentum))])?;
    step_until(&mut *solver, 2.0)?;
    let both = PhaseProfiles::from_snapshot(&solver.snapshot());
    let table =
        [(0.0, 1.1965, -1.0152, -0.2352), (2.0, 1.1579, -0.6179, -0.6179), (4.0, 1.1579, -0.6181, -0.6181)];
    let form = format!("{momentum} form");
    for (x, depth, solid, fluid) in table {
        let name = |what: &str| format!("B1b, {form}, x = {x} m: {what}");
        outcome.assert_close(name("depth (m)"), depth, 0.015, both.depth(x), "B1b: 1.5 %");
        let reason = "B1b: 3 % in node form, 7 % in symmetric form; finite volumes of the sheet";
        let found = both.velocities(x);
        outcome.assert_close(name("velocity of the grains (m/s)"), solid, bound, found[0], reason);
        outcome.assert_close(name("velocity of the fluid (m/s)"), fluid, bound, found[1], reason);
    }
    let mut shown = chart(&format!("Grains and fluid after 2 s, no drag, {form}"), "m, m/s, –");
    let over =
        |value: &dyn Fn(f64) -> f64| cell_centres(-HALF_LENGTH, HALF_LENGTH).map(|x| (x, value(x))).collect();
    shown.series.push(Series::new("depth", over(&|x| both.depth(x)), Style::Line));
    shown.series.push(Series::new("velocity of the grains", over(&|x| both.velocities(x)[0]), Style::Line));
    shown.series.push(Series::new("velocity of the fluid", over(&|x| both.velocities(x)[1]), Style::Line));
    shown.series.push(Series::new("porosity", over(&|x| both.porosity(x)), Style::Line));
    let reference = [
        (-6.0, 1.2632),
        (-4.0, 1.2278),
        (-2.0, 1.1965),
        (0.0, 1.1965),
        (2.0, 1.1579),
        (4.0, 1.1579),
        (6.0, 1.2172),
    ];
    shown.series.push(Series::new("depth, finite volumes", reference.to_vec(), Style::Markers));
    outcome.svg("B1b: four waves.", &shown)
}
