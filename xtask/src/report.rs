//! The validation report: one self-contained page, and the same as JSON.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::json;

use crate::benchmarks::{Benchmark, Check, Criterion, Outcome, Verdict};
use crate::html::escape;

/// A benchmark and what came of it.
pub struct Entry {
    /// The benchmark.
    pub benchmark: &'static Benchmark,
    /// Whether it ran in its short form.
    pub short: bool,
    /// What it found.
    pub outcome: Outcome,
    /// Why it could not finish.
    pub error: Option<String>,
    /// Wall-clock time (s).
    pub seconds: f64,
}

impl Entry {
    /// True when it finished, judged something, and no check failed but for open defects.
    pub fn passes(&self) -> bool {
        self.error.is_none() && self.judged() > 0 && self.count(Verdict::Fail) == 0
    }

    /// Number of checks with a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.outcome.checks.iter().filter(|check| check.verdict() == verdict).count()
    }

    /// Number of checks that were judged.
    pub fn judged(&self) -> usize {
        self.outcome.checks.len() - self.count(Verdict::NotJudged)
    }
}

/// What part of the benchmarks a report covers.
pub struct Scope {
    /// Text that the names had to contain; all benchmarks where there is none.
    pub filter: Option<String>,
    /// Whether short forms were asked for.
    pub quick: bool,
    /// How many benchmarks run in their short form.
    pub short: usize,
    /// How many run in their full form.
    pub full: usize,
    /// Names of those that do not run: they have no short form, or their full form takes minutes.
    pub left_out: Vec<&'static str>,
}

impl Scope {
    /// Where the report goes: a report of a part never takes the place of one of the whole.
    pub fn folder(&self) -> PathBuf {
        let folder = crate::root().join("target/validation");
        let Some(filter) = &self.filter else { return folder };
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
        let name: String = filter.chars().map(plain).collect();
        folder.join("filtered").join(if self.quick { format!("{name}.quick") } else { name })
    }

    /// Which benchmarks run, and in which form.
    pub fn words(&self) -> String {
        let (run, left) = (self.short + self.full, self.left_out.len());
        let mut words = match left {
            0 => format!("{run} benchmarks"),
            _ => format!("{run} of {} benchmarks", run + left),
        };
        if let Some(filter) = &self.filter {
            words += &format!(" with “{filter}” in their name");
        }
        words += &match (self.full, self.short) {
            (_, 0) => ", in full".to_owned(),
            (0, _) => ", in their short form".to_owned(),
            (full, short) => format!(", {full} in full, {short} in their short form"),
        };
        if left > 0 {
            words += &format!("; {left} left out (--long runs them)");
        }
        words
    }
}

/// Where and when the report was made.
struct Provenance {
    machine: String,
    rustc: String,
    commit: String,
    date: String,
}

fn output(program: &str, arguments: &[&str]) -> String {
    let result = Command::new(program).args(arguments).current_dir(crate::root()).output();
    result.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned()).unwrap_or_default()
}

fn provenance() -> Provenance {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model =
        info.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or(": unknown processor");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    Provenance {
        machine: format!(
            "{}, {cores} cores, {}",
            model.trim_start_matches([' ', '\t', ':']),
            std::env::consts::OS
        ),
        rustc: output("rustc", &["--version"]),
        commit: output("git", &["describe", "--always", "--dirty"]),
        date: output("date", &["-u", "+%Y-%m-%d %H:%M UTC"]),
    }
}

/// Writes `index.html` and `report.json` to `folder`.
pub fn write(folder: &Path, entries: &[Entry], scope: &Scope) -> Result<(), String> {
    let about = provenance();
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let save = |name: &str, text: String| {
        colluvium::case::output::write_atomically(&folder.join(name), text.as_bytes())
            .map_err(|e| e.to_string())
    };
    save("index.html", page(entries, &about, scope))?;
    let text =
        serde_json::to_string_pretty(&to_json(entries, &about, scope)).map_err(|error| error.to_string())?;
    save("report.json", text)
}

