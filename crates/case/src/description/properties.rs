//! Properties of a case that all methods use.

use std::collections::HashMap;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::json;

use crate::description::{Boundary, Domain, PrescribedMotion, Velocity};
use crate::files::json;
use crate::{Case, CaseError, Measure};

impl Case {
    /// Number of nodes along an axis of cells of edge `cell` (m) over the domain, a whole number.
    pub(crate) fn grid_nodes_along(&self, cell: f64, axis: usize) -> f64 {
        let width = self.domain.max[axis] - self.domain.min[axis];
        (width / cell - 1e-6).ceil().max(1.0) + 1.0
    }

    /// Number of nodes of cells of edge `cell` (m) over the domain; a float, since it may exceed the range of integers.
    pub(crate) fn grid_nodes(&self, cell: f64) -> f64 {
        (0..self.dimension()).map(|axis| self.grid_nodes_along(cell, axis)).product()
    }

    /// Number of coordinates of the space.
    pub fn dimension(&self) -> usize {
        self.space.dimension()
    }

    /// Gravity with three components (m/s²).
    pub fn gravity3(&self) -> [f64; 3] {
        spatial(&self.gravity)
    }

    /// Magnitude of gravity (m/s²).
    pub fn gravity_magnitude(&self) -> f64 {
        self.gravity.iter().map(|g| g * g).sum::<f64>().sqrt()
    }

    /// Sum of the durations of the stages (s).
    pub fn end_time(&self) -> f64 {
        self.stages.iter().map(|stage| stage.duration).sum()
    }

    /// Walls that are present in stage number `stage`, with their number in `boundaries`; beyond the last stage, those at its end.
    pub fn active_boundaries(&self, stage: usize) -> Vec<(usize, &Boundary)> {
        let removed = |boundary: &Boundary| {
            self.stages
                .iter()
                .take(stage.saturating_add(1))
                .any(|s| s.remove_boundaries.iter().any(|name| name == boundary.name()))
        };
        self.boundaries.iter().enumerate().filter(|(_, boundary)| !removed(boundary)).collect()
    }

    /// Duration of each boundary (s), in their order: until the stage that removes it.
    pub fn boundary_durations(&self) -> Vec<f64> {
        let mut left: HashMap<&str, f64> = HashMap::new();
        let mut time = 0.0;
        for stage in &self.stages {
            stage.remove_boundaries.iter().for_each(|name| {
                left.entry(name).or_insert(time);
            });
            time += stage.duration;
        }
        let stands = |boundary: &Boundary| left.get(boundary.name()).copied().unwrap_or(time);
        self.boundaries.iter().map(stands).collect()
    }

    /// Whether the bodies have no external actions in stage number `stage` except constant gravity along an axis that is not periodic.
    pub fn is_isolated(&self, stage: usize) -> bool {
        let moves =
            |velocity: &Option<Vec<f64>>| velocity.as_ref().is_some_and(|v| v.iter().any(|c| *c != 0.0));
        let falls_through = self.domain.periodic.iter().any(|axis| self.gravity[axis.number()] != 0.0);
        let stages = self.stages.iter().take(stage + 1);
        self.loads.is_empty()
            && self.patches.is_empty()
            && self.removal_shapes.is_empty()
            && !falls_through
            && !self.bodies.iter().any(|body| body.rigid || body.pore_fluid.is_some())
            && !self.boundaries.iter().any(|boundary| moves(&boundary.velocity))
            && !self.obstacles.iter().any(|obstacle| obstacle.motion.is_some())
            && stages.clone().all(|stage| stage.motions.is_empty())
            && self.stages.get(stage).is_some_and(|stage| stage.gravity_ramp == 0.0)
    }

    /// Whether the body of that name has been removed by the end of stage number `stage`.
    pub fn is_removed(&self, body: &str, stage: usize) -> bool {
        self.stages
            .iter()
            .take(stage.saturating_add(1))
            .any(|s| s.remove_bodies.iter().any(|name| name == body))
    }

    /// Whether the rigid body of that name moves freely in any stage.
    pub fn moves_freely(&self, body: &str) -> bool {
        self.stages.iter().filter_map(|stage| stage.motion_of(body)).any(PrescribedMotion::is_free)
    }

