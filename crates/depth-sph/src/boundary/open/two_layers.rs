//! Open sides of two layers: waves of surface and interface leave, each by its own invariant (sheet: depth-sph §2.2, §2.11, §3.9).
//!
//! Each layer has an open side of its own. Small waves on the far state, `h₁` of the lower and `h₂` of the upper layer, follow
//! `∂²h/∂t² = A ∂²h/∂x²` with `A = g [[h₁, γ h₁], [h₂, h₂]]`, `γ = ρ₂/ρ₁`; a left vector `ℓ` of `A` with `c²` is a wave by itself,
//! `ℓ·q ± c ℓ·h` its invariants with the fluxes `q`.

use serde::{Deserialize, Serialize};

use crate::boundary::open::boundary_state::{BoundaryState, INTERVALS, InteriorFit, riemann_state};
use crate::points::phase_nodes::PhaseNodes;

/// Least depth of a layer over that of the other one in the far field, below which the layer has no waves of its own.
const MIN_DEPTH_RATIO: f64 = 1e-3;

/// Layer of a two-layer flow to which an open boundary belongs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LayerOfSide {
    /// Node set of the layer: 0 for the lower, 1 for the upper one.
    pub(crate) set: usize,
    /// Density ratio `γ` of the upper to the lower layer.
    pub(crate) ratio: f64,
}

/// States of both layers at a boundary segment, the lower one first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LayerPair {
    /// Far states.
    far_states: [Option<BoundaryState>; 2],
    /// Flow that arrives from within at the side.
    interior: [Option<InteriorFit>; 2],
    /// At the end of a profile, history of the flow at a position before it, with times (s), ascending.
    history: Vec<(f64, [ArrivingLayer; 2])>,
    /// Distance of that position before the end (m).
    distance: f64,
    /// Time of the middle of the step (s).
    step_middle: f64,
}

/// Depth (m) and outward speed (m/s) of a layer that arrives at a position.
type ArrivingLayer = [f64; 2];

impl LayerOfSide {
    /// Effective gravity (m/s²) for waves of this layer alone at a node, while the free surface stays level (sheet: depth-sph §2.11, `c_i²`
    /// of a thin layer).
    pub(crate) fn wave_gravity<const D: usize>(&self, nodes: &PhaseNodes<D>, i: usize) -> f64 {
        let is_covered = self.set == 0 && nodes.depth[i] > nodes.partial_thickness[i];
        nodes.effective_gravity[i] * if is_covered { 1.0 - self.ratio } else { 1.0 }
    }

    /// Depth (m) and outward speed (m/s) of the layer at the boundary, from the arriving flow and the far field of both layers. `arriving`
    /// gives the arriving layers for a wave speed (m/s).
    fn riemann_state(
        &self,
        still: [Option<BoundaryState>; 2],
        arriving: impl Fn(f64) -> [ArrivingLayer; 2],
        effective_gravity: f64,
    ) -> (f64, f64) {
        let deepest = still.iter().flatten().map(|state| state.depth).fold(0.0, f64::max);
        let there = |layer: usize| still[layer].filter(|state| state.depth > MIN_DEPTH_RATIO * deepest);
        if let (Some(lower), Some(upper)) = (there(0), there(1)) {
            return self.riemann_state_of_both([lower, upper], arriving, effective_gravity);
        }
        // A layer without far state leaves unchanged; the surface of the other, over it, has the waves.
        let one = |still: BoundaryState| arriving((effective_gravity * still.depth).sqrt() + still.speed);
        match (there(0), there(1)) {
            (None, Some(upper)) if self.set == 1 => {
                let [below, own] = one(upper);
                let (surface, speed) =
                    riemann_state(Some(&upper), below[0] + own[0], own[1], effective_gravity);
                ((surface - below[0]).max(0.0), speed)
            }
            (Some(lower), None) if self.set == 0 => {
                let own = one(lower)[0];
                riemann_state(Some(&lower), own[0], own[1], effective_gravity)
            }
            (out, other) => {
                let [depth, speed] = out.or(other).map_or_else(|| arriving(f64::INFINITY), one)[self.set];
                (depth, speed)
            }
        }
    }

