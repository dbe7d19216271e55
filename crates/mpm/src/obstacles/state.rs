//! Obstacles on points, with their state and reactions.

use std::sync::Arc;

use colluvium_case::description::ObstacleWall;
use colluvium_case::rigid::{ObstacleContact as Ground, SupportReaction};
use colluvium_case::{MovingObstacle, ObstacleLaw, ObstacleLaws, PlacedObstacle};
use colluvium_points::Surface;
use colluvium_points::surface::{ContactQuery, NearestPoint, RigidTransform, cross};
use serde::{Deserialize, Serialize};

use crate::obstacles::penalty_law::{MAX_OVERLAPS, SurfaceOverlap};
use crate::obstacles::penetration_constraints::{PenetrationConstraint, PenetrationConstraints};
use crate::points::penalty_state::PenaltyState;

/// Search distance of a point from its surface, over its half width.
const SEARCH_RATIO: f64 = 2.0;

/// Distance from a surface over the half width of a point below which the point is in contact.
const CONTACT_TOLERANCE: f64 = 1e-6;

/// Gap over the half width of a point up to which adhesion acts. A sliding body oscillates by less, and would otherwise lose its adhesion
/// half of the time.
const ADHESION_RANGE: f64 = 1e-2;

/// Obstacle with penalty contact on points.
#[derive(Clone, Debug)]
pub struct PenaltyObstacle<const D: usize> {
    /// Name in the case.
    pub name: String,
    /// Surface of the obstacle.
    pub surface: Arc<dyn Surface<D>>,
    /// Contact laws.
    pub laws: ObstacleLaws,
    /// Motion of the obstacle; `None` if it is at rest.
    pub motion: Option<ObstacleMotionState<D>>,
    /// Reaction and energies of the obstacle.
    pub state: ObstacleReaction,
}

/// State of a moving obstacle.
#[derive(Clone, Debug)]
pub struct ObstacleMotionState<const D: usize> {
    /// Obstacle at its current position.
    pub obstacle: MovingObstacle<D>,
    /// Position at the previous step.
    previous_transform: RigidTransform<D>,
}

/// Reaction and energies of an obstacle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleReaction {
    /// Force of the material on the obstacle in the last step (N).
    pub force: [f64; 3],
    /// Moment of that force about the origin (N m).
    pub moment: [f64; 3],
    /// Impulse of the material on the obstacle since the start (N s).
    pub impulse: [f64; 3],
    /// Work of friction since the start (J), not negative.
    pub friction: f64,
    /// Work of the obstacle motion on the material since the start (J).
    pub work: f64,
    /// Energy of its springs at the start of the last step (J).
    pub spring_energy: f64,
    /// Energy removed since the start from points that the penetration limit stops at its surface (J), not negative.
    pub stopping_energy: f64,
}

impl ObstacleReaction {
    /// Adds the reaction of a rigid body in a step of `dt` (s).
    pub fn add_support_reaction(&mut self, reaction: &SupportReaction, dt: f64) {
        let moment = cross(&reaction.position, &reaction.impulse);
        for c in 0..3 {
            self.force[c] += reaction.impulse[c] / dt;
            self.moment[c] += moment[c] / dt;
            self.impulse[c] += reaction.impulse[c];
        }
        self.friction += reaction.friction;
        self.work += reaction.work;
    }

    /// Adds the forces of a group of points in a step of `dt` (s).
    pub fn add_block_forces(&mut self, sums: &ObstacleForces, dt: f64) {
        for c in 0..3 {
            self.force[c] += sums.force[c];
            self.moment[c] += sums.moment[c];
            self.impulse[c] += dt * sums.force[c];
        }
        self.friction += sums.friction;
        self.work += sums.work;
        self.spring_energy += sums.spring_energy;
    }
}

/// Reactions and energies of all obstacles, which change during a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleHistory {
    /// Number of points whose centre has been in an obstacle, over all steps.
    pub penetrations: u64,
    /// Upper bound of the displacement of an obstacle part in the domain (m).
    pub max_obstacle_displacement: f64,
    /// Time of the last obstacle forces (s).
    pub force_time: f64,
}

