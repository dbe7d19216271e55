//! The transfers of both phases, and what happens at the points in between (sheet: mpm §3.4).

use colluvium_case::SolverError;
use colluvium_constitutive::{BLOCK, Motions, SymTensor};
use colluvium_grid::{Gathered, Lanes, PhaseDeposit, Window};

use super::TwoPhase;
use crate::averages::Averages;
use crate::background::Background;
use crate::blocks::{Bench, Block, BlockReport, Failure, OfSet};
use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::clock::Clock;
use crate::driven::hold_phases_again;
use crate::loads::apply_loads;
use crate::mixed::{average_stresses, pull_with_cells};
use crate::nodal::load_phase_nodes;
use crate::nodes::Velocities::{self, Remapped, Solved};
use crate::pore::{Fluid, LIQUID, SOLID};
use crate::pressing::press;
use crate::transfer::force_columns;
use crate::update::{Moved, PointUpdate, UpdateOfPoints};
use crate::vectors::{lanes, three};

/// Point to grid (step 1), slab by slab.
pub(super) fn scatter_phases<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    boundary: &mut Boundary<D>,
    averages: &mut Averages<D>,
    phases: &mut TwoPhase,
) {
    apply_loads(clock, bodies, &boundary.load_starts);
    press(clock, background, bodies, &mut boundary.rocks);
    average_stresses(clock, background, bodies, &mut averages.stresses);
    let full = averages.stresses.full_cells(0, background.cell_layout().len());
    let Background { layout, sweeps, axisymmetric, .. } = background;
    let (sets, ground, axisymmetric) = (&bodies.sets, background.ground(), *axisymmetric);
    layout.scatter(&mut phases.nodes, |slab, window, offset| {
        let mut given = Given::NOTHING;
        for set in sets {
            let Some(pore) = &set.pore else { continue };
            let domain = set.domain.as_slice();
            for block in set.blocks_of(slab) {
                for (k, p) in block.clone().enumerate() {
                    let volume = set.points.volume[p];
                    let fluid = pore.fluid.map_or([0.0; 3], |fluid| {
                        let n = fluid.porosity_at(volume, set.points.initial_volume[p]);
                        let values = [n * fluid.density, n * fluid.resistance, fluid.density];
                        values.map(|value| value * volume)
                    });
                    let [liquid_mass, drag, full_mass] = fluid;
                    given.motion[k] = [
                        lanes(&set.points.velocity[p], 1.0) * set.points.mass[p],
                        lanes(&pore.points.velocity[p], 1.0) * liquid_mass,
                    ];
                    let liquid_stress = SymTensor::isotropic(-pore.points.pressure[p]);
                    let total = set.total_stress(p);
                    let left_to_cell =
                        full.is_some_and(|full| full[domain.cell(p, &ground, &set.points.position[p])]);
                    let pulling = if left_to_cell { 0.0 } else { volume };
                    given.columns[k] =
                        [force_columns::<D>(&total, pulling), force_columns::<D>(&liquid_stress, pulling)];
                    let of_loads = |forces: &[[f64; D]]| forces.get(p).copied().unwrap_or([0.0; D]);
                    let mut body = [
                        lanes(&of_loads(&set.points.traction), drag),
                        lanes(&of_loads(&pore.points.traction), full_mass),
                    ];
                    if axisymmetric {
                        let hoop = |stress: &SymTensor| -pulling * stress[2] / set.points.position[p][0];
                        body[SOLID] += Lanes::new([hoop(&total), 0.0, 0.0, 0.0]);
                        body[LIQUID] += Lanes::new([hoop(&liquid_stress), 0.0, 0.0, 0.0]);
                    }
                    if let (Some(pressed), Some(soaked)) =
                        (set.points.pressed.get(p), pore.points.soaked.get(p))
                    {
                        body[SOLID] += lanes(&pressed.force, 0.0);
                        body[LIQUID] += lanes(&soaked.force, 0.0);
                    }
                    given.body[k] = body;
                }
                let count = block.len();
                let (motion, columns) = (&given.motion[..count], &given.columns[..count]);
                let deposit = PhaseDeposit { motion, columns, body: &given.body[..count] };
                let to = Window { nodes: &mut *window, first: offset };
                sweeps.deposit_phases(&ground, &set.places().range(block), to, &deposit);
            }
        }
    });
    background.layout.fold(&mut phases.nodes, |sum, node| {
        for phase in [SOLID, LIQUID] {
            sum[phase].motion += node[phase].motion;
            sum[phase].force += node[phase].force;
        }
    });
    pull_with_cells(background, &averages.stresses, &mut phases.nodes);
    load_phase_nodes(clock, bodies, &boundary.nodal, &boundary.load_starts, &mut phases.nodes);
}

