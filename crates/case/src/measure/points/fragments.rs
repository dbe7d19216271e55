//! Fragments of bodies: connected pieces and their masses (sheet: snow-mpm §3.11).

use std::borrow::Cow;

use colluvium_points::{CellList, UnionFind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error_collector::ErrorCollector;
use crate::measure::{
    FieldUse, MeasureDefinition, MeasuredState, ScalarOutput, counted_points, point_subset,
};
use crate::output::is_plain;
use crate::{FieldRole, Snapshot};

/// Number of points of the smallest fragment that counts, where the case gives none (sheet: snow-mpm §3.11).
const fn default_min_points() -> usize {
    20
}

/// Fragments of broken bodies: columns `NAME.count`, `NAME.largest` and `NAME.second` (kg), and `NAME.loose` (kg), the mass of those too
/// small to count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fragments {
    /// Largest distance of connected points (m): 1 to 1.5 grid cells.
    pub link: f64,
    /// Points of the smallest counted fragment.
    #[serde(default = "default_min_points")]
    pub least: usize,
    /// Criterion of broken points, which connect no fragments; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub broken: Option<BreakageCriterion>,
    /// Bodies that count; all but rigid ones when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<Vec<String>>,
}

/// Criterion of broken points, by a field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BreakageCriterion {
    /// Number field: `compressive_strength` of `cohesive-cam-clay`, zero where broken.
    pub field: String,
    /// Largest value at broken points.
    #[serde(default)]
    pub max: f64,
}

impl Fragments {
    /// Fragments whose points are connected within the distance `link` (m).
    #[must_use]
    pub fn new(link: f64) -> Self {
        Self { link, least: default_min_points(), broken: None, bodies: None }
    }
}

impl MeasureDefinition for Fragments {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        errors.counted_bodies(path, self.bodies.as_deref());
        errors.positive(format!("{path}.link"), self.link, "m");
        if let Some(broken) = &self.broken {
            errors.finite(format!("{path}.broken.max"), broken.max);
            let problem = format!("{:?}: names of fields are made of letters, digits, _ and -", broken.field);
            errors.require(is_plain(&broken.field), format!("{path}.broken.field"), problem);
        }
    }

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        let whole = match &self.broken {
            Some(broken) => unbroken_points(state.snapshot, broken),
            None => Cow::Borrowed(state.snapshot),
        };
        let counted = counted_points(state.case, &whole, self.bodies.as_deref());
        scalar_outputs(name, &counted, self.link, self.least)
    }

    fn fields(&self) -> Vec<FieldUse<'_>> {
        let used = |broken: &'_ BreakageCriterion| FieldUse {
            key: "broken.field".to_owned(),
            name: broken.field.clone().into(),
            is_scalar: true,
        };
        self.broken.iter().map(used).collect()
    }
}

/// Points that are not broken by the criterion. All points where the snapshot lacks the field of the criterion.
fn unbroken_points<'a>(snapshot: &'a Snapshot, broken: &BreakageCriterion) -> Cow<'a, Snapshot> {
    let Some(values) = snapshot.scalars(&broken.field) else { return Cow::Borrowed(snapshot) };
    // Points without the value, such as those of another law, have not broken.
    let kept: Vec<usize> = (0..values.len()).filter(|&i| !(values[i] <= broken.max)).collect();
    Cow::Owned(point_subset(snapshot, &kept))
}

