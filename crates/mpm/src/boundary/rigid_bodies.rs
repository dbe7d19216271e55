//! Time step of rigid bodies, with prescribed motion or under forces (docs/theory/mpm.md, rigid bodies).

use colluvium_case::description::{PrescribedMotion, Velocity};
use colluvium_case::loads::damping::sign_or_zero;
use colluvium_case::rigid::{RigidBodyActions, RigidMass, RigidState, RigidStep, multiply};
use colluvium_case::{FailureReason, SolverError, spatial};
use colluvium_grid::{NodalState, Vector4};

use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::config::LagrangianFormulation;
use crate::contact::contact_law::FieldContacts;
use crate::momentum::EquilibriumTerms;
use crate::momentum::driven_object::DrivenObject;
use crate::points::bodies::{Bodies, point_error};
use crate::points::point_set::PointSet;

/// Mass and moments of inertia of a rigid body, with mass scaling.
fn rigid_mass<const D: usize>(clock: &Clock, set: &PointSet<D>) -> RigidMass {
    RigidMass::of_points(&set.points.mass, &set.points.position, set.extent[0])
        .scaled(clock.options.mass_scaling)
}

/// Returns the step of a free rigid body from its state at the start and the external forces.
fn free_rigid_step<const D: usize>(
    clock: &Clock,
    set: &PointSet<D>,
    motion: &PrescribedMotion,
    state: &RigidState,
) -> RigidStep {
    let own = set.points.mass.iter().sum::<f64>();
    let weight = clock.gravity_at_end().map(|g| own * g);
    let elapsed = clock.time + clock.dt - clock.stage_start;
    let acts = RigidBodyActions::of_motion(motion, elapsed, D, (&weight, &[0.0; 3]));
    let share = clock.dt * clock.stage().rayleigh_damping;
    RigidStep::new(rigid_mass(clock, set), state, &acts, clock.dt, share)
}

/// Terms of a free rigid body in the measures of equilibrium in a step of `dt` (s), with local damping of the axes and Rayleigh damping.
pub fn equilibrium_terms(
    free_body: &RigidStep,
    dt: f64,
    damping: &[f64; 3],
    rayleigh: f64,
) -> EquilibriumTerms {
    let mut sums = EquilibriumTerms { work: free_body.work(dt), ..EquilibriumTerms::default() };
    for c in (0..3).filter(|c| free_body.free_components[*c]) {
        let (start, end) = (free_body.start[c], free_body.motion[c]);
        let net = free_body.mass.mass * ((end - start) / dt + rayleigh * 0.5 * (start + end));
        let unbalanced = net / (1.0 - damping[c] * sign_or_zero(start) * sign_or_zero(net));
        sums.unbalanced += unbalanced * unbalanced;
        sums.external += free_body.applied_wrench[c] * free_body.applied_wrench[c];
    }
    let momentum = multiply(&free_body.mass.matrix(), &free_body.motion);
    sums.kinetic = 0.5 * (0..6).map(|k| momentum[k] * free_body.motion[k]).sum::<f64>();
    sums
}

/// Updates the velocities of rigid bodies and patches to the end of the step, and resets their forces.
pub fn update_driven_velocities<const D: usize>(
    clock: &Clock,
    bodies: &mut Bodies<D>,
    driven: &mut [DrivenObject],
) {
    let stage = clock.stage();
    let elapsed = clock.time + clock.dt - clock.stage_start;
    for (number, driven) in driven.iter_mut().enumerate() {
        let program_velocity = driven.state.program_velocity;
        let motion = stage.motion_of(&driven.name).filter(|_| program_velocity.is_none());
        driven.previous_velocity = driven.state.velocity;
        driven.state.force = [0.0; 3];
        let set = bodies.sets.iter().find(|set| set.rigid == Some(number));
        let free = motion.filter(|motion| motion.is_free()).zip(set);
        driven.free_rigid_body =
            free.map(|(motion, set)| free_rigid_step(clock, set, motion, &driven.state.rigid));
        if let Some(free_body) = &driven.free_rigid_body {
            driven.state.rigid.velocity = free_body.velocity();
        } else {
            let state = &mut driven.state;
            let of_case = || motion.map_or([None; 3], |motion| motion.velocity_at(elapsed));
            state.velocity = program_velocity.map_or_else(of_case, |velocity| velocity.map(Some));
            state.rigid.set_at_rest();
            state.rigid.velocity = state.velocity.map(|v| v.unwrap_or(0.0));
        }
    }
    for set in &mut bodies.sets {
        let Some(number) = set.rigid.filter(|number| driven[*number].free_rigid_body.is_none()) else {
            continue;
        };
        let velocity = driven[number].velocity();
        set.points.velocity.fill(std::array::from_fn(|c| velocity[c]));
    }
}

/// Moves rigid bodies and patches at the end of the step. Returns the largest displacement of a point along an axis (m).
///
/// # Errors
/// When a point of a rigid body leaves the domain or the mesh.
pub fn move_driven<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    driven: &mut [DrivenObject],
) -> Result<f64, SolverError> {
    let (mut moved, dt) = (0f64, clock.dt);
    for driven in &mut *driven {
        let velocity = driven.velocity();
        (0..3).for_each(|c| driven.state.displacement[c] += dt * velocity[c]);
    }
    let (view, mut lost) = (background.grid_view(), None);
    if clock.options.formulation == LagrangianFormulation::SmallDisplacement {
        for set in &mut bodies.sets {
            let Some(number) = set.rigid else { continue };
            for (x, origin) in set.points.position.iter().zip(&mut set.points.origin) {
                let velocity = driven[number].velocity_at(&spatial(x));
                (0..D).for_each(|c| origin[c] -= dt * velocity[c]);
            }
        }
        return Ok(0.0);
    }
    let within = !background.is_meshed() && background.periodic == [false; D];
    for (place, set) in bodies.sets.iter_mut().enumerate() {
        let Some(number) = set.rigid else { continue };
        let anchored = set.domain.are_anchored();
        moved = moved.max(move_rigid(dt, set, &mut driven[number]));
        let mut domain = set.domain.as_mut();
        for (p, position) in set.points.position.iter_mut().enumerate() {
            let mut settled = domain.relocate(p, &view, position);
            if within && !anchored && !background.grid.contains(position) {
                settled = Err("a rigid body left the domain: enlarge the domain".to_owned());
            }
            lost = lost.or(settled.err().map(|reason| (place, p, reason)));
        }
    }
    match lost {
        Some((set, point, reason)) => {
            Err(point_error(clock, &bodies.sets[set], point, FailureReason::LeftDomain(reason)))
        }
        None => Ok(moved),
    }
}

