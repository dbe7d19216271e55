//! `cargo xtask validate`.
//!
//! A check that fails makes the command fail, unless `validation/open-defects.json` lists it: it is then shown as a
//! failure all the same, with what is known of it, and counted apart.

use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use clap::Args;
use rayon::ThreadPoolBuilder;
use serde::Deserialize;

use crate::benchmarks::{ALL, Benchmark, Criterion, Known, Listed, Outcome, Verdict};
use crate::report::{self, Entry, Scope};

#[derive(Args)]
pub struct Arguments {
    /// Only benchmarks whose name contains this.
    filter: Option<String>,
    /// The short form of each benchmark.
    #[arg(long)]
    quick: bool,
    /// The full form of the benchmarks that take minutes each, too: without it they run in their short form, or
    /// not at all where they have none.
    #[arg(long, conflicts_with = "quick")]
    long: bool,
    /// List the benchmarks and the seconds to expect of each on one core.
    #[arg(long)]
    list: bool,
}

/// Seconds above which the full form of a benchmark is for `--long` only: on two cores the rest stays within ten minutes.
const LONG: u32 = 50;

impl Arguments {
    /// Whether a benchmark runs in its short form; `None` where it is left out.
    fn short(&self, listed: &Listed) -> Option<bool> {
        let short = self.quick || (listed.full > LONG && !self.long);
        if short { listed.quick.map(|_| true) } else { Some(false) }
    }
}

/// Runs the benchmarks; true when everything holds.
pub fn run(arguments: &Arguments) -> Result<bool, String> {
    let named =
        |listed: &&Listed| arguments.filter.as_deref().is_none_or(|f| listed.benchmark.id.contains(f));
    let chosen: Vec<&Listed> = ALL
        .iter()
        .filter(named)
        .filter(|listed| arguments.list || arguments.short(listed).is_some())
        .collect();
    if chosen.is_empty() {
        let filter = arguments.filter.as_deref().unwrap_or_default();
        return Err(format!("no benchmark's name contains {filter:?}, or it needs --long; see --list"));
    }
    if arguments.list {
        list(&chosen);
        return Ok(true);
    }
    let defects = defects()?;
    let work: Vec<Work> = chosen
        .into_iter()
        .filter_map(|listed| Some(Work { listed, short: arguments.short(listed)? }))
        .collect();
    let entries = all_entries(&work, &defects)?;
    let scope = Scope { filter: arguments.filter.as_deref(), quick: arguments.quick };
    let folder = scope.folder();
    report::write(&folder, &entries, &scope)?;
    let failed = entries.iter().filter(|entry| !entry.passes()).count();
    let checks: usize = entries.iter().map(Entry::judged).sum();
    let shown: usize = entries.iter().map(|entry| entry.count(Verdict::NotJudged)).sum();
    println!(
        "\n{checks} checks in {} benchmarks, {failed} benchmarks failed; {}; {shown} values shown without judgement",
        entries.len(),
        report::open_in_words(&entries)
    );
    println!("report: {}", folder.join("index.html").display());
    Ok(failed == 0)
}

/// A benchmark to run.
struct Work {
    listed: &'static Listed,
    short: bool,
}

impl Work {
    fn seconds(&self) -> u32 {
        if self.short { self.listed.quick.unwrap_or(self.listed.full) } else { self.listed.full }
    }
}

/// Runs the benchmarks, as many at a time as there are cores, the longest first: most are too small for many threads, and
/// results do not depend on their number.
fn all_entries(work: &[Work], defects: &[Defect]) -> Result<Vec<Entry>, String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = cores.min(work.len());
    let mut order: Vec<usize> = (0..work.len()).collect();
    order.sort_by_key(|&number| std::cmp::Reverse(work[number].seconds()));
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let pools: Vec<_> = (0..workers)
        .map(|_| ThreadPoolBuilder::new().num_threads(cores / workers).build())
        .collect::<Result<_, _>>()
        .map_err(|error| format!("threads: {error}"))?;
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                while let Some(&number) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let Work { listed, short } = &work[number];
                    let entry = pool.install(|| entry(listed.benchmark, *short, defects));
                    done.lock().expect("no benchmark panics out of its entry").push((number, entry));
                }
            });
        }
    });
    let mut entries = done.into_inner().expect("no benchmark panics out of its entry");
    entries.sort_by_key(|(number, _)| *number);
    Ok(entries.into_iter().map(|(_, entry)| entry).collect())
}

/// Checks that are known to fail, for one cause.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Defect {
    /// Name of the benchmark.
    benchmark: String,
    /// How the names of the checks begin.
    checks: Vec<String>,
    /// How they stand with what the source asks.
    criterion: Criterion,
    /// What was found.
    found: String,
}

/// The open defects, from `validation/open-defects.json`.
fn defects() -> Result<Vec<Defect>, String> {
    let path = crate::root().join("validation/open-defects.json");
    let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let text = std::fs::read_to_string(&path).map_err(|error| wrong(&error))?;
    let defects: Vec<Defect> = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
    match defects.iter().find(|defect| ALL.iter().all(|listed| listed.benchmark.id != defect.benchmark)) {
        Some(stray) => Err(wrong(&format!("there is no benchmark {:?}", stray.benchmark))),
        None => Ok(defects),
    }
}

/// Prints what there is and what it costs.
fn list(chosen: &[&Listed]) {
    println!("{:28} {:>8} {:>8}  seconds to expect on one core", "name", "--quick", "full");
    for Listed { benchmark, quick, full } in chosen {
        let quick = quick.map_or("left out".to_owned(), |seconds| format!("{seconds} s"));
        println!("{:28} {quick:>8} {:>8}  {}", benchmark.id, format!("{full} s"), benchmark.title);
    }
    let quick: u32 = chosen.iter().filter_map(|listed| listed.quick).sum();
    let full: u32 = chosen.iter().map(|listed| listed.full).sum();
    println!("{:28} {:>8} {:>8}", "together", format!("{quick} s"), format!("{full} s"));
}

fn entry(benchmark: &'static Benchmark, quick: bool, defects: &[Defect]) -> Entry {
    let mut text = format!("\n{} — {}\n", benchmark.id, benchmark.title);
    let start = Instant::now();
    // A benchmark that panics has failed; the others still run.
    let result = catch_unwind(AssertUnwindSafe(|| (benchmark.run)(quick)));
    let seconds = start.elapsed().as_secs_f64();
    let (mut outcome, error) = match result {
        Ok(Ok(outcome)) => (outcome, None),
        Ok(Err(error)) => (Outcome::default(), Some(error)),
        Err(_) => (Outcome::default(), Some("the benchmark panicked".to_owned())),
    };
    for check in &mut outcome.checks {
        let of_check = |defect: &&Defect| {
            defect.benchmark == benchmark.id
                && defect.checks.iter().any(|begin| check.name.starts_with(begin))
        };
        check.defect = defects
            .iter()
            .find(of_check)
            .map(|defect| Known { criterion: defect.criterion, found: defect.found.clone() });
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
    println!("{text}  {seconds:.1} s");
    Entry { benchmark, outcome, error, seconds }
}
