//! Values of the options of `methods.mpm`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Shape functions of the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShapeFunctions {
    /// Linear functions: the standard material point method.
    Linear,
    /// Linear functions with gradients averaged around the nodes, which do not jump from cell to cell (dual domain material point
    /// method).
    DualDomain,
    /// Generalised interpolation (GIMP) with point domains of fixed size.
    #[default]
    Ugimp,
    /// Generalised interpolation (GIMP) with point domains that stretch with the deformation.
    Cpgimp,
    /// Quadratic B-splines.
    Quadratic,
    /// Cubic B-splines.
    Cubic,
    /// Convected particle domains (CPDI): parallelograms that deform with the deformation gradient of their points.
    Cpdi,
    /// Convected particle domains of the second order: quadrilaterals whose corners move with the grid (plane strain).
    Cpdi2,
}

/// Configuration in which the gradients of the shape functions are taken (sheet: mpm §2.5g).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "MpmFormulation")]
pub enum LagrangianFormulation {
    /// Current positions of the points.
    #[default]
    UpdatedLagrangian,
    /// Initial positions of the points. No point crosses a cell and the grid does not tear a body. Bodies that touch at the start stay
    /// together, and other bodies do not detect contact with each other. Walls act on the nodes on which they acted at the start. Needs
    /// `shape` `linear` or `quadratic`.
    TotalLagrangian,
    /// Initial positions of the points, which do not move: loads and supports act on the initial geometry, as in finite elements for
    /// small displacements. Stresses, volumes and displacements follow the strains as in the other formulations. For limit loads. Not
    /// with `cpgimp`, `cpdi` and `cpdi2`, whose domains deform.
    SmallDisplacement,
}

/// Mass of the nodes (sheet: mpm §2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NodalMass {
    /// Lumped mass: the row sums of the consistent matrix. Each transfer of velocities through the nodes dissipates a little kinetic
    /// energy.
    #[default]
    Lumped,
    /// Consistent mass matrix, with a linear solve in each step, for studies of frequency and dissipation. Needs `stress_update` `usl`,
    /// rough and smooth walls and two points per cell and direction or more. Steps are shorter, and each costs ten to fifty times as
    /// much. A body that moves into empty cells makes nodes that are even lighter than with lumped mass: for bodies that move,
    /// `lumped_share` must be larger.
    Consistent,
}

/// Transfer of velocities between points and grid (sheet: mpm §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityTransfer {
    /// FLIP: points add the change of the grid velocity to their own, or blend this with the grid velocity (`flip` below 1).
    #[default]
    Flip,
    /// Extended PIC: points take the grid velocity, corrected for the loss of the mapping itself. Removes the noise that the grid does
    /// not represent and dissipates little else.
    Xpic,
    /// Affine PIC: points take the grid velocity and store its first moment. Conserves angular momentum (exactly with `stress_update`
    /// `usl`). Needs `shape` `quadratic` or `cubic`.
    Apic,
    /// Affine transfer like `apic`, with the velocity gradient in place of the moment, for any shape functions.
    Tpic,
}

/// Criterion of the critical step of skeleton and pore fluid (sheet: mpm §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StepCriterion {
    /// Waves and drag of both phases together.
    #[default]
    Combined,
    /// Smaller one of two limits: `courant` times the step of the undrained wave, and a limit of the drag (eqs. 4.122–4.128 of the
    /// scientific manual of Anura3D). For repeating analyses made with that program. It is not safe: its limit of the drag is that of an
    /// incompressible fluid and about a quarter too long, and with high conductivities the wave is faster.
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
    /// Update stress first (USF): from the velocities before the momentum solve.
    Usf,
    /// Update stress last (USL): from the velocities after the momentum solve. Dissipates a little.
    Usl,
    /// Modified update stress last (MUSL): from velocities mapped back from the updated points. Conserves energy well.
    #[default]
    Musl,
}

/// Treatment of fixed degrees of freedom (sheet: mpm §3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FixedNodes {
    /// Velocity and acceleration of the node are those of the wall; points keep their own velocity component.
    #[default]
    Force,
    /// Momentum that points transfer to the node is stopped by the wall.
    Momentum,
}

/// Source of the normal force in wall friction (sheet: mpm §3.7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallFriction {
    /// Momentum that the wall stops, with that of arriving material.
    #[default]
    Impulse,
    /// Acceleration into the wall.
    Acceleration,
}

/// Nodes or points on which obstacles act (docs/theory/mpm.md, obstacles).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ObstacleCoupling {
    /// Nodes in an obstacle or on its surface: their velocity is constrained to one that the obstacle permits.
    #[default]
    Nodes,
    /// Points closer to the surface than half their width: a spring acts on the overlap, and a tangential spring up to Coulomb's bound.
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
    /// Mixed integration (MPM-MIXED): full cells act with the average stress of their points, and the points of other cells with their
    /// own. Reduces the noise of points that cross cells. Needs `shape` `linear`; the cells of a `mesh` are its elements.
    Mixed,
    /// Gauss integration: every cell with a point acts with the average stress of its points and its whole volume, as in quasi-static
    /// analyses. There is no noise of points that cross cells. A half-filled cell at the surface acts as a full one, so that stress times
    /// volume is not proportional to the mass. Needs `shape` `linear`.
    Gauss,
}

/// Source of the volumetric strain of a point (sheet: mpm §2.17).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VolumetricStrain {
    /// Strain of the point itself.
    #[default]
    Point,
    /// Average over the points of the cell that have the same material, phase by phase with a `pore_fluid`. It has no effect in the
    /// triangles and tetrahedra of a `mesh`, whose strain is constant, except in axisymmetry.
    CellAverage,
    /// Average over the nodes of the cell, each of which has the average of the cells around it (nodal mixed discretisation).
    Nodal,
}
