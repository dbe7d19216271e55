//! Measures of static equilibrium (sheet: mpm §2.14; Anura3D manual 2021, eqs. 6.29 and 6.30).

use colluvium_constitutive::SymTensor;
use thiserror::Error;

/// Share of the reference scale below which an external force counts as zero.
const NO_FORCE: f64 = 1e-12;
/// External work over the reference energy of the stresses, below which the work is no scale: a stage that begins at rest has almost none.
const MIN_WORK_RATIO: f64 = 1e-3;

/// Measures of the distance from static equilibrium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equilibrium {
    /// `|F_ext - F_int| / |F_ext|` over the free degrees of freedom.
    pub unbalanced_force: f64,
    /// Kinetic energy over the work of the external forces since the stage began.
    pub kinetic_ratio: f64,
    /// Kinetic energy of that ratio (J): of the nodes, in a method with a grid.
    pub kinetic: f64,
}

/// Reference scales of unbalanced force and kinetic energy, from the stresses at the points. They replace external actions where there are
/// none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EquilibriumScales {
    /// Sum of the squares of stress times volume over spacing (N²).
    force_square: f64,
    /// Reference energy of the stresses `Σ V |σ|² / 2 M` with the P-wave modulus (J).
    energy: f64,
}

impl EquilibriumScales {
    /// Adds a point to the reference scales: its volume (m³), spacing (m), total and effective stress (Pa), and P-wave modulus (Pa; zero
    /// where it has none).
    pub fn add(&mut self, volume: f64, spacing: f64, total: &SymTensor, effective: &SymTensor, modulus: f64) {
        self.force_square += (volume / spacing * total.norm()).powi(2);
        if modulus > 0.0 {
            self.energy += 0.5 * volume * effective.dot(effective) / modulus;
        }
    }

    /// Unbalanced force (N) over the external force, or over the reference where the external force is negligible.
    pub fn force_ratio(&self, unbalanced: f64, external: f64) -> f64 {
        let reference = self.force_square.sqrt();
        ratio(unbalanced, if external > NO_FORCE * reference { external } else { reference })
    }

    /// Kinetic energy (J) over the absolute external work (J), or over a thousandth of the reference energy where that is larger.
    pub fn energy_ratio(&self, kinetic: f64, work: f64) -> f64 {
        ratio(kinetic, work.abs().max(MIN_WORK_RATIO * self.energy))
    }
}

/// Ratio of a value to its scale: zero for a zero value, infinite for a zero scale.
fn ratio(value: f64, scale: f64) -> f64 {
    if value == 0.0 {
        0.0
    } else if scale > 0.0 {
        value / scale
    } else {
        f64::INFINITY
    }
}

/// End of a stage without the equilibrium that it requests.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "stages[{stage}]: no equilibrium within its duration of {duration} s (unbalanced force {unbalanced:.3e}, \
     kinetic energy {kinetic:.3e} of the external work)"
)]
pub struct MissedEquilibrium {
    /// Index of the stage.
    pub stage: usize,
    /// Duration of the stage (s).
    pub duration: f64,
    /// Unbalanced-force ratio at the end; NaN without one.
    pub unbalanced: f64,
    /// Kinetic-energy ratio at the end; NaN without one.
    pub kinetic: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_external_force_the_force_ratio_refers_to_the_internal_forces() {
        let mut scales = EquilibriumScales::default();
        assert_eq!((scales.force_ratio(1.0, 0.0), scales.energy_ratio(0.0, 0.0)), (f64::INFINITY, 0.0));
        let stress = SymTensor::diagonal(3.0, 0.0, 4.0);
        scales.add(2.0, 0.5, &stress, &stress, 10.0);
        assert_eq!((scales.force_ratio(10.0, 0.0), scales.force_ratio(10.0, 40.0)), (0.5, 0.25));
        // The reference energy is 2.5 J.
        assert_eq!((scales.energy_ratio(0.005, 1e-4), scales.energy_ratio(5.0, -10.0)), (2.0, 0.5));
    }
}
