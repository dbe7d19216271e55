//! Number of spheres that a periodic cell needs, and windows cut from a larger one (sheet: dem §5, B16).

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::analysis::{max_or_nan, mean_and_deviation};
use crate::benchmarks::dem::case_builders::{GrainData, grain_file, load, method_options, parse_case};
use crate::benchmarks::dem::representative_disks::check_isotropy;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, run_in_memory, scalars};

/// Benchmark of triaxial tests of periodic cells with different numbers of spheres.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/representative-spheres",
    title: "Triaxial tests of periodic cells of 75, 311 and 979 spheres, DEM",
    source: "Sun 2020, §2.1, Figs 1 and 2; sheet: dem §5, B16",
    short_seconds: None,
    full_seconds: 90,
    run: |_| cells(),
};

/// Benchmark of triaxial tests of windows cut from larger specimens of spheres.
pub const WINDOW_TESTS: Benchmark = Benchmark {
    id: "dem/windows-spheres",
    title: "Triaxial tests of windows cut from specimens of 979 spheres, DEM",
    short_seconds: Some(75),
    full_seconds: 160,
    run: |quick| if quick { windows(&[311], 3) } else { windows(&WINDOW_GRAINS, SEEDS) },
    ..BENCHMARK
};

/// Benchmark of triaxial tests of spheres between rigid walls and in periodic cells.
pub const WALLS: Benchmark = Benchmark {
    id: "dem/rigid-walls-spheres",
    title: "Triaxial tests of spheres between rigid walls and in periodic cells, DEM",
    short_seconds: None,
    full_seconds: 120,
    run: |_| walls(),
    ..BENCHMARK
};

/// Number of spheres of the specimen in the case file.
const SPECIMEN_GRAINS: u32 = 979;
/// Numbers of spheres of the windows of the source.
const WINDOW_GRAINS: [u32; 4] = [619, 413, 311, 75];
/// Numbers of spheres of the periodic cells.
const CELL_GRAINS: [u32; 3] = [75, 311, 979];
/// Number of packings of each cell.
const SEEDS: u64 = 4;
/// Duration of the preparation in the case file (times √(m/(P d))).
const PREPARATION_DURATION: f64 = 100.0;
/// Duration of the settling in the case file (times √(m/(P d))).
const SETTLING_DURATION: f64 = 30.0;
/// Rate of the shear (1/√(m/(P d))).
const RATE: f64 = 1e-3;
/// Duration in which a window comes to rest (times √(m/(P d))).
const EQUILIBRATION_TIME: f64 = 60.0;
/// Strain over which stresses are averaged.
const WINDOW: f64 = 2e-3;

/// Result of a triaxial test of spheres.
struct SpheresResult {
    /// Deviator at the peak over the lateral stress.
    peak: f64,
    /// Anisotropy of the contacts and porosity before the shear.
    anisotropy: f64,
    porosity: f64,
}

/// Largest deviator over the lateral stress, averaged over a window of strain. The columns are the two lateral stresses and the axial one.
fn peak([one, other, down]: &[Vec<f64>; 3]) -> f64 {
    let ratios: Vec<f64> = down
        .iter()
        .zip(one)
        .zip(other)
        .map(|((down, one), other)| down / (0.5 * (one + other)) - 1.0)
        .collect();
    let rows = (WINDOW / RATE / 0.5).round() as usize + 1;
    ratios.windows(rows).map(|part| part.iter().sum::<f64>() / rows as f64).fold(0.0, max_or_nan)
}

/// Values of a measure after `start`.
fn values_after(report: &RunReport, start: f64, name: &str) -> Vec<f64> {
    let after = measure_series(report, name).into_iter().filter(|(time, _)| *time > start - 0.3);
    after.map(|(_, value)| value).collect()
}

