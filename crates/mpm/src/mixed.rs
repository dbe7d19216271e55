//! Integration of the internal force cell by cell (MPM-MIXED, and the Gauss integration of Beuth; MPM sheet §2.16).
//!
//! Cells that are full of material pull at their nodes with the average stress of their points over the whole cell,
//! which has no cell-crossing noise; the points of the others pull one by one. With Gauss integration every cell that holds a
//! point counts as full. With one stress for the cell, one Gauss
//! point at its centre and two along each axis give the same force.

use colluvium_case::CaseError;
use colluvium_constitutive::SymTensor;
use colluvium_grid::{Basis, Grid, Lanes, Layout, Node};

use crate::MpmOptions;
use crate::config::{Integration, ShapeFunctions};
use crate::momentum::RowSums;
use crate::points::{PointDomain, PointSet, ground};
use crate::solver::MpmSolver;
use crate::strain::lowest_node;

/// The average stresses of cells, velocity field after velocity field; an entry is named by the cell's lowest node.
/// Empty where every point pulls by itself.
#[derive(Clone, Debug, Default)]
pub struct CellStresses {
    /// Volume times stress, and the volume itself in the last lane but one.
    cells: Vec<[Lanes; 2]>,
    /// Whether a cell is full.
    full: Vec<bool>,
}

/// Refuses what cells cannot integrate.
pub fn cleared(options: &MpmOptions, two_phase: bool) -> Result<(), CaseError> {
    if options.integration == Integration::Points {
        return Ok(());
    }
    let refuse = |problem: &str| Err(CaseError::new("methods.mpm.integration", problem));
    if options.shape != ShapeFunctions::Linear {
        return refuse(
            "by cells (mixed, gauss) needs shape linear: other shape functions reach beyond a cell",
        );
    }
    if options.formulation != crate::Formulation::UpdatedLagrangian {
        return refuse("by cells (mixed, gauss) needs formulation updated-lagrangian");
    }
    if two_phase {
        return refuse("by cells (mixed, gauss) is not available with a pore_fluid yet");
    }
    Ok(())
}

impl CellStresses {
    /// Empty arrays for what the options ask for.
    pub fn new<const D: usize>(options: &MpmOptions, layout: &Layout<D>, fields: usize) -> Self {
        let length = if options.integration != Integration::Points { fields * layout.len() } else { 0 };
        Self { cells: vec![[Lanes::ZERO; 2]; length], full: vec![false; length] }
    }

    /// Which cells of a field, of `len` entries, take the internal force from their points.
    #[inline(always)]
    pub fn full_cells(&self, field: usize, len: usize) -> Option<&[bool]> {
        self.full.get(field * len..(field + 1) * len)
    }

    fn is_used(&self) -> bool {
        !self.cells.is_empty()
    }

    /// Empties the active entries.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        self.cells.chunks_exact_mut(layout.len()).for_each(|cells| layout.reset(cells));
        self.full.chunks_exact_mut(layout.len()).for_each(|full| layout.reset(full));
    }
}

/// What the cells of a field are, and what they pull with.
struct CellForces<'a, const D: usize> {
    grid: &'a Grid<D>,
    layout: &'a Layout<D>,
    ghosts: usize,
    axisymmetric: bool,
    /// Share of its volume that a cell at the boundary of the material must hold to count as full; any for zero.
    fill: f64,
}

