//! Hazard rasters: largest thickness, speed and dynamic pressure, and arrival time, of each cell in plan.
//!
//! The volume of a node is spread over the cells within its kernel, in proportion to it and so that they contain all of it: rasters
//! of thickness sum to the volume of the flow. This is done after every step.

use colluvium_points::{Georeference, Outline, Raster};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::bed::Bed;

use crate::kernel::Kernel;
use crate::output::flow_view::FlowView;
use crate::points::phase_nodes::PlanVector;

/// Rows of cells per task.
const ROWS_PER_TASK: usize = 8;

/// Shift of cell centres relative to a mapped outline (cells), so that no centre lies on the outline.
const ON_OUTLINE: f64 = 1e-6;

/// A regular grid of cells in plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanCells {
    /// Cells along x and y.
    pub counts: [usize; 2],
    /// Centre of the cell with the least x and y (m).
    pub origin: [f64; 2],
    /// Widths of a cell (m).
    pub spacing: [f64; 2],
    /// Georeference of the raster.
    pub reference: Georeference,
}

impl PlanCells {
    /// Area of a cell (m²).
    fn area(&self) -> f64 {
        self.spacing[0] * self.spacing[1]
    }

    /// Centre of a cell in plan (m).
    fn centre(&self, column: usize, row: usize) -> [f64; 2] {
        [self.origin[0] + column as f64 * self.spacing[0], self.origin[1] + row as f64 * self.spacing[1]]
    }

    /// Cell at a position in plan; `None` outside the raster.
    fn cell(&self, x: [f64; 2]) -> Option<[usize; 2]> {
        let along = |c: usize| {
            let steps = ((x[c] - self.origin[c]) / self.spacing[c]).round();
            (steps >= 0.0 && steps < self.counts[c] as f64).then_some(steps as usize)
        };
        Some([along(0)?, along(1)?])
    }

    /// First and last cell along an axis whose centres are within `reach` of `x` (m).
    fn window(&self, axis: usize, x: f64, reach: f64) -> Option<[usize; 2]> {
        let steps = |x: f64| (x - self.origin[axis]) / self.spacing[axis];
        let first = steps(x - reach).ceil().max(0.0);
        let last = steps(x + reach).floor().min((self.counts[axis] - 1) as f64);
        (first <= last).then_some([first as usize, last as usize])
    }
}

/// Extreme values of the flow in a raster cell since the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HazardCell {
    /// Largest thickness (m).
    pub thickness: f64,
    /// Largest speed along the bed during the times at which the thickness was at least the threshold (m/s).
    pub speed: f64,
    /// Largest `ρ |v|²` during that time (Pa).
    pub pressure: f64,
    /// First time at which the thickness was at least the threshold (s); not-a-number before.
    pub arrival_time: f64,
}

/// Hazard cell that no flow has reached.
const EMPTY_CELL: HazardCell =
    HazardCell { thickness: 0.0, speed: 0.0, pressure: 0.0, arrival_time: f64::NAN };

/// Current content of a cell: thickness (m), mass over area (kg/m²), momentum in plan over area (kg/(m s)).
type CellContent = [f64; 4];

/// Distribution of the mass of a node over the cells around it, by kernel weights.
struct NodeFootprint {
    position: [f64; 2],
    columns: [usize; 2],
    rows: [usize; 2],
    length: f64,
    /// Thickness per value of the kernel.
    factor: f64,
    density: f64,
    velocity: [f64; 2],
}

/// Hazard rasters of a flow.
pub struct HazardRasters {
    grid: PlanCells,
    /// Thickness at which a cell counts as reached (m).
    threshold: f64,
    /// Slope of the bed at each cell.
    slopes: Vec<[f64; 2]>,
    cells: Vec<HazardCell>,
    /// Cells whose centres lie within a mapped outline; empty without one.
    in_mapped_outline: Vec<bool>,
    /// Area of the mapped outline beyond the cells (m²).
    mapped_beyond_cells: f64,
    contents: Vec<CellContent>,
    footprints: Vec<NodeFootprint>,
    bands: Vec<Vec<u32>>,
}

