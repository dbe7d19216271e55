//! Critical-state sand: simple shear of three densities and columns of two (sheet: sph B-02, B-10).

use std::collections::BTreeMap;

use colluvium::case::{Case, RunReport, Snapshot};
use colluvium::constitutive::localisation::acoustic_tensor;
use colluvium::constitutive::{InitialCondition, Mat3, MaterialSpec, Motion, SymTensor};
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use serde_json::json;

use crate::analysis::{MaxOrNan, connected_front, mass_quantile_position};
use crate::benchmarks::sph::simple_shear::{ShearPath, ShearRow, law_in_frame};
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, initial_positions, load_case, run_in_memory, scalars, set_method_option,
};

/// Half the spacing of the sheet's set S (m), required for the bands of the dense sand.
const FINE_SPACING: f64 = 0.0025;

/// Benchmark of simple shear of critical-state sand at three densities.
pub const SHEAR: Benchmark = Benchmark {
    id: "sph/critical-shear",
    title: "Simple shear of critical-state sand at three densities, SPH",
    source: "Bui & Nguyen 2021, Fig. 15 and Table 1 as the sheet corrects it (K44); sheet: sph B-02",
    short_seconds: Some(2),
    full_seconds: 80,
    run: shear,
};

/// Benchmark of columns of loose and dense critical-state sand, at a coarse spacing.
pub const COLUMNS: Benchmark = Benchmark {
    id: "sph/critical-columns",
    title: "Columns of loose and dense critical-state sand, SPH",
    source: "Bui & Nguyen 2021, Fig. 29; sheet: sph B-10",
    short_seconds: None,
    full_seconds: 16,
    run: |_| columns(&[0.01]),
};

/// Benchmark of columns of loose and dense critical-state sand, at the spacing of the sheet's set S and at half of it.
pub const COLUMNS_FINE: Benchmark = Benchmark {
    id: "sph/critical-columns-fine",
    title: "Columns of loose and dense critical-state sand at 5 and 2.5 mm, SPH",
    short_seconds: None,
    full_seconds: 1200,
    run: |_| columns(&[2.0 * FINE_SPACING, FINE_SPACING]),
    ..COLUMNS
};

/// Sand of Table 1 of the source at a void ratio.
fn sand(void_ratio: f64, density: f64) -> Result<MaterialSpec, String> {
    serde_json::from_value(json!({
        "model": "simsand", "density": density, "void_ratio": void_ratio, "stiffness_constant": 130,
        "stiffness_exponent": 0.67, "poissons_ratio": 0.2, "critical_friction_angle": 31.4, "reference_void_ratio": 0.964,
        "critical_state_factor": 0.118, "critical_state_exponent": 0.205, "dilatancy_constant": 0.5,
        "dilatancy_exponent": 3.5, "peak_exponent": 1.9, "hardening_constant": 0.0017
    }))
    .map_err(|error| error.to_string())
}

/// Names and initial void ratios of sands.
const DENSITIES: [(&str, f64); 3] = [("loose", 0.91), ("medium", 0.81), ("dense", 0.77)];

