//! Strain-rate and stress control of a periodic cell (sheet: dem §3.7).

use crate::config::{CellControl, CellEntry};
use crate::solver::DemSolver;

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
            let way = wave(own.period, elapsed + ahead) - wave(own.period, elapsed);
            ControlTarget::Rate(own.amplitude * way / ahead)
        }
        CellEntry::CyclicStress(own) => {
            let stress = own.mean + own.amplitude * wave(own.period, elapsed);
            ControlTarget::Stress(stress, own.mean.abs().max(own.amplitude.abs()))
        }
    }
}

/// Entry of the velocity gradient in a row and a column; `None` where the case gives none.
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

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Stress of the cell: contact stress plus kinetic stress of the grains (Pa, tension-positive; N/m in the plane).
    pub(crate) fn stress(&self) -> [[f64; D]; D] {
        let volume = self.cell.volume();
        std::array::from_fn(|i| {
            std::array::from_fn(|j| (self.virial[0][i][j] + self.virial[1][i][j]) / volume)
        })
    }

    /// Change of the velocity gradient of the cell in a step of `dt` (1/s).
    pub(crate) fn control(&mut self, dt: f64) -> [[f64; D]; D] {
        let now = self.cell.velocity_gradient;
        if let Some(rate) = self.imposed_gradient {
            self.cell.mean_velocity_gradient = [[0.0; D]; D];
            return std::array::from_fn(|i| std::array::from_fn(|j| rate[i][j] - now[i][j]));
        }
        let Some(control) = self.stage().and_then(|stage| stage.cell) else {
            self.cell.mean_velocity_gradient = [[0.0; D]; D];
            return now.map(|row| row.map(|rate| -rate));
        };
        let mut change = [[0.0; D]; D];
        let elapsed = self.time - self.stage_start;
        let grain = self.mean_grain();
        for i in 0..D {
            for j in 0..D {
                let mut mean = 0.0;
                change[i][j] = match entry(&control, i, j).map(|entry| control_target(entry, elapsed, dt)) {
                    None => -now[i][j],
                    Some(ControlTarget::Rate(rate)) => rate - now[i][j],
                    Some(ControlTarget::Stress(target, size)) => {
                        let next = self.servo_rate((i, j), (target, size), (control.damping, grain), dt);
                        mean = next[1];
                        next[0] - now[i][j]
                    }
                };
                self.cell.mean_velocity_gradient[i][j] = mean;
            }
        }
        change
    }

    /// Mean mass (kg) and diameter (m) of the grains.
    pub(crate) fn mean_grain(&self) -> (f64, f64) {
        let count = self.grains.len() as f64;
        let mass: f64 = self.grains.mass.iter().sum();
        (mass / count, 2.0 * self.grains.radius.iter().sum::<f64>() / count)
    }

    /// Rate (1/s) of a stress-controlled entry after a step of `dt` (s), and the mean rate against which it is damped: missing stress
    /// accelerates a mass, and a dashpot couples a second mass to it (sheet: dem §3.7). While the cell carries less than half of the
    /// stress, the masses and the dashpot are those of a cell without support by the grains.
    fn servo_rate(
        &self,
        (i, j): (usize, usize),
        (target, size): (f64, f64),
        (damping, (mass, diameter)): (Option<f64>, (f64, f64)),
        dt: f64,
    ) -> [f64; 2] {
        let (stress, pressure) = (self.stress()[i][j], self.pressure());
        let (scale, borne) = match (i == j, size > 0.0) {
            (true, true) => (size, stress.abs()),
            (true, false) => (pressure, pressure),
            (false, _) => (pressure.max(size), pressure),
        };
        let share = if scale > 0.0 { (2.0 * borne / scale).clamp(0.0, 1.0) } else { 0.0 };
        let long = self.cell.h[j][j];
        let length = long + share * ((LENGTH * diameter).min(long) - long);
        let (rate, mean) = (self.cell.velocity_gradient[i][j], self.cell.mean_velocity_gradient[i][j]);
        let damping =
            damping.unwrap_or(DAMPING) * (scale.max(0.0) * diameter.powi(D as i32 - 2) / mass).sqrt();
        let all = mass * self.grains.len() as f64;
        let pull = (target - stress) * self.cell.volume() / (all * length * length);
        // Implicit in the dashpot, so that the rate does not overshoot.
        let next = (rate + dt * (pull + damping * share * mean)) / (1.0 + damping * dt);
        [next, (mean + damping * dt * next) / (1.0 + damping * dt)]
    }

    /// Mean pressure (Pa; N/m in the plane).
    pub(crate) fn pressure(&self) -> f64 {
        let stress = self.stress();
        -(0..D).map(|c| stress[c][c]).sum::<f64>() / D as f64
    }
}
