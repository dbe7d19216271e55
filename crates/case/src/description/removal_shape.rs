//! Removal shapes: shapes that move through bodies and remove material.

use colluvium_points::Shape;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Moving shape that removes covered points, as a saw or trench. Measures have `NAME.travel` (m), and the removed mass and kinetic and
/// recoverable energy, `NAME.mass` (kg) and `NAME.energy` (J).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RemovalShape {
    /// Name of letters, digits, _ and -, not a measure's.
    pub name: String,
    /// Region at `start`.
    pub shape: Shape,
    /// Velocity (m/s), one number per dimension.
    pub velocity: Vec<f64>,
    /// Stage to which `start` and `stop` refer and that ends the shape; the run when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stage: Option<String>,
    /// Start of motion and cut (s), non-negative.
    #[serde(default)]
    pub start: f64,
    /// Removal (s), after `start`; end of the stage or run when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop: Option<f64>,
    /// Cut bodies; all when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<Vec<String>>,
    /// Action on covered points.
    #[serde(default)]
    pub action: RemovalAction,
}

/// Action of a removal shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RemovalAction {
    /// Removal with mass, momentum and energy.
    #[default]
    Remove,
}

impl RemovalShape {
    /// Shape that moves at a velocity (m/s) from the beginning of the run to its end, and cuts all bodies.
    #[must_use]
    pub fn new(name: impl Into<String>, shape: Shape, velocity: impl Into<Vec<f64>>) -> Self {
        Self {
            name: name.into(),
            shape,
            velocity: velocity.into(),
            stage: None,
            start: 0.0,
            stop: None,
            bodies: None,
            action: RemovalAction::default(),
        }
    }

    /// Time of motion (s) at `elapsed` seconds after the start of its time scale.
    pub fn moving_time(&self, elapsed: f64) -> f64 {
        elapsed.min(self.stop.unwrap_or(f64::INFINITY)).max(self.start) - self.start
    }

    /// Whether it is active at some time between two times (s), on the time scale of `start`.
    pub fn is_active_between(&self, from: f64, to: f64) -> bool {
        to > self.start && self.stop.is_none_or(|stop| from < stop)
    }

    /// Speed of the shape (m/s).
    pub fn speed(&self) -> f64 {
        self.velocity.iter().map(|v| v * v).sum::<f64>().sqrt()
    }

    /// Whether it removes material of the body of this name.
    pub fn applies_to(&self, body: &str) -> bool {
        self.bodies.as_ref().is_none_or(|names| names.iter().any(|name| name == body))
    }

    /// Bounds of its initial shape along each axis of a space of `dimension` coordinates (m).
    pub fn bounds(&self, dimension: usize) -> AxisBounds {
        let (low, high) = self.shape.bounds(dimension);
        let mut bounds = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
        bounds.iter_mut().zip(low.iter().zip(high)).for_each(|(of, (low, high))| *of = [*low, high]);
        bounds
    }

    /// Region swept between two times (s), on the time scale of `start`; `bounds` are those of its shape.
    pub fn swept_region(&self, from: f64, to: f64, bounds: &AxisBounds) -> SweptRegion<'_> {
        let (begun, ended) = (self.moving_time(from), self.moving_time(to));
        let distance = self.speed() * (ended - begun);
        // A shape that moves by more than a fraction of its thickness is also sampled on the way.
        let looks = (distance / (SAMPLE_FRACTION * min_extent(bounds))).ceil().clamp(1.0, MAX_SAMPLES);
        let mut bounds = *bounds;
        for ([low, high], v) in bounds.iter_mut().zip(&self.velocity) {
            let (a, b) = (v * begun, v * ended);
            (*low, *high) = (*low + a.min(b), *high + a.max(b));
        }
        SweptRegion { shape: self, start_time: begun, end_time: ended, samples: looks as usize, bounds }
    }
}

/// Lower and upper bound along each axis (m); infinite for axes that the space does not have.
pub type AxisBounds = [[f64; 2]; 3];

/// Smallest extent along the axes (m).
pub fn min_extent(bounds: &AxisBounds) -> f64 {
    bounds.iter().map(|[low, high]| high - low).fold(f64::INFINITY, f64::min)
}

/// Displacement between two samples of a sweep over the thickness of the shape.
const SAMPLE_FRACTION: f64 = 0.25;
/// Largest number of samples per step.
const MAX_SAMPLES: f64 = 64.0;

/// Region that a removal shape sweeps in a step.
#[derive(Clone, Copy, Debug)]
pub struct SweptRegion<'a> {
    shape: &'a RemovalShape,
    start_time: f64,
    end_time: f64,
    samples: usize,
    bounds: AxisBounds,
}

impl SweptRegion<'_> {
    /// Bounds of the swept region along each axis (m).
    pub fn bounds(&self) -> &AxisBounds {
        &self.bounds
    }

    /// Whether the shape covers a position (m) at some sample of the sweep.
    pub fn contains<const D: usize>(&self, place: &[f64; D]) -> bool {
        let within = |axis: usize| place[axis] >= self.bounds[axis][0] && place[axis] <= self.bounds[axis][1];
        (0..D).all(within) && (0..=self.samples).any(|look| self.covers_at(look, place))
    }

    /// Whether the moving shape contains a position at the sample time number `look`.
    fn covers_at<const D: usize>(&self, look: usize, place: &[f64; D]) -> bool {
        let moved = self.start_time + (self.end_time - self.start_time) * look as f64 / self.samples as f64;
        let back: [f64; D] = std::array::from_fn(|axis| place[axis] - self.shape.velocity[axis] * moved);
        self.shape.shape.contains(&back)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn saw_cut() -> RemovalShape {
        serde_json::from_str(
            r#"{ "name": "saw", "shape": { "kind": "box", "min": [1, 0], "max": [1.1, 0.2] }, "velocity": [-2, 0],
            "start": 0.5, "stop": 1 }"#,
        )
        .unwrap()
    }

    #[test]
    fn a_removal_shape_moves_between_its_start_and_stop_times() {
        let saw = saw_cut();
        assert_eq!([0.0, 0.5, 0.75, 1.0, 3.0].map(|t| saw.moving_time(t)), [0.0, 0.0, 0.25, 0.5, 0.5]);
        assert!(!saw.is_active_between(0.4, 0.5) && saw.is_active_between(0.4, 0.6));
        assert!(saw.is_active_between(0.9, 1.1) && !saw.is_active_between(1.0, 1.1));
    }

    #[test]
    fn the_swept_region_covers_the_whole_path_of_a_step() {
        let saw = saw_cut();
        // From 1 m to 0 m in one step, ten times its width.
        let sweep = saw.swept_region(0.5, 1.0, &saw.bounds(2));
        for i in 0..=100 {
            assert!(sweep.contains(&[0.001 + 0.01 * f64::from(i), 0.1]), "{i}");
        }
        for outside in [[1.11, 0.1], [-0.01, 0.1], [0.5, 0.21], [0.5, -0.01]] {
            assert!(!sweep.contains(&outside), "{outside:?}");
        }
    }
}
