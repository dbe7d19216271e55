//! Rasters over the plan.

use colluvium_case::PlanRaster;
use colluvium_snow_mpm::SnowMpm;
use colluvium_testkit::{advance_to, read_case, refusal, start_solver};
use serde_json::{Value, json};

/// A block that slides over flat ground.
fn sliding() -> Value {
    json!({
        "title": "block", "space": "3d", "gravity": [0, 0, 0],
        "domain": { "min": [0, 0, 0], "max": [3, 1.2, 1] },
        "materials": { "m": { "model": "linear-elastic", "strain_measure": "hencky", "density": 400, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
        "bodies": [{ "name": "block", "material": "m", "velocity": { "kind": "uniform", "value": [3, 0, 0] },
            "shape": { "kind": "box", "min": [0.4, 0.4, 0.2], "max": [0.8, 0.8, 0.5] } }],
        "stages": [{ "name": "go", "duration": 1 }],
        "output": { "rasters": { "cell": 0.2, "threshold": 0.02 } },
        "methods": { "snow-mpm": { "cell_size": 0.1 } }
    })
}

fn of<'a>(rasters: &'a [PlanRaster], name: &str) -> &'a PlanRaster {
    rasters.iter().find(|raster| raster.name == name).unwrap()
}

#[test]
fn rasters_contain_peak_thickness_velocity_pressure_and_arrival_time() {
    let case = read_case(&sliding());
    let mut solver = start_solver(&SnowMpm, &case);
    advance_to(&mut *solver, 0.4);
    let rasters = solver.rasters();
    let thickness = of(&rasters, "final_thickness_vertical");
    let volume: f64 = thickness.raster.values.iter().filter(|v| v.is_finite()).sum::<f64>() * 0.04;
    assert!((volume / (0.4 * 0.4 * 0.3) - 1.0).abs() < 1e-9, "{volume}");
    let at = |name: &str, x: f64, y: f64| {
        let raster = &of(&rasters, name).raster;
        raster.value((x / 0.2) as usize, (y / 0.2) as usize)
    };
    for x in [0.5, 0.9, 1.3] {
        assert!((at("peak_thickness_vertical", x, 0.5) - 0.3).abs() < 1e-6, "{x}");
        assert!((at("peak_velocity", x, 0.5) - 3.0).abs() < 1e-9);
        assert!((at("peak_dynamic_pressure", x, 0.5) - 400.0 * 9.0).abs() < 1e-3);
    }
    // Its front, from 0.8 m on, covers a fifteenth of a cell before it counts.
    let arrival = at("arrival_time", 1.5, 0.5);
    assert!((arrival - (1.4 + 0.2 / 15.0 - 0.8) / 3.0).abs() < 0.01, "{arrival}");
    assert!(at("peak_thickness_vertical", 2.5, 0.5).is_nan() && at("peak_velocity", 1.0, 0.1).is_nan());
}

#[test]
fn rasters_continue_after_a_restart() {
    let case = read_case(&sliding());
    let mut whole = start_solver(&SnowMpm, &case);
    advance_to(&mut *whole, 0.1);
    let mut file = Vec::new();
    whole.save(&mut file).unwrap();
    let mut resumed = start_solver(&SnowMpm, &case);
    resumed.restore(&mut &file[..]).unwrap();
    for solver in [&mut whole, &mut resumed] {
        advance_to(&mut **solver, 0.2);
    }
    let bits = |rasters: Vec<PlanRaster>| -> Vec<u64> {
        rasters.iter().flat_map(|raster| raster.raster.values.iter().map(|v| v.to_bits())).collect()
    };
    assert_eq!(bits(whole.rasters()), bits(resumed.rasters()));
}

#[test]
fn a_profile_has_no_rasters() {
    let mut case = sliding();
    case["space"] = json!("plane-strain");
    case["domain"] = json!({ "min": [0, 0], "max": [3, 1] });
    case["gravity"] = json!([0, 0]);
    case["bodies"][0]["velocity"] = Value::Null;
    case["bodies"][0].as_object_mut().unwrap().remove("velocity");
    case["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0.4, 0.4], "max": [0.8, 0.8] });
    assert!(refusal(&SnowMpm, &case).starts_with("output.rasters: a profile has no plan"));
}

#[test]
fn rasters_in_map_coordinates_equal_those_near_zero() {
    // Numbers that stay as they are when the origin is taken off.
    let placed = |x: f64, y: f64| {
        let mut case = sliding();
        case["domain"] = json!({ "min": [x, y, 0], "max": [x + 3.0, y + 1.5, 1], "origin": [x, y, 0] });
        case["bodies"][0]["shape"] =
            json!({ "kind": "box", "min": [x + 0.5, y + 0.5, 0.25], "max": [x + 1.0, y + 1.0, 0.5] });
        case
    };
    let [near, far] = [placed(0.0, 0.0), placed(500_000.0, 4_000_000.0)].map(|case| {
        let mut solver = start_solver(&SnowMpm, &read_case(&case));
        advance_to(&mut *solver, 0.05);
        solver.rasters()
    });
    for (near, far) in near.iter().zip(&far) {
        let close = |a: f64, b: f64| (a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-6 * a.abs();
        assert!(
            near.raster.values.iter().zip(&far.raster.values).all(|(a, b)| close(*a, *b)),
            "{}",
            near.name
        );
    }
}
