//! The `Solver` face of the solver in ranks. What is not a step is done by a solver without ranks in the same state.

use std::io::{Read, Write};

use colluvium_case::description::Stage;
use colluvium_case::measure::Reading;
use colluvium_case::{
    Advance, Budget, Equilibrium, Field, FieldData, Frame, Reaction, Solver, SolverError, TimeStep, Wanted,
};

use super::{Rank, RankedSolver};
use crate::confinement::is_confined;
use crate::solver::SphSolver;

impl<const D: usize> RankedSolver<D> {
    /// Lets the solver without ranks do `work`.
    fn as_whole(
        &mut self,
        work: impl FnOnce(&mut SphSolver<D>) -> Result<(), SolverError>,
    ) -> Result<(), SolverError> {
        let mut whole = self.gather();
        work(&mut whole)?;
        let listed = !whole.lists.listed.positions.is_empty();
        self.give_to_first(whole);
        // After a restart neighbours are those that the checkpoint lists.
        if listed {
            let Rank { domain, .. } = &self.ranks[0];
            let (time, reach) = (domain.lists.listed.time, domain.lists.listed.reach);
            for rank in &mut self.ranks {
                let listed = &mut rank.domain.lists.listed;
                (listed.time, listed.reach) = (time, reach);
            }
            self.share_out()?;
        }
        Ok(())
    }

    /// The rank of each particle, by id.
    fn owners(&self) -> FieldData {
        let mut owners: Vec<(u32, f64)> = Vec::new();
        for (number, rank) in self.ranks.iter().enumerate() {
            owners.extend(rank.own().map(|i| (rank.domain.bodies.particles.id[i as usize], number as f64)));
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

    fn points(&self) -> usize {
        self.ranks.iter().map(|rank| rank.own().count()).sum()
    }

    fn limit(&mut self) -> TimeStep {
        self.critical_step()
    }

    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.critical_step();
        let dt = limit.towards(at_most);
        self.advance(dt)?;
        Ok(Advance { dt, limit: limit.limit })
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
        is_confined(&self.first().setting, &self.first().clock)
    }

    fn is_closed(&self) -> bool {
        self.gather().is_left_alone()
    }

    fn reaction(&self, name: &str) -> Option<Reaction> {
        self.first().reaction(name)
    }

    fn readings(&self) -> Vec<Reading> {
        self.gather().take_readings()
    }

    /// As without ranks, and the rank of each particle.
    fn frame(&self, _: Wanted) -> Frame {
        let mut snapshot = self.gather().take_snapshot();
        snapshot.fields.push(Field { name: "rank".to_owned(), unit: "", data: self.owners() });
        snapshot.into()
    }

    fn budget(&self) -> Option<Budget> {
        Some(self.gather().take_budget())
    }

    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        self.gather().save(out)
    }

    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        self.as_whole(|whole| whole.restore(input))
    }
}