/// Component of the stress with its name.
type StressComponent = (&'static str, fn(&SymTensor) -> f64);

/// Shear strain at which the law in simple shear loses ellipticity, and speed of growth at a shear of 0.2 (m/s): waves of number `k` grow
/// at this speed times `k`.
fn ellipticity(spec: &MaterialSpec) -> Result<(f64, f64), String> {
    /// Shear strain of a step.
    const STEP: f64 = 1e-4;
    let law = spec.build().map_err(|error| error.to_string())?;
    let initial = InitialCondition { stress: SymTensor::isotropic(-100e3), density: spec.density() };
    let (mut stress, mut states) = law.initial(&[initial]).map_err(|error| error.source.to_string())?;
    let motion = Motion::from_velocity_gradient(
        &Mat3([[0.0, STEP, 0.0], [0.0; 3], [0.0; 3]]),
        1.0,
        spec.density(),
        0.5,
    )
    .ok_or("a singular motion")?;
    let (mut lost, mut smallest) = (f64::NAN, 0.0);
    for step in 1..=2000 {
        if step % 10 == 0 {
            let tangent = law
                .tangent(&motion, &stress[0], &states.blocks()[0], 0)
                .map_err(|error| error.to_string())?;
            smallest = (0..180).map(|degree| f64::from(degree).to_radians()).fold(
                f64::INFINITY,
                |smallest: f64, angle| {
                    let [[a, b, _], [c, d, _], _] =
                        acoustic_tensor(&tangent, [angle.cos(), angle.sin(), 0.0]).0;
                    let (mean, square) = (0.5 * (a + d), 0.25 * (a - d) * (a - d) + b * c);
                    smallest.min(mean - square.max(0.0).sqrt())
                },
            );
            if lost.is_nan() && smallest < 0.0 {
                lost = STEP * f64::from(step);
            }
        }
        law.update(&[motion], &mut stress, &mut states.blocks_mut()[0])
            .map_err(|error| error.source.to_string())?;
    }
    Ok((lost, (-smallest / spec.density()).max(0.0).sqrt()))
}

/// Viscosity against hourglass modes, which grow fastest where the law is not elliptic.
const HOURGLASS: f64 = 1.0;

/// Checks simple shear of a block from 100 kPa to a shear of 0.2 against the law, at two rates (B-02). The strain is that of the frame, and
/// the law is rate-independent.
fn shear(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let axes = |title: &str, x_label: &str| LineChart::new(title, x_label, "shear stress (kPa)");
    let mut strains = axes("Simple shear of sand at constant volume", "shear strain");
    let mut paths = axes("Stress paths", "mean pressure (kPa)");
    let rates: &[f64] = if quick { &[0.4] } else { &[0.1, 0.01] };
    let settings = DENSITIES.iter().flat_map(|density| rates.iter().map(move |rate| (*density, *rate)));
    for ((name, void_ratio), rate) in settings {
        let spec = sand(void_ratio, 1500.0)?;
        let path = ShearPath { rate, pressure: 100e3, shear: 0.2, rows: 40, hourglass: HOURGLASS };
        let found = law_in_frame(&spec, path)?;
        let label = |what: &str| format!("B-02, {name} (e = {void_ratio}), {rate}/s: {what}");
        difference_from_law(&mut outcome, &found, &label);
        pressure_of_block(&mut outcome, &found, (name, void_ratio), &label);
        if rate < rates[0] {
            continue;
        }
        let (lost, speed) = ellipticity(&spec)?;
        let reason = "not judged: beyond it the law alone is ill-posed, and every deviation from simple shear grows with time";
        outcome.info(label("shear at which the law loses ellipticity"), "", lost, reason);
        let reason = "not judged: deviations grow by this times their wave number, less what viscosity takes";
        outcome.info(label("their speed of growth at the end (m/s)"), "", speed, reason);
        let strain = |stress: &SymTensor, shear: f64| (shear, stress.0[3] / 1e3);
        let path = |stress: &SymTensor, _: f64| (stress.pressure() / 1e3, stress.0[3] / 1e3);
        push_curves(&mut strains, name, &found, strain);
        push_curves(&mut paths, name, &found, path);
    }
    outcome.svg("Shear stress of the block and of the law alone.", &strains)?;
    outcome.svg("Their stress paths: the loose sand liquefies.", &paths)?;
    Ok(outcome)
}

/// Adds the curves of the block and of the law. `point` selects the drawn values from stress (Pa) and shear.
fn push_curves(
    chart: &mut LineChart,
    name: &str,
    found: &[ShearRow],
    point: impl Fn(&SymTensor, f64) -> (f64, f64),
) {
    let block = found.iter().map(|(shear, block, _)| point(block, *shear)).collect();
    let law = found.iter().map(|(shear, _, law)| point(law, *shear)).collect();
    chart.series.push(Series::new(name, block, Style::Markers));
    chart.series.push(Series::new("law", law, Style::Dashed));
}

/// Checks shear stress and pressure of the block against those of the law.
fn difference_from_law(outcome: &mut BenchmarkOutcome, found: &[ShearRow], label: &dyn Fn(&str) -> String) {
    let measures: [StressComponent; 2] = [("shear stress", |s| s.0[3]), ("pressure", SymTensor::pressure)];
    for (what, of) in measures {
        let largest = found.iter().map(|(_, _, law)| of(law).abs()).max_or_nan();
        let apart = found.iter().map(|(_, ours, law)| (of(ours) - of(law)).abs()).max_or_nan();
        let title = label(&format!("{what}, difference from the law"));
        let reason = "B-02: mean of the block within 3 % of the law alone; of the largest value on the path";
        outcome.assert_below(title, "0", apart / largest, 0.03, reason);
    }
}

/// Checks the pressure of the block: loose sand liquefies, denser sand first contracts and then dilates.
fn pressure_of_block(
    outcome: &mut BenchmarkOutcome,
    found: &[ShearRow],
    (name, void_ratio): (&str, f64),
    label: &dyn Fn(&str) -> String,
) {
    let pressures: Vec<f64> = found.iter().map(|(_, ours, _)| ours.pressure()).collect();
    let (end, smallest) =
        (pressures[pressures.len() - 1], pressures.iter().copied().fold(f64::INFINITY, f64::min));
    if name == "loose" {
        // e_c(p) = e: the remaining pressure at constant volume by the critical state line.
        let left: f64 = 1e5 * ((0.964 - void_ratio) / 0.118_f64).powf(1.0 / 0.205);
        let title = label("pressure at the end (Pa)");
        let reason = "B-02: liquefies; the critical state line leaves 2.2 kPa at this void ratio, twice that is allowed";
        outcome.assert_below(title, &format!("{left:.0}"), end, 2.0 * left, reason);
    } else {
        let reason = "B-02: contracts first, then dilates towards the critical state line";
        let title = label("pressure at the end over the least on the way");
        outcome.assert_above(title, "above 1", end / smallest, 1.02, reason);
        let title = label("least pressure over the initial");
        outcome.assert_below(title, "below 1", smallest / 100e3, 0.99, reason);
    }
}

/// Column of set S, of sand with grains of 2650 kg/m³. The initial stress is that of its weight with a lateral ratio of one half. The law
/// has no stiffness without pressure.
fn column(void_ratio: f64, spacing: f64) -> Result<Case, String> {
    let mut case = load_case("sph/aluminium-bars")?;
    let density = 2650.0 / (1.0 + void_ratio);
    case.materials.insert("bars".into(), sand(void_ratio, density)?);
    let weight = json!({ "kind": "k0", "surface": 0.1, "coefficient": 0.5 });
    case.bodies[0].stress = serde_json::from_value(weight).map_err(|error| error.to_string())?;
    case.output.frames = Some(0.02);
    set_method_option(&mut case, "sph", "spacing", spacing);
    Ok(case)
}

/// Position of the front of 99 % of the particles (m). The outermost particle of a column scatters by a tenth of its displacement with the
/// steps taken, which depend on the times of output too.
fn end(snapshot: &Snapshot) -> f64 {
    mass_quantile_position(snapshot, 0.99, |x| x[0])
}

/// Time at which the front of 99 % of the particles has moved half of its run-out (s), and the run-out (m).
fn run_out(report: &RunReport) -> (f64, f64) {
    let front: Vec<(f64, f64)> = report.frames.iter().map(|frame| (frame.time, end(frame))).collect();
    let (start, end) = (front[0].1, front[front.len() - 1].1);
    let half = start + 0.5 * (end - start);
    let crossing = front.windows(2).find(|pair| pair[0].1 < half && pair[1].1 >= half);
    let time = crossing.map_or(f64::NAN, |pair| {
        let ((t, x), (u, y)) = (pair[0], pair[1]);
        t + (u - t) * (half - x) / (y - x)
    });
    (time, end - start)
}

/// Courant numbers of repeated runs of the fine columns, in addition to the default: the front scatters by 2 to 3 % with the steps. The
/// bounds on the ratio are four times as wide.
const REPEATED_COURANT_NUMBERS: [f64; 2] = [0.18, 0.16];

/// Smoothing length over spacing.
const SMOOTHING: f64 = 1.2;
/// The middle three fifths of the height (m).
const MIDDLE_HEIGHTS: std::ops::Range<f64> = 0.02..0.08;
/// Plastic shear strain that counts as sheared.
const SHEAR_THRESHOLD: f64 = 0.1;

/// Share of the particles with a plastic shear strain above a tenth.
fn sheared_share(report: &RunReport) -> f64 {
    let strains = scalars(&report.snapshot, "plastic_strain");
    strains.iter().filter(|strain| **strain > SHEAR_THRESHOLD).count() as f64 / strains.len() as f64
}

/// Plastic shear strain of the initial lattice, row by row from the left, within the middle three fifths of the height. Each value is a
/// mean over two smoothing lengths. The strain itself alternates from particle to particle.
fn strain_rows(snapshot: &Snapshot, spacing: f64) -> Vec<Vec<f64>> {
    let index = |x: f64| (x / spacing).floor() as i64;
    let strains: BTreeMap<[i64; 2], f64> = initial_positions(snapshot)
        .iter()
        .map(|x| [index(x[1]), index(x[0])])
        .zip(scalars(snapshot, "plastic_strain"))
        .collect();
    let reach = 2.0 * SMOOTHING;
    let steps = -(reach as i64)..=reach as i64;
    let disc: Vec<[i64; 2]> = steps
        .clone()
        .flat_map(|a| steps.clone().map(move |b| [a, b]))
        .filter(|[a, b]| ((a * a + b * b) as f64) <= reach * reach)
        .collect();
    let mut rows: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
    for [row, column] in
        strains.keys().filter(|at| MIDDLE_HEIGHTS.contains(&((at[0] as f64 + 0.5) * spacing)))
    {
        let near: Vec<f64> =
            disc.iter().filter_map(|[a, b]| strains.get(&[row + a, column + b]).copied()).collect();
        rows.entry(*row).or_default().push(near.iter().sum::<f64>() / near.len() as f64);
    }
    rows.into_values().collect()
}

/// Number of shear bands across a row: maxima above a tenth, between which the strain falls to half of either.
fn bands(row: &[f64]) -> usize {
    let (mut count, mut within, mut turn) = (0, false, 0.0f64);
    for &strain in row {
        if within && strain < 0.5 * turn {
            (within, turn) = (false, strain);
        } else if !within && strain > SHEAR_THRESHOLD && strain > 2.0 * turn {
            (count, within, turn) = (count + 1, true, strain);
        } else {
            turn = if within { turn.max(strain) } else { turn.min(strain) };
        }
    }
    count
}

/// Width of the sheared part of a row, `(Σ ε)² / Σ ε²` particles: that of a band of uniform strain.
fn strain_width(row: &[f64]) -> f64 {
    row.iter().sum::<f64>().powi(2) / row.iter().map(|strain| strain * strain).sum::<f64>()
}

/// Compares the collapse of loose and dense columns at several spacings.
fn columns(spacings: &[f64]) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    for &spacing in spacings {
        pair(&mut outcome, spacing)?;
    }
    Ok(outcome)
}

