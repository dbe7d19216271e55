//! Inflow of depth-integrated SPH across a line, by a hydrograph.

use colluvium_case::{Case, Method, Solver};
use colluvium_depth_sph::DepthSph;
use colluvium_testkit::{advance_exactly_to, hash_after, read_case, refusal, scalar_output, start_solver};
use serde_json::{Value, json};

const GRAVITY: f64 = 9.81;

/// Smooth level channel, 4 m wide, into which 4 m³/s flow at twice the celerity.
pub fn channel() -> Value {
    json!({
        "title": "channel", "space": "3d", "gravity": [0, 0, -GRAVITY],
        "domain": { "min": [0, 0, 0], "max": [60, 4, 5] },
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "pond", "material": "water", "shape": { "kind": "box", "min": [58, 1, 0], "max": [59, 3, 0.2] } }],
        "boundaries": [
            { "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "y-max", "wall": { "kind": "smooth" } },
            { "side": "z-min", "wall": { "kind": "smooth" } }
        ],
        "stages": [{ "name": "flow", "duration": 6 }],
        "methods": { "depth-sph": { "spacing": 0.25, "inflows": [
            { "from": [4, 0], "to": [4, 4], "discharge": [[0, 4], [4, 4]], "froude": 2 } ] } }
    })
}

/// Behind the front a stream above its celerity keeps the depth and speed at which it enters.
#[test]
fn a_stream_keeps_the_depth_and_speed_that_it_enters_with() {
    let mut solver = start_solver(&DepthSph, &read_case(&channel()));
    let (depth, speed) = ((1.0 / (2.0 * GRAVITY.sqrt())).powf(2.0 / 3.0), 1.0);
    let speed = speed / depth;
    let pond = scalar_output(solver.as_ref(), "flow_volume");
    advance_exactly_to(solver.as_mut(), 3.0);
    // The tail of the front's fan moves with the speed less the celerity, half of it here.
    let (found, velocity) = solver.gauge(&[5.5, 2.0]).unwrap();
    assert!((found / depth - 1.0).abs() < 0.02, "depth {found} for {depth}");
    assert!(
        (velocity[0] / speed - 1.0).abs() < 0.02 && velocity[1].abs() < 0.02 * speed,
        "{velocity:?} for {speed}"
    );
    // A whole number of rows has the 16 m³.
    let row = 16.0 / (16.0 / (depth * 4.0 * 0.25)).round();
    for time in [3.0, 6.0] {
        advance_exactly_to(solver.as_mut(), time);
        let (entered, exact) = (scalar_output(solver.as_ref(), "volume_entered"), 4.0 * time.min(4.0));
        assert!((entered - exact).abs() <= 0.5 * row + 1e-9, "{entered} m³ of {exact} m³");
        let flow = scalar_output(solver.as_ref(), "flow_volume");
        assert!((flow - pond - entered).abs() < 1e-9 * flow, "{flow} {pond} {entered}");
    }
}

/// Energy of a stream without friction is conserved while it enters, on a level bed and on a slope: inflow counts in the balance.
#[test]
fn energy_balance_closes_during_an_inflow() {
    for slope in [0.0, 0.2] {
        let mut value = channel();
        value["gravity"] = json!([GRAVITY * slope, 0, -GRAVITY]);
        let mut solver = start_solver(&DepthSph, &read_case(&value));
        advance_exactly_to(solver.as_mut(), 3.0);
        let (depth, entered) = (
            (1.0 / (2.0 * GRAVITY.sqrt())).powf(2.0 / 3.0),
            scalar_output(solver.as_ref(), "volume_entered"),
        );
        let brought = 1000.0 * entered * (0.5 / depth.powi(2) + 0.5 * GRAVITY * depth);
        let error = scalar_output(solver.as_ref(), "energy_error");
        assert!(error.abs() < 0.01 * brought, "slope {slope}: {error} J of {brought} J");
    }
}

