//! Dual domain material point method (Zhang et al. 2011; MPM sheet §2.5f): gradients that do not jump at cell faces.
//!
//! Values are those of the linear functions. The gradient is `α ∇N_i + (1 - α) Σ_j N_j g_ji`, where `g_ji` is the average
//! of `∇N_i` around node `j`, weighed with `N_j`, and `α`, the product of the linear functions of the cell over its largest
//! value, vanishes on the faces. So the share `1 - α` of a point's stress goes to the nodes, with `N_j`, and these pull
//! with what they have; and the share `1 - α` of its velocity gradient is that of the nodes.
//!
//! An average over all cells around a node would reach nodes beyond those of cells that hold points: they have no mass, and
//! the force on them, with its momentum, would be lost. Here averages are over the cells that hold points, the body as the
//! grid sees it. Then force falls on nodes of such cells only, and as every `g_j` is an average of one and the same
//! gradients, `Σ_i g_ji = 0` and `Σ_i x_i ⊗ g_ji = 1` hold at the surface too: momentum is conserved to round-off and linear
//! fields have their gradients everywhere. The price is a jump where a point enters a cell that held none.

use colluvium_case::description::Load;
use colluvium_case::{Case, CaseError};
use colluvium_constitutive::SymTensor;
use colluvium_grid::{Basis, Grid, Lanes, Layout, Node};

use crate::config::{ShapeFunctions, VolumetricStrain};
use crate::points::{PointDomain, PointSet};
use crate::solver::MpmSolver;
use crate::{MpmOptions, Transfer};

/// Stresses, volumes and velocity gradients of nodes, velocity field after velocity field. Empty where another shape is
/// in use.
#[derive(Clone, Debug, Default)]
pub struct DualNodes {
    /// `Σ_p (1 - α) Ω_p σ_p N_ip` (N m) in six lanes; in the seventh, the number of points in the cell above the node.
    stresses: Vec<[Lanes; 2]>,
    /// One over the node's share of the volume of the cells around it that hold points (1/m³); zero without any.
    inverses: Vec<f64>,
    /// Velocity gradients, column by column (1/s).
    slopes: Vec<[Lanes; 3]>,
}

/// Refuses what goes by the gradient of a shape function at one place.
pub fn cleared(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    if options.shape != ShapeFunctions::DualDomain {
        return Ok(());
    }
    let refuse = |path: &str, problem: &str| Err(CaseError::new(path, problem));
    if options.volumetric_strain != VolumetricStrain::Point {
        return refuse("methods.mpm.volumetric_strain", "only point is available with shape dual-domain");
    }
    if matches!(options.transfer, Transfer::Apic | Transfer::Tpic) {
        return refuse("methods.mpm.transfer", "only flip and xpic are available with shape dual-domain");
    }
    if !case.domain.periodic.is_empty() {
        return refuse("domain.periodic", "is not available with shape dual-domain");
    }
    if let Some(number) = case.bodies.iter().position(|body| body.pore_fluid.is_some()) {
        return refuse(&format!("bodies[{number}].pore_fluid"), "is not available with shape dual-domain");
    }
    if let Some(number) = case.loads.iter().position(|load| matches!(load, Load::Pressure { .. })) {
        let problem =
            "a pressure that follows the surface is not available with shape dual-domain: use a traction";
        return refuse(&format!("loads[{number}].kind"), problem);
    }
    Ok(())
}

/// Cell of a place (m), and where in it (0 to 1 along each axis).
#[inline(always)]
fn place<const D: usize>(grid: &Grid<D>, position: &[f64; D]) -> ([usize; D], [f64; D]) {
    let (cell, local) = (grid.cell_of(position), grid.local(position));
    (cell, std::array::from_fn(|a| local[a] - cell[a] as f64))
}

/// `α = n^n ∏ N_i` over the `n = 2^D` nodes of a cell, at `s` in it.
#[inline(always)]
fn own_share<const D: usize>(s: &[f64; D]) -> f64 {
    let product: f64 = s.iter().map(|s| 4.0 * s * (1.0 - s)).product();
    product.max(0.0).powi(1 << (D - 1))
}

/// Share of its stress that a point keeps, and of its velocity gradient that is its own.
#[inline(always)]
pub fn share<const D: usize>(grid: &Grid<D>, position: &[f64; D]) -> f64 {
    own_share(&place(grid, position).1)
}

