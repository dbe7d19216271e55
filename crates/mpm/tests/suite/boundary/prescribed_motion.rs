//! Rigid bodies and patches of prescribed velocity (sheet: mpm §2.11, §3.6).

use std::collections::BTreeMap;

use colluvium_case::{Method, RunReport, Snapshot, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::{CaseBuilder, assert_same_on_threads, solve, start_solver, vectors, with_keys};
use serde_json::{Value, json};

/// Elastic block of 1 m on a smooth floor between smooth walls. The test adds the stages.
fn block_between_walls() -> CaseBuilder {
    CaseBuilder::plane_strain([0.0, 0.0], [1.0, 2.0])
        .elastic("m", 1000.0, 1e5, 0.0)
        .box_body("block", "m", &[0.0, 0.0], &[1.0, 1.0])
        .wall("y-min", "smooth")
        .wall("x-min", "smooth")
        .wall("x-max", "smooth")
        .options("mpm", json!({ "cell_size": 0.1, "courant": 0.4 }))
}

fn lid() -> Value {
    json!({ "name": "lid", "material": "m", "shape": { "kind": "box", "min": [0, 1], "max": [1, 1.2] }, "rigid": true })
}

fn block() -> Value {
    json!({ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } })
}

/// Mean force in the last tenth of the run, from the impulse.
fn late(report: &RunReport, impulse: &str) -> f64 {
    let pairs = report.table.pairs("time", impulse).unwrap();
    let [first, last] = [pairs[pairs.len() * 9 / 10], pairs[pairs.len() - 1]];
    (last.1 - first.1) / (last.0 - first.0)
}

/// A stage in which the lid presses the block by 1 % and stops, and one in which it rests.
fn press(of: &str) -> Value {
    json!([{ "name": "press", "duration": 1, "damping": 0.3,
             "motions": [{ "target": of, "velocity": [0, -0.0125], "ramp": 0.4 }] },
           { "name": "rest", "duration": 1, "damping": 0.5,
             "motions": [{ "target": of, "velocity": [0, 0] }] }])
}

#[test]
fn the_force_on_a_rigid_lid_is_that_of_the_oedometer() {
    // 1 % of strain of a modulus of 100 kPa on 1 m: 1 kN upward on the lid.
    for contacts in
        [json!([]), json!([{ "bodies": ["block", "lid"], "friction_coefficient": 0.2, "test": "gap" }])]
    {
        for scheme in ["usf", "usl", "musl"] {
            let case = block_between_walls().with(json!({
                "bodies": [block(), lid()],
                "stages": press("lid"),
                "measures": { "force": { "kind": "reaction", "target": "lid" } },
                "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4, "stress_update": scheme, "contacts": contacts } }
            })).build();
            let report = solve(&Mpm, &case);
            let force = late(&report, "force.impulse.y");
            // The lid holds the nodes at its face, which the surface of the block leaves by 1 % of its height.
            assert!((force / 1000.0 - 1.0).abs() < 0.03, "{contacts}, {scheme}: {force}");
            assert!(late(&report, "force.impulse.x").abs() < 1.0, "{scheme}");
            let displacements = vectors(&report.snapshot, "displacement");
            let lid = displacements.iter().zip(&report.snapshot.bodies).filter(|(_, b)| **b == 1);
            assert!(lid.into_iter().all(|(u, _)| u[0] == 0.0 && (u[1] + 0.01).abs() < 1e-4));
        }
    }
}

