//! Template of a debris flow, from terrain and release area to rasters and maps, run as a user runs it.

use std::fs;
use std::path::Path;

use colluvium_terrain::read_raster;
use serde_json::{Value, json};

use super::in_folder;

/// Changes the case that `new` has written.
fn change(folder: &Path, change: impl Fn(&mut Value)) {
    let file = folder.join("debris-flow.json");
    let mut case: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    change(&mut case);
    fs::write(file, case.to_string()).unwrap();
}

/// Last value of a column of the measures.
fn last(out: &Path, name: &str) -> f64 {
    let text = fs::read_to_string(out.join("measures.csv")).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = head.iter().position(|column| column.split(' ').next() == Some(name)).unwrap();
    lines.next_back().unwrap().split(',').nth(column).unwrap().parse().unwrap()
}

/// Checks that the deposit has the volume of the flow; returns that volume (m³).
fn sums_to_the_volume(out: &Path) -> f64 {
    let flow = last(out, "flow_volume");
    for ending in ["asc", "tif"] {
        let deposit = read_raster(&out.join(format!("rasters/final_thickness_vertical.{ending}"))).unwrap();
        let volume: f64 = deposit.values.iter().filter(|depth| depth.is_finite()).sum::<f64>() * 25.0;
        assert!((volume / flow - 1.0).abs() < 1e-9, "{ending}: {volume} m³ of {flow} m³");
    }
    flow
}

/// Material beyond an open boundary is in none of the rasters.
#[test]
fn volume_leaving_through_an_open_side_is_not_in_the_deposit_raster() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    in_folder(folder, &["new", "debris-flow"]);
    change(folder, |case| {
        case["stages"][0]["duration"] = json!(12);
        case["methods"]["depth-sph"]["spacing"] = json!(4);
        case["boundaries"] =
            json!([{ "side": "x-max", "position": 600_180, "wall": { "kind": "absorbing" } }]);
    });
    let (code, _, errors) = in_folder(folder, &["run", "debris-flow.json", "--quiet"]);
    assert_eq!(code, 0, "{errors}");
    let out = folder.join("debris-flow-depth-sph");
    let (flow, left) = (sums_to_the_volume(&out), last(&out, "volume_left"));
    assert!(left > 100.0, "{left} m³ have left, and {flow} m³ are there");
}

#[test]
fn the_debris_flow_template_gives_rasters_and_maps_on_the_terrain_grid() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (code, said, errors) = in_folder(folder, &["new", "debris-flow"]);
    assert!(code == 0 && said.contains("debris-flow-terrain.asc"), "{said} {errors}");
    let (code, _, errors) = in_folder(folder, &["new", "debris-flow", "other.json"]);
    assert!(code == 2 && errors.contains("debris-flow-terrain.asc exists already"), "{errors}");
    change(folder, |case| {
        case["stages"][0]["duration"] = json!(6);
        case["methods"]["depth-sph"]["spacing"] = json!(4);
    });
    let (code, _, errors) = in_folder(folder, &["run", "debris-flow.json", "--quiet"]);
    assert_eq!(code, 0, "{errors}");
    let out = folder.join("debris-flow-depth-sph");
    let terrain = read_raster(&folder.join("debris-flow-terrain.asc")).unwrap();
    sums_to_the_volume(&out);
    for ending in ["asc", "tif"] {
        let deposit = read_raster(&out.join(format!("rasters/final_thickness_vertical.{ending}"))).unwrap();
        let same = (deposit.origin, deposit.spacing, deposit.columns, deposit.rows);
        assert_eq!(same, (terrain.origin, terrain.spacing, terrain.columns, terrain.rows), "{ending}");
        let flow = last(&out, "flow_volume");
        // 1.5 m along the normal of slopes of about 30° over 3244 m².
        assert!((1.05..1.25).contains(&(flow / (1.5 * 3244.0))), "{flow}");
    }
    // `check` names positions in map coordinates.
    let (_, said, _) = in_folder(folder, &["check", "debris-flow.json"]);
    let place = said.split("at point").nth(1).unwrap().split(['(', ')']).nth(1).unwrap();
    let place: Vec<f64> = place.split(", ").map(|x| x.parse().unwrap()).collect();
    assert!((6e5..600_900.0).contains(&place[0]) && (5.2e6..5_200_400.0).contains(&place[1]), "{said}");
    assert!(place[2] > 100.0, "{said}");
    assert!(fs::metadata(out.join("rasters/map.png")).unwrap().len() > 10_000);
    let (code, _, errors) = in_folder(folder, &["plot", "debris-flow-depth-sph"]);
    assert!(code == 0 && out.join("plots/map-peak_velocity.png").exists(), "{errors}");
    let (code, _, errors) = in_folder(folder, &["report", "debris-flow-depth-sph"]);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(code == 0 && page.contains("Maps") && page.contains("peak dynamic pressure"), "{errors}");
}

