//! Excess pore pressure along the depth of a column (sheet: depth-sph §2.7, §3.6).
//!
//! The unknown is the head `ψ = Δp/(ρ' g_*)` (m) at `ζ_k = k/N` from the base (`k` = 0) to the surface (`k` = N). The mesh
//! strains with the column, so that `ζ` is material. `ψ = h` at the base is full liquefaction.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Largest number of intervals of a column, which bounds the size of arrays on the stack.
pub const MAX_CELLS: usize = 1000;

/// Drainage of the base.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Drainage {
    /// Impermeable base.
    #[default]
    Sealed,
    /// Hydrostatic base pressure: all excess pressure drains.
    Hydrostatic,
    /// Atmospheric base pressure: all pressure drains, as over a drainage rack.
    Atmospheric,
    /// Flow in proportion to the excess pressure, `k_w ∂p/∂x₃ = χ Δp`.
    Partly {
        /// Hydraulic conductance `χ ρ_w g` (1/s), positive: flow (m/s) per metre of head.
        conductance: f64,
    },
}

/// Pressure discretisation over the depth of a column.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PressureProfile {
    /// Finite differences.
    #[default]
    FiniteDifference,
    /// Quarter-cosine amplitude. A drained base permanently removes all pressure.
    ShapeFunction,
}

/// Lower bound of the pore pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum LowerBound {
    /// Total pressure at least minus the fluid's tensile strength.
    Total {
        /// Tensile strength of the fluid (Pa), non-negative; up to 1e5.
        #[serde(default)]
        cavitation: f64,
    },
    /// Excess pressure at least zero.
    NoSuction,
}

impl Default for LowerBound {
    fn default() -> Self {
        Self::Total { cavitation: 0.0 }
    }
}

/// Boundary condition of the difference scheme at the base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BaseCondition {
    /// No flow.
    Sealed,
    /// Prescribed head (m).
    Head(f64),
    /// `∂ψ/∂ζ = B ψ`.
    Partly(f64),
}

/// Advances the consolidation equation `∂ψ/∂T = ∂²ψ/∂ζ²` by the time factor `step = c_v Δt/h²` with the θ-scheme. A `weight` of 1 is
/// backward Euler, ½ Crank–Nicolson. `scratch` is as long as the column.
pub fn diffuse_head(head: &mut [f64], step: f64, weight: f64, base: BaseCondition, scratch: &mut [f64]) {
    let last = head.len() - 1;
    let r = step * (last * last) as f64;
    let (implicit, explicit) = (weight * r, (1.0 - weight) * r);
    let width = 1.0 / last as f64;
    // The row of the base: ψ₋₁ = ψ₁ - 2 Δζ B ψ₀.
    let leak = if let BaseCondition::Partly(leak) = base { 2.0 * width * leak } else { 0.0 };
    head[last] = 0.0;
    let mut below = head[0];
    if let BaseCondition::Head(value) = base {
        head[0] = value;
        scratch[0] = 0.0;
        below = value;
    } else {
        let right = head[0] + explicit * (2.0 * head[1] - (2.0 + leak) * head[0]);
        let pivot = 1.0 + implicit * (2.0 + leak);
        head[0] = right / pivot;
        scratch[0] = -2.0 * implicit / pivot;
    }
    for k in 1..last {
        let own = head[k];
        let right = own + explicit * (below - 2.0 * own + head[k + 1]);
        let pivot = 1.0 / (1.0 + implicit * (2.0 + scratch[k - 1]));
        head[k] = (right + implicit * head[k - 1]) * pivot;
        scratch[k] = -implicit * pivot;
        below = own;
    }
    for k in (0..last).rev() {
        head[k] -= scratch[k] * head[k + 1];
    }
}

/// Advances the amplitude of the shape function `ψ_b cos(πζ/2)` over the time factor `step` = `c_v Δt / h²`.
pub fn relax_amplitude(head: &mut [f64], step: f64, base: BaseCondition) {
    use std::f64::consts::FRAC_PI_2;
    let amplitude = match base {
        BaseCondition::Head(_) => 0.0,
        BaseCondition::Sealed | BaseCondition::Partly(_) => head[0] * (-FRAC_PI_2 * FRAC_PI_2 * step).exp(),
    };
    let last = (head.len() - 1) as f64;
    for (k, value) in head.iter_mut().enumerate() {
        *value = amplitude * (FRAC_PI_2 * k as f64 / last).cos();
    }
    if let Some(top) = head.last_mut() {
        *top = 0.0;
    }
}

