//! Contact of free rigid bodies with deformable bodies and walls (docs/theory/mpm.md, rigid bodies).
//!
//! The contact impulse of a node depends on the velocity of the rigid body there, and the velocity of the body depends on all impulses.
//! Both are one system: the momentum of the body and of its contact nodes is conserved, and at each node the contact law holds with the
//! body's velocity after the step. The system has as many unknowns as the body has free components. It is solved by Newton's method, exact
//! after one step where all nodes stick. The solution is stable for light nodes and for light bodies.

use colluvium_case::description::Wall;
use colluvium_case::rigid::{
    ContactLawAtPoint, ContactSystem, RigidStep, SupportPoints, Twist, WallPlane, add_impulses,
    add_stiffness, velocity_at, wrench_at,
};
use colluvium_case::spatial;
use colluvium_grid::{NodalState, NodeWalls, Vector4};

use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::contact::contact_law::{ContactImpulse, FieldContacts, Interface, RowContact};
use crate::contact::nodal_contact::{ContactNode, contact_node};
use crate::momentum::driven_object::DrivenObject;
use crate::obstacles::state::PenaltyObstacle;
use crate::points::bodies::Bodies;
use crate::points::vectors::first_three;

/// Node at which a rigid body touches a deformable body.
#[derive(Clone, Copy, Debug)]
pub struct ContactPoint {
    /// Number of the pair of fields, and the side of the rigid one.
    pair: usize,
    rigid_side: usize,
    node: usize,
    /// Position relative to the centre of mass (m).
    lever_arm: [f64; 3],
    /// Masses and velocity of the node of the deformable body (kg, m/s).
    masses: [f64; 2],
    velocity: [f64; 3],
    interface: Option<Interface>,
    impulse: ContactImpulse,
}

/// Workspace for the contacts of rigid bodies.
#[derive(Clone, Debug, Default)]
pub struct ContactSet {
    nodes: Vec<ContactPoint>,
    support_points: SupportPoints,
    /// Number of steps in which the iteration did not converge.
    pub unconverged_steps: u64,
}

/// System of equations of a rigid body in contact in a step.
struct RigidContactSystem<'a> {
    contact_nodes: &'a [ContactNode<'a>],
    nodes: &'a [ContactPoint],
    support_points: &'a SupportPoints,
}

impl ContactPoint {
    /// Velocities of the two bodies at the point (m/s), for the velocity `w` of the rigid body.
    fn side_velocities<'a>(&'a self, w: &'a [f64; 3]) -> [&'a [f64; 3]; 2] {
        if self.rigid_side == 0 { [w, &self.velocity] } else { [&self.velocity, w] }
    }
}

/// Contact node of a rigid body with its law.
struct ContactPointLaw<'a>(&'a ContactPoint, &'a ContactNode<'a>);

impl ContactLawAtPoint for ContactPointLaw<'_> {
    fn lever_arm(&self) -> &[f64; 3] {
        &self.0.lever_arm
    }

    fn impulse(&self, w: &[f64; 3]) -> [f64; 3] {
        let Self(point, contact) = self;
        let deformable = 1 - point.rigid_side;
        let (inertias, mut accumulated) = (contact.inertias(point.masses), point.impulse);
        let corrected = contact.velocities_at_interface(
            point.interface,
            inertias,
            point.side_velocities(w),
            &mut accumulated,
        );
        corrected.map_or([0.0; 3], |corrected| {
            std::array::from_fn(|c| inertias[deformable] * (point.velocity[c] - corrected[deformable][c]))
        })
    }

    fn stiffness(&self, w: &[f64; 3]) -> [[f64; 3]; 3] {
        let Self(point, contact) = self;
        let inertia = contact.inertias(point.masses)[1 - point.rigid_side];
        contact.stiffness(point.interface, inertia, point.side_velocities(w), &point.impulse)
    }
}

impl RigidContactSystem<'_> {
    /// Contact points of the system with the laws of their pairs.
    fn nodes(&self) -> impl Iterator<Item = ContactPointLaw<'_>> {
        self.nodes.iter().map(|point| ContactPointLaw(point, &self.contact_nodes[point.pair]))
    }
}

impl ContactSystem for RigidContactSystem<'_> {
    fn impulse(&self, motion: &Twist, stuck: bool) -> Twist {
        let mut sum = [0.0; 6];
        add_impulses(self.nodes(), motion, &mut sum);
        self.support_points.add_impulses(motion, stuck, &mut sum);
        sum
    }

    fn stiffness(&self, motion: &Twist, stuck: bool) -> [Twist; 6] {
        let mut sum = [[0.0; 6]; 6];
        add_stiffness(self.nodes(), motion, &mut sum);
        self.support_points.add_stiffness(motion, stuck, &mut sum);
        sum
    }
}

