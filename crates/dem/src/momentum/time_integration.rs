//! Time integration: leap-frog, velocities half a step ahead of positions (sheet: dem §3.4).

use crate::momentum::integrate_simd::GrainBlock;
use rayon::prelude::*;
use wide::f64x4 as Lanes;

use crate::boundary::periodic_cell::apply;
use crate::config::DampingForm;
use crate::points::grains::{Grains, MIN_GRAINS_PER_TASK, inertia};
use crate::points::vector::{difference, dot, norm};

/// External actions on grains: gravity, applied forces, damping, deformation of the cell.
#[derive(Clone, Copy, Debug)]
pub struct ExternalActions<'a, const D: usize> {
    /// Time step (s).
    pub dt: f64,
    /// Length of the last step, zero at the start (s).
    pub last_step: f64,
    /// Gravitational acceleration (m/s²).
    pub gravity: [f64; D],
    /// Applied forces on the grains without gravity and contact forces (N); empty if there are none.
    pub applied_force: &'a [[f64; D]],
    /// Local damping coefficient of each axis.
    pub damping: [f64; 3],
    /// Form of the local damping.
    pub form: DampingForm,
    /// Mass-proportional damping (1/s).
    pub viscous: f64,
    /// Velocity gradient of the cell (1/s), if damping acts on velocities relative to it.
    pub rate: Option<[[f64; D]; D]>,
    /// Map from positions at the last list build to those in the current cell, relative to the corner of the cell (m).
    pub cell_map: Option<([[f64; D]; D], [f64; D])>,
    /// Change of the velocity gradient in the step (1/s), and the corner of the cell (m).
    pub gradient_change: Option<([[f64; D]; D], [f64; D])>,
}

/// Sums over grains at the time of the forces.
#[derive(Clone, Copy, Debug)]
pub struct GrainSums<const D: usize> {
    /// Kinetic energy of centres (J).
    pub kinetic: f64,
    /// Kinetic energy of rotations (J).
    pub rotation: f64,
    /// Twice the kinetic energy tensor of velocities relative to the deformation of the cell (J).
    pub kinetic_stress: [[f64; D]; D],
    /// Work of gravity in this step (J).
    pub gravity: f64,
    /// Work of applied forces (J).
    pub applied_work: f64,
    /// Energy dissipated by damping (J).
    pub damping: f64,
    /// Work of grains with prescribed motion (J).
    pub held_work: f64,
    /// Work of the change of the velocity gradient of the cell in the step (J).
    pub cell: f64,
    /// Square of the largest velocity (m²/s²).
    pub max_speed_squared: f64,
    /// Square of the largest displacement since the last list build (m²).
    pub max_travel_squared: f64,
    /// Sum of the squares of forces (N²).
    pub squares: f64,
    /// First grain whose velocity is not finite.
    pub not_finite: Option<u32>,
}

impl<const D: usize> Default for GrainSums<D> {
    fn default() -> Self {
        Self {
            kinetic: 0.0,
            rotation: 0.0,
            kinetic_stress: [[0.0; D]; D],
            gravity: 0.0,
            applied_work: 0.0,
            damping: 0.0,
            held_work: 0.0,
            cell: 0.0,
            max_speed_squared: 0.0,
            max_travel_squared: 0.0,
            squares: 0.0,
            not_finite: None,
        }
    }
}

impl<const D: usize> GrainSums<D> {
    /// Sums of two parts of the grains.
    fn add(mut self, other: &Self) -> Self {
        self.kinetic += other.kinetic;
        self.rotation += other.rotation;
        for (row, more) in self.kinetic_stress.iter_mut().zip(&other.kinetic_stress) {
            row.iter_mut().zip(more).for_each(|(sum, value)| *sum += value);
        }
        self.gravity += other.gravity;
        self.applied_work += other.applied_work;
        self.damping += other.damping;
        self.held_work += other.held_work;
        self.cell += other.cell;
        self.max_speed_squared = self.max_speed_squared.max(other.max_speed_squared);
        self.max_travel_squared = self.max_travel_squared.max(other.max_travel_squared);
        self.squares += other.squares;
        self.not_finite = self.not_finite.or(other.not_finite);
        self
    }
}

