//! Charts of curves: axes, ticks, lines and markers.

pub(crate) mod axis_ticks;
pub(crate) mod line_chart;
pub(crate) mod plane_axes;
