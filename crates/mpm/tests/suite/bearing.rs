//! What obstacles bear of bodies at rest: weights in axisymmetry, of grains and water in the plane and in space (docs/theory/mpm.md, obstacles).

use colluvium_case::{Budget, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::cases::{advance_to, begin, changed, scalars};
use serde_json::{Value, json};

const GRAVITY: f64 = 9.81;
const BOTH: [&str; 2] = ["nodes", "points"];

/// Mean force (N) of the bodies on the obstacle `ground` between two times (s).
fn borne(solver: &mut dyn Solver, from: f64, to: f64) -> [f64; 3] {
    let mut impulse = |time: f64| {
        advance_to(&mut *solver, time);
        solver.reaction("ground").unwrap().impulse
    };
    let (start, end) = (impulse(from), impulse(to));
    std::array::from_fn(|c| (end[c] - start[c]) / (to - from))
}

#[test]
fn a_ring_on_a_cone_bears_down_with_its_weight_per_radian() {
    // A parallelogram from r = 0.5 m to 1.1 m, 0.3 m high, on a cone that falls outwards by a third.
    let at = |r: f64, above: f64| [r, 1.0 - r / 3.0 + above];
    let corners = [at(0.5, 0.0), at(1.1, 0.0), at(1.1, 0.3), at(0.5, 0.3)];
    let cone =
        json!({ "kind": "polygon", "vertices": [at(0.0, 0.0), at(2.0, 0.0), [2.0, -0.5], [0.0, -0.5]] });
    // Pappus: the area times the radius of its centroid.
    let exact = 1000.0 * GRAVITY * 0.6 * 0.3 * 0.8;
    for obstacles in BOTH {
        let value = json!({
            "title": "ring", "space": "axisymmetric", "gravity": [0, -GRAVITY],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 } },
            "domain": { "min": [0, 0], "max": [2, 1.5] },
            "bodies": [{ "name": "ring", "material": "m", "shape": { "kind": "polygon", "vertices": corners } }],
            "obstacles": [{ "name": "ground", "shape": cone, "wall": { "kind": "rough" } }],
            "stages": [{ "name": "rest", "duration": 1, "damping": 0.5 }],
            "measures": { "reaction": { "kind": "reaction", "of": "ground" } },
            "methods": { "mpm": { "cell_size": 0.1, "obstacles": obstacles } }
        });
        let mut solver = begin(&Mpm, &changed(value, &json!({})));
        let force = borne(&mut *solver, 0.9, 1.0);
        let weight = GRAVITY * solver.totals().mass;
        assert!((weight / exact - 1.0).abs() < 0.02, "{obstacles}: points in cells, {weight} {exact}");
        assert!((force[1] / -weight - 1.0).abs() < 2e-3, "{obstacles}: {force:?} {weight}");
    }
}

/// A saturated column, 0.8 m high, between smooth sides on an obstacle, with water of this pressure (Pa) at its middle.
fn column(space: &str, obstacles: &str, pressure: f64) -> Value {
    let (low, high, top) = match space {
        "3d" => (vec![0.0; 3], vec![0.2, 0.2, 0.8], vec![0.2, 0.2, 1.0]),
        _ => (vec![0.0; 2], vec![0.4, 0.8], vec![0.4, 1.0]),
    };
    let up = low.len() - 1;
    let along = |of: f64| -> Vec<f64> { (0..=up).map(|c| if c == up { of } else { 0.0 }).collect() };
    let sides = ["x-min", "x-max", "y-min", "y-max"];
    let boundaries: Vec<Value> =
        sides[..2 * up].iter().map(|side| json!({ "side": side, "wall": { "kind": "smooth" } })).collect();
    let at = |z: f64| -> Vec<f64> { along(z) };
    json!({
        "title": "column", "space": space, "gravity": along(-GRAVITY),
        "materials": { "m": { "model": "linear-elastic", "density": 1590, "youngs_modulus": 1e6, "poissons_ratio": 0.0 } },
        "domain": { "min": low, "max": top }, "boundaries": boundaries,
        "bodies": [{
            "name": "column", "material": "m", "shape": { "kind": "box", "min": low, "max": high },
            "pore_fluid": {
                "porosity": 0.4, "permeability": 4e-3, "bulk_modulus": 5e7,
                "pressure": { "kind": "uniform", "value": pressure }
            }
        }],
        "obstacles": [{
            "name": "ground", "shape": { "kind": "plane", "point": at(0.0), "normal": along(1.0) },
            "wall": { "kind": "smooth" }
        }],
        "stages": [{ "name": "settle", "duration": 3 }],
        "measures": { "reaction": { "kind": "reaction", "of": "ground" } },
        "methods": { "mpm": { "cell_size": 0.1, "obstacles": obstacles } }
    })
}

#[test]
fn an_obstacle_bears_grains_and_water_undrained_and_drained() {
    for space in ["plane-strain", "axisymmetric", "3d"] {
        for obstacles in BOTH {
            let mut value = column(space, obstacles, 0.0);
            let mean = |solver: &dyn Solver| {
                let pressures = scalars(&solver.snapshot(), "pore_pressure");
                pressures.iter().sum::<f64>() / pressures.len() as f64
            };
            // At rest in the end: all weight on the ground, the pressure of water alone in the pores.
            let mut solver = begin(&Mpm, &changed(value.clone(), &json!({})));
            let force = borne(&mut *solver, 2.5, 3.0);
            let weight = GRAVITY * solver.totals().mass;
            let up = if space == "3d" { 2 } else { 1 };
            assert!((force[up] / -weight - 1.0).abs() < 0.01, "{space}, {obstacles}: {force:?} {weight}");
            let (still, drained) = (mean(&*solver), 1000.0 * GRAVITY * 0.4);
            assert!((still / drained - 1.0).abs() < 0.05, "{space}, {obstacles}: {still} {drained}");
            // Nothing drains of a soil as tight as that: the water bears all.
            value["bodies"][0]["pore_fluid"]["permeability"] = json!(1e-6);
            value["stages"][0]["duration"] = json!(0.4);
            value["stages"][0]["damping"] = json!(0.2);
            let mut solver = begin(&Mpm, &changed(value, &json!({})));
            let force = borne(&mut *solver, 0.2, 0.4);
            assert!((force[up] / -weight - 1.0).abs() < 0.02, "{space}, {obstacles}: {force:?} {weight}");
            let (all, undrained) = (mean(&*solver), 1990.0 * GRAVITY * 0.4);
            assert!((all / undrained - 1.0).abs() < 0.05, "{space}, {obstacles}: {all} {undrained}");
        }
    }
}
