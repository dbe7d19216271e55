//! Trial of a search for a factor of safety: bodies of reduced strength start from rest.
//!
//! A trial is divided into time windows as long as the elastic settling.

use crate::description::Stage;
use crate::run::RunError;
use crate::run::factor_of_safety::elastic_settling::ElasticSettling;
use crate::run::factor_of_safety::slope_scale::{SlopeScale, displacements, exceeded_displacement};
use crate::run::factor_of_safety::{REST_RATIO, SearchContext};
use crate::simulation::step_size::{is_negligible, stable_step};
use crate::{Field, FieldData, Snapshot, Solver};

/// Steps between two checks of a trial.
const STEPS_PER_CHECK: u64 = 50;
/// Number of windows to whose displacements a geometric series is fitted.
const FITTED_WINDOWS: usize = 6;
/// Largest number of windows of a trial.
pub(super) const WINDOWS: usize = 2 * FITTED_WINDOWS;
/// Displacement in a time window over the total displacement, below which the displacement in the window counts as zero.
const NO_DISPLACEMENT_RATIO: f64 = 0.01;
/// Share of the elastic settlement that replaces a smaller total displacement in the test for small displacements.
const NO_DISPLACEMENT: f64 = 0.1;
/// Largest displacement beyond the elastic settlement, over the height of the slope.
const MAX_DISPLACEMENT_RATIO: f64 = 0.02;
/// Ratio of the values of successive windows, above which the unbalanced force or the velocity counts as not decreasing.
const NO_DECREASE_RATIO: f64 = 0.9;
/// Number of consecutive windows without a decrease that count as failure.
const BLOCKS_WITHOUT_DECREASE: usize = 2;
/// Largest displacement of stable bodies over the elastic settlement: beyond it they have slid and failed, even if they have stopped on a
/// flatter slope or by a mesh that locks.
const MAX_SETTLEMENTS: f64 = 5.0;
/// Factor on the least unbalanced-force ratio of the method, above which the ratio is no numerical noise.
const NOISE_FACTOR: f64 = 1.5;

/// Verdict on a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrialVerdict {
    /// Rest of the bodies.
    Stable,
    /// Failure: displacements too large or without decay.
    Failed,
    /// Neither rest nor failure.
    Undecided,
}

impl TrialVerdict {
    /// Name of the verdict in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Failed => "failed",
            Self::Undecided => "undecided",
        }
    }
}

/// Result of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrengthTrial {
    /// Strength reduction factor `F`.
    pub factor: f64,
    /// Verdict on the trial.
    pub verdict: TrialVerdict,
    /// Duration until the verdict (s).
    pub time: f64,
    /// Displacement that one hundredth of the points exceed (m).
    pub displacement: f64,
    /// Displacement over `γ H² / E`; not-a-number where a material has no Young's modulus.
    pub dimensionless_displacement: f64,
    /// Unbalanced force over the external one in the last window.
    pub unbalanced_force: f64,
}

impl StrengthTrial {
    /// Message about the trial of the measure `name`.
    pub fn message(&self, name: &str) -> String {
        let Self { factor, verdict, time, displacement, unbalanced_force, .. } = self;
        format!(
            "{name}: trial at {factor:.4}: {} after {time:.4} s, displacement {displacement:.3e} m, \
             unbalanced force {unbalanced_force:.1e}",
            verdict.name()
        )
    }

    /// Whether the bodies failed.
    pub fn is_failed(&self) -> bool {
        self.verdict == TrialVerdict::Failed
    }
}

/// Strength trial that runs, with its solver.
pub(super) struct RunningTrial<'a> {
    /// Solver of the bodies with reduced strength.
    pub solver: Box<dyn Solver>,
    /// Points at the start of the trial.
    pub start: Snapshot,
    /// Stage at whose end the trials begin.
    pub stage: &'a Stage,
    /// Start of the trial (s).
    pub start_time: f64,
}

impl RunningTrial<'_> {
    /// Advances by at most `steps` steps, and not beyond `end` (s from the start of the trial). Returns whether `end` is reached.
    pub fn advance(&mut self, steps: u64, end: f64) -> Result<bool, RunError> {
        let until = if end.is_finite() { end } else { self.elapsed_time() + self.stage.duration };
        for _ in 0..steps {
            let limit = stable_step(&mut *self.solver, self.stage, self.start_time + until)?;
            let left = self.start_time + until - self.solver.time();
            if is_negligible(left, limit.dt.min(until)) {
                return Ok(true);
            }
            self.solver.step(if end.is_finite() { left } else { limit.dt })?;
        }
        Ok(false)
    }

    /// Time since the start of the trial (s).
    pub fn elapsed_time(&self) -> f64 {
        self.solver.time() - self.start_time
    }

    /// Unbalanced force over the external one; not-a-number for methods without this measure.
    pub fn unbalanced_ratio(&self) -> f64 {
        self.solver.equilibrium().map_or(f64::NAN, |equilibrium| equilibrium.unbalanced_force)
    }
}

