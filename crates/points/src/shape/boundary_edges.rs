//! Boundary of a plane shape, as straight edges and arcs with the shape on their left.

use std::f64::consts::{PI, TAU};

use crate::shape::Shape;
use crate::surface::vector::{add_scaled, cross_2d, difference, dot};

/// Share of the extent of a shape within which positions coincide.
const COINCIDENCE_TOLERANCE: f64 = 1e-9;

/// Distance from an edge, over the extent of the shape, at which the side of the shape is determined.
const SIDE_PROBE_DISTANCE: f64 = 1e-7;

/// Position in the plane (m).
pub(crate) type PlanePoint = [f64; 2];

/// Length of a vector (m).
fn norm(a: PlanePoint) -> f64 {
    a[0].hypot(a[1])
}

/// Edge of a boundary, a line segment or an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BoundaryEdge {
    /// Segment between two ends (m).
    Line { from: PlanePoint, to: PlanePoint },
    /// Arc of a circle from angle `start` by `sweep` (radians), positive counter-clockwise.
    Arc { centre: PlanePoint, radius: f64, start: f64, sweep: f64 },
}

/// Area (m²) between a position and edges around it, and its first moments about that position (m³).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SectorMoments {
    /// Area of the sector (m²).
    pub(crate) area: f64,
    /// First moment of area (m³).
    pub(crate) first: PlanePoint,
}

impl SectorMoments {
    /// Adds the moments of another sector.
    pub(crate) fn add(&mut self, other: &Self) {
        self.area += other.area;
        (0..2).for_each(|c| self.first[c] += other.first[c]);
    }
}

impl BoundaryEdge {
    /// Position at the share `t` of its length (m).
    pub(crate) fn point_at(&self, t: f64) -> PlanePoint {
        match *self {
            Self::Line { from, to } => add_scaled(&from, t, &difference(&to, &from)),
            Self::Arc { centre, radius, start, sweep } => {
                let (sine, cosine) = (start + t * sweep).sin_cos();
                [centre[0] + radius * cosine, centre[1] + radius * sine]
            }
        }
    }

    /// Unit normal to the left at the share `t` of its length.
    pub(crate) fn left_normal(&self, t: f64) -> PlanePoint {
        match *self {
            Self::Line { from, to } => {
                let d = difference(&to, &from);
                [-d[1] / norm(d), d[0] / norm(d)]
            }
            Self::Arc { start, sweep, .. } => {
                let (sine, cosine) = (start + t * sweep).sin_cos();
                let inwards = -sweep.signum();
                [inwards * cosine, inwards * sine]
            }
        }
    }

    /// Length of the edge (m).
    pub(crate) fn length(&self) -> f64 {
        match *self {
            Self::Line { from, to } => norm(difference(&to, &from)),
            Self::Arc { radius, sweep, .. } => radius * sweep.abs(),
        }
    }

    /// Part between two shares of its length.
    pub(crate) fn sub_edge(&self, begin: f64, end: f64) -> Self {
        match *self {
            Self::Line { .. } => Self::Line { from: self.point_at(begin), to: self.point_at(end) },
            Self::Arc { centre, radius, start, sweep } => {
                Self::Arc { centre, radius, start: start + begin * sweep, sweep: (end - begin) * sweep }
            }
        }
    }

    /// Edge in the opposite direction.
    fn reversed(&self) -> Self {
        self.sub_edge(1.0, 0.0)
    }

    /// Distance of a position from the edge (m).
    pub(crate) fn distance(&self, x: PlanePoint) -> f64 {
        match *self {
            Self::Line { from, to } => {
                let d = difference(&to, &from);
                let t = (dot(&difference(&x, &from), &d) / dot(&d, &d)).clamp(0.0, 1.0);
                norm(difference(&x, &add_scaled(&from, t, &d)))
            }
            Self::Arc { centre, radius, .. } => match self.parameter_of(x, 0.0) {
                Some(_) => (norm(difference(&x, &centre)) - radius).abs(),
                None => {
                    norm(difference(&x, &self.point_at(0.0))).min(norm(difference(&x, &self.point_at(1.0))))
                }
            },
        }
    }

    /// Share of the length of the edge at which a position on its line or circle lies. `None` beyond its ends by more than `slack` (m).
    fn parameter_of(&self, x: PlanePoint, slack: f64) -> Option<f64> {
        match *self {
            Self::Line { from, to } => {
                let d = difference(&to, &from);
                let (t, beyond) = (dot(&difference(&x, &from), &d) / dot(&d, &d), slack / norm(d));
                (-beyond..=1.0 + beyond).contains(&t).then_some(t)
            }
            Self::Arc { centre, radius, start, sweep } => {
                let [dx, dy] = difference(&x, &centre);
                let turn = ((dy.atan2(dx) - start) * sweep.signum()).rem_euclid(TAU);
                let beyond = slack / radius;
                if turn <= sweep.abs() + beyond {
                    return Some(turn / sweep.abs());
                }
                (turn >= TAU - beyond).then_some(0.0)
            }
        }
    }

