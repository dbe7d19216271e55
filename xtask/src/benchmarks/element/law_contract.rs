//! Contract of all laws, and of the quantities around them (sheet: constitutive V-02, V-24 … V-27).

use std::sync::Arc;

use colluvium::constitutive::laws::StrengthReduction;
use colluvium::constitutive::porous::Biot;
use colluvium::constitutive::{InitialCondition, Mat3, Material, MaterialSpec, Motion, States, SymTensor};
use serde_json::json;

use crate::analysis::max_or_nan;
use crate::benchmarks::element::return_mappings::RandomSequence;
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of objectivity and tangents of every law, Biot's constants and strength reduction.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "constitutive/contract",
    title: "Objectivity and tangents of every law, Biot's constants, strength reduction",
    source: "sheet: constitutive V-02, V-24, V-25, V-26, V-27; §2.17, §3.1, §3.10",
    short_seconds: Some(5),
    full_seconds: 5,
    run: benchmark,
};

/// Number of random paths per law.
const PATHS: usize = 40;

/// Checks objectivity, tangents and the contract of every law, Biot's modulus and strength reduction.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    biot(&mut outcome)?;
    strength_reduction(&mut outcome)?;
    objectivity(&mut outcome)?;
    tangents(&mut outcome)?;
    obligations(&mut outcome);
    Ok(outcome)
}

/// Checks Biot's modulus against published values.
fn biot(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for (porosity, coefficient, exact) in [(0.375, 0.976, 179.5e6), (0.427, 0.983, 167.9e6)] {
        let biot = Biot::with_coefficient(coefficient, 0.33e9, 0.1e9, porosity).map_err(|e| e.to_string())?;
        let name = format!("V-24 Biot modulus, n = {porosity}, B = {coefficient} (Pa)");
        outcome.assert_close(name, exact, 5e-3, biot.modulus(), "the sheet's 0.5 %");
    }
    Ok(())
}

/// Checks that a law with reduced strength yields at the reduced friction and cohesion.
fn strength_reduction(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let factor = 1.4;
    for model in ["mohr-coulomb", "drucker-prager"] {
        let spec: MaterialSpec = serde_json::from_value(json!({
            "model": "strength-reduced", "factor": factor, "material": {
                "model": model, "density": 2000.0, "youngs_modulus": 20e6, "poissons_ratio": 0.3,
                "friction_angle": 30.0, "cohesion": 10e3
            }
        }))
        .map_err(|error| error.to_string())?;
        // In triaxial compression, where both criteria agree, on the surface of the strengths over F.
        let (sin, cos) = (30f64.to_radians().tan() / factor).atan().sin_cos();
        let lateral = -50e3;
        let axial = (lateral * (1.0 + sin) - 2.0 * 10e3 / factor * cos) / (1.0 - sin);
        let point = ContractPoint::new(&spec, SymTensor::diagonal(lateral, axial, lateral))?;
        let name =
            format!("V-27 {model} with strength over {factor}: yield value on the surface over stress");
        outcome.assert_below(name, "0", point.yield_value().abs() / axial.abs(), 1e-9, "machine precision");
        let again =
            spec.strength_reduced(&StrengthReduction::by_factor(1.0)).map_err(|error| error.to_string())?;
        let again = ContractPoint::new(&again, SymTensor::diagonal(lateral, axial, lateral))?;
        outcome.assert_close(
            format!("V-27 {model}: reduced again by 1"),
            point.yield_value(),
            1e-12,
            again.yield_value(),
            "no change",
        );
    }
    Ok(())
}

/// Material point of a law, with its stress and state.
#[derive(Clone)]
struct ContractPoint {
    law: Arc<dyn Material>,
    stress: SymTensor,
    states: States,
    density: f64,
}

impl ContractPoint {
    /// Point with an initial stress.
    fn new(spec: &MaterialSpec, stress: SymTensor) -> Result<Self, String> {
        let law = spec.build().map_err(|error| error.to_string())?;
        let start = InitialCondition { stress, density: spec.density() };
        let (stresses, states) = law.initial(&[start]).map_err(|error| error.to_string())?;
        Ok(Self { law, stress: stresses[0], states, density: spec.density() })
    }

    /// Point with the stress of the contract tests; isotropic for laws that admit no initial shear.
    fn from_spec(spec: &MaterialSpec) -> Result<Self, String> {
        let start = SymTensor([-60e3, -50e3, -45e3, 3e3, -2e3, 1e3]);
        Self::new(spec, start).or_else(|_| Self::new(spec, SymTensor::isotropic(start.trace() / 3.0)))
    }

