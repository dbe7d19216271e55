//! Grains that fill bodies, and cells of grains as the material of other methods.

use colluvium::case::{Case, Snapshot, Solver};
use colluvium::constitutive::driver::TestTrace;
use serde_json::{Value, json};

use super::{in_folder, output, program};

const PRESSURE: f64 = 100e3;
/// Strain of a step, and number of steps.
const STRAIN: f64 = 1e-4;
const STEPS: usize = 15;

/// Cell of 60 disks, friction 0.5, with a stiffness of 500 pressures.
fn cell() -> Value {
    json!({
        "model": "external", "law": "granular-cell", "density": 2000,
        "parameters": {
            "grains": 60, "grain_density": 2600, "seed": 5,
            "diameter": { "distribution": "uniform", "min": 0.8e-3, "max": 1.2e-3 },
            "contact": {
                "normal": { "law": "linear", "stiffness": 500.0 * PRESSURE, "damping_ratio": 0.4 },
                "friction": { "coefficient": 0.5 }
            },
            "preparation": { "pressure": PRESSURE }
        }
    })
}

fn common(method: &str, more: &Value) -> Value {
    let mut case = json!({
        "title": "a cell of grains at each point", "space": "plane-strain", "gravity": [0, 0],
        "materials": { "grains": cell() },
        "stages": [{ "name": "s", "duration": 1 }],
    });
    case["methods"] = json!({ method: more });
    case
}

/// One cell of the grid between walls, one of which moves: all nodes have prescribed motion.
fn mpm() -> Value {
    let options = json!({ "cell_size": 1, "points_per_cell": 2, "shape": "linear", "time_step": 1e-3 });
    let mut case = common("mpm", &options);
    case["domain"] = json!({ "min": [0, 0], "max": [1, 1] });
    case["bodies"] = json!([{
        "name": "b", "material": "grains", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
        "stress": { "kind": "uniform", "value": [-PRESSURE, -PRESSURE, -PRESSURE, 0, 0, 0] }
    }]);
    let smooth = json!({ "kind": "smooth" });
    case["boundaries"] = json!([
        { "side": "x-min", "wall": smooth }, { "side": "x-max", "wall": smooth }, { "side": "y-min", "wall": smooth },
        { "side": "y-max", "wall": smooth, "velocity": [0, -STRAIN / 1e-3] }
    ]);
    case
}

/// Particles with a prescribed linear velocity, and a free one beside them.
fn sph() -> Value {
    let options =
        json!({ "spacing": 0.1, "velocity_gradient": "corrected", "held": ["b"], "time_step": 1e-4 });
    let mut case = common("sph", &options);
    case["domain"] = json!({ "min": [-1, -1], "max": [2, 2] });
    case["materials"]["elastic"] =
        json!({ "model": "linear-elastic", "density": 2000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 });
    case["bodies"] = json!([
        {
            "name": "b", "material": "grains", "shape": { "kind": "box", "min": [0, 0], "max": [0.3, 0.3] },
            "stress": { "kind": "uniform", "value": [-PRESSURE, -PRESSURE, -PRESSURE, 0, 0, 0] },
            "velocity": { "kind": "linear", "value": [0, 0], "origin": [0, 0], "gradient": [[0, 0], [0, -STRAIN / 1e-4]] }
        },
        { "name": "far", "material": "elastic", "shape": { "kind": "box", "min": [1, 1], "max": [1.1, 1.1] } }
    ]);
    case
}

fn read(case: &Value) -> Result<Case, String> {
    colluvium::register_materials();
    Case::from_json(&case.to_string()).map_err(|errors| errors.to_string())
}

fn case(case: &Value) -> Case {
    read(case).unwrap()
}

fn begun(method: &str, value: &Value) -> Box<dyn Solver> {
    let mut solver = colluvium::method(method).unwrap().build(&case(value)).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    solver
}

/// Points after a number of steps of equal length.
fn stepped(solver: &mut dyn Solver, steps: usize) -> Snapshot {
    for _ in 0..steps {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    }
    solver.snapshot()
}

/// Stresses of the body of grains (Pa).
fn stresses(snapshot: &Snapshot) -> Vec<[f64; 6]> {
    let all = snapshot.tensors("stress").unwrap().iter().zip(&snapshot.bodies);
    all.filter(|(_, body)| **body == 0).map(|(stress, _)| stress.0).collect()
}

/// The cell alone in the element driver, with the same steps.
fn driven() -> TestTrace {
    let test = json!({
        "title": "the same cell", "material": cell(),
        "initial_stress": [-PRESSURE, -PRESSURE, -PRESSURE, 0, 0, 0],
        "stages": [{ "path": { "kind": "strain", "increment": [0, -STRAIN * STEPS as f64, 0, 0, 0, 0] }, "steps": STEPS }]
    });
    colluvium::element_test(&test.to_string()).unwrap().trace().unwrap()
}