#[test]
fn an_idle_patch_changes_nothing_at_walls() {
    // A block that slides on a frictional floor, damped; the patch is far above it.
    for nodes in ["force", "momentum"] {
        let ends = [false, true].map(|patch| {
            let mut more = json!({
                "gravity": [2, -10],
                "domain": { "min": [0, 0], "max": [3, 2] },
                "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.1 } }],
                "stages": [{ "name": "s", "duration": 0.2, "damping": 0.3 }],
                "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4, "fixed_nodes": nodes } }
            });
            if patch {
                more["patches"] = json!([{ "name": "idle", "region": { "kind": "box", "min": [2.5, 1.8], "max": [3, 2] } }]);
            }
            vectors(&block_between_walls().with(more).solve(&Mpm).snapshot, "displacement")
        });
        for (alone, with_patch) in ends[0].iter().zip(&ends[1]) {
            assert!(
                (0..2).all(|c| (alone[c] - with_patch[c]).abs() < 1e-9),
                "{nodes}: {alone:?}, {with_patch:?}"
            );
        }
    }
}

#[test]
fn a_plate_over_a_whole_period_moves_all_of_its_nodes() {
    // A-26 with the upper plate as a patch: nodes beyond the side and the images of nodes go along.
    for shape in ["linear", "ugimp"] {
        let flow = |region: [f64; 2]| {
            let case = block_between_walls().with(json!({
                "domain": { "min": [0, 0], "max": [0.3, 1], "periodic": ["x"] },
                "materials": { "m": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 4e5, "viscosity": 1000,
                                      "cavitation_strength": 4e5 } },
                "bodies": [{ "name": "oil", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.3, 1] } }],
                "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }, { "side": "y-max", "wall": { "kind": "smooth" } }],
                "patches": [{ "name": "plate", "region": { "kind": "box", "min": [region[0], 1], "max": [region[1], 1.2] } }],
                "measures": { "force": { "kind": "reaction", "target": "plate" } },
                "stages": [{ "name": "flow", "duration": 0.5, "motions": [{ "target": "plate", "velocity": [1, 0] }] }],
                "methods": { "mpm": { "cell_size": 0.1, "shape": shape } }
            })).build();
            solve(&Mpm, &case)
        };
        let report = flow([0.0, 0.3]);
        // Steady: 1000 Pa on 0.3 m.
        let force = late(&report, "force.impulse.x");
        assert!((force / -300.0 - 1.0).abs() < 0.02, "{shape}: {force}");
        let wider = flow([-0.2, 0.5]);
        for ((x, v), w) in report
            .snapshot
            .positions
            .iter()
            .zip(vectors(&report.snapshot, "velocity"))
            .zip(vectors(&wider.snapshot, "velocity"))
        {
            assert!((v[0] - x[1]).abs() < 0.01 && v[1].abs() < 1e-9, "{shape}: {v:?} at {x:?}");
            assert!((0..2).all(|c| (v[c] - w[c]).abs() < 1e-12), "{shape}: {v:?}, {w:?}");
        }
    }
}

/// The largest difference of velocity (m/s) within a row of points.
fn unevenness(snapshot: &Snapshot) -> f64 {
    let velocities = vectors(snapshot, "velocity");
    let mut rows: BTreeMap<i64, [[f64; 2]; 2]> = BTreeMap::new();
    for ((x, body), v) in
        snapshot.positions.iter().zip(&snapshot.bodies).zip(&velocities).filter(|((_, b), _)| **b == 0)
    {
        let row =
            rows.entry((x[1] * 1e6).round() as i64).or_insert([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]]);
        for c in 0..2 {
            row[0][c] = row[0][c].min(v[c]);
            row[1][c] = row[1][c].max(v[c]);
        }
        assert!(*body == 0);
    }
    rows.values().flat_map(|[low, high]| (0..2).map(|c| high[c] - low[c])).fold(0.0, f64::max)
}

#[test]
fn a_rigid_plate_from_wall_to_wall_compresses_uniformly() {
    // Nodes at the sides have half of the volume of others, and are held with them.
    for shape in ["linear", "ugimp", "quadratic"] {
        let case = block_between_walls().with(json!({
            "bodies": [block(), lid()],
            "stages": [{ "name": "press", "duration": 0.4, "motions": [{ "target": "lid", "velocity": [0, -0.3] }] }],
            "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4, "shape": shape } }
        })).build();
        let mut solver = start_solver(&Mpm, &case);
        while solver.time() < 0.4 {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
            let uneven = unevenness(&solver.snapshot());
            assert!(uneven < 1e-9, "{shape}: {uneven} at {}", solver.time());
        }
    }
}

