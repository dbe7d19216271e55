//! Hazard rasters of the snow in plan: largest thickness, speed and dynamic pressure, and arrival time of each cell.
//!
//! A point is distributed evenly over the square of its width in plan: thickness is volume over area of a cell, and rasters of it sum to
//! the volume. The speed of a cell is that of the mass over it. The rasters are updated after every step.

use colluvium_case::description::Rasters;
use colluvium_case::{Case, CaseError, PlanRaster};
use colluvium_points::{Georeference, Raster};
use serde::{Deserialize, Serialize};

use crate::points::bodies::Bodies;

/// Default width of a raster cell over that of a grid cell, for a case without terrain raster.
const DEFAULT_CELL_RATIO: f64 = 2.0;

/// Extreme values of one cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HazardCell {
    /// Largest thickness (m).
    thickness: f64,
    /// Largest speed at a thickness of at least the threshold (m/s).
    speed: f64,
    /// Largest `ρ |v|²` at a thickness of at least the threshold (Pa).
    pressure: f64,
    /// Time at which the thickness first reached the threshold (s); not-a-number before.
    arrival_time: f64,
}

/// Hazard cell that no flow has reached.
const EMPTY_CELL: HazardCell =
    HazardCell { thickness: 0.0, speed: 0.0, pressure: 0.0, arrival_time: f64::NAN };

/// Current content of a cell: thickness (m), mass over area (kg/m²), momentum over area (kg/(m s)).
type CellContent = [f64; 5];

/// Hazard rasters of a run.
#[derive(Clone, Debug)]
pub struct HazardRasters {
    /// Georeference and size of the rasters; its values are not used.
    grid: Raster,
    /// Thickness from which a cell counts as reached (m).
    threshold: f64,
    cells: Vec<HazardCell>,
    contents: Vec<CellContent>,
    covered_cells: Vec<u32>,
}

impl HazardRasters {
    /// Hazard rasters that the case requests, on the cells of the terrain or on cells of a given width. `cell` is the cell size of the grid
    /// (m).
    ///
    /// # Errors
    /// In the plane, and for more cells than fit into memory.
    pub fn of_case(case: &Case, cell: f64) -> Result<Option<Self>, CaseError> {
        let Some(rasters) = case.plan_rasters()? else { return Ok(None) };
        let mut terrain = None;
        for number in 0..case.obstacles.len() {
            terrain = terrain.or(case.heights(number)?);
        }
        let grid = match (terrain, rasters.cell) {
            (Some(terrain), None) => Raster { values: Vec::new(), ..terrain },
            (terrain, given) => {
                let corner = |of: &[f64]| std::array::from_fn(|c| of[c]);
                let reference = terrain.map_or_else(Georeference::default, |terrain| terrain.reference);
                let width = given.unwrap_or(DEFAULT_CELL_RATIO * cell);
                Rasters::raster_grid(corner(&case.domain.min), corner(&case.domain.max), width, reference)?
            }
        };
        let count = grid.columns * grid.rows;
        let (cells, over) = (vec![EMPTY_CELL; count], vec![[0.0; 5]; count]);
        Ok(Some(Self {
            grid,
            threshold: rasters.threshold,
            cells,
            contents: over,
            covered_cells: Vec::with_capacity(count),
        }))
    }

    /// Extreme values of all cells, one row after another from the smallest y.
    pub fn cells(&self) -> &[HazardCell] {
        &self.cells
    }

    /// Restores the values of the cells; `None` where their number differs.
    pub fn restore(&mut self, cells: Vec<HazardCell>) -> Option<()> {
        (cells.len() == self.cells.len()).then(|| self.cells = cells)
    }

    /// Updates the extreme values with the points at `time` (s).
    pub fn update<const D: usize>(&mut self, bodies: &Bodies<D>, time: f64) {
        self.distribute_points(bodies);
        for &number in &self.covered_cells {
            let (cell, over) = (&mut self.cells[number as usize], &self.contents[number as usize]);
            cell.thickness = cell.thickness.max(over[0]);
            if over[0] >= self.threshold {
                let speed = speed(over);
                cell.speed = cell.speed.max(speed);
                cell.pressure = cell.pressure.max(over[1] / over[0] * speed * speed);
                if cell.arrival_time.is_nan() {
                    cell.arrival_time = time;
                }
            }
        }
    }

