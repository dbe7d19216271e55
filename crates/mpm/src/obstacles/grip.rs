//! What the springs of obstacles do to a point that they act on.

use super::law::{MOST, Overlap, length, rub, way_out};
use super::rocks::{Rock, Seen, Sums};
use crate::pressed::Pressed;
use crate::soaked::Soaked;

/// The obstacles that bear the friction of a point, each its share of what all can bear; of those whose friction has no bound, its
/// share of what they are pressed by.
#[derive(Clone, Copy, Debug, Default)]
struct Bears {
    /// Number of each obstacle and its part.
    parts: [(usize, f64); MOST],
    count: usize,
    /// Sum of the parts.
    whole: f64,
    /// What friction bears at most, as a stretch of the spring (m); may be infinite.
    cap: f64,
}

impl Bears {
    /// Adds an obstacle whose friction has this bound (m) and that is pressed by so much (m).
    fn add(&mut self, number: usize, bound: f64, pressed: f64) {
        if bound.is_infinite() && self.cap.is_finite() {
            *self = Self { cap: f64::INFINITY, ..Self::default() };
        } else if bound.is_finite() && self.cap.is_infinite() {
            return;
        }
        if self.count < MOST {
            let part = if bound.is_infinite() { pressed } else { bound };
            self.parts[self.count] = (number, part);
            self.count += 1;
            self.whole += part;
            self.cap += bound;
        }
    }

    /// Number of each obstacle, and its share.
    fn shares(&self) -> impl Iterator<Item = (usize, f64)> {
        let (whole, equal) = (self.whole, 1.0 / self.count as f64);
        let all = &self.parts[..self.count];
        all.iter().map(move |(number, part)| (*number, if whole > 0.0 { part / whole } else { equal }))
    }
}

/// What acts on a point that [`look`] has seen something of.
#[derive(Clone, Copy, Debug)]
pub struct Grip<const D: usize> {
    /// Where it is (m).
    pub place: [f64; D],
    /// How far it has moved since it was last looked at (m).
    pub moved: [f64; D],
    /// Whether it was within its width of an obstacle then.
    pub touched: bool,
    /// Stiffness (N/m) of its springs.
    pub stiffness: f64,
    /// Area that it covers of a surface (m²; m in the plane, per radian in axisymmetry).
    pub area: f64,
}

impl<const D: usize> Grip<D> {
    /// Finds the force on the point, and adds the force on the obstacles to `sums`.
    pub fn act(&self, rocks: &[Rock<D>], seen: &Seen<D>, point: &mut Pressed<D>, sums: &mut [Sums]) {
        let k = self.stiffness;
        point.force = [0.0; D];
        if k <= 0.0 {
            point.spring = [0.0; D];
            return;
        }
        let mut ways = [0.0; MOST];
        let way = way_out(seen.overlaps(), &mut ways);
        let depth = length(&way);
        let mut bears = Bears::default();
        for (overlap, own) in seen.overlaps().iter().zip(ways).filter(|(_, own)| *own > 0.0) {
            let (rock, law) = (&rocks[overlap.rock], &overlap.law);
            // Without a normal force infinite friction bears nothing.
            let bound = if law.friction() == 0.0 { 0.0 } else { law.friction() * own }
                + law.adhesion() * self.area / k;
            bears.add(overlap.rock, bound, own);
            let push = overlap.normal.map(|n| k * own * n);
            (0..D).for_each(|c| point.force[c] += push[c]);
            self.add(rock, &mut sums[overlap.rock], &push);
            sums[overlap.rock].stored += 0.5 * k * own * overlap.depth;
        }
        let own = self.adhere(seen, &mut bears);
        let own = self.hold(rocks, seen, point, sums, &mut bears).or(own);
        let normal = if depth > 0.0 { Some(way.map(|c| c / depth)) } else { own };
        let Some(normal) = normal.filter(|_| bears.count > 0) else {
            point.spring = [0.0; D];
            return;
        };
        let mut moved = [0.0; D];
        for (number, share) in bears.shares() {
            let own = self.rubbed(&rocks[number], &normal, depth);
            (0..D).for_each(|c| moved[c] += share * own[c]);
        }
        let (spring, slip) = rub(&point.spring, &moved, &normal, bears.cap);
        point.spring = spring;
        let drag = spring.map(|s| -k * s);
        (0..D).for_each(|c| point.force[c] += drag[c]);
        let stretch = length(&spring);
        for (number, share) in bears.shares() {
            self.add(&rocks[number], &mut sums[number], &drag.map(|c| share * c));
            sums[number].stored += share * 0.5 * k * stretch * stretch;
            if slip > 0.0 {
                sums[number].friction += share * k * bears.cap * slip;
            }
        }
    }

    /// Lets an obstacle that the point has hardly left rub by its adhesion, where it overlaps none; the normal of that.
    fn adhere(&self, seen: &Seen<D>, bears: &mut Bears) -> Option<[f64; D]> {
        let left = seen.left.as_ref().filter(|_| bears.count == 0)?;
        bears.add(left.rock, left.law.adhesion() * self.area / self.stiffness, 0.0);
        Some(left.normal)
    }

