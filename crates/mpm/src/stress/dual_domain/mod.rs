//! Dual domain material point method (Zhang et al. 2011; sheet: mpm §2.5f): gradients that do not jump at cell faces.
//!
//! Values are those of the linear functions. The gradient is `α ∇N_i + (1 - α) Σ_j N_j g_ji`, where `g_ji` is the average of `∇N_i` around
//! node `j`, weighted with `N_j`, and `α`, the product of the linear functions of the cell over its largest value, vanishes on the faces.
//! The share `1 - α` of a point's stress goes to the nodes, with `N_j`, which add the force of their stress; the share `1 - α` of its
//! velocity gradient is that of the nodes.
//! An average over all cells around a node would reach nodes beyond those of cells with points: they have no mass, and the force on them,
//! with its momentum, would be lost. Here averages are over the cells with points. Then forces act on nodes of such cells only, and as
//! every `g_j` is an average of the same gradients, `Σ_i g_ji = 0` and `Σ_i x_i ⊗ g_ji = 1` hold at the surface too: momentum is conserved
//! to round-off and linear fields have exact gradients. The drawback is a jump where a point enters a cell without points.

use colluvium_case::{Case, CaseError};
use colluvium_constitutive::SymTensor;
use colluvium_grid::{Grid, Layout, NodalState, Vector4};

use crate::background_grid::BackgroundGrid;
use crate::config::{ShapeFunctions, VolumetricStrain};
use crate::momentum::velocity_fields::{VelocityFields, VelocitySource};
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;
use crate::{MpmOptions, VelocityTransfer};

/// Stresses, volumes and velocity gradients of nodes, velocity field after velocity field. Empty where another shape is
/// in use.
#[derive(Clone, Debug, Default)]
pub struct DualDomainNodes {
    /// `Σ_p (1 - α) Ω_p σ_p N_ip` (N m) in six lanes; in the seventh, the number of points in the cell above the node.
    stresses: Vec<[Vector4; 2]>,
    /// One over the node's share of the volume of the cells around it that hold points (1/m³); zero without any.
    inverse_volumes: Vec<f64>,
    /// Velocity gradients, column by column (1/s).
    velocity_gradients: Vec<[Vector4; 3]>,
}

/// Rejects features that need the gradient of a shape function at a single position.
pub fn check_supported(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    if options.shape != ShapeFunctions::DualDomain {
        return Ok(());
    }
    let refuse = |path: &str, problem: &str| Err(CaseError::new(path, problem));
    if options.volumetric_strain != VolumetricStrain::Point {
        return refuse("methods.mpm.volumetric_strain", "only point is available with shape dual-domain");
    }
    if matches!(options.transfer, VelocityTransfer::Apic | VelocityTransfer::Tpic) {
        return refuse("methods.mpm.transfer", "only flip and xpic are available with shape dual-domain");
    }
    if let Some(number) = case.loads.iter().position(|load| load.is_follower() && !load.is_of_fluid()) {
        let problem =
            "a load that follows the surface is not available with shape dual-domain: use a traction";
        return refuse(&format!("loads[{number}].kind"), problem);
    }
    Ok(())
}

/// Cell at a position (m), and local coordinates in it (0 to 1 along each axis).
#[inline(always)]
fn cell_and_offset<const D: usize>(grid: &Grid<D>, position: &[f64; D]) -> ([usize; D], [f64; D]) {
    let (cell, local) = (grid.cell_of(position), grid.local(position));
    (cell, std::array::from_fn(|a| local[a] - cell[a] as f64))
}

/// Weight `α = n^n ∏ N_i` over the `n = 2^D` nodes of a cell, at local coordinates `s`.
#[inline(always)]
fn own_share<const D: usize>(s: &[f64; D]) -> f64 {
    let product: f64 = s.iter().map(|s| 4.0 * s * (1.0 - s)).product();
    product.max(0.0).powi(1 << (D - 1))
}

/// Weight of the stress and velocity gradient of a point itself, against the nodal averages.
#[inline(always)]
pub fn own_stress_share<const D: usize>(grid: &Grid<D>, position: &[f64; D]) -> f64 {
    own_share(&cell_and_offset(grid, position).1)
}

/// Linear shape function of corner `k` of a cell at local coordinates `s`.
#[inline(always)]
fn weight<const D: usize>(k: usize, s: &[f64; D]) -> f64 {
    (0..D).map(|a| if k >> a & 1 == 1 { s[a] } else { 1.0 - s[a] }).product()
}

