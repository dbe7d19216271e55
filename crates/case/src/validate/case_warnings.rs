//! Warnings about valid cases.

use std::path::Path;

use colluvium_points::common_interior_point;

use crate::Case;
use crate::description::OVERLAP_RESOLUTION;
use crate::description::{Body, Boundary, Load, Stage, Wall};
use crate::files::terrain_files;
use colluvium_constitutive::Warning;

/// Sample points along each axis of a side.
const SAMPLES: usize = 32;

/// Distance of the sample points from a side, over the size of the domain.
const PROBE_DISTANCE: f64 = 1e-6;

impl Case {
    /// Warnings about a valid case.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        for (name, spec) in &self.materials {
            if !self.bodies.iter().any(|body| body.material == *name) {
                warnings.push(Warning::new(
                    "unused-material",
                    format!("materials.{name}: no body is made of it"),
                ));
            }
            for (number, body) in self.bodies.iter().enumerate().filter(|(_, body)| body.material == *name) {
                let Some(fluid) = &body.pore_fluid else { continue };
                if spec.density() <= (1.0 - fluid.porosity) * fluid.density {
                    let grains = spec.density() / (1.0 - fluid.porosity);
                    warnings.push(Warning::new("light-grains", format!(
                        "bodies[{number}].pore_fluid.density: {} kg/m³ is not below the density of the \
                         grains, {grains:.0} kg/m³ (density of {name:?} over 1 - porosity). Give the material \
                         its dry density, or correct the porosity or this density",
                        fluid.density
                    )));
                }
            }
            warnings
                .extend(spec.warnings().into_iter().map(|warning| warning.at(format!("materials.{name}"))));
        }
        warnings.extend(self.reference_system_warning());
        self.warn_of_grains(&mut warnings);
        self.warn_of_weights(&mut warnings);
        self.warn_of_units(&mut warnings);
        warnings.extend(self.unlimited_fall_warning());
        warnings.extend(self.closed_liquid());
        self.warn_of_walls(&mut warnings);
        self.warn_of_extents(&mut warnings);
        match self.dimension() {
            2 => self.warn_of_obstacles::<2>(&mut warnings),
            3 => self.warn_of_obstacles::<3>(&mut warnings),
            _ => {}
        }
        self.warn_of_searches(&mut warnings);
        self.warn_of_excavations(&mut warnings);
        self.warn_of_removal_shapes(&mut warnings);
        self.warn_of_overlaps(&mut warnings);
        self.warn_of_heights(&mut warnings);
        for (number, load) in self.loads.iter().enumerate() {
            self.warn_of_load(number, load, &mut warnings);
        }
        warnings
    }

    /// Warning where two map files have coordinate reference systems that may differ.
    fn reference_system_warning(&self) -> Option<Warning> {
        let mut case = self.clone();
        let systems: Vec<_> = case
            .files()
            .filter_map(|file| {
                Some((file.clone(), terrain_files::read_reference_system(Path::new(file.as_str()))?))
            })
            .collect();
        let (first, known) = systems.first()?;
        let (other, unknown) = systems.iter().find(|(_, system)| !system.is_comparable(known))?;
        Some(Warning::new(
            "crs-not-comparable",
            format!(
                "{other} is in the coordinate reference system {unknown}, and {first} in {known}. The program \
             cannot decide whether the two systems are the same. Save both files in one system, with its \
             EPSG number"
            ),
        ))
    }

    /// Warning where gravity acts and nothing limits the fall of the bodies.
    fn unlimited_fall_warning(&self) -> Option<Warning> {
        let stops = |boundary: &Boundary| {
            let outwards = if boundary.side.is_max() { 1.0 } else { -1.0 };
            let against = outwards * self.gravity[boundary.side.axis()] > 0.0;
            against || boundary.group.is_some() || !matches!(boundary.wall, Wall::Smooth)
        };
        let of_body = |own: &serde_json::Value| own.get("held").is_some_and(|held| held == true);
        let of_method = |options: &serde_json::Value| {
            let bodies = options.get("bodies").and_then(serde_json::Value::as_object);
            options.get("held").is_some() || bodies.is_some_and(|bodies| bodies.values().any(of_body))
        };
        let held = self.bodies.iter().any(|body| body.rigid) || self.methods.values().any(of_method);
        let bound = held
            || !self.obstacles.is_empty()
            || !self.patches.is_empty()
            || self.boundaries.iter().any(stops);
        let falls = self.gravity.iter().any(|g| *g != 0.0) && !bound;
        falls.then(|| {
            Warning::new("unlimited-fall", "gravity: no wall and no obstacle stops the fall of the bodies, so they leave the domain. Give \
             `boundaries` a wall at the lower end, or add an obstacle")
        })
    }

    /// Warns of walls with material on both sides.
    fn warn_of_walls(&self, warnings: &mut Vec<Warning>) {
        for (number, boundary) in self.boundaries.iter().enumerate() {
            let (axis, place) = (boundary.side.axis(), boundary.wall_coordinate(&self.domain));
            let slack = PROBE_DISTANCE * (self.domain.max[axis] - self.domain.min[axis]);
            let stands_in = |body: &&Body| {
                let (low, high) = body.shape.bounds(self.dimension());
                !body.rigid && low[axis] + slack < place && place < high[axis] - slack
            };
            if let Some(body) = self.bodies.iter().find(stands_in) {
                let (low, high) = body.shape.bounds(self.dimension());
                warnings.push(Warning::new("body-beyond-wall", format!(
                    "boundaries[{number}].position: the body {:?} reaches beyond the wall at {place} m, from \
                     {} to {} m. Move the wall to a face of the body, or cut the body there",
                    body.name, low[axis], high[axis]
                )));
            }
        }
    }

    /// Warns of obstacles at rest that are outside the domain. Unreadable surfaces are reported elsewhere.
    fn warn_of_obstacles<const D: usize>(&self, warnings: &mut Vec<Warning>) {
        for standing in self.placed_obstacles::<D>().iter().flatten().filter(|s| s.obstacle.motion.is_none())
        {
            let (low, high) = standing.surface.bounds();
            if let Some(apart) = self.outside_extent(&low, &high, false) {
                let number = standing.number;
                warnings.push(Warning::new(
                    "obstacle-outside-domain",
                    format!(
                        "obstacles[{number}].shape: lies outside the domain and has no effect: it reaches \
                     {apart}. Move it, or correct the domain or domain.origin"
                    ),
                ));
            }
        }
    }

    /// Warns of searches for a factor of safety from a state that may not be at rest.
    fn warn_of_searches(&self, warnings: &mut Vec<Warning>) {
        for (name, search) in self.factors_of_safety() {
            let rests = |stage: &Stage| stage.name == search.after && stage.equilibrium.is_some();
            if !self.stages.iter().any(rests) {
                warnings.push(Warning::new("search-not-from-rest", format!(
                    "measures.{name}.after: the stage {:?} may not end at rest (it has no `equilibrium`), \
                     but trials begin from its end. Give the stage `equilibrium`",
                    search.after
                )));
            }
        }
    }

    /// Warns of excavation regions without a body.
    fn warn_of_excavations(&self, warnings: &mut Vec<Warning>) {
        for (stage, of_stage) in self.stages.iter().enumerate() {
            for (number, region) in of_stage.excavate.iter().enumerate() {
                let is_there = |body: &Body| {
                    common_interior_point(&body.shape, region, self.dimension(), OVERLAP_RESOLUTION).is_some()
                };
                if !self.bodies.iter().any(is_there) {
                    warnings.push(Warning::new(
                        "empty-excavation",
                        format!(
                            "stages[{stage}].excavate[{number}]: no body is there at the start. Correct \
                               the region, or leave it out"
                        ),
                    ));
                }
            }
        }
    }

    /// Warns of removal shapes whose swept region contains no body at the start.
    fn warn_of_removal_shapes(&self, warnings: &mut Vec<Warning>) {
        for (number, cut) in self.removal_shapes.iter().enumerate() {
            let sweep = cut.swept_region(0.0, self.end_time(), &cut.bounds(self.dimension()));
            let meets = |body: &&Body| {
                let (low, high) = body.shape.bounds(self.dimension());
                let overlap = |axis: usize| {
                    low[axis] <= sweep.bounds()[axis][1] && high[axis] >= sweep.bounds()[axis][0]
                };
                cut.applies_to(&body.name) && (0..self.dimension()).all(overlap)
            };
            if !self.bodies.iter().any(|body| meets(&body)) {
                warnings.push(Warning::new(
                    "cut-misses-bodies",
                    format!(
                        "removal_shapes[{number}]: no body that it cuts lies in its path at the start. Check \
                     shape, velocity, start and bodies"
                    ),
                ));
            }
        }
    }

    /// Warns of loads on a side that is not, or not entirely, free and flat.
    fn warn_of_load(&self, number: usize, load: &Load, warnings: &mut Vec<Warning>) {
        let Some(body) = self.bodies.iter().find(|body| body.name == load.body()) else { return };
        let (Some(side), dimension) = (load.loaded_side(), self.dimension()) else { return };
        let (axis, outwards) = (side.axis(), if side.is_max() { 1.0 } else { -1.0 });
        let (low, high) = body.shape.bounds(dimension);
        let face = if side.is_max() { high[axis] } else { low[axis] };
        let step = outwards * PROBE_DISTANCE * (self.domain.max[axis] - self.domain.min[axis]);
        let path = format!("loads[{number}].side");
        let holds = |boundary: &&Boundary| {
            let place = boundary.wall_coordinate(&self.domain);
            boundary.side == side
                && outwards * (place - face) <= step.abs()
                && supports_load(&boundary.wall, load, axis)
        };
        let removed = |boundary: &&Boundary| {
            self.stages.iter().any(|stage| stage.remove_boundaries.iter().any(|name| name == boundary.name()))
        };
        if let Some(wall) = self.boundaries.iter().filter(holds).find(|wall| !removed(wall)) {
            warnings.push(Warning::new("load-on-wall", format!(
                "{path}: the wall {:?} fixes that side and takes the load. Load another side, or remove the \
                 wall before the load acts",
                wall.name()
            )));
        }
        let (loaded, flat, neighbours) = self.side_samples(load, body, (axis, face, step));
        let percent = |part: usize, whole: usize| (100.0 * part as f64 / whole.max(1) as f64).round();
        if loaded == 0 {
            warnings.push(Warning::new("load-without-effect", format!(
                "{path}: its profile is zero on the whole side of the body, which begins at {low:?} and ends \
                 at {high:?} m. Correct the positions of the profile"
            )));
        } else if flat < loaded {
            warnings.push(Warning::new("load-on-uneven-side", format!(
                "{path}: it acts where the body reaches {face} m along that axis, {} % of its width. To load \
                 the rest too, split the body and give each part a load",
                percent(flat, loaded)
            )));
        }
        for (touches, other) in neighbours.iter().zip(&self.bodies).filter(|(touches, _)| **touches > 0) {
            warnings.push(Warning::new("load-on-covered-side", format!(
                "{path}: {} % of it is not a free surface: the body {:?} lies there. Load that body, or end \
                 the profile there",
                percent(*touches, flat),
                other.name
            )));
        }
    }

    /// Sample points of a loaded side normal to `axis` at `face` (m): those under a load, those of them on the flat face, and those of the
    /// latter that each body covers. `step` (m) leads out of the body.
    fn side_samples(
        &self,
        load: &Load,
        body: &Body,
        (axis, face, step): (usize, f64, f64),
    ) -> (usize, usize, Vec<usize>) {
        let dimension = self.dimension();
        let (low, high) = body.shape.bounds(dimension);
        let (mut loaded, mut flat) = (0usize, 0usize);
        let mut neighbours = vec![0usize; self.bodies.len()];
        for sample in 0..SAMPLES.pow(dimension as u32 - 1) {
            let mut at = vec![face; dimension];
            let mut rest = sample;
            for c in (0..dimension).filter(|c| *c != axis) {
                at[c] = low[c] + (high[c] - low[c]) * ((rest % SAMPLES) as f64 + 0.5) / SAMPLES as f64;
                rest /= SAMPLES;
            }
            if load.profile_factor(&at) == 0.0 {
                continue;
            }
            loaded += 1;
            at[axis] = face - step;
            if !body.shape.contains(&at) {
                continue;
            }
            flat += 1;
            at[axis] = face + step;
            for (touches, other) in neighbours.iter_mut().zip(&self.bodies) {
                *touches += usize::from(other.shape.contains(&at));
            }
        }
        (loaded, flat, neighbours)
    }
}

