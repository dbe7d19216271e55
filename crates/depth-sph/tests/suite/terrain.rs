//! Depth-integrated SPH over terrain from a case file: a raster as bed.

use std::path::Path;

use colluvium_case::{Case, Method, Solver};
use colluvium_depth_sph::DepthSph;
use colluvium_points::Raster;
use colluvium_testkit::{advance_exactly_to, read_case};
use serde_json::{Value, json};

const GRAVITY: f64 = 9.81;

/// Writes the terrain, an ESRI ASCII grid of `z` over a window.
fn grid(folder: &Path, low: [f64; 2], counts: [usize; 2], spacing: f64, z: impl Fn(f64, f64) -> f64) {
    colluvium_testkit::write_ascii_grid(&folder.join("terrain.asc"), low, counts, spacing, z);
}

/// Body of sand over a raster, with its own friction of 30°.
fn over_raster(shape: &Value, wall: &Value) -> Value {
    json!({
        "title": "over terrain", "space": "3d", "gravity": [0, 0, -GRAVITY],
        "domain": { "min": [0, 0, 0], "max": [80, 20, 60] },
        "materials": { "sand": {
            "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "mass", "material": "sand", "shape": shape }],
        "obstacles": [{ "name": "slope", "shape": { "kind": "raster", "file": "terrain.asc" }, "wall": wall }],
        "stages": [{ "name": "release", "duration": 3 }],
        "methods": { "depth-sph": { "spacing": 1 } }
    })
}

fn case(folder: &Path, value: &Value) -> Case {
    Case::from_value(value, folder).unwrap()
}

fn run(case: &Case, time: f64) -> Box<dyn Solver> {
    let mut solver = DepthSph.build(case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    advance_exactly_to(solver.as_mut(), time);
    solver
}

/// A single node on a raster of 30° is a block on a plane: `s = ½ g (sin θ - cos θ tan φ) t²`.
#[test]
fn a_block_slides_down_a_raster_as_down_an_inclined_plane() {
    let folder = tempfile::tempdir().unwrap();
    let (slope, angle) = (30f64.to_radians().tan(), 30f64.to_radians());
    grid(folder.path(), [0.0, 0.0], [41, 11], 2.0, |x, _| 50.0 - slope * x);
    let block = json!({ "kind": "box", "min": [10, 10, 0], "max": [11, 11, 50] });
    for (wall, friction) in [
        (json!({ "kind": "frictional", "friction_coefficient": 0.3 }), 0.3),
        (json!({ "kind": "frictional", "friction_coefficient": 0.9 }), slope),
        (json!({ "kind": "rough" }), slope),
        (json!({ "kind": "smooth" }), 0.0),
    ] {
        let solver = run(&case(folder.path(), &over_raster(&block, &wall)), 3.0);
        let along = (solver.snapshot().positions[0][0] - 10.5) / angle.cos();
        let exact = 0.5 * GRAVITY * (angle.sin() - angle.cos() * friction) * 9.0;
        // V26: 0.5 %. On a plane the digits of the file are the only error.
        assert!((along - exact).abs() < 1e-9 * exact.max(1.0), "{wall}: {along} for {exact}");
    }
}

/// A slope as a plane and as a raster gives equal results.
#[test]
fn a_raster_of_a_plane_is_that_plane() {
    let folder = tempfile::tempdir().unwrap();
    let slope = 30f64.to_radians().tan();
    grid(folder.path(), [0.0, 0.0], [41, 11], 2.0, |x, _| 50.0 - slope * x);
    let heap = json!({ "kind": "intersection", "shapes": [
        { "kind": "box", "min": [9, 7, 0], "max": [15, 13, 60] },
        { "kind": "ball", "centre": [12, 10, 43], "radius": 4.5 } ] });
    let wall = json!({ "kind": "frictional", "friction_coefficient": 0.3 });
    let raster = over_raster(&heap, &wall);
    let mut plane = raster.clone();
    plane["obstacles"][0]["shape"] = json!({ "kind": "plane", "point": [0, 0, 50], "normal": [slope, 0, 1] });
    let place = |value: &Value| run(&case(folder.path(), value), 1.5).snapshot().positions;
    for (a, b) in place(&raster).iter().zip(place(&plane)) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-7), "{a:?} {b:?}");
    }
}

