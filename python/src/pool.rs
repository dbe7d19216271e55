//! Thread pool of calls that wait for their result. Runs have pools of their own.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;

use crate::errors::value_error;

/// Process and pool of the calls. A fork copies no threads: another process makes a pool of its own.
static POOL: Mutex<Option<(u32, Arc<rayon::ThreadPool>)>> = Mutex::new(None);

/// Calls a function in the pool, while the interpreter is free.
///
/// # Errors
/// `ValueError` when the system gives no threads.
pub fn in_pool<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| {
        let pool = {
            let mut kept = POOL.lock().unwrap_or_else(PoisonError::into_inner);
            match &*kept {
                Some((process, pool)) if *process == std::process::id() => Arc::clone(pool),
                _ => {
                    let pool = rayon::ThreadPoolBuilder::new().build();
                    let pool = Arc::new(pool.map_err(|error| value_error(&format!("threads: {error}")))?);
                    // The threads of the pool of another process cannot be waited for.
                    std::mem::forget(kept.replace((std::process::id(), Arc::clone(&pool))));
                    pool
                }
            }
        };
        Ok(pool.install(work))
    })
}
