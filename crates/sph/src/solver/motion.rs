//! The pieces of a step that move particles.

use colluvium_case::{SolverError, spatial};
use colluvium_points::ROWS;
use rayon::prelude::*;

use super::{Audit, SphSolver, TASK, over_rows, square};
use crate::config::SmoothingLength;
use crate::lanes::set_velocity;
use crate::particles::Group;

/// Share of the trace of a full moment below which a particle lies at a free surface (sheet §2.13 h: 1.5 of 2 and
/// 2.4 of 3).
const SURFACE_TRACE: [f64; 3] = [0.7, 1.5, 2.4];

/// What viscous damping of the strength `damping` leaves of a velocity after `dt` (s): the speed of sound is `sound`
/// (m/s), the smoothing length `h` (m).
pub(crate) fn decay(damping: f64, sound: f64, h: f64, dt: f64) -> f64 {
    if damping > 0.0 { (-damping / h * sound * dt).exp() } else { 1.0 }
}

impl<const D: usize> SphSolver<D> {
    /// Records and accelerations where lists are made already: steps 3 and 4.
    pub(crate) fn derive(&mut self, dt: f64) {
        self.load_records();
        self.accelerate(dt);
    }

    /// Accelerations, gravity and local damping of the stage included; keeps the weights of the pairs.
    pub(crate) fn accelerate(&mut self, dt: f64) {
        let gravity = self.gravity_at(dt);
        let mut accelerations = std::mem::take(&mut self.particles.acceleration);
        accelerations.resize(self.particles.len, [0.0; D]);
        let mut weights = std::mem::take(&mut self.weights);
        let pairs = self.pairs();
        over_rows(&self.neighbours, &mut weights, &mut accelerations, |i, row, weights, a| {
            let pull = pairs.acceleration(i, row, weights);
            *a = std::array::from_fn(|c| pull[c] + gravity[c]);
        });
        self.particles.acceleration = accelerations;
        self.weights = weights;
        (self.weighed, self.accelerated) = (true, true);
        self.confine(dt);
        self.resist_hourglass();
        // Smooth bodies feel nothing.
        self.smooth.ranges().for_each(|body| self.particles.acceleration[body].fill([0.0; D]));
    }

    /// Viscosity against what the velocity gradients of the step before do not see.
    fn resist_hourglass(&mut self) {
        let strength = self.options.hourglass_viscosity;
        if strength == 0.0 || self.last_step == 0.0 {
            return;
        }
        let mut accelerations = std::mem::take(&mut self.particles.acceleration);
        let mut weights = std::mem::take(&mut self.weights);
        let pairs = self.pairs();
        over_rows(&self.neighbours, &mut weights, &mut accelerations, |i, row, weights, a| {
            let pull = pairs.hourglass(i, (row, weights));
            (0..D).for_each(|c| a[c] += strength * pull[c]);
        });
        self.particles.acceleration = accelerations;
        self.weights = weights;
    }

    /// Unbalanced and external forces, kinetic energy and work of the step, of each of its free particles.
    pub(crate) fn audits(&self, dt: f64) -> impl Iterator<Item = (usize, Audit)> {
        let gravity = self.gravity_at(dt);
        let p = &self.particles;
        let free = self.groups.iter().filter(|group| group.held.is_none());
        free.flat_map(Group::range).filter(|&i| !self.is_guest(i)).map(move |i| {
            let (m, v) = (p.mass[i], &p.velocity[i]);
            let push = self.pushes.get(i).copied().unwrap_or([0.0; D]);
            let audit = Audit {
                unbalanced: m * m * square(&p.acceleration[i]),
                external: m * m * (square(&gravity) + square(&push)),
                kinetic: 0.5 * m * square(v),
                work: m * dt * (0..D).map(|c| (gravity[c] + push[c]) * v[c]).sum::<f64>(),
            };
            (i, audit)
        })
    }

    /// Adds `step` times the accelerations to the velocities, and the damping of `dt`; step 5.
    pub(crate) fn kick(&mut self, step: f64, dt: f64) {
        let local = self.case.stages[self.stage].damping;
        let damping = self.options.damping;
        let p = &mut self.particles;
        let moving = p.velocity[..p.len].par_iter_mut().zip(&mut p.records).zip(&p.acceleration);
        moving.zip(&p.sound).zip(&p.length).with_min_len(TASK).for_each(|((((v, record), a), sound), h)| {
            let factor = decay(damping, *sound, *h, dt);
            for c in 0..D {
                let resisted = if v[c] == 0.0 { 0.0 } else { local * a[c].abs() * v[c].signum() };
                v[c] = (v[c] + step * (a[c] - resisted)) * factor;
            }
            set_velocity(record, v);
        });
        self.hold();
    }

