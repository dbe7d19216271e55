//! Element tests of every model (sheet: constitutive V-01 … V-10 but returns, table of §2.13).

use colluvium::constitutive::driver::{ElementPath, ElementTest, LoadingPath, TestStage};
use colluvium::constitutive::{InitialCondition, MaterialSpec, SymTensor};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::analysis::MaxOrNan;
use crate::benchmarks::element::elastic_tests;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, merged};

/// Benchmark of element tests of every material model.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "constitutive/elements",
    title: "Element tests of every model",
    source: "sheet: constitutive V-01, V-02, V-03, V-06, V-07, V-09, V-10, V-20 (water), table of §2.13, closed forms",
    short_seconds: Some(1),
    full_seconds: 1,
    run: benchmark,
};

pub(super) const MACHINE: &str = "closed form, solved to machine precision";
const PATH: &str = "the sheet's 10⁻⁶ for a path to failure";

fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    elastic_tests::small_strain(&mut outcome)?;
    elastic_tests::jaumann_shear(&mut outcome)?;
    elastic_tests::objectivity(&mut outcome)?;
    elastic_tests::finite_strain(&mut outcome)?;
    biaxial(&mut outcome)?;
    triaxial(&mut outcome)?;
    softening(&mut outcome)?;
    fluid(&mut outcome)?;
    Ok(outcome)
}

/// Material of reference set R1 with other entries added or replaced.
pub(super) fn material(model: &str, more: serde_json::Value) -> Result<MaterialSpec, String> {
    let base = json!({ "model": model, "density": 2000.0, "youngs_modulus": 20e6, "poissons_ratio": 0.3 });
    serde_json::from_value(merged(base, more)).map_err(|error| error.to_string())
}

/// Element test of one stage from an isotropic stress of `pressure` (Pa).
pub(super) fn test(
    material: MaterialSpec,
    pressure: f64,
    path: LoadingPath,
    steps: usize,
) -> Result<ElementPath, String> {
    staged_test(material, pressure, &[(path, steps)])
}

/// Element test of several stages, with the steps of each, from an isotropic stress of `pressure` (Pa).
fn staged_test(
    material: MaterialSpec,
    pressure: f64,
    paths: &[(LoadingPath, usize)],
) -> Result<ElementPath, String> {
    let stage =
        |(path, steps): &(LoadingPath, usize)| TestStage { path: path.clone(), steps: *steps, duration: 1.0 };
    let test = ElementTest {
        title: String::new(),
        material,
        initial_stress: [-pressure, -pressure, -pressure, 0.0, 0.0, 0.0],
        stages: paths.iter().map(stage).collect(),
    };
    test.run().map_err(|error| error.to_string())
}

fn biaxial(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let path = || LoadingPath::BiaxialPlaneStrain { axial_compression: 0.4 };
    let strength = json!({ "friction_angle": 30.0, "cohesion": 10e3 });
    let with = |matching: &str, dilatancy: f64| {
        let mut more = strength.clone();
        more["matching"] = json!(matching);
        more["dilatancy_angle"] = json!(dilatancy);
        material("drucker-prager", more)
    };
    let mut chart =
        LineChart::new("Biaxial compression in plane strain, 100 kPa", "axial compression", "q (Pa)");
    let cases = [
        ("plane-strain", 0.0, -334_641.016_15),
        ("plane-strain", 10.0, -334_641.016_15),
        ("plane-strain-associated", 30.0, -334_641.016_15),
        ("compression", 0.0, -629_214.908_38),
    ];
    for (matching, dilatancy, exact) in cases {
        let run = test(with(matching, dilatancy)?, 100e3, path(), 400)?;
        let name = format!("V-06 Drucker–Prager {matching}, ψ = {dilatancy}°: σ_yy at failure (Pa)");
        outcome.assert_close(name, exact, 1e-6, run.last("stress_yy"), PATH);
        let curve = run
            .column("axial_compression")
            .unwrap_or_default()
            .into_iter()
            .zip(run.column("q").unwrap_or_default());
        let early = curve.filter(|(x, _)| *x < 0.08).collect();
        chart.series.push(Series::new(format!("{matching}, ψ = {dilatancy}°"), early, Style::Line));
    }
    for psi in [10.0, 30.0, 0.0f64] {
        let mut more = strength.clone();
        more["dilatancy_angle"] = json!(psi);
        let run = test(material("mohr-coulomb", more)?, 100e3, path(), 400)?;
        let name = format!("V-09 Mohr–Coulomb biaxial, ψ = {psi}°: σ_yy at failure (Pa)");
        outcome.assert_close(name, -334_641.016_15, 1e-6, run.last("stress_yy"), PATH);
    }
    let run = test(material("mohr-coulomb", strength)?, 100e3, path(), 400)?;
    let curve = run
        .column("axial_compression")
        .unwrap_or_default()
        .into_iter()
        .zip(run.column("q").unwrap_or_default());
    chart.series.push(Series::new("Mohr–Coulomb", curve.filter(|(x, _)| *x < 0.08).collect(), Style::Dashed));
    outcome.svg("How the cone is matched decides the strength in plane strain.", &chart)
}

