//! Time integration (sheet: sph §3.3). Each scheme has one function, with the sheet's step numbers.

use colluvium_case::SolverError;
use colluvium_constitutive::{States, SymTensor};

use crate::clock::Clock;
use crate::config::TimeIntegration;
use crate::context::SolverContext;
use crate::momentum::body_force::update_body_forces;
use crate::momentum::external_forces::apply_loads;
use crate::momentum::rate_sums::{accelerate, diffuse_stress, find_rates};
use crate::neighbours::verlet_lists::VerletLists;
use crate::pairs::pair_data::{update_pair_data, update_pair_velocities};
use crate::points::particles::{Bodies, SquareMatrix};
use crate::rates::Rates;
use crate::solver::SphSolver;
use crate::solver::particle_motion::{add_accelerations, drift};
use crate::stress::stress_update::{StageTime, update_stress};
use crate::walls::Walls;

/// Number of steps of the Verlet scheme between two steps from current velocities, which couple odd and even steps.
const STEPS_PER_PLAIN: u64 = 40;

/// Saved state of a step, with memory reused from step to step.
#[derive(Default)]
pub struct SavedState<const D: usize> {
    /// Positions at the start of the step (m).
    position: Vec<[f64; D]>,
    /// Velocities (m/s).
    velocity: Vec<[f64; D]>,
    /// Densities (kg/m³).
    density: Vec<f64>,
    /// Stresses (Pa).
    stress: Vec<SymTensor>,
    /// States of the laws, body by body.
    states: Vec<States>,
    /// Mean transport velocities of particles (m/s), or those at the end of the step.
    transport_velocity: Vec<[f64; D]>,
    /// Velocities of a stage of the step (m/s).
    stage_velocity: Vec<[f64; D]>,
    /// Mean accelerations (m/s²).
    mean_acceleration: Vec<[f64; D]>,
    /// Mean velocity gradients (1/s).
    gradient: Vec<SquareMatrix<D>>,
    /// Mean divergences (1/s).
    divergence: Vec<f64>,
}

/// Copies into existing memory.
fn copy<T: Copy>(to: &mut Vec<T>, from: &[T]) {
    to.clear();
    to.extend_from_slice(from);
}

/// Fills existing memory with `len` copies of a value.
fn fill<T: Copy>(to: &mut Vec<T>, value: T, len: usize) {
    to.clear();
    to.resize(len, value);
}

/// Adds vectors times a factor.
fn add<const D: usize>(to: &mut [[f64; D]], factor: f64, what: &[[f64; D]]) {
    to.iter_mut().zip(what).for_each(|(a, b)| (0..D).for_each(|c| a[c] += factor * b[c]));
}

/// Adds matrices times a factor.
fn add_matrix<const D: usize>(to: &mut [SquareMatrix<D>], factor: f64, what: &[SquareMatrix<D>]) {
    add(to.as_flattened_mut(), factor, what.as_flattened());
}

impl<const D: usize> SavedState<D> {
    /// Saves the state of the bodies.
    fn save(&mut self, bodies: &Bodies<D>) {
        let p = &bodies.particles;
        let len = p.len();
        copy(&mut self.position, &p.position[..len]);
        copy(&mut self.velocity, &p.velocity[..len]);
        copy(&mut self.density, &p.density[..len]);
        copy(&mut self.stress, &p.stress[..len]);
        self.states.resize_with(bodies.groups.len(), States::default);
        self.states.iter_mut().zip(&bodies.groups).for_each(|(kept, group)| kept.clone_from(&group.states));
    }

    /// Restores velocities, densities, stresses and states of the laws at the start.
    fn restore(&self, bodies: &mut Bodies<D>) {
        let p = &mut bodies.particles;
        let len = p.len();
        p.velocity[..len].copy_from_slice(&self.velocity);
        p.density[..len].copy_from_slice(&self.density);
        p.stress[..len].copy_from_slice(&self.stress);
        for (group, states) in bodies.groups.iter_mut().zip(&self.states) {
            group.states.clone_from(states);
        }
    }

    /// Sets the mean rates of `len` particles to zero.
    fn clear_means(&mut self, len: usize) {
        fill(&mut self.transport_velocity, [0.0; D], len);
        fill(&mut self.mean_acceleration, [0.0; D], len);
        fill(&mut self.gradient, [[0.0; D]; D], len);
        fill(&mut self.divergence, 0.0, len);
    }

