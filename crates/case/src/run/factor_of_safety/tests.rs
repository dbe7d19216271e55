use std::io::{Read, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use schemars::{JsonSchema, schema_for};

use crate::description::{Axis, Stage};
use crate::run::RunEnd;
use crate::run::factor_of_safety::*;
use crate::solver::{restore_value, save_value};
use crate::{
    Advance, Budget, Capabilities, CaseError, Equilibrium, Feature, Field, Frame, FrameRequest, Plan, Solver,
    SolverError, StepLimit, TimeStep, run_method,
};

/// Driving force per mass on the block of [`Slider`] (m/s²), and its cohesion per mass in the case.
const DRIVING_FORCE: f64 = 1.0;
const STRENGTH: f64 = 1.37;
/// Kinetic energy of points that no damping removes, as in FLIP (J).
const UNDAMPED_ENERGY: f64 = 1.0;

/// Block that slides where its cohesion per mass is less than the driving force per mass.
struct Slider {
    strength: f64,
    /// Acceleration in the last step (m/s²).
    rate: f64,
    x: f64,
    v: f64,
    time: f64,
    steps: u64,
}

/// Method whose solvers are [`Slider`]s; a run of it may be interrupted.
#[derive(Default)]
struct Sliding {
    /// Number of solvers built.
    built: AtomicUsize,
    /// Number of the solver at whose build a stop is requested.
    stops_at: Option<usize>,
    stop_flag: Arc<AtomicBool>,
    /// Number of the solver whose build fails.
    refuses_at: Option<usize>,
}

#[derive(JsonSchema)]
struct EmptyState {}

impl Method for Sliding {
    fn name(&self) -> &'static str {
        "sliding"
    }
    fn summary(&self) -> &'static str {
        "a block"
    }
    fn options_schema(&self) -> schemars::Schema {
        schema_for!(EmptyState)
    }
    fn capabilities(&self, _: &Case) -> Result<Capabilities, CaseError> {
        Ok(Capabilities::for_point_methods("sliding")
            .supports(&[Feature::StagesDamping])
            .supports_all_of(&[Feature::Boundaries]))
    }
    fn plan_supported_case(&self, _: &Case) -> Result<Plan, CaseError> {
        Err(CaseError::new("", "no plan"))
    }
    fn build_supported_case(&self, case: &Case) -> Result<Box<dyn Solver>, CaseError> {
        let built = Some(self.built.fetch_add(1, Ordering::Relaxed));
        if built == self.refuses_at {
            return Err(CaseError::new("materials.clay", "refused"));
        }
        self.stop_flag.store(built == self.stops_at, Ordering::Relaxed);
        let spec = serde_json::to_value(&case.materials["clay"]).unwrap();
        let strength = spec["cohesion"].as_f64().unwrap() / 1000.0;
        Ok(Box::new(Slider { strength, rate: 0.0, x: 0.0, v: 0.0, time: 0.0, steps: 0 }))
    }
}

impl Solver for Slider {
    fn time(&self) -> f64 {
        self.time
    }
    fn step_count(&self) -> u64 {
        self.steps
    }
    fn point_count(&self) -> usize {
        1
    }
    fn limit(&mut self) -> TimeStep {
        TimeStep { dt: 0.01, limit: StepLimit::FIXED_STEP, point: None, position: [0.0; 3] }
    }
    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.limit();
        let dt = limit.limited_to(at_most);
        let before = self.v;
        self.v = (self.v + dt * (DRIVING_FORCE - self.strength)).max(0.0);
        self.rate = (self.v - before) / dt;
        self.x += dt * self.v;
        self.time += dt;
        self.steps += 1;
        Ok(Advance { dt, limit: limit.limit })
    }
    fn begin_stage(&mut self, _: usize, _: f64) -> Result<(), SolverError> {
        Ok(())
    }
    fn end_stage(&mut self, _: &Stage) -> Result<(), SolverError> {
        Ok(())
    }
    fn equilibrium(&self) -> Option<Equilibrium> {
        Some(Equilibrium {
            unbalanced_force: self.rate.abs() / DRIVING_FORCE,
            kinetic_ratio: 0.0,
            kinetic: 0.5 * self.v * self.v,
        })
    }
    fn frame(&self, _: FrameRequest<'_>) -> Frame {
        let scalar = |name: &str, unit, value| Field {
            name: name.into(),
            unit,
            data: crate::FieldData::Scalar(vec![value]),
        };
        Frame::from(Snapshot {
            time: self.time,
            step: self.steps,
            ids: vec![0],
            bodies: vec![0],
            positions: vec![[self.x, 0.0, 0.0]],
            extents: vec![[0.1; 3]],
            fields: vec![scalar("mass", "kg", 1.0), scalar("volume", "m3", 1.0)],
        })
    }
    fn budget(&self) -> Option<Budget> {
        Some(Budget { mass: 1.0, kinetic: 0.5 * self.v * self.v + UNDAMPED_ENERGY, ..Budget::default() })
    }
    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        save_value(&(self.x, self.v, self.time, self.steps), out)
    }
    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        (self.x, self.v, self.time, self.steps) = restore_value(input)?;
        Ok(())
    }
}

