//! Time scales of a case: consolidation, waves, free fall.

use colluvium_constitutive::{InitialCondition, MaterialSpec, SymTensor};

use crate::Case;
use crate::description::Body;
use colluvium_constitutive::Warning;

/// Densities of a body with pore fluid (kg/m³).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyDensities {
    /// Density of the skeleton, the one of its material.
    pub dry: f64,
    /// Density of skeleton and fluid.
    pub saturated: f64,
    /// Density of the grains: dry density over one minus porosity.
    pub grains: f64,
}

impl BodyDensities {
    /// Usual range of the grain density of soils and rocks (kg/m³).
    const OF_GRAINS: [f64; 2] = [2300.0, 3000.0];

    /// Whether the grain density is usual for soils and rocks.
    fn are_usual(&self) -> bool {
        (Self::OF_GRAINS[0]..=Self::OF_GRAINS[1]).contains(&self.grains)
    }
}

/// Time scales of a case (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeScales {
    /// Extent of all bodies along gravity, or the largest layer thickness `h` (m).
    pub height: f64,
    /// Consolidation time `h²/c_v` of the slowest body, `c_v = (k/γ_w) / (1/M + n/K_f)`; `None` without pore fluid.
    pub consolidation: Option<f64>,
    /// Wave travel time `h/c` in the softest body, with skeleton and fluid moving together; `None` where laws have no stiffness.
    pub wave_time: Option<f64>,
    /// Fall time `√(h/g)`; `None` without gravity.
    pub fall_time: Option<f64>,
}

impl Case {
    /// Densities of a body; `None` without pore fluid.
    #[must_use]
    pub fn densities(&self, body: &Body) -> Option<BodyDensities> {
        let fluid = body.pore_fluid.as_ref()?;
        let dry = self.materials.get(&body.material).map(MaterialSpec::density)?;
        Some(BodyDensities {
            dry,
            saturated: fluid.saturated_density(dry),
            grains: dry / (1.0 - fluid.porosity),
        })
    }

    /// Time scales of the case.
    #[must_use]
    pub fn time_scales(&self) -> TimeScales {
        let gravity = self.gravity_magnitude();
        let height = self.height();
        let own = self.bodies.iter().filter(|body| !body.rigid);
        let (mut consolidation, mut wave_time) = (None::<f64>, None::<f64>);
        for (body, modulus) in own.filter_map(|body| Some((body, self.modulus(body)?))) {
            let h = extent(self, body);
            let mut stiffness = modulus;
            if let Some(fluid) = &body.pore_fluid {
                // sheet: mpm §2.3.
                let compliance = 1.0 / modulus + fluid.porosity / fluid.bulk_modulus;
                let time = h * h * compliance * fluid.resistance(gravity);
                consolidation = longer_time(consolidation, time);
                stiffness += fluid.bulk_modulus / fluid.porosity;
            }
            let time = h / (stiffness / self.bulk_density(body)).sqrt();
            wave_time = longer_time(wave_time, time);
        }
        let fall = (height / gravity).sqrt();
        TimeScales { height, consolidation, wave_time, fall_time: fall.is_finite().then_some(fall) }
    }

