//! Drop and roll of spheres, one by one until three supports hold each (ballistic deposition; sheet: dem §3.8).
//!
//! A sphere falls, rolls on one sphere down its meridian, or on two, or on one and a side, along the circle of the positions in contact
//! with both, until it meets another support or leaves one. The path follows from the possible direction of descent: that of its weight
//! projected on the motions that the supports allow.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;

use crate::points::vector::{add, cross, difference, dot, norm};
use crate::specimen::{Container, GrainHeap};

/// Largest number of paths of a sphere before it is discarded.
const MAX_PATHS: usize = 1000;
/// Relative tolerance of lengths, and tolerance of angles (rad).
const NEGLIGIBLE: f64 = 1e-9;

/// Largest distance of the centres of a rolling sphere and its next support, over the largest radius: four for the diameter of its path and
/// two for the radii.
const SUPPORT_DISTANCE: f64 = 6.0;

/// Vector in three dimensions.
type Vector3 = [f64; 3];

/// Support of a sphere: a sphere about a centre with the sum of both radii (m), or a plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
enum RollSupport {
    Sphere(Vector3, f64),
    /// Axis, coordinate of the centre in contact (m), and direction away from the plane.
    Plane(usize, f64, f64),
}

impl RollSupport {
    /// Gap between a sphere with centre `x` and the support (m).
    fn gap(&self, x: &Vector3) -> f64 {
        match self {
            Self::Sphere(centre, reach) => norm(&difference(x, centre)) - reach,
            Self::Plane(axis, at, away) => away * (x[*axis] - at),
        }
    }

    /// Direction from the support to the centre of a sphere in contact.
    fn normal(&self, x: &Vector3) -> Vector3 {
        match self {
            Self::Sphere(centre, _) => unit(&difference(x, centre)),
            Self::Plane(axis, _, away) => std::array::from_fn(|c| if c == *axis { *away } else { 0.0 }),
        }
    }
}

/// Unit vector of `v`.
fn unit(v: &Vector3) -> Vector3 {
    let length = norm(v);
    v.map(|c| c / length)
}

/// Path of a sphere from its supports.
enum RollPath {
    /// No motion: the sphere rests.
    Rest,
    /// Vertical fall.
    Fall,
    /// Roll on one or two of the supports, by number, in a direction.
    Roll(Vec<usize>, Vector3),
}

/// Downward path that the supports permit: projection of the weight without a component into them.
fn roll_path(normals: &[Vector3]) -> RollPath {
    let weight = [0.0, 0.0, -1.0];
    let allowed = |d: &Vector3| normals.iter().all(|n| dot(n, d) > -NEGLIGIBLE);
    if allowed(&weight) {
        return RollPath::Fall;
    }
    for (i, n) in normals.iter().enumerate() {
        let force = -dot(&weight, n);
        let mut d = weight;
        add(&mut d, force, n);
        if force > 0.0 && norm(&d) > NEGLIGIBLE && allowed(&d) {
            return RollPath::Roll(vec![i], d);
        }
    }
    for i in 0..normals.len() {
        for j in 0..i {
            let (a, b) = (&normals[i], &normals[j]);
            let along: Vector3 = cross(a, b);
            if norm(&along) < NEGLIGIBLE {
                continue;
            }
            let along = unit(&along);
            let down = dot(&along, &weight);
            let d = along.map(|c| c * down);
            let (both, pair) = (dot(a, b), [dot(a, &weight), dot(b, &weight)]);
            let pressed = pair[0] < both * pair[1] && pair[1] < both * pair[0];
            if pressed && down.abs() > NEGLIGIBLE && allowed(&d) {
                return RollPath::Roll(vec![i, j], d);
            }
        }
    }
    RollPath::Rest
}

/// Circle of a rolling sphere: `centre + radius (from cos φ + to sin φ)`.
struct RollCircle {
    centre: Vector3,
    radius: f64,
    first_axis: Vector3,
    second_axis: Vector3,
}