impl<const D: usize> CellForces<'_, D> {
    /// Index along each axis of the cell with the lowest node `entry`; `None` for a node that is no cell's lowest.
    fn cell(&self, entry: usize) -> Option<[usize; D]> {
        let mut rest = entry;
        let mut index = [0; D];
        for (axis, stride) in self.layout.strides().into_iter().enumerate() {
            index[axis] = (rest / stride).checked_sub(self.ghosts)?;
            rest %= stride;
            if index[axis] >= self.grid.cells[axis] {
                return None;
            }
        }
        Some(index)
    }

    fn radius(&self, cell: &[usize; D]) -> f64 {
        if self.axisymmetric { self.grid.origin[0] + (cell[0] as f64 + 0.5) * self.grid.cell } else { 1.0 }
    }

    fn is_full(&self, cells: &[[Lanes; 2]], entry: usize) -> bool {
        let volume = |entry: usize| cells[entry][1].as_array()[2];
        let Some(cell) = self.cell(entry) else { return false };
        if volume(entry) <= 0.0 {
            return false;
        }
        let strides = self.layout.strides();
        let surrounded = (0..D).all(|axis| {
            (cell[axis] == 0 || volume(entry - strides[axis]) > 0.0)
                && (cell[axis] + 1 == self.grid.cells[axis] || volume(entry + strides[axis]) > 0.0)
        });
        surrounded || volume(entry) > self.fill * self.grid.cell.powi(D as i32) * self.radius(&cell)
    }

    /// Force of the full cells around a node.
    fn pull(&self, cells: &[[Lanes; 2]], full: &[bool], node: usize) -> Lanes {
        let strides = self.layout.strides();
        let share = (self.grid.cell / 2.0).powi(D as i32 - 1);
        let mut force = Lanes::ZERO;
        for corner in 0..1usize << D {
            let is_upper = |axis: usize| corner >> axis & 1 == 1;
            let offset: usize = (0..D).filter(|&a| is_upper(a)).map(|a| strides[a]).sum();
            let Some(entry) = node.checked_sub(offset).filter(|&entry| full[entry]) else { continue };
            let ([a, b], Some(cell)) = (cells[entry].map(Lanes::to_array), self.cell(entry)) else {
                continue;
            };
            let stress = SymTensor([a[0], a[1], a[2], a[3], b[0], b[1]]) * (1.0 / b[2]);
            let radius = self.radius(&cell);
            let slope = |axis: usize| if is_upper(axis) { share * radius } else { -share * radius };
            let row = |i: usize| -> f64 {
                let s = &stress.0;
                let rows = [[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]];
                (0..D).map(|j| rows[i][j] * slope(j)).sum()
            };
            let at = |i: usize| if i < D { row(i) } else { 0.0 };
            let hoop = if self.axisymmetric { stress.0[2] * (self.grid.cell / 2.0).powi(2) } else { 0.0 };
            force -= Lanes::new([at(0) + hoop, at(1), at(2), 0.0]);
        }
        force
    }
}

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Average stresses of the cells, and which of them are full.
    pub(crate) fn average_stresses(&mut self) {
        if !self.stresses.is_used() {
            return;
        }
        let mut stresses = std::mem::take(&mut self.stresses);
        stresses.reset(&self.layout);
        let (len, strides, ground) = (self.layout.len(), self.layout.strides(), ground!(self));
        let mut row_sums = std::mem::take(&mut self.row_sums);
        let fields = stresses.cells.chunks_exact_mut(len).zip(stresses.full.chunks_exact_mut(len));
        for (field, (cells, full)) in fields.enumerate() {
            let of_field = |set: &&PointSet<D, P>| set.field == field;
            self.layout.scatter(cells, |slab, window, offset| {
                for set in self.sets.iter().filter(of_field) {
                    for p in set.slabs[slab]..set.slabs[slab + 1] {
                        let entry = lowest_node::<D, S, B>(ground.grid, &strides, &set.position[p]);
                        let (s, volume) = (&set.stress[p].0, set.volume[p]);
                        window[entry - offset][0] += Lanes::new([s[0], s[1], s[2], s[3]]) * volume;
                        window[entry - offset][1] += Lanes::new([s[4], s[5], 1.0, 0.0]) * volume;
                    }
                }
            });
            let forces = self.cell_forces();
            self.layout.rows(full, &mut row_sums, |row, active, line| {
                for number in active {
                    line[number] = forces.is_full(cells, row * strides[0] + number);
                }
                RowSums::default()
            });
        }
        self.row_sums = row_sums;
        self.stresses = stresses;
    }

    /// Adds the internal force of the full cells to the nodes.
    pub(crate) fn pull_with_cells(&mut self) {
        if !self.stresses.is_used() {
            return;
        }
        let mut nodes = std::mem::take(&mut self.nodes);
        let mut row_sums = std::mem::take(&mut self.row_sums);
        let (len, row_length) = (self.layout.len(), self.layout.strides()[0]);
        let (cells, full) = (self.stresses.cells.chunks_exact(len), self.stresses.full.chunks_exact(len));
        let forces = self.cell_forces();
        for ((nodes, cells), full) in nodes.chunks_exact_mut(len).zip(cells).zip(full) {
            self.layout.rows(nodes, &mut row_sums, |row, active, line: &mut [Node]| {
                for number in active {
                    line[number].force += forces.pull(cells, full, row * row_length + number);
                }
                RowSums::default()
            });
        }
        self.nodes = nodes;
        self.row_sums = row_sums;
    }

    fn cell_forces(&self) -> CellForces<'_, D> {
        CellForces {
            grid: &self.grid,
            layout: &self.layout,
            ghosts: B::GHOSTS,
            axisymmetric: self.axisymmetric,
            fill: if self.options.integration == Integration::Gauss { 0.0 } else { self.options.full_cell },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::points::FixedDomain;
    use crate::setup;
    use crate::transfer::Scatter;
    use colluvium_case::Case;
    use colluvium_grid::{Gimp, Linear};

    /// Internal forces (N) at the nodes 1 and 2 of the bar of [`nodal`], without the middle point of the second cell if
    /// `gap`.
    fn forces<const S: usize, B: Basis<S>>(shape: &str, integration: &str, gap: bool) -> [f64; 2] {
        let [_, first, second, _] = nodal::<S, B>(shape, integration, if gap { &[4] } else { &[] });
        [first, second]
    }

    /// Internal forces (N) at the nodes of a bar of three cells of 1 m with three points each under 7 Pa, without those of
    /// the points that are `out`.
    fn nodal<const S: usize, B: Basis<S>>(shape: &str, integration: &str, out: &[u32]) -> [f64; 4] {
        let text = serde_json::json!({
            "title": "bar", "space": "1d", "domain": { "min": [0], "max": [4] }, "gravity": [0],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [3] },
                         "stress": { "kind": "uniform", "value": [7, 0, 0, 0, 0, 0] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 1, "points_per_cell": 3, "shape": shape, "integration": integration } }
        });
        let case = Case::from_json(&text.to_string()).unwrap();
        let options = setup::options(&case).unwrap();
        let mut solver = setup::solver::<1, S, B, FixedDomain>(&case, &options).unwrap();
        let set = &mut solver.sets[0];
        set.retain(|x| !out.iter().any(|i| (x[0] - (f64::from(*i) + 0.5) / 3.0).abs() < 1e-9));
        solver.sort();
        solver.scatter(Scatter::Everything, 1e-3);
        [0, 1, 2, 3].map(|node| -solver.nodes[node + B::GHOSTS].force.to_array()[0])
    }

    #[test]
    fn a_cell_at_the_surface_pulls_with_its_whole_volume_by_gauss() {
        // The upper two of the three points of the last cell taken out: a third of its volume is left. Its two nodes get
        // ± σ Ω_p/h of the point, or ± σ of the cell, which pulls at its upper node as if it were full.
        for (integration, last) in [("points", 7.0 / 3.0), ("mixed", 7.0 / 3.0), ("gauss", 7.0)] {
            let [_, _, third, fourth] = nodal::<2, Linear>("linear", integration, &[7, 8]);
            assert!((fourth - last).abs() < 1e-14, "{integration}: {fourth}");
            assert!((third - (7.0 - last)).abs() < 1e-14, "{integration}: {third}");
        }
    }

    #[test]
    fn cells_with_unequal_numbers_of_points_pull_at_their_nodes_unless_they_are_full() {
        // MPM sheet S-04: 3, 2, 3 points of a third each under one stress.
        let [left, right] = forces::<2, Linear>("linear", "points", true);
        assert!((left - 7.0 / 3.0).abs() < 1e-14 && (right + 7.0 / 3.0).abs() < 1e-14, "{left}, {right}");
        for integration in ["mixed", "gauss"] {
            for force in forces::<2, Linear>("linear", integration, true) {
                assert!(force.abs() < 1e-14, "{integration}: {force}");
            }
        }
        for force in forces::<3, Gimp>("ugimp", "points", false) {
            assert!(force.abs() < 1e-14, "domains that tile the line: {force}");
        }
    }
}
