//! Results do not depend, to the last bit, on the number of threads or on a restart.

use colluvium_case::{Method, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::{assert_same_on_threads, start_solver};

use crate::solver::{SCHEMES, SHAPES, crash};

#[test]
fn results_are_the_same_on_one_and_two_threads() {
    for shape in SHAPES {
        for scheme in SCHEMES {
            let case = crash(shape, scheme);
            assert_same_on_threads(&Mpm, &case, &format!("{shape}, {scheme}"));
        }
    }
}

#[test]
fn a_restored_solver_continues_bit_identically() {
    for shape in SHAPES {
        let case = crash(shape, "musl");
        let advance = |solver: &mut dyn Solver, steps: usize| {
            for _ in 0..steps {
                let dt = solver.limit().dt;
                solver.step(dt).unwrap();
            }
        };
        let mut whole = start_solver(&Mpm, &case);
        // Later the disks have sheared too far for the corners of their points' domains.
        let cuts: &[usize] = if shape == "cpdi" { &[1, 37, 5] } else { &[1, 37, 5, 64] };
        for &cut in cuts {
            advance(&mut *whole, cut);
            let saved = whole.checkpoint_bytes().unwrap();
            let mut again = start_solver(&Mpm, &case);
            again.restore(&mut saved.as_slice()).unwrap();
            again.begin_stage(0, 0.0).unwrap();
            let mut reference = Mpm.build(&case).unwrap();
            reference.restore(&mut saved.as_slice()).unwrap();
            reference.begin_stage(0, 0.0).unwrap();
            advance(&mut *again, 50);
            advance(&mut *reference, 50);
            assert_eq!(again.snapshot().hash(), reference.snapshot().hash());
            advance(&mut *whole, 50);
            assert_eq!(again.snapshot().hash(), whole.snapshot().hash(), "{shape}, cut after {cut} steps");
        }
    }
}

#[test]
fn a_checkpoint_of_other_shape_functions_is_refused() {
    let saved = Mpm.build(&crash("ugimp", "usl")).unwrap().checkpoint_bytes().unwrap();
    let mut other = Mpm.build(&crash("cubic", "usl")).unwrap();
    assert!(other.restore(&mut saved.as_slice()).is_err());
    assert!(other.restore(&mut &saved[..saved.len() / 2]).is_err());
}
