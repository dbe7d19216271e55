//! Sweeps of a case over values of its parameters.

use std::path::PathBuf;
use std::sync::Arc;

use colluvium::case::CaseErrors;
use colluvium::case::files::json;
use colluvium::case::run::column_names;
use colluvium::sweep::{Sweep, SweepOptions, SweepRunState, run_sweep};
use pyo3::prelude::*;

use crate::channel::{Channel, Message};
use crate::errors::TaskError;

/// Sweep and its options.
pub struct SweepRequest {
    /// JSON text of the sweep.
    pub sweep: String,
    /// JSON text of the case.
    pub text: String,
    /// Folder at which file names in the case start.
    pub folder: PathBuf,
    /// Name of the method.
    pub method: Option<String>,
    /// Folder of the results.
    pub out: PathBuf,
    /// Number of simultaneous runs; by default as many as there are cores.
    pub jobs: Option<usize>,
    /// Threads of each run.
    pub threads: usize,
    /// Whether to continue the sweep in the folder.
    pub resume: bool,
    /// Whether to replace the sweep in the folder.
    pub overwrite: bool,
}

impl SweepRequest {
    /// Runs all cases.
    pub fn run(self, channel: &Arc<Channel>) -> Result<SweepData, TaskError> {
        let base = json::parse(&self.text).map_err(CaseErrors::from_error)?;
        let (sweep, members) = Sweep::of_case(&self.sweep, &base, &self.folder)?;
        let Some(first) = members.first() else { return Ok(SweepData { rows: Vec::new() }) };
        let method = colluvium::select_method(&first.case, self.method.as_deref())?;
        for (number, member) in members.iter().enumerate() {
            let plan = method.problem_size(&member.case).and_then(|size| {
                size.check_memory(colluvium::machine::free_memory())?;
                method.plan(&member.case)
            });
            plan.map_err(|error| sweep.with_run_context(number, &member.values, error.into()))?;
        }
        sweep.check_columns(&column_names(&first.case, &*method.build(&first.case)?))?;
        let threads = self.threads.max(1);
        let options = SweepOptions {
            output_folder: self.out.clone(),
            jobs: self.jobs.unwrap_or_else(|| (rayon::current_num_threads() / threads).max(1)),
            threads,
            resume: self.resume,
            overwrite: self.overwrite,
            stop_flag: Arc::clone(&channel.stop),
            commit: colluvium::COMMIT.map(str::to_owned),
        };
        channel
            .send(Message { time: members.len() as f64, ..Message::text("begin", method.name().to_owned()) });
        let tell = |number: usize, state: &SweepRunState| {
            let text = match state {
                SweepRunState::AlreadyComplete | SweepRunState::Completed => "",
                SweepRunState::Interrupted => "interrupted",
                SweepRunState::Failed { reason, .. } => reason,
            };
            let text = text.replace('\n', "; ");
            channel.send(Message { step: number as u64, ..Message::text("done", text) });
        };
        let results = run_sweep(&sweep, &members, method, &options, &tell)?;
        results.write_convergence(&self.out)?;
        let rows = results.rows.iter().map(|row| (row.status.clone(), row.reason.clone()));
        results.warnings().iter().for_each(|one| channel.warn(one));
        Ok(SweepData { rows: rows.collect() })
    }
}

/// Status of each run of a sweep, and the reason of a failure.
#[pyclass(frozen, module = "colluvium._native")]
pub struct SweepData {
    /// Status and reason of each run.
    #[pyo3(get)]
    rows: Vec<(String, Option<String>)>,
}
