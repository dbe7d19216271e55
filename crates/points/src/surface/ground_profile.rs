//! Ground profile of line segments and arcs.

use crate::surface::vector::{add_scaled, cross_2d, difference, dot, unit};
use crate::surface::{ContactQuery, NearestPoint, Surface, SurfaceError};

/// Share of an arc's radius by which the distances of its ends from the centre may differ.
const ARC_RADIUS_TOLERANCE: f64 = 1e-6;

/// Segment of a ground profile.
#[derive(Clone, Copy, Debug)]
enum ProfileSegment {
    /// Straight segment between two positions (m).
    Line { from: [f64; 2], to: [f64; 2] },
    /// Arc from the angle `start` by the angle `sweep`, counter-clockwise positive (radians).
    Arc { centre: [f64; 2], radius: f64, start: f64, sweep: f64 },
}

/// Part of a segment on which its nearest position lies.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SegmentPart {
    /// First end of the segment.
    Start,
    /// Positions between the ends.
    Interior,
    /// Last end of the segment.
    Endpoint,
}

impl ProfileSegment {
    /// Length of the segment (m).
    fn length(&self) -> f64 {
        match self {
            Self::Line { from, to } => dot(&difference(to, from), &difference(to, from)).sqrt(),
            Self::Arc { radius, sweep, .. } => radius * sweep.abs(),
        }
    }

    /// Position at a share of the length, and the unit normal to the left of the direction there.
    fn point_and_normal(&self, share: f64) -> ([f64; 2], [f64; 2]) {
        match self {
            Self::Line { from, to } => {
                let direction = difference(to, from);
                (
                    add_scaled(from, share, &direction),
                    unit(&[-direction[1], direction[0]]).unwrap_or([0.0, 1.0]),
                )
            }
            Self::Arc { centre, radius, start, sweep } => {
                let (sine, cosine) = (start + share * sweep).sin_cos();
                let inward = -sweep.signum();
                (add_scaled(centre, *radius, &[cosine, sine]), [inward * cosine, inward * sine])
            }
        }
    }

    /// Share of the length at which the segment is nearest to `x`.
    fn nearest(&self, x: &[f64; 2]) -> (f64, SegmentPart) {
        let share = match self {
            Self::Line { from, to } => {
                let direction = difference(to, from);
                dot(&difference(x, from), &direction) / dot(&direction, &direction)
            }
            Self::Arc { centre, start, sweep, .. } => {
                let out = difference(x, centre);
                let mut turn = (out[1].atan2(out[0]) - start) * sweep.signum();
                // From half of the remaining circle before the start to half of it beyond the end.
                let full = std::f64::consts::TAU;
                let rest = 0.5 * (full - sweep.abs());
                turn -= full * ((turn + rest) / full).floor();
                turn / sweep.abs()
            }
        };
        if !(share > 0.0) {
            (0.0, SegmentPart::Start)
        } else if share >= 1.0 {
            (1.0, SegmentPart::Endpoint)
        } else {
            (share, SegmentPart::Interior)
        }
    }

    /// Nearest position on the segment (m).
    fn nearest_position(&self, x: &[f64; 2]) -> [f64; 2] {
        self.point_and_normal(self.nearest(x).0).0
    }

