//! Files of points and their errors.

use crate::bodies::point_file::*;

fn case(points: &str, more: &str) -> (tempfile::TempDir, Case) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("points.csv"), points).unwrap();
    let text = format!(
        r#"{{
        "title": "t", "space": "plane-strain", "domain": {{ "min": [0, 0], "max": [2, 2] }}, "gravity": [0, -10],
        "materials": {{ "m": {{ "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 }} }},
        "bodies": [{{ "name": "b", "material": "m", "shape": {{ "kind": "box", "min": [0, 0], "max": [1, 1] }},
            "points": {{ "file": "points.csv" }} {more} }}],
        "stages": [{{ "name": "s", "duration": 1 }}]
    }}"#
    );
    let value = crate::files::json::parse(&text).unwrap();
    let case = Case::from_value(&value, folder.path()).unwrap();
    (folder, case)
}

#[test]
fn columns_in_any_order_give_places_volumes_velocities_and_stresses() {
    let text = "# from a tomography\ny (m), x (m), stress_yy (Pa), volume (m2), velocity_x (m/s), pore_pressure (Pa)\n\
                0.5, 0.25, -3e3, 0.01, 2, 4e3\n1, 0, -1, 0.03, -1, -5\n";
    let (_folder, case) = case(text, "");
    let list = case.point_list(0).unwrap().unwrap();
    assert_eq!(list.positions, [[0.25, 0.5, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(list.volumes, [0.01, 0.03]);
    assert_eq!(list.pore_pressures, Some(vec![4e3, -5.0]));
    assert_eq!(list.velocities, Some(vec![[2.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]));
    let stress = SymTensor([0.0, -3e3, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(list.stresses.as_ref().unwrap()[0], stress);
    assert_eq!(case.initial_stress_of(&case.bodies[0], Some(&list), 0, list.positions[0]), stress);
    assert!((list.spacing(2) - 0.02f64.sqrt()).abs() < 1e-15);
    let samples = list.samples::<2>();
    assert_eq!((samples[1].position, samples[1].volume), ([0.0, 1.0], 0.03));
}

#[test]
fn units_in_brackets_are_applied_and_semicolons_separate_columns() {
    let text = "x (mm);y [cm];volume (cm2);velocity_x (km/h);stress_yy (kPa);pore_pressure (kN/m²);radius (ft)\n\
                250,5;50;100;7,2;-3;4;0,5\n";
    let (_folder, case) = case(text, "");
    let list = case.point_list(0).unwrap().unwrap();
    let near =
        |found: f64, right: f64| assert!((found - right).abs() <= 1e-12 * right.abs(), "{found} for {right}");
    near(list.positions[0][0], 0.2505);
    near(list.positions[0][1], 0.5);
    near(list.volumes[0], 0.01);
    near(list.velocities.unwrap()[0][0], 2.0);
    near(list.stresses.unwrap()[0].0[1], -3e3);
    near(list.pore_pressures.unwrap()[0], 4e3);
    near(list.grains.radii.unwrap()[0], 0.1524);
}

#[test]
fn dry_density_of_a_point_is_its_mass_less_that_of_its_pore_fluid() {
    let (_folder, dry) = case("x,y,volume,mass\n0.5,0.5,0.01,20\n0.6,0.5,0.01,30\n", "");
    let list = dry.point_list(0).unwrap().unwrap();
    assert_eq!(list.masses, Some(vec![20.0, 30.0]));
    assert_eq!([0, 1].map(|point| dry.density_at(0, Some(&list), point).unwrap()), [2000.0, 3000.0]);
    assert_eq!(dry.density_at(0, None, 0).unwrap(), 1.0);
    let fluid = r#", "pore_fluid": { "porosity": 0.5, "permeability": 1e-3, "density": 1000 }"#;
    let (_folder, wet) = case("x,y,volume,mass\n0.5,0.5,0.01,20\n0.6,0.5,0.01,4\n", fluid);
    let list = wet.point_list(0).unwrap().unwrap();
    assert_eq!(wet.density_at(0, Some(&list), 0).unwrap(), 1500.0);
    let refused = wet.density_at(0, Some(&list), 1).unwrap_err().to_string();
    assert!(
        refused.starts_with("bodies[0].points.file: the point at [0.6, 0.5, 0.0] m has a density of"),
        "{refused}"
    );
}

#[test]
fn grains_have_radii_kinds_spins_and_numbers_and_the_volume_of_a_disk() {
    let text = "x,y,radius,kind,spin_z,held,id\n0.5,0.5,0.1,gravel,2,1,7\n0.2,0.2,0.05,sand,0,0,3\n";
    let (_folder, case) = case(text, "");
    let list = case.point_list(0).unwrap().unwrap();
    assert!((list.volumes[0] - 0.01 * std::f64::consts::PI).abs() < 1e-15);
    let grains = GrainColumns {
        radii: Some(vec![0.1, 0.05]),
        grain_types: Some(vec!["gravel".into(), "sand".into()]),
        spins: Some(vec![[0.0, 0.0, 2.0], [0.0; 3]]),
        is_held: Some(vec![true, false]),
        ids: Some(vec![7, 3]),
    };
    assert_eq!(list.grains, grains);
}

#[test]
fn every_mistake_in_a_list_is_named_with_its_line_and_column() {
    let head = "x,y,volume\n0.5,0.5,1\n";
    let mistakes = [
        (format!("{head}0.2,a,1\n"), "", "line 3, column \"y\": \"a\" is not a finite number"),
        (format!("{head}0.2,inf,1\n"), "", "line 3, column \"y\": \"inf\" is not a finite number"),
        (format!("{head}# a remark\n0.2,0.1,-1\n"), "", "line 4, column \"volume\": -1 must be positive"),
        (format!("{head}\n\n0.2,0.1,0\n"), "", "line 5, column \"volume\": 0 must be positive"),
        (format!("# of\n{head}#\n0.2,0.1\n"), "", "line 5: has 2 values, the head has 3 columns"),
        (format!("{head}0.2,0.1\n"), "", "line 3: has 2 values, the head has 3 columns"),
        (format!("{head}1.2,0.1,1\n"), "", "line 3: the point at [1.2, 0.1] m is not in the body's shape"),
        (format!("{head}0.1,0.1,1\n0.5,0.5,2\n"), "", "line 4: has the same position as line 2"),
        ("x,y,radius\n0.5,0.5,0\n".to_owned(), "", "line 2, column \"radius\": 0 must be positive"),
        (
            "x,y,radius,held\n0.5,0.5,1,2\n".to_owned(),
            "",
            "\"held\": \"2\" is not a whole number from 0 to 1",
        ),
        ("x,y,radius,id\n0.5,0.5,1,-1\n".to_owned(), "", "\"id\": \"-1\" is not a whole number"),
        ("x,y,radius,spin_x\n".to_owned(), "", "unknown column \"spin_x\"; did you mean \"spin_z\"?"),
        ("0.5,0.5,1\n".to_owned(), "", "has no names of columns in its first line, for example x,y"),
        ("x (yd),y,volume\n".to_owned(), "", "column \"x (yd)\": the unit must be one of a length"),
        ("x,y,volume (kg)\n".to_owned(), "", "column \"volume (kg)\": the unit must be one of a volume"),
        ("x,y,volum\n".to_owned(), "", "unknown column \"volum\"; did you mean \"volume\"?"),
        ("x,z,volume\n".to_owned(), "", "unknown column \"z\""),
        ("x,x,volume\n".to_owned(), "", "two columns are called \"x\""),
        ("x,volume\n".to_owned(), "", "the column \"y\" is missing"),
        ("x,y\n".to_owned(), "", "the column \"volume\" is missing, and `spacing` is not given"),
        ("x,y,volume\n".to_owned(), "", "contains no points"),
        (
            "x,y,volume,velocity_x\n".to_owned(),
            r#", "velocity": { "kind": "uniform", "value": [1, 0] }"#,
            "has velocities, but the body also has `velocity`",
        ),
        (
            "x,y,volume,stress_xy\n".to_owned(),
            r#", "stress": { "kind": "uniform", "value": [1, 0, 0, 0, 0, 0] }"#,
            "has stresses, but the body also has `stress`",
        ),
        ("x,y,volume,stress_xy\n".to_owned(), r#", "rigid": true"#, "a rigid body begins at rest"),
        (
            "x,y,volume,pore_pressure\n".to_owned(),
            r#", "pore_fluid": { "porosity": 0.4, "permeability": 1e-3, "pressure": { "kind": "uniform", "value": 1 } }"#,
            "has pore pressures, but the body also has `pore_fluid.pressure`",
        ),
    ];
    for (text, more, words) in mistakes {
        let (folder, case) = case(&text, more);
        let error = case.point_list(0).unwrap_err().to_string();
        let file = folder.path().join("points.csv");
        let start = format!("bodies[0].points.file: {}: ", file.display());
        assert!(error.starts_with(&start) && error.contains(words), "{text:?}: {error}");
    }
    let (folder, case) = case(head, "");
    std::fs::remove_file(folder.path().join("points.csv")).unwrap();
    assert!(case.point_list(0).unwrap_err().to_string().contains("cannot be read"));
}

#[test]
fn the_fingerprint_of_a_case_changes_with_its_point_file() {
    let (folder, case) = case("x,y,volume\n0.5,0.5,1\n", "");
    let before = case.fingerprint();
    assert_eq!(case.fingerprint(), before);
    std::fs::write(folder.path().join("points.csv"), "x,y,volume\n0.5,0.5,2\n").unwrap();
    assert_ne!(case.fingerprint(), before);
}

#[cfg(unix)]
#[test]
fn device_files_are_refused_as_point_files() {
    let (folder, case) = case("x,y,volume\n0.5,0.5,1\n", "");
    let mut value: serde_json::Value = serde_json::from_str(&case.to_json()).unwrap();
    value["bodies"][0]["points"]["file"] = serde_json::json!("/dev/zero");
    let error = Case::from_value(&value, folder.path()).unwrap_err().to_string();
    assert_eq!(error, "bodies[0].points.file: /dev/zero: is not a regular file");
}
