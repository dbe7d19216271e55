//! Integration of the internal force cell by cell (MPM-MIXED, and the Gauss integration of Beuth; sheet: mpm §2.16).
//!
//! Cells that are full of material exert the force of the average stress of their points over the whole cell, without cell-crossing noise;
//! in other cells each point exerts its own force. With Gauss integration every cell with a point counts as full. With one stress for the
//! cell, one Gauss point at its centre and two along each axis give the same force. With a pore fluid this holds for the total stress and
//! the pore pressure.

use colluvium_case::{Case, CaseError};
use colluvium_constitutive::SymTensor;
use colluvium_grid::{Layout, NodalState, Vector4};
use rayon::prelude::*;

use crate::MpmOptions;
use crate::background_grid::BackgroundGrid;
use crate::background_grid::averaging_cells::AveragingCells;
use crate::clock::Clock;
use crate::config::{InternalForceIntegration, ShapeFunctions};
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;
use crate::points::pore_fluid::{LIQUID, SOLID};
use crate::stress::force_columns::force_columns;

/// Average stresses of cells ([`crate::background_grid::averaging_cells`]), by velocity field. Empty where every point exerts its own
/// force.
#[derive(Clone, Debug, Default)]
pub struct CellStresses {
    /// Volume times total stress, then the volume itself and volume times pore pressure.
    cells: Vec<[Vector4; 2]>,
    /// Whether a cell is full.
    is_full: Vec<bool>,
}

/// Rejects options that the integration over cells does not support.
pub fn check_supported(options: &MpmOptions) -> Result<(), CaseError> {
    if options.integration == InternalForceIntegration::Points {
        return Ok(());
    }
    let refuse = |problem: &str| Err(CaseError::new("methods.mpm.integration", problem));
    if options.shape != ShapeFunctions::Linear {
        return refuse(
            "by cells (mixed, gauss) needs shape linear: other shape functions extend beyond a cell",
        );
    }
    if options.formulation == crate::LagrangianFormulation::TotalLagrangian {
        return refuse("by cells (mixed, gauss) is not available with total-lagrangian");
    }
    Ok(())
}

/// Rejects `mixed_reset` for materials whose stress is a function of their state, and for velocity fields with several materials or with
/// dry and saturated points. There the average stress is no valid stress of a point.
pub fn check_stress_reset<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    sets: &[PointSet<D>],
) -> Result<(), CaseError> {
    let refuse = |problem: String| Err(CaseError::new("methods.mpm.mixed_reset", problem));
    if !options.mixed_reset {
        return Ok(());
    }
    let name = |set: &PointSet<D>| &case.bodies[set.body as usize].material;
    let deformable = || sets.iter().filter(|set| set.rigid.is_none());
    if let Some(set) = deformable().find(|set| !set.material.is_hypoelastic()) {
        return refuse(format!(
            "the material {:?} ({}) computes its stress from its own state, not from the stress of the step \
             before",
            name(set),
            set.material.name()
        ));
    }
    let wet = |set: &PointSet<D>| set.pore.as_ref().is_some_and(|pore| pore.fluid.is_some());
    for set in deformable() {
        let differs = |other: &&PointSet<D>| name(other) != name(set) || wet(other) != wet(set);
        if let Some(other) = deformable().filter(|other| other.field == set.field).find(differs) {
            let [one, two] = [set, other].map(|set| &case.bodies[set.body as usize].name);
            return refuse(format!(
                "the bodies {one:?} and {two:?} may have points in one cell, and differ in material or \
                 pore_fluid: the average is a valid stress of neither"
            ));
        }
    }
    Ok(())
}

