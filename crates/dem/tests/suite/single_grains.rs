//! Cases of single grains.

use colluvium_case::Case;
use colluvium_dem::{DemSolver, disks};
use serde_json::{Value, json};

/// Centre, radius, velocity and spin.
pub type Grain = (Vec<f64>, f64, Vec<f64>, Vec<f64>);

/// Single disks or spheres, as (centre, radius, velocity, spin), under gravity along y, with the given pair and boundaries.
pub struct Scene {
    pub grains: Vec<Grain>,
    pub gravity: Vec<f64>,
    pub density: f64,
    pub pair: Value,
    pub boundaries: Value,
    pub options: Value,
    pub periodic: Value,
    pub half: f64,
}

impl Scene {
    pub fn new(pair: Value) -> Self {
        Self {
            grains: Vec::new(),
            gravity: vec![0.0, 0.0],
            density: 4.0 / std::f64::consts::PI,
            pair,
            boundaries: json!([]),
            options: json!({}),
            periodic: json!([]),
            half: 100.0,
        }
    }

    pub fn disk(mut self, centre: [f64; 2], radius: f64, velocity: [f64; 2], spin: f64) -> Self {
        self.grains.push((centre.to_vec(), radius, velocity.to_vec(), vec![spin]));
        self
    }

    pub fn sphere(mut self, centre: [f64; 3], radius: f64, velocity: [f64; 3], spin: [f64; 3]) -> Self {
        self.grains.push((centre.to_vec(), radius, velocity.to_vec(), spin.to_vec()));
        self
    }

    pub fn case(&self) -> Case {
        Case::from_json(&self.json().to_string()).unwrap()
    }

    pub fn json(&self) -> Value {
        let flat = self.grains[0].0.len() == 2;
        let dimension = self.grains[0].0.len();
        let bodies: Vec<Value> = self
            .grains
            .iter()
            .enumerate()
            .map(|(number, (centre, radius, velocity, _))| {
                json!({
                    "name": format!("grain {number}"), "material": "grain",
                    "shape": { "kind": "ball", "centre": centre, "radius": radius },
                    "velocity": { "kind": "uniform", "value": velocity }
                })
            })
            .collect();
        let mut pair = self.pair.clone();
        pair["between"] = json!(["grain", "grain"]);
        let mut own = serde_json::Map::new();
        for (number, (.., spin)) in self.grains.iter().enumerate() {
            own.insert(format!("grain {number}"), json!({ "spin": spin }));
        }
        let mut options = json!({
            "grains": { "grain": { "density": self.density, "fill": { "kind": "single" } } },
            "pairs": [pair], "bodies": own
        });
        options.as_object_mut().unwrap().extend(self.options.as_object().unwrap().clone());
        json!({
            "title": "grains",
            "space": if flat { "plane-strain" } else { "3d" },
            "domain": { "min": vec![-self.half; dimension], "max": vec![self.half; dimension], "periodic": self.periodic },
            "gravity": self.gravity,
            "materials": { "grain": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": bodies,
            "boundaries": self.boundaries,
            "stages": [{ "name": "all", "duration": 1000.0 }],
            "methods": { "dem": options }
        })
    }

    pub fn solver(&self) -> DemSolver<2, 1> {
        begun(disks(&self.case()).unwrap())
    }
}

/// Solver in its first stage.
pub fn begun<const D: usize, const R: usize>(mut solver: DemSolver<D, R>) -> DemSolver<D, R> {
    use colluvium_case::Solver;
    colluvium_testkit::single_threaded();
    solver.begin_stage(0, 0.0).unwrap();
    solver
}

/// Floor at y = 0.
pub fn floor(kind: &Value) -> Value {
    json!([{ "side": "y-min", "name": "floor", "position": 0, "wall": kind }])
}

/// Linear law with a damping ratio and a fixed ratio of stiffnesses.
pub fn linear(stiffness: f64, damping_ratio: f64, across: f64, friction: f64) -> Value {
    json!({
        "normal": { "law": "linear", "stiffness": stiffness, "damping_ratio": damping_ratio },
        "tangential": { "stiffness_ratio": across },
        "friction": { "coefficient": friction }
    })
}
