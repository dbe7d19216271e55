//! Uniform traction by membranes, and a border of grains with a linear displacement, against periodic cells (sheet: dem §5, B16).

use colluvium::case::{RunOptions, RunReport, Snapshot, run_method};
use colluvium::dem::Dem;
use serde_json::{Value, json};

use crate::analysis::max_or_nan;
use crate::benchmarks::dem::case_builders::{method_options, parse_case};
use crate::benchmarks::dem::representative_disks::{SEEDS, periodic_case, walled_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, run_in_memory, scalars};

/// Benchmark of the stiffness of disks under linear displacement, in periodic cells, and under uniform traction.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/membranes",
    title: "Stiffness of 300 disks: linear displacement, periodic cells and uniform traction, DEM",
    source: "Sun 2020, §2.1, Fig. 2; sheet: dem §5, B16",
    short_seconds: None,
    full_seconds: 60,
    run: |_| constraints(),
};

/// Number of disks of a specimen.
const COUNT: u32 = 300;
/// Rate of each principal strain: one shortening and one extension.
const RATE: f64 = 2e-5;
/// Difference of the principal strains at the end of a test.
const STRAIN: f64 = 3e-4;
/// Number of rows of measures until the strain is [`STRAIN`].
const ROWS: f64 = 30.0;
/// Width of the border with prescribed motion (mean diameters of the disks): one whole layer of disks.
const BORDER: f64 = 1.2;
/// Radius of the grains of a membrane (mean diameters of the disks).
const MEMBRANE_GRAIN_SIZE: f64 = 0.1;
/// Approximate distance of neighbouring grains of a membrane, over the mean diameter of the disks.
const APART: f64 = 0.25;
/// Stiffness of a membrane along it, over the pressure times a diameter.
const STIFFNESS: f64 = 10.0;
/// Difference of the pressures on both pairs of sides in successive stages.
const STEPS: [f64; 2] = [0.0, 0.08];
/// Duration of each stage of constant pressures.
const REST_DURATION: f64 = 40.0;

/// Runs a case up to the end of its stage `settle`, and returns the report and the specimen.
fn settled_specimen(mut value: Value, seed: u64) -> Result<(RunReport, String), String> {
    value["stages"].as_array_mut().ok_or("no stages")?.truncate(2);
    method_options(&mut value)["stages"].as_object_mut().ok_or("no stages")?.remove("shear");
    method_options(&mut value)["seed"] = json!(seed);
    let keep = RunOptions { method: "dem".to_owned(), keep_specimen: true, ..RunOptions::default() };
    let report = run_method(&Dem, &parse_case(&value)?, &keep).map_err(|error| error.to_string())?;
    let text = report.specimen.clone().ok_or("no specimen")?;
    Ok((report, text))
}

/// Specimen at rest between rigid walls under a pressure of one.
struct ConsolidatedSpecimen {
    file: String,
    size: [f64; 2],
    pressure: f64,
}

/// Specimen settled between rigid walls, with its size and pressure.
fn prepared_specimen(seed: u64) -> Result<ConsolidatedSpecimen, String> {
    let (report, text) = settled_specimen(walled_case(COUNT)?, seed)?;
    let last = |name: &str| measure_series(&report, name).last().map(|(_, at)| *at).ok_or("no wall");
    let size = [last("wall.right.position")?, last("wall.top.position")?];
    let [_, pressure] = stresses(&report.snapshot, |_| true)?;
    Ok(ConsolidatedSpecimen {
        file: write_input_file(&format!("walls-{seed}.json"), &text)?,
        size,
        pressure: pressure / (size[0] * size[1]),
    })
}

/// Writes a file with which a case begins, and returns its path.
fn write_input_file(name: &str, text: &str) -> Result<String, String> {
    let folder = crate::root().join("target/validation/specimens");
    let file = folder.join(name);
    let done = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&file, text));
    done.map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(file.display().to_string())
}

/// Difference of the vertical and the horizontal stress, and mean of both, times the volume of the grains selected by `counts` (Pa m²).
/// Compression is positive.
fn stresses(frame: &Snapshot, counts: impl Fn(usize) -> bool) -> Result<[f64; 2], String> {
    let stress = frame.tensors("stress").ok_or("no stress")?;
    let volumes = scalars(frame, "volume");
    let mut sums = [0.0; 2];
    for i in (0..frame.ids.len()).filter(|&i| counts(i)) {
        let [xx, yy] = [0, 1].map(|c| -stress[i].0[c] * volumes[i]);
        sums[0] += yy - xx;
        sums[1] += 0.5 * (yy + xx);
    }
    Ok(sums)
}

