//! Laws between kinds of grains.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How grains of two kinds act on each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairSpec {
    /// Names of the two kinds, the same twice for grains of one kind; the second may be the name of a wall (`boundaries`).
    /// Grains act on a wall that is not named as on their own kind, with the friction of the wall.
    pub between: [String; 2],
    /// Along the line of centres.
    pub normal: NormalLaw,
    /// Across it.
    #[serde(default)]
    pub tangential: TangentialSpec,
    /// Friction. For walls leave it out: they say theirs.
    #[serde(default)]
    pub friction: Option<Friction>,
    /// Resistance against rolling; none when absent.
    #[serde(default)]
    pub rolling: Option<RollingSpec>,
    /// Resistance of spheres against twisting about the line of centres; none when absent.
    #[serde(default)]
    pub twisting: Option<RollingSpec>,
    /// Attraction; none when absent.
    #[serde(default)]
    pub adhesion: Option<Adhesion>,
    /// Bonds between grains that touch at the start; none when absent.
    #[serde(default)]
    pub bond: Option<BondSpec>,
}

/// A law along the line of centres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case", deny_unknown_fields)]
pub enum NormalLaw {
    /// A spring and a dashpot (sheet: dem §2.3).
    Linear {
        /// Stiffness (N/m; per metre of thickness in the plane).
        #[serde(default)]
        stiffness: Option<f64>,
        /// Modulus of the grains (Pa) in place of the stiffness, which is then `2 E r_i r_j / (r_i + r_j)`; in the plane per
        /// radius: `2 E` times that over a metre.
        #[serde(default)]
        grain_modulus: Option<f64>,
        /// Coefficient of restitution of two grains, or of a grain and a wall, that collide head-on, above 0 up to 1: with or without the
        /// `clamp`, at the default step within 0.005 (without the clamp in the mean of collisions).
        #[serde(default)]
        restitution: Option<f64>,
        /// Damping ratio ζ in its place; the dashpot of each contact is `2 ζ √(k m_eff)`.
        #[serde(default)]
        damping_ratio: Option<f64>,
        /// Whether spring and dashpot together never pull. The damping ratio that follows from `restitution` is that of the
        /// law with the clamp or without it.
        #[serde(default = "default_true")]
        clamp: bool,
    },
    /// Elastic spheres after Hertz with friction after Mindlin; disks as spheres in a plane (sheet: dem §2.8).
    Hertz {
        /// Young's modulus of the grains (Pa).
        youngs_modulus: f64,
        /// Their Poisson ratio.
        poissons_ratio: f64,
        /// Young's modulus of the other side, for pairs of unlike grains and for walls; the same when absent.
        #[serde(default)]
        other_youngs_modulus: Option<f64>,
        /// Poisson ratio of the other side; the same when absent.
        #[serde(default)]
        other_poissons_ratio: Option<f64>,
        /// Coefficient of restitution of two grains, or of a grain and a wall, that collide head-on, above 0 up to 1: with or without the
        /// `clamp`, at any speed.
        #[serde(default)]
        restitution: Option<f64>,
        /// Damping ratio in its place.
        #[serde(default)]
        damping_ratio: Option<f64>,
        /// Whether elasticity and damping together never pull.
        #[serde(default = "default_true")]
        clamp: bool,
    },
}

/// Springs across the line of centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TangentialSpec {
    /// Stiffness over that along the line of centres (0 to 3). When absent 0.5 with the law `linear`, and with `hertz` that of Mindlin,
    /// `4 G*/E*`.
    pub stiffness_ratio: Option<f64>,
    /// Damping ratio; the dashpot is `2 ζ √(k_t m_eff)`, with `hertz` `2 √(5/6) ζ √(S_t m_eff)`. When absent 0 with the law `linear`,
    /// and with `hertz` the damping ratio along the line of centres.
    pub damping_ratio: Option<f64>,
    /// Elongation of the tangential spring after a contact slips.
    pub reset: SpringReset,
}

