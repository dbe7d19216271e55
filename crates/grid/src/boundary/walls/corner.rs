//! Contact of a node with several faces. The impulses do not depend on the order of the faces: normal impulses are the smallest after which
//! no face is penetrated, and friction is shared by the loaded faces.

use crate::boundary::walls::WallKind;
use crate::boundary::walls::node_faces::{NodeFace, dot, length};

/// Number of faces of a node whose order does not matter; of more faces the first in the list act.
pub(super) const MAX_FACES: usize = 12;

/// Largest number of linearly independent normals.
const AXES: usize = 3;

/// Relative tolerance of velocities for round-off.
const ROUND_OFF: f64 = 1e-12;

/// Number of iterations that distribute the overlap among faces between which no velocity is possible.
const MAX_ITERATIONS: usize = 64;

/// Normal velocity changes (m/s) of the faces of a node, in the order of the faces.
type NormalImpulses = [f64; MAX_FACES];

/// Unilateral or bilateral bound of the nodal velocity by a face.
#[derive(Clone, Copy, Debug)]
struct VelocityBound {
    /// Normal, without the components that walls prescribe.
    normal: [f64; 3],
    /// Least velocity along the normal (m/s).
    min_velocity: f64,
    /// Whether the velocity along the normal equals `min_velocity` (else it may be larger).
    bilateral: bool,
}

/// Velocity bounds of a node.
#[derive(Clone, Copy, Debug)]
struct VelocityBounds {
    bounds: [VelocityBound; MAX_FACES],
    count: usize,
}

impl VelocityBounds {
    /// Velocity bounds of the faces. Those for which `is_bilateral` is true prescribe the normal velocity; the others limit it.
    fn new(
        faces: &[NodeFace],
        velocity: &[f64; 3],
        held: [bool; 3],
        is_bilateral: impl Fn(&NodeFace) -> bool,
    ) -> Self {
        let none = VelocityBound { normal: [0.0; 3], min_velocity: 0.0, bilateral: false };
        let mut bounds = Self { bounds: [none; MAX_FACES], count: faces.len().min(MAX_FACES) };
        for (bound, face) in bounds.bounds.iter_mut().zip(faces) {
            let by_held: f64 = (0..3).filter(|c| held[*c]).map(|c| face.normal[c] * velocity[c]).sum();
            *bound = VelocityBound {
                normal: std::array::from_fn(|c| if held[c] { 0.0 } else { face.normal[c] }),
                min_velocity: dot(&face.velocity, &face.normal) - by_held,
                bilateral: is_bilateral(face),
            };
        }
        bounds
    }

    /// Bounds that the walls of the node impose on its velocity.
    fn bounds(&self) -> &[VelocityBound] {
        &self.bounds[..self.count]
    }

    /// Whether a velocity satisfies all bounds up to `slack` (m/s).
    fn are_satisfied_by(&self, velocity: &[f64; 3], slack: f64) -> bool {
        // Components that walls prescribe can't be changed by the impulse of a face.
        let can = |bound: &&VelocityBound| dot(&bound.normal, &bound.normal) > ROUND_OFF;
        self.bounds().iter().filter(can).all(|bound| {
            let beyond = dot(&bound.normal, velocity) - bound.min_velocity;
            beyond >= -slack && (!bound.bilateral || beyond <= slack)
        })
    }

    /// Projects a velocity onto the velocities that all bounds permit, by the smallest impulses along the normals (m/s). Where several sets
    /// of faces give such impulses, their mean is taken.
    fn project(&self, velocity: &mut [f64; 3]) -> NormalImpulses {
        let free: [f64; 3] = std::array::from_fn(|c| {
            if self.bounds().iter().any(|bound| bound.normal[c] != 0.0) { velocity[c] } else { 0.0 }
        });
        let scale = self.bounds().iter().map(|bound| bound.min_velocity.abs()).fold(length(&free), f64::max);
        let slack = ROUND_OFF * scale;
        if self.are_satisfied_by(velocity, slack) && !self.bounds().iter().any(|bound| bound.bilateral) {
            return [0.0; MAX_FACES];
        }
        for size in 1..=AXES {
            let (mut pushes, mut sets, mut last) = ([0.0; MAX_FACES], 0, *velocity);
            for_each_set(self.count, size, |set| {
                if let Some((parts, reached)) = self.solve_active_set(set, velocity, slack) {
                    set.iter().zip(parts).for_each(|(face, part)| pushes[*face] += part);
                    sets += 1;
                    last = reached;
                }
            });
            if sets > 0 {
                *velocity = last;
                return pushes.map(|push| push / f64::from(sets));
            }
        }
        self.balance_opposing_faces(velocity)
    }