/// Returns the walls of the stage that support rigid bodies.
fn supporting_walls<'a, const D: usize>(
    clock: &'a Clock,
    background: &'a BackgroundGrid<D>,
) -> impl Iterator<Item = WallPlane> + 'a {
    clock.case.active_boundaries(clock.stage).into_iter().filter_map(|(_, boundary)| {
        let (axis, wall) = (boundary.side.axis(), &boundary.wall);
        // The axis of rotation is no support.
        let of_axis = background.axisymmetric && axis == 0;
        if matches!(wall, Wall::Absorbing { .. }) || boundary.group.is_some() || of_axis {
            return None;
        }
        Some(WallPlane {
            axis,
            normal_sign: if boundary.side.is_max() { -1.0 } else { 1.0 },
            face: boundary.wall_coordinate(&clock.case.domain),
            velocity: boundary.velocity.as_ref().map_or([0.0; 3], |v| spatial(v)),
            friction: wall.friction(),
        })
    })
}

/// Input of the contact of rigid bodies.
pub struct ContactContext<'a, const D: usize> {
    /// Clock of the step.
    pub clock: &'a Clock,
    /// Background grid.
    pub background: &'a BackgroundGrid<D>,
    /// Points of all bodies.
    pub bodies: &'a Bodies<D>,
    /// Mass (kg) below which a node is skipped.
    pub mass_cutoff: f64,
    /// Walls on nodes.
    pub walls: &'a NodeWalls,
    /// Pairs of velocity fields in contact.
    pub contacts: &'a FieldContacts,
}

impl<const D: usize> ContactContext<'_, D> {
    /// Lists the corners of the points of rigid body `number` that can reach walls or obstacles in the step.
    fn find_corners(
        &self,
        number: usize,
        free_body: &RigidStep,
        obstacles: &[PenaltyObstacle<D>],
        support_points: &mut SupportPoints,
    ) {
        let Some(set) = self.bodies.sets.iter().find(|set| set.rigid == Some(number)) else { return };
        let points = (set.points.position.as_slice(), 0.5 * set.extent[0]);
        let sides = supporting_walls(self.clock, self.background);
        support_points.list(
            (free_body, self.clock.dt),
            points,
            sides,
            obstacles.iter().map(PenaltyObstacle::rigid_contact),
        );
    }

    /// Applies contact at the nodes of a rigid body. Returns whether a node changed, the impulse on the body (N s) with its moment (N m s),
    /// and the impulse alone.
    fn apply_contacts(
        &self,
        motion: &Twist,
        points: &[ContactPoint],
        contact_nodes: &[ContactNode<'_>],
        solved: &mut [NodalState],
        row_contacts: &mut [RowContact],
    ) -> (bool, Twist, [f64; 3]) {
        let (mut changed, mut impulse, mut contact_impulse) = (false, [0.0; 6], [0.0; 3]);
        for point in points {
            let w = velocity_at(motion, &point.lever_arm);
            let contact = &contact_nodes[point.pair];
            let applied =
                apply_contact(self.background, self.contacts, contact, point, &w, solved, row_contacts);
            let Some((moved, own)) = applied else { continue };
            changed |= moved;
            let of = wrench_at(&own, &point.lever_arm);
            (0..6).for_each(|k| impulse[k] += of[k]);
            (0..3).for_each(|c| contact_impulse[c] += own[c]);
        }
        (changed, impulse, contact_impulse)
    }
}

/// Applies contact of the free rigid bodies with deformable bodies, walls and obstacles; returns whether any node changed.
pub fn solve_rigid_contact<const D: usize>(
    context: &ContactContext<'_, D>,
    solved: &mut [NodalState],
    driven: &mut [DrivenObject],
    row_contacts: &mut [RowContact],
    (contact_set, obstacles): (&mut ContactSet, &mut [PenaltyObstacle<D>]),
) -> bool {
    let ContactContext { clock, background, mass_cutoff, walls, contacts, .. } = *context;
    let mut changed = false;
    for (field, number) in contacts.rigid.iter().enumerate() {
        let Some(number) = *number else { continue };
        let Some(mut free_body) = driven[number].free_rigid_body else { continue };
        let contact_nodes: Vec<ContactNode<'_>> = contacts
            .pairs
            .iter()
            .map(|pair| contact_node(clock, background, mass_cutoff, walls, contacts, pair, clock.dt))
            .collect();
        contact_set.nodes.clear();
        collect_contact_points(
            background,
            contacts,
            field,
            &free_body,
            solved,
            (&contact_nodes, row_contacts),
            &mut contact_set.nodes,
        );
        context.find_corners(number, &free_body, obstacles, &mut contact_set.support_points);
        let system = RigidContactSystem {
            contact_nodes: &contact_nodes,
            nodes: &contact_set.nodes,
            support_points: &contact_set.support_points,
        };
        let (motion, done) = free_body.solve_contact(&system);
        contact_set.unconverged_steps += u64::from(!done);
        let (moved, impulse, contact_impulse) =
            context.apply_contacts(&motion, &contact_set.nodes, &contact_nodes, solved, row_contacts);
        changed |= moved;
        // Walls take the remaining balance: computed from their inertia it would contain round-off.
        if contact_set.support_points.is_empty() {
            free_body.add_impulse(&impulse);
        } else {
            free_body.motion = motion;
            for reaction in contact_set.support_points.reactions(&free_body, !done) {
                obstacles[reaction.obstacle].state.add_support_reaction(&reaction, clock.dt);
            }
        }
        driven[number].free_rigid_body = Some(free_body);
        driven[number].add_impulse(contact_impulse, clock.dt);
    }
    changed
}

