//! Total-Lagrangian SPH of solids (sheet: sph §2.14): pairs and corrected kernel gradients of the reference
//! configuration throughout. Free of tensile instability; bodies that are neighbours there stay bonded.
//!
//! `F_i = Σ V⁰_j (x_j - x_i) ⊗ L⁰_i ∇⁰W`, `a_i = Σ V⁰_j (P_i L⁰_i + P_j L⁰_j) ∇⁰W / ρ⁰_i`, `P = σ cof F`.
//! After Vignjevic et al. (2006) and Ganzenmüller (2015).

use colluvium_case::CaseError;
use colluvium_case::loads::load_vectors::cofactor;
use colluvium_points::{NeighbourList, SearchError};
use rayon::prelude::*;

use crate::SphOptions;
use crate::kernel::Smoothing;
use crate::pairs::operators::GradientMoment;
use crate::points::particles::{Derivatives, MIN_PARTICLES_PER_TASK, Particles, SquareMatrix};

/// Softening of the viscosity for coincident particles, that of the pair sums (sheet: sph §2.8).
const SOFTENING: f64 = 0.01;

/// Initial configuration with its constant pairs and corrected gradients.
struct InitialConfiguration<const D: usize> {
    neighbours: NeighbourList<D>,
    smoothing: Smoothing<D>,
    /// Positions (m).
    position: Vec<[f64; D]>,
    /// Volumes (m^d).
    volume: Vec<f64>,
    /// Correction `L⁰`; zero where a particle has too few neighbours.
    correction: Vec<SquareMatrix<D>>,
}

/// Reference configuration and the tensors of its sums.
pub struct TotalLagrangianReference<const D: usize> {
    initial: InitialConfiguration<D>,
    /// Deformation gradient `F` at the start of the step.
    deformation: Vec<SquareMatrix<D>>,
    /// Corrected nominal stress `P L⁰` at the start of the step (Pa).
    nominal: Vec<SquareMatrix<D>>,
}

/// Matrix product `a b`.
fn matmul<const D: usize>(a: &SquareMatrix<D>, b: &SquareMatrix<D>) -> SquareMatrix<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..D).map(|k| a[i][k] * b[k][j]).sum()))
}

impl<const D: usize> InitialConfiguration<D> {
    /// Neighbours of `i` with `V⁰_j ∇⁰W`.
    fn for_each_neighbour(&self, i: usize) -> impl Iterator<Item = (usize, [f64; D])> {
        self.neighbours.neighbours(i).iter().map(move |&j| {
            let j = j as usize;
            let apart: [f64; D] = std::array::from_fn(|c| self.position[j][c] - self.position[i][c]);
            let weight = self.volume[j]
                * self.smoothing.gradient_factor(apart.iter().map(|c| c * c).sum::<f64>().sqrt());
            (j, apart.map(|c| c * weight))
        })
    }

    /// Uncorrected gradient `Σ V⁰_j f_j ⊗ ∇⁰W`.
    fn gradient(&self, i: usize, field: impl Fn(usize, usize) -> f64) -> SquareMatrix<D> {
        let mut sum = [[0.0; D]; D];
        for (j, weight) in self.for_each_neighbour(i) {
            for (c, row) in sum.iter_mut().enumerate() {
                let value = field(j, c);
                (0..D).for_each(|b| row[b] += value * weight[b]);
            }
        }
        sum
    }
}