/// Integrates the motion of all grains over a step; `buffer` receives the energy sums of each range of grains.
pub fn integrate_grains<const D: usize, const R: usize>(
    grains: &mut Grains<D, R>,
    actions: &ExternalActions<'_, D>,
    buffer: &mut Vec<GrainSums<D>>,
) -> GrainSums<D> {
    buffer.clear();
    buffer.resize(grains.len().div_ceil(MIN_GRAINS_PER_TASK), GrainSums::default());
    let Grains {
        id: _, is_held, radius, mass, position, listed_position, velocity, spin, force, torque, ..
    } = grains;
    let kick = LeapfrogKick::from_actions(actions);
    let moving = position
        .par_chunks_mut(MIN_GRAINS_PER_TASK)
        .zip(velocity.par_chunks_mut(MIN_GRAINS_PER_TASK))
        .zip(spin.par_chunks_mut(MIN_GRAINS_PER_TASK))
        .zip(buffer.par_iter_mut())
        .enumerate();
    let glides = actions.is_gravity_only();
    moving.for_each(|(block, (((position, velocity), spin), sums))| {
        let own = block * MIN_GRAINS_PER_TASK..block * MIN_GRAINS_PER_TASK + position.len();
        let mut done = 0;
        if glides && !is_held[own.clone()].iter().any(|is_held| *is_held) {
            let still = GrainBlock {
                first: own.start,
                radius: &radius[own.clone()],
                mass: &mass[own.clone()],
                force: &force[own.clone()],
                torque: &torque[own.clone()],
                listed_position: &listed_position[own],
            };
            done = still.integrate((actions, &kick), position, velocity, spin, sums);
        }
        for k in done..position.len() {
            let i = block * MIN_GRAINS_PER_TASK + k;
            let (force, torque, applied_force) = (&force[i], &torque[i], actions.applied_force.get(i));
            let grain =
                Grain { is_held: is_held[i], radius: radius[i], mass: mass[i], force, torque, applied_force };
            grain.advance((actions, &kick), &mut position[k], &mut velocity[k], &mut spin[k], sums);
            let reference = match &actions.cell_map {
                None => listed_position[i],
                Some((map, corner)) => {
                    let carried = apply(map, &difference(&listed_position[i], corner));
                    std::array::from_fn(|c| carried[c] + corner[c])
                }
            };
            let displacement = difference(&position[k], &reference);
            sums.max_travel_squared = sums.max_travel_squared.max(dot(&displacement, &displacement));
            if !(sums.kinetic + dot(&position[k], &position[k])).is_finite() && sums.not_finite.is_none() {
                sums.not_finite = Some(i as u32);
            }
        }
    });
    buffer.iter().fold(GrainSums::default(), GrainSums::add)
}

/// Leap-frog kick, equal for all velocities.
pub(crate) struct LeapfrogKick {
    /// Time over which forces act (s).
    pub(crate) time: f64,
    /// Fraction of the velocity step that is before the time of the forces.
    pub(crate) share_before: f64,
    /// Factor of mass-proportional damping on a velocity.
    pub(crate) damping_factor: f64,
    /// Time over which forces act on the velocity, reduced by mass-proportional damping (s).
    pub(crate) force_time: f64,
    /// Mass-proportional damping (1/s).
    viscous: f64,
}

impl LeapfrogKick {
    /// Factors of the velocity update for a step with viscous damping.
    fn from_actions<const D: usize>(actions: &ExternalActions<'_, D>) -> Self {
        let time = 0.5 * (actions.last_step + actions.dt);
        let slow = 1.0 / (1.0 + 0.5 * actions.viscous * time);
        let keep = (1.0 - 0.5 * actions.viscous * time) * slow;
        // Position of the time of the forces, half a step after the old velocity.
        let share_before = if time > 0.0 { 0.5 * actions.last_step / time } else { 0.0 };
        Self { time, share_before, damping_factor: keep, force_time: slow * time, viscous: actions.viscous }
    }

