//! Reached area of a flow against a mapped outline.

use colluvium_case::{Case, Method, Solver};
use colluvium_depth_sph::DepthSph;
use serde_json::{Value, json};

/// Water, 6 m by 4 m, that does not move: cells of half a metre.
fn pond(mapped: &str) -> Value {
    json!({
        "title": "pond", "space": "3d", "gravity": [0, 0, -9.81],
        "domain": { "min": [0, 0, 0], "max": [20, 10, 5] },
        "materials": { "mud": {
            "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 45
        } },
        "bodies": [{ "name": "pond", "material": "mud", "shape": { "kind": "box", "min": [4, 3, 0], "max": [10, 7, 0.5] } }],
        "boundaries": [{ "side": "z-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "rest", "duration": 1 }],
        "output": { "rasters": { "cell": 0.5, "threshold": 0.2, "mapped": mapped } },
        "methods": { "depth-sph": { "spacing": 0.25 } }
    })
}

fn readings(solver: &dyn Solver) -> [f64; 4] {
    let all = solver.scalar_outputs();
    ["mapped_hit", "mapped_missed", "mapped_beyond", "mapped_fit"]
        .map(|name| all.iter().find(|(own, ..)| own == name).unwrap().2)
}

#[test]
fn areas_are_those_of_the_outlines() {
    let folder = tempfile::tempdir().unwrap();
    // It begins 2 m later than the pond and ends 3 m later, as wide as that.
    let ring = [[6.0, 3.0], [13.0, 3.0], [13.0, 7.0], [6.0, 7.0], [6.0, 3.0]];
    std::fs::write(
        folder.path().join("mapped.geojson"),
        json!({ "type": "Polygon", "coordinates": [ring] }).to_string(),
    )
    .unwrap();
    let case = Case::from_value(&pond("mapped.geojson"), folder.path()).unwrap();
    let mut solver = DepthSph.build(&case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    let [hit, missed, beyond, fit] = readings(solver.as_ref());
    // Cells at the rim of the pond contain half of its depth.
    assert!(
        (hit - 16.0).abs() < 2.0 && (missed - 12.0).abs() < 2.0 && (beyond - 8.0).abs() < 4.0,
        "{hit} {missed} {beyond}"
    );
    assert!((hit + missed - 28.0).abs() < 1e-9, "the outline's own area");
    assert!((fit - hit / (hit + missed + beyond)).abs() < 1e-12);
    // Half of it beyond the cells counts as missed; on a grid of half a metre its sides go through centres of cells.
    let far = |low: f64, high: f64| {
        let ring = [[low, 3.25], [high, 3.25], [high, 7.25], [low, 7.25], [low, 3.25]];
        let text = json!({ "type": "Polygon", "coordinates": [ring] }).to_string();
        std::fs::write(folder.path().join("far.geojson"), text).unwrap();
        Case::from_value(&pond("far.geojson"), folder.path()).unwrap()
    };
    let case = far(10.0, 30.0);
    let [hit, missed, ..] = readings(DepthSph.build(&case).unwrap().as_ref());
    assert!((hit + missed - 4.0 * 20.0).abs() < 1e-6, "{hit} {missed}");
    let warnings = DepthSph.plan(&case).unwrap().warnings;
    assert!(
        warnings.iter().any(|warning| warning.text.contains("50.0 % of the outline's area")),
        "{warnings:?}"
    );
    let beside = DepthSph.plan(&far(30.0, 40.0)).map(|_| ()).unwrap_err().to_string();
    assert!(beside.ends_with("lies outside the terrain"), "{beside}");
    let refused = |file: &str| {
        let case = Case::from_value(&pond(file), folder.path()).unwrap();
        DepthSph.plan(&case).map(|_| ()).unwrap_err().to_string()
    };
    assert!(refused("none.geojson").starts_with("output.rasters.mapped: /"), "{}", refused("none.geojson"));
}
