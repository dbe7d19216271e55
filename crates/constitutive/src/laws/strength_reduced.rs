//! Strength reduction (sheet: constitutive §3.11; Bui & Nguyen 2021, sections 4.1 and 4.3): the factor of safety of a
//! slope is the factor by which strength is divided when it fails.
//!
//! `c → c/F`, `tan φ → tan φ/F`, the dilatancy angle at most the new friction angle. With `scope: peak` the
//! residual strengths are unchanged.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Softening;
use crate::Warning;
use crate::contract::parameter_checks::{check, positive};
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::{Material, MaterialError, MaterialSpec};

/// Divided strength parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ReductionScope {
    /// Peak and residual strength.
    #[default]
    Both,
    /// Peak strength.
    Peak,
}

/// Reduction of strength: factor and scope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrengthReduction {
    /// Factor `F`, > 0.
    pub factor: f64,
    /// Strength parameters that the factor divides.
    pub scope: ReductionScope,
    /// Whether the dilatancy angle is unchanged even if it exceeds the reduced friction angle.
    pub keep_dilatancy: bool,
}

impl StrengthReduction {
    /// Returns a reduction of both strengths by `factor`.
    pub fn by_factor(factor: f64) -> Self {
        Self { factor, scope: ReductionScope::Both, keep_dilatancy: false }
    }

    /// Angle whose tangent is divided by the reduction factor (degrees).
    pub(crate) fn angle(&self, degrees: f64) -> f64 {
        (degrees.to_radians().tan() / self.factor).atan().to_degrees()
    }

    /// Dilatancy angle with the reduced friction angle (degrees).
    pub(crate) fn dilatancy(&self, dilatancy: f64, reduced_friction: f64) -> f64 {
        // Also for parameters that other checks reject.
        let bound = reduced_friction.abs();
        if self.keep_dilatancy { dilatancy } else { dilatancy.max(-bound).min(bound) }
    }

    /// Residual strengths under the scope.
    pub(crate) fn softening(&self, softening: Option<Softening>) -> Option<Softening> {
        softening.map(|s| match self.scope {
            ReductionScope::Peak => s,
            ReductionScope::Both => Softening {
                residual_friction_angle: self.angle(s.residual_friction_angle),
                residual_cohesion: s.residual_cohesion / self.factor,
                ..s
            },
        })
    }
}

/// Parameters of `strength-reduced`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StrengthReducedSpec {
    /// Divisor of the strength, positive.
    pub factor: f64,
    /// Divided strength parameters.
    #[serde(default)]
    pub scope: ReductionScope,
    /// Whether dilatancy is kept, even above reduced friction.
    #[serde(default)]
    pub keep_dilatancy: bool,
    /// Weakened material.
    pub material: Box<MaterialSpec>,
}

impl StrengthReducedSpec {
    /// Parameters from factor (-) and material; all others have the defaults of a case file.
    #[must_use]
    pub fn new(factor: f64, material: impl Into<MaterialSpec>) -> Self {
        Self {
            factor,
            material: Box::new(material.into()),
            scope: ReductionScope::default(),
            keep_dilatancy: false,
        }
    }

    /// Specification of the inner material with reduced strength.
    fn reduced_material(&self) -> Result<MaterialSpec, MaterialError> {
        self.material.strength_reduced(&self.reduction())
    }

    /// Strength reduction of the specification: factor, scope and treatment of dilatancy.
    fn reduction(&self) -> StrengthReduction {
        let Self { factor, scope, keep_dilatancy, .. } = *self;
        StrengthReduction { factor, scope, keep_dilatancy }
    }
}

impl Model for StrengthReducedSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Bui & Nguyen 2021, sections 4.1, 4.3",
        kind: ModelFamily::Wrapper,
        strain: "the inner law's",
        tangent: "the inner law's",
    };

    fn inner(&self) -> Option<&MaterialSpec> {
        Some(&self.material)
    }

    fn wrap_material(&self, _inner: Arc<dyn Material>) -> Result<Arc<dyn Material>, MaterialError> {
        positive("factor", self.factor, "")?;
        self.reduced_material()
            .and_then(|material| material.build())
            .map_err(|error| error.under_key(Self::INNER_KEY))
    }

    fn warnings(&self) -> Vec<Warning> {
        self.material.warnings().into_iter().map(|warning| warning.at("material")).collect()
    }

    fn strength_reduced(&self, reduction: &StrengthReduction) -> Option<Result<Self, MaterialError>> {
        let check = check("factor", reduction.factor, reduction.factor > 0.0, "must be positive");
        let StrengthReduction { factor, scope, keep_dilatancy } = *reduction;
        if (scope, keep_dilatancy) == (self.scope, self.keep_dilatancy) {
            return Some(check.map(|()| Self { factor: self.factor * factor, ..self.clone() }));
        }
        // For other strengths: one reduction after the other.
        let inner = check.and_then(|()| self.reduced_material());
        Some(inner.map(|inner| Self { factor, scope, keep_dilatancy, material: Box::new(inner) }))
    }

    fn examples() -> Vec<Self> {
        let around = |material, scope| Self {
            factor: 1.1,
            scope,
            keep_dilatancy: false,
            material: Box::new(material),
        };
        let mut all = Vec::new();
        for spec in MaterialSpec::examples().into_iter().filter(|spec| spec.inner().is_none()) {
            if spec.strength_reduced(&StrengthReduction::by_factor(1.1)).is_ok() && all.len() < 6 {
                all.push(around(spec, ReductionScope::Both));
            }
        }
        all
    }
}
