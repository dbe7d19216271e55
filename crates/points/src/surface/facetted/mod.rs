//! Surfaces of facets: segments in 2D, triangles in 3D.

use std::collections::BTreeMap;

use thiserror::Error;

use super::vector::{cross, difference, dot, unit};
use super::{ContactQuery, NearestPoint, Surface};
use crate::surface::queries::bounding_volume_tree::BoundingVolumeTree;
use crate::surface::queries::contact_query::FacetCandidate;
use crate::surface::queries::nearest_on_facet::{FacetFeature, facet_normal, nearest_on_facet};
use crate::surface::queries::triangle_intersection;

/// Error in the data of a surface.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{path}: {problem}")]
pub struct SurfaceError {
    /// Path of the invalid value, e.g. `points[3]`.
    pub path: String,
    /// Description of the error.
    pub problem: String,
}

impl SurfaceError {
    /// Error at a key of a surface.
    pub(crate) fn new(path: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { path: path.into(), problem: problem.into() }
    }
}

/// Surface of facets with `D` corners each and the solid behind them. It is a closed polygon (2D) or triangle mesh (3D), or an open ground
/// line in 2D with the solid below.
///
/// The normal of the nearest face, edge or corner distinguishes inside from outside. Normals of edges and corners are means of the adjacent
/// faces weighted with their angles (Bærentzen and Aanæs 2005, Signed distance computation using the angle weighted pseudonormal, Theorem
/// 1).
#[derive(Clone, Debug)]
pub struct FacettedSurface<const D: usize> {
    vertices: Vec<[f64; D]>,
    facets: Vec<[u32; D]>,
    normals: Vec<[f64; D]>,
    vertex_normals: Vec<[f64; D]>,
    /// Number of the edge that follows each corner of a triangle.
    edges: Vec<[u32; 3]>,
    edge_normals: Vec<[f64; D]>,
    /// Arc length of a ground line at the start of each facet (m).
    lengths: Option<Vec<f64>>,
    tree: BoundingVolumeTree<D>,
}

/// Kind of a feature in its number: face of a facet.
const FACE: u64 = 0;
/// Kind of a feature in its number: edge of a facet.
const EDGE: u64 = 1;
/// Kind of a feature in its number: vertex of a facet.
const CORNER: u64 = 2;

impl<const D: usize> FacettedSurface<D> {
    /// Positions of the vertices (m).
    pub fn vertices(&self) -> &[[f64; D]] {
        &self.vertices
    }

    /// Vertex numbers of each facet.
    pub fn facets(&self) -> &[[u32; D]] {
        &self.facets
    }

