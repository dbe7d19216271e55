//! States beyond what a case file can say, and their rates without a step: for the balances that hold exactly between
//! the sums (sheet: sph §5.3, V-10 to V-13, V-20), for disordered particles (V-35), and for whoever wants to look at
//! the operators in place.
//!
//! The state is that of a [`Case`] with places, velocities, densities and stresses of your own.

use colluvium_case::{Case, CaseError, Solver, spatial};
use colluvium_constitutive::SymTensor;

use crate::config::SphOptions;
use crate::pairs::Pairs;
use crate::setting::corner;
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

/// The first components, and zeros for what is not there.
fn resized<const E: usize>(values: &[f64]) -> [f64; E] {
    corner(&spatial(values))
}

impl<const D: usize> Given<D> {
    fn over<const E: usize>(&self) -> Given<E> {
        Given {
            shift: resized(&self.shift),
            velocity: resized(&self.velocity),
            compression: self.compression,
            stress: self.stress,
        }
    }
}

impl<const D: usize> Particle<D> {
    fn over<const E: usize>(&self) -> Particle<E> {
        let mut gradient = [[0.0; E]; E];
        for (row, of) in gradient.iter_mut().zip(&self.gradient) {
            *row = resized(of);
        }
        Particle {
            position: resized(&self.position),
            velocity: resized(&self.velocity),
            mass: self.mass,
            density: self.density,
            stress: self.stress,
            acceleration: resized(&self.acceleration),
            gradient,
            divergence: self.divergence,
            drift: resized(&self.drift),
        }
    }
}

/// What particles are given, whatever the space. With it the solver is compiled here, and not again where it is asked.
type Giving<'a> = dyn Fn(u32, &[f64; 3]) -> Given<3> + 'a;

/// The solver of `case` at its start, in as many ranks as its options say, whose particles are given what `given(id, position)`
/// says. The laws start from the stress that they are given.
///
/// # Errors
/// As [`colluvium_case::Method::build`], and where a law refuses a stress.
pub fn prepared<const D: usize>(
    case: &Case,
    given: impl Fn(u32, &[f64; D]) -> Given<D>,
) -> Result<Box<dyn Solver>, CaseError> {
    prepared_in_space(case, &|id, position| given(id, &resized(position)).over())
}

/// Kinetic energy (J, per metre or square metre in plane or line) of `case` at its start and after each of `count` steps of exactly
/// `dt` (s), whatever is stable, in one rank: for studies of stability. Shorter where a particle can no longer be followed.
///
/// # Errors
/// As [`colluvium_case::Method::build`].
pub fn unchecked_course(case: &Case, dt: f64, count: usize) -> Result<Vec<f64>, CaseError> {
    match case.dimension() {
        1 => course::<1>(case, dt, count),
        2 => course::<2>(case, dt, count),
        _ => course::<3>(case, dt, count),
    }
}

fn course<const D: usize>(case: &Case, dt: f64, count: usize) -> Result<Vec<f64>, CaseError> {
    let mut solver: SphSolver<D> = setup::solver(case, &setup::options(case)?)?;
    solver.begin_stage(0, 0.0).map_err(|error| wrong(&error))?;
    let mut energies = vec![solver.totals().kinetic];
    energies.extend((0..count).map_while(|_| solver.advance(dt).ok().map(|()| solver.totals().kinetic)));
    Ok(energies)
}

fn prepared_in_space(case: &Case, given: &Giving<'_>) -> Result<Box<dyn Solver>, CaseError> {
    let options = setup::options(case)?;
    Ok(match case.dimension() {
        1 => setup::shared_out(made::<1>(case, &options, given)?, options.ranks),
        2 => setup::shared_out(made::<2>(case, &options, given)?, options.ranks),
        _ => setup::shared_out(made::<3>(case, &options, given)?, options.ranks),
    })
}

/// As [`prepared`], as the solver itself.
#[cfg(test)]
pub(crate) fn solver<const D: usize>(
    case: &Case,
    given: impl Fn(u32, &[f64; D]) -> Given<D>,
) -> SphSolver<D> {
    let given: &Giving<'_> = &|id, position| given(id, &resized(position)).over();
    made(case, &setup::options(case).unwrap(), given).unwrap()
}

fn made<const D: usize>(
    case: &Case,
    options: &SphOptions,
    given: &Giving<'_>,
) -> Result<SphSolver<D>, CaseError> {
    let mut solver: SphSolver<D> = setup::solver(case, options)?;
    let p = &mut solver.bodies.particles;
    for i in 0..p.len() {
        let given = given(p.id[i], &resized(&p.position[i])).over::<D>();
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
    let found = rates_in_space(case, &|id, position| given(id, &resized(position)).over())?;
    Ok(found.iter().map(Particle::over).collect())
}

fn rates_in_space(case: &Case, given: &Giving<'_>) -> Result<Vec<Particle<3>>, CaseError> {
    match case.dimension() {
        1 => found::<1>(case, given),
        2 => found::<2>(case, given),
        _ => found::<3>(case, given),
    }
}

fn found<const D: usize>(case: &Case, given: &Giving<'_>) -> Result<Vec<Particle<3>>, CaseError> {
    let mut solver = made::<D>(case, &setup::options(case)?, given)?;
    solver.setting.gravity = [0.0; D];
    solver.critical_step();
    solver.list(true).map_err(|error| wrong(&error))?;
    solver.derive(0.0);
    let SphSolver { setting, bodies, walls, lists, rates, .. } = &mut solver;
    find_rates(setting, bodies, walls, lists, rates, (0.0, 0.0));
    let p = &bodies.particles;
    let pairs = Pairs::new(setting, p, walls);
    let particle = |i: usize| Particle::<D> {
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
    Ok((0..p.len()).map(|i| particle(i).over()).collect())
}
