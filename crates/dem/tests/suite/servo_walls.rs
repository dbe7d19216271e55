//! Servo-controlled walls (sheet: dem §3.7).

use colluvium_case::{Case, Solver};
use colluvium_dem::{DemSolver, disks, spheres};
use colluvium_testkit::{assert_near, read_case, scalar_output};
use serde_json::{Value, json};

use crate::single_grains::{Scene, begun, linear};

const STIFFNESS: f64 = 1e6;
const DISKS: usize = 3;

/// Stack of disks of radius 0.5 m, without gravity, under a wall that presses with 5 N/m over the 200 m of the domain.
fn stack(start: f64) -> Value {
    let mut scene = Scene::new(linear(STIFFNESS, 0.3, 0.5, 0.5));
    for k in 0..DISKS {
        scene = scene.disk([0.0, 0.5 + k as f64], 0.5, [0.0; 2], 0.0);
    }
    scene.boundaries = json!([
        { "side": "y-min", "name": "floor", "position": 0, "wall": { "kind": "smooth" } },
        { "side": "y-max", "name": "platen", "position": start, "wall": { "kind": "smooth" } }
    ]);
    scene.options = json!({ "stages": { "all": { "walls": { "platen": { "stress": -5, "speed": 0.5, "area": 200 } } } } });
    scene.json()
}

fn solver(value: &Value) -> DemSolver<2, 1> {
    begun(disks(&read_case(value)).unwrap())
}

fn to(solver: &mut dyn Solver, time: f64) {
    while solver.time() < time {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    }
}

#[test]
fn a_platen_comes_to_rest_at_the_prescribed_stress_of_the_stack() {
    let mut solver = solver(&stack(3.2));
    to(&mut solver, 0.1);
    assert_near(scalar_output(&solver, "wall.platen.position"), 3.15, 1e-3);
    assert_near(scalar_output(&solver, "wall.platen.stress"), 0.0, 1e-12);
    to(&mut solver, 3.0);
    // Each contact carries 1000 N.
    let overlap = 1000.0 / STIFFNESS;
    assert_near(
        scalar_output(&solver, "wall.platen.position"),
        DISKS as f64 - (DISKS + 1) as f64 * overlap,
        1e-7,
    );
    assert_near(scalar_output(&solver, "wall.platen.stress"), -5.0, 1e-4);
    assert_near(solver.reaction("platen").unwrap().force[1], 1000.0, 0.02);
    assert_near(solver.reaction("floor").unwrap().force[1], -1000.0, 0.02);
    // Its work is the spring energy plus the dissipation of the dashpots.
    assert!(scalar_output(&solver, "work.boundaries") > 4.0 * 0.5 * 1000.0 * overlap);
    assert_near(scalar_output(&solver, "energy_error"), 0.0, 2e-3);
}

#[test]
fn a_platen_does_not_reverse_each_step_in_steps_short_for_its_dashpots() {
    let mut value = stack(3.02);
    let step = solver(&value).limit().dt / 20.0;
    value["methods"]["dem"]["time_step"] = json!(step);
    let mut solver = solver(&value);
    to(&mut solver, 1.5);
    let mut before = scalar_output(&solver, "wall.platen.position");
    for _ in 0..50 {
        solver.step(step).unwrap();
        assert_near(scalar_output(&solver, "wall.platen.stress"), -5.0, 1e-3);
        let after = scalar_output(&solver, "wall.platen.position");
        assert_near(after - before, 0.0, 1e-3 * 0.5 * step);
        before = after;
    }
}

#[test]
fn a_restart_with_a_moving_platen_is_bit_identical() {
    let mut solver = solver(&stack(3.02));
    to(&mut solver, 0.045);
    let saved = solver.checkpoint_bytes().unwrap();
    to(&mut solver, 0.1);
    let mut again = self::solver(&stack(3.02));
    again.restore(&mut &saved[..]).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    to(&mut again, 0.1);
    assert_eq!(solver.checkpoint_bytes().unwrap(), again.checkpoint_bytes().unwrap());
}