/// Result from the rows after `start`.
fn result_after(report: &RunReport, start: f64) -> Result<SpheresResult, String> {
    let sheared = |name: &str| values_after(report, start, name);
    let peak = peak(&["xx", "yy", "zz"].map(|entry| sheared(&format!("cell_stress.{entry}"))));
    let first = |name: &str| sheared(name).first().copied().ok_or_else(|| format!("no {name}"));
    let volume = first("cell.x")? * first("cell.y")? * first("cell.z")?;
    let solid: f64 = scalars(&report.snapshot, "radius")
        .iter()
        .map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3))
        .sum();
    Ok(SpheresResult { peak, anisotropy: first("fabric.anisotropy")?, porosity: 1.0 - solid / volume })
}

/// Case of `count` spheres, generated with a seed.
fn cell(count: u32, seed: u64) -> Result<Value, String> {
    let mut value = load("triaxial")?;
    let side = box_side(&value, count)?;
    set_box(&mut value, side);
    method_options(&mut value)["seed"] = json!(seed);
    Ok(value)
}

/// Side of the cube in which `count` spheres are generated.
fn box_side(value: &Value, count: u32) -> Result<f64, String> {
    let whole = value["bodies"][0]["shape"]["max"][0].as_f64().ok_or("no box")?;
    Ok(whole * (f64::from(count) / f64::from(SPECIMEN_GRAINS)).cbrt())
}

/// Sets the edge of the cube that is the domain and the body.
fn set_box(value: &mut Value, side: f64) {
    value["domain"]["max"] = json!([side, side, side]);
    value["bodies"][0]["shape"]["max"] = json!([side, side, side]);
}

/// Bound on the anisotropy of the contacts of `count` spheres, and its reason. Random directions have 4 (1/2 N)^½ for N contacts in the
/// plane and 7.5 (2/3 N)^½ in space; at rest without friction there are two contacts a disk and three a sphere (sheet: dem §5, B16).
fn anisotropy_bound(count: u32) -> (f64, &'static str) {
    let chance = |factor: f64, contacts: f64| factor / contacts.sqrt();
    let space = chance(7.5 * (2.0f64 / 3.0).sqrt(), 3.0 * f64::from(count));
    let plane = chance(4.0 * 0.5f64.sqrt(), 2.0 * 300.0);
    (
        0.15 * space / plane,
        "B16: even for all but 75 spheres; 0.15 for 300 disks, as many times what chance makes",
    )
}

/// Checks that the strength scatters less in cells of more spheres.
fn cells() -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut picture = LineChart::new(
        "Strength of periodic cells of spheres",
        "spheres",
        "deviator at the peak over the lateral stress",
    );
    picture.log = true;
    let (mut marks, mut spreads) = (Vec::new(), Vec::new());
    for count in CELL_GRAINS {
        let test = |seed| {
            result_after(
                &run_in_memory("dem", &parse_case(&cell(count, seed)?)?)?,
                PREPARATION_DURATION + SETTLING_DURATION,
            )
        };
        let all: Vec<SpheresResult> = (1..=SEEDS).map(test).collect::<Result<_, _>>()?;
        let porosity = all.iter().map(|own| own.porosity).sum::<f64>() / SEEDS as f64;
        let (peak, spread) = mean_and_deviation(&all.iter().map(|own| own.peak).collect::<Vec<f64>>());
        spreads.push(spread);
        marks.extend(all.iter().map(|own| (f64::from(count), own.peak)));
        let maximum = all.iter().map(|own| own.anisotropy).fold(0.0, max_or_nan);
        check_isotropy(
            &mut outcome,
            format!("{count} spheres: largest anisotropy of the contacts before the shear"),
            count,
            maximum,
            anisotropy_bound(count),
        );
        let reason = "not judged: no values in the source";
        outcome.info(
            format!("{count} spheres: deviator at the peak over the lateral stress"),
            "",
            peak,
            reason,
        );
        let reason = "not judged: the source's dense specimen, whose preparation it does not give";
        outcome.info(format!("{count} spheres: porosity before the shear"), "0.375", porosity, reason);
    }
    let name = "standard deviation of it between drawings, 979 spheres over 75";
    outcome.assert_below(
        name,
        "below one",
        spreads[2] / spreads[0],
        1.0,
        "B16: it decreases with the number",
    );
    let reason = "not judged: four drawings tell it to a half";
    outcome.info(
        "standard deviation of it between drawings, 311 spheres over 75",
        "below one",
        spreads[1] / spreads[0],
        reason,
    );
    picture.series.push(Series::new("four drawings of each", marks, Style::Markers));
    outcome.svg("B16: fewer grains scatter more.", &picture)?;
    Ok(outcome)
}

