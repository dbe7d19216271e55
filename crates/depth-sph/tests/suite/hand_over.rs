//! Nodes from the points of another method (sheet: depth-sph §3.2, 4).

use colluvium_case::{Case, CaseError, Method, PointList, Snapshot};
use colluvium_depth_sph::{DepthSph, point_stacks};
use colluvium_testkit::read_case;
use serde_json::json;

/// Cloud of points a quarter of a metre apart, 4 m by 3 m and 2 m high, that moves faster at its top.
fn cloud(folder: &std::path::Path) -> [f64; 4] {
    let mut text = "# from another run\nx (m),y (m),z (m),volume (m3),velocity_x (m/s)\n".to_owned();
    let mut sums = [0.0; 4];
    for i in 0..16 {
        for j in 0..12 {
            for k in 0..8 {
                let [x, y, z] = [i, j, k].map(|n| 0.25 * (f64::from(n) + 0.5));
                let volume = 0.25f64.powi(3) * (1.0 + 0.1 * (x + z).sin());
                let velocity = 1.0 + z;
                text += &format!("{},{},{z},{volume},{velocity}\n", x + 1.0, y + 2.0);
                let own = [1.0, x + 1.0, y + 2.0, velocity];
                (0..4).for_each(|c| sums[c] += volume * own[c]);
            }
        }
    }
    std::fs::write(folder.join("points.csv"), text).unwrap();
    sums
}