#[test]
fn tensile_or_unknown_platens_are_refused() {
    let refused = |change: fn(&mut Value)| {
        let mut value = stack(3.2);
        change(&mut value["methods"]["dem"]["stages"]["all"]["walls"]);
        let case = read_case(&value);
        disks(&case).map(|_| ()).unwrap_err().to_string()
    };
    let pulls = refused(|walls| walls["platen"]["stress"] = json!(5));
    assert!(pulls.contains("stages.all.walls.platen.stress") && pulls.contains("negative"), "{pulls}");
    let unknown = refused(|walls| walls["plate"] = walls["platen"].clone());
    assert!(unknown.contains("did you mean \"platen\""), "{unknown}");
    let swings = refused(|walls| walls["platen"]["gain"] = json!(0.5));
    assert!(swings.contains("walls.platen.gain"), "{swings}");
}

#[test]
fn a_platen_of_unbounded_area_requires_an_area() {
    let mut value = stack(3.2);
    let platen = &mut value["methods"]["dem"]["stages"]["all"]["walls"]["platen"];
    platen.as_object_mut().unwrap().remove("area");
    let refused = |value: &Value| disks(&read_case(value)).err().unwrap().to_string();
    let error = refused(&value);
    assert!(error.starts_with("methods.dem.stages.all.walls.platen.area: is missing: along x"), "{error}");
    value["methods"]["dem"]["stages"]["all"]["walls"]["platen"]["sleeve"] = json!("grain 0");
    let error = refused(&value);
    assert!(error.contains("platen.sleeve: \"grain 0\" is not a body that is a closed membrane"), "{error}");
}

#[test]
fn stress_control_of_obstacles_and_grains_is_refused_with_an_alternative() {
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut value = stack(3.2);
        change(&mut value);
        disks(&read_case(&value)).err().unwrap().to_string()
    };
    let press =
        |name: &str| json!({ "all": { "walls": { name: { "stress": -5, "speed": 0.5, "area": 1 } } } });
    // A polygon; an STL file gives an obstacle as well.
    let polygon = refused(&|value| {
        value["obstacles"] = json!([{ "name": "plate", "wall": { "kind": "smooth" },
            "shape": { "kind": "polygon", "vertices": [[-1, 4], [1, 4], [1, 5], [-1, 5]] } }]);
        value["methods"]["dem"]["stages"] = press("plate");
    });
    assert!(
        polygon.starts_with("methods.dem.stages.all.walls.plate: an obstacle has a prescribed `motion`"),
        "{polygon}"
    );
    for name in ["grain 0", "grain"] {
        let grains = refused(&|value| value["methods"]["dem"]["stages"] = press(name));
        let start = format!("methods.dem.stages.all.walls.{name}: grains cannot have a prescribed stress");
        assert!(grains.starts_with(&start) && grains.contains("methods.dem.stages.all.forces"), "{grains}");
    }
    let held = refused(&|value| {
        value["methods"]["dem"]["bodies"]["grain 2"] = json!({ "fill": { "kind": "single" }, "held": true });
        value["methods"]["dem"]["stages"] = json!({ "all": { "forces": { "grain 2": [0, -5] } } });
    });
    assert!(
        held.ends_with("so that a force cannot move them: leave held out, and bond them to each other"),
        "{held}"
    );
}

/// Box of triangles that face outwards, as an OBJ file.
fn box_as_obj(low: [f64; 3], high: [f64; 3]) -> String {
    let ends = [low, high];
    let corners = (0..8usize).map(|k| [0, 1, 2].map(|c| ends[k >> c & 1][c]));
    let mut text: String = corners.map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    for [a, b, c, d] in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    text
}

