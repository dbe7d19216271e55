//! Check of liquids without tensile strength in closed boxes.

use colluvium_constitutive::MaterialSpec;

use crate::Case;
use crate::description::{Body, InitialStress};
use colluvium_constitutive::Warning;

/// Share of the domain above which bodies fill it without a free surface.
const FULL_DOMAIN_FRACTION: f64 = 0.99;

impl Case {
    /// Warning about liquids that fill the domain without tensile strength or pressure: they cavitate where they move.
    pub(crate) fn closed_liquid(&self) -> Option<Warning> {
        let opens = |body: &Body| match self.materials.get(&body.material) {
            Some(MaterialSpec::NewtonianFluid(liquid)) => {
                liquid.cavitation_strength == 0.0 && matches!(body.stress, InitialStress::None)
            }
            _ => false,
        };
        let weightless = self.gravity.iter().all(|g| *g == 0.0);
        let body = self.bodies.iter().find(|body| opens(body)).filter(|_| weightless)?;
        let dimension = self.dimension();
        let size: f64 = self.domain.min.iter().zip(&self.domain.max).map(|(min, max)| max - min).product();
        let filled: f64 = self.bodies.iter().map(|body| body.shape.volume(dimension, false)).sum();
        (filled >= FULL_DOMAIN_FRACTION * size).then(|| {
            Warning::new(
                "closed-liquid",
                format!(
                    "materials.{}.cavitation_strength: it is 0, and the liquid fills the domain without a \
                 pressure at the start. As soon as it moves, voids open where its pressure falls below zero. \
                 Give a cavitation_strength of several times ρ v², or give the body {:?} a pressure as \
                 `stress`",
                    body.material, body.name
                ),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use crate::Case;

    fn has_warning(top: f64, change: &dyn Fn(&mut Value)) -> bool {
        let mut text = json!({
            "title": "box", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, 0],
            "materials": { "m": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 1 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, top] } }],
            "stages": [{ "name": "s", "duration": 1 }]
        });
        change(&mut text);
        let warnings = Case::from_json(&text.to_string()).unwrap().warnings();
        warnings.iter().any(|warning| {
            warning.text.contains("materials.m.cavitation_strength") && warning.text.contains("voids")
        })
    }

    #[test]
    fn a_liquid_without_tensile_strength_in_a_full_box_causes_a_warning() {
        assert!(has_warning(1.0, &|_| {}));
        assert!(!has_warning(0.9, &|_| {}), "it has a free surface");
        assert!(!has_warning(1.0, &|case| case["gravity"] = json!([0, -9.81])), "weight presses it together");
        assert!(!has_warning(1.0, &|case| case["materials"]["m"]["cavitation_strength"] = json!(1e6)));
        let pressed = json!({ "kind": "uniform", "value": [-1e4, -1e4, -1e4, 0, 0, 0] });
        assert!(!has_warning(1.0, &|case| case["bodies"][0]["stress"] = pressed.clone()));
    }
}
