//! Smooth surface through a raster of heights, for depth-integrated flow.

use std::ops::Range;

use crate::{Raster, RasterError};

/// Height, slope and curvature of a terrain at a position in plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TerrainSample {
    /// Height of the terrain (m).
    pub height: f64,
    /// Gradient of the height along x and y.
    pub gradient: [f64; 2],
    /// Second derivatives of the height: xx, xy, yy (1/m).
    pub hessian: [f64; 3],
}

/// Indices of the nodes around a position in plan, with their bilinear weights, whose sum is one.
pub type BilinearWeights = [(usize, f64); 4];

/// Terrain of depth-integrated flow: heights, slopes and second derivatives at the nodes of a raster, with bilinear interpolation between
/// them. Slopes are nodal recoveries on bilinear elements with a lumped mass, second derivatives are compact differences (sheet: depth-sph
/// §2.9): exact at inner nodes for heights of the second degree.
///
/// Contact uses the triangles of the same raster: [`HeightField`](crate::surface::HeightField).
#[derive(Clone, Debug)]
pub struct Terrain {
    raster: Raster,
    smoothing: usize,
    samples: Vec<TerrainSample>,
}

impl Terrain {
    /// Terrain of these heights (m). Second derivatives are averaged over 3 × 3 nodes `smoothing` times: those of survey data are noisy,
    /// those of analytic surfaces need no smoothing.
    ///
    /// # Errors
    /// See [`Raster::validate`].
    pub fn new(raster: Raster, smoothing: usize) -> Result<Self, RasterError> {
        raster.validate()?;
        let mut terrain = Self { samples: Vec::new(), raster, smoothing };
        terrain.recover_derivatives();
        Ok(terrain)
    }

    /// Raster of heights.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// Mutable heights of the nodes (m); [`Terrain::recover_derivatives`] must be called after a change.
    pub fn heights_mut(&mut self) -> &mut [f64] {
        &mut self.raster.values
    }

    /// Height, slope and second derivatives of each node, in the raster's order.
    pub fn node_samples(&self) -> &[TerrainSample] {
        &self.samples
    }

    /// Nodes around a position in plan (m) with their weights; `None` beyond the outermost nodes.
    #[inline]
    pub fn weights(&self, x: f64, y: f64) -> Option<BilinearWeights> {
        let ([i, j], [s, t]) = self.raster.locate_cell(x, y)?;
        let node = j * self.raster.columns + i;
        let above = node + self.raster.columns;
        Some([
            (node, (1.0 - s) * (1.0 - t)),
            (node + 1, s * (1.0 - t)),
            (above, (1.0 - s) * t),
            (above + 1, s * t),
        ])
    }

    /// Whether [`Terrain::sample_at`] has a value at a position in plan (m).
    #[inline]
    pub fn has_data_at(&self, x: f64, y: f64) -> bool {
        let Some(([i, j], _)) = self.raster.locate_cell(x, y) else { return false };
        let below = j * self.raster.columns + i;
        let above = below + self.raster.columns;
        [below, below + 1, above, above + 1].iter().all(|node| self.raster.values[*node].is_finite())
    }

    /// Height and derivatives at a position in plan (m); `None` beyond the outermost nodes or where a node around it has no data.
    #[inline]
    pub fn sample_at(&self, x: f64, y: f64) -> Option<TerrainSample> {
        let mut found = TerrainSample { height: 0.0, gradient: [0.0; 2], hessian: [0.0; 3] };
        for (node, weight) in self.weights(x, y)? {
            let bed = &self.samples[node];
            found.height += weight * bed.height;
            (0..2).for_each(|c| found.gradient[c] += weight * bed.gradient[c]);
            (0..3).for_each(|c| found.hessian[c] += weight * bed.hessian[c]);
        }
        found.height.is_finite().then_some(found)
    }

    /// Recovers slopes and second derivatives from the heights. Beside a node without data differences are one-sided; a node without two
    /// neighbours in a row has zero slope along it.
    pub fn recover_derivatives(&mut self) {
        let Raster { columns, rows, .. } = self.raster;
        let level = TerrainSample { height: f64::NAN, gradient: [0.0; 2], hessian: [0.0; 3] };
        self.samples.resize(self.raster.values.len(), level);
        self.recover_derivatives_within([0..columns, 0..rows]);
    }

