//! Velocity fields of the nodes.

use colluvium_grid::{InterpolatedMotion, Layout, NodalState, PointSlice, Vector4};

use crate::momentum::EquilibriumTerms;
use crate::transfer::background_grid::BackgroundGrid;

/// The nodes of all velocity fields, field after field; those of two phases are in [`crate::phases::TwoPhase`].
#[derive(Default)]
pub struct VelocityFields {
    /// Mass and momentum, then velocity at the end of the step; force, then acceleration.
    pub(crate) solved: Vec<NodalState>,
    /// Velocities mapped from the points once more; empty where nothing asks for them.
    pub(crate) remapped: Vec<Vector4>,
    /// Derivatives of the functions of the nodes times the masses of the points; empty where nothing asks for them.
    pub(crate) mass_gradients: Vec<Vector4>,
    /// Room for what the rows add to the measures of equilibrium.
    pub(crate) row_sums: Vec<EquilibriumTerms>,
    /// Measures of equilibrium of the last step that took them.
    pub(crate) sums: EquilibriumTerms,
    /// Work of external forces since the stage began (J).
    pub(crate) external_work: f64,
}

/// What points read of the nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocitySource {
    /// Velocities at the end of the step, and accelerations.
    Solved,
    /// Re-mapped velocities, or those at the start of the step.
    Remapped,
}

impl VelocityFields {
    /// What points of a velocity field read of its nodes, gradients among it.
    pub fn g2p<const D: usize>(
        &self,
        of: VelocitySource,
        background: &BackgroundGrid<D>,
        field: usize,
        points: &PointSlice<'_, D>,
        reads: &mut [InterpolatedMotion<D>],
    ) {
        let (ground, sweeps, first) =
            (background.grid_view(), background.transfers, field * background.layout.len());
        match of {
            VelocitySource::Solved => sweeps.g2p(&ground, points, &self.solved[first..], reads),
            VelocitySource::Remapped => sweeps.g2p_velocity(&ground, points, &self.remapped[first..], reads),
        }
    }

    /// Velocity (m/s) of a node of a field, by its place among the nodes of all fields.
    #[inline]
    pub fn motion(&self, of: VelocitySource, number: usize) -> Vector4 {
        match of {
            VelocitySource::Solved => self.solved[number].momentum_and_mass,
            VelocitySource::Remapped => self.remapped[number],
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
