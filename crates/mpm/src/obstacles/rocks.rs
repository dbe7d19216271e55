//! Obstacles that act on points, and what they have borne.

use std::sync::Arc;

use colluvium_case::description::ObstacleWall;
use colluvium_case::rigid::{Rock as Ground, Stood};
use colluvium_case::{MovingObstacle, ObstacleLaw, ObstacleLaws, Standing};
use colluvium_points::Surface;
use colluvium_points::surface::{Contacts, Frame, Nearest, cross};
use serde::{Deserialize, Serialize};

use super::law::{MOST, Overlap, length, rub, way_out};
use super::stops::{Halt, Stops};
use crate::pressed::Pressed;
use crate::soaked::Soaked;

/// How far from its surface a point looks for the next one, over its half width.
const LOOK: f64 = 2.0;

/// Distance from a surface over the half width of a point within which it counts as touching.
const TOUCH: f64 = 1e-6;

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
    /// The obstacle that holds it, with the nearest place of its surface and its law there.
    held: Option<(usize, Nearest<D>, ObstacleLaw)>,
}

impl<const D: usize> Seen<D> {
    const NOTHING: Self = {
        let law = ObstacleLaw { wall: ObstacleWall::Smooth, separation: false };
        Self {
            overlaps: [Overlap { normal: [0.0; D], depth: 0.0, rock: 0, law }; MOST],
            count: 0,
            held: None,
        }
    };

    fn add(&mut self, overlap: Overlap<D>) {
        if self.count < MOST {
            self.overlaps[self.count] = overlap;
            self.count += 1;
        }
    }

    fn overlaps(&self) -> &[Overlap<D>] {
        &self.overlaps[..self.count]
    }

    /// Whether obstacles act on the point.
    pub fn acts(&self) -> bool {
        self.count > 0 || self.held.is_some()
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
    fn step_at(&self, x: &[f64; D]) -> [f64; D] {
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
        } else if own.distance - point.reach <= TOUCH * point.half {
            point.bond = number as u32 + 1;
        }
        if point.bond == number as u32 + 1 {
            seen.held = Some((number, own, law));
        }
        let all = room.found.all();
        let places = if all.is_empty() { std::slice::from_ref(&own) } else { all };
        for place in places {
            let depth = point.reach - place.distance;
            if depth > 0.0 {
                let law = *rock.laws.at(&place.place);
                seen.add(Overlap { normal: place.normal, depth, rock: number, law });
            }
        }
    }
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
    if seen.held.is_some() {
        point.free = 0.0;
    }
    seen
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
        let mut cap = 0.0;
        // The obstacle that bears friction: the one that bears most of it.
        let (mut bears, mut most) = (None, -1.0);
        for (overlap, own) in seen.overlaps().iter().zip(ways).filter(|(_, own)| *own > 0.0) {
            let (rock, law) = (&rocks[overlap.rock], &overlap.law);
            // Without a normal force infinite friction bears nothing.
            let bound = if law.friction() == 0.0 { 0.0 } else { law.friction() * own }
                + law.adhesion() * self.area / k;
            cap += bound;
            if bound > most {
                (bears, most) = (Some((overlap.rock, overlap.normal)), bound);
            }
            let push = overlap.normal.map(|n| k * own * n);
            (0..D).for_each(|c| point.force[c] += push[c]);
            self.add(rock, &mut sums[overlap.rock], &push);
            sums[overlap.rock].stored += 0.5 * k * own * overlap.depth;
        }
        if let Some((number, place, law)) = &seen.held {
            let pulled = place.distance - point.reach;
            if pulled > 0.0 {
                let pull = place.normal.map(|n| -k * pulled * n);
                (0..D).for_each(|c| point.force[c] += pull[c]);
                self.add(&rocks[*number], &mut sums[*number], &pull);
                sums[*number].stored += 0.5 * k * pulled * pulled;
            }
            if law.friction().is_infinite() {
                (cap, bears) = (f64::INFINITY, Some((*number, place.normal)));
            } else if bears.is_none() {
                bears = Some((*number, place.normal));
            }
        }
        let Some((number, own)) = bears else {
            point.spring = [0.0; D];
            return;
        };
        let normal = if depth > 0.0 { way.map(|c| c / depth) } else { own };
        let moved = self.rubbed(&rocks[number], &normal, depth);
        let (spring, slip) = rub(&point.spring, &moved, &normal, cap);
        point.spring = spring;
        let drag = spring.map(|s| -k * s);
        (0..D).for_each(|c| point.force[c] += drag[c]);
        self.add(&rocks[number], &mut sums[number], &drag);
        let stretch = length(&spring);
        sums[number].stored += 0.5 * k * stretch * stretch;
        if slip > 0.0 {
            sums[number].friction += k * cap * slip;
        }
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
