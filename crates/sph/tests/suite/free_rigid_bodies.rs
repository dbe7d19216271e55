//! Rigid bodies with free motion (sheet: sph §2.14).

use colluvium_case::description::Velocity;
use colluvium_case::{Case, Method, RunReport};
use colluvium_sph::Sph;
use colluvium_testkit::{CaseBuilder, advance_steps, case_with, solve, start_solver, stresses, vectors};
use serde_json::{Value, json};

/// Rigid block of 0.2 m × 0.1 m and 10 kg, in empty space.
fn free_block() -> CaseBuilder {
    CaseBuilder::from_json(json!({
        "title": "test", "space": "plane-strain", "domain": { "min": [-1, -1], "max": [2, 2] }, "gravity": [0, 0],
        "materials": {
            "wood": { "model": "newtonian-fluid", "density": 500, "bulk_modulus": 2e5, "viscosity": 0 },
            "water": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 4e5, "viscosity": 0 },
            "soft": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 }
        },
        "bodies": [block([0.4, 0.4])],
        "stages": [{ "name": "s", "duration": 0.1, "motions": [{ "target": "block", "velocity": [null, null], "turns": true }] }],
        "methods": { "sph": { "spacing": 0.02 } }
    }))
}

fn block([x, y]: [f64; 2]) -> Value {
    json!({ "name": "block", "material": "wood", "rigid": true,
            "shape": { "kind": "box", "min": [x, y], "max": [x + 0.2, y + 0.1] } })
}

#[test]
fn a_free_block_falls_and_spins_as_one() {
    let mut spinning = block([0.4, 0.4]);
    spinning["velocity"] = json!({ "kind": "linear", "value": [0.5, 0.3], "origin": [0.5, 0.45], "gradient": [[0, -8], [8, 0]] });
    let report = free_block().with(json!({
        "gravity": [1, -3], "bodies": [spinning],
        "stages": [{ "name": "s", "duration": 0.1,
                     "motions": [{ "target": "block", "velocity": [null, null], "force": [10, 0], "turns": true }] }]
    })).solve(&Sph);
    let velocities = vectors(&report.snapshot, "velocity");
    let n = velocities.len() as f64;
    let mean: [f64; 2] = std::array::from_fn(|c| velocities.iter().map(|v| v[c]).sum::<f64>() / n);
    // Force of 10 N on 10 kg in addition to gravity.
    assert!((mean[0] - 0.7).abs() < 1e-9 && mean[1].abs() < 1e-9, "{mean:?}");
    let x = &report.snapshot.positions;
    let middle: [f64; 2] = std::array::from_fn(|c| x.iter().map(|x| x[c]).sum::<f64>() / n);
    let moved = vectors(&report.snapshot, "displacement");
    for ((x, v), u) in x.iter().zip(&velocities).zip(&moved) {
        let arm = [x[0] - middle[0], x[1] - middle[1]];
        let before = (x[0] - u[0] - 0.5).hypot(x[1] - u[1] - 0.45);
        assert!((arm[0].hypot(arm[1]) - before).abs() < 1e-12);
        assert!(
            (v[0] - mean[0] + 8.0 * arm[1]).abs() < 1e-6 && (v[1] - mean[1] - 8.0 * arm[0]).abs() < 1e-6,
            "{v:?}"
        );
    }
}

#[test]
fn a_collision_of_a_rigid_block_keeps_momentum() {
    let mut flying = block([0.4, 0.43]);
    flying["velocity"] = json!({ "kind": "uniform", "value": [0.2, -2] });
    let report = free_block().with(json!({
        "bodies": [flying, { "name": "bed", "material": "soft", "shape": { "kind": "box", "min": [0.46, 0.2], "max": [0.76, 0.4] } }]
    })).solve(&Sph);
    let (before, after) = (report.start.momentum, report.end.momentum);
    for c in 0..2 {
        assert!((after[c] - before[c]).abs() < 1e-9 * 20.0, "{before:?} {after:?}");
    }
    // The bodies have collided.
    assert!(
        report.end.kinetic < 0.95 * report.start.kinetic,
        "{} {}",
        report.end.kinetic,
        report.start.kinetic
    );
}

