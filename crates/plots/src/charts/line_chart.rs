//! Line charts.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::charts::axis_ticks::{AxisDirection, LETTERS, NumberAxis, Ticks};
use crate::{FONT, PALETTE, Picture, range};

/// Drawing style of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// Line through the points.
    #[default]
    Line,
    /// Dashed line: laws and closed forms.
    Dashed,
    /// Markers: measured points.
    Markers,
}

/// Series of points with a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Name in the legend; no entry when empty.
    pub label: String,
    /// Points; those that are not finite are left out.
    pub points: Vec<(f64, f64)>,
    /// Style in which the series is drawn.
    pub style: Style,
}

impl Series {
    /// Returns a series.
    pub fn new(label: impl Into<String>, points: Vec<(f64, f64)>, style: Style) -> Self {
        Self { label: label.into(), points, style }
    }
}

/// Chart of series of points, as lines or markers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineChart {
    /// Title above the chart.
    pub title: String,
    /// Label of the horizontal axis, with unit.
    pub x_label: String,
    /// Label of the vertical axis, with unit.
    pub y_label: String,
    /// Whether both axes are logarithmic; points that are not positive are left out.
    pub log: bool,
    /// Series of the chart.
    pub series: Vec<Series>,
}

impl Picture for LineChart {
    fn size(&self) -> (u32, u32) {
        (760, 480)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), String> {
        area.fill(&WHITE).map_err(|error| error.to_string())?;
        let all: Vec<(f64, f64)> = self.visible_series().flat_map(|(_, points)| points).collect();
        let x = range(all.iter().map(|p| p.0), 0.03);
        let y = range(all.iter().map(|p| p.1), 0.08);
        let (corner, room) = self.legend(&x, &y);
        let y = y.start..y.end + room * (y.end - y.start);
        self.draw_in(area, [x, y], corner)
    }
}

impl LineChart {
    /// Chart without series, with a title and the labels of both axes.
    pub fn new(title: impl Into<String>, x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        let (title, x_label, y_label) = (title.into(), x_label.into(), y_label.into());
        Self { title, x_label, y_label, ..Self::default() }
    }

    /// Corner for the legend that the series leave free. Where there is none, the second value is the extension of the vertical axis, as a
    /// share of its length.
    fn legend(&self, x: &Range<f64>, y: &Range<f64>) -> (SeriesLabelPosition, f64) {
        let named = || self.series.iter().map(|series| series.label.chars().count()).filter(|&n| n > 0);
        // Shares of the plotting area covered by the legend, with its margins: letters of 14 px are 7 wide, lines 20 high.
        let (width, height) = self.plane();
        let (wide, high) =
            (7.0 * named().max().unwrap_or(0) as f64 + 50.0, 20.0 * named().count() as f64 + 26.0);
        let (wide, high) = ((wide / width).min(1.0), (high / height).min(0.6));
        let share = |v: f64, r: &Range<f64>| (v - r.start) / (r.end - r.start);
        let places = self.visible_series().flat_map(|(series, points)| {
            let points: Vec<_> = points.iter().map(|p| (share(p.0, x), share(p.1, y))).collect();
            if series.style == Style::Markers { points } else { densified_line(&points) }
        });
        let places: Vec<(f64, f64)> = places.collect();
        let crowd = |right: bool, top: bool| {
            let beside = |u: f64| if right { u > 1.0 - wide } else { u < wide };
            let level = |v: f64| if top { v > 1.0 - high } else { v < high };
            places.iter().filter(|(u, v)| beside(*u) && level(*v)).count()
        };
        let corners = [
            (crowd(false, true), SeriesLabelPosition::UpperLeft),
            (crowd(true, true), SeriesLabelPosition::UpperRight),
            (crowd(true, false), SeriesLabelPosition::LowerRight),
            (crowd(false, false), SeriesLabelPosition::LowerLeft),
        ];
        let free = corners.into_iter().find(|(count, _)| *count == 0);
        free.map_or((SeriesLabelPosition::UpperRight, high / (1.0 - high)), |(_, corner)| (corner, 0.0))
    }

    /// Width and height of the plotting area between the axes (px).
    fn plane(&self) -> (f64, f64) {
        let (width, height) = self.size();
        (f64::from(width) - 102.0, f64::from(height) - 100.0)
    }

    /// Series with their visible points. On logarithmic axes coordinates are exponents of ten.
    fn visible_series(&self) -> impl Iterator<Item = (&Series, Vec<(f64, f64)>)> {
        self.series.iter().map(|series| (series, self.continuous_parts(series).concat()))
    }

    /// Parts of a series without gaps. On logarithmic axes coordinates are exponents of ten.
    fn continuous_parts(&self, series: &Series) -> Vec<Vec<(f64, f64)>> {
        let shown = |p: &(f64, f64)| {
            let finite = p.0.is_finite() && p.1.is_finite() && p.1.abs() < 1e200;
            finite && (!self.log || (p.0 > 0.0 && p.1 > 0.0))
        };
        let scale = |v: f64| if self.log { v.log10() } else { v };
        let pieces = series.points.split(|p| !shown(p)).filter(|piece| !piece.is_empty());
        pieces.map(|piece| piece.iter().map(|p| (scale(p.0), scale(p.1))).collect()).collect()
    }

