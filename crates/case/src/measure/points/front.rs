//! Front of the mass along an axis.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error_collector::ErrorCollector;
use crate::measure::{MeasureDefinition, MeasuredState, ScalarOutput, default_fraction};
use crate::{Case, FieldRole, Side, Snapshot};

/// Front of the mass along an axis (m): the farthest end of a point domain in the connected region. Connected are columns of cells with
/// points that share a face; of several such regions the one with the most mass counts. A quantile below 1 gives the position behind which
/// that fraction of the mass lies, which stray points do not change.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Front {
    /// Direction of the front.
    pub side: Side,
    /// Mass fraction behind the front.
    #[serde(default = "default_fraction")]
    pub quantile: f64,
    /// Column width (m) for quantile 1; when absent a grid cell, or two point widths.
    #[serde(default)]
    pub cell: Option<f64>,
    /// Bodies that count; all but rigid ones when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<Vec<String>>,
}

impl Front {
    /// Foremost front towards a side, of all bodies that are not rigid.
    #[must_use]
    pub fn new(side: Side) -> Self {
        Self { side, quantile: default_fraction(), cell: None, bodies: None }
    }
}

impl MeasureDefinition for Front {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        check_front(path, self.side, self.quantile, self.cell, errors);
        errors.counted_bodies(path, self.bodies.as_deref());
    }

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        let Self { side, quantile, cell, bodies } = self;
        let front = front_of_bodies(state, *side, *quantile, *cell, bodies.as_deref());
        vec![(name.to_owned(), "m".to_owned(), front + state.case.origin()[side.axis()])]
    }

    fn is_single_number(&self) -> bool {
        true
    }
}

/// Checks the side, the quantile and the cells of a front.
pub(super) fn check_front(
    path: &str,
    side: Side,
    quantile: f64,
    cell: Option<f64>,
    errors: &mut ErrorCollector<'_>,
) {
    errors.check_side(&format!("{path}.side"), side);
    errors.quantile(path, quantile);
    if let Some(cell) = cell {
        errors.positive(format!("{path}.cell"), cell, "m");
        let problem = "a quantile below 1 does not use cells";
        errors.require(quantile == 1.0, format!("{path}.cell"), problem);
    }
}

/// Front of the counted points (m from the origin of the case).
pub(super) fn front_of_bodies(
    state: &MeasuredState<'_>,
    side: Side,
    quantile: f64,
    cell: Option<f64>,
    bodies: Option<&[String]>,
) -> f64 {
    let counted = state.counted_points(bodies);
    match quantile {
        1.0 => FrontColumns::of_case(state.case, side, cell.or(state.cell), &counted).front(&counted),
        _ => front(&counted, side, quantile),
    }
}

/// Width of a column in point widths, for methods without a grid: two points per cell and direction are usual.
const POINT_WIDTHS_PER_COLUMN: f64 = 2.0;

/// Coordinate of the front towards `side` (m), behind which the fraction `quantile` of the mass lies. It is the end of the domain of the
/// last point of that mass. NaN without points or their `mass`.
pub fn front(snapshot: &Snapshot, side: Side, quantile: f64) -> f64 {
    let (axis, sign) = (side.axis(), sign(side));
    let along: Vec<f64> = snapshot.positions.iter().map(|x| sign * x[axis]).collect();
    let last = front_point(snapshot, &along, quantile);
    last.map_or(f64::NAN, |i| sign * (along[i] + 0.5 * snapshot.extents[i][axis]))
}

/// Index of the point up to which, in ascending order of `along`, the fraction `quantile` of the mass lies; `None` without points or their
/// `mass`.
pub(super) fn front_point(snapshot: &Snapshot, along: &[f64], quantile: f64) -> Option<usize> {
    let mass = snapshot.role_values(FieldRole::Mass)?;
    let mut order: Vec<usize> = (0..along.len()).collect();
    order.sort_by(|&a, &b| along[a].total_cmp(&along[b]));
    let total: f64 = order.iter().map(|&i| mass[i]).sum();
    let mut behind = 0.0;
    let reached = order.iter().find(|&&i| {
        behind += mass[i];
        behind >= quantile * total
    });
    reached.or(order.last()).copied()
}

