//! Collapsing columns of disks (sheet: dem §5, B13).

use std::f64::consts::PI;

use colluvium::case::{Snapshot, Solver};
use colluvium::dem::DemSolver;
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use serde_json::{Value, json};

use crate::analysis::mean_and_deviation;
use crate::benchmarks::dem::case_builders::{disk_solver, load, method_options, output_value, step};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, scalars};

/// Benchmark of the collapse of a column of disks with an aspect ratio of one.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/column",
    title: "Collapse of a column of 1500 disks, a = 1, DEM",
    source: "sheet: dem §5, B13",
    short_seconds: None,
    full_seconds: 96,
    run: |_| columns(&SHEET[1..2]),
};

/// Benchmark of the collapse of columns of disks with five aspect ratios.
pub const ASPECT_SWEEP: Benchmark = Benchmark {
    id: "dem/column-sweep",
    title: "Collapse of columns of 1500 disks, a = 0.5 to 8, DEM",
    source: "sheet: dem §5, B13; Staron and Hinch 2005; Lube et al. 2005",
    short_seconds: None,
    full_seconds: 600,
    run: |_| columns(&SHEET),
};

/// Result of the sheet's code for a column.
#[derive(Clone, Copy)]
struct ReferenceColumn {
    aspect: f64,
    /// Run-out of the connected front and of 98 % of the mass over the initial width.
    front: f64,
    mass: f64,
    /// Final height over the initial width.
    height: f64,
    /// Largest kinetic energy over the potential energy of the start.
    kinetic: f64,
    /// Allowed relative deviation of the results.
    band: f64,
    /// Quantities that scatter with the packing: mean and standard deviation over the packings of the sheet.
    scatter: PackingScatter,
}

/// Allowed range of the mean of a figure over several packings.
#[derive(Clone, Copy)]
enum PackingSpread {
    /// Within three standard deviations of such a mean: mean and standard deviation of single packings.
    Packings(f64, f64),
    /// Within a band of the sheet: its middle and half its width.
    Band(f64, f64),
}

impl PackingSpread {
    /// Bounds of a mean over `count` packings, with the statement of the source and the reason.
    fn bounds_of_mean(self, count: usize) -> ((f64, f64), String, &'static str) {
        match self {
            Self::Packings(middle, deviation) => {
                let off = 3.0 * deviation / (count as f64).sqrt();
                let reason = "B13, as corrected: three standard deviations of the mean of so many packings";
                ((middle - off, middle + off), format!("{middle} ± {deviation} (single packings)"), reason)
            }
            Self::Band(middle, half) => {
                let ends = (middle - half, middle + half);
                (ends, format!("{:.3} to {:.3}", ends.0, ends.1), "B13: the sheet's band")
            }
        }
    }
}

/// Allowed ranges of three figures of a column: times over √(H₀/g) of the largest kinetic energy and of rest, and the front at 3 √(H₀/g)
/// over that at the end.
#[derive(Clone, Copy)]
struct PackingScatter {
    front_time: PackingSpread,
    early_front: PackingSpread,
    final_rest: PackingSpread,
}

/// Result of the sheet's code for a column: front, mass quantile, height and kinetic energy, with their allowed relative deviation.
const fn row(
    aspect: f64,
    [front, mass, height, kinetic]: [f64; 4],
    band: f64,
    scatter: PackingScatter,
) -> ReferenceColumn {
    ReferenceColumn { aspect, front, mass, height, kinetic, band, scatter }
}

/// Allowed ranges of the sheet, where it has no scatter of packings.
const fn sheet_bands(when: f64, band: f64) -> PackingScatter {
    PackingScatter {
        front_time: PackingSpread::Band(when, when * band),
        early_front: PackingSpread::Band(0.725, 0.125),
        final_rest: PackingSpread::Band(7.0, 2.0),
    }
}

/// Results of the sheet's code for columns of five aspect ratios.
const SHEET: [ReferenceColumn; 5] = [
    row(
        0.50,
        [0.88, 0.68, 0.506, 0.050],
        0.10,
        PackingScatter {
            front_time: PackingSpread::Packings(1.23, 0.23),
            early_front: PackingSpread::Packings(0.65, 0.09),
            final_rest: PackingSpread::Packings(8.7, 1.5),
        },
    ),
    row(
        0.99,
        [1.98, 1.68, 0.672, 0.103],
        0.10,
        PackingScatter {
            front_time: PackingSpread::Packings(1.28, 0.18),
            early_front: PackingSpread::Packings(0.68, 0.05),
            final_rest: PackingSpread::Packings(7.2, 0.65),
        },
    ),
    row(
        1.98,
        [4.07, 3.55, 0.863, 0.181],
        0.10,
        PackingScatter {
            front_time: PackingSpread::Packings(1.12, 0.08),
            early_front: PackingSpread::Packings(0.70, 0.02),
            final_rest: PackingSpread::Packings(6.4, 0.6),
        },
    ),
    row(3.97, [7.80, 6.95, 1.15, 0.253], 0.10, sheet_bands(0.97, 0.10)),
    row(7.95, [12.0, 11.9, 1.42, 0.347], 0.15, sheet_bands(0.95, 0.15)),
];

