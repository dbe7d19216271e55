//! The rows of points along sides.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::Region;
use crate::shape::{Place, Side};

/// Share of a spacing that points of rows keep away from others.
const APART: f64 = 0.74;

/// The same of points of one row.
const IN_ROW: f64 = 0.6;

/// Cosine of the least angle between two sides at a corner that the rows of neither end at the other's.
const UPRIGHT: f64 = 0.2;

/// Share by which a side may be nearer than the one whose row a point is of.
const TIE: f64 = 1e-6;

/// Points that keep away from each other, in bins a spacing wide.
pub(super) struct Apart {
    points: Vec<Place>,
    bins: HashMap<[i64; 2], Vec<u32>>,
    edge: f64,
}

impl Apart {
    fn new(edge: f64) -> Self {
        Self { points: Vec::new(), bins: HashMap::new(), edge }
    }

    pub(super) fn into_points(self) -> Vec<Place> {
        self.points
    }

    fn bin(&self, x: Place) -> [i64; 2] {
        x.map(|c| (c / self.edge).floor() as i64)
    }

    /// Whether no point is nearer than `apart` (m), at most the edge of a bin.
    pub(super) fn is_free(&self, x: Place, apart: f64) -> bool {
        self.is_free_but(x, apart, usize::MAX, 0.0)
    }

    /// The same, but nearer than `others` (m) of points from number `since` on.
    fn is_free_but(&self, x: Place, apart: f64, since: usize, others: f64) -> bool {
        let [column, row] = self.bin(x);
        let bins = (0..9).filter_map(|k| self.bins.get(&[column + k / 3 - 1, row + k % 3 - 1]));
        bins.flatten().all(|&j| {
            let (other, j) = (self.points[j as usize], j as usize);
            (x[0] - other[0]).hypot(x[1] - other[1]) >= if j < since { apart } else { others }
        })
    }

    pub(super) fn add(&mut self, x: Place) {
        let bin = self.bin(x);
        self.bins.entry(bin).or_default().push(self.points.len() as u32);
        self.points.push(x);
    }
}

/// Distance between the rows along a side (m), fitted to what lies between it and one that runs along with it.
fn pitch(side: &Side, sides: &[Side], spacing: f64) -> f64 {
    let near = |a: f64, b: f64| (a - b).abs() < 1e-6 * spacing;
    let thickness = |other: &Side| -> Option<f64> {
        match (*side, *other) {
            (
                Side::Arc { centre, radius, sweep, .. },
                Side::Arc { centre: o, radius: other, sweep: turn, .. },
            ) => {
                let inwards = if sweep > 0.0 { radius - other } else { other - radius };
                let same = near(centre[0], o[0]) && near(centre[1], o[1]);
                (same && sweep * turn < 0.0 && inwards > 0.0).then_some(inwards)
            }
            (Side::Line { .. }, Side::Line { from, to }) => {
                let ([x, y], [nx, ny]) = (side.at(0.5), side.left(0.5));
                let depth = |place: Place| (place[0] - x) * nx + (place[1] - y) * ny;
                let level = near(depth(from), depth(to)) && depth(from) > 1e-6 * spacing;
                // Beside each other, and facing.
                let ahead = [x + nx * depth(from), y + ny * depth(from)];
                (level && near(other.distance(ahead), 0.0)).then(|| depth(from))
            }
            _ => None,
        }
    };
    let mut least = sides.iter().filter_map(thickness).fold(f64::INFINITY, f64::min);
    if least.is_infinite() {
        // A disk is filled to its centre.
        match *side {
            Side::Arc { radius, sweep, .. } if sweep > 0.0 => least = radius,
            _ => return spacing,
        }
    }
    least / (least / spacing).round().max(1.0)
}

/// Places of a row along a side at a depth below it (m), about a spacing apart.
fn row(side: &Side, depth: f64, spacing: f64) -> Vec<Place> {
    let fitting = |length: f64| (length / spacing).round().max(1.0);
    let shares = |count: f64| (0..count as usize).map(move |k| (k as f64 + 0.5) / count);
    match *side {
        Side::Line { .. } => {
            let below = |t: f64| {
                let (x, n) = (side.at(t), side.left(t));
                [x[0] + depth * n[0], x[1] + depth * n[1]]
            };
            shares(fitting(side.length())).map(below).collect()
        }
        Side::Arc { centre, radius, start, sweep } => {
            let radius = radius - depth * sweep.signum();
            if radius <= 0.0 {
                return Vec::new();
            }
            let circle = Side::Arc { centre, radius, start, sweep };
            shares(fitting(radius * sweep.abs().min(TAU))).map(|t| circle.at(t)).collect()
        }
    }
}

/// Whether two sides meet upright at a corner of less than half a turn.
fn upright(a: &Side, b: &Side, same: f64) -> bool {
    [(a, b), (b, a)].into_iter().any(|(a, b)| {
        let (x, y, n, m) = (a.at(1.0), b.at(0.0), a.left(1.0), b.left(0.0));
        let touch = (x[0] - y[0]).hypot(x[1] - y[1]) < same;
        touch && (n[0] * m[0] + n[1] * m[1]).abs() < UPRIGHT && n[0] * m[1] - n[1] * m[0] > 0.0
    })
}

/// A side whose rows go on.
struct Going<'a> {
    side: &'a Side,
    pitch: f64,
    /// The sides that its rows end at.
    against: Vec<&'a Side>,
}

/// Rows along the sides: of round ones first, as deep as these are the nearest, then of straight ones.
pub(super) fn along_sides(region: &Region<'_>) -> Apart {
    let spacing = region.spacing;
    let mut points = Apart::new(spacing);
    for round in [true, false] {
        let own = region.sides.iter().filter(|side| matches!(side, Side::Arc { .. }) == round);
        let mut going: Vec<Going<'_>> = own
            .map(|side| {
                let ends = |other: &&Side| *other != side && !upright(side, other, 1e-6 * spacing);
                let pitch = pitch(side, &region.sides, spacing);
                Going { side, pitch, against: region.sides.iter().filter(ends).collect() }
            })
            .collect();
        let mut number = 0.0;
        while !going.is_empty() {
            going.retain(|going| {
                let depth = (number + 0.5) * going.pitch;
                let nearest = |x: &Place| {
                    going.against.iter().all(|other| other.distance(*x) > depth * (1.0 - TIE))
                        && region.shape.contains(x)
                };
                let since = points.points.len();
                let mut any = false;
                for x in row(going.side, depth, spacing).into_iter().filter(nearest) {
                    any = true;
                    if points.is_free_but(x, APART * spacing, since, IN_ROW * spacing) {
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
