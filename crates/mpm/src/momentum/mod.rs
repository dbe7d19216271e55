//! The momentum solve on the nodes (sheet: mpm §3.3, steps 2–4).
//!
//! Velocity fields of the nodes, lumped and consistent mass, nodes of small mass, damping, and the motion of rigid bodies and patches. The
//! module knows the background grid and the points, and receives walls as data; it knows neither contact nor loads. All modules that read
//! nodal velocities may know it.

pub(crate) mod consistent_mass;
pub(crate) mod driven_object;
pub(crate) mod small_mass_nodes;
pub(crate) mod velocity_fields;

use std::ops::Range;

use colluvium_case::loads::damping::{rayleigh_damped_velocity, sign_or_zero};
use colluvium_grid::{Layout, NodalState, NodeWalls, Vector4};
use serde::{Deserialize, Serialize};

/// Sums over nodes for the equilibrium criterion (sheet: mpm §2.14).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EquilibriumTerms {
    /// Square of the unbalanced force over the free degrees of freedom (N²).
    pub unbalanced: f64,
    /// Square of the external force (N²).
    pub external: f64,
    /// Work of the external forces in the step (J).
    pub work: f64,
    /// Kinetic energy of the nodes (J).
    pub kinetic: f64,
}

impl EquilibriumTerms {
    /// Adds the sums of other nodes.
    pub fn add(&mut self, other: &Self) {
        self.unbalanced += other.unbalanced;
        self.external += other.external;
        self.work += other.work;
        self.kinetic += other.kinetic;
    }
}

/// Energies of obstacles on the nodes (J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NodeObstacleEnergies {
    /// Energy dissipated by friction (J).
    pub friction: f64,
    /// Work of moving obstacles on the material (J).
    pub work: f64,
}

/// Input of the momentum solve of a step.
pub struct MomentumSolve<'a, const D: usize> {
    /// Step (s).
    pub dt: f64,
    /// Gravity at the end of the step (m/s²).
    pub gravity: [f64; 3],
    /// Mass-proportional Rayleigh damping (1/s).
    pub rayleigh: f64,
    /// Whether constrained nodes keep their velocity at the start of the step.
    pub keep_initial_velocity: bool,
    /// Inertia over mass (mass scaling); weight is not scaled.
    pub inertia: f64,
    /// Mass below which a node is skipped (kg).
    pub mass_cutoff: f64,
    /// Boundary conditions.
    pub walls: &'a NodeWalls,
    /// Arrangement of the nodes in memory.
    pub layout: &'a Layout<D>,
}