    /// Recovers derivatives at the nodes of some columns and rows: all up to [`Terrain::derivative_reach`] from a changed height.
    pub fn recover_derivatives_within(&mut self, [columns, rows]: [Range<usize>; 2]) {
        let wide = |range: &Range<usize>, count: usize| {
            range.start.saturating_sub(self.smoothing)..(range.end + self.smoothing).min(count)
        };
        let around = [wide(&columns, self.raster.columns), wide(&rows, self.raster.rows)];
        let mut bends = Vec::with_capacity(around[0].len() * around[1].len());
        for j in around[1].clone() {
            for i in around[0].clone() {
                bends.push(self.second_differences(i, j));
            }
        }
        for _ in 0..self.smoothing {
            bends = self.smoothed_window(&bends, &around);
        }
        for j in rows {
            for i in columns.clone() {
                let own = (j - around[1].start) * around[0].len() + i - around[0].start;
                let bed = TerrainSample {
                    height: self.raster.value(i, j),
                    gradient: self.gradient(i, j),
                    hessian: bends[own],
                };
                self.samples[j * self.raster.columns + i] = bed;
            }
        }
    }

    /// Distance up to which a height affects derivatives (nodes): two beside a boundary or a gap, and one for each averaging.
    pub fn derivative_reach(&self) -> usize {
        2 + self.smoothing
    }

    /// Line of nodes along x.
    fn line_x(&self, j: usize) -> RasterLine<'_> {
        RasterLine { raster: &self.raster, axis: 0, cross_index: j }
    }

    /// Line of nodes along y.
    fn line_y(&self, i: usize) -> RasterLine<'_> {
        RasterLine { raster: &self.raster, axis: 1, cross_index: i }
    }

    /// Recovered slope at a node.
    fn gradient(&self, i: usize, j: usize) -> [f64; 2] {
        let Raster { columns, rows, spacing: [dx, dy], .. } = self.raster;
        // Means, with weights 1, 4, 1, of the nodes that have data.
        let weighted = |terms: [Option<f64>; 3]| {
            let both = terms.iter().zip([1.0, 4.0, 1.0]).filter_map(|(v, w)| v.map(|v| (v * w, w)));
            let (sum, weight) = both.fold((0.0, 0.0), |(s, n), (v, w)| (s + v, n + w));
            if weight > 0.0 { Some(sum / weight) } else { None }
        };
        let slope_x = |j: usize| self.line_x(j).slope(i).map(|d| d / dx);
        let slope_y = |i: usize| self.line_y(i).slope(j).map(|d| d / dy);
        [
            weighted(neighbour_indices(j, rows).map(|j| j.and_then(slope_x))).unwrap_or_default(),
            weighted(neighbour_indices(i, columns).map(|i| i.and_then(slope_y))).unwrap_or_default(),
        ]
    }

    /// Second differences at a node.
    fn second_differences(&self, i: usize, j: usize) -> [f64; 3] {
        let Raster { rows, spacing: [dx, dy], .. } = self.raster;
        let slope_x = |j: usize| self.line_x(j).slope(i).map(|d| d / dx);
        let cross =
            difference(neighbour_indices(j, rows).map(|j| j.and_then(slope_x))).map_or(0.0, |d| d / dy);
        [
            self.line_x(j).second_difference(i) / (dx * dx),
            cross,
            self.line_y(i).second_difference(j) / (dy * dy),
        ]
    }

    /// Means of the derivatives over 3 × 3 nodes, for the nodes of a window. Nodes without data do not count.
    fn smoothed_window(&self, before: &[[f64; 3]], [columns, rows]: &[Range<usize>; 2]) -> Vec<[f64; 3]> {
        let mut after = before.to_vec();
        for j in rows.clone() {
            for i in columns.clone() {
                let (mut sum, mut count) = ([0.0; 3], 0.0);
                for row in j.saturating_sub(1).max(rows.start)..(j + 2).min(rows.end) {
                    for column in i.saturating_sub(1).max(columns.start)..(i + 2).min(columns.end) {
                        if self.raster.value(column, row).is_finite() {
                            let own = (row - rows.start) * columns.len() + column - columns.start;
                            (0..3).for_each(|c| sum[c] += before[own][c]);
                            count += 1.0;
                        }
                    }
                }
                if count > 0.0 {
                    after[(j - rows.start) * columns.len() + i - columns.start] = sum.map(|s| s / count);
                }
            }
        }
        after
    }
}

/// Index before `k`, `k`, and index after it; `None` for one that is not below `count`.
fn neighbour_indices(k: usize, count: usize) -> [Option<usize>; 3] {
    [k.checked_sub(1), Some(k), Some(k + 1).filter(|next| *next < count)]
}

/// Difference per step at the middle one of three values. It is central, or one-sided where an outer value is missing.
fn difference([before, here, after]: [Option<f64>; 3]) -> Option<f64> {
    match (before, here, after) {
        (Some(b), Some(_), Some(a)) => Some(0.5 * (a - b)),
        (None, Some(h), Some(a)) => Some(a - h),
        (Some(b), Some(h), None) => Some(h - b),
        _ => None,
    }
}

