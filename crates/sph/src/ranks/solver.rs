//! The `Solver` face of the solver in ranks. What is not a step is done by a solver without ranks in the same state.

use colluvium_case::description::Stage;
use colluvium_case::measure::Reading;
use colluvium_case::{Budget, Equilibrium, Field, FieldData, Snapshot, Solver, SolverError, TimeStep};

use super::{Rank, RankedSolver};
use crate::solver::SphSolver;

impl<const D: usize> RankedSolver<D> {
    /// Lets the solver without ranks do `work`.
    fn as_whole(
        &mut self,
        work: impl FnOnce(&mut SphSolver<D>) -> Result<(), SolverError>,
    ) -> Result<(), SolverError> {
        let mut whole = self.gather();
        work(&mut whole)?;
        let listed = !whole.listed.positions.is_empty();
        self.give_to_first(whole);
        // After a restart neighbours are those that the checkpoint lists.
        if listed {
            let Rank { domain, .. } = &self.ranks[0];
            let (time, reach) = (domain.listed.time, domain.listed.reach);
            self.ranks
                .iter_mut()
                .for_each(|rank| (rank.domain.listed.time, rank.domain.listed.reach) = (time, reach));
            self.share_out()?;
        }
        Ok(())
    }

    /// The rank of each particle, by id.
    fn owners(&self) -> FieldData {
        let mut owners: Vec<(u32, f64)> = Vec::new();
        for (number, rank) in self.ranks.iter().enumerate() {
            owners.extend(rank.own().map(|i| (rank.domain.particles.id[i as usize], number as f64)));
        }
        owners.sort_unstable_by_key(|(id, _)| *id);
        FieldData::Scalar(owners.into_iter().map(|(_, rank)| rank).collect())
    }
}

impl<const D: usize> Solver for RankedSolver<D> {
    fn time(&self) -> f64 {
        self.first().time
    }

    fn step_count(&self) -> u64 {
        self.first().step
    }

    fn points(&self) -> usize {
        self.ranks.iter().map(|rank| rank.own().count()).sum()
    }

    fn time_step(&mut self) -> TimeStep {
        self.critical_step()
    }

    fn step(&mut self, dt: f64) -> Result<(), SolverError> {
        self.advance(dt)
    }

    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        self.as_whole(|whole| whole.begin_stage(stage, start))
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        self.as_whole(|whole| whole.end_stage(stage))
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        self.gather().equilibrium()
    }

    fn has_grown(&self) -> bool {
        self.first().is_confined()
    }

    fn readings(&self) -> Vec<Reading> {
        self.gather().take_readings()
    }

    /// As without ranks, and the rank of each particle.
    fn snapshot(&self) -> Snapshot {
        let mut snapshot = self.gather().take_snapshot();
        snapshot.fields.push(Field { name: "rank".to_owned(), unit: "", data: self.owners() });
        snapshot
    }

    fn budget(&self) -> Budget {
        self.gather().take_budget()
    }

    fn save(&self) -> Vec<u8> {
        self.gather().save()
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), SolverError> {
        self.as_whole(|whole| whole.restore(bytes))
    }
}
