//! Scalars on moving nodes of a line: convection, diffusion, decay, Burgers' equation (sheet: depth-sph §5.1, V1 to V3, V4a to V4c).

use std::f64::consts::{PI, TAU};

use colluvium::depth_sph::scalar_transport::ScalarNodes;
use colluvium::plots::{LineChart, Series, Style};

use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of convection, diffusion and Burgers' equation on moving nodes.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/scalar",
    title: "Convection, diffusion and Burgers' equation on moving nodes",
    source: "Pastor and others 2020, §2.1 and §2.2; sheet: depth-sph §5.1, V1 to V3, V4a to V4c",
    short_seconds: Some(1),
    full_seconds: 1,
    run,
};

/// Checks convection, diffusion, and solutions of Burgers' equation with rarefaction, steepening and shock.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    convection(&mut outcome);
    diffusion(&mut outcome);
    rarefaction(&mut outcome);
    steepening(&mut outcome);
    shock(&mut outcome);
    triangle(&mut outcome)?;
    Ok(outcome)
}

/// Centres of `count` equal cells from `low` to `high` (m).
fn cells(count: u32, low: f64, high: f64) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| low + (high - low) * (f64::from(k) + 0.5) / f64::from(count))
}

/// Gaussian curve with a standard deviation of 0.1.
fn gauss(x: f64) -> f64 {
    (-0.5 * (x / 0.1).powi(2)).exp()
}

/// Largest difference of the values at the nodes from a formula.
fn max_difference(line: &ScalarNodes, exact: impl Fn(f64) -> f64) -> f64 {
    line.positions.iter().zip(&line.values).map(|(x, value)| (value - exact(*x)).abs()).fold(0.0, f64::max)
}

/// Mean difference from a formula between two positions, over the length (m).
fn mean_difference(line: &ScalarNodes, [low, high]: [f64; 2], exact: impl Fn(f64) -> f64) -> f64 {
    let count = 2000;
    cells(count, low, high).map(|x| (line.value_at(x) - exact(x)).abs()).sum::<f64>() / f64::from(count)
}

/// Checks that convection is exact, for the profiles of V1 and V2b.
fn convection(outcome: &mut BenchmarkOutcome) {
    let pulse = |x: f64| if (0.3..0.5).contains(&x) { 1.0 } else { 0.0 };
    let reason = "V1: 1e-12";
    for (name, form) in
        [("a: Gaussian", &(|x: f64| gauss(x - 0.5)) as &dyn Fn(f64) -> f64), ("b: pulse", &pulse)]
    {
        let mut line = ScalarNodes::new(cells(200, 0.0, 2.0), form);
        let mut decaying = line.clone();
        for _ in 0..100 {
            line.advect(1.0, 0.01);
            decaying.advect(1.0, 0.01);
            decaying.diffuse(0.02, 0.01, 0.0, 0.1, 0.01);
        }
        outcome.assert_below(
            format!("V1{name}: largest error after 1 s"),
            "0",
            max_difference(&line, |x| form(x - 1.0)),
            1e-12,
            reason,
        );
        let found = max_difference(&decaying, |x| (-0.1f64).exp() * form(x - 1.0));
        outcome.assert_below(
            format!("V2b, {name}: largest error after 1 s of decay"),
            "0",
            found,
            1e-6,
            "V2b: 1e-6",
        );
    }
    let inflow = |t: f64| (TAU * t).sin();
    let mut line = ScalarNodes::new(cells(200, 0.0, 2.0), |_| 0.0);
    // One node at the corner where the inflow joins the initial state.
    line.insert_node(0.0, inflow(0.0));
    for step in 1..=100 {
        line.advect(1.0, 0.01);
        line.insert_node(0.0, inflow(0.01 * f64::from(step)));
    }
    let exact = |x: f64| if x < 1.0 { inflow(1.0 - x) } else { 0.0 };
    let found = cells(1000, 0.005, 1.995).map(|x| (line.value_at(x) - exact(x)).abs()).fold(0.0, f64::max);
    outcome.assert_below("V1c: largest error of what has flowed in after 1 s", "0", found, 1e-3, "V1: 1e-3");
}

