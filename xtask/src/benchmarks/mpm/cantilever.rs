//! Cantilever at large deflection under a dead load at its tip, or under its weight (sheet: mpm S-07).

use colluvium::case::{Case, Snapshot, description::Load};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_mpm, set_mpm_option, vectors};

/// Benchmark of a cantilever at large deflection against the elastica.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/cantilever",
    title: "Cantilever at large deflection: convected domains against the elastica",
    source: "Sadeghirad et al. 2011 and others; sheet: mpm S-07, elastica",
    short_seconds: None,
    full_seconds: 340,
    run: benchmark,
};

/// Length of the beam (m).
const LENGTH: f64 = 10.0;
/// Height of the beam (m).
const HEIGHT: f64 = 1.0;
/// Bending stiffness (N m²).
const STIFFNESS: f64 = 1e6;
/// Mass over length (kg/m).
const MASS: f64 = 1000.0;

/// Cell size of the case (m).
const CELL: f64 = 0.25;

/// Load that bends the beam.
#[derive(Clone, Copy)]
enum CantileverLoad {
    /// Load `PL²/EI` at the tip.
    Tip(f64),
    /// Weight `qL³/EI`.
    Weight(f64),
}

impl CantileverLoad {
    /// Dimensionless load as text.
    fn name(self) -> String {
        match self {
            Self::Tip(load) => format!("PL²/EI = {load}"),
            Self::Weight(load) => format!("qL³/EI = {load}"),
        }
    }

    /// Load (EI/L²) on the part of the beam beyond a position (L).
    fn load_beyond(self, place: f64) -> f64 {
        match self {
            Self::Tip(load) => load,
            Self::Weight(load) => load * (1.0 - place),
        }
    }
}

/// Checks deflections of a cantilever against the elastica.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart::new("Deflected axis", "along the beam at rest (m)", "down (m)");
    for (bending, down, across) in [
        (CantileverLoad::Tip(0.25), 0.082_746, 0.004_118),
        (CantileverLoad::Tip(0.5), 0.162_144, 0.015_919),
        (CantileverLoad::Tip(1.0), 0.301_721, 0.056_433),
        (CantileverLoad::Tip(2.0), 0.493_457, 0.160_642),
        (CantileverLoad::Weight(1.0), 0.123_471, 0.008_754),
        (CantileverLoad::Weight(2.0), 0.238_507, 0.033_107),
    ] {
        let load = bending.name();
        let exact = elastica(bending);
        outcome.assert_close(
            format!("elastica, {load}: w/L"),
            down,
            1e-5,
            exact.last().map_or(f64::NAN, |p| -p.1 / LENGTH),
            "the sheet's reference, to its digits",
        );
        chart.series.push(Series::new(format!("elastica, {load}"), exact, Style::Dashed));
        let (axis, tip) = deflected_axis(bending, CELL)?;
        outcome.assert_close(format!("{load}, cells of {CELL} m: w/L"), down, 0.03, tip[1], "the sheet: 3 %");
        let name = format!("{load}, cells of {CELL} m: u/L");
        outcome.info(name, &format!("{across}"), tip[0], "the sheet judges w/L");
        chart.series.push(Series::new(format!("CPDI, {load}"), axis, Style::Line));
        if matches!(bending, CantileverLoad::Tip(1.0)) {
            let (_, coarse) = deflected_axis(bending, 2.0 * CELL)?;
            let error = |tip: [f64; 2]| (tip[1] / down - 1.0).abs();
            outcome.assert_below(
                format!("{load}: error of w/L, cells halved, over that before"),
                "below 1",
                error(tip) / error(coarse),
                1.0,
                "the sheet: halving reduces the error",
            );
        }
    }
    outcome.svg("The axis of the beam under loads at its tip and under its weight.", &chart)?;
    Ok(outcome)
}

/// Positions along a line and downward deflections (m).
type DeflectionLine = Vec<(f64, f64)>;

