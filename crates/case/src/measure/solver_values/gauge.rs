//! Depth and velocity of a flow at a position in plan.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::CaseErrorKind;
use crate::error_collector::ErrorCollector;
use crate::measure::{AXES, MeasureDefinition, MeasuredState, ScalarOutput, visit_position};

/// Vertical depth of a flow (m) and velocity in plan (m/s): columns `NAME.depth`, `NAME.velocity.x`, …; no velocity where dry. For flows
/// over terrain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gauge {
    /// Position without height (m).
    pub position: Vec<f64>,
}

impl Gauge {
    /// Gauge at a position in plan (m).
    #[must_use]
    pub fn new(position: impl Into<Vec<f64>>) -> Self {
        Self { position: position.into() }
    }
}

impl MeasureDefinition for Gauge {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        let (axes, plan) = (self.position.len(), errors.case.dimension() - 1);
        let problem =
            CaseErrorKind::coded("wrong-dimension", format!("has {axes} coordinates, the plan has {plan}"));
        errors.require(axes == plan, format!("{path}.position"), problem);
        errors.places_inside(&format!("{path}.position"), &self.position);
    }

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        let found = state.solver.and_then(|solver| solver.gauge(&self.position));
        let (depth, velocity) = found.unwrap_or((f64::NAN, [f64::NAN; 3]));
        let axes = AXES.iter().zip(velocity).take(state.case.dimension() - 1);
        let velocities = axes.map(|(axis, v)| (format!("{name}.velocity.{axis}"), "m/s".to_owned(), v));
        [(format!("{name}.depth"), "m".to_owned(), depth)].into_iter().chain(velocities).collect()
    }

    fn needs_points(&self) -> bool {
        false
    }

    fn visit_coordinates(&mut self, visit: &mut dyn FnMut(usize, &mut f64)) {
        visit_position(&mut self.position, visit);
    }
}
