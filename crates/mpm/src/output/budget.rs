//! Budget of mass, momentum and energy of a run.

use colluvium_case::{Budget, PhaseBudget, spatial};

use crate::points::vectors::square;
use crate::solver::MpmSolver;
use crate::stress::stress_work::stored_energies;
use crate::transfer::affine_transfer::affine_energies;

impl<const D: usize> MpmSolver<D> {
    /// Total mass, momentum and energies of the points.
    pub(crate) fn collect_budget(&self) -> Budget {
        let mut budget = Budget::default();
        for set in &self.bodies.sets {
            let energies = stored_energies(set);
            if let Some(number) = set.rigid {
                let (rigid, mass) = (&self.boundary.driven[number].state.rigid, set.points.mass.iter().sum());
                rigid.add_rotation_energy(mass, set.extent[0], &mut budget);
            }
            for i in 0..set.len() {
                let (x, v, m) =
                    (spatial(&set.points.position[i]), spatial(&set.points.velocity[i]), set.points.mass[i]);
                budget.mass += m;
                budget.kinetic += 0.5 * m * square(&v);
                budget.elastic += energies[i];
                for c in 0..3 {
                    let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                    budget.momentum[c] += m * v[c];
                    budget.angular_momentum[c] += m * (x[a] * v[b] - x[b] * v[a]);
                    budget.potential -= m * self.clock.gravity[c] * x[c];
                    if self.clock.options.transfer == crate::VelocityTransfer::Apic && a < D && b < D {
                        // Spin within the point.
                        let moment = &set.points.affine_velocity[i];
                        budget.angular_momentum[c] += m * (moment[b][a] - moment[a][b]);
                    }
                }
            }
        }
        budget.kinetic += affine_energies(&self.clock, &self.background, &self.bodies).iter().sum::<f64>();
        self.add_liquid(&mut budget);
        budget
    }

    /// Adds the pore fluid to the totals.
    fn add_liquid(&self, budget: &mut Budget) {
        if self.two_phase.is_none() {
            return;
        }
        let mut liquid = PhaseBudget::default();
        for set in &self.bodies.sets {
            let Some(pore) = &set.pore else { continue };
            let Some(fluid) = pore.fluid else { continue };
            for i in 0..set.len() {
                let (x, v, m) =
                    (spatial(&set.points.position[i]), spatial(&pore.points.velocity[i]), set.liquid_mass(i));
                liquid.mass += m;
                liquid.kinetic += 0.5 * m * square(&v);
                let volume = set.porosity(i) * set.points.volume[i];
                liquid.elastic += 0.5 * pore.points.pressure[i].powi(2) / fluid.bulk_modulus * volume;
                for c in 0..3 {
                    let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                    liquid.momentum[c] += m * v[c];
                    budget.angular_momentum[c] += m * (x[a] * v[b] - x[b] * v[a]);
                    liquid.potential -= m * self.clock.gravity[c] * x[c];
                }
            }
        }
        budget.mass += liquid.mass;
        budget.kinetic += liquid.kinetic;
        budget.elastic += liquid.elastic;
        budget.potential += liquid.potential;
        for c in 0..3 {
            budget.momentum[c] += liquid.momentum[c];
        }
        budget.liquid = Some(liquid);
    }

    /// Whether the energy of the points is conserved apart from recorded dissipation, which excludes external work, a body force of
    /// the program, mass scaling and obstacle springs.
    pub(crate) fn is_energetically_closed(&self) -> bool {
        self.clock.options.mass_scaling <= 1.0
            && self.boundary.body_force.is_none()
            && self.clock.case.obstacles.is_empty()
            && self.clock.case.is_isolated(self.clock.stage)
            && self.bodies.sets.iter().all(|set| set.law_points().defines_energy())
    }
}