/// Linear weight of corner `k` of a cell at `s` in it.
#[inline(always)]
fn weight<const D: usize>(k: usize, s: &[f64; D]) -> f64 {
    (0..D).map(|a| if k >> a & 1 == 1 { s[a] } else { 1.0 - s[a] }).product()
}

/// Corners of cells, and `∫ N_j ∇N_i` over one.
struct Corners<const D: usize> {
    /// Distance in memory of each corner from the lowest.
    offsets: [usize; 8],
    /// `∫ N_j ∂N_i/∂x_a` over a cell for the upper one of `i` along `a`, by the axes along which `i` and `j` differ.
    products: [[f64; D]; 8],
}

impl<const D: usize> Corners<D> {
    fn new(grid: &Grid<D>, strides: &[usize; D]) -> Self {
        let offsets = std::array::from_fn(|k| (0..D).map(|a| (k >> a & 1) * strides[a]).sum());
        let h = grid.cell;
        let product = |differ: usize, a: usize| -> f64 {
            let across = (0..D).filter(|b| *b != a);
            0.5 * across.map(|b| if differ >> b & 1 == 1 { h / 6.0 } else { h / 3.0 }).product::<f64>()
        };
        Self { offsets, products: std::array::from_fn(|k| std::array::from_fn(|a| product(k, a))) }
    }

    const COUNT: usize = 1 << D;

    /// `∫ N_j ∇N_i` over a cell.
    #[inline(always)]
    fn integral(&self, j: usize, i: usize) -> [f64; D] {
        let products = self.products[i ^ j];
        std::array::from_fn(|a| if i >> a & 1 == 1 { products[a] } else { -products[a] })
    }

    /// The lowest node of the cell of which `node` is corner `k`, if that cell holds points.
    #[inline(always)]
    fn cell(&self, stresses: &[[Lanes; 2]], node: usize, k: usize) -> Option<usize> {
        node.checked_sub(self.offsets[k]).filter(|lowest| stresses[*lowest][1].as_array()[2] > 0.0)
    }
}

/// Called for every set of points in a slab, with their positions, stresses and volumes.
type Visit<'a, const D: usize> = dyn FnMut(&[[f64; D]], &[SymTensor], &[f64]) + 'a;
/// Calls a [`Visit`] for a slab.
type Slabs<'a, const D: usize> = dyn Fn(usize, &mut Visit<'_, D>) + Sync + 'a;

impl DualNodes {
    /// Memory of a node (bytes).
    pub const BYTES: usize = size_of::<f64>() + 5 * size_of::<Lanes>();

    /// Empty arrays for what the options ask for.
    pub fn new<const D: usize>(options: &MpmOptions, layout: &Layout<D>, fields: usize) -> Self {
        let length = if options.shape == ShapeFunctions::DualDomain { fields * layout.len() } else { 0 };
        Self {
            stresses: vec![[Lanes::ZERO; 2]; length],
            inverses: vec![0.0; length],
            slopes: vec![[Lanes::ZERO; 3]; length],
        }
    }

    /// Whether gradients are dual.
    #[inline(always)]
    pub fn is_used(&self) -> bool {
        !self.inverses.is_empty()
    }

