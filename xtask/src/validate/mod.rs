//! `cargo xtask validate`.
//!
//! A check that fails makes the command fail, unless `validation/open-defects.json` lists it: it is then shown as a
//! failure all the same, with what is known of it, and counted apart.

mod defects;
mod kept;
mod progress;

use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use clap::Args;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::benchmarks::{Benchmark, Outcome, Recorder, Verdict, all};
use crate::report::{self, Entry, Scope};
use defects::Defect;
use kept::Store;
use progress::Progress;

#[derive(Args)]
pub struct Arguments {
    /// Only the benchmark of this name, or, where none is called so, those whose name contains it; several are run together.
    names: Vec<String>,
    /// The short form of each benchmark.
    #[arg(long)]
    quick: bool,
    /// The full form of the benchmarks that take minutes each, too: without it they run in their short form, or
    /// not at all where they have none.
    #[arg(long, conflicts_with = "quick")]
    long: bool,
    /// Run what has not changed, too: without it a benchmark that did not fail is not run again while the program and the files that
    /// it reads are the same.
    #[arg(long)]
    all: bool,
    /// List the benchmarks and the seconds to expect of each on one core.
    #[arg(long)]
    list: bool,
}

/// Seconds above which the full form of a benchmark is for `--long` only: on two cores the rest stays within ten minutes.
const LONG: u32 = 50;

impl Arguments {
    /// Whether a benchmark is asked for: by its own name, by a part of it that no other one has as its name, or with all.
    fn asks_for(&self, benchmark: &Benchmark) -> bool {
        let asks = |name: &String| match all().find(|other| other.id == name.as_str()) {
            Some(one) => one.id == benchmark.id,
            None => benchmark.id.contains(name.as_str()),
        };
        self.names.is_empty() || self.names.iter().any(asks)
    }

    /// Whether a benchmark runs in its short form; `None` where it is left out.
    fn short(&self, benchmark: &Benchmark) -> Option<bool> {
        let short = self.quick || (benchmark.full > LONG && !self.long);
        if short { benchmark.quick.map(|_| true) } else { Some(false) }
    }
}

/// Runs the benchmarks; true when everything holds.
pub fn run(arguments: &Arguments) -> Result<bool, String> {
    let chosen: Vec<&'static Benchmark> = all().filter(|benchmark| arguments.asks_for(benchmark)).collect();
    if arguments.list {
        list(&chosen);
        return Ok(true);
    }
    let form = |&benchmark: &&'static Benchmark| Some(Work { benchmark, short: arguments.short(benchmark)? });
    let work: Vec<Work> = chosen.iter().filter_map(form).collect();
    if work.is_empty() {
        let names = arguments.names.join(" or ");
        return Err(format!("no benchmark's name contains {names:?}, or it needs --long; see --list"));
    }
    let left_out = chosen.iter().filter(|benchmark| arguments.short(benchmark).is_none());
    let scope = Scope {
        filter: (!arguments.names.is_empty()).then(|| arguments.names.join(" ")),
        quick: arguments.quick,
        short: work.iter().filter(|work| work.short).count(),
        full: work.iter().filter(|work| !work.short).count(),
        left_out: left_out.map(|benchmark| benchmark.id).collect(),
    };
    println!("{}", scope.words());
    let known = Known { store: Store::open()?, defects: defects::open()? };
    let entries = all_entries(&work, &known, arguments.all)?;
    let folder = scope.folder();
    report::write(&folder, &entries, &scope)?;
    let failed = entries.iter().filter(|entry| !entry.passes()).count();
    let checks: usize = entries.iter().map(Entry::judged).sum();
    let shown: usize = entries.iter().map(|entry| entry.count(Verdict::NotJudged)).sum();
    println!(
        "\n{}\n{checks} checks in {} benchmarks, {failed} benchmarks failed; {}; {shown} values shown without judgement",
        scope.words(),
        entries.len(),
        report::open_in_words(&entries)
    );
    println!("report: {}", folder.join("index.html").display());
    Ok(failed == 0)
}

/// A benchmark to run.
struct Work {
    benchmark: &'static Benchmark,
    short: bool,
}

impl Work {
    /// Seconds to expect on one core.
    fn seconds(&self) -> u32 {
        if self.short { self.benchmark.quick.unwrap_or(self.benchmark.full) } else { self.benchmark.full }
    }
}

/// What is known before anything runs.
struct Known {
    store: Store,
    defects: Vec<Defect>,
}

impl Known {
    /// What was kept of a benchmark that has not changed since, unless it fails by what is known of its defects now.
    fn find(&self, work: &Work) -> Option<Entry> {
        let mut entry = self.store.find(work.benchmark, work.short)?;
        self.judge(work.benchmark, &mut entry.outcome);
        entry.passes().then_some(entry)
    }

