//! Consolidation of the pore-pressure column (sheet: depth-sph §5.4).

use std::f64::consts::PI;

use colluvium::case::Case;
use colluvium::depth_sph::laws::pore_pressure_column::{
    BaseCondition, diffuse_head, limit_head, load_undrained, mean, relax_amplitude, set_linear_profile,
};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::analysis::MaxOrNan;
use crate::benchmarks::depth_sph::common_cases::{load as load_case, start, step_until};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, scalars, set_method_option};

/// Benchmark of the consolidation of a pore-pressure column.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/column",
    title: "Consolidation of the pore-pressure column",
    source: "Terzaghi's series; sheet: depth-sph §5.4, V13a, V14",
    short_seconds: Some(2),
    full_seconds: 2,
    run,
};

/// Checks excess pore pressures of a column against the series solutions of consolidation.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    series(&mut outcome)?;
    check_drained_rack(&mut outcome)?;
    check_undrained(&mut outcome);
    thinning(&mut outcome);
    layer(&mut outcome)?;
    Ok(outcome)
}

/// Initial pore pressure of a column, and condition at its base.
#[derive(Clone, Copy, PartialEq)]
enum ConsolidationKind {
    /// Uniform excess pressure above a sealed base.
    UniformSealed,
    /// Excess pressure that increases linearly with depth, above a sealed base.
    TriangleSealed,
    /// Excess pressure that increases linearly with depth, above a drained base.
    TriangleDrained,
}

impl ConsolidationKind {
    /// Row of the sheet, with initial profile and drainage.
    fn name(self) -> &'static str {
        match self {
            Self::UniformSealed => "V13a uniform, sealed",
            Self::TriangleSealed => "V13b triangular, sealed",
            Self::TriangleDrained => "V13c triangular, drained",
        }
    }

    /// Condition of the excess pressure at the base.
    fn base_condition(self) -> BaseCondition {
        if self == Self::TriangleDrained { BaseCondition::Head(0.0) } else { BaseCondition::Sealed }
    }

    /// Excess pressure at the start, over that at the base, at a relative height `zeta`.
    fn start(self, zeta: f64) -> f64 {
        if self == Self::UniformSealed { 1.0 } else { 1.0 - zeta }
    }

    /// Excess pressure by Terzaghi's series at the relative height `zeta` and the time factor `t`, over that at the base at the start.
    fn exact(self, zeta: f64, t: f64) -> f64 {
        let half = |k: i32| f64::from(2 * k + 1) * PI / 2.0;
        let term = |k: i32| match self {
            Self::UniformSealed => {
                let l = half(k);
                2.0 * (-1f64).powi(k) / l * (l * zeta).cos() * (-l * l * t).exp()
            }
            Self::TriangleSealed => {
                let l = half(k);
                2.0 / (l * l) * (l * zeta).cos() * (-l * l * t).exp()
            }
            Self::TriangleDrained => {
                let l = f64::from(k + 1) * PI;
                2.0 / l * (l * zeta).sin() * (-l * l * t).exp()
            }
        };
        (0..300).map(term).sum()
    }

    /// Largest error at the nodes for time factors of 0.05 and more, and profiles at some time factors.
    fn run(self, cells: usize, weight: f64, step: f64) -> (f64, Vec<(f64, Vec<f64>)>) {
        let zeta = |k: usize| k as f64 / cells as f64;
        let mut head: Vec<f64> = (0..=cells).map(|k| self.start(zeta(k))).collect();
        let mut scratch = head.clone();
        let (mut worst, mut kept) = (0.0f64, Vec::new());
        let per = (0.05 / step).round() as usize;
        for number in 1..=10 * per {
            diffuse_head(&mut head, step, weight, self.base_condition(), &mut scratch);
            if number % per == 0 {
                let time = number as f64 * step;
                let errors = head.iter().enumerate().map(|(k, p)| (p - self.exact(zeta(k), time)).abs());
                worst = worst.max(errors.max_or_nan());
                if [1, 2, 4, 10].contains(&(number / per)) {
                    kept.push((time, head.clone()));
                }
            }
        }
        (worst, kept)
    }
}