    /// Impulses by which some of the faces prescribe their normal velocities (m/s), and the resulting velocity. `None` if an impulse is
    /// tensile or another bound is violated.
    fn solve_active_set(
        &self,
        set: &[usize],
        velocity: &[f64; 3],
        slack: f64,
    ) -> Option<([f64; AXES], [f64; 3])> {
        let bound = |k: usize| &self.bounds[set[k]];
        let size = set.len();
        // Velocity within the span of the normals with the least norm.
        let given = solve(size, |a, b| dot(&bound(a).normal, &bound(b).normal), |a| bound(a).min_velocity)?;
        let lacks = |a: usize| bound(a).min_velocity - dot(&bound(a).normal, velocity);
        let parts = solve(size, |a, b| dot(&bound(a).normal, &bound(b).normal), lacks)?;
        if (0..size).any(|k| !bound(k).bilateral && parts[k] < -slack) {
            return None;
        }
        let span: [f64; 3] = std::array::from_fn(|c| (0..size).map(|k| given[k] * bound(k).normal[c]).sum());
        let reached = match size {
            1 => std::array::from_fn(|c| velocity[c] + parts[0] * bound(0).normal[c]),
            // Only along the edge, so that round-off leaves no velocity in plane problems.
            2 => {
                let edge = cross(&bound(0).normal, &bound(1).normal);
                let rest = dot(&edge, velocity) / dot(&edge, &edge);
                std::array::from_fn(|c| span[c] + rest * edge[c])
            }
            _ => span,
        };
        self.are_satisfied_by(&reached, slack).then_some((parts, reached))
    }

    /// Distributes the overlap among faces between which no velocity is possible, such as faces that close on a node.
    fn balance_opposing_faces(&self, velocity: &mut [f64; 3]) -> NormalImpulses {
        let (mut pushes, share) = ([0.0; MAX_FACES], 1.0 / self.count as f64);
        for _ in 0..MAX_ITERATIONS {
            let before = *velocity;
            for (bound, push) in self.bounds().iter().zip(&mut pushes) {
                let square = dot(&bound.normal, &bound.normal);
                if square <= ROUND_OFF {
                    continue;
                }
                let lacks = share * (bound.min_velocity - dot(&bound.normal, &before)) / square;
                let more = if bound.bilateral { lacks } else { lacks.max(-*push) };
                *push += more;
                (0..3).for_each(|c| velocity[c] += more * bound.normal[c]);
            }
        }
        pushes
    }
}

/// Calls `act` for each combination of `size` out of `count` faces.
fn for_each_set(count: usize, size: usize, mut act: impl FnMut(&[usize])) {
    for i in 0..count {
        match size {
            1 => act(&[i]),
            2 => (i + 1..count).for_each(|j| act(&[i, j])),
            _ => (i + 1..count).for_each(|j| (j + 1..count).for_each(|k| act(&[i, j, k]))),
        }
    }
}

/// Solves a symmetric system by Cholesky factorisation; `None` if it is singular.
fn solve(
    size: usize,
    matrix: impl Fn(usize, usize) -> f64,
    right: impl Fn(usize) -> f64,
) -> Option<[f64; AXES]> {
    let (mut lower, mut found) = ([[0.0; AXES]; AXES], [0.0; AXES]);
    for a in 0..size {
        for b in 0..=a {
            let rest = matrix(a, b) - (0..b).map(|c| lower[a][c] * lower[b][c]).sum::<f64>();
            lower[a][b] = if a != b {
                rest / lower[b][b]
            } else if rest > ROUND_OFF {
                rest.sqrt()
            } else {
                return None;
            };
        }
        found[a] = (right(a) - (0..a).map(|c| lower[a][c] * found[c]).sum::<f64>()) / lower[a][a];
    }
    for a in (0..size).rev() {
        found[a] = (found[a] - (a + 1..size).map(|c| lower[c][a] * found[c]).sum::<f64>()) / lower[a][a];
    }
    Some(found)
}

/// Vector product.
fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| {
        let (d, e) = ((c + 1) % 3, (c + 2) % 3);
        a[d] * b[e] - a[e] * b[d]
    })
}

/// Weighted mean of the face velocities (m/s) and the weight fractions; `None` where all weights are zero.
fn weighted_mean_velocity(
    faces: &[NodeFace],
    weight: impl Fn(usize) -> f64,
) -> Option<([f64; 3], NormalImpulses)> {
    let mut parts: NormalImpulses = std::array::from_fn(|k| if k < faces.len() { weight(k) } else { 0.0 });
    let whole: f64 = parts.iter().sum();
    if whole <= 0.0 {
        return None;
    }
    parts.iter_mut().for_each(|part| *part /= whole);
    let mean = std::array::from_fn(|c| parts.iter().zip(faces).map(|(p, face)| p * face.velocity[c]).sum());
    Some((mean, parts))
}

