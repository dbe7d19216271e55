//! Penalty contact of points with obstacles (docs/theory/mpm.md, obstacles).
//!
//! Forces depend on the positions of points at the start of a step and are scattered with their stresses, before the momentum solve. The
//! sliding displacement of a point is its displacement since the previous step.

use colluvium_constitutive::{BLOCK_SIZE, Material, StateBlock, SymTensor};
use colluvium_grid::DomainSlice;
use rayon::prelude::*;

use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::obstacles::point_springs::ObstacleSprings;
use crate::obstacles::state::{
    BlockWorkspace, ObstacleForces, ObstacleReaction, PenaltyObstacle, PenaltyObstacles, detect_contacts,
};
use crate::points::bodies::Bodies;
use crate::points::penalty_state::PenaltyState;
use crate::points::point_set::{PointColumns, PointSet};
use crate::points::pore_contact_state::PoreContactState;
use crate::points::pore_fluid::PoreFluidConstants;
use crate::points::vectors::square;

/// Number of blocks in a task.
const BLOCKS_PER_TASK: usize = 4;

/// Initialises the contact states of the points and the workspaces.
pub fn initialise_penalty<const D: usize>(
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    rocks: &mut Option<Box<PenaltyObstacles<D>>>,
) {
    let Some(rocks) = rocks else { return };
    let mut blocks = 0;
    for set in bodies.sets.iter_mut().filter(|set| set.rigid.is_none()) {
        let half = |p: usize| {
            let radius = if background.axisymmetric { set.points.position[p][0] } else { 1.0 };
            0.5 * (set.points.initial_volume[p] / radius).powf(1.0 / D as f64)
        };
        set.points.pressed =
            (0..set.len()).map(|p| rocks.initial_penalty_state(&set.points.position[p], half(p))).collect();
        if let Some(pore) = &mut set.pore {
            pore.points.soaked = vec![PoreContactState::NEW; pore.points.len()];
        }
        blocks = blocks.max(set.len().div_ceil(BLOCK_SIZE));
    }
    rocks.resize_workspaces(blocks);
}

/// Computes the forces of obstacles on points at the start of a step of `dt` (s).
pub fn penalty_forces<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    rocks: &mut Option<Box<PenaltyObstacles<D>>>,
) {
    let Some(rocks) = rocks else { return };
    rocks.advance(clock.time);
    let PenaltyObstacles { obstacles: rocks, workspaces: rooms, horizon, history: passed, .. } = &mut **rocks;
    let stiffness = clock.options.obstacle_stiffness;
    for set in bodies.sets.iter_mut().filter(|set| set.rigid.is_none()) {
        let PointSet { points, states, material, domain, pore, .. } = set;
        let PointColumns { pressed, position, origin, stress, volume, initial_volume, .. } = points;
        let fluid = pore.as_ref().and_then(|pore| pore.fluid);
        let domain = domain.as_slice();
        let (material, swept) = (&**material, passed.max_obstacle_displacement);
        let of_set = PenaltyInput {
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
        let act =
            |block: usize, points: &mut [_], soaked: &mut [_], states: &_, room: &mut BlockWorkspace<D>| {
                room.sums.fill(ObstacleForces::default());
                room.penetrations = 0;
                of_set.block(rocks, *horizon, block * BLOCK_SIZE, (points, soaked), states, room);
            };
        let blocks = pressed.par_chunks_mut(BLOCK_SIZE).zip(states.blocks()).zip(&mut *rooms);
        match pore {
            Some(pore) => {
                let soaked = pore.points.soaked.par_chunks_mut(BLOCK_SIZE);
                let blocks = blocks.zip(soaked).enumerate();
                blocks.with_min_len(BLOCKS_PER_TASK).for_each(
                    |(block, (((points, states), room), soaked))| {
                        act(block, points, soaked, states, room);
                    },
                );
            }
            None => blocks.enumerate().with_min_len(BLOCKS_PER_TASK).for_each(
                |(block, ((points, states), room))| {
                    act(block, points, &mut [], states, room);
                },
            ),
        }
        let count = pressed.len().div_ceil(BLOCK_SIZE);
        for room in &rooms[..count] {
            passed.penetrations += room.penetrations;
            for (rock, sums) in rocks.iter_mut().zip(&room.sums) {
                for c in 0..3 {
                    rock.state.force[c] += sums.force[c];
                    rock.state.moment[c] += sums.moment[c];
                    rock.state.impulse[c] += clock.dt * sums.force[c];
                }
                rock.state.friction += sums.friction;
                rock.state.work += sums.work;
                rock.state.spring_energy += sums.stored;
            }
        }
    }
}

/// Sets the displacements of points to zero at their current positions.
pub fn reset_displacements<const D: usize>(bodies: &mut Bodies<D>) {
    for set in &mut bodies.sets {
        for ((point, x), origin) in
            set.points.pressed.iter_mut().zip(&set.points.position).zip(&set.points.origin)
        {
            (0..D).for_each(|c| point.last_search_displacement[c] -= x[c] - origin[c]);
        }
    }
}

/// Warning on points whose centres have been in obstacles.
pub fn penetration_warning<const D: usize>(rocks: Option<&PenaltyObstacles<D>>) -> Option<String> {
    let under = rocks.map_or(0, |rocks| rocks.history.penetrations);
    (under > 0).then(|| {
        format!(
            "centres of points have been inside an obstacle ({under} points, counted in every step), although \
             points are stopped at its surface. Check where the obstacle is thinner or more curved than a \
             cell (take smaller cells, or a shorter step)"
        )
    })
}

/// Energies of obstacles that act on points (J).
pub struct PenaltyEnergies {
    /// Work of friction since the start.
    pub friction: f64,
    /// Energy of the contact springs.
    pub stored: f64,
    /// Energy removed by the penetration limit since the start.
    pub stopped: f64,
    /// Work of the motion of obstacles; `None` for obstacles at rest.
    pub work: Option<f64>,
}

/// Returns the energies of obstacles; `None` where they do not act on points.
pub fn penalty_energies<const D: usize>(rocks: Option<&PenaltyObstacles<D>>) -> Option<PenaltyEnergies> {
    let rocks = &rocks?.obstacles;
    let sum = |of: fn(&ObstacleReaction) -> f64| rocks.iter().map(|rock| of(&rock.state)).sum();
    let moves = rocks.iter().any(|rock| rock.moving.is_some());
    Some(PenaltyEnergies {
        friction: sum(|state| state.friction),
        stored: sum(|state| state.spring_energy),
        stopped: sum(|state| state.stopping_energy),
        work: moves.then(|| sum(|state| state.work)),
    })
}

/// Data that all points of a set share.
struct PenaltyInput<'a, const D: usize> {
    material: &'a dyn Material,
    position: &'a [[f64; D]],
    origin: &'a [[f64; D]],
    stress: &'a [SymTensor],
    volume: &'a [f64],
    initial_volume: &'a [f64],
    domain: DomainSlice<'a, D>,
    background: &'a BackgroundGrid<D>,
    stiffness: f64,
    /// Largest displacement of an obstacle so far (m).
    swept: f64,
    /// Pore fluid of the set, if any.
    fluid: Option<PoreFluidConstants>,
}