/// Obstacles of a case with penalty contact on points.
#[derive(Debug)]
pub struct PenaltyObstacles<const D: usize> {
    /// The obstacles.
    pub obstacles: Vec<PenaltyObstacle<D>>,
    /// Workspaces for groups of points.
    pub workspaces: Vec<BlockWorkspace<D>>,
    /// Search distance of a point that has no surface nearby (m).
    pub horizon: f64,
    /// Penetration constraints of the step.
    pub penetration_constraints: PenetrationConstraints<D>,
    /// State that changes during a run.
    pub history: ObstacleHistory,
}

/// Workspace for a group of points.
#[derive(Clone, Debug, Default)]
pub struct BlockWorkspace<const D: usize> {
    /// Result of the surface query, reused for each point.
    pub contacts: ContactQuery<D>,
    /// Penetration constraints of the points of the group.
    pub penetration_constraints: Vec<PenetrationConstraint<D>>,
    /// Interpolation weights of the nodes for these constraints, constraint by constraint.
    pub weights: Vec<(usize, f64)>,
    /// Forces and energies of each obstacle, summed over the group.
    pub sums: Vec<ObstacleForces>,
    /// Points whose centres are in an obstacle.
    pub penetrations: u64,
}

/// Forces and energies of an obstacle from points in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ObstacleForces {
    /// Force on it (N).
    pub force: [f64; 3],
    /// Moment of the force about the origin (N m).
    pub moment: [f64; 3],
    /// Work of friction (J).
    pub friction: f64,
    /// Work of the obstacle motion on points (J).
    pub work: f64,
    /// Energy of the springs (J).
    pub spring_energy: f64,
    /// Energy removed from points that are stopped at the obstacle (J).
    pub penetration_loss: f64,
}

/// Contact candidates of a point.
#[derive(Clone, Copy, Debug)]
pub struct ContactCandidates<const D: usize> {
    overlaps: [SurfaceOverlap<D>; MAX_OVERLAPS],
    count: usize,
    /// Adhesive contact close to the surface without an overlap.
    pub(super) adhesive_contact: Option<SurfaceOverlap<D>>,
    /// Bonded obstacle, with the closest position on its surface and the contact law.
    pub(super) bonded_contact: Option<(usize, NearestPoint<D>, ObstacleLaw)>,
}

impl<const D: usize> ContactCandidates<D> {
    /// Contact candidates of a point without contact.
    pub(super) const EMPTY: Self = {
        let law = ObstacleLaw { wall: ObstacleWall::Smooth, separation: false };
        Self {
            overlaps: [SurfaceOverlap { normal: [0.0; D], depth: 0.0, obstacle: 0, law }; MAX_OVERLAPS],
            count: 0,
            adhesive_contact: None,
            bonded_contact: None,
        }
    };

    /// Adds an overlap, up to [`MAX_OVERLAPS`] of them.
    pub(super) fn add(&mut self, overlap: SurfaceOverlap<D>) {
        if self.count < MAX_OVERLAPS {
            self.overlaps[self.count] = overlap;
            self.count += 1;
        }
    }

    /// Adds the surface positions of an obstacle within the reach of the point (m), and stores an adhesive one slightly outside it.
    fn add_contacts(
        &mut self,
        obstacle: &PenaltyObstacle<D>,
        number: usize,
        places: &[NearestPoint<D>],
        reach: f64,
    ) {
        for place in places {
            let depth = reach - place.distance;
            let law = *obstacle.laws.law_at(&place.position);
            let overlap = SurfaceOverlap { normal: place.normal, depth, obstacle: number, law };
            if depth > 0.0 {
                self.add(overlap);
            } else if law.adhesion() > 0.0
                && depth > -ADHESION_RANGE * reach
                && self.adhesive_contact.is_none()
            {
                self.adhesive_contact = Some(overlap);
            }
        }
    }

    /// Overlaps of the point with obstacles.
    pub(super) fn overlaps(&self) -> &[SurfaceOverlap<D>] {
        &self.overlaps[..self.count]
    }

    /// Whether obstacles act on the point.
    pub fn has_contact(&self) -> bool {
        self.count > 0 || self.bonded_contact.is_some() || self.adhesive_contact.is_some()
    }
}

