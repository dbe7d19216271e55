//! Estimates of the problem size before grains are placed.

use colluvium_case::Method;
use colluvium_dem::Dem;
use colluvium_testkit::read_case;
use serde_json::json;

#[test]
fn estimated_problem_sizes_match_the_placed_grains() {
    for (space, fill, diameter) in [
        ("plane-strain", json!({ "kind": "random", "solid_fraction": 0.7 }), 0.1),
        ("3d", json!({ "kind": "random", "solid_fraction": 0.5 }), 0.2),
        ("plane-strain", json!({ "kind": "drop-and-roll" }), 0.06),
        ("3d", json!({ "kind": "drop-and-roll" }), 0.15),
        (
            "plane-strain",
            json!({ "kind": "layers", "solid_fraction": 0.75, "layers": 3, "first_solid_fraction": 0.7 }),
            0.1,
        ),
        ("plane-strain", json!({ "kind": "lattice", "packing": "square" }), 0.05),
        ("plane-strain", json!({ "kind": "lattice", "packing": "hexagonal" }), 0.05),
        ("3d", json!({ "kind": "lattice", "packing": "hexagonal" }), 0.1),
        ("3d", json!({ "kind": "lattice", "packing": "body-centred", "pitch": 0.11 }), 0.1),
        ("3d", json!({ "kind": "lattice", "packing": "face-centred" }), 0.1),
    ] {
        let d = if space == "3d" { 3 } else { 2 };
        for shape in [
            json!({ "kind": "box", "min": vec![-1.0; d], "max": vec![1.0; d] }),
            json!({ "kind": "ball", "centre": vec![0.0; d], "radius": 1.0 }),
        ] {
            let case = json!({
                "title": "t", "space": space, "domain": { "min": vec![-2.0; d], "max": vec![2.0; d] },
                "gravity": vec![0.0; d],
                "materials": { "g": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
                "bodies": [{ "name": "b", "material": "g", "shape": shape }],
                "stages": [{ "name": "s", "duration": 1 }],
                "methods": { "dem": {
                    "grains": { "g": { "density": 1, "fill": fill,
                        "diameter": { "distribution": "uniform", "min": 0.9 * diameter, "max": diameter } } },
                    "pairs": [{ "between": ["g", "g"], "normal": { "law": "linear", "stiffness": 1, "damping_ratio": 0.1 },
                                "friction": { "coefficient": 0.5 } }]
                } }
            });
            let case = read_case(&case);
            let (estimated, made) = (Dem.problem_size(&case).unwrap(), Dem.plan(&case).unwrap());
            // Grains at the surface of a ball are left out, and those of a lattice along the sides too.
            let ratio = made.points as f64 / estimated.points;
            assert!((0.75..1.1).contains(&ratio), "{fill} in {shape}: {ratio}");
        }
    }
}
