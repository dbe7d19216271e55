//! Polygons in a plane.

use std::ops::{Deref, Range};
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use crate::search::box_overlaps::overlapping_boxes;

/// Corners of a polygon (m), with its edges sorted into bands where there are many, for fast searches at a given height.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PolygonVertices {
    vertices: Vec<[f64; 2]>,
    #[serde(skip)]
    bands: OnceLock<EdgeBands>,
}

impl PolygonVertices {
    /// Number of edges up to which testing all of them is as fast.
    const MAX_DIRECT_EDGES: usize = 32;

    /// Mutable corners (m).
    pub fn vertices_mut(&mut self) -> &mut [[f64; 2]] {
        self.bands.take();
        &mut self.vertices
    }

    /// Edge from corner `i` to the next.
    fn edge(&self, i: usize) -> LineSegment {
        (self.vertices[i], self.vertices[if i + 1 < self.vertices.len() { i + 1 } else { 0 }])
    }

    /// Edges that may reach heights from `low` to `high`. Some edges may occur twice, and some may not reach these heights.
    fn edges(&self, low: f64, high: f64) -> impl Iterator<Item = LineSegment> {
        let bands = (self.vertices.len() > Self::MAX_DIRECT_EDGES)
            .then(|| self.bands.get_or_init(|| EdgeBands::new(self)));
        let listed = bands.map_or(&[][..], |bands| bands.edges_between(low, high));
        let all = if bands.is_some() { 0..0 } else { 0..self.vertices.len() };
        all.chain(listed.iter().map(|i| *i as usize)).map(|i| self.edge(i))
    }

    /// Whether `meets` is true for an edge among those that may intersect the box from `low` to `high`.
    pub fn any_edge_in_box(
        &self,
        low: &[f64],
        high: &[f64],
        meets: impl Fn(&[f64; 2], &[f64; 2]) -> bool,
    ) -> bool {
        self.edges(low[1], high[1]).any(|(a, b)| meets(&a, &b))
    }

    /// Whether the polygon contains a point, by the crossing-number test; points on an edge count as inside.
    pub fn contains(&self, point: &[f64]) -> bool {
        let (x, y) = (point[0], point[1]);
        let mut inside = false;
        for (a, b) in self.edges(y, y) {
            let cross = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
            let between = |u: f64, v: f64, w: f64| u.min(v) <= w && w <= u.max(v);
            if cross == 0.0 && between(a[0], b[0], x) && between(a[1], b[1], y) {
                return true;
            }
            if (a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0] {
                inside = !inside;
            }
        }
        inside
    }

    /// Indices of the first two edges without a common corner that cross.
    pub fn crossing_edges(&self) -> Option<(usize, usize)> {
        let count = self.vertices.len();
        let around = |i: usize| {
            let (a, b) = self.edge(i);
            ([a[0].min(b[0]), a[1].min(b[1])], [a[0].max(b[0]), a[1].max(b[1])])
        };
        let boxes: Vec<_> = (0..count).map(around).collect();
        let apart = |&(i, j): &(usize, usize)| j != i + 1 && (i != 0 || j != count - 1);
        let pairs = overlapping_boxes(&boxes).into_iter().filter(apart);
        pairs.filter(|(i, j)| segments_cross_properly(self.edge(*i), self.edge(*j))).min()
    }
}

impl From<Vec<[f64; 2]>> for PolygonVertices {
    fn from(all: Vec<[f64; 2]>) -> Self {
        Self { vertices: all, bands: OnceLock::new() }
    }
}

impl Deref for PolygonVertices {
    type Target = [[f64; 2]];

    fn deref(&self) -> &Self::Target {
        &self.vertices
    }
}

impl PartialEq for PolygonVertices {
    fn eq(&self, other: &Self) -> bool {
        self.vertices == other.vertices
    }
}

/// Edges of a polygon sorted into bands of equal height by the second coordinate.
#[derive(Clone, Debug)]
struct EdgeBands {
    bottom: f64,
    /// Bands per length (1/m).
    per_length: f64,
    /// The edges of band `k` are those of `starts[k]` to `starts[k + 1]`.
    band_offsets: Vec<u32>,
    edges: Vec<u32>,
}