impl RollCircle {
    /// Circular path through a position in contact with one or two supports, in a given direction; `None` if there is none.
    fn through_contact(supports: &[RollSupport], x: &Vector3, direction: &Vector3) -> Option<Self> {
        let centre = match supports {
            [RollSupport::Sphere(centre, _)] => *centre,
            [RollSupport::Sphere(a, one), RollSupport::Sphere(b, other)] => {
                let between = difference(b, a);
                let square = dot(&between, &between);
                let mut centre = *a;
                add(&mut centre, 0.5 * (1.0 + (one * one - other * other) / square), &between);
                centre
            }
            [RollSupport::Sphere(centre, _), RollSupport::Plane(axis, at, _)]
            | [RollSupport::Plane(axis, at, _), RollSupport::Sphere(centre, _)] => {
                std::array::from_fn(|c| if c == *axis { *at } else { centre[c] })
            }
            _ => return None,
        };
        let first_axis = difference(x, &centre);
        let radius = norm(&first_axis);
        let first_axis = (radius > 0.0).then(|| unit(&first_axis))?;
        let mut to = *direction;
        add(&mut to, -dot(direction, &first_axis), &first_axis);
        (norm(&to) > 0.0).then(|| Self { centre, radius, first_axis, second_axis: unit(&to) })
    }

    /// Point of the circle at an angle (rad) from its first axis (m).
    fn point_at_angle(&self, angle: f64) -> Vector3 {
        let (sin, cos) = angle.sin_cos();
        std::array::from_fn(|c| {
            self.centre[c] + self.radius * (self.first_axis[c] * cos + self.second_axis[c] * sin)
        })
    }

    /// First angle at which `a cos φ + b sin φ + c` becomes negative.
    fn first_negative_angle([a, b, c]: [f64; 3]) -> Option<f64> {
        let size = a.hypot(b);
        if size <= c.abs() {
            return None;
        }
        // a cos φ + b sin φ = size cos(φ - top): it decreases through -c at most half a turn after its top.
        let angle = b.atan2(a) + (-c / size).acos();
        let angle = angle.rem_euclid(2.0 * PI);
        (angle > NEGLIGIBLE && angle < 2.0 * PI - NEGLIGIBLE).then_some(angle)
    }

    /// Angle at which a sphere on the circle first meets a support.
    fn contact_angle(&self, support: &RollSupport) -> Option<f64> {
        Self::first_negative_angle(match support {
            RollSupport::Sphere(other, reach) => {
                let apart = difference(&self.centre, other);
                let both = 2.0 * self.radius;
                let rest = dot(&apart, &apart) + self.radius * self.radius - reach * reach;
                [both * dot(&apart, &self.first_axis), both * dot(&apart, &self.second_axis), rest]
            }
            RollSupport::Plane(axis, at, away) => {
                let distance = away * self.radius;
                [
                    distance * self.first_axis[*axis],
                    distance * self.second_axis[*axis],
                    away * (self.centre[*axis] - at),
                ]
            }
        })
    }

    /// Angle at which the sphere separates from its first support, where the contact force vanishes.
    fn detachment_angle(&self, supports: &[RollSupport]) -> Option<f64> {
        // Normals as constants and factors of cos φ and sin φ.
        let parts = |support: &RollSupport| match support {
            RollSupport::Sphere(centre, reach) => {
                let constant = difference(&self.centre, centre).map(|c| c / reach);
                let share = self.radius / reach;
                [self.first_axis.map(|c| share * c), self.second_axis.map(|c| share * c), constant]
            }
            RollSupport::Plane(..) => [[0.0; 3], [0.0; 3], support.normal(&self.point_at_angle(0.0))],
        };
        let first = parts(supports.first()?);
        // The component of the weight along a normal is minus its last entry.
        let up = first.map(|part| part[2]);
        Self::first_negative_angle(match supports.get(1) {
            None => up,
            Some(second) => {
                let x = self.point_at_angle(0.0);
                let both = dot(&supports[0].normal(&x), &second.normal(&x));
                let other = parts(second).map(|part| part[2]);
                std::array::from_fn(|k| up[k] - both * other[k])
            }
        })
    }
}

