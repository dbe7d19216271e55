//! Local damping of both phases (sheet: mpm §2.13). It depends on the unbalanced force on the mixture. Reactions of walls, obstacles and
//! patches are in balance, so that damping follows them; drag only passes from one phase to the other.

use std::ops::Range;

use colluvium_case::loads::damping::sign_or_zero;
use colluvium_grid::{Layout, NodalState, NodeWalls, Vector4};

use crate::momentum::start_velocity;
use crate::points::pore_fluid::{LIQUID, SOLID};

/// Local damping of the nodes in a step.
pub(super) struct Damping<'a, const D: usize> {
    /// Step (s).
    pub dt: f64,
    /// Local damping factor of each axis.
    pub factors: [f64; 3],
    /// Mass of each phase below which a node is skipped (kg).
    pub mass_cutoff: [f64; 2],
    /// Prescribed velocity components of all nodes, one bit per axis; empty if there are none.
    pub constrained_components: &'a [[u8; 2]],
    /// Boundary conditions of both phases.
    pub walls: [&'a NodeWalls; 2],
    /// Arrangement of the nodes in memory.
    pub layout: &'a Layout<D>,
}

impl<const D: usize> Damping<'_, D> {
    /// Damps the solved active nodes of a row.
    pub fn row(&self, row: usize, active: Range<usize>, line: &mut [[NodalState; 2]]) {
        let first = row * self.layout.strides()[0];
        for number in active {
            let node = &mut line[number];
            if node[SOLID].momentum_and_mass.as_array()[3] <= self.mass_cutoff[SOLID] {
                continue;
            }
            let index = self.layout.axis_indices(row, number);
            let constrained = self.constrained_components.get(first + number).copied().unwrap_or_default();
            self.damp_node(&index, node, constrained);
        }
    }

    /// Damping of both phases at a node.
    fn damp_node(&self, index: &[usize; 3], node: &mut [NodalState; 2], constrained: [u8; 2]) {
        let mut ends = [SOLID, LIQUID].map(|phase| node[phase].momentum_and_mass.to_array());
        let mut rates = [SOLID, LIQUID].map(|phase| node[phase].force.to_array());
        let masses = ends.map(|end| end[3]);
        let by_walls = [SOLID, LIQUID]
            .map(|phase| self.walls[phase].constrained_components(index, &[0, 1, 2].map(|c| ends[phase][c])));
        let is_free = |phase: usize, c: usize| !by_walls[phase][c] && constrained[phase] & (1 << c) == 0;
        for c in (0..D).filter(|c| is_free(SOLID, *c)) {
            let moves = [true, masses[LIQUID] > self.mass_cutoff[LIQUID] && is_free(LIQUID, c)];
            let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
                let phases = [SOLID, LIQUID].into_iter().filter(|phase| moves[*phase]);
                phases.map(|phase| masses[phase] * of(phase)).sum()
            };
            let starts =
                [SOLID, LIQUID].map(|phase| start_velocity(ends[phase][c], self.dt * rates[phase][c]));
            let (mass, force) = (sum(&|_| 1.0), sum(&|phase| rates[phase][c]));
            let change = -self.factors[c] * force.abs() / mass * sign_or_zero(sum(&|phase| starts[phase]));
            for phase in [SOLID, LIQUID].into_iter().filter(|phase| moves[*phase]) {
                rates[phase][c] += change;
                ends[phase][c] = starts[phase] + self.dt * rates[phase][c];
            }
        }
        for phase in [SOLID, LIQUID] {
            node[phase].momentum_and_mass = Vector4::new(ends[phase]);
            node[phase].force = Vector4::new(rates[phase]);
        }
    }
}
