//! The column of aluminium bars, set S1 (sheet: sph §5.4), by MPM, SPH and depth-integrated flow.

use colluvium::case::description::Side;
use colluvium::case::measure::{front, profile};
use colluvium::plots::{Series, Style};

use super::chart;
use crate::benchmarks::{Benchmark, Outcome, case, run_by, scalars};

/// The benchmark.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "compare/aluminium-bars",
    title: "Column of aluminium bars: MPM, SPH and depth-integrated flow",
    source: "sheet: sph §5.4, set S1; Bui et al. 2008",
    quick: Some(40),
    full: 40,
    run: benchmark,
};

fn benchmark(_quick: bool) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let case = case("compare/aluminium-bars")?;
    let mut surfaces = chart("Column of 0.2 m × 0.1 m after 0.8 s", "x (m)", "height (m)");
    let mut found = Vec::new();
    for method in ["mpm", "sph", "depth-sph"] {
        let snapshot = run_by(method, &case)?.snapshot;
        let mass = scalars(&snapshot, "mass");
        let moment: f64 = mass.iter().zip(&snapshot.positions).map(|(m, x)| m * x[0]).sum();
        let centroid = moment / mass.iter().sum::<f64>();
        found.push((
            method,
            centroid,
            front(&snapshot, Side::XMax, 0.9),
            front(&snapshot, Side::XMax, 0.995),
        ));
        if method != "depth-sph" {
            surfaces.series.push(Series::new(method, profile(&snapshot, 0, 1, 0.01), Style::Line));
        }
    }
    let [mpm, sph, flow] = found[..] else { return Err("three methods".into()) };
    outcome.near(
        "sph: 99.5 % of the mass within (m)",
        0.404,
        0.05,
        sph.3,
        "sheet: sph §5.4, S1: 0.404 ± 0.02",
    );
    let reason =
        "5 %: the bulk of the deposit; the toe is as long as the dissipation of the method lets it be";
    outcome.near("mpm: centroid against that of sph (m)", sph.1, 0.05, mpm.1, reason);
    let reason = "10 %, as the toe counts for a tenth";
    outcome.near("mpm: 90 % of the mass within, against sph (m)", sph.2, 0.1, mpm.2, reason);
    for (what, value, other) in [
        ("centroid", flow.1, sph.1),
        ("90 % of the mass within", flow.2, sph.2),
        ("99.5 % within", flow.3, sph.3),
    ] {
        outcome.show(
            format!("depth-sph: {what} (m)"),
            &format!("{other:.4} (sph)"),
            value,
            "not judged: a column as high as half its width is outside of shallow flow; all of it slides on its floor, where \
             the others keep a core at rest",
        );
    }
    outcome.svg("Surfaces of the deposits.", &surfaces)?;
    Ok(outcome)
}
