//! Flexible confining pressure: a disc and a triaxial specimen in a membrane (sheet: sph V-33, B-05).

use colluvium::case::Snapshot;
use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_in_memory, stresses, vectors};

/// Benchmark of confining pressure by a flexible membrane.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/membrane",
    title: "Flexible confining pressure, SPH",
    source: "Bui & Nguyen 2021, eqs. 123–129, Figs. 20, 21; sheet: sph V-33, B-05",
    short_seconds: None,
    full_seconds: 85,
    run,
};

/// Checks the stress of a disc under membrane pressure, and the strength of triaxial specimens.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    disc(&mut outcome)?;
    let mut chart = LineChart::new(
        "Triaxial compression in a membrane",
        "mean pressure (kPa)",
        "deviatoric stress (kPa)",
    );
    for pressure in [5e4, 1e5] {
        let path = triaxial(&mut outcome, pressure)?;
        chart.series.push(Series::new(format!("{} kPa", pressure / 1e3), path, Style::Line));
        let end = [(pressure / 1e3, 0.0), (5.0 / 3.0 * pressure / 1e3, 2.0 * pressure / 1e3)];
        chart.series.push(Series::new(
            format!("{} kPa, closed form", pressure / 1e3),
            end.to_vec(),
            Style::Dashed,
        ));
    }
    outcome
        .svg("Stress path of the middle third of the specimen up to Mohr and Coulomb's strength.", &chart)?;
    Ok(outcome)
}

/// Checks the stress of a disc under membrane pressure (V-33).
fn disc(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    /// Pressure on the disc (Pa).
    const PRESSURE: f64 = 1e4;
    let snapshot = run_in_memory("sph", &load_case("sph/confined-disc")?)?.snapshot;
    let moved = vectors(&snapshot, "displacement");
    let (mut stress, mut radial) = (0.0_f64, 0.0_f64);
    let rate = -PRESSURE * 1.25 * 0.5 / 1e6;
    for ((x, s), u) in snapshot.positions.iter().zip(stresses(&snapshot)).zip(&moved) {
        let start = [x[0] - u[0], x[1] - u[1]];
        let r = start[0].hypot(start[1]);
        if r > 0.35 {
            continue;
        }
        stress = stress
            .max((s.component(0, 0) / -PRESSURE - 1.0).abs())
            .max((s.component(1, 1) / -PRESSURE - 1.0).abs());
        if r > 0.1 {
            let along = (u[0] * start[0] + u[1] * start[1]) / r;
            radial = radial.max((along / (rate * r) - 1.0).abs());
        }
    }
    let reason = "V-33: 3 % in the interior";
    outcome.assert_below(
        "disc: largest error of σ_xx, σ_yy over the pressure, interior",
        "0",
        stress,
        0.03,
        reason,
    );
    outcome.assert_below(
        "disc: largest error of the radial displacement, interior",
        "0",
        radial,
        0.03,
        reason,
    );
    Ok(())
}

/// Mean deviatoric stress, mean pressure and lateral stress of the middle third of the specimen (Pa).
fn middle_stresses(snapshot: &Snapshot) -> [f64; 3] {
    let inside =
        snapshot.positions.iter().zip(stresses(snapshot)).filter(|(x, _)| (x[2] - 0.05).abs() < 1.0 / 60.0);
    let (mut sums, mut count) = ([0.0; 3], 0.0);
    for (_, s) in inside {
        let lateral = -0.5 * (s.component(0, 0) + s.component(1, 1));
        let axial = -s.component(2, 2);
        for (sum, value) in sums.iter_mut().zip([axial - lateral, (axial + 2.0 * lateral) / 3.0, lateral]) {
            *sum += value;
        }
        count += 1.0;
    }
    sums.map(|sum| sum / count)
}

/// Checks triaxial compression in a membrane (B-05), and returns the stress path up to the peak (kPa).
fn triaxial(outcome: &mut BenchmarkOutcome, pressure: f64) -> Result<Vec<(f64, f64)>, String> {
    let mut case = load_case("sph/triaxial")?;
    for body in &mut case.bodies {
        body.stress = colluvium::case::description::InitialStress::Uniform {
            value: [-pressure, -pressure, -pressure, 0.0, 0.0, 0.0],
        };
    }
    if let Some(options) = case.methods.get_mut("sph") {
        options["confining"]["pressure"] = pressure.into();
    }
    case.stages[0].duration *= pressure / 5e4;
    let report = run_in_memory("sph", &case)?;
    let path: Vec<[f64; 3]> = report.frames.iter().map(middle_stresses).collect();
    let name = |what: &str| format!("{} kPa: {what}", pressure / 1e3);
    let peak = (0..path.len()).max_by(|&a, &b| path[a][0].total_cmp(&path[b][0])).unwrap_or(0);
    let reason = "B-05: σ1 = 3 σ3 for 30 degrees and no cohesion, ± 5 %";
    let strongest = path[peak][0] + path[peak][2];
    outcome.assert_close(
        name("largest axial stress over the pressure"),
        3.0,
        0.05,
        strongest / pressure,
        reason,
    );
    let reason = "B-05: q_peak is twice the pressure, ± 5 %";
    let deviatoric = path[peak][0] / pressure;
    outcome.assert_close(name("largest deviatoric stress over the pressure"), 2.0, 0.05, deviatoric, reason);
    // Up to half of the peak: the elastic path.
    let half = path.iter().position(|p| p[0] > 0.5 * path[peak][0]).unwrap_or(peak);
    let slope = (path[half][0] - path[0][0]) / (path[half][1] - path[0][1]);
    outcome.assert_close(name("slope of the stress path"), 3.0, 0.03, slope, "B-05: Δq/Δp = 3 ± 3 %");
    let before = path.iter().take_while(|p| p[0] < 0.95 * 2.0 * pressure);
    let drift = before.map(|p| (p[2] / pressure - 1.0).abs()).max_or_nan();
    outcome.assert_below(
        name("drift of the lateral stress before the peak"),
        "< 3 %",
        drift,
        0.03,
        "B-05: less than 3 %",
    );
    Ok(path.iter().map(|p| (p[1] / 1e3, p[0] / 1e3)).collect())
}
