//! `cargo xtask bench`: point-updates per second of the material point method, and of any case with `--case`.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use colluvium::case::{Case, Solver};
use serde_json::json;

use crate::speed::textbook_mpm::{TextbookProblem, TextbookShape, TextbookSolver};

#[derive(Args)]
pub struct BenchArguments {
    /// Only settings whose name contains this.
    filter: Option<String>,
    /// Leave out the runs with a million points.
    #[arg(long, conflicts_with = "points")]
    small: bool,
    /// Approximate number of points, instead of ten thousand and a million.
    #[arg(long, value_parser = clap::value_parser!(u32).range(100..))]
    points: Option<u32>,
    /// Measure also the memory bandwidth (needs 0.8 GB).
    #[arg(long)]
    bandwidth: bool,
    /// Only the comparison with the textbook kernel.
    #[arg(long)]
    textbook: bool,
    /// Measure particle-updates per second of smoothed particle hydrodynamics instead.
    #[arg(long)]
    sph: bool,
    /// Measure stress updates per second of every law instead.
    #[arg(long)]
    laws: bool,
    /// Measure a case with its methods instead: the same steps of its first stage on each number of threads.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["filter", "small", "points", "textbook", "sph", "laws"])]
    case: Option<PathBuf>,
    /// Only this method of the case.
    #[arg(long, requires = "case")]
    method: Option<String>,
    /// Number of steps of the case before the measurement.
    #[arg(long, requires = "case", default_value_t = 3)]
    warm_up_steps: usize,
    /// Number of measured steps of the case; by default the number that the first number of threads completes in `--seconds`.
    #[arg(long, requires = "case", value_parser = clap::value_parser!(u32).range(1..))]
    steps: Option<u32>,
    /// Numbers of threads, one after the other.
    #[arg(long, value_delimiter = ',', default_values_t = [1, 2], value_parser = threads)]
    threads: Vec<usize>,
    /// Seconds of measurement per setting.
    #[arg(long, default_value_t = 2.0)]
    seconds: f64,
}

/// Parses a number of threads.
fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) | Err(_) => Err("a number of threads must be 1 or more".to_owned()),
        Ok(count) => Ok(count),
    }
}

/// Density of the soil of the block (kg/m³).
const DENSITY: f64 = 2000.0;
/// Young's modulus of the soil (Pa).
const YOUNGS_MODULUS: f64 = 1e6;
/// Poisson's ratio of the soil.
const POISSONS_RATIO: f64 = 0.3;
/// Gravitational acceleration (m/s²); small, so that the block stays in place during the measurement.
const GRAVITY: f64 = -0.1;

/// Name of the elastic soil with water in its pores, solved as two phases.
const SATURATED_SOIL: &str = "two-phase";

/// Problem, method options and number of threads of a measurement.
struct BenchSetting {
    dimension: usize,
    shape: &'static str,
    scheme: &'static str,
    model: &'static str,
    points: usize,
    threads: usize,
}

impl BenchSetting {
    /// Name of the setting: its values separated by commas.
    fn name(&self) -> String {
        let Self { dimension, shape, scheme, model, points, threads } = self;
        format!("{dimension}d,{shape},{scheme},{model},{points},{threads}")
    }

    /// Number of cells along an edge of the block.
    fn cells(&self) -> usize {
        ((self.points as f64).powf(1.0 / self.dimension as f64) / 2.0).round().max(2.0) as usize
    }

