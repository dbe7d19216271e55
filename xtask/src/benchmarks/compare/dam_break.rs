//! Collapse of a water column on a dry floor (sheet: mpm A-25) by MPM, SPH and depth-integrated flow.

use colluvium::plots::{LineChart, Series, Style};

use super::MethodComparison;
use crate::analysis::{max_or_nan, regression_slope};
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, measure_series, reference_curve, reference_table, run_in_memory,
    set_method_option,
};

/// Benchmark of a dam break on a dry bed, computed by MPM, SPH and depth-integrated flow.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "compare/dam-break",
    title: "Dam break on a dry bed: MPM, SPH and depth-integrated flow",
    source: "Martin & Moyce 1952, Koshizuka & Oka 1996; Ritter 1892",
    short_seconds: Some(20),
    full_seconds: 40,
    run: benchmark,
};

/// Width of the column `a` (m), from which the unit of time √(a / 2g) follows.
const WIDTH: f64 = 0.146;

/// Points of a curve of the front position: dimensionless time and position.
type FrontCurve = Vec<(f64, f64)>;

/// Checks the front speed of three methods against the experiments of a surge on a dry bed.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut case = load_case("compare/dam-break")?;
    if quick {
        set_method_option(&mut case, "mpm", "cell_size", 0.0146);
        set_method_option(&mut case, "sph", "spacing", WIDTH / 30.0);
    }
    let unit = (WIDTH / (2.0 * 9.81)).sqrt();
    let between = |points: &[(f64, f64)]| -> FrontCurve {
        points.iter().copied().filter(|(_, z)| *z > 1.5 && *z < 3.0).collect()
    };
    let mut picture = LineChart::new("Front of a surge on a dry bed", "t √(2g/a)", "x / a");
    let (mut fronts, mut together) = (Vec::<FrontCurve>::new(), MethodComparison::default());
    for method in ["mpm", "sph", "depth-sph"] {
        let report = run_in_memory(method, &case)?;
        let front: FrontCurve =
            measure_series(&report, "front").iter().map(|(t, x)| (t / unit, x / WIDTH)).collect();
        outcome.assert_close(
            format!("{method}: mass at the end over that at the start"),
            1.0,
            1e-12,
            report.end.mass / report.start.mass,
            "exact",
        );
        together.add_run(method, &report);
        picture.series.push(Series::new(method, front.clone(), Style::Line));
        fronts.push(front);
    }
    let table = reference_table("mpm/dam-break/front.csv")?;
    let mut slopes = Vec::new();
    for (name, column) in [("Martin & Moyce", "martin-moyce"), ("Koshizuka & Oka", "koshizuka-oka")] {
        let measured = reference_curve(&table, "time", column)?;
        slopes.push(regression_slope(&between(&measured)));
        picture.series.push(Series::new(name, measured, Style::Markers));
    }
    let (smallest, largest) = (slopes[0].min(slopes[1]), slopes[0].max(slopes[1]));
    let claim = format!("{smallest:.2} and {largest:.2} in the experiments");
    for (method, front) in ["mpm", "sph"].into_iter().zip(&fronts) {
        outcome.assert_within(
            format!("{method}: speed of the front, dZ/dT for 1.5 < Z < 3"),
            &claim,
            regression_slope(&between(front)),
            (0.85 * smallest, 1.15 * largest),
            "between the two experiments, which differ by a third, and 15 % beyond (sheet: mpm A-25)",
        );
    }
    judge_agreement(&mut outcome, &fronts);
    let exact = (1..=40).map(|k| 0.05 * f64::from(k)).map(|t| (t, quantile(t)));
    picture.series.push(Series::new("Ritter, 99.9 %", exact.collect(), Style::Dashed));
    outcome.svg("Fronts of 99.9 % of the mass. Depth-integrated flow leaves at once at the speed of Ritter: it knows no time \
                 in which water must be set falling.", &picture)?;
    together.write_sections(&mut outcome, &case, "compare/dam-break")?;
    Ok(outcome)
}

/// Position of the 99.9 % quantile of the water in the solution of Ritter (1892), over the width of the column. The volume beyond `a + u t`
/// is `t (2 c - u)³ / (27 g)`.
fn quantile(time: f64) -> f64 {
    // In units of a and √(a / 2g): c² = g H with H = 2 a is 1, g is 1/2, and the column has 2.
    1.0 + time * (2.0 - (27.0 * 0.5 * 0.001 * 2.0 / time).cbrt())
}

/// Checks that the front speeds of the methods agree.
fn judge_agreement(outcome: &mut BenchmarkOutcome, fronts: &[FrontCurve]) {
    let [mpm, sph, flow] = fronts else { return };
    let apart = mpm.iter().zip(sph).map(|(a, b)| (a.1 / b.1 - 1.0).abs()).fold(0.0, max_or_nan);
    outcome.assert_below(
        "mpm against sph: largest difference of the front over its place",
        "the same flow",
        apart,
        0.1,
        "ten per cent: both resolve the same equations on points as far apart",
    );
    let inner = flow.iter().filter(|(_, z)| *z > 1.5 && *z < 3.0);
    outcome.assert_below(
        "depth-sph: largest difference of the front from that of 99.9 % of Ritter's water, over its place",
        "closed form of shallow water",
        inner.map(|(t, z)| (z / quantile(*t) - 1.0).abs()).fold(0.0, max_or_nan),
        0.05,
        "5 %: the tip is as thin as nodes are coarse",
    );
    for (name, front) in [("mpm", mpm), ("sph", sph)] {
        let lead = front
            .iter()
            .filter(|(t, _)| *t > 0.0)
            .map(|(t, z)| z - 1.0 - 2.0 * t)
            .fold(f64::NEG_INFINITY, max_or_nan);
        outcome.assert_below(
            format!("{name}: largest lead of the front over Ritter's, over the width of the column"),
            "none: x/a - 1 = 2 T is a bound",
            lead,
            0.0,
            "never above",
        );
    }
}
