//! Reading the nodes of the background grid.

use crate::solver::MpmSolver;

/// Node of the background grid after the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MpmNode<const D: usize> {
    /// Velocity field of the node: 0, or the number of a body or of a group of bodies that contact separates from others.
    pub field: usize,
    /// Position (m).
    pub position: [f64; D],
    /// Mass (kg; per metre in plane strain, per radian in axisymmetry).
    pub mass: f64,
    /// Velocity at the end of the step (m/s).
    pub velocity: [f64; D],
    /// Acceleration in the step (m/s²).
    pub acceleration: [f64; D],
}

impl<const D: usize> MpmSolver<D> {
    /// Nodes with mass after the last step, velocity field by velocity field, in a fixed order; none before the first step, and none in a
    /// case with a pore fluid. Their positions are those of the grid, and their masses those of the points at the start of the step.
    pub fn nodes(&self) -> impl Iterator<Item = MpmNode<D>> + '_ {
        let layout = &self.background.layout;
        let (row_length, fields) = (layout.strides()[0], self.nodes.fields(layout));
        let in_field = move |field: usize| {
            (0..layout.nodes()[0]).flat_map(move |row| {
                layout.active_nodes(row).filter_map(move |number| self.node(field, (row, number), row_length))
            })
        };
        (0..fields).flat_map(in_field)
    }

    /// Node of a velocity field, by its row and its number in the row; `None` without mass, and for an image in a periodic domain.
    fn node(&self, field: usize, (row, number): (usize, usize), row_length: usize) -> Option<MpmNode<D>> {
        let layout = &self.background.layout;
        let (index, in_layout) = (layout.axis_indices(row, number), row * row_length + number);
        let state = &self.nodes.nodal_states[field * layout.len() + in_layout];
        let (motion, acceleration) = (state.momentum_and_mass.to_array(), state.force.to_array());
        let is_read = motion[3] > 0.0 && !layout.is_periodic_image(&index);
        is_read.then(|| {
            let position = self.background.node_at(in_layout, &index);
            MpmNode {
                field,
                position: std::array::from_fn(|c| position[c]),
                mass: motion[3],
                velocity: std::array::from_fn(|c| motion[c]),
                acceleration: std::array::from_fn(|c| acceleration[c]),
            }
        })
    }
}
