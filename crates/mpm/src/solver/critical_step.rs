//! Largest stable time step (sheet: mpm §2.10), limited by the motion of obstacles.

use colluvium_case::{StepLimit, TimeStep, limit_step_by_obstacles, spatial};
use colluvium_constitutive::{BLOCK_SIZE, StateBlock, States, SymTensor};
use rayon::prelude::*;

use crate::config::{StepCoefficients, StepCriterion};
use crate::points::pore_fluid::{PoreFluidConstants, critical_step, simple_steps};
use crate::points::vectors::square;
use crate::solver::MpmSolver;

/// Steps between re-evaluations of the critical time step.
pub(crate) const STEPS_PER_TIME_STEP: u64 = 10;

/// Largest displacement of an obstacle in a step (cells), with which contact begins before it has passed points.
const MAX_OBSTACLE_MOVE: f64 = 0.25;

/// The point with the smallest stable step.
#[derive(Clone, Copy)]
pub struct LimitingPoint {
    /// The step (s).
    pub dt: f64,
    /// Criterion that limits the step.
    pub limit: StepLimit,
    /// Number of the point's set.
    pub set: usize,
    /// Index of the limiting point in its set.
    pub point_index: usize,
}

impl LimitingPoint {
    /// Point with the smaller time step; of equal ones, that with the lower index.
    fn min(self, other: Self) -> Self {
        let other_first = (other.dt, other.set, other.point_index) < (self.dt, self.set, self.point_index);
        if other_first { other } else { self }
    }
}

/// Smallest of `none` and the values of `of_block` for the groups of points of a set. Its arguments are the index of the first point, the
/// stresses and the states.
fn min_over_blocks(
    stress: &[SymTensor],
    states: &States,
    none: LimitingPoint,
    of_block: &(dyn Fn(usize, &[SymTensor], &StateBlock) -> LimitingPoint + Sync),
) -> LimitingPoint {
    let blocks = stress.par_chunks(BLOCK_SIZE).zip(states.blocks()).enumerate();
    let limit = |(block, (stress, states)): (usize, (&[SymTensor], &StateBlock))| {
        of_block(block * BLOCK_SIZE, stress, states)
    };
    blocks.with_min_len(16).map(limit).reduce(|| none, LimitingPoint::min)
}

impl<const D: usize> MpmSolver<D> {
    /// Returns the largest stable step from the current state (sheet: mpm §2.10).
    pub(crate) fn critical_step(&mut self) -> TimeStep {
        if self.clock.limit.is_none() || self.clock.limit_age >= STEPS_PER_TIME_STEP {
            let fixed = self.clock.options.time_step;
            let courant = if fixed.is_some() { 1.0 } else { self.clock.options.courant };
            let limit = self.wave_limit(courant);
            let max_courant = courant.min(self.clock.options.surface_courant(D));
            self.clock.courant = fixed.map_or(max_courant, |step| max_courant * (step / limit.dt).min(1.0));
            self.clock.limit = Some(self.limit_by_obstacle_motion(limit).or_fixed(fixed));
            self.clock.limit_age = 0;
        }
        self.clock.limit.expect("set above")
    }

    /// Reduces the critical step so that no obstacle moves farther than [`MAX_OBSTACLE_MOVE`].
    fn limit_by_obstacle_motion(&self, critical: TimeStep) -> TimeStep {
        let max_displacement = MAX_OBSTACLE_MOVE * self.clock.options.cell_size;
        let until = (self.clock.time, max_displacement, STEPS_PER_TIME_STEP + 1);
        limit_step_by_obstacles(critical, self.boundary.moving_obstacles(), until)
    }

    /// Largest step that waves, motion and viscosity of the points permit at a Courant number; at 1 it is the critical step.
    pub(crate) fn wave_limit(&self, courant: f64) -> TimeStep {
        let bounds = self.clock.options.step_bounds(D, courant);
        let none = LimitingPoint { dt: f64::INFINITY, limit: StepLimit::NO_MOTION, set: 0, point_index: 0 };
        let mut smallest = none;
        for (number, set) in self.bodies.sets.iter().enumerate() {
            let of_block = |first: usize, stress: &[SymTensor], states: &StateBlock| {
                self.block_limit(bounds, number, first, stress, states)
            };
            smallest = smallest.min(min_over_blocks(&set.points.stress, &set.states, none, &of_block));
        }
        let point = self.bodies.sets.get(smallest.set).filter(|set| smallest.point_index < set.len());
        TimeStep {
            dt: smallest.dt,
            limit: smallest.limit,
            point: point.map(|set| u64::from(set.points.id[smallest.point_index])),
            position: point.map_or([0.0; 3], |set| spatial(&set.points.position[smallest.point_index])),
        }
    }

