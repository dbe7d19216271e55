//! Order of the grains in memory: list builds sort them, and ids, frames, checkpoints and results do not depend on it.

use std::fmt::Write;

use colluvium_case::Solver;
use colluvium_dem::{DemSolver, spheres};
use colluvium_testkit::{advance_steps, read_case};
use serde_json::json;

/// Number of grains along each edge of the block, enough for several slabs.
const COUNTS: [usize; 3] = [10, 10, 30];

/// Position of a grain (m) and its id.
type ListedGrain = ([f64; 3], u32);

/// Loose block of spheres, displaced from a lattice, with ids in no spatial order.
fn block() -> Vec<ListedGrain> {
    let [nx, ny, nz] = COUNTS;
    let wave = |k: usize| 0.02 * (1.7 * k as f64).sin();
    let place = |k: usize| {
        let cell = [k / (ny * nz), k / nz % ny, k % nz];
        std::array::from_fn(|c| 0.1 * (cell[c] as f64 + 0.5) * 1.04 + 0.1 * wave(3 * k + c))
    };
    let count = nx * ny * nz;
    // The step has no divisor in common with the number of grains.
    (0..count).map(|k| (place(k), (k * 1009 % count) as u32)).collect()
}

/// Solver of spheres that fall on a floor with a wall beside it, from a file with the grains in a given order.
fn solver(grains: &[ListedGrain]) -> DemSolver<3, 3> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grains.csv");
    let mut text = "x,y,z,radius,id\n".to_owned();
    for ([x, y, z], id) in grains {
        writeln!(text, "{x},{y},{z},0.05,{id}").unwrap();
    }
    std::fs::write(&file, text).unwrap();
    let wall = json!({ "kind": "frictional", "friction_coefficient": 0.4 });
    let case = json!({
        "title": "block", "space": "3d",
        "domain": { "min": [-1, -1, 0], "max": [3, 3, 5] }, "gravity": [2, 0, -9.81],
        "materials": { "grain": { "model": "linear-elastic", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3 } },
        "bodies": [{
            "name": "block", "material": "grain", "points": { "file": file },
            "shape": { "kind": "box", "min": [-1, -1, 0], "max": [3, 3, 5] }
        }],
        "boundaries": [{ "side": "z-min", "wall": wall }, { "side": "x-max", "position": 1.06, "wall": wall }],
        "stages": [{ "name": "fall", "duration": 10 }],
        "methods": { "dem": {
            "grains": { "grain": { "density": 2500 } },
            "pairs": [{
                "between": ["grain", "grain"], "friction": { "coefficient": 0.4 },
                "normal": { "law": "linear", "stiffness": 1e5, "damping_ratio": 0.2, "clamp": false },
                "tangential": { "damping_ratio": 0.1 }
            }],
            "skin": 0.05
        } }
    });
    let mut solver = spheres(&read_case(&case)).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    solver
}

/// Runs a function on a number of threads.
fn on_threads<T: Send>(threads: usize, run: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

#[test]
fn results_do_not_depend_on_the_order_of_the_given_grains() {
    let (given, mut turned) = (block(), block());
    turned.reverse();
    let [one, two] = [&given, &turned].map(|grains| {
        let mut solver = solver(grains);
        advance_steps(&mut solver, 400);
        assert!(solver.contact_count() > 1000, "{}", solver.contact_count());
        solver.snapshot()
    });
    assert_eq!(one.ids, two.ids);
    for (a, b) in one.positions.iter().zip(&two.positions) {
        let apart = (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-10, "{a:?} {b:?}");
    }
}

#[test]
fn frames_have_ids_in_order_after_list_builds_have_sorted_the_grains() {
    let given = block();
    let mut solver = solver(&given);
    let start = solver.snapshot();
    for (position, id) in &given {
        let at = start.ids.iter().position(|own| own == &u64::from(*id)).unwrap();
        assert_eq!(&start.positions[at], position);
    }
    advance_steps(&mut solver, 400);
    let (end, grains) = (solver.snapshot(), solver.grains());
    assert_eq!(end.ids, start.ids);
    assert!(end.ids.is_sorted() && !grains.id().is_sorted());
    for (id, position) in grains.id().iter().zip(grains.position()) {
        let at = end.ids.iter().position(|own| own == &u64::from(*id)).unwrap();
        assert_eq!(&end.positions[at], position);
    }
    // Neighbours in space are neighbours in memory, in contrast to the ids.
    let jumps = |places: &[[f64; 3]]| {
        places.windows(2).map(|two| (0..3).map(|c| (two[1][c] - two[0][c]).powi(2)).sum::<f64>().sqrt()).sum()
    };
    let (sorted, by_id): (f64, f64) = (jumps(grains.position()), jumps(&end.positions));
    assert!(sorted < 0.25 * by_id, "{sorted} {by_id}");
}

#[test]
fn sorted_grains_have_the_same_bits_on_two_threads_and_after_a_restart() {
    let given = block();
    let [one, two, three] = [1, 2, 3].map(|threads| {
        on_threads(threads, || {
            let mut solver = solver(&given);
            advance_steps(&mut solver, 250);
            let saved = solver.checkpoint_bytes().unwrap();
            advance_steps(&mut solver, 250);
            (saved, solver.checkpoint_bytes().unwrap())
        })
    });
    assert!(one == two && one == three);
    let again = on_threads(2, || {
        let mut solver = solver(&given);
        solver.restore(&mut &one.0[..]).unwrap();
        solver.begin_stage(0, 0.0).unwrap();
        advance_steps(&mut solver, 250);
        solver.checkpoint_bytes().unwrap()
    });
    assert!(again == one.1);
}