    /// Draws the chart in axes of the given ranges. On logarithmic axes they are ranges of the exponents of ten.
    fn draw_in<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        [x, y]: [Range<f64>; 2],
        legend: SeriesLabelPosition,
    ) -> Result<(), String> {
        let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
        let (width, height) = self.plane();
        let ticks = if self.log { Ticks::logarithmic } else { Ticks::linear };
        let (across, up) =
            (ticks(&x, width, AxisDirection::Horizontal), ticks(&y, height, AxisDirection::Vertical));
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, 20))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(78)
            .build_cartesian_2d(NumberAxis::new(x, across.clone()), NumberAxis::new(y, up.clone()))
            .map_err(text)?;
        chart
            .configure_mesh()
            .x_desc(across.axis_label(&self.x_label))
            .y_desc(up.axis_label(&self.y_label))
            .label_style((FONT, LETTERS))
            .axis_desc_style((FONT, 16))
            .bold_line_style(RGBColor(225, 225, 225))
            .light_line_style(TRANSPARENT)
            .axis_style(RGBColor(90, 90, 90))
            .draw()
            .map_err(text)?;
        for (number, (series, points)) in self.visible_series().enumerate() {
            self.draw_series(&mut chart, PALETTE[number % PALETTE.len()], series, points).map_err(text)?;
        }
        if self.series.iter().any(|s| !s.label.is_empty()) {
            chart
                .configure_series_labels()
                .position(legend)
                .background_style(WHITE.mix(0.85))
                .border_style(RGBColor(200, 200, 200))
                .label_font((FONT, 14))
                .margin(8)
                .draw()
                .map_err(text)?;
        }
        Ok(())
    }

    /// Draws a series with its entry in the legend.
    fn draw_series<'a, B: DrawingBackend + 'a>(
        &self,
        chart: &mut ChartContext<'a, B, Cartesian2d<NumberAxis, NumberAxis>>,
        colour: RGBColor,
        series: &Series,
        points: Vec<(f64, f64)>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let line = colour.stroke_width(2);
        // A line ends where values are missing, and an isolated value is a dot.
        let (lines, alone): (Vec<_>, Vec<_>) =
            self.continuous_parts(series).into_iter().partition(|piece| piece.len() > 1);
        if series.style != Style::Markers {
            let dots = alone.concat().into_iter().map(|p| Circle::new(p, 2, colour.filled()));
            chart.draw_series(dots)?;
        }
        let drawn = match series.style {
            Style::Line => {
                let lines = lines.into_iter().map(|piece| PathElement::new(piece, line));
                chart.draw_series(lines)?
            }
            Style::Dashed => {
                let mut lines = lines.into_iter();
                let last = lines.next_back().unwrap_or_default();
                for piece in lines {
                    chart.draw_series(DashedLineSeries::new(piece, 7, 5, line))?;
                }
                chart.draw_series(DashedLineSeries::new(last, 7, 5, line))?
            }
            Style::Markers => {
                let markers = points.into_iter().map(|p| Circle::new(p, 4, colour.filled()));
                chart.draw_series(markers)?
            }
        };
        if !series.label.is_empty() {
            let style = series.style;
            drawn.label(&series.label).legend(move |(x, y)| {
                let dashes: &[(i32, i32)] = match style {
                    Style::Line => &[(0, 18)],
                    Style::Dashed => &[(0, 7), (11, 18)],
                    Style::Markers => &[],
                };
                let dash = |number: usize| {
                    let ends = dashes.get(number).map(|(from, to)| vec![(x + from, y), (x + to, y)]);
                    PathElement::new(ends.unwrap_or_default(), line)
                };
                let radius = if style == Style::Markers { 4 } else { 0 };
                let dot = Circle::new((x + 9, y), radius, colour.filled());
                EmptyElement::at((0, 0)) + dash(0) + dash(1) + dot
            });
        }
        Ok(())
    }
}

/// Points along a polyline. They are at most a hundredth apart along each axis, with at most a hundred for each segment.
fn densified_line(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let between = |pair: &[(f64, f64)]| {
        let ((x, y), (to_x, to_y)) = (pair[0], pair[1]);
        let parts = (100.0 * (to_x - x).abs().max((to_y - y).abs())).ceil().clamp(1.0, 100.0);
        (1..=parts as usize).map(move |k| {
            let share = k as f64 / parts;
            (x + share * (to_x - x), y + share * (to_y - y))
        })
    };
    points.first().copied().into_iter().chain(points.windows(2).flat_map(between)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(lines: &[&[(f64, f64)]]) -> LineChart {
        let series = lines.iter().map(|points| Series::new("a line", points.to_vec(), Style::Line)).collect();
        LineChart { series, ..LineChart::default() }
    }

    #[test]
    fn the_legend_is_placed_in_a_free_corner_or_above_all_lines() {
        let unit = 0.0..1.0;
        // Two points, but the line between them passes the corners that have no point.
        let (corner, room) = chart(&[&[(0.0, 0.0), (1.0, 1.0)]]).legend(&unit, &unit);
        assert!(matches!(corner, SeriesLabelPosition::UpperLeft) && room == 0.0);
        let cross = chart(&[&[(0.0, 0.0), (1.0, 1.0)], &[(0.0, 1.0), (1.0, 0.0)]]);
        let (_, room) = cross.legend(&unit, &unit);
        assert!(room > 0.1, "{room}");
        let svg = cross.to_svg().unwrap();
        assert!(svg.contains("a line"));
    }
}