fn triaxial(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart =
        LineChart::new("Mohr–Coulomb, drained and undrained triaxial compression", "p (Pa)", "q (Pa)");
    let spec = || material("mohr-coulomb", json!({ "friction_angle": 30.0, "cohesion": 10e3 }));
    for (pressure, exact) in [(50e3, 134_641.016_151), (100e3, 234_641.016_151)] {
        let run = test(spec()?, pressure, LoadingPath::TriaxialDrained { axial_compression: 0.1 }, 200)?;
        outcome.assert_close(
            format!("V-09 drained, {pressure} Pa: q at failure (Pa)"),
            exact,
            1e-6,
            run.last("q"),
            PATH,
        );
        let points = run.column("p").unwrap_or_default().into_iter().zip(run.column("q").unwrap_or_default());
        chart.series.push(Series::new(
            format!("drained, {} kPa", pressure / 1e3),
            points.collect(),
            Style::Line,
        ));
    }
    let run = test(
        spec()?,
        100e3,
        LoadingPath::TriaxialUndrained { axial_compression: 0.1, fluid_stiffness: None },
        200,
    )?;
    outcome.assert_close("V-09 undrained, ψ = 0: q at failure (Pa)", 140_784.610, 1e-6, run.last("q"), PATH);
    let points = run.column("p").unwrap_or_default().into_iter().zip(run.column("q").unwrap_or_default());
    chart.series.push(Series::new("undrained, 100 kPa", points.collect(), Style::Line));
    let slope = 6.0 * 0.5 / (3.0 - 0.5);
    let shift = 6.0 * 10e3 * 30f64.to_radians().cos() / 2.5;
    let surface = (0..=10).map(|i| 20e3 * f64::from(i)).map(|p| (p, shift + slope * p)).collect();
    chart.series.push(Series::new("yield in compression", surface, Style::Dashed));
    outcome.svg("Stress paths end on the yield surface.", &chart)?;
    outcome.assert_close("V-09 undrained, ψ = 0: p at failure (Pa)", 100e3, 1e-6, run.last("p"), PATH);
    dilating(outcome)?;
    check_oedometers(outcome)?;
    check_extension(outcome)
}

