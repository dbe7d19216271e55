//! Non-penetration constraints of points, and the nodal impulses that satisfy them (docs/theory/mpm.md, obstacles).

use std::ops::Range;

use crate::obstacles::state::ObstacleForces;

/// Maximum number of iterations over the constraints.
const MAX_ITERATIONS: usize = 200;

/// Position of a node that is not in the list.
const UNLISTED: u32 = u32::MAX;

/// Constraint on a point that would come too close to a surface in the step.
#[derive(Clone, Debug)]
pub struct PenetrationConstraint<const D: usize> {
    /// Range of its entries in the list of nodes and weights.
    pub nodes: Range<usize>,
    /// Position of the point (m).
    pub position: [f64; D],
    /// Unit normal out of the obstacle.
    pub normal: [f64; D],
    /// Least normal velocity that maintains the distance (m/s).
    pub min_normal_velocity: f64,
    /// Tolerance on that velocity (m/s).
    pub velocity_tolerance: f64,
    /// Velocity of the obstacle at the contact (m/s).
    pub obstacle_velocity: [f64; D],
    /// Number of the obstacle.
    pub obstacle: usize,
    /// Coefficient of friction at the contact, which may be infinite.
    pub friction: f64,
    /// Impulse along the normal (N s).
    pub normal_impulse: f64,
    /// Impulse along the surface (N s).
    pub friction_impulse: [f64; D],
}

/// Constraints of a step with the nodes that receive their impulses.
#[derive(Clone, Debug, Default)]
pub struct PenetrationConstraints<const D: usize> {
    /// Constraints of the points.
    pub constraints: Vec<PenetrationConstraint<D>>,
    /// Interpolation weights of the nodes for each point. The index is that of the node in memory, and during the solve that in the lists
    /// below.
    pub weights: Vec<(usize, f64)>,
    /// Numbers of the nodes in memory, ascending.
    pub numbers: Vec<usize>,
    /// Position of each node in memory in that list; [`UNLISTED`] between two searches.
    position_in_list: Vec<u32>,
    /// Velocities of the nodes (m/s).
    pub velocity: Vec<[f64; D]>,
    /// Inverse inertia of the nodes along each axis (1/kg); zero for constrained components.
    pub inverse_inertia: Vec<[f64; D]>,
    /// Changes of the velocities of the nodes (m/s).
    pub velocity_change: Vec<[f64; D]>,
    /// Impulse on each obstacle (N s), its moment, and the energies of contact and friction (J).
    pub sums: Vec<ObstacleForces>,
}

/// Scalar product.
fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|c| a[c] * b[c]).sum()
}

impl<const D: usize> PenetrationConstraints<D> {
    /// Removes all constraints, and resets the sums of the obstacles.
    pub fn clear(&mut self, obstacles: usize) {
        self.constraints.clear();
        self.weights.clear();
        self.sums.clear();
        self.sums.resize(obstacles, ObstacleForces::default());
    }

    /// Appends the constraints of a group of points.
    pub fn append(
        &mut self,
        constraints: &mut Vec<PenetrationConstraint<D>>,
        weights: &mut Vec<(usize, f64)>,
    ) {
        let first = self.weights.len();
        self.weights.append(weights);
        self.constraints.extend(constraints.drain(..).map(|constraint| PenetrationConstraint {
            nodes: constraint.nodes.start + first..constraint.nodes.end + first,
            ..constraint
        }));
    }

    /// Lists the nodes; `of` returns the velocity (m/s) of a node and its inverse inertia (1/kg).
    pub fn list_nodes(&mut self, of: impl Fn(usize) -> ([f64; D], [f64; D])) {
        let Self {
            weights,
            numbers,
            position_in_list,
            velocity,
            inverse_inertia: inverse_inertias,
            velocity_change,
            ..
        } = self;
        numbers.clear();
        let nodes = weights.iter().map(|(number, _)| number + 1).max().unwrap_or(0);
        position_in_list.resize(nodes.max(position_in_list.len()), UNLISTED);
        for (number, _) in &*weights {
            if position_in_list[*number] == UNLISTED {
                position_in_list[*number] = 0;
                numbers.push(*number);
            }
        }
        numbers.sort_unstable();
        numbers.iter().zip(0..).for_each(|(number, position)| position_in_list[*number] = position);
        weights.iter_mut().for_each(|(number, _)| *number = position_in_list[*number] as usize);
        numbers.iter().for_each(|number| position_in_list[*number] = UNLISTED);
        velocity.clear();
        inverse_inertias.clear();
        for number in numbers.iter() {
            let (own, inverse_inertia) = of(*number);
            velocity.push(own);
            inverse_inertias.push(inverse_inertia);
        }
        velocity_change.clear();
        velocity_change.resize(numbers.len(), [0.0; D]);
    }