/// Results of the collapse of a column.
struct ColumnRun {
    /// Time of half of the run-out (s).
    half_time: f64,
    /// Run-out of 99 % of the mass (m).
    run_out: f64,
    /// Share of the mass that is sheared by more than a tenth.
    sheared_share: f64,
    /// Widths of the sheared zone at half the time and at the end (m).
    widths: [f64; 2],
}

impl ColumnRun {
    /// Runs a column and shows its results.
    fn run(
        outcome: &mut BenchmarkOutcome,
        (name, void_ratio): (&str, f64),
        spacing: f64,
    ) -> Result<Self, String> {
        let label = |what: &str| format!("B-10, {} mm, {name}: {what}", 1e3 * spacing);
        let report = run_in_memory("sph", &column(void_ratio, spacing)?)?;
        let ((time, way), share) = (run_out(&report), sheared_share(&report));
        let outermost =
            connected_front(&report.snapshot, spacing) - connected_front(&report.frames[0], spacing);
        let reason = "judged against the other";
        outcome.info(label("half of the run-out after (s)"), "", time, reason);
        outcome.info(label("run-out of 99 % of the mass (m)"), "", way, reason);
        let stray = "not judged: scatters by a tenth with the steps taken";
        outcome.info(label("run-out of the outermost particle (m)"), "", outermost, stray);
        outcome.info(label("share sheared by more than a tenth"), "", share, reason);
        if let Some(cloud) = PointCloud::from_snapshot(&report.snapshot, "plastic_strain", [0, 1]) {
            let caption =
                format!("Plastic shear strain of the {name} column at its end, {} mm.", 1e3 * spacing);
            outcome.png(&caption, &cloud)?;
        }
        let half = report.frames.iter().find(|frame| frame.time >= time).unwrap_or(&report.snapshot);
        let widths = [("half-way", half), ("at the end", &report.snapshot)].map(|(when, snapshot)| {
            let rows = strain_rows(snapshot, spacing);
            let mean =
                |of: fn(&[f64]) -> f64| rows.iter().map(|row| of(row)).sum::<f64>() / rows.len() as f64;
            let reason =
                "not judged: the sheet gives no number, and it is one in both; their widths tell them apart";
            let (count, width) = (mean(|row| bands(row) as f64), spacing * mean(strain_width));
            outcome.info(label(&format!("shear bands across a row, {when}")), "", count, reason);
            let reason = "judged against the other";
            outcome.info(label(&format!("width of what shears, {when} (m)")), "", width, reason);
            width
        });
        Ok(Self { half_time: time, run_out: way, sheared_share: share, widths })
    }
}

