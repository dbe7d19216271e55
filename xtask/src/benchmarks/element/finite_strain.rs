//! Finite-strain laws: elasticity, Cohesive Cam Clay, weak layers, snow (sheet: constitutive V-04, V-13 …
//! V-15).

use std::sync::Arc;

use colluvium::constitutive::driver::{ElementPath, ElementTest, LoadingPath, TestStage};
use colluvium::constitutive::laws::Elasticity;
use colluvium::constitutive::laws::cohesive_cam_clay::YieldEllipse;
use colluvium::constitutive::{InitialCondition, Mat3, Material, MaterialSpec, Motion, States, SymTensor};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use super::element_tests::material;
use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, merged};

/// Benchmark of finite-strain elasticity, Cohesive Cam Clay, weak layers and snow.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "constitutive/finite-strain",
    title: "Finite-strain elasticity, Cohesive Cam Clay, weak layers and snow",
    source: "sheet: constitutive V-04, V-13, V-14, V-15, tables of §2.13–2.15, closed forms",
    short_seconds: Some(1),
    full_seconds: 1,
    run: benchmark,
};

/// Reason of the tolerance of values printed in the sheet.
const DIGITS: &str = "the digits the sheet gives";
/// Reason of the tolerance of values in closed form.
const MACHINE: &str = "closed form, solved to machine precision";
/// Reason of a tolerance of 10⁻³ for paths of 2000 steps.
const PATH: &str = "the sheet's 10⁻³ for 2000 steps";

/// Checks finite-strain elasticity, Cohesive Cam Clay, weak layers and snow.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    table(&mut outcome)?;
    closed_path(&mut outcome)?;
    cam_clay_returns(&mut outcome)?;
    weak_layer(&mut outcome)?;
    snow(&mut outcome)?;
    Ok(outcome)
}

/// Material from its keys.
fn spec(value: Value) -> Result<MaterialSpec, String> {
    serde_json::from_value(value).map_err(|error| error.to_string())
}

/// Material point on a strain path, with its Kirchhoff stress.
struct FiniteStrainPoint {
    law: Arc<dyn Material>,
    stress: Vec<SymTensor>,
    states: States,
    deformation: Mat3,
}

impl FiniteStrainPoint {
    /// Material point without stress.
    fn new(spec: &MaterialSpec) -> Result<Self, String> {
        let law = spec.build().map_err(|error| error.to_string())?;
        let start = InitialCondition { stress: SymTensor::ZERO, density: spec.density() };
        let (stress, states) = law.initial(&[start]).map_err(|error| error.to_string())?;
        Ok(Self { law, stress, states, deformation: Mat3::IDENTITY })
    }

    /// Kirchhoff stress after a step to the deformation gradient `f`.
    fn stress_after_step_to(&mut self, f: &Mat3) -> Result<SymTensor, String> {
        let step = *f * self.deformation.inverse().ok_or("singular deformation")?;
        let motion = Motion::from_deformation(&step, 1.0, 1.0, 1.0).ok_or("singular step")?;
        self.law
            .update(&[motion], &mut self.stress, &mut self.states.blocks_mut()[0])
            .map_err(|error| error.to_string())?;
        self.deformation = *f;
        Ok(self.stress[0] * f.determinant())
    }

    /// Output scalars of the point.
    fn outputs(&self) -> Vec<f64> {
        let mut out = vec![0.0; self.law.output_names().len()];
        self.law.outputs(&self.stress, &self.states.blocks()[0], &mut out);
        out
    }
}

