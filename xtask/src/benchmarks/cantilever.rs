//! Cantilever at large deflection under a dead load at its tip (MPM sheet S-07).

use colluvium::case::plot::{LineChart, Series, Style};
use colluvium::case::{Snapshot, description::Load};

use super::{Benchmark, Outcome, case, run, set, vectors};

/// The benchmark.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/cantilever",
    title: "Cantilever at large deflection: convected domains against the elastica",
    source: "Sadeghirad et al. 2011 and others; MPM sheet S-07, elastica",
    run: benchmark,
};

/// Length and height (m), and bending stiffness (N m²) of the case.
const LENGTH: f64 = 10.0;
const HEIGHT: f64 = 1.0;
const STIFFNESS: f64 = 1e6;

fn benchmark(_quick: bool) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let mut chart = LineChart {
        title: "Deflected axis".into(),
        x_label: "along the beam at rest (m)".into(),
        y_label: "down (m)".into(),
        ..LineChart::default()
    };
    let loads = [(1.0, 0.301_721, 0.056_433), (2.0, 0.493_457, 0.160_642)];
    for (load, down, across) in loads {
        let exact = elastica(load);
        let name = format!("elastica, PL²/EI = {load}: w/L");
        outcome.near(
            name,
            down,
            1e-5,
            exact.last().map_or(f64::NAN, |p| -p.1 / LENGTH),
            "the sheet's reference, to its digits",
        );
        chart.series.push(Series::new(format!("elastica, PL²/EI = {load}"), exact, Style::Dashed));
        let mut errors = Vec::new();
        for cell in if load == 1.0 { vec![0.5, 0.25] } else { vec![0.25] } {
            let (axis, tip) = deflected(load, cell)?;
            let name = format!("PL²/EI = {load}, cells of {cell} m");
            errors.push((tip[1] / down - 1.0).abs());
            if cell == 0.25 {
                outcome.near(format!("{name}: w/L"), down, 0.03, tip[1], "the sheet: 3 %");
                outcome.show(format!("{name}: u/L"), &format!("{across}"), tip[0], "the sheet judges w/L");
                chart.series.push(Series::new(format!("CPDI, PL²/EI = {load}"), axis, Style::Line));
            }
        }
        if let [coarse, fine] = errors[..] {
            outcome.below(
                "PL²/EI = 1: error of w/L, cells halved, over that before",
                "below 1",
                fine / coarse,
                1.0,
                "the sheet: halving reduces the error",
            );
        }
    }
    outcome.svg("The axis of the beam under two loads.", &chart)?;
    Ok(outcome)
}

/// Places along a line and down from it (m).
type Line = Vec<(f64, f64)>;

/// Axis of the deflected beam (m), and shortening and deflection of its tip over the length.
fn deflected(load: f64, cell: f64) -> Result<(Line, [f64; 2]), String> {
    let mut case = case("mpm/cantilever")?;
    set(&mut case, "cell_size", cell);
    let force = load * STIFFNESS / (LENGTH * LENGTH);
    for of_case in &mut case.loads {
        if let Load::Traction { value, .. } = of_case {
            *value = vec![0.0, -force / HEIGHT];
        }
    }
    let report = run(&case)?;
    let axis = axis(&report.snapshot);
    // From the last two columns of points to the end of the beam.
    let [.., (x1, a), (x2, b)] = axis[..] else { return Err("no points".into()) };
    let tip = std::array::from_fn(|c| {
        let slope = (b[c] - a[c]) / (x2 - x1);
        -(b[c] + slope * (LENGTH - x2)) / LENGTH
    });
    Ok((axis.iter().map(|(x, u)| (x + u[0], u[1])).collect(), tip))
}

/// Mean displacement (m) of the points over each place along the beam at rest (m).
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

/// Axis (m) of `EI θ'' = -P cos θ`, `θ(0) = 0`, `θ'(L) = 0`, downwards: shooting for the curvature at the wall,
/// fourth-order Runge–Kutta.
fn elastica(load: f64) -> Vec<(f64, f64)> {
    let steps = 2000;
    let shoot = |curvature: f64| {
        let ds = 1.0 / f64::from(steps);
        let rate = |y: [f64; 4]| [y[1], -load * y[0].cos(), y[0].cos(), y[0].sin()];
        let add = |y: [f64; 4], k: [f64; 4], s: f64| -> [f64; 4] { std::array::from_fn(|i| y[i] + s * k[i]) };
        let mut y = [0.0, curvature, 0.0, 0.0];
        let mut line = vec![(0.0, 0.0)];
        for _ in 0..steps {
            let a = rate(y);
            let b = rate(add(y, a, 0.5 * ds));
            let c = rate(add(y, b, 0.5 * ds));
            let d = rate(add(y, c, ds));
            y = std::array::from_fn(|i| y[i] + ds / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
            line.push((LENGTH * y[2], -LENGTH * y[3]));
        }
        (y[1], line)
    };
    let (mut low, mut high) = (0.0, load);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if shoot(middle).0 < 0.0 { low = middle } else { high = middle }
    }
    shoot(0.5 * (low + high)).1
}
