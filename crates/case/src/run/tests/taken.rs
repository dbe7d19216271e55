//! Tests of folders with files that a run may not overwrite.

use super::*;

#[test]
fn files_that_no_run_wrote_are_never_written_over() {
    let case = case(r#"[ { "name": "all", "duration": 0.1 } ]"#);
    for name in ["case.json", "measures.csv", "frames.pvd", "profile-top.csv", "state-0.bin", "frames"] {
        for overwrite in [false, true] {
            let out = tempfile::tempdir().unwrap();
            let path = out.path().join(name);
            std::fs::write(&path, "mine").unwrap();
            let options_of_run = RunOptions { overwrite, ..options(out.path()) };
            let error = run(&case, Oscillators::boxed(0.0, None), &options_of_run).unwrap_err().to_string();
            assert!(error.contains(&format!("contains {name}, which no run wrote")), "{error}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
            assert_eq!(std::fs::read_dir(out.path()).unwrap().count(), 1, "nothing else was written");
        }
    }
}

#[test]
fn files_of_other_origin_do_not_block_a_run_and_are_kept() {
    let case = case(r#"[ { "name": "all", "duration": 0.1 } ]"#);
    let out = tempfile::tempdir().unwrap();
    std::fs::write(out.path().join("notes.txt"), "mine").unwrap();
    run(&case, Oscillators::boxed(0.0, None), &options(out.path())).unwrap();
    let again = RunOptions { overwrite: true, ..options(out.path()) };
    run(&case, Oscillators::boxed(0.0, None), &again).unwrap();
    assert_eq!(std::fs::read_to_string(out.path().join("notes.txt")).unwrap(), "mine");
}
