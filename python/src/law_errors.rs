//! Exceptions of laws in Python, which come out as the causes of errors.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use pyo3::PyErr;

/// Exceptions of laws that nobody has received yet, by their numbers in texts.
static EXCEPTIONS: Mutex<(u64, BTreeMap<u64, PyErr>)> = Mutex::new((0, BTreeMap::new()));

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
