//! The outline of a shape in the plane, as straight and round sides with the shape on their left.

use std::f64::consts::{PI, TAU};

use super::Shape;
use crate::surface::vector::{along, cross_flat, dot, minus};

/// Share of the extent of a shape within which places are the same.
const SAME: f64 = 1e-9;

/// Share of the extent at which it is looked to which side of a piece the shape lies.
const BESIDE: f64 = 1e-7;

/// A place in the plane (m).
pub(crate) type Place = [f64; 2];

fn size(a: Place) -> f64 {
    a[0].hypot(a[1])
}

/// A side, straight or round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Side {
    /// From one end to the other (m).
    Line { from: Place, to: Place },
    /// Of a circle, from an angle on (radians), by a sweep that is positive counter-clockwise.
    Arc { centre: Place, radius: f64, start: f64, sweep: f64 },
}

/// Area (m²) between a place and sides around it, and its first moments about that place (m³).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Moments {
    pub(crate) area: f64,
    pub(crate) first: Place,
}

impl Moments {
    pub(crate) fn add(&mut self, other: &Self) {
        self.area += other.area;
        (0..2).for_each(|c| self.first[c] += other.first[c]);
    }
}

impl Side {
    /// Its place at a share `t` of its length.
    pub(crate) fn at(&self, t: f64) -> Place {
        match *self {
            Self::Line { from, to } => along(&from, t, &minus(&to, &from)),
            Self::Arc { centre, radius, start, sweep } => {
                let (sine, cosine) = (start + t * sweep).sin_cos();
                [centre[0] + radius * cosine, centre[1] + radius * sine]
            }
        }
    }

    /// Unit normal to the left.
    pub(crate) fn left(&self, t: f64) -> Place {
        match *self {
            Self::Line { from, to } => {
                let d = minus(&to, &from);
                [-d[1] / size(d), d[0] / size(d)]
            }
            Self::Arc { start, sweep, .. } => {
                let (sine, cosine) = (start + t * sweep).sin_cos();
                let inwards = -sweep.signum();
                [inwards * cosine, inwards * sine]
            }
        }
    }

    /// Length (m).
    pub(crate) fn length(&self) -> f64 {
        match *self {
            Self::Line { from, to } => size(minus(&to, &from)),
            Self::Arc { radius, sweep, .. } => radius * sweep.abs(),
        }
    }

    /// The part between two shares of its length.
    pub(crate) fn part(&self, begin: f64, end: f64) -> Self {
        match *self {
            Self::Line { .. } => Self::Line { from: self.at(begin), to: self.at(end) },
            Self::Arc { centre, radius, start, sweep } => {
                Self::Arc { centre, radius, start: start + begin * sweep, sweep: (end - begin) * sweep }
            }
        }
    }

    fn reversed(&self) -> Self {
        self.part(1.0, 0.0)
    }

    /// Distance of a place from it (m).
    pub(crate) fn distance(&self, x: Place) -> f64 {
        match *self {
            Self::Line { from, to } => {
                let d = minus(&to, &from);
                let t = (dot(&minus(&x, &from), &d) / dot(&d, &d)).clamp(0.0, 1.0);
                size(minus(&x, &along(&from, t, &d)))
            }
            Self::Arc { centre, radius, .. } => match self.share(x, 0.0) {
                Some(_) => (size(minus(&x, &centre)) - radius).abs(),
                None => size(minus(&x, &self.at(0.0))).min(size(minus(&x, &self.at(1.0)))),
            },
        }
    }

    /// The share of its length at which a place on its line or circle lies; `None` beyond its ends by more than `slack` (m).
    fn share(&self, x: Place, slack: f64) -> Option<f64> {
        match *self {
            Self::Line { from, to } => {
                let d = minus(&to, &from);
                let (t, beyond) = (dot(&minus(&x, &from), &d) / dot(&d, &d), slack / size(d));
                (-beyond..=1.0 + beyond).contains(&t).then_some(t)
            }
            Self::Arc { centre, radius, start, sweep } => {
                let [dx, dy] = minus(&x, &centre);
                let turn = ((dy.atan2(dx) - start) * sweep.signum()).rem_euclid(TAU);
                let beyond = slack / radius;
                if turn <= sweep.abs() + beyond {
                    return Some(turn / sweep.abs());
                }
                (turn >= TAU - beyond).then_some(0.0)
            }
        }
    }

