//! Template of a debris flow: a case with the files that it names.

use crate::points::Raster;

/// Name of the case.
pub(crate) const NAME: &str = "debris-flow";

/// Name of the file of the terrain.
pub(crate) const TERRAIN_FILE: &str = "debris-flow-terrain.asc";
/// Name and text of the file of the release area.
pub(crate) const RELEASE_FILE: (&str, &str) =
    ("debris-flow-release.geojson", include_str!("flows/debris-flow-release.geojson"));

/// South-western corner of the terrain on its map (m).
const MAP_CORNER: [f64; 2] = [600_000.0, 5_200_000.0];

/// Terrain: a slope that becomes gentle, with a winding channel that ends on a fan, at nodes 5 m apart.
pub(crate) fn terrain() -> Raster {
    Raster::from_function([181, 81], MAP_CORNER, [5.0; 2], |east, north| {
        let (x, y) = (east - MAP_CORNER[0], north - MAP_CORNER[1]);
        let fan = {
            let t = ((x - 400.0) / 240.0).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        let aside = y - 200.0 - 18.0 * (x / 90.0).sin();
        let slope = 20.0 + 170.0 * (-x / 320.0).exp() + 0.05 * (900.0 - x);
        let flanks =
            0.22 * ((aside * aside + 400.0).sqrt() - 20.0) * (1.0 - fan) - 0.0004 * aside * aside * fan;
        let channel = 9.0 * (-aside * aside / 450.0).exp() * (1.0 - fan);
        // Heights rounded to centimetres, as in surveys.
        ((slope + flanks - channel) * 100.0).round() / 100.0
    })
}
