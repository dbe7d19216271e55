//! Options of `methods.mpm` in a case file.

use std::collections::BTreeMap;

use colluvium_case::description::Stage;
use colluvium_case::{Case, CaseError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the steps of a run go by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StepBounds {
    /// Step times wave speed over cell size.
    pub courant: f64,
    /// Step times viscosity over density and the square of the cell size.
    pub diffusion: f64,
}

/// Options of the explicit material point method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MpmOptions {
    /// Edge of the square (cubic) grid cells (m); the domain must be a whole number of cells wide.
    pub cell_size: f64,
    /// A mesh of triangles or tetrahedra in place of the structured grid; needs `shape` `linear`. Measures still count in
    /// columns of `cell_size`.
    #[serde(default)]
    pub mesh: Option<MeshSource>,
    /// Points per cell and direction. With a `mesh`, 1, 2 or 3 stand for 1, 3 or 6 points a triangle, and 1, 4 or 10 a
    /// tetrahedron.
    #[serde(default = "two")]
    pub points_per_cell: usize,
    /// Shape functions.
    #[serde(default)]
    pub shape: ShapeFunctions,
    /// When in the step stress is updated.
    #[serde(default)]
    pub stress_update: StressScheme,
    /// How velocities pass from the grid to the points and back.
    #[serde(default)]
    pub transfer: Transfer,
    /// With `transfer` `xpic`: its order, 1 to 20. 1 is PIC; the higher, the less is dissipated, at the cost of
    /// one more sweep over the grid each.
    #[serde(default = "xpic_order")]
    pub xpic_order: usize,
    /// With `transfer` `flip`: share of FLIP in the velocity update, 0 to 1; the rest is PIC. 1 dissipates nothing.
    #[serde(default = "one")]
    pub flip: f64,
    /// The same in single stages, by their names, in place of `flip`: bodies may come to rest with less of it than
    /// they flow with.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub stage_flip: BTreeMap<String, f64>,
    /// Courant number: the step over cell size / (wave speed + point speed), 0 to 1. Without an entry it is 0.9 in
    /// cases with a `pore_fluid` and `musl`, whose critical step is that of both phases and their drag (with
    /// `step_criterion` `combined`). With
    /// `stress_update` `usl` steps are never longer than what is stable at free surfaces: in d dimensions 0.95 times
    /// the root of 1 / (d times the points per cell and axis) with GIMP and CPDI, of 1/d with quadratic splines.
    #[serde(default = "courant")]
    pub courant: f64,
    /// Fixed time step (s), which must be below the critical one, and stops the run when it is not any more; chosen by the
    /// solver when absent. Before an output steps are shorter, so that they end at its time.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// With a `pore_fluid`: what the critical step goes by.
    #[serde(default, skip_serializing_if = "StepCriterion::is_combined")]
    pub step_criterion: StepCriterion,
    /// Factor on inertia, at least 1, but not on weight: the stable step grows with its square root. For quasi-static
    /// stages only, and with a study of how much the result depends on it.
    #[serde(default = "one")]
    pub mass_scaling: f64,
    /// Contacts between bodies. Bodies that no contact names share one velocity field and stick where they touch;
    /// each body named here has a field of its own.
    #[serde(default)]
    pub contacts: Vec<Contact>,
    /// How a held degree of freedom treats the momentum that arrives there. What runs into a wall that may let go is always
    /// stopped with its momentum, but for `wall_friction` `acceleration`.
    #[serde(default)]
    pub fixed_nodes: FixedNodes,
    /// Nodes lighter than this share of the heaviest point get no force and move with the points around
    /// them. Larger values, up to about half the square of `courant`, keep linear shape functions with
    /// `stress_update` `usl` stable at free surfaces, at the cost of a little momentum.
    #[serde(default = "mass_cutoff")]
    pub node_mass_cutoff: f64,
    /// How frictional walls find the normal force.
    #[serde(default)]
    pub wall_friction: WallFriction,
    /// With `wall_friction` `acceleration`: coefficient of friction of a node at rest over that of a node that
    /// slides, at least 1. At rest is a node without any speed along the wall.
    #[serde(default = "one")]
    pub static_friction_ratio: f64,
    /// Mass of the nodes.
    #[serde(default)]
    pub mass: Mass,
    /// With `mass` `consistent`: share of the lumped mass in the matrix, 0 to 1 (0 excluded), without which few points
    /// leave it singular. From `3^-d` on, in `d` dimensions, the step is safe however the points lie; `ugimp` and `cpgimp` need
    /// that.
    #[serde(default = "thousandth")]
    pub lumped_share: f64,
    /// What the domains of `cpgimp` points follow.
    #[serde(default)]
    pub domain_stretch: DomainStretch,
    /// Whether gradients are taken where points are or where they were at the start.
    #[serde(default)]
    pub formulation: Formulation,
    /// Over what the internal force is summed.
    #[serde(default)]
    pub integration: Integration,
    /// With `integration` `mixed` or `gauss`: whether the points of full cells take the average stress as their own at the
    /// beginning of each step, with a `pore_fluid` the average pore pressure too; by default only the internal force goes by
    /// it. Internal variables stay the points' own. For materials whose stress is no function of these, the same in all
    /// bodies that share a velocity field.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mixed_reset: bool,
    /// With `integration` `mixed`: share of its volume, above 0 and at most 1, that a cell at the boundary of the
    /// material must hold to count as full.
    #[serde(default = "full_cell")]
    pub full_cell: f64,
    /// Where volumetric strain comes from: a cure of locking, where a material keeps its volume.
    #[serde(default)]
    pub volumetric_strain: VolumetricStrain,
    /// Points of fluids where the cells around are filled to less than this share lie on the free surface and carry no
    /// stress, 0 to 1 (both excluded), e.g. 0.7; no such points when absent.
    #[serde(default)]
    pub free_surface: Option<f64>,
    /// Largest volume of a stress-free point over its initial volume: keeps the points of a
    /// cohesionless free front from swelling without bound.
    #[serde(default = "volume_cap")]
    pub volume_cap: f64,
}

