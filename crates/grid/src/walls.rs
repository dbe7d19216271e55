//! Boundary conditions on the nodes.

mod edge;

use edge::Edge;

/// How a wall acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallKind {
    /// No slip.
    Rough,
    /// Free slip.
    Smooth,
    /// Coulomb friction in impulse form (MPM sheet §3.7).
    Frictional {
        /// Coefficient of friction.
        coefficient: f64,
    },
    /// Coulomb friction in acceleration form, with a larger coefficient for what is at rest (GT
    /// Algorithm 3.1 as corrected in MPM sheet §3.7).
    Plane {
        /// Coefficient for a node at rest.
        resting: f64,
        /// Coefficient for a node that slides.
        sliding: f64,
    },
}

/// A half-space of nodes beyond a plane normal to an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Axis normal to the wall.
    pub axis: usize,
    /// True for a wall above its plane (material below), false for one below.
    pub upper: bool,
    /// Node index, along the axis, of the wall's face.
    pub node: usize,
    /// How it acts.
    pub kind: WallKind,
    /// Whether material may lift off; without, the wall is bilateral and its normal velocity is that of what it holds.
    pub separation: bool,
    /// Velocity of the wall (m/s).
    pub velocity: [f64; 3],
}

/// All walls of a grid, looked up by node index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Walls {
    walls: Vec<Wall>,
    /// `lookup[axis][index]`: number of the wall plus one, zero for none.
    lookup: [Vec<u32>; 3],
    /// Whether walls that move set off in this step: what they hold is not yet as fast as they are.
    sets_off: bool,
    /// On a mesh: distance between neighbouring entries of a node's index, and `lookup` is by node.
    strides: Option<[usize; 3]>,
}

impl Walls {
    /// The walls of a grid with `nodes` nodes per axis. Where two walls normal to the same axis claim
    /// a node, the later one has it.
    pub fn new(nodes: &[usize], walls: Vec<Wall>) -> Self {
        let mut lookup: [Vec<u32>; 3] = Default::default();
        for (axis, &count) in nodes.iter().enumerate() {
            lookup[axis] = vec![0; count];
        }
        for (number, wall) in walls.iter().enumerate() {
            let nodes = &mut lookup[wall.axis];
            let range = if wall.upper { wall.node..nodes.len() } else { 0..wall.node + 1 };
            nodes[range].fill(number as u32 + 1);
        }
        Self { walls, lookup, sets_off: false, strides: None }
    }

    /// The walls of a mesh with `count` nodes (of a layout with `strides`), each with the nodes it holds.
    pub fn of_nodes<const D: usize>(strides: [usize; D], count: usize, walls: Vec<(Wall, Vec<u32>)>) -> Self {
        let mut lookup: [Vec<u32>; 3] = Default::default();
        lookup[..D].fill(vec![0; count]);
        for (number, (wall, nodes)) in walls.iter().enumerate() {
            nodes.iter().for_each(|&node| lookup[wall.axis][node as usize] = number as u32 + 1);
        }
        let strides = std::array::from_fn(|axis| strides.get(axis).copied().unwrap_or(0));
        let walls = walls.into_iter().map(|(wall, _)| wall).collect();
        Self { walls, lookup, sets_off: false, strides: Some(strides) }
    }

    /// The wall normal to `axis` that holds the node with an index along each axis.
    #[inline]
    pub fn at(&self, axis: usize, index: &[usize; 3]) -> Option<&Wall> {
        let entry = match self.strides {
            None => index[axis],
            Some(strides) => (0..3).map(|a| index[a] * strides[a]).sum(),
        };
        match self.lookup[axis][entry] {
            0 => None,
            number => Some(&self.walls[number as usize - 1]),
        }
    }

    /// The walls that hold a node, axis by axis.
    fn of_node(&self, index: &[usize; 3]) -> impl Iterator<Item = &Wall> {
        let axes = (0..3).filter(|axis| !self.lookup[*axis].is_empty());
        axes.filter_map(|axis| self.at(axis, index))
    }