/// Maps the velocities of the points to the nodes, walls included: the updated ones back (step 6) or, at the `start` of
/// the step, those that there are.
pub(super) fn remap_phases<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    boundary: &Boundary<D>,
    phases: &mut TwoPhase,
    start: bool,
) {
    let TwoPhase { nodes, remapped, walls, .. } = phases;
    background.layout.reset(remapped);
    let Background { layout, sweeps, .. } = background;
    let (ground, sets) = (background.ground(), &bodies.sets);
    layout.scatter(remapped, |slab, window, offset| {
        let mut momenta = [[Lanes::ZERO; 2]; BLOCK];
        for set in sets {
            let Some(pore) = &set.pore else { continue };
            for block in set.blocks_of(slab) {
                for (p, momenta) in block.clone().zip(&mut momenta) {
                    *momenta = [
                        lanes(&set.points.velocity[p], 1.0) * set.points.mass[p],
                        lanes(&pore.points.velocity[p], 1.0) * set.liquid_mass(p),
                    ];
                }
                let to = Window { nodes: &mut *window, first: offset };
                let momenta = &momenta[..block.len()];
                sweeps.deposit_motions(&ground, &set.places().range(block), to, momenta);
            }
        }
    });
    background.layout.fold(remapped, |sum, node| [SOLID, LIQUID].into_iter().for_each(|i| sum[i] += node[i]));
    let walls = [&boundary.walls, &*walls];
    let row_length = layout.strides()[0];
    background.layout.each(remapped, |row, active, line| {
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
    hold_phases_again(clock, background, &boundary.driven, &boundary.contacts, remapped);
}

/// Grid to point (steps 5, 7–9); returns the largest move along an axis (m).
pub(super) fn update_phases<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    boundary: &Boundary<D>,
    averages: &Averages<D>,
    (phases, read): (&TwoPhase, Velocities),
    what: PointUpdate,
) -> Result<f64, SolverError> {
    let update = UpdateOfPoints { clock, background, strains: &averages.strains, closed: &boundary.closed };
    let bench = || {
        Bench::at_rest::<D>([Gathered::ZERO; 2], clock.dt, clock.options.band_cells() * background.grid.cell)
    };
    bodies.update_blocks(clock, &bench, |set, block, bench| {
        update.phase_block((phases, read), set, block, bench, what)
    })
}

impl<const D: usize> UpdateOfPoints<'_, D> {
    #[inline]
    fn phase_block(
        &self,
        (phases, read): (&TwoPhase, Velocities),
        set: &OfSet<'_, D>,
        block: &mut Block<'_, D>,
        Bench { reads, motions }: &mut Bench<[Gathered<D>; 2]>,
        what: PointUpdate,
    ) -> BlockReport {
        if block.pressure.is_empty() {
            return Ok(0.0);
        }
        let (ground, sweeps, n) = (self.background.ground(), self.background.sweeps, block.position.len());
        let reads = &mut reads[..n];
        let points = block.points(&set.extent);
        match (read, what.stress) {
            (Solved, true) => sweeps.gather_phases(&ground, &points, &phases.nodes, reads),
            (Solved, false) => sweeps.gather_motions(&ground, &points, &phases.nodes, reads),
            (Remapped, _) => sweeps.gather_velocities(&ground, &points, &phases.remapped, reads),
        }
        let reads = &*reads;
        if what.velocity {
            for (p, read) in reads.iter().enumerate() {
                self.follow_node(&mut block.velocity[p], &read[SOLID]);
                if set.fluid.is_some() {
                    self.follow_node(&mut block.liquid_velocity[p], &read[LIQUID]);
                }
            }
        }
        if what.stress {
            self.deform_phases(set, block, reads, motions)?;
        }
        let mut moves = [Moved::default(); BLOCK];
        if what.position {
            block.stretch_at_last();
            self.seep(set, block, reads);
            for (p, read) in reads.iter().enumerate() {
                moves[p] = self.move_point(block, p, read[SOLID].velocity.as_array());
            }
        }
        let moved = if what.position { self.settle(set, block, &moves)? } else { 0.0 };
        if what.stress {
            set.material.update_block(motions, block.stress, &mut block.states[0]).map_err(|error| {
                Failure { index: block.first + error.index, reason: error.source.to_string() }
            })?;
            self.cap_volumes(block.volume, block.initial_volume, block.stress);
        }
        Ok(moved)
    }

    /// Counts how far the fluid seeps through the skeleton, for obstacles on points.
    fn seep(&self, set: &OfSet<'_, D>, block: &mut Block<'_, D>, reads: &[[Gathered<D>; 2]]) {
        let Some(fluid) = &set.fluid else { return };
        let volumes = block.volume.iter().zip(block.initial_volume);
        for ((soaked, [solid, liquid]), (volume, initial)) in block.soaked.iter_mut().zip(reads).zip(volumes)
        {
            let way = self.clock.dt * fluid.porosity_at(*volume, *initial);
            let (solid, liquid) = (solid.velocity.as_array(), liquid.velocity.as_array());
            (0..D).for_each(|c| soaked.seep[c] += way * (liquid[c] - solid[c]));
        }
    }

    /// FLIP and PIC (sheet: mpm §2.6), alike for both phases.
    #[inline(always)]
    fn follow_node(&self, velocity: &mut [f64; D], read: &Gathered<D>) {
        let (flip, dt) = (self.clock.flip, self.clock.dt);
        let (new, acceleration) = (read.velocity.as_array(), read.acceleration.as_array());
        for c in 0..D {
            velocity[c] = flip * (velocity[c] + dt * acceleration[c]) + (1.0 - flip) * new[c];
        }
    }

    /// Motions, volumes, pore pressures and domains of a block from what its points have read (steps 7 to 9).
    #[inline]
    fn deform_phases(
        &self,
        set: &OfSet<'_, D>,
        block: &mut Block<'_, D>,
        reads: &[[Gathered<D>; 2]],
        motions: &mut Motions,
    ) -> Result<(), Failure> {
        self.find_motions(block, reads.iter().map(|read| &read[SOLID]), motions);
        let mut failed = None;
        for (p, read) in reads.iter().enumerate() {
            let strains = if self.strains.is_shared() {
                let strains = self.shared_strain(set.body, &block.points(&set.extent), p);
                self.set_dilation(motions, p, strains[SOLID], 0.0);
                strains
            } else {
                [SOLID, LIQUID]
                    .map(|phase| motions.dt * self.background.dilation(&read[phase], block.position[p][0]))
            };
            if let Some(fluid) = &set.fluid
                && let Err(reason) = press_liquid(block, p, fluid, strains)
            {
                failed = Some(Failure { index: block.first + p, reason });
                break;
            }
        }
        if set.fluid.is_some() {
            motions.pore_pressure[..reads.len()].copy_from_slice(block.pressure);
            motions.saturation.fill(1.0);
        }
        self.change_volumes(set, block, motions, failed)
    }
}

