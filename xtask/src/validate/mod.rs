//! `cargo xtask validate`.
//!
//! A check that fails makes the command fail, unless `validation/open-defects.json` lists it: it is then still shown as a failure, with its
//! defect record, and counted apart.

mod cache;
mod progress;

use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use clap::Args;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::benchmarks::{Benchmark, BenchmarkOutcome, CheckVerdict, InputRecorder, all_benchmarks};
use crate::open_defects::{self, DefectRecord};
use crate::report;
use crate::report::{BenchmarkEntry, ReportScope};
use crate::validate::cache::OutcomeCache;
use progress::ValidationProgress;

#[derive(Args)]
pub struct ValidateArguments {
    /// Names of benchmarks, or parts of names: a part that is no name selects all benchmarks whose name contains it.
    names: Vec<String>,
    /// Run the short form of each benchmark.
    #[arg(long)]
    quick: bool,
    /// Run also the full form of the benchmarks that take minutes each: without it they run in their short form, or
    /// not at all if they have none.
    #[arg(long, conflicts_with = "quick")]
    long: bool,
    /// Run also unchanged benchmarks: without it a benchmark that did not fail is not run again while the program and the files that
    /// it reads are unchanged.
    #[arg(long)]
    all: bool,
    /// List the benchmarks and their expected seconds on one core.
    #[arg(long)]
    list: bool,
}

/// Time (s) above which the full form of a benchmark runs with `--long` only. On two cores the other benchmarks take less than ten minutes.
const LONG_SECONDS: u32 = 50;

/// Time (s) above which even the short form of a benchmark is left out without `--quick` or `--long`.
const LONG_SHORT_SECONDS: u32 = 70;

impl ValidateArguments {
    /// Whether a benchmark is requested: by its name, by a part of it that is not the name of another one, or because all are.
    fn is_requested(&self, benchmark: &Benchmark) -> bool {
        let asks = |name: &String| match all_benchmarks().find(|other| other.id == name.as_str()) {
            Some(one) => one.id == benchmark.id,
            None => benchmark.id.contains(name.as_str()),
        };
        self.names.is_empty() || self.names.iter().any(asks)
    }

    /// Whether a benchmark runs in its short form; `None` where it is left out.
    fn is_short_run(&self, benchmark: &Benchmark) -> Option<bool> {
        let short = self.quick || (benchmark.full_seconds > LONG_SECONDS && !self.long);
        let fits = |seconds: &u32| self.quick || *seconds <= LONG_SHORT_SECONDS;
        if short { benchmark.short_seconds.filter(fits).map(|_| true) } else { Some(false) }
    }
}

/// Runs the benchmarks; returns whether all checks pass.
pub fn run(arguments: &ValidateArguments) -> Result<bool, String> {
    let chosen: Vec<&'static Benchmark> =
        all_benchmarks().filter(|benchmark| arguments.is_requested(benchmark)).collect();
    if arguments.list {
        list(&chosen);
        return Ok(true);
    }
    let form = |&benchmark: &&'static Benchmark| {
        Some(BenchmarkJob { benchmark, is_short: arguments.is_short_run(benchmark)? })
    };
    let work: Vec<BenchmarkJob> = chosen.iter().filter_map(form).collect();
    if work.is_empty() {
        let names = arguments.names.join(" or ");
        return Err(format!("no benchmark's name contains {names:?}, or it needs --long; see --list"));
    }
    let left_out = chosen.iter().filter(|benchmark| arguments.is_short_run(benchmark).is_none());
    let scope = ReportScope {
        filter: (!arguments.names.is_empty()).then(|| arguments.names.join(" ")),
        quick: arguments.quick,
        short_count: work.iter().filter(|work| work.is_short).count(),
        full_count: work.iter().filter(|work| !work.is_short).count(),
        skipped_benchmarks: left_out.map(|benchmark| benchmark.id).collect(),
    };
    println!("{}", scope.text());
    let known = KnownResults { store: OutcomeCache::load()?, defects: open_defects::read_all()? };
    let entries = all_entries(&work, &known, arguments.all)?;
    let folder = scope.folder();
    report::write(&folder, &entries, &scope)?;
    let failed = entries.iter().filter(|entry| !entry.passes()).count();
    let checks: usize = entries.iter().map(BenchmarkEntry::judged_checks).sum();
    let shown: usize = entries.iter().map(|entry| entry.count(CheckVerdict::Unbounded)).sum();
    println!(
        "\n{}\n{checks} checks in {} benchmarks, {failed} benchmarks failed; {}; {shown} values shown without bounds",
        scope.text(),
        entries.len(),
        report::open_defect_text(&entries)
    );
    println!("report: {}", folder.join("index.html").display());
    Ok(failed == 0)
}