    /// Applies the smallest normal impulses with which each point has its least normal velocity, and the tangential impulses of Coulomb's
    /// law. The iteration over points ends when all constraints are satisfied.
    pub fn solve(&mut self) {
        let Self {
            constraints: list,
            weights,
            velocity,
            inverse_inertia: inverse_inertias,
            velocity_change,
            sums,
            ..
        } = self;
        for _ in 0..MAX_ITERATIONS {
            let mut settled = true;
            for constraint in list.iter_mut() {
                let nodes = &weights[constraint.nodes.clone()];
                let mut point =
                    ConstrainedPoint { nodes, velocity, inverse_inertia: inverse_inertias, velocity_change };
                settled &= constraint.apply_normal(&mut point, &mut sums[constraint.obstacle]);
            }
            if settled {
                return;
            }
        }
    }
}

/// Constrained point with its nodes.
struct ConstrainedPoint<'a, const D: usize> {
    nodes: &'a [(usize, f64)],
    velocity: &'a mut [[f64; D]],
    inverse_inertia: &'a [[f64; D]],
    velocity_change: &'a mut [[f64; D]],
}

impl<const D: usize> ConstrainedPoint<'_, D> {
    /// Velocity of the point (m/s).
    fn velocity(&self) -> [f64; D] {
        let mut sum = [0.0; D];
        for (node, w) in self.nodes {
            (0..D).for_each(|c| sum[c] += w * self.velocity[*node][c]);
        }
        sum
    }

    /// Inverse inertia of the point along a unit vector (1/kg).
    fn inverse_inertia_along(&self, direction: &[f64; D]) -> f64 {
        let of = |(node, w): &(usize, f64)| {
            w * w * (0..D).map(|c| self.inverse_inertia[*node][c] * direction[c] * direction[c]).sum::<f64>()
        };
        self.nodes.iter().map(of).sum()
    }

    /// Applies an impulse (N s) to the nodes of the point.
    fn add_impulse(&mut self, impulse: &[f64; D]) {
        for (node, w) in self.nodes {
            for c in 0..D {
                let change = w * impulse[c] * self.inverse_inertia[*node][c];
                self.velocity[*node][c] += change;
                self.velocity_change[*node][c] += change;
            }
        }
    }
}

impl<const D: usize> PenetrationConstraint<D> {
    /// Applies the missing normal impulse of a constraint; returns whether it was satisfied within the tolerance.
    fn apply_normal(&mut self, point: &mut ConstrainedPoint<'_, D>, sums: &mut ObstacleForces) -> bool {
        let inverse_inertia = point.inverse_inertia_along(&self.normal);
        // Nodes with constrained components cannot move.
        if inverse_inertia <= 0.0 {
            return true;
        }
        let lacks = self.min_normal_velocity - dot(&point.velocity(), &self.normal);
        let more = (lacks / inverse_inertia).max(-self.normal_impulse);
        if more != 0.0 {
            self.normal_impulse += more;
            let removed = self.apply_impulse(&self.normal.map(|n| more * n), point, sums);
            sums.penetration_loss += removed;
        }
        if self.friction > 0.0 && (self.normal_impulse > 0.0 || self.friction_impulse != [0.0; D]) {
            self.apply_friction(point, sums);
        }
        lacks <= self.velocity_tolerance
    }

    /// Applies the tangential impulse of a constraint, limited by friction.
    fn apply_friction(&mut self, point: &mut ConstrainedPoint<'_, D>, sums: &mut ObstacleForces) {
        let velocity = point.velocity();
        let slides: [f64; D] = std::array::from_fn(|c| velocity[c] - self.obstacle_velocity[c]);
        let out = dot(&slides, &self.normal);
        let slides: [f64; D] = std::array::from_fn(|c| slides[c] - out * self.normal[c]);
        let speed = dot(&slides, &slides).sqrt();
        let bound = if self.normal_impulse > 0.0 { self.friction * self.normal_impulse } else { 0.0 };
        let mut next = self.friction_impulse;
        if speed > 0.0 {
            let along = slides.map(|v| v / speed);
            let inverse_inertia = point.inverse_inertia_along(&along);
            if inverse_inertia <= 0.0 {
                return;
            }
            (0..D).for_each(|c| next[c] -= speed / inverse_inertia * along[c]);
        }
        let full = dot(&next, &next).sqrt();
        if full > bound {
            next = next.map(|c| c * (bound / full));
        }
        let more = std::array::from_fn(|c| next[c] - self.friction_impulse[c]);
        self.friction_impulse = next;
        sums.friction += self.apply_impulse(&more, point, sums);
    }