    /// Intersections of the line or circle of this edge with that of another one: at most two. The ends of the other edge where both
    /// coincide.
    fn carrier_intersections(&self, other: &Self, same: f64) -> Vec<PlanePoint> {
        match (*self, *other) {
            (Self::Line { from, to }, Self::Line { from: begin, to: end }) => {
                let (d, e, between) =
                    (difference(&to, &from), difference(&end, &begin), difference(&begin, &from));
                let turn = cross_2d(&d, &e);
                if turn.abs() > 1e-12 * norm(d) * norm(e) {
                    return vec![add_scaled(&from, cross_2d(&between, &e) / turn, &d)];
                }
                let apart = cross_2d(&d, &between).abs() / norm(d);
                if apart < same { vec![begin, end] } else { Vec::new() }
            }
            (Self::Line { from, to }, Self::Arc { centre, radius, .. })
            | (Self::Arc { centre, radius, .. }, Self::Line { from, to }) => {
                let d = difference(&to, &from);
                let middle = dot(&difference(&centre, &from), &d) / dot(&d, &d);
                let away = norm(difference(&centre, &add_scaled(&from, middle, &d)));
                if away > radius + same {
                    return Vec::new();
                }
                let half = (radius * radius - away * away).max(0.0).sqrt() / norm(d);
                vec![add_scaled(&from, middle - half, &d), add_scaled(&from, middle + half, &d)]
            }
            (
                Self::Arc { centre, radius, .. },
                Self::Arc { centre: other_centre, radius: other_radius, .. },
            ) => {
                let d = difference(&other_centre, &centre);
                let apart = norm(d);
                if apart < same {
                    let ends = || vec![other.point_at(0.0), other.point_at(1.0)];
                    return if (radius - other_radius).abs() < same { ends() } else { Vec::new() };
                }
                if apart > radius + other_radius + same || apart < (radius - other_radius).abs() - same {
                    return Vec::new();
                }
                let to_chord = 0.5 * (apart + (radius * radius - other_radius * other_radius) / apart);
                let half = (radius * radius - to_chord * to_chord).max(0.0).sqrt() / apart;
                let foot = add_scaled(&centre, to_chord / apart, &d);
                [-half, half].map(|h| add_scaled(&foot, h, &[-d[1], d[0]])).to_vec()
            }
        }
    }

    /// Shares of the length of the edge at which another edge intersects it, within `same` (m).
    pub(crate) fn intersection_parameters(&self, other: &Self, same: f64) -> impl Iterator<Item = f64> {
        let on_both =
            move |place: PlanePoint| other.parameter_of(place, same).and(self.parameter_of(place, same));
        self.carrier_intersections(other, same).into_iter().filter_map(on_both)
    }

    /// Parts of the edge between the given shares of its length, without parts shorter than `same` (m).
    pub(crate) fn split_at(&self, mut shares: Vec<f64>, same: f64) -> Vec<Self> {
        shares.extend([0.0, 1.0]);
        shares.sort_by(f64::total_cmp);
        let length = self.length();
        let clamped = shares.windows(2).map(|pair| [pair[0].clamp(0.0, 1.0), pair[1].clamp(0.0, 1.0)]);
        clamped
            .filter(|[begin, end]| (end - begin) * length > same)
            .map(|[begin, end]| self.sub_edge(begin, end))
            .collect()
    }

    /// Area between a position and the edge, and its first moments. They are positive where the edge runs counter-clockwise around the
    /// position.
    pub(crate) fn sector_moments(&self, origin: PlanePoint) -> SectorMoments {
        let (a, b) = (difference(&self.point_at(0.0), &origin), difference(&self.point_at(1.0), &origin));
        let area = 0.5 * cross_2d(&a, &b);
        let mut sum = SectorMoments { area, first: [(a[0] + b[0]) * area / 3.0, (a[1] + b[1]) * area / 3.0] };
        if let Self::Arc { centre, radius, start, sweep } = *self {
            // Circular segment between chord and arc.
            let area = 0.5 * radius * radius * (sweep - sweep.sin());
            let moment = 2.0 / 3.0 * (radius * (0.5 * sweep).sin()).powi(3);
            let (sine, cosine) = (start + 0.5 * sweep).sin_cos();
            let from = difference(&centre, &origin);
            sum.add(&SectorMoments {
                area,
                first: [area * from[0] + moment * cosine, area * from[1] + moment * sine],
            });
        }
        sum
    }

