//! Distribution of mass over cells in plan, by which the final states of methods are compared on any ground.

use super::key_figures::CaseAxes;
use crate::case::Snapshot;

/// Greatest number of cells along an axis, with one horizontal axis and with two.
const MOST_CELLS: [usize; 2] = [50, 25];

/// One horizontal axis of the cells.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlanAxis {
    axis: usize,
    start: f64,
    width: f64,
    count: usize,
}

impl PlanAxis {
    /// Cells along an axis over the extent of all points, none narrower than the widest point; `None` without extent.
    fn spanning(snapshots: &[&Snapshot], axis: usize, most: usize) -> Option<Self> {
        let points = snapshots.iter().flat_map(|snapshot| snapshot.positions.iter().zip(&snapshot.extents));
        let (mut low, mut high, mut widest) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        for (x, extent) in points.filter(|(x, extent)| (x[axis] + extent[axis]).is_finite()) {
            low = low.min(x[axis] - 0.5 * extent[axis]);
            high = high.max(x[axis] + 0.5 * extent[axis]);
            widest = widest.max(extent[axis]);
        }
        if !(high > low && widest > 0.0) {
            return None;
        }
        let count = most.min(((high - low) / widest) as usize).max(1);
        Some(Self { axis, start: low, width: (high - low) / count as f64, count })
    }

    /// Cells that a point covers, each with its share of the point.
    fn shares(&self, position: f64, extent: f64) -> Vec<(usize, f64)> {
        let place = |x: f64| ((x - self.start) / self.width).clamp(0.0, self.count as f64);
        let (low, high) = (place(position - 0.5 * extent), place(position + 0.5 * extent));
        let cell = |place: f64| (place as usize).min(self.count - 1);
        if high - low <= 0.0 {
            return vec![(cell(low), 1.0)];
        }
        let overlap = |k: usize| high.min((k + 1) as f64) - low.max(k as f64);
        (cell(low)..=cell(high)).map(|k| (k, overlap(k) / (high - low))).collect()
    }
}

/// Cells in plan, equal for all methods: columns in two dimensions, rectangles in three.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlanCells {
    axes: Vec<PlanAxis>,
}

impl PlanCells {
    /// Cells over the extent of all snapshots; `None` without points.
    pub(super) fn spanning(snapshots: &[&Snapshot], axes: CaseAxes) -> Option<Self> {
        let horizontal = (0..3).filter(|axis| *axis != axes.vertical);
        let is_plane = |axis: &usize| PlanAxis::spanning(snapshots, *axis, 1).is_some();
        let horizontal: Vec<usize> = horizontal.filter(is_plane).collect();
        let most = MOST_CELLS[horizontal.len().checked_sub(1)?.min(1)];
        let axes = horizontal.iter().map(|axis| PlanAxis::spanning(snapshots, *axis, most));
        Some(Self { axes: axes.collect::<Option<Vec<_>>>()? })
    }

    /// Mass in each cell (kg). A point's mass is spread evenly over its extent. Without masses each point counts one.
    pub(super) fn masses(&self, snapshot: &Snapshot) -> Vec<f64> {
        let mut masses = vec![0.0; self.axes.iter().map(|axis| axis.count).product()];
        let mass = snapshot.scalars("mass");
        for (k, (x, extent)) in snapshot.positions.iter().zip(&snapshot.extents).enumerate() {
            let mut parts = vec![(0, mass.map_or(1.0, |mass| mass[k]))];
            for axis in &self.axes {
                let shares = axis.shares(x[axis.axis], extent[axis.axis]);
                let split = |(cell, part): &(usize, f64)| {
                    let (row, part) = (cell * axis.count, *part);
                    shares.iter().map(move |(k, share)| (row + k, part * share)).collect::<Vec<_>>()
                };
                parts = parts.iter().flat_map(split).collect();
            }
            for (cell, part) in parts {
                masses[cell] += part;
            }
        }
        masses
    }
}

/// Share of the mass of the first distribution that another one has in other cells: half the sum of the differences over the mass of the
/// first. It is zero for equal distributions and one where no cell is common. Mass that one of them lacks counts half.
pub(super) fn displaced_share(first: &[f64], other: &[f64]) -> f64 {
    let apart: f64 = first.iter().zip(other).map(|(a, b)| (a - b).abs()).sum();
    0.5 * apart / first.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{Field, FieldData};

    const AXES: CaseAxes = CaseAxes { spreading: 0, vertical: 2 };

    /// Layer on an inclined plane: points over a rectangle in plan, at the elevation of the plane.
    fn layer(start: f64, spacing: f64) -> Snapshot {
        let (columns, rows) = ((2.0 / spacing).round() as usize, (1.0 / spacing).round() as usize);
        let at = |k: usize| (k as f64 + 0.5) * spacing;
        let place = |k: usize| {
            let x = start + at(k % columns);
            [x, at(k / columns), 1000.0 - 0.5 * x]
        };
        let count = columns * rows;
        let mass = vec![spacing * spacing; count];
        Snapshot {
            time: 0.0,
            step: 0,
            ids: (0..count as u64).collect(),
            bodies: vec![0; count],
            extents: vec![[spacing; 3]; count],
            positions: (0..count).map(place).collect(),
            fields: vec![Field { name: "mass".to_owned(), unit: "kg", data: FieldData::Scalar(mass) }],
        }
    }

    #[test]
    fn the_displaced_share_is_independent_of_spacing_and_elevation() {
        let (first, fine, moved) = (layer(0.0, 0.1), layer(0.0, 0.05), layer(0.5, 0.1));
        let cells = PlanCells::spanning(&[&first, &fine, &moved], AXES).unwrap();
        let masses = |snapshot| cells.masses(snapshot);
        assert!((masses(&first).iter().sum::<f64>() - 2.0).abs() < 1e-12);
        assert!(displaced_share(&masses(&first), &masses(&fine)) < 1e-12);
        // A layer of length 2 that is 0.5 further has a quarter of its mass elsewhere.
        assert!((displaced_share(&masses(&first), &masses(&moved)) - 0.25).abs() < 1e-9);
    }

    #[test]
    fn layers_without_common_cells_are_displaced_as_a_whole() {
        let (first, far) = (layer(0.0, 0.1), layer(4.0, 0.1));
        let cells = PlanCells::spanning(&[&first, &far], AXES).unwrap();
        assert!((displaced_share(&cells.masses(&first), &cells.masses(&far)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn in_a_plane_the_cells_are_columns() {
        let mut flat = layer(0.0, 0.1);
        flat.positions.iter_mut().for_each(|x| (x[1], x[2]) = (x[2], 0.0));
        flat.extents.iter_mut().for_each(|extent| extent[2] = 0.0);
        let cells = PlanCells::spanning(&[&flat], CaseAxes { spreading: 0, vertical: 1 }).unwrap();
        let masses = cells.masses(&flat);
        assert_eq!(masses.len(), 20);
        assert!(masses.iter().all(|mass| (mass - 0.1).abs() < 1e-12));
    }
}