/// Result of a time window of a trial: unbalanced-force ratio, and displacement at its end (m).
#[derive(Clone, Copy, Debug, PartialEq)]
struct TrialWindow {
    unbalanced_ratio: f64,
    displacement: f64,
}

/// Criterion of failure of a trial.
#[derive(Clone, Copy, Debug)]
pub(super) struct FailureCriterion {
    /// Unbalanced-force ratio below which the bodies are at rest.
    rest_tolerance: f64,
    /// Elastic settlement under the weight (m).
    elastic: f64,
    /// Displacement at failure (m).
    max_displacement: f64,
}

impl FailureCriterion {
    /// Limits of rest and failure of a slope, from its height and from its elastic settling.
    pub fn new(scale: &SlopeScale, settling: &ElasticSettling) -> Self {
        Self {
            rest_tolerance: REST_RATIO.max(NOISE_FACTOR * settling.floor),
            elastic: settling.displacement,
            max_displacement: settling.displacement + MAX_DISPLACEMENT_RATIO * scale.height,
        }
    }

    /// Verdict on a trial from its windows; `None` while it is undecided.
    fn judge(&self, windows: &[TrialWindow]) -> Option<TrialVerdict> {
        let last = windows.len().checked_sub(1)?;
        let TrialWindow { unbalanced_ratio, displacement } = windows[last];
        let before = |k: usize| if k > 0 { windows[k - 1].displacement } else { 0.0 };
        let added: Vec<f64> = (0..=last).map(|k| windows[k].displacement - before(k)).collect();
        let little = NO_DISPLACEMENT_RATIO * displacement.max(NO_DISPLACEMENT * self.elastic);
        let course = DisplacementSeries::fit(&added);
        // Failed bodies move farther than their elastic settlement.
        let comes_to_rest = course.is_some_and(|course| displacement + course.remaining() <= self.elastic);
        if unbalanced_ratio < self.rest_tolerance && (added[last] <= little || comes_to_rest) {
            let slid = self.elastic > 0.0 && displacement > MAX_SETTLEMENTS * self.elastic;
            return Some(if slid { TrialVerdict::Failed } else { TrialVerdict::Stable });
        }
        let goes_on = |k: usize| {
            let force = windows[k].unbalanced_ratio;
            let held =
                force < self.rest_tolerance || force > NO_DECREASE_RATIO * windows[k - 1].unbalanced_ratio;
            held && added[k] > NO_DECREASE_RATIO * added[k - 1]
        };
        let soon = last > BLOCKS_WITHOUT_DECREASE
            && (last + 1 - BLOCKS_WITHOUT_DECREASE..=last).all(goes_on)
            && added[last] > little;
        // Elastic bodies would have come to rest in this time, so these bodies yield whatever the unbalanced force is.
        let slides =
            course.is_some_and(|course| course.sum > self.elastic && course.ratio > NO_DECREASE_RATIO);
        ((soon || slides) && displacement > self.elastic).then_some(TrialVerdict::Failed)
    }
}

/// Geometric series of the displacements in the last [`FITTED_WINDOWS`] time windows of a trial. Single windows are too uneven near failure,
/// because points cross cells and yielding is intermittent.
#[derive(Clone, Copy, Debug)]
struct DisplacementSeries {
    /// Displacement in all fitted time windows together (m).
    sum: f64,
    /// Mean ratio of the displacement in a time window to that in the window before.
    ratio: f64,
}

impl DisplacementSeries {
    /// Fits a geometric series to the displacements added in successive time windows of equal duration (m). `None` for fewer than
    /// [`FITTED_WINDOWS`] windows after the first one, which includes the elastic settlement, or for a window without displacement.
    fn fit(added: &[f64]) -> Option<Self> {
        let fitted = added.get(1..)?.last_chunk::<FITTED_WINDOWS>()?;
        // Least squares of the logarithms.
        let middle = 0.5 * (FITTED_WINDOWS as f64 - 1.0);
        let (mut square, mut slope) = (0.0, 0.0);
        for (k, add) in fitted.iter().enumerate() {
            let from = k as f64 - middle;
            square += from * from;
            slope += from * add.ln();
        }
        let ratio = (slope / square).exp();
        fitted.iter().all(|add| *add > 0.0).then(|| Self { sum: fitted.iter().sum(), ratio })
    }

