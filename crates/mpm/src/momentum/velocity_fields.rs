//! Velocity fields of the nodes.

use colluvium_grid::{InterpolatedMotion, Layout, NodalState, PointSlice, Vector4};

use crate::background_grid::BackgroundGrid;
use crate::momentum::EquilibriumTerms;

/// Nodes of all velocity fields, field by field. Those of two phases are in [`crate::phases::TwoPhase`].
#[derive(Default)]
pub struct VelocityFields {
    /// Mass, momentum and force of each node; after the solve velocity and acceleration.
    pub(crate) nodal_states: Vec<NodalState>,
    /// Re-mapped velocities of the nodes; empty if no option needs them.
    pub(crate) remapped_velocities: Vec<Vector4>,
    /// Mass gradients of the nodes, `Σ_p m_p ∇N`; empty if no option needs them.
    pub(crate) mass_gradients: Vec<Vector4>,
    /// Equilibrium sums of each row of nodes, as memory that a step reuses.
    pub(crate) row_sums: Vec<EquilibriumTerms>,
    /// Equilibrium sums of the last step that computed them.
    pub(crate) sums: EquilibriumTerms,
    /// Work of external forces since the start of the stage (J).
    pub(crate) external_work: f64,
}

/// Nodal velocities that points interpolate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocitySource {
    /// Velocities at the end of the step, and accelerations.
    EndOfStep,
    /// Re-mapped velocities, or those at the start of the step.
    Remapped,
}

impl VelocityFields {
    /// Interpolates velocities and gradients of the nodes of a velocity field to its points.
    pub fn g2p<const D: usize>(
        &self,
        of: VelocitySource,
        background: &BackgroundGrid<D>,
        field: usize,
        points: &PointSlice<'_, D>,
        reads: &mut [InterpolatedMotion<D>],
    ) {
        let (view, transfers, first) =
            (background.grid_view(), background.transfers, field * background.layout.len());
        match of {
            VelocitySource::EndOfStep => transfers.g2p(&view, points, &self.nodal_states[first..], reads),
            VelocitySource::Remapped => {
                transfers.g2p_velocity(&view, points, &self.remapped_velocities[first..], reads);
            }
        }
    }

    /// Velocity of a node (m/s), by its index among the nodes of all fields.
    #[inline]
    pub fn motion(&self, of: VelocitySource, number: usize) -> Vector4 {
        match of {
            VelocitySource::EndOfStep => self.nodal_states[number].momentum_and_mass,
            VelocitySource::Remapped => self.remapped_velocities[number],
        }
    }

    /// Sets the active nodes of all velocity fields to zero.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        self.nodal_states.chunks_exact_mut(layout.len()).for_each(|nodes| layout.reset(nodes));
    }

    /// Number of velocity fields.
    pub fn fields<const D: usize>(&self, layout: &Layout<D>) -> usize {
        self.nodal_states.len() / layout.len()
    }

    /// Sets the re-mapped velocities and XPIC sums of active nodes to zero.
    pub fn reset_remapped<const D: usize>(&mut self, layout: &Layout<D>) {
        self.remapped_velocities.chunks_exact_mut(layout.len()).for_each(|nodes| layout.reset(nodes));
    }
}
