//! Bodies with a pore fluid: data of grains and fluid in the case have the effect of those in the options of the method.

use colluvium_case::{Case, Method, Solver};
use colluvium_depth_sph::DepthSph;
use colluvium_testkit::{advance_exactly_to, advance_steps, read_case, start_solver};
use serde_json::{Value, json};

const GRAVITY: f64 = 9.81;

/// Saturated column that a depth-resolved model with two phases runs as well.
fn with_fluid(options: &Value) -> Value {
    let mut value = json!({
        "title": "saturated column", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "domain": { "min": [0, 0], "max": [12, 3] },
        "materials": { "sand": {
            "model": "mohr-coulomb", "density": 1590, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "column", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [4, 2] },
            "pore_fluid": { "porosity": 0.4, "permeability": 1e-3 } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "y-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "release", "duration": 1 }],
        "methods": { "depth-sph": { "spacing": 0.1 } }
    });
    value["methods"]["depth-sph"].as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
    value
}

/// The column with its fluid described in the options.
fn with_options(options: &Value) -> Value {
    let mut value = with_fluid(options);
    value["bodies"][0].as_object_mut().unwrap().remove("pore_fluid");
    value["materials"]["sand"]["density"] = json!(1990);
    let mixture = &mut value["methods"]["depth-sph"]["mixture"];
    *mixture = json!({ "grain_density": 1590.0 / 0.6, "fluid_density": 1000, "porosity": 0.4,
        "drag": { "law": "darcy", "permeability": 1e-3 } });
    value
}

fn hash(value: &Value) -> u64 {
    let mut solver = start_solver(&DepthSph, &read_case(value));
    advance_steps(solver.as_mut(), 60);
    solver.snapshot().hash()
}

fn plan(value: &Value) -> Result<Vec<colluvium_case::Warning>, String> {
    let case = Case::from_json(&value.to_string()).map_err(|errors| errors.to_string())?;
    DepthSph.plan(&case).map(|plan| plan.warnings).map_err(|error| error.to_string())
}

#[test]
fn a_pore_fluid_is_equivalent_to_the_mixture_options() {
    for options in [
        json!({}),
        json!({ "phases": "two" }),
        json!({ "column": { "cells": 8, "consolidation": 0.02, "excess_ratio": 0.5 } }),
        json!({ "phases": "two", "column": { "cells": 8, "consolidation": 0.02 } }),
    ] {
        assert_eq!(hash(&with_fluid(&options)), hash(&with_options(&options)), "{options}");
    }
    // Permeability and ratio of excess pressure are properties of the fluid as well.
    let column = json!({ "column": { "cells": 8, "consolidation": 0.02 } });
    let mut own = with_fluid(&column);
    own["bodies"][0]["pore_fluid"]["excess_ratio"] = json!(0.5);
    let mut other = with_options(&column);
    other["methods"]["depth-sph"]["column"]["excess_ratio"] = json!(0.5);
    assert_eq!(hash(&own), hash(&other));
}

#[test]
fn pore_pressure_columns_use_the_stiffness_of_the_body_material() {
    let own = with_fluid(&json!({ "column": { "cells": 8, "excess_ratio": 1 } }));
    let skeleton = json!({ "youngs_modulus": 1e7, "poissons_ratio": 0.3 });
    let other = with_options(&json!({ "column": { "cells": 8, "excess_ratio": 1, "skeleton": skeleton } }));
    assert_eq!(hash(&own), hash(&other));
}

#[test]
fn bodies_of_two_porosities_and_a_fluid_that_moves_by_itself() {
    let mut value =
        with_fluid(&json!({ "phases": "two", "basal": { "model": "coulomb", "friction_angle": 20 } }));
    value["materials"]["loose"] = value["materials"]["sand"].clone();
    value["materials"]["loose"]["density"] = json!(0.5 * 2650.0);
    let mut loose = value["bodies"][0].clone();
    loose["name"] = json!("loose");
    loose["material"] = json!("loose");
    loose["shape"] = json!({ "kind": "box", "min": [4, 0], "max": [6, 1] });
    loose["pore_fluid"]["porosity"] = json!(0.5);
    loose["pore_fluid"]["velocity"] = json!({ "kind": "uniform", "value": [0.25, 0] });
    value["bodies"].as_array_mut().unwrap().push(loose);
    let solver = start_solver(&DepthSph, &read_case(&value));
    let snapshot = solver.snapshot();
    let [phase, mass] = ["phase", "mass"].map(|name| snapshot.scalars(name).unwrap());
    let velocity = snapshot.vectors("velocity").unwrap();
    let mut masses = [[0.0; 2]; 2];
    for (i, x) in snapshot.positions.iter().enumerate() {
        let body = usize::from(x[0] > 4.0);
        masses[body][phase[i] as usize] += mass[i];
        let moves = body == 1 && phase[i] == 1.0;
        assert_eq!(velocity[i][0], if moves { 0.25 } else { 0.0 });
    }
    for (found, exact) in masses.iter().flatten().zip([8.0 * 1590.0, 8.0 * 400.0, 2.0 * 1325.0, 2.0 * 500.0])
    {
        assert!((found / exact - 1.0).abs() < 1e-12, "{found} kg for {exact} kg");
    }
}

/// A separate fluid is decelerated by the zone of the bed below it: `v = v0/(1 + g v0 t/(ξ h))`.
#[test]
fn parts_of_the_bed_have_fluid_resistance_of_their_own() {
    let law = |turbulence: f64| json!({ "law": "turbulent", "turbulence": turbulence });
    let region =
        json!({ "shape": { "kind": "box", "min": [2], "max": [12] }, "fluid_resistance": law(20.0) });
    let mut value = with_options(&json!({ "phases": "two", "regions": [region] }));
    value["boundaries"][1]["wall"] = json!({ "kind": "smooth" });
    value["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [2, 0] });
    let mixture = &mut value["methods"]["depth-sph"]["mixture"];
    mixture["drag"] = json!({ "law": "none" });
    mixture["fluid_resistance"] = law(80.0);
    let mut solver = start_solver(&DepthSph, &read_case(&value));
    let (start, time) = (2.0, 0.05);
    advance_exactly_to(solver.as_mut(), time);
    let snapshot = solver.snapshot();
    let (phase, velocity) = (snapshot.scalars("phase").unwrap(), snapshot.vectors("velocity").unwrap());
    let mut counts = [0; 2];
    for (x, (phase, v)) in snapshot.positions.iter().zip(phase.iter().zip(velocity)) {
        // Waves from the ends of the column and from the border of the zones have not arrived yet.
        let part = [1.0..1.4, 2.6..3.2].iter().position(|part| part.contains(&x[0]));
        let Some(part) = part.filter(|_| *phase == 1.0) else { continue };
        let lost = start - start / (1.0 + GRAVITY * start * time / ([80.0, 20.0][part] * 2.0));
        assert!(((start - v[0]) / lost - 1.0).abs() < 0.02, "at {x:?}: {} of {lost} m/s lost", start - v[0]);
        counts[part] += 1;
    }
    assert!(counts.iter().all(|count| *count > 2), "{counts:?}");
}

#[test]
fn resistance_to_a_fluid_that_does_not_move_by_itself_is_refused() {
    let law = json!({ "law": "laminar", "viscosity": 1 });
    let region = |law: &Value| json!([{ "shape": { "kind": "box", "min": [2], "max": [12] }, "fluid_resistance": law }]);
    let error = plan(&with_fluid(&json!({ "mixture": { "fluid_resistance": law } }))).unwrap_err();
    assert!(
        error.starts_with("methods.depth-sph.mixture.fluid_resistance: applies only to a fluid"),
        "{error}"
    );
    let error = plan(&with_fluid(&json!({ "regions": region(&law) }))).unwrap_err();
    assert!(
        error.starts_with("methods.depth-sph.regions[0].fluid_resistance: applies only to a fluid"),
        "{error}"
    );
    let wrong = json!({ "law": "laminar", "viscosity": -1 });
    let error = plan(&with_fluid(&json!({ "phases": "two", "regions": region(&wrong) }))).unwrap_err();
    assert!(error.starts_with("methods.depth-sph.regions[0].fluid_resistance.viscosity: "), "{error}");
}

/// Excess pressures at the base over 1 to 3 m, away from the front (Pa).
fn excess(solver: &dyn Solver) -> Vec<f64> {
    let snapshot = solver.snapshot();
    let mean = snapshot.scalars("mean_excess_pore_pressure").unwrap();
    let inner = snapshot.positions.iter().zip(mean).filter(|(x, _)| (1.0..3.0).contains(&x[0]));
    inner.map(|(_, value)| *value).collect()
}

/// A field of pore pressure is the initial pressure of columns; a hydrostatic one has no excess.
#[test]
fn columns_begin_with_the_pore_pressure_of_the_fluid() {
    let column = json!({ "column": { "cells": 8, "consolidation": 0 } });
    let submerged = 0.6 * 1650.0 * GRAVITY;
    let weight = 1000.0 * GRAVITY;
    let field = format!("{} * (2 - y)", weight + 0.6 * submerged);
    for (pressure, exact) in [
        (json!({ "kind": "hydrostatic", "surface": 2 }), 0.0),
        (json!({ "kind": "formula", "value": field }), 0.6 * submerged),
        (json!({ "kind": "uniform", "value": weight }), -1.0),
    ] {
        let mut value = with_fluid(&column);
        value["bodies"][0]["pore_fluid"]["pressure"] = pressure.clone();
        let solver = start_solver(&DepthSph, &read_case(&value));
        let found = excess(solver.as_ref());
        assert!(found.len() > 15);
        for value in found {
            if exact >= 0.0 {
                assert!((value - exact).abs() < 1e-9 * submerged, "{pressure}: {value} Pa for {exact} Pa");
            }
        }
        let warned = plan(&value).unwrap();
        // A pressure of a metre of water at all heights exceeds the weight of the grains above the base.
        let held =
            warned.iter().any(|warning| warning.text.starts_with("bodies: the initial pore pressure of"));
        assert_eq!(held, exact < 0.0, "{warned:?}");
        assert!(!warned.iter().any(|warning| warning.text.contains("pressure: is not given")), "{warned:?}");
    }
    let warned = plan(&with_fluid(&json!({}))).unwrap();
    assert!(warned.iter().any(|warning| warning.text.contains("pressure: is not given")), "{warned:?}");
}

#[test]
fn pore_fluid_properties_without_meaning_for_the_flow_are_refused_by_path() {
    let check = |options: Value, fluid: Value, start: &str| {
        let mut value = with_fluid(&options);
        let own = value["bodies"][0]["pore_fluid"].as_object_mut().unwrap();
        own.extend(fluid.as_object().unwrap().clone());
        let error = plan(&value).expect_err(start);
        assert!(error.starts_with(start), "{error}");
    };
    let fluid = "bodies[0].pore_fluid";
    let own = "methods.depth-sph";
    let column = json!({ "column": { "consolidation": 0.02, "excess_ratio": 0.2 } });
    check(json!({ "phases": "layers" }), json!({}), &format!("{fluid}: is not available for two layers"));
    check(
        json!({}),
        json!({ "excess_ratio": 0.5 }),
        &format!("{fluid}.excess_ratio: applies only with pore-pressure columns"),
    );
    check(column.clone(), json!({ "excess_ratio": 0.5 }), &format!("{own}.column.excess_ratio: 0.2 differs"));
    check(json!({}), json!({ "excess_ratio": 1.5 }), &format!("{fluid}.excess_ratio: 1.5 is not in"));
    let uniform = json!({ "kind": "uniform", "value": 1e3 });
    check(
        json!({}),
        json!({ "pressure": uniform }),
        &format!("{fluid}.pressure: applies only with pore-pressure columns"),
    );
    let both = json!({ "pressure": uniform, "excess_ratio": 0.5 });
    check(column, both, &format!("{fluid}.pressure: is given in addition"));
    let low = json!({ "pressure": { "kind": "hydrostatic", "surface": 1.5 } });
    check(json!({}), low, &format!("{fluid}.pressure.surface: 1.5 m differs from the surface of the flow"));
    check(json!({}), json!({ "density": 2700 }), &format!("{fluid}.density: 2700 kg/m³ is not below"));
    let velocity = json!({ "velocity": { "kind": "uniform", "value": [1, 0] } });
    check(json!({}), velocity, &format!("{fluid}.velocity: applies only to a fluid with separate nodes"));
    let upward = json!({ "velocity": { "kind": "uniform", "value": [0, 1] } });
    check(json!({ "phases": "two" }), upward, &format!("{fluid}.velocity.value[1]: must be 0"));
    check(
        json!({}),
        json!({ "cavitation_strength": 2e5 }),
        &format!("{fluid}.cavitation_strength: is above"),
    );
}

#[test]
fn mixture_options_that_contradict_the_pore_fluid_are_refused() {
    let check = |mixture: Value, start: &str| {
        let value = with_fluid(&json!({ "phases": "two", "mixture": mixture }));
        match plan(&value) {
            Ok(_) => assert!(start.is_empty(), "{mixture} is taken"),
            Err(error) => assert!(
                !start.is_empty() && error.starts_with(&format!("methods.depth-sph.mixture.{start}")),
                "{error}"
            ),
        }
    };
    check(json!({ "fluid_resistance": { "law": "laminar", "viscosity": 1 } }), "");
    check(json!({ "grain_density": 2650, "porosity": 0.4 }), "");
    check(json!({ "drag": { "law": "darcy", "permeability": 1e-3 } }), "");
    check(json!({ "grain_density": 2500 }), "grain_density: 2500 differs from the value");
    check(json!({ "fluid_density": 1100 }), "fluid_density: 1100 differs");
    check(json!({ "porosity": 0.5 }), "porosity: 0.5 differs");
    check(
        json!({ "drag": { "law": "darcy", "permeability": 1e-2 } }),
        "drag: gives a permeability of 1.000e-2",
    );
    let mut value = with_fluid(&json!({}));
    let mut dry = value["bodies"][0].clone();
    dry["name"] = json!("dry");
    dry["shape"] = json!({ "kind": "box", "min": [4, 0], "max": [5, 1] });
    let two = |change: &dyn Fn(&mut Value)| {
        let mut other = dry.clone();
        change(&mut other);
        let mut value = value.clone();
        value["bodies"].as_array_mut().unwrap().push(other);
        plan(&value).unwrap_err()
    };
    let error = two(&|body| {
        body.as_object_mut().unwrap().remove("pore_fluid");
    });
    assert!(error.starts_with("bodies[1].pore_fluid: is missing"), "{error}");
    let error = two(&|body| body["pore_fluid"]["permeability"] = json!(1e-4));
    assert!(error.starts_with("bodies[1].pore_fluid.permeability: is not that of the body"), "{error}");
    let error = two(&|body| body["pore_fluid"]["porosity"] = json!(0.3));
    assert!(error.starts_with("bodies[1].pore_fluid.porosity: 0.3 is not that of"), "{error}");
    value["bodies"][0]["pore_fluid"]["excess_ratio"] = json!(0.5);
    assert!(plan(&value).is_err());
}

/// Layer between smooth side walls, which stays at rest, over a permeable bed, by the key `drained` that all methods have.
fn over_a_drained_bed(options: &Value) -> Value {
    let mut value = with_fluid(options);
    value["domain"]["max"] = json!([4, 3]);
    let wall = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
    value["boundaries"] = json!([wall("x-min"), wall("x-max"), wall("y-min")]);
    value["boundaries"][2]["drained"] = json!(true);
    value
}

/// The pressure in excess of the hydrostatic one and that one drain together to zero through both ends: row c of the sheet's table (V13c).
#[test]
fn a_drained_bed_is_open_to_the_air() {
    let column = json!({ "cells": 40, "consolidation": 0.4, "weight": 0.5 });
    let value = over_a_drained_bed(&json!({ "column": column, "max_time_step": 0.01 }));
    let mut other = value.clone();
    other["boundaries"][2].as_object_mut().unwrap().remove("drained");
    let sealed = hash(&other);
    other["methods"]["depth-sph"]["drainage"] = json!({ "kind": "atmospheric" });
    assert_eq!(hash(&value), hash(&other), "as the option says it");
    assert_ne!(hash(&value), sealed);
    let mut solver = start_solver(&DepthSph, &read_case(&value));
    for (factor, exact) in [(0.05, 0.495_912), (0.1, 0.302_118)] {
        let end = factor * 4.0 / 0.4;
        while solver.time() < end {
            solver.step(end - solver.time()).unwrap();
        }
        // All of the pressure is that of the air in the end.
        let air = -1000.0 * GRAVITY;
        for value in excess(solver.as_ref()) {
            let share = 1.0 - value / air;
            // Heads are those of the middle of a step, and the first ones oscillate at the base with Crank and Nicolson.
            assert!((share - exact).abs() < 0.004, "{share} of the pressure is left, not {exact}");
        }
    }
}

#[test]
fn unsupported_drained_walls_are_refused_by_path() {
    let column = json!({ "column": { "consolidation": 0.02 } });
    let check = |change: &dyn Fn(&mut Value), start: &str| {
        let mut value = over_a_drained_bed(&column);
        change(&mut value);
        let error = plan(&value).expect_err(start);
        assert!(error.starts_with(start), "{error}");
    };
    let side = |value: &mut Value| value["boundaries"][0]["drained"] = json!(true);
    check(&side, "boundaries[0].drained: a side wall of depth-sph cannot be drained");
    let sealed = |value: &mut Value| {
        value["methods"]["depth-sph"]["drainage"] = json!({ "kind": "sealed" });
    };
    check(&sealed, "methods.depth-sph.drainage: {\"kind\":\"sealed\"} differs from boundaries[2].drained");
    let without = |value: &mut Value| {
        value["methods"]["depth-sph"].as_object_mut().unwrap().remove("column");
    };
    check(&without, "boundaries[2].drained: applies only with pore-pressure columns");
    let covered = |value: &mut Value| {
        let face = json!({ "kind": "plane", "point": [0, 0.1], "normal": [0, 1] });
        value["obstacles"] = json!([{ "name": "bed", "shape": face, "wall": { "kind": "smooth" } }]);
    };
    check(&covered, "boundaries[2].drained: the obstacles are the bed");
    let above = |value: &mut Value| {
        let wall = json!({ "side": "y-min", "name": "above", "position": 0.2, "wall": { "kind": "smooth" } });
        value["boundaries"].as_array_mut().unwrap().push(wall);
    };
    check(&above, "boundaries[2].drained: the flow is not on this wall");
}