    /// Notes what is known of checks that fail.
    fn judge(&self, benchmark: &Benchmark, outcome: &mut Outcome) {
        for check in &mut outcome.checks {
            check.defect = defects::known(&self.defects, benchmark.id, &check.name);
        }
    }
}

/// The entries of all benchmarks, in their order: those that have not changed as they were kept, the others from their runs.
fn all_entries(work: &[Work], known: &Known, again: bool) -> Result<Vec<Entry>, String> {
    let find = |work: &Work| if again { None } else { known.find(work) };
    let mut entries: Vec<Option<Entry>> = work.iter().map(find).collect();
    let kept = entries.iter().flatten().count();
    if kept > 0 {
        println!("{kept} of them have not changed since they ran, and are not run again (--all runs them)");
    }
    let open: Vec<usize> = (0..work.len()).filter(|&number| entries[number].is_none()).collect();
    for (number, entry) in fresh(work, open, known)? {
        entries[number] = Some(entry?);
    }
    Ok(entries.into_iter().flatten().collect())
}

/// A benchmark's number and what came of it, or why that could not be kept.
type Ran = (usize, Result<Entry, String>);

/// Runs the benchmarks of some numbers, as many at a time as there are cores, the longest first: most are too small for many
/// threads, and results do not depend on their number. Each is kept when it is done, so that what is interrupted can go on.
fn fresh(work: &[Work], mut order: Vec<usize>, known: &Known) -> Result<Vec<Ran>, String> {
    if order.is_empty() {
        return Ok(Vec::new());
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = cores.min(order.len());
    order.sort_by_key(|&number| std::cmp::Reverse(work[number].seconds()));
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let progress = Progress::new(order.iter().map(|&number| work[number].seconds()), workers);
    println!("{}", progress.head());
    let pools: Vec<_> = (0..workers)
        .map(|_| ThreadPoolBuilder::new().num_threads(cores / workers).build())
        .collect::<Result<_, _>>()
        .map_err(|error| format!("threads: {error}"))?;
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                while let Some(&number) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let entry = known.store.keep(entry(&work[number], pool, known, &progress));
                    done.lock().expect("no benchmark panics out of its entry").push((number, entry));
                }
            });
        }
    });
    Ok(done.into_inner().expect("no benchmark panics out of its entry"))
}

/// Prints what there is and what it costs.
fn list(chosen: &[&Benchmark]) {
    println!("{:28} {:>8} {:>8}  seconds to expect on one core", "name", "--quick", "full");
    for benchmark in chosen {
        let quick = benchmark.quick.map_or("left out".to_owned(), |seconds| format!("{seconds} s"));
        let full = format!("{} s", benchmark.full);
        println!("{:28} {quick:>8} {full:>8}  {}", benchmark.id, benchmark.title);
    }
    let quick: u32 = chosen.iter().filter_map(|benchmark| benchmark.quick).sum();
    let full: u32 = chosen.iter().map(|benchmark| benchmark.full).sum();
    println!("{:28} {:>8} {:>8}", "together", format!("{quick} s"), format!("{full} s"));
}

/// Runs a benchmark on the threads of a pool and prints what came of it.
fn entry(work: &Work, pool: &ThreadPool, known: &Known, progress: &Progress) -> Entry {
    let Work { benchmark, short } = *work;
    let recorder = Recorder::follow(pool);
    let start = Instant::now();
    // A benchmark that panics has failed; the others still run.
    let result = pool.install(|| catch_unwind(AssertUnwindSafe(|| (benchmark.run)(short))));
    let seconds = start.elapsed().as_secs_f64();
    let (mut outcome, error) = match result {
        Ok(Ok(outcome)) => (outcome, None),
        Ok(Err(error)) => (Outcome::default(), Some(error)),
        Err(_) => (Outcome::default(), Some("the benchmark panicked".to_owned())),
    };
    // A comparison has the runs on one slider.
    if outcome.comparison.is_none() {
        outcome.films = recorder.films();
    }
    known.judge(benchmark, &mut outcome);
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
    // At once: others report meanwhile.
    let line = progress.after(work.seconds(), seconds);
    println!("\n{line}: {} — {}\n{text}  {seconds:.1} s", benchmark.id, benchmark.title);
    Entry { benchmark, short, outcome, error, seconds, files: recorder.files(), kept: false }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_benchmark_called_by_its_name_runs_alone() {
        let chosen = |names: &[&str]| -> Vec<&str> {
            let names = names.iter().copied().map(str::to_owned).collect();
            let arguments = Arguments { names, quick: false, long: true, all: false, list: false };
            all().filter(|benchmark| arguments.asks_for(benchmark)).map(|benchmark| benchmark.id).collect()
        };
        assert_eq!(chosen(&["dem/column"]), ["dem/column"]);
        assert_eq!(chosen(&["dem/colum"]), ["dem/column", "dem/column-sweep"]);
        assert_eq!(chosen(&["dem/column", "mpm/bar"]).len(), 2);
        assert_eq!(chosen(&[]).len(), all().count());
    }
}
