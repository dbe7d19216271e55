//! Initial stress: K0 stress by the weight of the material above (sheet: mpm §2.19).

use colluvium_constitutive::{MaterialSpec, SymTensor};

use crate::Case;
use crate::description::{Body, InitialStress, PoreFluid};
use colluvium_constitutive::Warning;

/// Sampling points per direction for the comparison of the weights above a body.
const SAMPLES: usize = 24;
/// Tolerance of the comparison of weights and heights, over the largest of them.
const WEIGHT_TOLERANCE: f64 = 1e-6;

impl Case {
    /// Initial stress of `body` at `x` (Pa, tension-positive): the effective stress with a pore fluid, the total stress for an undrained
    /// material.
    pub fn initial_stress(&self, body: &Body, x: [f64; 3]) -> SymTensor {
        match &body.stress {
            InitialStress::None => SymTensor::ZERO,
            InitialStress::Uniform { value } => SymTensor(*value),
            InitialStress::Formula { value } => SymTensor(std::array::from_fn(|c| value[c].evaluate(x))),
            InitialStress::K0 { surface, coefficient } => {
                let gravity = self.gravity3();
                let Some(axis) = self.vertical() else { return SymTensor::ZERO };
                let pore_pressure =
                    body.pore_fluid.as_ref().map_or(0.0, |fluid| fluid.pressure_at(x, gravity));
                let undrained = self.materials.get(&body.material).map_or(0.0, undrained_pressure);
                let vertical = pore_pressure + undrained - self.weight_above(x, axis, *surface, body);
                let mut effective = SymTensor::isotropic(coefficient * vertical);
                effective[axis] = vertical;
                effective - SymTensor::isotropic(undrained)
            }
        }
    }

    /// Axis of gravity; `None` without gravity.
    pub(crate) fn vertical(&self) -> Option<usize> {
        let gravity = self.gravity3();
        (0..3).find(|&axis| gravity[axis] != 0.0)
    }

    /// Weight per area (Pa) above `x`, a position in `body`: of the bodies up to the coordinate `surface` (m), and of open water up to the
    /// surface of the pore fluid of `body`. Rigid bodies do not count.
    fn weight_above(&self, x: [f64; 3], axis: usize, surface: f64, body: &Body) -> f64 {
        let gravity = self.gravity3()[axis];
        let above = |end: f64, start: f64| (start - end) * gravity.signum() > 0.0;
        let fluid = body.pore_fluid.as_ref();
        let water = fluid.and_then(|fluid| Some((fluid.surface()?, fluid.density)));
        let dimension = self.dimension();
        let crossings = self.bodies.iter().flat_map(|body| body.shape.crossings(&x[..dimension], axis));
        let ends = [surface].into_iter().chain(water.map(|(surface, _)| surface)).chain(crossings);
        let mut cuts: Vec<f64> = ends.filter(|end| above(*end, x[axis])).chain([x[axis]]).collect();
        cuts.sort_by(f64::total_cmp);
        let weight = |pair: &[f64]| {
            let mut middle = x;
            middle[axis] = 0.5 * (pair[0] + pair[1]);
            let here = self.bodies.iter().filter(|body| body.shape.contains(&middle[..dimension]));
            let here = here.min_by_key(|body| body.rigid);
            let density = match (here, water) {
                (Some(body), _) if !body.rigid && above(surface, middle[axis]) => self.bulk_density(body),
                (None, Some((surface, density))) if above(surface, middle[axis]) => density,
                _ => 0.0,
            };
            density * gravity.abs() * (pair[1] - pair[0])
        };
        cuts.windows(2).map(weight).sum()
    }

    /// Bulk density of a body with its pore fluid (kg/m³).
    pub(crate) fn bulk_density(&self, body: &Body) -> f64 {
        let own = self.materials.get(&body.material).map_or(0.0, MaterialSpec::density);
        body.pore_fluid.as_ref().map_or(own, |fluid| fluid.saturated_density(own))
    }

