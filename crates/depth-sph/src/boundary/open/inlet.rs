//! Inflow through an end of a profile (sheet: depth-sph §3.9; §0 for dry beds).

use crate::boundary::open::boundary_state::BoundaryState;
use crate::inflow;
use crate::inflow::ArrivingFlow;

/// Inflow by a hydrograph through an end of a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Inlet {
    /// Hydrograph: times (s) and discharges per width (m²/s), linear between them and zero before and after.
    pub hydrograph: Vec<[f64; 2]>,
    /// Froude number `u/√(g h)` of the inflow, used if the end is dry or the inflow supercritical.
    pub froude: f64,
    /// Porosity of the inflow of grains and fluid; unused for a single phase.
    pub porosity: f64,
    /// Number of the layer that flows in (0 lower, 1 upper); `None` for flows that are not of two layers.
    pub layer: Option<usize>,
}

impl Inlet {
    /// Discharge per width at a time (m²/s).
    pub fn discharge(&self, time: f64) -> f64 {
        inflow::at_time(&self.hydrograph, time)
    }

    /// Depth (m) and speed (m/s) by the Froude number, at a discharge (m²/s) under `gravity` (m/s²).
    pub fn section_by_froude(&self, discharge: f64, gravity: f64) -> (f64, f64) {
        inflow::section_by_froude(discharge, self.froude, gravity)
    }

    /// Largest speed of the inflow (m/s) by the Froude number, under `gravity` (m/s²).
    pub(crate) fn max_speed(&self, gravity: f64) -> f64 {
        self.hydrograph.iter().map(|pair| self.section_by_froude(pair[1], gravity).1).fold(0.0, f64::max)
    }

    /// State at the end of the profile for the arriving flow, which is `None` if the end is dry. `gravity` is in m/s².
    pub(super) fn state(&self, time: f64, arriving: Option<ArrivingFlow>, gravity: f64) -> BoundaryState {
        let (depth, speed) = inflow::inflow_section(self.discharge(time), arriving, self.froude, gravity);
        BoundaryState { depth, speed: -speed, tangential_speed: 0.0, porosity: self.porosity }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inflow_state_depends_on_the_outgoing_characteristic_of_standing_water() {
        let feed =
            Inlet { hydrograph: vec![[0.0, 0.5], [10.0, 0.5]], froude: 2.0, porosity: 0.4, layer: None };
        let state = |time: f64, outgoing: Option<f64>| {
            let arriving = outgoing.map(|outgoing| ArrivingFlow { outgoing, effective_gravity: 9.81 });
            let BoundaryState { depth, speed, porosity, .. } = feed.state(time, arriving, 9.81);
            assert_eq!(porosity, 0.4);
            (depth, speed)
        };
        // The sheet's values: 0.5 m²/s into still water 1 m deep.
        let (h, u) = state(1.0, Some(2.0 * 9.81f64.sqrt()));
        assert!((h - 1.144_364).abs() < 1e-6 && (u + 0.436_924).abs() < 1e-6, "{h} {u}");
        let (h, u) = state(1.0, None);
        assert!((h * u + 0.5).abs() < 1e-12 && (u * u / (9.81 * h) - 4.0).abs() < 1e-9, "onto a dry bed");
        let (h, u) = state(11.0, Some(2.0 * 9.81f64.sqrt()));
        assert!((h - 1.0).abs() < 1e-9 && u.abs() < 1e-9, "nothing: as a wall");
    }
}
