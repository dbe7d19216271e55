//! Time integration: leapfrog, midpoint rule, classical fourth order (sheet: depth-sph §3.4).

use rayon::prelude::*;

use super::set::{Set, TASK};
use super::{Asked, Failure, Flow};
use crate::choices::{Continuity, Integration, Phases};
use crate::kernel::Kernel;
use crate::nodes::{Plan, dot};

/// State of a set at the beginning of a step, and what the stages have summed up.
#[derive(Clone, Debug, Default)]
struct Stages<const D: usize> {
    position: Vec<Plan<D>>,
    velocity: Vec<Plan<D>>,
    height: Vec<f64>,
    rates: [Vec<Plan<D>>; 2],
    height_rate: Vec<f64>,
}

impl<const D: usize> Flow<D> {
    /// Positions and velocities over a step, with drag and the resistance of the bed.
    pub(super) fn integrate(&mut self, dt: f64) -> Result<(), Failure> {
        match self.settings.numerics.integration {
            Integration::Leapfrog => self.leap(dt),
            Integration::RungeKutta2 => self.run(dt, &[(0.0, 0.0), (0.5, 1.0)]),
            Integration::RungeKutta4 => {
                self.run(dt, &[(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)])
            }
        }
    }

    /// Half a drift, a kick, half a drift.
    fn leap(&mut self, dt: f64) -> Result<(), Failure> {
        self.smooth_velocities()?;
        self.drift_in(0.5 * dt);
        if self.settings.phases == Phases::Two {
            self.sets.iter_mut().for_each(|set| set.before.clone_from(&set.nodes.velocity));
        }
        self.evaluate(dt, Some(self.time + 0.5 * dt), Asked::Before)?;
        self.keep_unkicked();
        #[cfg(test)]
        self.break_pressure();
        for set in &mut self.sets {
            let kicks = set.nodes.velocity.par_iter_mut().zip(&set.acceleration);
            kicks.with_min_len(TASK).for_each(|(v, a)| {
                for c in 0..D {
                    v[c] += dt * a[c];
                }
            });
        }
        self.resist(dt);
        #[cfg(test)]
        self.break_resistance(dt);
        self.hold();
        self.book_step(dt);
        if self.settings.numerics.continuity.is_rate() {
            self.find_rates();
            for set in &mut self.sets {
                for (height, rate) in set.nodes.height.iter_mut().zip(&set.rate) {
                    *height += dt * rate;
                }
            }
        }
        self.smooth_velocities()?;
        self.drift_out(0.5 * dt);
        Ok(())
    }

    /// Drag and the resistance of the bed.
    fn resist(&mut self, dt: f64) {
        match self.settings.phases {
            Phases::One => self.resist_single(dt),
            Phases::Two => {
                self.sets.iter_mut().for_each(Set::turn_images);
                self.couple(dt);
            }
            Phases::Layers => {
                self.resist_single(dt);
                self.rub_layers(dt);
            }
        }
    }

