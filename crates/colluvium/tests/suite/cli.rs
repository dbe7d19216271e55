//! The command line, run as a user runs it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant, SystemTime};

use serde_json::{Value, json};

use super::{output, program};

/// Small column that collapses.
pub fn column() -> Value {
    json!({
        "title": "small column", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [0.4, 0.12] }, "gravity": [0, -9.81],
        "materials": { "sand": {
            "model": "mohr-coulomb", "density": 1925, "youngs_modulus": 1e6, "poissons_ratio": 0.23, "friction_angle": 31
        } },
        "bodies": [{ "name": "column", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [0.1, 0.1] } }],
        "boundaries": [
            { "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } },
            { "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.6 } }
        ],
        "stages": [
            { "name": "hold", "duration": 0.02, "damping": 0.5 },
            { "name": "go", "duration": 0.1, "reset": ["velocity"] }
        ],
        "output": { "frames": 0.02, "measures": 0.005, "checkpoint": 0.02 },
        "measures": {
            "front": { "kind": "front", "side": "x-max" },
            "surface": { "kind": "profile", "axis": 0, "height": 1, "bin": 0.02 }
        },
        "methods": { "mpm": { "cell_size": 0.01, "courant": 0.3 } }
    })
}

pub fn write(folder: &Path, name: &str, case: &Value) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, case.to_string()).expect("a file in a temporary folder");
    path
}

fn summary(out: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(out.join("summary.json")).expect("a summary")).expect("JSON")
}

/// Output files of a finished run except the wall time, by name.
fn results(out: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<(String, Vec<u8>)> = [out.to_owned(), out.join("frames")]
        .iter()
        .flat_map(|folder| {
            fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path())
        })
        .filter(|path| path.is_file() && !path.ends_with("summary.json"))
        .map(|path| {
            (
                path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                fs::read(&path).expect("a file"),
            )
        })
        .collect();
    files.sort();
    files
}

#[test]
fn broken_cases_end_with_code_3_and_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let breakages: Vec<(&str, &str, Value)> = vec![
        ("/title", "title", json!(1)),
        ("/space", "space", json!("4d")),
        ("/domain/min", "domain.max[0]", json!([1, 0])),
        ("/gravity", "gravity", json!([0])),
        ("/materials/sand/friction_angle", "materials.sand.friction_angle", json!(95)),
        ("/materials/sand/friction", "materials.sand.friction", json!(30)),
        ("/materials/sand/poissons_ratio", "materials.sand.poissons_ratio", json!(0.7)),
        ("/materials/sand/model", "materials.sand.model", json!("gravel")),
        ("/bodies/0/material", "bodies[0].material", json!("clay")),
        ("/bodies/0/shape/max", "bodies[0].shape", json!([0.1, 9])),
        ("/bodies/0/shape/kind", "bodies[0].shape.kind", json!("bx")),
        ("/boundaries/0/side", "boundaries[0].side", json!("left")),
        ("/boundaries/2/wall/friction_coefficient", "boundaries[2].wall.friction_coefficient", json!(-1)),
        ("/stages/0/duration", "stages[0].duration", json!(-1)),
        ("/stages/0/damping", "stages[0].damping", json!(3)),
        ("/stages/1/reset", "stages[1].reset[0]", json!(["all"])),
        ("/output/frames", "output.frames", json!(0)),
        ("/measures/front/side", "measures.front.side", json!("ahead")),
        ("/methods/mpm/cell_size", "methods.mpm.cell_size", json!(0.03)),
        ("/methods/mpm/shape", "methods.mpm.shape", json!("hexagonal")),
        ("/methods/mpm/time_step", "methods.mpm.time_step", json!(1.0)),
        ("/methods/unheard_of", "methods.unheard_of", json!({})),
        ("/methods/mpm/flip", "methods.mpm.flip", json!(2)),
        ("/output/fields", "output.fields[1]", json!(["stress", "strss"])),
        (
            "/measures/front",
            "measures.front.fields[0]",
            json!({ "kind": "probe", "position": [0, 0], "radius": 0.1, "fields": ["heat"] }),
        ),
        ("/measures/mass", "measures.mass", json!({ "kind": "front", "side": "x-max" })),
        (
            "/loads",
            "loads[0].body",
            json!([{ "kind": "traction", "body": "x", "side": "x-max", "value": [1, 0] }]),
        ),
    ];
    for (number, (pointer, path, value)) in breakages.into_iter().enumerate() {
        let mut case = column();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match case.pointer_mut(parent).unwrap() {
            Value::Object(map) => {
                map.insert(key.to_owned(), value);
            }
            other => other[key.parse::<usize>().unwrap()] = value,
        }
        let file = write(folder.path(), &format!("broken-{number}.json"), &case);
        let out = folder.path().join(format!("out-{number}"));
        for command in ["check", "run", "run --quiet"] {
            let mut run = program();
            run.args(command.split(' ')).arg(&file);
            if command != "check" {
                run.arg("--out").arg(&out);
            }
            let (code, _, errors) = output(&mut run);
            assert_eq!(code, 3, "{command} {pointer}: {errors}");
            // A run warns before its method looks at the case.
            let first = errors.lines().find(|line| !line.starts_with("warning: ")).unwrap_or_default();
            assert!(first.starts_with(&format!("error: {path}: ")), "{command} {pointer}: {first}");
            assert!(!errors.contains("panicked"), "{errors}");
        }
        assert!(!out.exists(), "{pointer}: a broken case leaves nothing");
    }
}