    /// Where its line or circle meets that of another: twice at most, and at the ends of the other where they are the same.
    fn carriers_meet(&self, other: &Self, same: f64) -> Vec<Place> {
        match (*self, *other) {
            (Self::Line { from, to }, Self::Line { from: begin, to: end }) => {
                let (d, e, between) = (minus(&to, &from), minus(&end, &begin), minus(&begin, &from));
                let turn = cross_flat(&d, &e);
                if turn.abs() > 1e-12 * size(d) * size(e) {
                    return vec![along(&from, cross_flat(&between, &e) / turn, &d)];
                }
                let apart = cross_flat(&d, &between).abs() / size(d);
                if apart < same { vec![begin, end] } else { Vec::new() }
            }
            (Self::Line { from, to }, Self::Arc { centre, radius, .. })
            | (Self::Arc { centre, radius, .. }, Self::Line { from, to }) => {
                let d = minus(&to, &from);
                let middle = dot(&minus(&centre, &from), &d) / dot(&d, &d);
                let away = size(minus(&centre, &along(&from, middle, &d)));
                if away > radius + same {
                    return Vec::new();
                }
                let half = (radius * radius - away * away).max(0.0).sqrt() / size(d);
                vec![along(&from, middle - half, &d), along(&from, middle + half, &d)]
            }
            (
                Self::Arc { centre, radius, .. },
                Self::Arc { centre: other_centre, radius: other_radius, .. },
            ) => {
                let d = minus(&other_centre, &centre);
                let apart = size(d);
                if apart < same {
                    let ends = || vec![other.at(0.0), other.at(1.0)];
                    return if (radius - other_radius).abs() < same { ends() } else { Vec::new() };
                }
                if apart > radius + other_radius + same || apart < (radius - other_radius).abs() - same {
                    return Vec::new();
                }
                let to_chord = 0.5 * (apart + (radius * radius - other_radius * other_radius) / apart);
                let half = (radius * radius - to_chord * to_chord).max(0.0).sqrt() / apart;
                let foot = along(&centre, to_chord / apart, &d);
                [-half, half].map(|h| along(&foot, h, &[-d[1], d[0]])).to_vec()
            }
        }
    }

    /// Shares of its length at which another side meets it, to within `same` (m).
    pub(crate) fn meets(&self, other: &Self, same: f64) -> impl Iterator<Item = f64> {
        let on_both = move |place: Place| other.share(place, same).and(self.share(place, same));
        self.carriers_meet(other, same).into_iter().filter_map(on_both)
    }

    /// Its pieces between these shares of its length and its ends, longer than `same` (m).
    pub(crate) fn pieces(&self, mut shares: Vec<f64>, same: f64) -> Vec<Self> {
        shares.extend([0.0, 1.0]);
        shares.sort_by(f64::total_cmp);
        let length = self.length();
        let clamped = shares.windows(2).map(|pair| [pair[0].clamp(0.0, 1.0), pair[1].clamp(0.0, 1.0)]);
        clamped
            .filter(|[begin, end]| (end - begin) * length > same)
            .map(|[begin, end]| self.part(begin, end))
            .collect()
    }

    /// What lies between a place and the side, as seen from there: positive where the side goes round it counter-clockwise.
    pub(crate) fn fan(&self, origin: Place) -> Moments {
        let (a, b) = (minus(&self.at(0.0), &origin), minus(&self.at(1.0), &origin));
        let area = 0.5 * cross_flat(&a, &b);
        let mut sum = Moments { area, first: [(a[0] + b[0]) * area / 3.0, (a[1] + b[1]) * area / 3.0] };
        if let Self::Arc { centre, radius, start, sweep } = *self {
            // Segment between chord and arc.
            let area = 0.5 * radius * radius * (sweep - sweep.sin());
            let moment = 2.0 / 3.0 * (radius * (0.5 * sweep).sin()).powi(3);
            let (sine, cosine) = (start + 0.5 * sweep).sin_cos();
            let from = minus(&centre, &origin);
            sum.add(&Moments {
                area,
                first: [area * from[0] + moment * cosine, area * from[1] + moment * sine],
            });
        }
        sum
    }