    /// Distributes the points over the cells.
    fn distribute_points<const D: usize>(&mut self, bodies: &Bodies<D>) {
        self.covered_cells.drain(..).for_each(|number| self.contents[number as usize] = [0.0; 5]);
        for body in &bodies.bodies {
            let points = &body.points;
            for (i, place) in points.position.iter().enumerate() {
                let momentum: [f64; D] = points.velocity[i].map(|v| v * points.mass[i]);
                self.add_point(place, body.width, points.volume[i], points.mass[i], &momentum);
            }
        }
    }

    /// Adds a point to the cells that its square in plan covers, by the share of the area.
    fn add_point<const D: usize>(
        &mut self,
        place: &[f64; D],
        width: f64,
        volume: f64,
        mass: f64,
        momentum: &[f64; D],
    ) {
        let Raster { columns, rows, origin, spacing, .. } = self.grid;
        let counts = [columns, rows];
        // In widths of a cell, from the outer side of the first one.
        let side = |c: usize, half: f64| (place[c] + half - origin[c]) / spacing[c] + 0.5;
        let range = |c: usize| [side(c, -0.5 * width), side(c, 0.5 * width)];
        let ends = [range(0), range(1)];
        let cells = |c: usize| {
            let [from, to] = ends[c];
            from.floor().max(0.0) as usize..(to.ceil().max(0.0) as usize).min(counts[c])
        };
        // Share of the point along an axis.
        let share = |c: usize, number: usize| {
            let ([from, to], number) = (ends[c], number as f64);
            (to.min(number + 1.0) - from.max(number)).max(0.0) / (to - from)
        };
        let per_area = 1.0 / (spacing[0] * spacing[1]);
        for row in cells(1) {
            for column in cells(0) {
                let part = share(0, column) * share(1, row) * per_area;
                if part == 0.0 {
                    continue;
                }
                let number = row * columns + column;
                let over = &mut self.contents[number];
                if over[0] == 0.0 {
                    self.covered_cells.push(number as u32);
                }
                over[0] += part * volume;
                over[1] += part * mass;
                momentum.iter().enumerate().for_each(|(c, p)| over[2 + c] += part * p);
            }
        }
    }

    /// Hazard rasters for output, with the names that depth-integrated flow uses.
    pub fn rasters<const D: usize>(&self, bodies: &Bodies<D>) -> Vec<PlanRaster> {
        let mut now = self.clone();
        now.distribute_points(bodies);
        let raster = |name: &str, unit, value: &dyn Fn(usize) -> f64| {
            let values = (0..self.cells.len()).map(value).collect();
            PlanRaster { name: name.to_owned(), unit, raster: Raster { values, ..self.grid.clone() } }
        };
        let seen = |name: &str, unit, value: fn(&HazardCell) -> f64| {
            raster(name, unit, &|k| {
                let cell = &self.cells[k];
                if cell.thickness >= self.threshold { value(cell) } else { f64::NAN }
            })
        };
        let left = |name: &str, unit, value: fn(&CellContent) -> f64| {
            raster(name, unit, &|k| if now.contents[k][0] > 0.0 { value(&now.contents[k]) } else { f64::NAN })
        };
        vec![
            seen("peak_thickness_vertical", "m", |cell| cell.thickness),
            seen("peak_velocity", "m/s", |cell| cell.speed),
            seen("peak_dynamic_pressure", "Pa", |cell| cell.pressure),
            seen("arrival_time", "s", |cell| cell.arrival_time),
            left("final_thickness_vertical", "m", |over| over[0]),
            left("final_velocity", "m/s", speed),
        ]
    }
}

/// Speed of the mass over a cell (m/s).
fn speed(over: &CellContent) -> f64 {
    over[2..].iter().map(|p| (p / over[1]).powi(2)).sum::<f64>().sqrt()
}