impl<const D: usize> TotalLagrangianReference<D> {
    /// Returns the reference configuration of the particles at their present positions.
    ///
    /// # Errors
    /// When the neighbour search fails.
    pub fn new(particles: &Particles<D>, smoothing: &Smoothing<D>) -> Result<Self, SearchError> {
        let position = particles.position[..particles.len()].to_vec();
        let mut neighbours = NeighbourList::new();
        neighbours.build(&position, smoothing.radius())?;
        let volume: Vec<f64> = particles.mass.iter().zip(&particles.density).map(|(m, d)| m / d).collect();
        let unit: SquareMatrix<D> =
            std::array::from_fn(|a| std::array::from_fn(|b| f64::from(u8::from(a == b))));
        let count = position.len();
        let correction = vec![unit; count];
        let mut initial =
            InitialConfiguration { neighbours, smoothing: *smoothing, correction, volume, position };
        for i in 0..count {
            let moment = GradientMoment {
                matrix: initial.gradient(i, |j, c| initial.position[j][c] - initial.position[i][c]),
                neighbours: initial.for_each_neighbour(i).filter(|(_, weight)| *weight != [0.0; D]).count()
                    as u32,
            };
            // Without neighbours on all sides a particle moves without deformation.
            initial.correction[i] = moment.correction().unwrap_or([[0.0; D]; D]);
        }
        let (deformation, nominal) = (vec![unit; count], vec![[[0.0; D]; D]; count]);
        Ok(Self { initial, deformation, nominal })
    }

    /// Updates `F` and `P L⁰` of the state.
    fn update_nominal_stress(&mut self, p: &Particles<D>) {
        let Self { initial, deformation, nominal } = self;
        let all = deformation.par_iter_mut().zip(nominal).enumerate();
        all.with_min_len(MIN_PARTICLES_PER_TASK).for_each(|(i, (deformation, nominal))| {
            let sum = initial.gradient(i, |j, c| p.position[j][c] - p.position[i][c]);
            if initial.correction[i] != [[0.0; D]; D] {
                *deformation = matmul(&sum, &initial.correction[i]);
            }
            let stress = matmul(
                &std::array::from_fn(|a| std::array::from_fn(|b| p.stress[i].component(a, b))),
                &cofactor(deformation),
            );
            *nominal = matmul(&stress, &initial.correction[i]);
        });
    }

    /// Acceleration of particle `i` by its neighbours (m/s²), with artificial viscosity `(α, β)` along current distance vectors.
    fn acceleration(&self, p: &Particles<D>, i: usize, (linear, quadratic): (f64, f64)) -> [f64; D] {
        let h = self.initial.smoothing.length();
        let density = p.mass[i] / self.initial.volume[i];
        let mut sum = [0.0; D];
        for (j, weight) in self.initial.for_each_neighbour(i) {
            let pair: SquareMatrix<D> = std::array::from_fn(|a| {
                std::array::from_fn(|b| self.nominal[i][a][b] + self.nominal[j][a][b])
            });
            let apart: [f64; D] = std::array::from_fn(|c| p.position[j][c] - p.position[i][c]);
            let closing: f64 = (0..D).map(|c| (p.velocity[j][c] - p.velocity[i][c]) * apart[c]).sum();
            let square: f64 = apart.iter().map(|c| c * c).sum();
            let pi = h * closing.min(0.0) / (square + SOFTENING * h * h);
            let sound = 0.5 * (p.sound[i] + p.sound[j]);
            let mean = 0.5 * (density + p.mass[j] / self.initial.volume[j]);
            let stress = mean * (linear * sound * pi - quadratic * pi * pi);
            let size = (weight.iter().map(|c| c * c).sum::<f64>() / square.max(1e-24 * h * h)).sqrt();
            for a in 0..D {
                let acceleration: f64 = (0..D).map(|b| pair[a][b] * weight[b]).sum();
                sum[a] += (acceleration + stress * size * apart[a]) / density;
            }
        }
        sum
    }

    /// Velocity gradient over the present positions (1/s).
    fn rate(&self, p: &Particles<D>, i: usize) -> SquareMatrix<D> {
        let sum = self.initial.gradient(i, |j, c| p.velocity[j][c] - p.velocity[i][c]);
        let rate = matmul(&sum, &self.initial.correction[i]);
        let cofactor = cofactor(&self.deformation[i]);
        let determinant: f64 = (0..D).map(|c| self.deformation[i][0][c] * cofactor[0][c]).sum();
        // F⁻¹ = cofᵀ / det.
        let inverse: SquareMatrix<D> =
            std::array::from_fn(|a| std::array::from_fn(|b| cofactor[b][a] / determinant));
        matmul(&rate, &inverse)
    }
}

