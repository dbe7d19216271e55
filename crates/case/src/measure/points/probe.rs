//! Fields at a position.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::CaseErrorKind;
use crate::error_collector::ErrorCollector;
use crate::measure::{AXES, FieldUse, MeasureDefinition, MeasuredState, ScalarOutput, visit_position};
use crate::output::is_plain;
use crate::{FieldData, Snapshot};

/// Mean fields of the points within `radius` of a position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Position (m).
    pub position: Vec<f64>,
    /// Radius (m).
    pub radius: f64,
    /// Names of fields.
    pub fields: Vec<String>,
}

impl Probe {
    /// Means of fields over the points within `radius` (m) of a position (m).
    #[must_use]
    pub fn new<F: Into<String>>(
        position: impl Into<Vec<f64>>,
        radius: f64,
        fields: impl IntoIterator<Item = F>,
    ) -> Self {
        Self { position: position.into(), radius, fields: fields.into_iter().map(Into::into).collect() }
    }
}

impl MeasureDefinition for Probe {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        let Self { position, radius, fields } = self;
        let dimension = errors.case.dimension();
        let problem = format!("has {} entries, the space has {dimension} dimensions", position.len());
        errors.require(
            position.len() == dimension,
            format!("{path}.position"),
            CaseErrorKind::coded("wrong-dimension", problem),
        );
        errors.places_inside(&format!("{path}.position"), position);
        errors.positive(format!("{path}.radius"), *radius, "m");
        errors.require(!fields.is_empty(), format!("{path}.fields"), "name at least one field");
        for (number, field) in fields.iter().enumerate() {
            let problem = format!("{field:?}: names of fields are made of letters, digits, _ and -");
            errors.require(is_plain(field), format!("{path}.fields[{number}]"), problem);
        }
    }

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        probe(name, state.snapshot, &self.position, self.radius, &self.fields)
    }

    fn visit_coordinates(&mut self, visit: &mut dyn FnMut(usize, &mut f64)) {
        visit_position(&mut self.position, visit);
    }

    fn fields(&self) -> Vec<FieldUse<'_>> {
        let used = |(number, name): (usize, &'_ String)| (format!("fields[{number}]"), name.clone());
        let named = self.fields.iter().enumerate().map(used);
        named.map(|(key, name)| FieldUse { key, name: name.into(), is_scalar: false }).collect()
    }

    fn has_empty_radius(&self) -> bool {
        true
    }
}

/// Values of fields at a position, as means over the points within `radius`.
fn probe(
    name: &str,
    snapshot: &Snapshot,
    place: &[f64],
    radius: f64,
    fields: &[String],
) -> Vec<ScalarOutput> {
    let near = |x: &[f64; 3]| {
        let square: f64 = place.iter().zip(x).map(|(p, x)| (p - x).powi(2)).sum();
        square <= radius * radius
    };
    let inside: Vec<usize> =
        (0..snapshot.positions.len()).filter(|&i| near(&snapshot.positions[i])).collect();
    let mean = |value: &dyn Fn(usize) -> f64| {
        // NaN without a point in the probe.
        inside.iter().map(|&i| value(i)).sum::<f64>() / inside.len() as f64
    };
    let mut readings = Vec::new();
    for wanted in fields {
        let Some(field) = snapshot.field(wanted) else {
            readings.push((format!("{name}.{wanted}"), String::new(), f64::NAN));
            continue;
        };
        let unit = || field.unit.to_owned();
        match &field.data {
            FieldData::Integer(values) => {
                readings.push((format!("{name}.{wanted}"), unit(), mean(&|i| values[i] as f64)));
            }
            FieldData::Scalar(values) => {
                readings.push((format!("{name}.{wanted}"), unit(), mean(&|i| values[i])));
            }
            FieldData::Vector(values) => {
                for (c, axis) in AXES.into_iter().enumerate() {
                    readings.push((format!("{name}.{wanted}.{axis}"), unit(), mean(&|i| values[i][c])));
                }
            }
            FieldData::Tensor(values) => {
                for (c, part) in ["xx", "yy", "zz", "xy", "yz", "zx"].into_iter().enumerate() {
                    readings.push((format!("{name}.{wanted}.{part}"), unit(), mean(&|i| values[i][c])));
                }
            }
        }
    }
    readings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::tests::line;

    #[test]
    fn a_probe_averages_the_points_within_its_radius() {
        let readings =
            probe("p", &line(&[0.0, 1.0, 5.0]), &[0.5, 0.25], 1.0, &["mass".into(), "heat".into()]);
        assert_eq!(readings[0].0, "p.mass");
        assert_eq!(readings[0].2, 1.0);
        assert!(readings[1].2.is_nan());
    }
}
