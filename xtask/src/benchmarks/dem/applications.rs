//! Landslides, bonded slopes, dilatant shear (sheet: dem §5, B15).

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use serde_json::json;

use crate::benchmarks::dem::case_builders::{load, method_options, parse_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, run_in_memory, vectors};

/// Benchmark of a block on a slope, a bonded cliff and dilatant shear.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/applications",
    title: "A block on a slope, a bonded cliff, dilatant shear, DEM",
    source: "sheet: dem §5, B15; Kumar 2015, §3.4",
    short_seconds: Some(60),
    full_seconds: 60,
    run: |_| run_applications(),
};

/// Checks a block on a slope, a bonded cliff and dilatant shear.
fn run_applications() -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    slide(&mut outcome)?;
    cliff(&mut outcome)?;
    dilate(&mut outcome)?;
    Ok(outcome)
}

/// Last value of a measure.
fn last(report: &RunReport, name: &str) -> f64 {
    report.table.last(name).unwrap_or(f64::NAN)
}

/// Checks the velocity of a block that cannot roll: `v = √(2 g s (sin β - μ cos β))`, 50 m/s after 1322 m.
fn slide(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let report = run_in_memory("dem", &parse_case(&load("block")?)?)?;
    let mean = |name: &str| {
        let all = vectors(&report.snapshot, name);
        all.iter().map(|own| own[0]).sum::<f64>() / all.len() as f64
    };
    let (displacement, speed) = (mean("displacement"), mean("velocity"));
    outcome.assert_close(
        "block on 14°, μ = 0.15: way after which it has 50 m/s (m)",
        1322.0,
        0.005,
        displacement * (50.0 / speed).powi(2),
        "B15: closed form; ± 0.5 %, as it begins above its overlap at rest",
    );
    outcome.assert_below(
        "block: bonds that broke",
        "0",
        last(&report, "broken_bonds"),
        0.5,
        "they have no strength to exceed",
    );
    Ok(())
}

/// Checks that a cliff is stable with strong bonds, and breaks and runs out with weak ones.
fn cliff(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let run = |strength: f64| -> Result<RunReport, String> {
        let mut value = load("cliff")?;
        let bond = &mut method_options(&mut value)["pairs"][0]["bond"];
        (bond["tensile_strength"], bond["cohesion"]) = (json!(strength), json!(strength));
        run_in_memory("dem", &parse_case(&value)?)
    };
    let front = |report: &RunReport| {
        let snapshot = &report.snapshot;
        let rock = snapshot.positions.iter().zip(&snapshot.bodies).filter(|(_, body)| **body == 0);
        rock.map(|(x, _)| x[0]).fold(0.0, f64::max)
    };
    let (strong, weak) = (run(1000.0)?, run(0.3)?);
    let reason = "B15: a feature test";
    outcome.assert_below(
        "bonded cliff, strength 83 ρ g h: bonds that broke",
        "0",
        last(&strong, "broken_bonds"),
        0.5,
        reason,
    );
    outcome.assert_below(
        "the same: way of the front (diameters)",
        "it stands",
        (front(&strong) - 20.0).abs(),
        0.7,
        reason,
    );
    let broken = last(&weak, "broken_bonds");
    outcome.assert_within(
        "bonded cliff, strength 0.03 ρ g h: bonds that broke",
        "some",
        broken,
        (20.0, 1e4),
        reason,
    );
    outcome.assert_within(
        "the same: way of the front (diameters)",
        "it runs out",
        front(&weak) - 20.0,
        (3.0, 100.0),
        reason,
    );
    let error = [&strong, &weak].map(|report| last(report, "energy_error").abs());
    outcome.assert_below(
        "cliffs: error of the energy balance over input",
        "0",
        error[0].max(error[1]),
        0.01,
        "§2.14: 1 %",
    );
    if let Some(cloud) = PointCloud::from_snapshot(&weak.snapshot, "velocity", [0, 1]) {
        outcome.png("A cliff whose bonds are weak, at the end.", &cloud)?;
    }
    Ok(())
}

/// Checks that the void ratio of a dense packing rises in shear to that of the critical state.
fn dilate(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut value = load("biaxial")?;
    let side = 20.0;
    value["domain"]["max"] = json!([side, side]);
    value["bodies"][0]["shape"]["max"] = json!([side, side]);
    for (stage, duration) in [150, 30, 100].into_iter().enumerate() {
        value["stages"][stage]["duration"] = json!(duration);
    }
    method_options(&mut value)["stages"]["shear"] =
        json!({ "cell": { "xy": { "rate": 0.005 }, "yy": { "stress": -1 } } });
    let report = run_in_memory("dem", &parse_case(&value)?)?;
    let voids: Vec<(f64, f64)> = measure_series(&report, "solid_fraction")
        .into_iter()
        .filter(|(time, _)| *time >= 180.0 - 1e-6)
        .map(|(time, solid)| (0.005 * (time - 180.0), 1.0 / solid - 1.0))
        .collect();
    let [first, end] = [voids.first(), voids.last()].map(|at| at.map_or(f64::NAN, |at| at.1));
    let reason =
        "B15: the void ratio rises in shear; B11 and B14 have 0.187 dense and 0.229 at critical state";
    outcome.assert_within(
        "dilatant shear of dense disks to a strain of 0.5: rise of the void ratio",
        "0.04",
        end - first,
        (0.01, 0.08),
        reason,
    );
    let mut picture =
        LineChart::new("Shear of dense disks at constant pressure", "shear strain", "void ratio");
    picture.series.push(Series::new("DEM", voids, Style::Line));
    outcome.svg("B15: dilatant shear.", &picture)
}