/// V12b as amended demands less than a hundredth of the celerity after ten seconds.
#[test]
fn a_lake_in_a_basin_of_a_raster_stays_at_rest() {
    let folder = tempfile::tempdir().unwrap();
    let basin = |x: f64, y: f64| 0.02 * ((x - 20.0).powi(2) + (y - 10.0).powi(2)) + 0.1 * (0.7 * x).sin();
    grid(folder.path(), [0.0, 0.0], [81, 41], 0.5, basin);
    let mut value = over_raster(
        &json!({ "kind": "box", "min": [9, 1, 0], "max": [31, 19, 1.2] }),
        &json!({ "kind": "smooth" }),
    );
    value["domain"] = json!({ "min": [0, 0, 0], "max": [40, 20, 10] });
    value["methods"]["depth-sph"] =
        json!({ "spacing": 0.25, "surface_gradient": true, "terrain_smoothing": 0 });
    let case = case(folder.path(), &value);
    let warnings = DepthSph.plan(&case).unwrap().warnings;
    assert!(
        warnings.iter().any(|warning| warning.text.contains("% of the volume lies below the bed")),
        "{warnings:?}"
    );
    let solver = run(&case, 10.0);
    let snapshot = solver.snapshot();
    let depth = snapshot.scalars("depth").unwrap();
    let speeds = match &snapshot.field("velocity").unwrap().data {
        colluvium_case::FieldData::Vector(v) => v.clone(),
        _ => unreachable!(),
    };
    let deepest = depth.iter().copied().fold(0.0, f64::max);
    let fastest = speeds.iter().map(|v| v[0].hypot(v[1])).fold(0.0, f64::max);
    assert!(deepest > 1.0, "{deepest}");
    assert!(fastest < 1e-2 * (GRAVITY * deepest).sqrt(), "{fastest} m/s");
}

#[test]
fn nodes_that_leave_the_raster_are_counted_or_end_the_run() {
    let folder = tempfile::tempdir().unwrap();
    grid(folder.path(), [0.0, 0.0], [16, 11], 2.0, |x, _| 40.0 - x);
    let mut value = over_raster(
        &json!({ "kind": "box", "min": [20, 8, 0], "max": [24, 12, 25] }),
        &json!({ "kind": "smooth" }),
    );
    value["domain"]["max"] = json!([30, 20, 60]);
    let all = case(folder.path(), &value);
    let mut solver = DepthSph.build(&all).unwrap();
    let volume = |solver: &dyn Solver, name: &str| {
        solver.scalar_outputs().iter().find(|(reading, ..)| reading == name).unwrap().2
    };
    let before = volume(solver.as_ref(), "flow_volume");
    solver.begin_stage(0, 0.0).unwrap();
    advance_exactly_to(solver.as_mut(), 3.0);
    let (left, stayed) = (volume(solver.as_ref(), "volume_left"), volume(solver.as_ref(), "flow_volume"));
    assert!(left > 0.0 && (left + stayed - before).abs() < 1e-9 * before, "{left} {stayed} {before}");
    assert!(solver.warnings_at_end().iter().any(|remark| remark.text.contains("have left the terrain")));
    value["methods"]["depth-sph"]["leaving_is_an_error"] = json!(true);
    let mut solver = DepthSph.build(&case(folder.path(), &value)).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    let error = loop {
        if let Err(error) = solver.step(3.0) {
            break error.to_string();
        }
        assert!(solver.time() < 10.0);
    };
    assert!(error.contains("it has left the terrain"), "{error}");
}

