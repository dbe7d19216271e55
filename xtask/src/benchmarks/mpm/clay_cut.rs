//! Failure of cuts and slopes in clay (sheet: mpm A-30).

use std::collections::BTreeMap;

use colluvium::case::measure::{Dissipation, Measure, Probe, profile};
use colluvium::case::{Case, RunReport, Snapshot};
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use serde_json::json;

use crate::analysis::MaxOrNan;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, measure_series, run_mpm, scalars, set_mpm_option, vectors,
};

/// Benchmark of cuts and slopes in Tresca clay: stability and run-out.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/slope-failure",
    title: "Vertical cut and slopes in Tresca clay: stability and run-out",
    source: "Published bounds of the stability number of a vertical cut, 3.776 to 3.782; Taylor 1937; sheet: mpm A-30",
    short_seconds: Some(17),
    full_seconds: 250,
    run: benchmark,
};

/// Unit weight (N/m³).
const WEIGHT: f64 = 2e4;
/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 10.0;
/// Height of the cut (m).
const HEIGHT: f64 = 1.0;
/// Position of the face of the cut (m).
const FACE: f64 = 1.5;
/// Height of the foot of the cut (m).
const FOOT: f64 = 0.5;
/// Duration of the free fall of the unstable cut (s).
const FALL_DURATION: f64 = 3.0;
/// Duration of the undamped observation at rest (s).
const REST_DURATION: f64 = 0.05;
/// Time between frames of the fall (s).
const FRAME: f64 = 0.02;
/// Largest settlement of a crest that counts as stable (m).
const CREST: f64 = 0.05 * HEIGHT;
/// Largest height of a vertical face that may remain of a cut, over c_u/γ.
const FACE_BOUND: f64 = 3.83;
/// Smallest angle of a near-vertical face (degrees).
const NEAR_VERTICAL: f64 = 75.0;

/// Sets the strength of the clay by a stability number γH/c_u. `strong` clay does not yield.
fn clay(case: &mut Case, number: f64, strong: bool) -> Result<(), String> {
    let strength = WEIGHT * HEIGHT / number;
    let clay = json!({ "model": "tresca", "density": 2000, "youngs_modulus": 500.0 * strength, "poissons_ratio": 0.3,
                       "undrained_strength": if strong { 1e3 * strength } else { strength } });
    let clay = serde_json::from_value(clay).map_err(|error| error.to_string())?;
    case.materials.insert("clay".into(), clay);
    set_mpm_option(case, "volumetric_strain", "cell-average");
    Ok(())
}

/// Case of a slope at an angle (degrees) on a layer `depth` (m) thick. The layer would settle by more than a cell: the points keep their
/// positions, as in the theory of Taylor's numbers.
fn slope(angle: f64, depth: f64) -> Result<Case, String> {
    let mut case = load_case("mpm/vertical-cut")?;
    let back = HEIGHT / angle.to_radians().tan();
    let (crest, length) = (2.0, 2.0 + back + 2.0);
    let cells = |x: f64| (x / 0.05).ceil() * 0.05;
    let shape = json!({ "kind": "polygon", "vertices": [
        [0.0, 0.0], [cells(length), 0.0], [cells(length), depth], [crest + back, depth], [crest, depth + HEIGHT],
        [0.0, depth + HEIGHT]] });
    case.bodies[0].shape = serde_json::from_value(shape).map_err(|error| error.to_string())?;
    case.domain.max = vec![cells(length), cells(depth + HEIGHT + 0.2)];
    let Some(Measure::Probe(Probe { position, .. })) = case.measures.get_mut("crest") else {
        return Err("no probe at the crest".to_owned());
    };
    *position = vec![crest - 0.05, depth + HEIGHT - 0.05];
    set_mpm_option(&mut case, "formulation", "small-displacement");
    Ok(case)
}

/// Settlement of the crest until it is at rest (m); infinite where it does not come to rest, or no crest remains.
fn sinking(case: &Case, number: f64, strong: bool) -> Result<f64, String> {
    let mut case = case.clone();
    clay(&mut case, number, strong)?;
    match run_mpm(&case) {
        Ok(report) => {
            let rows = measure_series(&report, "crest.displacement.y");
            let (_, rise) = rows.last().ok_or("the crest was not measured")?;
            Ok(if rise.is_nan() { f64::INFINITY } else { -rise })
        }
        Err(error) if error.contains("no equilibrium") => Ok(f64::INFINITY),
        Err(error) => Err(error),
    }
}

/// Whether a slope comes to rest under its weight with its crest at most 5 % of the height below that of elastic clay. The deep layer
/// settles by 3 % of the height.
fn is_slope_stable(case: &Case, number: f64) -> Result<bool, String> {
    let settlement = sinking(case, number, false)?;
    Ok(settlement.is_finite() && settlement - sinking(case, number, true)? <= CREST)
}

