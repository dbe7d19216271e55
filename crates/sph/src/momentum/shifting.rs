//! Shifting of particles towards even spacing (sheet: sph §2.12).

use rayon::prelude::*;

use crate::clock::Clock;
use crate::config::ShiftingSpeed;
use crate::context::SolverContext;
use crate::neighbours::verlet_lists::VerletLists;
use crate::pairs::{PairContext, Shift};
use crate::points::particles::{Bodies, ParticleGroup};
use crate::points::vector_algebra::square;
use crate::rates::Rates;
use crate::walls::Walls;

/// Trace of the moment matrix below which a particle is at a free surface, in 1, 2 and 3 dimensions (sheet: sph §2.13 h: 1.5 of 2 and 2.4
/// of 3).
const SURFACE_TRACE: [f64; 3] = [0.7, 1.5, 2.4];

/// Largest number of steps between two shifts.
const MAX_STEPS: f64 = 4.0;
/// Largest product of strength and steps between two shifts. At a tenth of the speed of sound, the limit of a weakly compressible liquid, a
/// particle moves about 0.02 smoothing lengths in a step, and a shift of less than two smoothing lengths per length moved does not
/// overshoot an even spacing.
const MAX_STRENGTH: f64 = 40.0;

/// Number of steps between two shifts at a strength.
fn steps_per_shift(strength: f64) -> u64 {
    (MAX_STRENGTH / strength).clamp(1.0, MAX_STEPS) as u64
}

/// Particles at a free surface, and shifts of the others; empty without shifting.
#[derive(Default)]
pub struct Shifting<const D: usize> {
    surface: Vec<bool>,
    /// Squares of the largest particle speeds of the bodies (m²/s²), where these are used.
    max_speeds_squared: Vec<f64>,
    shifts: Vec<Option<Shift<D>>>,
}

impl<const D: usize> Shifting<D> {
    /// Shifts particles towards even spacing; step 10, of the previous steps.
    pub fn shift(
        &mut self,
        setting: &SolverContext<D>,
        clock: &mut Clock,
        bodies: &mut Bodies<D>,
        walls: &mut Walls<D>,
        lists: &mut VerletLists<D>,
        rates: &mut Rates<D>,
    ) {
        if setting.options.shifting == 0.0 || !clock.is_due(steps_per_shift(setting.options.shifting)) {
            return;
        }
        walls.load_images(bodies);
        walls.move_images(bodies);
        // Values of the previous step belong to other lists, or are absent after a restart.
        walls.extrapolate_densities(setting, bodies, &lists.neighbours);
        self.compute(setting, clock.time - clock.last_shift_time, bodies, walls, lists);
        clock.last_shift_time = clock.time;
        let p = &mut bodies.particles;
        for (i, shift) in self.shifts.iter().enumerate() {
            let Some(shift) = shift else { continue };
            for c in 0..D {
                p.position[i][c] += shift.displacement[c];
                p.velocity[i][c] += shift.velocity[c];
            }
            p.density[i] += shift.density;
            p.stress[i] += shift.stress;
        }
        walls.place_at_time(clock.time, p);
        lists.weights_current = false;
        rates.is_current = false;
    }

    /// Computes surfaces and shifts of particles that moved for `dt` (s).
    fn compute(
        &mut self,
        setting: &SolverContext<D>,
        dt: f64,
        bodies: &Bodies<D>,
        walls: &Walls<D>,
        lists: &VerletLists<D>,
    ) {
        let (p, neighbours) = (&bodies.particles, &lists.neighbours);
        let pairs = PairContext::new(setting, p, walls);
        let at_surface = |i: usize| pairs.moment_trace(i, neighbours.neighbours(i)) < SURFACE_TRACE[D - 1];
        (0..p.len()).into_par_iter().map(at_surface).collect_into_vec(&mut self.surface);
        let surface = &self.surface;
        let fastest = |body: &ParticleGroup| p.velocity[body.range()].iter().map(square).fold(0.0, f64::max);
        self.max_speeds_squared.clear();
        if setting.options.shifting_speed == ShiftingSpeed::Largest {
            self.max_speeds_squared.extend(bodies.groups.iter().map(fastest));
        }
        let fastest = &self.max_speeds_squared;
        let moves = |i: usize| {
            let number = bodies.groups.iter().position(|body| body.range().contains(&i))?;
            let body = Some(&bodies.groups[number])
                .filter(|body| body.prescribed_velocity.is_none() && body.rigid.is_none() && !surface[i])?;
            let length = fastest.get(number).copied().unwrap_or_else(|| square(&p.velocity[i])).sqrt() * dt;
            pairs.shift(i, neighbours.neighbours(i), length, (&body.range(), surface))
        };
        (0..p.len()).into_par_iter().map(moves).collect_into_vec(&mut self.shifts);
    }
}

#[cfg(test)]
mod tests {
    use colluvium_constitutive::SymTensor;
    use serde_json::json;

    use crate::setup::rates_only;
    use crate::setup::rates_only::PrescribedParticle;
    use crate::solver::SphSolver;

    /// Particles move as far as the lists allow before they are shifted by the maximum.
    #[test]
    fn shifted_particles_have_all_their_neighbours_listed() {
        let text = json!({
            "title": "shift", "space": "plane-strain", "domain": { "min": [-1, -1], "max": [2, 2] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "sph": { "spacing": 0.025, "shifting": 1 } }
        });
        let case = colluvium_case::Case::from_json(&text.to_string()).unwrap();
        let jitter = |id: u32, k: f64| (f64::from(id + 1) * k).fract() - 0.5;
        let given = |id: u32, _: &[f64; 2]| PrescribedParticle {
            displacement: [0.02 * jitter(id, 0.618_033_988_75), 0.02 * jitter(id, 0.754_877_666_25)],
            velocity: [1e3, 0.0],
            compression: 1.0,
            stress: SymTensor::ZERO,
        };
        let mut solver = rates_only::solver::<2>(&case, given);
        solver.update_lists(true).unwrap();
        let support = solver.setting.smoothing.radius();
        for i in 0..solver.bodies.particles.len() {
            // Bands move towards each other.
            let x = &mut solver.bodies.particles.position[i][0];
            let sign = if (10.0 * *x).floor() % 2.0 == 0.0 { 1.0 } else { -1.0 };
            *x += 0.049 * sign * support;
        }
        solver.update_lists(true).unwrap();
        (solver.clock.step, solver.clock.last_shift_time) = (4, solver.clock.time - 1e-3);
        let SphSolver { setting, clock, bodies, walls, lists, rates, shifting, .. } = &mut solver;
        shifting.shift(setting, clock, bodies, walls, lists, rates);
        let x = &solver.bodies.particles.position[..solver.bodies.particles.len()];
        for i in 0..x.len() {
            let close = |j: &usize| (x[i][0] - x[*j][0]).hypot(x[i][1] - x[*j][1]) < support;
            for j in (0..x.len()).filter(|j| *j != i).filter(close) {
                assert!(solver.lists.neighbours.neighbours(i).contains(&(j as u32)), "{:?} {:?}", x[i], x[j]);
            }
        }
    }
}
