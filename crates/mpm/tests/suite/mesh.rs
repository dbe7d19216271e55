//! Triangles and tetrahedra: invariants, and invalid mesh files.

use std::fmt::Write as _;

use colluvium_case::{Case, Method, RunOptions, RunReport, Solver, run};
use colluvium_mpm::Mpm;
use colluvium_testkit::{CaseBuilder, solve, start_solver, stresses, vectors};
use serde_json::{Value, json};

/// Block of an elastic material that flies through triangles.
fn flying_block() -> CaseBuilder {
    CaseBuilder::from_json(json!({
        "title": "test", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [2, 1] }, "gravity": [0, 0],
        "materials": { "m": { "model": "neo-hookean", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0.3], "max": [0.6, 0.7] },
                     "velocity": { "kind": "uniform", "value": [6, 1] } }],
        "stages": [{ "name": "s", "duration": 0.2 }],
        "methods": { "mpm": { "cell_size": 0.1, "shape": "linear", "mesh": { "kind": "box" } } }
    }))
}

#[test]
fn a_body_in_free_flight_through_elements_has_no_stress() {
    // sheet: mpm A-04.
    for points in [1, 2, 3] {
        let report = flying_block().with(json!({
                "methods": { "mpm": { "cell_size": 0.1, "points_per_cell": points, "shape": "linear", "mesh": { "kind": "box" } } }
            })).solve(&Mpm);
        for u in vectors(&report.snapshot, "displacement") {
            assert!((u[0] - 1.2).abs() < 1e-11 && (u[1] - 0.2).abs() < 1e-11, "{points}: {u:?}");
        }
        let stress = stresses(&report.snapshot).iter().flatten().fold(0.0, |a: f64, s| a.max(s.abs()));
        assert!(stress < 1e-9 * 1e6, "{points}: {stress} Pa");
    }
}

/// A swinging ball in tetrahedra.
fn ball(scheme: &str) -> Case {
    flying_block().with(json!({
        "space": "3d", "domain": { "min": [0, 0, 0], "max": [1, 1, 1] }, "gravity": [0, 0, 0],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.5, 0.5, 0.5], "radius": 0.25 },
                     "velocity": { "kind": "linear", "value": [0.3, -0.2, 0.1], "origin": [0.5, 0.5, 0.5],
                                   "gradient": [[1, 0.4, 0], [-0.8, -1, 0.3], [0, 0.2, 0.5]] } }],
        "stages": [{ "name": "s", "duration": 0.1 }],
        "methods": { "mpm": { "cell_size": 0.125, "shape": "linear", "stress_update": scheme, "mesh": { "kind": "box" } } }
    })).build()
}

#[test]
fn mass_and_momentum_are_conserved_and_threads_change_no_bits() {
    // Not `usl`, which turns points inside out at nodes that little mass reaches, as it does with linear quadrilaterals.
    for scheme in ["musl", "usf"] {
        let case = ball(scheme);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| solve(&Mpm, &case))
        };
        let report = on(1);
        assert_eq!(report.snapshot.hash(), on(2).snapshot.hash(), "{scheme}");
        assert_eq!(report.end.mass, report.start.mass);
        for c in 0..3 {
            let change = report.end.momentum[c] - report.start.momentum[c];
            assert!(change.abs() < 1e-12 * report.start.mass, "{scheme}: {change}");
        }
    }
}

#[test]
fn a_restored_solver_continues_bit_identically() {
    let case = ball("musl");
    let advance = |solver: &mut dyn Solver, steps: usize| {
        for _ in 0..steps {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
        }
    };
    let mut whole = start_solver(&Mpm, &case);
    advance(&mut *whole, 23);
    let mut again = Mpm.build(&case).unwrap();
    again.restore(&mut whole.checkpoint_bytes().unwrap().as_slice()).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    advance(&mut *whole, 40);
    advance(&mut *again, 40);
    assert_eq!(whole.snapshot().hash(), again.snapshot().hash());
}

