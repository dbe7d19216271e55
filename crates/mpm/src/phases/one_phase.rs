//! Nodes of one phase: dry material, or a mixture that moves as one (sheet: mpm §3.3).

use colluvium_case::SolverError;
use colluvium_grid::NodeWalls;

use crate::background_grid::BackgroundGrid;
use crate::boundary::boundary_conditions::{BoundaryConditions, work_of_loads};
use crate::boundary::nodal_loads::nodal_load_work;
use crate::boundary::point_loads::update_follower_loads;
use crate::boundary::{prescribed_motion, rigid_bodies};
use crate::clock::Clock;
use crate::contact::contact_correction::correct_velocities;
use crate::contact::contact_law::FieldContacts;
use crate::contact::rigid_contact::ContactContext;
use crate::momentum::consistent_mass;
use crate::momentum::consistent_mass::ConsistentMass;
use crate::momentum::small_mass_nodes::rescale_small_mass_forces;
use crate::momentum::velocity_fields::{VelocityFields, VelocitySource};
use crate::momentum::{EquilibriumAudit, EquilibriumTerms, MomentumSolve, damp};
use crate::obstacles::penetration_limit::{limit_remapped, limit_solved};
use crate::phases::nodal_phases::NodalPhases;
use crate::points::bodies::Bodies;
use crate::points::vectors::first_three;
use crate::stress::averages::CellAverages;
use crate::stress::free_surface::free_surface_correction;
use crate::stress::volumetric_strain::average_strains_of_one_phase;
use crate::transfer::affine_transfer::g2p_affine_of_rigid;
use crate::transfer::p2g::{P2gContent, p2g, remap, start_velocities};
use crate::transfer::point_update::{UpdateSelection, update_points};
use crate::transfer::xpic::filter_velocities;

/// Nodes of one phase in a step.
pub(crate) struct OnePhase<'a> {
    /// Velocity fields of the bodies.
    pub nodes: &'a mut VelocityFields,
    /// System of equations of the consistent mass matrix, unused with lumped mass.
    pub consistent: &'a mut ConsistentMass,
}

impl<const D: usize> NodalPhases<D> for OnePhase<'_> {
    fn p2g(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
        averages: &mut CellAverages<D>,
        content: P2gContent,
    ) {
        p2g(clock, background, bodies, self.nodes, boundary, averages, content);
    }

    fn start_velocities(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
        averages: &mut CellAverages<D>,
    ) {
        p2g(clock, background, bodies, self.nodes, boundary, averages, P2gContent::Motion);
        start_velocities(clock, background, bodies, self.nodes, boundary);
    }

    fn correct_free_surface(
        &mut self,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        averages: &mut CellAverages<D>,
    ) {
        free_surface_correction(background, bodies, &mut averages.free_surface);
    }

    fn rescale_small_mass_forces(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
    ) {
        rescale_small_mass_forces(clock, background, bodies, self.nodes);
    }

    fn solve_momentum(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
    ) -> Result<(), SolverError> {
        solve_momentum(clock, background, bodies, self.nodes, boundary, self.consistent)
    }

    fn remap(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
    ) {
        remap(clock, background, bodies, self.nodes, boundary);
    }

    fn limit_remapped(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
    ) {
        let obstacles = (&boundary.walls, &mut boundary.penalty_obstacles);
        limit_remapped(clock, background, bodies, self.nodes, obstacles);
    }

    fn average_strains(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        averages: &mut CellAverages<D>,
        source: VelocitySource,
    ) {
        average_strains_of_one_phase(clock, background, bodies, (self.nodes, source), &mut averages.strains);
    }

    fn update_follower_loads(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        source: VelocitySource,
    ) {
        update_follower_loads(clock, background, bodies, (self.nodes, source));
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
        update_points(clock, background, bodies, (self.nodes, source), boundary, averages, selection)
    }
}

/// Computes velocities at the end of the step and accelerations of the nodes (steps 2 to 4).
fn solve_momentum<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
    consistent: &mut ConsistentMass,
) -> Result<(), SolverError> {
    if consistent.is_used() {
        return consistent_mass::solve_momentum(
            clock,
            background,
            bodies,
            &mut nodes.nodal_states,
            &boundary.walls,
            consistent,
        );
    }
    solve_rows(clock, background, bodies.mass_cutoff(clock), nodes, boundary);
    let BoundaryConditions { walls, driven, contacts, absorbing, .. } = &mut *boundary;
    absorbing.apply(clock, &mut nodes.nodal_states, walls);
    rigid_bodies::impose_velocity_of_all_rigid(background, driven, contacts, &mut nodes.nodal_states);
    correct_contacts(clock, background, bodies, nodes, boundary);
    let BoundaryConditions { driven, contacts, .. } = &mut *boundary;
    prescribed_motion::impose_patch_velocity(
        clock,
        background,
        driven,
        contacts,
        &mut nodes.nodal_states,
        true,
    );
    damp_nodes(clock, background, bodies, nodes, boundary);
    let BoundaryConditions { walls, driven, contacts, penalty_obstacles, .. } = &mut *boundary;
    rigid_bodies::integrate_rigid(clock, driven);
    rigid_bodies::impose_rigid_velocity(background, driven, contacts, &mut nodes.nodal_states);
    limit_solved(clock, background, bodies, &mut nodes.nodal_states, (walls, penalty_obstacles));
    if clock.stage().equilibrium.is_some() {
        let sums = update_equilibrium(clock, background, bodies, nodes, boundary);
        nodes.external_work += sums.work;
        nodes.sums = sums;
    }
    if clock.options.filters_velocities() {
        filter_velocities(clock, background, bodies, nodes, boundary);
    }
    g2p_affine_of_rigid(clock, background, bodies, nodes);
    Ok(())
}