impl<const D: usize> PenaltyInput<'_, D> {
    /// Computes the forces on the points of a block, from number `first` on.
    fn block(
        &self,
        rocks: &[PenaltyObstacle<D>],
        horizon: f64,
        first: usize,
        (points, soaked): (&mut [PenaltyState<D>], &mut [PoreContactState<D>]),
        states: &StateBlock,
        room: &mut BlockWorkspace<D>,
    ) {
        let mut moduli: Option<[f64; BLOCK_SIZE]> = None;
        for (k, point) in points.iter_mut().enumerate() {
            let p = first + k;
            let x = &self.position[p];
            let way: [f64; D] = std::array::from_fn(|c| x[c] - self.origin[p][c]);
            let moved: [f64; D] = std::array::from_fn(|c| way[c] - point.last_search_displacement[c]);
            if square(&moved).sqrt() + (self.swept - point.obstacle_displacement) < point.free_distance {
                continue;
            }
            // A point without a surface near may not have been searched for many steps.
            let touched = point.free_distance <= 0.0;
            (point.last_search_displacement, point.obstacle_displacement) = (way, self.swept);
            let mut soaked = soaked.get_mut(k);
            if let (Some(soaked), false) = (&mut soaked, touched) {
                **soaked = PoreContactState::NEW;
            }
            let seen = detect_contacts(rocks, horizon, x, point, room);
            if !seen.acts() {
                (point.force, point.spring) = ([0.0; D], [0.0; D]);
                soaked.into_iter().for_each(|soaked| *soaked = PoreContactState::NEW);
                continue;
            }
            let modulus = moduli.get_or_insert_with(|| {
                let mut moduli = [0.0; BLOCK_SIZE];
                let end = (first + BLOCK_SIZE).min(self.stress.len());
                self.material.wave_moduli(&self.stress[first..end], states, &mut moduli[..end - first]);
                moduli
            })[k];
            let h = self.domain.spacing(p, &self.background.grid_view());
            let grip = ObstacleSprings {
                place: *x,
                displacement: moved,
                was_near: touched,
                stiffness: self.stiffness * modulus * self.volume[p] / (h * h),
                area: self.volume[p] / (2.0 * point.half),
            };
            grip.apply(rocks, &seen, point, &mut room.sums);
            if let (Some(soaked), Some(fluid)) = (soaked, &self.fluid) {
                let modulus = fluid.bulk_modulus / fluid.porosity_at(self.volume[p], self.initial_volume[p]);
                let stiffness = self.stiffness * modulus * self.volume[p] / (h * h);
                let wet = ObstacleSprings { stiffness, ..grip };
                wet.pore_fluid_contact(rocks, &seen, fluid.min_pressure, (point, soaked), &mut room.sums);
            }
        }
    }
}
