//! Oedometric compression under self-weight (sheet: mpm A-09).

use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, reference_curve, reference_table, run_mpm, set_mpm_option,
    stresses, vectors,
};

/// Benchmark of oedometric compression under self-weight at large strain.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/self-weight",
    title: "Oedometric compression under self-weight at large strain",
    source: "Bardenhagen & Kober 2004 and others; sheet: mpm A-09, closed form",
    short_seconds: Some(12),
    full_seconds: 12,
    run: benchmark,
};

/// Height of the column (m).
const HEIGHT: f64 = 10.0;
/// Unit weight (N/m³).
const WEIGHT: f64 = 800.0;
/// Stiffness of the column in vertical compression (Pa).
const STIFFNESS: f64 = 1e4;

/// Errors of a column under its weight against the closed form.
struct ColumnErrors {
    /// Mean error of stress, over the stress at the base.
    stress: f64,
    /// Largest error of position, over the height.
    max_position_error: f64,
    /// Stress (Pa) over height (m) of the points.
    profile: Vec<(f64, f64)>,
}

impl ColumnErrors {
    /// Runs the column on a number of cells.
    fn from_run(shape: &str, cells: usize) -> Result<Self, String> {
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
        let off = start.iter().zip(&snapshot.positions).map(|(x, now)| (now[0] - final_position(*x)).abs());
        let off = off.max_or_nan() / HEIGHT;
        let profile = snapshot.positions.iter().zip(&found).map(|(x, s)| (x[0], s[0])).collect();
        Ok(Self { stress: error, max_position_error: off, profile })
    }

    /// Adds the checks of the sheet. `bound` is that of the error of stress.
    fn check(&self, outcome: &mut BenchmarkOutcome, shape: &str, cells: usize, bound: f64) {
        if shape == "cpgimp" {
            let name = format!("cpGIMP, {cells} cells: mean stress error");
            let claim = "0.0120 / 0.0054 / 0.0037 (sheet's prototype)";
            outcome.assert_below(name, claim, self.stress, bound, "the sheet's bound");
            let name = format!("cpGIMP, {cells} cells: largest error of position over height");
            let claim = "3.3e-4 / 2.1e-4 / 5.5e-5 (sheet's prototype)";
            outcome.assert_below(name, claim, self.max_position_error, 1e-3, "the sheet's bound");
        }
        if shape == "dual-domain" {
            let name = format!("dual domain, {cells} cells: mean stress error");
            let reason = "the sheet gives no bound for this shape";
            outcome.info(name, "none in the sheet", self.stress, reason);
        }
    }
}

/// Checks the stress of a column under its weight at several cell sizes.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut convergence = LineChart {
        log: true,
        ..LineChart::new("Error of stress", "cell size (m)", "mean error over stress at the base")
    };
    let exact = reference_curve(&reference_table("mpm/self-weight/reference.csv")?, "place", "stress")?;
    let mut profile = LineChart {
        series: vec![Series::new("closed form", exact, Style::Dashed)],
        ..LineChart::new(
            "Stress over height, 32 cells",
            "height in the deformed column (m)",
            "vertical stress (Pa)",
        )
    };
    let free = [f64::INFINITY; 3];
    let bands = [("linear", free), ("ugimp", free), ("cpgimp", [0.02, 0.01, 0.006]), ("dual-domain", free)];
    let mut errors = Vec::new();
    for (shape, bounds) in bands {
        let mut of_shape = Vec::new();
        for (cells, bound) in [16usize, 32, 64].into_iter().zip(bounds) {
            let found = ColumnErrors::from_run(shape, cells)?;
            of_shape.push((HEIGHT / cells as f64, found.stress));
            found.check(&mut outcome, shape, cells, bound);
            if cells == 32 {
                profile.series.push(Series::new(shape, found.profile, Style::Markers));
            }
        }
        convergence.series.push(Series::new(shape, of_shape.clone(), Style::Line));
        errors.push(of_shape);
    }
    for (level, cells) in [16, 32, 64].into_iter().enumerate() {
        let ratio = errors[0][level].1 / errors[1][level].1;
        let name = format!("{cells} cells: error of MPM over that of uGIMP");
        let claim = "above 1: cell crossing spoils the standard method";
        outcome.assert_above(name, claim, ratio, 1.0, "the sheet's criterion");
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
fn final_position(x: f64) -> f64 {
    let load = |height: f64| (-WEIGHT * height / STIFFNESS).exp();
    STIFFNESS / WEIGHT * (load(HEIGHT - x) - load(HEIGHT))
}