    /// Extent of all bodies along gravity, or along the first axis without gravity; the largest thickness of layers on terrain (m).
    pub(super) fn height(&self) -> f64 {
        let layers = self.bodies.iter().filter_map(|body| body.shape.layer_thickness());
        let thickest = layers.fold(0.0, f64::max);
        if thickest > 0.0 {
            return thickest;
        }
        let axis = self.steepest_axis();
        let bounds =
            self.bodies.iter().filter(|body| !body.rigid).map(|body| body.shape.bounds(self.dimension()));
        let ends = bounds.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (from, to)| {
            [low.min(from[axis]), high.max(to[axis])]
        });
        ends[1] - ends[0]
    }

    /// Axis of the largest component of gravity, the first axis without gravity.
    fn steepest_axis(&self) -> usize {
        let axes = (0..self.gravity.len()).rev();
        axes.max_by(|a, b| self.gravity[*a].abs().total_cmp(&self.gravity[*b].abs())).unwrap_or(0)
    }

    /// P-wave modulus of a body at its initial density without stress (Pa).
    pub(super) fn modulus(&self, body: &Body) -> Option<f64> {
        let spec = self.materials.get(&body.material)?;
        let law = spec.build().ok()?;
        let start = InitialCondition { stress: SymTensor([0.0; 6]), density: spec.density() };
        let (stresses, states) = law.initial(&[start]).ok()?;
        let mut modulus = [f64::NAN];
        law.wave_moduli(&stresses, &states.blocks()[0], &mut modulus);
        Some(modulus[0]).filter(|modulus| modulus.is_finite() && *modulus > 0.0)
    }

    /// Warns of grain densities unusual for soils and rocks: the given density may be meant for skeleton and fluid.
    pub(crate) fn warn_of_grains(&self, warnings: &mut Vec<Warning>) {
        for (number, body) in self.bodies.iter().enumerate().filter(|(_, body)| !body.rigid) {
            let (Some(fluid), Some(densities)) = (&body.pore_fluid, self.densities(body)) else { continue };
            let BodyDensities { dry, saturated, grains } = densities;
            if densities.are_usual() || dry <= (1.0 - fluid.porosity) * fluid.density {
                continue;
            }
            let meant = dry - fluid.porosity * fluid.density;
            let cure = if grains > BodyDensities::OF_GRAINS[1] && meant > 0.0 {
                format!(
                    "With a pore fluid this density is that of the dry skeleton. If the value includes the \
                     fluid, change it to {meant:.0}"
                )
            } else {
                "With a pore fluid this density is that of the dry skeleton, the density of the grains times \
                 one minus the porosity"
                    .to_owned()
            };
            warnings.push(Warning::new("unusual-grain-density", format!(
                "materials.{}.density: {dry} kg/m³ gives grains of {grains:.0} kg/m³ at the porosity {} of \
                 bodies[{number}], and {saturated:.0} kg/m³ with the fluid. Grains of soil have {:.0} to \
                 {:.0} kg/m³. {cure}",
                body.material,
                fluid.porosity,
                BodyDensities::OF_GRAINS[0],
                BodyDensities::OF_GRAINS[1]
            )));
        }
    }
}

/// Longer of two times (s), of which the second may be not-a-number.
fn longer_time(known: Option<f64>, time: f64) -> Option<f64> {
    if time.is_finite() { Some(known.map_or(time, |known| known.max(time))) } else { known }
}

/// Extent of a body along gravity (m). For a layer on terrain it is the thickness.
fn extent(case: &Case, body: &Body) -> f64 {
    if let Some(thickness) = body.shape.layer_thickness() {
        return thickness;
    }
    let (axis, (low, high)) = (case.steepest_axis(), body.shape.bounds(case.dimension()));
    high[axis] - low[axis]
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Saturated column, 2 m high, with this dry density (kg/m³).
    fn column(density: f64) -> Case {
        let text = json!({
            "title": "column", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 3] }, "gravity": [0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": density, "youngs_modulus": 1e7, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 2] },
                "pore_fluid": { "porosity": 0.4, "permeability": 1e-3, "density": 1000, "bulk_modulus": 2e9 } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
            "stages": [{ "name": "s", "duration": 1 }]
        });
        Case::from_json(&text.to_string()).unwrap()
    }

    #[test]
    fn time_scales_follow_their_closed_forms() {
        let TimeScales { height, consolidation, wave_time, fall_time: fall } = column(1590.0).time_scales();
        assert_eq!(height, 2.0);
        // c_v = k / (γ_w (1/M + n/K)), with M = E.
        let exact = 4.0 / (1e-3 / (1e4 * (1e-7 + 0.4 / 2e9)));
        assert!((consolidation.unwrap() / exact - 1.0).abs() < 1e-12, "{consolidation:?}");
        let exact = 2.0 / ((1e7 + 2e9 / 0.4) / 1990.0_f64).sqrt();
        assert!((wave_time.unwrap() / exact - 1.0).abs() < 1e-12, "{wave_time:?}");
        assert!((fall.unwrap() - 0.2_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_density_that_implies_implausible_grain_density_causes_a_warning() {
        let doubts = |density: f64| {
            let all = column(density).warnings();
            all.into_iter()
                .map(|warning| warning.text)
                .filter(|text| text.starts_with("materials.m.density"))
                .collect::<Vec<_>>()
        };
        assert!(doubts(1590.0).is_empty());
        let doubt = doubts(2000.0).concat();
        assert!(doubt.contains("grains of 3333 kg/m³") && doubt.contains("change it to 1600"), "{doubt}");
        assert!(doubts(1200.0).concat().contains("grains of 2000 kg/m³"));
        let BodyDensities { dry, saturated, grains } =
            column(1590.0).densities(&column(1590.0).bodies[0]).unwrap();
        assert_eq!([dry, saturated, grains], [1590.0, 1990.0, 2650.0]);
    }
}
