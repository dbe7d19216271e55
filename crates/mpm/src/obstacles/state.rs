//! Obstacles that act on points, and what they have borne.

use std::sync::Arc;

use colluvium_case::description::ObstacleWall;
use colluvium_case::rigid::{ObstacleContact as Ground, SupportReaction};
use colluvium_case::{MovingObstacle, ObstacleLaw, ObstacleLaws, PlacedObstacle};
use colluvium_points::Surface;
use colluvium_points::surface::{ContactQuery, NearestPoint, RigidTransform, cross};
use serde::{Deserialize, Serialize};

use crate::obstacles::penalty_law::{MAX_OVERLAPS, SurfaceOverlap};
use crate::obstacles::penalty_state::PenaltyState;
use crate::obstacles::penetration_constraints::{PenetrationConstraint, PenetrationConstraints};

/// How far from its surface a point looks for the next one, over its half width.
const SEARCH_RATIO: f64 = 2.0;

/// Distance from a surface over the half width of a point within which it counts as touching.
const CONTACT_TOLERANCE: f64 = 1e-6;

/// Gap over the half width of a point up to which an obstacle with adhesion still rubs on it: a body that slides trembles by less, and
/// would be without adhesion half of the time.
const ADHESION_RANGE: f64 = 1e-2;

/// An obstacle.
#[derive(Clone, Debug)]
pub struct PenaltyObstacle<const D: usize> {
    /// Name in the case.
    pub name: String,
    /// Its surface.
    pub surface: Arc<dyn Surface<D>>,
    /// How it acts.
    pub laws: ObstacleLaws,
    /// Its motion; `None` at rest.
    pub moving: Option<ObstacleMotionState<D>>,
    /// What it has borne.
    pub state: ObstacleReaction,
}

/// An obstacle on its way.
#[derive(Clone, Debug)]
pub struct ObstacleMotionState<const D: usize> {
    /// Where it is.
    pub obstacle: MovingObstacle<D>,
    /// Where it was in the step before.
    previous_transform: RigidTransform<D>,
}

/// What an obstacle has borne.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleReaction {
    /// Force of the material on it in the last step (N).
    pub force: [f64; 3],
    /// Moment of that force about the origin (N m).
    pub moment: [f64; 3],
    /// Impulse of the material on it since the start (N s).
    pub impulse: [f64; 3],
    /// Work of friction since the start (J), not negative.
    pub friction: f64,
    /// Work of its motion on the material since the start (J).
    pub work: f64,
    /// Energy of its springs at the start of the last step (J).
    pub spring_energy: f64,
    /// Energy taken since the start from points that were stopped before its surface (J), not negative.
    pub stopping_energy: f64,
}

impl ObstacleReaction {
    /// Takes what a rigid body gives in a step of `dt` (s).
    pub fn add_support_reaction(&mut self, stood: &SupportReaction, dt: f64) {
        let moment = cross(&stood.place, &stood.impulse);
        for c in 0..3 {
            self.force[c] += stood.impulse[c] / dt;
            self.moment[c] += moment[c] / dt;
            self.impulse[c] += stood.impulse[c];
        }
        self.friction += stood.friction;
        self.work += stood.work;
    }
}

/// What changes of all obstacles in the course of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleHistory {
    /// Number of points whose centre has been in an obstacle, over all steps.
    pub penetrations: u64,
    /// How far a place of an obstacle in the domain can have come, at most (m).
    pub max_obstacle_displacement: f64,
    /// When obstacles last acted (s).
    pub at: f64,
}

/// The obstacles of a case whose bodies press on them with their points.
#[derive(Debug)]
pub struct PenaltyObstacles<const D: usize> {
    /// The obstacles.
    pub obstacles: Vec<PenaltyObstacle<D>>,
    /// Room for blocks of points.
    pub workspaces: Vec<BlockWorkspace<D>>,
    /// How far a point looks around where it finds none near (m).
    pub horizon: f64,
    /// Room for points that are stopped before a surface.
    pub penetration_constraints: PenetrationConstraints<D>,
    /// What changes.
    pub history: ObstacleHistory,
}

/// What a block of points finds and adds up.
#[derive(Clone, Debug, Default)]
pub struct BlockWorkspace<const D: usize> {
    pub found: ContactQuery<D>,
    /// Points that come too near to a surface.
    pub penetration_constraints: Vec<PenetrationConstraint<D>>,
    /// Nodes of these and weights, one point after another.
    pub weights: Vec<(usize, f64)>,
    /// Of each obstacle.
    pub sums: Vec<ObstacleForces>,
    /// Points whose centres are in an obstacle.
    pub penetrations: u64,
}

