//! Column collapse with domain decomposition into ranks (sheet: sph V-26).

use colluvium::case::{Case, Snapshot, Solver};
use serde_json::json;

use crate::analysis::MaxOrNan;
use crate::benchmarks::sph::waves::{advance, start};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, set_method_option};

/// Benchmark of a collapsing column that is divided into ranks.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/ranks",
    title: "A collapsing column in 1, 2, 3 and 8 ranks, SPH",
    source: "Bui & Nguyen 2021, §3.7; sheet: sph §3.9, V-26",
    short_seconds: Some(4),
    full_seconds: 4,
    run,
};

/// Number of steps that are compared (V-26).
const STEPS: usize = 200;
/// Steps between two checks of the particles' ranks.
const STEPS_PER_CHECK: usize = 20;

/// Time at which the compared steps begin (s). In the first 200 of all steps the column hardly moves.
const FALL_DURATION: f64 = 0.1;

/// Case of the column of set S in a number of ranks, with a tenth of the stiffness so that it moves within 200 steps.
fn column(ranks: u32) -> Result<Case, String> {
    let mut case = load_case("sph/aluminium-bars")?;
    let soft = json!({ "model": "drucker-prager", "density": 2040, "youngs_modulus": 5.84e5, "poissons_ratio": 0.3,
                       "friction_angle": 21.9, "matching": "plane-strain-associated" });
    case.materials.insert("bars".into(), serde_json::from_value(soft).map_err(|error| error.to_string())?);
    set_method_option(&mut case, "sph", "courant", 0.4);
    if ranks > 1 {
        set_method_option(&mut case, "sph", "ranks", ranks);
    }
    Ok(case)
}

/// Solver in a number of ranks that continues from a checkpoint.
fn resumed_solver(mut checkpoint: &[u8], ranks: u32) -> Result<Box<dyn Solver>, String> {
    let mut solver = start(&column(ranks)?)?;
    solver.restore(&mut checkpoint).map_err(|error| error.to_string())?;
    solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
    Ok(solver)
}

/// Ranks to which the particles belong.
fn owners(snapshot: &Snapshot) -> Vec<f64> {
    snapshot.scalars("rank").map_or_else(|| vec![0.0; snapshot.ids.len()], <[f64]>::to_vec)
}

/// Largest distance between positions of a particle in two snapshots (m).
fn apart(a: &Snapshot, b: &Snapshot) -> f64 {
    let distance = |(x, y): (&[f64; 3], &[f64; 3])| (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f64>().sqrt();
    a.positions.iter().zip(&b.positions).map(distance).max_or_nan()
}

/// Checks that a column in several ranks moves as in one.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut alone = start(&column(1)?)?;
    while alone.time() < FALL_DURATION {
        advance(&mut *alone)?;
    }
    let checkpoint = alone.checkpoint_bytes().map_err(|error| error.to_string())?;
    for _ in 0..STEPS {
        advance(&mut *alone)?;
    }
    let expected = alone.snapshot();
    let begun = resumed_solver(&checkpoint, 1)?.snapshot();
    outcome.info(
        format!("farthest way of a particle in the {STEPS} steps from {FALL_DURATION} s (m)"),
        "",
        apart(&begun, &expected),
        "for scale: the spacing is 0.005 m",
    );
    for ranks in [1, 2, 3, 8] {
        let mut solver = resumed_solver(&checkpoint, ranks)?;
        let (mut migrated, mut before) = (0, Vec::new());
        for step in 0..STEPS {
            advance(&mut *solver)?;
            if step % STEPS_PER_CHECK == 0 {
                let now = owners(&solver.snapshot());
                migrated += now.iter().zip(&before).filter(|(a, b)| a != b).count();
                before = now;
            }
        }
        let found = solver.snapshot();
        let name = |what: &str| format!("V-26, {ranks} ranks: {what}");
        let reason = "V-26: 1e-12; sums run in the order of the solver without ranks, so that it is nothing";
        outcome.assert_below(
            name("largest distance from the run without ranks (m)"),
            "0",
            apart(&found, &expected),
            1e-12,
            reason,
        );
        if ranks > 1 {
            let reason = "V-26 tests nothing where nobody moves house; counted every 20 steps";
            outcome.assert_within(
                name("particles that migrated"),
                "some",
                migrated as f64,
                (1.0, f64::INFINITY),
                reason,
            );
            let mut held = vec![0.0f64; ranks as usize];
            owners(&found).iter().for_each(|rank| held[*rank as usize] += 1.0);
            let maximum = held.iter().copied().max_or_nan();
            let mean = held.iter().sum::<f64>() / f64::from(ranks);
            let reason = "not judged: ranks are balanced by neighbours, within 1.1 (sheet: sph §3.9)";
            outcome.info(name("most particles in a rank over the mean"), "about 1", maximum / mean, reason);
        }
    }
    Ok(outcome)
}