impl CellStresses {
    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.cells[..]) + size_of_val(&self.is_full[..])
    }

    /// Returns empty arrays over the cells for the options.
    pub fn new<const D: usize>(options: &MpmOptions, cells: &Layout<D>, fields: usize) -> Self {
        let length =
            if options.integration == InternalForceIntegration::Points { 0 } else { fields * cells.len() };
        Self { cells: vec![[Vector4::ZERO; 2]; length], is_full: vec![false; length] }
    }

    /// Full cells of a field, of `len` entries, whose internal force is not summed over their points.
    #[inline(always)]
    pub fn full_cells(&self, field: usize, len: usize) -> Option<&[bool]> {
        self.is_full.get(field * len..(field + 1) * len)
    }

    /// Whether stresses are averaged over cells.
    fn is_used(&self) -> bool {
        !self.cells.is_empty()
    }

    /// Sets the active entries to zero.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        self.cells.chunks_exact_mut(layout.len()).for_each(|cells| layout.reset(cells));
        self.is_full.chunks_exact_mut(layout.len()).for_each(|full| layout.reset(full));
    }

    /// Finds the full cells: cells whose neighbours across all faces contain points, and cells filled by more than the fraction `fill`.
    fn mark_full<const D: usize>(&mut self, layout: &Layout<D>, cells: &impl AveragingCells<D>, fill: f64) {
        let sums = self.cells.chunks_exact(layout.len());
        for (sums, full) in sums.zip(self.is_full.chunks_exact_mut(layout.len())) {
            let volume = |cell: usize| sums[cell][1].as_array()[2];
            layout.for_each_active_node_range(full, |row, active, line| {
                for number in active {
                    let cell = row * layout.strides()[0] + number;
                    if volume(cell) <= 0.0 {
                        continue;
                    }
                    let mut surrounded = true;
                    cells.neighbours(cell, |other| surrounded &= volume(other) > 0.0);
                    line[number] = surrounded || volume(cell) > fill * cells.volume(cell);
                }
            });
        }
    }

    /// Adds the forces of the full cells around the nodes.
    fn add_forces<const D: usize, N: CellForceTarget>(
        &self,
        nodes: &mut [N],
        [of_nodes, of_cells]: [&Layout<D>; 2],
        cells: &impl AveragingCells<D>,
    ) {
        let fields = self.cells.chunks_exact(of_cells.len()).zip(self.is_full.chunks_exact(of_cells.len()));
        for (nodes, (sums, full)) in nodes.chunks_exact_mut(of_nodes.len()).zip(fields) {
            of_nodes.for_each_active_node_range(nodes, |row, active, line| {
                for number in active {
                    cells.for_each_cell_around(row * of_nodes.strides()[0] + number, |cell, corner| {
                        if full[cell] {
                            line[number].add_cell_force(&sums[cell], cells.gradient_integrals(cell, corner));
                        }
                    });
                }
            });
        }
    }
}

/// Node that receives forces of cells.
pub trait CellForceTarget: Send {
    /// Adds the force of a full cell to a node. `sums` are the cell sums, `slopes` the integrals of the gradient of the shape function and,
    /// in axisymmetry, of the function over the radius.
    fn add_cell_force<const D: usize>(&mut self, sums: &[Vector4; 2], slopes: ([f64; D], f64));
}

impl CellForceTarget for NodalState {
    #[inline(always)]
    fn add_cell_force<const D: usize>(&mut self, sums: &[Vector4; 2], slopes: ([f64; D], f64)) {
        self.force -= force(&cell_average(sums).0, slopes);
    }
}

/// Skeleton and liquid: their equations are those of the mixture and of the liquid.
impl CellForceTarget for [NodalState; 2] {
    #[inline(always)]
    fn add_cell_force<const D: usize>(&mut self, sums: &[Vector4; 2], slopes: ([f64; D], f64)) {
        let (total, pressure) = cell_average(sums);
        self[SOLID].force -= force(&total, slopes);
        self[LIQUID].force -= force(&SymTensor::isotropic(-pressure), slopes);
    }
}

/// Average total stress and pore pressure of a cell from its sums.
#[inline(always)]
fn cell_average(sums: &[Vector4; 2]) -> (SymTensor, f64) {
    let [a, b] = sums.map(Vector4::to_array);
    (SymTensor([a[0], a[1], a[2], a[3], b[0], b[1]]) * (1.0 / b[2]), b[3] / b[2])
}

/// Force `σ ∫∇N` of the stress of a cell, and along the radius the hoop stress times `∫N/r`.
#[inline(always)]
fn force<const D: usize>(stress: &SymTensor, (slope, hoop): ([f64; D], f64)) -> Vector4 {
    let columns = force_columns::<D>(stress, -1.0);
    let along = columns.into_iter().zip(slope).map(|(column, slope)| column * slope);
    along.fold(Vector4::new([stress.0[2] * hoop, 0.0, 0.0, 0.0]), |sum, part| sum + part)
}