#[test]
fn the_time_step_depends_on_the_least_height() {
    // Right triangles with legs of 0.1 m: 2 A / l_max = 0.1 / √2.
    let still = json!({ "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0.3], "max": [0.6, 0.7] } }] });
    let mut solver = Mpm.build(&flying_block().with(still).build()).unwrap();
    let modulus: f64 = 1e6 * 0.75 / (1.25 * 0.5);
    let exact = 0.5 * 0.1 / 2f64.sqrt() / (modulus / 1000.0).sqrt();
    assert!((solver.limit().dt / exact - 1.0).abs() < 1e-9, "{}", solver.limit().dt);
}

/// A block above a floor that it has not reached yet.
fn falling(floor: bool) -> Result<RunReport, String> {
    let mut more = json!({
        "gravity": [0, -10],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.6, 0.5], "max": [1.2, 0.8] },
                     "velocity": { "kind": "uniform", "value": [0, -1] } }],
        "stages": [{ "name": "s", "duration": 0.4 }]
    });
    if floor {
        more["boundaries"] = json!([{ "side": "y-min", "position": 0.2, "wall": { "kind": "smooth" } }]);
    }
    let case = flying_block().with(more).build();
    run(&case, Mpm.build(&case).unwrap(), &RunOptions::default()).map_err(|error| error.to_string())
}

#[test]
fn walls_constrain_nodes_before_points_reach_them() {
    // sheet: mpm S-08: no deeper than an element; without the wall it falls through.
    let lowest =
        |report: &RunReport| report.snapshot.positions.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
    assert!(lowest(&falling(true).unwrap()) > 0.2 - 0.1);
    assert!(
        falling(false).map_or_else(|error| error.contains("left the mesh"), |report| lowest(&report) < 0.1)
    );
}

#[test]
fn stress_under_self_weight_at_rest_is_that_of_an_oedometer() {
    for (space, corner) in [("plane-strain", &[0.4, 1.0][..]), ("3d", &[0.2, 1.0, 0.2][..])] {
        let dimension = corner.len();
        let walls: Vec<Value> = ["x-min", "x-max", "y-min", "z-min", "z-max"]
            .iter()
            .filter(|side| dimension == 3 || !side.starts_with('z'))
            .map(|side| json!({ "side": side, "wall": { "kind": "smooth" } }))
            .collect();
        let mut gravity = vec![0.0; dimension];
        gravity[1] = -10.0;
        let mut high = corner.to_vec();
        high[1] += 0.2;
        let report = flying_block().with(json!({
                "space": space, "gravity": gravity, "boundaries": walls,
                "domain": { "min": vec![0.0; dimension], "max": high },
                "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.25 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": vec![0.0; dimension], "max": corner } }],
                "stages": [{ "name": "settle", "duration": 20, "damping": 0.7, "equilibrium": { "unbalanced_force": 1e-5, "kinetic_energy": 1e-5 } }]
            })).solve(&Mpm);
        let displacement = vectors(&report.snapshot, "displacement");
        for ((x, u), s) in report.snapshot.positions.iter().zip(&displacement).zip(stresses(&report.snapshot))
        {
            let vertical = -1000.0 * 10.0 * (1.0 - (x[1] - u[1]));
            // Constant in an element: the weight of one.
            assert!(
                (s[1] - vertical).abs() < 1000.0 * 10.0 * 0.1,
                "{space}: {} for {vertical} at {x:?}",
                s[1]
            );
        }
    }
}

#[test]
fn the_momentum_gain_by_a_traction_is_its_impulse() {
    let report = flying_block().with(json!({
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0.3], "max": [0.6, 0.7] } }],
            "loads": [{ "kind": "traction", "body": "b", "side": "x-max", "value": [200, -50] }],
            "stages": [{ "name": "s", "duration": 0.02 }]
        })).solve(&Mpm);
    assert!((report.end.momentum[0] - 200.0 * 0.4 * 0.02).abs() < 1e-10);
    assert!((report.end.momentum[1] + 50.0 * 0.4 * 0.02).abs() < 1e-10);
}

