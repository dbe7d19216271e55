//! Particles that a program adds or removes between two steps.

use std::ops::Range;

use colluvium_case::{CaseError, GRAIN_COLUMNS, OVERLAP_TOLERANCE, PointList, removed_points};

use crate::points::particles::{ParticleGroup, Particles};
use crate::setup::bodies::{add_body, check_distances};
use crate::solver::SphSolver;

impl<const D: usize> SphSolver<D> {
    /// Adds particles to a body that is not rigid, by its index in [`colluvium_case::Case::bodies`], between two steps. Positions (m) are
    /// relative to the origin of the domain. What the list leaves out is as at the start of the case: the density of the material, and the
    /// velocity and the stress of the body at that position. Velocities are those at [`SphSolver::velocity_time`]. Returns the numbers of
    /// the particles, which no other particles have had.
    ///
    /// # Errors
    /// An invalid value of the list, by its path; a position outside the domain, in a wall, in an obstacle or at that of another particle;
    /// a body that is rigid, has loads or has no particles left; the total-Lagrangian formulation. The state is then unchanged.
    pub fn add_points(&mut self, body: u32, points: &PointList) -> Result<Range<u32>, CaseError> {
        let case = self.setting.case.clone();
        case.check_added_points(body as usize, points, D)?;
        points.reject_columns(&GRAIN_COLUMNS, "sph")?;
        let (index, first) = (self.growing_group(body)?, self.bodies.next_id);
        if points.positions.is_empty() {
            return Ok(first..first);
        }
        let (options, mut added) = (&self.setting.options, Particles::default());
        let as_added = |error: CaseError| error.of_added_points(body as usize);
        let group =
            add_body(&case, options, (body as usize, Some(points)), first, &mut added).map_err(as_added)?;
        case.reject_added_in_obstacles(&added.position, OVERLAP_TOLERANCE * options.spacing)?;
        self.check_free_positions(&added).map_err(as_added)?;
        let (particles, count) = (&mut self.bodies.particles, added.len());
        particles.previous.clear();
        if !particles.delayed_pressure.is_empty() {
            added.delayed_pressure = vec![0.0; count];
        }
        if !particles.body_force.is_empty() {
            added.body_force = vec![[0.0; D]; count];
        }
        self.bodies.insert(index, (&added, &group.states), &mut self.rates.derivatives);
        self.bodies.next_id += count as u32;
        self.number_has_changed();
        Ok(first..self.bodies.next_id)
    }

    /// Removes particles of bodies that are not rigid, by their numbers, between two steps.
    ///
    /// # Errors
    /// A number that no particle has, a particle of a rigid body, and the total-Lagrangian formulation. The state is then unchanged.
    pub fn remove_points(&mut self, ids: &[u32]) -> Result<(), CaseError> {
        if self.reference.is_some() {
            return Err(fixed_points_error());
        }
        let removed = removed_points(ids, self.particles().id().iter().copied())?;
        for group in self.bodies.groups.iter().filter(|group| group.rigid.is_some()) {
            let own = &self.bodies.particles.id[group.range()];
            if let Some(index) = ids.iter().position(|id| own.contains(id)) {
                let problem = format!("is a particle of the rigid body {:?}", self.name_of(group.body));
                return Err(CaseError::new(format!("ids[{index}]"), problem));
            }
        }
        if self.bodies.retain_where(|_, id| !removed.contains(&id), &mut self.rates.derivatives) {
            self.number_has_changed();
        }
        Ok(())
    }

    /// Index of the group of a body to which particles can be added.
    fn growing_group(&self, body: u32) -> Result<usize, CaseError> {
        if self.reference.is_some() {
            return Err(fixed_points_error());
        }
        let name = self.name_of(body);
        let refused = |problem: &str| Err(CaseError::new("body", format!("{name:?} {problem}")));
        let Some(index) = self.bodies.groups.iter().position(|group| group.body == body) else {
            return refused("has no particles left");
        };
        let ParticleGroup { rigid, .. } = &self.bodies.groups[index];
        if rigid.is_some() {
            return refused("is rigid: its mass is constant");
        }
        if self.bodies.loads.loads.iter().any(|load| load.body == body) {
            return refused("has loads on its surface, which added particles would change");
        }
        Ok(index)
    }

    /// Name of a body.
    fn name_of(&self, body: u32) -> &str {
        &self.setting.case.bodies[body as usize].name
    }

    /// Checks that added particles have no position of each other or of another particle.
    fn check_free_positions(&self, added: &Particles<D>) -> Result<(), CaseError> {
        let mut position = self.particles().position().to_vec();
        position.extend_from_slice(&added.position);
        check_distances(&position, &self.setting.options)
    }

    /// Discards what depends on the number of particles.
    fn number_has_changed(&mut self) {
        self.lists.listed_positions.positions.clear();
        self.state_has_changed();
    }
}

/// Error of the total-Lagrangian formulation.
fn fixed_points_error() -> CaseError {
    CaseError::new(
        "methods.sph.formulation",
        "`total-lagrangian` has the neighbours of the start: particles can be neither added nor removed",
    )
}
