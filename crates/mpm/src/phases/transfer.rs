//! Transfers of both phases, and the update of points between them (sheet: mpm §3.4).

use std::ops::Range;

use colluvium_case::SolverError;
use colluvium_constitutive::{BLOCK_SIZE, MotionBlock, SymTensor};
use colluvium_grid::{InterpolatedMotion, NodeRange, P2gPhaseInput, Vector4};

use crate::background_grid::BackgroundGrid;
use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::nodal_loads::apply_phase_nodal_loads;
use crate::boundary::point_loads::apply_loads;
use crate::boundary::prescribed_motion::impose_phase_patch_velocity_remapped;
use crate::clock::Clock;
use crate::momentum::velocity_fields::VelocitySource;
use crate::momentum::velocity_fields::VelocitySource::{EndOfStep, Remapped};
use crate::obstacles::obstacle_penalty::penalty_forces;
use crate::phases::TwoPhase;
use crate::points::bodies::Bodies;
use crate::points::point_blocks::{BlockReport, PointBlock, PointFailure, SetProperties, Workspace};
use crate::points::point_set::PointSet;
use crate::points::pore_fluid::{LIQUID, PoreFluidConstants, PoreSet, SOLID};
use crate::points::vectors::{first_three, vector4};
use crate::stress::averages::CellAverages;
use crate::stress::cell_integration::{add_cell_forces, average_stresses};
use crate::stress::force_columns::force_columns;
use crate::transfer::point_update::{Displacement, PointUpdater, UpdateSelection};

/// Point to grid (step 1), slab by slab.
pub(super) fn p2g_phases<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    boundary: &mut BoundaryConditions<D>,
    averages: &mut CellAverages<D>,
    phases: &mut TwoPhase,
) {
    apply_loads(clock, bodies, &boundary.load_starts);
    penalty_forces(clock, background, bodies, &mut boundary.penalty_obstacles);
    average_stresses(clock, background, bodies, &mut averages.stresses);
    let full_cells = averages.stresses.full_cells(0, background.cell_layout().len());
    let (sets, view) = (&bodies.sets, background.grid_view());
    background.layout.for_each_slab(&mut phases.nodes, |slab, window, offset| {
        let mut buffer = PhaseP2gBuffer::EMPTY;
        for set in sets {
            let Some(pore) = &set.pore else { continue };
            for block in set.blocks_of(slab) {
                buffer.fill(background, (set, pore), block.clone(), full_cells);
                let count = block.len();
                let input = P2gPhaseInput {
                    momentum_and_mass: &buffer.motion[..count],
                    stress_columns: &buffer.columns[..count],
                    body_force: &buffer.body[..count],
                };
                let to = NodeRange { nodes: &mut *window, first: offset };
                background.transfers.p2g_phases(&view, &set.point_slice().range(block), to, &input);
            }
        }
    });
    background.layout.sum_periodic_images(&mut phases.nodes, |sum, node| {
        for phase in [SOLID, LIQUID] {
            sum[phase].momentum_and_mass += node[phase].momentum_and_mass;
            sum[phase].force += node[phase].force;
        }
    });
    add_cell_forces(background, &averages.stresses, &mut phases.nodes);
    apply_phase_nodal_loads(clock, bodies, &boundary.nodal_loads, &boundary.load_starts, &mut phases.nodes);
}

