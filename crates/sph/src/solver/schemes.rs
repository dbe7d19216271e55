//! Time integration (SPH sheet §3.3).

use colluvium_case::SolverError;
use colluvium_constitutive::{States, SymTensor};

use super::{Over, SphSolver};
use crate::config::TimeIntegration;
use crate::particles::Matrix;

/// Steps of the Verlet scheme between two plain ones, which keep odd and even steps together.
const STEPS_PER_PLAIN: u64 = 40;

/// What a step keeps besides the state; in memory of its own from step to step.
#[derive(Default)]
pub struct Kept<const D: usize> {
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
    /// Mean velocities with which particles move (m/s), or those at the end of the step.
    moved: Vec<[f64; D]>,
    /// Velocities of a stage of the step (m/s).
    staged: Vec<[f64; D]>,
    /// Mean accelerations (m/s²).
    kicked: Vec<[f64; D]>,
    /// Mean velocity gradients (1/s).
    gradient: Vec<Matrix<D>>,
    /// Mean divergences (1/s).
    divergence: Vec<f64>,
}

/// A copy in memory that is there already.
fn copy<T: Copy>(to: &mut Vec<T>, from: &[T]) {
    to.clear();
    to.extend_from_slice(from);
}

/// As many of a value in memory that is there already.
fn fill<T: Copy>(to: &mut Vec<T>, value: T, len: usize) {
    to.clear();
    to.resize(len, value);
}

fn add<const D: usize>(to: &mut [[f64; D]], factor: f64, what: &[[f64; D]]) {
    to.iter_mut().zip(what).for_each(|(a, b)| (0..D).for_each(|c| a[c] += factor * b[c]));
}

fn add_matrix<const D: usize>(to: &mut [Matrix<D>], factor: f64, what: &[Matrix<D>]) {
    add(to.as_flattened_mut(), factor, what.as_flattened());
}