/// A restored solver reports the readings of the saved state before its first step, and the same bits after later steps.
#[test]
fn a_restored_inflow_has_the_saved_readings_before_its_first_step() {
    let mut value = channel();
    value["gravity"] = json!([GRAVITY * 0.2, 0, -GRAVITY]);
    let mut solver = start_solver(&DepthSph, &read_case(&value));
    advance_exactly_to(solver.as_mut(), 1.0);
    let mut saved = Vec::new();
    solver.save(&mut saved).unwrap();
    let mut other = start_solver(&DepthSph, &read_case(&value));
    other.restore(&mut saved.as_slice()).unwrap();
    let bits = |solver: &dyn Solver| -> Vec<(String, u64)> {
        solver.scalar_outputs().into_iter().map(|(name, _, value)| (name, value.to_bits())).collect()
    };
    assert_eq!(
        scalar_output(other.as_ref(), "energy_entered"),
        scalar_output(solver.as_ref(), "energy_entered")
    );
    for time in [1.5, 2.0] {
        advance_exactly_to(solver.as_mut(), time);
        advance_exactly_to(other.as_mut(), time);
        assert_eq!(bits(solver.as_ref()), bits(other.as_ref()), "{time} s");
    }
}

#[test]
fn an_inflow_is_bit_identical_on_any_threads_and_after_a_restart() {
    let run =
        |threads: usize, restart: Option<usize>| hash_after(&DepthSph, &channel(), threads, 190, restart);
    let whole = run(1, None);
    assert_eq!(run(3, None), whole);
    assert_eq!(run(1, Some(70)), whole);
}

#[test]
fn invalid_hydrographs_and_lines_are_refused_by_path() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("flood.csv"), "time,discharge\n0,1\n10,three\n").unwrap();
    let refused_with = |changes: Value| {
        let mut value = channel();
        let inflow = value["methods"]["depth-sph"]["inflows"][0].as_object_mut().unwrap();
        inflow.extend(changes.as_object().unwrap().clone());
        inflow.retain(|_, value| !value.is_null());
        let case = Case::from_value(&value, folder.path()).unwrap();
        DepthSph.plan(&case).map(|_| ()).unwrap_err().to_string()
    };
    for (changes, start) in [
        (json!({ "discharge": [[0, 1], [0, 2]] }), "discharge: times must increase"),
        (json!({ "discharge": [[0, 1], [1, -2]] }), "discharge: -2 m³/s at 1 s"),
        (json!({ "discharge": [[0, 0], [1, 0]] }), "discharge: must begin at zero or later and have"),
        (json!({ "hydrograph": "flood.csv" }), "discharge: give either"),
        (json!({ "discharge": null, "hydrograph": "flood.csv" }), "hydrograph: /"),
        (json!({ "froude": 0 }), "froude: 0 must be"),
        (json!({ "to": [4, 0] }), "to: is equal to `from`"),
        (json!({ "to": null }), "to: is missing"),
        (json!({ "to": [4, 1e17] }), "to: makes the line 4.0e17 spacings long"),
        (json!({ "side": "x-min" }), "side: applies only to a profile"),
    ] {
        let error = refused_with(changes);
        assert!(error.starts_with(&format!("methods.depth-sph.inflows[0].{start}")), "{error}");
    }
    // In the opposite direction, it would leave the domain at once.
    let turned = refused_with(json!({ "from": [0.75, 4], "to": [0.75, 0] }));
    assert!(
        turned.starts_with("methods.depth-sph.inflows[0].from: the inflow leaves the domain 0.750 m ahead")
            && turned.contains("exchange the two"),
        "{turned}"
    );
    let warned = |from: Value, to: Value| {
        let mut value = channel();
        value["methods"]["depth-sph"]["inflows"][0]["from"] = from;
        value["methods"]["depth-sph"]["inflows"][0]["to"] = to;
        let plan = DepthSph.plan(&Case::from_value(&value, folder.path()).unwrap()).unwrap();
        plan.warnings
            .iter()
            .any(|warning| warning.text.contains("inflows[0]: the inflow leaves the domain 4.000 m"))
    };
    assert!(warned(json!([4, 4]), json!([4, 0])) && !warned(json!([4, 0]), json!([4, 4])));
    let of_two = |porosity: f64, phases: &str| {
        let mut value = channel();
        value["methods"]["depth-sph"]["inflows"][0]["porosity"] = json!(porosity);
        value["methods"]["depth-sph"]["phases"] = json!(phases);
        value["methods"]["depth-sph"]["mixture"] = json!({ "grain_density": 2000, "porosity": 0.5 });
        value["materials"]["water"]["density"] = json!(1500);
        refusal(&DepthSph, &value)
    };
    let key = "methods.depth-sph.inflows[0].porosity: ";
    assert!(
        of_two(0.3, "one").starts_with(&format!("{key}applies only to grains and fluid")),
        "{}",
        of_two(0.3, "one")
    );
    assert!(of_two(1.0, "two").starts_with(&format!("{key}1 is not between")), "{}", of_two(1.0, "two"));
}