/// The run continues to its end, and has rasters of the flow that has passed.
#[test]
fn a_flow_that_has_left_the_domain_completely_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    grid(folder.path(), [0.0, 0.0], [16, 11], 2.0, |x, _| 40.0 - x);
    let shape = json!({ "kind": "box", "min": [24, 8, 0], "max": [28, 12, 17] });
    let mut value = over_raster(&shape, &json!({ "kind": "smooth" }));
    value["domain"]["max"] = json!([30, 20, 60]);
    value["output"] = json!({ "rasters": {} });
    let solver = run(&case(folder.path(), &value), 30.0);
    assert_eq!((solver.point_count(), solver.snapshot().positions.len()), (0, 0));
    let peak = raster(solver.as_ref(), "peak_thickness_vertical");
    assert!(known(&peak).fold(0.0, f64::max) > 1.0);
    let left = solver.scalar_outputs().iter().find(|(reading, ..)| reading == "volume_left").unwrap().2;
    assert!(
        left > 10.0
            && solver.warnings_at_end().iter().any(|remark| remark.text.contains("have left the terrain"))
    );
}

#[test]
fn a_smoothed_flow_that_leaves_along_a_wall_ends_without_nodes() {
    let folder = tempfile::tempdir().unwrap();
    grid(folder.path(), [0.0, 0.0], [16, 11], 2.0, |x, _| 40.0 - x);
    let shape = json!({ "kind": "box", "min": [24, 14, 0], "max": [28, 20, 17] });
    let mut value = over_raster(&shape, &json!({ "kind": "smooth" }));
    value["domain"]["max"] = json!([30, 20, 60]);
    value["boundaries"] = json!([{ "side": "y-max", "wall": { "kind": "smooth" } }]);
    value["methods"]["depth-sph"]["xsph"] = json!(0.1);
    assert_eq!(run(&case(folder.path(), &value), 30.0).point_count(), 0);
}

#[test]
fn invalid_terrain_is_refused_by_path() {
    let folder = tempfile::tempdir().unwrap();
    grid(folder.path(), [0.0, 0.0], [16, 11], 2.0, |x, y| {
        if (x - 20.0).abs() < 1.0 && (y - 10.0).abs() < 1.0 { f64::NAN } else { 40.0 - x }
    });
    let mass = json!({ "kind": "box", "min": [4, 8, 0], "max": [8, 12, 40] });
    let sound = over_raster(&mass, &json!({ "kind": "rough" }));
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut value = sound.clone();
        change(&mut value);
        DepthSph.plan(&case(folder.path(), &value)).map(|_| ()).unwrap_err().to_string()
    };
    let starts = |text: String, start: &str| assert!(text.starts_with(start), "{text}");
    starts(
        refused(&|v| v["bodies"][0]["shape"]["min"] = json!([4, 8, 39])),
        "bodies[0].shape: there is a gap from",
    );
    let moved = json!({ "kind": "box", "min": [18, 8, 0], "max": [22, 12, 40] });
    starts(
        refused(&|v| v["bodies"][0]["shape"] = moved.clone()),
        "bodies[0].shape: there is no ground below",
    );
    let off = json!({ "kind": "box", "min": [28, 8, 0], "max": [34, 12, 40] });
    starts(refused(&|v| v["bodies"][0]["shape"] = off.clone()), "bodies[0].shape: there is no ground below");
    starts(
        refused(&|v| v["methods"]["depth-sph"]["frame"] = json!("bed-fitted")),
        "methods.depth-sph.frame: must not be bed-fitted",
    );
    starts(refused(&|v| v["gravity"] = json!([1, 0, -9])), "gravity[0]: must be 0 over an obstacle");
    let floor = json!([{ "side": "z-min", "position": 20, "wall": { "kind": "smooth" } }]);
    starts(refused(&|v| v["boundaries"] = floor.clone()), "boundaries[0].wall: is at 20 m, above the lowest");
    let ball = json!({ "kind": "ball", "centre": [20, 10, 5], "radius": 4 });
    starts(
        refused(&|v| v["obstacles"][0]["shape"] = ball.clone()),
        "bodies[0].shape: there is no ground below",
    );
    let second = |kind: &str| json!({ "name": "other", "shape": ball, "wall": { "kind": kind } });
    starts(
        refused(&|v| v["obstacles"].as_array_mut().unwrap().push(second("smooth"))),
        "obstacles[1].wall: is not that of \"slope\"",
    );
    let tall = json!({ "kind": "box", "min": [2, 2, 0], "max": [9, 9, 70] });
    let tower = json!({ "name": "tower", "shape": tall, "wall": { "kind": "rough" } });
    starts(
        refused(&|v| v["obstacles"].as_array_mut().unwrap().push(tower.clone())),
        "obstacles[1].shape: is higher than the domain at [",
    );
    let sticky = json!({ "kind": "frictional", "friction_coefficient": 0.3, "adhesion": 10 });
    starts(refused(&|v| v["obstacles"][0]["wall"] = sticky.clone()), "obstacles[0].wall.adhesion: ");
    starts(refused(&|v| v["obstacles"][0]["shape"]["file"] = json!("none.asc")), "obstacles[0].shape.file: ");
    grid(folder.path(), [0.0, 0.0], [3, 11], 10.0, |x, _| 40.0 - x);
    starts(refused(&|_| {}), "obstacles[0].shape.file: ");
}

