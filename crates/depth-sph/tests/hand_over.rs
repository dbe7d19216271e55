//! Nodes from the points of another method (sheet: depth-sph §3.2, 4).

use colluvium_case::{Case, CaseError, Method};
use colluvium_depth_sph::DepthSph;
use serde_json::json;

/// A cloud of points a quarter of a metre apart, 4 m by 3 m and 2 m high, that moves faster at its top.
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
fn points_hand_over_their_volume_their_middle_and_their_momentum() {
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

#[test]
fn a_file_that_is_no_list_of_points_is_told() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("points.csv"), "x,y,z,volume\n1,1,1,-1\n").unwrap();
    let refused = |case: Case| -> CaseError { DepthSph.plan(&case).map(|_| ()).unwrap_err() };
    let problem = refused(case(folder.path(), "one").unwrap()).to_string();
    assert!(
        problem.starts_with("bodies[0].points.file: ") && problem.contains("must be positive"),
        "{problem}"
    );
}
