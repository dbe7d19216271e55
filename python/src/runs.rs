//! Runs on a thread of their own, with a pool of their own.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use colluvium::case::run::{Run, RunEnd, RunError, RunEvent, RunReport, SafetyResult};
use colluvium::case::{Case, Method, RunOptions, Warning};
use numpy::{PyArray2, PyArrayMethods};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::errors::{run_error, value_error};
use crate::frames::Frame;
use crate::read_case;

/// Interval between two messages about progress (s).
const PROGRESS_INTERVAL: Duration = Duration::from_millis(100);

/// Message of a run: kind, time (s), step, and text.
type Message = (&'static str, f64, u64, String);

/// Messages of a run that Python has not taken.
#[derive(Default)]
struct Messages {
    queue: VecDeque<Message>,
    is_finished: bool,
}

/// State shared by the thread of a run and Python.
#[derive(Default)]
struct SharedState {
    messages: Mutex<Messages>,
    changed: Condvar,
}

impl SharedState {
    fn messages(&self) -> MutexGuard<'_, Messages> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn send(&self, message: Message) {
        self.messages().queue.push_back(message);
        self.changed.notify_all();
    }

    fn finish(&self) {
        self.messages().is_finished = true;
        self.changed.notify_all();
    }
}

/// Result of the thread of a run.
type Outcome = Result<RunReport, RunError>;

/// Run on a thread of its own.
#[pyclass(module = "colluvium")]
pub struct RunTask {
    shared: Arc<SharedState>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Outcome>>,
}

#[pymethods]
impl RunTask {
    /// Starts the run of a case.
    #[new]
    #[pyo3(signature = (text, folder, method, out, threads, resume, overwrite))]
    #[allow(clippy::too_many_arguments, reason = "the signature of the Python call")]
    fn new(
        py: Python<'_>,
        text: &str,
        folder: PathBuf,
        method: Option<&str>,
        out: Option<PathBuf>,
        threads: Option<usize>,
        resume: bool,
        overwrite: bool,
    ) -> PyResult<Self> {
        let (case, method) = py.detach(|| -> PyResult<(Case, &'static dyn Method)> {
            let case = read_case(text, &folder)?;
            let method = colluvium::select_method(&case, method).map_err(|error| value_error(&error))?;
            Ok((case, method))
        })?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
        let pool = pool.map_err(|error| value_error(&error))?;
        let (shared, stop) = (Arc::new(SharedState::default()), Arc::new(AtomicBool::new(false)));
        let options = RunOptions {
            method: method.name().to_owned(),
            output_folder: out,
            resume,
            overwrite,
            keep_frames: true,
            stop_flag: Some(Arc::clone(&stop)),
            commit: colluvium::COMMIT.map(str::to_owned),
            ..RunOptions::default()
        };
        let channel = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name("colluvium-run".to_owned()).spawn(move || {
            let found = pool.install(|| follow_run(case, method, options, &channel));
            channel.finish();
            found
        });
        let thread = thread.map_err(|error| value_error(&error))?;
        Ok(Self { shared, stop, thread: Some(thread) })
    }

    /// Next message of the run, waited for at most `seconds`; `None` without one.
    fn wait(&self, py: Python<'_>, seconds: f64) -> Option<Message> {
        py.detach(|| {
            let waits = |messages: &mut Messages| messages.queue.is_empty() && !messages.is_finished;
            let wait = Duration::from_secs_f64(seconds.clamp(0.0, 60.0));
            let found = self.shared.changed.wait_timeout_while(self.shared.messages(), wait, waits);
            found.unwrap_or_else(PoisonError::into_inner).0.queue.pop_front()
        })
    }

    /// Whether the run has ended and all its messages were taken.
    fn is_finished(&self) -> bool {
        let messages = self.shared.messages();
        messages.is_finished && messages.queue.is_empty()
    }

    /// Stops the run at its next step.
    fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Results of the run, which is waited for.
    ///
    /// # Errors
    /// The error of the run.
    fn result(&mut self, py: Python<'_>) -> PyResult<RunData> {
        let thread = self.thread.take().ok_or_else(|| PyRuntimeError::new_err("the results were taken before"))?;
        let joined = py.detach(|| thread.join());
        let found = joined.map_err(|_| PyRuntimeError::new_err("the run panicked: this is an error of colluvium"))?;
        found.map(|report| RunData { report: Some(report) }).map_err(|error| run_error(&error))
    }
}

