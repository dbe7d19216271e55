//! Options of `methods.mpm` in a case file.
//!
//! Names, defaults with their reasons, and ranges of the options. The module knows no other module; all may know it.

mod choices;
mod contact;

use std::collections::BTreeMap;

use colluvium_case::description::Stage;
use colluvium_case::{Case, CaseError, CaseErrorKind, MethodOptions};
use colluvium_constitutive::with_defaults;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use choices::{
    DomainStretch, FixedNodes, InternalForceIntegration, LagrangianFormulation, NodalMass, ObstacleCoupling,
    ShapeFunctions, StepCriterion, StressScheme, VelocityTransfer, VolumetricStrain, WallFriction,
};
pub use contact::{BodyContact, ContactTest, PenaltyContact};

/// Coefficients of the step limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StepCoefficients {
    /// Courant number of the wave limit: step times wave speed over cell size (-).
    pub courant: f64,
    /// Diffusion number of the viscous limit: step times viscosity over density and the square of the cell size (-).
    pub diffusion: f64,
}

/// Options of the explicit material point method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MpmOptions {
    /// Edge of the square (cubic) grid cells (m). Domains are a whole number of cells wide.
    pub cell_size: f64,
    /// Mesh of triangles or tetrahedra in place of the grid. Needs `shape` `linear`. Measures use columns of `cell_size`.
    #[serde(default)]
    pub mesh: Option<MeshSource>,
    /// Points per cell and direction, by default 3 where only Newtonian liquids deform without `mesh`. On a `mesh` 1, 2, 3 give 1, 3, 6
    /// points in a triangle, 1, 4, 10 in a tetrahedron.
    #[serde(default = "default_points_per_cell")]
    pub points_per_cell: usize,
    /// Shape functions.
    #[serde(default)]
    pub shape: ShapeFunctions,
    /// Position of the stress update.
    #[serde(default)]
    pub stress_update: StressScheme,
    /// Transfer between points and grid. The default is `tpic` where only Newtonian liquids deform, with `volumetric_strain` `point`,
    /// `mass` `lumped`, `updated-lagrangian`, no `dual-domain`, FLIP or XPIC option: with FLIP they keep motion that the grid does not
    /// represent. Liquids of `contacts` have `tpic` beside bodies with `flip`.
    #[serde(default)]
    pub transfer: VelocityTransfer,
    /// Filter order, 1 to 20, with `transfer` `xpic`, or `flip` and a `residual_time`; 1 is PIC. Higher orders dissipate less, each by one
    /// more grid loop.
    #[serde(default = "xpic_order")]
    pub xpic_order: usize,
    /// Time (s) in which point velocities that the grid does not represent fall to 1/e, with `transfer` `flip` or `xpic`: about the root of
    /// a deposit's height over gravity. When absent FLIP keeps them; XPIC removes them in each step, so that
    /// shorter steps dissipate more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual_time: Option<f64>,
    /// FLIP fraction, 0 to 1, with `transfer` `flip`; the rest is PIC. 1 dissipates nothing.
    #[serde(default = "default_one")]
    pub flip: f64,
    /// `flip` of stages, such as less for rest than flow.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub stage_flip: BTreeMap<String, f64>,
    /// Courant number, 0 to 1: step over cell size / (wave speed + point speed); default 0.9 with a `pore_fluid`, `musl` and
    /// `step_criterion` `combined`. Free surfaces bound it with `stress_update` `usl`. With `linear` and `dual-domain` without
    /// `node_mass_cutoff` bounds are 0.7, 0.57, 0.48 in 1D, 2D, 3D. In d dimensions they are `0.95 √(1/(d n))` with GIMP and CPDI of n
    /// points per cell and axis, `0.95 √(1/d)` with `quadratic`.
    #[serde(default = "courant")]
    pub courant: f64,
    /// Fixed time step (s), below the critical step, or the run stops; the solver's when absent. Steps before outputs are shorter.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// Critical step criterion, with `pore_fluid`.
    #[serde(default, skip_serializing_if = "StepCriterion::is_combined")]
    pub step_criterion: StepCriterion,
    /// Mass scaling factor, at least 1, on inertia, not weight; the stable step grows with its root. For quasi-static stages only, with a
    /// study of its effect.
    #[serde(default = "default_one")]
    pub mass_scaling: f64,
    /// Body contacts. Bodies named here have own velocity fields; all others share one, and stick where they touch.
    #[serde(default)]
    pub contacts: Vec<BodyContact>,
    /// Fixed degrees of freedom. Momentum into a wall that permits separation is always stopped, except with `wall_friction`
    /// `acceleration`.
    #[serde(default)]
    pub fixed_nodes: FixedNodes,
    /// Node mass over the heaviest point's below which nodes have no force and move with surrounding points; 1e-12 when absent. Then, with
    /// `stress_update` `usl`, lumped mass, one phase and `shape` `linear` or `dual-domain`, forces except weight are also reduced at nodes
    /// with little material. This reaches about half the squared Courant number times the number of axes into the cell at most. It keeps
    /// free surfaces stable at the cost of a little momentum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node_mass_cutoff: Option<f64>,
    /// Normal force of wall friction.
    #[serde(default)]
    pub wall_friction: WallFriction,
    /// Nodes or points on which obstacles act; default `points` where only Newtonian liquids deform.
    #[serde(default)]
    pub obstacles: ObstacleCoupling,
    /// Contact stiffness with `obstacles` `points`, above 0, at most 1000, in wave modulus times point volume over squared cell size.
    /// Points penetrate about stress / (wave modulus × stiffness) cells. Steps are shorter by `√(1 + stiffness/4)`.
    #[serde(default = "obstacle_stiffness")]
    pub obstacle_stiffness: f64,
    /// Friction coefficient of nodes at rest over that of sliding ones, at least 1, with `wall_friction` `acceleration`.
    #[serde(default = "default_one")]
    pub static_friction_ratio: f64,
    /// Nodal mass.
    #[serde(default)]
    pub mass: NodalMass,
    /// Lumped share of the mass matrix, 0 to 1 (0 excluded), with `mass` `consistent`; without it few points make it singular. From `3^-d`
    /// in `d` dimensions the step is stable for any positions; `ugimp` and `cpgimp` need that.
    #[serde(default = "default_lumped_share")]
    pub lumped_share: f64,
    /// Stretch of `cpgimp` domains.
    #[serde(default)]
    pub domain_stretch: DomainStretch,
    /// Configuration of gradients.
    #[serde(default)]
    pub formulation: LagrangianFormulation,
    /// Internal force integration.
    #[serde(default)]
    pub integration: InternalForceIntegration,
    /// Whether points of full cells take the average stress and pore pressure as their own in each step; by default only the internal force
    /// does. Needs `integration` `mixed` or `gauss`. A velocity field must have one material, whose stress is no function of internal
    /// variables.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mixed_reset: bool,
    /// Fill ratio from which a boundary cell counts as full, above 0, at most 1, with `integration` `mixed`.
    #[serde(default = "full_cell")]
    pub full_cell: f64,
    /// Source of volumetric strain; averages reduce locking of nearly incompressible materials.
    #[serde(default)]
    pub volumetric_strain: VolumetricStrain,
    /// Fill ratio of surrounding cells, below 1, under which fluid points are stress-free surface; 0 for none. The default is 0.7 where
    /// only Newtonian liquids deform, in all or a velocity field, except in periodic domains and axisymmetry.
    #[serde(default)]
    pub free_surface: Option<f64>,
    /// Largest volume of a stress-free point over its initial one, against swelling cohesionless fronts.
    #[serde(default = "volume_cap")]
    pub volume_cap: f64,
    /// Numbers of the liquid bodies in velocity fields of their own, which have `tpic` whatever transfer the others have.
    #[serde(skip)]
    #[schemars(skip)]
    pub liquid_bodies: Vec<usize>,
}

