//! Raster of heights as a triangulated surface.

use super::vector::{difference, dot, unit};
use super::{ContactQuery, NearestPoint, Surface};
use crate::surface::queries::contact_query::FacetCandidate;
use crate::surface::queries::nearest_on_facet::{FacetFeature, facet_normal, nearest_on_facet};
use crate::{Raster, RasterError};

/// Ground surface of a raster of heights, with z along the third axis. Each cell between four nodes has two triangles; the diagonal begins
/// at the node with the smallest x and y. There is no ground beyond the raster and in cells with a node without data.
///
/// Contact uses these triangles. Depth-integrated flow uses the bilinear interpolation of the same raster, with gradient and curvature
/// recovered at the nodes: [`Terrain`](crate::Terrain). Both agree at the nodes; between them they differ by at most a quarter of the
/// cell's twist.
#[derive(Clone, Debug)]
pub struct HeightField {
    raster: Raster,
    lowest: f64,
    max_height: f64,
    /// Upper bound of the vertical distance of a position from the ground over its normal distance; infinite where the ground has holes.
    max_gap_ratio: f64,
}

/// Nearest position on a triangle of the height field.
struct NearestTriangle {
    triangle: u64,
    corners: [[f64; 3]; 3],
    position: [f64; 3],
    feature: FacetFeature,
}

/// Relative error of distances that counts as round-off.
const ROUND_OFF: f64 = 1e-9;

/// Kind of a feature in its number: face of a triangle.
const FACE: u64 = 0;
/// Kind of a feature in its number: edge of a triangle.
const EDGE: u64 = 1;
/// Kind of a feature in its number: node of the raster.
const CORNER: u64 = 2;

impl HeightField {
    /// Ground under these heights (m).
    ///
    /// # Errors
    /// See [`Raster::validate`].
    pub fn new(raster: Raster) -> Result<Self, RasterError> {
        raster.validate()?;
        let known = || raster.values.iter().copied().filter(|v| v.is_finite());
        let (lowest, max_height) =
            (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
        let mut field = Self { raster, lowest, max_height, max_gap_ratio: 1.0 };
        field.max_gap_ratio = field.steepest_normal_length();
        Ok(field)
    }

    /// Length of the steepest normal whose vertical component is one. Infinite for a raster with holes, across which heights may jump.
    fn steepest_normal_length(&self) -> f64 {
        let (mut square, [dx, dy]) = (0.0, self.raster.spacing);
        for j in 0..self.raster.rows - 1 {
            for i in 0..self.raster.columns - 1 {
                if !self.is_cell_complete(i, j) {
                    return f64::INFINITY;
                }
                let [a, b] = [0, 1].map(|k| self.raster.value(i + k, j));
                let [d, c] = [0, 1].map(|k| self.raster.value(i + k, j + 1));
                for (along_x, along_y) in [((b - a) / dx, (c - b) / dy), ((c - d) / dx, (d - a) / dy)] {
                    square = f64::max(square, along_x * along_x + along_y * along_y);
                }
            }
        }
        (1.0 + square).sqrt()
    }

    /// Raster of heights.
    pub fn raster(&self) -> &Raster {
        &self.raster
    }

    /// Height of the triangles at a position in plan (m); `None` beyond the raster or without data.
    pub fn height(&self, x: f64, y: f64) -> Option<f64> {
        let ([i, j], [s, t]) = self.raster.locate_cell(x, y)?;
        let [a, c] = [self.raster.value(i, j), self.raster.value(i + 1, j + 1)];
        let z = if s >= t {
            let b = self.raster.value(i + 1, j);
            a + s * (b - a) + t * (c - b)
        } else {
            let d = self.raster.value(i, j + 1);
            a + t * (d - a) + s * (c - d)
        };
        // As for contact, a cell with a node without data has no ground.
        self.is_cell_complete(i, j).then_some(z)
    }

    /// Whether the four nodes of a cell have heights.
    fn is_cell_complete(&self, i: usize, j: usize) -> bool {
        [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)]
            .iter()
            .all(|(i, j)| self.raster.value(*i, *j).is_finite())
    }

