//! Rigid bodies that move freely meet bodies that deform, and walls (docs/theory/mpm.md, rigid bodies).
//!
//! What a node takes from a rigid body depends on the body's velocity there, and the body's velocity on what all nodes take.
//! Both are one system: the momentum of the body and of the nodes that it touches is that before, and at each node the law
//! of contact holds with the body's velocity after the step. It has as many unknowns as the body has free components, and
//! is solved by Newton's method, exact after one step where all nodes stick. So nothing heavy rides on the small masses of
//! nodes, however light the body.

use colluvium_case::description::Wall;
use colluvium_case::rigid::{
    Planks, RigidStep, Side, Six, Touched, Touching, add_impulses, add_stiffness, resultant, velocity_at,
};
use colluvium_case::spatial;
use colluvium_grid::{Lanes, Node, Walls};

use crate::at_node::{Touch, touching};
use crate::background::Background;
use crate::bodies::Bodies;
use crate::clock::Clock;
use crate::contact::{Contacts, Given, Interface, RowTouch};
use crate::driven::Driven;
use crate::obstacles::rocks::Rock;
use crate::vectors::three;

/// A node at which a rigid body touches a body that deforms.
#[derive(Clone, Copy, Debug)]
pub struct Grip {
    /// Number of the pair of fields, and the side of the rigid one.
    pair: usize,
    side: usize,
    place: usize,
    /// From the centre of mass (m).
    arm: [f64; 3],
    /// Of the node of what deforms (kg, m/s).
    masses: [f64; 2],
    velocity: [f64; 3],
    surface: Option<Interface>,
    given: Given,
}

/// Room for what a rigid body touches.
#[derive(Clone, Debug, Default)]
pub struct Grips {
    nodes: Vec<Grip>,
    planks: Planks,
    /// How often the laws were not met to the last digit.
    pub unsettled: u64,
}

/// What a rigid body meets in a step.
struct Meeting<'a> {
    touches: &'a [Touch<'a>],
    nodes: &'a [Grip],
    planks: &'a Planks,
}

impl Grip {
    /// Velocities (m/s) of the two sides where the rigid body has the velocity `w`.
    fn ends<'a>(&'a self, w: &'a [f64; 3]) -> [&'a [f64; 3]; 2] {
        if self.side == 0 { [w, &self.velocity] } else { [&self.velocity, w] }
    }
}

/// A node that a rigid body touches, with the law there.
struct At<'a>(&'a Grip, &'a Touch<'a>);

impl Touching for At<'_> {
    fn arm(&self) -> &[f64; 3] {
        &self.0.arm
    }

    fn impulse(&self, w: &[f64; 3]) -> [f64; 3] {
        let Self(grip, touch) = self;
        let soft = 1 - grip.side;
        let (inertias, mut given) = (touch.inertias(grip.masses), grip.given);
        let touched = touch.answer(grip.surface, inertias, grip.ends(w), &mut given);
        touched.map_or([0.0; 3], |touched| {
            std::array::from_fn(|c| inertias[soft] * (grip.velocity[c] - touched[soft][c]))
        })
    }

    fn stiffness(&self, w: &[f64; 3]) -> [[f64; 3]; 3] {
        let Self(grip, touch) = self;
        let inertia = touch.inertias(grip.masses)[1 - grip.side];
        touch.stiffness(grip.surface, inertia, grip.ends(w), &grip.given)
    }
}

impl Meeting<'_> {
    fn nodes(&self) -> impl Iterator<Item = At<'_>> {
        self.nodes.iter().map(|grip| At(grip, &self.touches[grip.pair]))
    }
}

impl Touched for Meeting<'_> {
    fn impulse(&self, motion: &Six, stuck: bool) -> Six {
        let mut sum = [0.0; 6];
        add_impulses(self.nodes(), motion, &mut sum);
        self.planks.add_impulses(motion, stuck, &mut sum);
        sum
    }

    fn stiffness(&self, motion: &Six, stuck: bool) -> [Six; 6] {
        let mut sum = [[0.0; 6]; 6];
        add_stiffness(self.nodes(), motion, &mut sum);
        self.planks.add_stiffness(motion, stuck, &mut sum);
        sum
    }
}