impl EdgeBands {
    /// Sorts the edges into bands of the second coordinate, with at most three entries for each edge on average.
    fn new(corners: &PolygonVertices) -> Self {
        let count = corners.len();
        let rises = |i: usize| {
            let (a, b) = corners.edge(i);
            (a[1].min(b[1]), a[1].max(b[1]))
        };
        let (bottom, top) =
            (0..count).map(rises).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), edge| {
                (low.min(edge.0), high.max(edge.1))
            });
        let climbed: f64 = (0..count).map(|i| rises(i).1 - rises(i).0).sum();
        let number = (2.0 * count as f64 * (top - bottom) / climbed).clamp(1.0, count as f64).floor();
        let per_length = if top > bottom { number / (top - bottom) } else { 0.0 };
        let mut bands =
            Self { bottom, per_length, band_offsets: vec![0; number as usize + 1], edges: Vec::new() };
        let reach: Vec<Range<usize>> = (0..count).map(|i| bands.range(rises(i).0, rises(i).1)).collect();
        for range in &reach {
            range.clone().for_each(|band| bands.band_offsets[band + 1] += 1);
        }
        for band in 0..number as usize {
            bands.band_offsets[band + 1] += bands.band_offsets[band];
        }
        let mut next = bands.band_offsets.clone();
        bands.edges = vec![0; bands.band_offsets[number as usize] as usize];
        for (i, range) in reach.into_iter().enumerate() {
            for band in range {
                bands.edges[next[band] as usize] = i as u32;
                next[band] += 1;
            }
        }
        bands
    }

    /// Indices of the bands that overlap the range from `low` to `high` (m).
    fn range(&self, low: f64, high: f64) -> Range<usize> {
        let last = self.band_offsets.len() - 2;
        let band = |y: f64| (((y - self.bottom) * self.per_length) as usize).min(last);
        band(low)..band(high) + 1
    }

    /// Indices of edges that may meet a range of the coordinate across the bands.
    fn edges_between(&self, low: f64, high: f64) -> &[u32] {
        let range = self.range(low, high);
        &self.edges[self.band_offsets[range.start] as usize..self.band_offsets[range.end] as usize]
    }
}

/// Signed area (m²), positive where the corners run counter-clockwise.
pub fn signed_area(vertices: &[[f64; 2]]) -> f64 {
    let next = vertices.iter().cycle().skip(1);
    0.5 * vertices.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>()
}

/// First moment of the area about the line where the first coordinate is zero (m³), positive for counter-clockwise vertices at positive
/// coordinates.
pub fn first_moment(vertices: &[[f64; 2]]) -> f64 {
    let next = vertices.iter().cycle().skip(1);
    vertices.iter().zip(next).map(|(a, b)| (a[0] + b[0]) * (a[0] * b[1] - b[0] * a[1])).sum::<f64>() / 6.0
}

/// Coordinates along `axis` at which the line through `point` parallel to that axis may cross an edge.
pub fn polygon_crossings(vertices: &[[f64; 2]], point: &[f64], axis: usize) -> Vec<f64> {
    let (across, at) = (1 - axis, point[1 - axis]);
    let mut all = Vec::new();
    for (a, b) in vertices.iter().zip(vertices.iter().cycle().skip(1)) {
        if a[across].min(b[across]) > at || a[across].max(b[across]) < at {
            continue;
        }
        if a[across] == b[across] {
            all.extend([a[axis], b[axis]]);
        } else {
            let share = (at - a[across]) / (b[across] - a[across]);
            all.push(a[axis] + share * (b[axis] - a[axis]));
        }
    }
    all
}

/// Line segment: its two ends (m).
pub type LineSegment = ([f64; 2], [f64; 2]);

/// Share of the extent of a ring that counts as round-off.
const ROUND_OFF: f64 = 1e-9;

/// Pairs of edges of a ring whose bounding boxes overlap or touch, as indices of their first corners, with the extent of the ring (m).
fn candidate_edge_pairs(ring: &[[f64; 2]]) -> (Vec<(usize, usize)>, f64) {
    let end = |c: usize, start: f64, pick: fn(f64, f64) -> f64| ring.iter().map(|x| x[c]).fold(start, pick);
    let side = |c: usize| end(c, f64::NEG_INFINITY, f64::max) - end(c, f64::INFINITY, f64::min);
    let extent = side(0).max(side(1));
    let margin = ROUND_OFF * extent;
    let around = |(a, b): LineSegment| {
        let low: [f64; 2] = std::array::from_fn(|c| a[c].min(b[c]) - margin);
        (low, std::array::from_fn::<f64, 2, _>(|c| a[c].max(b[c]) + margin))
    };
    let boxes: Vec<_> = (0..ring.len()).map(|i| around(ring_edge(ring, i))).collect();
    (overlapping_boxes(&boxes), extent)
}

/// Edge of a ring from vertex `i` to the next one.
fn ring_edge(ring: &[[f64; 2]], i: usize) -> LineSegment {
    (ring[i], ring[(i + 1) % ring.len()])
}