    /// Position of a node of the raster (m).
    fn node_position(&self, i: usize, j: usize) -> [f64; 3] {
        let [x, y] = self.raster.node_position(i, j);
        [x, y, self.raster.value(i, j)]
    }

    /// Range of columns or rows of cells that overlap a window around a coordinate.
    fn cell_range(&self, axis: usize, x: f64, reach: f64) -> std::ops::Range<usize> {
        let cells = [self.raster.columns, self.raster.rows][axis] - 1;
        let step = |at: f64| (at - self.raster.origin[axis]) / self.raster.spacing[axis];
        let (from, to) = (step(x - reach).floor().max(0.0), step(x + reach).floor().min(cells as f64 - 1.0));
        if to >= from { from as usize..to as usize + 1 } else { 0..0 }
    }

    /// Calls `visit` with the two triangles of each cell that overlaps a window of this half width around `x`.
    fn visit_triangles(&self, x: &[f64; 3], reach: f64, mut visit: impl FnMut(u64, &[[f64; 3]; 3])) {
        for j in self.cell_range(1, x[1], reach) {
            for i in self.cell_range(0, x[0], reach) {
                if !self.is_cell_complete(i, j) {
                    continue;
                }
                let (a, c) = (self.node_position(i, j), self.node_position(i + 1, j + 1));
                let cell = (j * self.raster.columns + i) as u64;
                visit(2 * cell, &[a, self.node_position(i + 1, j), c]);
                visit(2 * cell + 1, &[a, c, self.node_position(i, j + 1)]);
            }
        }
    }

    /// Identifier of a feature of a triangle. An edge is identified by its first node and its direction: along x, along y, diagonal.
    fn feature_id(&self, triangle: u64, feature: FacetFeature) -> u64 {
        let (node, columns) = (triangle / 2, self.raster.columns as u64);
        let upper = triangle % 2 == 1;
        let (number, kind) = match feature {
            FacetFeature::Face => (triangle, FACE),
            FacetFeature::Corner(k) => {
                let corners = if upper { [0, columns + 1, columns] } else { [0, 1, columns + 1] };
                (node + corners[k], CORNER)
            }
            FacetFeature::Edge(k) => {
                let lower = [(0, 0), (1, 1), (0, 2)];
                let higher = [(0, 2), (columns, 0), (0, 1)];
                let (offset, direction) = if upper { higher[k] } else { lower[k] };
                (3 * (node + offset) + direction, EDGE)
            }
        };
        number << 2 | kind
    }
}

impl Surface<3> for HeightField {
    fn contains(&self, x: &[f64; 3]) -> bool {
        self.height(x[0], x[1]).is_some_and(|z| x[2] <= z)
    }

    fn gap(&self, x: &[f64; 3], reach: f64) -> Option<NearestPoint<3>> {
        if x[2] - self.max_height > reach || self.lowest - x[2] > reach {
            return None;
        }
        // The nearest point is no farther than the ground vertically above or below.
        let vertical = self.height(x[0], x[1]).map(|z| (x[2] - z).abs());
        let window = reach.min(vertical.unwrap_or(reach));
        // The steepest slope bounds the distance from below.
        if vertical.is_some_and(|vertical| vertical > (1.0 + ROUND_OFF) * self.max_gap_ratio * reach) {
            return None;
        }
        let mut square = reach * reach;
        // Of equally near positions that of the triangle with the smallest number counts, which comes first.
        let mut best: Option<NearestTriangle> = None;
        self.visit_triangles(x, window, |triangle, corners| {
            let (place, feature) = nearest_on_facet(corners, x);
            let from = difference(x, &place);
            let away = dot(&from, &from);
            if away < square || best.is_none() && away == square {
                square = away;
                best = Some(NearestTriangle { triangle, corners: *corners, position: place, feature });
            }
        });
        let NearestTriangle { triangle, corners, position, feature } = best?;
        let from = difference(x, &position);
        let sign = if self.contains(x) { -1.0 } else { 1.0 };
        let away = if feature == FacetFeature::Face { None } else { unit(&from) };
        let own = || facet_normal(&corners).unwrap_or([0.0, 0.0, 1.0]);
        let normal = away.map_or_else(own, |away| away.map(|c| sign * c));
        let distance = sign * dot(&from, &from).sqrt();
        Some(NearestPoint { distance, normal, position, feature_id: self.feature_id(triangle, feature) })
    }