    /// Point after a motion.
    fn after_motion(&self, motion: &Motion) -> Result<Self, String> {
        let mut new = self.clone();
        let mut stress = [self.stress];
        let block = &mut new.states.blocks_mut()[0];
        let updated = new.law.update(std::slice::from_ref(motion), &mut stress, block);
        updated.map_err(|error| format!("{}: {error}", self.law.name()))?;
        (new.stress, new.density) = (stress[0], motion.density);
        Ok(new)
    }

    /// P-wave modulus (Pa).
    fn modulus(&self) -> f64 {
        let mut out = [0.0];
        self.law.wave_moduli(&[self.stress], &self.states.blocks()[0], &mut out);
        out[0]
    }

    /// Value of the yield function.
    fn yield_value(&self) -> f64 {
        let mut out = [0.0];
        self.law.yield_values(&[self.stress], &self.states.blocks()[0], &mut out);
        out[0]
    }

    /// Magnitude of the stresses in a step, of the initial one and of the elastic trial.
    fn stress_magnitude(&self, motion: &Motion) -> f64 {
        self.stress.norm() + self.modulus() * motion.velocity_gradient_dt.sym().norm()
    }
}

/// Random velocity gradient with entries up to `size`.
fn gradient(random: &mut RandomSequence, size: f64) -> Mat3 {
    Mat3(std::array::from_fn(|_| std::array::from_fn(|_| size * (2.0 * random.next_number() - 1.0))))
}

/// Motion with mid-step gradient `a`, density following the volume.
fn motion(a: &Mat3, density: f64) -> Result<Motion, String> {
    let dt = 1e-3;
    let mut motion = Motion::from_velocity_gradient(&(*a * (1.0 / dt)), dt, density, 0.1)
        .ok_or("the step is too large")?;
    motion.density = density / motion.deformation.determinant();
    Ok(motion)
}

/// Examples of all laws, wrapped laws included.
fn every_law() -> Vec<MaterialSpec> {
    MaterialSpec::examples().into_iter().chain(MaterialSpec::wrapped_examples()).collect()
}