    /// Adds the rates with a weight to their means.
    fn add_rates(&mut self, share: f64, velocities: &[[f64; D]], rates: &Rates<D>) {
        add(&mut self.transport_velocity, share, velocities);
        add(&mut self.transport_velocity, share, &rates.xsph_velocity);
        add(&mut self.mean_acceleration, share, &rates.derivatives.acceleration);
        add_matrix(&mut self.gradient, share, &rates.derivatives.gradient);
        self.divergence.iter_mut().zip(&rates.derivatives.divergence).for_each(|(sum, d)| *sum += share * d);
    }
}

/// Updates pair records and accelerations with present lists: steps 3 and 4.
pub fn update_accelerations<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
    dt: f64,
) {
    update_pair_data(setting, clock, bodies, walls, lists);
    accelerate(setting, clock, bodies, walls, lists, rates, dt);
}

/// Updates velocity gradients, densities and stresses: steps 6 to 8.
fn update_strain<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &mut Bodies<D>,
    walls: &Walls<D>,
    lists: &mut VerletLists<D>,
    rates: &mut Rates<D>,
    dt: f64,
) -> Result<(), SolverError> {
    find_rates(setting, bodies, walls, lists, rates, (dt, dt));
    diffuse_stress(setting, clock, bodies, walls, lists, rates, dt);
    update_stress(setting, clock, bodies, &rates.derivatives, dt, StageTime::Start)
}

impl<const D: usize> SolverContext<D> {
    /// Whether velocities are half a step earlier than positions.
    pub(crate) fn has_half_step_velocities(&self) -> bool {
        matches!(self.options.integration, TimeIntegration::Leapfrog | TimeIntegration::LeapfrogRates)
    }
}

impl<const D: usize> SphSolver<D> {
    /// Advances the state, not the time.
    pub(super) fn integrate(&mut self, dt: f64) -> Result<(), SolverError> {
        match self.setting.options.integration {
            _ if self.reference.is_some() => self.total_leapfrog(dt),
            TimeIntegration::Leapfrog => self.leapfrog(dt),
            TimeIntegration::LeapfrogRates => self.leapfrog_rates(dt),
            TimeIntegration::PredictorCorrector => self.predictor_corrector(dt),
            TimeIntegration::PositionVerlet => self.position_verlet(dt),
            TimeIntegration::VelocityVerlet => self.velocity_verlet(dt),
            TimeIntegration::Verlet => self.verlet(dt),
            TimeIntegration::RungeKutta4 => self.runge_kutta(dt),
        }
    }