#[test]
fn a_case_for_several_methods_asks_which_and_tells_of_no_grid_where_there_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["methods"]["sph"] = json!({ "spacing": 0.01 });
    let file = write(folder.path(), "both.json", &case);
    let (code, _, errors) = output(program().arg("check").arg(&file));
    assert!(code == 2 && errors.contains("several methods, mpm, sph: choose one with --method"), "{errors}");
    let text = |method: &str| output(program().args(["check", "--method", method]).arg(&file)).1;
    assert!(text("mpm").contains("grid nodes") && !text("sph").contains("grid nodes"));
}

#[test]
fn a_check_warns_on_standard_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "column.json", &column());
    let (code, text, errors) = output(program().arg("check").arg(&file));
    assert!(code == 0 && text.contains("points") && !text.contains("warning"), "{text}");
    assert!(errors.starts_with("warning: stages[0].damping: "), "{errors}");
}

#[test]
fn a_problem_that_does_not_fit_in_memory_is_refused_before_it_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let mut mpm = column();
    mpm["methods"]["mpm"]["cell_size"] = json!(1e-7);
    let mut sph = column();
    sph["methods"] = json!({ "sph": { "spacing": 1e-7 } });
    let mut coarse = column();
    coarse["methods"]["mpm"]["cell_size"] = json!(0.01);
    for (name, case, key, points) in [
        ("mpm", mpm, "methods.mpm.cell_size", "4.0e12 points and 4.8e12 grid nodes"),
        ("sph", sph, "methods.sph.spacing", "1.0e12 points"),
    ] {
        let file = write(folder.path(), &format!("{name}.json"), &case);
        let out = folder.path().join(name);
        for command in [vec!["check"], vec!["run", "--out", out.to_str().unwrap()]] {
            let (code, _, errors) = output(program().args(&command).arg(&file));
            assert_eq!(code, 3, "{command:?}: {errors}");
            let start = format!("error: {key}: gives about {points}, which need at least ");
            assert!(errors.starts_with(&start) && errors.contains(" GB of memory; "), "{errors}");
        }
        assert!(!out.exists());
    }
    let sweep = json!({ "title": "finer", "case": "coarse.json",
        "parameters": { "cell": { "at": ["methods.mpm.cell_size"], "values": [0.01, 1e-7] } } });
    write(folder.path(), "coarse.json", &coarse);
    let (code, _, errors) =
        output(program().args(["sweep", "--check"]).arg(write(folder.path(), "sweep.json", &sweep)));
    assert!(
        code == 3 && errors.contains("methods.mpm.cell_size: gives about 4.0e12 points"),
        "{code} {errors}"
    );
}

#[test]
fn files_that_are_no_cases_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("none.json");
    let (code, _, errors) = output(program().arg("check").arg(&missing));
    assert!(code == 3 && errors.contains("cannot be read"), "{errors}");
    let torn = folder.path().join("torn.json");
    fs::write(&torn, "{ \"title\": \"x\", ").unwrap();
    let (code, _, errors) = output(program().arg("run").arg(&torn));
    let place = format!("error: {}: line 1, column 16: ", torn.display());
    assert!(code == 3 && errors.starts_with(&place), "{errors}");
    let (code, ..) = output(program().arg("frobnicate"));
    assert_eq!(code, 2);
}

#[test]
fn threads_do_not_change_a_bit() {
    let folder = tempfile::tempdir().unwrap();
    let shapes = ["linear", "ugimp", "cpgimp", "quadratic", "cubic"];
    let pairs = shapes.iter().flat_map(|shape| ["usf", "usl", "musl"].map(|scheme| (*shape, scheme)));
    for (shape, scheme) in pairs {
        let mut case = column();
        case["methods"]["mpm"]["shape"] = json!(shape);
        case["methods"]["mpm"]["stress_update"] = json!(scheme);
        case["stages"] = json!([{ "name": "go", "duration": 0.03 }]);
        let name = format!("{shape}-{scheme}");
        let file = write(folder.path(), &format!("{name}.json"), &case);
        let run = |threads: &str| {
            let out = folder.path().join(format!("{name}-{threads}"));
            let mut command = program();
            command.args(["run", "--quiet", "--threads", threads, "--out"]).arg(&out).arg(&file);
            let (code, _, errors) = output(&mut command);
            assert_eq!(code, 0, "{name}: {errors}");
            (summary(&out)["snapshot_hash"].clone(), results(&out))
        };
        let (one, two) = (run("1"), run("2"));
        assert!(one.0.is_string() && one.0 == two.0, "{name}: {} and {}", one.0, two.0);
        assert!(one.1 == two.1, "{name}: every file is the same");
    }
}

