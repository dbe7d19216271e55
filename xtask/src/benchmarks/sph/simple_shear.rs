//! Blocks in a frame with prescribed motion (sheet: sph §5.3, V-14, V-30, V-31; B-02).

use colluvium::case::{Case, Snapshot};
use colluvium::constitutive::{InitialCondition, Mat3, MaterialSpec, ModelFamily, Motion, SymTensor};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::analysis::MaxOrNan;
use crate::benchmarks::sph::waves::{advance, load, start};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, set_method_option, stresses};

/// Benchmark of simple shear inside a frame of particles, and of rigid rotation.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/shear",
    title: "Simple shear in a frame and rigid rotation, SPH",
    source: "Bui and Nguyen 2021, Fig. 14 and §3.2.4; sheet: sph §5.3, V-14, V-30, V-31",
    short_seconds: Some(6),
    full_seconds: 8,
    run,
};

/// Shear modulus (Pa).
const SHEAR_MODULUS: f64 = 1e7 / 2.6;

/// Checks rotation, simple shear and tension of blocks with every law.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    rotation(&mut outcome)?;
    elastic(&mut outcome)?;
    check_slow_tension(&mut outcome, quick)?;
    plastic(&mut outcome)?;
    every_law(&mut outcome)?;
    Ok(outcome)
}

/// Value from its JSON text.
fn parse<T: serde::de::DeserializeOwned>(text: Value) -> Result<T, String> {
    serde_json::from_value(text).map_err(|error| error.to_string())
}

/// Case of a block of particles inside a frame of particles with prescribed motion, at a shear rate (1/s) and an isotropic pressure (Pa).
fn frame(rate: f64, pressure: f64) -> Result<Case, String> {
    let mut case = load("shear/case.json")?;
    for body in &mut case.bodies {
        body.velocity = parse(json!({
            "kind": "linear", "value": [0, 0], "origin": [0, 0], "gradient": [[0, rate], [0, 0]]
        }))?;
        body.stress =
            parse(json!({ "kind": "uniform", "value": [-pressure, -pressure, -pressure, 0, 0, 0] }))?;
    }
    Ok(case)
}

/// Stresses of the particles of the block, the first body.
fn of_block(snapshot: &Snapshot) -> Vec<SymTensor> {
    let all = stresses(snapshot).into_iter().zip(&snapshot.bodies);
    all.filter(|(_, body)| **body == 0).map(|(s, _)| s).collect()
}

/// Mean of stresses.
fn mean(stresses: &[SymTensor]) -> SymTensor {
    let mut sum = SymTensor::ZERO;
    stresses.iter().for_each(|s| sum += *s);
    sum * (1.0 / stresses.len() as f64)
}

/// Smallest distance of two particles over the spacing.
pub(super) fn closest(snapshot: &Snapshot, spacing: f64) -> f64 {
    let x = &snapshot.positions;
    let mut smallest = f64::INFINITY;
    for (i, a) in x.iter().enumerate() {
        for b in &x[i + 1..] {
            smallest = smallest.min((a[0] - b[0]).hypot(a[1] - b[1]));
        }
    }
    smallest / spacing
}

/// Checks ten rigid turns by steps along chords, the motion of a rotating body (V-14).
fn rotation(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (steps, dt) = (6400, 1e-4);
    let angle = 20.0 * std::f64::consts::PI / f64::from(steps);
    let (sin, cos) = angle.sin_cos();
    let mut case = frame(0.0, 0.0)?;
    let turn = [[(cos - 1.0) / dt, -sin / dt], [sin / dt, (cos - 1.0) / dt]];
    let first = SymTensor([3e4, -1e4, 2e4, 1.5e4, 0.0, 0.0]);
    case.bodies[0].shape = parse(json!({ "kind": "box", "min": [15, 15], "max": [15.5, 15.5] }))?;
    case.bodies[1].shape = parse(json!({ "kind": "box", "min": [-2, -2], "max": [2, 2] }))?;
    case.bodies[1].velocity =
        parse(json!({ "kind": "linear", "value": [0, 0], "origin": [0, 0], "gradient": turn }))?;
    case.bodies[1].stress = parse(json!({ "kind": "uniform", "value": first.0 }))?;
    set_method_option(&mut case, "sph", "time_step", dt);
    let mut solver = start(&case)?;
    let (mut worst_invariant, mut worst_stress) = (0.0f64, 0.0f64);
    for step in 1..=steps {
        solver.step(dt).map_err(|error| error.to_string())?;
        // Every eighth of a turn: after half a turn any stress equals the first, whether it rotated or not.
        if step % 80 == 0 {
            let (sin, cos) = (angle * f64::from(step)).sin_cos();
            let exact = first.rotated(&Mat3([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]));
            let snapshot = solver.snapshot();
            let all = stresses(&snapshot);
            let turning = all.iter().zip(&snapshot.bodies).filter(|(_, body)| **body == 1);
            for (stress, _) in turning {
                let invariant =
                    (stress.trace() / first.trace() - 1.0).abs().max((stress.q() / first.q() - 1.0).abs());
                worst_invariant = worst_invariant.max(invariant);
                worst_stress = worst_stress.max((*stress - exact).norm() / first.norm());
            }
        }
    }
    let reason = "V-14: 1e-6 over ten turns";
    outcome.assert_below("V-14, change of the invariants", "0", worst_invariant, 1e-6, reason);
    let reason = "V-14: 1e-6; every eighth of a turn";
    outcome.assert_below("V-14, difference of the stress from R σ Rᵀ", "0", worst_stress, 1e-6, reason);
    Ok(())
}

