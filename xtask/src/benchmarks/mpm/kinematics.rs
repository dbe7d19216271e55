//! Velocity gradient and rotation at the points (sheet: mpm ).

use colluvium::case::{Case, Snapshot};
use colluvium::constitutive::{InitialCondition, Mat3, Motion, SymTensor};
use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, reference_curve, reference_table, run_mpm, set_mpm_option,
    stresses, vectors,
};

/// Benchmark of a constant velocity gradient, rotation and shear of a stressed block.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/kinematics",
    title: "Constant velocity gradient, rotation and shear of a stressed block",
    source: "sheet: mpm A-04, A-05, closed forms",
    short_seconds: Some(6),
    full_seconds: 6,
    run: benchmark,
};

/// Shape functions that all checks use.
const SHAPES: [&str; 5] = ["linear", "ugimp", "cpgimp", "quadratic", "cubic"];
/// Name of linear shape functions on a mesh of triangles.
const TRIANGLES: &str = "triangles";

/// Half width (m) of the evaluated core. The surface, where the lumped mass of a node does not lie at the node, does not affect it: with
/// cubic splines and re-mapping a step reaches eight cells.
const CORE: f64 = 0.2;

/// Checks velocity gradients and rotations at the points.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    for shape in SHAPES.into_iter().chain(["cpdi", "cpdi2", "dual-domain", TRIANGLES]) {
        patch(&mut outcome, shape)?;
    }
    // Domains of cpGIMP follow the diagonal of the deformation gradient, which is zero in a quarter turn.
    for shape in ["linear", "ugimp", "quadratic", "cubic"] {
        rotation(&mut outcome, shape)?;
    }
    shear(&mut outcome)?;
    Ok(outcome)
}

/// Stresses of the points that were initially in the core.
fn core(snapshot: &Snapshot) -> Vec<SymTensor> {
    let moved = vectors(snapshot, "displacement");
    let inside = |(x, u): (&[f64; 3], &[f64; 3])| (0..2).all(|c| (x[c] - u[c]).abs() < CORE);
    let points = snapshot.positions.iter().zip(&moved).zip(stresses(snapshot));
    points.filter(|((x, u), _)| inside((x, u))).map(|(_, stress)| stress).collect()
}

/// Mean of stresses.
fn mean(stresses: &[SymTensor]) -> SymTensor {
    let sum = stresses.iter().fold(SymTensor::ZERO, |sum, stress| sum + *stress);
    sum * (1.0 / stresses.len() as f64)
}

/// Largest distance of stresses from the exact one.
fn farthest(stresses: &[SymTensor], exact: SymTensor) -> f64 {
    stresses.iter().map(|stress| (*stress + exact * -1.0).norm()).max_or_nan()
}

/// Checks that after one step of a linear velocity field the stress of every point of the core is that of the law. The law is one-to-one,
/// so that the stress represents the gradient, its spin included.
fn patch(outcome: &mut BenchmarkOutcome, shape: &str) -> Result<(), String> {
    let mut worst = 0f64;
    for scheme in ["usf", "usl", "musl"] {
        let mut case = load_case("mpm/patch")?;
        if shape == TRIANGLES {
            set_mpm_option(&mut case, "mesh", serde_json::json!({ "kind": "box" }));
        } else {
            set_mpm_option(&mut case, "shape", shape);
        }
        set_mpm_option(&mut case, "stress_update", scheme);
        let report = run_mpm(&case)?;
        let (exact, scale) = stress_after_step(&case)?;
        let found = core(&report.snapshot);
        if report.steps != 1 || found.is_empty() {
            return Err(format!("{shape}, {scheme}: {} steps, {} points", report.steps, found.len()));
        }
        worst = worst.max(farthest(&found, exact) / scale);
    }
    let reason = "the sheet's 10⁻¹², for stress first, last and last from re-mapped velocities";
    let name = format!("A-04 patch, {shape}: largest error of stress over E |L| Δt");
    outcome.assert_below(name, "0", worst, 1e-12, reason);
    Ok(())
}