/// Column with cohesion for a search of its strength.
fn searched() -> Value {
    let mut case = column();
    case["materials"]["sand"]["cohesion"] = json!(2000);
    case["stages"] = json!([{ "name": "rest", "duration": 0.01, "damping": 0.5 }]);
    case["measures"] = json!({ "safety": {
        "kind": "factor-of-safety", "after": "rest", "duration": 0.1, "height": 0.1, "damping": 0.5,
        "range": [0.5, 20], "tolerance": 0.1
    } });
    case
}

/// Eight halvings of 19.5 come below 0.1; undecided trials leave both halves to search. A block is a twelfth of the duration.
#[test]
fn a_check_tells_what_a_search_takes() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "slope.json", &searched());
    let (code, text, _) = output(program().arg("check").arg(&file));
    let line = text.lines().find(|line| line.starts_with("search")).unwrap_or_else(|| panic!("{text}"));
    let told =
        "search         safety: 10 trials, 17 at most, of 12 blocks at most, about 0.008 s each: about ";
    assert!(code == 0 && line.starts_with(told), "{line}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_search_ends_with_code_4_and_goes_on_when_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "slope.json", &searched());
    let run = |out: &Path, flag: Option<&str>| {
        let mut command = program();
        command.args(["run", "--quiet", "--out"]).arg(out).arg(&file).args(flag);
        command
    };
    let out = folder.path().join("cut");
    let mut child = run(&out, None).spawn().expect("the program starts");
    while !out.join("trials-safety.csv").exists() && child.try_wait().expect("a child").is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(killed.success());
    assert_eq!(child.wait().expect("a child").code(), Some(4));
    assert_eq!(summary(&out)["status"], "interrupted");
    let (code, _, errors) = output(&mut run(&out, Some("--resume")));
    assert_eq!(code, 0, "{errors}");
    let whole = folder.path().join("whole");
    assert_eq!(output(&mut run(&whole, None)).0, 0);
    let (found, exact) = (summary(&out), summary(&whole));
    assert!(exact["factors_of_safety"]["safety"]["told"].is_string(), "{exact}");
    assert_eq!(found["factors_of_safety"], exact["factors_of_safety"]);
    assert_eq!(found["snapshot_hash"], exact["snapshot_hash"]);
    assert!(results(&out) == results(&whole), "every file is the same");
}

fn modified(file: &Path) -> Option<SystemTime> {
    fs::metadata(file).and_then(|data| data.modified()).ok()
}

/// The first frame after the start, once a checkpoint was written after it.
fn frame_before_checkpoint(out: &Path) -> Option<(PathBuf, SystemTime)> {
    let entries = fs::read_dir(out.join("frames")).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    let mut frames: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|extension| extension == "vtu")).collect();
    frames.sort();
    let frame = frames.into_iter().nth(1)?;
    let (written, saved) = (modified(&frame)?, modified(&out.join("checkpoint.bin"))?);
    (saved > written).then_some((frame, written))
}

#[test]
fn a_killed_run_resumes_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "column.json", &column());
    let whole = folder.path().join("whole");
    let (code, _, errors) = output(program().args(["run", "--quiet", "--out"]).arg(&whole).arg(&file));
    assert_eq!(code, 0, "{errors}");
    assert_eq!(summary(&whole)["status"], "completed");
    assert_eq!(summary(&whole)["commit"].as_str(), colluvium::COMMIT);
    let killed = folder.path().join("killed");
    let mut kills = 0;
    let mut kept = None;
    // Later and later, so that the run progresses between two kills at any speed of the machine.
    for attempt in 0..60u64 {
        let mut command = program();
        command.args(["run", "--quiet", "--out"]).arg(&killed).arg(&file);
        if killed.join("summary.json").exists() {
            command.arg("--resume");
        }
        let mut child = command.spawn().expect("the program starts");
        let patience = Instant::now() + Duration::from_millis(30 + 37 * attempt);
        // The first kill waits until there is output that only a run from the start would write again.
        while kept.is_none() && child.try_wait().expect("a child").is_none() {
            std::thread::sleep(Duration::from_millis(1));
            kept = frame_before_checkpoint(&killed);
        }
        while child.try_wait().expect("a child").is_none() && Instant::now() < patience {
            std::thread::sleep(Duration::from_millis(1));
        }
        // The child may end by itself before the signal comes; its status shows which.
        let _ = child.kill();
        let done = child.wait().expect("a dead child").success();
        kills += usize::from(!done);
        // A run that the signal reached between its last message and its end is complete as well; the files below show if it was not.
        if done || (killed.join("summary.json").exists() && summary(&killed)["status"] == "completed") {
            break;
        }
    }
    assert!(kills > 0, "the run was killed at least once");
    assert_eq!(summary(&killed)["status"], "completed");
    for same in ["snapshot_hash", "stages", "time_step_limits", "warnings"] {
        assert_eq!(summary(&killed)[same], summary(&whole)[same], "{same}");
    }
    assert!(results(&killed) == results(&whole), "every file is the same after {kills} kills");
    let (frame, written) = kept.expect("a checkpoint after the first frame");
    assert_eq!(modified(&frame), Some(written), "runs from the start write {} again", frame.display());
}

