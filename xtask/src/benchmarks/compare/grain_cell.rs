//! Periodic cells of grains at a material point, and Mohr–Coulomb fitted to the mean of several packings, which must predict another test
//! of the same packings.

use colluvium::constitutive::driver::ElementTest;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::analysis::{max_or_nan, mean_and_deviation};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of periodic cells of grains as a material, and of Mohr–Coulomb fitted to them.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "compare/grain-cell",
    title: "Cells of grains in biaxial compression, and Mohr–Coulomb fitted to them",
    source: "a law fitted at 100 kPa against the same cells at 200 kPa",
    short_seconds: None,
    full_seconds: 240,
    run: benchmark,
};

/// Seeds of the packings of grains.
const SEEDS: [u32; 4] = [4, 5, 6, 7];

/// Biaxial test: rows of shortening along y, stresses along x and y (Pa), and volumetric strain.
struct BiaxialCurve(Vec<[f64; 4]>);

impl BiaxialCurve {
    /// Runs an element test, and takes strains and stresses from its path.
    fn from_test(test: &ElementTest) -> Result<Self, String> {
        let trace = test.trace().map_err(|error| error.to_string())?;
        if let Some(why) = trace.stop_reason {
            return Err(why.to_string());
        }
        let column = |name: &str| trace.path.column(name).ok_or_else(|| format!("no column {name}"));
        let [xx, yy] = [column("strain_xx")?, column("strain_yy")?];
        let [across, along] = [column("stress_xx")?, column("stress_yy")?];
        Ok(Self((0..xx.len()).map(|k| [-yy[k], across[k], along[k], xx[k] + yy[k]]).collect()))
    }

    /// Mean of the curves of several tests, which have the same steps.
    fn mean(all: &[Self]) -> Self {
        let rows = all.iter().map(|own| own.0.len()).min().unwrap_or(0);
        let entry =
            |row: usize, k: usize| all.iter().map(|own| own.0[row][k]).sum::<f64>() / all.len() as f64;
        Self((0..rows).map(|row| std::array::from_fn(|k| entry(row, k))).collect())
    }

    /// Largest ratio of the radius of Mohr's circle to its centre: the sine of the mobilised friction angle.
    fn strength(&self) -> f64 {
        let ratio = |[_, across, along, _]: &[f64; 4]| (across - along) / -(across + along);
        self.0.iter().map(ratio).fold(0.0, max_or_nan)
    }

    /// Largest difference of the stresses (Pa).
    fn peak(&self) -> f64 {
        self.0.iter().map(|[_, across, along, _]| across - along).fold(0.0, max_or_nan)
    }

    /// Increase of the volumetric strain from one shortening to another.
    fn dilation(&self, from: f64, to: f64) -> f64 {
        let at = |shortening: f64| {
            let row =
                self.0.iter().min_by(|a, b| (a[0] - shortening).abs().total_cmp(&(b[0] - shortening).abs()));
            row.map_or(f64::NAN, |row| row[3])
        };
        at(to) - at(from)
    }

    /// Difference of the stresses over the shortening, up to half of the peak (Pa).
    fn stiffness(&self) -> f64 {
        let half = 0.5 * self.peak();
        let reached = self.0.windows(2).find(|pair| pair[1][1] - pair[1][2] >= half);
        reached.map_or(f64::NAN, |pair| {
            let [a, b] = [0, 1].map(|k| (pair[k][0], pair[k][1] - pair[k][2]));
            half / (a.0 + (b.0 - a.0) * (half - a.1) / (b.1 - a.1))
        })
    }

    /// Stress difference over axial strain, as a series of a chart.
    fn series(&self, name: &str, style: Style) -> Series {
        Series::new(name, self.0.iter().map(|row| (row[0], row[1] - row[2])).collect(), style)
    }
}

/// Test at another pressure (Pa).
fn at_pressure(test: &ElementTest, pressure: f64) -> ElementTest {
    ElementTest { initial_stress: [-pressure, -pressure, -pressure, 0.0, 0.0, 0.0], ..test.clone() }
}

/// Biaxial test of the packing with a seed.
fn packing(file: &std::path::Path, seed: u32) -> Result<ElementTest, String> {
    let text = std::fs::read_to_string(file).map_err(|error| error.to_string())?;
    let mut value: serde_json::Value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    value["material"]["parameters"]["seed"] = json!(seed);
    serde_json::from_value(value).map_err(|error| error.to_string())
}

