//! Obstacles that act on points, and what they have borne.

use std::sync::Arc;

use colluvium_case::description::ObstacleWall;
use colluvium_case::rigid::{Rock as Ground, Stood};
use colluvium_case::{MovingObstacle, ObstacleLaw, ObstacleLaws, Standing};
use colluvium_points::Surface;
use colluvium_points::surface::{Contacts, Frame, Nearest, cross};
use serde::{Deserialize, Serialize};

use super::law::{MOST, Overlap};
use super::stops::{Halt, Stops};
use crate::pressed::Pressed;

/// How far from its surface a point looks for the next one, over its half width.
const LOOK: f64 = 2.0;

/// Distance from a surface over the half width of a point within which it counts as touching.
const TOUCH: f64 = 1e-6;

/// Gap over the half width of a point up to which an obstacle with adhesion still rubs on it: a body that slides trembles by less, and
/// would be without adhesion half of the time.
const ADHERES: f64 = 1e-2;

/// An obstacle.
#[derive(Clone, Debug)]
pub struct Rock<const D: usize> {
    /// Name in the case.
    pub name: String,
    /// Its surface.
    pub surface: Arc<dyn Surface<D>>,
    /// How it acts.
    pub laws: ObstacleLaws,
    /// Its motion; `None` at rest.
    pub moving: Option<Moving<D>>,
    /// What it has borne.
    pub state: RockState,
}

/// An obstacle on its way.
#[derive(Clone, Debug)]
pub struct Moving<const D: usize> {
    /// Where it is.
    pub own: MovingObstacle<D>,
    /// Where it was in the step before.
    before: Frame<D>,
}

/// What an obstacle has borne.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RockState {
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
    pub stored: f64,
    /// Energy taken since the start from points that were stopped before its surface (J), not negative.
    pub stopped: f64,
}

