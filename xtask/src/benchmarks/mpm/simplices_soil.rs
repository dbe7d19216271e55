//! Triangles and tetrahedra in soil: locking, skeleton and water, contact (sheet: mpm S-09, A-13, A-14, A-19, A-21, A-23).

use colluvium::case::description::Space;
use colluvium::case::{Case, RunReport, Snapshot};
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use serde_json::{Value, json};

use super::contact::{check_bars, contact, history, mean};
use super::two_phase::{
    CONSOLIDATION_RATE, LOAD, SKELETON, WATER, judge_pressures, modes, run_consolidation,
};
use crate::analysis::{MaxOrNan, regression_slope};
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, patched_case, run_mpm, scalars, set_mpm_option, vectors,
};

/// Benchmark of triangles and tetrahedra in soil: locking, pore water and contact.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/simplices-soil",
    title: "Triangles and tetrahedra: locking, pore water, contact",
    source: "sheet: mpm S-09, A-13, A-14, A-19, A-21, A-23, closed forms",
    short_seconds: Some(6),
    full_seconds: 6,
    run: benchmark,
};

/// Spaces with the names of their elements.
const KINDS: [(Space, &str); 2] = [(Space::PlaneStrain, "triangles"), (Space::ThreeD, "tetrahedra")];

/// Checks locking, consolidation, drag and contact on triangles and tetrahedra.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    check_locking(&mut outcome)?;
    consolidation(&mut outcome)?;
    drag(&mut outcome)?;
    check_undrained(&mut outcome)?;
    impact(&mut outcome)?;
    incline(&mut outcome)?;
    Ok(outcome)
}

/// Checks the displacement of the free corner of an incompressible patch, over that of a compressible one (S-09).
fn check_locking(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let corner = |snapshot: &Snapshot| {
        let place = |p: &usize| snapshot.positions[*p][0] + snapshot.positions[*p][1];
        let nearest = (0..snapshot.positions.len()).max_by(|a, b| place(a).total_cmp(&place(b))).unwrap_or(0);
        let u = vectors(snapshot, "displacement")[nearest];
        u[0].hypot(u[1])
    };
    let sag = |cells: f64, ratio: f64, volumetric: &str| -> Result<(f64, RunReport), String> {
        let mut value: Value = text(&load_case("mpm/simplices-patch")?)?;
        value["domain"]["max"] = json!([1.0 + 1.0 / cells, 1.0 + 1.0 / cells]);
        value["materials"]["m"]["poissons_ratio"] = json!(ratio);
        let mut case = Case::from_json(&value.to_string()).map_err(|errors| errors.to_string())?;
        set_mpm_option(&mut case, "cell_size", 1.0 / cells);
        set_mpm_option(&mut case, "volumetric_strain", volumetric);
        let report = run_mpm(&case)?;
        Ok((corner(&report.snapshot), report))
    };
    let soft = [sag(1.0, 0.3, "point")?.0, sag(4.0, 0.3, "point")?.0];
    let reason = "the sheet's 1 %";
    let two = sag(1.0, 0.4999, "point")?.0 / soft[0];
    outcome.assert_below(
        "S-09, two triangles: free node at ν = 0.4999 over that at 0.3",
        "below 0.01",
        two,
        0.01,
        reason,
    );
    let patch = sag(4.0, 0.4999, "point")?.0 / soft[1];
    outcome.assert_below(
        "S-09, 4 × 4 cells: the same without shared strain",
        "below 0.01",
        patch,
        0.01,
        reason,
    );
    let average = sag(4.0, 0.4999, "cell-average")?.0 / soft[1];
    let why = "shown: strain is constant in an element, so that its average changes nothing";
    outcome.info("S-09, 4 × 4 cells: the same with averages over elements", "as without", average, why);
    let (free, report) = sag(4.0, 0.4999, "nodal")?;
    outcome.assert_within(
        "S-09, 4 × 4 cells: the same with averages over nodes",
        "above 0.2",
        free / soft[1],
        (0.2, 1.0),
        "the sheet's 20 %; above 1 it would be softer than what keeps no volume",
    );
    let cloud =
        PointCloud::from_snapshot(&report.snapshot, "displacement", [0, 1]).ok_or("no displacement")?;
    outcome.png("The patch with nodal volumetric strain, held on the left and below.", &cloud)
}

/// JSON value of a case.
fn text(case: &Case) -> Result<Value, String> {
    serde_json::from_str(&case.to_json()).map_err(|error| error.to_string())
}

