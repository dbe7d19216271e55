//! Transfer between methods by lists of points.

use std::path::Path;

use serde_json::{Value, json};

use super::cli::{column, write};
use super::{output, program};

#[test]
fn the_last_frame_of_a_run_becomes_a_depth_integrated_flow() {
    use colluvium::case::output::{Table, read_frame};
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "column.json", &column());
    let out = folder.path().join("out");
    assert_eq!(output(program().args(["run", "--quiet", "--out"]).arg(&out).arg(&file)).0, 0);
    let (code, said, errors) = output(program().args(["export", "--points"]).arg(&out));
    assert_eq!(code, 0, "{errors}");
    assert!(said.contains("points at 0.12 s to ") && said.trim_end().ends_with("points.csv"), "{said}");
    let mut next = column();
    next["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0, 0], "max": [0.4, 0.12] });
    next["bodies"][0]["points"] = json!({ "file": "out/points.csv" });
    next["stages"] = json!([{ "name": "run-out", "duration": 0.1 }]);
    next["methods"] = json!({ "depth-sph": { "spacing": 0.01 } });
    next["measures"] = json!({});
    let file = write(folder.path(), "next.json", &next);
    let then = folder.path().join("then");
    let (code, said, errors) = output(program().args(["run", "--out"]).arg(&then).arg(&file));
    assert_eq!(code, 0, "{said}{errors}");
    let last = read_frame(&out.join("frames/frame-00006.vtu"), 0.12).unwrap();
    // A flow has one density: its volume follows from the mass, not from points that have loosened.
    let handed = last.scalars("mass").unwrap().iter().sum::<f64>() / 1925.0;
    let table = Table::read(&then.join("measures.csv")).unwrap();
    let flow = table.column("flow_volume").unwrap();
    assert!(flow.iter().all(|volume| (volume / handed - 1.0).abs() < 1e-12), "{handed} {flow:?}");
}

/// Saturated column, water up to its surface at 1 m, with 3 kPa of excess pressure at the base.
fn saturated() -> Value {
    let smooth = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
    json!({
        "title": "saturated", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1.2] }, "gravity": [0, -9.81],
        "materials": { "soil": { "model": "linear-elastic", "density": 1590, "youngs_modulus": 1e7, "poissons_ratio": 0.2 } },
        "bodies": [{ "name": "column", "material": "soil", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
            "pore_fluid": { "porosity": 0.4, "permeability": 1e-3, "density": 1000,
                "pressure": { "kind": "formula", "value": "9810*(1-y)+3000*(1-y*y)" } } }],
        "boundaries": [smooth("x-min"), smooth("x-max"), smooth("y-min")],
        "stages": [{ "name": "hold", "duration": 1e-7 }],
        "methods": { "mpm": { "cell_size": 0.1 } }
    })
}

/// Runs a case, writes its last frame as points, and reads the first frame.
fn first_frame(folder: &Path, name: &str, case: &Value) -> colluvium::case::Snapshot {
    let out = folder.join(name);
    let file = write(folder, &format!("{name}.json"), case);
    let (code, said, errors) = output(program().args(["run", "--out"]).arg(&out).arg(&file));
    assert_eq!(code, 0, "{said}{errors}");
    let (code, _, errors) = output(program().args(["export", "--points"]).arg(&out));
    assert_eq!(code, 0, "{errors}");
    colluvium::case::output::read_frame(&out.join("frames/frame-00000.vtu"), 0.0).unwrap()
}

