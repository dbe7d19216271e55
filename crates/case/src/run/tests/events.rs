//! Events of a run that a program advances itself.

use super::*;

/// Run of the oscillators, without method.
fn begun(stages: &str, fail_at: Option<f64>, options: RunOptions) -> Run<'static> {
    let mut case = case(stages);
    case.output.frames = Some(0.5);
    case.output.measures = Some(0.25);
    Run::with_solver(Arc::new(case), Oscillators::boxed(0.0, fail_at), options).unwrap()
}

/// Events without the steps, each as a letter.
fn letters(run: &mut Run<'_>) -> (String, Option<RunError>) {
    let mut letters = String::new();
    loop {
        let event = match run.advance() {
            Ok(Some(event)) => event,
            Ok(None) => return (letters, None),
            Err(error) => return (letters, Some(error)),
        };
        letters.push(match event {
            RunEvent::StageBegan { .. } => 'B',
            RunEvent::Step(_) => continue,
            RunEvent::Row => 'r',
            RunEvent::Frame(_) => 'f',
            RunEvent::StageEnded { at_rest: false, .. } => 'e',
            RunEvent::Ended(RunEnd::Completed) => 'C',
            RunEvent::Ended(RunEnd::Interrupted) => 'I',
            _ => '?',
        });
    }
}

const TWO_STAGES: &str = r#"[ { "name": "a", "duration": 0.5 }, { "name": "b", "duration": 0.6 } ]"#;

#[test]
fn events_follow_the_stages_and_the_output_times() {
    fn is_send<T: Send + 'static>(_: &T) {}
    let mut run = begun(TWO_STAGES, None, RunOptions::default());
    is_send(&run);
    let (letters, error) = letters(&mut run);
    assert!(error.is_none());
    // Outputs at 0, 0.25 and 0.5 s in the first stage; at 0.75 and 1 s, and at the end at 1.1 s.
    assert_eq!(letters, "BrfrrfeBrrferfC");
    assert!(run.advance().unwrap().is_none());
    assert_eq!(run.table().rows.len(), 6);
}

#[test]
fn frames_are_handed_over_and_equal_those_that_are_kept() {
    let options = RunOptions { keep_frames: true, ..RunOptions::default() };
    let mut run = begun(TWO_STAGES, None, options);
    let mut frames = Vec::new();
    while let Some(event) = run.advance().unwrap() {
        frames.extend(if let RunEvent::Frame(frame) = event { Some(frame) } else { None });
    }
    let kept = run.finish().unwrap().frames;
    assert_eq!(kept.len(), 4);
    assert_eq!(frames.into_iter().map(|mut frame| frame.take_points().unwrap()).collect::<Vec<_>>(), kept);
}

#[test]
fn an_error_comes_after_the_events_before_it_and_then_the_run_refuses_to_advance() {
    let folder = tempfile::tempdir().unwrap();
    let mut run = begun(TWO_STAGES, Some(0.3), options(folder.path()));
    let (letters, error) = letters(&mut run);
    assert_eq!(letters, "Brfr");
    assert!(matches!(error, Some(RunError::Stopped { .. })), "{error:?}");
    assert!(matches!(run.advance(), Err(RunError::HasFailed)));
    assert!(matches!(run.finish(), Err(RunError::HasFailed)));
    let summary = std::fs::read_to_string(folder.path().join("summary.json")).unwrap();
    assert!(summary.contains(r#""status": "failed""#), "{summary}");
}

#[test]
fn a_run_interrupted_between_two_events_resumes_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let whole = begun(TWO_STAGES, None, RunOptions::default()).finish().unwrap();
    for events in [0, 1, 7, 30, 60, 75] {
        let mut run = begun(TWO_STAGES, None, RunOptions { overwrite: true, ..options(folder.path()) });
        for _ in 0..events {
            run.advance().unwrap().unwrap();
        }
        run.interrupt().unwrap();
        drop(run);
        let again = begun(TWO_STAGES, None, RunOptions { resume: true, ..options(folder.path()) });
        let report = again.finish().unwrap();
        assert_eq!(report.ending, RunEnd::Completed);
        assert_eq!(report.snapshot, whole.snapshot, "after {events} events");
        // As text, in which NaN equals itself.
        assert_eq!(format!("{:?}", report.table), format!("{:?}", whole.table), "after {events} events");
    }
}

#[test]
fn a_run_is_read_back_from_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let with = RunOptions { keep_frames: true, ..options(folder.path()) };
    let mut run = begun(TWO_STAGES, None, with);
    for _ in 0..30 {
        run.advance().unwrap();
    }
    let half = open(folder.path()).unwrap();
    assert_eq!((half.status(), half.frame_times().len()), (&RunStatus::Running, 1));
    let report = run.finish().unwrap();
    let read = open(folder.path()).unwrap();
    assert_eq!((read.status(), read.method()), (&RunStatus::Completed, "test"));
    assert_eq!(format!("{:?}", read.table()), format!("{:?}", report.table));
    assert_eq!(
        read.frame_times().collect::<Vec<_>>(),
        report.frames.iter().map(|f| f.time).collect::<Vec<_>>()
    );
    let frame = read.frame(2).unwrap().unwrap();
    assert_eq!(frame.positions, report.frames[2].positions);
    assert_eq!(read.frame(9).unwrap(), None);
    assert!(read.verify().unwrap().problems.is_empty());
    let error = open(&folder.path().join("frames")).unwrap_err().to_string();
    assert!(error.contains("summary.json"), "{error}");
}

/// At the end of the first stage, before the second one begins.
#[test]
fn a_run_interrupted_between_two_stages_continues_with_the_second() {
    let folder = tempfile::tempdir().unwrap();
    let mut run = begun(TWO_STAGES, None, options(folder.path()));
    while !matches!(run.advance().unwrap().unwrap(), RunEvent::StageEnded { .. }) {}
    run.interrupt().unwrap();
    drop(run);
    let mut again = begun(TWO_STAGES, None, RunOptions { resume: true, ..options(folder.path()) });
    assert_eq!(letters(&mut again).0, "BrrferfC");
}

#[test]
fn an_observer_sees_every_event_with_time_and_step() {
    use std::sync::Mutex;
    let seen = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&seen);
    let observer = Observer::new(move |observed: &ObservedEvent<'_>| {
        assert_eq!(observed.end_time, 1.1);
        kept.lock().unwrap().push((observed.event.clone(), observed.time, observed.step));
    });
    let options = RunOptions { observer: Some(observer), ..RunOptions::default() };
    let mut run = begun(TWO_STAGES, None, options);
    let mut advanced = Vec::new();
    while let Some(event) = run.advance().unwrap() {
        advanced.push((event, run.time(), run.solver().step_count()));
    }
    assert!(advanced.len() > 10);
    assert_eq!(*seen.lock().unwrap(), advanced);
}
