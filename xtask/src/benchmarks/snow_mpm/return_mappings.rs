//! Worked examples of the return maps (sheet: snow-mpm §3.9), by the law that a case selects.

use colluvium::constitutive::{InitialCondition, Mat3, MaterialSpec, Motion, SymTensor};
use serde_json::json;

use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of worked examples of the return map of Cohesive Cam Clay.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/returns",
    title: "Cohesive Cam clay: worked examples of the return map",
    source: "sheet: snow-mpm §3.9, both worked examples of cohesive Cam clay, and the amendment",
    short_seconds: Some(1),
    full_seconds: 1,
    run: benchmark,
};

/// Reason of the tolerance of the sheet's examples.
const TOLERANCE_REASON: &str = "the sheet's tolerance; round-off where a value is nought";

/// Kirchhoff stress (Pa), plastic volumetric strain and compressive strength (Pa) after one step.
struct ReturnedState {
    stress: SymTensor,
    volumetric: f64,
    strength: f64,
}

/// State after one step with the deformation `f` from the initial state of the sheet's snow.
fn returned_state(f: &Mat3, integration: &str, invariants: &str) -> Result<ReturnedState, String> {
    let spec: MaterialSpec = serde_json::from_value(json!({
        "model": "cohesive-cam-clay", "density": 250, "youngs_modulus": 3e6, "poissons_ratio": 0.3,
        "critical_state_slope": 1.2, "cohesion_ratio": 0.3, "hardening_factor": 1, "compressive_strength": 20e3,
        "integration": integration, "invariants": invariants
    }))
    .map_err(|error| error.to_string())?;
    let law = spec.build().map_err(|error| error.to_string())?;
    let start = InitialCondition { stress: SymTensor::ZERO, density: 250.0 };
    let (mut stress, mut states) = law.initial(&[start]).map_err(|error| error.source.to_string())?;
    let motion = Motion::from_deformation(f, 1e-3, 250.0, 1.0).ok_or("singular motion")?;
    law.update(&[motion], &mut stress, &mut states.blocks_mut()[0])
        .map_err(|error| error.source.to_string())?;
    let mut out = vec![0.0; law.output_names().len()];
    law.outputs(&stress, &states.blocks()[0], &mut out);
    let of = |name: &str| law.output_names().iter().position(|own| *own == name).map_or(f64::NAN, |i| out[i]);
    Ok(ReturnedState {
        stress: stress[0] * f.determinant(),
        volumetric: of("plastic_volumetric_strain"),
        strength: of("compressive_strength"),
    })
}

/// Checks worked examples of the return map of Cohesive Cam Clay.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    // Trial strains; for explicit and implicit p0: p, q (Pa), plastic volumetric strain, p0 (Pa).
    let table = [
        (
            [-0.006, -0.001, -0.001],
            [16993.525485, 7887.743882, -0.001202589806, 23006.585908],
            [18147.779532, 9075.390812, -0.000740888187, 21852.285397],
        ),
        (
            [0.004, -0.003, -0.0012],
            [1553.178261, 11198.165905, 0.000421271304, 18946.789782],
            [1671.948242, 10631.539405, 0.000468779297, 18828.016410],
        ),
        (
            [0.004, 0.002, 0.001],
            [-5725.849836, 2519.418855, 0.004709660066, 8225.651350],
            [-986.822565, 488.042681, 0.006605270974, 3486.610368],
        ),
        (
            [-0.004; 3],
            [20000.0, 0.0, -0.004, 30000.506663],
            [25000.101663, 0.0, -0.001999959335, 25000.101663],
        ),
        ([0.002; 3], [-6000.0, 0.0, 0.0036, 10999.822164], [-2142.769881, 0.0, 0.005142892047, 7142.566271]),
    ];
    for (trial, explicit, implicit) in table {
        let [x, y, z] = trial.map(f64::exp);
        let f = Mat3([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]);
        for (integration, exact) in [("explicit", explicit), ("implicit", implicit)] {
            let ReturnedState { stress, volumetric, strength } = returned_state(&f, integration, "space")?;
            let found = [stress.pressure(), stress.q(), volumetric, strength];
            for (what, (found, exact)) in ["p (Pa)", "q (Pa)", "plastic volumetric strain", "p0 (Pa)"]
                .iter()
                .zip(found.iter().zip(exact))
            {
                // Tips have no deviator: its round-off is a share of p0.
                let tolerance = if exact == 0.0 { 20e3 * 1e-8 } else { 1e-8 };
                outcome.assert_close(
                    format!("W1 {trial:?}, {integration}: {what}"),
                    exact,
                    tolerance,
                    *found,
                    TOLERANCE_REASON,
                );
            }
        }
    }
    full_tensor(&mut outcome)?;
    Ok(outcome)
}

/// Checks the return of a stress with shear components (W2).
fn full_tensor(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let f = Mat3([[1.002, 0.006, 0.0], [-0.001, 0.995, 0.0], [0.0, 0.0, 1.0]]);
    for (integration, exact, p0) in [
        ("explicit", [-2529.386846, 4035.081754, -13911.761183], 20112.817001),
        ("implicit", [-2513.085335, 4056.243147, -13955.152858], 20103.530478),
    ] {
        let ReturnedState { stress, strength, .. } = returned_state(&f, integration, "space")?;
        for (what, found, exact) in
            [("τ_xx", stress[0], exact[0]), ("τ_xy", stress[3], exact[1]), ("τ_yy", stress[1], exact[2])]
        {
            outcome.assert_close(
                format!("W2, {integration}: {what} (Pa)"),
                exact,
                1e-8,
                found,
                TOLERANCE_REASON,
            );
        }
        outcome.assert_close(format!("W2, {integration}: p0 (Pa)"), p0, 1e-8, strength, TOLERANCE_REASON);
    }
    let plane = returned_state(&f, "explicit", "plane")?.stress;
    for (what, found, exact) in
        [("τ_xx", plane[0], -2508.913022), ("τ_xy", plane[3], 4098.018983), ("τ_yy", plane[1], -14068.824057)]
    {
        outcome.assert_close(
            format!("W2, invariants of the plane, explicit: {what} (Pa)"),
            exact,
            1e-8,
            found,
            TOLERANCE_REASON,
        );
    }
    let ReturnedState { stress, volumetric, strength } = returned_state(&f, "implicit", "plane")?;
    let name = "W2, invariants of the plane, implicit";
    outcome.assert_close(
        format!("{name}: p (Pa)"),
        8334.119275,
        1e-8,
        -0.5 * (stress[0] + stress[1]),
        TOLERANCE_REASON,
    );
    outcome.assert_close(
        format!("{name}: plastic volumetric strain"),
        -1.193597159e-4,
        1e-8,
        volumetric,
        TOLERANCE_REASON,
    );
    outcome.assert_close(format!("{name}: p0 (Pa)"), 20344.315292, 1e-8, strength, TOLERANCE_REASON);
    Ok(())
}
