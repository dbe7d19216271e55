//! Fragments of bodies: connected pieces and their masses (sheet: snow-mpm §3.11).

use colluvium_points::{CellList, UnionFind};

use super::ScalarOutput;
use crate::{FieldRole, Snapshot};

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
pub(super) fn scalar_outputs(
    name: &str,
    snapshot: &Snapshot,
    link: f64,
    minimum: usize,
) -> Vec<ScalarOutput> {
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