/// Release area of 1.5 m along the normal of a slope of cosine 0.8, on a map.
#[test]
fn a_layer_of_a_map_is_released_with_its_volume() {
    let folder = tempfile::tempdir().unwrap();
    grid(folder.path(), [600_000.0, 5e6], [41, 21], 2.0, |x, _| 80.0 - 0.75 * (x - 600_000.0));
    let corners = [[10.0, 8.0], [30.0, 8.0], [30.0, 28.0], [20.0, 32.0], [10.0, 28.0], [10.0, 8.0]];
    let ring = corners.map(|[x, y]: [f64; 2]| [600_000.0 + x, 5e6 + y]);
    let text = json!({ "type": "Polygon", "coordinates": [ring] }).to_string();
    std::fs::write(folder.path().join("release.geojson"), text).unwrap();
    let layer = json!({ "kind": "layer", "on": "slope", "outline": "release.geojson", "thickness": 1.5, "measured": "normal" });
    let mut value = over_raster(&layer, &json!({ "kind": "frictional", "friction_coefficient": 0.3 }));
    value["domain"] =
        json!({ "min": [600_000, 5e6, 0], "max": [600_080, 5_000_040, 100], "origin": [600_000, 5e6, 0] });
    let case = case(folder.path(), &value);
    let plan = DepthSph.plan(&case).unwrap();
    // The outline contains 20 m by 20 m and a triangle of 4 m on them.
    let exact = 440.0 * 1.5 / 0.8;
    assert!((plan.volumes[0] / exact - 1.0).abs() < 2e-3, "{:?}", plan.volumes);
    let before = DepthSph.build(&case).unwrap().snapshot();
    let depth = before.scalars("depth").unwrap();
    let (middle, _) = before
        .positions
        .iter()
        .zip(depth)
        .find(|(x, _)| (x[0] - 20.5).abs() < 0.1 && (x[1] - 18.5).abs() < 0.1)
        .unwrap();
    assert!((middle[2] - (80.0 - 0.75 * 20.5) - 0.5 * 1.875).abs() < 0.02, "{middle:?}");
    let after = run(&case, 2.0).snapshot();
    let mean = |snapshot: &colluvium_case::Snapshot| {
        snapshot.positions.iter().map(|x| x[0]).sum::<f64>() / snapshot.positions.len() as f64
    };
    assert!(mean(&after) > mean(&before) + 4.0, "it slides");
}

