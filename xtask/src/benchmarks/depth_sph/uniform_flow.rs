//! Uniform flows and drag, with equal motion of all columns (sheet: depth-sph §5.5, V15, V16, V22, V22b).

use colluvium::constitutive::basal::{BasalFlow, plug_ratio, plug_ratio_quadratic};
use colluvium::depth_sph::bed::Bed;
use colluvium::depth_sph::config::choices::{DepthFrame, Phases};
use colluvium::depth_sph::config::settings::{BedZone, FlowSettings};
use colluvium::depth_sph::laws::interphase_drag::InterphaseDrag;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::benchmarks::depth_sph::common_cases::{
    basal_law, block, endless_layer, grains_in_water, load, start, step_flow_until, step_until,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, scalars, set_material, set_method_option, vectors};

/// Benchmark of uniform flows down planes, and of the drag between two phases.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/uniform",
    title: "Uniform flows down planes and drag of two phases",
    source: "sheet: depth-sph §5.5, V15, V16, V22, V22b",
    short_seconds: Some(4),
    full_seconds: 15,
    run,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;

/// Checks the velocities of uniform flows by several basal laws, and the drag between two phases.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    drag(&mut outcome)?;
    laws(&mut outcome)?;
    voellmy(&mut outcome)?;
    quadratic(&mut outcome)?;
    check_slip(&mut outcome, quick)?;
    Ok(outcome)
}

/// Checks that the slip between the phases relaxes exponentially with steps of any size (V15).
fn drag(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let exact = |t: f64| {
        let beta = InterphaseDrag::Anderson { settling_velocity: 0.1.into(), exponent: 1.0 }.relaxation(
            0.3,
            0.0,
            &grains_in_water(0.3).densities,
        );
        let slip = (-beta * t).exp();
        let mean = 300.0 / 2050.0;
        (mean - 300.0 / 2050.0 * slip, mean + 1750.0 / 2050.0 * slip)
    };
    for (time, steps, printed) in [
        (1e-3, 1, [0.048_462, 0.717_303]),
        (1e-3, 10, [0.048_462, 0.717_303]),
        (1e-2, 1, [0.143_720, 0.161_635]),
        (1e-2, 7, [0.143_720, 0.161_635]),
    ] {
        let mut settings = FlowSettings::single_phase(2050.0);
        settings.material = grains_in_water(0.3);
        settings.phases = Phases::Two;
        settings.drag = InterphaseDrag::Anderson { settling_velocity: 0.1.into(), exponent: 1.0 };
        let mut flow = endless_layer(settings, 1.0, &[0.7, 0.3])?;
        flow.nodes.sets[1].nodes.velocity.fill([1.0]);
        for _ in 0..steps {
            flow.advance(time / f64::from(steps)).map_err(|failure| failure.to_string())?;
        }
        let found = [0, 1].map(|set| flow.nodes.sets[set].nodes.velocity[3][0]);
        let (solid, fluid) = exact(time);
        let name = |what: &str| format!("V15, {:.0} ms in {steps} steps: {what}", 1e3 * time);
        outcome.assert_close(name("velocity of the grains (m/s)"), solid, 1e-10, found[0], "V15: 1e-10");
        outcome.assert_close(name("velocity of the fluid (m/s)"), fluid, 1e-10, found[1], "V15: 1e-10");
        let momentum = (1750.0 * found[0] + 300.0 * found[1]) / 300.0;
        outcome.assert_close(name("momentum over the first"), 1.0, 1e-10, momentum, "V15: 1e-10");
        let apart = (found[0] - printed[0]).abs().max((found[1] - printed[1]).abs());
        let reason = "V15: the digits of the sheet";
        outcome.assert_below(name("difference from the printed values (m/s)"), "0", apart, 6e-7, reason);
    }
    Ok(())
}