/// Solves the momentum equation of the active nodes with their walls and obstacles, and records the reactions of obstacles.
fn solve_rows<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    mass_cutoff: f64,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
) {
    let BoundaryConditions { walls, reaction_recorder, .. } = boundary;
    let solve = MomentumSolve {
        dt: clock.dt,
        gravity: clock.gravity_at_end(),
        rayleigh: clock.stage().rayleigh_damping,
        keep_initial_velocity: clock.keeps_initial_velocity(),
        inertia: clock.options.mass_scaling,
        mass_cutoff,
        walls,
        layout: &background.layout,
    };
    if let Some(recorder) = reaction_recorder {
        recorder.record(&solve, background, &nodes.nodal_states);
    }
    for nodes in nodes.nodal_states.chunks_exact_mut(background.layout.len()) {
        background.layout.for_each_active_node_range(nodes, |row, active, line| solve.row(row, active, line));
    }
}

/// Corrects the solved velocities for the contacts of bodies.
fn correct_contacts<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
) {
    let BoundaryConditions {
        walls, driven, contacts, row_contacts, rigid_contacts, penalty_obstacles, ..
    } = boundary;
    let mass_cutoff = bodies.mass_cutoff(clock);
    let context = ContactContext { clock, background, bodies, mass_cutoff, walls, contacts };
    let obstacles = penalty_obstacles.as_deref_mut().map_or(&mut [][..], |all| &mut all.obstacles[..]);
    correct_velocities(&context, &mut nodes.nodal_states, driven, row_contacts, (rigid_contacts, obstacles));
}

/// Updates the equilibrium sums of the step, with the work of loads and motions and the terms of free rigid bodies.
fn update_equilibrium<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &BoundaryConditions<D>,
) -> EquilibriumTerms {
    let BoundaryConditions { walls, driven, contacts, nodal_loads, load_starts, .. } = boundary;
    let mut sums = equilibrium_terms(clock, background, bodies.mass_cutoff(clock), nodes, walls, contacts);
    sums.work += work_of_loads(bodies, driven, clock.dt);
    for free_body in driven.iter().filter_map(|driven| driven.free_rigid_body.as_ref()) {
        let stage = clock.stage();
        sums.add(&rigid_bodies::equilibrium_terms(
            free_body,
            clock.dt,
            &stage.damping_of_axes(),
            stage.rayleigh_damping,
        ));
    }
    sums.work += nodal_load_work(clock, background, bodies, &nodes.nodal_states, nodal_loads, load_starts);
    sums
}

/// Applies local damping to the solved nodes. It depends on the unbalanced forces. Forces of walls, of contact, of driven bodies and of the
/// penetration limit are in balance with others, so that damping follows them. Prescribed components are not damped.
fn damp_nodes<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
) {
    let damping = clock.stage().damping_of_axes();
    if damping == [0.0; 3] {
        return;
    }
    let BoundaryConditions { walls, driven, contacts, penalty_obstacles, .. } = boundary;
    limit_solved(clock, background, bodies, &mut nodes.nodal_states, (walls, penalty_obstacles));
    let layout = &background.layout;
    for nodes in nodes.nodal_states.chunks_exact_mut(layout.len()) {
        layout.for_each_active_node_range(nodes, |row, active, line| {
            for number in active {
                let node = &mut line[number];
                let constrained = walls.constrained_components(
                    &layout.axis_indices(row, number),
                    &first_three(node.momentum_and_mass),
                );
                damp(node, &damping, constrained, clock.dt);
            }
        });
    }
    prescribed_motion::impose_patch_velocity(
        clock,
        background,
        driven,
        contacts,
        &mut nodes.nodal_states,
        false,
    );
}

/// Returns the measures of equilibrium from the solved nodes, contacts included (sheet: mpm §2.14).
fn equilibrium_terms<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    mass_cutoff: f64,
    nodes: &mut VelocityFields,
    walls: &NodeWalls,
    contacts: &FieldContacts,
) -> EquilibriumTerms {
    let stage = clock.stage();
    let audit = EquilibriumAudit {
        dt: clock.dt,
        gravity: clock.gravity_at_end(),
        damping: stage.damping_of_axes(),
        rayleigh: stage.rayleigh_damping,
        inertia: clock.options.mass_scaling,
        mass_cutoff,
        walls,
        layout: &background.layout,
    };
    let mut sums = EquilibriumTerms::default();
    let VelocityFields { nodal_states, row_sums, .. } = nodes;
    for (field, nodes) in nodal_states.chunks_exact_mut(background.layout.len()).enumerate() {
        if contacts.is_rigid(field) {
            continue;
        }
        background.layout.for_each_row(nodes, row_sums, |row, active, line| audit.row(row, active, line));
        row_sums.iter().for_each(|row| sums.add(row));
    }
    sums
}
