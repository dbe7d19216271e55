//! Rates of a state, without a step: for the balances that hold exactly between the sums (SPH sheet §5.3, V-10 to
//! V-13, V-20), and for whoever wants to look at the operators in place.
//!
//! The state is that of a [`Case`] with velocities, densities and stresses of your own.

use colluvium_case::{Case, CaseError};
use colluvium_constitutive::SymTensor;

use crate::setup;
use crate::solver::SphSolver;

/// What a particle is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Given<const D: usize> {
    /// Velocity (m/s).
    pub velocity: [f64; D],
    /// Density over the initial one.
    pub compression: f64,
    /// Stress (Pa).
    pub stress: SymTensor,
}

/// A particle and its rates.
#[derive(Clone, Debug, PartialEq)]
pub struct Particle<const D: usize> {
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
    /// `-ρ̇/ρ` (1/s).
    pub divergence: f64,
    /// `Σ m/ρ (v_j - v_i) W`, the velocity of XSPH over its factor (m/s).
    pub drift: [f64; D],
}

/// The rates of `case`, whose particles are given what `given(id, position)` says.
///
/// # Errors
/// As [`colluvium_case::Method::build`].
pub fn rates<const D: usize>(
    case: &Case,
    given: impl Fn(u32, &[f64; D]) -> Given<D>,
) -> Result<Vec<Particle<D>>, CaseError> {
    let options = case.method_options("sph")?;
    let mut solver: SphSolver<D> = setup::solver(case, &options)?;
    solver.gravity = [0.0; D];
    solver.critical_step();
    let p = &mut solver.particles;
    for i in 0..p.len {
        let given = given(p.id[i], &p.position[i]);
        p.velocity[i] = given.velocity;
        p.density[i] *= given.compression;
        p.stress[i] = given.stress;
    }
    let wrong = |error: colluvium_case::SolverError| CaseError::new("bodies", error.to_string());
    solver.refresh_neighbours(true).map_err(wrong)?;
    solver.derive(0.0);
    solver.find_rates(0.0);
    let pairs = solver.pairs();
    let p = &solver.particles;
    let particle = |i: usize| Particle {
        position: p.position[i],
        velocity: p.velocity[i],
        mass: p.mass[i],
        density: p.density[i],
        stress: p.stress[i],
        acceleration: p.acceleration[i],
        gradient: p.gradient[i],
        divergence: p.divergence[i],
        drift: pairs.drift(i, solver.neighbours.of(i)),
    };
    Ok((0..p.len).map(particle).collect())
}