/// Checks the speeds at which basal resistance balances the weight (V22).
fn laws(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let viscous = |consistency: f64, exponent: f64| json!({ "model": "viscous-frictional", "friction_angle": 10, "consistency": consistency, "exponent": exponent });
    let rows = [
        ("Bingham", json!({ "model": "bingham", "yield_stress": 2000, "viscosity": 100 }), 7.443_834),
        ("Voellmy", json!({ "model": "voellmy", "friction_angle": 10, "turbulence": 400 }), 5.949_799),
        ("viscous and frictional, m = 1", viscous(500.0, 1.0), 1.157_583),
        ("viscous and frictional, m = 2", viscous(50.0, 2.0), 2.357_202),
        ("viscous and frictional, m = 0.5", viscous(2000.0, 0.5), 0.188_437),
    ];
    for (name, basal, exact) in rows {
        // A single column: in a layer roll waves grow out of round-off within two minutes.
        let mut settings = FlowSettings::single_phase(2000.0);
        settings.frame = DepthFrame::BedFitted;
        settings.gravity = GRAVITY * 15f64.to_radians().cos();
        settings.plan_gravity = [GRAVITY * 15f64.to_radians().sin()];
        settings.zones = vec![BedZone::unbounded(basal_law(basal)?)];
        let mut flow = block(settings, Bed::Flat(0.0), 1.0, 0.0, 0.0)?;
        step_flow_until(&mut flow, 120.0)?;
        let found = flow.nodes.sets[0].nodes.velocity[0][0];
        outcome.assert_close(
            format!("V22, {name}: steady velocity (m/s)"),
            exact,
            0.001,
            found,
            "V22: 0.1 %",
        );
    }
    Ok(())
}

/// Checks the transition to the steady speed of Voellmy's law (V22).
fn voellmy(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut case = load("uniform")?;
    set_method_option(&mut case, "depth-sph", "max_time_step", 2e-3);
    let mut solver = start(&case)?;
    let mut found = Vec::new();
    let (mut path, mut before) = (0.0, 0.0);
    while path < 201.0 {
        let advance = solver.step(2e-3).map_err(|error| error.to_string())?;
        let speed = vectors(&solver.snapshot(), "velocity")[10][0];
        path += 0.5 * (speed + before) * advance.dt;
        before = speed;
        found.push((path, speed));
    }
    for (place, exact) in [(10.0, 3.704_579), (50.0, 5.687_964), (200.0, 5.949_635)] {
        let after = found.partition_point(|(path, _)| *path < place);
        let (a, b) = (found[after - 1], found[after]);
        let speed = a.1 + (b.1 - a.1) * (place - a.0) / (b.0 - a.0);
        let name = format!("V22, Voellmy: velocity after {place} m (m/s)");
        outcome.assert_close(name, exact, 0.001, speed, "V22: 0.1 %");
    }
    let mut chart = LineChart::new("Block with Voellmy's resistance", "path (m)", "velocity (m/s)");
    let closed = |s: f64| 5.949_799 * (1.0 - (-2.0 * GRAVITY * s / 400.0).exp()).sqrt();
    let exact = (0..=200).map(|k| (f64::from(k), closed(f64::from(k)))).collect();
    let shown = found.iter().step_by(100).copied().collect();
    chart.series.push(Series::new("closed form", exact, Style::Dashed));
    chart.series.push(Series::new("layer", shown, Style::Markers));
    outcome.svg("V22: from rest to the steady speed.", &chart)
}

/// Checks the quadratic approximation of the Bingham law (V22b), and the plug of a Bingham layer (V22).
fn quadratic(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let a = 6.0 * 100.0 * 7.443_834 / 2000.0;
    outcome.assert_close(
        "V22: plug of Bingham's profile over the depth",
        0.393_854,
        1e-5,
        plug_ratio(a),
        "V22: digits",
    );
    let found = plug_ratio_quadratic(a);
    outcome.assert_close("V22b: plug by the quadratic formula", 0.389_805, 1e-5, found, "V22b: 1e-5");
    let quadratic =
        json!({ "model": "bingham", "yield_stress": 2000, "viscosity": 100, "solution": "quadratic" });
    let Some(law) = basal_law(quadratic)? else { return Err("no law".to_owned()) };
    let flow = BasalFlow {
        depth: 1.0,
        speed: 7.443_834,
        normal_stress: 2000.0 * GRAVITY * 15f64.to_radians().cos(),
        pore_pressure: 0.0,
        slope: 0.0,
        unit_weight: 2000.0 * GRAVITY,
    };
    let stress = law.shear_stress(&flow).map_err(|error| error.to_string())?;
    outcome.assert_close("V22b: stress by the quadratic formula (Pa)", 5130.775, 1e-5, stress, "V22b: 1e-5");
    Ok(())
}

