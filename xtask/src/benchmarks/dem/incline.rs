//! Layer of disks on a rough incline (sheet: dem §5, B12).

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, PointCloud, Series, Style};

use serde_json::json;

use crate::analysis::max_or_nan;
use crate::benchmarks::dem::case_builders::{load, method_options, parse_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, run_in_memory, scalars};

/// Benchmark of a layer of disks that flows down a rough incline.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/incline",
    title: "A layer of 500 disks flows down a rough incline of 20°, DEM",
    source: "sheet: dem §5, B12; Bagnold 1954",
    short_seconds: Some(40),
    full_seconds: 150,
    run: |quick| flow(if quick { SHORT_SETUP } else { FULL_SETUP }),
};

/// Parameters of the test on the incline.
#[derive(Clone, Copy)]
struct InclineSetup {
    /// Stiffness of contacts.
    stiffness: f64,
    /// Whether this is the set-up of the sheet, with the sheet's results as reference.
    of_sheet: bool,
}

/// Parameters of the sheet, with 3.6 million steps.
const FULL_SETUP: InclineSetup = InclineSetup { stiffness: 2e5, of_sheet: true };
/// Parameters of the short form, with a twentieth of the stiffness: 800 thousand steps, overlaps of 0.2 % of the diameter at the base. With
/// 1 % the solid fraction grows with the depth by more than the sheet allows.
const SHORT_SETUP: InclineSetup = InclineSetup { stiffness: 1e4, of_sheet: false };

/// Angle of the incline (degrees).
const ANGLE: f64 = 20.0;
/// Results of the sheet's code: inertial number of the layer, solid fraction.
const SHEET: [f64; 2] = [0.092, 0.779];
/// Mean mass of a disk, with gravity and mean diameter one.
const MASS: f64 = 1.013;
/// Density of the grains times the thickness, with gravity and mean diameter one.
const DENSITY: f64 = 4.0 / std::f64::consts::PI;
/// Width of the layer (mean diameters).
const WIDTH: f64 = 25.0;
/// Duration of the flow, over `√(d/g)`.
const FLOW: f64 = 400.0;
/// Share of the flow at its end over which results are averaged.
const LAST: f64 = 0.4;

/// Mean velocity and area of grains in a bin one diameter high.
#[derive(Clone, Copy, Debug, Default)]
struct VelocityBin {
    area: f64,
    velocity: f64,
}

/// Velocity along the incline and area of grains over height, from frames of the last part of the run, and the thickness of the layer:
/// twice the mean height of the grains.
fn profile(report: &RunReport) -> (Vec<VelocityBin>, f64) {
    let end = report.frames.last().map_or(0.0, |frame| frame.time);
    let start = end - LAST * FLOW;
    let mut layers = vec![VelocityBin::default(); 40];
    let (mut frames, mut mass, mut moment) = (0.0, 0.0, 0.0);
    for frame in report.frames.iter().filter(|frame| frame.time > start) {
        frames += 1.0;
        let (areas, velocity) = (scalars(frame, "volume"), frame.vectors("velocity").unwrap_or_default());
        for i in (0..areas.len()).filter(|&i| frame.bodies[i] == 0) {
            let height = frame.positions[i][1];
            mass += areas[i];
            moment += areas[i] * height;
            if let Some(layer) = layers.get_mut(height.max(0.0) as usize) {
                layer.area += areas[i];
                layer.velocity += areas[i] * velocity[i][0];
            }
        }
    }
    for layer in &mut layers {
        layer.velocity /= layer.area;
        layer.area /= frames * WIDTH;
    }
    (layers, 2.0 * moment / mass)
}

/// Intercept, slope and `R²` of a regression line.
fn line(points: &[(f64, f64)]) -> [f64; 3] {
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>();
    let slope = sum(&|p| (p.0 - x) * (p.1 - y)) / sum(&|p| (p.0 - x).powi(2));
    let off = sum(&|p| (p.1 - y - slope * (p.0 - x)).powi(2));
    [y - slope * x, slope, 1.0 - off / sum(&|p| (p.1 - y).powi(2))]
}

/// Runs the case with the parameters `form`.
fn run(form: InclineSetup) -> Result<RunReport, String> {
    let mut value = load("incline")?;
    for pair in 0..3 {
        method_options(&mut value)["pairs"][pair]["normal"]["stiffness"] = json!(form.stiffness);
    }
    run_in_memory("dem", &parse_case(&value)?)
}

