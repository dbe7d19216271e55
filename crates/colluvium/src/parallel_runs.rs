//! Several simultaneous runs, each on its own threads.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Calls `work` for all numbers below `count`, `jobs` of them simultaneously, each on a thread pool of `threads` threads. A failure ends
/// the work of its thread; the others continue.
///
/// # Errors
/// The first failure in the order of the threads; `lost` makes the error of threads that the system does not start or that panic.
pub(crate) fn run_in_parallel<E: Send>(
    count: usize,
    (jobs, threads): (usize, usize),
    work: impl Fn(usize) -> Result<(), E> + Sync,
    lost: impl Fn(String) -> E + Sync,
) -> Result<(), E> {
    let next = AtomicUsize::new(0);
    let all = || -> Result<(), E> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
        let pool = pool.map_err(|error| lost(error.to_string()))?;
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                return Ok(());
            }
            pool.install(|| work(number))?;
        }
    };
    let ends: Vec<Result<(), E>> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..jobs.clamp(1, count.max(1))).map(|_| scope.spawn(all)).collect();
        let joined = |worker: std::thread::ScopedJoinHandle<'_, Result<(), E>>| {
            worker.join().unwrap_or_else(|_| Err(lost("a thread panicked".to_owned())))
        };
        workers.into_iter().map(joined).collect()
    });
    ends.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn each_task_runs_once_and_a_failure_is_returned() {
        let done = Mutex::new(vec![0; 9]);
        let work = |number: usize| {
            done.lock().unwrap()[number] += rayon::current_num_threads();
            if number == 4 { Err("four".to_owned()) } else { Ok(()) }
        };
        assert_eq!(run_in_parallel(9, (3, 2), work, |text| text), Err("four".to_owned()));
        assert_eq!(*done.lock().unwrap(), [2; 9]);
        assert_eq!(run_in_parallel(0, (3, 2), work, |text| text), Ok(()));
    }
}
