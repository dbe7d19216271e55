//! Gradients and Laplacians of a field known on particles (sheet: sph §2.3, §2.4).
//!
//! ```
//! use colluvium_points::NeighbourList;
//! use colluvium_sph::kernel::{Kernel, Smoothing};
//! use colluvium_sph::pairs::operators::{ParticleCloud, Gradient, test_lattice};
//!
//! let lattice = test_lattice::<2>(10, 3, 0.2);
//! let smoothing = Smoothing::new(Kernel::CubicSpline, 1.3 * lattice.spacing)?;
//! let mut neighbours = NeighbourList::new();
//! neighbours.build(&lattice.positions, smoothing.radius())?;
//! let volume = vec![lattice.spacing.powi(2); lattice.positions.len()];
//! let cloud = ParticleCloud::new(&lattice.positions, &volume, &neighbours, &smoothing);
//!
//! let field: Vec<f64> = lattice.positions.iter().map(|x| 3.0 * x[0] - x[1]).collect();
//! let slope = cloud.gradient(Gradient::Corrected, &field, lattice.inner[7]);
//! assert!((slope[0] - 3.0).abs() < 1e-12 && (slope[1] + 1.0).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use colluvium_points::NeighbourList;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::kernel::Smoothing;

/// Smallest determinant of a moment matrix over that of an isotropic one with equal trace, below which a particle has too few neighbours
/// for a correction (sheet: sph §2.3).
pub const MIN_DETERMINANT_RATIO: f64 = 1e-3;

/// Discrete gradient operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Gradient {
    /// Plain gradient `Σ V_j f_j ∇W` (BN 15).
    Plain,
    /// Difference gradient `Σ V_j (f_j - f_i) ∇W` (BN 20): exact for constants.
    Difference,
    /// Corrected gradient `M⁻¹ Σ V_j (f_j - f_i) ∇W` (BN 21): exact for linear fields on any arrangement.
    Corrected,
    /// Difference gradient with densities, `Σ m_j (f_j - f_i) ∇W / ρ_i` (BN 22).
    DensityDifference,
    /// Symmetric gradient `ρ_i Σ m_j (f_i / ρ_i² + f_j / ρ_j²) ∇W` (BN 23): pairwise antisymmetric.
    SymmetricRho2,
    /// Symmetric gradient `Σ V_j (f_i + f_j) ∇W` (BN 24): pairwise antisymmetric.
    SymmetricSum,
}

/// Discrete Laplacian operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Laplacian {
    /// Second derivative of the kernel, `Σ V_j (f_j - f_i) ∇²W` (BN 25): sensitive to disorder.
    SecondDerivative,
    /// Brookshaw's Laplacian `2 Σ V_j (f_j - f_i) F` (BN 31).
    Brookshaw,
    /// Laplacian of Bui and Nguyen (BN 39): exact for linear fields on any arrangement.
    BuiNguyen,
    /// Corrected second derivatives by inversion: exact for quadratic fields on any arrangement.
    Csph2,
}

/// Mean of two diffusivities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DiffusivityMean {
    /// Harmonic mean `2 k_i k_j / (k_i + k_j)`.
    Harmonic,
    /// Arithmetic mean `(k_i + k_j) / 2`.
    Arithmetic,
}

/// Particles with their neighbours and kernel, for discrete operators.
#[derive(Clone, Copy, Debug)]
pub struct ParticleCloud<'a, const D: usize> {
    positions: &'a [[f64; D]],
    volumes: &'a [f64],
    densities: Option<&'a [f64]>,
    neighbours: &'a NeighbourList<D>,
    smoothing: &'a Smoothing<D>,
}

impl<'a, const D: usize> ParticleCloud<'a, D> {
    /// Cloud of particles with volumes (m^d), whose neighbours are within the kernel radius.
    pub fn new(
        positions: &'a [[f64; D]],
        volumes: &'a [f64],
        neighbours: &'a NeighbourList<D>,
        smoothing: &'a Smoothing<D>,
    ) -> Self {
        Self { positions, volumes, densities: None, neighbours, smoothing }
    }

