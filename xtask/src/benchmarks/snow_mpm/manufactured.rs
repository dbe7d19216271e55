//! Manufactured solution on a periodic line: cell crossing and convergence (sheet: snow-mpm V14).

use std::f64::consts::TAU;

use colluvium::case::{Manufactured, PrescribedState, Snapshot};
use colluvium::plots::{LineChart, Series, Style};
use colluvium::snow_mpm::SnowMpm;
use serde_json::json;

use super::case_with_options;
use crate::analysis::manufactured_solution::{max_errors_over_steps, rms_position_error};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, scalars, stresses};

/// Benchmark of the manufactured solution of a periodic line: cell crossing and convergence.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/manufactured",
    title: "Manufactured solution of a periodic line: cell crossing and convergence",
    source: "sheet: snow-mpm V14",
    short_seconds: Some(4),
    full_seconds: 8,
    run: benchmark,
};

/// Modulus of uniaxial strain (Pa).
const MODULUS: f64 = 1e4;
/// Density of the line (kg/m³).
const DENSITY: f64 = 1.0;
/// Wave speed (m/s).
const SPEED: f64 = 100.0;
/// Courant number: time step times wave speed over cell size.
const COURANT: f64 = 0.1;
/// Amplitude (m) of the sheet's table.
const AMPLITUDE: f64 = 0.05;
/// Cell numbers per metre of the refinements of the table.
const CELLS: [usize; 5] = [16, 32, 64, 128, 256];

/// Standing wave `u = A sin 2πX sin 2πct`.
#[derive(Clone, Copy)]
struct StandingWave {
    amplitude: f64,
}

impl StandingWave {
    /// Displacement of the material point `x` at the time `t` (m).
    fn displacement(self, x: f64, t: f64) -> f64 {
        self.amplitude * (TAU * x).sin() * (TAU * SPEED * t).sin()
    }

    /// Velocity of the material point `x` at the time `t` (m/s).
    fn velocity(self, x: f64, t: f64) -> f64 {
        self.amplitude * (TAU * x).sin() * TAU * SPEED * (TAU * SPEED * t).cos()
    }

    /// Stretch, and its derivative along the line (1/m).
    fn stretch(self, x: f64, t: f64) -> [f64; 2] {
        let strain = self.amplitude * TAU * (TAU * SPEED * t).sin();
        [1.0 + strain * (TAU * x).cos(), -TAU * strain * (TAU * x).sin()]
    }

    /// Body force (m/s²).
    fn force(self, x: f64, t: f64) -> f64 {
        let [stretch, slope] = self.stretch(x, t);
        let stress = MODULUS / DENSITY * (1.0 - stretch.ln()) / (stretch * stretch) * slope;
        -(TAU * SPEED).powi(2) * self.displacement(x, t) - stress
    }

    /// Initial state and body force of the solution.
    fn solution(self) -> Manufactured {
        Manufactured {
            start: Box::new(move |[x, ..]| {
                let mut deformation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                deformation[0][0] = self.stretch(x, 0.0)[0];
                PrescribedState {
                    position: [x + self.displacement(x, 0.0), 0.0, 0.0],
                    velocity: [self.velocity(x, 0.0), 0.0, 0.0],
                    deformation,
                }
            }),
            force: Box::new(move |[x, ..], t| [self.force(x, t), 0.0, 0.0]),
        }
    }

    /// Root mean square error of the Kirchhoff stress (Pa).
    fn stress_error(self, snapshot: &Snapshot) -> f64 {
        let places = snapshot.positions.iter().zip(snapshot.vectors("displacement").unwrap_or(&[]));
        let (stresses, densities) = (stresses(snapshot), scalars(snapshot, "density"));
        let squares = places.zip(stresses.iter().zip(&densities)).map(|((x, u), (stress, density))| {
            let [stretch, _] = self.stretch(x[0] - u[0], snapshot.time);
            (stress.0[0] * DENSITY / density - MODULUS * stretch.ln()).powi(2)
        });
        (squares.sum::<f64>() / densities.len() as f64).sqrt()
    }

    /// Largest errors over a period, with a number of cells per metre: of the displacement over the amplitude, and of the Kirchhoff stress
    /// over `2πAM`.
    fn errors(self, functions: &TransferSetting, cells: usize) -> Result<[f64; 2], String> {
        let cell = 1.0 / cells as f64;
        let mut options = json!({
            "cell_size": cell, "points_per_cell": functions.points, "shape": functions.shape,
            "time_step": COURANT * cell / SPEED, "transfer": functions.transfer
        });
        if functions.transfer == "flip" {
            options["flip_ratio"] = json!(1);
        }
        let case = case_with_options("manufactured", &options)?;
        let mut solver =
            SnowMpm.manufactured_solver(&case, self.solution()).map_err(|error| error.to_string())?;
        let [off, stress] = max_errors_over_steps(&mut *solver, case.stages[0].duration, |snapshot| {
            let place = |[x, ..]: [f64; 3], t| [x + self.displacement(x, t), 0.0, 0.0];
            [rms_position_error(snapshot, place), self.stress_error(snapshot)]
        })?;
        Ok([off / self.amplitude, stress / (TAU * self.amplitude * MODULUS)])
    }
}

/// Shape functions, points per cell and transfer, with the errors of the sheet's prototype, if there are any.
struct TransferSetting {
    name: &'static str,
    shape: &'static str,
    points: usize,
    transfer: &'static str,
    displacement: [f64; 5],
    stress: Option<[f64; 5]>,
}

