//! Textbook implementation of the material point method for comparisons of speed: an array of structs, plain loops over the points and
//! their nodes, one thread, nothing sorted, nothing fused. USL, linear elasticity with the Jaumann rate, linear shape functions or
//! quadratic B-splines.

/// Shape functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextbookShape {
    /// Hat functions.
    Linear,
    /// Quadratic B-splines, without modification at the ends.
    Quadratic,
}

/// Problem of a block that settles on a rough floor: edge 1 m, two points per cell and direction.
#[derive(Clone, Copy, Debug)]
pub struct TextbookProblem {
    /// Number of cells along an edge of the block.
    pub cells: usize,
    /// Shape functions.
    pub shape: TextbookShape,
    /// Density of the block (kg/m³).
    pub density: f64,
    /// Young's modulus (Pa).
    pub youngs_modulus: f64,
    /// Poisson's ratio of the block.
    pub poissons_ratio: f64,
    /// Gravity along the second axis (m/s²).
    pub gravity: f64,
}

/// Material point of the textbook solver.
#[derive(Clone, Copy, Debug)]
pub struct TextbookPoint<const D: usize> {
    /// Position of the point (m).
    pub position: [f64; D],
    /// Velocity of the point (m/s).
    pub velocity: [f64; D],
    mass: f64,
    volume: f64,
    stress: [[f64; 3]; 3],
}

impl<const D: usize> TextbookPoint<D> {
    /// Adds the stress of a displacement gradient: linear elasticity with the Jaumann rate.
    #[inline]
    fn update_stress(&mut self, gradient: &[[f64; 3]; 3], lame: f64, shear: f64) {
        let trace = gradient[0][0] + gradient[1][1] + gradient[2][2];
        let old = self.stress;
        for a in 0..3 {
            for b in 0..3 {
                let mut change = shear * (gradient[a][b] + gradient[b][a]);
                if a == b {
                    change += lame * trace;
                }
                for c in 0..3 {
                    let spin = |i: usize, j: usize| 0.5 * (gradient[i][j] - gradient[j][i]);
                    change += spin(a, c) * old[c][b] - old[a][c] * spin(c, b);
                }
                self.stress[a][b] += change;
            }
        }
        self.volume *= 1.0 + trace;
    }
}

/// Node of the grid.
#[derive(Clone, Copy, Debug)]
struct TextbookNode<const D: usize> {
    mass: f64,
    momentum: [f64; D],
    force: [f64; D],
}

/// Weights and gradients of the nodes at a point.
struct TextbookWeights<const D: usize> {
    count: usize,
    node: [usize; 27],
    value: [f64; 27],
    gradient: [[f64; D]; 27],
}

/// Solver of the textbook method.
pub struct TextbookSolver<const D: usize> {
    problem: TextbookProblem,
    /// Material points.
    pub points: Vec<TextbookPoint<D>>,
    nodes: Vec<TextbookNode<D>>,
    width: usize,
    cell: f64,
}

/// Number of layers of cells around the block. The floor is the node of this number along the second axis.
const MARGIN: usize = 4;

impl<const D: usize> TextbookSolver<D> {
    /// Solver of a problem, with points at rest and without stress.
    pub fn new(problem: TextbookProblem) -> Self {
        let cell = 1.0 / problem.cells as f64;
        let per_axis = 2 * problem.cells;
        let spacing = 0.5 * cell;
        let place = |number: usize| {
            let mut rest = number;
            let mut position = [0.0; D];
            for axis in (0..D).rev() {
                position[axis] = ((rest % per_axis) as f64 + 0.5) * spacing;
                rest /= per_axis;
            }
            position
        };
        let volume = spacing.powi(D as i32);
        let point = |number: usize| TextbookPoint {
            position: place(number),
            velocity: [0.0; D],
            mass: problem.density * volume,
            volume,
            stress: [[0.0; 3]; 3],
        };
        let width = problem.cells + 2 * MARGIN + 1;
        let node = TextbookNode { mass: 0.0, momentum: [0.0; D], force: [0.0; D] };
        Self {
            problem,
            points: (0..per_axis.pow(D as u32)).map(point).collect(),
            nodes: vec![node; width.pow(D as u32)],
            width,
            cell,
        }
    }