    /// Velocity after the step and velocity at the time of the forces, for given force and inertia.
    #[inline(always)]
    fn apply<const N: usize>(&self, v: &[f64; N], force: &[f64; N], inertia: f64) -> ([f64; N], [f64; N]) {
        let lanes = |of: &[f64; N]| Lanes::new(std::array::from_fn(|c| if c < N { of[c] } else { 0.0 }));
        let old = lanes(v);
        let new = self.damping_factor * old + self.force_time * lanes(force) * Lanes::splat(1.0 / inertia);
        let now = (old + self.share_before * (new - old)).to_array();
        let new = new.to_array();
        (std::array::from_fn(|c| new[c]), std::array::from_fn(|c| now[c]))
    }

    /// Energy dissipated by mass-proportional damping (J).
    #[inline]
    fn viscous_loss<const N: usize>(
        &self,
        old: &[f64; N],
        new: &[f64; N],
        now: &[f64; N],
        inertia: f64,
    ) -> f64 {
        if self.viscous == 0.0 {
            return 0.0;
        }
        let each = |c: usize| self.viscous * inertia * 0.5 * (old[c] + new[c]) * now[c] * self.time;
        (0..N).map(each).sum()
    }
}

impl<const D: usize> ExternalActions<'_, D> {
    /// Whether only contacts and gravity act on the grains.
    fn is_gravity_only(&self) -> bool {
        let damped = self.damping != [0.0; 3] || self.viscous != 0.0;
        self.applied_force.is_empty() && !damped && self.gradient_change.is_none() && self.cell_map.is_none()
    }
}

/// State of one grain.
struct Grain<'a, const D: usize, const R: usize> {
    is_held: bool,
    radius: f64,
    mass: f64,
    force: &'a [f64; D],
    torque: &'a [f64; R],
    applied_force: Option<&'a [f64; D]>,
}

/// Local damping force on a velocity component (N), opposed to it.
#[inline]
fn local_damping(damping: f64, force: f64, velocity: f64) -> f64 {
    if velocity == 0.0 { 0.0 } else { -damping * force.abs() * velocity.signum() }
}