#[test]
fn a_folder_with_results_is_safe() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["stages"] = json!([{ "name": "go", "duration": 0.002 }]);
    let file = write(folder.path(), "column.json", &case);
    let out = folder.path().join("out");
    let run = |flag: Option<&str>| {
        let mut command = program();
        command.args(["run", "--quiet", "--out"]).arg(&out).arg(&file).args(flag);
        output(&mut command)
    };
    assert_eq!(run(None).0, 0);
    let (code, _, errors) = run(None);
    assert!(code == 1 && errors.contains("earlier run"), "{errors}");
    assert_eq!(run(Some("--overwrite")).0, 0);
    assert!(fs::read_to_string(out.join("frames.pvd")).unwrap().contains("timestep"));
}

/// Names of the pictures that `plot --field pressure` writes for the disks, without extension.
const PICTURES: [&str; 17] = [
    "angular_momentum.z",
    "elastic_energy",
    "kinetic_energy",
    "kinetic_energy.x",
    "kinetic_energy.y",
    "mass",
    "momentum.x",
    "momentum.y",
    "momentum.z",
    "points_per_cell.mean",
    "points_per_cell.min",
    "potential_energy",
    "pressure-00009",
    "time_step",
    "total_energy",
    "volume_ratio.max",
    "volume_ratio.min",
];

#[test]
fn templates_that_take_seconds_end_without_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["oedometer", "disks", "snowball", "grains", "dam-break", "debris-flow"] {
        let file = folder.path().join(format!("{name}.json"));
        assert_eq!(output(program().args(["new", name]).arg(&file)).0, 0);
        let out = folder.path().join(name);
        let (code, text, errors) = output(program().args(["run", "--out"]).arg(&out).arg(&file));
        assert!(
            code == 0 && !text.contains("warning") && !errors.contains("warning"),
            "{name}: {text}{errors}"
        );
    }
}

#[test]
fn templates_pass_their_check_and_the_smallest_runs_and_plots() {
    let folder = tempfile::tempdir().unwrap();
    let (code, names, _) = output(program().args(["new", "--list"]));
    assert!(code == 0 && names.lines().count() >= 4);
    for name in names.lines() {
        let file = folder.path().join(format!("{name}.json"));
        assert_eq!(output(program().args(["new", name]).arg(&file)).0, 0);
        let (code, text, errors) = output(program().arg("check").arg(&file));
        assert!(code == 0 && text.contains("time step") && text.contains("memory"), "{name}: {errors}");
        assert!(!text.contains("warning") && !errors.contains("warning"), "{name}: {text}{errors}");
        assert_eq!(output(program().args(["new", name]).arg(&file)).0, 2, "an existing file is kept");
    }
    let out = folder.path().join("out");
    let (code, _, errors) =
        output(program().args(["run", "--quiet", "--out"]).arg(&out).arg(folder.path().join("disks.json")));
    assert_eq!(code, 0, "{errors}");
    for format in ["png", "svg"] {
        let (code, _, errors) =
            output(program().args(["plot", "--field", "pressure", "--format", format]).arg(&out));
        assert_eq!(code, 0, "{errors}");
        let ending = format!(".{format}");
        let mut pictures = names_in(&out.join("plots"));
        pictures.retain(|name| name.ends_with(&ending));
        assert_eq!(pictures, PICTURES.map(|name| format!("{name}{ending}")), "{format}");
    }
    assert!(!names_in(&out).iter().any(|name| name.ends_with(".png")), "no picture among the results");
    let film = folder.path().join("film");
    let arguments =
        ["plot", "--fields", "pressure,velocity", "--frame", "all", "--range", "-10,200", "--gif", "--out"];
    let (code, said, errors) = output(program().args(arguments).arg(&film).arg(&out));
    assert!(code == 0 && said.contains("velocity.gif shows 10 of 10 frames"), "{said} {errors}");
    let names = names_in(&film);
    let count = |begin: &str| names.iter().filter(|name| name.starts_with(begin)).count();
    assert_eq!((count("pressure"), count("velocity")), (11, 11), "{names:?}");
    assert_eq!(fs::read(film.join("pressure.gif")).unwrap()[..6], *b"GIF89a");
    for wrong in ["200,-10", "1", "a,b", "0,inf"] {
        let (code, _, errors) = output(program().args(["plot", "--range", wrong]).arg(&out));
        assert!(code == 2 && errors.contains("--range"), "{wrong}: {errors}");
    }
    assert_eq!(output(program().args(["plot", "--frame", "999"]).arg(&out)).0, 2);
    assert_eq!(output(program().args(["plot", "--field", "colour"]).arg(&out)).0, 2);
    let (code, _, errors) = output(program().arg("plot").arg(folder.path().join("nowhere")));
    assert!(
        code == 2 && errors.contains("nowhere: contains no run (summary.json is missing)"),
        "{code} {errors}"
    );
}

