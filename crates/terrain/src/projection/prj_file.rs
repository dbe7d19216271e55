//! Coordinate reference system in a `.prj` file: well-known text, or the lines of ArcInfo.

use std::path::Path;

use colluvium_points::Georeference;

use crate::projection::well_known_text::{epsg_code, is_well_known, visit_brackets};
use crate::projection::{map_projection, proj_string};
use crate::raster_band;
use crate::raster_band::{is_length, metres_per_unit};

/// Relative deviation of a unit of length from the metre, up to which it counts as the metre.
const UNIT_TOLERANCE: f64 = 1e-9;

/// Text of the `.prj` file beside a file; `None` where there is none.
pub(crate) fn read_text(file: &Path) -> Result<Option<String>, String> {
    let beside = ["prj", "PRJ"].map(|ending| file.with_extension(ending));
    let Some(prj) = beside.iter().find(|path| path.is_file()) else { return Ok(None) };
    let read =
        crate::read_text(prj).map_err(|error| format!("{} beside it {}", file_name(prj), error.problem))?;
    to_well_known_text(read.trim())
        .map(Some)
        .map_err(|problem| format!("{} beside it {problem}", file_name(prj)))
}

/// Converts an EPSG code or a PROJ string to well-known text; returns other texts unchanged.
fn to_well_known_text(text: &str) -> Result<String, String> {
    let words = text.lines().filter_map(|line| line.split_whitespace().next());
    let is_of_arcinfo =
        words.map(str::to_lowercase).any(|word| ["projection", "units"].contains(&word.as_str()));
    if text.is_empty() || is_well_known(text) {
        return Ok(text.to_owned());
    }
    if proj_string::is_proj_string(text) {
        return proj_string::to_well_known_text(text);
    }
    if let Some(code) = epsg_code(text) {
        let problem = || format!("has EPSG:{code}, which is not supported: write it as well-known text");
        return map_projection::epsg_well_known_text(code).map(str::to_owned).ok_or_else(problem);
    }
    if is_of_arcinfo {
        return Ok(text.to_owned());
    }
    let start: String = text.chars().take(40).collect();
    Err(format!("has no readable coordinate reference system, {start:?}: write it as well-known text"))
}

