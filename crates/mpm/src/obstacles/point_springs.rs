//! Contact springs between a point and obstacles.

use crate::obstacles::penalty_law::{
    MAX_OVERLAPS, SurfaceOverlap, friction_impulse, length, minimum_translation,
};
use crate::obstacles::state::{ContactCandidates, ObstacleForces, PenaltyObstacle};
use crate::points::penalty_state::PenaltyState;
use crate::points::pore_contact_state::PoreContactState;

/// Shares of obstacles in the friction on a point, in proportion to their friction bounds. Among infinite bounds they are in proportion to
/// the normal forces.
#[derive(Clone, Copy, Debug, Default)]
struct FrictionShares {
    /// Number of each obstacle and its part.
    obstacle_parts: [(usize, f64); MAX_OVERLAPS],
    count: usize,
    /// Sum of the parts.
    total: f64,
    /// Friction bound, as a stretch of the spring (m); may be infinite.
    max_slip: f64,
}

impl FrictionShares {
    /// Adds an obstacle with a friction bound (m) and a normal overlap (m).
    fn add(&mut self, number: usize, bound: f64, overlap: f64) {
        if bound.is_infinite() && self.max_slip.is_finite() {
            *self = Self { max_slip: f64::INFINITY, ..Self::default() };
        } else if bound.is_finite() && self.max_slip.is_infinite() {
            return;
        }
        if self.count < MAX_OVERLAPS {
            let part = if bound.is_infinite() { overlap } else { bound };
            self.obstacle_parts[self.count] = (number, part);
            self.count += 1;
            self.total += part;
            self.max_slip += bound;
        }
    }

    /// Number and friction share of each obstacle.
    fn obstacle_shares(&self) -> impl Iterator<Item = (usize, f64)> {
        let (whole, equal) = (self.total, 1.0 / self.count as f64);
        let all = &self.obstacle_parts[..self.count];
        all.iter().map(move |(number, part)| (*number, if whole > 0.0 { part / whole } else { equal }))
    }
}

