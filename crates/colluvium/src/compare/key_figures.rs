//! Key figures that are measured of every method alike, independent of the measures of the case.

use crate::case::{Case, FieldData, Snapshot};

/// Share of the mass behind a front or below a top. Single points that fly ahead do not count.
const QUANTILE: f64 = 0.999;
/// Number of columns of a profile over the longest deposit.
const PROFILE_COLUMNS: usize = 100;

/// Axes in which a case is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CaseAxes {
    /// Axis along which deposits spread.
    pub spreading: usize,
    /// Axis against gravity.
    pub vertical: usize,
}

impl CaseAxes {
    /// Axes of a case: vertical is the axis of the largest gravity, y without gravity; spreading is the first other axis.
    pub fn of_case(case: &Case) -> Self {
        let size = |axis: usize| case.gravity.get(axis).copied().unwrap_or(0.0).abs();
        let dimension = case.dimension();
        let largest = (0..dimension).max_by(|a, b| size(*a).total_cmp(&size(*b)));
        let up =
            largest.filter(|axis| size(*axis) > 0.0).unwrap_or_else(|| dimension.saturating_sub(1).min(1));
        Self { spreading: if up == 0 { 1 } else { 0 }, vertical: up }
    }
}

/// Key figures of one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyFigures {
    /// Position of the front along the axis of spreading (m): 99.9 % of the mass lies behind.
    pub front: f64,
    /// Height of the top (m): 99.9 % of the mass lies below.
    pub top: f64,
    /// Centre of mass along the axis of spreading, and up (m).
    pub centre: [f64; 2],
    /// Speed below which 99.9 % of the mass is (m/s).
    pub speed: f64,
}

impl KeyFigures {
    /// Key figures of a snapshot; `None` where it has no points.
    pub fn of_snapshot(snapshot: &Snapshot, axes: CaseAxes) -> Option<Self> {
        let count = snapshot.positions.len();
        if count == 0 {
            return None;
        }
        let ones = vec![1.0; count];
        let mass = snapshot.scalars("mass").unwrap_or(&ones);
        let edge = |axis: usize, i: usize| snapshot.positions[i][axis] + 0.5 * snapshot.extents[i][axis];
        let whole: f64 = mass.iter().sum();
        let mean =
            |axis: usize| snapshot.positions.iter().zip(mass).map(|(x, m)| x[axis] * m).sum::<f64>() / whole;
        // The velocity that moves the points, where they carry more than one.
        let velocity = snapshot.field("grid_velocity").or_else(|| snapshot.field("velocity"));
        let speeds: Vec<f64> = match velocity.map(|field| &field.data) {
            Some(FieldData::Vector(v)) => v.iter().map(length).collect(),
            _ => vec![f64::NAN; count],
        };
        Some(Self {
            front: quantile((0..count).map(|i| (edge(axes.spreading, i), mass[i]))),
            top: quantile((0..count).map(|i| (edge(axes.vertical, i), mass[i]))),
            centre: [mean(axes.spreading), mean(axes.vertical)],
            speed: quantile(speeds.into_iter().zip(mass.iter().copied())),
        })
    }
}

/// Length of a vector.
fn length(v: &[f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Weighted quantile: the value at which [`QUANTILE`] of the weights are reached.
fn quantile(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let mut values: Vec<(f64, f64)> = values.filter(|(value, _)| value.is_finite()).collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted = QUANTILE * values.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut sum = 0.0;
    for (value, weight) in &values {
        sum += weight;
        if sum >= wanted {
            return *value;
        }
    }
    values.last().map_or(f64::NAN, |(value, _)| *value)
}

/// Columns in which the profiles of all methods are evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileColumns {
    start: f64,
    width: f64,
    count: usize,
}

impl ProfileColumns {
    /// Columns over the extent of all snapshots, none narrower than the widest point of the finest snapshot.
    pub fn spanning(snapshots: &[&Snapshot], axes: CaseAxes) -> Option<Self> {
        let (mut low, mut high, mut finest) = (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY);
        for snapshot in snapshots {
            let mut widest = 0.0_f64;
            for (x, extent) in snapshot.positions.iter().zip(&snapshot.extents) {
                let (place, width) = (x[axes.spreading], extent[axes.spreading]);
                if (place + width).is_finite() {
                    (low, high) = (low.min(place - 0.5 * width), high.max(place + 0.5 * width));
                    widest = widest.max(width);
                }
            }
            finest = if widest > 0.0 { finest.min(widest) } else { finest };
        }
        if low >= high || !(high - low).is_finite() {
            return None;
        }
        let narrowest = if finest.is_finite() { finest } else { f64::MIN_POSITIVE };
        let count = PROFILE_COLUMNS.min(((high - low) / narrowest) as usize).max(1);
        Some(Self { start: low, width: (high - low) / count as f64, count })
    }

    /// Profile: height of the highest point over each column (m), with the column's centre (m); NaN without points.
    pub fn profile(&self, snapshot: &Snapshot, axes: CaseAxes) -> Vec<(f64, f64)> {
        let mut heights = vec![f64::NAN; self.count];
        for (x, e) in snapshot.positions.iter().zip(&snapshot.extents) {
            let (centre, half) = (x[axes.spreading], 0.5 * e[axes.spreading]);
            let column = |place: f64| ((place - self.start) / self.width).clamp(0.0, (self.count - 1) as f64);
            let top = x[axes.vertical] + 0.5 * e[axes.vertical];
            // The columns whose middle the point covers, and its own.
            let first = column(centre - half + 0.5 * self.width) as usize;
            let last = column(centre + half - 0.5 * self.width) as usize;
            let own = column(centre) as usize;
            for k in (first..=last).chain([own]) {
                heights[k] = heights[k].max(top);
            }
        }
        let middle = |k: usize| self.start + (k as f64 + 0.5) * self.width;
        heights.into_iter().enumerate().map(|(k, height)| (middle(k), height)).collect()
    }
}

/// Value of a curve at a position, linear between its points and constant beyond them; NaN for an empty curve.
pub(super) fn interpolated(curve: &[(f64, f64)], x: f64) -> f64 {
    let next = curve.partition_point(|(place, _)| *place < x);
    match (next.checked_sub(1).map(|k| curve[k]), curve.get(next)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0),
        (Some(a), None) => a.1,
        (None, Some(b)) => b.1,
        (None, None) => f64::NAN,
    }
}

