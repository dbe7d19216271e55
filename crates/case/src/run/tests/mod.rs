mod events;
mod overwrite;
mod resume;
mod summary;
mod taken;

use std::io::{Read, Write};

use colluvium_constitutive::SymTensor;

use super::*;
use crate::description::{Reset, Stage};
use crate::output::Collection;
use crate::run::output::run_folder::lock;
use crate::run::run_loop::SUMMARY_INTERVAL;
use crate::solver::{restore_value, save_value};
use crate::{
    Advance, Dataset, DatasetGeometry, Equilibrium, Field, FieldData, Frame, FrameRequest, Lattice,
    SolverError, StepLimit, TimeStep,
};

/// Independent oscillators `x'' = -ω² x - 2 d x'`, one per point.
struct Oscillators {
    state: Vec<[f64; 2]>,
    time: f64,
    steps: u64,
    damping: f64,
    /// Stable step (s).
    dt: f64,
    /// Time at which the stable step decreases, and the remaining share of it.
    stiffening: Option<(f64, f64)>,
    fail_at: Option<f64>,
    /// Whether the solver ends the whole program at its failure, and pauses before.
    exits_on_failure: bool,
    /// Whether frames have their masses at the nodes of a line instead of points.
    on_nodes: bool,
}

impl Oscillators {
    /// Time at which a solver that ends the program pauses (s).
    const NAP: f64 = 0.98;

    fn new(damping: f64, fail_at: Option<f64>) -> Self {
        let state = (0..5).map(|i| [1.0 + f64::from(i), 0.0]).collect();
        Self {
            state,
            time: 0.0,
            steps: 0,
            damping,
            dt: 0.0137,
            stiffening: None,
            fail_at,
            exits_on_failure: false,
            on_nodes: false,
        }
    }

    fn boxed(damping: f64, fail_at: Option<f64>) -> Box<dyn Solver> {
        Box::new(Self::new(damping, fail_at))
    }

    /// Oscillators at rest, with another stable step (s).
    fn at_rest(dt: f64) -> Box<dyn Solver> {
        Box::new(Self { state: vec![[0.0; 2]; 5], dt, ..Self::new(0.0, None) })
    }
}

impl Solver for Oscillators {
    fn time(&self) -> f64 {
        self.time
    }
    fn step_count(&self) -> u64 {
        self.steps
    }
    fn point_count(&self) -> usize {
        self.state.len()
    }
    fn limit(&mut self) -> TimeStep {
        match self.stiffening {
            Some((at, share)) if self.time >= at => TimeStep {
                dt: share * self.dt,
                limit: StepLimit::ELASTIC_WAVE,
                point: Some(3),
                position: [1.0, 2.0, 0.0],
            },
            _ => TimeStep { dt: self.dt, limit: StepLimit::FIXED_STEP, point: None, position: [0.0; 3] },
        }
    }
    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.limit();
        let dt = limit.limited_to(at_most);
        if self.fail_at.is_some_and(|at| self.time >= at) {
            assert!(!self.exits_on_failure, "killed");
            let reason = "it was told to".into();
            return Err(SolverError::Point {
                step: self.steps,
                time: self.time,
                point: 3,
                position: [1.0; 3],
                reason,
            });
        }
        if self.exits_on_failure && self.time < Self::NAP && self.time + dt >= Self::NAP {
            std::thread::sleep(SUMMARY_INTERVAL);
        }
        for [x, v] in &mut self.state {
            *v -= dt * (9.0 * *x + 2.0 * self.damping * *v);
            *x += dt * *v;
        }
        self.time += dt;
        self.steps += 1;
        Ok(Advance { dt, limit: limit.limit })
    }
    fn begin_stage(&mut self, _stage: usize, _start: f64) -> Result<(), SolverError> {
        Ok(())
    }
    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        if stage.reset.contains(&Reset::Velocity) {
            self.state.iter_mut().for_each(|s| s[1] = 0.0);
        }
        Ok(())
    }
    fn equilibrium(&self) -> Option<Equilibrium> {
        let worst = self.state.iter().map(|[x, v]| x.abs().max(v.abs())).fold(0.0, f64::max);
        Some(Equilibrium { unbalanced_force: worst, kinetic_ratio: worst, kinetic: worst })
    }
    fn frame(&self, _: FrameRequest<'_>) -> Frame {
        let count = self.state.len();
        if self.on_nodes {
            let nodes = Lattice { low: [1.0, 0.0, 0.0], spacing: 1.0, count: [count, 1, 1] };
            let mask = (0..count).map(|node| node + 1 < count).collect();
            let mass = Field { name: "mass".into(), unit: "kg", data: FieldData::Scalar(vec![1.0; count]) };
            let support = DatasetGeometry::Lattice { nodes, mask };
            let datasets = vec![Dataset { name: "fluid".into(), geometry: support, fields: vec![mass] }];
            return Frame { time: self.time, step: self.steps, datasets };
        }
        Frame::from(Snapshot {
            time: self.time,
            step: self.steps,
            ids: (0..count as u64).collect(),
            bodies: vec![0; count],
            positions: self.state.iter().map(|[x, _]| [*x, 0.0, 0.0]).collect(),
            extents: vec![[0.1; 3]; count],
            fields: vec![
                Field { name: "mass".into(), unit: "kg", data: FieldData::Scalar(vec![1.0; count]) },
                Field {
                    name: "stress".into(),
                    unit: "Pa",
                    data: FieldData::Tensor(vec![SymTensor::ZERO; count]),
                },
            ],
        })
    }
    fn budget(&self) -> Option<Budget> {
        Some(Budget { kinetic: self.state.iter().map(|[_, v]| 0.5 * v * v).sum(), ..Budget::default() })
    }
    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        save_value(&(&self.state, self.time, self.steps), out)
    }
    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        (self.state, self.time, self.steps) = restore_value(input)?;
        Ok(())
    }
}

