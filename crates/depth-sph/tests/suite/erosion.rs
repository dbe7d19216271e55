//! Erodible bed: lowered by erosion, down to the erodible depth (sheet: depth-sph §2.8, §5.2: eroded bed volume).

use std::path::Path;

use colluvium_case::{Case, Method, Solver};
use colluvium_depth_sph::DepthSph;
use colluvium_testkit::{advance_exactly_to, advance_steps, refusal, scalar_output, start_solver};
use serde_json::{Value, json};

/// Slope of 0.6 that bends to a flat, on a grid of 2 m.
fn terrain(folder: &Path) {
    let (columns, rows) = (61, 21);
    let mut text =
        format!("ncols {columns}\nnrows {rows}\nxllcenter 0\nyllcenter 0\ncellsize 2\nnodata_value -9999\n");
    for _ in 0..rows {
        for column in 0..columns {
            let x = 2.0 * f64::from(column);
            text += &format!("{:?} ", if x < 80.0 { 0.6 * (80.0 - x) } else { 0.0 });
        }
        text.push('\n');
    }
    std::fs::write(folder.join("terrain.asc"), text).unwrap();
}

/// Heap that erodes half as much again over 20 m.
fn heap(folder: &Path, more: &Value) -> Case {
    let mut value = json!({
        "title": "scour", "space": "3d", "gravity": [0, 0, -9.81],
        "domain": { "min": [0, 0, 0], "max": [120, 40, 80] },
        "materials": { "debris": {
            "model": "mohr-coulomb", "density": 2000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "heap", "material": "debris",
            "shape": { "kind": "box", "min": [8, 15, 0], "max": [16, 25, 44.2] } }],
        "obstacles": [{ "name": "slope", "shape": { "kind": "raster", "file": "terrain.asc" },
            "wall": { "kind": "frictional", "friction_coefficient": 0.2 } }],
        "stages": [{ "name": "release", "duration": 5 }],
        "output": { "rasters": { "threshold": 0.05 } },
        "methods": { "depth-sph": { "spacing": 1, "erosion": { "law": "hungr", "rate": 0.02 } } }
    });
    let options = value["methods"]["depth-sph"].as_object_mut().unwrap();
    options.extend(more.as_object().unwrap().clone());
    Case::from_value(&value, folder).unwrap()
}

fn start(case: &Case) -> Box<dyn Solver> {
    start_solver(&DepthSph, case)
}

/// Growth of the flow and of its outflow (m³), loss in the raster of the bed's change, and the least change (m).
fn account(solver: &dyn Solver, before: f64) -> [f64; 3] {
    let growth = scalar_output(solver, "flow_volume") + scalar_output(solver, "volume_left") - before;
    let rasters = solver.rasters();
    let change = &rasters.iter().find(|raster| raster.name == "bed_change").unwrap().raster;
    // Nodes at the rim represent half a cell.
    let half = |k: usize, count: usize| if k == 0 || k + 1 == count { 0.5 } else { 1.0 };
    let area =
        |k: usize| 4.0 * half(k % change.columns, change.columns) * half(k / change.columns, change.rows);
    let cells = change.values.iter().enumerate().filter(|(_, z)| z.is_finite());
    let lost: f64 = cells.map(|(k, z)| -z * area(k)).sum();
    let least = change.values.iter().copied().fold(0.0, f64::min);
    assert!((scalar_output(solver, "deepest_erosion") + least).abs() < 1e-12);
    [growth, lost, least]
}