impl<const D: usize> PenaltyObstacle<D> {
    /// Returns the obstacle at its current position as a support of rigid bodies.
    pub fn rigid_contact(&self) -> Ground<'_, D> {
        let motion = self.motion.as_ref().map(|motion| &motion.obstacle);
        let surface = motion.map_or(&*self.surface, |own| &own.surface);
        Ground { surface, laws: &self.laws, motion }
    }
}

impl<const D: usize> PenaltyObstacles<D> {
    /// Obstacles that act on points, in a domain with given corners (m); `horizon` is the search distance of points (m).
    pub fn new(placed: &[PlacedObstacle<'_, D>], domain: ([f64; D], [f64; D]), horizon: f64) -> Self {
        let penalty_obstacle =
            |PlacedObstacle { obstacle, surface, laws, .. }: &PlacedObstacle<'_, D>| PenaltyObstacle {
                name: obstacle.name.clone(),
                surface: Arc::clone(surface),
                laws: laws.clone(),
                motion: obstacle.motion.as_ref().map(|motion| ObstacleMotionState {
                    obstacle: MovingObstacle::new(motion, surface, domain),
                    previous_transform: motion.transform(0.0),
                }),
                state: ObstacleReaction::default(),
            };
        Self {
            obstacles: placed.iter().map(penalty_obstacle).collect(),
            workspaces: Vec::new(),
            horizon,
            penetration_constraints: PenetrationConstraints::default(),
            history: ObstacleHistory::default(),
        }
    }

    /// Returns the moving obstacles.
    pub fn moving_obstacles(&self) -> impl Iterator<Item = &MovingObstacle<D>> {
        self.obstacles.iter().filter_map(|obstacle| obstacle.motion.as_ref()).map(|moving| &moving.obstacle)
    }

    /// Returns the moving obstacles, to be changed.
    pub fn moving_obstacles_mut(&mut self) -> impl Iterator<Item = &mut MovingObstacle<D>> {
        self.obstacles.iter_mut().filter_map(|own| own.motion.as_mut()).map(|moving| &mut moving.obstacle)
    }

    /// Moves the obstacles to `time` (s), and resets their forces of the step.
    pub fn advance(&mut self, time: f64) {
        let at = std::mem::replace(&mut self.history.force_time, time);
        let mut max_displacement = 0f64;
        for obstacle in &mut self.obstacles {
            (obstacle.state.force, obstacle.state.moment, obstacle.state.spring_energy) =
                ([0.0; 3], [0.0; 3], 0.0);
            let Some(ObstacleMotionState { obstacle: own, previous_transform: before }) =
                &mut obstacle.motion
            else {
                continue;
            };
            *before = own.transform(at);
            own.move_to(time);
            max_displacement = max_displacement.max(own.max_displacement(at, time));
        }
        self.history.max_obstacle_displacement += max_displacement;
    }

    /// Resizes the workspaces to a number of groups of points.
    pub fn resize_workspaces(&mut self, blocks: usize) {
        let workspace = BlockWorkspace {
            sums: vec![ObstacleForces::default(); self.obstacles.len()],
            ..BlockWorkspace::default()
        };
        self.workspaces = vec![workspace; blocks];
    }

    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        // With a few contacts in a block.
        let workspace = size_of::<BlockWorkspace<D>>() + self.obstacles.len() * size_of::<ObstacleForces>();
        self.workspaces.len() * workspace
    }

    /// Initial contact state of a point (m). Its reach is at most the distance from the nearest surface, so that there is no initial force.
    pub fn initial_penalty_state(&self, x: &[f64; D], half_width: f64) -> PenaltyState<D> {
        let distances =
            self.obstacles.iter().filter_map(|obstacle| obstacle.current_surface().gap(x, half_width));
        let nearest = distances.map(|gap| gap.distance).fold(half_width, f64::min);
        PenaltyState { half_width, penalty_distance: nearest.max(0.0), ..PenaltyState::NEW }
    }
}

impl<const D: usize> PenaltyObstacle<D> {
    /// Surface of the obstacle at its current position.
    pub fn current_surface(&self) -> &dyn Surface<D> {
        match &self.motion {
            Some(moving) => &moving.obstacle.surface,
            None => &*self.surface,
        }
    }

