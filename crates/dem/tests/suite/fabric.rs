//! Fabric of contacts (sheet: dem §3.9).

use colluvium_testkit::{assert_near, read_case};

use crate::single_grains::{Scene, begun, linear};

/// Disks of radius 0.5001 m on a square lattice of 1 m, six by six.
fn lattice() -> Scene {
    let mut scene = Scene::new(linear(1e4, 0.0, 0.5, 0.5));
    for a in 0..6 {
        for b in 0..6 {
            let at = [a, b].map(|k: i32| f64::from(k) - 2.5);
            scene = scene.disk([at[0], at[1]], 0.5001, [0.0; 2], 0.0);
        }
    }
    scene
}

fn solver(scene: &Scene) -> colluvium_dem::DemSolver<2, 1> {
    use colluvium_case::Solver;
    let mut solver = scene.solver();
    solver.step(1e-9).unwrap();
    solver
}

#[test]
fn a_square_lattice_has_no_direction_of_its_tensor() {
    let fabric = solver(&lattice()).fabric().unwrap();
    assert_eq!(fabric.contacts, 60);
    assert_near(fabric.coordination, 120.0 / 36.0, 1e-12);
    assert_near(fabric.mechanical_coordination, 120.0 / 36.0, 1e-12);
    assert_near(fabric.rattlers, 0.0, 1e-12);
    assert_near(fabric.tensor[0][0], 0.5, 1e-12);
    assert_near(fabric.tensor[0][1], 0.0, 1e-12);
    assert_near(fabric.anisotropy, 0.0, 1e-12);
    assert_near(fabric.mean_force / (1e4 * 2e-4), 1.0, 1e-6);
    let rose = solver(&lattice()).contact_rose(4);
    assert_near(rose.iter().sum::<f64>(), 1.0, 1e-12);
}

#[test]
fn contacts_of_a_single_row_all_lie_along_it() {
    let mut scene = Scene::new(linear(1e4, 0.0, 0.5, 0.5));
    for k in 0..8 {
        scene = scene.disk([f64::from(k) - 3.5, 0.0], 0.5001, [0.0; 2], 0.0);
    }
    let row = solver(&scene);
    let fabric = row.fabric().unwrap();
    assert_near(fabric.tensor[0][0], 1.0, 1e-9);
    // 4 (G - 1/2) has the entries 2 and -2.
    assert_near(fabric.anisotropy, 8.0f64.sqrt(), 1e-6);
    assert_near(fabric.alignment, 1.0, 1e-9);
    assert_near(fabric.coordination, 14.0 / 8.0, 1e-12);
    // Its ends are rattlers, and without them the next ones are too.
    assert_near(fabric.mechanical_coordination, 0.0, 1e-12);
    assert_near(fabric.rattlers, 1.0, 1e-12);
}

#[test]
fn where_no_grains_touch_there_is_no_fabric() {
    let scene = Scene::new(linear(1e4, 0.0, 0.5, 0.5)).disk([0.0, 0.0], 0.5, [0.0; 2], 0.0);
    let alone = solver(&scene);
    assert!(alone.fabric().is_none());
    assert_eq!(alone.contact_rose(3), [0.0; 3]);
}

#[test]
fn lines_of_contacts_join_the_centres_and_carry_the_forces() {
    use colluvium_case::{DatasetGeometry, FieldData, FrameRequest, Solver};
    use colluvium_dem::disks;
    let mut scene = lattice();
    scene.boundaries = crate::single_grains::floor(&serde_json::json!({ "kind": "smooth" }));
    scene.boundaries[0]["position"] = serde_json::json!(-3.0);
    let mut case = scene.json();
    case["output"] = serde_json::json!({ "contacts": true });
    let lattice = begun(disks(&read_case(&case)).unwrap());
    assert!(lattice.frame(FrameRequest::Measured).dataset("contacts").is_none());
    let frame = lattice.frame(FrameRequest::Requested);
    let lines = frame.dataset("contacts").unwrap();
    let DatasetGeometry::Mesh(mesh) = &lines.geometry else { panic!("lines") };
    // Six disks are in contact with the floor.
    assert_eq!(mesh.cells().count(), 66);
    let scalars = |name: &str| match &lines.fields.iter().find(|field| field.name == name).unwrap().data {
        FieldData::Scalar(values) => values.clone(),
        _ => panic!("{name} is no scalar"),
    };
    let (normal, wall) = (scalars("normal_force"), scalars("wall"));
    for (k, ends) in mesh.cells().enumerate() {
        let [from, to] = [ends[0], ends[1]];
        let length = (0..3).map(|c| (to[c] - from[c]).powi(2)).sum::<f64>().sqrt();
        let (distance, overlap) = if wall[k] == 1.0 { (0.5, 1e-4) } else { (1.0, 2e-4) };
        assert_near(length, distance, 1e-6);
        assert_near(normal[k] / (1e4 * overlap), 1.0, 1e-6);
    }
    assert_near(wall.iter().sum::<f64>(), 6.0, 1e-12);
    // Every output row contains the fabric.
    let rows = lattice.scalar_outputs();
    let row = |name: &str| rows.iter().find(|(own, ..)| own == name).unwrap().2;
    assert_near(row("fabric.xx") + row("fabric.yy"), 1.0, 1e-12);
}

#[test]
fn rows_under_above_average_stress_are_force_chains() {
    // Two rows of six, one pressed ten times as much as the other, and a row of four without force.
    let mut scene = Scene::new(linear(1e4, 0.0, 0.5, 0.5));
    for k in 0..6 {
        let x = f64::from(k);
        scene = scene.disk([0.9998 * x, 0.0], 0.5, [0.0; 2], 0.0);
        scene = scene.disk([0.99998 * x, 3.0], 0.5, [0.0; 2], 0.0);
    }
    for k in 0..4 {
        scene = scene.disk([f64::from(k), 6.0], 0.499, [0.0; 2], 0.0);
    }
    let rows = solver(&scene);
    let chains = rows.force_chains();
    assert_eq!(chains.iter().map(Vec::len).collect::<Vec<_>>(), [6]);
    let contacts = rows.contacts();
    let inside = |i: usize| chains[0].contains(&i);
    // All contacts of the chain are those of the row with the largest pressure.
    let overlaps: Vec<f64> =
        contacts.iter().filter(|contact| inside(contact.grain)).map(|contact| contact.overlap).collect();
    assert!(overlaps.len() == 5 && overlaps.iter().copied().fold(f64::INFINITY, f64::min) > 1e-4);
    let read =
        colluvium_case::Solver::scalar_outputs(&rows).into_iter().find(|(name, ..)| name == "chains.grains");
    assert_near(read.unwrap().2, 6.0 / 16.0, 1e-12);
}
