//! Penetration limit: points that their contact springs do not turn back are stopped before the surface of an obstacle (docs/theory/mpm.md,
//! obstacles).

use colluvium_constitutive::BLOCK_SIZE;
use colluvium_grid::{InterpolatedMotion, NodalState, NodeWalls, PointSlice, Vector4};
use colluvium_points::surface::{NearestPoint, path_enters_solid};
use rayon::prelude::*;

use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::momentum::velocity_fields::VelocityFields;
use crate::obstacles::penetration_constraints::PenetrationConstraint;
use crate::obstacles::state::{BlockWorkspace, PenaltyObstacle, PenaltyObstacles};
use crate::points::bodies::Bodies;
use crate::points::penalty_state::PenaltyState;
use crate::points::point_set::PointColumns;
use crate::points::pore_fluid::SOLID;
use crate::points::vectors::{first_three, square, vector4};

/// Least distance of a point centre from a surface, over the distance at which its contact springs begin to act.
const MIN_DISTANCE_RATIO: f64 = 0.05;

/// Fraction of its distance by which a stopped point may still approach a surface in a step.
const DISTANCE_TOLERANCE: f64 = 1e-3;

/// Largest displacement of a point in a step (cells); a larger one is an error.
const MAX_MOVE: f64 = 0.5;

/// Depth of the search for solid under a face, over the least distance of a centre.
const SEARCH_DEPTH_RATIO: f64 = 0.1;

/// Maximum number of searches for points that come too close, because stopping a point can move another.
const MAX_SEARCHES: usize = 4;

/// Number of groups of points in a parallel task.
const GRAIN: usize = 4;

/// Input of the penetration limit.
pub struct PenetrationLimit<'a, const D: usize> {
    /// Clock of the step.
    pub clock: &'a Clock,
    /// Background grid.
    pub background: &'a BackgroundGrid<D>,
    /// Points of all bodies.
    pub bodies: &'a Bodies<D>,
    /// Walls and obstacles on the nodes.
    pub walls: &'a NodeWalls,
    /// Whether the velocities are those that move the points; then friction acts and reactions are recorded. Otherwise points only move
    /// with them.
    pub is_final: bool,
}

/// Limits the penetration by the solved velocities and accelerations of the nodes.
pub fn limit_solved<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    solved: &mut [NodalState],
    (walls, obstacles): (&NodeWalls, &mut Option<Box<PenaltyObstacles<D>>>),
) {
    let limit = PenetrationLimit { clock, background, bodies, walls, is_final: true };
    limit.limit_penetration(
        obstacles,
        solved,
        |_, node| node.momentum_and_mass,
        |node, change| node.change_velocity(change, clock.dt),
    );
}

/// Limits the penetration by the re-mapped velocities of the nodes, which move the points.
pub fn limit_remapped<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    (walls, obstacles): (&NodeWalls, &mut Option<Box<PenaltyObstacles<D>>>),
) {
    let VelocityFields { nodal_states, remapped_velocities, .. } = nodes;
    let limit = PenetrationLimit { clock, background, bodies, walls, is_final: false };
    let of = |number: usize, own: &Vector4| with_mass(*own, nodal_states[number].momentum_and_mass);
    limit.limit_penetration(obstacles, remapped_velocities, of, |node, change| *node += change);
}

