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
use crate::pairs::SOFTENING;
use crate::pairs::operators::GradientMoment;
use crate::points::packed_particles::{self, Lanes};
use crate::points::particles::{Derivatives, MIN_PARTICLES_PER_TASK, Particles, SquareMatrix};
use crate::points::vector_algebra::separation;

/// Four neighbours of a particle, with the particle itself in place of missing ones.
struct FourNeighbours<const D: usize> {
    /// Indices.
    index: [u32; 4],
    /// Gradients `V⁰_j ∇⁰W` (1/m); zero in place of missing neighbours.
    gradient: [Lanes; D],
}

/// Initial configuration with its constant pairs and corrected gradients.
struct InitialConfiguration<const D: usize> {
    /// Neighbours of all particles, particle by particle.
    neighbours: Vec<FourNeighbours<D>>,
    /// Ends of the particles in `neighbours`.
    row_ends: Vec<usize>,
    /// Smoothing length (m).
    length: f64,
    /// Densities `ρ⁰` (kg/m³).
    density: Vec<f64>,
    /// Sums of the gradients of each particle (1/m); zero with neighbours on all sides.
    gradient_sum: Vec<[f64; D]>,
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

/// Vectors of four particles, relative to one of them.
#[inline(always)]
fn relative<const D: usize>(vectors: &[[f64; D]], four: [usize; 4], own: &[f64; D]) -> [Lanes; D] {
    let vectors = four.map(|j| &vectors[j]);
    std::array::from_fn(|c| Lanes::new(vectors.map(|v| v[c])) - own[c])
}

impl<const D: usize> InitialConfiguration<D> {
    /// Configuration of particles at their positions, with the correction still to be set.
    fn new(particles: &Particles<D>, smoothing: &Smoothing<D>) -> Result<Self, SearchError> {
        let position = &particles.position[..particles.len()];
        let mut near = NeighbourList::new();
        near.build(position, smoothing.radius())?;
        let mut initial = Self {
            neighbours: Vec::new(),
            row_ends: Vec::new(),
            length: smoothing.length(),
            density: particles.density.clone(),
            gradient_sum: Vec::new(),
            correction: Vec::new(),
        };
        for i in 0..position.len() {
            let gradient = |j: usize| {
                let (apart, square) = separation(&position[i], &position[j]);
                let volume = particles.mass[j] / particles.density[j];
                apart.map(|c| c * (volume * smoothing.gradient_factor(square.sqrt())))
            };
            for four in near.neighbours(i).chunks(4) {
                let index = std::array::from_fn(|k| four.get(k).copied().unwrap_or(i as u32));
                let gradients = index.map(|j| gradient(j as usize));
                let gradient = std::array::from_fn(|c| Lanes::new(gradients.map(|g| g[c])));
                initial.neighbours.push(FourNeighbours { index, gradient });
            }
            initial.row_ends.push(initial.neighbours.len());
            initial.find_correction(i, position);
        }
        Ok(initial)
    }

    /// Adds the correction of the last particle `i` and the sum of its gradients.
    fn find_correction(&mut self, i: usize, position: &[[f64; D]]) {
        let row = self.row(i);
        let some = row.iter().flat_map(|four| (0..4).map(|k| four.gradient.map(|lanes| lanes.to_array()[k])));
        let moment = GradientMoment {
            matrix: self.gradient(i, position),
            neighbours: some.filter(|gradient| *gradient != [0.0; D]).count() as u32,
        };
        let mut sum = [Lanes::splat(0.0); D];
        row.iter().for_each(|four| (0..D).for_each(|c| sum[c] += four.gradient[c]));
        // Without neighbours on all sides a particle moves without deformation.
        let correction = moment.correction().unwrap_or([[0.0; D]; D]);
        self.gradient_sum.push(sum.map(packed_particles::sum));
        self.correction.push(correction);
    }

    /// Neighbours of particle `i`.
    #[inline(always)]
    fn row(&self, i: usize) -> &[FourNeighbours<D>] {
        let start = if i == 0 { 0 } else { self.row_ends[i - 1] };
        &self.neighbours[start..self.row_ends[i]]
    }