/// Position in plan with two coordinates; the second one is zero in a profile.
fn to_2d<const D: usize>(x: &PlanVector<D>) -> [f64; 2] {
    std::array::from_fn(|c| x.get(c).copied().unwrap_or(0.0))
}

impl HazardRasters {
    /// Creates rasters over a bed that no flow has reached yet.
    pub fn new<const D: usize>(grid: PlanCells, threshold: f64, bed: &Bed<D>) -> Self {
        let count = grid.counts[0] * grid.counts[1];
        let slope = |number: usize| {
            let centre = grid.centre(number % grid.counts[0], number / grid.counts[0]);
            let found = bed.bed_point(&std::array::from_fn(|c| centre[c]));
            found.map_or([0.0; 2], |bed| to_2d(&bed.slope))
        };
        let slopes = (0..count).into_par_iter().map(slope).collect::<Vec<_>>();
        let bands = vec![Vec::new(); grid.counts[1].div_ceil(ROWS_PER_TASK)];
        Self {
            threshold,
            slopes,
            cells: vec![EMPTY_CELL; count],
            in_mapped_outline: Vec::new(),
            mapped_beyond_cells: 0.0,
            contents: vec![[0.0; 4]; count],
            footprints: Vec::new(),
            bands,
            grid,
        }
    }

    /// Compares the reached cells with a mapped outline. Returns the share of its area outside the raster. A cell centre on the lower edges
    /// of the outline is inside, one on its upper edges outside.
    pub fn compare(&mut self, outline: &Outline) -> f64 {
        let grid = &self.grid;
        let within = |k: usize| {
            let centre = grid.centre(k % grid.counts[0], k / grid.counts[0]);
            outline.contains(std::array::from_fn(|c| centre[c] + ON_OUTLINE * grid.spacing[c]))
        };
        self.in_mapped_outline = (0..self.cells.len()).into_par_iter().map(within).collect::<Vec<_>>();
        let low: [f64; 2] = std::array::from_fn(|c| grid.origin[c] - 0.5 * grid.spacing[c]);
        let high: [f64; 2] = std::array::from_fn(|c| low[c] + grid.counts[c] as f64 * grid.spacing[c]);
        let ring = vec![low, [high[0], low[1]], high, [low[0], high[1]], low];
        let inside = Outline::new(vec![vec![ring]]).map_or(0.0, |cells| cells.overlap(outline));
        self.mapped_beyond_cells = (outline.area() - inside).max(0.0);
        self.mapped_beyond_cells / outline.area()
    }

    /// Areas (m²): reached inside the mapped outline, not reached inside it, and reached outside it; `None` without an outline.
    pub fn score(&self) -> Option<[f64; 3]> {
        let mut counts = [0.0; 3];
        for (cell, within) in self.cells.iter().zip(&self.in_mapped_outline) {
            match (!cell.arrival_time.is_nan(), within) {
                (true, true) => counts[0] += 1.0,
                (false, true) => counts[1] += 1.0,
                (true, false) => counts[2] += 1.0,
                (false, false) => {}
            }
        }
        let [hit, missed, beyond] = counts.map(|count| count * self.grid.area());
        (!self.in_mapped_outline.is_empty()).then_some([hit, missed + self.mapped_beyond_cells, beyond])
    }

    /// Extreme values of all cells, one row after another from the smallest y.
    pub fn cells(&self) -> &[HazardCell] {
        &self.cells
    }

    /// Restores the extreme values of the cells; `None` if the saved ones are of another raster.
    pub fn restore(&mut self, cells: Vec<HazardCell>) -> Option<()> {
        (cells.len() == self.cells.len()).then(|| self.cells = cells)
    }

