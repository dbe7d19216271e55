//! Localisation bands in particles: the band length is two spacings (sheet: sph §0; constitutive §2.16).

use colluvium_case::{Case, Method};
use colluvium_sph::Sph;
use colluvium_testkit::cohesive_bar::{
    self, DENSITY, ENERGY, LENGTH, PULL_SPEED, STIFFNESS, WEAK_STRENGTH_RATIO, cohesive_material,
};
use colluvium_testkit::{read_case, start_solver};
use serde_json::{Value, json};

/// Bar with a weak row in its middle, in one dimension.
fn on_a_line(spacing: f64, sph: &Value) -> Case {
    bar(
        "1d",
        &json!([]),
        spacing,
        &|x, _| json!([x]),
        &|from, to| json!({ "kind": "box", "min": [from], "max": [to] }),
        sph,
    )
}

/// Bar with a weak row in its middle, of six rows in the plane, periodic across the bar.
fn of_rows(spacing: f64, sph: &Value) -> Case {
    let half = 3.0 * spacing;
    let part = |from: f64, to: f64| json!({ "kind": "box", "min": [from, -half], "max": [to, half] });
    bar("plane-strain", &json!(["y"]), spacing, &|x, y| json!([x, y * half]), &part, sph)
}

/// Bar with given parts between two positions, in a domain with corners at (±1, ±1) of its length and height.
fn bar(
    space: &str,
    periodic: &Value,
    spacing: f64,
    place: &dyn Fn(f64, f64) -> Value,
    part: &dyn Fn(f64, f64) -> Value,
    sph: &Value,
) -> Case {
    let (grip, row, end) = (4.0 * spacing, 0.5 * spacing, 0.5 * LENGTH);
    let reach = end + 5.0 * spacing;
    let mut methods = json!({ "spacing": spacing, "held": ["left", "right"] });
    methods.as_object_mut().unwrap().extend(sph.as_object().unwrap().clone());
    let grips = json!({ "model": "linear-elastic", "density": DENSITY, "youngs_modulus": STIFFNESS, "poissons_ratio": 0 });
    read_case(&json!({
        "title": "bar", "space": space, "gravity": if space == "1d" { json!([0]) } else { json!([0, 0]) },
        "domain": { "min": place(-reach, -1.0), "max": place(reach, 1.0), "periodic": periodic },
        "materials": { "strong": cohesive_material(1.0, ENERGY), "weak": cohesive_material(WEAK_STRENGTH_RATIO, ENERGY), "grip": grips },
        "bodies": [
            { "name": "left", "material": "grip", "shape": part(-end - grip, -end) },
            { "name": "near", "material": "strong", "shape": part(-end, -row) },
            { "name": "middle", "material": "weak", "shape": part(-row, row) },
            { "name": "far", "material": "strong", "shape": part(row, end) },
            { "name": "right", "material": "grip", "shape": part(end, end + grip),
              "velocity": { "kind": "uniform", "value": place(PULL_SPEED, 0.0) } }],
        "stages": [{ "name": "pull", "duration": 20 }],
        "methods": { "sph": methods }
    }))
}

/// Work of the grips over the fracture energy.
fn work_over_energy(case: &Case) -> f64 {
    cohesive_bar::work_over_energy(&mut *start_solver(&Sph, case), &(-0.4 * LENGTH..-0.25 * LENGTH))
}

/// With a band length of one spacing the work would be twice the fracture energy, at any spacing.
#[test]
fn a_bar_in_tension_dissipates_its_fracture_energy() {
    for rows in [20.0, 40.0] {
        let spacing = LENGTH / (rows + 1.0);
        for (name, case) in [
            ("rows", of_rows(spacing, &json!({}))),
            ("line", on_a_line(spacing, &json!({}))),
            ("line in the total form", on_a_line(spacing, &json!({ "formulation": "total-lagrangian" }))),
        ] {
            let found = work_over_energy(&case);
            assert!((found - 1.0).abs() < 0.05, "{name} of {rows}: {found}");
        }
    }
}

#[test]
fn options_that_spread_a_crack_and_snap_back_are_refused_with_a_remedy() {
    let refused =
        |case: &Case| Sph.build(case).map(|_| ()).map_err(|error| (error.path.clone(), error.problem()));
    assert_eq!(refused(&of_rows(0.1, &json!({}))), Ok(()));
    let (path, problem) = refused(&of_rows(0.1, &json!({ "smoothing": 1.5 }))).unwrap_err();
    assert_eq!(path, "methods.sph.smoothing");
    assert!(problem.contains("at most 1.2") && problem.contains("\"strong\""), "{problem}");
    let (path, problem) = refused(&of_rows(0.1, &json!({ "kernel": "wendland-c2" }))).unwrap_err();
    assert_eq!(path, "methods.sph.kernel");
    assert!(problem.contains("cubic-spline"), "{problem}");
    // E G/f_t² is 0.08 m. Without a Poisson's ratio the shear modulus is half of E, so that a sliding band shows snap-back from 0.04 m on,
    // less its stretch before softening; a spacing is half of that.
    let mut brittle: Value = serde_json::from_str(&of_rows(0.1, &json!({})).to_json()).unwrap();
    brittle["materials"]["strong"] = cohesive_material(1.0, 8e-4);
    let (path, problem) = refused(&read_case(&brittle)).unwrap_err();
    assert_eq!(path, "methods.sph.spacing");
    let from: f64 = problem
        .split("\"strong\" show snap-back from ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!((from / 0.02 - 1.0).abs() < 1e-3, "{problem}");
}

#[test]
fn soil_beside_a_rigid_body_causes_a_warning_that_it_sticks() {
    let warnings = |rigid: bool, material: &Value| {
        let case = read_case(&json!({
            "title": "block", "space": "plane-strain", "gravity": [0, -9.81],
            "domain": { "min": [-1, -1], "max": [1, 1] },
            "materials": { "soil": material, "steel": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 } },
            "bodies": [
                { "name": "fill", "material": "soil", "shape": { "kind": "box", "min": [-0.5, -0.5], "max": [0.5, 0] } },
                { "name": "block", "material": "steel", "rigid": rigid, "shape": { "kind": "box", "min": [-0.2, 0], "max": [0.2, 0.3] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "sph": { "spacing": 0.1 } }
        }));
        colluvium_testkit::lines(&Sph.plan(&case).unwrap().warnings)
    };
    let sand = json!({ "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e6, "poissons_ratio": 0.3, "friction_angle": 30 });
    let text = warnings(true, &sand);
    assert!(
        text.contains("\"fill\" sticks to the rigid body \"block\"") && text.contains("obstacle"),
        "{text}"
    );
    assert!(!warnings(false, &sand).contains("sticks"));
    let water = json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e6, "viscosity": 0.1 });
    assert!(!warnings(true, &water).contains("sticks"));
}
