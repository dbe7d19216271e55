//! Check of stress control during deformation: means of the controlled stresses over the strain.

use serde::{Deserialize, Serialize};

use crate::boundary::cell_control::{ControlTarget, control_target, entry};
use crate::solver::DemSolver;

/// Strain over which a stress is averaged.
const STRAIN: f64 = 0.01;
/// Smallest averaging time, over `√(m / P d^(D-2))` of the mean grain: at inertial numbers above a thousandth the strain of a
/// window is larger.
const TIME: f64 = 10.0;
/// Relative difference of the mean from the target stress above which the run warns.
const ALLOWED: f64 = 0.02;

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
    /// Begins a stage, in which the target must be reached again.
    pub fn begin_stage(&mut self) {
        (self.is_met, self.window) = (false, [0.0; 3]);
    }

    /// Records the error of a step, over the stress, with its strain and its length over the smallest averaging time.
    fn record(&mut self, error: f64, strain: f64, time: f64, stage: usize) {
        self.is_met |= error.abs() <= ALLOWED;
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

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Records the stresses of the last forces, in a step of `dt` (s).
    pub(crate) fn record_controlled_stresses(&mut self, dt: f64) {
        let Some(stage) = self.stage() else { return };
        if self.imposed_gradient.is_some() || (stage.cell.is_none() && stage.walls.is_empty()) {
            return;
        }
        self.record_cell(dt);
        self.record_walls(dt);
    }

    /// Length of a step of `dt` (s) over the smallest averaging time under a stress (Pa).
    fn share_of_window(&self, stress: f64, dt: f64) -> f64 {
        let (mass, diameter) = self.mean_grain();
        dt * (stress.abs() * diameter.powi(D as i32 - 2) / mass).sqrt() / TIME
    }

    /// Records the stress-controlled entries of the cell, over the strain of the rate-controlled ones.
    fn record_cell(&mut self, dt: f64) {
        let Some(control) = self.stage().and_then(|stage| stage.cell) else { return };
        let (elapsed, stress, number) = (self.time - self.stage_start, self.stress(), self.stage);
        let ask = |i: usize, j: usize| entry(&control, i, j).map(|entry| control_target(entry, elapsed, dt));
        let mut strain = 0.0f64;
        for i in 0..D {
            for j in 0..D {
                if let Some(ControlTarget::Rate(rate)) = ask(i, j) {
                    strain = strain.max(dt * rate.abs());
                }
            }
        }
        if strain == 0.0 {
            return;
        }
        for i in 0..D {
            for j in 0..D {
                if let Some(ControlTarget::Stress(target, size)) = ask(i, j)
                    && size > 0.0
                {
                    let error = (stress[i][j] - target) * target.signum() / size;
                    let time = self.share_of_window(size, dt);
                    self.controlled_stresses[D * i + j].record(error, strain, time, number);
                }
            }
        }
    }

    /// Records the stress-controlled walls, over the strain by the other walls.
    fn record_walls(&mut self, dt: f64) {
        let Some(stage) = self.stage() else { return };
        let mut rates = [0.0f64; D];
        for wall in self.walls.iter().filter(|wall| wall.surface.is_none()) {
            if !stage.walls.contains_key(&wall.name) {
                let towards = if wall.upper { -1.0 } else { 1.0 } * wall.velocity[wall.axis];
                rates[wall.axis] += towards / self.extent(wall.axis);
            }
        }
        let strain = dt * rates.iter().fold(0.0f64, |most, rate| most.max(rate.abs()));
        if strain == 0.0 {
            return;
        }
        for number in 0..self.walls.len() {
            let wall = &self.walls[number];
            let Some(press) = self.stage().and_then(|stage| stage.walls.get(&wall.name)) else { continue };
            let (axis, slot, stress) = (wall.axis, D * D + wall.boundary, press.stress);
            let error = self.wall_force(number) / (-stress * self.servo_area(press, axis)) - 1.0;
            let (time, stage) = (self.share_of_window(stress, dt), self.stage);
            self.controlled_stresses[slot].record(error, strain, time, stage);
        }
    }

    /// Warnings of stresses that missed their targets.
    pub(crate) fn missed_stress_warnings(&self) -> Vec<String> {
        let axes = ["x", "y", "z"];
        let name = |slot: usize| match slot.checked_sub(D * D) {
            None => format!("the stress {}{} that the cell follows", axes[slot / D], axes[slot % D]),
            Some(wall) => {
                let name = self.case.boundaries.get(wall).map_or("", |boundary| boundary.name());
                format!("the stress that the wall {name:?} follows")
            }
        };
        let missed = |(slot, own): (usize, &ControlledStress)| {
            (own.max_mean_error.abs() > ALLOWED).then(|| {
                format!(
                    "stage {:?}: {} was {:.2} times what was asked for, as the mean over a strain of 1 %: deform the specimen \
                     more slowly in this stage",
                    self.case.stages.get(own.stage as usize).map_or("", |stage| stage.name.as_str()),
                    name(slot),
                    1.0 + own.max_mean_error
                )
            })
        };
        self.controlled_stresses.iter().enumerate().filter_map(missed).collect()
    }
}