fn case(folder: &std::path::Path, phases: &str) -> Result<Case, String> {
    let value = json!({
        "title": "hand-over", "space": "3d", "domain": { "min": [0, 0, 0], "max": [20, 10, 5] }, "gravity": [0, 0, -9.81],
        "materials": { "debris": {
            "model": "mohr-coulomb", "density": 1990, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "failed", "material": "debris", "points": { "file": "points.csv" },
            "shape": { "kind": "box", "min": [0, 0, 0], "max": [8, 8, 4] } }],
        "boundaries": [{ "side": "z-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "run-out", "duration": 1 }],
        "methods": { "depth-sph": { "spacing": 0.5, "phases": phases,
            "mixture": { "grain_density": 2650, "porosity": 0.4, "drag": { "law": "anderson", "settling_velocity": 0.05 } } } }
    });
    Case::from_value(&value, folder).map_err(|errors| errors.to_string())
}

#[test]
fn points_transfer_their_volume_centre_of_mass_and_momentum() {
    let folder = tempfile::tempdir().unwrap();
    let sums = cloud(folder.path());
    for phases in ["one", "two"] {
        let mut solver = DepthSph.build(&case(folder.path(), phases).unwrap()).unwrap();
        solver.begin_stage(0, 0.0).unwrap();
        let snapshot = solver.snapshot();
        let (volume, velocity) = (snapshot.scalars("volume").unwrap(), snapshot.vectors("velocity").unwrap());
        let mut found = [0.0; 4];
        for (i, x) in snapshot.positions.iter().enumerate() {
            let own = [1.0, x[0], x[1], velocity[i][0]];
            (0..4).for_each(|c| found[c] += volume[i] * own[c]);
        }
        for (found, exact) in found.iter().zip(sums) {
            assert!((found / exact - 1.0).abs() < 1e-12, "{phases}: {found} for {exact}");
        }
        assert_eq!(snapshot.positions.len(), if phases == "one" { 48 } else { 96 }, "a node for each square");
        let depth = snapshot.scalars("depth").unwrap();
        let middle =
            snapshot.positions.iter().position(|x| (x[0] - 3.0).abs() < 0.3 && (x[1] - 3.5).abs() < 0.3);
        assert!((depth[middle.unwrap()] - 2.0).abs() < 0.2, "{}", depth[middle.unwrap()]);
    }
}

/// Writes points with their pore pressures.
fn write(folder: &std::path::Path, list: &PointList) {
    let mut text = "x (m),y (m),z (m),volume (m3),pore_pressure (Pa)\n".to_owned();
    for (i, x) in list.positions.iter().enumerate() {
        let pressure = list.pore_pressures.as_ref().unwrap()[i];
        text += &format!("{:?},{:?},{:?},{:?},{pressure:?}\n", x[0], x[1], x[2], list.volumes[i]);
    }
    std::fs::write(folder.join("points.csv"), text).unwrap();
}

/// Case and snapshot from the points of the file, with columns.
fn handed(folder: &std::path::Path, phases: &str) -> (Case, Snapshot) {
    let mut value = serde_json::to_value(case(folder, phases).unwrap()).unwrap();
    value["bodies"][0]["points"]["file"] = json!("points.csv");
    value["methods"]["depth-sph"]["column"] = json!({ "consolidation": 0.01 });
    let case = Case::from_value(&value, folder).unwrap();
    let mut solver = DepthSph.build(&case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    (case, solver.snapshot())
}

/// Block of points 2 m high, with the pore pressure of water up to their surface and `excess` (Pa) of the height over the depth.
fn block(excess: impl Fn(f64) -> f64) -> PointList {
    let mut list = PointList { pore_pressures: Some(Vec::new()), ..PointList::default() };
    for (i, j, k) in (0..32).flat_map(|i| (0..24).flat_map(move |j| (0..16).map(move |k| (i, j, k)))) {
        let [x, y, z] = [i, j, k].map(|n| 0.125 * (f64::from(n) + 0.5));
        list.positions.push([x + 1.0, y + 2.0, z]);
        list.volumes.push(0.125f64.powi(3));
        list.pore_pressures.as_mut().unwrap().push(9810.0 * (2.0 - z) + excess(0.5 * z));
    }
    list
}

/// Base and mean of the excess pressure of the nodes in the middle (Pa), and their depths (m).
fn inner(snapshot: &Snapshot) -> Vec<[f64; 3]> {
    let names = ["excess_pore_pressure", "mean_excess_pore_pressure", "depth"];
    let columns = names.map(|name| snapshot.scalars(name).unwrap());
    let is_inner = |i: &usize| {
        let x = snapshot.positions[*i];
        (x[0] - 3.0).abs() < 0.8 && (x[1] - 3.5).abs() < 0.6 && columns[0][*i].is_finite()
    };
    let found: Vec<_> =
        (0..snapshot.positions.len()).filter(is_inner).map(|i| columns.map(|column| column[i])).collect();
    assert!(found.len() >= 4);
    found
}

#[test]
fn pore_pressure_is_transferred_and_recovered() {
    let linear = |zeta: f64| 6e3 * (1.0 - zeta);
    let parabola = |zeta: f64| 6e3 * (1.0 - zeta * zeta);
    // The mean of the points of a parabola is that of sixteen layers.
    let profiles: [(&dyn Fn(f64) -> f64, f64); 2] = [(&linear, 3e3), (&parabola, 4e3 * (1.0 + 1.0 / 2048.0))];
    for phases in ["one", "two"] {
        // Of grains and fluid the porosity is that of sums over nodes.
        let close = if phases == "one" { 1e-9 } else { 1e-3 };
        for (excess, mean) in profiles {
            let folder = tempfile::tempdir().unwrap();
            write(folder.path(), &block(excess));
            let (case, first) = handed(folder.path(), phases);
            let there = inner(&first);
            for [base, of_depth, _] in &there {
                assert!((of_depth / mean - 1.0).abs() < close, "{phases}: mean {of_depth} for {mean}");
                assert!((base / 6e3 - 1.0).abs() < 0.005, "{phases}: base {base}");
            }
            let back = point_stacks(&case, &first).unwrap();
            let (all, volume) = (back.pore_pressures.as_ref().unwrap(), &back.volumes);
            let whole: f64 = volume.iter().sum();
            assert!((whole / 24.0 - 1.0).abs() < 1e-12, "{phases}: {whole} m³");
            assert!(all.len() > 2 * 48, "stacks of {} points", all.len());
            write(folder.path(), &back);
            for (before, after) in there.iter().zip(inner(&handed(folder.path(), phases).1)) {
                assert!((after[2] / before[2] - 1.0).abs() < close, "{phases}: depth {after:?} {before:?}");
                assert!(
                    (after[1] / before[1] - 1.0).abs() < 2.0 * close,
                    "{phases}: mean {after:?} {before:?}"
                );
                // There are three or four points in a stack: for a parabola they have means of layers.
                let bound = if (mean - 3e3).abs() < 1.0 { 2.0 * close } else { 0.02 };
                assert!((after[0] / before[0] - 1.0).abs() < bound, "{phases}: base {after:?} {before:?}");
            }
        }
    }
}

#[test]
fn pore_pressure_above_the_weight_is_limited_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &block(|zeta| 40e3 * (1.0 - zeta)));
    let (case, snapshot) = handed(folder.path(), "one");
    let warnings = DepthSph.plan(&case).unwrap().warnings;
    assert!(
        warnings.iter().any(|warning| warning.text.starts_with("bodies: the initial pore pressure of")),
        "{warnings:?}"
    );
    for liquefaction in snapshot.scalars("liquefaction").unwrap() {
        assert!((liquefaction - 1.0).abs() < 1e-12, "{liquefaction}");
    }
    let without = DepthSph.plan(&self::case(folder.path(), "one").unwrap()).unwrap().warnings;
    assert!(
        without.iter().any(|warning| warning.text.contains("the pore pressures are ignored")),
        "{without:?}"
    );
}

#[test]
fn files_without_a_list_of_points_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("points.csv"), "x,y,z,volume\n1,1,1,-1\n").unwrap();
    let refused = |case: Case| -> CaseError { DepthSph.plan(&case).map(|_| ()).unwrap_err() };
    let problem = refused(case(folder.path(), "one").unwrap()).to_string();
    assert!(
        problem.starts_with("bodies[0].points.file: ") && problem.contains("must be positive"),
        "{problem}"
    );
}

