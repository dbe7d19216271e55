//! Layer of sand that slides down a terrain raster in space: MPM, SPH, DEM and depth-integrated flow.

use colluvium::case::{Case, RunReport};
use colluvium::plots::{LineChart, Series, Style};

use super::MethodComparison;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, centre_of_mass, load_case, max_penetration, obstacle_energy_shares,
    run_in_memory,
};

/// Benchmark of a slide of sand on a terrain raster, computed by four methods.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "compare/slide",
    title: "Slide on a terrain raster: MPM, SPH, DEM and depth-integrated flow",
    source: "agreement of methods; a mass point on the slope",
    short_seconds: Some(60),
    full_seconds: 60,
    run: benchmark,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Angle of the upper slope (degrees).
const ANGLE: f64 = 32.0;
/// Friction coefficient of the terrain.
const FRICTION: f64 = 0.4;

/// Checks mass, energy and penetration of a slide by four methods, and compares the paths of its centre of mass.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let case = load_case("compare/slide")?;
    let mut picture = LineChart::new("Centre of mass of a slide on a raster", "time (s)", "x (m)");
    let (mut found, mut together) = (Vec::new(), MethodComparison::default());
    for method in ["mpm", "sph", "dem", "depth-sph"] {
        let report = run_in_memory(method, &case)?;
        outcome.assert_close(
            format!("{method}: mass at the end over that at the start"),
            1.0,
            1e-12,
            report.end.mass / report.start.mass,
            "exact",
        );
        let path: Vec<(f64, f64)> =
            report.frames.iter().map(|frame| (frame.time, centre_of_mass(frame)[0])).collect();
        picture.series.push(Series::new(method, path.clone(), Style::Line));
        above_ground(&mut outcome, method, &case, &report)?;
        if ["mpm", "sph"].contains(&method) {
            outcome.assert_below(
                format!("{method}: largest rise of the total energy over the work of gravity"),
                "none",
                obstacle_energy_shares(&report).max_rise,
                1e-3,
                "0.1 %: what springs and steps exchange",
            );
        }
        together.add_run(method, &report);
        found.push((method, path));
    }
    judge(&mut outcome, &found);
    let acceleration = GRAVITY * (ANGLE.to_radians().sin() - FRICTION * ANGLE.to_radians().cos());
    let start = found.first().and_then(|(_, path)| path.first()).map_or(f64::NAN, |first| first.1);
    let along = |t: f64| (t, start + 0.5 * acceleration * t * t * ANGLE.to_radians().cos());
    let point = (0..=20).map(|k| along(0.15 * f64::from(k))).collect();
    picture.series.push(Series::new("mass point on the upper slope", point, Style::Dashed));
    outcome.svg("The centre of mass in time.", &picture)?;
    together.write_sections(&mut outcome, &case, "compare/slide")?;
    Ok(outcome)
}

/// Checks that no centre of a point lies under the terrain in any frame.
fn above_ground(
    outcome: &mut BenchmarkOutcome,
    method: &str,
    case: &Case,
    report: &RunReport,
) -> Result<(), String> {
    outcome.assert_below(
        format!("{method}: largest depth of a point's centre under the terrain (m)"),
        "none",
        max_penetration(case, report)?,
        0.05,
        "a tenth of the distance of points",
    );
    Ok(())
}

/// Checks the agreement of the methods, which have equal friction and initial positions.
fn judge(outcome: &mut BenchmarkOutcome, found: &[(&str, Vec<(f64, f64)>)]) {
    let [mpm, sph, dem, flow] = found else { return };
    let displacement =
        |path: &[(f64, f64)]| path.last().map_or(f64::NAN, |p| p.1) - path.first().map_or(f64::NAN, |p| p.1);
    for (one, band, reason) in [
        (sph, 0.05, "5 %: the same law of the material and of the floor on points as far apart"),
        (flow, 0.1, "10 %: the same floor, and a mass that is thin against its length"),
        (dem, 0.2, "20 %: grains whose rolling on the floor the continua do not have"),
    ] {
        outcome.assert_close(
            format!("{}: way of the centre of mass in 6 s, against mpm (m)", one.0),
            displacement(&mpm.1),
            band,
            displacement(&one.1),
            reason,
        );
    }
}