    /// Intersections of the line or circle of this segment with that of another one. They may lie beyond the segments.
    fn carrier_intersections(&self, other: &Self) -> Vec<[f64; 2]> {
        match (self, other) {
            (Self::Line { from: a, to: b }, Self::Line { from: c, to: d }) => {
                let (u, v, w) = (difference(b, a), difference(d, c), difference(c, a));
                let (across, size) = (cross_2d(&u, &v), (dot(&u, &u) * dot(&v, &v)).sqrt());
                if across.abs() > ARC_RADIUS_TOLERANCE * size {
                    vec![add_scaled(a, cross_2d(&w, &v) / across, &u)]
                } else {
                    // Collinear segments meet at the ends of either that lie on the other.
                    vec![*a, *b, *c, *d]
                }
            }
            (Self::Line { from, to }, Self::Arc { centre, radius, .. })
            | (Self::Arc { centre, radius, .. }, Self::Line { from, to }) => {
                let Some(direction) = unit(&difference(to, from)) else { return Vec::new() };
                let foot = add_scaled(from, dot(&difference(centre, from), &direction), &direction);
                chord_ends(&foot, &difference(&foot, centre), *radius, &direction)
            }
            (Self::Arc { centre: a, radius: r, .. }, Self::Arc { centre: b, radius: s, .. }) => {
                let apart = difference(b, a);
                let distance = dot(&apart, &apart).sqrt();
                let Some(direction) = unit(&apart).filter(|_| distance > ARC_RADIUS_TOLERANCE * r) else {
                    return vec![
                        self.point_and_normal(0.0).0,
                        self.point_and_normal(1.0).0,
                        other.point_and_normal(0.0).0,
                        other.point_and_normal(1.0).0,
                    ];
                };
                let foot = add_scaled(a, 0.5 * (distance + (r * r - s * s) / distance), &direction);
                chord_ends(&foot, &difference(&foot, a), *r, &[-direction[1], direction[0]])
            }
        }
    }

    /// Position at which two segments cross or touch; `None` where they do so only near their common `joint` (m).
    fn crosses(&self, other: &Self, joint: Option<&[f64; 2]>) -> Option<[f64; 2]> {
        let slack = ARC_RADIUS_TOLERANCE * self.length().max(other.length());
        let away = |a: &[f64; 2], b: &[f64; 2]| dot(&difference(a, b), &difference(a, b)) > slack * slack;
        let on_both =
            |x: &[f64; 2]| !away(x, &self.nearest_position(x)) && !away(x, &other.nearest_position(x));
        let apart = |x: &[f64; 2]| {
            joint
                .is_none_or(|joint| dot(&difference(x, joint), &difference(x, joint)) > slack * self.length())
        };
        self.carrier_intersections(other).into_iter().find(|x| on_both(x) && apart(x))
    }
}

/// Intersections of a circle with a line of this direction; `foot` is the position of the line nearest to its centre, and `out` the vector
/// from the centre to it.
fn chord_ends(foot: &[f64; 2], out: &[f64; 2], radius: f64, direction: &[f64; 2]) -> Vec<[f64; 2]> {
    let square = radius * radius - dot(out, out);
    if square < -2.0 * ARC_RADIUS_TOLERANCE * radius * radius {
        return Vec::new();
    }
    let half = square.max(0.0).sqrt();
    vec![add_scaled(foot, half, direction), add_scaled(foot, -half, direction)]
}

/// Ground below a line of straight segments and arcs, built segment by segment from its start. There is no ground beyond its ends.
#[derive(Clone, Debug)]
pub struct GroundProfile {
    segments: Vec<ProfileSegment>,
    end: [f64; 2],
    start: [f64; 2],
}

impl GroundProfile {
    /// Profile that starts at `start` (m), without segments.
    pub fn starting_at(start: [f64; 2]) -> Self {
        Self { segments: Vec::new(), end: start, start }
    }

    /// Adds a straight segment to `to` (m).
    ///
    /// # Errors
    /// When its two ends coincide, or `to` is not finite.
    pub fn line_to(&mut self, to: [f64; 2]) -> Result<(), SurfaceError> {
        let length = difference(&to, &self.end);
        if !(dot(&length, &length) > 0.0 && to.iter().all(|c| c.is_finite())) {
            return Err(SurfaceError::new(
                "to",
                format!(
                    "{to:?} m is not the end of a piece from {:?} m: the two must differ and be finite",
                    self.end
                ),
            ));
        }
        self.segments.push(ProfileSegment::Line { from: self.end, to });
        self.end = to;
        Ok(())
    }