fn case(extra: &str) -> Case {
    let text = format!(
        r#"{{
            "title": "a block", "space": "plane-strain",
            "domain": {{ "min": [0, 0], "max": [10, 1] }}, "gravity": [0, -9.81],
            "materials": {{ "clay": {{ "model": "drucker-prager", "density": 2000, "youngs_modulus": 1e6,
                "poissons_ratio": 0.3, "friction_angle": 0, "cohesion": {}, "matching": "plane-strain" }} }},
            "bodies": [{{ "name": "block", "material": "clay", "shape": {{ "kind": "box", "min": [0, 0], "max": [1, 1] }} }}],
            {extra}
        }}"#,
        1000.0 * STRENGTH
    );
    Case::from_json(&text).unwrap()
}

fn searching(range: &str) -> Case {
    case(&format!(
        r#""stages": [{{ "name": "rest", "duration": 0.5 }}, {{ "name": "more", "duration": 0.2 }}],
           "measures": {{ "safety": {{ "kind": "factor-of-safety", "after": "rest", "duration": 10, "height": 1,
                "range": {range}, "tolerance": 0.01 }} }}"#
    ))
}

#[test]
fn the_factor_of_a_block_is_cohesion_over_driving_stress() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let options = RunOptions { output_folder: Some(out.clone()), ..RunOptions::default() };
    let report = run_method(&Sliding::default(), &searching("[1, 2]"), &options).unwrap();
    let safety = &report.safety["safety"];
    assert!(safety.stable_factor <= STRENGTH && STRENGTH <= safety.failing_factor, "{safety:?}");
    assert!(safety.failing_factor - safety.stable_factor <= 0.01);
    assert!((safety.factor().unwrap() - STRENGTH).abs() <= 0.005);
    let table = Table::read(&out.join("trials-safety.csv")).unwrap();
    assert_eq!(table.rows.len(), safety.trials.len());
    let summary: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary["factors_of_safety"]["safety"]["factor"].as_f64(), safety.factor());
    assert_eq!(report.snapshot.time, 0.7, "the run itself goes on with its stages");
}

fn status(out: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).unwrap()).unwrap()
}

/// Names and bytes of the files in a folder except the summary.
fn files(out: &Path) -> Vec<(String, Vec<u8>)> {
    let paths = std::fs::read_dir(out).unwrap().map(|entry| entry.unwrap().path());
    let kept = paths.filter(|path| path.is_file() && !path.ends_with("summary.json"));
    let mut files: Vec<_> = kept
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(path).unwrap()))
        .collect();
    files.sort();
    files
}

#[test]
fn an_interrupted_search_resumes_at_the_interrupted_trial() {
    let folder = tempfile::tempdir().unwrap();
    let options = |name: &str| RunOptions {
        method: "sliding".into(),
        output_folder: Some(folder.path().join(name)),
        ..RunOptions::default()
    };
    let case = searching("[1, 2]");
    let whole = run_method(&Sliding::default(), &case, &options("whole")).unwrap();
    let cut = Sliding { stops_at: Some(5), ..Sliding::default() };
    let report =
        run_method(&cut, &case, &RunOptions { stop_flag: Some(cut.stop_flag.clone()), ..options("cut") })
            .unwrap();
    assert_eq!((report.ending, report.safety.len()), (RunEnd::Interrupted, 0));
    let out = folder.path().join("cut");
    let summary = status(&out);
    assert_eq!(summary["status"], "interrupted");
    assert!(summary["factors_of_safety"].is_null(), "{summary}");
    let again = Sliding::default();
    let report = run_method(&again, &case, &RunOptions { resume: true, ..options("cut") }).unwrap();
    assert_eq!((report.ending, &report.safety), (RunEnd::Completed, &whole.safety));
    // The first build is that of the run, the second that of the bodies without yielding.
    let open = whole.safety["safety"].trials.len() - 3;
    assert_eq!(again.built.into_inner(), 2 + open, "trials that are done are not run again");
    let (summary, exact) = (status(&out), status(&folder.path().join("whole")));
    for key in ["status", "factors_of_safety", "snapshot_hash", "measures", "end"] {
        assert_eq!(summary[key], exact[key], "{key}");
    }
    assert_eq!(summary["status"], "completed");
    assert!(files(&out) == files(&folder.path().join("whole")));
}

