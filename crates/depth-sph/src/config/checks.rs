//! Ranges of the options (sheet: depth-sph §7).

use colluvium_case::CaseErrorKind;
use colluvium_constitutive::MaybeInfinite;

use super::{
    ColumnOptions, DepthOptions, FluidResistanceOptions, MixtureOptions, SkeletonConfinement, SkeletonOptions,
};
use crate::config::choices::{Phases, PressureForceForm, ThicknessEquation, TimeScheme};
use crate::laws::erosion::Erosion;
use crate::laws::interphase_drag::InterphaseDrag;
use crate::laws::pore_pressure_column::MAX_CELLS;
use crate::laws::pore_pressure_column::{Drainage, LowerBound};
use colluvium_case::Warning;

/// Option that is out of range: its key and the reason.
pub type OptionError = (String, CaseErrorKind);

/// Returns the problem of an option unless the condition is true.
fn check<K: Into<CaseErrorKind>>(
    holds: bool,
    name: &str,
    problem: impl FnOnce() -> K,
) -> Result<(), OptionError> {
    if holds { Ok(()) } else { Err((name.to_owned(), problem().into())) }
}

/// Returns the error of a value of an option unless a rule holds.
fn check_rule(holds: bool, name: &str, value: f64, rule: &str) -> Result<(), OptionError> {
    check(holds, name, || CaseErrorKind::out_of_range(value, rule))
}

/// Requires a finite positive value of an option.
fn positive(name: &str, value: f64, unit: &str) -> Result<(), OptionError> {
    check_rule(value > 0.0 && value.is_finite(), name, value, &format!("must be positive{unit}"))
}

/// Requires a finite value of an option that is zero or positive.
fn not_negative(name: &str, value: f64, unit: &str) -> Result<(), OptionError> {
    check_rule(value >= 0.0 && value.is_finite(), name, value, &format!("must not be negative{unit}"))
}

/// Requires a value of an option between `low` and `high`, bounds included.
fn check_range(name: &str, value: f64, low: f64, high: f64) -> Result<(), OptionError> {
    check_rule((low..=high).contains(&value), name, value, &format!("is not in {low}..={high}"))
}

