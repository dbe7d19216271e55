//! Penalty contact of points with obstacles (docs/theory/mpm.md, obstacles).
//!
//! Forces depend on the positions of points at the start of a step and are scattered with their stresses, before the momentum solve. The
//! sliding displacement of a point is its displacement since the previous step.

use colluvium_constitutive::{BLOCK_SIZE, Material, StateBlock, States, SymTensor};
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
use colluvium_case::Warning;

/// Number of blocks in a task.
const BLOCKS_PER_TASK: usize = 4;

/// Initialises the contact states of the points and the workspaces.
pub fn initialise_penalty<const D: usize>(
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    obstacles: &mut Option<Box<PenaltyObstacles<D>>>,
) {
    let Some(obstacles) = obstacles else { return };
    for set in bodies.sets.iter_mut().filter(|set| set.rigid.is_none()) {
        initialise_contact_states(background, obstacles, set);
    }
    fit_workspaces(bodies, obstacles);
}

/// Initialises the contact states of the points of a deformable body.
pub fn initialise_contact_states<const D: usize>(
    background: &BackgroundGrid<D>,
    obstacles: &PenaltyObstacles<D>,
    set: &mut PointSet<D>,
) {
    let half = |p: usize| {
        let radius = if background.axisymmetric { set.points.position[p][0] } else { 1.0 };
        0.5 * (set.points.initial_volume[p] / radius).powf(1.0 / D as f64)
    };
    set.points.obstacle_contact =
        (0..set.len()).map(|p| obstacles.initial_penalty_state(&set.points.position[p], half(p))).collect();
    if let Some(pore) = &mut set.pore {
        pore.points.obstacle_contact = vec![PoreContactState::NEW; pore.points.len()];
    }
}

/// Resizes the workspaces of the obstacles to the largest body.
pub fn fit_workspaces<const D: usize>(bodies: &Bodies<D>, obstacles: &mut PenaltyObstacles<D>) {
    let blocks = bodies.deformable_sets().map(|set| set.len().div_ceil(BLOCK_SIZE)).max();
    obstacles.resize_workspaces(blocks.unwrap_or(0));
}

/// Computes the forces of obstacles on points at the start of a step of `dt` (s).
pub fn penalty_forces<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    obstacles: &mut Option<Box<PenaltyObstacles<D>>>,
) {
    let Some(all) = obstacles else { return };
    all.advance(clock.time);
    for set in bodies.sets.iter_mut().filter(|set| set.rigid.is_none()) {
        let PointSet { points, states, material, domain, pore, .. } = set;
        let PointColumns { obstacle_contact, position, origin, stress, volume, initial_volume, .. } = points;
        let input = PenaltyInput {
            material: &**material,
            position,
            origin,
            stress,
            volume,
            initial_volume,
            domain: domain.as_slice(),
            background,
            stiffness: clock.options.obstacle_stiffness,
            max_obstacle_displacement: all.history.max_obstacle_displacement,
            fluid: pore.as_ref().and_then(|pore| pore.fluid),
        };
        let pore_contact = pore.as_mut().map(|pore| &mut pore.points.obstacle_contact[..]);
        let blocks = obstacle_contact.len().div_ceil(BLOCK_SIZE);
        input.update_blocks(all, (obstacle_contact, pore_contact), states);
        let PenaltyObstacles { obstacles, workspaces, history, .. } = &mut **all;
        for workspace in &workspaces[..blocks] {
            history.penetrations += workspace.penetrations;
            for (obstacle, sums) in obstacles.iter_mut().zip(&workspace.sums) {
                obstacle.state.add_block_forces(sums, clock.dt);
            }
        }
    }
}

/// Sets the displacements of points to zero, with their current positions as reference.
pub fn reset_displacements<const D: usize>(bodies: &mut Bodies<D>) {
    for set in &mut bodies.sets {
        for ((point, x), origin) in
            set.points.obstacle_contact.iter_mut().zip(&set.points.position).zip(&set.points.origin)
        {
            (0..D).for_each(|c| point.last_search_displacement[c] -= x[c] - origin[c]);
        }
    }
}

/// Warning on points whose centres have been in obstacles.
pub fn penetration_warning<const D: usize>(obstacles: Option<&PenaltyObstacles<D>>) -> Option<Warning> {
    let count = obstacles.map_or(0, |obstacles| obstacles.history.penetrations);
    (count > 0).then(|| {
        Warning::new("obstacle-penetration", format!(
            "centres of points have been inside an obstacle ({count} points, counted in every step), although \
             points are stopped at its surface. Check where the obstacle is thinner or more curved than a \
             cell (take smaller cells, or a shorter step)"
        ))
    })
}

/// Energies of obstacles that act on points (J).
pub struct PenaltyEnergies {
    /// Work of friction since the start (J).
    pub friction: f64,
    /// Energy of the contact springs.
    pub spring_energy: f64,
    /// Energy removed by the penetration limit since the start.
    pub penetration_loss: f64,
    /// Work of the motion of obstacles (J); `None` if no obstacle moves.
    pub work: Option<f64>,
}

