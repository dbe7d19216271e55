//! File of the points of a body.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Points from a CSV file. The first line names the columns, in any order. Numbers are in the units below, or in those in brackets after a
/// name, as `x (mm)`. Lines that begin with `#` are ignored. Columns:
///
/// - `x`, `y`, `z`: position (m), one per space dimension;
/// - `volume`: volume of the point (m³; m² in plane strain and axisymmetry, m in 1D), unless `spacing` is given;
/// - `mass`: mass of the point with its pore fluid (kg; kg/m in plane strain, kg/rad in axisymmetry), in place of volume times density. It
///   sets the density of the point; in `depth-sph`, whose flows have one density, its volume;
/// - `velocity_x`, `velocity_y`, `velocity_z`: initial velocity (m/s), in place of the body's; zero for those absent;
/// - `stress_xx`, `stress_yy`, `stress_zz`, `stress_xy`, `stress_yz`, `stress_zx`: initial stress (Pa, tension-positive), in place of the
///   body's; zero for those absent;
/// - `pore_pressure`: initial pore pressure (Pa, compression-positive), in place of that of the `pore_fluid`.
///
/// Columns for `dem`, which other methods ignore:
///
/// - `radius`: radius of the grain (m), which gives an absent `volume`; without it the volume gives the radius;
/// - `kind`: kind of the grain, one of `methods.dem.grains`, in place of the body's material;
/// - `spin_x`, `spin_y`, `spin_z`: initial spin (rad/s), in the plane `spin_z`; zero for those absent;
/// - `held`: 1 for fixed grains, 0 for others;
/// - `id`: number of the grain in all output, whole and unique.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointFile {
    /// File.
    pub file: String,
    /// Distance of points (m), each a square or cube, for files without `volume`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing: Option<f64>,
}