/// Mesh of triangles (plane) or tetrahedra (sheet: mpm §2.5b).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum MeshSource {
    /// Cells of `cell_size` in the domain, each two triangles or six tetrahedra.
    Box,
    /// Gmsh file of version 2.2 or 4.1, text or binary. Boundaries can name its physical groups.
    File {
        /// File, from the case's folder.
        file: String,
    },
}

impl MethodOptions for MpmOptions {
    const METHOD: &'static str = "mpm";
    const REQUIRED: &'static [&'static str] = &["cell_size"];

    fn default_options(&self) -> Self {
        Self::new(self.cell_size)
    }
}

impl MpmOptions {
    /// Options with a cell size (m) and the defaults of a case file.
    #[must_use]
    pub fn new(cell_size: f64) -> Self {
        with_defaults(&[("cell_size", cell_size)])
    }

    /// Checks the ranges; the error names the option and the rule.
    ///
    /// # Errors
    /// The first option out of range, as (name, problem).
    pub fn validate(&self) -> Result<(), (&'static str, CaseErrorKind)> {
        let needs = |problem: &str| CaseErrorKind::coded("needs-other-key", problem);
        let rule = |name, value: f64, holds: bool, rule: &str| {
            if holds { Ok(()) } else { Err((name, CaseErrorKind::out_of_range(value, rule))) }
        };
        let cell = self.cell_size;
        rule("cell_size", cell, cell.is_finite() && cell > 0.0, "must be finite and positive (m)")?;
        let per_cell = self.points_per_cell;
        rule("points_per_cell", per_cell as f64, (1..=20).contains(&per_cell), "is not in 1..=20")?;
        rule("flip", self.flip, (0.0..=1.0).contains(&self.flip), "is not in 0..=1")?;
        self.validate_transfer()?;
        let courant = self.courant;
        rule("courant", courant, courant > 0.0 && courant <= 1.0, "is not in 0..=1 (0 excluded)")?;
        if let Some(step) = self.time_step {
            rule("time_step", step, step.is_finite() && step > 0.0, "must be finite and positive (s)")?;
        }
        let scaling = self.mass_scaling;
        rule("mass_scaling", scaling, scaling.is_finite() && scaling >= 1.0, "must be at least 1")?;
        let share = self.lumped_share;
        rule("lumped_share", share, share > 0.0 && share <= 1.0, "is not in 0..=1 (0 excluded)")?;
        if share != default_lumped_share() && self.mass != NodalMass::Consistent {
            return Err(("lumped_share", needs("needs mass consistent")));
        }
        if let Some(cutoff) = self.node_mass_cutoff {
            rule("node_mass_cutoff", cutoff, (0.0..1.0).contains(&cutoff), "is not in 0..1")?;
        }
        let ratio = self.static_friction_ratio;
        rule("static_friction_ratio", ratio, ratio.is_finite() && ratio >= 1.0, "must be at least 1")?;
        if ratio > 1.0 && self.wall_friction != WallFriction::Acceleration {
            return Err(("static_friction_ratio", needs("needs wall_friction acceleration")));
        }
        if self.domain_stretch != DomainStretch::Diagonal && self.shape != ShapeFunctions::Cpgimp {
            return Err(("domain_stretch", needs("needs shape cpgimp")));
        }
        self.validate_formulation()?;
        let stiffness = self.obstacle_stiffness;
        let holds = stiffness > 0.0 && stiffness <= 1000.0;
        rule("obstacle_stiffness", stiffness, holds, "is not in 0..=1000 (0 excluded)")?;
        if stiffness != obstacle_stiffness() && self.obstacles != ObstacleCoupling::Points {
            return Err(("obstacle_stiffness", needs("needs obstacles points")));
        }
        let fill = self.full_cell;
        rule("full_cell", fill, fill > 0.0 && fill <= 1.0, "is not in 0..=1 (0 excluded)")?;
        if fill != full_cell() && self.integration != InternalForceIntegration::Mixed {
            return Err(("full_cell", needs("needs integration mixed")));
        }
        if self.mixed_reset && self.integration == InternalForceIntegration::Points {
            return Err(("mixed_reset", needs("needs integration mixed or gauss")));
        }
        if let Some(factor) = self.free_surface {
            rule("free_surface", factor, factor > 0.0 && factor < 1.0, "is not in 0..1 (0 and 1 excluded)")?;
        }
        let cap = self.volume_cap;
        rule("volume_cap", cap, cap >= 1.0, "must be at least 1")
    }