/// The walls of the stage that rigid bodies stand on.
fn sides<'a, const D: usize>(
    clock: &'a Clock,
    background: &'a Background<D>,
) -> impl Iterator<Item = Side> + 'a {
    clock.case.active_boundaries(clock.stage).into_iter().filter_map(|(_, boundary)| {
        let (axis, wall) = (boundary.side.axis(), &boundary.wall);
        // The axis of rotation holds nothing.
        let of_axis = background.axisymmetric && axis == 0;
        if matches!(wall, Wall::Absorbing { .. }) || boundary.group.is_some() || of_axis {
            return None;
        }
        Some(Side {
            axis,
            off: if boundary.side.is_max() { -1.0 } else { 1.0 },
            face: boundary.position(&clock.case.domain),
            velocity: boundary.velocity.as_ref().map_or([0.0; 3], |v| spatial(v)),
            friction: wall.friction(),
        })
    })
}

/// What rigid bodies meet.
pub struct Around<'a, const D: usize> {
    /// The step.
    pub clock: &'a Clock,
    /// Where the nodes are.
    pub background: &'a Background<D>,
    /// The points.
    pub bodies: &'a Bodies<D>,
    /// Mass (kg) up to which a node does not count.
    pub light: f64,
    /// Walls on nodes.
    pub walls: &'a Walls,
    /// The pairs of fields.
    pub contacts: &'a Contacts,
}

impl<const D: usize> Around<'_, D> {
    /// Lists the corners of the points of rigid body `number` that can reach walls and obstacles in the step.
    fn find(&self, number: usize, loose: &RigidStep, rocks: &[Rock<D>], planks: &mut Planks) {
        let Some(set) = self.bodies.sets.iter().find(|set| set.rigid == Some(number)) else { return };
        let points = (set.points.position.as_slice(), 0.5 * set.extent[0]);
        let sides = sides(self.clock, self.background);
        planks.list((loose, self.clock.dt), points, sides, rocks.iter().map(Rock::ground));
    }
}

/// Lets the rigid bodies that move freely act on what deforms, on walls and on obstacles; says whether that changes any node.
pub fn meet<const D: usize>(
    around: &Around<'_, D>,
    solved: &mut [Node],
    driven: &mut [Driven],
    touched: &mut [RowTouch],
    (grips, rocks): (&mut Grips, &mut [Rock<D>]),
) -> bool {
    let Around { clock, background, light, walls, contacts, .. } = *around;
    let mut changed = false;
    for (field, number) in contacts.rigid.iter().enumerate() {
        let Some(number) = *number else { continue };
        let Some(mut loose) = driven[number].loose else { continue };
        let touches: Vec<Touch<'_>> = contacts
            .pairs
            .iter()
            .map(|pair| touching(clock, background, light, walls, contacts, pair, clock.dt))
            .collect();
        grips.nodes.clear();
        gather(background, contacts, field, &loose, solved, (&touches, touched), &mut grips.nodes);
        around.find(number, &loose, rocks, &mut grips.planks);
        let meeting = Meeting { touches: &touches, nodes: &grips.nodes, planks: &grips.planks };
        let (motion, done) = loose.settled(&meeting);
        grips.unsettled += u64::from(!done);
        let mut impulse = [0.0; 6];
        let mut taken = [0.0; 3];
        for grip in &grips.nodes {
            let w = velocity_at(&motion, &grip.arm);
            let touch = &touches[grip.pair];
            let Some((moved, own)) = act(background, contacts, touch, grip, &w, solved, touched) else {
                continue;
            };
            changed |= moved;
            let of = resultant(&own, &grip.arm);
            (0..6).for_each(|k| impulse[k] += of[k]);
            (0..3).for_each(|c| taken[c] += own[c]);
        }
        // Walls take what is left of the balance: found from their inertia it would carry the round-off of that.
        if grips.planks.is_empty() {
            loose.push(&impulse);
        } else {
            loose.motion = motion;
            for stood in grips.planks.stood(&loose, !done) {
                rocks[stood.obstacle].state.take(&stood, clock.dt);
            }
        }
        driven[number].loose = Some(loose);
        driven[number].take(taken, clock.dt);
    }
    changed
}