    /// Displacement of all later terms of the series (m).
    fn remaining(&self) -> f64 {
        let over_fitted = self.ratio.powi(FITTED_WINDOWS as i32);
        if over_fitted < 1.0 { self.sum * over_fitted / (1.0 - over_fitted) } else { f64::INFINITY }
    }
}

/// Runs a trial with windows of `window` seconds. Returns its result and the points at its end with their
/// `trial_displacement`.
pub(super) fn run_trial(
    context: &SearchContext<'_>,
    factor: f64,
    (scale, rule, window): (&SlopeScale, &FailureCriterion, f64),
) -> Result<Option<(StrengthTrial, Snapshot)>, RunError> {
    let case = context.search.trial(context.case, context.name, factor, WINDOWS as f64 * window);
    let domain = &context.case.domain;
    let mut running = context.start_trial(&case)?;
    let mut windows: Vec<TrialWindow> = Vec::with_capacity(WINDOWS);
    let mut displacement = 0.0;
    let verdict = loop {
        let (begin, end) = (running.elapsed_time(), (windows.len() + 1) as f64 * window);
        let (mut sum, mut count) = (0.0, 0.0);
        let failed = loop {
            if context.is_to_stop() {
                return Ok(None);
            }
            let over = running.advance(STEPS_PER_CHECK, end)?;
            let now = exceeded_displacement(&running.solver.snapshot(), &running.start, domain);
            let failed = now > rule.max_displacement && now > displacement;
            displacement = now;
            // The first half of a window is left out of the mean.
            if over || running.elapsed_time() - begin > 0.5 * window {
                (sum, count) = (sum + running.unbalanced_ratio(), count + 1.0);
            }
            if over || failed {
                break failed;
            }
        };
        windows.push(TrialWindow {
            unbalanced_ratio: if count > 0.0 { sum / count } else { running.unbalanced_ratio() },
            displacement,
        });
        if failed {
            break TrialVerdict::Failed;
        }
        if let Some(verdict) = rule.judge(&windows) {
            break verdict;
        }
        if windows.len() == WINDOWS {
            break TrialVerdict::Undecided;
        }
    };
    let trial = StrengthTrial {
        factor,
        verdict,
        time: running.elapsed_time(),
        displacement,
        dimensionless_displacement: displacement / scale.settlement,
        unbalanced_force: windows.last().map_or(f64::NAN, |window| window.unbalanced_ratio),
    };
    let mut snapshot = running.solver.snapshot();
    let since = displacements(&snapshot, &running.start, domain);
    let data = FieldData::Vector(since.into_iter().map(Option::unwrap_or_default).collect());
    snapshot.fields.push(Field { name: "trial_displacement".to_owned(), unit: "m", data });
    Ok(Some((trial, snapshot)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEST_CRITERION: FailureCriterion =
        FailureCriterion { rest_tolerance: 1e-3, elastic: 0.05, max_displacement: 1.0 };

    fn windows(unbalanced_ratio: &[f64], displacement: &[f64]) -> Vec<TrialWindow> {
        let both = unbalanced_ratio.iter().zip(displacement);
        both.map(|(&unbalanced_ratio, &displacement)| TrialWindow { unbalanced_ratio, displacement })
            .collect()
    }

    #[test]
    fn bodies_at_rest_after_small_displacements_are_stable() {
        assert_eq!(TEST_CRITERION.judge(&windows(&[1e-4], &[1e-6])), Some(TrialVerdict::Stable));
        assert_eq!(TEST_CRITERION.judge(&windows(&[1e-4, 1e-4], &[0.1, 0.1005])), Some(TrialVerdict::Stable));
    }

    #[test]
    fn bodies_that_move_on_without_force_are_not_at_rest() {
        assert_eq!(TEST_CRITERION.judge(&windows(&[1e-4, 1e-4], &[0.1, 0.105])), None);
        assert_eq!(
            TEST_CRITERION.judge(&windows(&[1e-4; 4], &[0.1, 0.12, 0.14, 0.16])),
            Some(TrialVerdict::Failed)
        );
    }

    #[test]
    fn bodies_that_do_not_slow_down_have_failed_after_three_blocks() {
        let moving = windows(&[0.02, 0.02, 0.02, 0.02], &[0.01, 0.03, 0.06, 0.10]);
        assert_eq!(TEST_CRITERION.judge(&moving[..3]), None);
        assert_eq!(TEST_CRITERION.judge(&moving), Some(TrialVerdict::Failed));
    }

    #[test]
    fn bodies_that_have_hardly_moved_have_not_failed_yet() {
        let creeping = windows(&[0.02, 0.02, 0.02, 0.02], &[0.001, 0.003, 0.006, 0.010]);
        assert_eq!(TEST_CRITERION.judge(&creeping), None);
    }

    #[test]
    fn bodies_that_come_to_rest_after_a_slide_have_failed() {
        assert_eq!(TEST_CRITERION.judge(&windows(&[1e-2, 1e-4], &[0.3, 0.301])), Some(TrialVerdict::Failed));
    }

    /// Displacements at the ends of successive time windows (m), in each of which `added` (m) is added.
    fn summed(added: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let mut sum = 0.0;
        added.into_iter().map(|add| (sum += add, sum).1).collect()
    }

    #[test]
    fn a_geometric_series_is_summed_to_its_end() {
        for ratio in [0.3, 0.7, 0.95f64] {
            let added: Vec<f64> = (0..9).map(|k| 0.01 * ratio.powi(k)).collect();
            let course = DisplacementSeries::fit(&added).unwrap();
            let left = 0.01 * ratio.powi(9) / (1.0 - ratio);
            assert!((course.ratio - ratio).abs() < 1e-12);
            assert!((course.remaining() / left - 1.0).abs() < 1e-9, "{ratio}");
        }
        assert!(DisplacementSeries::fit(&[0.01; 6]).is_none(), "the first window does not count");
        assert_eq!(DisplacementSeries::fit(&[0.01; 7]).unwrap().remaining(), f64::INFINITY);
        assert!(DisplacementSeries::fit(&[0.01, 0.01, 0.01, 0.0, 0.01, 0.01, 0.01]).is_none());
    }

    /// Elastic settlement of 0.05 m. Windows of 4 mm that fall by 0.89, each other one uneven, add 36 mm at the end.
    #[test]
    fn bodies_that_slow_down_to_an_end_short_of_their_elastic_settlement_are_stable() {
        let moved = |first: f64, share: f64| {
            summed((0..12).map(move |k| {
                let uneven = if k % 2 == 0 { 1.0 } else { 0.8 };
                if k == 0 { first } else { 0.004 * f64::powi(share, k) * uneven }
            }))
        };
        let judge =
            |moved: &[f64], force: f64| TEST_CRITERION.judge(&windows(&vec![force; moved.len()], moved));
        assert_eq!(judge(&moved(0.01, 0.89)[..6], 9e-4), None);
        assert_eq!(judge(&moved(0.01, 0.89)[..7], 9e-4), Some(TrialVerdict::Stable));
        assert_eq!(judge(&moved(0.01, 0.89)[..7], 2e-3), None, "out of balance");
        assert_eq!(judge(&moved(0.03, 0.89)[..7], 9e-4), None, "the end is farther off");
        for count in 7..=12 {
            assert_eq!(judge(&moved(0.01, 1.0)[..count], 9e-4), None, "they creep on, {count}");
        }
    }

    #[test]
    fn bodies_that_move_on_for_a_round_have_failed_though_their_force_falls() {
        let force: Vec<f64> = (0..7).map(|k| 5e-3 * f64::powi(0.88, k)).collect();
        // Each other window is half as fast as the one before.
        let uneven = |first: f64, share: f64| {
            summed((0..7).map(move |k| first * f64::powi(share, k) * if k % 2 == 0 { 1.0 } else { 0.5 }))
        };
        let slides = uneven(0.014, 1.0);
        assert_eq!(TEST_CRITERION.judge(&windows(&force[..6], &slides[..6])), None);
        assert_eq!(TEST_CRITERION.judge(&windows(&force, &slides)), Some(TrialVerdict::Failed));
        assert_eq!(TEST_CRITERION.judge(&windows(&force, &uneven(0.03, 0.8))), None, "they slow down");
        let creep = summed(std::iter::once(0.06).chain([0.006; 6]));
        assert_eq!(TEST_CRITERION.judge(&windows(&force, &creep)), None, "less than the weight settles them");
    }

    #[test]
    fn trials_of_decelerating_bodies_continue() {
        assert_eq!(
            TEST_CRITERION.judge(&windows(&[0.02, 0.02, 0.02, 0.02], &[0.10, 0.18, 0.24, 0.28])),
            None
        );
        assert_eq!(
            TEST_CRITERION.judge(&windows(&[0.02, 0.01, 0.005, 0.0025], &[0.01, 0.03, 0.06, 0.10])),
            None
        );
    }
}