/// Checks the loose and the dense column at a spacing against the requirements of the sheet.
fn pair(outcome: &mut BenchmarkOutcome, spacing: f64) -> Result<(), String> {
    let label = |what: &str| format!("B-10, {} mm, {what}", 1e3 * spacing);
    let loose = ColumnRun::run(outcome, DENSITIES[0], spacing)?;
    let dense = ColumnRun::run(outcome, DENSITIES[2], spacing)?;
    let run_outs = repeated_run_outs(outcome, &loose, &dense, spacing)?;
    for (number, when) in ["half-way", "at the end"].into_iter().enumerate() {
        let title = label(&format!("width of what shears, loose over dense, {when}"));
        let reason = "B-10: loose it shears diffusely, dense in bands; the mean over rows of (Σ ε)²/Σ ε²";
        outcome.assert_above(title, "above 1", loose.widths[number] / dense.widths[number], 1.0, reason);
    }
    let title = label("time of half the run-out, loose over dense");
    let reason = "B-10: the loose column is the faster one";
    outcome.assert_below(title, "below 1", loose.half_time / dense.half_time, 1.0, reason);
    let title = label("share sheared, loose over dense");
    let reason = "B-10: loose it fails deeper and more diffusely, dense in bands";
    outcome.assert_above(title, "above 1", loose.sheared_share / dense.sheared_share, 1.0, reason);
    let [all_loose, all_dense] = run_outs.map(|run_outs| run_outs.iter().sum::<f64>());
    let (name, ratio) = (label("run-out of 99 % of the mass, loose over dense"), all_loose / all_dense);
    if spacing > FINE_SPACING {
        let reason =
            "not judged: too few layers for the bands in which the dense sand softens; judged at 2.5 mm";
        outcome.info(name, "0.9 to 1.1", ratio, reason);
    } else {
        let reason = "B-10: 0.9 to 1.1; the mean of runs with three Courant numbers, each of which scatters by 2 to 3 %";
        outcome.assert_within(name, "0.9 to 1.1", ratio, (0.9, 1.1), reason);
    }
    Ok(())
}

