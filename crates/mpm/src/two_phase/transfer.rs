//! The transfers of both phases, and what happens at the points in between (MPM sheet §3.4).

use colluvium_case::SolverError;
use colluvium_constitutive::{BLOCK, Motion, Pore, SymTensor};
use colluvium_grid::{Basis, Gathered, Lanes, Support};

use super::{Fluid, LIQUID, SOLID, TwoPhase};
use crate::blocks::{Block, BlockReport, Failure, OfSet};
use crate::contact::three;
use crate::points::{PointDomain, ground};
use crate::solver::MpmSolver;
use crate::strain::set_volumetric;
use crate::transfer::{Moved, PointUpdate, force_columns, lanes, still};

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Point to grid (step 1), slab by slab.
    pub(super) fn scatter_phases(&mut self, phases: &mut TwoPhase, dt: f64) {
        self.apply_loads(dt);
        self.average_stresses();
        let full = self.stresses.full_cells(0, self.cell_layout().len());
        let strides = self.layout.strides();
        let (sets, ground, axisymmetric) = (&self.sets, ground!(self), self.axisymmetric);
        self.layout.scatter(&mut phases.nodes, |slab, window, offset| {
            for set in sets {
                let Some(pore) = &set.pore else { continue };
                for p in set.slabs[slab]..set.slabs[slab + 1] {
                    let stencil = set.domain[p].support::<S, B>(&ground, &set.position[p], &set.extent);
                    let volume = set.volume[p];
                    let fluid = pore.fluid.map_or([0.0; 3], |fluid| {
                        let n = fluid.porosity_at(volume, set.initial_volume[p]);
                        [n * fluid.density, n * fluid.resistance, fluid.density].map(|value| value * volume)
                    });
                    let [liquid_mass, drag, full_mass] = fluid;
                    let motion = [
                        lanes(&set.velocity[p], 1.0) * set.mass[p],
                        lanes(&pore.velocity[p], 1.0) * liquid_mass,
                    ];
                    let liquid_stress = SymTensor::isotropic(-pore.pressure[p]);
                    let total = set.total_stress(p);
                    let left_to_cell = full.is_some_and(|full| {
                        full[set.domain[p].cell::<S, B>(&ground, &strides, &set.position[p])]
                    });
                    let pulling = if left_to_cell { 0.0 } else { volume };
                    let columns =
                        [force_columns::<D>(&total, pulling), force_columns::<D>(&liquid_stress, pulling)];
                    let of_loads = |forces: &[[f64; D]]| forces.get(p).copied().unwrap_or([0.0; D]);
                    let mut body =
                        [lanes(&of_loads(&set.traction), drag), lanes(&of_loads(&pore.traction), full_mass)];
                    if axisymmetric {
                        let hoop = |stress: &SymTensor| -pulling * stress[2] / set.position[p][0];
                        body[SOLID] += Lanes::new([hoop(&total), 0.0, 0.0, 0.0]);
                        body[LIQUID] += Lanes::new([hoop(&liquid_stress), 0.0, 0.0, 0.0]);
                    }
                    stencil.deposit_phases(window, offset, &strides, &motion, &columns, &body);
                }
            }
        });
        self.layout.fold(&mut phases.nodes, |sum, node| {
            for phase in [SOLID, LIQUID] {
                sum[phase].motion += node[phase].motion;
                sum[phase].force += node[phase].force;
            }
        });
        self.pull_phases_with_cells(&mut phases.nodes);
        self.load_phase_nodes(&mut phases.nodes, dt);
    }

    /// Maps the velocities of the points to the nodes, walls included: the updated ones back (step 6) or, at the `start` of
    /// the step, those that there are.
    pub(super) fn remap_phases(&mut self, phases: &mut TwoPhase, start: bool) {
        let TwoPhase { nodes, remapped, walls, .. } = phases;
        self.layout.reset(remapped);
        let strides = self.layout.strides();
        let (sets, ground) = (&self.sets, ground!(self));
        self.layout.scatter(remapped, |slab, window, offset| {
            for set in sets {
                let Some(pore) = &set.pore else { continue };
                for p in set.slabs[slab]..set.slabs[slab + 1] {
                    let stencil = set.domain[p].support::<S, B>(&ground, &set.position[p], &set.extent);
                    let momenta = [
                        lanes(&set.velocity[p], 1.0) * set.mass[p],
                        lanes(&pore.velocity[p], 1.0) * set.liquid_mass(p),
                    ];
                    stencil.deposit_motions(window, offset, &strides, &momenta);
                }
            }
        });
        self.layout.fold(remapped, |sum, node| [SOLID, LIQUID].into_iter().for_each(|i| sum[i] += node[i]));
        let walls = [&self.walls, &*walls];
        let (layout, row_length) = (&self.layout, strides[0]);
        self.layout.each(remapped, |row, active, line| {
            for number in active {
                let index = layout.index(row, number);
                for phase in [SOLID, LIQUID] {
                    let velocity = &mut line[number][phase];
                    let mass = velocity.as_array()[3];
                    let solved = match start {
                        true => Lanes::splat(f64::NAN),
                        false => nodes[row * row_length + number][phase].motion,
                    };
                    if mass <= 0.0 {
                        *velocity = Lanes::ZERO;
                        continue;
                    }
                    *velocity *= 1.0 / mass;
                    let mut held = three(*velocity);
                    walls[phase].constrain_again(&index, &three(solved), &mut held);
                    *velocity = lanes(&held, 0.0);
                }
            }
        });
        self.hold_phases_again(remapped);
    }

    /// Grid to point (steps 5, 7–9); returns the largest move along an axis (m).
    pub(super) fn update_phases<const FROM_SOLVED: bool>(
        &mut self,
        phases: &TwoPhase,
        dt: f64,
        what: PointUpdate,
    ) -> Result<f64, SolverError> {
        self.update_blocks(|solver, set, block| {
            solver.update_phase_block::<FROM_SOLVED>(phases, set, block, dt, what)
        })
    }

    #[inline]
    fn update_phase_block<const FROM_SOLVED: bool>(
        &self,
        phases: &TwoPhase,
        set: &OfSet<'_, D>,
        block: &mut Block<'_, D, P>,
        dt: f64,
        what: PointUpdate,
    ) -> BlockReport {
        if block.pressure.is_empty() {
            return Ok(0.0);
        }
        let (strides, ground) = (self.layout.strides(), ground!(self));
        let mut moves = [Moved::default(); BLOCK];
        let mut motions = [still(dt, set.extent[0]); BLOCK];
        let n = block.position.len();
        for p in 0..n {
            let stencil = block.domain[p].support::<S, B>(&ground, &block.position[p], &set.extent);
            let read = if FROM_SOLVED {
                stencil.gather_phases(&phases.nodes, &strides)
            } else {
                stencil.gather_velocities(&phases.remapped, &strides)
            };
            let velocity = read[SOLID].velocity.to_array();
            if what.velocity {
                self.follow_node(&mut block.velocity[p], &read[SOLID], dt);
                if set.fluid.is_some() {
                    self.follow_node(&mut block.liquid_velocity[p], &read[LIQUID], dt);
                }
            }
            if what.stress {
                let radius = block.position[p][0];
                let mut strains = [SOLID, LIQUID].map(|phase| dt * self.dilation(&read[phase], radius));
                let mut motion = still(dt, set.extent[0]);
                self.set_gradient(&mut motion, &read[SOLID].gradient, velocity[0], radius);
                if self.strains.is_shared() {
                    strains = self.shared_strain(set.body, &block.domain[p], &block.position[p]);
                    set_volumetric(&mut motion, self.normal_strains(), strains[SOLID]);
                }
                self.deform(block, p, &set.extent, &mut motion, set.fluid.as_ref(), strains)
                    .map_err(|reason| Failure { index: block.first + p, reason })?;
                motions[p] = motion;
            }
            if what.position {
                block.stretch_at_last(p);
                moves[p] = self.move_point(block, p, &velocity, dt);
            }
        }
        let moved = if what.position { self.settle(set, block, &moves)? } else { 0.0 };
        if what.stress {
            set.material.update(&motions[..n], block.stress, &mut block.states[0]).map_err(|error| {
                Failure { index: block.first + error.index, reason: error.source.to_string() }
            })?;
            self.cap_volumes(block.volume, block.initial_volume, block.stress);
        }
        Ok(moved)
    }

    /// FLIP and PIC (MPM sheet §2.6), alike for both phases.
    #[inline(always)]
    fn follow_node(&self, velocity: &mut [f64; D], read: &Gathered<D>, dt: f64) {
        let flip = self.flip;
        let (new, acceleration) = (read.velocity.as_array(), read.acceleration.as_array());
        for c in 0..D {
            velocity[c] = flip * (velocity[c] + dt * acceleration[c]) + (1.0 - flip) * new[c];
        }
    }

    /// Volume, porosity and pore pressure of a point (steps 8, 9), from the volumetric strains of both phases.
    #[inline(always)]
    fn deform(
        &self,
        block: &mut Block<'_, D, P>,
        p: usize,
        extent: &[f64; D],
        motion: &mut Motion,
        fluid: Option<&Fluid>,
        [solid, liquid]: [f64; 2],
    ) -> Result<(), String> {
        let stretch = motion.deformation.determinant();
        // Written so that NaN counts as a failure.
        if !(stretch > 0.0) {
            return Err(format!("the step would turn it inside out (volume ratio {stretch})"));
        }
        if let Some(fluid) = fluid {
            // At the porosity before the step, as the sheet has it.
            let n = fluid.porosity_at(block.volume[p], block.initial_volume[p]);
            if !Fluid::holds(n) {
                return Err(format!("its porosity has become {n}, beyond 0.01 to 0.99"));
            }
            block.pressure[p] = fluid.pressure_after(block.pressure[p], n, solid, liquid);
            motion.pore = Pore { pressure: block.pressure[p], saturation: 1.0 };
        }
        block.volume[p] *= stretch;
        motion.density = block.mass[p] / block.volume[p];
        let gradient: [[f64; D]; D] =
            std::array::from_fn(|i| std::array::from_fn(|j| motion.gradient.0[i][j]));
        block.stretch(p, &gradient);
        block.domain[p].fault(extent, self.grid.cell).map_or(Ok(()), Err)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::points::FixedDomain;
    use crate::setup;
    use colluvium_case::Case;
    use colluvium_grid::Linear;

    /// Internal forces (N) of mixture and liquid at the two inner nodes of a bar of three cells of 1 m with three points
    /// each under 7 Pa of effective stress and 5 Pa of pore pressure, without the middle point of the second cell.
    fn forces(integration: &str) -> [[f64; 2]; 2] {
        let text = serde_json::json!({
            "title": "bar", "space": "1d", "domain": { "min": [0], "max": [4] }, "gravity": [0],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [3] },
                         "stress": { "kind": "uniform", "value": [7, 0, 0, 0, 0, 0] },
                         "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1e-10,
                                         "pressure": { "kind": "uniform", "value": 5 } } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 1, "points_per_cell": 3, "shape": "linear", "integration": integration } }
        });
        let case = Case::from_json(&text.to_string()).unwrap();
        let options = setup::options(&case).unwrap();
        let mut solver = setup::solver::<1, 2, Linear, FixedDomain>(&case, &options).unwrap();
        solver.sets[0].retain(|x| (x[0] - 1.5).abs() > 1e-9);
        solver.sort();
        let mut phases = solver.two_phase.take().unwrap();
        solver.scatter_phases(&mut phases, 1e-3);
        [1, 2].map(|node| [SOLID, LIQUID].map(|phase| -phases.nodes[node][phase].force.as_array()[0]))
    }

    #[test]
    fn full_cells_pull_at_both_phases_with_their_mean_total_stress_and_pressure() {
        // MPM sheet S-04 with §2.16: total stress 2 Pa, of the liquid -5 Pa, a third of a cell missing.
        for (node, sign) in forces("points").into_iter().zip([1.0, -1.0]) {
            for (force, stress) in node.into_iter().zip([2.0, -5.0]) {
                assert!((force - sign * stress / 3.0).abs() < 1e-14, "{node:?}");
            }
        }
        for force in forces("mixed").as_flattened() {
            assert!(force.abs() < 1e-14, "{force}");
        }
    }
}
