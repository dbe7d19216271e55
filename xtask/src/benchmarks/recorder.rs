//! What a benchmark reads, its case files and reference data, and the runs of which its page shows an animation.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use colluvium::case::{Case, RunReport};
use colluvium::pictures::plane_under;
use colluvium::plots::{Animation, Panel, View};
use rayon::ThreadPool;

use super::Film;

/// Runs of a benchmark that are shown as animations, at most: the first ones.
const FILMS: usize = 4;
/// Bytes of an animation.
const BYTES: usize = 300_000;
/// Frames and points below which there is nothing to see.
const LEAST: [usize; 2] = [5, 30];

/// Follows what the threads of a pool do.
#[derive(Clone, Default)]
pub struct Recorder(Arc<Mutex<Record>>);

#[derive(Default)]
struct Record {
    files: BTreeSet<String>,
    films: Vec<Film>,
    runs: usize,
}

thread_local! {
    static OF_THREAD: RefCell<Option<Recorder>> = const { RefCell::new(None) };
}

impl Recorder {
    /// Of what the threads of `pool` do from now on.
    pub fn follow(pool: &ThreadPool) -> Self {
        let recorder = Self::default();
        pool.broadcast(|_| OF_THREAD.replace(Some(recorder.clone())));
        recorder
    }

    /// The files read, below the root of the repository, in order.
    pub fn files(&self) -> Vec<String> {
        self.record().files.iter().cloned().collect()
    }

    /// The animations, each with its place among the runs.
    pub fn films(&self) -> Vec<Film> {
        let record = self.record();
        let told = |film: &Film| Film {
            caption: format!("{} of {} runs", film.caption, record.runs),
            ..film.clone()
        };
        record.films.iter().map(told).collect()
    }

    fn record(&self) -> MutexGuard<'_, Record> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The recorder of this thread; none outside of the benchmarks of `validate`.
fn of_thread() -> Option<Recorder> {
    OF_THREAD.with_borrow(Clone::clone)
}

/// Notes that the benchmark of this thread reads a file.
pub fn reads(path: &Path) {
    let name = path.strip_prefix(crate::root()).unwrap_or(path).to_string_lossy().into_owned();
    if let Some(recorder) = of_thread() {
        recorder.record().files.insert(name);
    }
}

/// Notes a run of the benchmark of this thread, and keeps an animation of the first ones.
pub fn ran(method: &str, case: &Case, report: &RunReport) {
    let Some(recorder) = of_thread() else { return };
    let mut record = recorder.record();
    record.runs += 1;
    let seen = [report.frames.len(), report.snapshot.ids.len()];
    if record.films.len() >= FILMS || seen[0] < LEAST[0] || seen[1] < LEAST[1] {
        return;
    }
    let panel =
        Panel { name: method.to_owned(), frames: report.frames.iter().collect(), of: report.frames.len() };
    let Ok(text) = serde_json::to_value(case) else { return };
    let plane = plane_under(case.gravity.get(2).copied(), None);
    let ground = colluvium::ground::ground(case);
    let view = View { bytes: BYTES, ground, ..colluvium::animation::view(&text, plane, &[]) };
    if let Some(animation) = Animation::of(&[panel], &view) {
        let caption = format!("{} ({method}): run {}", case.title, record.runs);
        record.films.push(Film { caption, element: animation.element() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmarks::{case, run};

    fn pool(threads: usize) -> ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    #[test]
    fn the_files_of_a_benchmark_are_those_that_the_threads_of_its_pool_read() {
        let (one, two) = (pool(1), pool(2));
        let (first, second) = (Recorder::follow(&one), Recorder::follow(&two));
        one.install(|| case("mpm/bar")).unwrap();
        let (a, b) = two.install(|| rayon::join(|| case("mpm/slope-in-motion"), || case("sph/balance")));
        assert!(a.is_ok() && b.is_ok());
        assert_eq!(first.files(), ["validation/mpm/bar/case.json"]);
        assert_eq!(
            second.files(),
            ["validation/mpm/slope-in-motion/case.json", "validation/sph/balance/case.json"]
        );
        // The next benchmark of a pool begins with none.
        assert!(Recorder::follow(&one).files().is_empty());
    }

    #[test]
    fn the_first_runs_with_frames_are_kept_as_animations() {
        let pool = pool(1);
        let recorder = Recorder::follow(&pool);
        pool.install(|| {
            let mut case = case("mpm/two-disks").unwrap();
            case.stages[0].duration = 0.01;
            case.output.frames = Some(0.002);
            for _ in 0..=FILMS {
                run(&case).unwrap();
            }
        });
        let films = recorder.films();
        assert_eq!(films.len(), FILMS);
        assert!(films[1].caption.ends_with("run 2 of 5 runs"), "{}", films[1].caption);
        assert!(films[0].element.starts_with("<div class=\"player\">"));
    }
}