    /// Empties the active entries.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        self.stresses.chunks_exact_mut(layout.len()).for_each(|values| layout.reset(values));
        self.inverses.chunks_exact_mut(layout.len()).for_each(|values| layout.reset(values));
        self.slopes.chunks_exact_mut(layout.len()).for_each(|values| layout.reset(values));
    }

    /// Takes the points of a velocity field: stresses of nodes, and cells that hold points.
    fn take<const D: usize>(
        &mut self,
        field: usize,
        grid: &Grid<D>,
        layout: &Layout<D>,
        slabs: &Slabs<'_, D>,
    ) {
        let (len, strides) = (layout.len(), layout.strides());
        let corners = Corners::new(grid, &strides);
        let stresses = &mut self.stresses[field * len..(field + 1) * len];
        layout.reset(stresses);
        layout.scatter(stresses, |slab, window, offset| {
            slabs(slab, &mut |positions, stresses, volumes| {
                for ((position, stress), volume) in positions.iter().zip(stresses).zip(volumes) {
                    let (cell, s) = place(grid, position);
                    let lowest = (0..D).map(|a| cell[a] * strides[a]).sum::<usize>() - offset;
                    let (t, given) = (&stress.0, volume * (1.0 - own_share(&s)));
                    for k in 0..Corners::<D>::COUNT {
                        let given = given * weight(k, &s);
                        let node = &mut window[lowest + corners.offsets[k]];
                        node[0] += Lanes::new([t[0], t[1], t[2], t[3]]) * given;
                        node[1] += Lanes::new([t[4], t[5], 0.0, 0.0]) * given;
                    }
                    window[lowest][1] += Lanes::new([0.0, 0.0, 1.0, 0.0]);
                }
            });
        });
        let stresses = &self.stresses[field * len..(field + 1) * len];
        let share = (0.5 * grid.cell).powi(D as i32);
        layout.each(&mut self.inverses[field * len..(field + 1) * len], |row, active, line| {
            for number in active {
                let node = row * strides[0] + number;
                let around =
                    (0..Corners::<D>::COUNT).filter(|k| corners.cell(stresses, node, *k).is_some()).count();
                line[number] = if around > 0 { 1.0 / (around as f64 * share) } else { 0.0 };
            }
        });
    }

    /// Adds the force of the stresses of the nodes of a field.
    fn pull<const D: usize>(&self, field: usize, grid: &Grid<D>, layout: &Layout<D>, nodes: &mut [Node]) {
        let (len, strides) = (layout.len(), layout.strides());
        let corners = Corners::new(grid, &strides);
        let stresses = &self.stresses[field * len..(field + 1) * len];
        let inverses = &self.inverses[field * len..(field + 1) * len];
        layout.each(nodes, |row, active, line| {
            for number in active {
                let node = row * strides[0] + number;
                let mut force = Lanes::ZERO;
                for i in 0..Corners::<D>::COUNT {
                    let Some(lowest) = corners.cell(stresses, node, i) else { continue };
                    for j in 0..Corners::<D>::COUNT {
                        let other = lowest + corners.offsets[j];
                        let ([a, b], inverse) = (stresses[other].map(Lanes::to_array), inverses[other]);
                        let rows = [[a[0], a[3], b[1]], [a[3], a[1], b[0]], [b[1], b[0], a[2]]];
                        for (c, slope) in corners.integral(j, i).into_iter().enumerate() {
                            let [x, y, z] = rows[c];
                            force += Lanes::new([x, y, z, 0.0]) * (slope * inverse);
                        }
                    }
                }
                let mut axes = [0.0; 4];
                axes[..D].fill(1.0);
                line[number].force -= force * Lanes::new(axes);
            }
        });
    }

    /// Velocity gradients of the nodes of a field from the velocity that `of` finds at a node.
    fn average<const D: usize>(
        &mut self,
        field: usize,
        grid: &Grid<D>,
        layout: &Layout<D>,
        of: impl Fn(usize) -> Lanes + Sync,
    ) {
        let (len, strides) = (layout.len(), layout.strides());
        let corners = Corners::new(grid, &strides);
        let stresses = &self.stresses[field * len..(field + 1) * len];
        let inverses = &self.inverses[field * len..(field + 1) * len];
        layout.each(&mut self.slopes[field * len..(field + 1) * len], |row, active, line| {
            for number in active {
                let node = row * strides[0] + number;
                let mut columns = [Lanes::ZERO; 3];
                for j in 0..Corners::<D>::COUNT {
                    let Some(lowest) = corners.cell(stresses, node, j) else { continue };
                    for i in 0..Corners::<D>::COUNT {
                        let velocity = of(lowest + corners.offsets[i]) * inverses[node];
                        for (column, slope) in columns.iter_mut().zip(corners.integral(j, i)) {
                            *column += velocity * slope;
                        }
                    }
                }
                line[number] = columns;
            }
        });
    }

    /// Makes the dual gradient at a place (m) of the one of the linear functions there.
    #[inline(never)]
    pub fn blend<const D: usize>(
        &self,
        field: usize,
        grid: &Grid<D>,
        layout: &Layout<D>,
        position: &[f64; D],
        gradient: &mut [Lanes; D],
    ) {
        let strides = layout.strides();
        let (cell, s) = place(grid, position);
        let lowest: usize = field * layout.len() + (0..D).map(|a| cell[a] * strides[a]).sum::<usize>();
        let own = own_share(&s);
        let mut columns = gradient.map(|column| column * own);
        for k in 0..Corners::<D>::COUNT {
            let offset: usize = (0..D).map(|a| (k >> a & 1) * strides[a]).sum();
            let given = (1.0 - own) * weight(k, &s);
            for (column, slope) in columns.iter_mut().zip(&self.slopes[lowest + offset]) {
                *column += *slope * given;
            }
        }
        *gradient = columns;
    }
}

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Gives the nodes their share of the points' stresses.
    pub(crate) fn share_stresses(&mut self) {
        if !self.dual.is_used() {
            return;
        }
        let mut dual = std::mem::take(&mut self.dual);
        for field in 0..self.contacts.fields() {
            let of_field = |set: &&PointSet<D, P>| set.field == field;
            let sets = &self.sets;
            dual.take(field, &self.grid, &self.layout, &|slab, visit| {
                for set in sets.iter().filter(of_field) {
                    let points = set.slabs[slab]..set.slabs[slab + 1];
                    visit(&set.position[points.clone()], &set.stress[points.clone()], &set.volume[points]);
                }
            });
        }
        self.dual = dual;
    }

    /// Adds the force of the stresses of the nodes.
    pub(crate) fn pull_with_nodes(&mut self) {
        if !self.dual.is_used() {
            return;
        }
        let (grid, layout) = (&self.grid, &self.layout);
        for (field, nodes) in self.nodes.chunks_exact_mut(layout.len()).enumerate() {
            self.dual.pull(field, grid, layout, nodes);
        }
    }

    /// Averages the velocity gradients around the nodes.
    pub(crate) fn average_slopes<const FROM_SOLVED: bool>(&mut self) {
        if !self.dual.is_used() {
            return;
        }
        let (grid, layout, nodes, remapped) = (&self.grid, &self.layout, &self.nodes, &self.remapped);
        for field in 0..self.contacts.fields() {
            let first = field * layout.len();
            let of = |number: usize| {
                if FROM_SOLVED { nodes[first + number].motion } else { remapped[first + number] }
            };
            self.dual.average(field, grid, layout, of);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::points::FixedDomain;
    use crate::setup;
    use crate::transfer::Scatter;
    use colluvium_grid::{Linear, Stencil, Support};
    use proptest::prelude::*;

    /// A grid of `cells` of 0.5 m an axis with points at `places`, and how to read a field of nodes with it.
    struct Ground<const D: usize> {
        grid: Grid<D>,
        layout: Layout<D>,
        dual: DualNodes,
    }

    impl<const D: usize> Ground<D> {
        fn new(cells: usize, mut places: Vec<[f64; D]>) -> Self {
            let grid = Grid::new([0.0; D], [0.5 * cells as f64; D], 0.5).unwrap();
            let order = colluvium_grid::sort_by_cell(&grid, &places);
            places = order.iter().map(|i| places[*i as usize]).collect();
            let mut layout = Layout::new::<2, Linear>(&grid);
            let bounds = layout.add_points(&places);
            let options = serde_json::json!({ "cell_size": 0.5, "shape": "dual-domain" });
            let options: MpmOptions = serde_json::from_value(options).unwrap();
            let mut dual = DualNodes::new(&options, &layout, 1);
            let (stresses, volumes) = (vec![SymTensor::ZERO; places.len()], vec![0.1; places.len()]);
            dual.take(0, &grid, &layout, &|slab, visit| {
                let points = bounds[slab]..bounds[slab + 1];
                visit(&places[points.clone()], &stresses[points.clone()], &volumes[points]);
            });
            Self { grid, layout, dual }
        }

        /// A point in every cell.
        fn full(cells: usize) -> Self {
            let count = cells.pow(D as u32);
            let place = |mut n: usize| {
                std::array::from_fn(|_| {
                    let x = 0.5 * ((n % cells) as f64 + 0.5);
                    n /= cells;
                    x
                })
            };
            Self::new(cells, (0..count).map(place).collect())
        }

        fn node(&self, number: usize) -> [f64; D] {
            let mut rest = number;
            self.layout.strides().map(|stride| {
                let index = rest / stride;
                rest %= stride;
                0.5 * index as f64
            })
        }

        /// Gradient at a place of the field that `of` gives at the nodes.
        fn gradient(&mut self, x: &[f64; D], of: &(dyn Fn([f64; D]) -> [f64; 3] + Sync)) -> [[f64; 3]; D] {
            let values: Vec<Lanes> = (0..self.layout.len())
                .map(|n| {
                    let [a, b, c] = of(self.node(n));
                    Lanes::new([a, b, c, 0.0])
                })
                .collect();
            self.dual.average(0, &self.grid, &self.layout, |n| values[n]);
            let stencil = Stencil::<D, 2>::new::<Linear>(&self.grid, x, &[0.1; D]);
            let mut gradient = stencil.gather_velocity(&values, &self.layout.strides()).gradient;
            self.dual.blend(0, &self.grid, &self.layout, x, &mut gradient);
            gradient.map(|column| {
                let [a, b, c, _] = column.to_array();
                [a, b, c]
            })
        }
    }

    #[test]
    fn on_a_line_the_gradients_have_their_closed_form() {
        // At s of a cell of h, with α = 4 s (1 - s): the linear ± 1/h, and of the nodes the central differences.
        let mut line = Ground::<1>::full(8);
        for s in [0.0, 0.1, 0.25, 0.5, 0.8] {
            let x = 0.5 * (3.0 + s);
            let alpha = 4.0 * s * (1.0 - s);
            let exact = [
                -(1.0 - alpha) * 0.5 * (1.0 - s),
                -alpha - (1.0 - alpha) * 0.5 * s,
                alpha + (1.0 - alpha) * 0.5 * (1.0 - s),
                (1.0 - alpha) * 0.5 * s,
            ];
            for (k, exact) in exact.into_iter().enumerate() {
                let node = 0.5 * (2 + k) as f64;
                let found = line
                    .gradient(&[x], &|at| [if (at[0] - node).abs() < 1e-9 { 1.0 } else { 0.0 }, 0.0, 0.0]);
                assert!((found[0][0] - exact / 0.5).abs() < 1e-13, "{s}, node {k}: {found:?} for {exact}");
            }
        }
    }

    #[test]
    fn the_own_share_is_one_in_the_middle_and_none_on_faces() {
        assert!((own_share(&[0.5; 3]) - 1.0).abs() < 1e-15 && own_share(&[0.5, 0.0]) == 0.0);
        // 2^D weights over each other: 256 × (1/4 × 3/4 × 1/2)² / 16 at (1/4, 1/2).
        let [w, n] = [own_share(&[0.25, 0.5]), (0..4).map(|k| weight(k, &[0.25, 0.5])).product::<f64>()];
        assert!((w - 256.0 * n).abs() < 1e-14, "{w}");
        let cube = (0..8).map(|k| weight(k, &[0.3, 0.4, 0.6])).product::<f64>();
        assert!((own_share(&[0.3, 0.4, 0.6]) / (8f64.powi(8) * cube) - 1.0).abs() < 1e-12);
    }

    /// Gradients of a constant and of the places at `x`.
    fn linear_fields<const D: usize>(ground: &mut Ground<D>, x: &[f64; D]) {
        for (j, column) in ground.gradient(x, &|_| [1.0, -2.0, 3.0]).into_iter().enumerate() {
            assert!(column.iter().all(|c| c.abs() < 1e-12), "∂/∂x_{j}: {column:?}");
        }
        let found = ground.gradient(x, &|at| std::array::from_fn(|c| if c < D { at[c] } else { 0.0 }));
        for (j, column) in found.into_iter().enumerate() {
            for (i, c) in column.into_iter().enumerate() {
                assert!((c - if i == j { 1.0 } else { 0.0 }).abs() < 1e-12, "∂x_{i}/∂x_{j}: {c}");
            }
        }
    }

    /// A field without any order.
    fn rough<const D: usize>(x: [f64; D]) -> [f64; 3] {
        let phase: f64 = x.iter().enumerate().map(|(a, x)| (7.3 + 3.1 * a as f64) * x * x).sum();
        [phase.sin(), (1.7 * phase).cos(), (phase + 0.4).sin()]
    }

    fn continuous<const D: usize>(mut place: [f64; D], axis: usize) {
        let mut ground = Ground::<D>::full(5);
        let face = 1.0;
        let mut at = |x: f64| {
            place[axis] = x;
            ground.gradient(&place, &rough)
        };
        let (below, above) = (at(face - 1e-9), at(face + 1e-9));
        for (a, b) in below.as_flattened().iter().zip(above.as_flattened()) {
            assert!((a - b).abs() < 1e-6, "{place:?}: {a} and {b}");
        }
    }

    /// The power of the nodes' forces is that of the points' stresses, whatever the velocities: force and velocity gradient
    /// go by the same gradients.
    fn power<const D: usize>(space: &str) {
        let all = |value: f64| vec![value; D];
        let text = serde_json::json!({
            "title": "ball", "space": space, "domain": { "min": all(0.0), "max": all(1.0) }, "gravity": all(0.0),
            "materials": { "m": { "model": "linear-elastic", "density": 7, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": all(0.5), "radius": 0.3 } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 0.2, "shape": "dual-domain", "stress_update": "usl" } }
        });
        let case = Case::from_json(&text.to_string()).unwrap();
        let options = setup::options(&case).unwrap();
        let mut solver = setup::solver::<D, 2, Linear, FixedDomain>(&case, &options).unwrap();
        let set = &mut solver.sets[0];
        for (p, position) in set.position.iter_mut().enumerate() {
            let wave = rough([0.37 * p as f64; 1]);
            (0..D).for_each(|c| position[c] += 0.1 * wave[c]);
            let [a, b, c] = rough([1.0 + 0.53 * p as f64; 1]);
            let in_space = |axis: usize, value: f64| if axis < D { value } else { 0.0 };
            set.stress[p] = SymTensor([a, b, c, in_space(1, a * b), in_space(2, b * c), in_space(2, c * a)]);
        }
        solver.sort();
        solver.scatter(Scatter::Everything, 1e-3);
        let mut power = 0.0;
        let mut total = [0.0; 3];
        for (n, node) in solver.nodes.iter_mut().enumerate() {
            let (force, mass) = (node.force.to_array(), node.motion.as_array()[3]);
            assert!(mass > 0.0 || force[..3] == [0.0; 3], "force on a node without mass: {force:?}");
            let velocity = rough([0.2 + 0.11 * n as f64; 1]);
            for c in 0..D {
                power += force[c] * velocity[c];
                total[c] += force[c];
            }
            node.motion = Lanes::new([velocity[0], velocity[1], velocity[2], mass]);
        }
        assert!(total.iter().all(|force| force.abs() < 1e-14), "{space}: {total:?}");
        solver.average_slopes::<true>();
        let (set, mut exact) = (&solver.sets[0], 0.0);
        for (p, x) in set.position.iter().enumerate() {
            let support: Stencil<D, 2> = Stencil::new::<Linear>(&solver.grid, x, &set.extent);
            let mut gradient = support.gather(&solver.nodes, &solver.layout.strides()).gradient;
            solver.dual.blend(0, &solver.grid, &solver.layout, x, &mut gradient);
            for (j, column) in gradient.into_iter().enumerate() {
                let column = column.to_array();
                exact -= (0..D).map(|i| set.volume[p] * set.stress[p].at(i, j) * column[i]).sum::<f64>();
            }
        }
        assert!(
            (power - exact).abs() < 1e-13 * exact.abs().max(1.0) && exact != 0.0,
            "{space}: {power}, {exact}"
        );
    }

    #[test]
    fn forces_do_the_work_of_the_stresses_and_fall_on_nodes_with_mass() {
        power::<1>("1d");
        power::<2>("plane-strain");
        power::<3>("3d");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn linear_fields_have_their_gradients_at_the_surface_too(
            places in proptest::collection::vec(proptest::array::uniform3(0.0..2.0f64), 1..20),
        ) {
            linear_fields(&mut Ground::<1>::new(4, places.iter().map(|x| [x[0]]).collect()), &[places[0][0]]);
            let plane = places.iter().map(|x| [x[0], x[1]]).collect();
            linear_fields(&mut Ground::<2>::new(4, plane), &[places[0][0], places[0][1]]);
            linear_fields(&mut Ground::<3>::new(4, places.clone()), &places[0]);
        }

        #[test]
        fn gradients_pass_through_faces_without_a_jump(x in proptest::array::uniform3(0.0..2.5f64)) {
            continuous::<1>([x[0]], 0);
            (0..2).for_each(|axis| continuous::<2>([x[0], x[1]], axis));
            (0..3).for_each(|axis| continuous::<3>(x, axis));
        }
    }
}
