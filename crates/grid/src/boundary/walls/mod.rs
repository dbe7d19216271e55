//! Boundary conditions on the nodes.

mod corner;
mod friction_edge;
mod node_faces;

use std::sync::Arc;

use crate::boundary::walls::friction_edge::FrictionEdge;
pub use crate::boundary::walls::node_faces::{NodeFace, NodeFaces};

/// Contact condition of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallKind {
    /// No slip.
    Rough,
    /// Free slip.
    Smooth,
    /// Coulomb friction in impulse form (sheet: mpm §3.7).
    Frictional {
        /// Coefficient of friction.
        coefficient: f64,
    },
    /// Coulomb friction in acceleration form, with a larger coefficient for nodes at rest (GT
    /// Algorithm 3.1 as corrected in `sheet: mpm §3.7`).
    StaticAndSliding {
        /// Coefficient for a node at rest.
        static_coefficient: f64,
        /// Coefficient for a node that slides.
        sliding_coefficient: f64,
    },
}

/// Wall: a half-space that begins at a plane of nodes normal to an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeWall {
    /// Axis normal to the wall.
    pub axis: usize,
    /// Whether the wall is above its plane, with material below.
    pub is_upper: bool,
    /// Node index, along the axis, of the wall's face.
    pub node: usize,
    /// Contact condition.
    pub kind: WallKind,
    /// Whether material may separate; without separation the wall is bilateral and prescribes the normal velocity.
    pub separation: bool,
    /// Velocity of the wall (m/s).
    pub velocity: [f64; 3],
}

/// All walls of a grid, by node index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeWalls {
    walls: Vec<NodeWall>,
    /// `lookup[axis][index]`: number of the wall plus one, zero for none.
    lookup: [Vec<u32>; 3],
    /// Whether moving walls start in this step, so that constrained nodes do not yet have their velocity.
    starts_moving: bool,
    /// Node strides of a mesh; then `lookup` is by node.
    strides: Option<[usize; 3]>,
    /// Rigid geometry of any shape.
    faces: Arc<NodeFaces>,
}

impl NodeWalls {
    /// Returns the walls of a grid with `nodes` nodes per axis. Where two walls normal to the same axis include
    /// a node, the later one acts.
    pub fn new(nodes: &[usize], walls: Vec<NodeWall>) -> Self {
        let mut lookup: [Vec<u32>; 3] = Default::default();
        for (axis, &count) in nodes.iter().enumerate() {
            lookup[axis] = vec![0; count];
        }
        for (number, wall) in walls.iter().enumerate() {
            let nodes = &mut lookup[wall.axis];
            let range = if wall.is_upper { wall.node..nodes.len() } else { 0..wall.node + 1 };
            nodes[range].fill(number as u32 + 1);
        }
        Self { walls, lookup, starts_moving: false, strides: None, faces: Arc::default() }
    }

    /// Walls of a mesh with `count` nodes in a layout with `strides`, each given with its nodes.
    pub fn for_mesh_nodes<const D: usize>(
        strides: [usize; D],
        count: usize,
        walls: Vec<(NodeWall, Vec<u32>)>,
    ) -> Self {
        let mut lookup: [Vec<u32>; 3] = Default::default();
        lookup[..D].fill(vec![0; count]);
        for (number, (wall, nodes)) in walls.iter().enumerate() {
            nodes.iter().for_each(|&node| lookup[wall.axis][node as usize] = number as u32 + 1);
        }
        let strides = std::array::from_fn(|axis| strides.get(axis).copied().unwrap_or(0));
        let walls = walls.into_iter().map(|(wall, _)| wall).collect();
        Self { walls, lookup, starts_moving: false, strides: Some(strides), faces: Arc::default() }
    }

    /// Adds rigid geometry of any shape to the walls.
    #[must_use]
    pub fn with_faces(self, faces: Arc<NodeFaces>) -> Self {
        Self { faces, ..self }
    }

    /// Rigid geometry of any shape.
    pub fn faces(&self) -> &Arc<NodeFaces> {
        &self.faces
    }

    /// Mutable faces of rigid geometry; they are copied if they are shared.
    pub fn faces_mut(&mut self) -> &mut NodeFaces {
        Arc::make_mut(&mut self.faces)
    }

    /// Wall normal to `axis` at a node index, if there is one.
    #[inline]
    pub fn wall_at(&self, axis: usize, index: &[usize; 3]) -> Option<&NodeWall> {
        let entry = match self.strides {
            None => index[axis],
            Some(strides) => (0..3).map(|a| index[a] * strides[a]).sum(),
        };
        match self.lookup[axis][entry] {
            0 => None,
            number => Some(&self.walls[number as usize - 1]),
        }
    }

