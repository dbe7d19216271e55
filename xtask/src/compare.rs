//! `cargo xtask compare`.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use colluvium::case::plot::{LineChart, Picture, PointCloud, Series, Style};
use colluvium::case::{Case, RunOptions, RunReport};

#[derive(Args)]
pub struct Arguments {
    /// The case file.
    case: PathBuf,
}

/// Runs the case with every method that supports it and overlays the measures.
pub fn run(arguments: &Arguments) -> Result<bool, String> {
    let case = Case::load(&arguments.case).map_err(|errors| errors.to_string())?;
    let mut runs: Vec<(&str, RunReport)> = Vec::new();
    for method in colluvium::methods() {
        match method.build(&case) {
            Err(refusal) => println!("{}: not for this case ({refusal})", method.name()),
            Ok(solver) => {
                let options = RunOptions { method: method.name().to_owned(), ..RunOptions::default() };
                let report =
                    colluvium::case::run(&case, solver, &options).map_err(|error| error.to_string())?;
                println!("{}: {} steps in {:.1} s", method.name(), report.steps, report.wall);
                runs.push((method.name(), report));
            }
        }
    }
    if runs.is_empty() {
        return Err("no method supports this case".to_owned());
    }
    let stem = arguments.case.file_stem().unwrap_or_default();
    let folder = crate::root().join("target/compare").join(stem);
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut html = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>body {{ font: 15px/1.5 \
         system-ui, sans-serif; max-width: 960px; margin: 2em auto; }}</style></head><body><h1>{0}</h1>",
        case.title
    );
    let columns: Vec<(String, String)> = runs[0].1.table.columns.clone();
    for (name, unit) in columns.iter().filter(|(name, _)| name != "time" && name != "step") {
        let series = |(method, report): &(&str, RunReport)| {
            Series::new(*method, report.table.pairs("time", name).unwrap_or_default(), Style::Line)
        };
        let chart = LineChart {
            title: name.replace('_', " "),
            x_label: "time (s)".into(),
            y_label: if unit.is_empty() { name.clone() } else { format!("{name} ({unit})") },
            log: false,
            series: runs.iter().map(series).collect(),
        };
        html.push_str(&chart.to_svg()?);
    }
    for (method, report) in &runs {
        if let Some(cloud) = PointCloud::of(&report.snapshot, "displacement", [0, 1]) {
            let file = format!("{method}.png");
            cloud.write(&folder.join(&file)).map_err(|error| error.to_string())?;
            // Writing to a string cannot fail.
            let _ = write!(html, "<h2>{method}</h2><img src=\"{file}\" alt=\"{method}\">");
        }
    }
    html.push_str("</body></html>\n");
    let page = folder.join("index.html");
    std::fs::write(&page, html).map_err(|error| format!("{}: {error}", page.display()))?;
    println!("comparison: {}", page.display());
    Ok(true)
}