    /// Depth (m) and speed (m/s) of this layer at the boundary, from the characteristics of the coupled two-layer system.
    fn riemann_state_of_both(
        &self,
        still: [BoundaryState; 2],
        arriving: impl Fn(f64) -> [ArrivingLayer; 2],
        effective_gravity: f64,
    ) -> (f64, f64) {
        let depths = still.map(|state| state.depth);
        let [lower, upper] = depths;
        let mean = still.iter().map(|state| state.depth * state.speed).sum::<f64>() / (lower + upper);
        let spread = ((lower - upper).powi(2) + 4.0 * self.ratio * lower * upper).sqrt();
        // Left vectors, and the parts of heights and fluxes of their waves at the side.
        let waves = [1.0, -1.0].map(|sign| {
            let square = 0.5 * effective_gravity * (lower + upper + sign * spread);
            let (vector, celerity) =
                ([effective_gravity * upper, square - effective_gravity * lower], square.max(0.0).sqrt());
            let along = |change: [f64; 2]| vector[0] * change[0] + vector[1] * change[1];
            let brought = arriving((mean + celerity).max(0.5 * celerity));
            let height = along([0, 1].map(|k| brought[k][0] - depths[k]));
            let flux = along([0, 1].map(|k| depths[k] * (brought[k][1] - still[k].speed)));
            let found = if mean >= celerity {
                [height, flux]
            } else if mean <= -celerity {
                [0.0; 2]
            } else {
                let outward = 0.5 * (height + flux / celerity);
                [outward, celerity * outward]
            };
            (vector, found)
        });
        let [(first, of_first), (second, of_second)] = waves;
        let determinant = first[0] * second[1] - first[1] * second[0];
        let back = |k: usize| {
            let (a, b) = (of_first[k], of_second[k]);
            match self.set {
                0 => (a * second[1] - b * first[1]) / determinant,
                _ => (b * first[0] - a * second[0]) / determinant,
            }
        };
        let own = still[self.set];
        ((own.depth + back(0)).max(0.0), own.speed + back(1) / own.depth)
    }

    /// State of the layer at a distance `beyond` outside the boundary (m). Depths are those of the waves that have arrived there, and the
    /// speed is that at the boundary, so that nodes outside keep their distances.
    pub(super) fn state_beyond(&self, both: &LayerPair, beyond: f64) -> BoundaryState {
        let own = both.far_states[self.set];
        let Some(arriving) = both.interior[self.set].or(both.interior[1 - self.set]) else {
            return own.unwrap_or_default();
        };
        let at = |far: f64| {
            self.riemann_state(
                both.far_states,
                |wave| both.arriving_layers(far, wave),
                arriving.effective_gravity,
            )
        };
        let tangential_speed = own
            .map_or(both.interior[self.set].map_or(0.0, |within| within.tangential_speed), |still| {
                still.tangential_speed
            });
        BoundaryState { depth: at(beyond).0, speed: at(0.0).1, tangential_speed, porosity: 0.0 }
    }
}

impl LayerPair {
    /// Sets the far-field states of both layers and the fits of the interior flow that arrives at the boundary.
    pub(super) fn set_states(&mut self, far: [Option<BoundaryState>; 2], interior: [Option<InteriorFit>; 2]) {
        (self.far_states, self.interior) = (far, interior);
    }