    /// Says whether walls that move set off in this step. Then they take along what they hold, as a prescribed motion that
    /// begins does: without an acceleration the points beside would never have the speed of the wall.
    pub fn set_off(&mut self, sets_off: bool) {
        self.sets_off = sets_off;
    }

    /// Lets the walls of a node act: `start` is its velocity before the step, `end` the one after the momentum solve. With
    /// `keep_start` the start velocity is left as it was (momentum variant of fixed nodes), else a held component has no
    /// acceleration (force variant, MPM sheet §3.3).
    pub fn constrain(&self, index: &[usize; 3], start: &mut [f64; 3], end: &mut [f64; 3], keep_start: bool) {
        self.constrain_skeleton(index, start, end, keep_start, &[0.0; 3]);
    }

    /// The same for the skeleton of a saturated soil: friction goes by the effective stress. `lift` (m/s) is the change
    /// of velocity that what the wall bears of the pore pressure would give the skeleton.
    ///
    /// In an edge no wall comes first: friction goes by the motion that all of them leave along the wall.
    pub fn constrain_skeleton(
        &self,
        index: &[usize; 3],
        start: &mut [f64; 3],
        end: &mut [f64; 3],
        keep_start: bool,
        lift: &[f64; 3],
    ) {
        let walls = |held: bool| self.of_node(index).filter(move |wall| wall.holds() == held);
        let keep = |wall: &Wall| keep_start || (self.sets_off && wall.velocity != [0.0; 3]);
        walls(true).for_each(|wall| wall.hold(start, end, keep(wall)));
        let (mut pushes, [begun, free]) = ([None; 3], [*start, *end]);
        walls(false).for_each(|wall| pushes[wall.axis] = wall.stop(start, end, keep(wall), lift));
        if pushes == [None; 3] {
            return;
        }
        if walls(false).any(|wall| walls(false).any(|other| other.velocity != wall.velocity)) {
            let edge = Edge {
                walls: std::array::from_fn(|axis| walls(false).find(|wall| wall.axis == axis)),
                held: walls(true).fold([false; 3], |held, wall| {
                    std::array::from_fn(|c| held[c] || wall.held_components().contains(&c))
                }),
                start: *start,
                free,
                lift: *lift,
            };
            *end = edge.solve(pushes);
            // What others rubbed off a wall is not held there.
            for wall in walls(false).filter(|wall| end[wall.axis] != wall.velocity[wall.axis]) {
                start[wall.axis] = begun[wall.axis];
            }
        } else {
            for wall in walls(false) {
                if let Some(push) = pushes[wall.axis] {
                    wall.rub(start, end, push);
                }
            }
        }
        walls(true).for_each(|wall| wall.hold(start, end, keep(wall)));
    }

    /// Which components of the velocity of a node its walls hold now that it has ended with `end`.
    pub fn holding(&self, index: &[usize; 3], end: &[f64; 3]) -> [bool; 3] {
        self.of_node(index).fold([false; 3], |held, wall| {
            let own = wall.holding(end);
            std::array::from_fn(|c| held[c] || own[c])
        })
    }

    /// Lets the walls of a node act on its re-mapped velocity (MUSL): no penetration; what they stopped in the momentum
    /// solve (`solved`) does not lift off, and what stuck sticks.
    pub fn constrain_again(&self, index: &[usize; 3], solved: &[f64; 3], velocity: &mut [f64; 3]) {
        let walls = |held: bool| self.of_node(index).filter(move |wall| wall.holds() == held);
        walls(false).for_each(|wall| wall.constrain_again(solved, velocity));
        walls(true).for_each(|wall| wall.hold(&mut [0.0; 3], velocity, true));
    }

    /// One for each component of velocity that no wall of a node holds whatever happens, else zero.
    pub fn free_components(&self, index: &[usize; 3]) -> [f64; 3] {
        self.of_node(index).fold([1.0; 3], |mut free, wall| {
            let own = wall.free_components();
            (0..3).for_each(|c| free[c] *= own[c]);
            free
        })
    }

