//! Recorder of the case files and reference data that a benchmark reads, and of the runs that its page shows as animations.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use colluvium::case::{Case, RunReport};
use colluvium::output::run_pictures::view_plane_for_gravity;
use colluvium::plots::{Animation, Panel, View};
use rayon::ThreadPool;

use super::BenchmarkAnimation;

/// Largest number of runs of a benchmark that are shown as animations. The first ones are shown.
const MAX_ANIMATIONS: usize = 4;
/// Size of an animation (bytes).
const ANIMATION_BYTES: usize = 300_000;
/// Least number of frames, and of points, of an animation.
const MIN_FRAMES_AND_POINTS: [usize; 2] = [5, 30];

/// Recorder of the inputs and runs of the threads of a pool.
#[derive(Clone, Default)]
pub struct InputRecorder(Arc<Mutex<RecordedInputs>>);

/// Inputs and animations that a benchmark has recorded.
#[derive(Default)]
struct RecordedInputs {
    files: BTreeSet<String>,
    animations: Vec<BenchmarkAnimation>,
    runs: usize,
}

thread_local! {
    /// Recorder of the benchmark that runs on this thread.
    static OF_THREAD: RefCell<Option<InputRecorder>> = const { RefCell::new(None) };
}

impl InputRecorder {
    /// Attaches a recorder to all threads of `pool`.
    pub fn attach(pool: &ThreadPool) -> Self {
        let recorder = Self::default();
        pool.broadcast(|_| OF_THREAD.replace(Some(recorder.clone())));
        recorder
    }

    /// Files read, relative to the root of the repository, in order.
    pub fn files(&self) -> Vec<String> {
        self.record().files.iter().cloned().collect()
    }

    /// Animations, with the number of runs in their captions.
    pub fn animations(&self) -> Vec<BenchmarkAnimation> {
        let record = self.record();
        let copy = |film: &BenchmarkAnimation| BenchmarkAnimation {
            caption: format!("{} of {} runs", film.caption, record.runs),
            ..film.clone()
        };
        record.animations.iter().map(copy).collect()
    }

    /// Record, locked against other threads.
    fn record(&self) -> MutexGuard<'_, RecordedInputs> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Recorder of this thread; `None` outside of the benchmarks of `validate`.
fn of_thread() -> Option<InputRecorder> {
    OF_THREAD.with_borrow(Clone::clone)
}

/// Records a file that the benchmark of this thread reads.
pub fn record_file(path: &Path) {
    let name = path.strip_prefix(crate::root()).unwrap_or(path).to_string_lossy().into_owned();
    if let Some(recorder) = of_thread() {
        recorder.record().files.insert(name);
    }
}

/// Records a run of the benchmark of this thread, and an animation of the first runs.
pub fn record_run(method: &str, case: &Case, report: &RunReport) {
    let Some(recorder) = of_thread() else { return };
    let mut record = recorder.record();
    record.runs += 1;
    let counts = [report.frames.len(), report.snapshot.ids.len()];
    if record.animations.len() >= MAX_ANIMATIONS
        || counts[0] < MIN_FRAMES_AND_POINTS[0]
        || counts[1] < MIN_FRAMES_AND_POINTS[1]
    {
        return;
    }
    let panel = Panel {
        name: method.to_owned(),
        frames: report.frames.iter().collect(),
        frame_count: report.frames.len(),
    };
    let Ok(text) = serde_json::to_value(case) else { return };
    let plane = view_plane_for_gravity(case.gravity.get(2).copied(), None);
    let ground = colluvium::output::rigid_geometry::rigid_geometry(case);
    let view =
        View { bytes: ANIMATION_BYTES, ground, ..colluvium::output::animation::view(&text, plane, &[]) };
    if let Some(animation) = Animation::from_panels(&[panel], &view) {
        let caption = format!("{} ({method}): run {}", case.title, record.runs);
        record.animations.push(BenchmarkAnimation { caption, element: animation.element() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmarks::{load_case, run_mpm};

    fn pool(threads: usize) -> ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    #[test]
    fn the_files_of_a_benchmark_are_those_that_the_threads_of_its_pool_read() {
        let (one, two) = (pool(1), pool(2));
        let (first, second) = (InputRecorder::attach(&one), InputRecorder::attach(&two));
        one.install(|| load_case("mpm/bar")).unwrap();
        let (a, b) =
            two.install(|| rayon::join(|| load_case("mpm/slope-in-motion"), || load_case("sph/balance")));
        assert!(a.is_ok() && b.is_ok());
        assert_eq!(first.files(), ["validation/mpm/bar/case.json"]);
        assert_eq!(
            second.files(),
            ["validation/mpm/slope-in-motion/case.json", "validation/sph/balance/case.json"]
        );
        // The next benchmark of a pool begins without records.
        assert!(InputRecorder::attach(&one).files().is_empty());
    }

    #[test]
    fn the_first_runs_with_frames_are_kept_as_animations() {
        let pool = pool(1);
        let recorder = InputRecorder::attach(&pool);
        pool.install(|| {
            let mut case = load_case("mpm/two-disks").unwrap();
            case.stages[0].duration = 0.01;
            case.output.frames = Some(0.002);
            for _ in 0..=MAX_ANIMATIONS {
                run_mpm(&case).unwrap();
            }
        });
        let films = recorder.animations();
        assert_eq!(films.len(), MAX_ANIMATIONS);
        assert!(films[1].caption.ends_with("run 2 of 5 runs"), "{}", films[1].caption);
        assert!(films[0].element.starts_with("<div class=\"player\">"));
    }
}