    /// Edge that joins this one and the next one, which lies on the same line or circle.
    fn merged_with(&self, next: &Self, same: f64) -> Option<Self> {
        if norm(difference(&self.point_at(1.0), &next.point_at(0.0))) > same {
            return None;
        }
        match (*self, *next) {
            (Self::Line { from, .. }, Self::Line { to, .. }) => {
                let straight =
                    norm(difference(&self.left_normal(0.5), &next.left_normal(0.5))) < COINCIDENCE_TOLERANCE;
                straight.then_some(Self::Line { from, to })
            }
            (
                Self::Arc { centre, radius, start, sweep },
                Self::Arc { centre: other, radius: other_radius, sweep: more, .. },
            ) => {
                let circle = norm(difference(&centre, &other)) < same && (radius - other_radius).abs() < same;
                let whole = (sweep + more).abs() <= TAU * (1.0 + COINCIDENCE_TOLERANCE);
                (circle && sweep * more > 0.0 && whole).then_some(Self::Arc {
                    centre,
                    radius,
                    start,
                    sweep: (sweep + more).clamp(-TAU, TAU),
                })
            }
            _ => None,
        }
    }
}

impl Shape {
    /// Edges of a valid plane shape, with the shape on their left; `None` for a shape with other edges than lines and arcs, or with too
    /// many.
    pub(crate) fn boundary_edges(&self) -> Option<Vec<BoundaryEdge>> {
        let mut all = Vec::new();
        self.collect_edges(&mut all)?;
        let (low, high) = self.bounds(2);
        let extent = (high[0] - low[0]).hypot(high[1] - low[1]);
        if !(extent > 0.0) {
            return Some(Vec::new());
        }
        let same = COINCIDENCE_TOLERANCE * extent;
        let mut kept: Vec<BoundaryEdge> = Vec::new();
        for (number, side) in all.iter().enumerate() {
            let others = all.iter().enumerate().filter(|(other, _)| *other != number);
            let shares = others.flat_map(|(_, other)| side.intersection_parameters(other, same)).collect();
            for piece in side.split_at(shares, same) {
                let (middle, left) = (piece.point_at(0.5), piece.left_normal(0.5));
                let inside = |beside: f64| self.contains(&add_scaled(&middle, beside * extent, &left));
                let twice = |other: &BoundaryEdge| norm(difference(&other.point_at(0.5), &middle)) < same;
                match (inside(SIDE_PROBE_DISTANCE), inside(-SIDE_PROBE_DISTANCE)) {
                    (true, false) if !kept.iter().any(twice) => kept.push(piece),
                    (false, true) if !kept.iter().any(twice) => kept.push(piece.reversed()),
                    _ => {}
                }
            }
        }
        while let Some((first, second, whole)) = mergeable_edges(&kept, same) {
            kept[first] = whole;
            kept.remove(second);
        }
        Some(kept)
    }

    /// Whether it is a valid plane shape along whose edges points can lie in rows.
    pub fn has_boundary_edges(&self) -> bool {
        self.collect_edges(&mut Vec::new()).is_some()
    }

    /// Whether it, or a part of it, has round edges.
    pub fn has_round_edges(&self) -> bool {
        match self {
            Self::Ball { .. } | Self::Cylinder { .. } => true,
            Self::Union { shapes } | Self::Intersection { shapes } => {
                shapes.iter().any(Self::has_round_edges)
            }
            Self::Difference { from, cut } => from.has_round_edges() || cut.has_round_edges(),
            _ => false,
        }
    }

    /// Adds the edges of the parts of the shape, in either sense of rotation.
    fn collect_edges(&self, all: &mut Vec<BoundaryEdge>) -> Option<()> {
        let mut ring = |corners: &[PlanePoint]| {
            let next = corners.iter().cycle().skip(1);
            let sides = corners.iter().zip(next).filter(|(a, b)| a != b);
            all.extend(sides.map(|(a, b)| BoundaryEdge::Line { from: *a, to: *b }));
        };
        match self {
            Self::Box { min, max } => {
                let ([left, bottom], [right, top]) = (min[..].try_into().ok()?, max[..].try_into().ok()?);
                ring(&[[left, bottom], [right, bottom], [right, top], [left, top]]);
            }
            Self::Ball { centre, radius } if centre.len() == 2 => {
                let half = |start| BoundaryEdge::Arc {
                    centre: [centre[0], centre[1]],
                    radius: *radius,
                    start,
                    sweep: PI,
                };
                all.extend([half(0.0), half(PI)]);
            }
            Self::Polygon { vertices } => ring(vertices),
            Self::Union { shapes } | Self::Intersection { shapes } => {
                shapes.iter().try_for_each(|shape| shape.collect_edges(all))?;
            }
            Self::Difference { from, cut } => {
                from.collect_edges(all)?;
                cut.collect_edges(all)?;
            }
            _ => return None,
        }
        (all.len() <= MAX_EDGES).then_some(())
    }
}

