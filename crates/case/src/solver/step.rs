//! Time steps.

use serde::{Deserialize, Serialize};

/// What limits a time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum StepLimit {
    /// A wave crosses a cell, or a smoothing length.
    ElasticWave,
    /// Momentum diffuses by a viscosity.
    Viscosity,
    /// A force moves a point.
    Acceleration,
    /// Viscous damping.
    Damping,
    /// The drag between skeleton and pore fluid.
    SeepageDrag,
    /// The case fixes the step.
    Fixed,
    /// There is nothing that moves.
    Nothing,
}

impl std::fmt::Display for StepLimit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::ElasticWave => "elastic wave",
            Self::Viscosity => "viscosity",
            Self::Acceleration => "acceleration",
            Self::Damping => "damping",
            Self::SeepageDrag => "seepage drag",
            Self::Fixed => "fixed by the case",
            Self::Nothing => "nothing",
        })
    }
}

/// A stable time step and its reason.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeStep {
    /// The step (s).
    pub dt: f64,
    /// What limits it.
    pub limit: StepLimit,
    /// Id of the limiting point, if a point limits it.
    pub point: Option<u64>,
    /// Where that point is (m).
    pub position: [f64; 3],
}

impl TimeStep {
    /// A step of less than this share of the first one of a run is worth a word.
    const COLLAPSED: f64 = 1e-3;

    /// What to say of a step at `time` (s) that has become a small part of the `first` one (s): a run that hardly goes on.
    #[must_use]
    pub fn collapse(&self, first: f64, time: f64) -> Option<String> {
        let Self { dt, limit, point, position } = self;
        let place = point.map_or_else(String::new, |point| format!(" of point {point} at {position:?} m"));
        (*dt < Self::COLLAPSED * first).then(|| {
            format!(
                "t = {time} s: the time step has fallen to {dt:.3e} s from {first:.3e} s at the start, limited by: \
                 {limit}{place}; if that lasts, the run will hardly go on (look at what deforms there, and how fast it moves)"
            )
        })
    }

    /// The step that a case fixes (s), if it does and this critical one allows it.
    #[must_use]
    pub fn or_fixed(self, fixed: Option<f64>) -> Self {
        match fixed {
            Some(dt) if dt <= self.dt => {
                Self { dt, limit: StepLimit::Fixed, point: None, position: [0.0; 3] }
            }
            _ => self,
        }
    }

    /// What is wrong with the step that a case fixes (s), where it is longer than this one.
    #[must_use]
    pub fn too_long(&self, fixed: Option<f64>) -> Option<String> {
        let Self { dt, limit, .. } = self;
        fixed.filter(|fixed| fixed > dt).map(|fixed| {
            format!(
                "{fixed} s is larger than the critical step {dt:.4e} s, limited by: {limit} (make it smaller, or leave it \
                 out for steps that follow the state)"
            )
        })
    }
}
