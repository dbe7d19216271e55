//! Artificial stress where smoothing lengths vary (sheet: sph §2.5, §2.11).

use colluvium_case::Case;
use colluvium_constitutive::SymTensor;
use colluvium_sph::setup::rates_only::{ParticleRates, PrescribedParticle, rates};
use colluvium_testkit::case_with;
use serde_json::{Value, json};

const SYMMETRISATIONS: [&str; 7] = ["arithmetic", "harmonic", "geometric", "max", "min", "kernel", "grad-h"];

/// Block on a smooth wall, with artificial stress.
fn block(symmetrisation: &str, boundaries: &Value) -> Case {
    let text = json!({
        "title": "block", "space": "plane-strain", "domain": { "min": [0, -2], "max": [4, 4] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "sph": {
            "spacing": 0.1, "smoothing_length": "density", "symmetrisation": symmetrisation,
            "tensile": { "kind": "artificial-stress", "strength": 0.5, "exponent": 2.55 }
        } }
    });
    case_with(text, &json!({ "boundaries": boundaries }))
}

/// Pseudo-random number between -1 and 1.
fn jitter(id: u32, k: f64) -> f64 {
    2.0 * (f64::from(id + 1) * k).fract() - 1.0
}

/// Non-uniform tension.
fn tension(id: u32) -> SymTensor {
    let [a, b, c] = [0.618_033_988_75, 0.754_877_666_25, 0.569_840_290_998].map(|k| 1e3 * jitter(id, k));
    SymTensor([2e3 + a, 1.5e3 + b, 0.0, c, 0.0, 0.0])
}

/// Rates of a block scaled by `scale`, with the same masses and the same relative disorder.
fn scaled(symmetrisation: &str, scale: f64) -> Vec<ParticleRates<2>> {
    let case = block(symmetrisation, &json!([{ "side": "x-min", "wall": { "kind": "smooth" } }]));
    let given = |id: u32, x: &[f64; 2]| {
        let place = |c: usize, k: f64| scale * (x[c] + 0.01 * jitter(id, k)) - x[c];
        PrescribedParticle {
            displacement: [place(0, 0.819_172_513), place(1, 0.671_043_607)],
            velocity: [0.0; 2],
            compression: scale.powi(-2),
            stress: tension(id),
        }
    };
    let mut particles = rates::<2>(&case, given).unwrap();
    // Sorted by cell the particles have another order; each has a unique stress.
    particles.sort_by(|a, b| a.stress.0[0].total_cmp(&b.stress.0[0]));
    particles
}

/// All lengths scaled at the same stress and masses: areas over masses scale alike, and so do the accelerations.
#[test]
fn artificial_stress_is_the_same_share_of_the_stress_in_dilute_material() {
    for symmetrisation in SYMMETRISATIONS {
        let (dense, dilute) = (scaled(symmetrisation, 1.0), scaled(symmetrisation, 1.4));
        let size = dense.iter().map(|p| p.acceleration[0].hypot(p.acceleration[1])).fold(0.0, f64::max);
        for (one, other) in dense.iter().zip(&dilute) {
            for c in 0..2 {
                let off = other.acceleration[c] / 1.4 - one.acceleration[c];
                assert!(off.abs() < 1e-12 * size, "{symmetrisation}: {one:?} {other:?}");
            }
        }
    }
}

#[test]
fn artificial_stress_conserves_momentum_between_different_smoothing_lengths() {
    for symmetrisation in SYMMETRISATIONS {
        let given = |id: u32, _: &[f64; 2]| PrescribedParticle {
            displacement: [0.01 * jitter(id, 0.819_172_513), 0.01 * jitter(id, 0.671_043_607)],
            velocity: [0.0; 2],
            compression: 1.0 + 0.3 * jitter(id, 0.438_579_021),
            stress: tension(id),
        };
        let all = rates::<2>(&block(symmetrisation, &json!([])), given).unwrap();
        for c in 0..2 {
            let force = |p: &ParticleRates<2>| p.mass * p.acceleration[c];
            let (sum, size): (f64, f64) =
                (all.iter().map(force).sum(), all.iter().map(|p| force(p).abs()).sum());
            assert!(sum.abs() < 1e-12 * size, "{symmetrisation}: {sum} of {size} N");
        }
    }
}
