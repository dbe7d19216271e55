//! `cargo xtask compare`.

use std::fmt::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use clap::Args;
use colluvium::case::output::heading;
use colluvium::case::plot::{LineChart, Picture, PointCloud, Series, Style};
use colluvium::case::{Case, Method, RunOptions, RunReport};

use crate::html::{embedded_png, escape};

#[derive(Args)]
pub struct Arguments {
    /// The case file.
    case: PathBuf,
}

/// What came of a method.
enum End {
    /// It cannot honour the case; the text says why.
    Refused(String),
    /// It began and did not finish; the text says why.
    Failed(String),
    /// It ran.
    Done(Box<RunReport>),
}

/// Runs the case with every method that supports it and overlays the measures; true when all that began
/// have finished.
pub fn run(arguments: &Arguments) -> Result<bool, String> {
    let case = Case::load(&arguments.case).map_err(|errors| errors.to_string())?;
    let methods = colluvium::methods();
    let ends: Vec<(&str, End)> = methods.iter().map(|method| (method.name(), end(*method, &case))).collect();
    if ends.iter().all(|(_, end)| matches!(end, End::Refused(_))) {
        return Err("no method supports this case".to_owned());
    }
    let stem = arguments.case.file_stem().unwrap_or_default();
    let folder = crate::root().join("target/compare").join(stem);
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let file = folder.join("index.html");
    colluvium::case::output::write_atomically(&file, page(&case, &ends)?.as_bytes())
        .map_err(|error| error.to_string())?;
    println!("comparison: {}", file.display());
    Ok(!ends.iter().any(|(_, end)| matches!(end, End::Failed(_))))
}

/// Runs the case with one method. Whatever goes wrong there, the others still run.
fn end(method: &dyn Method, case: &Case) -> End {
    let attempt = || match method.build(case) {
        Err(refusal) => End::Refused(refusal.to_string()),
        Ok(_) => {
            let options = RunOptions { method: method.name().to_owned(), ..RunOptions::default() };
            match colluvium::case::run_method(method, case, &options) {
                Ok(report) => End::Done(Box::new(report)),
                Err(error) => End::Failed(error.to_string()),
            }
        }
    };
    let end =
        catch_unwind(AssertUnwindSafe(attempt)).unwrap_or_else(|_| End::Failed("it panicked".to_owned()));
    match &end {
        End::Refused(why) => println!("{}: not for this case ({why})", method.name()),
        End::Failed(why) => println!("{}: FAILED, {why}", method.name()),
        End::Done(report) => println!("{}: {} steps in {:.1} s", method.name(), report.steps, report.wall),
    }
    end
}

const STYLE: &str = "body { font: 15px/1.5 system-ui, sans-serif; max-width: 960px; margin: 2em auto; padding: 0 1em; } \
                     table { border-collapse: collapse; } th, td { text-align: left; padding: 4px 12px 4px 0; \
                     border-bottom: 1px solid #dde3e9; vertical-align: top; } .failed { color: #c0392b; } \
                     svg, img { max-width: 100%; height: auto; }";

/// The page; it needs no other file.
fn page(case: &Case, ends: &[(&str, End)]) -> Result<String, String> {
    let title = escape(&case.title);
    let mut html = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title><style>{STYLE}</style>\
         </head><body><h1>{title}</h1><table><tr><th>Method</th><th>Result</th><th>Steps</th><th>Time</th>"
    );
    let searches: Vec<&str> = case.factors_of_safety().map(|(name, _)| name).collect();
    for name in &searches {
        // Writing to a string cannot fail.
        let _ = write!(html, "<th>{}: factor of safety</th>", escape(name));
    }
    html.push_str("</tr>");
    let rest = 3 + searches.len();
    for (method, end) in ends {
        let _ = match end {
            End::Refused(why) => {
                write!(
                    html,
                    "<tr><td>{method}</td><td colspan=\"{rest}\">not for this case: {}</td></tr>",
                    escape(why)
                )
            }
            End::Failed(why) => write!(
                html,
                "<tr class=\"failed\"><td>{method}</td><td colspan=\"{rest}\">failed: {}</td></tr>",
                escape(why)
            ),
            End::Done(report) => write!(
                html,
                "<tr><td>{method}</td><td>completed</td><td>{}</td><td>{:.1} s</td>{}</tr>",
                report.steps,
                report.wall,
                factors(report, &searches)
            ),
        };
    }
    html.push_str("</table>");
    let runs: Vec<(&str, &RunReport)> = ends
        .iter()
        .filter_map(|(method, end)| match end {
            End::Done(report) => Some((*method, &**report)),
            _ => None,
        })
        .collect();
    for chart in charts(&runs) {
        html.push_str(&chart.to_svg()?);
    }
    for (method, report) in &runs {
        if let Some(cloud) = PointCloud::of(&report.snapshot, "displacement", [0, 1]) {
            let _ = write!(html, "<h2>{method}</h2>{}", embedded_png(&cloud, method)?);
        }
    }
    html.push_str("</body></html>\n");
    Ok(html)
}

