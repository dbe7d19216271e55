//! Cantilever in its first mode (sheet: sph V-37).

use colluvium::case::{Budget, RunReport, Snapshot};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_in_memory, set_method_option};

/// Benchmark of an elastic cantilever by updated- and total-Lagrangian SPH.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/cantilever",
    title: "Elastic cantilever, updated and total Lagrangian SPH",
    source: "Gray, Monaghan & Swift 2001; sheet: sph V-37",
    short_seconds: None,
    full_seconds: 400,
    run,
};

/// Length of the beam (m).
const LENGTH: f64 = 0.2;
/// Speed of sound (m/s).
const SPEED: f64 = 63.25;
/// Period of the thin beam (s), from the dimensionless period `T c0 / L` of the sheet.
const PERIOD: f64 = 72.4389 * LENGTH / SPEED;
/// Amplitude of the deflection, `V_f c0 / ω`.
const AMPLITUDE: f64 = 0.02306;

/// Form of the method with which the cantilever is run.
struct CantileverVariant {
    name: &'static str,
    options: Vec<(&'static str, Value)>,
    /// Bounds of the period over that of the thin beam.
    bounds: Option<(f64, f64)>,
    claim: &'static str,
}

/// Compared forms of the momentum equation and stabilisations.
fn variants() -> Vec<CantileverVariant> {
    vec![
        CantileverVariant {
            name: "corrected",
            options: vec![],
            bounds: Some((1.0, 1.18)),
            claim: "1 to 1.18; the sheet's code 1.15",
        },
        CantileverVariant {
            name: "corrected on both sides",
            options: vec![("momentum", json!("corrected"))],
            bounds: Some((1.0, 1.18)),
            claim: "1 to 1.18",
        },
        CantileverVariant {
            name: "uncorrected",
            options: vec![("velocity_gradient", json!("compatible"))],
            bounds: None,
            claim: "the sheet's code 1.21",
        },
        CantileverVariant {
            name: "corrected, no artificial stress",
            options: vec![("tensile", json!({ "kind": "none" }))],
            bounds: None,
            claim: "",
        },
        CantileverVariant {
            name: "total Lagrangian",
            options: vec![("tensile", json!({ "kind": "none" })), ("formulation", json!("total-lagrangian"))],
            bounds: Some((1.0, 1.18)),
            claim: "1 to 1.18",
        },
    ]
}

/// Checks the period of a cantilever in its first mode.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart::new("Tip of the cantilever", "time (s)", "deflection (m)");
    for variant in variants() {
        let mut case = load_case("sph/cantilever")?;
        for (option, value) in &variant.options {
            set_method_option(&mut case, "sph", option, value.clone());
        }
        let report = run_in_memory("sph", &case)?;
        judge(&mut outcome, &variant, &report);
        chart.series.push(Series::new(variant.name, tip(&report), Style::Line));
    }
    check_refinement(&mut outcome)?;
    let exact = (0..=100).map(|k| 0.0016 * f64::from(k));
    let exact = exact.map(|t| (t, AMPLITUDE * (std::f64::consts::TAU * t / PERIOD).sin())).collect();
    chart.series.push(Series::new("thin beam", exact, Style::Dashed));
    outcome.svg("Deflection of the tip against the theory of thin beams.", &chart)?;
    Ok(outcome)
}

/// Deflection of the tip over time (m).
fn tip(report: &RunReport) -> Vec<(f64, f64)> {
    deflection(report, 1)
}

/// Mean deflection of the last columns of the beam along an axis, over time (m).
pub(super) fn deflection(report: &RunReport, across: usize) -> Vec<(f64, f64)> {
    let start = &report.frames[0].positions;
    let end = start.iter().map(|x| x[0]).fold(f64::NEG_INFINITY, f64::max);
    let last: Vec<usize> = (0..start.len()).filter(|&i| start[i][0] > end - 1e-6).collect();
    let mean = |frame: &Snapshot| {
        last.iter().map(|&i| frame.positions[i][across] - start[i][across]).sum::<f64>() / last.len() as f64
    };
    report.frames.iter().map(|frame| (frame.time, mean(frame))).collect()
}

/// Twice the time between the start and the first return through zero (s).
pub(super) fn period(tip: &[(f64, f64)]) -> f64 {
    let crossing = tip.windows(2).find(|pair| pair[0].1 > 0.0 && pair[1].1 <= 0.0);
    crossing.map_or(f64::NAN, |pair| {
        let ((t, y), (u, z)) = (pair[0], pair[1]);
        2.0 * (t + (u - t) * y / (y - z))
    })
}

/// Least distance of two particles over the spacing.
fn closest(snapshot: &Snapshot) -> f64 {
    let (x, spacing) = (&snapshot.positions, snapshot.extents[0][0]);
    let mut smallest = f64::INFINITY;
    for i in 0..x.len() {
        for j in 0..i {
            smallest = smallest.min((x[i][0] - x[j][0]).hypot(x[i][1] - x[j][1]));
        }
    }
    smallest / spacing
}

