//! Basal laws of a case file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BasalDrag, BasalRheology, BasalStrength, BinghamSolution, CohesionForm};
use crate::Warning;
use crate::contract::parameter_checks::{check, not_negative, positive};
use crate::{MaterialError, MaybeInfinite};

/// Friction angle (degrees) above which there is a warning.
const MAX_FRICTION_ANGLE: f64 = 50.0;
/// Friction angle (degrees) below which there is a warning: it is probably a friction coefficient.
const MIN_FRICTION_ANGLE: f64 = 1.0;
/// Turbulence coefficients (m/s²) without a warning.
const TURBULENCE: std::ops::RangeInclusive<f64> = 20.0..=20_000.0;

/// Basal law. The pore-pressure ratio is water's constant share of the normal stress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "model", deny_unknown_fields)]
pub enum BasalSpec {
    /// No shear stress.
    #[serde(rename = "none")]
    Frictionless {},
    /// Bingham fluid.
    #[serde(rename = "bingham")]
    Bingham(BinghamBaseSpec),
    /// Friction, viscous power law.
    #[serde(rename = "viscous-frictional")]
    ViscousFrictional(ViscousFrictionalSpec),
    /// Friction, turbulence.
    #[serde(rename = "voellmy")]
    Voellmy(VoellmySpec),
    /// Friction alone.
    #[serde(rename = "coulomb")]
    Coulomb(CoulombSpec),
    /// Dense granular flow, μ(I).
    #[serde(rename = "mu-i")]
    Granular(GranularBaseSpec),
    /// Friction, turbulence by Manning's roughness.
    #[serde(rename = "manning")]
    Manning(ManningSpec),
    /// Friction, turbulence by Chézy's coefficient.
    #[serde(rename = "chezy")]
    Chezy(ChezySpec),
}

impl BasalSpec {
    /// Builds the law, with parameters checked and angles converted.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn build(&self) -> Result<BasalRheology, MaterialError> {
        let (name, law) = match self {
            Self::Frictionless {} => return Ok(BasalRheology::FRICTIONLESS),
            Self::Bingham(spec) => ("bingham", spec.law()),
            Self::ViscousFrictional(spec) => ("viscous-frictional", spec.law()),
            Self::Voellmy(spec) => ("voellmy", spec.law()),
            Self::Coulomb(spec) => ("coulomb", spec.law()),
            Self::Granular(spec) => ("mu-i", spec.law()),
            Self::Manning(spec) => ("manning", spec.law()),
            Self::Chezy(spec) => ("chezy", spec.law()),
        };
        let (strength, drag) = law.map_err(|error| error.with_model(name))?;
        Ok(BasalRheology { name, strength, drag })
    }

    /// Warnings about valid but unusual parameter values, each with the name of the parameter.
    pub fn warnings(&self) -> Vec<Warning> {
        let angle = match self {
            Self::ViscousFrictional(ViscousFrictionalSpec { friction_angle, .. })
            | Self::Voellmy(VoellmySpec { friction_angle, .. })
            | Self::Coulomb(CoulombSpec { friction_angle, .. })
            | Self::Bingham(BinghamBaseSpec { friction_angle, .. })
            | Self::Manning(ManningSpec { friction_angle, .. })
            | Self::Chezy(ChezySpec { friction_angle, .. }) => *friction_angle,
            Self::Frictionless {} | Self::Granular(_) => 0.0,
        };
        let mut warnings = Vec::new();
        if angle > MAX_FRICTION_ANGLE {
            warnings.push(Warning::new(
                "large-friction-angle",
                format!(
                    "friction_angle: {angle} degrees is more than that of any bed ({MAX_FRICTION_ANGLE} degrees). \
                     Check the value, which is an angle and no coefficient"
                ),
            ));
        }
        if angle > 0.0 && angle < MIN_FRICTION_ANGLE {
            warnings.push(Warning::new(
                "doubtful-unit",
                format!(
                    "friction_angle: {angle} degrees is nearly no friction. For a friction coefficient of {angle} \
                     give {:.3} degrees; for no friction give 0",
                    angle.atan().to_degrees()
                ),
            ));
        }
        if let Self::Voellmy(VoellmySpec { turbulence: MaybeInfinite::Number(turbulence), .. }) = self
            && !TURBULENCE.contains(turbulence)
        {
            warnings.push(Warning::new(
                "doubtful-unit",
                format!(
                    "turbulence: {turbulence} m/s² is far from that of flows and avalanches, 100 to 4000 m/s². \
                     Check the unit"
                ),
            ));
        }
        warnings
    }

    /// Example laws that include all variants of each law, for tests.
    pub fn examples() -> Vec<Self> {
        let bingham = |friction_angle, solution| {
            Self::Bingham(BinghamBaseSpec {
                yield_stress: 200.0,
                friction_angle,
                pore_pressure_ratio: 0.0,
                viscosity: 50.0,
                solution,
            })
        };
        vec![
            Self::Frictionless {},
            bingham(0.0, BinghamSolution::Exact),
            bingham(0.0, BinghamSolution::Quadratic),
            bingham(5.0, BinghamSolution::Exact),
            Self::ViscousFrictional(ViscousFrictionalSpec::new(15.0, 0.8, 2.0)),
            Self::ViscousFrictional(ViscousFrictionalSpec::new(15.0, 300.0, 0.5)),
            Self::Voellmy(VoellmySpec::new(15.0, 600.0.into())),
            Self::Voellmy(VoellmySpec {
                cohesion: 500.0,
                cohesion_form: CohesionForm::Ramms,
                pore_pressure_ratio: 0.3,
                ..VoellmySpec::new(15.0, MaybeInfinite::INFINITE)
            }),
            Self::Coulomb(CoulombSpec { cohesion: 300.0, ..CoulombSpec::new(15.0) }),
            Self::Granular(GranularBaseSpec::new(0.38, 0.64, 0.279, 0.01, 2450.0)),
            Self::Manning(ManningSpec::new(15.0, 0.1)),
            Self::Chezy(ChezySpec::new(15.0, 25.0)),
        ]
    }
}

