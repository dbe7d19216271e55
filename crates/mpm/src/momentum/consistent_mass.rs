//! Consistent mass (GT eq. 3.9, Anura3D manual eq. 4.23; sheet: mpm §2.1): `M_ij = Σ_p m_p N_ip N_jp`.
//!
//! Velocities of nodes solve `M v = p` and accelerations `M a = f`, with the conjugate gradients preconditioned by the
//! diagonal of `M` (Jacobi), each component of the vectors by itself. `M` is never stored: `M x` is a sweep from nodes to
//! points and back. Components that a wall holds are the wall's, and have no equation.
//!
//! The rank of `M` is at most the number of points, so it may be singular where there are few, while the right side
//! `f`, unlike `p`, has a part that has no value at any point. The matrix of the system is therefore `(1 - θ) M + θ M_L` with the lumped
//! `M_L` and a small `θ`, the option `lumped_share` (the partly consistent matrix of Burgess, Sulsky & Brackbill 1992): it is
//! never singular, and has the row sums of both, so that momentum is conserved.

use colluvium_case::description::{Boundary, Wall};
use colluvium_case::loads::damping::{rayleigh_damped_velocity, sign_or_zero};
use colluvium_case::{Case, CaseError, SolverError};
use colluvium_constitutive::BLOCK_SIZE;
use colluvium_grid::{Layout, NodalState, NodeRange, NodeWalls, Vector4};

use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::config::{NodalMass, ShapeFunctions};
use crate::points::bodies::Bodies;
use crate::points::vectors::first_three;
use crate::{FixedNodes, MpmOptions, StressScheme, VelocityTransfer};
use colluvium_case::FailureReason;

/// Norm of the residual at convergence, relative to that of the right-hand side.
const TOLERANCE: f64 = 1e-12;
/// Maximum number of conjugate-gradient iterations.
const MAX_ITERATIONS: usize = 1000;

/// Data of the solves, by node; empty with lumped mass.
#[derive(Clone, Debug, Default)]
pub struct ConsistentMass {
    /// `Σ_p m_p N_ip²` (kg).
    mass_squares: Vec<f64>,
    /// One over the diagonal of the matrix, zero for components without an equation.
    inverse: Vec<Vector4>,
    velocity: Vec<Vector4>,
    acceleration: Vec<Vector4>,
    residual: Vec<Vector4>,
    direction: Vec<Vector4>,
    product: Vec<Vector4>,
    /// Sums of the rows of nodes.
    rows: Vec<Vector4>,
}

/// Rejects features that need the mass of single nodes.
pub fn check_supported(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    if options.mass == NodalMass::Lumped {
        return Ok(());
    }
    let refuse =
        |path: &str, problem: &str| Err(CaseError::new(path, format!("with mass consistent {problem}")));
    if options.stress_update != StressScheme::Usl {
        let problem = "only usl is available: the re-mapped velocity of musl equals the solved one";
        return refuse("methods.mpm.stress_update", problem);
    }
    if options.transfer != VelocityTransfer::Flip {
        return refuse("methods.mpm.transfer", "only flip (or a share of it) is available");
    }
    if options.fixed_nodes != FixedNodes::Force {
        return refuse("methods.mpm.fixed_nodes", "only force is available");
    }
    if options.mesh.is_some() {
        return refuse("methods.mpm.mesh", "a mesh is not available");
    }
    if options.points_per_cell < 2 {
        return refuse(
            "methods.mpm.points_per_cell",
            "at least 2 are needed: fewer leave the matrix singular",
        );
    }
    // The far node of a domain that reaches over a face by δ gets a mass of δ⁴ and a force of δ.
    let smallest = 3f64.powi(-(case.dimension() as i32));
    let gimp = matches!(options.shape, ShapeFunctions::Ugimp | ShapeFunctions::Cpgimp);
    if gimp && options.lumped_share < 0.9 * smallest {
        let problem = format!(
            "gimp needs {smallest:.3} or more, otherwise the acceleration of nodes of small mass is too large; \
             or use shape linear or quadratic"
        );
        return refuse("methods.mpm.lumped_share", &problem);
    }
    if !options.contacts.is_empty() {
        return refuse("methods.mpm.contacts", "contacts are not available");
    }
    let holds = |wall: &Boundary| matches!(wall.wall, Wall::Rough | Wall::Smooth) && !wall.separation;
    if let Some(number) = case.boundaries.iter().position(|boundary| !holds(boundary)) {
        let problem = "walls must be rough or smooth, without separation, because the system is linear";
        return refuse(&format!("boundaries[{number}].wall"), problem);
    }
    Ok(())
}