/// Peak deviator over the lateral stress of `count` spheres between rigid walls.
fn between_walls(count: u32, seed: u64) -> Result<f64, String> {
    let mut value = load("box-spheres")?;
    let side = box_side(&value, count)?;
    value["domain"]["max"] = json!([side + 1.0, side + 1.0, side + 1.0]);
    value["bodies"][0]["shape"]["max"] = json!([side, side, side]);
    for wall in [1, 3, 5] {
        value["boundaries"][wall]["position"] = json!(side);
    }
    // For the height of the spheres at a porosity of 0.36, generated at a solid fraction of one half.
    value["boundaries"][5]["velocity"] = json!([0.0, 0.0, -RATE * side * (0.5f64 / 0.64).cbrt()]);
    method_options(&mut value)["seed"] = json!(seed);
    let report = run_in_memory("dem", &parse_case(&value)?)?;
    let stress = |wall: &str| {
        values_after(&report, PREPARATION_DURATION + SETTLING_DURATION, &format!("wall.{wall}.stress"))
    };
    Ok(peak(&["right", "back", "top"].map(stress)))
}

/// Compares the strength of spheres between rigid walls with that of periodic cells.
fn walls() -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut picture = LineChart::new(
        "Strength of spheres between rigid walls and in periodic cells",
        "spheres",
        "deviator at the peak over the lateral stress",
    );
    picture.log = true;
    let mut marks = [Vec::new(), Vec::new()];
    for count in [311, SPECIMEN_GRAINS] {
        let round = |seed| {
            Ok(result_after(
                &run_in_memory("dem", &parse_case(&cell(count, seed)?)?)?,
                PREPARATION_DURATION + SETTLING_DURATION,
            )?
            .peak)
        };
        let all = |test: &dyn Fn(u64) -> Result<f64, String>| -> Result<Vec<f64>, String> {
            (1..=SEEDS).map(test).collect()
        };
        let drawn = [all(&|seed| between_walls(count, seed))?, all(&round)?];
        for (marks, own) in marks.iter_mut().zip(&drawn) {
            marks.extend(own.iter().map(|peak| (f64::from(count), *peak)));
        }
        let [rigid, round] = drawn.map(|own| mean_and_deviation(&own));
        for (name, (mean, spread)) in [("rigid walls", rigid), ("periodic", round)] {
            let name = format!("{count} spheres, {name}: deviator at the peak over the lateral stress");
            outcome.info(name.clone(), "", mean, "not judged: no values in the source");
            let reason = "not judged: four drawings tell it to a half";
            outcome.info(format!("{name}, standard deviation between drawings"), "", spread, reason);
        }
        if count < SPECIMEN_GRAINS {
            let name = format!("{count} spheres: peak between rigid walls over that in a periodic cell");
            let reason = "not judged: B16 requires it in the plane, for 300 disks and fewer";
            outcome.info(name, "at least one", rigid.0 / round.0, reason);
        } else {
            let name = format!("{count} spheres: difference of the peaks over the mean");
            let difference = (rigid.0 - round.0).abs() / (0.5 * (rigid.0 + round.0));
            outcome.assert_below(name, "fades", difference, 0.1, "B16: < 10 % at about 1000");
        }
    }
    for (name, marks) in
        ["smooth rigid walls, four drawings", "periodic cells, four drawings"].into_iter().zip(marks)
    {
        picture.series.push(Series::new(name, marks, Style::Markers));
    }
    outcome.svg(
        "B16: what kind of boundary a specimen has matters less, the more spheres it holds.",
        &picture,
    )?;
    Ok(outcome)
}

