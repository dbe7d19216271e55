//! Nodal momentum equation with damping and walls (sheet: snow-mpm §3.5, steps 2 and 3), and its energy terms.

pub(crate) mod body_force;

use std::ops::Range;

use colluvium_grid::{Layout, NodalState, NodeWalls, Vector4};
use colluvium_points::surface::cross;
use serde::{Deserialize, Serialize};

use crate::background_grid::BackgroundGrid;
use crate::obstacles::node_obstacles::MAX_RECORDED;

/// Sums over the nodes in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MomentumTerms {
    /// Work of gravity in the step (J).
    pub gravity: f64,
    /// Work of the impulses of walls on the nodes (J).
    pub boundary: f64,
    /// Work of damping on the nodes (J).
    pub damping: f64,
    /// Kinetic energy of the nodes (J).
    pub kinetic: f64,
    /// Increase of the kinetic energy of the nodes in the step (J).
    pub kinetic_gain: f64,
    /// Square of the unbalanced force (N²).
    pub unbalanced: f64,
    /// Square of the weight (N²).
    pub weight: f64,
    /// Frictional dissipation at obstacles, from the velocity relative to the obstacle (J).
    pub friction: f64,
    /// Impulses on the recorded obstacles (N s).
    pub impulses: [[f64; 3]; MAX_RECORDED],
    /// Moments of the impulses about the origin of coordinates (N m s).
    pub moments: [[f64; 3]; MAX_RECORDED],
}

impl MomentumTerms {
    /// Adds the sums of other nodes.
    pub fn add(&mut self, other: &Self) {
        self.gravity += other.gravity;
        self.boundary += other.boundary;
        self.damping += other.damping;
        self.kinetic += other.kinetic;
        self.kinetic_gain += other.kinetic_gain;
        self.unbalanced += other.unbalanced;
        self.weight += other.weight;
        self.friction += other.friction;
        for (own, other) in [(&mut self.impulses, &other.impulses), (&mut self.moments, &other.moments)] {
            own.as_flattened_mut()
                .iter_mut()
                .zip(other.as_flattened())
                .for_each(|(own, other)| *own += other);
        }
    }
}

/// Nodal momenta, forces and masses of the grid.
pub struct GridNodes {
    /// State of the nodes.
    pub nodes: Vec<NodalState>,
    rows: Vec<MomentumTerms>,
}

/// Parameters of the momentum equation of a step.
pub struct MomentumSolve<'a, const D: usize> {
    /// Step (s).
    pub dt: f64,
    /// Gravity at the end of the step (m/s²).
    pub gravity: [f64; 3],
    /// Local damping coefficient of each axis.
    pub damping: [f64; 3],
    /// Mass (kg) up to which nodes have no force.
    pub mass_cutoff: f64,
    /// Walls.
    pub walls: &'a NodeWalls,
    /// Positions and order of the nodes.
    pub background: &'a BackgroundGrid<D>,
}

impl GridNodes {
    /// Nodes of a grid, without mass and momentum.
    pub fn new<const D: usize>(layout: &Layout<D>) -> Self {
        Self {
            nodes: vec![NodalState::default(); layout.len()],
            rows: vec![MomentumTerms::default(); layout.nodes()[0]],
        }
    }

    /// Sets the active nodes to zero.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        layout.reset(&mut self.nodes);
    }

    /// Solves the momentum equation of the active nodes: velocity at the end of the step and acceleration replace momentum and force.
    pub fn solve<const D: usize>(&mut self, momentum: &MomentumSolve<'_, D>) -> MomentumTerms {
        momentum.background.layout.for_each_row(&mut self.nodes, &mut self.rows, |row, active, line| {
            momentum.solve_row(row, active, line)
        });
        let mut sums = MomentumTerms::default();
        self.rows.iter().for_each(|row| sums.add(row));
        sums
    }

    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.rows[..])
    }
}

