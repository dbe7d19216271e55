//! How far points reach, and where what moves ends.

use std::collections::BTreeMap;

use colluvium::case::Snapshot;

use super::numbers::Largest;

/// How far `along` that share of the particles reaches, all of one mass (m).
pub fn reach_of(snapshot: &Snapshot, share: f64, along: impl Fn(&[f64; 3]) -> f64) -> f64 {
    let mut places: Vec<f64> = snapshot.positions.iter().map(along).collect();
    places.sort_by(f64::total_cmp);
    let number = (share * places.len() as f64).ceil() as usize;
    places.get(number.saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

/// The outermost particle along x with at least two neighbours within 1.5 spacings (sheet: sph §5.4 set S), in m.
pub fn held_front(snapshot: &Snapshot, spacing: f64) -> f64 {
    farthest_held(snapshot, spacing, |x| x[0])
}

/// How far `along` the particles reach that have at least two neighbours within 1.5 spacings (m).
pub fn farthest_held(snapshot: &Snapshot, spacing: f64, along: impl Fn(&[f64; 3]) -> f64) -> f64 {
    let x = &snapshot.positions;
    let near = |a: &[f64; 3], b: &[f64; 3]| {
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>() <= (1.5 * spacing).powi(2)
    };
    let mut order: Vec<&[f64; 3]> = x.iter().collect();
    order.sort_by(|a, b| along(b).total_cmp(&along(a)));
    let held = |a: &&&[f64; 3]| x.iter().filter(|b| near(a, b)).count() > 2;
    order.iter().find(held).map_or(f64::NAN, |a| along(a))
}

/// Height of the highest point before `x` (m).
pub fn crest(snapshot: &Snapshot, x: f64) -> f64 {
    let near = snapshot.positions.iter().zip(&snapshot.extents).filter(|(p, _)| p[0] < x);
    near.map(|(p, e)| p[1] + 0.5 * e[1]).largest()
}

/// Where what moves ends: in each column of particles, given by their places at the start (m) and a value, from the top
/// down the first place where the value falls below a level.
pub fn lower_boundary(
    particles: impl IntoIterator<Item = ([f64; 2], f64)>,
    spacing: f64,
    level: f64,
) -> Vec<[f64; 2]> {
    let mut columns: BTreeMap<i64, Vec<([f64; 2], f64)>> = BTreeMap::new();
    for (place, value) in particles {
        columns.entry((place[0] / spacing).floor() as i64).or_default().push((place, value));
    }
    let crossing = |mut column: Vec<([f64; 2], f64)>| {
        column.sort_by(|a, b| b.0[1].total_cmp(&a.0[1]));
        let pair = column.windows(2).find(|pair| pair[0].1 >= level && pair[1].1 < level)?;
        let ((above, a), (below, b)) = (pair[0], pair[1]);
        let share = (a - level) / (a - b);
        Some([0, 1].map(|axis| above[axis] + share * (below[axis] - above[axis])))
    };
    columns.into_values().filter_map(crossing).collect()
}
