//! Strain-rate and stress control of a periodic cell (sheet: dem §3.7).

use crate::boundary::controlled_cell::ControlledCell;
use crate::clock::Clock;
use crate::config::{CellControl, CellEntry};
use crate::points::grains::Grains;

/// Default damping ratio of stress-controlled entries (sheet: dem §3.7).
const DAMPING: f64 = 1.0;

/// Length of the cell whose inertia resists the controlled stress, over the mean diameter (sheet: dem §3.7).
const LENGTH: f64 = 3.0;

/// Target of an entry at a time: a rate (1/s), or a stress with the size of the controlled stress over the stage (Pa).
pub(crate) enum ControlTarget {
    Rate(f64),
    Stress(f64, f64),
}

/// Target of an entry at time `elapsed` of its stage (s), for a step of length `ahead` (s).
pub(crate) fn control_target(entry: CellEntry, elapsed: f64, ahead: f64) -> ControlTarget {
    let wave = |period: f64, time: f64| (std::f64::consts::TAU * time / period).sin();
    match entry {
        CellEntry::Rate(rate) => ControlTarget::Rate(rate),
        CellEntry::Stress(stress) => ControlTarget::Stress(stress, stress.abs()),
        CellEntry::CyclicStrain(own) => {
            // The rate that brings the strain from its value now to that at the end of the step.
            let change = wave(own.period, elapsed + ahead) - wave(own.period, elapsed);
            ControlTarget::Rate(own.amplitude * change / ahead)
        }
        CellEntry::CyclicStress(own) => {
            let stress = own.mean + own.amplitude * wave(own.period, elapsed);
            ControlTarget::Stress(stress, own.mean.abs().max(own.amplitude.abs()))
        }
    }
}

/// Control of an entry of the velocity gradient; `None` if the case gives none.
pub(crate) fn entry(control: &CellControl, row: usize, column: usize) -> Option<CellEntry> {
    match (row, column) {
        (0, 0) => control.xx,
        (1, 1) => control.yy,
        (2, 2) => control.zz,
        (0, 1) => control.xy,
        (1, 2) => control.yz,
        (0, 2) => control.xz,
        _ => None,
    }
}

/// Change of the velocity gradient of the cell in a step of `dt` (1/s).
pub(crate) fn control_cell<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &mut ControlledCell<D>,
    grains: &Grains<D, R>,
    dt: f64,
) -> [[f64; D]; D] {
    let now = cell.geometry.velocity_gradient;
    if let Some(rate) = cell.given_gradient() {
        cell.geometry.mean_velocity_gradient = [[0.0; D]; D];
        return std::array::from_fn(|i| std::array::from_fn(|j| rate[i][j] - now[i][j]));
    }
    let Some(control) = clock.stage_options().and_then(|stage| stage.cell) else {
        cell.geometry.mean_velocity_gradient = [[0.0; D]; D];
        return now.map(|row| row.map(|rate| -rate));
    };
    let mut change = [[0.0; D]; D];
    let elapsed = clock.elapsed();
    let (mass, diameter) = grains.mean_mass_and_diameter();
    let servo = CellServo { damping: control.damping, mass, diameter, count: grains.len() as f64, dt };
    for i in 0..D {
        for j in 0..D {
            let mut mean = 0.0;
            change[i][j] = match entry(&control, i, j).map(|entry| control_target(entry, elapsed, dt)) {
                None => -now[i][j],
                Some(ControlTarget::Rate(rate)) => rate - now[i][j],
                Some(ControlTarget::Stress(target, size)) => {
                    let next = servo.rate(cell, (i, j), (target, size));
                    mean = next[1];
                    next[0] - now[i][j]
                }
            };
            cell.geometry.mean_velocity_gradient[i][j] = mean;
        }
    }
    change
}

/// Servo of the stress-controlled entries of a cell.
struct CellServo {
    /// Damping ratio, where the case gives it.
    damping: Option<f64>,
    /// Mean mass of the grains (kg).
    mass: f64,
    /// Mean diameter of the grains (m).
    diameter: f64,
    /// Number of grains.
    count: f64,
    /// Length of the step (s).
    dt: f64,
}

impl CellServo {
    /// Rate of a stress-controlled entry of the velocity gradient after the step (1/s), and its mean rate (sheet: dem §3.7). The stress
    /// difference accelerates a mass, and a dashpot couples a second mass to it. While the cell carries less than half of the stress, the
    /// masses and the dashpot are those of a cell without support by the grains.
    fn rate<const D: usize>(
        &self,
        cell: &ControlledCell<D>,
        (i, j): (usize, usize),
        (target, size): (f64, f64),
    ) -> [f64; 2] {
        let Self { mass, diameter, dt, .. } = *self;
        let (stress, pressure) = (cell.stress()[i][j], cell.pressure());
        let (scale, carried) = match (i == j, size > 0.0) {
            (true, true) => (size, stress.abs()),
            (true, false) => (pressure, pressure),
            (false, _) => (pressure.max(size), pressure),
        };
        let share = if scale > 0.0 { (2.0 * carried / scale).clamp(0.0, 1.0) } else { 0.0 };
        let long = cell.geometry.h[j][j];
        let length = long + share * ((LENGTH * diameter).min(long) - long);
        let (rate, mean) =
            (cell.geometry.velocity_gradient[i][j], cell.geometry.mean_velocity_gradient[i][j]);
        let damping =
            self.damping.unwrap_or(DAMPING) * (scale.max(0.0) * diameter.powi(D as i32 - 2) / mass).sqrt();
        let total_mass = mass * self.count;
        let acceleration = (target - stress) * cell.geometry.volume() / (total_mass * length * length);
        // Implicit in the dashpot, so that the rate does not overshoot.
        let next = (rate + dt * (acceleration + damping * share * mean)) / (1.0 + damping * dt);
        [next, (mean + damping * dt * next) / (1.0 + damping * dt)]
    }
}
