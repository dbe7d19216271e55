//! The benchmarks, one module each.

mod bar;
mod column_collapse;
mod element_tests;
mod localisation;
mod rigid_motion;
mod self_weight;
mod two_disks;

use colluvium::case::plot::Picture;
use colluvium::case::{Case, FieldData, RunOptions, RunReport, Snapshot};

/// A benchmark: a source, what must hold, and the way to find out.
pub struct Benchmark {
    /// Path-like name.
    pub id: &'static str,
    /// What it is, in a line.
    pub title: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// Runs it; `quick` asks for the short form.
    pub run: fn(quick: bool) -> Result<Outcome, String>,
}

/// All benchmarks.
pub const ALL: [Benchmark; 7] = [
    element_tests::BENCHMARK,
    localisation::BENCHMARK,
    rigid_motion::BENCHMARK,
    bar::BENCHMARK,
    self_weight::BENCHMARK,
    two_disks::BENCHMARK,
    column_collapse::BENCHMARK,
];

/// What a benchmark found.
#[derive(Default)]
pub struct Outcome {
    /// What must hold, and whether it does.
    pub checks: Vec<Check>,
    /// Pictures.
    pub figures: Vec<Figure>,
}

/// One thing that must hold.
pub struct Check {
    /// What is checked.
    pub name: String,
    /// What the source says.
    pub claim: String,
    /// What we found.
    pub measured: f64,
    /// Lower and upper bound of what passes.
    pub range: (f64, f64),
    /// Why these bounds.
    pub reason: String,
}

impl Check {
    /// True when the measured value lies within the bounds; NaN never does.
    pub fn passes(&self) -> bool {
        self.measured >= self.range.0 && self.measured <= self.range.1
    }
}

/// A picture with its caption, ready for a page.
pub struct Figure {
    /// Caption.
    pub caption: String,
    /// HTML: inline SVG or an embedded PNG.
    pub html: String,
}

impl Outcome {
    fn within(
        &mut self,
        name: impl Into<String>,
        claim: &str,
        measured: f64,
        range: (f64, f64),
        reason: &str,
    ) {
        let (name, claim, reason) = (name.into(), claim.to_owned(), reason.to_owned());
        self.checks.push(Check { name, claim, measured, range, reason });
    }

    /// Within a relative distance of the source's value (absolute for a value of zero).
    fn near(&mut self, name: impl Into<String>, exact: f64, tolerance: f64, measured: f64, reason: &str) {
        let width = tolerance * if exact == 0.0 { 1.0 } else { exact.abs() };
        self.within(name, &format!("{exact:.10e}"), measured, (exact - width, exact + width), reason);
    }

    fn below(&mut self, name: impl Into<String>, claim: &str, measured: f64, bound: f64, reason: &str) {
        self.within(name, claim, measured, (f64::NEG_INFINITY, bound), reason);
    }

    fn svg(&mut self, caption: &str, picture: &impl Picture) -> Result<(), String> {
        self.figures.push(Figure { caption: caption.to_owned(), html: picture.to_svg()? });
        Ok(())
    }

    fn png(&mut self, caption: &str, picture: &impl Picture) -> Result<(), String> {
        use base64::Engine;
        let file = std::env::temp_dir().join(format!("colluvium-figure-{}.png", std::process::id()));
        picture.write(&file).map_err(|error| error.to_string())?;
        let bytes = std::fs::read(&file).map_err(|error| error.to_string())?;
        let _ = std::fs::remove_file(&file);
        let text = base64::engine::general_purpose::STANDARD.encode(bytes);
        let html = format!("<img alt=\"{caption}\" src=\"data:image/png;base64,{text}\">");
        self.figures.push(Figure { caption: caption.to_owned(), html });
        Ok(())
    }
}

/// The case of a benchmark, `validation/<folder>/case.json`.
fn case(folder: &str) -> Result<Case, String> {
    let path = crate::root().join("validation").join(folder).join("case.json");
    Case::load(&path).map_err(|errors| format!("{}: {errors}", path.display()))
}

/// Sets an option of the material point method.
fn set(case: &mut Case, option: &str, value: impl Into<serde_json::Value>) {
    if let Some(serde_json::Value::Object(options)) = case.methods.get_mut("mpm") {
        options.insert(option.to_owned(), value.into());
    }
}

/// Runs a case in memory, frames kept.
fn run(case: &Case) -> Result<RunReport, String> {
    let method = colluvium::method("mpm").ok_or("no method mpm")?;
    let solver = method.build(case).map_err(|error| error.to_string())?;
    let options = RunOptions { method: "mpm".to_owned(), keep_frames: true, ..RunOptions::default() };
    colluvium::case::run(case, solver, &options).map_err(|error| error.to_string())
}

/// Vectors of a field.
fn vectors(snapshot: &Snapshot, name: &str) -> Vec<[f64; 3]> {
    match snapshot.field(name).map(|f| &f.data) {
        Some(FieldData::Vector(values)) => values.clone(),
        _ => Vec::new(),
    }
}

/// Stresses of the points.
fn stresses(snapshot: &Snapshot) -> Vec<colluvium::constitutive::SymTensor> {
    match snapshot.field("stress").map(|f| &f.data) {
        Some(FieldData::Tensor(values)) => values.clone(),
        _ => Vec::new(),
    }
}

/// A column of the measures; empty where there is none.
fn series(report: &RunReport, name: &str) -> Vec<(f64, f64)> {
    report.table.pairs("time", name).unwrap_or_default()
}
