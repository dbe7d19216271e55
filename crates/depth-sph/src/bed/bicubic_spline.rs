//! Bicubic B-spline near the levels of a raster: one surface, twice continuously differentiable, for level, slope and
//! curvature alike (sheet: depth-sph §2.9, as amended).

use std::ops::Range;

use colluvium_points::Raster;

/// Weight of each neighbour along an axis in a mean with weights 1, 2, 1.
const MEAN_WEIGHT: f64 = 0.25;
/// Weight of second differences in the filter of the levels, with which the spline interpolates cubic levels exactly.
const SHARPEN: f64 = -1.0 / 6.0;
/// Distance over which a level influences coefficients (nodes): one by the filter, and two by the extrapolation at each side.
const INFLUENCE_NODES: usize = 5;

/// Coefficients of a bicubic B-spline at the nodes of a raster and one node beyond its edges.
#[derive(Clone, Debug, PartialEq)]
pub struct BicubicSpline {
    columns: usize,
    coefficients: Vec<f64>,
}

/// Level, slopes along x and y, and second derivatives xx, xy, yy.
pub type SplineValues = (f64, [f64; 2], [f64; 3]);

/// Weights of four coefficients for the value, the first derivative times the spacing, and the second derivative times its square.
#[inline(always)]
fn weights(s: f64) -> [[f64; 4]; 3] {
    let (t, sixth) = (1.0 - s, 1.0 / 6.0);
    let (s2, t2) = (s * s, t * t);
    [
        [sixth * t2 * t, 2.0 / 3.0 - 0.5 * s2 * (2.0 - s), 2.0 / 3.0 - 0.5 * t2 * (2.0 - t), sixth * s2 * s],
        [-0.5 * t2, 0.5 * s * (3.0 * s - 4.0), -0.5 * t * (3.0 * t - 4.0), 0.5 * s2],
        [t, 3.0 * s - 2.0, 3.0 * t - 2.0, s],
    ]
}

impl BicubicSpline {
    /// Spline that interpolates the levels of a raster.
    pub fn new(raster: &Raster) -> Self {
        let (columns, rows) = (raster.columns + 2, raster.rows + 2);
        let mut spline = Self { columns, coefficients: vec![0.0; columns * rows] };
        spline.update_window(raster, [0..raster.columns, 0..raster.rows]);
        spline
    }

    /// Recomputes the coefficients that depend on the levels of given columns and rows.
    pub fn update_window(&mut self, raster: &Raster, [columns, rows]: [Range<usize>; 2]) {
        // Coefficients that change, and levels that they depend on, on the lattice with the rim.
        let wide = |range: &Range<usize>, by: usize, count: usize| {
            (range.start + 1).saturating_sub(by)..(range.end + 1 + by).min(count + 2)
        };
        let changed =
            [wide(&columns, INFLUENCE_NODES, raster.columns), wide(&rows, INFLUENCE_NODES, raster.rows)];
        let window = [
            wide(&columns, 2 * INFLUENCE_NODES, raster.columns),
            wide(&rows, 2 * INFLUENCE_NODES, raster.rows),
        ];
        let mut patch = LevelWindow::from_raster(raster, &window);
        patch.filter(SHARPEN);
        patch.fill();
        for j in changed[1].clone() {
            for i in changed[0].clone() {
                let found = patch.levels[(j - window[1].start) * patch.columns + i - window[0].start];
                // Never evaluated, but beside coefficients that are.
                self.coefficients[j * self.columns + i] = if found.is_finite() { found } else { 0.0 };
            }
        }
    }

    /// Surface at the fractions `s, t` of cell `i, j`, whose nodes are `dx, dy` apart (m).
    #[inline]
    pub fn evaluate(&self, [i, j]: [usize; 2], [s, t]: [f64; 2], [dx, dy]: [f64; 2]) -> SplineValues {
        let ([w, w1, w2], [u, u1, u2]) = (weights(s), weights(t));
        let mut sums = [0.0; 6];
        for b in 0..4 {
            let first = (j + b) * self.columns + i;
            let row = &self.coefficients[first..first + 4];
            let (mut r, mut r1, mut r2) = (0.0, 0.0, 0.0);
            for a in 0..4 {
                r += w[a] * row[a];
                r1 += w1[a] * row[a];
                r2 += w2[a] * row[a];
            }
            sums[0] += u[b] * r;
            sums[1] += u[b] * r1;
            sums[2] += u1[b] * r;
            sums[3] += u[b] * r2;
            sums[4] += u1[b] * r1;
            sums[5] += u2[b] * r;
        }
        let [x, y] = [1.0 / dx, 1.0 / dy];
        (sums[0], [sums[1] * x, sums[2] * y], [sums[3] * x * x, sums[4] * x * y, sums[5] * y * y])
    }
}

