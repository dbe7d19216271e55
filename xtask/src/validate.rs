//! `cargo xtask validate`.
//!
//! A check that fails makes the command fail, unless `validation/open-defects.json` lists it: it is then shown as a
//! failure all the same, with what is known of it, and counted apart.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use clap::Args;
use serde::Deserialize;

use crate::benchmarks::{ALL, Benchmark, Listed, Outcome, Verdict};
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
    /// List the benchmarks and the seconds to expect of each on two cores.
    #[arg(long)]
    list: bool,
}

/// Seconds above which the full form of a benchmark is for `--long` only: the rest stays within ten minutes.
const LONG: u32 = 90;

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
    let entries: Vec<Entry> = chosen
        .into_iter()
        .filter_map(|listed| Some(entry(listed.benchmark, arguments.short(listed)?, &defects)))
        .collect();
    let scope = Scope { filter: arguments.filter.as_deref(), quick: arguments.quick };
    let folder = scope.folder();
    report::write(&folder, &entries, &scope)?;
    let failed = entries.iter().filter(|entry| !entry.passes()).count();
    let checks: usize = entries.iter().map(Entry::judged).sum();
    let shown: usize = entries.iter().map(|entry| entry.count(Verdict::NotJudged)).sum();
    let open: usize = entries.iter().map(|entry| entry.count(Verdict::Open)).sum();
    println!(
        "\n{checks} checks in {} benchmarks, {failed} benchmarks failed; {open} checks fail as open defects; {shown} \
         values shown without judgement",
        entries.len()
    );
    println!("report: {}", folder.join("index.html").display());
    Ok(failed == 0)
}

/// A check that is known to fail.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Defect {
    /// Name of the benchmark.
    benchmark: String,
    /// How the name of the check begins.
    check: String,
    /// What is known of it.
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
    println!("{:28} {:>8} {:>8}  seconds to expect on two cores", "name", "--quick", "full");
    for Listed { benchmark, quick, full } in chosen {
        let quick = quick.map_or("left out".to_owned(), |seconds| format!("{seconds} s"));
        println!("{:28} {quick:>8} {:>8}  {}", benchmark.id, format!("{full} s"), benchmark.title);
    }
    let quick: u32 = chosen.iter().filter_map(|listed| listed.quick).sum();
    let full: u32 = chosen.iter().map(|listed| listed.full).sum();
    println!("{:28} {:>8} {:>8}", "together", format!("{quick} s"), format!("{full} s"));
}

fn entry(benchmark: &'static Benchmark, quick: bool, defects: &[Defect]) -> Entry {
    println!("\n{} — {}", benchmark.id, benchmark.title);
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
        let of_check =
            |defect: &&Defect| defect.benchmark == benchmark.id && check.name.starts_with(&defect.check);
        check.defect = defects.iter().find(of_check).map(|defect| defect.found.clone());
        println!(
            "  {:<10}  {:<72} {:>16.9e}   source: {}",
            check.verdict().name(),
            check.name,
            check.measured,
            check.claim
        );
    }
    if let Some(error) = &error {
        println!("  FAIL        {error}");
    }
    println!("  {seconds:.1} s");
    Entry { benchmark, outcome, error, seconds }
}