    /// Bodies and walls whose velocities vary in time get those of the step of `dt` (s) that begins.
    pub(crate) fn follow_histories(&mut self, dt: f64) {
        self.walls.follow_histories(self.time, self.time + dt, &mut self.images);
        let mut varies = false;
        for group in &mut self.groups {
            let Some(history) = &group.history else { continue };
            group.factor = history.mean(self.time, self.time + dt);
            varies = true;
        }
        if varies {
            self.hold();
        }
    }

    /// Gives bodies that are held their velocities.
    pub(crate) fn hold(&mut self) {
        let p = &mut self.particles;
        for group in &self.groups {
            let Some(field) = &group.held else { continue };
            for i in group.range() {
                let v = field.at(spatial(&p.position[i]));
                p.velocity[i] = std::array::from_fn(|c| group.factor * v[c]);
                set_velocity(&mut p.records[i], &p.velocity[i]);
            }
        }
    }

    /// Puts the velocities of all particles into their records.
    pub(crate) fn show_velocities(&mut self) {
        let p = &mut self.particles;
        let all = p.records[..p.len].par_iter_mut().zip(&p.velocity);
        all.with_min_len(TASK).for_each(|(record, v)| set_velocity(record, v));
    }

    /// Velocity gradients and divergences; step 6.
    pub(crate) fn find_rates(&mut self, dt: f64) {
        self.particles.move_images(&self.images);
        self.move_walls();
        let mut gradient = std::mem::take(&mut self.particles.gradient);
        let mut divergence = std::mem::take(&mut self.particles.divergence);
        let mut weights = std::mem::take(&mut self.weights);
        let (pairs, weighed) = (self.pairs(), self.weighed);
        let diffusion = 2.0 * self.options.density_diffusion;
        let fluid = |i: usize| self.body_of(i).filter(|group| group.fluid);
        // The gradient and the divergence of a particle stand in two arrays.
        let both = gradient.par_chunks_mut(ROWS).zip(divergence.par_chunks_mut(ROWS));
        let blocks = both.zip(&mut weights).zip(self.neighbours.blocks()).enumerate();
        blocks.for_each(|(number, (((gradient, divergence), weights), rows))| {
            for k in 0..gradient.len() {
                let i = number * ROWS + k;
                let (row, weights) = (rows.of(k), &mut weights[rows.range(k)]);
                if !weighed {
                    pairs.fill_weights(i, row, weights);
                }
                let rates = pairs.rates(i, row, weights);
                gradient[k] = rates.gradient;
                divergence[k] = rates.divergence;
                if diffusion > 0.0
                    && let Some(body) = fluid(i)
                {
                    divergence[k] += diffusion * pairs.density_diffusion(i, (row, weights), &body.range());
                }
            }
        });
        self.particles.gradient = gradient;
        self.particles.divergence = divergence;
        self.weights = weights;
        self.weighed = true;
        self.find_drift();
        self.follow_rate(dt);
        self.keep_still();
    }

    /// Copies of particles of other ranks do not strain here: they lack neighbours, and come anew before the next step.
    /// Smooth bodies feel nothing.
    fn keep_still(&mut self) {
        let p = &mut self.particles;
        let guests = self.guests.iter().enumerate().filter_map(|(i, guest)| guest.then_some(i));
        for i in guests.chain(self.smooth.ranges().flatten()) {
            p.gradient[i] = [[0.0; D]; D];
            p.divergence[i] = 0.0;
        }
    }

    /// Velocities of XSPH. Bodies that are held move with none.
    fn find_drift(&mut self) {
        if self.options.xsph == 0.0 {
            return;
        }
        let mut drift = std::mem::take(&mut self.particles.drift);
        drift.resize(self.particles.len, [0.0; D]);
        let mut weights = std::mem::take(&mut self.weights);
        let (pairs, share) = (self.pairs(), self.options.xsph);
        over_rows(&self.neighbours, &mut weights, &mut drift, |i, row, _, drift| {
            *drift = pairs.drift(i, row).map(|v| v * share);
        });
        for group in self.groups.iter().filter(|group| group.held.is_some()) {
            drift[group.range()].fill([0.0; D]);
        }
        self.weights = weights;
        self.particles.drift = drift;
    }

