//! Zones of the bed, from options and from obstacles.

use std::path::Path;

use colluvium_case::{Case, Method};
use colluvium_depth_sph::DepthSph;
use colluvium_testkit::{advance_exactly_to, write_ascii_grid};
use serde_json::{Value, json};

/// Corner of the map.
const ORIGIN: [f64; 2] = [600_000.0, 5e6];

/// Writes a raster over 80 m by 40 m of the map, of cells of 2 m.
fn raster(folder: &Path, name: &str, value: impl Fn(f64) -> f64) {
    write_ascii_grid(&folder.join(name), ORIGIN, [41, 21], 2.0, |x, _| value(x - ORIGIN[0]));
}

/// Sand that slides down a raster.
fn slide(wall: &Value) -> Value {
    json!({
        "title": "parts", "space": "3d", "gravity": [0, 0, -9.81],
        "domain": { "min": [600_000, 5e6, 0], "max": [600_080, 5_000_040, 60], "origin": [600_000, 5e6, 0] },
        "materials": { "sand": {
            "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 45
        } },
        "bodies": [{ "name": "mass", "material": "sand",
            "shape": { "kind": "box", "min": [600_010, 5_000_016, 0], "max": [600_018, 5_000_024, 48] } }],
        "obstacles": [{ "name": "slope", "shape": { "kind": "raster", "file": "terrain.asc" }, "wall": wall }],
        "stages": [{ "name": "release", "duration": 4 }],
        "methods": { "depth-sph": { "spacing": 1 } }
    })
}

fn places(folder: &Path, value: &Value) -> Vec<[f64; 3]> {
    let case = Case::from_value(value, folder).unwrap();
    let mut solver = DepthSph.build(&case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    advance_exactly_to(solver.as_mut(), 4.0);
    solver.snapshot().positions
}

fn refused(folder: &Path, value: &Value) -> String {
    match Case::from_value(value, folder) {
        Ok(case) => DepthSph.plan(&case).map(|_| ()).unwrap_err().to_string(),
        Err(errors) => errors.to_string(),
    }
}

fn friction(coefficient: f64) -> Value {
    json!({ "kind": "frictional", "friction_coefficient": coefficient })
}

/// Forest from 30 m on gives equal results as cells of land cover and as a shape, in the options and at the obstacle.
#[test]
fn cells_of_a_raster_and_regions_of_an_obstacle_are_parts_of_the_bed() {
    let folder = tempfile::tempdir().unwrap();
    raster(folder.path(), "terrain.asc", |x| 50.0 - 0.4 * x);
    // Cells reach from 1 m before their centres.
    raster(folder.path(), "cover.asc", |x| if x > 31.0 { 3.0 } else { 1.0 });
    raster(folder.path(), "forest.asc", |x| if x > 31.0 { 3.0 } else { f64::NAN });
    let mut value = slide(&friction(0.2));
    let free = places(folder.path(), &value);
    let shape =
        json!({ "shape": { "kind": "box", "min": [600_031, 4_999_999], "max": [600_081, 5_000_041] } });
    let cells = json!({ "raster": { "file": "cover.asc", "value": 3 } });
    let any = json!({ "raster": { "file": "forest.asc" } });
    let with = |place: &Value, key: &str, what: Value| {
        let mut region = place.clone();
        region[key] = what;
        json!([region])
    };
    value["methods"]["depth-sph"]["regions"] =
        with(&shape, "basal", json!({ "model": "coulomb", "friction_angle": 40 }));
    let of_options = places(folder.path(), &value);
    let furthest = |places: &[[f64; 3]]| places.iter().map(|x| x[0]).fold(0.0, f64::max);
    assert!(furthest(&of_options) + 5.0 < furthest(&free), "{} {}", furthest(&of_options), furthest(&free));
    for place in [&cells, &any] {
        value["methods"]["depth-sph"]["regions"] =
            with(place, "basal", json!({ "model": "coulomb", "friction_angle": 40 }));
        assert_eq!(places(folder.path(), &value), of_options);
    }
    value["methods"]["depth-sph"]["regions"] = json!([]);
    let tangent = 40f64.to_radians().tan();
    for place in [&shape, &cells, &any] {
        value["obstacles"][0]["regions"] = with(place, "wall", friction(tangent));
        let of_obstacle = places(folder.path(), &value);
        for (a, b) in of_obstacle.iter().zip(&of_options) {
            assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-6), "{a:?} {b:?}");
        }
        // A zone of the options without a resistance leaves that to the obstacle.
        let mut eroded = value.clone();
        eroded["methods"]["depth-sph"]["regions"] =
            with(&shape, "erosion", json!({ "law": "hungr", "rate": 0.0 }));
        assert_eq!(places(folder.path(), &eroded), of_obstacle);
    }
}

#[test]
fn parts_of_a_bed_that_contradict_each_other_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    raster(folder.path(), "terrain.asc", |x| 50.0 - 0.4 * x);
    raster(folder.path(), "cover.asc", |x| if x > 31.0 { 3.0 } else { 1.0 });
    let region = |value: f64, wall: Value| json!([{ "raster": { "file": "cover.asc", "value": value }, "wall": wall }]);
    let mut value = slide(&friction(0.2));
    value["obstacles"][0]["regions"] = region(3.0, friction(0.5));
    value["methods"]["depth-sph"]["basal"] = json!({ "model": "coulomb", "friction_angle": 20 });
    let found = refused(folder.path(), &value);
    assert!(
        found.starts_with("obstacles[0].regions: methods.depth-sph.basal applies to the whole bed"),
        "{found}"
    );
    let mut value = slide(&friction(0.2));
    value["obstacles"][0]["regions"] = region(2.0, friction(0.5));
    let found = refused(folder.path(), &value);
    assert!(found.starts_with("obstacles[0].regions[0].raster.value: no cell of /"), "{found}");
    assert!(found.ends_with("cover.asc has 2: the values are 1, 3"), "{found}");
    value["obstacles"][0]["regions"] =
        region(3.0, json!({ "kind": "frictional", "friction_coefficient": 0.1, "adhesion": 5 }));
    let found = refused(folder.path(), &value);
    assert!(found.starts_with("obstacles[0].regions[0].wall.adhesion: "), "{found}");
    value["obstacles"][0]["regions"] = region(3.0, friction(0.5));
    value["obstacles"].as_array_mut().unwrap().push(json!({ "name": "block", "wall": friction(0.2),
        "shape": { "kind": "box", "min": [600_040, 5_000_010, 0], "max": [600_044, 5_000_014, 40] } }));
    let found = refused(folder.path(), &value);
    assert!(found.starts_with("obstacles[0].regions: several obstacles are the bed"), "{found}");
    let mut value = slide(&friction(0.2));
    value["methods"]["depth-sph"]["regions"] =
        json!([{ "raster": { "file": "cover.asc", "value": 2 }, "drainage": { "kind": "atmospheric" } }]);
    value["methods"]["depth-sph"]["column"] = json!({ "consolidation": 0.01 });
    value["methods"]["depth-sph"]["mixture"] = json!({ "grain_density": 2000, "porosity": 0.4 });
    let found = refused(folder.path(), &value);
    assert!(found.starts_with("methods.depth-sph.regions[0].raster.value: no cell of /"), "{found}");
}