    /// Adds an arc around `centre` (m), the shorter one, to `to` (m).
    ///
    /// # Errors
    /// When the two ends are not equally far from the centre, or coincide.
    pub fn arc_to(&mut self, to: [f64; 2], centre: [f64; 2]) -> Result<(), SurfaceError> {
        let (a, b) = (difference(&self.end, &centre), difference(&to, &centre));
        let [radius, other] = [a, b].map(|v| dot(&v, &v).sqrt());
        if !(radius > 0.0 && (radius - other).abs() <= ARC_RADIUS_TOLERANCE * radius) {
            let problem =
                format!("its ends are {radius} and {other} m from the centre, which must be the same");
            return Err(SurfaceError::new("centre", problem));
        }
        let sweep = (a[0] * b[1] - a[1] * b[0]).atan2(dot(&a, &b));
        if sweep == 0.0 {
            return Err(SurfaceError::new("to", "begins and ends at the same place"));
        }
        self.segments.push(ProfileSegment::Arc { centre, radius, start: a[1].atan2(a[0]), sweep });
        self.end = to;
        Ok(())
    }

    /// Completed profile with the solid below.
    ///
    /// # Errors
    /// When it has no segments, does not run from left to right overall, or crosses itself.
    pub fn close(self) -> Result<Self, SurfaceError> {
        if self.segments.is_empty() {
            return Err(SurfaceError::new("pieces", "there are none"));
        }
        if !(self.end[0] > self.start[0]) {
            let problem = format!(
                "ends at x = {} m, and must end right of its start, {} m",
                self.end[0], self.start[0]
            );
            return Err(SurfaceError::new("pieces", problem));
        }
        for (number, piece) in self.segments.iter().enumerate() {
            for (later, other) in self.segments.iter().enumerate().skip(number + 1) {
                let joint = (later == number + 1).then(|| piece.point_and_normal(1.0).0);
                if let Some(place) = piece.crosses(other, joint.as_ref()) {
                    let problem =
                        format!("meets pieces[{number}] at {place:.6?} m: a profile must not cross itself");
                    return Err(SurfaceError::new(format!("pieces[{later}]"), problem));
                }
            }
        }
        Ok(self)
    }

    /// Nearest segment with the position on it.
    fn nearest(&self, x: &[f64; 2]) -> (usize, f64, SegmentPart, f64) {
        let mut best = (0, 0.0, SegmentPart::Interior, f64::INFINITY);
        for (number, piece) in self.segments.iter().enumerate() {
            let (share, part) = piece.nearest(x);
            let from = difference(x, &piece.point_and_normal(share).0);
            let square = dot(&from, &from);
            if square < best.3 {
                best = (number, share, part, square);
            }
        }
        best
    }

    /// Identifier and normal of a part of a segment. At a joint the normal is the mean of both segments.
    fn feature(&self, number: usize, share: f64, part: SegmentPart) -> (u64, [f64; 2]) {
        let joint = match part {
            SegmentPart::Interior => {
                return ((number as u64) << 2, self.segments[number].point_and_normal(share).1);
            }
            SegmentPart::Start => number,
            SegmentPart::Endpoint => number + 1,
        };
        let before = joint.checked_sub(1).map(|n| self.segments[n].point_and_normal(1.0).1);
        let after = self.segments.get(joint).map(|piece| piece.point_and_normal(0.0).1);
        let sum = [before, after].into_iter().flatten().fold([0.0; 2], |s, n| [s[0] + n[0], s[1] + n[1]]);
        ((joint as u64) << 2 | 2, unit(&sum).unwrap_or([0.0, 1.0]))
    }

