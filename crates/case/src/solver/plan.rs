//! Size of a problem and plan of its solution.

use super::TimeStep;
use crate::CaseErrorKind;
use crate::{Case, CaseError, Resolution};
use colluvium_constitutive::Warning;

/// Approximate size of a problem, before its points are generated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProblemSize {
    /// Number of points, including those of walls.
    pub points: f64,
    /// Number of grid nodes.
    pub nodes: f64,
    /// Least memory (bytes).
    pub memory: f64,
    /// Key of the case that determines the size: the cell size, a spacing, or grains.
    pub case_key: &'static str,
    /// Time to place the points (s), where it exceeds the time to write them.
    pub placing_time: f64,
    /// Advice for a problem that does not fit in memory; “make it larger” when empty.
    pub advice: &'static str,
}

/// Time to place points (s) above which it is reported in advance.
const LONG_PLACING_TIME: f64 = 5.0;

/// Memory of a node of `output.grid` (bytes).
const BYTES_OF_GRID_NODE: f64 = 320.0;
/// Memory of the mass of a point at a node of `output.grid` (bytes).
const BYTES_OF_SHARE: f64 = 24.0;

/// Duration (s) as text.
fn duration_text(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "a second".to_owned(),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

impl ProblemSize {
    /// Notice before the points are generated, with their number, time and memory. `None` where that takes little time.
    pub fn size_notice(&self) -> Option<Warning> {
        (self.placing_time >= LONG_PLACING_TIME).then(|| {
            Warning::new(
                "large-problem",
                format!(
                    "{}: about {:.1e} points will be placed. This takes about {} and at least {:.2} GB of \
                 memory. If that is not intended, make the key larger",
                    self.case_key,
                    self.points,
                    duration_text(self.placing_time),
                    self.memory / 1e9
                ),
            )
        })
    }

    /// Rejects a problem that does not fit in the available memory (bytes).
    ///
    /// # Errors
    /// The number of points and their memory, at the key that determines it.
    pub fn check_memory(&self, available: f64) -> Result<(), CaseError> {
        // The comparison rejects NaN.
        if self.memory <= available {
            return Ok(());
        }
        let cure = if self.advice.is_empty() { "make it larger" } else { self.advice };
        if !self.memory.is_finite() {
            let problem = format!("gives more points or nodes than can be counted: {cure}");
            return Err(CaseError::new(self.case_key, CaseErrorKind::coded("not-enough-memory", problem)));
        }
        let nodes =
            if self.nodes > 0.0 { format!(" and {:.1e} grid nodes", self.nodes) } else { String::new() };
        let problem = format!(
            "gives about {:.1e} points{nodes}, which need at least {:.1} GB of memory; {:.1} GB are free: {cure}",
            self.points,
            self.memory / 1e9,
            available / 1e9
        );
        Err(CaseError::new(self.case_key, CaseErrorKind::coded("not-enough-memory", problem)))
    }
}

/// Plan of a solution, for `check` and for the progress bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Number of points.
    pub points: usize,
    /// Number of grid nodes; zero for methods without a grid.
    pub nodes: usize,
    /// Estimated number of steps over all stages.
    pub steps: u64,
    /// First time step with its limit.
    pub time_step: TimeStep,
    /// Estimated memory (bytes): points with their states, nodes, mesh or neighbours, and buffers of sorting.
    pub memory: u64,
    /// Initial volume of the points of each body, including rigid ones (m³; m² × 1 m in plane strain, per radian in axisymmetry).
    pub volumes: Vec<f64>,
    /// Mass of the grains of each body (kg; per metre in plane strain), for a method with grains and voids.
    pub grains: Option<Vec<f64>>,
    /// Density of each body (kg/m³) where options of the method determine it, as for a mixture of phases.
    pub densities: Option<Vec<f64>>,
    /// Cell size or spacing relative to the bodies; `None` for methods without cells or spacings.
    pub resolution: Option<Resolution>,
    /// Expected point updates per second and thread, from this project's benchmarks.
    pub updates_per_second: f64,
    /// Warnings, for example about cells with few points or a Poisson's ratio near 0.5.
    pub warnings: Vec<Warning>,
}

