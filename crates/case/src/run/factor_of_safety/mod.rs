//! Factors of safety by strength reduction (after sheet: sph §3.5, whose criteria are others; Bui & Nguyen 2021, section 4.1): bisection by
//! trials from one state at rest, between a factor at which the bodies come to rest again and one at which they do not.

mod elastic_settling;
mod search_cost;
mod searches;
mod slope_scale;
mod strength_trial;

use std::path::PathBuf;

use serde_json::{Value, json};

use crate::description::FactorOfSafety;
use crate::output::{Table, WriteOptions, read_frame, write_frame};
use crate::run::factor_of_safety::elastic_settling::ElasticSettling;
use crate::run::factor_of_safety::slope_scale::SlopeScale;
use crate::run::factor_of_safety::strength_trial::{FailureCriterion, RunningTrial, WINDOWS, run_trial};
use crate::run::output::run_folder::{failing_points_file, trials};
use crate::run::{RunError, RunOptions};
use crate::{Case, CaseErrors, Method, Snapshot};
use colluvium_constitutive::Warning;

pub use crate::run::factor_of_safety::search_cost::SearchCost;
pub use crate::run::factor_of_safety::strength_trial::{StrengthTrial, TrialVerdict};

/// Unbalanced-force ratio below which bodies are at rest.
const REST_RATIO: f64 = 1e-3;

/// Factor of safety with the trials of its search.
#[derive(Clone, Debug, PartialEq)]
pub struct SafetyResult {
    /// Largest factor at which the bodies came to rest; zero without one.
    pub stable_factor: f64,
    /// Least factor at which the bodies failed; infinite without one.
    pub failing_factor: f64,
    /// Required width of the interval between the two factors.
    pub tolerance: f64,
    /// Height of the slope `H` (m), by which trials are judged.
    pub height: f64,
    /// Duration of a time window of a trial (s), after which it is evaluated.
    pub window: f64,
    /// Trials in the order in which they were run.
    pub trials: Vec<StrengthTrial>,
}

/// Outcome of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchOutcome {
    /// Factor of safety known to within the tolerance.
    Found,
    /// Undecided trials between the largest stable factor and the least failing one.
    Undecided,
    /// Failure of the bodies at the least factor of the range.
    BelowRange,
    /// Rest of the bodies at the largest factor of the range.
    AboveRange,
}

impl SearchOutcome {
    /// Name of the outcome in summaries.
    pub fn name(self) -> &'static str {
        match self {
            Self::Found => "found",
            Self::Undecided => "undecided",
            Self::BelowRange => "below the range",
            Self::AboveRange => "above the range",
        }
    }
}

/// Displacement of a stable trial over `γ H² / E` above which the slope has slid. Trials below the factor of safety move up to 0.3 times
/// that length.
const MAX_STABLE_DISPLACEMENT: f64 = 1.0;
/// Weight of the height over Young's modulus, `γ H / E`, above which the factor depends on the modulus: at 0.012 it is 3 % too high.
const MAX_SOFTNESS: f64 = 0.01;

impl SafetyResult {
    /// Outcome of the search.
    pub fn outcome(&self) -> SearchOutcome {
        let open = self.trials.iter().any(|trial| trial.verdict == TrialVerdict::Undecided);
        if self.stable_factor > 0.0 && self.failing_factor - self.stable_factor <= self.tolerance_reached() {
            SearchOutcome::Found
        } else if open {
            SearchOutcome::Undecided
        } else if self.failing_factor.is_infinite() {
            SearchOutcome::AboveRange
        } else {
            SearchOutcome::BelowRange
        }
    }

    /// Factor of safety, the middle of the remaining interval; `None` where it is outside the range or the search is undecided.
    pub fn factor(&self) -> Option<f64> {
        (self.outcome() == SearchOutcome::Found).then_some(0.5 * (self.stable_factor + self.failing_factor))
    }