/// Masses of the connected pieces of at least `minimum` points (kg), largest first, and the mass of smaller pieces (kg). Points within a
/// distance `link` (m) are connected. `None` where positions or masses are not finite.
pub fn fragments(snapshot: &Snapshot, link: f64, minimum: usize) -> Option<(Vec<f64>, f64)> {
    let mass = snapshot.role_values(FieldRole::Mass)?;
    let mut cells = CellList::<3>::new();
    // Slightly larger cells, so that round-off does not place a neighbour in a cell that is not searched.
    cells.build(&snapshot.positions, link * (1.0 + 1e-6)).ok()?;
    let mut joined = UnionFind::new(mass.len());
    for (i, place) in snapshot.positions.iter().enumerate() {
        cells.visit(place, |j| {
            let other = &snapshot.positions[j as usize];
            let square: f64 = place.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum();
            if (j as usize) < i && square <= link * link * (1.0 + 1e-9) {
                joined.union(i, j as usize);
            }
        });
    }
    let mut pieces = vec![(0usize, 0.0); mass.len()];
    for (i, mass) in mass.iter().enumerate() {
        let piece = &mut pieces[joined.root(i)];
        *piece = (piece.0 + 1, piece.1 + mass);
    }
    let loose = pieces.iter().filter(|(count, _)| *count < minimum).map(|(_, mass)| mass).sum();
    let mut large: Vec<f64> = pieces
        .into_iter()
        .filter(|(count, _)| *count > 0 && *count >= minimum)
        .map(|(_, mass)| mass)
        .collect();
    large.sort_by(|a, b| b.total_cmp(a));
    Some((large, loose))
}

/// Columns of the measure `name`.
fn scalar_outputs(name: &str, snapshot: &Snapshot, link: f64, minimum: usize) -> Vec<ScalarOutput> {
    let found = fragments(snapshot, link, minimum);
    let size = |number: usize| {
        found.as_ref().map_or(f64::NAN, |(large, _)| large.get(number).copied().unwrap_or(0.0))
    };
    let count = found.as_ref().map_or(f64::NAN, |(large, _)| large.len() as f64);
    let loose = found.as_ref().map_or(f64::NAN, |(_, loose)| *loose);
    let entries =
        [("count", "", count), ("largest", "kg", size(0)), ("second", "kg", size(1)), ("loose", "kg", loose)];
    entries.map(|(column, unit, value)| (format!("{name}.{column}"), unit.to_owned(), value)).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::tests::line;

    #[test]
    fn broken_points_do_not_connect_fragments() {
        let mut row = line(&[0.0, 0.1, 0.2, 0.3, 0.4]);
        let strength = FieldData::Scalar(vec![1.0, 2.0, 0.0, f64::NAN, 1.0]);
        row.fields.push(Field { name: "strength".into(), unit: "Pa", data: strength });
        let broken = |at_most: f64| BreakageCriterion { field: "strength".into(), max: at_most };
        let pieces = |broken: &BreakageCriterion| {
            let whole = unbroken_points(&row, broken);
            fragments(&whole, 0.12, 1).unwrap().0
        };
        assert_eq!(pieces(&broken(0.0)), [2.0, 2.0]);
        assert_eq!(pieces(&broken(1.0)), [1.0, 1.0]);
        assert_eq!(pieces(&BreakageCriterion { field: "none".into(), max: 9.0 }), [5.0]);
    }

    use crate::{Field, FieldData};

    #[test]
    fn points_within_the_link_distance_form_one_fragment() {
        // Pieces of five, three and one points, in mixed order.
        let places = [0.0, 5.0, 0.1, 9.0, 0.2, 5.1, 0.3, 5.2, 0.4];
        let snapshot = Snapshot {
            time: 0.0,
            step: 0,
            ids: (0..9).collect(),
            bodies: vec![0; 9],
            positions: places.map(|x| [x, 0.0, 0.0]).into(),
            extents: vec![[0.1; 3]; 9],
            fields: vec![Field { name: "mass".into(), unit: "kg", data: FieldData::Scalar(vec![2.0; 9]) }],
        };
        assert_eq!(fragments(&snapshot, 0.1, 1), Some((vec![10.0, 6.0, 2.0], 0.0)));
        assert_eq!(fragments(&snapshot, 0.1, 3), Some((vec![10.0, 6.0], 2.0)));
        assert_eq!(fragments(&snapshot, 5.0, 3), Some((vec![18.0], 0.0)));
        assert_eq!(fragments(&snapshot, 0.09, 2), Some((vec![], 18.0)));
    }
}