/// Contact springs of a point with candidates from [`detect_contacts`].
#[derive(Clone, Copy, Debug)]
pub struct ObstacleSprings<const D: usize> {
    /// Position of the point (m).
    pub position: [f64; D],
    /// Displacement of the point since its last search (m).
    pub displacement: [f64; D],
    /// Whether the point was within its half width of an obstacle at the last search.
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
        obstacles: &[PenaltyObstacle<D>],
        candidates: &ContactCandidates<D>,
        point: &mut PenaltyState<D>,
        sums: &mut [ObstacleForces],
    ) {
        let k = self.stiffness;
        point.force = [0.0; D];
        if k <= 0.0 {
            point.spring = [0.0; D];
            return;
        }
        let mut translation_shares = [0.0; MAX_OVERLAPS];
        let translation = minimum_translation(candidates.overlaps(), &mut translation_shares);
        let depth = length(&translation);
        let mut friction_shares = FrictionShares::default();
        for (overlap, own) in
            candidates.overlaps().iter().zip(translation_shares).filter(|(_, own)| *own > 0.0)
        {
            let (obstacle, law) = (&obstacles[overlap.obstacle], &overlap.law);
            // Without a normal force infinite friction gives no force.
            let bound = if law.friction() == 0.0 { 0.0 } else { law.friction() * own }
                + law.adhesion() * self.area / k;
            friction_shares.add(overlap.obstacle, bound, own);
            let normal_force = overlap.normal.map(|n| k * own * n);
            (0..D).for_each(|c| point.force[c] += normal_force[c]);
            self.add_reaction(obstacle, &mut sums[overlap.obstacle], &normal_force);
            sums[overlap.obstacle].spring_energy += 0.5 * k * own * overlap.depth;
        }
        let own = self.apply_adhesion(candidates, &mut friction_shares);
        let own = self.apply_bond(obstacles, candidates, point, sums, &mut friction_shares).or(own);
        let normal = if depth > 0.0 { Some(translation.map(|c| c / depth)) } else { own };
        let Some(normal) = normal.filter(|_| friction_shares.count > 0) else {
            point.spring = [0.0; D];
            return;
        };
        let mut moved = [0.0; D];
        for (number, share) in friction_shares.obstacle_shares() {
            let own = self.sliding_displacement(&obstacles[number], &normal, depth);
            (0..D).for_each(|c| moved[c] += share * own[c]);
        }
        let (spring, slip) = friction_impulse(&point.spring, &moved, &normal, friction_shares.max_slip);
        point.spring = spring;
        let friction = spring.map(|s| -k * s);
        (0..D).for_each(|c| point.force[c] += friction[c]);
        let stretch = length(&spring);
        for (number, share) in friction_shares.obstacle_shares() {
            self.add_reaction(&obstacles[number], &mut sums[number], &friction.map(|c| share * c));
            sums[number].spring_energy += share * 0.5 * k * stretch * stretch;
            if slip > 0.0 {
                sums[number].friction += share * k * friction_shares.max_slip * slip;
            }
        }
    }

    /// Adds the friction of an adhesive obstacle from which the point has just separated, if it overlaps none; returns the normal.
    fn apply_adhesion(
        &self,
        candidates: &ContactCandidates<D>,
        friction_shares: &mut FrictionShares,
    ) -> Option<[f64; D]> {
        let contact = candidates.adhesive_contact.as_ref().filter(|_| friction_shares.count == 0)?;
        friction_shares.add(contact.obstacle, contact.law.adhesion() * self.area / self.stiffness, 0.0);
        Some(contact.normal)
    }

    /// Adds the tension and friction of the bonded obstacle; returns its normal.
    fn apply_bond(
        &self,
        obstacles: &[PenaltyObstacle<D>],
        candidates: &ContactCandidates<D>,
        point: &mut PenaltyState<D>,
        sums: &mut [ObstacleForces],
        friction_shares: &mut FrictionShares,
    ) -> Option<[f64; D]> {
        let (number, place, law) = candidates.bonded_contact.as_ref()?;
        let (k, extension) = (self.stiffness, place.distance - point.penalty_distance);
        if extension > 0.0 {
            let tension = place.normal.map(|n| -k * extension * n);
            (0..D).for_each(|c| point.force[c] += tension[c]);
            self.add_reaction(&obstacles[*number], &mut sums[*number], &tension);
            sums[*number].spring_energy += 0.5 * k * extension * extension;
        }
        if law.friction().is_infinite() && friction_shares.max_slip.is_finite() {
            *friction_shares = FrictionShares::default();
            friction_shares.add(*number, f64::INFINITY, 1.0);
        } else if friction_shares.count == 0 {
            friction_shares.add(*number, 0.0, 1.0);
        }
        Some(place.normal)
    }

    /// Sliding displacement of the point along an obstacle since it reached the surface (m); `depth` is the overlap (m).
    fn sliding_displacement(&self, obstacle: &PenaltyObstacle<D>, normal: &[f64; D], depth: f64) -> [f64; D] {
        let obstacle_displacement = obstacle.displacement_since(&self.position);
        let moved: [f64; D] = std::array::from_fn(|c| self.displacement[c] - obstacle_displacement[c]);
        let approach: f64 = -(0..D).map(|c| moved[c] * normal[c]).sum::<f64>();
        let share = if self.was_near || approach <= depth { 1.0 } else { depth / approach };
        moved.map(|c| share * c)
    }

    /// Computes the contact force on the pore fluid of the point and adds it to the force on the point. The flux of the mixture does not
    /// pass the surface: the overlap is that of the point less the seepage through its skeleton. Tension is limited by the `min_pressure`
    /// pressure (Pa) for a bonded point.
    pub fn pore_fluid_contact(
        &self,
        obstacles: &[PenaltyObstacle<D>],
        candidates: &ContactCandidates<D>,
        min_pressure: f64,
        (point, pore): (&mut PenaltyState<D>, &mut PoreContactState<D>),
        sums: &mut [ObstacleForces],
    ) {
        let k = self.stiffness;
        let mut fluid_candidates = ContactCandidates::EMPTY;
        for overlap in candidates.overlaps() {
            let depth = overlap.depth - pore.seepage_along(&overlap.normal);
            if depth > 0.0 {
                fluid_candidates.add(SurfaceOverlap { depth, ..*overlap });
            } else if overlap.law.allows_separation() {
                // After separation a returning point is in contact at once.
                (0..D).for_each(|c| pore.seepage_displacement[c] += depth * overlap.normal[c]);
            }
        }
        pore.force = [0.0; D];
        let mut translation_shares = [0.0; MAX_OVERLAPS];
        minimum_translation(fluid_candidates.overlaps(), &mut translation_shares);
        for (overlap, own) in
            fluid_candidates.overlaps().iter().zip(translation_shares).filter(|(_, own)| *own > 0.0)
        {
            let normal_force = overlap.normal.map(|n| k * own * n);
            self.add_fluid_force(
                &obstacles[overlap.obstacle],
                &normal_force,
                (&mut *point, &mut *pore),
                &mut sums[overlap.obstacle],
            );
            sums[overlap.obstacle].spring_energy += 0.5 * k * own * overlap.depth;
        }
        if let Some((number, place, _)) = &candidates.bonded_contact {
            let overlap = point.penalty_distance - place.distance;
            let depth = overlap - pore.seepage_along(&place.normal);
            if depth < 0.0 || overlap <= 0.0 {
                let tension = (k * depth).max(min_pressure * self.area);
                let tension = place.normal.map(|n| tension * n);
                self.add_fluid_force(
                    &obstacles[*number],
                    &tension,
                    (&mut *point, &mut *pore),
                    &mut sums[*number],
                );
                sums[*number].spring_energy += 0.5 * k * depth * depth;
            }
        }
        // On a single surface the seepage along it has no effect.
        let normal = match (candidates.overlaps(), &candidates.bonded_contact) {
            ([overlap], None) => overlap.normal,
            ([], Some((_, place, _))) => place.normal,
            ([overlap], Some((number, ..))) if overlap.obstacle == *number => overlap.normal,
            _ => return,
        };
        let out = pore.seepage_along(&normal);
        pore.seepage_displacement = normal.map(|n| out * n);
    }

    /// Adds a force (N) on the fluid of the point.
    fn add_fluid_force(
        &self,
        obstacle: &PenaltyObstacle<D>,
        force: &[f64; D],
        (point, pore): (&mut PenaltyState<D>, &mut PoreContactState<D>),
        sums: &mut ObstacleForces,
    ) {
        for c in 0..D {
            point.force[c] += force[c];
            pore.force[c] += force[c];
        }
        self.add_reaction(obstacle, sums, force);
    }

    /// Adds the reaction to a force (N) on the point.
    fn add_reaction(&self, obstacle: &PenaltyObstacle<D>, sums: &mut ObstacleForces, force: &[f64; D]) {
        if obstacle.motion.is_some() {
            let obstacle_displacement = obstacle.displacement_since(&self.position);
            sums.work += (0..D).map(|c| obstacle_displacement[c] * force[c]).sum::<f64>();
        }
        let at = |a: &[f64; D], c: usize| a.get(c).copied().unwrap_or(0.0);
        for c in 0..3 {
            sums.force[c] -= at(force, c);
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            sums.moment[c] -= at(&self.position, a) * at(force, b) - at(&self.position, b) * at(force, a);
        }
    }
}