    /// Code of the note about a search without a factor; `None` where it has one.
    pub fn note_code(&self) -> Option<&'static str> {
        match self.outcome() {
            SearchOutcome::Undecided => Some("search-undecided"),
            SearchOutcome::BelowRange | SearchOutcome::AboveRange => Some("search-out-of-range"),
            SearchOutcome::Found => None,
        }
    }

    /// Warnings about a factor that is probably too high.
    pub(crate) fn warnings(&self, name: &str) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let stable = self.trials.iter().filter(|trial| trial.verdict == TrialVerdict::Stable);
        let slid = stable.clone().find(|trial| trial.dimensionless_displacement > MAX_STABLE_DISPLACEMENT);
        if let Some(StrengthTrial { factor, displacement, dimensionless_displacement, .. }) = slid {
            let text = format!(
                "measures.{name}: the stable trial at {factor:.4} has moved {displacement:.3e} m, {dimensionless_displacement:.1} \
                 times γH²/E: the slope has slid and come to rest in another shape. Begin the range lower, so that trials \
                 below it decide"
            );
            warnings.push(Warning::new("slid-in-stable-trial", text));
        }
        // γH/E from the displacements with and without dimension.
        let softness =
            stable.map(|trial| trial.displacement / trial.dimensionless_displacement / self.height);
        let softness = softness.filter(|softness| softness.is_finite()).fold(0.0, f64::max);
        if softness > MAX_SOFTNESS {
            let text = format!(
                "measures.{name}: the weight of the slope's height is {:.1} % of Young's modulus. Soft slopes settle into \
                 a flatter shape, and their factor is too high. Give a Young's modulus of {:.0} times the present one or \
                 more: it has no influence on the strength",
                100.0 * softness,
                (softness / (0.3 * MAX_SOFTNESS)).ceil()
            );
            warnings.push(Warning::new("soft-slope", text));
        }
        warnings
    }

    /// Message about the outcome.
    pub fn message(&self) -> String {
        let Self { stable_factor, failing_factor, window, .. } = self;
        match (self.outcome(), self.factor()) {
            (SearchOutcome::Undecided, _) => {
                let open: Vec<String> =
                    self.undecided_factors().map(|factor| format!("{factor:.3}")).collect();
                let from = if *stable_factor > 0.0 {
                    format!("stable at {stable_factor:.3}")
                } else {
                    "no stable factor".to_owned()
                };
                let to = if failing_factor.is_finite() {
                    format!("failed at {failing_factor:.3}")
                } else {
                    "no failed factor".to_owned()
                };
                format!(
                    "undecided: {from}, {to}; at {} the bodies neither clearly failed nor came to rest \
                     within {:.3} s. Check the displacements of the trials: where they grow fast, the slope \
                     fails. A longer `duration`, finer points or a remedy for locking may decide it",
                    open.join(", "),
                    WINDOWS as f64 * window
                )
            }
            (SearchOutcome::BelowRange, _) => {
                format!(
                    "less than {failing_factor:.3}: the bodies fail with the smallest factor of the range. \
                     Lower the range, or check strength, water and initial stress"
                )
            }
            (SearchOutcome::AboveRange, _) => {
                format!(
                    "more than {stable_factor:.3}: the bodies come to rest with the largest factor of the \
                     range. Raise the range, or check that the failure fits into the domain"
                )
            }
            (SearchOutcome::Found, factor) => {
                let factor = factor.unwrap_or(f64::NAN);
                format!(
                    "factor of safety {factor:.3} (stable at {stable_factor:.3}, failed at {failing_factor:.3})"
                )
            }
        }
    }

    /// Tolerance of the ratio of the bracketing factors, with a margin for rounding.
    fn tolerance_reached(&self) -> f64 {
        self.tolerance * (1.0 + 1e-9)
    }

    /// Factors of undecided trials between the largest stable and the least failing factor.
    fn undecided_factors(&self) -> impl Iterator<Item = f64> {
        let open = self.trials.iter().filter(|trial| trial.verdict == TrialVerdict::Undecided);
        // Factors outside the remaining interval have been decided by later trials.
        open.map(|trial| trial.factor)
            .filter(|factor| self.stable_factor < *factor && *factor < self.failing_factor)
    }

    /// Factor of the next trial; `None` after the last one. The interval around undecided factors is narrowed from both sides.
    fn next_factor(&self, [low, high]: [f64; 2]) -> Option<f64> {
        let tried = |factor: f64| self.trials.iter().any(|trial| trial.factor == factor);
        if !tried(low) {
            return Some(low);
        }
        if self.stable_factor == 0.0 {
            return None;
        }
        if !tried(high) {
            return Some(high);
        }
        let (first, last) =
            self.undecided_factors().fold((f64::INFINITY, 0.0_f64), |(a, b), f| (a.min(f), b.max(f)));
        let gaps = match (first.is_finite(), self.failing_factor.is_finite()) {
            (false, false) => return None,
            (false, true) => vec![[self.stable_factor, self.failing_factor]],
            (true, false) => vec![[self.stable_factor, first]],
            (true, true) => vec![[self.stable_factor, first], [last, self.failing_factor]],
        };
        let open = gaps.into_iter().filter(|[a, b]| b - a > self.tolerance_reached());
        let widest = open.max_by(|[a, b], [c, d]| (b - a).total_cmp(&(d - c)));
        widest.map(|[a, b]| 0.5 * (a + b))
    }

    /// Adds a trial, and narrows the interval of the factor of safety by its verdict.
    fn add(&mut self, trial: StrengthTrial) {
        match trial.verdict {
            TrialVerdict::Stable => self.stable_factor = self.stable_factor.max(trial.factor),
            TrialVerdict::Failed => self.failing_factor = self.failing_factor.min(trial.factor),
            TrialVerdict::Undecided => {}
        }
        self.trials.push(trial);
    }

    /// Table of the trials.
    pub fn table(&self) -> Table {
        let columns = [
            ("factor", ""),
            ("failed", ""),
            ("undecided", ""),
            ("time", "s"),
            ("displacement", "m"),
            ("dimensionless_displacement", ""),
            ("unbalanced_force", ""),
        ];
        let row = |t: &StrengthTrial| {
            let is = |verdict: TrialVerdict| f64::from(t.verdict == verdict);
            let [failed, undecided] = [TrialVerdict::Failed, TrialVerdict::Undecided].map(is);
            let scaled = t.dimensionless_displacement;
            vec![t.factor, failed, undecided, t.time, t.displacement, scaled, t.unbalanced_force]
        };
        Table {
            columns: columns.map(|(name, unit)| (name.to_owned(), unit.to_owned())).to_vec(),
            rows: self.trials.iter().map(row).collect(),
        }
    }

    /// Entry of the search in the summary of a run.
    pub(super) fn to_json(&self) -> Value {
        json!({
            "outcome": self.outcome().name(),
            "told": self.message(),
            "factor": self.factor(),
            "stable": (self.stable_factor > 0.0).then_some(self.stable_factor),
            "failed": self.failing_factor.is_finite().then_some(self.failing_factor),
            "trials": self.trials.len(),
            "height": self.height,
            "window": self.window,
        })
    }
}

