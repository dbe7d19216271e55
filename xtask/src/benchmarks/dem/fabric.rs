//! Directions of contacts and force chains at the peak of a biaxial test (sheet: dem §3.9, B14).

use colluvium::case::{Dataset, DatasetGeometry, FrameRequest, Solver};
use colluvium::dem::DemSolver;
use colluvium::plots::{ContactRose, ForceChains};
use serde_json::json;

use crate::benchmarks::dem::case_builders::{load, output_value, parse_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of the contact directions and force chains of dense disks at the peak of a biaxial test.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/fabric",
    title: "Contacts of dense disks at the peak of a biaxial test, DEM",
    source: "sheet: dem §3.9, B14",
    short_seconds: None,
    full_seconds: 40,
    run: |_| run(),
};

/// Strain rate of the stage of shear.
const RATE: f64 = 3e-4;

/// Vertical strain at the peak.
const PEAK: f64 = 0.014;

/// Number of sectors of the rose diagram.
const SECTORS: usize = 18;

/// Solver of the biaxial test at the peak strength.
fn peak() -> Result<DemSolver<2, 1>, String> {
    let mut value = load("biaxial")?;
    value["stages"][2]["duration"] = json!(PEAK / RATE);
    value["output"]["contacts"] = json!(true);
    let case = parse_case(&value)?;
    let failed = |error: colluvium::case::SolverError| error.to_string();
    let mut solver = colluvium::dem::disks(&case).map_err(|error| error.to_string())?;
    let mut end = 0.0;
    for (number, stage) in case.stages.iter().enumerate() {
        solver.begin_stage(number, end).map_err(failed)?;
        end += stage.duration;
        while solver.time() < end {
            solver.step(end - solver.time()).map_err(failed)?;
        }
        solver.end_stage(stage).map_err(failed)?;
    }
    Ok(solver)
}

/// Picture of the grains and their normal contact forces.
fn chains(solver: &DemSolver<2, 1>) -> ForceChains {
    let snapshot = solver.snapshot();
    let flat = |x: &[f64; 3]| [x[0], x[1]];
    let grains = snapshot.positions.iter().zip(&snapshot.extents).map(|(x, e)| (flat(x), 0.5 * e[0]));
    let frame = solver.frame(FrameRequest::Requested);
    let ends: Vec<Vec<[f64; 3]>> = match frame.dataset(Dataset::CONTACTS).map(|dataset| &dataset.geometry) {
        Some(DatasetGeometry::Mesh(lines)) => lines.cells().collect(),
        _ => Vec::new(),
    };
    let forces = solver.contacts().into_iter().map(|contact| contact.normal);
    ForceChains {
        title: "Normal forces at the peak; dark: above the mean".to_owned(),
        grains: grains.collect(),
        lines: ends.iter().map(|line| [flat(&line[0]), flat(&line[1])]).zip(forces).collect(),
        axes: ["x (m)".to_owned(), "y (m)".to_owned()],
        ..ForceChains::default()
    }
}

/// Checks the anisotropy of contact directions, the coordination number and the share of weak contacts at the peak.
fn run() -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let solver = peak()?;
    let fabric = solver.fabric().ok_or("no grains touch")?;
    let anisotropy = 4.0 * (fabric.tensor[1][1] - 0.5);
    outcome.assert_within(
        "B14, dense: 4 (G₁₁ - ½) at a strain of 0.014",
        "0.33",
        anisotropy,
        (0.25, 0.41),
        "the sheet's rows around it scatter by 0.08",
    );
    outcome.assert_within(
        "B14, dense: contacts of a grain at a strain of 0.014",
        "3.29",
        fabric.coordination,
        (3.13, 3.45),
        "the sheet's rows around it differ by 0.16",
    );
    outcome.assert_within(
        "share of the contacts below the mean force",
        "about 0.6",
        fabric.weak_fraction,
        (0.52, 0.68),
        "Radjai et al. 1998, as of memory in the sheet",
    );
    let reason = "not judged: the sheet gives no value at the peak";
    outcome.info("grains that bear nothing", "-", fabric.rattlers, reason);
    outcome.info("contacts of a grain that carries a force", "-", fabric.mechanical_coordination, reason);
    let row = output_value(&solver, "fabric.yy");
    outcome.assert_close(
        "column fabric.yy of the measures",
        fabric.tensor[1][1],
        1e-12,
        row,
        "the same number",
    );
    outcome.png("Chains of forces at the peak.", &chains(&solver))?;
    let even = 1.0 / SECTORS as f64;
    let angle = |k: usize| std::f64::consts::PI * (k as f64 + 0.5) / 72.0;
    // 1 + F:n⊗n with F = 4 (G - ½).
    let first_order = |a: f64| {
        let (n, g) = ([a.cos(), a.sin()], &fabric.tensor);
        let mut sum = 1.0;
        for i in 0..2 {
            for j in 0..2 {
                sum += 4.0 * (g[i][j] - if i == j { 0.5 } else { 0.0 }) * n[i] * n[j];
            }
        }
        even * sum
    };
    let rose = ContactRose {
        title: "Directions of contacts at the peak; line: by the fabric tensor".to_owned(),
        sector_shares: solver.contact_rose(SECTORS),
        line: (0..72).map(|k| first_order(angle(k))).collect(),
    };
    outcome.png("Rose of contacts at the peak.", &rose)?;
    Ok(outcome)
}
