//! Pore fluid of a body, and its columns for the body's points.

use colluvium_constitutive::SymTensor;
use colluvium_points::struct_of_arrays;

use crate::points::point_set::PointSet;
use crate::points::pore_contact_state::PoreContactState;

/// Entry of the skeleton at a node; until the solve the fourth lane of its force is the drag `Q`.
pub const SOLID: usize = 0;
/// Entry of the liquid at a node; its mass is `M̄_L`, and until the solve the fourth lane of its force is `M_L`.
pub const LIQUID: usize = 1;

/// Range of porosities for which the mixture theory is valid (sheet: mpm §7).
const POROSITIES: [f64; 2] = [0.01, 0.99];

/// Constants of a pore fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoreFluidConstants {
    /// Density (kg/m³).
    pub density: f64,
    /// Bulk modulus (Pa).
    pub bulk_modulus: f64,
    /// Initial porosity of the skeleton.
    pub porosity: f64,
    /// Drag per Darcy velocity `ρ_L g / k` (Pa s/m²).
    pub resistance: f64,
    /// Least pressure, the cavitation pressure (Pa).
    pub min_pressure: f64,
}

impl PoreFluidConstants {
    /// Porosity of a point with the current volume `volume`: the volume of the grains is constant.
    #[inline(always)]
    pub fn porosity_at(&self, volume: f64, initial_volume: f64) -> f64 {
        1.0 - (1.0 - self.porosity) * initial_volume / volume
    }

    /// Pressure after the volumetric strains of both phases (sheet: mpm §2.9, step 8), at porosity `n`.
    #[inline(always)]
    pub fn pressure_after(&self, pressure: f64, n: f64, solid: f64, liquid: f64) -> f64 {
        let storage = ((1.0 - n) * solid + n * liquid) / n;
        (pressure - self.bulk_modulus * storage).max(self.min_pressure)
    }

    /// Whether a porosity is within the valid range.
    #[inline(always)]
    pub fn is_valid_porosity(porosity: f64) -> bool {
        // Written so that NaN counts as a failure.
        porosity > POROSITIES[0] && porosity < POROSITIES[1]
    }
}

struct_of_arrays! {
    /// Pore-fluid columns of the points.
    pub struct PoreColumns<const D: usize> {
        /// Velocities of the fluid (m/s).
        pub velocity: [f64; D],
        /// Pore pressures (Pa), compression-positive.
        pub pressure: f64,
        /// Forces of prescribed boundary pore pressures in the step (N); empty if there are none.
        pub traction: [f64; D],
        /// Contact states of the pore fluid; empty unless obstacles act on points.
        pub obstacle_contact: PoreContactState<D>,
    }
}

/// Pore fluid of a body, with columns in the order of the body's points.
pub struct PoreSet<const D: usize> {
    /// Constants of the pore fluid; `None` for a dry body in a case with saturated ones.
    pub fluid: Option<PoreFluidConstants>,
    /// Pore-fluid columns of the points.
    pub points: PoreColumns<D>,
}

/// Largest stable step (s) of an element of length `h` (m) by the combined criterion, and whether drag limits it (sheet: mpm §2.10).
/// `modulus` is that of the drained skeleton (Pa), `dry` its density `(1 - n) ρ_S` (kg/m³), `n` the porosity.
pub fn critical_step(fluid: &PoreFluidConstants, n: f64, dry: f64, modulus: f64, h: f64) -> (f64, bool) {
    let PoreFluidConstants { density, bulk_modulus, resistance, .. } = *fluid;
    let mixture = dry + n * density;
    let drag = n * mixture * resistance / (density * dry);
    let sum = 4.0
        * (n * mixture * bulk_modulus + (1.0 - 2.0 * n) * density * bulk_modulus + n * density * modulus)
        / (n * dry * density * h * h);
    let product = 16.0 * modulus * bulk_modulus / (dry * density * h.powi(4));
    let fastest = sum + (sum * sum - 4.0 * product).max(0.0).sqrt();
    // Form of the sheet without the difference of large numbers in its numerator.
    let step = 8.0 / (2.0 * drag + (4.0 * drag * drag + 8.0 * fastest).sqrt());
    (step, 4.0 * drag * drag > 8.0 * fastest)
}

/// Stable steps (s) of the undrained wave and of the drag, by the simple criterion (sheet: mpm §2.10): `L/c_1` with `c_1² = (E_c +
/// K_L/n)/ρ`, and `2 ρ̃ k/(ρ_L g)` with `ρ̃ = ρ + (1/n - 2) ρ_L`. The parameters are those of [`critical_step`].
pub fn simple_steps(fluid: &PoreFluidConstants, n: f64, dry: f64, modulus: f64, h: f64) -> [f64; 2] {
    let PoreFluidConstants { density, bulk_modulus, resistance, .. } = *fluid;
    let mixture = dry + n * density;
    let speed = ((modulus + bulk_modulus / n) / mixture).sqrt();
    [h / speed, 2.0 * (mixture + (1.0 / n - 2.0) * density) / resistance]
}

impl<const D: usize> PointSet<D> {
    /// Porosity of a point; zero for a dry point.
    pub fn porosity(&self, point: usize) -> f64 {
        let fluid = self.pore.as_ref().and_then(|pore| pore.fluid);
        fluid.map_or(0.0, |fluid| {
            fluid.porosity_at(self.points.volume[point], self.points.initial_volume[point])
        })
    }

