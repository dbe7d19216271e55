//! Manufactured solutions (sheet: mpm ): the acceptance tests of GIMP, and of convected domains and the
//! total-Lagrangian form.

use std::f64::consts::PI;

use colluvium::case::{Case, Manufactured, PrescribedState};
use colluvium::mpm::Mpm;
use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::manufactured_solution::{max_errors_over_steps, rms_position_error};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, set_mpm_option};

/// Benchmark of the order of convergence for an axis-aligned manufactured solution.
pub const AXIS_ALIGNED: Benchmark = Benchmark {
    id: "mpm/axis-aligned",
    title: "Axis-aligned manufactured solution: order of GIMP",
    source: "Wallstedt & Guilkey 2008; sheet: mpm A-10",
    short_seconds: Some(15),
    full_seconds: 78,
    run: axis_aligned,
};

/// Benchmark of the manufactured solution of a generalised vortex.
pub const VORTEX: Benchmark = Benchmark {
    id: "mpm/vortex",
    title: "Generalised vortex: shear without bound on any axis-aligned domain",
    source: "Brannon, Kamojjala & Sadeghirad 2011; sheet: mpm A-11",
    short_seconds: Some(45),
    full_seconds: 60,
    run: vortex,
};

/// Density of the material of both problems (kg/m³).
const DENSITY: f64 = 1000.0;
/// Poisson's ratio of both problems.
const POISSON: f64 = 0.3;

/// Lamé's first constant and the shear modulus.
fn lame(young: f64) -> (f64, f64) {
    (young * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)), young / (2.0 * (1.0 + POISSON)))
}

/// Largest root mean square distance of the points from their exact positions over the steps (m).
fn largest_error(
    case: &Case,
    solution: Manufactured,
    exact: impl Fn([f64; 3], f64) -> [f64; 3],
) -> Result<f64, String> {
    let mut solver = Mpm.manufactured_solver(case, solution).map_err(|error| error.to_string())?;
    let end = case.stages[0].duration;
    let [largest] =
        max_errors_over_steps(&mut *solver, end, |snapshot| [rms_position_error(snapshot, &exact)])?;
    Ok(largest)
}

/// Solution `u_a = A sin 2πX_a sin(cπt + φ_a)`.
#[derive(Clone, Copy)]
struct WaveSolution {
    amplitude: f64,
}

impl WaveSolution {
    /// Young's modulus (Pa).
    const YOUNG: f64 = 1e4;
    /// Phases of the waves along x and y (radians).
    const PHASES: [f64; 2] = [0.0, 2.0 * PI / 3.0];

    /// Wave speed (m/s).
    fn speed() -> f64 {
        (Self::YOUNG / DENSITY).sqrt()
    }

    /// Displacement, velocity and stretch along axis `a`.
    fn axis_motion(self, a: usize, x: [f64; 3], t: f64) -> [f64; 3] {
        let (space, phase) = (2.0 * PI * x[a], Self::speed() * PI * t + Self::PHASES[a]);
        let u = self.amplitude * space.sin() * phase.sin();
        let v = self.amplitude * space.sin() * phase.cos() * Self::speed() * PI;
        [u, v, 1.0 + 2.0 * PI * self.amplitude * space.cos() * phase.sin()]
    }

    /// Current position of a point (m).
    fn current_position(self, x: [f64; 3], t: f64) -> [f64; 3] {
        [x[0] + self.axis_motion(0, x, t)[0], x[1] + self.axis_motion(1, x, t)[0], 0.0]
    }

    /// Cauchy stress along x.
    fn stress(self, x: [f64; 3], t: f64) -> f64 {
        let (lambda, mu) = lame(Self::YOUNG);
        let [a, b] = [self.axis_motion(0, x, t)[2], self.axis_motion(1, x, t)[2]];
        (lambda * (a * b).ln() + mu * (a * a - 1.0)) / (a * b)
    }

    /// Body force that the solution requires (m/s²).
    fn force(self, x: [f64; 3], t: f64) -> [f64; 3] {
        let (lambda, mu) = lame(Self::YOUNG);
        let along = [self.axis_motion(0, x, t), self.axis_motion(1, x, t)];
        let log = (along[0][2] * along[1][2]).ln();
        let of = |[u, _, f]: [f64; 3]| {
            let stiff = 4.0 * mu / DENSITY - Self::speed().powi(2);
            PI * PI * u * (stiff - 4.0 * (lambda * (log - 1.0) - mu) / (DENSITY * f * f))
        };
        [of(along[0]), of(along[1]), 0.0]
    }