/// Case with triangles, or with tetrahedra in a domain extended by `depth` between smooth walls.
fn in_space(case: &Case, space: Space, depth: f64) -> Result<Case, String> {
    if space == Space::PlaneStrain {
        return Ok(case.clone());
    }
    let mut value = text(case)?;
    value["space"] = "3d".into();
    let push = |value: Option<&mut Value>, entry: f64| {
        if let Some(list) = value.and_then(Value::as_array_mut) {
            list.push(json!(entry));
        }
    };
    push(value.pointer_mut("/domain/min"), 0.0);
    push(value.pointer_mut("/domain/max"), depth);
    push(value.pointer_mut("/gravity"), 0.0);
    push(value.pointer_mut("/bodies/0/shape/min"), 0.0);
    push(value.pointer_mut("/bodies/0/shape/max"), depth);
    push(value.pointer_mut("/bodies/0/pore_fluid/velocity/value"), 0.0);
    push(value.pointer_mut("/loads/0/value"), 0.0);
    if let Some(walls) = value["boundaries"].as_array_mut() {
        for wall in walls.iter_mut() {
            push(wall.get_mut("velocity"), 0.0);
        }
        for side in ["z-min", "z-max"] {
            walls.push(json!({ "side": side, "wall": { "kind": "smooth" } }));
        }
    }
    Case::from_json(&value.to_string()).map_err(|errors| errors.to_string())
}

/// Time factor at the end of the load ramp.
const RAMP: f64 = 0.01;

/// Mean over the load ramp of the decay of the mode with the wave number `a` at the time factor `factor`.
fn mean_decay(a: f64, factor: f64) -> f64 {
    ((-a * a * (factor - RAMP)).exp() - (-a * a * factor).exp()) / (a * a * RAMP)
}

/// Pore pressure of Terzaghi's column over that at the start, at a depth `z` (m) of 1 m.
fn isochrone(z: f64, factor: f64) -> f64 {
    modes().map(|a| 2.0 / a * (a * z).sin() * mean_decay(a, factor)).sum()
}

/// Degree of consolidation of Terzaghi's column.
fn degree(factor: f64) -> f64 {
    1.0 - modes().map(|a| 2.0 / (a * a) * mean_decay(a, factor)).sum::<f64>()
}

/// Checks the consolidation of a column under a load with a ramp.
fn consolidation(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart = LineChart::new(
        "Isochrones, 40 cells",
        "depth below the drained top (m)",
        "pore pressure over that at the start",
    );
    let start = LOAD * WATER / (SKELETON + WATER);
    for ((space, name), factors) in [(KINDS[0], &[0.02, 0.05, 0.1, 0.2][..]), (KINDS[1], &[0.02, 0.05][..])] {
        let column = in_space(&load_case("mpm/simplices-consolidation")?, space, 0.025)?;
        let report = run_consolidation(&column, *factors.last().unwrap_or(&0.1))?;
        for factor in factors {
            let at = |frame: &&Snapshot| (CONSOLIDATION_RATE * frame.time - factor).abs() < 1e-9;
            let Some(frame) = report.frames.iter().find(at) else { continue };
            let moved = vectors(frame, "displacement");
            let depths = frame.positions.iter().zip(moved).map(|(x, u)| 1.0 - (x[1] - u[1]));
            let points: Vec<(f64, f64)> =
                depths.zip(scalars(frame, "pore_pressure").iter().map(|p| p / start)).collect();
            let law = |z: f64| isochrone(z, *factor);
            let label = format!("A-19, {name}, T = {factor}");
            judge_pressures(outcome, &label, &points, &law, degree(*factor));
            if space == Space::PlaneStrain {
                let label = if *factor == factors[0] { "closed form" } else { "" };
                let exact =
                    (0..=50).map(|k| 0.02 * f64::from(k)).map(|z| (z, isochrone(z, *factor))).collect();
                chart.series.push(Series::new(label, exact, Style::Dashed));
                chart.series.push(Series::new(format!("T = {factor}"), points, Style::Markers));
            }
        }
    }
    outcome.svg("Pore pressure of the points of a strip of triangles against Terzaghi's isochrones.", &chart)
}

/// Cube of `mpm/simplices-cube` with changed keys, in triangles or tetrahedra.
fn cube(space: Space, changes: &[(&str, Value)]) -> Result<Case, String> {
    in_space(&patched_case(&load_case("mpm/simplices-cube")?, changes)?, space, 1.0)
}