/// Case with its load. The points of the last column of cells carry the load at the tip; each of their three layers is a body whose
/// outermost points it forms.
fn loaded_case(bending: CantileverLoad, cell: f64) -> Result<Case, String> {
    let mut case = load_case("mpm/cantilever")?;
    set_mpm_option(&mut case, "cell_size", cell);
    let edge = |body: usize| if body == 0 { 0.0 } else { LENGTH - cell * (4 - body) as f64 / 3.0 };
    for (number, body) in case.bodies.iter_mut().enumerate() {
        let shape = json!({ "kind": "box", "min": [edge(number), 0.0], "max": [edge(number + 1), HEIGHT] });
        body.shape = serde_json::from_value(shape).map_err(|error| error.to_string())?;
    }
    match bending {
        CantileverLoad::Tip(load) => {
            let force = load * STIFFNESS / (LENGTH * LENGTH);
            for of_case in &mut case.loads {
                if let Load::Traction { value, .. } = of_case {
                    *value = vec![0.0, -force / (3.0 * HEIGHT)];
                }
            }
        }
        CantileverLoad::Weight(load) => {
            case.loads.clear();
            case.gravity = vec![0.0, -load * STIFFNESS / (MASS * LENGTH.powi(3))];
        }
    }
    Ok(case)
}

/// Axis of the deflected beam (m), with the shortening and deflection of its tip over the length.
fn deflected_axis(bending: CantileverLoad, cell: f64) -> Result<(DeflectionLine, [f64; 2]), String> {
    let report = run_mpm(&loaded_case(bending, cell)?)?;
    let axis = axis(&report.snapshot);
    // From the last two columns of points to the end of the beam.
    let [.., (x1, a), (x2, b)] = axis[..] else { return Err("no points".into()) };
    let tip = std::array::from_fn(|c| {
        let slope = (b[c] - a[c]) / (x2 - x1);
        -(b[c] + slope * (LENGTH - x2)) / LENGTH
    });
    Ok((axis.iter().map(|(x, u)| (x + u[0], u[1])).collect(), tip))
}

/// Mean displacement (m) of the points at each initial position along the beam (m).
fn axis(snapshot: &Snapshot) -> Vec<(f64, [f64; 2])> {
    let displacement = vectors(snapshot, "displacement");
    let mut columns: std::collections::BTreeMap<i64, (f64, [f64; 2], f64)> =
        std::collections::BTreeMap::new();
    for (x, u) in snapshot.positions.iter().zip(&displacement) {
        let start = x[0] - u[0];
        let column = columns.entry((start * 1e6).round() as i64).or_insert((start, [0.0; 2], 0.0));
        column.1[0] += u[0];
        column.1[1] += u[1];
        column.2 += 1.0;
    }
    columns.into_values().map(|(x, sum, count)| (x, sum.map(|c| c / count))).collect()
}

/// Axis of the elastica (m): `EI θ'' = -P cos θ`, or `-q (L - s) cos θ`, with `θ(0) = 0`, `θ'(L) = 0`, downwards. It is solved by shooting
/// for the curvature at the wall, with the fourth-order Runge–Kutta method.
fn elastica(bending: CantileverLoad) -> Vec<(f64, f64)> {
    let steps = 2000;
    let shoot = |curvature: f64| {
        let ds = 1.0 / f64::from(steps);
        let rate = |s: f64, y: [f64; 4]| [y[1], -bending.load_beyond(s) * y[0].cos(), y[0].cos(), y[0].sin()];
        let add = |y: [f64; 4], k: [f64; 4], s: f64| -> [f64; 4] { std::array::from_fn(|i| y[i] + s * k[i]) };
        let mut y = [0.0, curvature, 0.0, 0.0];
        let mut line = vec![(0.0, 0.0)];
        for step in 0..steps {
            let s = f64::from(step) * ds;
            let a = rate(s, y);
            let b = rate(s + 0.5 * ds, add(y, a, 0.5 * ds));
            let c = rate(s + 0.5 * ds, add(y, b, 0.5 * ds));
            let d = rate(s + ds, add(y, c, ds));
            y = std::array::from_fn(|i| y[i] + ds / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
            line.push((LENGTH * y[2], -LENGTH * y[3]));
        }
        (y[1], line)
    };
    let (mut low, mut high) = (0.0, bending.load_beyond(0.0));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if shoot(middle).0 < 0.0 { low = middle } else { high = middle }
    }
    shoot(0.5 * (low + high)).1
}