    /// Case of a block at rest on the floor that settles under a small gravity, with two points per cell and direction.
    fn case(&self) -> Result<Case, String> {
        let cell = 1.0 / self.cells() as f64;
        let all = |value: f64| vec![value; self.dimension];
        let mut gravity = all(0.0);
        gravity[1] = GRAVITY;
        let mut floor = all(-4.0 * cell);
        floor[1] = 0.0;
        let mut material = json!({
            "model": self.model, "density": DENSITY, "youngs_modulus": YOUNGS_MODULUS, "poissons_ratio": POISSONS_RATIO
        });
        let saturated = self.model == SATURATED_SOIL;
        if saturated {
            material["model"] = json!("linear-elastic");
        } else if self.model != "linear-elastic" {
            // Weak enough that the block yields under its weight.
            material["friction_angle"] = json!(20.0);
            material["cohesion"] = json!(0.1);
        }
        let mut text = json!({
            "title": "throughput",
            "space": if self.dimension == 2 { "plane-strain" } else { "3d" },
            "domain": { "min": floor, "max": all(1.0 + 4.0 * cell) },
            "gravity": gravity,
            "materials": { "soil": material },
            "bodies": [{ "name": "block", "material": "soil", "shape": { "kind": "box", "min": all(0.0), "max": all(1.0) } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
            "stages": [{ "name": "shake", "duration": 1.0 }],
            "methods": { "mpm": { "cell_size": cell, "shape": self.shape, "stress_update": self.scheme } }
        });
        if saturated {
            text["bodies"][0]["pore_fluid"] =
                json!({ "porosity": 0.4, "permeability": 1e-3, "bulk_modulus": 1e7 });
        }
        Case::from_json(&text.to_string()).map_err(|errors| errors.to_string())
    }

    /// Measures the solver. Returns the number of points and million point-updates per second.
    fn measure(&self, seconds: f64) -> Result<(usize, f64), String> {
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(self.threads).build().map_err(|e| e.to_string())?;
        pool.install(|| {
            let mut solver = self.solver()?;
            let points = solver.point_count();
            let rate = updates_per_second(points, seconds, || {
                let dt = solver.limit().dt;
                solver.step(dt).map(drop).map_err(|error| error.to_string())
            })?;
            Ok((points, rate))
        })
    }

    /// Solver at the start of the first stage.
    fn solver(&self) -> Result<Box<dyn Solver>, String> {
        let method = colluvium::method("mpm").ok_or("no method mpm")?;
        let mut solver = method.build(&self.case()?).map_err(|error| error.to_string())?;
        solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
        Ok(solver)
    }

    /// Textbook solver of the problem, which has an elastic material.
    fn textbook<const D: usize>(&self) -> TextbookSolver<D> {
        TextbookSolver::new(TextbookProblem {
            cells: self.cells(),
            shape: if self.shape == "linear" { TextbookShape::Linear } else { TextbookShape::Quadratic },
            density: DENSITY,
            youngs_modulus: YOUNGS_MODULUS,
            poissons_ratio: POISSONS_RATIO,
            gravity: GRAVITY,
        })
    }

    /// Measures the textbook solver with the step of this project's solver. Returns million point-updates per second.
    fn measure_textbook<const D: usize>(&self, seconds: f64) -> Result<f64, String> {
        let dt = self.solver()?.limit().dt;
        let mut textbook = self.textbook::<D>();
        updates_per_second(textbook.points.len(), seconds, || {
            textbook.step(dt);
            Ok(())
        })
    }

    /// Measures this project's solver and the textbook solver in turn, three times. Returns the best result of each.
    fn measure_against_textbook(&self, seconds: f64) -> Result<(usize, f64, f64), String> {
        let (mut points, mut ours, mut textbook) = (0, 0f64, 0f64);
        for _ in 0..3 {
            let (count, rate) = self.measure(seconds / 3.0)?;
            points = count;
            ours = ours.max(rate);
            textbook = textbook.max(match self.dimension {
                2 => self.measure_textbook::<2>(seconds / 3.0)?,
                _ => self.measure_textbook::<3>(seconds / 3.0)?,
            });
        }
        Ok((points, ours, textbook))
    }
}

/// Million point-updates per second of `step`, over about `seconds`.
pub fn updates_per_second(
    points: usize,
    seconds: f64,
    mut step: impl FnMut() -> Result<(), String>,
) -> Result<f64, String> {
    // The first steps fill the caches.
    for _ in 0..3 {
        step()?;
    }
    let batch = (100_000 / points).clamp(1, 20);
    let (mut steps, start) = (0, Instant::now());
    while start.elapsed().as_secs_f64() < seconds && steps < 2000 {
        for _ in 0..batch {
            step()?;
        }
        steps += batch;
    }
    Ok((points * steps) as f64 / start.elapsed().as_secs_f64() / 1e6)
}

/// Memory bandwidth (GB/s) of `a = b + s c` over arrays far larger than the caches.
fn bandwidth(threads: usize) -> Result<f64, String> {
    use rayon::prelude::*;
    /// Number of entries of each array.
    const LENGTH: usize = 1 << 25;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| e.to_string())?;
    let (b, c) = (vec![1.0f64; LENGTH], vec![2.0f64; LENGTH]);
    let mut a = vec![0.0f64; LENGTH];
    let mut best = 0.0f64;
    for _ in 0..5 {
        let start = Instant::now();
        pool.install(|| {
            let chunk = LENGTH / threads;
            a.par_chunks_mut(chunk).zip(b.par_chunks(chunk)).zip(c.par_chunks(chunk)).for_each(
                |((a, b), c)| {
                    a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = b + 3.0 * c);
                },
            );
        });
        best = best.max(3.0 * 8.0 * LENGTH as f64 / start.elapsed().as_secs_f64() / 1e9);
    }
    Ok(best)
}

/// Largest memory of this process so far (MB), where the system reports it.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().trim_end_matches(" kB").parse().ok()?;
    Some(kilobytes / 1e3)
}