/// Inputs of a search.
pub(super) struct SearchContext<'a> {
    /// Method that runs the trials.
    pub method: &'a dyn Method,
    /// Case whose strength is reduced.
    pub case: &'a Case,
    /// Name of the measure.
    pub name: &'a str,
    /// Options of the search.
    pub search: &'a FactorOfSafety,
    /// State of the solver at rest, as bytes of a checkpoint.
    pub rest_state: &'a [u8],
    /// Options of the run.
    pub options: &'a RunOptions,
}

impl SearchContext<'_> {
    /// Whether the run was asked to stop.
    fn is_to_stop(&self) -> bool {
        self.options.stop_is_requested()
    }

    /// Builds a solver at rest in the last stage of the case of a trial.
    fn start_trial<'b>(&self, case: &'b Case) -> Result<RunningTrial<'b>, RunError> {
        let stage = case.stages.len() - 1;
        let weak = case.with_weakening(stage).map_err(CaseErrors::from_error)?;
        let mut solver = self.method.build(&weak).map_err(CaseErrors::from_error)?;
        solver.restore(&mut &*self.rest_state)?;
        let start_time = solver.time();
        solver.begin_stage(stage, start_time)?;
        let start = solver.snapshot();
        Ok(RunningTrial { solver, start, stage: &case.stages[stage], start_time })
    }

    /// Path of a file of the search in the folder of the run; `None` for a run without a folder.
    fn file(&self, name: fn(&str) -> String) -> Option<PathBuf> {
        Some(self.options.output_folder.as_ref()?.join(name(self.name)))
    }

    /// Reads the trials of an interrupted search from its table.
    fn finished_trials(&self) -> Result<Vec<StrengthTrial>, RunError> {
        let Some(table) = self.file(trials) else { return Ok(Vec::new()) };
        if !self.options.resume || !table.exists() {
            return Ok(Vec::new());
        }
        let trial = |row: &Vec<f64>| match row[..] {
            [factor, failed, undecided, time, displacement, scaled, unbalanced_force] => {
                let verdict = match (failed != 0.0, undecided != 0.0) {
                    (true, _) => TrialVerdict::Failed,
                    (false, true) => TrialVerdict::Undecided,
                    (false, false) => TrialVerdict::Stable,
                };
                let dimensionless_displacement = scaled;
                Some(StrengthTrial {
                    factor,
                    verdict,
                    time,
                    displacement,
                    dimensionless_displacement,
                    unbalanced_force,
                })
            }
            _ => None,
        };
        Ok(Table::read(&table)?.rows.iter().filter_map(trial).collect())
    }

    /// Error of a trial, with its factor.
    fn trial_error(&self, factor: f64, error: RunError) -> RunError {
        RunError::Trial { measure: self.name.to_owned(), factor, source: Box::new(error) }
    }
}

