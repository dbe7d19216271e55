//! File of the points of a body.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Points from a CSV file. The first line names the columns, in any order; numbers are in the units below, or in that between brackets
/// after a name, as `x (mm)` or `stress_yy (kPa)`. Lines that begin with `#` are ignored. The columns are:
///
/// - `x`, `y`, `z`: the position (m), as many as the space has dimensions;
/// - `volume`: the volume of the point (m³; the area in m² in plane strain and in axisymmetry, the length in m in 1D), unless
///   `spacing` is given;
/// - `mass`: the mass of the point (kg; kg/m in plane strain, kg/rad in axisymmetry), with the fluid in its pores, in place of the
///   volume times the density of the material. The density of the point is its mass over its volume. For `depth-sph`, whose flows
///   have one density, its volume follows from the mass;
/// - `velocity_x`, `velocity_y`, `velocity_z`: the initial velocity (m/s), in place of the body's `velocity`; zero for those absent;
/// - `stress_xx`, `stress_yy`, `stress_zz`, `stress_xy`, `stress_yz`, `stress_zx`: the initial stress (Pa, tension-positive), in
///   place of the body's `stress`; zero for those absent;
/// - `pore_pressure`: the initial pore pressure (Pa, compression-positive), in place of that of the body's `pore_fluid`.
///
/// Further columns for `dem`, which other methods ignore:
///
/// - `radius`: the radius of the grain (m); without it the grain is as large as the point. With it `volume` may be absent, and is that
///   of the grain;
/// - `kind`: the kind of the grain, one of `methods.dem.grains`, in place of the body's material;
/// - `spin_x`, `spin_y`, `spin_z`: the initial spin (rad/s), in the plane `spin_z`; zero for those absent;
/// - `held`: 1 for fixed grains, 0 for others;
/// - `id`: the number of the grain in all output, a whole number that no other grain has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointFile {
    /// Name of the file, from the folder of the case.
    pub file: String,
    /// Distance of the points (m), each of which then represents a square or a cube; for files without a column `volume`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing: Option<f64>,
}
