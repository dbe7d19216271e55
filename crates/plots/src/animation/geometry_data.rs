//! Rigid geometry behind the points, for the player.

use serde_json::{Value, json};

use crate::animation::quantisation::QuantisedRange;
use crate::animation::text;
use crate::{Heights, RigidGeometry};

/// Rigid geometry as JSON for the player of the animation, with the positions of moving parts at `times` (s).
pub(super) fn geometry_data(ground: &RigidGeometry, times: &[f64]) -> Value {
    let moving = ground.moving.iter().map(|one| {
        let poses = times.iter().map(|time| one.pose(*time));
        json!({ "lines": lines(&one.lines), "poses": poses.collect::<Vec<_>>() })
    });
    let shells = ground.shells.iter().map(|one| {
        let poses = times.iter().map(|time| one.pose(*time));
        json!({ "corners": rounded_positions(&one.corners), "faces": one.faces, "poses": poses.collect::<Vec<_>>() })
    });
    json!({
        "shells": shells.collect::<Vec<_>>(), "lines": lines(&ground.lines), "moving": moving.collect::<Vec<_>>(),
        "heights": ground.heights.as_ref().and_then(heights),
    })
}

/// Lines with rounded coordinates.
fn lines(lines: &[Vec<[f64; 2]>]) -> Vec<Vec<[f64; 2]>> {
    lines.iter().map(|line| rounded_positions(line)).collect()
}

/// Positions to six digits (m).
fn rounded_positions<const D: usize>(places: &[[f64; D]]) -> Vec<[f64; D]> {
    let digits = |x: f64| format!("{x:.5e}").parse::<f64>().unwrap_or(x);
    places.iter().map(|x| x.map(digits)).collect()
}

/// Heights quantised to 16 bits; `None` where there are none.
fn heights(heights: &Heights) -> Option<Value> {
    let there = || heights.values.iter().filter(|height| height.is_finite());
    let low = there().copied().reduce(f64::min)?;
    let high = there().copied().fold(low, f64::max);
    // The last number is reserved for NaN.
    let scale = QuantisedRange { low, high: if high > low { high } else { low + 1.0 }, steps: 65_534 };
    let words: Vec<u8> =
        heights.values.iter().flat_map(|height| (scale.quantise(*height) as u16).to_le_bytes()).collect();
    Some(json!({
        "counts": heights.counts, "origin": heights.origin, "spacing": heights.spacing, "low": scale.low, "high": scale.high,
        "values": text(&words),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use base64::Engine;

    #[test]
    fn packed_heights_are_recovered_within_a_step_and_no_data_remains() {
        let values = vec![3.0, f64::NAN, 7.5, 5.25];
        let of = |values: Vec<f64>| {
            let heights =
                Heights { counts: [values.len(), 1], origin: [0.0, 1.0], spacing: [1.0, 2.0], values };
            geometry_data(&RigidGeometry { heights: Some(heights), ..RigidGeometry::default() }, &[])["heights"].clone()
        };
        let data = of(values.clone());
        let engine = base64::engine::general_purpose::STANDARD;
        let bytes = engine.decode(data["values"].as_str().unwrap()).unwrap();
        let (low, high) = (data["low"].as_f64().unwrap(), data["high"].as_f64().unwrap());
        for (pair, value) in bytes.as_chunks::<2>().0.iter().zip(values) {
            let number = u16::from_le_bytes(*pair);
            if value.is_nan() {
                assert_eq!(number, u16::MAX);
            } else {
                assert!((low + f64::from(number) / 65_534.0 * (high - low) - value).abs() < 1e-4);
            }
        }
        assert!(of(vec![f64::NAN]).is_null());
    }
}
