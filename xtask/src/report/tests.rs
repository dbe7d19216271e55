//! Tests of the texts on the pages of the report.

use super::*;
use crate::benchmarks::{Criterion, OpenDefect, all_benchmarks};

fn entry(checks: &[(f64, bool)]) -> BenchmarkEntry {
    let mut outcome = BenchmarkOutcome::default();
    for (number, (measured, known)) in checks.iter().enumerate() {
        outcome.assert_close(
            format!("check {number}"),
            1.0,
            0.1,
            *measured,
            "a tenth, as <the source> has it",
        );
        let defect = OpenDefect { criterion: Criterion::Missed, observation: "it is \"too far\"".into() };
        outcome.checks[number].defect = known.then_some(defect);
    }
    let benchmark = all_benchmarks().find(|benchmark| benchmark.id == "mpm/column-collapse").unwrap();
    BenchmarkEntry {
        benchmark,
        is_short: true,
        outcome,
        error: None,
        seconds: 0.2,
        files: vec!["validation/a/case.json".into()],
        cached: false,
    }
}

fn scope(entries: &[BenchmarkEntry]) -> ReportScope {
    ReportScope {
        filter: None,
        quick: true,
        short_count: entries.len(),
        full_count: 0,
        skipped_benchmarks: vec!["sph/drum"],
    }
}

#[test]
fn a_failing_check_makes_a_benchmark_fail_whatever_else_is_open() {
    assert_eq!(entry(&[(1.0, false)]).status(), BenchmarkStatus::Pass);
    // A listed defect whose check passes counts as a pass.
    assert_eq!(entry(&[(1.0, true)]).status(), BenchmarkStatus::Pass);
    assert_eq!(entry(&[(1.0, false), (2.0, true)]).status(), BenchmarkStatus::Open);
    assert_eq!(entry(&[(2.0, true), (2.0, false)]).status(), BenchmarkStatus::Fail);
    assert_eq!(entry(&[(f64::NAN, false)]).status(), BenchmarkStatus::Fail);
    assert_eq!(entry(&[]).status(), BenchmarkStatus::Fail);
    let broken = BenchmarkEntry { error: Some("no disk".into()), ..entry(&[(1.0, false)]) };
    assert_eq!(broken.status(), BenchmarkStatus::Fail);
}

#[test]
fn the_page_of_a_benchmark_shows_failed_checks_and_reasons_of_open_ones() {
    let text = benchmark_page::page(&entry(&[(1.0, false), (2.0, true), (3.0, false)]), &provenance(), "../")
        .into_string();
    assert_eq!(text.matches("✓ pass").count(), 1, "one check");
    assert_eq!(text.matches("✗ fail").count(), 2, "one check and the whole");
    assert_eq!(text.matches("◐ open").count(), 2, "one check and its reason");
    assert!(text.contains("Found: it is &quot;too far&quot;."), "{text}");
    assert!(text.contains("as &lt;the source&gt; has it"));
    assert!(text.contains("href=\"../../index.html#mpm/column-collapse\""));
    assert!(text.contains("href=\"../validation/a/case.json\""));
    assert!(
        text.contains("href=\"../docs/sheets/mpm.md\"") && text.contains("href=\"../docs/theory/mpm.md\"")
    );
    assert!(text.contains("cargo xtask validate mpm/column-collapse --quick"));
}

#[test]
fn the_index_page_has_the_counts_of_the_json_report() {
    let entries =
        [entry(&[(1.0, false)]), entry(&[(2.0, true)]), entry(&[(2.0, false), (2.0, true), (1.0, false)])];
    let page = index_page::page(&entries, &provenance(), &scope(&entries)).into_string();
    let json = to_json(&entries, &provenance(), &scope(&entries));
    for status in ["pass", "open", "fail"] {
        let rows = page.matches(&format!("data-status=\"{status}\"")).count();
        let listed = json["benchmarks"].as_array().unwrap().iter().filter(|b| b["status"] == status).count();
        assert_eq!((rows, listed), (1, 1), "{status}");
    }
    assert!(page.contains("5 checks; 2 checks fail as open defects"), "{page}");
    assert!(page.contains("1 pass, 1 open, 1 fail"));
    assert!(page.contains("href=\"pages/mpm/column-collapse.html\""));
    assert!(page.contains("Left out (--long runs them): sph/drum."));
    assert!(
        page.contains("<option value=\"Lube et al. 2005\">")
            && page.contains(concat!("<option value=\"sheet", ": mpm\">"))
    );
}

#[test]
fn a_report_is_an_index_with_pages_and_pictures_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let mut one = entry(&[(1.0, false)]);
    one.outcome.svg("the line", &colluvium::plots::LineChart::default()).unwrap();
    let stale = folder.path().join("pages/mpm/gone.html");
    std::fs::create_dir_all(stale.parent().unwrap()).unwrap();
    std::fs::write(&stale, "").unwrap();
    let entries = [one];
    write(folder.path(), &entries, &scope(&entries)).unwrap();
    assert!(!stale.exists(), "pages of an earlier report");
    let page = std::fs::read_to_string(folder.path().join("pages/mpm/column-collapse.html")).unwrap();
    assert!(page.contains("src=\"column-collapse-1.svg\" alt=\"the line\" loading=\"lazy\""), "{page}");
    assert!(folder.path().join("pages/mpm/column-collapse-1.svg").exists());
    assert!(!page.contains("http"), "nothing of the network");
    let index = std::fs::metadata(folder.path().join("index.html")).unwrap().len();
    assert!(index < 100_000, "{index} bytes");
}

#[test]
fn the_index_of_all_benchmarks_is_below_a_megabyte_and_its_links_lead_to_documents() {
    let with = |benchmark| BenchmarkEntry { benchmark, ..entry(&[(1.0, false)]) };
    let entries: Vec<BenchmarkEntry> = all_benchmarks().map(with).collect();
    let page = index_page::page(&entries, &provenance(), &scope(&entries)).into_string();
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
    for entry in &entries {
        let source = entry.benchmark.source;
        assert!(!index_page::sources(source).is_empty(), "{source}");
        let sheets =
            benchmark_page::sheets(source).into_iter().map(|sheet| format!("docs/sheets/{sheet}.md"));
        for file in sheets.chain([benchmark_page::theory(entry.method())]) {
            assert!(crate::root().join(&file).exists(), "{}: {file}", entry.benchmark.id);
        }
    }
}