    /// Adds densities (kg/m³) for density-weighted operators; without them they are one.
    #[must_use]
    pub fn with_densities(self, densities: &'a [f64]) -> Self {
        Self { densities: Some(densities), ..self }
    }

    /// Density of a particle (kg/m³); 1 without densities.
    fn density(&self, i: usize) -> f64 {
        self.densities.map_or(1.0, |densities| densities[i])
    }

    /// Volume, distance vector `x_j - x_i` and `r` of every neighbour.
    fn for_each_neighbour(&self, i: usize) -> impl Iterator<Item = (usize, f64, [f64; D], f64)> {
        let x = self.positions[i];
        self.neighbours.neighbours(i).iter().map(move |&j| {
            let j = j as usize;
            let apart: [f64; D] = std::array::from_fn(|c| self.positions[j][c] - x[c]);
            (j, self.volumes[j], apart, apart.iter().map(|c| c * c).sum::<f64>().sqrt())
        })
    }

    /// `Σ V_j f_j W` (BN 4), the particle itself included. Of the density it is `Σ m_j W` (BN 2), which replaces the top
    /// hat, the mass within a sphere over its volume (BN 1), by a smooth weight:
    ///
    /// ```
    /// use colluvium_points::NeighbourList;
    /// use colluvium_sph::kernel::{Kernel, Smoothing};
    /// use colluvium_sph::pairs::operators::{ParticleCloud, test_lattice};
    ///
    /// let lattice = test_lattice::<2>(9, 20, 0.0);
    /// let (x, centre) = (&lattice.positions, lattice.inner[40]);
    /// let mass = 1000.0 * lattice.spacing.powi(2);
    ///
    /// let radius = 20.5 * lattice.spacing;
    /// let inside = x.iter().filter(|y| (y[0] - x[centre][0]).hypot(y[1] - x[centre][1]) < radius);
    /// let top_hat = inside.map(|_| mass).sum::<f64>() / (std::f64::consts::PI * radius.powi(2));
    /// assert!((top_hat - 1000.0).abs() < 10.0);
    ///
    /// let smoothing = Smoothing::new(Kernel::CubicSpline, 1.2 * lattice.spacing)?;
    /// let mut neighbours = NeighbourList::new();
    /// neighbours.build(x, smoothing.radius())?;
    /// let volume = vec![lattice.spacing.powi(2); x.len()];
    /// let density = vec![1000.0; x.len()];
    /// let summed = ParticleCloud::new(x, &volume, &neighbours, &smoothing).interpolate(&density, centre);
    /// assert!((summed - 1000.0).abs() < 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn interpolate(&self, field: &[f64], i: usize) -> f64 {
        let own = self.volumes[i] * field[i] * self.smoothing.value(0.0);
        own + self
            .for_each_neighbour(i)
            .map(|(j, v, _, r)| v * field[j] * self.smoothing.value(r))
            .sum::<f64>()
    }

    /// Gradient moment matrix of a particle, by the sum over its neighbours.
    fn moments(&self, i: usize) -> GradientMoment<D> {
        let mut moment = GradientMoment::default();
        self.for_each_neighbour(i)
            .for_each(|(_, v, x, r)| moment.add(v * self.smoothing.gradient_factor(r), &x));
        moment
    }

    /// Gradient moment `M = Σ V_j (x_j - x_i) ⊗ ∇W`, symmetric; the unit matrix in a full regular support.
    pub fn moment(&self, i: usize) -> [[f64; D]; D] {
        self.moments(i).matrix
    }

    /// Sum `Σ V_j ∇W` (1/m), zero in a full regular support and along the inward normal at a surface.
    pub fn asymmetry(&self, i: usize) -> [f64; D] {
        let mut sum = [0.0; D];
        for (_, v, x, r) in self.for_each_neighbour(i) {
            let weight = v * self.smoothing.gradient_factor(r);
            for c in 0..D {
                sum[c] += weight * x[c];
            }
        }
        sum
    }

    /// Correction matrix `L = M⁻¹`; `None` where the particle has too few neighbours.
    pub fn correction(&self, i: usize) -> Option<[[f64; D]; D]> {
        self.moments(i).correction()
    }

    /// Gradient of `field` at particle `i`; `Corrected` falls back to `Difference` where no correction exists.
    pub fn gradient(&self, operator: Gradient, field: &[f64], i: usize) -> [f64; D] {
        let (own, density) = (field[i], self.density(i));
        let mut sum = [0.0; D];
        for (j, v, x, r) in self.for_each_neighbour(i) {
            let other = field[j];
            let ratio = self.density(j) / density;
            let value = match operator {
                Gradient::Plain => other,
                Gradient::Difference | Gradient::Corrected => other - own,
                Gradient::DensityDifference => ratio * (other - own),
                Gradient::SymmetricRho2 => ratio * own + other / ratio,
                Gradient::SymmetricSum => own + other,
            };
            let weight = v * value * self.smoothing.gradient_factor(r);
            for c in 0..D {
                sum[c] += weight * x[c];
            }
        }
        match operator {
            Gradient::Corrected => self.correction(i).map_or(sum, |l| product(&l, &sum)),
            _ => sum,
        }
    }

    /// Laplacian of `field` at particle `i`. With too few neighbours `Csph2` is replaced by `BuiNguyen`, which is zero without neighbours.
    pub fn laplacian(&self, operator: Laplacian, field: &[f64], i: usize) -> f64 {
        let sum = |weight: &dyn Fn(f64) -> f64| -> f64 {
            self.for_each_neighbour(i).map(|(j, v, _, r)| v * (field[j] - field[i]) * weight(r)).sum()
        };
        match operator {
            Laplacian::SecondDerivative => sum(&|r| self.smoothing.laplacian(r)),
            Laplacian::Brookshaw => 2.0 * sum(&|r| self.smoothing.gradient_factor(r)),
            Laplacian::BuiNguyen => {
                let gradient = self.gradient(Gradient::Corrected, field, i);
                let moment = self.moment(i);
                // K = tr M / d: sheet: sph K07.
                let trace = (0..D).map(|c| moment[c][c]).sum::<f64>() / D as f64;
                if trace == 0.0 {
                    return 0.0;
                }
                let slope: f64 = gradient.iter().zip(self.asymmetry(i)).map(|(g, b)| g * b).sum();
                2.0 / trace * (sum(&|r| self.smoothing.gradient_factor(r)) - slope)
            }
            Laplacian::Csph2 => {
                self.csph2(field, i).unwrap_or_else(|| self.laplacian(Laplacian::BuiNguyen, field, i))
            }
        }
    }

    /// Diffusion `∇·(k ∇f)` by `2 Σ V_j k_ij (f_j - f_i) F`.
    pub fn diffusion(&self, mean: DiffusivityMean, diffusivity: &[f64], field: &[f64], i: usize) -> f64 {
        let own = diffusivity[i];
        let term = |(j, v, _, r): (usize, f64, [f64; D], f64)| {
            let other = diffusivity[j];
            let k = match mean {
                DiffusivityMean::Harmonic if own + other == 0.0 => 0.0,
                DiffusivityMean::Harmonic => 2.0 * own * other / (own + other),
                DiffusivityMean::Arithmetic => 0.5 * (own + other),
            };
            v * k * (field[j] - field[i]) * self.smoothing.gradient_factor(r)
        };
        2.0 * self.for_each_neighbour(i).map(term).sum::<f64>()
    }

    /// Gradient and second derivatives from a common linear system; `None` if it is singular. Lengths are relative to the smoothing length,
    /// so that its rows have the same magnitude.
    fn csph2(&self, field: &[f64], i: usize) -> Option<f64> {
        let size = D + D * (D + 1) / 2;
        if self.neighbours.neighbours(i).len() < size {
            return None;
        }
        let scale = 1.0 / self.smoothing.length();
        let mut system = [[0.0; 10]; 9];
        for (j, v, x, r) in self.for_each_neighbour(i) {
            let weight = v * self.smoothing.gradient_factor(r);
            let x = x.map(|c| c * scale);
            let mut basis = [0.0; 9];
            let mut tests = [0.0; 9];
            basis[..D].copy_from_slice(&x);
            tests[..D].copy_from_slice(&x);
            let mut k = D;
            for a in 0..D {
                for b in a..D {
                    tests[k] = x[a] * x[b];
                    basis[k] = if a == b { 0.5 } else { 1.0 } * tests[k];
                    k += 1;
                }
            }
            for row in 0..size {
                for column in 0..size {
                    system[row][column] += weight * tests[row] * basis[column];
                }
                system[row][9] += weight * tests[row] * (field[j] - field[i]);
            }
        }
        let solution = solve(&mut system, size)?;
        let mut k = D;
        let mut trace = 0.0;
        for a in 0..D {
            trace += solution[k];
            k += D - a;
        }
        Some(trace * scale * scale)
    }
}

