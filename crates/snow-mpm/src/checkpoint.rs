//! Saving and restoring the solver, and the `Solver` face of it.

use std::io::{Read, Write};
use std::sync::Arc;

use colluvium_case::description::{Reset, Stage};
use colluvium_case::measure::Reading;
use colluvium_case::solver::{restore_value, save_value};
use colluvium_case::{
    Advance, Budget, Dataset, Equilibrium, Frame, Reaction, Solver, SolverError, TimeStep, Wanted,
};
use serde::{Deserialize, Serialize};

use crate::bodies::{Body, Failure};
use crate::ledger::{Ledger, Taken};
use crate::maps::Cell;
use crate::nodes::Sums;
use crate::solver::SnowSolver;
use crate::walls::Boundaries;

/// Version of the layout of a checkpoint.
const FORMAT: u32 = 7;

/// Depth of a point under an obstacle of which is told (cells).
const SUNK: f64 = 0.1;

/// What is no column.
#[derive(Serialize, Deserialize)]
struct Head {
    format: u32,
    dimension: usize,
    shape: String,
    time: f64,
    step: u64,
    limit: TimeStep,
    sums: Sums,
    external: f64,
    travel: f64,
    ledger: Ledger,
    maps: Option<Vec<Cell>>,
    /// Number, slabs and states of each body.
    bodies: Vec<(u32, Vec<usize>, Vec<u8>)>,
}

fn wrong(what: &str) -> SolverError {
    SolverError::Checkpoint(what.to_owned())
}

impl<const D: usize> SnowSolver<D> {
    fn head(&self) -> Head {
        let body = |body: &Body<D>| (body.number, body.slabs.clone(), body.material.save(&body.states));
        Head {
            format: FORMAT,
            dimension: D,
            shape: self.background.axis.name.to_owned(),
            time: self.clock.time,
            step: self.clock.step,
            limit: self.clock.limit,
            sums: self.clock.sums,
            external: self.clock.external,
            travel: self.bodies.travel,
            ledger: self.ledger.clone(),
            maps: self.maps.as_ref().map(|maps| maps.cells().to_vec()),
            bodies: self.bodies.all.iter().map(body).collect(),
        }
    }

    /// States of the laws, where they begin anew from the stresses that there are.
    fn reset_states(&mut self) -> Result<(), SolverError> {
        for number in 0..self.bodies.all.len() {
            let body = &self.bodies.all[number];
            let begun = body.law_points().begun_anew(|i| body.points.mass[i] / body.points.volume[i]);
            let (stress, states) =
                begun.map_err(|(index, reason)| self.failed(number, &Failure { index, reason }))?;
            self.bodies.all[number].points.stress = stress;
            self.bodies.all[number].states = states;
        }
        Ok(())
    }
}

impl<const D: usize> Solver for SnowSolver<D> {
    fn time(&self) -> f64 {
        self.clock.time
    }

    fn step_count(&self) -> u64 {
        self.clock.step
    }

    fn points(&self) -> usize {
        self.bodies.len()
    }