/// Whether a wall normal to `axis` supports a load on the side that it constrains.
fn supports_load(wall: &Wall, load: &Load, axis: usize) -> bool {
    match (wall, load) {
        (Wall::Absorbing { .. }, _) | (_, Load::PorePressure { .. }) => false,
        (Wall::Rough, _) => true,
        (_, Load::Traction { value, .. }) => value.get(axis).is_some_and(|normal| *normal != 0.0),
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// Warnings for a block of 1 m on the floor of its domain with a pressure on `side`, changed by `change`.
    fn warnings(side: &str, change: impl Fn(&mut Value)) -> Vec<Warning> {
        let mut case = json!({
            "title": "block", "space": "plane-strain", "domain": { "min": [0, 0], "max": [4, 2] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [1, 0], "max": [2, 1] } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
            "loads": [{ "kind": "pressure", "body": "b", "side": side, "value": 1 }],
            "stages": [{ "name": "s", "duration": 1 }]
        });
        change(&mut case);
        Case::from_json(&case.to_string()).unwrap().warnings()
    }

    #[test]
    fn a_load_on_a_free_flat_side_causes_no_warning() {
        for side in ["x-min", "x-max", "y-max"] {
            assert_eq!(warnings(side, |_| {}), Vec::<Warning>::new(), "{side}");
        }
    }

    #[test]
    fn gravity_without_a_supporting_wall_causes_a_warning() {
        let falls = |gravity: [f64; 2], change: fn(&mut Value)| {
            let all = warnings("y-max", |case| {
                case["gravity"] = json!(gravity);
                change(case);
            });
            all.iter()
                .any(|warning| warning.text.starts_with("gravity: no wall and no obstacle stops the fall"))
        };
        assert!(!falls([0.0, -9.81], |_| {}) && !falls([0.0, 0.0], |case| case["boundaries"] = json!([])));
        assert!(falls([0.0, 9.81], |_| {}) && falls([0.0, -9.81], |case| case["boundaries"] = json!([])));
        assert!(falls([-9.81, 0.0], |_| {}), "a smooth floor holds nothing along it");
        assert!(!falls([-9.81, 0.0], |case| {
            case["methods"] = json!({ "dem": { "bodies": { "b": { "held": true } } } });
        }));
        assert!(falls([-9.81, 0.0], |case| {
            case["methods"] = json!({ "dem": { "bodies": { "b": { "held": false } } } });
        }));
        assert!(!falls([-9.81, 0.0], |case| case["boundaries"][0]["wall"]["kind"] = json!("rough")));
        assert!(!falls([0.0, 9.81], |case| {
            case["obstacles"] = json!([{ "name": "o", "shape": { "kind": "ball", "centre": [2, 1.8], "radius": 0.1 },
                                         "wall": { "kind": "rough" } }]);
        }));
    }

    #[test]
    fn loads_on_a_side_with_a_wall_cause_warnings() {
        let floor = warnings("y-min", |_| {});
        assert!(
            floor.len() == 1
                && floor[0].text.contains("loads[0].side")
                && floor[0].text.contains("takes the load"),
            "{floor:?}"
        );
        // A load along a wall acts at a smooth wall, but not at a rough one.
        let shear = |wall: &'static str| {
            warnings("y-min", move |case| {
                case["loads"][0] =
                    json!({ "kind": "traction", "body": "b", "side": "y-min", "value": [1, 0] });
                case["boundaries"][0]["wall"]["kind"] = json!(wall);
            })
        };
        assert_eq!((shear("smooth").len(), shear("rough").len()), (0, 1));
        let for_a_while = warnings("y-min", |case| {
            case["boundaries"][0]["name"] = json!("floor");
            case["stages"][0]["remove_boundaries"] = json!(["floor"]);
        });
        assert_eq!(for_a_while, Vec::<Warning>::new());
    }

    #[test]
    fn loads_on_slopes_and_between_bodies_cause_warnings() {
        let slope = warnings("y-max", |case| {
            case["bodies"][0]["shape"] =
                json!({ "kind": "polygon", "vertices": [[1, 0], [2, 0], [2, 1], [1.75, 1]] });
        });
        assert!(
            slope.len() == 1 && slope[0].text.contains("reaches 1 m") && slope[0].text.contains("25 %"),
            "{slope:?}"
        );
        let beside = |case: &mut Value| {
            let shape = json!({ "kind": "box", "min": [2, 0], "max": [3, 0.5] });
            case["bodies"]
                .as_array_mut()
                .unwrap()
                .push(json!({ "name": "next", "material": "m", "shape": shape }));
        };
        let between = warnings("x-max", beside);
        assert!(
            between.len() == 1 && between[0].text.contains("50 %") && between[0].text.contains("next"),
            "{between:?}"
        );
        let strip = |low: f64, high: f64| {
            warnings("x-max", move |case| {
                beside(case);
                let shares = json!([[low, 0], [low, 1], [high, 1], [high, 0]]);
                case["loads"][0]["profile"] = json!({ "axis": "y", "shares": shares });
            })
        };
        assert_eq!(strip(0.5, 1.0), Vec::<Warning>::new(), "above the other body");
        let nothing = strip(1.5, 2.0);
        assert!(nothing.len() == 1 && nothing[0].text.contains("is zero on the whole side"), "{nothing:?}");
    }

    #[test]
    fn walls_through_bodies_and_empty_excavations_cause_warnings() {
        let cut = warnings("y-max", |case| {
            case["boundaries"] = json!([{ "side": "x-min", "position": 1.5, "wall": { "kind": "smooth" } }]);
        });
        assert!(
            cut.len() == 1 && cut[0].text.starts_with("boundaries[0].position: the body \"b\""),
            "{cut:?}"
        );
        let nothing = warnings("y-max", |case| {
            case["stages"][0]["excavate"] = json!([{ "kind": "box", "min": [3, 0], "max": [4, 1] }]);
        });
        assert!(
            nothing.len() == 1 && nothing[0].text.starts_with("stages[0].excavate[0]: no body"),
            "{nothing:?}"
        );
    }

    #[test]
    fn a_fixed_obstacle_outside_the_domain_causes_a_warning() {
        let with = |obstacle: Value| {
            warnings("y-max", move |case| {
                case["domain"] = json!({ "min": [5e5, 0], "max": [5e5 + 4.0, 2], "origin": [5e5, 0] });
                case["bodies"][0]["shape"] =
                    json!({ "kind": "box", "min": [5e5 + 1.0, 0], "max": [5e5 + 2.0, 1] });
                case["obstacles"] = json!([obstacle]);
            })
        };
        let ball = |x: f64| json!({ "name": "o", "shape": { "kind": "ball", "centre": [x, 1], "radius": 0.5 }, "wall": { "kind": "rough" } });
        let found = with(ball(3.0));
        let expected = "obstacles[0].shape: lies outside the domain and has no effect: it reaches from 2.5 to \
                        3.5 m along x, the domain from 500000 to 500004 m";
        assert_eq!(found.iter().filter(|warning| warning.text.starts_with(expected)).count(), 1, "{found:?}");
        assert!(!with(ball(5e5 + 3.0)).iter().any(|warning| warning.text.starts_with("obstacles")));
        let mut moving = ball(3.0);
        moving["motion"] = json!({ "velocity": [1, 0] });
        assert!(!with(moving).iter().any(|warning| warning.text.starts_with("obstacles")));
    }
}
