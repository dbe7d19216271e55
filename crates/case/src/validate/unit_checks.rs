//! Warnings about numbers that are probably in another unit.

use colluvium_constitutive::Warning;

use crate::Case;
use crate::description::{ObstacleWall, Wall};

/// Densities (kg/m³) under gravity without a warning.
const DENSITIES: std::ops::RangeInclusive<f64> = 20.0..=12_000.0;
/// Friction angle (degrees) below which there is a warning: it is probably in radians, or a coefficient.
const MIN_FRICTION_ANGLE: f64 = 2.0;
/// Cohesion over the weight of the bodies' height below which there is a warning: it is probably in kPa.
const MIN_COHESION: f64 = 1e-3;
/// Weight of the bodies' height over the P-wave modulus above which there is a warning for a soil.
const MAX_COMPRESSION: f64 = 0.3;
/// Weight of the bodies' height over the bulk modulus above which there is a warning for a liquid: waves are then slower than five times the
/// speed of free fall over that height.
const MAX_COMPRESSION_OF_LIQUID: f64 = 0.02;
/// Friction coefficient above which there is a warning: that of 63 degrees.
const MAX_FRICTION_COEFFICIENT: f64 = 2.0;

impl Case {
    /// Warnings about gravity that points up and about friction coefficients that are probably angles.
    pub(super) fn warn_of_units(&self, warnings: &mut Vec<Warning>) {
        if let (Some(component), Some(axis)) =
            (self.gravity.last(), ["y", "z"].get(self.dimension().wrapping_sub(2)))
            && *component > 0.0
        {
            warnings.push(Warning::new(
                "doubtful-unit",
                format!("gravity: points up, along +{axis}. Check its sign"),
            ));
        }
        for (path, coefficient) in self.wall_friction_coefficients() {
            warnings.extend(friction_warning(&path, coefficient));
        }
        if self.gravity_magnitude() > 0.0 {
            self.warn_of_materials(warnings);
        }
    }

    /// Warnings about parameters of materials that do not fit the weight of the bodies.
    fn warn_of_materials(&self, warnings: &mut Vec<Warning>) {
        let height = self.height();
        for (name, spec) in &self.materials {
            let Some(body) = self.bodies.iter().find(|body| body.material == *name && !body.rigid) else {
                continue;
            };
            let mut doubt = |problem: String| {
                warnings.push(Warning::new("doubtful-unit", format!("materials.{name}{problem}")));
            };
            let density = spec.density();
            if !DENSITIES.contains(&density) {
                doubt(format!(
                    ".density: {density} kg/m³ is that of no soil, snow or liquid. Check the unit (kg/m³)"
                ));
                continue;
            }
            let weight = density * self.gravity_magnitude() * height;
            let parameters = serde_json::to_value(spec).unwrap_or_default();
            let number = |key: &str| parameters[key].as_f64();
            if let Some(angle) =
                number("friction_angle").filter(|angle| *angle > 0.0 && *angle < MIN_FRICTION_ANGLE)
            {
                doubt(format!(
                    ".friction_angle: {angle} degrees is nearly no friction. In radians it would be {:.1} degrees, as a \
                     coefficient {:.1} degrees. Give degrees",
                    angle.to_degrees(),
                    angle.atan().to_degrees()
                ));
            }
            for key in ["cohesion", "undrained_strength"] {
                let value = number(key).filter(|value| *value > 0.0 && *value < MIN_COHESION * weight);
                if let Some(value) = value {
                    doubt(format!(
                        ".{key}: {value} Pa is less than a thousandth of the weight of the bodies' height, \
                         {weight:.3e} Pa. Check the unit (Pa)"
                    ));
                }
            }
            let limit = if spec.is_fluid() { MAX_COMPRESSION_OF_LIQUID } else { MAX_COMPRESSION };
            if let Some(modulus) = self.modulus(body).filter(|modulus| weight > limit * modulus) {
                doubt(format!(
                    ": the weight of the bodies' height, {weight:.3e} Pa, is {:.1} % of the modulus, {modulus:.3e} Pa, \
                     and compresses the material. Check the unit (Pa), or give a stiffer material",
                    100.0 * weight / modulus
                ));
            }
        }
    }

