//! Local damping of both phases (sheet: mpm §2.13). It goes by the forces out of balance, without drag: what walls, obstacles and
//! patches bear is in balance with them, and so it comes after these.

use std::ops::Range;

use colluvium_case::damping::sign;
use colluvium_grid::{Lanes, Layout, Node, Walls};

use super::momentum::Masses;
use crate::momentum::before;
use crate::pore::{LIQUID, SOLID};

/// Mass of the liquid as if it filled the node (kg) and drag (kg/s), which the solve puts accelerations in the place of.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Coupling {
    full: f64,
    drag: f64,
}

impl Coupling {
    /// Of a node that is not solved yet.
    pub fn of(node: &[Node; 2]) -> Self {
        let Masses { full, drag, .. } = Masses::of(node);
        Self { full, drag }
    }
}

/// What damps the nodes of a step.
pub(super) struct Damping<'a, const D: usize> {
    /// Step (s).
    pub dt: f64,
    /// Local damping factor of each axis.
    pub factors: [f64; 3],
    /// Inertia over mass.
    pub inertia: f64,
    /// Nodes with less mass of a phase than this (kg) are skipped.
    pub light: [f64; 2],
    /// Components of velocity that are prescribed, of all nodes, one bit an axis; empty where none are.
    pub held: &'a [[u8; 2]],
    /// Boundary conditions of both phases.
    pub walls: [&'a Walls; 2],
    /// The nodes.
    pub layout: &'a Layout<D>,
    /// What the solve has overwritten, node by node.
    pub couplings: &'a [Coupling],
}

impl<const D: usize> Damping<'_, D> {
    /// Damps the solved active nodes of a row.
    pub fn row(&self, row: usize, active: Range<usize>, line: &mut [[Node; 2]]) {
        let first = row * self.layout.strides()[0];
        for number in active {
            let node = &mut line[number];
            if node[SOLID].motion.as_array()[3] <= self.light[SOLID] {
                continue;
            }
            let index = self.layout.index(row, number);
            let held = self.held.get(first + number).copied().unwrap_or_default();
            self.node(&index, node, held, self.couplings[first + number]);
        }
    }

    fn node(
        &self,
        index: &[usize; 3],
        node: &mut [Node; 2],
        held: [u8; 2],
        Coupling { full, drag }: Coupling,
    ) {
        let ends = [SOLID, LIQUID].map(|phase| node[phase].motion.to_array());
        let mut rates = [SOLID, LIQUID].map(|phase| node[phase].force.to_array());
        let starts = [SOLID, LIQUID].map(|phase| -> [f64; 3] {
            std::array::from_fn(|c| before(ends[phase][c], self.dt * rates[phase][c]))
        });
        let [solid, liquid] = ends.map(|end| end[3]);
        let wet = liquid > self.light[LIQUID];
        let share = if wet { liquid / full } else { 0.0 };
        let inertias = [self.inertia * solid, self.inertia * full];
        for phase in [SOLID, LIQUID].into_iter().filter(|phase| *phase == SOLID || wet) {
            let end = &ends[phase];
            let by_walls = self.walls[phase].holding(index, &[end[0], end[1], end[2]]);
            for c in (0..D).filter(|c| !by_walls[*c] && held[phase] & (1 << c) == 0) {
                let pulls = if wet { drag * (starts[LIQUID][c] - starts[SOLID][c]) } else { 0.0 };
                // Drag pulls the skeleton along by the share of the liquid, and slows that.
                let without = if phase == SOLID { -share * pulls } else { pulls };
                let force = inertias[phase] * rates[phase][c] + without;
                rates[phase][c] -= self.factors[c] * force.abs() * sign(starts[phase][c]) / inertias[phase];
            }
            let [x, y, z] = std::array::from_fn(|c| {
                if c < D { starts[phase][c] + self.dt * rates[phase][c] } else { end[c] }
            });
            node[phase].motion = Lanes::new([x, y, z, end[3]]);
            node[phase].force = Lanes::new(rates[phase]);
        }
    }
}