#[test]
fn a_trial_that_fails_fails_the_run_which_can_be_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions {
        method: "sliding".into(),
        output_folder: Some(folder.path().to_owned()),
        ..RunOptions::default()
    };
    let case = searching("[1, 2]");
    let error =
        run_method(&Sliding { refuses_at: Some(3), ..Sliding::default() }, &case, &options).unwrap_err();
    assert_eq!(error.to_string(), "measures.safety: trial with the factor 2: materials.clay: refused");
    let summary = status(folder.path());
    assert_eq!(summary["status"], "failed");
    assert_eq!(summary["reason"].as_str(), Some(error.to_string().as_str()));
    let report = run_method(&Sliding::default(), &case, &RunOptions { resume: true, ..options }).unwrap();
    assert!(report.safety["safety"].factor().is_some());
    assert_eq!(status(folder.path())["status"], "completed");
}

#[test]
fn a_search_range_without_the_factor_yields_a_bound_and_no_factor() {
    for (range, trials, stable, failed) in [("[1.5, 2]", 1, 0.0, 1.5), ("[0.5, 1.2]", 2, 1.2, f64::INFINITY)]
    {
        let report = run_method(&Sliding::default(), &searching(range), &RunOptions::default()).unwrap();
        let safety = &report.safety["safety"];
        assert_eq!(
            (safety.trials.len(), safety.stable_factor, safety.failing_factor),
            (trials, stable, failed)
        );
        assert_eq!(safety.factor(), None);
    }
}

#[test]
fn a_stage_with_weakening_has_the_reduced_strength() {
    let stages = r#""stages": [{ "name": "rest", "duration": 0.5 },
        { "name": "weak", "duration": 1, "weakening": { "factor": 2 } },
        { "name": "weak still", "duration": 1 },
        { "name": "strong", "duration": 1, "weakening": { "factor": 1 } }]"#;
    let report = run_method(&Sliding::default(), &case(stages), &RunOptions::default()).unwrap();
    let at = |time: f64| {
        let row = report.table.rows.iter().min_by(|a, b| (a[0] - time).abs().total_cmp(&(b[0] - time).abs()));
        row.unwrap()[report.table.columns.iter().position(|(name, _)| name == "kinetic_energy").unwrap()]
    };
    let fastest = 2.0 * (DRIVING_FORCE - 0.5 * STRENGTH);
    assert_eq!(at(0.5), UNDAMPED_ENERGY);
    assert!(((at(2.5) - UNDAMPED_ENERGY) / (0.5 * fastest * fastest) - 1.0).abs() < 0.05, "{}", at(2.5));
    assert!(at(3.5) < at(2.5), "full strength brakes");
    let whole = case(stages);
    let error =
        crate::run(&whole, Sliding::default().build(&whole).unwrap(), &RunOptions::default()).unwrap_err();
    assert!(error.to_string().contains("stages[1].weakening"), "{error}");
}