/// Result of the checks of a law, under a key.
fn under_key(key: &str, found: Result<(), (&'static str, String)>) -> Result<(), OptionError> {
    found.map_err(|(name, problem)| (format!("{key}.{name}"), problem.into()))
}

impl DepthOptions {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The key of the first value that is out of range, and the reason.
    pub fn validate(&self) -> Result<(), OptionError> {
        positive("spacing", self.spacing, " (m)")?;
        if let Some(smoothing) = self.smoothing {
            check_range("smoothing", smoothing, 1.0, 3.0)?;
        }
        if let Some(length) = self.shortest_smoothing {
            positive("shortest_smoothing", length, " (m)")?;
        }
        if let Some(length) = self.absorbing_layer {
            positive("absorbing_layer", length, " (m)")?;
        }
        let passes = self.passes;
        check_rule((1..=10).contains(&passes), "passes", passes as f64, "is not in 1..=10")?;
        let smoothing = self.terrain_smoothing;
        check_rule(smoothing <= 20, "terrain_smoothing", smoothing as f64, "is not in 0..=20")?;
        if let Some(spacing) = self.terrain_spacing {
            positive("terrain_spacing", spacing, " (m)")?;
        }
        not_negative("viscosity_linear", self.viscosity_linear, "")?;
        not_negative("viscosity_quadratic", self.viscosity_quadratic, "")?;
        check_range("xsph", self.xsph, 0.0, 1.0)?;
        let drifts = self.integration == TimeScheme::Leapfrog || self.xsph == 0.0;
        check(drifts, "xsph", || {
            CaseErrorKind::coded(
                "needs-other-key",
                "applies only with `integration` `leapfrog`: leave `xsph` or `integration` out",
            )
        })?;
        positive("courant", self.courant, "")?;
        check_range("courant", self.courant, 0.0, 0.5)?;
        if let Some(step) = self.max_time_step {
            positive("max_time_step", step, " (s)")?;
        }
        self.check_drainage()?;
        self.check_fluid_resistance()?;
        self.check_erosion()?;
        self.check_dams()?;
        if let Some(mixture) = &self.mixture {
            mixture.validate(self.phases, self.column.is_some())?;
        }
        if let Some(column) = &self.column {
            column.validate(self.mixture.as_ref())?;
        }
        self.check_earth_pressure()?;
        self.check_momentum()?;
        positive("stop.speed", self.stop.speed, " (m/s)")?;
        check_range("stop.share", self.stop.share, 0.0, 1.0)?;
        check_range("stop.kinetic_ratio", self.stop.kinetic_ratio, 0.0, 1.0)?;
        not_negative("stop.hold", self.stop.hold, " (s)")
    }

    /// Checks the drainage of the bed and of its regions, which requires pore-pressure columns.
    fn check_drainage(&self) -> Result<(), OptionError> {
        drainage("drainage", self.drainage)?;
        let without = |key: &str, requested: bool| {
            check(self.column.is_some() || !requested, key, || {
                CaseErrorKind::coded(
                    "conflicting-keys",
                    "applies only with pore-pressure columns: give `column`, or leave this out",
                )
            })
        };
        without("drainage", self.drainage != Drainage::default())?;
        for (number, region) in self.regions.iter().enumerate() {
            let key = format!("regions[{number}].drainage");
            drainage(&key, region.drainage.unwrap_or_default())?;
            without(&key, region.drainage.is_some_and(|drainage| drainage != Drainage::default()))?;
        }
        Ok(())
    }

    /// Checks the fluid resistance of the regions of the bed.
    fn check_fluid_resistance(&self) -> Result<(), OptionError> {
        for (number, region) in self.regions.iter().enumerate() {
            let key = format!("regions[{number}].fluid_resistance");
            region.fluid_resistance.unwrap_or_default().validate(&key, self.phases)?;
        }
        Ok(())
    }

    /// Checks the erosion of the bed and the erodible depth of its regions.
    fn check_erosion(&self) -> Result<(), OptionError> {
        erosion("erosion", self.erosion)?;
        for (number, region) in self.regions.iter().enumerate() {
            erosion(&format!("regions[{number}].erosion"), region.erosion)?;
            let depth = region.erodible_depth;
            erodible(&format!("regions[{number}].erodible_depth"), depth, region.erosion.is_some())?;
        }
        if let Some(last) = self.regions.last() {
            let says = last.basal.is_some()
                || last.drainage.is_some()
                || last.fluid_resistance.is_some()
                || last.erosion.is_some();
            // Within a bed with erosion a region without any key is one without erosion.
            check(says || self.erosion.is_some(), &format!("regions[{}]", self.regions.len() - 1), || {
                CaseErrorKind::coded(
                    "needs-other-key",
                    "has no property of the bed: give `basal`, `drainage`, `fluid_resistance` or `erosion`",
                )
            })?;
        }
        let erodes = self.erosion.is_some() || self.regions.iter().any(|region| region.erosion.is_some());
        erodible("erodible_depth", self.erodible_depth, erodes)?;
        let requested =
            [("erodible_depth_raster", self.erodible_depth_raster.is_some()), ("lower_bed", self.lower_bed)];
        requested.into_iter().try_for_each(|(key, requested)| {
            check(erodes || !requested, key, || {
                CaseErrorKind::coded(
                    "conflicting-keys",
                    "applies only with erosion of the bed: give `erosion`, or leave this out",
                )
            })
        })
    }

    /// Checks the line, height, width and slopes of the dams.
    fn check_dams(&self) -> Result<(), OptionError> {
        for (number, dam) in self.dams.iter().enumerate() {
            let key = |name: &str| format!("dams[{number}].{name}");
            check(dam.line.len() >= 2, &key("line"), || "has fewer than two corners".to_owned())?;
            let finite = dam.line.iter().flatten().all(|x| x.is_finite());
            check(finite, &key("line"), || "has a corner that is not finite".to_owned())?;
            positive(&key("height"), dam.height, " (m)")?;
            not_negative(&key("width"), dam.width, " (m)")?;
            positive(&key("side_slope"), dam.side_slope, "")?;
        }
        Ok(())
    }

    /// Requires one phase with depths by summation for the variational form of the pressure force.
    fn check_momentum(&self) -> Result<(), OptionError> {
        let is_plain = self.phases == Phases::One
            && self.continuity == ThicknessEquation::Summation
            && !self.surface_gradient;
        check(self.momentum != PressureForceForm::Variational || is_plain, "momentum", || {
            CaseErrorKind::coded(
                "conflicting-keys",
                "`variational` requires one phase with depths by summation: leave `phases`, `continuity` and \
             `surface_gradient` out",
            )
        })
    }

    /// Checks the friction angles of the earth-pressure coefficient.
    fn check_earth_pressure(&self) -> Result<(), OptionError> {
        let Some(earth) = &self.earth_pressure else { return Ok(()) };
        let internal = earth.internal_friction_angle;
        check_range("earth_pressure.internal_friction_angle", internal, 0.0, 89.9)?;
        let basal = earth.basal_friction_angle;
        check((0.0..=internal).contains(&basal), "earth_pressure.basal_friction_angle", || {
            format!("{basal} is not between 0 and the internal friction angle, {internal} degrees")
        })
    }

    /// Warnings about values that are allowed but unusual (sheet: depth-sph §7, units).
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let drag = self.mixture.as_ref().map(|mixture| mixture.drag);
        if let Some(InterphaseDrag::Anderson { settling_velocity: MaybeInfinite::Number(velocity), .. }) =
            drag
            && velocity > 10.0
        {
            warnings.push(Warning::new(
                "doubtful-unit",
                format!(
                    "methods.depth-sph.mixture.drag.settling_velocity: {velocity} m/s is faster than grains \
                 settle: check the unit (m/s)"
                ),
            ));
        }
        let consolidation = self.column.as_ref().and_then(|column| column.consolidation);
        if let Some(value) = consolidation.filter(|value| *value > 100.0) {
            warnings.push(Warning::new(
                "doubtful-unit",
                format!(
                    "methods.depth-sph.column.consolidation: {value} m²/s is higher than the coefficient of \
                 consolidation of soils: check the unit (m²/s)"
                ),
            ));
        }
        let of_bed = self.basal.iter().map(|spec| ("basal".to_owned(), spec));
        let of_regions = self.regions.iter().enumerate();
        let of_regions = of_regions.filter_map(|(number, region)| {
            Some((format!("regions[{number}].basal"), region.basal.as_ref()?))
        });
        for (key, spec) in of_bed.chain(of_regions) {
            let found = spec.warnings().into_iter();
            warnings.extend(found.map(|warning| warning.at(format!("methods.depth-sph.{key}"))));
        }
        warnings
    }
}

