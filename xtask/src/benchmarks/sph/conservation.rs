//! Exact conservation properties of SPH sums (sheet: sph §5.3, V-10 to V-13 and V-20).

use colluvium::case::Case;
use colluvium::constitutive::SymTensor;
use colluvium::sph::setup::rates_only::{ParticleRates, PrescribedParticle, rates};
use serde_json::{Value, json};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, set_method_option};

/// Benchmark of momentum, energy and dissipation of particles in a random state.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/balance",
    title: "Momentum, energy and dissipation of a random state",
    source: "sheet: sph §5.3, V-10 to V-13 and V-20",
    short_seconds: Some(1),
    full_seconds: 1,
    run,
};

/// Number between -1 and 1 that varies irregularly with `id`.
fn scattered_number(id: u32, channel: u32) -> f64 {
    /// Multipliers of additive recurrences, whose fractional parts are low-discrepancy sequences.
    const STEPS: [f64; 3] = [0.618_033_988_749_894_9, 0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    let step = STEPS[channel as usize % 3];
    2.0 * (f64::from(id + 1) * step * f64::from(1 + channel / 3)).fract() - 1.0
}

/// Disordered state of a particle. `deviator` is one for stress of any kind and zero for pressure alone.
fn random(id: u32, deviator: f64) -> PrescribedParticle<2> {
    let s = |channel| scattered_number(id, channel);
    let pressure = 2e4 * s(3);
    let stress = [
        pressure + deviator * 1e4 * s(4),
        pressure + deviator * 1e4 * s(5),
        pressure + deviator * 1e4 * s(6),
        deviator * 1e4 * s(7),
        0.0,
        0.0,
    ];
    PrescribedParticle {
        displacement: [0.0; 2],
        velocity: [s(0), s(1)],
        compression: 1.0 + 0.1 * s(2),
        stress: SymTensor(stress),
    }
}

/// Case of a periodic box with changed options.
fn case_with_options(options: &[(&str, Value)]) -> Result<Case, String> {
    let mut case = load_case("sph/balance")?;
    for (name, value) in options {
        set_method_option(&mut case, "sph", name, value.clone());
    }
    Ok(case)
}

/// Rates of particles in a prescribed state.
fn evaluate(
    options: &[(&str, Value)],
    given: impl Fn(u32, &[f64; 2]) -> PrescribedParticle<2>,
) -> Result<Vec<ParticleRates<2>>, String> {
    rates::<2>(&case_with_options(options)?, given).map_err(|error| error.to_string())
}

/// Sum of a quantity over the particles.
fn total(particles: &[ParticleRates<2>], value: impl Fn(&ParticleRates<2>) -> f64) -> f64 {
    particles.iter().map(value).sum()
}

/// Largest component of the total force `Σ m a`, over `Σ m |a|`.
fn momentum(particles: &[ParticleRates<2>], value: impl Fn(&ParticleRates<2>) -> [f64; 2]) -> f64 {
    let sum = |c: usize| total(particles, |p| p.mass * value(p)[c]).abs();
    sum(0).max(sum(1)) / total(particles, |p| p.mass * value(p)[0].hypot(value(p)[1]))
}

/// Total torque `Σ m x × a` over `Σ m |x| |a|`, about the middle of the body.
fn torque(particles: &[ParticleRates<2>]) -> f64 {
    let arm = |p: &ParticleRates<2>| [p.position[0] - 0.5, p.position[1] - 0.5];
    let sum = total(particles, |p| p.mass * (arm(p)[0] * p.acceleration[1] - arm(p)[1] * p.acceleration[0]));
    let scale = total(particles, |p| {
        p.mass * arm(p)[0].hypot(arm(p)[1]) * p.acceleration[0].hypot(p.acceleration[1])
    });
    sum.abs() / scale
}

/// Power balance `Σ m v·a + Σ V σ:L`, over the sum of the sizes of its terms.
fn power(particles: &[ParticleRates<2>]) -> f64 {
    let terms = |p: &ParticleRates<2>| {
        let kinetic = p.mass * (p.velocity[0] * p.acceleration[0] + p.velocity[1] * p.acceleration[1]);
        let stress: f64 = (0..4).map(|k| p.stress.component(k / 2, k % 2) * p.gradient[k / 2][k % 2]).sum();
        [kinetic, p.mass / p.density * stress]
    };
    let sum = total(particles, |p| terms(p).iter().sum());
    sum.abs() / total(particles, |p| terms(p).iter().map(|t| t.abs()).sum())
}

/// Checks conserved momenta, energy balance, sign of the viscous power and the effect of alternating velocities.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    momenta(&mut outcome)?;
    energies(&mut outcome)?;
    viscosity(&mut outcome)?;
    checkerboard(&mut outcome)?;
    Ok(outcome)
}