    /// Surface from vertices and facets; an error where a facet has no area.
    fn new(vertices: Vec<[f64; D]>, facets: Vec<[u32; D]>) -> Result<Self, SurfaceError> {
        if let Some(number) = vertices.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
            return Err(SurfaceError::new(format!("points[{number}]"), "must be finite (m)"));
        }
        if facets.is_empty() {
            return Err(SurfaceError::new("facets", "there are none"));
        }
        let corners = |facet: &[u32; D]| facet.map(|v| vertices[v as usize]);
        let mut normals = Vec::with_capacity(facets.len());
        let mut vertex_sums = vec![[0.0; D]; vertices.len()];
        for (number, facet) in facets.iter().enumerate() {
            let corners = corners(facet);
            let Some(n) = facet_normal(&corners) else {
                let problem = format!("the facet from {:?} m has no extent", corners[0]);
                return Err(SurfaceError::new(format!("facets[{number}]"), problem));
            };
            for (k, vertex) in facet.iter().enumerate() {
                let weight = corner_angle(&corners, k);
                (0..D).for_each(|c| vertex_sums[*vertex as usize][c] += weight * n[c]);
            }
            normals.push(n);
        }
        let boxes: Vec<_> = facets.iter().map(|facet| bounding_box(&corners(facet))).collect();
        let tree = BoundingVolumeTree::new(&boxes);
        let vertex_normals = vertex_sums.iter().map(|sum| unit(sum).unwrap_or(*sum)).collect();
        let (edges, edge_normals) = edge_normals(&facets, &normals);
        Ok(Self { vertices, facets, normals, vertex_normals, edges, edge_normals, lengths: None, tree })
    }

    /// Positions of the vertices of a facet (m).
    fn corners(&self, facet: usize) -> [[f64; D]; D] {
        self.facets[facet].map(|v| self.vertices[v as usize])
    }

    /// Identifier and normal of a feature of a facet.
    fn feature(&self, facet: usize, feature: FacetFeature) -> (u64, &[f64; D]) {
        match feature {
            FacetFeature::Face => ((facet as u64) << 2 | FACE, &self.normals[facet]),
            FacetFeature::Edge(k) => {
                let edge = self.edges[facet][k];
                (u64::from(edge) << 2 | EDGE, &self.edge_normals[edge as usize])
            }
            FacetFeature::Corner(k) => {
                let vertex = self.facets[facet][k];
                (u64::from(vertex) << 2 | CORNER, &self.vertex_normals[vertex as usize])
            }
        }
    }

    /// Nearest facet within `reach` (m), with the nearest position on it (m) and the feature on which that lies.
    fn nearest(&self, x: &[f64; D], reach: f64) -> Option<(usize, [f64; D], FacetFeature)> {
        let mut best: Option<(usize, [f64; D], FacetFeature)> = None;
        self.tree.visit(x, reach * reach, |facet, square| {
            let (place, feature) = nearest_on_facet(&self.corners(facet), x);
            let from = difference(x, &place);
            let away = dot(&from, &from);
            // Of equally near facets the first counts, whatever the order of the tree.
            let first = best.is_none_or(|(number, ..)| facet < number);
            if away < *square || away == *square && first {
                *square = away;
                best = Some((facet, place, feature));
            }
        });
        best
    }

    /// Surface of a box with these corners (m).
    ///
    /// # Errors
    /// When a corner is not finite or the upper one is not above the lower; in one dimension.
    pub fn around_box(low: [f64; D], high: [f64; D]) -> Result<Self, SurfaceError> {
        if let Some(axis) = (0..D).find(|&c| !(low[c] < high[c])) {
            let problem = format!("{} must be above min, {}", high[axis], low[axis]);
            return Err(SurfaceError::new(format!("max[{axis}]"), problem));
        }
        let corner = |number: usize| -> [f64; D] {
            std::array::from_fn(|c| if number >> c & 1 == 0 { low[c] } else { high[c] })
        };
        // Clockwise in the plane, counter-clockwise seen from outside in space.
        let flat: &[[u32; 3]] = &[[0, 2, 0], [2, 3, 0], [3, 1, 0], [1, 0, 0]];
        let solid: &[[u32; 3]] = &[
            [0, 4, 6],
            [0, 6, 2],
            [1, 3, 7],
            [1, 7, 5],
            [0, 1, 5],
            [0, 5, 4],
            [2, 6, 7],
            [2, 7, 3],
            [0, 2, 3],
            [0, 3, 1],
            [4, 5, 7],
            [4, 7, 6],
        ];
        let facets = match D {
            2 => flat,
            3 => solid,
            _ => return Err(SurfaceError::new("kind", "one dimension has no facets")),
        };
        let facets = facets.iter().map(|facet| std::array::from_fn(|k| facet[k])).collect();
        Self::new((0..1 << D).map(corner).collect(), facets)
    }
}