    /// Velocities that nodes drift with, their own and a share of the mean around, where that is asked for (XSPH).
    fn smooth_velocities(&mut self) -> Result<(), Failure> {
        if self.settings.numerics.xsph == 0.0 {
            return Ok(());
        }
        self.find_neighbours()?;
        let (kernel, share) = (self.settings.numerics.kernel, self.settings.numerics.xsph);
        for set in &mut self.sets {
            set.raise_images();
            let (seen, near) = (&set.seen, &set.near);
            let smooth = |i: usize| -> Plan<D> {
                let mut v = seen.velocity[i];
                for &j in near.of(i) {
                    let j = j as usize;
                    let apart: Plan<D> = std::array::from_fn(|c| seen.position[i][c] - seen.position[j][c]);
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
            (0..count).into_par_iter().with_min_len(TASK).map(smooth).collect_into_vec(&mut set.spare);
        }
        Ok(())
    }

    /// An explicit Runge–Kutta step: of each stage where it stands and what it weighs.
    fn run(&mut self, dt: f64, stages: &[(f64, f64)]) -> Result<(), Failure> {
        if self.settings.phases == Phases::Two {
            self.sets.iter_mut().for_each(|set| set.before.clone_from(&set.nodes.velocity));
        }
        let rates = self.settings.numerics.continuity.is_rate();
        let mut kept: Vec<Stages<D>> = self.sets.iter().map(Stages::of).collect();
        for (number, (place, weight)) in stages.iter().enumerate() {
            if number > 0 {
                for (set, kept) in self.sets.iter_mut().zip(&kept) {
                    kept.put(set, place * dt, rates);
                }
                self.reflect();
            }
            // Pore pressure is that of the beginning of the step.
            self.evaluate(dt, (number == 0).then_some(self.time), Asked::Now)?;
            if rates {
                self.find_rates();
            }
            self.book_stage(weight * dt);
            for (set, kept) in self.sets.iter_mut().zip(&mut kept) {
                kept.add(set, weight * dt, rates);
            }
        }
        for (set, kept) in self.sets.iter_mut().zip(kept) {
            kept.finish(set, rates);
        }
        self.reflect();
        self.keep_unkicked();
        self.resist(dt);
        self.hold();
        self.book_resistance();
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

    /// Rates of height by one of the forms of the sheet (m/s).
    fn find_rates(&mut self) {
        let (kernel, form) = (self.settings.numerics.kernel, self.settings.numerics.continuity);
        for set in &mut self.sets {
            set.turn_images();
            set.find_rates(kernel, form);
        }
    }
}

#[cfg(test)]
impl<const D: usize> Flow<D> {
    /// Multiplies pressure by the factor of a test.
    fn break_pressure(&mut self) {
        let (factor, drive) = (self.faults[1] - 1.0, self.settings.drive);
        for set in &mut self.sets {
            for (i, a) in set.acceleration.iter_mut().enumerate() {
                let (bed, viscous) = (&set.bed[i], &set.viscous[i]);
                for c in 0..D {
                    a[c] += factor * (a[c] - viscous[c] + set.reaction[i] * bed.slope[c] - drive[c]);
                }
            }
        }
    }

    /// Multiplies what has resisted the kick by the factor of a test.
    fn break_resistance(&mut self, dt: f64) {
        let factor = self.faults[0];
        for set in &mut self.sets {
            for (i, v) in set.nodes.velocity.iter_mut().enumerate() {
                for c in 0..D {
                    let kicked = set.unkicked[i][c] + dt * set.acceleration[i][c];
                    v[c] = kicked + factor * (v[c] - kicked);
                }
            }
        }
    }
}

impl<const D: usize> Set<D> {
    fn find_rates(&mut self, kernel: Kernel, form: Continuity) {
        let (seen, near) = (&self.seen, &self.near);
        let rate = |i: usize| -> f64 {
            let (x, v, height) = (&seen.position[i], &seen.velocity[i], seen.height[i]);
            let pair = |&j: &u32| {
                let j = j as usize;
                let apart: Plan<D> = std::array::from_fn(|c| x[c] - seen.position[j][c]);
                let relative: Plan<D> = std::array::from_fn(|c| v[c] - seen.velocity[j][c]);
                let mean = 0.5 * (seen.length[i] + seen.length[j]);
                let gradient = kernel.gradient::<D>(dot(&apart, &apart).sqrt(), mean);
                let volume = seen.volume[j];
                gradient
                    * match form {
                        Continuity::RateDifference => volume * dot(&relative, &apart),
                        Continuity::RateVolume => height * volume / seen.height[j] * dot(&relative, &apart),
                        _ => -height * volume / seen.height[j] * dot(&seen.velocity[j], &apart),
                    }
            };
            near.of(i).iter().map(pair).sum()
        };
        let count = self.nodes.len();
        (0..count).into_par_iter().with_min_len(TASK).map(rate).collect_into_vec(&mut self.rate);
    }
}

impl<const D: usize> Stages<D> {
    fn of(set: &Set<D>) -> Self {
        let zero = vec![[0.0; D]; set.nodes.len()];
        Self {
            position: set.nodes.position.clone(),
            velocity: set.nodes.velocity.clone(),
            height: set.nodes.height.clone(),
            height_rate: vec![0.0; zero.len()],
            rates: [zero.clone(), zero],
        }
    }

    /// The state after `dt` (s) under the rates of the stage before. Heights that are sums are left to the next sum.
    fn put(&self, set: &mut Set<D>, dt: f64, with_heights: bool) {
        let nodes = &mut set.nodes;
        for i in 0..nodes.len() {
            for c in 0..D {
                nodes.position[i][c] = self.position[i][c] + dt * nodes.velocity[i][c];
                nodes.velocity[i][c] = self.velocity[i][c] + dt * set.acceleration[i][c];
            }
            if with_heights {
                nodes.height[i] = self.height[i] + dt * set.rate[i];
            }
        }
    }

    /// Adds a stage.
    fn add(&mut self, set: &Set<D>, dt: f64, with_heights: bool) {
        for i in 0..set.nodes.len() {
            for c in 0..D {
                self.rates[0][i][c] += dt * set.nodes.velocity[i][c];
                self.rates[1][i][c] += dt * set.acceleration[i][c];
            }
            if with_heights {
                self.height_rate[i] += dt * set.rate[i];
            }
        }
    }

    /// The end of the step. Heights that are sums stay those of the last stage.
    fn finish(self, set: &mut Set<D>, with_heights: bool) {
        let nodes = &mut set.nodes;
        for i in 0..nodes.len() {
            for c in 0..D {
                nodes.position[i][c] = self.position[i][c] + self.rates[0][i][c];
                nodes.velocity[i][c] = self.velocity[i][c] + self.rates[1][i][c];
            }
            if with_heights {
                nodes.height[i] = self.height[i] + self.height_rate[i];
            }
        }
    }
}
