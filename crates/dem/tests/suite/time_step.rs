//! Rules of the time step, sliding blocks, and uniformity of a packing.

use colluvium_case::Solver;
use colluvium_dem::disks;
use colluvium_testkit::{assert_near, read_case};
use serde_json::json;

use crate::single_grains::{Scene, begun, floor, linear};

#[test]
fn the_step_is_a_share_of_the_period_of_the_stiffest_contact() {
    // Masses 1 and 4 kg: two of the small ones have 1/2 kg, ω₀ = √(2e6) rad/s.
    let scene = Scene::new(linear(1e6, 0.0, 0.5, 0.0)).disk([0.0, 0.0], 0.5, [0.0; 2], 0.0).disk(
        [3.0, 0.0],
        1.0,
        [0.0; 2],
        0.0,
    );
    let period = std::f64::consts::PI / 2e6f64.sqrt();
    assert_near(scene.solver().limit().dt / (period / 30.0), 1.0, 1e-12);
    let mut value = scene.json();
    value["methods"]["dem"]["step_fraction"] = json!(0.01);
    let case = read_case(&value);
    assert_near(begun(disks(&case).unwrap()).limit().dt / (period * 0.01), 1.0, 1e-12);
    // A fixed step above 0.4 / ω₀ is refused, one just below it is accepted.
    for (factor, taken) in [(0.401, false), (0.399, true)] {
        value["methods"]["dem"]["time_step"] = json!(factor / 2e6f64.sqrt());
        let case = read_case(&value);
        let built = disks(&case);
        assert_eq!(built.is_ok(), taken, "{factor}");
        if let Err(error) = built {
            assert!(error.to_string().starts_with("methods.dem.time_step: "), "{error}");
        }
    }
}

#[test]
fn a_bonded_row_slides_down_a_slope_with_coulomb_friction() {
    // The slope is along x: gravity is rotated. A block that cannot roll: g (sin β - μ cos β).
    let (g, slope) = (9.81, 25f64.to_radians());
    for friction in [0.2, 0.6] {
        let mut pair = linear(1e7, 0.3, 0.5, 0.0);
        pair["tangential"]["damping_ratio"] = json!(0.3);
        pair["bond"] = json!({ "normal_stiffness": 1e8, "shear_stiffness": 1e8, "gap": 0.01 });
        let mut scene = Scene::new(pair);
        let sunk = g * slope.cos() / 1e7;
        for k in 0..4 {
            scene = scene.disk([f64::from(k), 0.5 - sunk], 0.5, [0.0; 2], 0.0);
        }
        scene.gravity = vec![g * slope.sin(), -g * slope.cos()];
        scene.boundaries = floor(&json!({ "kind": "frictional", "friction_coefficient": friction }));
        let mut solver = scene.solver();
        while solver.time() < 0.5 {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
        }
        let (time, snapshot) = (solver.time(), solver.snapshot());
        let moved: f64 = snapshot.vectors("displacement").unwrap().iter().map(|u| u[0]).sum::<f64>() / 4.0;
        if friction < slope.tan() {
            let exact = 0.5 * g * (slope.sin() - friction * slope.cos()) * time * time;
            // Tangential springs take a little of it until the block slips.
            assert_near(moved / exact, 1.0, 5e-3);
        } else {
            assert_near(moved, 0.0, 1e-5);
        }
    }
}

#[test]
fn a_hexagonal_packing_is_even_in_bands_of_whole_rows() {
    // Periodic rows of ten, √3/2 apart.
    let row = 0.5 * 3f64.sqrt();
    let mut scene = Scene::new(linear(1e6, 0.0, 0.5, 0.0));
    for j in 0..24 {
        for i in 0..10 {
            let x = f64::from(i) + if j % 2 == 1 { 0.5 } else { 0.0 };
            scene = scene.disk([x - 5.0, f64::from(j) * row], 0.5, [0.0; 2], 0.0);
        }
    }
    let solver = scene.solver();
    // From the middle of the second row to that of the last but one.
    let ends = [row, 21.0 * row];
    let even = solver.void_ratio_bands([-5.0, 5.0], ends, 10).unwrap();
    let void_ratio = (1.0 - 0.906_899_682_117_109) / 0.906_899_682_117_109;
    assert_near(even.void_ratio, void_ratio, 1e-9);
    assert_near(even.variance, 0.0, 1e-20);
    // Bands of 5/4 rows contain more or fewer rows.
    let uneven = solver.void_ratio_bands([-5.0, 5.0], ends, 16).unwrap();
    assert_near(uneven.void_ratio, void_ratio, 1e-9);
    assert!(uneven.variance > 1e-5, "{}", uneven.variance);
    assert!(solver.void_ratio_bands([0.0, 0.0], ends, 10).is_none());
    assert!(solver.void_ratio_bands([-5.0, 5.0], [50.0, 60.0], 10).is_none());
}