fn case(stages: &str) -> Case {
    let text = format!(
        r#"{{
        "title": "oscillators", "space": "plane-strain",
        "domain": {{ "min": [-10, -1], "max": [10, 1] }}, "gravity": [0, 0],
        "materials": {{ "m": {{ "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 }} }},
        "bodies": [ {{ "name": "b", "material": "m", "shape": {{ "kind": "box", "min": [0, 0], "max": [1, 1] }} }} ],
        "stages": {stages},
        "measures": {{
            "head": {{ "kind": "front", "side": "x-max", "quantile": 0.9 }},
            "top": {{ "kind": "profile", "axis": 0, "height": 1, "bin": 0.5 }}
        }},
        "output": {{ "frames": 0.5, "measures": 0.1, "checkpoint": 1e-9 }}
    }}"#
    );
    Case::from_json(&text).unwrap()
}

fn options(out: &std::path::Path) -> RunOptions {
    RunOptions { method: "test".into(), output_folder: Some(out.to_owned()), ..RunOptions::default() }
}

/// Files of a run, without the wall-clock times, which may differ.
fn output_files(folder: &std::path::Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for place in [folder.to_owned(), folder.join("frames")] {
        for entry in std::fs::read_dir(place).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_file() && name != "summary.json" {
                files.push((name, std::fs::read(path).unwrap()));
            }
        }
    }
    files.sort();
    files
}

#[test]
fn rows_and_frames_are_written_at_their_intervals() {
    let case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    let options = RunOptions { keep_frames: true, ..RunOptions::default() };
    let report = run(&case, Oscillators::boxed(0.0, None), &options).unwrap();
    let times = report.table.column("time").unwrap();
    assert_eq!(times.len(), 21);
    for (row, time) in times.iter().enumerate() {
        assert!((time - 0.1 * row as f64).abs() < 1e-12, "row {row} at {time}");
    }
    let frames: Vec<f64> = report.frames.iter().map(|f| f.time).collect();
    assert_eq!(frames.len(), 5);
    assert!(frames.iter().enumerate().all(|(k, t)| (t - 0.5 * k as f64).abs() < 1e-12));
    assert!(report.table.column("head").unwrap()[0] > 4.9);
}

#[test]
fn datasets_on_nodes_are_measured_and_stored_like_points() {
    let mut case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    let probe = r#"{ "kind": "probe", "position": [2.2, 0], "radius": 0.5, "fields": ["mass"] }"#;
    case.measures.insert("at".into(), serde_json::from_str(probe).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let options = RunOptions { keep_frames: true, ..options(&out) };
    let solver = Oscillators { on_nodes: true, ..Oscillators::new(0.0, None) };
    let report = run(&case, Box::new(solver), &options).unwrap();
    // The last node has no mass: the front is that of the fourth.
    let head = report.table.column("head").unwrap();
    assert!(head.iter().all(|x| (3.0..=4.5).contains(x)), "{head:?}");
    assert_eq!(report.table.column("at.mass"), Some(vec![1.0; 21]));
    assert_eq!(Table::read(&out.join("profile-top.csv")).unwrap().rows.len(), 5 * 4);
    let files = Collection::read(&out.join("frames.pvd")).unwrap().frames;
    assert_eq!(files[4].1, "frames/fluid-00004.vtr");
    assert_eq!(report.frames[4].positions, [1.0, 2.0, 3.0, 4.0].map(|x| [x, 0.0, 0.0]));
    let read = crate::output::read_frame(&out.join(&files[4].1), files[4].0).unwrap();
    assert_eq!(read.positions, report.frames[4].positions);
}

#[test]
fn default_measure_rows_do_not_shorten_steps() {
    let mut case = case(r#"[ { "name": "a", "duration": 1.3 }, { "name": "b", "duration": 0.7 } ]"#);
    (case.output.measures, case.output.frames) = (None, None);
    let steps = |dt: f64, case: &Case| {
        let report = run(case, Oscillators::at_rest(dt), &RunOptions::default()).unwrap();
        (report.steps, report.table.column("time").unwrap())
    };
    // Steps shorter and longer than a hundredth of the run; the last two steps of a stage are equal.
    for (dt, smallest, rows) in
        [(0.0137, 95 + 52, 101), (0.003, 434 + 234, 101), (0.1, 13 + 7, 21), (10.0, 2, 3)]
    {
        let (steps, times) = steps(dt, &case);
        assert_eq!((steps, times.len()), (smallest, if rows == 101 { times.len() } else { rows }), "{dt} s");
        if rows == 101 {
            assert!((98..=102).contains(&times.len()), "{dt} s: {} rows", times.len());
        }
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]) && times.last() == Some(&2.0), "{times:?}");
        let late = |(row, time): (usize, &f64)| time - 0.02 * row as f64;
        let latest = times.iter().enumerate().map(late).fold(0.0, f64::max);
        assert!(dt > 0.02 || latest < dt, "{dt} s: a row is {latest} s late");
    }
    // Frames are at their times, and so are rows with an interval.
    case.output.frames = Some(0.5);
    let options = RunOptions { keep_frames: true, ..RunOptions::default() };
    let report = run(&case, Oscillators::boxed(0.0, None), &options).unwrap();
    let frames: Vec<f64> = report.frames.iter().map(|frame| frame.time).collect();
    assert!(frames.len() == 5 && frames.iter().enumerate().all(|(k, t)| (t - 0.5 * k as f64).abs() < 1e-12));
    case.output.measures = Some(0.02);
    assert!(steps(0.0137, &case).0 >= 200, "two steps a row");
}