#[test]
fn a_block_of_half_the_density_of_water_floats_with_half_of_it_under_water() {
    // A tank 0.8 m wide, filled 0.3 m deep around a block that is submerged by 0.08 m of its height of 0.1 m and rises.
    let part = |name: &str, min: [f64; 2], max: [f64; 2]| json!({ "name": name, "material": "water", "shape": { "kind": "box", "min": min, "max": max } });
    let report = free_block().with(json!({
        "gravity": [0, -9.81], "domain": { "min": [0, 0], "max": [0.8, 1] },
        "bodies": [part("left", [0.0, 0.0], [0.3, 0.3]), part("below", [0.3, 0.0], [0.5, 0.22]),
                   part("right", [0.5, 0.0], [0.8, 0.3]), block([0.3, 0.22])],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
                       { "side": "x-max", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "s", "duration": 3, "gravity_ramp": 0.5, "damping": 0.05,
                     "motions": [{ "target": "block", "velocity": [0, null] }] }]
    })).solve(&Sph);
    let of_block =
        report.snapshot.positions.iter().zip(&report.snapshot.bodies).filter(|(_, body)| **body == 3);
    let heights: Vec<f64> = of_block.map(|(x, _)| x[1]).collect();
    let middle = heights.iter().sum::<f64>() / heights.len() as f64;
    // Water of 0.224 m² and half of the block fill 0.8 m.
    let level = (0.8 * 0.3 - 0.2 * 0.08 + 0.5 * 0.2 * 0.1) / 0.8;
    // The surface for a particle is the middle between two rows: half a spacing.
    assert!((middle - level).abs() < 0.01, "{middle} {level}");
}

/// The reaction is the rate of momentum less weight and force, for free and for prescribed motion.
#[test]
fn reaction_of_a_rigid_body_equals_the_force_on_it() {
    let mut flying = block([0.4, 0.43]);
    flying["velocity"] = json!({ "kind": "uniform", "value": [0.2, -2] });
    let bed = json!({ "name": "bed", "material": "soft", "shape": { "kind": "box", "min": [0.46, 0.2], "max": [0.76, 0.4] } });
    for motion in [json!([null, null]), json!([0.2, -2])] {
        let free = motion[0].is_null();
        let case = free_block().with(json!({
            "gravity": [0, -5], "bodies": [flying.clone(), bed.clone()], "output": { "measures": 0.01 },
            "measures": { "push": { "kind": "reaction", "target": "block" } },
            "stages": [{ "name": "s", "duration": 0.05, "motions": [{ "target": "block", "velocity": motion, "force": if free { json!([3, 0]) } else { json!([0, 0]) }, "turns": true }] }]
        })).build();
        let report = solve(&Sph, &case);
        let impulse =
            |axis: &str| *report.table.column(&format!("push.impulse.{axis}")).unwrap().last().unwrap();
        let mass = &report.snapshot;
        let momentum = |body: u32| -> [f64; 2] {
            let masses = colluvium_testkit::scalars(mass, "mass");
            let all = vectors(mass, "velocity").into_iter().zip(masses).zip(&mass.bodies);
            all.filter(|(_, of)| **of == body)
                .fold([0.0; 2], |sum, ((v, m), _)| [sum[0] + m * v[0], sum[1] + m * v[1]])
        };
        // Of the block, 10 kg, and of the bed, 60 kg: velocities are half a step behind forces.
        let (block, bed) = (momentum(0), momentum(1));
        assert!(impulse("y") > 1.0, "{}", impulse("y"));
        for (c, axis) in ["x", "y"].into_iter().enumerate() {
            let bed_impulse = [0.0, 60.0 * -5.0 * 0.05][c] - bed[c];
            assert!(
                (impulse(axis) - bed_impulse).abs() < 0.01 * impulse("y"),
                "{axis}: {} {bed_impulse}",
                impulse(axis)
            );
            if free {
                let gained = block[c] - [2.0 + 3.0 * 0.05, -20.0 - 10.0 * 5.0 * 0.05][c];
                assert!(
                    (impulse(axis) - gained).abs() < 0.01 * impulse("y"),
                    "{axis}: {} {gained}",
                    impulse(axis)
                );
            }
        }
    }
}

#[test]
fn options_without_support_for_rigid_bodies_are_refused_by_key() {
    let refused = |more: Value| {
        Sph.plan(&free_block().with(more.clone()).build())
            .map_or_else(|error| error.to_string(), |_| String::new())
    };
    let euler = json!({ "methods": { "sph": { "spacing": 0.02, "integration": "predictor-corrector" } } });
    assert!(refused(euler).contains("leapfrog"));
    let periodic = json!({ "domain": { "min": [-1, -1], "max": [2, 2], "periodic": ["x"] } });
    assert!(refused(periodic).contains("rigid"));
    let mut solver = free_block().start(&Sph);
    solver.step(1e-4).unwrap();
}

