//! Coordinate reference systems by PROJ strings, such as `+proj=utm +zone=10 +datum=NAD83 +units=m`.

use std::collections::HashMap;
use std::fmt::Write;

/// Names of projections in PROJ and in well-known texts.
const PROJECTIONS: [(&str, &str); 15] = [
    ("utm", "Transverse_Mercator"),
    ("tmerc", "Transverse_Mercator"),
    ("etmerc", "Transverse_Mercator"),
    ("lcc", "Lambert_Conformal_Conic"),
    ("laea", "Lambert_Azimuthal_Equal_Area"),
    ("aea", "Albers_Conic_Equal_Area"),
    ("stere", "Polar_Stereographic"),
    ("sterea", "Oblique_Stereographic"),
    ("somerc", "Swiss_Oblique_Mercator"),
    ("omerc", "Hotine_Oblique_Mercator"),
    ("krovak", "Krovak"),
    ("cass", "Cassini_Soldner"),
    ("merc", "Mercator"),
    ("webmerc", "Popular_Visualisation_Pseudo_Mercator"),
    ("eqc", "Equidistant_Cylindrical"),
];

/// Names of parameters in PROJ and in well-known texts.
const PARAMETERS: [(&str, &str); 10] = [
    ("lat_0", "latitude_of_origin"),
    ("lon_0", "central_meridian"),
    ("lonc", "longitude_of_center"),
    ("alpha", "azimuth"),
    ("k", "scale_factor"),
    ("k_0", "scale_factor"),
    ("x_0", "false_easting"),
    ("y_0", "false_northing"),
    ("lat_1", "standard_parallel_1"),
    ("lat_2", "standard_parallel_2"),
];

/// Sizes of the units of PROJ (m).
const UNITS: [(&str, f64); 7] = [
    ("m", 1.0),
    ("km", 1e3),
    ("dm", 0.1),
    ("cm", 0.01),
    ("mm", 1e-3),
    ("ft", 0.3048),
    ("us-ft", 1200.0 / 3937.0),
];

/// Whether a text is a PROJ string.
pub(crate) fn is_proj_string(text: &str) -> bool {
    text.contains("+proj=") || text.contains("+init=")
}

/// Well-known text of a PROJ string. It has the parts that comparisons use: the projection, its parameters, and the unit.
///
/// # Errors
/// When the projection is unknown.
pub(crate) fn to_well_known_text(text: &str) -> Result<String, String> {
    let words = text.split_whitespace().filter_map(|word| word.strip_prefix('+'));
    let keys: HashMap<&str, &str> = words.map(|word| word.split_once('=').unwrap_or((word, ""))).collect();
    let unread = || {
        format!("has its system as a PROJ text that is not supported, {text:?}: write it as well-known text")
    };
    if let Some(code) = keys.get("init").and_then(|init| crate::projection::well_known_text::epsg_code(init))
    {
        return crate::projection::map_projection::epsg_well_known_text(code)
            .map(str::to_owned)
            .ok_or_else(unread);
    }
    let name = *keys.get("proj").ok_or_else(unread)?;
    /// End of the well-known text of a system with an unknown datum, in degrees from Greenwich.
    const GLOBE: &str = r#"DATUM["unknown"],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]"#;
    if ["longlat", "latlong", "lonlat", "latlon"].contains(&name) {
        return Ok(format!(r#"GEOGCS["unknown",{GLOBE}"#));
    }
    if ["geocent", "cart"].contains(&name) {
        return Ok(r#"GEOCCS["unknown",UNIT["metre",1]]"#.to_owned());
    }
    let (_, method) = PROJECTIONS.iter().find(|(own, _)| *own == name).ok_or_else(unread)?;
    let mut values: Vec<(&str, f64)> = Vec::new();
    if name == "utm" {
        let zone: f64 = keys.get("zone").and_then(|zone| zone.parse().ok()).ok_or_else(unread)?;
        let northing = if keys.contains_key("south") { 1e7 } else { 0.0 };
        values.extend([
            ("latitude_of_origin", 0.0),
            ("central_meridian", 6.0 * zone - 183.0),
            ("scale_factor", 0.9996),
        ]);
        values.extend([("false_easting", 5e5), ("false_northing", northing)]);
    } else {
        for (own, other) in PARAMETERS {
            if let Some(value) = keys.get(own) {
                values.push((other, value.parse().map_err(|_| unread())?));
            }
        }
    }
    let (unit, metres) = length(&keys, ["units", "to_meter"]).unwrap_or(("m", 1.0));
    let mut found =
        format!(r#"PROJCS["{}",GEOGCS["unknown",{GLOBE},PROJECTION["{method}"]"#, text.replace('"', " "));
    for (name, value) in values {
        let _ = write!(found, r#",PARAMETER["{name}",{value}]"#);
    }
    let _ = write!(found, r#",UNIT["{unit}",{metres}]]"#);
    // Heights have a unit of their own where it is named.
    Ok(match length(&keys, ["vunits", "vto_meter"]) {
        Some((unit, metres)) => {
            format!(r#"COMPD_CS["unknown",{found},VERT_CS["unknown",UNIT["{unit}",{metres}]]]"#)
        }
        None => found,
    })
}

/// Name and size (m) of a unit, under two keys of which the size takes precedence. NaN for an unknown unit; `None` where the text has
/// neither key.
fn length<'a>(keys: &HashMap<&str, &'a str>, [name, size]: [&str; 2]) -> Option<(&'a str, f64)> {
    let known =
        |unit: &str| UNITS.iter().find(|(own, _)| *own == unit).map_or(f64::NAN, |(_, metres)| *metres);
    match (keys.get(name), keys.get(size)) {
        (_, Some(size)) => Some((keys.get(name).unwrap_or(size), size.parse().unwrap_or(f64::NAN))),
        (Some(unit), None) => Some((unit, known(unit))),
        (None, None) => None,
    }
}
