//! Frames with some fields only.

use colluvium::case::measure::{MeasuredState, read, read_solver};
use colluvium::case::{Case, FrameRequest, Snapshot, Solver};

/// Snapshot of a request.
fn snapshot(solver: &dyn Solver, wanted: FrameRequest<'_>) -> Snapshot {
    solver.frame(wanted).into_measured_points()
}

#[test]
fn a_frame_has_the_wanted_fields_with_their_values_in_the_whole_frame() {
    let folder = tempfile::tempdir().unwrap();
    for name in colluvium::template_names() {
        colluvium::write_template_files(name, folder.path()).unwrap();
        let text: serde_json::Value = serde_json::from_str(colluvium::template(name).unwrap()).unwrap();
        let case = Case::from_value(&text, folder.path()).unwrap();
        for method in case.methods.keys() {
            let mut solver = colluvium::method(method).unwrap().build(&case).unwrap();
            solver.begin_stage(0, 0.0).unwrap();
            for _ in 0..2 {
                let dt = solver.limit().dt;
                solver.step(dt).unwrap();
            }
            let whole = snapshot(&*solver, FrameRequest::Measured);
            let none = snapshot(&*solver, FrameRequest::Fields(&[]));
            assert_eq!(none, Snapshot { fields: Vec::new(), ..whole.clone() }, "{name}, {method}");
            // Measures ask for the fields that they read, and for no others.
            let travels = solver.removal_shape_travel();
            let state = MeasuredState {
                case: &case,
                snapshot: &whole,
                solver: Some(&*solver),
                cell: solver.cell_size(),
                travels: &travels,
            };
            let (wanted, all) = (read_solver(&case, &*solver), read(&state));
            assert_eq!(format!("{wanted:?}"), format!("{all:?}"), "{name}, {method}");
            for field in &whole.fields {
                let found = snapshot(&*solver, FrameRequest::Fields(&[&field.name]));
                let text = |fields: &[colluvium::case::Field]| format!("{fields:?}");
                assert!(
                    text(&found.fields) == text(std::slice::from_ref(field)),
                    "{name}, {method}: {}",
                    field.name
                );
            }
        }
    }
}