#[test]
fn what_lies_on_nodes_is_drawn_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["stages"] = json!([{ "name": "hold", "duration": 0.01 }]);
    case["output"]["grid"] = json!(0.02);
    let file = write(folder.path(), "column.json", &case);
    let out = folder.path().join("out");
    assert_eq!(output(program().args(["run", "--quiet", "--out"]).arg(&out).arg(&file)).0, 0);
    let draw = |dataset: &str, field: &str| {
        output(program().args(["plot", "--dataset", dataset, "--field", field]).arg(&out))
    };
    let (code, _, errors) = draw("grid", "density");
    assert_eq!(code, 0, "{errors}");
    assert!(names_in(&out.join("plots")).contains(&"grid-density-00001.png".to_owned()));
    let (code, _, errors) = draw("grid", "colour");
    assert!(code == 2 && errors.contains("density"), "{errors}");
    let (code, _, errors) = draw("contacts", "force");
    assert!(
        code == 2
            && errors.contains("--dataset contacts: is not a dataset of the run; there are grid, points"),
        "{errors}"
    );
}

#[test]
fn a_report_needs_no_other_file_and_has_all_that_a_run_left() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["title"] = json!("a <small> column & its fall");
    case["methods"]["mpm"]["courant"] = json!(0.31);
    let file = write(folder.path(), "column.json", &case);
    let out = folder.path().join("out");
    assert_eq!(output(program().args(["run", "--quiet", "--out"]).arg(&out).arg(&file)).0, 0);
    let (code, said, errors) = output(program().args(["report", "--frames", "3"]).arg(&out));
    assert_eq!(code, 0, "{errors}");
    assert!(said.contains("report.html"), "{said}");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("<h1>a &lt;small&gt; column &amp; its fall</h1>"));
    // Two fields of three frames; the other pictures and the animation script are in the page itself.
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 6);
    assert_eq!(page.matches("src=").count(), 6);
    assert!(!page.contains("href=") && page.matches("<script").count() == 2);
    assert!(page.contains("<div class=\"player\">"));
    let summary = summary(&out);
    let stage = |number: usize, key: &str| summary["stages"][number][key].clone();
    assert_eq!((stage(0, "name"), stage(0, "ended")), (json!("hold"), json!("duration over")));
    assert!((stage(0, "end").as_f64().unwrap() - 0.02).abs() < 1e-9 && stage(1, "start") == stage(0, "end"));
    let limits = summary["time_step_limits"].as_array().unwrap();
    let counted: u64 = limits.iter().map(|limit| limit["steps"].as_u64().unwrap()).sum();
    assert_eq!(counted, summary["steps"].as_u64().unwrap());
    let wanted = [
        "Completed.",
        "duration over",
        "elastic wave",
        summary["snapshot_hash"].as_str().unwrap(),
        "materials.sand.friction_angle</td><td>31",
        "methods.mpm.courant</td><td>0.31",
        "boundaries[2].wall.friction_coefficient</td><td>0.6",
        "sum of the energies (J)",
        "<figcaption>front</figcaption>",
        "<figcaption>surface</figcaption>",
        "velocity, frame 6",
    ];
    for wanted in wanted {
        assert!(page.contains(wanted), "{wanted}");
    }
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
    // Measures of the case come before energies, and those before the data on progress.
    let order = [
        "<figcaption>front",
        "<figcaption>surface",
        "<figcaption>potential energy",
        "<figcaption>time step",
        "Hash of the",
    ];
    assert!(order.map(place).is_sorted(), "{:?}", order.map(place));
    assert!(!page.contains("Incomplete") && !page.contains("<figcaption>mass"));
    assert_eq!(output(program().args(["report", "--field", "colour"]).arg(&out)).0, 2);
    assert_eq!(output(program().arg("report").arg(folder.path())).0, 2, "contains no run");
}

