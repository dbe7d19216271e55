//! Force of the material on a rigid body, a patch or an obstacle.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::CaseErrorKind;
use crate::error_collector::ErrorCollector;
use crate::measure::{AXES, MeasureDefinition, MeasuredState, ScalarOutput, visit_position};
use crate::{Space, spatial};

/// Force on a rigid body, patch or obstacle in the last step (N; per metre in plane strain, per radian in axisymmetry): columns `NAME.x`,
/// …. `NAME.impulse.x`, … (N s) are its impulse since the start, whose slope is the mean force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReactionForce {
    /// Rigid body, patch or obstacle.
    pub target: String,
    /// Reference point (m) of the moment (N m; per metre in plane strain, anticlockwise): columns `NAME.moment.x`, …, in the plane
    /// `NAME.moment`. For obstacles, in the plane and in space.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub about: Vec<f64>,
}

impl ReactionForce {
    /// Force on a rigid body, a patch or an obstacle.
    #[must_use]
    pub fn new(target: impl Into<String>) -> Self {
        Self { target: target.into(), about: Vec::new() }
    }
}

impl MeasureDefinition for ReactionForce {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        let (of, about) = (&self.target, &self.about);
        check_target(path, of, errors);
        if about.is_empty() {
            return;
        }
        let path = &format!("{path}.about");
        let problem = CaseErrorKind::coded(
            "needs-other-key",
            "a moment about a place is available in plane-strain and 3d only",
        );
        let has_moment = matches!(errors.case.space, Space::PlaneStrain | Space::ThreeD);
        errors.require(has_moment, path, problem);
        errors.vector(path, about);
        let is_obstacle = errors.case.obstacles.iter().any(|obstacle| obstacle.name == *of);
        let problem = format!(
            "moments are available on obstacles only, and {of:?} is not an obstacle: leave the place out"
        );
        errors.require(is_obstacle, path, CaseErrorKind::coded("conflicting-keys", problem));
    }

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        let reaction = state.reaction(&self.target);
        let mut readings = Vec::new();
        for (c, axis) in AXES.iter().enumerate().take(state.case.dimension()) {
            let of = |value: fn(&crate::Reaction) -> [f64; 3]| {
                reaction.as_ref().map_or(f64::NAN, |reaction| value(reaction)[c])
            };
            readings.push((format!("{name}.{axis}"), "N".to_owned(), of(|r| r.force)));
            readings.push((format!("{name}.impulse.{axis}"), "N s".to_owned(), of(|r| r.impulse)));
        }
        if !self.about.is_empty() {
            let moment = reaction.and_then(|reaction| reaction.moment_about(&spatial(&self.about)));
            readings.extend(moments(name, state.case.dimension(), moment.unwrap_or([f64::NAN; 3])));
        }
        readings
    }

    fn needs_points(&self) -> bool {
        false
    }

    fn visit_coordinates(&mut self, visit: &mut dyn FnMut(usize, &mut f64)) {
        visit_position(&mut self.about, visit);
    }

    fn reaction_target(&self) -> Option<&str> {
        Some(&self.target)
    }
}

/// Checks that the target of a force is a rigid body, a patch or an obstacle.
pub(super) fn check_target(path: &str, of: &str, errors: &mut ErrorCollector<'_>) {
    let mut known = errors.case.movable_names();
    known.extend(errors.case.obstacles.iter().map(|obstacle| obstacle.name.as_str()));
    let what = "the name of a rigid body, a patch or an obstacle";
    errors.name(&format!("{path}.target"), of, &known, what);
}

/// Components of a moment; in the plane only the one perpendicular to it.
fn moments(name: &str, dimension: usize, [x, y, z]: [f64; 3]) -> Vec<ScalarOutput> {
    let reading = |name: String, value: f64| (name, "N m".to_owned(), value);
    if dimension < 3 {
        return vec![reading(format!("{name}.moment"), z)];
    }
    let named = AXES.into_iter().zip([x, y, z]);
    named.map(|(axis, value)| reading(format!("{name}.moment.{axis}"), value)).collect()
}
