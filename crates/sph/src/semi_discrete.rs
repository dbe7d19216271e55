//! States beyond what a case file can say, and their rates without a step: for the balances that hold exactly between
//! the sums (sheet: sph §5.3, V-10 to V-13, V-20), for disordered particles (V-35), and for whoever wants to look at
//! the operators in place.
//!
//! The state is that of a [`Case`] with places, velocities, densities and stresses of your own.

use colluvium_case::{Case, CaseError, Solver};
use colluvium_constitutive::SymTensor;

use crate::pairs::Pairs;
use crate::setup;
use crate::solver::{SphSolver, find_rates};

/// What a particle is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Given<const D: usize> {
    /// Change of place (m).
    pub shift: [f64; D],
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

/// The solver of `case` at its start, whose particles are given what `given(id, position)` says. The laws start from
/// the stress that they are given.
///
/// # Errors
/// As [`colluvium_case::Method::build`], and where a law refuses a stress.
pub fn prepared<const D: usize>(
    case: &Case,
    given: impl Fn(u32, &[f64; D]) -> Given<D>,
) -> Result<SphSolver<D>, CaseError> {
    let options = setup::options(case)?;
    let mut solver: SphSolver<D> = setup::solver(case, &options)?;
    let p = &mut solver.bodies.particles;
    for i in 0..p.len() {
        let given = given(p.id[i], &p.position[i]);
        (0..D).for_each(|c| p.position[i][c] += given.shift[c]);
        p.origin[i] = p.position[i];
        p.velocity[i] = given.velocity;
        p.density[i] *= given.compression;
        p.stress[i] = given.stress;
    }
    solver.begin_stage(0, 0.0).map_err(|error| wrong(&error))?;
    solver.reset_states().map_err(|error| wrong(&error))?;
    Ok(solver)
}

fn wrong(error: &colluvium_case::SolverError) -> CaseError {
    CaseError::new("bodies", error.to_string())
}

/// The rates of such a state.
///
/// # Errors
/// As [`prepared`].
pub fn rates<const D: usize>(
    case: &Case,
    given: impl Fn(u32, &[f64; D]) -> Given<D>,
) -> Result<Vec<Particle<D>>, CaseError> {
    let mut solver = prepared(case, given)?;
    solver.setting.gravity = [0.0; D];
    solver.critical_step();
    solver.list(true).map_err(|error| wrong(&error))?;
    solver.derive(0.0);
    let SphSolver { setting, bodies, walls, lists, rates, .. } = &mut solver;
    find_rates(setting, bodies, walls, lists, rates, 0.0);
    let p = &bodies.particles;
    let pairs = Pairs::new(setting, p, walls);
    let particle = |i: usize| Particle {
        position: p.position[i],
        velocity: p.velocity[i],
        mass: p.mass[i],
        density: p.density[i],
        stress: p.stress[i],
        acceleration: rates.of.acceleration[i],
        gradient: rates.of.gradient[i],
        divergence: rates.of.divergence[i],
        drift: pairs.drift(i, lists.neighbours.of(i)),
    };
    Ok((0..p.len()).map(particle).collect())
}
