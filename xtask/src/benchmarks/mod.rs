//! The benchmarks, one module each.

mod aluminium_bars;
mod bar;
mod cantilever;
mod column_a04;
mod column_collapse;
mod contract;
mod critical_state;
mod element_tests;
mod finite_strain;
mod flow;
mod flow_cycles;
mod kinematics;
mod localisation;
mod manufactured;
mod mpm_axisymmetric;
mod mpm_contact;
mod mpm_cut;
mod mpm_footing;
mod mpm_liquid;
mod mpm_saturated;
mod mpm_slope;
mod mpm_step_wave;
mod mpm_two_phase;
mod mpm_units;
mod returns;
mod rigid_motion;
mod self_weight;
mod simplices;
mod simplices_soil;
mod sph_balance;
mod sph_cantilever;
mod sph_cantilever_3d;
mod sph_clay;
mod sph_column;
mod sph_columns;
mod sph_critical;
mod sph_cylinders;
mod sph_drum;
mod sph_flow;
mod sph_footing;
mod sph_geostatic;
mod sph_membrane;
mod sph_operators;
mod sph_pairing;
mod sph_ranks;
mod sph_shear;
mod sph_slope;
mod sph_tensile;
mod sph_threads;
mod sph_waves;
mod two_disks;

use std::collections::BTreeMap;

use colluvium::case::output::Table;
use colluvium::case::plot::Picture;
use colluvium::case::{Case, FieldData, RunOptions, RunReport, Snapshot};
use serde::{Deserialize, Serialize};

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

/// A benchmark in the list, with what it costs.
pub struct Listed {
    /// The benchmark.
    pub benchmark: &'static Benchmark,
    /// Seconds to expect of the short form, on one core; `None` where `--quick` leaves it out.
    pub quick: Option<u32>,
    /// Seconds to expect of the full form, on one core.
    pub full: u32,
}

impl Listed {
    const fn new(benchmark: &'static Benchmark, quick: Option<u32>, full: u32) -> Self {
        Self { benchmark, quick, full }
    }
}

