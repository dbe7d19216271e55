//! State at an open side and beyond it, by the Riemann invariants along the normal (sheet: depth-sph §2.2, §3.9).

use serde::{Deserialize, Serialize};

use crate::points::phase_nodes::PlanVector;

/// Least variance of node distances from a boundary, over their mean square, for a linear extrapolation of depth and speed. A single row
/// has less; the slope through it is arbitrary.
const MIN_DISTANCE_VARIANCE: f64 = 1e-2;

/// Number of samples of the recorded flow in the travel time of a wave from the recording position to the boundary.
pub(super) const INTERVALS: f64 = 16.0;

/// State of the flow at a position of an open boundary: depth and velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoundaryState {
    /// Depth (m).
    pub depth: f64,
    /// Outward speed (m/s).
    pub speed: f64,
    /// Speed along the boundary (m/s); zero in a profile.
    pub tangential_speed: f64,
    /// Porosity of a flow of grains and fluid.
    pub porosity: f64,
}

impl BoundaryState {
    /// Share of a node set in the total depth: 1 for a single phase, else the share of grains or of fluid.
    pub fn depth_share(&self, sets: usize, number: usize) -> f64 {
        match (sets, number) {
            (1, _) => 1.0,
            (_, 0) => 1.0 - self.porosity,
            _ => self.porosity,
        }
    }
}

/// Depth and velocity of the flow inside an open boundary with their outward slopes, by a linear fit over the nodes in kernel range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InteriorFit {
    /// Depth at the boundary (m) and its outward slope (-).
    pub depth: [f64; 2],
    /// Outward speed at the boundary (m/s) and its outward slope (1/s).
    pub speed: [f64; 2],
    /// Speed along the side (m/s).
    pub tangential_speed: f64,
    /// Porosity of a flow of grains and fluid.
    pub porosity: f64,
    /// Effective gravity (m/s²).
    pub effective_gravity: f64,
    /// Distance over which slopes are extrapolated (m).
    pub extrapolation_distance: f64,
}

impl InteriorFit {
    /// Depth (m) and outward speed (m/s) of the arriving flow, extrapolated to the distance `far` outside the boundary (m).
    pub(super) fn extrapolated(&self, far: f64) -> [f64; 2] {
        let [depth, slope] = self.depth;
        let arriving = (depth + slope * far).clamp(0.5 * depth, 1.5 * depth);
        [arriving, self.speed[0] + self.speed[1] * far]
    }

    /// State at a distance `beyond` outside the boundary (m), for the far-field state `still`. Depths are those of the extrapolated
    /// arriving flow, and the speed is that at the boundary, so that nodes outside keep their distances.
    pub fn state_beyond(&self, still: Option<&BoundaryState>, beyond: f64) -> BoundaryState {
        let riemann = |[depth, speed]: [f64; 2]| riemann_state(still, depth, speed, self.effective_gravity);
        let (at_side, there) = (
            riemann([self.depth[0], self.speed[0]]),
            riemann(self.extrapolated(beyond.min(self.extrapolation_distance))),
        );
        // Along the side nodes keep their distances as well, or their depths would contain that compression in addition.
        let tangential_speed = still.map_or(self.tangential_speed, |still| still.tangential_speed);
        BoundaryState { depth: there.0, speed: at_side.1, tangential_speed, porosity: self.porosity }
    }
}

/// Recorded flow at a position inside an open boundary, from which waves travel to the boundary and the nodes outside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ArrivalHistory {
    /// Times (s), ascending, and the states there.
    records: Vec<(f64, BoundaryState)>,
    /// Effective gravity at the position (m/s²).
    effective_gravity: f64,
    /// Distance of the position before the side (m).
    distance: f64,
    /// Time of the middle of the step (s).
    step_middle: f64,
}

impl ArrivalHistory {
    /// Records the state at `distance` inside the boundary (m) at the beginning of a step of `dt` (s). It is evaluated up to `reach`
    /// outside the boundary (m).
    pub fn record(&mut self, (time, dt): (f64, f64), found: &InteriorFit, distance: f64, reach: f64) {
        let InteriorFit { depth, speed, tangential_speed, porosity, effective_gravity, .. } = *found;
        let state = BoundaryState { depth: depth[0], speed: speed[0], tangential_speed, porosity };
        (self.effective_gravity, self.distance, self.step_middle) =
            (effective_gravity, distance, time + 0.5 * dt);
        let wave = self.wave(&state);
        let interval = distance / (INTERVALS * wave);
        if self.records.last().is_none_or(|(last, _)| time - last >= interval) {
            self.records.push((time, state));
        }
        // Twice as long as waves need, which may become slower.
        let old = self.step_middle - 2.0 * (distance + reach) / wave;
        let first = self.records.partition_point(|(time, _)| *time < old).saturating_sub(1);
        self.records.drain(..first);
    }

