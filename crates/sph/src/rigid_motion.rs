//! Rigid bodies, whose particles keep their places to each other (sheet: sph §2.14, (133), (134), (137)).
//!
//! Their particles act on those of other bodies as particles of their material do, density and stress included. Of the
//! accelerations that come back only what moves the body as a whole is kept, the force and the moment about the centre of
//! mass, so that pairs give and take the same and momentum is that before. A prescribed component has none.

use std::ops::Range;

use colluvium_case::description::PrescribedMotion;
use colluvium_case::rigid::{
    Acts, RigidMass, RigidState, RigidStep, Six, resultant, solve, times, velocity_at,
};
use colluvium_case::spatial;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::lanes::set_velocity;
use crate::particles::{Bodies, Group, Matrix};
use crate::rates::{Felt, Rates};
use crate::rigid::{Pulled, Rigid};
use crate::setting::Setting;
use crate::walls::Walls;

/// Energy (kinetic, of the change of motion) that the ground and the forces make together in a step over that of the forces alone, above
/// which it is a blow.
const BLOW: f64 = 9.0;

/// Gives particles the accelerations of a body (m/s²) with these rates of its velocity and spin (m/s², rad/s²).
fn accelerate<const D: usize>(
    positions: &[[f64; D]],
    mass: &RigidMass,
    rate: &Six,
    accelerations: &mut [[f64; D]],
) {
    for (x, a) in positions.iter().zip(accelerations) {
        let of_body = velocity_at(rate, &mass.arm(&spatial(x)));
        *a = std::array::from_fn(|c| of_body[c]);
    }
}

impl<const D: usize> Bodies<D> {
    /// Whether any is rigid.
    pub fn any_rigid(&self) -> bool {
        self.groups.iter().any(|group| group.rigid.is_some())
    }

    /// The particles of the rigid body that particle `i` belongs to.
    pub fn rigid_range(&self, i: usize) -> Option<Range<usize>> {
        self.of(i).filter(|group| group.rigid.is_some()).map(Group::range)
    }

    /// Whether particle `i` belongs to a rigid body that moves freely in the stage.
    pub fn moves_freely(&self, setting: &Setting<D>, clock: &Clock, i: usize) -> bool {
        let Some(group) = self.of(i).filter(|group| group.rigid.is_some()) else { return false };
        let name = &setting.case.bodies[group.body as usize].name;
        setting.case.stages[clock.stage].motion_of(name).is_some_and(PrescribedMotion::is_free)
    }

    /// Velocity gradient of the turn of the rigid body that particle `i` belongs to (1/s), and whether the ground strains it; `None`
    /// without a turn of one that the ground strains.
    pub fn turn_of(&self, i: usize) -> Option<(Matrix<D>, bool)> {
        let Rigid { about, loose, .. } = self.of(i)?.rigid?;
        let turn = std::array::from_fn(|a| std::array::from_fn(|b| about[a][b]));
        (loose || turn != [[0.0; D]; D]).then_some((turn, !loose))
    }

    /// Finds what acts on rigid bodies in a step of `dt` (s), with the forces of the stage, makes the accelerations of their particles
    /// those of a body, and keeps what is neither the weight under `gravity` (m/s²) nor a load: the force of the others.
    pub fn stiffen(
        &self,
        setting: &Setting<D>,
        clock: &Clock,
        rates: &mut Rates<D>,
        gravity: &[f64; D],
        dt: f64,
    ) {
        let p = &self.particles;
        rates.pulled.clear();
        for (number, group) in self.groups.iter().enumerate().filter(|(_, group)| group.rigid.is_some()) {
            let range = group.range();
            let positions = &p.position[range.clone()];
            let mass = RigidMass::of(&p.mass[range.clone()], positions, setting.options.spacing);
            let sum = |field: &[[f64; D]]| -> Six {
                let mut sum = [0.0; 6];
                for i in range.clone() {
                    let own = spatial(&field[i].map(|a| p.mass[i] * a));
                    let own = resultant(&own, &mass.arm(&spatial(&p.position[i])));
                    (0..6).for_each(|k| sum[k] += own[k]);
                }
                sum
            };
            let [fx, fy, fz, mx, my, mz] = sum(&rates.of.acceleration);
            let (force, weight) = ([fx, fy, fz], spatial(gravity).map(|g| mass.mass * g));
            let pushed = if rates.pushes.is_empty() { [0.0; 6] } else { sum(&rates.pushes) };
            let body = group.body as usize;
            rates.felt.resize(rates.felt.len().max(body + 1), Felt::default());
            rates.felt[body].force = std::array::from_fn(|c| force[c] - weight[c] - pushed[c]);
            // Velocities are those in the middle of the step.
            let elapsed = clock.time + 0.5 * dt - clock.stage_start;
            let motion = setting.case.stages[clock.stage].motion_of(&setting.case.bodies[body].name);
            let acts =
                motion.map_or(Acts::REST, |motion| Acts::of(motion, elapsed, D, (&force, &[mx, my, mz])));
            let rate = solve(&mass.matrix(), &acts.applied(), &acts.free).unwrap_or_default();
            accelerate(positions, &mass, &rate, &mut rates.of.acceleration[range]);
            rates.pulled.push(Pulled { group: number, mass, acts, rate });
        }
    }

