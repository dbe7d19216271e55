//! No point is carried into an obstacle: what its springs have not turned back is stopped before the surface
//! (docs/theory/mpm.md, obstacles).

use colluvium_constitutive::BLOCK;
use colluvium_grid::{Lanes, Node, Points, Walls};
use colluvium_points::surface::{Nearest, passes_through};
use rayon::prelude::*;

use crate::background::Background;
use crate::bodies::Bodies;
use crate::clock::Clock;
use crate::nodes::Nodes;
use crate::obstacles::rocks::{Rock, Rocks, Room};
use crate::obstacles::stops::Halt;
use crate::points::Columns;
use crate::pressed::Pressed;
use crate::vectors::{lanes, square, three};

/// Least distance of a centre from a surface over the way from there at which its springs begin to press.
const LEAST: f64 = 0.05;

/// Share of its distance by which a point that is stopped may come nearer in a step.
const SLACK: f64 = 1e-3;

/// Largest move of a point in a step (cells); a longer one is an error.
const LONGEST: f64 = 0.5;

/// How deep under a face solid is looked for, over the least distance of a centre.
const UNDER: f64 = 0.1;

/// Searches for points that come too near, at most: what stops one may move another.
const PASSES: usize = 4;

/// Points in blocks that one thread takes at once.
const GRAIN: usize = 4;

/// What stops points.
pub struct Stopping<'a, const D: usize> {
    /// The step.
    pub clock: &'a Clock,
    /// Where points and nodes are.
    pub background: &'a Background<D>,
    /// The points.
    pub bodies: &'a Bodies<D>,
    /// What holds nodes.
    pub walls: &'a Walls,
    /// Whether the velocities are those that points take: obstacles rub then, and what they bear is added up. Else points only
    /// change place by them.
    pub takes: bool,
}

/// Stops points by the solved velocities and accelerations of the nodes.
pub fn stop_solved<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    solved: &mut [Node],
    (walls, rocks): (&Walls, &mut Option<Box<Rocks<D>>>),
) {
    let stopping = Stopping { clock, background, bodies, walls, takes: true };
    stopping.stop(
        rocks,
        solved,
        |_, node| node.motion,
        |node, change| node.change_velocity(change, clock.dt),
    );
}

/// Stops points by the re-mapped velocities of the nodes, by which they change place.
pub fn stop_remapped<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    nodes: &mut Nodes,
    (walls, rocks): (&Walls, &mut Option<Box<Rocks<D>>>),
) {
    let Nodes { solved, remapped, .. } = nodes;
    let stopping = Stopping { clock, background, bodies, walls, takes: false };
    let of = |number: usize, own: &Lanes| with_mass(*own, solved[number].motion);
    stopping.stop(rocks, remapped, of, |node, change| *node += change);
}

/// A velocity with the mass in the fourth lane of another.
pub fn with_mass(velocity: Lanes, other: Lanes) -> Lanes {
    let ([x, y, z, _], [.., mass]) = (velocity.to_array(), other.to_array());
    Lanes::new([x, y, z, mass])
}