/// Spheres at rest, sorted into columns over the floor.
struct RestingSpheres<'a> {
    container: &'a Container<3>,
    spheres: Vec<(Vector3, f64)>,
    columns: Vec<Vec<u32>>,
    counts: [usize; 2],
    max_radius: f64,
}

impl<'a> RestingSpheres<'a> {
    /// Empty set of spheres in a container; `max_radius` is the largest radius (m).
    fn new(container: &'a Container<3>, max_radius: f64) -> Self {
        // As wide as the largest distance of the next support of a rolling sphere, so that all of them are in its column or beside it.
        let counts = [0, 1]
            .map(|axis| (container.width(axis) / (SUPPORT_DISTANCE * max_radius)).floor().max(1.0) as usize);
        Self {
            container,
            spheres: Vec::new(),
            columns: vec![Vec::new(); counts[0] * counts[1]],
            counts,
            max_radius,
        }
    }

    /// Column of a position in plan.
    fn column(&self, x: &Vector3) -> [usize; 2] {
        [0, 1].map(|axis| {
            let share = (x[axis] - self.container.low[axis]) / self.container.width(axis);
            ((share * self.counts[axis] as f64).max(0.0) as usize).min(self.counts[axis] - 1)
        })
    }

    /// Columns along an axis that a sphere rolling in column `own` can reach.
    fn reachable_columns(&self, axis: usize, own: usize) -> Vec<usize> {
        let count = self.counts[axis] as i64;
        let all = if count < 3 { 0..=count - 1 } else { own as i64 - 1..=own as i64 + 1 };
        let round = self.container.periodic[axis];
        all.filter(|k| round || (0..count).contains(k)).map(|k| k.rem_euclid(count) as usize).collect()
    }

    /// Spheres, side walls and floor that a sphere at `x` can meet on its path, without those far below it.
    fn supports(&self, x: &Vector3, radius: f64, from: f64) -> Vec<RollSupport> {
        let own = self.column(x);
        let mut all = Vec::new();
        for j in self.reachable_columns(1, own[1]) {
            for i in self.reachable_columns(0, own[0]) {
                for &k in &self.columns[i + self.counts[0] * j] {
                    let (other, its) = &self.spheres[k as usize];
                    if other[2] >= from {
                        let apart = self.container.separation(other, x);
                        let centre = std::array::from_fn(|c| if c == 2 { other[c] } else { x[c] + apart[c] });
                        all.push(RollSupport::Sphere(centre, radius + its));
                    }
                }
            }
        }
        for axis in 0..2 {
            if !self.container.periodic[axis] {
                all.push(RollSupport::Plane(axis, self.container.low[axis] + radius, 1.0));
                all.push(RollSupport::Plane(axis, self.container.high[axis] - radius, -1.0));
            }
        }
        all.push(RollSupport::Plane(2, self.container.low[2] + radius, 1.0));
        all
    }

    /// Height to which a sphere falls at a position (m).
    fn resting_height(&self, x: &Vector3, radius: f64) -> f64 {
        let mut height = self.container.low[2] + radius;
        for support in self.supports(x, radius, f64::NEG_INFINITY) {
            let RollSupport::Sphere(centre, reach) = support else { continue };
            let apart = (x[0] - centre[0]).hypot(x[1] - centre[1]);
            if apart >= reach * (1.0 - NEGLIGIBLE) {
                continue;
            }
            let contact_height = centre[2] + (reach * reach - apart * apart).sqrt();
            if contact_height > height && contact_height <= x[2] + NEGLIGIBLE * reach {
                height = contact_height;
            }
        }
        height
    }
}

