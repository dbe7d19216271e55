//! Relative run-out of the mass.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Side;
use crate::error_collector::ErrorCollector;
use crate::measure::points::front::{check_front, front_of_bodies};
use crate::measure::{MeasureDefinition, MeasuredState, ScalarOutput, default_fraction};

/// Relative run-out `(front - initial) / initial`, both from `origin`; the front is that of the measure `front`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunOut {
    /// Direction of the front.
    pub side: Side,
    /// Wall coordinate behind the mass (m).
    pub origin: f64,
    /// Initial length (m).
    pub initial_length: f64,
    /// Mass fraction behind the front.
    #[serde(default = "default_fraction")]
    pub quantile: f64,
    /// Column width (m), as in `front`.
    #[serde(default)]
    pub cell: Option<f64>,
    /// Bodies that count; all but rigid ones when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<Vec<String>>,
}

impl RunOut {
    /// Run-out towards a side, from a wall at `origin` (m), of a mass of the length `initial_length` (m).
    #[must_use]
    pub fn new(side: Side, origin: f64, initial_length: f64) -> Self {
        Self { side, origin, initial_length, quantile: default_fraction(), cell: None, bodies: None }
    }
}

impl MeasureDefinition for RunOut {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        check_front(path, self.side, self.quantile, self.cell, errors);
        errors.counted_bodies(path, self.bodies.as_deref());
        errors.finite(format!("{path}.origin"), self.origin);
        errors.positive(format!("{path}.initial_length"), self.initial_length, "m");
    }

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        let Self { side, origin, initial_length, quantile, cell, bodies } = self;
        let sign = if side.is_max() { 1.0 } else { -1.0 };
        let front = front_of_bodies(state, *side, *quantile, *cell, bodies.as_deref());
        let run_out = (sign * (front - origin) - initial_length) / initial_length;
        vec![(name.to_owned(), String::new(), run_out)]
    }

    fn visit_coordinates(&mut self, visit: &mut dyn FnMut(usize, &mut f64)) {
        visit(self.side.axis(), &mut self.origin);
    }

    fn is_single_number(&self) -> bool {
        true
    }
}