impl FacettedSurface<2> {
    /// Surface of a polygon, in either sense of rotation, that does not cross itself.
    ///
    /// # Errors
    /// Fewer than three corners, an edge without length, edges that cross.
    pub fn polygon(corners: &[[f64; 2]]) -> Result<Self, SurfaceError> {
        let count = corners.len();
        if count < 3 {
            let problem = format!("{count} corners are too few, at least three are needed");
            return Err(SurfaceError::new("points", problem));
        }
        let pairs = (0..count).map(|k| (corners[k], corners[(k + 1) % count]));
        let area: f64 = pairs.map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
        let mut corners = corners.to_vec();
        if area > 0.0 {
            corners.reverse();
        }
        let facets = (0..count as u32).map(|k| [k, (k + 1) % count as u32]).collect();
        let surface = Self::new(corners, facets)?;
        surface.self_crossing().map_or(Ok(surface), Err)
    }

    /// Surface of the ground below a line from its first point to its last one (m). The line may overhang but not cross itself, and may be
    /// given from either end. There is no ground beyond its ends.
    ///
    /// # Errors
    /// Fewer than two points, two equal consecutive points, segments that cross.
    pub fn ground_line(points: &[[f64; 2]]) -> Result<Self, SurfaceError> {
        let (Some(first), Some(last)) = (points.first(), points.last()) else {
            return Err(SurfaceError::new("points", "there are none"));
        };
        if points.len() < 2 {
            return Err(SurfaceError::new("points", "one point is not a line, at least two are needed"));
        }
        if first[0] == last[0] {
            let problem = format!("begins and ends at x = {} m: there is no ground below it", first[0]);
            return Err(SurfaceError::new("points", problem));
        }
        let mut points = points.to_vec();
        // Equal consecutive points count once.
        points.dedup();
        if first[0] > last[0] {
            points.reverse();
        }
        let facets = (0..points.len() as u32 - 1).map(|k| [k, k + 1]).collect();
        let mut surface = Self::new(points, facets)?;
        if let Some(error) = surface.self_crossing() {
            return Err(error);
        }
        let mut length = 0.0;
        let mut before = Vec::with_capacity(surface.facets.len());
        for facet in 0..surface.facets.len() {
            before.push(length);
            let [a, b] = surface.corners(facet);
            length += dot(&difference(&b, &a), &difference(&b, &a)).sqrt();
        }
        surface.lengths = Some(before);
        Ok(surface)
    }

    /// Error for the first two facets without a common corner that intersect.
    fn self_crossing(&self) -> Option<SurfaceError> {
        let mut found: Option<(usize, usize)> = None;
        for (number, facet) in self.facets.iter().enumerate() {
            let edge = self.corners(number);
            let (low, high) = bounding_box(&edge);
            self.tree.visit_box(&low, &high, |other| {
                let apart = facet.iter().all(|v| !self.facets[other].contains(v));
                if other > number && apart && segments_intersect(&edge, &self.corners(other)) {
                    found = Some(found.map_or((number, other), |before| before.min((number, other))));
                }
            });
            if found.is_some() {
                break;
            }
        }
        found.map(|(a, b)| {
            let [from, to] = self.corners(a);
            let [other, end] = self.corners(b);
            let problem =
                format!("the piece from {from:?} to {to:?} m crosses the one from {other:?} to {end:?} m");
            SurfaceError::new("points", problem)
        })
    }
}

impl FacettedSurface<3> {
    /// Closed surface of triangles, each with three numbers of `vertices` (m). Degenerate triangles with a repeated vertex are left out; a
    /// mesh that is inside out is reversed.
    ///
    /// # Errors
    /// When an edge does not belong to exactly two triangles with opposite senses, with its position; when a triangle has no area, or
    /// intersects another; when a number is not one of a vertex.
    pub fn closed_surface(vertices: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Result<Self, SurfaceError> {
        let count = vertices.len();
        if let Some(number) = triangles.iter().position(|t| t.iter().any(|v| *v as usize >= count)) {
            let problem =
                format!("{:?} has a vertex that is not one of the {count} vertices", triangles[number]);
            return Err(SurfaceError::new(format!("facets[{number}]"), problem));
        }
        let whole = |t: &&[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        let mut triangles: Vec<[u32; 3]> = triangles.iter().filter(whole).copied().collect();
        check_watertight(&vertices, &triangles)?;
        let reference = vertices.first().copied().unwrap_or_default();
        let volume = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| difference(&vertices[v as usize], &reference));
            dot(&a, &cross(&b, &c))
        };
        if triangles.iter().map(volume).sum::<f64>() < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let surface = Self::new(vertices, triangles)?;
        surface.self_intersection().map_or(Ok(surface), Err)
    }