    /// Initial state and body force of the solution.
    fn solution(self) -> Manufactured {
        Manufactured {
            start: Box::new(move |x| {
                let [a, b] = [self.axis_motion(0, x, 0.0), self.axis_motion(1, x, 0.0)];
                let deformation = [[a[2], 0.0, 0.0], [0.0, b[2], 0.0], [0.0, 0.0, 1.0]];
                PrescribedState {
                    position: self.current_position(x, 0.0),
                    velocity: [a[1], b[1], 0.0],
                    deformation,
                }
            }),
            force: Box::new(move |x, t| self.force(x, t)),
        }
    }

    /// Largest error of position with shape functions on a number of cells across (m).
    fn error(self, shape: &str, cells: usize) -> Result<f64, String> {
        let mut case = load_case("mpm/axis-aligned")?;
        set_mpm_option(&mut case, "shape", shape);
        set_mpm_option(&mut case, "cell_size", 1.0 / cells as f64);
        case.stages[0].duration = 2.0 / Self::speed();
        largest_error(&case, self.solution(), |x, t| self.current_position(x, t))
    }
}

/// Kind of shape functions, with the bounds of its errors.
struct ShapeRow {
    shape: &'static str,
    name: &'static str,
    /// Whether the errors are judged by those of the sheet's prototype.
    is_judged: bool,
    /// Whether the order of convergence is judged.
    has_order: bool,
}

/// Kinds of shape functions of the axis-aligned problem.
const SHAPES: [ShapeRow; 5] = [
    ShapeRow { shape: "cpgimp", name: "cpGIMP", is_judged: true, has_order: true },
    ShapeRow { shape: "cpdi", name: "CPDI", is_judged: false, has_order: true },
    ShapeRow { shape: "ugimp", name: "uGIMP", is_judged: false, has_order: false },
    ShapeRow { shape: "dual-domain", name: "dual domain MPM", is_judged: false, has_order: false },
    ShapeRow { shape: "linear", name: "linear MPM", is_judged: false, has_order: false },
];

/// Errors of the sheet's prototype with cpGIMP on 8, 16, 32 and 64 cells (m).
const PROTOTYPE: [f64; 4] = [5.6e-3, 1.15e-3, 2.6e-4, 9.0e-5];

/// Checks convergence for axis-aligned waves.
fn axis_aligned(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let waves = WaveSolution { amplitude: 0.05 };
    wave_samples(&mut outcome, &waves);
    let mut chart = LineChart {
        log: true,
        ..LineChart::new("Largest error of position", "cell size (m)", "root mean square (m)")
    };
    let refinement: &[usize] = if quick { &[8, 16, 32] } else { &[8, 16, 32, 64] };
    for row in &SHAPES {
        let errors =
            refinement.iter().map(|&n| waves.error(row.shape, n)).collect::<Result<Vec<f64>, _>>()?;
        let points = refinement.iter().zip(&errors).map(|(n, e)| (1.0 / *n as f64, *e)).collect();
        chart.series.push(Series::new(row.name, points, Style::Line));
        refinement_errors(&mut outcome, row, refinement, &errors);
    }
    let small = WaveSolution { amplitude: 1e-4 };
    for shape in ["cpgimp", "ugimp", "linear", "cpdi"] {
        let order = (small.error(shape, 8)? / small.error(shape, 32)?).log2() / 2.0;
        let name = format!("{shape}, amplitude 10⁻⁴, no crossing: order over 8 to 32 cells");
        outcome.assert_above(name, "1.9 (sheet's prototype)", order, 1.6, "the sheet: at least 1.6");
    }
    outcome.svg("The axis-aligned solution: generalised interpolation with stretching domains converges, domains of fixed size stall, points without domains diverge.", &chart)?;
    Ok(outcome)
}

/// Checks the solution against the sheet's samples.
fn wave_samples(outcome: &mut BenchmarkOutcome, waves: &WaveSolution) {
    for (x, t, exact) in [
        ([0.1, 0.2, 0.0], 0.05, [0.014_005_534_5, 1.121_120_74, 1.050_781_504, 4.558_258_755, 1_641.255_248]),
        (
            [0.3, 0.7, 0.0],
            0.13,
            [0.045_710_091_64, 0.906_681_446_4, 1.023_481_468, 24.483_046_97, -1_202.208],
        ),
        ([0.25, 0.4, 0.0], 0.2, [0.045_733_181_89, 1.0, 1.205_207_151, 17.846_571_02, 893.485_700_7]),
    ] {
        let [[u, _, fx], [_, _, fy]] = [waves.axis_motion(0, x, t), waves.axis_motion(1, x, t)];
        let found = [u, fx, fy, waves.force(x, t)[0], waves.stress(x, t)];
        for (name, (exact, found)) in
            ["u_x", "F_xx", "F_yy", "b_x", "σ_xx"].iter().zip(exact.into_iter().zip(found))
        {
            let name = format!("solution at ({}, {}), t = {t}: {name}", x[0], x[1]);
            outcome.assert_close(name, exact, 1e-8, found, "the sheet's samples, to their digits");
        }
    }
}