/// Curve of a specimen in a periodic cell: difference of the strains, and change of the deviator over the pressure.
fn periodic_cell(text: &str, seed: u64) -> Result<Vec<(f64, f64)>, String> {
    let mut value = shear_case(&write_input_file(&format!("cell-{seed}.json"), text)?, seed)?;
    method_options(&mut value)["stages"] =
        json!({ "shear": { "cell": { "xx": { "rate": RATE }, "yy": { "rate": -RATE } } } });
    let report = run_in_memory("dem", &parse_case(&value)?)?;
    let [yy, xx] = ["cell_stress.yy", "cell_stress.xx"].map(|name| measure_series(&report, name));
    let deviator: Vec<(f64, f64)> = yy.iter().zip(&xx).map(|(yy, xx)| (yy.0, xx.1 - yy.1)).collect();
    // The first row precedes the first step.
    let (begun, start) = deviator[1];
    let pressure = -0.5 * (yy[1].1 + xx[1].1);
    let row = |(time, now): &(f64, f64)| (2.0 * RATE * (time - begun), (now - start) / pressure);
    Ok(deviator[1..].iter().map(row).collect())
}

/// Case of the stage `shear` alone, which begins with a specimen of a periodic cell.
fn shear_case(file: &str, seed: u64) -> Result<Value, String> {
    let mut value = periodic_case(COUNT, seed)?;
    let duration = 0.5 * STRAIN / RATE;
    value["stages"] = json!([{ "name": "shear", "duration": duration }]);
    value["output"] = json!({ "measures": duration / ROWS, "frames": duration });
    method_options(&mut value)["stages"] = json!({});
    method_options(&mut value)["specimen"] = json!(file);
    Ok(value)
}

/// Change of the deviator over the pressure at [`STRAIN`], of grains within a border that moves by a linear displacement.
fn linear_displacement(text: &str, seed: u64) -> Result<f64, String> {
    let mut stored: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let cell = stored["head"]["cell"].clone();
    let size = [0, 1].map(|c| number(&cell["vectors"][c][c]));
    let middle = [0, 1].map(|c| number(&cell["corner"][c]) + 0.5 * size[c]);
    let columns = stored["grains"]["columns"].as_array().ok_or("no columns")?;
    let column = |name: &str| columns.iter().position(|own| own[0] == name).ok_or("no such column");
    let (of_body, place) = (column("body")?, [column("x")?, column("y")?]);
    for row in stored["grains"]["rows"].as_array_mut().ok_or("no grains")? {
        let within = |c: usize| (number(&row[place[c]]) - middle[c]).abs() < 0.5 * size[c] - BORDER;
        if !(within(0) && within(1)) {
            row[of_body] = json!(1.0);
        }
    }
    for (list, name) in [("bodies", "border"), ("kinds", "grain")] {
        stored["head"][list].as_array_mut().ok_or("no head")?.push(json!(name));
    }
    let mut value =
        shear_case(&write_input_file(&format!("border-{seed}.json"), &stored.to_string())?, seed)?;
    let domain = value["domain"].clone();
    let half = json!([0.5 * number(&domain["max"][0]), domain["max"][1]]);
    let mut border = value["bodies"][0].clone();
    // The grains are those of the file, independent of the shapes.
    value["bodies"][0]["shape"]["max"] = half.clone();
    border["name"] = json!("border");
    border["shape"]["min"] = json!([half[0], 0]);
    border["velocity"] =
        json!({ "kind": "linear", "value": [0, 0], "origin": middle, "gradient": [[RATE, 0], [0, -RATE]] });
    value["bodies"].as_array_mut().ok_or("no bodies")?.push(border);
    method_options(&mut value)["bodies"] = json!({ "border": { "held": true } });
    let report = run_in_memory("dem", &parse_case(&value)?)?;
    let inner = |frame: &Snapshot| stresses(frame, |i| frame.bodies[i] == 0);
    let [start, pressure] = inner(report.frames.first().ok_or("no frames")?)?;
    Ok((inner(&report.snapshot)?[0] - start) / pressure)
}