impl GrainHeap<3> for RestingSpheres<'_> {
    fn resting_position(&self, over: Vector3, radius: f64, _: &mut ChaCha8Rng) -> Option<Vector3> {
        let mut x = over;
        x[2] = self.resting_height(&x, radius);
        for _ in 0..MAX_PATHS {
            let near = self.supports(&x, radius, x[2] - SUPPORT_DISTANCE * self.max_radius);
            let touching: Vec<RollSupport> =
                near.iter().filter(|support| support.gap(&x) < NEGLIGIBLE * radius).copied().collect();
            let normals: Vec<Vector3> = touching.iter().map(|support| support.normal(&x)).collect();
            match roll_path(&normals) {
                RollPath::Rest => return Some(x),
                RollPath::Fall => {
                    let height = self.resting_height(&x, radius);
                    if x[2] - height < NEGLIGIBLE * radius {
                        return None;
                    }
                    x[2] = height;
                }
                RollPath::Roll(on, direction) => {
                    let on: Vec<RollSupport> = on.into_iter().map(|k| touching[k]).collect();
                    let circle = RollCircle::through_contact(&on, &x, &direction)?;
                    let others = near.iter().filter(|support| !on.contains(support));
                    let first_contact =
                        others.filter_map(|support| circle.contact_angle(support)).fold(PI, f64::min);
                    let turned: Vec<RollSupport> = on.iter().rev().copied().collect();
                    let ends = [
                        circle.detachment_angle(&on),
                        (on.len() > 1).then(|| circle.detachment_angle(&turned)).flatten(),
                    ];
                    let angle = ends.into_iter().flatten().fold(first_contact, f64::min);
                    if angle <= NEGLIGIBLE {
                        return None;
                    }
                    x = circle.point_at_angle(angle);
                    for axis in 0..2 {
                        x[axis] = self.container.wrapped_coordinate(axis, x[axis]);
                    }
                }
            }
        }
        None
    }

    fn add(&mut self, place: Vector3, radius: f64) {
        let [i, j] = self.column(&place);
        self.columns[i + self.counts[0] * j].push(self.spheres.len() as u32);
        self.spheres.push((place, radius));
    }
}