/// Sign of the outward direction of a side: 1 at a maximum, -1 at a minimum.
fn sign(side: Side) -> f64 {
    if side.is_max() { 1.0 } else { -1.0 }
}

/// Columns of cells on the base, by which the front of `sheet: mpm §3.9` is located. A column is occupied where it contains a point, at any
/// height. Flow that rolls over a rough base leaves few points in its lowest cells.
#[derive(Clone, Debug, PartialEq)]
pub struct FrontColumns {
    /// Side towards which the front moves.
    pub side: Side,
    /// Coordinate of the wall behind the mass (m), from which the columns are counted.
    pub wall: f64,
    /// Horizontal axis perpendicular to that of the front, along which columns are separated. `None` in the plane, and where gravity is
    /// zero or acts mainly along the axis of the front.
    pub lateral_axis: Option<usize>,
    /// Width of a column (m).
    pub cell: f64,
}

/// Index of a column: number along the axis of the front, counted from the wall, and number across.
type FrontColumn = (i64, i64);

impl FrontColumns {
    /// Columns of a case. `cell` is their width (m), which follows from the widths of the points where it is `None`.
    pub fn of_case(case: &Case, side: Side, cell: Option<f64>, snapshot: &Snapshot) -> Self {
        let axis = side.axis();
        let g = case.gravity3();
        let vertical = (0..case.dimension())
            .filter(|&c| g[c] != 0.0)
            .max_by(|&a, &b| g[a].abs().total_cmp(&g[b].abs()))
            .filter(|c| *c != axis);
        Self {
            side,
            wall: innermost_wall(case, side_of(axis, !side.is_max())),
            lateral_axis: vertical.filter(|_| case.dimension() == 3).map(|c| 3 - c - axis),
            cell: cell.unwrap_or_else(|| POINT_WIDTHS_PER_COLUMN * median_width(snapshot, axis)),
        }
    }

    /// Front (m): the farthest end of a point domain in the connected columns with the most mass. NaN without points.
    pub fn front(&self, snapshot: &Snapshot) -> f64 {
        if !(self.cell.is_finite() && self.cell > 0.0) {
            // Points without width have no columns.
            return front(snapshot, self.side, 1.0);
        }
        let columns: Vec<FrontColumn> = snapshot.positions.iter().map(|x| self.column(x)).collect();
        let mut occupied = columns.clone();
        for (x, extent) in snapshot.positions.iter().zip(&snapshot.extents) {
            self.add_covered_columns(x, extent, &mut occupied);
        }
        occupied.dedup();
        occupied.sort_unstable();
        occupied.dedup();
        let regions = connected_regions(&occupied);
        let region_of = |column: &FrontColumn| regions[occupied.partition_point(|other| other < column)];
        // Most points are in the column of the point before.
        let runs = columns.chunk_by(|one, next| one == next);
        let of_points: Vec<usize> =
            runs.flat_map(|run| std::iter::repeat_n(region_of(&run[0]), run.len())).collect();
        let largest = heaviest_region(&of_points, snapshot.role_values(FieldRole::Mass));
        let (axis, sign) = (self.side.axis(), sign(self.side));
        let end = |i: usize| sign * snapshot.positions[i][axis] + 0.5 * snapshot.extents[i][axis];
        let ends = (0..of_points.len()).filter(|&i| of_points[i] == largest).map(end);
        sign * ends.fold(f64::NAN, f64::max)
    }

    /// Adds the columns that a point wider than a column covers, such as the nodes of a flow that has spread.
    fn add_covered_columns(&self, x: &[f64; 3], extent: &[f64; 3], occupied: &mut Vec<FrontColumn>) {
        let axes = [Some(self.side.axis()), self.lateral_axis];
        if axes.into_iter().flatten().all(|axis| extent[axis] <= self.cell) {
            return;
        }
        let end = |share: f64| {
            let mut place = *x;
            axes.into_iter().flatten().for_each(|axis| place[axis] += share * extent[axis]);
            self.column(&place)
        };
        let (first, last) = (end(-0.5), end(0.5));
        for along in first.0.min(last.0)..=first.0.max(last.0) {
            occupied.extend((first.1..=last.1).map(|across| (along, across)));
        }
    }

