//! Maps: a quantity in colours over the shaded relief of its terrain.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::charts::axis_ticks::{AxisDirection, LETTERS, NumberAxis, Ticks};
use crate::charts::plane_axes::PlaneAxes;
use crate::pictures::point_cloud::{colour, draw_bar};
use crate::{FONT, Picture, range};

/// Values on the cells of a plan grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapCells {
    /// Numbers of cells along x and y.
    pub counts: [usize; 2],
    /// Centre of the cell with the least x and y (m).
    pub origin: [f64; 2],
    /// Widths of a cell (m).
    pub spacing: [f64; 2],
    /// Value of each cell, row by row from the least y; NaN where there is none.
    pub values: Vec<f64>,
}

impl MapCells {
    /// Value of a cell; `None` outside the map or without a value.
    fn value_in_cell(&self, column: usize, row: usize) -> Option<f64> {
        let value = *self.values.get(row * self.counts[0] + column)?;
        value.is_finite().then_some(value)
    }

    /// Index of the cell around a coordinate.
    fn cell_index(&self, axis: usize, x: f64) -> Option<usize> {
        let steps = ((x - self.origin[axis]) / self.spacing[axis]).round();
        (steps >= 0.0 && steps < self.counts[axis] as f64).then_some(steps as usize)
    }

    /// Value of the map cell that contains a position (m); `None` outside the map or without a value.
    fn value(&self, x: [f64; 2]) -> Option<f64> {
        self.value_in_cell(self.cell_index(0, x[0])?, self.cell_index(1, x[1])?)
    }

    /// Extent of the cells along an axis (m).
    fn extent(&self, axis: usize) -> Range<f64> {
        let low = self.origin[axis] - 0.5 * self.spacing[axis];
        low..low + self.counts[axis] as f64 * self.spacing[axis]
    }

    /// Bilinear gradient of heights at a position.
    fn gradient(&self, x: [f64; 2]) -> Option<[f64; 2]> {
        let h = self.spacing;
        let value = |dx: f64, dy: f64| self.smooth([x[0] + dx * h[0], x[1] + dy * h[1]]);
        let along = |after: Option<f64>, before: Option<f64>, step: f64| Some((after? - before?) / step);
        Some([
            along(value(0.5, 0.0), value(-0.5, 0.0), h[0])?,
            along(value(0.0, 0.5), value(0.0, -0.5), h[1])?,
        ])
    }

    /// Bilinear interpolation between the centres of cells.
    fn smooth(&self, x: [f64; 2]) -> Option<f64> {
        let (mut cell, mut share) = ([0; 2], [0.0; 2]);
        for c in 0..2 {
            let last = self.counts[c].checked_sub(2)?;
            let steps = (x[c] - self.origin[c]) / self.spacing[c];
            cell[c] = (steps.max(0.0) as usize).min(last);
            share[c] = steps.clamp(0.0, (last + 1) as f64) - cell[c] as f64;
        }
        let [i, j] = cell;
        let mix = |a: f64, b: f64, t: f64| a + t * (b - a);
        let south = mix(self.value_in_cell(i, j)?, self.value_in_cell(i + 1, j)?, share[0]);
        let north = mix(self.value_in_cell(i, j + 1)?, self.value_in_cell(i + 1, j + 1)?, share[0]);
        Some(mix(south, north, share[1]))
    }
}

/// Map of a quantity over terrain, with x to the east and y to the north.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TerrainMap {
    /// Title above it.
    pub title: String,
    /// Label of the colour scale: quantity with unit.
    pub label: String,
    /// Heights of the terrain (m), for its shading; `None` for a plane.
    pub heights: Option<MapCells>,
    /// Quantity shown in colours.
    pub cells: MapCells,
    /// Rings drawn as red lines, for example of a release area (m).
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// Rings drawn as black lines, of a mapped event (m).
    pub mapped_outlines: Vec<Vec<[f64; 2]>>,
}