    fn query_contacts(&self, x: &[f64; 3], radius: f64, found: &mut ContactQuery<3>) {
        if x[2] - self.max_height > radius || self.contains(x) {
            return;
        }
        let candidates = found.candidates();
        candidates.clear();
        self.visit_triangles(x, radius, |triangle, corners| {
            let (position, feature) = nearest_on_facet(corners, x);
            let from = difference(x, &position);
            let away = dot(&from, &from);
            let own = facet_normal(corners).unwrap_or([0.0, 0.0, 1.0]);
            if away > radius * radius || dot(&from, &own) < 0.0 {
                return;
            }
            let outward = if feature == FacetFeature::Face { None } else { unit(&from) };
            let key = self.feature_id(triangle, feature);
            let position = NearestPoint {
                distance: away.sqrt(),
                normal: outward.unwrap_or(own),
                position,
                feature_id: key,
            };
            candidates.push(FacetCandidate { corners: *corners, nearest: position });
        });
        found.select_distinct(radius);
    }

    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let ([x, y], [far_x, far_y]) = (self.raster.origin, self.raster.last_node_position());
        ([x, y, f64::NEG_INFINITY], [far_x, far_y, self.max_height])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::surface::{HalfSpace, PlacedSurface};

    fn waves() -> HeightField {
        let height = |x: f64, y: f64| (1.3 * x).sin() * (0.9 * y).cos() + 0.2 * x;
        HeightField::new(Raster::from_function([21, 17], [-5.0, -4.0], [0.5, 0.5], height)).unwrap()
    }

    proptest! {
        #[test]
        fn over_a_plane_the_gap_is_that_of_the_half_space(
            x in -3.0..3.0f64, y in -3.0..3.0f64, z in -1.0..1.0f64, a in -0.8..0.8f64, b in -0.8..0.8f64,
        ) {
            let raster = Raster::from_function([41, 41], [-10.0, -10.0], [0.5, 0.5], |x, y| a * x + b * y);
            let field = HeightField::new(raster).unwrap();
            let plane = HalfSpace::new([0.0; 3], [-a, -b, 1.0]).unwrap();
            let at = [x, y, a * x + b * y + z];
            let (got, exact) = (field.gap(&at, 2.0).unwrap(), plane.gap(&at, 2.0).unwrap());
            prop_assert!((got.distance - exact.distance).abs() < 1e-12, "{got:?} {exact:?}");
            prop_assert!((0..3).all(|c| (got.position[c] - exact.position[c]).abs() < 1e-12));
            // At a seam of two triangles, apart from round-off, the normal is only as accurate as the distance.
            prop_assert!(z.abs() < 1e-3 || (0..3).all(|c| (got.normal[c] - exact.normal[c]).abs() < 1e-9));
            let mut found = ContactQuery::default();
            field.query_contacts(&at, 2.0, &mut found);
            prop_assert_eq!(found.len(), usize::from(z > 0.0));
        }

        #[test]
        fn no_triangle_is_nearer_than_the_gap(
            x in -4.0..4.0f64, y in -3.0..3.0f64, z in -2.0..2.0f64,
        ) {
            let field = waves();
            let at = [x, y, z];
            let mut smallest = f64::INFINITY;
            field.visit_triangles(&at, 10.0, |_, corners| {
                let from = difference(&at, &nearest_on_facet(corners, &at).0);
                smallest = smallest.min(dot(&from, &from).sqrt());
            });
            let gap = field.gap(&at, 3.0).unwrap();
            prop_assert!((gap.distance.abs() - smallest).abs() < 1e-12);
            prop_assert_eq!(gap.distance < 0.0, field.contains(&at));
            prop_assert!(field.gap(&at, 0.99 * smallest).is_none());
            let short = field.gap(&at, 1.01 * smallest).unwrap();
            prop_assert!(short == gap, "{short:?} {gap:?}");
        }
    }