#[test]
fn bad_searches_are_refused_by_path() {
    let measure = |text: &str| {
        let mut value: Value = serde_json::from_str(&searching("[1, 2]").to_json()).unwrap();
        let change: Value = serde_json::from_str(text).unwrap();
        for (key, new) in change.as_object().unwrap() {
            value["measures"]["safety"][key] = new.clone();
        }
        Case::from_json(&value.to_string()).unwrap_err().to_string()
    };
    for (change, path) in [
        (r#"{ "after": "nothing" }"#, "measures.safety.after"),
        (r#"{ "duration": 0 }"#, "measures.safety.duration"),
        (r#"{ "height": -1 }"#, "measures.safety.height"),
        (r#"{ "range": [2, 1] }"#, "measures.safety.range"),
        (r#"{ "range": [0, 1] }"#, "measures.safety.range"),
        (r#"{ "duration": -1 }"#, "measures.safety.duration"),
        (r#"{ "tolerance": 0 }"#, "measures.safety.tolerance"),
        (r#"{ "tolerance": 1e-30 }"#, "measures.safety.tolerance"),
        (r#"{ "damping": 1 }"#, "measures.safety.damping"),
        (r#"{ "materials": ["silt"] }"#, "measures.safety.materials[0]"),
    ] {
        let error = measure(change);
        assert!(error.contains(path), "{change}: {error}");
    }
}

#[test]
fn displacement_is_measured_on_points_present_at_both_times() {
    let at = |ids: &[u64], places: &[f64]| Snapshot {
        time: 0.0,
        step: 0,
        ids: ids.to_vec(),
        bodies: vec![0; ids.len()],
        positions: places.iter().map(|x| [*x, 0.0, 0.0]).collect(),
        extents: vec![[0.1; 3]; ids.len()],
        fields: Vec::new(),
    };
    let before = at(&[0, 1, 4, 7], &[0.0, 1.0, 4.0, 7.0]);
    let mut domain = searching("[1, 2]").domain;
    // Two points have left, one has been added, and the remaining ones have moved by 0.5 and 0.25.
    let now = at(&[1, 5, 7], &[1.5, 50.0, 7.25]);
    assert_eq!(slope_scale::exceeded_displacement(&now, &before, &domain), 0.5);
    assert_eq!(slope_scale::displacements(&now, &before, &domain)[1], None);
    assert_eq!(slope_scale::exceeded_displacement(&at(&[9], &[1.0]), &before, &domain), 0.0);
    // A point has left at the end of the period and entered at its start.
    domain.periodic = vec![Axis::X];
    assert_eq!(slope_scale::exceeded_displacement(&at(&[7], &[0.5]), &at(&[7], &[9.75]), &domain), 0.75);
}

fn slope(extra: &[([f64; 2], f64)]) -> Snapshot {
    let mut positions: Vec<[f64; 3]> = Vec::new();
    let (spacing, mut extents) = (0.5, Vec::new());
    for i in 0..40 {
        // Level at 2 m up to x = 5 m, a face up to 8 m at x = 11 m, level beyond.
        let x = (f64::from(i) + 0.5) * spacing;
        let top = (x - 3.0).clamp(2.0, 8.0);
        positions
            .extend((0..16).map(|j| [x, (f64::from(j) + 0.5) * spacing, 0.0]).filter(|place| place[1] < top));
    }
    extents.resize(positions.len(), [spacing, spacing, 1.0]);
    for (place, width) in extra {
        positions.push([place[0], place[1], 0.0]);
        extents.push([*width, *width, 1.0]);
    }
    let count = positions.len();
    let scalar = |name: &str, unit, value: f64| Field {
        name: name.into(),
        unit,
        data: crate::FieldData::Scalar(vec![value; count]),
    };
    Snapshot {
        time: 0.0,
        step: 0,
        ids: (0..count as u64).collect(),
        bodies: vec![0; count],
        positions,
        extents,
        fields: vec![scalar("mass", "kg", 500.0), scalar("volume", "m3", 0.25)],
    }
}

#[test]
fn slope_height_is_measured_on_the_surface_without_the_foundation() {
    let case = searching("[1, 2]");
    let scale = SlopeScale::of_case(&case, &slope(&[]), None);
    assert!((scale.height - 6.0).abs() < 1e-9, "{scale:?}");
    // γ H² / E of 2000 kg/m³ and 1 MPa.
    assert!((scale.settlement / (2000.0 * 9.81 * 36.0 / 1e6) - 1.0).abs() < 1e-9, "{scale:?}");
    assert_eq!(SlopeScale::of_case(&case, &slope(&[]), Some(3.0)).height, 3.0);
}

#[test]
fn slope_height_of_a_level_body_is_the_body_height() {
    let mut level = slope(&[]);
    level.positions.iter_mut().for_each(|place| place[0] = place[0].max(12.0));
    assert!((SlopeScale::of_case(&searching("[1, 2]"), &level, None).height - 8.0).abs() < 1e-9);
}

#[test]
fn a_search_with_only_a_stage_derives_its_other_settings() {
    let mut value: Value = serde_json::from_str(&searching("[1, 2]").to_json()).unwrap();
    value["measures"]["safety"] = json!({ "kind": "factor-of-safety", "after": "rest" });
    let case = Case::from_json(&value.to_string()).unwrap();
    let report = run_method(&Sliding::default(), &case, &RunOptions::default()).unwrap();
    let safety = &report.safety["safety"];
    assert_eq!((safety.outcome(), safety.tolerance), (SearchOutcome::Found, 0.01));
    assert!((safety.factor().unwrap() - STRENGTH).abs() <= 0.005, "{safety:?}");
    assert!(safety.window > 0.0 && safety.height > 0.0);
    let failing = &report.failed_trials["safety"];
    let moved = failing.vectors("trial_displacement").unwrap()[0][0];
    let last = safety
        .trials
        .iter()
        .filter(|trial| trial.is_failed())
        .map(|trial| (trial.factor, trial.displacement));
    let (_, displacement) = last.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    assert_eq!(moved, displacement, "the frame is that of the least failing factor");
    value["gravity"] = json!([0, 0]);
    let error = Case::from_json(&value.to_string()).unwrap_err().to_string();
    assert!(error.contains("measures.safety.duration: cannot be determined without gravity"), "{error}");
}

fn safety_of(trials: &[(f64, TrialVerdict)]) -> SafetyResult {
    let mut safety = SafetyResult {
        stable_factor: 0.0,
        failing_factor: f64::INFINITY,
        tolerance: 0.1,
        height: 1.0,
        window: 1.0,
        trials: Vec::new(),
    };
    for &(factor, verdict) in trials {
        safety.add(StrengthTrial {
            factor,
            verdict,
            time: 1.0,
            displacement: 0.1,
            dimensionless_displacement: 1.0,
            unbalanced_force: 0.1,
        });
    }
    safety
}

#[test]
fn undecided_trials_are_bracketed_from_both_sides_and_yield_no_factor() {
    use TrialVerdict::{Failed, Stable, Undecided};
    let mut trials = vec![(1.0, Stable), (2.0, Failed), (1.5, Undecided)];
    assert_eq!(safety_of(&trials).next_factor([1.0, 2.0]), Some(1.75));
    trials.push((1.75, Failed));
    assert_eq!(safety_of(&trials).next_factor([1.0, 2.0]), Some(1.25));
    trials.extend([(1.25, Stable), (1.375, Stable), (1.4375, Stable), (1.625, Failed), (1.5625, Failed)]);
    let safety = safety_of(&trials);
    assert_eq!(
        (safety.next_factor([1.0, 2.0]), safety.factor(), safety.outcome()),
        (None, None, SearchOutcome::Undecided)
    );
    let message = safety.message();
    assert!(
        message.starts_with("undecided: stable at 1.438, failed at 1.562; at 1.500 the bodies"),
        "{message}"
    );
    assert!(safety.to_json()["factor"].is_null());
}

#[test]
fn a_search_with_undecided_range_limits_is_undecided() {
    use TrialVerdict::{Failed, Stable, Undecided};
    let safety = safety_of(&[(1.0, Undecided)]);
    assert_eq!((safety.next_factor([1.0, 2.0]), safety.outcome()), (None, SearchOutcome::Undecided));
    assert!(safety.message().contains("no stable factor, no failed factor"), "{}", safety.message());
    let mut trials = vec![(1.0, Stable), (1.1, Undecided)];
    assert_eq!(safety_of(&trials).next_factor([1.0, 1.1]), None);
    trials.push((1.05, Failed));
    let found = safety_of(&trials);
    assert_eq!((found.next_factor([1.0, 1.1]), found.outcome()), (None, SearchOutcome::Found));
}

#[test]
fn stable_trials_that_slid_and_soft_slopes_cause_warnings() {
    let codes = |displacement: f64, dimensionless: f64| {
        let mut safety = safety_of(&[(1.0, TrialVerdict::Stable), (2.0, TrialVerdict::Failed)]);
        safety.trials[0].displacement = displacement;
        safety.trials[0].dimensionless_displacement = dimensionless;
        safety.warnings("safety").into_iter().map(|warning| warning.code.into_owned()).collect::<Vec<_>>()
    };
    assert!(codes(1e-3, 0.2).is_empty());
    assert_eq!(codes(8e-3, 4.0), ["slid-in-stable-trial"]);
    assert_eq!(codes(8e-3, 0.2), ["soft-slope"]);
    assert!(codes(0.1, f64::NAN).is_empty(), "no Young's modulus");
}