    /// Requires shape functions and options that the Lagrangian formulation supports.
    fn validate_formulation(&self) -> Result<(), (&'static str, CaseErrorKind)> {
        if self.formulation == LagrangianFormulation::SmallDisplacement {
            let deforms =
                matches!(self.shape, ShapeFunctions::Cpgimp | ShapeFunctions::Cpdi | ShapeFunctions::Cpdi2);
            let problem = "small-displacement needs points whose domains do not deform: linear, dual-domain, \
                           ugimp, quadratic, cubic or a mesh";
            return if deforms { Err(("formulation", problem.into())) } else { Ok(()) };
        }
        if self.formulation == LagrangianFormulation::UpdatedLagrangian {
            return Ok(());
        }
        if !matches!(self.shape, ShapeFunctions::Linear | ShapeFunctions::Quadratic) {
            return Err((
                "formulation",
                CaseErrorKind::coded("needs-other-key", "total-lagrangian needs shape linear or quadratic"),
            ));
        }
        if !self.contacts.is_empty() {
            let problem = "total-lagrangian does not detect contact between bodies: it needs contacts to be \
                           empty";
            return Err(("formulation", problem.into()));
        }
        Ok(())
    }

    /// Checks the options of the transfer: order of XPIC, residual time and FLIP fraction.
    fn validate_transfer(&self) -> Result<(), (&'static str, CaseErrorKind)> {
        let refuse = |name, problem: &str| Err((name, problem.into()));
        if !(1..=20).contains(&self.xpic_order) {
            let order = self.xpic_order as f64;
            return Err(("xpic_order", CaseErrorKind::out_of_range(order, "is not in 1..=20")));
        }
        if self.xpic_order != xpic_order() && !self.filters_velocities() {
            return refuse("xpic_order", "needs transfer xpic or a residual_time");
        }
        if let Some(time) = self.residual_time {
            if !(time.is_finite() && time > 0.0) {
                let rule = "must be finite and positive (s)";
                return Err(("residual_time", CaseErrorKind::out_of_range(time, rule)));
            }
            if self.transfer.is_affine() {
                return refuse(
                    "residual_time",
                    "needs transfer flip or xpic: with affine transfers the points have only the velocity of \
                     the grid",
                );
            }
        }
        for (name, none) in [("flip", self.flip == 1.0), ("stage_flip", self.stage_flip.is_empty())] {
            if !none && self.transfer != VelocityTransfer::Flip {
                return refuse(name, "needs transfer flip: the other transfers have no FLIP fraction");
            }
        }
        let spline = matches!(self.shape, ShapeFunctions::Quadratic | ShapeFunctions::Cubic);
        if self.transfer == VelocityTransfer::Apic && !spline {
            return refuse("transfer", "apic needs shape quadratic or cubic; with other shapes use tpic");
        }
        Ok(())
    }