/// V28: water that flows into still water of a channel, slower than its waves, rises by the invariant, and a bore runs ahead.
#[test]
fn an_inflow_into_still_water_sends_a_bore_ahead() {
    let value = json!({
        "title": "channel", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "domain": { "min": [0, 0], "max": [40, 3] },
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "still", "material": "water", "shape": { "kind": "box", "min": [0, 0], "max": [40, 1] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "flow", "duration": 6 }],
        "methods": { "depth-sph": { "spacing": 0.05, "smoothing": 2, "inflows": [
            { "side": "x-min", "discharge": [[0, 0.5], [9, 0.5]] } ] } }
    });
    let mut solver = start_solver(&DepthSph, &read_case(&value));
    advance_exactly_to(solver.as_mut(), 6.0);
    let entered = scalar_output(solver.as_ref(), "volume_entered");
    assert!((entered - 3.0).abs() < 0.06, "0.5 m²/s for 6 s, to a node: {entered}");
    let flow = scalar_output(solver.as_ref(), "flow_volume");
    assert!((flow - 40.0 - entered).abs() < 1e-9, "{flow} {entered}");
    let snapshot = solver.snapshot();
    let depth = snapshot.scalars("depth").unwrap();
    let velocity = snapshot.vectors("velocity").unwrap();
    let (mut count, mut means) = (0.0, [0.0; 2]);
    let mut bore = 0.0f64;
    for (i, x) in snapshot.positions.iter().enumerate() {
        if (2.0..15.0).contains(&x[0]) {
            count += 1.0;
            means = [means[0] + depth[i], means[1] + velocity[i][0]];
        }
        if depth[i] > 1.0 + 0.5 * 0.144_364 {
            bore = bore.max(x[0]);
        }
    }
    let [depth, speed] = means.map(|sum| sum / count);
    assert!((depth / 1.144_364 - 1.0).abs() < 0.02, "{depth}");
    assert!((speed / 0.436_924 - 1.0).abs() < 0.02, "{speed}");
    assert!((bore / (6.0 * 3.463) - 1.0).abs() < 0.02, "{bore}");
}

/// Still water 1 m deep in a channel of a plan, 1.5 m wide, into which as much flows in for 2.5 s across a line at 4 m.
pub fn still_plan() -> Value {
    json!({
        "title": "channel", "space": "3d", "gravity": [0, 0, -GRAVITY],
        "domain": { "min": [0, 0, 0], "max": [24, 1.5, 3] },
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "still", "material": "water", "shape": { "kind": "box", "min": [4, 0, 0], "max": [24, 1.5, 1] } }],
        "boundaries": [
            { "side": "z-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } },
            { "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "y-max", "wall": { "kind": "smooth" } }
        ],
        "stages": [{ "name": "flow", "duration": 6 }],
        "methods": { "depth-sph": { "spacing": 0.1, "inflows": [
            { "from": [4, 0], "to": [4, 1.5], "discharge": [[0, 0.75], [2.5, 0.75]] } ] } }
    })
}

