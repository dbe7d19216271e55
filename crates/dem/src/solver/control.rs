//! A periodic cell that follows rates and stresses (sheet: dem §3.7).

use super::DemSolver;
use crate::config::{CellControl, CellEntry};

/// Damping of entries that follow a stress where the case says none (sheet: dem §3.7).
const DAMPING: f64 = 0.3;

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
        let stage = &self.case.stages[self.stage];
        let control = self.options.stages.get(&stage.name).and_then(|options| options.cell);
        let Some(control) = control else {
            return self.cell.rate.map(|row| row.map(|rate| -rate));
        };
        let (stress, volume) = (self.stress(), self.cell.volume());
        let mass: f64 = self.grains.mass.iter().sum();
        let count = self.grains.len() as f64;
        for i in 0..D {
            for j in 0..D {
                let now = self.cell.rate[i][j];
                change[i][j] = match entry(&control, i, j) {
                    None => -now,
                    Some(CellEntry::Rate(rate)) => rate - now,
                    Some(CellEntry::Stress(target)) => {
                        let length = self.cell.h[j][j];
                        let diameter = 2.0 * self.grains.radius.iter().sum::<f64>() / count;
                        let scale = if i == j { target.abs() } else { self.pressure().max(target.abs()) };
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
