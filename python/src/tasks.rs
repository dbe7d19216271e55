//! Long work on a thread of its own: runs, sweeps and comparisons, with messages to Python while they go on.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::channel::{Channel, Message};
use crate::compare::{CompareData, CompareRequest};
use crate::errors::{TaskError, value_error};
use crate::frames::FrameData;
use crate::runs::{RunData, RunRequest};
use crate::sweeps::{SweepData, SweepRequest};

/// Kind, time (s), step, text and frame of a message.
type MessageRow = (&'static str, f64, u64, String, Option<Py<FrameData>>);

/// Finishes a channel when the thread of a task ends, by a panic as well.
struct Finish(Arc<Channel>);

impl Drop for Finish {
    fn drop(&mut self) {
        self.0.finish();
    }
}

/// Largest number of threads, as for the command.
const MAX_THREADS: usize = 1024;

/// Results of a task.
pub enum TaskResult {
    /// Results of a run.
    Run(Box<RunData>),
    /// Results of a sweep.
    Sweep(SweepData),
    /// Results of a comparison.
    Compare(CompareData),
}

/// Work on a thread of its own, with a pool of its own.
#[pyclass(module = "colluvium._native")]
pub struct Task {
    channel: Arc<Channel>,
    thread: Option<JoinHandle<Result<TaskResult, TaskError>>>,
    process: u32,
}

impl Task {
    /// Starts work on `threads` threads; all cores without a number.
    fn start(
        threads: Option<usize>,
        work: impl FnOnce(&Arc<Channel>) -> Result<TaskResult, TaskError> + Send + 'static,
    ) -> PyResult<Self> {
        if let Some(count) = threads.filter(|count| !(1..=MAX_THREADS).contains(count)) {
            return Err(value_error(&format!("threads: {count} is not between 1 and {MAX_THREADS}")));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
        let pool = pool.map_err(|error| value_error(&format!("threads: {error}")))?;
        let channel = Arc::new(Channel::default());
        let own = Arc::clone(&channel);
        let thread = std::thread::Builder::new().name("colluvium".to_owned()).spawn(move || {
            let finish = Finish(own);
            pool.install(|| work(&finish.0))
        });
        let thread = thread.map_err(|error| value_error(&format!("threads: {error}")))?;
        Ok(Self { channel, thread: Some(thread), process: std::process::id() })
    }

    /// Refuses a task of another process, whose threads a fork does not copy.
    fn check_process(&self) -> PyResult<()> {
        if self.process == std::process::id() {
            return Ok(());
        }
        let problem = format!(
            "the run began in process {} and has no threads in this one, which was forked from it: start it here, or use the start \
             method \"spawn\"",
            self.process
        );
        Err(PyRuntimeError::new_err(problem))
    }
}

/// Refuses a number of simultaneous runs, or of their threads, that is not possible.
fn check_jobs(jobs: Option<usize>) -> PyResult<()> {
    match jobs.filter(|count| !(1..=MAX_THREADS).contains(count)) {
        Some(count) => {
            Err(value_error(&format!("jobs, threads: {count} is not between 1 and {MAX_THREADS}")))
        }
        None => Ok(()),
    }
}

#[pymethods]
impl Task {
    /// Starts the run of a case.
    #[staticmethod]
    #[pyo3(signature = (text, folder, method, out, threads, resume, overwrite, frames, waits))]
    #[allow(clippy::too_many_arguments, reason = "the signature of the Python call")]
    fn run(
        text: String,
        folder: PathBuf,
        method: Option<String>,
        out: Option<PathBuf>,
        threads: Option<usize>,
        resume: bool,
        overwrite: bool,
        frames: bool,
        waits: bool,
    ) -> PyResult<Self> {
        let request = RunRequest { text, folder, method, out, resume, overwrite, frames, waits };
        Self::start(threads, move |channel| {
            request.run(channel).map(|found| TaskResult::Run(Box::new(found)))
        })
    }

    /// Starts the runs of a sweep, `jobs` at a time with `threads` threads each.
    #[staticmethod]
    #[pyo3(signature = (sweep, text, folder, method, out, jobs, threads, resume, overwrite))]
    #[allow(clippy::too_many_arguments, reason = "the signature of the Python call")]
    fn sweep(
        sweep: String,
        text: String,
        folder: PathBuf,
        method: Option<String>,
        out: PathBuf,
        jobs: Option<usize>,
        threads: usize,
        resume: bool,
        overwrite: bool,
    ) -> PyResult<Self> {
        check_jobs(jobs)?;
        check_jobs(Some(threads))?;
        let request = SweepRequest { sweep, text, folder, method, out, jobs, threads, resume, overwrite };
        Self::start(None, move |channel| request.run(channel).map(TaskResult::Sweep))
    }

    /// Starts the comparison of methods on a case, `jobs` at a time.
    #[staticmethod]
    #[pyo3(signature = (text, folder, methods, out, jobs, threads, resume, overwrite, reference))]
    #[allow(clippy::too_many_arguments, reason = "the signature of the Python call")]
    fn compare(
        text: String,
        folder: PathBuf,
        methods: Vec<String>,
        out: PathBuf,
        jobs: usize,
        threads: Option<usize>,
        resume: bool,
        overwrite: bool,
        reference: Option<PathBuf>,
    ) -> PyResult<Self> {
        check_jobs(Some(jobs))?;
        let request = CompareRequest { text, folder, methods, out, jobs, resume, overwrite, reference };
        Self::start(threads, move |channel| request.run(channel).map(TaskResult::Compare))
    }

    /// Next message: kind, time (s), step, text and frame, waited for at most `seconds`; `None` without one.
    fn wait(&self, py: Python<'_>, seconds: f64) -> PyResult<Option<MessageRow>> {
        self.check_process()?;
        let wait = Duration::from_secs_f64(seconds.clamp(0.0, 60.0));
        let found = py.detach(|| self.channel.take(wait));
        let Some(Message { kind, time, step, text, frame }) = found else { return Ok(None) };
        let frame = frame.map(|frame| FrameData::new(py, frame)).transpose()?;
        Ok(Some((kind, time, step, text, frame)))
    }

    /// Whether the work has ended and all its messages were taken.
    fn is_finished(&self) -> bool {
        self.channel.is_finished()
    }

    /// Stops the work at the next step.
    fn stop(&self) {
        self.channel.stop();
    }

    /// Results of the work, which is waited for.
    ///
    /// # Errors
    /// The error of the work.
    fn result(&mut self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        self.check_process()?;
        let thread =
            self.thread.take().ok_or_else(|| PyRuntimeError::new_err("the results were taken before"))?;
        let joined = py.detach(|| thread.join());
        let found = joined.map_err(|_| {
            PyRuntimeError::new_err(
                "the run panicked: this is an error of colluvium, please report it with the case",
            )
        })?;
        match found.map_err(TaskError::into_exception)? {
            TaskResult::Run(run) => Ok(Py::new(py, *run)?.into_any()),
            TaskResult::Sweep(sweep) => Ok(Py::new(py, sweep)?.into_any()),
            TaskResult::Compare(compare) => Ok(Py::new(py, compare)?.into_any()),
        }
    }
}

impl Drop for Task {
    /// Stops work whose results nobody can take.
    fn drop(&mut self) {
        self.stop();
    }
}
