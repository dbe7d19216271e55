//! Contact between bodies (sheet: mpm §2.12).

use colluvium_case::{Case, FieldData, Method, Snapshot};
use colluvium_mpm::Mpm;
use colluvium_testkit::{
    CaseBuilder, advance_steps, assert_same_after_restart, assert_same_on_threads, solve, start_solver,
    vectors, with_keys,
};
use serde_json::{Value, json};

/// Square of 2 m and an elastic material. The test adds bodies, stages and options.
fn square() -> CaseBuilder {
    CaseBuilder::plane_strain([0.0, 0.0], [2.0, 2.0]).elastic("m", 1000.0, 1e5, 0.0)
}

/// Two blocks, one upon the other, that move with the velocities given.
fn blocks(velocities: [[f64; 2]; 2], options: &Value) -> Case {
    let mut mpm = json!({ "cell_size": 0.1, "courant": 0.3 });
    for (key, value) in options.as_object().unwrap() {
        mpm[key] = value.clone();
    }
    square().with(json!({
        "bodies": [
            { "name": "lower", "material": "m", "shape": { "kind": "box", "min": [0.5, 0.6], "max": [1.5, 1.0] },
              "velocity": { "kind": "uniform", "value": velocities[0] } },
            { "name": "upper", "material": "m", "shape": { "kind": "box", "min": [0.5, 1.0], "max": [1.5, 1.4] },
              "velocity": { "kind": "uniform", "value": velocities[1] } }],
        "stages": [{ "name": "s", "duration": 0.1 }],
        "methods": { "mpm": mpm }
    })).build()
}

fn contact(friction: f64, adhesion: f64) -> Value {
    json!([{ "bodies": ["upper", "lower"], "friction_coefficient": friction, "adhesion": adhesion, "test": "gap" }])
}

/// Mean velocities of the two bodies.
fn means(snapshot: &Snapshot) -> [[f64; 2]; 2] {
    let velocities = vectors(snapshot, "velocity");
    [0, 1].map(|body| {
        let of_body = || velocities.iter().zip(&snapshot.bodies).filter(|(_, b)| **b == body).map(|(v, _)| v);
        let mean = |c: usize| of_body().map(|v| v[c]).sum::<f64>() / of_body().count() as f64;
        [mean(0), mean(1)]
    })
}

const SHAPES: [&str; 5] = ["linear", "ugimp", "cpgimp", "quadratic", "cubic"];
const SCHEMES: [&str; 3] = ["usf", "usl", "musl"];

#[test]
fn separating_bodies_have_no_contact_force() {
    for shape in SHAPES {
        for scheme in SCHEMES {
            let options = json!({ "shape": shape, "stress_update": scheme, "contacts": contact(0.5, 1e3) });
            let report = solve(&Mpm, &blocks([[0.1, -0.5], [-0.2, 0.5]], &options));
            for (velocity, body) in vectors(&report.snapshot, "velocity").iter().zip(&report.snapshot.bodies)
            {
                let expected = if *body == 0 { [0.1, -0.5] } else { [-0.2, 0.5] };
                let error = (velocity[0] - expected[0]).abs() + (velocity[1] - expected[1]).abs();
                assert!(error < 1e-10, "{shape}, {scheme}: {velocity:?}");
            }
        }
    }
    // Without a contact they hold each other.
    let stuck = solve(&Mpm, &blocks([[0.0, -0.5], [0.0, 0.5]], &json!({})));
    assert!(means(&stuck.snapshot)[1][1] < 0.45);
}

#[test]
fn smooth_bodies_slide_without_a_change() {
    for shape in SHAPES {
        for scheme in SCHEMES {
            let options = json!({ "shape": shape, "stress_update": scheme,
                                  "contacts": [{ "bodies": ["lower", "upper"], "normal": [0, 1], "test": "gap" }] });
            let report = solve(&Mpm, &blocks([[0.0, 0.0], [0.5, 0.0]], &options));
            let [lower, upper] = means(&report.snapshot);
            assert!(lower[0].abs() < 1e-12 && (upper[0] - 0.5).abs() < 1e-12, "{shape}, {scheme}: {upper:?}");
        }
    }
}

