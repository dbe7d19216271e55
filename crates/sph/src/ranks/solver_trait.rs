//! `Solver` implementation of the solver in ranks. Everything but a step is done by a solver without ranks in the same state.

use std::io::{Read, Write};

use colluvium_case::description::Stage;
use colluvium_case::measure::ScalarOutput;
use colluvium_case::{
    Advance, Budget, Equilibrium, Field, FieldData, Frame, FrameRequest, Reaction, Solver, SolverError,
    TimeStep,
};

use crate::momentum::confining_pressure::is_confined;
use crate::ranks::{Rank, RankedSolver};
use crate::solver::SphSolver;

impl<const D: usize> RankedSolver<D> {
    /// Applies a function to a solver without ranks.
    fn with_single_solver(
        &mut self,
        work: impl FnOnce(&mut SphSolver<D>) -> Result<(), SolverError>,
    ) -> Result<(), SolverError> {
        let mut whole = self.gather();
        work(&mut whole)?;
        let listed = !whole.lists.listed_positions.positions.is_empty();
        self.move_to_first(whole);
        // After a restart the neighbours are those listed in the checkpoint.
        if listed {
            let Rank { domain, .. } = &self.ranks[0];
            let (time, reach) =
                (domain.lists.listed_positions.time, domain.lists.listed_positions.list_radius);
            for rank in &mut self.ranks {
                let listed = &mut rank.domain.lists.listed_positions;
                (listed.time, listed.list_radius) = (time, reach);
            }
            self.distribute()?;
        }
        Ok(())
    }

    /// Field of the rank of each particle, by id.
    fn owners(&self) -> FieldData {
        let mut owners: Vec<(u32, f64)> = Vec::new();
        for (number, rank) in self.ranks.iter().enumerate() {
            owners.extend(
                rank.own_particles().map(|i| (rank.domain.bodies.particles.id[i as usize], number as f64)),
            );
        }
        owners.sort_unstable_by_key(|(id, _)| *id);
        FieldData::Scalar(owners.into_iter().map(|(_, rank)| rank).collect())
    }
}

impl<const D: usize> Solver for RankedSolver<D> {
    fn time(&self) -> f64 {
        self.first().clock.time
    }

    fn step_count(&self) -> u64 {
        self.first().clock.step
    }

    fn point_count(&self) -> usize {
        self.ranks.iter().map(|rank| rank.own_particles().count()).sum()
    }

    fn limit(&mut self) -> TimeStep {
        self.critical_step()
    }

    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.critical_step();
        let dt = limit.limited_to(at_most);
        self.advance(dt)?;
        Ok(Advance { dt, limit: limit.limit })
    }

    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        self.with_single_solver(|whole| whole.begin_stage(stage, start))
    }

    fn resume_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        self.with_single_solver(|whole| whole.resume_stage(stage, start))
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        self.with_single_solver(|whole| whole.end_stage(stage))
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        self.gather().equilibrium()
    }

    fn ramps_are_complete(&self) -> bool {
        is_confined(&self.first().setting, &self.first().clock)
    }

    fn is_isolated(&self) -> bool {
        self.gather().is_energetically_closed()
    }

    fn reaction(&self, name: &str) -> Option<Reaction> {
        self.first().reaction(name)
    }

    fn scalar_outputs(&self) -> Vec<ScalarOutput> {
        self.gather().collect_scalar_outputs()
    }

    /// Output frame of the solver without ranks, with the rank of each particle.
    fn frame(&self, wanted: FrameRequest<'_>) -> Frame {
        let mut snapshot = self.gather().collect_snapshot(wanted);
        if wanted.includes("rank") {
            snapshot.fields.push(Field { name: "rank".to_owned(), unit: "", data: self.owners() });
        }
        snapshot.into()
    }

    fn budget(&self) -> Option<Budget> {
        Some(self.gather().collect_budget())
    }

    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        self.gather().save(out)
    }

    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        self.with_single_solver(|whole| whole.restore(input))
    }
}
