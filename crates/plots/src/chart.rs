//! Line charts.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;

use super::{FONT, PALETTE, Picture, range, tick};

/// How a series is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A line through the points.
    #[default]
    Line,
    /// A broken line: laws and closed forms.
    Dashed,
    /// Markers: measured points.
    Markers,
}

/// Points with a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Name in the legend; none when empty.
    pub label: String,
    /// The points; those that are not finite are left out.
    pub points: Vec<(f64, f64)>,
    /// How they are drawn.
    pub style: Style,
}

impl Series {
    /// A series.
    pub fn new(label: impl Into<String>, points: Vec<(f64, f64)>, style: Style) -> Self {
        Self { label: label.into(), points, style }
    }
}

/// A line chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineChart {
    /// Title above the chart.
    pub title: String,
    /// Label of the horizontal axis, with unit.
    pub x_label: String,
    /// Label of the vertical axis, with unit.
    pub y_label: String,
    /// Logarithmic axes, both; points that are not positive are left out.
    pub log: bool,
    /// What is drawn.
    pub series: Vec<Series>,
}

impl Picture for LineChart {
    fn size(&self) -> (u32, u32) {
        (760, 480)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), String> {
        area.fill(&WHITE).map_err(|error| error.to_string())?;
        let shown = |p: &&(f64, f64)| {
            let finite = p.0.is_finite() && p.1.is_finite() && p.1.abs() < 1e200;
            finite && (!self.log || (p.0 > 0.0 && p.1 > 0.0))
        };
        let all = || self.series.iter().flat_map(|s| &s.points).filter(shown);
        let scale = |v: f64| if self.log { v.log10() } else { v };
        let x = range(all().map(|p| scale(p.0)), 0.03);
        let y = range(all().map(|p| scale(p.1)), 0.08);
        if self.log {
            let power = |r: std::ops::Range<f64>| (10f64.powf(r.start)..10f64.powf(r.end)).log_scale();
            self.draw_in(area, power(x), power(y), [0.0; 2])
        } else {
            let spans = [x.end - x.start, y.end - y.start];
            self.draw_in(area, x, y, spans)
        }
    }
}

impl LineChart {
    /// The corner with the fewest points, for the legend.
    fn emptiest_corner(&self) -> SeriesLabelPosition {
        let scale = |v: f64| if self.log { v.log10() } else { v };
        let at = |p: &(f64, f64)| (scale(p.0), scale(p.1));
        let points: Vec<(f64, f64)> = self.series.iter().flat_map(|s| s.points.iter().map(at)).collect();
        let (x, y) = (range(points.iter().map(|p| p.0), 0.03), range(points.iter().map(|p| p.1), 0.08));
        let share = |v: f64, r: &std::ops::Range<f64>| (v - r.start) / (r.end - r.start);
        // A legend takes about half of the width and a third of the height.
        let crowd = |right: bool, top: bool| {
            let near = |p: &&(f64, f64)| {
                let (u, v) = (share(p.0, &x), share(p.1, &y));
                (if right { u > 0.5 } else { u < 0.5 }) && (if top { v > 0.65 } else { v < 0.35 })
            };
            points.iter().filter(near).count()
        };
        let corners = [
            (crowd(false, true), SeriesLabelPosition::UpperLeft),
            (crowd(true, true), SeriesLabelPosition::UpperRight),
            (crowd(true, false), SeriesLabelPosition::LowerRight),
            (crowd(false, false), SeriesLabelPosition::LowerLeft),
        ];
        let least = corners.into_iter().min_by_key(|(count, _)| *count);
        least.map_or(SeriesLabelPosition::UpperLeft, |(_, corner)| corner)
    }

    /// Draws in axes that span so much; of logarithmic ones nothing.
    fn draw_in<B, X, Y>(
        &self,
        area: &DrawingArea<B, Shift>,
        x: X,
        y: Y,
        spans: [f64; 2],
    ) -> Result<(), String>
    where
        B: DrawingBackend,
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, 20))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(72)
            .build_cartesian_2d(x, y)
            .map_err(text)?;
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_label_formatter(&|at| tick(*at, spans[0]))
            .y_label_formatter(&|at| tick(*at, spans[1]))
            .x_labels(if self.log { 30 } else { 8 })
            .y_labels(if self.log { 30 } else { 8 })
            .label_style((FONT, 14))
            .axis_desc_style((FONT, 16))
            .bold_line_style(RGBColor(225, 225, 225))
            .light_line_style(TRANSPARENT)
            .axis_style(RGBColor(90, 90, 90))
            .draw()
            .map_err(text)?;
        for (number, series) in self.series.iter().enumerate() {
            let colour = PALETTE[number % PALETTE.len()];
            let positive = |p: &&(f64, f64)| !self.log || (p.0 > 0.0 && p.1 > 0.0);
            let points: Vec<(f64, f64)> = series
                .points
                .iter()
                .filter(positive)
                .filter(|p| p.0.is_finite() && p.1.is_finite() && p.1.abs() < 1e200)
                .copied()
                .collect();
            let line = colour.stroke_width(2);
            let drawn = match series.style {
                Style::Line => chart.draw_series(LineSeries::new(points, line)).map_err(text)?,
                Style::Dashed => {
                    chart.draw_series(DashedLineSeries::new(points, 7, 5, line)).map_err(text)?
                }
                Style::Markers => {
                    let markers = points.into_iter().map(|p| Circle::new(p, 4, colour.filled()));
                    chart.draw_series(markers).map_err(text)?
                }
            };
            if !series.label.is_empty() {
                let markers = series.style == Style::Markers;
                drawn.label(&series.label).legend(move |(x, y)| {
                    let line = PathElement::new(vec![(x, y), (x + 18, y)], line);
                    let dot = Circle::new((x + 9, y), if markers { 4 } else { 0 }, colour.filled());
                    let line = if markers { PathElement::new(vec![], colour) } else { line };
                    EmptyElement::at((0, 0)) + line + dot
                });
            }
        }
        if self.series.iter().any(|s| !s.label.is_empty()) {
            chart
                .configure_series_labels()
                .position(self.emptiest_corner())
                .background_style(WHITE.mix(0.85))
                .border_style(RGBColor(200, 200, 200))
                .label_font((FONT, 14))
                .margin(8)
                .draw()
                .map_err(text)?;
        }
        Ok(())
    }
}