/// Name of a file without its folder.
fn file_name(file: &Path) -> String {
    file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Checks that the `.prj` file beside a file, or the `.aux.xml` of GDAL, has the metre as unit. Files without one are accepted.
pub(crate) fn check_metres(file: &Path) -> Result<(), String> {
    let of_gdal = || {
        Ok::<_, String>(
            raster_band::sidecar_band(file)?.crs.map(|text| (format!("{}.aux.xml", file_name(file)), text)),
        )
    };
    let own = read_text(file)?.map(|text| (file_name(&file.with_extension("prj")), text));
    let Some((beside, text)) = own.map_or_else(of_gdal, |own| Ok(Some(own)))? else { return Ok(()) };
    match non_metre_unit(&text) {
        None => match map_projection::length_distortion(&text) {
            Some(fault) => Err(format!("by {beside} beside it, it {fault}")),
            None => Ok(()),
        },
        Some(unit) => Err(format!(
            "by {beside} beside it, it is in {unit:?}, but only metres are supported, in plan and in height: \
             project it, or write its heights, in metres"
        )),
    }
}

/// Name of the system of a well-known text.
pub(crate) fn system_name(text: &str) -> Option<String> {
    let after = text.split_once(['[', '('])?.1;
    map_projection::quoted_name(after).map(str::to_owned)
}

/// Sets the coordinate reference system of a raster to that of `text`, the content of the PRJ file beside it.
pub(crate) fn set_georeference(reference: &mut Georeference, text: Option<String>) {
    let text = text.filter(|text| is_well_known(text));
    (reference.epsg, reference.crs) = (text.as_deref().and_then(epsg), text);
}

/// Unit of coordinates or heights that is not the metre; `None` where all are metres.
pub(crate) fn non_metre_unit(text: &str) -> Option<String> {
    let units = if is_well_known(text) { length_units(text) } else { arcinfo_units(text) };
    // A unit of unknown size is not the metre.
    let is_metre = |metres: Option<f64>| metres.is_some_and(|metres| (metres - 1.0).abs() <= UNIT_TOLERANCE);
    let is_named_otherwise = |unit: &str| is_length(unit) && metres_per_unit(unit) != Some(1.0);
    let other = |(unit, metres): &(String, Option<f64>)| !is_metre(*metres) || is_named_otherwise(unit);
    units.into_iter().find(other).map(|(unit, _)| unit)
}

/// Name and size (m) of the unit of heights in a well-known text, where it has heights.
pub(crate) fn height_unit(text: &str) -> Option<(String, Option<f64>)> {
    let mut found = None;
    visit_brackets(text, |open, after| {
        let vertical =
            |name: &String| ["VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"].contains(&name.as_str());
        let own = open.iter().any(vertical).then(|| unit_after(open, after)).flatten()?;
        found = found.take().or(Some(own));
        Some(())
    });
    found
}

/// EPSG code of the projected system of a well-known text, where it has one.
pub(crate) fn epsg(text: &str) -> Option<u32> {
    let projected = |name: &String| ["PROJCS", "PROJCRS", "PROJECTEDCRS"].contains(&name.as_str());
    let mut found = None;
    visit_brackets(text, |open, after| {
        let (keyword, above) = open.split_last()?;
        let is_own = above.last().is_some_and(projected) && ["AUTHORITY", "ID"].contains(&keyword.as_str());
        let after = after.trim_start().strip_prefix("\"EPSG\"").filter(|_| is_own)?;
        let code = after.trim_start_matches([',', ' ', '"']).split(['"', ']', ')']).next()?;
        found = code.trim().parse().ok().or(found);
        Some(())
    });
    found
}

/// Units of coordinates and heights with their sizes (m), without angular units.
fn length_units(text: &str) -> Vec<(String, Option<f64>)> {
    let mut units = Vec::new();
    visit_brackets(text, |open, after| {
        units.push(unit_after(open, after)?);
        Some(())
    });
    units
}

/// Unit of coordinates in a bracket that has just been opened; `None` where it is no such unit.
fn unit_after(open: &[String], after: &str) -> Option<(String, Option<f64>)> {
    let (keyword, above) = open.split_last()?;
    // Ellipsoids, parameters of projections and base systems have units of their own.
    let inner = |name: &String| {
        [
            "SPHEROID",
            "ELLIPSOID",
            "PARAMETER",
            "CONVERSION",
            "BASEGEOGCRS",
            "BASEGEODCRS",
            "PRIMEM",
            "BBOX",
            "USAGE",
        ]
        .contains(&name.as_str())
    };
    let geographic =
        |name: &String| ["GEOGCS", "GEOGCRS", "GEODCRS", "GEOGRAPHICCRS"].contains(&name.as_str());
    let projected = |name: &String| ["PROJCS", "PROJCRS", "PROJECTEDCRS"].contains(&name.as_str());
    let [inside, on_globe, in_plane] =
        [above.iter().any(inner), above.iter().any(geographic), above.iter().any(projected)];
    if inside || on_globe && in_plane {
        return None;
    }
    if !["UNIT", "LENGTHUNIT", "ANGLEUNIT"].contains(&keyword.as_str()) {
        return None;
    }
    let name = after.split('"').nth(1).unwrap_or_default().to_owned();
    let angle = keyword == "ANGLEUNIT" || on_globe;
    let length = after.split('"').nth(2).and_then(|text| {
        text.trim_start_matches([',', ' ']).split([',', ']', ')']).next()?.trim().parse::<f64>().ok()
    });
    Some((name, length.filter(|_| !angle)))
}

/// Units of the lines `Units METERS` and `Zunits METERS` of ArcInfo; `Zunits NO` means that there are no heights.
fn arcinfo_units(text: &str) -> Vec<(String, Option<f64>)> {
    let words = text.lines().filter_map(|line| line.split_once(char::is_whitespace));
    let named = words.map(|(key, unit)| (key.to_lowercase(), unit.trim()));
    let units =
        named.filter(|(key, unit)| key == "units" || key == "zunits" && !unit.eq_ignore_ascii_case("no"));
    let metres = |unit: &str| ["METERS", "METRES", "METER", "METRE"].contains(&unit.to_uppercase().as_str());
    units.map(|(_, unit)| (unit.to_owned(), metres(unit).then_some(1.0))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::well_known_text::horizontal_part;

    const DEGREES: &str = r#"GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]]"#;

    fn plan(unit: &str) -> String {
        format!(
            r#"PROJCS["NAD_1983 (UTM), zone 10",{DEGREES},PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],{unit}]"#
        )
    }

    fn checked(text: &str) -> Result<(), String> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("area.prj"), text).unwrap();
        check_metres(&folder.path().join("area.shp"))
    }

    #[test]
    fn metres_are_accepted_and_feet_and_degrees_are_refused_by_name() {
        assert_eq!(checked(&plan(r#"UNIT["Meter",1.0]"#)), Ok(()));
        assert!(checked(&plan(r#"UNIT["Foot_US",0.3048006096012192]"#)).unwrap_err().contains("Foot_US"));
        assert!(checked(DEGREES).unwrap_err().contains("Degree"));
        let heights = |unit: &str| {
            format!(
                r#"COMPD_CS["both",{},VERT_CS["height",VERT_DATUM["d",2005],{unit}]]"#,
                plan(r#"UNIT["metre",1]"#)
            )
        };
        assert_eq!(checked(&heights(r#"UNIT["metre",1,AUTHORITY["EPSG","9001"]]"#)), Ok(()));
        assert!(checked(&heights(r#"UNIT["foot",0.3048]"#)).unwrap_err().contains("foot"));
        for (name, metres) in [
            ("fathom", "1.8288"),
            ("yard", "0.9144"),
            ("link", "0.201168"),
            ("chain", "20.1168"),
            ("kilometre", "1000"),
            ("degree", "0.0174532925199433"),
        ] {
            // Also where the size of the unit contradicts its name, or is none.
            for size in [metres, "1", "nan", "\"x\""] {
                let text = format!(r#"UNIT["{name}",{size}]"#);
                assert!(checked(&heights(&text)).unwrap_err().contains(name), "{text}");
                assert!(checked(&plan(&text)).unwrap_err().contains(name), "{text}");
            }
        }
    }

    #[test]
    fn the_reference_system_of_a_prj_file_is_written_with_grids_and_geotiffs() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        let grid = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n1 2\n3 4\n";
        std::fs::write(file("a.asc"), grid).unwrap();
        let own = plan(r#"UNIT["Meter",1.0]"#);
        std::fs::write(file("a.prj"), &own).unwrap();
        let raster = crate::read_raster(&file("a.asc")).unwrap();
        assert_eq!((raster.reference.crs.as_deref(), raster.reference.epsg), (Some(own.as_str()), None));
        for name in ["b.asc", "b.tif"] {
            crate::write_raster(&file(name), &raster).unwrap();
            assert_eq!(
                crate::read_raster(&file(name)).unwrap().reference.crs,
                raster.reference.crs,
                "{name}"
            );
        }
        assert_eq!(std::fs::read_to_string(file("b.prj")).unwrap(), own);
        let mut numbered = raster.clone();
        (numbered.reference.crs, numbered.reference.epsg) = (Some("a name".to_owned()), Some(31254));
        crate::write_raster(&file("c.asc"), &numbered).unwrap();
        assert_eq!(crate::read_raster(&file("c.asc")).unwrap().reference.epsg, Some(31254));
        let system = crate::read_reference_system(&file("c.asc")).unwrap();
        assert!(system.differs(&crate::read_reference_system(&file("b.tif")).unwrap()), "{system}");
    }

    #[test]
    fn lengths_in_feet_in_a_gdal_sidecar_file_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.asc");
        std::fs::write(&file, "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n1 2\n3 4\n").unwrap();
        let text = plan(r#"UNIT["Foot_US",0.3048006096012192]"#).replace('"', "&quot;");
        let beside = format!("<PAMDataset><SRS>{text}</SRS></PAMDataset>");
        std::fs::write(folder.path().join("a.asc.aux.xml"), beside).unwrap();
        let problem = crate::read_raster(&file).unwrap_err().problem;
        assert!(problem.contains("Foot_US") && problem.contains("a.asc.aux.xml"), "{problem}");
    }

    #[test]
    fn the_second_version_of_well_known_text_and_the_lines_of_arcinfo_are_read() {
        let second = |unit: &str| {
            format!(
                r#"PROJCRS["UTM",BASEGEOGCRS["WGS 84",DATUM["w",ELLIPSOID["WGS 84",6378137,298.2,LENGTHUNIT["metre",1]]],PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174]]],CONVERSION["UTM zone 32N",METHOD["TM"],PARAMETER["Latitude",0,ANGLEUNIT["degree",0.0174]]],CS[Cartesian,2],AXIS["(E)",east,ORDER[1],{unit}],AXIS["(N)",north,ORDER[2],{unit}]]"#
            )
        };
        assert_eq!(checked(&second(r#"LENGTHUNIT["metre",1]"#)), Ok(()));
        assert!(checked(&second(r#"LENGTHUNIT["US survey foot",0.304800609601219]"#)).is_err());
        assert_eq!(checked("Projection UTM\nZone 32\nUnits METERS\n"), Ok(()));
        assert!(checked("Projection GEOGRAPHIC\nUnits DD\n").unwrap_err().contains("DD"));
        assert_eq!(checked("Projection UTM\nZunits NO\nUnits METERS\n"), Ok(()));
        assert!(checked("Projection UTM\nZunits FEET\nUnits METERS\n").unwrap_err().contains("FEET"));
        assert_eq!(check_metres(Path::new("/nowhere/area.shp")), Ok(()));
    }

    #[test]
    fn epsg_codes_and_proj_strings_are_read_and_other_texts_are_refused() {
        assert_eq!(checked("EPSG:26910"), Ok(()));
        let feet = checked("EPSG:2263").unwrap_err();
        assert!(feet.contains("foot") && feet.contains("area.prj"), "{feet}");
        assert_eq!(checked("+proj=utm +zone=10 +datum=NAD83 +units=m +no_defs"), Ok(()));
        assert!(checked("+proj=utm +zone=10 +datum=NAD83 +units=us-ft").unwrap_err().contains("us-ft"));
        for unit in ["fath", "yd", "link", "ch", "kmi", "in", "cubit"] {
            let text = format!("+proj=utm +zone=10 +datum=NAD83 +units={unit}");
            assert!(checked(&text).unwrap_err().contains(unit), "{text}");
            let text = format!("+proj=utm +zone=10 +datum=NAD83 +units=m +vunits={unit}");
            assert!(checked(&text).unwrap_err().contains(unit), "{text}");
        }
        assert_eq!(checked("+proj=utm +zone=10 +datum=NAD83 +units=m +vunits=m"), Ok(()));
        let heights = checked("+proj=utm +zone=10 +datum=NAD83 +units=m +vto_meter=1.8288");
        assert!(heights.unwrap_err().contains("1.8288"));
        assert!(checked("+proj=longlat +datum=WGS84").unwrap_err().contains("degree"));
        assert!(checked("+proj=merc +lon_0=0 +k=1").unwrap_err().contains("maps of the world"));
        assert!(checked(r#"GEOCCS["WGS 84",UNIT["metre",1]]"#).unwrap_err().contains("geocentric"));
        assert!(
            checked("hello").unwrap_err().contains("has no readable coordinate reference system, \"hello\"")
        );
        assert!(checked("EPSG:1").unwrap_err().contains("EPSG:1, which is not supported"));
        assert_eq!(checked(""), Ok(()));
        let folder = tempfile::tempdir().unwrap();
        let system = |text: &str| {
            std::fs::write(folder.path().join("a.prj"), text).unwrap();
            crate::read_reference_system(&folder.path().join("a.shp")).unwrap()
        };
        let utm = system("EPSG:26910");
        assert!(!system("+proj=utm +zone=10 +datum=NAD83").differs(&utm));
        assert!(system("+proj=utm +zone=11 +datum=NAD83").differs(&utm));
    }

    #[test]
    fn the_horizontal_part_of_a_system_excludes_its_vertical_part() {
        let own = plan(r#"UNIT["Meter",1.0]"#);
        let heights = r#"VERTCS["NAVD88_height",VDATUM["x"],UNIT["Meter",1.0]]"#;
        for text in [own.clone(), format!("{own},{heights}"), format!(r#"COMPD_CS["both",{own},{heights}]"#)]
        {
            assert_eq!(horizontal_part(&text), own);
        }
        assert_eq!(horizontal_part("UTM + heights (ft)"), "UTM");
        assert_eq!((horizontal_part(DEGREES), horizontal_part("PROJCS[\"cut")), (DEGREES, "PROJCS[\"cut"));
    }
}