/// Elastic laws of the sheet's table, in the order of its columns.
fn elastic_laws() -> Result<[(&'static str, MaterialSpec); 4], String> {
    Ok([
        ("Hencky", material("linear-elastic", json!({ "strain_measure": "hencky" }))?),
        ("St. Venant–Kirchhoff", material("st-venant-kirchhoff", json!({}))?),
        ("neo-Hookean", material("neo-hookean", json!({}))?),
        ("fixed corotated", material("fixed-corotated", json!({}))?),
    ])
}

/// Shear modulus (Pa).
const SHEAR_MODULUS: f64 = 20e6 / 2.6;

/// Checks the Kirchhoff stresses of elastic laws at three deformations.
fn table(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let shear = Mat3([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let stretch = Mat3([[1.0, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 1.0]]);
    let general = Mat3([[1.1, 0.3, 0.0], [0.05, 0.9, -0.1], [0.0, 0.2, 1.05]]);
    // Kirchhoff stress over G: deformation, component, value of each law.
    let rows: [(Mat3, usize, [f64; 4]); 12] = [
        (shear, 3, [0.860_817_88, 2.75, 1.0, 1.105_572_81]),
        (shear, 0, [0.430_408_94, 4.5, 1.0, 1.316_718_43]),
        (shear, 1, [-0.430_408_94, 1.75, 0.0, 0.211_145_62]),
        (shear, 2, [0.0, 0.75, 0.0, 0.0]),
        (stretch, 1, [-0.781_002_43, -0.403_2, -0.694_715_33, -0.56]),
        (stretch, 0, [-0.334_715_33, -0.27, -0.334_715_33, -0.24]),
        (general, 0, [0.284_776_81, 0.757_6, 0.367_101_5, 0.414_634_41]),
        (general, 1, [-0.190_978_98, 0.128_728_13, -0.110_398_5, -0.066_999_65]),
        (general, 2, [0.196_975_33, 0.399_103_13, 0.209_601_5, 0.220_808_15]),
        (general, 3, [0.321_123_16, 0.433_906_25, 0.325, 0.329_174_2]),
        (general, 4, [0.071_062_99, 0.106_781_25, 0.075, 0.077_502_11]),
        (general, 5, [0.039_726_07, 0.122_85, 0.06, 0.070_663_21]),
    ];
    let mut chart = LineChart::new("Simple shear", "shear strain", "Kirchhoff shear stress over G");
    for (column, (name, spec)) in elastic_laws()?.iter().enumerate() {
        let mut largest = 0.0f64;
        for (f, component, exact) in &rows {
            let found = FiniteStrainPoint::new(spec)?.stress_after_step_to(f)?[*component] / SHEAR_MODULUS;
            largest = largest.max((found - exact[column]).abs());
        }
        let name_of_check = format!("V-04 {name}: largest difference from the table of τ/G");
        outcome.assert_below(name_of_check, "0, to eight decimals", largest, 5.1e-9, DIGITS);
        let mut walker = FiniteStrainPoint::new(spec)?;
        let mut points = vec![(0.0, 0.0)];
        for step in 1..=60 {
            let gamma = 0.05 * f64::from(step);
            let f = Mat3([[1.0, gamma, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
            points.push((gamma, walker.stress_after_step_to(&f)?[3] / SHEAR_MODULUS));
        }
        points.retain(|(_, stress)| *stress < 4.0);
        chart.series.push(Series::new(*name, points, Style::Line));
    }
    outcome.svg("Four elastic laws with the same moduli at small strain.", &chart)
}

/// Work of a law around a closed path of large strain and rotation, over G, at every step.
fn work(spec: &MaterialSpec) -> Result<Vec<(f64, f64)>, String> {
    let a = Mat3([[0.1, 0.4, 0.0], [-0.1, -0.1, 0.2], [0.1, 0.0, 0.15]]);
    let b = Mat3([[0.05, -0.1, 0.2], [0.3, 0.1, 0.0], [0.0, 0.15, -0.1]]);
    let steps = 400;
    let dt = std::f64::consts::TAU / f64::from(steps);
    let mut walker = FiniteStrainPoint::new(spec)?;
    let mut total = 0.0;
    let mut points = Vec::new();
    // The trapezoidal rule converges faster than any power of the step on a periodic path.
    let mut last = 0.0;
    for step in 0..=steps {
        let t = dt * f64::from(step);
        let f = Mat3::IDENTITY + a * t.sin() + b * (1.0 - t.cos());
        let rate = a * t.cos() + b * t.sin();
        let gradient = rate * f.inverse().ok_or("singular deformation")?;
        let power = walker.stress_after_step_to(&f)?.dot(&gradient.sym()) / SHEAR_MODULUS;
        if step > 0 {
            total += 0.5 * dt * (last + power);
        }
        last = power;
        points.push((t / std::f64::consts::TAU, total));
    }
    Ok(points)
}

/// Checks that hyperelastic laws have no work around a closed strain path, and that a hypoelastic one has.
fn closed_path(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart = LineChart::new(
        "Work around a closed strain path",
        "part of the path",
        "work per initial volume over G",
    );
    let last = |points: &[(f64, f64)]| points.last().map_or(f64::NAN, |p| p.1);
    let quadratic = spec(json!({
        "model": "neo-hookean", "density": 2000.0, "youngs_modulus": 20e6, "poissons_ratio": 0.3,
        "volumetric_law": "quadratic"
    }))?;
    let mut laws = elastic_laws()?.to_vec();
    laws.push(("neo-Hookean, quadratic", quadratic));
    for (name, spec) in laws {
        let points = work(&spec)?;
        let name_of_check = format!("V-04 {name}: work around a closed path over G");
        outcome.assert_within(name_of_check, "0", last(&points), (-1e-10, 1e-10), "the sheet's 10⁻¹⁰");
        if name != "neo-Hookean, quadratic" {
            chart.series.push(Series::new(name, points, Style::Line));
        }
    }
    let rate = json!({ "model": "linear-elastic", "density": 2000.0, "youngs_modulus": 20e6, "poissons_ratio": 0.3 });
    let points = work(&spec(rate)?)?;
    outcome.assert_within(
        "V-04 rate form (Jaumann), for contrast: work around a closed path over G, absolute",
        "not 0",
        last(&points).abs(),
        (1e-4, f64::INFINITY),
        "informative: a rate form has no energy",
    );
    chart.series.push(Series::new("rate form (Jaumann)", points, Style::Dashed));
    outcome.svg("A closed path gives all work back, except in rate form.", &chart)
}

/// Cohesive Cam Clay of §2.15 with some keys replaced.
fn cam_clay(more: Value) -> Result<MaterialSpec, String> {
    let base = json!({
        "model": "cohesive-cam-clay", "density": 250.0, "youngs_modulus": 5e6, "poissons_ratio": 0.3,
        "critical_state_slope": 0.8, "cohesion_ratio": 0.1, "compressive_strength": 10e3,
        "hardening_factor": 10.0
    });
    spec(merged(base, more))
}

/// Deformation gradient of principal logarithmic strains.
fn exponential(strain: [f64; 3]) -> Mat3 {
    let [a, b, c] = strain.map(f64::exp);
    Mat3([[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]])
}

/// Checks the return map of Cohesive Cam Clay at constant strength.
fn cam_clay_returns(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let elasticity = Elasticity::new(5e6, 0.3).map_err(|error| error.to_string())?;
    let ellipse = YieldEllipse { slope: 0.8, cohesion_ratio: 0.1, strength: 10e3 };
    // Trial strain, p, q, plastic multiplier, plastic volumetric strain.
    let rows: [([f64; 3], f64, f64, f64, f64); 5] = [
        ([-8e-3, -1e-3, 0.0], 9_398.175_58, 1_826.891_85, 1.075_725_439_0e-6, -6.744_437_86e-3),
        ([-3e-3; 3], 10_000.0, 0.0, 9.375e-7, -6.6e-3),
        ([2e-3, 1e-3, 0.0], -828.153_121, 996.201_939, 4.107_373_118_1e-7, 2.801_243_25e-3),
        ([1e-3; 3], -1_000.0, 0.0, 3.920_454_5e-7, 2.76e-3),
        ([4e-3, -2.2e-3, -2.3e-3], 3_679.772_91, 3_971.715_16, 3.649_384_748_1e-7, 3.831_455_00e-4),
    ];
    let mut chart = LineChart::new("Cohesive Cam Clay: returns at fixed strength", "p (Pa)", "q (Pa)");
    let surface = (0..=120).map(|i| std::f64::consts::PI * f64::from(i) / 120.0).map(|angle| {
        let (height, width) = (0.5 * 0.8 * 10e3 * 1.1 / 1.2f64.sqrt(), 0.5 * 1.1 * 10e3);
        (4_500.0 + width * angle.cos(), height * angle.sin())
    });
    chart.series.push(Series::new("yield surface", surface.collect(), Style::Line));
    for (strain, p, q, multiplier, volumetric) in rows {
        let trial = elasticity.stress(&SymTensor::diagonal(strain[0], strain[1], strain[2]));
        let found = ellipse.return_map(&elasticity, trial.pressure(), trial.q());
        let name = |what: &str| format!("V-13 trial {strain:?}: {what}");
        outcome.assert_close(name("p (Pa)"), p, 1e-8, found.pressure, DIGITS);
        outcome.assert_within(name("q (Pa)"), &format!("{q}"), found.q, (q - 5.1e-6, q + 5.1e-6), DIGITS);
        outcome.assert_close(name("Δγ (1/Pa)"), multiplier, 2e-8, found.multiplier, DIGITS);
        outcome.assert_close(name("plastic volumetric strain"), volumetric, 2e-9, found.volumetric, DIGITS);
        // Returns of distant trial states would compress the chart: only short paths are drawn.
        if trial.q() < 10e3 && trial.pressure() < 15e3 {
            let return_path = vec![(trial.pressure(), trial.q()), (found.pressure, found.q)];
            chart.series.push(Series::new("", return_path, Style::Dashed));
        }
        chart.series.push(Series::new("", vec![(found.pressure, found.q)], Style::Markers));
    }
    outcome.svg("The associated return ends on the ellipse, in tension as in compression.", &chart)?;
    // Strength solved with the return: trial strain, plastic volumetric strain, p, q, p0.
    let rows: [([f64; 3], f64, f64, f64, f64); 3] = [
        ([-3e-3; 3], -5.999_912_293_5e-4, 35_000.036_5, 0.0, 35_000.036_5),
        ([-8e-3, -1e-3, 0.0], -8.888_219_439_7e-4, 33_796.575_2, 16_487.405_9, 47_035.237_0),
        ([2e-3, 1e-3, 0.0], 3e-3, 0.0, 0.0, 0.0),
    ];
    let slab = cam_clay(json!({}))?;
    for (strain, volumetric, p, q, strength) in rows {
        let mut walker = FiniteStrainPoint::new(&slab)?;
        let stress = walker.stress_after_step_to(&exponential(strain))?;
        let out = walker.outputs();
        let name = |what: &str| format!("V-13 hardening, trial {strain:?}: {what}");
        outcome.assert_close(name("plastic volumetric strain"), volumetric, 1e-10, out[1], DIGITS);
        let pascal = |value: f64| (value - 5.1e-5, value + 5.1e-5);
        outcome.assert_within(name("p (Pa)"), &format!("{p}"), stress.pressure(), pascal(p), DIGITS);
        outcome.assert_within(name("q (Pa)"), &format!("{q}"), stress.q(), pascal(q), DIGITS);
        outcome.assert_within(name("p0 (Pa)"), &format!("{strength}"), out[2], pascal(strength), DIGITS);
    }
    Ok(())
}

/// Path of an element test without initial stress.
fn driven(material: MaterialSpec, path: LoadingPath, steps: usize) -> Result<ElementPath, String> {
    let stages = vec![TestStage { path, steps, duration: 1.0 }];
    let test = ElementTest { title: String::new(), material, initial_stress: [0.0; 6], stages };
    test.run().map_err(|error| error.to_string())
}

/// Kirchhoff values of a column over the compression of the volume.
fn kirchhoff(run: &ElementPath, name: &str) -> Vec<(f64, f64)> {
    let strain = run.column("volumetric_strain").unwrap_or_default();
    let values = run.column(name).unwrap_or_default();
    strain.into_iter().zip(values).map(|(e, value)| (-e, value * e.exp())).collect()
}

/// Checks weak layers and slabs in hydrostatic and in uniaxial compression.
fn weak_layer(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let layer = |hardening: Value| {
        cam_clay(json!({
            "youngs_modulus": 1e6, "compressive_strength": 2e3, "hardening_factor": 0.5, "hardening": hardening
        }))
    };
    let weak = || layer(json!({ "kind": "weak-layer", "softening_factor": 1.0 }));
    hydrostatic_weak_layer(outcome, weak()?)?;
    uniaxial(outcome, weak()?, layer(json!({ "kind": "slab" }))?)
}

/// Checks the pressure of a weak layer in hydrostatic compression: peak, collapse and compaction.
fn hydrostatic_weak_layer(outcome: &mut BenchmarkOutcome, weak: MaterialSpec) -> Result<(), String> {
    let third = -0.02 / 3.0;
    let path = LoadingPath::Strain { increment: [third, third, third, 0.0, 0.0, 0.0] };
    let run = driven(weak, path, 2000)?;
    let points = kirchhoff(&run, "p");
    let at = |strain: f64| {
        let after = points.partition_point(|(e, _)| *e < strain - 1e-9).clamp(1, points.len() - 1);
        let ((e0, p0), (e1, p1)) = (points[after - 1], points[after]);
        p0 + (p1 - p0) * (strain - e0) / (e1 - e0)
    };
    let table = [(0.0024, 2000.0), (0.0030, 1500.0), (0.006_299_995_4, 416.667), (0.0198, 4_166.684)];
    for (strain, exact) in table {
        let name = format!("V-14 weak layer, hydrostatic: p at compression {strain} (Pa)");
        outcome.assert_close(name, exact, 1e-3, at(strain), PATH);
    }
    let (collapse, strength) = (0.004_799_995_4, 2e3);
    let name = "V-14 weak layer, hydrostatic: p at the collapse (Pa)";
    outcome.assert_within(name, "0", at(collapse), (0.0, 1e-3 * strength), PATH);
    let flags = run.column("collapsed").unwrap_or_default();
    let switch = flags.iter().position(|flag| *flag > 0.5).map_or(f64::NAN, |row| points[row].0);
    let (name, claim) = ("V-14 weak layer: compression at the collapse", format!("{collapse}"));
    let range = (collapse, collapse + 1e-5);
    outcome.assert_within(name, &claim, switch, range, "the step in which it happens");
    let closed = |x: f64| {
        let k = 1e6 / 1.2;
        let start = (2e3f64 / k).asinh() / 0.5;
        let p = if x < start { k * (0.5 * (start - x)).sinh() } else { k * (0.5 * (x - start)).sinh() };
        (x + p / k, p)
    };
    let mut exact = vec![(0.0, 0.0)];
    exact.extend((0..=150).map(|i| closed(1e-4 * f64::from(i))));
    let chart = LineChart {
        series: vec![
            Series::new("element test", points, Style::Line),
            Series::new("closed form", exact, Style::Dashed),
        ],
        ..LineChart::new(
            "Weak layer under hydrostatic compression",
            "logarithmic volumetric compression",
            "p of the Kirchhoff stress (Pa)",
        )
    };
    outcome.svg("Elastic, peak, loss of strength, collapse, packing.", &chart)
}

/// Checks that a weak layer loses half of its peak stress in uniaxial compression, and that a slab hardens throughout.
fn uniaxial(outcome: &mut BenchmarkOutcome, weak: MaterialSpec, slab: MaterialSpec) -> Result<(), String> {
    let mut chart =
        LineChart::new("Uniaxial compression", "logarithmic compression", "Kirchhoff stress (Pa)");
    for (name, spec) in [("weak layer", weak), ("slab", slab)] {
        let run = driven(spec, LoadingPath::Oedometer { axial_compression: 0.012 }, 2000)?;
        for column in ["p", "q"] {
            let points = kirchhoff(&run, column);
            // The peak before the collapse: debris may carry more when compacted.
            let standing = run.column("collapsed").unwrap_or_default();
            let until = standing.iter().position(|flag| *flag > 0.5).unwrap_or(points.len());
            let highest = points[..until].iter().map(|v| v.1).max_or_nan();
            let peak = points.iter().position(|v| v.1 == highest).unwrap_or_default();
            let low = points[peak..].iter().fold(highest, |m: f64, v| m.min(v.1));
            let name_of_check = format!("V-14 {name}, uniaxial: {column} after its peak over the peak");
            if name == "weak layer" {
                outcome.assert_below(name_of_check, "drops", low / highest, 0.5, "at least by half");
            } else if column == "p" {
                let end = points.last().map_or(f64::NAN, |v| v.1) / highest;
                outcome.assert_within(
                    "V-14 slab, uniaxial: p at the end over its largest",
                    "1: hardens throughout",
                    end,
                    (1.0, 1.0),
                    MACHINE,
                );
            }
            let style = if name == "slab" { Style::Dashed } else { Style::Line };
            chart.series.push(Series::new(format!("{name}, {column}"), points, style));
        }
    }
    outcome.svg("The weak layer gives way where the slab hardens.", &chart)
}

/// Checks plastic volume ratio and stress of snow beyond its critical compression and stretch.
fn snow(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let law = |elastic_law: &str| {
        spec(json!({
            "model": "snow", "density": 400.0, "youngs_modulus": 1.4e5, "poissons_ratio": 0.2, "elastic_law": elastic_law
        }))
    };
    let along = |stretch: f64| Mat3([[stretch, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let mut chart =
        LineChart::new("Snow stretched and compressed along x", "stretch", "Kirchhoff stress along x (Pa)");
    for (name, elastic_law) in [("fixed corotated", "fixed-corotated"), ("Hencky", "hencky")] {
        let spec = law(elastic_law)?;
        let mut curve = Vec::new();
        for (what, bound, end) in [("compression", 0.975, 0.85), ("extension", 1.0075, 1.15)] {
            let mut walker = FiniteStrainPoint::new(&spec)?;
            let first = FiniteStrainPoint::new(&spec)?.stress_after_step_to(&along(bound))?[0];
            let (mut volume_error, mut stress_error, mut elastic_error) = (0.0f64, 0.0f64, 0.0f64);
            let steps = 300;
            let mut branch = vec![(1.0, 0.0)];
            for step in 1..=steps {
                let stretch = 1.0 + (end - 1.0) * f64::from(step) / f64::from(steps);
                let stress = walker.stress_after_step_to(&along(stretch))?[0];
                let volume = walker.outputs()[0];
                if (stretch - bound) * (end - 1.0) > 1e-12 {
                    let exact = first * (10.0 * (1.0 - stretch / bound)).exp();
                    volume_error = volume_error.max((volume * bound / stretch - 1.0).abs());
                    stress_error = stress_error.max((stress / exact - 1.0).abs());
                } else {
                    elastic_error = elastic_error.max((volume - 1.0).abs());
                }
                branch.push((stretch, stress));
            }
            let check = |text: &str| format!("V-15 {name}, {what}: {text}");
            outcome.assert_below(check("|J_P - 1| while elastic"), "0", elastic_error, 1e-14, MACHINE);
            outcome.assert_below(check("|J_P / (λ / bound) - 1| beyond"), "0", volume_error, 1e-12, MACHINE);
            outcome.assert_below(
                check("τ over its value at the bound, against exp(ξ(1 - J_P))"),
                "0",
                stress_error,
                1e-11,
                MACHINE,
            );
            if what == "compression" {
                branch.reverse();
            }
            curve.extend(branch);
        }
        let style = if elastic_law == "hencky" { Style::Dashed } else { Style::Line };
        chart.series.push(Series::new(name, curve, style));
    }
    reference_step(outcome, &[("fixed corotated", law("fixed-corotated")?), ("Hencky", law("hencky")?)])?;
    outcome.svg("Torn snow softens, packed snow stiffens, with the excess over the bounds.", &chart)
}

/// Checks the stress of a single step of §2.14 from rest, whose stiffness depends on the earlier plastic volume.
fn reference_step(outcome: &mut BenchmarkOutcome, laws: &[(&str, MaterialSpec); 2]) -> Result<(), String> {
    let trial = Mat3([[1.01, 0.02, 0.0], [-0.015, 0.96, 0.01], [0.0, 0.005, 1.002]]);
    let exact = [-4_182.833_577, -4_333.691_282];
    let hardening = 1.268_843_31f64;
    for ((elastic_law, spec), exact) in laws.iter().zip(exact) {
        let mut walker = FiniteStrainPoint::new(spec)?;
        let stress = walker.stress_after_step_to(&trial)?;
        let volume = walker.outputs()[0] * 0.99;
        // A driver starts at J_P = 1, the sheet at 0.99: the moduli follow the product.
        let scale = hardening / walker.outputs()[1];
        let name = |what: &str| format!("V-15 reference step, {elastic_law}: {what}");
        outcome.assert_close(name("J_P"), 0.976_189_43, 6e-9, volume, DIGITS);
        outcome.assert_close(name("τ₂₂ (Pa)"), exact, 1e-8, stress[1] * scale, DIGITS);
    }
    Ok(())
}
