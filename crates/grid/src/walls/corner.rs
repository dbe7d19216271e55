//! Faces that meet at a node. Their impulses do not depend on the order in which they are listed: those along the normals are the
//! smallest that leave a velocity into none of the faces, and friction is shared by the faces that bear some.

use super::WallKind;
use super::faces::{Face, dot, length};

/// Faces of a node among which no order is made; of more the first that are listed act.
pub(super) const MOST: usize = 12;

/// Independent normals at most.
const AXES: usize = 3;

/// Round-off over the velocities that enter.
const ROUND: f64 = 1e-12;

/// Rounds in which faces that leave no way out share their overlap.
const ROUNDS: usize = 64;

/// Changes of velocity (m/s) along the normals of the faces of a node, in their order.
type Pushes = [f64; MOST];

/// A face as a bound of the velocity.
#[derive(Clone, Copy, Debug)]
struct Bound {
    /// Normal, without the components that walls hold.
    normal: [f64; 3],
    /// Least velocity along it (m/s).
    least: f64,
    /// Whether the velocity along it is that one, and not more.
    bilateral: bool,
}

/// The bounds of a node.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    all: [Bound; MOST],
    count: usize,
}

impl Bounds {
    /// Those of faces; the velocity along the normal of those that `is_bilateral` picks is given.
    fn new(
        faces: &[Face],
        velocity: &[f64; 3],
        held: [bool; 3],
        is_bilateral: impl Fn(&Face) -> bool,
    ) -> Self {
        let none = Bound { normal: [0.0; 3], least: 0.0, bilateral: false };
        let mut bounds = Self { all: [none; MOST], count: faces.len().min(MOST) };
        for (bound, face) in bounds.all.iter_mut().zip(faces) {
            let by_held: f64 = (0..3).filter(|c| held[*c]).map(|c| face.normal[c] * velocity[c]).sum();
            *bound = Bound {
                normal: std::array::from_fn(|c| if held[c] { 0.0 } else { face.normal[c] }),
                least: dot(&face.velocity, &face.normal) - by_held,
                bilateral: is_bilateral(face),
            };
        }
        bounds
    }

    fn all(&self) -> &[Bound] {
        &self.all[..self.count]
    }

    /// Whether a velocity keeps to all bounds up to `slack` (m/s).
    fn admit(&self, velocity: &[f64; 3], slack: f64) -> bool {
        // What walls hold altogether no impulse of a face can change.
        let can = |bound: &&Bound| dot(&bound.normal, &bound.normal) > ROUND;
        self.all().iter().filter(can).all(|bound| {
            let beyond = dot(&bound.normal, velocity) - bound.least;
            beyond >= -slack && (!bound.bilateral || beyond <= slack)
        })
    }

