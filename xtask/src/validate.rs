//! `cargo xtask validate`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use clap::Args;

use crate::benchmarks::{ALL, Benchmark, Outcome};
use crate::report::{self, Entry};

#[derive(Args)]
pub struct Arguments {
    /// Only benchmarks whose name contains this.
    filter: Option<String>,
    /// The short form of each benchmark.
    #[arg(long)]
    quick: bool,
    /// List the benchmarks.
    #[arg(long)]
    list: bool,
}

/// Runs the benchmarks; true when everything holds.
pub fn run(arguments: &Arguments) -> Result<bool, String> {
    let wanted =
        |benchmark: &&Benchmark| arguments.filter.as_deref().is_none_or(|f| benchmark.id.contains(f));
    let chosen: Vec<&Benchmark> = ALL.iter().filter(wanted).collect();
    if chosen.is_empty() {
        return Err(format!("no benchmark's name contains {:?}; see --list", arguments.filter));
    }
    if arguments.list {
        for benchmark in chosen {
            println!("{:28} {}", benchmark.id, benchmark.title);
        }
        return Ok(true);
    }
    let entries: Vec<Entry> = chosen.into_iter().map(|benchmark| entry(benchmark, arguments.quick)).collect();
    let folder = crate::root().join("target/validation");
    report::write(&folder, &entries, arguments.quick)?;
    let failed = entries.iter().filter(|entry| !entry.passes()).count();
    let checks: usize = entries.iter().map(|entry| entry.outcome.checks.len()).sum();
    println!("\n{checks} checks in {} benchmarks, {failed} benchmarks failed", entries.len());
    println!("report: {}", folder.join("index.html").display());
    Ok(failed == 0)
}

fn entry(benchmark: &'static Benchmark, quick: bool) -> Entry {
    println!("\n{} — {}", benchmark.id, benchmark.title);
    let start = Instant::now();
    // A benchmark that panics has failed; the others still run.
    let result = catch_unwind(AssertUnwindSafe(|| (benchmark.run)(quick)));
    let seconds = start.elapsed().as_secs_f64();
    let (outcome, error) = match result {
        Ok(Ok(outcome)) => (outcome, None),
        Ok(Err(error)) => (Outcome::default(), Some(error)),
        Err(_) => (Outcome::default(), Some("the benchmark panicked".to_owned())),
    };
    for check in &outcome.checks {
        let verdict = if check.passes() { "pass" } else { "FAIL" };
        println!("  {verdict}  {:<72} {:>16.9e}   source: {}", check.name, check.measured, check.claim);
    }
    if let Some(error) = &error {
        println!("  FAIL  {error}");
    }
    println!("  {seconds:.1} s");
    Entry { benchmark, outcome, error, seconds }
}