/// Means of depth and speed along x over the nodes within an interval (m), and the excess of their depth over the middle of the bore (m).
pub fn bore(solver: &dyn Solver, low: f64, high: f64) -> [f64; 3] {
    let snapshot = solver.snapshot();
    let (depth, velocity) = (snapshot.scalars("depth").unwrap(), snapshot.vectors("velocity").unwrap());
    let (mut count, mut sums) = (0.0, [0.0; 3]);
    for (i, x) in snapshot.positions.iter().enumerate() {
        if (low..high).contains(&x[0]) {
            count += 1.0;
            sums = [sums[0] + depth[i], sums[1] + velocity[i][0], sums[2]];
        }
        if depth[i] > 1.0 + 0.5 * 0.144_364 {
            sums[2] = sums[2].max(x[0]);
        }
    }
    [sums[0] / count, sums[1] / count, sums[2]]
}

/// V28 across a line in plan: equal to the closed form and to the profile.
#[test]
fn an_inflow_across_a_line_into_still_water_sends_the_bore_of_the_profile() {
    let mut solver = start_solver(&DepthSph, &read_case(&still_plan()));
    let pond = scalar_output(solver.as_ref(), "flow_volume");
    assert!((pond - 30.0).abs() < 1e-9, "{pond}");
    advance_exactly_to(solver.as_mut(), 2.4);
    let entered = scalar_output(solver.as_ref(), "volume_entered");
    assert!((entered - 1.8).abs() <= 0.5 * 1.5 * 0.1 + 1e-9, "0.75 m³/s for 2.4 s, to half a row: {entered}");
    let flow = scalar_output(solver.as_ref(), "flow_volume");
    assert!((flow - pond - entered).abs() < 1e-9, "{flow} {entered}");
    let [depth, speed, front] = bore(solver.as_ref(), 4.5, 10.0);
    assert!((depth / 1.144_364 - 1.0).abs() < 0.02, "{depth}");
    assert!((speed / 0.436_924 - 1.0).abs() < 0.02, "{speed}");
    assert!(((front - 4.0) / (2.4 * 3.463) - 1.0).abs() < 0.03, "{front}");
    let mut value = still_plan();
    value["space"] = json!("plane-strain");
    value["gravity"] = json!([0, -GRAVITY]);
    value["domain"] = json!({ "min": [4, 0], "max": [24, 3] });
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [4, 0], "max": [24, 1] });
    value["boundaries"] = json!([{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } }]);
    value["methods"]["depth-sph"]["inflows"] =
        json!([{ "side": "x-min", "discharge": [[0, 0.5], [2.5, 0.5]] }]);
    let mut profile = start_solver(&DepthSph, &read_case(&value));
    advance_exactly_to(profile.as_mut(), 2.4);
    let [of_profile, other, _] = bore(profile.as_ref(), 4.5, 10.0);
    assert!((depth / of_profile - 1.0).abs() < 0.01, "{depth} m, and {of_profile} m of the profile");
    assert!((speed / other - 1.0).abs() < 0.02, "{speed} m/s, and {other} m/s of the profile");
    // After the end of the inflow the line is a wall: the invariant that arrives has still water behind it.
    advance_exactly_to(solver.as_mut(), 4.5);
    let entered = scalar_output(solver.as_ref(), "volume_entered");
    assert!((entered - 1.875).abs() <= 0.5 * 1.5 * 0.1 + 1e-9, "{entered}");
    let [depth, speed, _] = bore(solver.as_ref(), 4.5, 8.0);
    assert!((depth - 1.0).abs() < 0.02 && speed.abs() < 0.02, "{depth} m, {speed} m/s");
    let snapshot = solver.snapshot();
    let past = snapshot.positions.iter().filter(|x| x[0] < 3.0).count();
    assert_eq!(past, 0, "nothing runs back");
}

