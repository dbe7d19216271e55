//! Pore pressure over the depth of a node from the points of a depth-resolved model (sheet: depth-sph §3.2, 4).

use crate::laws::pore_pressure_column::mean;

/// Profile of pore pressure over the depth of a node, from the points above its square.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferredPressure {
    /// Depth of the transferred points (m).
    pub depth: f64,
    /// Pore pressures at equal distances from the base to the surface (Pa), zero at the surface.
    pub pressure: Vec<f64>,
}

/// Point above a lattice square: its volume (m³; m² in a profile), height above the bed (m) and pore pressure (Pa).
pub type PointAboveSquare = [f64; 3];

impl TransferredPressure {
    /// Pore-pressure profile on `cells` intervals. It is the least-squares fit `(1 - ζ)(a + b ζ)` to the means of layers, with the
    /// residuals interpolated linearly. A linear part over the depth makes its mean that of the points. Linear profiles are exact. Points
    /// whose middle lies in the bed have no column.
    pub fn from_points(points: &[PointAboveSquare], cells: usize) -> Self {
        let volume: f64 = points.iter().map(|point| point[0]).sum();
        let over = |value: usize| points.iter().map(|point| point[0] * point[value]).sum::<f64>() / volume;
        // Twice the height of the centroid, whatever the size of the points.
        let (depth, whole) = (2.0 * over(1), over(2));
        if !(depth > 0.0) {
            return Self { depth: 0.0, pressure: vec![0.0; cells + 1] };
        }
        let layers = layers(points, depth, cells);
        let (a, b) = smooth(&layers);
        let smooth = |zeta: f64| (1.0 - zeta) * (a + b * zeta);
        let off = |layer: &[f64; 3]| (layer[1], layer[2] - smooth(layer[1]));
        let at = |zeta: f64| {
            let next = layers.iter().position(|layer| layer[1] > zeta).unwrap_or(layers.len());
            let above = |number: usize| layers.get(number).map_or((1.0, 0.0), off);
            let (from, to) = match next.checked_sub(1) {
                Some(before) => (above(before), above(next)),
                // Extrapolated from the first two to the base.
                None => (above(0), above(1)),
            };
            let share = if to.0 > from.0 { (zeta - from.0) / (to.0 - from.0) } else { 1.0 };
            smooth(zeta) + from.1 + (to.1 - from.1) * share
        };
        let zeta = |k: usize| k as f64 / cells as f64;
        let mut pressure: Vec<f64> = (0..=cells).map(|k| if k < cells { at(zeta(k)) } else { 0.0 }).collect();
        let left = 2.0 * (whole - mean(&pressure));
        for (k, value) in pressure.iter_mut().enumerate() {
            *value += left * (1.0 - zeta(k));
        }
        Self { depth, pressure }
    }
}

/// Coefficients `a` and `b` of `(1 - ζ)(a + b ζ)` by least squares; `b` is zero for a single layer.
fn smooth(layers: &[[f64; 3]]) -> (f64, f64) {
    let [mut aa, mut ab, mut bb, mut ap, mut bp] = [0.0; 5];
    for [volume, zeta, pressure] in layers {
        let rest = 1.0 - zeta;
        let bend = rest * zeta;
        aa += volume * rest * rest;
        ab += volume * rest * bend;
        bb += volume * bend * bend;
        ap += volume * rest * pressure;
        bp += volume * bend * pressure;
    }
    let determinant = aa * bb - ab * ab;
    if layers.len() > 1 && determinant > 1e-9 * aa * bb {
        return ((bb * ap - ab * bp) / determinant, (aa * bp - ab * ap) / determinant);
    }
    (if aa > 0.0 { ap / aa } else { 0.0 }, 0.0)
}