/// Benchmark to be run, in its short or full form.
struct BenchmarkJob {
    benchmark: &'static Benchmark,
    is_short: bool,
}

impl BenchmarkJob {
    /// Expected time on one core (s).
    fn seconds(&self) -> u32 {
        if self.is_short {
            self.benchmark.short_seconds.unwrap_or(self.benchmark.full_seconds)
        } else {
            self.benchmark.full_seconds
        }
    }
}

/// Cached outcomes and known defects.
struct KnownResults {
    store: OutcomeCache,
    defects: Vec<DefectRecord>,
}

impl KnownResults {
    /// Cached entry of an unchanged benchmark; `None` where it fails by the current defect records.
    fn cached_entry(&self, work: &BenchmarkJob) -> Option<BenchmarkEntry> {
        let mut entry = self.store.entry(work.benchmark, work.is_short)?;
        self.attach_defects(work.benchmark, &mut entry.outcome);
        entry.passes().then_some(entry)
    }

    /// Attaches the defect records to the checks.
    fn attach_defects(&self, benchmark: &Benchmark, outcome: &mut BenchmarkOutcome) {
        for check in &mut outcome.checks {
            check.defect = open_defects::find_defect(&self.defects, benchmark.id, &check.name);
        }
    }
}

/// Entries of all benchmarks, in their order: cached ones where unchanged, the others from their runs.
fn all_entries(
    work: &[BenchmarkJob],
    known: &KnownResults,
    again: bool,
) -> Result<Vec<BenchmarkEntry>, String> {
    let find = |work: &BenchmarkJob| if again { None } else { known.cached_entry(work) };
    let mut entries: Vec<Option<BenchmarkEntry>> = work.iter().map(find).collect();
    let kept = entries.iter().flatten().count();
    if kept > 0 {
        println!("{kept} of them are unchanged since their last run and are not run again (--all runs them)");
    }
    let open: Vec<usize> = (0..work.len()).filter(|&number| entries[number].is_none()).collect();
    for (number, entry) in run_jobs(work, open, known)? {
        entries[number] = Some(entry?);
    }
    Ok(entries.into_iter().flatten().collect())
}

/// Index of a benchmark and its entry, or the reason why the entry could not be stored.
type JobResult = (usize, Result<BenchmarkEntry, String>);

/// Runs benchmarks, as many simultaneously as there are cores, the longest first. Most are too small for many threads, and results do not
/// depend on their number. Each is stored when complete, so that an interrupted validation can continue.
fn run_jobs(
    work: &[BenchmarkJob],
    mut order: Vec<usize>,
    known: &KnownResults,
) -> Result<Vec<JobResult>, String> {
    if order.is_empty() {
        return Ok(Vec::new());
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = cores.min(order.len());
    order.sort_by_key(|&number| std::cmp::Reverse(work[number].seconds()));
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let progress = ValidationProgress::new(order.iter().map(|&number| work[number].seconds()), workers);
    println!("{}", progress.header_text());
    let pools: Vec<_> = (0..workers)
        .map(|_| ThreadPoolBuilder::new().num_threads(cores / workers).build())
        .collect::<Result<_, _>>()
        .map_err(|error| format!("threads: {error}"))?;
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                while let Some(&number) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let entry = known.store.store(run_benchmark(&work[number], pool, known, &progress));
                    done.lock().expect("no benchmark panics out of its entry").push((number, entry));
                }
            });
        }
    });
    Ok(done.into_inner().expect("no benchmark panics out of its entry"))
}

