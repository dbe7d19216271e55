//! The solver: its owners and one step (sheet: sph §3.3).
//!
//! | owner | holds | changed by |
//! |---|---|---|
//! | [`Setting`] | case, options, kernel | nobody |
//! | [`Clock`] | stage, time, step and its limit | the end of a step |
//! | [`Bodies`] | columns of particles, laws and their states, what particles show each other | kick, strain, drift |
//! | [`Walls`] | planes, images, smooth bodies | their motion, new lists |
//! | [`Lists`] | neighbours and the weights of the pairs | new lists, the first sums over the pairs |
//! | [`Rates`] | accelerations, velocity gradients, … | the sums over neighbours |

mod motion;
mod records;
mod schemes;
mod sums;

pub use motion::audits;
pub use schemes::Kept;

pub(crate) use records::{show, sum_densities};
#[cfg(test)]
pub(crate) use sums::diffuse_stress;
pub(crate) use sums::find_rates;

use colluvium_case::{SolverError, TimeStep};
use serde::{Deserialize, Serialize};

use crate::bearing::{bear_obstacles, follow};
use crate::clock::Clock;
use crate::limit::{find_limit, slowed, time_step_of};
use crate::lists::{Listed, Lists};
use crate::particles::Bodies;
use crate::rates::Rates;
use crate::regularise::Averages;
use crate::setting::Setting;
use crate::shifting::Shifting;
use crate::total::Reference;
use crate::walls::{Borne, Walls};

/// Distance from equilibrium and its pieces.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Audit {
    /// Square of the sum of the unbalanced forces (N²).
    pub unbalanced: f64,
    /// Square of the external forces (N²).
    pub external: f64,
    /// Kinetic energy (J).
    pub kinetic: f64,
    /// Work of gravity, loads and a confining pressure since the stage began (J).
    pub work: f64,
}

impl Audit {
    /// That of the next step, from what each particle adds to it, in this order: work goes on.
    pub(crate) fn next(self, particles: impl Iterator<Item = Self>) -> Self {
        particles.fold(Self { work: self.work, ..Self::default() }, |sum, own| Self {
            unbalanced: sum.unbalanced + own.unbalanced,
            external: sum.external + own.external,
            kinetic: sum.kinetic + own.kinetic,
            work: sum.work + own.work,
        })
    }
}

/// Explicit SPH in `D` dimensions.
pub struct SphSolver<const D: usize> {
    pub(crate) setting: Setting<D>,
    pub(crate) clock: Clock,
    pub(crate) bodies: Bodies<D>,
    pub(crate) walls: Walls<D>,
    pub(crate) lists: Lists<D>,
    pub(crate) rates: Rates<D>,
    /// Of smoothed stresses and renewed densities.
    pub(crate) averages: Averages,
    pub(crate) shifting: Shifting<D>,
    /// Of the schemes that need more than the state.
    pub(crate) kept: Kept<D>,
    pub(crate) audit: Audit,
    /// What obstacles have taken since the start.
    pub(crate) borne: Borne,
    /// The initial configuration, of the total-Lagrangian form.
    pub(crate) reference: Option<Box<Reference<D>>>,
}

impl<const D: usize> SphSolver<D> {
    /// A solver of `bodies` between `walls`, at time zero.
    pub(crate) fn new(setting: Setting<D>, bodies: Bodies<D>, walls: Walls<D>) -> Self {
        let mut rates = Rates::default();
        rates.of.resize(bodies.particles.len());
        Self {
            setting,
            clock: Clock::default(),
            bodies,
            walls,
            lists: Lists::new(Listed::default(), None),
            rates,
            averages: Averages::default(),
            shifting: Shifting::default(),
            kept: Kept::default(),
            audit: Audit::default(),
            borne: Borne::default(),
            reference: None,
        }
    }

    /// A solver in the same stage of the same case at the same time, without particles.
    pub(crate) fn hollow(&self) -> Self {
        Self {
            clock: self.clock,
            lists: self.lists.hollow(),
            rates: self.rates.hollow(),
            audit: self.audit,
            borne: self.borne,
            ..Self::new(self.setting.clone(), self.bodies.hollow(), self.walls.hollow())
        }
    }

    /// One step of exactly `dt` (s), whatever is stable.
    ///
    /// # Errors
    /// When a particle can no longer be followed.
    pub(crate) fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        if self.clock.limit.is_none() {
            self.critical_step();
        }
        self.walls.obstacles.take_pace(self.clock.time + dt, dt);
        if self.reference.is_none() {
            self.list(true)?;
        }
        self.advance_listed(dt)?;
        let Self { setting, clock, bodies, rates, audit, borne, .. } = self;
        if setting.is_audited(clock) {
            *audit = audit.next(audits(setting, clock, bodies, rates, dt).map(|(_, own)| own));
        }
        rates.borne.iter().for_each(|own| borne.add(own));
        clock.end_step(dt);
        Ok(())
    }

    /// Step 1: neighbours, images and walls.
    pub(crate) fn list(&mut self, begins: bool) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, .. } = self;
        lists.refresh(setting, clock, bodies, walls, rates, begins)
    }

    /// The state at the end of a step, with the neighbours as they are listed.
    pub(crate) fn advance_listed(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, averages, shifting, .. } = self;
        if let Some(problem) = clock.too_long(setting.options.time_step) {
            return Err(clock.failed(format!("methods.sph.time_step: {problem}")));
        }
        walls.follow_histories(clock.time, clock.time + dt);
        bodies.follow_histories(clock.time, clock.time + dt);
        if averages.regularise(setting, clock, bodies, walls, lists, dt)? {
            rates.current = false;
        }
        shifting.shift(setting, clock, bodies, walls, lists, rates);
        self.integrate(dt)?;
        let Self { setting, clock, bodies, walls, lists, rates, reference, .. } = self;
        rates.felt.iter_mut().for_each(|felt| felt.last(dt));
        follow(setting, bodies, lists, rates, reference.is_some(), dt);
        let turned = walls.turn_back(bodies, &mut rates.of, clock.time + dt);
        if bear_obstacles(setting, bodies, walls, rates, (clock.time + dt, dt)) || turned {
            (lists.weighed, rates.current) = (false, false);
        }
        walls.press(setting, bodies, dt);
        Ok(())
    }

    /// Steps 3 and 4, where neighbours are listed.
    pub(crate) fn derive(&mut self, dt: f64) {
        let Self { setting, clock, bodies, walls, lists, rates, .. } = self;
        schemes::derive(setting, clock, bodies, walls, lists, rates, dt);
    }

    /// The largest stable step from the current state (sheet: sph §3.4).
    pub(crate) fn critical_step(&mut self) -> TimeStep {
        let Self { setting, clock, bodies, walls, rates, .. } = self;
        if let Some(limit) = clock.limit.filter(|_| !clock.is_limit_due()) {
            return limit;
        }
        let critical = time_step_of(find_limit(setting, bodies, rates), &bodies.particles);
        let critical = slowed(critical, &walls.obstacles, (clock.time, setting.options.spacing));
        clock.set_limit(critical, setting.options.time_step)
    }

    /// What summation would make of the densities as the particles stand now.
    pub(crate) fn summed_densities(&self) -> Result<Vec<f64>, SolverError> {
        let Self { setting, mut bodies, walls, lists, .. } = self.probe()?;
        walls.load_images(&mut bodies);
        sum_densities(&setting, &mut bodies, &walls, &lists);
        Ok(bodies.shown.summed)
    }
}