#[test]
fn a_point_of_mpm_and_of_sph_has_the_stress_of_its_cell_in_the_element_driver() {
    let path = driven().path;
    let start = [-PRESSURE, -PRESSURE, -PRESSURE, 0.0, 0.0, 0.0];
    let own: Vec<f64> = ["xx", "yy", "zz", "xy"].map(|c| path.last(&format!("stress_{c}"))).to_vec();
    // The cell has yielded: the stress grows by far less than by its first stiffness.
    let rise = own[1] - start[1];
    assert!(rise < -0.1 * PRESSURE, "{own:?}");
    for (method, case) in [("mpm", mpm()), ("sph", sph())] {
        let found = stresses(&stepped(&mut *begun(method, &case), STEPS));
        assert!(found.len() >= 4, "{method}: {}", found.len());
        for stress in &found {
            for (c, own) in own.iter().enumerate() {
                let off = (stress[c] - own).abs() / rise.abs();
                // The driver's steps are equal in logarithmic strain, the methods' in time.
                assert!(off < 1e-3, "{method}: {stress:?}, {own:?}");
            }
        }
    }
}

/// Cell of the grid in space, of 50 spheres a point.
fn mpm_of_spheres() -> Value {
    let mut case = mpm();
    case["space"] = json!("3d");
    case["gravity"] = json!([0, 0, 0]);
    case["domain"] = json!({ "min": [0, 0, 0], "max": [1, 1, 1] });
    case["materials"]["grains"] = spheres();
    case["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0, 0, 0], "max": [1, 1, 1] });
    let smooth = json!({ "kind": "smooth" });
    let mut sides: Vec<Value> = ["x-min", "x-max", "y-min", "y-max", "z-min"]
        .iter()
        .map(|side| json!({ "side": side, "wall": smooth }))
        .collect();
    sides.push(json!({ "side": "z-max", "wall": smooth, "velocity": [0, 0, -STRAIN / 1e-3] }));
    case["boundaries"] = json!(sides);
    case
}

/// The cell of disks as one of spheres.
fn spheres() -> Value {
    let mut cell = cell();
    let own = &mut cell["parameters"];
    own["dimension"] = json!(3);
    own["grains"] = json!(50);
    own["contact"]["normal"]["stiffness"] = json!(500.0 * PRESSURE * 1e-3);
    cell
}

#[test]
fn points_of_spheres_have_the_stress_of_their_cell_in_the_element_driver() {
    let test = json!({
        "title": "the same cell", "material": spheres(),
        "initial_stress": [-PRESSURE, -PRESSURE, -PRESSURE, 0, 0, 0],
        "stages": [{ "path": { "kind": "oedometer", "axial_compression": STRAIN * STEPS as f64 }, "steps": STEPS }]
    });
    let path = colluvium::element_test(&test.to_string()).unwrap().trace().unwrap().path;
    let own = ["xx", "yy", "zz", "xy", "yz", "zx"].map(|c| path.last(&format!("stress_{c}")));
    let rise = own[2] + PRESSURE;
    assert!(rise < -0.1 * PRESSURE, "{own:?}");
    let found = stresses(&stepped(&mut *begun("mpm", &mpm_of_spheres()), STEPS));
    assert_eq!(found.len(), 8);
    for stress in &found {
        for (c, own) in own.iter().enumerate() {
            // The driver's steps are equal in logarithmic strain, the method's in time.
            assert!((stress[c] - own).abs() / rise.abs() < 1e-3, "{stress:?}, {own:?}");
        }
    }
}

#[test]
fn cells_of_grains_are_bit_identical_on_any_threads_and_after_a_restart() {
    for (method, case) in [("mpm", mpm()), ("sph", sph())] {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut solver = begun(method, &case);
                stepped(&mut *solver, 4);
                solver.checkpoint_bytes().unwrap()
            })
        };
        let one = on(1);
        assert!(one == on(3), "{method}: other bits on three threads");
        let mut whole = begun(method, &case);
        stepped(&mut *whole, 4);
        let mut again = colluvium::method(method).unwrap().build(&self::case(&case)).unwrap();
        again.restore(&mut one.as_slice()).unwrap();
        again.begin_stage(0, 0.0).unwrap();
        let (whole, again) = (stepped(&mut *whole, 2), stepped(&mut *again, 2));
        assert_eq!(whole.hash(), again.hash(), "{method}");
    }
}