    /// Smoothing lengths by their rate.
    fn follow_rate(&mut self, dt: f64) {
        if self.options.smoothing_length != SmoothingLength::Rate {
            return;
        }
        let mut rates = std::mem::take(&mut self.scalars);
        rates.resize(self.particles.len, 0.0);
        let mut weights = std::mem::take(&mut self.weights);
        let pairs = self.pairs();
        over_rows(&self.neighbours, &mut weights, &mut rates, |i, row, weights, rate| {
            *rate = pairs.length_rate(i, row, weights);
        });
        self.weights = weights;
        let h = self.smoothing.length();
        let (least, most) = (h / self.options.smoothing_growth, h * self.options.smoothing_growth);
        for (length, rate) in self.particles.length.iter_mut().zip(&rates) {
            *length = (*length + dt * rate).clamp(least, most);
        }
        self.scalars = rates;
    }

    /// How far out particles may be along each axis at `time` (s): to the sides of the domain and the faces of walls in
    /// it, wherever these have moved. A soft material may be pressed into a wall as far as the wall's first particles.
    fn room(&self, time: f64) -> [(f64, f64); D] {
        let (domain, margin) = (&self.case.domain, self.margin());
        std::array::from_fn(|c| {
            if domain.is_periodic(c) {
                return (-f64::INFINITY, f64::INFINITY);
            }
            let (low, high) = self.walls.ends(c, time);
            (domain.min[c].max(low) - margin, domain.max[c].min(high) + margin)
        })
    }

    fn margin(&self) -> f64 {
        0.5 * self.options.spacing
    }

    /// Why particle `i`, which is not in its room at `time` (s), may not be where it is.
    fn astray(&self, i: usize, time: f64) -> String {
        let Some(wall) = self.walls.passed(&self.particles.position[i], time, self.margin()) else {
            return "it left the domain: enlarge the domain or add a wall on that side".to_owned();
        };
        let (name, axis) = (self.case.boundaries[wall.boundary].name(), ["x", "y", "z"][wall.axis]);
        format!(
            "it passed the wall {name:?}, whose face stands at {axis} = {} m: methods.sph.wall_guard keeps particles off \
             walls of particles, methods.sph.hourglass_viscosity off mirrors",
            wall.face_at(time)
        )
    }

    /// Positions at the end of the step; step 9.
    pub(crate) fn drift(&mut self, dt: f64) -> Result<(), SolverError> {
        let longest = 0.2 * self.smoothing.length();
        let end = self.time + dt;
        let room = self.room(end);
        let guests = &self.guests;
        let p = &mut self.particles;
        let extra = &p.drift;
        let all = p.position[..p.len].par_iter_mut().zip(&p.velocity).zip(&p.stress).enumerate();
        let lost = all.with_min_len(TASK).filter_map(|(i, ((x, v), stress))| {
            let v = extra.get(i).map_or(*v, |extra| std::array::from_fn(|c| v[c] + extra[c]));
            let far = !(square(&v) * dt * dt <= longest * longest);
            (0..D).for_each(|c| x[c] += dt * v[c]);
            let outside = (0..D).any(|c| x[c] < room[c].0 || x[c] > room[c].1);
            if guests.get(i).is_some_and(|guest| *guest) {
                None
            } else if far {
                Some((i, Some("it moved by more than 0.2 smoothing lengths in a step")))
            } else if !stress.is_finite() {
                Some((i, Some("its stress is not finite")))
            } else if outside {
                Some((i, None))
            } else {
                None
            }
        });
        let first = lost.min_by_key(|(i, _)| *i);
        self.weighed = false;
        self.accelerated = false;
        first.map_or(Ok(()), |(i, reason)| {
            let reason = reason.map_or_else(|| self.astray(i, end), ToOwned::to_owned);
            Err(self.failed(i, reason))
        })
    }

