//! Validation report: an index, a page of each benchmark with its pictures, and the same data as JSON.

mod benchmark_page;
mod index_page;
mod provenance;
mod scope;
mod value_text;

#[cfg(test)]
mod tests;

use std::path::Path;

use serde_json::json;

use crate::benchmarks::{Benchmark, BenchmarkOutcome, Check, CheckVerdict};
use crate::coverage;
pub use crate::report::value_text::open_defect_text;
use provenance::{Provenance, provenance};
pub use scope::ReportScope;

/// Entry of a benchmark in the report.
pub struct BenchmarkEntry {
    /// The benchmark.
    pub benchmark: &'static Benchmark,
    /// Whether it ran in its short form.
    pub is_short: bool,
    /// Outcome of the benchmark.
    pub outcome: BenchmarkOutcome,
    /// Reason why the benchmark could not finish.
    pub error: Option<String>,
    /// Wall-clock time (s).
    pub seconds: f64,
    /// Case files and reference data that the benchmark read, relative to the root of the repository.
    pub files: Vec<String>,
    /// Whether the outcome is from an earlier run of the same program and files.
    pub cached: bool,
}

/// Status of a benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BenchmarkStatus {
    /// Every judged check passes.
    Pass,
    /// Every failed check is listed among the open defects.
    Open,
    /// A check fails, nothing was judged, or the benchmark could not finish.
    Fail,
}

impl BenchmarkStatus {
    /// Name of the status.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Open => "open",
            Self::Fail => "fail",
        }
    }
}

impl BenchmarkEntry {
    /// Whether the benchmark finished, judged something, and no check failed except open defects.
    pub fn passes(&self) -> bool {
        self.error.is_none() && self.judged_checks() > 0 && self.count(CheckVerdict::Fail) == 0
    }

    /// Status of the benchmark.
    pub fn status(&self) -> BenchmarkStatus {
        match (self.passes(), self.count(CheckVerdict::Open)) {
            (false, _) => BenchmarkStatus::Fail,
            (true, 0) => BenchmarkStatus::Pass,
            (true, _) => BenchmarkStatus::Open,
        }
    }

    /// Name of the method: the first part of the benchmark's name.
    pub fn method(&self) -> &'static str {
        self.benchmark.id.split('/').next().unwrap_or_default()
    }

    /// Number of checks with a verdict.
    pub fn count(&self, verdict: CheckVerdict) -> usize {
        self.outcome.checks.iter().filter(|check| check.verdict() == verdict).count()
    }

    /// Number of checks that were judged.
    pub fn judged_checks(&self) -> usize {
        self.outcome.checks.len() - self.count(CheckVerdict::Unbounded)
    }
}

/// Text on the form in which a benchmark ran.
fn form_text(entry: &BenchmarkEntry) -> &'static str {
    if entry.is_short { "short" } else { "full" }
}

/// Folder of the pages of benchmarks in that of a report.
const PAGES: &str = "pages";

/// Name of the page on rows of specification sheets.
const COVERAGE: &str = "coverage.html";

/// Writes `index.html`, `report.json` and the page of each benchmark to `folder`.
pub fn write(folder: &Path, entries: &[BenchmarkEntry], scope: &ReportScope) -> Result<(), String> {
    let about = provenance();
    let pages = folder.join(PAGES);
    if pages.exists() {
        std::fs::remove_dir_all(&pages).map_err(|error| format!("{}: {error}", pages.display()))?;
    }
    let save = |file: &Path, bytes: &[u8]| {
        let parent = file.parent().unwrap_or(folder);
        std::fs::create_dir_all(parent).map_err(|error| format!("{}: {error}", parent.display()))?;
        colluvium::case::output::write_atomically(file, bytes).map_err(|error| error.to_string())
    };
    for entry in entries {
        let page = pages.join(format!("{}.html", entry.benchmark.id));
        for (number, figure) in entry.outcome.figures.iter().enumerate() {
            save(&page.with_file_name(benchmark_page::picture(entry, number)), &figure.bytes)?;
        }
        save(&page, benchmark_page::page(entry, &about, &path_to_root(&page)).into_string().as_bytes())?;
    }
    let (sheets, place) = (coverage::load_sheets()?, folder.join(COVERAGE));
    save(&place, coverage::html(&sheets, value_text::STYLE, &path_to_root(&place)).into_string().as_bytes())?;
    let text =
        serde_json::to_string_pretty(&to_json(entries, &about, scope)).map_err(|error| error.to_string())?;
    save(&folder.join("report.json"), text.as_bytes())?;
    save(&folder.join("index.html"), index_page::page(entries, &about, scope).into_string().as_bytes())
}

/// Relative link from a page to the root of the repository, with a slash at its end; empty for a page elsewhere.
fn path_to_root(page: &Path) -> String {
    let below = page.strip_prefix(crate::root()).ok().and_then(Path::parent);
    below.map_or(String::new(), |folder| "../".repeat(folder.components().count()))
}

fn to_json(entries: &[BenchmarkEntry], about: &Provenance, scope: &ReportScope) -> serde_json::Value {
    let check = |c: &Check| {
        json!({
            "name": c.name, "claim": c.claim, "measured": c.measured,
            "verdict": c.verdict().name(),
            "pass": c.range.map(|_| c.verdict() == CheckVerdict::Pass),
            "lower": c.range.map(|r| r.0).filter(|bound| bound.is_finite()),
            "upper": c.range.map(|r| r.1).filter(|bound| bound.is_finite()),
            "reason": c.reason, "defect": c.defect.as_ref().filter(|_| c.verdict() == CheckVerdict::Open),
        })
    };
    let entry = |e: &BenchmarkEntry| {
        json!({
            "id": e.benchmark.id, "title": e.benchmark.title, "source": e.benchmark.source,
            "form": form_text(e), "status": e.status().name(), "pass": e.passes(), "files": e.files, "kept": e.cached, "error": e.error, "seconds": e.seconds,
            "checks": e.outcome.checks.iter().map(check).collect::<Vec<_>>(),
        })
    };
    json!({
        "machine": about.machine, "rustc": about.rustc, "commit": about.commit, "date": about.date,
        "filter": scope.filter, "quick": scope.quick, "scope": scope.text(), "left_out": scope.skipped_benchmarks,
        "pass": entries.iter().all(BenchmarkEntry::passes),
        "benchmarks": entries.iter().map(entry).collect::<Vec<_>>(),
    })
}