/// Checks the velocity profile and the inertial number of a layer of disks on an incline of 20°.
fn flow(form: InclineSetup) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let report = run(form)?;
    let (layers, height) = profile(&report);
    let bagnold = |z: f64| height.powf(1.5) - (height - z).max(0.0).powf(1.5);
    let inner: Vec<(f64, &VelocityBin)> = (2..layers.len())
        .map(|k| (k as f64 + 0.5, &layers[k]))
        .filter(|(z, _)| *z > 2.4 && *z < height - 2.4)
        .collect();
    let points: Vec<(f64, f64)> = inner.iter().map(|(z, own)| (bagnold(*z), own.velocity)).collect();
    let [slip, slope, fit] = line(&points);
    let solid = inner.iter().map(|(_, own)| own.area).sum::<f64>() / inner.len() as f64;
    let cosine = ANGLE.to_radians().cos();
    let number = 1.5 * slope / (solid * DENSITY * cosine / MASS).sqrt();
    outcome.assert_within(
        "R² of the velocities against Bagnold's profile, 2.4 diameters from base and surface",
        "above 0.98",
        fit,
        (0.98, 1.0),
        "B12",
    );
    if form.of_sheet {
        outcome.assert_close(
            "inertial number of the plane",
            SHEET[0],
            0.15,
            number,
            "B12: ± 15 % of the same set-up",
        );
    } else {
        let reason = "not judged: softer than the sheet's";
        outcome.info("inertial number of the plane", "0.092", number, reason);
    }
    let areas: Vec<f64> = inner.iter().map(|(_, own)| own.area).collect();
    of_plane_shear(&mut outcome, number, solid, &areas);
    outcome.info(
        "slip at the base over √(g d)",
        "1.3 (sheet's code)",
        slip,
        "not judged: B12 gives no bound",
    );
    draw(&mut outcome, &report, (&layers, height), &|z| slip + slope * bagnold(z))?;
    Ok(outcome)
}

/// Checks inertial number and solid fraction against the laws of plane shear, and that the layers are uniform.
fn of_plane_shear(outcome: &mut BenchmarkOutcome, number: f64, solid: f64, layers: &[f64]) {
    let law = 0.27 + 1.15 * number;
    outcome.assert_below(
        "difference of tan θ from the friction of plane shear at this inertial number",
        "the same law",
        (ANGLE.to_radians().tan() - law).abs(),
        0.04,
        "B12",
    );
    let spread = layers.iter().map(|area| (area - solid).abs()).fold(0.0, max_or_nan);
    outcome.assert_below(
        "largest difference of the solid fraction of a layer from the mean",
        "uniform",
        spread,
        0.02,
        "B12",
    );
    outcome.assert_below(
        "difference of the solid fraction from that of plane shear at this inertial number",
        "the same law",
        (solid - (0.813 - 0.31 * number)).abs(),
        0.006,
        "B11: ± 0.006",
    );
    let reason = "not judged: B12 gives no bound";
    let claim = format!("{} (sheet's code)", SHEET[1]);
    outcome.info("solid fraction", &claim, solid, reason);
}

/// Draws the velocity profile with the fitted profile of Bagnold.
fn draw(
    outcome: &mut BenchmarkOutcome,
    report: &RunReport,
    (layers, height): (&[VelocityBin], f64),
    fitted: &dyn Fn(f64) -> f64,
) -> Result<(), String> {
    let mut picture = LineChart::new(
        "Velocity down a rough incline of 20°",
        "height over diameter",
        "velocity over √(g d)",
    );
    let found = layers.iter().enumerate().filter(|(k, _)| (*k as f64) < height);
    picture.series.push(Series::new(
        "DEM",
        found.map(|(k, own)| (k as f64 + 0.5, own.velocity)).collect(),
        Style::Markers,
    ));
    let curve = (0..=60).map(|k| height * f64::from(k) / 60.0).map(|z| (z, fitted(z)));
    picture.series.push(Series::new("Bagnold", curve.collect(), Style::Line));
    outcome.svg("B12.", &picture)?;
    if let Some(cloud) = PointCloud::from_snapshot(&report.snapshot, "velocity", [0, 1]) {
        outcome.png("Speed at the end.", &cloud)?;
    }
    Ok(())
}