/// Width of a map (pixels).
const WIDTH: u32 = 1000;
/// Width and height of the margins around the map together (pixels).
const MARGINS: (u32, u32) = (200, 100);
/// Direction to the light, from the north-west and 45° high.
const LIGHT_DIRECTION: [f64; 3] = [-0.5, 0.5, std::f64::consts::FRAC_1_SQRT_2];
/// Opacity of a colour over the shading.
const COLOUR_OPACITY: f64 = 0.72;

impl TerrainMap {
    /// Ranges of the map along the two axes (m): all coloured cells and outlines, with some terrain around.
    fn window(&self) -> [Range<f64>; 2] {
        let cells = &self.cells;
        let along = |axis: usize| {
            let ends = |number: usize| {
                let k = if axis == 0 { number % cells.counts[0] } else { number / cells.counts[0] };
                let x = cells.origin[axis] + k as f64 * cells.spacing[axis];
                [x - 0.5 * cells.spacing[axis], x + 0.5 * cells.spacing[axis]]
            };
            let known = (0..cells.values.len()).filter(|k| cells.values[*k].is_finite());
            let corners =
                self.outlines.iter().chain(&self.mapped_outlines).flatten().map(|corner| corner[axis]);
            range(known.flat_map(ends).chain(corners), 0.12)
        };
        let [x, y] = [along(0), along(1)];
        // No side is shorter than half the other one.
        let smallest = 0.5 * (x.end - x.start).max(y.end - y.start);
        let wide = |r: Range<f64>, axis: usize| {
            let extra = 0.5 * (smallest - (r.end - r.start)).max(0.0);
            let end = self.heights.as_ref().unwrap_or(cells).extent(axis);
            let visible = (r.start - extra).max(end.start)..(r.end + extra).min(end.end);
            if visible.start < visible.end { visible } else { r }
        };
        [wide(x, 0), wide(y, 1)]
    }

    /// Values of the first and the last colour: the smallest and the largest value, or zero where that is beyond them.
    fn scale(&self) -> Range<f64> {
        let known = self.cells.values.iter().filter(|value| value.is_finite());
        let (low, high) = known.fold((0.0f64, 0.0f64), |(low, high), v| (low.min(*v), high.max(*v)));
        low..if low < high { high } else { f64::MIN_POSITIVE }
    }

    /// Grey level of the terrain at a position by its shading; white where there is no terrain.
    fn shade(&self, x: [f64; 2]) -> [f64; 3] {
        let Some(heights) = &self.heights else { return [225.0; 3] };
        let Some([a, b]) = heights.gradient(x) else { return [255.0; 3] };
        let length = (1.0 + a * a + b * b).sqrt();
        let facing = (LIGHT_DIRECTION[2] - a * LIGHT_DIRECTION[0] - b * LIGHT_DIRECTION[1]) / length;
        [70.0 + 185.0 * facing.max(0.0); 3]
    }

    /// Colour at a position: that of its value, darkened or lightened by the relief.
    fn colour(&self, x: [f64; 2], values: &Range<f64>) -> RGBColor {
        let shade = self.shade(x);
        let Some(value) = self.cells.value(x) else {
            let [r, g, b] = shade.map(|c| c as u8);
            return RGBColor(r, g, b);
        };
        let over = colour((value - values.start) / (values.end - values.start));
        // Shading shows through, as light and dark of the colour.
        let mix = |c: u8, grey: f64| (COLOUR_OPACITY * f64::from(c) + (1.0 - COLOUR_OPACITY) * grey) as u8;
        RGBColor(mix(over.0, shade[0]), mix(over.1, shade[1]), mix(over.2, shade[2]))
    }
}

/// Longest of the lengths 1, 2, 5, 10, … m that is not above `length` (m).
fn round_length(length: f64) -> f64 {
    let power = 10f64.powf(length.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|k| k * power).find(|x| *x <= length).unwrap_or(power)
}