/// Requires a positive conductance (1/s) of a partly drained bed.
fn drainage(key: &str, drainage: Drainage) -> Result<(), OptionError> {
    match drainage {
        Drainage::Partly { conductance } => positive(&format!("{key}.conductance"), conductance, " (1/s)"),
        Drainage::Sealed | Drainage::Hydrostatic | Drainage::Atmospheric => Ok(()),
    }
}

/// Checks the erosion law of an option.
fn erosion(key: &str, erosion: Option<Erosion>) -> Result<(), OptionError> {
    erosion.map_or(Ok(()), |erosion| under_key(key, erosion.validate()))
}

/// Requires a finite erodible depth (m), only together with an erosion law.
fn erodible(key: &str, depth: Option<f64>, erodes: bool) -> Result<(), OptionError> {
    let Some(depth) = depth else { return Ok(()) };
    not_negative(key, depth, " (m)")?;
    check(erodes, key, || {
        CaseErrorKind::coded(
            "conflicting-keys",
            "applies only with erosion: give `erosion`, or leave this out",
        )
    })
}

impl MixtureOptions {
    /// Checks densities, porosity and drag of the mixture for the number of phases and the pore-pressure column.
    fn validate(&self, phases: Phases, column: bool) -> Result<(), OptionError> {
        let key = |name: &str| format!("mixture.{name}");
        positive(&key("grain_density"), self.grain_density, " (kg/m³)")?;
        positive(&key("fluid_density"), self.fluid_density, " (kg/m³)")?;
        let (grain, fluid) = (self.grain_density, self.fluid_density);
        let buoyant = column || !matches!(self.drag, InterphaseDrag::None);
        check(!buoyant || grain > fluid, &key("grain_density"), || {
            format!(
                "{grain} kg/m³ is not above the density of the fluid, {fluid} kg/m³: the grains would float"
            )
        })?;
        let layers = phases == Phases::Layers;
        let porosity = self.porosity;
        check(layers || (porosity > 0.0 && porosity < 1.0), &key("porosity"), || {
            format!("{porosity} is not between 0 and 1 (both excluded)")
        })?;
        check(phases == Phases::Two || self.porosities.is_empty(), &key("porosities"), || {
            CaseErrorKind::coded(
                "conflicting-keys",
                "apply only to grains and fluid with separate nodes: set `phases` to `two`, or leave them out",
            )
        })?;
        for (body, porosity) in &self.porosities {
            check(*porosity > 0.0 && *porosity < 1.0, &key(&format!("porosities.{body}")), || {
                format!("{porosity} is not between 0 and 1 (both excluded)")
            })?;
        }
        under_key("mixture.drag", self.drag.validate())?;
        check(layers != self.upper.is_empty(), &key("upper"), || {
            CaseErrorKind::coded(
                "needs-other-key",
                "must name the bodies of the upper layer if `phases` is `layers`, and must be left out otherwise",
            )
        })?;
        check_range(&key("interface_friction"), self.interface_friction, 0.0, 1.0)?;
        self.fluid_resistance.validate(&key("fluid_resistance"), phases)
    }
}