/// Levels after smoothing `times` times with the weights 1, 2, 1 along each axis, extrapolated linearly at edges and gaps.
pub fn smoothed_raster(raster: &Raster, times: usize) -> Raster {
    let mut patch = LevelWindow::from_raster(raster, &[0..raster.columns + 2, 0..raster.rows + 2]);
    (0..times).for_each(|_| patch.filter(MEAN_WEIGHT));
    let mut result = raster.clone();
    for j in 0..raster.rows {
        let first = (j + 1) * patch.columns + 1;
        let row = &patch.levels[first..first + raster.columns];
        let own = &mut result.values[j * raster.columns..(j + 1) * raster.columns];
        own.iter_mut().zip(row).filter(|(z, _)| z.is_finite()).for_each(|(z, mean)| *z = *mean);
    }
    result
}

/// Levels of a window of a raster with one node beyond its edges.
struct LevelWindow {
    columns: usize,
    rows: usize,
    levels: Vec<f64>,
    /// Whether each level is that of a node with data.
    has_data: Vec<bool>,
}

impl LevelWindow {
    /// Levels of a window of columns and rows of a raster; nodes outside the raster have no data.
    fn from_raster(raster: &Raster, [columns, rows]: &[Range<usize>; 2]) -> Self {
        let mut levels = Vec::with_capacity(columns.len() * rows.len());
        for j in rows.clone() {
            for i in columns.clone() {
                let inside = (1..=raster.columns).contains(&i) && (1..=raster.rows).contains(&j);
                levels.push(if inside { raster.value(i - 1, j - 1) } else { f64::NAN });
            }
        }
        let known = levels.iter().map(|z| z.is_finite()).collect();
        Self { columns: columns.len(), rows: rows.len(), levels, has_data: known }
    }

    /// Smooths over 3 × 3 nodes, with the weight `side` for each neighbour along an axis.
    fn filter(&mut self, side: f64) {
        self.fill();
        let before = self.levels.clone();
        let weights = [side, 1.0 - 2.0 * side, side];
        for j in 1..self.rows.saturating_sub(1) {
            for i in 1..self.columns.saturating_sub(1) {
                let own = j * self.columns + i;
                if !self.has_data[own] {
                    continue;
                }
                let row = |r: usize| {
                    let first = own + r * self.columns - self.columns - 1;
                    (0..3).map(|c| weights[c] * before[first + c]).sum::<f64>()
                };
                self.levels[own] = (0..3).map(|r| weights[r] * row(r)).sum();
            }
        }
    }

    /// Extrapolates the levels linearly to nodes without data next to nodes with data.
    fn fill(&mut self) {
        for j in 0..self.rows {
            for i in 0..self.columns {
                let own = j * self.columns + i;
                if !self.has_data[own] {
                    self.levels[own] = self.extrapolated_level(i, j);
                }
            }
        }
    }

