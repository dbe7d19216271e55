//! How far a stage is from static equilibrium (MPM sheet §2.14; Anura3D manual 2021, eqs. 6.29 and 6.30).

use colluvium_case::Equilibrium;
use colluvium_constitutive::BLOCK;
use colluvium_grid::Basis;

use crate::points::{PointDomain, PointSet, ground};
use crate::solver::MpmSolver;

/// Share of the reference scale below which external force or work is none.
const NONE: f64 = 1e-12;

/// What unbalanced force (N) and kinetic energy (J) are compared with where nothing acts from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scales {
    /// Root of the sum of the squares of stress times volume over spacing (N).
    pub force: f64,
    /// `Σ V |σ|² / 2 M` with the modulus of waves: what the stresses may hold (J).
    pub energy: f64,
}

/// A measure over what acts from outside, or over the reference scale where that is next to nothing.
pub fn over(value: f64, external: f64, reference: f64) -> f64 {
    let scale = if external > NONE * reference { external } else { reference };
    if value == 0.0 {
        0.0
    } else if scale > 0.0 {
        value / scale
    } else {
        f64::INFINITY
    }
}

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Unbalanced force and kinetic energy over what acts from outside; `None` where the stage does not ask.
    pub(crate) fn measure_equilibrium(&self) -> Option<Equilibrium> {
        self.case.stages[self.stage].equilibrium?;
        let (scales, traction) = (self.scales(), self.traction_square());
        if let Some(phases) = &self.two_phase {
            return Some(self.phase_equilibrium(phases, traction, scales));
        }
        let external = (self.sums.external + traction).sqrt();
        Some(Equilibrium {
            unbalanced_force: over(self.sums.unbalanced.sqrt(), external, scales.force),
            kinetic_ratio: over(self.sums.kinetic, self.external_work.abs(), scales.energy),
        })
    }

    fn scales(&self) -> Scales {
        let mut sums = Scales::default();
        for set in self.soft_sets() {
            let mut moduli = [0.0; BLOCK];
            for (block, (stresses, states)) in set.stress.chunks(BLOCK).zip(set.states.blocks()).enumerate() {
                set.material.wave_moduli(stresses, states, &mut moduli[..stresses.len()]);
                for (k, stress) in stresses.iter().enumerate() {
                    let p = block * BLOCK + k;
                    let spacing = set.domain[p].spacing(&ground!(self));
                    sums.force += (set.volume[p] / spacing * set.total_stress(p).norm()).powi(2);
                    if moduli[k] > 0.0 {
                        sums.energy += 0.5 * set.volume[p] * stress.dot(stress) / moduli[k];
                    }
                }
            }
        }
        Scales { force: sums.force.sqrt(), ..sums }
    }

    /// Sum of the squares of the tractions (N²).
    fn traction_square(&self) -> f64 {
        self.sets.iter().map(|set| square_sum(&set.traction)).sum()
    }
}

/// Sum of the squares of vectors.
pub fn square_sum<const D: usize>(vectors: &[[f64; D]]) -> f64 {
    vectors.as_flattened().iter().map(|c| c * c).sum()
}

/// Power of forces (N) on points that move (m/s).
pub fn power<const D: usize>(forces: &[[f64; D]], velocities: &[[f64; D]]) -> f64 {
    forces
        .as_flattened()
        .iter()
        .zip(velocities.as_flattened())
        .map(|(force, velocity)| force * velocity)
        .sum()
}

impl<const D: usize, P: PointDomain<D>> PointSet<D, P> {
    /// Forces of prescribed pore pressures on the fluid of each point, its share of the volume only (N).
    pub fn pore_loads(&self) -> impl Iterator<Item = (usize, [f64; D])> {
        let forces = self.pore.iter().flat_map(|pore| pore.traction.iter().enumerate());
        forces.map(|(p, force)| (p, force.map(|c| self.porosity(p) * c)))
    }
}