/// Maps point velocities to the nodes, with walls: the updated velocities (step 6), or those at the `start` of the step.
pub(super) fn remap_phases<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    boundary: &BoundaryConditions<D>,
    phases: &mut TwoPhase,
    start: bool,
) {
    let TwoPhase { nodes, remapped_velocities: velocities, walls, .. } = phases;
    background.layout.reset(velocities);
    let BackgroundGrid { layout, transfers, .. } = background;
    let (view, sets) = (background.grid_view(), &bodies.sets);
    layout.for_each_slab(velocities, |slab, window, offset| {
        let mut momenta = [[Vector4::ZERO; 2]; BLOCK_SIZE];
        for set in sets {
            let Some(pore) = &set.pore else { continue };
            for block in set.blocks_of(slab) {
                for (p, momenta) in block.clone().zip(&mut momenta) {
                    *momenta = [
                        vector4(&set.points.velocity[p], 1.0) * set.points.mass[p],
                        vector4(&pore.points.velocity[p], 1.0) * set.liquid_mass(p),
                    ];
                }
                let to = NodeRange { nodes: &mut *window, first: offset };
                let momenta = &momenta[..block.len()];
                transfers.p2g_phase_values(&view, &set.point_slice().range(block), to, momenta);
            }
        }
    });
    background.layout.sum_periodic_images(velocities, |sum, node| {
        [SOLID, LIQUID].into_iter().for_each(|i| sum[i] += node[i]);
    });
    let walls = [&boundary.walls, &*walls];
    let row_length = layout.strides()[0];
    background.layout.for_each_active_node_range(velocities, |row, active, line| {
        for number in active {
            let index = layout.axis_indices(row, number);
            for phase in [SOLID, LIQUID] {
                let velocity = &mut line[number][phase];
                let mass = velocity.as_array()[3];
                let solved = match start {
                    true => Vector4::splat(f64::NAN),
                    false => nodes[row * row_length + number][phase].momentum_and_mass,
                };
                if mass <= 0.0 {
                    *velocity = Vector4::ZERO;
                    continue;
                }
                *velocity *= 1.0 / mass;
                let mut constrained = first_three(*velocity);
                walls[phase].constrain_remapped(&index, &first_three(solved), &mut constrained);
                *velocity = vector4(&constrained, 0.0);
            }
        }
    });
    impose_phase_patch_velocity_remapped(clock, background, &boundary.driven, &boundary.contacts, velocities);
}

/// Grid to point (steps 5, 7–9); returns the largest displacement along an axis (m).
pub(super) fn update_phases<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    boundary: &BoundaryConditions<D>,
    averages: &CellAverages<D>,
    (phases, read): (&TwoPhase, VelocitySource),
    selection: UpdateSelection,
) -> Result<f64, SolverError> {
    let update = PointUpdater { clock, background, strains: &averages.strains, has_wall: &boundary.has_wall };
    let new_workspace = || {
        Workspace::at_rest::<D>(
            [InterpolatedMotion::ZERO; 2],
            clock.dt,
            clock.options.band_cells() * background.grid.cell,
        )
    };
    bodies.update_blocks(clock, &new_workspace, |set, block, workspace| {
        update.phase_block((phases, read), set, block, workspace, selection)
    })
}

