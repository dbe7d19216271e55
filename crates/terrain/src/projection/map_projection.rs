//! Map projections of coordinate reference systems, by well-known texts of either version and of Esri, and by the EPSG registry.

use colluvium_points::Georeference;

use crate::projection::well_known_text;
use crate::projection::well_known_text::{GEOCENTRIC, WEB_MERCATOR, WORLD_MAP};

/// Kinds of projections, each with words of which its names contain one.
const PROJECTION_METHODS: [(&str, &[&str]); 11] = [
    ("oblique Mercator", &["oblique_mercator", "hotine", "swiss_oblique", "rectified_skew"]),
    ("transverse Mercator", &["transverse_mercator", "gauss_kruger"]),
    ("Lambert conformal conic", &["lambert_conformal", "lambert_conic_conformal"]),
    ("Lambert azimuthal equal-area", &["azimuthal_equal_area"]),
    ("Albers", &["albers"]),
    ("stereographic", &["stereographic"]),
    ("Krovak", &["krovak"]),
    ("Cassini", &["cassini"]),
    ("polyconic", &["polyconic"]),
    ("New Zealand map grid", &["new_zealand_map_grid"]),
    ("Mercator", &["mercator"]),
];

/// Parameter of a projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ProjectionParameter {
    /// Longitude of the origin (°, east of Greenwich).
    Meridian,
    /// Latitude of the origin (°).
    Latitude,
    /// Standard parallel (°).
    Parallel,
    /// Azimuth of the initial line (°).
    Azimuth,
    /// Scale at the origin.
    Scale,
    /// Easting of the origin (m).
    Easting,
    /// Northing of the origin (m).
    Northing,
}

impl ProjectionParameter {
    /// Parameter that has a name of well-known text.
    fn from_name(name: &str) -> Option<Self> {
        let has = |word: &str| name.contains(word);
        Some(match () {
            () if has("easting") => Self::Easting,
            () if has("northing") => Self::Northing,
            () if has("scale") => Self::Scale,
            () if has("azimuth") => Self::Azimuth,
            () if has("parallel") => Self::Parallel,
            () if has("longitude") || has("meridian") => Self::Meridian,
            () if has("latitude") => Self::Latitude,
            () => return None,
        })
    }

    /// Whether the parameter is an angle.
    fn is_angle(self) -> bool {
        matches!(self, Self::Meridian | Self::Latitude | Self::Parallel | Self::Azimuth)
    }

    /// Difference of two values that counts as round-off.
    fn tolerance(self) -> f64 {
        match self {
            Self::Scale => 1e-8,
            Self::Easting | Self::Northing => 0.01,
            _ => 1e-6,
        }
    }
}

/// Difference of semi-major axes (m) that counts as round-off.
const AXIS_TOLERANCE: f64 = 1.0;

/// Projection of a horizontal coordinate reference system.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MapProjection {
    kind: Option<&'static str>,
    parameters: Vec<(ProjectionParameter, f64)>,
    /// Semi-major axis of the ellipsoid (m).
    ellipsoid: Option<f64>,
}

impl MapProjection {
    /// Projection of a well-known text; `None` where it has none.
    pub(crate) fn from_well_known_text(text: &str) -> Option<Self> {
        let mut found = Self::default();
        let (mut degrees, mut greenwich) = (1.0, 0.0);
        well_known_text::visit_brackets(text, |open, after| {
            let (keyword, above) = open.split_last()?;
            let parent = above.last().map_or("", String::as_str);
            let number = || number_after_name(after);
            match keyword.as_str() {
                "PROJECTION" | "METHOD" => {
                    found.kind = projection_method(&normalised_name(quoted_name(after)?));
                }
                "SPHEROID" | "ELLIPSOID" => found.ellipsoid = number(),
                "PRIMEM" => greenwich = number()?,
                // In the first version, angles of parameters are in the unit of the base system, which precedes them.
                "UNIT" if ["GEOGCS", "BASEGEOGCS"].contains(&parent) => degrees = number()?.to_degrees(),
                "PARAMETER" => {
                    let parameter = ProjectionParameter::from_name(&normalised_name(quoted_name(after)?))?;
                    let unit = if parameter.is_angle() { degrees } else { 1.0 };
                    found.parameters.push((parameter, number()? * unit));
                }
                // In the second version, each parameter has its own unit.
                "ANGLEUNIT" if parent == "PARAMETER" => {
                    found.parameters.last_mut()?.1 *= number()?.to_degrees();
                }
                "LENGTHUNIT" if parent == "PARAMETER" => found.parameters.last_mut()?.1 *= number()?,
                _ => {}
            }
            Some(())
        });
        for (parameter, value) in &mut found.parameters {
            if *parameter == ProjectionParameter::Meridian {
                *value += greenwich;
            }
        }
        (found.kind.is_some() && !found.parameters.is_empty()).then_some(found)
    }

