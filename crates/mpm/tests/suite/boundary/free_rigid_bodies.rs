//! Rigid bodies that move by Newton's law (docs/theory/mpm.md, rigid bodies).

use colluvium_case::{Budget, Method, RunReport};
use colluvium_mpm::Mpm;
use colluvium_testkit::{CaseBuilder, advance_to, read_case, solve, start_solver, vectors};
use serde_json::{Value, json};

const G: f64 = 10.0;

/// A rigid block of 0.4 m × 0.2 m and 160 kg in empty space.
fn free_block() -> CaseBuilder {
    CaseBuilder::from_json(json!({
        "title": "test", "space": "plane-strain", "domain": { "min": [0, 0], "max": [2, 2] }, "gravity": [0, 0],
        "materials": {
            "m": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 },
            "soft": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 }
        },
        "bodies": [block(json!([0.8, 1.0]))],
        "stages": [{ "name": "s", "duration": 0.1,
                     "motions": [{ "target": "block", "velocity": [null, null], "turns": true }] }],
        "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4 } }
    }))
}

/// The block with its lower left corner somewhere.
#[allow(clippy::needless_pass_by_value, reason = "`block(json!(…))` reads well")]
fn block(low: Value) -> Value {
    let max: Vec<f64> =
        [0.4, 0.2].iter().zip(low.as_array().unwrap()).map(|(w, x)| w + x.as_f64().unwrap()).collect();
    json!({ "name": "block", "material": "m", "rigid": true, "shape": { "kind": "box", "min": low, "max": max } })
}

fn with_velocity(mut body: Value, velocity: &Value) -> Value {
    body["velocity"] = velocity.clone();
    body
}

/// A deformable body.
fn soft(min: [f64; 2], max: [f64; 2]) -> Value {
    json!({ "name": "bed", "material": "soft", "shape": { "kind": "box", "min": min, "max": max } })
}

/// Mean rate of a column over the part of the run from `share` of its time on.
fn late(report: &RunReport, column: &str, share: f64) -> f64 {
    let pairs = report.table.pairs("time", column).unwrap();
    let last = pairs[pairs.len() - 1];
    let first = pairs.iter().find(|pair| pair.0 >= share * last.0).unwrap();
    (last.1 - first.1) / (last.0 - first.0)
}

fn last(report: &RunReport, column: &str) -> f64 {
    report.table.pairs("time", column).unwrap().last().unwrap().1
}

#[test]
fn a_free_block_falls_and_spins_exactly() {
    let spin =
        json!({ "kind": "linear", "value": [0.5, 0.3], "origin": [1.0, 1.1], "gradient": [[0, -8], [8, 0]] });
    for (formulation, scale) in [("updated-lagrangian", 1.0), ("updated-lagrangian", 4.0)] {
        let report = free_block().with(json!({
            "gravity": [1, -3], "bodies": [with_velocity(block(json!([0.8, 1.0])), &spin)],
            "methods": { "mpm": { "cell_size": 0.1, "time_step": 1e-3, "formulation": formulation, "mass_scaling": scale } }
        })).solve(&Mpm);
        let t = 0.1;
        let velocity = ["x", "y"].map(|axis| last(&report, &format!("block.velocity.{axis}")));
        let exact = [0.5 + t / scale, 0.3 - 3.0 * t / scale];
        assert!((0..2).all(|c| (velocity[c] - exact[c]).abs() < 1e-12), "{velocity:?}");
        assert!((last(&report, "block.spin.z") - 8.0).abs() < 1e-11);
        assert!((last(&report, "block.angle") - 0.8).abs() < 1e-11);
        // The block is that of the formula to the last digit: its points are squares.
        let (m, i) = (160.0, 160.0 * (0.16 + 0.04) / 12.0);
        let kinetic = 0.5 * m * (exact[0] * exact[0] + exact[1] * exact[1]) + 0.5 * i * 64.0;
        assert!((report.end.kinetic / kinetic - 1.0).abs() < 1e-12, "{} {kinetic}", report.end.kinetic);
        // And stays a block: every point as far from the middle as it was.
        let n = report.snapshot.positions.len() as f64;
        let middle: [f64; 2] =
            std::array::from_fn(|c| report.snapshot.positions.iter().map(|x| x[c]).sum::<f64>() / n);
        // Forward of the exact place by half a step's worth of fall.
        let place = [1.0 + 0.5 * t + 0.5 * t * t / scale, 1.1 + 0.3 * t - 1.5 * t * t / scale];
        assert!(
            (0..2).all(|c| (middle[c] - place[c]).abs() < 0.5 * 3.0 * t * 1e-3 + 1e-12),
            "{middle:?} {place:?}"
        );
        let moved = vectors(&report.snapshot, "displacement");
        for (x, u) in report.snapshot.positions.iter().zip(&moved) {
            let arm = (x[0] - middle[0]).hypot(x[1] - middle[1]);
            let before = (x[0] - u[0] - 1.0).hypot(x[1] - u[1] - 1.1);
            assert!((arm - before).abs() < 1e-12);
        }
    }
}