impl ConsistentMass {
    /// Size in memory (bytes).
    pub fn bytes(&self) -> usize {
        let vectors = [
            &self.inverse,
            &self.velocity,
            &self.acceleration,
            &self.residual,
            &self.direction,
            &self.product,
        ];
        vectors.map(|vector| size_of_val(&vector[..])).iter().sum::<usize>()
            + size_of_val(&self.mass_squares[..])
    }

    /// Returns empty arrays for the options.
    pub fn new<const D: usize>(options: &MpmOptions, layout: &Layout<D>) -> Self {
        if options.mass == NodalMass::Lumped {
            return Self::default();
        }
        let vectors = || vec![Vector4::ZERO; layout.len()];
        Self {
            mass_squares: vec![0.0; layout.len()],
            inverse: vectors(),
            velocity: vectors(),
            acceleration: vectors(),
            residual: vectors(),
            direction: vectors(),
            product: vectors(),
            rows: vec![Vector4::ZERO; layout.nodes()[0]],
        }
    }

    /// Whether mass is consistent.
    pub fn is_used(&self) -> bool {
        !self.mass_squares.is_empty()
    }

    /// Sets the entries of active nodes to zero.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        if !self.is_used() {
            return;
        }
        layout.reset(&mut self.mass_squares);
        for values in [
            &mut self.inverse,
            &mut self.velocity,
            &mut self.acceleration,
            &mut self.residual,
            &mut self.direction,
            &mut self.product,
        ] {
            layout.reset(values);
        }
    }
}

/// Sum over the active nodes, in their order, of the values of `of`, which may change the node.
fn sum_over<const D: usize>(
    layout: &Layout<D>,
    values: &mut [Vector4],
    rows: &mut [Vector4],
    of: &(dyn Fn(usize, &mut Vector4) -> Vector4 + Sync),
) -> Vector4 {
    let row_length = layout.strides()[0];
    layout.for_each_row(values, rows, |row, active, line| {
        let mut sum = Vector4::ZERO;
        for number in active {
            sum += of(row * row_length + number, &mut line[number]);
        }
        sum
    });
    rows.iter().fold(Vector4::ZERO, |sum, row| sum + *row)
}

/// Quotient `a / b` lane by lane, zero where the divisor is zero.
fn quotient(a: Vector4, b: Vector4) -> Vector4 {
    let (a, b) = (a.to_array(), b.to_array());
    Vector4::new(std::array::from_fn(|c| if b[c] > 0.0 { a[c] / b[c] } else { 0.0 }))
}

/// Arrays of a conjugate-gradient solve, by node.
struct ConjugateGradientSystem<'a> {
    solution: &'a mut [Vector4],
    residual: &'a mut [Vector4],
    direction: &'a mut [Vector4],
    product: &'a mut [Vector4],
    inverse: &'a [Vector4],
    rows: &'a mut [Vector4],
}

