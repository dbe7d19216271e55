//! Cache of the outcomes of benchmarks: a benchmark is not run again while the program and the files that it reads are unchanged.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::benchmarks::{Benchmark, BenchmarkOutcome, CheckVerdict};
use crate::report::BenchmarkEntry;

/// Folder of cached outcomes.
pub struct OutcomeCache {
    /// Root of the files of benchmarks.
    root: PathBuf,
    folder: PathBuf,
    /// Hash of the program, which contains every benchmark and all code that it calls.
    program_hash: u64,
}

/// Cached outcome with its dependencies.
#[derive(Serialize, Deserialize)]
struct CachedOutcome {
    program: u64,
    /// Files with the hashes of their contents.
    files: Vec<(String, u64)>,
    seconds: f64,
    outcome: BenchmarkOutcome,
}

/// Hash of some bytes.
fn content_hash(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    hasher.finish()
}

impl OutcomeCache {
    /// Opens the cache of this program and repository.
    pub fn load() -> Result<Self, String> {
        let program = std::env::current_exe().and_then(std::fs::read);
        let program =
            content_hash(&program.map_err(|error| format!("this program cannot be read: {error}"))?);
        let root = crate::root().to_owned();
        Ok(Self { folder: root.join("target/validation/kept"), root, program_hash: program })
    }

    /// File of the outcome of a benchmark, in its short or full form.
    fn file(&self, benchmark: &Benchmark, short: bool) -> PathBuf {
        let form = if short { "short" } else { "full" };
        self.folder.join(format!("{}.{form}", benchmark.id.replace('/', ".")))
    }

    /// Hash of a file; `None` where it does not exist.
    fn file_hash(&self, file: &str) -> Option<u64> {
        std::fs::read(self.root.join(Path::new(file))).ok().map(|bytes| content_hash(&bytes))
    }

    /// Cached entry of a benchmark whose program and files have not changed since; `None` otherwise.
    pub fn entry(&self, benchmark: &'static Benchmark, is_short: bool) -> Option<BenchmarkEntry> {
        let bytes = std::fs::read(self.file(benchmark, is_short)).ok()?;
        let kept: CachedOutcome = postcard::from_bytes(&bytes).ok()?;
        let same = |(file, mark): &(String, u64)| self.file_hash(file) == Some(*mark);
        let CachedOutcome { program, files, seconds, outcome } = kept;
        (program == self.program_hash && files.iter().all(same)).then(|| BenchmarkEntry {
            benchmark,
            is_short,
            outcome,
            error: None,
            seconds,
            files: files.into_iter().map(|(file, _)| file).collect(),
            cached: true,
        })
    }

    /// Stores the entry of a benchmark. A failed one is not stored, so that it runs again.
    pub fn store(&self, entry: BenchmarkEntry) -> Result<BenchmarkEntry, String> {
        let file = self.file(entry.benchmark, entry.is_short);
        let marks: Option<Vec<(String, u64)>> =
            entry.files.iter().map(|name| Some((name.clone(), self.file_hash(name)?))).collect();
        let Some(files) = marks.filter(|_| entry.error.is_none() && entry.count(CheckVerdict::Fail) == 0)
        else {
            // The earlier outcome is of another state.
            let _ = std::fs::remove_file(&file);
            return Ok(entry);
        };
        let kept = CachedOutcome {
            program: self.program_hash,
            files,
            seconds: entry.seconds,
            outcome: entry.outcome,
        };
        let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
        let bytes = postcard::to_stdvec(&kept).map_err(|error| wrong(&error))?;
        std::fs::create_dir_all(&self.folder).map_err(|error| wrong(&error))?;
        colluvium::case::output::write_atomically(&file, &bytes).map_err(|error| error.to_string())?;
        Ok(BenchmarkEntry { outcome: kept.outcome, ..entry })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmarks::all_benchmarks;

    fn entry(measured: f64) -> BenchmarkEntry {
        let mut outcome = BenchmarkOutcome::default();
        outcome.assert_below("a bound without a lower end", "1", measured, 1.0, "closed form");
        outcome.info("nothing", "–", f64::NAN, "shown");
        let benchmark = all_benchmarks().next().unwrap();
        let files = vec!["case.json".to_owned()];
        BenchmarkEntry { benchmark, is_short: true, outcome, error: None, seconds: 2.5, files, cached: false }
    }

    #[test]
    fn a_benchmark_is_kept_until_program_or_case_change_and_never_when_it_fails() {
        let folder = tempfile::tempdir().unwrap();
        let case = folder.path().join("case.json");
        std::fs::write(&case, "{}").unwrap();
        let store = |program| OutcomeCache {
            root: folder.path().to_owned(),
            folder: folder.path().join("kept"),
            program_hash: program,
        };
        let benchmark = all_benchmarks().next().unwrap();
        assert!(store(1).entry(benchmark, true).is_none());
        store(1).store(entry(0.5)).unwrap();
        let found = store(1).entry(benchmark, true).unwrap();
        let checks = &found.outcome.checks;
        assert!(found.cached && found.seconds == 2.5 && found.files == ["case.json"]);
        assert_eq!((checks[0].measured, checks[0].range), (0.5, Some((f64::NEG_INFINITY, 1.0))));
        assert!(checks[1].measured.is_nan() && checks[1].range.is_none());
        assert!(store(1).entry(benchmark, false).is_none(), "another form");
        assert!(store(2).entry(benchmark, true).is_none(), "another program");
        std::fs::write(&case, "{ }").unwrap();
        assert!(store(1).entry(benchmark, true).is_none(), "another case");
        store(1).store(entry(0.5)).unwrap();
        assert!(store(1).entry(benchmark, true).is_some());
        store(1).store(entry(1.5)).unwrap();
        assert!(store(1).entry(benchmark, true).is_none(), "it fails");
    }
}