/// A deposit, which has no data where it is dry, is the thickness of the layer of a following case.
#[test]
fn a_deposit_raster_is_the_release_layer_of_another_case() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert_eq!(in_folder(folder, &["new", "debris-flow"]).0, 0);
    let short = |case: &mut Value, time: f64| {
        case["stages"][0]["duration"] = json!(time);
        case["methods"]["depth-sph"]["spacing"] = json!(4);
    };
    change(folder, |case| short(case, 5.0));
    let run = |out: &str| in_folder(folder, &["run", "debris-flow.json", "--quiet", "--out", out]);
    let (code, _, errors) = run("first");
    assert_eq!(code, 0, "{errors}");
    let deposit = "first/rasters/final_thickness_vertical.tif";
    let read = read_raster(&folder.join(deposit)).unwrap();
    assert!(read.values.iter().any(|depth| depth.is_nan()));
    let ([west, south], [east, north]) =
        (read.node_position(1, 1), read.node_position(read.columns - 2, read.rows - 2));
    let ring = [[west, south], [east, south], [east, north], [west, north], [west, south]];
    let outline = |ring: &[[f64; 2]]| json!({ "type": "Polygon", "coordinates": [ring] }).to_string();
    fs::write(folder.join("around.geojson"), outline(&ring)).unwrap();
    change(folder, |case| {
        short(case, 0.1);
        let shape = &mut case["bodies"][0]["shape"];
        (shape["outline"], shape["thickness"]) = (json!("around.geojson"), json!(deposit));
        shape["measured"] = json!("vertical");
    });
    let (code, _, errors) = run("next");
    assert_eq!(code, 0, "{errors}");
    let [before, after] = ["first", "next"].map(|out| last(&folder.join(out), "flow_volume"));
    assert!((after / before - 1.0).abs() < 1e-4, "{after} m³ of {before} m³");
    // An outline in a dry area.
    let dry = ring.map(|[x, y]| [west + 0.02 * (x - west), south + 0.02 * (y - south)]);
    fs::write(folder.join("around.geojson"), outline(&dry)).unwrap();
    let (code, _, errors) = run("none");
    assert!(code != 0 && errors.contains("bodies[0].shape.thickness: "), "{errors}");
    assert!(errors.contains("final_thickness_vertical.tif: is zero in the whole outline"), "{errors}");
}

#[test]
fn rasters_are_refused_by_methods_that_have_none() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert_eq!(in_folder(folder, &["new", "debris-flow"]).0, 0);
    change(folder, |case| case["methods"] = json!({ "mpm": { "cell_size": 20 } }));
    let (code, _, errors) = in_folder(folder, &["check", "debris-flow.json"]);
    assert!(
        code != 0 && errors.contains("output.rasters: rasters over the plan are available with"),
        "{errors}"
    );
    change(folder, |case| {
        case["output"] = json!({});
    });
    let (code, said, errors) = in_folder(folder, &["check", "debris-flow.json"]);
    assert!(code == 0, "the layer is a body of the material point method too: {said} {errors}");
}

/// Writes the template, shortened, and a sweep of its friction with the additional keys `more`.
fn friction_sweep(folder: &Path, more: &Value) {
    let mut sweep = json!({
        "title": "friction", "case": "debris-flow.json",
        "parameters": { "friction": { "at": ["methods.depth-sph.basal.friction_angle"], "values": [3, 15, 28] } }
    });
    sweep.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    fs::write(folder.join("sweep.json"), sweep.to_string()).unwrap();
    if folder.join("debris-flow.json").exists() {
        return;
    }
    assert_eq!(in_folder(folder, &["new", "debris-flow"]).0, 0);
    change(folder, |case| {
        case["stages"][0]["duration"] = json!(8);
        case["methods"]["depth-sph"]["spacing"] = json!(5);
        case["measures"]["dry"] = json!({ "kind": "gauge", "position": [600_850, 5_200_010] });
    });
}

fn swept(folder: &Path) {
    let (code, _, errors) = in_folder(folder, &["sweep", "sweep.json", "--out", "out", "--jobs", "1"]);
    assert_eq!(code, 0, "{errors}");
}

fn refused_sweep(folder: &Path, more: &Value, problem: &str) {
    friction_sweep(folder, more);
    let (code, _, errors) = in_folder(folder, &["sweep", "sweep.json", "--check"]);
    assert!(code != 0 && errors.contains(problem), "{errors}");
}

