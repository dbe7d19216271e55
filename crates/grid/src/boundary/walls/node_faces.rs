//! Contact of nodes with rigid geometry of any shape.

use crate::boundary::walls::WallKind;
use crate::{Basis1d, Grid, Layout};

/// Contact condition of a surface of any shape at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeFace {
    /// Unit normal out of the solid.
    pub normal: [f64; 3],
    /// Contact condition; friction in impulse form.
    pub kind: WallKind,
    /// Whether material may separate.
    pub separation: bool,
    /// Velocity of the surface (m/s).
    pub velocity: [f64; 3],
    /// Index of the reaction to which the face contributes; `None` if it is not measured.
    pub reaction_index: Option<u8>,
}

/// Faces of the nodes in contact with rigid geometry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeFaces {
    /// Node strides.
    strides: [usize; 3],
    /// Index of each node in the list of nodes with faces plus one, zero for none; empty without any.
    lookup: Vec<u32>,
    /// Whether any node of a row has faces, by index along the first axis.
    rows: Vec<bool>,
    /// First face of each node with faces, and the number of faces.
    first_faces: Vec<u32>,
    /// Nodes with faces.
    nodes: Vec<u32>,
    faces: Vec<NodeFace>,
}

/// Scalar product.
pub(super) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Euclidean norm.
pub(super) fn length(a: &[f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Relative tolerance of the normal velocity for round-off.
const ROUND_OFF: f64 = 1e-12;

impl NodeFaces {
    /// Faces of `count` nodes in a layout with `strides`, each given with its node in ascending order.
    pub fn new<const D: usize>(strides: [usize; D], count: usize, of_nodes: &[(u32, NodeFace)]) -> Self {
        if of_nodes.is_empty() {
            return Self::default();
        }
        let mut faces = Self {
            strides: std::array::from_fn(|axis| strides.get(axis).copied().unwrap_or(0)),
            lookup: vec![0; count],
            rows: vec![false; count / strides[0].max(1)],
            ..Self::default()
        };
        for (node, face) in of_nodes {
            faces.faces.push(*face);
            faces.assign(*node, faces.faces.len() - 1);
        }
        faces.first_faces.push(of_nodes.len() as u32);
        faces
    }

    /// Assigns the faces from index `first` on to a node, whose number is at least that of the last one assigned.
    fn assign(&mut self, node: u32, first: usize) {
        if self.lookup[node as usize] == 0 && first < self.faces.len() {
            self.first_faces.push(first as u32);
            self.nodes.push(node);
            self.lookup[node as usize] = self.first_faces.len() as u32;
            self.rows[node as usize / self.strides[0].max(1)] = true;
        }
    }

    /// Rebuilds the faces of the active nodes of a structured grid: the permanent ones in `rest`, and those that `find` adds for a node
    /// position (m). Memory is reused.
    pub fn rebuild<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        layout: &Layout<D>,
        axis: &Basis1d,
        rest: &Self,
        mut find: impl FnMut(&[f64; D], &mut Vec<NodeFace>),
    ) {
        let strides = layout.strides();
        self.strides = std::array::from_fn(|axis| strides.get(axis).copied().unwrap_or(0));
        self.lookup.resize(layout.len(), 0);
        self.rows.resize(layout.nodes()[0], false);
        self.nodes.drain(..).for_each(|node| self.lookup[node as usize] = 0);
        self.rows.fill(false);
        self.first_faces.clear();
        self.faces.clear();
        for row in 0..layout.nodes()[0] {
            for number in layout.active_nodes(row) {
                let index = layout.axis_indices(row, number);
                let place = std::array::from_fn(|a| {
                    grid.origin[a] + grid.cell * axis.coordinate(index[a], grid.cells[a])
                });
                let node = (row * strides[0] + number) as u32;
                let first = self.faces.len();
                self.faces.extend_from_slice(rest.faces_at(&index));
                find(&place, &mut self.faces);
                self.assign(node, first);
            }
        }
        self.first_faces.push(self.faces.len() as u32);
    }

    /// Returns the faces of the nodes of a structured grid: `find` adds the faces at the position of a node (m) to its list.
    pub fn from_positions<const D: usize>(
        grid: &Grid<D>,
        layout: &Layout<D>,
        axis: &Basis1d,
        mut find: impl FnMut(&[f64; D], &mut Vec<NodeFace>),
    ) -> Self {
        let strides = layout.strides();
        let (mut of_nodes, mut found) = (Vec::new(), Vec::new());
        for row in 0..layout.nodes()[0] {
            for number in 0..strides[0] {
                let index = layout.axis_indices(row, number);
                let place = std::array::from_fn(|a| {
                    grid.origin[a] + grid.cell * axis.coordinate(index[a], grid.cells[a])
                });
                find(&place, &mut found);
                let node = (row * strides[0] + number) as u32;
                of_nodes.extend(found.drain(..).map(|face| (node, face)));
            }
        }
        Self::new(strides, layout.len(), &of_nodes)
    }

    /// Whether no node has faces.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Whether a node with a given index along the first axis has faces.
    #[inline]
    pub(super) fn has_faces_in_row(&self, row: usize) -> bool {
        !self.faces.is_empty() && self.rows[row]
    }

    /// Faces of a node.
    #[inline]
    pub fn faces_at(&self, index: &[usize; 3]) -> &[NodeFace] {
        if self.faces.is_empty() {
            return &[];
        }
        match self.lookup[(0..3).map(|a| index[a] * self.strides[a]).sum::<usize>()] {
            0 => &[],
            number => {
                let number = number as usize;
                &self.faces[self.first_faces[number - 1] as usize..self.first_faces[number] as usize]
            }
        }
    }
}

impl NodeFace {
    /// Face without velocity, with an outward unit normal: smooth for zero `friction`, rough for infinite friction, else frictional.
    pub fn at_rest(normal: [f64; 3], friction: f64, separation: bool) -> Self {
        let kind = match friction {
            0.0 => WallKind::Smooth,
            coefficient if coefficient.is_finite() => WallKind::Frictional { coefficient },
            _ => WallKind::Rough,
        };
        Self { normal, kind, separation, velocity: [0.0; 3], reaction_index: None }
    }

    /// Whether the face prescribes all velocity components without condition.
    pub(super) fn is_fully_bonded(&self) -> bool {
        self.kind == WallKind::Rough && !self.separation
    }

    /// Removes the normal component of a velocity.
    fn stop(&self, velocity: &mut [f64; 3]) {
        let out = dot(velocity, &self.normal);
        (0..3).for_each(|c| velocity[c] -= out * self.normal[c]);
    }

    /// Velocity along the normal, relative to the surface (m/s).
    pub(super) fn separation_velocity(&self, velocity: &[f64; 3]) -> f64 {
        dot(velocity, &self.normal) - dot(&self.velocity, &self.normal)
    }

    /// Friction coefficient of the face while sliding; infinite for a rough one.
    pub(super) fn coefficient(&self) -> f64 {
        match self.kind {
            WallKind::Smooth => 0.0,
            WallKind::Rough => f64::INFINITY,
            WallKind::Frictional { coefficient }
            | WallKind::StaticAndSliding { sliding_coefficient: coefficient, .. } => coefficient,
        }
    }

    /// Applies the face to a node like a wall, see
    /// [`NodeWalls::constrain_skeleton`](crate::boundary::walls::NodeWalls::constrain_skeleton).
    pub(super) fn constrain(
        &self,
        start: &mut [f64; 3],
        end: &mut [f64; 3],
        keep_start: bool,
        lift: &[f64; 3],
    ) {
        if self.velocity == [0.0; 3] {
            return self.constrain_relative(start, end, keep_start, lift);
        }
        let shift = |v: &mut [f64; 3], sign: f64| (0..3).for_each(|c| v[c] += sign * self.velocity[c]);
        shift(start, -1.0);
        shift(end, -1.0);
        self.constrain_relative(start, end, keep_start, lift);
        shift(start, 1.0);
        shift(end, 1.0);
    }

    /// Applies the face with velocities relative to the surface.
    fn constrain_relative(
        &self,
        start: &mut [f64; 3],
        end: &mut [f64; 3],
        keep_start: bool,
        lift: &[f64; 3],
    ) {
        if self.is_fully_bonded() {
            *end = [0.0; 3];
            if !keep_start {
                *start = [0.0; 3];
            }
            return;
        }
        if self.separation && dot(end, &self.normal) >= 0.0 {
            return;
        }
        let push = -dot(&std::array::from_fn(|c| end[c] + lift[c]), &self.normal);
        self.stop(end);
        if !self.separation && !keep_start {
            self.stop(start);
        }
        if self.kind == WallKind::Smooth {
            return;
        }
        let (speed, bound) = (length(end), self.coefficient() * push.max(0.0));
        let keep = if self.kind == WallKind::Rough || speed <= bound { 0.0 } else { 1.0 - bound / speed };
        end.iter_mut().for_each(|c| *c *= keep);
    }

    /// Removes the velocity into the solid, without friction, by changes of the components that walls do not prescribe.
    pub(super) fn remove_penetration(&self, velocity: &mut [f64; 3], held: [bool; 3]) {
        let out = self.separation_velocity(velocity);
        if out >= 0.0 {
            return;
        }
        let free: [f64; 3] = std::array::from_fn(|c| if held[c] { 0.0 } else { self.normal[c] });
        let share = dot(&free, &free);
        if share > ROUND_OFF {
            (0..3).for_each(|c| velocity[c] -= out / share * free[c]);
        }
    }

    /// Whether a node is in contact with the face; `end` is its velocity at the end of the step (m/s).
    pub(super) fn is_in_contact(&self, end: &[f64; 3]) -> bool {
        self.is_fully_bonded() || self.separation_velocity(end).abs() <= ROUND_OFF * length(end)
    }

    /// Constrains the re-mapped velocity (MUSL) of a node that had the velocity `solved` after the face.
    pub(super) fn constrain_remapped(&self, solved: &[f64; 3], velocity: &mut [f64; 3]) {
        if self.is_in_contact(solved) || !self.separation || self.separation_velocity(velocity) < 0.0 {
            let out = self.separation_velocity(velocity);
            (0..3).for_each(|c| velocity[c] -= out * self.normal[c]);
        }
        if self.is_fully_bonded() || (*solved == self.velocity && self.kind != WallKind::Smooth) {
            *velocity = self.velocity;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::walls::{NodeWall, NodeWalls};
    use std::sync::Arc;

    const INCLINED_NORMAL: [f64; 3] = [0.6, 0.8, 0.0];

    fn walls(faces: &[(u32, NodeFace)], walls: Vec<NodeWall>) -> NodeWalls {
        NodeWalls::new(&[2, 2, 2], walls).with_faces(Arc::new(NodeFaces::new([4, 2, 1], 8, faces)))
    }

    fn constrained_velocity(walls: &NodeWalls, index: [usize; 3], free: [f64; 3]) -> [f64; 3] {
        let (mut start, mut end) = ([0.0; 3], free);
        walls.constrain(&index, &mut start, &mut end, true);
        end
    }

    fn is_near(a: [f64; 3], b: [f64; 3]) -> bool {
        (0..3).all(|c| (a[c] - b[c]).abs() < 1e-14)
    }

    #[test]
    fn a_tilted_face_applies_coulomb_friction_and_permits_separation() {
        let face = |kind, separation| NodeFace {
            normal: INCLINED_NORMAL,
            kind,
            separation,
            velocity: [0.0; 3],
            reaction_index: None,
        };
        let act =
            |kind, free| constrained_velocity(&walls(&[(5, face(kind, true))], Vec::new()), [1, 0, 1], free);
        // Approach velocity 1, slip 2 in the plane and 1 across it.
        let free = [-0.6 + 2.0 * 0.8, -0.8 - 2.0 * 0.6, 1.0];
        let along = [1.6, -1.2, 1.0];
        assert!(is_near(act(WallKind::Smooth, free), along));
        let keep = 1.0 - 0.3 / 5f64.sqrt();
        assert!(is_near(act(WallKind::Frictional { coefficient: 0.3 }, free), along.map(|c| keep * c)));
        assert_eq!(act(WallKind::Frictional { coefficient: 3.0 }, free), [0.0; 3]);
        assert_eq!(act(WallKind::Rough, free), [0.0; 3]);
        assert_eq!(act(WallKind::Rough, [0.6, 0.8, 0.1]), [0.6, 0.8, 0.1], "it leaves");
        let held = walls(&[(5, face(WallKind::Rough, false))], Vec::new());
        assert_eq!(constrained_velocity(&held, [1, 0, 1], [0.6, 0.8, 0.1]), [0.0; 3]);
        assert_eq!(constrained_velocity(&held, [1, 1, 1], free), free, "another node");
        assert!(!held.is_row_free(0, 1) && held.is_row_free(0, 0) && held.is_row_free(1, 0));
    }

    #[test]
    fn velocity_beside_a_wall_enters_neither_the_face_nor_the_wall() {
        let face = NodeFace::at_rest(INCLINED_NORMAL, 0.0, true);
        let floor = NodeWall {
            axis: 1,
            is_upper: false,
            node: 0,
            kind: WallKind::Smooth,
            separation: false,
            velocity: [0.0; 3],
        };
        let end = constrained_velocity(&walls(&[(4, face)], vec![floor]), [1, 0, 0], [-1.0, -1.0, 0.0]);
        assert!(end[1] == 0.0 && 0.6 * end[0] > -1e-14, "{end:?}");
    }

    #[test]
    fn a_moving_face_imposes_its_velocity_and_records_the_momentum_change() {
        let velocity = [1.2, 1.6, 0.5];
        let moving = |friction| NodeFace {
            velocity,
            reaction_index: Some(3),
            ..NodeFace::at_rest(INCLINED_NORMAL, friction, true)
        };
        let act = |friction, free: [f64; 3]| {
            let walls = walls(&[(5, moving(friction))], Vec::new());
            let (mut start, mut end, mut changes) = ([0.0; 3], free, Vec::new());
            walls.constrain_and_record(
                &[1, 0, 1],
                &mut start,
                &mut end,
                true,
                &[0.0; 3],
                |face, change, _| {
                    changes.push((face.reaction_index, change));
                },
            );
            (end, changes)
        };
        // The face moves along its normal by 2, and tangentially.
        let (end, changes) = act(0.0, [0.0; 3]);
        assert!(is_near(end, INCLINED_NORMAL.map(|n| 2.0 * n)), "{end:?}");
        assert!(changes[0].0 == Some(3) && is_near(changes[0].1, end), "{changes:?}");
        let (end, _) = act(f64::INFINITY, [0.0; 3]);
        assert!(is_near(end, velocity), "{end:?}");
        let faster = INCLINED_NORMAL.map(|n| 2.5 * n);
        let (end, changes) = act(0.3, faster);
        assert!(
            is_near(end, faster) && changes.iter().all(|(_, change)| is_near(*change, [0.0; 3])),
            "it leaves"
        );
        // With a normal impulse it slips by 0.5, less than the friction limit.
        let (end, _) = act(0.3, [0.0; 3]);
        assert!(is_near(end, velocity), "{end:?}");
    }
}