    /// Point with the smallest time step in a group of points.
    fn block_limit(
        &self,
        bounds: StepCoefficients,
        number: usize,
        first: usize,
        stress: &[SymTensor],
        states: &StateBlock,
    ) -> LimitingPoint {
        let set = &self.bodies.sets[number];
        let view = self.background.grid_view();
        let mut moduli = [0.0; BLOCK_SIZE];
        let mut viscosities = [0.0; BLOCK_SIZE];
        set.material.wave_moduli(stress, states, &mut moduli[..stress.len()]);
        set.material.viscosities(stress, states, &mut viscosities[..stress.len()]);
        let mut smallest =
            LimitingPoint { dt: f64::INFINITY, limit: StepLimit::NO_MOTION, set: number, point_index: first };
        let stiffening = self.obstacle_stiffening();
        for k in 0..stress.len() {
            let point_index = first + k;
            let h = set.domain.as_slice().spacing(point_index, &view);
            let density = set.points.mass[point_index] / set.points.volume[point_index];
            if set.rigid.is_some() {
                (moduli[k], viscosities[k]) = (0.0, 0.0);
            }
            let speed = (stiffening * moduli[k] / (self.clock.options.mass_scaling * density)).sqrt()
                + square(&set.points.velocity[point_index]).sqrt();
            let wave = LimitingPoint {
                dt: bounds.courant * h / speed,
                limit: StepLimit::ELASTIC_WAVE,
                set: number,
                point_index,
            };
            smallest = smallest.min(self.phase_limit(bounds, wave, moduli[k]));
            if viscosities[k] > 0.0 {
                // Explicit diffusion of momentum, sheet: mpm §2.10.
                let inertia = self.clock.options.mass_scaling * density;
                let dt = bounds.diffusion * inertia * h * h / viscosities[k];
                smallest =
                    smallest.min(LimitingPoint { dt, limit: StepLimit::VISCOSITY, set: number, point_index });
            }
        }
        smallest
    }

    /// Factor on the wave moduli for the springs of obstacles that act on points; 1 without such obstacles.
    #[inline]
    fn obstacle_stiffening(&self) -> f64 {
        let on_points = self.boundary.penalty_obstacles.is_some();
        if on_points { self.clock.options.obstacle_stiffness_factor() } else { 1.0 }
    }

    /// Step limit of a point, from that of the skeleton wave and, with pore fluid, those of both phases.
    #[inline]
    fn phase_limit(&self, bounds: StepCoefficients, wave: LimitingPoint, modulus: f64) -> LimitingPoint {
        let (set, i) = (&self.bodies.sets[wave.set], wave.point_index);
        let Some(fluid) = set.pore.as_ref().and_then(|pore| pore.fluid) else { return wave };
        let (n, dry) = (set.porosity(i), set.points.mass[i] / set.points.volume[i]);
        let h = set.domain.as_slice().spacing(i, &self.background.grid_view());
        // In time over the root of the scale of inertia the equations are the unscaled ones, with a weaker drag.
        let scale = self.clock.options.mass_scaling.sqrt();
        // Obstacles on points have the same springs for fluid and skeleton.
        let stiffening = self.obstacle_stiffening();
        let (modulus, bulk_modulus) = (stiffening * modulus, stiffening * fluid.bulk_modulus);
        let scaled = PoreFluidConstants { resistance: fluid.resistance / scale, bulk_modulus, ..fluid };
        let moving =
            |step: f64| bounds.courant / (1.0 / (scale * step) + square(&set.points.velocity[i]).sqrt() / h);
        let (dt, by_drag) = match self.clock.options.step_criterion {
            StepCriterion::Combined => {
                let (step, by_drag) = critical_step(&scaled, n, dry, modulus, h);
                (moving(step), by_drag)
            }
            StepCriterion::Simple => {
                let [step, drag] = simple_steps(&scaled, n, dry, modulus, h);
                let (dt, drag) = (moving(step), scale * drag);
                (dt.min(drag), drag < dt)
            }
        };
        LimitingPoint {
            dt,
            limit: if by_drag { StepLimit::SEEPAGE_DRAG } else { StepLimit::ELASTIC_WAVE },
            ..wave
        }
    }
}