/// Solves a linear system by Gaussian elimination with row pivoting; column 9 is the right-hand side.
fn solve(system: &mut [[f64; 10]; 9], size: usize) -> Option<[f64; 9]> {
    let largest = (0..size).map(|k| system[k][k].abs()).fold(0.0, f64::max);
    for column in 0..size {
        let pivot =
            (column..size).max_by(|&a, &b| system[a][column].abs().total_cmp(&system[b][column].abs()))?;
        if !(system[pivot][column].abs() > 1e-10 * largest) {
            return None;
        }
        system.swap(column, pivot);
        for row in column + 1..size {
            let factor = system[row][column] / system[column][column];
            for k in (column..size).chain([9]) {
                system[row][k] -= factor * system[column][k];
            }
        }
    }
    let mut solution = [0.0; 9];
    for row in (0..size).rev() {
        let known: f64 = (row + 1..size).map(|k| system[row][k] * solution[k]).sum();
        solution[row] = (system[row][9] - known) / system[row][row];
    }
    Some(solution)
}

/// Product of a matrix and a vector.
#[inline]
pub(crate) fn product<const D: usize>(matrix: &[[f64; D]; D], vector: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|a| (0..D).map(|b| matrix[a][b] * vector[b]).sum())
}

/// Gradient moment of a particle, `M = Σ V_j F x ⊗ x`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GradientMoment<const D: usize> {
    /// Sum of the moment.
    pub matrix: [[f64; D]; D],
    /// Number of neighbours with a weight.
    pub neighbours: u32,
}