/// All benchmarks.
pub const ALL: &[Listed] = &[
    Listed::new(&element_tests::BENCHMARK, Some(1), 1),
    Listed::new(&returns::BENCHMARK, Some(1), 1),
    Listed::new(&contract::BENCHMARK, Some(5), 5),
    Listed::new(&critical_state::BENCHMARK, Some(2), 2),
    Listed::new(&flow::BENCHMARK, Some(1), 1),
    Listed::new(&finite_strain::BENCHMARK, Some(1), 1),
    Listed::new(&localisation::BENCHMARK, Some(2), 2),
    Listed::new(&kinematics::BENCHMARK, Some(6), 6),
    Listed::new(&rigid_motion::BENCHMARK, Some(15), 15),
    Listed::new(&bar::BENCHMARK, Some(7), 7),
    Listed::new(&self_weight::BENCHMARK, Some(12), 12),
    Listed::new(&two_disks::BENCHMARK, Some(1), 1),
    Listed::new(&manufactured::AXIS_ALIGNED, Some(15), 78),
    Listed::new(&manufactured::VORTEX, Some(45), 60),
    Listed::new(&cantilever::BENCHMARK, None, 340),
    Listed::new(&simplices::BENCHMARK, Some(5), 5),
    Listed::new(&simplices_soil::BENCHMARK, Some(6), 6),
    Listed::new(&mpm_contact::BENCHMARK, Some(28), 28),
    Listed::new(&mpm_two_phase::CONSOLIDATION, Some(15), 22),
    Listed::new(&mpm_two_phase::WAVES, Some(1), 1),
    Listed::new(&mpm_units::BENCHMARK, Some(6), 6),
    Listed::new(&mpm_step_wave::BENCHMARK, Some(1), 1),
    Listed::new(&mpm_footing::BENCHMARK, Some(9), 105),
    Listed::new(&mpm_cut::BENCHMARK, Some(17), 250),
    Listed::new(&mpm_slope::BENCHMARK, Some(16), 780),
    Listed::new(&mpm_axisymmetric::BENCHMARK, Some(25), 60),
    Listed::new(&mpm_saturated::PHASES, Some(2), 2),
    Listed::new(&mpm_saturated::GRAVITY, Some(4), 4),
    Listed::new(&mpm_saturated::ABSORBING, Some(2), 2),
    Listed::new(&mpm_liquid::HYDROSTATIC, Some(2), 2),
    Listed::new(&mpm_liquid::VISCOUS, Some(6), 6),
    Listed::new(&mpm_liquid::DAM_BREAK, Some(3), 20),
    Listed::new(&column_collapse::BENCHMARK, Some(64), 250),
    Listed::new(&column_a04::BENCHMARK, Some(56), 1700),
    Listed::new(&aluminium_bars::BENCHMARK, Some(22), 82),
    Listed::new(&sph_operators::BENCHMARK, Some(2), 2),
    Listed::new(&sph_balance::BENCHMARK, Some(1), 1),
    Listed::new(&sph_waves::BENCHMARK, Some(1), 1),
    Listed::new(&sph_flow::BENCHMARK, Some(4), 10),
    Listed::new(&sph_shear::BENCHMARK, Some(6), 8),
    Listed::new(&sph_pairing::BENCHMARK, Some(12), 52),
    Listed::new(&sph_geostatic::BENCHMARK, Some(24), 72),
    Listed::new(&sph_column::BENCHMARK, None, 290),
    Listed::new(&sph_slope::BENCHMARK, None, 310),
    Listed::new(&sph_tensile::BENCHMARK, Some(10), 10),
    Listed::new(&sph_cantilever_3d::BENCHMARK, None, 2200),
    Listed::new(&sph_cantilever_3d::UPDATED, None, 2800),
    Listed::new(&sph_drum::BENCHMARK, None, 45),
    Listed::new(&sph_drum::FINE, None, 110),
    Listed::new(&sph_threads::BENCHMARK, Some(2), 8),
    Listed::new(&sph_ranks::BENCHMARK, Some(4), 4),
    Listed::new(&sph_critical::SHEAR, Some(2), 80),
    Listed::new(&sph_critical::COLUMNS, None, 16),
    Listed::new(&sph_critical::COLUMNS_FINE, None, 1200),
    Listed::new(&sph_cantilever::BENCHMARK, None, 400),
    Listed::new(&sph_columns::BENCHMARK, None, 120),
    Listed::new(&sph_columns::SWEEP, None, 3600),
    Listed::new(&sph_clay::BENCHMARK, None, 62),
    Listed::new(&sph_clay::FINE, None, 5200),
    Listed::new(&sph_cylinders::BENCHMARK, None, 1400),
    Listed::new(&sph_footing::BENCHMARK, Some(30), 220),
    Listed::new(&sph_footing::SMOOTH, Some(30), 220),
    Listed::new(&sph_footing::SOILS, None, 34),
    Listed::new(&sph_footing::SOILS_FINE, None, 320),
    Listed::new(&sph_membrane::BENCHMARK, None, 85),
];

/// What a benchmark found.
#[derive(Default)]
pub struct Outcome {
    /// What must hold, and whether it does.
    pub checks: Vec<Check>,
    /// Pictures.
    pub figures: Vec<Figure>,
}

/// One thing that must hold, or that is shown without a judgement.
pub struct Check {
    /// What is checked.
    pub name: String,
    /// What the source says.
    pub claim: String,
    /// What we found.
    pub measured: f64,
    /// Lower and upper bound of what passes; `None` where the value is shown and not judged.
    pub range: Option<(f64, f64)>,
    /// Why these bounds, or why none.
    pub reason: String,
    /// What is known of a check that does not hold: an open defect.
    pub defect: Option<Known>,
}

/// What is known of an open defect.
#[derive(Clone, Debug, Serialize)]
pub struct Known {
    /// How it stands with what the source asks.
    pub criterion: Criterion,
    /// What was found.
    pub found: String,
}

/// How a check that fails stands with what its source asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Criterion {
    /// What the source asks is not met.
    Missed,
    /// What the source asks disagrees with a closed form, with another of its references or with its own computation.
    Disputed,
    /// What the source asks is met elsewhere; this check goes beyond it.
    Met,
}

impl Criterion {
    /// Each, in order of weight.
    pub const ALL: [Self; 3] = [Self::Missed, Self::Disputed, Self::Met];

    /// In words, after a number of checks or before what was found.
    pub fn words(self) -> &'static str {
        match self {
            Self::Missed => "against a criterion of the source that is missed",
            Self::Disputed => "against a criterion that another reference contradicts",
            Self::Met => "beyond the criterion of the source, which is met",
        }
    }
}