/// Computes the average stresses of the cells and finds the full cells.
pub fn average_stresses<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    stresses: &mut CellStresses,
) {
    if !stresses.is_used() {
        return;
    }
    let layout = background.cell_layout();
    stresses.reset(layout);
    let view = background.grid_view();
    for (field, cells) in stresses.cells.chunks_exact_mut(layout.len()).enumerate() {
        let of_field = |set: &&PointSet<D>| set.field == field;
        layout.for_each_slab(cells, |slab, window, offset| {
            for set in bodies.sets.iter().filter(of_field) {
                let domain = set.domain.as_slice();
                for p in set.slabs[slab]..set.slabs[slab + 1] {
                    let cell = domain.cell(p, &view, &set.points.position[p]);
                    let (s, pressure, volume) =
                        (set.total_stress(p).0, set.pore_pressure(p), set.points.volume[p]);
                    window[cell - offset][0] += Vector4::new([s[0], s[1], s[2], s[3]]) * volume;
                    window[cell - offset][1] += Vector4::new([s[4], s[5], 1.0, pressure]) * volume;
                }
            }
        });
    }
    let gauss = clock.options.integration == InternalForceIntegration::Gauss;
    let fill = if gauss { 0.0 } else { clock.options.full_cell };
    if background.is_meshed() {
        stresses.mark_full(layout, &background.mesh_cells(), fill);
    } else {
        stresses.mark_full(layout, &background.grid_cells(), fill);
    }
    if clock.options.mixed_reset {
        reset_stresses(background, bodies, stresses);
    }
}

/// Sets stress and pore pressure of the points of full cells to the cell averages (`mixed_reset`).
fn reset_stresses<const D: usize>(
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    stresses: &CellStresses,
) {
    let cells = background.cell_layout().len();
    let view = background.grid_view();
    for set in bodies.sets.iter_mut().filter(|set| set.rigid.is_none()) {
        let first = set.field * cells;
        let domain = set.domain.as_slice();
        let of_cell = |(p, position): (usize, &[f64; D])| {
            let cell = first + domain.cell(p, &view, position);
            stresses.is_full[cell].then(|| cell_average(&stresses.cells[cell]))
        };
        let places = || set.points.position.par_iter().enumerate().map(of_cell);
        set.points.stress.par_iter_mut().zip(places()).for_each(|(own, average)| {
            *own = average.map_or(*own, |(total, pressure)| total + SymTensor::isotropic(pressure));
        });
        if let Some(pore) = set.pore.as_mut().filter(|pore| pore.fluid.is_some()) {
            pore.points.pressure.par_iter_mut().zip(places()).for_each(|(own, average)| {
                *own = average.map_or(*own, |(_, pressure)| pressure);
            });
        }
    }
}