impl<const D: usize> Stopping<'_, D> {
    /// Changes the velocities of nodes so that the points which they carry stay before the surfaces. `of` has the velocity of a
    /// node, in all velocity fields, with its mass in the fourth lane; `add` adds to it (m/s).
    pub fn stop<T: Sync>(
        &self,
        rocks: &mut Option<Box<Rocks<D>>>,
        nodes: &mut [T],
        of: impl Fn(usize, &T) -> Lanes + Sync,
        add: impl Fn(&mut T, Lanes),
    ) {
        let Some(rocks) = rocks else { return };
        for _ in 0..PASSES {
            if !self.find(rocks, &|number| of(number, &nodes[number])) {
                return;
            }
            let stops = &mut rocks.stops;
            stops.list(|number| self.node(number, of(number, &nodes[number])));
            stops.solve();
            for (number, change) in stops.numbers.iter().zip(&stops.change) {
                self.each_image(*number, |image| add(&mut nodes[image], lanes(change, 0.0)));
            }
            if self.takes {
                self.book(rocks);
            }
        }
    }

    /// Finds the points that come too near to a surface; whether there are any.
    fn find(&self, rocks: &mut Rocks<D>, of: &(dyn Fn(usize) -> Lanes + Sync)) -> bool {
        let Rocks { rocks, rooms, horizon, passed, stops } = rocks;
        stops.clear(rocks.len());
        let ways = rocks.iter().filter_map(|rock| rock.moving.as_ref());
        let (from, to) = (self.clock.time, self.clock.time + self.clock.dt);
        let ahead = ways.map(|moving| moving.own.way(from, to)).fold(0.0, f64::max);
        let nodes = self.background.layout.len();
        for set in self.bodies.sets.iter().filter(|set| set.rigid.is_none()) {
            let Columns { pressed, origin, .. } = &set.points;
            let of_set = OfSet {
                stopping: self,
                places: set.places(),
                origin,
                first_node: set.field * nodes,
                horizon: *horizon,
                swept: passed.swept,
                ahead,
            };
            let blocks = pressed.par_chunks(BLOCK).zip(&mut *rooms).enumerate();
            blocks.with_min_len(GRAIN).for_each(|(block, (points, room))| {
                of_set.block(rocks, block * BLOCK, points, of, room);
            });
            for room in &mut rooms[..pressed.len().div_ceil(BLOCK)] {
                stops.take(&mut room.halts, &mut room.weights);
            }
        }
        !stops.halts.is_empty()
    }

    /// Velocity (m/s) of a node, and one over its inertia along each axis (1/kg).
    fn node(&self, number: usize, motion: Lanes) -> ([f64; D], [f64; D]) {
        let (velocity, [.., mass]) = (three(motion), motion.to_array());
        let held = self.walls.holding(&self.index(number), &velocity);
        let ease = if mass > 0.0 { 1.0 / (mass * self.clock.options.mass_scaling) } else { 0.0 };
        let free = std::array::from_fn(|c| if held[c] { 0.0 } else { ease });
        (std::array::from_fn(|c| velocity[c]), free)
    }

    /// Index of a node along the axes.
    fn index(&self, number: usize) -> [usize; 3] {
        let layout = &self.background.layout;
        let (number, row) = (number % layout.len(), layout.strides()[0]);
        layout.index(number / row, number % row)
    }

    /// Calls `act` for a node and those that are the same one in a periodic domain.
    fn each_image(&self, number: usize, mut act: impl FnMut(usize)) {
        let Background { layout, periodic, .. } = self.background;
        if *periodic == [false; D] {
            act(number);
            return;
        }
        let (own, strides) = (self.index(number), layout.strides());
        let at = |index: &[usize; 3]| (0..D).map(|c| index[c] * strides[c]).sum::<usize>();
        for image in layout.images(own) {
            act(number + at(&image) - at(&own));
        }
    }

    /// The first of the nodes that are one in a periodic domain.
    fn first_of(&self, number: usize) -> usize {
        let mut first = number;
        if self.background.periodic != [false; D] {
            self.each_image(number, |image| first = first.min(image));
        }
        first
    }

    /// Adds up what obstacles have got.
    fn book(&self, rocks: &mut Rocks<D>) {
        let Rocks { rocks, stops, .. } = rocks;
        for (rock, sums) in rocks.iter_mut().zip(&stops.sums) {
            for c in 0..3 {
                rock.state.force[c] += sums.force[c] / self.clock.dt;
                rock.state.moment[c] += sums.moment[c] / self.clock.dt;
                rock.state.impulse[c] += sums.force[c];
            }
            rock.state.friction += sums.friction;
            rock.state.work += sums.work;
            rock.state.stopped += sums.stopped;
        }
    }
}

/// What the points of a set share.
struct OfSet<'a, const D: usize> {
    stopping: &'a Stopping<'a, D>,
    places: Points<'a, D>,
    origin: &'a [[f64; D]],
    first_node: usize,
    horizon: f64,
    /// How far obstacles have come at most (m).
    swept: f64,
    /// How far obstacles go in the step at most (m).
    ahead: f64,
}

