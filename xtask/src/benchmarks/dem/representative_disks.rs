//! Number of disks that a periodic cell needs (sheet: dem §5, B16).

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::analysis::{max_or_nan, mean_and_deviation};
use crate::benchmarks::dem::case_builders::{GrainData, grain_file, load, method_options, parse_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, run_in_memory, scalars};

/// Benchmark of biaxial tests of disks between rigid walls and in periodic cells.
pub const WALLS: Benchmark = Benchmark {
    id: "dem/rigid-walls",
    title: "Biaxial tests of disks between rigid walls and in periodic cells, DEM",
    short_seconds: None,
    full_seconds: 200,
    run: |_| walls(),
    ..BENCHMARK
};

/// Benchmark of biaxial tests of windows cut from larger specimens of disks.
pub const WINDOW_TESTS: Benchmark = Benchmark {
    id: "dem/windows",
    title: "Biaxial tests of windows cut from specimens of 1000 disks, DEM",
    short_seconds: Some(40),
    full_seconds: 80,
    run: |quick| windows(if quick { &[300] } else { &[600, 400, 300, 75] }),
    ..BENCHMARK
};

/// Benchmark of biaxial tests of periodic cells with different numbers of disks.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/representative-cell",
    title: "Biaxial tests of periodic cells of 75, 300 and 1000 disks, DEM",
    source: "Sun 2020, §2.1, Figs 1 and 2; sheet: dem §5, B16",
    short_seconds: None,
    full_seconds: 120,
    run: |_| sizes(),
};

/// Numbers of disks of the periodic cells.
const COUNTS: [u32; 3] = [75, 300, 1000];
/// Number of packings of each kind of cell.
pub const SEEDS: u64 = 4;
/// Durations of preparation, settling and shear (times √(m/P)).
const STAGES: [f64; 3] = [150.0, 30.0, 83.0];
/// Rate of the shear (1/√(m/P)).
const RATE: f64 = 3e-4;

/// Sine of the friction angle at the peak, and the anisotropy of the contacts before the shear.
fn test(count: u32, seed: u64) -> Result<(f64, f64), String> {
    let report = run_in_memory("dem", &parse_case(&periodic_case(count, seed)?)?)?;
    let start = STAGES[0] + STAGES[1];
    peak_friction(&report, start, ["cell_stress.yy", "cell_stress.xx"])
}

/// Case of `count` disks in a periodic cell.
pub fn periodic_case(count: u32, seed: u64) -> Result<Value, String> {
    let mut value = load("biaxial")?;
    let side = box_side(&value, count)?;
    value["domain"]["max"] = json!([side, side]);
    value["bodies"][0]["shape"]["max"] = json!([side, side]);
    for (k, duration) in STAGES.iter().enumerate() {
        value["stages"][k]["duration"] = json!(duration);
    }
    method_options(&mut value)["seed"] = json!(seed);
    Ok(value)
}

/// Side of the square in which `count` disks are generated. The case file has 1600.
fn box_side(value: &Value, count: u32) -> Result<f64, String> {
    let whole = value["bodies"][0]["shape"]["max"][0].as_f64().ok_or("no box")?;
    Ok(whole * (f64::from(count) / 1600.0).sqrt())
}

/// Sine of the friction angle at the peak after `start`, and the anisotropy of the contacts before. The columns are those of the vertical
/// and of the lateral stress.
fn peak_friction(report: &RunReport, start: f64, [down, side]: [&str; 2]) -> Result<(f64, f64), String> {
    let sheared = |name: &str| {
        measure_series(report, name)
            .into_iter()
            .filter(move |(time, _)| *time > start - 0.3)
            .map(|(_, value)| value)
    };
    let sines: Vec<f64> =
        sheared(down).zip(sheared(side)).map(|(down, side)| (down - side) / (down + side)).collect();
    // Over a window of strain of 5e-4, four rows (sheet: dem §3.11).
    let window = (5e-4 / RATE / 0.5).round() as usize + 1;
    let peak = sines.windows(window).map(|part| part.iter().sum::<f64>() / window as f64).fold(0.0, f64::max);
    let anisotropy = sheared("fabric.anisotropy").next().ok_or("no fabric")?;
    Ok((peak, anisotropy))
}

/// Checks the anisotropy of the contacts of about `count` grains before the shear.
pub fn check_isotropy(
    outcome: &mut BenchmarkOutcome,
    name: String,
    count: u32,
    anisotropy: f64,
    (bound, reason): (f64, &str),
) {
    if count >= 300 {
        outcome.assert_below(name, "even", anisotropy, bound, reason);
    } else {
        let reason = "not judged: the source calls 75 grains too few";
        outcome.info(name, "uneven in the source", anisotropy, reason);
    }
}

