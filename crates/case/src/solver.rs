//! What every method offers: [`Method`] makes a [`Solver`] of a [`Case`].

use colluvium_constitutive::SymTensor;
use schemars::Schema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::description::Stage;
use crate::measure::Reading;
use crate::{Case, CaseError, Equilibrium};

/// A numerical method: its options, and the way from a case to a running solver.
pub trait Method: Send + Sync {
    /// Name of the method, the key under `methods` in a case file.
    fn name(&self) -> &'static str;

    /// One sentence on what the method is.
    fn summary(&self) -> &'static str;

    /// JSON Schema of the options under `methods.<name>`.
    fn options_schema(&self) -> Schema;

    /// About how large the problem is, without making its points. Methods that do not tell are of no size.
    ///
    /// # Errors
    /// When its options are wrong.
    fn size(&self, case: &Case) -> Result<Size, CaseError> {
        let _ = case;
        Ok(Size::default())
    }

    /// What would be solved, without solving it. Refuses, by JSON path, whatever the method cannot honour.
    ///
    /// # Errors
    /// The first thing in the case that this method cannot honour.
    fn plan(&self, case: &Case) -> Result<Plan, CaseError>;

    /// A solver at time zero, before the first stage begins.
    ///
    /// # Errors
    /// As [`Method::plan`].
    fn build(&self, case: &Case) -> Result<Box<dyn Solver>, CaseError>;
}

/// About how large a problem is, known before any of it is made; points from files and meshes do not count.
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
    /// Estimated memory (bytes).
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
    /// Estimated wall-clock time on one thread (s).
    pub fn seconds(&self) -> f64 {
        self.points as f64 * self.steps as f64 / self.updates_per_second
    }
}

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

/// Totals of the whole system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// Mass (kg; per metre in plane strain, per radian in axisymmetry).
    pub mass: f64,
    /// Linear momentum (kg m/s).
    pub momentum: [f64; 3],
    /// Angular momentum about the origin (kg m²/s).
    pub angular_momentum: [f64; 3],
    /// Kinetic energy (J).
    pub kinetic: f64,
    /// Recoverable energy of the materials that define one (J).
    pub elastic: f64,
    /// Potential energy of gravity, zero at the origin (J).
    pub potential: f64,
    /// The share of the pore fluid in all of these; `None` where nothing is saturated.
    pub liquid: Option<PhaseBudget>,
}

/// Totals of one phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseBudget {
    /// Mass (kg).
    pub mass: f64,
    /// Linear momentum (kg m/s).
    pub momentum: [f64; 3],
    /// Kinetic energy (J).
    pub kinetic: f64,
    /// Energy of compression (J).
    pub elastic: f64,
    /// Potential energy of gravity, zero at the origin (J).
    pub potential: f64,
}

/// What the material does to a rigid body or to a patch of prescribed velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// Force in the last step (N; per metre in plane strain, per radian in axisymmetry).
    pub force: [f64; 3],
    /// Impulse since the start (N s).
    pub impulse: [f64; 3],
}

/// One named quantity on the points.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name in snake case: `velocity`, `stress`, `mass`, `volume`, `displacement`, `density`, …
    pub name: String,
    /// SI unit, for labels.
    pub unit: &'static str,
    /// The values.
    pub data: FieldData,
}

/// Values of a [`Field`], one per point.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldData {
    /// Scalars.
    Scalar(Vec<f64>),
    /// Vectors.
    Vector(Vec<[f64; 3]>),
    /// Symmetric tensors.
    Tensor(Vec<SymTensor>),
}

/// The state of all points at an instant, in the order of their ids, whatever order the solver keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Time (s).
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// Ids, ascending; an id is the point's for its whole life.
    pub ids: Vec<u64>,
    /// Index into `Case::bodies` of each point.
    pub bodies: Vec<u32>,
    /// Positions (m); unused components are zero.
    pub positions: Vec<[f64; 3]>,
    /// Full widths of the points' domains (m).
    pub extents: Vec<[f64; 3]>,
    /// Fields; every method gives at least `velocity`, `stress`, `mass`, `volume`, `displacement`.
    pub fields: Vec<Field>,
}

impl Snapshot {
    /// The field called `name`.
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|f| f.name == name)
    }

    /// The scalars of the field called `name`, one a point; `None` where there is none of scalars.
    pub fn scalars(&self, name: &str) -> Option<&[f64]> {
        match &self.field(name)?.data {
            FieldData::Scalar(values) => Some(values),
            _ => None,
        }
    }

    /// The vectors of the field called `name`, one a point; `None` where there is none of vectors.
    pub fn vectors(&self, name: &str) -> Option<&[[f64; 3]]> {
        match &self.field(name)?.data {
            FieldData::Vector(values) => Some(values),
            _ => None,
        }
    }

    /// The tensors of the field called `name`, one a point; `None` where there is none of tensors.
    pub fn tensors(&self, name: &str) -> Option<&[SymTensor]> {
        match &self.field(name)?.data {
            FieldData::Tensor(values) => Some(values),
            _ => None,
        }
    }
}

/// The problem of a body whose law cannot begin anew from the stress it has, for its own `reason`.
pub fn not_reset(reason: &str) -> String {
    format!(
        "reset of state at the end of the stage: its law cannot begin anew from the stress it has ({reason})"
    )
}

/// Why a run had to stop.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SolverError {
    /// A point left what the method can follow: NaN, runaway velocity, inverted, outside the grid.
    #[error("step {step}, t = {time} s, point {point} at {position:?} m: {reason}")]
    Point {
        /// Step during which it happened.
        step: u64,
        /// Time at the start of that step (s).
        time: f64,
        /// Id of the first such point.
        point: u64,
        /// Its position (m).
        position: [f64; 3],
        /// What happened.
        reason: String,
    },
    /// A step that could not be done.
    #[error("step {step}, t = {time} s: {reason}")]
    Step {
        /// The step.
        step: u64,
        /// Time at its start (s).
        time: f64,
        /// What happened.
        reason: String,
    },
    /// A checkpoint does not fit this case or this version.
    #[error("checkpoint: {0}")]
    Checkpoint(String),
}