/// Reset rule of the tangential spring when its contact slips (sheet: dem §2.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SpringReset {
    /// The elongation that with the dashpot gives the friction force, at most that force over the stiffness.
    #[default]
    Clip,
    /// The force of friction over the stiffness.
    Spring,
}

/// Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Coefficient of friction.
    pub coefficient: f64,
    /// Coefficient that must be overcome before a contact slips; the same when absent.
    #[serde(default)]
    pub at_rest: Option<f64>,
}

/// Resistance against rolling or twisting: a spring, a dashpot and a largest moment (sheet: dem §2.6).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RollingSpec {
    /// Largest moment over effective radius times normal force: the tangent of the steepest slope on which a grain stays.
    pub friction: f64,
    /// Stiffness over tangential stiffness times square of the effective radius.
    #[serde(default = "default_one")]
    pub stiffness_ratio: f64,
    /// Damping ratio; the dashpot is the tangential one of that ratio times the square of the effective radius.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// Attraction of grains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Adhesion {
    /// Tensile and shear strength of a contact until it breaks (sheet: dem §2.7).
    Cohesive {
        /// Tensile force over the smaller radius (N/m per metre in the plane), or its square in space (Pa).
        tension: f64,
        /// Shear force without pressure over the same.
        shear: f64,
        /// Whether shear beyond the cap breaks it too.
        #[serde(default)]
        fragile: bool,
        /// Whether contacts that come to be later have it as well.
        #[serde(default)]
        new_contacts: bool,
    },
    /// Adhesion of elastic spheres after Johnson, Kendall and Roberts; with `hertz`.
    Jkr {
        /// Work of adhesion (J/m²), twice the surface energy of like grains.
        work_of_adhesion: f64,
    },
    /// A bridge of liquid between spheres that have touched, after Rabinovich et al. (2005).
    Capillary {
        /// Surface tension (N/m).
        surface_tension: f64,
        /// Contact angle (degrees).
        #[serde(default)]
        contact_angle: f64,
        /// Volume of a bridge over the cube of the effective radius.
        volume_ratio: f64,
    },
}

/// A beam between two grains, in parallel with their contact (Potyondy and Cundall 2004; sheet: dem §2.7).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BondSpec {
    /// Normal stiffness per area (Pa/m).
    pub normal_stiffness: f64,
    /// Shear stiffness per area (Pa/m).
    pub shear_stiffness: f64,
    /// Radius over that of the smaller grain.
    #[serde(default = "default_one")]
    pub radius_factor: f64,
    /// Share of the moments in the stresses that break it.
    #[serde(default = "default_one")]
    pub moment_factor: f64,
    /// Tensile strength (Pa); does not break when absent.
    #[serde(default)]
    pub tensile_strength: Option<f64>,
    /// Shear strength without pressure (Pa); does not break by shear when absent.
    #[serde(default)]
    pub cohesion: Option<f64>,
    /// Angle by which shear strength grows with pressure (degrees).
    #[serde(default)]
    pub friction_angle: f64,
    /// Coefficient of variation of the strengths, which are drawn from a Weibull distribution of that mean, 0 to 1.
    #[serde(default)]
    pub scatter: f64,
    /// Largest gap over mean diameter of two grains that are bonded at the start.
    #[serde(default = "default_bond_gap")]
    pub gap: f64,
}

/// Parameters of a pair that differ in a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairOverride {
    /// The pair, as in `pairs`.
    pub between: [String; 2],
    /// Another law along the line of centres.
    #[serde(default)]
    pub normal: Option<NormalLaw>,
    /// Other springs across it.
    #[serde(default)]
    pub tangential: Option<TangentialSpec>,
    /// Other friction.
    #[serde(default)]
    pub friction: Option<Friction>,
    /// Other resistance against rolling; its `friction` may be 0.
    #[serde(default)]
    pub rolling: Option<RollingSpec>,
}

fn default_true() -> bool {
    true
}
fn default_one() -> f64 {
    1.0
}
/// Default of `gap` (sheet: dem, amendments).
fn default_bond_gap() -> f64 {
    0.01
}