/// Where a mesh of triangles (in the plane) or tetrahedra comes from (MPM sheet §2.5b).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum MeshSource {
    /// The domain, cut into cells of `cell_size` and these into two triangles or six tetrahedra each.
    Box,
    /// A file of Gmsh, in text form of version 2.2 or 4.1. Its physical groups can be named by boundaries.
    File {
        /// Path, from the folder of the case file.
        file: String,
    },
}

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

/// Where the gradients of the shape functions are taken (MPM sheet §2.5g).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "MpmFormulation")]
pub enum Formulation {
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

/// Contact of two bodies (MPM sheet §2.12): they may separate, and slide by Coulomb's law with adhesion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Names of the two bodies.
    pub bodies: [String; 2],
    /// Coefficient of friction, tangent of the friction angle of the interface.
    #[serde(default)]
    pub friction_coefficient: f64,
    /// Adhesion (Pa): shear strength of the interface without normal stress, while it is closed.
    #[serde(default)]
    pub adhesion: f64,
    /// Direction from the first body to the second, where the interface is a plane; from the gradients of the
    /// bodies' volumes when absent.
    #[serde(default)]
    pub normal: Option<Vec<f64>>,
    /// When the bodies act on each other; when absent `gap`, but `approach` where `normal` is given and on a mesh.
    #[serde(default)]
    pub test: Option<ContactTest>,
    /// A normal force that grows with the overlap of the bodies, in place of velocities that do not approach; with `test`
    /// `gap`.
    #[serde(default)]
    pub penalty: Option<Penalty>,
}

impl Contact {
    /// When the bodies act on each other, on a grid or on a mesh.
    pub fn test(&self, on_mesh: bool) -> ContactTest {
        // A plane that is given tells where bodies meet; without it what comes near would be held by its corners.
        let usual = if on_mesh || self.normal.is_some() { ContactTest::Approach } else { ContactTest::Gap };
        self.test.unwrap_or(usual)
    }

