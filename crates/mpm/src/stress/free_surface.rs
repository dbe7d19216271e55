//! Free surface of liquids (sheet: mpm §2.18; Anura3D manual 2021, eqs. 6.38–6.40).
//!
//! Nodes have a fill ratio: the volume of the mass of the points at rest, over the volume of the cells around that contain a point. Where
//! the ratio interpolated to a liquid point is small the point lies on the free surface: it has no stress and the volume of that state, so
//! that it returns to the liquid in its state at rest. Weights are those of linear shape functions, for any shape of the solver, since the
//! ratio is one of cells.

use colluvium_case::description::{Body, Space};
use colluvium_case::{Case, CaseError};
use colluvium_constitutive::BLOCK_SIZE;
use colluvium_grid::{
    DomainSlice, Domains, FixedDomain, GridView, Layout, NodeRange, PointSlice, Transfers, Vector4,
};
use rayon::prelude::*;

use crate::MpmOptions;
use crate::background_grid::BackgroundGrid;
use crate::background_grid::averaging_cells::{AveragingCells, GridCells};
use crate::points::bodies::Bodies;
use crate::points::point_set::{PointColumns, PointSet};
use colluvium_case::CaseErrorKind;

/// Detection of the free surface.
pub struct FreeSurface<const D: usize> {
    /// Fill ratio below which a point is on the surface.
    factor: f64,
    /// Nodes of the cells.
    layout: Layout<D>,
    /// `Σ N m_p/ρ_0` (m³) of the nodes, in every lane.
    sums: Vec<Vector4>,
    /// Whether a cell holds a point.
    has_point: Vec<bool>,
    /// Fill ratios of the nodes, in every lane.
    fill: Vec<Vector4>,
    /// Transfers with linear functions, for any shape of the solver.
    transfers: &'static dyn Transfers<D>,
    /// On a grid, domains of no width, one for each point.
    zero_width_domains: Option<Vec<FixedDomain>>,
    /// Densities at rest of the bodies of the case (kg/m³).
    densities: Vec<f64>,
    /// Whether each body of the case is a liquid.
    liquid: Vec<bool>,
}

/// Free-surface detection of a case; `None` if it is off. `limit` is the largest number of points of a body.
pub fn free_surface<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    background: &BackgroundGrid<D>,
    limit: usize,
) -> Result<Option<Box<FreeSurface<D>>>, CaseError> {
    let Some(factor) = options.free_surface else { return Ok(None) };
    let spec = |body: &Body| &case.materials[&body.material];
    let liquid: Vec<bool> = case.bodies.iter().map(|body| spec(body).is_fluid()).collect();
    if !liquid.contains(&true) {
        return Err(CaseError::new(
            "methods.mpm.free_surface",
            CaseErrorKind::coded("needs-other-key", "needs a body of a fluid"),
        ));
    }
    if !case.domain.periodic.is_empty() {
        return Err(CaseError::new(
            "methods.mpm.free_surface",
            CaseErrorKind::coded("incompatible-options", "is not available in a periodic domain"),
        ));
    }
    if case.space == Space::Axisymmetric {
        return Err(CaseError::new(
            "methods.mpm.free_surface",
            CaseErrorKind::coded("incompatible-options", "is not available in axisymmetry"),
        ));
    }
    let BackgroundGrid { grid, layout: own, elements, transfers, linear_transfers: linear, .. } = background;
    let on_grid = || Layout::with_basis(grid, &linear.basis_1d()).with_slabs_of(own);
    let layout = elements.as_ref().map_or_else(on_grid, |_| own.clone());
    Ok(Some(Box::new(FreeSurface {
        factor,
        sums: vec![Vector4::ZERO; layout.len()],
        has_point: vec![false; elements.as_ref().unwrap_or(&layout).len()],
        fill: vec![Vector4::ZERO; layout.len()],
        layout,
        transfers: if background.is_meshed() { *transfers } else { *linear },
        zero_width_domains: (!background.is_meshed()).then(|| vec![FixedDomain; limit]),
        densities: case.bodies.iter().map(|body| spec(body).density()).collect(),
        liquid,
    })))
}