    /// Uncorrected gradient `Σ V⁰_j (f_j - f_i) ⊗ ∇⁰W` of a vector field.
    #[inline]
    fn gradient(&self, i: usize, field: &[[f64; D]]) -> SquareMatrix<D> {
        let mut sum = [[Lanes::splat(0.0); D]; D];
        for four in self.row(i) {
            let difference = relative(field, four.index.map(|j| j as usize), &field[i]);
            for (row, value) in sum.iter_mut().zip(difference) {
                (0..D).for_each(|b| row[b] += value * four.gradient[b]);
            }
        }
        sum.map(|row| row.map(packed_particles::sum))
    }
}

impl<const D: usize> TotalLagrangianReference<D> {
    /// Returns the reference configuration of the particles at their present positions.
    ///
    /// # Errors
    /// When the neighbour search fails.
    pub fn new(particles: &Particles<D>, smoothing: &Smoothing<D>) -> Result<Self, SearchError> {
        let initial = InitialConfiguration::new(particles, smoothing)?;
        let unit: SquareMatrix<D> =
            std::array::from_fn(|a| std::array::from_fn(|b| f64::from(u8::from(a == b))));
        let count = particles.len();
        Ok(Self { initial, deformation: vec![unit; count], nominal: vec![[[0.0; D]; D]; count] })
    }

    /// Updates `F` and `P L⁰` of the state.
    fn update_nominal_stress(&mut self, p: &Particles<D>) {
        let Self { initial, deformation, nominal } = self;
        let all = deformation.par_iter_mut().zip(nominal).enumerate();
        all.with_min_len(MIN_PARTICLES_PER_TASK).for_each(|(i, (deformation, nominal))| {
            if initial.correction[i] != [[0.0; D]; D] {
                *deformation = matmul(&initial.gradient(i, &p.position), &initial.correction[i]);
            }
            let stress = matmul(
                &std::array::from_fn(|a| std::array::from_fn(|b| p.stress[i].component(a, b))),
                &cofactor(deformation),
            );
            *nominal = matmul(&stress, &initial.correction[i]);
        });
    }

    /// Acceleration of particle `i` by its neighbours (m/s²), with artificial viscosity `(α, β)` along current distance vectors.
    fn acceleration(&self, p: &Particles<D>, i: usize, viscosity: (f64, f64)) -> [f64; D] {
        let Self { initial, nominal, .. } = self;
        let is_viscous = viscosity != (0.0, 0.0);
        let mut sum = [Lanes::splat(0.0); D];
        for four in initial.row(i) {
            let index = four.index.map(|j| j as usize);
            let stress = index.map(|j| &nominal[j]);
            for (a, sum) in sum.iter_mut().enumerate() {
                for b in 0..D {
                    *sum += Lanes::new(stress.map(|stress| stress[a][b])) * four.gradient[b];
                }
            }
            if is_viscous {
                let apart = relative(&p.position, index, &p.position[i]);
                let viscous = self.viscosity(p, (i, index), &apart, &four.gradient, viscosity);
                (0..D).for_each(|c| sum[c] += apart[c] * viscous);
            }
        }
        // The stress of the particle itself is the same in all pairs.
        let (own, along) = (&nominal[i], &initial.gradient_sum[i]);
        std::array::from_fn(|a| {
            let by_own: f64 = (0..D).map(|b| own[a][b] * along[b]).sum();
            (packed_particles::sum(sum[a]) + by_own) / initial.density[i]
        })
    }

    /// Viscous stress `ρ (α c π - β π²)` of four pairs times the size of their gradients, over their distances `apart` (m).
    #[inline(always)]
    fn viscosity(
        &self,
        p: &Particles<D>,
        (i, four): (usize, [usize; 4]),
        apart: &[Lanes; D],
        gradient: &[Lanes; D],
        (linear, quadratic): (f64, f64),
    ) -> Lanes {
        let (h, density) = (self.initial.length, &self.initial.density);
        let closing = packed_particles::dot(&relative(&p.velocity, four, &p.velocity[i]), apart);
        let square = packed_particles::dot(apart, apart);
        let softened = square + SOFTENING * h * h;
        let sound = (Lanes::new(four.map(|j| p.sound[j])) + p.sound[i]) * 0.5;
        let mean = (Lanes::new(four.map(|j| density[j])) + density[i]) * 0.5;
        // π = h closing / softened, and |∇W| / r = √(∇W² r²) / r²: one root and one division.
        let product = closing.fast_min(Lanes::splat(0.0)) * h;
        let size = (packed_particles::dot(gradient, gradient) * square).sqrt();
        let stress = mean * product * (sound * softened * linear - product * quadratic);
        stress * size / (softened * softened * square.fast_max(Lanes::splat(1e-24 * h * h)))
    }

    /// Velocity gradient over the present positions (1/s).
    fn rate(&self, p: &Particles<D>, i: usize) -> SquareMatrix<D> {
        let rate = matmul(&self.initial.gradient(i, &p.velocity), &self.initial.correction[i]);
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
        let both = rates.gradient.par_iter_mut().zip(&mut rates.divergence).enumerate();
        both.with_min_len(MIN_PARTICLES_PER_TASK).for_each(|(i, (gradient, divergence))| {
            *gradient = self.rate(particles, i);
            *divergence = (0..D).map(|c| gradient[c][c]).sum();
        });
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