/// Means of the tests of all packings at both pressures.
fn grains(file: &std::path::Path, outcome: &mut BenchmarkOutcome) -> Result<[BiaxialCurve; 2], String> {
    let (mut low, mut high, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    for seed in SEEDS {
        let test = packing(file, seed)?;
        let (one, two) = (
            BiaxialCurve::from_test(&at_pressure(&test, 100e3))?,
            BiaxialCurve::from_test(&at_pressure(&test, 200e3))?,
        );
        let ratio = two.peak() / (2.0 * one.peak());
        outcome.info(
            format!("packing {seed}: peak at 200 kPa over twice that at 100 kPa"),
            "–",
            ratio,
            "not judged: one packing",
        );
        ratios.push(ratio);
        low.push(one);
        high.push(two);
    }
    let (_, spread) = mean_and_deviation(&ratios);
    let name = "standard deviation of it between packings";
    outcome.info(name, "–", spread, "not judged: four packings tell it to a half");
    Ok([BiaxialCurve::mean(&low), BiaxialCurve::mean(&high)])
}

/// Checks Mohr–Coulomb, fitted to packings of grains in one test, against another test of the same packings.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let file = crate::root().join("validation/compare/grain-cell/element.json");
    crate::benchmarks::recorder::record_file(&file);
    let test = colluvium::load_element_test(&file).map_err(|errors| errors.to_string())?;
    let [low, high] = grains(&file, &mut outcome)?;
    // Plane strain: the difference of the stresses grows with E / (1 - ν²); volume grows with 2 sin ψ / (1 - sin ψ) per shortening.
    let ratio: f64 = 0.2;
    let (from, to) = (0.02, 0.05);
    let rate = low.dilation(from, to) / (to - from);
    let law = json!({
        "model": "mohr-coulomb", "density": 2000, "poissons_ratio": ratio,
        "youngs_modulus": low.stiffness() * (1.0 - ratio * ratio),
        "friction_angle": low.strength().asin().to_degrees(),
        "dilatancy_angle": (rate / (2.0 + rate)).asin().to_degrees(),
    });
    for (name, unit) in [("youngs_modulus", "Pa"), ("friction_angle", "°"), ("dilatancy_angle", "°")] {
        let value = law[name].as_f64().unwrap_or(f64::NAN);
        outcome.info(
            format!("fitted at 100 kPa: {} ({unit})", name.replace('_', " ")),
            "–",
            value,
            "not judged: the fit",
        );
    }
    let material = serde_json::from_value(law).map_err(|error| error.to_string())?;
    let fitted = ElementTest { material, ..test };
    let (own, foretold) = (
        BiaxialCurve::from_test(&at_pressure(&fitted, 100e3))?,
        BiaxialCurve::from_test(&at_pressure(&fitted, 200e3))?,
    );
    let reason = "a strength that grows with the pressure alone; the scatter of the mean of four packings of 200 grains";
    let name = "at 200 kPa: largest difference of the stresses, law over grains";
    outcome.assert_within(name, "1", foretold.peak() / high.peak(), (0.93, 1.07), reason);
    let reason = "slope to half of the peak; springs are linear, contacts become more with pressure";
    let name = "at 200 kPa: stiffness, law over grains";
    outcome.assert_within(name, "1", foretold.stiffness() / high.stiffness(), (0.75, 1.25), reason);
    let name = "at 200 kPa: volume gained from 2 to 5 % of shortening, law over grains";
    let gained = foretold.dilation(from, to) / high.dilation(from, to);
    outcome.assert_within(
        name,
        "1",
        gained,
        (0.75, 1.25),
        "one dilatancy angle; the scatter of the mean of four packings of 200 grains",
    );
    let mut picture = LineChart::new(
        "Four cells of grains in the mean, and the law fitted to it at 100 kPa",
        "shortening",
        "difference of the stresses (Pa)",
    );
    picture.series.push(low.series("grains, 100 kPa", Style::Markers));
    picture.series.push(own.series("fitted, 100 kPa", Style::Dashed));
    picture.series.push(high.series("grains, 200 kPa", Style::Markers));
    picture.series.push(foretold.series("foretold, 200 kPa", Style::Line));
    outcome.svg("The law has no softening: it keeps the peak.", &picture)?;
    Ok(outcome)
}