    /// Records the state at `distance` before the end of a profile (m) at the beginning of a step of `dt` (s). It is evaluated up to
    /// `reach` outside the end (m).
    pub(super) fn record(
        &mut self,
        (time, dt): (f64, f64),
        found: [Option<InteriorFit>; 2],
        distance: f64,
        reach: f64,
    ) {
        let Some(effective_gravity) = found.iter().flatten().map(|within| within.effective_gravity).next()
        else {
            return self.history.clear();
        };
        (self.step_middle, self.distance) = (time + 0.5 * dt, distance);
        let whole: f64 = found.iter().flatten().map(|within| within.depth[0]).sum();
        let smallest = found.iter().flatten().map(|within| within.depth[0]).fold(whole, f64::min);
        let interval = distance / (INTERVALS * (effective_gravity * whole).sqrt());
        if self.history.last().is_none_or(|(last, _)| time - last >= interval) {
            self.history
                .push((time, found.map(|within| within.map_or([0.0; 2], |within| within.extrapolated(0.0)))));
        }
        // Waves of the interface are the slowest.
        let slowest = 0.25 * (effective_gravity * smallest.max(MIN_DEPTH_RATIO * whole)).sqrt();
        let old = self.step_middle - (distance + reach) / slowest;
        let first = self.history.partition_point(|(time, _)| *time < old).saturating_sub(1);
        self.history.drain(..first);
    }

    /// Depths and speeds of both layers that a wave of a given speed (m/s) carries to a distance `beyond` outside the boundary (m).
    fn arriving_layers(&self, beyond: f64, wave: f64) -> [ArrivingLayer; 2] {
        let Some((_, last)) = self.history.last() else {
            let far = |within: InteriorFit| within.extrapolated(beyond.min(within.extrapolation_distance));
            return self.interior.map(|within| within.map_or([0.0; 2], far));
        };
        let time = self.step_middle - (self.distance + beyond) / wave;
        let after = self.history.partition_point(|(own, _)| *own < time).max(1);
        let (first, before) = self.history[after - 1];
        let Some((second, later)) = self.history.get(after).filter(|_| time > first) else {
            return if time > first { *last } else { before };
        };
        let share = (time - first) / (second - first);
        let between = |k: usize, c: usize| before[k][c] + share * (later[k][c] - before[k][c]);
        [0, 1].map(|k| [0, 1].map(|c| between(k, c)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An outgoing wave of either kind is unchanged at the side, and an incoming one is absent.
    #[test]
    fn waves_of_both_modes_leave_without_incoming_waves() {
        let (depths, gravity, ratio) = ([0.6, 0.4], 9.81, 0.5);
        let still = depths.map(|depth| Some(BoundaryState { depth, ..BoundaryState::default() }));
        let spread =
            ((depths[0] - depths[1]) * (depths[0] - depths[1]) + 4.0 * ratio * depths[0] * depths[1]).sqrt();
        for sign in [1.0, -1.0] {
            let square = 0.5 * gravity * (1.0 + sign * spread);
            // Right vector of the wave: `g h₁ (a + γ b) = c² a`.
            let shape = [ratio * gravity * depths[0], square - gravity * depths[0]];
            for (direction, size) in [(1.0, 1e-3), (-1.0, 1e-3), (1.0, -1e-3)] {
                let celerity = square.sqrt();
                let arriving = [0, 1].map(|k| {
                    let height = size * shape[k];
                    [depths[k] + height, direction * celerity * height / depths[k]]
                });
                for set in 0..2 {
                    let (depth, speed) =
                        LayerOfSide { set, ratio }.riemann_state(still, |_| arriving, gravity);
                    let exact = if direction > 0.0 { arriving[set] } else { [depths[set], 0.0] };
                    assert!(
                        (depth - exact[0]).abs() < 1e-12 && (speed - exact[1]).abs() < 1e-12,
                        "{sign} {direction}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_layer_absent_beyond_the_side_leaves_unchanged() {
        let upper = BoundaryState { depth: 2.0, ..BoundaryState::default() };
        let still = [None, Some(upper)];
        let arriving = [[0.3, 1.5], [1.7, 0.0]];
        assert_eq!(LayerOfSide { set: 0, ratio: 0.5 }.riemann_state(still, |_| arriving, 9.81), (0.3, 1.5));
        let (depth, speed) = LayerOfSide { set: 1, ratio: 0.5 }.riemann_state(still, |_| arriving, 9.81);
        assert!((depth - 1.7).abs() < 1e-12 && speed.abs() < 1e-12, "its surface is level: {depth} {speed}");
    }
}