/// Checks the decay of the relative velocity of skeleton and water by drag.
fn drag(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let rate = 0.4 * 1990.0 * 9.81 / (1590.0 * 1e-3);
    let dt: f64 = 1e-5;
    for (space, name) in KINDS {
        let velocity = json!({ "kind": "uniform", "value": [0.02, 0] });
        let changes = [("/bodies/0/pore_fluid/velocity", velocity), ("/methods/mpm/time_step", json!(dt))];
        let report = run_mpm(&cube(space, &changes)?)?;
        let end = &report.snapshot;
        let between = vectors(end, "liquid_velocity")[0][0] - vectors(end, "velocity")[0][0];
        outcome.assert_close(
            format!("A-21, {name}: relative velocity after 100 steps over that at the start"),
            (1.0 - rate * dt).powi(100),
            1e-9,
            between / 0.02,
            "the sheet has it exact; the remainder is 0.7 %, so round-off of the whole is 1e-14",
        );
        let lost = (report.end.momentum[0] - report.start.momentum[0]).abs() / report.start.momentum[0];
        outcome.assert_below(
            format!("A-21, {name}: momentum lost over that at the start"),
            "0",
            lost,
            1e-12,
            "round-off",
        );
    }
    Ok(())
}

/// Checks the pore pressure of undrained compression.
fn check_undrained(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let strain = -1e-3 * 1e-5;
    for (space, name) in KINDS {
        let smooth = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
        let upper = json!({ "side": "y-max", "wall": { "kind": "smooth" }, "velocity": [0, -1e-3] });
        let walls = json!([smooth("x-min"), smooth("x-max"), smooth("y-min"), upper]);
        let changes = [
            ("/boundaries", walls),
            ("/methods/mpm/time_step", json!(1e-6)),
            ("/methods/mpm/cell_size", json!(1.0)),
            ("/stages/0/duration", json!(1e-5)),
        ];
        let report = run_mpm(&cube(space, &changes)?)?;
        let worst =
            |values: Vec<f64>, exact: f64| values.iter().map(|v| (v / exact - 1.0).abs()).max_or_nan();
        let pressure = worst(scalars(&report.snapshot, "pore_pressure"), -WATER * strain);
        let reason = "the sheet's 1e-6";
        outcome.assert_below(
            format!("A-23, {name}: largest error of pore pressure"),
            "0",
            pressure,
            1e-6,
            reason,
        );
        let total = report.snapshot.tensors("total_stress").unwrap_or_default();
        let vertical = worst(total.iter().map(|s| s.0[1]).collect(), (SKELETON + WATER) * strain);
        outcome.assert_below(
            format!("A-23, {name}: largest error of vertical stress"),
            "0",
            vertical,
            1e-6,
            reason,
        );
    }
    Ok(())
}

/// Checks the collision of two bars.
fn impact(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let report = run_mpm(&load_case("mpm/simplices-bars")?)?;
    check_bars(outcome, "A-13 bars of triangles", &report)
}

/// Checks the acceleration of a block on an incline.
fn incline(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart = LineChart::new(
        "Block on an incline of 30°, triangles",
        "time (s)",
        "mean velocity along the incline (m/s)",
    );
    let weight = 9.81 * 0.5;
    for (friction, exact) in [(0.2, 3.2059), (0.7, 0.0)] {
        let mut case = load_case("mpm/contact-incline")?;
        set_mpm_option(&mut case, "mesh", json!({ "kind": "box" }));
        contact(&mut case, "friction_coefficient", friction);
        case.stages[1].damping = 0.1;
        case.stages[1].damping_axes = Some(vec![1]);
        let report = run_mpm(&case)?;
        let speeds = history(&report, "velocity", 1, report.snapshot.time - 1.0);
        if exact > 0.0 {
            outcome.assert_within(
                format!("A-14 incline of triangles, μ = {friction}: acceleration (m/s²)"),
                &format!("{exact}"),
                regression_slope(&speeds),
                (exact - 0.03 * weight, exact + 0.03 * weight),
                "the sheet's 3 % of g sin θ",
            );
        } else {
            outcome.assert_within(
                format!("A-14 incline of triangles, μ = {friction}: drift in 1 s (m)"),
                "0",
                mean(&report.snapshot, "displacement", 1, 0),
                (-5e-3, 5e-3),
                "the sheet's 5 mm; local damping 0.1 of the vertical motion, as in its prototype",
            );
        }
        chart.series.push(Series::new(format!("μ = {friction}"), speeds, Style::Line));
    }
    outcome.svg("Velocity of the block for two coefficients of friction.", &chart)
}