/// Checks the errors of a kind of shape functions under refinement.
fn refinement_errors(outcome: &mut BenchmarkOutcome, row: &ShapeRow, refinement: &[usize], errors: &[f64]) {
    let name = row.name;
    for ((cells, error), bound) in refinement.iter().zip(errors).zip(PROTOTYPE) {
        let title = format!("{name}, {cells} cells: largest error of position (m)");
        if row.is_judged {
            let claim = format!("{bound:.3e} (sheet's prototype)");
            outcome.assert_below(title, &claim, *error, 1.3 * bound, "the sheet: 1.3 times its errors");
        } else {
            let claim = "sheet: uGIMP stalls, MPM diverges; none for CPDI and dual domains";
            outcome.info(title, claim, *error, "the sheet gives no bound");
        }
    }
    if row.has_order {
        let (title, order) =
            (format!("{name}: order over 8 to 32 cells"), (errors[0] / errors[2]).log2() / 2.0);
        outcome.assert_above(title, "2.2 (sheet's prototype)", order, 1.8, "the sheet: at least 1.8");
    }
    if row.shape == "linear" {
        let title = "linear MPM: error of 32 cells over that of 8";
        let reason = "cell crossing: refining makes linear MPM worse (P-01)";
        outcome.assert_above(title, "1.98 (sheet's prototype)", errors[2] / errors[0], 1.0, reason);
    }
}

/// Solution of a ring that rotates by `α(R, t)`.
#[derive(Clone, Copy)]
struct VortexSolution {
    strength: f64,
}

impl VortexSolution {
    /// Young's modulus (Pa).
    const YOUNG: f64 = 1000.0;

    /// Profile of the rotation over the radius, with its first and second derivative.
    fn profile(radius: f64) -> [f64; 3] {
        let s = radius - 1.0;
        [1.0 - 32.0 * s * s + 256.0 * s.powi(4), -64.0 * s + 1024.0 * s.powi(3), -64.0 + 3072.0 * s * s]
    }

    /// Rotation at a radius and a time (radians).
    fn angle(self, radius: f64, t: f64) -> f64 {
        self.strength * (PI * t).sin() * Self::profile(radius)[0]
    }

    /// Current position of a point (m).
    fn current_position(self, x: [f64; 3], t: f64) -> [f64; 3] {
        let (s, c) = self.angle(x[0].hypot(x[1]), t).sin_cos();
        [c * x[0] - s * x[1], s * x[0] + c * x[1], 0.0]
    }

    /// Radial and tangential body force (N/kg).
    fn polar_force(self, radius: f64, t: f64) -> [f64; 2] {
        let (_, mu) = lame(Self::YOUNG);
        let [value, slope, bend] = Self::profile(radius).map(|p| self.strength * p);
        let (s, c) = (PI * t).sin_cos();
        let rate = PI * c * value;
        let radial = mu / DENSITY * radius * (s * slope).powi(2) - radius * rate * rate;
        let tangential = -PI * PI * s * radius * value - mu / DENSITY * s * (3.0 * slope + radius * bend);
        [radial, tangential]
    }

    /// Initial state and body force of the solution.
    fn solution(self) -> Manufactured {
        Manufactured {
            start: Box::new(move |x| {
                let rate = self.strength * PI * Self::profile(x[0].hypot(x[1]))[0];
                let deformation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                PrescribedState { position: x, velocity: [-rate * x[1], rate * x[0], 0.0], deformation }
            }),
            force: Box::new(move |x, t| {
                let radius = x[0].hypot(x[1]);
                let [radial, tangential] = self.polar_force(radius, t);
                let (s, c) = (x[1].atan2(x[0]) + self.angle(radius, t)).sin_cos();
                [radial * c - tangential * s, radial * s + tangential * c, 0.0]
            }),
        }
    }