    /// Warns of K0 stresses that are not in equilibrium, and of surfaces above all bodies.
    pub(crate) fn warn_of_weights(&self, warnings: &mut Vec<Warning>) {
        let Some(axis) = self.vertical() else { return };
        let settles = self.stages.first().is_some_and(|stage| stage.equilibrium.is_some());
        let up = -self.gravity3()[axis].signum();
        let top = |body: &Body| {
            let (low, high) = body.shape.bounds(self.dimension());
            if up > 0.0 { high[axis] } else { -low[axis] }
        };
        let all = self.bodies.iter().filter(|b| !b.rigid).map(top).fold(f64::NEG_INFINITY, f64::max);
        let size = self.domain.max[axis] - self.domain.min[axis];
        let ramped = self.stages.first().is_some_and(|stage| stage.gravity_ramp > 0.0);
        for (number, body) in self.bodies.iter().enumerate().filter(|(_, body)| !body.rigid) {
            self.warn_of_table((number, body), axis, warnings);
            let InitialStress::K0 { surface, .. } = body.stress else { continue };
            if up * surface > all + WEIGHT_TOLERANCE * size {
                warnings.push(Warning::new(
                    "stress-surface-misplaced",
                    format!(
                        "bodies[{number}].stress.surface: {surface} m lies above all bodies, which end at {} \
                     m. The empty space above the bodies adds no weight to the stress. Set the surface to \
                     the top of the ground",
                        up * all
                    ),
                ));
            } else if up * surface < top(body) - WEIGHT_TOLERANCE * size {
                warnings.push(Warning::new(
                    "stress-surface-misplaced",
                    format!(
                        "bodies[{number}].stress.surface: {surface} m lies below the top of the body, {} m. \
                     The material above the surface adds no weight to the stress. Set the surface to the \
                     top of the ground",
                        up * top(body)
                    ),
                ));
            }
            if ramped {
                warnings.push(Warning::new(
                    "stress-with-gravity-ramp",
                    format!(
                        "bodies[{number}].stress: it is the stress under full gravity, but the first stage \
                     begins without gravity (gravity_ramp). Leave out one of the two"
                    ),
                ));
            }
            if !settles && !self.is_level(body, axis, surface) {
                warnings.push(Warning::new("stress-not-in-equilibrium", format!(
                    "bodies[{number}].stress: the weight above differs at the same height (a slope, a step, \
                     or layers that are not level), so a k0 stress is not in equilibrium. Begin with a stage \
                     that has `equilibrium`"
                )));
            }
        }
    }

    /// Warns of a water table within a body: its pores are saturated above the table too.
    fn warn_of_table(&self, (number, body): (usize, &Body), axis: usize, warnings: &mut Vec<Warning>) {
        let Some(table) = body.pore_fluid.as_ref().and_then(PoreFluid::surface) else { return };
        let (low, high) = body.shape.bounds(self.dimension());
        let slack = WEIGHT_TOLERANCE * (high[axis] - low[axis]);
        if low[axis] + slack < table && table < high[axis] - slack {
            warnings.push(Warning::new(
                "water-table-in-body",
                format!(
                    "bodies[{number}].pore_fluid.pressure.surface: {table} m lies within the body, and the \
                 pores above it are full too. The water above the surface is not in equilibrium and flows \
                 down. Split the body there, and leave out the pore fluid above"
                ),
            ));
        }
    }

    /// Whether the weight above a body is constant on each horizontal plane through it.
    fn is_level(&self, body: &Body, axis: usize, surface: f64) -> bool {
        let dimension = self.dimension();
        let (low, high) = body.shape.bounds(dimension);
        let place = |c: usize, i: usize| low[c] + (i as f64 + 0.5) / SAMPLES as f64 * (high[c] - low[c]);
        let across: Vec<usize> = (0..dimension).filter(|c| *c != axis).collect();
        let columns = SAMPLES.pow(across.len() as u32);
        let (mut differ, mut largest) = (0.0_f64, 0.0_f64);
        for height in 0..SAMPLES {
            let weights = (0..columns).filter_map(|column| {
                let mut x = [0.0; 3];
                x[axis] = place(axis, height);
                for (k, c) in across.iter().enumerate() {
                    x[*c] = place(*c, column / SAMPLES.pow(k as u32) % SAMPLES);
                }
                body.shape.contains(&x[..dimension]).then(|| self.weight_above(x, axis, surface, body))
            });
            let none = (f64::INFINITY, f64::NEG_INFINITY);
            let (smallest, maximum) = weights.fold(none, |(a, b), weight| (a.min(weight), b.max(weight)));
            differ = differ.max(maximum - smallest);
            largest = largest.max(maximum);
        }
        differ <= WEIGHT_TOLERANCE * largest
    }
}