impl<const D: usize> Default for GradientMoment<D> {
    fn default() -> Self {
        Self { matrix: [[0.0; D]; D], neighbours: 0 }
    }
}

impl<const D: usize> GradientMoment<D> {
    /// Adds a neighbour with weight `V F` at the distance vector `apart` (m).
    #[inline]
    pub fn add(&mut self, weight: f64, apart: &[f64; D]) {
        self.neighbours += u32::from(weight > 0.0);
        for a in 0..D {
            for b in 0..D {
                self.matrix[a][b] += weight * apart[a] * apart[b];
            }
        }
    }

    /// Trace `tr M`, which decreases at free surfaces (sheet: sph §2.13 h).
    pub fn trace(&self) -> f64 {
        (0..D).map(|c| self.matrix[c][c]).sum()
    }

    /// Rate of rotation `Ω` that best fits the relative velocities of the neighbours (1/s). It minimises `Σ V F |v - Ω x|²`, from the sums
    /// `gradient = Σ V F v ⊗ x`, by the angular velocity `ω = (tr M - M)⁻¹ Σ V F x × v`. `None` in one dimension, and in space where
    /// neighbours are collinear: the rotation about that line is not determined.
    #[inline]
    pub fn rotation(&self, gradient: &[[f64; D]; D]) -> Option<[[f64; D]; D]> {
        let trace = self.trace();
        let mut spin = [[0.0; D]; D];
        let mut set = |a: usize, b: usize, rate: f64| {
            spin[a][b] = rate;
            spin[b][a] = -rate;
        };
        if D == 2 && trace > 0.0 {
            set(1, 0, (gradient[1][0] - gradient[0][1]) / trace);
            return Some(spin);
        }
        if D < 3 {
            return None;
        }
        let axes = [(1, 2), (2, 0), (0, 1)];
        let moment = axes.map(|(a, b)| gradient[b][a] - gradient[a][b]);
        let inertia = GradientMoment::<3> {
            matrix: std::array::from_fn(|a| {
                std::array::from_fn(|b| f64::from(u8::from(a == b)) * trace - self.matrix[a][b])
            }),
            neighbours: self.neighbours,
        };
        let rate = product(&inertia.correction()?, &moment);
        axes.iter().zip(rate).for_each(|((a, b), rate)| set(*b, *a, rate));
        Some(spin)
    }