impl Picture for TerrainMap {
    fn size(&self) -> (u32, u32) {
        let [x, y] = self.window();
        let ratio = ((y.end - y.start) / (x.end - x.start)).clamp(0.2, 1.6);
        (WIDTH, (f64::from(WIDTH - MARGINS.0) * ratio) as u32 + MARGINS.1)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), String> {
        let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
        area.fill(&WHITE).map_err(text)?;
        let (main, bar) = area.split_horizontally(WIDTH - 100);
        let values = self.scale();
        let [x, y] = self.window();
        let pixels = f64::from(WIDTH - MARGINS.0);
        let across = Ticks::linear(&x, pixels, AxisDirection::Horizontal);
        let up = Ticks::linear(&y, f64::from(self.size().1 - MARGINS.1), AxisDirection::Vertical);
        let mut chart = ChartBuilder::on(&main)
            .caption(&self.title, (FONT, 20))
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(80)
            .build_cartesian_2d(
                NumberAxis::new(x.clone(), across.clone()),
                NumberAxis::new(y.clone(), up.clone()),
            )
            .map_err(text)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc(across.axis_label("x, east (m)"))
            .y_desc(up.axis_label("y, north (m)"))
            .label_style((FONT, LETTERS))
            .axis_desc_style((FONT, 15))
            .draw()
            .map_err(text)?;
        self.draw_ground(&chart, &values)?;
        let black = self.mapped_outlines.iter().map(|ring| (ring, BLACK));
        for (ring, pen) in black.chain(self.outlines.iter().map(|ring| (ring, RGBColor(200, 20, 20)))) {
            let closed = ring.iter().chain(ring.first()).map(|[x, y]| (*x, *y));
            let line = PathElement::new(closed.collect::<Vec<_>>(), pen.stroke_width(2));
            chart.draw_series([line]).map_err(text)?;
        }
        draw_scale(&mut chart, &x, &y)?;
        let label = draw_bar(&bar, values, &self.label)?;
        let style = TextStyle::from((FONT, 15)).pos(Pos::new(HPos::Right, VPos::Top));
        area.draw(&Text::new(label, (WIDTH as i32 - 8, 12), style)).map_err(text)
    }
}

impl TerrainMap {
    /// Draws shading and colours, pixel by pixel.
    fn draw_ground<B: DrawingBackend>(
        &self,
        chart: &PlaneAxes<'_, B>,
        values: &Range<f64>,
    ) -> Result<(), String> {
        let [x, y] = self.window();
        let plane = chart.plotting_area().strip_coord_spec();
        let (width, height) = plane.dim_in_pixel();
        for row in 0..height {
            let north = y.end - (f64::from(row) + 0.5) / f64::from(height) * (y.end - y.start);
            for column in 0..width {
                let east = x.start + (f64::from(column) + 0.5) / f64::from(width) * (x.end - x.start);
                let colour = self.colour([east, north], values);
                plane.draw_pixel((column as i32, row as i32), &colour).map_err(|error| error.to_string())?;
            }
        }
        Ok(())
    }
}

