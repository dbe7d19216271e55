//! Wall-clock time of the parts of a run, measured on its first steps.

use std::time::{Duration, Instant};

use crate::output::{WriteOptions, averages, write_frame};
use crate::run::output::measure_row;
use crate::{Case, FrameRequest, Plan, Solver};

/// Fewest steps that are measured beside the first, unless they take longer than what they may.
const MIN_STEPS: u32 = 3;

/// Time of a step on one thread (s), as the plan expects it, above which none is made: of laws that are models of their own.
const LONGEST_STEP: f64 = 20.0;
/// Points from which on frames and rows are estimated: they would take the memory of the points once more.
const MAX_MEASURED_POINTS: usize = 200_000;
/// Time of a frame for each of them (s), and of a row.
const FRAME_OF_POINT: f64 = 3e-6;
const ROW_OF_POINT: f64 = 5e-7;
/// Memory of a frame for each of them, with what is made of it for its file (bytes).
const FRAME_BYTES_OF_POINT: f64 = 250.0;

/// Memory of a frame of so many points (bytes), with what is made of it for its file.
pub fn frame_memory(points: usize) -> f64 {
    FRAME_BYTES_OF_POINT * points as f64
}

/// Wall-clock time of the parts of a run (s), and how many steps it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunTiming {
    /// A step.
    pub step: f64,
    /// A frame, with its file.
    pub frame: f64,
    /// A row of the measures.
    pub row: f64,
    /// Steps of the whole run: those of the plan, as much shorter as they were when the measurement ended.
    pub steps: f64,
    /// Memory of a frame (bytes) where none was made: one that was counts in that of the process.
    pub frame_memory: f64,
}

impl RunTiming {
    /// That of a solver at time zero, which steps on in the first stage for a time that it `may` take, and is of no further use. `None`
    /// where no step can be done, as the run will say, and where one would take too long.
    pub fn measure(case: &Case, plan: &Plan, solver: &mut dyn Solver, may: Duration) -> Option<Self> {
        if plan.seconds() > LONGEST_STEP * plan.steps as f64 {
            return None;
        }
        // On a thread of the pool: each loop of a step would wake one, and wait for it, from any other.
        rayon::scope(|_| {
            let steps = MeasuredSteps::measure(case, solver, may)?;
            // Points that have moved are more work to compress.
            let points = solver.points() as f64;
            let [frame, row, frame_memory] = match solver.points() {
                MAX_MEASURED_POINTS.. => {
                    [FRAME_OF_POINT, ROW_OF_POINT, FRAME_BYTES_OF_POINT].map(|each| points * each)
                }
                _ => [frame(case, solver), row(case, solver), 0.0],
            };
            let left = 1.0 - steps.until / case.end_time();
            let shorter = (plan.time_step.dt / steps.dt).max(1.0);
            let whole = f64::from(steps.count) + left * plan.steps as f64 * shorter;
            Some(Self { step: steps.mean, frame, row, steps: whole, frame_memory })
        })
    }

    /// Time of a run, without its searches for factors of safety (s).
    pub fn run_time(&self, case: &Case) -> f64 {
        let outputs = |interval: Option<f64>, others: f64| {
            interval.map_or(others, |interval| (case.end_time() / interval).floor() + 1.0)
        };
        let (frames, rows) = (outputs(case.output.frames, 2.0), outputs(case.output.measures, 100.0));
        self.steps * self.step + frames * self.frame + rows * self.row
    }
}

/// The first steps of a run.
struct MeasuredSteps {
    count: u32,
    /// Time that they have come to (s).
    until: f64,
    /// Bound on the next one (s).
    dt: f64,
    /// Mean wall-clock time of those after the first, which makes lists and buffers (s).
    mean: f64,
}

impl MeasuredSteps {
    fn measure(case: &Case, solver: &mut dyn Solver, may: Duration) -> Option<Self> {
        solver.begin_stage(0, 0.0).ok()?;
        let end = case.stages.first()?.duration;
        let interval = case.output.frames.into_iter().chain(case.output.measures).fold(end, f64::min);
        let one = |solver: &mut dyn Solver| {
            let dt = solver.limit().dt.min(interval);
            let goes_on = dt > 0.0 && dt.is_finite() && solver.time() + dt < end;
            if goes_on { solver.step(dt).ok() } else { None }
        };
        let begun = Instant::now();
        one(solver)?;
        let first = begun.elapsed();
        let (begun, mut count) = (Instant::now(), 0);
        while (begun.elapsed() < may || count < MIN_STEPS)
            && begun.elapsed() < 10 * may
            && one(solver).is_some()
        {
            count += 1;
        }
        let mean =
            if count > 0 { begun.elapsed().as_secs_f64() / f64::from(count) } else { first.as_secs_f64() };
        Some(Self { count: count + 1, until: solver.time(), dt: solver.limit().dt, mean })
    }
}

/// Time of a frame of points with its file, and of its averages on a grid (s); zero where no file can be made.
fn frame(case: &Case, solver: &dyn Solver) -> f64 {
    let begun = Instant::now();
    let Some(points) = solver.frame(FrameRequest::Written).take_points() else {
        return begun.elapsed().as_secs_f64();
    };
    if let Some(cell) = case.output.grid {
        std::hint::black_box(averages(case, cell, &points, case.output.fields.as_deref()));
    }
    let written = WriteOptions { only: case.output.fields.as_deref(), compression: case.output.compression };
    let file = tempfile::tempdir().map(|folder| {
        let _ = write_frame(&folder.path().join("frame.vtu"), &points, [0.0; 3], written);
    });
    if file.is_ok() { begun.elapsed().as_secs_f64() } else { 0.0 }
}

/// Time of a row of the measures (s).
fn row(case: &Case, solver: &dyn Solver) -> f64 {
    let begun = Instant::now();
    let mut now = solver.frame(FrameRequest::Measured);
    let points = now.take_points();
    let points = points.or_else(|| now.first_as_points()).unwrap_or_default();
    std::hint::black_box((
        measure_row::run_outputs(solver, None),
        measure_row::case_outputs(case, solver, &points),
    ));
    begun.elapsed().as_secs_f64()
}