/// Stress (Pa) after the step of the case by the law alone, and `E |L| Δt` (Pa).
fn stress_after_step(case: &Case) -> Result<(SymTensor, f64), String> {
    let body = serde_json::to_value(&case.bodies[0]).map_err(|error| error.to_string())?;
    let entry = |i: usize, j: usize| body["velocity"]["gradient"][i][j].as_f64().unwrap_or(f64::NAN);
    let dt = case.stages[0].duration;
    let mut gradient = Mat3::ZERO;
    for i in 0..2 {
        for j in 0..2 {
            gradient.0[i][j] = entry(i, j) * dt;
        }
    }
    let spec = &case.materials["body"];
    let law = spec.build().map_err(|error| error.to_string())?;
    let stress = case.initial_stress(&case.bodies[0], [0.0; 3]);
    let start = InitialCondition { stress, density: spec.density() };
    let (mut stresses, mut states) = law.initial(&[start]).map_err(|error| error.to_string())?;
    let deformation = Mat3::IDENTITY + gradient;
    let mut motion =
        Motion::from_deformation(&Mat3::IDENTITY, dt, spec.density(), 1.0).ok_or("singular identity")?;
    motion.deformation = deformation;
    motion.velocity_gradient_dt = gradient;
    law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]).map_err(|error| error.to_string())?;
    let size = gradient.0.as_flattened().iter().map(|g| g * g).sum::<f64>().sqrt();
    Ok((stresses[0], 1e6 * size))
}

/// Sets the MPM shape functions of a case. The domains of contiguous-particle GIMP follow the right stretch: with the diagonal of the
/// deformation gradient a point at the surface separates in shear (see the page of validation).
fn set_shape_functions(case: &mut Case, shape: &str) {
    set_mpm_option(case, "shape", shape);
    if shape == "cpgimp" {
        set_mpm_option(case, "domain_stretch", "right-stretch");
    }
}

/// Checks a quarter turn of a stressed block across the cells of the grid.
fn rotation(outcome: &mut BenchmarkOutcome, shape: &str) -> Result<(), String> {
    let mut case = load_case("mpm/stress-rotation")?;
    set_shape_functions(&mut case, shape);
    let start = case.initial_stress(&case.bodies[0], [0.0; 3]);
    let turned = start.rotated(&Mat3::rotation_z(std::f64::consts::FRAC_PI_2));
    let found = core(&run_mpm(&case).map_err(|error| format!("quarter turn, {shape}: {error}"))?.snapshot);
    let middle = mean(&found);
    let reason = "the sheet's 0.5 %; mean over the core";
    for (component, name) in [(0, "σ_xx"), (1, "σ_yy"), (3, "σ_xy")] {
        let name = format!("A-05 quarter turn, {shape}: {name} (Pa)");
        outcome.assert_close(name, turned[component], 5e-3, middle[component], reason);
    }
    outcome.assert_below(
        format!("A-05 quarter turn, {shape}: largest error of a point over the size of the stress"),
        "0",
        farthest(&found, turned) / start.norm(),
        5e-3,
        "the sheet's 0.5 %",
    );
    Ok(())
}

/// Checks simple shear to 1 in steps of 0.001.
fn shear(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let exact = reference_table("mpm/simple-shear/reference.csv")?;
    let mut chart =
        LineChart::new("Simple shear of a hypoelastic block", "shear strain γ", "stress over shear modulus");
    let modulus = 1e6 / 2.6;
    for component in ["xy", "xx"] {
        let label = format!("σ_{component}, closed form");
        chart.series.push(Series::new(label, reference_curve(&exact, "shear", component)?, Style::Dashed));
    }
    for shape in SHAPES {
        let mut case = load_case("mpm/simple-shear")?;
        set_shape_functions(&mut case, shape);
        let report = run_mpm(&case).map_err(|error| format!("simple shear, {shape}: {error}"))?;
        let found = core(&report.snapshot);
        let middle = mean(&found) * (1.0 / modulus);
        let reason = "the sheet's 1 % in steps of 0.001; mean over the core";
        let (xx, xy) = (1.0 - 1f64.cos(), 1f64.sin());
        for (component, name, value) in [(3, "σ_xy", xy), (0, "σ_xx", xx), (1, "σ_yy", -xx)] {
            let name = format!("A-05 simple shear to γ = 1, {shape}: {name} over G");
            outcome.assert_close(name, value, 1e-2, middle[component], reason);
        }
        if shape == "ugimp" {
            for (component, name) in [(3, "xy"), (0, "xx")] {
                let points = report.frames.iter().map(|f| (f.time, mean(&core(f))[component] / modulus));
                chart.series.push(Series::new(format!("σ_{name}, uGIMP"), points.collect(), Style::Markers));
            }
        }
    }
    outcome
        .svg("Stress in the core of a block that shears across the grid, and Jaumann's closed form.", &chart)
}