#[test]
fn a_rigid_plate_over_a_whole_period_drags_evenly() {
    for shape in ["linear", "ugimp", "cpgimp"] {
        let reactions = [0.6, 1.2].map(|width| {
            let flow = block_between_walls().with(json!({
                "domain": { "min": [0, 0], "max": [width, 1.4], "periodic": ["x"] },
                "materials": { "m": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 4e5, "viscosity": 1000,
                                      "cavitation_strength": 4e5 } },
                "bodies": [{ "name": "oil", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [width, 1] } },
                           { "name": "lid", "material": "m", "shape": { "kind": "box", "min": [0, 1], "max": [width, 1.2] }, "rigid": true }],
                "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
                "measures": { "force": { "kind": "reaction", "target": "lid" } },
                "stages": [{ "name": "flow", "duration": 0.5, "motions": [{ "target": "lid", "velocity": [1, 0] }] }],
                "methods": { "mpm": { "cell_size": 0.1, "shape": shape } }
            })).build();
            let report = solve(&Mpm, &flow);
            let uneven = unevenness(&report.snapshot);
            assert!(uneven < 1e-9, "{shape}, {width}: {uneven}");
            late(&report, "force.impulse.x") / width
        });
        // Steady: 1000 Pa, whatever the width.
        assert!((reactions[0] / reactions[1] - 1.0).abs() < 1e-6, "{shape}: {reactions:?}");
        assert!((reactions[0] / -1000.0 - 1.0).abs() < 0.02, "{shape}: {reactions:?}");
    }
}

#[test]
fn a_moving_rough_wall_drives_linear_shear_flow_of_a_viscous_liquid() {
    // A-26, steady: the speed of a point is its height, to the last row under the wall.
    for scheme in ["usf", "usl", "musl"] {
        let flow = block_between_walls().with(json!({
            "domain": { "min": [0, 0], "max": [0.3, 1], "periodic": ["x"] },
            "materials": { "m": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 4e5, "viscosity": 1000,
                                  "cavitation_strength": 4e5 } },
            "bodies": [{ "name": "oil", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.3, 1] } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } },
                           { "side": "y-max", "wall": { "kind": "rough" }, "velocity": [1, 0] }],
            "stages": [{ "name": "flow", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 0.1, "stress_update": scheme } }
        })).build();
        let snapshot = solve(&Mpm, &flow).snapshot;
        for (x, v) in snapshot.positions.iter().zip(vectors(&snapshot, "velocity")) {
            assert!((v[0] - x[1]).abs() < 0.02, "{scheme}: {v:?} at {x:?}");
        }
    }
}

#[test]
fn a_rigid_plate_compresses_points_in_the_small_displacement_formulation() {
    // Displacement of more than a cell: the plate acts on the surface at its initial position.
    let case = block_between_walls().with(json!({
        "bodies": [block(), lid()],
        "stages": [{ "name": "press", "duration": 1, "damping": 0.5, "motions": [{ "target": "lid", "velocity": [0, -0.3], "ramp": 0.2 }] }],
        "measures": { "force": { "kind": "reaction", "target": "lid" } },
        "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4, "formulation": "small-displacement" } }
    })).build();
    let report = solve(&Mpm, &case);
    let lid: Vec<[f64; 3]> = report
        .snapshot
        .positions
        .iter()
        .zip(&report.snapshot.bodies)
        .filter(|(_, body)| **body == 1)
        .map(|(x, _)| *x)
        .collect();
    assert!(lid.iter().all(|x| x[1] > 1.0), "it stays as the points do");
    let displacements = vectors(&report.snapshot, "displacement");
    let displacement =
        displacements.iter().zip(&report.snapshot.bodies).find(|(_, body)| **body == 1).unwrap().0[1];
    assert!((displacement + 0.27).abs() < 1e-3, "{displacement}");
    // On a grid that stays, a rate w of the block of 1 m makes the stress E w and the volume exp(-w): in the last tenth.
    let (force, mean) = (late(&report, "force.impulse.y"), 0.255f64);
    let exact = 1e5 * mean * (-mean).exp();
    assert!((force / exact - 1.0).abs() < 0.05, "{force} instead of {exact}");
}

