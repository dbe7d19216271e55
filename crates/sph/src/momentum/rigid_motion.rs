//! Rigid bodies, whose particles keep their relative positions (sheet: sph §2.14, (133), (134), (137)).
//!
//! Their particles act on those of other bodies as particles of their material do, density and stress included. Of the reactions only the
//! resultant force and the moment about the centre of mass are used, so that pair forces are antisymmetric and momentum is conserved. A
//! prescribed component has no acceleration.

use std::ops::Range;

use colluvium_case::description::PrescribedMotion;
use colluvium_case::rigid::{
    RigidBodyActions, RigidMass, RigidState, RigidStep, Twist, multiply, solve, velocity_at, wrench_at,
};
use colluvium_case::spatial;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::context::SolverContext;
use crate::points::packed_particles::set_velocity;
use crate::points::particles::{Bodies, ParticleGroup, SquareMatrix};
use crate::points::rigid_body::{RigidBody, RigidForces};
use crate::rates::{Rates, ReactionSum};
use crate::walls::Walls;

/// Ratio of the kinetic energy of the velocity change in a step by supports and forces to that by the forces alone, above which the step is
/// an impact.
const IMPACT_ENERGY_RATIO: f64 = 9.0;

/// Sets the accelerations of particles to those of a rigid body, from its rates of velocity (m/s²) and spin (rad/s²).
fn accelerate<const D: usize>(
    positions: &[[f64; D]],
    mass: &RigidMass,
    rate: &Twist,
    accelerations: &mut [[f64; D]],
) {
    for (x, a) in positions.iter().zip(accelerations) {
        let of_body = velocity_at(rate, &mass.lever_arm(&spatial(x)));
        *a = std::array::from_fn(|c| of_body[c]);
    }
}

impl<const D: usize> Bodies<D> {
    /// Whether any body is rigid.
    pub fn any_rigid(&self) -> bool {
        self.groups.iter().any(|group| group.rigid.is_some())
    }

    /// Particle range of the rigid body of particle `i`.
    pub fn rigid_range(&self, i: usize) -> Option<Range<usize>> {
        self.group_of(i).filter(|group| group.rigid.is_some()).map(ParticleGroup::range)
    }

    /// Whether particle `i` belongs to a rigid body that moves freely in the stage.
    pub fn moves_freely(&self, setting: &SolverContext<D>, clock: &Clock, i: usize) -> bool {
        let Some(group) = self.group_of(i).filter(|group| group.rigid.is_some()) else { return false };
        let name = &setting.case.bodies[group.body as usize].name;
        group.program_velocity.is_none()
            && setting.case.stages[clock.stage].motion_of(name).is_some_and(PrescribedMotion::is_free)
    }

    /// Velocity gradient of the rotation of the rigid body of particle `i` (1/s), and whether walls and obstacles strain the body. `None`
    /// if it is zero and they do.
    pub fn rotation_of(&self, i: usize) -> Option<(SquareMatrix<D>, bool)> {
        let RigidBody { rotation_gradient: about, moves_freely: loose, .. } = self.group_of(i)?.rigid?;
        let turn = std::array::from_fn(|a| std::array::from_fn(|b| about[a][b]));
        (loose || turn != [[0.0; D]; D]).then_some((turn, !loose))
    }

    /// Computes the forces on rigid bodies in a step of `dt` (s) and the resulting accelerations of their particles. It stores the force of
    /// the other bodies, that is the total without weight under `gravity` (m/s²) and loads.
    pub fn rigidify_accelerations(
        &self,
        setting: &SolverContext<D>,
        clock: &Clock,
        rates: &mut Rates<D>,
        gravity: &[f64; D],
        dt: f64,
    ) {
        let p = &self.particles;
        rates.rigid_forces.clear();
        for (number, group) in self.groups.iter().enumerate().filter(|(_, group)| group.rigid.is_some()) {
            let range = group.range();
            let positions = &p.position[range.clone()];
            let mass = RigidMass::of_points(&p.mass[range.clone()], positions, setting.options.spacing);
            let sum = |field: &[[f64; D]]| -> Twist {
                let mut sum = [0.0; 6];
                for i in range.clone() {
                    let own = spatial(&field[i].map(|a| p.mass[i] * a));
                    let own = wrench_at(&own, &mass.lever_arm(&spatial(&p.position[i])));
                    (0..6).for_each(|k| sum[k] += own[k]);
                }
                sum
            };
            let [fx, fy, fz, mx, my, mz] = sum(&rates.derivatives.acceleration);
            let (force, weight) = ([fx, fy, fz], spatial(gravity).map(|g| mass.mass * g));
            let pushed = if rates.external_accelerations.is_empty() {
                [0.0; 6]
            } else {
                sum(&rates.external_accelerations)
            };
            let body = group.body as usize;
            rates.reactions.resize(rates.reactions.len().max(body + 1), ReactionSum::default());
            rates.reactions[body].force = std::array::from_fn(|c| force[c] - weight[c] - pushed[c]);
            // Velocities are at the middle of the step.
            let elapsed = clock.time + 0.5 * dt - clock.stage_start;
            let motion = setting.case.stages[clock.stage].motion_of(&setting.case.bodies[body].name);
            let acts = match (group.program_velocity, motion) {
                (Some(velocity), _) => RigidBodyActions::prescribed(velocity),
                (None, Some(motion)) => {
                    RigidBodyActions::of_motion(motion, elapsed, D, (&force, &[mx, my, mz]))
                }
                (None, None) => RigidBodyActions::AT_REST,
            };
            let rate = solve(&mass.matrix(), &acts.applied(), &acts.free_components).unwrap_or_default();
            accelerate(positions, &mass, &rate, &mut rates.derivatives.acceleration[range]);
            rates.rigid_forces.push(RigidForces { group: number, mass, actions: acts, rate });
        }
    }