impl Plan {
    /// Plan with the notes of ignored features and the costs of the laws. An error for a case that cannot end.
    pub(super) fn complete(
        mut self,
        case: &Case,
        notes: Vec<Warning>,
        has_laws: bool,
    ) -> Result<Self, CaseError> {
        self.check_progress(case)?;
        self.has_points(case)?;
        self.count_output(case);
        if has_laws {
            self.count_laws(case);
        }
        self.warnings.extend(notes);
        Ok(self)
    }

    /// Rejects a case with a body that has no points.
    fn has_points(&self, case: &Case) -> Result<(), CaseError> {
        let empty = self.volumes.iter().position(|volume| *volume <= 0.0).filter(|_| self.grains.is_none());
        let Some(body) = empty.filter(|body| *body < case.bodies.len()) else { return Ok(()) };
        let problem = "the body has no points: it lies under the ground, inside an obstacle or between the \
                       points. Move it, make it larger, or use smaller cells or spacings";
        Err(CaseError::new(format!("bodies[{body}].shape"), CaseErrorKind::coded("empty-body", problem)))
    }

    /// Rejects a case without motion, and a case whose end cannot be reached by its steps.
    fn check_progress(&self, case: &Case) -> Result<(), CaseError> {
        let TimeStep { dt, limit, .. } = self.time_step;
        if dt == f64::INFINITY {
            let loose = case.bodies.iter().any(|body| case.moves_freely(&body.name));
            let problem = if loose {
                CaseErrorKind::coded(
                    "nothing-moves",
                    "all bodies are rigid, so no limit of the time step exists: give the method a `time_step`",
                )
            } else {
                CaseErrorKind::coded(
                    "nothing-moves",
                    "nothing in the case can move, because all bodies are rigid: there is no time step",
                )
            };
            return Err(CaseError::new("bodies", problem));
        }
        let end = case.end_time();
        if !(dt > 0.0) || self.time_step.is_below_precision(end) {
            let problem = format!(
                "the time step, {dt:.3e} s, limited by: {limit}, is below the precision of the time: the end \
                 at {end} s is more than 2^53 steps away. Check stiffness, density and sizes"
            );
            return Err(CaseError::new("stages", problem));
        }
        Ok(())
    }

    /// Adds the steps shortened by outputs, and the memory of a frame on a grid.
    fn count_output(&mut self, case: &Case) {
        let (end, dt) = (case.end_time(), self.time_step.dt);
        for interval in case.output.frames.into_iter().chain(case.output.measures) {
            let steps = end / interval * (interval / dt - 1e-9).ceil().max(1.0);
            self.steps = self.steps.max(steps.ceil() as u64);
        }
        if let Some(cell) = case.output.grid {
            let nodes = case.grid_nodes(cell) * BYTES_OF_GRID_NODE;
            let shares = (self.points << case.dimension()) as f64 * BYTES_OF_SHARE;
            self.memory += (nodes + shares) as u64;
        }
    }

    /// Reduces the updates per second by the least cost of the laws, and adds a note for each body.
    fn count_laws(&mut self, case: &Case) {
        let whole: f64 = self.volumes.iter().sum();
        let mut seconds = 0.0;
        for (body, volume) in case.bodies.iter().zip(&self.volumes).filter(|(body, _)| !body.rigid) {
            let law = case.materials.get(&body.material).and_then(|spec| spec.build().ok());
            let Some(cost) = law.and_then(|law| law.update_cost()) else { continue };
            let share = volume / whole;
            seconds += share * cost.update;
            let points = (share * self.points as f64).round();
            self.warnings.push(Warning::new(
                "slow-law",
                format!(
                    "materials.{}: an update of a point takes about {:.2} ms on one thread, and one with a \
                 strain of 1e-4 takes {:.2} ms. The run takes at least {} for the {points} points of the \
                 body {:?} and {} steps. Use fewer points if that is too long",
                    body.material,
                    1e3 * cost.update,
                    1e3 * (1e-4 * cost.strain).max(cost.update),
                    duration_text(points * self.steps as f64 * cost.update),
                    body.name,
                    self.steps
                ),
            ));
        }
        if seconds > 0.0 {
            self.updates_per_second = 1.0 / (1.0 / self.updates_per_second + seconds);
        }
    }

    /// Estimated wall-clock time on one thread (s).
    pub fn seconds(&self) -> f64 {
        self.points as f64 * self.steps as f64 / self.updates_per_second
    }
}