/// Velocity changes by each face at the end and the start of the step (m/s).
#[derive(Clone, Copy, Debug)]
struct VelocityChanges {
    end: [[f64; 3]; MAX_FACES],
    start: [[f64; 3]; MAX_FACES],
}

impl VelocityChanges {
    /// Velocity changes of normal impulses.
    fn from_impulses(faces: &[NodeFace], end: &NormalImpulses, start: &NormalImpulses) -> Self {
        let along = |pushes: &NormalImpulses| {
            std::array::from_fn(|k| faces.get(k).map_or([0.0; 3], |face| face.normal.map(|n| pushes[k] * n)))
        };
        Self { end: along(end), start: along(start) }
    }
}

/// Applies the contact conditions of several faces to the velocities of a node at the start and the end of a step (m/s), see
/// [`NodeWalls::constrain_and_record`](crate::boundary::walls::NodeWalls::constrain_and_record).
pub(super) fn constrain(
    faces: &[NodeFace],
    (start, end): (&mut [f64; 3], &mut [f64; 3]),
    keep_start: bool,
    lift: &[f64; 3],
    tell: &mut impl FnMut(&NodeFace, [f64; 3], [f64; 3]),
) {
    let faces = &faces[..faces.len().min(MAX_FACES)];
    let (begun, free) = (*start, *end);
    let bounds =
        VelocityBounds::new(faces, end, [false; 3], |face| !face.separation && !face.is_fully_bonded());
    let pushes = bounds.project(end);
    let mut kept = [0.0; MAX_FACES];
    if !keep_start {
        kept = constrain_start(faces, start);
    }
    let mut changes = VelocityChanges::from_impulses(faces, &pushes, &kept);
    let holding = |k: usize| f64::from(u8::from(faces[k].is_fully_bonded()));
    let pressed = |k: usize| if pushes[k] > 0.0 { pushes[k] } else { 0.0 };
    let sticks = |k: usize| if faces[k].kind == WallKind::Rough { pressed(k) } else { 0.0 };
    if let Some((velocity, parts)) = weighted_mean_velocity(faces, holding) {
        // Bonded faces take a larger part where they are compressed.
        let parts =
            weighted_mean_velocity(faces, |k| holding(k) * pressed(k)).map_or(parts, |(_, parts)| parts);
        impose_bonded_velocity(&mut changes.end, &parts, &free, end, velocity);
        if !keep_start {
            impose_bonded_velocity(&mut changes.start, &parts, &begun, start, velocity);
        }
    } else if let Some((velocity, parts)) = weighted_mean_velocity(faces, sticks) {
        impose_bonded_velocity(&mut changes.end, &parts, &free, end, velocity);
    } else {
        apply_friction(faces, &pushes, lift, end, &mut changes.end);
    }
    for (k, face) in faces.iter().enumerate() {
        tell(face, changes.end[k], changes.start[k]);
    }
}

/// Prescribes the velocity at the start of the step along the normals of bilateral faces (m/s).
fn constrain_start(faces: &[NodeFace], start: &mut [f64; 3]) -> NormalImpulses {
    let mut pushes = [0.0; MAX_FACES];
    let mut chosen = VelocityBounds::new(faces, start, [false; 3], |_| true);
    for (bound, face) in chosen.bounds.iter_mut().zip(faces) {
        if face.separation || face.is_fully_bonded() {
            *bound = VelocityBound { normal: [0.0; 3], min_velocity: 0.0, bilateral: false };
        }
    }
    if faces.iter().any(|face| !face.separation && !face.is_fully_bonded()) {
        pushes = chosen.project(start);
    }
    pushes
}

/// Sets the velocity of a node at a corner to that of the rough faces, and divides the remaining velocity change among them. The change
/// beyond the normal impulses is divided among the faces.
fn impose_bonded_velocity(
    changes: &mut [[f64; 3]; MAX_FACES],
    parts: &NormalImpulses,
    free: &[f64; 3],
    now: &mut [f64; 3],
    velocity: [f64; 3],
) {
    let told: [f64; 3] = std::array::from_fn(|c| changes.iter().map(|change| change[c]).sum());
    for (change, part) in changes.iter_mut().zip(parts) {
        (0..3).for_each(|c| change[c] += part * (velocity[c] - free[c] - told[c]));
    }
    *now = velocity;
}