/// Checks the diffusion of a Gaussian profile: its peak, its value at ± 0.2, and the order of convergence (V2).
fn diffusion(outcome: &mut BenchmarkOutcome) {
    let (speed, diffusivity, sink, start) = (1.0, 0.01, 0.1, 0.5);
    let exact = |x: f64, t: f64| {
        let square = 0.01 + 2.0 * diffusivity * t;
        let from = x - start - speed * t;
        (-sink * t).exp() * (0.01 / square).sqrt() * (-0.5 * from * from / square).exp()
    };
    let at_time = |count: u32, end: f64| {
        let spacing = 4.0 / f64::from(count);
        let length = 2.0 * spacing;
        let steps = (end / (0.1 * length * length / diffusivity)).ceil().max(10.0);
        let mut line = ScalarNodes::new(cells(count, -1.0, 3.0), |x| gauss(x - start));
        for _ in 0..steps as u32 {
            line.advect(speed, end / steps);
            line.diffuse(length, spacing, diffusivity, sink, end / steps);
        }
        line
    };
    for (time, printed, beside) in [(0.5, 0.672_621, 0.247_443), (1.0, 0.522_408, 0.268_213)] {
        let line = at_time(400, time);
        let peak = line.value_at(start + time);
        outcome.assert_close(format!("V2: peak after {time} s"), printed, 0.01, peak, "V2: 1 %");
        let found = 0.5 * (line.value_at(start + time - 0.2) + line.value_at(start + time + 0.2));
        outcome.assert_close(
            format!("V2: value 0.2 m beside it after {time} s"),
            beside,
            0.01,
            found,
            "V2: 1 %, as of the peak",
        );
    }
    let [coarse, fine] = [100, 200].map(|count| max_difference(&at_time(count, 1.0), |x| exact(x, 1.0)));
    let claim = "at least 1.8";
    outcome.assert_within(
        "V2: order of the error in the spacing",
        claim,
        (coarse / fine).log2(),
        (1.8, 4.5),
        "V2: at least 1.8",
    );
}

/// Checks a rarefaction of Burgers' equation (V3).
fn rarefaction(outcome: &mut BenchmarkOutcome) {
    let mut line = ScalarNodes::new(cells(200, -1.0, 1.0), |x| if x < 0.0 { 0.0 } else { 1.0 });
    line.steepen(0.5);
    let found = mean_difference(&line, [-0.5, 1.0], |x| (x / 0.5).clamp(0.0, 1.0));
    outcome.assert_below("V3: mean error of a rarefaction after 0.5 s", "0", found, 0.01, "V3: L1 below 1 %");
}

/// Checks the steepening of a wave of Burgers' equation until just before it breaks (V4a).
fn steepening(outcome: &mut BenchmarkOutcome) {
    let rows = [
        (0.2, [0.192_196, 0.470_453, 0.858_130, 0.986_306, 0.671_284]),
        (0.3, [0.161_366, 0.398_470, 0.756_446, 0.989_226, 0.927_868]),
    ];
    for (time, printed) in rows {
        let mut line = ScalarNodes::new(cells(16_000, 0.0, 2.0), |x| (PI * x).sin());
        line.steepen(time);
        let apart = |(x, exact): (f64, f64)| (line.value_at(x) - exact).abs();
        let found = [0.1, 0.25, 0.5, 0.75, 0.9].into_iter().zip(printed).map(apart).fold(0.0, f64::max);
        outcome.assert_below(
            format!("V4a: largest error of the sine after {time} s"),
            "0",
            found,
            1e-6,
            "V4a: 1e-6",
        );
    }
}

