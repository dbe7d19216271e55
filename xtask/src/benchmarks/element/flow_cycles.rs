//! Cyclic shear of dense granular flow (sheet: constitutive §5.3).

use colluvium::constitutive::{Mat3, SymTensor};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::analysis::MaxOrNan;
use crate::benchmarks::BenchmarkOutcome;
use crate::benchmarks::element::flow_laws::sand;

/// Constant pressure of the shear test (Pa).
const PRESSURE: f64 = 1000.0;
/// Shear rate (1/s).
const RATE: f64 = 100.0;
/// Amplitude of the shear strain.
const AMPLITUDE: f64 = 0.05;
/// Shear modulus (Pa).
const SHEAR_MODULUS: f64 = 2e6;
/// Number of steps of a quarter of a cycle.
const QUARTER_CYCLE_STEPS: usize = 5000;

/// Number of steps after a reversal in which the rate-dependent excess over the static friction relaxes.
const RELAXATION_STEPS: usize = 4;

/// Stress–strain curve of three cycles of shear.
#[derive(Default)]
struct ShearCycles {
    /// Work of each cycle (J/m³).
    work: Vec<f64>,
    /// Strain and shear stress (Pa) of the third cycle.
    third_cycle: Vec<(f64, f64)>,
    /// Slopes of the first steps after the reversal of the third cycle (Pa).
    reversal: Vec<f64>,
}

impl ShearCycles {
    /// Shears the law at constant rate and pressure.
    fn run() -> Result<Self, String> {
        let law = sand(&json!({ "kind": "elasto-viscoplastic" }))?;
        let mut walker = law.start(SymTensor::isotropic(-PRESSURE))?;
        let dt = AMPLITUDE / RATE / QUARTER_CYCLE_STEPS as f64;
        let (mut strain, mut cycles) = (0.0, Self::default());
        for cycle in 0..3 {
            let mut done = 0.0;
            for step in 0..4 * QUARTER_CYCLE_STEPS {
                let sign =
                    if (QUARTER_CYCLE_STEPS..3 * QUARTER_CYCLE_STEPS).contains(&step) { -1.0 } else { 1.0 };
                let rate = 0.5 * sign * RATE;
                let before = law.shear(&walker);
                law.step(&mut walker, &Mat3([[0.0, rate, 0.0], [rate, 0.0, 0.0], [0.0; 3]]), dt)?;
                let after = law.shear(&walker);
                strain += sign * RATE * dt;
                done += 0.5 * (before + after) * sign * RATE * dt;
                if cycle == 2 && step >= QUARTER_CYCLE_STEPS + RELAXATION_STEPS && cycles.reversal.len() < 8 {
                    cycles.reversal.push((after - before) / (-RATE * dt));
                }
                if cycle == 2 && step % 50 == 49 {
                    cycles.third_cycle.push((strain, after));
                }
            }
            cycles.work.push(done);
        }
        Ok(cycles)
    }
}

/// Checks the loop of cyclic shear at constant rate and pressure: a parallelogram between `±μ(I) p` with the elastic slope. Its area `4 τ
/// (γ_a - τ/G)` is dissipated in every cycle.
pub fn cyclic_shear(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let ShearCycles { work, third_cycle, reversal } = ShearCycles::run()?;
    let friction = 0.439_590_075_2 * PRESSURE;
    let elastic = reversal.iter().map(|g| (g / SHEAR_MODULUS - 1.0).abs()).max_or_nan();
    let name = "§5.3 μ(I), cyclic shear: slope after a reversal over G, less 1";
    let small = "below the static friction the answer is elastic, to round-off of the stress";
    outcome.assert_close(name, 0.0, 1e-9, elastic, small);
    let corner = "between the static friction and that of the flow lies a strain of 10⁻⁴";
    let area = 4.0 * friction * (AMPLITUDE - friction / SHEAR_MODULUS);
    outcome.assert_close("§5.3 μ(I), cyclic shear: work of a cycle (J/m³)", area, 1e-3, work[2], corner);
    let closed = (work[2] / work[1] - 1.0).abs();
    let name = "§5.3 μ(I), cyclic shear: change of work from cycle to cycle";
    outcome.assert_close(name, 0.0, 1e-9, closed, "periodic");
    let flowing = third_cycle.iter().map(|(_, tau)| tau.abs()).max_or_nan();
    let name = "§5.3 μ(I), cyclic shear: largest shear stress (Pa)";
    outcome.assert_close(name, friction, 1e-6, flowing, "steady flow between reversals");
    let chart = LineChart {
        series: vec![
            Series::new("μ(I), third cycle", third_cycle, Style::Line),
            Series::new("±μ(I) p", vec![(-AMPLITUDE, friction), (AMPLITUDE, friction)], Style::Markers),
            Series::new("", vec![(-AMPLITUDE, -friction), (AMPLITUDE, -friction)], Style::Markers),
        ],
        ..LineChart::new("Cyclic shear of dense granular flow", "shear strain", "shear stress (Pa)")
    };
    let caption = "Shear to and fro: elastic after each reversal, then flow with the friction of its rate.";
    outcome.svg(caption, &chart)
}
