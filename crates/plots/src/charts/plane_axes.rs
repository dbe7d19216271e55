//! Axes of pictures of a plane.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::FONT;
use crate::charts::axis_ticks::{AxisDirection, LETTERS, NumberAxis, Ticks};

/// Axes of a plane, both of numbers.
pub(crate) type PlaneAxes<'a, B> = ChartContext<'a, B, Cartesian2d<NumberAxis, NumberAxis>>;

/// Size of a pixel (m) at which the ranges of two axes fill at most the given numbers of pixels.
pub(crate) fn scale([x, y]: &[Range<f64>; 2], pixels: [u32; 2]) -> f64 {
    ((x.end - x.start) / f64::from(pixels[0])).max((y.end - y.start) / f64::from(pixels[1]))
}

/// Draws axes of equal scales under a title. The range of the axis that has pixels left is widened.
pub(crate) fn plane<'a, B: DrawingBackend>(
    area: &'a DrawingArea<B, Shift>,
    title: &str,
    axes: &[String; 2],
    ranges: [Range<f64>; 2],
    pixels: [u32; 2],
) -> Result<PlaneAxes<'a, B>, String> {
    let text = |error: DrawingAreaErrorKind<B::ErrorType>| error.to_string();
    let pixel = scale(&ranges, pixels);
    let [mut x, mut y] = ranges;
    for (range, pixels) in [&mut x, &mut y].into_iter().zip(pixels) {
        let extra = 0.5 * (pixel * f64::from(pixels) - (range.end - range.start)).max(0.0);
        *range = range.start - extra..range.end + extra;
    }
    let across = Ticks::linear(&x, f64::from(pixels[0]), AxisDirection::Horizontal);
    let up = Ticks::linear(&y, f64::from(pixels[1]), AxisDirection::Vertical);
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 20))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(66)
        .build_cartesian_2d(NumberAxis::new(x, across.clone()), NumberAxis::new(y, up.clone()))
        .map_err(text)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc(across.axis_label(&axes[0]))
        .y_desc(up.axis_label(&axes[1]))
        .label_style((FONT, LETTERS))
        .axis_desc_style((FONT, 16))
        .draw()
        .map_err(text)?;
    Ok(chart)
}
