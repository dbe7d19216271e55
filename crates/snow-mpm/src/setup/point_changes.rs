//! Points that a program adds or removes between two steps.

use std::ops::Range;

use colluvium_case::{CaseError, GRAIN_COLUMNS, OVERLAP_TOLERANCE, PointList, removed_points};

use crate::setup::body_points::body_points;
use crate::solver::SnowSolver;
use colluvium_case::CaseErrorKind;

impl<const D: usize> SnowSolver<D> {
    /// Adds points to a body, by its index in [`colluvium_case::Case::bodies`], between two steps. Positions (m) are relative to the origin
    /// of the domain. What the list leaves out is as at the start of the case: the density of the material, and the velocity and the stress
    /// of the body at that position. Their energy counts as removed energy in the energy balance, negative. Returns the numbers of the
    /// points, which no other points have had.
    ///
    /// # Errors
    /// An invalid value of the list, by its path; a position outside the domain or in an obstacle; a body that has no points left. The state
    /// is then unchanged.
    pub fn add_points(&mut self, body: u32, points: &PointList) -> Result<Range<u32>, CaseError> {
        let case = self.case.clone();
        case.check_added_points(body as usize, points, D)?;
        points.reject_columns(&GRAIN_COLUMNS, "snow-mpm")?;
        let Some(index) = self.bodies.bodies.iter().position(|own| own.number == body) else {
            let problem = format!("{:?} has no points left", case.bodies[body as usize].name);
            return Err(CaseError::new("body", CaseErrorKind::coded("empty-body", problem)));
        };
        let first = self.bodies.next_id;
        if points.positions.is_empty() {
            return Ok(first..first);
        }
        let listed = (body as usize, Some(points));
        let mut added = body_points(&case, &self.options, &self.background, listed, first as usize)
            .map_err(|error| error.of_added_points(body as usize))?;
        let tolerance = OVERLAP_TOLERANCE * self.options.cell_size;
        case.reject_added_in_obstacles(&added.points.position, tolerance)?;
        if self.body_force.is_some() {
            added.points.body_force = vec![[0.0; D]; added.points.len()];
        }
        self.settle_changes();
        let before = self.stored_energies();
        self.nodes.reset(&self.background.layout);
        self.bodies.next_id += added.points.len() as u32;
        self.bodies.bodies[index].append(added);
        self.bodies.sort(&mut self.background);
        self.energy_balance.add_change(&before, &self.stored_energies());
        self.update_step_bounds();
        Ok(first..self.bodies.next_id)
    }

    /// Removes points, by their numbers, between two steps. Their energy counts as removed energy in the energy balance.
    ///
    /// # Errors
    /// A number that no point has. The state is then unchanged.
    pub fn remove_points(&mut self, ids: &[u32]) -> Result<(), CaseError> {
        let removed = removed_points(ids, self.points().id().iter().copied())?;
        self.settle_changes();
        self.retain(|body, i| !removed.contains(&body.points.id[i]));
        Ok(())
    }
}
