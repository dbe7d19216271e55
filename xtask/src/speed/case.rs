//! `cargo xtask bench --case FILE`: point-updates per second of any case with any method, on several numbers of threads.

use std::path::Path;
use std::time::Instant;

use colluvium::case::Case;

/// Settings of the measurement of a case.
pub struct CaseBenchSettings<'a> {
    /// Case file.
    pub file: &'a Path,
    /// Name of the measured method; `None` for all methods of the case.
    pub method: Option<&'a str>,
    /// Numbers of threads, each measured after the other.
    pub threads: &'a [usize],
    /// Number of steps before the measurement.
    pub warm_up_steps: usize,
    /// Number of measured steps; when absent, as many as the first number of threads makes in `seconds`.
    pub steps: Option<usize>,
    /// Duration of a measurement (s).
    pub seconds: f64,
}

/// Measured speed: points at the end, counted steps, point-updates and their time (s).
struct CaseMeasurement {
    points: usize,
    steps: usize,
    updates: f64,
    seconds: f64,
}

impl CaseMeasurement {
    /// Million point-updates per second.
    fn rate(&self) -> f64 {
        self.updates / self.seconds / 1e6
    }
}

/// Runs a case from its start and measures steps of its first stage: `steps` of them, or as many as fit in `seconds`.
fn measure(
    case: &Case,
    method: &str,
    settings: &CaseBenchSettings,
    steps: Option<usize>,
) -> Result<CaseMeasurement, String> {
    let method = colluvium::method(method).ok_or_else(|| format!("there is no method {method}"))?;
    let mut solver = method.build(case).map_err(|errors| errors.to_string())?;
    solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
    let mut step = || -> Result<usize, String> {
        let dt = solver.limit().dt;
        solver.step(dt).map_err(|error| error.to_string())?;
        Ok(solver.point_count())
    };
    for _ in 0..settings.warm_up_steps {
        step()?;
    }
    let start = Instant::now();
    let mut measured = CaseMeasurement { points: 0, steps: 0, updates: 0.0, seconds: 0.0 };
    while steps.map_or(measured.seconds < settings.seconds, |largest| measured.steps < largest) {
        measured.points = step()?;
        measured.steps += 1;
        measured.updates += measured.points as f64;
        measured.seconds = start.elapsed().as_secs_f64();
    }
    Ok(measured)
}

/// Prints a row for each method and number of threads. All rows of a method have the same steps, so that their work is equal.
pub fn print_table(settings: &CaseBenchSettings) -> Result<(), String> {
    let case = Case::from_file(settings.file).map_err(|errors| errors.to_string())?;
    let methods: Vec<&str> = match settings.method {
        Some(name) => vec![name],
        None => case.methods.keys().map(String::as_str).collect(),
    };
    println!("method,points,steps,threads,seconds,million_updates_per_second,times_the_first");
    for method in methods {
        let (mut steps, mut first) = (settings.steps, None);
        for &threads in settings.threads {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| e.to_string())?;
            let measured = pool.install(|| measure(&case, method, settings, steps))?;
            steps.get_or_insert(measured.steps);
            let first = *first.get_or_insert(measured.rate());
            let CaseMeasurement { points, steps, seconds, .. } = measured;
            let rate = measured.rate();
            println!("{method},{points},{steps},{threads},{seconds:.3},{rate:.3},{:.2}", rate / first);
        }
    }
    Ok(())
}