/// Checks the steady slip of two phases that flow down a plane, with two step sizes (V16 as amended).
fn check_slip(outcome: &mut BenchmarkOutcome, quick: bool) -> Result<(), String> {
    let rows: &[(f64, f64, f64)] =
        &[(0.2, 11.312_248, 11.325_275), (2.0, 11.289_565, 11.416_578), (20.0, 11.107_454, 12.118_465)];
    let steps: &[f64] = if quick { &[2e-2, 5e-3] } else { &[2e-2, 5e-3, 1e-3] };
    for (settling, solid, fluid) in rows.iter().take(if quick { 1 } else { 3 }) {
        let steps = if *settling > 0.5 { &steps[1..2] } else { steps };
        for step in steps {
            let found = steady_velocities(*settling, *step, true)?;
            let name = |what: &str| format!("V16, V_T = {settling} m/s, steps of {} ms: {what}", 1e3 * step);
            outcome.assert_close(name("grains (m/s)"), *solid, 0.001, found[0], "V16: 0.1 %");
            outcome.assert_close(name("fluid (m/s)"), *fluid, 0.001, found[1], "V16: 0.1 %");
            let reason = "V16 as amended: 2 % at two steps";
            outcome.assert_close(name("slip (m/s)"), fluid - solid, 0.02, found[1] - found[0], reason);
        }
    }
    for step in &steps[..2] {
        let found = steady_velocities(0.2, *step, false)?;
        let name = format!("V16, no resistance to the fluid, steps of {} ms: slip (m/s)", 1e3 * step);
        outcome.assert_close(name, 0.033_147, 0.02, found[1] - found[0], "V16 as amended: 2 % at two steps");
    }
    Ok(())
}

/// Steady velocities of grains and fluid on a slope of 25 degrees (m/s).
fn steady_velocities(settling: f64, step: f64, fluid_bed: bool) -> Result<[f64; 2], String> {
    let mut case = load("uniform")?;
    let (sin, cos) = 25f64.to_radians().sin_cos();
    case.gravity = vec![GRAVITY * sin, -GRAVITY * cos];
    set_material(&mut case, "debris", &[("density", json!(2020.0))])?;
    set_method_option(
        &mut case,
        "depth-sph",
        "basal",
        json!({ "model": "voellmy", "friction_angle": 20, "turbulence": 500 }),
    );
    let velocity = json!({ "kind": "uniform", "value": [11.3, 0] });
    case.bodies[0].velocity = serde_json::from_value(velocity).map_err(|error| error.to_string())?;
    set_method_option(&mut case, "depth-sph", "phases", "two");
    let mut mixture = json!({ "grain_density": 2700, "porosity": 0.4,
        "drag": { "law": "anderson", "settling_velocity": settling } });
    if fluid_bed {
        mixture["fluid_resistance"] = json!({ "law": "turbulent", "turbulence": 500 });
    }
    set_method_option(&mut case, "depth-sph", "mixture", mixture);
    set_method_option(&mut case, "depth-sph", "max_time_step", step);
    let mut solver = start(&case)?;
    step_until(&mut *solver, 20.0)?;
    let snapshot = solver.snapshot();
    let velocity = vectors(&snapshot, "velocity");
    let phases = scalars(&snapshot, "phase");
    let of = |phase: f64| phases.iter().position(|own| *own == phase).map_or(f64::NAN, |i| velocity[i][0]);
    Ok([of(0.0), of(1.0)])
}
