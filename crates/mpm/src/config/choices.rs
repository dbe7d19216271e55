//! Values of the options of `methods.mpm`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Shape functions of the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShapeFunctions {
    /// Linear: the standard material point method.
    Linear,
    /// Linear, with gradients that are averages around the nodes where cells meet and do not jump there (dual domain
    /// material point method).
    DualDomain,
    /// Generalised interpolation with point domains of fixed size.
    #[default]
    Ugimp,
    /// Generalised interpolation with point domains that stretch with the deformation.
    Cpgimp,
    /// Quadratic B-splines.
    Quadratic,
    /// Cubic B-splines.
    Cubic,
    /// Convected particle domains: parallelograms that the deformation gradient carries along.
    Cpdi,
    /// Convected particle domains of the second order: quadrilaterals whose corners move with the grid (plane strain).
    Cpdi2,
}

/// Where the gradients of the shape functions are taken (sheet: mpm §2.5g).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "MpmFormulation")]
pub enum LagrangianFormulation {
    /// Where the points are now.
    #[default]
    UpdatedLagrangian,
    /// Where the points were at the start: no point ever crosses a cell and no body is torn by the grid, but what
    /// touched at the start stays together, and what did not never meets. Walls hold the nodes they held at the
    /// start. With `shape` `linear` or `quadratic`.
    TotalLagrangian,
    /// Where the points were at the start, and the points stay there: loads and supports act on the geometry at the
    /// start, as in finite elements for small displacements. Stresses, volumes and displacements follow the strains as
    /// ever. For limit loads. Not with `cpgimp`, `cpdi` and `cpdi2`, whose domains deform.
    SmallDisplacement,
}

/// Mass of the nodes (sheet: mpm §2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NodalMass {
    /// A number a node: the row sums of the consistent matrix. Takes a little kinetic energy each time velocities pass
    /// through the nodes.
    #[default]
    Lumped,
    /// The consistent matrix, solved with in each step, for studies of frequency and dissipation. Needs `stress_update`
    /// `usl`, rough and smooth walls and two points per cell and direction or more; steps are shorter, and each costs ten to
    /// fifty times as much. What a body moves into empty cells makes nodes that are lighter still than with lumped mass: for
    /// bodies that move `lumped_share` must be larger.
    Consistent,
}

/// How velocities pass between points and grid (sheet: mpm §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityTransfer {
    /// Points take the change of velocity of the grid (FLIP), or a share of its velocity (`flip` below 1).
    #[default]
    Flip,
    /// Extended PIC: points take the grid's velocity less what the mapping itself loses. Removes the noise that
    /// the grid cannot see and dissipates little else.
    Xpic,
    /// Affine PIC: points take the grid's velocity and carry its moment. Conserves angular momentum (exactly with
    /// `stress_update` `usl`); needs `shape` `quadratic` or `cubic`.
    Apic,
    /// As `apic` with the velocity gradient in place of the moment; for any shape functions.
    Tpic,
}

/// Criterion of the critical step of skeleton and pore fluid (sheet: mpm §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StepCriterion {
    /// Waves and drag of both phases together.
    #[default]
    Combined,
    /// The smaller one of `courant` times the step of the undrained wave and a limit of the drag (eqs. 4.122–4.128 of the
    /// scientific manual of Anura3D). To repeat analyses that were made with it: it is not safe, as the limit of the drag is
    /// that of an incompressible fluid and about a quarter too long, and with high conductivities the wave is faster.
    Simple,
}

impl StepCriterion {
    pub(super) fn is_combined(&self) -> bool {
        *self == Self::Combined
    }
}

/// When stress is updated in the step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StressScheme {
    /// First, from the velocities before the momentum solve.
    Usf,
    /// Last, from the velocities after it. Dissipates a little.
    Usl,
    /// Last, from velocities mapped back from the updated points. Conserves energy well.
    #[default]
    Musl,
}

/// Treatment of held degrees of freedom (sheet: mpm §3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FixedNodes {
    /// Velocity and acceleration are the wall's; points keep their own velocity component.
    #[default]
    Force,
    /// The wall stops the momentum that points bring.
    Momentum,
}

/// How frictional walls find the normal force (sheet: mpm §3.7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallFriction {
    /// From the momentum that the wall takes, that of arriving material included.
    #[default]
    Impulse,
    /// From the acceleration into the wall.
    Acceleration,
}

/// Where obstacles act on bodies (docs/theory/mpm.md, obstacles).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ObstacleCoupling {
    /// On nodes in them or on their surface, whose velocity is that which the obstacle allows.
    #[default]
    Nodes,
    /// On points that come nearer than half their width, by springs: of the overlap, and along the surface up to Coulomb's bound.
    Points,
}

/// Stretch of the domains of `cpgimp` points (sheet: mpm §2.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DomainStretch {
    /// The diagonal of the deformation gradient: for bodies that stretch along the axes.
    #[default]
    Diagonal,
    /// The diagonal of the right stretch tensor, which is invariant under rotation.
    RightStretch,
}

impl VelocityTransfer {
    /// Whether points carry more of the velocity than its value.
    pub(crate) fn is_affine(self) -> bool {
        matches!(self, Self::Apic | Self::Tpic)
    }
}

/// Over what the internal force is summed (sheet: mpm §2.16).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "MpmIntegration")]
pub enum InternalForceIntegration {
    /// The points, each with its own stress and volume.
    #[default]
    Points,
    /// The cells that are full of material, each with the average stress of its points, and the points of the others
    /// (MPM-MIXED): less noise of points that cross cells. Needs `shape` `linear`; the cells of a `mesh` are its elements.
    Mixed,
    /// All cells that hold a point, each with the average stress of its points and its whole volume, as in quasi-static
    /// analyses: no noise of points that cross cells at all, but a cell at the surface that is filled by half pulls as if
    /// it were full, so that stress times volume does not follow the mass. Needs `shape` `linear`.
    Gauss,
}

/// Where the volumetric strain of a point comes from (sheet: mpm §2.17).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VolumetricStrain {
    /// The point itself.
    #[default]
    Point,
    /// The average over the points of its cell that have its material; phase by phase with a `pore_fluid`. In the triangles
    /// and tetrahedra of a `mesh`, whose strain is constant, it changes nothing, but in axisymmetry.
    CellAverage,
    /// The average over the nodes of its cell, each of which takes the average of the cells around it (nodal mixed
    /// discretisation).
    Nodal,
}
