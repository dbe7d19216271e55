//! Biaxial tests, dense and loose (sheet: dem §5, B14).

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::analysis::mean_and_deviation;
use crate::benchmarks::dem::case_builders::{load, method_options, parse_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, run_in_memory};

/// Benchmark of a biaxial test of dense disks up to the peak strength.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/biaxial",
    title: "Biaxial test of dense disks to the peak, DEM",
    source: "sheet: dem §5, B14",
    short_seconds: None,
    full_seconds: 130,
    run: |_| peak(),
};

/// Benchmark of biaxial tests of dense and loose disks up to the critical state.
pub const CRITICAL: Benchmark = Benchmark {
    id: "dem/biaxial-critical",
    title: "Biaxial tests of dense and loose disks to critical state, DEM",
    source: "sheet: dem §5, B14",
    short_seconds: None,
    full_seconds: 340,
    run: |_| critical(),
};

/// Seeds of the dense packings, whose mean peak is judged.
const SEEDS: [u32; 4] = [0, 1, 2, 3];

/// Strain rate of the stage of shear.
const RATE: f64 = 3e-4;

/// Results of the dense specimen of the sheet: strain, ratio of stresses, volumetric strain.
const DENSE: [(f64, f64, f64); 12] = [
    (0.0, 1.0, 0.0),
    (0.002, 1.80, -0.0014),
    (0.004, 2.33, -0.0018),
    (0.008, 2.51, -0.0003),
    (0.014, 2.53, 0.0036),
    (0.02, 2.33, 0.0079),
    (0.04, 2.21, 0.0184),
    (0.06, 1.99, 0.0268),
    (0.08, 1.89, 0.0316),
    (0.10, 1.69, 0.0332),
    (0.14, 1.73, 0.0351),
    (0.18, 1.80, 0.0338),
];

/// Results of the loose specimen of the sheet: strain, ratio of stresses, volumetric strain.
const LOOSE_SPECIMEN: [(f64, f64, f64); 10] = [
    (0.002, 1.24, -0.0011),
    (0.004, 1.37, -0.0013),
    (0.008, 1.51, -0.0018),
    (0.02, 1.61, -0.0051),
    (0.04, 1.60, -0.0072),
    (0.08, 1.66, -0.0107),
    (0.12, 1.74, -0.0087),
    (0.16, 1.60, -0.0099),
    (0.20, 1.55, -0.0109),
    (0.24, 1.74, -0.0126),
];

/// Biaxial test: ratio of stresses, volumetric strain and solid fraction over logarithmic strain.
struct BiaxialTest {
    ratio: Vec<(f64, f64)>,
    volume: Vec<(f64, f64)>,
    solid_fraction: Vec<(f64, f64)>,
    contacts: f64,
    error: f64,
}

impl BiaxialTest {
    /// Runs a test to an axial strain; `preparation` is the friction coefficient with which the specimen is compacted.
    fn run(preparation: f64, strain: f64, seed: u32) -> Result<Self, String> {
        let mut value = load("biaxial")?;
        // Several windows of the means.
        value["output"]["measures"] = json!(0.1);
        method_options(&mut value)["seed"] = json!(seed);
        value["stages"][2]["duration"] = json!(strain / RATE);
        method_options(&mut value)["stages"]["prepare"]["pairs"][0]["friction"]["coefficient"] =
            json!(preparation);
        let start = 330.0;
        Ok(Self::from_report(&run_in_memory("dem", &parse_case(&value)?)?, start))
    }