impl<const D: usize> FreeSurface<D> {
    /// Grid view of the nodes of the ratios.
    fn grid_view<'a>(&self, background: &'a BackgroundGrid<D>) -> GridView<'a, D> {
        GridView::new(&background.grid, &background.mesh, &self.layout)
    }

    /// Resizes the arrays of points to a number of points of the largest body.
    pub fn resize_point_buffers(&mut self, max_points: usize) {
        if let Some(domains) = &mut self.zero_width_domains {
            domains.resize(max_points, FixedDomain);
        }
    }

    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.sums[..]) + size_of_val(&self.has_point[..]) + size_of_val(&self.fill[..])
    }

    /// Computes the fill ratios of the nodes.
    fn compute_fill(&mut self, background: &BackgroundGrid<D>, sets: &[PointSet<D>]) {
        let Self { layout, sums, has_point, transfers, zero_width_domains: thin, densities, .. } = self;
        let (layout, thin) = (&*layout, thin.as_deref());
        let view = GridView::new(&background.grid, &background.mesh, layout);
        sums.fill(Vector4::ZERO);
        has_point.fill(false);
        layout.for_each_slab(sums, |slab, window, offset| {
            let mut volumes = [Vector4::ZERO; BLOCK_SIZE];
            for set in sets {
                let scale = 1.0 / densities[set.body as usize];
                let points = points(thin, &set.points.position, &set.domain, &set.extent);
                for block in set.blocks_of(slab) {
                    let masses = &set.points.mass[block.clone()];
                    volumes
                        .iter_mut()
                        .zip(masses)
                        .for_each(|(value, mass)| *value = Vector4::splat(scale * mass));
                    let (to, volumes) =
                        (NodeRange { nodes: &mut *window, first: offset }, &volumes[..block.len()]);
                    transfers.p2g_values(&view, &points.range(block), to, volumes, None);
                }
            }
        });
        background.elements.as_ref().unwrap_or(layout).for_each_slab(has_point, |slab, window, offset| {
            for set in sets {
                let points = points(thin, &set.points.position, &set.domain, &set.extent);
                for p in set.slabs[slab]..set.slabs[slab + 1] {
                    window[points.domain.cell(p, &view, &set.points.position[p]) - offset] = true;
                }
            }
        });
        if background.is_meshed() {
            self.fill_ratios_from_sums(&background.mesh_cells());
        } else {
            let (grid, strides) = (&background.grid, self.layout.strides());
            self.fill_ratios_from_sums(&GridCells { grid, strides, ghosts: 0, axisymmetric: false });
        }
    }

    /// Computes fill ratios from the sums.
    fn fill_ratios_from_sums(&mut self, cells: &impl AveragingCells<D>) {
        let Self { layout, sums, has_point, fill, .. } = self;
        let row = layout.strides()[0];
        fill.par_chunks_mut(row).enumerate().for_each(|(number, line)| {
            for (place, ratio) in line.iter_mut().enumerate() {
                let node = number * row + place;
                let volume = sums[node].as_array()[0];
                if volume == 0.0 {
                    *ratio = Vector4::ZERO;
                    continue;
                }
                let mut around = 0.0;
                cells.for_each_cell_around(node, |cell, _| {
                    if has_point[cell] {
                        around += cells.volume(cell);
                    }
                });
                *ratio = Vector4::splat(volume / around * corners(cells) as f64);
            }
        });
    }
}

/// View of the points of a set for the fill ratios; on a grid their domains have the width zero.
fn points<'a, const D: usize>(
    thin: Option<&'a [FixedDomain]>,
    position: &'a [[f64; D]],
    domain: &'a Domains<D>,
    extent: &'a [f64; D],
) -> PointSlice<'a, D> {
    match thin {
        None => PointSlice { position, domain: domain.as_slice(), extent },
        Some(thin) => {
            PointSlice { position, domain: DomainSlice::Fixed(&thin[..position.len()]), extent: &[0.0; D] }
        }
    }
}

/// Number of corners of a cell.
fn corners<const D: usize, C: AveragingCells<D>>(_cells: &C) -> usize {
    C::CORNERS
}

/// Sets the stress of liquid points at the free surface to zero.
pub fn free_surface_correction<const D: usize>(
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    surface: &mut Option<Box<FreeSurface<D>>>,
) {
    let Some(surface) = surface else { return };
    surface.compute_fill(background, &bodies.sets);
    for set in bodies.sets.iter_mut().filter(|set| surface.liquid[set.body as usize]) {
        remove_surface_stress(background, surface, set);
    }
}