/// What an obstacle gets from points in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ObstacleForces {
    /// Force on it (N).
    pub force: [f64; 3],
    /// Moment of it about the origin (N m).
    pub moment: [f64; 3],
    /// Work of friction (J).
    pub friction: f64,
    /// Work of its motion on points (J).
    pub work: f64,
    /// Energy of the springs (J).
    pub stored: f64,
    /// Energy taken from points that are stopped before it (J).
    pub stopped: f64,
}

/// What a point sees of the obstacles.
#[derive(Clone, Copy, Debug)]
pub struct ContactCandidates<const D: usize> {
    overlaps: [SurfaceOverlap<D>; MAX_OVERLAPS],
    count: usize,
    /// A place with adhesion that it does not overlap, but has hardly left.
    pub(super) adhesive_contact: Option<SurfaceOverlap<D>>,
    /// The obstacle that holds it, with the nearest place of its surface and its law there.
    pub(super) bonded_contact: Option<(usize, NearestPoint<D>, ObstacleLaw)>,
}

impl<const D: usize> ContactCandidates<D> {
    pub(super) const NOTHING: Self = {
        let law = ObstacleLaw { wall: ObstacleWall::Smooth, separation: false };
        Self {
            overlaps: [SurfaceOverlap { normal: [0.0; D], depth: 0.0, obstacle: 0, law }; MAX_OVERLAPS],
            count: 0,
            adhesive_contact: None,
            bonded_contact: None,
        }
    };

    pub(super) fn add(&mut self, overlap: SurfaceOverlap<D>) {
        if self.count < MAX_OVERLAPS {
            self.overlaps[self.count] = overlap;
            self.count += 1;
        }
    }

    /// Adds those places of an obstacle that are nearer than the point reaches (m), and notes one with adhesion just beyond.
    fn add_contacts(
        &mut self,
        rock: &PenaltyObstacle<D>,
        number: usize,
        places: &[NearestPoint<D>],
        reach: f64,
    ) {
        for place in places {
            let depth = reach - place.distance;
            let law = *rock.laws.at(&place.position);
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

    pub(super) fn overlaps(&self) -> &[SurfaceOverlap<D>] {
        &self.overlaps[..self.count]
    }

    /// Whether obstacles act on the point.
    pub fn acts(&self) -> bool {
        self.count > 0 || self.bonded_contact.is_some() || self.adhesive_contact.is_some()
    }
}

impl<const D: usize> PenaltyObstacle<D> {
    /// As what rigid bodies stand on, where it is.
    pub fn rigid_contact(&self) -> Ground<'_, D> {
        let moving = self.moving.as_ref().map(|moving| &moving.obstacle);
        let surface = moving.map_or(&*self.surface, |own| &own.placed);
        Ground { surface, laws: &self.laws, moving }
    }
}

impl<const D: usize> PenaltyObstacles<D> {
    /// The obstacles of a case in a domain with these corners (m); `horizon` (m) is how far points look around.
    pub fn new(standing: &[PlacedObstacle<'_, D>], domain: ([f64; D], [f64; D]), horizon: f64) -> Self {
        let rock = |PlacedObstacle { obstacle, surface, laws, .. }: &PlacedObstacle<'_, D>| PenaltyObstacle {
            name: obstacle.name.clone(),
            surface: Arc::clone(surface),
            laws: laws.clone(),
            moving: obstacle.motion.as_ref().map(|motion| ObstacleMotionState {
                obstacle: MovingObstacle::new(motion, surface, domain),
                previous_transform: motion.transform(0.0),
            }),
            state: ObstacleReaction::default(),
        };
        Self {
            obstacles: standing.iter().map(rock).collect(),
            workspaces: Vec::new(),
            horizon,
            penetration_constraints: PenetrationConstraints::default(),
            history: ObstacleHistory::default(),
        }
    }

    /// Those on their way.
    pub fn moving(&self) -> impl Iterator<Item = &MovingObstacle<D>> {
        self.obstacles.iter().filter_map(|rock| rock.moving.as_ref()).map(|moving| &moving.obstacle)
    }

    /// Brings the obstacles to where they are at `time` (s); what they bear in the step is counted anew.
    pub fn advance(&mut self, time: f64) {
        let at = std::mem::replace(&mut self.history.at, time);
        let mut swept = 0f64;
        for rock in &mut self.obstacles {
            (rock.state.force, rock.state.moment, rock.state.spring_energy) = ([0.0; 3], [0.0; 3], 0.0);
            let Some(ObstacleMotionState { obstacle: own, previous_transform: before }) = &mut rock.moving
            else {
                continue;
            };
            *before = own.motion.transform(at);
            own.move_to(time);
            swept = swept.max(own.max_displacement(at, time));
        }
        self.history.max_obstacle_displacement += swept;
    }

    /// Makes room for so many blocks of points.
    pub fn resize_workspaces(&mut self, blocks: usize) {
        let room = BlockWorkspace {
            sums: vec![ObstacleForces::default(); self.obstacles.len()],
            ..BlockWorkspace::default()
        };
        self.workspaces = vec![room; blocks];
    }

    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        // Of the places that a block finds a few.
        let room = size_of::<BlockWorkspace<D>>() + self.obstacles.len() * size_of::<ObstacleForces>();
        self.workspaces.len() * room
    }