#[test]
fn stress_control_is_refused_for_mesh_plates_and_holds_for_walls_of_given_area() {
    // Four spheres on a floor, and a plate on them, 3 m by 3 m.
    let mut scene = Scene::new(linear(STIFFNESS, 0.3, 0.5, 0.5));
    for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
        scene = scene.sphere([x, y, 0.5], 0.5, [0.0; 3], [0.0; 3]);
    }
    scene.gravity = vec![0.0; 3];
    let smooth = json!({ "kind": "smooth" });
    let floor = json!({ "side": "z-min", "name": "floor", "position": 0, "wall": smooth });
    scene.boundaries = json!([floor]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plate.obj"), box_as_obj([-1.5, -1.5, 1.05], [1.5, 1.5, 1.5])).unwrap();
    let mut meshed = scene.json();
    meshed["obstacles"] =
        json!([{ "name": "plate", "wall": smooth, "shape": { "kind": "mesh", "file": "plate.obj" } }]);
    let read = |value: &Value| Case::from_value(value, folder.path());
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut value = meshed.clone();
        change(&mut value);
        match read(&value) {
            Ok(case) => spheres(&case).err().unwrap().to_string(),
            Err(errors) => errors.to_string(),
        }
    };
    assert!(spheres(&read(&meshed).unwrap()).is_ok());
    let cures = ["methods.dem.stages.all.walls", "methods.dem.stages.all.forces"];
    let stress = json!({ "stress": -500, "speed": 0.5, "area": 9 });
    for (key, own) in [("walls", stress.clone()), ("forces", json!([0, 0, -4500]))] {
        let error = refused(&|value| {
            value["methods"]["dem"]["stages"] = json!({ "all": { key: { "plate": own } } });
        });
        let start = format!("methods.dem.stages.all.{key}.plate: an obstacle has a prescribed `motion`");
        assert!(error.starts_with(&start) && cures.iter().all(|cure| error.contains(cure)), "{error}");
    }
    let error = refused(&|value| {
        value["stages"][0]["motions"] =
            json!([{ "target": "plate", "velocity": [0, 0, null], "force": [0, 0, -4500] }]);
    });
    let start = "stages[0].motions[0].target: \"plate\" is an obstacle, whose motion is obstacles[0].motion and does not depend on a force";
    assert!(error.starts_with(start) && error.contains("a wall in boundaries"), "{error}");

    // The alternative named in the refusals: a wall across the domain, 200 m wide, under the stress on the area of the plate.
    scene.boundaries =
        json!([floor, { "side": "z-max", "name": "platen", "position": 1.05, "wall": smooth }]);
    scene.options = json!({ "stages": { "all": { "walls": { "platen": stress } } } });
    let mut solver = begun(spheres(&scene.case()).unwrap());
    to(&mut solver, 3.0);
    assert_near(scalar_output(&solver, "wall.platen.stress"), -500.0, 1e-2);
    assert_near(solver.reaction("platen").unwrap().force[2], 4500.0, 0.1);
    assert_near(solver.reaction("floor").unwrap().force[2], -4500.0, 0.1);
    // Each sphere carries a quarter between two contacts.
    assert_near(scalar_output(&solver, "wall.platen.position"), 1.0 - 2.0 * 0.25 * 4500.0 / STIFFNESS, 1e-7);
}

#[test]
fn a_loaded_plate_of_bonded_disks_transmits_its_force_to_the_floor() {
    let mut scene = Scene::new(linear(STIFFNESS, 0.3, 0.5, 0.5));
    for k in 0..3 {
        scene = scene.disk([f64::from(k), 0.5], 0.5, [0.0; 2], 0.0);
    }
    scene.boundaries =
        json!([{ "side": "y-min", "name": "floor", "position": 0, "wall": { "kind": "smooth" } }]);
    let mut value = scene.json();
    value["materials"]["steel"] = value["materials"]["grain"].clone();
    value["bodies"].as_array_mut().unwrap().push(json!({ "name": "plate", "material": "steel",
        "shape": { "kind": "box", "min": [-0.5, 1], "max": [2.5, 2] } }));
    let own = &mut value["methods"]["dem"];
    own["grains"]["steel"] = json!({ "density": 1000, "diameter": { "distribution": "equal", "value": 1 },
        "fill": { "kind": "lattice", "packing": "square" } });
    own["mix"] = json!(true);
    let mut bonded = own["pairs"][0].clone();
    bonded["between"] = json!(["steel", "steel"]);
    bonded["bond"] = json!({ "normal_stiffness": 1e7, "shear_stiffness": 1e7 });
    own["pairs"].as_array_mut().unwrap().push(bonded);
    own["stages"] = json!({ "all": { "forces": { "plate": [0, -3000] } } });
    value["stages"][0]["rayleigh_damping"] = json!(20);
    let mut solver = solver(&value);
    to(&mut solver, 3.0);
    assert_near(solver.reaction("floor").unwrap().force[1], -3000.0, 1.0);
    // Each column carries a third: two contacts, with plate and floor, above one another.
    let plate: Vec<f64> = solver.snapshot().positions[3..].iter().map(|x| x[1]).collect();
    assert_eq!(plate.len(), 3);
    let mean = plate.iter().sum::<f64>() / 3.0;
    assert_near(mean, 1.5 - 2.0 * 1000.0 / STIFFNESS, 1e-5);
}