    /// Pore pressure of a point (Pa); zero for a dry point.
    pub fn pore_pressure(&self, point: usize) -> f64 {
        self.pore.as_ref().map_or(0.0, |pore| pore.points.pressure[point])
    }

    /// Total stress of a point (Pa): effective stress minus pore pressure.
    pub fn total_stress(&self, point: usize) -> SymTensor {
        self.points.stress[point] - SymTensor::isotropic(self.pore_pressure(point))
    }

    /// Mass of the pore fluid of a point (kg).
    pub fn liquid_mass(&self, point: usize) -> f64 {
        let fluid = self.pore.as_ref().and_then(|pore| pore.fluid);
        fluid.map_or(0.0, |fluid| {
            let n = fluid.porosity_at(self.points.volume[point], self.points.initial_volume[point]);
            n * fluid.density * self.points.volume[point]
        })
    }

    /// Forces of prescribed pore pressures on the fluid of each point (N), in proportion to its volume fraction.
    pub fn pore_loads(&self) -> impl Iterator<Item = (usize, [f64; D])> {
        let forces = self.pore.iter().flat_map(|pore| pore.points.traction.iter().enumerate());
        forces.map(|(p, force)| (p, force.map(|c| self.porosity(p) * c)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fluid(porosity: f64, bulk_modulus: f64, conductivity: f64) -> PoreFluidConstants {
        let resistance = 1000.0 * 9.81 / conductivity;
        PoreFluidConstants {
            density: 1000.0,
            bulk_modulus,
            porosity,
            resistance,
            min_pressure: f64::NEG_INFINITY,
        }
    }

    #[test]
    fn critical_steps_are_those_of_the_sheet() {
        // sheet: mpm §2.10: n, rho_S, E_c, K_L, k, L, step by the formula.
        let table = [
            (0.4, 2650.0, 1e7, 2.15e9, 1e-3, 0.1, 5.095711e-5),
            (0.4, 2650.0, 1e7, 2.15e9, 1e-5, 0.1, 4.049846e-6),
            (0.4, 2650.0, 1e7, 2.15e9, 1e-7, 0.1, 4.072347e-8),
            (0.4, 2650.0, 5e9, 2.0e9, 1e-2, 0.05, 2.224362e-5),
            (0.4, 2650.0, 5e9, 2.0e9, 1e-5, 0.05, 3.944958e-6),
            (0.3, 2700.0, 1e8, 3e9, 1e-4, 0.01, 4.070237e-6),
            (0.4, 2650.0, 1e7, 2.15e9, 1e3, 0.1, 5.447947e-5),
        ];
        for (n, grains, modulus, bulk, k, h, exact) in table {
            let (step, _) = critical_step(&fluid(n, bulk, k), n, (1.0 - n) * grains, modulus, h);
            // Seven digits are printed.
            assert!((step / exact - 1.0).abs() < 2e-7, "k = {k}: {step:.7e} instead of {exact:.7e}");
        }
        assert!(critical_step(&fluid(0.4, 2.15e9, 1e-7), 0.4, 1590.0, 1e7, 0.1).1);
        assert!(!critical_step(&fluid(0.4, 2.15e9, 1e3), 0.4, 1590.0, 1e7, 0.1).1);
    }

    #[test]
    fn simple_steps_are_those_of_the_sheet() {
        // sheet: mpm §2.10, last column: n, rho_S, E_c, K_L, k, L, wave, drag.
        let table = [
            (0.4, 2650.0, 1e7, 2.15e9, 1e-3, 0.1, 6.0790e-5, 5.0765e-4),
            (0.4, 2650.0, 1e7, 2.15e9, 1e-5, 0.1, 6.0790e-5, 5.0765e-6),
            (0.4, 2650.0, 5e9, 2.0e9, 1e-2, 0.05, 2.2305e-5, 5.0765e-3),
            (0.3, 2700.0, 1e8, 3e9, 1e-4, 0.01, 4.6565e-6, 7.1831e-5),
        ];
        for (n, grains, modulus, bulk, k, h, wave, drag) in table {
            let steps = simple_steps(&fluid(n, bulk, k), n, (1.0 - n) * grains, modulus, h);
            // Five digits are printed.
            for (step, exact) in steps.into_iter().zip([wave, drag]) {
                assert!((step / exact - 1.0).abs() < 3e-5, "k = {k}: {step:.5e} instead of {exact:.5e}");
            }
        }
    }

    #[test]
    fn porosity_keeps_the_volume_of_the_grains() {
        let fluid = fluid(0.4, 1e9, 1e-3);
        assert!((fluid.porosity_at(2.0, 2.0) - 0.4).abs() < 1e-15);
        let shrunk = fluid.porosity_at(1.8, 2.0);
        assert!(((1.0 - shrunk) * 1.8 - 0.6 * 2.0).abs() < 1e-15);
    }

    #[test]
    fn without_drainage_pressure_rises_by_the_modulus_over_porosity() {
        let fluid = fluid(0.4, 2e9, 1e-3);
        assert!((fluid.pressure_after(100.0, 0.4, -1e-6, -1e-6) - 5100.0).abs() < 1e-9);
        let weak = PoreFluidConstants { min_pressure: -50.0, ..fluid };
        assert_eq!(weak.pressure_after(0.0, 0.4, 1e-6, 1e-6), -50.0);
    }
}