#[test]
fn contact_forces_do_not_depend_on_distant_bodies() {
    let soft = json!({ "stiffness": 1e5 });
    let laws = [
        json!({ "bodies": ["lower", "upper"], "test": "gap", "penalty": soft }),
        json!({ "bodies": ["lower", "upper"], "test": "gap", "adhesion": 50.0, "friction_coefficient": 0.2 }),
        json!({ "bodies": ["lower", "upper"], "test": "gap", "friction_coefficient": 0.9,
                "penalty": { "stiffness": 1e5, "shear_strength": 20.0 } }),
    ];
    for law in laws {
        let ends = [false, true].map(|third| {
            let options = json!({ "shape": "ugimp", "contacts": [law] });
            let mut case = blocks([[0.0, 0.1], [0.4, -0.3]], &options);
            if third {
                let mut far = case.bodies[1].clone();
                far.name = "far".to_owned();
                far.shape =
                    serde_json::from_value(json!({ "kind": "box", "min": [0.1, 0.1], "max": [0.3, 0.3] }))
                        .unwrap();
                far.velocity = Default::default();
                case.bodies.push(far);
            }
            means(&solve(&Mpm, &case).snapshot)
        });
        for (alone, with_far) in ends[0].iter().flatten().zip(ends[1].iter().flatten()) {
            assert!((alone - with_far).abs() < 1e-9, "{law}: {ends:?}");
        }
    }
}

#[test]
fn adhesion_on_a_ring_is_that_of_its_whole_area_per_radian() {
    // A ring of 10 to 11 m and 1 m high on a rigid core, pressed on it, in free fall: of 10 m² per radian and 1 kPa.
    let falls = |adhesion: f64| {
        let case = square().with(json!({
            "space": "axisymmetric", "domain": { "min": [9.5, 0], "max": [11.5, 3] }, "gravity": [0, -1],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0 } },
            "bodies": [
                { "name": "core", "rigid": true, "material": "m", "shape": { "kind": "box", "min": [9.7, 0], "max": [10, 3] } },
                { "name": "ring", "material": "m", "shape": { "kind": "box", "min": [10, 1.5], "max": [11, 2.5] } }],
            "loads": [{ "kind": "traction", "body": "ring", "side": "x-max", "value": [-20000.0, 0], "ramp": 0.05 }],
            "stages": [{ "name": "s", "duration": 0.4 }],
            "methods": { "mpm": { "cell_size": 0.1, "courant": 0.4,
                                  "contacts": [{ "bodies": ["core", "ring"], "adhesion": adhesion, "normal": [1, 0] }] } }
        })).build();
        let report = solve(&Mpm, &case);
        let budget = report.snapshot.bodies.iter().zip(vectors(&report.snapshot, "velocity"));
        let ring: Vec<f64> = budget.filter(|(body, _)| **body == 1).map(|(_, v)| v[1]).collect();
        ring.iter().sum::<f64>() / ring.len() as f64
    };
    let mass = 1000.0 * 0.5 * (11.0f64.powi(2) - 10.0f64.powi(2));
    let force = mass * (falls(1000.0) - falls(0.0)) / 0.4;
    assert!((force / 10_000.0 - 1.0).abs() < 0.1, "{force}");
}

#[test]
fn contact_conserves_momentum_and_generates_no_kinetic_energy() {
    for shape in SHAPES {
        for scheme in SCHEMES {
            // Unstable at nodes of small mass; the cutoff that stabilises them does not conserve momentum.
            if (shape, scheme) == ("linear", "usl") {
                continue;
            }
            let options = json!({ "shape": shape, "stress_update": scheme, "contacts": contact(0.3, 10.0) });
            let case = blocks([[0.0, 0.2], [0.4, -0.3]], &options);
            let mut solver = start_solver(&Mpm, &case);
            let before = solver.totals();
            for _ in 0..200 {
                let dt = solver.limit().dt;
                solver.step(dt).unwrap();
            }
            let after = solver.totals();
            for c in 0..2 {
                let change = (after.momentum[c] - before.momentum[c]).abs();
                // Not round-off alone: nodes below the cut-off of mass take no force.
                assert!(change < 1e-9 * before.mass, "{shape}, {scheme}: momentum changes by {change}");
            }
            let energy = (after.kinetic + after.elastic) / before.kinetic;
            assert!(energy < 1.01, "{shape}, {scheme}: energy grows to {energy}");
            let [lower, upper] = means(&solver.snapshot());
            assert!(lower[0] > 1e-3 && upper[1] > lower[1], "{shape}, {scheme}: they rub and bounce apart");
        }
    }
}