/// Checks stability numbers of clay cuts, slopes near Taylor's numbers, and the run-out of an unstable cut.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    check_stability_numbers(&mut outcome, quick)?;
    if !quick {
        taylor(&mut outcome)?;
        run_out(&mut outcome)?;
    }
    Ok(outcome)
}

/// Checks the largest stability number at which a cut is stable, and the smallest at which it fails ((i) of the sheet).
fn check_stability_numbers(outcome: &mut BenchmarkOutcome, quick: bool) -> Result<(), String> {
    let case = load_case("mpm/vertical-cut")?;
    let numbers: &[f64] = if quick { &[3.6, 4.1] } else { &[3.6, 3.7, 3.8, 3.9, 4.0, 4.1] };
    let mut standing = 0.0;
    let mut fallen = f64::INFINITY;
    for &number in numbers {
        if sinking(&case, number, false)? <= CREST {
            standing = number;
        } else {
            fallen = number;
            break;
        }
    }
    let reason = "the sheet's 3.6 to 4.1 on cells of H/20";
    outcome.assert_within(
        "A-30 vertical cut: largest γH/c_u that stands",
        "3.776 to 3.782",
        standing,
        (3.6, 4.1),
        reason,
    );
    outcome.assert_within(
        "A-30 vertical cut: smallest γH/c_u that fails",
        "3.776 to 3.782",
        fallen,
        (3.6, 4.1),
        reason,
    );
    Ok(())
}

/// Checks that slopes of φ = 0 are stable 8 % on one side of Taylor's number and fail 8 % on the other ((ii) of the sheet).
fn taylor(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for (angle, depth, number) in [(60.0, 0.5, 0.191), (45.0, 2.0, 0.181)] {
        let case = slope(angle, depth)?;
        let reason = "the sheet's 8 %";
        let safe = f64::from(is_slope_stable(&case, 1.0 / (1.08 * number))?);
        let name = format!("A-30 slope of {angle}°: stands at c_u/γH = {number} + 8 % (1: yes)");
        outcome.assert_close(name, 1.0, 0.0, safe, reason);
        let unsafe_one = f64::from(is_slope_stable(&case, 1.0 / (0.92 * number))?);
        let name = format!("A-30 slope of {angle}°: stands at c_u/γH = {number} - 8 % (1: yes)");
        outcome.assert_close(name, 0.0, 0.0, unsafe_one, reason);
    }
    Ok(())
}

/// Checks that the released potential energy equals plastic dissipation and remaining kinetic energy at the end of the fall.
fn balance(outcome: &mut BenchmarkOutcome, report: &RunReport, cell: f64) {
    let at = |name: &str| {
        let rows = measure_series(report, name);
        let last = rows.iter().rfind(|(t, _)| *t <= FALL_DURATION).map_or(f64::NAN, |row| row.1);
        (rows.first().map_or(f64::NAN, |row| row.1), last)
    };
    let ((start, end), (_, lost), (_, kinetic)) = (at("potential_energy"), at("lost"), at("kinetic_energy"));
    outcome.assert_within(
        format!(
            "A-30 run-out, {} mm: plastic dissipation and kinetic energy over the weight's work",
            1e3 * cell
        ),
        "1 ± 0.05",
        (lost + kinetic) / (start - end),
        (0.95, 1.05),
        "the sheet's 5 %",
    );
    let stored = at("elastic_energy");
    outcome.info(
        format!("A-30 run-out, {} mm: the same with what the clay stores under its weight", 1e3 * cell),
        "1",
        (lost + kinetic + stored.1 - stored.0) / (start - end),
        "the sheet leaves it out: 4 % of the weight's work",
    );
}

/// Height of the highest near-vertical face of a surface (m): its largest drop over the width that a face of height `bound` (m) has at the
/// smallest angle.
fn face(snapshot: &Snapshot, bin: f64, bound: f64) -> f64 {
    let width = bound / NEAR_VERTICAL.to_radians().tan();
    let surface = profile(snapshot, 0, 1, bin);
    let falls = surface.iter().flat_map(|(x, top)| {
        let near = surface.iter().filter(move |(other, _)| (other - x).abs() <= width);
        near.map(move |(_, other)| top - other)
    });
    falls.max_or_nan()
}

