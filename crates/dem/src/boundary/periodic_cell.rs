//! Periodic cell, periodic along some of its axes, which may deform (sheet: dem §2.11).

use crate::points::vector::norm;

/// Periodic cell spanned by the columns of the cell matrix `h`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicCell<const D: usize> {
    /// Corner (m).
    pub origin: [f64; D],
    /// Matrix of the cell vectors, which are its columns (m).
    pub h: [[f64; D]; D],
    /// Axes along which the cell is periodic.
    pub periodic: [bool; D],
    /// Velocity gradient of the cell (1/s).
    pub velocity_gradient: [[f64; D]; D],
    /// Mean rates of the stress-controlled entries of `velocity_gradient`, to which dashpots couple them; 0 for other entries (1/s).
    pub mean_velocity_gradient: [[f64; D]; D],
}

/// Product of a matrix with a vector.
#[inline]
pub fn apply<const D: usize>(matrix: &[[f64; D]; D], vector: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|row| crate::points::vector::dot(&matrix[row], vector))
}

/// Product of two matrices.
pub fn product<const D: usize>(a: &[[f64; D]; D], b: &[[f64; D]; D]) -> [[f64; D]; D] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..D).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Inverse and determinant of a matrix.
pub fn inverse<const D: usize>(m: &[[f64; D]; D]) -> ([[f64; D]; D], f64) {
    let mut out = [[0.0; D]; D];
    if D == 2 {
        let det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        (out[0][0], out[0][1]) = (m[1][1] / det, -m[0][1] / det);
        (out[1][0], out[1][1]) = (-m[1][0] / det, m[0][0] / det);
        return (out, det);
    }
    let minor = |i: usize, j: usize| {
        let [a, b] = [(i + 1) % 3, (i + 2) % 3];
        let [c, d] = [(j + 1) % 3, (j + 2) % 3];
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let det = (0..3).map(|j| m[0][j] * minor(0, j)).sum::<f64>();
    for i in 0..D {
        for j in 0..D {
            out[i][j] = minor(j, i) / det;
        }
    }
    (out, det)
}

impl<const D: usize> PeriodicCell<D> {
    /// Creates a box between two corners (m).
    pub fn new(low: [f64; D], high: [f64; D], periodic: [bool; D]) -> Self {
        let mut h = [[0.0; D]; D];
        for c in 0..D {
            h[c][c] = high[c] - low[c];
        }
        Self {
            origin: low,
            h,
            periodic,
            velocity_gradient: [[0.0; D]; D],
            mean_velocity_gradient: [[0.0; D]; D],
        }
    }

    /// Whether the cell is periodic along some axis.
    pub fn is_periodic(&self) -> bool {
        self.periodic.contains(&true)
    }

    /// Whether the cell deforms.
    pub fn is_deforming(&self) -> bool {
        self.velocity_gradient.iter().flatten().any(|rate| *rate != 0.0)
    }

    /// Area or volume (m², m³).
    pub fn volume(&self) -> f64 {
        inverse(&self.h).1
    }

    /// Reduced coordinates along the cell vectors, 0 to 1 within the cell.
    pub fn reduced(&self, inverse: &[[f64; D]; D], x: &[f64; D]) -> [f64; D] {
        apply(inverse, &crate::points::vector::difference(x, &self.origin))
    }

    /// Distances between opposite sides of the cell (m).
    pub fn widths(&self) -> [f64; D] {
        inverse(&self.h).0.map(|row| 1.0 / norm(&row))
    }

    /// Number of images, the cell itself included.
    pub const fn images() -> usize {
        3usize.pow(D as u32)
    }

    /// Lattice steps of the image with index `code`.
    pub fn image_steps(code: u8) -> [i32; D] {
        let mut rest = i32::from(code);
        std::array::from_fn(|_| {
            let step = rest % 3;
            rest /= 3;
            if step == 2 { -1 } else { step }
        })
    }

    /// Index of the periodic image that is displaced by a number of cell vectors.
    pub fn image_index(steps: &[i32; D]) -> u8 {
        steps.iter().rev().fold(0, |code, step| 3 * code + step.rem_euclid(3) as u8)
    }

    /// Shift (m) by lattice steps.
    pub fn shift(&self, steps: &[i32; D]) -> [f64; D] {
        apply(&self.h, &steps.map(f64::from))
    }

    /// Displacements of all periodic images (m), and their velocities relative to the cell (m/s).
    pub fn shifts(&self, out: &mut Vec<([f64; D], [f64; D])>) {
        out.clear();
        out.extend((0..Self::images()).map(|code| {
            let shift = self.shift(&Self::image_steps(code as u8));
            (shift, apply(&self.velocity_gradient, &shift))
        }));
    }

    /// Advances the cell by a step of `dt` (s).
    pub fn advance(&mut self, dt: f64) {
        let change = product(&self.velocity_gradient, &self.h);
        for i in 0..D {
            for j in 0..D {
                self.h[i][j] += dt * change[i][j];
            }
        }
    }

    /// Replaces cell vectors that shear has lengthened by the shortest vectors of the same lattice.
    pub fn reduce(&mut self) {
        for j in 1..D {
            for i in (0..j).rev() {
                if !(self.periodic[i] && self.periodic[j]) {
                    continue;
                }
                let column = |k: usize| -> [f64; D] { std::array::from_fn(|row| self.h[row][k]) };
                let (a, b) = (column(i), column(j));
                let count = (crate::points::vector::dot(&a, &b) / crate::points::vector::dot(&a, &a)).round();
                // With a margin, so that a cell near half a lattice step does not switch back and forth.
                if count != 0.0
                    && (crate::points::vector::dot(&a, &b) / crate::points::vector::dot(&a, &a)).abs() > 0.55
                {
                    for row in 0..D {
                        self.h[row][j] -= count * a[row];
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_of_a_sheared_cell_are_those_of_lees_and_edwards() {
        // Sheet: dem §2.11. Shear of 3.7 in a cell of 2 m × 1 m: images above are 3.7 mod 2 m ahead, and 3 m/s faster.
        let (wide, high, rate) = (2.0, 1.0, 3.0);
        let mut cell = PeriodicCell::new([0.0; 2], [wide, high], [true; 2]);
        cell.velocity_gradient[0][1] = rate;
        cell.h[0][1] = 3.7;
        cell.reduce();
        let ahead = 3.7f64.rem_euclid(wide);
        let (unit, _) = inverse(&cell.h);
        for k in 0..200 {
            let [x, y] =
                [0.754_877_666, 0.569_840_291].map(|f: f64| 0.6 * ((f64::from(k) * f).fract() - 0.5));
            for (up, along) in [(0.0, 0.0), (1.0, 0.0), (-1.0, 1.0), (2.0, -3.0)] {
                // The pair once more, written with an image of the second grain.
                let apart = [x + up * 3.7 + along * wide, y + up * high];
                let s = apply(&unit, &apart);
                let steps = s.map(f64::round);
                let near = apply(&cell.h, &[s[0] - steps[0], s[1] - steps[1]]);
                let rows = (apart[1] / high).round();
                let mut exact = [apart[0] - rows * ahead, apart[1] - rows * high];
                exact[0] -= wide * (exact[0] / wide).round();
                assert!(
                    (near[0] - exact[0]).abs() + (near[1] - exact[1]).abs() < 1e-12,
                    "{near:?} {exact:?}"
                );
                let jump = apply(&cell.velocity_gradient, &apply(&cell.h, &steps));
                assert!((jump[0] - rows * rate * high).abs() < 1e-12 && jump[1] == 0.0);
            }
        }
    }

    #[test]
    fn image_indices_are_invertible_and_cell_shear_is_reduced() {
        for code in 0..27 {
            assert_eq!(PeriodicCell::<3>::image_index(&PeriodicCell::<3>::image_steps(code)), code);
        }
        let mut cell = PeriodicCell::new([0.0; 2], [2.0, 1.0], [true; 2]);
        cell.h[0][1] = 1.3;
        let volume = cell.volume();
        cell.reduce();
        assert!((cell.h[0][1] + 0.7).abs() < 1e-15 && (cell.volume() - volume).abs() < 1e-15);
        let h = [[2.0, 0.3, 0.1], [0.0, 1.5, -0.2], [0.1, 0.0, 1.0]];
        let unit = product(&h, &inverse(&h).0);
        for (i, row) in unit.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }
}
