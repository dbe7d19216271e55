//! Check of stress control during deformation: means of the controlled stresses over the strain.

use serde::{Deserialize, Serialize};

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::cell_control::{ControlTarget, control_target, entry};
use crate::boundary::controlled_cell::ControlledCell;
use crate::clock::Clock;
use crate::points::grains::Grains;
use colluvium_case::Warning;

/// Strain over which a stress is averaged.
const STRAIN: f64 = 0.01;
/// Smallest averaging time, over `√(m / P d^(D-2))` of the mean grain.
const TIME: f64 = 10.0;
/// Relative difference of mean and target stress above which there is a warning.
const STRESS_TOLERANCE: f64 = 0.02;

/// Record of a controlled stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ControlledStress {
    /// Whether the target has been reached in this stage.
    is_met: bool,
    /// Strain and time since the start of the window, time over the smallest averaging time, and the integral of the error over the strain.
    window: [f64; 3],
    /// Largest mean error of a window, over the target stress.
    max_mean_error: f64,
    /// Stage of that window.
    stage: u32,
}

impl ControlledStress {
    /// Begins a stage, in which the target stress must be reached again.
    pub fn begin_stage(&mut self) {
        (self.is_met, self.window) = (false, [0.0; 3]);
    }

    /// Records the error of a step, over the stress, with its strain and its length over the smallest averaging time.
    fn record(&mut self, error: f64, strain: f64, time: f64, stage: usize) {
        self.is_met |= error.abs() <= STRESS_TOLERANCE;
        if !self.is_met {
            return;
        }
        self.window[0] += strain;
        self.window[1] += time;
        self.window[2] += strain * error;
        if self.window[0] < STRAIN || self.window[1] < 1.0 {
            return;
        }
        let mean = self.window[2] / self.window[0];
        if mean.abs() > self.max_mean_error.abs() {
            (self.max_mean_error, self.stage) = (mean, stage as u32);
        }
        self.window = [0.0; 3];
    }
}

/// Records the stresses of the last forces, in a step of `dt` (s).
pub fn record_controlled_stresses<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &ControlledCell<D>,
    grains: &Grains<D, R>,
    boundary: &BoundaryConditions<D>,
    stresses: &mut [ControlledStress],
    dt: f64,
) {
    let Some(stage) = clock.stage_options() else { return };
    if cell.imposed_gradient.is_some() || (stage.cell.is_none() && stage.walls.is_empty()) {
        return;
    }
    if cell.program_gradient.is_none() {
        record_cell(clock, cell, grains, stresses, dt);
    }
    record_walls(clock, cell, grains, boundary, stresses, dt);
}

/// Length of a step of `dt` (s) over the smallest averaging time under a stress (Pa).
fn share_of_window<const D: usize, const R: usize>(grains: &Grains<D, R>, stress: f64, dt: f64) -> f64 {
    let (mass, diameter) = grains.mean_mass_and_diameter();
    dt * (stress.abs() * diameter.powi(D as i32 - 2) / mass).sqrt() / TIME
}

/// Records the stress-controlled cell entries against the strain of the rate-controlled ones.
fn record_cell<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &ControlledCell<D>,
    grains: &Grains<D, R>,
    stresses: &mut [ControlledStress],
    dt: f64,
) {
    let Some(control) = clock.stage_options().and_then(|stage| stage.cell) else { return };
    let (elapsed, stress) = (clock.elapsed(), cell.stress());
    let target = |i: usize, j: usize| entry(&control, i, j).map(|entry| control_target(entry, elapsed, dt));
    let mut strain = 0.0f64;
    for i in 0..D {
        for j in 0..D {
            if let Some(ControlTarget::Rate(rate)) = target(i, j) {
                strain = strain.max(dt * rate.abs());
            }
        }
    }
    if strain == 0.0 {
        return;
    }
    for i in 0..D {
        for j in 0..D {
            if let Some(ControlTarget::Stress(target, size)) = target(i, j)
                && size > 0.0
            {
                let error = (stress[i][j] - target) * target.signum() / size;
                let time = share_of_window(grains, size, dt);
                stresses[D * i + j].record(error, strain, time, clock.stage);
            }
        }
    }
}

/// Records the stress-controlled walls against the strain by the other walls.
fn record_walls<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &ControlledCell<D>,
    grains: &Grains<D, R>,
    boundary: &BoundaryConditions<D>,
    stresses: &mut [ControlledStress],
    dt: f64,
) {
    let Some(stage) = clock.stage_options() else { return };
    let mut rates = [0.0f64; D];
    for wall in boundary.walls.iter().filter(|wall| wall.surface.is_none()) {
        if wall.program_velocity.is_some() || !stage.walls.contains_key(&wall.name) {
            let towards = if wall.is_upper { -1.0 } else { 1.0 } * wall.velocity[wall.axis];
            rates[wall.axis] += towards / boundary.extent(clock, &cell.geometry, wall.axis);
        }
    }
    let strain = dt * rates.iter().fold(0.0f64, |largest, rate| largest.max(rate.abs()));
    if strain == 0.0 {
        return;
    }
    for wall in boundary.walls.iter().filter(|wall| wall.program_velocity.is_none()) {
        let Some(servo) = stage.walls.get(&wall.name) else { continue };
        let (slot, stress) = (D * D + wall.boundary, servo.stress);
        let area = boundary.servo_area(clock, &cell.geometry, grains, servo, wall.axis);
        let error = wall.outward_force() / (-stress * area) - 1.0;
        stresses[slot].record(error, strain, share_of_window(grains, stress, dt), clock.stage);
    }
}

/// Warnings of stresses that missed their targets.
pub fn missed_stress_warnings<const D: usize>(clock: &Clock, stresses: &[ControlledStress]) -> Vec<Warning> {
    let axes = ["x", "y", "z"];
    let name = |slot: usize| match slot.checked_sub(D * D) {
        None => format!("the controlled stress {}{} of the cell", axes[slot / D], axes[slot % D]),
        Some(wall) => {
            let name = clock.case.boundaries.get(wall).map_or("", |boundary| boundary.name());
            format!("the controlled stress of the wall {name:?}")
        }
    };
    let missed = |(slot, own): (usize, &ControlledStress)| {
        (own.max_mean_error.abs() > STRESS_TOLERANCE).then(|| {
            Warning::new("stress-target-missed", format!(
                "stage {:?}: {} was {:.2} times its target, as the mean over a strain of 1 %: deform the specimen \
                 more slowly in this stage",
                clock.case.stages.get(own.stage as usize).map_or("", |stage| stage.name.as_str()),
                name(slot),
                1.0 + own.max_mean_error
            ))
        })
    };
    stresses.iter().enumerate().filter_map(missed).collect()
}