impl RockState {
    /// Takes what a rigid body gives in a step of `dt` (s).
    pub fn take(&mut self, stood: &Stood, dt: f64) {
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
pub struct Passed {
    /// Number of points whose centre has been in an obstacle, over all steps.
    pub under: u64,
    /// How far a place of an obstacle in the domain can have come, at most (m).
    pub swept: f64,
    /// When obstacles last acted (s).
    pub at: f64,
}

/// The obstacles of a case whose bodies press on them with their points.
#[derive(Debug)]
pub struct Rocks<const D: usize> {
    /// The obstacles.
    pub rocks: Vec<Rock<D>>,
    /// Room for blocks of points.
    pub rooms: Vec<Room<D>>,
    /// How far a point looks around where it finds none near (m).
    pub horizon: f64,
    /// Room for points that are stopped before a surface.
    pub stops: Stops<D>,
    /// What changes.
    pub passed: Passed,
}

/// What a block of points finds and adds up.
#[derive(Clone, Debug, Default)]
pub struct Room<const D: usize> {
    pub found: Contacts<D>,
    /// Points that come too near to a surface.
    pub halts: Vec<Halt<D>>,
    /// Nodes of these and weights, one point after another.
    pub weights: Vec<(usize, f64)>,
    /// Of each obstacle.
    pub sums: Vec<Sums>,
    /// Points whose centres are in an obstacle.
    pub under: u64,
}

/// What an obstacle gets from points in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
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
pub struct Seen<const D: usize> {
    overlaps: [Overlap<D>; MOST],
    count: usize,
    /// A place with adhesion that it does not overlap, but has hardly left.
    pub(super) left: Option<Overlap<D>>,
    /// The obstacle that holds it, with the nearest place of its surface and its law there.
    pub(super) held: Option<(usize, Nearest<D>, ObstacleLaw)>,
}

impl<const D: usize> Seen<D> {
    pub(super) const NOTHING: Self = {
        let law = ObstacleLaw { wall: ObstacleWall::Smooth, separation: false };
        Self {
            overlaps: [Overlap { normal: [0.0; D], depth: 0.0, rock: 0, law }; MOST],
            count: 0,
            left: None,
            held: None,
        }
    };

    pub(super) fn add(&mut self, overlap: Overlap<D>) {
        if self.count < MOST {
            self.overlaps[self.count] = overlap;
            self.count += 1;
        }
    }

    /// Adds those places of an obstacle that are nearer than the point reaches (m), and notes one with adhesion just beyond.
    fn press(&mut self, rock: &Rock<D>, number: usize, places: &[Nearest<D>], reach: f64) {
        for place in places {
            let depth = reach - place.distance;
            let law = *rock.laws.at(&place.place);
            let overlap = Overlap { normal: place.normal, depth, rock: number, law };
            if depth > 0.0 {
                self.add(overlap);
            } else if law.adhesion() > 0.0 && depth > -ADHERES * reach && self.left.is_none() {
                self.left = Some(overlap);
            }
        }
    }

    pub(super) fn overlaps(&self) -> &[Overlap<D>] {
        &self.overlaps[..self.count]
    }

    /// Whether obstacles act on the point.
    pub fn acts(&self) -> bool {
        self.count > 0 || self.held.is_some() || self.left.is_some()
    }
}

impl<const D: usize> Rock<D> {
    /// As what rigid bodies stand on, where it is.
    pub fn ground(&self) -> Ground<'_, D> {
        let moving = self.moving.as_ref().map(|moving| &moving.own);
        let surface = moving.map_or(&*self.surface, |own| &own.placed);
        Ground { surface, laws: &self.laws, moving }
    }
}

impl<const D: usize> Rocks<D> {
    /// The obstacles of a case in a domain with these corners (m); `horizon` (m) is how far points look around.
    pub fn new(standing: &[Standing<'_, D>], domain: ([f64; D], [f64; D]), horizon: f64) -> Self {
        let rock = |Standing { obstacle, surface, laws, .. }: &Standing<'_, D>| Rock {
            name: obstacle.name.clone(),
            surface: Arc::clone(surface),
            laws: laws.clone(),
            moving: obstacle.motion.as_ref().map(|motion| Moving {
                own: MovingObstacle::new(motion, surface, domain),
                before: motion.frame(0.0),
            }),
            state: RockState::default(),
        };
        Self {
            rocks: standing.iter().map(rock).collect(),
            rooms: Vec::new(),
            horizon,
            stops: Stops::default(),
            passed: Passed::default(),
        }
    }

    /// Those on their way.
    pub fn moving(&self) -> impl Iterator<Item = &MovingObstacle<D>> {
        self.rocks.iter().filter_map(|rock| rock.moving.as_ref()).map(|moving| &moving.own)
    }

    /// Brings the obstacles to where they are at `time` (s); what they bear in the step is counted anew.
    pub fn advance(&mut self, time: f64) {
        let at = std::mem::replace(&mut self.passed.at, time);
        let mut swept = 0f64;
        for rock in &mut self.rocks {
            (rock.state.force, rock.state.moment, rock.state.stored) = ([0.0; 3], [0.0; 3], 0.0);
            let Some(Moving { own, before }) = &mut rock.moving else { continue };
            *before = own.motion.frame(at);
            own.go_to(time);
            swept = swept.max(own.way(at, time));
        }
        self.passed.swept += swept;
    }

    /// Makes room for so many blocks of points.
    pub fn make_room(&mut self, blocks: usize) {
        let room = Room { sums: vec![Sums::default(); self.rocks.len()], ..Room::default() };
        self.rooms = vec![room; blocks];
    }

    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        // Of the places that a block finds a few.
        let room = size_of::<Room<D>>() + self.rocks.len() * size_of::<Sums>();
        self.rooms.len() * room
    }