/// Values of a node that contain the velocity of the points of an obstacle problem.
pub trait NodeVelocity<const D: usize>: Sync + Sized {
    /// Velocity of the grid at the first of the points (m/s); the first node is that of their velocity field.
    fn at_point(background: &BackgroundGrid<D>, points: &PointSlice<'_, D>, nodes: &[Self]) -> Vector4;
}

impl<const D: usize> NodeVelocity<D> for NodalState {
    fn at_point(background: &BackgroundGrid<D>, points: &PointSlice<'_, D>, nodes: &[Self]) -> Vector4 {
        background.transfers.momentum_at(&background.grid_view(), points, nodes)
    }
}

impl<const D: usize> NodeVelocity<D> for Vector4 {
    fn at_point(background: &BackgroundGrid<D>, points: &PointSlice<'_, D>, nodes: &[Self]) -> Vector4 {
        background.transfers.value_at(&background.grid_view(), points, nodes)
    }
}

impl<const D: usize> NodeVelocity<D> for [NodalState; 2] {
    fn at_point(background: &BackgroundGrid<D>, points: &PointSlice<'_, D>, nodes: &[Self]) -> Vector4 {
        let mut read = [[InterpolatedMotion::ZERO; 2]];
        background.transfers.g2p_phase_motions(&background.grid_view(), points, nodes, &mut read);
        read[0][SOLID].velocity
    }
}

impl<const D: usize> NodeVelocity<D> for [Vector4; 2] {
    fn at_point(background: &BackgroundGrid<D>, points: &PointSlice<'_, D>, nodes: &[Self]) -> Vector4 {
        let mut read = [[InterpolatedMotion::ZERO; 2]];
        background.transfers.g2p_phase_velocities(&background.grid_view(), points, nodes, &mut read);
        read[0][SOLID].velocity
    }
}

/// Returns a velocity with the mass in the fourth lane of another vector.
pub fn with_mass(velocity: Vector4, other: Vector4) -> Vector4 {
    let ([x, y, z, _], [.., mass]) = (velocity.to_array(), other.to_array());
    Vector4::new([x, y, z, mass])
}

impl<const D: usize> PenetrationLimit<'_, D> {
    /// Changes nodal velocities so that points do not reach obstacle surfaces. `of` returns the velocity of a node with its mass as fourth
    /// component, and `add` adds to it (m/s).
    pub fn limit_penetration<T: NodeVelocity<D>>(
        &self,
        obstacles: &mut Option<Box<PenaltyObstacles<D>>>,
        nodes: &mut [T],
        of: impl Fn(usize, &T) -> Vector4,
        add: impl Fn(&mut T, Vector4),
    ) {
        let Some(obstacles) = obstacles else { return };
        for _ in 0..MAX_SEARCHES {
            if !self.find_constraints(obstacles, nodes) {
                return;
            }
            let constraints = &mut obstacles.penetration_constraints;
            constraints
                .list_nodes(|number| self.velocity_and_inverse_inertia(number, of(number, &nodes[number])));
            constraints.solve();
            for (number, change) in constraints.numbers.iter().zip(&constraints.velocity_change) {
                self.each_image(*number, |image| add(&mut nodes[image], vector4(change, 0.0)));
            }
            if self.is_final {
                self.record_reactions(obstacles);
            }
        }
    }

    /// Finds the points that come too close to a surface; returns whether there are any.
    fn find_constraints<T: NodeVelocity<D>>(&self, obstacles: &mut PenaltyObstacles<D>, nodes: &[T]) -> bool {
        let PenaltyObstacles {
            obstacles,
            workspaces,
            horizon,
            history,
            penetration_constraints: constraints,
        } = obstacles;
        constraints.clear(obstacles.len());
        let motions = obstacles.iter().filter_map(|obstacle| obstacle.motion.as_ref());
        let (from, to) = (self.clock.time, self.clock.time + self.clock.dt);
        let step_displacement =
            motions.map(|moving| moving.obstacle.max_displacement(from, to)).fold(0.0, f64::max);
        let field_nodes = self.background.layout.len();
        for set in self.bodies.sets.iter().filter(|set| set.rigid.is_none()) {
            let PointColumns { obstacle_contact, origin, .. } = &set.points;
            let input = PenetrationInput {
                limit: self,
                points: set.point_slice(),
                origin,
                first_node: set.field * field_nodes,
                horizon: *horizon,
                max_obstacle_displacement: history.max_obstacle_displacement,
                step_displacement,
            };
            let blocks = obstacle_contact.par_chunks(BLOCK_SIZE).zip(&mut *workspaces).enumerate();
            blocks.with_min_len(GRAIN).for_each(|(block, (points, workspace))| {
                input.block(obstacles, block * BLOCK_SIZE, points, &nodes[input.first_node..], workspace);
            });
            for workspace in &mut workspaces[..obstacle_contact.len().div_ceil(BLOCK_SIZE)] {
                constraints.append(&mut workspace.penetration_constraints, &mut workspace.weights);
            }
        }
        !constraints.constraints.is_empty()
    }