/// Checks that the undrained strength of a dilating soil has no bound.
fn dilating(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let more = json!({ "friction_angle": 30.0, "cohesion": 10e3, "dilatancy_angle": 10.0 });
    let spec = material("mohr-coulomb", more)?;
    let run = test(
        spec.clone(),
        100e3,
        LoadingPath::TriaxialUndrained { axial_compression: 0.1, fluid_stiffness: None },
        200,
    )?;
    let q = run.column("q").unwrap_or_default();
    let smallest = q.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    let growth = (0.0, f64::INFINITY);
    outcome.assert_within(
        "V-09 undrained, ψ = 10°: least growth of q (Pa)",
        "above 0",
        smallest,
        growth,
        "monotone growth",
    );
    let name = "V-09 undrained, ψ = 10°: q at 10 % over that of ψ = 0";
    outcome.assert_within(
        name,
        "no bound",
        run.last("q") / 140_784.610,
        (2.0, f64::INFINITY),
        "far beyond it",
    );
    let undrained: MaterialSpec = serde_json::from_value(
        json!({ "model": "undrained", "fluid_bulk_modulus": 2e9, "porosity": 0.4, "skeleton": spec }),
    )
    .map_err(|error| error.to_string())?;
    let warned =
        undrained.warnings().iter().any(|warning| warning.text.starts_with("skeleton.dilatancy_angle"));
    outcome.assert_close(
        "V-09 undrained, ψ = 10°: a warning",
        1.0,
        0.0,
        f64::from(u8::from(warned)),
        "the sheet requires it",
    );
    Ok(())
}

/// Checks oedometers without cohesion.
fn check_oedometers(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let soil = |nu: f64| material("mohr-coulomb", json!({ "friction_angle": 30.0, "poissons_ratio": nu }));
    let path = |axial_compression| LoadingPath::Oedometer { axial_compression };
    let run = test(soil(0.2)?, 0.0, path(0.01), 100)?;
    let name = "V-09 oedometer from zero stress, ν = 0.2";
    outcome.assert_close(
        format!("{name}: axial stress at 1 % (Pa)"),
        -200e3,
        1e-6,
        run.last("stress_zz"),
        PATH,
    );
    outcome.assert_close(
        format!("{name}: lateral stress at 1 % (Pa)"),
        -200e3 / 3.0,
        1e-6,
        run.last("stress_xx"),
        PATH,
    );
    let half = run.column("stress_zz").unwrap_or_default()[50];
    outcome.assert_close(
        format!("{name}: slope (Pa)"),
        20e6,
        1e-6,
        (half - run.last("stress_zz")) / 0.005,
        PATH,
    );
    let run = staged_test(soil(0.2)?, 100e3, &[(path(0.036), 360), (path(0.01), 100)])?;
    let axial = run.column("stress_zz").unwrap_or_default();
    let lateral = run.column("stress_xx").unwrap_or_default();
    let name = "V-09 oedometer from 100 kPa, ν = 0.2";
    outcome.assert_close(
        format!("{name}: elastic slope (Pa)"),
        20e6 / 0.9,
        1e-6,
        (axial[0] - axial[300]) / 0.03,
        PATH,
    );
    outcome.assert_close(format!("{name}: axial stress at yield (Pa)"), -900e3, 1e-6, axial[360], PATH);
    outcome.assert_close(format!("{name}: lateral stress at yield (Pa)"), -300e3, 1e-6, lateral[360], PATH);
    outcome.assert_close(
        format!("{name}: slope after yield (Pa)"),
        20e6,
        1e-6,
        (axial[360] - axial[460]) / 0.01,
        PATH,
    );
    let run = test(soil(0.3)?, 0.0, path(0.01), 100)?;
    let name = "V-09 oedometer from zero stress, ν = 0.3: axial stress, elastic (Pa)";
    outcome.assert_close(name, -269_230.769_230_769, 1e-6, run.last("stress_zz"), PATH);
    Ok(())
}

/// Checks a cohesionless soil that is extended by 1 % in each direction and compressed by a tenth of that.
fn check_extension(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let strain = |e: f64| LoadingPath::Strain { increment: [e, e, e, 0.0, 0.0, 0.0] };
    for model in ["mohr-coulomb", "drucker-prager", "cfd-soil"] {
        let soil = material(model, json!({ "friction_angle": 30.0 }))?;
        let run = staged_test(soil, 0.0, &[(strain(0.01), 10), (strain(-0.001), 10)])?;
        let stress = |row: usize| {
            let of = |name: &str| run.column(name).map_or(f64::NAN, |column| column[row].abs());
            of("p").max(of("q"))
        };
        let open = (0..=10).map(stress).max_or_nan();
        outcome.assert_close(
            format!("V-10 {model} in tension: largest stress (Pa)"),
            0.0,
            0.0,
            open,
            "exactly stress-free",
        );
        // The apex of a perfectly plastic law has no memory of the gap; a pressure from density has.
        let (pressure, reason) = match model {
            "cfd-soil" => (0.0, "pressure from density comes back only when the gap has closed"),
            _ => (0.003 * 20e6 / 1.2, "P-06: the apex of a perfectly plastic law forgets the opened volume"),
        };
        outcome.assert_close(
            format!("V-10 {model} pressed together again: p (Pa)"),
            pressure,
            1e-9,
            run.last("p"),
            reason,
        );
    }
    Ok(())
}

