//! Searches for factors of safety at the end of a run.

use std::io::Write;
use std::time::Instant;

use crate::run::{RunEnd, RunError, RunLoop, factor_of_safety};

impl RunLoop<'_> {
    /// Searches for the factors of safety, each from the state at the end of its stage. The checkpoint that is written first allows an
    /// interrupted search to resume.
    pub(crate) fn search(&mut self) -> Result<RunEnd, RunError> {
        let (Some(method), Some(_)) = (self.method, self.case.factors_of_safety().next()) else {
            return Ok(RunEnd::Completed);
        };
        self.recorder.output_last(&*self.solver, &mut self.progress)?;
        self.progress.stage = self.case.stages.len();
        self.save()?;
        let begun = Instant::now();
        for (name, search) in self.case.factors_of_safety() {
            self.progress_bar.set_message(format!("searching for {name}"));
            let rest = self.recorder.state(&search.after)?;
            let tell = |line: &str| self.report_search(line);
            let (case, options) = (self.case, self.options);
            let context = factor_of_safety::SearchContext {
                method,
                case,
                name,
                search,
                rest_state: &rest,
                options,
                report: &tell,
            };
            let found = factor_of_safety::search(&context);
            self.search_time = begun.elapsed();
            let Some((found, failing)) = found? else { return Ok(RunEnd::Interrupted) };
            self.safety.insert(name.to_owned(), found);
            self.failing_points.extend(failing.map(|points| (name.to_owned(), points)));
        }
        Ok(RunEnd::Completed)
    }

    /// Prints a message about a search.
    fn report_search(&self, line: &str) {
        if self.options.progress {
            self.progress_bar.suspend(|| {
                let _ = writeln!(std::io::stderr(), "{line}");
            });
        }
    }
}