    /// Velocity (m/s) of a node, and its inverse inertia along each axis (1/kg).
    fn velocity_and_inverse_inertia(&self, number: usize, motion: Vector4) -> ([f64; D], [f64; D]) {
        let (velocity, [.., mass]) = (first_three(motion), motion.to_array());
        let constrained = self.walls.constrained_components(&self.node_index(number), &velocity);
        let inverse_inertia = if mass > 0.0 { 1.0 / (mass * self.clock.options.mass_scaling) } else { 0.0 };
        let free = std::array::from_fn(|c| if constrained[c] { 0.0 } else { inverse_inertia });
        (std::array::from_fn(|c| velocity[c]), free)
    }

    /// Index of a node along the axes.
    fn node_index(&self, number: usize) -> [usize; 3] {
        let layout = &self.background.layout;
        let (number, row) = (number % layout.len(), layout.strides()[0]);
        layout.axis_indices(number / row, number % row)
    }

    /// Calls `act` for a node and its images in a periodic domain.
    fn each_image(&self, number: usize, mut act: impl FnMut(usize)) {
        let BackgroundGrid { layout, periodic, .. } = self.background;
        if *periodic == [false; D] {
            act(number);
            return;
        }
        let (own, strides) = (self.node_index(number), layout.strides());
        let at = |index: &[usize; 3]| (0..D).map(|c| index[c] * strides[c]).sum::<usize>();
        for image in layout.periodic_images(own) {
            act(number + at(&image) - at(&own));
        }
    }

    /// First of the images of a node in a periodic domain.
    fn first_of(&self, number: usize) -> usize {
        let mut first = number;
        if self.background.periodic != [false; D] {
            self.each_image(number, |image| first = first.min(image));
        }
        first
    }

    /// Adds the impulses of the step to the reactions of the obstacles.
    fn record_reactions(&self, obstacles: &mut PenaltyObstacles<D>) {
        let PenaltyObstacles { obstacles, penetration_constraints: constraints, .. } = obstacles;
        for (obstacle, sums) in obstacles.iter_mut().zip(&constraints.sums) {
            for c in 0..3 {
                obstacle.state.force[c] += sums.force[c] / self.clock.dt;
                obstacle.state.moment[c] += sums.moment[c] / self.clock.dt;
                obstacle.state.impulse[c] += sums.force[c];
            }
            obstacle.state.friction += sums.friction;
            obstacle.state.work += sums.work;
            obstacle.state.stopping_energy += sums.penetration_loss;
        }
    }
}

/// Data for the search that all points of a set have in common.
struct PenetrationInput<'a, const D: usize> {
    limit: &'a PenetrationLimit<'a, D>,
    points: PointSlice<'a, D>,
    origin: &'a [[f64; D]],
    first_node: usize,
    horizon: f64,
    /// Largest displacement of an obstacle so far (m).
    max_obstacle_displacement: f64,
    /// Largest displacement of an obstacle in the step (m).
    step_displacement: f64,
}

impl<const D: usize> PenetrationInput<'_, D> {
    /// Finds the constraints of a group of points, from index `first` on.
    fn block<T: NodeVelocity<D>>(
        &self,
        obstacles: &[PenaltyObstacle<D>],
        first: usize,
        points: &[PenaltyState<D>],
        nodes: &[T],
        workspace: &mut BlockWorkspace<D>,
    ) {
        workspace.penetration_constraints.clear();
        workspace.weights.clear();
        let background = self.limit.background;
        let view = background.grid_view();
        for (k, point) in points.iter().enumerate() {
            let p = first + k;
            let x = &self.points.position[p];
            let displacement: [f64; D] =
                std::array::from_fn(|c| x[c] - self.origin[p][c] - point.last_search_displacement[c]);
            // A point bonded to an obstacle may be nearer than its reach.
            let min_distance = if point.bond == 0 {
                point.free_distance + point.half_width
                    - square(&displacement).sqrt()
                    - (self.max_obstacle_displacement - point.obstacle_displacement)
            } else {
                0.0
            };
            let max_travel = MAX_MOVE * self.points.domain.spacing(p, &view) + self.step_displacement;
            if min_distance > max_travel + MIN_DISTANCE_RATIO * point.penalty_distance {
                continue;
            }
            let (own, found) = (self.points.range(p..p + 1), workspace.penetration_constraints.len());
            let velocity = T::at_point(background, &own, nodes).to_array();
            let velocity = std::array::from_fn(|c| velocity[c]);
            let candidate = PenetrationCandidate { x, velocity, min_distance, point };
            candidate.find_constraints(obstacles, self.limit, self.horizon, workspace);
            let BlockWorkspace { penetration_constraints: constraints, weights, .. } = workspace;
            if constraints.len() > found {
                let start = weights.len();
                background.transfers.for_each_weight(&view, &own, &mut |_, node, w| {
                    weights.push((self.limit.first_of(self.first_node + node), w));
                });
                constraints[found..].iter_mut().for_each(|own| own.nodes = start..weights.len());
            }
        }
    }
}