    /// One side of this and another that goes on from its end along the same line or circle.
    fn joined(&self, next: &Self, same: f64) -> Option<Self> {
        if size(minus(&self.at(1.0), &next.at(0.0))) > same {
            return None;
        }
        match (*self, *next) {
            (Self::Line { from, .. }, Self::Line { to, .. }) => {
                let straight = size(minus(&self.left(0.5), &next.left(0.5))) < SAME;
                straight.then_some(Self::Line { from, to })
            }
            (
                Self::Arc { centre, radius, start, sweep },
                Self::Arc { centre: other, radius: other_radius, sweep: more, .. },
            ) => {
                let circle = size(minus(&centre, &other)) < same && (radius - other_radius).abs() < same;
                let whole = (sweep + more).abs() <= TAU * (1.0 + SAME);
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
    /// The sides of a valid shape in the plane, each with the shape on its left; `None` of what has other than straight and round ones,
    /// or too many.
    pub(crate) fn sides(&self) -> Option<Vec<Side>> {
        let mut all = Vec::new();
        self.own_sides(&mut all)?;
        let (low, high) = self.bounds(2);
        let extent = (high[0] - low[0]).hypot(high[1] - low[1]);
        if !(extent > 0.0) {
            return Some(Vec::new());
        }
        let same = SAME * extent;
        let mut kept: Vec<Side> = Vec::new();
        for (number, side) in all.iter().enumerate() {
            let others = all.iter().enumerate().filter(|(other, _)| *other != number);
            let shares = others.flat_map(|(_, other)| side.meets(other, same)).collect();
            for piece in side.pieces(shares, same) {
                let (middle, left) = (piece.at(0.5), piece.left(0.5));
                let inside = |beside: f64| self.contains(&along(&middle, beside * extent, &left));
                let twice = |other: &Side| size(minus(&other.at(0.5), &middle)) < same;
                match (inside(BESIDE), inside(-BESIDE)) {
                    (true, false) if !kept.iter().any(twice) => kept.push(piece),
                    (false, true) if !kept.iter().any(twice) => kept.push(piece.reversed()),
                    _ => {}
                }
            }
        }
        while let Some((first, second, whole)) = joint(&kept, same) {
            kept[first] = whole;
            kept.remove(second);
        }
        Some(kept)
    }

    /// Whether points can lie in rows along its sides, of a valid shape in the plane; of no other one.
    pub fn has_sides(&self) -> bool {
        self.own_sides(&mut Vec::new()).is_some()
    }

    /// Whether it, or a shape that it is made of, is round.
    pub fn is_round(&self) -> bool {
        match self {
            Self::Ball { .. } | Self::Cylinder { .. } => true,
            Self::Union { shapes } | Self::Intersection { shapes } => shapes.iter().any(Self::is_round),
            Self::Difference { from, cut } => from.is_round() || cut.is_round(),
            _ => false,
        }
    }

    /// The sides of the shapes that it is made of, in any sense of rotation.
    fn own_sides(&self, all: &mut Vec<Side>) -> Option<()> {
        let mut ring = |corners: &[Place]| {
            let next = corners.iter().cycle().skip(1);
            let sides = corners.iter().zip(next).filter(|(a, b)| a != b);
            all.extend(sides.map(|(a, b)| Side::Line { from: *a, to: *b }));
        };
        match self {
            Self::Box { min, max } => {
                let ([left, bottom], [right, top]) = (min[..].try_into().ok()?, max[..].try_into().ok()?);
                ring(&[[left, bottom], [right, bottom], [right, top], [left, top]]);
            }
            Self::Ball { centre, radius } if centre.len() == 2 => {
                let half =
                    |start| Side::Arc { centre: [centre[0], centre[1]], radius: *radius, start, sweep: PI };
                all.extend([half(0.0), half(PI)]);
            }
            Self::Polygon { vertices } => ring(vertices),
            Self::Union { shapes } | Self::Intersection { shapes } => {
                shapes.iter().try_for_each(|shape| shape.own_sides(all))?;
            }
            Self::Difference { from, cut } => {
                from.own_sides(all)?;
                cut.own_sides(all)?;
            }
            _ => return None,
        }
        (all.len() <= MOST_SIDES).then_some(())
    }
}

/// More sides than this are not looked at pair by pair.
const MOST_SIDES: usize = 2000;

/// Two sides that are one, and that one.
fn joint(sides: &[Side], same: f64) -> Option<(usize, usize, Side)> {
    for (first, side) in sides.iter().enumerate() {
        for (second, next) in sides.iter().enumerate().filter(|(second, _)| *second != first) {
            if let Some(whole) = side.joined(next, same) {
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
        let sides = shape.sides().unwrap();
        (sides.len(), sides.iter().map(|side| side.fan([0.3, 0.2]).area).sum())
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
        let quarter = Side::Arc { centre: [2.0, 1.0], radius: 3.0, start: 0.0, sweep: 0.5 * PI };
        let Moments { area, first } = quarter.fan([2.0, 1.0]);
        assert!((area - 2.25 * PI).abs() < 1e-12);
        // Centre of a quarter disk: 4 R / 3 π.
        assert!((first[0] / area - 4.0 / PI).abs() < 1e-12 && (first[0] - first[1]).abs() < 1e-12);
        assert!((quarter.distance([4.0, 1.0]) - 1.0).abs() < 1e-12);
        assert!((quarter.distance([2.0, -1.0]) - 13.0f64.sqrt()).abs() < 1e-12, "from its end at (5, 1)");
    }

    #[test]
    fn what_is_no_plane_shape_has_no_sides() {
        let cylinder = Shape::Cylinder { base: [0.0; 3], axis: 1, radius: 0.5, height: 2.0 };
        assert!(!cylinder.has_sides() && cylinder.is_round());
        assert!(!Shape::Ball { centre: vec![0.0; 3], radius: 1.0 }.has_sides());
        // As a case file may have it before it is looked at.
        assert!(!Shape::Box { min: vec![0.0; 2], max: Vec::new() }.has_sides());
    }
}