    /// Which key is wrong, and what is wrong with it.
    pub(crate) fn validate(&self, on_mesh: bool) -> Result<(), (&'static str, String)> {
        for (key, value) in [("friction_coefficient", self.friction_coefficient), ("adhesion", self.adhesion)]
        {
            if !(value.is_finite() && value >= 0.0) {
                return Err((key, format!("{value} must be finite and not negative")));
            }
        }
        let test = self.test(on_mesh);
        if on_mesh && test == ContactTest::Gap {
            let problem = "gap needs a structured grid, whose shape functions tell the distance of a surface: use approach";
            return Err(("test", problem.to_owned()));
        }
        self.penalty.map_or(Ok(()), |penalty| penalty.validate(test)).map_err(|problem| ("penalty", problem))
    }
}

/// Penalty contact (MPM sheet §4, row 58; after Ma, Zhang & Lian): the normal stress is `stiffness` times the overlap, and
/// friction ends at a shear strength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Penalty {
    /// Normal stress for an overlap of one metre (Pa/m), > 0. A step never parts the bodies by more than the overlap,
    /// however stiff they are.
    pub stiffness: f64,
    /// Largest shear stress (Pa), not negative, whatever the normal stress; no limit when absent.
    #[serde(default)]
    pub shear_strength: Option<f64>,
}

impl Penalty {
    /// What is wrong with it, beside a test of contact.
    pub(crate) fn validate(&self, test: ContactTest) -> Result<(), String> {
        if test != ContactTest::Gap {
            return Err("needs test gap, which tells the overlap".to_owned());
        }
        if !(self.stiffness.is_finite() && self.stiffness > 0.0) {
            return Err(format!("the stiffness {} must be finite and positive (Pa/m)", self.stiffness));
        }
        match self.shear_strength {
            Some(strength) if !(strength.is_finite() && strength >= 0.0) => {
                Err(format!("the shear strength {strength} must be finite and not negative (Pa)"))
            }
            _ => Ok(()),
        }
    }
}

/// When two bodies act on each other at a node that knows both, besides that their velocities approach (MPM sheet
/// §2.12).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactTest {
    /// Always: contact begins up to a cell early, and what rolls or comes near at an angle is held back. With normals from
    /// the gradients of volumes corners dig in: a block that slides down loses more than half of its acceleration.
    Approach,
    /// Where their surfaces touch, by what the node knows of their volumes and surfaces. What rests upon another
    /// bounces more, since nothing dampens the approach. Not on a mesh.
    Gap,
}

/// Mass of the nodes (MPM sheet §2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mass {
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

/// How velocities pass between points and grid (MPM sheet §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Transfer {
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

/// What the critical step of skeleton and pore fluid goes by (MPM sheet §2.10).
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
    fn is_combined(&self) -> bool {
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

/// Treatment of held degrees of freedom (MPM sheet §3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FixedNodes {
    /// Velocity and acceleration are the wall's; points keep their own velocity component.
    #[default]
    Force,
    /// The wall stops the momentum that points bring.
    Momentum,
}

/// How frictional walls find the normal force (MPM sheet §3.7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallFriction {
    /// From the momentum that the wall takes, that of arriving material included.
    #[default]
    Impulse,
    /// From the acceleration into the wall.
    Acceleration,
}

/// What the domains of `cpgimp` points follow (MPM sheet §2.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DomainStretch {
    /// The diagonal of the deformation gradient: for bodies that stretch along the axes.
    #[default]
    Diagonal,
    /// The diagonal of the right stretch tensor, which a rotation leaves as it is.
    RightStretch,
}

impl Transfer {
    /// Whether points carry more of the velocity than its value.
    pub(crate) fn is_affine(self) -> bool {
        matches!(self, Self::Apic | Self::Tpic)
    }
}