/// Corners of cells, and `∫ N_j ∇N_i` over a cell.
struct CellCorners<const D: usize> {
    /// Distance in memory of each corner from the lowest.
    offsets: [usize; 8],
    /// `∫ N_j ∂N_i/∂x_a` over a cell for the upper one of `i` along `a`, by the axes along which `i` and `j` differ.
    products: [[f64; D]; 8],
}

impl<const D: usize> CellCorners<D> {
    /// Corner offsets of a cell and integrals of products of its shape functions.
    fn new(grid: &Grid<D>, strides: &[usize; D]) -> Self {
        let offsets = std::array::from_fn(|k| (0..D).map(|a| (k >> a & 1) * strides[a]).sum());
        let h = grid.cell;
        let product = |differ: usize, a: usize| -> f64 {
            let across = (0..D).filter(|b| *b != a);
            0.5 * across.map(|b| if differ >> b & 1 == 1 { h / 6.0 } else { h / 3.0 }).product::<f64>()
        };
        Self { offsets, products: std::array::from_fn(|k| std::array::from_fn(|a| product(k, a))) }
    }

    /// Number of corners of a cell.
    const COUNT: usize = 1 << D;

    /// Integral `∫ N_j ∇N_i` over a cell.
    #[inline(always)]
    fn integral(&self, j: usize, i: usize) -> [f64; D] {
        let products = self.products[i ^ j];
        std::array::from_fn(|a| if i >> a & 1 == 1 { products[a] } else { -products[a] })
    }

    /// Returns the lowest node of the cell of which `node` is corner `k`, if that cell has points.
    #[inline(always)]
    fn cell(&self, stresses: &[[Vector4; 2]], node: usize, k: usize) -> Option<usize> {
        node.checked_sub(self.offsets[k]).filter(|lowest| stresses[*lowest][1].as_array()[2] > 0.0)
    }
}

/// Function that is called with positions, stresses and volumes of the points of each set in a slab.
type PointVisitor<'a, const D: usize> = dyn FnMut(&[[f64; D]], &[SymTensor], &[f64]) + 'a;
/// Function that calls a [`PointVisitor`] for a slab.
type SlabVisitor<'a, const D: usize> = dyn Fn(usize, &mut PointVisitor<'_, D>) + Sync + 'a;

