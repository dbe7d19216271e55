//! Front of a flow by arc length along the line of an obstacle (sheet: snow-mpm §3.11).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error_collector::ErrorCollector;
use crate::measure::points::front::front_point;
use crate::measure::{MeasureDefinition, MeasuredState, ScalarOutput, default_fraction};
use crate::{Case, Obstacle, ObstacleShape, Snapshot};

/// Front of a flow along the line of an obstacle in the plane (m): the length along it behind which a fraction of the mass lies, each point
/// at its nearest position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArcFront {
    /// Obstacle, a `profile` or `ground-line`.
    pub obstacle: String,
    /// Mass fraction behind the front: 1 gives the foremost point; 0.99 excludes stray points.
    #[serde(default = "default_fraction")]
    pub quantile: f64,
    /// Length along the line to the front's zero (m).
    #[serde(default)]
    pub zero: f64,
    /// Bodies that count; all but rigid ones when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<Vec<String>>,
}

impl ArcFront {
    /// Foremost front along the line of an obstacle.
    #[must_use]
    pub fn new(obstacle: impl Into<String>) -> Self {
        Self { obstacle: obstacle.into(), quantile: default_fraction(), zero: 0.0, bodies: None }
    }
}

impl MeasureDefinition for ArcFront {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        errors.counted_bodies(path, self.bodies.as_deref());
        let is_line = |obstacle: &&Obstacle| {
            matches!(obstacle.shape, ObstacleShape::Profile { .. } | ObstacleShape::GroundLine { .. })
        };
        let lines = errors.case.obstacles.iter().filter(is_line);
        let lines: Vec<&str> = lines.map(|obstacle| obstacle.name.as_str()).collect();
        let what = "the name of an obstacle that is a profile or a ground-line";
        errors.name(&format!("{path}.obstacle"), &self.obstacle, &lines, what);
        errors.quantile(path, self.quantile);
        errors.finite(format!("{path}.zero"), self.zero);
    }

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        let counted = state.counted_points(self.bodies.as_deref());
        let front = arc_front(state.case, &counted, &self.obstacle, self.quantile);
        vec![(name.to_owned(), "m".to_owned(), front - self.zero)]
    }
}

/// Arc length along the ground line of an obstacle (m), behind which the fraction `quantile` of the mass lies. Each point counts at its
/// nearest place on the line. NaN without points, their `mass` or such an obstacle.
pub fn arc_front(case: &Case, snapshot: &Snapshot, of: &str, quantile: f64) -> f64 {
    let Some(line) = case.ground_line(of) else { return f64::NAN };
    let place = |x: &[f64; 3]| line.arc_length(&[x[0], x[1]]).unwrap_or(f64::NAN);
    let along: Vec<f64> = snapshot.positions.iter().map(place).collect();
    front_point(snapshot, &along, quantile).map_or(f64::NAN, |i| along[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Field, FieldData};

    #[test]
    fn the_front_is_counted_along_slope_arc_and_flat() {
        // A slope of 3 to 4, 5 m long, and a flat without a transition arc behind it.
        let text = r#"{
            "title": "track", "space": "plane-strain", "domain": { "min": [-5, -1], "max": [10, 5] }, "gravity": [0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [ { "name": "b", "material": "m", "shape": { "kind": "box", "min": [5, 1], "max": [6, 2] } } ],
            "obstacles": [ { "name": "track", "wall": { "kind": "rough" },
                "shape": { "kind": "profile", "start": [-4, 3], "pieces": [{ "to": [0, 0] }, { "to": [10, 0] }] } } ],
            "stages": [ { "name": "go", "duration": 1 } ],
            "measures": { "front": { "kind": "arc-front", "obstacle": "track", "zero": 5 },
                          "middle": { "kind": "arc-front", "obstacle": "track", "quantile": 0.5 } }
        }"#;
        let case = Case::from_json(text).unwrap();
        // Points at 1 m and at 3 m down the slope, each slightly above it, and at 2.5 m on the flat.
        let positions = vec![[-3.2 + 0.06, 2.4 + 0.08, 0.0], [-1.6, 1.2, 0.0], [2.5, 0.3, 0.0]];
        let snapshot = Snapshot {
            time: 0.0,
            step: 0,
            ids: vec![0, 1, 2],
            bodies: vec![0; 3],
            positions,
            extents: vec![[0.1; 3]; 3],
            fields: vec![Field { name: "mass".into(), unit: "kg", data: FieldData::Scalar(vec![1.0; 3]) }],
        };
        let readings = crate::measure::read(&MeasuredState::of_points(&case, &snapshot));
        let found: Vec<f64> = readings.iter().map(|reading| reading.2).collect();
        assert!((found[0] - 2.5).abs() < 1e-12 && (found[1] - 3.0).abs() < 1e-12, "{found:?}");
    }
}