#[test]
fn a_free_block_in_space_keeps_its_angular_momentum_and_wobbles_with_its_energy() {
    let gradient = [[0.0, -6.0, 3.0], [6.0, 0.0, -5.0], [-3.0, 5.0, 0.0]];
    let run = |dt: f64| {
        let mut solver = start_solver(
            &Mpm,
            &read_case(&json!({
                "title": "test", "space": "3d", "domain": { "min": [0, 0, 0], "max": [2, 2, 2] }, "gravity": [0, 0, 0],
                "materials": { "m": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 } },
                "bodies": [{ "name": "block", "material": "m", "rigid": true,
                             "shape": { "kind": "box", "min": [0.6, 0.8, 0.9], "max": [1.4, 1.2, 1.1] },
                             "velocity": { "kind": "linear", "value": [0, 0, 0], "origin": [1, 1, 1], "gradient": gradient } }],
                "stages": [{ "name": "s", "duration": 0.3,
                             "motions": [{ "target": "block", "velocity": [null, null, null], "turns": true }] }],
                "methods": { "mpm": { "cell_size": 0.1, "time_step": dt } }
            })),
        );
        let before = solver.budget().unwrap();
        advance_to(&mut *solver, 0.3);
        (before, solver.budget().unwrap())
    };
    let drift = |(before, after): (Budget, Budget)| {
        for c in 0..3 {
            let scale = before.angular_momentum.iter().map(|l| l * l).sum::<f64>().sqrt();
            assert!((after.angular_momentum[c] - before.angular_momentum[c]).abs() < 1e-11 * scale);
        }
        (after.kinetic / before.kinetic - 1.0).abs()
    };
    let [coarse, fine] = [1e-3, 5e-4].map(|dt| drift(run(dt)));
    // The turn of a step is of second order.
    assert!(coarse < 5e-5 && fine < 0.3 * coarse, "{coarse} {fine}");
}

#[test]
fn a_push_moves_a_block_on_a_wall_by_its_mass_and_friction() {
    let (force, mass) = (800.0, 160.0);
    for (wall, friction) in [
        (json!({ "kind": "smooth" }), 0.0),
        (json!({ "kind": "frictional", "friction_coefficient": 0.3 }), 0.3),
        (json!({ "kind": "frictional", "friction_coefficient": 0.6 }), 0.5),
        (json!({ "kind": "rough" }), 0.5),
    ] {
        for turns in [false, true] {
            let report = free_block().with(json!({
                "gravity": [0, -G], "bodies": [block(json!([0.4, 0.0]))],
                "boundaries": [{ "side": "y-min", "wall": wall }],
                "stages": [{ "name": "s", "duration": 0.4,
                             "motions": [{ "target": "block", "velocity": [null, null], "force": [force, 0], "turns": turns }] }],
                "methods": { "mpm": { "cell_size": 0.1, "time_step": 1e-3 } }
            })).solve(&Mpm);
            let exact = 0.4 * (force / mass - friction * G);
            let velocity = ["x", "y"].map(|axis| last(&report, &format!("block.velocity.{axis}")));
            assert!((velocity[0] - exact).abs() < 1e-5, "{wall}, {turns}: {velocity:?}, {exact}");
            assert!(velocity[1].abs() < 1e-5, "{wall}, {turns}: {velocity:?}");
            assert!(last(&report, "block.angle").abs() < 1e-5, "{wall}: {}", last(&report, "block.angle"));
        }
    }
}

