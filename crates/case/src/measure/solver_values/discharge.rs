//! Discharge of a flow across a line in plan.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::CaseErrorKind;
use crate::error_collector::ErrorCollector;
use crate::measure::{MeasureDefinition, MeasuredState, ScalarOutput, visit_position};

/// Discharge of a flow across a line in plan (m³/s), positive to the right from `from` to `to`. In 3D, for flows over terrain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Discharge {
    /// First end (m).
    pub from: [f64; 2],
    /// Second end (m).
    pub to: [f64; 2],
}

impl Discharge {
    /// Discharge across the line between two positions in plan (m).
    #[must_use]
    pub fn new(from: [f64; 2], to: [f64; 2]) -> Self {
        Self { from, to }
    }
}

impl MeasureDefinition for Discharge {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        let Self { from, to } = self;
        let has_plan = errors.case.dimension() == 3;
        errors.require(
            has_plan,
            path,
            CaseErrorKind::coded("needs-other-key", "a line across a flow needs a space of 3d"),
        );
        errors.require(from != to, format!("{path}.to"), "must differ from the start of the line");
        errors.places_inside(&format!("{path}.from"), from);
        errors.places_inside(&format!("{path}.to"), to);
    }

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        let discharge = state.solver.and_then(|solver| solver.discharge(self.from, self.to));
        vec![(name.to_owned(), "m3/s".to_owned(), discharge.unwrap_or(f64::NAN))]
    }

    fn needs_points(&self) -> bool {
        false
    }

    fn visit_coordinates(&mut self, visit: &mut dyn FnMut(usize, &mut f64)) {
        for end in [&mut self.from, &mut self.to] {
            visit_position(end, visit);
        }
    }
}