/// What a check says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The value lies within its bounds.
    Pass,
    /// It does not.
    Fail,
    /// It does not, and is listed among the open defects.
    Open,
    /// It has no bounds.
    NotJudged,
}

impl Verdict {
    /// The verdict in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "FAIL",
            Self::Open => "FAIL, open",
            Self::NotJudged => "not judged",
        }
    }
}

impl Check {
    /// Whether the measured value lies within the bounds; NaN never does.
    pub fn verdict(&self) -> Verdict {
        match self.range {
            None => Verdict::NotJudged,
            Some((low, high)) if self.measured >= low && self.measured <= high => Verdict::Pass,
            Some(_) if self.defect.is_some() => Verdict::Open,
            Some(_) => Verdict::Fail,
        }
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
        self.checks.push(Check { name, claim, measured, range: Some(range), reason, defect: None });
    }

    /// A value that is shown and not judged; the reason says why.
    fn show(&mut self, name: impl Into<String>, claim: &str, measured: f64, reason: &str) {
        let (name, claim, reason) = (name.into(), claim.to_owned(), reason.to_owned());
        self.checks.push(Check { name, claim, measured, range: None, reason, defect: None });
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
        let html = crate::html::embedded_png(picture, caption)?;
        self.figures.push(Figure { caption: caption.to_owned(), html });
        Ok(())
    }
}

/// The case of a benchmark, `validation/<folder>/case.json`.
fn case(folder: &str) -> Result<Case, String> {
    let path = crate::root().join("validation").join(folder).join("case.json");
    Case::load(&path).map_err(|errors| format!("{}: {errors}", path.display()))
}

/// Reference data, a CSV file under `validation/` whose first lines say where the numbers are from.
fn reference(file: &str) -> Result<Table, String> {
    Table::read(&crate::root().join("validation").join(file)).map_err(|error| error.to_string())
}

/// Two columns of reference data, without the rows that lack one of them.
fn curve(table: &Table, x: &str, y: &str) -> Result<Vec<(f64, f64)>, String> {
    let pairs = table.pairs(x, y).ok_or_else(|| format!("the reference data lack {x} or {y}"))?;
    Ok(pairs.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite()).collect())
}

/// Sets an option of the material point method.
fn set(case: &mut Case, option: &str, value: impl Into<serde_json::Value>) {
    set_of(case, "mpm", option, value);
}

/// Sets an option of a method.
fn set_of(case: &mut Case, method: &str, option: &str, value: impl Into<serde_json::Value>) {
    if let Some(serde_json::Value::Object(options)) = case.methods.get_mut(method) {
        options.insert(option.to_owned(), value.into());
    }
}

/// Sets keys of a material.
fn set_material(case: &mut Case, material: &str, keys: &[(&str, serde_json::Value)]) -> Result<(), String> {
    let spec = case.materials.get_mut(material).ok_or_else(|| format!("no material {material}"))?;
    let mut text = serde_json::to_value(&*spec).map_err(|error| error.to_string())?;
    keys.iter().for_each(|(key, value)| text[*key] = value.clone());
    *spec = serde_json::from_value(text).map_err(|error| error.to_string())?;
    Ok(())
}

/// Runs a case with the material point method in memory, frames kept.
fn run(case: &Case) -> Result<RunReport, String> {
    run_by("mpm", case)
}

/// Runs a case in memory, frames kept.
fn run_by(name: &str, case: &Case) -> Result<RunReport, String> {
    let method = colluvium::method(name).ok_or_else(|| format!("no method {name}"))?;
    let options = RunOptions { method: name.to_owned(), keep_frames: true, ..RunOptions::default() };
    // Where a case names no interval steps end on its rows all the same, so that series are at even times.
    let mut case = case.clone();
    case.output.measures = case.output.measures.or(Some(case.end_time() / 100.0));
    colluvium::case::run_method(method, &case, &options).map_err(|error| error.to_string())
}

/// The larger of both; not a number where one of them is none, so that a check fails on it.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a >= b { a } else { b }
}

/// The largest of what a benchmark found.
trait Largest {
    /// NaN, which fails every check, where there are no numbers or one of them is none.
    fn largest(self) -> f64;
}