impl FluidResistanceOptions {
    /// Requires two phases and checks the parameter of the resistance law.
    fn validate(self, path: &str, phases: Phases) -> Result<(), OptionError> {
        check(self == Self::None || phases == Phases::Two, path, || {
            CaseErrorKind::coded(
                "conflicting-keys",
                "applies only to a fluid with separate nodes: set `phases` to `two`, or leave this out",
            )
        })?;
        let key = |name: &str| format!("{path}.{name}");
        match self {
            Self::None => Ok(()),
            Self::Laminar { viscosity } => not_negative(&key("viscosity"), viscosity, " (Pa s)"),
            Self::Manning { coefficient } => not_negative(&key("coefficient"), coefficient, " (s/m^⅓)"),
            Self::Turbulent { turbulence } => positive(&key("turbulence"), turbulence, " (m/s²)"),
        }
    }
}

impl ColumnOptions {
    /// Checks the discretisation and the consolidation parameters of the pore-pressure column.
    fn validate(&self, mixture: Option<&MixtureOptions>) -> Result<(), OptionError> {
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
                let problem = "is missing, and so is `skeleton`: give one of them for the rate of drainage";
                return Err((key("consolidation"), CaseErrorKind::coded("conflicting-keys", problem)));
            }
            (Some(_), Some(_)) => {
                let problem = "is given together with `skeleton`, which determines it: leave one of them out";
                return Err((key("consolidation"), CaseErrorKind::coded("conflicting-keys", problem)));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn first_error(text: &str) -> String {
        let options: DepthOptions = serde_json::from_str(text).unwrap();
        options.validate().unwrap_err().0
    }

    /// The sheet's table of bad input, by the key in the error.
    #[test]
    fn invalid_options_are_refused_by_key() {
        let table = [
            (r#"{ "spacing": 0 }"#, "spacing"),
            (r#"{ "spacing": 1, "courant": 0.6 }"#, "courant"),
            (r#"{ "spacing": 1, "smoothing": 0.9 }"#, "smoothing"),
            (r#"{ "spacing": 1, "max_time_step": 0 }"#, "max_time_step"),
            (r#"{ "spacing": 1, "erosion": { "law": "hungr", "rate": 1.1 } }"#, "erosion.rate"),
            (
                r#"{ "spacing": 1, "erodible_depth": -1, "erosion": { "law": "hungr", "rate": 0.01 } }"#,
                "erodible_depth",
            ),
            (r#"{ "spacing": 1, "erodible_depth": 1 }"#, "erodible_depth"),
            (r#"{ "spacing": 1, "lower_bed": true }"#, "lower_bed"),
            (
                r#"{ "spacing": 1, "mixture": { "grain_density": 900, "drag": { "law": "darcy", "permeability": 1 } } }"#,
                "mixture.grain_density",
            ),
            (r#"{ "spacing": 1, "mixture": { "grain_density": 2600, "porosity": 1 } }"#, "mixture.porosity"),
            (
                r#"{ "spacing": 1, "mixture": { "grain_density": 2600, "porosities": { "a": 0.4 } } }"#,
                "mixture.porosities",
            ),
            (
                r#"{ "spacing": 1, "phases": "two", "mixture": { "grain_density": 2600, "porosities": { "a": 1.4 } } }"#,
                "mixture.porosities.a",
            ),
            (
                r#"{ "spacing": 1, "mixture": { "grain_density": 2600, "drag": { "law": "anderson", "settling_velocity": 0 } } }"#,
                "mixture.drag.settling_velocity",
            ),
            (
                r#"{ "spacing": 1, "earth_pressure": { "internal_friction_angle": 20, "basal_friction_angle": 30 } }"#,
                "earth_pressure.basal_friction_angle",
            ),
        ];
        for (text, key) in table {
            assert_eq!(first_error(text), key, "{text}");
        }
    }

    #[test]
    fn invalid_column_options_are_refused_by_key() {
        let table = [
            (r#"{ "spacing": 1, "column": { "consolidation": 1 } }"#, "column"),
            (
                r#"{ "spacing": 1, "mixture": { "grain_density": 2600 }, "column": { "cells": 3, "consolidation": 1 } }"#,
                "column.cells",
            ),
            (
                r#"{ "spacing": 1, "mixture": { "grain_density": 2600 }, "column": { "weight": 0.4, "consolidation": 1 } }"#,
                "column.weight",
            ),
            (
                r#"{ "spacing": 1, "mixture": { "grain_density": 2600 }, "column": { "excess_ratio": 1.2, "consolidation": 1 } }"#,
                "column.excess_ratio",
            ),
            (
                r#"{ "spacing": 1, "mixture": { "grain_density": 2600 }, "column": {} }"#,
                "column.consolidation",
            ),
            (
                r#"{ "spacing": 1, "mixture": { "grain_density": 2600 }, "column": { "consolidation": 1, "skeleton": { "youngs_modulus": 1e7, "poissons_ratio": 0.2 } } }"#,
                "column.consolidation",
            ),
            (
                r#"{ "spacing": 1, "mixture": { "grain_density": 2600 }, "column": { "skeleton": { "youngs_modulus": 1e7, "poissons_ratio": 0.2 } } }"#,
                "column.skeleton",
            ),
        ];
        for (text, key) in table {
            assert_eq!(first_error(text), key, "{text}");
        }
    }

    #[test]
    fn implausible_units_cause_warnings() {
        let text = r#"{ "spacing": 1, "mixture": { "grain_density": 2600, "drag": { "law": "anderson", "settling_velocity": 20 } },
            "column": { "consolidation": 500 } }"#;
        let options: DepthOptions = serde_json::from_str(text).unwrap();
        assert_eq!(options.warnings().len(), 2);
    }
}