/// Strength and drag of a basal law, or the error of its first invalid parameter.
type StrengthAndDrag = Result<(BasalStrength, BasalDrag), MaterialError>;

/// Friction coefficient `tan φ` of an angle in degrees.
fn friction(angle: f64) -> Result<f64, MaterialError> {
    let rule = "is not in 0..90 degrees (90 excluded)";
    check("friction_angle", angle, (0.0..90.0).contains(&angle), rule)?;
    Ok(angle.to_radians().tan())
}

/// Checks that the ratio of pore pressure to total normal stress is between 0 and 1.
fn pore_pressure_ratio(ratio: f64) -> Result<f64, MaterialError> {
    check("pore_pressure_ratio", ratio, (0.0..=1.0).contains(&ratio), "is not between 0 and 1")?;
    Ok(ratio)
}

/// Parameters of `bingham`, angles in degrees. The yield stress is `yield_stress + σ' tan φ`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BinghamBaseSpec {
    /// Yield stress `τ_y` (Pa), non-negative.
    pub yield_stress: f64,
    /// Friction angle (degrees), non-negative, below 90; adds `σ' tan φ` to yield.
    #[serde(default)]
    pub friction_angle: f64,
    /// Pore-pressure ratio `r_u`, 0 to 1.
    #[serde(default)]
    pub pore_pressure_ratio: f64,
    /// Plastic viscosity `μ` (Pa s), non-negative.
    pub viscosity: f64,
    /// Solution of the cubic.
    #[serde(default)]
    pub solution: BinghamSolution,
}

impl BinghamBaseSpec {
    /// Returns a fluid with a constant yield stress, solved exactly.
    pub fn new(yield_stress: f64, viscosity: f64) -> Self {
        let solution = BinghamSolution::Exact;
        Self { yield_stress, friction_angle: 0.0, pore_pressure_ratio: 0.0, viscosity, solution }
    }

    /// Strength and Bingham drag of the checked parameters.
    fn law(&self) -> StrengthAndDrag {
        not_negative("yield_stress", self.yield_stress, "Pa")?;
        not_negative("viscosity", self.viscosity, "Pa s")?;
        let strength = BasalStrength {
            friction: friction(self.friction_angle)?,
            cohesion: self.yield_stress,
            form: CohesionForm::Constant,
            pore_pressure_ratio: pore_pressure_ratio(self.pore_pressure_ratio)?,
        };
        Ok((strength, BasalDrag::Bingham { viscosity: self.viscosity, solution: self.solution }))
    }
}

/// Law with a strength of friction and cohesion: its own parameters, and those common to all such laws.
macro_rules! frictional {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $kind:ty,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $($(#[$field_doc])* pub $field: $kind,)*
            /// Cohesion `c` (Pa), non-negative.
            #[serde(default)]
            pub cohesion: f64,
            /// Cohesion form.
            #[serde(default)]
            pub cohesion_form: CohesionForm,
            /// Pore-pressure ratio `r_u`, 0 to 1.
            #[serde(default)]
            pub pore_pressure_ratio: f64,
        }

        impl $name {
            /// Returns the law without cohesion or pore pressure.
            pub fn new($($field: $kind),*) -> Self {
                let cohesion_form = CohesionForm::Constant;
                Self { $($field,)* cohesion: 0.0, cohesion_form, pore_pressure_ratio: 0.0 }
            }

            /// Basal strength of the cohesion and a friction coefficient (-), with the parameters checked.
            fn strength(&self, friction: f64) -> Result<BasalStrength, MaterialError> {
                not_negative("cohesion", self.cohesion, "Pa")?;
                if self.cohesion_form == CohesionForm::Ramms && friction > 1.0 {
                    let rule = "the form ramms is for friction angles up to 45 degrees";
                    return Err(MaterialError::incompatible_options("cohesion_form", rule));
                }
                Ok(BasalStrength {
                    friction,
                    cohesion: self.cohesion,
                    form: self.cohesion_form,
                    pore_pressure_ratio: pore_pressure_ratio(self.pore_pressure_ratio)?,
                })
            }
        }
    };
}