/// Number of disks.
const COUNT: f64 = 1500.0;
/// Solid fraction from which the sheet estimates the width of the column.
const SOLID: f64 = 0.83;

/// Seeds of the packings over which the results of a column are averaged. The sheet's values are means of two; the largest kinetic energy
/// of single packings scatters by 4 % for a = 1, so that a mean of two is not known to a third of the band.
const SEEDS: [u64; 4] = [1, 2, 3, 4];

/// Case of a column with an aspect ratio, and its initial width (m).
fn set_up(aspect: f64, seed: u64) -> Result<(Value, f64), String> {
    let mut value = load("column")?;
    // Mean area of a disk: the mean square of the diameters by number is 0.9867 for this curve.
    let area = COUNT * PI / 4.0 * 0.9867;
    let width = (area / (SOLID * aspect)).sqrt();
    // Single disks run half as far again as the rest.
    let reach = (1.5 * width * (2.5 + 3.2 * aspect)).ceil();
    let fill = area / (0.80 * width);
    value["domain"]["max"] = json!([reach + 1.0, fill + 5.0]);
    value["bodies"][0]["shape"]["max"] = json!([width, fill]);
    value["bodies"][1]["shape"]["max"] = json!([reach, 0]);
    value["boundaries"][1]["position"] = json!(width);
    let stiffness = 5e3 * aspect * width;
    let own = method_options(&mut value);
    for k in 0..3 {
        own["pairs"][k]["normal"]["stiffness"] = json!(stiffness);
    }
    own["seed"] = json!(seed);
    own["time_step"] = json!(PI * (0.08 * PI / stiffness).sqrt() / 12.0);
    Ok((value, width))
}

/// Front and height of the largest cluster of grains with gaps below 0.05, and the 98 % quantile of mass.
fn measures(snapshot: &Snapshot) -> [f64; 3] {
    let radii = scalars(snapshot, "radius");
    let grains: Vec<([f64; 2], f64)> = (0..radii.len())
        .filter(|&i| snapshot.bodies[i] == 0)
        .map(|i| ([snapshot.positions[i][0], snapshot.positions[i][1]], radii[i]))
        .collect();
    let mut order: Vec<usize> = (0..grains.len()).collect();
    order.sort_by(|&a, &b| grains[a].0[0].total_cmp(&grains[b].0[0]));
    // Cluster of each grain, by its smallest number.
    let mut cluster: Vec<usize> = (0..grains.len()).collect();
    let root = |cluster: &[usize], mut i: usize| {
        while cluster[i] != i {
            i = cluster[i];
        }
        i
    };
    for (k, &i) in order.iter().enumerate() {
        for &j in order[k + 1..].iter().take_while(|&&j| grains[j].0[0] - grains[i].0[0] < 1.3) {
            let apart = (grains[j].0[0] - grains[i].0[0]).hypot(grains[j].0[1] - grains[i].0[1]);
            if apart - grains[i].1 - grains[j].1 < 0.05 {
                let (a, b) = (root(&cluster, i), root(&cluster, j));
                cluster[a.max(b)] = a.min(b);
            }
        }
    }
    let roots: Vec<usize> = (0..grains.len()).map(|i| root(&cluster, i)).collect();
    let mut sizes = vec![0usize; grains.len()];
    roots.iter().for_each(|&own| sizes[own] += 1);
    let largest = (0..sizes.len()).max_by_key(|&own| sizes[own]).unwrap_or(0);
    let (mut front, mut top) = (0.0f64, 0.0f64);
    for (x, r) in grains.iter().zip(&roots).filter(|(_, own)| **own == largest).map(|(grain, _)| grain) {
        front = front.max(x[0] + r);
        top = top.max(x[1] + r);
    }
    let total: f64 = grains.iter().map(|(_, r)| r * r).sum();
    let (mut sum, mut quantile) = (0.0, 0.0);
    for &i in &order {
        sum += grains[i].1 * grains[i].1;
        if sum <= 0.98 * total {
            quantile = grains[i].0[0];
        }
    }
    [front, quantile, top]
}

/// Results of the collapse of a column.
struct ColumnDeposit {
    /// Width and height when the gate is removed.
    size: [f64; 2],
    /// Front, 98 % quantile and height at the end; front at three times √(H₀/g).
    end: [f64; 3],
    early_front: f64,
    /// Kinetic over the first potential energy, by time over √(H₀/g).
    energy: Vec<(f64, f64)>,
    error: f64,
    first: Snapshot,
    last: Snapshot,
}

