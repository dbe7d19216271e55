//! The momentum solve of liquid and mixture on the nodes (sheet: mpm §3.4, steps 2–4).

use std::ops::Range;

use colluvium_grid::{Layout, NodalState, NodeFace, NodeWalls, Vector4};
use serde::{Deserialize, Serialize};

use crate::momentum::EquilibriumTerms;
use crate::points::pore_fluid::{LIQUID, SOLID};

/// Sums over nodes for the equilibrium criterion of mixture and liquid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PhaseEquilibriumTerms {
    /// Terms of the mixture; work and kinetic energy are those of both phases.
    pub mixture: EquilibriumTerms,
    /// Terms of the liquid: its equation times the porosity.
    pub liquid: EquilibriumTerms,
}

impl PhaseEquilibriumTerms {
    /// Adds the sums of other nodes.
    pub fn add(&mut self, other: &Self) {
        self.mixture.add(&other.mixture);
        self.liquid.add(&other.liquid);
    }
}

/// Input of the momentum solve of both phases, like [`crate::momentum::MomentumSolve`] for one.
pub struct PhaseSolve<'a, const D: usize> {
    /// Step (s).
    pub dt: f64,
    /// Gravity at the end of the step (m/s²).
    pub gravity: [f64; 3],
    /// Whether constrained nodes keep their velocity at the start of the step.
    pub keep_initial_velocity: bool,
    /// Inertia over mass (mass scaling); weight and drag are not scaled.
    pub inertia: f64,
    /// Mass of each phase below which a node is skipped (kg).
    pub mass_cutoff: [f64; 2],
    /// Whether to sum the measures of equilibrium.
    pub sum_equilibrium: bool,
    /// Prescribed velocity components of all nodes, one bit per axis; empty if there are none.
    pub constrained_components: &'a [[u8; 2]],
    /// Boundary conditions of both phases.
    pub walls: [&'a NodeWalls; 2],
    /// Arrangement of the nodes in memory.
    pub layout: &'a Layout<D>,
}

/// Masses and drag of a node.
#[derive(Clone, Copy)]
pub(super) struct PhaseMasses {
    /// `M_S` (kg).
    pub solid: f64,
    /// `M̄_L` (kg).
    liquid: f64,
    /// `M_L` (kg).
    full_liquid: f64,
    /// `Q` (kg/s).
    drag: f64,
}

impl PhaseMasses {
    /// Returns masses and drag of a node before its solve.
    pub fn of_node(node: &[NodalState; 2]) -> Self {
        Self {
            solid: node[SOLID].momentum_and_mass.as_array()[3],
            liquid: node[LIQUID].momentum_and_mass.as_array()[3],
            full_liquid: node[LIQUID].force.as_array()[3],
            drag: node[SOLID].force.as_array()[3],
        }
    }
}

/// Contribution of the liquid of a node to the equation of the mixture.
#[derive(Clone, Copy, Default)]
struct LiquidContribution {
    /// `M̄_L a_L` (N).
    inertia_force: [f64; 3],
    /// Reaction of walls to the pore pressure, as a change of the skeleton's velocity (m/s).
    pore_pressure_part: [f64; 3],
}

/// Mask of the three spatial components.
const VECTOR: Vector4 = Vector4::new([1.0, 1.0, 1.0, 0.0]);

