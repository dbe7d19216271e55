//! Numbers that are not finite: each is refused by its path.

use colluvium_case::Case;
use colluvium_case::Measure;
use colluvium_case::description::{InitialStress, Load, Velocity, Wall};
use colluvium_case::measure;
use colluvium_constitutive::MaterialSpec;
use colluvium_points::Shape;
use serde_json::json;

use super::sound;

/// Path of a number of the case, and the function that sets it.
type Row = (&'static str, fn(&mut Case, f64));

/// Sets a value inside of a variant.
macro_rules! inside {
    ($pattern:pat = $place:expr => $value:expr, $bad:expr) => {
        if let $pattern = $place { *$value = $bad } else { panic!("the case has another variant") }
    };
}

/// Numbers of domain, materials and bodies.
const BODIES: &[Row] = &[
    ("domain.min[0]", |c, bad| c.domain.min[0] = bad),
    ("domain.max[1]", |c, bad| c.domain.max[1] = bad),
    ("gravity[1]", |c, bad| c.gravity[1] = bad),
    ("materials.sand.cohesion", |c, bad| {
        inside!(Some(MaterialSpec::MohrCoulomb(spec)) = c.materials.get_mut("sand") => &mut spec.cohesion, bad);
    }),
    ("bodies[0].shape.min[0]", |c, bad| {
        inside!(Shape::Box { min, .. } = &mut c.bodies[0].shape => &mut min[0], bad);
    }),
    ("bodies[0].stress.value[3]", |c, bad| {
        inside!(InitialStress::Uniform { value } = &mut c.bodies[0].stress => &mut value[3], bad);
    }),
    ("bodies[1].stress.surface", |c, bad| {
        inside!(InitialStress::K0 { surface, .. } = &mut c.bodies[1].stress => surface, bad);
    }),
    ("bodies[1].stress.coefficient", |c, bad| {
        inside!(InitialStress::K0 { coefficient, .. } = &mut c.bodies[1].stress => coefficient, bad);
    }),
    ("bodies[0].velocity.phase", |c, bad| {
        inside!(Velocity::Sine { phase, .. } = &mut c.bodies[0].velocity => phase, bad);
    }),
    ("bodies[1].velocity.gradient[1][0]", |c, bad| {
        inside!(Velocity::Linear { gradient, .. } = &mut c.bodies[1].velocity => &mut gradient[1][0], bad);
    }),
];

/// Numbers of boundaries and loads.
const BOUNDARIES_AND_LOADS: &[Row] = &[
    ("boundaries[0].position", |c, bad| c.boundaries[0].position = Some(bad)),
    ("boundaries[0].velocity[0]", |c, bad| c.boundaries[0].velocity = Some(vec![bad, 0.0])),
    ("boundaries[0].wall.friction_coefficient", |c, bad| {
        c.boundaries[0].wall = Wall::Frictional { friction_coefficient: bad, bilateral: false };
    }),
    ("loads[0].value[1]", |c, bad| {
        inside!(Load::Traction { value, .. } = &mut c.loads[0] => &mut value[1], bad);
    }),
    ("loads[0].ramp", |c, bad| {
        inside!(Load::Traction { ramp, .. } = &mut c.loads[0] => ramp, bad);
    }),
    ("loads[0].profile.shares[1][0]", |c, bad| {
        inside!(Load::Traction { profile: Some(profile), .. } = &mut c.loads[0] => &mut profile.shares[1][0], bad);
    }),
    ("loads[0].profile.shares[1][1]", |c, bad| {
        inside!(Load::Traction { profile: Some(profile), .. } = &mut c.loads[0] => &mut profile.shares[1][1], bad);
    }),
];

/// Numbers of stages and output.
const STAGES_AND_OUTPUT: &[Row] = &[
    ("stages[1].duration", |c, bad| c.stages[1].duration = bad),
    ("stages[1].damping", |c, bad| c.stages[1].damping = bad),
    ("stages[1].gravity_ramp", |c, bad| c.stages[1].gravity_ramp = bad),
    ("stages[1].rayleigh_damping", |c, bad| c.stages[1].rayleigh_damping = bad),
    ("stages[0].equilibrium.kinetic_energy", |c, bad| {
        inside!(Some(criterion) = &mut c.stages[0].equilibrium => &mut criterion.kinetic_energy, bad);
    }),
    ("output.frames", |c, bad| c.output.frames = Some(bad)),
    ("output.measures", |c, bad| c.output.measures = Some(bad)),
    ("output.grid", |c, bad| c.output.grid = Some(bad)),
    ("output.checkpoint", |c, bad| c.output.checkpoint = bad),
];

/// Numbers of measures.
const MEASURES: &[Row] = &[
    ("measures.front.quantile", |c, bad| {
        inside!(Some(Measure::Front(measure::Front { quantile, .. })) = c.measures.get_mut("front") => quantile, bad);
    }),
    ("measures.front.cell", |c, bad| {
        inside!(Some(Measure::Front(measure::Front { cell, .. })) = c.measures.get_mut("front") => cell, Some(bad));
    }),
    ("measures.slide.origin", |c, bad| {
        inside!(Some(Measure::RunOut(measure::RunOut { origin, .. })) = c.measures.get_mut("slide") => origin, bad);
    }),
    ("measures.slide.initial_length", |c, bad| {
        inside!(Some(Measure::RunOut(measure::RunOut { initial_length, .. })) = c.measures.get_mut("slide") => initial_length, bad);
    }),
    ("measures.top.bin", |c, bad| {
        inside!(Some(Measure::Profile(measure::Profile { bin, .. })) = c.measures.get_mut("top") => bin, bad);
    }),
    ("measures.eye.position[0]", |c, bad| {
        inside!(Some(Measure::Probe(measure::Probe { position, .. })) = c.measures.get_mut("eye") => &mut position[0], bad);
    }),
    ("measures.eye.radius", |c, bad| {
        inside!(Some(Measure::Probe(measure::Probe { radius, .. })) = c.measures.get_mut("eye") => radius, bad);
    }),
];

/// Valid case with all its numeric keys.
pub(super) fn numbers() -> Case {
    let mut case = sound();
    case["bodies"][0]["stress"] = json!({ "kind": "uniform", "value": [1, 2, 3, 4, 5, 6] });
    case["bodies"][0]["velocity"] = json!({ "kind": "sine", "amplitude": [0, 1], "wave_vector": [1, 0] });
    case["bodies"][1]["stress"] = json!({ "kind": "k0", "surface": 1, "coefficient": 0.5 });
    case["bodies"][1]["velocity"] =
        json!({ "kind": "linear", "value": [0, 1], "origin": [0, 0], "gradient": [[0, 1], [1, 0]] });
    case["boundaries"][0]["position"] = json!(0);
    case["boundaries"][0]["velocity"] = json!([0, 0]);
    case["loads"][0]["profile"] = json!({ "axis": "x", "shares": [[0, 1], [0.4, 0]] });
    case["output"]["measures"] = json!(0.1);
    case["measures"]["slide"] =
        json!({ "kind": "run-out", "side": "x-max", "origin": 0, "initial_length": 1 });
    case["measures"]["top"] = json!({ "kind": "profile", "axis": 0, "height": 1, "bin": 0.1 });
    Case::from_json(&case.to_string()).unwrap()
}

#[test]
fn numbers_that_are_not_finite_are_refused_by_path() {
    let whole = numbers();
    for (path, set) in [BODIES, BOUNDARIES_AND_LOADS, STAGES_AND_OUTPUT, MEASURES].into_iter().flatten() {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut case = whole.clone();
            set(&mut case, bad);
            let errors = case.validate().expect_err(path);
            assert!(errors.0.iter().any(|error| error.path == *path), "{path} = {bad}, found\n{errors}");
        }
    }
}