/// Draws a scale bar and a north arrow.
fn draw_scale<B: DrawingBackend>(
    chart: &mut PlaneAxes<'_, B>,
    x: &Range<f64>,
    y: &Range<f64>,
) -> Result<(), String> {
    let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
    let (width, height) = (x.end - x.start, y.end - y.start);
    let length = round_length(0.25 * width);
    let at = |east: f64, north: f64| (x.start + east, y.start + north * height);
    let (left, low, high) = (0.03 * width, 0.03, 0.045);
    for part in 0..4 {
        let [from, to] = [part, part + 1].map(|k| left + f64::from(k) * 0.25 * length);
        let fill = if part % 2 == 0 { BLACK } else { WHITE };
        let bar = |style: ShapeStyle| Rectangle::new([at(from, low), at(to, high)], style);
        chart.draw_series([bar(fill.filled()), bar(BLACK.stroke_width(1))]).map_err(text)?;
    }
    let style = TextStyle::from((FONT, 16)).pos(Pos::new(HPos::Center, VPos::Bottom));
    let name = if length >= 1000.0 { format!("{} km", length / 1000.0) } else { format!("{length} m") };
    let label = Text::new(name, at(left + 0.5 * length, high + 0.01), style.clone());
    chart.draw_series([label]).map_err(text)?;
    let (east, tip) = (0.96 * width, 0.9);
    let head = |side: f64| (at(east + side * 0.007 * width, tip - 0.025), at(east, tip));
    for (from, to) in [(at(east, tip - 0.09), at(east, tip)), head(-1.0), head(1.0)] {
        chart.draw_series([PathElement::new(vec![from, to], BLACK.stroke_width(2))]).map_err(text)?;
    }
    chart.draw_series([Text::new("N", at(east, tip + 0.01), style)]).map_err(text)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(value: impl Fn(f64, f64) -> f64) -> MapCells {
        let values = (0..600).map(|k| value(f64::from(k % 30), f64::from(k / 30))).collect();
        MapCells { counts: [30, 20], origin: [0.0; 2], spacing: [1.0; 2], values }
    }

    #[test]
    fn slopes_that_face_the_light_are_bright() {
        let map = |z: fn(f64, f64) -> f64| TerrainMap { heights: Some(cells(z)), ..TerrainMap::default() };
        let grey = |map: TerrainMap| map.shade([10.2, 8.7])[0];
        let (to_light, level, away) =
            (grey(map(|x, y| x - y)), grey(map(|_, _| 3.0)), grey(map(|x, y| y - x)));
        assert!(to_light > level && level > away, "{to_light} {level} {away}");
        assert_eq!(map(|_, _| f64::NAN).shade([10.2, 8.7]), [255.0; 3]);
    }

    #[test]
    fn the_map_window_contains_coloured_cells_and_outlines() {
        let map = TerrainMap {
            title: "peak".into(),
            label: "thickness (m)".into(),
            heights: Some(cells(|x, y| 0.3 * x + 0.1 * (y - 10.0).powi(2))),
            cells: cells(|x, y| if (x - 15.0).hypot(y - 10.0) < 5.0 { x } else { f64::NAN }),
            outlines: vec![vec![[8.0, 8.0], [12.0, 8.0], [12.0, 12.0]]],
            ..TerrainMap::default()
        };
        let [x, y] = map.window();
        assert!(
            x.start < 8.0 && x.end > 19.5 && x.end < 25.0 && y.start > 2.0 && y.end < 18.0,
            "{x:?} {y:?}"
        );
        assert!(map.to_png().unwrap().len() > 2000);
        assert_eq!([0.7, 30.0, 999.0].map(round_length), [0.5, 20.0, 500.0]);
    }

    #[test]
    fn the_colour_range_includes_zero_and_extends_to_negative_values_of_erosion() {
        let scale =
            |value: fn(f64, f64) -> f64| TerrainMap { cells: cells(value), ..TerrainMap::default() }.scale();
        assert_eq!(scale(|x, _| 2.0 + x), 0.0..31.0);
        assert_eq!(scale(|x, _| if x > 5.0 { -0.1 * x } else { f64::NAN }), -0.1 * 29.0..0.0);
        assert_eq!(scale(|x, y| x - y), -19.0..29.0);
        assert!(scale(|_, _| 0.0).end > 0.0);
    }

    #[test]
    fn a_mapped_outline_is_within_the_window() {
        let map = |mapped| TerrainMap {
            cells: cells(|x, _| if x < 3.0 { x } else { f64::NAN }),
            mapped_outlines: mapped,
            ..TerrainMap::default()
        };
        let with = map(vec![vec![[0.0, 8.0], [25.0, 8.0], [25.0, 12.0]]]);
        assert!(with.window()[0].end > 25.0 && map(Vec::new()).window()[0].end < 15.0);
        assert_ne!(with.to_png().unwrap(), map(Vec::new()).to_png().unwrap());
    }

    #[test]
    fn a_map_of_nothing_is_drawn() {
        let nothing = TerrainMap { cells: cells(|_, _| f64::NAN), ..TerrainMap::default() };
        assert!(nothing.to_png().is_ok());
    }
}