/// Checks out-of-balance force and kinetic energy of the worst column of cells, without damping. The out-of-balance force follows from the
/// change of momentum between two frames and is relative to the weight; the kinetic energy is relative to the work of the weight.
fn columns_at_rest(outcome: &mut BenchmarkOutcome, report: &RunReport, cell: f64) -> Result<(), String> {
    // The last frame may have any distance from the one before.
    let [.., before, after, _] = &report.frames[..] else { return Err("too few frames".to_owned()) };
    let mut columns: BTreeMap<i64, [f64; 5]> = BTreeMap::new();
    let mass = scalars(after, "mass");
    let (old, new) = (vectors(before, "velocity"), vectors(after, "velocity"));
    let moved = vectors(after, "displacement");
    let dt = after.time - before.time;
    for (p, x) in after.positions.iter().enumerate() {
        let force: [f64; 2] = std::array::from_fn(|c| mass[p] * (new[p][c] - old[p][c]) / dt);
        let kinetic = 0.5 * mass[p] * (new[p][0].powi(2) + new[p][1].powi(2));
        let weight = mass[p] * GRAVITY;
        let more = [force[0], force[1], kinetic, weight, weight * moved[p][1].abs()];
        let sums = columns.entry((x[0] / cell).floor() as i64).or_default();
        sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
    }
    let largest = |of: fn(&[f64; 5]) -> f64| columns.values().map(of).max_or_nan();
    for (what, found) in [
        ("force out of balance over weight", largest(|[x, y, _, weight, _]| x.hypot(*y) / weight)),
        ("kinetic energy over the work of its weight", largest(|[_, _, kinetic, _, work]| kinetic / work)),
    ] {
        let name = format!("A-30 run-out, {} mm, at rest: {what}, worst column of cells", 1e3 * cell);
        outcome.assert_below(name, "below 1e-2", found, 1e-2, "the sheet's criterion, of every column");
    }
    Ok(())
}

/// Case of a cut with `γH/c_u = number` that falls and comes to rest, on cells of `cell` (m).
fn failing_cut(number: f64, cell: f64) -> Result<Case, String> {
    let mut case = load_case("mpm/vertical-cut")?;
    clay(&mut case, number, false)?;
    set_mpm_option(&mut case, "cell_size", cell);
    // Shared strains and points without domains gain energy where the clay flies apart without damping.
    set_mpm_option(&mut case, "volumetric_strain", "point");
    set_mpm_option(&mut case, "shape", "ugimp");
    let stages = json!([{ "name": "fall", "duration": FALL_DURATION },
                        { "name": "rest", "duration": 10, "damping": 0.7, "equilibrium": {} },
                        { "name": "still", "duration": REST_DURATION }]);
    case.stages = serde_json::from_value(stages).map_err(|error| error.to_string())?;
    case.output.frames = Some(FRAME);
    case.measures.insert("lost".into(), Dissipation {}.into());
    Ok(case)
}

/// Checks that the cut with γH/c_u = 6 runs out and stops ((iii) of the sheet).
fn run_out(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let number = 6.0;
    let mut ends = Vec::new();
    let mut chart = LineChart::new("Run-out of a cut", "time (s)", "front (m)");
    for cell in [0.05, 0.025] {
        let report = run_mpm(&failing_cut(number, cell)?)?;
        balance(outcome, &report, cell);
        // The material above the foot.
        let start = &report.frames[0];
        let above: Vec<usize> =
            (0..start.positions.len()).filter(|p| start.positions[*p][1] > FOOT).collect();
        let front = |frame: &Snapshot| above.iter().map(|p| frame.positions[*p][0]).max_or_nan();
        let front_positions: Vec<(f64, f64)> =
            report.frames.iter().map(|frame| (frame.time, front(frame))).collect();
        let end = front_positions.last().map_or(f64::NAN, |row| row.1);
        let at =
            |time: f64| front_positions.iter().find(|(t, _)| *t >= time - 1e-9).map_or(f64::NAN, |row| row.1);
        let name = |what: &str| format!("A-30 run-out, {} mm: {what}", 1e3 * cell);
        let title = name(&format!("advance of the front from 2 s to {FALL_DURATION} s, undamped (m)"));
        let advance = at(FALL_DURATION) - at(2.0);
        outcome.assert_below(title, "0: it stops", advance, 0.01 * HEIGHT, "1 % of the height");
        columns_at_rest(outcome, &report, cell)?;
        let bound = FACE_BOUND * HEIGHT / number;
        outcome.assert_below(
            name("height of the highest near-vertical face at rest (m)"),
            "below 3.83 c_u/γ = 0.638 m",
            face(&report.snapshot, cell, bound),
            bound,
            "the sheet's bound; near-vertical: 75° or steeper, on bins of a cell",
        );
        ends.push(end - FACE);
        chart.series.push(Series::new(format!("{} mm", 1e3 * cell), front_positions, Style::Line));
        if cell == 0.05 {
            let cloud = PointCloud::from_snapshot(&report.snapshot, "displacement", [0, 1])
                .ok_or("no displacement")?;
            outcome.png("The cut with γH/c_u = 6 at rest, coloured by displacement.", &cloud)?;
        }
    }
    let name = "A-30 run-out on half the cells over that on the whole";
    outcome.assert_within(name, "1 ± 0.1", ends[1] / ends[0], (0.9, 1.1), "the sheet's 10 %");
    outcome.svg("The front of a cut that is too high.", &chart)
}