    /// Curves of a run over the axial strain since `start` (s).
    fn from_report(report: &RunReport, start: f64) -> Self {
        let all = |name: &str| {
            measure_series(report, name).into_iter().filter(|(t, _)| *t > start - 0.05).collect::<Vec<_>>()
        };
        let (height, width) = (all("cell.y"), all("cell.x"));
        let strain = |k: usize| -(height[k].1 / height[0].1).ln();
        let by = |values: Vec<f64>| {
            values.into_iter().enumerate().map(|(k, v)| (strain(k), v)).collect::<Vec<_>>()
        };
        let mean = |name: &str| smooth(&by(all(name).into_iter().map(|(_, stress)| stress).collect()));
        let (down, side) = (mean("cell_stress.yy"), mean("cell_stress.xx"));
        let volume = (0..height.len()).map(|k| (height[k].1 * width[k].1 / height[0].1 / width[0].1).ln());
        let contacts = all("coordination");
        Self {
            ratio: down.iter().zip(&side).map(|(a, b)| (a.0, a.1 / b.1)).collect(),
            volume: by(volume.collect()),
            solid_fraction: by(all("solid_fraction").into_iter().map(|(_, v)| v).collect()),
            contacts: contacts.first().map_or(f64::NAN, |(_, z)| *z),
            error: measure_series(report, "energy_error").last().map_or(f64::NAN, |(_, error)| *error),
        }
    }

    /// Friction angle at the peak (degrees), and the strain there.
    fn peak(&self) -> (f64, f64) {
        let (strain, ratio) = self
            .ratio
            .iter()
            .copied()
            .fold((f64::NAN, 0.0), |largest, now| if now.1 > largest.1 { now } else { largest });
        (angle(ratio), strain)
    }

    /// Mean of a curve over strains beyond 15 %, where the state is critical.
    fn critical(curve: &[(f64, f64)]) -> f64 {
        let last: Vec<f64> =
            curve.iter().filter(|(strain, _)| *strain >= 0.15).map(|(_, value)| *value).collect();
        last.iter().sum::<f64>() / last.len() as f64
    }
}

/// Mobilised friction angle for a ratio of stresses (degrees).
fn angle(ratio: f64) -> f64 {
    ((ratio - 1.0) / (ratio + 1.0)).asin().to_degrees()
}

/// Curve averaged over windows of strain of 5e-4 (sheet: dem §3.11).
fn smooth(curve: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mean = |&(at, _): &(f64, f64)| {
        let near: Vec<f64> =
            curve.iter().filter(|(x, _)| (x - at).abs() <= 2.5e-4).map(|(_, y)| *y).collect();
        (at, near.iter().sum::<f64>() / near.len() as f64)
    };
    curve.iter().map(mean).collect()
}

/// Checks the friction angle of dense packings at the peak.
fn dense(outcome: &mut BenchmarkOutcome, tests: &[&BiaxialTest]) {
    let test = tests[0];
    let of = |pick: fn((f64, f64)) -> f64| {
        mean_and_deviation(&tests.iter().map(|own| pick(own.peak())).collect::<Vec<_>>())
    };
    let ((peak, spread), (strain, _)) = (of(|peak| peak.0), of(|peak| peak.1));
    let name = "B14, dense: friction angle at the peak, mean of the packings (°)";
    outcome.assert_within(name, "25.9", peak, (23.9, 27.9), "B14: ± 2°");
    let reason = "not judged: the sheet gives no bounds";
    outcome.info("B14, dense: standard deviation of that angle (°)", "", spread, reason);
    outcome.info("B14, dense: strain at the peak, mean of the packings", "0.015", strain, reason);
    outcome.info("B14, dense: solid fraction before shear", "0.8428", test.solid_fraction[0].1, reason);
    outcome.info("B14, dense: contacts of a grain before shear", "4.04", test.contacts, reason);
    let smallest = test.volume.iter().map(|(_, v)| *v).fold(0.0, f64::min);
    outcome.assert_within(
        "B14, dense: largest contraction",
        "-0.0018",
        smallest,
        (-0.01, -1e-4),
        "B14: contraction, then dilation",
    );
    let last = test.volume.last().map_or(f64::NAN, |(_, v)| *v);
    outcome.assert_within(
        "B14, dense: volumetric strain at the end",
        "dilation",
        last,
        (0.005, 0.1),
        "B14: contraction, then dilation",
    );
    outcome.assert_below(
        "B14, dense: error of the energy balance over input",
        "0",
        test.error.abs(),
        0.01,
        "§2.14: 1 %",
    );
}

/// Biaxial test with its label and with the results of the sheet.
type LabelledTest<'a> = (&'a str, &'a BiaxialTest, &'a [(f64, f64, f64)]);