fn to_json(entries: &[Entry], about: &Provenance, scope: &Scope) -> serde_json::Value {
    let check = |c: &Check| {
        json!({
            "name": c.name, "claim": c.claim, "measured": c.measured,
            "verdict": c.verdict().name(),
            "pass": c.range.map(|_| c.verdict() == Verdict::Pass),
            "lower": c.range.map(|r| r.0).filter(|bound| bound.is_finite()),
            "upper": c.range.map(|r| r.1).filter(|bound| bound.is_finite()),
            "reason": c.reason, "defect": c.defect.as_ref().filter(|_| c.verdict() == Verdict::Open),
        })
    };
    let entry = |e: &Entry| {
        json!({
            "id": e.benchmark.id, "title": e.benchmark.title, "source": e.benchmark.source,
            "form": form(e), "pass": e.passes(), "error": e.error, "seconds": e.seconds,
            "checks": e.outcome.checks.iter().map(check).collect::<Vec<_>>(),
        })
    };
    json!({
        "machine": about.machine, "rustc": about.rustc, "commit": about.commit, "date": about.date,
        "filter": scope.filter, "quick": scope.quick, "scope": scope.words(), "left_out": scope.left_out,
        "pass": entries.iter().all(Entry::passes),
        "benchmarks": entries.iter().map(entry).collect::<Vec<_>>(),
    })
}

const STYLE: &str = "
:root { --ink: #1d2733; --soft: #5c6b7a; --line: #dde3e9; --good: #1a7f4b; --bad: #c0392b; --paper: #ffffff; }
* { box-sizing: border-box; }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: #f5f7f9; margin: 0; }
main { max-width: 1080px; margin: 0 auto; padding: 32px 24px 64px; }
h1 { margin: 0 0 4px; font-size: 28px; } h2 { margin: 0; font-size: 20px; }
.meta, .source { color: var(--soft); font-size: 13.5px; }
.card { background: var(--paper); border: 1px solid var(--line); border-radius: 8px; padding: 20px 24px; margin: 22px 0; }
.badge { display: inline-block; padding: 1px 9px; border-radius: 10px; color: #fff; font-size: 12.5px; font-weight: 600; vertical-align: 2px; }
.pass { background: var(--good); } .fail { background: var(--bad); } .shown { background: var(--soft); white-space: nowrap; }
table { border-collapse: collapse; width: 100%; margin: 14px 0; font-size: 13.5px; }
th { text-align: left; color: var(--soft); font-weight: 600; border-bottom: 2px solid var(--line); padding: 5px 8px; }
td { border-bottom: 1px solid var(--line); padding: 5px 8px; vertical-align: top; }
td.number { font-variant-numeric: tabular-nums; white-space: nowrap; }
figure { margin: 18px 0 6px; } figure svg, figure img { max-width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: 13.5px; } a { color: #0b62a4; }
@media (max-width: 720px) { .card { padding: 14px; overflow-x: auto; } }
";

fn badge(pass: bool) -> &'static str {
    if pass { "<span class=\"badge pass\">pass</span>" } else { "<span class=\"badge fail\">fail</span>" }
}

/// How many checks fail as open defects, and how each kind stands with its source.
pub fn open_in_words(entries: &[Entry]) -> String {
    let known: Vec<Criterion> = entries
        .iter()
        .flat_map(|entry| &entry.outcome.checks)
        .filter(|check| check.verdict() == Verdict::Open)
        .filter_map(|check| Some(check.defect.as_ref()?.criterion))
        .collect();
    let kinds = Criterion::ALL.map(|kind| (known.iter().filter(|&&k| k == kind).count(), kind.words()));
    let kinds: Vec<String> = kinds
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, words)| format!("{count} {words}"))
        .collect();
    match kinds.is_empty() {
        true => "no check fails as an open defect".to_owned(),
        false => format!("{} checks fail as open defects ({})", known.len(), kinds.join(", ")),
    }
}

/// In which form a benchmark ran.
fn form(entry: &Entry) -> &'static str {
    if entry.short { "short" } else { "full" }
}

/// Verdict on a benchmark, and how many defects it has open.
fn badges(entry: &Entry) -> String {
    let open = entry.count(Verdict::Open);
    let more =
        if open == 0 { String::new() } else { format!(" <span class=\"badge fail\">{open} open</span>") };
    badge(entry.passes()).to_owned() + &more
}

fn verdict(check: &Check) -> &'static str {
    match check.verdict() {
        Verdict::NotJudged => "<span class=\"badge shown\">not judged</span>",
        Verdict::Open => "<span class=\"badge fail\">fail, open</span>",
        other => badge(other == Verdict::Pass),
    }
}

fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e6).contains(&size) {
        let text = format!("{value:.6}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{value:.4e}")
    }
}

/// The reason for the bounds, and what is known where they do not hold.
fn why(check: &Check) -> String {
    match &check.defect {
        Some(known) if check.verdict() == Verdict::Open => {
            format!("{}. Open; {}: {}", check.reason, known.criterion.words(), known.found)
        }
        _ => check.reason.clone(),
    }
}