    /// Gives rigid bodies the motion that forces over the time `step` (s) and the ground make, and their particles the velocity that takes
    /// them in `dt` (s) to where they are then: so a turn makes no strain.
    pub fn push_rigid(
        &mut self,
        setting: &Setting<D>,
        clock: &Clock,
        walls: &Walls<D>,
        rates: &mut Rates<D>,
        (step, dt): (f64, f64),
    ) {
        let local = setting.case.stages[clock.stage].damping;
        let p = &mut self.particles;
        let Rates { pulled, stood, planks, unsettled, of, .. } = rates;
        stood.clear();
        for Pulled { group, mass, acts, rate } in &*pulled {
            let mut rate = *rate;
            let group = &mut self.groups[*group];
            let range = group.range();
            let Some(rigid) = &mut group.rigid else { continue };
            rigid.loose = acts.free != [false; 6];
            let mut body = RigidStep::new(*mass, &rigid.state, acts, step, 0.0);
            if rigid.loose {
                let points = (&p.position[range.clone()], 0.5 * setting.options.spacing);
                let alone = body.gained();
                let done = walls.bear(&setting.case, (&mut body, dt), points, planks);
                *unsettled += u64::from(!done);
                // Half a step ahead a blow is over: there the forces alone count.
                if !planks.is_empty() && step > 0.0 && body.gained() <= BLOW * alone {
                    rate = std::array::from_fn(|k| (body.motion[k] - body.start[k]) / step);
                    accelerate(&p.position[range.clone()], mass, &rate, &mut of.acceleration[range.clone()]);
                }
                stood.extend(planks.stood(&body, !done).map(|own| (range.start, own)));
            }
            body.damp(&[local; 3]);
            let left = |i: usize| p.mass[i] * setting.damped(p.sound[i], p.length[i], dt);
            let left = range.clone().map(left).sum::<f64>() / mass.mass;
            (0..6).filter(|k| acts.free[*k]).for_each(|k| body.motion[k] *= left);
            body.settle(&mut rigid.state);
            let (along, about) = (body.velocity(), body.mean_gradient(dt));
            (rigid.rate, rigid.step, rigid.about) = (rate, Some(body), about);
            let positions = &p.position[range.clone()];
            let records = &mut self.shown.records[range.clone()];
            let moving = p.velocity[range].par_iter_mut().zip(records).zip(positions);
            moving.for_each(|((v, record), x)| {
                let turned = times(&about, &mass.arm(&spatial(x)));
                *v = std::array::from_fn(|c| along[c] + turned[c]);
                set_velocity(record, v);
            });
        }
    }

    /// Gives the particles of rigid bodies, which have moved in a step of `dt` (s), the velocities that they have there.
    pub fn turn_rigid(&mut self, dt: f64) {
        let p = &mut self.particles;
        for group in &mut self.groups {
            let range = group.range();
            let Some(rigid) = &mut group.rigid else { continue };
            let Some(body) = rigid.step.take() else { continue };
            body.turn(dt, &mut rigid.state);
            let RigidState { velocity: [vx, vy, vz], spin: [wx, wy, wz], .. } = rigid.state;
            let (motion, mut mass) = ([vx, vy, vz, wx, wy, wz], body.mass);
            (0..3).for_each(|c| mass.centre[c] += dt * motion[c]);
            let moving = p.velocity[range.clone()].par_iter_mut().zip(&p.position[range]);
            moving.for_each(|(v, x)| {
                let of_body = velocity_at(&motion, &mass.arm(&spatial(x)));
                *v = std::array::from_fn(|c| of_body[c]);
            });
        }
    }
}
