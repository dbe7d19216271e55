//! Averages of the volumetric strain over cells or nodes, against locking (sheet: mpm §2.17).
//!
//! Bodies of one material have common averages; each material has its own.

use std::ops::Range;

use colluvium_case::Case;
use colluvium_constitutive::{BLOCK_SIZE, Material, Motion, StateBlock, SymTensor};
use colluvium_grid::{InterpolatedMotion, Layout, Vector4};

use crate::MpmOptions;
use crate::background_grid::BackgroundGrid;
use crate::background_grid::averaging_cells::AveragingCells;
use crate::clock::Clock;
use crate::config::VolumetricStrain;
use crate::momentum::velocity_fields::{VelocityFields, VelocitySource};
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;

/// Averaged volumetric strain increments by cell ([`crate::background_grid::averaging_cells`]) and by node.
#[derive(Clone, Debug, Default)]
pub struct CellStrains {
    /// Number of the material of each body.
    materials: Vec<usize>,
    /// Volume and volume times strain of the skeleton, and of the liquid; material after material. Empty where points
    /// keep their own strain.
    cells: Vec<Vector4>,
    /// Volume and volume times strain at nodes; empty without nodal averages.
    nodes: Vec<Vector4>,
}

impl CellStrains {
    /// Returns empty arrays over nodes and cells for the options.
    pub fn new<const D: usize>(case: &Case, options: &MpmOptions, [nodes, cells]: [&Layout<D>; 2]) -> Self {
        let first = |body: usize| {
            let same =
                |other: &colluvium_case::description::Body| other.material == case.bodies[body].material;
            case.bodies.iter().position(same).unwrap_or(body)
        };
        let firsts: Vec<usize> = (0..case.bodies.len()).map(first).collect();
        let mut distinct = firsts.clone();
        distinct.sort_unstable();
        distinct.dedup();
        let materials: Vec<usize> =
            firsts.iter().map(|f| distinct.iter().position(|d| d == f).unwrap_or(0)).collect();
        let length = |wanted: bool, of: &Layout<D>| if wanted { distinct.len() * of.len() } else { 0 };
        let kind = options.volumetric_strain;
        Self {
            cells: vec![Vector4::ZERO; length(kind != VolumetricStrain::Point, cells)],
            nodes: vec![Vector4::ZERO; length(kind == VolumetricStrain::Nodal, nodes)],
            materials,
        }
    }

    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.cells[..]) + size_of_val(&self.nodes[..])
    }

    /// Whether strains are averaged.
    #[inline(always)]
    pub fn is_shared(&self) -> bool {
        !self.cells.is_empty()
    }

    /// Sets the entries of active cells and nodes to zero.
    pub fn reset<const D: usize>(&mut self, [nodes, cells]: [&Layout<D>; 2]) {
        for (values, layout) in [(&mut self.nodes, nodes), (&mut self.cells, cells)] {
            values.chunks_exact_mut(layout.len()).for_each(|values| layout.reset(values));
        }
    }

    /// Volumetric strains of skeleton and liquid in a cell, for points of a body.
    #[inline(always)]
    pub fn cell_strains(&self, body: u32, entries: usize, cell: usize) -> [f64; 2] {
        let [volume, solid, moved, liquid] =
            self.cells[self.materials[body as usize] * entries + cell].to_array();
        [solid / volume, if moved > 0.0 { liquid / moved } else { 0.0 }]
    }

    /// Averages the strains of cells at their nodes (6.35), and then the nodal strains in the cells (6.36).
    fn average_over_nodes<const D: usize>(
        &mut self,
        layouts: [&Layout<D>; 2],
        cells: &impl AveragingCells<D>,
    ) {
        let [of_nodes, of_cells] = layouts;
        let values = self.cells.chunks_exact_mut(of_cells.len());
        for (values, nodes) in values.zip(self.nodes.chunks_exact_mut(of_nodes.len())) {
            let row = of_nodes.strides()[0];
            of_nodes.for_each_active_node_range(nodes, |number, active, line| {
                for node in active {
                    let mut sum = Vector4::ZERO;
                    cells.for_each_cell_around(number * row + node, |cell, _| {
                        let [volume, solid, moved, liquid] = values[cell].to_array();
                        if volume > 0.0 {
                            let size = cells.volume(cell);
                            sum += Vector4::new([size, size * solid / volume, 0.0, 0.0]);
                            if moved > 0.0 {
                                sum += Vector4::new([0.0, 0.0, size, size * liquid / moved]);
                            }
                        }
                    });
                    line[node] = sum;
                }
            });
            let row = of_cells.strides()[0];
            of_cells.for_each_active_node_range(values, |number, active, line| {
                for cell in active {
                    let [volume, _, moved, _] = line[cell].to_array();
                    if volume <= 0.0 {
                        continue;
                    }
                    let (mut count, mut mean) = (0.0, [0.0; 2]);
                    cells.corners(number * row + cell, |node| {
                        let [sizes, solid, wet, liquid] = nodes[node].to_array();
                        count += 1.0;
                        mean[0] += solid / sizes;
                        mean[1] += if wet > 0.0 { liquid / wet } else { 0.0 };
                    });
                    let wet = if moved > 0.0 { count } else { 0.0 };
                    line[cell] = Vector4::new([count, mean[0], wet, mean[1]]);
                }
            });
        }
    }
}