/// Checks the excess pressures of columns with three initial profiles and drainages (V13a to V13c).
fn series(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for kind in [
        ConsolidationKind::UniformSealed,
        ConsolidationKind::TriangleSealed,
        ConsolidationKind::TriangleDrained,
    ] {
        let name = |what: &str| format!("{}: {what}", kind.name());
        // The jump of a uniform pressure at the surface makes Crank–Nicolson oscillate: its first steps are shorter.
        let rows = [(20, 0.5, 1e-3, 1e-3), (20, 1.0, 1e-3, 3.5e-3), (40, 0.5, 1e-3, 2.5e-4)];
        for (cells, weight, step, bound) in rows {
            let found = kind.run(cells, weight, step).0;
            let scheme = if weight == 1.0 { "backward Euler" } else { "Crank–Nicolson" };
            let what = format!("{cells} intervals, {scheme}: largest error over the first pressure");
            let reason = "V13: 0.1 % and 0.025 % with Crank–Nicolson, 0.35 % with backward Euler";
            outcome.assert_below(name(&what), "0", found, bound, reason);
        }
        // A weight of one and steps proportional to the square of the cell: no oscillation, only the error in depth.
        let [coarse, fine] = [10, 20].map(|cells| kind.run(cells, 1.0, 0.5 / (cells * cells) as f64 / 8.0).0);
        let order = (coarse / fine).log2();
        outcome.assert_within(
            name("order in the interval"),
            "2",
            order,
            (1.8, 2.2),
            "V13: second order in depth",
        );
    }
    let kind = ConsolidationKind::TriangleSealed;
    let [long, short] = [1e-3, 5e-4].map(|step| kind.run(160, 1.0, step).0);
    outcome.assert_within(
        "V13b: order in the step, backward Euler",
        "1",
        (long / short).log2(),
        (0.85, 1.15),
        "V13: first order in time",
    );
    draw(outcome)
}

/// Draws profiles of excess pressure beside those of the closed form.
fn draw(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for kind in [ConsolidationKind::TriangleSealed, ConsolidationKind::TriangleDrained] {
        let mut chart = LineChart {
            title: kind.name().to_owned(),
            x_label: "excess pressure over the first one at the base".to_owned(),
            y_label: "height over depth".to_owned(),
            ..LineChart::default()
        };
        for (time, head) in kind.run(20, 0.5, 1e-3).1 {
            let zeta = |k: usize| k as f64 / 20.0;
            let exact = (0..=100).map(|k| (kind.exact(f64::from(k) / 100.0, time), f64::from(k) / 100.0));
            chart.series.push(Series::new(String::new(), exact.collect(), Style::Dashed));
            let found = head.iter().enumerate().map(|(k, p)| (*p, zeta(k))).collect();
            chart.series.push(Series::new(format!("T = {time:.2}"), found, Style::Markers));
        }
        outcome.svg("V13: heads of 20 intervals, and the series (broken).", &chart)?;
    }
    Ok(())
}

/// Checks the pressure of a column that passes over a drained rack (V13d).
fn check_drained_rack(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let table = [
        (0.05, [0.747_695, 0.484_632, 0.450_022]),
        (0.06, [0.0, 0.476_617, 0.357_542]),
        (0.07, [0.0, 0.459_297, 0.315_878]),
        (0.075, [0.190_228, 0.445_440, 0.310_965]),
        (0.08, [0.247_729, 0.429_486, 0.306_079]),
        (0.1, [0.331_802, 0.368_323, 0.287_016]),
        (0.15, [0.351_891, 0.286_198, 0.246_196]),
        (0.2, [0.325_922, 0.242_470, 0.214_684]),
        (0.3, [0.260_374, 0.185_411, 0.166_538]),
    ];
    let (cells, step) = (40, 1e-4);
    let mut head = vec![0.0; cells + 1];
    set_linear_profile(&mut head, 1.0);
    let (mut scratch, mut shape) = (head.clone(), head.clone());
    let (mut worst, mut left) = (0.0f64, 0.0f64);
    let mut base = Vec::new();
    for number in 1..=3000 {
        let time = f64::from(number) * step;
        let open = (501..=700).contains(&number);
        let below = if open { BaseCondition::Head(0.0) } else { BaseCondition::Sealed };
        diffuse_head(&mut head, step, 1.0, below, &mut scratch);
        relax_amplitude(&mut shape, step, below);
        base.push((time, head[0]));
        if let Some((_, exact)) = table.iter().find(|(at, _)| (at - time).abs() < 0.1 * step) {
            let found = [head[0], head[cells / 2], mean(&head)];
            worst = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(worst, f64::max);
        }
        if number > 500 {
            left = left.max(shape[0].abs()).max(mean(&shape).abs());
        }
    }
    outcome.assert_below(
        "V13d: largest difference of base, middle and mean from the reference",
        "0",
        worst,
        0.01,
        "V13d: 1 % of the first pressure",
    );
    outcome.assert_below(
        "V13d, shape function: pressure left behind the rack",
        "0",
        left,
        1e-15,
        "V13d: nothing",
    );
    let mut chart = LineChart::new(
        "Base of a column that crosses a rack",
        "time factor",
        "excess pressure over the first one",
    );
    let reference = table.iter().map(|(t, exact)| (*t, exact[0])).collect();
    chart.series.push(Series::new("base", base, Style::Line));
    chart.series.push(Series::new("reference", reference, Style::Markers));
    outcome.svg("V13d: drained from 0.05 to 0.07; the pressure comes back from above.", &chart)
}

