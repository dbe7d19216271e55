//! Rows of points along the edges of a shape.

use std::collections::HashMap;
use std::f64::consts::TAU;

use crate::sampling::fitted::PlanarRegion;
use crate::shape::{BoundaryEdge, PlanePoint};

/// Smallest distance between points of different rows (spacings).
const ROW_CLEARANCE: f64 = 0.74;

/// Smallest distance between points of the same row (spacings).
const CLEARANCE_IN_ROW: f64 = 0.6;

/// Largest cosine of the angle between two edges at a convex corner at which the rows of neither edge end at the other.
const MAX_CORNER_COSINE: f64 = 0.2;

/// Relative tolerance of the distance to the nearest edge.
const NEAREST_TOLERANCE: f64 = 1e-6;

/// Points of which no two are closer than a smallest distance, in search bins one spacing wide.
pub(super) struct SpacedPoints {
    points: Vec<PlanePoint>,
    bins: HashMap<[i64; 2], Vec<u32>>,
    edge: f64,
}

impl SpacedPoints {
    /// Empty list of points with bins of the width `edge` (m).
    fn new(edge: f64) -> Self {
        Self { points: Vec::new(), bins: HashMap::new(), edge }
    }

    /// Points in the order of their addition.
    pub(super) fn into_points(self) -> Vec<PlanePoint> {
        self.points
    }

    /// Bin of a position.
    fn bin(&self, x: PlanePoint) -> [i64; 2] {
        x.map(|c| (c / self.edge).floor() as i64)
    }

    /// Whether no point is nearer to `x` than `apart` (m), which is at most the width of a bin.
    pub(super) fn is_free(&self, x: PlanePoint, apart: f64) -> bool {
        self.is_free_except_since(x, apart, usize::MAX, 0.0)
    }

    /// Whether `x` is free: no point with an index below `since` is nearer than `apart` (m), and no later one nearer than `others` (m).
    fn is_free_except_since(&self, x: PlanePoint, apart: f64, since: usize, others: f64) -> bool {
        let [column, row] = self.bin(x);
        let bins = (0..9).filter_map(|k| self.bins.get(&[column + k / 3 - 1, row + k % 3 - 1]));
        bins.flatten().all(|&j| {
            let (other, j) = (self.points[j as usize], j as usize);
            (x[0] - other[0]).hypot(x[1] - other[1]) >= if j < since { apart } else { others }
        })
    }

    /// Adds a point to the list and to its bin.
    pub(super) fn add(&mut self, x: PlanePoint) {
        let bin = self.bin(x);
        self.bins.entry(bin).or_default().push(self.points.len() as u32);
        self.points.push(x);
    }
}

/// Distance between the rows along an edge (m), fitted to the distance of an opposite edge that is parallel to it.
fn row_spacing(side: &BoundaryEdge, sides: &[BoundaryEdge], spacing: f64) -> f64 {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-6 * spacing;
    let thickness = |other: &BoundaryEdge| -> Option<f64> {
        match (*side, *other) {
            (
                BoundaryEdge::Arc { centre, radius, sweep, .. },
                BoundaryEdge::Arc { centre: o, radius: other, sweep: turn, .. },
            ) => {
                let inwards = if sweep > 0.0 { radius - other } else { other - radius };
                let same = near(centre[0], o[0]) && near(centre[1], o[1]);
                (same && sweep * turn < 0.0 && inwards > 0.0).then_some(inwards)
            }
            (BoundaryEdge::Line { .. }, BoundaryEdge::Line { from, to }) => {
                let ([x, y], [nx, ny]) = (side.point_at(0.5), side.left_normal(0.5));
                let depth = |place: PlanePoint| (place[0] - x) * nx + (place[1] - y) * ny;
                let level = near(depth(from), depth(to)) && depth(from) > 1e-6 * spacing;
                // The edges are opposite each other, and their normals face.
                let ahead = [x + nx * depth(from), y + ny * depth(from)];
                (level && near(other.distance(ahead), 0.0)).then(|| depth(from))
            }
            _ => None,
        }
    };
    let mut smallest = sides.iter().filter_map(thickness).fold(f64::INFINITY, f64::min);
    if smallest.is_infinite() {
        // A disk is filled up to its centre.
        match *side {
            BoundaryEdge::Arc { radius, sweep, .. } if sweep > 0.0 => smallest = radius,
            _ => return spacing,
        }
    }
    smallest / (smallest / spacing).round().max(1.0)
}

