//! One and two threads (sheet: sph B-06).

use std::time::Instant;

use colluvium::case::Solver;

use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, set_method_option};

/// Benchmark of equal results on one and two threads, and of the gain in time.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/threads",
    title: "One and two threads: the same bits in less time, SPH",
    source: "Bui & Nguyen 2021, Fig. 23; sheet: sph B-06",
    short_seconds: Some(2),
    full_seconds: 8,
    run,
};

/// Makes steps on a thread pool, and returns their time (s).
fn time_of_steps(pool: &rayon::ThreadPool, solver: &mut dyn Solver, steps: usize) -> Result<f64, String> {
    let start = Instant::now();
    pool.install(|| {
        for _ in 0..steps {
            let dt = solver.limit().dt;
            solver.step(dt).map_err(|error| error.to_string())?;
        }
        Ok(start.elapsed().as_secs_f64())
    })
}

/// Checks that one and two threads give bit-identical results, and measures both speeds.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let batches = if quick { 2 } else { 6 };
    let mut case = load_case("sph/threads")?;
    if !quick {
        // 50,176 particles.
        set_method_option(&mut case, "sph", "spacing", 1.0 / 224.0);
    }
    let method = colluvium::method("sph").ok_or("no method sph")?;
    let pool = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| error.to_string())
    };
    let pools = [pool(1)?, pool(2)?];
    let mut solvers = Vec::new();
    for pool in &pools {
        let mut solver = pool.install(|| method.build(&case)).map_err(|error| error.to_string())?;
        solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
        solvers.push(solver);
    }
    // In turns, so that other load on the machine affects both; the best time of each counts.
    let mut best = [f64::INFINITY; 2];
    for _ in 0..batches {
        for ((pool, solver), best) in pools.iter().zip(&mut solvers).zip(&mut best) {
            *best = best.min(time_of_steps(pool, &mut **solver, 20)?);
        }
    }
    let same = solvers[0].snapshot().hash() == solvers[1].snapshot().hash();
    let reason = "B-06: identical results";
    outcome.assert_within(
        "the same bits on one and two threads (1 is yes)",
        "yes",
        f64::from(u8::from(same)),
        (1.0, 1.0),
        reason,
    );
    let gain = best[0] / best[1];
    let name = "time on one thread over time on two, best of batches of 20 steps";
    let reason = "not judged: benchmarks run side by side here. `cargo xtask bench --sph` measures it alone; docs/performance.md \
                  keeps the numbers";
    outcome.info(name, "at least 1.7", gain, reason);
    outcome.info(
        "million particle-updates per second on one thread",
        "3 (aim)",
        solvers[0].point_count() as f64 * 20.0 / best[0] / 1e6,
        "not judged: depends on the machine",
    );
    Ok(outcome)
}