    /// Column in which a position lies: number along the direction of the front and number across it.
    fn column(&self, x: &[f64; 3]) -> FrontColumn {
        let along = sign(self.side) * (x[self.side.axis()] - self.wall) / self.cell;
        let across = self.lateral_axis.map_or(0.0, |axis| x[axis] / self.cell);
        // Points that round-off has placed behind the wall count at the wall.
        (along.floor().max(0.0) as i64, across.floor() as i64)
    }
}

/// Number of the connected region of each of the `occupied` columns, which are in ascending order; columns of a region share faces. Regions
/// are numbered from the rear.
fn connected_regions(occupied: &[FrontColumn]) -> Vec<usize> {
    let mut regions = vec![usize::MAX; occupied.len()];
    let mut count = 0;
    for start in 0..occupied.len() {
        if regions[start] != usize::MAX {
            continue;
        }
        regions[start] = count;
        let mut open = vec![start];
        while let Some((along, across)) = open.pop().map(|i| occupied[i]) {
            let beside = [(along + 1, across), (along - 1, across), (along, across + 1), (along, across - 1)];
            for i in beside.iter().filter_map(|column| occupied.binary_search(column).ok()) {
                if regions[i] == usize::MAX {
                    regions[i] = count;
                    open.push(i);
                }
            }
        }
        count += 1;
    }
    regions
}

/// Region with the most mass of its points, or with the most points without `mass`; the rearmost of equal ones.
fn heaviest_region(of_points: &[usize], mass: Option<&[f64]>) -> usize {
    let mut masses = vec![0.0; of_points.iter().max().map_or(0, |last| last + 1)];
    for (i, region) in of_points.iter().enumerate() {
        masses[*region] += mass.map_or(1.0, |mass| mass[i]);
    }
    (0..masses.len()).rev().max_by(|&a, &b| masses[a].total_cmp(&masses[b])).unwrap_or(0)
}

/// Side of the domain that is normal to an axis.
fn side_of(axis: usize, max: bool) -> Side {
    match (axis, max) {
        (0, false) => Side::XMin,
        (0, true) => Side::XMax,
        (1, false) => Side::YMin,
        (1, true) => Side::YMax,
        (_, false) => Side::ZMin,
        (_, true) => Side::ZMax,
    }
}

/// Coordinate of the side of the domain (m), or of the innermost wall on it that exists for the whole run.
fn innermost_wall(case: &Case, side: Side) -> f64 {
    let axis = side.axis();
    let end = if side.is_max() { case.domain.max[axis] } else { case.domain.min[axis] };
    let walls = case.active_boundaries(usize::MAX);
    let faces = walls
        .iter()
        .filter(|(_, wall)| wall.side == side)
        .map(|(_, wall)| wall.wall_coordinate(&case.domain));
    if side.is_max() { faces.fold(end, f64::min) } else { faces.fold(end, f64::max) }
}