/// Pore pressure of a point (step 9) from the volumetric strains of both phases.
#[inline(always)]
fn press_liquid<const D: usize>(
    block: &mut Block<'_, D>,
    p: usize,
    fluid: &Fluid,
    [solid, liquid]: [f64; 2],
) -> Result<(), String> {
    // At the porosity before the step, as the sheet has it.
    let n = fluid.porosity_at(block.volume[p], block.initial_volume[p]);
    if !Fluid::holds(n) {
        return Err(format!("its porosity has become {n}, beyond 0.01 to 0.99"));
    }
    block.pressure[p] = fluid.pressure_after(block.pressure[p], n, solid, liquid);
    Ok(())
}

/// What a block of points gives to the nodes in two phases.
struct Given<const D: usize> {
    motion: [[Lanes; 2]; BLOCK],
    columns: [[[Lanes; D]; 2]; BLOCK],
    body: [[Lanes; 2]; BLOCK],
}

impl<const D: usize> Given<D> {
    const NOTHING: Self = Self {
        motion: [[Lanes::ZERO; 2]; BLOCK],
        columns: [[[Lanes::ZERO; D]; 2]; BLOCK],
        body: [[Lanes::ZERO; 2]; BLOCK],
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MpmSolver;
    use crate::dispatch::tests::begun;
    use colluvium_case::Case;
    use colluvium_points::Spare;

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
        let mut solver = begun::<1>(&case);
        solver.bodies.sets[0].retain(|x| (x[0] - 1.5).abs() > 1e-9, &mut Spare::default());
        solver.sort();
        let MpmSolver { clock, background, bodies, boundary, averages, two_phase, .. } = &mut solver;
        let phases = two_phase.as_deref_mut().unwrap();
        clock.dt = 1e-3;
        scatter_phases(clock, background, bodies, boundary, averages, phases);
        [1, 2].map(|node| [SOLID, LIQUID].map(|phase| -phases.nodes[node][phase].force.as_array()[0]))
    }

    #[test]
    fn full_cells_pull_at_both_phases_with_their_mean_total_stress_and_pressure() {
        // sheet: mpm S-04 with §2.16: total stress 2 Pa, of the liquid -5 Pa, a third of a cell missing.
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