frictional! {
    /// Parameters of `viscous-frictional`, angles in degrees.
    ViscousFrictionalSpec {
        /// Friction angle (degrees), non-negative, below 90.
        friction_angle: f64,
        /// Consistency `μ` (Pa sᵐ), non-negative.
        consistency: f64,
        /// Power `m` of the shear rate, positive: 1 viscous, 2 grain inertia.
        exponent: f64,
    }
}

impl ViscousFrictionalSpec {
    /// Frictional strength and power-law viscous drag of the checked parameters.
    fn law(&self) -> StrengthAndDrag {
        let friction = friction(self.friction_angle)?;
        not_negative("consistency", self.consistency, "Pa sᵐ")?;
        positive("exponent", self.exponent, "")?;
        let drag = BasalDrag::Viscous { consistency: self.consistency, exponent: self.exponent };
        Ok((self.strength(friction)?, drag))
    }
}

frictional! {
    /// Parameters of `voellmy`, angles in degrees.
    VoellmySpec {
        /// Friction angle (degrees), non-negative, below 90.
        friction_angle: f64,
        /// Turbulence coefficient `ξ` (m/s²), positive, or `"none"`.
        turbulence: MaybeInfinite,
    }
}

impl VoellmySpec {
    /// Frictional strength and turbulent (Voellmy) drag of the checked parameters.
    fn law(&self) -> StrengthAndDrag {
        let friction = friction(self.friction_angle)?;
        let coefficient = self.turbulence.check_positive("turbulence", "m/s²")?;
        Ok((self.strength(friction)?, BasalDrag::Turbulent { coefficient }))
    }
}

frictional! {
    /// Parameters of `coulomb`, angles in degrees.
    CoulombSpec {
        /// Friction angle (degrees), non-negative, below 90.
        friction_angle: f64,
    }
}

impl CoulombSpec {
    /// Coulomb strength of the checked parameters, without drag.
    fn law(&self) -> StrengthAndDrag {
        Ok((self.strength(friction(self.friction_angle)?)?, BasalDrag::None))
    }
}

frictional! {
    /// Parameters of `mu-i`: dense granular flow whose profile is Bagnold's (Pouliquen & Forterre 2002; Jop et al.
    /// 2006).
    GranularBaseSpec {
        /// Friction coefficient at rest `μ_s`, above 0, below 2.
        static_friction: f64,
        /// Friction coefficient `μ_2` in fast flow: at least `static_friction`, below 2.
        limit_friction: f64,
        /// Inertial number `I_0` at halfway friction, positive.
        reference_inertial_number: f64,
        /// Grain diameter (m), positive.
        grain_diameter: f64,
        /// Grain density (kg/m³), positive.
        grain_density: f64,
    }
}

impl GranularBaseSpec {
    /// Strength at the static friction and the rate-dependent granular drag of the checked parameters.
    fn law(&self) -> StrengthAndDrag {
        let (low, high) = (self.static_friction, self.limit_friction);
        crate::laws::mu_i::check_friction(low, high)?;
        positive("reference_inertial_number", self.reference_inertial_number, "")?;
        positive("grain_diameter", self.grain_diameter, "m")?;
        positive("grain_density", self.grain_density, "kg/m³")?;
        let drag = BasalDrag::Granular {
            friction_range: high - low,
            reference: self.reference_inertial_number,
            diameter: self.grain_diameter,
            grain_density: self.grain_density,
        };
        Ok((self.strength(low)?, drag))
    }
}

frictional! {
    /// Parameters of `manning`, angles in degrees.
    ManningSpec {
        /// Friction angle (degrees), non-negative, below 90.
        friction_angle: f64,
        /// Manning's roughness `n` (s/m^⅓), non-negative.
        roughness: f64,
    }
}

impl ManningSpec {
    /// Frictional strength and Manning drag of the checked parameters.
    fn law(&self) -> StrengthAndDrag {
        let friction = friction(self.friction_angle)?;
        not_negative("roughness", self.roughness, "s/m^⅓")?;
        Ok((self.strength(friction)?, BasalDrag::Manning { roughness: self.roughness }))
    }
}

frictional! {
    /// Parameters of `chezy`, angles in degrees.
    ChezySpec {
        /// Friction angle (degrees), non-negative, below 90.
        friction_angle: f64,
        /// Chézy's coefficient `C` (m^½/s), positive: `ξ = C²`.
        coefficient: f64,
    }
}

impl ChezySpec {
    /// Frictional strength and turbulent drag of the checked parameters, whose coefficient is the square of Chézy's.
    fn law(&self) -> StrengthAndDrag {
        let friction = friction(self.friction_angle)?;
        positive("coefficient", self.coefficient, "m^½/s")?;
        Ok((
            self.strength(friction)?,
            BasalDrag::Turbulent { coefficient: self.coefficient * self.coefficient },
        ))
    }
}