#[test]
fn an_export_has_every_frame_and_table_to_the_last_bit() {
    use colluvium::case::output::{NpzValues, Table, read_frame, read_npz};
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "column.json", &column());
    let out = folder.path().join("out");
    assert_eq!(output(program().args(["run", "--quiet", "--out"]).arg(&out).arg(&file)).0, 0);
    let archives = out.join("npz");
    let (code, said, errors) = output(program().arg("export").arg(&out));
    assert_eq!(code, 0, "{errors}");
    let mut wanted = vec!["derived.txt".to_owned()];
    wanted.extend((0..7).map(|number| format!("frame-{number:05}.npz")));
    wanted.extend(["measures.npz", "profile-surface.npz"].map(str::to_owned));
    assert_eq!(names_in(&archives), wanted);
    assert!(said.starts_with("wrote 9 archives"), "{said}");
    let arrays = |name: &str| read_npz(&archives.join(name)).unwrap();
    let frame = read_frame(&out.join("frames/frame-00003.vtu"), 0.06).unwrap();
    let last = arrays("frame-00003.npz");
    let values = |name: &str| &last.iter().find(|array| array.name == name).unwrap().values;
    assert_eq!(*values("position"), NpzValues::Float(frame.positions.as_flattened().to_vec()));
    assert_eq!(
        *values("velocity"),
        NpzValues::Float(frame.vectors("velocity").unwrap().as_flattened().to_vec())
    );
    let table = Table::read(&out.join("measures.csv")).unwrap();
    let columns = arrays("measures.npz");
    let numbers = columns.iter().filter(|array| !array.name.ends_with(".mask")).count();
    assert_eq!(numbers, table.columns.len());
    assert_eq!(columns[0].values, NpzValues::Float(table.column("time").unwrap()));
    assert_eq!(output(program().arg("export").arg(folder.path())).0, 2, "contains no run");
}

#[test]
fn a_report_says_that_a_run_is_incomplete() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["stages"][1] =
        json!({ "name": "rest", "duration": 0.02, "equilibrium": { "unbalanced_force": 1e-12 } });
    let file = write(folder.path(), "column.json", &case);
    let out = folder.path().join("out");
    let (code, _, errors) = output(program().args(["run", "--quiet", "--out"]).arg(&out).arg(&file));
    assert_eq!(code, 1, "{errors}");
    let page = || {
        let (code, _, errors) = output(program().arg("report").arg(&out));
        assert_eq!(code, 0, "{errors}");
        fs::read_to_string(out.join("report.html")).unwrap()
    };
    let failed = page();
    assert!(failed.contains("Incomplete. The run failed.") && failed.contains("no equilibrium within"));
    assert!(failed.contains("not ended") && failed.contains("In the last row"));
    // Summary of a run that was killed, and of one that was killed before its first row.
    fs::write(out.join("summary.json"), r#"{ "status": "running", "method": "mpm" }"#).unwrap();
    let killed = page();
    assert!(killed.contains("was killed before its end") && killed.contains("materials.sand.friction_angle"));
    for file in ["measures.csv", "frames.pvd", "profile-surface.csv"] {
        fs::remove_file(out.join(file)).unwrap();
    }
    assert!(page().contains("No results yet."));
}

#[test]
fn a_sweep_tells_of_each_run_and_leaves_one_table() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["stages"] = json!([{ "name": "go", "duration": 0.02 }]);
    write(folder.path(), "column.json", &case);
    let mut sweep = json!({
        "title": "cells", "case": "column.json",
        "parameters": { "cell": { "at": ["methods.mpm.cell_size"], "values": [0.02, 0.01, 0.005] } },
        "convergence": { "parameter": "cell", "measures": ["front"] },
        "targets": { "front": { "value": 0.1, "tolerance": 0.01 } }
    });
    let file = write(folder.path(), "sweep.json", &sweep);
    let out = folder.path().join("out");
    let (code, said, errors) = output(program().arg("sweep").arg(&file).arg("--out").arg(&out));
    assert_eq!(code, 0, "{errors}");
    for line in
        ["run 2 (cell = 0.01): completed", "nearest to the targets: run ", "front: ", "3 of 3 runs complete"]
    {
        assert!(said.contains(line), "{line:?} in {said}");
    }
    assert_eq!(fs::read_to_string(out.join("runs.csv")).unwrap().lines().count(), 4);
    assert_eq!(fs::read_to_string(out.join("convergence.csv")).unwrap().lines().count(), 4);
    let again = ["sweep", "--quiet", "--resume", "--out"];
    let (code, said, errors) = output(program().args(again).arg(&out).arg(&file));
    assert_eq!((code, said.as_str()), (0, ""), "{errors}");

    sweep["parameters"]["cell"]["values"] = json!([0.02, 0.01, 0.03]);
    let file = write(folder.path(), "sweep.json", &sweep);
    let (code, _, errors) = output(program().arg("sweep").arg("--check").arg(&file));
    assert_eq!(code, 3);
    assert!(errors.starts_with("error: run 3 (cell = 0.03): methods.mpm.cell_size: "), "{errors}");
}

