//! Events of a run, and observers that receive them.

use std::fmt;
use std::sync::Arc;

use colluvium_constitutive::Warning;

use crate::run::{RunEnd, StrengthTrial};
use crate::{Advance, Frame};

/// Part of a run that [`Run::advance`](crate::Run::advance) has completed.
#[derive(Clone, Debug, PartialEq)]
pub enum RunEvent {
    /// A stage has begun, or continues after a restart.
    StageBegan {
        /// Index of the stage.
        stage: usize,
    },
    /// A step has been taken.
    Step(Advance),
    /// A row of the measures has been added to [`Run::table`](crate::Run::table).
    Row,
    /// A frame has been recorded. Positions are relative to [`Case::origin`](crate::Case::origin).
    Frame(Frame),
    /// A warning about the state.
    Warning(Warning),
    /// A stage has ended.
    StageEnded {
        /// Index of the stage.
        stage: usize,
        /// Whether the bodies came to rest before its duration.
        at_rest: bool,
    },
    /// The search for a factor of safety has begun.
    SearchBegan {
        /// Name of the measure.
        measure: String,
        /// Message about the scales by which its trials are judged.
        message: String,
    },
    /// A trial of a search has ended.
    Trial {
        /// Name of the measure.
        measure: String,
        /// Result of the trial.
        trial: StrengthTrial,
    },
    /// The run has ended. No event follows.
    Ended(RunEnd),
}

impl RunEvent {
    /// Message about a search; `None` for other events.
    pub fn search_message(&self) -> Option<String> {
        match self {
            Self::SearchBegan { message, .. } => Some(message.clone()),
            Self::Trial { measure, trial } => Some(trial.message(measure)),
            _ => None,
        }
    }
}

/// Event of a run, with the state of the run at it.
#[derive(Clone, Copy, Debug)]
pub struct ObservedEvent<'a> {
    /// The event.
    pub event: &'a RunEvent,
    /// Name of the method.
    pub method: &'a str,
    /// Time (s).
    pub time: f64,
    /// End of the last stage (s).
    pub end_time: f64,
    /// Number of steps.
    pub step: u64,
}

/// Function that receives the events of a run, such as a progress bar. Clones share it.
///
/// ```
/// use std::sync::Arc;
/// use std::sync::atomic::{AtomicU64, Ordering};
///
/// use colluvium_case::RunOptions;
/// use colluvium_case::run::{Observer, RunEvent};
///
/// let rows = Arc::new(AtomicU64::new(0));
/// let counted = Arc::clone(&rows);
/// let observer = Observer::new(move |observed| {
///     if matches!(observed.event, RunEvent::Row) {
///         counted.fetch_add(1, Ordering::Relaxed);
///     }
/// });
/// let options = RunOptions { observer: Some(observer), ..RunOptions::default() };
/// # let _ = options;
/// ```
#[derive(Clone)]
pub struct Observer(Arc<dyn Fn(&ObservedEvent<'_>) + Send + Sync>);

impl Observer {
    /// Observer by a function. A panic in it ends the run.
    pub fn new(observe: impl Fn(&ObservedEvent<'_>) + Send + Sync + 'static) -> Self {
        Self(Arc::new(observe))
    }

    /// Hands an event over.
    pub fn observe(&self, observed: &ObservedEvent<'_>) {
        (self.0)(observed);
    }
}

impl fmt::Debug for Observer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Observer")
    }
}
