//! Velocity fields of the nodes.

use colluvium_grid::{Gathered, Lanes, Layout, Node, Points};

use crate::background::Background;
use crate::momentum::RowSums;

/// The nodes of all velocity fields, field after field; those of two phases are in [`crate::two_phase::TwoPhase`].
#[derive(Default)]
pub struct Nodes {
    /// Mass and momentum, then velocity at the end of the step; force, then acceleration.
    pub(crate) solved: Vec<Node>,
    /// Velocities mapped from the points once more; empty where nothing asks for them.
    pub(crate) remapped: Vec<Lanes>,
    /// Derivatives of the functions of the nodes times the masses of the points; empty where nothing asks for them.
    pub(crate) slopes: Vec<Lanes>,
    /// Room for what the rows add to the measures of equilibrium.
    pub(crate) row_sums: Vec<RowSums>,
    /// Measures of equilibrium of the last step that took them.
    pub(crate) sums: RowSums,
    /// Work of external forces since the stage began (J).
    pub(crate) external_work: f64,
}

/// What points read of the nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Velocities {
    /// Velocities at the end of the step, and accelerations.
    Solved,
    /// Re-mapped velocities, or those at the start of the step.
    Remapped,
}

impl Nodes {
    /// What points of a velocity field read of its nodes, gradients among it.
    pub fn gather<const D: usize>(
        &self,
        of: Velocities,
        background: &Background<D>,
        field: usize,
        points: &Points<'_, D>,
        reads: &mut [Gathered<D>],
    ) {
        let (ground, sweeps, first) =
            (background.ground(), background.sweeps, field * background.layout.len());
        match of {
            Velocities::Solved => sweeps.gather(&ground, points, &self.solved[first..], reads),
            Velocities::Remapped => sweeps.gather_velocity(&ground, points, &self.remapped[first..], reads),
        }
    }

    /// Velocity (m/s) of a node of a field, by its place among the nodes of all fields.
    #[inline]
    pub fn motion(&self, of: Velocities, number: usize) -> Lanes {
        match of {
            Velocities::Solved => self.solved[number].motion,
            Velocities::Remapped => self.remapped[number],
        }
    }

    /// Empties the active nodes of all velocity fields.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        self.solved.chunks_exact_mut(layout.len()).for_each(|nodes| layout.reset(nodes));
    }

    /// Number of velocity fields.
    pub fn fields<const D: usize>(&self, layout: &Layout<D>) -> usize {
        self.solved.len() / layout.len()
    }

    /// Empties the active nodes of what re-mapping and XPIC sum up.
    pub fn reset_remapped<const D: usize>(&mut self, layout: &Layout<D>) {
        self.remapped.chunks_exact_mut(layout.len()).for_each(|nodes| layout.reset(nodes));
    }
}
