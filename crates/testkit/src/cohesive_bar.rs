//! Tension test of a bar of a material with localisation bands.

use std::ops::Range;

use colluvium_case::Solver;
use serde_json::{Value, json};

use crate::solver_runs::stresses;

/// Young's modulus (Pa). The bar is a fourth of `E G/f_t²` long, so that the crack opening is small against the point spacing.
pub const STIFFNESS: f64 = 1e8;
/// Tensile strength (Pa).
pub const STRENGTH: f64 = 1e3;
/// Fracture energy (J/m²).
pub const ENERGY: f64 = 0.04;
/// Density (kg/m³).
pub const DENSITY: f64 = 1000.0;
/// Length of the bar (m).
pub const LENGTH: f64 = 1.0;
/// Speed of the pulled end (m/s), a tenth of `f_t/√(E ρ)`.
pub const PULL_SPEED: f64 = 0.0003;
/// Tensile strength of the weak middle over that of the other parts.
pub const WEAK_STRENGTH_RATIO: f64 = 0.95;

/// Material with a share of the tensile strength and with a fracture energy (J/m²).
pub fn cohesive_material(share: f64, energy: f64) -> Value {
    json!({
        "model": "double-scale", "density": DENSITY, "youngs_modulus": STIFFNESS, "poissons_ratio": 0,
        "band": { "law": "cohesive-damage", "tensile_strength": share * STRENGTH, "fracture_energy": energy,
                  "stiffness": 1e4 * STRENGTH * STRENGTH / energy }
    })
}

/// Work of the pulled end over the fracture energy, up to six times the opening over which the strength falls to 1/e. The work is the mean
/// stress of the points between the abscissas `whole` (m), where no crack forms, times the displacement.
///
/// # Panics
/// When a step fails.
pub fn work_over_energy(solver: &mut dyn Solver, whole: &Range<f64>) -> f64 {
    let (mut before, mut sum) = (0.0, 0.0);
    while PULL_SPEED * solver.time() < 6.0 * ENERGY / STRENGTH {
        let from = solver.time();
        for _ in 0..20 {
            let step = solver.limit().dt;
            solver.step(step).unwrap();
        }
        let snapshot = solver.snapshot();
        let all = snapshot.positions.iter().zip(stresses(&snapshot));
        let of: Vec<f64> = all.filter(|(x, _)| whole.contains(&x[0])).map(|(_, s)| s[0]).collect();
        let mean = of.iter().sum::<f64>() / of.len() as f64;
        sum += 0.5 * (before + mean) * PULL_SPEED * (solver.time() - from);
        before = mean;
    }
    sum / ENERGY
}
