//! Messages of work on another thread.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use colluvium::case::{Frame, Warning};

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

    /// Sends a warning: its code and its text.
    pub fn warn(&self, warning: &Warning) {
        self.send(Message::text("warning", format!("[{}] {}", warning.code, warning.text)));
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

    /// Next message, waited for at most `wait`.
    pub fn take(&self, wait: Duration) -> Option<Message> {
        let waits = |messages: &mut Messages| messages.queue.is_empty() && !messages.is_finished;
        let found = self.changed.wait_timeout_while(self.messages(), wait, waits);
        let message = found.unwrap_or_else(PoisonError::into_inner).0.queue.pop_front();
        self.changed.notify_all();
        message
    }

    /// Whether the work has ended and all messages were taken.
    pub fn is_finished(&self) -> bool {
        let messages = self.messages();
        messages.is_finished && messages.queue.is_empty()
    }

    /// Stops the work at its next step.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// Says that no message follows.
    pub fn finish(&self) {
        self.messages().is_finished = true;
        self.changed.notify_all();
    }
}
