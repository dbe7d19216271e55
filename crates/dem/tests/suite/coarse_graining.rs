//! Coarse graining (sheet: dem §3.9).

use colluvium_case::{DatasetGeometry, FieldData, FrameRequest, Lattice, Solver};
use colluvium_dem::disks;
use colluvium_dem::output::coarse_graining::CoarseGrainingNodes;
use colluvium_testkit::{assert_near, read_case};
use serde_json::json;

use crate::single_grains::{Scene, begun, linear};

fn nodes(half: f64, count: usize) -> CoarseGrainingNodes<2> {
    CoarseGrainingNodes { origin: [-half; 2], spacing: 2.0 * half / (count - 1) as f64, count: [count; 2] }
}

#[test]
fn fields_integrate_to_mass_momentum_and_the_stress_of_the_branch() {
    let mut solver = Scene::new(linear(1e4, 0.0, 0.5, 0.5))
        .disk([-0.5, 0.0], 0.5, [0.0; 2], 0.0)
        .disk([0.301, 0.0], 0.3, [-1.0, 0.1], 0.0)
        .solver();
    for _ in 0..300 {
        solver.step(1e-5).unwrap();
    }
    let lattice = nodes(3.0, 241);
    let fields = solver.coarse_grained(&lattice, 1.1);
    let area = lattice.spacing * lattice.spacing;
    let budget = solver.totals();
    assert_near(fields.iter().map(|field| field.density).sum::<f64>() * area / budget.mass, 1.0, 1e-4);
    let momentum = fields.iter().map(|field| field.density * field.velocity[0]).sum::<f64>() * area;
    assert_near(momentum / budget.momentum[0], 1.0, 1e-3);
    let contact = solver.contacts().first().unwrap();
    let whole = fields.iter().map(|field| field.contact.component(0, 0)).sum::<f64>() * area;
    assert_near(whole / -(contact.force[0] * contact.branch[0]), 1.0, 1e-4);
    assert!(whole < 0.0, "grains that push each other are under pressure");
}

#[test]
fn a_single_grain_has_its_velocity_everywhere_and_no_kinetic_stress() {
    let scene = Scene::new(linear(1e4, 0.0, 0.5, 0.5)).disk([0.1, 0.2], 0.5, [3.0, -1.0], 0.0);
    for field in scene.solver().coarse_grained(&nodes(1.0, 21), 0.8) {
        if field.density > 0.0 {
            assert_near(field.velocity[0], 3.0, 1e-12);
            assert_near(field.kinetic.norm(), 0.0, 1e-9);
        }
    }
}

#[test]
fn two_grains_that_pass_each_other_have_the_kinetic_stress_of_their_energy() {
    let v = 2.0;
    let scene = Scene::new(linear(1e4, 0.0, 0.5, 0.5)).disk([0.0, 0.6], 0.5, [v, 0.0], 0.0).disk(
        [0.0, -0.6],
        0.5,
        [-v, 0.0],
        0.0,
    );
    // Half way between the two grains the mean velocity is zero.
    let middle = CoarseGrainingNodes { origin: [0.0; 2], spacing: 1.0, count: [1; 2] };
    let field = scene.solver().coarse_grained(&middle, 3.0)[0];
    assert_near(field.velocity[0], 0.0, 1e-12);
    assert_near(field.kinetic.component(0, 0) / (-field.density * v * v), 1.0, 1e-12);
}

#[test]
fn a_periodic_row_is_as_dense_at_its_ends_as_within() {
    let mut scene = Scene::new(linear(1e4, 0.0, 0.5, 0.5));
    for k in 0..8 {
        scene = scene.disk([-3.5 + f64::from(k), 0.0], 0.4, [0.0; 2], 0.0);
    }
    scene.periodic = json!(["x"]);
    scene.half = 4.0;
    let row = CoarseGrainingNodes { origin: [-3.5, 0.0], spacing: 1.0, count: [8, 1] };
    let fields = scene.solver().coarse_grained(&row, 2.5);
    for field in &fields {
        assert_near(field.density / fields[3].density, 1.0, 1e-12);
    }
}

#[test]
fn a_run_has_the_fields_on_its_grid_and_cells_of_grains_in_its_frames() {
    let mut value = Scene::new(linear(1e4, 0.0, 0.5, 0.5)).disk([0.0, 0.0], 1.0, [0.0; 2], 0.0).json();
    value["domain"] = json!({ "min": [0, 0], "max": [6, 6], "periodic": ["x", "y"] });
    value["bodies"] = json!([{ "name": "all", "material": "grain", "shape": { "kind": "box", "min": [0, 0], "max": [6, 6] },
        "velocity": { "kind": "uniform", "value": [0.5, 0] } }]);
    value["methods"]["dem"]["bodies"] = json!({});
    value["methods"]["dem"]["voronoi"] = json!(true);
    value["output"] = json!({ "grid": 0.25 });
    value["methods"]["dem"]["grains"] = json!({ "grain": { "density": 3, "diameter": { "distribution": "equal", "value": 1 },
        "fill": { "kind": "lattice", "packing": "square" } } });
    let solver = begun(disks(&read_case(&value)).unwrap());
    let frame = solver.frame(FrameRequest::Requested);
    let grid = frame.dataset("grid").unwrap();
    let nodes = Lattice { low: [0.0; 3], spacing: 0.25, count: [25, 25, 1] };
    assert_eq!(grid.geometry, DatasetGeometry::Lattice { nodes, mask: Vec::new() });
    let fields = &grid.fields;
    let names: Vec<&str> = fields.iter().map(|field| &*field.name).collect();
    assert_eq!(names, ["density", "velocity", "stress", "kinetic_stress"]);
    let FieldData::Scalar(density) = &fields[0].data else { panic!("density") };
    let mean = density.iter().sum::<f64>() / 625.0;
    assert_near(mean / (3.0 * 0.25 * std::f64::consts::PI), 1.0, 0.01);
    let FieldData::Vector(velocity) = &fields[1].data else { panic!("velocity") };
    assert!(velocity.iter().all(|v| (v[0] - 0.5).abs() < 1e-12));
    let snapshot = solver.snapshot();
    let fraction = snapshot.scalars("cell_solid_fraction").unwrap();
    assert!(fraction.iter().all(|own| (own - std::f64::consts::FRAC_PI_4).abs() < 1e-6), "{fraction:?}");
    let rows = solver.scalar_outputs();
    let inner = rows.iter().find(|(name, ..)| name == "inner_solid_fraction").unwrap().2;
    assert_near(inner, std::f64::consts::FRAC_PI_4, 1e-6);
}
