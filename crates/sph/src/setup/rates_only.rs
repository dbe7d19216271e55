//! Rates of prescribed states without a step: for the balances that hold exactly between the sums (sheet: sph §5.3, V-10 to V-13, V-20),
//! for disordered particles (V-35), and for
//! studies of the operators.
//!
//! The state is that of a [`Case`] with prescribed positions, velocities, densities and stresses.

use colluvium_case::{Case, CaseError, Solver, spatial};
use colluvium_constitutive::SymTensor;

use crate::config::SphOptions;
use crate::context::leading_components;
use crate::pairs::PairContext;
use crate::setup;
use crate::solver::{SphSolver, find_rates};
use colluvium_case::CaseErrorKind;

/// Prescribed state of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrescribedParticle<const D: usize> {
    /// Displacement (m).
    pub displacement: [f64; D],
    /// Velocity (m/s).
    pub velocity: [f64; D],
    /// Density over the initial one.
    pub compression: f64,
    /// Stress (Pa).
    pub stress: SymTensor,
}

/// State and rates of a particle.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticleRates<const D: usize> {
    /// Position (m).
    pub position: [f64; D],
    /// Velocity (m/s).
    pub velocity: [f64; D],
    /// Mass (kg).
    pub mass: f64,
    /// Density (kg/m³).
    pub density: f64,
    /// Stress (Pa).
    pub stress: SymTensor,
    /// Acceleration by the neighbours and walls, without gravity (m/s²).
    pub acceleration: [f64; D],
    /// Velocity gradient `∂v_a/∂x_b` (1/s).
    pub gradient: [[f64; D]; D],
    /// Divergence `-ρ̇/ρ` (1/s).
    pub divergence: f64,
    /// XSPH velocity over its factor, `Σ m/ρ (v_j - v_i) W` (m/s).
    pub drift: [f64; D],
}

/// Leading components, padded with zeros.
fn resized_vector<const E: usize>(values: &[f64]) -> [f64; E] {
    leading_components(&spatial(values))
}

impl<const D: usize> PrescribedParticle<D> {
    /// Values of the particle in `E` dimensions: components are dropped or filled with zeros.
    fn with_dimension<const E: usize>(&self) -> PrescribedParticle<E> {
        PrescribedParticle {
            displacement: resized_vector(&self.displacement),
            velocity: resized_vector(&self.velocity),
            compression: self.compression,
            stress: self.stress,
        }
    }
}

impl<const D: usize> ParticleRates<D> {
    /// Rates of the particle in `E` dimensions: components are dropped or filled with zeros.
    fn with_dimension<const E: usize>(&self) -> ParticleRates<E> {
        let mut gradient = [[0.0; E]; E];
        for (row, of) in gradient.iter_mut().zip(&self.gradient) {
            *row = resized_vector(of);
        }
        ParticleRates {
            position: resized_vector(&self.position),
            velocity: resized_vector(&self.velocity),
            mass: self.mass,
            density: self.density,
            stress: self.stress,
            acceleration: resized_vector(&self.acceleration),
            gradient,
            divergence: self.divergence,
            drift: resized_vector(&self.drift),
        }
    }
}

/// Function that prescribes the state of a particle from its id and position (m).
type ParticlePrescription<'a> = dyn Fn(u32, &[f64; 3]) -> PrescribedParticle<3> + 'a;

/// Solver of `case` at its start with prescribed particle states, distributed over ranks by its options. The laws start from the given
/// stress.
///
/// # Errors
/// As [`colluvium_case::Method::build`], and where a law refuses a stress.
pub fn prepared_solver<const D: usize>(
    case: &Case,
    given: impl Fn(u32, &[f64; D]) -> PrescribedParticle<D>,
) -> Result<Box<dyn Solver>, CaseError> {
    prepared_in_space(case, &|id, position| given(id, &resized_vector(position)).with_dimension())
}

/// Kinetic energy of `case` at its start and after each of `count` steps of `dt` (J; per metre in the plane), without a stability limit and
/// ranks, for stability studies. The list is shorter if the state of a particle becomes invalid.
///
/// # Errors
/// As [`colluvium_case::Method::build`].
pub fn unchecked_energy_history(case: &Case, dt: f64, count: usize) -> Result<Vec<f64>, CaseError> {
    match case.dimension() {
        1 => energy_history::<1>(case, dt, count),
        2 => energy_history::<2>(case, dt, count),
        _ => energy_history::<3>(case, dt, count),
    }
}

