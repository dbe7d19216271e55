//! Built-in loading paths of a case file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Loading path of a stage. Amounts are totals over the stage; keys named `compression` are positive when the specimen shortens.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum LoadingPath {
    /// Isotropic path: all normal stresses change to minus the given pressure.
    Isotropic {
        /// Pressure at the end (Pa, compression-positive).
        pressure: f64,
    },
    /// Compression along z without lateral strain.
    Oedometer {
        /// Strain along z.
        axial_compression: f64,
    },
    /// Compression along z at constant lateral stress.
    TriaxialDrained {
        /// Strain along z (-).
        axial_compression: f64,
    },
    /// Compression along z without drainage, at constant total lateral stress; the law gives effective stress.
    TriaxialUndrained {
        /// Strain along z.
        axial_compression: f64,
        /// Stiffness of the pore fluid `K_f/n` (Pa), > 0, which relates the pore pressure to the volume; constant volume when absent.
        #[serde(default)]
        fluid_stiffness: Option<f64>,
    },
    /// Extension along z at constant lateral stress.
    TriaxialExtension {
        /// Strain along z.
        axial_extension: f64,
    },
    /// Compression along z at constant stress along x, with the stress along y in between: `b = (σ_y - σ_x)/(σ_z - σ_x)`.
    TrueTriaxial {
        /// Strain along z.
        axial_compression: f64,
        /// Ratio b, 0 to 1.
        b: f64,
    },
    /// Compression along y at constant stress along x, without strain along z.
    BiaxialPlaneStrain {
        /// Strain along y.
        axial_compression: f64,
    },
    /// Simple shear along x on planes normal to y, without other strain; the material rotates.
    SimpleShearConstantVolume {
        /// Engineering shear strain.
        shear: f64,
    },
    /// Simple shear along x on planes normal to y, at constant normal stress on them.
    SimpleShearConstantNormalStress {
        /// Engineering shear strain.
        shear: f64,
    },
    /// Prescribed strain increment.
    Strain {
        /// Tensor components xx yy zz xy yz zx, tension-positive.
        increment: [f64; 6],
    },
    /// Prescribed stress increment.
    Stress {
        /// Components xx yy zz xy yz zx (Pa, tension-positive).
        increment: [f64; 6],
    },
    /// Simple shear along x on planes normal to y by a prescribed shear stress, at constant normal stress.
    SimpleShearStress {
        /// Change of the shear stress (Pa).
        shear_stress: f64,
    },
    /// General linear control `S Δσ + E Δε = ΔY`, six rows; strain with tensor shear. With an
    /// amplitude the stage is one period: `ΔY(t) = total t/T + amplitude (sin(2πt/T + phase) - sin(phase))`.
    General {
        /// Matrix S, row by row.
        stress: [[f64; 6]; 6],
        /// Matrix E, row by row.
        strain: [[f64; 6]; 6],
        /// Right-hand side ΔY.
        total: [f64; 6],
        /// Amplitude of each row.
        #[serde(default)]
        amplitude: [f64; 6],
        /// Phase of each row (degrees).
        #[serde(default)]
        phase: [f64; 6],
        /// Rotation over the stage: angles about x, y, z (degrees, right-handed).
        #[serde(default)]
        spin: [f64; 3],
        /// Stiffness of the pore fluid `K_f/n` (Pa), > 0: the test is undrained, `Δσ` the total stress, and the
        /// pore pressure `Δp_w = -K_f/n tr Δε` a seventh unknown; drained when absent.
        #[serde(default)]
        fluid_stiffness: Option<f64>,
    },
    /// List of increments in sequence, each applied in the number of steps of the stage and an equal share of its duration. Every row
    /// prescribes either strain or stress.
    Direct {
        /// Quantity prescribed by each of the rows xx yy zz xy yz zx.
        control: [ControlledQuantity; 6],
        /// Increments: tensor strain, or stress (Pa), tension-positive, according to `control`.
        increments: Vec<[f64; 6]>,
        /// Rotation in each increment: angles about x, y, z (degrees); none when empty.
        #[serde(default)]
        spins: Vec<[f64; 3]>,
    },
    /// Constant velocity gradient: creep of a fluid, steady flow.
    Flow {
        /// Velocity gradient `∂v_i/∂x_j` (1/s), row by row.
        velocity_gradient: [[f64; 3]; 3],
    },
    /// Deformation gradient, linear in time from the unit matrix to the given one.
    DeformationGradient {
        /// Deformation gradient at the end, relative to the beginning of the stage, row by row.
        deformation: [[f64; 3]; 3],
    },
    /// Creep: constant stress over the duration.
    Creep {},
    /// Relaxation: no deformation over the duration.
    Relaxation {},
    /// Reversal of the previous stage: control of the same kind with all amounts reversed.
    Reversal {
        /// Share of the previous stage that is reversed (-).
        #[serde(default = "default_fraction")]
        fraction: f64,
    },
    /// Rigid rotation about z.
    Rotation {
        /// Angle (degrees, right-handed).
        angle: f64,
    },
}

/// Quantity that a component of a direct path prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ControlledQuantity {
    /// Strain increment.
    Strain,
    /// Stress increment.
    Stress,
}

/// Default fraction of the previous stage that is reversed: all of it.
fn default_fraction() -> f64 {
    1.0
}
