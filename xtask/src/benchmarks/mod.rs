//! Benchmarks: a folder for each method, a module for each benchmark.

mod compare;
mod dem;
mod depth_sph;
mod element;
mod mpm;
mod outcome;
mod recorder;
mod snow_mpm;
mod sph;

use colluvium::case::output::Table;
use colluvium::case::{Case, FieldData, RunOptions, RunReport, Snapshot};

use crate::analysis::max_or_nan;
pub use outcome::{BenchmarkAnimation, BenchmarkOutcome, Check, CheckVerdict, Criterion, OpenDefect};
pub use recorder::InputRecorder;

/// Benchmark: a source, its requirements, and the function that checks them.
pub struct Benchmark {
    /// Identifier of the benchmark, like a path.
    pub id: &'static str,
    /// Title, in a line.
    pub title: &'static str,
    /// Source of the requirements.
    pub source: &'static str,
    /// Expected time of the short form on one core (s); `None` where `--quick` leaves the benchmark out.
    pub short_seconds: Option<u32>,
    /// Expected time of the full form, on one core (s).
    pub full_seconds: u32,
    /// Function that runs the benchmark, in the short form where `quick` is true.
    pub run: fn(quick: bool) -> Result<BenchmarkOutcome, String>,
}

/// Benchmarks of all methods, one list for each method.
#[rustfmt::skip]
const METHODS: &[&[Benchmark]] = &[
    element::ALL,
    mpm::ALL,
    sph::ALL,
    depth_sph::ALL,
    dem::ALL,
    snow_mpm::ALL,
    compare::ALL,
];

/// Benchmarks of all methods, in the order of the report.
pub fn all_benchmarks() -> impl Iterator<Item = &'static Benchmark> {
    METHODS.iter().copied().flatten()
}

/// Reads the case of a benchmark, `validation/<folder>/case.json`.
fn load_case(folder: &str) -> Result<Case, String> {
    let path = crate::root().join("validation").join(folder).join("case.json");
    recorder::record_file(&path);
    Case::from_file(&path).map_err(|errors| format!("{}: {errors}", path.display()))
}

/// Reads reference data, a CSV file under `validation/` whose first lines name the source.
fn reference_table(file: &str) -> Result<Table, String> {
    let path = crate::root().join("validation").join(file);
    recorder::record_file(&path);
    Table::read(&path).map_err(|error| error.to_string())
}

/// Curve of two columns of reference data, without the rows that lack one of them.
fn reference_curve(table: &Table, x: &str, y: &str) -> Result<Vec<(f64, f64)>, String> {
    let pairs = table.pairs(x, y).ok_or_else(|| format!("the reference data lack {x} or {y}"))?;
    Ok(pairs.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite()).collect())
}

/// Sets an option of the material point method.
fn set_mpm_option(case: &mut Case, option: &str, value: impl Into<serde_json::Value>) {
    set_method_option(case, "mpm", option, value);
}

/// Sets an option of a method.
fn set_method_option(case: &mut Case, method: &str, option: &str, value: impl Into<serde_json::Value>) {
    if let Some(serde_json::Value::Object(options)) = case.methods.get_mut(method) {
        options.insert(option.to_owned(), value.into());
    }
}

/// Case with changed values, each at a JSON pointer. A missing value is added to the object that would contain it.
fn patched_case(case: &Case, changes: &[(&str, serde_json::Value)]) -> Result<Case, String> {
    let mut text: serde_json::Value = serde_json::from_str(&case.to_json()).map_err(|e| e.to_string())?;
    for (pointer, value) in changes {
        let (parent, key) = pointer.rsplit_once('/').ok_or("no pointer")?;
        match text.pointer_mut(parent) {
            Some(serde_json::Value::Object(map)) => map.insert(key.to_owned(), value.clone()),
            _ => return Err(format!("{pointer} leads nowhere")),
        };
    }
    Case::from_json(&text.to_string()).map_err(|errors| errors.to_string())
}

/// Sets keys of a material.
fn set_material(case: &mut Case, material: &str, keys: &[(&str, serde_json::Value)]) -> Result<(), String> {
    let spec = case.materials.get_mut(material).ok_or_else(|| format!("no material {material}"))?;
    let mut text = serde_json::to_value(&*spec).map_err(|error| error.to_string())?;
    keys.iter().for_each(|(key, value)| text[*key] = value.clone());
    *spec = serde_json::from_value(text).map_err(|error| error.to_string())?;
    Ok(())
}

/// Runs a case with the material point method in memory, with all frames.
fn run_mpm(case: &Case) -> Result<RunReport, String> {
    run_in_memory("mpm", case)
}

/// Runs a case in memory, with all frames.
fn run_in_memory(name: &str, case: &Case) -> Result<RunReport, String> {
    let method = colluvium::method(name).ok_or_else(|| format!("no method {name}"))?;
    let options = RunOptions { method: name.to_owned(), keep_frames: true, ..RunOptions::default() };
    // Where a case has no output interval, steps still end at the times of its rows, so that series have even times.
    let mut case = case.clone();
    case.output.measures = case.output.measures.or(Some(case.end_time() / 100.0));
    let report = colluvium::case::run_method(method, &case, &options).map_err(|error| error.to_string())?;
    recorder::record_run(name, &case, &report);
    Ok(report)
}