/// Drops spheres at random positions over a container until it is full. `draw` gives the radius of each sphere (m). Returns positions and
/// radii (m), the lowest first. Each sphere rests on three spheres or side walls with its centre between them, or on the floor.
///
/// # Errors
/// When the container is narrower than six of the largest spheres (`largest`, m), or would hold more than `limit` of them.
pub fn drop_and_roll(
    container: &Container<3>,
    largest: f64,
    limit: usize,
    random: &mut ChaCha8Rng,
    draw: impl FnMut(&mut ChaCha8Rng) -> f64,
) -> Result<Vec<(Vector3, f64)>, String> {
    for axis in 0..2 {
        let width = container.width(axis);
        if width < 2.0 * SUPPORT_DISTANCE * largest {
            let axis = ["x", "y"][axis];
            return Err(format!("is {width} m wide along {axis}, less than six of the largest grains"));
        }
    }
    let mut bed = RestingSpheres::new(container, largest);
    container.drop_grains(&mut bed, limit, random, draw)?;
    Ok(bed.spheres)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    fn drop_and_roll_packing(
        periodic: bool,
        seed: u64,
        [low, span]: [f64; 2],
    ) -> (Container<3>, Vec<(Vector3, f64)>) {
        let container = Container {
            low: [-2.0, 1.0, 3.0],
            high: [6.0, 8.0, 11.0],
            periodic: [periodic, false, false],
            round_wall: None,
        };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let draw = |random: &mut ChaCha8Rng| low + span * random.random::<f64>();
        let placed = drop_and_roll(&container, low + span, 100_000, &mut random, draw).unwrap();
        (container, placed)
    }

    #[test]
    fn dropped_spheres_rest_in_local_minima_of_height() {
        for (periodic, seed, sizes) in
            [(true, 1, [0.4, 0.15]), (false, 2, [0.3, 0.2]), (true, 3, [0.4, 1e-4])]
        {
            let (container, placed) = drop_and_roll_packing(periodic, seed, sizes);
            assert!(placed.len() > 200, "{}", placed.len());
            let mut random = ChaCha8Rng::seed_from_u64(9);
            for (i, (x, radius)) in placed.iter().enumerate() {
                let mut normals = Vec::new();
                for (y, other) in &placed[..i] {
                    let apart = container.separation(x, y);
                    let gap = norm(&apart) - radius - other;
                    assert!(gap > -1e-7, "{i}: {gap}");
                    if gap < 1e-7 {
                        normals.push(unit(&apart));
                    }
                }
                for axis in 0..3 {
                    if container.periodic[axis] {
                        continue;
                    }
                    let gaps =
                        [x[axis] - radius - container.low[axis], container.high[axis] - radius - x[axis]];
                    assert!(gaps[0] > -1e-9 && gaps[1] > -1e-9, "{i}: {gaps:?}");
                    for (gap, away) in gaps.into_iter().zip([1.0, -1.0]) {
                        if gap < 1e-7 && (axis < 2 || away > 0.0) {
                            normals.push(std::array::from_fn(|c| if c == axis { away } else { 0.0 }));
                        }
                    }
                }
                let on_floor = x[2] - radius - container.low[2] < 1e-7;
                assert!(on_floor || normals.len() >= 3, "{i}: {normals:?}");
                for _ in 0..200 {
                    let d: Vector3 = std::array::from_fn(|_| 2.0 * random.random::<f64>() - 1.0);
                    let d = [d[0], d[1], -d[2].abs() - 0.02];
                    assert!(
                        normals.iter().any(|n| dot(n, &d) < 1e-7),
                        "{i}: {normals:?} let it go along {d:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_bed_of_nearly_equal_spheres_has_three_supports_each_and_is_seeded() {
        let container = Container {
            low: [0.0; 3],
            high: [12.0, 12.0, 16.0],
            periodic: [true, true, false],
            round_wall: None,
        };
        let bed = |seed: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            // Equal spheres may have four supports in a lattice.
            let draw = |random: &mut ChaCha8Rng| 0.5 + 1e-3 * random.random::<f64>();
            drop_and_roll(&container, 0.501, 100_000, &mut random, draw).unwrap()
        };
        let placed = bed(5);
        let on_floor = |(x, r): &(Vector3, f64)| x[2] - r - container.low[2] < 1e-9;
        let mut contacts = 0;
        for (i, (x, radius)) in placed.iter().enumerate().filter(|(_, own)| !on_floor(own)) {
            for (y, other) in &placed[..i] {
                let touch = norm(&container.separation(x, y)) < (radius + other) * (1.0 + 1e-8);
                contacts += usize::from(touch);
            }
        }
        let above = placed.iter().filter(|own| !on_floor(own)).count();
        assert_eq!(contacts, 3 * above);
        // Away from floor and surface: 0.582 for equal spheres (Visscher and Bolsterli 1972).
        let (low, high) = (4.0, 12.0);
        let inner = placed.iter().filter(|(x, _)| x[2] > low && x[2] < high).count() as f64;
        let solid = inner * PI / 6.0 * 1.001f64.powi(3) / (144.0 * (high - low));
        assert!((0.565..0.6).contains(&solid), "{solid}");
        assert_eq!(bed(5), placed);
        assert_ne!(bed(6), placed);
    }

    #[test]
    fn narrow_boxes_and_too_many_grains_are_refused() {
        let container =
            Container { low: [0.0; 3], high: [1.0, 1.0, 9.0], periodic: [false; 3], round_wall: None };
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let narrow = drop_and_roll(&container, 0.1, 10, &mut random, |_| 0.1).unwrap_err();
        assert!(narrow.contains("less than six"), "{narrow}");
        let many = drop_and_roll(&container, 0.08, 10, &mut random, |_| 0.08).unwrap_err();
        assert!(many.contains("more than 10"), "{many}");
    }
}
