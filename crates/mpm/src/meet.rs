//! Rigid bodies that move freely meet bodies that deform, and walls (docs/theory/mpm.md, rigid bodies).
//!
//! What a node takes from a rigid body depends on the body's velocity there, and the body's velocity on what all nodes take.
//! Both are one system: the momentum of the body and of the nodes that it touches is that before, and at each node the law
//! of contact holds with the body's velocity after the step. It has as many unknowns as the body has free components, and
//! is solved by Newton's method, exact after one step where all nodes stick. So nothing heavy rides on the small masses of
//! nodes, however light the body.

use colluvium_case::rigid::{RigidStep, Six, resultant, solve, velocity_at};
use colluvium_grid::{Lanes, Node, Walls};

use crate::at_node::{Touch, touching};
use crate::background::Background;
use crate::bodies::Bodies;
use crate::clock::Clock;
use crate::contact::{Contacts, Given, Interface, RowTouch};
use crate::driven::Driven;
use crate::stand::{Plank, planks};
use crate::vectors::three;

/// Most steps of Newton's method.
const STEPS: usize = 60;
/// Most times that a step is halved.
const HALVINGS: usize = 12;
/// Change of the motion over the motion at which it has ended.
const SETTLED: f64 = 1e-13;

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
    planks: Vec<Plank>,
    /// How often the laws were not met to the last digit.
    pub unsettled: u64,
}

impl Grips {
    /// What is to be said of steps in which the laws of contact were not met.
    pub fn remark(&self) -> Option<String> {
        let times = self.unsettled;
        (times > 0).then(|| {
            format!(
                "the contact of a rigid body that moves freely was not solved to the last digit in {times} steps, in which it rubs \
                 or rests less firmly than its law says (momentum is kept all the same): take a smaller time step"
            )
        })
    }
}

/// What a rigid body meets in a step.
struct Meeting<'a> {
    touches: &'a [Touch<'a>],
    nodes: &'a [Grip],
    planks: &'a [Plank],
    /// Inertia with which walls take what comes (kg).
    wall: f64,
}

impl Grip {
    /// Velocities (m/s) of the two sides where the rigid body has the velocity `w`.
    fn ends<'a>(&'a self, w: &'a [f64; 3]) -> [&'a [f64; 3]; 2] {
        if self.side == 0 { [w, &self.velocity] } else { [&self.velocity, w] }
    }

    /// Impulse (N s) on the rigid body that has the velocity `w` (m/s) here.
    fn impulse(&self, touch: &Touch<'_>, w: &[f64; 3]) -> [f64; 3] {
        let soft = 1 - self.side;
        let (inertias, mut given) = (touch.inertias(self.masses), self.given);
        let touched = touch.answer(self.surface, inertias, self.ends(w), &mut given);
        touched.map_or([0.0; 3], |touched| {
            std::array::from_fn(|c| inertias[soft] * (self.velocity[c] - touched[soft][c]))
        })
    }

    /// How it falls with that velocity (kg).
    fn stiffness(&self, touch: &Touch<'_>, w: &[f64; 3]) -> [[f64; 3]; 3] {
        let inertia = touch.inertias(self.masses)[1 - self.side];
        touch.stiffness(self.surface, inertia, self.ends(w), &self.given)
    }
}

impl Meeting<'_> {
    /// Impulse on a body of some motion.
    fn impulse(&self, motion: &Six) -> Six {
        let mut sum = [0.0; 6];
        let mut add = |impulse: [f64; 3], arm: &[f64; 3]| {
            let own = resultant(&impulse, arm);
            (0..6).for_each(|k| sum[k] += own[k]);
        };
        for grip in self.nodes {
            add(grip.impulse(&self.touches[grip.pair], &velocity_at(motion, &grip.arm)), &grip.arm);
        }
        for plank in self.planks {
            add(plank.impulse(self.wall, &velocity_at(motion, &plank.arm)), &plank.arm);
        }
        sum
    }

    /// How the impulse falls with the motion.
    fn stiffness(&self, motion: &Six) -> [Six; 6] {
        let mut sum = [[0.0; 6]; 6];
        let mut add = |fall: [[f64; 3]; 3], arm: &[f64; 3]| {
            for axis in 0..3 {
                let column = resultant(&std::array::from_fn(|c| fall[c][axis]), arm);
                // The velocity along an axis, by the six components of the motion.
                let along = resultant(&std::array::from_fn(|c| if c == axis { 1.0 } else { 0.0 }), arm);
                for i in 0..6 {
                    (0..6).for_each(|j| sum[i][j] += column[i] * along[j]);
                }
            }
        };
        for grip in self.nodes {
            add(grip.stiffness(&self.touches[grip.pair], &velocity_at(motion, &grip.arm)), &grip.arm);
        }
        for plank in self.planks {
            add(plank.stiffness(self.wall, &velocity_at(motion, &plank.arm)), &plank.arm);
        }
        sum
    }
}

/// Largest velocity and spin of two motions.
fn speeds(one: &Six, other: &Six) -> [f64; 2] {
    [0..3, 3..6].map(|part| part.map(|k| one[k].abs().max(other[k].abs())).fold(0.0, f64::max))
}

/// The motion of a body with which the laws hold at all places that it meets; says too whether they do.
fn settled(loose: &RigidStep, meeting: &Meeting<'_>) -> (Six, bool) {
    let (matrix, free, before) = (loose.mass.matrix(), loose.free, loose.motion);
    let rest = |motion: &Six| -> Six {
        let impulse = meeting.impulse(motion);
        std::array::from_fn(|i| {
            (0..6).map(|j| matrix[i][j] * (motion[j] - before[j])).sum::<f64>() - impulse[i]
        })
    };
    let size = |rest: &Six| -> f64 {
        solve(&matrix, rest, &free).map_or(f64::NAN, |x| (0..6).map(|k| x[k] * rest[k]).sum())
    };
    let mut motion = before;
    let mut open = rest(&motion);
    let mut large = size(&open);
    for _ in 0..STEPS {
        if large == 0.0 {
            return (motion, true);
        }
        let mut tangent = meeting.stiffness(&motion);
        (0..6).for_each(|i| (0..6).for_each(|j| tangent[i][j] += matrix[i][j]));
        let Some(step) = solve(&tangent, &open, &free) else { return (motion, false) };
        let [along, about] = speeds(&motion, &before);
        let about = about.max(along / loose.mass.radius());
        let moves = (0..6).all(|k| step[k].abs() <= SETTLED * if k < 3 { along } else { about });
        let (mut share, mut next) = (1.0, motion);
        for _ in 0..HALVINGS {
            next = std::array::from_fn(|k| motion[k] - share * step[k]);
            let left = rest(&next);
            let now = size(&left);
            if now <= large || moves {
                (open, large) = (left, now);
                break;
            }
            share *= 0.5;
            (open, large) = (left, now);
        }
        motion = next;
        if moves {
            return (motion, true);
        }
    }
    (motion, false)
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

/// Lets the rigid bodies that move freely act on what deforms and on walls; says whether that changes any node.
pub fn meet<const D: usize>(
    around: &Around<'_, D>,
    solved: &mut [Node],
    driven: &mut [Driven],
    touched: &mut [RowTouch],
    grips: &mut Grips,
) -> bool {
    let Around { clock, background, bodies, light, walls, contacts } = *around;
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
        planks(clock, background, bodies, number, &loose, &mut grips.planks);
        let meeting = Meeting {
            touches: &touches,
            nodes: &grips.nodes,
            planks: &grips.planks,
            wall: crate::stand::STIFF * loose.mass.mass,
        };
        let (motion, done) = settled(&loose, &meeting);
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