    /// Largest error of position with shape functions and a formulation on a number of cells across (m).
    fn error(self, shape: &str, formulation: &str, cells: usize) -> Result<f64, String> {
        let mut case = load_case("mpm/vortex")?;
        set_mpm_option(&mut case, "shape", shape);
        set_mpm_option(&mut case, "formulation", formulation);
        set_mpm_option(&mut case, "cell_size", 3.0 / cells as f64);
        largest_error(&case, self.solution(), |x, t| self.current_position(x, t))
    }
}

/// Checks convergence for a vortex with large rotations.
fn vortex(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let full = VortexSolution { strength: 1.0 };
    vortex_samples(&mut outcome, &full);
    let weak = VortexSolution { strength: 0.1 };
    let cells: &[usize] = if quick { &[30, 60] } else { &[30, 60, 120] };
    for (cells, prototype) in cells.iter().zip([2.1e-2, 3.3e-3, 1.9e-3]) {
        let name = format!("cpGIMP, G = 0.1, {cells} cells: largest error of position (m)");
        let claim = format!("{prototype:.2e} (sheet's prototype)");
        let error = weak.error("cpgimp", UPDATED_LAGRANGIAN, *cells)?;
        outcome.assert_below(name, &claim, error, 1.3 * prototype, "the sheet: 1.3 times its errors");
    }
    let mut chart = LineChart {
        log: true,
        ..LineChart::new("Largest error of position, G = 1", "cell size (m)", "root mean square (m)")
    };
    let forms = [
        ("cpdi", UPDATED_LAGRANGIAN, "CPDI"),
        ("cpdi2", UPDATED_LAGRANGIAN, "CPDI2"),
        ("linear", TOTAL, "total-Lagrangian, linear"),
        ("quadratic", TOTAL, "total-Lagrangian, quadratic"),
    ];
    for (shape, formulation, name) in forms {
        let mut points = Vec::new();
        for cells in [60usize, 120] {
            let error = full.error(shape, formulation, cells)?;
            points.push((3.0 / cells as f64, error));
            let title = format!("{name}, G = 1, {cells} cells: largest error of position (m)");
            full_vortex_error(&mut outcome, title, formulation, cells, error);
        }
        chart.series.push(Series::new(name, points, Style::Line));
    }
    outcome.svg("The vortex at full strength: shear of 5 and turns by a radian.", &chart)?;
    Ok(outcome)
}

/// Name of the updated-Lagrangian formulation.
const UPDATED_LAGRANGIAN: &str = "updated-lagrangian";
/// Name of the total-Lagrangian formulation.
const TOTAL: &str = "total-lagrangian";

/// Checks the solution against the sheet's samples.
fn vortex_samples(outcome: &mut BenchmarkOutcome, full: &VortexSolution) {
    for (radius, t, [angle, radial, tangential]) in [
        (0.8, 0.25, [0.091_641_038_84, 3.200_408_957, -17.293_800_16]),
        (1.0, 0.5, [1.0, 0.0, 14.745_780_21]),
        (1.1, 0.25, [0.498_934_544_8, 3.411_166_264, 8.925_585_998]),
        (1.2, 0.75, [0.091_641_038_84, 4.800_613_435, -16.541_619_34]),
    ] {
        let force = full.polar_force(radius, t);
        let rows =
            [("α", angle, full.angle(radius, t)), ("b_r", radial, force[0]), ("b_θ", tangential, force[1])];
        let rows = rows
            .map(|(name, exact, found)| (format!("solution at R = {radius}, t = {t}: {name}"), exact, found));
        outcome.assert_all_close(rows, 1e-8, "the sheet's samples, to their digits");
    }
}

/// Checks the error at full strength (m). The sheet has a bound for the total-Lagrangian form on 120 cells.
fn full_vortex_error(
    outcome: &mut BenchmarkOutcome,
    title: String,
    formulation: &str,
    cells: usize,
    error: f64,
) {
    if formulation == UPDATED_LAGRANGIAN {
        let reason = "the sheet requires one of both, and the total-Lagrangian form is judged; convected domains \
                      shear until their corners lie more than two cells from the point, and the run stops";
        outcome.info(title, "5e-2 by this or by total-Lagrangian MPM", error, reason);
    } else if cells == 120 {
        let claim = "total-Lagrangian 3.6e-2, with quadratic splines 1.9e-2 at 120 (sheet's prototype)";
        outcome.assert_below(title, claim, error, 5e-2, "the sheet's bound");
    } else {
        let reason = "the sheet gives no bound at 60 cells";
        outcome.info(title, "8.2e-2, 4.6e-2 at 60 (sheet's prototype)", error, reason);
    }
}