    /// Correction matrix `L = M⁻¹` in closed form (sheet: sph §2.3). `None` with fewer than `D + 1` neighbours, or if the determinant is
    /// below [`MIN_DETERMINANT_RATIO`] of that of an isotropic moment.
    #[inline]
    pub fn correction(&self) -> Option<[[f64; D]; D]> {
        let m = |a: usize, b: usize| self.matrix[a][b];
        let trace = self.trace() / D as f64;
        // Cofactors; the matrix is symmetric.
        let (determinant, cofactor): (f64, [[f64; D]; D]) = match D {
            1 => (m(0, 0), [[1.0; D]; D]),
            2 => {
                let rows = std::array::from_fn(|a| {
                    std::array::from_fn(|b| if a == b { m(1 - a, 1 - a) } else { -m(a, b) })
                });
                (m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0), rows)
            }
            _ => {
                let minor = |a: usize, b: usize| {
                    let (i, k) = ((a + 1) % 3, (a + 2) % 3);
                    let (j, l) = ((b + 1) % 3, (b + 2) % 3);
                    m(i, j) * m(k, l) - m(i, l) * m(k, j)
                };
                let rows = std::array::from_fn(|a| std::array::from_fn(|b| minor(a, b)));
                (m(0, 0) * minor(0, 0) + m(0, 1) * minor(0, 1) + m(0, 2) * minor(0, 2), rows)
            }
        };
        let enough = self.neighbours as usize > D;
        let sound =
            enough && determinant > MIN_DETERMINANT_RATIO * trace.powi(D as i32) && determinant.is_finite();
        sound.then(|| cofactor.map(|row| row.map(|c| c / determinant)))
    }
}

/// Particle positions and volumes for the studies in `sheet: sph §5.1`.
#[derive(Clone, Debug)]
pub struct TestLattice<const D: usize> {
    /// All particles, x fastest (m).
    pub positions: Vec<[f64; D]>,
    /// Indices of particles within the unit square (cube).
    pub inner: Vec<usize>,
    /// Spacing (m).
    pub spacing: f64,
}

/// Particles at the `n^D` cell centres of the unit square or cube, with `layers` more on each side. Each is displaced by up to `disorder`
/// spacings along each axis.
pub fn test_lattice<const D: usize>(n: usize, layers: usize, disorder: f64) -> TestLattice<D> {
    // Additive recurrences of the sheet; the third is the next of the same family.
    /// Fractional parts of a quasi-random sequence that disturbs the lattice.
    const STEPS: [f64; 3] = [0.618_033_988_749_894_9, 0.754_877_666_246_692_7, 0.819_172_513_396_164_4];
    let (spacing, width) = (1.0 / n as f64, n + 2 * layers);
    let mut lattice = TestLattice { positions: Vec::new(), inner: Vec::new(), spacing };
    for number in 0..width.pow(D as u32) {
        let cell: [usize; D] = std::array::from_fn(|c| number / width.pow(c as u32) % width);
        if cell.iter().all(|c| (layers..layers + n).contains(c)) {
            lattice.inner.push(number);
        }
        let place = |c: usize| {
            let regular = cell[c] as f64 - layers as f64 + 0.5;
            let random = ((number + 1) as f64 * STEPS[c]).fract();
            spacing * (regular + disorder * (2.0 * random - 1.0))
        };
        lattice.positions.push(std::array::from_fn(place));
    }
    lattice
}
