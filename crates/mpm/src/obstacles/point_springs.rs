//! Contact springs between a point and obstacles.

use crate::obstacles::penalty_law::{
    MAX_OVERLAPS, SurfaceOverlap, friction_impulse, length, minimum_translation,
};
use crate::obstacles::state::{ContactCandidates, ObstacleForces, PenaltyObstacle};
use crate::points::penalty_state::PenaltyState;
use crate::points::pore_contact_state::PoreContactState;

/// Shares of the obstacles in the friction on a point: each in proportion to its friction bound; where bounds are infinite, in proportion
/// to the normal force.
#[derive(Clone, Copy, Debug, Default)]
struct FrictionShares {
    /// Number of each obstacle and its part.
    parts: [(usize, f64); MAX_OVERLAPS],
    count: usize,
    /// Sum of the parts.
    whole: f64,
    /// Friction bound, as a stretch of the spring (m); may be infinite.
    max_slip: f64,
}

impl FrictionShares {
    /// Adds an obstacle with this friction bound (m) and normal overlap (m).
    fn add(&mut self, number: usize, bound: f64, pressed: f64) {
        if bound.is_infinite() && self.max_slip.is_finite() {
            *self = Self { max_slip: f64::INFINITY, ..Self::default() };
        } else if bound.is_finite() && self.max_slip.is_infinite() {
            return;
        }
        if self.count < MAX_OVERLAPS {
            let part = if bound.is_infinite() { pressed } else { bound };
            self.parts[self.count] = (number, part);
            self.count += 1;
            self.whole += part;
            self.max_slip += bound;
        }
    }

    /// Returns the number of each obstacle and its share.
    fn shares(&self) -> impl Iterator<Item = (usize, f64)> {
        let (whole, equal) = (self.whole, 1.0 / self.count as f64);
        let all = &self.parts[..self.count];
        all.iter().map(move |(number, part)| (*number, if whole > 0.0 { part / whole } else { equal }))
    }
}

/// Contact springs of a point with candidates from [`detect_contacts`].
#[derive(Clone, Copy, Debug)]
pub struct ObstacleSprings<const D: usize> {
    /// Position of the point (m).
    pub place: [f64; D],
    /// Displacement of the point since its last search (m).
    pub displacement: [f64; D],
    /// Whether it was within its width of an obstacle at the last search.
    pub was_near: bool,
    /// Stiffness of the contact springs (N/m).
    pub stiffness: f64,
    /// Contact area of the point (m²; m in the plane, per radian in axisymmetry).
    pub area: f64,
}

impl<const D: usize> ObstacleSprings<D> {
    /// Computes the force on the point, and adds the reaction on the obstacles to `sums`.
    pub fn apply(
        &self,
        rocks: &[PenaltyObstacle<D>],
        seen: &ContactCandidates<D>,
        point: &mut PenaltyState<D>,
        sums: &mut [ObstacleForces],
    ) {
        let k = self.stiffness;
        point.force = [0.0; D];
        if k <= 0.0 {
            point.spring = [0.0; D];
            return;
        }
        let mut ways = [0.0; MAX_OVERLAPS];
        let way = minimum_translation(seen.overlaps(), &mut ways);
        let depth = length(&way);
        let mut bears = FrictionShares::default();
        for (overlap, own) in seen.overlaps().iter().zip(ways).filter(|(_, own)| *own > 0.0) {
            let (rock, law) = (&rocks[overlap.obstacle], &overlap.law);
            // Without a normal force infinite friction gives no force.
            let bound = if law.friction() == 0.0 { 0.0 } else { law.friction() * own }
                + law.adhesion() * self.area / k;
            bears.add(overlap.obstacle, bound, own);
            let push = overlap.normal.map(|n| k * own * n);
            (0..D).for_each(|c| point.force[c] += push[c]);
            self.add_reaction(rock, &mut sums[overlap.obstacle], &push);
            sums[overlap.obstacle].stored += 0.5 * k * own * overlap.depth;
        }
        let own = self.apply_adhesion(seen, &mut bears);
        let own = self.apply_bond(rocks, seen, point, sums, &mut bears).or(own);
        let normal = if depth > 0.0 { Some(way.map(|c| c / depth)) } else { own };
        let Some(normal) = normal.filter(|_| bears.count > 0) else {
            point.spring = [0.0; D];
            return;
        };
        let mut moved = [0.0; D];
        for (number, share) in bears.shares() {
            let own = self.sliding_displacement(&rocks[number], &normal, depth);
            (0..D).for_each(|c| moved[c] += share * own[c]);
        }
        let (spring, slip) = friction_impulse(&point.spring, &moved, &normal, bears.max_slip);
        point.spring = spring;
        let drag = spring.map(|s| -k * s);
        (0..D).for_each(|c| point.force[c] += drag[c]);
        let stretch = length(&spring);
        for (number, share) in bears.shares() {
            self.add_reaction(&rocks[number], &mut sums[number], &drag.map(|c| share * c));
            sums[number].stored += share * 0.5 * k * stretch * stretch;
            if slip > 0.0 {
                sums[number].friction += share * k * bears.max_slip * slip;
            }
        }
    }

    /// Adds friction by the adhesion of an obstacle that the point has just left, where it overlaps none; returns its normal.
    fn apply_adhesion(&self, seen: &ContactCandidates<D>, bears: &mut FrictionShares) -> Option<[f64; D]> {
        let left = seen.adhesive_contact.as_ref().filter(|_| bears.count == 0)?;
        bears.add(left.obstacle, left.law.adhesion() * self.area / self.stiffness, 0.0);
        Some(left.normal)
    }

