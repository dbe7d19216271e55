//! Equal bits on any number of threads and after a restart.

use colluvium_case::Method;
use colluvium_snow_mpm::SnowMpm;
use colluvium_testkit::{advance_steps, read_case, start_solver, take_steps};
use serde_json::json;

use crate::bodies::ball;

#[test]
fn the_result_is_the_same_on_any_number_of_threads() {
    for options in [json!({ "cell_size": 0.02 }), json!({ "cell_size": 0.02, "transfer": "flip" })] {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut solver = start_solver(&SnowMpm, &read_case(&ball(&options)));
                advance_steps(&mut *solver, 150);
                (
                    solver.snapshot().hash(),
                    solver.scalar_outputs().iter().map(|r| r.2.to_bits()).collect::<Vec<_>>(),
                )
            })
        };
        assert_eq!(run(1), run(3), "{options}");
    }
}

#[test]
fn a_restored_solver_is_bit_identical() {
    let case = read_case(&ball(&json!({})));
    let mut first = start_solver(&SnowMpm, &read_case(&ball(&json!({}))));
    // Far enough for points to have been sorted again, and to have drifted since.
    advance_steps(&mut *first, 220);
    let saved = first.checkpoint_bytes().unwrap();
    let mut second = SnowMpm.build(&case).unwrap();
    second.restore(&mut saved.as_slice()).unwrap();
    second.begin_stage(0, 0.0).unwrap();
    assert_eq!(second.checkpoint_bytes().unwrap(), saved);
    for solver in [&mut first, &mut second] {
        let dt = solver.limit().dt;
        take_steps(&mut **solver, 1, 0.5 * dt);
        advance_steps(&mut **solver, 120);
    }
    assert_eq!(first.snapshot().hash(), second.snapshot().hash());
    assert_eq!(first.checkpoint_bytes().unwrap(), second.checkpoint_bytes().unwrap());
}

#[test]
fn bytes_of_another_case_are_refused() {
    let saved = start_solver(&SnowMpm, &read_case(&ball(&json!({})))).checkpoint_bytes().unwrap();
    let mut other = start_solver(&SnowMpm, &read_case(&ball(&json!({ "shape": "quadratic" }))));
    let error = other.restore(&mut saved.as_slice()).unwrap_err();
    assert!(error.to_string().contains("another case"), "{error}");
    let mut same = start_solver(&SnowMpm, &read_case(&ball(&json!({}))));
    assert!(same.restore(&mut &saved[..saved.len() / 2]).is_err());
}