#[test]
fn a_slender_block_on_a_rough_wall_tips_where_the_push_passes_its_edge() {
    // Pushed at its middle height of 0.2 m, it tips where the force exceeds W (0.2 m / 2) / 0.2 m = W / 2.
    let ends = [0.45, 0.55].map(|share| {
        let weight = 160.0 * G;
        let tall = json!({ "name": "block", "material": "m", "rigid": true,
                           "shape": { "kind": "box", "min": [0.8, 0.0], "max": [1.0, 0.4] } });
        let report = free_block().with(json!({
            "gravity": [0, -G], "bodies": [tall], "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
            "stages": [{ "name": "s", "duration": 0.3,
                         "motions": [{ "target": "block", "velocity": [null, null], "force": [share * weight, 0], "turns": true }] }],
            "methods": { "mpm": { "cell_size": 0.1, "time_step": 1e-3 } }
        })).solve(&Mpm);
        last(&report, "block.angle")
    });
    assert!(ends[0].abs() < 1e-4 && ends[1] < -0.02, "{ends:?}");
}

/// Momenta of a collision between a flying block and a bed that is at rest in empty space, before and after.
fn collision(contacts: &Value, scheme: &str, turns: bool) -> ([Budget; 2], f64) {
    let flight = json!({ "kind": "uniform", "value": [0.3, -2.0] });
    let case = free_block().with(json!({
        "bodies": [with_velocity(block(json!([0.65, 1.05])), &flight), soft([0.8, 0.6], [1.4, 1.0])],
        "stages": [{ "name": "s", "duration": 0.2, "motions": [{ "target": "block", "velocity": [null, null], "turns": turns }] }],
        "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4, "stress_update": scheme, "contacts": contacts } }
    })).build();
    let mut solver = start_solver(&Mpm, &case);
    let before = solver.budget().unwrap();
    advance_to(&mut *solver, 0.2);
    let impulse = solver.reaction("block").unwrap().impulse;
    ([before, solver.budget().unwrap()], impulse[0].hypot(impulse[1]))
}

#[test]
fn a_collision_with_a_deformable_body_keeps_momentum() {
    let law = json!([{ "bodies": ["block", "bed"], "friction_coefficient": 0.3, "test": "gap" }]);
    for contacts in [json!([]), law] {
        for scheme in ["usf", "usl", "musl"] {
            let ([before, after], impulse) = collision(&contacts, scheme, true);
            let size = 160.0 * 2.0;
            for c in 0..2 {
                let change = after.momentum[c] - before.momentum[c];
                assert!(change.abs() < 1e-10 * size, "{contacts}, {scheme}: {change}");
            }
            // The bed has taken some of it, or nothing would have been looked at.
            assert!((after.kinetic / before.kinetic) < 0.95, "{contacts}, {scheme}: {}", after.kinetic);
            // Impulses act at nodes, and on points of the deformable body within half a cell of them.
            let change = after.angular_momentum[2] - before.angular_momentum[2];
            assert!(
                impulse > 0.1 * size && change.abs() < 0.5 * 0.1 * impulse,
                "{contacts}, {scheme}: {change}"
            );
        }
    }
}

/// A block of the width of its bed that presses it between smooth walls, brought to rest.
fn rests(contacts: &Value, force: f64, turns: bool) -> (f64, f64) {
    let case = free_block().with(json!({
        "gravity": [0, -G], "domain": { "min": [0, 0], "max": [0.4, 2] },
        "bodies": [block(json!([0.0, 0.65])), soft([0.0, 0.0], [0.4, 0.6])],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
                       { "side": "x-max", "wall": { "kind": "smooth" } }],
        "measures": { "reaction": { "kind": "reaction", "target": "block" } },
        "stages": [{ "name": "drop", "duration": 2, "damping": 0.3,
                     "motions": [{ "target": "block", "velocity": [null, null], "force": [0, -force], "turns": turns }] }],
        "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4, "contacts": contacts } }
    })).build();
    let report = solve(&Mpm, &case);
    let moved = vectors(&report.snapshot, "displacement");
    let down = moved.iter().zip(&report.snapshot.bodies).find(|(_, body)| **body == 0).unwrap().0[1];
    (late(&report, "reaction.impulse.y", 0.9), down)
}

