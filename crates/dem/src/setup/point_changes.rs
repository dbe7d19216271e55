//! Grains that a program adds or removes between two steps.

use std::ops::Range;

use colluvium_case::{CaseError, PointList, removed_points};

use crate::boundary::periodic_cell::inverse;
use crate::contact::contact_laws::GrainSizes;
use crate::points::grains::Grains;
use crate::setup::body_grains::added_grains;
use crate::setup::pair_laws;
use crate::setup::start_checks::check_step;
use crate::solver::DemSolver;
use crate::specimen::pluviation_entry::{distance_in_cell, nearby_grains};
use colluvium_case::CaseErrorKind;

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Adds grains to a body, by its index in [`colluvium_case::Case::bodies`], between two steps. Positions (m) are relative to the origin
    /// of the domain. The radii are those of the list, or those of its volumes; what else the list leaves out is as for a body with points
    /// from a file. The energy of the grains counts as a change between stages. Returns the numbers of the grains, which no other grains
    /// have had.
    ///
    /// # Errors
    /// An invalid value of the list, by its path; given numbers of grains; a position outside the domain; a grain in a wall or an obstacle,
    /// or one that overlaps another by more than `initial_overlap`; a body that has been removed or is a membrane. The state is then
    /// unchanged.
    pub fn add_points(&mut self, body: u32, points: &PointList) -> Result<Range<u32>, CaseError> {
        let (case, number, first) = (self.clock.case.clone(), body as usize, self.specimen.next_id);
        case.check_added_points(number, points, D)?;
        points.reject_columns(&["stresses", "pore_pressures"], "dem")?;
        self.check_growth(number, points)?;
        if points.positions.is_empty() {
            return Ok(first..first);
        }
        let mut added = added_grains::<D, R>(&case, &self.clock.options, number, points)
            .map_err(|error| error.of_added_points(number))?;
        self.check_overlaps_of(&added)?;
        let end = first + added.len() as u32;
        added.id = (first..end).collect();
        if !self.grains.body_force.is_empty() {
            added.body_force = vec![[0.0; D]; added.len()];
        }
        // An error of the present grains comes before the change.
        self.rebuild()?;
        let mut grains = self.grains.clone();
        grains.append(&mut added);
        self.set_sizes(GrainSizes::of_grains(&grains, self.laws.kinds.len()))?;
        (self.grains, self.specimen.next_id) = (grains, end);
        self.rebuild()?;
        Ok(first..end)
    }

    /// Makes the laws of the stage for grains of these sizes; an error where a fixed time step is too long for them, without a change.
    fn set_sizes(&mut self, sizes: GrainSizes) -> Result<(), CaseError> {
        let DemSolver { clock, laws, boundary, .. } = self;
        let stage = pair_laws::laws::<D>(&clock.case, &clock.options, &laws.kinds, &sizes, clock.stage)?;
        let before = std::mem::replace(&mut laws.stage, stage);
        if let Err(error) = check_step(clock, laws) {
            laws.stage = before;
            return Err(error);
        }
        laws.sizes = sizes;
        for wall in &mut boundary.walls {
            wall.laws.clone_from(&laws.stage.walls[wall.boundary]);
        }
        Ok(())
    }

    /// Removes grains with their contacts, by their numbers, between two steps. Their energy counts as a change between stages.
    ///
    /// # Errors
    /// A number that no grain has, and a grain of a membrane. The state is then unchanged.
    pub fn remove_points(&mut self, ids: &[u32]) -> Result<(), CaseError> {
        let removed = removed_points(ids, self.grains.id.iter().copied())?;
        if removed.is_empty() {
            return Ok(());
        }
        for (id, body) in self.grains.id.iter().zip(&self.grains.body) {
            if removed.contains(id)
                && let Some(problem) = self.membrane_problem(*body as usize)
            {
                let index = ids.iter().position(|own| own == id).unwrap_or(0);
                return Err(CaseError::new(format!("ids[{index}]"), problem));
            }
        }
        // An error of the present grains comes before the change.
        self.rebuild()?;
        let DemSolver { laws, grains, boundary, neighbours, .. } = self;
        neighbours
            .retain_grains(laws, grains, boundary.walls.len(), |grains, i| !removed.contains(&grains.id[i]));
        self.set_sizes(GrainSizes::of_grains(&self.grains, self.laws.kinds.len()))?;
        self.rebuild()
    }

    /// Checks that grains with these properties can be added to a body.
    fn check_growth(&self, body: usize, points: &PointList) -> Result<(), CaseError> {
        let name = &self.clock.case.bodies[body].name;
        if self.clock.case.is_removed(name, self.clock.stage) {
            return Err(CaseError::new("body", format!("{name:?} has been removed")));
        }
        if let Some(problem) = self.membrane_problem(body) {
            return Err(CaseError::new("body", problem));
        }
        if points.grains.ids.is_some() {
            let problem = CaseErrorKind::coded("conflicting-keys", "are given by the solver: leave them out");
            return Err(CaseError::new("points.grains.ids", problem));
        }
        Ok(())
    }

    /// Reason why the grains of a body cannot change, if it is a membrane.
    fn membrane_problem(&self, body: usize) -> Option<String> {
        let name = &self.clock.case.bodies[body].name;
        let is_membrane = self.clock.options.stages.values().any(|stage| stage.membranes.contains_key(name));
        is_membrane.then(|| format!("{name:?} is a membrane, whose grains form its rings"))
    }

    /// Checks that added grains overlap neither walls nor grains by more than is allowed at the start.
    fn check_overlaps_of(&self, added: &Grains<D, R>) -> Result<(), CaseError> {
        let allowed = self.clock.options.initial_overlap * (1.0 + 1e-9);
        let refuse = |i: usize, overlap: f64, other: &str| {
            let problem =
                format!("overlaps {other} by {overlap:.3} of the smaller radius, more than {allowed:.3}");
            Err(CaseError::new(format!("points.positions[{i}]"), CaseErrorKind::coded("overlap", problem)))
        };
        let (unit, _) = inverse(&self.cell.geometry.h);
        let distance = |a: &[f64; D], b: &[f64; D]| distance_in_cell((&self.cell.geometry, &unit), a, b);
        for i in 0..added.len() {
            let (x, radius) = (&added.position[i], added.radius[i]);
            let overlap = |y: &[f64; D], other: f64| (radius + other - distance(x, y)) / radius.min(other);
            let near = nearby_grains(&self.cell.geometry, &self.grains, (x, x), radius);
            for (grains, j) in near.iter().map(|j| (&self.grains, *j)).chain((0..i).map(|j| (added, j))) {
                let share = overlap(&grains.position[j], grains.radius[j]);
                if share > allowed {
                    return refuse(i, share, &format!("a grain at {:?} m", grains.position[j]));
                }
            }
            for wall in &self.boundary.walls {
                let distance = match wall.current_surface() {
                    None => wall.distance(x).0,
                    Some(surface) if surface.contains(x) => 0.0,
                    Some(surface) => surface.gap(x, radius).map_or(radius, |gap| gap.distance),
                };
                let share = 1.0 - distance / radius;
                if share > allowed {
                    return refuse(i, share, &format!("the wall {:?}", wall.name));
                }
            }
        }
        Ok(())
    }

    /// Rebuilds the lists after a change of the number of grains.
    fn rebuild(&mut self) -> Result<(), CaseError> {
        self.count_changes();
        self.boundary.membranes.clear();
        self.neighbours.since_build.cell = None;
        self.build_lists()
            .map_err(|error| CaseError::new("points", CaseErrorKind::coded(error.code(), error.to_string())))
    }
}

