//! Wall-clock time of the parts of a run, measured on its first steps.

use std::time::{Duration, Instant};

use crate::output::{WriteOptions, averages, write_frame};
use crate::run::output::measure_row;
use crate::{Case, FrameRequest, Plan, Solver};

/// Smallest number of measured steps after the first one, unless they exceed the time limit.
const MIN_STEPS: u32 = 3;

/// Longest expected time of a step on one thread (s) for which steps are measured. Material laws that are simulations of grains exceed it.
const LONGEST_STEP: f64 = 20.0;
/// Number of points from which frames and rows are estimated, since measuring them would double the memory of the points.
const MAX_MEASURED_POINTS: usize = 200_000;
/// Wall-clock time of a frame, for each point (s).
const FRAME_OF_POINT: f64 = 3e-6;
/// Wall-clock time of a row of measures, for each point (s).
const ROW_OF_POINT: f64 = 5e-7;
/// Memory of a frame with the contents of its file, for each point (bytes).
const FRAME_BYTES_OF_POINT: f64 = 250.0;

/// Memory of a frame with this number of points and of the contents of its file (bytes).
pub fn frame_memory(points: usize) -> f64 {
    FRAME_BYTES_OF_POINT * points as f64
}

/// Wall-clock time of the parts of a run (s), and its number of steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunTiming {
    /// Time of a step.
    pub step: f64,
    /// Time of a frame, including its file.
    pub frame: f64,
    /// Time of a row of the measures.
    pub row: f64,
    /// Steps of the whole run: those of the plan, increased by the shortening of the step during the measurement.
    pub steps: f64,
    /// Memory of a frame (bytes) where the measurement made none. A frame that it made is in the memory of the process already.
    pub frame_memory: f64,
}

impl RunTiming {
    /// Measures the wall time of steps, frames and rows with a solver at time zero, for at most the time `may`. The solver is of no further
    /// use. `None` where no step is possible or a step would take too long.
    pub fn measure(case: &Case, plan: &Plan, solver: &mut dyn Solver, may: Duration) -> Option<Self> {
        if plan.seconds() > LONGEST_STEP * plan.steps as f64 {
            return None;
        }
        // Runs on a thread of the pool: from any other thread each loop of a step would wake a thread of the pool and wait for it.
        rayon::scope(|_| {
            let steps = MeasuredSteps::measure(case, solver, may)?;
            // Moved points take longer to compress.
            let points = solver.point_count() as f64;
            let [frame, row, frame_memory] = match solver.point_count() {
                MAX_MEASURED_POINTS.. => {
                    [FRAME_OF_POINT, ROW_OF_POINT, FRAME_BYTES_OF_POINT].map(|each| points * each)
                }
                _ => [frame(case, solver), row(case, solver), 0.0],
            };
            let left = 1.0 - steps.end_time / case.end_time();
            let shorter = (plan.time_step.dt / steps.dt).max(1.0);
            let whole = f64::from(steps.count) + left * plan.steps as f64 * shorter;
            Some(Self { step: steps.mean, frame, row, steps: whole, frame_memory })
        })
    }

    /// Time of a run without its searches for factors of safety (s).
    pub fn run_time(&self, case: &Case) -> f64 {
        let outputs = |interval: Option<f64>, others: f64| {
            interval.map_or(others, |interval| (case.end_time() / interval).floor() + 1.0)
        };
        let (frames, rows) = (outputs(case.output.frames, 2.0), outputs(case.output.measures, 100.0));
        self.steps * self.step + frames * self.frame + rows * self.row
    }
}

/// Measurement of the first steps of a run.
struct MeasuredSteps {
    count: u32,
    /// Time after these steps (s).
    end_time: f64,
    /// Bound on the next step (s).
    dt: f64,
    /// Mean wall-clock time of a step (s), without the first one, which builds lists and buffers.
    mean: f64,
}

impl MeasuredSteps {
    /// Measures the wall time of steps at the start of a run, for at most the duration `may`.
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
        Some(Self { count: count + 1, end_time: solver.time(), dt: solver.limit().dt, mean })
    }
}

/// Time of a frame of points with its file and its averages on a grid (s); zero where no file can be made.
fn frame(case: &Case, solver: &dyn Solver) -> f64 {
    let begun = Instant::now();
    let Some(points) = solver.frame(FrameRequest::Requested).take_points() else {
        return begun.elapsed().as_secs_f64();
    };
    if let Some(cell) = case.output.grid {
        std::hint::black_box(averages(case, cell, &points, case.output.fields.as_deref()));
    }
    let written =
        WriteOptions { field_names: case.output.fields.as_deref(), compression: case.output.compression };
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