/// Initial pore pressure (Pa) of an undrained material, including those of wrapped materials.
fn undrained_pressure(material: &MaterialSpec) -> f64 {
    let own = match material {
        MaterialSpec::Undrained(spec) => spec.initial_pore_pressure,
        _ => 0.0,
    };
    own + material.inner().map_or(0.0, undrained_pressure)
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    /// Layers of 1 m of 3000 kg/m³ over 2 m of 1000 kg/m³, under 10 m/s², with changes at JSON pointers.
    fn layers(changes: &[(&str, Value)]) -> Case {
        let soil = |density: f64| json!({ "model": "linear-elastic", "density": density, "youngs_modulus": 1e7, "poissons_ratio": 0.2 });
        let k0 = json!({ "kind": "k0", "surface": 3, "coefficient": 0.5 });
        let wall = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
        let mut case = json!({
            "title": "layers", "space": "plane-strain",
            "domain": { "min": [0, 0], "max": [8, 8] }, "gravity": [0, -10],
            "materials": { "heavy": soil(3000.0), "light": soil(1000.0) },
            "bodies": [
                { "name": "lower", "material": "light", "stress": k0, "shape": { "kind": "box", "min": [0, 0], "max": [8, 2] } },
                { "name": "upper", "material": "heavy", "stress": k0, "shape": { "kind": "box", "min": [0, 2], "max": [8, 3] } }
            ],
            "boundaries": [wall("x-min"), wall("x-max"), wall("y-min")],
            "stages": [{ "name": "go", "duration": 1 }]
        });
        for (pointer, value) in changes {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            match case.pointer_mut(parent).unwrap() {
                Value::Array(items) => items[key.parse::<usize>().unwrap()] = value.clone(),
                object => object[key] = value.clone(),
            }
        }
        Case::from_json(&case.to_string()).unwrap()
    }

    fn vertical(case: &Case, body: usize, x: [f64; 3]) -> f64 {
        case.initial_stress(&case.bodies[body], x)[1]
    }

    #[test]
    fn vertical_stress_in_a_layer_includes_the_layers_above_by_their_densities() {
        let case = layers(&[]);
        assert!((vertical(&case, 1, [1.0, 2.75, 0.0]) + 7.5e3).abs() < 1e-9);
        assert!((vertical(&case, 0, [1.0, 1.975, 0.0]) + 30.25e3).abs() < 1e-9);
        let stress = case.initial_stress(&case.bodies[0], [4.0, 1.0, 0.0]);
        assert!((stress[1] + 40e3).abs() < 1e-9 && (stress[0] + 20e3).abs() < 1e-9 && stress[2] == stress[0]);
        assert!(case.warnings().is_empty(), "{:?}", case.warnings());
    }

    #[test]
    fn depth_counts_from_the_surface_above_the_point() {
        // A slope of 45° from (2, 2) up to (3, 3).
        let slope = json!({ "kind": "polygon", "vertices": [[2, 2], [8, 2], [8, 3], [3, 3]] });
        let case = layers(&[("/bodies/1/shape", slope)]);
        assert!((vertical(&case, 1, [2.5, 2.25, 0.0]) + 7.5e3).abs() < 1e-9);
        assert!((vertical(&case, 0, [2.25, 1.5, 0.0]) + 12.5e3).abs() < 1e-9);
        assert!((vertical(&case, 0, [1.0, 1.5, 0.0]) + 5e3).abs() < 1e-9, "nothing above but its own");
        assert_eq!(vertical(&case, 1, [7.0, 3.0, 0.0]), 0.0);
    }

    #[test]
    fn material_above_the_given_surface_and_rigid_bodies_add_no_overburden() {
        let own = json!({ "kind": "k0", "surface": 2, "coefficient": 0 });
        assert!((vertical(&layers(&[("/bodies/0/stress", own)]), 0, [1.0, 1.0, 0.0]) + 10e3).abs() < 1e-9);
        let rigid =
            layers(&[("/bodies/1/rigid", json!(true)), ("/bodies/1/stress", json!({ "kind": "none" }))]);
        assert!((vertical(&rigid, 0, [1.0, 1.0, 0.0]) + 10e3).abs() < 1e-9);
        let high = json!({ "kind": "k0", "surface": 5, "coefficient": 0 });
        let high = layers(&[("/bodies/0/stress", high)]);
        assert!((vertical(&high, 0, [1.0, 1.0, 0.0]) + 40e3).abs() < 1e-9);
        assert!(
            high.warnings()[0].text.starts_with("bodies[0].stress.surface: 5 m lies above"),
            "{:?}",
            high.warnings()
        );
    }

    #[test]
    fn effective_stress_of_a_saturated_layer_is_overburden_minus_pore_pressure() {
        let water = json!({ "porosity": 0.4, "permeability": 1e-3, "pressure": { "kind": "hydrostatic", "surface": 2 } });
        let case = layers(&[("/bodies/0/pore_fluid", water)]);
        // 30 kPa of the dry layer, 1 m of 1400 kg/m³, and 10 kPa of water.
        assert!((vertical(&case, 0, [1.0, 1.0, 0.0]) + 34e3).abs() < 1e-9);
    }

    #[test]
    fn effective_stress_under_open_water_is_independent_of_the_water_depth() {
        let water = |surface: f64| json!({ "porosity": 0.4, "permeability": 1e-3, "pressure": { "kind": "hydrostatic", "surface": surface } });
        let both = |surface: f64| {
            layers(&[("/bodies/0/pore_fluid", water(surface)), ("/bodies/1/pore_fluid", water(surface))])
        };
        // The effective stress under water does not depend on the water depth: buoyant weights of 2400 and 400 kg/m³.
        for surface in [3.0, 5.0, 7.5] {
            let case = both(surface);
            assert!((vertical(&case, 1, [1.0, 2.5, 0.0]) + 12e3).abs() < 1e-9, "{surface}");
            assert!((vertical(&case, 0, [1.0, 1.0, 0.0]) + 28e3).abs() < 1e-9, "{surface}");
            assert!(vertical(&case, 1, [1.0, 3.0, 0.0]).abs() < 1e-9, "{surface}");
        }
        // Also under a slope, where water fills the space above the ground.
        let slope = json!({ "kind": "polygon", "vertices": [[2, 2], [8, 2], [8, 3], [3, 3]] });
        let changes = [
            ("/bodies/1/shape", slope),
            ("/bodies/0/pore_fluid", water(4.0)),
            ("/bodies/1/pore_fluid", water(4.0)),
        ];
        assert!((vertical(&layers(&changes), 0, [1.0, 1.5, 0.0]) + 2e3).abs() < 1e-9);
    }

    #[test]
    fn the_ratio_holds_for_the_effective_stress_of_an_undrained_layer() {
        let skeleton = json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.2 });
        let clay = json!({ "model": "undrained", "fluid_bulk_modulus": 2e9, "porosity": 0.4,
                           "initial_pore_pressure": 6000, "skeleton": skeleton });
        let drying = json!({ "model": "eigenstrain", "volumetric_strain": 0, "duration": 1, "material": clay.clone() });
        for material in [clay, drying] {
            let case = layers(&[("/materials/light", material)]);
            let stress = case.initial_stress(&case.bodies[0], [4.0, 1.0, 0.0]);
            // 40 kPa in total, 34 kPa of them effective.
            let exact = [-23e3, -40e3, -23e3, 0.0, 0.0, 0.0];
            assert!(stress.0.iter().zip(exact).all(|(s, e)| (s - e).abs() < 1e-9), "{stress:?}");
        }
    }

    #[test]
    fn surfaces_below_ground_gravity_ramps_and_water_tables_in_the_ground_cause_warnings() {
        let one = |changes: &[(&str, Value)], word: &str| {
            let warnings = layers(changes).warnings();
            assert!(warnings.iter().any(|warning| warning.text.contains(word)), "{word}: {warnings:?}");
        };
        let low = json!({ "kind": "k0", "surface": 1.5, "coefficient": 0 });
        one(&[("/bodies/0/stress", low)], "1.5 m lies below the top of the body");
        one(
            &[("/stages", json!([{ "name": "g", "duration": 1, "gravity_ramp": 0.5 }]))],
            "the stress under full gravity",
        );
        let water = json!({ "porosity": 0.4, "permeability": 1e-3, "pressure": { "kind": "hydrostatic", "surface": 1 } });
        one(&[("/bodies/0/pore_fluid", water)], "1 m lies within the body");
    }

    #[test]
    fn k0_stress_under_a_slope_causes_a_warning_without_an_equilibrium_stage() {
        let slope = json!({ "kind": "polygon", "vertices": [[0, 2], [8, 2], [8, 3], [1, 3]] });
        let tilted = layers(&[("/bodies/1/shape", slope.clone())]).warnings();
        assert_eq!(tilted.len(), 2, "both layers: {tilted:?}");
        assert!(tilted[0].text.starts_with("bodies[0].stress: the weight above differs"), "{tilted:?}");
        let settle =
            json!([{ "name": "settle", "duration": 9, "equilibrium": {} }, { "name": "go", "duration": 1 }]);
        assert!(layers(&[("/bodies/1/shape", slope), ("/stages", settle)]).warnings().is_empty());
    }
}