/// Adds the internal forces of the full cells to the nodes of all phases.
pub fn add_cell_forces<const D: usize>(
    background: &BackgroundGrid<D>,
    stresses: &CellStresses,
    nodes: &mut [impl CellForceTarget],
) {
    if !stresses.is_used() {
        return;
    }
    let layouts = [&background.layout, background.cell_layout()];
    if background.is_meshed() {
        stresses.add_forces(nodes, layouts, &background.mesh_cells());
    } else {
        stresses.add_forces(nodes, layouts, &background.grid_cells());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MpmSolver;
    use crate::setup::tests::initial_solver;
    use colluvium_case::Case;
    use colluvium_points::ScratchBuffers;
    use serde_json::{Value, json};

    /// Internal forces (N) at the nodes 1 and 2 of the bar of [`nodal_loads`], without the middle point of the second cell if
    /// `gap`.
    fn forces(shape: &str, integration: &str, gap: bool) -> [f64; 2] {
        let [_, first, second, _] = nodal(shape, integration, if gap { &[4] } else { &[] });
        [first, second]
    }

    /// The bar of [`nodal_loads`] with keys of `more` in place of its own.
    fn bar_case(shape: &str, integration: &str, more: &Value) -> Case {
        let mut text = json!({
            "title": "bar", "space": "1d", "domain": { "min": [0], "max": [4] }, "gravity": [0],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [3] },
                         "stress": { "kind": "uniform", "value": [7, 0, 0, 0, 0, 0] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 1, "points_per_cell": 3, "shape": shape, "integration": integration } }
        });
        text.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        Case::from_json(&text.to_string()).unwrap()
    }

    /// Internal forces (N) at the nodes of a bar of three cells of 1 m with three points each under 7 Pa, without those of
    /// the points that are `out`.
    fn nodal(shape: &str, integration: &str, out: &[u32]) -> [f64; 4] {
        let case = bar_case(shape, integration, &json!({}));
        let mut solver = initial_solver::<1>(&case);
        let set = &mut solver.bodies.sets[0];
        let outside = |x: &[f64; 1]| !out.iter().any(|i| (x[0] - (f64::from(*i) + 0.5) / 3.0).abs() < 1e-9);
        set.retain_where(|points, i| outside(&points.position[i]), &mut ScratchBuffers::default());
        solver.sort();
        solver.p2g_for_tests();
        [0, 1, 2, 3].map(|node| {
            -solver.nodes.nodal_states[node + solver.background.basis_1d.ghosts].force.to_array()[0]
        })
    }

    #[test]
    fn gauss_integration_uses_the_whole_volume_of_a_surface_cell() {
        // The upper two of the three points of the last cell are removed: a third of its volume is left. The forces of its two nodes are
        // ± σ Ω_p/h of the point, or ± σ of a full cell.
        for (integration, last) in [("points", 7.0 / 3.0), ("mixed", 7.0 / 3.0), ("gauss", 7.0)] {
            let [_, _, third, fourth] = nodal("linear", integration, &[7, 8]);
            assert!((fourth - last).abs() < 1e-14, "{integration}: {fourth}");
            assert!((third - (7.0 - last)).abs() < 1e-14, "{integration}: {third}");
        }
    }

    /// The bar in one phase, and with a fluid under a pressure that grows along it.
    fn resettable_bars() -> [Case; 2] {
        let reset = json!({ "mpm": { "cell_size": 1, "points_per_cell": 3, "shape": "linear", "integration": "mixed",
                                     "mixed_reset": true } });
        let fluid = json!({ "porosity": 0.5, "intrinsic_permeability": 1e-9, "density": 1,
                            "pressure": { "kind": "hydrostatic", "surface": 3 } });
        let wet = json!([{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [3] },
                           "pore_fluid": fluid }]);
        [
            bar_case("linear", "mixed", &json!({ "methods": reset })),
            bar_case("linear", "mixed", &json!({ "methods": reset, "bodies": wet, "gravity": [-9] })),
        ]
    }

    #[test]
    fn points_of_full_cells_get_the_cell_average_where_reset_is_requested() {
        for (case, wet) in resettable_bars().iter().zip([false, true]) {
            let mut solver = initial_solver::<1>(case);
            // Two of three points are left in the last cell.
            solver.bodies.sets[0].retain_where(
                |points, i| (points.position[i][0] - 8.5 / 3.0).abs() > 1e-9,
                &mut ScratchBuffers::default(),
            );
            solver.sort();
            let set = &mut solver.bodies.sets[0];
            for (p, stress) in set.points.stress.iter_mut().enumerate() {
                *stress = SymTensor([p as f64, 1.0, 2.0, 3.0, 4.0, 5.0]);
            }
            let before = set.pore.as_ref().map_or(vec![0.0; 8], |pore| pore.points.pressure.clone());
            let MpmSolver { clock, background, bodies, averages, .. } = &mut solver;
            average_stresses(clock, background, bodies, &mut averages.stresses);
            let stresses: Vec<f64> =
                solver.bodies.sets[0].points.stress.iter().map(|stress| stress.0[0]).collect();
            let exact = [1.0, 1.0, 1.0, 4.0, 4.0, 4.0, 6.0, 7.0];
            assert!(stresses.iter().zip(exact).all(|(s, e)| (s - e).abs() < 1e-13), "{wet}: {stresses:?}");
            assert!(
                solver.bodies.sets[0]
                    .points
                    .stress
                    .iter()
                    .all(|s| (s.0[1] - 1.0).abs() < 1e-13 && s.0[5] == 5.0)
            );
            let Some(pore) = &solver.bodies.sets[0].pore else { continue };
            let exact =
                [before[1], before[1], before[1], before[4], before[4], before[4], before[6], before[7]];
            assert!(
                pore.points.pressure.iter().zip(exact).all(|(p, e)| (p - e).abs() < 1e-12),
                "{:?}",
                pore.points.pressure
            );
        }
    }

    #[test]
    fn cells_with_unequal_numbers_of_points_exert_nodal_forces_unless_they_are_full() {
        // sheet: mpm S-04: 3, 2, 3 points of a third each under one stress.
        let [left, right] = forces("linear", "points", true);
        assert!((left - 7.0 / 3.0).abs() < 1e-14 && (right + 7.0 / 3.0).abs() < 1e-14, "{left}, {right}");
        for integration in ["mixed", "gauss"] {
            for force in forces("linear", integration, true) {
                assert!(force.abs() < 1e-14, "{integration}: {force}");
            }
        }
        for force in forces("ugimp", "points", false) {
            assert!(force.abs() < 1e-14, "domains that tile the line: {force}");
        }
    }
}