#[cfg(test)]
mod tests {
    use colluvium_case::{Body, Case, Domain, GrainColumns, PointList, Side, Space, Stage, Wall};
    use colluvium_constitutive::LinearElasticSpec;

    use crate::{Adhesion, Dem, DemOptions, Diameters, Fill, GrainKind, LatticePacking, NormalLaw, PairSpec};

    /// The rupture distance of a cohesive contact with a wall grows with the largest grain.
    #[test]
    fn walls_have_the_laws_of_added_grains() {
        let case = Case::new(Space::PlaneStrain, Domain::new([0.0, 0.0], [2.0, 2.0]))
            .material("sand", LinearElasticSpec::new(2650.0, 1e7, 0.3))
            .body(Body::block("block", "sand", [0.5, 0.5], [1.0, 1.0]))
            .wall(Side::YMin, Wall::frictional(0.5))
            .stage(Stage::new("rest", 0.1));
        let fill = Fill::Lattice { packing: LatticePacking::Square, pitch: None, jitter: 0.0 };
        let sand = GrainKind::filled(2650.0, Diameters::Equal { value: 0.1 }, fill);
        let pair = PairSpec::new(["sand", "sand"], NormalLaw::linear(1e6));
        let cohesion = Adhesion::Cohesive { tension: 1e3, shear: 1e3, fragile: true, new_contacts: true };
        let with_wall =
            PairSpec { adhesion: Some(cohesion), ..PairSpec::new(["sand", "y-min"], NormalLaw::linear(1e6)) };
        let options = DemOptions::new([("sand", sand)], [pair, with_wall]);
        let mut solver = Dem::new(options).solver::<2>(&case).unwrap();
        let before = solver.boundary.walls[0].laws.clone();
        let list = PointList {
            positions: vec![[1.6, 1.6, 0.0]],
            volumes: vec![0.1],
            grains: GrainColumns { radii: Some(vec![0.2]), ..GrainColumns::default() },
            ..PointList::default()
        };
        solver.add_points(0, &list).unwrap();
        let wall = &solver.boundary.walls[0];
        assert!(wall.laws != before);
        assert_eq!(wall.laws, solver.laws.stage.walls[wall.boundary]);
    }
}
