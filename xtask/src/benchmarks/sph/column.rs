//! Aluminium-bar column by SPH (sheet: sph §5.4 set S; B-03 and B-09).

use colluvium::plots::{LineChart, PointCloud, Series, Style};
use serde_json::json;

use crate::analysis::connected_front as front;
use crate::analysis::crest;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, reference_curve, reference_table, run_in_memory, set_material,
    set_method_option,
};

/// Benchmark of the collapse of a column of aluminium bars.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/aluminium-bars",
    title: "Aluminium-bar column, SPH",
    source: "Bui et al. 2008; Bui and Nguyen 2021, Fig. 16; sheet: sph §5.4 set S",
    short_seconds: None,
    full_seconds: 290,
    run,
};

/// Spacing of the particles (m).
const SPACING: f64 = 0.005;

/// Checks the front of a column of aluminium bars with three artificial viscosities.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let sheet = reference_curve(&reference_table("sph/aluminium-bars/reference.csv")?, "viscosity", "front")?;
    let at = |viscosity: f64| sheet.iter().find(|(a, _)| *a == viscosity).map_or(f64::NAN, |(_, x)| *x);
    let mut chart = LineChart::new("Front of the column", "time (s)", "x (m)");
    let mut fronts = Vec::new();
    for viscosity in [0.1, 0.0, 1.0] {
        let mut case = load_case("sph/aluminium-bars")?;
        set_method_option(&mut case, "sph", "viscosity_linear", viscosity);
        let report = match run_in_memory("sph", &case) {
            Ok(report) => report,
            Err(error) => {
                let name = format!("viscosity {viscosity}: the run ends ({error})");
                outcome.assert_within(name, "yes", f64::NAN, (1.0, 1.0), "a run that stops has no front");
                fronts.push(f64::NAN);
                continue;
            }
        };
        let end = front(&report.snapshot, SPACING);
        fronts.push(end);
        let points = report.frames.iter().map(|frame| (frame.time, front(frame, SPACING))).collect();
        chart.series.push(Series::new(format!("viscosity {viscosity}"), points, Style::Line));
        if viscosity == 0.1 {
            let reason = "set S, for continuous integration: 0.404 ± 0.02";
            outcome.assert_within("front (m)", "0.404 ± 0.02", end, (0.384, 0.424), reason);
            let reason = "set S: the corner at x = 0 stays undisturbed";
            let top = crest(&report.snapshot, 0.01);
            outcome.assert_within("height at the wall (m)", "0.100 ± 0.001", top, (0.099, 0.101), reason);
            let reason = "set S: below 1e-6 J at 0.8 s";
            outcome.assert_below("kinetic energy at 0.8 s (J)", "< 1e-6", report.end.kinetic, 1e-6, reason);
            if let Some(cloud) = PointCloud::from_snapshot(&report.snapshot, "displacement", [0, 1]) {
                outcome.png("The deposit at 0.8 s, displacement.", &cloud)?;
            }
        } else {
            let reason = "not judged: set S judges the order only";
            let claim = format!("{}{}", if viscosity == 0.0 { "at least " } else { "" }, at(viscosity));
            outcome.info(format!("viscosity {viscosity}: front (m)"), &claim, end, reason);
        }
    }
    forward(&mut outcome)?;
    let [usual, none, strong] = fronts[..] else { return Err("three runs".to_owned()) };
    let ordered = f64::from(u8::from(none > usual && usual > strong));
    let reason = "set S: fronts for viscosities 0 > 0.1 > 1 strictly";
    outcome.assert_within("fronts fall with viscosity (1 is yes)", "yes", ordered, (1.0, 1.0), reason);
    check_viscous_damping(&mut outcome)?;
    variants(&mut outcome, usual)?;
    outcome.svg("Advance of the front.", &chart)?;
    Ok(outcome)
}

/// Checks the front without artificial viscosity, which depends on the integration of the law.
fn forward(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut case = load_case("sph/aluminium-bars")?;
    set_method_option(&mut case, "sph", "viscosity_linear", 0.0);
    set_material(&mut case, "bars", &[("integration", "explicit".into())])?;
    let reason = "not judged: set S judges the order only. Steps of the noise are longer than the strain at yield: the \
                  forward algorithm of the source takes energy out of it, as the return does";
    match run_in_memory("sph", &case) {
        Ok(report) => {
            outcome.info(
                "viscosity 0, forward algorithm: front (m)",
                "at least 0.485",
                front(&report.snapshot, SPACING),
                reason,
            );
            let claim = "does not vanish";
            outcome.info(
                "viscosity 0, forward algorithm: kinetic energy (J)",
                claim,
                report.end.kinetic,
                reason,
            );
        }
        Err(error) => {
            outcome.info(format!("viscosity 0, forward algorithm: ends ({error})"), "", f64::NAN, reason);
        }
    }
    Ok(())
}

/// Checks viscous damping and regularisation in place of artificial viscosity (the fourth setting of B-03).
fn check_viscous_damping(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for damping in [1e-3, 1e-4] {
        let mut case = load_case("sph/aluminium-bars")?;
        set_method_option(&mut case, "sph", "viscosity_linear", 0.0);
        set_method_option(&mut case, "sph", "regularisation", "mls");
        set_method_option(&mut case, "sph", "damping", damping);
        let report = run_in_memory("sph", &case)?;
        let name = |what: &str| format!("damping {damping}, mls, no viscosity: {what}");
        let reason = "not judged: B-03 has the kinematics of viscosity with MLS, without a number, and the sheet leaves the \
                      damping open up to 1e-3";
        outcome.info(name("front (m)"), "0.383", front(&report.snapshot, SPACING), reason);
        outcome.info(name("kinetic energy (J)"), "", report.end.kinetic, reason);
    }
    Ok(())
}

/// Checks the front with other walls and with regularisation.
fn variants(outcome: &mut BenchmarkOutcome, usual: f64) -> Result<(), String> {
    for (option, value, sheet) in [
        ("regularisation", json!("mls"), "0.383 (wall b)"),
        ("stress_diffusion", json!(0.1), "0.380"),
        ("wall_stress", json!("interpolated"), "0.404"),
        ("wall_stress", json!("extrapolated"), "0.402"),
        ("sound_speed", json!("youngs-modulus"), "not given"),
        ("velocity_gradient", json!("corotated"), "0.404"),
    ] {
        let mut case = load_case("sph/aluminium-bars")?;
        let name = format!("{option} {value}: front (m)").replace('"', "");
        set_method_option(&mut case, "sph", option, value);
        let end = run_in_memory("sph", &case).map_or(f64::NAN, |report| front(&report.snapshot, SPACING));
        if matches!(option, "regularisation" | "stress_diffusion") {
            let reason = "set S: MLS and diffusion within -10 % of the run without";
            outcome.assert_within(name, sheet, end, (0.9 * usual, usual), reason);
        } else {
            outcome.info(
                name,
                sheet,
                end,
                "not judged: set S judges wall c at 5 mm with the sums of the source",
            );
        }
    }
    Ok(())
}