    /// Lets the obstacle that holds the point pull it back and bear friction; the normal of that.
    fn hold(
        &self,
        rocks: &[Rock<D>],
        seen: &Seen<D>,
        point: &mut Pressed<D>,
        sums: &mut [Sums],
        bears: &mut Bears,
    ) -> Option<[f64; D]> {
        let (number, place, law) = seen.held.as_ref()?;
        let (k, pulled) = (self.stiffness, place.distance - point.reach);
        if pulled > 0.0 {
            let pull = place.normal.map(|n| -k * pulled * n);
            (0..D).for_each(|c| point.force[c] += pull[c]);
            self.add(&rocks[*number], &mut sums[*number], &pull);
            sums[*number].stored += 0.5 * k * pulled * pulled;
        }
        if law.friction().is_infinite() && bears.cap.is_finite() {
            *bears = Bears::default();
            bears.add(*number, f64::INFINITY, 1.0);
        } else if bears.count == 0 {
            bears.add(*number, 0.0, 1.0);
        }
        Some(place.normal)
    }

    /// How far the point has moved (m) along an obstacle that it overlaps by `depth` (m), since it reached its surface.
    fn rubbed(&self, rock: &Rock<D>, normal: &[f64; D], depth: f64) -> [f64; D] {
        let way = rock.step_at(&self.place);
        let moved: [f64; D] = std::array::from_fn(|c| self.moved[c] - way[c]);
        let comes: f64 = -(0..D).map(|c| moved[c] * normal[c]).sum::<f64>();
        let share = if self.touched || comes <= depth { 1.0 } else { depth / comes };
        moved.map(|c| share * c)
    }

    /// Finds the force on the pore fluid of the point, whose springs have the stiffness of the grip, and adds it to that on the point.
    /// What moves with the flux of the mixture does not pass the surface: the overlap is that of the point less what has seeped through
    /// its skeleton. It pulls as far as the `least` pressure (Pa) allows where material does not lift off.
    pub fn soak(
        &self,
        rocks: &[Rock<D>],
        seen: &Seen<D>,
        least: f64,
        (point, soaked): (&mut Pressed<D>, &mut Soaked<D>),
        sums: &mut [Sums],
    ) {
        let k = self.stiffness;
        let mut wet = Seen::NOTHING;
        for overlap in seen.overlaps() {
            let depth = overlap.depth - soaked.out(&overlap.normal);
            if depth > 0.0 {
                wet.add(Overlap { depth, ..*overlap });
            } else if overlap.law.lets_go() {
                // It has left: when it comes back it presses at once.
                (0..D).for_each(|c| soaked.seep[c] += depth * overlap.normal[c]);
            }
        }
        soaked.force = [0.0; D];
        let mut ways = [0.0; MOST];
        way_out(wet.overlaps(), &mut ways);
        for (overlap, own) in wet.overlaps().iter().zip(ways).filter(|(_, own)| *own > 0.0) {
            let push = overlap.normal.map(|n| k * own * n);
            self.push_fluid(
                &rocks[overlap.rock],
                &push,
                (&mut *point, &mut *soaked),
                &mut sums[overlap.rock],
            );
            sums[overlap.rock].stored += 0.5 * k * own * overlap.depth;
        }
        if let Some((number, place, _)) = &seen.held {
            let overlap = point.reach - place.distance;
            let depth = overlap - soaked.out(&place.normal);
            if depth < 0.0 || overlap <= 0.0 {
                let pull = (k * depth).max(least * self.area);
                let pull = place.normal.map(|n| pull * n);
                self.push_fluid(&rocks[*number], &pull, (&mut *point, &mut *soaked), &mut sums[*number]);
                sums[*number].stored += 0.5 * k * depth * depth;
            }
        }
        // Along a single surface what has seeped does not matter.
        let normal = match (seen.overlaps(), &seen.held) {
            ([overlap], None) => overlap.normal,
            ([], Some((_, place, _))) => place.normal,
            ([overlap], Some((number, ..))) if overlap.rock == *number => overlap.normal,
            _ => return,
        };
        let out = soaked.out(&normal);
        soaked.seep = normal.map(|n| out * n);
    }

    /// A force (N) on the fluid of the point.
    fn push_fluid(
        &self,
        rock: &Rock<D>,
        force: &[f64; D],
        (point, soaked): (&mut Pressed<D>, &mut Soaked<D>),
        sums: &mut Sums,
    ) {
        for c in 0..D {
            point.force[c] += force[c];
            soaked.force[c] += force[c];
        }
        self.add(rock, sums, force);
    }

    /// The reaction to a force (N) on the point.
    fn add(&self, rock: &Rock<D>, sums: &mut Sums, force: &[f64; D]) {
        if rock.moving.is_some() {
            let way = rock.step_at(&self.place);
            sums.work += (0..D).map(|c| way[c] * force[c]).sum::<f64>();
        }
        let at = |a: &[f64; D], c: usize| a.get(c).copied().unwrap_or(0.0);
        for c in 0..3 {
            sums.force[c] -= at(force, c);
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            sums.moment[c] -= at(&self.place, a) * at(force, b) - at(&self.place, b) * at(force, a);
        }
    }
}
