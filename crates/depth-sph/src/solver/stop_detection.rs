//! Detection of the time at which a flow comes to rest (sheet: depth-sph §0, stopping).

use serde::{Deserialize, Serialize};

use crate::config::StopOptions;
use crate::output::flow_view::FlowView;
use crate::points::phase_nodes::norm;

/// Detection of the time at which the flow has stopped (sheet: depth-sph §0, stopping).
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct StopDetection {
    /// Largest kinetic energy since the start (J).
    pub(super) peak: f64,
    /// Time since which all conditions have held (s); NaN while they do not.
    rest_since: f64,
    /// Time at which the flow had stopped (s); NaN before.
    pub(super) stop_time: f64,
}

impl Default for StopDetection {
    fn default() -> Self {
        Self { peak: 0.0, rest_since: f64::NAN, stop_time: f64::NAN }
    }
}

impl StopDetection {
    /// Updates the detection with the flow at `time` (s) and its kinetic energy (J).
    pub(super) fn update(&mut self, stop: &StopOptions, motion: &FlowMotion, time: f64) {
        let FlowMotion { kinetic, slow_volume, total_volume } = *motion;
        self.peak = self.peak.max(kinetic);
        let holds = self.peak > 0.0
            && kinetic <= stop.kinetic_ratio * self.peak
            && slow_volume >= stop.share * total_volume;
        if !holds {
            (self.rest_since, self.stop_time) = (f64::NAN, f64::NAN);
        } else if self.rest_since.is_nan() {
            self.rest_since = time;
        }
        if holds && self.stop_time.is_nan() && time - self.rest_since >= stop.hold {
            self.stop_time = self.rest_since;
        }
    }
}

/// Kinetic energy of a flow with its total and its slow volume, for the detection of its stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FlowMotion {
    /// Kinetic energy of the motion in plan (J).
    pub(super) kinetic: f64,
    /// Volume of the first set that is slower than the speed of the criterion (m³).
    slow_volume: f64,
    /// Volume of the first set (m³).
    total_volume: f64,
}

impl FlowMotion {
    /// Motion of the nodes against a speed (m/s).
    pub(super) fn of_flow<const D: usize>(flow: &FlowView<'_, D>, slow_speed: f64) -> Self {
        let (mut kinetic, mut slow_volume, mut total_volume) = (0.0, 0.0, 0.0);
        for (number, set) in flow.sets().iter().enumerate() {
            let density = flow.density(number);
            for (velocity, volume) in set.nodes.velocity.iter().zip(&set.nodes.volume) {
                let speed = norm(velocity);
                kinetic += 0.5 * density * volume * speed * speed;
                if number == 0 {
                    total_volume += volume;
                    slow_volume += if speed < slow_speed { *volume } else { 0.0 };
                }
            }
        }
        Self { kinetic, slow_volume, total_volume }
    }
}