/// Run-outs of the loose and of the dense column (m). At the fine spacing they include other Courant numbers.
fn repeated_run_outs(
    outcome: &mut BenchmarkOutcome,
    loose: &ColumnRun,
    dense: &ColumnRun,
    spacing: f64,
) -> Result<[Vec<f64>; 2], String> {
    let mut run_outs = [vec![loose.run_out], vec![dense.run_out]];
    if spacing > FINE_SPACING {
        return Ok(run_outs);
    }
    for courant in REPEATED_COURANT_NUMBERS {
        for (run_outs, (_, void_ratio)) in run_outs.iter_mut().zip([DENSITIES[0], DENSITIES[2]]) {
            let mut case = column(void_ratio, spacing)?;
            set_method_option(&mut case, "sph", "courant", courant);
            run_outs.push(run_out(&run_in_memory("sph", &case)?).1);
        }
    }
    for (run_outs, name) in run_outs.iter().zip(["loose", "dense"]) {
        for (run_out, courant) in run_outs[1..].iter().zip(REPEATED_COURANT_NUMBERS) {
            let name = format!(
                "B-10, {} mm, {name}, Courant number {courant}: run-out of 99 % of the mass (m)",
                1e3 * spacing
            );
            outcome.info(name, "", *run_out, "judged in the mean");
        }
    }
    Ok(run_outs)
}
