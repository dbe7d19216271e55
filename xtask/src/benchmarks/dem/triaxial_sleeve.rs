//! Triaxial compression in a flexible sleeve between platens, dense and loose (sheet: dem §2.10, §3.7, §3.8).

use std::f64::consts::PI;

use colluvium::case::{RunReport, Snapshot};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::analysis::{max_or_nan, mean_and_deviation};
use crate::benchmarks::dem::case_builders::{method_options, parse_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, run_in_memory, scalars};

/// Benchmark of triaxial compression of spheres in a flexible sleeve.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/triaxial-sleeve",
    title: "Triaxial compression in a sleeve, dense and loose spheres, DEM",
    source: "equilibrium of specimen, sleeve and platens; critical state as in sheet: dem §5, B14",
    short_seconds: Some(270),
    full_seconds: 2700,
    run,
};

/// Pressure of the sleeve and on the platen (Pa).
const PRESSURE: f64 = 2e4;
/// Durations of the stages before the shear (s).
const STAGE_DURATIONS: [f64; 2] = [0.1, 0.05];
/// Axial strain at the end of the shear, in the short and in the full form.
const SHEAR_STRAINS: [f64; 2] = [0.12, 0.2];
/// Strain at the end of the shear over which stresses are averaged.
const WINDOW: f64 = 0.01;
/// Time between rows (s), a divisor of the stages before the shear.
const ROW: f64 = 0.0025;
/// Friction coefficient of grains during the compression of the loose specimen. The dense one is compressed without friction.
const LOOSE_FRICTION: f64 = 1.0;
/// Seeds of packings, whose results are averaged.
const SEEDS: [u64; 3] = [1, 2, 3];
/// Solid fraction of the generated loose specimen.
const LOOSE_SOLID_FRACTION: f64 = 0.52;

/// Number of grains of a ring of the sleeve.
fn columns(quick: bool) -> usize {
    if quick { 74 } else { 98 }
}

/// Case of a specimen with a seed, which is compressed with a friction coefficient and sheared.
fn test(friction: f64, seed: u64, quick: bool) -> Result<Value, String> {
    let text = colluvium::template("triaxial-sleeve").ok_or("no template")?;
    let mut value: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let height = value["domain"]["max"][2].as_f64().ok_or("no height")?;
    let (rate, strain) = if quick { (0.75, SHEAR_STRAINS[0]) } else { (0.5, SHEAR_STRAINS[1]) };
    value["boundaries"][1]["velocity"] = json!([0, 0, -rate * height]);
    let shear = strain / rate;
    value["stages"][0]["duration"] = json!(STAGE_DURATIONS[0]);
    value["stages"][1]["duration"] = json!(STAGE_DURATIONS[1]);
    value["stages"][2]["duration"] = json!(shear);
    value["output"] = json!({ "measures": ROW, "frames": STAGE_DURATIONS[1] });
    let own = method_options(&mut value);
    own["seed"] = json!(seed);
    if friction > 0.0 {
        own["grains"]["grain"]["fill"]["solid_fraction"] = json!(LOOSE_SOLID_FRACTION);
    }
    own["stages"]["prepare"]["pairs"] =
        json!([{ "between": ["grain", "grain"], "friction": { "coefficient": friction } }]);
    if !quick {
        // Grains of three quarters of the size, and a sleeve that is finer by the same ratio.
        own["grains"]["grain"]["diameter"] =
            json!({ "distribution": "uniform", "min": 0.006, "max": 0.0075 });
        let sizes = 0.75;
        let normal = |own: &mut Value, pair: usize| -> Result<(), String> {
            let stiffness = &mut own["pairs"][pair]["normal"]["stiffness"];
            *stiffness = json!(sizes * stiffness.as_f64().ok_or("no stiffness")?);
            Ok(())
        };
        (0..3).try_for_each(|pair| normal(own, pair))?;
        let columns = columns(quick);
        own["grains"]["rubber"]["diameter"]["value"] = json!(0.00225);
        own["grains"]["rubber"]["fill"]["columns"] = json!(columns);
        for stage in ["prepare", "settle", "shear"] {
            own["stages"][stage]["membranes"]["sleeve"]["columns"] = json!(columns);
        }
    }
    Ok(value)
}

