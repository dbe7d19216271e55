//! Factor of safety of a slope and its run-out once it has failed (SPH sheet V-40, V-41).

use colluvium::case::description::Measure;
use colluvium::case::plot::{LineChart, Series, Style};
use colluvium::case::{Case, Safety, Snapshot};

use super::{Benchmark, Outcome, case, run_by, vectors};
use crate::bishop::{Circle, Slope};

/// The benchmark.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/slope-safety",
    title: "Slope: factor of safety by strength reduction, SPH",
    source: "Bui & Nguyen 2021, Fig. 25 by way of the SPH sheet, V-40; Griffiths & Lane 1999, example 1",
    run,
};

const SPACING: f64 = 0.02;
const SLOPE: Slope =
    Slope { height: 0.6, cotangent: 1.0, unit_weight: 2000.0 * 9.81, cohesion: 550.0, friction_angle: 31.2 };
/// Where the toe of the case is (m); it rises towards smaller x.
const TOE: f64 = 1.1;

fn run(quick: bool) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let example =
        Slope { height: 10.0, cotangent: 2.0, unit_weight: 20e3, cohesion: 10e3, friction_angle: 20.0 };
    let known = example.critical().ok_or("no circle")?;
    let reason = "V-40: the check of our own limit equilibrium, to the digits the sheet gives";
    outcome.near(
        "Bishop's simplified method: Griffiths & Lane, example 1",
        1.379,
        1e-3,
        known.factor,
        reason,
    );
    let circle = SLOPE.critical().ok_or("no circle")?;
    let reason = "V-40: the sheet's own search; the last digit given";
    outcome.near("Bishop's simplified method: this slope", 1.232, 1e-3, circle.factor, reason);

    let found = safety(&search(quick, "plane-strain", [1.0, 2.0])?)?;
    judge(&mut outcome, &found);
    if !quick {
        let cone = safety(&search(false, "compression", [1.0, 3.0])?)?;
        let reason = "V-40: with the compression cone the friction angle of plane strain is 46.3 degrees: clearly larger";
        outcome.within(
            "factor of safety, compression cone",
            "clearly above 1.23",
            cone.stable,
            (1.29, 3.0),
            reason,
        );
    }
    surface(&mut outcome, &circle)?;
    Ok(outcome)
}

/// The case with another matching; in the short form with two trials only, at the ends of what passes.
fn search(quick: bool, matching: &str, range: [f64; 2]) -> Result<Case, String> {
    let mut case = case("sph/slope")?;
    if let Some(Measure::FactorOfSafety(search)) = case.measures.get_mut("safety") {
        (search.range, search.tolerance) = if quick { (BAND.into(), 1.0) } else { (range, 0.01) };
    }
    matched(&mut case, matching)?;
    Ok(case)
}

/// What passes: 1.23 ± 0.06.
const BAND: (f64, f64) = (1.17, 1.29);

fn matched(case: &mut Case, matching: &str) -> Result<(), String> {
    let spec = case.materials.get_mut("soil").ok_or("no soil")?;
    let mut value = serde_json::to_value(&*spec).map_err(|error| error.to_string())?;
    value["matching"] = matching.into();
    *spec = serde_json::from_value(value).map_err(|error| error.to_string())?;
    Ok(())
}

fn safety(case: &Case) -> Result<Safety, String> {
    run_by("sph", case)?.safety.remove("safety").ok_or_else(|| "no factor of safety".to_owned())
}

fn judge(outcome: &mut Outcome, found: &Safety) {
    let reason = "V-40: 1.23 ± 0.06; stable at a factor at least as large, failed at one at most as large";
    outcome.within(
        "largest factor at which the slope is stable",
        "at least 1.17",
        found.stable,
        BAND,
        reason,
    );
    outcome.within("least factor at which it fails", "at most 1.29", found.failed, BAND, reason);
    for trial in &found.trials {
        let state = if trial.failed { "failed" } else { "stable" };
        let name = format!("trial at {:.4}, {state}: displacement (m)", trial.factor);
        outcome.show(name, "0.06 is a tenth of the height", trial.displacement, "how the search went");
    }
}

/// The slip surface of the slope that has just failed, beside Bishop's.
fn surface(outcome: &mut Outcome, circle: &Circle) -> Result<(), String> {
    let case = case("sph/slope-failure")?;
    let snapshot = run_by("sph", &case)?.snapshot;
    let entry = TOE - scarp(&snapshot);
    let reason = "V-40: within two spacings of Bishop's circle, which meets the crest at about 0.70 m";
    let range = (circle.entry - 2.0 * SPACING, circle.entry + 2.0 * SPACING);
    outcome.within(
        "slip surface at the crest: distance from the toe (m)",
        &format!("{:.3} (Bishop)", circle.entry),
        entry,
        range,
        reason,
    );
    let mut chart = LineChart {
        title: "Slope at its slip".into(),
        x_label: "distance from the toe (m)".into(),
        y_label: "height (m)".into(),
        ..LineChart::default()
    };
    let moved = vectors(&snapshot, "displacement");
    let largest = moved.iter().map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
    let sliding: Vec<(f64, f64)> = snapshot
        .positions
        .iter()
        .zip(&moved)
        .filter(|(_, u)| u[0].hypot(u[1]) > 0.25 * largest)
        .map(|(x, u)| (TOE - (x[0] - u[0]), x[1] - u[1]))
        .collect();
    chart.series.push(Series::new(
        "particles that have moved by a quarter of the most",
        sliding,
        Style::Markers,
    ));
    let arc = (0..=60).map(|k| circle.exit + (circle.entry - circle.exit) * f64::from(k) / 60.0);
    chart.series.push(Series::new(
        "Bishop's circle",
        arc.map(|x| (x, circle.bottom(x))).collect(),
        Style::Line,
    ));
    let face = vec![(0.0, 0.0), (0.6, 0.6), (1.1, 0.6)];
    chart.series.push(Series::new("slope", face, Style::Dashed));
    outcome.svg(
        "Where the failing slope moves, in its initial shape, and the circle of limit equilibrium.",
        &chart,
    )
}

/// Where displacement jumps along the crest (m).
fn scarp(snapshot: &Snapshot) -> f64 {
    let moved = vectors(snapshot, "displacement");
    let mut crest: Vec<(f64, f64)> = snapshot
        .positions
        .iter()
        .zip(&moved)
        .map(|(x, u)| ([x[0] - u[0], x[1] - u[1]], u[0].hypot(u[1])))
        .filter(|(x, _)| x[1] > SLOPE.height - SPACING)
        .map(|(x, u)| (x[0], u))
        .collect();
    crest.sort_by(|a, b| a.0.total_cmp(&b.0));
    let jump = crest.windows(2).max_by(|a, b| (a[1].1 - a[0].1).total_cmp(&(b[1].1 - b[0].1)));
    jump.map_or(f64::NAN, |pair| 0.5 * (pair[0].0 + pair[1].0))
}
