//! Layers along the ground line of an obstacle in the plane, between two arc lengths.

use crate::description::{ObstacleShape, ProfilePiece};

/// Largest turning angle of an arc between two corners of the outline (rad).
const MAX_TURN: f64 = 0.004;

/// Segment of a ground line.
enum GroundSegment {
    /// Straight segment: start (m), direction and length (m).
    Straight { from: [f64; 2], along: [f64; 2], length: f64 },
    /// Circular arc: centre (m), radius (m), angle at its start and turning angle (rad).
    Arc { centre: [f64; 2], radius: f64, from: f64, sweep: f64 },
}

impl GroundSegment {
    /// Segment from `from` along a piece of a profile: a straight line, or an arc where the piece has a centre.
    fn new(from: [f64; 2], piece: &ProfilePiece) -> Self {
        let to = piece.to;
        match piece.centre {
            None => {
                let length = (to[0] - from[0]).hypot(to[1] - from[1]);
                Self::Straight {
                    from,
                    along: [(to[0] - from[0]) / length, (to[1] - from[1]) / length],
                    length,
                }
            }
            Some(centre) => {
                let angle = |x: [f64; 2]| (x[1] - centre[1]).atan2(x[0] - centre[0]);
                let full = 2.0 * std::f64::consts::PI;
                // The shorter arc.
                let sweep = (angle(to) - angle(from) + 0.5 * full).rem_euclid(full) - 0.5 * full;
                let radius = (from[0] - centre[0]).hypot(from[1] - centre[1]);
                Self::Arc { centre, radius, from: angle(from), sweep }
            }
        }
    }

    /// Arc length of the segment (m).
    fn length(&self) -> f64 {
        match self {
            Self::Straight { length, .. } => *length,
            Self::Arc { radius, sweep, .. } => radius * sweep.abs(),
        }
    }

    /// Position (m) at an arc length from the start (m), and the normal to the left of the direction along the line.
    fn point_and_normal(&self, length: f64) -> ([f64; 2], [f64; 2]) {
        match self {
            Self::Straight { from, along, .. } => {
                ([from[0] + length * along[0], from[1] + length * along[1]], [-along[1], along[0]])
            }
            Self::Arc { centre, radius, from, sweep } => {
                let (sine, cosine) = (from + sweep.signum() * length / radius).sin_cos();
                // The centre lies to the left where the arc turns counter-clockwise.
                let out = -sweep.signum();
                ([centre[0] + radius * cosine, centre[1] + radius * sine], [out * cosine, out * sine])
            }
        }
    }

    /// Arc lengths of the outline's corners, between two arc lengths (m).
    fn stations(&self, from: f64, to: f64) -> Vec<f64> {
        let count = match self {
            Self::Straight { .. } => 1,
            Self::Arc { radius, .. } => (((to - from) / radius / MAX_TURN).ceil() as usize).max(1),
        };
        (0..=count).map(|k| from + (to - from) * k as f64 / count as f64).collect()
    }
}

/// Segments of the ground line of an obstacle, and the horizontal distance from its start to its end (m), negative where the line runs from
/// right to left.
///
/// # Errors
/// Key of the layer and a description of the error, for other shapes.
fn ground_segments(shape: &ObstacleShape) -> Result<(Vec<GroundSegment>, f64), (&'static str, String)> {
    let corners: Vec<ProfilePiece>;
    let (first, pieces) = match shape {
        ObstacleShape::Profile { start, pieces } => (*start, pieces.as_slice()),
        ObstacleShape::GroundLine { points, file: None } if points.len() > 1 => {
            corners = points[1..].iter().map(|to| ProfilePiece { to: *to, centre: None }).collect();
            (points[0], corners.as_slice())
        }
        _ => {
            return Err((
                "on",
                "is neither a profile nor a ground-line with its points in the case".to_owned(),
            ));
        }
    };
    let mut made = Vec::with_capacity(pieces.len());
    let mut here = first;
    for piece in pieces {
        made.push(GroundSegment::new(here, piece));
        here = piece.to;
    }
    Ok((made, here[0] - first[0]))
}

/// Outline of the layer along the line of an obstacle, between the arc lengths `start` and `end` (m) and the distances `from` and `to`
/// along the normal out of the ground (m).
///
/// # Errors
/// Key of the layer and a description of the error.
pub fn outline(
    shape: &ObstacleShape,
    [start, end]: [f64; 2],
    [from, to]: [f64; 2],
) -> Result<Vec<[f64; 2]>, (&'static str, String)> {
    let (pieces, extent) = ground_segments(shape)?;
    let length: f64 = pieces.iter().map(GroundSegment::length).sum();
    if end > length * (1.0 + 1e-9) {
        return Err((
            "end",
            format!("{end} m is beyond the end of the line of the obstacle, which is {length} m long"),
        ));
    }
    // The ground lies below: a ground line may run from right to left.
    let up = if extent >= 0.0 { 1.0 } else { -1.0 };
    let (mut sides, mut begun): ([Vec<[f64; 2]>; 2], f64) = (Default::default(), 0.0);
    let mut before: Option<[f64; 2]> = None;
    for piece in &pieces {
        let (low, high) = ((start - begun).max(0.0), (end - begun).min(piece.length()));
        begun += piece.length();
        if high <= low {
            continue;
        }
        for (number, station) in piece.stations(low, high).into_iter().enumerate() {
            let (place, normal) = piece.point_and_normal(station);
            let mut normal = normal.map(|n| up * n);
            if let Some(last) = before.filter(|_| number == 0) {
                // Where segments meet at an angle the corner lies at the distance from both.
                let share = 1.0 + normal[0] * last[0] + normal[1] * last[1];
                if !(share > 0.1) {
                    return Err(("on", "the line turns back on itself within the layer".to_owned()));
                }
                normal = std::array::from_fn(|c| (normal[c] + last[c]) / share);
                sides.iter_mut().for_each(|side| {
                    side.pop();
                });
            }
            for (side, distance) in sides.iter_mut().zip([from, to]) {
                side.push([place[0] + distance * normal[0], place[1] + distance * normal[1]]);
            }
        }
        before = Some(piece.point_and_normal(high).1.map(|n| up * n));
    }
    let [mut outline, far] = sides;
    outline.extend(far.into_iter().rev());
    Ok(outline)
}

