//! Comparisons of several methods on one case.

use std::path::PathBuf;
use std::sync::Arc;

use colluvium::case::RunEvent;
use colluvium::case::run::Observer;
use colluvium::compare::{self, CompareOptions, MethodOutcome, MethodResult, ReferenceProfiles};
use colluvium::output::run_pictures::view_plane_for_gravity;
use pyo3::prelude::*;

use crate::cases::read_case;
use crate::channel::{Channel, Message};
use crate::errors::TaskError;

/// Comparison and its options.
pub struct CompareRequest {
    /// JSON text of the case.
    pub text: String,
    /// Folder at which file names in the case start.
    pub folder: PathBuf,
    /// Names of the methods; all that support the case where it is empty.
    pub methods: Vec<String>,
    /// Folder of the results.
    pub out: PathBuf,
    /// Number of simultaneous methods.
    pub jobs: usize,
    /// Whether to continue runs in the folder.
    pub resume: bool,
    /// Whether to replace runs in the folder.
    pub overwrite: bool,
    /// File of reference profiles.
    pub reference: Option<PathBuf>,
}

impl CompareRequest {
    /// Runs the methods, and writes the page.
    pub fn run(self, channel: &Arc<Channel>) -> Result<CompareData, TaskError> {
        let case = read_case(&self.text, &self.folder)?;
        let methods = compare::methods_by_name(&self.methods)?;
        let reference =
            self.reference.as_deref().map(ReferenceProfiles::read).transpose()?.unwrap_or_default();
        let own = Arc::clone(channel);
        let observer = Observer::new(move |observed| {
            if let RunEvent::Warning(warning) = observed.event {
                let text = format!("[{}] {}: {}", warning.code, observed.method, warning.text);
                own.send(Message::text("warning", text));
            }
        });
        let options = CompareOptions {
            output_folder: self.out.clone(),
            resume: self.resume,
            overwrite: self.overwrite,
            jobs: self.jobs,
            free_memory: colluvium::machine::free_memory(),
            stop_flag: Some(Arc::clone(&channel.stop)),
            commit: colluvium::COMMIT.map(str::to_owned),
            observer: Some(observer),
        };
        channel.send(Message { time: methods.len() as f64, ..Message::text("begin", String::new()) });
        let tell = |result: &MethodResult| channel.send(Message::text("done", result.method.to_owned()));
        let results = compare::run(&case, &methods, &options, &tell)?;
        let interrupted = results.iter().any(|result| matches!(result.outcome, MethodOutcome::Interrupted));
        let page = if interrupted {
            None
        } else {
            let plane = view_plane_for_gravity(case.gravity.get(2).copied(), None);
            Some(compare::write_page(&self.out, &case, &results, plane, &reference)?)
        };
        Ok(CompareData { page, methods: results.iter().map(method_row).collect() })
    }
}

/// Name, status, text, and options chosen for a method.
type MethodRow = (&'static str, &'static str, String, String);

/// Row of a method in the results.
fn method_row(result: &MethodResult) -> MethodRow {
    let (status, text) = match &result.outcome {
        MethodOutcome::Refused(why) => ("refused", why.clone()),
        MethodOutcome::Failed { reason, .. } => ("failed", reason.clone()),
        MethodOutcome::Interrupted => ("interrupted", String::new()),
        MethodOutcome::Completed(_) => ("completed", String::new()),
    };
    (result.method, status, text, result.chosen_options.clone())
}

/// Results of a comparison.
#[pyclass(frozen, module = "colluvium._native")]
pub struct CompareData {
    /// File of the page; `None` for an interrupted comparison.
    #[pyo3(get)]
    page: Option<PathBuf>,
    /// Name, status, text and chosen options of each method.
    #[pyo3(get)]
    methods: Vec<MethodRow>,
}