/// Largest value of each model over its examples, in the order of the list.
fn worst_of_models(
    mut measure: impl FnMut(&MaterialSpec, &mut RandomSequence) -> Result<f64, String>,
) -> Result<Vec<(&'static str, usize, f64)>, String> {
    let mut worst: Vec<(&'static str, usize, f64)> = Vec::new();
    for spec in every_law() {
        let found = measure(&spec, &mut RandomSequence(11))?;
        match worst.iter_mut().find(|(name, ..)| *name == spec.name()) {
            Some((_, count, value)) => {
                *count += 1;
                *value = max_or_nan(*value, found);
            }
            None => worst.push((spec.name(), 1, found)),
        }
    }
    Ok(worst)
}

/// Checks that the stress of a rotated motion is the rotated stress.
fn objectivity(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let worst = worst_of_models(|spec, random| {
        let mut worst = 0f64;
        for _ in 0..PATHS {
            let here = ContractPoint::from_spec(spec)?;
            let angle = |random: &mut RandomSequence| 6.2 * random.next_number();
            let (s, c) = angle(random).sin_cos();
            let tilt = Mat3([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]);
            let q = Mat3::rotation_z(angle(random)) * tilt * Mat3::rotation_z(angle(random));
            let there = ContractPoint::new(spec, here.stress.rotated(&q))?;
            let step = motion(&gradient(random, 0.02), here.density)?;
            let turn = |m: &Mat3| q * *m * q.transpose();
            let turned = Motion {
                deformation: turn(&step.deformation),
                velocity_gradient_dt: turn(&step.velocity_gradient_dt),
                ..step
            };
            let (new, other) = (here.after_motion(&step)?, there.after_motion(&turned)?);
            let scale = here.stress_magnitude(&step).max(new.stress_magnitude(&step));
            worst = max_or_nan(worst, (other.stress - new.stress.rotated(&q)).norm() / scale);
        }
        Ok(worst)
    })?;
    for (name, set_count, found) in worst {
        let name = format!("V-02 {name} ({set_count} sets): a turned observer, {PATHS} random steps");
        let reason = "the sheet's 10⁻¹² per step, of the stress a step handles";
        outcome.assert_below(name, "0", found, 1e-12, reason);
    }
    Ok(())
}

/// Indices of the components xx yy zz xy yz zx.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// Largest difference between the tangent of a step and central differences of the update, over the larger of wave modulus and tangent.
/// Entries at which two differences disagree lie on a change of region and are left out.
fn tangent_error(walker: &ContractPoint, a: &Mat3, size: f64) -> Result<(f64, usize), String> {
    let at = motion(a, walker.density)?;
    let tangent = walker
        .law
        .tangent(&at, &walker.stress, &walker.states.blocks()[0], 0)
        .map_err(|error| error.to_string())?;
    let stiffest = tangent.0.iter().flatten().fold(walker.modulus(), |largest, c| largest.max(c.abs()));
    let stress = |column: usize, amount: f64| -> Result<SymTensor, String> {
        let (i, j) = PAIRS[column];
        let mut moved = *a;
        moved.0[i][j] += 0.5 * amount;
        moved.0[j][i] += 0.5 * amount;
        Ok(walker.after_motion(&motion(&moved, walker.density)?)?.stress)
    };
    let step = 1e-4 * size.max(1e-4);
    let (mut worst, mut compared) = (0f64, 0);
    for column in 0..6 {
        let slope = |step: f64| -> Result<SymTensor, String> {
            Ok((stress(column, step)? - stress(column, -step)?) * (0.5 / step))
        };
        let (wide, near) = (slope(2.0 * step)?, slope(step)?);
        for row in 0..6 {
            if (wide[row] - near[row]).abs() > 1e-6 * stiffest {
                continue;
            }
            let slope = near[row] + (near[row] - wide[row]) / 3.0;
            worst = max_or_nan(worst, (tangent.0[row][column] - slope).abs() / stiffest);
            compared += 1;
        }
    }
    Ok((worst, compared))
}

/// Checks tangents against difference quotients of the stress.
fn tangents(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut compared = 0;
    let worst = worst_of_models(|spec, random| {
        let mut worst = 0f64;
        for path in 0..PATHS {
            let start = ContractPoint::from_spec(spec)?;
            let walker = start.after_motion(&motion(&gradient(random, 2e-3), start.density)?)?;
            let size = [1e-5, 1e-3, 2e-2][path % 3];
            let a = gradient(random, size).sym().to_matrix();
            let (found, entries) = tangent_error(&walker, &a, size)?;
            compared += entries;
            worst = max_or_nan(worst, found);
        }
        Ok(worst)
    })?;
    for (name, set_count, found) in worst {
        let name = format!(
            "V-25 {name} ({set_count} sets): worst relative error of the tangent, {PATHS} random steps"
        );
        let reason = "the sheet's 10⁻⁶ away from switches of region, against central differences";
        outcome.assert_below(name, "0", found, 1e-6, reason);
    }
    let reason = "entries on a switch of region, where two differences disagree, are left out";
    outcome.info("V-25 entries compared", "no value", compared as f64, reason);
    Ok(())
}

/// Shows the number of parameter sets of the property tests, which run by `cargo test`, not here.
fn obligations(outcome: &mut BenchmarkOutcome) {
    let laws = every_law().len() as f64;
    for (obligation, test) in [
        ("no motion changes nothing, 10⁻¹⁴", "a_step_without_motion_keeps_the_stress"),
        ("objectivity, 10⁻¹²", "the_stress_rotates_with_the_observer, a_rigid_rotation_rotates_the_stress"),
        ("isotropy, 10⁻¹²", "permuted_axes_permute_the_stress"),
        ("yield, 10⁻⁹; finite stress", "stress_stays_finite_and_inside_the_yield_surface"),
        ("errors instead of NaN, no panic", "extreme_motions_are_refused_or_give_finite_stress"),
        ("dissipation, -10⁻¹²", "plastic_flow_dissipates"),
        ("two half steps, O(Δε²)", "two_half_steps_differ_from_one_by_the_square_of_the_step"),
        ("determinism on any thread", "the_same_input_gives_the_same_bits_on_any_thread"),
        ("tangents, 10⁻⁶", "tangents_are_the_slopes_of_the_update"),
    ] {
        let name = format!("V-26 {obligation}: sets of parameters tested");
        let reason =
            format!("a property test, run by cargo test: crates/constitutive/tests/suite/contract, {test}");
        outcome.info(name, "all", laws, &reason);
    }
}
