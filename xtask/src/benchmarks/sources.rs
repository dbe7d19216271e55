//! Which files a benchmark reads: its case files and reference data.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::ThreadPool;

/// The files that the threads of a pool read, from the time it follows them.
#[derive(Clone, Default)]
pub struct Sources(Arc<Mutex<BTreeSet<String>>>);

thread_local! {
    static OF_THREAD: RefCell<Option<Sources>> = const { RefCell::new(None) };
}

impl Sources {
    /// Of what the threads of `pool` read from now on.
    pub fn follow(pool: &ThreadPool) -> Self {
        let sources = Self::default();
        pool.broadcast(|_| OF_THREAD.replace(Some(sources.clone())));
        sources
    }

    /// The files, below the root of the repository, in order.
    pub fn files(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).iter().cloned().collect()
    }
}

/// Notes that the benchmark of this thread reads a file.
pub fn reads(path: &Path) {
    let name = path.strip_prefix(crate::root()).unwrap_or(path).to_string_lossy().into_owned();
    OF_THREAD.with_borrow(|sources| {
        if let Some(Sources(files)) = sources {
            files.lock().unwrap_or_else(PoisonError::into_inner).insert(name);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmarks::case;

    #[test]
    fn the_files_of_a_benchmark_are_those_that_the_threads_of_its_pool_read() {
        let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (one, two) = (pool(1), pool(2));
        let (first, second) = (Sources::follow(&one), Sources::follow(&two));
        one.install(|| case("mpm/bar")).unwrap();
        let (a, b) = two.install(|| rayon::join(|| case("mpm/slope-in-motion"), || case("sph/balance")));
        assert!(a.is_ok() && b.is_ok());
        assert_eq!(first.files(), ["validation/mpm/bar/case.json"]);
        assert_eq!(
            second.files(),
            ["validation/mpm/slope-in-motion/case.json", "validation/sph/balance/case.json"]
        );
        // The next benchmark of a pool begins with none.
        assert!(Sources::follow(&one).files().is_empty());
    }
}