/// Prints the benchmarks and their expected times.
fn list(chosen: &[&Benchmark]) {
    println!("{:28} {:>8} {:>8}  expected seconds on one core", "name", "--quick", "full");
    for benchmark in chosen {
        let quick = benchmark.short_seconds.map_or("left out".to_owned(), |seconds| format!("{seconds} s"));
        let full = format!("{} s", benchmark.full_seconds);
        println!("{:28} {quick:>8} {full:>8}  {}", benchmark.id, benchmark.title);
    }
    let quick: u32 = chosen.iter().filter_map(|benchmark| benchmark.short_seconds).sum();
    let full: u32 = chosen.iter().map(|benchmark| benchmark.full_seconds).sum();
    println!("{:28} {:>8} {:>8}", "total", format!("{quick} s"), format!("{full} s"));
}

/// Runs a benchmark on the threads of a pool and prints its outcome.
fn run_benchmark(
    work: &BenchmarkJob,
    pool: &ThreadPool,
    known: &KnownResults,
    progress: &ValidationProgress,
) -> BenchmarkEntry {
    let BenchmarkJob { benchmark, is_short } = *work;
    let recorder = InputRecorder::attach(pool);
    let start = Instant::now();
    // A benchmark that panics has failed; the others still run.
    let result = pool.install(|| catch_unwind(AssertUnwindSafe(|| (benchmark.run)(is_short))));
    let seconds = start.elapsed().as_secs_f64();
    let (mut outcome, error) = match result {
        Ok(Ok(outcome)) => (outcome, None),
        Ok(Err(error)) => (BenchmarkOutcome::default(), Some(error)),
        Err(_) => (BenchmarkOutcome::default(), Some("the benchmark panicked".to_owned())),
    };
    // A comparison already has the runs on one slider.
    if outcome.comparison.is_none() {
        outcome.animations = recorder.animations();
    }
    known.attach_defects(benchmark, &mut outcome);
    let mut text = String::new();
    for check in &outcome.checks {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "  {:<10}  {:<72} {:>16.9e}   source: {}",
            check.verdict().name(),
            check.name,
            check.measured,
            check.claim
        );
    }
    if let Some(error) = &error {
        let _ = writeln!(text, "  FAIL        {error}");
    }
    // Printed in one call: other threads report meanwhile.
    let line = progress.finished_text(work.seconds(), seconds);
    println!("\n{line}: {} — {}\n{text}  {seconds:.1} s", benchmark.id, benchmark.title);
    BenchmarkEntry { benchmark, is_short, outcome, error, seconds, files: recorder.files(), cached: false }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_benchmark_called_by_its_name_runs_alone() {
        let chosen = |names: &[&str]| -> Vec<&str> {
            let names = names.iter().copied().map(str::to_owned).collect();
            let arguments = ValidateArguments { names, quick: false, long: true, all: false, list: false };
            all_benchmarks()
                .filter(|benchmark| arguments.is_requested(benchmark))
                .map(|benchmark| benchmark.id)
                .collect()
        };
        assert_eq!(chosen(&["dem/column"]), ["dem/column"]);
        assert_eq!(chosen(&["dem/colum"]), ["dem/column", "dem/column-sweep"]);
        assert_eq!(chosen(&["dem/column", "mpm/bar"]).len(), 2);
        assert_eq!(chosen(&[]).len(), all_benchmarks().count());
    }

    #[test]
    fn minutes_of_a_short_form_are_left_out_without_an_option() {
        let form = |[quick, long]: [bool; 2]| {
            let arguments = ValidateArguments { names: Vec::new(), quick, long, all: false, list: false };
            let benchmark = all_benchmarks().find(|benchmark| benchmark.id == "dem/triaxial-sleeve");
            arguments.is_short_run(benchmark.unwrap())
        };
        assert_eq!([[false; 2], [true, false], [false, true]].map(form), [None, Some(true), Some(false)]);
    }
}
