//! Bearing capacity of a strip footing (sheet: sph V-39; B-07).

use std::f64::consts::PI;

use colluvium::case::{Case, RunReport, Snapshot};
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use colluvium::points::Shape;
use serde_json::Value;

use crate::analysis::{base_of_moving_mass, regression_slope};
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, initial_positions, load_case, run_in_memory, set_material,
    set_method_option, stresses,
};

/// Benchmark of the bearing capacity of clay under a strip footing, with the Drucker–Prager cone of plane strain.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/footing",
    title: "Strip footing: Prandtl's bearing capacity, SPH",
    source: "Prandtl 1921; Bui & Nguyen 2021, Fig. 24; sheet: sph V-39",
    short_seconds: Some(30),
    full_seconds: 220,
    run: |quick| run_footing(&[CLAY], if quick { &[0.1] } else { &[0.1, 0.05] }),
};

/// Benchmark of the bearing capacity of clay under a smooth strip footing.
pub const SMOOTH: Benchmark = Benchmark {
    id: "sph/footing-smooth",
    title: "Smooth strip footing: Prandtl's bearing capacity, SPH",
    short_seconds: Some(30),
    full_seconds: 220,
    run: |quick| run_footing(&[SLIPPERY], if quick { &[0.1] } else { &[0.1, 0.05] }),
    ..BENCHMARK
};

/// Benchmark of a strip footing on clay with the cone through triaxial compression, and on soil with friction.
pub const SOILS: Benchmark = Benchmark {
    id: "sph/footing-soils",
    title: "Strip footing on other soils, SPH",
    short_seconds: None,
    full_seconds: 34,
    run: |_| run_footing(&[CONE, FRICTION], &[0.1]),
    ..BENCHMARK
};

/// Benchmark of a strip footing on clay with the cone through triaxial compression, and on soil with friction, at half the spacing.
pub const SOILS_FINE: Benchmark = Benchmark {
    id: "sph/footing-soils-fine",
    title: "Strip footing on other soils, a twentieth of its width, SPH",
    short_seconds: None,
    full_seconds: 320,
    run: |_| run_footing(&[CONE, FRICTION], &[0.05]),
    ..BENCHMARK
};

/// Soil under the footing, with the size and duration of its test.
#[derive(Clone, Copy)]
struct FootingSoil {
    name: &'static str,
    matching: &'static str,
    /// Angle of friction and of dilatancy (degrees).
    friction: f64,
    /// Whether the soil slips along the footing.
    slips: bool,
    /// Half of the width of the domain (m).
    half_width: f64,
    /// Duration of the footing's motion (s).
    duration: f64,
}

/// Clay under a rough footing.
const CLAY: FootingSoil = FootingSoil {
    name: "von Mises",
    matching: "plane-strain",
    friction: 0.0,
    slips: false,
    half_width: 4.0,
    duration: 6.0,
};
/// Clay under a smooth footing.
const SLIPPERY: FootingSoil = FootingSoil { name: "smooth footing", slips: true, ..CLAY };
/// Clay with the Drucker–Prager cone through triaxial compression.
const CONE: FootingSoil = FootingSoil { name: "cone through compression", matching: "compression", ..CLAY };
/// Frictional soil. The exit of Prandtl's mechanism is 3.77 m from the middle, 4.14 m with the effective width. The mechanism takes three
/// times the load, and so three times the displacement.
const FRICTION: FootingSoil =
    FootingSoil { name: "friction of 25 degrees", friction: 25.0, half_width: 6.0, duration: 16.0, ..CLAY };

impl FootingSoil {
    /// Prandtl's bearing capacity over cohesion.
    fn capacity(&self) -> f64 {
        let angle = self.friction.to_radians();
        if angle > 0.0 {
            let surcharge = (PI * angle.tan()).exp() * (0.25 * PI + 0.5 * angle).tan().powi(2);
            (surcharge - 1.0) / angle.tan()
        } else {
            // The cone through compression has 2/√3 of the cohesion in plane strain.
            (2.0 + PI) * if self.matching == "compression" { 2.0 / 3f64.sqrt() } else { 1.0 }
        }
    }

    /// Case of a footing on this soil.
    fn case(&self, spacing: f64) -> Result<Case, String> {
        let mut case = load_case("sph/footing")?;
        case.domain.max[0] = self.half_width;
        case.bodies[0].shape = Shape::Box { min: vec![0.0, 0.0], max: vec![self.half_width, SOIL] };
        case.stages[0].duration = self.duration;
        let angle = || Value::from(self.friction);
        let keys =
            [("matching", self.matching.into()), ("friction_angle", angle()), ("dilatancy_angle", angle())];
        set_material(&mut case, "clay", &keys)?;
        set_method_option(&mut case, "sph", "spacing", spacing);
        if self.slips {
            set_method_option(&mut case, "sph", "smooth_bodies", serde_json::json!(["footing"]));
        }
        Ok(case)
    }
}

/// Cohesion of the clay (Pa).
const COHESION: f64 = 10e3;
/// Width of the footing (m).
const WIDTH: f64 = 1.0;
/// Depths between which the vertical force is evaluated (m): it is equal at all of them.
const DEPTHS: std::ops::Range<f64> = 1.0..2.0;
/// Depth of the soil (m).
const SOIL: f64 = 4.0;
/// Velocity of the footing (m/s).
const SPEED: f64 = 8.2e-3;