/// Volume, mean height over the depth and mean pressure of layers as thick as the points, `cells` at most.
fn layers(points: &[PointAboveSquare], depth: f64, cells: usize) -> Vec<[f64; 3]> {
    let levels = {
        // As many as there are heights, by their differences: points of one layer have about one height.
        let mut heights: Vec<f64> = points.iter().map(|point| point[1]).collect();
        heights.sort_by(f64::total_cmp);
        let apart = 0.25 * depth / cells as f64;
        1 + heights.windows(2).filter(|pair| pair[1] - pair[0] > apart).count()
    };
    let count = levels.clamp(1, cells);
    let mut sums = vec![[0.0; 3]; count];
    for [volume, height, pressure] in points {
        let zeta = (height / depth).clamp(0.0, 1.0);
        let layer = ((zeta * count as f64) as usize).min(count - 1);
        let own = [*volume, volume * zeta, volume * pressure];
        sums[layer].iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
    }
    let filled = sums.into_iter().filter(|sums| sums[0] > 0.0);
    filled.map(|[volume, zeta, pressure]| [volume, zeta / volume, pressure / volume]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Column of points in this number of layers, 2 m high.
    fn points(layers: usize, pressure: impl Fn(f64) -> f64) -> Vec<PointAboveSquare> {
        let zeta = |k: usize| (k as f64 + 0.5) / layers as f64;
        (0..2 * layers).map(|k| [0.3, 2.0 * zeta(k / 2), pressure(zeta(k / 2))]).collect()
    }

    #[test]
    fn a_linear_pressure_profile_is_transferred_exactly() {
        for layers in [1, 3, 20, 64] {
            let transferred =
                TransferredPressure::from_points(&points(layers, |zeta| 7e3 * (1.0 - zeta)), 20);
            assert!((transferred.depth - 2.0).abs() < 1e-12);
            for (k, value) in transferred.pressure.iter().enumerate() {
                assert!((value - 350.0 * (20 - k) as f64).abs() < 1e-8, "{layers} layers: {k} {value}");
            }
        }
    }

    #[test]
    fn other_profiles_keep_their_mean_and_converge() {
        let parabola = |zeta: f64| 5e3 * (1.0 - zeta * zeta);
        let drained = |zeta: f64| 5e3 * (std::f64::consts::PI * zeta).sin();
        let shapes: [(&dyn Fn(f64) -> f64, f64); 2] = [(&parabola, 40.0), (&drained, 120.0)];
        for (shape, bound) in shapes {
            let error = |layers: usize| {
                let points = points(layers, shape);
                let transferred = TransferredPressure::from_points(&points, 20);
                let whole = points.iter().map(|point| point[2]).sum::<f64>() / points.len() as f64;
                assert!((mean(&transferred.pressure) / whole - 1.0).abs() < 1e-12, "{layers} layers");
                let each = transferred.pressure.iter().enumerate();
                each.map(|(k, value)| (value - shape(k as f64 / 20.0)).abs()).fold(0.0, f64::max)
            };
            let (few, many) = (error(5), error(20));
            assert!(many < bound && many < 0.25 * few, "{few} {many}");
        }
    }

    /// Points at uneven heights, like those of a flow, and one that lies in the bed.
    #[test]
    fn uneven_points_keep_depth_and_mean() {
        let mut all = points(7, |zeta| 4e3 * (1.0 - zeta));
        for (k, point) in all.iter_mut().enumerate() {
            point[1] += 0.03 * (3.0 * k as f64).sin();
        }
        all.push([0.1, -0.01, 4e3]);
        let transferred = TransferredPressure::from_points(&all, 12);
        let volume: f64 = all.iter().map(|point| point[0]).sum();
        let over = |value: usize| all.iter().map(|point| point[0] * point[value]).sum::<f64>() / volume;
        assert!((transferred.depth - 2.0 * over(1)).abs() < 1e-12);
        assert!((mean(&transferred.pressure) / over(2) - 1.0).abs() < 1e-12);
        assert_eq!(*transferred.pressure.last().unwrap(), 0.0);
        assert!((transferred.pressure[0] / 4e3 - 1.0).abs() < 0.06, "{}", transferred.pressure[0]);
    }
}