#[test]
fn the_reaction_on_a_block_at_rest_is_its_weight_and_load() {
    let law = json!([{ "bodies": ["block", "bed"], "friction_coefficient": 0.3, "test": "gap" }]);
    for (contacts, turns) in [(json!([]), false), (law.clone(), false), (law, true)] {
        for force in [0.0, 4000.0] {
            let (reaction, down) = rests(&contacts, force, turns);
            let whole = 160.0 * G + force;
            assert!((reaction / whole - 1.0).abs() < 2e-3, "{contacts}, {force}: {reaction} of {whole}");
            // It goes down the gap of 0.05 m (nodes touch up to half a cell before it), and the bed gives way by its modulus.
            let modulus = 1e6 * (1.0 - 0.2) / ((1.0 + 0.2) * (1.0 - 0.4));
            let given = 0.6 * whole / 0.4 / modulus;
            assert!((-0.05 - given - down).abs() < 0.06, "{contacts}, {force}: {down}, {given}");
        }
    }
}

#[test]
fn a_pushed_block_accelerates_by_the_force_less_friction_of_the_bed() {
    let (force, friction, mass) = (1200.0, 0.3, 160.0);
    let report = free_block().with(json!({
        "gravity": [0, -G],
        "bodies": [block(json!([0.2, 0.3])), soft([0.0, 0.0], [2.0, 0.3])],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
                       { "side": "x-max", "wall": { "kind": "smooth" } }],
        "measures": { "reaction": { "kind": "reaction", "target": "block" } },
        "stages": [
            { "name": "settle", "duration": 0.3, "damping": 0.3, "motions": [{ "target": "block", "velocity": [null, null] }],
              "reset": ["velocity"] },
            { "name": "push", "duration": 0.5,
              "motions": [{ "target": "block", "velocity": [null, null], "force": [force, 0] }] }],
        "methods": { "mpm": { "cell_size": 0.05, "courant": 0.4,
                              "contacts": [{ "bodies": ["block", "bed"], "friction_coefficient": friction, "test": "gap",
                                             "normal": [0, -1] }] } }
    })).solve(&Mpm);
    let gained = late(&report, "block.velocity.x", 0.5);
    let exact = force / mass - friction * G;
    assert!((gained / exact - 1.0).abs() < 0.01, "{gained}, {exact}");
    // Newton's law to round-off, for any deformation of the bed.
    let friction_impulse = late(&report, "reaction.impulse.x", 0.5);
    assert!((mass * gained - force - friction_impulse).abs() < 1e-9 * force, "{gained} {friction_impulse}");
    let whole = friction_impulse / late(&report, "reaction.impulse.y", 0.5);
    assert!((whole + friction).abs() < 1e-3, "{whole}");
}

#[test]
fn a_light_block_on_heavy_ground_gains_no_energy() {
    // A block of a hundredth of the density of the bed, stuck to it: the energy falls.
    for contacts in
        [json!([]), json!([{ "bodies": ["block", "bed"], "friction_coefficient": 0.3, "test": "gap" }])]
    {
        let case = free_block().with(json!({
            "gravity": [0, -G],
            "materials": { "m": { "model": "linear-elastic", "density": 10, "youngs_modulus": 1e6, "poissons_ratio": 0.2 },
                           "soft": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 } },
            "bodies": [block(json!([0.8, 0.5])), soft([0.0, 0.0], [2.0, 0.5])],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
                           { "side": "x-max", "wall": { "kind": "smooth" } }],
            "stages": [{ "name": "s", "duration": 0.5, "motions": [{ "target": "block", "velocity": [null, null], "turns": true }] }],
            "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4, "contacts": contacts } }
        })).build();
        let mut solver = start_solver(&Mpm, &case);
        let energy = |b: &Budget| b.kinetic + b.elastic + b.potential;
        let start = solver.budget().unwrap();
        let mut largest_energy = energy(&start);
        while solver.time() < 0.5 {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
            largest_energy = largest_energy.max(energy(&solver.budget().unwrap()));
        }
        let exchanged = energy(&start) * 0.01;
        assert!(largest_energy - energy(&start) < exchanged, "{contacts}: {largest_energy} {start:?}");
    }
}

