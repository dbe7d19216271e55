//! The built-in paths, as conditions on stress and strain increments.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Mat3;

/// What a stage prescribes. Amounts are totals over the stage; keys named `compression` are positive
/// when the specimen gets shorter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Path {
    /// All normal stresses go to minus the given pressure.
    Isotropic {
        /// Pressure at the end (Pa, compression-positive).
        pressure: f64,
    },
    /// Compression along z, no lateral strain.
    Oedometer {
        /// Strain along z.
        axial_compression: f64,
    },
    /// Compression along z, lateral stress kept.
    TriaxialDrained {
        /// Strain along z.
        axial_compression: f64,
    },
    /// Compression along z, volume kept.
    TriaxialUndrained {
        /// Strain along z.
        axial_compression: f64,
    },
    /// Extension along z, lateral stress kept.
    TriaxialExtension {
        /// Strain along z.
        axial_extension: f64,
    },
    /// Compression along z, stress along x kept, stress along y in between: `b = (σ_y - σ_x)/(σ_z - σ_x)`.
    TrueTriaxial {
        /// Strain along z.
        axial_compression: f64,
        /// Ratio b, 0 to 1.
        b: f64,
    },
    /// Compression along y, stress along x kept, no strain along z.
    BiaxialPlaneStrain {
        /// Strain along y.
        axial_compression: f64,
    },
    /// Simple shear along x on planes normal to y, no other strain; the material turns.
    SimpleShearConstantVolume {
        /// Engineering shear strain.
        shear: f64,
    },
    /// Simple shear along x on planes normal to y, normal stress on them kept.
    SimpleShearConstantNormalStress {
        /// Engineering shear strain.
        shear: f64,
    },
    /// Given strain increment.
    Strain {
        /// Tensor components xx yy zz xy yz zx, tension-positive.
        increment: [f64; 6],
    },
    /// Given stress increment.
    Stress {
        /// Components xx yy zz xy yz zx (Pa, tension-positive).
        increment: [f64; 6],
    },
    /// General linear control `S Δσ + E Δε = ΔY`, six rows; strain with tensor shear.
    General {
        /// The matrix S, row by row.
        stress: [[f64; 6]; 6],
        /// The matrix E, row by row.
        strain: [[f64; 6]; 6],
        /// The right-hand side ΔY.
        total: [f64; 6],
    },
    /// Constant velocity gradient: creep, relaxation (zero gradient) and steady flow.
    Flow {
        /// Velocity gradient `∂v_i/∂x_j` (1/s), row by row.
        velocity_gradient: [[f64; 3]; 3],
    },
    /// Rigid rotation about z.
    Rotation {
        /// Angle (degrees, right-handed).
        angle: f64,
    },
}

/// Conditions of one step: either six linear equations, or the whole motion.
pub(super) enum Control {
    /// `S Δσ + E Δε = ΔY`, with engineering shear in Δε, and the spin that goes with a unit of Δε_xy.
    Mixed { stress: [[f64; 6]; 6], strain: [[f64; 6]; 6], total: [f64; 6], shear_turns: bool },
    /// `dt L` of the step.
    Given(Mat3),
    /// A rigid rotation by this angle (rad) a step.
    Rotation(f64),
}

/// Names of the components, for messages.
pub(super) const NAMES: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "zx"];

/// Collects rows of the control.
struct Rows {
    stress: [[f64; 6]; 6],
    strain: [[f64; 6]; 6],
    total: [f64; 6],
    shear_turns: bool,
}

impl Rows {
    /// All strain increments zero.
    fn still() -> Self {
        let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let strain = std::array::from_fn(|i| std::array::from_fn(|j| unit(i, j)));
        Self { stress: [[0.0; 6]; 6], strain, total: [0.0; 6], shear_turns: false }
    }

    fn strain(mut self, component: usize, total: f64) -> Self {
        self.total[component] = total;
        self
    }

    fn stress(mut self, component: usize, total: f64) -> Self {
        self.strain[component][component] = 0.0;
        self.stress[component][component] = 1.0;
        self.total[component] = total;
        self
    }

    fn done(self) -> Control {
        let Self { stress, strain, total, shear_turns } = self;
        Control::Mixed { stress, strain, total, shear_turns }
    }
}

impl Path {
    /// The conditions of one of `steps` steps, from a stage that starts at `stress`.
    pub(super) fn control(&self, stress: &crate::SymTensor, steps: usize, dt: f64) -> Control {
        let share = 1.0 / steps as f64;
        let still = Rows::still;
        match *self {
            Self::Isotropic { pressure } => {
                let to = |c: usize| (-pressure - stress[c]) * share;
                still().stress(0, to(0)).stress(1, to(1)).stress(2, to(2)).done()
            }
            Self::Oedometer { axial_compression } => still().strain(2, -axial_compression * share).done(),
            Self::TriaxialDrained { axial_compression: amount } => {
                still().stress(0, 0.0).stress(1, 0.0).strain(2, -amount * share).done()
            }
            Self::TriaxialExtension { axial_extension: amount } => {
                still().stress(0, 0.0).stress(1, 0.0).strain(2, amount * share).done()
            }
            Self::TriaxialUndrained { axial_compression } => {
                let mut rows = still().strain(2, -axial_compression * share);
                rows.strain[0] = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
                rows.strain[1] = [0.0; 6];
                rows.stress[1] = [1.0, -1.0, 0.0, 0.0, 0.0, 0.0];
                rows.done()
            }
            Self::TrueTriaxial { axial_compression, b } => {
                let mut rows = still().stress(0, 0.0).stress(1, 0.0).strain(2, -axial_compression * share);
                rows.stress[1] = [b - 1.0, 1.0, -b, 0.0, 0.0, 0.0];
                rows.done()
            }
            Self::BiaxialPlaneStrain { axial_compression } => {
                still().stress(0, 0.0).strain(1, -axial_compression * share).done()
            }
            Self::SimpleShearConstantVolume { shear } => {
                let mut rows = still().strain(3, shear * share);
                rows.shear_turns = true;
                rows.done()
            }
            Self::SimpleShearConstantNormalStress { shear } => {
                let mut rows = still().stress(1, 0.0).strain(3, shear * share);
                rows.shear_turns = true;
                rows.done()
            }
            Self::Strain { increment } => {
                let engineering = |c: usize| if c < 3 { increment[c] } else { 2.0 * increment[c] };
                let mut rows = still();
                rows.total = std::array::from_fn(|c| engineering(c) * share);
                rows.done()
            }
            Self::Stress { increment } => {
                (0..6).fold(still(), |rows, c| rows.stress(c, increment[c] * share)).done()
            }
            Self::General { stress, mut strain, total } => {
                // The file's strain has tensor shear, the solve engineering shear.
                strain.iter_mut().for_each(|row| row[3..].iter_mut().for_each(|e| *e *= 0.5));
                Control::Mixed { stress, strain, total: total.map(|t| t * share), shear_turns: false }
            }
            Self::Flow { velocity_gradient } => Control::Given(Mat3(velocity_gradient) * dt),
            Self::Rotation { angle } => Control::Rotation(angle.to_radians() * share),
        }
    }
}