/// Rows of membrane grains along the four sides, one body each, with equal distances also around corners. They are the first three columns
/// of point files.
fn rows([wide, high]: [f64; 2]) -> [(&'static str, String); 4] {
    let row = |length: f64, place: &dyn Fn(f64) -> [f64; 2]| {
        // From corner to corner; the part cut off at a corner has the length of the other distances.
        let whole = length + 2.0 * MEMBRANE_GRAIN_SIZE;
        let parts = ((whole / APART) - 2f64.sqrt()).round();
        let pitch = whole / (parts + 2f64.sqrt());
        let mut text = "x,y,radius\n".to_owned();
        for k in 0..=parts as usize {
            let [x, y] = place(pitch * (k as f64 + 0.5f64.sqrt()) - MEMBRANE_GRAIN_SIZE);
            text += &format!("{x:?},{y:?},{MEMBRANE_GRAIN_SIZE:?}\n");
        }
        text
    };
    [
        ("west", row(high, &|s| [-MEMBRANE_GRAIN_SIZE, s])),
        ("east", row(high, &|s| [wide + MEMBRANE_GRAIN_SIZE, s])),
        ("south", row(wide, &|s| [s, -MEMBRANE_GRAIN_SIZE])),
        ("north", row(wide, &|s| [s, high + MEMBRANE_GRAIN_SIZE])),
    ]
}

/// Boxes that contain the rows of membrane grains of a side.
fn strip(side: &str, [wide, high]: [f64; 2]) -> Value {
    let (low, up) = match side {
        "west" => ([-4.0 * MEMBRANE_GRAIN_SIZE, 0.0], [0.0, high]),
        "east" => ([wide, 0.0], [wide + 4.0 * MEMBRANE_GRAIN_SIZE, high]),
        "south" => ([0.0, -4.0 * MEMBRANE_GRAIN_SIZE], [wide, 0.0]),
        _ => ([0.0, high], [wide, high + 4.0 * MEMBRANE_GRAIN_SIZE]),
    };
    json!({ "kind": "box", "min": low, "max": up })
}

/// Case of a specimen within membranes on all sides.
fn membrane_case(specimen: &ConsolidatedSpecimen, seed: u64) -> Result<Value, String> {
    let mut value = walled_case(COUNT)?;
    let [wide, high] = specimen.size;
    value["domain"] = json!({ "min": [-2, -2], "max": [wide + 2.0, high + 2.0] });
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0, 0], "max": [wide, high] });
    value["boundaries"] = json!([]);
    value["materials"]["membrane"] = value["materials"]["grain"].clone();
    for (name, text) in rows(specimen.size) {
        let file = write_input_file(&format!("{name}-{seed}.csv"), &text)?;
        let shape = strip(name, specimen.size);
        let body =
            json!({ "name": name, "material": "membrane", "shape": shape, "points": { "file": file } });
        value["bodies"].as_array_mut().ok_or("no bodies")?.push(body);
    }
    let stage = |number: usize| json!({ "name": format!("step-{number}"), "duration": REST_DURATION, "rayleigh_damping": 0.1 });
    value["stages"] = (0..STEPS.len()).map(stage).collect();
    value["output"] = json!({ "measures": REST_DURATION, "frames": REST_DURATION });
    let own = method_options(&mut value);
    own["stages"] = json!({});
    own["specimen"] = json!(specimen.file);
    own["grains"]["membrane"] = json!({ "density": 16 });
    let normal = own["pairs"][0]["normal"].clone();
    // A bond has the cross-section of a grain.
    let stiffness = STIFFNESS / (APART * 2.0 * MEMBRANE_GRAIN_SIZE);
    let pairs = own["pairs"].as_array_mut().ok_or("no pairs")?;
    // Without friction the ring of membranes surrounds the specimen as a belt.
    pairs.push(
        json!({ "between": ["grain", "membrane"], "normal": normal, "friction": { "coefficient": 0.5 } }),
    );
    pairs.push(json!({ "between": ["membrane", "membrane"], "normal": normal,
        "bond": { "normal_stiffness": stiffness, "shear_stiffness": stiffness, "gap": 0.5 } }));
    for (number, step) in STEPS.iter().enumerate() {
        let press = |pressure: f64| json!({ "pressure": pressure, "against": "specimen" });
        let [beside, above] = [press(1.0 - 0.5 * step), press(1.0 + 0.5 * step)];
        own["stages"][format!("step-{number}")] =
            json!({ "membranes": { "west": beside, "east": beside, "south": above, "north": above } });
    }
    Ok(value)
}