/// Displacement of the point next to the free corner of a square of `cells × cells` squares, held on the left and below
/// and under its own weight (m).
fn sagging(cells: u32, poissons_ratio: f64, volumetric: &str) -> f64 {
    let cell = 1.0 / f64::from(cells);
    let report = flying_block().with(json!({
            "domain": { "min": [0, 0], "max": [1.0 + cell, 1.0 + cell] }, "gravity": [0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": poissons_ratio } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "rough" } }, { "side": "y-min", "wall": { "kind": "rough" } }],
            "stages": [{ "name": "settle", "duration": 20, "damping": 0.7, "equilibrium": { "unbalanced_force": 1e-4, "kinetic_energy": 1e-4 } }],
            "methods": { "mpm": { "cell_size": cell, "shape": "linear", "mesh": { "kind": "box" }, "volumetric_strain": volumetric } }
        })).solve(&Mpm);
    let displacement = vectors(&report.snapshot, "displacement");
    let corner = |p: usize| report.snapshot.positions[p][0] + report.snapshot.positions[p][1];
    let nearest = (0..displacement.len()).max_by(|a, b| corner(*a).total_cmp(&corner(*b))).unwrap();
    displacement[nearest][0].hypot(displacement[nearest][1])
}

#[test]
fn shared_volumetric_strain_frees_a_patch_that_locks() {
    // sheet: mpm S-09: two triangles whose free node has nowhere to go, and a patch of 4 × 4 squares of them.
    let ratio = |cells, volumetric| sagging(cells, 0.4999, volumetric) / sagging(cells, 0.3, "point");
    assert!(ratio(1, "point") < 0.01);
    assert!(ratio(4, "point") < 0.01);
    assert!(ratio(4, "nodal") > 0.2);
}

#[test]
fn water_flows_in_triangles() {
    // sheet: mpm A-25 on coarse elements, with the free surface found: mass exact, energy not gained beyond 2 %, and the
    // front behind that of shallow water without friction, 2 √(gH) t.
    for integration in ["points", "mixed"] {
        let report = flying_block().with(json!({
                "domain": { "min": [0, 0], "max": [2, 1] }, "gravity": [0, -10],
                "materials": { "m": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e6, "viscosity": 1e-3 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.4, 0.8] },
                             "stress": { "kind": "k0", "surface": 0.8, "coefficient": 1 } }],
                "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-min", "wall": { "kind": "smooth" } }],
                "stages": [{ "name": "flow", "duration": 0.25 }],
                "methods": { "mpm": { "cell_size": 0.05, "shape": "linear", "mesh": { "kind": "box" }, "free_surface": 0.7,
                                      "integration": integration } }
            })).solve(&Mpm);
        let energy = |b: &colluvium_case::Budget| b.kinetic + b.potential + b.elastic;
        assert_eq!(report.end.mass, report.start.mass);
        let kept = energy(&report.end) / energy(&report.start);
        assert!(kept < 1.02, "{integration}: {kept}");
        let front = report.snapshot.positions.iter().map(|x| x[0]).fold(0.0, f64::max);
        let fastest = 0.4 + 2.0 * (10.0f64 * 0.8).sqrt() * 0.25;
        assert!(front > 0.8 && front < fastest, "{integration}: {front} for {fastest} at most");
    }
}

