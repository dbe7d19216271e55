//! Removal shapes (cuts) of the case: shapes that move and remove the points that they cover (sheet: snow-mpm A5).

use std::sync::Arc;

use colluvium_case::SolverError;
use colluvium_case::description::{RemovalShape, SweptRegion};

use crate::points::bodies::BodyPoints;
use crate::solver::SnowSolver;

impl<const D: usize> SnowSolver<D> {
    /// Removes the points that the cuts have covered in the last step of length `dt` (s), and records their mass and energy.
    ///
    /// # Errors
    /// When the first cut finds a weak layer that has yielded at rest.
    pub(super) fn apply_removal_shapes(&mut self, dt: f64) -> Result<(), SolverError> {
        let case = Arc::clone(&self.case);
        for (number, cut) in case.removal_shapes.iter().enumerate() {
            let Some(begun) = self.start_time_of(cut) else { continue };
            let (from, to) = (self.clock.time - dt - begun, self.clock.time - begun);
            if !cut.is_active_between(from, to) {
                continue;
            }
            if self.energy_balance.removals().iter().all(|taken| taken.cut_displacement == 0.0) {
                self.check_rest(cut)?;
            }
            self.energy_balance.removal(number).cut_displacement +=
                cut.speed() * (cut.moving_time(to) - cut.moving_time(from));
            let sweep = cut.swept_region(from, to, &self.cut_bounds[number]);
            let takes = |body: &BodyPoints<D>| cut.applies_to(&case.bodies[body.number as usize].name);
            let mass = self.mass_in_region(&sweep, takes);
            if mass > 0.0 {
                let keeps = |body: &BodyPoints<D>, i: usize| {
                    !(takes(body) && sweep.contains(&body.points.position[i]))
                };
                let energy = self.retain(keeps);
                let taken = self.energy_balance.removal(number);
                taken.mass += mass;
                taken.energy += energy;
            }
        }
        Ok(())
    }

    /// Time to which the times of a cut refer (s); `None` if its stage is not the current one.
    fn start_time_of(&self, cut: &RemovalShape) -> Option<f64> {
        match &cut.stage {
            None => Some(0.0),
            Some(name) => {
                (self.case.stages[self.clock.stage].name == *name).then_some(self.clock.stage_start)
            }
        }
    }

    /// Mass of the points in the swept region of a cut (kg).
    fn mass_in_region(&self, sweep: &SweptRegion<'_>, takes: impl Fn(&BodyPoints<D>) -> bool) -> f64 {
        let mut mass = 0.0;
        for body in self.bodies.bodies.iter().filter(|body| takes(body)) {
            let points = body.points.position.iter().zip(&body.points.mass);
            mass += points.filter(|(place, _)| sweep.contains(place)).map(|(_, mass)| mass).sum::<f64>();
        }
        mass
    }
}
