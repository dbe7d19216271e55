//! Solver: its components and one step (sheet: sph §3.3).
//!
//! | component | content | changed by |
//! |---|---|---|
//! | [`SolverContext`] | case, options, kernel | nobody |
//! | [`Clock`] | stage, time, step and its limit | the end of a step |
//! | [`Bodies`] | columns of particles, laws and their states, pair data | kick, strain, drift |
//! | [`Walls`] | planes, images, smooth bodies | their motion, new lists |
//! | [`VerletLists`] | neighbours and the weights of the pairs | new lists, the first sums over the pairs |
//! | [`Rates`] | accelerations, velocity gradients, … | the sums over neighbours |

mod particle_motion;
mod program_access;
mod time_integration;

pub use crate::solver::particle_motion::equilibrium_terms;
pub use crate::solver::program_access::SphParticles;
pub use crate::solver::time_integration::SavedState;

#[cfg(test)]
pub(crate) use crate::momentum::rate_sums::diffuse_stress;
pub(crate) use crate::momentum::rate_sums::find_rates;
pub(crate) use crate::pairs::pair_data::{sum_densities, update_pair_data};

use colluvium_case::{FailureReason, SolverError, TimeStep};
use serde::{Deserialize, Serialize};

use crate::clock::Clock;
use crate::context::SolverContext;
use crate::critical_step::{critical_step, limit_by_obstacle_motion, to_time_step};
use crate::momentum::body_force::update_body_forces;
use crate::momentum::external_forces::{stop_at_obstacles, update_follower_loads};
use crate::momentum::shifting::Shifting;
use crate::neighbours::verlet_lists::{ListedPositions, VerletLists};
use crate::points::particles::Bodies;
use crate::rates::Rates;
use crate::stress::regularisation::SmoothedFields;
use crate::stress::total_lagrangian::TotalLagrangianReference;
use crate::walls::{ObstacleEnergies, Walls};

/// Terms of the equilibrium criterion.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct EquilibriumTerms {
    /// Square of the sum of the unbalanced forces (N²).
    pub unbalanced: f64,
    /// Square of the external forces (N²).
    pub external: f64,
    /// Kinetic energy (J).
    pub kinetic: f64,
    /// Work of gravity, loads, body force and confining pressure since the start of the stage (J).
    pub work: f64,
}

impl EquilibriumTerms {
    /// Equilibrium terms of the next step, summed over particles in order; the work is accumulated.
    pub(crate) fn next_terms(self, particles: impl Iterator<Item = Self>) -> Self {
        particles.fold(Self { work: self.work, ..Self::default() }, |sum, own| Self {
            unbalanced: sum.unbalanced + own.unbalanced,
            external: sum.external + own.external,
            kinetic: sum.kinetic + own.kinetic,
            work: sum.work + own.work,
        })
    }
}

/// Explicit SPH solver in `D` dimensions.
pub struct SphSolver<const D: usize> {
    /// Case, options, kernel and gravity, constant during the run.
    pub(crate) setting: SolverContext<D>,
    /// Time and step of the run.
    pub(crate) clock: Clock,
    /// Particles of all bodies.
    pub(crate) bodies: Bodies<D>,
    /// Wall particles and planes.
    pub(crate) walls: Walls<D>,
    /// Neighbour lists.
    pub(crate) lists: VerletLists<D>,
    /// Rates of velocity, density and strain.
    pub(crate) rates: Rates<D>,
    /// Smoothed stresses and renewed densities.
    pub(crate) averages: SmoothedFields,
    /// Particle shifting.
    pub(crate) shifting: Shifting<D>,
    /// Saved state of multi-stage schemes.
    pub(crate) saved_state: SavedState<D>,
    /// Force and energy sums for the equilibrium criterion.
    pub(crate) equilibrium_terms: EquilibriumTerms,
    /// Energies that obstacles have removed since the start.
    pub(crate) obstacle_energies: ObstacleEnergies,
    /// Initial configuration, of the total-Lagrangian formulation.
    pub(crate) reference: Option<Box<TotalLagrangianReference<D>>>,
}

impl<const D: usize> SphSolver<D> {
    /// Returns a solver of `bodies` between `walls`, at time zero.
    pub(crate) fn new(setting: SolverContext<D>, bodies: Bodies<D>, walls: Walls<D>) -> Self {
        let mut rates = Rates::default();
        rates.derivatives.resize(bodies.particles.len());
        Self {
            setting,
            clock: Clock::default(),
            bodies,
            walls,
            lists: VerletLists::new(ListedPositions::default(), None),
            rates,
            averages: SmoothedFields::default(),
            shifting: Shifting::default(),
            saved_state: SavedState::default(),
            equilibrium_terms: EquilibriumTerms::default(),
            obstacle_energies: ObstacleEnergies::default(),
            reference: None,
        }
    }