/// Compares specimens of 979 spheres at rest with smaller windows cut from them, which come to rest again and are sheared. Results are
/// means over the specimens.
fn windows(counts: &[u32], specimens: u64) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut all: Vec<Vec<SpheresResult>> = counts.iter().map(|_| Vec::new()).collect();
    for seed in 1..=specimens {
        let (places, sides) = specimen(seed)?;
        for (own, &count) in all.iter_mut().zip(counts) {
            own.push(window(seed, count, &places, sides)?);
        }
    }
    for (own, &count) in all.iter().zip(counts) {
        let of =
            |of: fn(&SpheresResult) -> f64| mean_and_deviation(&own.iter().map(of).collect::<Vec<f64>>());
        let [(uneven, spread), (peak, scattered)] = [of(|own| own.anisotropy), of(|own| own.peak)];
        let name =
            format!("windows of about {count} spheres: mean anisotropy of the contacts before the shear");
        check_isotropy(&mut outcome, name, count, uneven, anisotropy_bound(count));
        let chance = format!("not judged: {specimens} specimens");
        let maximum = own.iter().map(|own| own.anisotropy).fold(0.0, max_or_nan);
        for (name, value) in [("standard deviation between specimens", spread), ("the largest", maximum)] {
            outcome.info(format!("this anisotropy, {name}"), "", value, &chance);
        }
        let name = format!("windows of about {count} spheres: deviator at the peak over the lateral stress");
        outcome.info(name, "", peak, "not judged: no values in the source");
        outcome.info("this peak, standard deviation between specimens", "", scattered, &chance);
    }
    Ok(outcome)
}

/// Centres of the spheres of a specimen at rest, and the sides of its cell (m).
fn specimen(seed: u64) -> Result<(Vec<[f64; 3]>, [f64; 3]), String> {
    let mut whole = cell(SPECIMEN_GRAINS, seed)?;
    whole["stages"].as_array_mut().ok_or("no stages")?.truncate(2);
    method_options(&mut whole)["stages"].as_object_mut().ok_or("no stages")?.remove("shear");
    let report = run_in_memory("dem", &parse_case(&whole)?)?;
    let side = |axis: &str| {
        measure_series(&report, &format!("cell.{axis}")).last().map(|(_, side)| *side).ok_or("no cell")
    };
    Ok((report.snapshot.positions.clone(), [side("x")?, side("y")?, side("z")?]))
}

/// Result of a window of about `count` spheres cut from a specimen, which is brought to the pressure again and sheared.
fn window(seed: u64, count: u32, places: &[[f64; 3]], sides: [f64; 3]) -> Result<SpheresResult, String> {
    let share = (f64::from(count) / f64::from(SPECIMEN_GRAINS)).cbrt();
    let widths = sides.map(|side| share * side);
    // At a distance of the reach of a sphere from the sides of its cell: none is in contact across them.
    let within = |x: &[f64; 3]| (0..3).all(|c| x[c] < widths[c]);
    let grains: Vec<GrainData> = (places.iter())
        .filter(|x| within(x))
        .map(|x| (x.iter().map(|c| c + 0.5).collect(), 0.5, vec![0.0; 3]))
        .collect();
    let mut value = cell(SPECIMEN_GRAINS, 1)?;
    let cell = widths.map(|width| width + 1.0);
    value["domain"]["max"] = json!(cell);
    value["bodies"][0]["shape"]["max"] = json!(cell);
    value["bodies"][0]["points"] = grain_file(&format!("window-spheres-{seed}-{count}"), &grains)?;
    value["stages"].as_array_mut().ok_or("no stages")?.remove(0);
    value["stages"][0]["duration"] = json!(EQUILIBRATION_TIME);
    method_options(&mut value)["stages"].as_object_mut().ok_or("no stages")?.remove("prepare");
    result_after(&run_in_memory("dem", &parse_case(&value)?)?, EQUILIBRATION_TIME)
}
