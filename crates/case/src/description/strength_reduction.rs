//! Strength reduction in a stage, and the search for the factor of safety.

use colluvium_constitutive::laws::{ReductionScope, StrengthReduction};
use colluvium_constitutive::{MaterialError, MaterialSpec};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::description::{EquilibriumCriterion, Stage};
use crate::{Case, CaseError, Measure};

/// Strength reduction of materials: `c → c/F`, `tan φ → tan φ/F`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Weakening {
    /// Factor `F`, positive.
    pub factor: f64,
    /// Divided strength parameters.
    #[serde(default)]
    pub scope: ReductionScope,
    /// Materials; all with strength when absent.
    #[serde(default)]
    pub materials: Option<Vec<String>>,
}

/// Sets that an initial stress outside the yield surface is returned to it, also in wrapped materials.
fn set_return_to_yield(material: &mut MaterialSpec) {
    match material {
        MaterialSpec::DruckerPrager(spec) => spec.return_initial_stress_to_yield = true,
        MaterialSpec::MohrCoulomb(spec) => spec.return_initial_stress_to_yield = true,
        MaterialSpec::Tresca(spec) => spec.return_initial_stress_to_yield = true,
        MaterialSpec::VonMises(spec) => spec.return_initial_stress_to_yield = true,
        MaterialSpec::Sand(spec) => spec.return_initial_stress_to_yield = true,
        MaterialSpec::Eigenstrain(spec) => set_return_to_yield(&mut spec.material),
        MaterialSpec::StrengthReduced(spec) => set_return_to_yield(&mut spec.material),
        MaterialSpec::Undrained(spec) => set_return_to_yield(&mut spec.skeleton),
        // Other materials have no strength reduction.
        _ => {}
    }
}

/// Search for a factor of safety by strength reduction (after sheet: sph §3.5; the criteria differ,
/// docs/theory/sph.md). Only `after` must be given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FactorOfSafety {
    /// Stage at whose end the bodies rest with full strength.
    pub after: String,
    /// Longest trial (s), in twelve windows; if bodies neither rest nor clearly fail, the search is undecided. When absent a window is the
    /// time to rest without yielding after removal of half the weight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration: Option<f64>,
    /// Slope height (m). Bodies have failed when a hundredth has moved by more than 0.02 of it plus their elastic settlement. When absent
    /// the height range of the free surface, or of the bodies if it is level.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Smallest and largest factor.
    #[serde(default = "range")]
    pub range: [f64; 2],
    /// Final interval width of the factor.
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
    /// Local damping of trials, 0 to 1. With little damping bodies oscillate too long, and trials remain undecided.
    #[serde(default = "strong_damping")]
    pub damping: f64,
    /// Divided strength parameters.
    #[serde(default)]
    pub scope: ReductionScope,
    /// Materials; all with strength when absent.
    #[serde(default)]
    pub materials: Option<Vec<String>>,
}

impl Weakening {
    /// Division of all strengths by a factor (-).
    #[must_use]
    pub fn new(factor: f64) -> Self {
        Self { factor, scope: ReductionScope::default(), materials: None }
    }
}

impl FactorOfSafety {
    /// Search after the stage of this name, with the defaults of a case file.
    #[must_use]
    pub fn new(after: impl Into<String>) -> Self {
        Self {
            after: after.into(),
            duration: None,
            height: None,
            range: range(),
            tolerance: default_tolerance(),
            damping: strong_damping(),
            scope: ReductionScope::default(),
            materials: None,
        }
    }
}

/// Local damping with about the fastest decay of elastic vibrations (Cundall 1987).
const STRONG_DAMPING: f64 = 0.8;

/// Default damping of the trials of a search for the factor of safety.
fn strong_damping() -> f64 {
    STRONG_DAMPING
}

/// Default range of the factors of safety that a search considers.
fn range() -> [f64; 2] {
    [0.5, 3.0]
}

/// sheet: sph §3.5.
fn default_tolerance() -> f64 {
    0.01
}

impl FactorOfSafety {
    /// Case of a trial of at most `duration` (s), with the strength divided by `factor`. Its stages are those up to the state at rest, and
    /// one more with the reduced strength.
    pub fn trial(&self, case: &Case, name: &str, factor: f64, duration: f64) -> Case {
        let mut case = case.clone();
        let rest = case.stages.iter().position(|stage| stage.name == self.after).map_or(0, |n| n + 1);
        case.stages.truncate(rest);
        case.stages.push(Stage {
            name: format!("{name}: {factor}"),
            duration,
            damping: self.damping,
            damping_axes: None,
            rayleigh_damping: 0.0,
            gravity_ramp: 0.0,
            // For the unbalanced force.
            equilibrium: Some(EquilibriumCriterion::default()),
            motions: Vec::new(),
            reset: Vec::new(),
            remove_boundaries: Vec::new(),
            remove_bodies: Vec::new(),
            excavate: Vec::new(),
            weakening: Some(Weakening { factor, scope: self.scope, materials: self.materials.clone() }),
        });
        case.measures.clear();
        case
    }

