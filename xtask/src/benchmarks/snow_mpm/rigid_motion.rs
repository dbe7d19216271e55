//! Rigid motions, and conserved quantities of the transfers (sheet: snow-mpm V4, V11).

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::analysis::MaxOrNan;
use crate::benchmarks::snow_mpm::{case_with_options, run_snow_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, stresses, vectors};

/// Benchmark of rigid motions, and of the quantities that transfers conserve.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/motion",
    title: "Rigid motions: what the transfers keep",
    source: "sheet: snow-mpm V4, V11",
    short_seconds: Some(20),
    full_seconds: 20,
    run: benchmark,
};

/// Young's modulus (Pa).
const YOUNG: f64 = 1e6;

/// Checks rigid motions, and conserved quantities of the transfers.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let transfers = [
        ("APIC, cubic", json!({ "transfer": "apic" })),
        ("APIC, quadratic", json!({ "transfer": "apic", "shape": "quadratic" })),
        ("FLIP 1", json!({ "transfer": "flip", "flip_ratio": 1 })),
        ("FLIP 0.95", json!({ "transfer": "flip", "flip_ratio": 0.95 })),
        ("PIC", json!({ "transfer": "flip", "flip_ratio": 0 })),
    ];
    let mut chart =
        LineChart::new("Angular momentum of a spinning disc", "time (s)", "over its initial value");
    for (name, options) in &transfers {
        check_free_fall(&mut outcome, name, options)?;
        spin(&mut outcome, &mut chart, name, options)?;
    }
    outcome.svg("One turn: PIC and its blends take the spin, APIC keeps it.", &chart)?;
    Ok(outcome)
}

/// Checks flight under gravity (V4).
fn check_free_fall(outcome: &mut BenchmarkOutcome, name: &str, options: &Value) -> Result<(), String> {
    let mut case = case_with_options("motion", options)?;
    let (dt, end) = (2e-4, 0.1);
    case.gravity = vec![0.0, -9.81];
    case.bodies[0].velocity =
        serde_json::from_value(json!({ "kind": "uniform", "value": [0.5, 1] })).map_err(|e| e.to_string())?;
    case.stages[0].duration = end;
    case.output.measures = Some(dt);
    crate::benchmarks::set_method_option(&mut case, "snow-mpm", "time_step", dt);
    let report = run_snow_case(&case)?;
    let exact = [0.5 * end, end - 0.5 * 9.81 * end * (end + dt)];
    let off = |u: &[f64; 3]| (u[0] - exact[0]).hypot(u[1] - exact[1]);
    let off = vectors(&report.snapshot, "displacement").iter().map(off).max_or_nan();
    let stress = stresses(&report.snapshot).iter().map(colluvium::constitutive::SymTensor::norm).max_or_nan();
    let reason = "round-off over 500 steps";
    outcome.assert_below(
        format!("V4 free fall, {name}: distance from that of the integrator (m)"),
        "0",
        off,
        1e-11,
        reason,
    );
    outcome.assert_below(format!("V4 free fall, {name}: stress over E"), "0", stress / YOUNG, 1e-11, reason);
    Ok(())
}

/// Checks the momenta and the energy of a spinning disc in flight (V11).
fn spin(
    outcome: &mut BenchmarkOutcome,
    chart: &mut LineChart,
    name: &str,
    options: &Value,
) -> Result<(), String> {
    let case = case_with_options("motion", options)?;
    let report = run_snow_case(&case)?;
    let RunReport { start, end, .. } = &report;
    let momentum = (end.momentum[0] - start.momentum[0]).hypot(end.momentum[1] - start.momentum[1])
        / start.momentum[0].hypot(start.momentum[1]);
    let pass = "the sheet's criterion";
    outcome.assert_below(format!("V11 disc, {name}: change of momentum"), "0", momentum, 1e-11, pass);
    let turned = end.angular_momentum[2] / start.angular_momentum[2] - 1.0;
    let energy = (end.kinetic + end.elastic) / start.kinetic - 1.0;
    let name = format!("V11 disc, {name}");
    match name.as_str() {
        n if n.contains("APIC") => {
            outcome.assert_below(
                format!("{name}: change of angular momentum"),
                "0",
                turned.abs(),
                1e-11,
                pass,
            );
            let claim = "3.0e-4 cubic, 4.0e-4 quadratic (sheet's prototype)";
            outcome.assert_within(format!("{name}: share of energy lost"), claim, -energy, (0.0, 1e-3), pass);
        }
        n if n.ends_with("FLIP 1") => {
            let claim = "-0.013 (sheet's prototype)";
            outcome.assert_within(
                format!("{name}: change of angular momentum"),
                claim,
                turned,
                (-0.03, 0.03),
                pass,
            );
            outcome.info(
                format!("{name}: change of energy"),
                "-0.020 (sheet's prototype)",
                energy,
                "no bound in the sheet",
            );
        }
        n => {
            let claim =
                if n.ends_with("PIC") { "-1.00 (sheet's prototype)" } else { "-0.84 (sheet's prototype)" };
            outcome.info(
                format!("{name}: change of angular momentum"),
                claim,
                turned,
                "no bound in the sheet",
            );
        }
    }
    let first = start.angular_momentum[2];
    let share = measure_series(&report, "angular_momentum.z").iter().map(|(t, l)| (*t, l / first)).collect();
    chart.series.push(Series::new(name.trim_start_matches("V11 disc, "), share, Style::Line));
    Ok(())
}
