//! Motion of the grains in a step: prescribed velocities, prediction, integration and growth.

use std::collections::BTreeMap;

use colluvium_case::{FailureReason, SolverError};

use crate::boundary::controlled_cell::ControlledCell;
use crate::boundary::membranes::Membranes;
use crate::boundary::periodic_cell::{inverse, product};
use crate::clock::Clock;
use crate::config::ContactVelocity;
use crate::force_loop::contact_buffers::ContactBuffers;
use crate::momentum::applied_forces::applied_forces;
use crate::momentum::time_integration::{ExternalActions, GrainSums, integrate_grains, rotate};
use crate::neighbours::grain_neighbours::SinceListBuild;
use crate::points::grain_extremes::GrainExtremes;
use crate::points::grains::Grains;
use crate::points::vector::add;

/// Imposes the velocities of rigid bodies that the stage prescribes, and those of bodies that a program prescribes, for a step of `dt` (s).
pub fn impose_body_velocities<const D: usize, const R: usize>(
    clock: &Clock,
    grains: &mut Grains<D, R>,
    of_program: &BTreeMap<u32, [f64; D]>,
    dt: f64,
) {
    let case = &clock.case;
    if !case.bodies.iter().any(|body| body.rigid) && of_program.is_empty() {
        return;
    }
    let elapsed = clock.time + 0.5 * dt - clock.stage_start;
    let motions = &case.stages[clock.stage].motions;
    for (velocity, body) in grains.velocity.iter_mut().zip(&grains.body) {
        let imposed = of_program.get(body);
        let body = &case.bodies[*body as usize];
        if let Some(imposed) = imposed {
            *velocity = *imposed;
        } else if body.rigid {
            let motion = motions.iter().find(|motion| motion.target == body.name);
            let prescribed = motion.map_or([None; 3], |motion| motion.velocity_at(elapsed));
            *velocity = std::array::from_fn(|c| prescribed[c].unwrap_or(0.0));
        }
    }
}

/// Predicts the velocities half a step ahead from the last forces, for contact forces at predicted velocities.
pub fn predict_velocities<const D: usize, const R: usize>(
    clock: &Clock,
    grains: &Grains<D, R>,
    membranes: &Membranes,
    buffers: &mut ContactBuffers<D, R>,
) {
    if clock.options.velocity != ContactVelocity::Predicted {
        return;
    }
    let (gravity, applied) = (clock.gravity_at(0.0), applied_forces(clock, grains, membranes));
    let half = 0.5 * clock.last_step;
    buffers.velocity.clone_from(&grains.velocity);
    buffers.spin.clone_from(&grains.spin);
    for i in (0..grains.len()).filter(|&i| !grains.is_held[i]) {
        add(&mut buffers.velocity[i], half / grains.mass[i], &grains.force[i]);
        add(&mut buffers.velocity[i], half, &gravity);
        if let Some(applied) = applied.get(i) {
            add(&mut buffers.velocity[i], half / grains.mass[i], applied);
        }
        add(&mut buffers.spin[i], half / grains.inertia(i), &grains.torque[i]);
    }
}

/// Moves the grains and the cell by a step of `dt` (s), in which the velocity gradient of the cell changes by `change` (1/s).
pub fn move_grains<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &mut ControlledCell<D>,
    (grains, extremes): (&mut Grains<D, R>, &mut GrainExtremes),
    membranes: &Membranes,
    since_build: &mut SinceListBuild<D>,
    buffer: &mut Vec<GrainSums<D>>,
    (dt, change): (f64, [[f64; D]; D]),
) -> Result<GrainSums<D>, SolverError> {
    let stage = &clock.case.stages[clock.stage];
    let options = clock.stage_options();
    let now = cell.geometry;
    let moves = now.is_periodic() && (now.is_deforming() || change != [[0.0; D]; D]);
    let mut next = now;
    for (row, more) in next.velocity_gradient.iter_mut().zip(&change) {
        add(row, 1.0, more);
    }
    next.advance(dt);
    let carried =
        since_build.cell.filter(|_| moves).map(|then| (product(&next.h, &inverse(&then).0), now.origin));
    let applied = applied_forces(clock, grains, membranes);
    let actions = ExternalActions {
        dt,
        last_step: clock.last_step,
        gravity: clock.gravity_at(0.0),
        applied_force: &applied,
        damping: stage.damping_of_axes(),
        form: options.map_or_else(Default::default, |options| options.damping_form),
        viscous: stage.rayleigh_damping,
        rate: moves.then_some(now.velocity_gradient),
        cell_map: carried,
        gradient_change: moves.then_some((change, now.origin)),
    };
    let sums = integrate_grains(grains, &actions, buffer);
    if let Some(grain) = sums.not_finite {
        let reason = FailureReason::NotFinite("its position or velocity is not finite".to_owned());
        return Err(clock.grain_error(grains, grain as usize, reason));
    }
    for (orientation, spin) in grains.orientation.iter_mut().zip(&grains.spin) {
        rotate(orientation, spin, dt);
    }
    cell.virial[1] = sums.kinetic_stress.map(|row| row.map(|value| -value));
    extremes.max_speed = sums.max_speed_squared.sqrt();
    since_build.grain_travel = sums.max_travel_squared.sqrt();
    cell.geometry = next;
    Ok(sums)
}

/// Grows radii and masses in a step of `dt` (s).
pub fn grow_grains<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &ControlledCell<D>,
    (grains, extremes): (&mut Grains<D, R>, &mut GrainExtremes),
    since_build: &mut SinceListBuild<D>,
    dt: f64,
) {
    let rate = cell.growth_rate(clock);
    if rate == 0.0 {
        return;
    }
    let factor = 1.0 + rate * dt;
    let Grains { radius, mass, is_held, .. } = &mut *grains;
    for ((radius, mass), _) in radius.iter_mut().zip(mass).zip(is_held).filter(|(_, is_held)| !**is_held) {
        *radius *= factor;
        *mass *= factor.powi(D as i32);
    }
    extremes.radii = grains.radii();
    since_build.wall_travel += 2.0 * rate.abs() * dt * extremes.radii.1;
}