    /// Displacement of the obstacle at `x` since the previous step (m).
    pub(super) fn displacement_since(&self, x: &[f64; D]) -> [f64; D] {
        self.motion.as_ref().map_or(
            [0.0; D],
            |ObstacleMotionState { obstacle: own, previous_transform: before }| {
                let previous = own.material_position(x, before);
                std::array::from_fn(|c| x[c] - previous[c])
            },
        )
    }

    /// Displacement of the obstacle at `x` until `time` (m).
    pub fn displacement_until(&self, x: &[f64; D], time: f64) -> [f64; D] {
        self.motion.as_ref().map_or([0.0; D], |ObstacleMotionState { obstacle: own, .. }| {
            let end = own.material_position(x, &own.transform(time));
            std::array::from_fn(|c| end[c] - x[c])
        })
    }
}

/// Whether a surface position precedes another: the closer one, or by the normals at equal distance. The result does not depend on the
/// order of obstacles.
fn is_before<const D: usize>(own: &NearestPoint<D>, other: &NearestPoint<D>) -> bool {
    (own.distance, own.normal) < (other.distance, other.normal)
}

/// Finds the contacts of a point at `x` (m) with the obstacles. Updates reach, free distance and bond of the point.
pub fn detect_contacts<const D: usize>(
    obstacles: &[PenaltyObstacle<D>],
    horizon: f64,
    x: &[f64; D],
    point: &mut PenaltyState<D>,
    workspace: &mut BlockWorkspace<D>,
) -> ContactCandidates<D> {
    let mut candidates = ContactCandidates::EMPTY;
    let radius = SEARCH_RATIO * point.half_width;
    let mut nearest = f64::INFINITY;
    // Of the obstacles without separation: the nearest in contact, and the one bonded so far.
    let (mut touched, mut bonded) = (None, None);
    for (number, obstacle) in obstacles.iter().enumerate() {
        workspace.contacts.clear();
        let surface = obstacle.current_surface();
        surface.query_contacts(x, radius, &mut workspace.contacts);
        let all = workspace.contacts.contacts();
        let own = all.first().copied().or_else(|| surface.gap(x, horizon.max(radius)));
        nearest = nearest.min(own.map_or(horizon.max(radius), |own| own.distance));
        let Some(own) = own.filter(|own| own.distance < radius) else { continue };
        workspace.penetrations += u64::from(own.distance < 0.0);
        let law = *obstacle.laws.law_at(&own.position);
        if law.allows_separation() {
            // The point has moved from a bonded part of the obstacle.
            point.bond = if point.bond == number as u32 + 1 { 0 } else { point.bond };
        } else if own.distance - point.penalty_distance <= CONTACT_TOLERANCE * point.half_width
            && touched.as_ref().is_none_or(|(_, other, _)| is_before(&own, other))
        {
            touched = Some((number, own, law));
        }
        if point.bond == number as u32 + 1 {
            bonded = Some((number, own, law));
        }
        let places = if all.is_empty() { std::slice::from_ref(&own) } else { all };
        candidates.add_contacts(obstacle, number, places, point.penalty_distance);
    }
    if let Some((number, ..)) = touched {
        point.bond = number as u32 + 1;
    }
    candidates.bonded_contact = touched.or(bonded);
    update_reach(point, nearest, &mut candidates);
    candidates
}

/// Updates reach, free distance and bond of a point whose nearest surface is at the distance `nearest` (m).
#[inline]
fn update_reach<const D: usize>(
    point: &mut PenaltyState<D>,
    nearest: f64,
    candidates: &mut ContactCandidates<D>,
) {
    if point.bond == 0 {
        // A point that has moved away gets a larger reach; this causes no force.
        point.penalty_distance = point.half_width.min(point.penalty_distance.max(nearest));
    }
    point.free_distance = nearest - point.half_width;
    // A point whose reach is less than its half width has tension up to that distance again.
    if let Some((_, place, _)) = candidates.bonded_contact
        && place.distance - point.penalty_distance > point.half_width
    {
        (point.bond, candidates.bonded_contact) = (0, None);
    } else if candidates.bonded_contact.is_none() {
        point.bond = 0;
    }
    if candidates.has_contact() {
        point.free_distance = point.free_distance.min(0.0);
    }
}
