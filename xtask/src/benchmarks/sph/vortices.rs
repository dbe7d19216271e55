//! Flow with vorticity (Taylor & Green 1937): a shear wave, and an array of vortices on an aligned and on a rotated lattice.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use colluvium::case::description::PointFile;
use colluvium::case::{Case, RunReport, Snapshot};
use colluvium::plots::{LineChart, PointCloud, Series, Style};

use super::waves::load;
use crate::benchmarks::sph::simple_shear::closest;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, run_in_memory, set_method_option, vectors};

/// Benchmark of the decay of a shear wave and of vortices.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/vortices",
    title: "Decay of a shear wave and of vortices, SPH",
    source: "Taylor & Green 1937",
    short_seconds: Some(4),
    full_seconds: 250,
    run: decay,
};

/// Kinematic viscosity of the waves and vortices (m²/s).
const VISCOSITY: f64 = 0.01;
/// Numbers of particles along the two sides of the cell of a lattice that is rotated by 29.9° and fits a periodic box. The number of
/// particles in the box is the sum of their squares.
const ROTATED_LATTICE_COUNTS: [i64; 2] = [87, 50];

/// Velocity of a flow mode of amplitude one at a position.
type FlowMode = fn(&[f64; 3]) -> [f64; 2];

/// Velocity of a shear wave (m/s).
fn wave(x: &[f64; 3]) -> [f64; 2] {
    [(TAU * x[1]).sin(), 0.0]
}

/// Velocity of a periodic array of vortices at a position (m/s).
fn array(x: &[f64; 3]) -> [f64; 2] {
    let (a, b) = ((TAU * x[0]).sin_cos(), (TAU * x[1]).sin_cos());
    [a.0 * b.1, -a.1 * b.0]
}

/// Amplitude of a flow mode in the velocities, and the share of the kinetic energy in other modes.
fn amplitude(snapshot: &Snapshot, mode: FlowMode) -> (f64, f64) {
    let (mut own, mut all, mut both) = (0.0, 0.0, 0.0);
    for (x, v) in snapshot.positions.iter().zip(vectors(snapshot, "velocity")) {
        let m = mode(x);
        own += m[0] * m[0] + m[1] * m[1];
        all += v[0] * v[0] + v[1] * v[1];
        both += m[0] * v[0] + m[1] * v[1];
    }
    (both / own, 1.0 - both * both / (own * all))
}

/// Checks the decay of a shear wave and of vortices against closed forms.
fn decay(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart::new("Decay of vortices", "time (s)", "kinetic energy over that at the start");
    let shear = run_in_memory("sph", &load("vortices/shear.json")?)?;
    let (found, off) = amplitude(&shear.snapshot, wave);
    let exact = (-VISCOSITY * TAU * TAU).exp();
    outcome.assert_close(
        "shear wave, amplitude after 1 s",
        exact,
        0.01,
        found,
        "1 % with 100 particles along the wave",
    );
    outcome.info(
        "shear wave, share of the energy off the mode",
        "0",
        off,
        "not judged: the wave bends no lattice much",
    );
    if quick {
        return Ok(outcome);
    }
    let case = load("vortices/array.json")?;
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let turned = rotated_lattice_case(case.clone(), folder.path())?;
    let runs = [("along the lattice", case), ("turned by 29.9° against the lattice", turned)];
    let exact = (-2.0 * VISCOSITY * TAU * TAU).exp();
    for (name, case) in runs {
        let report = run_in_memory("sph", &case)?;
        let (found, off) = amplitude(&report.snapshot, array);
        let close = closest(&report.snapshot, spacing(&case));
        let reason = "3 % with 100 particles along the box";
        outcome.assert_close(format!("vortices {name}, amplitude after 1 s"), exact, 0.03, found, reason);
        let reason = "2 %: the lattice breaks up, and vortices with it, unless particles are kept even";
        outcome.assert_below(
            format!("vortices {name}, share of the energy off the mode"),
            "0",
            off,
            0.02,
            reason,
        );
        let reason = "three quarters of the spacing: particles that come closer clump";
        outcome.assert_within(
            format!("vortices {name}, closest particles over the spacing"),
            "≥ 0.75",
            close,
            (0.75, f64::INFINITY),
            reason,
        );
        chart.series.push(Series::new(name, energies(&report), Style::Line));
        if let Some(cloud) = PointCloud::from_snapshot(&report.snapshot, "velocity", [0, 1]) {
            outcome.png(&format!("Speed after 1 s, {name}."), &cloud)?;
        }
    }
    without_options(&mut outcome, &mut chart)?;
    chart.series.push(Series::new("closed form", closed_form(), Style::Dashed));
    outcome.svg("Energy of the vortices.", &chart)?;
    Ok(outcome)
}

/// Checks the vortices with default options of liquids, by both methods that support them.
fn without_options(outcome: &mut BenchmarkOutcome, chart: &mut LineChart) -> Result<(), String> {
    let exact = (-4.0 * VISCOSITY * TAU * TAU).exp();
    for (method, options) in
        [("sph", serde_json::json!({ "spacing": 0.01 })), ("mpm", serde_json::json!({ "cell_size": 0.01 }))]
    {
        let mut case = load("vortices/array.json")?;
        case.methods = [(method.to_owned(), options)].into();
        let energies = energies(&run_in_memory(method, &case)?);
        let found = energies.last().map_or(f64::NAN, |row| row.1);
        let name =
            format!("vortices by {method} without options, kinetic energy after 1 s over that at the start");
        outcome.assert_close(name, exact, 0.1, found, "10 % with 100 points or cells along the box");
        chart.series.push(Series::new(format!("{method} without options"), energies, Style::Line));
    }
    Ok(())
}

/// Kinetic energy of the vortices over that at the start, over time (s).
fn closed_form() -> Vec<(f64, f64)> {
    let at = |t: f64| (t, (-4.0 * VISCOSITY * TAU * TAU * t).exp());
    (0..=50).map(|k| at(f64::from(k) / 50.0)).collect()
}

/// Spacing of the particles of a case (m).
fn spacing(case: &Case) -> f64 {
    case.methods
        .get("sph")
        .and_then(|sph| sph.get("spacing"))
        .and_then(serde_json::Value::as_f64)
        .unwrap_or(f64::NAN)
}

/// Kinetic energy over that at the start, over time (s).
fn energies(report: &RunReport) -> Vec<(f64, f64)> {
    let rows = report.table.pairs("time", "kinetic_energy").unwrap_or_default();
    let start = rows.first().map_or(1.0, |row| row.1);
    rows.into_iter().map(|(t, energy)| (t, energy / start)).collect()
}

/// Case of the vortices on a lattice that is rotated against their box.
fn rotated_lattice_case(mut case: Case, folder: &Path) -> Result<Case, String> {
    let [a, b] = ROTATED_LATTICE_COUNTS;
    let count = a * a + b * b;
    let mut text = "x,y\n".to_owned();
    for i in -(a + b)..=a + b {
        for j in -(a + b)..=a + b {
            let place = [a * i - b * j, b * i + a * j];
            if place.iter().all(|x| (0..count).contains(x)) {
                let [x, y] = place.map(|x| (x as f64 + 0.5) / count as f64);
                let _ = writeln!(text, "{x},{y}");
            }
        }
    }
    let file = folder.join("turned.csv");
    std::fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))?;
    let spacing = 1.0 / (count as f64).sqrt();
    case.bodies[0].points = Some(PointFile { file: file.display().to_string(), spacing: Some(spacing) });
    set_method_option(&mut case, "sph", "spacing", spacing);
    Ok(case)
}