impl DualDomainNodes {
    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.stresses[..])
            + size_of_val(&self.inverse_volumes[..])
            + size_of_val(&self.velocity_gradients[..])
    }

    /// Returns empty arrays for the options.
    pub fn new<const D: usize>(options: &MpmOptions, layout: &Layout<D>, fields: usize) -> Self {
        let length = if options.shape == ShapeFunctions::DualDomain { fields * layout.len() } else { 0 };
        Self {
            stresses: vec![[Vector4::ZERO; 2]; length],
            inverse_volumes: vec![0.0; length],
            velocity_gradients: vec![[Vector4::ZERO; 3]; length],
        }
    }

    /// Whether dual-domain gradients are used.
    #[inline(always)]
    pub fn is_used(&self) -> bool {
        !self.inverse_volumes.is_empty()
    }

    /// Sets the active entries to zero.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        self.stresses.chunks_exact_mut(layout.len()).for_each(|values| layout.reset(values));
        self.inverse_volumes.chunks_exact_mut(layout.len()).for_each(|values| layout.reset(values));
        self.velocity_gradients.chunks_exact_mut(layout.len()).for_each(|values| layout.reset(values));
    }

    /// Adds the points of a velocity field: stresses of nodes, and cells with points.
    fn add_points<const D: usize>(
        &mut self,
        field: usize,
        grid: &Grid<D>,
        layout: &Layout<D>,
        slabs: &SlabVisitor<'_, D>,
    ) {
        let (len, strides) = (layout.len(), layout.strides());
        let corners = CellCorners::new(grid, &strides);
        let stresses = &mut self.stresses[field * len..(field + 1) * len];
        layout.reset(stresses);
        layout.for_each_slab(stresses, |slab, window, offset| {
            slabs(slab, &mut |positions, stresses, volumes| {
                for ((position, stress), volume) in positions.iter().zip(stresses).zip(volumes) {
                    let (cell, s) = cell_and_offset(grid, position);
                    let lowest = (0..D).map(|a| cell[a] * strides[a]).sum::<usize>() - offset;
                    let (t, shared_volume) = (&stress.0, volume * (1.0 - own_share(&s)));
                    for k in 0..CellCorners::<D>::COUNT {
                        let shared_volume = shared_volume * weight(k, &s);
                        let node = &mut window[lowest + corners.offsets[k]];
                        node[0] += Vector4::new([t[0], t[1], t[2], t[3]]) * shared_volume;
                        node[1] += Vector4::new([t[4], t[5], 0.0, 0.0]) * shared_volume;
                    }
                    window[lowest][1] += Vector4::new([0.0, 0.0, 1.0, 0.0]);
                }
            });
        });
        let stresses = &self.stresses[field * len..(field + 1) * len];
        let share = (0.5 * grid.cell).powi(D as i32);
        layout.for_each_active_node_range(
            &mut self.inverse_volumes[field * len..(field + 1) * len],
            |row, active, line| {
                for number in active {
                    let node = row * strides[0] + number;
                    let around = (0..CellCorners::<D>::COUNT)
                        .filter(|k| corners.cell(stresses, node, *k).is_some())
                        .count();
                    line[number] = if around > 0 { 1.0 / (around as f64 * share) } else { 0.0 };
                }
            },
        );
    }

    /// Adds the force of the nodal stresses of a field.
    fn add_forces<const D: usize>(
        &self,
        field: usize,
        grid: &Grid<D>,
        layout: &Layout<D>,
        nodes: &mut [NodalState],
    ) {
        let (len, strides) = (layout.len(), layout.strides());
        let corners = CellCorners::new(grid, &strides);
        let stresses = &self.stresses[field * len..(field + 1) * len];
        let inverses = &self.inverse_volumes[field * len..(field + 1) * len];
        layout.for_each_active_node_range(nodes, |row, active, line| {
            for number in active {
                let node = row * strides[0] + number;
                let mut force = Vector4::ZERO;
                for i in 0..CellCorners::<D>::COUNT {
                    let Some(lowest) = corners.cell(stresses, node, i) else { continue };
                    for j in 0..CellCorners::<D>::COUNT {
                        let other = lowest + corners.offsets[j];
                        let ([a, b], inverse) = (stresses[other].map(Vector4::to_array), inverses[other]);
                        let rows = [[a[0], a[3], b[1]], [a[3], a[1], b[0]], [b[1], b[0], a[2]]];
                        for (c, slope) in corners.integral(j, i).into_iter().enumerate() {
                            let [x, y, z] = rows[c];
                            force += Vector4::new([x, y, z, 0.0]) * (slope * inverse);
                        }
                    }
                }
                let mut axes = [0.0; 4];
                axes[..D].fill(1.0);
                line[number].force -= force * Vector4::new(axes);
            }
        });
    }

    /// Averages velocity gradients at the nodes of a field from the nodal velocities of `of`.
    fn average_gradients<const D: usize>(
        &mut self,
        field: usize,
        grid: &Grid<D>,
        layout: &Layout<D>,
        of: impl Fn(usize) -> Vector4 + Sync,
    ) {
        let (len, strides) = (layout.len(), layout.strides());
        let corners = CellCorners::new(grid, &strides);
        let stresses = &self.stresses[field * len..(field + 1) * len];
        let inverses = &self.inverse_volumes[field * len..(field + 1) * len];
        layout.for_each_active_node_range(
            &mut self.velocity_gradients[field * len..(field + 1) * len],
            |row, active, line| {
                for number in active {
                    let node = row * strides[0] + number;
                    let mut columns = [Vector4::ZERO; 3];
                    for j in 0..CellCorners::<D>::COUNT {
                        let Some(lowest) = corners.cell(stresses, node, j) else { continue };
                        for i in 0..CellCorners::<D>::COUNT {
                            let velocity = of(lowest + corners.offsets[i]) * inverses[node];
                            for (column, slope) in columns.iter_mut().zip(corners.integral(j, i)) {
                                *column += velocity * slope;
                            }
                        }
                    }
                    line[number] = columns;
                }
            },
        );
    }

    /// Replaces the gradient of the linear functions at a position (m) by the dual-domain gradient.
    #[inline(never)]
    pub fn blend<const D: usize>(
        &self,
        field: usize,
        grid: &Grid<D>,
        layout: &Layout<D>,
        position: &[f64; D],
        gradient: &mut [Vector4; D],
    ) {
        let strides = layout.strides();
        let (cell, s) = cell_and_offset(grid, position);
        let lowest: usize = field * layout.len() + (0..D).map(|a| cell[a] * strides[a]).sum::<usize>();
        let own = own_share(&s);
        let mut columns = gradient.map(|column| column * own);
        for k in 0..CellCorners::<D>::COUNT {
            let offset: usize = (0..D).map(|a| (k >> a & 1) * strides[a]).sum();
            let shared_volume = (1.0 - own) * weight(k, &s);
            for (column, slope) in columns.iter_mut().zip(&self.velocity_gradients[lowest + offset]) {
                *column += *slope * shared_volume;
            }
        }
        *gradient = columns;
    }
}

