//! Measures: numbers that a run records over time.
//!
//! A measure is a file with a structure, its key in case files, and its `MeasureDefinition`, and a line in the list of [`Measure`].

mod points;
mod solver_values;

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error_collector::ErrorCollector;
use crate::{
    Body, Case, FactorOfSafety, Field, FieldData, FieldRole, FrameRequest, Reaction, Snapshot, Solver,
};

pub use crate::measure::points::arc_front::{ArcFront, arc_front};
pub use crate::measure::points::crack_tip::CrackTip;
pub use crate::measure::points::fragments::{BreakageCriterion, Fragments, fragments};
pub use crate::measure::points::front::{Front, FrontColumns, front};
pub use crate::measure::points::probe::Probe;
pub use crate::measure::points::profile::{Profile, profile};
pub use crate::measure::points::run_out::RunOut;
pub use crate::measure::solver_values::discharge::Discharge;
pub use crate::measure::solver_values::dissipation::Dissipation;
pub use crate::measure::solver_values::gauge::Gauge;
pub use crate::measure::solver_values::impact_pressure::ImpactPressure;
pub use crate::measure::solver_values::reaction::ReactionForce;
pub use crate::solver::ScalarOutput;

/// Names of the axes in columns.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// Calls `visit` with the axis of each coordinate of a position, and with the coordinate (m).
pub(crate) fn visit_position(position: &mut [f64], visit: &mut dyn FnMut(usize, &mut f64)) {
    position.iter_mut().enumerate().for_each(|(axis, x)| visit(axis, x));
}

/// Default fraction of the mass behind a front: all.
pub(crate) const fn default_fraction() -> f64 {
    1.0
}

/// State of which measures are read.
pub struct MeasuredState<'a> {
    /// Case with the measures.
    pub case: &'a Case,
    /// Points, nodes or cells.
    pub snapshot: &'a Snapshot,
    /// Solver; measures that it computes are NaN without it.
    pub solver: Option<&'a dyn Solver>,
    /// Cell size of the grid of the method (m); `None` without one.
    pub cell: Option<f64>,
    /// Travelled distances of the removal shapes ([`Solver::removal_shape_travel`]).
    pub travels: &'a [Option<f64>],
}

impl<'a> MeasuredState<'a> {
    /// State of points without a solver.
    #[must_use]
    pub fn of_points(case: &'a Case, snapshot: &'a Snapshot) -> Self {
        Self { case, snapshot, solver: None, cell: None, travels: &[] }
    }

    /// Points whose mass a measure counts, as [`counted_points`].
    fn counted_points(&self, bodies: Option<&[String]>) -> Cow<'a, Snapshot> {
        counted_points(self.case, self.snapshot, bodies)
    }

    /// Force on a rigid body, a patch or an obstacle; `None` where the solver has none.
    fn reaction(&self, target: &str) -> Option<Reaction> {
        self.solver?.reaction(target)
    }
}

/// Field that a measure reads.
#[cfg_attr(not(feature = "output"), allow(dead_code, reason = "runs read it"))]
pub(crate) struct FieldUse<'a> {
    /// Key of the name in the measure.
    pub(crate) key: String,
    /// Name of the field.
    pub(crate) name: Cow<'a, str>,
    /// Whether the field must be of numbers.
    pub(crate) is_scalar: bool,
}

/// Definition of a measure: its checks, its columns and what it needs.
#[cfg_attr(not(feature = "output"), allow(dead_code, reason = "runs call some of its functions"))]
pub(crate) trait MeasureDefinition {
    /// Checks the rules that the schema does not contain; `path` is the JSON path of the measure.
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>);

    /// Columns of the measure `name`: name, unit and value. Their names and order are constant.
    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput>;

    /// Whether the measure needs the positions of points, nodes or cells.
    fn needs_points(&self) -> bool {
        true
    }

    /// Calls `visit` with the axis of each map coordinate and with the coordinate (m).
    fn visit_coordinates(&mut self, visit: &mut dyn FnMut(usize, &mut f64)) {
        let _ = visit;
    }

    /// Fields that the measure reads.
    fn fields(&self) -> Vec<FieldUse<'_>> {
        Vec::new()
    }

    /// Profile at a frame: positions and heights (m on the map); `None` for measures without one.
    fn profile(&self, state: &MeasuredState<'_>) -> Option<Vec<(f64, f64)>> {
        let _ = state;
        None
    }

    /// Name of the rigid body, patch or obstacle on which the force of the material is measured.
    fn reaction_target(&self) -> Option<&str> {
        None
    }

    /// Whether the measure is one number, in a column of its own name.
    fn is_single_number(&self) -> bool {
        false
    }

    /// Whether the measure is NaN in all rows where no point comes within its radius.
    fn has_empty_radius(&self) -> bool {
        false
    }
}

