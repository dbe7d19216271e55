//! Points of all bodies.

use std::sync::atomic::AtomicBool;

use colluvium_case::{FailureReason, SolverError, spatial};
use colluvium_grid::wrap_into_period;
use colluvium_points::ScratchBuffers;

use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::points::point_blocks::{BlockReport, BlockUpdateTask, PointBlock, SetProperties, Workspace};
use crate::points::point_set::{PointColumns, PointSet};

/// Points, body by body.
pub struct Bodies<const D: usize> {
    /// Point sets, one per body.
    pub(crate) sets: Vec<PointSet<D>>,
    /// Sum over the steps since the last sort of the largest move along an axis (m).
    pub(crate) travel_since_sort: f64,
    /// Whether points have left the domain in the step and must be removed; their position is NaN. Boxed, so that the data of a step are
    /// known to be constant.
    pub(crate) any_outside: Box<AtomicBool>,
    /// Largest mass of a point (kg).
    pub(crate) max_point_mass: f64,
    /// Number of the next point that is added.
    pub(crate) next_id: u32,
    scratch: ScratchBuffers,
}

impl<const D: usize> Bodies<D> {
    /// Returns points that are not sorted yet.
    pub fn new(sets: Vec<PointSet<D>>) -> Self {
        let count: usize = sets.iter().map(PointSet::len).sum();
        Self {
            sets,
            travel_since_sort: 0.0,
            any_outside: Box::default(),
            max_point_mass: 0.0,
            next_id: count as u32,
            scratch: ScratchBuffers::default(),
        }
    }

    /// Points of the deformable bodies.
    pub fn deformable_sets(&self) -> impl Iterator<Item = &PointSet<D>> {
        self.sets.iter().filter(|set| set.rigid.is_none())
    }

    /// Mass (kg) up to which a node is too light for a meaningful force.
    pub fn mass_cutoff(&self, clock: &Clock) -> f64 {
        clock.options.mass_cutoff() * self.max_point_mass
    }

    /// Sorts all points by cell.
    pub fn sort(&mut self, background: &BackgroundGrid<D>) {
        self.sets.iter_mut().for_each(|set| set.sort(&background.grid, &mut self.scratch));
        self.travel_since_sort = 0.0;
    }

    /// Finds active nodes and slab bounds from the sorted points.
    pub fn find_active_nodes(&mut self, background: &mut BackgroundGrid<D>) {
        background.layout.clear();
        for set in &mut self.sets {
            set.slabs = background.layout.add_points(&set.evaluation_positions());
        }
        self.max_point_mass =
            self.sets.iter().flat_map(|set| &set.points.mass).fold(0.0, |a: f64, &b| a.max(b));
    }

    /// Removes the points that have left the domain since the last call; returns whether there are any.
    pub fn remove_outside_points(&mut self) -> bool {
        let any_outside = std::mem::replace(self.any_outside.get_mut(), false);
        if any_outside {
            self.retain(|x| !x[0].is_nan());
        }
        any_outside
    }

    /// Removes the points for whose positions (m) the condition is false, and bodies without points.
    pub fn retain(&mut self, keep: impl Fn(&[f64; D]) -> bool) {
        self.retain_where(|points, i| keep(&points.position[i]));
    }

    /// Removes the points for whose index in the columns of their set the condition is false, and bodies without points.
    pub fn retain_where(&mut self, keep: impl Fn(&PointColumns<D>, usize) -> bool) {
        self.sets.iter_mut().for_each(|set| set.retain_where(&keep, &mut self.scratch));
        self.sets.retain(|set| set.len() > 0);
    }

    /// Moves points that have left through a periodic boundary to the opposite one.
    pub fn wrap_into_period(&mut self, background: &BackgroundGrid<D>) {
        if background.periodic == [false; D] {
            return;
        }
        let (low, high, periodic) = (background.grid.origin, background.upper_corner, background.periodic);
        let mut wrapped = false;
        for set in &mut self.sets {
            wrapped |=
                wrap_into_period([&low, &high], &periodic, &mut set.points.position, &mut set.points.origin);
        }
        if wrapped {
            // The points are in other slabs now.
            self.travel_since_sort = f64::INFINITY;
        }
    }

    /// Updates the points of all deformable bodies in parallel, in groups of up to `BLOCK_SIZE` points. Returns the largest displacement of
    /// a point along an axis (m).
    pub fn update_blocks<R>(
        &mut self,
        clock: &Clock,
        new_workspace: &(dyn Fn() -> Workspace<R> + Sync),
        update: impl Fn(&SetProperties<'_, D>, &mut PointBlock<'_, D>, &mut Workspace<R>) -> BlockReport + Sync,
    ) -> Result<f64, SolverError> {
        let Self { sets, any_outside, .. } = self;
        let mut moved = 0f64;
        for number in 0..sets.len() {
            let set = &mut sets[number];
            if set.rigid.is_some() {
                continue;
            }
            let material = set.material.clone();
            let body = &clock.case.bodies[set.body as usize];
            let properties = SetProperties {
                material: &*material,
                extent: set.extent,
                body: set.body,
                field: set.field,
                has_affine_field: !set.points.affine_velocity.is_empty(),
                reference_configuration: set.domain.are_anchored(),
                fluid: set.pore.as_ref().and_then(|pore| pore.fluid),
                is_fluid: clock.case.materials[&body.material].is_fluid(),
                remove_outside: body.remove_outside,
                any_outside,
            };
            let block = &|block: &mut PointBlock<'_, D>, workspace: &mut Workspace<R>| {
                update(&properties, block, workspace)
            };
            match set.as_block().update(&BlockUpdateTask { new_workspace, block }) {
                Ok(m) => moved = moved.max(m),
                Err(failure) => return Err(point_error(clock, &sets[number], failure.index, failure.reason)),
            }
        }
        Ok(moved)
    }
}

/// Error of a point of a set, with its position.
pub fn point_error<const D: usize>(
    clock: &Clock,
    set: &PointSet<D>,
    index: usize,
    reason: impl Into<FailureReason>,
) -> SolverError {
    let material = &clock.case.bodies[set.body as usize].material;
    SolverError::Point {
        step: clock.step,
        time: clock.time,
        point: u64::from(set.points.id[index]),
        position: spatial(&set.points.position[index]),
        reason: reason.into().of_material(material),
    }
}
