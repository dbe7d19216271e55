//! Progress of runs on a terminal.

use std::io::Write;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::case::run::{ObservedEvent, Observer};
use crate::case::{Advance, RunEvent, Warning, printable, shortened};

/// Wall-clock time between two lines of progress without a terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Steps between two updates of the bar.
const STEPS_PER_UPDATE: u64 = 16;

/// Progress bar and warnings of runs, one after another, on standard error; without a terminal there, a line every few seconds.
#[derive(Default)]
pub struct RunProgress {
    state: Mutex<ProgressState>,
}

/// Bar of the present run.
#[derive(Default)]
struct ProgressState {
    /// Bar; `None` before the first event and after the last.
    bar: Option<ProgressBar>,
    /// Whether only warnings are shown.
    has_no_bar: bool,
    last_line: Option<Instant>,
    /// Warnings so far.
    warnings: Vec<Warning>,
}

impl RunProgress {
    /// Warnings only, for simultaneous runs, whose bars would overwrite each other.
    pub fn of_warnings() -> Self {
        let progress = Self::default();
        progress.state().has_no_bar = true;
        progress
    }

    /// Progress of runs that have this observer among their options.
    pub fn observer(self: &Arc<Self>) -> Observer {
        let progress = Arc::clone(self);
        Observer::new(move |observed| progress.state().observe(observed))
    }

    /// Warnings of the runs so far, which have been printed.
    pub fn warnings(&self) -> Vec<Warning> {
        self.state().warnings.clone()
    }

    /// Clears the bar, as after a run that failed.
    pub fn clear(&self) {
        self.state().clear();
    }

    fn state(&self) -> MutexGuard<'_, ProgressState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ProgressState {
    /// Shows an event of a run.
    fn observe(&mut self, observed: &ObservedEvent<'_>) {
        match observed.event {
            RunEvent::Warning(_) => {}
            _ if self.has_no_bar => return,
            _ => {}
        }
        match observed.event {
            RunEvent::Step(step) => self.show_step(observed, step),
            RunEvent::Warning(warning) => {
                self.warnings.push(warning.clone());
                self.print(&shortened(&printable(&warning.line("warning"))));
            }
            RunEvent::SearchBegan { measure, message } => {
                self.bar(observed).set_message(format!("searching for {measure}"));
                self.print(message);
            }
            RunEvent::Trial { measure, trial } => self.print(&trial.message(measure)),
            RunEvent::Ended(_) => self.clear(),
            RunEvent::StageBegan { .. } => drop(self.bar(observed)),
            RunEvent::StageEnded { .. } | RunEvent::Row | RunEvent::Frame(_) => {}
        }
    }

    /// Bar of the present run.
    fn bar(&mut self, observed: &ObservedEvent<'_>) -> ProgressBar {
        let new_bar = || {
            let template = "{bar:30} {percent:>3} %  {msg}  {elapsed} of about {duration}";
            let style =
                ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::new((observed.end_time * 1e9) as u64).with_style(style);
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        };
        self.bar.get_or_insert_with(new_bar).clone()
    }

    /// Shows a step as the position of the bar, or as a line.
    fn show_step(&mut self, observed: &ObservedEvent<'_>, &Advance { dt, limit }: &Advance) {
        let &ObservedEvent { time, end_time, step, .. } = observed;
        if !step.is_multiple_of(STEPS_PER_UPDATE) {
            return;
        }
        let message = || format!("t = {time:.4} s, step {step}, dt = {dt:.2e} s ({limit})");
        let bar = self.bar(observed);
        if !bar.is_hidden() {
            bar.set_position((time * 1e9) as u64);
            bar.set_message(message());
        } else if self.last_line.get_or_insert_with(Instant::now).elapsed() >= LINE_INTERVAL {
            self.last_line = Some(Instant::now());
            self.print(&format!("{:.0} % of the time, {}", 100.0 * time / end_time, message()));
        }
    }

    /// Prints a line above the bar. A failed write to a file or a pipe does not end the run.
    fn print(&self, line: &str) {
        let write = || {
            let _ = writeln!(std::io::stderr(), "{line}");
        };
        match &self.bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }

    fn clear(&mut self) {
        self.bar.take().iter().for_each(ProgressBar::finish_and_clear);
        self.last_line = None;
    }
}

impl Drop for ProgressState {
    fn drop(&mut self) {
        self.clear();
    }
}
