//! Whether a weak layer bears what lies on it before anything else happens (sheet: snow-mpm §3.12, §7).

use colluvium_case::description::{RemovalShape, Stage};
use colluvium_case::{SolverError, spatial};

use crate::points::bodies::{BodyPoints, PointFailure};
use crate::points::vectors::square;
use crate::solver::SnowSolver;
use crate::solver::saw_test::{sawn_layer, strength_of_weak_layer};

/// Share of its strength that a point may have lost by round-off.
const YIELD_TOLERANCE: f64 = 1e-9;
/// Speed of the fastest point of a column at rest (m/s; sheet: snow-mpm §3.12).
const REST_SPEED: f64 = 1e-3;

/// What the run has to say of rest.
#[derive(Clone, Copy, Debug, Default)]
pub struct RestChecks {
    /// Speed of the fastest point (m/s) when a saw test began, where that was no rest.
    initial_speed: Option<f64>,
    /// What of a weak layer had yielded before anything else happened, and when that was.
    early_yield: Option<(CheckTime, YieldedPoints)>,
}

/// When a weak layer was looked at.
#[derive(Clone, Copy, Debug)]
enum CheckTime {
    /// At the end of the stage of this number, which let the weight grow.
    EndOf(usize),
    /// When the first cut began.
    FirstCut,
}

/// Points of a weak layer that have yielded.
#[derive(Clone, Copy, Debug)]
struct YieldedPoints {
    /// Number of the body in the case.
    body: u32,
    /// How many they are.
    count: usize,
    /// How many of them have no strength left.
    collapsed: usize,
    /// How many points the layer has.
    layer_count: usize,
    /// Index of the first, of those without strength if there are any, among the points of its body; its place (m).
    index: usize,
    place: [f64; 3],
}

impl<const D: usize> SnowSolver<D> {
    /// Looks whether a saw test is at rest when its first cut begins.
    ///
    /// # Errors
    /// Where a point of the weak layer has collapsed: the crack is there before the saw.
    pub(super) fn check_rest(&mut self, cut: &RemovalShape) -> Result<(), SolverError> {
        let Some(name) = sawn_layer(&self.case, cut) else { return Ok(()) };
        let velocities = self.bodies.all.iter().flat_map(|body| &body.points.velocity);
        let fastest = velocities.map(square).fold(0f64, f64::max).sqrt();
        let of_layer = |body: &BodyPoints<D>| self.case.bodies[body.number as usize].name == *name;
        let number = self.bodies.all.iter().position(of_layer);
        let yielded = number.and_then(|number| self.yielded_points(&self.bodies.all[number]));
        if let (Some(number), Some(YieldedPoints { collapsed, layer_count: of, index, .. })) =
            (number, yielded.filter(|yielded| yielded.collapsed > 0))
        {
            let reason = format!(
                "{collapsed} of the {of} points of the weak layer {name:?} have collapsed at rest, before the first cut, this one among them: \
                 make it stronger or the slab lighter, let its weight come more slowly (gravity_ramp and damping \
                 of the stage before), or on ground along no axis lay old, elastic snow below it"
            );
            return Err(self.point_error(number, &PointFailure { index, reason }));
        }
        let seen = &mut self.clock.rest_checks;
        seen.early_yield = seen.early_yield.or(yielded.map(|yielded| (CheckTime::FirstCut, yielded)));
        seen.initial_speed = Some(fastest).filter(|fastest| *fastest > REST_SPEED);
        Ok(())
    }

    /// Looks whether the weight that a stage has let grow slowly is borne at its end by the weak layers, where another stage follows.
    pub(crate) fn check_weak_layers(&mut self, stage: &Stage) {
        let number = self.clock.stage;
        if stage.gravity_ramp > 0.0
            && number + 1 < self.case.stages.len()
            && self.clock.rest_checks.early_yield.is_none()
        {
            let yielded = self.bodies.all.iter().find_map(|body| self.yielded_points(body));
            self.clock.rest_checks.early_yield = yielded.map(|yielded| (CheckTime::EndOf(number), yielded));
        }
    }

    /// What of a body has yielded, where it is a weak layer.
    fn yielded_points(&self, body: &BodyPoints<D>) -> Option<YieldedPoints> {
        let of_case = &self.case.bodies[body.number as usize];
        let spec = &self.case.materials[&of_case.material];
        let strength = strength_of_weak_layer(spec)?;
        // A law around another may begin with a part of its strength.
        let least = if spec.inner().is_none() { strength * (1.0 - YIELD_TOLERANCE) } else { 0.0 };
        let names = body.material.output_names();
        let column = |name: &str| names.iter().position(|own| *own == name);
        let (bears, collapsed) = (column("compressive_strength")?, column("collapsed")?);
        let outputs = body.law_points().law_values(names.len(), |stress, states, out| {
            body.material.outputs(stress, states, out);
        });
        let has_collapsed = |outputs: &&[f64]| outputs[collapsed] > 0.5;
        let has_yielded = |outputs: &&[f64]| outputs[bears] < least || has_collapsed(outputs);
        let all = || outputs.chunks(names.len());
        let index =
            all().position(|of| has_collapsed(&of)).or_else(|| all().position(|of| has_yielded(&of)))?;
        Some(YieldedPoints {
            body: body.number,
            count: all().filter(has_yielded).count(),
            collapsed: all().filter(has_collapsed).count(),
            layer_count: body.points.len(),
            index,
            place: spatial(&body.points.position[index]),
        })
    }

    /// What there is to say of rest.
    pub(crate) fn rest_warning(&self) -> Option<String> {
        let RestChecks { initial_speed: unrest, early_yield: early } = self.clock.rest_checks;
        if let Some((moment, YieldedPoints { body, count, collapsed, layer_count: of, place, .. })) = early {
            let when = match moment {
                CheckTime::EndOf(stage) => format!("at the end of stage {:?}", self.case.stages[stage].name),
                CheckTime::FirstCut => "when the first cut began".to_owned(),
            };
            let (name, place) = (&self.case.bodies[body as usize].name, self.case.map_position(&place));
            return Some(format!(
                "{when} {count} of the {of} points of the weak layer {name:?} had yielded under their weight alone, {collapsed} of them without \
                 strength, one at {:.4?} m: what follows finds a weaker layer than that of the case (make it stronger or the slope less; on \
                 ground along no axis lay old, elastic snow below it)",
                &place[..D]
            ));
        }
        unrest.map(|fastest| {
            format!(
                "the first cut began with points as fast as {fastest:.1e} m/s, above the {REST_SPEED:.0e} of a column at rest: let it settle longer, \
                 with gravity_ramp and damping"
            )
        })
    }
}