/// Row or column of a raster.
struct RasterLine<'a> {
    raster: &'a Raster,
    axis: usize,
    cross_index: usize,
}

impl RasterLine<'_> {
    /// Height of a node of the line (m); `None` outside the raster or without a height.
    fn height(&self, k: Option<usize>) -> Option<f64> {
        let counts = [self.raster.columns, self.raster.rows];
        let k = k.filter(|k| *k < counts[self.axis])?;
        let (i, j) = if self.axis == 0 { (k, self.cross_index) } else { (self.cross_index, k) };
        Some(self.raster.value(i, j)).filter(|height| height.is_finite())
    }

    /// Heights of a node and of its two neighbours on the line (m).
    fn neighbour_heights(&self, k: usize) -> [Option<f64>; 3] {
        [k.checked_sub(1), Some(k), Some(k + 1)].map(|k| self.height(k))
    }

    /// Slope of the terrain along the line at a node.
    fn slope(&self, k: usize) -> Option<f64> {
        difference(self.neighbour_heights(k))
    }

    /// Second difference at node `k`. At an end it is that of the next node, and it is zero where fewer than three nodes have data.
    fn second_difference(&self, k: usize) -> f64 {
        let at = |k: usize| match self.neighbour_heights(k) {
            [Some(b), Some(h), Some(a)] => Some(a - 2.0 * h + b),
            _ => None,
        };
        at(k).or_else(|| at(k + 1)).or_else(|| k.checked_sub(1).and_then(at)).unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parabola(x: f64, y: f64) -> f64 {
        1.0 + 0.3 * x - 0.2 * y + 0.05 * x * x + 0.02 * x * y - 0.04 * y * y
    }

    #[test]
    fn heights_of_the_second_degree_have_exact_slopes_and_curvatures_at_inner_nodes() {
        let raster = Raster::from_function([12, 9], [-3.0, 2.0], [0.5, 0.25], parabola);
        for smoothing in [0, 2] {
            let terrain = Terrain::new(raster.clone(), smoothing).unwrap();
            let (x, y) = (-1.0, 3.0);
            let bed = terrain.sample_at(x, y).unwrap();
            assert!(terrain.has_data_at(x, y) && !terrain.has_data_at(-3.1, y));
            let exact = [0.3 + 0.1 * x + 0.02 * y, -0.2 + 0.02 * x - 0.08 * y];
            assert!((bed.height - parabola(x, y)).abs() < 1e-12);
            assert!((0..2).all(|c| (bed.gradient[c] - exact[c]).abs() < 1e-12), "{bed:?} {exact:?}");
            let hessian = [0.1, 0.02, -0.08];
            assert!((0..3).all(|c| (bed.hessian[c] - hessian[c]).abs() < 1e-10), "{bed:?}");
        }
    }

    #[test]
    fn a_plane_is_one_up_to_its_rim_and_beside_a_gap() {
        let mut raster = Raster::from_function([6, 6], [0.0; 2], [2.0; 2], |x, y| 3.0 - 0.5 * x + 0.25 * y);
        raster.values[14] = f64::NAN;
        let terrain = Terrain::new(raster, 1).unwrap();
        for (x, y) in [(0.0, 0.0), (9.9, 9.9), (10.0, 3.0), (7.5, 7.5), (1.0, 8.0)] {
            let bed = terrain.sample_at(x, y).unwrap();
            assert!((bed.gradient[0] + 0.5).abs() < 1e-12 && (bed.gradient[1] - 0.25).abs() < 1e-12);
            assert!(bed.hessian.iter().all(|h| h.abs() < 1e-12));
        }
        assert_eq!(terrain.sample_at(4.5, 4.5), None);
        assert_eq!(terrain.sample_at(-0.1, 4.0), None);
    }

    #[test]
    fn a_window_recovers_as_the_whole_does() {
        let mut raster =
            Raster::from_function([14, 12], [0.0; 2], [0.5; 2], |x, y| (3.0 * x).sin() * y.cos());
        raster.values[30] = f64::NAN;
        let mut parts = Terrain::new(raster, 2).unwrap();
        parts.heights_mut()[6 * 14 + 7] += 0.3;
        let mut whole = parts.clone();
        whole.recover_derivatives();
        let reach = parts.derivative_reach();
        parts.recover_derivatives_within([7 - reach..8 + reach, 6 - reach..7 + reach]);
        let bits = |terrain: &Terrain| -> Vec<u64> {
            let all =
                terrain.node_samples().iter().flat_map(|bed| bed.gradient.into_iter().chain(bed.hessian));
            all.map(f64::to_bits).collect()
        };
        assert_eq!(bits(&parts), bits(&whole));
    }
}
