//! Saturated bodies: skeleton and pore fluid move apart on one set of points, which follow the skeleton
//! (sheet: mpm §2.3, §3.4; "v–w" formulation with a single point set).
//!
//! A node holds both phases. The liquid's equation is per volume of liquid, the other one that of the mixture:
//!
//! ```text
//! M_L a_L = f_L - Q (v_L - v_S)          M_S a_S = f - M̄_L a_L
//! ```
//!
//! with `M_L = Σ N ρ_L Ω`, `M̄_L = Σ N n ρ_L Ω`, `M_S = Σ N m_S` and the drag `Q = Σ N n ρ_L g / k Ω`.
//! Here pore pressure is compression-positive, `p_w = -p_L` of the sheet.
//!
//! The module holds the operations of a step on the nodes of one phase and of two, with which `solver` runs the same step for both. It knows
//! all modules of the method below the solver; only `solver`, `setup` and `checkpoint` may know it.

mod damping;
mod momentum;
pub(crate) mod nodal_phases;
pub(crate) mod one_phase;
mod reactions;
mod setup;
mod transfer;
mod volumetric_strain;

use std::sync::Arc;

use colluvium_case::SolverError;
use colluvium_constitutive::BLOCK_SIZE;
use colluvium_grid::{InterpolatedMotion, Layout, NodalState, NodeFaces, NodeWalls, PointSlice, Vector4};

pub use crate::phases::momentum::PhaseEquilibriumTerms;
pub use crate::phases::setup::{check_supported, liquid_case, pore_set, two_phase};

use crate::background_grid::BackgroundGrid;
use crate::boundary::boundary_conditions::{BoundaryConditions, work_of_loads};
use crate::boundary::nodal_loads::phase_nodal_load_work;
use crate::boundary::point_loads::update_follower_vectors;
use crate::boundary::prescribed_motion::{impose_phase_patch_velocity, mark_constrained};
use crate::clock::Clock;
use crate::momentum::velocity_fields::VelocitySource::{EndOfStep, Remapped};
use crate::momentum::velocity_fields::{VelocityFields, VelocitySource};
use crate::obstacles::penetration_limit::{PenetrationLimit, with_mass};
use crate::phases::damping::Damping;
use crate::phases::momentum::PhaseSolve;
use crate::phases::nodal_phases::NodalPhases;
use crate::phases::reactions::record_phase_reactions;
use crate::phases::transfer::{p2g_phases, remap_phases, update_phases};
use crate::phases::volumetric_strain::average_phase_strains;
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;
use crate::points::pore_fluid::SOLID;
use crate::points::vectors::power;
use crate::stress::averages::CellAverages;
use crate::transfer::p2g::P2gContent;
use crate::transfer::point_update::UpdateSelection;

/// Nodal data of a solver with pore fluid.
pub struct TwoPhase {
    nodes: Vec<[NodalState; 2]>,
    remapped_velocities: Vec<[Vector4; 2]>,
    row_sums: Vec<PhaseEquilibriumTerms>,
    /// Components of velocity that patches prescribe, one bit an axis; empty where no option needs them.
    constrained_components: Vec<[u8; 2]>,
    /// Force and energy sums of the phases for the equilibrium criterion.
    pub(crate) sums: PhaseEquilibriumTerms,
    /// Walls of the liquid.
    pub(crate) walls: NodeWalls,
    /// Faces of obstacles on the nodes for the liquid.
    pub(crate) faces: Arc<NodeFaces>,
    /// Largest liquid mass of a point (kg).
    pub(crate) max_liquid_mass: f64,
}

impl TwoPhase {
    /// Memory of the nodes (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.remapped_velocities[..])
            + size_of_val(&self.row_sums[..])
            + size_of_val(&self.constrained_components[..])
    }

    /// Interpolates velocities and gradients of the nodes of both phases to points.
    fn g2p<const D: usize>(
        &self,
        of: VelocitySource,
        background: &BackgroundGrid<D>,
        points: &PointSlice<'_, D>,
        reads: &mut [[InterpolatedMotion<D>; 2]],
    ) {
        let (view, transfers) = (background.grid_view(), background.transfers);
        match of {
            EndOfStep => transfers.g2p_phases(&view, points, &self.nodes, reads),
            Remapped => transfers.g2p_phase_velocities(&view, points, &self.remapped_velocities, reads),
        }
    }

    /// Sets the active nodes of both phases to zero.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        layout.reset(&mut self.nodes);
        layout.reset(&mut self.remapped_velocities);
    }
}