impl<const D: usize> PhaseSolve<'_, D> {
    /// Solves the momentum equations of both phases at the active nodes of a row: velocity at the end of the step and acceleration replace
    /// momentum and force.
    pub fn row(
        &self,
        row: usize,
        active: Range<usize>,
        line: &mut [[NodalState; 2]],
    ) -> PhaseEquilibriumTerms {
        let mut sums = PhaseEquilibriumTerms::default();
        let [gx, gy, gz] = self.gravity;
        let gravity = Vector4::new([gx, gy, gz, 0.0]);
        let plain = !self.sum_equilibrium;
        let free = |axis: usize, index: usize| self.walls.iter().all(|walls| walls.is_row_free(axis, index));
        let row_free = free(0, row);
        let line_length = self.layout.strides()[0];
        for number in active {
            let node = &mut line[number];
            let masses = PhaseMasses::of_node(node);
            if masses.solid <= self.mass_cutoff[SOLID] {
                // Too light for a meaningful force: the phase moves with the points around it.
                follow_points(&mut node[SOLID], masses.solid);
                follow_points(&mut node[LIQUID], masses.liquid);
                continue;
            }
            let index = self.layout.axis_indices(row, number);
            if plain && row_free && (1..D).all(|axis| free(axis, index[axis])) {
                self.free_node(node, &masses, gravity);
            } else {
                let constrained =
                    self.constrained_components.get(row * line_length + number).copied().unwrap_or_default();
                let mut repeated = PhaseEquilibriumTerms::default();
                let sums = if self.layout.is_periodic_image(&index) { &mut repeated } else { &mut sums };
                self.solve_node(&index, node, &masses, constrained, sums, |_, _, _| {});
            }
        }
        sums
    }

    /// Solves a node without walls and without measures of equilibrium.
    #[inline]
    fn free_node(&self, [solid, liquid]: &mut [NodalState; 2], masses: &PhaseMasses, gravity: Vector4) {
        let start = solid.momentum_and_mass * VECTOR * (1.0 / masses.solid);
        let mut weight = masses.solid;
        let mut inertia_force = Vector4::ZERO;
        if masses.liquid > self.mass_cutoff[LIQUID] {
            let of_liquid = liquid.momentum_and_mass * VECTOR * (1.0 / masses.liquid);
            let force = liquid.force - (of_liquid - start) * masses.drag;
            let acceleration = (force * VECTOR * (1.0 / masses.full_liquid) + gravity) * (1.0 / self.inertia);
            liquid.momentum_and_mass = with_mass(of_liquid + acceleration * self.dt, masses.liquid);
            liquid.force = acceleration;
            weight += masses.liquid;
            inertia_force = acceleration * (masses.liquid * self.inertia);
        } else {
            follow_points(liquid, masses.liquid);
        }
        let force = solid.force * VECTOR + gravity * weight - inertia_force;
        let acceleration = force * (1.0 / (masses.solid * self.inertia));
        solid.momentum_and_mass = with_mass(start + acceleration * self.dt, masses.solid);
        solid.force = acceleration;
    }

    /// Solves the momentum equations at a node with walls. `record` receives each change of the skeleton velocity by obstacles (m/s).
    pub(super) fn solve_node(
        &self,
        index: &[usize; 3],
        [solid, liquid]: &mut [NodalState; 2],
        masses: &PhaseMasses,
        constrained: [u8; 2],
        sums: &mut PhaseEquilibriumTerms,
        record: impl FnMut(&NodeFace, [f64; 3], [f64; 3]),
    ) {
        let has_faces = self.has_faces(index);
        let is_free = |phase: usize, c: usize| constrained[phase] & (1 << c) == 0;
        let wet = masses.liquid > self.mass_cutoff[LIQUID];
        let mut weight = masses.solid;
        let LiquidContribution { inertia_force, pore_pressure_part: pore_pressure_change } = if wet {
            weight += masses.liquid;
            let start = self.start(SOLID, index, solid, masses.solid);
            self.liquid(index, liquid, &start, masses, constrained[LIQUID], sums)
        } else {
            follow_points(liquid, masses.liquid);
            LiquidContribution::default()
        };
        // Mixture.
        let motion = solid.momentum_and_mass.to_array();
        let force = solid.force.to_array();
        let (mut from, mut to, mut total) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for c in 0..D {
            from[c] = motion[c] / masses.solid;
            total[c] = force[c] + weight * self.gravity[c];
            let force = total[c] - inertia_force[c];
            to[c] = from[c] + self.dt * force / (self.inertia * masses.solid);
        }
        let free = to;
        self.walls[SOLID].constrain_and_record(
            index,
            &mut from,
            &mut to,
            self.keep_initial_velocity,
            &pore_pressure_change,
            record,
        );
        if self.sum_equilibrium {
            let open = self.walls[SOLID].free_components(index);
            for c in 0..D {
                let (own, all) = (masses.solid * self.gravity[c], weight * self.gravity[c]);
                sums.mixture.external += all * all;
                if !is_free(SOLID, c) {
                    continue;
                }
                if has_faces {
                    let net = self.inertia * masses.solid * (to[c] - from[c]) / self.dt + inertia_force[c];
                    sums.mixture.unbalanced += (open[c] * net).powi(2);
                } else if to[c] == free[c] {
                    sums.mixture.unbalanced += total[c] * total[c];
                }
                sums.mixture.work += own * to[c] * self.dt;
                sums.mixture.kinetic += 0.5 * self.inertia * masses.solid * to[c] * to[c];
            }
        }
        self.set_result(solid, &from, &to, masses.solid);
    }

    /// Solves the liquid of a node, with the velocity of the skeleton at the `start` of the step (m/s).
    fn liquid(
        &self,
        index: &[usize; 3],
        node: &mut NodalState,
        start: &[f64; 3],
        masses: &PhaseMasses,
        constrained: u8,
        sums: &mut PhaseEquilibriumTerms,
    ) -> LiquidContribution {
        let has_faces = self.has_faces(index);
        let is_free = |c: usize| constrained & (1 << c) == 0;
        let LiquidContribution { mut inertia_force, pore_pressure_part: mut pore_pressure_change } =
            LiquidContribution::default();
        let mut from = self.start(LIQUID, index, node, masses.liquid);
        let force = node.force.to_array();
        let mut to = [0.0; 3];
        let mut unbalanced = [0.0; 3];
        for c in 0..D {
            let driving = force[c] + masses.full_liquid * self.gravity[c];
            unbalanced[c] = driving - masses.drag * (from[c] - start[c]);
            to[c] = from[c] + self.dt * unbalanced[c] / (self.inertia * masses.full_liquid);
        }
        let free = to;
        self.walls[LIQUID].constrain(index, &mut from, &mut to, self.keep_initial_velocity);
        let open = if has_faces { self.walls[LIQUID].free_components(index) } else { [1.0; 3] };
        let share = masses.liquid / masses.full_liquid;
        for c in 0..D {
            pore_pressure_change[c] = masses.full_liquid * (to[c] - free[c]) / masses.solid;
            inertia_force[c] = self.inertia * masses.liquid * (to[c] - from[c]) / self.dt;
            if self.sum_equilibrium {
                let own = masses.liquid * self.gravity[c];
                sums.liquid.external += own * own;
                if !is_free(c) {
                    continue;
                }
                if has_faces {
                    sums.liquid.unbalanced += (open[c] * inertia_force[c]).powi(2);
                } else if to[c] == free[c] {
                    sums.liquid.unbalanced += (share * unbalanced[c]).powi(2);
                }
                sums.mixture.work += own * to[c] * self.dt;
                sums.mixture.kinetic += 0.5 * self.inertia * masses.liquid * to[c] * to[c];
            }
        }
        self.set_result(node, &from, &to, masses.liquid);
        LiquidContribution { inertia_force, pore_pressure_part: pore_pressure_change }
    }

    /// Whether rigid geometry of any shape acts on a node.
    fn has_faces(&self, index: &[usize; 3]) -> bool {
        !self.walls[SOLID].faces().faces_at(index).is_empty()
    }

    /// Velocity of a phase at the start of the step (m/s), with the velocities that walls prescribe.
    fn start(&self, phase: usize, index: &[usize; 3], node: &NodalState, mass: f64) -> [f64; 3] {
        let motion = node.momentum_and_mass.to_array();
        let mut start: [f64; 3] = std::array::from_fn(|c| if c < D { motion[c] / mass } else { 0.0 });
        let mut end = start;
        self.walls[phase].constrain(index, &mut start, &mut end, self.keep_initial_velocity);
        start
    }

    /// Sets the velocity (m/s) and acceleration (m/s²) of a node from those at the start and the end of the step.
    fn set_result(&self, node: &mut NodalState, start: &[f64; 3], end: &[f64; 3], mass: f64) {
        let rate = |c: usize| (end[c] - start[c]) / self.dt;
        node.momentum_and_mass = Vector4::new([end[0], end[1], end[2], mass]);
        node.force = Vector4::new([rate(0), rate(1), rate(2), 0.0]);
    }
}

/// Velocity vector with the mass in its fourth component.
fn with_mass(velocity: Vector4, mass: f64) -> Vector4 {
    velocity + Vector4::new([0.0, 0.0, 0.0, mass])
}

/// Sets a phase whose mass is too small for forces to move with the points around it.
fn follow_points(node: &mut NodalState, mass: f64) {
    let inverse = if mass > 0.0 { 1.0 / mass } else { 0.0 };
    node.momentum_and_mass *= Vector4::new([inverse, inverse, inverse, 1.0]);
    node.force = Vector4::ZERO;
}

#[cfg(test)]
mod tests;