/// Checks that excess pressures change with the depth where they cannot drain (V14).
fn check_undrained(outcome: &mut BenchmarkOutcome) {
    let mut head = vec![0.0; 21];
    set_linear_profile(&mut head, 2.0);
    let (mut depth, mut worst) = (2.0, 0.0f64);
    for growth in [-0.5, 0.7, -1.9, 4.0, -3.0] {
        load_undrained(&mut head, growth);
        depth += growth;
        limit_head(&mut head, depth, |_| 0.0);
        worst = worst.max((head[0] / depth - 1.0).abs());
    }
    outcome.assert_below("V14: change of the liquefaction ratio of 1", "0", worst, 1e-12, "V14: 1e-12");
    set_linear_profile(&mut head, 0.3);
    load_undrained(&mut head, 1.25);
    outcome.assert_close("V14: head at the base after growth (m)", 1.55, 1e-12, head[0], "V14: 1e-12");
}

/// Checks a column that becomes thinner while it drains (V14b).
fn thinning(outcome: &mut BenchmarkOutcome) {
    let run = |steps: usize| {
        let mut head = vec![0.0; 81];
        let mut scratch = head.clone();
        set_linear_profile(&mut head, 2.0);
        let (dt, depth) = (5.0 / steps as f64, |t: f64| 2.0 * (-t / 5.0f64).exp());
        let mut found = Vec::new();
        for number in 0..steps {
            let t = number as f64 * dt;
            load_undrained(&mut head, depth(t + dt) - depth(t));
            diffuse_head(
                &mut head,
                0.5 * dt / depth(t + 0.5 * dt).powi(2),
                1.0,
                BaseCondition::Sealed,
                &mut scratch,
            );
            if [1, 2, 5].iter().any(|second| number + 1 == second * steps / 5) {
                found.extend([head[0], mean(&head)]);
            }
        }
        found
    };
    let exact = [0.866_05, 0.553_88, 0.310_10, 0.201_52, -0.068_06, -0.042_70];
    let error = |found: Vec<f64>| found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // By extrapolation of a first-order scheme.
    let [long, short] = [run(500), run(1000)];
    let beyond = long.iter().zip(&short).map(|(a, b)| 2.0 * b - a).collect();
    let (coarse, fine) = (error(long), error(short));
    let reason = "V14b: first order of backward Euler";
    outcome.assert_within("V14b: order in the step", "1", (coarse / fine).log2(), (0.8, 1.2), reason);
    let reason =
        "V14b: heads at 1, 2 and 5 s; the digits that the sheet gives, over the two intervals of V13";
    outcome.assert_below(
        "V14b: largest error (m), extrapolated in the step",
        "0",
        error(beyond),
        2.5e-4,
        reason,
    );
}

/// Checks excess pressures in a case: a layer at rest between walls (V13b and V13c).
fn layer(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let sealed = load_case("column")?;
    for (base, drainage, exact) in [("sealed", "sealed", 0.747_687), ("drained", "hydrostatic", 0.0)] {
        let mut case: Case = sealed.clone();
        set_method_option(&mut case, "depth-sph", "drainage", json!({ "kind": drainage }));
        let mut solver = start(&case)?;
        // The depth of the nodes is that of their SPH sums, and so is the time factor.
        let depth = scalars(&solver.snapshot(), "depth")[10];
        let time = 0.05 * depth * depth / 0.5;
        step_until(&mut *solver, time)?;
        let found = scalars(&solver.snapshot(), "liquefaction")[10];
        let reason = "V13: 0.35 % of the first pressure with backward Euler";
        let name = format!("layer at rest, base {base}: liquefaction ratio at T = 0.05");
        outcome.assert_within(name, &format!("{exact}"), found, (exact - 3.5e-3, exact + 3.5e-3), reason);
    }
    Ok(())
}