    /// Whether two projections are known to differ: by their kinds, their ellipsoids, or a parameter that both have.
    pub(crate) fn differs(&self, other: &Self) -> bool {
        let kinds = self.kind != other.kind;
        let ellipsoids = self.ellipsoid.zip(other.ellipsoid);
        let of = |all: &Self, parameter: ProjectionParameter| {
            let mut values: Vec<f64> =
                all.parameters.iter().filter(|(own, _)| *own == parameter).map(|(_, value)| *value).collect();
            // Texts name two standard parallels in either order.
            values.sort_by(f64::total_cmp);
            values
        };
        let parameters = self.parameters.iter().any(|&(parameter, _)| {
            let (own, others) = (of(self, parameter), of(other, parameter));
            own.len() == others.len()
                && own.iter().zip(&others).any(|(a, b)| (a - b).abs() > parameter.tolerance())
        });
        kinds || ellipsoids.is_some_and(|(a, b)| (a - b).abs() > AXIS_TOLERANCE) || parameters
    }
}

/// Words in the names of projections for world maps.
const WORLD_MAP_WORDS: [&str; 13] = [
    "cylindrical",
    "plate_carree",
    "equirectangular",
    "mollweide",
    "sinusoidal",
    "robinson",
    "eckert",
    "miller",
    "winkel",
    "goode",
    "equal_earth",
    "natural_earth",
    "van_der_grinten",
];

/// Reason why lengths in a coordinate reference system differ from those on the ground, by the method of its projection; `None` where they
/// do not.
pub(crate) fn length_distortion(text: &str) -> Option<&'static str> {
    let (mut method, mut is_geocentric) = (String::new(), false);
    well_known_text::visit_brackets(text, |open, after| {
        match open.last()?.as_str() {
            "PROJECTION" | "METHOD" => method = normalised_name(quoted_name(after)?),
            "GEOCCS" => is_geocentric = true,
            "CS" => is_geocentric |= after.replace(' ', "").starts_with("Cartesian,3"),
            _ => {}
        }
        Some(())
    });
    if is_geocentric {
        return Some(GEOCENTRIC);
    }
    if method.contains("pseudo_mercator")
        || method.contains("auxiliary_sphere")
        || text.to_lowercase().contains("pseudo-mercator")
    {
        return Some(WEB_MERCATOR);
    }
    match projection_method(&method) {
        Some("Mercator") => {
            let parameters =
                MapProjection::from_well_known_text(text).map(|found| found.parameters).unwrap_or_default();
            // A system with true lengths elsewhere than at the equator is a regional one.
            let is_regional = parameters.iter().any(|(parameter, value)| match parameter {
                ProjectionParameter::Parallel => *value != 0.0,
                ProjectionParameter::Scale => *value != 1.0,
                _ => false,
            });
            (!is_regional).then_some(WORLD_MAP)
        }
        None if WORLD_MAP_WORDS.iter().any(|word| method.contains(word)) => Some(WORLD_MAP),
        _ => None,
    }
}

/// Well-known text of a coordinate reference system of the EPSG registry.
pub(crate) fn epsg_well_known_text(epsg: u32) -> Option<&'static str> {
    crs_definitions::from_code(u16::try_from(epsg).ok()?).map(|system| system.wkt)
}

/// Well-known text of a raster's horizontal system, from the raster or from the EPSG registry.
pub(crate) fn georeference_well_known_text(reference: &Georeference) -> Option<String> {
    let own = reference.crs.clone().filter(|text| well_known_text::is_well_known(text));
    let text = own.or_else(|| Some(epsg_well_known_text(reference.epsg?)?.to_owned()))?;
    Some(well_known_text::horizontal_part(&text).to_owned())
}

/// PROJ name of a projection method that has a name in well-known text.
fn projection_method(method: &str) -> Option<&'static str> {
    PROJECTION_METHODS
        .iter()
        .find(|(_, words)| words.iter().any(|word| method.contains(word)))
        .map(|(kind, _)| *kind)
}

/// Name in lower-case letters and digits, with all other characters as `_`.
fn normalised_name(name: &str) -> String {
    name.to_lowercase().replace(|letter: char| !letter.is_ascii_alphanumeric(), "_")
}

/// Quoted name at the beginning of a bracket.
pub(crate) fn quoted_name(after: &str) -> Option<&str> {
    after.trim_start().strip_prefix('"')?.split('"').next()
}