    /// True when no wall is normal to `axis` at `index`: the quick test of a node's row. On a mesh with walls no row is
    /// known to be free.
    #[inline]
    pub fn is_free(&self, axis: usize, index: usize) -> bool {
        match self.strides {
            None => self.lookup[axis][index] == 0,
            Some(_) => self.walls.is_empty(),
        }
    }
}

fn length(vector: &[f64; 3]) -> f64 {
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
}

impl Wall {
    fn approach(&self, velocity: &[f64; 3]) -> f64 {
        let normal = velocity[self.axis] - self.velocity[self.axis];
        if self.upper { normal } else { -normal }
    }

    /// True when the wall fixes all that it acts on whatever the material does (no separation, no friction).
    fn holds(&self) -> bool {
        !self.separation && matches!(self.kind, WallKind::Rough | WallKind::Smooth)
    }

    /// One for each component of velocity that the wall leaves to the material whatever happens, else zero.
    fn free_components(&self) -> [f64; 3] {
        let held = if self.separation { 0..0 } else { self.held_components() };
        std::array::from_fn(|c| if held.contains(&c) { 0.0 } else { 1.0 })
    }

    /// Which components it holds of a node that it has left with `end`.
    fn holding(&self, end: &[f64; 3]) -> [bool; 3] {
        if self.holds() {
            let held = self.held_components();
            return std::array::from_fn(|c| held.contains(&c));
        }
        let stopped = end[self.axis] == self.velocity[self.axis];
        let stuck = *end == self.velocity && self.kind != WallKind::Smooth;
        std::array::from_fn(|c| stuck || (stopped && c == self.axis))
    }

    /// Gives a node the velocity of the wall in the components that it holds.
    #[inline]
    fn hold(&self, start: &mut [f64; 3], end: &mut [f64; 3], keep_start: bool) {
        for component in self.held_components() {
            end[component] = self.velocity[component];
            if !keep_start {
                start[component] = self.velocity[component];
            }
        }
    }

    /// Stops a node that runs into the wall, or that a bilateral one holds: as a fixed component, with `keep_start` or
    /// without acceleration. What runs into one that may let go always has the acceleration that stops it. The change of velocity into the wall (m/s) that friction goes by, less `lift`,
    /// which a fluid in the pores bears. `None` where the node moves off.
    #[inline]
    fn stop(
        &self,
        start: &mut [f64; 3],
        end: &mut [f64; 3],
        keep_start: bool,
        lift: &[f64; 3],
    ) -> Option<f64> {
        if self.separation && self.approach(end) <= 0.0 {
            return None;
        }
        let dry: [f64; 3] = std::array::from_fn(|c| end[c] + lift[c]);
        end[self.axis] = self.velocity[self.axis];
        let plane = matches!(self.kind, WallKind::Plane { .. });
        // Of a plane a_n dt of the sheet: a node that only runs into it, without being pushed, has none, and then no friction
        // (step 1).
        let push = self.approach(&dry) - if plane { self.approach(start) } else { 0.0 };
        // Step 4. The force variant does not see the momentum that points carry into the wall.
        if (plane || !self.separation) && !keep_start {
            start[self.axis] = self.velocity[self.axis];
        }
        Some(push)
    }

    /// Friction on a stopped node, by the `push` into the wall (m/s); none where it is pulled.
    #[inline]
    fn rub(&self, start: &[f64; 3], end: &mut [f64; 3], push: f64) {
        match self.kind {
            WallKind::Smooth => return,
            WallKind::Rough => {
                *end = self.velocity;
                return;
            }
            WallKind::Frictional { .. } | WallKind::Plane { .. } => {}
        }
        let slip = self.along(end);
        let speed = length(&slip);
        let bound = self.coefficient(start, speed) * push.max(0.0);
        let keep = if speed <= bound { 0.0 } else { 1.0 - bound / speed };
        for c in (0..3).filter(|c| *c != self.axis) {
            end[c] = self.velocity[c] + keep * slip[c];
        }
    }