/// Vectors of a field; empty where it is missing.
fn vectors(snapshot: &Snapshot, name: &str) -> Vec<[f64; 3]> {
    match snapshot.field(name).map(|f| &f.data) {
        Some(FieldData::Vector(values)) => values.clone(),
        _ => Vec::new(),
    }
}

/// JSON object with the entries of another one added or replaced.
fn merged(mut object: serde_json::Value, more: serde_json::Value) -> serde_json::Value {
    if let (Some(object), serde_json::Value::Object(more)) = (object.as_object_mut(), more) {
        object.extend(more);
    }
    object
}

/// Scalars of a field.
fn scalars(snapshot: &Snapshot, name: &str) -> Vec<f64> {
    snapshot.scalars(name).unwrap_or_default().to_vec()
}

/// Largest depth of a point's centre under the first obstacle of a case in space, in any frame (m). A centre on the surface, to the
/// round-off of its coordinates, is not under it.
fn max_penetration(case: &Case, report: &RunReport) -> Result<f64, String> {
    let standing = case.placed_obstacles::<3>().map_err(|error| error.to_string())?;
    let surface = &standing[0].surface;
    let places = report.frames.iter().flat_map(|frame| &frame.positions);
    let depth = |x: &[f64; 3]| {
        let largest = x.iter().fold(0f64, |maximum, c| maximum.max(c.abs()));
        let depth = -surface.gap(x, f64::INFINITY)?.distance;
        (depth > 4.0 * f64::EPSILON * largest).then_some(depth)
    };
    Ok(places.filter(|x| surface.contains(x)).filter_map(depth).fold(0.0, max_or_nan))
}

/// Centre of mass of the points (m).
fn centre_of_mass(snapshot: &Snapshot) -> [f64; 3] {
    let mass = scalars(snapshot, "mass");
    let all: f64 = mass.iter().sum();
    [0, 1, 2].map(|c| mass.iter().zip(&snapshot.positions).map(|(m, x)| m * x[c]).sum::<f64>() / all)
}

/// Stresses of the points (Pa).
fn stresses(snapshot: &Snapshot) -> Vec<colluvium::constitutive::SymTensor> {
    match snapshot.field("stress").map(|f| &f.data) {
        Some(FieldData::Tensor(values)) => values.clone(),
        _ => Vec::new(),
    }
}

/// Column of the measures over time; empty where it is missing.
fn measure_series(report: &RunReport, name: &str) -> Vec<(f64, f64)> {
    report.table.pairs("time", name).unwrap_or_default()
}

/// Last value of a measure; NaN where it is missing.
fn final_measure(report: &RunReport, name: &str) -> f64 {
    measure_series(report, name).last().map_or(f64::NAN, |row| row.1)
}

/// Energies of the contact with obstacles over the work of gravity.
struct ObstacleEnergyShares {
    /// Largest rise of the sum of all energies, including the work on obstacles.
    max_rise: f64,
    /// Work of friction.
    friction: f64,
    /// Energy removed by the penetration limit.
    penetration_limit: f64,
}

/// Energy balance of a run with obstacles, over the work of gravity. The sum of kinetic, elastic, potential and spring energy, and of the
/// work of friction and of the penetration limit, falls by the dissipation in the material.
fn obstacle_energy_shares(report: &RunReport) -> ObstacleEnergyShares {
    let parts =
        ["kinetic_energy", "elastic_energy", "potential_energy", "obstacles.friction", "obstacles.stopped"];
    let [.., potential, friction, stopped] = parts.map(|name| measure_series(report, name));
    let fallen = potential.iter().map(|(_, e)| potential[0].1 - e).fold(0.0, max_or_nan);
    let all = parts.into_iter().chain(["obstacles.stored"]).map(|name| measure_series(report, name));
    let mut sums = vec![0.0; potential.len()];
    all.for_each(|part| part.iter().zip(&mut sums).for_each(|((_, e), sum)| *sum += e));
    let (mut smallest, mut rise) = (f64::INFINITY, 0f64);
    for energy in sums {
        smallest = smallest.min(energy);
        rise = rise.max(energy - smallest);
    }
    let last = |part: &[(f64, f64)]| part.last().map_or(f64::NAN, |last| last.1) / fallen;
    ObstacleEnergyShares {
        max_rise: rise / fallen,
        friction: last(&friction),
        penetration_limit: last(&stopped),
    }
}

/// Initial positions of the points of a case in the plane (m).
fn initial_positions(snapshot: &Snapshot) -> Vec<[f64; 2]> {
    let displacement = vectors(snapshot, "displacement");
    snapshot.positions.iter().zip(displacement).map(|(x, u)| [x[0] - u[0], x[1] - u[1]]).collect()
}
