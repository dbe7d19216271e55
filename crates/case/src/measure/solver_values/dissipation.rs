//! Energy dissipated by the materials.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error_collector::ErrorCollector;
use crate::measure::{MeasureDefinition, MeasuredState, ScalarOutput};

/// Energy dissipated since the start (J; per metre in plane strain, per radian in axisymmetry): work of stresses minus stored energy, or
/// all work of laws without a defined one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Dissipation {}

impl MeasureDefinition for Dissipation {
    fn check(&self, _path: &str, _errors: &mut ErrorCollector<'_>) {}

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        let dissipated = state.solver.and_then(crate::Solver::dissipated);
        vec![(name.to_owned(), "J".to_owned(), dissipated.unwrap_or(f64::NAN))]
    }

    fn needs_points(&self) -> bool {
        false
    }

    fn is_single_number(&self) -> bool {
        true
    }
}