#[test]
fn a_stable_step_longer_than_the_run_does_not_end_it_early() {
    let case = case(r#"[ { "name": "a", "duration": 0.35 }, { "name": "b", "duration": 0.65 } ]"#);
    for dt in [1.0, 1e9, 1e200] {
        let report = run(&case, Oscillators::at_rest(dt), &RunOptions::default()).unwrap();
        assert_eq!(
            (report.steps, report.table.rows.len()),
            (11, 11),
            "a step to each row and end of a stage"
        );
        assert!((report.snapshot.time - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_run_without_moving_material_fails_and_the_error_names_the_stage() {
    let case = case(r#"[ { "name": "dig", "duration": 1 } ]"#);
    let error = run(&case, Oscillators::at_rest(f64::INFINITY), &RunOptions::default()).unwrap_err();
    let problem = "stage \"dig\", t = 0 s: no material is left that moves: all bodies are removed, are rigid or have left the domain; ";
    assert!(error.to_string().starts_with(problem), "{error}");
}

#[test]
fn names_checked_by_the_solver_are_refused_before_files_are_written() {
    let probe = |field: &str| serde_json::json!({ "kind": "probe", "position": [0, 0], "radius": 1, "fields": ["mass", field] });
    let front = serde_json::json!({ "kind": "front", "side": "x-max" });
    for (change, path, words) in [
        (("fields", serde_json::json!(["mass", "strss"])), "output.fields[1]", "did you mean \"stress\"?"),
        (("fields", serde_json::json!(["heat"])), "output.fields[0]", "there are mass, stress, id"),
        (("eye", probe("strss")), "measures.eye.fields[1]", "did you mean \"stress\"?"),
        (("mass", front.clone()), "measures.mass", "the column \"mass\" exists in every run"),
        (("kinetic_ratio", front), "measures.kinetic_ratio", "exists in every run"),
    ] {
        let mut value: serde_json::Value =
            serde_json::from_str(&case(r#"[ { "name": "all", "duration": 1 } ]"#).to_json()).unwrap();
        let place = if change.0 == "fields" { "output" } else { "measures" };
        value[place][change.0] = change.1;
        let wrong = Case::from_json(&value.to_string()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let error = run(&wrong, Oscillators::boxed(0.0, None), &options(folder.path())).unwrap_err();
        assert!(matches!(error, RunError::Case(_)));
        let error = error.to_string();
        assert!(error.starts_with(&format!("{path}: ")) && error.contains(words), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{path}");
    }
    let mut sound = case(r#"[ { "name": "all", "duration": 0.1 } ]"#);
    sound.output.fields = Some(["stress", "id", "extent"].map(str::to_owned).into());
    run(&sound, Oscillators::boxed(0.0, None), &RunOptions::default()).unwrap();
}

#[test]
fn a_stage_ends_at_rest_and_the_next_begins() {
    let case = case(
        r#"[ { "name": "settle", "duration": 100.0, "equilibrium": { "hold": 2 }, "reset": ["velocity"] },
             { "name": "go", "duration": 1.0 } ]"#,
    );
    let report = run(&case, Oscillators::boxed(1.0, None), &RunOptions::default()).unwrap();
    let end = report.snapshot.time;
    assert!(end > 4.0 && end < 20.0, "settling takes about ln(1500) s, the run ended at {end} s");
}

/// Oscillators with a load that grows over 8 s, starting with `stage`. With a damping of 3 they rest after 4 s.
fn loaded_oscillators(stages: &str, stage: Option<&str>) -> Case {
    let mut case = case(stages);
    let load = serde_json::json!({ "kind": "traction", "body": "b", "side": "y-max", "value": [0, -1], "ramp": 8,
                                   "stage": stage });
    case.loads = vec![serde_json::from_value(load).unwrap()];
    case
}

/// Time between the equilibrium checks of the oscillators (s).
const CHECKS: f64 = 1.4;

#[test]
fn no_stage_is_at_rest_before_its_loads_have_grown() {
    let stages = r#"[ { "name": "wait", "duration": 3 }, { "name": "settle", "duration": 40, "equilibrium": { "hold": 1 } },
                      { "name": "last", "duration": 1 } ]"#;
    for (stage, rest) in [(None, 8.0), (Some("wait"), 8.0), (Some("settle"), 11.0), (Some("last"), 3.0)] {
        let case = loaded_oscillators(stages, stage);
        let report = run(&case, Oscillators::boxed(3.0, None), &RunOptions::default()).unwrap();
        let end = report.snapshot.time - 1.0;
        assert!((rest..rest + CHECKS).contains(&end), "{stage:?}: {end} s");
    }
}

#[test]
fn no_stage_is_at_rest_before_its_motions_have_grown() {
    let mut case = case(r#"[ { "name": "settle", "duration": 40.0, "equilibrium": { "hold": 1 } } ]"#);
    let motion = serde_json::json!({ "target": "p", "velocity": [1, null], "ramp": 8 });
    case.stages[0].motions = vec![serde_json::from_value(motion).unwrap()];
    let patch = serde_json::json!({ "name": "p", "region": { "kind": "box", "min": [0, 0], "max": [1, 1] } });
    case.patches = vec![serde_json::from_value(patch).unwrap()];
    let end = run(&case, Oscillators::boxed(3.0, None), &RunOptions::default()).unwrap().snapshot.time;
    assert!((8.0..8.0 + CHECKS).contains(&end), "{end} s");
}

#[test]
fn rows_contain_the_time_step_and_the_equilibrium_ratios() {
    let case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    let report = run(&case, Oscillators::boxed(0.0, None), &RunOptions::default()).unwrap();
    let steps = report.table.column("time_step").unwrap();
    assert!(steps[0].is_nan() && steps[1..].iter().all(|dt| *dt == 0.0137), "{steps:?}");
    assert_eq!(report.table.column("kinetic_ratio"), report.table.column("unbalanced_force"));
    assert!(report.table.column("points_per_cell.min").is_none(), "the method reports none");
}

#[test]
fn a_stage_that_does_not_settle_is_an_error() {
    let case = case(r#"[ { "name": "settle", "duration": 2.0, "equilibrium": {} } ]"#);
    let error = run(&case, Oscillators::boxed(0.0, None), &RunOptions::default()).unwrap_err();
    assert!(error.to_string().starts_with("stages[0]: no equilibrium within its duration of"), "{error}");
}

#[test]
fn two_runs_do_not_write_into_one_folder() {
    let out = tempfile::tempdir().unwrap();
    let case = case(r#"[ { "name": "all", "duration": 1.0 } ]"#);
    let other = lock(out.path()).unwrap();
    let error = run(&case, Oscillators::boxed(0.0, None), &options(out.path())).unwrap_err();
    assert!(error.to_string().contains("another run is writing here"), "{error}");
    drop(other);
    run(&case, Oscillators::boxed(0.0, None), &options(out.path())).unwrap();
}

#[test]
fn a_probe_without_points_nearby_causes_a_warning() {
    let mut case = case(r#"[ { "name": "all", "duration": 0.5 } ]"#);
    for (name, x) in [("near", 0.0), ("far", 9.0)] {
        let probe =
            crate::measure::Probe { position: vec![x, 0.0], radius: 2.0, fields: vec!["mass".into()] };
        case.measures.insert(name.into(), probe.into());
    }
    let report = run(&case, Oscillators::boxed(0.1, None), &RunOptions::default()).unwrap();
    let [remark] = report.warnings_at_end.as_slice() else { panic!("{:?}", report.warnings_at_end) };
    assert_eq!(remark.code, "probe-without-points");
    assert!(remark.text.starts_with("measures.far: no point came within its radius"), "{remark}");
}

#[test]
fn a_collapse_of_the_time_step_causes_a_warning_with_its_position() {
    let case = case(r#"[ { "name": "all", "duration": 0.5 } ]"#);
    let falling = |share| {
        let stiffening = Some((0.485, share));
        Box::new(Oscillators {
            state: vec![[0.0; 2]; 5],
            dt: 0.01,
            stiffening,
            ..Oscillators::new(0.0, None)
        })
    };
    let [(little, _), (much, reported)] = [2e-3, 5e-4].map(|share| {
        let mut run =
            Run::with_solver(Arc::new(case.clone()), falling(share), RunOptions::default()).unwrap();
        let mut reported = Vec::new();
        while let Some(event) = run.advance().unwrap() {
            reported.extend(if let RunEvent::Warning(text) = event { Some(text) } else { None });
        }
        (run.finish().unwrap().warnings_at_end, reported)
    });
    assert!(little.is_empty(), "{little:?}");
    let [remark] = much.as_slice() else { panic!("{much:?}") };
    for part in ["5.000e-6 s", "1.000e-2 s", "elastic wave", "point 3", "[1.0, 2.0, 0.0] m"] {
        assert!(remark.text.contains(part), "{remark}");
    }
    assert_eq!(reported, much, "once, while it ran");
}

#[test]
fn invalid_cases_built_in_code_are_refused_before_files_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    case.stages[0].duration = f64::NAN;
    let error = run(&case, Oscillators::boxed(0.0, None), &options(folder.path())).unwrap_err();
    assert!(error.to_string().starts_with("stages[0].duration: NaN"), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_folder_with_a_run_is_overwritten_only_with_the_option() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(r#"[ { "name": "all", "duration": 0.2 } ]"#);
    let go = |options: RunOptions| run(&case, Oscillators::boxed(0.0, None), &options);
    assert!(matches!(
        go(RunOptions { resume: true, ..options(folder.path()) }),
        Err(RunError::Folder { .. })
    ));
    go(options(folder.path())).unwrap();
    assert!(matches!(go(options(folder.path())), Err(RunError::Folder { .. })));
    let before = std::fs::read(folder.path().join("summary.json")).unwrap();
    let again = go(RunOptions { resume: true, ..options(folder.path()) });
    assert!(matches!(again, Err(RunError::Folder { .. })), "a complete run is not resumed");
    assert_eq!(std::fs::read(folder.path().join("summary.json")).unwrap(), before, "nor touched");
    go(RunOptions { overwrite: true, ..options(folder.path()) }).unwrap();
}

#[test]
fn a_run_fails_when_steps_no_longer_advance_its_time() {
    // After 1e6 s a step of 1e-12 s does not change the time, and such steps do not reach the end of the stage.
    let mut case = case(r#"[ { "name": "a", "duration": 1 } ]"#);
    case.stages = vec![
        Stage { name: "long".to_owned(), duration: 1e6, ..case.stages[0].clone() },
        Stage { name: "short".to_owned(), duration: 1e-3, ..case.stages[0].clone() },
    ];
    case.output.measures = None;
    case.output.frames = None;
    let solver = Oscillators {
        state: vec![[0.0; 2]],
        dt: 1e6,
        stiffening: Some((1e6, 1e-18)),
        ..Oscillators::new(0.0, None)
    };
    let error = run(&case, Box::new(solver), &RunOptions::default()).unwrap_err();
    assert!(error.to_string().contains("cannot advance"), "{error}");
}
