//! Checks of the columns of pore pressure.

use colluvium_case::CaseErrorKind;

use crate::config::checks::{OptionError, check, check_range, not_negative, positive};
use crate::config::{
    ColumnOptions, DepthOptions, InterphaseDrag, MixtureOptions, SkeletonConfinement, SkeletonOptions,
};
use crate::laws::pore_pressure_column::{LowerBound, MAX_CELLS};

impl DepthOptions {
    /// Refuses a constant ratio of pore pressure beside columns, as the strength of the bed would be reduced twice.
    pub(super) fn check_pore_pressure_ratios(&self) -> Result<(), OptionError> {
        let laws = std::iter::once(("basal".to_owned(), self.basal.as_ref())).chain(
            self.regions
                .iter()
                .enumerate()
                .map(|(number, region)| (format!("regions[{number}].basal"), region.basal.as_ref())),
        );
        for (key, law) in laws.filter_map(|(key, law)| Some((key, law?))) {
            let ratio = law.build().map_or(0.0, |law| law.strength.pore_pressure_ratio);
            check(ratio == 0.0, &format!("{key}.pore_pressure_ratio"), || {
                CaseErrorKind::coded(
                    "conflicting-keys",
                    format!(
                        "{ratio} would count the pore pressure twice, as `column` computes it: leave the ratio out, and give \
                         the initial pressure as `column.excess_ratio`"
                    ),
                )
            })?;
        }
        Ok(())
    }
}

impl ColumnOptions {
    /// Checks the discretisation and the consolidation parameters of the pore-pressure column.
    pub(super) fn validate(&self, mixture: Option<&MixtureOptions>) -> Result<(), OptionError> {
        let key = |name: &str| format!("column.{name}");
        check(mixture.is_some(), "column", || {
            CaseErrorKind::coded(
                "needs-other-key",
                "requires grains and fluid: give the bodies a `pore_fluid`, or give `mixture`",
            )
        })?;
        check((4..=MAX_CELLS).contains(&self.cells), &key("cells"), || {
            format!("{} is not in 4..={MAX_CELLS}", self.cells)
        })?;
        check_range(&key("weight"), self.weight, 0.5, 1.0)?;
        check_range(&key("excess_ratio"), self.excess_ratio, 0.0, 1.0)?;
        match (self.consolidation, &self.skeleton) {
            (Some(value), None) => not_negative(&key("consolidation"), value, " (m²/s)")?,
            (None, Some(skeleton)) => {
                skeleton.validate()?;
                let permeable = mixture.is_some_and(|mixture| mixture.drag != InterphaseDrag::None);
                check(permeable, &key("skeleton"), || {
                    CaseErrorKind::coded(
                        "needs-other-key",
                        "requires the permeability: give a law of `mixture.drag`",
                    )
                })?;
            }
            (None, None) => {
                let problem = CaseErrorKind::coded(
                    "conflicting-keys",
                    "is missing, and so is `skeleton`: give one of them for the rate of drainage",
                );
                return Err((key("consolidation"), problem));
            }
            (Some(_), Some(_)) => {
                let problem = CaseErrorKind::coded(
                    "conflicting-keys",
                    "is given together with `skeleton`, which determines it: leave one of them out",
                );
                return Err((key("consolidation"), problem));
            }
        }
        if let LowerBound::Total { cavitation } = self.lower_bound {
            check_range(&key("lower_bound.cavitation"), cavitation, 0.0, 1e5)?;
        }
        let Some(dilatancy) = &self.dilatancy else { return Ok(()) };
        not_negative(&key("dilatancy.slope"), dilatancy.slope, "")?;
        check_range(&key("dilatancy.critical_porosity"), dilatancy.critical_porosity, 0.0, 1.0)?;
        check(self.skeleton.is_some(), &key("dilatancy"), || {
            CaseErrorKind::coded("needs-other-key", "requires the stiffness of the skeleton: give `skeleton`")
        })
    }
}

impl SkeletonOptions {
    /// Checks the elastic constants and the lateral confinement of the skeleton.
    fn validate(&self) -> Result<(), OptionError> {
        let key = |name: &str| format!("column.skeleton.{name}");
        positive(&key("youngs_modulus"), self.youngs_modulus, " (Pa)")?;
        let nu = self.poissons_ratio;
        check((0.0..0.5).contains(&nu), &key("poissons_ratio"), || {
            format!("{nu} is not in 0..0.5 (0.5 excluded)")
        })?;
        match self.confinement {
            SkeletonConfinement::OneDimensional | SkeletonConfinement::Isotropic => Ok(()),
            SkeletonConfinement::Lateral { k0 } => not_negative(&key("confinement.k0"), k0, ""),
            SkeletonConfinement::Source { k0 } => positive(&key("confinement.k0"), k0, ""),
            SkeletonConfinement::Value { alpha } => positive(&key("confinement.alpha"), alpha, ""),
        }
    }
}
