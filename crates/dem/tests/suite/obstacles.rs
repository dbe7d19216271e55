//! Grains on obstacles (sheet: dem §2.10).

use colluvium_case::{Method, Solver};
use colluvium_dem::{Dem, DemSolver, disks, spheres};
use colluvium_testkit::read_case;
use serde_json::{Value, json};

use crate::single_grains::{Scene, begun, linear};

const ANGLE: f64 = 30.0;
const STIFFNESS: f64 = 1e6;

/// Grain of radius 0.5 m at rest on a plane through the origin that descends along x, pressed in by its weight.
fn resting(dimension: usize, shape: &Value, friction: f64) -> Value {
    let (sine, cosine) = ANGLE.to_radians().sin_cos();
    let mut scene = Scene::new(linear(STIFFNESS, 0.2, 0.5, 0.5));
    let volume = if dimension == 2 { 0.25 } else { 0.5 / 3.0 } * std::f64::consts::PI;
    let distance = 0.5 - scene.density * volume * 9.81 * cosine / STIFFNESS;
    let up = dimension - 1;
    let mut centre = vec![0.0; dimension];
    (centre[0], centre[up]) = (distance * sine, distance * cosine);
    scene.gravity = vec![0.0; dimension];
    scene.gravity[up] = -9.81;
    let none = vec![0.0; dimension];
    scene.grains.push((centre, 0.5, none, vec![0.0; if dimension == 2 { 1 } else { 3 }]));
    let mut value = scene.json();
    let wall = json!({ "kind": "frictional", "friction_coefficient": friction });
    value["obstacles"] = json!([{ "name": "slope", "shape": shape, "wall": wall }]);
    value
}

/// Displacement of the grain down the plane after `time` (s).
fn downslope_displacement<const D: usize, const R: usize>(solver: DemSolver<D, R>, time: f64) -> f64
where
    DemSolver<D, R>: Solver,
{
    let mut solver = begun(solver);
    let (sine, cosine) = ANGLE.to_radians().sin_cos();
    let along = |x: [f64; 3]| cosine * x[0] - sine * x[D - 1];
    let start = along(solver.snapshot().positions[0]);
    while solver.time() < time - 1e-9 {
        solver.step(time - solver.time()).unwrap();
    }
    along(solver.snapshot().positions[0]) - start
}

/// Displacement in a second of a grain of moment of inertia `share m r²` that rolls or slides.
fn exact(share: f64, friction: f64) -> f64 {
    let (sine, cosine) = ANGLE.to_radians().sin_cos();
    let rolls = friction >= ANGLE.to_radians().tan() * share / (1.0 + share);
    0.5 * 9.81 * if rolls { sine / (1.0 + share) } else { sine - friction * cosine }
}

fn at(x: f64) -> [f64; 2] {
    [x, -x * ANGLE.to_radians().tan()]
}

#[test]
fn disks_roll_and_slide_on_a_plane_and_on_a_line_of_many_pieces() {
    let (sine, cosine) = ANGLE.to_radians().sin_cos();
    let plane = json!({ "kind": "plane", "point": [0, 0], "normal": [sine, cosine] });
    let pieces: Vec<[f64; 2]> = (-8..40).map(|k| at(0.173 * f64::from(k))).collect();
    let line = json!({ "kind": "ground-line", "points": pieces });
    let polygon = json!({ "kind": "polygon", "vertices": [at(-3.0), at(9.0), [9.0, -20.0], [-3.0, -20.0]] });
    for friction in [0.0, 0.1, 0.5] {
        for (name, shape) in [("plane", &plane), ("line", &line), ("polygon", &polygon)] {
            let found = downslope_displacement(disks(&read_case(&resting(2, shape, friction))).unwrap(), 1.0);
            let exact = exact(0.5, friction);
            assert!((found / exact - 1.0).abs() < 2e-3, "{name}, {friction}: {found} is not {exact}");
        }
    }
}