#[test]
fn cells_of_disks_are_refused_where_there_is_strain_across_their_plane() {
    let mut value = mpm();
    value["space"] = json!("axisymmetric");
    let refusal = read(&value).unwrap_err();
    assert!(refusal.contains("materials.grains: its law has no strain normal to the plane"), "{refusal}");
    // Grains in tension at the start.
    let mut value = mpm();
    value["bodies"][0]["stress"]["value"] = json!([1e3, -1e3, 0, 0, 0, 0]);
    let refusal = colluvium::method("mpm").unwrap().build(&case(&value)).err().unwrap().to_string();
    assert!(refusal.contains("cannot carry tension"), "{refusal}");
}

#[test]
fn check_warns_of_the_cost_of_representative_cells_of_grains() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.json");
    std::fs::write(&file, mpm().to_string()).unwrap();
    let (code, text, errors) = output(program().args(["check", file.to_str().unwrap()]));
    assert_eq!(code, 0, "{errors}");
    assert!(
        errors.contains("warning[slow-law]: materials.grains: an update of a point takes about 0.14 ms "),
        "{errors}"
    );
    assert!(errors.contains("for the 4 points of the body \"b\" and 1000 steps"), "{errors}");
    // 60 grains a point, each with a step and with loading and storing its state; without them three million points a second.
    let plan = colluvium::method("mpm").unwrap().plan(&case(&mpm())).unwrap();
    assert!(plan.updates_per_second < 1e6 / 60.0 && plan.updates_per_second > 1e3, "{plan:?}");
    assert!(text.contains("duration       about "), "{text}");
}