/// Bound of the anisotropy of contacts of disks, and its reason.
const ANISOTROPY_BOUND: (f64, &str) = (0.15, "B16: below 0.15 for 300 grains and more");

/// Checks that the strength scatters less in cells of more disks.
fn sizes() -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut picture = LineChart::new(
        "Strength of periodic cells of disks",
        "disks",
        "sine of the friction angle at the peak",
    );
    picture.log = true;
    let (mut points, mut spreads) = (Vec::new(), Vec::new());
    for count in COUNTS {
        let found: Vec<(f64, f64)> = (1..=SEEDS).map(|seed| test(count, seed)).collect::<Result<_, _>>()?;
        let (mean, spread) = mean_and_deviation(&found.iter().map(|own| own.0).collect::<Vec<f64>>());
        spreads.push(spread);
        points.extend(found.iter().map(|own| (f64::from(count), own.0)));
        let maximum = found.iter().map(|own| own.1).fold(0.0, max_or_nan);
        let name = format!("{count} disks: largest anisotropy of the contacts before the shear");
        check_isotropy(&mut outcome, name, count, maximum, ANISOTROPY_BOUND);
        let reason = "not judged: no values in the source";
        outcome.info(format!("{count} disks: sine of the friction angle at the peak"), "", mean, reason);
    }
    let reason = "B16: it decreases with the number";
    outcome.assert_below(
        "standard deviation of it between drawings, 1000 disks over 75",
        "below one",
        spreads[2] / spreads[0],
        1.0,
        reason,
    );
    let reason = "not judged: four drawings tell it to a half";
    outcome.info(
        "standard deviation of it between drawings, 300 disks over 75",
        "below one",
        spreads[1] / spreads[0],
        reason,
    );
    picture.series.push(Series::new("four drawings of each", points, Style::Markers));
    outcome.svg("B16: fewer grains scatter more.", &picture)?;
    Ok(outcome)
}

/// Deviator at the peak over the lateral stress, from the sine of the friction angle.
fn deviator(sine: f64) -> f64 {
    2.0 * sine / (1.0 - sine)
}

/// Case of `count` disks between rigid walls.
pub fn walled_case(count: u32) -> Result<Value, String> {
    let mut value = load("box")?;
    let side = box_side(&value, count)?;
    value["domain"]["max"] = json!([side + 1.0, side + 1.0]);
    value["bodies"][0]["shape"]["max"] = json!([side, side]);
    for wall in [1, 3] {
        value["boundaries"][wall]["position"] = json!(side);
    }
    // For the height of the grains at a solid fraction of 0.843.
    value["boundaries"][3]["velocity"] = json!([0.0, -RATE * side * (0.7f64 / 0.843).sqrt()]);
    Ok(value)
}

/// Sine of the friction angle at the peak of `count` disks between rigid walls.
fn between_walls(count: u32, seed: u64) -> Result<f64, String> {
    let mut value = walled_case(count)?;
    method_options(&mut value)["seed"] = json!(seed);
    let report = run_in_memory("dem", &parse_case(&value)?)?;
    Ok(peak_friction(&report, STAGES[0] + STAGES[1], ["wall.top.stress", "wall.right.stress"])?.0)
}

/// Compares the strength of disks between rigid walls with that of periodic cells.
fn walls() -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    for count in [300, 1000] {
        let all = |test: &dyn Fn(u64) -> Result<f64, String>| -> Result<(f64, f64), String> {
            let all =
                (1..=SEEDS).map(|seed| Ok(deviator(test(seed)?))).collect::<Result<Vec<f64>, String>>()?;
            Ok(mean_and_deviation(&all))
        };
        let rigid = all(&|seed| between_walls(count, seed))?;
        let round = all(&|seed| Ok(test(count, seed)?.0))?;
        for (name, (mean, spread)) in [("rigid walls", rigid), ("periodic", round)] {
            let name = format!("{count} disks, {name}: deviator at the peak over the lateral stress");
            outcome.info(name.clone(), "", mean, "not judged: no values in the source");
            let reason = "not judged: four drawings tell it to a half";
            outcome.info(format!("{name}, standard deviation between drawings"), "", spread, reason);
        }
        let (rigid, round) = (rigid.0, round.0);
        if count <= 300 {
            let name = format!("{count} disks: peak between rigid walls over that in a periodic cell");
            let reason = "not judged: smooth walls prescribe the displacement across them and no traction along them, a mixed condition \
                          for which no bound against a periodic cell follows";
            outcome.info(name, "–", rigid / round, reason);
        } else {
            let name = format!("{count} disks: difference of the peaks over the mean");
            outcome.assert_below(
                name,
                "fades",
                (rigid - round).abs() / (0.5 * (rigid + round)),
                0.1,
                "B16: < 10 % at about 1000",
            );
        }
    }
    Ok(outcome)
}