/// Checks a shock of Burgers' equation without viscosity, in which nodes that collide merge (V4b).
fn shock(outcome: &mut BenchmarkOutcome) {
    let mut line = ScalarNodes::new(cells(400, -2.0, 2.0), |x| if x < 0.0 { 1.0 } else { 0.0 });
    let front = |line: &ScalarNodes| {
        let k = line.values.partition_point(|value| *value > 0.5);
        let share = (line.values[k - 1] - 0.5) / (line.values[k - 1] - line.values[k]);
        line.positions[k - 1] + share * (line.positions[k] - line.positions[k - 1])
    };
    line.steepen(0.2);
    let before = front(&line);
    line.steepen(0.8);
    outcome.assert_close("V4b: speed of a shock (m/s)", 0.5, 0.01, (front(&line) - before) / 0.8, "V4b: 1 %");
    let found = mean_difference(&line, [-0.9, 1.9], |x| if x < 0.5 { 1.0 } else { 0.0 });
    outcome.assert_below("V4b: mean error behind and before it after 1 s", "0", found, 0.02, "V4b: L1 2 %");
}

/// Checks a triangular pulse of Burgers' equation whose rarefaction reaches its shock (V4c). Values are between 0 and 1 at its edge: nodes
/// a billionth of a metre wide.
fn triangle(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let count = 200;
    let ramp = (0..count).map(|k| 1e-9 * (f64::from(k) / f64::from(count) - 1.0));
    let places =
        std::iter::once(-1.0).chain(ramp).chain(cells(count, 0.0, 1.0)).chain(cells(3 * count, 1.0, 4.0));
    let form = |x: f64| if x < 0.0 { (1.0 + 1e9 * x).max(0.0) } else { f64::from(u8::from(x < 1.0)) };
    let mut line = ScalarNodes::new(places, form);
    let before = line.area();
    let mut chart =
        LineChart::new("Burgers' equation: a pulse becomes a triangle", "place (m)", "value (m/s)");
    for time in 1..=4 {
        line.steepen(1.0);
        let time = f64::from(time);
        let (end, height) =
            if time < 2.0 { (1.0 + 0.5 * time, 1.0) } else { ((2.0 * time).sqrt(), (2.0 / time).sqrt()) };
        let flat = if time < 2.0 { vec![(time, 1.0)] } else { Vec::new() };
        let exact = [vec![(0.0, 0.0)], flat, vec![(end, height), (end, 0.0), (4.0, 0.0)]].concat();
        chart.series.push(Series::new(format!("closed form, {time} s"), exact, Style::Dashed));
        let shown =
            line.positions.iter().zip(&line.values).step_by(10).map(|(x, value)| (*x, *value)).collect();
        chart.series.push(Series::new(format!("nodes, {time} s"), shown, Style::Markers));
    }
    outcome.assert_close("V4c: area under the pulse after 4 s (m²/s)", 1.0, 1e-3, line.area(), "V4c: 1e-3");
    outcome.assert_close("V4c: area after 4 s over the first", 1.0, 1e-3, line.area() / before, "V4c: 1e-3");
    let top = line.values.iter().copied().fold(0.0, f64::max);
    let k = line.values.iter().position(|value| *value == top).unwrap_or_default();
    let after = line.values[k..].partition_point(|value| *value > 0.5 * top) + k;
    let share = (line.values[after - 1] - 0.5 * top) / (line.values[after - 1] - line.values[after]);
    let place = line.positions[after - 1] + share * (line.positions[after] - line.positions[after - 1]);
    outcome.assert_close("V4c: place of the shock after 4 s (m)", 2.828_427, 0.02, place, "V4c: 2 %");
    outcome.assert_close(
        "V4c: height of the triangle after 4 s (m/s)",
        std::f64::consts::FRAC_1_SQRT_2,
        0.02,
        top,
        "V4c: 2 %, as of the place",
    );
    outcome.svg("V4c: nodes that meet become one with the value that keeps the area.", &chart)
}