#[test]
fn the_schema_is_json_and_knows_the_methods() {
    let (code, text, _) = output(program().arg("schema"));
    let schema: Value = serde_json::from_str(&text).unwrap();
    assert!(
        code == 0
            && schema["properties"]["methods"]["properties"]["mpm"]["properties"]["cell_size"].is_object()
    );
    let (code, text, _) = output(program().args(["schema", "--markdown"]));
    assert!(code == 0 && text.starts_with("# Case file") && text.contains("`friction_angle`"));
}

/// Sorted names in a folder.
fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Last value of a column of `path.csv`.
fn last(out: &Path, column: &str) -> f64 {
    let table = fs::read_to_string(out.join("path.csv")).expect("a table");
    let mut columns = table.lines().nth(1).expect("a head").split(',');
    let index = columns.position(|c| c.split(" (").next() == Some(column)).expect("the column");
    let row = table.lines().last().expect("a row");
    row.split(',').nth(index).expect("a value").parse().expect("a number")
}

fn triaxial(path: &Value) -> Value {
    json!({
        "title": "triaxial",
        "material": { "model": "drucker-prager", "density": 1600, "youngs_modulus": 2e7, "poissons_ratio": 0.3, "friction_angle": 30 },
        "initial_stress": [-1e5, -1e5, -1e5, 0, 0, 0],
        "stages": [{ "path": path, "steps": 100 }]
    })
}

#[test]
fn an_element_test_leaves_a_table_and_four_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let drained = triaxial(&json!({ "kind": "triaxial-drained", "axial_compression": 0.05 }));
    let file = write(folder.path(), "triaxial.json", &drained);
    let out = folder.path().join("out");
    let (code, _, errors) = output(program().arg("element-test").arg(&file).arg("--out").arg(&out));
    assert_eq!(code, 0, "{errors}");
    assert_eq!(
        names_in(&out),
        ["path.csv", "q-p.png", "q-strain.png", "volume-ln-p.png", "volume-strain.png"]
    );
    // Cohesionless, matched in triaxial compression: q = σ₃ (k - 1) = 200 kPa.
    assert!((last(&out, "q") / 2e5 - 1.0).abs() < 1e-6, "{}", last(&out, "q"));
    // Into the same folder: no result of the drained test remains.
    let undrained = triaxial(&json!({ "kind": "triaxial-undrained", "axial_compression": 0.05 }));
    let file = write(folder.path(), "undrained.json", &undrained);
    let mut command = program();
    let (code, _, errors) =
        output(command.arg("element-test").arg(&file).arg("--out").arg(&out).args(["--format", "svg"]));
    assert_eq!(code, 0, "{errors}");
    assert_eq!(
        names_in(&out),
        ["path.csv", "pore-pressure-strain.svg", "q-p.svg", "q-strain.svg", "volume-ln-p.svg"]
    );
    assert!(fs::read_to_string(out.join("q-p.svg")).unwrap().contains("yield surface"));
    // Files that no element test wrote remain.
    for foreign in ["path.csv", "q-p.png"] {
        let other = folder.path().join(foreign.replace('.', "-"));
        fs::create_dir(&other).unwrap();
        fs::write(other.join(foreign), "mine").unwrap();
        let (code, _, errors) = output(program().arg("element-test").arg(&file).arg("--out").arg(&other));
        assert!(code == 1 && errors.contains(foreign) && errors.contains("--out"), "{code}: {errors}");
        assert_eq!(fs::read_to_string(other.join(foreign)).unwrap(), "mine");
        assert_eq!(names_in(&other), [foreign]);
    }
}