#[test]
fn the_force_on_a_rigid_lid_on_meshes_is_that_of_the_oedometer() {
    let slides = json!([{ "bodies": ["block", "lid"], "friction_coefficient": 0.2, "normal": [0, 1] }]);
    for (scheme, contacts) in [("usl", json!([])), ("musl", json!([])), ("musl", slides)] {
        let case = block_between_walls().with(json!({
            "bodies": [block(), lid()],
            "stages": press("lid"),
            "measures": { "force": { "kind": "reaction", "target": "lid" } },
            "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4, "shape": "linear", "mesh": { "kind": "box" },
                                  "stress_update": scheme, "contacts": contacts } }
        })).build();
        let force = late(&solve(&Mpm, &case), "force.impulse.y");
        assert!((force / 1000.0 - 1.0).abs() < 0.03, "{contacts}, {scheme}: {force}");
    }
    // A column of 0.3 m x 0.3 m: 90 N.
    let corner = |low: f64, high: f64| json!({ "kind": "box", "min": [0, 0, low], "max": [0.3, 0.3, high] });
    let sides: Vec<Value> = ["x-min", "x-max", "y-min", "y-max", "z-min"]
        .map(|side| json!({ "side": side, "wall": { "kind": "smooth" } }))
        .into();
    let mut stages = press("lid");
    stages.as_array_mut().unwrap().iter_mut().for_each(|stage| {
        let down = stage["motions"][0]["velocity"][1].take();
        stage["motions"][0]["velocity"] = json!([0, 0, down]);
    });
    let case = block_between_walls().with(json!({
        "space": "3d", "domain": { "min": [0, 0, 0], "max": [0.3, 0.3, 1.3] }, "gravity": [0, 0, 0],
        "bodies": [{ "name": "block", "material": "m", "shape": corner(0.0, 1.0) },
                   { "name": "lid", "material": "m", "shape": corner(1.0, 1.2), "rigid": true }],
        "boundaries": sides,
        "stages": stages,
        "measures": { "force": { "kind": "reaction", "target": "lid" } },
        "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4, "shape": "linear", "mesh": { "kind": "box" },
                              "stress_update": "musl" } }
    })).build();
    let force = late(&solve(&Mpm, &case), "force.impulse.z");
    assert!((force / 90.0 - 1.0).abs() < 0.03, "tetrahedra: {force}");
}

#[test]
fn a_rigid_body_that_leaves_is_an_error() {
    for mesh in [json!({ "kind": "box" }), Value::Null] {
        let case = block_between_walls().with(json!({
            "bodies": [block(), { "name": "lid", "material": "m", "shape": { "kind": "box", "min": [0, 1.2], "max": [1, 1.6] },
                                  "rigid": true }],
            "stages": [{ "name": "up", "duration": 1, "motions": [{ "target": "lid", "velocity": [0, 1] }] }],
            "methods": { "mpm": { "cell_size": 0.2, "shape": "linear", "mesh": mesh } }
        })).build();
        let mut solver = start_solver(&Mpm, &case);
        let error = loop {
            let step = solver.limit().dt;
            if let Err(error) = solver.step(step) {
                break error.to_string();
            }
            assert!(solver.time() < 1.0, "no error");
        };
        let place = if mesh.is_null() { "left the domain" } else { "left the mesh" };
        assert!(error.contains(place), "{error}");
    }
}