#[test]
fn an_inflow_line_before_still_water_is_bit_identical_on_threads_and_after_restart() {
    let run =
        |threads: usize, restart: Option<usize>| hash_after(&DepthSph, &still_plan(), threads, 60, restart);
    let whole = run(1, None);
    assert_eq!(run(3, None), whole);
    assert_eq!(run(1, Some(25)), whole);
}

#[test]
fn a_line_within_standing_water_is_refused() {
    let mut value = still_plan();
    value["bodies"][0]["shape"]["min"] = json!([2, 0, 0]);
    let error = refusal(&DepthSph, &value);
    assert!(error.starts_with("methods.depth-sph.inflows[0].from: lies within a body"), "{error}");
}

/// Dry profile with `inflows` through its end, and a pond far from it.
pub fn profile(inflows: &Value) -> Value {
    json!({
        "title": "channel", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "domain": { "min": [0, 0], "max": [60, 3] },
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "pond", "material": "water", "shape": { "kind": "box", "min": [58, 0], "max": [59, 0.2] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "flow", "duration": 4 }],
        "methods": { "depth-sph": { "spacing": 0.1, "inflows": inflows } }
    })
}

/// An inflow onto a dry bed has the depth and speed of its Froude number.
#[test]
fn an_inflow_onto_a_dry_profile_has_its_froude_number() {
    let value = profile(&json!([{ "side": "x-min", "discharge": [[0, 1], [9, 1]], "froude": 2 }]));
    let mut solver = start_solver(&DepthSph, &read_case(&value));
    advance_exactly_to(solver.as_mut(), 4.0);
    let depth = (1.0 / (2.0 * GRAVITY.sqrt())).powf(2.0 / 3.0);
    let snapshot = solver.snapshot();
    let (found, velocity) = (snapshot.scalars("depth").unwrap(), snapshot.vectors("velocity").unwrap());
    let inside: Vec<usize> =
        (0..found.len()).filter(|i| (1.0..4.0).contains(&snapshot.positions[*i][0])).collect();
    assert!(inside.len() > 20, "{}", inside.len());
    for i in inside {
        assert!((found[i] / depth - 1.0).abs() < 0.03, "{} for {depth}", found[i]);
        assert!((velocity[i][0] * depth - 1.0).abs() < 0.03, "{} for {}", velocity[i][0], 1.0 / depth);
    }
    let entered = scalar_output(solver.as_ref(), "volume_entered");
    assert!((entered - 4.0).abs() < 0.1, "{entered}");
}

/// A hydrograph gives its integral through an end too, at any spacing, on a dry bed and against still water, of one and of two phases.
#[test]
fn a_hydrograph_through_an_end_brings_its_integral() {
    let (rectangle, triangle) = (json!([[0, 1], [1, 1]]), json!([[0, 0], [0.5, 1.5], [2, 0]]));
    for (hydrograph, exact) in [(&rectangle, 1.0), (&triangle, 1.5)] {
        for spacing in [0.05, 0.21, 0.4] {
            let mut dry = profile(&json!([{ "side": "x-min", "discharge": hydrograph, "froude": 2 }]));
            dry["methods"]["depth-sph"]["spacing"] = json!(spacing);
            let mut wet = wet(0.4);
            wet["methods"]["depth-sph"]["spacing"] = json!(spacing);
            wet["methods"]["depth-sph"]["inflows"][0]["discharge"] = hydrograph.clone();
            for value in [dry, wet] {
                let mut solver = start_solver(&DepthSph, &read_case(&value));
                advance_exactly_to(solver.as_mut(), 4.5);
                let entered = scalar_output(solver.as_ref(), "volume_entered");
                assert!(
                    (entered / exact - 1.0).abs() < 1e-6,
                    "spacing {spacing}: {entered} of {exact} {}",
                    value["methods"]
                );
                let phases = value["methods"]["depth-sph"]["phases"] == "two";
                let fluid =
                    if phases { scalar_output(solver.as_ref(), "fluid_entered") / entered } else { 0.4 };
                assert!((fluid - 0.4).abs() < 1e-6, "spacing {spacing}: a share of {fluid}");
            }
        }
    }
}