/// Mean velocities of two blocks, the upper of which sets out to slide, pressed together by tractions at top and bottom;
/// nothing else holds them.
fn pressed(mut contacts: Value) -> [[f64; 2]; 2] {
    contacts[0]["normal"] = json!([0, -1]);
    let mut case = blocks([[0.0, 0.0], [0.2, 0.0]], &json!({ "contacts": contacts }));
    let loads = json!([
        { "kind": "traction", "body": "upper", "side": "y-max", "value": [0, -200], "ramp": 0.1 },
        { "kind": "traction", "body": "lower", "side": "y-min", "value": [0, 200], "ramp": 0.1 }]);
    case.loads = serde_json::from_value(loads).unwrap();
    case.stages[0].duration = 0.3;
    means(&solve(&Mpm, &case).snapshot)
}

/// One block upon the other, the lower one on a smooth floor, settled under their weight.
fn settled(contacts: &Value) -> Snapshot {
    let mut case = blocks([[0.0; 2]; 2], &json!({ "contacts": contacts }));
    case.gravity = vec![0.0, -1.0];
    let floor = json!([{ "side": "y-min", "position": 0.6, "wall": { "kind": "smooth" } }]);
    case.boundaries = serde_json::from_value(floor).unwrap();
    case.stages = serde_json::from_value(json!([
        { "name": "settle", "duration": 20, "damping": 0.5, "gravity_ramp": 1, "equilibrium": {} }]))
    .unwrap();
    solve(&Mpm, &case).snapshot
}

#[test]
fn pressed_bodies_slide_by_the_friction_between_them_and_stick_below_it() {
    // Blocks of 400 kg. The normal impulse is p t less half the ramp, less the momentum of the lower block.
    for (friction, adhesion, tolerance) in
        [(0.1, 0.0, 0.03), (0.2, 0.0, 0.03), (0.0, 20.0, 0.06), (0.1, 20.0, 0.06)]
    {
        let [lower, upper] = pressed(contact(friction, adhesion));
        let impulse = 200.0 * 0.25 - 400.0 * lower[1];
        // Adhesion misses the moments in which they bounce.
        let expected = (friction * impulse + adhesion * 0.3) / 400.0;
        let error = (lower[0] / expected - 1.0).abs();
        assert!(error < tolerance, "{friction}, {adhesion}: {lower:?}, {expected}");
        assert!((upper[0] + lower[0] - 0.2).abs() < 1e-9, "{upper:?}");
    }
    let [lower, upper] = pressed(contact(100.0, 0.0));
    assert!((lower[0] - upper[0]).abs() < 0.05, "they stick: {lower:?}, {upper:?}");
}

#[test]
fn a_penalty_carries_a_block_by_the_overlap() {
    // 400 Pa under the upper block: an overlap of 1 cm.
    let mut contacts = contact(0.3, 0.0);
    contacts[0]["penalty"] = json!({ "stiffness": 4e4 });
    let snapshot = settled(&contacts);
    let heights = |body: u32| {
        let of_body = snapshot.positions.iter().zip(&snapshot.bodies).filter(move |(_, b)| **b == body);
        of_body.map(|(x, _)| x[1])
    };
    let (top, bottom) = (heights(0).fold(0.0, f64::max), heights(1).fold(f64::INFINITY, f64::min));
    let overlap = 0.05 * (1.0 - 400.0 / 1e5) - (bottom - top);
    assert!((overlap / 0.01 - 1.0).abs() < 0.1, "{overlap}");
}

#[test]
fn friction_of_a_penalty_is_proportional_to_its_force_up_to_the_shear_strength() {
    let pushed = |friction: f64, strength: Option<f64>| {
        let mut contacts = contact(friction, 0.0);
        contacts[0]["penalty"] = json!({ "stiffness": 1e5, "shear_strength": strength });
        pressed(contacts)
    };
    // As without a penalty: 400 kg and the impulse that presses, less the momentum that the lower block has.
    let [lower, upper] = pushed(0.2, None);
    let expected = 0.2 * (200.0 * 0.25 - 400.0 * lower[1]) / 400.0;
    assert!((lower[0] / expected - 1.0).abs() < 0.05, "{lower:?}, {expected}");
    assert!((upper[0] + lower[0] - 0.2).abs() < 1e-9, "{upper:?}");
    // The strength is reached as soon as there is any pressure, and lost while they are apart.
    let [lower, upper] = pushed(100.0, Some(20.0));
    let bound = 20.0 * 0.3 / 400.0;
    assert!(lower[0] < bound * (1.0 + 1e-9) && lower[0] > 0.85 * bound, "{lower:?}, {bound}");
    assert!((upper[0] + lower[0] - 0.2).abs() < 1e-9, "{upper:?}");
}

