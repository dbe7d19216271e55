//! Tests of a run that overwrites: files of an earlier run, and other files.

use super::*;
use crate::run::output::run_folder::names;

#[test]
fn overwriting_removes_files_of_the_earlier_run_and_keeps_others() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = case(r#"[ { "name": "all", "duration": 0.2 } ]"#);
    run(&case, Oscillators::boxed(0.0, None), &options(folder.path())).unwrap();
    assert!(folder.path().join("profile-top.csv").exists());
    let foreign = ["notes.txt", "frames/note.txt", "rasters/style.qml", "rasters/mine.tif"];
    std::fs::create_dir(folder.path().join("rasters")).unwrap();
    for name in foreign {
        std::fs::write(folder.path().join(name), "kept").unwrap();
    }
    // A map of the earlier run, and a frame that was partial when the run was killed.
    let own = ["rasters/peak_velocity.asc", "frames/points-00077.vtu", "frames/points-00078.vtu.tmp"];
    own.iter().for_each(|name| std::fs::write(folder.path().join(name), "gone").unwrap());
    case.measures.remove("top");
    run(&case, Oscillators::boxed(0.0, None), &RunOptions { overwrite: true, ..options(folder.path()) })
        .unwrap();
    assert!(!folder.path().join("profile-top.csv").exists());
    for name in foreign {
        assert!(folder.path().join(name).exists(), "{name}: a file of no run is kept");
    }
    for name in own {
        assert!(!folder.path().join(name).exists(), "{name}: a file of the run is removed");
    }
    remove_run(folder.path()).unwrap();
    let mut left = names(folder.path()).unwrap();
    left.sort();
    assert_eq!(left, ["frames", "notes.txt", "rasters"]);
}
