//! Time integration: leapfrog, midpoint rule, classical fourth order (sheet: depth-sph §3.4).

use rayon::prelude::*;

use crate::config::choices::{Phases, ThicknessEquation, TimeScheme};
use crate::flow::{BedSampling, Flow, FlowFailure};
use crate::neighbours::kernel::Kernel;
use crate::phases::phase::{PhaseSet, TASK};
use crate::phases::phase_nodes::{PlanVector, dot};

/// State of a set at the beginning of a step, and the sums of the stages.
#[derive(Clone, Debug, Default)]
struct StageSums<const D: usize> {
    position: Vec<PlanVector<D>>,
    velocity: Vec<PlanVector<D>>,
    partial_thickness: Vec<f64>,
    rates: [Vec<PlanVector<D>>; 2],
    thickness_rate: Vec<f64>,
}

impl<const D: usize> Flow<D> {
    /// Integrates positions and velocities over a step, with drag and the resistance of the bed.
    pub(crate) fn integrate(&mut self, dt: f64) -> Result<(), FlowFailure> {
        match self.settings.numerics.integration {
            TimeScheme::Leapfrog => self.leapfrog(dt),
            TimeScheme::RungeKutta2 => self.runge_kutta(dt, &[(0.0, 0.0), (0.5, 1.0)]),
            TimeScheme::RungeKutta4 => self
                .runge_kutta(dt, &[(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)]),
        }
    }

    /// Leapfrog step: half a drift, a kick, half a drift.
    fn leapfrog(&mut self, dt: f64) -> Result<(), FlowFailure> {
        self.smooth_velocities()?;
        self.first_half_drift(0.5 * dt);
        if self.settings.phases == Phases::Two {
            self.sets.iter_mut().for_each(|set| set.start_velocity.clone_from(&set.nodes.velocity));
        }
        self.evaluate(dt, Some(self.time + 0.5 * dt), BedSampling::Before)?;
        self.store_velocities();
        #[cfg(test)]
        self.scale_pressure_for_test();
        for set in &mut self.sets {
            let kicks = set.nodes.velocity.par_iter_mut().zip(&set.acceleration);
            kicks.with_min_len(TASK).for_each(|(v, a)| {
                for c in 0..D {
                    v[c] += dt * a[c];
                }
            });
        }
        self.apply_resistance(dt);
        #[cfg(test)]
        self.scale_resistance_for_test(dt);
        self.hold_inflow_velocities();
        self.add_step_work(dt);
        if self.settings.numerics.continuity.is_rate() {
            self.find_rates();
            for set in &mut self.sets {
                for (height, rate) in set.nodes.partial_thickness.iter_mut().zip(&set.rate) {
                    *height += dt * rate;
                }
            }
        }
        self.smooth_velocities()?;
        self.second_half_drift(0.5 * dt);
        Ok(())
    }

    /// Applies drag and the resistance of the bed.
    fn apply_resistance(&mut self, dt: f64) {
        match self.settings.phases {
            Phases::One => self.apply_resistance_single(dt),
            Phases::Two => {
                self.sets.iter_mut().for_each(PhaseSet::update_image_velocities);
                self.apply_drag_and_resistance(dt);
            }
            Phases::Layers => {
                self.apply_resistance_single(dt);
                self.interface_friction(dt);
            }
        }
    }

    /// Drift velocities of the nodes, their own and a share of the mean around, where that is chosen (XSPH).
    fn smooth_velocities(&mut self) -> Result<(), FlowFailure> {
        if self.settings.numerics.xsph == 0.0 {
            return Ok(());
        }
        self.find_neighbours()?;
        let (kernel, share) = (self.settings.numerics.kernel, self.settings.numerics.xsph);
        for set in &mut self.sets {
            set.update_image_thickness();
            let (seen, near) = (&set.neighbour_data, &set.same_phase_neighbours);
            let smooth = |i: usize| -> PlanVector<D> {
                let mut v = seen.velocity[i];
                for &j in near.neighbours(i) {
                    let j = j as usize;
                    let apart: PlanVector<D> =
                        std::array::from_fn(|c| seen.position[i][c] - seen.position[j][c]);
                    let mean = 0.5 * (seen.length[i] + seen.length[j]);
                    let weight = 2.0 * seen.volume[j] / (seen.height[i] + seen.height[j])
                        * kernel.value::<D>(dot(&apart, &apart).sqrt(), mean);
                    for c in 0..D {
                        v[c] += share * weight * (seen.velocity[j][c] - seen.velocity[i][c]);
                    }
                }
                v
            };
            let count = set.nodes.len();
            (0..count)
                .into_par_iter()
                .with_min_len(TASK)
                .map(smooth)
                .collect_into_vec(&mut set.scratch_vectors);
        }
        Ok(())
    }

    /// Explicit Runge–Kutta step: each stage with its time and its weight.
    fn runge_kutta(&mut self, dt: f64, stages: &[(f64, f64)]) -> Result<(), FlowFailure> {
        if self.settings.phases == Phases::Two {
            self.sets.iter_mut().for_each(|set| set.start_velocity.clone_from(&set.nodes.velocity));
        }
        let rates = self.settings.numerics.continuity.is_rate();
        let mut kept: Vec<StageSums<D>> = self.sets.iter().map(StageSums::of).collect();
        for (number, (place, weight)) in stages.iter().enumerate() {
            if number > 0 {
                for (set, kept) in self.sets.iter_mut().zip(&kept) {
                    kept.put(set, place * dt, rates);
                }
                self.reflect();
            }
            // Pore pressure stays that of the beginning of the step.
            self.evaluate(dt, (number == 0).then_some(self.time), BedSampling::Now)?;
            if rates {
                self.find_rates();
            }
            self.add_stage_work(weight * dt);
            for (set, kept) in self.sets.iter_mut().zip(&mut kept) {
                kept.add(set, weight * dt, rates);
            }
        }
        for (set, kept) in self.sets.iter_mut().zip(kept) {
            kept.finish(set, rates);
        }
        self.reflect();
        self.store_velocities();
        self.apply_resistance(dt);
        self.hold_inflow_velocities();
        self.add_resistance_work();
        Ok(())
    }