/// Runs the settling and the collapse of a column of disks.
fn collapse(aspect: f64, seed: u64) -> Result<ColumnDeposit, String> {
    let (value, width) = set_up(aspect, seed)?;
    let mut solver = disk_solver(&value)?;
    let settled = value["stages"][0]["duration"].as_f64().ok_or("no duration")?;
    while solver.time() < settled {
        let dt = solver.limit().dt;
        step(&mut solver, dt)?;
    }
    let first = solver.snapshot();
    let (masses, radii) = (scalars(&first, "mass"), scalars(&first, "radius"));
    let grains = || (0..masses.len()).filter(|&i| first.bodies[i] == 0);
    let potential: f64 = grains().map(|i| masses[i] * first.positions[i][1]).sum();
    let mut tops: Vec<f64> = grains().map(|i| first.positions[i][1] + radii[i]).collect();
    tops.sort_by(f64::total_cmp);
    let height = tops[(0.99 * tops.len() as f64) as usize];
    let start = solver.time();
    solver.begin_stage(1, start).map_err(|error| error.to_string())?;
    let unit = height.sqrt();
    let (mut energy, mut early_front) = (Vec::new(), f64::NAN);
    loop {
        advance(&mut solver, 0.02 * unit)?;
        let time = (solver.time() - start) / unit;
        let kinetic = solver.totals().kinetic / potential;
        energy.push((time, kinetic));
        if early_front.is_nan() && time >= 3.0 {
            early_front = measures(&solver.snapshot())[0];
        }
        if time > 3.0 && kinetic < 2e-5 || time > 14.0 {
            break;
        }
    }
    let last = solver.snapshot();
    let error = output_value(&solver, "energy_error");
    Ok(ColumnDeposit { size: [width, height], end: measures(&last), early_front, energy, error, first, last })
}

/// Advances a solver by the time `span` (s) with its largest stable steps.
fn advance(solver: &mut DemSolver<2, 1>, span: f64) -> Result<(), String> {
    let end = solver.time() + span;
    while solver.time() < end {
        let dt = solver.limit().dt;
        step(solver, dt)?;
    }
    Ok(())
}

/// Checks the deposits and kinetic energies of collapsing columns, as means of several packings.
fn columns(rows: &[ReferenceColumn]) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut energies = LineChart::new(
        "Kinetic energy of collapsing columns",
        "time over √(H₀/g)",
        "over potential energy at the start",
    );
    let (mut found, mut sheet) = (Vec::new(), Vec::new());
    for row in rows {
        let deposits = SEEDS.map(|seed| collapse(row.aspect, seed));
        let deposits: Vec<ColumnDeposit> = deposits.into_iter().collect::<Result<_, _>>()?;
        let figures: Vec<ColumnFigures> = deposits.iter().map(ColumnDeposit::figures).collect();
        judge(&mut outcome, row, &figures);
        found.push((row.aspect, mean(&figures, |own| own.front)));
        let deposit = deposits.into_iter().next().ok_or("no packing")?;
        sheet.push((row.aspect, row.front));
        if rows.len() == 1 || row.aspect > 3.0 && row.aspect < 5.0 {
            for (name, snapshot) in [("before", &deposit.first), ("after", &deposit.last)] {
                let mut cloud =
                    PointCloud::from_snapshot(snapshot, "pressure", [0, 1]).ok_or("no pressure")?;
                cloud.title = format!("Column of a = {}, {name}", row.aspect);
                outcome.png(
                    &format!("B13, a = {}, {name} the collapse: pressure in grains.", row.aspect),
                    &cloud,
                )?;
            }
        }
        energies.series.push(Series::new(format!("a = {}", row.aspect), deposit.energy, Style::Line));
    }
    outcome.svg("B13: all comes to rest.", &energies)?;
    if rows.len() > 1 {
        scaling(&mut outcome, &found)?;
        let mut picture = LineChart::new(
            "Run-out of columns of disks",
            "initial height over width",
            "run-out over initial width",
        );
        picture.log = true;
        let law = |a: f64| if a < 2.0 { 2.5 * a } else { 3.25 * a.powf(0.7) };
        let aspects = (0..=40).map(|k| 0.5 * 16f64.powf(f64::from(k) / 40.0));
        picture.series.push(Series::new(
            "Staron and Hinch, flat floor",
            aspects.map(|a| (a, law(a))).collect(),
            Style::Dashed,
        ));
        picture.series.push(Series::new("sheet's code", sheet, Style::Line));
        picture.series.push(Series::new("DEM", found, Style::Markers));
        outcome.svg("B13.", &picture)?;
    }
    Ok(outcome)
}