#[test]
fn eroded_volume_of_the_flow_equals_the_volume_loss_of_the_bed() {
    let folder = tempfile::tempdir().unwrap();
    terrain(folder.path());
    let two = json!({ "grain_density": 2650, "porosity": 0.4, "drag": { "law": "anderson", "settling_velocity": 0.05 } });
    for more in [
        json!({ "lower_bed": true }),
        json!({ "lower_bed": true, "erodible_depth": 0.1 }),
        json!({ "lower_bed": false, "erodible_depth": 0.1 }),
        json!({ "lower_bed": true, "erodible_depth": 0.1, "phases": "two", "mixture": two }),
    ] {
        let mut solver = start(&heap(folder.path(), &more));
        let before = scalar_output(solver.as_ref(), "flow_volume");
        advance_steps(solver.as_mut(), 60);
        let [growth, lost, least] = account(solver.as_ref(), before);
        assert!(growth > 1.0, "{growth} m³ of {before} m³: {more}");
        assert!((growth - lost).abs() < 1e-9 * before, "flow and bed: {growth} {lost}: {more}");
        let limited = more.get("erodible_depth").is_some();
        assert!(least < -0.05 && (!limited || least >= -0.1 - 1e-12), "{least} m: {more}");
        assert!(limited || least < -0.12, "it would go deeper: {least} m");
    }
}

#[test]
fn the_flow_follows_a_lowered_bed_which_checkpoints_restore() {
    let folder = tempfile::tempdir().unwrap();
    terrain(folder.path());
    let case = heap(folder.path(), &json!({ "lower_bed": true }));
    let whole = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = start(&case);
            advance_steps(solver.as_mut(), 80);
            solver.snapshot().hash()
        })
    };
    let mut solver = start(&case);
    advance_steps(solver.as_mut(), 43);
    let mut bytes = Vec::new();
    solver.save(&mut bytes).unwrap();
    let mut other = start(&case);
    other.restore(&mut bytes.as_slice()).unwrap();
    advance_steps(other.as_mut(), 37);
    assert_eq!(whole(1), whole(2));
    assert_eq!(other.snapshot().hash(), whole(1));
    let level = |more: &Value| {
        let mut solver = start(&heap(folder.path(), more));
        advance_steps(solver.as_mut(), 80);
        let snapshot = solver.snapshot();
        let bed = snapshot.scalars("bed").unwrap();
        snapshot
            .positions
            .iter()
            .zip(bed)
            .map(|(x, bed)| bed - 0.6 * (80.0 - x[0]).max(0.0))
            .fold(0.0, f64::min)
    };
    let lowered = level(&json!({ "lower_bed": true }));
    let kept = level(&json!({}));
    assert!(lowered < kept - 0.02, "{lowered} {kept}");
    // Two cells of 2 m beside the foot of the slope the spline lies below it by less than a 24th of the bend.
    assert!(kept > -0.6 * 2.0 / 24.0, "{kept}");
}

#[test]
fn a_raster_limits_the_erodible_depth_of_each_position() {
    let folder = tempfile::tempdir().unwrap();
    terrain(folder.path());
    let mut text =
        "ncols 21\nnrows 21\nxllcenter 0\nyllcenter 0\ncellsize 2\nnodata_value -9999\n".to_owned();
    for _ in 0..21 {
        (0..21).for_each(|column| text += if column < 12 { "0.02 " } else { "0.06 " });
        text.push('\n');
    }
    std::fs::write(folder.path().join("depths.asc"), &text).unwrap();
    let more = json!({ "lower_bed": true, "erodible_depth_raster": "depths.asc" });
    let mut solver = start(&heap(folder.path(), &more));
    let before = scalar_output(solver.as_ref(), "flow_volume");
    advance_steps(solver.as_mut(), 60);
    let [growth, lost, least] = account(solver.as_ref(), before);
    assert!((growth - lost).abs() < 1e-9 * before, "flow and bed: {growth} {lost}");
    assert!((-0.06 - 1e-12..-0.04).contains(&least), "{least} m");
    let rasters = solver.rasters();
    let change = &rasters.iter().find(|raster| raster.name == "bed_change").unwrap().raster;
    for row in 0..change.rows {
        let of = |column: usize| change.value(column, row);
        assert!((0..11).all(|column| of(column).is_nan() || of(column) >= -0.02 - 1e-12));
        assert!((21..change.columns).all(|column| of(column).is_nan()), "nothing beyond the raster");
    }
    let file = folder.path().join("depths.asc");
    std::fs::write(&file, text.replacen("0.02", "-0.02", 1)).unwrap();
    let problem = DepthSph.plan(&heap(folder.path(), &more)).map(|_| ()).unwrap_err().to_string();
    assert!(problem.starts_with("methods.depth-sph.erodible_depth_raster: "), "{problem}");
    assert!(problem.ends_with("a depth of -0.02 m must not be negative"), "{problem}");
    for mark in ["-32768", "1e38"] {
        std::fs::write(&file, text.replacen("0.02", mark, 1)).unwrap();
        let problem = DepthSph.plan(&heap(folder.path(), &more)).map(|_| ()).unwrap_err().to_string();
        let named = problem.starts_with("methods.depth-sph.erodible_depth_raster: ");
        assert!(
            named && problem.contains("1 of its values") && problem.contains("NODATA_value"),
            "{problem}"
        );
    }
}