/// Curves of a triaxial test over axial strain.
struct TriaxialRecord {
    /// Axial strain from the start of the shear, logarithmic, shortening positive.
    strain: Vec<f64>,
    /// Pressure of the platen over that of the sleeve.
    ratio: Vec<f64>,
    /// Volume over that at the start of the shear, less one.
    dilation: Vec<f64>,
    /// Porosity of the grains within the sleeve.
    porosity: Vec<f64>,
    /// Largest error of the energy balance over the energy input.
    energy: f64,
}

/// Volume of the grains of a body (m³).
fn solid(frame: &Snapshot, body: u32) -> f64 {
    let radii = scalars(frame, "radius");
    (0..frame.ids.len()).filter(|&i| frame.bodies[i] == body).map(|i| 4.0 / 3.0 * PI * radii[i].powi(3)).sum()
}

/// Curves of stress ratio, volume and porosity over axial strain.
fn rows(report: &RunReport) -> Result<TriaxialRecord, String> {
    let start = STAGE_DURATIONS[0] + STAGE_DURATIONS[1];
    let sheared = |name: &str| -> Vec<f64> {
        let all = measure_series(report, name).into_iter();
        all.filter(|(time, _)| *time > start - 1e-9).map(|(_, value)| value).collect()
    };
    let [height, stress, volume] =
        ["wall.top.position", "wall.top.stress", "membrane.sleeve.volume"].map(&sheared);
    let (Some(first), Some(begun)) = (height.first(), volume.first()) else {
        return Err("no rows".to_owned());
    };
    let solid = solid(&report.snapshot, 0);
    Ok(TriaxialRecord {
        strain: height.iter().map(|height| (first / height).ln()).collect(),
        ratio: stress.iter().map(|stress| -stress / PRESSURE).collect(),
        dilation: volume.iter().map(|volume| volume / begun - 1.0).collect(),
        porosity: volume.iter().map(|volume| 1.0 - solid / volume).collect(),
        energy: measure_series(report, "energy_error")
            .into_iter()
            .map(|(_, error)| error.abs())
            .fold(0.0, max_or_nan),
    })
}

/// Mean of a column over the last [`WINDOW`] of the strain.
fn last(strain: &[f64], column: &[f64]) -> f64 {
    let end = strain.last().copied().unwrap_or(0.0);
    let own: Vec<f64> =
        strain.iter().zip(column).filter(|(at, _)| **at > end - WINDOW).map(|(_, value)| *value).collect();
    own.iter().sum::<f64>() / own.len() as f64
}

/// Balance of internal forces and applied pressures at a time, each over its value in equilibrium.
struct ForceBalance {
    /// Radial and axial sums over the contacts of specimen and sleeve, over those of the applied pressures.
    total: [f64; 2],
    /// Share of the sleeve in the axial sum.
    sleeve: f64,
    /// Pressure of the platen over that of the sleeve.
    platen: f64,
}

/// Radial and axial sum of force times position (J) of a pressure on a sheet of closed rows of grains, inwards positive. A piece between
/// four grains has the pressure times half the cross product of its diagonals, a quarter on each grain.
fn pressure_virial(sheet: &[[f64; 3]], columns: usize) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (low, high) in sheet.chunks(columns).zip(sheet.chunks(columns).skip(1)) {
        for k in 0..columns {
            let next = (k + 1) % columns;
            let corners = [low[k], low[next], high[next], high[k]];
            let [d, e] =
                [[2, 0], [3, 1]].map(|[to, from]| [0, 1, 2].map(|c| corners[to][c] - corners[from][c]));
            // Rings run from x to y and upwards: the area points outwards.
            let area = [d[1] * e[2] - d[2] * e[1], d[2] * e[0] - d[0] * e[2], d[0] * e[1] - d[1] * e[0]];
            for x in &corners {
                let share = |c: usize| 0.125 * PRESSURE * area[c] * x[c];
                sums[0] += 0.5 * (share(0) + share(1));
                sums[1] += share(2);
            }
        }
    }
    sums
}

