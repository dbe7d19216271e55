//! Basal law equivalent to a material of the other methods: fluids by their Bingham form, soils by friction and
//! cohesion.

use crate::basal::{BasalRheology, BasalSpec, BasalStrength, BinghamBaseSpec, CoulombSpec, GranularBaseSpec};
use crate::laws::StrengthReduction;
use crate::{MaterialError, MaterialSpec};

impl MaterialSpec {
    /// Basal law of a depth-integrated flow of this material over a bed of the same strength. Soils give `tan φ` and cohesion, von Mises
    /// and Tresca cohesion only, granular flow `μ(I)`, fluids Bingham's profile. For `frictional-fluid` Bingham's profile has `sin φ` and
    /// `c cos φ`, as its yield stress is `c cos φ + p sin φ`.
    ///
    /// # Errors
    /// Parameters out of range, and materials whose strength depends on a state that depth-integrated flow does not
    /// have (softening, hardening, density, water).
    pub fn basal(&self) -> Result<BasalRheology, MaterialError> {
        self.build()?;
        let own = |law: BasalRheology| BasalRheology { name: self.name(), ..law };
        self.basal_law().map(own).map_err(|error| error.with_model(self.name()))
    }

    /// Basal law that corresponds to this material: Coulomb friction for soils, Bingham for fluids with a yield stress.
    fn basal_law(&self) -> Result<BasalRheology, MaterialError> {
        let soil = |friction_angle: f64, cohesion: f64| {
            let spec = CoulombSpec { cohesion, ..CoulombSpec::new(friction_angle) };
            BasalSpec::Coulomb(spec).build()
        };
        let fluid = |yield_stress: f64, viscosity: f64| {
            BasalSpec::Bingham(BinghamBaseSpec::new(yield_stress, viscosity)).build()
        };
        match self {
            Self::MohrCoulomb(spec) if spec.softening.is_none() => soil(spec.friction_angle, spec.cohesion),
            Self::DruckerPrager(spec) if spec.softening.is_none() => soil(spec.friction_angle, spec.cohesion),
            Self::CfdSoil(spec) => soil(spec.friction_angle, spec.cohesion),
            Self::VonMises(spec) if spec.residual_cohesion.is_none() => soil(0.0, spec.cohesion),
            Self::Tresca(spec) => soil(0.0, spec.undrained_strength),
            Self::NewtonianFluid(spec) => fluid(0.0, spec.viscosity),
            Self::Bingham(spec) => fluid(spec.yield_stress, spec.viscosity),
            Self::FrictionalFluid(spec) => {
                let rheology = spec.rheology()?;
                let strength = BasalStrength {
                    friction: rheology.friction,
                    cohesion: rheology.cohesion,
                    ..BasalStrength::ZERO
                };
                Ok(BasalRheology { strength, ..fluid(0.0, spec.viscosity)? })
            }
            Self::MuI(spec) => BasalSpec::Granular(GranularBaseSpec::new(
                spec.static_friction,
                spec.limit_friction,
                spec.reference_inertial_number,
                spec.grain_diameter,
                spec.grain_density,
            ))
            .build(),
            Self::StrengthReduced(spec) => {
                let reduction = StrengthReduction {
                    factor: spec.factor,
                    scope: spec.scope,
                    keep_dilatancy: spec.keep_dilatancy,
                };
                spec.material.strength_reduced(&reduction)?.basal()
            }
            _ => {
                let (field, reason) = self.reason_without_basal_law();
                let rule =
                    format!("{reason}: depth-integrated flow of this material needs a basal law of its own");
                Err(MaterialError::incompatible_options(field, rule))
            }
        }
    }

    /// Parameter and reason for which a material has no equivalent basal law.
    fn reason_without_basal_law(&self) -> (&'static str, &'static str) {
        match self {
            Self::MohrCoulomb(_) | Self::DruckerPrager(_) => ("softening", "strength softens with strain"),
            Self::VonMises(_) => ("residual_cohesion", "strength softens with strain"),
            Self::LinearElastic(_)
            | Self::NeoHookean(_)
            | Self::StVenantKirchhoff(_)
            | Self::FixedCorotated(_)
            | Self::PressureElastic(_) => ("model", "it does not yield"),
            Self::Umat(_) => ("model", "its strength is unknown"),
            Self::TensionCut(_) | Self::DoubleScale(_) => ("model", "it yields in tension only or in bands"),
            Self::Undrained(_) | Self::SaturationSoftened(_) => {
                ("model", "its strength depends on pore water")
            }
            Self::Eigenstrain(_) => ("model", "it strains without stress"),
            _ => ("model", "its strength depends on its density or its history"),
        }
    }
}
