//! Values of the options of `methods.mpm`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Shape functions of the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShapeFunctions {
    /// Linear functions: the standard material point method.
    Linear,
    /// Linear functions with gradients averaged around nodes, without jumps between cells (dual domain).
    DualDomain,
    /// Generalised interpolation (GIMP), point domains of fixed size.
    #[default]
    Ugimp,
    /// Generalised interpolation (GIMP), point domains that stretch.
    Cpgimp,
    /// Quadratic B-splines.
    Quadratic,
    /// Cubic B-splines.
    Cubic,
    /// Convected particle domains (CPDI): parallelograms that deform with their points.
    Cpdi,
    /// CPDI of the second order: quadrilaterals whose corners move with the grid (plane strain).
    Cpdi2,
}

/// Configuration of the gradients of the shape functions (sheet: mpm §2.5g).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "MpmFormulation")]
pub enum LagrangianFormulation {
    /// Current positions.
    #[default]
    UpdatedLagrangian,
    /// Initial positions: no point crosses a cell, and the grid does not tear a body. Bodies that touch at the start stay together; others
    /// do not detect contact. Walls act on their initial nodes. Needs `shape` `linear` or `quadratic`; not with `contacts`.
    TotalLagrangian,
    /// Initial positions of points that do not move, as in finite elements for small displacements; for limit loads. Stresses, volumes and
    /// displacements follow the strains. Not with `cpgimp`, `cpdi`, `cpdi2`.
    SmallDisplacement,
}

/// Mass of the nodes (sheet: mpm §2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NodalMass {
    /// Row sums of the consistent matrix. Each transfer dissipates a little kinetic energy.
    #[default]
    Lumped,
    /// Consistent mass matrix, with a linear solve in each step, for studies of frequency and dissipation. Needs `stress_update` `usl`,
    /// rough and smooth walls, and at least two points per cell and direction. Steps are shorter, each ten to fifty times as expensive.
    /// Bodies that move into empty cells need a larger `lumped_share`.
    Consistent,
}

/// Transfer of velocities between points and grid (sheet: mpm §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityTransfer {
    /// FLIP: points add the change of the grid velocity, blended with the grid velocity if `flip` is below 1.
    #[default]
    Flip,
    /// Extended PIC: grid velocity, corrected for the loss of the mapping. Removes noise that the grid does not represent, and dissipates
    /// little else.
    Xpic,
    /// Affine PIC: grid velocity with its first moment. Conserves angular momentum (exactly with `stress_update` `usl`). Needs `shape`
    /// `quadratic` or `cubic`.
    Apic,
    /// As `apic`, with the velocity gradient in place of the moment, for any shape functions.
    Tpic,
}

/// Criterion of the critical step of skeleton and pore fluid (sheet: mpm §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StepCriterion {
    /// Waves and drag of both phases together.
    #[default]
    Combined,
    /// Smaller of `courant` times the undrained wave step and a drag limit, to repeat analyses of Anura3D (scientific manual, eqs.
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

/// Position of the stress update in the step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StressScheme {
    /// First (USF), from velocities before the momentum solve.
    Usf,
    /// Last (USL), from velocities after the momentum solve. Dissipates a little.
    Usl,
    /// Modified last (MUSL), from velocities mapped back from the updated points. Conserves energy well.
    #[default]
    Musl,
}

/// Treatment of fixed degrees of freedom (sheet: mpm §3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FixedNodes {
    /// Velocity and acceleration are the wall's; points keep their own component.
    #[default]
    Force,
    /// The wall stops the momentum that points transfer to the node.
    Momentum,
}

/// Source of the normal force in wall friction (sheet: mpm §3.7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallFriction {
    /// Momentum stopped by the wall, with that of arriving material.
    #[default]
    Impulse,
    /// Acceleration into the wall.
    Acceleration,
}

/// Nodes or points on which obstacles act (docs/theory/mpm.md, obstacles).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ObstacleCoupling {
    /// Nodes in an obstacle or on its surface, whose velocity is constrained.
    #[default]
    Nodes,
    /// Points closer to the surface than half their width: springs on overlap and slip, up to Coulomb's bound.
    Points,
}

/// Stretch of the domains of `cpgimp` points (sheet: mpm §2.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DomainStretch {
    /// Diagonal of the deformation gradient, for bodies that stretch along the axes.
    #[default]
    Diagonal,
    /// Diagonal of the right stretch tensor, which is invariant under rotation.
    RightStretch,
}

impl VelocityTransfer {
    /// Whether points store more of the velocity than its value.
    pub(crate) fn is_affine(self) -> bool {
        matches!(self, Self::Apic | Self::Tpic)
    }
}

/// Integration of the internal force (sheet: mpm §2.16).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "MpmIntegration")]
pub enum InternalForceIntegration {
    /// Sum over the points, each with its own stress and volume.
    #[default]
    Points,
    /// Mixed (MPM-MIXED): full cells act with the average stress of their points, others by points. Reduces the noise of points that cross
    /// cells. Needs `shape` `linear`; cells of a `mesh` are its elements.
    Mixed,
    /// Gauss: every cell with a point acts with its average stress and whole volume, for quasi-static analyses. There is no noise of
    /// crossing points. Half-filled surface cells act as full: stress times volume is not proportional to mass. Needs `shape` `linear`.
    Gauss,
}

/// Source of the volumetric strain of a point (sheet: mpm §2.17).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VolumetricStrain {
    /// Strain of the point itself.
    #[default]
    Point,
    /// Average over points of one material in the cell, by phase with a `pore_fluid`. No effect on a `mesh`, except in axisymmetry.
    CellAverage,
    /// Average over the cell's nodes, each with the average of the cells around it (nodal mixed discretisation).
    Nodal,
}