#[test]
fn broken_element_tests_end_with_code_3_and_the_path_of_every_mistake() {
    let folder = tempfile::tempdir().unwrap();
    let breakages: Vec<(&str, &str, Value)> = vec![
        ("/title", "title", json!(1)),
        ("/initial_stress", "initial_stress", json!([1, 2, 3])),
        ("/initial_stress/2", "initial_stress", json!(-9e9)),
        ("/material/friction_angle", "material.friction_angle", json!(95)),
        ("/material/friction", "material.friction", json!(95)),
        ("/stages", "stages", json!([])),
        ("/stages/0/steps", "stages[0].steps", json!(0)),
        ("/stages/0/steps", "stages[0].steps", json!(-5)),
        ("/stages/0/duration", "stages[0].duration", json!(0)),
        ("/stages/0/path/kind", "stages[0].path.kind", json!("triaxal")),
        ("/stages/0/path/b", "stages[0].path.b", json!(1.5)),
        ("/stages/0/path/axial_compression", "stages[0].path", json!(1e3)),
        ("/stages/0/path", "stages[0].path", json!({ "kind": "reversal" })),
    ];
    for (number, (pointer, path, value)) in breakages.into_iter().enumerate() {
        let mut test = triaxial(&json!({ "kind": "true-triaxial", "axial_compression": 0.05, "b": 0.2 }));
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match test.pointer_mut(parent).unwrap() {
            Value::Object(map) => {
                map.insert(key.to_owned(), value);
            }
            other => other[key.parse::<usize>().unwrap()] = value,
        }
        let file = write(folder.path(), &format!("broken-{number}.json"), &test);
        let out = folder.path().join(format!("out-{number}"));
        let (code, _, errors) = output(program().arg("element-test").arg(&file).arg("--out").arg(&out));
        assert_eq!(code, 3, "{pointer}: {errors}");
        let first = errors.lines().next().unwrap_or_default();
        assert!(first.starts_with(&format!("error: {path}: ")), "{pointer}: {first}");
        assert!(!out.exists(), "{pointer}: a broken test leaves nothing");
    }
}

#[test]
fn a_limit_load_leaves_what_came_before_and_ends_with_code_1() {
    let folder = tempfile::tempdir().unwrap();
    let push = triaxial(&json!({ "kind": "stress", "increment": [0, 0, -3e5, 0, 0, 0] }));
    let file = write(folder.path(), "push.json", &push);
    let out = folder.path().join("out");
    let (code, _, errors) = output(program().arg("element-test").arg(&file).arg("--out").arg(&out));
    assert_eq!(code, 1, "{errors}");
    assert!(errors.starts_with("error: stages[0].path: limit load reached in step 66"), "{errors}");
    assert!((last(&out, "q") / 2e5 - 1.0).abs() < 1e-4, "{}", last(&out, "q"));
    assert_eq!(names_in(&out).len(), 5);
}

#[test]
fn a_folder_of_an_incremental_driver_is_an_element_test() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    put("parameters.inp", "Elastic\n2\n2.0d4\n0.3\n");
    put("initialconditions.inp", "6\n-100\n-100\n-100\n0\n0\n0\n1\n0.0\n");
    put("test.inp", "out.txt # triaxial\n*TriaxialE1\n100 10 1.0 : 10\n-0.01\n*End\n");
    let material =
        json!({ "model": "linear-elastic", "density": 1600, "youngs_modulus": 2e7, "poissons_ratio": 0.3 });
    let law = write(folder.path(), "law.json", &material);
    let out = folder.path().join("out");
    let run = |law: &Path| {
        let mut command = program();
        command.arg("element-test").arg(folder.path()).args(["--stress-unit", "kPa", "--material"]).arg(law);
        output(command.arg("--out").arg(&out))
    };
    let (code, text, errors) = run(&law);
    assert_eq!(code, 0, "{errors}");
    assert!(text.starts_with("12 rows"), "{text}");
    assert!(errors.starts_with("warning: parameters.inp: "), "{errors}");
    assert!((last(&out, "q") / 2e5 - 1.0).abs() < 1e-9, "{}", last(&out, "q"));
    put("test.inp", "out.txt\n*TriaxialE9\n100 10 1.0\n-0.01\n");
    let (code, _, errors) = run(&law);
    let place = folder.path().join("test.inp:2");
    assert!(
        code == 3 && errors.starts_with(&format!("error: {}: \"*TriaxialE9\" ", place.display())),
        "{errors}"
    );
    for (key, value) in
        [("youngs_modulus", json!(-1)), ("youngs_modulus", json!("soft")), ("stiffness", json!(1))]
    {
        let mut wrong = material.clone();
        wrong[key] = value;
        put("test.inp", "out.txt\n*TriaxialE1\n100 10 1.0\n-0.01\n");
        let wrong = write(folder.path(), "wrong.json", &wrong);
        let (code, _, errors) = run(&wrong);
        let place = format!("error: {}: {key}: ", wrong.display());
        assert!(code == 3 && errors.starts_with(&place), "{errors}");
    }
    let (code, ..) = output(program().arg("element-test").arg(folder.path()));
    assert_eq!(code, 2, "a folder needs a law");
    let (code, ..) = output(program().arg("element-test").arg(&law).arg("--material").arg(&law));
    assert_eq!(code, 2, "a test file has its own law");
}