/// Figures of a column for which the sheet has values. Lengths are over the initial width.
#[derive(Clone, Copy, Debug)]
struct ColumnFigures {
    aspect: f64,
    front: f64,
    mass: f64,
    height: f64,
    /// Largest kinetic energy over the first potential energy, and its time over √(H₀/g).
    kinetic: f64,
    time_of_max_kinetic: f64,
    /// Travel of the front at 3 √(H₀/g) over that at the end.
    early_front_share: f64,
    /// Time at the end over √(H₀/g), and the remaining share of the kinetic energy.
    rest: (f64, f64),
    error: f64,
}

impl ColumnDeposit {
    /// Dimensionless figures of the collapse.
    fn figures(&self) -> ColumnFigures {
        let [width, height] = self.size;
        let [front, mass, top] = self.end;
        let (when, kinetic) =
            self.energy.iter().copied().fold((0.0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        ColumnFigures {
            aspect: height / width,
            front: front / width - 1.0,
            mass: mass / width - 1.0,
            height: top / width,
            kinetic,
            time_of_max_kinetic: when,
            early_front_share: (self.early_front - width) / (front - width),
            rest: self.energy.last().copied().unwrap_or((f64::NAN, f64::NAN)),
            error: self.error,
        }
    }
}

/// Mean of a figure over the packings.
fn mean(figures: &[ColumnFigures], of: impl Fn(&ColumnFigures) -> f64) -> f64 {
    figures.iter().map(of).sum::<f64>() / figures.len() as f64
}

/// Checks the mean figures of the packings of one aspect ratio.
fn judge(outcome: &mut BenchmarkOutcome, row: &ReferenceColumn, figures: &[ColumnFigures]) {
    let name = |what: &str| format!("B13, a = {}: {what}", row.aspect);
    let reason =
        if row.band > 0.1 { "B13: ± 15 % for a = 8" } else { "B13: ± 10 %, means of four packings" };
    let mean = |of: fn(&ColumnFigures) -> f64| mean(figures, of);
    outcome.assert_close(
        name("height over width at the start"),
        row.aspect,
        0.02,
        mean(|own| own.aspect),
        "the sheet's columns",
    );
    for (what, exact, value) in [
        ("run-out of the connected front over initial width", row.front, mean(|own| own.front)),
        ("run-out of 98 % of the mass over initial width", row.mass, mean(|own| own.mass)),
        ("final height over initial width", row.height, mean(|own| own.height)),
        ("largest kinetic energy over first potential energy", row.kinetic, mean(|own| own.kinetic)),
    ] {
        outcome.assert_close(name(what), exact, row.band, value, reason);
    }
    let kinetic: Vec<f64> = figures.iter().map(|own| own.kinetic).collect();
    outcome.info(
        name("largest kinetic energy, standard deviation of packings"),
        "",
        mean_and_deviation(&kinetic).1,
        "not judged: shows how well the mean is known",
    );
    let PackingScatter { front_time, early_front, final_rest } = row.scatter;
    for (what, spread, value) in [
        ("time of it over √(H₀/g)", front_time, mean(|own| own.time_of_max_kinetic)),
        ("front at 3 √(H₀/g) over that at the end", early_front, mean(|own| own.early_front_share)),
        ("time at rest over √(H₀/g)", final_rest, mean(|own| own.rest.0)),
    ] {
        let (ends, claim, reason) = spread.bounds_of_mean(figures.len());
        outcome.assert_within(name(what), &claim, value, ends, reason);
    }
    let largest = |of: fn(&ColumnFigures) -> f64| figures.iter().map(of).fold(0.0, f64::max);
    outcome.assert_below(
        name("kinetic energy at the end over first potential energy"),
        "at rest",
        largest(|own| own.rest.1),
        2e-5,
        "B13",
    );
    outcome.assert_below(
        name("error of the energy balance over input"),
        "0",
        largest(|own| own.error.abs()),
        0.01,
        "§2.14: 1 %",
    );
}

/// Checks the exponents of the run-out over the aspect ratio.
fn scaling(outcome: &mut BenchmarkOutcome, found: &[(f64, f64)]) -> Result<(), String> {
    let exponent = |a: (f64, f64), b: (f64, f64)| (b.1 / a.1).ln() / (b.0 / a.0).ln();
    let [first, one, two, four, eight] = found else { return Err("five columns are needed".into()) };
    let prefactor = (first.1 / first.0 + one.1 / one.0 + two.1 / two.0) / 3.0;
    outcome.assert_within(
        "B13, run-out over aspect ratio, a ≤ 2",
        "2.0",
        prefactor,
        (1.8, 2.2),
        "B13: 2.0 ± 0.2",
    );
    outcome.assert_below(
        "B13, exponent of the run-out between a = 4 and 8",
        "below 0.8",
        exponent(*four, *eight),
        0.8,
        "B13",
    );
    Ok(())
}