    /// Moves particles towards even spacing; step 10, of the step before.
    pub(crate) fn shift(&mut self) {
        if self.options.shifting == 0.0 || self.last_step == 0.0 {
            return;
        }
        self.particles.load_images(&self.images);
        self.particles.move_images(&self.images);
        // What the step before left there belongs to other lists, or to none after a restart.
        self.weigh_walls();
        let (mut surface, mut shifts) = (std::mem::take(&mut self.surface), std::mem::take(&mut self.shifts));
        let (len, dt) = (self.particles.len, self.last_step);
        let (pairs, neighbours) = (self.pairs(), &self.neighbours);
        let at_surface = |i: usize| pairs.moment(i, neighbours.of(i)).trace() < SURFACE_TRACE[D - 1];
        (0..len).into_par_iter().map(at_surface).collect_into_vec(&mut surface);
        let moves = |i: usize| {
            let length = square(&self.particles.velocity[i]).sqrt() * dt;
            let body = self.body_of(i).filter(|body| body.held.is_none() && !surface[i])?;
            pairs.shift(i, neighbours.of(i), length, (&body.range(), &surface))
        };
        (0..len).into_par_iter().map(moves).collect_into_vec(&mut shifts);
        let p = &mut self.particles;
        for (i, shift) in shifts.iter().enumerate() {
            let Some(shift) = shift else { continue };
            for c in 0..D {
                p.position[i][c] += shift.position[c];
                p.velocity[i][c] += shift.velocity[c];
            }
            p.density[i] += shift.density;
            p.stress[i] += shift.stress;
        }
        (self.surface, self.shifts) = (surface, shifts);
        self.place();
        self.accelerated = false;
    }
}

#[cfg(test)]
mod tests {
    use colluvium_constitutive::SymTensor;
    use serde_json::json;

    use crate::semi_discrete::{Given, prepared};

    /// Also between two listings of the neighbours.
    #[test]
    fn images_in_a_moving_mirror_stand_across_it_in_every_step() {
        let text = json!({
            "title": "mirror", "space": "plane-strain", "domain": { "min": [-1, -1], "max": [2, 2] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } }],
            "boundaries": [{ "side": "x-min", "position": 0, "wall": { "kind": "smooth" }, "velocity": [0.5, 0] }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "sph": { "spacing": 0.1 } }
        });
        let case = colluvium_case::Case::from_json(&text.to_string()).unwrap();
        let still = |_: u32, _: &[f64; 2]| Given {
            shift: [0.0; 2],
            velocity: [0.0; 2],
            compression: 1.0,
            stress: SymTensor::ZERO,
        };
        let mut solver = prepared::<2>(&case, still).unwrap();
        for _ in 0..5 {
            solver.advance(1e-4).unwrap();
            solver.refresh_neighbours(true).unwrap();
            let (p, time) = (&solver.particles, solver.time);
            assert!(!solver.images.is_empty() && solver.listed.time < time);
            for (image, slot) in solver.images.iter().zip(p.len..) {
                let middle = 0.5 * (p.position[slot][0] + p.position[image.source as usize][0]);
                assert!((middle - 0.5 * time).abs() < 1e-15, "{middle} m after {time} s");
            }
        }
    }

    /// Particles go as far as the lists allow before they are shifted as far as they may be.
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
        let given = |id: u32, _: &[f64; 2]| Given {
            shift: [0.02 * jitter(id, 0.618_033_988_75), 0.02 * jitter(id, 0.754_877_666_25)],
            velocity: [1e3, 0.0],
            compression: 1.0,
            stress: SymTensor::ZERO,
        };
        let mut solver = prepared::<2>(&case, given).unwrap();
        solver.refresh_neighbours(true).unwrap();
        let support = solver.smoothing.radius();
        for i in 0..solver.particles.len {
            // Bands go towards each other.
            let x = &mut solver.particles.position[i][0];
            let way = if (10.0 * *x).floor() % 2.0 == 0.0 { 1.0 } else { -1.0 };
            *x += 0.049 * way * support;
        }
        solver.refresh_neighbours(true).unwrap();
        solver.last_step = 1e-3;
        solver.shift();
        let x = &solver.particles.position[..solver.particles.len];
        for i in 0..x.len() {
            let close = |j: &usize| (x[i][0] - x[*j][0]).hypot(x[i][1] - x[*j][1]) < support;
            for j in (0..x.len()).filter(|j| *j != i).filter(close) {
                assert!(solver.neighbours.of(i).contains(&(j as u32)), "{:?} {:?}", x[i], x[j]);
            }
        }
    }
}
