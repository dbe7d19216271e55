//! Checks that a weak layer carries its slab before a saw test begins (sheet: snow-mpm §3.12, §7).

use colluvium_case::description::{RemovalShape, Stage};
use colluvium_case::{SolverError, spatial};

use crate::points::bodies::{BodyPoints, PointFailure};
use crate::points::vectors::square;
use crate::solver::SnowSolver;
use crate::solver::saw_test::{sawn_layer, strength_of_weak_layer};
use colluvium_case::FailureReason;
use colluvium_case::Warning;

/// Relative loss of strength that is regarded as round-off.
const YIELD_TOLERANCE: f64 = 1e-9;
/// Largest speed of points in a column that is regarded as at rest (m/s; sheet: snow-mpm §3.12).
const REST_SPEED: f64 = 1e-3;

/// Results of the checks of rest.
#[derive(Clone, Copy, Debug, Default)]
pub struct RestChecks {
    /// Speed of the fastest point (m/s) at the start of a saw test, where it is above that of rest.
    initial_speed: Option<f64>,
    /// Points of a weak layer that yielded before the first cut, with the time of the check.
    early_yield: Option<(CheckTime, YieldedPoints)>,
}

/// Time of a check of a weak layer.
#[derive(Clone, Copy, Debug)]
enum CheckTime {
    /// End of the stage of this number, in which gravity was ramped.
    EndOf(usize),
    /// Start of the first cut.
    FirstCut,
}

/// Points of a weak layer that have yielded.
#[derive(Clone, Copy, Debug)]
struct YieldedPoints {
    /// Number of the body in the case.
    body: u32,
    /// Number of yielded points.
    count: usize,
    /// Number of points without remaining strength.
    collapsed_points: usize,
    /// Number of points of the layer.
    layer_count: usize,
    /// Index of the first yielded point among the points of its body, of those without strength if there are any; its position (m).
    index: usize,
    position: [f64; 3],
}

impl<const D: usize> SnowSolver<D> {
    /// Checks that a saw test is at rest at the start of its first cut. A collapsed point of the weak layer is an error, as the crack then
    /// exists before the cut.
    ///
    /// # Errors
    /// When a point of the weak layer has collapsed: the crack exists before the cut.
    pub(super) fn check_rest(&mut self, cut: &RemovalShape) -> Result<(), SolverError> {
        let Some(name) = sawn_layer(&self.case, cut) else { return Ok(()) };
        let velocities = self.bodies.bodies.iter().flat_map(|body| &body.points.velocity);
        let fastest = velocities.map(square).fold(0f64, f64::max).sqrt();
        let of_layer = |body: &BodyPoints<D>| self.case.bodies[body.number as usize].name == *name;
        let number = self.bodies.bodies.iter().position(of_layer);
        let yielded = number.and_then(|number| self.yielded_points(&self.bodies.bodies[number]));
        if let (Some(number), Some(YieldedPoints { collapsed_points, layer_count: of, index, .. })) =
            (number, yielded.filter(|yielded| yielded.collapsed_points > 0))
        {
            let reason = FailureReason::coded(
                "weak-layer-collapsed",
                format!(
                    "{collapsed_points} of the {of} points of the weak layer {name:?} have collapsed at rest, before the \
                 first cut, this one among them: make the layer stronger or the slab lighter, apply its \
                 weight more slowly (gravity_ramp and damping of the stage before), or, on ground that is not \
                 parallel to an axis, add old, elastic snow below the layer"
                ),
            );
            return Err(self.point_error(number, &PointFailure { index, reason }));
        }
        let checks = &mut self.clock.rest_checks;
        checks.early_yield = checks.early_yield.or(yielded.map(|yielded| (CheckTime::FirstCut, yielded)));
        checks.initial_speed = Some(fastest).filter(|fastest| *fastest > REST_SPEED);
        Ok(())
    }

    /// Checks that the weak layers carry the weight at the end of a stage with a gravity ramp, if another stage follows.
    pub(crate) fn check_weak_layers(&mut self, stage: &Stage) {
        let number = self.clock.stage;
        if stage.gravity_ramp > 0.0
            && number + 1 < self.case.stages.len()
            && self.clock.rest_checks.early_yield.is_none()
        {
            let yielded = self.bodies.bodies.iter().find_map(|body| self.yielded_points(body));
            self.clock.rest_checks.early_yield = yielded.map(|yielded| (CheckTime::EndOf(number), yielded));
        }
    }

    /// Yielded points of a body that is a weak layer.
    fn yielded_points(&self, body: &BodyPoints<D>) -> Option<YieldedPoints> {
        let of_case = &self.case.bodies[body.number as usize];
        let spec = &self.case.materials[&of_case.material];
        let strength = strength_of_weak_layer(spec)?;
        // A wrapper of a law may begin with a part of its strength.
        let smallest = if spec.inner().is_none() { strength * (1.0 - YIELD_TOLERANCE) } else { 0.0 };
        let names = body.material.output_names();
        let column = |name: &str| names.iter().position(|own| *own == name);
        let (bears, collapsed) = (column("compressive_strength")?, column("collapsed")?);
        let outputs = body.law_points().law_values(names.len(), |stress, states, out| {
            body.material.outputs(stress, states, out);
        });
        let has_collapsed = |outputs: &&[f64]| outputs[collapsed] > 0.5;
        let has_yielded = |outputs: &&[f64]| outputs[bears] < smallest || has_collapsed(outputs);
        let all = || outputs.chunks(names.len());
        let index =
            all().position(|of| has_collapsed(&of)).or_else(|| all().position(|of| has_yielded(&of)))?;
        Some(YieldedPoints {
            body: body.number,
            count: all().filter(has_yielded).count(),
            collapsed_points: all().filter(has_collapsed).count(),
            layer_count: body.points.len(),
            index,
            position: spatial(&body.points.position[index]),
        })
    }

    /// Warning of the checks of rest.
    pub(crate) fn rest_warning(&self) -> Option<Warning> {
        let RestChecks { initial_speed: unrest, early_yield: early } = self.clock.rest_checks;
        if let Some((
            moment,
            YieldedPoints { body, count, collapsed_points, layer_count: of, position, .. },
        )) = early
        {
            let when = match moment {
                CheckTime::EndOf(stage) => format!("at the end of stage {:?}", self.case.stages[stage].name),
                CheckTime::FirstCut => "when the first cut began".to_owned(),
            };
            let (name, position) = (&self.case.bodies[body as usize].name, self.case.map_position(&position));
            return Some(Warning::new(
                "weak-layer-yielded",
                format!(
                    "{when} {count} of the {of} points of the weak layer {name:?} had yielded under their weight \
                 alone, {collapsed_points} of them without strength, one at {:.4?} m. The layer is then weaker than \
                 that of the case: make it stronger or the slope less, or, on ground that is not parallel to \
                 an axis, add old, elastic snow below it",
                    &position[..D]
                ),
            ));
        }
        unrest.map(|fastest| {
            Warning::new(
                "cut-not-at-rest",
                format!(
                    "the first cut began with points as fast as {fastest:.1e} m/s, above the limit of \
                 {REST_SPEED:.0e} m/s for a column at rest: let it settle longer, with gravity_ramp and \
                 damping"
                ),
            )
        })
    }
}