/// Checks the oscillation of the stress of the Jaumann rate in large shear (V-30).
fn elastic(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart =
        LineChart::new("Simple shear of an elastic block", "shear strain", "stress over shear modulus");
    let closed = |f: fn(f64) -> f64| (0..=40).map(|k| f64::from(k) * 0.01).map(|g| (g, f(g))).collect();
    chart.series.push(Series::new("sin γ", closed(f64::sin), Style::Dashed));
    chart.series.push(Series::new("1 - cos γ", closed(|g| 1.0 - g.cos()), Style::Dashed));
    for operator in ["corrected", "difference", "compatible"] {
        let mut case = frame(1.0, 0.0)?;
        set_method_option(&mut case, "sph", "velocity_gradient", operator);
        let found = shear_elastic(&case, 1.0)?;
        judge_elastic(outcome, &format!("V-30, {operator}"), &found, 0.0, operator == "corrected");
        if operator == "corrected" {
            chart.series.push(Series::new(
                "σ_xy",
                found.iter().map(|(g, s)| (*g, s.0[3])).collect(),
                Style::Markers,
            ));
            chart.series.push(Series::new(
                "σ_xx",
                found.iter().map(|(g, s)| (*g, s.0[0])).collect(),
                Style::Markers,
            ));
        }
    }
    outcome
        .svg("V-30: mean stress of the free particles against the closed form of the Jaumann rate.", &chart)
}

/// Mean stress of the block over the shear modulus, at shear strains of 0.1 to 0.4.
fn shear_elastic(case: &Case, rate: f64) -> Result<Vec<(f64, SymTensor)>, String> {
    let mut solver = start(case)?;
    let mut found = Vec::new();
    while found.len() < 4 {
        advance(&mut *solver)?;
        if rate * solver.time() >= 0.1 * (found.len() + 1) as f64 {
            found.push((rate * solver.time(), mean(&of_block(&solver.snapshot())) * (1.0 / SHEAR_MODULUS)));
        }
    }
    Ok(found)
}

/// Checks an elastic path. `pressure` is the initial one over the shear modulus; with a `corrected` gradient linear fields are exact.
fn judge_elastic(
    outcome: &mut BenchmarkOutcome,
    name: &str,
    found: &[(f64, SymTensor)],
    pressure: f64,
    corrected: bool,
) {
    let tolerance = if corrected { 0.005 } else { 0.02 };
    let reason = format!("V-30: {} % for γ up to 0.4", tolerance * 100.0);
    let of_shear = format!("V-30: none, within {} % of σ_xy", tolerance * 100.0);
    for (gamma, stress) in found {
        let label = |what: &str| format!("{name}: {what} at γ = {gamma:.3}");
        outcome.assert_close(label("σ_xy/G"), gamma.sin(), tolerance, stress.0[3], &reason);
        let exact = 1.0 - gamma.cos();
        let normal = [("σ_xx/G", stress.0[0] + pressure), ("-σ_yy/G", -stress.0[1] - pressure)];
        if corrected {
            for (what, found) in normal {
                outcome.assert_close(label(what), exact, tolerance, found, &reason);
            }
        } else {
            let mean = 0.5 * (normal[0].1 + normal[1].1);
            outcome.assert_close(label("(σ_xx - σ_yy)/2G"), exact, tolerance, mean, &reason);
            let reason = "not judged: of the uncorrected gradient the sheet gives σ_xy and a spurious σ_zz; the spurious part \
                          is in all normal stresses";
            for (what, found) in normal {
                outcome.info(label(what), &format!("{exact:.5}"), found, reason);
            }
        }
        let out_of_plane = (stress.0[2] + pressure).abs() / gamma.sin();
        outcome.assert_below(label("|σ_zz/σ_xy|"), "0", out_of_plane, tolerance, &of_shear);
    }
}