impl<const D: usize> PointUpdater<'_, D> {
    /// Updates both phases of a group of points from the grid, and their stresses.
    #[inline]
    fn phase_block(
        &self,
        (phases, read): (&TwoPhase, VelocitySource),
        set: &SetProperties<'_, D>,
        block: &mut PointBlock<'_, D>,
        Workspace { interpolated_motion: reads, motions }: &mut Workspace<[InterpolatedMotion<D>; 2]>,
        selection: UpdateSelection,
    ) -> BlockReport {
        if block.pressure.is_empty() {
            return Ok(0.0);
        }
        let (view, transfers, n) =
            (self.background.grid_view(), self.background.transfers, block.position.len());
        let reads = &mut reads[..n];
        let points = block.point_slice(&set.extent);
        match (read, selection.stress) {
            (EndOfStep, true) => transfers.g2p_phases(&view, &points, &phases.nodes, reads),
            (EndOfStep, false) => transfers.g2p_phase_motions(&view, &points, &phases.nodes, reads),
            (Remapped, _) => {
                transfers.g2p_phase_velocities(&view, &points, &phases.remapped_velocities, reads);
            }
        }
        let reads = &*reads;
        if selection.velocity {
            for (p, read) in reads.iter().enumerate() {
                self.update_velocity(&mut block.velocity[p], &read[SOLID]);
                if set.fluid.is_some() {
                    self.update_velocity(&mut block.liquid_velocity[p], &read[LIQUID]);
                }
            }
        }
        if selection.stress {
            self.deform_phases(set, block, reads, motions)?;
        }
        let mut moves = [Displacement::default(); BLOCK_SIZE];
        if selection.position {
            block.apply_pending_domains();
            self.add_seepage(set, block, reads);
            for (p, read) in reads.iter().enumerate() {
                moves[p] = self.move_point(block, p, read[SOLID].velocity.as_array());
            }
        }
        let moved = if selection.position { self.check_positions(set, block, &moves)? } else { 0.0 };
        if selection.stress {
            set.material.update_block(motions, block.stress, &mut block.states[0]).map_err(|error| {
                PointFailure { index: block.first + error.index, reason: error.source.into() }
            })?;
            self.cap_volumes(block.volume, block.initial_volume, block.stress);
        }
        Ok(moved)
    }

    /// Adds the seepage displacement of the fluid through the skeleton, for obstacles on points.
    fn add_seepage(
        &self,
        set: &SetProperties<'_, D>,
        block: &mut PointBlock<'_, D>,
        reads: &[[InterpolatedMotion<D>; 2]],
    ) {
        let Some(fluid) = &set.fluid else { return };
        let volumes = block.volume.iter().zip(block.initial_volume);
        for ((pore_contact, [solid, liquid]), (volume, initial)) in
            block.pore_contact.iter_mut().zip(reads).zip(volumes)
        {
            let factor = self.clock.dt * fluid.porosity_at(*volume, *initial);
            let (solid, liquid) = (solid.velocity.as_array(), liquid.velocity.as_array());
            (0..D).for_each(|c| pore_contact.seepage_displacement[c] += factor * (liquid[c] - solid[c]));
        }
    }

    /// Velocity update with FLIP and PIC (sheet: mpm §2.6), identical for both phases.
    #[inline(always)]
    fn update_velocity(&self, velocity: &mut [f64; D], read: &InterpolatedMotion<D>) {
        let (flip, dt) = (self.clock.flip_fraction, self.clock.dt);
        let (new, acceleration) = (read.velocity.as_array(), read.acceleration.as_array());
        for c in 0..D {
            velocity[c] = flip * (velocity[c] + dt * acceleration[c]) + (1.0 - flip) * new[c];
        }
    }

    /// Computes motions, volumes, pore pressures and domains of a group of points from interpolated values (steps 7 to 9).
    #[inline]
    fn deform_phases(
        &self,
        set: &SetProperties<'_, D>,
        block: &mut PointBlock<'_, D>,
        reads: &[[InterpolatedMotion<D>; 2]],
        motions: &mut MotionBlock,
    ) -> Result<(), PointFailure> {
        self.find_motions(block, reads.iter().map(|read| &read[SOLID]), motions);
        let mut failed = None;
        for (p, read) in reads.iter().enumerate() {
            let strains = if self.strains.is_shared() {
                let strains = self.shared_strain(set.body, &block.point_slice(&set.extent), p);
                self.set_dilation(motions, p, strains[SOLID], 0.0);
                strains
            } else {
                [SOLID, LIQUID]
                    .map(|phase| motions.dt * self.background.dilation(&read[phase], block.position[p][0]))
            };
            if let Some(fluid) = &set.fluid
                && let Err(reason) = update_pore_pressure(block, p, fluid, strains)
            {
                failed = Some(PointFailure { index: block.first + p, reason: reason.into() });
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
fn update_pore_pressure<const D: usize>(
    block: &mut PointBlock<'_, D>,
    p: usize,
    fluid: &PoreFluidConstants,
    [solid, liquid]: [f64; 2],
) -> Result<(), String> {
    // At the porosity before the step, as the sheet has it.
    let n = fluid.porosity_at(block.volume[p], block.initial_volume[p]);
    if !PoreFluidConstants::is_valid_porosity(n) {
        return Err(format!("its porosity has become {n}, outside the range 0.01 to 0.99"));
    }
    block.pressure[p] = fluid.pressure_after(block.pressure[p], n, solid, liquid);
    Ok(())
}

/// Contributions of a group of points to the nodes of two phases.
struct PhaseP2gBuffer<const D: usize> {
    motion: [[Vector4; 2]; BLOCK_SIZE],
    columns: [[[Vector4; D]; 2]; BLOCK_SIZE],
    body: [[Vector4; 2]; BLOCK_SIZE],
}

impl<const D: usize> PhaseP2gBuffer<D> {
    /// Buffer without contributions.
    const EMPTY: Self = Self {
        motion: [[Vector4::ZERO; 2]; BLOCK_SIZE],
        columns: [[[Vector4::ZERO; D]; 2]; BLOCK_SIZE],
        body: [[Vector4::ZERO; 2]; BLOCK_SIZE],
    };

    /// Computes the contributions of the points with indices `block`.
    #[inline(always)]
    fn fill(
        &mut self,
        background: &BackgroundGrid<D>,
        (set, pore): (&PointSet<D>, &PoreSet<D>),
        block: Range<usize>,
        full_cells: Option<&[bool]>,
    ) {
        let (points, domain, view) = (&set.points, set.domain.as_slice(), background.grid_view());
        for (k, p) in block.enumerate() {
            let volume = points.volume[p];
            let [liquid_mass, drag, full_mass] = pore.fluid.map_or([0.0; 3], |fluid| {
                let n = fluid.porosity_at(volume, points.initial_volume[p]);
                let values = [n * fluid.density, n * fluid.resistance, fluid.density];
                values.map(|value| value * volume)
            });
            self.motion[k] = [
                vector4(&points.velocity[p], 1.0) * points.mass[p],
                vector4(&pore.points.velocity[p], 1.0) * liquid_mass,
            ];
            let liquid_stress = SymTensor::isotropic(-pore.points.pressure[p]);
            let total_stress = set.total_stress(p);
            let is_in_full_cell =
                full_cells.is_some_and(|full| full[domain.cell(p, &view, &points.position[p])]);
            let own_volume = if is_in_full_cell { 0.0 } else { volume };
            self.columns[k] = [
                force_columns::<D>(&total_stress, own_volume),
                force_columns::<D>(&liquid_stress, own_volume),
            ];
            let load = |forces: &[[f64; D]]| forces.get(p).copied().unwrap_or([0.0; D]);
            let mut body =
                [vector4(&load(&points.traction), drag), vector4(&load(&pore.points.traction), full_mass)];
            if background.axisymmetric {
                let hoop = |stress: &SymTensor| -own_volume * stress[2] / points.position[p][0];
                body[SOLID] += Vector4::new([hoop(&total_stress), 0.0, 0.0, 0.0]);
                body[LIQUID] += Vector4::new([hoop(&liquid_stress), 0.0, 0.0, 0.0]);
            }
            if let (Some(solid), Some(liquid)) =
                (points.obstacle_contact.get(p), pore.points.obstacle_contact.get(p))
            {
                body[SOLID] += vector4(&solid.force, 0.0);
                body[LIQUID] += vector4(&liquid.force, 0.0);
            }
            self.body[k] = body;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MpmSolver;
    use crate::setup::tests::initial_solver;
    use colluvium_case::Case;
    use colluvium_points::ScratchBuffers;

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
        let mut solver = initial_solver::<1>(&case);
        solver.bodies.sets[0].retain_where(
            |points, i| (points.position[i][0] - 1.5).abs() > 1e-9,
            &mut ScratchBuffers::default(),
        );
        solver.sort();
        let MpmSolver { clock, background, bodies, boundary, averages, two_phase, .. } = &mut solver;
        let phases = two_phase.as_deref_mut().unwrap();
        clock.dt = 1e-3;
        p2g_phases(clock, background, bodies, boundary, averages, phases);
        [1, 2].map(|node| [SOLID, LIQUID].map(|phase| -phases.nodes[node][phase].force.as_array()[0]))
    }

    #[test]
    fn full_cells_exert_their_mean_total_stress_and_pressure_on_both_phases() {
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
