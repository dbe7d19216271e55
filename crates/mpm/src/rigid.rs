//! Rigid bodies in a step: as the case prescribes, and as forces make them (docs/theory/mpm.md, rigid bodies).

use colluvium_case::damping::sign;
use colluvium_case::description::{PrescribedMotion, Velocity};
use colluvium_case::rigid::{Acts, RigidMass, RigidState, RigidStep, times};
use colluvium_case::{SolverError, spatial};
use colluvium_grid::{Lanes, Node};

use crate::background::Background;
use crate::bodies::{Bodies, failed};
use crate::clock::Clock;
use crate::config::Formulation;
use crate::contact::Contacts;
use crate::driven::Driven;
use crate::momentum::RowSums;
use crate::points::PointSet;

/// Mass and moments of inertia of a rigid body, with mass scaling.
fn mass_of<const D: usize>(clock: &Clock, set: &PointSet<D>) -> RigidMass {
    RigidMass::of(&set.points.mass, &set.points.position, set.extent[0]).scaled(clock.options.mass_scaling)
}

/// A rigid body that moves freely, at the start of a step, with the motion at its end that forces from outside give it.
fn loosened<const D: usize>(
    clock: &Clock,
    set: &PointSet<D>,
    motion: &PrescribedMotion,
    state: &RigidState,
) -> RigidStep {
    let own = set.points.mass.iter().sum::<f64>();
    let weight = clock.gravity_at_end().map(|g| own * g);
    let elapsed = clock.time + clock.dt - clock.stage_start;
    let acts = Acts::of(motion, elapsed, D, (&weight, &[0.0; 3]));
    let share = clock.dt * clock.stage().rayleigh_damping;
    RigidStep::new(mass_of(clock, set), state, &acts, clock.dt, share)
}

/// What a rigid body that moves freely adds to the measures of equilibrium in a step of `dt` (s), with local damping of the axes
/// and Rayleigh damping.
pub fn audit(loose: &RigidStep, dt: f64, damping: &[f64; 3], rayleigh: f64) -> RowSums {
    let mut sums = RowSums { work: loose.work(dt), ..RowSums::default() };
    for c in (0..3).filter(|c| loose.free[*c]) {
        let (start, end) = (loose.start[c], loose.motion[c]);
        let net = loose.mass.mass * ((end - start) / dt + rayleigh * 0.5 * (start + end));
        let unbalanced = net / (1.0 - damping[c] * sign(start) * sign(net));
        sums.unbalanced += unbalanced * unbalanced;
        sums.external += loose.applied[c] * loose.applied[c];
    }
    let momentum = times(&loose.mass.matrix(), &loose.motion);
    sums.kinetic = 0.5 * (0..6).map(|k| momentum[k] * loose.motion[k]).sum::<f64>();
    sums
}

/// Velocities at the end of a step of `dt`; forces are counted anew.
pub fn drive<const D: usize>(clock: &Clock, bodies: &mut Bodies<D>, driven: &mut [Driven]) {
    let stage = clock.stage();
    let elapsed = clock.time + clock.dt - clock.stage_start;
    for (number, driven) in driven.iter_mut().enumerate() {
        let motion = stage.motion_of(&driven.name);
        driven.before = driven.state.velocity;
        driven.state.force = [0.0; 3];
        let set = bodies.sets.iter().find(|set| set.rigid == Some(number));
        let free = motion.filter(|motion| motion.is_free()).zip(set);
        driven.loose = free.map(|(motion, set)| loosened(clock, set, motion, &driven.state.rigid));
        if let Some(loose) = &driven.loose {
            driven.state.rigid.velocity = loose.velocity();
        } else {
            let state = &mut driven.state;
            state.velocity = motion.map_or([None; 3], |motion| motion.velocity_at(elapsed));
            state.rigid.stop();
            state.rigid.velocity = state.velocity.map(|v| v.unwrap_or(0.0));
        }
    }
    for set in &mut bodies.sets {
        let Some(number) = set.rigid.filter(|number| driven[*number].loose.is_none()) else { continue };
        let velocity = driven[number].velocity();
        set.points.velocity.fill(std::array::from_fn(|c| velocity[c]));
    }
}

/// Moves what is driven, at the end of a step of `dt`; returns the largest move of a point along an axis (m).
///
/// # Errors
/// When a point of a rigid body leaves the domain or the mesh.
pub fn move_driven<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    driven: &mut [Driven],
) -> Result<f64, SolverError> {
    let (mut moved, dt) = (0f64, clock.dt);
    for driven in &mut *driven {
        let velocity = driven.velocity();
        (0..3).for_each(|c| driven.state.way[c] += dt * velocity[c]);
    }
    let (ground, mut lost) = (background.ground(), None);
    if clock.options.formulation == Formulation::SmallDisplacement {
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
            let mut settled = domain.settle(p, &ground, position);
            if within && !anchored && !background.grid.contains(position) {
                settled = Err("a rigid body left the domain: enlarge the domain".to_owned());
            }
            lost = lost.or(settled.err().map(|reason| (place, p, reason)));
        }
    }
    match lost {
        Some((set, point, reason)) => Err(failed(clock, &bodies.sets[set], point, reason)),
        None => Ok(moved),
    }
}