/// Search for a factor of safety between two trials.
pub(super) struct StrengthSearch {
    scale: SlopeScale,
    rule: FailureCriterion,
    safety: SafetyResult,
    /// Elastic settlement of the bodies (m).
    settlement: f64,
    /// Points at the end of the failing trial with the least factor.
    failing: Option<Snapshot>,
    /// Trials of an interrupted search, which are not run again.
    finished: Vec<StrengthTrial>,
}

/// Progress of a search.
pub(super) enum SearchStep {
    /// A trial has ended.
    Trial(StrengthTrial),
    /// The run is to stop.
    Interrupted,
    /// The last trial has ended before.
    Complete,
}

impl StrengthSearch {
    /// Determines the settling of the bodies without yielding, by which trials are judged; `None` when the run is to stop.
    ///
    /// # Errors
    /// When the bodies do not come to rest, or the solver fails.
    pub(super) fn begin(context: &SearchContext<'_>) -> Result<Option<Self>, RunError> {
        let SearchContext { case, search, name, .. } = context;
        let finished = context.finished_trials()?;
        let loose = search.unloading(case, name, case.end_time());
        let strong = context.start_trial(&loose)?;
        let scale = SlopeScale::of_case(case, &strong.start, search.height);
        let Some(settling) = ElasticSettling::find(context, strong)? else { return Ok(None) };
        let safety = SafetyResult {
            stable_factor: 0.0,
            failing_factor: f64::INFINITY,
            tolerance: search.tolerance,
            height: scale.height,
            window: search.duration.map_or(settling.time, |duration| duration / WINDOWS as f64),
            trials: Vec::new(),
        };
        let rule = FailureCriterion::new(&scale, &settling);
        let settlement = settling.displacement;
        Ok(Some(Self { scale, rule, safety, settlement, failing: None, finished }))
    }

    /// Message about the scales by which trials are judged.
    pub(super) fn scales_message(&self, name: &str) -> String {
        let SafetyResult { height, window, .. } = self.safety;
        format!(
            "{name}: height {height:.4} m, windows of {window:.4} s, elastic settlement {:.3e} m",
            self.settlement
        )
    }

    /// Runs the next trial, or takes it from an interrupted search.
    ///
    /// # Errors
    /// When the trial cannot be built, or its solver fails.
    pub(super) fn advance(&mut self, context: &SearchContext<'_>) -> Result<SearchStep, RunError> {
        let Some(factor) = self.safety.next_factor(context.search.range) else {
            return Ok(SearchStep::Complete);
        };
        let trial = match self.finished.iter().find(|trial| trial.factor == factor) {
            Some(trial) => *trial,
            None => {
                let found = run_trial(context, factor, (&self.scale, &self.rule, self.safety.window));
                let found = found.map_err(|error| context.trial_error(factor, error))?;
                let Some((trial, points)) = found else { return Ok(SearchStep::Interrupted) };
                if trial.is_failed() && factor < self.safety.failing_factor {
                    write_failed_points(context, &points)?;
                    self.failing = Some(points);
                }
                trial
            }
        };
        self.safety.add(trial);
        if let Some(table) = context.file(trials) {
            let about = "trials of a search for a factor of safety; failed and undecided are 1 or 0; the displacement is the one that \
                         a hundredth of the points exceed, dimensionless times E / (gamma H^2)";
            self.safety.table().write(&table, about)?;
        }
        Ok(SearchStep::Trial(trial))
    }

    /// Result of the search, and the points at the end of its failing trial with the least factor.
    ///
    /// # Errors
    /// When the points of an interrupted search cannot be read.
    pub(super) fn finish(
        self,
        context: &SearchContext<'_>,
    ) -> Result<(SafetyResult, Option<Snapshot>), RunError> {
        let Self { safety, mut failing, .. } = self;
        if let (None, Some(file)) = (&failing, context.file(failing_points_file).filter(|file| file.exists()))
        {
            failing = Some(read_frame(&file, 0.0)?);
        }
        Ok((safety, failing))
    }
}

/// Writes the points at the end of a failing trial over those of a trial with a larger factor.
fn write_failed_points(context: &SearchContext<'_>, points: &Snapshot) -> Result<(), RunError> {
    if let Some(file) = context.file(failing_points_file) {
        let written =
            WriteOptions { compression: context.case.output.compression, ..WriteOptions::default() };
        write_frame(&file, points, context.case.origin(), written)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