/// Measures all settings and prints a table in CSV.
pub fn run(arguments: &BenchArguments) -> Result<bool, String> {
    if arguments.laws {
        crate::speed::laws::run(arguments.filter.as_deref(), arguments.seconds)?;
        return Ok(true);
    }
    for &threads in arguments.threads.iter().filter(|_| arguments.bandwidth) {
        println!("# memory bandwidth on {threads} threads: {:.1} GB/s", bandwidth(threads)?);
    }
    if let Some(file) = &arguments.case {
        crate::speed::case::print_table(&crate::speed::case::CaseBenchSettings {
            file,
            method: arguments.method.as_deref(),
            threads: &arguments.threads,
            warm_up_steps: arguments.warm_up_steps,
            steps: arguments.steps.map(|steps| steps as usize),
            seconds: arguments.seconds,
        })?;
        return Ok(true);
    }
    println!("# million point-updates per second of wall-clock time");
    let sizes = match (arguments.points, arguments.small) {
        (Some(points), _) => vec![points as usize],
        (None, true) => vec![10_000],
        (None, false) => vec![10_000, 1_000_000],
    };
    if arguments.sph {
        let middle = if sizes.len() > 1 { vec![sizes[0], 100_000, sizes[1]] } else { sizes };
        crate::speed::sph::print_table(
            &middle,
            arguments.seconds,
            &arguments.threads,
            arguments.filter.as_deref(),
        )?;
        return Ok(true);
    }
    let wanted =
        |setting: &BenchSetting| arguments.filter.as_deref().is_none_or(|f| setting.name().contains(f));
    let mut failed = if arguments.textbook {
        0
    } else {
        print_table(&sizes, arguments.seconds, &arguments.threads, wanted)
    };
    failed += print_textbook_table(&sizes, arguments.seconds, wanted);
    if let Some(memory) = peak_memory() {
        println!("# peak memory {memory:.0} MB");
    }
    if failed > 0 {
        println!("# {failed} settings failed");
    }
    Ok(failed == 0)
}

/// Prints a row of the table, or the failure of its setting. Returns the number of failures. Returns the number of failures.
fn print_row(setting: &BenchSetting, row: Result<String, String>) -> usize {
    match row {
        Ok(row) => {
            println!("{row}");
            0
        }
        Err(reason) => {
            println!("# {} failed: {reason}", setting.name());
            1
        }
    }
}

/// Prints the speeds of all settings, and returns the number of failures.
fn print_table(
    sizes: &[usize],
    seconds: f64,
    threads: &[usize],
    wanted: impl Fn(&BenchSetting) -> bool,
) -> usize {
    let mut failed = 0;
    println!("dimension,shape,stress_update,model,points,threads,million_updates_per_second");
    for dimension in [2, 3] {
        for shape in ["linear", "ugimp", "quadratic"] {
            for (scheme, model) in [
                ("usl", "linear-elastic"),
                ("musl", "linear-elastic"),
                ("usl", "drucker-prager"),
                ("usl", "mohr-coulomb"),
                ("usl", SATURATED_SOIL),
                ("musl", SATURATED_SOIL),
            ] {
                for &points in sizes {
                    for &threads in threads {
                        let setting = BenchSetting { dimension, shape, scheme, model, points, threads };
                        if !wanted(&setting) {
                            continue;
                        }
                        let row = setting.measure(seconds).map(|(points, rate)| {
                            format!("{dimension},{shape},{scheme},{model},{points},{threads},{rate:.3}")
                        });
                        failed += print_row(&setting, row);
                    }
                }
            }
        }
    }
    failed
}

/// Prints the speeds of this project's solver and of the textbook solver in the same program, and returns the number of failures.
fn print_textbook_table(sizes: &[usize], seconds: f64, wanted: impl Fn(&BenchSetting) -> bool) -> usize {
    let mut failed = 0;
    println!("# comparison with a textbook kernel: array of structs, plain loops, one thread");
    println!("dimension,shape,points,ours,textbook,ratio");
    let (scheme, model, threads) = ("usl", "linear-elastic", 1);
    for dimension in [2, 3] {
        for shape in ["linear", "quadratic"] {
            for &points in sizes {
                let setting = BenchSetting { dimension, shape, scheme, model, points, threads };
                if !wanted(&setting) {
                    continue;
                }
                let row = setting.measure_against_textbook(seconds).map(|(points, ours, textbook)| {
                    format!("{dimension},{shape},{points},{ours:.3},{textbook:.3},{:.2}", ours / textbook)
                });
                failed += print_row(&setting, row);
            }
        }
    }
    failed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that both solvers compute the same positions, without which a comparison of speed has no meaning.
    fn both_end_at_the_same_places<const D: usize>(points: usize) {
        let setting = BenchSetting {
            dimension: D,
            shape: "linear",
            scheme: "usl",
            model: "linear-elastic",
            points,
            threads: 1,
        };
        let (mut solver, mut textbook) = (setting.solver().unwrap(), setting.textbook::<D>());
        let dt = solver.limit().dt;
        for _ in 0..60 {
            // The critical step shrinks by a little as the block falls.
            textbook.step(solver.step(dt).unwrap().dt);
        }
        let ours = solver.snapshot().positions;
        assert_eq!(ours.len(), textbook.points.len());
        let settled = 0.5 * GRAVITY.abs() * solver.time().powi(2);
        for (x, point) in ours.iter().zip(&textbook.points) {
            for c in 0..D {
                // The two differ in the second order of the strain, which is about 2e-4 here.
                let apart = (x[c] - point.position[c]).abs();
                assert!(apart < 1e-3 * settled, "{D}D: {apart} m apart, settled by {settled} m");
            }
        }
    }

    #[test]
    fn the_textbook_kernel_agrees_with_the_solver() {
        both_end_at_the_same_places::<2>(400);
        both_end_at_the_same_places::<3>(1000);
    }
}