/// Moves a rigid body in a step of `dt`; returns the largest move of a point along an axis (m).
fn move_rigid<const D: usize>(dt: f64, set: &mut PointSet<D>, driven: &mut Driven) -> f64 {
    let velocity = driven.velocity();
    let Some(loose) = &driven.loose else {
        set.points.position.iter_mut().for_each(|x| (0..D).for_each(|c| x[c] += dt * velocity[c]));
        return velocity.iter().fold(0.0, |most, v| most.max((dt * v).abs()));
    };
    loose.carry(dt, &mut driven.state.rigid, &mut set.points.position, &mut set.points.velocity);
    set.points.velocity.as_flattened().iter().fold(0.0, |most, v| most.max((dt * v).abs()))
}

/// Motion with which rigid bodies begin.
pub fn start<const D: usize>(clock: &Clock, sets: &[PointSet<D>], driven: &mut [Driven]) {
    for set in sets {
        let Some(number) = set.rigid else { continue };
        let given = &clock.case.bodies[set.body as usize].velocity;
        let (mass, points) = (mass_of(clock, set), &set.points);
        driven[number].state.rigid = if *given == Velocity::Rest {
            // A list of points may have velocities.
            RigidState::of_points(&mass, &points.mass, &points.position, &points.velocity)
        } else {
            RigidState::begun(&mass, given)
        };
    }
}

/// Ends the step of the rigid bodies that move freely, with local damping.
pub fn settle_loose(clock: &Clock, driven: &mut [Driven]) {
    let damping = clock.stage().damping_of_axes();
    for driven in driven {
        let Some(loose) = &mut driven.loose else { continue };
        loose.damp(&damping);
        loose.settle(&mut driven.state.rigid);
    }
}

/// Brings rigid bodies that move freely to rest.
pub fn stop_loose(driven: &mut [Driven]) {
    for driven in driven.iter_mut().filter(|driven| driven.patch.is_none()) {
        driven.state.rigid.stop();
    }
}

/// Calls `visit(velocity of the body, node)` at all nodes of rigid bodies that move freely.
fn at_loose<T: Send, const D: usize>(
    background: &Background<D>,
    driven: &[Driven],
    contacts: &Contacts,
    nodes: &mut [T],
    visit: impl Fn([f64; 3], &mut T) + Sync,
) {
    let (len, row_length) = (background.layout.len(), background.layout.strides()[0]);
    for (field, number) in contacts.rigid.iter().enumerate() {
        let Some(loose) = number.and_then(|number| driven[number].loose.as_ref()) else { continue };
        background.layout.each(&mut nodes[field * len..(field + 1) * len], |row, active, line| {
            for number in active {
                let index = background.layout.index(row, number);
                let x = background.node_at(row * row_length + number, &index);
                visit(loose.velocity_at(&x), &mut line[number]);
            }
        });
    }
}

/// Gives the solved nodes of rigid bodies that move freely their velocity.
pub fn hold_loose<const D: usize>(
    background: &Background<D>,
    driven: &[Driven],
    contacts: &Contacts,
    solved: &mut [Node],
) {
    at_loose(background, driven, contacts, solved, |[x, y, z], node| {
        let mass = node.motion.as_array()[3];
        *node = Node { motion: Lanes::new([x, y, z, mass]), force: Lanes::ZERO };
    });
}

/// Gives the re-mapped nodes of rigid bodies that move freely their velocity.
pub fn hold_loose_again<const D: usize>(
    background: &Background<D>,
    driven: &[Driven],
    contacts: &Contacts,
    remapped: &mut [Lanes],
) {
    at_loose(background, driven, contacts, remapped, |[x, y, z], node| *node = Lanes::new([x, y, z, 0.0]));
}

/// Gives the nodes of rigid bodies their velocity.
pub fn hold_rigid<const D: usize>(
    background: &Background<D>,
    driven: &[Driven],
    contacts: &Contacts,
    solved: &mut [Node],
) {
    for (field, number) in contacts.rigid.iter().enumerate() {
        let Some(number) = number else { continue };
        let [x, y, z] = driven[*number].velocity();
        let len = background.layout.len();
        let nodes = &mut solved[field * len..(field + 1) * len];
        background.layout.each(nodes, |_, active, line| {
            for node in &mut line[active] {
                let mass = node.motion.as_array()[3];
                *node = Node { motion: Lanes::new([x, y, z, mass]), force: Lanes::ZERO };
            }
        });
    }
    hold_loose(background, driven, contacts, solved);
}