    /// Changes a velocity (m/s) by the smallest pushes along the normals after which it keeps to all bounds. Where several sets of
    /// faces can give them, each gives its part of their mean.
    fn project(&self, velocity: &mut [f64; 3]) -> Pushes {
        let free: [f64; 3] = std::array::from_fn(|c| {
            if self.all().iter().any(|bound| bound.normal[c] != 0.0) { velocity[c] } else { 0.0 }
        });
        let scale = self.all().iter().map(|bound| bound.least.abs()).fold(length(&free), f64::max);
        let slack = ROUND * scale;
        if self.admit(velocity, slack) && !self.all().iter().any(|bound| bound.bilateral) {
            return [0.0; MOST];
        }
        for size in 1..=AXES {
            let (mut pushes, mut sets, mut last) = ([0.0; MOST], 0, *velocity);
            for_each_set(self.count, size, |set| {
                if let Some((parts, reached)) = self.of_set(set, velocity, slack) {
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
        self.share_overlap(velocity)
    }

    /// Pushes (m/s) of a set of faces that bring a velocity onto all of them, and the velocity then; none where some would have to
    /// pull or another bound is broken.
    fn of_set(&self, set: &[usize], velocity: &[f64; 3], slack: f64) -> Option<([f64; AXES], [f64; 3])> {
        let bound = |k: usize| &self.all[set[k]];
        let size = set.len();
        // Velocity within the span of the normals that has the least components along them.
        let given = solve(size, |a, b| dot(&bound(a).normal, &bound(b).normal), |a| bound(a).least)?;
        let lacks = |a: usize| bound(a).least - dot(&bound(a).normal, velocity);
        let parts = solve(size, |a, b| dot(&bound(a).normal, &bound(b).normal), lacks)?;
        if (0..size).any(|k| !bound(k).bilateral && parts[k] < -slack) {
            return None;
        }
        let span: [f64; 3] = std::array::from_fn(|c| (0..size).map(|k| given[k] * bound(k).normal[c]).sum());
        let reached = match size {
            1 => std::array::from_fn(|c| velocity[c] + parts[0] * bound(0).normal[c]),
            // Along the edge alone, so that in the plane nothing is left by round-off.
            2 => {
                let edge = cross(&bound(0).normal, &bound(1).normal);
                let rest = dot(&edge, velocity) / dot(&edge, &edge);
                std::array::from_fn(|c| span[c] + rest * edge[c])
            }
            _ => span,
        };
        self.admit(&reached, slack).then_some((parts, reached))
    }

    /// Faces that leave no way out, as those that close on a node do, share what one takes and another gives back.
    fn share_overlap(&self, velocity: &mut [f64; 3]) -> Pushes {
        let (mut pushes, share) = ([0.0; MOST], 1.0 / self.count as f64);
        for _ in 0..ROUNDS {
            let before = *velocity;
            for (bound, push) in self.all().iter().zip(&mut pushes) {
                let square = dot(&bound.normal, &bound.normal);
                if square <= ROUND {
                    continue;
                }
                let lacks = share * (bound.least - dot(&bound.normal, &before)) / square;
                let more = if bound.bilateral { lacks } else { lacks.max(-*push) };
                *push += more;
                (0..3).for_each(|c| velocity[c] += more * bound.normal[c]);
            }
        }
        pushes
    }
}

/// Calls `act` with each set of `size` of `count` faces.
fn for_each_set(count: usize, size: usize, mut act: impl FnMut(&[usize])) {
    for i in 0..count {
        match size {
            1 => act(&[i]),
            2 => (i + 1..count).for_each(|j| act(&[i, j])),
            _ => (i + 1..count).for_each(|j| (j + 1..count).for_each(|k| act(&[i, j, k]))),
        }
    }
}

/// Solves a symmetric system by Cholesky's factors; none where it is singular.
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
            } else if rest > ROUND {
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

fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| {
        let (d, e) = ((c + 1) % 3, (c + 2) % 3);
        a[d] * b[e] - a[e] * b[d]
    })
}

/// Mean of the velocities (m/s) of the faces with a weight, and the part of each; none where all weights are zero.
fn weighted(faces: &[Face], weight: impl Fn(usize) -> f64) -> Option<([f64; 3], Pushes)> {
    let mut parts: Pushes = std::array::from_fn(|k| if k < faces.len() { weight(k) } else { 0.0 });
    let whole: f64 = parts.iter().sum();
    if whole <= 0.0 {
        return None;
    }
    parts.iter_mut().for_each(|part| *part /= whole);
    let mean = std::array::from_fn(|c| parts.iter().zip(faces).map(|(p, face)| p * face.velocity[c]).sum());
    Some((mean, parts))
}

/// Changes of velocity (m/s) by each face, at the end and at the start of the step.
#[derive(Clone, Copy, Debug)]
struct Changes {
    end: [[f64; 3]; MOST],
    start: [[f64; 3]; MOST],
}

impl Changes {
    /// Pushes along the normals.
    fn of(faces: &[Face], end: &Pushes, start: &Pushes) -> Self {
        let along = |pushes: &Pushes| {
            std::array::from_fn(|k| faces.get(k).map_or([0.0; 3], |face| face.normal.map(|n| pushes[k] * n)))
        };
        Self { end: along(end), start: along(start) }
    }
}

/// Lets faces that meet at a node act on its velocities at the start and at the end of a step (m/s), as
/// [`Walls::constrain_and_tell`](super::Walls::constrain_and_tell) has it.
pub(super) fn constrain(
    faces: &[Face],
    (start, end): (&mut [f64; 3], &mut [f64; 3]),
    keep_start: bool,
    lift: &[f64; 3],
    tell: &mut impl FnMut(&Face, [f64; 3], [f64; 3]),
) {
    let faces = &faces[..faces.len().min(MOST)];
    let (begun, free) = (*start, *end);
    let bounds = Bounds::new(faces, end, [false; 3], |face| !face.separation && !face.holds_all());
    let pushes = bounds.project(end);
    let mut kept = [0.0; MOST];
    if !keep_start {
        kept = hold_start(faces, start);
    }
    let mut changes = Changes::of(faces, &pushes, &kept);
    let holding = |k: usize| f64::from(u8::from(faces[k].holds_all()));
    let pressed = |k: usize| if pushes[k] > 0.0 { pushes[k] } else { 0.0 };
    let sticks = |k: usize| if faces[k].kind == WallKind::Rough { pressed(k) } else { 0.0 };
    if let Some((velocity, parts)) = weighted(faces, holding) {
        // What holds bears more where it is pressed.
        let parts = weighted(faces, |k| holding(k) * pressed(k)).map_or(parts, |(_, parts)| parts);
        stick(&mut changes.end, &parts, &free, end, velocity);
        if !keep_start {
            stick(&mut changes.start, &parts, &begun, start, velocity);
        }
    } else if let Some((velocity, parts)) = weighted(faces, sticks) {
        stick(&mut changes.end, &parts, &free, end, velocity);
    } else {
        rub(faces, &pushes, lift, end, &mut changes.end);
    }
    for (k, face) in faces.iter().enumerate() {
        tell(face, changes.end[k], changes.start[k]);
    }
}

/// Takes the velocity at the start of the step (m/s) along the normals of faces that are bilateral.
fn hold_start(faces: &[Face], start: &mut [f64; 3]) -> Pushes {
    let mut pushes = [0.0; MOST];
    let mut chosen = Bounds::new(faces, start, [false; 3], |_| true);
    for (bound, face) in chosen.all.iter_mut().zip(faces) {
        if face.separation || face.holds_all() {
            *bound = Bound { normal: [0.0; 3], least: 0.0, bilateral: false };
        }
    }
    if faces.iter().any(|face| !face.separation && !face.holds_all()) {
        pushes = chosen.project(start);
    }
    pushes
}

/// Gives a node the velocity of faces that hold it; beside their pushes they bear their parts of the rest.
fn stick(
    changes: &mut [[f64; 3]; MOST],
    parts: &Pushes,
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

/// Coulomb's friction of faces, by the motion (m/s) that all of them leave. Each takes its part of what all can take.
fn rub(faces: &[Face], pushes: &Pushes, lift: &[f64; 3], end: &mut [f64; 3], changes: &mut [[f64; 3]; MOST]) {
    let bound = |k: usize| {
        let push = if pushes[k] > 0.0 { pushes[k] - dot(lift, &faces[k].normal) } else { 0.0 };
        if faces[k].kind == WallKind::Smooth { 0.0 } else { faces[k].coefficient() * push.max(0.0) }
    };
    let Some((_, parts)) = weighted(faces, bound) else { return };
    let left = *end;
    for (k, face) in faces.iter().enumerate().filter(|(k, _)| parts[*k] > 0.0) {
        let out = face.leaving(&left);
        let slides: [f64; 3] = std::array::from_fn(|c| left[c] - face.velocity[c] - out * face.normal[c]);
        let speed = length(&slides);
        let (own, least) = (bound(k), parts[k] * speed);
        let taken = if own >= least { parts[k] } else { own / speed };
        for c in 0..3 {
            let change = -taken * slides[c];
            changes[k][c] += change;
            end[c] += change;
        }
    }
}

/// Lets nothing of a velocity (m/s) into any face, without friction, by changes of the components that walls do not hold.
pub(super) fn keep_out(
    faces: &[Face],
    velocity: &mut [f64; 3],
    held: [bool; 3],
    tell: &mut impl FnMut(&Face, [f64; 3], [f64; 3]),
) {
    let faces = &faces[..faces.len().min(MOST)];
    let before = *velocity;
    let bounds = Bounds::new(faces, velocity, held, |_| false);
    let pushes = bounds.project(velocity);
    (0..3).filter(|c| held[*c]).for_each(|c| velocity[c] = before[c]);
    for (k, face) in faces.iter().enumerate().filter(|(k, _)| pushes[*k] != 0.0) {
        tell(face, bounds.all[k].normal.map(|n| pushes[k] * n), [0.0; 3]);
    }
}

/// Acts on the re-mapped velocity (MUSL) of a node that the faces have left with `solved`.
pub(super) fn constrain_again(faces: &[Face], solved: &[f64; 3], velocity: &mut [f64; 3]) {
    let faces = &faces[..faces.len().min(MOST)];
    let stopped = |face: &Face| face.has_stopped(solved) || !face.separation;
    Bounds::new(faces, velocity, [false; 3], stopped).project(velocity);
    let stuck = |face: &Face| face.holds_all() || (*solved == face.velocity && face.kind != WallKind::Smooth);
    if let Some((held, _)) = weighted(faces, |k| f64::from(u8::from(stuck(&faces[k])))) {
        *velocity = held;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn face(normal: [f64; 3], friction: f64, separation: bool) -> Face {
        let long = length(&normal);
        Face::at_rest(normal.map(|n| n / long), friction, separation)
    }

    /// Velocity that faces leave of one, and what each of them changes.
    fn act(faces: &[Face], free: [f64; 3]) -> ([f64; 3], Vec<[f64; 3]>) {
        let (mut start, mut end, mut told) = ([0.0; 3], free, vec![[0.0; 3]; faces.len()]);
        constrain(faces, (&mut start, &mut end), true, &[0.0; 3], &mut |face, change, _| {
            let number = faces.iter().position(|own| std::ptr::eq(own, face));
            told[number.unwrap_or_else(|| faces.iter().position(|own| own == face).unwrap())] = change;
        });
        (end, told)
    }

    #[test]
    fn a_corner_in_the_plane_stops_what_goes_into_both_faces() {
        let corner =
            |friction| [face([0.0, 1.0, 0.0], friction, true), face([0.8, 0.6, 0.0], friction, true)];
        for friction in [0.0, 0.4, f64::INFINITY] {
            let (end, told) = act(&corner(friction), [-0.3, -0.7, 0.0]);
            assert_eq!(end, [0.0; 3], "{friction}: nothing is left by round-off");
            let sum: [f64; 3] = std::array::from_fn(|c| told[0][c] + told[1][c]);
            assert!((sum[0] - 0.3).abs() < 1e-15 && (sum[1] - 0.7).abs() < 1e-15, "{friction}: {sum:?}");
        }
        // Along the wall, off the floor.
        let (end, told) = act(&corner(0.0), [-0.7, 0.6, 0.0]);
        assert!((end[0] + 0.6 * 0.9).abs() < 1e-15 && (end[1] - 0.8 * 0.9).abs() < 1e-15, "{end:?}");
        assert_eq!(told[0], [0.0; 3]);
    }

    #[test]
    fn faces_of_one_plane_bear_the_same() {
        for friction in [0.0, 0.3, f64::INFINITY] {
            let floor = face([0.0, 1.0, 0.0], friction, true);
            let other = Face { bearer: Some(1), ..floor };
            let (end, told) = act(&[floor, other], [1.0, -1.0, 0.0]);
            assert_eq!(told[0], told[1]);
            let exact = if friction.is_finite() { 1.0 - friction } else { 0.0 };
            assert!((end[0] - exact).abs() < 1e-15 && end[1] == 0.0, "{friction}: {end:?}");
        }
    }

    #[test]
    fn faces_that_close_on_a_node_share_their_overlap() {
        let floor = Face { velocity: [0.0, 1.0, 0.0], ..face([0.0, 1.0, 0.0], 0.0, true) };
        let roof = Face { velocity: [0.0, -1.0, 0.0], ..face([0.0, -1.0, 0.0], 0.0, true) };
        let (end, _) = act(&[floor, roof], [0.5, -0.4, 0.0]);
        assert!(end[1].abs() < 1e-12 && end[0] == 0.5, "{end:?}");
    }

    fn some_faces() -> impl Strategy<Value = Vec<Face>> {
        let friction = prop_oneof![Just(0.0), 0.05..1.0f64, Just(f64::INFINITY)];
        let one = ([-1.0..1.0f64, -1.0..1.0f64, 0.05..1.0f64], friction);
        proptest::collection::vec(one, 2..6).prop_map(|all| {
            let of = |(k, (normal, friction)): (usize, ([f64; 3], f64))| Face {
                bearer: Some(k as u8),
                ..face(normal, friction, true)
            };
            all.into_iter().enumerate().map(of).collect()
        })
    }

    proptest! {
        #[test]
        fn no_face_is_entered_and_each_bears_the_same_in_any_order(
            faces in some_faces(),
            free in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64],
            turn in 1usize..6,
        ) {
            let (end, told) = act(&faces, free);
            prop_assert!(faces.iter().all(|face| face.leaving(&end) >= -1e-11), "{end:?}");
            for c in 0..3 {
                let sum: f64 = told.iter().map(|change| change[c]).sum();
                prop_assert!((free[c] + sum - end[c]).abs() < 1e-12);
            }
            prop_assert!(length(&end) <= length(&free) + 1e-12, "friction makes no energy");
            let mut turned = faces.clone();
            turned.rotate_left(turn % faces.len());
            turned.swap(0, 1);
            let (other, of_turned) = act(&turned, free);
            prop_assert!((0..3).all(|c| (other[c] - end[c]).abs() < 1e-10), "{end:?} {other:?}");
            for (face, change) in turned.iter().zip(of_turned) {
                let own = told[usize::from(face.bearer.unwrap())];
                prop_assert!((0..3).all(|c| (own[c] - change[c]).abs() < 1e-9), "{own:?} {change:?}");
            }
        }

        #[test]
        fn smooth_faces_take_the_least_that_they_can(
            faces in some_faces(),
            free in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64],
            other in [-2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64],
        ) {
            let smooth: Vec<Face> = faces.iter().map(|face| Face { kind: WallKind::Smooth, ..*face }).collect();
            let (end, _) = act(&smooth, free);
            let away = |from: &[f64; 3]| length(&std::array::from_fn(|c| from[c] - free[c]));
            let admits = smooth.iter().all(|face| face.leaving(&other) >= 0.0);
            prop_assert!(!admits || away(&other) >= away(&end) - 1e-10);
        }

        #[test]
        fn what_the_faces_have_stopped_is_kept_out_of_all_of_them_again(
            faces in some_faces(),
            free in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64],
            mapped in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64],
        ) {
            let (solved, _) = act(&faces, free);
            let mut velocity = mapped;
            constrain_again(&faces, &solved, &mut velocity);
            prop_assert!(faces.iter().all(|face| face.leaving(&velocity) >= -1e-10), "{velocity:?}");
        }
    }
}
