//! Warnings that compare the extents of bodies with the domain, the measures and the resolution.

use colluvium_constitutive::Warning;

use crate::Case;
use crate::description::{Body, Side};
use crate::measure::{Measure, RunOut};

/// Sides of a domain.
const SIDES: [Side; 6] = [Side::XMin, Side::XMax, Side::YMin, Side::YMax, Side::ZMin, Side::ZMax];
/// Positions along a side at which a body is sampled.
const SAMPLES: usize = 32;
/// Share of a side of the domain that a body must cover to count as lying at it.
const COVERED_SHARE: f64 = 0.1;
/// Relative difference of the initial length of a run-out from that of the bodies, above which there is a warning.
const LENGTH_TOLERANCE: f64 = 0.02;
/// Points over the height of the bodies below which a factor of safety is too high.
const POINTS_OVER_HEIGHT: f64 = 20.0;

impl Case {
    /// Adds the warnings about extents of bodies.
    pub(super) fn warn_of_extents(&self, warnings: &mut Vec<Warning>) {
        warnings.extend(self.free_side_warnings());
        warnings.extend(self.run_out_warnings());
        warnings.extend(self.coarse_search_warnings());
    }

    /// Warnings for bodies that lie at a side of the domain without a wall, as if the ground ended there.
    fn free_side_warnings(&self) -> Vec<Warning> {
        let only_in_plan = !self.methods.is_empty() && self.methods.keys().all(|name| name == "depth-sph");
        if self.dimension() < 2
            || self.gravity_magnitude() == 0.0
            || !self.obstacles.is_empty()
            || only_in_plan
        {
            return Vec::new();
        }
        let is_supported = |side: Side| {
            let axis = side.axis();
            let outwards = if side.is_max() { 1.0 } else { -1.0 };
            let is_top = outwards * self.gravity[axis] < 0.0
                && self.gravity[axis].abs() > 0.5 * self.gravity_magnitude();
            is_top
                || self.domain.is_periodic(axis)
                || self.boundaries.iter().any(|boundary| boundary.side == side)
        };
        let mut warnings = Vec::new();
        let sides = SIDES.into_iter().filter(|side| side.axis() < self.dimension());
        for side in sides.filter(|side| !is_supported(*side)) {
            let loaded = |body: &Body| {
                self.loads.iter().any(|load| load.body() == body.name && load.loaded_side() == Some(side))
            };
            let ends_there = |body: &&Body| {
                !body.rigid && !body.remove_outside && !loaded(body) && self.lies_at(body, side)
            };
            if let Some(body) = self.bodies.iter().find(ends_there) {
                warnings.push(Warning::new(
                    "side-without-wall",
                    format!(
                        "boundaries: the body {:?} reaches the side {side} of the domain, which has no wall: it is a free \
                         face there and can flow out. Add a wall",
                        body.name
                    ),
                ));
            }
        }
        warnings
    }

    /// Whether a body covers a part of a side of the domain.
    fn lies_at(&self, body: &Body, side: Side) -> bool {
        let (axis, dimension) = (side.axis(), self.dimension());
        let (low, high) = body.shape.bounds(dimension);
        let size = self.domain.max[axis] - self.domain.min[axis];
        let (end, face, inwards) = if side.is_max() {
            (self.domain.max[axis], high[axis], -1.0)
        } else {
            (self.domain.min[axis], low[axis], 1.0)
        };
        if !((end - face).abs() <= 1e-9 * size) {
            return false;
        }
        let across = if axis == 0 { 1 } else { 0 };
        let (from, width) = (self.domain.min[across], self.domain.max[across] - self.domain.min[across]);
        let covered = (0..SAMPLES).filter(|k| {
            let mut at: Vec<f64> = (0..dimension).map(|c| 0.5 * (low[c] + high[c])).collect();
            at[axis] = end + inwards * 1e-6 * size;
            at[across] = from + width * (*k as f64 + 0.5) / SAMPLES as f64;
            at.iter().all(|x| x.is_finite()) && body.shape.contains(&at)
        });
        covered.count() as f64 > COVERED_SHARE * SAMPLES as f64
    }