/// Coulomb friction of faces on the sliding velocity (m/s) after all faces. Each face takes its part of the total friction limit.
fn apply_friction(
    faces: &[NodeFace],
    pushes: &NormalImpulses,
    lift: &[f64; 3],
    end: &mut [f64; 3],
    changes: &mut [[f64; 3]; MAX_FACES],
) {
    let bound = |k: usize| {
        let push = if pushes[k] > 0.0 { pushes[k] - dot(lift, &faces[k].normal) } else { 0.0 };
        if faces[k].kind == WallKind::Smooth { 0.0 } else { faces[k].coefficient() * push.max(0.0) }
    };
    let Some((_, parts)) = weighted_mean_velocity(faces, bound) else { return };
    let left = *end;
    for (k, face) in faces.iter().enumerate().filter(|(k, _)| parts[*k] > 0.0) {
        let out = face.separation_velocity(&left);
        let slides: [f64; 3] = std::array::from_fn(|c| left[c] - face.velocity[c] - out * face.normal[c]);
        let speed = length(&slides);
        let (own, smallest) = (bound(k), parts[k] * speed);
        let taken = if own >= smallest { parts[k] } else { own / speed };
        for c in 0..3 {
            let change = -taken * slides[c];
            changes[k][c] += change;
            end[c] += change;
        }
    }
}

/// Removes the velocity (m/s) into faces, without friction, by changes of the components that walls do not prescribe.
pub(super) fn remove_penetration(
    faces: &[NodeFace],
    velocity: &mut [f64; 3],
    held: [bool; 3],
    tell: &mut impl FnMut(&NodeFace, [f64; 3], [f64; 3]),
) {
    let faces = &faces[..faces.len().min(MAX_FACES)];
    let before = *velocity;
    let bounds = VelocityBounds::new(faces, velocity, held, |_| false);
    let pushes = bounds.project(velocity);
    (0..3).filter(|c| held[*c]).for_each(|c| velocity[c] = before[c]);
    for (k, face) in faces.iter().enumerate().filter(|(k, _)| pushes[*k] != 0.0) {
        tell(face, bounds.bounds[k].normal.map(|n| pushes[k] * n), [0.0; 3]);
    }
}