/// Kinetic energy at the start and after each of `count` steps of `dt` (J).
fn energy_history<const D: usize>(case: &Case, dt: f64, count: usize) -> Result<Vec<f64>, CaseError> {
    let mut solver: SphSolver<D> = setup::solver(case, &setup::options(case)?)?;
    solver.begin_stage(0, 0.0).map_err(|error| to_case_error(&error))?;
    let mut energies = vec![solver.totals().kinetic];
    energies.extend((0..count).map_while(|_| solver.advance(dt).ok().map(|()| solver.totals().kinetic)));
    Ok(energies)
}

/// Solver of a case with prescribed particle states, in the dimension of the case.
fn prepared_in_space(case: &Case, given: &ParticlePrescription<'_>) -> Result<Box<dyn Solver>, CaseError> {
    let options = setup::options(case)?;
    Ok(match case.dimension() {
        1 => setup::distributed_solver(build_prescribed::<1>(case, &options, given)?, options.ranks),
        2 => setup::distributed_solver(build_prescribed::<2>(case, &options, given)?, options.ranks),
        _ => setup::distributed_solver(build_prescribed::<3>(case, &options, given)?, options.ranks),
    })
}

/// Solver as [`prepared_solver`], with its concrete type.
#[cfg(test)]
pub(crate) fn solver<const D: usize>(
    case: &Case,
    given: impl Fn(u32, &[f64; D]) -> PrescribedParticle<D>,
) -> SphSolver<D> {
    let given: &ParticlePrescription<'_> =
        &|id, position| given(id, &resized_vector(position)).with_dimension();
    build_prescribed(case, &setup::options(case).unwrap(), given).unwrap()
}

/// Solver of a case with prescribed displacement, velocity, density and stress of its particles.
fn build_prescribed<const D: usize>(
    case: &Case,
    options: &SphOptions,
    given: &ParticlePrescription<'_>,
) -> Result<SphSolver<D>, CaseError> {
    let mut solver: SphSolver<D> = setup::solver(case, options)?;
    let p = &mut solver.bodies.particles;
    for i in 0..p.len() {
        let given = given(p.id[i], &resized_vector(&p.position[i])).with_dimension::<D>();
        (0..D).for_each(|c| p.position[i][c] += given.displacement[c]);
        p.origin[i] = p.position[i];
        p.velocity[i] = given.velocity;
        p.density[i] *= given.compression;
        p.stress[i] = given.stress;
    }
    solver.begin_stage(0, 0.0).map_err(|error| to_case_error(&error))?;
    solver.reset_states().map_err(|error| to_case_error(&error))?;
    Ok(solver)
}

/// Error of a case for a failure of the solver.
fn to_case_error(error: &colluvium_case::SolverError) -> CaseError {
    CaseError::new("bodies", CaseErrorKind::coded(error.code(), error.to_string()))
}

/// Rates of a prescribed state.
///
/// # Errors
/// As [`prepared_solver`].
pub fn rates<const D: usize>(
    case: &Case,
    given: impl Fn(u32, &[f64; D]) -> PrescribedParticle<D>,
) -> Result<Vec<ParticleRates<D>>, CaseError> {
    let found = rates_in_space(case, &|id, position| given(id, &resized_vector(position)).with_dimension())?;
    Ok(found.iter().map(ParticleRates::with_dimension).collect())
}

/// Rates of all particles with prescribed states, in the dimension of the case.
fn rates_in_space(case: &Case, given: &ParticlePrescription<'_>) -> Result<Vec<ParticleRates<3>>, CaseError> {
    match case.dimension() {
        1 => prescribed_rates::<1>(case, given),
        2 => prescribed_rates::<2>(case, given),
        _ => prescribed_rates::<3>(case, given),
    }
}

/// Rates of all particles with prescribed states, without gravity.
fn prescribed_rates<const D: usize>(
    case: &Case,
    given: &ParticlePrescription<'_>,
) -> Result<Vec<ParticleRates<3>>, CaseError> {
    let mut solver = build_prescribed::<D>(case, &setup::options(case)?, given)?;
    solver.setting.gravity = [0.0; D];
    solver.critical_step();
    solver.update_lists(true).map_err(|error| to_case_error(&error))?;
    solver.update_accelerations(0.0);
    let SphSolver { setting, bodies, walls, lists, rates, .. } = &mut solver;
    find_rates(setting, bodies, walls, lists, rates, (0.0, 0.0));
    let p = &bodies.particles;
    let pairs = PairContext::new(setting, p, walls);
    let particle = |i: usize| ParticleRates::<D> {
        position: p.position[i],
        velocity: p.velocity[i],
        mass: p.mass[i],
        density: p.density[i],
        stress: p.stress[i],
        acceleration: rates.derivatives.acceleration[i],
        gradient: rates.derivatives.gradient[i],
        divergence: rates.derivatives.divergence[i],
        drift: pairs.xsph_velocity(i, lists.neighbours.neighbours(i)),
    };
    Ok((0..p.len()).map(|i| particle(i).with_dimension()).collect())
}