/// A method's running instance.
pub trait Solver: Send {
    /// Time (s).
    fn time(&self) -> f64;

    /// Steps done.
    fn step_count(&self) -> u64;

    /// Number of points.
    fn points(&self) -> usize;

    /// The largest stable step from here, safety factor included.
    fn time_step(&mut self) -> TimeStep;

    /// Advances by `dt`, at most [`Solver::time_step`].
    ///
    /// # Errors
    /// When a point can no longer be followed; the solver is then not to be used further.
    fn step(&mut self, dt: f64) -> Result<(), SolverError>;

    /// Prepares a stage: its boundaries, damping, gravity ramp. Called once when the stage begins,
    /// and after [`Solver::restore`] with the stage the checkpoint lies in; `stage` is an index into
    /// `Case::stages`, `start` the time the stage began (s).
    ///
    /// # Errors
    /// When the stage cannot be begun.
    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError>;

    /// Ends a stage: performs its `reset` (velocities, displacements, plastic strains).
    ///
    /// # Errors
    /// When the stage cannot be ended.
    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError>;

    /// Width of the cells of its grid (m); `None` for methods without a grid.
    fn cell_size(&self) -> Option<f64> {
        None
    }

    /// Distance from equilibrium after the last step; `None` where the method has no measure of it.
    fn equilibrium(&self) -> Option<Equilibrium>;

    /// Whether what its own options let grow with time has its full size: before that nothing is at rest.
    fn has_grown(&self) -> bool {
        true
    }

    /// What else the method tells of itself in each row of the measures; always the same names in the same order, NaN for
    /// what it does not know at the time.
    fn readings(&self) -> Vec<Reading> {
        Vec::new()
    }

    /// Force of the material on the rigid body or patch `name`; `None` for methods without them.
    fn reaction(&self, name: &str) -> Option<Reaction> {
        let _ = name;
        None
    }

    /// Energy (J) that the materials of the points that are there have dissipated since the start; `None` where the case
    /// does not measure it.
    fn dissipated(&self) -> Option<f64> {
        None
    }

    /// What of the state is worth a word when a run ends: points that are where their law is no longer meant to hold, …
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }

    /// Everything on the points, in the order of ids.
    fn snapshot(&self) -> Snapshot;

    /// Totals.
    fn budget(&self) -> Budget;

    /// The complete state as bytes: a restored solver continues bit-identically.
    fn save(&self) -> Vec<u8>;

    /// Takes the state of [`Solver::save`] of the same case.
    ///
    /// # Errors
    /// When the bytes are not such a state.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), SolverError>;
}

impl Snapshot {
    /// A number that is the same only for snapshots equal to the last bit: time, step, ids, bodies,
    /// places and fields with their names.
    pub fn hash(&self) -> u64 {
        let mut bytes: Vec<u8> = Vec::new();
        bytes.extend(self.time.to_bits().to_le_bytes());
        bytes.extend(self.step.to_le_bytes());
        // Counts keep apart what would run together.
        bytes.extend((self.ids.len() as u64).to_le_bytes());
        bytes.extend(self.ids.iter().flat_map(|id| id.to_le_bytes()));
        bytes.extend(self.bodies.iter().flat_map(|body| body.to_le_bytes()));
        let add = |bytes: &mut Vec<u8>, values: &[f64]| {
            bytes.extend(values.iter().flat_map(|v| v.to_bits().to_le_bytes()));
        };
        add(&mut bytes, self.positions.as_flattened());
        add(&mut bytes, self.extents.as_flattened());
        for field in &self.fields {
            bytes.extend((field.name.len() as u64).to_le_bytes());
            bytes.extend(field.name.as_bytes());
            match &field.data {
                FieldData::Scalar(values) => add(&mut bytes, values),
                FieldData::Vector(values) => add(&mut bytes, values.as_flattened()),
                FieldData::Tensor(values) => values.iter().for_each(|tensor| add(&mut bytes, &tensor.0)),
            }
        }
        crate::load::fnv1a(&bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hash_tells_apart_snapshots_that_differ_anywhere() {
        let whole = Snapshot {
            time: 1.0,
            step: 7,
            ids: vec![0, 1],
            bodies: vec![0, 1],
            positions: vec![[0.0; 3], [1.0; 3]],
            extents: vec![[0.1; 3]; 2],
            fields: vec![Field { name: "mass".into(), unit: "kg", data: FieldData::Scalar(vec![1.0, 2.0]) }],
        };
        let changes: [fn(&mut Snapshot); 8] = [
            |s| s.time = 1.5,
            |s| s.step = 8,
            |s| s.ids[1] = 2,
            |s| s.bodies[1] = 0,
            |s| s.positions[0][1] = -0.0,
            |s| s.extents[0][0] = 0.2,
            |s| s.fields[0].name = "heat".into(),
            |s| s.fields[0].data = FieldData::Scalar(vec![1.0, 2.0 + 1e-15]),
        ];
        let hashes: Vec<u64> = changes
            .iter()
            .map(|change| {
                let mut snapshot = whole.clone();
                change(&mut snapshot);
                snapshot.hash()
            })
            .chain([whole.hash()])
            .collect();
        for (i, hash) in hashes.iter().enumerate() {
            assert!(!hashes[..i].contains(hash), "change {i} goes unseen");
        }
        assert_eq!(whole.hash(), whole.clone().hash());
    }
}
