//! Specimen files: a case that begins with one continues where another stopped.

use std::path::{Path, PathBuf};

use colluvium_case::{Case, Method, Snapshot, Solver};
use colluvium_dem::{Contact, Dem, DemSolver, disks, spheres};
use colluvium_testkit::{advance_steps, read_case, scalar_output};
use serde_json::{Value, json};

use crate::determinism::heap;
use crate::single_grains::begun;

/// Periodic box of disks under stress control and at a shear rate.
fn cell() -> Value {
    let mut value = heap(2);
    value["domain"] = json!({ "min": [0, 0], "max": [2, 2], "periodic": ["x", "y"] });
    value["gravity"] = json!([0, 0]);
    value["boundaries"] = json!([]);
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0, 0], "max": [2, 2] });
    value["methods"]["dem"]["grains"]["sand"]["fill"]["solid_fraction"] = json!(0.8);
    value["methods"]["dem"]["stages"] = json!({ "fall": { "cell": { "xx": { "stress": -2e4 }, "yy": { "stress": -2e4 }, "xy": { "rate": 2 } } } });
    value
}

/// Case that begins with a file, in place of its filling.
fn from(value: &Value, file: &Path) -> Value {
    let mut value = value.clone();
    value["methods"]["dem"]["specimen"] = json!(file.display().to_string());
    value
}

fn read(value: &Value) -> Case {
    read_case(value)
}

fn kept(folder: &tempfile::TempDir, text: &str) -> PathBuf {
    let file = folder.path().join("specimen.json");
    std::fs::write(&file, text).unwrap();
    file
}

/// Normal force and magnitude of the force of each contact (N), sorted.
fn forces<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> Vec<[f64; 2]> {
    let of = |contact: Contact<D>| [contact.normal, contact.force.iter().map(|c| c * c).sum::<f64>().sqrt()];
    let mut all: Vec<[f64; 2]> = solver.contacts().iter().map(of).collect();
    all.sort_by(|a, b| a[0].total_cmp(&b[0]));
    all
}

/// Checks that two solvers have equal contacts and forces, to round-off.
fn same_forces<const D: usize, const R: usize>(a: &DemSolver<D, R>, b: &DemSolver<D, R>, slack: f64) {
    let (own, other) = (forces(a), forces(b));
    assert_eq!(own.len(), other.len(), "as many contacts");
    let largest = own.last().unwrap()[0];
    assert!(largest > 0.0);
    let apart = |(a, b): &(&[f64; 2], &[f64; 2])| (0..2).any(|k| (a[k] - b[k]).abs() > slack * largest);
    let off: Vec<_> = own.iter().zip(&other).filter(apart).collect();
    assert!(off.is_empty(), "{} of {}, of {largest} N: {off:?}", off.len(), own.len());
}

/// Checks that two solvers have equal grains at equal positions and velocities, to round-off.
fn same_grains(a: &dyn Solver, b: &dyn Solver, slack: f64) {
    let (own, other) = (a.snapshot(), b.snapshot());
    assert_eq!(own.ids, other.ids);
    let speeds = |snapshot: &Snapshot| snapshot.vectors("velocity").unwrap().to_vec();
    let fastest = speeds(&own).iter().flatten().fold(0.0f64, |largest, v| largest.max(v.abs()));
    for (a, b) in own.positions.iter().zip(&other.positions) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() <= slack), "{a:?}, {b:?}");
    }
    for (a, b) in speeds(&own).iter().zip(&speeds(&other)) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() <= slack * fastest), "{a:?}, {b:?}");
    }
}

/// Runs a case, writes its specimen after `first` steps, and continues from it and without it.
fn continues_from_its_specimen<const D: usize, const R: usize>(
    value: &Value,
    first: usize,
    solver: impl Fn(&Case) -> Result<DemSolver<D, R>, colluvium_case::CaseError>,
) {
    let folder = tempfile::tempdir().unwrap();
    let mut whole = begun(solver(&read(value)).unwrap());
    advance_steps(&mut whole, first);
    let file = kept(&folder, &whole.specimen().unwrap());
    let mut again = begun(solver(&read(&from(value, &file))).unwrap());
    // Grains that have left a cell are wrapped into it, as an image with the velocity of the cell.
    let periodic = read(value).domain.is_periodic(0);
    // Only the order of sums differs.
    same_forces(&whole, &again, 1e-12);
    if !periodic {
        same_grains(&whole, &again, 1e-12);
    }
    for solver in [&mut whole, &mut again] {
        advance_steps(solver, 1);
    }
    let of_cell = ["cell_stress.xx", "cell_stress.xy", "cell_stress.yy", "cell.x"];
    let always = ["coordination", "sliding_contacts"];
    for name in always.into_iter().chain(of_cell.into_iter().filter(|_| periodic)) {
        let (own, other) = (scalar_output(&whole, name), scalar_output(&again, name));
        assert!((own - other).abs() <= 1e-10 * own.abs() && own.is_finite(), "{name}: {own}, {other}");
    }
    if !periodic {
        let kinetic = [whole.totals().kinetic, again.totals().kinetic];
        assert!((kinetic[0] - kinetic[1]).abs() <= 1e-11 * kinetic[0], "{kinetic:?}");
    }
    for solver in [&mut whole, &mut again] {
        advance_steps(solver, 60);
    }
    // Round-off grows where grains collide. In a cell that deforms by a share `L Δt` in a step, an image moves like its grain only up to
    // the square of that share, so that the time matters at which grains are wrapped into the cell.
    same_forces(&whole, &again, if periodic { 1e-3 } else { 1e-8 });
    assert!(scalar_output(&again, "energy_error").abs() < 0.01, "{}", scalar_output(&again, "energy_error"));
}