#[test]
fn runs_of_free_rigid_bodies_are_the_same_on_two_threads_and_after_a_restart() {
    let flight = json!({ "kind": "uniform", "value": [0.3, -2.0] });
    let case = free_block().with(json!({
        "gravity": [0, -G], "bodies": [with_velocity(block(json!([0.5, 0.45])), &flight), soft([0.0, 0.0], [2.0, 0.4])],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
                       { "side": "x-max", "wall": { "kind": "smooth" } }],
        "methods": { "mpm": { "cell_size": 0.05, "courant": 0.4,
                              "contacts": [{ "bodies": ["block", "bed"], "friction_coefficient": 0.3 }] } }
    })).build();
    let hash = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = start_solver(&Mpm, &case);
            advance_to(&mut *solver, 0.06);
            solver.snapshot().hash()
        })
    };
    assert_eq!(hash(1), hash(2));
    let mut whole = start_solver(&Mpm, &case);
    (0..60).for_each(|_| {
        whole.step(4e-4).unwrap();
    });
    let mut again = Mpm.build(&case).unwrap();
    again.restore(&mut whole.checkpoint_bytes().unwrap().as_slice()).unwrap();
    for solver in [&mut whole, &mut again] {
        (0..60).for_each(|_| {
            solver.step(4e-4).unwrap();
        });
    }
    assert_eq!(whole.snapshot().hash(), again.snapshot().hash());
}

#[test]
fn options_without_support_for_free_rigid_bodies_are_rejected_by_key() {
    let refused = |more: Value| {
        let case = free_block().with(more).build();
        Mpm.plan(&case).map_or_else(|error| error.to_string(), |_| String::new())
    };
    assert_eq!(refused(json!({ "methods": { "mpm": { "cell_size": 0.1, "time_step": 1e-3 } } })), "");
    assert!(refused(json!({})).contains("give the method a `time_step`"));
    let rock = json!([{ "name": "o", "shape": { "kind": "ball", "centre": [0.3, 0.3], "radius": 0.1 }, "wall": { "kind": "smooth" } }]);
    assert!(refused(json!({ "obstacles": rock })).contains("`points`"));
    assert!(
        refused(json!({ "domain": { "min": [0, 0], "max": [2, 2], "periodic": ["x"] } }))
            .contains("no periodic image")
    );
    assert!(
        refused(json!({ "methods": { "mpm": { "cell_size": 0.1, "shape": "cpdi" } } }))
            .contains("do not rotate")
    );
}

#[test]
fn a_stage_with_equilibrium_ends_where_a_loaded_block_rests() {
    let case = free_block().with(json!({
        "gravity": [0, -G], "domain": { "min": [0, 0], "max": [0.4, 2] },
        "bodies": [block(json!([0.0, 0.6])), soft([0.0, 0.0], [0.4, 0.6])],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
                       { "side": "x-max", "wall": { "kind": "smooth" } }],
        "measures": { "reaction": { "kind": "reaction", "target": "block" } },
        "stages": [{ "name": "rest", "duration": 10, "damping": 0.5, "equilibrium": { "unbalanced_force": 1e-3, "kinetic_energy": 1e-4 },
                     "motions": [{ "target": "block", "velocity": [0, null], "force": [0, -4000], "ramp": 0.2 }] }]
    })).build();
    let report = solve(&Mpm, &case);
    let end = last(&report, "time");
    assert!((0.2..5.0).contains(&end), "{end}");
    let force = last(&report, "reaction.y");
    assert!((force / (160.0 * G + 4000.0) - 1.0).abs() < 0.01, "{force}");
}