/// Adds undrained loading: the column grows by `growth` (m).
pub fn load_undrained(head: &mut [f64], growth: f64) {
    let last = (head.len() - 1) as f64;
    for (k, value) in head.iter_mut().enumerate() {
        *value += growth * (1.0 - k as f64 / last);
    }
}

/// Limits the column of depth `depth` (m) between liquefaction and `lowest(1 - ζ)` (m); returns whether a value was changed.
pub fn limit_head(head: &mut [f64], depth: f64, lowest: impl Fn(f64) -> f64) -> bool {
    let last = (head.len() - 1) as f64;
    let mut changed = false;
    for (k, value) in head.iter_mut().enumerate() {
        let rest = 1.0 - k as f64 / last;
        let held = value.min(depth * rest).max(lowest(rest));
        // Round-off of a liquefied column does not count as a limit.
        changed |= (held - *value).abs() > 1e-9 * depth;
        *value = held;
    }
    changed
}

/// Mean over the depth, by the trapezoid rule (m).
pub fn mean(head: &[f64]) -> f64 {
    let last = head.len() - 1;
    let inner: f64 = head[1..last].iter().sum();
    (inner + 0.5 * (head[0] + head[last])) / last as f64
}

/// Sets a linear profile from `base` at the base to zero at the surface (m).
pub fn set_linear_profile(head: &mut [f64], base: f64) {
    head.fill(0.0);
    load_undrained(head, base);
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Series of the sheet for a unit pressure: uniform, triangular, triangular drained at both ends.
    fn uniform(zeta: f64, t: f64) -> f64 {
        let term = |k: i32| {
            let l = f64::from(2 * k + 1) * PI / 2.0;
            2.0 * (-1f64).powi(k) / l * (l * zeta).cos() * (-l * l * t).exp()
        };
        (0..200).map(term).sum()
    }
    fn triangular(zeta: f64, t: f64) -> f64 {
        let term = |k: i32| {
            let l = f64::from(2 * k + 1) * PI / 2.0;
            2.0 / (l * l) * (l * zeta).cos() * (-l * l * t).exp()
        };
        (0..200).map(term).sum()
    }
    fn drained_solution(zeta: f64, t: f64) -> f64 {
        let term = |k: i32| {
            let l = f64::from(k) * PI;
            2.0 / l * (l * zeta).sin() * (-l * l * t).exp()
        };
        (1..200).map(term).sum()
    }

    /// Largest error at times of 0.05 and more.
    fn max_error(
        cells: usize,
        weight: f64,
        step: f64,
        base: BaseCondition,
        start: fn(f64) -> f64,
        exact: fn(f64, f64) -> f64,
    ) -> f64 {
        let zeta = |k: usize| k as f64 / cells as f64;
        let mut head: Vec<f64> = (0..=cells).map(|k| start(zeta(k))).collect();
        let mut scratch = vec![0.0; cells + 1];
        let (mut worst, mut time) = (0.0f64, 0.0);
        for number in 1..=(0.5 / step).round() as usize {
            diffuse_head(&mut head, step, weight, base, &mut scratch);
            time += step;
            if number % (0.05 / step).round() as usize == 0 {
                let errors = head.iter().enumerate().map(|(k, p)| (p - exact(zeta(k), time)).abs());
                worst = errors.fold(worst, f64::max);
            }
        }
        worst
    }

    /// V13b and V13c with the tolerances of the sheet, and their orders.
    #[test]
    fn consolidation_is_that_of_the_series() {
        let start = |z: f64| 1.0 - z;
        let sealed =
            |cells, weight, step| max_error(cells, weight, step, BaseCondition::Sealed, start, triangular);
        let (fine, coarse) = (sealed(40, 0.5, 1e-3), sealed(20, 0.5, 1e-3));
        assert!(coarse < 1e-3 && fine < 2.5e-4, "{coarse} {fine}");
        assert!((coarse / fine).log2() > 1.8, "second order in depth: {coarse} {fine}");
        let (long, short) = (sealed(20, 1.0, 1e-3), sealed(80, 1.0, 5e-4));
        assert!(long < 3.5e-3, "{long}");
        assert!(short < 0.6 * long, "first order in time: {long} {short}");
        let open = max_error(40, 0.5, 1e-3, BaseCondition::Head(0.0), start, drained_solution);
        assert!(open < 1e-3, "{open}");
    }

    /// V13a: a uniform pressure, whose jump at the surface Crank–Nicolson does not damp within the first steps.
    #[test]
    fn a_uniform_pressure_drains_as_the_series() {
        let found = max_error(20, 1.0, 1e-3, BaseCondition::Sealed, |_| 1.0, uniform);
        assert!(found < 7e-3, "{found}");
    }

    /// V13d: sealed, drained, sealed again: pressure comes back to the base.
    #[test]
    fn basal_pressure_recovers_after_a_drained_section() {
        let cells = 40;
        let mut head = vec![0.0; cells + 1];
        let mut scratch = head.clone();
        set_linear_profile(&mut head, 1.0);
        let step = 1e-4;
        let mut shape = head.clone();
        relax_amplitude(&mut shape, 0.0, BaseCondition::Sealed);
        let table = [
            (500, [0.747_695, 0.484_632, 0.450_022]),
            (600, [0.0, 0.476_617, 0.357_542]),
            (700, [0.0, 0.459_297, 0.315_878]),
            (750, [0.190_228, 0.445_440, 0.310_965]),
            (1000, [0.331_802, 0.368_323, 0.287_016]),
            (2000, [0.325_922, 0.242_470, 0.214_684]),
        ];
        for number in 1..=2000 {
            let base =
                if (501..=700).contains(&number) { BaseCondition::Head(0.0) } else { BaseCondition::Sealed };
            diffuse_head(&mut head, step, 1.0, base, &mut scratch);
            relax_amplitude(&mut shape, step, base);
            if let Some((_, exact)) = table.iter().find(|(at, _)| *at == number) {
                let found = [head[0], head[cells / 2], mean(&head)];
                for (found, exact) in found.iter().zip(exact) {
                    assert!((found - exact).abs() < 0.01, "{number}: {found} for {exact}");
                }
            }
            if number > 500 {
                assert_eq!((shape[0], mean(&shape)), (0.0, 0.0));
            }
        }
    }

    /// V14: without drainage a liquefied column stays liquefied, whatever its height, and pressures follow the height.
    #[test]
    fn an_undrained_column_keeps_its_liquefaction() {
        let mut head = vec![0.0; 21];
        set_linear_profile(&mut head, 2.0);
        let mut depth = 2.0;
        for growth in [-0.5, 0.7, -1.9, 4.0] {
            load_undrained(&mut head, growth);
            depth += growth;
            assert!(!limit_head(&mut head, depth, |_| 0.0));
            assert!((head[0] / depth - 1.0).abs() < 1e-12);
        }
        set_linear_profile(&mut head, 0.3);
        load_undrained(&mut head, 1.25);
        assert!((head[0] - 1.55).abs() < 1e-12);
    }

    /// V14b: a column that thins as `h = 2 exp(-t/5)` while it drains; heads in metres.
    #[test]
    fn a_thinning_column_converges_to_the_sheet() {
        let run = |steps: usize, cells: usize| {
            let mut head = vec![0.0; cells + 1];
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
                    found.push([head[0], mean(&head)]);
                }
            }
            found
        };
        let exact = [[0.866_05, 0.553_88], [0.310_10, 0.201_52], [-0.068_06, -0.042_70]];
        let error = |steps: usize, cells: usize| {
            let pairs = run(steps, cells).into_iter().zip(exact);
            pairs.flat_map(|(a, b)| [(a[0] - b[0]).abs(), (a[1] - b[1]).abs()]).fold(0.0, f64::max)
        };
        let (long, short) = (error(500, 80), error(1000, 80));
        assert!(short < 0.6 * long && short < 5e-3, "{long} {short}");
    }

    #[test]
    fn a_leaking_base_lies_between_sealed_and_open() {
        let base = |base: BaseCondition| {
            let mut head = vec![0.0; 21];
            let mut scratch = head.clone();
            set_linear_profile(&mut head, 1.0);
            for _ in 0..100 {
                diffuse_head(&mut head, 1e-3, 1.0, base, &mut scratch);
            }
            head[0]
        };
        let (sealed, weak, strong) =
            (base(BaseCondition::Sealed), base(BaseCondition::Partly(1.0)), base(BaseCondition::Partly(1e6)));
        assert!(sealed > weak && weak > 0.1 && strong.abs() < 1e-4, "{sealed} {weak} {strong}");
        assert!((base(BaseCondition::Partly(0.0)) - sealed).abs() < 1e-15);
    }
}