/// Checks period and damping of a variant.
fn judge(outcome: &mut BenchmarkOutcome, variant: &CantileverVariant, report: &RunReport) {
    let tip = tip(report);
    let ratio = period(&tip) / PERIOD;
    let name = |what: &str| format!("{}: {what}", variant.name);
    let reason = "V-37: up to 18 % above the thin beam at a tenth of the height, with correction";
    match variant.bounds {
        Some(bounds) => {
            outcome.assert_within(
                name("period over that of the thin beam"),
                variant.claim,
                ratio,
                bounds,
                reason,
            );
        }
        None => outcome.info(
            name("period over that of the thin beam"),
            variant.claim,
            ratio,
            "V-37 judges the corrected gradient",
        ),
    }
    let amplitude = tip.iter().map(|(_, y)| *y).max_or_nan() / AMPLITUDE;
    outcome.info(name("amplitude over that of the thin beam"), "1", amplitude, "the sheet gives no bound");
    let smallest = report.frames.last().map_or(f64::NAN, closest);
    let range = (0.5, 1.5);
    if variant.name == "corrected, no artificial stress" {
        outcome.info(
            name("least distance over spacing"),
            "",
            smallest,
            "shown: what the artificial stress is for",
        );
    } else {
        outcome.assert_within(
            name("least distance over spacing"),
            "no clumping",
            smallest,
            range,
            "V-37: no clumping; half a spacing as in V-36",
        );
    }
}

/// Checks the effect of refinement, and the loss of amplitude without viscosity.
fn check_refinement(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut case = load_case("sph/cantilever")?;
    set_method_option(&mut case, "sph", "spacing", 0.001);
    let fine = period(&tip(&run_in_memory("sph", &case)?)) / PERIOD;
    let reason = "V-37: decreasing with refinement";
    let coarse = outcome.checks[0].measured;
    let name = "corrected, twice as fine: period over that of the thin beam";
    outcome.assert_within(name, "below the coarse one", fine, (1.0, coarse), reason);
    without_viscosity(outcome)
}

/// Checks the period and the loss of amplitude without viscosity (V-37). Artificial stress does work that no stress power balances, and so
/// does the corrected gradient with a momentum equation that is not its conjugate.
fn without_viscosity(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let none = || ("tensile", json!({ "kind": "none" }));
    let both = || ("momentum", json!("corrected"));
    let compatible = || ("velocity_gradient", json!("compatible"));
    /// Name of a run, its options, and whether it has bounds.
    type Run = (&'static str, Vec<(&'static str, Value)>, bool);
    let runs: [Run; 5] = [
        ("corrected on both sides", vec![both(), none()], true),
        ("uncorrected", vec![compatible(), none()], true),
        ("total Lagrangian", vec![none(), ("formulation", json!("total-lagrangian"))], true),
        ("corrected in the velocity gradient only", vec![none()], false),
        (
            "corrected, artificial stress, a tenth against hourglass modes",
            vec![("hourglass_viscosity", json!(0.1))],
            false,
        ),
    ];
    for (name, options, judged) in runs {
        let mut case = load_case("sph/cantilever")?;
        for (option, value) in options {
            set_method_option(&mut case, "sph", option, value);
        }
        set_method_option(&mut case, "sph", "viscosity_linear", 0.0);
        case.stages[0].duration = 0.45;
        // A run that stops counts as the loss of all amplitude.
        let report = run_in_memory("sph", &case).ok();
        let loss = report.as_ref().map_or(f64::NAN, |report| loss(&tip(report)));
        let label = |what: &str| format!("{name}, no viscosity: {what}");
        if !judged {
            let reason = "not judged: no pair, or not without viscosity. NaN where the run stops";
            outcome.info(label("loss of amplitude in a period"), "", loss, reason);
            continue;
        }
        let reason = "V-37: less than 10 % per period without viscosity";
        outcome.assert_below(label("loss of amplitude in a period"), "< 0.1", loss, 0.1, reason);
        let smallest = report.as_ref().and_then(|report| report.frames.last()).map_or(f64::NAN, closest);
        let reason = "V-37: no clumping; half a spacing as in V-36";
        outcome.assert_within(
            label("least distance over spacing"),
            "no clumping",
            smallest,
            (0.5, 1.5),
            reason,
        );
        let turn = report.as_ref().map_or(f64::NAN, |report| period(&tip(report)) / PERIOD);
        let reason = "not judged here: without artificial stress particles draw together in tension, and the beam is softer";
        outcome.info(label("period over that of the thin beam"), "", turn, reason);
        let energy = report.as_ref().map_or(f64::NAN, |report| {
            let of = |budget: &Budget| budget.kinetic + budget.elastic;
            of(&report.end) / of(&report.start) - 1.0
        });
        let reason = "not judged: the sheet gives no bound; a pair keeps it to the order of the step";
        outcome.info(label("change of energy in 0.45 s, nearly two periods"), "0", energy, reason);
    }
    Ok(())
}

/// Loss of amplitude from the first peak to the next one.
fn loss(tip: &[(f64, f64)]) -> f64 {
    let turn = period(tip);
    let peak = |from: f64, to: f64| {
        let within = tip.iter().filter(|(t, _)| (from * turn..to * turn).contains(t));
        within.map(|(_, y)| *y).max_or_nan()
    };
    1.0 - peak(0.8, 1.6) / peak(0.0, 0.5)
}