/// Moves a rigid body in a step of `dt`; returns the largest displacement of a point along an axis (m).
fn move_rigid<const D: usize>(dt: f64, set: &mut PointSet<D>, driven: &mut DrivenObject) -> f64 {
    let velocity = driven.velocity();
    let Some(free_body) = &driven.free_rigid_body else {
        set.points.position.iter_mut().for_each(|x| (0..D).for_each(|c| x[c] += dt * velocity[c]));
        return velocity.iter().fold(0.0, |largest, v| largest.max((dt * v).abs()));
    };
    free_body.move_points(dt, &mut driven.state.rigid, &mut set.points.position, &mut set.points.velocity);
    set.points.velocity.as_flattened().iter().fold(0.0, |largest, v| largest.max((dt * v).abs()))
}

/// Sets the initial motion of rigid bodies.
pub fn initialise_rigid<const D: usize>(clock: &Clock, sets: &[PointSet<D>], driven: &mut [DrivenObject]) {
    for set in sets {
        let Some(number) = set.rigid else { continue };
        let given = &clock.case.bodies[set.body as usize].velocity;
        let (mass, points) = (rigid_mass(clock, set), &set.points);
        driven[number].state.rigid = if *given == Velocity::Rest {
            // Points from a file may have velocities.
            RigidState::of_points(&mass, &points.mass, &points.position, &points.velocity)
        } else {
            RigidState::initial(&mass, given)
        };
    }
}

/// Integrates the motion of the free rigid bodies over the step, with local damping.
pub fn integrate_rigid(clock: &Clock, driven: &mut [DrivenObject]) {
    let damping = clock.stage().damping_of_axes();
    for driven in driven {
        let Some(free_body) = &mut driven.free_rigid_body else { continue };
        free_body.damp(&damping);
        free_body.apply(&mut driven.state.rigid);
    }
}

/// Sets the velocities of free rigid bodies to zero.
pub fn stop_free_rigid_bodies(driven: &mut [DrivenObject]) {
    for driven in driven.iter_mut().filter(|driven| driven.patch.is_none()) {
        driven.state.rigid.set_at_rest();
    }
}

/// Calls `visit(velocity of the body, node)` at all nodes of free rigid bodies.
fn for_free_rigid_nodes<T: Send, const D: usize>(
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
    contacts: &FieldContacts,
    nodes: &mut [T],
    visit: impl Fn([f64; 3], &mut T) + Sync,
) {
    let (len, row_length) = (background.layout.len(), background.layout.strides()[0]);
    for (field, number) in contacts.rigid.iter().enumerate() {
        let Some(free_body) = number.and_then(|number| driven[number].free_rigid_body.as_ref()) else {
            continue;
        };
        background.layout.for_each_active_node_range(
            &mut nodes[field * len..(field + 1) * len],
            |row, active, line| {
                for number in active {
                    let index = background.layout.axis_indices(row, number);
                    let x = background.node_at(row * row_length + number, &index);
                    visit(free_body.velocity_at(&x), &mut line[number]);
                }
            },
        );
    }
}

/// Imposes the velocity of free rigid bodies on their solved nodes.
pub fn impose_rigid_velocity<const D: usize>(
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
    contacts: &FieldContacts,
    solved: &mut [NodalState],
) {
    for_free_rigid_nodes(background, driven, contacts, solved, |[x, y, z], node| {
        let mass = node.momentum_and_mass.as_array()[3];
        *node = NodalState { momentum_and_mass: Vector4::new([x, y, z, mass]), force: Vector4::ZERO };
    });
}

/// Imposes the velocity of free rigid bodies on their re-mapped nodes.
pub fn impose_rigid_velocity_remapped<const D: usize>(
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
    contacts: &FieldContacts,
    remapped: &mut [Vector4],
) {
    for_free_rigid_nodes(background, driven, contacts, remapped, |[x, y, z], node| {
        *node = Vector4::new([x, y, z, 0.0]);
    });
}

/// Imposes the velocities of all rigid bodies on their nodes.
pub fn impose_velocity_of_all_rigid<const D: usize>(
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
    contacts: &FieldContacts,
    solved: &mut [NodalState],
) {
    for (field, number) in contacts.rigid.iter().enumerate() {
        let Some(number) = number else { continue };
        let [x, y, z] = driven[*number].velocity();
        let len = background.layout.len();
        let nodes = &mut solved[field * len..(field + 1) * len];
        background.layout.for_each_active_node_range(nodes, |_, active, line| {
            for node in &mut line[active] {
                let mass = node.momentum_and_mass.as_array()[3];
                *node = NodalState { momentum_and_mass: Vector4::new([x, y, z, mass]), force: Vector4::ZERO };
            }
        });
    }
    impose_rigid_velocity(background, driven, contacts, solved);
}
