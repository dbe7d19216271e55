//! Exceptions of laws in Python, which come out as the causes of errors.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;

/// Exceptions of laws that nobody has received yet, by their numbers in texts.
static EXCEPTIONS: Mutex<(u64, BTreeMap<u64, PyErr>)> = Mutex::new((0, BTreeMap::new()));

thread_local! {
    /// First exception of a law in the element test of this thread.
    static FIRST: RefCell<Option<PyErr>> = const { RefCell::new(None) };
    /// Whether an element test runs on this thread.
    static TESTS: Cell<bool> = const { Cell::new(false) };
}

/// Calls a function that runs an element test on this thread, and returns its result with the first exception of a law.
pub fn with_first<T>(test: impl FnOnce() -> T) -> (T, Option<PyErr>) {
    FIRST.take();
    TESTS.set(true);
    let result = test();
    TESTS.set(false);
    (result, FIRST.take())
}

/// Whether an element test runs on this thread.
pub fn is_testing() -> bool {
    TESTS.get()
}

/// Whether a law on this thread has raised an exception that nobody has taken.
pub fn has_first() -> bool {
    FIRST.with_borrow(Option::is_some)
}

/// Keeps the first exception of a law on this thread, so that it ends an element test whose driver goes on.
pub fn keep_first(error: &PyErr) {
    FIRST.with_borrow_mut(|first| {
        if first.is_none() {
            *first = Python::attach(|py| Some(error.clone_ref(py)));
        }
    });
}

/// Marks of the number of an exception in a text.
const MARKS: [&str; 2] = ["\u{2}exception ", "\u{3}"];

/// Most exceptions that are kept until an error takes one.
const MAX_EXCEPTIONS: usize = 16;

/// Text of an exception of a law, with a number under which it is kept.
pub fn keep_exception(error: PyErr) -> String {
    let text = error.to_string();
    let mut kept = EXCEPTIONS.lock().unwrap_or_else(PoisonError::into_inner);
    // All points of a step may raise the same exception.
    if kept.1.len() < MAX_EXCEPTIONS {
        kept.0 += 1;
        let number = kept.0;
        kept.1.insert(number, error);
    }
    format!("{text}{}{}{}", MARKS[0], kept.0, MARKS[1])
}

/// Text without the number of an exception, and the exception.
pub fn without_number(text: &str) -> (String, Option<PyErr>) {
    let (mut clean, mut cause) = (String::new(), None);
    let mut rest = text;
    while let Some((before, after)) = rest.split_once(MARKS[0]) {
        let (number, after) = after.split_once(MARKS[1]).unwrap_or((after, ""));
        if let Ok(number) = number.parse() {
            let mut kept = EXCEPTIONS.lock().unwrap_or_else(PoisonError::into_inner);
            cause = cause.or(kept.1.remove(&number));
            kept.1.clear();
        }
        clean.push_str(before);
        rest = after;
    }
    clean.push_str(rest);
    (clean, cause)
}