    fn limit(&mut self) -> TimeStep {
        self.clock.limit
    }

    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.clock.limit;
        let dt = limit.towards(at_most);
        self.advance(dt)?;
        Ok(Advance { dt, limit: limit.limit })
    }

    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        let fresh = start == self.clock.time;
        (self.clock.stage, self.clock.stage_start) = (stage, start);
        let case = Arc::clone(&self.case);
        self.keep(|body, _| !case.is_removed(&case.bodies[body.number as usize].name, stage));
        let obstacles = self.boundaries.obstacles();
        self.boundaries = Boundaries::new(&self.case, stage, &self.background, obstacles);
        if fresh {
            self.clock.external = 0.0;
        }
        Ok(())
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        self.look_at_weak_layers(stage);
        if stage.reset.is_empty() {
            return Ok(());
        }
        let before = self.stored();
        for reset in &stage.reset {
            match reset {
                Reset::Velocity => self.bodies.all.iter_mut().for_each(|body| {
                    body.points.velocity.fill([0.0; D]);
                    body.points.affine.fill([[0.0; D]; D]);
                }),
                Reset::Displacement => {
                    let all = self.bodies.all.iter_mut();
                    all.for_each(|body| body.points.origin.clone_from(&body.points.position));
                }
                Reset::State => self.reset_states()?,
            }
        }
        self.ledger.book(&before, &self.stored());
        self.set_paces();
        Ok(())
    }

    fn cell_size(&self) -> Option<f64> {
        Some(self.options.cell_size)
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        Some(self.measure_equilibrium())
    }

    fn readings(&self) -> Vec<Reading> {
        self.take_readings()
    }

    fn warning(&self) -> Option<String> {
        self.warning_of_rest()
    }

    fn remarks(&self) -> Vec<String> {
        let places: Vec<[f64; D]> =
            self.bodies.all.iter().flat_map(|body| &body.points.position).copied().collect();
        let slack = SUNK * self.background.grid.cell;
        let reason =
            "obstacles act on the nodes here, and what is within a cell is not seen (take smaller cells)";
        self.case.remark_on_covered(&places, slack, reason).into_iter().collect()
    }

    fn products(&self) -> Vec<Dataset> {
        let rasters = self.maps.as_ref().map_or_else(Vec::new, |maps| maps.rasters(&self.bodies));
        rasters.into_iter().map(Dataset::of_raster).collect()
    }

    fn travels_of_cuts(&self) -> Vec<Option<f64>> {
        self.ledger.cuts().iter().map(Taken::begun).collect()
    }

    fn reaction(&self, name: &str) -> Option<Reaction> {
        let number = self.obstacles.bearers().iter().position(|own| own == name)?;
        Some(self.ledger.borne(number))
    }

    fn dissipated(&self) -> Option<f64> {
        self.case.measures_dissipation().then(|| self.ledger.dissipated(&self.stored()))
    }

    fn frame(&self, _: Wanted) -> Frame {
        self.take_snapshot().into()
    }

    fn budget(&self) -> Option<Budget> {
        Some(self.take_budget())
    }

    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        save_value(&self.head(), out)?;
        for body in &self.bodies.all {
            body.points.write(out)?;
        }
        Ok(())
    }

    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        let head: Head = restore_value(input)?;
        if head.format != FORMAT || head.dimension != D || head.shape != self.background.axis.name {
            return Err(wrong("was written by another version or for another case"));
        }
        self.nodes.reset(&self.background.layout);
        self.bodies.all.retain(|body| head.bodies.iter().any(|(number, ..)| *number == body.number));
        if self.bodies.all.len() != head.bodies.len() {
            return Err(wrong("names bodies that the case does not have"));
        }
        for (body, (number, _, states)) in self.bodies.all.iter_mut().zip(&head.bodies) {
            body.points.read(input)?;
            let states = body.material.load(states).filter(|states| states.len() == body.points.len());
            body.states = states
                .filter(|_| body.number == *number)
                .ok_or_else(|| wrong("its arrays do not fit together"))?;
        }
        self.bodies.find_active_nodes(&mut self.background);
        // Since the sort points may have drifted, and the order of summation must stay what it was.
        for (body, (_, slabs, _)) in self.bodies.all.iter_mut().zip(head.bodies) {
            if slabs.len() != body.slabs.len() || slabs.last() != Some(&body.points.len()) {
                return Err(wrong("its slabs do not fit the case"));
            }
            body.slabs = slabs;
        }
        if head.ledger.cuts().len() != self.case.cuts.len() {
            return Err(wrong("counts other cuts than the case has"));
        }
        let restored = match (&mut self.maps, head.maps) {
            (Some(maps), Some(cells)) => maps.restore(cells).is_some(),
            (None, None) => true,
            _ => false,
        };
        if !restored {
            return Err(wrong("has rasters of other cells than the case"));
        }
        self.bodies.travel = head.travel;
        self.ledger = head.ledger;
        let clock = &mut self.clock;
        (clock.time, clock.step, clock.limit) = (head.time, head.step, head.limit);
        (clock.sums, clock.external) = (head.sums, head.external);
        Ok(())
    }
}