/// Values of a raster of each of the three runs.
fn of_runs(folder: &Path, name: &str) -> Vec<Vec<f64>> {
    let file = |run: i32| folder.join(format!("out/run-000{run}/rasters/{name}.asc"));
    (1..=3).map(|run| read_raster(&file(run)).unwrap().values).collect()
}

#[test]
fn exceedance_rasters_of_a_sweep_contain_the_share_of_runs_over_a_threshold() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    friction_sweep(
        folder,
        &json!({ "exceedance": { "peak_velocity": [2, 500], "peak_thickness_vertical": [0.5] } }),
    );
    swept(folder);
    let runs = of_runs(folder, "peak_velocity");
    let share = read_raster(&folder.join("out/rasters/exceedance-peak_velocity-2.tif")).unwrap();
    let mut occurrences = [0; 4];
    for (cell, value) in share.values.iter().enumerate() {
        let count = runs.iter().filter(|run| run[cell] >= 2.0).count();
        occurrences[count] += 1;
        let exact = if count == 0 { f64::NAN } else { count as f64 / 3.0 };
        assert!(value.is_nan() && exact.is_nan() || (value - exact).abs() < 1e-12, "{value} {exact}");
    }
    assert!(occurrences[1] > 0 && occurrences[0] > 0, "{occurrences:?}");
    assert!(folder.join("out/rasters/exceedance-peak_thickness_vertical-0.5.png").exists());
    assert!(!folder.join("out/rasters/exceedance-peak_velocity-500.asc").exists());
    let table = fs::read_to_string(folder.join("out/rasters/exceedance.csv")).unwrap();
    assert!(table.contains("peak_velocity,500,m/s,3,3,0"), "{table}");
    // A gauge that remains dry has no velocity.
    assert!(!fs::read_to_string(folder.join("out/runs.csv")).unwrap().contains("NaN"));
    for (exceedance, problem) in [
        (json!({ "peak_height": [1] }), "exceedance.peak_height: is not a raster"),
        (json!({ "peak_velocity": [0] }), "exceedance.peak_velocity[0]: 0 must be positive"),
        (
            json!({ "peak_thickness_vertical": [0.01] }),
            "exceedance.peak_thickness_vertical[0]: 0.01 m is below",
        ),
    ] {
        refused_sweep(folder, &json!({ "exceedance": exceedance }), problem);
    }
}

#[test]
fn intensity_rasters_of_a_sweep_contain_the_highest_class_and_class_shares() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let classes = json!([
        { "name": "weak", "reaches": { "peak_velocity": 2 } },
        { "name": "strong", "reaches": { "peak_velocity": 4, "peak_thickness_vertical": 0.5 } }
    ]);
    friction_sweep(folder, &json!({ "intensities": classes }));
    swept(folder);
    let (velocity, thickness) =
        (of_runs(folder, "peak_velocity"), of_runs(folder, "peak_thickness_vertical"));
    let [class, strong, weak] = ["intensity", "exceedance-intensity-strong", "exceedance-intensity-weak"]
        .map(|name| read_raster(&folder.join(format!("out/rasters/{name}.asc"))).unwrap().values);
    for cell in 0..class.len() {
        let is_strong = |run: &usize| velocity[*run][cell] >= 4.0 && thickness[*run][cell] >= 0.5;
        let is_weak = |run: &usize| velocity[*run][cell] >= 2.0;
        let [of_strong, of_weak] = [(0..3).filter(is_strong).count(), (0..3).filter(is_weak).count()];
        let shares = [strong[cell], weak[cell]].map(|share| if share.is_nan() { 0.0 } else { 3.0 * share });
        assert_eq!(shares.map(f64::round), [of_strong as f64, of_weak as f64]);
        let highest = if of_strong > 0 { 2.0 } else { 1.0 };
        assert!(if of_weak == 0 { class[cell].is_nan() } else { class[cell] == highest });
    }
    assert!(class.contains(&2.0) && class.contains(&1.0));
    assert!(folder.join("out/rasters/intensity.png").exists());
    for (intensities, problem) in [
        (json!([{ "name": "weak", "reaches": {} }]), "intensities[0].reaches: has no threshold"),
        (
            json!([{ "name": "a b", "reaches": { "peak_velocity": 1 } }]),
            "intensities[0].name: a name is made of",
        ),
        (json!([classes[0], classes[0]]), "intensities[1].name: is also the name of another class"),
        (
            json!([{ "name": "weak", "reaches": { "speed": 1 } }]),
            "intensities[0].reaches.speed: is not a raster with thresholds",
        ),
    ] {
        refused_sweep(folder, &json!({ "intensities": intensities }), problem);
    }
}