    /// Walls of a node, axis by axis.
    fn walls_of_node(&self, index: &[usize; 3]) -> impl Iterator<Item = &NodeWall> {
        let axes = (0..3).filter(|axis| !self.lookup[*axis].is_empty());
        axes.filter_map(|axis| self.wall_at(axis, index))
    }

    /// Sets whether moving walls start their motion in this step. Then constrained nodes get an acceleration, as with a prescribed motion
    /// that begins: without it, points beside the wall would never have its speed.
    pub fn set_starts_moving(&mut self, sets_off: bool) {
        self.starts_moving = sets_off;
    }

    /// Applies the walls to a node with the velocity `start` before the step and `end` after the momentum solve (m/s). With `keep_start`
    /// the start velocity is unchanged (momentum variant of fixed nodes); without, a prescribed component has no acceleration (force
    /// variant, sheet: mpm §3.3).
    pub fn constrain(&self, index: &[usize; 3], start: &mut [f64; 3], end: &mut [f64; 3], keep_start: bool) {
        self.constrain_skeleton(index, start, end, keep_start, &[0.0; 3]);
    }

    /// Applies the walls to the skeleton of a saturated soil, with friction by the effective stress. `lift` is the change of the skeleton
    /// velocity that the pore pressure on the wall would cause (m/s).
    ///
    /// In an edge, all walls act at once: friction depends on the sliding velocity after all of them. The same holds for faces at one node.
    /// Rigid geometry of any shape acts before walls.
    pub fn constrain_skeleton(
        &self,
        index: &[usize; 3],
        start: &mut [f64; 3],
        end: &mut [f64; 3],
        keep_start: bool,
        lift: &[f64; 3],
    ) {
        self.constrain_and_record(index, start, end, keep_start, lift, |_, _, _| {});
    }

    /// Applies the walls like [`Self::constrain_skeleton`], and calls `tell` with the velocity changes at the end and the start of the step
    /// by each face of rigid geometry (m/s).
    #[inline]
    pub fn constrain_and_record(
        &self,
        index: &[usize; 3],
        start: &mut [f64; 3],
        end: &mut [f64; 3],
        keep_start: bool,
        lift: &[f64; 3],
        mut tell: impl FnMut(&NodeFace, [f64; 3], [f64; 3]),
    ) {
        let faces = self.faces.faces_at(index);
        match faces {
            [] => {}
            [face] => {
                let before = (*start, *end);
                face.constrain(start, end, keep_start, lift);
                tell(face, minus(end, &before.1), minus(start, &before.0));
            }
            _ => corner::constrain(faces, (start, end), keep_start, lift, &mut tell),
        }
        self.constrain_by_walls(index, start, end, keep_start, lift);
        // Where several faces or walls act, the change by one may lead into another.
        if faces.len() > 1 || (!faces.is_empty() && self.walls_of_node(index).next().is_some()) {
            let held = self.walls_of_node(index).fold([false; 3], |held, wall| {
                let own = wall.constrained_components(end);
                std::array::from_fn(|c| held[c] || own[c])
            });
            if let [face] = faces {
                let before = *end;
                face.remove_penetration(end, held);
                tell(face, minus(end, &before), [0.0; 3]);
            } else {
                corner::remove_penetration(faces, end, held, &mut tell);
            }
        }
    }

    /// Imposes the walls of a node on its velocities at the start and the end of a step (m/s), with friction.
    fn constrain_by_walls(
        &self,
        index: &[usize; 3],
        start: &mut [f64; 3],
        end: &mut [f64; 3],
        keep_start: bool,
        lift: &[f64; 3],
    ) {
        let walls =
            |held: bool| self.walls_of_node(index).filter(move |wall| wall.is_unconditional() == held);
        let keep = |wall: &NodeWall| keep_start || (self.starts_moving && wall.velocity != [0.0; 3]);
        walls(true).for_each(|wall| wall.impose_velocity(start, end, keep(wall)));
        let (mut pushes, [begun, free]) = ([None; 3], [*start, *end]);
        walls(false).for_each(|wall| pushes[wall.axis] = wall.stop(start, end, keep(wall), lift));
        if pushes == [None; 3] {
            return;
        }
        if walls(false).any(|wall| walls(false).any(|other| other.velocity != wall.velocity)) {
            let edge = FrictionEdge {
                walls: std::array::from_fn(|axis| walls(false).find(|wall| wall.axis == axis)),
                constrained_components: walls(true).fold([false; 3], |held, wall| {
                    std::array::from_fn(|c| held[c] || wall.unconditional_components().contains(&c))
                }),
                start: *start,
                free_velocity: free,
                pore_pressure_part: *lift,
            };
            *end = edge.solve(pushes);
            // A wall that others have opened by friction does not constrain the node.
            for wall in walls(false).filter(|wall| end[wall.axis] != wall.velocity[wall.axis]) {
                start[wall.axis] = begun[wall.axis];
            }
        } else {
            for wall in walls(false) {
                if let Some(push) = pushes[wall.axis] {
                    wall.apply_friction(start, end, push);
                }
            }
        }
        walls(true).for_each(|wall| wall.impose_velocity(start, end, keep(wall)));
    }