#[test]
fn a_heap_continues_from_its_specimen_file_with_equal_forces() {
    continues_from_its_specimen(&heap(2), 1500, disks);
    continues_from_its_specimen(&heap(3), 700, spheres);
}

#[test]
fn a_compressed_and_sheared_cell_continues_from_its_specimen_file_with_equal_forces() {
    continues_from_its_specimen(&cell(), 3000, disks);
    let mut bonded = cell();
    bonded["methods"]["dem"]["pairs"][0]["bond"] =
        json!({ "normal_stiffness": 1e8, "shear_stiffness": 1e8, "gap": 0.3 });
    continues_from_its_specimen(&bonded, 500, disks);
}

#[test]
fn contacts_with_an_obstacle_and_a_moving_wall_continue_from_a_specimen_file() {
    let mut value = heap(2);
    value["obstacles"] = json!([{ "name": "ramp", "wall": { "kind": "frictional", "friction_coefficient": 0.3 },
        "shape": { "kind": "polygon", "vertices": [[0, -1], [3, -1], [3, 0.1], [1.5, 0.6], [0, 0.1]] } }]);
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0.1, 0.7], "max": [2.9, 2.7] });
    value["boundaries"][1]["velocity"] = json!([0.5, 0]);
    value["boundaries"][1]["name"] = json!("piston");
    continues_from_its_specimen(&value, 2500, disks);
}

/// Messages on a case that begins with the changed text of a file.
fn messages(value: &Value, text: &str) -> Result<Vec<String>, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = kept(&folder, text);
    let plan = Dem.plan(&read(&from(value, &file)));
    plan.map(|plan| plan.warnings.into_iter().map(|warning| warning.text).collect())
        .map_err(|error| error.to_string().replace(&file.display().to_string(), "FILE"))
}

#[test]
fn missing_data_of_specimen_files_and_cases_are_named() {
    let value = cell();
    let mut solver = begun(disks(&read(&value)).unwrap());
    advance_steps(&mut solver, 500);
    let text = solver.specimen().unwrap();
    let notes = messages(&value, &text).unwrap();
    assert!(notes.iter().any(|note| note.contains("replaces the domain")), "{notes:?}");
    let refused = |value: &Value, text: &str, problem: &str| {
        let error = messages(value, text).unwrap_err();
        assert!(error.starts_with("methods.dem.specimen: FILE: ") && error.contains(problem), "{error}");
    };
    refused(&value, &text[..text.len() / 2], "is not a complete specimen file: EOF");
    refused(&value, &text.replacen("colluvium-specimen-1", "colluvium-specimen-9", 1), "its format is");
    refused(&value, &text.replacen("\"radius\"", "\"radios\"", 1), "the grains have no column \"radius\"");
    refused(&value, &text.replacen("\"slide\"", "\"slip\"", 1), "the contacts have no column \"slide\"");
    refused(
        &value,
        &text.replacen("\"sand\"", "\"gravel\"", 1),
        "of the kind \"gravel\", but in the case they are of the kind \"sand\"",
    );
    refused(&value, &text.replacen("\"heap\"\n", "\"pile\"\n", 1), "has grains of the body \"pile\"");
    let parsed: Value = serde_json::from_str(&text).unwrap();
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut other = parsed.clone();
        change(&mut other);
        other.to_string()
    };
    let rows = |table: &'static str| {
        move |text: &mut Value| text[table]["rows"][0].as_array_mut().unwrap().truncate(3)
    };
    refused(&value, &changed(&rows("grains")), "row 1 of the grains has 3 numbers");
    refused(&value, &changed(&rows("contacts")), "row 1 of the contacts has 3 numbers");
    refused(
        &value,
        &changed(&|text| text["contacts"]["rows"][0][0] = json!(99_999)),
        "there is no grain 99999",
    );
    refused(
        &value,
        &changed(&|text| text["grains"]["rows"][0][0] = text["grains"]["rows"][1][0].clone()),
        "is given twice",
    );
    refused(
        &value,
        &changed(&|text| text["head"]["cell"]["periodic"] = json!([true, false])),
        "its cell is periodic along \"x\", but",
    );
    let mut other = value.clone();
    other["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [1, 0] });
    assert!(messages(&other, &text).unwrap_err().starts_with("bodies[0].velocity: "));
    assert!(messages(&heap(3), &text).unwrap_err().contains("has 2 dimensions, but the case has 3"));
}

#[test]
fn contacts_with_a_missing_wall_are_omitted_with_a_note() {
    let mut value = heap(2);
    let mut solver = begun(disks(&read(&value)).unwrap());
    advance_steps(&mut solver, 1500);
    let text = solver.specimen().unwrap();
    assert!(!messages(&value, &text).unwrap().iter().any(|note| note.contains("they are left out")));
    value["boundaries"].as_array_mut().unwrap().remove(0);
    let notes = messages(&value, &text).unwrap();
    let gone = notes.iter().find(|note| note.contains("they are left out")).unwrap();
    assert!(gone.contains("contacts of the specimen are with the wall \"y-min\""), "{gone}");
    // Another body is filled beside the specimen, with new ids.
    value["boundaries"] = heap(2)["boundaries"].clone();
    value["bodies"].as_array_mut().unwrap().push(json!({ "name": "more", "material": "sand",
        "shape": { "kind": "box", "min": [1, 3.2], "max": [2, 3.8] } }));
    let folder = tempfile::tempdir().unwrap();
    let both = disks(&read(&from(&value, &kept(&folder, &text)))).unwrap().snapshot();
    let mut ids = both.ids.clone();
    ids.dedup();
    assert!(ids.len() == both.ids.len() && ids.len() > solver.point_count() + 10);
    assert_eq!(both.bodies.iter().filter(|body| **body == 0).count(), solver.point_count());
}