/// Difference of the strains along the axes between two frames, positive for vertical shortening and horizontal extension, by the best fit
/// to the specimen: Green's strain, since the specimen may rotate.
fn strain(from: &Snapshot, to: &Snapshot) -> f64 {
    let own: Vec<usize> = (0..from.ids.len()).filter(|&i| from.bodies[i] == 0).collect();
    let mean = |of: &dyn Fn(usize) -> f64| own.iter().map(|&i| of(i)).sum::<f64>() / own.len() as f64;
    let centre = [0, 1].map(|c| mean(&|i| from.positions[i][c]));
    let off = |i: usize, c: usize| from.positions[i][c] - centre[c];
    let [xx, yy, xy] = [[0, 0], [1, 1], [0, 1]].map(|[a, b]| mean(&|i| off(i, a) * off(i, b)));
    let gradient = [0, 1].map(|axis| {
        let [x, y] = [0, 1].map(|c| mean(&|i| off(i, c) * (to.positions[i][axis] - from.positions[i][axis])));
        [x * yy - y * xy, y * xx - x * xy].map(|own| own / (xx * yy - xy * xy))
    });
    let green = |c: usize| gradient[c][c] + 0.5 * (gradient[0][c].powi(2) + gradient[1][c].powi(2));
    green(0) - green(1)
}

/// Difference of the strains and change of the deviator over the pressure, of a specimen under membranes on all sides.
fn uniform_traction(specimen: &ConsolidatedSpecimen, seed: u64) -> Result<(f64, f64), String> {
    let report = run_in_memory("dem", &parse_case(&membrane_case(specimen, seed)?)?)?;
    let inside = |frame: &Snapshot| stresses(frame, |i| frame.bodies[i] == 0);
    let [_, first, last] = &report.frames[..] else { return Err("not three frames".to_owned()) };
    let [start, pressure] = inside(first)?;
    Ok((strain(first, last), (inside(last)?[0] - start) / pressure))
}

/// Value at `x` of a curve that begins at zero.
fn value_at(curve: &[(f64, f64)], x: f64) -> f64 {
    let after = curve.iter().position(|own| own.0 >= x).unwrap_or(curve.len() - 1).max(1);
    let ((a, low), (b, high)) = (curve[after - 1], curve[after]);
    low + (high - low) * (x - a) / (b - a)
}

/// Checks that periodic cells are stiffer than specimens under uniform traction, and softer than those with a linear displacement.
fn constraints() -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let (mut ratios, mut stiffness, mut pressures) = ([0.0; 2], 0.0, Vec::new());
    for seed in 1..=SEEDS {
        let specimen = prepared_specimen(seed)?;
        pressures.push(specimen.pressure);
        let (_, text) = settled_specimen(periodic_case(COUNT, seed)?, seed)?;
        let curve = periodic_cell(&text, seed)?;
        let linear = linear_displacement(&text, seed)? / value_at(&curve, STRAIN);
        let (strain, deviator) = uniform_traction(&specimen, seed)?;
        let uniform = deviator / value_at(&curve, strain);
        for (sum, own) in ratios.iter_mut().zip([linear, uniform]) {
            *sum += own / SEEDS as f64;
        }
        stiffness += value_at(&curve, STRAIN) / STRAIN / SEEDS as f64;
        let reason = "not judged: one drawing";
        outcome.info(format!("drawing {seed}: linear displacement over periodic"), "", linear, reason);
        outcome.info(format!("drawing {seed}: uniform traction over periodic"), "", uniform, reason);
        outcome.info(
            format!("drawing {seed}: difference of the strains under uniform traction"),
            "",
            strain,
            reason,
        );
    }
    let off = pressures.iter().map(|own| (own - 1.0).abs()).fold(0.0, max_or_nan);
    outcome.assert_below(
        "B17.8: mean stress of the grains between walls against the pressure of the walls",
        "the same",
        off,
        0.01,
        "B17.8: within 1 %",
    );
    let name =
        format!("{COUNT} disks, periodic: deviator over pressure and difference of strains of {STRAIN:e}");
    outcome.info(name, "", stiffness, "not judged: no values in the source");
    let reason = "the source: a linear displacement is the stiffest constraint, uniform traction the softest, a periodic cell lies between";
    outcome.assert_within(
        "stiffness by a linear displacement over that of a periodic cell, mean of four drawings",
        "at least one",
        ratios[0],
        (1.0, 2.0),
        reason,
    );
    outcome.assert_within(
        "stiffness by uniform traction over that of a periodic cell, mean of four drawings",
        "at most one",
        ratios[1],
        (0.2, 1.0),
        reason,
    );
    Ok(outcome)
}