#[test]
fn the_force_on_a_patch_is_that_of_the_oedometer() {
    let mesh =
        |scheme: &str| json!({ "mesh": { "kind": "box" }, "shape": "linear", "stress_update": scheme });
    for (moves, more) in [
        (false, json!({ "stress_update": "musl" })),
        (true, json!({ "stress_update": "usl" })),
        (false, json!({ "stress_update": "usf" })),
        (false, mesh("musl")),
        (true, mesh("usf")),
    ] {
        let options = with_keys(json!({ "cell_size": 0.1, "courant": 0.4 }), &more);
        let case = block_between_walls().with(json!({
            "patches": [{ "name": "lid", "region": { "kind": "box", "min": [0, 1], "max": [1, 1.2] }, "moves": moves }],
            "stages": press("lid"),
            "measures": { "force": { "kind": "reaction", "target": "lid" } },
            "methods": { "mpm": options }
        })).build();
        let force = late(&solve(&Mpm, &case), "force.impulse.y");
        assert!((force / 1000.0 - 1.0).abs() < 0.03, "{moves}, {more}: {force}");
    }
}

#[test]
fn the_impulse_on_a_patch_is_that_on_the_material() {
    // The patch accelerates all nodes of the block from rest to 0.05 m/s and holds that velocity: ramped and at once, with either
    // treatment of fixed nodes.
    for (ramp, fixed) in [(0.2, "force"), (0.0, "force"), (0.2, "momentum")] {
        let case = block_between_walls().with(json!({
            "boundaries": [],
            "patches": [{ "name": "hand", "region": { "kind": "box", "min": [0, 0], "max": [1, 2] } }],
            "stages": [{ "name": "s", "duration": 0.5, "motions": [{ "target": "hand", "velocity": [null, 0.05], "ramp": ramp }] }],
            "measures": { "force": { "kind": "reaction", "target": "hand" } },
            "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4, "fixed_nodes": fixed } }
        })).build();
        let report = solve(&Mpm, &case);
        let momentum = report.end.momentum[1] - report.start.momentum[1];
        let impulse = report.table.pairs("time", "force.impulse.y").unwrap().last().unwrap().1;
        assert!((momentum - 50.0).abs() < 1e-9, "{fixed}, ramp {ramp}: {momentum}");
        assert!((momentum + impulse).abs() < 1e-9, "{fixed}, ramp {ramp}: {momentum} {impulse}");
    }
}

#[test]
fn patch_force_on_a_yielding_column_is_its_strength_at_any_speed() {
    // Tresca's column between smooth ends in plane strain carries 2 c_u. Points next to the patch move with it: their lag in
    // velocity causes no force.
    for speed in [0.01, 0.05] {
        let case = block_between_walls().with(json!({
            "domain": { "min": [0, 0], "max": [2, 1] },
            "materials": { "m": { "model": "tresca", "density": 2000, "youngs_modulus": 5e6, "poissons_ratio": 0.3,
                                  "undrained_strength": 10000 } },
            "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-min", "wall": { "kind": "smooth" } }],
            "patches": [{ "name": "lid", "region": { "kind": "box", "min": [0, 1], "max": [1, 1.1] } }],
            "stages": [{ "name": "s", "duration": 0.02 / speed,
                         "motions": [{ "target": "lid", "velocity": [null, -speed], "ramp": 0.1 }] }],
            "measures": { "force": { "kind": "reaction", "target": "lid" } },
            "output": { "measures": 0.002 / speed },
            "methods": { "mpm": { "cell_size": 0.1, "shape": "linear", "volumetric_strain": "cell-average",
                                  "formulation": "small-displacement" } }
        })).build();
        let force = late(&solve(&Mpm, &case), "force.impulse.y");
        // Waves go up and down meanwhile.
        assert!((force / 20_000.0 - 1.0).abs() < 0.04, "{speed}: {force}");
    }
}