    /// Updates the cells with the current flow.
    pub fn update<const D: usize>(&mut self, flow: &FlowView<'_, D>) {
        self.add_nodes(flow);
        let Self { grid, threshold, slopes, cells, contents, bands, .. } = self;
        let (width, threshold) = (grid.counts[0] * ROWS_PER_TASK, *threshold);
        let time = flow.clock.time;
        let all = cells.par_chunks_mut(width).zip(contents.par_chunks(width)).zip(slopes.par_chunks(width));
        all.zip(&*bands).for_each(|(((cells, contents), slopes), band)| {
            if band.is_empty() {
                return;
            }
            for ((cell, contents), slope) in cells.iter_mut().zip(contents).zip(slopes) {
                cell.thickness = cell.thickness.max(contents[0]);
                if contents[0] >= threshold {
                    let speed = speed(contents, slope);
                    cell.speed = cell.speed.max(speed);
                    cell.pressure = cell.pressure.max(contents[1] / contents[0] * speed * speed);
                    if cell.arrival_time.is_nan() {
                        cell.arrival_time = time;
                    }
                }
            }
        });
    }

    /// Adds the nodes to the cells by their kernel weights.
    fn add_nodes<const D: usize>(&mut self, flow: &FlowView<'_, D>) {
        let kernel = flow.settings.numerics.kernel;
        let Self { grid, contents, footprints, bands, .. } = self;
        footprints.clear();
        for (number, set) in flow.sets().iter().enumerate() {
            let density = flow.density(number);
            let nodes = &set.nodes;
            let footprint = |i: usize| {
                if flow.boundary.is_outside(nodes.id[i]) {
                    return None;
                }
                let of = (to_2d(&nodes.position[i]), nodes.length[i], nodes.volume[i]);
                patch(grid, kernel, of, density, to_2d(&nodes.velocity[i]))
            };
            footprints.par_extend((0..nodes.len()).into_par_iter().filter_map(footprint));
        }
        bands.iter_mut().for_each(Vec::clear);
        for (number, footprint) in footprints.iter().enumerate() {
            for band in footprint.rows[0] / ROWS_PER_TASK..=footprint.rows[1] / ROWS_PER_TASK {
                bands[band].push(number as u32);
            }
        }
        let columns = grid.counts[0];
        let chunks = contents.par_chunks_mut(columns * ROWS_PER_TASK).zip(&*bands).enumerate();
        chunks.for_each(|(number, (contents, band))| {
            if band.is_empty() {
                return;
            }
            contents.fill([0.0; 4]);
            let first = number * ROWS_PER_TASK;
            for footprint in band.iter().map(|&footprint| &footprints[footprint as usize]) {
                for row in footprint.rows[0].max(first)..=footprint.rows[1].min(first + ROWS_PER_TASK - 1) {
                    for column in footprint.columns[0]..=footprint.columns[1] {
                        let thickness = footprint.factor * footprint.weight(grid, kernel, column, row);
                        let mass = footprint.density * thickness;
                        let cell = &mut contents[(row - first) * columns + column];
                        cell[0] += thickness;
                        cell[1] += mass;
                        cell[2] += mass * footprint.velocity[0];
                        cell[3] += mass * footprint.velocity[1];
                    }
                }
            }
        });
    }