/// Energies of the obstacles that act on points; `None` if there are none.
pub fn penalty_energies<const D: usize>(obstacles: Option<&PenaltyObstacles<D>>) -> Option<PenaltyEnergies> {
    let obstacles = &obstacles?.obstacles;
    let sum = |of: fn(&ObstacleReaction) -> f64| obstacles.iter().map(|obstacle| of(&obstacle.state)).sum();
    let moves = obstacles.iter().any(|obstacle| obstacle.motion.is_some());
    Some(PenaltyEnergies {
        friction: sum(|state| state.friction),
        spring_energy: sum(|state| state.spring_energy),
        penetration_loss: sum(|state| state.stopping_energy),
        work: moves.then(|| sum(|state| state.work)),
    })
}

/// Data for the penalty forces that all points of a set have in common.
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
    max_obstacle_displacement: f64,
    /// Pore fluid of the set, if any.
    fluid: Option<PoreFluidConstants>,
}

impl<const D: usize> PenaltyInput<'_, D> {
    /// Computes the penalty forces on all points of a set in parallel, and the contact states of the pore fluid if the set has one.
    fn update_blocks(
        &self,
        all: &mut PenaltyObstacles<D>,
        (points, pore): (&mut [PenaltyState<D>], Option<&mut [PoreContactState<D>]>),
        states: &States,
    ) {
        let PenaltyObstacles { obstacles, workspaces, horizon, .. } = all;
        let (obstacles, horizon) = (&obstacles[..], *horizon);
        let update = |block: usize,
                      points: &mut [_],
                      pore: &mut [_],
                      states: &_,
                      workspace: &mut BlockWorkspace<D>| {
            workspace.sums.fill(ObstacleForces::default());
            workspace.penetrations = 0;
            self.block(obstacles, horizon, block * BLOCK_SIZE, (points, pore), states, workspace);
        };
        let blocks = points.par_chunks_mut(BLOCK_SIZE).zip(states.blocks()).zip(&mut *workspaces);
        match pore {
            Some(pore) => {
                let blocks = blocks.zip(pore.par_chunks_mut(BLOCK_SIZE)).enumerate();
                blocks.with_min_len(BLOCKS_PER_TASK).for_each(
                    |(block, (((points, states), workspace), pore))| {
                        update(block, points, pore, states, workspace);
                    },
                );
            }
            None => blocks.enumerate().with_min_len(BLOCKS_PER_TASK).for_each(
                |(block, ((points, states), workspace))| {
                    update(block, points, &mut [], states, workspace);
                },
            ),
        }
    }

    /// Computes the penalty forces on the points of a group, from index `first` on.
    fn block(
        &self,
        obstacles: &[PenaltyObstacle<D>],
        horizon: f64,
        first: usize,
        (points, pore): (&mut [PenaltyState<D>], &mut [PoreContactState<D>]),
        states: &StateBlock,
        workspace: &mut BlockWorkspace<D>,
    ) {
        let mut moduli: Option<[f64; BLOCK_SIZE]> = None;
        for (k, point) in points.iter_mut().enumerate() {
            let p = first + k;
            let x = &self.position[p];
            let displacement: [f64; D] = std::array::from_fn(|c| x[c] - self.origin[p][c]);
            let moved: [f64; D] =
                std::array::from_fn(|c| displacement[c] - point.last_search_displacement[c]);
            let obstacle_motion = self.max_obstacle_displacement - point.obstacle_displacement;
            if square(&moved).sqrt() + obstacle_motion < point.free_distance {
                continue;
            }
            // A point without a surface near may not have been searched for many steps.
            let was_near = point.free_distance <= 0.0;
            point.last_search_displacement = displacement;
            point.obstacle_displacement = self.max_obstacle_displacement;
            let mut pore = pore.get_mut(k);
            if let (Some(pore), false) = (&mut pore, was_near) {
                **pore = PoreContactState::NEW;
            }
            let candidates = detect_contacts(obstacles, horizon, x, point, workspace);
            if !candidates.has_contact() {
                (point.force, point.spring) = ([0.0; D], [0.0; D]);
                pore.into_iter().for_each(|pore| *pore = PoreContactState::NEW);
                continue;
            }
            let modulus = moduli.get_or_insert_with(|| {
                let mut moduli = [0.0; BLOCK_SIZE];
                let end = (first + BLOCK_SIZE).min(self.stress.len());
                self.material.wave_moduli(&self.stress[first..end], states, &mut moduli[..end - first]);
                moduli
            })[k];
            let h = self.domain.spacing(p, &self.background.grid_view());
            let springs = ObstacleSprings {
                position: *x,
                displacement: moved,
                was_near,
                stiffness: self.stiffness * modulus * self.volume[p] / (h * h),
                area: self.volume[p] / (2.0 * point.half_width),
            };
            springs.apply(obstacles, &candidates, point, &mut workspace.sums);
            if let (Some(pore), Some(fluid)) = (pore, &self.fluid) {
                let modulus = fluid.bulk_modulus / fluid.porosity_at(self.volume[p], self.initial_volume[p]);
                let stiffness = self.stiffness * modulus * self.volume[p] / (h * h);
                let fluid_springs = ObstacleSprings { stiffness, ..springs };
                let (states, sums) = ((point, pore), &mut workspace.sums);
                fluid_springs.pore_fluid_contact(obstacles, &candidates, fluid.min_pressure, states, sums);
            }
        }
    }
}
