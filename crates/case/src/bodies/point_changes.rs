//! Points that a program adds to a body, or takes away, between two steps.

use std::collections::HashSet;
use std::fmt::Display;
use std::hash::Hash;

use crate::bodies::point_file::coinciding_points;
use crate::{Case, CaseError, CaseErrorKind, PointList, Space};

/// Entry of a column that is not valid: its index, and the reason.
type InvalidEntry = Option<(usize, CaseErrorKind)>;

impl Case {
    /// Checks points that a program adds to a body, by its index: their columns have equal lengths and valid values, and the points are
    /// distinct and in the domain. `axes` is the number of coordinates of a position: those in plan for methods that have no others.
    ///
    /// # Errors
    /// The first invalid value, by the path `points.COLUMN[INDEX]`; the path `body` for a body that the case does not have. A volume is
    /// invalid where it is larger than the domain, and a position on the axis of symmetry, where a point has no volume.
    pub fn check_added_points(&self, body: usize, points: &PointList, axes: usize) -> Result<(), CaseError> {
        if body >= self.bodies.len() {
            let rule = format!("must be below {}, the number of bodies", self.bodies.len());
            return Err(CaseError::new("body", CaseErrorKind::out_of_range(body as f64, rule)));
        }
        let count = points.positions.len();
        for (column, length) in points.column_lengths() {
            if length != count {
                let rule = format!("{count} are needed, one for each position");
                return Err(CaseError::new(
                    format!("points.{column}"),
                    CaseErrorKind::WrongLength { length, rule },
                ));
            }
        }
        let columns = [
            (
                "positions",
                self.invalid_position(&points.positions, axes).or_else(|| self.on_axis(&points.positions)),
            ),
            ("volumes", not_positive(&points.volumes).or_else(|| self.too_large(&points.volumes))),
            ("masses", points.masses.as_deref().and_then(not_positive)),
            ("velocities", points.velocities.as_deref().and_then(|all| not_finite(all, |v| v))),
            ("stresses", points.stresses.as_deref().and_then(|all| not_finite(all, |stress| &stress.0))),
            (
                "pore_pressures",
                points.pore_pressures.as_deref().and_then(|all| not_finite(all, std::slice::from_ref)),
            ),
            ("grains.radii", points.grains.radii.as_deref().and_then(not_positive)),
            ("grains.spins", points.grains.spins.as_deref().and_then(|all| not_finite(all, |spin| spin))),
        ];
        for (column, invalid) in columns {
            if let Some((index, problem)) = invalid {
                return Err(CaseError::new(format!("points.{column}[{index}]"), problem));
            }
        }
        let used = |x: &[f64; 3]| std::array::from_fn(|c| if c < axes { x[c] } else { 0.0 });
        let positions: Vec<[f64; 3]> = points.positions.iter().map(used).collect();
        match coinciding_points(&positions) {
            Some([a, b]) => {
                Err(CaseError::new(format!("points.positions[{b}]"), format!("is the position of point {a}")))
            }
            None => Ok(()),
        }
    }

    /// First position that is not finite or outside the domain.
    fn invalid_position(&self, positions: &[[f64; 3]], axes: usize) -> InvalidEntry {
        let (min, max) = (&self.domain.min[..axes], &self.domain.max[..axes]);
        let is_inside =
            |x: &[f64; 3]| x.iter().zip(min).zip(max).all(|((x, min), max)| (min..=max).contains(&x));
        // Comparisons with NaN are false.
        let index = positions.iter().position(|x| !is_inside(x))?;
        let own = &positions[index][..axes];
        Some((
            index,
            CaseErrorKind::coded(
                "outside-domain",
                format!("{own:?} m is outside the domain, from {min:?} to {max:?} m"),
            ),
        ))
    }

    /// First position on the axis of symmetry, where the volume of a point is zero.
    fn on_axis(&self, positions: &[[f64; 3]]) -> InvalidEntry {
        let index = positions.iter().position(|x| self.space == Space::Axisymmetric && x[0] == 0.0)?;
        Some((index, "is on the axis of symmetry, where a point has no volume".into()))
    }

    /// First volume larger than that of the domain.
    fn too_large(&self, volumes: &[f64]) -> InvalidEntry {
        let sides = self.domain.min.iter().zip(&self.domain.max);
        let domain: f64 = sides.map(|(min, max)| max - min).product();
        let index = volumes.iter().position(|volume| *volume > domain)?;
        let rule = format!("must be at most {domain}, the volume of the domain");
        Some((index, CaseErrorKind::out_of_range(volumes[index], rule)))
    }
}

impl PointList {
    /// Refuses columns that a method does not use.
    ///
    /// # Errors
    /// The first column that is present, among the `unused` ones.
    pub fn reject_columns(&self, unused: &[&str], method: &str) -> Result<(), CaseError> {
        match self.column_lengths().iter().find(|(column, _)| unused.contains(column)) {
            Some((column, _)) => Err(CaseError::new(
                format!("points.{column}"),
                CaseErrorKind::coded("conflicting-keys", format!("is not used by {method}: leave it out")),
            )),
            None => Ok(()),
        }
    }

