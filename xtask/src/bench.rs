//! `cargo xtask bench`: point-updates per second of the material point method.

use std::time::Instant;

use clap::Args;
use colluvium::case::Case;
use serde_json::json;

#[derive(Args)]
pub struct Arguments {
    /// Only settings whose name contains this.
    filter: Option<String>,
    /// Leave out the runs with a million points.
    #[arg(long)]
    small: bool,
    /// Measure the bandwidth of memory as well (takes 0.8 GB).
    #[arg(long)]
    bandwidth: bool,
    /// Seconds of measurement per setting.
    #[arg(long, default_value_t = 2.0)]
    seconds: f64,
}

/// What is measured.
struct Setting {
    dimension: usize,
    shape: &'static str,
    scheme: &'static str,
    model: &'static str,
    points: usize,
    threads: usize,
}

impl Setting {
    fn name(&self) -> String {
        let Self { dimension, shape, scheme, model, points, threads } = self;
        format!("{dimension}d,{shape},{scheme},{model},{points},{threads}")
    }

    /// A block that rests on the floor of its box and settles under a little gravity: two points per cell and
    /// direction.
    fn case(&self) -> Result<Case, String> {
        let dimension = self.dimension as f64;
        let cells = ((self.points as f64).powf(1.0 / dimension) / 2.0).round().max(2.0);
        let cell = 1.0 / cells;
        let all = |value: f64| vec![value; self.dimension];
        let mut gravity = all(0.0);
        // Small loads keep the block in place while it is measured.
        gravity[1] = -0.1;
        let mut floor = all(-4.0 * cell);
        floor[1] = 0.0;
        let mut material =
            json!({ "model": self.model, "density": 2000.0, "youngs_modulus": 1e6, "poissons_ratio": 0.3 });
        if self.model != "linear-elastic" {
            // Weak enough that the block yields under its weight.
            material["friction_angle"] = json!(20.0);
            material["cohesion"] = json!(0.1);
        }
        let text = json!({
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
        Case::from_json(&text.to_string()).map_err(|errors| errors.to_string())
    }

    /// Million point-updates per second.
    fn measure(&self, seconds: f64) -> Result<(usize, f64), String> {
        let case = self.case()?;
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(self.threads).build().map_err(|e| e.to_string())?;
        pool.install(|| {
            let method = colluvium::method("mpm").ok_or("no method mpm")?;
            let mut solver = method.build(&case).map_err(|error| error.to_string())?;
            solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
            let mut step = |count: usize| {
                for _ in 0..count {
                    let dt = solver.time_step().dt;
                    solver.step(dt).map_err(|error| error.to_string())?;
                }
                Ok::<usize, String>(solver.points())
            };
            let points = step(3)?;
            let batch = (100_000 / points).clamp(1, 20);
            let (mut steps, start) = (0, Instant::now());
            while start.elapsed().as_secs_f64() < seconds && steps < 2000 {
                step(batch)?;
                steps += batch;
            }
            Ok((points, (points * steps) as f64 / start.elapsed().as_secs_f64() / 1e6))
        })
    }
}

/// Memory bandwidth (GB/s) of `a = b + s c` over arrays far larger than the caches.
fn bandwidth(threads: usize) -> Result<f64, String> {
    use rayon::prelude::*;
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

/// Largest memory this process has held so far (MB), where the system tells.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().trim_end_matches(" kB").parse().ok()?;
    Some(kilobytes / 1e3)
}

/// Measures and prints a table in CSV.
pub fn run(arguments: &Arguments) -> Result<bool, String> {
    for threads in [1, 2].into_iter().filter(|_| arguments.bandwidth) {
        println!("# memory bandwidth on {threads} threads: {:.1} GB/s", bandwidth(threads)?);
    }
    println!("# million point-updates per second of wall-clock time");
    println!("dimension,shape,stress_update,model,points,threads,million_updates_per_second");
    let sizes: &[usize] = if arguments.small { &[10_000] } else { &[10_000, 1_000_000] };
    for dimension in [2, 3] {
        for shape in ["linear", "ugimp", "quadratic"] {
            for (scheme, model) in [
                ("usl", "linear-elastic"),
                ("musl", "linear-elastic"),
                ("usl", "drucker-prager"),
                ("usl", "mohr-coulomb"),
            ] {
                for &points in sizes {
                    for threads in [1, 2] {
                        let setting = Setting { dimension, shape, scheme, model, points, threads };
                        if arguments.filter.as_deref().is_some_and(|f| !setting.name().contains(f)) {
                            continue;
                        }
                        let (points, rate) = setting.measure(arguments.seconds)?;
                        println!("{dimension},{shape},{scheme},{model},{points},{threads},{rate:.3}");
                    }
                }
            }
        }
    }
    if let Some(memory) = peak_memory() {
        println!("# peak memory {memory:.0} MB");
    }
    Ok(true)
}
