//! Standard plots of soil tests.

use crate::SymTensor;
use crate::driver::{ElementPath, TestTrace};

/// Standard plot of an element test: columns and labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StandardPlot {
    /// Short name, for files.
    pub name: &'static str,
    /// Column on the horizontal axis.
    pub x: &'static str,
    /// Column on the vertical axis.
    pub y: &'static str,
    /// Label of the horizontal axis.
    pub x_label: &'static str,
    /// Label of the vertical axis.
    pub y_label: &'static str,
}

impl StandardPlot {
    /// Names of the standard plots.
    pub const NAMES: [&'static str; 6] =
        ["q-strain", "volume-strain", "pore-pressure-strain", "q-p", "volume-ln-p", "void-ratio-ln-p"];
}

impl ElementPath {
    /// Returns the four standard plots: `q` and volume change over the largest compression, `q` over `p`, and volume change over `ln p`.
    /// Excess pore pressure and void ratio replace the volume change if the test has them.
    pub fn standard_plots(&self) -> [StandardPlot; 4] {
        /// Key and axis label of the largest axial compression.
        const COMPRESSION: (&str, &str) = ("axial_compression", "largest compression (-)");
        let plot = |name, x: (&'static str, &'static str), y: (&'static str, &'static str)| StandardPlot {
            name,
            x: x.0,
            y: y.0,
            x_label: x.1,
            y_label: y.1,
        };
        let q = ("q", "q (Pa)");
        let volume = ("volumetric_strain", "volumetric strain, expansion positive (-)");
        let pressure = self.column("excess_pore_pressure").unwrap_or_default();
        let undrained = pressure.iter().any(|u| *u != 0.0);
        let [q_strain, volume_strain, pore_pressure_strain, q_p, volume_ln_p, void_ratio_ln_p] =
            StandardPlot::NAMES;
        let ln_p = ("ln_p", "ln(p / Pa)");
        [
            plot(q_strain, COMPRESSION, q),
            if undrained {
                plot(pore_pressure_strain, COMPRESSION, ("excess_pore_pressure", "excess pore pressure (Pa)"))
            } else {
                plot(volume_strain, COMPRESSION, volume)
            },
            plot(q_p, ("p", "p (Pa)"), q),
            if self.column(VOID_RATIO).is_some() {
                plot(void_ratio_ln_p, ln_p, (VOID_RATIO, "void ratio (-)"))
            } else {
                plot(volume_ln_p, ln_p, volume)
            },
        ]
    }
}

/// Name of the output of laws that have a void ratio.
const VOID_RATIO: &str = "void_ratio";

/// Yield curve of a law in triaxial compression.
#[derive(Clone, Debug, PartialEq)]
pub struct YieldCurve {
    /// Label of the curve: `yield surface`, or that of the start and the end if the surface has moved.
    pub label: &'static str,
    /// Points p and q (Pa).
    pub points: Vec<(f64, f64)>,
}

/// Number of points of a yield curve.
const LINE: usize = 60;

/// Number of halvings of a bracket: to the last bit.
const BISECTIONS: usize = 60;

/// Number of doublings in the search of a stress outside the yield surface.
const DOUBLINGS: i32 = 40;

impl TestTrace {
    /// Yield curves in triaxial compression over the range of pressures of the test: one, two if the surface has moved, none for laws
    /// without a yield function.
    pub fn yield_lines(&self) -> Vec<YieldCurve> {
        let extreme = |name: &str, start: f64, pick: fn(f64, f64) -> f64| {
            let values = self.path.column(name).unwrap_or_default();
            values.into_iter().filter(|v| v.is_finite()).fold(start, pick)
        };
        let (low, high) = (extreme("p", 0.0, f64::min), extreme("p", 0.0, f64::max));
        let scale = high.max(-low).max(extreme("q", 0.0, f64::max)).max(1.0);
        let (low, high) = (low - 0.1 * scale, high.max(0.3 * scale) * 1.1);
        let line = |yields: &dyn Fn(f64, f64) -> f64| -> Vec<(f64, f64)> {
            let pressures = (0..=LINE).map(|i| low + (high - low) * i as f64 / LINE as f64);
            pressures.filter_map(|p| Some((p, strength(&|q| yields(p, q), scale)?))).collect()
        };
        let start = line(&|p, q| self.start.yield_value_at(&compression(p, q)));
        let end = line(&|p, q| self.end.yield_value_at(&compression(p, q)));
        let same = start.len() == end.len()
            && start.iter().zip(&end).all(|(a, b)| (a.1 - b.1).abs() <= 1e-3 * scale);
        let lines = if same {
            vec![YieldCurve { label: "yield surface", points: end }]
        } else {
            vec![
                YieldCurve { label: "yield surface, start", points: start },
                YieldCurve { label: "yield surface, end", points: end },
            ]
        };
        lines.into_iter().filter(|line| !line.points.is_empty()).collect()
    }
}

/// Stress of triaxial compression along z.
fn compression(p: f64, q: f64) -> SymTensor {
    let (lateral, axial) = (-p + q / 3.0, -p - 2.0 * q / 3.0);
    SymTensor::diagonal(lateral, lateral, axial)
}

/// Stress at which the yield function becomes zero, by bisection; `None` if it is positive at zero stress or never becomes zero.
fn strength(yields: &dyn Fn(f64) -> f64, scale: f64) -> Option<f64> {
    if !(yields(0.0) <= 0.0) {
        return None;
    }
    let mut outside = (0..DOUBLINGS).map(|i| scale * 2f64.powi(i)).find(|q| yields(*q) > 0.0)?;
    let mut inside = 0.0;
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (inside + outside);
        if yields(middle) > 0.0 {
            outside = middle;
        } else {
            inside = middle;
        }
    }
    Some(0.5 * (inside + outside))
}