    /// Young's modulus of the material of that name (Pa), where it has one; wrapped materials are not considered.
    pub fn youngs_modulus(&self, material: &str) -> Option<f64> {
        serde_json::to_value(self.materials.get(material)?).ok()?.get("youngs_modulus")?.as_f64()
    }

    /// Options of method `name`, its defaults where the case has none.
    ///
    /// # Errors
    /// When they are invalid, with the path from the root of the case.
    pub fn method_options<T: DeserializeOwned + JsonSchema>(&self, name: &str) -> Result<T, CaseError> {
        let empty = json!({});
        let value = self.methods.get(name).unwrap_or(&empty);
        json::from_value(value, &format!("methods.{name}")).map_err(|errors| errors.first().clone())
    }

    /// Names of rigid bodies and patches, whose motion can be prescribed.
    pub(crate) fn movable_names(&self) -> Vec<&str> {
        let rigid = self.bodies.iter().filter(|body| body.rigid).map(|body| body.name.as_str());
        rigid.chain(self.patches.iter().map(|patch| patch.name.as_str())).collect()
    }

    /// Whether dissipated energy is measured.
    pub fn measures_dissipation(&self) -> bool {
        self.measures.values().any(|measure| matches!(measure, Measure::Dissipation(_)))
    }

    /// Origin that is subtracted from coordinates (m): `domain.origin`, or zero.
    pub fn origin(&self) -> [f64; 3] {
        spatial(&self.domain.origin)
    }

    /// Position (m) in map coordinates, for output.
    #[must_use]
    pub fn map_position<const D: usize>(&self, place: &[f64; D]) -> [f64; D] {
        let origin = self.origin();
        std::array::from_fn(|c| place[c] + origin[c])
    }
}

/// Vector in space of one to three components; missing components are zero.
#[inline]
pub fn spatial(vector: &[f64]) -> [f64; 3] {
    std::array::from_fn(|c| vector.get(c).copied().unwrap_or(0.0))
}

/// First mode shape of a cantilever at the share `x` of its length; the root is that of `cos kL cosh kL = -1`.
fn cantilever_mode(x: f64) -> f64 {
    /// First root of the frequency equation of a cantilever, cos x cosh x = -1.
    const ROOT: f64 = 1.875_104_068_711_961_3;
    let (k, kx) = (ROOT, ROOT * x);
    (k.cos() + k.cosh()) * (kx.cosh() - kx.cos()) + (k.sin() - k.sinh()) * (kx.sinh() - kx.sin())
}

impl Velocity {
    /// Velocity at `x` (m/s).
    #[inline]
    pub fn velocity_at(&self, x: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Rest => [0.0; 3],
            Self::Uniform { value } => spatial(value),
            Self::Linear { value, origin, gradient } => {
                let (base, from) = (spatial(value), spatial(origin));
                std::array::from_fn(|i| {
                    let row = gradient.get(i).map_or([0.0; 3], |row| spatial(row));
                    base[i] + (0..3).map(|j| row[j] * (x[j] - from[j])).sum::<f64>()
                })
            }
            Self::Sine { amplitude, wave_vector, phase } => {
                let k = spatial(wave_vector);
                let angle = k[0] * x[0] + k[1] * x[1] + k[2] * x[2] + phase.to_radians();
                spatial(amplitude).map(|a| a * angle.sin())
            }
            Self::Formula { value } => {
                std::array::from_fn(|c| value.get(c).map_or(0.0, |formula| formula.evaluate(x)))
            }
            Self::Bending { along, across, clamp, length, tip } => {
                let place = ((x[*along] - clamp) / length).max(0.0);
                let value = tip * cantilever_mode(place) / cantilever_mode(1.0);
                std::array::from_fn(|c| if c == *across { value } else { 0.0 })
            }
        }
    }
}

impl Boundary {
    /// Name, or that of its side.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(self.side.name())
    }

    /// Coordinate of the wall's face (m).
    pub fn wall_coordinate(&self, domain: &Domain) -> f64 {
        let axis = self.side.axis();
        self.position.unwrap_or(if self.side.is_max() { domain.max[axis] } else { domain.min[axis] })
    }
}