impl TwoPhase {
    /// Computes the largest liquid mass of a point.
    pub fn find_heaviest<const D: usize>(&mut self, bodies: &Bodies<D>) {
        let masses = bodies.sets.iter().flat_map(|set| (0..set.len()).map(|p| set.liquid_mass(p)));
        self.max_liquid_mass = masses.fold(0.0, f64::max);
    }
}

/// Nodes of skeleton and pore fluid in a step (sheet: mpm §3.4).
pub(crate) struct SkeletonAndFluid<'a> {
    /// Velocity fields, whose account of external work both phases share.
    nodes: &'a mut VelocityFields,
    /// Nodes of both phases.
    phases: &'a mut TwoPhase,
}

impl<'a> SkeletonAndFluid<'a> {
    /// Nodes of both phases, cleared for a step.
    pub(crate) fn cleared<const D: usize>(
        background: &BackgroundGrid<D>,
        nodes: &'a mut VelocityFields,
        phases: &'a mut TwoPhase,
    ) -> Self {
        background.layout.reset(&mut phases.nodes);
        Self { nodes, phases }
    }
}

impl Drop for SkeletonAndFluid<'_> {
    fn drop(&mut self) {
        self.phases.walls.set_starts_moving(false);
    }
}

impl<const D: usize> NodalPhases<D> for SkeletonAndFluid<'_> {
    fn p2g(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
        averages: &mut CellAverages<D>,
        _content: P2gContent,
    ) {
        p2g_phases(clock, background, bodies, boundary, averages, self.phases);
    }

    fn start_velocities(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
        _averages: &mut CellAverages<D>,
    ) {
        remap_phases(clock, background, bodies, boundary, self.phases, true);
    }

    fn solve_momentum(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
    ) -> Result<(), SolverError> {
        solve_phases(clock, background, bodies, self.nodes, boundary, self.phases);
        Ok(())
    }

    fn remap(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
    ) {
        remap_phases(clock, background, bodies, boundary, self.phases, false);
    }

    fn limit_remapped(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
    ) {
        limit_remapped_penetration(clock, background, bodies, boundary, self.phases);
    }

    fn average_strains(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        averages: &mut CellAverages<D>,
        source: VelocitySource,
    ) {
        average_phase_strains(clock, background, bodies, &mut averages.strains, (self.phases, source));
    }

    fn update_follower_loads(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        source: VelocitySource,
    ) {
        update_follower_loads(clock, background, bodies, (self.phases, source));
    }

    fn update_points(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
        averages: &mut CellAverages<D>,
        (source, selection): (VelocitySource, UpdateSelection),
    ) -> Result<f64, SolverError> {
        update_phases(clock, background, bodies, boundary, averages, (self.phases, source), selection)
    }
}

/// Updates loads that follow the surface by the velocity of the skeleton.
fn update_follower_loads<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    (phases, read): (&TwoPhase, VelocitySource),
) {
    update_follower_vectors(clock, background, bodies, &|_, points, out| {
        let mut all = [[InterpolatedMotion::ZERO; 2]; BLOCK_SIZE];
        let reads = &mut all[..points.len()];
        phases.g2p(read, background, points, reads);
        out.iter_mut().zip(&*reads).for_each(|(out, read)| *out = read[SOLID]);
    });
}