/// Adds the weighted stresses of the points to the nodal averages.
pub fn share_stresses<const D: usize>(
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    fields: usize,
    dual: &mut DualDomainNodes,
) {
    if !dual.is_used() {
        return;
    }
    for field in 0..fields {
        let of_field = |set: &&PointSet<D>| set.field == field;
        let sets = &bodies.sets;
        dual.add_points(field, &background.grid, &background.layout, &|slab, visit| {
            for set in sets.iter().filter(of_field) {
                let points = set.slabs[slab]..set.slabs[slab + 1];
                visit(
                    &set.points.position[points.clone()],
                    &set.points.stress[points.clone()],
                    &set.points.volume[points],
                );
            }
        });
    }
}

/// Adds the force of the nodal stresses.
pub fn add_dual_forces<const D: usize>(
    background: &BackgroundGrid<D>,
    dual: &DualDomainNodes,
    solved: &mut [NodalState],
) {
    if !dual.is_used() {
        return;
    }
    let (grid, layout) = (&background.grid, &background.layout);
    for (field, nodes) in solved.chunks_exact_mut(layout.len()).enumerate() {
        dual.add_forces(field, grid, layout, nodes);
    }
}

/// Averages the velocity gradients around the nodes.
pub fn average_velocity_gradients<const D: usize>(
    background: &BackgroundGrid<D>,
    (nodes, read): (&VelocityFields, VelocitySource),
    dual: &mut DualDomainNodes,
) {
    if !dual.is_used() {
        return;
    }
    let (grid, layout) = (&background.grid, &background.layout);
    for field in 0..nodes.fields(layout) {
        let first = field * layout.len();
        dual.average_gradients(field, grid, layout, |number| nodes.motion(read, first + number));
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod power_tests {
    use super::tests::rough;
    use super::*;
    use crate::MpmSolver;
    use crate::setup::tests::initial_solver;
    use colluvium_grid::{LinearBasis, NodeSupport, Stencil};

    /// Power of the stresses of the points, with the velocity gradients of the solved nodes.
    fn stress_power<const D: usize>(solver: &MpmSolver<D>) -> f64 {
        let (set, mut power) = (&solver.bodies.sets[0], 0.0);
        for (p, x) in set.points.position.iter().enumerate() {
            let support: Stencil<D, 2> = Stencil::new::<LinearBasis>(&solver.background.grid, x, &set.extent);
            let mut gradient =
                support.g2p(&solver.nodes.nodal_states, &solver.background.layout.strides()).gradient;
            solver.averages.dual_domain.blend(
                0,
                &solver.background.grid,
                &solver.background.layout,
                x,
                &mut gradient,
            );
            for (j, column) in gradient.into_iter().enumerate() {
                let column = column.to_array();
                power -= (0..D)
                    .map(|i| set.points.volume[p] * set.points.stress[p].component(i, j) * column[i])
                    .sum::<f64>();
            }
        }
        power
    }

    /// Power of the nodal forces, which is that of the points' stresses for any velocities: force and velocity gradient use the same gradients.
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
        let mut solver = initial_solver::<D>(&case);
        let set = &mut solver.bodies.sets[0];
        for (p, position) in set.points.position.iter_mut().enumerate() {
            let wave = rough([0.37 * p as f64; 1]);
            (0..D).for_each(|c| position[c] += 0.1 * wave[c]);
            let [a, b, c] = rough([1.0 + 0.53 * p as f64; 1]);
            let in_space = |axis: usize, value: f64| if axis < D { value } else { 0.0 };
            set.points.stress[p] =
                SymTensor([a, b, c, in_space(1, a * b), in_space(2, b * c), in_space(2, c * a)]);
        }
        solver.sort();
        solver.p2g_for_tests();
        let mut power = 0.0;
        let mut total = [0.0; 3];
        for (n, node) in solver.nodes.nodal_states.iter_mut().enumerate() {
            let (force, mass) = (node.force.to_array(), node.momentum_and_mass.as_array()[3]);
            assert!(mass > 0.0 || force[..3] == [0.0; 3], "force on a node without mass: {force:?}");
            let velocity = rough([0.2 + 0.11 * n as f64; 1]);
            for c in 0..D {
                power += force[c] * velocity[c];
                total[c] += force[c];
            }
            node.momentum_and_mass = Vector4::new([velocity[0], velocity[1], velocity[2], mass]);
        }
        assert!(total.iter().all(|force| force.abs() < 1e-14), "{space}: {total:?}");
        average_velocity_gradients(
            &solver.background,
            (&solver.nodes, VelocitySource::EndOfStep),
            &mut solver.averages.dual_domain,
        );
        let exact = stress_power(&solver);
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
}