/// Heap on a slope that ends in a flat, with rasters of half a metre.
fn mapped(folder: &Path) -> Value {
    grid(folder, [0.0, 0.0], [41, 21], 1.0, |x, _| 0.5 * (20.0 - x).max(0.0) + 3.0);
    let mut value = over_raster(
        &json!({ "kind": "intersection", "shapes": [
            { "kind": "box", "min": [2, 6, 0], "max": [10, 14, 20] },
            { "kind": "ball", "centre": [6, 10, 8], "radius": 4 } ] }),
        &json!({ "kind": "frictional", "friction_coefficient": 0.3 }),
    );
    value["domain"] = json!({ "min": [0, 0, 0], "max": [40, 20, 20] });
    value["methods"]["depth-sph"]["spacing"] = json!(0.5);
    value["output"] = json!({ "rasters": { "cell": 0.5, "threshold": 0.1 } });
    value
}

fn raster(solver: &dyn Solver, name: &str) -> Raster {
    solver.rasters().into_iter().find(|raster| raster.name == name).unwrap().raster
}

fn known(raster: &Raster) -> impl Iterator<Item = f64> {
    raster.values.iter().copied().filter(|value| value.is_finite())
}

#[test]
fn deposit_rasters_hold_the_volume_and_peak_rasters_match_the_extremes() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(folder.path(), &mapped(folder.path()));
    let mut solver = DepthSph.build(&case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    let (mut deepest, mut fastest) = (0f64, 0f64);
    while solver.time() < 4.0 {
        solver.step(4.0 - solver.time()).unwrap();
        let readings = solver.scalar_outputs();
        let value = |name: &str| readings.iter().find(|(reading, ..)| reading == name).unwrap().2;
        (deepest, fastest) = (deepest.max(value("largest_depth")), fastest.max(value("largest_speed")));
    }
    let deposit = raster(solver.as_ref(), "final_thickness_vertical");
    let volume = solver.scalar_outputs().iter().find(|(name, ..)| name == "flow_volume").unwrap().2;
    let held: f64 = known(&deposit).sum::<f64>() * 0.25;
    assert!((held / volume - 1.0).abs() < 1e-12, "{held} {volume}");
    assert_eq!((deposit.columns, deposit.rows, deposit.origin), (82, 42, [-0.25, -0.25]));
    let maximum_of = |name: &str| known(&raster(solver.as_ref(), name)).fold(0.0, f64::max);
    let peak = maximum_of("peak_thickness_vertical");
    assert!((0.8 * deepest..1.2 * deepest).contains(&peak), "{peak} {deepest}");
    // Along the slope speed is larger than in plan by at most the root of 1.25.
    let speed = maximum_of("peak_velocity");
    assert!((0.7 * fastest..1.12 * fastest).contains(&speed), "{speed} {fastest}");
    let pressure = maximum_of("peak_dynamic_pressure");
    assert!((pressure / (1600.0 * speed * speed) - 1.0).abs() < 1e-9);
    let arrival = raster(solver.as_ref(), "arrival_time");
    assert_eq!(arrival.interpolate(6.0, 10.0), Some(0.0), "the release is there from the start");
    let along: Vec<f64> = (24..60).map(|i| arrival.value(i, 20)).filter(|time| time.is_finite()).collect();
    assert!(along.len() > 6 && along.windows(2).all(|pair| pair[0] <= pair[1]), "{along:?}");
    assert!(known(&raster(solver.as_ref(), "peak_thickness_vertical")).all(|depth| depth >= 0.1));
}

