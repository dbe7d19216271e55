//! How large a problem is.

use super::TimeStep;
use crate::{Case, CaseError};

/// About how large a problem is, known before any of it is made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Size {
    /// Number of points.
    pub points: f64,
    /// Number of grid nodes.
    pub nodes: f64,
    /// The memory that is needed at least (bytes).
    pub memory: f64,
    /// Key of the case that it follows from: the size of cells, or a spacing.
    pub key: &'static str,
}

impl Size {
    /// Refuses a problem that does not fit in the memory that is there (bytes).
    ///
    /// # Errors
    /// With the number of points and what they need, at the key that it follows from.
    pub fn fit(&self, available: f64) -> Result<(), CaseError> {
        // What is no number fits nowhere.
        if self.memory <= available {
            return Ok(());
        }
        if !self.memory.is_finite() {
            let problem = "gives more points or nodes than can be counted: make it larger";
            return Err(CaseError::new(self.key, problem));
        }
        let nodes =
            if self.nodes > 0.0 { format!(" and {:.1e} grid nodes", self.nodes) } else { String::new() };
        let problem = format!(
            "gives about {:.1e} points{nodes}, which need at least {:.1} GB of memory; {:.1} GB are free: make it larger",
            self.points,
            self.memory / 1e9,
            available / 1e9
        );
        Err(CaseError::new(self.key, problem))
    }
}

/// The size of a problem, for `check` and for the progress bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Number of points.
    pub points: usize,
    /// Number of grid nodes; zero for methods without a grid.
    pub nodes: usize,
    /// Estimated number of steps over all stages.
    pub steps: u64,
    /// First time step and what limits it.
    pub time_step: TimeStep,
    /// Estimated memory (bytes): points with the states of their laws, nodes, mesh or neighbours, and what sorting takes.
    pub memory: u64,
    /// Volume of the points of each body at the start (m³; m² × 1 m in plane strain, per radian in axisymmetry), rigid ones
    /// included.
    pub volumes: Vec<f64>,
    /// Point-updates per second to expect per thread, from this project's benchmarks.
    pub updates_per_second: f64,
    /// Warnings worth showing: under-sampled cells, a Poisson ratio near 0.5, …
    pub warnings: Vec<String>,
}

impl Plan {
    /// Refuses a case in which nothing moves, and one whose end steps do not lead to.
    pub(super) fn goes_on(&self, case: &Case) -> Result<(), CaseError> {
        let TimeStep { dt, limit, .. } = self.time_step;
        if dt == f64::INFINITY {
            let problem = "nothing in the case can move, all bodies are rigid: there is no time step";
            return Err(CaseError::new("bodies", problem));
        }
        let end = case.end_time();
        if !(dt > 0.0) || self.time_step.is_lost_in(end) {
            let problem = format!(
                "the time step, {dt:.3e} s, limited by: {limit}, is lost beside the end at {end} s, more than 2^53 steps away: look at \
                 stiffness, density and sizes"
            );
            return Err(CaseError::new("stages", problem));
        }
        Ok(())
    }

    /// Estimated wall-clock time on one thread (s).
    pub fn seconds(&self) -> f64 {
        self.points as f64 * self.steps as f64 / self.updates_per_second
    }
}