    /// Adds the tension and friction of the bonded obstacle; returns its normal.
    fn apply_bond(
        &self,
        rocks: &[PenaltyObstacle<D>],
        seen: &ContactCandidates<D>,
        point: &mut PenaltyState<D>,
        sums: &mut [ObstacleForces],
        bears: &mut FrictionShares,
    ) -> Option<[f64; D]> {
        let (number, place, law) = seen.bonded_contact.as_ref()?;
        let (k, pulled) = (self.stiffness, place.distance - point.reach);
        if pulled > 0.0 {
            let pull = place.normal.map(|n| -k * pulled * n);
            (0..D).for_each(|c| point.force[c] += pull[c]);
            self.add_reaction(&rocks[*number], &mut sums[*number], &pull);
            sums[*number].stored += 0.5 * k * pulled * pulled;
        }
        if law.friction().is_infinite() && bears.max_slip.is_finite() {
            *bears = FrictionShares::default();
            bears.add(*number, f64::INFINITY, 1.0);
        } else if bears.count == 0 {
            bears.add(*number, 0.0, 1.0);
        }
        Some(place.normal)
    }

    /// Sliding displacement of the point (m) along an obstacle with the overlap `depth` (m), since it reached its surface.
    fn sliding_displacement(&self, rock: &PenaltyObstacle<D>, normal: &[f64; D], depth: f64) -> [f64; D] {
        let way = rock.displacement_since(&self.place);
        let moved: [f64; D] = std::array::from_fn(|c| self.displacement[c] - way[c]);
        let comes: f64 = -(0..D).map(|c| moved[c] * normal[c]).sum::<f64>();
        let share = if self.was_near || comes <= depth { 1.0 } else { depth / comes };
        moved.map(|c| share * c)
    }

    /// Computes the contact force on the pore fluid of the point, with the stiffness of its contact springs, and adds it to the force on
    /// the point. The flux of the mixture does not pass the surface: the overlap is that of the point less the seepage through its
    /// skeleton. Tension is limited by the `least` pressure (Pa) for a bonded point.
    pub fn pore_fluid_contact(
        &self,
        rocks: &[PenaltyObstacle<D>],
        seen: &ContactCandidates<D>,
        least: f64,
        (point, soaked): (&mut PenaltyState<D>, &mut PoreContactState<D>),
        sums: &mut [ObstacleForces],
    ) {
        let k = self.stiffness;
        let mut wet = ContactCandidates::NOTHING;
        for overlap in seen.overlaps() {
            let depth = overlap.depth - soaked.seepage_along(&overlap.normal);
            if depth > 0.0 {
                wet.add(SurfaceOverlap { depth, ..*overlap });
            } else if overlap.law.allows_separation() {
                // After separation a returning point is in contact at once.
                (0..D).for_each(|c| soaked.seepage_displacement[c] += depth * overlap.normal[c]);
            }
        }
        soaked.force = [0.0; D];
        let mut ways = [0.0; MAX_OVERLAPS];
        minimum_translation(wet.overlaps(), &mut ways);
        for (overlap, own) in wet.overlaps().iter().zip(ways).filter(|(_, own)| *own > 0.0) {
            let push = overlap.normal.map(|n| k * own * n);
            self.add_fluid_force(
                &rocks[overlap.obstacle],
                &push,
                (&mut *point, &mut *soaked),
                &mut sums[overlap.obstacle],
            );
            sums[overlap.obstacle].stored += 0.5 * k * own * overlap.depth;
        }
        if let Some((number, place, _)) = &seen.bonded_contact {
            let overlap = point.reach - place.distance;
            let depth = overlap - soaked.seepage_along(&place.normal);
            if depth < 0.0 || overlap <= 0.0 {
                let pull = (k * depth).max(least * self.area);
                let pull = place.normal.map(|n| pull * n);
                self.add_fluid_force(&rocks[*number], &pull, (&mut *point, &mut *soaked), &mut sums[*number]);
                sums[*number].stored += 0.5 * k * depth * depth;
            }
        }
        // On a single surface the seepage along it has no effect.
        let normal = match (seen.overlaps(), &seen.bonded_contact) {
            ([overlap], None) => overlap.normal,
            ([], Some((_, place, _))) => place.normal,
            ([overlap], Some((number, ..))) if overlap.obstacle == *number => overlap.normal,
            _ => return,
        };
        let out = soaked.seepage_along(&normal);
        soaked.seepage_displacement = normal.map(|n| out * n);
    }

    /// Adds a force (N) on the fluid of the point.
    fn add_fluid_force(
        &self,
        rock: &PenaltyObstacle<D>,
        force: &[f64; D],
        (point, soaked): (&mut PenaltyState<D>, &mut PoreContactState<D>),
        sums: &mut ObstacleForces,
    ) {
        for c in 0..D {
            point.force[c] += force[c];
            soaked.force[c] += force[c];
        }
        self.add_reaction(rock, sums, force);
    }

    /// Adds the reaction to a force (N) on the point.
    fn add_reaction(&self, rock: &PenaltyObstacle<D>, sums: &mut ObstacleForces, force: &[f64; D]) {
        if rock.moving.is_some() {
            let way = rock.displacement_since(&self.place);
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