/// Checks the tensile instability, which grows with time, not with strain: a slow block in tension clumps before the strain at which it is
/// checked. Under a pressure above its tensions it has none.
fn check_slow_tension(outcome: &mut BenchmarkOutcome, quick: bool) -> Result<(), String> {
    let rates: &[f64] = if quick { &[0.1] } else { &[0.1, 0.03] };
    for &rate in rates {
        let found = shear_elastic(&frame(rate, 0.5 * SHEAR_MODULUS)?, rate)?;
        judge_elastic(outcome, &format!("V-30, {rate}/s under p = G/2, corrected"), &found, 0.5, true);
    }
    let mut solver = start(&frame(0.1, 0.0)?)?;
    while solver.time() < 3.0 {
        if advance(&mut *solver).is_err() {
            break;
        }
    }
    let reason = "not judged: the sheet gives no rate. The growth of the instability in tension is a matter of time: at \
                  0.1/s the unconfined block clumps where it does not at 1/s";
    let smallest = closest(&solver.snapshot(), 0.5);
    outcome.info(
        "V-30, 0.1/s without pressure: closest particles over the spacing at γ = 0.3",
        "1",
        smallest,
        reason,
    );
    Ok(())
}

/// Checks yield in simple shear (V-31): Drucker–Prager without dilatancy keeps its pressure.
fn plastic(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    // Slow, for the steady state of small steps: a step of the strain at yield would leave s_xx a tenth too large.
    let mut case = frame(0.1, 50e3)?;
    case.materials.insert(
        "m".into(),
        parse(json!({
            "model": "drucker-prager", "density": 2700, "youngs_modulus": 1e7, "poissons_ratio": 0.3,
            "friction_angle": 30, "matching": "plane-strain"
        }))?,
    );
    let mut solver = start(&case)?;
    while solver.time() < 0.6 {
        advance(&mut *solver)?;
    }
    let snapshot = solver.snapshot();
    let stress = mean(&of_block(&snapshot));
    let strength = 25e3;
    let ratio = strength / SHEAR_MODULUS;
    let reason = "V-31: 2 %";
    outcome.assert_close("V-31, pressure (Pa)", 50e3, 0.02, stress.pressure(), reason);
    outcome.assert_close("V-31, √J2 (Pa)", strength, 0.02, stress.j2().sqrt(), reason);
    let shear = strength * (1.0 - ratio * ratio).sqrt();
    outcome.assert_close("V-31, s_xy (Pa)", shear, 0.02, stress.0[3], reason);
    let deviator = stress.deviator();
    let found = 0.5 * (deviator.0[0] - deviator.0[1]);
    outcome.assert_close("V-31, s_xx (Pa)", strength * ratio, 0.02, found, reason);
    let central: Vec<f64> = snapshot
        .positions
        .iter()
        .zip(stresses(&snapshot))
        .filter(|(x, _)| x[0].abs() < 2.5 && x[1].abs() < 2.5)
        .map(|(_, s)| s.0[3])
        .collect();
    let middle = central.iter().sum::<f64>() / central.len() as f64;
    let spread =
        (central.iter().map(|s| (s - middle).powi(2)).sum::<f64>() / central.len() as f64).sqrt() / middle;
    outcome.assert_below(
        "V-31, standard deviation of σ_xy in the middle",
        "homogeneous",
        spread,
        0.02,
        "V-31: below 2 %",
    );
    Ok(())
}

/// Checks the stress of the block against the law, for every law in rate form.
fn every_law(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut names: Vec<&str> = Vec::new();
    for mut spec in MaterialSpec::examples() {
        // A band has the same length in the frame and in the law alone: that of a particle, below which the example does not snap back.
        if let MaterialSpec::DoubleScale(law) = &mut spec {
            law.size = Some(0.5);
        }
        let facts = spec.model_info();
        if facts.kind != ModelFamily::Solid || !facts.strain.contains("rate") {
            continue;
        }
        let number = names.iter().filter(|name| **name == spec.name()).count() + 1;
        names.push(spec.name());
        let name = format!(
            "frame against the law: {} {number}, largest difference of stress over its size",
            spec.name()
        );
        let found = compare(&spec).map_err(|error| format!("{}: {error}", spec.name()))?;
        outcome.assert_below(
            name,
            "0",
            found,
            0.03,
            "B-02: mean of the block within 3 % of the element driver",
        );
    }
    Ok(())
}

