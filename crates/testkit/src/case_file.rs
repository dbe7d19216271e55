//! Builder of cases.

use colluvium_case::{Case, CaseErrors, Method, RunReport, Solver};
use serde_json::{Map, Value, json};

use crate::pairwise::set_value;
use crate::solver_runs;

/// Case under construction: the JSON of a case file, changed key by key. Invalid use is an error of the test and panics.
#[derive(Clone, Debug)]
pub struct CaseBuilder(Value);

impl CaseBuilder {
    /// Case in a space (`1d`, `plane-strain`, `axisymmetric`, `3d`) over a domain (m), without gravity, bodies and stages.
    pub fn new(space: &str, min: &[f64], max: &[f64]) -> Self {
        Self(json!({
            "title": "test", "space": space,
            "domain": { "min": min, "max": max }, "gravity": vec![0.0; min.len()]
        }))
    }

    /// Case in plane strain over a rectangle (m), without gravity, bodies and stages.
    pub fn plane_strain(min: [f64; 2], max: [f64; 2]) -> Self {
        Self::new("plane-strain", &min, &max)
    }

    /// Case of a complete text.
    pub fn from_json(text: Value) -> Self {
        Self(text)
    }

    /// Adds a material.
    #[must_use]
    pub fn material(self, name: &str, law: Value) -> Self {
        self.insert("materials", name, law)
    }

    /// Adds a linear-elastic material of a density (kg/m³), Young's modulus (Pa) and Poisson's ratio.
    #[must_use]
    pub fn elastic(self, name: &str, density: f64, youngs_modulus: f64, poissons_ratio: f64) -> Self {
        let law = json!({
            "model": "linear-elastic", "density": density,
            "youngs_modulus": youngs_modulus, "poissons_ratio": poissons_ratio
        });
        self.material(name, law)
    }

    /// Adds a body.
    #[must_use]
    pub fn body(self, body: Value) -> Self {
        self.push("bodies", body)
    }

    /// Adds a body that is a box (m).
    #[must_use]
    pub fn box_body(self, name: &str, material: &str, min: &[f64], max: &[f64]) -> Self {
        self.body(box_body(name, material, min, max))
    }

    /// Adds a wall at a side of the domain. `wall` is a kind without parameters, or an object.
    #[must_use]
    pub fn wall(self, side: &str, wall: impl Into<Value>) -> Self {
        let wall = match wall.into() {
            Value::String(kind) => json!({ "kind": kind }),
            object => object,
        };
        self.push("boundaries", json!({ "side": side, "wall": wall }))
    }

    /// Adds a stage of a duration (s).
    #[must_use]
    pub fn stage(self, name: &str, duration: f64) -> Self {
        self.push("stages", json!({ "name": name, "duration": duration }))
    }

    /// Adds options of a method, or replaces those of the same name.
    #[must_use]
    #[allow(clippy::needless_pass_by_value, reason = "`options(…, json!({ … }))` reads well")]
    pub fn options(mut self, method: &str, options: Value) -> Self {
        let own = self.object("methods").entry(method).or_insert_with(|| json!({}));
        let own = own.as_object_mut().expect("options are an object");
        own.extend(options.as_object().expect("options are an object").clone());
        self
    }

    /// Replaces top-level keys of the case.
    #[must_use]
    #[allow(clippy::needless_pass_by_value, reason = "`with(json!({ … }))` reads well")]
    pub fn with(self, keys: Value) -> Self {
        Self(solver_runs::with_keys(self.0, &keys))
    }

    /// Sets the value at a JSON pointer, see [`set_value`].
    #[must_use]
    pub fn set(mut self, pointer: &str, value: impl Into<Value>) -> Self {
        set_value(&mut self.0, pointer, &value.into());
        self
    }

    /// JSON value of the case.
    pub fn json(&self) -> &Value {
        &self.0
    }

    /// Reads the case; the error lists its errors.
    ///
    /// # Errors
    /// Those of [`Case::from_json`].
    pub fn read(&self) -> Result<Case, CaseErrors> {
        Case::from_json(&self.0.to_string())
    }

    /// Reads the case, which must be valid.
    #[track_caller]
    pub fn build(&self) -> Case {
        solver_runs::read_case(&self.0)
    }

    /// Error about the case: it is invalid, or the method rejects it.
    #[track_caller]
    pub fn error(&self, method: &dyn Method) -> String {
        solver_runs::refusal(method, &self.0)
    }

    /// Runs the case to its end.
    #[track_caller]
    pub fn solve(&self, method: &dyn Method) -> RunReport {
        solver_runs::solve(method, &self.build())
    }

    /// Solver at the start of the first stage.
    #[track_caller]
    pub fn start(&self, method: &dyn Method) -> Box<dyn Solver> {
        solver_runs::start_solver(method, &self.build())
    }

    /// Object of the case under a key; made where it is missing.
    fn object(&mut self, key: &str) -> &mut Map<String, Value> {
        let entry = self.0.as_object_mut().expect("a case is an object").entry(key);
        entry.or_insert_with(|| json!({})).as_object_mut().expect("an object")
    }

    /// Adds a named value to the object under a key.
    fn insert(mut self, key: &str, name: &str, value: Value) -> Self {
        self.object(key).insert(name.to_owned(), value);
        self
    }

    /// Adds a value to the list under a key.
    fn push(mut self, key: &str, value: Value) -> Self {
        let entry = self.0.as_object_mut().expect("a case is an object").entry(key);
        entry.or_insert_with(|| json!([])).as_array_mut().expect("a list").push(value);
        self
    }
}

/// Body that is a box (m).
fn box_body(name: &str, material: &str, min: &[f64], max: &[f64]) -> Value {
    json!({ "name": name, "material": material, "shape": { "kind": "box", "min": min, "max": max } })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block() -> CaseBuilder {
        CaseBuilder::plane_strain([0.0, 0.0], [1.0, 1.0])
            .elastic("m", 1000.0, 1e6, 0.25)
            .box_body("b", "m", &[0.2, 0.3], &[0.6, 0.7])
            .wall("y-min", "rough")
            .stage("s", 0.05)
            .options("mpm", json!({ "cell_size": 0.1 }))
    }

    #[test]
    fn a_built_case_is_valid_and_holds_its_parts() {
        let case = block().build();
        assert_eq!((case.bodies.len(), case.boundaries.len(), case.stages.len()), (1, 1, 1));
        assert_eq!(case.methods["mpm"]["cell_size"], json!(0.1));
    }

    #[test]
    fn keys_are_replaced_at_the_top_by_pointer_and_in_options() {
        let case = block()
            .with(json!({ "gravity": [0, -10] }))
            .set("/bodies/0/material", "n")
            .set("/materials/m/poissons_ratio", Value::Null)
            .options("mpm", json!({ "shape": "linear" }));
        assert_eq!(case.json()["gravity"], json!([0, -10]));
        assert_eq!(case.json()["bodies"][0]["material"], json!("n"));
        assert_eq!(case.json()["materials"]["m"].get("poissons_ratio"), None);
        assert_eq!(case.json()["methods"]["mpm"], json!({ "cell_size": 0.1, "shape": "linear" }));
        let errors = case.read().unwrap_err().to_string();
        assert!(errors.contains("poissons_ratio"), "{errors}");
    }
}