/// Sets the stress of points with a small fill ratio to zero.
fn remove_surface_stress<const D: usize>(
    background: &BackgroundGrid<D>,
    surface: &FreeSurface<D>,
    set: &mut PointSet<D>,
) {
    let view = surface.grid_view(background);
    let density = surface.densities[set.body as usize];
    let PointSet { points: PointColumns { stress, volume, mass, position, .. }, domain, extent, .. } = set;
    let points = points(surface.zero_width_domains.as_deref(), position, domain, extent);
    let own = stress.par_chunks_mut(BLOCK_SIZE).zip(volume.par_chunks_mut(BLOCK_SIZE));
    own.zip(mass.par_chunks(BLOCK_SIZE)).enumerate().for_each(|(number, ((stresses, volumes), masses))| {
        let first = number * BLOCK_SIZE;
        let mut all = [Vector4::ZERO; BLOCK_SIZE];
        let ratios = &mut all[..stresses.len()];
        let points = points.range(first..first + stresses.len());
        surface.transfers.g2p_values(&view, &points, &surface.fill, ratios);
        for (k, ratio) in ratios.iter().enumerate() {
            if ratio.as_array()[0] <= surface.factor {
                stresses[k].0 = [0.0; 6];
                volumes[k] = masses[k] / density;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MpmSolver;
    use crate::setup::tests::initial_solver;

    /// A stack of water of two whole cells and half a cell, in a tank as wide.
    fn case() -> Case {
        let text = r#"{
            "title": "stack", "space": "plane-strain", "domain": { "min": [0, 0], "max": [3, 4] }, "gravity": [0, -1],
            "materials": { "water": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e6 } },
            "bodies": [{ "name": "b", "material": "water", "shape": { "kind": "box", "min": [0, 0], "max": [3, 2.5] },
                         "stress": { "kind": "uniform", "value": [-10, -10, -10, 0, 0, 0] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 1, "points_per_cell": 20, "shape": "linear", "free_surface": 0.7 } }
        }"#;
        Case::from_json(text).unwrap()
    }

    fn stack() -> MpmSolver<2> {
        initial_solver(&case())
    }

    #[test]
    fn fill_ratios_are_those_of_the_sheet() {
        let mut solver = stack();
        let mut surface = solver.averages.free_surface.take().unwrap();
        surface.compute_fill(&solver.background, &solver.bodies.sets);
        // A surface cell filled to f = 0.5: f² above and (1 + 2 f - f²)/2 below it, but for the points' midpoint rule.
        let at = |x: usize, y: usize| surface.fill[x * surface.layout.strides()[0] + y].as_array()[0];
        for x in 0..4 {
            assert!((at(x, 3) - 0.25).abs() < 1e-3, "{}", at(x, 3));
            assert!((at(x, 2) - 0.875).abs() < 1e-3, "{}", at(x, 2));
            assert!((at(x, 1) - 1.0).abs() < 1e-12 && (at(x, 0) - 1.0).abs() < 1e-2 && at(x, 4) == 0.0);
        }
    }

    #[test]
    fn points_near_the_surface_carry_no_stress() {
        let mut solver = stack();
        solver.bodies.sets[0].points.volume.iter_mut().for_each(|volume| *volume *= 0.9);
        let MpmSolver { background, bodies, averages, .. } = &mut solver;
        free_surface_correction(background, bodies, &mut averages.free_surface);
        // Between 0.875 and 0.25 the ratio falls to 0.7 at 0.28 of the cell.
        let set = &solver.bodies.sets[0];
        for p in 0..set.len() {
            let relieved = set.points.position[p][1] > 2.28;
            assert_eq!(set.points.stress[p].0 == [0.0; 6], relieved, "{:?}", set.points.position[p]);
            assert!(
                (set.points.volume[p] * 1000.0 / set.points.mass[p] - if relieved { 1.0 } else { 0.9 }).abs()
                    < 1e-12
            );
        }
    }

    #[test]
    fn triangles_have_the_ratios_of_squares() {
        // The function of a node of these triangles, summed along x, is the hat of the squares: f² and (1 + 2 f - f²)/2, for
        // which the points give 2/9 and 8/9: three to a triangle, at 1/6, 1/6 and 2/3, or 1/3, 5/6 and 5/6 of its height.
        let mut case = case();
        let options = case.methods.get_mut("mpm").unwrap();
        options["mesh"] = serde_json::json!({ "kind": "box" });
        options["points_per_cell"] = 2.into();
        let mut solver = initial_solver::<2>(&case);
        let mut surface = solver.averages.free_surface.take().unwrap();
        surface.compute_fill(&solver.background, &solver.bodies.sets);
        for (x, ratio) in
            solver.background.mesh.nodes().iter().zip(&surface.fill).filter(|(x, _)| x[0] > 0.0 && x[0] < 3.0)
        {
            let exact = if x[1] > 3.5 {
                0.0
            } else if x[1] > 2.5 {
                2.0 / 9.0
            } else if x[1] > 1.5 {
                8.0 / 9.0
            } else {
                1.0
            };
            assert!((ratio.as_array()[0] - exact).abs() < 1e-12, "{x:?}: {ratio:?} for {exact}");
        }
        free_surface_correction(&solver.background, &mut solver.bodies, &mut Some(surface));
        let set = &solver.bodies.sets[0];
        let relieved = |p: usize| set.points.stress[p].0 == [0.0; 6];
        let within = |p: &usize| set.points.position[*p][0] > 1.0 && set.points.position[*p][0] < 2.0;
        // Linear between 8/9 at 2 m and 2/9 at 3 m: 0.7 at 2.283 m.
        for p in (0..set.len()).filter(within) {
            assert_eq!(relieved(p), set.points.position[p][1] > 2.283, "{:?}", set.points.position[p]);
        }
    }
}
