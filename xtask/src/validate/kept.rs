//! What earlier runs of benchmarks found: a benchmark is not run again while the program and the files that it reads are the same.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::benchmarks::{Benchmark, Outcome, Verdict};
use crate::report::Entry;

/// Where outcomes are kept.
pub struct Store {
    /// Below which the files of benchmarks are.
    root: PathBuf,
    folder: PathBuf,
    /// Mark of the program: every benchmark and all that it calls is in it.
    program: u64,
}

/// An outcome with what it depends on.
#[derive(Serialize, Deserialize)]
struct Kept {
    program: u64,
    /// Files with the marks of what they hold.
    files: Vec<(String, u64)>,
    seconds: f64,
    outcome: Outcome,
}

/// A mark of some bytes.
fn mark(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    hasher.finish()
}

impl Store {
    /// That of this program and repository.
    pub fn open() -> Result<Self, String> {
        let program = std::env::current_exe().and_then(std::fs::read);
        let program = mark(&program.map_err(|error| format!("this program cannot be read: {error}"))?);
        let root = crate::root().to_owned();
        Ok(Self { folder: root.join("target/validation/kept"), root, program })
    }

    fn file(&self, benchmark: &Benchmark, short: bool) -> PathBuf {
        let form = if short { "short" } else { "full" };
        self.folder.join(format!("{}.{form}", benchmark.id.replace('/', ".")))
    }

    fn mark_of(&self, file: &str) -> Option<u64> {
        std::fs::read(self.root.join(Path::new(file))).ok().map(|bytes| mark(&bytes))
    }

    /// What a benchmark found before, where nothing that it depends on has changed since.
    pub fn find(&self, benchmark: &'static Benchmark, short: bool) -> Option<Entry> {
        let bytes = std::fs::read(self.file(benchmark, short)).ok()?;
        let kept: Kept = postcard::from_bytes(&bytes).ok()?;
        let same = |(file, mark): &(String, u64)| self.mark_of(file) == Some(*mark);
        let Kept { program, files, seconds, outcome } = kept;
        (program == self.program && files.iter().all(same)).then(|| Entry {
            benchmark,
            short,
            outcome,
            error: None,
            seconds,
            files: files.into_iter().map(|(file, _)| file).collect(),
            kept: true,
        })
    }

    /// Keeps what a benchmark found; not of one that fails, which runs again.
    pub fn keep(&self, entry: Entry) -> Result<Entry, String> {
        let file = self.file(entry.benchmark, entry.short);
        let marks: Option<Vec<(String, u64)>> =
            entry.files.iter().map(|name| Some((name.clone(), self.mark_of(name)?))).collect();
        let Some(files) = marks.filter(|_| entry.error.is_none() && entry.count(Verdict::Fail) == 0) else {
            // What was kept before is of another state.
            let _ = std::fs::remove_file(&file);
            return Ok(entry);
        };
        let kept = Kept { program: self.program, files, seconds: entry.seconds, outcome: entry.outcome };
        let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
        let bytes = postcard::to_stdvec(&kept).map_err(|error| wrong(&error))?;
        std::fs::create_dir_all(&self.folder).map_err(|error| wrong(&error))?;
        colluvium::case::output::write_atomically(&file, &bytes).map_err(|error| error.to_string())?;
        Ok(Entry { outcome: kept.outcome, ..entry })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmarks::all;

    fn entry(measured: f64) -> Entry {
        let mut outcome = Outcome::default();
        outcome.below("a bound without a lower end", "1", measured, 1.0, "closed form");
        outcome.show("nothing", "–", f64::NAN, "shown");
        let benchmark = all().next().unwrap();
        let files = vec!["case.json".to_owned()];
        Entry { benchmark, short: true, outcome, error: None, seconds: 2.5, files, kept: false }
    }

    #[test]
    fn a_benchmark_is_kept_until_program_or_case_change_and_never_when_it_fails() {
        let folder = tempfile::tempdir().unwrap();
        let case = folder.path().join("case.json");
        std::fs::write(&case, "{}").unwrap();
        let store =
            |program| Store { root: folder.path().to_owned(), folder: folder.path().join("kept"), program };
        let benchmark = all().next().unwrap();
        assert!(store(1).find(benchmark, true).is_none());
        store(1).keep(entry(0.5)).unwrap();
        let found = store(1).find(benchmark, true).unwrap();
        let checks = &found.outcome.checks;
        assert!(found.kept && found.seconds == 2.5 && found.files == ["case.json"]);
        assert_eq!((checks[0].measured, checks[0].range), (0.5, Some((f64::NEG_INFINITY, 1.0))));
        assert!(checks[1].measured.is_nan() && checks[1].range.is_none());
        assert!(store(1).find(benchmark, false).is_none(), "another form");
        assert!(store(2).find(benchmark, true).is_none(), "another program");
        std::fs::write(&case, "{ }").unwrap();
        assert!(store(1).find(benchmark, true).is_none(), "another case");
        store(1).keep(entry(0.5)).unwrap();
        assert!(store(1).find(benchmark, true).is_some());
        store(1).keep(entry(1.5)).unwrap();
        assert!(store(1).find(benchmark, true).is_none(), "it fails");
    }
}