    /// A point at `x` (m) of this half width before the first step: where it is nearer to a surface than that it reaches as far as the
    /// surface, so that nothing presses yet.
    pub fn begin(&self, x: &[f64; D], half: f64) -> Pressed<D> {
        let distances = self.rocks.iter().filter_map(|rock| rock.now().gap(x, half));
        let nearest = distances.map(|gap| gap.distance).fold(half, f64::min);
        Pressed { half, reach: nearest.max(0.0), ..Pressed::NEW }
    }
}

impl<const D: usize> Rock<D> {
    /// Its surface where it is.
    pub fn now(&self) -> &dyn Surface<D> {
        match &self.moving {
            Some(moving) => &moving.own.placed,
            None => &*self.surface,
        }
    }

    /// How far its part at `x` (m) has come since the step before (m).
    pub(super) fn step_at(&self, x: &[f64; D]) -> [f64; D] {
        self.moving.as_ref().map_or([0.0; D], |Moving { own, before }| {
            let was = own.carried(x, before);
            std::array::from_fn(|c| x[c] - was[c])
        })
    }

    /// How far its part at `x` (m) goes until `time` (s) (m).
    pub fn step_until(&self, x: &[f64; D], time: f64) -> [f64; D] {
        self.moving.as_ref().map_or([0.0; D], |Moving { own, .. }| {
            let goes = own.carried(x, &own.motion.frame(time));
            std::array::from_fn(|c| goes[c] - x[c])
        })
    }
}

/// Whether a place of a surface comes before another: the nearer one, and of two as near one that their normals tell, so that it does
/// not depend on the order of the obstacles.
fn comes_first<const D: usize>(own: &Nearest<D>, other: &Nearest<D>) -> bool {
    (own.distance, own.normal) < (other.distance, other.normal)
}

/// What `rocks` do to a point at `x` (m). The point's reach, what it may move and what holds it follow.
pub fn look<const D: usize>(
    rocks: &[Rock<D>],
    horizon: f64,
    x: &[f64; D],
    point: &mut Pressed<D>,
    room: &mut Room<D>,
) -> Seen<D> {
    let mut seen = Seen::NOTHING;
    let radius = LOOK * point.half;
    let mut nearest = f64::INFINITY;
    // Of the obstacles that hold what touches them: the nearest that it touches, and the one that has held it so far.
    let (mut touched, mut bonded) = (None, None);
    for (number, rock) in rocks.iter().enumerate() {
        room.found.clear();
        let surface = rock.now();
        surface.touch(x, radius, &mut room.found);
        let own = room.found.all().first().copied().or_else(|| surface.gap(x, horizon.max(radius)));
        nearest = nearest.min(own.map_or(horizon.max(radius), |own| own.distance));
        let Some(own) = own.filter(|own| own.distance < radius) else { continue };
        room.under += u64::from(own.distance < 0.0);
        let law = *rock.laws.at(&own.place);
        if law.lets_go() {
            // It has come from a part that holds it.
            point.bond = if point.bond == number as u32 + 1 { 0 } else { point.bond };
        } else if own.distance - point.reach <= TOUCH * point.half
            && touched.as_ref().is_none_or(|(_, other, _)| comes_first(&own, other))
        {
            touched = Some((number, own, law));
        }
        if point.bond == number as u32 + 1 {
            bonded = Some((number, own, law));
        }
        let all = room.found.all();
        seen.press(rock, number, if all.is_empty() { std::slice::from_ref(&own) } else { all }, point.reach);
    }
    if let Some((number, ..)) = touched {
        point.bond = number as u32 + 1;
    }
    seen.held = touched.or(bonded);
    if point.bond == 0 {
        // What has gone farther away reaches farther from then on: nothing is done to it by that.
        point.reach = point.half.min(point.reach.max(nearest));
    }
    point.free = nearest - point.half;
    // A point that presses by less than its width pulls as far as that again.
    if let Some((_, place, _)) = seen.held
        && place.distance - point.reach > point.half
    {
        (point.bond, seen.held) = (0, None);
    } else if seen.held.is_none() {
        point.bond = 0;
    }
    if seen.acts() {
        point.free = point.free.min(0.0);
    }
    seen
}
