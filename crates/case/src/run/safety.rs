//! Factors of safety by strength reduction (sheet: sph §3.5; Bui & Nguyen 2021, section 4.1): trials from one
//! state at rest, bisected between a factor at which the bodies come to rest again and one at which they do not.

use serde_json::{Value, json};

use super::folder::trials;
use super::{RunError, RunOptions};
use crate::description::{FactorOfSafety, Stage};
use crate::output::Table;
use crate::{Case, Method, Snapshot, Solver};

/// Steps between two looks at a trial.
const STEPS_PER_LOOK: u64 = 50;
/// Kinetic energy over its peak below which the bodies rest (sheet: sph §3.5).
const REST: f64 = 1e-4;
/// Kinetic energy over `M g H` below which the bodies rest whatever the peak: that of the sheet's largest
/// velocity of a geostatic state, `1e-4 √(gH)`.
const STILL: f64 = 5e-9;
/// Share of a trial's duration during which the bodies must rest.
const HOLD: f64 = 0.1;
/// Share of the height by which the bodies may move (sheet: sph §3.5).
const MOST_MOVED: f64 = 0.1;
/// Share of the points that must have moved so far: single loose points are no failure.
const MOVED_SHARE: f64 = 0.01;

/// What a trial found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// The factor by which strength was divided.
    pub factor: f64,
    /// Whether the bodies failed.
    pub failed: bool,
    /// Duration until that was clear (s).
    pub time: f64,
    /// Displacement that a hundredth of the points exceed (m).
    pub displacement: f64,
    /// Kinetic energy at the end over its peak.
    pub kinetic_ratio: f64,
}

/// A factor of safety and how it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Safety {
    /// The largest factor with which the bodies came to rest, zero where none did.
    pub stable: f64,
    /// The least with which they failed, infinite where none did.
    pub failed: f64,
    /// The trials, in their order.
    pub trials: Vec<Trial>,
}

impl Safety {
    /// The factor of safety, the middle of what is left; `None` where the range does not hold it.
    pub fn factor(&self) -> Option<f64> {
        (self.stable > 0.0 && self.failed.is_finite()).then_some(0.5 * (self.stable + self.failed))
    }

    /// The trials as a table.
    pub fn table(&self) -> Table {
        let columns =
            [("factor", ""), ("failed", ""), ("time", "s"), ("displacement", "m"), ("kinetic_ratio", "")];
        let row = |t: &Trial| vec![t.factor, f64::from(t.failed), t.time, t.displacement, t.kinetic_ratio];
        Table {
            columns: columns.map(|(name, unit)| (name.to_owned(), unit.to_owned())).to_vec(),
            rows: self.trials.iter().map(row).collect(),
        }
    }

    /// What the summary of a run says of it.
    pub(super) fn to_json(&self) -> Value {
        json!({
            "factor": self.factor(),
            "stable": (self.stable > 0.0).then_some(self.stable),
            "failed": self.failed.is_finite().then_some(self.failed),
            "trials": self.trials.len(),
        })
    }
}

/// The trials of a search that was interrupted: those in its table.
fn done(options: &RunOptions, name: &str) -> Result<Vec<Trial>, RunError> {
    let Some(table) = options.out.as_ref().map(|out| out.join(trials(name))) else { return Ok(Vec::new()) };
    if !options.resume || !table.exists() {
        return Ok(Vec::new());
    }
    let trial = |row: &Vec<f64>| match row[..] {
        [factor, failed, time, displacement, kinetic_ratio] => {
            Some(Trial { factor, failed: failed != 0.0, time, displacement, kinetic_ratio })
        }
        _ => None,
    };
    Ok(Table::read(&table)?.rows.iter().filter_map(trial).collect())
}