impl<const D: usize> MomentumSolve<'_, D> {
    /// Solves the momentum equation at the active nodes of a row: velocity at the end of the step and acceleration replace momentum and
    /// force.
    pub fn row(&self, row: usize, active: Range<usize>, line: &mut [NodalState]) {
        let [gx, gy, gz] = self.gravity;
        let gravity = Vector4::new([gx, gy, gz, 0.0]);
        let row_free = self.walls.is_row_free(0, row);
        let inverse_scaling = 1.0 / self.inertia;
        let plain = self.rayleigh == 0.0;
        for number in active {
            let node = &mut line[number];
            let mass = node.momentum_and_mass.as_array()[3];
            if mass <= self.mass_cutoff {
                // Too light for a meaningful force: the node moves with the points around it.
                let inverse = if mass > 0.0 { 1.0 / mass } else { 0.0 };
                node.momentum_and_mass *= Vector4::new([inverse, inverse, inverse, 1.0]);
                node.force = Vector4::ZERO;
                continue;
            }
            let index = self.layout.axis_indices(row, number);
            if plain && row_free && (1..D).all(|axis| self.walls.is_row_free(axis, index[axis])) {
                let inverse = 1.0 / mass;
                let acceleration = (node.force * inverse + gravity) * inverse_scaling;
                // The fourth lane keeps the mass.
                node.momentum_and_mass = node.momentum_and_mass
                    * Vector4::new([inverse, inverse, inverse, 1.0])
                    + acceleration * self.dt;
                node.force = acceleration;
            } else {
                self.solve_node(&index, node, mass);
            }
        }
    }

    /// Velocities of a node at the start and the end of the step without constraints (m/s).
    fn unconstrained_velocities(&self, node: &NodalState, mass: f64) -> ([f64; 3], [f64; 3]) {
        let motion = node.momentum_and_mass.to_array();
        let force = node.force.to_array();
        let mut start = [0.0; 3];
        let mut end = [0.0; 3];
        for c in 0..D {
            start[c] = motion[c] / mass;
            let total = force[c] + mass * self.gravity[c];
            end[c] = start[c] + self.dt * total / (self.inertia * mass);
            if self.rayleigh > 0.0 {
                end[c] = rayleigh_damped_velocity(start[c], end[c], self.rayleigh * self.dt);
            }
        }
        (start, end)
    }

    /// Adds the impulses of a node (N s) to the reactions that are recorded, and the energies that obstacles dissipate and supply (J).
    pub fn record_reactions(
        &self,
        index: &[usize; 3],
        node: &NodalState,
        impulses: &mut [[f64; 3]],
        energies: &mut NodeObstacleEnergies,
    ) {
        let mass = node.momentum_and_mass.as_array()[3];
        let faces = self.walls.faces().faces_at(index);
        if faces.is_empty() || mass <= self.mass_cutoff {
            return;
        }
        let inertia = self.inertia * mass;
        let (begun, mut end) = self.unconstrained_velocities(node, mass);
        let (mut start, mut rubbed, mut dragged) = (begun, [0.0; 3], 0.0);
        let mut tell = |bearer: Option<u8>, change: [f64; 3]| {
            if let Some(number) = bearer {
                (0..3).for_each(|c| impulses[usize::from(number)][c] -= inertia * change[c]);
            }
        };
        self.walls.constrain_and_record(
            index,
            &mut start,
            &mut end,
            self.keep_initial_velocity,
            &[0.0; 3],
            |face, change, kept| {
                // Points get the change from start to end, which includes the part removed from the start.
                tell(face.reaction_index, std::array::from_fn(|c| change[c] - kept[c]));
                let along: f64 = (0..3).map(|c| change[c] * face.normal[c]).sum();
                for c in 0..3 {
                    let rubs = change[c] - along * face.normal[c];
                    rubbed[c] += rubs;
                    dragged += inertia * rubs * face.velocity[c];
                    energies.work += inertia * (change[c] - kept[c]) * face.velocity[c];
                }
            },
        );
        let whole = (0..3).map(|c| 0.5 * inertia * rubbed[c] * (begun[c] + end[c])).sum::<f64>();
        energies.friction -= whole - dragged;
    }

    /// Velocity and acceleration of a node at the end of the step.
    fn solve_node(&self, index: &[usize; 3], node: &mut NodalState, mass: f64) {
        let (mut start, mut end) = self.unconstrained_velocities(node, mass);
        self.walls.constrain(index, &mut start, &mut end, self.keep_initial_velocity);
        node.momentum_and_mass = Vector4::new([end[0], end[1], end[2], mass]);
        let rate = |c: usize| (end[c] - start[c]) / self.dt;
        node.force = Vector4::new([rate(0), rate(1), rate(2), 0.0]);
    }
}

/// Velocity at the start of a step from its end value and change; zero if it is below round-off.
pub fn start_velocity(end: f64, change: f64) -> f64 {
    let start = end - change;
    if start.abs() <= 1e-12 * change.abs() { 0.0 } else { start }
}

/// Applies local damping to the components of a solved node that no wall constrains, in proportion to the total force (sheet: mpm §2.13).
pub fn damp(node: &mut NodalState, damping: &[f64; 3], constrained: [bool; 3], dt: f64) {
    let (mut end, mut rate) = (node.momentum_and_mass.to_array(), node.force.to_array());
    for c in (0..3).filter(|c| !constrained[*c]) {
        let start = start_velocity(end[c], dt * rate[c]);
        rate[c] -= damping[c] * rate[c].abs() * sign_or_zero(start);
        end[c] = start + dt * rate[c];
    }
    *node = NodalState { momentum_and_mass: Vector4::new(end), force: Vector4::new(rate) };
}

/// Evaluation of the measures of equilibrium from solved nodes (sheet: mpm §2.14).
pub struct EquilibriumAudit<'a, const D: usize> {
    /// Step (s).
    pub dt: f64,
    /// Gravity at the end of the step (m/s²).
    pub gravity: [f64; 3],
    /// Local damping factor of each axis.
    pub damping: [f64; 3],
    /// Mass-proportional Rayleigh damping (1/s).
    pub rayleigh: f64,
    /// Factor on the mass that gives the inertia (mass scaling).
    pub inertia: f64,
    /// Mass below which a node is skipped (kg).
    pub mass_cutoff: f64,
    /// Boundary conditions.
    pub walls: &'a NodeWalls,
    /// Arrangement of the nodes in memory.
    pub layout: &'a Layout<D>,
}