    /// Leapfrog step of `dt` (s), with velocities at the middle of the step.
    fn leapfrog(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, .. } = self;
        update_accelerations(setting, clock, bodies, walls, lists, rates, dt); // 3, 4
        let step = 0.5 * (clock.last_step + dt);
        add_accelerations(setting, clock, bodies, &rates.derivatives.acceleration, step, dt); // 5
        bodies.integrate_rigid(setting, clock, walls, rates, (step, dt));
        update_strain(setting, clock, bodies, walls, lists, rates, dt)?; // 6–8
        drift(setting, clock, bodies, walls, lists, rates, dt)?; // 9
        bodies.rotate_rigid_velocities(dt);
        Ok(())
    }

    /// Leapfrog over the reference configuration.
    fn total_leapfrog(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, reference, .. } = self;
        let Some(reference) = reference else { return Ok(()) };
        let gravity = setting.gravity_at(clock, dt);
        reference.accelerate(
            &setting.options,
            &bodies.particles,
            &gravity,
            &mut rates.derivatives.acceleration,
        );
        apply_loads(setting, clock, bodies, rates, dt);
        add_accelerations(
            setting,
            clock,
            bodies,
            &rates.derivatives.acceleration,
            0.5 * (clock.last_step + dt),
            dt,
        );
        reference.find_rates(&bodies.particles, &mut rates.derivatives);
        update_stress(setting, clock, bodies, &rates.derivatives, dt, StageTime::Start)?;
        drift(setting, clock, bodies, walls, lists, rates, dt)
    }

    /// Leapfrog step of `dt` (s) with velocity, density and stress at half steps, as in the literature.
    fn leapfrog_rates(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, saved_state: kept, .. } = self;
        kept.save(bodies);
        if clock.last_step > 0.0 {
            // From n - 1/2 to n with the rates of the previous step.
            let half = 0.5 * clock.last_step;
            add_accelerations(setting, clock, bodies, &rates.derivatives.acceleration, half, half);
            update_stress(setting, clock, bodies, &rates.derivatives, half, StageTime::Start)?;
            update_body_forces(clock, bodies)?;
        }
        update_accelerations(setting, clock, bodies, walls, lists, rates, dt);
        find_rates(setting, bodies, walls, lists, rates, (dt, 0.0));
        kept.restore(bodies);
        let step = 0.5 * (clock.last_step + dt);
        diffuse_stress(setting, clock, bodies, walls, lists, rates, step);
        add_accelerations(setting, clock, bodies, &rates.derivatives.acceleration, step, step);
        update_stress(setting, clock, bodies, &rates.derivatives, step, StageTime::Middle)?;
        drift(setting, clock, bodies, walls, lists, rates, dt)
    }

    /// Predictor–corrector step of `dt` (s), with rates at the start and the middle of the step.
    fn predictor_corrector(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, saved_state: kept, .. } = self;
        let half = 0.5 * dt;
        kept.save(bodies);
        update_accelerations(setting, clock, bodies, walls, lists, rates, dt);
        find_rates(setting, bodies, walls, lists, rates, (dt, 0.0));
        drift(setting, clock, bodies, walls, lists, rates, half)?;
        add_accelerations(setting, clock, bodies, &rates.derivatives.acceleration, half, half);
        update_stress(setting, clock, bodies, &rates.derivatives, half, StageTime::Start)?;
        let middle = Clock { time: clock.time + half, ..*clock };
        lists.refresh(setting, &middle, bodies, walls, rates, false)?;
        update_body_forces(&middle, bodies)?;
        update_accelerations(setting, &middle, bodies, walls, lists, rates, half);
        find_rates(setting, bodies, walls, lists, rates, (dt, 0.0));
        let len = bodies.particles.len();
        bodies.particles.position[..len].copy_from_slice(&kept.position);
        // The predicted velocities move the particles.
        drift(setting, clock, bodies, walls, lists, rates, dt)?;
        kept.restore(bodies);
        diffuse_stress(setting, clock, bodies, walls, lists, rates, dt);
        add_accelerations(setting, clock, bodies, &rates.derivatives.acceleration, dt, dt);
        update_stress(setting, clock, bodies, &rates.derivatives, dt, StageTime::Middle)
    }

    /// Position Verlet step of `dt` (s): half drift, full velocity update, half drift.
    fn position_verlet(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, .. } = self;
        let half = 0.5 * dt;
        update_pair_data(setting, clock, bodies, walls, lists);
        update_strain(setting, clock, bodies, walls, lists, rates, half)?;
        drift(setting, clock, bodies, walls, lists, rates, half)?;
        let middle = Clock { time: clock.time + half, ..*clock };
        lists.refresh(setting, &middle, bodies, walls, rates, false)?;
        update_body_forces(&middle, bodies)?;
        update_accelerations(setting, &middle, bodies, walls, lists, rates, half);
        add_accelerations(setting, &middle, bodies, &rates.derivatives.acceleration, dt, dt);
        update_strain(setting, &middle, bodies, walls, lists, rates, half)?;
        drift(setting, clock, bodies, walls, lists, rates, half)
    }

    /// Velocity Verlet step of `dt` (s): half velocity update, drift, half velocity update.
    fn velocity_verlet(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, .. } = self;
        if rates.is_current {
            update_pair_data(setting, clock, bodies, walls, lists);
        } else {
            update_accelerations(setting, clock, bodies, walls, lists, rates, 0.0);
        }
        let half = 0.5 * dt;
        add_accelerations(setting, clock, bodies, &rates.derivatives.acceleration, half, half);
        update_strain(setting, clock, bodies, walls, lists, rates, dt)?;
        drift(setting, clock, bodies, walls, lists, rates, dt)?;
        let end = Clock { time: clock.time + dt, ..*clock };
        lists.refresh(setting, &end, bodies, walls, rates, false)?;
        update_body_forces(&end, bodies)?;
        update_accelerations(setting, &end, bodies, walls, lists, rates, 0.0);
        add_accelerations(setting, clock, bodies, &rates.derivatives.acceleration, half, half);
        Ok(())
    }

    /// Verlet step of `dt` (s): velocities over two steps, and over one step at regular intervals.
    fn verlet(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, saved_state: kept, .. } = self;
        update_accelerations(setting, clock, bodies, walls, lists, rates, dt);
        let len = bodies.particles.len();
        let SavedState { velocity: before, transport_velocity: after, .. } = kept;
        copy(before, &bodies.particles.velocity[..len]);
        let plain = bodies.particles.previous.len() != len || clock.step.is_multiple_of(STEPS_PER_PLAIN);
        let step = if plain { dt } else { clock.last_step + dt };
        if !plain {
            let p = &mut bodies.particles;
            p.velocity[..len].copy_from_slice(&p.previous);
        }
        add_accelerations(setting, clock, bodies, &rates.derivatives.acceleration, step, step);
        // Strain by the mean of the velocities at the start and the end of the step.
        copy(after, &bodies.particles.velocity[..len]);
        add(&mut bodies.particles.velocity[..len], 1.0, before);
        bodies.particles.velocity[..len].as_flattened_mut().iter_mut().for_each(|v| *v *= 0.5);
        update_pair_velocities(bodies);
        update_strain(setting, clock, bodies, walls, lists, rates, dt)?;
        // x + dt v + dt² a / 2.
        bodies.particles.velocity[..len].copy_from_slice(before);
        add(&mut bodies.particles.velocity[..len], 0.5 * dt, &rates.derivatives.acceleration);
        bodies.impose_held_velocities();
        drift(setting, clock, bodies, walls, lists, rates, dt)?;
        bodies.particles.velocity[..len].copy_from_slice(after);
        copy(&mut bodies.particles.previous, before);
        Ok(())
    }

    /// Fourth-order Runge–Kutta step of `dt` (s).
    fn runge_kutta(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, rates, saved_state: kept, .. } = self;
        let len = bodies.particles.len();
        kept.save(bodies);
        kept.clear_means(len);
        for (fraction, share) in [(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)] {
            if fraction > 0.0 {
                let step = fraction * dt;
                copy(&mut kept.stage_velocity, &bodies.particles.velocity[..len]);
                kept.restore(bodies);
                add_accelerations(setting, clock, bodies, &rates.derivatives.acceleration, step, step);
                update_stress(setting, clock, bodies, &rates.derivatives, step, StageTime::Start)?;
                bodies.particles.position[..len].copy_from_slice(&kept.position);
                add(&mut bodies.particles.position[..len], step, &kept.stage_velocity);
                rates.is_current = false;
            }
            let now = Clock { time: clock.time + fraction * dt, ..*clock };
            lists.refresh(setting, &now, bodies, walls, rates, false)?;
            update_body_forces(&now, bodies)?;
            update_accelerations(setting, &now, bodies, walls, lists, rates, 0.0);
            find_rates(setting, bodies, walls, lists, rates, (dt, 0.0));
            kept.add_rates(share, &bodies.particles.velocity[..len], rates);
        }
        kept.restore(bodies);
        diffuse_stress(setting, clock, bodies, walls, lists, rates, dt);
        let p = &mut bodies.particles;
        p.position[..len].copy_from_slice(&kept.position);
        p.velocity[..len].copy_from_slice(&kept.transport_velocity);
        rates.xsph_velocity.clear();
        rates.derivatives.gradient.copy_from_slice(&kept.gradient);
        rates.derivatives.divergence.copy_from_slice(&kept.divergence);
        drift(setting, clock, bodies, walls, lists, rates, dt)?;
        bodies.particles.velocity[..len].copy_from_slice(&kept.velocity);
        rates.derivatives.acceleration.copy_from_slice(&kept.mean_acceleration);
        add_accelerations(setting, clock, bodies, &rates.derivatives.acceleration, dt, dt);
        update_stress(setting, clock, bodies, &rates.derivatives, dt, StageTime::Middle)
    }
}
