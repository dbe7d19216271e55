//! Polygons and outlines in plan, and integrals over the parts of raster cells within them (m, m²).
//!
//! Outlines come from `colluvium-terrain` or a case; heights are in `terrain`.

pub(crate) mod outline;
pub(crate) mod plan_integral;
pub(crate) mod polygon;
