//! Gauss–Legendre points in the cells of a grid.

use super::{CandidateCells, Sample, SamplingError};
use crate::Shape;

/// Samples a shape with `per_cell` Gauss–Legendre points per direction in every cell of a grid with lower corner `origin` (m) and cell edge
/// `cell` (m). Only points in the shape are kept. The volume of a point is its Gauss weight, so that sums over whole cells integrate
/// polynomials of degree `2 per_cell - 1` along each axis exactly. A cell that the shape cuts keeps the points inside; its sum is then a
/// count only.
///
/// # Errors
/// When there would be more than 2²⁸ candidates, or the cell is not a length.
pub fn gauss_per_cell<const D: usize>(
    shape: &Shape,
    origin: [f64; D],
    cell: f64,
    per_cell: usize,
) -> Result<Vec<Sample<D>>, SamplingError> {
    let rule = gauss_legendre(per_cell);
    let in_cell = per_cell.pow(D as u32);
    let mut samples = Vec::new();
    for index in CandidateCells::around_shape(shape, origin, cell, in_cell as f64)?.indices() {
        for number in 0..in_cell {
            let mut rest = number;
            let mut sample = Sample { position: [0.0; D], volume: 1.0 };
            for axis in (0..D).rev() {
                let (abscissa, weight) = rule[rest % per_cell];
                sample.position[axis] = origin[axis] + (index[axis] as f64 + abscissa) * cell;
                sample.volume *= weight * cell;
                rest /= per_cell;
            }
            if shape.contains(&sample.position) {
                samples.push(sample);
            }
        }
    }
    Ok(samples)
}

/// Abscissae and weights of the Gauss–Legendre rule on 0..1, ascending.
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let zero = |k: usize| {
        let mut x = (std::f64::consts::PI * ((count - k) as f64 - 0.25) / (n + 0.5)).cos();
        let mut slope = 1.0;
        // Newton's method converges quadratically; from Tricomi's estimate eight steps suffice for any degree.
        for _ in 0..8 {
            let (mut before, mut here) = (1.0, x);
            for degree in 2..=count {
                let j = degree as f64;
                (before, here) = (here, ((2.0 * j - 1.0) * x * here - (j - 1.0) * before) / j);
            }
            slope = n * (before - x * here) / (1.0 - x * x);
            x -= here / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(zero).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rules_of_two_and_three_points_are_those_of_the_tables() {
        let close = |a: f64, b: f64| (a - b).abs() < 1e-15;
        let two = gauss_legendre(2);
        assert!(close(two[0].0, 0.5 - 0.5 / 3f64.sqrt()) && close(two[1].1, 0.5));
        let three = gauss_legendre(3);
        assert!(close(three[0].0, 0.5 - 0.5 * 0.6f64.sqrt()) && close(three[0].1, 5.0 / 18.0));
        assert!(close(three[1].0, 0.5) && close(three[1].1, 8.0 / 18.0));
        assert_eq!(gauss_legendre(1).len(), 1);
    }

    #[test]
    fn polynomials_of_degree_2n_minus_1_are_integrated_exactly() {
        fn integrates<const D: usize>(count: usize) {
            let (min, max) = (vec![-0.5; D], vec![1.0; D]);
            let samples = gauss_per_cell::<D>(&Shape::Box { min, max }, [0.0; D], 0.25, count).unwrap();
            assert_eq!(samples.len(), (6 * count).pow(D as u32));
            for power in 0..2 * count as i32 {
                let sum: f64 = samples
                    .iter()
                    .map(|s| s.volume * s.position.iter().map(|x| x.powi(power)).product::<f64>())
                    .sum();
                let line = (1.0 - (-0.5f64).powi(power + 1)) / f64::from(power + 1);
                let exact = line.powi(D as i32);
                assert!(
                    (sum - exact).abs() < 1e-13,
                    "{D}D, {count} points, degree {power}: {sum} for {exact}"
                );
            }
        }
        for count in 1..=6 {
            integrates::<1>(count);
            integrates::<2>(count);
        }
        integrates::<3>(2);
        integrates::<3>(3);
        integrates::<1>(20);
    }

    #[test]
    fn only_points_in_the_shape_are_kept() {
        let disk = Shape::Ball { centre: vec![0.0, 0.0], radius: 1.0 };
        let samples = gauss_per_cell(&disk, [0.05, 0.0], 0.02, 2).unwrap();
        assert!(samples.iter().all(|s| disk.contains(&s.position)));
        let area: f64 = samples.iter().map(|s| s.volume).sum();
        // At most half of the points of a cut cell are wrong: the boundary takes a hundredth of a cell's edge per cell.
        assert!((area - std::f64::consts::PI).abs() < 5e-3, "{area}");
        assert!(matches!(gauss_per_cell(&disk, [0.0; 2], 1e-4, 3), Err(SamplingError::TooMany(_))));
        assert!(matches!(gauss_per_cell(&disk, [0.0; 2], 0.0, 3), Err(SamplingError::Spacing(_))));
    }
}