    /// Mean of the linear extrapolations to a node along the axes, else along the diagonals. If no direction has two levels, it is the mean
    /// of single neighbours.
    fn extrapolated_level(&self, i: usize, j: usize) -> f64 {
        let at = |di: isize, dj: isize| {
            let (i, j) = (i.checked_add_signed(di)?, j.checked_add_signed(dj)?);
            let inside = i < self.columns && j < self.rows;
            let own = j * self.columns + i;
            (inside && self.has_data[own]).then(|| self.levels[own])
        };
        let mut level = (0.0, 0.0);
        for lines in [[(0, -1), (-1, 0), (1, 0), (0, 1)], [(-1, -1), (1, -1), (-1, 1), (1, 1)]] {
            let mut straight = (0.0, 0.0);
            for (di, dj) in lines {
                let Some(near) = at(di, dj) else { continue };
                level = (level.0 + near, level.1 + 1.0);
                if let Some(far) = at(2 * di, 2 * dj) {
                    straight = (straight.0 + 2.0 * near - far, straight.1 + 1.0);
                }
            }
            if straight.1 > 0.0 {
                return straight.0 / straight.1;
            }
        }
        level.0 / level.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(z: impl Fn(f64, f64) -> f64) -> Raster {
        Raster::from_function([16, 13], [0.0; 2], [2.0, 3.0], z)
    }

    fn evaluate_at(spline: &BicubicSpline, raster: &Raster, x: [f64; 2]) -> SplineValues {
        let (cell, share) = raster.locate_cell(x[0], x[1]).unwrap();
        spline.evaluate(cell, share, raster.spacing)
    }

    #[test]
    fn cubic_heights_are_reproduced_away_from_the_edges() {
        let z = |x: f64, y: f64| 3.0 + x - 2.0 * y + 0.01 * x * x * x - 0.02 * x * x * y + 0.003 * y * y * y;
        let raster = raster(z);
        let (level, slope, bend) = evaluate_at(&BicubicSpline::new(&raster), &raster, [13.3, 17.2]);
        let [x, y] = [13.3, 17.2];
        assert!((level - z(x, y)).abs() < 1e-10, "{level} {}", z(x, y));
        let exact = [1.0 + 0.03 * x * x - 0.04 * x * y, -2.0 - 0.02 * x * x + 0.009 * y * y];
        assert!((0..2).all(|c| (slope[c] - exact[c]).abs() < 1e-10), "{slope:?} {exact:?}");
        let exact = [0.06 * x - 0.04 * y, -0.04 * x, 0.018 * y];
        assert!((0..3).all(|c| (bend[c] - exact[c]).abs() < 1e-10), "{bend:?} {exact:?}");
    }

    #[test]
    fn a_plane_is_one_up_to_the_rim_and_beside_gaps() {
        let z = |x: f64, y: f64| 3.0 + x - 2.0 * y;
        let mut raster = raster(z);
        raster.values[5 * 16 + 6] = f64::NAN;
        let raster = smoothed_raster(&raster, 3);
        assert!(raster.value(6, 5).is_nan(), "a gap stays one");
        let spline = BicubicSpline::new(&raster);
        for x in [[0.1, 0.2], [29.9, 35.8], [9.0, 15.5], [0.0, 17.0]] {
            let (level, slope, _) = evaluate_at(&spline, &raster, x);
            assert!((level - z(x[0], x[1])).abs() < 1e-10, "{x:?} {level}");
            assert!((slope[0] - 1.0).abs() + (slope[1] + 2.0).abs() < 1e-10, "{x:?} {slope:?}");
        }
    }

    /// Sheet: a wave of 20 m on cells of 5 m keeps 0.50 of its height in one mean, 0.44 on the spline.
    #[test]
    fn smoothing_and_spline_attenuate_a_short_wave_by_the_factors_of_the_sheet() {
        let wave = |x: f64| (std::f64::consts::TAU * x / 20.0).cos();
        let raster = Raster::from_function([41, 5], [0.0; 2], [5.0; 2], |x, _| wave(x));
        let mean = smoothed_raster(&raster, 1);
        assert!((mean.value(20, 2) - 0.5).abs() < 1e-12, "{}", mean.value(20, 2));
        let (crest, ..) = evaluate_at(&BicubicSpline::new(&mean), &mean, [100.0, 10.0]);
        assert!((crest - 4.0 / 9.0).abs() < 1e-12, "{crest}");
    }

    #[test]
    fn an_updated_window_equals_the_spline_of_the_changed_raster() {
        let mut raster =
            Raster::from_function([40, 36], [0.0; 2], [2.0; 2], |x, y| (0.3 * x + 0.1 * y).sin());
        raster.values[12 * 40 + 9] = f64::NAN;
        raster.values[0] = f64::NAN;
        let mut spline = BicubicSpline::new(&raster);
        for (i, j) in [(8, 12), (10, 14), (0, 1), (39, 35)] {
            raster.values[j * 40 + i] -= 0.7;
            spline.update_window(&raster, [i..i + 1, j..j + 1]);
        }
        assert_eq!(spline, BicubicSpline::new(&raster));
    }
}
