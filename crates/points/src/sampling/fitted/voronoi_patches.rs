//! Voronoi patches of points within a region.

use crate::sampling::fitted::PlanarRegion;
use crate::search::neighbours::CellList;
use crate::shape::{BoundaryEdge, PlanePoint, SectorMoments};

/// Half the edge of the square around a point that bounds its patch (spacings).
const SEARCH_HALF_WIDTH: f64 = 1.2;

/// Distance within which positions coincide (spacings).
const COINCIDENCE_TOLERANCE: f64 = 1e-9;

/// Voronoi patches of points.
pub(super) struct VoronoiPatches<'a> {
    region: &'a PlanarRegion<'a>,
    points: &'a [PlanePoint],
    cells: CellList<2>,
}

impl<'a> VoronoiPatches<'a> {
    /// Voronoi patches of points, with a cell list of their neighbours.
    pub(super) fn new(region: &'a PlanarRegion<'a>, points: &'a [PlanePoint]) -> Self {
        let mut cells = CellList::new();
        // Cannot fail: the points of a sampled shape are finite and not too many.
        let _ = cells.build(points, 2.0 * std::f64::consts::SQRT_2 * SEARCH_HALF_WIDTH * region.spacing);
        Self { region, points, cells }
    }

    /// Centroid (m) and area (m²) of the patch of a point.
    pub(super) fn centroid_and_area(&self, i: usize) -> (PlanePoint, f64) {
        let point = self.points[i];
        let (ring, reach) = self.cell(i);
        let near: Vec<&BoundaryEdge> =
            self.region.sides.iter().filter(|side| side.distance(point) < reach).collect();
        let next = ring.iter().cycle().skip(1);
        let place = |[x, y]: &PlanePoint| [point[0] + x, point[1] + y];
        let edges = || {
            ring.iter().zip(next.clone()).map(|(a, b)| BoundaryEdge::Line { from: place(a), to: place(b) })
        };
        let sum = if near.is_empty() {
            edges().fold(SectorMoments::default(), |mut sum, edge| {
                sum.add(&edge.sector_moments(point));
                sum
            })
        } else {
            self.clipped_moments(point, &edges().collect::<Vec<_>>(), &near)
        };
        if sum.area <= 0.0 {
            return (point, 0.0);
        }
        ([0, 1].map(|c| point[c] + sum.first[c] / sum.area), sum.area)
    }

    /// Corners of the Voronoi cell of a point relative to the point (m), counter-clockwise, and the distance of the farthest corner (m).
    fn cell(&self, i: usize) -> (Vec<PlanePoint>, f64) {
        let (point, half) = (self.points[i], SEARCH_HALF_WIDTH * self.region.spacing);
        let mut others: Vec<(f64, PlanePoint)> = Vec::new();
        self.cells.visit(&point, |j| {
            let d = [0, 1].map(|c| self.points[j as usize][c] - point[c]);
            if j as usize != i {
                others.push((d[0] * d[0] + d[1] * d[1], d));
            }
        });
        others
            .sort_by(|(a, d), (b, e)| a.total_cmp(b).then(d[0].total_cmp(&e[0])).then(d[1].total_cmp(&e[1])));
        let mut ring = vec![[-half, -half], [half, -half], [half, half], [-half, half]];
        let farthest = |ring: &[PlanePoint]| ring.iter().map(|[x, y]| x * x + y * y).fold(0.0, f64::max);
        let mut square = farthest(&ring);
        for (distance, d) in others {
            // Bisectors lie half way between the points.
            if distance > 4.0 * square {
                break;
            }
            let beyond = |x: &PlanePoint| d[0] * x[0] + d[1] * x[1] - 0.5 * distance;
            let mut cut = Vec::with_capacity(ring.len() + 1);
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let (at_a, at_b) = (beyond(a), beyond(b));
                if at_a <= 0.0 {
                    cut.push(*a);
                }
                if (at_a < 0.0 && at_b > 0.0) || (at_a > 0.0 && at_b < 0.0) {
                    let t = at_a / (at_a - at_b);
                    cut.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
                }
            }
            ring = cut;
            square = farthest(&ring);
        }
        (ring, square.sqrt())
    }

    /// Area and moments of the part of a convex ring within the region, integrated along the boundary of that part.
    fn clipped_moments(
        &self,
        point: PlanePoint,
        edges: &[BoundaryEdge],
        near: &[&BoundaryEdge],
    ) -> SectorMoments {
        let same = COINCIDENCE_TOLERANCE * self.region.spacing;
        let mut sum = SectorMoments::default();
        for edge in edges.iter().filter(|edge| edge.length() > same) {
            let shares = near.iter().flat_map(|side| edge.intersection_parameters(side, same)).collect();
            for piece in edge.split_at(shares, 0.0) {
                if self.region.shape.contains(&piece.point_at(0.5)) {
                    sum.add(&piece.sector_moments(point));
                }
            }
        }
        let within = |x: PlanePoint| {
            edges.iter().all(|edge| {
                let (from, n) = (edge.point_at(0.0), edge.left_normal(0.5));
                !((x[0] - from[0]) * n[0] + (x[1] - from[1]) * n[1] < 0.0)
            })
        };
        for side in near {
            let shares = edges.iter().flat_map(|edge| side.intersection_parameters(edge, same)).collect();
            for piece in side.split_at(shares, 0.0) {
                if within(piece.point_at(0.5)) {
                    sum.add(&piece.sector_moments(point));
                }
            }
        }
        sum
    }
}