impl<const D: usize, const R: usize> Grain<'_, D, R> {
    /// Advances velocity, spin and position of a grain by a step and adds its energies to the sums.
    #[inline]
    fn advance(
        &self,
        (actions, kick): (&ExternalActions<'_, D>, &LeapfrogKick),
        x: &mut [f64; D],
        v: &mut [f64; D],
        w: &mut [f64; R],
        sums: &mut GrainSums<D>,
    ) {
        let dt = actions.dt;
        sums.max_speed_squared = sums.max_speed_squared.max(dot(v, v));
        if self.is_held {
            sums.held_work -= dot(self.force, v) * kick.time;
            for c in 0..D {
                x[c] += v[c] * dt;
            }
            return;
        }
        let gravity = actions.gravity.map(|g| self.mass * g);
        let mut force: [f64; D] = std::array::from_fn(|c| self.force[c] + gravity[c]);
        if let Some(applied) = self.applied_force {
            force = std::array::from_fn(|c| force[c] + applied[c]);
        }
        let mut torque = *self.torque;
        let inertia = inertia(D) * self.mass * self.radius * self.radius;
        sums.squares += dot(&force, &force);
        let mut lost = self.damp(actions, x, v, &mut force);
        if actions.damping[0] != 0.0 {
            for c in 0..R {
                let middle = w[c] + 0.5 * dt * torque[c] / inertia;
                let damped = local_damping(actions.damping[0], torque[c], middle);
                torque[c] += damped;
                lost -= damped * middle * kick.time;
            }
        }
        let (new, now) = kick.apply(v, &force, self.mass);
        lost += kick.viscous_loss(v, &new, &now, self.mass);
        *v = new;
        let (new, turning) = kick.apply(w, &torque, inertia);
        lost += kick.viscous_loss(w, &new, &turning, inertia);
        *w = new;
        sums.damping += lost;
        sums.gravity += dot(&gravity, &now) * kick.time;
        sums.applied_work += self.applied_force.map_or(0.0, |applied| dot(applied, &now) * kick.time);
        sums.kinetic += 0.5 * self.mass * dot(&now, &now);
        sums.rotation += 0.5 * inertia * dot(&turning, &turning);
        self.add_cell_motion(actions, &now, x, v, sums);
        for c in 0..D {
            x[c] += v[c] * dt;
        }
    }

    /// Adds the velocity change by the deforming cell with its work, and the kinetic stress of the grain.
    #[inline]
    fn add_cell_motion(
        &self,
        actions: &ExternalActions<'_, D>,
        now: &[f64; D],
        x: &[f64; D],
        v: &mut [f64; D],
        sums: &mut GrainSums<D>,
    ) {
        let Some((change, corner)) = &actions.gradient_change else { return };
        let place = difference(x, corner);
        if let Some(rate) = &actions.rate {
            let own = difference(now, &apply(rate, &place));
            for a in 0..D {
                for b in 0..D {
                    sums.kinetic_stress[a][b] += self.mass * own[a] * own[b];
                }
            }
        }
        let more = apply(change, &place);
        for c in 0..D {
            // Work of the cell on the grains that move with it.
            sums.cell += self.mass * (v[c] + 0.5 * more[c]) * more[c];
            v[c] += more[c];
        }
    }

    /// Adds local damping to the force, and returns the energy dissipated (J).
    #[inline]
    fn damp(
        &self,
        actions: &ExternalActions<'_, D>,
        x: &[f64; D],
        v: &[f64; D],
        force: &mut [f64; D],
    ) -> f64 {
        if actions.damping == [0.0; 3] {
            return 0.0;
        }
        let kick = 0.5 * (actions.last_step + actions.dt);
        let mut middle: [f64; D] = std::array::from_fn(|c| v[c] + 0.5 * actions.dt * force[c] / self.mass);
        if let (Some(rate), Some((_, corner))) = (&actions.rate, &actions.gradient_change) {
            middle = difference(&middle, &apply(rate, &difference(x, corner)));
        }
        let damped: [f64; D] = match actions.form {
            DampingForm::Components => {
                std::array::from_fn(|c| local_damping(actions.damping[c], force[c], middle[c]))
            }
            DampingForm::Vector => {
                let power = dot(force, &middle);
                let sign = if power == 0.0 { 0.0 } else { power.signum() };
                force.map(|f| -actions.damping[0] * f * sign)
            }
        };
        for c in 0..D {
            force[c] += damped[c];
        }
        -dot(&damped, &middle) * kick
    }
}

/// Rotates a quaternion by an angular velocity over a step, or an angle in the plane (sheet: dem §3.4).
pub fn rotate<const R: usize>(orientation: &mut [f64; 4], spin: &[f64; R], dt: f64) {
    if R == 1 {
        orientation[0] += spin[0] * dt;
        return;
    }
    let rate = norm(spin);
    let half = 0.5 * rate * dt;
    if half < 5e-15 {
        return;
    }
    let (sin, cos) = half.sin_cos();
    let axis = [spin[0] / rate * sin, spin[1] / rate * sin, spin[2] / rate * sin];
    let [a, b, c, d] = *orientation;
    let new = [
        cos * a - axis[0] * b - axis[1] * c - axis[2] * d,
        cos * b + axis[0] * a + axis[1] * d - axis[2] * c,
        cos * c + axis[1] * a + axis[2] * b - axis[0] * d,
        cos * d + axis[2] * a + axis[0] * c - axis[1] * b,
    ];
    let size = norm(&new);
    *orientation = new.map(|q| q / size);
}