/// Point that may come too close to a surface.
struct PenetrationCandidate<'a, const D: usize> {
    x: &'a [f64; D],
    /// Velocity of the point from the grid (m/s).
    velocity: [f64; D],
    /// Least distance from any surface (m).
    min_distance: f64,
    point: &'a PenaltyState<D>,
}

impl<const D: usize> PenetrationCandidate<'_, D> {
    /// Constraint of the point along a normal, still without its nodes, motion of the obstacle and friction.
    fn constraint(&self, normal: [f64; D]) -> PenetrationConstraint<D> {
        PenetrationConstraint {
            nodes: 0..0,
            position: *self.x,
            normal,
            min_normal_velocity: 0.0,
            velocity_tolerance: 0.0,
            obstacle_velocity: [0.0; D],
            obstacle: 0,
            friction: 0.0,
            normal_impulse: 0.0,
            friction_impulse: [0.0; D],
        }
    }

    /// Finds the surface positions to which the point comes too close.
    fn find_constraints(
        &self,
        obstacles: &[PenaltyObstacle<D>],
        limit: &PenetrationLimit<'_, D>,
        horizon: f64,
        workspace: &mut BlockWorkspace<D>,
    ) {
        let PenetrationLimit { clock, is_final, .. } = limit;
        let dt = clock.dt;
        let min_distance = MIN_DISTANCE_RATIO * self.point.penalty_distance;
        for (number, obstacle) in obstacles.iter().enumerate() {
            let obstacle_velocity = obstacle.displacement_until(self.x, clock.time + dt).map(|u| u / dt);
            let relative_displacement: [f64; D] =
                std::array::from_fn(|c| dt * (self.velocity[c] - obstacle_velocity[c]));
            let travel = square(&relative_displacement).sqrt();
            if self.min_distance > min_distance + travel {
                continue;
            }
            let surface = obstacle.current_surface();
            let Some(now) = surface.gap(self.x, horizon.max(min_distance + travel)) else { continue };
            if now.distance > min_distance + travel {
                continue;
            }
            let allowed_distance = now.distance.min(min_distance);
            let slack = DISTANCE_TOLERANCE * allowed_distance.abs() + f64::EPSILON * self.point.half_width;
            let to: [f64; D] = std::array::from_fn(|c| self.x[c] + relative_displacement[c]);
            workspace.contacts.clear();
            surface.query_contacts(&to, min_distance, &mut workspace.contacts);
            let inside = if workspace.contacts.is_empty() {
                surface.gap(&to, horizon.max(min_distance + travel))
            } else {
                None
            };
            let through = path_enters_solid(
                surface,
                self.x,
                &relative_displacement,
                &now,
                SEARCH_DEPTH_RATIO * min_distance,
            );
            // Behind an obstacle that the point has passed through, the nearest surface is on the other side.
            let faces = |place: &&NearestPoint<D>| {
                through.is_none() || (0..D).map(|c| place.normal[c] * now.normal[c]).sum::<f64>() > 0.0
            };
            let places =
                workspace.contacts.contacts().iter().chain(inside.as_ref()).filter(faces).chain(&through);
            for place in places.filter(|place| place.distance < allowed_distance - slack) {
                let along: f64 = (0..D).map(|c| self.velocity[c] * place.normal[c]).sum();
                workspace.penetration_constraints.push(PenetrationConstraint {
                    min_normal_velocity: along + (allowed_distance - place.distance) / dt,
                    velocity_tolerance: 0.5 * slack / dt,
                    obstacle_velocity,
                    obstacle: number,
                    friction: if *is_final { obstacle.laws.law_at(&place.position).friction() } else { 0.0 },
                    ..self.constraint(place.normal)
                });
            }
        }
    }
}