#[test]
fn contact_is_the_same_on_two_threads_and_after_a_restart() {
    for (shape, scheme) in [("linear", "musl"), ("ugimp", "usl"), ("cubic", "usf")] {
        let options = json!({ "shape": shape, "stress_update": scheme, "contacts": contact(0.3, 10.0) });
        let case = blocks([[0.0, 0.2], [0.4, -0.3]], &options);
        assert_same_on_threads(&Mpm, &case, &format!("{shape}, {scheme}"));
        assert_same_after_restart(&Mpm, &case, |solver| advance_steps(solver, 40));
    }
}

#[test]
fn bodies_have_no_contact_force_before_they_touch() {
    // A gap of a third of a cell, closing at 1 m/s: nodes have mass of both bodies from the start.
    for shape in SHAPES {
        let options = json!({ "shape": shape, "contacts": contact(0.5, 0.0) });
        let mut case = blocks([[0.0, 0.0], [0.3, -1.0]], &options);
        case.bodies[1].shape =
            serde_json::from_value(json!({ "kind": "box", "min": [0.5, 1.05], "max": [1.5, 1.45] })).unwrap();
        let mut solver = start_solver(&Mpm, &case);
        let mut first = f64::NAN;
        while solver.time() < 0.09 && first.is_nan() {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
            if means(&solver.snapshot())[0][1] != 0.0 {
                first = solver.time();
            }
        }
        // They meet after 0.05 s; linear shape functions do not resolve the position of a row of points between the nodes.
        let early = if shape == "linear" { 0.02 } else { 0.008 };
        assert!((first - 0.05).abs() < early, "{shape}: they meet at {first} s");
        // By velocities alone they meet at once; so they do without a test where the normal is given.
        for (keys, at_once) in
            [(json!({ "test": "approach" }), true), (json!({ "normal": [0, -1] }), true), (json!({}), false)]
        {
            let mut early = case.clone();
            let pair = &mut early.methods.get_mut("mpm").unwrap()["contacts"][0];
            *pair = with_keys(json!({ "bodies": ["upper", "lower"] }), &keys);
            let mut solver = start_solver(&Mpm, &early);
            solver.step(1e-4).unwrap();
            assert_eq!(means(&solver.snapshot())[0][1] != 0.0, at_once, "{shape}, {keys}");
        }
    }
}

#[test]
fn three_bodies_in_contact_at_a_node_do_not_interpenetrate() {
    // A plate of half a cell between two blocks that press it: all three share nodes.
    let boxed = |name: &str, low: f64, high: f64, speed: f64| {
        json!({ "name": name, "material": "m", "shape": { "kind": "box", "min": [0.5, low], "max": [1.5, high] },
                "velocity": { "kind": "uniform", "value": [0, speed] } })
    };
    let pair = |a: &str, b: &str| json!({ "bodies": [a, b], "friction_coefficient": 0.3, "test": "gap" });
    let case = square().with(json!({
        "bodies": [boxed("lower", 0.6, 1.0, 0.2), boxed("plate", 1.0, 1.05, 0.0), boxed("upper", 1.05, 1.45, -0.2)],
        "stages": [{ "name": "s", "duration": 0.05 }],
        "methods": { "mpm": { "cell_size": 0.1, "courant": 0.3, "points_per_cell": 4,
                              "contacts": [pair("lower", "plate"), pair("plate", "upper"), pair("lower", "upper")] } }
    })).build();
    let report = solve(&Mpm, &case);
    assert!(report.end.momentum[1].abs() < 1e-9 * report.end.mass, "{:?}", report.end.momentum);
    let thickness = |snapshot: &Snapshot| {
        let of_plate = snapshot.positions.iter().zip(&snapshot.bodies).filter(|(_, b)| **b == 1);
        let (low, high) =
            of_plate.fold((f64::INFINITY, 0f64), |(low, high), (x, _)| (low.min(x[1]), high.max(x[1])));
        high - low
    };
    // As stiff as the blocks, which the impact strains by v/c = 2 %.
    let kept = thickness(&report.snapshot) / 0.025;
    assert!((0.9..1.1).contains(&kept), "the plate keeps its thickness: {kept}");
}