/// Lets a rigid body of the velocity `w` (m/s) at a node act there; says whether that changes anything, and which impulse
/// (N s) the rigid body takes.
fn act<const D: usize>(
    background: &Background<D>,
    contacts: &Contacts,
    touch: &Touch<'_>,
    grip: &Grip,
    w: &[f64; 3],
    solved: &mut [Node],
    touched: &mut [RowTouch],
) -> Option<(bool, [f64; 3])> {
    let (len, row_length) = (background.layout.len(), background.layout.strides()[0]);
    let (row, number) = (grip.place / row_length, grip.place % row_length);
    let index = background.layout.index(row, number);
    let [first, second] = contacts.pairs[grip.pair].fields;
    let (low, high) = solved.split_at_mut(second * len);
    let pair = [&mut low[first * len + grip.place], &mut high[grip.place]];
    pair[grip.side].motion = Lanes::new([w[0], w[1], w[2], grip.masses[grip.side]]);
    let mut alone = Given::default();
    let rows = background.layout.nodes()[0];
    let given = touched[grip.pair * rows + row].given.get_mut(number).unwrap_or(&mut alone);
    let (changed, impulse) = touch.solved(grip.place, &index, pair, given)?;
    let sign = if grip.side == 0 { 1.0 } else { -1.0 };
    Some((changed, impulse.map(|i| sign * i)))
}

/// The nodes at which a rigid body touches what deforms.
fn gather<const D: usize>(
    background: &Background<D>,
    contacts: &Contacts,
    field: usize,
    loose: &RigidStep,
    solved: &[Node],
    (touches, touched): (&[Touch<'_>], &[RowTouch]),
    nodes: &mut Vec<Grip>,
) {
    let (layout, len) = (&background.layout, background.layout.len());
    let (rows, row_length) = (layout.nodes()[0], layout.strides()[0]);
    for row in 0..rows {
        for number in layout.active(row) {
            let place = row * row_length + number;
            if !(solved[field * len + place].motion.as_array()[3] > 0.0) {
                continue;
            }
            for (pair, Pairing { side, other }) in pairings(contacts, field) {
                let soft = &solved[other * len + place];
                let mut masses = [soft.motion.as_array()[3]; 2];
                masses[side] = solved[field * len + place].motion.as_array()[3];
                if !touches[pair].present(place, masses) {
                    continue;
                }
                let surface = match &touches[pair].law {
                    Some(law) => match touches[pair].interface(place, law) {
                        None => continue,
                        surface => surface,
                    },
                    None => None,
                };
                let index = layout.index(row, number);
                nodes.push(Grip {
                    pair,
                    side,
                    place,
                    arm: loose.mass.arm(&background.node_at(place, &index)),
                    masses,
                    velocity: three(soft.motion),
                    surface,
                    given: touched[pair * rows + row].given.get(number).copied().unwrap_or_default(),
                });
            }
        }
    }
}

/// A pair of fields, seen from a rigid one.
struct Pairing {
    side: usize,
    other: usize,
}

/// The pairs of a rigid field with fields that deform.
fn pairings(contacts: &Contacts, field: usize) -> impl Iterator<Item = (usize, Pairing)> {
    contacts.pairs.iter().enumerate().filter_map(move |(number, pair)| {
        let side = pair.fields.iter().position(|own| *own == field)?;
        let other = pair.fields[1 - side];
        (!contacts.is_rigid(other)).then_some((number, Pairing { side, other }))
    })
}