/// Rigid box of 0.2 m × 0.12 m × 0.08 m in space; `more` adds keys to the case.
fn in_space(more: &Value) -> Case {
    case_with(
        json!({
            "title": "test", "space": "3d", "domain": { "min": [-1, -1, -1], "max": [1, 1, 1] }, "gravity": [0, 0, 0],
            "materials": { "rock": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 } },
            "bodies": [{ "name": "box", "material": "rock", "rigid": true,
                         "shape": { "kind": "box", "min": [-0.1, -0.06, -0.04], "max": [0.1, 0.06, 0.04] } }],
            "stages": [{ "name": "s", "duration": 0.3, "motions": [{ "target": "box", "velocity": [null, null, null], "turns": true }] }],
            "output": { "measures": 0.01 }, "methods": { "sph": { "spacing": 0.02, "time_step": 2e-4 } }
        }),
        more,
    )
}

/// Mass (kg) and moments of inertia (kg m²) of that box about its axes.
fn of_box() -> (f64, [f64; 3]) {
    let (m, [a, b, c]) = (2000.0 * 0.2 * 0.12 * 0.08, [0.2f64, 0.12, 0.08]);
    (m, [b * b + c * c, c * c + a * a, a * a + b * b].map(|squares| m * squares / 12.0))
}

#[test]
fn a_moment_spins_a_box_up_by_its_moment_of_inertia() {
    let (_, inertia) = of_box();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let mut moment = [0.0; 3];
        moment[axis] = 0.5;
        let report = solve(
            &Sph,
            &in_space(&json!({
                "stages": [{ "name": "s", "duration": 0.1,
                             "motions": [{ "target": "box", "velocity": [null, null, null], "moment": moment, "turns": true }] }]
            })),
        );
        let spin = *report.table.column(&format!("box.spin.{name}")).unwrap().last().unwrap();
        let exact = 0.5 * 0.1 / inertia[axis];
        assert!((spin / exact - 1.0).abs() < 1e-10, "{name}: {spin} {exact}");
        let kinetic = 0.5 * inertia[axis] * exact * exact;
        assert!((report.end.kinetic / kinetic - 1.0).abs() < 1e-6, "{} {kinetic}", report.end.kinetic);
        assert!((report.end.angular_momentum[axis] / 0.05 - 1.0).abs() < 1e-6);
    }
}

#[test]
fn a_free_box_in_space_keeps_its_angular_momentum_and_wobbles_with_its_energy() {
    let gradient = [[0.0, -6.0, 3.0], [6.0, 0.0, -5.0], [-3.0, 5.0, 0.0]];
    let run = |dt: f64| {
        let mut spinning = in_space(&json!({})).bodies[0].clone();
        spinning.velocity = Velocity::Linear {
            value: vec![0.3, 0.2, 0.1],
            origin: vec![0.0; 3],
            gradient: gradient.map(|row| row.to_vec()).to_vec(),
        };
        let report = solve(
            &Sph,
            &in_space(
                &json!({ "bodies": [spinning], "methods": { "sph": { "spacing": 0.02, "time_step": dt } } }),
            ),
        );
        let exact: [f64; 3] = std::array::from_fn(|c| of_box().1[c] * [5.0, 3.0, 6.0][c]);
        let size = exact.iter().map(|l| l * l).sum::<f64>().sqrt();
        for c in 0..3 {
            // The path of the centre adds none: it passes through the coordinate origin.
            let now = report.end.angular_momentum[c];
            assert!((now - exact[c]).abs() < 1e-9 * size, "{now} {}", exact[c]);
        }
        // Its rotation causes no stress.
        let stress =
            stresses(&report.snapshot).as_flattened().iter().fold(0.0f64, |largest, s| largest.max(s.abs()));
        assert!(stress < 1e-6, "{stress}");
        let x = &report.snapshot.positions;
        let corner = (0..3).map(|c| (x[0][c] - x[x.len() - 1][c]).powi(2)).sum::<f64>().sqrt();
        let start = (0.18f64.powi(2) + 0.1 * 0.1 + 0.06 * 0.06).sqrt();
        assert!((corner - start).abs() < 1e-12, "{corner} {start}");
        (report.end.kinetic / report.start.kinetic - 1.0).abs()
    };
    let [coarse, fine] = [4e-4, 2e-4].map(run);
    assert!(coarse < 1e-5 && fine < 0.3 * coarse, "{coarse} {fine}");
}

/// Rigid box on a floor under gravity inclined by the tangent `tan`, with friction, for 0.3 s.
fn on_slope(tan: f64, wall: &Value) -> (RunReport, [f64; 2]) {
    let g = 9.81 / (1.0 + tan * tan).sqrt();
    let report = solve(
        &Sph,
        &in_space(&json!({
            "gravity": [g * tan, 0, -g], "domain": { "min": [-0.2, -0.2, -0.04], "max": [1, 0.2, 0.4] },
            "boundaries": [{ "side": "z-min", "wall": wall }],
            "stages": [{ "name": "s", "duration": 0.3, "gravity_ramp": 0.05,
                         "motions": [{ "target": "box", "velocity": [null, null, null], "turns": true }] }],
            "output": { "measures": 0.01 }, "methods": { "sph": { "spacing": 0.02 } }
        })),
    );
    (report, [g * tan, g])
}