#[test]
fn a_block_at_rest_on_another_is_in_equilibrium() {
    // Reactions between the bodies are no unbalanced force.
    let snapshot = settled(&contact(0.3, 0.0));
    assert!(snapshot.time < 10.0, "it comes to rest, after {} s", snapshot.time);
    let Some(FieldData::Tensor(stress)) = snapshot.field("stress").map(|f| &f.data) else {
        panic!("no stress")
    };
    let mean = stress.iter().map(|s| s[1]).sum::<f64>() / stress.len() as f64;
    // Half of the load of the floor, 1000 kg/m³ × 1 m/s² × 0.8 m.
    assert!((mean / -400.0 - 1.0).abs() < 0.02, "{mean}");
}

#[test]
fn invalid_contacts_are_rejected_by_path() {
    let table = [
        (json!([{ "bodies": ["upper", "roof"] }]), "methods.mpm.contacts[0].bodies"),
        (json!([{ "bodies": ["upper", "upper"] }]), "methods.mpm.contacts[0].bodies"),
        (
            json!([{ "bodies": ["upper", "lower"] }, { "bodies": ["lower", "upper"] }]),
            "methods.mpm.contacts[1].bodies",
        ),
        (
            json!([{ "bodies": ["upper", "lower"], "friction_coefficient": -1 }]),
            "methods.mpm.contacts[0].friction_coefficient",
        ),
        (json!([{ "bodies": ["upper", "lower"], "adhesion": -1 }]), "methods.mpm.contacts[0].adhesion"),
        (json!([{ "bodies": ["upper", "lower"], "normal": [0, 0] }]), "methods.mpm.contacts[0].normal"),
        (json!([{ "bodies": ["upper", "lower"], "normal": [1] }]), "methods.mpm.contacts[0].normal"),
        (
            json!([{ "bodies": ["upper", "lower"], "test": "approach", "penalty": { "stiffness": 1e5 } }]),
            "methods.mpm.contacts[0].penalty",
        ),
        (
            json!([{ "bodies": ["upper", "lower"], "test": "gap", "penalty": { "stiffness": 0 } }]),
            "methods.mpm.contacts[0].penalty",
        ),
        (
            json!([{ "bodies": ["upper", "lower"], "test": "gap",
                     "penalty": { "stiffness": 1, "shear_strength": -1 } }]),
            "methods.mpm.contacts[0].penalty",
        ),
    ];
    for (contacts, path) in table {
        let error =
            Mpm.plan(&blocks([[0.0; 2]; 2], &json!({ "contacts": contacts }))).unwrap_err().to_string();
        assert!(error.starts_with(path), "{contacts}: {error}");
    }
}

#[test]
fn layers_between_walls_are_pressed_together_without_shear() {
    // The sides of both bodies lie on the walls, where the interface is level as everywhere else.
    for test in ["gap", "approach"] {
        for (axis, side) in [(0, "x"), (1, "y")] {
            let turned = |v: [f64; 2]| if axis == 0 { v } else { [v[1], v[0]] };
            let layer = |name: &str, low: f64, high: f64| {
                let shape = json!({ "kind": "box", "min": turned([0.0, low]), "max": turned([1.0, high]) });
                json!({ "name": name, "material": "m", "shape": shape })
            };
            let wall = |side: String| json!({ "side": side, "wall": { "kind": "smooth" } });
            let other = if side == "x" { "y" } else { "x" };
            let report = square().with(json!({
                "domain": { "min": [0, 0], "max": turned([1.0, 2.0]) }, "gravity": turned([0.0, -9.81]),
                "materials": { "m": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
                "bodies": [layer("low", 0.0, 0.8125), layer("high", 0.8125, 1.5)],
                "boundaries": [wall(format!("{side}-min")), wall(format!("{side}-max")), wall(format!("{other}-min"))],
                "stages": [{ "name": "press", "duration": 0.1 }],
                "methods": { "mpm": { "cell_size": 0.125, "contacts": [
                    { "bodies": ["low", "high"], "friction_coefficient": 0, "test": test }
                ] } }
            })).solve(&Mpm);
            let FieldData::Tensor(stress) = &report.snapshot.field("stress").unwrap().data else { panic!() };
            let largest = |c: usize| stress.iter().map(|s| s[c].abs()).fold(0.0, f64::max);
            assert!(largest(1 - axis) > 1e4, "they are pressed");
            assert!(
                largest(3) < 1e-6 * largest(1 - axis),
                "{test}, walls along {other}: shear {}",
                largest(3)
            );
        }
    }
}
