//! Energy of a block that slides over the facets of a rough raster without friction, by MPM and SPH.

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, Series, Style};

use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_in_memory, set_mpm_option};

/// Benchmark of a frictionless block on a rough raster, computed by MPM and SPH.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/rough-slope",
    title: "A frictionless block on a rough raster, MPM and SPH",
    source: "conservation of energy",
    short_seconds: Some(10),
    full_seconds: 10,
    run: rough_slope,
};

/// Checks the energy that a frictionless block keeps on a rough slope.
fn rough_slope(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart::new(
        "Energy kept on a rough slope",
        "time (s)",
        "(kinetic + elastic) energy over the energy of the fall",
    );
    for (name, method, contact) in
        [("MPM, points", "mpm", "points"), ("MPM, nodes", "mpm", "nodes"), ("SPH", "sph", "")]
    {
        let mut case = load_case("mpm/rough-slope")?;
        if method == "mpm" {
            set_mpm_option(&mut case, "obstacles", contact);
        }
        let kept = energy_ratio(&run_in_memory(method, &case)?);
        let last = kept.last().map_or(f64::NAN, |row| row.1);
        outcome.assert_close(
            format!("{name}: energy after 6 s over that of the fall"),
            1.0,
            0.02,
            last,
            "2 %: the steps of the scheme and the edges of the facets, over a fall of 42 m",
        );
        chart.series.push(Series::new(name, kept, Style::Line));
    }
    outcome.svg("Energy of the block over that of its fall; its first second is left out.", &chart)?;
    Ok(outcome)
}

/// Gain of kinetic and elastic energy over loss of potential energy, over time (s), from the time of one second.
fn energy_ratio(report: &RunReport) -> Vec<(f64, f64)> {
    let column = |name: &str| report.table.pairs("time", name).unwrap_or_default();
    let (kinetic, elastic, potential) =
        (column("kinetic_energy"), column("elastic_energy"), column("potential_energy"));
    let gained = |rows: &[(f64, f64)], row: usize| rows[row].1 - rows[0].1;
    (0..kinetic.len().min(elastic.len()).min(potential.len()))
        .filter(|row| kinetic[*row].0 >= 1.0)
        .map(|row| {
            let share = (gained(&kinetic, row) + gained(&elastic, row)) / -gained(&potential, row);
            (kinetic[row].0, share)
        })
        .collect()
}