/// Whether edges of a ring touch other than at common corners: a corner lies on another edge, or edges overlap.
pub fn has_self_contact(ring: &[[f64; 2]]) -> bool {
    let cross = |e: LineSegment, p: [f64; 2]| {
        (e.1[0] - e.0[0]) * (p[1] - e.0[1]) - (e.1[1] - e.0[1]) * (p[0] - e.0[0])
    };
    let lies_on = |e: LineSegment, p: [f64; 2]| {
        let between = |c: usize| e.0[c].min(e.1[c]) <= p[c] && p[c] <= e.0[c].max(e.1[c]);
        cross(e, p) == 0.0 && between(0) && between(1)
    };
    let count = ring.len();
    let touch = |&(i, j): &(usize, usize)| {
        let (a, b) = (ring_edge(ring, i), ring_edge(ring, j));
        if j == i + 1 {
            return lies_on(a, b.1) || lies_on(b, a.0);
        }
        if i == 0 && j == count - 1 {
            return lies_on(a, b.0) || lies_on(b, a.1);
        }
        [a.0, a.1].iter().any(|p| lies_on(b, *p)) || [b.0, b.1].iter().any(|p| lies_on(a, *p))
    };
    candidate_edge_pairs(ring).0.iter().any(touch)
}

/// First two edges of a ring that cross in their interiors, by more than round-off.
pub fn proper_crossing(ring: &[[f64; 2]]) -> Option<(LineSegment, LineSegment)> {
    let (pairs, extent) = candidate_edge_pairs(ring);
    let is_clear = |e: LineSegment, other: LineSegment| {
        let length = (e.1[0] - e.0[0]).hypot(e.1[1] - e.0[1]);
        let beside = |p: [f64; 2]| {
            (e.1[0] - e.0[0]) / length * (p[1] - e.0[1]) - (e.1[1] - e.0[1]) / length * (p[0] - e.0[0])
        };
        let (from, to) = (beside(other.0), beside(other.1));
        (from < 0.0) != (to < 0.0) && from.abs().min(to.abs()) > ROUND_OFF * extent
    };
    let edges = |(i, j): (usize, usize)| (ring_edge(ring, i), ring_edge(ring, j));
    let crosses = |&(i, j): &(usize, usize)| {
        let (a, b) = edges((i, j));
        is_clear(a, b) && is_clear(b, a)
    };
    pairs.into_iter().filter(crosses).min().map(edges)
}

/// Whether two segments cross in their interiors.
fn segments_cross_properly(a: LineSegment, b: LineSegment) -> bool {
    let side = |e: LineSegment, p: [f64; 2]| {
        (e.1[0] - e.0[0]) * (p[1] - e.0[1]) - (e.1[1] - e.0[1]) * (p[0] - e.0[0])
    };
    side(a, b.0) * side(a, b.1) < 0.0 && side(b, a.0) * side(b, a.1) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_polygon_of_many_corners_contains_the_points_of_its_triangles(
            radii in prop::collection::vec(0.2..1.0f64, 3..200),
            places in prop::collection::vec(prop::array::uniform2(-1.1..1.1f64), 50),
        ) {
            let count = radii.len();
            let corner = |k: usize| {
                let angle = std::f64::consts::TAU * k as f64 / count as f64;
                [radii[k] * angle.cos(), radii[k] * angle.sin()]
            };
            let corners = PolygonVertices::from((0..count).map(corner).collect::<Vec<_>>());
            prop_assert_eq!(corners.crossing_edges(), None);
            for [x, y] in places {
                let sector = (y.atan2(x).rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU * count as f64) as usize;
                let (a, b) = corners.edge(sector.min(count - 1));
                let inward = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
                prop_assert!(inward.abs() < 1e-9 || corners.contains(&[x, y]) == (inward > 0.0));
            }
        }
    }

    #[test]
    fn the_first_edges_that_cross_are_found_among_many() {
        let round = |k: u32| [f64::from(k).to_radians().cos(), f64::from(k).to_radians().sin()];
        let mut all: Vec<[f64; 2]> = (0..360).map(round).collect();
        all.swap(100, 102);
        let crossed = PolygonVertices::from(all.clone()).crossing_edges().unwrap();
        let pairs = (0..360).flat_map(|i| (i + 2..360).map(move |j| (i, j))).filter(|pair| *pair != (0, 359));
        let corners = PolygonVertices::from(all);
        let expected =
            pairs.into_iter().find(|(i, j)| segments_cross_properly(corners.edge(*i), corners.edge(*j)));
        assert_eq!(Some(crossed), expected);
    }
}