/// Over what the internal force is summed (MPM sheet §2.16).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "MpmIntegration")]
pub enum Integration {
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

/// Where the volumetric strain of a point comes from (MPM sheet §2.17).
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

impl MpmOptions {
    /// Checks the ranges; the error names the option and the rule.
    ///
    /// # Errors
    /// The first option out of range, as (name, problem).
    pub fn validate(&self) -> Result<(), (&'static str, String)> {
        let rule = |name, value: f64, holds: bool, rule: &str| {
            if holds { Ok(()) } else { Err((name, format!("{value} {rule}"))) }
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
        if share != thousandth() && self.mass != Mass::Consistent {
            return Err(("lumped_share", "needs mass consistent".to_owned()));
        }
        let cutoff = self.node_mass_cutoff;
        rule("node_mass_cutoff", cutoff, (0.0..1.0).contains(&cutoff), "is not in 0..1")?;
        let ratio = self.static_friction_ratio;
        rule("static_friction_ratio", ratio, ratio.is_finite() && ratio >= 1.0, "must be at least 1")?;
        if ratio > 1.0 && self.wall_friction != WallFriction::Acceleration {
            return Err(("static_friction_ratio", "needs wall_friction acceleration".to_owned()));
        }
        if self.domain_stretch != DomainStretch::Diagonal && self.shape != ShapeFunctions::Cpgimp {
            return Err(("domain_stretch", "needs shape cpgimp".to_owned()));
        }
        self.validate_formulation()?;
        let fill = self.full_cell;
        rule("full_cell", fill, fill > 0.0 && fill <= 1.0, "is not in 0..=1 (0 excluded)")?;
        if fill != full_cell() && self.integration != Integration::Mixed {
            return Err(("full_cell", "needs integration mixed".to_owned()));
        }
        if self.mixed_reset && self.integration == Integration::Points {
            return Err(("mixed_reset", "needs integration mixed or gauss".to_owned()));
        }
        if let Some(factor) = self.free_surface {
            rule("free_surface", factor, factor > 0.0 && factor < 1.0, "is not in 0..1 (0 and 1 excluded)")?;
        }
        let cap = self.volume_cap;
        rule("volume_cap", cap, cap >= 1.0, "must be at least 1")
    }

    fn validate_formulation(&self) -> Result<(), (&'static str, String)> {
        if self.formulation == Formulation::SmallDisplacement {
            let deforms =
                matches!(self.shape, ShapeFunctions::Cpgimp | ShapeFunctions::Cpdi | ShapeFunctions::Cpdi2);
            let problem = "small-displacement needs points whose domains stay as they are: linear, dual-domain, ugimp, \
                           quadratic, cubic or a mesh";
            return if deforms { Err(("formulation", problem.to_owned())) } else { Ok(()) };
        }
        if self.formulation == Formulation::UpdatedLagrangian {
            return Ok(());
        }
        if !matches!(self.shape, ShapeFunctions::Linear | ShapeFunctions::Quadratic) {
            return Err(("formulation", "total-lagrangian needs shape linear or quadratic".to_owned()));
        }
        if !self.contacts.is_empty() {
            let problem = "total-lagrangian cannot tell when bodies meet: it needs contacts to be empty";
            return Err(("formulation", problem.to_owned()));
        }
        Ok(())
    }

    fn validate_transfer(&self) -> Result<(), (&'static str, String)> {
        let refuse = |name, problem: &str| Err((name, problem.to_owned()));
        if !(1..=20).contains(&self.xpic_order) {
            return Err(("xpic_order", format!("{} is not in 1..=20", self.xpic_order)));
        }
        if self.xpic_order != xpic_order() && self.transfer != Transfer::Xpic {
            return refuse("xpic_order", "needs transfer xpic");
        }
        for (name, none) in [("flip", self.flip == 1.0), ("stage_flip", self.stage_flip.is_empty())] {
            if !none && self.transfer != Transfer::Flip {
                return refuse(name, "needs transfer flip: the other transfers have no share of it");
            }
        }
        let spline = matches!(self.shape, ShapeFunctions::Quadratic | ShapeFunctions::Cubic);
        if self.transfer == Transfer::Apic && !spline {
            return refuse("transfer", "apic needs shape quadratic or cubic; with other shapes use tpic");
        }
        Ok(())
    }

    /// The largest Courant number in `dimension` axes at which steps with stress last are stable at free surfaces
    /// (docs/theory/mpm.md, limits). A node that only the end of a domain of half width `l` reaches forgets its velocity
    /// from step to step, and strains that point by `-C² h/l` times the strain that makes the force; at corners, and in
    /// fluids, as much for each axis. Beyond -2 that grows, and some of it before: a twentieth is kept back. 1 with linear functions, which `node_mass_cutoff` keeps stable,
    /// and with functions whose gradient falls faster than the root of their weight.
    pub(crate) fn surface_courant(&self, dimension: usize) -> f64 {
        match (self.stress_update, self.half_width()) {
            (StressScheme::Usl, Some(half)) => (0.95 * (2.0 * half / dimension as f64).sqrt()).min(1.0),
            _ => 1.0,
        }
    }

    /// Half the width of the domain of a point over the cell size, where the gradients of its functions fall with the
    /// root of their weights.
    fn half_width(&self) -> Option<f64> {
        match self.shape {
            ShapeFunctions::Ugimp | ShapeFunctions::Cpgimp | ShapeFunctions::Cpdi | ShapeFunctions::Cpdi2 => {
                Some(0.5 / self.points_per_cell as f64)
            }
            ShapeFunctions::Quadratic => Some(0.5),
            _ => None,
        }
    }

    /// The largest viscosity times step over density and the square of the cell size, in `dimension` axes, at which momentum
    /// diffuses in good order: that of the sheet (§2.10) or less. With stress last a strain rate is that of the solved
    /// velocity, of which points keep a part only: neither the shortest wave, which a liquid resists with 4/3 of its
    /// viscosity, nor what the node beyond a free surface adds, must be turned in one step.
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

    /// What steps go by in `dimension` axes at a Courant number of `courant`. A cell with consistent mass whose points
    /// integrate it exactly has a mode with a third of the lumped mass for each axis along which its nodes move against each
    /// other; none has less than the share of the lumped mass.
    pub(crate) fn step_bounds(&self, dimension: usize, courant: f64) -> StepBounds {
        let inertia = match self.mass {
            Mass::Lumped => 1.0,
            Mass::Consistent => self.lumped_share.max(3f64.powi(-(dimension as i32))),
        };
        StepBounds {
            courant: courant.min(self.surface_courant(dimension)) * inertia.sqrt(),
            diffusion: (2.0 * courant).min(1.0) * self.surface_diffusion(dimension) * inertia,
        }
    }

    /// Checks the shares that single stages of the case have.
    pub(crate) fn validate_stage_flip(&self, case: &Case) -> Result<(), CaseError> {
        for (name, share) in &self.stage_flip {
            let refuse =
                |problem: String| Err(CaseError::new(format!("methods.mpm.stage_flip.{name}"), problem));
            if case.stages.iter().all(|stage| stage.name != *name) {
                return refuse("is the name of no stage".to_owned());
            }
            if !(0.0..=1.0).contains(share) {
                return refuse(format!("{share} is not in 0..=1"));
            }
        }
        Ok(())
    }

    /// Share of the old velocity and of the acceleration in the update of a point in a stage; the rest is the grid's
    /// velocity.
    pub(crate) fn flip_share(&self, stage: &Stage) -> f64 {
        match self.transfer {
            Transfer::Flip => self.stage_flip.get(&stage.name).copied().unwrap_or(self.flip),
            // Its velocities are filtered before.
            Transfer::Xpic => 1.0,
            Transfer::Apic | Transfer::Tpic => 0.0,
        }
    }
}

fn one() -> f64 {
    1.0
}
fn thousandth() -> f64 {
    1e-3
}
fn xpic_order() -> usize {
    2
}
/// The Courant number of cases that say none.
pub(crate) const COURANT: f64 = 0.5;

fn courant() -> f64 {
    COURANT
}
fn two() -> usize {
    2
}
/// Of MPM sheet §3.2: what round-off leaves.
fn mass_cutoff() -> f64 {
    1e-12
}
/// Of MPM sheet §2.16.
fn full_cell() -> f64 {
    0.9
}
fn volume_cap() -> f64 {
    1.1
}