    /// A point at `x` (m) of this half width before the first step: where it is nearer to a surface than that it reaches as far as the
    /// surface, so that nothing presses yet.
    pub fn initial_penalty_state(&self, x: &[f64; D], half: f64) -> PenaltyState<D> {
        let distances = self.obstacles.iter().filter_map(|rock| rock.current_surface().gap(x, half));
        let nearest = distances.map(|gap| gap.distance).fold(half, f64::min);
        PenaltyState { half, reach: nearest.max(0.0), ..PenaltyState::NEW }
    }
}

impl<const D: usize> PenaltyObstacle<D> {
    /// Its surface where it is.
    pub fn current_surface(&self) -> &dyn Surface<D> {
        match &self.moving {
            Some(moving) => &moving.obstacle.placed,
            None => &*self.surface,
        }
    }

    /// How far its part at `x` (m) has come since the step before (m).
    pub(super) fn displacement_since(&self, x: &[f64; D]) -> [f64; D] {
        self.moving.as_ref().map_or(
            [0.0; D],
            |ObstacleMotionState { obstacle: own, previous_transform: before }| {
                let was = own.material_position(x, before);
                std::array::from_fn(|c| x[c] - was[c])
            },
        )
    }

    /// How far its part at `x` (m) goes until `time` (s) (m).
    pub fn displacement_until(&self, x: &[f64; D], time: f64) -> [f64; D] {
        self.moving.as_ref().map_or([0.0; D], |ObstacleMotionState { obstacle: own, .. }| {
            let goes = own.material_position(x, &own.motion.transform(time));
            std::array::from_fn(|c| goes[c] - x[c])
        })
    }
}

/// Whether a place of a surface comes before another: the nearer one, and of two as near one that their normals tell, so that it does
/// not depend on the order of the obstacles.
fn is_before<const D: usize>(own: &NearestPoint<D>, other: &NearestPoint<D>) -> bool {
    (own.distance, own.normal) < (other.distance, other.normal)
}

/// What `rocks` do to a point at `x` (m). The point's reach, what it may move and what holds it follow.
pub fn detect_contacts<const D: usize>(
    rocks: &[PenaltyObstacle<D>],
    horizon: f64,
    x: &[f64; D],
    point: &mut PenaltyState<D>,
    room: &mut BlockWorkspace<D>,
) -> ContactCandidates<D> {
    let mut seen = ContactCandidates::NOTHING;
    let radius = SEARCH_RATIO * point.half;
    let mut nearest = f64::INFINITY;
    // Of the obstacles that hold what touches them: the nearest that it touches, and the one that has held it so far.
    let (mut touched, mut bonded) = (None, None);
    for (number, rock) in rocks.iter().enumerate() {
        room.found.clear();
        let surface = rock.current_surface();
        surface.query_contacts(x, radius, &mut room.found);
        let own = room.found.all().first().copied().or_else(|| surface.gap(x, horizon.max(radius)));
        nearest = nearest.min(own.map_or(horizon.max(radius), |own| own.distance));
        let Some(own) = own.filter(|own| own.distance < radius) else { continue };
        room.penetrations += u64::from(own.distance < 0.0);
        let law = *rock.laws.at(&own.position);
        if law.allows_separation() {
            // It has come from a part that holds it.
            point.bond = if point.bond == number as u32 + 1 { 0 } else { point.bond };
        } else if own.distance - point.reach <= CONTACT_TOLERANCE * point.half
            && touched.as_ref().is_none_or(|(_, other, _)| is_before(&own, other))
        {
            touched = Some((number, own, law));
        }
        if point.bond == number as u32 + 1 {
            bonded = Some((number, own, law));
        }
        let all = room.found.all();
        seen.add_contacts(
            rock,
            number,
            if all.is_empty() { std::slice::from_ref(&own) } else { all },
            point.reach,
        );
    }
    if let Some((number, ..)) = touched {
        point.bond = number as u32 + 1;
    }
    seen.bonded_contact = touched.or(bonded);
    if point.bond == 0 {
        // What has gone farther away reaches farther from then on: nothing is done to it by that.
        point.reach = point.half.min(point.reach.max(nearest));
    }
    point.free_distance = nearest - point.half;
    // A point that presses by less than its width pulls as far as that again.
    if let Some((_, place, _)) = seen.bonded_contact
        && place.distance - point.reach > point.half
    {
        (point.bond, seen.bonded_contact) = (0, None);
    } else if seen.bonded_contact.is_none() {
        point.bond = 0;
    }
    if seen.acts() {
        point.free_distance = point.free_distance.min(0.0);
    }
    seen
}
