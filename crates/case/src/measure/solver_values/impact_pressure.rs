//! Pressure of the material on a rigid body, a patch or an obstacle.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Reaction;
use crate::error_collector::ErrorCollector;
use crate::measure::solver_values::reaction::check_target;
use crate::measure::{MeasureDefinition, MeasuredState, ScalarOutput};

/// Pressure on a rigid body, patch or obstacle (Pa): a component of the force of the last step over an area. `NAME.impulse` (Pa s) is its
/// impulse since the start, whose slope is the mean pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImpactPressure {
    /// Rigid body, patch or obstacle.
    pub target: String,
    /// Direction of the force, of any length.
    pub direction: Vec<f64>,
    /// Area (m²; in plane strain m), as of the obstacle across the flow.
    pub area: f64,
}

impl ImpactPressure {
    /// Pressure on a rigid body, a patch or an obstacle along a direction of any length, over an area (m²; m in plane strain).
    #[must_use]
    pub fn new(target: impl Into<String>, direction: impl Into<Vec<f64>>, area: f64) -> Self {
        Self { target: target.into(), direction: direction.into(), area }
    }
}

impl MeasureDefinition for ImpactPressure {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        check_target(path, &self.target, errors);
        errors.vector(&format!("{path}.direction"), &self.direction);
        let is_zero = self.direction.iter().all(|c| *c == 0.0);
        errors.require(!is_zero, format!("{path}.direction"), "must not be zero");
        errors.positive(format!("{path}.area"), self.area, "m²; m in plane strain");
    }

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        pressure(name, state.reaction(&self.target), &self.direction, self.area).into()
    }

    fn needs_points(&self) -> bool {
        false
    }

    fn reaction_target(&self) -> Option<&str> {
        Some(&self.target)
    }
}

/// Pressure and impulse per area of a `reaction` along `direction` over `area` (m²).
fn pressure(name: &str, reaction: Option<Reaction>, direction: &[f64], area: f64) -> [ScalarOutput; 2] {
    let length = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
    let over =
        |vector: [f64; 3]| direction.iter().zip(vector).map(|(d, v)| d * v).sum::<f64>() / (length * area);
    let of = |value: fn(&Reaction) -> [f64; 3]| reaction.as_ref().map_or(f64::NAN, |r| over(value(r)));
    [
        (name.to_owned(), "Pa".to_owned(), of(|r| r.force)),
        (format!("{name}.impulse"), "Pa s".to_owned(), of(|r| r.impulse)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pressure_is_force_along_a_direction_over_an_area() {
        let reaction = Reaction { force: [30.0, 40.0, 0.0], impulse: [3.0, -4.0, 0.0], moment: None };
        let found = pressure("p", Some(reaction), &[6.0, 8.0], 2.0);
        assert!((found[0].2 - 25.0).abs() < 1e-12 && (found[1].2 + 0.7).abs() < 1e-12, "{found:?}");
        assert!(found[1].0 == "p.impulse" && pressure("p", None, &[1.0, 0.0], 2.0)[0].2.is_nan());
    }
}