/// Draws stress ratio and volumetric strain over axial strain.
fn draw(outcome: &mut BenchmarkOutcome, tests: &[LabelledTest]) -> Result<(), String> {
    let mut stress = LineChart::new("Biaxial test of disks", "vertical strain", "ratio of stresses");
    let mut volume =
        LineChart::new("Biaxial test of disks", "vertical strain", "volumetric strain, dilation positive");
    for (name, test, sheet) in tests {
        let end = test.ratio.last().map_or(0.0, |last| last.0 + 1e-3);
        let shown = || sheet.iter().filter(|row| row.0 <= end);
        stress.series.push(Series::new(*name, test.ratio.clone(), Style::Line));
        let points = shown().map(|row| (row.0, row.1)).collect();
        stress.series.push(Series::new(format!("{name}, sheet's code"), points, Style::Markers));
        volume.series.push(Series::new(*name, test.volume.clone(), Style::Line));
        let points = shown().map(|row| (row.0, row.2)).collect();
        volume.series.push(Series::new(format!("{name}, sheet's code"), points, Style::Markers));
    }
    outcome.svg("B14: stress.", &stress)?;
    outcome.svg("B14: volume.", &volume)
}

/// Checks the peak strength of dense packings of disks.
fn peak() -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let tests = SEEDS.map(|seed| BiaxialTest::run(0.0, 0.03, seed));
    let tests = tests.into_iter().collect::<Result<Vec<_>, _>>()?;
    dense(&mut outcome, &tests.iter().collect::<Vec<_>>());
    draw(&mut outcome, &[("dense", &tests[0], &DENSE)])?;
    Ok(outcome)
}

/// Checks the critical state of a dense and of a loose packing of disks.
fn critical() -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let (firm, loose) = (BiaxialTest::run(0.0, 0.24, SEEDS[0])?, BiaxialTest::run(1.0, 0.24, SEEDS[0])?);
    let others = SEEDS[1..].iter().map(|seed| BiaxialTest::run(0.0, 0.03, *seed));
    let others = others.collect::<Result<Vec<_>, _>>()?;
    dense(&mut outcome, &std::iter::once(&firm).chain(&others).collect::<Vec<_>>());
    let reason = "not judged: the sheet gives no bounds";
    outcome.info("B14, loose: solid fraction before shear", "0.804", loose.solid_fraction[0].1, reason);
    outcome.info(
        "B14, loose: largest friction angle (°)",
        "no peak; 18.4 by fluctuation",
        loose.peak().0,
        reason,
    );
    let contraction = loose.volume.last().map_or(f64::NAN, |(_, v)| *v);
    outcome.assert_within(
        "B14, loose: volumetric strain at the end",
        "contraction",
        contraction,
        (-0.05, 0.0),
        "B14: contracts",
    );
    for (name, test, exact) in [("dense", &firm, 15.2), ("loose", &loose, 14.5)] {
        let found = angle(BiaxialTest::critical(&test.ratio));
        let claim = format!("{exact}");
        outcome.assert_within(
            format!("B14, {name}: critical friction angle (°)"),
            &claim,
            found,
            (exact - 2.5, exact + 2.5),
            "B14: ± 2.5°",
        );
        let solid = BiaxialTest::critical(&test.solid_fraction);
        outcome.assert_within(
            format!("B14, {name}: critical solid fraction"),
            "0.814",
            solid,
            (0.806, 0.822),
            "B14: ± 0.008",
        );
    }
    let apart = angle(BiaxialTest::critical(&firm.ratio)) - angle(BiaxialTest::critical(&loose.ratio));
    outcome.assert_within(
        "B14, critical angle, dense less loose (°)",
        "0",
        apart,
        (-2.5, 2.5),
        "B14: the same within 2.5°",
    );
    let apart = BiaxialTest::critical(&firm.solid_fraction) - BiaxialTest::critical(&loose.solid_fraction);
    outcome.assert_within(
        "B14, critical solid fraction, dense less loose",
        "0",
        apart,
        (-0.008, 0.008),
        "B14: the same within 0.008",
    );
    draw(&mut outcome, &[("dense", &firm, &DENSE), ("loose", &loose, &LOOSE_SPECIMEN)])?;
    Ok(outcome)
}