/// Computes velocities at the end of the step and accelerations of both phases (steps 2 to 4).
fn solve_phases<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
    phases: &mut TwoPhase,
) {
    mark_patch_components(clock, background, boundary, phases);
    let BoundaryConditions {
        walls, driven, contacts, absorbing, reaction_recorder, penalty_obstacles, ..
    } = boundary;
    let TwoPhase {
        nodes: solved,
        row_sums,
        walls: liquid_walls,
        max_liquid_mass,
        constrained_components,
        ..
    } = phases;
    let dt = clock.dt;
    let solve = PhaseSolve {
        dt,
        gravity: clock.gravity_at_end(),
        keep_initial_velocity: clock.keeps_initial_velocity(),
        inertia: clock.options.mass_scaling,
        mass_cutoff: [bodies.mass_cutoff(clock), clock.options.mass_cutoff() * *max_liquid_mass],
        sum_equilibrium: clock.stage().equilibrium.is_some(),
        constrained_components,
        walls: [&*walls, &*liquid_walls],
        layout: &background.layout,
    };
    if let Some(recorder) = reaction_recorder {
        record_phase_reactions(recorder, &solve, background, solved);
    }
    background.layout.for_each_row(solved, row_sums, |row, active, line| solve.row(row, active, line));
    absorbing.apply_to_phases(clock, solved, [&*walls, &*liquid_walls]);
    impose_phase_patch_velocity(clock, background, driven, contacts, solved);
    let limit = PenetrationLimit { clock, background, bodies, walls, is_final: true };
    let change = |node: &mut [NodalState; 2], change| node[SOLID].change_velocity(change, dt);
    limit.limit_penetration(penalty_obstacles, solved, |_, node| node[SOLID].momentum_and_mass, change);
    let factors = clock.stage().damping_of_axes();
    if factors != [0.0; 3] {
        let PhaseSolve { mass_cutoff, constrained_components, walls, layout, .. } = solve;
        let damping = Damping { dt, factors, mass_cutoff, constrained_components, walls, layout };
        layout.for_each_active_node_range(solved, |row, active, line| damping.row(row, active, line));
        limit.limit_penetration(penalty_obstacles, solved, |_, node| node[SOLID].momentum_and_mass, change);
    }
    if clock.stage().equilibrium.is_some() {
        update_phase_equilibrium(clock, bodies, nodes, boundary, phases);
    }
}

/// Marks the velocity components that patches prescribe, if damping or the equilibrium criterion need them.
fn mark_patch_components<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    boundary: &BoundaryConditions<D>,
    phases: &mut TwoPhase,
) {
    let stage = clock.stage();
    phases.constrained_components.clear();
    let is_needed = stage.equilibrium.is_some() || stage.damping_of_axes() != [0.0; 3];
    if is_needed && !clock.case.patches.is_empty() {
        phases.constrained_components.resize(phases.nodes.len(), [0; 2]);
        let BoundaryConditions { driven, contacts, .. } = boundary;
        mark_constrained(clock, background, driven, contacts, &mut phases.constrained_components);
    }
}

/// Updates the equilibrium sums of the step, with the work of loads and prescribed motions.
fn update_phase_equilibrium<const D: usize>(
    clock: &Clock,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &BoundaryConditions<D>,
    phases: &mut TwoPhase,
) {
    let TwoPhase { nodes: solved, row_sums, sums, .. } = phases;
    let BoundaryConditions { driven, nodal_loads, load_starts, .. } = boundary;
    *sums = PhaseEquilibriumTerms::default();
    row_sums.iter().for_each(|row| sums.add(row));
    nodes.external_work +=
        sums.mixture.work + work_of_loads(bodies, driven, clock.dt) + work_of_pore_loads(bodies, clock.dt);
    nodes.external_work += phase_nodal_load_work(clock, bodies, nodal_loads, load_starts, solved);
}

/// Limits the penetration of points into obstacles by the re-mapped skeleton velocities, with which they move.
fn limit_remapped_penetration<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    boundary: &mut BoundaryConditions<D>,
    phases: &mut TwoPhase,
) {
    let BoundaryConditions { walls, penalty_obstacles, .. } = boundary;
    let TwoPhase { nodes, remapped_velocities, .. } = phases;
    let limit = PenetrationLimit { clock, background, bodies, walls, is_final: false };
    let of =
        |number: usize, own: &[Vector4; 2]| with_mass(own[SOLID], nodes[number][SOLID].momentum_and_mass);
    limit.limit_penetration(penalty_obstacles, remapped_velocities, of, |node, change| node[SOLID] += change);
}

/// Work of prescribed pore pressures on the fluid in the step (J) that exceeds that on the mixture.
fn work_of_pore_loads<const D: usize>(bodies: &Bodies<D>, dt: f64) -> f64 {
    let of_set = |set: &PointSet<D>| -> f64 {
        let Some(pore) = &set.pore else { return 0.0 };
        let seepage =
            |p: usize| std::array::from_fn(|c| pore.points.velocity[p][c] - set.points.velocity[p][c]);
        set.pore_loads().map(|(p, force)| power(&[force], &[seepage(p)])).sum()
    };
    dt * bodies.sets.iter().map(of_set).sum::<f64>()
}