/// Sets the volumetric strain of a motion to `dilation`, except for the fraction `kept` of its original one. The first `normal` normal
/// components are changed: two in plane strain, else three.
#[inline(always)]
pub fn set_volumetric(motion: &mut Motion, normal: usize, dilation: f64, kept: f64) {
    let own: f64 = (0..normal).map(|c| motion.velocity_gradient_dt.0[c][c]).sum();
    let extra = (1.0 - kept) * (dilation - own) / normal as f64;
    for c in 0..normal {
        motion.velocity_gradient_dt.0[c][c] += extra;
        motion.deformation.0[c][c] += extra;
    }
}

/// Fraction of the volumetric strain that a point of a fluid retains, divided by its pressure over bulk modulus. Averages leave motions
/// within a cell without stiffness, and those grow under a pressure.
const OWN_STRAIN_FACTOR: f64 = 40.0;

/// Fractions of the volumetric strains that points of a fluid retain, from their stresses (Pa).
pub fn own_strain_shares(
    material: &dyn Material,
    stress: &[SymTensor],
    states: &StateBlock,
    kept: &mut [f64],
) {
    material.wave_moduli(stress, states, kept);
    for (kept, stress) in kept.iter_mut().zip(stress) {
        *kept = (OWN_STRAIN_FACTOR * stress.pressure().max(0.0) / *kept).min(1.0);
    }
}

/// Function that computes volumetric strains of skeleton and liquid for a range of points.
type StrainReader<'a, const D: usize> = dyn Fn(&PointSet<D>, Range<usize>, &mut [[f64; 2]]) + Sync + 'a;

/// Averages the volumetric strain increments of the step. `read` computes those of skeleton and liquid for a range of points.
pub fn average_strains<const D: usize>(
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    strains: &mut CellStrains,
    read: &StrainReader<'_, D>,
) {
    if !strains.is_shared() {
        return;
    }
    let layouts = [&background.layout, background.cell_layout()];
    strains.reset(layouts);
    let (view, [_, of_cells]) = (background.grid_view(), layouts);
    let CellStrains { materials, cells, .. } = &mut *strains;
    for (material, cells) in cells.chunks_exact_mut(of_cells.len()).enumerate() {
        let of_material =
            |set: &&PointSet<D>| materials[set.body as usize] == material && set.rigid.is_none();
        of_cells.for_each_slab(cells, |slab, window, offset| {
            let (mut all, mut places) = ([[0.0; 2]; BLOCK_SIZE], [0; BLOCK_SIZE]);
            for set in bodies.sets.iter().filter(of_material) {
                let wet = set.pore.as_ref().is_some_and(|pore| pore.fluid.is_some());
                for block in set.blocks_of(slab) {
                    let (all, places) = (&mut all[..block.len()], &mut places[..block.len()]);
                    read(set, block.clone(), all);
                    set.domain.as_slice().range(block.clone()).cells(
                        &view,
                        &set.points.position[block.clone()],
                        places,
                    );
                    for ((p, cell), [solid, liquid]) in block.zip(&*places).zip(&*all) {
                        let volume = set.points.volume[p];
                        let moved = if wet { volume } else { 0.0 };
                        window[*cell - offset] +=
                            Vector4::new([volume, volume * solid, moved, moved * liquid]);
                    }
                }
            }
        });
    }
    if !strains.nodes.is_empty() {
        if background.is_meshed() {
            strains.average_over_nodes(layouts, &background.mesh_cells());
        } else {
            strains.average_over_nodes(layouts, &background.grid_cells());
        }
    }
}