/// Median width of the points along an axis (m); NaN without points.
fn median_width(snapshot: &Snapshot, axis: usize) -> f64 {
    let mut widths: Vec<f64> = snapshot.extents.iter().map(|extent| extent[axis]).collect();
    let middle = widths.len() / 2;
    if widths.is_empty() { f64::NAN } else { *widths.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use colluvium_testkit::assert_near;

    use super::*;
    use crate::Field;
    use crate::FieldData;

    fn points(positions: Vec<[f64; 3]>, extent: f64) -> Snapshot {
        let count = positions.len();
        Snapshot {
            time: 0.0,
            step: 0,
            ids: (0..count as u64).collect(),
            bodies: vec![0; count],
            positions,
            extents: vec![[extent; 3]; count],
            fields: vec![Field {
                name: "mass".into(),
                unit: "kg",
                data: FieldData::Scalar(vec![1.0; count]),
            }],
        }
    }

    #[test]
    fn points_that_have_spread_leave_no_gap_before_the_front() {
        // Points of width 0.1 m at the back and of 0.5 m in front: columns follow from the median width.
        let places: Vec<f64> = (0..8).map(|i| 0.05 + 0.1 * f64::from(i)).chain([1.05, 1.55]).collect();
        let mut snapshot = layer(&places);
        (snapshot.extents[8][0], snapshot.extents[9][0]) = (0.5, 0.5);
        let columns = FrontColumns { side: Side::XMax, wall: 0.0, lateral_axis: None, cell: 0.2 };
        assert_near(columns.front(&snapshot), 1.8, 1e-12);
        let mirrored = FrontColumns { side: Side::XMin, wall: 2.0, ..columns };
        snapshot.positions.iter_mut().for_each(|x| x[0] = 2.0 - x[0]);
        assert_near(mirrored.front(&snapshot), 0.2, 1e-12);
    }

    /// Layer of points 0.05 m above the base, 0.1 m wide, at the given coordinates.
    fn layer(places: &[f64]) -> Snapshot {
        points(places.iter().map(|&x| [x, 0.05, 0.0]).collect(), 0.1)
    }

    fn columns(cell: f64) -> FrontColumns {
        FrontColumns { side: Side::XMax, wall: 0.0, lateral_axis: None, cell }
    }

    #[test]
    fn the_quantile_ignores_stray_points() {
        let mut places: Vec<f64> = (0..100).map(|i| 0.05 + 0.1 * f64::from(i)).collect();
        places.push(30.0);
        let snapshot = layer(&places);
        assert_near(front(&snapshot, Side::XMax, 0.98), 9.9, 1e-12);
        assert_near(front(&snapshot, Side::XMax, 1.0), 30.05, 1e-12);
        assert!(front(&layer(&[]), Side::XMax, 1.0).is_nan());
    }

    #[test]
    fn the_front_stops_at_the_first_empty_column() {
        let places = [0.05, 0.15, 0.25, 0.35, 0.75, 0.85];
        // Columns of 0.2 m: the third, from 0.4 to 0.6 m, is empty, though four widths would bridge the gap.
        assert_near(columns(0.2).front(&layer(&places)), 0.4, 1e-12);
        // Columns of 0.3 m: none is empty.
        assert_near(columns(0.3).front(&layer(&places)), 0.9, 1e-12);
        assert!(columns(0.2).front(&layer(&[])).is_nan());
    }

    #[test]
    fn a_stray_point_behind_the_mass_is_not_the_front() {
        // No wall behind the mass; one point has stayed at the rear, two have flown ahead.
        let places = [-3.05, 0.05, 0.15, 0.25, 0.35, 5.05, 5.15];
        assert_near(FrontColumns { wall: -10.0, ..columns(0.2) }.front(&layer(&places)), 0.4, 1e-12);
        // Of two equal regions the rear one counts.
        assert_near(columns(0.2).front(&layer(&[0.05, 1.05])), 0.1, 1e-12);
        // Mass counts, not the number of points.
        let mut snapshot = layer(&[0.05, 0.15, 1.05]);
        snapshot.fields[0].data = FieldData::Scalar(vec![1.0, 1.0, 9.0]);
        assert_near(columns(0.2).front(&snapshot), 1.1, 1e-12);
    }

    #[test]
    fn a_front_that_moves_down_the_axis_is_counted_from_the_upper_wall() {
        let towards = FrontColumns { side: Side::XMin, wall: 1.0, ..columns(0.2) };
        assert_near(towards.front(&layer(&[0.95, 0.75, 0.7, 0.3, 0.1])), 0.65, 1e-12);
    }

    #[test]
    fn a_column_is_occupied_at_any_height() {
        // A deposit with an empty cell at its base from 0.4 to 0.6 m, and a point thrown beyond a gap.
        let places = [[0.1, 0.05], [0.3, 0.05], [0.5, 0.35], [0.7, 0.05], [1.1, 0.05]];
        let mut positions = places.map(|[x, y]| [x, y, 0.0]).to_vec();
        assert_near(columns(0.2).front(&points(positions.clone(), 0.04)), 0.72, 1e-12);
        // The whole deposit in the air.
        positions.iter_mut().for_each(|x| x[1] += 5.0);
        assert_near(columns(0.2).front(&points(positions, 0.04)), 0.72, 1e-12);
    }

    #[test]
    fn columns_are_connected_across_the_width_in_three_dimensions() {
        // Points around an empty column, and a detached point beside them.
        let places = [[0.1, 0.1], [0.1, 0.3], [0.3, 0.3], [0.5, 0.3], [0.5, 0.1], [0.9, 0.1]];
        let positions = places.map(|[x, y]| [x, y, 0.05]).to_vec();
        let flat = FrontColumns { lateral_axis: Some(1), ..columns(0.2) };
        assert_near(flat.front(&points(positions, 0.1)), 0.55, 1e-12);
    }

    #[test]
    fn points_that_penetrate_the_wall_count_as_points_at_the_wall() {
        assert_near(columns(0.2).front(&layer(&[-0.01, 0.1, 0.3])), 0.35, 1e-12);
    }

    fn case(more: &str) -> Case {
        let text = format!(
            r#"{{
            "title": "front", "space": "plane-strain",
            "domain": {{ "min": [-1, -2], "max": [4, 2] }}, "gravity": [0, -10],
            "materials": {{ "m": {{ "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 }} }},
            "bodies": [ {{ "name": "b", "material": "m", "shape": {{ "kind": "box", "min": [0, 0], "max": [1, 1] }} }} ],
            "stages": [ {{ "name": "go", "duration": 1, "remove_boundaries": ["gate"] }} ],
            "boundaries": [
                {{ "side": "y-min", "position": 0, "wall": {{ "kind": "rough" }} }},
                {{ "side": "x-min", "position": -0.5, "wall": {{ "kind": "smooth" }} }},
                {{ "name": "gate", "side": "x-min", "position": 0, "wall": {{ "kind": "smooth" }} }}
            ]
            {more} }}"#
        );
        Case::from_json(&text).unwrap()
    }

    #[test]
    fn the_wall_position_of_the_front_is_that_of_the_case() {
        let snapshot = layer(&[0.05, 0.15]);
        let found = FrontColumns::of_case(&case(""), Side::XMax, None, &snapshot);
        assert_eq!(found, FrontColumns { wall: -0.5, ..columns(0.2) });
        let found = FrontColumns::of_case(&case(""), Side::XMin, Some(0.5), &snapshot);
        assert_eq!(found, FrontColumns { side: Side::XMin, wall: 4.0, ..columns(0.5) });
        let falling = FrontColumns::of_case(&case(""), Side::YMin, Some(0.5), &snapshot);
        assert_eq!(falling.wall, 2.0);
    }

    #[test]
    fn the_width_axis_of_the_front_is_horizontal_in_three_dimensions() {
        let text = r#"{
            "title": "front", "space": "3d", "domain": { "min": [0, 0, 0], "max": [4, 4, 4] }, "gravity": [0, 0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [ { "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0, 0], "max": [1, 1, 1] } } ],
            "stages": [ { "name": "go", "duration": 1 } ]
        }"#;
        let case = Case::from_json(text).unwrap();
        let across = |side| FrontColumns::of_case(&case, side, Some(0.5), &layer(&[])).lateral_axis;
        assert_eq!([Side::XMax, Side::YMin, Side::ZMin].map(across), [Some(1), Some(0), None]);
    }

    #[test]
    fn the_front_uses_the_cell_of_the_measure_or_that_of_the_method() {
        let more = r#", "measures": {
            "own": { "kind": "front", "side": "x-max", "cell": 0.1 },
            "method": { "kind": "front", "side": "x-max" },
            "mass": { "kind": "front", "side": "x-max", "quantile": 0.999 },
            "run": { "kind": "run-out", "side": "x-max", "origin": 0, "initial_length": 0.1, "cell": 0.1 }
        }"#;
        let readings = crate::measure::read(&MeasuredState {
            cell: Some(0.4),
            ..MeasuredState::of_points(&case(more), &layer(&[0.05, 0.35, 0.55, 0.9, 1.6]))
        });
        let found = |name: &str| readings.iter().find(|(n, ..)| n == name).map_or(f64::NAN, |r| r.2);
        assert_near(found("own"), 0.1, 1e-12);
        assert_near(found("method"), 0.95, 1e-12);
        assert_near(found("mass"), 1.65, 1e-12);
        assert_near(found("run"), 0.0, 1e-12);
    }
}
