//! Long work on a thread of its own: runs, sweeps and comparisons, with messages to Python while they go on.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use colluvium::case::Frame;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::comparisons::{CompareData, CompareRequest};
use crate::errors::{TaskError, value_error};
use crate::frames::FrameData;
use crate::runs::{RunData, RunRequest};
use crate::sweeps::{SweepData, SweepRequest};

/// Longest wait of a task for a reader before it looks whether it is stopped.
const READER_INTERVAL: Duration = Duration::from_millis(20);

/// Message of a task.
pub struct Message {
    /// Kind: `begin`, `progress`, `row`, `warning`, `search`, `frame` or `done`.
    pub kind: &'static str,
    /// Time of the run (s).
    pub time: f64,
    /// Number of steps of the run.
    pub step: u64,
    /// Text of the message.
    pub text: String,
    /// Frame of a message of that kind.
    pub frame: Option<Frame>,
}

impl Message {
    /// Message without a state of a run.
    pub fn text(kind: &'static str, text: String) -> Self {
        Self { kind, time: 0.0, step: 0, text, frame: None }
    }
}

/// Kind, time (s), step, text and frame of a message.
type MessageRow = (&'static str, f64, u64, String, Option<Py<FrameData>>);

/// Messages that Python has not taken.
#[derive(Default)]
struct Messages {
    queue: VecDeque<Message>,
    is_finished: bool,
}

/// State shared by the thread of a task and Python.
#[derive(Default)]
pub struct Channel {
    messages: Mutex<Messages>,
    changed: Condvar,
    /// Flag that stops the task at its next step.
    pub stop: Arc<AtomicBool>,
}

impl Channel {
    fn messages(&self) -> MutexGuard<'_, Messages> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends a message.
    pub fn send(&self, message: Message) {
        self.messages().queue.push_back(message);
        self.changed.notify_all();
    }

    /// Sends a message, and waits until Python has taken all messages or has stopped the task.
    pub fn send_and_wait(&self, message: Message) {
        self.send(message);
        let mut messages = self.messages();
        while !messages.queue.is_empty() && !self.stop.load(Ordering::Relaxed) {
            let waited = self.changed.wait_timeout(messages, READER_INTERVAL);
            messages = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn finish(&self) {
        self.messages().is_finished = true;
        self.changed.notify_all();
    }
}

/// Finishes a channel when the thread of a task ends, by a panic as well.
struct Finish(Arc<Channel>);

impl Drop for Finish {
    fn drop(&mut self) {
        self.0.finish();
    }
}

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
        if threads == Some(0) {
            return Err(value_error(&"threads: 0 is not a number of threads"));
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
        let request = CompareRequest { text, folder, methods, out, jobs, resume, overwrite, reference };
        Self::start(threads, move |channel| request.run(channel).map(TaskResult::Compare))
    }

    /// Next message: kind, time (s), step, text and frame, waited for at most `seconds`; `None` without one.
    fn wait(&self, py: Python<'_>, seconds: f64) -> PyResult<Option<MessageRow>> {
        self.check_process()?;
        let found = py.detach(|| {
            let waits = |messages: &mut Messages| messages.queue.is_empty() && !messages.is_finished;
            let wait = Duration::from_secs_f64(seconds.clamp(0.0, 60.0));
            let found = self.channel.changed.wait_timeout_while(self.channel.messages(), wait, waits);
            let message = found.unwrap_or_else(PoisonError::into_inner).0.queue.pop_front();
            self.channel.changed.notify_all();
            message
        });
        let Some(Message { kind, time, step, text, frame }) = found else { return Ok(None) };
        let frame = frame.map(|frame| FrameData::new(py, frame)).transpose()?;
        Ok(Some((kind, time, step, text, frame)))
    }

    /// Whether the work has ended and all its messages were taken.
    fn is_finished(&self) -> bool {
        let messages = self.channel.messages();
        messages.is_finished && messages.queue.is_empty()
    }

    /// Stops the work at the next step.
    fn stop(&self) {
        self.channel.stop.store(true, Ordering::Relaxed);
        self.channel.changed.notify_all();
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