    /// Friction coefficients of walls and obstacles, with their paths.
    fn wall_friction_coefficients(&self) -> Vec<(String, f64)> {
        let mut found = Vec::new();
        for (number, boundary) in self.boundaries.iter().enumerate() {
            if let Wall::Frictional { friction_coefficient, .. } = boundary.wall {
                found.push((format!("boundaries[{number}].wall"), friction_coefficient));
            }
        }
        let mut add = |path: String, wall: ObstacleWall| {
            if let ObstacleWall::Frictional { friction_coefficient, .. } = wall {
                found.push((path, friction_coefficient));
            }
        };
        for (number, obstacle) in self.obstacles.iter().enumerate() {
            add(format!("obstacles[{number}].wall"), obstacle.wall);
            for (region, part) in obstacle.regions.iter().enumerate() {
                add(format!("obstacles[{number}].regions[{region}].wall"), part.wall);
            }
        }
        found.into_iter().map(|(path, value)| (format!("{path}.friction_coefficient"), value)).collect()
    }
}

/// Warning for a friction coefficient (-) at a path that is probably an angle in degrees.
pub fn friction_warning(path: &str, coefficient: f64) -> Option<Warning> {
    (coefficient > MAX_FRICTION_COEFFICIENT).then(|| {
        let tangent = coefficient.to_radians().tan();
        let hint = if (5.0..80.0).contains(&coefficient) {
            format!(", {tangent:.4} for {coefficient} degrees")
        } else {
            String::new()
        };
        Warning::new(
            "large-friction-coefficient",
            format!(
                "{path}: {coefficient} is more than the friction of soil, snow or grains on any surface \
                 ({MAX_FRICTION_COEFFICIENT}). It is the tangent of an angle{hint}; for a surface without sliding, \
                 use a rough wall"
            ),
        )
    })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use crate::Case;

    #[test]
    fn parameters_that_do_not_fit_the_weight_are_doubtful() {
        let doubtful = |key: &str, value: f64| {
            let mut sand = json!({ "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 2e6,
                                   "poissons_ratio": 0.3, "friction_angle": 33, "cohesion": 100 });
            sand[key] = json!(value);
            let case = json!({
                "title": "block", "space": "plane-strain", "domain": { "min": [0, 0], "max": [4, 2] }, "gravity": [0, -9.81],
                "materials": { "sand": sand },
                "bodies": [{ "name": "b", "material": "sand", "shape": { "kind": "box", "min": [1, 0], "max": [2, 1] } }],
                "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
                "stages": [{ "name": "s", "duration": 1 }]
            });
            let warnings = Case::from_json(&case.to_string()).unwrap().warnings();
            let texts = warnings.into_iter().filter(|warning| warning.code == "doubtful-unit");
            texts.map(|warning| warning.text).collect::<Vec<_>>().join("; ")
        };
        assert_eq!(doubtful("density", 1800.0), "");
        for (key, value, start) in [
            ("density", 1.6, "materials.sand.density: 1.6 kg/m³"),
            ("friction_angle", 0.576, "materials.sand.friction_angle: 0.576 degrees"),
            ("cohesion", 5.0, "materials.sand.cohesion: 5 Pa"),
            ("youngs_modulus", 2e4, "materials.sand: the weight"),
        ] {
            let text = doubtful(key, value);
            assert!(text.starts_with(start) && !text.contains("; "), "{key}: {text}");
        }
    }

    #[test]
    fn gravity_that_points_up_and_friction_in_degrees_are_doubtful() {
        let texts = |gravity: [f64; 2], friction: f64| {
            let wall = json!({ "kind": "frictional", "friction_coefficient": friction });
            let case = json!({
                "title": "block", "space": "plane-strain", "domain": { "min": [0, 0], "max": [4, 2] }, "gravity": gravity,
                "materials": { "m": { "model": "linear-elastic", "density": 1600, "youngs_modulus": 1e8, "poissons_ratio": 0 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [1, 0], "max": [2, 1] } }],
                "boundaries": [{ "side": "y-min", "wall": wall }, { "side": "y-max", "wall": { "kind": "smooth" } }],
                "obstacles": [{ "name": "o", "wall": wall, "shape": { "kind": "plane", "point": [0, 0.0], "normal": [0, 1] } }],
                "stages": [{ "name": "s", "duration": 1 }]
            });
            let warnings = Case::from_json(&case.to_string()).unwrap().warnings();
            let doubtful = warnings
                .into_iter()
                .filter(|warning| ["doubtful-unit", "large-friction-coefficient"].contains(&&*warning.code));
            doubtful.map(|warning| warning.text).collect::<Vec<_>>()
        };
        assert!(texts([1.0, -9.81], 0.7).is_empty());
        let found = texts([0.0, 9.81], 35.0);
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found[0].starts_with("gravity: points up, along +y"), "{found:?}");
        assert!(found[1].starts_with("boundaries[0].wall.friction_coefficient: 35 is more"), "{found:?}");
        assert!(found[1].contains("0.7002 for 35 degrees"), "{found:?}");
        assert!(found[2].starts_with("obstacles[0].wall.friction_coefficient"), "{found:?}");
    }
}