#[test]
fn spheres_roll_and_slide_on_a_wedge_and_on_a_raster() {
    let wedge = json!({
        "kind": "extruded", "axis": 1, "from": -3, "to": 3,
        "vertices": [at(-3.0), at(9.0), [9.0, -20.0], [-3.0, -20.0]]
    });
    let folder = std::env::temp_dir().join(format!("colluvium-dem-obstacles-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut text = "ncols 41\nnrows 21\nxllcenter -2\nyllcenter -2\ncellsize 0.2\n".to_owned();
    for _ in 0..21 {
        let row: Vec<String> = (0..41).map(|k| at(0.2 * f64::from(k) - 2.0)[1].to_string()).collect();
        text += &(row.join(" ") + "\n");
    }
    let file = folder.join("slope.asc");
    std::fs::write(&file, text).unwrap();
    let raster = json!({ "kind": "raster", "file": file.display().to_string() });
    for friction in [0.1, 0.5] {
        for (name, shape) in [("wedge", &wedge), ("raster", &raster)] {
            let found =
                downslope_displacement(spheres(&read_case(&resting(3, shape, friction))).unwrap(), 1.0);
            let exact = exact(0.4, friction);
            assert!((found / exact - 1.0).abs() < 2e-3, "{name}, {friction}: {found} is not {exact}");
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_grain_rests_at_the_bottom_of_a_bowl_whose_reaction_is_its_weight() {
    let mut value =
        resting(2, &json!({ "kind": "ball", "centre": [0, 5], "radius": 5, "hollow": true }), 0.5);
    value["bodies"][0]["shape"]["centre"] = json!([2.0, 1.2]);
    value["methods"]["dem"]["pairs"][0]["rolling"] = json!({ "friction": 0.2 });
    value["stages"][0]["damping"] = json!(0.3);
    let case = read_case(&value);
    let mut solver = begun(disks(&case).unwrap());
    while solver.time() < 20.0 - 1e-9 {
        solver.step(20.0 - solver.time()).unwrap();
    }
    let snapshot = solver.snapshot();
    let height = snapshot.positions[0][1];
    assert!((0.49..0.55).contains(&height), "{:?}", snapshot.positions);
    let force = solver.reaction("slope").unwrap().force;
    assert!((force[1] + 9.81).abs() < 0.01 && force[0].abs() < 0.02, "{force:?}");
}

#[test]
fn a_restart_of_a_grain_on_an_obstacle_is_bit_identical() {
    let pieces: Vec<[f64; 2]> = (-8..40).map(|k| at(0.173 * f64::from(k))).collect();
    let case = read_case(&resting(2, &json!({ "kind": "ground-line", "points": pieces }), 0.5));
    let walk = |solver: &mut dyn Solver, count: usize| {
        for _ in 0..count {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
        }
    };
    let mut whole = begun(disks(&case).unwrap());
    walk(&mut whole, 3000);
    let saved = whole.checkpoint_bytes().unwrap();
    walk(&mut whole, 3000);
    let mut again = Dem.build(&case).unwrap();
    again.restore(&mut saved.as_slice()).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    walk(&mut *again, 3000);
    assert_eq!(whole.checkpoint_bytes().unwrap(), again.checkpoint_bytes().unwrap());
}

#[test]
fn grains_filled_beside_a_slope_touch_it_without_overlap() {
    let mut case = Scene::new(linear(1e5, 0.2, 0.5, 0.5)).disk([0.0, 0.0], 1.0, [0.0; 2], 0.0).json();
    // A triangle on a slope of 30 degrees.
    let (sin, cos) = 30f64.to_radians().sin_cos();
    case["bodies"] = json!([{ "name": "heap", "material": "grain",
        "shape": { "kind": "polygon", "vertices": [[0, 0], [10.0 * cos, -10.0 * sin], [10.0 * cos, 2.0]] } }]);
    case["obstacles"] = json!([{ "name": "slope", "wall": { "kind": "smooth" },
        "shape": { "kind": "plane", "point": [0, 0], "normal": [sin, cos] } }]);
    case["methods"]["dem"]["bodies"] = json!({});
    case["methods"]["dem"]["grains"] = json!({ "grain": { "density": 2000, "diameter": { "distribution": "equal", "value": 0.4 },
        "fill": { "kind": "lattice", "packing": "square" } } });
    let solver = disks(&read_case(&case)).unwrap();
    let snapshot = solver.snapshot();
    assert!(snapshot.positions.len() > 50);
    let gaps = snapshot.positions.iter().map(|x| sin * x[0] + cos * x[1] - 0.2);
    let least = gaps.fold(f64::INFINITY, f64::min);
    assert!((-1e-6..0.2).contains(&least), "{least}");
}

#[test]
fn a_grain_inside_an_obstacle_is_refused_with_its_position() {
    let value = resting(2, &json!({ "kind": "plane", "point": [0, 1], "normal": [0, 1] }), 0.5);
    let problem = disks(&read_case(&value)).map(|_| ()).unwrap_err().to_string();
    assert!(problem.starts_with("bodies[0].shape: the point at [0.2"), "{problem}");
    assert!(problem.contains("inside the obstacle \"slope\""), "{problem}");
}

#[test]
fn a_disk_slides_over_the_smooth_part_and_rolls_at_two_thirds_of_its_speed_on_the_rough_one() {
    let mut value = resting(2, &json!({ "kind": "plane", "point": [0, 0], "normal": [0, 1] }), 0.0);
    value["obstacles"][0]["regions"] = json!([{
        "shape": { "kind": "box", "min": [1.0], "max": [50.0] },
        "wall": { "kind": "frictional", "friction_coefficient": 0.3 }
    }]);
    let mut scene = Scene::new(linear(STIFFNESS, 0.2, 0.5, 0.5));
    let weight = scene.density * 0.25 * std::f64::consts::PI * 9.81;
    scene.gravity = vec![0.0, -9.81];
    scene.grains.push((vec![0.0, 0.5 - weight / STIFFNESS], 0.5, vec![2.0, 0.0], vec![0.0]));
    let own = scene.json();
    for key in ["bodies", "gravity", "methods"] {
        value[key] = own[key].clone();
    }
    let mut solver = begun(disks(&read_case(&value)).unwrap());
    let mut until = |time: f64| {
        while solver.time() < time - 1e-9 {
            solver.step(time - solver.time()).unwrap();
        }
        solver.totals().momentum[0] / solver.totals().mass
    };
    let smooth = until(0.4);
    assert!((smooth - 2.0).abs() < 1e-6, "{smooth}");
    // It slips for v/(3 μ g) = 0.227 s.
    let rolls = until(1.0);
    // The tangential spring has no dashpot and oscillates from μ m g, at √(3 k_t/m), about rolling: so does a third of the speed.
    let across = 0.5 * STIFFNESS;
    let swing = 0.3 * 9.81 / 3.0 * (3.0 / across).sqrt();
    assert!((rolls - 4.0 / 3.0).abs() < 1.02 * swing, "{rolls}, swings by {swing}");
}
