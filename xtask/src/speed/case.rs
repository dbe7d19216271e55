//! `cargo xtask bench --case FILE`: point-updates per second of any case with any method, on several numbers of threads.

use std::path::Path;
use std::time::{Duration, Instant};

use colluvium::case::{Case, Solver};
use sysinfo::{Pid, ProcessRefreshKind, ProcessesToUpdate, System};

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

/// Measured speed: points at the end, counted steps, point-updates, their wall time (s) and their processor time (s).
struct CaseMeasurement {
    points: usize,
    steps: usize,
    updates: f64,
    seconds: f64,
    cpu_seconds: f64,
    end: EndState,
}

impl CaseMeasurement {
    /// Million point-updates per second of wall time.
    fn rate(&self) -> f64 {
        self.updates / self.seconds / 1e6
    }

    /// Million point-updates per second of processor time.
    fn cpu_rate(&self) -> f64 {
        self.updates / self.cpu_seconds / 1e6
    }
}

/// State after the measured steps, by which programs with the same case are compared.
struct EndState {
    /// Time (s).
    time: f64,
    /// Centre of mass, or of the volume, or the mean of the positions (m).
    centre: [f64; 3],
    /// Kinetic energy (J), not-a-number for methods that do not give it.
    kinetic: f64,
}

impl EndState {
    /// End state of a solver.
    fn of(solver: &dyn Solver) -> Self {
        let points = solver.snapshot();
        let weights = points.scalars("mass").or(points.scalars("volume"));
        let weight = |i: usize| weights.map_or(1.0, |weights| weights[i]);
        let whole: f64 = (0..points.positions.len()).map(weight).sum();
        let mean = |axis: usize| {
            points.positions.iter().enumerate().map(|(i, x)| weight(i) * x[axis]).sum::<f64>() / whole
        };
        Self { time: solver.time(), centre: [mean(0), mean(1), mean(2)], kinetic: solver.totals().kinetic }
    }
}

/// Processor time of this process so far, of all threads, in steps of about 10 ms; zero where the system does not report it.
fn processor_time() -> Duration {
    let id = Pid::from_u32(std::process::id());
    let mut system = System::new();
    system.refresh_processes_specifics(
        ProcessesToUpdate::Some(&[id]),
        false,
        ProcessRefreshKind::nothing().with_cpu(),
    );
    Duration::from_millis(system.process(id).map_or(0, sysinfo::Process::accumulated_cpu_time))
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
    let (start, cpu_start) = (Instant::now(), processor_time());
    let (mut points, mut count, mut updates, mut seconds) = (0, 0, 0.0, 0.0);
    while steps.map_or(seconds < settings.seconds, |largest| count < largest) {
        points = step()?;
        count += 1;
        updates += points as f64;
        seconds = start.elapsed().as_secs_f64();
    }
    let cpu_seconds = (processor_time() - cpu_start).as_secs_f64();
    let end = EndState::of(&*solver);
    Ok(CaseMeasurement { points, steps: count, updates, seconds, cpu_seconds, end })
}

/// Prints a row for each method and number of threads. All rows of a method have the same steps, so that their work is equal.
pub fn print_table(settings: &CaseBenchSettings) -> Result<(), String> {
    let case = Case::from_file(settings.file).map_err(|errors| errors.to_string())?;
    let methods: Vec<&str> = match settings.method {
        Some(name) => vec![name],
        None => case.methods.keys().map(String::as_str).collect(),
    };
    println!(
        "method,points,steps,threads,seconds,million_updates_per_second,times_the_first,cpu_seconds,\
         million_updates_per_cpu_second,time,centre_x,centre_y,centre_z,kinetic_energy"
    );
    for method in methods {
        let (mut steps, mut first) = (settings.steps, None);
        for &threads in settings.threads {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| e.to_string())?;
            let measured = pool.install(|| measure(&case, method, settings, steps))?;
            steps.get_or_insert(measured.steps);
            let first = *first.get_or_insert(measured.rate());
            let (rate, cpu_rate) = (measured.rate(), measured.cpu_rate());
            let CaseMeasurement { points, steps, seconds, cpu_seconds, end, .. } = measured;
            let EndState { time, centre: [x, y, z], kinetic } = end;
            println!(
                "{method},{points},{steps},{threads},{seconds:.3},{rate:.3},{:.2},{cpu_seconds:.2},{cpu_rate:.3},\
                 {time:.6e},{x:.9e},{y:.9e},{z:.9e},{kinetic:.6e}",
                rate / first
            );
        }
    }
    Ok(())
}