/// Largest difference between the mean stress of a block and that of the law on the same path, over the stress.
fn compare(spec: &MaterialSpec) -> Result<f64, String> {
    let (pressure, steps, shear) = (100e3, 150.0, 0.03);
    let mut case = frame_case(spec, 0.0, pressure)?;
    let dt = start(&case)?.limit().dt;
    let rate = shear / (steps * dt);
    set_method_option(&mut case, "sph", "time_step", dt);
    let path =
        law_comparison(&mut case, spec, ShearPath { rate, pressure, shear, rows: 10, hourglass: 0.0 })?;
    let apart = path.iter().map(|(_, ours, law)| (*ours - *law).norm() / law.norm().max(1e-3 * pressure));
    Ok(apart.max_or_nan())
}

/// Case of 10 × 10 free particles of a material inside a frame of particles that move with the shear rate (1/s), from an isotropic pressure
/// (Pa).
fn frame_case(spec: &MaterialSpec, rate: f64, pressure: f64) -> Result<Case, String> {
    let mut case = frame(rate, pressure)?;
    case.materials.insert("m".into(), spec.clone());
    case.bodies[0].shape = parse(json!({ "kind": "box", "min": [-2.5, -2.5], "max": [2.5, 2.5] }))?;
    case.bodies[1].shape = parse(json!({
        "kind": "difference", "from": { "kind": "box", "min": [-4, -4], "max": [4, 4] },
        "cut": { "kind": "box", "min": [-2.5, -2.5], "max": [2.5, 2.5] }
    }))?;
    Ok(case)
}

/// Shear strain, mean stress of the block (Pa), and stress of the law (Pa).
pub(super) type ShearRow = (f64, SymTensor, SymTensor);

/// Path of simple shear from an isotropic pressure.
#[derive(Clone, Copy)]
pub(super) struct ShearPath {
    /// Rate of shear (1/s).
    pub rate: f64,
    /// Initial pressure (Pa).
    pub pressure: f64,
    /// Shear at the end.
    pub shear: f64,
    /// Number of rows of the result.
    pub rows: usize,
    /// Option `hourglass_viscosity` of the method.
    pub hourglass: f64,
}

/// Stresses in simple shear of a block of 10 × 10 particles and of the law, along a path.
pub(super) fn law_in_frame(spec: &MaterialSpec, path: ShearPath) -> Result<Vec<ShearRow>, String> {
    law_comparison(&mut frame_case(spec, path.rate, path.pressure)?, spec, path)
}

/// Stresses of the block beside those of the law at a point, in simple shear.
fn law_comparison(case: &mut Case, spec: &MaterialSpec, path: ShearPath) -> Result<Vec<ShearRow>, String> {
    let ShearPath { rate, pressure, shear, rows, hourglass } = path;
    set_method_option(case, "sph", "hourglass_viscosity", hourglass);
    for body in &mut case.bodies {
        body.velocity = parse(json!({
            "kind": "linear", "value": [0, 0], "origin": [0, 0], "gradient": [[0, rate], [0, 0]]
        }))?;
    }
    let mut solver = start(case)?;
    let law = spec.build().map_err(|error| error.to_string())?;
    let initial = InitialCondition { stress: SymTensor::isotropic(-pressure), density: spec.density() };
    let (mut stress, mut states) = law.initial(&[initial]).map_err(|error| error.source.to_string())?;
    let mut found = Vec::new();
    while found.len() < rows {
        let dt = advance(&mut *solver)?;
        let l = Mat3([[0.0, rate, 0.0], [0.0; 3], [0.0; 3]]);
        let motion =
            Motion::from_velocity_gradient(&l, dt, spec.density(), 0.5).ok_or("a singular motion")?;
        law.update(&[motion], &mut stress, &mut states.blocks_mut()[0])
            .map_err(|error| error.source.to_string())?;
        let strain = rate * solver.time();
        if strain >= shear * (found.len() + 1) as f64 / rows as f64 * (1.0 - 1e-9) {
            found.push((strain, mean(&of_block(&solver.snapshot())), stress[0]));
        }
    }
    Ok(found)
}