/// A rectangle of `nx × ny` squares of 0.25 m in two triangles each, as Gmsh 2.2, its base the group "base".
fn msh(nx: usize, ny: usize) -> String {
    let number = |i: usize, j: usize| i * (ny + 1) + j + 1;
    let mut text =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n1 3 \"base\"\n$EndPhysicalNames\n"
            .to_owned();
    writeln!(text, "$Nodes\n{}", (nx + 1) * (ny + 1)).unwrap();
    for i in 0..=nx {
        for j in 0..=ny {
            writeln!(text, "{} {} {} 0", number(i, j), 0.25 * i as f64, 0.25 * j as f64).unwrap();
        }
    }
    writeln!(text, "$EndNodes\n$Elements\n{}", nx + 2 * nx * ny).unwrap();
    for i in 0..nx {
        writeln!(text, "{} 1 2 3 1 {} {}", i + 1, number(i, 0), number(i + 1, 0)).unwrap();
        for j in 0..ny {
            let (a, b, c, d) = (number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1));
            writeln!(
                text,
                "{} 2 2 0 1 {a} {b} {c}\n{} 2 2 0 1 {a} {c} {d}",
                10_000 + 2 * (i * ny + j),
                10_001 + 2 * (i * ny + j)
            )
            .unwrap();
        }
    }
    text + "$EndElements\n"
}

#[test]
fn a_gmsh_file_supplies_mesh_and_wall_groups() {
    let folder = std::env::temp_dir().join(format!("colluvium-mesh-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("rectangle.msh"), msh(8, 4)).unwrap();
    let write = |wall: Value, file: &str| {
        let text = flying_block().with(json!({
            "gravity": [0, -10],
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.5, 0], "max": [1.5, 0.5] } }],
            "boundaries": [wall],
            "stages": [{ "name": "settle", "duration": 20, "damping": 0.7, "equilibrium": { "unbalanced_force": 1e-3, "kinetic_energy": 1e-3 } }],
            "methods": { "mpm": { "cell_size": 0.25, "shape": "linear", "mesh": { "kind": "file", "file": file } } }
        }));
        std::fs::write(folder.join("case.json"), text.json().to_string()).unwrap();
        Case::from_file(&folder.join("case.json")).unwrap()
    };
    let by_group = solve(
        &Mpm,
        &write(json!({ "side": "y-min", "group": "base", "wall": { "kind": "rough" } }), "rectangle.msh"),
    );
    let by_plane =
        solve(&Mpm, &write(json!({ "side": "y-min", "wall": { "kind": "rough" } }), "rectangle.msh"));
    assert_eq!(by_group.snapshot.hash(), by_plane.snapshot.hash());
    let refuse = |wall: Value, file: &str| Mpm.build(&write(wall, file)).map(|_| ()).unwrap_err().to_string();
    let rough = json!({ "kind": "rough" });
    let error = refuse(json!({ "side": "y-min", "group": "top", "wall": rough }), "rectangle.msh");
    assert!(error.contains("boundaries[0].group") && error.contains("[\"base\"]"), "{error}");
    let leaning = json!({ "side": "x-min", "group": "base", "wall": { "kind": "smooth" } });
    let error = refuse(leaning, "rectangle.msh");
    assert!(error.contains("boundaries[0].group") && error.contains("is not normal to the axis"), "{error}");
    let smooth = json!({ "side": "y-min", "group": "base", "wall": { "kind": "smooth" } });
    assert!(Mpm.build(&write(smooth, "rectangle.msh")).is_ok());
    let error = refuse(json!({ "side": "y-min", "position": 0.1, "wall": rough }), "rectangle.msh");
    assert!(error.contains("no node of the mesh lies on the wall"), "{error}");
    let error = refuse(json!({ "side": "y-min", "wall": rough }), "none.msh");
    assert!(error.contains("methods.mpm.mesh.file") && error.contains("cannot be read"), "{error}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn options_without_support_on_a_mesh_are_rejected_by_key() {
    for (key, value) in [
        ("shape", json!("ugimp")),
        ("shape", json!("quadratic")),
        ("shape", json!("cpdi")),
        ("transfer", json!("apic")),
        ("formulation", json!("total-lagrangian")),
        ("points_per_cell", json!(4)),
    ] {
        let case = flying_block().options("mpm", json!({ key: value })).build();
        let error = Mpm.build(&case).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(&format!("methods.mpm.{key}")), "{key} {value}: {error}");
    }
}