/// Defines the enumeration of the measures from a list of its variants.
macro_rules! measures {
    ($($(#[$documentation:meta])* $variant:ident($definition:ty),)*) => {
        /// Quantity recorded in time.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
        pub enum Measure {
            $($(#[$documentation])* $variant($definition),)*
        }

        impl Measure {
            /// Definition of the measure.
            fn definition(&self) -> &dyn MeasureDefinition {
                match self {
                    $(Self::$variant(measure) => measure,)*
                }
            }

            /// Definition of the measure, to be changed.
            fn definition_mut(&mut self) -> &mut dyn MeasureDefinition {
                match self {
                    $(Self::$variant(measure) => measure,)*
                }
            }
        }

        $(
            impl From<$definition> for Measure {
                fn from(measure: $definition) -> Self {
                    Self::$variant(measure)
                }
            }
        )*
    };
}

measures! {
    /// Front of the mass along an axis (m). Columns of cells with a point at any height that share a face are a connected region. The front
    /// is the farthest end of a point domain in the region with the most mass; points beyond a gap are detached. With a quantile below 1,
    /// the front is the position behind which that mass fraction lies, which stray points do not change.
    Front(Front),
    /// Relative run-out `(front - initial) / initial`, both from `origin`, with the front of the measure `front`.
    RunOut(RunOut),
    /// Surface height in bins along an axis, at each frame.
    Profile(Profile),
    /// Field averages over points within `radius` of a position.
    Probe(Probe),
    /// Crack length through a body (m): columns `NAME`, the end of the continuous crack or cut from the origin, and `NAME.farthest`, that
    /// of the farthest part.
    CrackTip(CrackTip),
    /// Front along the line of an obstacle in the plane, arcs included (m): the position behind which a mass fraction lies. Each point
    /// counts at its nearest position on the line.
    ArcFront(ArcFront),
    /// Fragments of broken bodies: columns `NAME.count`, `NAME.largest` and `NAME.second` (kg), and `NAME.loose`, the mass of fragments too
    /// small to count (kg).
    Fragments(Fragments),
    /// Vertical flow depth at a position in plan (m), and velocity in plan (m/s): columns `NAME.depth`, `NAME.velocity.x`, …; no velocity
    /// where dry. For flows over terrain.
    Gauge(Gauge),
    /// Discharge across a line in plan (m³/s), positive to the right, seen along the line from `from` to `to`. In 3D, for flows over
    /// terrain.
    Discharge(Discharge),
    /// Force of the material on a rigid body, patch or obstacle in the last step (N; per metre in plane strain, per radian in axisymmetry):
    /// columns `NAME.x`, …. Columns `NAME.impulse.x`, … have its impulse since the start (N s), whose slope is the mean force.
    Reaction(ReactionForce),
    /// Pressure of the material on a rigid body, patch or obstacle (Pa): force of the last step along a direction, over an area. The column
    /// `NAME.impulse` (Pa s) is its impulse since the start, whose slope is the mean pressure.
    ImpactPressure(ImpactPressure),
    /// Energy dissipated by materials since the start (J; per metre in plane strain, per radian in axisymmetry): stress work minus stored
    /// energy. For laws without defined stored energy, all work counts.
    Dissipation(Dissipation),
    /// Factor of safety: largest divisor of strength at which bodies come to rest, by trials after the run.
    FactorOfSafety(FactorOfSafety),
}

impl Measure {
    /// Checks the rules that the schema does not contain.
    pub(crate) fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        self.definition().check(path, errors);
    }

    /// Whether the measure needs the positions of points, nodes or cells.
    pub(crate) fn needs_points(&self) -> bool {
        self.definition().needs_points()
    }

    /// Calls `visit` with the axis of each map coordinate and with the coordinate (m).
    pub(crate) fn visit_coordinates(&mut self, visit: &mut dyn FnMut(usize, &mut f64)) {
        self.definition_mut().visit_coordinates(visit);
    }

    /// Fields that the measure reads.
    pub(crate) fn fields(&self) -> Vec<FieldUse<'_>> {
        self.definition().fields()
    }

    /// Profile at a frame: positions and heights (m on the map); `None` for measures without one.
    #[cfg(feature = "output")]
    pub(crate) fn profile(&self, state: &MeasuredState<'_>) -> Option<Vec<(f64, f64)>> {
        self.definition().profile(state)
    }

    /// Whether the measure is NaN in all rows where no point comes within its radius.
    #[cfg(feature = "output")]
    pub(crate) fn has_empty_radius(&self) -> bool {
        self.definition().has_empty_radius()
    }

    /// Name of the rigid body, patch or obstacle on which the force of the material is measured.
    pub fn reaction_target(&self) -> Option<&str> {
        self.definition().reaction_target()
    }

    /// Whether the measure is one number, in a column of its own name.
    pub fn is_single_number(&self) -> bool {
        self.definition().is_single_number()
    }
}

/// Fields that the measures of a case read from points, besides ids, bodies, positions and extents.
pub(crate) fn fields_of_measures(case: &Case) -> Vec<String> {
    let named = case.measures.values().flat_map(Measure::fields).map(|used| used.name.into_owned());
    ["mass", "displacement"].map(str::to_owned).into_iter().chain(named).collect()
}

/// Reads the measures of the case: those of the points, and then those that the solver computes, each in the order of their names.
pub fn read(state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
    let of_kind = |needs_points: bool| {
        let measures = state.case.measures.iter();
        measures.filter(move |(_, measure)| measure.needs_points() == needs_points)
    };
    let all = of_kind(true).chain(of_kind(false));
    all.flat_map(|(name, measure)| measure.definition().read(name, state)).collect()
}

/// Reads the measures of the case from the present state of a solver, as [`read`]. Those of a run, profiles and factors of safety, have no
/// value here.
pub fn read_solver(case: &Case, solver: &dyn Solver) -> Vec<ScalarOutput> {
    let fields = fields_of_measures(case);
    let names: Vec<&str> = fields.iter().map(String::as_str).collect();
    let points = solver.frame(FrameRequest::Fields(&names)).into_measured_points();
    read_snapshot(case, solver, &points)
}

/// Reads the measures of the case from a solver and from the snapshot of its present state.
pub(crate) fn read_snapshot(case: &Case, solver: &dyn Solver, snapshot: &Snapshot) -> Vec<ScalarOutput> {
    let travels = solver.removal_shape_travel();
    let (cell, travels) = (solver.cell_size(), travels.as_slice());
    read(&MeasuredState { case, snapshot, solver: Some(solver), cell, travels })
}

/// Points whose mass a measure counts: those of `bodies`, or of all bodies that are not rigid.
pub fn counted_points<'a>(
    case: &Case,
    snapshot: &'a Snapshot,
    bodies: Option<&[String]>,
) -> Cow<'a, Snapshot> {
    let counts = |body: &Body| match bodies {
        Some(names) => names.contains(&body.name),
        None => !body.rigid,
    };
    let counts: Vec<bool> = case.bodies.iter().map(counts).collect();
    let kept = |i: &usize| counts.get(snapshot.bodies[*i] as usize).copied().unwrap_or(bodies.is_none());
    let kept: Vec<usize> = (0..snapshot.bodies.len()).filter(kept).collect();
    if kept.len() == snapshot.bodies.len() {
        return Cow::Borrowed(snapshot);
    }
    Cow::Owned(point_subset(snapshot, &kept))
}

/// Subset of the points, with their `mass`.
pub(crate) fn point_subset(snapshot: &Snapshot, kept: &[usize]) -> Snapshot {
    let mass = snapshot.role_values(FieldRole::Mass).map(|values| {
        let data = FieldData::Scalar(kept.iter().map(|&i| values[i]).collect());
        Field { name: "mass".to_owned(), unit: "kg", data }
    });
    Snapshot {
        time: snapshot.time,
        step: snapshot.step,
        ids: kept.iter().map(|&i| snapshot.ids[i]).collect(),
        bodies: kept.iter().map(|&i| snapshot.bodies[i]).collect(),
        positions: kept.iter().map(|&i| snapshot.positions[i]).collect(),
        extents: kept.iter().map(|&i| snapshot.extents[i]).collect(),
        fields: mass.into_iter().collect(),
    }
}

#[cfg(test)]
pub(crate) mod tests;