/// Mean vertical force over the depths per half of the `width` (m) that carries it, over the cohesion.
fn pressure(snapshot: &Snapshot, width: f64) -> f64 {
    let stress = stresses(snapshot);
    let force: f64 = snapshot
        .positions
        .iter()
        .zip(&stress)
        .zip(&snapshot.extents)
        .filter(|((x, _), _)| DEPTHS.contains(&(SOIL - x[1])))
        .map(|((_, s), e)| -s.component(1, 1) * e[0] * e[1])
        .sum();
    let depth = DEPTHS.end - DEPTHS.start;
    force / depth / (0.5 * width) / COHESION
}

/// Angle of the side of the soil wedge that moves down with the footing (degrees). In Prandtl's mechanism the soil within has the velocity
/// of the footing and beside it moves down half as fast, with associated friction too. The side is the regression line through the
/// positions in the columns under the footing where the mean velocity between two frames passes three quarters of the footing's.
fn wedge([first, last]: [&Snapshot; 2], spacing: f64) -> f64 {
    let settlement = SPEED * (last.time - first.time);
    let sinks = |p: usize| (first.positions[p][1] - last.positions[p][1]) / settlement;
    let under = initial_positions(first)
        .into_iter()
        .enumerate()
        .filter(|(p, start)| first.bodies[*p] == 0 && start[0] < 0.4 * WIDTH)
        .map(|(p, start)| (start, sinks(p)));
    let side: Vec<(f64, f64)> =
        base_of_moving_mass(under, spacing, 0.75).into_iter().map(|[x, y]| (x, y)).collect();
    regression_slope(&side).atan().to_degrees()
}

/// Checks bearing capacities of footings at several spacings.
fn run_footing(soils: &[FootingSoil], spacings: &[f64]) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    for soil in soils {
        let mut chart = LineChart::new(
            format!("Strip footing, {}", soil.name),
            "settlement over width",
            "pressure over cohesion",
        );
        for &spacing in spacings {
            let curve = load_curve(&mut outcome, soil, spacing)?;
            chart.series.push(Series::new(format!("spacing {spacing} m"), curve, Style::Line));
        }
        let (exact, end) = (soil.capacity(), SPEED * soil.duration / WIDTH);
        chart.series.push(Series::new("Prandtl", vec![(0.0, exact), (end, exact)], Style::Dashed));
        outcome.svg("Pressure under the footing, from the vertical force in the soil below.", &chart)?;
    }
    Ok(outcome)
}

/// Pushes the footing into a soil, and returns the pressure over the cohesion over the settlement over the width.
fn load_curve(
    outcome: &mut BenchmarkOutcome,
    soil: &FootingSoil,
    spacing: f64,
) -> Result<Vec<(f64, f64)>, String> {
    let label = |what: &str| match soil.name {
        "von Mises" => format!("spacing {spacing} m: {what}"),
        name => format!("{name}, spacing {spacing} m: {what}"),
    };
    let report = run_in_memory("sph", &soil.case(spacing)?)?;
    // Over the effective width that the sheet prescribes.
    let width = WIDTH + spacing;
    let curve: Vec<(f64, f64)> =
        report.frames.iter().map(|frame| (SPEED * frame.time / WIDTH, pressure(frame, width))).collect();
    let last = &curve[curve.len() * 4 / 5..];
    let plateau = last.iter().map(|(_, q)| q).sum::<f64>() / last.len() as f64;
    let reason = "V-39: ± 10 % over the effective width, one spacing wider than the footing";
    outcome.assert_close(label("plateau over cohesion"), soil.capacity(), 0.1, plateau, reason);
    let rise = last[last.len() - 1].1 / last[0].1 - 1.0;
    let unjudged = "not judged: how flat the plateau is";
    outcome.info(label("rise over the last fifth"), "0", rise, unjudged);
    if soil.slips {
        let unjudged = "not judged: a smooth footing takes along nothing of the soil beside it";
        outcome.info(
            label("plateau over cohesion, over the width of the footing"),
            "5.14",
            plateau * width / WIDTH,
            unjudged,
        );
    }
    // Hill's mechanism under a smooth footing has two wedges.
    if !soil.slips {
        judge_wedge(outcome, label("angle of the wedge under the footing (degrees)"), soil, &report, spacing);
    }
    if let Some(cloud) = PointCloud::from_snapshot(&report.snapshot, "displacement", [0, 1]) {
        outcome.png(&format!("Displacement at the end, {}, spacing {spacing} m.", soil.name), &cloud)?;
    }
    Ok(curve)
}

/// Checks the angle of the wedge against Prandtl's.
fn judge_wedge(
    outcome: &mut BenchmarkOutcome,
    name: String,
    soil: &FootingSoil,
    report: &RunReport,
    spacing: f64,
) {
    let frames = &report.frames[report.frames.len() * 4 / 5..];
    let angle = wedge([&frames[0], &frames[frames.len() - 1]], spacing);
    let exact = 45.0 + 0.5 * soil.friction;
    let room = (spacing / (0.5 * WIDTH)).atan().to_degrees();
    let reason = "V-39: 45°, Prandtl's 45° + φ/2; it names no tolerance: one spacing over half the width";
    outcome.assert_within(name, &exact.to_string(), angle, (exact - room, exact + room), reason);
}
