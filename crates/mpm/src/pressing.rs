//! Bodies press on obstacles with their points (docs/theory/mpm.md, obstacles).
//!
//! Forces go by where points are at the start of a step and are scattered with their stresses, before the momentum solve. What a point
//! has moved along an obstacle is told by its displacement since the step before.

use colluvium_constitutive::{BLOCK, Material, StateBlock, SymTensor};
use colluvium_grid::DomainSlice;
use rayon::prelude::*;

use crate::background::Background;
use crate::bodies::Bodies;
use crate::clock::Clock;
use crate::obstacles::grip::Grip;
use crate::obstacles::rocks::{Rock, RockState, Rocks, Room, Sums, look};
use crate::points::{Columns, PointSet};
use crate::pore::Fluid;
use crate::pressed::Pressed;
use crate::soaked::Soaked;
use crate::vectors::square;

/// Blocks that one thread takes at once.
const GRAIN: usize = 4;

/// Lets the points of bodies begin where they are, and makes room.
pub fn begin_pressing<const D: usize>(
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    rocks: &mut Option<Box<Rocks<D>>>,
) {
    let Some(rocks) = rocks else { return };
    let mut blocks = 0;
    for set in bodies.sets.iter_mut().filter(|set| set.rigid.is_none()) {
        let half = |p: usize| {
            let radius = if background.axisymmetric { set.points.position[p][0] } else { 1.0 };
            0.5 * (set.points.initial_volume[p] / radius).powf(1.0 / D as f64)
        };
        set.points.pressed = (0..set.len()).map(|p| rocks.begin(&set.points.position[p], half(p))).collect();
        if let Some(pore) = &mut set.pore {
            pore.points.soaked = vec![Soaked::NEW; pore.points.len()];
        }
        blocks = blocks.max(set.len().div_ceil(BLOCK));
    }
    rocks.make_room(blocks);
}

/// Finds the forces of obstacles on points at the start of a step of `dt` (s).
pub fn press<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    rocks: &mut Option<Box<Rocks<D>>>,
) {
    let Some(rocks) = rocks else { return };
    rocks.advance(clock.time);
    let Rocks { rocks, rooms, horizon, passed, .. } = &mut **rocks;
    let stiffness = clock.options.obstacle_stiffness;
    for set in bodies.sets.iter_mut().filter(|set| set.rigid.is_none()) {
        let PointSet { points, states, material, domain, pore, .. } = set;
        let Columns { pressed, position, origin, stress, volume, initial_volume, .. } = points;
        let fluid = pore.as_ref().and_then(|pore| pore.fluid);
        let domain = domain.as_slice();
        let (material, swept) = (&**material, passed.swept);
        let of_set = OfSet {
            material,
            position,
            origin,
            stress,
            volume,
            initial_volume,
            domain,
            background,
            stiffness,
            swept,
            fluid,
        };
        let act = |block: usize, points: &mut [_], soaked: &mut [_], states: &_, room: &mut Room<D>| {
            room.sums.fill(Sums::default());
            room.under = 0;
            of_set.block(rocks, *horizon, block * BLOCK, (points, soaked), states, room);
        };
        let blocks = pressed.par_chunks_mut(BLOCK).zip(states.blocks()).zip(&mut *rooms);
        match pore {
            Some(pore) => {
                let soaked = pore.points.soaked.par_chunks_mut(BLOCK);
                let blocks = blocks.zip(soaked).enumerate();
                blocks.with_min_len(GRAIN).for_each(|(block, (((points, states), room), soaked))| {
                    act(block, points, soaked, states, room);
                });
            }
            None => blocks.enumerate().with_min_len(GRAIN).for_each(|(block, ((points, states), room))| {
                act(block, points, &mut [], states, room);
            }),
        }
        let count = pressed.len().div_ceil(BLOCK);
        for room in &rooms[..count] {
            passed.under += room.under;
            for (rock, sums) in rocks.iter_mut().zip(&room.sums) {
                for c in 0..3 {
                    rock.state.force[c] += sums.force[c];
                    rock.state.moment[c] += sums.moment[c];
                    rock.state.impulse[c] += clock.dt * sums.force[c];
                }
                rock.state.friction += sums.friction;
                rock.state.work += sums.work;
                rock.state.stored += sums.stored;
            }
        }
    }
}

/// Begins to count displacements anew from where the points are.
pub fn forget_displacements<const D: usize>(bodies: &mut Bodies<D>) {
    for set in &mut bodies.sets {
        for ((point, x), origin) in
            set.points.pressed.iter_mut().zip(&set.points.position).zip(&set.points.origin)
        {
            (0..D).for_each(|c| point.seen[c] -= x[c] - origin[c]);
        }
    }
}