    /// Whether each velocity component of a node is constrained by its walls; `end` is its velocity at the end of the step (m/s).
    pub fn constrained_components(&self, index: &[usize; 3], end: &[f64; 3]) -> [bool; 3] {
        if self.faces.faces_at(index).iter().any(|face| face.is_in_contact(end)) {
            return [true; 3];
        }
        self.walls_of_node(index).fold([false; 3], |held, wall| {
            let own = wall.constrained_components(end);
            std::array::from_fn(|c| held[c] || own[c])
        })
    }

    /// Constrains the re-mapped velocity of a node (MUSL) to no penetration. If the momentum solve (`solved`) had contact there is no
    /// separation, and if it had sticking there is no slip.
    pub fn constrain_remapped(&self, index: &[usize; 3], solved: &[f64; 3], velocity: &mut [f64; 3]) {
        match self.faces.faces_at(index) {
            [] => {}
            [face] => face.constrain_remapped(solved, velocity),
            faces => corner::constrain_remapped(faces, solved, velocity),
        }
        let walls =
            |held: bool| self.walls_of_node(index).filter(move |wall| wall.is_unconditional() == held);
        walls(false).for_each(|wall| wall.constrain_remapped(solved, velocity));
        walls(true).for_each(|wall| wall.impose_velocity(&mut [0.0; 3], velocity, true));
    }

    /// Factors of the velocity components of a node: 0 where a wall prescribes the component unconditionally, else 1.
    pub fn free_components(&self, index: &[usize; 3]) -> [f64; 3] {
        if self.faces.faces_at(index).iter().any(NodeFace::is_fully_bonded) {
            return [0.0; 3];
        }
        self.walls_of_node(index).fold([1.0; 3], |mut free, wall| {
            let own = wall.free_components();
            (0..3).for_each(|c| free[c] *= own[c]);
            free
        })
    }

    /// Whether there is no wall normal to `axis` at a node index and, for the first axis, no face in that row of nodes. It is a quick test
    /// for rows without constraints. False on a mesh with walls.
    #[inline]
    pub fn is_row_free(&self, axis: usize, index: usize) -> bool {
        !(self.has_wall(axis, index) || axis == 0 && self.faces.has_faces_in_row(index))
    }

    /// Whether there is a wall normal to `axis` at a node index; on a mesh, whether there is any wall normal to it.
    #[inline]
    pub fn has_wall(&self, axis: usize, index: usize) -> bool {
        match self.strides {
            None => self.lookup[axis][index] != 0,
            Some(_) => !self.walls.is_empty(),
        }
    }
}

/// Difference `a - b`.
fn minus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] - b[c])
}

/// Euclidean norm of a vector.
fn length(vector: &[f64; 3]) -> f64 {
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
}

impl NodeWall {
    /// Velocity towards the wall, relative to it (m/s); positive for approach.
    fn approach_velocity(&self, velocity: &[f64; 3]) -> f64 {
        let normal = velocity[self.axis] - self.velocity[self.axis];
        if self.is_upper { normal } else { -normal }
    }

    /// Whether the wall prescribes velocity components without condition, because it has neither separation nor friction.
    fn is_unconditional(&self) -> bool {
        !self.separation && matches!(self.kind, WallKind::Rough | WallKind::Smooth)
    }

    /// Factors of the velocity components: 0 where the wall prescribes the component unconditionally, else 1.
    fn free_components(&self) -> [f64; 3] {
        let held = if self.separation { 0..0 } else { self.unconditional_components() };
        std::array::from_fn(|c| if held.contains(&c) { 0.0 } else { 1.0 })
    }

    /// Whether each velocity component of a node is constrained by the wall; `end` is its velocity at the end of the step (m/s).
    fn constrained_components(&self, end: &[f64; 3]) -> [bool; 3] {
        if self.is_unconditional() {
            let held = self.unconditional_components();
            return std::array::from_fn(|c| held.contains(&c));
        }
        let stopped = end[self.axis] == self.velocity[self.axis];
        let stuck = *end == self.velocity && self.kind != WallKind::Smooth;
        std::array::from_fn(|c| stuck || (stopped && c == self.axis))
    }