fn bounds(range: Option<(f64, f64)>) -> String {
    let Some((low, high)) = range else { return "–".to_owned() };
    match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("{} … {}", number(low), number(high)),
        (true, false) => format!("≥ {}", number(low)),
        (false, true) => format!("≤ {}", number(high)),
        (false, false) => "any".to_owned(),
    }
}

fn page(entries: &[Entry], about: &Provenance, scope: &Scope) -> String {
    let mut html = String::new();
    let all = entries.iter().all(Entry::passes);
    let judged: usize = entries.iter().map(Entry::judged).sum();
    let shown: usize = entries.iter().map(|e| e.count(Verdict::NotJudged)).sum();
    let open = open_in_words(entries);
    let seconds: f64 = entries.iter().map(|e| e.seconds).sum();
    // Writing to a string cannot fail.
    let _ = write!(
        html,
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Colluvium: validation</title><style>{STYLE}</style></head><body><main>\
         <h1>Validation {}</h1><p class=\"meta\"><strong>{}</strong>. {judged} checks in {} benchmarks, \
         {open}, and {shown} values shown without judgement, {seconds:.0} s · commit {} · {} · {} · {}</p>",
        badge(all),
        escape(&scope.words()),
        entries.len(),
        escape(&about.commit),
        escape(&about.date),
        escape(&about.machine),
        escape(&about.rustc),
    );
    html.push_str(
        "<div class=\"card\"><table><tr><th>Benchmark</th><th>Form</th><th>Checks</th><th>Time</th><th></th></tr>",
    );
    for entry in entries {
        let id = entry.benchmark.id;
        let _ = write!(
            html,
            "<tr><td><a href=\"#{id}\">{id}</a> — {}</td><td>{}</td><td>{}</td><td>{:.1} s</td><td>{}</td></tr>",
            escape(entry.benchmark.title),
            form(entry),
            entry.judged(),
            entry.seconds,
            badges(entry),
        );
    }
    html.push_str("</table>");
    if !scope.left_out.is_empty() {
        let _ = write!(html, "<p class=\"meta\">Left out: {}.</p>", escape(&scope.left_out.join(", ")));
    }
    html.push_str("</div>");
    for entry in entries {
        section(&mut html, entry);
    }
    html.push_str("</main></body></html>\n");
    html
}

fn section(html: &mut String, entry: &Entry) {
    let benchmark = entry.benchmark;
    let _ = write!(
        html,
        "<section class=\"card\" id=\"{}\"><h2>{} {}</h2><p class=\"source\">{}, in its {} form<br>Source: {}</p>",
        benchmark.id,
        escape(benchmark.title),
        badges(entry),
        benchmark.id,
        form(entry),
        escape(benchmark.source),
    );
    if let Some(error) = &entry.error {
        let _ = write!(html, "<p><strong>Could not finish:</strong> {}</p>", escape(error));
    }
    for figure in &entry.outcome.figures {
        let _ = write!(
            html,
            "<figure>{}<figcaption>{}</figcaption></figure>",
            figure.html,
            escape(&figure.caption)
        );
    }
    html.push_str(
        "<table><tr><th>What</th><th>The source says</th><th>We find</th><th>Passes</th><th>Why these bounds, or none</th><th></th></tr>",
    );
    for check in &entry.outcome.checks {
        let _ = write!(
            html,
            "<tr><td>{}</td><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td><td>{}</td><td>{}</td></tr>",
            escape(&check.name),
            escape(&check.claim),
            number(check.measured),
            bounds(check.range),
            escape(&why(check)),
            verdict(check),
        );
    }
    html.push_str("</table></section>");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_says_what_ran_in_which_form() {
        let scope = |filter: Option<&str>, full, short, left_out: &[&'static str]| {
            let filter = filter.map(str::to_owned);
            Scope { filter, quick: false, short, full, left_out: left_out.to_vec() }.words()
        };
        assert_eq!(scope(None, 3, 0, &[]), "3 benchmarks, in full");
        assert_eq!(
            scope(None, 36, 14, &["a", "b"]),
            "50 of 52 benchmarks, 36 in full, 14 in their short form; 2 left out (--long runs them)"
        );
        assert_eq!(
            scope(Some("bar"), 0, 2, &[]),
            "2 benchmarks with “bar” in their name, in their short form"
        );
    }
}