/// Checks that momentum, angular momentum and the momentum of XSPH velocities are conserved.
fn momenta(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let viscous = [("viscosity_linear", json!(1.0)), ("viscosity_quadratic", json!(1.0))];
    for (name, options) in conservative_forms(&viscous) {
        let particles = evaluate(&options, |id, _| random(id, 1.0))?;
        let found = momentum(&particles, |p| p.acceleration);
        outcome.assert_below(format!("V-10, Σ m a over Σ m |a|: {name}"), "0", found, 1e-12, "V-10: 1e-12");
    }
    let particles = evaluate(&[], |id, _| random(id, 1.0))?;
    let found = momentum(&particles, |p| p.drift);
    let name = "V-10, Σ m times the velocity of XSPH, over its size";
    outcome.assert_below(name, "0", found, 1e-12, "V-10: 1e-12");
    let particles = evaluate(&[("momentum", json!("difference"))], |id, _| random(id, 1.0))?;
    let found = momentum(&particles, |p| p.acceleration);
    let name = "V-10, the form (57), which conserves nothing";
    outcome.info(name, "not 0", found, "not judged: for comparison");
    let particles = evaluate(&viscous, |id, _| random(id, 0.0))?;
    let name = "V-11, Σ m x × a over Σ m |x| |a|: isotropic stress";
    let reason = "V-11: pair forces are central when stress is isotropic";
    outcome.assert_below(name, "0", torque(&particles), 1e-12, reason);
    let particles = evaluate(&viscous, |id, _| random(id, 1.0))?;
    let reason = "not judged: V-11 has it reported; pair forces of deviatoric stress are not central (K15)";
    outcome.info("V-11, the same with deviatoric stress", "not 0", torque(&particles), reason);
    let particles = evaluate(&[("momentum", json!("corrected"))], |id, _| random(id, 1.0))?;
    let name = "V-11, the same with deviatoric stress, corrected on both sides";
    let reason = "pair forces are not central, but σ L M = σ is symmetric: their torques cancel";
    outcome.assert_below(name, "0", torque(&particles), 1e-12, reason);
    Ok(())
}