    /// State at a distance `beyond` outside the boundary (m), for the far-field state `still`. Depths are those of the waves that have
    /// arrived there, and the speed is that at the boundary, so that nodes outside keep their distances.
    pub fn state_beyond(&self, still: Option<&BoundaryState>, beyond: f64) -> BoundaryState {
        let Some((_, last)) = self.records.last() else { return still.copied().unwrap_or_default() };
        let riemann = |beyond: f64| {
            let BoundaryState { depth, speed, .. } = self.travelled_state(beyond, last);
            riemann_state(still, depth, speed, self.effective_gravity)
        };
        // Along the side nodes keep their distances as well, or their depths would contain that compression in addition.
        let tangential_speed = still.map_or(last.tangential_speed, |still| still.tangential_speed);
        BoundaryState {
            depth: riemann(beyond).0,
            speed: riemann(0.0).1,
            tangential_speed,
            porosity: last.porosity,
        }
    }

    /// State that has travelled from the recording position to a distance `beyond` outside the boundary (m).
    fn travelled_state(&self, beyond: f64, last: &BoundaryState) -> BoundaryState {
        let time = self.step_middle - (self.distance + beyond) / self.wave(last);
        let after = self.records.partition_point(|(own, _)| *own < time).max(1);
        let (first, before) = self.records[after - 1];
        let Some((second, later)) = self.records.get(after).filter(|_| time > first) else { return before };
        let share = (time - first) / (second - first);
        let between = |a: f64, b: f64| a + share * (b - a);
        BoundaryState {
            depth: between(before.depth, later.depth),
            speed: between(before.speed, later.speed),
            ..before
        }
    }

    /// Speed of waves outward (m/s), bounded from below: against an inflow nearly as fast they would take too long.
    fn wave(&self, state: &BoundaryState) -> f64 {
        let celerity = (self.effective_gravity * state.depth).sqrt();
        (state.speed + celerity).max(0.5 * celerity)
    }
}

/// Depth (m) and outward speed (m/s) at the boundary for an arriving flow, from the Riemann invariants of waves in the normal direction.
/// `effective_gravity` is in m/s². A wave at an angle `θ` to the normal is reflected with the factor `(1 - cos θ)/(1 + cos θ)`.
pub fn riemann_state(
    still: Option<&BoundaryState>,
    depth: f64,
    speed: f64,
    effective_gravity: f64,
) -> (f64, f64) {
    let celerity = (effective_gravity * depth).sqrt();
    let Some(still) = still.filter(|_| speed < celerity) else {
        // No wave returns against a supercritical flow.
        return (depth, speed);
    };
    let outgoing = speed + 2.0 * celerity;
    let incoming = still.speed - 2.0 * (effective_gravity * still.depth).sqrt();
    let found = 0.25 * (outgoing - incoming);
    (found * found / effective_gravity, 0.5 * (outgoing + incoming))
}

/// Sums over the nodes in kernel range of a boundary position, for linear least-squares fits.
#[derive(Clone, Copy, Debug, Default)]
pub struct LineFitSums {
    powers: [f64; 3],
    depth: [f64; 2],
    speed: [f64; 2],
    tangential_speed: f64,
    fluid: f64,
    effective_gravity: f64,
    extrapolation_distance: f64,
}

impl LineFitSums {
    /// Adds a node to the sums. `beyond` is its distance outside the boundary (m), negative inside; `velocity` has the outward and the
    /// tangential component (m/s).
    pub fn add(
        &mut self,
        weight: f64,
        beyond: f64,
        velocity: [f64; 2],
        depth: f64,
        effective_gravity: f64,
        reach: f64,
    ) {
        let powers = [weight, weight * beyond, weight * beyond * beyond];
        (0..3).for_each(|k| self.powers[k] += powers[k]);
        for k in 0..2 {
            self.depth[k] += powers[k] * depth;
            self.speed[k] += powers[k] * velocity[0];
        }
        self.tangential_speed += weight * velocity[1];
        self.effective_gravity += weight * effective_gravity;
        self.extrapolation_distance = self.extrapolation_distance.max(reach);
    }

    /// Adds the weight of a node of the pore fluid.
    pub fn add_fluid(&mut self, weight: f64) {
        self.fluid += weight;
    }