impl<const D: usize> EquilibriumAudit<'_, D> {
    /// Equilibrium sums of the active nodes of a row.
    pub fn row(&self, row: usize, active: Range<usize>, line: &[NodalState]) -> EquilibriumTerms {
        let mut sums = EquilibriumTerms::default();
        for number in active {
            let node = &line[number];
            let (end, rate) = (node.momentum_and_mass.to_array(), node.force.to_array());
            let mass = end[3];
            let index = self.layout.axis_indices(row, number);
            if mass <= self.mass_cutoff || self.layout.is_periodic_image(&index) {
                continue;
            }
            let free = self.walls.free_components(&index);
            for c in 0..D {
                let weight = mass * self.gravity[c];
                // Acceleration without its damping part.
                let start = start_velocity(end[c], self.dt * rate[c]);
                let net = self.inertia * mass * (rate[c] + self.rayleigh * 0.5 * (start + end[c]));
                let unbalanced =
                    free[c] * net / (1.0 - self.damping[c] * sign_or_zero(start) * sign_or_zero(net));
                sums.unbalanced += unbalanced * unbalanced;
                sums.external += weight * weight;
                sums.work += weight * end[c] * self.dt;
                sums.kinetic += 0.5 * self.inertia * mass * end[c] * end[c];
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use colluvium_grid::{Grid, LinearBasis};

    /// Largest speed over the one at the start in `steps` steps of one lumped element with free ends, in units in
    /// which length, density and modulus are 1 (sheet: mpm A-36).
    fn growth(dt: f64, steps: usize) -> f64 {
        let walls = NodeWalls::new(&[2], Vec::new());
        let layout = Layout::new::<2, LinearBasis>(&Grid::new([0.0], [1.0], 1.0).unwrap());
        let solve = MomentumSolve::<1> {
            dt,
            gravity: [0.0; 3],
            rayleigh: 0.0,
            keep_initial_velocity: false,
            inertia: 1.0,
            mass_cutoff: 0.0,
            walls: &walls,
            layout: &layout,
        };
        let (mut speeds, mut stress, mut largest) = ([1.0, -1.0], 0.0, 0f64);
        for _ in 0..steps {
            for (end, sign) in [(0, 1.0), (1, -1.0)] {
                let motion = Vector4::new([0.5 * speeds[end], 0.0, 0.0, 0.5]);
                let mut line = [NodalState {
                    momentum_and_mass: motion,
                    force: Vector4::new([sign * stress, 0.0, 0.0, 0.0]),
                }];
                solve.row(end, 0..1, &mut line);
                speeds[end] = line[0].momentum_and_mass.to_array()[0];
            }
            stress += dt * (speeds[1] - speeds[0]);
            largest = speeds.iter().fold(largest, |a, v| a.max(v.abs()));
        }
        largest
    }

    #[test]
    fn nodes_starting_from_rest_are_not_damped() {
        for change in [0.1, 0.3, 1e-7, -0.7] {
            for dt in [1e-3, 0.3, 1e-5] {
                let rate = change / dt;
                let mut node = NodalState {
                    momentum_and_mass: Vector4::new([dt * rate, 1.0, 0.0, 2.0]),
                    force: Vector4::new([rate, rate, rate, 0.0]),
                };
                damp(&mut node, &[0.7; 3], [false, false, true], dt);
                let (end, rates) = (node.momentum_and_mass.to_array(), node.force.to_array());
                assert_eq!((end[0], rates[0]), (dt * rate, rate), "from rest");
                let start = 1.0 - dt * rate;
                let damped = rate - 0.7 * rate.abs() * sign_or_zero(start);
                assert!(
                    (rates[1] - damped).abs() <= 1e-9 * rate.abs()
                        && (end[1] - start - dt * damped).abs() < 1e-12
                );
                assert_eq!((end[2], rates[2]), (0.0, rate), "held");
            }
        }
    }

    #[test]
    fn one_element_is_stable_up_to_its_length_over_the_speed_of_waves() {
        assert!(growth(0.95, 100_000) < 10.0);
        assert!(growth(1.05, 1000) > 1e6);
    }
}