/// Solves for all components by conjugate gradients from the initial guess in `solution`. Components without an equation stay constant.
/// `multiply` applies the matrix, and `right` gives the right-hand side of a node. Returns whether the iteration has converged.
fn solve<const D: usize>(
    layout: &Layout<D>,
    system: ConjugateGradientSystem<'_>,
    multiply: &dyn Fn(&[Vector4], &mut [Vector4]),
    right: &(dyn Fn(usize) -> Vector4 + Sync),
) -> bool {
    let ConjugateGradientSystem { solution, residual, direction, product, inverse, rows } = system;
    multiply(solution, product);
    let scale = sum_over(layout, residual, rows, &|node, _| right(node) * right(node) * inverse[node]);
    let left = &*product;
    let mut squared = sum_over(layout, residual, rows, &|node, rest| {
        *rest = right(node) - left[node];
        *rest * *rest * inverse[node]
    });
    let rest = &*residual;
    sum_over(layout, direction, rows, &|node, along| {
        *along = rest[node] * inverse[node];
        Vector4::ZERO
    });
    // Norm of the right side, or of the contribution of the walls' motion.
    let (given, begun) = (scale.to_array(), squared.to_array());
    let scale: [f64; 4] = std::array::from_fn(|c| given[c].max(begun[c]));
    for _ in 0..MAX_ITERATIONS {
        let now = squared.to_array();
        if (0..4).all(|c| now[c] <= TOLERANCE * TOLERANCE * scale[c]) {
            return true;
        }
        multiply(direction, product);
        let along = &*direction;
        let stiffness = sum_over(layout, product, rows, &|node, product| along[node] * *product);
        let step = quotient(squared, stiffness);
        sum_over(layout, solution, rows, &|node, solution| {
            *solution += along[node] * step;
            Vector4::ZERO
        });
        let product = &*product;
        let next = sum_over(layout, residual, rows, &|node, rest| {
            *rest -= product[node] * step;
            *rest * *rest * inverse[node]
        });
        let turn = quotient(next, squared);
        let rest = &*residual;
        sum_over(layout, direction, rows, &|node, along| {
            *along = rest[node] * inverse[node] + *along * turn;
            Vector4::ZERO
        });
        squared = next;
    }
    false
}

/// Product `out = ((1 - θ) M + θ M_L) x`; the masses of the nodes are in their fourth lane.
fn multiply_mass<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    solved: &[NodalState],
    x: &[Vector4],
    out: &mut [Vector4],
) {
    let BackgroundGrid { layout, transfers, .. } = background;
    let (view, strides) = (background.grid_view(), layout.strides());
    let share = clock.options.lumped_share;
    let own = 1.0 - share;
    layout.reset(out);
    layout.for_each_slab(out, |slab, window, offset| {
        let mut all = [Vector4::ZERO; BLOCK_SIZE];
        for set in &bodies.sets {
            for block in set.blocks_of(slab) {
                let (points, values) = (set.point_slice().range(block.clone()), &mut all[..block.len()]);
                transfers.g2p_values(&view, &points, x, values);
                let masses = &set.points.mass[block];
                values.iter_mut().zip(masses).for_each(|(value, mass)| *value *= own * mass);
                let to = NodeRange { nodes: &mut *window, first: offset };
                transfers.p2g_values(&view, &points, to, values, None);
            }
        }
    });
    layout.for_each_active_node_range(out, |row, active, line| {
        for number in active {
            let node = row * strides[0] + number;
            line[number] += x[node] * (share * solved[node].momentum_and_mass.as_array()[3]);
        }
    });
}

/// Sums `Σ_p m_p N_ip²` (kg).
fn mass_squares<const D: usize>(background: &BackgroundGrid<D>, bodies: &Bodies<D>, squares: &mut [f64]) {
    let BackgroundGrid { layout, transfers, .. } = background;
    let view = background.grid_view();
    layout.reset(squares);
    layout.for_each_slab(squares, |slab, window, offset| {
        for set in &bodies.sets {
            let points = set.slabs[slab]..set.slabs[slab + 1];
            let to = NodeRange { nodes: &mut *window, first: offset };
            transfers.p2g_squared_weights(
                &view,
                &set.point_slice().range(points.clone()),
                to,
                &set.points.mass[points],
            );
        }
    });
}

/// Momentum equation with the consistent mass matrix (steps 2 to 4): velocity at the end of the step and acceleration of each node.
pub fn solve_momentum<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    solved: &mut [NodalState],
    walls: &NodeWalls,
    mass: &mut ConsistentMass,
) -> Result<(), SolverError> {
    mass_squares(background, bodies, &mut mass.mass_squares);
    let system = ConsistentSystem { clock, background, bodies, nodes: solved, walls };
    system.set_initial_guess(mass);
    if !(system.solve_velocities(mass) && system.solve_accelerations(mass)) {
        return Err(clock.step_error(FailureReason::coded("not-converged", format!(
            "the system of the consistent mass matrix has not converged in {MAX_ITERATIONS} iterations: use mass \
             lumped, or more points per cell"
        ))));
    }
    set_end_state(clock, &background.layout, solved, mass);
    Ok(())
}