    /// Largest Courant number in `dimension` axes at which steps with stress last are stable at free surfaces (docs/theory/mpm.md,
    /// limits). A node supported only by the end of a domain of half width `l` loses its velocity from step to step, and strains that
    /// point by `-C² h/l` times the strain that causes the force; at corners, and in fluids, as much for each axis. Beyond -2 this strain
    /// grows, and sometimes earlier: hence the factor 0.95. With linear functions it is the number at which forces of nodes within
    /// material would be reduced (`small_mass_nodes.rs`). 1 with a `node_mass_cutoff` and functions whose gradient falls faster than the
    /// root of their weight.
    pub(crate) fn surface_courant(&self, dimension: usize) -> f64 {
        let axes = dimension as f64;
        match (self.stress_update, self.half_width()) {
            // Within material the reach is a half: at this one nodes have all of their force.
            _ if self.rescales_small_mass_forces() => {
                (0.5 * ((axes * axes + 8.0 * MAX_REACH).sqrt() - axes)).sqrt().min(1.0)
            }
            (StressScheme::Usl, Some(half)) => (0.95 * (2.0 * half / axes).sqrt()).min(1.0),
            _ => 1.0,
        }
    }

    /// Whether the strain near nodes of small mass is unbounded: for stress last with shape functions whose gradients do not decrease with
    /// their weights.
    pub(crate) fn has_unbounded_small_node_strain(&self) -> bool {
        matches!(self.shape, ShapeFunctions::Linear | ShapeFunctions::DualDomain)
            && self.stress_update == StressScheme::Usl
            && self.mass == NodalMass::Lumped
    }