/// Number after the name at the beginning of a bracket.
fn number_after_name(after: &str) -> Option<f64> {
    let rest = after.trim_start().strip_prefix('"')?.split_once('"')?.1;
    rest.trim_start_matches([',', ' ', '\n', '\r', '\t']).split([',', ']', ')']).next()?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_epsg(code: u32) -> MapProjection {
        MapProjection::from_well_known_text(epsg_well_known_text(code).unwrap()).unwrap()
    }

    const SWISS_OF_ESRI: &str = r#"PROJCS["CH1903+_LV95",GEOGCS["GCS_CH1903+",DATUM["D_CH1903+",SPHEROID["Bessel_1841",6377397.155,299.1528128]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Hotine_Oblique_Mercator_Azimuth_Center"],PARAMETER["False_Easting",2600000.0],PARAMETER["False_Northing",1200000.0],PARAMETER["Scale_Factor",1.0],PARAMETER["Azimuth",90.0],PARAMETER["Longitude_Of_Center",7.439583333333333],PARAMETER["Latitude_Of_Center",46.95240555555556],UNIT["Meter",1.0]]"#;

    #[test]
    fn texts_of_esri_are_those_of_the_registry_and_of_no_other_system() {
        let swiss = MapProjection::from_well_known_text(SWISS_OF_ESRI).unwrap();
        assert!(!swiss.differs(&of_epsg(2056)));
        for other in [21781, 25832, 31254, 2154, 3035, 3857] {
            assert!(swiss.differs(&of_epsg(other)) && of_epsg(other).differs(&swiss), "{other}");
        }
    }

    #[test]
    fn standard_parallels_are_unordered_and_meridians_refer_to_greenwich() {
        let lambert = |parallels: [f64; 2], prime: f64, meridian: f64| {
            let text = format!(
                r#"PROJCS["x",GEOGCS["y",DATUM["z",SPHEROID["w",6378137,298.257]],PRIMEM["p",{prime}],UNIT["degree",0.0174532925199433]],PROJECTION["Lambert_Conformal_Conic"],PARAMETER["False_Easting",700000],PARAMETER["False_Northing",6600000],PARAMETER["Central_Meridian",{meridian}],PARAMETER["Standard_Parallel_1",{}],PARAMETER["Standard_Parallel_2",{}],PARAMETER["Latitude_Of_Origin",46.5],UNIT["Meter",1]]"#,
                parallels[0], parallels[1]
            );
            MapProjection::from_well_known_text(&text).unwrap()
        };
        let france = of_epsg(2154);
        assert!(!lambert([44.0, 49.0], 0.0, 3.0).differs(&france));
        assert!(!lambert([49.0, 44.0], 2.0, 1.0).differs(&france));
        assert!(lambert([49.0, 45.0], 0.0, 3.0).differs(&france));
        assert!(lambert([49.0, 44.0], 0.0, 3.5).differs(&france));
    }

    #[test]
    fn angles_of_either_version_are_in_their_units() {
        let second = r#"PROJCRS["x",BASEGEOGCRS["y",DATUM["z",ELLIPSOID["w",6378137,298.2,LENGTHUNIT["metre",1]]],PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174532925199433]]],CONVERSION["UTM zone 33N",METHOD["Transverse Mercator",ID["EPSG",9807]],PARAMETER["Latitude of natural origin",0,ANGLEUNIT["degree",0.0174532925199433]],PARAMETER["Longitude of natural origin",15,ANGLEUNIT["degree",0.0174532925199433]],PARAMETER["Scale factor at natural origin",0.9996,SCALEUNIT["unity",1]],PARAMETER["False easting",500000,LENGTHUNIT["metre",1]],PARAMETER["False northing",0,LENGTHUNIT["metre",1]]],CS[Cartesian,2]]"#;
        assert!(!MapProjection::from_well_known_text(second).unwrap().differs(&of_epsg(32633)));
        assert!(MapProjection::from_well_known_text(second).unwrap().differs(&of_epsg(32632)));
        // NTF (Paris): grads from Paris, where the longitude is 0 grad.
        let paris = of_epsg(27572);
        let meridian = paris
            .parameters
            .iter()
            .find(|(parameter, _)| *parameter == ProjectionParameter::Meridian)
            .unwrap()
            .1;
        assert!((meridian - 2.337_229_17).abs() < 1e-6, "{meridian}");
    }

    #[test]
    fn systems_of_the_registry_that_are_projected_have_a_projection() {
        let codes =
            [2056, 2154, 2180, 3035, 3857, 5514, 21781, 25832, 26910, 27700, 28992, 31254, 31467, 32633];
        for code in codes {
            assert!(
                epsg_well_known_text(code).and_then(MapProjection::from_well_known_text).is_some(),
                "{code}"
            );
        }
        assert!(
            epsg_well_known_text(4326).and_then(MapProjection::from_well_known_text).is_none()
                && epsg_well_known_text(1).is_none()
        );
    }
}
