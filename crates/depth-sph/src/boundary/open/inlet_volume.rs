//! Volume of the inflow through an end of a profile: that of its hydrograph.

use crate::boundary::open::boundary_state::BoundaryState;
use crate::boundary::open::inlet::Inlet;
use crate::boundary::open::open_boundary::OpenBoundary;
use crate::phases::phase::PhaseSet;

/// Least and largest volume of an inflow node over the volume of its length.
const NODE_VOLUME_RANGE: (f64, f64) = (0.5, 1.5);

/// Largest remainder of a hydrograph that the last node receives in addition to its volume, over the volume of a node. For a remainder
/// below one half no further node enters.
const LAST: f64 = 0.75;

/// Relative tolerance of the total inflow volume against the integral of the hydrograph.
const VOLUME_TOLERANCE: f64 = 1e-12;

impl Inlet {
    /// Inflow volume of a node set until a time (m²), where `share` is its share of the total.
    fn volume(&self, time: f64, share: f64) -> f64 {
        share * crate::inflow::volume(&self.hydrograph, time)
    }

    /// Depth at the largest discharge by the Froude number (m), under `gravity` (m/s²).
    fn deepest(&self, gravity: f64) -> f64 {
        self.hydrograph.iter().map(|pair| self.section_by_froude(pair[1], gravity).0).fold(0.0, f64::max)
    }
}

impl<const D: usize> OpenBoundary<D> {
    /// Share of a node set in the inflow volume.
    fn inlet_share(&self, inlet: &Inlet, sets: usize, number: usize) -> f64 {
        self.depth_share(
            &BoundaryState { porosity: inlet.porosity, ..BoundaryState::default() },
            sets,
            number,
        )
    }

    /// Sets the volumes of nodes that have just entered, so that their sum is the integral of the discharge. Half the volume of a node
    /// counts when its centre crosses the boundary. The last node of a hydrograph takes the remainder. `gravity` in m/s².
    pub(super) fn set_inlet_volumes(
        &mut self,
        sets: &mut [PhaseSet<D>],
        fresh: &[(usize, usize)],
        (time, gravity): (f64, f64),
    ) {
        let (count, spacing) = (sets.len(), self.spacing);
        for &(number, i) in fresh {
            let Some(inlet) = &self.inlet else { return };
            let share = self.inlet_share(inlet, count, number);
            let nodes = &mut sets[number].nodes;
            // The node has passed within the step that ends now.
            let speed = -self.outward * nodes.velocity[i][self.axis];
            let since = -self.distance_beyond(&nodes.position[i]) / speed;
            let passed = if speed > 0.0 && since < time { time - since } else { time };
            let own = &mut nodes.volume[i];
            let before = -self.state.outflow[number] - *own;
            let left = inlet.volume(f64::INFINITY, share) - before;
            if !(left > 0.0) {
                continue;
            }
            let wanted = inlet.volume(passed, share) + 0.5 * *own - before;
            let mut volume = wanted.clamp(NODE_VOLUME_RANGE.0 * *own, NODE_VOLUME_RANGE.1 * *own);
            let whole = f64::max(*own, share * inlet.deepest(gravity) * spacing);
            if left - volume < LAST * whole {
                volume = left;
            }
            self.state.outflow[number] -= volume - *own;
            *own = volume;
        }
    }

    /// Time at which the discharge is evaluated (s): at most the end of the hydrograph until its volume has entered, infinite afterwards.
    pub(super) fn discharge_time(&self, time: f64, sets: usize) -> f64 {
        if self.is_exhausted(sets) {
            return f64::INFINITY;
        }
        let end = self.inlet.as_ref().and_then(|inlet| inlet.hydrograph.last()).map_or(time, |last| last[0]);
        time.min(end)
    }

    /// Whether the whole volume of a hydrograph has entered.
    fn is_exhausted(&self, sets: usize) -> bool {
        let Some(inlet) = &self.inlet else { return false };
        (0..sets).filter(|number| self.is_of(*number)).all(|number| {
            let all = inlet.volume(f64::INFINITY, self.inlet_share(inlet, sets, number));
            -self.state.outflow[number] >= (1.0 - VOLUME_TOLERANCE) * all
        })
    }
}