    /// Sets the prescribed velocity components of a node to those of the wall.
    #[inline]
    fn impose_velocity(&self, start: &mut [f64; 3], end: &mut [f64; 3], keep_start: bool) {
        for component in self.unconditional_components() {
            end[component] = self.velocity[component];
            if !keep_start {
                start[component] = self.velocity[component];
            }
        }
    }

    /// Applies the normal condition of the wall to a node that approaches it or is at a bilateral wall. At a unilateral wall the node
    /// always has the acceleration that stops it. Returns the velocity change into the wall (m/s) for friction, less `lift` of the pore
    /// fluid; `None` if the node separates.
    #[inline]
    fn stop(
        &self,
        start: &mut [f64; 3],
        end: &mut [f64; 3],
        keep_start: bool,
        lift: &[f64; 3],
    ) -> Option<f64> {
        if self.separation && self.approach_velocity(end) <= 0.0 {
            return None;
        }
        let dry: [f64; 3] = std::array::from_fn(|c| end[c] + lift[c]);
        end[self.axis] = self.velocity[self.axis];
        let plane = matches!(self.kind, WallKind::StaticAndSliding { .. });
        // The increment a_n dt of the sheet is zero for a node that approaches the wall without acceleration into it; then there is no
        // friction (step 1).
        let push = self.approach_velocity(&dry) - if plane { self.approach_velocity(start) } else { 0.0 };
        // Step 4. The force variant does not account for the momentum of points into the wall.
        if (plane || !self.separation) && !keep_start {
            start[self.axis] = self.velocity[self.axis];
        }
        Some(push)
    }

    /// Applies wall friction to a node in contact, for the normal impulse `push` (m/s); none if it is tensile.
    #[inline]
    fn apply_friction(&self, start: &[f64; 3], end: &mut [f64; 3], push: f64) {
        match self.kind {
            WallKind::Smooth => return,
            WallKind::Rough => {
                *end = self.velocity;
                return;
            }
            WallKind::Frictional { .. } | WallKind::StaticAndSliding { .. } => {}
        }
        let slip = self.tangential_velocity(end);
        let speed = length(&slip);
        let bound = self.coefficient(start, speed) * push.max(0.0);
        let keep = if speed <= bound { 0.0 } else { 1.0 - bound / speed };
        for c in (0..3).filter(|c| *c != self.axis) {
            end[c] = self.velocity[c] + keep * slip[c];
        }
    }

    /// Tangential velocity relative to the wall (m/s).
    #[inline]
    fn tangential_velocity(&self, velocity: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|c| if c == self.axis { 0.0 } else { velocity[c] - self.velocity[c] })
    }

    /// Friction coefficient of a node with the present slip speed `speed` (m/s).
    #[inline]
    fn coefficient(&self, start: &[f64; 3], speed: f64) -> f64 {
        match self.kind {
            WallKind::Smooth => 0.0,
            WallKind::Rough => f64::INFINITY,
            WallKind::Frictional { coefficient } => coefficient,
            // Steps 2 and 3: the slip is a_t dt from rest and v_t + a_t dt in sliding; the friction limit acts along it. Rest means a speed
            // within round-off.
            WallKind::StaticAndSliding { static_coefficient: resting, .. }
                if length(&self.tangential_velocity(start)) <= 1e-14 * speed =>
            {
                resting
            }
            WallKind::StaticAndSliding { sliding_coefficient: sliding, .. } => sliding,
        }
    }

    /// Constrains the re-mapped velocity of a node (MUSL) to no penetration. If the momentum solve (`solved`) had contact there is no
    /// separation, since the wall force would do work, and if it had sticking there is no slip.
    #[inline]
    fn constrain_remapped(&self, solved: &[f64; 3], velocity: &mut [f64; 3]) {
        let held = self.constrained_components(solved);
        if !self.separation || held[self.axis] || self.approach_velocity(velocity) > 0.0 {
            velocity[self.axis] = self.velocity[self.axis];
            if held == [true; 3] {
                *velocity = self.velocity;
            }
        }
    }

    /// Components of the velocity that the wall prescribes without condition: all for a rough wall, else the normal one.
    fn unconditional_components(&self) -> std::ops::Range<usize> {
        if self.kind == WallKind::Rough { 0..3 } else { self.axis..self.axis + 1 }
    }
}

#[cfg(test)]
mod tests;