/// Applies contact of a rigid body with the velocity `w` (m/s) at a node; returns whether the node changed, and the impulse (N s) on the
/// rigid body.
fn apply_contact<const D: usize>(
    background: &BackgroundGrid<D>,
    contacts: &FieldContacts,
    contact: &ContactNode<'_>,
    point: &ContactPoint,
    w: &[f64; 3],
    solved: &mut [NodalState],
    row_contacts: &mut [RowContact],
) -> Option<(bool, [f64; 3])> {
    let (len, row_length) = (background.layout.len(), background.layout.strides()[0]);
    let (row, number) = (point.node / row_length, point.node % row_length);
    let index = background.layout.axis_indices(row, number);
    let [first, second] = contacts.pairs[point.pair].fields;
    let (low, high) = solved.split_at_mut(second * len);
    let pair = [&mut low[first * len + point.node], &mut high[point.node]];
    pair[point.rigid_side].momentum_and_mass =
        Vector4::new([w[0], w[1], w[2], point.masses[point.rigid_side]]);
    let mut alone = ContactImpulse::default();
    let rows = background.layout.nodes()[0];
    let accumulated = row_contacts[point.pair * rows + row].impulses.get_mut(number).unwrap_or(&mut alone);
    let (changed, impulse) = contact.correct_velocities(point.node, &index, pair, accumulated)?;
    let sign = if point.rigid_side == 0 { 1.0 } else { -1.0 };
    Some((changed, impulse.map(|i| sign * i)))
}

/// Returns the nodes at which a rigid body touches deformable bodies.
fn collect_contact_points<const D: usize>(
    background: &BackgroundGrid<D>,
    contacts: &FieldContacts,
    field: usize,
    free_body: &RigidStep,
    solved: &[NodalState],
    (contact_nodes, row_contacts): (&[ContactNode<'_>], &[RowContact]),
    nodes: &mut Vec<ContactPoint>,
) {
    let (layout, len) = (&background.layout, background.layout.len());
    let (rows, row_length) = (layout.nodes()[0], layout.strides()[0]);
    for row in 0..rows {
        for number in layout.active_nodes(row) {
            let node = row * row_length + number;
            if !(solved[field * len + node].momentum_and_mass.as_array()[3] > 0.0) {
                continue;
            }
            for (pair, RigidPair { rigid_side, other_field }) in rigid_pairs(contacts, field) {
                let deformable = &solved[other_field * len + node];
                let mut masses = [deformable.momentum_and_mass.as_array()[3]; 2];
                masses[rigid_side] = solved[field * len + node].momentum_and_mass.as_array()[3];
                if !contact_nodes[pair].are_both_present(node, masses) {
                    continue;
                }
                let surface = match &contact_nodes[pair].law {
                    Some(law) => match contact_nodes[pair].interface(node, law) {
                        None => continue,
                        surface => surface,
                    },
                    None => None,
                };
                let index = layout.axis_indices(row, number);
                nodes.push(ContactPoint {
                    pair,
                    rigid_side,
                    node,
                    lever_arm: free_body.mass.lever_arm(&background.node_at(node, &index)),
                    masses,
                    velocity: first_three(deformable.momentum_and_mass),
                    interface: surface,
                    impulse: row_contacts[pair * rows + row]
                        .impulses
                        .get(number)
                        .copied()
                        .unwrap_or_default(),
                });
            }
        }
    }
}

/// Pair of a rigid and a deformable field.
struct RigidPair {
    rigid_side: usize,
    other_field: usize,
}

/// Returns the pairs of a rigid field with deformable fields.
fn rigid_pairs(contacts: &FieldContacts, field: usize) -> impl Iterator<Item = (usize, RigidPair)> {
    contacts.pairs.iter().enumerate().filter_map(move |(number, pair)| {
        let rigid_side = pair.fields.iter().position(|own| *own == field)?;
        let other_field = pair.fields[1 - rigid_side];
        (!contacts.is_rigid(other_field)).then_some((number, RigidPair { rigid_side, other_field }))
    })
}