impl<const D: usize> MomentumSolve<'_, D> {
    /// Solves the momentum equation at the active nodes of a row of the grid and sums the terms of the energy balance.
    fn solve_row(&self, row: usize, active: Range<usize>, line: &mut [NodalState]) -> MomentumTerms {
        let mut sums = MomentumTerms::default();
        let row_free = self.walls.is_row_free(0, row);
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
            let index = self.background.layout.axis_indices(row, number);
            let free = row_free && (1..D).all(|axis| self.walls.is_row_free(axis, index[axis]));
            if self.background.is_periodic_image(&index) {
                self.solve_node(&index, free, node, mass, &mut MomentumTerms::default());
                continue;
            }
            self.solve_node(&index, free, node, mass, &mut sums);
        }
        sums
    }

    /// Velocity and acceleration of a node at the end of the step.
    #[inline(always)]
    fn solve_node(
        &self,
        index: &[usize; 3],
        free: bool,
        node: &mut NodalState,
        mass: f64,
        sums: &mut MomentumTerms,
    ) {
        let (motion, force) = (node.momentum_and_mass.to_array(), node.force.to_array());
        let (mut start, mut end, mut slowed) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for c in 0..D {
            start[c] = motion[c] / mass;
            let total = force[c] + mass * self.gravity[c];
            let undamped = start[c] + self.dt * total / mass;
            end[c] = undamped;
            if self.damping[c] > 0.0 && start[c] != 0.0 {
                // Sheet: snow-mpm §3.12.
                let kept = total - self.damping[c] * total.abs() * start[c].signum();
                end[c] = start[c] + self.dt * kept / mass;
                slowed[c] = end[c] - undamped;
            }
            sums.weight += (mass * self.gravity[c]).powi(2);
        }
        let before = end;
        if !free {
            self.constrain(index, mass, &start, &mut end, sums);
        }
        let rate: [f64; 3] = std::array::from_fn(|c| (end[c] - start[c]) / self.dt);
        for c in 0..D {
            // The work of impulses uses the mean of the velocities before and after.
            let mean = 0.5 * mass * (start[c] + end[c]);
            sums.boundary += mean * (end[c] - before[c]);
            sums.damping += mean * slowed[c];
            sums.gravity += mass * self.gravity[c] * end[c] * self.dt;
            sums.kinetic += 0.5 * mass * end[c] * end[c];
            sums.kinetic_gain += mean * (end[c] - start[c]);
            sums.unbalanced += (mass * rate[c]).powi(2);
        }
        node.momentum_and_mass = Vector4::new([end[0], end[1], end[2], mass]);
        node.force = Vector4::new([rate[0], rate[1], rate[2], 0.0]);
    }

    /// Constrains the velocity of a node by walls and obstacles, and records their impulses, moments and friction.
    #[inline(always)]
    fn constrain(
        &self,
        index: &[usize; 3],
        mass: f64,
        start: &[f64; 3],
        end: &mut [f64; 3],
        sums: &mut MomentumTerms,
    ) {
        let mut initial = *start;
        // Change of velocity by obstacles along their surface, and its product with their velocities.
        let (mut sliding, mut carried) = ([0.0; 3], 0.0);
        // Velocities at the start are those from the points (sheet: snow-mpm §3.5, note iii).
        self.walls.constrain_and_record(index, &mut initial, end, true, &[0.0; 3], |face, change, _| {
            if let Some(number) = face.reaction_index {
                let (number, place) = (usize::from(number), self.background.node_position(index));
                for c in 0..D {
                    sums.impulses[number][c] -= mass * change[c];
                }
                let turn = cross(&place, &change);
                (0..3).for_each(|c| sums.moments[number][c] -= mass * turn[c]);
            }
            let across: f64 = (0..3).map(|c| change[c] * face.normal[c]).sum();
            for c in 0..3 {
                let along = change[c] - across * face.normal[c];
                sliding[c] += along;
                carried += along * face.velocity[c];
            }
        });
        let slipped: f64 = (0..D).map(|c| 0.5 * sliding[c] * (start[c] + end[c])).sum();
        sums.friction -= mass * (slipped - carried);
    }
}
