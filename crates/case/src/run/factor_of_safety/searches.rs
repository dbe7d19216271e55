//! Searches for factors of safety at the end of a run, one trial after the other.

use std::sync::Arc;
use std::time::Instant;

use crate::run::factor_of_safety::{SearchContext, SearchStep, StrengthSearch};
use crate::run::{Phase, Run, RunEnd, RunError, RunEvent};

impl Run<'_> {
    /// Begins the searches after the last stage, where the case has any. The checkpoint that is written allows an interrupted search to
    /// resume.
    pub(in crate::run) fn begin_searches(&mut self) -> Result<(), RunError> {
        if self.method.is_none() || self.case.factors_of_safety().next().is_none() {
            self.end(RunEnd::Completed);
            return Ok(());
        }
        let written = self.recorder.output_last(&*self.solver, &mut self.progress)?;
        self.push_output(written);
        self.progress.is_searching = true;
        self.phase = Phase::Search { number: 0, search: None };
        self.save()
    }

    /// Advances the search `number` by a trial, and begins or ends it.
    pub(in crate::run) fn advance_search(
        &mut self,
        number: usize,
        search: Option<Box<StrengthSearch>>,
    ) -> Result<(), RunError> {
        let (case, options) = (Arc::clone(&self.case), Arc::clone(&self.options));
        let begun = Instant::now();
        let (Some(method), Some((name, factor_of_safety))) =
            (self.method, case.factors_of_safety().nth(number))
        else {
            self.end(RunEnd::Completed);
            return Ok(());
        };
        let rest = self.recorder.state(&factor_of_safety.after)?;
        let context = SearchContext {
            method,
            case: &case,
            name,
            search: factor_of_safety,
            rest_state: &rest,
            options: &options,
        };
        let mut number = number;
        let next = match search {
            None => {
                let Some(found) = StrengthSearch::begin(&context)? else { return self.interrupt_search() };
                let message = found.scales_message(name);
                self.events.push_back(RunEvent::SearchBegan { measure: name.to_owned(), message });
                Some(Box::new(found))
            }
            Some(mut search) => match search.advance(&context)? {
                SearchStep::Trial(trial) => {
                    self.events.push_back(RunEvent::Trial { measure: name.to_owned(), trial });
                    Some(search)
                }
                SearchStep::Interrupted => return self.interrupt_search(),
                SearchStep::Complete => {
                    let (safety, failing) = search.finish(&context)?;
                    self.safety.insert(name.to_owned(), safety);
                    self.failing_points.extend(failing.map(|points| (name.to_owned(), points)));
                    number += 1;
                    None
                }
            },
        };
        self.phase = Phase::Search { number, search: next };
        self.search_time += begun.elapsed();
        Ok(())
    }

    /// Ends a run whose search was interrupted; its checkpoint was written when the searches began.
    fn interrupt_search(&mut self) -> Result<(), RunError> {
        self.end(RunEnd::Interrupted);
        Ok(())
    }
}
