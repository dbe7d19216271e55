//! Distance of a stage from static equilibrium (sheet: mpm §2.14).

use colluvium_case::{Equilibrium, EquilibriumScales};
use colluvium_constitutive::BLOCK_SIZE;

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::nodal_loads::nodal_load_squares;
use crate::momentum::EquilibriumTerms;
use crate::phases::{PhaseEquilibriumTerms, TwoPhase};
use crate::points::point_set::PointSet;
use crate::points::vectors::square_sum;
use crate::solver::MpmSolver;

impl<const D: usize> MpmSolver<D> {
    /// Ratios of unbalanced to external force and of kinetic energy to external work; `None` if the stage has no equilibrium criterion.
    pub(crate) fn measure_equilibrium(&self) -> Option<Equilibrium> {
        self.clock.stage().equilibrium?;
        let (scales, traction) = (self.equilibrium_scales(), self.traction_square());
        if let Some(phases) = &self.two_phase {
            return Some(self.phase_equilibrium(phases, traction, scales));
        }
        let external = (self.nodes.sums.external + traction).sqrt();
        Some(Equilibrium {
            unbalanced_force: scales.force_ratio(self.nodes.sums.unbalanced.sqrt(), external),
            kinetic_ratio: scales.energy_ratio(self.nodes.sums.kinetic, self.nodes.external_work),
            kinetic: self.nodes.sums.kinetic,
        })
    }

    /// Scales of force and energy for the equilibrium criterion, from the stresses and moduli of all points.
    fn equilibrium_scales(&self) -> EquilibriumScales {
        let mut scales = EquilibriumScales::default();
        for set in self.bodies.deformable_sets() {
            let mut moduli = [0.0; BLOCK_SIZE];
            for (block, (stresses, states)) in
                set.points.stress.chunks(BLOCK_SIZE).zip(set.states.blocks()).enumerate()
            {
                set.material.wave_moduli(stresses, states, &mut moduli[..stresses.len()]);
                for (k, stress) in stresses.iter().enumerate() {
                    let p = block * BLOCK_SIZE + k;
                    let spacing = set.domain.as_slice().spacing(p, &self.background.grid_view());
                    scales.add(set.points.volume[p], spacing, &set.total_stress(p), stress, moduli[k]);
                }
            }
        }
        scales
    }

    /// Sum of the squares of the tractions (N²).
    fn traction_square(&self) -> f64 {
        let BoundaryConditions { nodal_loads: nodal, load_starts, .. } = &self.boundary;
        let [on_nodes, _] = nodal_load_squares(&self.clock, &self.bodies, nodal, load_starts);
        self.bodies.sets.iter().map(|set| square_sum(&set.points.traction)).sum::<f64>() + on_nodes
    }

    /// Equilibrium ratios of mixture and liquid, the larger one of both (sheet: mpm §2.14). `traction` is the sum of the squared tractions
    /// (N²).
    fn phase_equilibrium(&self, phases: &TwoPhase, traction: f64, scales: EquilibriumScales) -> Equilibrium {
        let PhaseEquilibriumTerms { mixture, liquid } = &phases.sums;
        let of_mixture = (mixture.external + traction).sqrt();
        let pore_loads = self.bodies.sets.iter().flat_map(PointSet::pore_loads);
        let pore_loads: f64 = pore_loads.map(|(_, force)| square_sum(&[force])).sum();
        let BoundaryConditions { nodal_loads: nodal, load_starts, .. } = &self.boundary;
        let [_, on_nodes] = nodal_load_squares(&self.clock, &self.bodies, nodal, load_starts);
        let mut of_liquid = (liquid.external + pore_loads + on_nodes).sqrt();
        if of_liquid == 0.0 {
            // Without weight and pressures the liquid has no external force of its own.
            of_liquid = of_mixture;
        }
        let unbalanced =
            |sums: &EquilibriumTerms, external| scales.force_ratio(sums.unbalanced.sqrt(), external);
        Equilibrium {
            unbalanced_force: unbalanced(mixture, of_mixture).max(unbalanced(liquid, of_liquid)),
            kinetic_ratio: scales.energy_ratio(mixture.kinetic, self.nodes.external_work),
            kinetic: mixture.kinetic,
        }
    }
}