impl<I: Iterator<Item = f64>> Largest for I {
    fn largest(self) -> f64 {
        self.reduce(larger).unwrap_or(f64::NAN)
    }
}

/// Vectors of a field; none where it is not there.
fn vectors(snapshot: &Snapshot, name: &str) -> Vec<[f64; 3]> {
    match snapshot.field(name).map(|f| &f.data) {
        Some(FieldData::Vector(values)) => values.clone(),
        _ => Vec::new(),
    }
}

/// A JSON object with entries of another added or replaced.
fn with(mut object: serde_json::Value, more: serde_json::Value) -> serde_json::Value {
    if let (Some(object), serde_json::Value::Object(more)) = (object.as_object_mut(), more) {
        object.extend(more);
    }
    object
}

/// A field of one number a point.
fn scalars(snapshot: &Snapshot, name: &str) -> Vec<f64> {
    snapshot.scalars(name).unwrap_or_default().to_vec()
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

/// Where the points of a case in the plane were at the start (m).
fn starts(snapshot: &Snapshot) -> Vec<[f64; 2]> {
    let displacement = vectors(snapshot, "displacement");
    snapshot.positions.iter().zip(displacement).map(|(x, u)| [x[0] - u[0], x[1] - u[1]]).collect()
}

/// Where what moves ends: in each column of particles, given by their places at the start (m) and a value, from the top
/// down the first place where the value falls below a level.
fn lower_boundary(
    particles: impl IntoIterator<Item = ([f64; 2], f64)>,
    spacing: f64,
    level: f64,
) -> Vec<[f64; 2]> {
    let mut columns: BTreeMap<i64, Vec<([f64; 2], f64)>> = BTreeMap::new();
    for (place, value) in particles {
        columns.entry((place[0] / spacing).floor() as i64).or_default().push((place, value));
    }
    let crossing = |mut column: Vec<([f64; 2], f64)>| {
        column.sort_by(|a, b| b.0[1].total_cmp(&a.0[1]));
        let pair = column.windows(2).find(|pair| pair[0].1 >= level && pair[1].1 < level)?;
        let ((above, a), (below, b)) = (pair[0], pair[1]);
        let share = (a - level) / (a - b);
        Some([0, 1].map(|axis| above[axis] + share * (below[axis] - above[axis])))
    };
    columns.into_values().filter_map(crossing).collect()
}

/// Slope of the straight line through the points, by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) = points
        .iter()
        .fold((0.0, 0.0), |(xy, xx), p| (xy + (p.0 - mx) * (p.1 - my), xx + (p.0 - mx) * (p.0 - mx)));
    xy / xx
}

/// How far `along` that share of the particles reaches, all of one mass (m).
fn reach_of(snapshot: &Snapshot, share: f64, along: impl Fn(&[f64; 3]) -> f64) -> f64 {
    let mut places: Vec<f64> = snapshot.positions.iter().map(along).collect();
    places.sort_by(f64::total_cmp);
    let number = (share * places.len() as f64).ceil() as usize;
    places.get(number.saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

/// The outermost particle along x with at least two neighbours within 1.5 spacings (SPH sheet, set S), in m.
fn held_front(snapshot: &Snapshot, spacing: f64) -> f64 {
    farthest_held(snapshot, spacing, |x| x[0])
}

/// How far `along` the particles reach that have at least two neighbours within 1.5 spacings (m).
fn farthest_held(snapshot: &Snapshot, spacing: f64, along: impl Fn(&[f64; 3]) -> f64) -> f64 {
    let x = &snapshot.positions;
    let near = |a: &[f64; 3], b: &[f64; 3]| {
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>() <= (1.5 * spacing).powi(2)
    };
    let mut order: Vec<&[f64; 3]> = x.iter().collect();
    order.sort_by(|a, b| along(b).total_cmp(&along(a)));
    let held = |a: &&&[f64; 3]| x.iter().filter(|b| near(a, b)).count() > 2;
    order.iter().find(held).map_or(f64::NAN, |a| along(a))
}

/// Height of the highest point before `x` (m).
fn crest(snapshot: &Snapshot, x: f64) -> f64 {
    let near = snapshot.positions.iter().zip(&snapshot.extents).filter(|(p, _)| p[0] < x);
    near.map(|(p, e)| p[1] + 0.5 * e[1]).largest()
}
