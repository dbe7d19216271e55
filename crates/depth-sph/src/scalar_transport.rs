//! Scalars on the nodes of a line: convection, diffusion, decay, and Burgers' equation (sheet: depth-sph §2.1, V1 to V3, V4a to V4c).
//!
//! Nodes carry a value along their paths. Between nodes it is linear. Where nodes with their own velocity collide, two become one
//! with the value that keeps the area under the line: shocks then move as in the conserved form.

use rayon::prelude::*;

use crate::kernel::Kernel;

/// Nodes on a line in ascending order, each with a scalar value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScalarNodes {
    /// Positions (m), ascending.
    pub positions: Vec<f64>,
    /// Values; velocities (m/s) in Burgers' equation.
    pub values: Vec<f64>,
}

impl ScalarNodes {
    /// Creates nodes at `positions` (m), ascending, with the values of a formula.
    pub fn new(positions: impl Iterator<Item = f64>, value: impl Fn(f64) -> f64) -> Self {
        let positions: Vec<f64> = positions.collect();
        let values = positions.iter().map(|x| value(*x)).collect();
        Self { positions, values }
    }

    /// Moves all nodes with a common velocity (m/s) for a time `dt` (s).
    pub fn advect(&mut self, speed: f64, dt: f64) {
        self.positions.iter_mut().for_each(|x| *x += speed * dt);
    }

    /// Inserts a node after the first one.
    pub fn insert_node(&mut self, place: f64, value: f64) {
        self.positions.insert(0, place);
        self.values.insert(0, value);
    }

    /// Applies diffusion (m²/s) and decay at the rate `sink` (1/s) for `dt` (s), by the midpoint rule. `length` is the smoothing length and
    /// `spacing` the node distance (m). Stable for `dt` up to a quarter of `length²/diffusivity`.
    pub fn diffuse(&mut self, length: f64, spacing: f64, diffusivity: f64, sink: f64, dt: f64) {
        let first = self.laplacian(&self.values, length, spacing);
        let half = |(value, bend): (&f64, &f64)| value + 0.5 * dt * diffusivity * bend;
        let middle: Vec<f64> = self.values.iter().zip(&first).map(half).collect();
        let second = self.laplacian(&middle, length, spacing);
        let decay = (-sink * dt).exp();
        for (value, bend) in self.values.iter_mut().zip(&second) {
            *value = (*value + dt * diffusivity * bend) * decay;
        }
    }

    /// Second derivative at each node, `2 Σ Ω_J (φ_I - φ_J) x·∇W/|x|²`. The quotient is finite for coincident nodes, so that no softening
    /// is needed (sheet: depth-sph §2.1).
    fn laplacian(&self, values: &[f64], length: f64, spacing: f64) -> Vec<f64> {
        let kernel = Kernel::CubicSpline;
        let reach = kernel.support() * length;
        let bend = |i: usize| -> f64 {
            let x = self.positions[i];
            let first = self.positions.partition_point(|y| *y <= x - reach);
            let end = self.positions.partition_point(|y| *y < x + reach);
            let pair = |j: usize| {
                let distance = (x - self.positions[j]).abs();
                2.0 * spacing * (values[i] - values[j]) * kernel.gradient::<1>(distance, length)
            };
            (first..end).map(pair).sum()
        };
        (0..values.len()).into_par_iter().map(bend).collect::<Vec<_>>()
    }

    /// Integrates Burgers' equation for `time` (s): each node moves with its value, and nodes that collide are merged.
    pub fn steepen(&mut self, time: f64) {
        let mut left = time;
        loop {
            let meets = |i: &usize| {
                let closing = self.values[*i] - self.values[i + 1];
                if closing > 0.0 {
                    (self.positions[i + 1] - self.positions[*i]) / closing
                } else {
                    f64::INFINITY
                }
            };
            let pairs = 0..self.positions.len().saturating_sub(1);
            let next = pairs.map(|i| (meets(&i), i)).min_by(|a, b| a.0.total_cmp(&b.0));
            let dt = next.map_or(left, |(dt, _)| dt.min(left));
            self.positions.iter_mut().zip(&self.values).for_each(|(x, value)| *x += dt * value);
            match next {
                Some((meeting, i)) if meeting <= left => self.merge(i),
                _ => return,
            }
            left -= dt;
        }
    }

    /// Merges the nodes `i` and `i + 1`, which have collided.
    fn merge(&mut self, i: usize) {
        let (places, values) = (&self.positions, &self.values);
        let place = 0.5 * (places[i] + places[i + 1]);
        let value = match (i.checked_sub(1), places.get(i + 2)) {
            (Some(before), Some(after)) => {
                let area: f64 =
                    (before..i + 2).map(|k| (places[k + 1] - places[k]) * (values[k] + values[k + 1])).sum();
                let [low, high] = [places[before], *after];
                let outer = (place - low) * values[before] + (high - place) * values[i + 2];
                (area - outer) / (high - low)
            }
            _ => 0.5 * (values[i] + values[i + 1]),
        };
        // Round-off of nodes at one position.
        let value = value.clamp(values[i].min(values[i + 1]), values[i].max(values[i + 1]));
        (self.positions[i], self.values[i]) = (place, value);
        self.positions.remove(i + 1);
        self.values.remove(i + 1);
    }

    /// Value at a position (m), linear between the nodes and constant outside them.
    pub fn value_at(&self, x: f64) -> f64 {
        let after = self.positions.partition_point(|y| *y < x);
        if after == 0 || after == self.positions.len() {
            return self.values.get(after.min(self.values.len().saturating_sub(1))).copied().unwrap_or(0.0);
        }
        let (a, b) = (self.positions[after - 1], self.positions[after]);
        let share = (x - a) / (b - a);
        self.values[after - 1] + share * (self.values[after] - self.values[after - 1])
    }

    /// Integral of the value between the outermost nodes.
    pub fn area(&self) -> f64 {
        let strips = self.positions.windows(2).zip(self.values.windows(2));
        strips.map(|(x, value)| 0.5 * (x[1] - x[0]) * (value[0] + value[1])).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_has_its_second_derivative() {
        // Two spacings: the second moment of the cubic spline on a lattice is then that of the integral.
        let line = ScalarNodes::new((0..60).map(|k| 0.1 * f64::from(k)), |x| 3.0 * x * x - x);
        let bends = line.laplacian(&line.values, 0.2, 0.1);
        assert!(bends[10..50].iter().all(|bend| (bend - 6.0).abs() < 1e-10), "{bends:?}");
    }

    #[test]
    fn a_shock_moves_with_the_mean_and_keeps_the_area() {
        let mut line =
            ScalarNodes::new(
                (0..80).map(|k| 0.05 * f64::from(k) - 1.975),
                |x| if x < 0.0 { 1.2 } else { 0.2 },
            );
        let before = line.area();
        line.steepen(1.0);
        // Inflow at the left end and outflow at the right one.
        let carried = line.area() - before;
        let ends = [line.positions[0] + 1.975, line.positions[line.positions.len() - 1] - 1.975];
        let swept = 0.5 * (1.2 * 1.2 - 0.2 * 0.2) - 1.2 * ends[0] + 0.2 * ends[1];
        assert!((carried - swept).abs() < 1e-10, "{carried} {swept}");
        assert!(
            (line.value_at(0.7) - 0.7).abs() < 0.02,
            "half of the jump stands at 0.7: {}",
            line.value_at(0.7)
        );
        assert!(line.positions.windows(2).all(|pair| pair[0] <= pair[1]));
    }
}