/// What is to be said of points whose centres have been in obstacles.
pub fn remark_on_obstacles<const D: usize>(rocks: Option<&Rocks<D>>) -> Option<String> {
    let under = rocks.map_or(0, |rocks| rocks.passed.under);
    (under > 0).then(|| {
        format!(
            "centres of points have been in an obstacle, {under} times a point and a step, though points are stopped before it: \
             look at where it is thinner or more curved than a cell (take smaller cells, or a shorter step)"
        )
    })
}

/// Energies of obstacles that act on points (J).
pub struct ObstacleEnergies {
    /// Work of friction since the start.
    pub friction: f64,
    /// Energy of their springs.
    pub stored: f64,
    /// Energy taken since the start from points that were stopped.
    pub stopped: f64,
    /// Work of their motion; `None` where they stand still.
    pub work: Option<f64>,
}

/// The energies of obstacles; `None` where they do not act on points.
pub fn obstacle_energies<const D: usize>(rocks: Option<&Rocks<D>>) -> Option<ObstacleEnergies> {
    let rocks = &rocks?.rocks;
    let sum = |of: fn(&RockState) -> f64| rocks.iter().map(|rock| of(&rock.state)).sum();
    let moves = rocks.iter().any(|rock| rock.moving.is_some());
    Some(ObstacleEnergies {
        friction: sum(|state| state.friction),
        stored: sum(|state| state.stored),
        stopped: sum(|state| state.stopped),
        work: moves.then(|| sum(|state| state.work)),
    })
}

/// What the points of a set share.
struct OfSet<'a, const D: usize> {
    material: &'a dyn Material,
    position: &'a [[f64; D]],
    origin: &'a [[f64; D]],
    stress: &'a [SymTensor],
    volume: &'a [f64],
    initial_volume: &'a [f64],
    domain: DomainSlice<'a, D>,
    background: &'a Background<D>,
    stiffness: f64,
    /// How far obstacles have come at most (m).
    swept: f64,
    /// Its pore fluid, if any.
    fluid: Option<Fluid>,
}

impl<const D: usize> OfSet<'_, D> {
    /// The points of a block, from number `first` on.
    fn block(
        &self,
        rocks: &[Rock<D>],
        horizon: f64,
        first: usize,
        (points, soaked): (&mut [Pressed<D>], &mut [Soaked<D>]),
        states: &StateBlock,
        room: &mut Room<D>,
    ) {
        let mut moduli: Option<[f64; BLOCK]> = None;
        for (k, point) in points.iter_mut().enumerate() {
            let p = first + k;
            let x = &self.position[p];
            let way: [f64; D] = std::array::from_fn(|c| x[c] - self.origin[p][c]);
            let moved: [f64; D] = std::array::from_fn(|c| way[c] - point.seen[c]);
            if square(&moved).sqrt() + (self.swept - point.swept) < point.free {
                continue;
            }
            // Where nothing was near it may not have been looked at for many steps.
            let touched = point.free <= 0.0;
            (point.seen, point.swept) = (way, self.swept);
            let mut soaked = soaked.get_mut(k);
            if let (Some(soaked), false) = (&mut soaked, touched) {
                **soaked = Soaked::NEW;
            }
            let seen = look(rocks, horizon, x, point, room);
            if !seen.acts() {
                (point.force, point.spring) = ([0.0; D], [0.0; D]);
                soaked.into_iter().for_each(|soaked| *soaked = Soaked::NEW);
                continue;
            }
            let modulus = moduli.get_or_insert_with(|| {
                let mut moduli = [0.0; BLOCK];
                let end = (first + BLOCK).min(self.stress.len());
                self.material.wave_moduli(&self.stress[first..end], states, &mut moduli[..end - first]);
                moduli
            })[k];
            let h = self.domain.spacing(p, &self.background.ground());
            let grip = Grip {
                place: *x,
                moved,
                touched,
                stiffness: self.stiffness * modulus * self.volume[p] / (h * h),
                area: self.volume[p] / (2.0 * point.half),
            };
            grip.act(rocks, &seen, point, &mut room.sums);
            if let (Some(soaked), Some(fluid)) = (soaked, &self.fluid) {
                let modulus = fluid.bulk_modulus / fluid.porosity_at(self.volume[p], self.initial_volume[p]);
                let stiffness = self.stiffness * modulus * self.volume[p] / (h * h);
                let wet = Grip { stiffness, ..grip };
                wet.soak(rocks, &seen, fluid.least, (point, soaked), &mut room.sums);
            }
        }
    }
}
