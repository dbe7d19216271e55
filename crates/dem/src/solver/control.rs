//! A periodic cell that follows rates and stresses (sheet: dem §3.7).

use super::DemSolver;
use crate::config::{CellControl, CellEntry};

/// Damping of entries that follow a stress where the case says none (sheet: dem §3.7).
const DAMPING: f64 = 0.3;

/// What an entry asks for at a time: a rate (1/s), or a stress with the size of what it follows over the stage (Pa).
enum Asked {
    Rate(f64),
    Stress(f64, f64),
}

/// What an entry asks for after `elapsed` of its stage, in a step that ends `ahead` from then (s).
fn asked(entry: CellEntry, elapsed: f64, ahead: f64) -> Asked {
    let wave = |period: f64, time: f64| (std::f64::consts::TAU * time / period).sin();
    match entry {
        CellEntry::Rate(rate) => Asked::Rate(rate),
        CellEntry::Stress(stress) => Asked::Stress(stress, stress.abs()),
        CellEntry::CyclicStrain(own) => {
            // As much as takes the strain from its value now to that at the end of the step.
            let way = wave(own.period, elapsed + ahead) - wave(own.period, elapsed);
            Asked::Rate(own.amplitude * way / ahead)
        }
        CellEntry::CyclicStress(own) => {
            let stress = own.mean + own.amplitude * wave(own.period, elapsed);
            Asked::Stress(stress, own.mean.abs().max(own.amplitude.abs()))
        }
    }
}

/// Entry of the velocity gradient in a row and a column.
fn entry(control: &CellControl, row: usize, column: usize) -> Option<CellEntry> {
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
    /// Stress of the grains in the cell, with that of their motion (Pa, tension-positive; N/m in the plane).
    pub(crate) fn stress(&self) -> [[f64; D]; D] {
        let volume = self.cell.volume();
        std::array::from_fn(|i| {
            std::array::from_fn(|j| (self.virial[0][i][j] + self.virial[1][i][j]) / volume)
        })
    }

    /// Change of the velocity gradient of the cell with a step of `dt` (1/s).
    pub(crate) fn control(&self, dt: f64) -> [[f64; D]; D] {
        if let Some(rate) = self.imposed {
            let now = self.cell.rate;
            return std::array::from_fn(|i| std::array::from_fn(|j| rate[i][j] - now[i][j]));
        }
        let mut change = [[0.0; D]; D];
        let Some(control) = self.stage().and_then(|stage| stage.cell) else {
            return self.cell.rate.map(|row| row.map(|rate| -rate));
        };
        let (stress, volume) = (self.stress(), self.cell.volume());
        let mass: f64 = self.grains.mass.iter().sum();
        let count = self.grains.len() as f64;
        for i in 0..D {
            for j in 0..D {
                let now = self.cell.rate[i][j];
                let elapsed = self.time - self.stage_start;
                change[i][j] = match entry(&control, i, j).map(|entry| asked(entry, elapsed, dt)) {
                    None => -now,
                    Some(Asked::Rate(rate)) => rate - now,
                    Some(Asked::Stress(target, size)) => {
                        let length = self.cell.h[j][j];
                        let diameter = 2.0 * self.grains.radius.iter().sum::<f64>() / count;
                        let scale = if i == j { size } else { self.pressure().max(size) };
                        let rate = (scale * diameter.powi(D as i32 - 2) * count / mass).sqrt();
                        let damping = control.damping.unwrap_or(DAMPING) * rate;
                        let pull = (target - stress[i][j]) * volume / (mass * length * length);
                        // Against the damping without overshoot.
                        (pull - damping * now) * dt / (1.0 + 0.5 * damping * dt)
                    }
                };
            }
        }
        change
    }

    /// Mean pressure (Pa; N/m in the plane).
    pub(crate) fn pressure(&self) -> f64 {
        let stress = self.stress();
        -(0..D).map(|c| stress[c][c]).sum::<f64>() / D as f64
    }
}
