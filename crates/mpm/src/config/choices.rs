//! Values of the options of `methods.mpm`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Shape functions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShapeFunctions {
    /// Linear: the standard material point method.
    Linear,
    /// Linear with gradients averaged around nodes, without jumps between cells (dual domain).
    DualDomain,
    /// Generalised interpolation (GIMP), fixed point domains.
    #[default]
    Ugimp,
    /// Generalised interpolation (GIMP), stretching point domains.
    Cpgimp,
    /// Quadratic B-splines.
    Quadratic,
    /// Cubic B-splines.
    Cubic,
    /// Convected particle domains (CPDI): parallelograms deforming with points.
    Cpdi,
    /// Second-order CPDI: quadrilaterals whose corners move with the grid (plane strain).
    Cpdi2,
}

/// Configuration of shape function gradients (sheet: mpm §2.5g).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "MpmFormulation")]
pub enum LagrangianFormulation {
    /// Current positions.
    #[default]
    UpdatedLagrangian,
    /// Initial positions: no point crosses a cell, and the grid does not tear bodies. Bodies touching at the start stay together; others do
    /// not detect contact. Walls act on initial nodes. Needs `shape` `linear` or `quadratic`; no `contacts`.
    TotalLagrangian,
    /// Initial positions of points that do not move, as in small-displacement finite elements; for limit loads. Stresses, volumes and
    /// displacements follow the strains. Not with `cpgimp`, `cpdi`, `cpdi2`.
    SmallDisplacement,
}

/// Nodal mass (sheet: mpm §2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NodalMass {
    /// Row sums of the consistent matrix. Transfers dissipate a little kinetic energy.
    #[default]
    Lumped,
    /// Consistent mass matrix, solved in each step, for studies of frequency and dissipation. Needs `stress_update` `usl`, rough and smooth
    /// walls, and at least two points per cell and direction. Steps are shorter, each ten to fifty times as expensive. Bodies that move
    /// into empty cells need a larger `lumped_share`.
    Consistent,
}

/// Velocity transfer between points and grid (sheet: mpm §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityTransfer {
    /// FLIP: points add the change of grid velocity, blended with grid velocity if `flip` is below 1.
    #[default]
    Flip,
    /// Extended PIC: grid velocity, corrected for the mapping's loss. Removes noise, dissipates little else.
    Xpic,
    /// Affine PIC: grid velocity with its first moment. Conserves angular momentum (exactly with `stress_update` `usl`). Needs `shape`
    /// `quadratic` or `cubic`.
    Apic,
    /// As `apic`, velocity gradient in place of the moment, any shape functions.
    Tpic,
}

/// Critical step of skeleton and pore fluid (sheet: mpm §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StepCriterion {
    /// Both phases' waves and drag together.
    #[default]
    Combined,
    /// Smaller of `courant` times the undrained wave step and a drag limit, to repeat Anura3D analyses (scientific manual, eqs.
    /// 4.122–4.128). Not safe: the drag limit, for incompressible fluid, is a quarter too long, and at high conductivities the wave is
    /// faster.
    Simple,
}

impl StepCriterion {
    /// Whether the criterion combines wave speed and particle speed; output files omit this default.
    pub(super) fn is_combined(&self) -> bool {
        *self == Self::Combined
    }
}

/// Position of the stress update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StressScheme {
    /// First (USF), velocities before the momentum solve.
    Usf,
    /// Last (USL), velocities after the momentum solve. Dissipates a little.
    Usl,
    /// Modified last (MUSL), velocities mapped back from updated points. Conserves energy well.
    #[default]
    Musl,
}

/// Fixed degrees of freedom (sheet: mpm §3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FixedNodes {
    /// Velocity and acceleration of the wall; points keep their own component.
    #[default]
    Force,
    /// Momentum that points transfer to the node, which the wall stops.
    Momentum,
}

/// Normal force of wall friction (sheet: mpm §3.7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallFriction {
    /// Momentum stopped by the wall, also of arriving material.
    #[default]
    Impulse,
    /// Acceleration into the wall.
    Acceleration,
}

/// Nodes or points on which obstacles act (docs/theory/mpm.md, obstacles).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ObstacleCoupling {
    /// Nodes in an obstacle or on its surface, of constrained velocity.
    #[default]
    Nodes,
    /// Points within half their width of the surface: springs on overlap and slip, up to Coulomb's bound.
    Points,
}

/// Stretch of `cpgimp` domains (sheet: mpm §2.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DomainStretch {
    /// Diagonal of the deformation gradient, for stretch along the axes.
    #[default]
    Diagonal,
    /// Diagonal of the right stretch tensor, invariant under rotation.
    RightStretch,
}

impl VelocityTransfer {
    /// Whether points store more of the velocity than its value.
    pub(crate) fn is_affine(self) -> bool {
        matches!(self, Self::Apic | Self::Tpic)
    }
}

/// Internal force integration (sheet: mpm §2.16).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "MpmIntegration")]
pub enum InternalForceIntegration {
    /// Sum over points, each with own stress and volume.
    #[default]
    Points,
    /// Mixed (MPM-MIXED): full cells act with their points' average stress, others by points. Reduces cell-crossing noise. Needs `shape`
    /// `linear`; cells of a `mesh` are its elements.
    Mixed,
    /// Gauss: every cell with a point acts with its average stress and whole volume, for quasi-static analyses, without cell-crossing
    /// noise. Half-filled surface cells act as full, so that stress times volume is not proportional to mass. Needs `shape` `linear`.
    Gauss,
}

/// Source of a point's volumetric strain (sheet: mpm §2.17).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VolumetricStrain {
    /// Own strain.
    #[default]
    Point,
    /// Average over one material's points in the cell, by phase with a `pore_fluid`. No effect on a `mesh`, except in axisymmetry.
    CellAverage,
    /// Average over the cell's nodes, each with the surrounding cells' average (nodal mixed discretisation).
    Nodal,
}