/// Largest number of edges of which all pairs are tested.
const MAX_EDGES: usize = 2000;

/// Two edges that can be merged, and the merged edge.
fn mergeable_edges(sides: &[BoundaryEdge], same: f64) -> Option<(usize, usize, BoundaryEdge)> {
    for (first, side) in sides.iter().enumerate() {
        for (second, next) in sides.iter().enumerate().filter(|(second, _)| *second != first) {
            if let Some(whole) = side.merged_with(next, same) {
                return Some((first, second, whole));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(x: f64, y: f64, radius: f64) -> Shape {
        Shape::Ball { centre: vec![x, y], radius }
    }

    fn rectangle(min: [f64; 2], max: [f64; 2]) -> Shape {
        Shape::Box { min: min.to_vec(), max: max.to_vec() }
    }

    fn area(shape: &Shape) -> (usize, f64) {
        let sides = shape.boundary_edges().unwrap();
        (sides.len(), sides.iter().map(|side| side.sector_moments([0.3, 0.2]).area).sum())
    }

    fn difference(from: Shape, cut: Shape) -> Shape {
        Shape::Difference { from: Box::new(from), cut: Box::new(cut) }
    }

    #[test]
    fn sides_enclose_the_area_of_the_closed_form() {
        let lens = Shape::Intersection { shapes: vec![ball(0.0, 0.0, 1.0), ball(1.0, 0.0, 1.0)] };
        let ring = difference(ball(0.0, 0.0, 1.0), ball(0.0, 0.0, 0.5));
        let corner = difference(rectangle([0.0, 0.0], [3.0, 2.0]), ball(0.0, 0.0, 1.0));
        let edge = difference(rectangle([0.0, 0.0], [3.0, 2.0]), rectangle([0.0, 0.0], [1.0, 3.0]));
        let side_by_side = Shape::Union {
            shapes: vec![rectangle([0.0, 0.0], [1.0, 1.0]), rectangle([1.0, 0.0], [2.0, 1.0])],
        };
        let angular =
            Shape::Polygon { vertices: vec![[0.0, 0.0], [1.0, 1.0], [2.0, 0.0], [1.0, 3.0]].into() };
        for (shape, sides, exact) in [
            (lens, 2, 2.0 * PI / 3.0 - 0.75f64.sqrt()),
            (ring, 2, 0.75 * PI),
            (corner, 5, 6.0 - 0.25 * PI),
            (edge, 4, 4.0),
            (side_by_side, 4, 2.0),
            (angular, 4, 2.0),
        ] {
            let (count, found) = area(&shape);
            assert_eq!(count, sides, "{shape:?}");
            assert!((found - exact).abs() < 1e-12, "{shape:?}: {found} for {exact}");
        }
    }

    #[test]
    fn a_round_side_has_the_moment_of_its_sector() {
        let quarter = BoundaryEdge::Arc { centre: [2.0, 1.0], radius: 3.0, start: 0.0, sweep: 0.5 * PI };
        let SectorMoments { area, first } = quarter.sector_moments([2.0, 1.0]);
        assert!((area - 2.25 * PI).abs() < 1e-12);
        // Centroid of a quarter disk: 4 R / 3 π.
        assert!((first[0] / area - 4.0 / PI).abs() < 1e-12 && (first[0] - first[1]).abs() < 1e-12);
        assert!((quarter.distance([4.0, 1.0]) - 1.0).abs() < 1e-12);
        assert!((quarter.distance([2.0, -1.0]) - 13.0f64.sqrt()).abs() < 1e-12, "from its end at (5, 1)");
    }

    #[test]
    fn shapes_in_space_and_invalid_shapes_have_no_boundary_edges() {
        let cylinder = Shape::Cylinder { base: [0.0; 3], axis: 1, radius: 0.5, height: 2.0 };
        assert!(!cylinder.has_boundary_edges() && cylinder.has_round_edges());
        assert!(!Shape::Ball { centre: vec![0.0; 3], radius: 1.0 }.has_boundary_edges());
        // Invalid shape, as a case file may contain before validation.
        assert!(!Shape::Box { min: vec![0.0; 2], max: Vec::new() }.has_boundary_edges());
    }
}