    /// Names and lengths of the columns that the list has, beside the positions.
    fn column_lengths(&self) -> Vec<(&'static str, usize)> {
        let grains = &self.grains;
        let optional = [
            ("masses", self.masses.as_ref().map(Vec::len)),
            ("velocities", self.velocities.as_ref().map(Vec::len)),
            ("stresses", self.stresses.as_ref().map(Vec::len)),
            ("pore_pressures", self.pore_pressures.as_ref().map(Vec::len)),
            ("grains.radii", grains.radii.as_ref().map(Vec::len)),
            ("grains.grain_types", grains.grain_types.as_ref().map(Vec::len)),
            ("grains.spins", grains.spins.as_ref().map(Vec::len)),
            ("grains.is_held", grains.is_held.as_ref().map(Vec::len)),
            ("grains.ids", grains.ids.as_ref().map(Vec::len)),
        ];
        let present = optional.into_iter().filter_map(|(name, length)| Some((name, length?)));
        [("volumes", self.volumes.len())].into_iter().chain(present).collect()
    }
}

/// Columns of grains, which only methods with grains use.
pub const GRAIN_COLUMNS: [&str; 5] =
    ["grains.radii", "grains.grain_types", "grains.spins", "grains.is_held", "grains.ids"];

impl CaseError {
    /// Error about the points of a body in a case, as one of the points that a program adds to it.
    #[must_use]
    pub fn of_added_points(mut self, body: usize) -> Self {
        let own = format!("bodies[{body}].");
        if let Some(key) = self.path.strip_prefix(&own) {
            self.path = match key.split_once('.').map_or(key, |(first, _)| first) {
                "stress" => "points.stresses".to_owned(),
                "pore_fluid" => "points.pore_pressures".to_owned(),
                "velocity" => "points.velocities".to_owned(),
                "shape" => "points.positions".to_owned(),
                "points" => "points".to_owned(),
                _ => self.path,
            };
        } else if self.path == "bodies" {
            "points.positions".clone_into(&mut self.path);
        }
        self
    }
}

/// First entry that is not a positive finite number.
fn not_positive(column: &[f64]) -> InvalidEntry {
    let index = column.iter().position(|value| !(value.is_finite() && *value > 0.0))?;
    Some((index, CaseErrorKind::out_of_range(column[index], "must be positive")))
}

/// First entry with a component that is not finite.
fn not_finite<T>(column: &[T], components: impl Fn(&T) -> &[f64]) -> InvalidEntry {
    let index = column.iter().position(|entry| !components(entry).iter().all(|value| value.is_finite()))?;
    Some((index, CaseErrorKind::NotFinite(format!("{:?} must be finite", components(&column[index])))))
}

/// Set of the points that a program removes, of which each must be among the points that there are.
///
/// # Errors
/// The first number that is not the number of a point, by the path `ids[INDEX]`.
pub fn removed_points<T: Copy + Eq + Hash + Display>(
    ids: &[T],
    existing: impl Iterator<Item = T>,
) -> Result<HashSet<T>, CaseError> {
    let removed: HashSet<T> = ids.iter().copied().collect();
    let found: HashSet<T> = existing.filter(|id| removed.contains(id)).collect();
    match ids.iter().position(|id| !found.contains(id)) {
        Some(index) => {
            Err(CaseError::new(format!("ids[{index}]"), format!("no point has the number {}", ids[index])))
        }
        None => Ok(removed),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::point_file::GrainColumns;
    use crate::{Body, Domain, Space, Stage};

    /// Square in a domain of 1 m.
    fn case() -> Case {
        Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [1.0, 1.0]))
            .material("soil", colluvium_constitutive::LinearElasticSpec::new(1000.0, 1e6, 0.3))
            .body(Body::block("square", "soil", [0.0, 0.0], [0.5, 0.5]))
            .stage(Stage::new("rest", 1.0))
    }

    /// Two points in the domain.
    fn points() -> PointList {
        PointList {
            positions: vec![[0.2, 0.3, 0.0], [0.4, 0.3, 0.0]],
            volumes: vec![0.01; 2],
            ..PointList::default()
        }
    }

    #[test]
    fn invalid_points_are_named_by_column_and_index() {
        assert_eq!(case().check_added_points(0, &points(), 2), Ok(()));
        let [a, b] = [[0.2, 0.3, 0.0], [0.4, 1.3, 0.0]];
        for (path, wrong) in [
            ("points.positions[1]", PointList { positions: vec![a, b], ..points() }),
            ("points.positions[1]", PointList { positions: vec![a, a], ..points() }),
            ("points.positions[0]", PointList { positions: vec![[f64::NAN, 0.0, 0.0], a], ..points() }),
            ("points.volumes", PointList { volumes: vec![0.01], ..points() }),
            ("points.volumes[1]", PointList { volumes: vec![0.01, 0.0], ..points() }),
            ("points.masses[0]", PointList { masses: Some(vec![f64::INFINITY, 1.0]), ..points() }),
            ("points.velocities", PointList { velocities: Some(vec![a; 3]), ..points() }),
            ("points.velocities[1]", PointList { velocities: Some(vec![a, [f64::NAN; 3]]), ..points() }),
            (
                "points.grains.radii[0]",
                PointList {
                    grains: GrainColumns { radii: Some(vec![-1.0, 1.0]), ..GrainColumns::default() },
                    ..points()
                },
            ),
        ] {
            assert_eq!(case().check_added_points(0, &wrong, 2).unwrap_err().path, path, "{wrong:?}");
        }
        assert_eq!(case().check_added_points(1, &points(), 2).unwrap_err().path, "body");
    }

    #[test]
    fn points_to_remove_exist() {
        assert_eq!(removed_points(&[3, 1, 3], 0..5).unwrap(), HashSet::from([1, 3]));
        assert_eq!(removed_points(&[3, 5], 0..5).unwrap_err().path, "ids[1]");
    }
}