impl<const D: usize> TotalLagrangianReference<D> {
    /// Computes the accelerations over the reference configuration, under `gravity`.
    pub fn accelerate(
        &mut self,
        options: &SphOptions,
        particles: &Particles<D>,
        gravity: &[f64; D],
        accelerations: &mut Vec<[f64; D]>,
    ) {
        let viscosity = (options.viscosity_linear, options.viscosity_quadratic);
        self.update_nominal_stress(particles);
        accelerations.resize(particles.len(), [0.0; D]);
        accelerations.par_iter_mut().enumerate().with_min_len(MIN_PARTICLES_PER_TASK).for_each(|(i, a)| {
            let acceleration = self.acceleration(particles, i, viscosity);
            *a = std::array::from_fn(|c| acceleration[c] + gravity[c]);
        });
    }

    /// Computes velocity gradients and divergences.
    pub fn find_rates(&self, particles: &Particles<D>, rates: &mut Derivatives<D>) {
        let all = rates.gradient.par_iter_mut().enumerate();
        all.with_min_len(MIN_PARTICLES_PER_TASK).for_each(|(i, l)| *l = self.rate(particles, i));
        for (divergence, l) in rates.divergence.iter_mut().zip(&rates.gradient) {
            *divergence = (0..D).map(|c| l[c][c]).sum();
        }
    }
}

/// Rejects options that have no meaning in a reference configuration.
///
/// # Errors
/// The first such option, by its path.
pub fn check_supported(options: &SphOptions) -> Result<(), CaseError> {
    use crate::config::{
        ContinuityEquation, DensityReset, MomentumEquation, Regularisation, Symmetrisation, Tensile,
        TimeIntegration, VelocityGradientOperator,
    };
    let rule = |holds: bool, path: &str, problem: &str| {
        if holds {
            Ok(())
        } else {
            Err(CaseError::new(path, format!("{problem}, in the total-Lagrangian form")))
        }
    };
    let of = |name: &str| format!("methods.sph.{name}");
    rule(options.integration == TimeIntegration::Leapfrog, &of("integration"), "only leapfrog is available")?;
    rule(options.tensile == Tensile::None, &of("tensile"), "there is no tensile instability")?;
    rule(options.regularisation == Regularisation::None, &of("regularisation"), "stress is not smoothed")?;
    // Both are corrected and adjoint by construction.
    let momentum = matches!(options.momentum, MomentumEquation::Rho2 | MomentumEquation::Corrected);
    rule(momentum, &of("momentum"), "the momentum equation is corrected")?;
    let gradient = matches!(
        options.velocity_gradient,
        VelocityGradientOperator::Compatible | VelocityGradientOperator::Corrected
    );
    rule(gradient, &of("velocity_gradient"), "the velocity gradient is corrected")?;
    rule(
        options.continuity == ContinuityEquation::Trace,
        &of("continuity"),
        "density follows the deformation",
    )?;
    rule(
        options.density_reset == DensityReset::None,
        &of("density_reset"),
        "density follows the deformation",
    )?;
    let symmetrisation = options.symmetrisation == Symmetrisation::Arithmetic;
    rule(symmetrisation, &of("symmetrisation"), "the smoothing length is fixed")?;
    rule(!options.is_variable(), &of("smoothing_length"), "the smoothing length is fixed")?;
    rule(!options.diagnostics, &of("diagnostics"), "kernel sums do not change")?;
    rule(options.smooth_bodies.is_empty(), &of("smooth_bodies"), "bodies in contact stay bonded")?;
    rule(options.confining.is_none(), &of("confining"), "no pressure acts on surfaces")?;
    for (name, value) in [
        ("stress_diffusion", options.stress_diffusion),
        ("density_diffusion", options.density_diffusion),
        ("xsph", options.xsph),
        ("hourglass_viscosity", options.hourglass_viscosity),
        ("shifting", options.shifting),
    ] {
        rule(value == 0.0, &of(name), "it has no effect")?;
    }
    Ok(())
}