    /// Solver without particles at the same time and stage of the same case.
    pub(crate) fn empty_like(&self) -> Self {
        Self {
            clock: self.clock,
            lists: self.lists.empty_like(),
            rates: self.rates.empty_like(),
            equilibrium_terms: self.equilibrium_terms,
            obstacle_energies: self.obstacle_energies,
            ..Self::new(self.setting.clone(), self.bodies.empty_like(), self.walls.empty_like())
        }
    }

    /// Advances by a step of `dt` (s), without a check of its stability.
    ///
    /// # Errors
    /// When the state of a particle becomes invalid.
    pub(crate) fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        update_body_forces(&self.clock, &mut self.bodies)?;
        if self.clock.limit.is_none() {
            self.critical_step();
        }
        self.walls.obstacles.set_mean_velocity(self.clock.time + dt, dt);
        if self.reference.is_none() {
            self.update_lists(true)?;
        }
        self.advance_listed(dt)?;
        let Self {
            setting, clock, bodies, rates, equilibrium_terms: audit, obstacle_energies: energies, ..
        } = self;
        if setting.needs_equilibrium(clock) {
            *audit =
                audit.next_terms(equilibrium_terms(setting, clock, bodies, rates, dt).map(|(_, own)| own));
        }
        rates.obstacle_energies.iter().for_each(|own| energies.add(own));
        clock.end_step(dt);
        Ok(())
    }

    /// Updates neighbour lists, image particles and wall particles (step 1). Particles may be sorted only if `at_step_start` is true.
    pub(crate) fn update_lists(&mut self, at_step_start: bool) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, .. } = self;
        lists.refresh(setting, clock, bodies, walls, rates, at_step_start)
    }

    /// Advances the state by a step, with the present neighbour lists.
    pub(crate) fn advance_listed(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, averages, shifting, .. } = self;
        if let Some(problem) = clock.fixed_step_problem(setting.options.time_step) {
            return Err(
                clock.step_error(FailureReason::FixedStep(format!("methods.sph.time_step: {problem}")))
            );
        }
        walls.update_time_histories(clock.time, clock.time + dt);
        bodies.update_time_histories(clock.time, clock.time + dt);
        if averages.regularise(setting, clock, bodies, walls, lists, dt)? {
            rates.is_current = false;
        }
        shifting.shift(setting, clock, bodies, walls, lists, rates);
        if setting.options.shifting > 0.0 {
            update_body_forces(clock, bodies)?;
        }
        self.integrate(dt)?;
        let Self { setting, clock, bodies, walls, lists, rates, reference, .. } = self;
        rates.reactions.iter_mut().for_each(|reaction| reaction.add_impulse(dt));
        update_follower_loads(setting, bodies, lists, rates, reference.is_some(), dt);
        let turned = walls.reflect_escaped(bodies, &mut rates.derivatives, clock.time + dt);
        if stop_at_obstacles(setting, bodies, walls, rates, (clock.time + dt, dt)) || turned {
            (lists.weights_current, rates.is_current) = (false, false);
        }
        walls.update_delayed_pressures(setting, bodies, dt);
        Ok(())
    }

    /// Updates the accelerations with the present neighbour lists; steps 3 and 4.
    pub(crate) fn update_accelerations(&mut self, dt: f64) {
        let Self { setting, clock, bodies, walls, lists, rates, .. } = self;
        time_integration::update_accelerations(setting, clock, bodies, walls, lists, rates, dt);
    }

    /// Critical time step of the current state (sheet: sph §3.4).
    pub(crate) fn critical_step(&mut self) -> TimeStep {
        let Self { setting, clock, bodies, walls, rates, .. } = self;
        if let Some(limit) = clock.limit.filter(|_| !clock.is_limit_due()) {
            return limit;
        }
        let critical = to_time_step(critical_step(setting, bodies, rates), &bodies.particles);
        let critical =
            limit_by_obstacle_motion(critical, &walls.obstacles, (clock.time, setting.options.spacing));
        clock.set_limit(critical, setting.options.time_step)
    }

    /// Densities by summation at the present positions (kg/m³).
    pub(crate) fn summed_densities(&self) -> Result<Vec<f64>, SolverError> {
        let Self { setting, mut bodies, walls, lists, .. } = self.diagnostic_copy()?;
        walls.load_images(&mut bodies);
        sum_densities(&setting, &mut bodies, &walls, &lists);
        Ok(bodies.pair_data.summed_density)
    }
}