fn softening(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    // BN Table 2: c = 1.5 + 23.5 exp(-5κ) kPa, no friction.
    let softening = json!({
        "residual_friction_angle": 0.0, "residual_cohesion": 1500.0, "friction_rate": 0.0, "cohesion_rate": 5.0
    });
    let mut chart = LineChart::new("Simple shear of a sensitive clay", "shear strain", "shear stress (Pa)");
    for (matching, peak) in [("compression", 28_867.513), ("plane-strain", 25_000.0)] {
        let more = json!({
            "friction_angle": 0.0, "cohesion": 25e3, "matching": matching, "softening": softening,
            "youngs_modulus": 25e6, "poissons_ratio": 0.49
        });
        // 1000 steps to ten per cent for the peak, 1000 more to the residual strength.
        let path = |shear: f64| LoadingPath::SimpleShearConstantVolume { shear };
        let paths = [(path(0.1), 1000), (path(0.9), 1000)];
        let run = staged_test(material("drucker-prager", more)?, 0.0, &paths)?;
        let root: Vec<f64> =
            run.column("q").unwrap_or_default().into_iter().map(|q| q / 3f64.sqrt()).collect();
        let found = root.iter().copied().max_or_nan();
        let name = format!("V-07 sensitive clay, {matching}: peak of √J2 (Pa)");
        outcome.assert_close(name, peak, 1e-3, found, "the sheet's for 1000 steps");
        let kappa = run.last("plastic_strain");
        let exact = (1500.0 + 23_500.0 * (-5.0 * kappa).exp()) * peak / 25e3;
        outcome.assert_close(
            format!("V-07 sensitive clay, {matching}: √J2 at the end (Pa)"),
            exact,
            1e-6,
            root[root.len() - 1],
            MACHINE,
        );
        let shear = run.column("strain_xy").unwrap_or_default().into_iter().map(|e| 2.0 * e);
        chart.series.push(Series::new(matching, shear.zip(root).collect(), Style::Line));
    }
    outcome.svg("The fully implicit softening return stays on the shrinking surface.", &chart)
}

fn fluid(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let water =
        json!({ "model": "newtonian-fluid", "density": 1000.0, "bulk_modulus": 2.15e9, "viscosity": 1e-3 });
    let spec: MaterialSpec = serde_json::from_value(water).map_err(|error| error.to_string())?;
    let law = spec.build().map_err(|error| error.to_string())?;
    let start = InitialCondition { stress: SymTensor::ZERO, density: 1000.0 };
    let (stresses, states) = law.initial(&[start]).map_err(|error| error.to_string())?;
    let mut modulus = [0.0];
    law.wave_moduli(&stresses, &states.blocks()[0], &mut modulus);
    outcome.assert_close(
        "V-20 water: speed of sound (m/s)",
        1466.29,
        1e-5,
        (modulus[0] / 1000.0).sqrt(),
        "the sheet's digits",
    );
    let shear = LoadingPath::Flow { velocity_gradient: [[0.0, 5.0, 0.0], [0.0; 3], [0.0; 3]] };
    let run = test(spec, 0.0, shear, 5)?;
    outcome.assert_close(
        "V-20 water: shear stress at 5 1/s (Pa)",
        5e-3,
        1e-9,
        run.last("stress_xy"),
        MACHINE,
    );
    Ok(())
}