/// Balance of forces at a time. In equilibrium the sum of force times branch vector over all contacts and bonds equals force times position
/// of the external actions.
fn force_balance(report: &RunReport, columns: usize, time: f64) -> Result<ForceBalance, String> {
    let frame = report.frames.iter().find(|frame| (frame.time - time).abs() < 1e-6).ok_or("no frame")?;
    let value = |name: &str| value_at(&measure_series(report, name), time);
    let (area, height, stress) =
        (value("membrane.sleeve.area"), value("wall.top.position"), value("wall.top.stress"));
    let tensors = frame.tensors("stress").ok_or("no stress")?;
    let volumes = scalars(frame, "volume");
    let mut sums = [[0.0; 2]; 2];
    for i in 0..frame.ids.len() {
        let own = &mut sums[frame.bodies[i] as usize];
        let [xx, yy, zz] = [0, 1, 2].map(|c| -tensors[i].0[c] * volumes[i]);
        own[0] += 0.5 * (xx + yy);
        own[1] += zz;
    }
    let sheet: Vec<[f64; 3]> =
        (0..frame.ids.len()).filter(|&i| frame.bodies[i] == 1).map(|i| frame.positions[i]).collect();
    let [radial, axial] = pressure_virial(&sheet, columns);
    let total = [0, 1].map(|c| sums[0][c] + sums[1][c]);
    Ok(ForceBalance {
        total: [total[0] / radial, total[1] / (axial - stress * area * height)],
        sleeve: sums[1][1] / total[1],
        platen: -stress / PRESSURE,
    })
}

/// Value of a series at a time.
fn value_at(series: &[(f64, f64)], time: f64) -> f64 {
    let near = series.iter().min_by(|a, b| (a.0 - time).abs().total_cmp(&(b.0 - time).abs()));
    near.map_or(f64::NAN, |(_, value)| *value)
}

/// Checks that the platen, the contacts and the sleeve have the same pressure before the shear.
fn equilibrium(
    outcome: &mut BenchmarkOutcome,
    name: &str,
    report: &RunReport,
    columns: usize,
) -> Result<(), String> {
    let own = force_balance(report, columns, STAGE_DURATIONS[0] + STAGE_DURATIONS[1])?;
    let reason = "the rule of the platen; 1 % as in B17.8";
    outcome.assert_close(
        format!("{name}, before the shear: platen over sleeve"),
        1.0,
        0.01,
        own.platen,
        reason,
    );
    let reason = "equilibrium: sheet: dem §3.9, B17.8 within 1 %; the friction of the platens along themselves is not counted";
    let name_of =
        |what: &str| format!("{name}, before the shear: sum over contacts over that of the pressure, {what}");
    outcome.assert_close(name_of("radial"), 1.0, 0.01, own.total[0], reason);
    outcome.assert_close(name_of("axial"), 1.0, 0.01, own.total[1], reason);
    let reason = "not judged: a sleeve of grains shrinks with the specimen, and its bonds bear a part";
    outcome.info(format!("{name}, before the shear: axial share of the sleeve"), "", own.sleeve, reason);
    Ok(())
}

/// Checks the equilibrium of specimens in a sleeve, and compares dense with loose ones in triaxial compression.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut pictures = [
        LineChart::new(
            "Triaxial compression in a sleeve",
            "axial strain",
            "pressure of the platen over that of the sleeve",
        ),
        LineChart::new("Volume in triaxial compression", "axial strain", "change of volume"),
    ];
    let mut all = Vec::new();
    for (name, friction) in [("dense", 0.0), ("loose", LOOSE_FRICTION)] {
        let mut drawn = Vec::new();
        for seed in SEEDS {
            let report = run_in_memory("dem", &parse_case(&test(friction, seed, quick)?)?)?;
            if seed == SEEDS[0] {
                equilibrium(&mut outcome, name, &report, columns(quick))?;
            }
            drawn.push(rows(&report)?);
        }
        draw(&mut pictures, name, &drawn[0]);
        let energy = drawn.iter().map(|own| own.energy).fold(0.0, max_or_nan);
        let reason = "sheet: dem §2.14";
        outcome.assert_below(
            format!("{name}: error of the energy balance"),
            "conserved",
            energy,
            0.01,
            reason,
        );
        all.push(drawn);
    }
    let [dense, loose] = &all[..] else { return Err("not two tests".to_owned()) };
    compare(&mut outcome, dense, loose);
    outcome.svg("Dense spheres have a peak and dilate; loose ones have none.", &pictures[0])?;
    outcome.svg("The volume within the sleeve, between the platens.", &pictures[1])?;
    Ok(outcome)
}

