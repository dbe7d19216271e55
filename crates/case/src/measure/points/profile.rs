//! Profile of the surface along an axis.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::CaseErrorKind;
use crate::Snapshot;
use crate::error_collector::ErrorCollector;
use crate::measure::{MeasureDefinition, MeasuredState, ScalarOutput};

/// Height of the surface in bins along an axis, written at each frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Axis of the bins: 0 is x.
    pub axis: usize,
    /// Axis of height.
    pub height: usize,
    /// Bin width (m).
    pub bin: f64,
    /// Bodies that count; all but rigid ones when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<Vec<String>>,
}

impl Profile {
    /// Surface along the axis `axis`, as heights along the axis `height`, in bins of the width `bin` (m).
    #[must_use]
    pub fn new(axis: usize, height: usize, bin: f64) -> Self {
        Self { axis, height, bin, bodies: None }
    }
}

impl MeasureDefinition for Profile {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        let Self { axis, height, bin, bodies } = self;
        errors.counted_bodies(path, bodies.as_deref());
        let dimension = errors.case.dimension();
        let fits = *axis < dimension && *height < dimension && axis != height;
        let problem = format!("{axis} and height {height} must be two different axes of the space");
        errors.require(fits, format!("{path}.axis"), CaseErrorKind::coded("wrong-dimension", problem));
        errors.positive(format!("{path}.bin"), *bin, "m");
    }

    /// No columns: the profile has a table of its own.
    fn read(&self, _name: &str, _state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        Vec::new()
    }

    fn profile(&self, state: &MeasuredState<'_>) -> Option<Vec<(f64, f64)>> {
        let Self { axis, height, bin, bodies } = self;
        let origin = state.case.origin();
        let heights = profile(&state.counted_points(bodies.as_deref()), *axis, *height, *bin);
        Some(heights.into_iter().map(|(x, top)| (x + origin[*axis], top + origin[*height])).collect())
    }
}

/// Height of the surface in bins of width `bin` (m) along `axis`: pairs of bin centre and height (m).
pub fn profile(snapshot: &Snapshot, axis: usize, height: usize, bin: f64) -> Vec<(f64, f64)> {
    let mut bins: BTreeMap<i64, f64> = BTreeMap::new();
    for (position, extent) in snapshot.positions.iter().zip(&snapshot.extents) {
        let number = (position[axis] / bin).floor() as i64;
        let top = position[height] + 0.5 * extent[height];
        let entry = bins.entry(number).or_insert(f64::NEG_INFINITY);
        *entry = entry.max(top);
    }
    bins.into_iter().map(|(number, top)| ((number as f64 + 0.5) * bin, top)).collect()
}