    /// Least extension of material into a cell for the full force of a node, at a Courant number `C`. It is `C²/2` along each axis for the
    /// node on the far side, and `C⁴/2` for nodes on the near side.
    pub(crate) fn min_reach(courant: f64, dimension: usize) -> f64 {
        let square = courant * courant;
        0.5 * square * (dimension as f64 + square)
    }

    /// Whether the forces of nodes with little material in reach are reduced.
    pub(crate) fn rescales_small_mass_forces(&self) -> bool {
        self.has_unbounded_small_node_strain() && self.node_mass_cutoff.is_none()
    }

    /// Nodal mass, as a fraction of the largest point mass, up to which a node has no force.
    pub(crate) fn mass_cutoff(&self) -> f64 {
        self.node_mass_cutoff.unwrap_or(ROUND_OFF)
    }

    /// Half the width of a point domain over the cell size, for shape functions whose gradients decrease with the square root of their
    /// weights; else `None`.
    fn half_width(&self) -> Option<f64> {
        match self.shape {
            ShapeFunctions::Ugimp | ShapeFunctions::Cpgimp | ShapeFunctions::Cpdi | ShapeFunctions::Cpdi2 => {
                Some(0.5 / self.points_per_cell as f64)
            }
            ShapeFunctions::Quadratic => Some(0.5),
            _ => None,
        }
    }

    /// Largest stable viscosity times step over density and squared cell size, at most that of sheet: mpm §2.10. With stress last a strain
    /// rate is that of the solved velocity, of which points keep only a part. One step must not reverse the shortest wave, which a liquid
    /// resists with 4/3 of its viscosity, nor the contribution of the node beyond a free surface.
    fn surface_diffusion(&self, dimension: usize) -> f64 {
        let sheet = 0.25 / dimension as f64;
        match self.stress_update {
            StressScheme::Usl => {
                let surface = self.half_width().map_or(f64::INFINITY, |half| 0.5 * half);
                sheet.min(3.0 / 16.0).min(surface)
            }
            StressScheme::Musl | StressScheme::Usf => sheet,
        }
    }

    /// Coefficients of the step limits in `dimension` axes at a Courant number of `courant`. A cell with consistent mass whose points
    /// integrate it exactly has a mode with a third of the lumped mass for each axis along which its nodes move in opposite directions; no
    /// mode has less mass than the share of the lumped mass.
    pub(crate) fn step_bounds(&self, dimension: usize, courant: f64) -> StepCoefficients {
        let inertia = match self.mass {
            NodalMass::Lumped => 1.0,
            NodalMass::Consistent => self.lumped_share.max(3f64.powi(-(dimension as i32))),
        };
        StepCoefficients {
            courant: courant.min(self.surface_courant(dimension)) * inertia.sqrt(),
            diffusion: (2.0 * courant).min(1.0) * self.surface_diffusion(dimension) * inertia,
        }
    }