/// Points of a row along an edge at a `depth` below it (m), about a `spacing` (m) apart.
fn row_points(side: &BoundaryEdge, depth: f64, spacing: f64) -> Vec<PlanePoint> {
    let fitting = |length: f64| (length / spacing).round().max(1.0);
    let shares = |count: f64| (0..count as usize).map(move |k| (k as f64 + 0.5) / count);
    match *side {
        BoundaryEdge::Line { .. } => {
            let below = |t: f64| {
                let (x, n) = (side.point_at(t), side.left_normal(t));
                [x[0] + depth * n[0], x[1] + depth * n[1]]
            };
            shares(fitting(side.length())).map(below).collect()
        }
        BoundaryEdge::Arc { centre, radius, start, sweep } => {
            let radius = radius - depth * sweep.signum();
            if radius <= 0.0 {
                return Vec::new();
            }
            let circle = BoundaryEdge::Arc { centre, radius, start, sweep };
            shares(fitting(radius * sweep.abs().min(TAU))).map(|t| circle.point_at(t)).collect()
        }
    }
}

/// Whether two edges meet at a convex corner that is nearly a right angle.
fn is_perpendicular_corner(a: &BoundaryEdge, b: &BoundaryEdge, same: f64) -> bool {
    [(a, b), (b, a)].into_iter().any(|(a, b)| {
        let (x, y, n, m) = (a.point_at(1.0), b.point_at(0.0), a.left_normal(1.0), b.left_normal(0.0));
        let touch = (x[0] - y[0]).hypot(x[1] - y[1]) < same;
        touch && (n[0] * m[0] + n[1] * m[1]).abs() < MAX_CORNER_COSINE && n[0] * m[1] - n[1] * m[0] > 0.0
    })
}

/// Edge along which further rows are to be placed.
struct ActiveEdge<'a> {
    boundary_edge: &'a BoundaryEdge,
    pitch: f64,
    /// Edges at which its rows end.
    ends_at: Vec<&'a BoundaryEdge>,
}

/// Rows of points along the edges of a region: first along arcs, as far as these are the nearest edges, then along straight edges.
pub(super) fn rows_along_boundary(region: &PlanarRegion<'_>) -> SpacedPoints {
    let spacing = region.spacing;
    let mut points = SpacedPoints::new(spacing);
    for round in [true, false] {
        let own = region
            .sides
            .iter()
            .filter(|boundary_edge| matches!(boundary_edge, BoundaryEdge::Arc { .. }) == round);
        let mut going: Vec<ActiveEdge<'_>> = own
            .map(|boundary_edge| {
                let ends = |other: &&BoundaryEdge| {
                    *other != boundary_edge && !is_perpendicular_corner(boundary_edge, other, 1e-6 * spacing)
                };
                let pitch = row_spacing(boundary_edge, &region.sides, spacing);
                ActiveEdge { boundary_edge, pitch, ends_at: region.sides.iter().filter(ends).collect() }
            })
            .collect();
        let mut number = 0.0;
        while !going.is_empty() {
            going.retain(|going| {
                let depth = (number + 0.5) * going.pitch;
                let nearest = |x: &PlanePoint| {
                    going.ends_at.iter().all(|other| other.distance(*x) > depth * (1.0 - NEAREST_TOLERANCE))
                        && region.shape.contains(x)
                };
                let since = points.points.len();
                let mut any = false;
                for x in row_points(going.boundary_edge, depth, spacing).into_iter().filter(nearest) {
                    any = true;
                    if points.is_free_except_since(
                        x,
                        ROW_CLEARANCE * spacing,
                        since,
                        CLEARANCE_IN_ROW * spacing,
                    ) {
                        points.add(x);
                    }
                }
                any
            });
            number += 1.0;
        }
    }
    points
}
