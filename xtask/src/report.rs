//! The validation report: one self-contained page, and the same as JSON.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use serde_json::json;

use crate::benchmarks::{Benchmark, Check, Outcome};

/// A benchmark and what came of it.
pub struct Entry {
    /// The benchmark.
    pub benchmark: &'static Benchmark,
    /// What it found.
    pub outcome: Outcome,
    /// Why it could not finish.
    pub error: Option<String>,
    /// Wall-clock time (s).
    pub seconds: f64,
}

impl Entry {
    /// True when it finished and every check holds.
    pub fn passes(&self) -> bool {
        self.error.is_none()
            && !self.outcome.checks.is_empty()
            && self.outcome.checks.iter().all(Check::passes)
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
pub fn write(folder: &Path, entries: &[Entry], quick: bool) -> Result<(), String> {
    let about = provenance();
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let save = |name: &str, text: String| {
        colluvium::case::output::write_atomically(&folder.join(name), text.as_bytes())
            .map_err(|e| e.to_string())
    };
    save("index.html", page(entries, &about, quick))?;
    let text =
        serde_json::to_string_pretty(&to_json(entries, &about, quick)).map_err(|error| error.to_string())?;
    save("report.json", text)
}

fn to_json(entries: &[Entry], about: &Provenance, quick: bool) -> serde_json::Value {
    let check = |c: &Check| {
        json!({
            "name": c.name, "claim": c.claim, "measured": c.measured, "pass": c.passes(),
            "lower": c.range.0.is_finite().then_some(c.range.0),
            "upper": c.range.1.is_finite().then_some(c.range.1),
            "reason": c.reason,
        })
    };
    let entry = |e: &Entry| {
        json!({
            "id": e.benchmark.id, "title": e.benchmark.title, "source": e.benchmark.source,
            "pass": e.passes(), "error": e.error, "seconds": e.seconds,
            "checks": e.outcome.checks.iter().map(check).collect::<Vec<_>>(),
        })
    };
    json!({
        "machine": about.machine, "rustc": about.rustc, "commit": about.commit, "date": about.date,
        "quick": quick,
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
.pass { background: var(--good); } .fail { background: var(--bad); }
table { border-collapse: collapse; width: 100%; margin: 14px 0; font-size: 13.5px; }
th { text-align: left; color: var(--soft); font-weight: 600; border-bottom: 2px solid var(--line); padding: 5px 8px; }
td { border-bottom: 1px solid var(--line); padding: 5px 8px; vertical-align: top; }
td.number { font-variant-numeric: tabular-nums; white-space: nowrap; }
figure { margin: 18px 0 6px; } figure svg, figure img { max-width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: 13.5px; } a { color: #0b62a4; }
@media (max-width: 720px) { .card { padding: 14px; overflow-x: auto; } }
";

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn badge(pass: bool) -> &'static str {
    if pass { "<span class=\"badge pass\">pass</span>" } else { "<span class=\"badge fail\">fail</span>" }
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

fn bounds((low, high): (f64, f64)) -> String {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("{} … {}", number(low), number(high)),
        (true, false) => format!("≥ {}", number(low)),
        (false, true) => format!("≤ {}", number(high)),
        (false, false) => "any".to_owned(),
    }
}

fn page(entries: &[Entry], about: &Provenance, quick: bool) -> String {
    let mut html = String::new();
    let all = entries.iter().all(Entry::passes);
    let checks: usize = entries.iter().map(|e| e.outcome.checks.len()).sum();
    let seconds: f64 = entries.iter().map(|e| e.seconds).sum();
    let form = if quick { "quick form" } else { "full form" };
    // Writing to a string cannot fail.
    let _ = write!(
        html,
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>Colluvium: validation</title><style>{STYLE}</style></head><body><main>\
         <h1>Validation {}</h1><p class=\"meta\">{checks} checks in {} benchmarks, {form}, {seconds:.0} s · commit {} · {} · {} · {}</p>",
        badge(all),
        entries.len(),
        escape(&about.commit),
        escape(&about.date),
        escape(&about.machine),
        escape(&about.rustc),
    );
    html.push_str(
        "<div class=\"card\"><table><tr><th>Benchmark</th><th>Checks</th><th>Time</th><th></th></tr>",
    );
    for entry in entries {
        let id = entry.benchmark.id;
        let _ = write!(
            html,
            "<tr><td><a href=\"#{id}\">{id}</a> — {}</td><td>{}</td><td>{:.1} s</td><td>{}</td></tr>",
            escape(entry.benchmark.title),
            entry.outcome.checks.len(),
            entry.seconds,
            badge(entry.passes()),
        );
    }
    html.push_str("</table></div>");
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
        "<section class=\"card\" id=\"{}\"><h2>{} {}</h2><p class=\"source\">{}<br>Source: {}</p>",
        benchmark.id,
        escape(benchmark.title),
        badge(entry.passes()),
        benchmark.id,
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
        "<table><tr><th>What</th><th>The source says</th><th>We find</th><th>Passes</th><th>Why these bounds</th><th></th></tr>",
    );
    for check in &entry.outcome.checks {
        let _ = write!(
            html,
            "<tr><td>{}</td><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td><td>{}</td><td>{}</td></tr>",
            escape(&check.name),
            escape(&check.claim),
            number(check.measured),
            bounds(check.range),
            escape(&check.reason),
            badge(check.passes()),
        );
    }
    html.push_str("</table></section>");
}