    /// Nearest point of the profile, on the segment `number` at the share `share` of its length.
    fn nearest_from(&self, x: &[f64; 2], number: usize, share: f64, part: SegmentPart) -> NearestPoint<2> {
        let (key, normal) = self.feature(number, share, part);
        let (position, _) = self.segments[number].point_and_normal(share);
        let from = difference(x, &position);
        let sign = if dot(&from, &normal) < 0.0 { -1.0 } else { 1.0 };
        let away = if part == SegmentPart::Interior { None } else { unit(&from) };
        let distance = sign * dot(&from, &from).sqrt();
        NearestPoint {
            distance,
            normal: away.map_or(normal, |away| away.map(|c| sign * c)),
            position,
            feature_id: key,
        }
    }
}

impl Surface<2> for GroundProfile {
    fn contains(&self, x: &[f64; 2]) -> bool {
        self.gap(x, f64::INFINITY).is_some_and(|gap| gap.distance <= 0.0)
    }

    fn gap(&self, x: &[f64; 2], reach: f64) -> Option<NearestPoint<2>> {
        let (number, share, part, square) = self.nearest(x);
        (square <= reach * reach).then(|| self.nearest_from(x, number, share, part))
    }

    fn query_contacts(&self, x: &[f64; 2], radius: f64, found: &mut ContactQuery<2>) {
        if self.gap(x, radius).is_none_or(|gap| gap.distance < 0.0) {
            return;
        }
        let before = found.len();
        let square = |place: &[f64; 2]| dot(&difference(x, place), &difference(x, place));
        for (number, piece) in self.segments.iter().enumerate() {
            let (share, part) = piece.nearest(x);
            let (place, normal) = piece.point_and_normal(share);
            let own = square(&place);
            if own > radius * radius || dot(&difference(x, &place), &normal) < 0.0 {
                continue;
            }
            // As for facets, a position at which a nearer segment ends belongs to that segment.
            let shadowed = self.segments.iter().enumerate().any(|(other, nearer)| {
                let theirs = square(&nearer.nearest_position(x));
                let beside = difference(&place, &nearer.nearest_position(&place));
                (theirs, other) < (own, number) && dot(&beside, &beside) <= (1e-7 * radius).powi(2)
            });
            if !shadowed {
                found.add_if_outside(Some(self.nearest_from(x, number, share, part)));
            }
        }
        found
            .contacts_since_mut(before)
            .sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.feature_id.cmp(&b.feature_id)));
    }

    fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        let mut around = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut add = |x: [f64; 2]| {
            for c in 0..2 {
                around.0[c] = around.0[c].min(x[c]);
                around.1[c] = around.1[c].max(x[c]);
            }
        };
        for piece in &self.segments {
            match piece {
                ProfileSegment::Line { from, to } => [*from, *to].into_iter().for_each(&mut add),
                ProfileSegment::Arc { centre, radius, .. } => {
                    add(centre.map(|c| c - radius));
                    add(centre.map(|c| c + radius));
                }
            }
        }
        around
    }

    fn arc_length(&self, x: &[f64; 2]) -> Option<f64> {
        let (number, share, ..) = self.nearest(x);
        let before: f64 = self.segments[..number].iter().map(ProfileSegment::length).sum();
        Some(before + share * self.segments[number].length())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slope of 45°, a circular transition to the level, and a level segment.
    fn slope() -> GroundProfile {
        let mut profile = GroundProfile::starting_at([-1.0, 2.0]);
        let half = 0.5f64.sqrt();
        let foot = [1.0 - half, 1.0 - half];
        profile.line_to([foot[0] - 1.0, foot[1] + 1.0]).unwrap();
        profile.line_to(foot).unwrap();
        profile.arc_to([1.0, 0.0], [1.0, 2.0]).unwrap_err();
        // The centre lies a radius above the foot of the slope along its normal.
        let radius = 2.0;
        let centre = [foot[0] + radius * half, foot[1] + radius * half];
        profile.arc_to([centre[0], centre[1] - radius], centre).unwrap();
        profile.line_to([9.0, centre[1] - radius]).unwrap();
        profile.close().unwrap()
    }

    #[test]
    fn a_self_crossing_profile_is_refused_with_the_position() {
        let of = |pieces: &[([f64; 2], Option<[f64; 2]>)]| {
            let mut profile = GroundProfile::starting_at([0.0, 0.0]);
            for (to, centre) in pieces {
                match centre {
                    Some(centre) => profile.arc_to(*to, *centre).unwrap(),
                    None => profile.line_to(*to).unwrap(),
                }
            }
            profile.close().map(|_| ()).map_err(|error| error.to_string())
        };
        let loops = of(&[([3.0, 0.0], None), ([3.0, 2.0], None), ([1.0, -1.0], None), ([4.0, -1.0], None)]);
        assert!(loops.unwrap_err().starts_with("pieces[2]: meets pieces[0] at [1.66666"));
        let arc = of(&[
            ([4.0, 0.0], None),
            ([4.0, 2.0], Some([4.0, 1.0])),
            ([2.0, 0.0], Some([2.0, 2.0])),
            ([5.0, -3.0], None),
        ]);
        assert!(arc.unwrap_err().contains("meets pieces[0] at [2.0"), "an arc that touches a line");
        let back = of(&[([3.0, 0.0], None), ([1.0, 0.0], None), ([4.0, -1.0], None)]);
        assert!(back.unwrap_err().starts_with("pieces[1]: meets pieces[0]"), "back on the same line");
        let smooth = of(&[
            ([1.0, 0.0], None),
            ([2.0, 1.0], Some([1.0, 1.0])),
            ([3.0, 2.0], Some([3.0, 1.0])),
            ([5.0, 2.0], None),
            ([7.0, 2.0], None),
        ]);
        assert_eq!(smooth, Ok(()), "pieces that go on smoothly");
    }

    #[test]
    fn gaps_over_slope_arc_and_floor_are_those_of_line_and_circle() {
        let (profile, half) = (slope(), 0.5f64.sqrt());
        let foot = 1.0 - half;
        let centre = [foot + 2.0 * half, foot + 2.0 * half];
        let gap = |x: [f64; 2]| profile.gap(&x, 9.0).unwrap();
        let on_slope = gap([foot - 0.5 + 0.3 * half, foot + 0.5 + 0.3 * half]);
        assert!((on_slope.distance - 0.3).abs() < 1e-12 && (on_slope.normal[0] - half).abs() < 1e-12);
        let x = [centre[0] - 0.5, centre[1] - 1.6];
        let away = (0.5f64.powi(2) + 1.6f64.powi(2)).sqrt();
        assert!((gap(x).distance - (2.0 - away)).abs() < 1e-12);
        assert!((gap(x).normal[0] - 0.5 / away).abs() < 1e-12, "towards the centre");
        let below = gap([5.0, centre[1] - 2.4]);
        assert!((below.distance + 0.4).abs() < 1e-12 && (below.normal[1] - 1.0).abs() < 1e-12);
        assert!(profile.contains(&[5.0, -5.0]) && !profile.contains(&[5.0, 5.0]));
        let whole = 2f64.sqrt() + 2.0 * std::f64::consts::FRAC_PI_4;
        let on = profile.arc_length(&[centre[0] + 1.0, 0.0]).unwrap();
        assert!(on > whole, "{on}");
    }

    #[test]
    fn a_ball_on_a_smooth_joint_touches_once_and_at_a_kink_twice() {
        let mut found = ContactQuery::default();
        let (profile, half) = (slope(), 0.5f64.sqrt());
        let foot = [1.0 - half, 1.0 - half];
        profile.query_contacts(&[foot[0] + 0.2 * half, foot[1] + 0.2 * half], 0.3, &mut found);
        assert_eq!(found.len(), 1);
        let mut kink = GroundProfile::starting_at([-1.0, 1.0]);
        kink.line_to([0.0, 0.0]).unwrap();
        kink.line_to([1.0, 1.0]).unwrap();
        found.clear();
        kink.close().unwrap().query_contacts(&[0.0, 0.3], 0.25, &mut found);
        assert_eq!(found.len(), 2);
    }
}