    /// Error for the first two triangles without a common corner that intersect, where inside and outside are undefined.
    fn self_intersection(&self) -> Option<SurfaceError> {
        (0..self.facets.len()).find_map(|number| {
            let (own, corners) = (&self.facets[number], self.corners(number));
            let ((low, high), mut found) = (bounding_box(&corners), None::<usize>);
            self.tree.visit_box(&low, &high, |other| {
                let apart = own.iter().all(|v| !self.facets[other].contains(v));
                if other > number
                    && apart
                    && triangle_intersection::triangles_intersect(&corners, &self.corners(other))
                {
                    found = Some(found.map_or(other, |before| before.min(other)));
                }
            });
            let other = self.corners(found?);
            let problem = format!(
                "the triangle from {:?} m passes through the one from {:?} m: unite overlapping parts into \
                 one surface",
                corners[0], other[0]
            );
            Some(SurfaceError::new("facets", problem))
        })
    }

    /// Closed surface of separate triangles (m), as in an STL file: corners with equal coordinates are one vertex.
    ///
    /// # Errors
    /// See [`FacettedSurface::closed_surface`].
    pub fn from_triangles(triangles: &[[[f64; 3]; 3]]) -> Result<Self, SurfaceError> {
        let mut vertices = Vec::new();
        let mut known: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        // Zero and minus zero are the same coordinate.
        let mut vertex = |x: [f64; 3]| {
            *known.entry(x.map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                vertices.push(x);
                vertices.len() as u32 - 1
            })
        };
        let facets: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(&mut vertex)).collect();
        Self::closed_surface(vertices, &facets)
    }
}

impl<const D: usize> Surface<D> for FacettedSurface<D> {
    fn contains(&self, x: &[f64; D]) -> bool {
        self.gap(x, f64::INFINITY).is_some_and(|gap| gap.distance <= 0.0)
    }

    fn gap(&self, x: &[f64; D], reach: f64) -> Option<NearestPoint<D>> {
        let (facet, position, feature) = self.nearest(x, reach)?;
        let (key, normal) = self.feature(facet, feature);
        let from = difference(x, &position);
        let sign = if dot(&from, normal) < 0.0 { -1.0 } else { 1.0 };
        // On a face its normal is exact; beside an edge the direction to the edge is.
        let away = if feature == FacetFeature::Face { None } else { unit(&from) };
        let normal = away.map_or(*normal, |away| away.map(|c| sign * c));
        Some(NearestPoint { distance: sign * dot(&from, &from).sqrt(), normal, position, feature_id: key })
    }

    fn query_contacts(&self, x: &[f64; D], radius: f64, found: &mut ContactQuery<D>) {
        if self.gap(x, radius).is_none_or(|gap| gap.distance < 0.0) {
            return;
        }
        let candidates = found.candidates();
        candidates.clear();
        self.tree.visit(x, radius * radius, |facet, square| {
            let corners = self.corners(facet);
            let (position, feature) = nearest_on_facet(&corners, x);
            let from = difference(x, &position);
            let away = dot(&from, &from);
            // A face that points away from the point lies behind the face in contact.
            if away > *square || dot(&from, &self.normals[facet]) < 0.0 {
                return;
            }
            let (key, normal) = self.feature(facet, feature);
            let outward = if feature == FacetFeature::Face { None } else { unit(&from) };
            let normal = outward.unwrap_or(*normal);
            let position = NearestPoint { distance: away.sqrt(), normal, position, feature_id: key };
            candidates.push(FacetCandidate { corners, nearest: position });
        });
        found.select_distinct(radius);
    }

    fn bounds(&self) -> ([f64; D], [f64; D]) {
        self.tree.bounds()
    }

