//! Progress of a run on a terminal.

use std::io::Write;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::case::{Advance, Case, Run, RunEvent, Warning};

/// Wall-clock time between two lines of progress without a terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Steps between two updates of the bar.
const STEPS_PER_UPDATE: u64 = 16;

/// Progress bar of a run on standard error; without a terminal there, a line every few seconds.
pub struct RunProgress {
    /// Bar; `None` where no progress is shown.
    bar: Option<ProgressBar>,
    /// End of the last stage (s).
    end_time: f64,
    last_line: Instant,
    /// Receives warnings during the run.
    on_warning: Option<fn(&Warning)>,
    /// Warnings so far.
    warnings: Vec<Warning>,
}

impl RunProgress {
    /// Progress of a run of the case. Without `is_shown` only warnings are handed to `on_warning`.
    pub fn new(case: &Case, is_shown: bool, on_warning: Option<fn(&Warning)>) -> Self {
        let bar = || {
            let template = "{bar:30} {percent:>3} %  {msg}  {elapsed} of about {duration}";
            let style =
                ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::new((case.end_time() * 1e9) as u64).with_style(style);
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        };
        Self {
            bar: is_shown.then(bar),
            end_time: case.end_time(),
            last_line: Instant::now(),
            on_warning,
            warnings: Vec::new(),
        }
    }

    /// Warnings of the run so far, which have been handed on.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Shows an event of the run.
    pub fn observe(&mut self, run: &Run<'_>, event: &RunEvent) {
        match event {
            RunEvent::Step(step) => self.show_step(run, step),
            RunEvent::Warning(warning) => {
                if let Some(warn) = self.on_warning {
                    self.warnings.push(warning.clone());
                    self.suspended(|| warn(warning));
                }
            }
            RunEvent::SearchBegan { measure, message } => {
                if let Some(bar) = &self.bar {
                    bar.set_message(format!("searching for {measure}"));
                }
                self.print(message);
            }
            RunEvent::Trial { measure, trial } => self.print(&trial.message(measure)),
            RunEvent::Ended(_) => self.bar.iter().for_each(ProgressBar::finish_and_clear),
            RunEvent::StageBegan { .. }
            | RunEvent::StageEnded { .. }
            | RunEvent::Row
            | RunEvent::Frame(_) => {}
        }
    }

    /// Shows a step as the position of the bar, or as a line.
    fn show_step(&mut self, run: &Run<'_>, &Advance { dt, limit }: &Advance) {
        let (time, steps) = (run.time(), run.solver().step_count());
        let Some(bar) = self.bar.as_ref().filter(|_| steps.is_multiple_of(STEPS_PER_UPDATE)) else { return };
        let message = || format!("t = {time:.4} s, step {steps}, dt = {dt:.2e} s ({limit})");
        if !bar.is_hidden() {
            bar.set_position((time * 1e9) as u64);
            bar.set_message(message());
        } else if self.last_line.elapsed() >= LINE_INTERVAL {
            self.last_line = Instant::now();
            let share = 100.0 * time / self.end_time;
            self.print(&format!("{share:.0} % of the time, {}", message()));
        }
    }

    /// Prints a line above the bar. A failed write to a file or a pipe does not end the run.
    fn print(&self, line: &str) {
        if self.bar.is_some() {
            self.suspended(|| {
                let _ = writeln!(std::io::stderr(), "{line}");
            });
        }
    }

    /// Calls `write` while the bar is not drawn.
    fn suspended(&self, write: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }
}

impl Drop for RunProgress {
    /// Clears the bar of a run that failed.
    fn drop(&mut self) {
        self.bar.iter().for_each(ProgressBar::finish_and_clear);
    }
}