#[test]
fn a_dam_stops_a_flow_that_passes_without_it() {
    let folder = tempfile::tempdir().unwrap();
    terrain(folder.path());
    let farthest = |dams: Value| {
        let mut solver = start(&heap(folder.path(), &json!({ "erosion": null, "dams": dams })));
        advance_exactly_to(solver.as_mut(), 5.0);
        solver.snapshot().positions.iter().map(|x| x[0]).fold(0.0, f64::max)
    };
    let line = json!([[30, 0], [30, 40]]);
    let held = farthest(json!([{ "line": line, "height": 12, "width": 3, "side_slope": 1.5 }]));
    assert!(held < 32.0, "{held} m");
    assert!(farthest(json!([])) > 45.0, "without a dam it runs on");
    let plan = |dam: Value| {
        let case = heap(folder.path(), &json!({ "dams": [dam] }));
        DepthSph
            .plan(&case)
            .map(|plan| colluvium_testkit::lines(&plan.warnings))
            .unwrap_or_else(|error| error.to_string())
    };
    let thin = plan(json!({ "line": line, "height": 3 }));
    assert!(
        thin.contains("methods.depth-sph.dams[0]: cells of 2 m by 2 m reduce its crest to 1.59 m"),
        "{thin}"
    );
    let off = plan(json!({ "line": [[300, 0], [300, 40]], "height": 3 }));
    assert!(off.starts_with("methods.depth-sph.dams[0].line: covers no node of the terrain"), "{off}");
    let short = plan(json!({ "line": [[30, 0]], "height": 3 }));
    assert!(short.starts_with("methods.depth-sph.dams[0].line: has fewer than two corners"), "{short}");
}

#[test]
fn rock_is_not_eroded_and_a_plane_cannot_be_lowered() {
    let folder = tempfile::tempdir().unwrap();
    terrain(folder.path());
    let region = json!([{ "shape": { "kind": "box", "min": [0, 0], "max": [40, 40] } }]);
    let mut solver = start(&heap(folder.path(), &json!({ "lower_bed": true, "regions": region })));
    advance_steps(solver.as_mut(), 60);
    let rasters = solver.rasters();
    let change = &rasters.iter().find(|raster| raster.name == "bed_change").unwrap().raster;
    for row in 0..change.rows {
        // Nodes at 40 m and less lie in the region without erosion.
        assert!((0..20).all(|column| change.value(column, row).is_nan()));
    }
    let mut value = serde_json::to_value(heap(folder.path(), &json!({ "lower_bed": true }))).unwrap();
    value["obstacles"][0]["shape"] = json!({ "kind": "plane", "point": [0, 0, 40], "normal": [0.5, 0, 1] });
    let problem = refusal(&DepthSph, &value);
    assert!(problem.starts_with("methods.depth-sph.lower_bed: the bed is a plane"), "{problem}");
}