/// Searches for the factor of safety from the state `rest` of the solver at the end of the stage `after`; `None` when
/// it is asked to stop. Trials that a resumed search has done are not run again.
///
/// # Errors
/// When a trial cannot be built or its solver cannot go on.
pub(super) fn search(
    method: &dyn Method,
    case: &Case,
    (name, search): (&str, &FactorOfSafety),
    rest: &[u8],
    options: &RunOptions,
) -> Result<Option<Safety>, RunError> {
    let done = done(options, name)?;
    let mut safety = Safety { stable: 0.0, failed: f64::INFINITY, trials: Vec::new() };
    let [low, high] = search.range;
    let mut next = Some(low);
    while let Some(factor) = next {
        let trial = match done.iter().find(|trial| trial.factor == factor) {
            Some(trial) => Some(*trial),
            None => run_trial(method, &search.trial(case, name, factor), search, rest, options).map_err(
                |error| RunError::Trial { measure: name.to_owned(), factor, source: Box::new(error) },
            )?,
        };
        let Some(trial) = trial else { return Ok(None) };
        let bound = if trial.failed { &mut safety.failed } else { &mut safety.stable };
        *bound = factor;
        safety.trials.push(Trial { factor, ..trial });
        if let Some(out) = &options.out {
            let about = "trials of a search for a factor of safety; failed is 1 or 0";
            safety.table().write(&out.join(trials(name)), about)?;
        }
        next = if safety.stable == 0.0 {
            None
        } else if safety.failed.is_infinite() {
            (factor < high).then_some(high)
        } else {
            let open = safety.failed - safety.stable > search.tolerance * (1.0 + 1e-9);
            open.then_some(0.5 * (safety.stable + safety.failed))
        };
    }
    Ok(Some(safety))
}

fn run_trial(
    method: &dyn Method,
    case: &Case,
    search: &FactorOfSafety,
    rest: &[u8],
    options: &RunOptions,
) -> Result<Option<Trial>, RunError> {
    let stage = case.stages.len() - 1;
    let weak = case.weakened(stage).map_err(crate::CaseErrors::one)?;
    let mut solver = method.build(&weak).map_err(crate::CaseErrors::one)?;
    solver.restore(&mut &*rest)?;
    let start = solver.time();
    solver.begin_stage(stage, start)?;
    let places = solver.snapshot();
    let gravity = case.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let still = STILL * solver.budget().mass * gravity * search.height;
    let (mut peak, mut rested) = (0.0_f64, 0.0);
    let mut trial = Trial { factor: 0.0, failed: true, time: 0.0, displacement: 0.0, kinetic_ratio: 0.0 };
    loop {
        if super::asked_to_stop(options) {
            return Ok(None);
        }
        let before = trial.time;
        let over = advance(&mut *solver, &case.stages[stage], start)?;
        trial.time = solver.time() - start;
        // Points may keep motion that the grid does not see, and nothing brakes.
        let kinetic = solver.equilibrium().map_or_else(|| solver.budget().kinetic, |e| e.kinetic);
        peak = peak.max(kinetic);
        trial.kinetic_ratio = if peak > 0.0 { kinetic / peak } else { 0.0 };
        let moved = moved(&solver.snapshot(), &places);
        let growing = moved > trial.displacement;
        trial.displacement = moved;
        if moved > MOST_MOVED * search.height && growing && kinetic > still {
            return Ok(Some(trial));
        }
        rested = if kinetic < (REST * peak).max(still) { rested + (trial.time - before) } else { 0.0 };
        if rested >= HOLD * search.duration || (over && rested > 0.0) {
            return Ok(Some(Trial { failed: false, ..trial }));
        }
        if over {
            return Ok(Some(trial));
        }
    }
}

/// Some steps of a stage that began at `start`, at most until its end; whether it is reached.
fn advance(solver: &mut dyn Solver, stage: &Stage, start: f64) -> Result<bool, RunError> {
    for _ in 0..STEPS_PER_LOOK {
        let limit = super::steps::stable_step(solver, stage, start + stage.duration)?;
        let left = start + stage.duration - solver.time();
        if super::steps::is_there(left, limit.dt.min(stage.duration)) {
            return Ok(true);
        }
        solver.step(left)?;
    }
    Ok(false)
}

/// The displacement that a hundredth of the points exceed (m), of those that are there both times, by their ids.
fn moved(now: &Snapshot, before: &Snapshot) -> f64 {
    let apart = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    let mut known = before.ids.iter().zip(&before.positions).peekable();
    let mut all: Vec<f64> = Vec::with_capacity(now.ids.len());
    for (id, place) in now.ids.iter().zip(&now.positions) {
        while known.next_if(|(known, _)| *known < id).is_some() {}
        all.extend(known.next_if(|(known, _)| *known == id).map(|(_, was)| apart(place, was)));
    }
    let rank = (MOVED_SHARE * all.len() as f64) as usize;
    if all.is_empty() {
        return 0.0;
    }
    let (_, value, _) = all.select_nth_unstable_by(rank, |a, b| b.total_cmp(a));
    *value
}

#[cfg(test)]
mod tests;