    /// What a velocity has along the wall, relative to it (m/s).
    #[inline]
    fn along(&self, velocity: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|c| if c == self.axis { 0.0 } else { velocity[c] - self.velocity[c] })
    }

    /// Coefficient of friction of a node that slips by `speed` (m/s) now.
    #[inline]
    fn coefficient(&self, start: &[f64; 3], speed: f64) -> f64 {
        match self.kind {
            WallKind::Smooth => 0.0,
            WallKind::Rough => f64::INFINITY,
            WallKind::Frictional { coefficient } => coefficient,
            // Steps 2 and 3: from rest the slip is a_t dt, sliding it is v_t + a_t dt, and in both the bound on the friction
            // is along it. At rest is what round-off cannot tell from it.
            WallKind::Plane { resting, .. } if length(&self.along(start)) <= 1e-14 * speed => resting,
            WallKind::Plane { sliding, .. } => sliding,
        }
    }

    /// Constrains the re-mapped velocity of MUSL: no penetration; what the wall stopped in the momentum solve (`solved`)
    /// does not lift off, or the force of the wall would do work; and what stuck sticks.
    #[inline]
    fn constrain_again(&self, solved: &[f64; 3], velocity: &mut [f64; 3]) {
        let held = self.holding(solved);
        if !self.separation || held[self.axis] || self.approach(velocity) > 0.0 {
            velocity[self.axis] = self.velocity[self.axis];
            if held == [true; 3] {
                *velocity = self.velocity;
            }
        }
    }

    fn held_components(&self) -> std::ops::Range<usize> {
        if self.kind == WallKind::Rough { 0..3 } else { self.axis..self.axis + 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor(kind: WallKind, separation: bool) -> Wall {
        Wall { axis: 1, upper: false, node: 0, kind, separation, velocity: [0.0; 3] }
    }

    /// The walls of a node with this one only.
    fn alone(wall: Wall) -> Walls {
        Walls::new(&[1; 3], vec![wall])
    }

    fn act(wall: Wall, start: &mut [f64; 3], end: &mut [f64; 3], keep_start: bool, lift: &[f64; 3]) {
        alone(wall).constrain_skeleton(&[0; 3], start, end, keep_start, lift);
    }

    /// Every kind of wall on each axis, and a node that runs into some of them.
    #[test]
    fn no_axis_comes_first_in_an_edge() {
        let kinds = [
            None,
            Some((WallKind::Rough, true)),
            Some((WallKind::Smooth, false)),
            Some((WallKind::Smooth, true)),
            Some((WallKind::Frictional { coefficient: 0.3 }, true)),
            Some((WallKind::Frictional { coefficient: 0.7 }, false)),
            Some((WallKind::Plane { resting: 0.6, sliding: 0.4 }, true)),
        ];
        let turned = |v: [f64; 3]| [v[2], v[0], v[1]];
        let (start, end) = ([0.4, -0.1, 0.2], [1.3, -0.8, -0.5]);
        for code in 0..kinds.len().pow(3) {
            let wall = |axis: usize, place: usize| {
                let (kind, separation) = kinds[code / kinds.len().pow(axis as u32) % kinds.len()]?;
                Some(Wall { axis: place, ..floor(kind, separation) })
            };
            let here = Walls::new(&[1; 3], (0..3).filter_map(|axis| wall(axis, axis)).collect());
            let there = Walls::new(&[1; 3], (0..3).filter_map(|axis| wall(axis, (axis + 1) % 3)).collect());
            for keep_start in [false, true] {
                let (mut from, mut to) = (start, end);
                here.constrain(&[0; 3], &mut from, &mut to, keep_start);
                let (mut from_turned, mut to_turned) = (turned(start), turned(end));
                there.constrain(&[0; 3], &mut from_turned, &mut to_turned, keep_start);
                let distance =
                    |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
                assert!(distance(turned(from), from_turned) < 1e-15, "{here:?}: {from:?}, {from_turned:?}");
                assert!(distance(turned(to), to_turned) < 1e-15, "{here:?}: {to:?}, {to_turned:?}");
            }
        }
    }

    #[test]
    fn what_a_smooth_side_holds_does_not_slip_on_the_floor() {
        for [side, floor, along] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let wall = |axis, kind, separation| Wall {
                axis,
                upper: false,
                node: 0,
                kind,
                separation,
                velocity: [0.0; 3],
            };
            let smooth = wall(side, WallKind::Smooth, false);
            let walls = Walls::new(
                &[1; 3],
                vec![smooth, wall(floor, WallKind::Frictional { coefficient: 0.5 }, true)],
            );
            let mut end = [0.0; 3];
            (end[side], end[floor], end[along]) = (9.0, -1.0, 0.4);
            walls.constrain(&[0; 3], &mut [0.0; 3], &mut end, false);
            assert_eq!(end, [0.0; 3], "0.4 is less than 0.5 × 1: it sticks, whatever pushes it to the side");
        }
    }

    #[test]
    fn friction_takes_the_coulomb_share_of_the_normal_impulse() {
        let wall = floor(WallKind::Frictional { coefficient: 0.5 }, true);
        let (mut start, mut end) = ([3.0, 0.0, 4.0], [3.0, -2.0, 4.0]);
        act(wall, &mut start, &mut end, true, &[0.0; 3]);
        // |v_t| = 5 is reduced by 0.5 × 2.
        assert!((end[0] - 3.0 * 0.8).abs() < 1e-15 && end[1] == 0.0 && (end[2] - 4.0 * 0.8).abs() < 1e-15);
        let mut end = [0.3, -2.0, 0.4];
        act(wall, &mut start, &mut end, true, &[0.0; 3]);
        assert_eq!(end, [0.0; 3], "slower than the friction allows: it sticks");
    }

    #[test]
    fn a_frictional_plane_follows_the_algorithm_of_the_sheet() {
        // Pushed into the floor by 2 m/s in the step; (start, end along it, expected end).
        let wall = floor(WallKind::Plane { resting: 0.5, sliding: 0.25 }, true);
        let table = [
            ([0.0, 0.0], [0.6, 0.8], [0.0, 0.0]), // at rest: 1 is not more than 0.5 × 2
            ([0.0, 0.0], [3.0, 4.0], [2.4, 3.2]), // sets off: 5 - 0.5 × 2
            ([3.0, 4.0], [3.0, 4.0], [2.7, 3.6]), // slides: 5 - 0.25 × 2
            ([3.0, 4.0], [0.3, 0.4], [0.0, 0.0]), // comes to rest: 0.5 is not more than 0.25 × 2
            ([0.0, 5.0], [3.0, 4.0], [2.7, 3.6]), // friction is along the speed it would end with
        ];
        for (before, after, expected) in table {
            for (approach, keep_start) in [(0.0, false), (0.7, true)] {
                let mut start = [before[0], -approach, before[1]];
                let mut end = [after[0], -approach - 2.0, after[1]];
                act(wall, &mut start, &mut end, keep_start, &[0.0; 3]);
                let close = |a: f64, b: f64| (a - b).abs() < 1e-15;
                assert!(close(end[0], expected[0]) && end[1] == 0.0 && close(end[2], expected[1]), "{end:?}");
                assert_eq!(start[1], -approach, "left, or without acceleration");
            }
        }
        // It runs into the wall without being pushed: stopped, without friction.
        let mut end = [3.0, -0.5, 0.0];
        act(wall, &mut [3.0, -0.7, 0.0], &mut end, true, &[0.0; 3]);
        assert_eq!(end, [3.0, 0.0, 0.0]);
    }

    #[test]
    fn what_pore_pressure_bears_does_not_rub() {
        for (kind, friction) in [
            (WallKind::Frictional { coefficient: 0.5 }, 0.5 * (2.0 - 1.5)),
            (WallKind::Plane { resting: 0.5, sliding: 0.25 }, 0.25 * (2.0 - 1.5)),
        ] {
            let mut end = [3.0, -2.0, 0.0];
            act(floor(kind, true), &mut [3.0, 0.0, 0.0], &mut end, false, &[0.0, 1.5, 0.0]);
            assert!((end[0] - (3.0 - friction)).abs() < 1e-15 && end[1] == 0.0, "{kind:?}: {end:?}");
            // It bears all: the wall stops without friction. From above it pushes the other way.
            let mut end = [3.0, -2.0, 0.0];
            act(floor(kind, true), &mut [3.0, 0.0, 0.0], &mut end, false, &[0.0, 2.5, 0.0]);
            assert_eq!(end, [3.0, 0.0, 0.0], "{kind:?}");
            let mut end = [3.0, 2.0, 0.0];
            let ceiling = Wall { upper: true, ..floor(kind, true) };
            act(ceiling, &mut [3.0, 0.0, 0.0], &mut end, false, &[0.0, -1.5, 0.0]);
            assert!((end[0] - (3.0 - friction)).abs() < 1e-15 && end[1] == 0.0, "{kind:?}: {end:?}");
        }
    }

    #[test]
    fn the_last_of_many_walls_holds_its_nodes() {
        let many = (0..300).map(|node| Wall { node, ..floor(WallKind::Smooth, false) }).rev().collect();
        let walls = Walls::new(&[1, 400], many);
        assert_eq!(walls.at(1, &[0, 0, 0]).map(|wall| wall.node), Some(0));
        assert_eq!(walls.at(1, &[0, 299, 0]).map(|wall| wall.node), Some(299));
        assert_eq!(walls.at(1, &[0, 300, 0]), None);
    }

    #[test]
    fn unilateral_walls_let_go() {
        let plane = WallKind::Plane { resting: 1.0, sliding: 0.5 };
        for kind in [WallKind::Rough, WallKind::Smooth, WallKind::Frictional { coefficient: 1.0 }, plane] {
            let mut end = [1.0, 0.5, 0.0];
            act(floor(kind, true), &mut [0.0; 3], &mut end, true, &[0.0; 3]);
            assert_eq!(end, [1.0, 0.5, 0.0]);
        }
    }

    #[test]
    fn bilateral_walls_hold_what_is_pulled_off_without_friction() {
        let plane = WallKind::Plane { resting: 1.0, sliding: 0.5 };
        for kind in [WallKind::Frictional { coefficient: 0.5 }, plane] {
            let wall = floor(kind, false);
            let (mut start, mut end) = ([3.0, 0.1, 4.0], [3.0, 2.0, 4.0]);
            act(wall, &mut start, &mut end, true, &[0.0; 3]);
            assert_eq!((start, end), ([3.0, 0.1, 4.0], [3.0, 0.0, 4.0]), "pulled: {kind:?}");
            act(wall, &mut [3.0, 0.0, 4.0], &mut end, false, &[0.0, 1.0, 0.0]);
            assert_eq!(end, [3.0, 0.0, 4.0], "the fluid pushes it off: {kind:?}");
            // Pushed by 2 m/s in the step: as every wall with friction.
            let (mut start, mut pushed) = ([3.0, 0.0, 4.0], [3.0, -2.0, 4.0]);
            act(wall, &mut start, &mut pushed, true, &[0.0; 3]);
            assert!((pushed[0] - 2.4).abs() < 1e-15 && pushed[1] == 0.0 && (pushed[2] - 3.2).abs() < 1e-15);
            assert_eq!(wall.free_components(), [1.0, 0.0, 1.0]);
            assert_eq!(floor(kind, true).free_components(), [1.0; 3]);
            // Re-mapped, and (solved with NaN) before the solve.
            for solved in [[3.0, 0.0, 4.0], [f64::NAN; 3]] {
                let mut velocity = [1.0, 0.2, 0.0];
                alone(wall).constrain_again(&[0; 3], &solved, &mut velocity);
                assert_eq!(velocity, [1.0, 0.0, 0.0], "{kind:?}");
            }
        }
        // The acceleration form goes by the acceleration into the wall, though the node still moves off.
        let (mut start, mut end) = ([3.0, 2.0, 4.0], [3.0, 0.5, 4.0]);
        act(floor(plane, false), &mut start, &mut end, false, &[0.0; 3]);
        assert!((end[0] - 3.0 * 0.85).abs() < 1e-15 && end[1] == 0.0 && start[1] == 0.0, "{end:?}");
    }

    #[test]
    fn a_wall_holds_what_it_has_stopped() {
        let rubs = floor(WallKind::Frictional { coefficient: 0.5 }, true);
        assert_eq!(rubs.holding(&[0.0; 3]), [true; 3], "sticks");
        assert_eq!(rubs.holding(&[1.0, 0.0, 0.0]), [false, true, false], "slides");
        assert_eq!(rubs.holding(&[0.0, 0.1, 0.0]), [false; 3], "lifts off");
        assert_eq!(floor(WallKind::Smooth, true).holding(&[0.0; 3]), [false, true, false]);
        assert_eq!(floor(WallKind::Smooth, false).holding(&[1.0, 2.0, 3.0]), [false, true, false]);
        assert_eq!(floor(WallKind::Rough, false).holding(&[1.0, 2.0, 3.0]), [true; 3]);
    }

    #[test]
    fn what_a_wall_stopped_in_the_solve_does_not_lift_off_as_it_is_re_mapped() {
        let wall = floor(WallKind::Frictional { coefficient: 0.5 }, true);
        for (solved, remapped, expected) in [
            ([1.0, 0.0, 0.0], [1.1, 0.2, 0.0], [1.1, 0.0, 0.0]), // slides
            ([0.0, 0.0, 0.0], [0.1, 0.2, 0.3], [0.0, 0.0, 0.0]), // sticks
            ([1.0, 0.3, 0.0], [1.1, 0.2, 0.0], [1.1, 0.2, 0.0]), // lifts off
            ([1.0, 0.3, 0.0], [1.1, -0.2, 0.0], [1.1, 0.0, 0.0]), // may not come back
        ] {
            let mut velocity = remapped;
            alone(wall).constrain_again(&[0; 3], &solved, &mut velocity);
            assert_eq!(velocity, expected);
        }
    }

    #[test]
    fn the_force_variant_leaves_no_acceleration_on_a_held_node() {
        let (mut start, mut end) = ([1.0, -0.1, 0.0], [2.0, -0.7, 0.0]);
        act(floor(WallKind::Smooth, false), &mut start, &mut end, false, &[0.0; 3]);
        assert_eq!((start, end), ([1.0, 0.0, 0.0], [2.0, 0.0, 0.0]));
        act(floor(WallKind::Rough, false), &mut start, &mut end, false, &[0.0; 3]);
        assert_eq!((start, end), ([0.0; 3], [0.0; 3]));
    }

    #[test]
    fn a_bilateral_wall_without_friction_is_a_smooth_one() {
        let plane = WallKind::Plane { resting: 0.0, sliding: 0.0 };
        for kind in [WallKind::Frictional { coefficient: 0.0 }, plane] {
            for (keep_start, normal) in [(false, -0.7), (false, 0.7), (true, -0.7), (true, 0.7)] {
                let ends = [kind, WallKind::Smooth].map(|kind| {
                    let (mut start, mut end) = ([1.0, -0.1, 0.0], [2.0, normal, 0.3]);
                    act(floor(kind, false), &mut start, &mut end, keep_start, &[0.0; 3]);
                    (start, end)
                });
                assert_eq!(ends[0], ends[1], "{kind:?}, momentum variant: {keep_start}");
            }
        }
    }

    #[test]
    fn lookup_covers_everything_beyond_the_face() {
        let upper = Wall { upper: true, node: 3, axis: 0, ..floor(WallKind::Rough, false) };
        let walls = Walls::new(&[6, 5], vec![floor(WallKind::Smooth, false), upper]);
        assert!(walls.at(1, &[2, 0, 0]).is_some() && walls.is_free(1, 1));
        assert!(
            walls.is_free(0, 2) && walls.at(0, &[3, 1, 0]) == walls.at(0, &[5, 1, 0]) && !walls.is_free(0, 5)
        );
    }
}
