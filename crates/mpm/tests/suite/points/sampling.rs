//! Points in rows along the sides of a body.

use std::f64::consts::PI;

use colluvium_case::{Case, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::{read_case, solve, start_solver};
use serde_json::{Value, json};

fn mass(space: &str, shape: &Value) -> f64 {
    let text = json!({
        "title": "rows", "space": space, "domain": { "min": [0, 0], "max": [4, 4] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "sampling": "fitted", "shape": shape }],
        "stages": [{ "name": "s", "duration": 1e-3 }],
        "methods": { "mpm": { "cell_size": 0.25 } }
    });
    solve(&Mpm, &read_case(&text)).end.mass
}

/// Areas of patches add up to that of the body, and with their centres to the volume of a ring (Pappus): the closed forms to
/// round-off.
#[test]
fn fitted_points_have_the_mass_of_the_body() {
    let ball = |radius: f64| json!({ "kind": "ball", "centre": [2, 2], "radius": radius });
    let ring = json!({ "kind": "difference", "from": ball(1.5), "cut": ball(0.6) });
    let plane = mass("plane-strain", &ring) / (1e3 * PI * (2.25 - 0.36));
    assert!((plane - 1.0).abs() < 1e-12, "{plane}");
    let torus = mass("axisymmetric", &ball(1.0)) / (1e3 * PI * 2.0);
    assert!((torus - 1.0).abs() < 1e-12, "{torus}");
}

/// A block in space or in the plane, whose points lie at random.
fn random(space: &str, seed: u64) -> Value {
    let d = if space == "3d" { 3 } else { 2 };
    json!({
        "title": "random", "space": space, "domain": { "min": vec![0; d], "max": vec![2; d] }, "gravity": vec![0; d],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "sampling": "poisson-disk", "sampling_seed": seed,
            "shape": { "kind": "box", "min": vec![0.52; d], "max": vec![1.31; d] } }],
        "stages": [{ "name": "s", "duration": 1e-3 }],
        "methods": { "mpm": { "cell_size": 0.25 } }
    })
}

#[test]
fn points_at_random_have_the_mass_of_the_body_and_follow_from_their_seed() {
    // The ring goes around its axis by a radian in the mean of its radii.
    let ring = 0.79 * 0.79 * 0.5 * (0.52 + 1.31);
    for (space, volume) in [("plane-strain", 0.79 * 0.79), ("axisymmetric", ring), ("3d", 0.79 * 0.79 * 0.79)]
    {
        let begun = |seed: u64| start_solver(&Mpm, &read_case(&random(space, seed)));
        let one = begun(7);
        let mass = one.totals().mass;
        assert!((mass / (1000.0 * volume) - 1.0).abs() < 1e-12, "{space}: {mass}");
        let places = |solver: &dyn Solver| solver.snapshot().positions;
        assert_eq!(places(&*one), places(&*begun(7)));
        assert_ne!(places(&*one), places(&*begun(8)));
    }
    // A torus (Pappus) and a cone, of a third of its base times its height.
    let torus = json!({ "kind": "ball", "centre": [1.1, 1], "radius": 0.7 });
    let cone = json!({ "kind": "polygon", "vertices": [[0, 0], [1.2, 0], [0, 1.5]] });
    for (shape, volume) in [(torus, 1.1 * PI * 0.49), (cone, 1.2 * 1.2 * 1.5 / 6.0)] {
        let mut round = random("axisymmetric", 7);
        round["bodies"][0]["shape"] = shape;
        let mass = start_solver(&Mpm, &read_case(&round)).totals().mass;
        assert!((mass / (1000.0 * volume) - 1.0).abs() < 1e-12, "{mass}");
    }
    let mut lattice = random("plane-strain", 7);
    lattice["bodies"][0]["sampling"] = json!("lattice");
    let error = Case::from_json(&lattice.to_string()).unwrap_err().to_string();
    assert!(error.starts_with("bodies[0].sampling_seed: needs `sampling` `poisson-disk`"), "{error}");
}