    /// Rasters with their names and units; thickness is measured `along` the vertical or the normal.
    pub fn rasters<const D: usize>(
        &self,
        flow: &FlowView<'_, D>,
        along: &str,
    ) -> Vec<(String, &'static str, Raster)> {
        let mut now = Self { cells: Vec::new(), ..Self::new(self.grid.clone(), self.threshold, flow.bed) };
        now.add_nodes(flow);
        let raster = |value: &dyn Fn(usize) -> f64| Raster {
            columns: self.grid.counts[0],
            rows: self.grid.counts[1],
            origin: self.grid.origin,
            spacing: self.grid.spacing,
            values: (0..self.slopes.len()).map(value).collect(),
            reference: self.grid.reference.clone(),
        };
        let peak = |value: fn(&HazardCell) -> f64| {
            raster(&|k| {
                let cell = &self.cells[k];
                if cell.thickness >= self.threshold { value(cell) } else { f64::NAN }
            })
        };
        // Where no flow is left at all, that is known of every cell.
        let beyond = if now.footprints.is_empty() { 0.0 } else { f64::NAN };
        let left = |value: &dyn Fn(usize) -> f64| {
            raster(&|k| if now.contents[k][0] > 0.0 { value(k) } else { beyond })
        };
        let mut rasters = vec![
            (format!("peak_thickness_{along}"), "m", peak(|cell| cell.thickness)),
            ("peak_velocity".to_owned(), "m/s", peak(|cell| cell.speed)),
            ("peak_dynamic_pressure".to_owned(), "Pa", peak(|cell| cell.pressure)),
            ("arrival_time".to_owned(), "s", peak(|cell| cell.arrival_time)),
            (format!("final_thickness_{along}"), "m", left(&|k| now.contents[k][0])),
            ("final_velocity".to_owned(), "m/s", left(&|k| speed(&now.contents[k], &now.slopes[k]))),
        ];
        if let Some(erodible) = flow.bed.erodible() {
            let centre = |k: usize| self.grid.centre(k % self.grid.counts[0], k / self.grid.counts[0]);
            let change = raster(&|k| {
                let [x, y] = centre(k);
                let taken = erodible.eroded_depth_at(x, y);
                if taken > 0.0 { -taken } else { f64::NAN }
            });
            rasters.push(("bed_change".to_owned(), "m", change));
        }
        rasters
    }

    /// Whether any cell has been reached.
    pub fn are_empty(&self) -> bool {
        self.cells.iter().all(|cell| cell.arrival_time.is_nan())
    }
}

/// Speed along the bed of the material in a cell (m/s).
fn speed(contents: &CellContent, slope: &[f64; 2]) -> f64 {
    let v = [contents[2] / contents[1], contents[3] / contents[1]];
    let rise = v[0] * slope[0] + v[1] * slope[1];
    (v[0] * v[0] + v[1] * v[1] + rise * rise).sqrt()
}

impl NodeFootprint {
    /// Kernel weight of a cell. If a kernel contains no cell centre, the cell of the node has the weight 1.
    #[inline]
    fn weight(&self, grid: &PlanCells, kernel: Kernel, column: usize, row: usize) -> f64 {
        if self.length == 0.0 {
            return 1.0;
        }
        let centre = grid.centre(column, row);
        let square = (centre[0] - self.position[0]).powi(2) + (centre[1] - self.position[1]).powi(2);
        kernel.profile::<2>(square.sqrt() / self.length)
    }
}

/// Footprint of a node on the cells, by kernel weights; `None` for a node outside the raster.
fn patch(
    grid: &PlanCells,
    kernel: Kernel,
    (position, length, volume): ([f64; 2], f64, f64),
    density: f64,
    velocity: [f64; 2],
) -> Option<NodeFootprint> {
    let cell = grid.cell(position)?;
    let reach = kernel.support() * length;
    let around = |c: usize| grid.window(c, position[c], reach).unwrap_or([cell[c]; 2]);
    let mut footprint = NodeFootprint {
        position,
        columns: around(0),
        rows: around(1),
        length,
        factor: 0.0,
        density,
        velocity,
    };
    let mut sum = 0.0;
    for row in footprint.rows[0]..=footprint.rows[1] {
        for column in footprint.columns[0]..=footprint.columns[1] {
            sum += footprint.weight(grid, kernel, column, row);
        }
    }
    if !(sum > 0.0) {
        (footprint.columns, footprint.rows, footprint.length, sum) = ([cell[0]; 2], [cell[1]; 2], 0.0, 1.0);
    }
    footprint.factor = volume / (sum * grid.area());
    Some(footprint)
}