    /// Integrates the motion of rigid bodies under forces over the time `step` (s), and under supports. Their particles receive the
    /// velocity that moves them to their new positions in `dt` (s), so that rotation causes no strain.
    pub fn integrate_rigid(
        &mut self,
        setting: &SolverContext<D>,
        clock: &Clock,
        walls: &Walls<D>,
        rates: &mut Rates<D>,
        (step, dt): (f64, f64),
    ) {
        let local = setting.case.stages[clock.stage].damping;
        let p = &mut self.particles;
        let Rates {
            rigid_forces: pulled,
            support_reactions: stood,
            support_points: planks,
            unconverged_supports: unsettled,
            derivatives: of,
            ..
        } = rates;
        stood.clear();
        for RigidForces { group, mass, actions: acts, rate } in &*pulled {
            let mut rate = *rate;
            let group = &mut self.groups[*group];
            let range = group.range();
            let Some(rigid) = &mut group.rigid else { continue };
            rigid.moves_freely = acts.free_components != [false; 6];
            let mut body = RigidStep::new(*mass, &rigid.state, acts, step, 0.0);
            if rigid.moves_freely {
                let points = (&p.position[range.clone()], 0.5 * setting.options.spacing);
                let alone = body.kinetic_energy_gain();
                let done = walls.support_rigid_body(&setting.case, (&mut body, dt), points, planks);
                *unsettled += u64::from(!done);
                // Half a step later an impact is over: then the forces alone act.
                if !planks.is_empty()
                    && step > 0.0
                    && body.kinetic_energy_gain() <= IMPACT_ENERGY_RATIO * alone
                {
                    rate = std::array::from_fn(|k| (body.motion[k] - body.start[k]) / step);
                    accelerate(&p.position[range.clone()], mass, &rate, &mut of.acceleration[range.clone()]);
                }
                stood.extend(planks.reactions(&body, !done).map(|own| (range.start, own)));
            }
            body.damp(&[local; 3]);
            let left = |i: usize| p.mass[i] * setting.damping_factor(p.sound[i], p.length[i], dt);
            let left = range.clone().map(left).sum::<f64>() / mass.mass;
            (0..6).filter(|k| acts.free_components[*k]).for_each(|k| body.motion[k] *= left);
            body.apply(&mut rigid.state);
            let (along, about) = (body.velocity(), body.mean_gradient(dt));
            (rigid.rate, rigid.step, rigid.rotation_gradient) = (rate, Some(body), about);
            let positions = &p.position[range.clone()];
            let records = &mut self.pair_data.records[range.clone()];
            let moving = p.velocity[range].par_iter_mut().zip(records).zip(positions);
            moving.for_each(|((v, record), x)| {
                let turned = multiply(&about, &mass.lever_arm(&spatial(x)));
                *v = std::array::from_fn(|c| along[c] + turned[c]);
                set_velocity(record, v);
            });
        }
    }

    /// Rotates the velocities of the particles of rigid bodies to their new positions after a step of `dt` (s).
    pub fn rotate_rigid_velocities(&mut self, dt: f64) {
        let p = &mut self.particles;
        for group in &mut self.groups {
            let range = group.range();
            let Some(rigid) = &mut group.rigid else { continue };
            let Some(body) = rigid.step.take() else { continue };
            body.rotate(dt, &mut rigid.state);
            let RigidState { velocity: [vx, vy, vz], angular_velocity: [wx, wy, wz], .. } = rigid.state;
            let (motion, mut mass) = ([vx, vy, vz, wx, wy, wz], body.mass);
            (0..3).for_each(|c| mass.centre[c] += dt * motion[c]);
            let moving = p.velocity[range.clone()].par_iter_mut().zip(&p.position[range]);
            moving.for_each(|(v, x)| {
                let of_body = velocity_at(&motion, &mass.lever_arm(&spatial(x)));
                *v = std::array::from_fn(|c| of_body[c]);
            });
        }
    }
}
