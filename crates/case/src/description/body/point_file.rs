//! File of the points of a body.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Points from a CSV file. The first line names the columns, in any order. Numbers are in units below, or in brackets after a name, as `x
/// (mm)`. Lines beginning with `#` are ignored. Columns:
///
/// - `x`, `y`, `z`: position (m), one per space dimension;
/// - `volume`: volume (m³; m² in plane strain and axisymmetry, m in 1D), unless `spacing` is given;
/// - `mass`: mass with pore fluid (kg; kg/m in plane strain, kg/rad in axisymmetry), in place of volume times density. It sets the point's
///   density; in `depth-sph`, whose flows have one density, its volume;
/// - `velocity_x`, `velocity_y`, `velocity_z`: initial velocity (m/s), in place of the body's; zero for those absent;
/// - `stress_xx`, `stress_yy`, `stress_zz`, `stress_xy`, `stress_yz`, `stress_zx`: initial stress (Pa, tension-positive), in place of the
///   body's; zero for those absent;
/// - `pore_pressure`: initial pore pressure (Pa, compression-positive), in place of the `pore_fluid`'s.
///
/// Columns for `dem` only:
///
/// - `radius`: radius (m), which gives an absent `volume`, and the reverse;
/// - `kind`: kind, of `methods.dem.grains`, in place of the body's material;
/// - `spin_x`, `spin_y`, `spin_z`: initial spin (rad/s), in the plane `spin_z`; zero for those absent;
/// - `held`: 1 for fixed grains, else 0;
/// - `id`: number in all output, whole and unique.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointFile {
    /// File.
    pub file: String,
    /// Distance (m) of points, each a square or cube, for files without `volume`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing: Option<f64>,
}