/// Systems of equations of a step with the consistent mass matrix.
struct ConsistentSystem<'a, const D: usize> {
    clock: &'a Clock,
    background: &'a BackgroundGrid<D>,
    bodies: &'a Bodies<D>,
    /// Nodes with momentum, lumped mass and force.
    nodes: &'a [NodalState],
    walls: &'a NodeWalls,
}

impl<const D: usize> ConsistentSystem<'_, D> {
    /// Sets the initial guess of the velocities, the prescribed components, and the inverse diagonal of the matrix (step 2).
    fn set_initial_guess(&self, mass: &mut ConsistentMass) {
        let (layout, nodes) = (&self.background.layout, self.nodes);
        let row_length = layout.strides()[0];
        let ConsistentMass { mass_squares: squares, inverse, velocity, rows, .. } = mass;
        let lumped_velocity = |node: usize| -> [f64; 3] {
            let lumped = nodes[node].momentum_and_mass.as_array()[3];
            first_three(nodes[node].momentum_and_mass).map(|p| if lumped > 0.0 { p / lumped } else { 0.0 })
        };
        sum_over(layout, velocity, rows, &|node, velocity| {
            let mut start = lumped_velocity(node);
            let index = layout.axis_indices(node / row_length, node % row_length);
            self.walls.constrain(&index, &mut start, &mut [0.0; 3], false);
            *velocity = Vector4::new([start[0], start[1], start[2], 0.0]);
            Vector4::ZERO
        });
        let (cutoff, share) = (self.bodies.mass_cutoff(self.clock), self.clock.options.lumped_share);
        sum_over(layout, inverse, rows, &|node, inverse| {
            let lumped = nodes[node].momentum_and_mass.as_array()[3];
            let index = layout.axis_indices(node / row_length, node % row_length);
            let diagonal = (1.0 - share) * squares[node] + share * lumped;
            let own = if lumped > cutoff { 1.0 / diagonal } else { 0.0 };
            let [x, y, z] = self.walls.free_components(&index);
            let in_space = |axis: usize| if axis < D { own } else { 0.0 };
            *inverse = Vector4::new([x * in_space(0), y * in_space(1), z * in_space(2), 0.0]);
            Vector4::ZERO
        });
    }

    /// Product of the consistent mass matrix with a nodal vector.
    fn multiply(&self, x: &[Vector4], out: &mut [Vector4]) {
        multiply_mass(self.clock, self.background, self.bodies, self.nodes, x, out);
    }

    /// Solves for the velocities at the start of the step (step 2); returns whether the iteration has converged.
    fn solve_velocities(&self, mass: &mut ConsistentMass) -> bool {
        /// Factor that keeps the three spatial components of a nodal vector and sets the fourth, the mass, to zero.
        const SPATIAL: Vector4 = Vector4::new([1.0, 1.0, 1.0, 0.0]);
        let ConsistentMass { inverse, velocity, residual, direction, product, rows, .. } = mass;
        let system =
            ConjugateGradientSystem { solution: velocity, residual, direction, product, inverse, rows };
        solve(&self.background.layout, system, &|x, out| self.multiply(x, out), &|node| {
            self.nodes[node].momentum_and_mass * SPATIAL
        })
    }

    /// Solves for the accelerations (step 3); returns whether the iteration has converged.
    fn solve_accelerations(&self, mass: &mut ConsistentMass) -> bool {
        let (layout, clock, nodes) = (&self.background.layout, self.clock, self.nodes);
        let ConsistentMass { inverse, velocity, acceleration, residual, direction, product, rows, .. } = mass;
        let (damping, scaling) = (clock.stage().damping_of_axes(), clock.options.mass_scaling);
        let (gravity, velocity) = (clock.gravity_at_end(), &*velocity);
        let force = |node: usize| -> Vector4 {
            let (force, lumped) = (nodes[node].force.to_array(), nodes[node].momentum_and_mass.as_array()[3]);
            let start = velocity[node].to_array();
            let along = |c: usize| {
                let total = force[c] + lumped * gravity[c];
                (total - damping[c] * total.abs() * sign_or_zero(start[c])) / scaling
            };
            Vector4::new([along(0), along(1), along(2), 0.0])
        };
        sum_over(layout, acceleration, rows, &|_, acceleration| {
            *acceleration = Vector4::ZERO;
            Vector4::ZERO
        });
        let system =
            ConjugateGradientSystem { solution: acceleration, residual, direction, product, inverse, rows };
        solve(layout, system, &|x, out| self.multiply(x, out), &force)
    }
}

