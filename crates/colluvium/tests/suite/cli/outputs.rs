//! Templates, pictures, reports and exports.

use std::fs;
use std::path::PathBuf;

use colluvium::TemplateKind;
use colluvium::case::Case;
use serde_json::json;

use super::{column, names_in, summary, write};
use crate::{output, program};

/// Names of the pictures that `plot --field pressure` writes for the disks, without extension.
const PICTURES: [&str; 13] = [
    "angular_momentum.z",
    "elastic_energy",
    "kinetic_energy",
    "kinetic_energy.x",
    "kinetic_energy.y",
    "momentum.x",
    "momentum.y",
    "points_per_cell.mean",
    "points_per_cell.min",
    "pressure-00009",
    "total_energy",
    "volume_ratio.max",
    "volume_ratio.min",
];

#[test]
fn short_templates_run_without_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["oedometer", "disks", "snowball", "two-grains", "heap-on-plane", "debris-flow"] {
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
fn templates_are_listed_and_pass_their_check() {
    let folder = tempfile::tempdir().unwrap();
    let (code, list, _) = output(program().arg("new"));
    assert_eq!((code, &list), (0, &output(program().args(["new", "--list"])).1));
    for template in colluvium::TEMPLATES {
        let name = template.name;
        assert!(list.contains(&format!("  {name} ")) && list.contains(template.topic), "{list}");
        let picture = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(template.picture());
        assert!(list.contains(&template.picture()) && picture.is_file(), "{}", picture.display());
        let own = folder.path().join(name);
        fs::create_dir(&own).unwrap();
        let file = own.join(format!("{name}.json"));
        assert_eq!(output(program().args(["new", name]).arg(&file)).0, 0);
        assert_eq!(output(program().args(["new", name]).arg(&file)).0, 2, "an existing file is kept");
        let checks: Vec<Vec<&str>> = match template.kind {
            TemplateKind::Case => {
                let methods = &Case::from_file(&file).unwrap().methods;
                let method = |name: &String| colluvium::method(name).unwrap().name();
                methods.keys().map(|name| vec!["check", "--method", method(name)]).collect()
            }
            TemplateKind::ElementTest => vec![vec!["element-test"]],
            TemplateKind::ForeignLaw => {
                let (code, _, errors) = output(program().arg("element-test").arg(&file).current_dir(&own));
                assert!(code == 3 && errors.contains("--allow-library"), "{name}: {errors}");
                Vec::new()
            }
            TemplateKind::Sweep => vec![vec!["sweep", "--check"]],
            TemplateKind::Fit => vec![vec!["fit", "--check"], vec!["fit"]],
        };
        for arguments in checks {
            let (code, text, errors) = output(program().args(&arguments).arg(&file).current_dir(&own));
            assert_eq!(code, 0, "{name}: {errors}");
            assert!(!text.contains("warning") && !errors.contains("warning"), "{name}: {text}{errors}");
            let is_plan = text.contains("time step") && text.contains("memory");
            assert!(is_plan || template.kind != TemplateKind::Case, "{name}: {text}");
        }
    }
}

#[test]
fn the_smallest_template_runs_and_plots() {
    let folder = tempfile::tempdir().unwrap();
    let disks = folder.path().join("disks.json");
    assert_eq!(output(program().args(["new", "disks"]).arg(&disks)).0, 0);
    let out = folder.path().join("out");
    let (code, _, errors) = output(program().args(["run", "--quiet", "--out"]).arg(&out).arg(disks));
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
fn plot_draws_datasets_on_nodes_by_name() {
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
fn a_report_is_self_contained_and_complete() {
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
fn an_export_has_every_frame_and_table_bit_identically() {
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
fn the_report_of_an_incomplete_run_states_its_reason() {
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