/// Mean rate of a column over the second half of the run.
fn late(report: &RunReport, column: &str) -> f64 {
    let pairs = report.table.pairs("time", column).unwrap();
    let (middle, last) = (pairs[pairs.len() / 2], pairs[pairs.len() - 1]);
    (last.1 - middle.1) / (last.0 - middle.0)
}

#[test]
fn a_box_slides_down_a_slope_in_space_by_coulombs_law() {
    for friction in [0.0, 0.3, 0.6] {
        let wall = json!({ "kind": "frictional", "friction_coefficient": friction });
        let smooth = json!({ "kind": "smooth" });
        let (report, [along, down]) = on_slope(0.5, if friction > 0.0 { &wall } else { &smooth });
        let exact = (along - friction * down).max(0.0);
        let found = late(&report, "box.velocity.x");
        assert!((found - exact).abs() < 1e-3 * along, "{friction}: {found} {exact}");
        assert!(report.table.column("box.spin.y").unwrap().last().unwrap().abs() < 1e-3);
    }
}

#[test]
fn a_slender_box_topples_down_a_slope_in_space_where_its_weight_passes_its_edge() {
    // 0.2 m high on 0.08 m: it topples beyond a tangent of 0.4.
    let tilts = [0.37, 0.5].map(|tan| {
        let g = 9.81;
        let tall = json!({ "name": "box", "material": "rock", "rigid": true,
                           "shape": { "kind": "box", "min": [-0.04, -0.06, 0.0], "max": [0.04, 0.06, 0.2] } });
        let report = solve(&Sph, &in_space(&json!({
            "gravity": [g * tan, 0, -g], "domain": { "min": [-0.2, -0.2, 0.0], "max": [1, 0.2, 0.4] }, "bodies": [tall],
            "boundaries": [{ "side": "z-min", "wall": { "kind": "frictional", "friction_coefficient": 1.0 } }],
            "stages": [{ "name": "s", "duration": 0.4, "gravity_ramp": 0.1,
                         "motions": [{ "target": "box", "velocity": [null, null, null], "turns": true }] }],
            "output": { "measures": 0.01 }, "methods": { "sph": { "spacing": 0.02 } }
        })));
        // Displacement of the top relative to the foot, over the height between them.
        let (x, moved) = (&report.snapshot.positions, vectors(&report.snapshot, "displacement"));
        let of = |level: f64| {
            let all = x.iter().zip(&moved).filter(|(x, u)| (x[2] - u[2] - level).abs() < 1e-9);
            let (sum, count) = all.fold((0.0, 0), |(sum, count), (_, u)| (sum + u[0], count + 1));
            sum / f64::from(count)
        };
        (of(0.19) - of(0.01)) / 0.18
    });
    assert!(tilts[0].abs() < 1e-4 && tilts[1] > 0.1, "{tilts:?}");
}

#[test]
fn impact_of_a_rotating_box_is_bit_identical_on_threads_and_after_a_restart() {
    let mut thrown = in_space(&json!({})).bodies[0].clone();
    let gradient = [[0.0, -6.0, 3.0], [6.0, 0.0, -5.0], [-3.0, 5.0, 0.0]];
    thrown.velocity = Velocity::Linear {
        value: vec![0.3, 0.0, -1.0],
        origin: vec![0.0; 3],
        gradient: gradient.map(|row| row.to_vec()).to_vec(),
    };
    let case = in_space(&json!({
        "bodies": [thrown], "gravity": [0, 0, -9.81], "domain": { "min": [-0.4, -0.2, -0.06], "max": [0.6, 0.2, 0.4] },
        "boundaries": [{ "side": "z-min", "wall": { "kind": "frictional", "friction_coefficient": 0.4 } }],
        "methods": { "sph": { "spacing": 0.02 } }
    }));
    let hash = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = start_solver(&Sph, &case);
            advance_steps(&mut *solver, 200);
            solver.snapshot().hash()
        })
    };
    assert_eq!(hash(1), hash(2));
    let mut whole = start_solver(&Sph, &case);
    advance_steps(&mut *whole, 100);
    let mut again = Sph.build(&case).unwrap();
    again.restore(&mut whole.checkpoint_bytes().unwrap().as_slice()).unwrap();
    for solver in [&mut whole, &mut again] {
        advance_steps(&mut **solver, 100);
    }
    assert_eq!(whole.snapshot().hash(), again.snapshot().hash());
    // It falls at 1 m/s and more until it hits the floor.
    let (rise, mass) = (whole.budget().unwrap().momentum[2], of_box().0);
    assert!(rise > -0.5 * mass, "{rise} {mass}");
}