/// A saturated column of MPM at excess pressure becomes a flow with equal basal stress, and points of MPM again.
#[test]
fn pore_pressure_is_transferred_from_mpm_to_depth_integrated_flow_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut column = saturated();
    first_frame(folder.path(), "column", &column);
    let mut flow = column.clone();
    flow["materials"]["soil"]["density"] = json!(1990);
    flow["bodies"][0] = json!({ "name": "column", "material": "soil", "points": { "file": "column/points.csv" },
        "shape": { "kind": "box", "min": [0, 0], "max": [1, 1.2] } });
    flow["methods"] = json!({ "depth-sph": { "spacing": 0.1, "basal": { "model": "coulomb", "friction_angle": 30 },
        "mixture": { "grain_density": 2650, "porosity": 0.4 }, "column": { "consolidation": 0 } } });
    let frame = first_frame(folder.path(), "flow", &flow);
    let [depth, pressure, mean] =
        ["depth", "pore_pressure", "mean_excess_pore_pressure"].map(|name| frame.scalars(name).unwrap());
    for (i, depth) in depth.iter().enumerate() {
        let effective = 1990.0 * 9.81 * depth - pressure[i];
        let exact = 990.0 * 9.81 - 3000.0;
        assert!((effective / exact - 1.0).abs() < 0.02, "{effective} Pa for {exact}");
        assert!((mean[i] / 2000.0 - 1.0).abs() < 0.01, "{} Pa on the mean", mean[i]);
    }
    column["bodies"][0]["points"] = json!({ "file": "flow/points.csv" });
    column["bodies"][0]["shape"]["max"] = json!([1, 1.2]);
    column["bodies"][0]["pore_fluid"]["pressure"] = json!({ "kind": "none" });
    column["methods"]["mpm"]["cell_size"] = json!(0.2);
    let frame = first_frame(folder.path(), "again", &column);
    let [volume, pressure] = ["volume", "pore_pressure"].map(|name| frame.scalars(name).unwrap());
    let whole: f64 = volume.iter().zip(pressure).map(|(volume, pressure)| volume * pressure).sum();
    assert!((volume.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    assert!((whole / (4905.0 + 2000.0) - 1.0).abs() < 0.01, "{whole} Pa on the mean");
    // Effective stress and pore pressure carry the weight above.
    let stress = frame.tensors("stress").unwrap();
    for (i, x) in frame.positions.iter().enumerate() {
        let weight = 1990.0 * 9.81 * (1.0 - x[1]);
        let total_stress = pressure[i] + stress[i].pressure();
        assert!(
            (total_stress - weight).abs() < 0.02 * 1990.0 * 9.81,
            "{total_stress} for {weight} Pa at {x:?}"
        );
    }
    column["bodies"][0].as_object_mut().unwrap().remove("pore_fluid");
    let file = write(folder.path(), "dry.json", &column);
    let (code, _, errors) = output(program().arg("check").arg(&file));
    assert_ne!(code, 0, "it is refused");
    assert!(errors.contains("bodies[0].points.file: the points have pore pressures"), "{errors}");
}

/// Sums of masses, of volumes and of momentum along x in the last frame of a run (kg/m, m², kg/s).
fn sums(out: &Path) -> [f64; 3] {
    use colluvium::case::output::{Collection, read_frame};
    let frames = Collection::read(&out.join("frames.pvd")).unwrap().of_points();
    sums_of(&read_frame(&out.join(&frames.last().unwrap().1), 0.0).unwrap())
}

/// Sums of masses, of volumes and of momentum along x of a frame (kg/m, m², kg/s).
fn sums_of(last: &colluvium::case::Snapshot) -> [f64; 3] {
    let [mass, volume] = ["mass", "volume"].map(|name| last.scalars(name).unwrap());
    let velocity = last.vectors("velocity").unwrap();
    let momentum = mass.iter().zip(velocity).map(|(mass, velocity)| mass * velocity[0]).sum();
    [mass.iter().sum(), volume.iter().sum(), momentum]
}

/// A column that falls, by MPM or SPH, continues as a flow, and that as a column of MPM or SPH again: the mass is equal to round-off,
/// although the volume of points is not that of their mass at the density of the material.
#[test]
fn mass_is_conserved_to_round_off_in_transfer_between_methods() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let run = |name: &str, case: &Value| {
        first_frame(folder, name, case);
        sums(&folder.join(name))
    };
    for (method, options) in [
        ("mpm", json!({ "cell_size": 0.01, "courant": 0.3 })),
        ("sph", json!({ "spacing": 0.005, "continuity": "mass" })),
    ] {
        let mut first = column();
        first["measures"] = json!({});
        first["methods"] = json!({ method: options });
        let before = run(method, &first);
        let density = before[0] / before[1];
        assert!(
            (density / 1925.0 - 1.0).abs() > 1e-4,
            "{method}: {density} kg/m³, and volumes are those of the masses"
        );
        let mut next = first.clone();
        next["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0, 0], "max": [0.4, 0.12] });
        next["bodies"][0]["points"] = json!({ "file": format!("{method}/points.csv") });
        next["stages"] = json!([{ "name": "on", "duration": 1e-8 }]);
        next["methods"] = json!({ "depth-sph": { "spacing": 0.01 } });
        let (on, back) = (format!("{method}-flow"), format!("{method}-again"));
        let flow = run(&on, &next);
        next["bodies"][0]["points"] = json!({ "file": format!("{on}/points.csv") });
        next["methods"] = first["methods"].clone();
        let again = run(&back, &next);
        for (name, found) in [("flow", flow), ("again", again)] {
            assert!(
                (found[0] / before[0] - 1.0).abs() < 1e-12,
                "{method} {name}: {} kg/m of {}",
                found[0],
                before[0]
            );
            // A step of 1e-8 s lies between.
            assert!(
                (found[2] / before[2] - 1.0).abs() < 1e-4,
                "{method} {name}: {} of {}",
                found[2],
                before[2]
            );
        }
    }
}

/// A saturated column that falls in a model in depth continues as grains and fluid on separate nodes, which move apart, and as points
/// again: no mass is lost.
#[test]
fn grain_and_fluid_masses_are_conserved_to_round_off_in_transfer_between_methods() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let run = |name: &str, case: &Value| {
        first_frame(folder, name, case);
        sums(&folder.join(name))
    };
    let mut first = saturated();
    first["domain"]["max"] = json!([3, 1.2]);
    first["boundaries"] = json!([{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "y-min", "wall": { "kind": "smooth" } }]);
    first["materials"]["soil"]["youngs_modulus"] = json!(1e6);
    first["bodies"][0]["pore_fluid"]["bulk_modulus"] = json!(1e7);
    first["bodies"][0]["pore_fluid"]["permeability"] = json!(1e-2);
    first["stages"][0]["duration"] = json!(0.05);
    let before = run("fall", &first);
    let mut next = first.clone();
    next["bodies"][0]["points"] = json!({ "file": "fall/points.csv" });
    next["bodies"][0]["shape"]["max"] = json!([3, 1.2]);
    next["bodies"][0]["pore_fluid"]["pressure"] = json!({ "kind": "none" });
    next["stages"][0]["duration"] = json!(0.3);
    let basal = json!({ "model": "coulomb", "friction_angle": 30 });
    next["methods"] =
        json!({ "depth-sph": { "spacing": 0.1, "phases": "two", "basal": basal, "column": {} } });
    let flow = run("flow", &next);
    next["bodies"][0]["points"] = json!({ "file": "flow/points.csv" });
    next["methods"] = json!({ "mpm": { "cell_size": 0.2 } });
    next["stages"][0]["duration"] = json!(1e-8);
    // The liquid of MPM has the mass in its pores, which a step changes.
    let again = sums_of(&first_frame(folder, "again", &next));
    assert!((flow[0] / before[0] - 1.0).abs() < 1e-12, "{} kg/m of {}", flow[0], before[0]);
    assert!((again[0] / flow[0] - 1.0).abs() < 1e-12, "{} kg/m of {}", again[0], flow[0]);
    assert!((again[2] / flow[2] - 1.0).abs() < 1e-12, "{} of {}", again[2], flow[2]);
}

/// In axisymmetry lists have areas, and masses per radian.
#[test]
fn points_of_an_axisymmetric_run_are_read_back_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["space"] = json!("axisymmetric");
    case["measures"] = json!({});
    first_frame(folder.path(), "first", &case);
    let before = sums(&folder.path().join("first"));
    case["bodies"][0]["shape"]["max"] = json!([0.4, 0.12]);
    case["bodies"][0]["points"] = json!({ "file": "first/points.csv" });
    case["stages"] = json!([{ "name": "on", "duration": 1e-8 }]);
    let frame = first_frame(folder.path(), "next", &case);
    let [mass, volume] = ["mass", "volume"].map(|name| frame.scalars(name).unwrap().iter().sum::<f64>());
    assert!((mass / before[0] - 1.0).abs() < 1e-12, "{mass} kg of {}", before[0]);
    assert!((volume / before[1] - 1.0).abs() < 1e-12, "{volume} m³ of {}", before[1]);
}