#[cfg(test)]
mod tests {
    use colluvium_points::Shape;
    use serde_json::{Value, json};

    use crate::Case;

    fn case(shape: &Value, on: &Value) -> Result<Case, crate::CaseErrors> {
        let text = json!({
            "title": "layer", "space": "plane-strain", "domain": { "min": [-20, -5], "max": [20, 20] }, "gravity": [0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": shape }],
            "obstacles": [{ "name": "track", "wall": { "kind": "rough" }, "shape": on }],
            "stages": [{ "name": "go", "duration": 1 }]
        });
        Case::from_json(&text.to_string())
    }

    fn track() -> Value {
        // A slope of 5 m that falls by 30 degrees, an arc of 4 m and a level of 6 m.
        let (sine, cosine) = 30f64.to_radians().sin_cos();
        let foot = [-4.0 * sine, 4.0 * (1.0 - cosine)];
        json!({ "kind": "profile", "start": [foot[0] - 5.0 * cosine, foot[1] + 5.0 * sine],
            "pieces": [{ "to": foot }, { "to": [0, 0], "centre": [0, 4] }, { "to": [6, 0] }] })
    }

    #[test]
    fn a_layer_lies_along_slope_arc_and_flat() {
        let arc = 4.0 * 30f64.to_radians();
        let layer = |start: f64, end: f64, from: f64, to: f64| json!({ "kind": "arc-layer", "on": "track", "start": start, "end": end, "from": from, "to": to });
        let shape = |value: Value| case(&value, &track()).unwrap().bodies[0].shape.clone();
        let whole = shape(layer(1.0, 5.0 + arc + 3.0, 0.2, 0.7));
        // The arc is concave: the layer is shorter on top.
        let exact = 7.0 * 0.5 + 0.5 * 30f64.to_radians() * (3.8f64.powi(2) - 3.3f64.powi(2));
        let area = whole.measure(2).unwrap();
        assert!((area / exact - 1.0).abs() < 1e-5, "{area} for {exact}");
        assert!(whole.contains(&[2.9, 0.21]) && whole.contains(&[2.9, 0.69]));
        assert!(
            !whole.contains(&[2.9, 0.19]) && !whole.contains(&[3.1, 0.5]) && !whole.contains(&[2.0, 0.71])
        );
        let Shape::ArcLayer { .. } = whole else { panic!() };
        // The lowest of rows 0.1 m high lies half of that above the lower side, on slope, arc and level.
        let mut rows = layer(1.0, 5.0 + arc + 3.0, 0.2, 0.7);
        rows["rows"] = json!("terrain");
        let samples = colluvium_points::lattice(&shape(rows), [0.0; 2], 0.1).unwrap();
        assert!((samples.iter().map(|sample| sample.volume).sum::<f64>() / exact - 1.0).abs() < 1e-5);
        let lowest = samples.iter().step_by(5).map(|sample| sample.position);
        let (sine, cosine) = 30f64.to_radians().sin_cos();
        for [x, y] in lowest {
            let foot = x + (4.0 - y) * sine / cosine;
            let above = if x > 0.0 {
                y
            } else if foot > 0.0 {
                4.0 - x.hypot(4.0 - y)
            } else {
                (x + 4.0 * sine) * sine + (y - 4.0 * (1.0 - cosine)) * cosine
            };
            assert!((above - 0.25).abs() < 1e-4, "{x} {y}: {above}");
        }
    }

    #[test]
    fn a_kink_has_its_corner_at_the_distance_from_both_sides() {
        let line = json!({ "kind": "ground-line", "points": [[10, 0], [0, 0], [-6, 8]] });
        let layer = json!({ "kind": "arc-layer", "on": "track", "start": 2, "end": 15, "to": 1 });
        let shape = case(&layer, &line).unwrap().bodies[0].shape.clone();
        // Two straight parts of 8 and 5 m; on either side of the corner the tangent of half the turning angle is missing.
        let half = 0.5 * (8f64.atan2(6.0));
        let exact = 13.0 - half.tan();
        assert!(
            (shape.measure(2).unwrap() - exact).abs() < 1e-9,
            "{} for {exact}",
            shape.measure(2).unwrap()
        );
        assert!(shape.contains(&[4.0, 0.5]) && !shape.contains(&[4.0, -0.1]));
    }

    #[test]
    fn a_layer_beyond_its_line_is_refused_by_its_key() {
        let layer = json!({ "kind": "arc-layer", "on": "track", "start": 1, "end": 30, "to": 1 });
        let error = case(&layer, &track()).unwrap_err().to_string();
        assert!(error.contains("bodies[0].shape.end: 30 m is beyond"), "{error}");
        let ball = json!({ "kind": "ball", "centre": [0, -3], "radius": 1 });
        let error = case(&layer, &ball).unwrap_err().to_string();
        assert!(error.contains("bodies[0].shape.on"), "{error}");
        let turned = json!({ "kind": "arc-layer", "on": "track", "start": 3, "end": 2, "to": 1 });
        let error = case(&turned, &track()).unwrap_err().to_string();
        assert!(error.contains("bodies[0].shape.end"), "{error}");
    }
}