    /// Case in which half of the weight is removed from bodies that do not yield, for at most `duration` (s). It differs from
    /// [`FactorOfSafety::trial`] by the smallest factor of the range and strong damping.
    pub fn unloading(&self, case: &Case, name: &str, duration: f64) -> Case {
        let mut case = self.trial(case, name, self.range[0].min(1.0), duration);
        case.gravity.iter_mut().for_each(|g| *g *= 0.5);
        if let Some(stage) = case.stages.last_mut() {
            (stage.name, stage.damping) = (format!("{name}: unloading"), STRONG_DAMPING);
        }
        case
    }
}

impl Case {
    /// Strength reduction in effect in stage number `stage`.
    pub fn weakening(&self, stage: usize) -> Option<&Weakening> {
        self.stages.iter().take(stage.saturating_add(1)).rev().find_map(|stage| stage.weakening.as_ref())
    }

    /// Case with the materials of stage number `stage`. Weakened materials return their initial stress to yield: that of the full strength
    /// may lie outside the reduced yield surface, and a state at the start of the stage replaces it anyway.
    ///
    /// # Errors
    /// When the strength of a material cannot be reduced, with the path of the stage.
    pub fn with_weakening(&self, stage: usize) -> Result<Self, CaseError> {
        let Some(number) =
            (0..=stage).rev().find(|&n| self.stages.get(n).is_some_and(|s| s.weakening.is_some()))
        else {
            return Ok(self.clone());
        };
        let path = format!("stages[{number}].weakening");
        self.weakening(number).map_or(Ok(self.clone()), |weakening| self.with_strength(weakening, &path))
    }

    /// Case whose materials have the strength reduced by `weakening`; `path` is that of the reduction, for errors.
    fn with_strength(&self, weakening: &Weakening, path: &str) -> Result<Self, CaseError> {
        let mut case = self.clone();
        let reduction =
            StrengthReduction { factor: weakening.factor, scope: weakening.scope, keep_dilatancy: false };
        let mut any = false;
        for (name, spec) in &mut case.materials {
            let named = weakening.materials.as_ref().map(|names| names.contains(name));
            if named == Some(false) {
                continue;
            }
            match spec.strength_reduced(&reduction) {
                Ok(reduced) => {
                    (*spec, any) = (reduced, true);
                    set_return_to_yield(spec);
                }
                Err(MaterialError::IncompatibleOptions { field, .. })
                    if named.is_none() && field == "model" => {}
                Err(error) => return Err(CaseError::new(path, format!("material {name:?}: {error}"))),
            }
        }
        if any { Ok(case) } else { Err(CaseError::new(path, "no material has a strength to reduce")) }
    }

    /// Searches for a factor of safety, with their names.
    pub fn factors_of_safety(&self) -> impl Iterator<Item = (&str, &FactorOfSafety)> {
        self.measures.iter().filter_map(|(name, measure)| match measure {
            Measure::FactorOfSafety(search) => Some((name.as_str(), search)),
            _ => None,
        })
    }

    /// Checks that the materials at both ends of the range of a search can be built.
    pub(crate) fn check_search(&self, search: &FactorOfSafety) -> Result<(), String> {
        for factor in search.range {
            let weakening = Weakening { factor, scope: search.scope, materials: search.materials.clone() };
            let weak = self.with_strength(&weakening, "").map_err(|error| error.problem())?;
            for (name, spec) in &weak.materials {
                spec.build().map_err(|error| format!("material {name:?} at {factor}: {error}"))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use colluvium_constitutive::laws::EigenstrainSpec;
    use serde_json::Value;

    use super::*;

    fn innermost_law(spec: &MaterialSpec) -> &MaterialSpec {
        spec.inner().map_or(spec, innermost_law)
    }

    #[test]
    fn reduced_laws_return_an_initial_stress_outside_the_reduced_yield_surface() {
        let reduction = StrengthReduction::by_factor(1.05);
        let mut all = MaterialSpec::examples();
        let drying = |material: &MaterialSpec| {
            let material = Box::new(material.clone());
            MaterialSpec::Eigenstrain(EigenstrainSpec { volumetric_strain: 0.0, duration: 1.0, material })
        };
        all.extend(all.iter().map(drying).collect::<Vec<_>>());
        all.extend(MaterialSpec::wrapped_examples());
        let mut names: Vec<&str> = Vec::new();
        for mut reduced in all.iter().filter_map(|spec| spec.strength_reduced(&reduction).ok()) {
            set_return_to_yield(&mut reduced);
            let law = serde_json::to_value(innermost_law(&reduced)).unwrap();
            assert_eq!(
                law["return_initial_stress_to_yield"],
                Value::Bool(true),
                "{} around {}",
                reduced.name(),
                law["model"]
            );
            names.push(reduced.name());
        }
        for name in ["mohr-coulomb", "undrained", "eigenstrain", "strength-reduced"] {
            assert!(names.contains(&name), "{name} is not among {names:?}");
        }
    }
}