/// Averages the volumetric strain increments of one phase, if the options require it.
pub fn average_strains_of_one_phase<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    (nodes, read): (&VelocityFields, VelocitySource),
    strains: &mut CellStrains,
) {
    average_strains(background, bodies, strains, &|set, block, out| {
        let points = set.point_slice().range(block);
        let mut all = [InterpolatedMotion::ZERO; BLOCK_SIZE];
        let reads = &mut all[..points.len()];
        nodes.g2p(read, background, set.field, &points, reads);
        for ((out, read), position) in out.iter_mut().zip(&*reads).zip(points.position) {
            *out = [clock.dt * background.dilation(read, position[0]), 0.0];
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::background_grid::averaging_cells::GridCells;
    use colluvium_constitutive::{Mat3, PoreFluidState};
    use colluvium_grid::{Grid, GridView, LinearBasis, Mesh};

    fn motion(gradient: [[f64; 3]; 3]) -> Motion {
        let mut deformation = gradient;
        (0..3).for_each(|c| deformation[c][c] += 1.0);
        let (gradient, deformation) = (Mat3(gradient), Mat3(deformation));
        Motion {
            deformation,
            velocity_gradient_dt: gradient,
            dt: 1.0,
            density: 1.0,
            size: 1.0,
            pore: PoreFluidState::default(),
        }
    }

    #[test]
    fn the_trace_becomes_the_shared_one_and_the_rest_stays() {
        // sheet: mpm A-35.
        let start = [[0.01, 0.02, 0.0], [0.005, -0.03, 0.0], [0.0; 3]];
        let mut plane = motion(start);
        set_volumetric(&mut plane, 2, 0.004, 0.0);
        let g = plane.velocity_gradient_dt.0;
        assert!((g[0][0] + g[1][1] - 0.004).abs() < 1e-16 && g[2][2] == 0.0, "nothing out of the plane");
        assert!((g[0][0] - g[1][1] - 0.04).abs() < 1e-16 && g[0][1] == 0.02 && g[1][0] == 0.005);
        let mut solid = motion(start);
        set_volumetric(&mut solid, 3, 0.004, 0.0);
        let g = solid.velocity_gradient_dt.0;
        assert!(((0..3).map(|c| g[c][c]).sum::<f64>() - 0.004).abs() < 1e-16);
        assert!((g[0][0] - g[2][2] - 0.01).abs() < 1e-16);
        let determinant = solid.deformation.determinant();
        assert!((determinant - 1.0 - 0.004).abs() < 1e-3, "and the deformation with it");
    }

    /// Strains of the cells of a 3 × 2 grid after passing through the nodes; cells without points are `None`.
    fn smoothed_strains(strains: [[Option<f64>; 2]; 3]) -> [[f64; 2]; 3] {
        let grid = Grid::new([0.0; 2], [3.0, 2.0], 1.0).unwrap();
        let mut layout = Layout::new::<2, LinearBasis>(&grid);
        layout.add_points(&[[0.5, 0.5], [1.5, 0.5], [2.5, 1.5]]);
        let mesh = Mesh::default();
        let view = GridView::new(&grid, &mesh, &layout);
        let number = |i: usize, j: usize| view.lowest_node(&[i as f64 + 0.5, j as f64 + 0.5]);
        let (cells, nodes) = (vec![Vector4::ZERO; layout.len()], vec![Vector4::ZERO; layout.len()]);
        let mut shared = CellStrains { materials: vec![0], cells, nodes };
        for (i, column) in strains.iter().enumerate() {
            for (j, strain) in column.iter().enumerate() {
                if let Some(strain) = strain {
                    shared.cells[number(i, j)] = Vector4::new([0.7, 0.7 * strain, 0.0, 0.0]);
                }
            }
        }
        let grid_cells = GridCells { grid: &grid, strides: layout.strides(), ghosts: 0, axisymmetric: false };
        shared.average_over_nodes([&layout; 2], &grid_cells);
        std::array::from_fn(|i| {
            std::array::from_fn(|j| shared.cell_strains(0, layout.len(), number(i, j))[0])
        })
    }

    #[test]
    fn uniform_strain_passes_unchanged() {
        for column in smoothed_strains([[Some(0.3); 2], [Some(0.3); 2], [None, Some(0.3)]]) {
            assert!(column.iter().all(|s| s.is_nan() || (s - 0.3).abs() < 1e-15), "{column:?}");
        }
    }

    #[test]
    fn nodes_average_the_cells_around_them_and_cells_their_nodes() {
        // One row of three cells: interior nodes have two adjacent cells, nodes at the ends one.
        let out = smoothed_strains([[Some(1.0), None], [Some(2.0), None], [Some(6.0), None]]);
        let exact = [(1.0 + 1.5) / 2.0, (1.5 + 4.0) / 2.0, (4.0 + 6.0) / 2.0];
        for (column, exact) in out.iter().zip(exact) {
            assert!((column[0] - exact).abs() < 1e-15, "{out:?}");
        }
    }
}