/// Adds the curves of a specimen to the charts of stress and volume.
fn draw(pictures: &mut [LineChart; 2], name: &str, own: &TriaxialRecord) {
    for (picture, column) in pictures.iter_mut().zip([&own.ratio, &own.dilation]) {
        let curve = own.strain.iter().copied().zip(column.iter().copied()).collect();
        picture.series.push(Series::new(name, curve, Style::Line));
    }
}

/// Friction angle (degrees) from a ratio of principal stresses.
fn angle(ratio: f64) -> f64 {
    ((ratio - 1.0) / (ratio + 1.0)).asin().to_degrees()
}

/// Mean and standard deviation of a number over packings.
fn packing_statistics(all: &[TriaxialRecord], of: impl Fn(&TriaxialRecord) -> f64) -> (f64, f64) {
    mean_and_deviation(&all.iter().map(of).collect::<Vec<_>>())
}

/// Compares peak strength, final strength and porosity of dense and loose specimens.
fn compare(outcome: &mut BenchmarkOutcome, dense: &[TriaxialRecord], loose: &[TriaxialRecord]) {
    let peaks = |all: &[TriaxialRecord]| {
        packing_statistics(all, |own| angle(own.ratio.iter().copied().fold(0.0, max_or_nan)))
    };
    let ends = |all: &[TriaxialRecord]| packing_statistics(all, |own| angle(last(&own.strain, &own.ratio)));
    let porosities = |all: &[TriaxialRecord]| packing_statistics(all, |own| last(&own.strain, &own.porosity));
    for (name, own) in [("dense", dense), ("loose", loose)] {
        let reason = "not judged: no values in the source; mean of three packings";
        let before = packing_statistics(own, |own| own.porosity[0]);
        for (what, (mean, deviation)) in [
            ("friction angle at the peak (degrees)", peaks(own)),
            ("friction angle at the end (degrees)", ends(own)),
            ("porosity before the shear", before),
            ("porosity at the end", porosities(own)),
        ] {
            outcome.info(format!("{name}: {what}"), "", mean, reason);
            outcome.info(format!("{name}: {what}, standard deviation of packings"), "", deviation, reason);
        }
    }
    let (peak, end) = (|all: &[TriaxialRecord]| peaks(all).0, |all: &[TriaxialRecord]| ends(all).0);
    let porosity = |all: &[TriaxialRecord]| porosities(all).0;
    let change = |all: &[TriaxialRecord]| packing_statistics(all, |own| last(&own.strain, &own.dilation)).0;
    let reason = "B14: the dense specimen has a peak 11 degrees above large strain, the loose one none beyond its scatter of 3 degrees";
    let above = peak(dense) - peak(loose);
    outcome.assert_within(
        "peak of the dense specimen above that of the loose one (degrees)",
        "stronger",
        above,
        (3.0, 20.0),
        reason,
    );
    let reason = "B14: contraction, then dilation of a dense specimen; a loose one contracts";
    outcome.assert_within(
        "dense: change of volume at the end",
        "dilates",
        change(dense),
        (0.01, 0.2),
        reason,
    );
    outcome.assert_below("loose: change of volume at the end", "contracts", change(loose), 0.0, reason);
    let reason = "B14: both within 2.5 degrees of the same critical state";
    outcome.assert_below(
        "friction angles at the end, difference (degrees)",
        "the same",
        (end(dense) - end(loose)).abs(),
        5.0,
        reason,
    );
    let reason = "B14: both within 0.008 of the same critical state";
    outcome.assert_below(
        "porosities at the end, difference",
        "the same",
        (porosity(dense) - porosity(loose)).abs(),
        0.016,
        reason,
    );
}