    fn arc_length(&self, x: &[f64; D]) -> Option<f64> {
        let lengths = self.lengths.as_ref()?;
        let (facet, place, _) = self.nearest(x, f64::INFINITY)?;
        let along = difference(&place, &self.corners(facet)[0]);
        Some(lengths[facet] + dot(&along, &along).sqrt())
    }
}

/// Bounding box of the corners of a facet.
fn bounding_box<const D: usize>(corners: &[[f64; D]; D]) -> ([f64; D], [f64; D]) {
    let fold = |start: f64, pick: fn(f64, f64) -> f64| {
        std::array::from_fn(|c| corners.iter().map(|v| v[c]).fold(start, pick))
    };
    (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max))
}

/// Angle of a triangle at a corner (rad). One for a segment, whose two ends have equal weights.
fn corner_angle<const D: usize>(corners: &[[f64; D]; D], k: usize) -> f64 {
    if D != 3 {
        return 1.0;
    }
    let to = |other: usize| unit(&difference(&corners[other % D], &corners[k])).unwrap_or([0.0; D]);
    dot(&to(k + 1), &to(k + 2)).clamp(-1.0, 1.0).acos()
}

/// Edge numbers of each triangle, one for the edge after each corner, and the normal of each edge: the mean of its faces.
fn edge_normals<const D: usize>(facets: &[[u32; D]], normals: &[[f64; D]]) -> (Vec<[u32; 3]>, Vec<[f64; D]>) {
    if D != 3 {
        return (Vec::new(), Vec::new());
    }
    let mut known: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut sums: Vec<[f64; D]> = Vec::new();
    let mut of_facets = Vec::with_capacity(facets.len());
    for (facet, normal) in facets.iter().zip(normals) {
        of_facets.push(std::array::from_fn(|k| {
            let (a, b) = (facet[k], facet[(k + 1) % D]);
            let edge = *known.entry((a.min(b), a.max(b))).or_insert_with(|| {
                sums.push([0.0; D]);
                sums.len() as u32 - 1
            });
            (0..D).for_each(|c| sums[edge as usize][c] += normal[c]);
            edge
        }));
    }
    (of_facets, sums.iter().map(|sum| unit(sum).unwrap_or(*sum)).collect())
}

/// Checks that the triangles contain each edge once in each direction.
fn check_watertight(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<(), SurfaceError> {
    let mut runs: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for triangle in triangles {
        for k in 0..3 {
            *runs.entry((triangle[k], triangle[(k + 1) % 3])).or_default() += 1;
        }
    }
    for ((a, b), count) in &runs {
        let back = runs.get(&(*b, *a)).copied().unwrap_or_default();
        let [from, to] = [a, b].map(|v| vertices[*v as usize]);
        let problem = match (*count, back) {
            (1, 1) => continue,
            (1, 0) => "belongs to one triangle only: the surface is open there",
            (_, 0) => "has the same direction in its two triangles: they face opposite ways",
            _ => "belongs to more than two triangles",
        };
        return Err(SurfaceError::new("facets", format!("the edge from {from:?} to {to:?} m {problem}")));
    }
    Ok(())
}

/// Whether two segments have a point in common.
fn segments_intersect(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> bool {
    let side = |p: &[f64; 2], q: &[f64; 2], x: &[f64; 2]| {
        (q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0])
    };
    let apart = |s: f64, t: f64| s * t > 0.0;
    if apart(side(&a[0], &a[1], &b[0]), side(&a[0], &a[1], &b[1])) {
        return false;
    }
    if apart(side(&b[0], &b[1], &a[0]), side(&b[0], &b[1], &a[1])) {
        return false;
    }
    // Collinear segments intersect where their boxes do.
    let ((al, ah), (bl, bh)) = (bounding_box(a), bounding_box(b));
    (0..2).all(|c| al[c] <= bh[c] && bl[c] <= ah[c])
}

#[cfg(test)]
mod tests;