/// Grains and fluid that have spread apart are exported with all of their mass and momentum; fluid without grains nearby is reported by
/// the missing mass.
#[test]
fn separately_moving_fluid_is_transferred_with_the_grains_around_it() {
    let folder = tempfile::tempdir().unwrap();
    cloud(folder.path());
    let case = case(folder.path(), "two").unwrap();
    let mut solver = DepthSph.build(&case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    for _ in 0..120 {
        solver.step(1.0).unwrap();
    }
    let mut snapshot = solver.snapshot();
    let sums = |masses: &[f64], velocities: &[[f64; 3]]| {
        let momentum = |c: usize| masses.iter().zip(velocities).map(|(mass, v)| mass * v[c]).sum::<f64>();
        [masses.iter().sum::<f64>(), momentum(0), momentum(1)]
    };
    let of_list = |list: &PointList| sums(list.masses.as_ref().unwrap(), list.velocities.as_ref().unwrap());
    let of_frame =
        |frame: &Snapshot| sums(frame.scalars("mass").unwrap(), frame.vectors("velocity").unwrap());
    let (handed, whole) = (of_list(&point_stacks(&case, &snapshot).unwrap()), of_frame(&snapshot));
    let phase = snapshot.scalars("phase").unwrap().to_vec();
    let depth = snapshot.scalars("depth").unwrap();
    let height = snapshot.scalars("height").unwrap();
    let mut shares = (0..phase.len()).filter(|i| phase[*i] == 0.0).map(|i| 1.0 - height[i] / depth[i]);
    assert!(shares.any(|porosity| (porosity - 0.4).abs() > 0.01), "they have moved apart");
    // Nothing moves along y on the whole.
    let size = whole[1];
    for (handed, whole) in handed.iter().zip(whole) {
        let size = whole.abs().max(size);
        assert!((handed - whole).abs() < 1e-12 * size, "{handed} of {whole}");
    }
    let alone = phase.iter().position(|phase| *phase == 1.0).unwrap();
    snapshot.positions[alone][0] += 1e3;
    let kept = of_list(&point_stacks(&case, &snapshot).unwrap())[0];
    let own = snapshot.scalars("mass").unwrap()[alone];
    assert!(((whole[0] - kept) / own - 1.0).abs() < 1e-6, "{kept} of {}, without {own}", whole[0]);
}

/// Nodes behind a line of inflow, which are in the frames, are not exported.
#[test]
fn inflow_nodes_not_yet_in_the_domain_are_not_exported() {
    let value = json!({
        "title": "channel", "space": "3d", "gravity": [0, 0, -9.81], "domain": { "min": [0, 0, 0], "max": [20, 4, 5] },
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "pond", "material": "water", "shape": { "kind": "box", "min": [16, 1, 0], "max": [17, 3, 0.2] } }],
        "boundaries": [{ "side": "z-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "flow", "duration": 6 }],
        "methods": { "depth-sph": { "spacing": 0.25, "inflows": [
            { "from": [4, 0], "to": [4, 4], "discharge": [[0, 4], [4, 4]], "froude": 2 } ] } }
    });
    let case = read_case(&value);
    let mut solver = DepthSph.build(&case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    for _ in 0..40 {
        solver.step(1.0).unwrap();
    }
    let list = point_stacks(&case, &solver.snapshot()).unwrap();
    let flow = solver.scalar_outputs().iter().find(|(name, ..)| name == "flow_volume").unwrap().2;
    let handed: f64 = list.volumes.iter().sum();
    assert!((handed / flow - 1.0).abs() < 1e-12, "{handed} m³ of {flow}");
    assert!(list.positions.iter().all(|x| x[0] > 4.0 - 1e-9));
}