impl Drop for RunTask {
    /// Stops a run whose results nobody can take.
    fn drop(&mut self) {
        self.stop();
    }
}

/// Follows a run to its end, and sends messages about its progress.
fn follow_run(case: Case, method: &'static dyn Method, options: RunOptions, channel: &SharedState) -> Outcome {
    let end = case.end_time();
    channel.send(("begin", end, 0, method.name().to_owned()));
    let run = Run::new(Arc::new(case), method, options)?;
    let mut last = Instant::now();
    run.finish_observed(|run, event| {
        let text = match event {
            RunEvent::Warning(warning) => Some(("warning", format!("[{}] {}", warning.code, warning.text))),
            RunEvent::Frame(_) => Some(("frame", String::new())),
            _ if event.search_message().is_some() => event.search_message().map(|text| ("search", text)),
            _ if last.elapsed() >= PROGRESS_INTERVAL => {
                last = Instant::now();
                Some(("progress", String::new()))
            }
            _ => None,
        };
        if let Some((kind, text)) = text {
            channel.send((kind, run.time(), run.solver().step_count(), text));
        }
    })
}

/// Results of a run.
#[pyclass(module = "colluvium")]
pub struct RunData {
    report: Option<RunReport>,
}

impl RunData {
    fn report(&self) -> PyResult<&RunReport> {
        self.report.as_ref().ok_or_else(|| PyRuntimeError::new_err("the frames were taken before"))
    }
}

/// Codes and texts of warnings.
fn texts(warnings: &[Warning]) -> Vec<(String, String)> {
    warnings.iter().map(|warning| (warning.code.to_string(), warning.text.clone())).collect()
}

#[pymethods]
impl RunData {
    /// Whether the run was stopped before its end.
    #[getter]
    fn is_interrupted(&self) -> PyResult<bool> {
        Ok(self.report()?.ending == RunEnd::Interrupted)
    }

    /// Number of steps.
    #[getter]
    fn steps(&self) -> PyResult<u64> {
        Ok(self.report()?.steps)
    }

    /// Wall-clock time (s).
    #[getter]
    fn wall(&self) -> PyResult<f64> {
        Ok(self.report()?.wall)
    }

    /// Codes and texts of the warnings about the results.
    #[getter]
    fn warnings(&self) -> PyResult<Vec<(String, String)>> {
        Ok(texts(&self.report()?.warnings_at_end))
    }

    /// Names and units of the columns of the measures, and their rows.
    fn measures<'py>(&self, py: Python<'py>) -> PyResult<(Vec<(String, String)>, Bound<'py, PyArray2<f64>>)> {
        let table = &self.report()?.table;
        let values = table.rows.iter().flatten().copied().collect::<Vec<f64>>();
        let shape = [table.rows.len(), table.columns.len()];
        let rows = numpy::PyArray1::from_vec(py, values).reshape(shape)?;
        Ok((table.columns.clone(), rows))
    }

    /// Name, factor, largest stable and smallest failing factor, and text of each search for a factor of safety. The factor is `None` where
    /// the search is undecided or outside its range.
    #[getter]
    fn safety(&self) -> PyResult<Vec<(String, Option<f64>, f64, f64, String)>> {
        let found = self.report()?.safety.iter();
        let of = |(name, found): (&String, &SafetyResult)| {
            (name.clone(), found.factor(), found.stable_factor, found.failing_factor, found.message())
        };
        Ok(found.map(of).collect())
    }

    /// Frames of the run, which are moved out.
    fn take_frames(&mut self) -> PyResult<Vec<Frame>> {
        let report = self.report.as_mut().ok_or_else(|| PyRuntimeError::new_err("the frames were taken before"))?;
        Ok(std::mem::take(&mut report.frames).into_iter().map(Frame::new).collect())
    }

    /// Points at the end.
    fn take_last(&mut self) -> PyResult<Frame> {
        let report = self.report.as_mut().ok_or_else(|| PyRuntimeError::new_err("the frames were taken before"))?;
        Ok(Frame::new(std::mem::take(&mut report.snapshot)))
    }
}