    fn reflect(&mut self) {
        let Self { ends, sets, .. } = self;
        if ends.are_open() {
            return;
        }
        for set in sets {
            for (x, v) in set.nodes.position.iter_mut().zip(&mut set.nodes.velocity) {
                ends.reflect(x, v);
            }
        }
    }

    /// Computes rates of height by one of the forms of the sheet (m/s).
    fn find_rates(&mut self) {
        let (kernel, form) = (self.settings.numerics.kernel, self.settings.numerics.continuity);
        for set in &mut self.sets {
            set.update_image_velocities();
            set.find_rates(kernel, form);
        }
    }
}

#[cfg(test)]
impl<const D: usize> Flow<D> {
    /// Multiplies pressure by the factor of a test.
    fn scale_pressure_for_test(&mut self) {
        let (factor, drive) = (self.test_factors[1] - 1.0, self.settings.plan_gravity);
        for set in &mut self.sets {
            for (i, a) in set.acceleration.iter_mut().enumerate() {
                let (bed, viscous) = (&set.bed[i], &set.viscous[i]);
                for c in 0..D {
                    a[c] += factor * (a[c] - viscous[c] + set.reaction[i] * bed.slope[c] - drive[c]);
                }
            }
        }
    }

    /// Multiplies the resistance to the kick by the factor of a test.
    fn scale_resistance_for_test(&mut self, dt: f64) {
        let factor = self.test_factors[0];
        for set in &mut self.sets {
            for (i, v) in set.nodes.velocity.iter_mut().enumerate() {
                for c in 0..D {
                    let kicked = set.stored_velocity[i][c] + dt * set.acceleration[i][c];
                    v[c] = kicked + factor * (v[c] - kicked);
                }
            }
        }
    }
}

impl<const D: usize> PhaseSet<D> {
    fn find_rates(&mut self, kernel: Kernel, form: ThicknessEquation) {
        let (seen, near) = (&self.neighbour_data, &self.same_phase_neighbours);
        let rate = |i: usize| -> f64 {
            let (x, v, height) = (&seen.position[i], &seen.velocity[i], seen.height[i]);
            let pair = |&j: &u32| {
                let j = j as usize;
                let apart: PlanVector<D> = std::array::from_fn(|c| x[c] - seen.position[j][c]);
                let relative: PlanVector<D> = std::array::from_fn(|c| v[c] - seen.velocity[j][c]);
                let mean = 0.5 * (seen.length[i] + seen.length[j]);
                let gradient = kernel.gradient::<D>(dot(&apart, &apart).sqrt(), mean);
                let volume = seen.volume[j];
                gradient
                    * match form {
                        ThicknessEquation::RateDifference => volume * dot(&relative, &apart),
                        ThicknessEquation::RateVolume => {
                            height * volume / seen.height[j] * dot(&relative, &apart)
                        }
                        _ => -height * volume / seen.height[j] * dot(&seen.velocity[j], &apart),
                    }
            };
            near.neighbours(i).iter().map(pair).sum()
        };
        let count = self.nodes.len();
        (0..count).into_par_iter().with_min_len(TASK).map(rate).collect_into_vec(&mut self.rate);
    }
}

impl<const D: usize> StageSums<D> {
    fn of(set: &PhaseSet<D>) -> Self {
        let zero = vec![[0.0; D]; set.nodes.len()];
        Self {
            position: set.nodes.position.clone(),
            velocity: set.nodes.velocity.clone(),
            partial_thickness: set.nodes.partial_thickness.clone(),
            thickness_rate: vec![0.0; zero.len()],
            rates: [zero.clone(), zero],
        }
    }

    /// Sets the state after `dt` (s) under the rates of the stage before. Heights by summation are left to the next sum.
    fn put(&self, set: &mut PhaseSet<D>, dt: f64, with_heights: bool) {
        let nodes = &mut set.nodes;
        for i in 0..nodes.len() {
            for c in 0..D {
                nodes.position[i][c] = self.position[i][c] + dt * nodes.velocity[i][c];
                nodes.velocity[i][c] = self.velocity[i][c] + dt * set.acceleration[i][c];
            }
            if with_heights {
                nodes.partial_thickness[i] = self.partial_thickness[i] + dt * set.rate[i];
            }
        }
    }

    /// Adds a stage.
    fn add(&mut self, set: &PhaseSet<D>, dt: f64, with_heights: bool) {
        for i in 0..set.nodes.len() {
            for c in 0..D {
                self.rates[0][i][c] += dt * set.nodes.velocity[i][c];
                self.rates[1][i][c] += dt * set.acceleration[i][c];
            }
            if with_heights {
                self.thickness_rate[i] += dt * set.rate[i];
            }
        }
    }

    /// Sets the state at the end of the step. Heights by summation stay those of the last stage.
    fn finish(self, set: &mut PhaseSet<D>, with_heights: bool) {
        let nodes = &mut set.nodes;
        for i in 0..nodes.len() {
            for c in 0..D {
                nodes.position[i][c] = self.position[i][c] + self.rates[0][i][c];
                nodes.velocity[i][c] = self.velocity[i][c] + self.rates[1][i][c];
            }
            if with_heights {
                nodes.partial_thickness[i] = self.partial_thickness[i] + self.thickness_rate[i];
            }
        }
    }
}