#[test]
fn rasters_are_the_same_on_any_threads_and_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(folder.path(), &mapped(folder.path()));
    let bits = |solver: &dyn Solver| -> Vec<Vec<u64>> {
        solver.rasters().iter().map(|of| of.raster.values.iter().map(|v| v.to_bits()).collect()).collect()
    };
    let steps = |solver: &mut dyn Solver, count: usize| {
        (0..count).for_each(|_| {
            solver.step(1.0).unwrap();
        });
    };
    let begun = || {
        let mut solver = DepthSph.build(&case).unwrap();
        solver.begin_stage(0, 0.0).unwrap();
        solver
    };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = begun();
            steps(solver.as_mut(), 150);
            bits(solver.as_ref())
        })
    };
    let whole = run(1);
    assert_eq!(whole, run(3));
    let mut solver = begun();
    steps(solver.as_mut(), 60);
    let bytes = solver.checkpoint_bytes().unwrap();
    let mut again = begun();
    again.restore(&mut &bytes[..]).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    steps(again.as_mut(), 90);
    assert_eq!(bits(again.as_ref()), whole);
}

/// A dam, a box, on a raster: the bed is the highest of both.
#[test]
fn obstacles_on_a_raster_raise_the_bed() {
    let folder = tempfile::tempdir().unwrap();
    grid(folder.path(), [0.0, 0.0], [81, 41], 0.5, |x, _| 10.0 - 0.2 * x);
    // Slope 1:1.3 on its face, and higher than the top of the mass.
    let dam = |top: f64| {
        let vertices =
            [[18.0, 0.0], [18.0 + 1.3 * top, top], [19.0 + 1.3 * top, top], [19.0 + 2.6 * top, 0.0]];
        json!({ "kind": "extruded", "vertices": vertices, "axis": 1, "from": -1, "to": 21 })
    };
    let mut value = over_raster(
        &json!({ "kind": "box", "min": [8, 4, 0], "max": [16, 16, 9.5] }),
        &json!({ "kind": "smooth" }),
    );
    value["domain"] = json!({ "min": [0, 0, 0], "max": [40, 20, 20] });
    let front = |value: &Value| {
        let snapshot = run(&case(folder.path(), value), 4.0).snapshot();
        snapshot.positions.iter().map(|x| x[0]).fold(0.0, f64::max)
    };
    let free = front(&value);
    value["obstacles"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "name": "dam", "shape": dam(14.0), "wall": { "kind": "smooth" } }));
    let held = front(&value);
    assert!(free > 38.0 && held < 18.0 + 1.3 * 14.0, "{free} {held}");
    value["obstacles"][1]["shape"] = dam(1.0);
    assert_eq!(front(&value), free, "one below the ground changes nothing");
    let wall = json!({ "kind": "box", "min": [19.8, -1, 0], "max": [21.2, 21, 14] });
    value["obstacles"][1]["shape"] = wall;
    let warnings = DepthSph.plan(&case(folder.path(), &value)).unwrap().warnings;
    assert!(
        warnings.iter().any(|warning| warning.text.starts_with("obstacles: the slope of the bed reaches 8")),
        "{warnings:?}"
    );
}

/// V26: friction without curvature works along the path in plan, so that the mass stops where `H/L = tan φ`.
#[test]
fn a_mass_on_a_profile_stops_at_its_travel_angle() {
    let (slope, radius) = (30f64.to_radians(), 25.0);
    // An arc from the slope to the flat at x = 60 m.
    let (foot, rise) = (60.0 - radius * slope.sin(), radius * (1.0 - slope.cos()));
    let head = rise + foot * slope.tan();
    let start = 18.75;
    let drop = rise + (foot - start) * slope.tan();
    let value = json!({
        "title": "travel angle", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "domain": { "min": [0, -5], "max": [120, 40] },
        "materials": { "rock": {
            "model": "mohr-coulomb", "density": 2000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 40
        } },
        "bodies": [{ "name": "mass", "material": "rock",
            "shape": { "kind": "box", "min": [start - 0.25, 0], "max": [start + 0.25, drop + 0.2] } }],
        "obstacles": [{ "name": "slope", "wall": { "kind": "frictional", "friction_coefficient": 15f64.to_radians().tan() },
            "shape": { "kind": "profile", "start": [0, head], "pieces": [
                { "to": [foot, rise] }, { "to": [60, 0], "centre": [60, radius] }, { "to": [120, 0] } ] } }],
        "stages": [{ "name": "slide", "duration": 30 }],
        "methods": { "depth-sph": { "spacing": 0.5, "curvature_in_friction": false, "terrain_smoothing": 0 } }
    });
    let case = read_case(&value);
    let solver = run(&case, 30.0);
    let length = solver.snapshot().positions[0][0] - start;
    let exact = drop / 15f64.to_radians().tan();
    assert!((length / exact - 1.0).abs() < 5e-3, "{length} m for {exact} m");
}