    /// Warnings for run-outs whose initial length is not that of the bodies.
    fn run_out_warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        for (name, measure) in &self.measures {
            let Measure::RunOut(RunOut { side, origin, initial_length, bodies, .. }) = measure else {
                continue;
            };
            let counts = |body: &&Body| match bodies {
                Some(names) => names.contains(&body.name),
                None => !body.rigid,
            };
            let end = |body: &Body| {
                let (low, high) = body.shape.bounds(self.dimension());
                if side.is_max() { high[side.axis()] - origin } else { origin - low[side.axis()] }
            };
            let length = self.bodies.iter().filter(counts).map(end).fold(f64::NEG_INFINITY, f64::max);
            if length.is_finite() && (length - initial_length).abs() > LENGTH_TOLERANCE * length.abs() {
                warnings.push(Warning::new(
                    "run-out-length",
                    format!(
                        "measures.{name}.initial_length: is {initial_length} m, but the bodies reach {length:.6} m from its \
                         origin. Give that length, or correct the origin"
                    ),
                ));
            }
        }
        warnings
    }

    /// Warnings for searches of a factor of safety with few points over the height.
    fn coarse_search_warnings(&self) -> Vec<Warning> {
        if self.factors_of_safety().next().is_none() {
            return Vec::new();
        }
        let height = self.height();
        let spacing = |options: &serde_json::Value| options["spacing"].as_f64();
        let coarse = self.methods.iter().filter_map(|(name, options)| {
            let points = height / spacing(options)?;
            (points < POINTS_OVER_HEIGHT * (1.0 - 1e-9)).then(|| {
                Warning::new(
                    "coarse-search",
                    format!(
                        "methods.{name}.spacing: {points:.0} points over the height of {height} m are few for a factor of \
                         safety, which is then too high. Give {POINTS_OVER_HEIGHT} or more over the height of the slope"
                    ),
                )
            })
        });
        coarse.collect()
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use crate::Case;

    /// Codes of the warnings of a column between walls on a floor, changed by `change`.
    fn codes(change: impl Fn(&mut Value)) -> Vec<String> {
        let wall = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
        let mut case = json!({
            "title": "column", "space": "plane-strain", "domain": { "min": [0, 0], "max": [4, 2] }, "gravity": [0, -9.81],
            "materials": { "m": { "model": "linear-elastic", "density": 1600, "youngs_modulus": 1e8, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } }],
            "boundaries": [wall("x-min"), wall("y-min")],
            "measures": { "run": { "kind": "run-out", "side": "x-max", "origin": 0, "initial_length": 1 } },
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "sph": { "spacing": 0.05 } }
        });
        change(&mut case);
        let warnings = Case::from_json(&case.to_string()).unwrap().warnings();
        warnings.into_iter().map(|warning| warning.code.into_owned()).collect()
    }

    #[test]
    fn bodies_at_sides_without_a_wall_cause_a_warning() {
        assert!(codes(|_| {}).is_empty());
        let open: fn(&mut Value) = |case| case["boundaries"].as_array_mut().unwrap().truncate(1);
        assert!(codes(open).contains(&"side-without-wall".to_owned()));
        assert_eq!(
            codes(|case| case["domain"]["max"] = json!([4, 1])),
            Vec::<String>::new(),
            "the top is free"
        );
        // The toe of a slope touches the side in a point.
        let toe: fn(&mut Value) = |case| {
            case["bodies"][0]["shape"] = json!({ "kind": "polygon", "vertices": [[0, 0], [4, 0], [0, 1]] });
            case["measures"] = json!({});
        };
        assert!(codes(toe).is_empty());
    }

    #[test]
    fn a_run_out_of_another_length_than_that_of_the_bodies_causes_a_warning() {
        assert_eq!(codes(|case| case["bodies"][0]["shape"]["max"][0] = json!(1.5)), ["run-out-length"]);
    }

    #[test]
    fn a_search_with_few_points_over_the_height_causes_a_warning() {
        let search = |spacing: f64| {
            codes(move |case| {
                case["methods"]["sph"]["spacing"] = json!(spacing);
                case["materials"]["m"] = json!({ "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e8,
                                                 "poissons_ratio": 0.3, "friction_angle": 30, "cohesion": 1e4 });
                case["measures"] =
                    json!({ "safety": { "kind": "factor-of-safety", "after": "s", "range": [0.5, 2] } });
                case["stages"][0]["equilibrium"] = json!({});
            })
        };
        assert!(!search(0.05).contains(&"coarse-search".to_owned()));
        assert!(search(0.1).contains(&"coarse-search".to_owned()));
    }
}