/// A number to five digits.
pub(super) fn five_digits(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        return "–".to_owned();
    }
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.3e}");
    }
    let digits = if size >= 1.0 { 4 - (size.log10() as usize).min(4) } else { 5 };
    let plain = format!("{value:.digits$}");
    if plain.contains('.') { plain.trim_end_matches('0').trim_end_matches('.').to_owned() } else { plain }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Field;

    fn block(width: f64, height: f64, spacing: f64) -> Snapshot {
        let (columns, rows) = ((width / spacing).round() as usize, (height / spacing).round() as usize);
        let at = |k: usize| (k as f64 + 0.5) * spacing;
        let positions: Vec<_> =
            (0..columns * rows).map(|k| [at(k % columns), at(k / columns), 0.0]).collect();
        let count = positions.len();
        let scalar = |name: &str, value: f64| Field {
            name: name.to_owned(),
            unit: "",
            data: FieldData::Scalar(vec![value; count]),
        };
        let velocity = Field {
            name: "velocity".into(),
            unit: "m/s",
            data: FieldData::Vector(vec![[3.0, 4.0, 0.0]; count]),
        };
        Snapshot {
            time: 0.0,
            step: 0,
            ids: (0..count as u64).collect(),
            bodies: vec![0; count],
            extents: vec![[spacing, spacing, 0.0]; count],
            positions,
            fields: vec![scalar("mass", spacing * spacing), velocity],
        }
    }

    const AXES: CaseAxes = CaseAxes { spreading: 0, vertical: 1 };

    #[test]
    fn figures_of_a_block_are_its_edges_and_centre_at_any_spacing() {
        for spacing in [0.1, 0.02] {
            let figures = KeyFigures::of_snapshot(&block(2.0, 1.0, spacing), AXES).unwrap();
            for (found, expected) in [
                (figures.front, 2.0),
                (figures.top, 1.0),
                (figures.centre[0], 1.0),
                (figures.centre[1], 0.5),
                (figures.speed, 5.0),
            ] {
                assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn the_speed_is_that_of_the_grid_where_points_carry_more() {
        let mut snapshot = block(2.0, 1.0, 0.1);
        let still = FieldData::Vector(vec![[0.0, 0.5, 0.0]; snapshot.positions.len()]);
        snapshot.fields.push(Field { name: "grid_velocity".into(), unit: "m/s", data: still });
        assert!((KeyFigures::of_snapshot(&snapshot, AXES).unwrap().speed - 0.5).abs() < 1e-12);
    }

    #[test]
    fn profiles_are_independent_of_spacing() {
        let (coarse, fine, low) = (block(2.0, 1.0, 0.1), block(2.0, 1.0, 0.025), block(2.0, 0.5, 0.05));
        let columns = ProfileColumns::spanning(&[&coarse, &fine, &low], AXES).unwrap();
        for (snapshot, height) in [(&coarse, 1.0), (&fine, 1.0), (&low, 0.5)] {
            let profile = columns.profile(snapshot, AXES);
            assert!(profile.iter().all(|(_, top)| (top - height).abs() < 1e-12), "{profile:?}");
        }
    }

    #[test]
    fn profiles_below_zero_and_gaps_between_points_keep_their_heights() {
        let (mut snapshot, mut far) = (block(2.0, 1.0, 0.1), block(2.0, 1.0, 0.1));
        snapshot.positions.iter_mut().for_each(|x| x[1] -= 5.0);
        far.positions.iter_mut().for_each(|x| (x[0], x[1]) = (x[0] + 4.0, x[1] - 7.0));
        let columns = ProfileColumns::spanning(&[&snapshot, &far], AXES).unwrap();
        let profile = columns.profile(&snapshot, AXES);
        let (first, last) = (profile.first().unwrap().1, profile.last().unwrap().1);
        assert!((first + 4.0).abs() < 1e-12 && last.is_nan(), "{profile:?}");
    }

    #[test]
    fn single_points_ahead_do_not_define_the_front() {
        let mut snapshot = block(2.0, 1.0, 0.02);
        snapshot.positions[7][0] = 50.0;
        assert!((KeyFigures::of_snapshot(&snapshot, AXES).unwrap().front - 2.0).abs() < 1e-9);
    }
}