    #[test]
    fn a_contact_keeps_its_key_on_its_triangle_and_along_an_edge() {
        let field = waves();
        let key = |x: f64, y: f64| field.gap(&[x, y, field.height(x, y).unwrap()], 0.1).unwrap().feature_id;
        assert_eq!(key(0.3, 0.1), key(0.4, 0.05));
        assert_ne!(key(0.3, 0.1), key(0.1, 0.3), "the other triangle of the cell");
        // The edge between two cells has the same identifier from either triangle.
        let cell = |i: u64, j: u64| j * 21 + i;
        assert_eq!(
            field.feature_id(2 * cell(3, 4), FacetFeature::Edge(1)),
            field.feature_id(2 * cell(4, 4) + 1, FacetFeature::Edge(2))
        );
        assert_eq!(
            field.feature_id(2 * cell(3, 5), FacetFeature::Edge(0)),
            field.feature_id(2 * cell(3, 4) + 1, FacetFeature::Edge(1))
        );
        assert_eq!(
            field.feature_id(2 * cell(3, 4), FacetFeature::Edge(2)),
            field.feature_id(2 * cell(3, 4) + 1, FacetFeature::Edge(0))
        );
        assert_eq!(
            field.feature_id(2 * cell(3, 4), FacetFeature::Corner(2)),
            field.feature_id(2 * cell(4, 5), FacetFeature::Corner(0))
        );
    }

    #[test]
    fn without_data_there_is_no_ground() {
        let mut raster = Raster::from_function([5, 5], [0.0; 2], [1.0; 2], |_, _| 0.0);
        raster.values[12] = f64::NAN;
        let field = HeightField::new(raster).unwrap();
        assert_eq!(field.height(2.5, 2.5), None);
        assert!(field.gap(&[2.5, 2.5, 0.1], 0.2).is_none());
        assert!(field.gap(&[0.5, 0.5, 0.1], 0.2).is_some());
        assert!(!field.contains(&[2.5, 2.5, -1.0]) && !field.contains(&[7.0, 7.0, -1.0]));
    }

    #[test]
    fn a_rotated_and_translated_surface_has_the_transformed_gap() {
        let surface = std::sync::Arc::new(waves());
        let frame = crate::surface::RigidTransform::rotation_about([1.0, 2.0, 0.0], [0.3, -0.2, 1.0], 0.7)
            .shifted(&[10.0, 0.0, 5.0]);
        let placed = PlacedSurface { surface: surface.clone(), transform: frame };
        let local = [0.3, -0.4, 0.8];
        let (own, out) =
            (surface.gap(&local, 5.0).unwrap(), placed.gap(&frame.to_space(&local), 5.0).unwrap());
        assert!((own.distance - out.distance).abs() < 1e-12 && own.feature_id == out.feature_id);
        let back = frame.to_body(&out.position);
        assert!((0..3).all(|c| (back[c] - own.position[c]).abs() < 1e-12));
        let centre =
            crate::surface::RigidTransform::rotation_about([1.0, 2.0], [0.0; 3], 1.0).to_space(&[1.0, 2.0]);
        assert!((centre[0] - 1.0).abs() < 1e-15 && (centre[1] - 2.0).abs() < 1e-15, "{centre:?}");
    }
}
