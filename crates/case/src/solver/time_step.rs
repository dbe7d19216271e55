//! Time steps and their limits.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use colluvium_constitutive::Warning;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use thiserror::Error;

/// Criterion that limits a time step, as a short text that the method gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepLimit(&'static str);

impl StepLimit {
    /// Travel time of an elastic wave across a cell or a smoothing length limits the step.
    pub const ELASTIC_WAVE: Self = Self::new("elastic wave");
    /// Diffusion of momentum by viscosity limits the step.
    pub const VISCOSITY: Self = Self::new("viscosity");
    /// Displacement of a point by its acceleration limits the step.
    pub const ACCELERATION: Self = Self::new("acceleration");
    /// Viscous damping limits the step.
    pub const DAMPING: Self = Self::new("damping");
    /// Drag between skeleton and pore fluid limits the step.
    pub const SEEPAGE_DRAG: Self = Self::new("seepage drag");
    /// The case prescribes the step.
    pub const FIXED_STEP: Self = Self::new("fixed by the case");
    /// Nothing moves, and the step is not limited.
    pub const NO_MOTION: Self = Self::new("nothing");

    /// Criterion with this name.
    #[must_use]
    pub const fn new(name: &'static str) -> Self {
        Self(name)
    }
}

impl std::fmt::Display for StepLimit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0)
    }
}

impl Serialize for StepLimit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0)
    }
}

impl<'de> Deserialize<'de> for StepLimit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self(static_name(String::deserialize(deserializer)?)))
    }
}

/// Text with static lifetime. A checkpoint contains only a few of them.
fn static_name(name: String) -> &'static str {
    static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = names.get(name.as_str()) {
        return known;
    }
    let kept: &'static str = Box::leak(name.into_boxed_str());
    names.insert(kept);
    kept
}

/// Result of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advance {
    /// Increment of time (s), or of the load factor of a static solver.
    pub dt: f64,
    /// Criterion that limited the step.
    pub limit: StepLimit,
}

/// Stable time step with the criterion that limits it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeStep {
    /// Time step (s).
    pub dt: f64,
    /// Criterion that limits the step.
    pub limit: StepLimit,
    /// Id of the limiting point, if a point limits it.
    pub point: Option<u64>,
    /// Position of that point (m).
    pub position: [f64; 3],
}

impl TimeStep {
    /// Share of the first step of a run below which a step leads to a warning.
    const COLLAPSE_RATIO: f64 = 1e-3;

    /// Warning about a step at `time` (s) that has become a small part of the `first` one (s), so that the run hardly advances.
    #[must_use]
    pub fn collapse(&self, first: f64, time: f64) -> Option<Warning> {
        let Self { dt, limit, point, position } = self;
        let place = point.map_or_else(String::new, |point| format!(" of point {point} at {position:?} m"));
        (*dt < Self::COLLAPSE_RATIO * first).then(|| {
            Warning::new(
                "time-step-collapse",
                format!(
                    "t = {time} s: the time step has fallen to {dt:.3e} s from {first:.3e} s at the start, \
                 limited by: {limit}{place}. If the step stays so small, the run hardly advances. Check the \
                 deformation and the velocity there"
                ),
            )
        })
    }

    /// Whether the step is below double precision at a time (s): it is less than a 2⁻⁵³ part of it.
    #[must_use]
    pub fn is_below_precision(&self, time: f64) -> bool {
        self.dt > 0.0 && self.dt < 0.5 * f64::EPSILON * time
    }

    /// Step of an explicit method that has the time `at_most` (s) left: at most this one. The last two steps before the end are equal, so
    /// that none is tiny.
    #[must_use]
    pub fn limited_to(&self, at_most: f64) -> f64 {
        if at_most <= self.dt * (1.0 + 1e-9) {
            at_most
        } else if at_most < 2.0 * self.dt * (1.0 - 1e-9) {
            0.5 * at_most
        } else {
            self.dt
        }
    }

    /// Fixed step of the case, where it has one that this critical step allows; else this step.
    #[must_use]
    pub fn or_fixed(self, fixed: Option<f64>) -> Self {
        match fixed {
            Some(dt) if dt <= self.dt => {
                Self { dt, limit: StepLimit::FIXED_STEP, point: None, position: [0.0; 3] }
            }
            _ => self,
        }
    }

    /// Error text for a fixed step of the case (s) that exceeds this critical step.
    #[must_use]
    pub fn fixed_step_problem(&self, fixed: Option<f64>) -> Option<String> {
        let Self { dt, limit, .. } = self;
        fixed.filter(|fixed| fixed > dt).map(|fixed| {
            format!(
                "{fixed} s is larger than the critical step {dt:.4e} s, limited by: {limit} (make it \
                 smaller, or leave it out for steps that adapt to the state)"
            )
        })
    }
}

/// Time step with which a solver cannot advance.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TimeStepError {
    /// No limit of the time step, because no material is left that moves.
    #[error(
        "stage {stage:?}, t = {time} s: no material is left that moves: all bodies are removed, are rigid \
         or have left the domain"
    )]
    NoMotion {
        /// Name of the stage.
        stage: String,
        /// Time (s).
        time: f64,
    },
    /// Time step below the precision of the time in double precision.
    #[error(
        "t = {time} s: a step of {dt:.3e} s, limited by: {limit}, is below the precision of the time: the \
         end at {end} s is more than 2^53 steps away. The run cannot advance. Check stiffness, density and \
         sizes"
    )]
    TooSmall {
        /// Time (s).
        time: f64,
        /// Time step (s).
        dt: f64,
        /// Limit of the time step.
        limit: StepLimit,
        /// End of the stage (s).
        end: f64,
    },
    /// Time step that is not positive, or not a number.
    #[error("t = {time} s: no stable time step (found {dt} s, limited by: {limit})")]
    Unstable {
        /// Time (s).
        time: f64,
        /// Time step of the solver (s).
        dt: f64,
        /// Limit of the time step.
        limit: StepLimit,
    },
}

impl TimeStepError {
    /// Stable code of the error.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::NoMotion { .. } => "nothing-moves",
            Self::TooSmall { .. } => "time-step-too-small",
            Self::Unstable { .. } => "no-stable-step",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_two_steps_before_an_output_are_equal() {
        let limit = TimeStep { dt: 1.0, limit: StepLimit::NO_MOTION, point: None, position: [0.0; 3] };
        for (rest, step) in
            [(0.3, 0.3), (1.0, 1.0), (1.0 + 1e-10, 1.0 + 1e-10), (1.5, 0.75), (2.0, 1.0), (7.3, 1.0)]
        {
            assert_eq!(limit.limited_to(rest), step, "{rest}");
        }
    }

    #[test]
    fn limits_keep_their_names_in_a_checkpoint() {
        let bytes = postcard::to_stdvec(&StepLimit::new("contact")).unwrap();
        let limit: StepLimit = postcard::from_bytes(&bytes).unwrap();
        assert_eq!((limit, limit.to_string().as_str()), (StepLimit::new("contact"), "contact"));
    }
}