/// Constrains the re-mapped velocity (MUSL) of a node that had the velocity `solved` after the faces.
pub(super) fn constrain_remapped(faces: &[NodeFace], solved: &[f64; 3], velocity: &mut [f64; 3]) {
    let faces = &faces[..faces.len().min(MAX_FACES)];
    let stopped = |face: &NodeFace| face.is_in_contact(solved) || !face.separation;
    VelocityBounds::new(faces, velocity, [false; 3], stopped).project(velocity);
    let stuck = |face: &NodeFace| {
        face.is_fully_bonded() || (*solved == face.velocity && face.kind != WallKind::Smooth)
    };
    if let Some((held, _)) = weighted_mean_velocity(faces, |k| f64::from(u8::from(stuck(&faces[k])))) {
        *velocity = held;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn face(normal: [f64; 3], friction: f64, separation: bool) -> NodeFace {
        let long = length(&normal);
        NodeFace::at_rest(normal.map(|n| n / long), friction, separation)
    }

    /// Velocity after the faces and the velocity change by each face.
    fn constrained_velocity(faces: &[NodeFace], free: [f64; 3]) -> ([f64; 3], Vec<[f64; 3]>) {
        let (mut start, mut end, mut changes) = ([0.0; 3], free, vec![[0.0; 3]; faces.len()]);
        constrain(faces, (&mut start, &mut end), true, &[0.0; 3], &mut |face, change, _| {
            let number = faces.iter().position(|own| std::ptr::eq(own, face));
            changes[number.unwrap_or_else(|| faces.iter().position(|own| own == face).unwrap())] = change;
        });
        (end, changes)
    }

    #[test]
    fn a_plane_corner_stops_velocity_directed_into_both_faces() {
        let corner =
            |friction| [face([0.0, 1.0, 0.0], friction, true), face([0.8, 0.6, 0.0], friction, true)];
        for friction in [0.0, 0.4, f64::INFINITY] {
            let (end, changes) = constrained_velocity(&corner(friction), [-0.3, -0.7, 0.0]);
            assert_eq!(end, [0.0; 3], "{friction}: nothing is left by round-off");
            let sum: [f64; 3] = std::array::from_fn(|c| changes[0][c] + changes[1][c]);
            assert!((sum[0] - 0.3).abs() < 1e-15 && (sum[1] - 0.7).abs() < 1e-15, "{friction}: {sum:?}");
        }
        // Along the wall, off the floor.
        let (end, changes) = constrained_velocity(&corner(0.0), [-0.7, 0.6, 0.0]);
        assert!((end[0] + 0.6 * 0.9).abs() < 1e-15 && (end[1] - 0.8 * 0.9).abs() < 1e-15, "{end:?}");
        assert_eq!(changes[0], [0.0; 3]);
    }

    #[test]
    fn coplanar_faces_carry_equal_force() {
        for friction in [0.0, 0.3, f64::INFINITY] {
            let floor = face([0.0, 1.0, 0.0], friction, true);
            let other = NodeFace { reaction_index: Some(1), ..floor };
            let (end, changes) = constrained_velocity(&[floor, other], [1.0, -1.0, 0.0]);
            assert_eq!(changes[0], changes[1]);
            let exact = if friction.is_finite() { 1.0 - friction } else { 0.0 };
            assert!((end[0] - exact).abs() < 1e-15 && end[1] == 0.0, "{friction}: {end:?}");
        }
    }

    #[test]
    fn closing_faces_of_a_node_share_their_overlap() {
        let floor = NodeFace { velocity: [0.0, 1.0, 0.0], ..face([0.0, 1.0, 0.0], 0.0, true) };
        let roof = NodeFace { velocity: [0.0, -1.0, 0.0], ..face([0.0, -1.0, 0.0], 0.0, true) };
        let (end, _) = constrained_velocity(&[floor, roof], [0.5, -0.4, 0.0]);
        assert!(end[1].abs() < 1e-12 && end[0] == 0.5, "{end:?}");
    }

    fn test_faces() -> impl Strategy<Value = Vec<NodeFace>> {
        let friction = prop_oneof![Just(0.0), 0.05..1.0f64, Just(f64::INFINITY)];
        let one = ([-1.0..1.0f64, -1.0..1.0f64, 0.05..1.0f64], friction);
        proptest::collection::vec(one, 2..6).prop_map(|all| {
            let of = |(k, (normal, friction)): (usize, ([f64; 3], f64))| NodeFace {
                reaction_index: Some(k as u8),
                ..face(normal, friction, true)
            };
            all.into_iter().enumerate().map(of).collect()
        })
    }

    proptest! {
        #[test]
        fn faces_are_not_penetrated_and_their_forces_are_independent_of_order(
            faces in test_faces(),
            free in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64],
            turn in 1usize..6,
        ) {
            let (end, changes) = constrained_velocity(&faces, free);
            prop_assert!(faces.iter().all(|face| face.separation_velocity(&end) >= -1e-11), "{end:?}");
            for c in 0..3 {
                let sum: f64 = changes.iter().map(|change| change[c]).sum();
                prop_assert!((free[c] + sum - end[c]).abs() < 1e-12);
            }
            prop_assert!(length(&end) <= length(&free) + 1e-12, "friction makes no energy");
            let mut turned = faces.clone();
            turned.rotate_left(turn % faces.len());
            turned.swap(0, 1);
            let (other, of_turned) = constrained_velocity(&turned, free);
            prop_assert!((0..3).all(|c| (other[c] - end[c]).abs() < 1e-10), "{end:?} {other:?}");
            for (face, change) in turned.iter().zip(of_turned) {
                let own = changes[usize::from(face.reaction_index.unwrap())];
                prop_assert!((0..3).all(|c| (own[c] - change[c]).abs() < 1e-9), "{own:?} {change:?}");
            }
        }

        #[test]
        fn smooth_faces_remove_the_minimum_momentum(
            faces in test_faces(),
            free in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64],
            other in [-2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64],
        ) {
            let smooth: Vec<NodeFace> = faces.iter().map(|face| NodeFace { kind: WallKind::Smooth, ..*face }).collect();
            let (end, _) = constrained_velocity(&smooth, free);
            let away = |from: &[f64; 3]| length(&std::array::from_fn(|c| from[c] - free[c]));
            let admits = smooth.iter().all(|face| face.separation_velocity(&other) >= 0.0);
            prop_assert!(!admits || away(&other) >= away(&end) - 1e-10);
        }

        #[test]
        fn remapped_velocity_stays_out_of_all_faces_in_contact(
            faces in test_faces(),
            free in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64],
            mapped in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64],
        ) {
            let (solved, _) = constrained_velocity(&faces, free);
            let mut velocity = mapped;
            constrain_remapped(&faces, &solved, &mut velocity);
            prop_assert!(faces.iter().all(|face| face.separation_velocity(&velocity) >= -1e-10), "{velocity:?}");
        }
    }
}