/// Settings of the sheet's table.
const TABLE: [TransferSetting; 6] = [
    TransferSetting {
        name: "linear, 4 points per cell",
        shape: "linear",
        points: 4,
        transfer: "flip",
        displacement: [9.3e-2, 8.9e-2, 1.3e-1, 2.7e-1, 4.6e-1],
        stress: None,
    },
    TransferSetting {
        name: "quadratic, 4 points per cell",
        shape: "quadratic",
        points: 4,
        transfer: "flip",
        displacement: [1.52e-1, 3.6e-2, 9.0e-3, 2.3e-3, 2.1e-3],
        stress: Some([1.6e-1, 4.2e-2, 1.4e-2, 1.2e-2, 1.4e-2]),
    },
    TransferSetting {
        name: "cubic, 4 points per cell",
        shape: "cubic",
        points: 4,
        transfer: "flip",
        displacement: [2.13e-1, 4.80e-2, 1.20e-2, 3.00e-3, 7.51e-4],
        stress: Some([2.2e-1, 5.6e-2, 1.5e-2, 3.7e-3, 1.0e-3]),
    },
    TransferSetting {
        name: "cubic, 4 points per cell, APIC",
        shape: "cubic",
        points: 4,
        transfer: "apic",
        displacement: [1.19e-1, 2.63e-2, 6.1e-3, 1.49e-3, f64::NAN],
        stress: None,
    },
    TransferSetting {
        name: "linear, 2 points per cell",
        shape: "linear",
        points: 2,
        transfer: "flip",
        displacement: [1.5e-1, 2.5e-1, 5.6e-1, 8.1e-1, 1.06],
        stress: None,
    },
    TransferSetting {
        name: "cubic, 2 points per cell",
        shape: "cubic",
        points: 2,
        transfer: "flip",
        displacement: [2.1e-1, 4.8e-2, 1.2e-2, 3.6e-3, 3.0e-3],
        stress: None,
    },
];

/// Checks errors of displacement against the sheet's table, with several shape functions and cell sizes.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart {
        log: true,
        ..LineChart::new(
            "Largest error of displacement over the amplitude",
            "cell size (m)",
            "root mean square (-)",
        )
    };
    let refinements = if quick { &CELLS[..4] } else { &CELLS[..] };
    for functions in TABLE.iter().filter(|functions| !quick || functions.points == 4) {
        let wave = StandingWave { amplitude: AMPLITUDE };
        let errors: Vec<[f64; 2]> =
            refinements.iter().map(|&cells| wave.errors(functions, cells)).collect::<Result<_, _>>()?;
        let line = refinements.iter().zip(&errors).map(|(n, [off, _])| (1.0 / *n as f64, *off)).collect();
        chart.series.push(Series::new(functions.name, line, Style::Line));
        show_errors(&mut outcome, functions, refinements, &errors);
        judge(&mut outcome, functions, &errors);
    }
    let small = StandingWave { amplitude: 5e-4 };
    for functions in &TABLE[..3] {
        let name = format!(
            "V14: {}, amplitude 0.5 mm, 32 cells, no crossing: error of displacement",
            functions.name
        );
        let [error, _] = small.errors(functions, 32)?;
        outcome.assert_below(name, "below 6e-2", error, 6e-2, "the sheet's criterion");
    }
    outcome.svg(
        "V14: cubic functions converge in second order, linear ones diverge as points cross cells.",
        &chart,
    )?;
    Ok(outcome)
}

/// Shows the errors beside those of the sheet.
fn show_errors(
    outcome: &mut BenchmarkOutcome,
    functions: &TransferSetting,
    refinements: &[usize],
    errors: &[[f64; 2]],
) {
    let reason = "the sheet judges order, divergence and what does not cross cells";
    let claim = |sheet: f64| {
        if sheet.is_nan() { "not given".to_owned() } else { format!("{sheet:.3e} (sheet's prototype)") }
    };
    for (i, (cells, [off, stress])) in refinements.iter().zip(errors).enumerate() {
        let name = |of: &str| format!("V14: {}, {cells} cells: error of {of}", functions.name);
        outcome.info(name("displacement"), &claim(functions.displacement[i]), *off, reason);
        if let Some(sheet) = functions.stress {
            outcome.info(name("stress"), &claim(sheet[i]), *stress, reason);
        }
    }
}

/// Checks the errors against the requirements of the sheet.
fn judge(outcome: &mut BenchmarkOutcome, functions: &TransferSetting, errors: &[[f64; 2]]) {
    let ratio = errors[1][0] / errors[3][0];
    let pass = "the sheet's criterion";
    match (functions.shape, functions.points, functions.transfer) {
        ("cubic", 4, "flip") => {
            let name = format!("V14: {}: order between 32 and 128 cells", functions.name);
            outcome.assert_within(name, "2.0 ± 0.15", 0.5 * ratio.log2(), (1.85, 2.15), pass);
        }
        ("linear", 4, _) => {
            let name = format!("V14: {}: error with 128 cells over that with 32", functions.name);
            outcome.assert_within(
                name,
                "above 2; 3.0 (sheet's prototype)",
                1.0 / ratio,
                (2.0, f64::INFINITY),
                pass,
            );
        }
        _ => {}
    }
}