impl<const D: usize> OfSet<'_, D> {
    /// Finds those of a block, from number `first` on.
    fn block(
        &self,
        rocks: &[Rock<D>],
        first: usize,
        points: &[Pressed<D>],
        of: &(dyn Fn(usize) -> Lanes + Sync),
        room: &mut Room<D>,
    ) {
        room.halts.clear();
        room.weights.clear();
        let background = self.stopping.background;
        let ground = background.ground();
        for (k, point) in points.iter().enumerate() {
            let p = first + k;
            let x = &self.places.position[p];
            let gone: [f64; D] = std::array::from_fn(|c| x[c] - self.origin[p][c] - point.seen[c]);
            // What an obstacle holds may be nearer than it counts.
            let near = if point.bond == 0 {
                point.free + point.half - square(&gone).sqrt() - (self.swept - point.swept)
            } else {
                0.0
            };
            let most = LONGEST * self.places.domain.spacing(p, &ground) + self.ahead;
            if near > most + LEAST * point.reach {
                continue;
            }
            let (start, mut velocity) = (room.weights.len(), [0.0; D]);
            background.sweeps.weights(&ground, &self.places.range(p..p + 1), &mut |_, node, w| {
                let node = self.stopping.first_of(self.first_node + node);
                let own = of(node).to_array();
                (0..D).for_each(|c| velocity[c] += w * own[c]);
                room.weights.push((node, w));
            });
            let seen = Seen { x, velocity, nodes: start..room.weights.len(), near, point };
            if !seen.find(rocks, self.stopping, self.horizon, room) {
                room.weights.truncate(start);
            }
        }
    }
}

/// A point that may come too near to a surface.
struct Seen<'a, const D: usize> {
    x: &'a [f64; D],
    /// Velocity with which it is carried (m/s).
    velocity: [f64; D],
    nodes: std::ops::Range<usize>,
    /// Least distance from any surface (m).
    near: f64,
    point: &'a Pressed<D>,
}

impl<const D: usize> Seen<'_, D> {
    /// Finds the places to which it comes too near; whether there are any.
    fn find(&self, rocks: &[Rock<D>], stopping: &Stopping<'_, D>, horizon: f64, room: &mut Room<D>) -> bool {
        let Stopping { clock, takes, .. } = stopping;
        let (dt, before) = (clock.dt, room.halts.len());
        let kept = LEAST * self.point.reach;
        for (number, rock) in rocks.iter().enumerate() {
            let course = rock.step_until(self.x, clock.time + dt).map(|way| way / dt);
            let goes: [f64; D] = std::array::from_fn(|c| dt * (self.velocity[c] - course[c]));
            let way = square(&goes).sqrt();
            if self.near > kept + way {
                continue;
            }
            let surface = rock.now();
            let Some(now) = surface.gap(self.x, horizon.max(kept + way)) else { continue };
            if now.distance > kept + way {
                continue;
            }
            let keeps = now.distance.min(kept);
            let slack = SLACK * keeps.abs() + f64::EPSILON * self.point.half;
            let to: [f64; D] = std::array::from_fn(|c| self.x[c] + goes[c]);
            room.found.clear();
            surface.touch(&to, kept, &mut room.found);
            let inside = if room.found.is_empty() { surface.gap(&to, horizon.max(kept + way)) } else { None };
            let through = passes_through(surface, self.x, &goes, &now, UNDER * kept);
            // Behind what it has gone through the nearest surface is on the other side.
            let faces = |place: &&Nearest<D>| {
                through.is_none() || (0..D).map(|c| place.normal[c] * now.normal[c]).sum::<f64>() > 0.0
            };
            let places = room.found.all().iter().chain(inside.as_ref()).filter(faces).chain(&through);
            for place in places.filter(|place| place.distance < keeps - slack) {
                let along: f64 = (0..D).map(|c| self.velocity[c] * place.normal[c]).sum();
                room.halts.push(Halt {
                    nodes: self.nodes.clone(),
                    place: *self.x,
                    normal: place.normal,
                    least: along + (keeps - place.distance) / dt,
                    slack: 0.5 * slack / dt,
                    course,
                    rock: number,
                    friction: if *takes { rock.laws.at(&place.place).friction() } else { 0.0 },
                    pushed: 0.0,
                    rubbed: [0.0; D],
                });
            }
        }
        room.halts.len() > before
    }
}