/// Cells with what the searches for a factor of safety found.
fn factors(report: &RunReport, searches: &[&str]) -> String {
    let found = |name: &&str| match report.safety.get(*name) {
        None => String::new(),
        Some(safety) => match safety.factor() {
            Some(factor) => format!("{factor:.3} ({:.3} to {:.3})", safety.stable, safety.failed),
            None if safety.stable == 0.0 => format!("below {:.3}", safety.failed),
            None => format!("above {:.3}", safety.stable),
        },
    };
    searches.iter().map(|name| format!("<td>{}</td>", found(name))).collect()
}

/// One chart per measure, every method that has it in it.
fn charts(runs: &[(&str, &RunReport)]) -> Vec<LineChart> {
    let mut columns: Vec<&(String, String)> = Vec::new();
    for column in runs.iter().flat_map(|(_, report)| &report.table.columns) {
        if column.0 != "time" && column.0 != "step" && !columns.contains(&column) {
            columns.push(column);
        }
    }
    let chart = |(name, unit): &(String, String)| LineChart {
        title: name.replace('_', " "),
        x_label: "time (s)".into(),
        y_label: heading(name, unit),
        log: false,
        series: runs
            .iter()
            .filter_map(|(method, report)| {
                Some(Series::new(*method, report.table.pairs("time", name)?, Style::Line))
            })
            .collect(),
    };
    columns.into_iter().map(chart).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_run_stands_in_the_table_beside_the_others_and_the_page_needs_no_other_file() {
        let text = colluvium::template("column-collapse").expect("a template");
        let mut case = Case::from_json(text).expect("a case");
        case.stages[0].duration = 0.002;
        let method = colluvium::method("mpm").expect("the method");
        let ends = [
            ("broken", End::Failed("step 3: <inside out>".to_owned())),
            ("other", End::Refused("gravity: not here".to_owned())),
            ("mpm", end(method, &case)),
        ];
        let html = page(&case, &ends).expect("a page");
        for words in ["failed: step 3: &lt;inside out&gt;", "not for this case: gravity", "completed", "<svg"]
        {
            assert!(html.contains(words), "{words}");
        }
        assert_eq!(html.matches("src=\"").count(), html.matches("src=\"data:image/png;base64,").count());
        assert!(html.contains("src=\"data:"));
    }

    #[test]
    fn what_a_search_for_a_factor_of_safety_finds_stands_in_the_table() {
        let text = colluvium::template("column-collapse").expect("a template");
        let mut case = Case::from_json(text).expect("a case");
        case.stages[0].duration = 0.002;
        let search = serde_json::json!({
            "kind": "factor-of-safety", "after": case.stages[0].name, "duration": 0.002, "height": 0.1,
            "range": [1, 2], "tolerance": 1
        });
        case.measures.insert("safety".to_owned(), serde_json::from_value(search).expect("a measure"));
        let weakening = serde_json::from_value(serde_json::json!({ "factor": 1.1 }));
        case.stages[0].weakening = Some(weakening.expect("a weakening"));
        let ends = [("mpm", end(colluvium::method("mpm").expect("the method"), &case))];
        let html = page(&case, &ends).expect("a page");
        assert!(html.contains("<th>safety: factor of safety</th>"));
        let End::Done(report) = &ends[0].1 else { panic!("{html}") };
        let cell = factors(report, &["safety"]);
        assert!(
            html.contains(&cell) && ["above", "below", "1."].iter().any(|word| cell.contains(word)),
            "{cell}"
        );
    }
}
