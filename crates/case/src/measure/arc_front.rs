//! Front of a flow by arc length along the line of an obstacle (sheet: snow-mpm §3.11).

use crate::measure::front::front_point;
use crate::{Case, Snapshot};

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
        let readings = crate::measure::read(&case, &snapshot, None, &[]);
        let found: Vec<f64> = readings.iter().map(|reading| reading.2).collect();
        assert!((found[0] - 2.5).abs() < 1e-12 && (found[1] - 3.0).abs() < 1e-12, "{found:?}");
    }
}