/// Options of the forms that conserve momentum, with their names.
fn conservative_forms(viscous: &[(&'static str, Value)]) -> [(&'static str, Vec<(&'static str, Value)>); 6] {
    let stress = json!({ "kind": "artificial-stress", "strength": 0.5, "exponent": 2.55 });
    let pressure = json!({ "kind": "artificial-pressure", "strength": 0.9, "exponent": 2.55 });
    let of_density =
        |form: &str| vec![("smoothing_length", json!("density")), ("symmetrisation", json!(form))];
    [
        ("(54), viscosity, artificial stress", [viscous, &[("tensile", stress)]].concat()),
        (
            "footnote 5, viscosity, artificial pressure",
            [viscous, &[("tensile", pressure), ("momentum", json!("rho-rho"))]].concat(),
        ),
        ("corrected on both sides", vec![("momentum", json!("corrected"))]),
        ("variable h, mean of kernels", of_density("kernel")),
        ("variable h, harmonic", of_density("harmonic")),
        ("variable h, gradient of h", of_density("grad-h")),
    ]
}

/// Checks that momentum and continuity operators are conjugate: the power of the stresses is the loss of kinetic energy.
fn energies(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let still = ("viscosity_linear", json!(0.0));
    let pairs: [(&str, Vec<(&str, Value)>); 4] = [
        ("(54) and operator 22", vec![still.clone()]),
        ("footnote 5 and operator 20", vec![still.clone(), ("momentum", json!("rho-rho"))]),
        ("operator 21 on both sides", vec![still.clone(), ("momentum", json!("corrected"))]),
        (
            "gradient of h",
            vec![still.clone(), ("smoothing_length", json!("density")), ("symmetrisation", json!("grad-h"))],
        ),
    ];
    for (name, options) in pairs {
        let found = power(&evaluate(&options, |id, _| random(id, 1.0))?);
        let name = format!("V-12, Σ m v·a + Σ V σ:L over its terms: {name}");
        outcome.assert_below(name, "0", found, 1e-12, "V-12: 1e-12 relative");
    }
    let found = power(&evaluate(&[still.clone(), ("velocity_gradient", json!("corrected"))], |id, _| {
        random(id, 1.0)
    })?);
    outcome.info("V-12, (54) and operator 21: no pair", "not 0", found, "not judged: for comparison");
    let forms = ["rho2", "rho-rho", "corrected"]
        .into_iter()
        .flat_map(|form| ["rough", "smooth"].map(|wall| (form, wall)));
    for (form, wall) in forms {
        let mut case = case_with_options(&[still.clone(), ("momentum", json!(form))])?;
        let text = json!({ "side": "y-min", "position": 0.3, "wall": { "kind": wall } });
        case.boundaries.push(serde_json::from_value(text).map_err(|error| error.to_string())?);
        case.bodies[0].shape =
            serde_json::from_value(json!({ "kind": "box", "min": [0.2, 0.3], "max": [0.6, 0.7] }))
                .map_err(|error| error.to_string())?;
        let particles = rates::<2>(&case, |id, _| random(id, 1.0)).map_err(|error| error.to_string())?;
        let name = format!("V-12, the same on a {wall} wall at rest, {form}");
        // Particles interact with their mirror images, which have their half of the pair.
        outcome.assert_below(name, "0", power(&particles), 1e-12, "V-12: with the pairwise mirror too");
    }
    Ok(())
}

/// Power of the viscosity: its contribution to `Σ m v·a`.
fn viscous_power(given: impl Fn(u32, &[f64; 2]) -> PrescribedParticle<2>) -> Result<f64, String> {
    let options = [("viscosity_linear", json!(1.0)), ("viscosity_quadratic", json!(2.0))];
    let particles =
        evaluate(&options, |id, x| PrescribedParticle { stress: SymTensor::ZERO, ..given(id, x) })?;
    Ok(total(&particles, |p| {
        p.mass * (p.velocity[0] * p.acceleration[0] + p.velocity[1] * p.acceleration[1])
    }))
}

/// Checks that artificial viscosity only dissipates, and acts in compression alone.
fn viscosity(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut worst = f64::NEG_INFINITY;
    for seed in 0..8 {
        worst = worst.max(viscous_power(|id, _| random(id + 1000 * seed, 1.0))?);
    }
    let reason = "V-13: never positive; the largest of eight random states";
    outcome.assert_below("V-13, power of the viscosity (W)", "below 0", worst, 0.0, reason);
    let expanding =
        viscous_power(|id, x| PrescribedParticle { velocity: [x[0] - 0.5, x[1] - 0.5], ..random(id, 0.0) })?;
    let reason = "V-13: zero where all particles part";
    outcome.assert_within("V-13, the same in an expansion", "0", expanding, (0.0, 0.0), reason);
    let turning =
        viscous_power(|id, x| PrescribedParticle { velocity: [0.5 - x[1], x[0] - 0.5], ..random(id, 0.0) })?;
    let reason = "V-13: exactly zero in exact arithmetic; the products of a turn cancel to round-off of 1e-16 of their \
                  size, and the power of a compression at the same speeds is of order 1e4 W";
    outcome.assert_within("V-13, the same in a rigid turn", "0", turning, (-1e-9, 0.0), reason);
    Ok(())
}

/// Checks that alternating velocities have no velocity gradient: the zero-energy mode of SPH.
fn checkerboard(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let particles = evaluate(&[], |_, x| {
        let number = |c: usize| (x[c] / 0.02 - 0.5).round() as i64;
        let sign = if (number(0) + number(1)) % 2 == 0 { 1.0 } else { -1.0 };
        PrescribedParticle {
            displacement: [0.0; 2],
            velocity: [sign, -sign],
            compression: 1.0,
            stress: SymTensor::ZERO,
        }
    })?;
    let inside = particles.iter().filter(|p| (p.position[0] - 0.5).hypot(p.position[1] - 0.5) < 0.24);
    let worst = inside.flat_map(|p| p.gradient.as_flattened()).map(|g| g.abs()).max_or_nan() * 0.02;
    let reason = "V-20: 1e-13 inside, in units of the velocity over the spacing";
    outcome.assert_below("V-20, velocity gradient of a checkerboard", "0", worst, 1e-13, reason);
    Ok(())
}