    /// Applies an impulse (N s) to the point, and its reaction to the obstacle; adds the dissipated energy (J) to the obstacle.
    fn apply_impulse(
        &self,
        impulse: &[f64; D],
        point: &mut ConstrainedPoint<'_, D>,
        sums: &mut ObstacleForces,
    ) -> f64 {
        let before = point.velocity();
        point.add_impulse(impulse);
        let after = point.velocity();
        let slides: [f64; D] =
            std::array::from_fn(|c| 0.5 * (before[c] + after[c]) - self.obstacle_velocity[c]);
        sums.work += dot(impulse, &self.obstacle_velocity);
        let at = |a: &[f64; D], c: usize| a.get(c).copied().unwrap_or(0.0);
        for c in 0..3 {
            sums.force[c] -= at(impulse, c);
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            sums.moment[c] -= at(&self.position, a) * at(impulse, b) - at(&self.position, b) * at(impulse, a);
        }
        -dot(impulse, &slides)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two points over a floor on nodes 0, 1 and 2 of 1, 2 and 4 kg, which fall and slide.
    fn floor_constraints(friction: f64) -> PenetrationConstraints<2> {
        let constraint = |nodes: Range<usize>, smallest: f64| PenetrationConstraint {
            nodes,
            position: [0.0; 2],
            normal: [0.0, 1.0],
            min_normal_velocity: smallest,
            velocity_tolerance: 1e-12,
            obstacle_velocity: [0.0; 2],
            obstacle: 0,
            friction,
            normal_impulse: 0.0,
            friction_impulse: [0.0; 2],
        };
        let mut stops = PenetrationConstraints::default();
        stops.clear(1);
        stops.append(
            &mut vec![constraint(0..2, -0.1), constraint(2..4, 0.0)],
            &mut vec![(10, 0.3), (11, 0.7), (11, 0.6), (14, 0.4)],
        );
        stops.list_nodes(|number| {
            let inverse_inertia = match number {
                10 => 1.0,
                11 => 0.5,
                _ => 0.25,
            };
            ([1.0, -2.0], [inverse_inertia; 2])
        });
        stops
    }

    fn energy(stops: &PenetrationConstraints<2>) -> f64 {
        let of = |(velocity, inverse_inertia): (&[f64; 2], &[f64; 2])| {
            0.5 * dot(velocity, velocity) / inverse_inertia[0]
        };
        stops.velocity.iter().zip(&stops.inverse_inertia).map(of).sum()
    }

    #[test]
    fn points_keep_their_least_velocities_and_the_energy_removed_is_recorded() {
        for friction in [0.0, 0.5, f64::INFINITY] {
            let mut stops = floor_constraints(friction);
            let (before, momentum) = (energy(&stops), 7.0);
            stops.solve();
            for constraint in &stops.constraints {
                let of = |(node, w): &(usize, f64)| w * stops.velocity[*node][1];
                let velocity: f64 = stops.weights[constraint.nodes.clone()].iter().map(of).sum();
                assert!(velocity >= constraint.min_normal_velocity - 1e-11, "{velocity}");
                assert!(constraint.normal_impulse >= 0.0);
                // Without a normal impulse there is no friction, for any coefficient.
                let bound =
                    if constraint.normal_impulse > 0.0 { friction * constraint.normal_impulse } else { 0.0 };
                assert!(
                    constraint.friction_impulse[0].abs() <= bound + 1e-12,
                    "{friction}: {} {bound}",
                    constraint.friction_impulse[0]
                );
                assert_eq!(constraint.friction_impulse[1], 0.0);
            }
            let removed = stops.sums[0].penetration_loss + stops.sums[0].friction;
            assert!((before - energy(&stops) - removed).abs() < 1e-10 * before, "{friction}: {removed}");
            assert!(stops.sums[0].penetration_loss > 0.0 && stops.sums[0].friction >= 0.0);
            let kept: f64 = stops
                .velocity
                .iter()
                .zip(&stops.inverse_inertia)
                .map(|(v, inverse_inertia)| v[0] / inverse_inertia[0])
                .sum();
            assert!((momentum - kept - stops.sums[0].force[0]).abs() < 1e-10, "{kept}");
        }
    }

    #[test]
    fn constrained_nodes_do_not_move_and_separating_points_have_no_impulse() {
        let mut stops = floor_constraints(0.3);
        stops.inverse_inertia[1] = [0.0; 2];
        stops.velocity.fill([0.0, 3.0]);
        stops.solve();
        assert_eq!(stops.velocity_change, [[0.0; 2]; 3]);
        stops.velocity.fill([0.0, -3.0]);
        stops.solve();
        assert_eq!(stops.velocity_change[1], [0.0; 2]);
        assert!(stops.velocity_change[0][1] > 0.0 && stops.velocity_change[2][1] > 0.0);
    }
}
