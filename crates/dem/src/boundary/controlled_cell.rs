//! Periodic cell with its stress, and the velocity gradient that the run imposes on it.

use crate::boundary::periodic_cell::PeriodicCell;
use crate::clock::Clock;
use crate::contact::Virial;

/// Cell of the grains, whose strain rates or stresses are controlled.
#[derive(Clone, Copy, Debug)]
pub struct ControlledCell<const D: usize> {
    /// Cell vectors and velocity gradient.
    pub geometry: PeriodicCell<D>,
    /// Contact and kinetic part of the stress times volume in the last step (J).
    pub virial: [Virial<D>; 2],
    /// Velocity gradient that a material law imposes (1/s), which replaces that of the stage.
    pub imposed_gradient: Option<[[f64; D]; D]>,
    /// Velocity gradient that a program prescribes (1/s), which replaces that of the stage.
    pub program_gradient: Option<[[f64; D]; D]>,
}

impl<const D: usize> ControlledCell<D> {
    /// Periodic cell with zero stress.
    pub fn new(geometry: PeriodicCell<D>) -> Self {
        Self { geometry, virial: [[[0.0; D]; D]; 2], imposed_gradient: None, program_gradient: None }
    }

    /// Velocity gradient that replaces that of the stage (1/s).
    pub fn given_gradient(&self) -> Option<[[f64; D]; D]> {
        self.imposed_gradient.or(self.program_gradient)
    }

    /// Stress of the cell: contact stress plus kinetic stress of the grains (Pa, tension-positive; N/m in the plane).
    pub fn stress(&self) -> [[f64; D]; D] {
        let volume = self.geometry.volume();
        std::array::from_fn(|i| {
            std::array::from_fn(|j| (self.virial[0][i][j] + self.virial[1][i][j]) / volume)
        })
    }

    /// Mean pressure (Pa; N/m in the plane).
    pub fn pressure(&self) -> f64 {
        let stress = self.stress();
        -(0..D).map(|c| stress[c][c]).sum::<f64>() / D as f64
    }

    /// Rate at which the radii grow in the present stage (1/s): zero from its pressure on.
    pub fn growth_rate(&self, clock: &Clock) -> f64 {
        let Some(options) = clock.stage_options() else { return 0.0 };
        let stops = options.growth != 0.0 && options.grow_until.is_some_and(|limit| self.pressure() >= limit);
        if stops { 0.0 } else { options.growth }
    }
}