/// Regions of an outline and of a shape are equal, at coordinates of a map too, and their law applies.
#[test]
fn a_region_from_an_outline_is_that_of_its_shape() {
    let folder = tempfile::tempdir().unwrap();
    let origin = [600_000.0, 5e6];
    grid(folder.path(), origin, [41, 21], 2.0, |x, _| 50.0 - 0.4 * (x - 600_000.0));
    let corners: [[f64; 2]; 4] = [[30.0, 0.0], [80.0, 0.0], [80.0, 40.0], [30.0, 40.0]];
    let ring: Vec<[f64; 2]> =
        corners.iter().chain(&corners[..1]).map(|[x, y]| [origin[0] + x, origin[1] + y]).collect();
    let text = json!({ "type": "Polygon", "coordinates": [ring] }).to_string();
    std::fs::write(folder.path().join("forest.geojson"), text).unwrap();
    let heap = json!({ "kind": "box", "min": [600_010, 5_000_016, 0], "max": [600_018, 5_000_024, 48] });
    let mut value = over_raster(&heap, &json!({ "kind": "smooth" }));
    value["domain"] = json!({ "min": [600_000, 5e6, 0], "max": [600_080, 5_000_040, 60], "origin": [origin[0], origin[1], 0] });
    let region = |place: Value| {
        let mut region = json!({ "basal": { "model": "coulomb", "friction_angle": 45 } });
        region.as_object_mut().unwrap().extend(place.as_object().unwrap().clone());
        json!([region])
    };
    let places = |value: &Value| run(&case(folder.path(), value), 4.0).snapshot().positions;
    let furthest = |places: &[[f64; 3]]| places.iter().map(|x| x[0]).fold(0.0, f64::max);
    let free = places(&value);
    value["methods"]["depth-sph"]["regions"] = region(json!({ "outline": "forest.geojson" }));
    let outlined = places(&value);
    assert!(furthest(&outlined) + 5.0 < furthest(&free), "{} {}", furthest(&outlined), furthest(&free));
    let shape = json!({ "kind": "polygon", "vertices": &ring[..4] });
    value["methods"]["depth-sph"]["regions"] = region(json!({ "shape": shape }));
    assert_eq!(places(&value), outlined);
    let refused = |place: Value| {
        let mut value = value.clone();
        value["methods"]["depth-sph"]["regions"] = region(place);
        DepthSph.plan(&case(folder.path(), &value)).map(|_| ()).unwrap_err().to_string()
    };
    let start = "methods.depth-sph.regions[0].";
    assert!(refused(json!({})).starts_with(&format!("{start}shape: give one of")));
    assert!(refused(json!({ "outline": "none.shp" })).starts_with(&format!("{start}outline: /")));
    // Coordinates from the origin in place of those of the map.
    let unshifted = json!({ "shape": { "kind": "box", "min": [30, 0], "max": [80, 40] } });
    assert!(refused(unshifted).starts_with(&format!(
        "{start}shape: lies outside the domain: it reaches from 30 to 80 m along x, the domain from 600000"
    )));
}