impl<const D: usize> SphSolver<D> {
    /// Advances the state, not the time.
    pub(crate) fn integrate(&mut self, dt: f64) -> Result<(), SolverError> {
        match self.options.integration {
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

    /// Whether the velocities stand half a step behind the positions.
    pub(crate) fn lags(&self) -> bool {
        matches!(self.options.integration, TimeIntegration::Leapfrog | TimeIntegration::LeapfrogRates)
    }

    fn leapfrog(&mut self, dt: f64) -> Result<(), SolverError> {
        self.derive(dt); // 1–4
        self.kick(0.5 * (self.last_step + dt), dt); // 5
        self.strain(dt)?; // 6–8
        self.drift(dt) // 9
    }

    /// Velocity gradients, densities and stresses.
    fn strain(&mut self, dt: f64) -> Result<(), SolverError> {
        self.find_rates(dt);
        self.diffuse_stress(dt);
        self.update_stress(dt, Over::Start)
    }

    /// The state now; given back to `kept` where it is no longer needed.
    fn start(&mut self) -> Kept<D> {
        let mut start = std::mem::take(&mut self.kept);
        let p = &self.particles;
        copy(&mut start.position, &p.position[..p.len]);
        copy(&mut start.velocity, &p.velocity[..p.len]);
        copy(&mut start.density, &p.density[..p.len]);
        copy(&mut start.stress, &p.stress[..p.len]);
        start.states.resize_with(self.groups.len(), States::default);
        start.states.iter_mut().zip(&self.groups).for_each(|(kept, group)| kept.clone_from(&group.states));
        start
    }

    /// Back to the start: velocities, densities and stresses, and the states of the laws.
    fn go_back(&mut self, start: &Kept<D>) {
        let p = &mut self.particles;
        let len = p.len;
        p.velocity[..len].copy_from_slice(&start.velocity);
        p.density[..len].copy_from_slice(&start.density);
        p.stress[..len].copy_from_slice(&start.stress);
        for (group, states) in self.groups.iter_mut().zip(&start.states) {
            group.states.clone_from(states);
        }
    }

    /// The source's leapfrog: velocity, density and stress at half steps.
    fn leapfrog_rates(&mut self, dt: f64) -> Result<(), SolverError> {
        let start = self.start();
        if self.last_step > 0.0 {
            // From n - 1/2 to n with the rates of the step before.
            let half = 0.5 * self.last_step;
            self.kick(half, half);
            self.update_stress(half, Over::Start)?;
        }
        self.derive(dt);
        self.find_rates(dt);
        self.go_back(&start);
        self.kept = start;
        let step = 0.5 * (self.last_step + dt);
        self.diffuse_stress(step);
        self.kick(step, step);
        self.update_stress(step, Over::Middle)?;
        self.drift(dt)
    }

    fn predictor_corrector(&mut self, dt: f64) -> Result<(), SolverError> {
        let start = self.start();
        self.derive(dt);
        self.find_rates(dt);
        self.drift(0.5 * dt)?;
        self.kick(0.5 * dt, 0.5 * dt);
        self.update_stress(0.5 * dt, Over::Start)?;
        let time = self.time;
        self.time += 0.5 * dt;
        self.refresh_neighbours(false)?;
        self.derive(0.5 * dt);
        self.find_rates(dt);
        self.time = time;
        let len = self.particles.len;
        self.particles.position[..len].copy_from_slice(&start.position);
        // The predicted velocities move the particles.
        self.drift(dt)?;
        self.go_back(&start);
        self.kept = start;
        self.diffuse_stress(dt);
        self.kick(dt, dt);
        self.update_stress(dt, Over::Middle)
    }

    fn position_verlet(&mut self, dt: f64) -> Result<(), SolverError> {
        let half = 0.5 * dt;
        self.load_records();
        self.strain(half)?;
        self.drift(half)?;
        let time = self.time;
        self.time += half;
        self.refresh_neighbours(false)?;
        self.derive(half);
        self.kick(dt, dt);
        self.strain(half)?;
        self.time = time;
        self.drift(half)
    }

    fn velocity_verlet(&mut self, dt: f64) -> Result<(), SolverError> {
        if !self.accelerated {
            self.derive(0.0);
        } else {
            self.load_records();
        }
        let half = 0.5 * dt;
        self.kick(half, half);
        self.strain(dt)?;
        self.drift(dt)?;
        let time = self.time;
        self.time += dt;
        self.refresh_neighbours(false)?;
        self.derive(0.0);
        self.time = time;
        self.kick(half, half);
        Ok(())
    }

    fn verlet(&mut self, dt: f64) -> Result<(), SolverError> {
        self.derive(dt);
        let len = self.particles.len;
        let Kept { velocity: mut before, moved: mut after, .. } = std::mem::take(&mut self.kept);
        copy(&mut before, &self.particles.velocity[..len]);
        let plain = self.particles.previous.len() != len || self.step.is_multiple_of(STEPS_PER_PLAIN);
        let mut previous = std::mem::take(&mut self.particles.previous);
        if plain {
            self.kick(dt, dt);
        } else {
            self.particles.velocity[..len].copy_from_slice(&previous);
            self.kick(self.last_step + dt, self.last_step + dt);
        }
        // Strain by the mean of the velocities at both ends of the step.
        copy(&mut after, &self.particles.velocity[..len]);
        add(&mut self.particles.velocity[..len], 1.0, &before);
        self.particles.velocity[..len].as_flattened_mut().iter_mut().for_each(|v| *v *= 0.5);
        self.show_velocities();
        self.strain(dt)?;
        // x + dt v + dt² a / 2.
        self.particles.velocity[..len].copy_from_slice(&before);
        let accelerations = std::mem::take(&mut self.particles.acceleration);
        add(&mut self.particles.velocity[..len], 0.5 * dt, &accelerations);
        self.particles.acceleration = accelerations;
        self.hold();
        self.drift(dt)?;
        self.particles.velocity[..len].copy_from_slice(&after);
        copy(&mut previous, &before);
        self.particles.previous = previous;
        self.kept = Kept { velocity: before, moved: after, ..Kept::default() };
        Ok(())
    }

    fn runge_kutta(&mut self, dt: f64) -> Result<(), SolverError> {
        let mut start = self.start();
        let (len, time) = (self.particles.len, self.time);
        fill(&mut start.moved, [0.0; D], len);
        fill(&mut start.kicked, [0.0; D], len);
        fill(&mut start.gradient, [[0.0; D]; D], len);
        fill(&mut start.divergence, 0.0, len);
        for (fraction, share) in [(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)] {
            if fraction > 0.0 {
                let step = fraction * dt;
                copy(&mut start.staged, &self.particles.velocity[..len]);
                self.go_back(&start);
                self.kick(step, step);
                self.update_stress(step, Over::Start)?;
                self.particles.position[..len].copy_from_slice(&start.position);
                add(&mut self.particles.position[..len], step, &start.staged);
                self.accelerated = false;
            }
            self.time = time + fraction * dt;
            self.refresh_neighbours(false)?;
            self.derive(0.0);
            self.find_rates(dt);
            let p = &self.particles;
            add(&mut start.moved, share, &p.velocity[..len]);
            add(&mut start.moved, share, &p.drift);
            add(&mut start.kicked, share, &p.acceleration);
            add_matrix(&mut start.gradient, share, &p.gradient);
            start.divergence.iter_mut().zip(&p.divergence).for_each(|(sum, d)| *sum += share * d);
        }
        self.time = time;
        self.go_back(&start);
        self.diffuse_stress(dt);
        let p = &mut self.particles;
        p.position[..len].copy_from_slice(&start.position);
        p.velocity[..len].copy_from_slice(&start.moved);
        p.drift.clear();
        std::mem::swap(&mut p.gradient, &mut start.gradient);
        std::mem::swap(&mut p.divergence, &mut start.divergence);
        self.drift(dt)?;
        self.particles.velocity[..len].copy_from_slice(&start.velocity);
        std::mem::swap(&mut self.particles.acceleration, &mut start.kicked);
        self.kept = start;
        self.kick(dt, dt);
        self.update_stress(dt, Over::Middle)
    }
}