/// Mixture of grains and fluid in which the grains settle slowly.
pub fn mixture(porosity: f64) -> Value {
    json!({ "grain_density": 2000, "porosity": porosity, "drag": { "law": "anderson", "settling_velocity": 1e-3 } })
}

/// Volumes of grains and of fluid on the nodes at `x` >= `from` (m).
fn volumes(solver: &dyn Solver, from: f64) -> [f64; 2] {
    let snapshot = solver.snapshot();
    let (phase, volume) = (snapshot.scalars("phase").unwrap(), snapshot.scalars("volume").unwrap());
    let mut sums = [0.0; 2];
    for (i, _) in snapshot.positions.iter().enumerate().filter(|(_, x)| x[0] >= from) {
        sums[phase[i] as usize] += volume[i];
    }
    sums
}

/// Grains and fluid cross a line onto a dry bed together, each with its share of the hydrograph to round-off.
#[test]
fn two_phases_flow_in_across_a_line_with_their_shares() {
    let mut value = channel();
    value["materials"]["water"]["density"] = json!(1600);
    let own = value["methods"]["depth-sph"].as_object_mut().unwrap();
    own.extend(json!({ "phases": "two", "mixture": mixture(0.4) }).as_object().unwrap().clone());
    own["inflows"][0]["porosity"] = json!(0.6);
    let mut solver = start_solver(&DepthSph, &read_case(&value));
    let pond = volumes(solver.as_ref(), 50.0);
    let depth = (1.0 / (2.0 * GRAVITY.sqrt())).powf(2.0 / 3.0);
    advance_exactly_to(solver.as_mut(), 3.0);
    let (found, velocity) = solver.gauge(&[5.5, 2.0]).unwrap();
    assert!((found / depth - 1.0).abs() < 0.02, "depth {found} for {depth}");
    assert!((velocity[0] * depth - 1.0).abs() < 0.02, "{velocity:?}");
    // A whole number of rows has the 16 m³.
    let row = 16.0 / (16.0 / (depth * 4.0 * 0.25)).round();
    for time in [3.0, 5.0] {
        advance_exactly_to(solver.as_mut(), time);
        let (entered, exact) = (scalar_output(solver.as_ref(), "volume_entered"), 4.0 * time.min(4.0));
        assert!((entered - exact).abs() <= 0.5 * row + 1e-9, "{entered} m³ of {exact} m³");
        assert!((scalar_output(solver.as_ref(), "fluid_entered") / entered - 0.6).abs() < 1e-12);
        let all = volumes(solver.as_ref(), f64::NEG_INFINITY);
        let waiting = all[0] + all[1] - scalar_output(solver.as_ref(), "flow_volume");
        for (phase, share) in [0.4, 0.6].into_iter().enumerate() {
            let added = all[phase] - pond[phase];
            let exact = share * (entered + waiting);
            assert!((added - exact).abs() < 1e-10 * exact, "phase {phase}: {added} m³ for {exact} m³");
        }
    }
}

/// Channel of grains and water 1 m deep into which such a mixture flows through its end.
fn wet(porosity: f64) -> Value {
    json!({
        "title": "channel", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "domain": { "min": [0, 0], "max": [30, 3] },
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "still", "material": "water", "shape": { "kind": "box", "min": [0, 0], "max": [30, 1] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "flow", "duration": 4 }],
        "methods": { "depth-sph": { "spacing": 0.05, "phases": "two", "mixture": mixture(0.4), "inflows": [
            { "side": "x-min", "discharge": [[0, 0.5], [9, 0.5]], "porosity": porosity } ] } }
    })
}