    /// Factor on the wave modulus of a point for obstacle springs. At worst these add `obstacle_stiffness` times `M/(ρ h²)` to the square
    /// of the largest frequency of a cell, `4 M/(ρ h²)`.
    pub(crate) fn obstacle_stiffness_factor(&self) -> f64 {
        match self.obstacles {
            ObstacleCoupling::Nodes => 1.0,
            ObstacleCoupling::Points => 1.0 + 0.25 * self.obstacle_stiffness,
        }
    }

    /// Checks the `flip` values of single stages of the case.
    pub(crate) fn validate_stage_flip(&self, case: &Case) -> Result<(), CaseError> {
        for (name, share) in &self.stage_flip {
            let refuse =
                |problem: String| Err(CaseError::new(format!("methods.mpm.stage_flip.{name}"), problem));
            if case.stages.iter().all(|stage| stage.name != *name) {
                return refuse("is not the name of a stage".to_owned());
            }
            if !(0.0..=1.0).contains(share) {
                return refuse(format!("{share} is not in 0..=1"));
            }
        }
        Ok(())
    }

    /// Transfer of a body, by its number.
    pub(crate) fn transfer_of(&self, body: usize) -> VelocityTransfer {
        if self.liquid_bodies.contains(&body) { VelocityTransfer::Tpic } else { self.transfer }
    }

    /// Whether the null-space velocities of points are filtered.
    pub(crate) fn filters_velocities(&self) -> bool {
        self.transfer == VelocityTransfer::Xpic || self.residual_time.is_some()
    }

    /// Length of a band in cells (docs/theory/mpm.md, bands). A crack opens one cell of linear functions and point domains; splines
    /// are too smooth for that, and it opens two.
    pub(crate) fn band_cells(&self) -> f64 {
        if matches!(self.shape, ShapeFunctions::Quadratic | ShapeFunctions::Cubic) { 2.0 } else { 1.0 }
    }

    /// FLIP fraction of a stage: weight of the point velocity with its acceleration in the update, against the grid velocity.
    pub(crate) fn flip_share(&self, stage: &Stage) -> f64 {
        match self.transfer {
            VelocityTransfer::Flip => self.stage_flip.get(&stage.name).copied().unwrap_or(self.flip),
            // Its velocities are filtered before.
            VelocityTransfer::Xpic => 1.0,
            VelocityTransfer::Apic | VelocityTransfer::Tpic => 0.0,
        }
    }
}

/// Default value 1 of factors.
fn default_one() -> f64 {
    1.0
}
/// Default share of the lumped mass in the consistent mass matrix (-).
fn default_lumped_share() -> f64 {
    1e-3
}
/// Default order of XPIC.
fn xpic_order() -> usize {
    2
}
/// Default Courant number.
pub(crate) const COURANT: f64 = 0.5;

/// Default Courant number of the time step (-).
fn courant() -> f64 {
    COURANT
}
/// Default number of points per cell along each axis.
fn default_points_per_cell() -> usize {
    2
}
/// Upper limit of the extension of material into a cell, in cells, below which the forces of nodes are reduced.
const MAX_REACH: f64 = 0.375;
/// Fraction of the largest point mass that is regarded as round-off (sheet: mpm §3.2).
const ROUND_OFF: f64 = 1e-12;

/// Default value (`sheet: mpm §2.16`).
fn full_cell() -> f64 {
    0.9
}
/// Default stiffness, which halves the square of the stable step. With stiffer points the penetration is limited by the cell size.
fn obstacle_stiffness() -> f64 {
    4.0
}
/// Default upper bound of the volume of a stress-free point over its initial volume (-).
fn volume_cap() -> f64 {
    1.1
}
