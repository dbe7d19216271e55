//! Points that a program adds or removes between two steps.

use std::ops::Range;

use colluvium_case::{CaseError, GRAIN_COLUMNS, OVERLAP_TOLERANCE, PointList, removed_points};

use crate::obstacles::obstacle_penalty::initialise_contact_states;
use crate::points::point_set::PointSet;
use crate::setup::bodies::point_set;
use crate::solver::MpmSolver;
use crate::stress::stress_work::stored_energies;

impl<const D: usize> MpmSolver<D> {
    /// Adds points to a deformable body, by its index in [`colluvium_case::Case::bodies`], between two steps. Positions (m) are relative to
    /// the origin of the domain. What the list leaves out is as at the start of the case: the density of the material, and the velocity,
    /// the stress and the pore pressure of the body at that position. Returns the numbers of the points, which no other points have had.
    ///
    /// # Errors
    /// An invalid value of the list, by its path; a position outside the domain or in an obstacle; a body that is rigid, has loads or has no
    /// points left; the total-Lagrangian formulation. The state is then unchanged.
    pub fn add_points(&mut self, body: u32, points: &PointList) -> Result<Range<u32>, CaseError> {
        let case = self.clock.case.clone();
        case.check_added_points(body as usize, points, D)?;
        points.reject_columns(&GRAIN_COLUMNS, "mpm")?;
        let index = self.growing_set(body)?;
        let first = self.bodies.next_id;
        if points.positions.is_empty() {
            return Ok(first..first);
        }
        let (options, wet) = (&self.clock.options, self.two_phase.is_some());
        let listed = (body as usize, Some(points));
        let mut added = point_set(&case, options, &self.background, listed, first as usize, wet)
            .map_err(|error| error.of_added_points(body as usize))?;
        case.reject_added_in_obstacles(&added.points.position, OVERLAP_TOLERANCE * options.cell_size)?;
        self.fill_columns(index, &mut added);
        self.bodies.next_id += added.len() as u32;
        self.bodies.sets[index].append(added);
        self.points_have_changed();
        Ok(first..self.bodies.next_id)
    }

    /// Removes points of deformable bodies, by their numbers, between two steps.
    ///
    /// # Errors
    /// A number that no point has, and a point of a rigid body. The state is then unchanged.
    pub fn remove_points(&mut self, ids: &[u32]) -> Result<(), CaseError> {
        let removed = removed_points(ids, self.points().id().iter().copied())?;
        for set in self.bodies.sets.iter().filter(|set| set.rigid.is_some()) {
            if let Some(index) = ids.iter().position(|id| set.points.id.contains(id)) {
                let name = &self.clock.case.bodies[set.body as usize].name;
                let problem = format!("is a point of the rigid body {name:?}");
                return Err(CaseError::new(format!("ids[{index}]"), problem));
            }
        }
        if !removed.is_empty() {
            self.bodies.retain_where(|points, i| !removed.contains(&points.id[i]));
            self.points_have_changed();
        }
        Ok(())
    }

    /// Index of the set of a body to which points can be added.
    fn growing_set(&self, body: u32) -> Result<usize, CaseError> {
        let refused = |problem: &str| {
            let name = &self.clock.case.bodies[body as usize].name;
            Err(CaseError::new("body", format!("{name:?} {problem}")))
        };
        let Some(index) = self.bodies.sets.iter().position(|set| set.body == body) else {
            return refused("has no points left");
        };
        let set = &self.bodies.sets[index];
        if set.rigid.is_some() {
            return refused("is rigid: its mass is constant");
        }
        if !set.loads.is_empty() {
            return refused("has loads on its surface, which added points would change");
        }
        if set.domain.are_anchored() {
            return refused("is in the total-Lagrangian formulation, whose points are those of the start");
        }
        Ok(index)
    }

    /// Fills the columns of added points that the set at `index` uses beside those of the start.
    fn fill_columns(&self, index: usize, added: &mut PointSet<D>) {
        let (present, count) = (&self.bodies.sets[index], added.len());
        if let Some(obstacles) = &self.boundary.penalty_obstacles {
            initialise_contact_states(&self.background, obstacles, added);
        }
        if !present.points.work.is_empty() {
            added.points.work = stored_energies(added);
        }
        let zeros = |column: &[[f64; D]]| vec![[0.0; D]; if column.is_empty() { 0 } else { count }];
        added.points.traction = zeros(&present.points.traction);
        added.points.body_force = zeros(&present.points.body_force);
        if let (Some(pore), Some(present)) = (&mut added.pore, &present.pore) {
            pore.points.traction = zeros(&present.points.traction);
        }
    }

    /// Updates what depends on the number of points.
    fn points_have_changed(&mut self) {
        self.clock.limit = None;
        self.resize_point_buffers();
        self.sort();
    }
}
