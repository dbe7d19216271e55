//! Exceptions of laws in Python, which come out as the causes of errors.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;

/// Exceptions of laws that nobody has received yet, by their texts, which the errors of a run contain.
static EXCEPTIONS: Mutex<BTreeMap<String, PyErr>> = Mutex::new(BTreeMap::new());

/// Most exceptions that are kept: all points of a step may raise one.
const MAX_EXCEPTIONS: usize = 4096;

thread_local! {
    /// First exception of a law in the element test of this thread.
    static FIRST: RefCell<Option<PyErr>> = const { RefCell::new(None) };
    /// Whether an element test runs on this thread.
    static TESTS: Cell<bool> = const { Cell::new(false) };
}

/// Calls a function that runs an element test on this thread, and returns its result with the first exception of a law.
pub fn with_first<T>(test: impl FnOnce() -> T) -> (T, Option<PyErr>) {
    // A law may run an element test of its own.
    let outer = (FIRST.take(), TESTS.replace(true));
    let result = test();
    TESTS.set(outer.1);
    (result, FIRST.replace(outer.0))
}

/// Whether an element test runs on this thread.
pub fn is_testing() -> bool {
    TESTS.get()
}

/// Whether a law has raised an exception in the element test of this thread.
pub fn has_first() -> bool {
    FIRST.with_borrow(Option::is_some)
}

/// Keeps the first exception of a law on this thread, so that it ends an element test whose driver goes on.
pub fn keep_first(error: PyErr) {
    FIRST.with_borrow_mut(|first| {
        first.get_or_insert(error);
    });
}

/// Text of an exception of a law, by which `take_cause` finds it.
pub fn keep_exception(error: PyErr) -> String {
    let text = error.to_string();
    let mut kept = EXCEPTIONS.lock().unwrap_or_else(PoisonError::into_inner);
    if kept.len() < MAX_EXCEPTIONS {
        kept.insert(text.clone(), error);
    }
    text
}

/// Exception whose text is in that of an error; all that were kept are forgotten then.
pub fn take_cause(text: &str) -> Option<PyErr> {
    let mut kept = EXCEPTIONS.lock().unwrap_or_else(PoisonError::into_inner);
    let found = kept.keys().filter(|own| text.contains(own.as_str())).max_by_key(|own| own.len())?.clone();
    let cause = kept.remove(&found);
    kept.clear();
    cause
}
