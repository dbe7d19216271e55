//! Contact laws between kinds of grains.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Contact law of two grain kinds, or grains and wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairSpec {
    /// Names of two kinds, or twice one; the second may be a wall (`boundaries`). Unnamed walls have the law of like grains, with their own
    /// friction.
    pub between: [String; 2],
    /// Normal law, along the line of centres.
    pub normal: NormalLaw,
    /// Tangential law.
    #[serde(default)]
    pub tangential: TangentialSpec,
    /// Coulomb friction; walls have their own.
    #[serde(default)]
    pub friction: Option<Friction>,
    /// Rolling resistance.
    #[serde(default)]
    pub rolling: Option<RollingSpec>,
    /// Torsional resistance of spheres.
    #[serde(default)]
    pub twisting: Option<RollingSpec>,
    /// Attractive force.
    #[serde(default)]
    pub adhesion: Option<Adhesion>,
    /// Initial bonds.
    #[serde(default)]
    pub bond: Option<BondSpec>,
}

impl PairSpec {
    /// Law of two kinds of grains, or of a kind and a wall, by their names, with a normal law: without friction, rolling resistance,
    /// attraction and bonds.
    #[must_use]
    pub fn new(between: [&str; 2], normal: NormalLaw) -> Self {
        Self {
            between: between.map(str::to_owned),
            normal,
            tangential: TangentialSpec::default(),
            friction: None,
            rolling: None,
            twisting: None,
            adhesion: None,
            bond: None,
        }
    }

    /// Sets a Coulomb friction coefficient (-).
    #[must_use]
    pub fn friction(self, coefficient: f64) -> Self {
        Self { friction: Some(Friction::new(coefficient)), ..self }
    }
}

/// Contact law along the line of centres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case", deny_unknown_fields)]
pub enum NormalLaw {
    /// Linear spring, dashpot (sheet: dem §2.3).
    Linear {
        /// Normal stiffness `k_n` (N/m; N/m² in the plane).
        #[serde(default)]
        stiffness: Option<f64>,
        /// Grain modulus `E` (Pa) for a stiffness `2 E r_i r_j / (r_i + r_j)` (in the plane over a metre).
        #[serde(default)]
        grain_modulus: Option<f64>,
        /// Restitution coefficient of head-on collisions, 0.01 to 1; within 0.005 at the default step (mean without `clamp`).
        #[serde(default)]
        restitution: Option<f64>,
        /// Damping ratio `ζ` in place of `restitution`, 0 to 5; dashpot `2 ζ √(k m_eff)`.
        #[serde(default)]
        damping_ratio: Option<f64>,
        /// Whether tension of spring and dashpot together is excluded; `restitution` allows for it.
        #[serde(default = "default_true")]
        clamp: bool,
    },
    /// Elastic spheres (Hertz, Mindlin); disks as spheres in a plane (sheet: dem §2.8).
    Hertz {
        /// Young's modulus (Pa).
        youngs_modulus: f64,
        /// Poisson's ratio.
        poissons_ratio: f64,
        /// Young's modulus (Pa) of the second kind or wall; the first's when absent.
        #[serde(default)]
        other_youngs_modulus: Option<f64>,
        /// Poisson's ratio of the second kind or wall; the first's when absent.
        #[serde(default)]
        other_poissons_ratio: Option<f64>,
        /// Restitution coefficient of head-on collisions at any speed, 0.01 to 1.
        #[serde(default)]
        restitution: Option<f64>,
        /// Damping ratio `ζ` in place of `restitution`, 0 to 5.
        #[serde(default)]
        damping_ratio: Option<f64>,
        /// Whether tension of both forces together is excluded.
        #[serde(default = "default_true")]
        clamp: bool,
    },
}

impl NormalLaw {
    /// Linear spring of a stiffness (N/m; in the plane per metre of thickness), without dashpot.
    #[must_use]
    pub fn linear(stiffness: f64) -> Self {
        Self::Linear {
            stiffness: Some(stiffness),
            grain_modulus: None,
            restitution: None,
            damping_ratio: None,
            clamp: default_true(),
        }
    }

    /// Elastic spheres of a Young's modulus (Pa) and a Poisson's ratio (-), without dashpot.
    #[must_use]
    pub fn hertz(youngs_modulus: f64, poissons_ratio: f64) -> Self {
        Self::Hertz {
            youngs_modulus,
            poissons_ratio,
            other_youngs_modulus: None,
            other_poissons_ratio: None,
            restitution: None,
            damping_ratio: None,
            clamp: default_true(),
        }
    }

    /// Sets a coefficient of restitution (-), 0.01 to 1.
    #[must_use]
    pub fn restitution(mut self, coefficient: f64) -> Self {
        let (Self::Linear { restitution, .. } | Self::Hertz { restitution, .. }) = &mut self;
        *restitution = Some(coefficient);
        self
    }
}

/// Spring and dashpot across the line of centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TangentialSpec {
    /// Tangential over normal stiffness, 0 to 3; by default 0.5 with `linear`, Mindlin's `4 G*/E*` with `hertz`.
    pub stiffness_ratio: Option<f64>,
    /// Tangential damping ratio `ζ`: dashpot `2 ζ √(k_t m_eff)`, with `hertz` `2 √(5/6) ζ √(S_t m_eff)`. When absent 0 with `linear`, the
    /// normal one with `hertz`.
    pub damping_ratio: Option<f64>,
    /// Spring elongation after slip.
    pub reset: SpringReset,
}

/// Spring elongation when its contact slips (sheet: dem §2.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SpringReset {
    /// Elongation that with the dashpot gives friction, at most friction over stiffness.
    #[default]
    Clip,
    /// Friction over stiffness.
    Spring,
}

/// Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Friction coefficient `μ`.
    pub coefficient: f64,
    /// Static friction coefficient; `coefficient` when absent.
    #[serde(default)]
    pub at_rest: Option<f64>,
}

impl Friction {
    /// Friction of a coefficient (-), at rest and in motion.
    #[must_use]
    pub fn new(coefficient: f64) -> Self {
        Self { coefficient, at_rest: None }
    }
}

/// Rolling or torsional spring and dashpot with largest moment (sheet: dem §2.6).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RollingSpec {
    /// Rolling friction coefficient `μ_r`: largest moment over effective radius times normal force, and tangent of the steepest slope of
    /// rest.
    pub friction: f64,
    /// Rolling stiffness over tangential stiffness times effective radius squared.
    #[serde(default = "default_one")]
    pub stiffness_ratio: f64,
    /// Damping ratio of tangential dashpot times effective radius squared.
    #[serde(default)]
    pub damping_ratio: f64,
}

impl RollingSpec {
    /// Resistance of a rolling friction coefficient (-), without dashpot.
    #[must_use]
    pub fn new(friction: f64) -> Self {
        Self { friction, stiffness_ratio: default_one(), damping_ratio: 0.0 }
    }
}

/// Attraction between grains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Adhesion {
    /// Tensile and shear strength of a contact until it breaks (sheet: dem §2.7).
    Cohesive {
        /// Tensile force over the smaller radius (N/m per metre in the plane), in space over its square (Pa).
        tension: f64,
        /// Shear force at zero normal force, as `tension`.
        shear: f64,
        /// Whether excess shear breaks contacts too.
        #[serde(default)]
        fragile: bool,
        /// Whether later contacts have strength too.
        #[serde(default)]
        new_contacts: bool,
    },
    /// Elastic spheres' adhesion (Johnson, Kendall and Roberts); with `hertz`.
    Jkr {
        /// Work of adhesion (J/m²), twice the surface energy of like grains.
        work_of_adhesion: f64,
    },
    /// Liquid bridge of spheres after contact (Rabinovich et al. 2005).
    Capillary {
        /// Surface tension (N/m).
        surface_tension: f64,
        /// Contact angle (degrees).
        #[serde(default)]
        contact_angle: f64,
        /// Bridge volume over the cube of the effective radius.
        volume_ratio: f64,
    },
}

impl Adhesion {
    /// Tensile and shear strength of the contacts at the start (N/m in the plane, Pa in space), which shear does not break.
    #[must_use]
    pub fn cohesive(tension: f64, shear: f64) -> Self {
        Self::Cohesive { tension, shear, fragile: false, new_contacts: false }
    }

    /// Liquid bridges of a surface tension (N/m) and a volume over the cube of the effective radius (-), with a contact angle of zero.
    #[must_use]
    pub fn capillary(surface_tension: f64, volume_ratio: f64) -> Self {
        Self::Capillary { surface_tension, contact_angle: 0.0, volume_ratio }
    }
}

/// Parallel bond: a beam beside the contact (Potyondy and Cundall 2004; sheet: dem §2.7).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BondSpec {
    /// Normal stiffness per area (Pa/m).
    pub normal_stiffness: f64,
    /// Shear stiffness per area (Pa/m).
    pub shear_stiffness: f64,
    /// Bond radius over the smaller grain's.
    #[serde(default = "default_one")]
    pub radius_factor: f64,
    /// Factor on moments in bond-breaking stresses.
    #[serde(default = "default_one")]
    pub moment_factor: f64,
    /// Tensile strength (Pa); unlimited when absent.
    #[serde(default)]
    pub tensile_strength: Option<f64>,
    /// Shear strength without pressure (Pa); unlimited when absent.
    #[serde(default)]
    pub cohesion: Option<f64>,
    /// Friction angle of shear strength (degrees).
    #[serde(default)]
    pub friction_angle: f64,
    /// Coefficient of variation of strengths, 0 to 1, Weibull with the given means.
    #[serde(default)]
    pub scatter: f64,
    /// Largest gap bonded at the start, over mean diameter.
    #[serde(default = "default_bond_gap")]
    pub gap: f64,
}

impl BondSpec {
    /// Bonds of a normal and a shear stiffness per area (Pa/m) that do not break.
    #[must_use]
    pub fn new(normal_stiffness: f64, shear_stiffness: f64) -> Self {
        Self {
            normal_stiffness,
            shear_stiffness,
            radius_factor: default_one(),
            moment_factor: default_one(),
            tensile_strength: None,
            cohesion: None,
            friction_angle: 0.0,
            scatter: 0.0,
            gap: default_bond_gap(),
        }
    }
}

/// Parameters of a pair in a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairOverride {
    /// Names, as in `pairs`.
    pub between: [String; 2],
    /// Normal law.
    #[serde(default)]
    pub normal: Option<NormalLaw>,
    /// Tangential law.
    #[serde(default)]
    pub tangential: Option<TangentialSpec>,
    /// Friction.
    #[serde(default)]
    pub friction: Option<Friction>,
    /// Rolling resistance; its `friction` may be 0.
    #[serde(default)]
    pub rolling: Option<RollingSpec>,
}

impl PairOverride {
    /// Pair by its names, with the laws that it has in the other stages.
    #[must_use]
    pub fn new(between: [&str; 2]) -> Self {
        Self {
            between: between.map(str::to_owned),
            normal: None,
            tangential: None,
            friction: None,
            rolling: None,
        }
    }
}

/// Default value of an option that is on unless the case turns it off.
fn default_true() -> bool {
    true
}
/// Default value 1 of factors.
fn default_one() -> f64 {
    1.0
}
/// Default largest gap of grains that are bonded.
fn default_bond_gap() -> f64 {
    0.01
}
