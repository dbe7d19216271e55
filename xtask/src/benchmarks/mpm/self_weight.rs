//! Oedometric compression under self-weight (sheet: mpm A-09).

use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, reference_curve, reference_table, run_mpm, set_mpm_option,
    stresses, vectors,
};

/// Benchmark of this module.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/self-weight",
    title: "Oedometric compression under self-weight at large strain",
    source: "Bardenhagen & Kober 2004 and others; sheet: mpm A-09, closed form",
    short_seconds: Some(12),
    full_seconds: 12,
    run: benchmark,
};

/// Height (m), unit weight (N/m³) and stiffness (Pa) of the case.
const HEIGHT: f64 = 10.0;
const WEIGHT: f64 = 800.0;
const STIFFNESS: f64 = 1e4;

fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut convergence = LineChart {
        title: "Error of stress".into(),
        x_label: "cell size (m)".into(),
        y_label: "mean error over stress at the base".into(),
        log: true,
        ..LineChart::default()
    };
    let exact = reference_curve(&reference_table("mpm/self-weight/reference.csv")?, "place", "stress")?;
    let mut profile = LineChart {
        title: "Stress over height, 32 cells".into(),
        x_label: "height in the deformed column (m)".into(),
        y_label: "vertical stress (Pa)".into(),
        series: vec![Series::new("closed form", exact, Style::Dashed)],
        ..LineChart::default()
    };
    let free = [f64::INFINITY; 3];
    let bands = [("linear", free), ("ugimp", free), ("cpgimp", [0.02, 0.01, 0.006]), ("dual-domain", free)];
    let mut errors = Vec::new();
    for (shape, bounds) in bands {
        let mut of_shape = Vec::new();
        for (cells, bound) in [16usize, 32, 64].into_iter().zip(bounds) {
            let mut case = load_case("mpm/self-weight")?;
            set_mpm_option(&mut case, "cell_size", HEIGHT / cells as f64);
            set_mpm_option(&mut case, "shape", shape);
            let report = run_mpm(&case)?;
            let snapshot = &report.snapshot;
            let displacement = vectors(snapshot, "displacement");
            let start: Vec<f64> =
                snapshot.positions.iter().zip(&displacement).map(|(x, u)| x[0] - u[0]).collect();
            let found = stresses(snapshot);
            let count = start.len() as f64;
            let error = start.iter().zip(&found).map(|(x, s)| (s[0] - stress(*x)).abs()).sum::<f64>()
                / (count * WEIGHT * HEIGHT);
            let off = start.iter().zip(&snapshot.positions).map(|(x, now)| (now[0] - place(*x)).abs());
            let off = off.max_or_nan() / HEIGHT;
            of_shape.push((HEIGHT / cells as f64, error));
            if shape == "cpgimp" {
                let name = format!("cpGIMP, {cells} cells: mean stress error");
                outcome.assert_below(
                    name,
                    "0.0120 / 0.0054 / 0.0037 (sheet's prototype)",
                    error,
                    bound,
                    "the sheet's bound",
                );
                let name = format!("cpGIMP, {cells} cells: largest error of position over height");
                outcome.assert_below(
                    name,
                    "3.3e-4 / 2.1e-4 / 5.5e-5 (sheet's prototype)",
                    off,
                    1e-3,
                    "the sheet's bound",
                );
            }
            if shape == "dual-domain" {
                let name = format!("dual domain, {cells} cells: mean stress error");
                outcome.info(name, "none in the sheet", error, "the sheet gives no bound for this shape");
            }
            if cells == 32 {
                let points = snapshot.positions.iter().zip(&found).map(|(x, s)| (x[0], s[0])).collect();
                profile.series.push(Series::new(shape, points, Style::Markers));
            }
        }
        convergence.series.push(Series::new(shape, of_shape.clone(), Style::Line));
        errors.push(of_shape);
    }
    for (level, cells) in [16, 32, 64].into_iter().enumerate() {
        let ratio = errors[0][level].1 / errors[1][level].1;
        let claim = "above 1: cell crossing spoils the standard method";
        outcome.assert_within(
            format!("{cells} cells: error of MPM over that of uGIMP"),
            claim,
            ratio,
            (1.0, f64::INFINITY),
            "the sheet's criterion",
        );
    }
    outcome.svg("Stress of the points against the closed form.", &profile)?;
    outcome.svg(
        "Refinement helps GIMP; it does not help the standard method, whose points cross cells.",
        &convergence,
    )?;
    Ok(outcome)
}

/// Stress (Pa) of the material initially at `x`.
fn stress(x: f64) -> f64 {
    -WEIGHT * (HEIGHT - x)
}

/// Final position of the material initially at `x` (m).
fn place(x: f64) -> f64 {
    let load = |height: f64| (-WEIGHT * height / STIFFNESS).exp();
    STIFFNESS / WEIGHT * (load(HEIGHT - x) - load(HEIGHT))
}