/// Box that grains fill.
fn filled(width: f64, diameter: f64) -> Value {
    json!({
        "title": "a box of grains", "space": "3d", "domain": { "min": [0, 0, 0], "max": [width, width, width] },
        "gravity": [0, 0, -9.81],
        "materials": { "grain": { "model": "linear-elastic", "density": 2600, "youngs_modulus": 1e7, "poissons_ratio": 0.2 } },
        "bodies": [{ "name": "b", "material": "grain", "shape": { "kind": "box", "min": [0, 0, 0], "max": [width, width, width] } }],
        "boundaries": [{ "side": "z-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "s", "duration": 1e-3 }],
        "methods": { "dem": {
            "grains": { "grain": { "density": 2600, "diameter": { "distribution": "uniform", "min": 0.8 * diameter, "max": diameter },
                                   "fill": { "kind": "random", "solid_fraction": 0.55 } } },
            "pairs": [
                { "between": ["grain", "grain"], "normal": { "law": "linear", "stiffness": 1e5, "damping_ratio": 0.1 },
                  "friction": { "coefficient": 0.5 } },
                { "between": ["grain", "z-min"], "normal": { "law": "linear", "stiffness": 1e5, "damping_ratio": 0.1 } }
            ]
        } }
    })
}

#[test]
fn slow_grain_placement_gives_a_notice_and_grains_beyond_memory_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.json");
    let path = file.to_str().unwrap();
    std::fs::write(&file, filled(1e3, 1e-3).to_string()).unwrap();
    for command in ["check", "run"] {
        let (code, _, errors) = output(program().args([command, path]));
        assert_eq!(code, 3, "{errors}");
        let refusal =
            "error[not-enough-memory]: methods.dem.grains: gives about 1.4e18 points, which need at least ";
        assert!(
            errors.starts_with(refusal) && errors.ends_with("use larger grains or smaller bodies\n"),
            "{errors}"
        );
    }
    // Size notice for a box of a million grains, which are not placed here.
    let dem = colluvium::method("dem").unwrap();
    let notice = |value: &Value| dem.problem_size(&case(value)).unwrap().size_notice();
    let words = notice(&filled(1.0, 0.01)).unwrap();
    assert!(
        words.text.starts_with("methods.dem.grains: about 1.4e6 points will be placed. This takes about "),
        "{words}"
    );
    assert_eq!(notice(&filled(1.0, 0.1)), None);
}

/// Disks that fall on a floor and come to rest, in stages.
fn bed() -> Value {
    json!({
        "title": "bed of disks", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, -10],
        "materials": { "sand": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
        "bodies": [{ "name": "bed", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [1, 0.4] } }],
        "boundaries": [
            { "side": "y-min", "wall": { "kind": "rough" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
            { "side": "x-max", "wall": { "kind": "smooth" } }
        ],
        "stages": [{ "name": "fall", "duration": 0.3 }, { "name": "rest", "duration": 0.1 }],
        "methods": { "dem": {
            "grains": { "sand": { "density": 2500, "fill": { "kind": "random", "solid_fraction": 0.7 },
                "diameter": { "distribution": "uniform", "min": 0.04, "max": 0.06 } } },
            "pairs": [{ "between": ["sand", "sand"], "friction": { "coefficient": 0.5 }, "rolling": { "friction": 0.1 },
                "normal": { "law": "linear", "stiffness": 1e6, "restitution": 0.3 } }],
            "stages": { "rest": { "reset_contacts": false } }
        } }
    })
}

#[test]
fn a_specimen_written_by_the_command_line_is_read_by_another_case() {
    let folder = tempfile::tempdir().unwrap();
    let command = |arguments: &[&str]| in_folder(folder.path(), arguments);
    std::fs::write(folder.path().join("bed.json"), bed().to_string()).unwrap();
    let prepare = ["specimen", "bed.json", "--until", "fall", "--out", "bed.specimen.json"];
    let (code, said, problems) = command(&prepare);
    assert!(code == 0 && said.contains("grains with their contacts at 0.300000 s"), "{said}{problems}");
    assert_eq!(command(&prepare).0, 2, "there is one already");
    let (code, _, problems) = command(&["specimen", "bed.json", "--until", "fell", "--out", "no.json"]);
    assert!(code == 3 && problems.contains("there is no stage \"fell\"; there are fall, rest"), "{problems}");
    // A case of the second stage alone, started from the file in its own folder, ends where the whole run does.
    let mut second = bed();
    second["stages"].as_array_mut().unwrap().remove(0);
    second["methods"]["dem"]["specimen"] = json!("bed.specimen.json");
    std::fs::write(folder.path().join("second.json"), second.to_string()).unwrap();
    for name in ["bed", "second"] {
        let (code, _, problems) = command(&["run", &format!("{name}.json"), "--out", name, "-q"]);
        assert_eq!(code, 0, "{problems}");
    }
    let end = |name: &str| -> Value {
        serde_json::from_slice(&std::fs::read(folder.path().join(name).join("summary.json")).unwrap())
            .unwrap()
    };
    let (whole, second) = (end("bed"), end("second"));
    let number = |of: &Value, key: &str| of["end"][key].as_f64().unwrap();
    assert_eq!(number(&whole, "mass"), number(&second, "mass"));
    let (own, other) = (number(&whole, "potential_energy"), number(&second, "potential_energy"));
    assert!((own - other).abs() < 1e-9 * own, "{own}, {other}");
}

#[test]
fn a_specimen_from_a_run_folder_equals_that_from_running_the_case() {
    let folder = tempfile::tempdir().unwrap();
    let command = |arguments: &[&str]| in_folder(folder.path(), arguments);
    std::fs::write(folder.path().join("bed.json"), bed().to_string()).unwrap();
    for arguments in [
        &["run", "bed.json", "--out", "bed", "-q"][..],
        &["specimen", "bed.json", "--out", "run.json", "-q"],
        &["specimen", "bed", "--out", "left.json", "--until", "rest"],
    ] {
        let (code, said, problems) = command(arguments);
        assert_eq!((code, problems.as_str()), (0, ""), "{said}");
    }
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(read("run.json") == read("left.json"), "to the last bit");
    // For a state that a folder lacks, the message names the remedy.
    let early = ["specimen", "bed", "--out", "no.json", "--until", "fall"];
    let (code, _, problems) = command(&early);
    let cure = "case.json --until fall --out no.json` runs the case again to the end of \"fall\"";
    assert!(
        code == 2 && problems.contains("contains the end of its last stage only") && problems.contains(cure),
        "{problems}"
    );
    assert_eq!(command(&["specimen", ".", "--out", "no.json"]).0, 2, "no run");
    let (code, _, problems) = command(&["specimen", "bed", "--method", "mpm", "--out", "no.json"]);
    assert!(code == 2 && problems.contains("is a run of dem, not of mpm"), "{problems}");
    std::fs::remove_file(folder.path().join("bed/checkpoint.bin")).unwrap();
    let (code, _, problems) = command(&["specimen", "bed", "--out", "no.json"]);
    assert!(
        code == 1 && problems.contains("checkpoint.bin with the history of the contacts is missing"),
        "{problems}"
    );
    assert!(!folder.path().join("no.json").exists());
}

/// Two kinds of grains in a box, the lower ones held, with spin and velocity.
fn mixed(dimension: usize) -> Value {
    let of = |values: [f64; 3]| values[..dimension].to_vec();
    let fill = json!({ "kind": "lattice", "packing": "square", "jitter": 0.02 });
    let kind = |density: f64| {
        json!({ "density": density, "fill": fill,
        "diameter": { "distribution": "uniform", "min": 0.05, "max": 0.06 } })
    };
    let soil = json!({ "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 });
    let part = |low: f64, high: f64| {
        let up = |height: f64, side: f64| {
            of(if dimension == 2 { [side, height, 0.0] } else { [side, side, height] })
        };
        json!({ "kind": "box", "min": up(low, 0.0), "max": up(high, 0.3) })
    };
    let spin = if dimension == 2 { vec![3.0] } else { vec![1.0, -2.0, 3.0] };
    json!({
        "title": "two kinds", "space": if dimension == 2 { "plane-strain" } else { "3d" },
        "domain": { "min": of([-1.0; 3]), "max": of([2.0; 3]) }, "gravity": of([0.0; 3]),
        "materials": { "clay": soil, "rock": soil },
        "bodies": [
            { "name": "floor", "material": "rock", "shape": part(0.0, 0.1) },
            { "name": "heap", "material": "clay", "shape": part(0.12, 0.3),
              "velocity": { "kind": "uniform", "value": of([0.4, -0.3, -0.5]) } }
        ],
        "stages": [{ "name": "s", "duration": 0.1 }],
        "methods": { "dem": {
            "grains": { "clay": kind(2000.0), "rock": kind(3000.0) },
            "bodies": { "floor": { "held": true }, "heap": { "spin": spin } },
            "pairs": [{ "between": ["clay", "clay"], "normal": { "law": "linear", "stiffness": 1e5, "restitution": 0.5 },
                        "friction": { "coefficient": 0.5 } },
                      { "between": ["rock", "rock"], "normal": { "law": "linear", "stiffness": 1e5, "restitution": 0.5 } }],
            "mix": true
        } }
    })
}

#[test]
fn points_of_an_export_are_the_grains_of_a_case_that_reads_them() {
    use colluvium::case::output::{Collection, NpzValues, read_frame, read_npz};
    for dimension in [2, 3] {
        let folder = tempfile::tempdir().unwrap();
        let mut value = mixed(dimension);
        std::fs::write(folder.path().join("case.json"), value.to_string()).unwrap();
        for arguments in [
            &["run", "case.json", "--out", "out", "-q"][..],
            &["export", "out", "--points"],
            &["export", "out"],
        ] {
            let (code, _, problems) = in_folder(folder.path(), arguments);
            assert_eq!(code, 0, "{problems}");
        }
        let out = folder.path().join("out");
        let last = Collection::read(&out.join("frames.pvd")).unwrap().frames.pop().unwrap();
        let end = read_frame(&out.join(&last.1), last.0).unwrap();
        // One body of all grains: their properties are in the file.
        let whole = json!({ "kind": "box", "min": value["domain"]["min"], "max": value["domain"]["max"] });
        value["bodies"] = json!([{ "name": "all", "material": "clay", "shape": whole, "points": { "file": "out/points.csv" } }]);
        value["methods"]["dem"]["bodies"] = json!({});
        colluvium::register_materials();
        let again = Case::from_value(&value, folder.path()).unwrap();
        let mut solver = colluvium::method("dem").unwrap().build(&again).unwrap();
        solver.begin_stage(0, 0.0).unwrap();
        let start = solver.snapshot();
        assert_eq!((&start.ids, &start.positions), (&end.ids, &end.positions));
        for name in ["velocity", "radius", "kind", "spin", "held", "mass"] {
            assert_eq!(start.field(name).unwrap().data, end.field(name).unwrap().data, "{name}");
        }
        let held = end.scalars("held").unwrap();
        assert!(held.contains(&1.0) && held.contains(&0.0), "{held:?}");
        let moved = end.vectors("displacement").unwrap().iter().any(|u| u[dimension - 1] < -0.01);
        let kinds = end.scalars("kind").unwrap();
        assert!(moved && kinds.contains(&0.0) && kinds.contains(&1.0));
        let arrays = read_npz(&out.join("npz/frame-00001.npz")).unwrap();
        let archived = |name: &str| arrays.iter().find(|array| array.name == name).unwrap().values.clone();
        assert_eq!(archived("held"), NpzValues::Float(held.to_vec()));
        assert_eq!(archived("kind"), NpzValues::Float(kinds.to_vec()));
        let (code, said, problems) =
            in_folder(folder.path(), &["export", "out", "--points", "--body", "heap"]);
        let count = held.iter().filter(|own| **own == 0.0).count();
        assert!(code == 0 && said.contains(&format!("wrote the {count} points")), "{said}{problems}");
        assert_eq!(in_folder(folder.path(), &["export", "out", "--points", "--body", "hill"]).0, 2);
    }
}