/// V28 with grains and fluid coupled by drag: a mixture like that of the channel raises the bore of water, one with more water
/// pushes the other before it, and the volume of each phase is kept to round-off.
#[test]
fn two_phases_flow_into_a_wet_channel_with_their_shares() {
    for porosity in [0.4, 0.6] {
        let mut solver = start_solver(&DepthSph, &read_case(&wet(porosity)));
        advance_exactly_to(solver.as_mut(), 4.0);
        let entered = scalar_output(solver.as_ref(), "volume_entered");
        assert!((entered - 2.0).abs() < 0.12, "0.5 m²/s for 4 s, to a node of each phase: {entered}");
        let fluid = scalar_output(solver.as_ref(), "fluid_entered");
        assert!((fluid - porosity * entered).abs() < 0.06, "{fluid} of {entered} m²");
        let inside = volumes(solver.as_ref(), 0.0);
        for (found, exact) in inside.iter().zip([18.0 + entered - fluid, 12.0 + fluid]) {
            assert!((found - exact).abs() < 1e-9, "{porosity}: {found} m² for {exact} m²");
        }
        let snapshot = solver.snapshot();
        let [depth, height, phase] = ["depth", "height", "phase"].map(|name| snapshot.scalars(name).unwrap());
        let mean = |low: f64, high: f64, value: &dyn Fn(usize) -> f64| {
            let inside: Vec<usize> = (0..depth.len())
                .filter(|i| (low..high).contains(&snapshot.positions[*i][0]) && phase[*i] == 1.0)
                .collect();
            inside.iter().map(|i| value(*i)).sum::<f64>() / inside.len() as f64
        };
        let share = mean(0.3, 1.2, &|i| height[i] / depth[i]);
        assert!((share - porosity).abs() < 0.02, "{share}: what has flowed in is there");
        let share = mean(4.0, 12.0, &|i| height[i] / depth[i]);
        assert!((share - 0.4).abs() < 0.01, "{share}: before it is what was there");
        if porosity == 0.4 {
            let found = mean(2.0, 10.0, &|i| depth[i]);
            assert!((found / 1.144_364 - 1.0).abs() < 0.02, "{found}");
        }
    }
}

/// Options of the integrators, and of smoothed velocities.
pub fn integrators() -> [Value; 4] {
    let named = |name: &str| json!({ "integration": name });
    [json!({}), json!({ "xsph": 0.2 }), named("runge-kutta2"), named("runge-kutta4")]
}

/// Grains and fluid that flow onto a dry profile have the depth and speed of their Froude number, with columns of pore pressure too, by all
/// integrators.
#[test]
fn two_phases_flow_onto_a_dry_profile_with_liquefied_grains() {
    integrators().iter().for_each(liquefied_grains_flow_onto_a_dry_profile);
}

fn liquefied_grains_flow_onto_a_dry_profile(integrator: &Value) {
    let mut value = wet(0.5);
    let own = value["methods"]["depth-sph"].as_object_mut().unwrap();
    own.extend(integrator.as_object().unwrap().clone());
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [28, 0], "max": [29, 0.2] });
    value["methods"]["depth-sph"]["inflows"][0]["froude"] = json!(2.0);
    value["methods"]["depth-sph"]["column"] = json!({ "cells": 8, "consolidation": 0, "excess_ratio": 0.8 });
    let mut solver = start_solver(&DepthSph, &read_case(&value));
    advance_exactly_to(solver.as_mut(), 2.5);
    let depth = (0.5 / (2.0 * GRAVITY.sqrt())).powf(2.0 / 3.0);
    let (found, velocity) = solver.gauge(&[0.5]).unwrap();
    assert!((found / depth - 1.0).abs() < 0.03, "{integrator}: {found} m for {depth} m");
    assert!((velocity[0] * depth / 0.5 - 1.0).abs() < 0.03, "{integrator}: {velocity:?}");
    let snapshot = solver.snapshot();
    let (ratio, phase) = (snapshot.scalars("liquefaction").unwrap(), snapshot.scalars("phase").unwrap());
    for (i, x) in snapshot.positions.iter().enumerate() {
        if (-0.2..1.0).contains(&x[0]) && phase[i] == 0.0 {
            assert!((ratio[i] - 0.8).abs() < 0.02, "{integrator}: at {} m: {}", x[0], ratio[i]);
        }
    }
}