    /// Weights and gradients of the nodes around a position.
    fn weights(&self, position: &[f64; D]) -> TextbookWeights<D> {
        let mut first = [0; D];
        let mut value = [[0.0; 3]; D];
        let mut slope = [[0.0; 3]; D];
        let per_axis = if self.problem.shape == TextbookShape::Linear { 2 } else { 3 };
        for axis in 0..D {
            let x = position[axis] / self.cell + MARGIN as f64;
            if self.problem.shape == TextbookShape::Linear {
                first[axis] = x as usize;
                let s = x - first[axis] as f64;
                value[axis] = [1.0 - s, s, 0.0];
                slope[axis] = [-1.0 / self.cell, 1.0 / self.cell, 0.0];
            } else {
                first[axis] = (x - 0.5) as usize;
                let s = x - first[axis] as f64;
                value[axis] = [0.5 * (1.5 - s).powi(2), 0.75 - (s - 1.0).powi(2), 0.5 * (s - 0.5).powi(2)];
                slope[axis] = [(s - 1.5) / self.cell, -2.0 * (s - 1.0) / self.cell, (s - 0.5) / self.cell];
            }
        }
        let mut weights =
            TextbookWeights { count: 0, node: [0; 27], value: [0.0; 27], gradient: [[0.0; D]; 27] };
        let last = if D == 3 { per_axis } else { 1 };
        for i in 0..per_axis {
            for j in 0..per_axis {
                for k in 0..last {
                    let index = [i, j, k];
                    let n = weights.count;
                    weights.count += 1;
                    let mut node = 0;
                    let mut product = 1.0;
                    for axis in 0..D {
                        node = node * self.width + first[axis] + index[axis];
                        product *= value[axis][index[axis]];
                    }
                    weights.node[n] = node;
                    weights.value[n] = product;
                    for axis in 0..D {
                        let mut gradient = slope[axis][index[axis]];
                        for other in 0..D {
                            if other != axis {
                                gradient *= value[other][index[other]];
                            }
                        }
                        weights.gradient[n][axis] = gradient;
                    }
                }
            }
        }
        weights
    }

    /// Makes one step of `dt` (s).
    pub fn step(&mut self, dt: f64) {
        for node in &mut self.nodes {
            *node = TextbookNode { mass: 0.0, momentum: [0.0; D], force: [0.0; D] };
        }
        self.particle_to_grid();
        self.update_momentum(dt);
        self.grid_to_particle(dt);
    }

    /// Sums mass, momentum and force of the points at the nodes.
    fn particle_to_grid(&mut self) {
        for p in 0..self.points.len() {
            let point = self.points[p];
            let weights = self.weights(&point.position);
            for n in 0..weights.count {
                let node = &mut self.nodes[weights.node[n]];
                node.mass += weights.value[n] * point.mass;
                for a in 0..D {
                    node.momentum[a] += weights.value[n] * point.mass * point.velocity[a];
                    for b in 0..D {
                        node.force[a] -= point.volume * point.stress[a][b] * weights.gradient[n][b];
                    }
                }
                node.force[1] += weights.value[n] * point.mass * self.problem.gravity;
            }
        }
    }

    /// Divides momenta and forces of the nodes by their masses, and applies the floor. Afterwards `momentum` is the velocity and `force`
    /// the acceleration.
    fn update_momentum(&mut self, dt: f64) {
        for number in 0..self.nodes.len() {
            let height = if D == 3 { number / self.width % self.width } else { number % self.width };
            let node = &mut self.nodes[number];
            if node.mass > 1e-12 * self.points[0].mass {
                for a in 0..D {
                    node.force[a] /= node.mass;
                    node.momentum[a] = node.momentum[a] / node.mass + dt * node.force[a];
                }
            }
            if height <= MARGIN {
                node.momentum = [0.0; D];
                node.force = [0.0; D];
            }
        }
    }

    /// Updates velocities, positions and stresses of the points from the nodes.
    fn grid_to_particle(&mut self, dt: f64) {
        let (e, nu) = (self.problem.youngs_modulus, self.problem.poissons_ratio);
        let lame = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        let shear = 0.5 * e / (1.0 + nu);
        for p in 0..self.points.len() {
            let weights = self.weights(&self.points[p].position);
            let point = &mut self.points[p];
            let mut gradient = [[0.0; 3]; 3];
            for n in 0..weights.count {
                let node = &self.nodes[weights.node[n]];
                for a in 0..D {
                    point.velocity[a] += dt * weights.value[n] * node.force[a];
                    point.position[a] += dt * weights.value[n] * node.momentum[a];
                    for b in 0..D {
                        gradient[a][b] += dt * node.momentum[a] * weights.gradient[n][b];
                    }
                }
            }
            point.update_stress(&gradient, lame, shear);
        }
    }
}
