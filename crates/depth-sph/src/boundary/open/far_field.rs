//! Nodes and strips beyond an open side.

use serde::{Deserialize, Serialize};

use crate::boundary::open::boundary_state::{ArrivalHistory, BoundaryState, InteriorFit};
use crate::boundary::open::open_boundary::OpenBoundary;
use crate::boundary::open::two_layers::LayerPair;

/// State of the flow outside an open boundary.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FarField {
    /// Numbers of the nodes, ascending.
    pub ids: Vec<u64>,
    /// Net outflow volume of each node set (m³; m² in profiles).
    pub outflow: [f64; 2],
    /// State of each boundary segment.
    pub strips: Vec<StripState>,
}

/// State of the flow at a boundary segment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StripState {
    /// Depth and velocity outside the boundary if they are the same at all distances.
    pub prescribed: Option<BoundaryState>,
    /// Flow that arrives from within.
    pub interior_fit: Option<InteriorFit>,
    /// Earlier flow that travels to the end of a profile as waves.
    pub history: ArrivalHistory,
    /// States of both layers of a two-layer flow at each boundary segment.
    pub layers: Option<LayerPair>,
}

impl<const D: usize> OpenBoundary<D> {
    /// Whether there was material outside the boundary at the start.
    pub fn is_filled(&self) -> bool {
        self.strips.iter().any(|strip| strip.far_state.is_some())
    }

    /// Whether a boundary segment was dry outside at the start and has no inflow.
    pub(super) fn is_dry_outside(&self, strip: usize) -> bool {
        self.strips[strip].far_state.is_none() && self.inlet.is_none() && self.flow_layer.is_none()
    }

    /// Sets the tangential speed of initially dry segments to their mean. Converging flow would otherwise pile up outside the boundary.
    pub(super) fn average_tangential_speed(&mut self) {
        if D == 1 {
            return;
        }
        let is_dry: Vec<bool> = (0..self.strips.len()).map(|strip| self.is_dry_outside(strip)).collect();
        let own = |strips: &[StripState]| -> [f64; 2] {
            let found = strips.iter().zip(&is_dry).filter(|(_, dry)| **dry);
            found.filter_map(|(known, _)| known.interior_fit).fold([0.0; 2], |[depth, flux], within| {
                [depth + within.depth[0], flux + within.depth[0] * within.tangential_speed]
            })
        };
        let [depth, flux] = own(&self.state.strips);
        let mean = if depth > 0.0 { flux / depth } else { 0.0 };
        let strips = self.state.strips.iter_mut().zip(&is_dry).filter(|(_, dry)| **dry);
        for within in strips.filter_map(|(known, _)| known.interior_fit.as_mut()) {
            within.tangential_speed = mean;
        }
    }
}