    /// Linear fits of depth and speeds; `None` if there are no nodes.
    pub fn interior_fit(&self) -> Option<InteriorFit> {
        let [weight, first, second] = self.powers;
        if !(weight > 0.0) {
            return None;
        }
        let spread = weight * second - first * first;
        let line = |[sum, moment]: [f64; 2]| {
            let is_line = spread > MIN_DISTANCE_VARIANCE * weight * second;
            let slope = if is_line { (weight * moment - first * sum) / spread } else { 0.0 };
            [(sum - slope * first) / weight, slope]
        };
        // A line through a front may fall below the bed before the side.
        let [depth, slope] = line(self.depth);
        Some(InteriorFit {
            depth: [depth.max(0.0), slope],
            speed: line(self.speed),
            tangential_speed: self.tangential_speed / weight,
            porosity: self.fluid / weight,
            effective_gravity: self.effective_gravity / weight,
            extrapolation_distance: self.extrapolation_distance,
        })
    }
}

/// Outward and tangential components of a velocity in plan at a boundary normal to `axis` (m/s).
pub fn outward_and_tangential<const D: usize>(
    velocity: &PlanVector<D>,
    axis: usize,
    outward: f64,
) -> [f64; 2] {
    let along = if D == 1 { 0.0 } else { velocity[1 - axis] };
    [outward * velocity[axis], along]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simple_waves_and_supercritical_flow_leave_a_boundary_unchanged() {
        let celerity = |depth: f64| (9.81 * depth).sqrt();
        let still = BoundaryState { depth: 1.0, ..BoundaryState::default() };
        for depth in [0.8, 1.0, 1.3] {
            let speed = 2.0 * (celerity(depth) - celerity(1.0));
            let (h, u) = riemann_state(Some(&still), depth, speed, 9.81);
            assert!((h - depth).abs() < 1e-12 && (u - speed).abs() < 1e-12);
        }
        // A wave that enters from the end itself is not admitted: the material outside rests.
        let (h, u) = riemann_state(Some(&still), 1.1, -2.0 * (celerity(1.1) - celerity(1.0)), 9.81);
        assert!((h - 1.0).abs() < 1e-12 && u.abs() < 1e-12);
        assert_eq!(riemann_state(Some(&still), 0.2, 3.0, 9.81), (0.2, 3.0));
        assert_eq!(riemann_state(None, 0.2, 0.1, 9.81), (0.2, 0.1));
    }

    /// A front that is thinner the nearer it is to the side, so that a line through it is below the bed there.
    #[test]
    fn a_front_before_the_side_has_no_depth_beyond_it() {
        let mut moments = LineFitSums::default();
        for (beyond, depth) in [(-1.0, 0.9), (-0.6, 0.1)] {
            moments.add(1.0, beyond, [1.0, 0.0], depth, 9.81, 2.0);
        }
        let within = moments.interior_fit().unwrap();
        assert_eq!(within.depth[0], 0.0);
        assert_eq!(within.state_beyond(None, 0.5).depth, 0.0);
    }

    /// Depth and speed of a single row of grains and fluid are its means, without a slope.
    #[test]
    fn a_row_of_grains_and_fluid_has_no_slope() {
        let mut moments = LineFitSums::default();
        for (beyond, speed) in [(-0.0394, 0.0), (-0.0397, -3.7)] {
            moments.add(1.0, beyond, [speed, 0.0], 0.3, 9.81, 2.0);
        }
        let within = moments.interior_fit().unwrap();
        assert!((within.speed[0] + 1.85).abs() < 1e-12 && within.speed[1] == 0.0, "{within:?}");
    }

    #[test]
    fn the_state_beyond_a_side_is_the_wave_delayed_by_its_travel_time() {
        let celerity = (9.81f64).sqrt();
        let still = BoundaryState { depth: 1.0, ..BoundaryState::default() };
        let hump = |time: f64| 1e-4 * (-(4.0 * (time - 1.0)).powi(2)).exp();
        let (distance, dt) = (0.3, 0.004);
        let mut past = ArrivalHistory::default();
        for step in 0..400 {
            let time = dt * f64::from(step);
            let height = hump(time);
            let found = InteriorFit {
                depth: [1.0 + height, 0.0],
                speed: [height * celerity, 0.0],
                tangential_speed: 0.0,
                porosity: 0.0,
                effective_gravity: 9.81,
                extrapolation_distance: 0.15,
            };
            past.record((time, dt), &found, distance, 0.45);
            let BoundaryState { depth, speed, .. } = past.state_beyond(Some(&still), 0.15);
            let there = |beyond: f64| hump(time + 0.5 * dt - (distance + beyond) / celerity);
            assert!((depth - 1.0 - there(0.15)).abs() < 2e-7, "{time} s: {depth}");
            assert!((speed - celerity * there(0.0)).abs() < 6e-7, "{time} s: {speed}");
        }
        assert!(past.records.len() < 120, "{} are kept", past.records.len());
    }
}