/// Computes velocities at the end of the step and accelerations of the nodes, with Rayleigh damping (step 4).
fn set_end_state<const D: usize>(
    clock: &Clock,
    layout: &Layout<D>,
    solved: &mut [NodalState],
    mass: &ConsistentMass,
) {
    let ConsistentMass { inverse, velocity, acceleration, .. } = mass;
    let (dt, rayleigh) = (clock.dt, clock.stage().rayleigh_damping * clock.dt);
    let row_length = layout.strides()[0];
    layout.for_each_active_node_range(solved, |row, active, line| {
        for number in active {
            let node = row * row_length + number;
            let (start, rate) = (velocity[node].to_array(), acceleration[node].to_array());
            let lumped = line[number].momentum_and_mass.as_array()[3];
            let is_free = inverse[node].to_array().map(|inverse| inverse > 0.0);
            let mut end: [f64; 4] = std::array::from_fn(|c| start[c] + dt * rate[c]);
            for c in (0..3).filter(|c| rayleigh > 0.0 && is_free[*c]) {
                end[c] = rayleigh_damped_velocity(start[c], end[c], rayleigh);
            }
            let rate = |c: usize| (end[c] - start[c]) / dt;
            line[number] = NodalState {
                momentum_and_mass: Vector4::new([end[0], end[1], end[2], lumped]),
                force: Vector4::new([rate(0), rate(1), rate(2), 0.0]),
            };
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::tests::initial_solver;

    /// The rows of the matrix sum to the lumped masses, and it is symmetric.
    fn sums(shape: &str) {
        let text = serde_json::json!({
            "title": "ball", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 7, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.5, 0.45], "radius": 0.3 } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 0.1, "shape": shape, "stress_update": "usl", "mass": "consistent",
                                  "lumped_share": 0.2 } }
        });
        let case = Case::from_json(&text.to_string()).unwrap();
        let mut solver = initial_solver::<2>(&case);
        solver.p2g_for_tests();
        let count = solver.background.layout.len();
        let mut out = vec![Vector4::ZERO; count];
        let times = |x: &[Vector4], out: &mut [Vector4]| {
            multiply_mass(
                &solver.clock,
                &solver.background,
                &solver.bodies,
                &solver.nodes.nodal_states,
                x,
                out,
            );
        };
        times(&vec![Vector4::ONE; count], &mut out);
        let mut total = 0.0;
        for (node, row) in solver.nodes.nodal_states.iter().zip(&out) {
            let lumped = node.momentum_and_mass.as_array()[3];
            total += lumped;
            assert!(
                row.to_array().iter().all(|sum| (sum - lumped).abs() < 1e-14),
                "{shape}: {row:?}, {lumped}"
            );
        }
        assert!(total > 1.0);
        let wave = |phase: f64| -> Vec<Vector4> {
            (0..count).map(|n| Vector4::splat((n as f64 * 1.3 + phase).sin())).collect()
        };
        let mut product = |x: &[Vector4], y: &[Vector4]| -> f64 {
            times(x, &mut out);
            out.iter().zip(y).map(|(a, b)| a.as_array()[0] * b.as_array()[0]).sum()
        };
        let (x, y) = (wave(0.0), wave(0.7));
        assert!((product(&x, &y) - product(&y, &x)).abs() < 1e-13 && product(&x, &x) > 0.0, "{shape}");
    }

    #[test]
    fn rows_of_the_matrix_sum_to_the_lumped_mass() {
        sums("linear");
        sums("ugimp");
    }
}