/// Compares specimens of 1000 disks at rest with smaller windows cut from them, which come to rest again and are sheared.
fn windows(counts: &[u32]) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut all = vec![Vec::new(); counts.len()];
    for seed in 1..=SEEDS {
        let (grains, side) = specimen(seed)?;
        for (own, &count) in all.iter_mut().zip(counts) {
            let width = side * (f64::from(count) / 1000.0).sqrt();
            let inside: Vec<GrainData> =
                grains.iter().filter(|grain| grain.0[0] < width && grain.0[1] < width).map(shifted).collect();
            own.push(window(&format!("window-{seed}-{count}"), &inside, width + 2.0 * MAX_RADIUS)?);
        }
    }
    for (own, &count) in all.iter().zip(counts) {
        let mean = |of: fn(&(f64, f64)) -> f64| own.iter().map(of).sum::<f64>() / own.len() as f64;
        let name =
            format!("windows of about {count} disks: mean anisotropy of the contacts before the shear");
        check_isotropy(&mut outcome, name, count, mean(|own| own.1), ANISOTROPY_BOUND);
        let maximum = own.iter().map(|own| own.1).fold(0.0, max_or_nan);
        let reason = format!(
            "not judged: as many normals drawn at random, two to a disk, have {:.2} in the mean and more than {:.2} one time in ten",
            random_anisotropy(count, std::f64::consts::FRAC_PI_4),
            random_anisotropy(count, 10f64.ln())
        );
        outcome.info(format!("windows of about {count} disks: the largest of {SEEDS}"), "", maximum, &reason);
        let name = format!("windows of about {count} disks: sine of the friction angle at the peak");
        outcome.info(name, "", mean(|own| own.0), "not judged: no values in the source");
    }
    Ok(outcome)
}

/// Anisotropy that `count` disks with two independent contact normals each would have; `share` is relative to the mean of its square. The
/// square has the mean `8/(2 count)` and an exponential distribution, since the sums of cos 2θ and sin 2θ are both normal.
fn random_anisotropy(count: u32, share: f64) -> f64 {
    (4.0 * share / f64::from(count)).sqrt()
}

/// Largest radius (m).
const MAX_RADIUS: f64 = 0.67;

/// Grain of a window, shifted so that it does not reach across its cell.
fn shifted((place, radius, velocity): &GrainData) -> GrainData {
    (place.iter().map(|x| x + MAX_RADIUS).collect(), *radius, velocity.clone())
}

/// Disks of a periodic cell of 1000 at rest, and the side of the cell (m).
fn specimen(seed: u64) -> Result<(Vec<GrainData>, f64), String> {
    let mut whole = periodic_case(1000, seed)?;
    whole["stages"].as_array_mut().ok_or("no stages")?.truncate(2);
    method_options(&mut whole)["stages"].as_object_mut().ok_or("no stages")?.remove("shear");
    let report = run_in_memory("dem", &parse_case(&whole)?)?;
    let side = measure_series(&report, "cell.x").last().ok_or("no cell")?.1;
    let radii = scalars(&report.snapshot, "radius");
    let grains = report.snapshot.positions.iter().zip(&radii);
    Ok((grains.map(|(x, radius)| (vec![x[0], x[1]], *radius, vec![0.0; 2])).collect(), side))
}

/// Shears a window of disks that was cut from a specimen, after it is brought to the pressure again. The window is a periodic cell that no
/// disk reaches across.
fn window(name: &str, grains: &[GrainData], width: f64) -> Result<(f64, f64), String> {
    let mut value = periodic_case(1000, 1)?;
    value["domain"]["max"] = json!([width, width]);
    value["bodies"][0]["shape"]["max"] = json!([width, width]);
    value["bodies"][0]["points"] = grain_file(name, grains)?;
    value["stages"].as_array_mut().ok_or("no stages")?.remove(0);
    value["stages"][0]["duration"] = json!(100);
    method_options(&mut value)["stages"].as_object_mut().ok_or("no stages")?.remove("prepare");
    let report = run_in_memory("dem", &parse_case(&value)?)?;
    peak_friction(&report, 100.0, ["cell_stress.yy", "cell_stress.xx"])
}