#[test]
fn the_impulse_on_a_rigid_body_is_the_momentum_that_the_material_loses() {
    // A block thrown at a rigid plate in the air.
    for friction in [0.0, 0.4] {
        let case = block_between_walls().with(json!({
            "bodies": [
                { "name": "ball", "material": "m", "shape": { "kind": "box", "min": [0.3, 0.5], "max": [0.7, 0.8] },
                  "velocity": { "kind": "uniform", "value": [0.1, 0.3] } },
                { "name": "lid", "material": "m", "shape": { "kind": "box", "min": [0, 1], "max": [1, 1.2] }, "rigid": true }],
            "boundaries": [],
            "stages": [{ "name": "s", "duration": 1 }],
            "measures": { "force": { "kind": "reaction", "target": "lid" } },
            "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4,
                                  "contacts": [{ "bodies": ["ball", "lid"], "friction_coefficient": friction,
                                                 "normal": [0, 1], "test": "gap" }] } }
        })).build();
        let report = solve(&Mpm, &case);
        let momentum = [0, 1].map(|c| report.start.momentum[c] - report.end.momentum[c]);
        let impulse = ["force.impulse.x", "force.impulse.y"]
            .map(|m| report.table.pairs("time", m).unwrap().last().unwrap().1);
        for c in 0..2 {
            assert!((momentum[c] - impulse[c]).abs() < 1e-9 * report.start.mass, "{momentum:?} {impulse:?}");
        }
        // The block is stopped and rebounds, less the oscillation that remains in its three cells.
        assert!(impulse[1] > 0.3 * 120.0 && impulse[1] < 2.0 * 0.3 * 120.0, "{impulse:?}");
        let friction_impulse = friction * impulse[1];
        assert!(
            impulse[0] <= friction_impulse + 1e-9 && impulse[0] >= (0.9 * friction_impulse).min(10.0),
            "{impulse:?}"
        );
    }
}

#[test]
fn driven_runs_are_the_same_on_two_threads_and_after_a_restart() {
    let case = block_between_walls().with(json!({
        "bodies": [block(), lid()],
        "patches": [{ "name": "foot", "region": { "kind": "box", "min": [0, 0.4], "max": [0.3, 0.6] }, "moves": true }],
        "stages": [{ "name": "s", "duration": 0.2, "motions": [
            { "target": "lid", "velocity": [0.01, -0.05], "ramp": 0.1 }, { "target": "foot", "velocity": [null, 0.02] }] }],
    })).build();
    assert_same_on_threads(&Mpm, &case, "driven block");
    let advance = |solver: &mut dyn Solver| {
        for _ in 0..40 {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
        }
    };
    let mut whole = start_solver(&Mpm, &case);
    advance(&mut *whole);
    let mut again = Mpm.build(&case).unwrap();
    again.restore(&mut whole.checkpoint_bytes().unwrap().as_slice()).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    advance(&mut *whole);
    advance(&mut *again);
    assert_eq!(whole.snapshot().hash(), again.snapshot().hash());
    assert_eq!(whole.reaction("lid"), again.reaction("lid"));
}

#[test]
fn a_patch_without_nodes_causes_a_warning() {
    let patch = |low: f64, high: f64| {
        let case = block_between_walls().with(json!({
            "patches": [{ "name": "plate", "region": { "kind": "box", "min": [0.2, low], "max": [0.8, high] } }],
            "stages": [{ "name": "s", "duration": 0.1, "motions": [{ "target": "plate", "velocity": [0, -0.01] }] }]
        })).build();
        Mpm.plan(&case).unwrap().warnings
    };
    assert!(
        patch(1.02, 1.08)
            .iter()
            .any(|warning| warning.text.starts_with("patches[0].region: contains no node at the start"))
    );
    assert!(patch(1.02, 1.12).is_empty());
}
