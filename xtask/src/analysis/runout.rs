//! Run-out of points, and base of a moving mass.

use std::collections::BTreeMap;

use colluvium::case::Snapshot;

use crate::analysis::statistics::MaxOrNan;

/// Quantile of the position `along` for a share of the particles, which have equal masses (m).
pub fn mass_quantile_position(snapshot: &Snapshot, share: f64, along: impl Fn(&[f64; 3]) -> f64) -> f64 {
    let mut places: Vec<f64> = snapshot.positions.iter().map(along).collect();
    places.sort_by(f64::total_cmp);
    let number = (share * places.len() as f64).ceil() as usize;
    places.get(number.saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

/// Position along x of the outermost particle with at least two neighbours within 1.5 spacings (m; sheet: sph §5.4 set S).
pub fn connected_front(snapshot: &Snapshot, spacing: f64) -> f64 {
    farthest_connected(snapshot, spacing, |x| x[0])
}

/// Farthest position `along` of particles with at least two neighbours within 1.5 spacings (m).
pub fn farthest_connected(snapshot: &Snapshot, spacing: f64, along: impl Fn(&[f64; 3]) -> f64) -> f64 {
    let x = &snapshot.positions;
    let near = |a: &[f64; 3], b: &[f64; 3]| {
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>() <= (1.5 * spacing).powi(2)
    };
    let mut order: Vec<&[f64; 3]> = x.iter().collect();
    order.sort_by(|a, b| along(b).total_cmp(&along(a)));
    let held = |a: &&&[f64; 3]| x.iter().filter(|b| near(a, b)).count() > 2;
    order.iter().find(held).map_or(f64::NAN, |a| along(a))
}

/// Height of the highest point whose coordinate is below `x` (m).
pub fn crest(snapshot: &Snapshot, x: f64) -> f64 {
    let near = snapshot.positions.iter().zip(&snapshot.extents).filter(|(p, _)| p[0] < x);
    near.map(|(p, e)| p[1] + 0.5 * e[1]).max_or_nan()
}

/// Base of the moving mass. In each column of particles, given by initial position (m) and value, it is the first position from the top
/// down where the value falls below a level.
pub fn base_of_moving_mass(
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

#[cfg(test)]
mod tests {
    use super::*;

    fn snapshot(positions: Vec<[f64; 3]>) -> Snapshot {
        let extents = vec![[0.5, 0.2, 0.0]; positions.len()];
        Snapshot { positions, extents, ..Snapshot::default() }
    }

    #[test]
    fn reach_is_the_position_of_a_mass_share_and_not_of_the_farthest_point() {
        let row = snapshot((0..10).map(|i| [f64::from(i), 0.0, 0.0]).collect());
        assert_eq!(mass_quantile_position(&row, 1.0, |x| x[0]), 9.0);
        assert_eq!(mass_quantile_position(&row, 0.9, |x| x[0]), 8.0);
        assert_eq!(mass_quantile_position(&row, 0.5, |x| -x[0]), -5.0);
        assert!(mass_quantile_position(&snapshot(Vec::new()), 0.5, |x| x[0]).is_nan());
    }

    #[test]
    fn a_front_point_needs_two_neighbours() {
        // A row a metre apart, the last of which has one neighbour, and one detached point.
        let mut row: Vec<[f64; 3]> = (0..4).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        row.push([9.0, 0.0, 0.0]);
        assert_eq!(connected_front(&snapshot(row.clone()), 1.0), 2.0);
        assert_eq!(farthest_connected(&snapshot(row), 1.0, |x| -x[0]), -1.0);
        assert!(connected_front(&snapshot(vec![[0.0; 3]]), 1.0).is_nan());
    }

    #[test]
    fn the_crest_is_the_top_of_the_highest_point_before_a_position() {
        let points = snapshot(vec![[0.0, 1.0, 0.0], [1.0, 2.0, 0.0], [2.0, 3.0, 0.0]]);
        assert_eq!(crest(&points, 1.5), 2.1);
        assert!(crest(&points, -1.0).is_nan());
    }

    #[test]
    fn the_base_of_the_moving_mass_is_interpolated_between_points() {
        // Two columns: the value falls by one a metre downwards; in the second column everything moves.
        let first = (0..4).map(|i| ([0.5, f64::from(i)], f64::from(i)));
        let second = (0..4).map(|i| ([1.5, f64::from(i)], 9.0));
        assert_eq!(base_of_moving_mass(first.chain(second), 1.0, 1.25), [[0.5, 1.25]]);
    }
}
