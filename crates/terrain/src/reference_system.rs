//! Coordinate reference systems of files.

use std::fmt;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use geojson::{GeoJson, GeometryValue, JsonObject, JsonValue};

use crate::projection::map_projection::MapProjection;
use crate::raster::geotiff;
use crate::raster_band;
use crate::{extension, read_text};

/// Horizontal coordinate reference system of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CoordinateReferenceSystem {
    epsg: Option<u32>,
    name: Option<String>,
    projection: Option<MapProjection>,
    /// Reason why its lengths differ from those on the ground.
    length_distortion: Option<&'static str>,
    /// Unit of its coordinates, where it is not the metre.
    unit: Option<String>,
}

impl CoordinateReferenceSystem {
    /// Reference system from an EPSG code, a name and a well-known text, as far as a file has them.
    fn new(epsg: Option<u32>, name: Option<String>, text: Option<&str>) -> Self {
        // The code may be that of a compound system, with heights.
        let in_plan = epsg
            .and_then(crate::projection::map_projection::epsg_well_known_text)
            .and_then(crate::projection::prj_file::epsg);
        let epsg = in_plan.or(epsg);
        let registered = epsg.and_then(crate::projection::map_projection::epsg_well_known_text);
        let own = text.and_then(MapProjection::from_well_known_text);
        let name = registered.and_then(crate::projection::prj_file::system_name).or(name);
        let fault = text.or(registered).and_then(crate::projection::map_projection::length_distortion);
        let unit = text.or(registered).and_then(crate::projection::prj_file::non_metre_unit);
        Self {
            epsg,
            name,
            projection: own.or(registered.and_then(MapProjection::from_well_known_text)),
            length_distortion: fault,
            unit,
        }
    }

    /// Reference system of a well-known text.
    fn from_well_known_text(text: &str) -> Self {
        Self::new(
            crate::projection::prj_file::epsg(text),
            crate::projection::prj_file::system_name(text),
            Some(text),
        )
    }

    /// Reads a `crs` member of GeoJSON (2008): by name, or by EPSG code.
    fn from_crs_member(crs: &JsonValue) -> Result<Self, String> {
        let property = |key: &str| crs.get("properties").and_then(|properties| properties.get(key));
        if crs.get("type").and_then(JsonValue::as_str) == Some("link") {
            let place = property("href").map_or_else(String::new, ToString::to_string);
            return Err(format!(
                "has its coordinate reference system as a link, {place}, which is not supported: give its \
                 number, as \"crs\": {{\"type\": \"name\", \"properties\": {{\"name\": \"EPSG:25832\"}}}}"
            ));
        }
        if let Some(name) = crs.as_str().or_else(|| property("name").and_then(JsonValue::as_str)) {
            return Self::from_name(name);
        }
        let code = property("code").map(|code| code.to_string().trim_matches('"').to_owned());
        match code.as_ref().and_then(|code| code.rsplit(':').next()?.parse().ok()) {
            Some(code) => Ok(Self::new(Some(code), None, None)),
            None => Err(format!(
                "has a member crs that is not supported, {crs}: give the number of the system, as \"crs\": \
                 {{\"type\": \"name\", \"properties\": {{\"name\": \"EPSG:25832\"}}}}"
            )),
        }
    }

    /// Reads a name, a well-known text or a PROJ string.
    fn from_name(name: &str) -> Result<Self, String> {
        if crate::projection::well_known_text::is_well_known(name) {
            return Ok(Self::from_well_known_text(name));
        }
        if crate::projection::proj_string::is_proj_string(name) {
            return crate::projection::proj_string::to_well_known_text(name)
                .map(|text| Self::from_well_known_text(&text));
        }
        Ok(Self::new(crate::projection::well_known_text::epsg_code(name), Some(name.to_owned()), None))
    }

    /// Whether two systems are known to differ. Where one has no EPSG code, projections are compared.
    pub fn differs(&self, other: &Self) -> bool {
        if let (Some(a), Some(b)) = (self.epsg, other.epsg) {
            return a != b;
        }
        self.projection.as_ref().zip(other.projection.as_ref()).is_some_and(|(a, b)| a.differs(b))
    }

    /// Whether the known properties of two systems suffice for a comparison.
    pub fn is_comparable(&self, other: &Self) -> bool {
        self.epsg.is_some() && other.epsg.is_some()
            || self.projection.is_some() && other.projection.is_some()
            || self.name.is_some() && self.name == other.name
    }

    /// Reports an error for a system in degrees or in units other than the metre.
    pub(crate) fn check(&self) -> Result<(), String> {
        let in_degrees =
            self.name.as_deref().is_some_and(|name| name.ends_with("CRS84") || name.ends_with("CRS83"));
        if let Some(fault) = self.length_distortion {
            return Err(format!("by its coordinate reference system it {fault}"));
        }
        let other = self.unit.clone().or(in_degrees.then(|| "degree".to_owned()));
        match other {
            None => Ok(()),
            Some(unit) if unit.to_lowercase().contains("deg") => {
                Err(format!("is in degrees ({self}): project it to metres, for example to UTM"))
            }
            Some(unit) => {
                Err(format!("is in {unit:?} ({self}), but only metres are supported: project it to metres"))
            }
        }
    }
}

impl fmt::Display for CoordinateReferenceSystem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.epsg, self.name.as_deref()) {
            (Some(code), Some(name)) if !name.contains(&code.to_string()) => {
                write!(out, "EPSG:{code}, {name}")
            }
            (Some(code), _) => write!(out, "EPSG:{code}"),
            (None, Some(name)) => write!(out, "{name}"),
            (None, None) => write!(out, "not named"),
        }
    }
}

/// Coordinate reference system that a raster or outline file names; `None` where it names none, or cannot be read.
pub fn read_reference_system(file: &Path) -> Option<CoordinateReferenceSystem> {
    match extension(file).as_str() {
        "tif" | "tiff" => {
            if let Some(text) = raster_band::sidecar_band(file).ok()?.crs {
                return crate::projection::well_known_text::is_well_known(&text)
                    .then(|| CoordinateReferenceSystem::from_well_known_text(&text));
            }
            let (epsg, name) = geotiff::read_reference_system(BufReader::new(File::open(file).ok()?)).ok()?;
            if epsg.is_none() && name.is_none() {
                return sidecar_system(file);
            }
            let text = name.clone().filter(|text| crate::projection::well_known_text::is_well_known(text));
            let name = text.as_deref().map_or(name, crate::projection::prj_file::system_name);
            Some(CoordinateReferenceSystem::new(epsg, name, text.as_deref()))
        }
        "geojson" | "json" => geojson_system(&read_text(file).ok()?.parse().ok()?).ok()?,
        "asc" | "grd" | "txt" | "shp" => sidecar_system(file),
        _ => None,
    }
}

/// Coordinate reference system of the `.prj` beside a file, or of the `.aux.xml` of GDAL.
fn sidecar_system(file: &Path) -> Option<CoordinateReferenceSystem> {
    let of_gdal = || raster_band::sidecar_band(file).ok()?.crs;
    let text = crate::projection::prj_file::read_text(file).ok()?.or_else(of_gdal)?;
    crate::projection::well_known_text::is_well_known(&text)
        .then(|| CoordinateReferenceSystem::from_well_known_text(&text))
}

/// Coordinate reference system of the `crs` members of a GeoJSON file (not in degrees), its features and their geometries.
///
/// # Errors
/// When a member names a system in an unsupported way, or members name several systems.
pub(crate) fn geojson_system(parsed: &GeoJson) -> Result<Option<CoordinateReferenceSystem>, String> {
    let mut found: Option<CoordinateReferenceSystem> = None;
    let mut take = |members: Option<&JsonObject>| {
        let Some(crs) = members.and_then(|members| members.get("crs")).filter(|crs| !crs.is_null()) else {
            return Ok(());
        };
        let system = CoordinateReferenceSystem::from_crs_member(crs)?;
        if let Some(other) = found.as_ref().filter(|found| **found != system) {
            return Err(format!(
                "has several coordinate reference systems, {other} and {system}: write it in one"
            ));
        }
        found = Some(system);
        Ok(())
    };
    match parsed {
        GeoJson::Geometry(geometry) => each_geometry(geometry, &mut take)?,
        GeoJson::Feature(feature) => each_feature(feature, &mut take)?,
        GeoJson::FeatureCollection(all) => {
            take(all.foreign_members.as_ref())?;
            all.features.iter().try_for_each(|feature| each_feature(feature, &mut take))?;
        }
    }
    Ok(found)
}

/// Function that is called with the foreign members of each GeoJSON object.
type CrsVisitor<'a> = dyn FnMut(Option<&JsonObject>) -> Result<(), String> + 'a;

/// Calls `take` for a GeoJSON feature and its geometry.
fn each_feature(feature: &geojson::Feature, take: &mut CrsVisitor<'_>) -> Result<(), String> {
    take(feature.foreign_members.as_ref())?;
    feature.geometry.iter().try_for_each(|geometry| each_geometry(geometry, take))
}

/// Calls `take` for a GeoJSON geometry and the geometries in it.
fn each_geometry(geometry: &geojson::Geometry, take: &mut CrsVisitor<'_>) -> Result<(), String> {
    take(geometry.foreign_members.as_ref())?;
    match &geometry.value {
        GeometryValue::GeometryCollection { geometries } => {
            geometries.iter().try_for_each(|inner| each_geometry(inner, take))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(folder: &Path, name: &str, text: &str) -> std::path::PathBuf {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    #[test]
    fn systems_differ_by_their_numbers_or_their_projections() {
        let folder = tempfile::tempdir().unwrap();
        let json = |code: &str| {
            let text = format!(
                r#"{{"type": "FeatureCollection", "crs": {{"type": "name", "properties": {{"name": "{code}"}}}}, "features": []}}"#
            );
            read_reference_system(&file(folder.path(), "a.geojson", &text)).unwrap()
        };
        let esri = |meridian: f64| {
            let text = format!(
                r#"PROJCS["ETRS_1989_UTM",GEOGCS["x",DATUM["x",SPHEROID["x",6378137.0,298.25]],PRIMEM["x",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",{meridian:.1}],UNIT["Meter",1.0]]"#
            );
            file(folder.path(), "b.prj", &text);
            read_reference_system(&folder.path().join("b.shp")).unwrap()
        };
        let utm = json("urn:ogc:def:crs:EPSG::25832");
        assert!(utm.differs(&json("EPSG:31254")) && !utm.differs(&json("EPSG:25832")));
        assert!(
            !utm.differs(&esri(9.0)) && utm.differs(&esri(15.0)) && json("EPSG:31254").differs(&esri(9.0))
        );
        assert!(json("EPSG:2056").differs(&esri(9.0)), "an oblique projection is none of UTM");
        assert_eq!(utm.to_string(), "EPSG:25832, ETRS89 / UTM zone 32N");
        assert_eq!(esri(9.0).to_string(), "ETRS_1989_UTM");
        assert!(json("urn:ogc:def:crs:OGC:1.3:CRS84").check().unwrap_err().contains("degrees"));
        assert!(json("EPSG:4326").check().is_err() && utm.check().is_ok());
        let feet = json("urn:ogc:def:crs:EPSG::2225").check().unwrap_err();
        assert!(feet.contains("survey foot") && feet.contains("EPSG:2225"), "{feet}");
        let of_web = json("http://www.opengis.net/def/crs/EPSG/0/25833");
        assert!(of_web.differs(&utm) && !json("EPSG:5555").differs(&utm), "heights beside a system in plan");
        // A compound system, with heights.
        let both = json("urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::5783");
        assert!(both.check().is_ok() && !both.differs(&utm), "{both}");
        assert!(!json("EPSG:25832+5783").differs(&utm) && json("EPSG:31254+5783").differs(&utm));
        assert!(json("EPSG:3857").check().unwrap_err().contains("Web Mercator"));
        assert!(!json("ESRI:102100").is_comparable(&utm));
        let own = CoordinateReferenceSystem::from_well_known_text(r#"LOCAL_CS["site grid",UNIT["metre",1]]"#);
        assert!(!own.is_comparable(&utm) && own.is_comparable(&own) && esri(9.0).is_comparable(&utm));
        assert_eq!(
            read_reference_system(&file(
                folder.path(),
                "c.geojson",
                r#"{"type": "Point", "coordinates": [0, 0]}"#
            )),
            None
        );
        assert_eq!(read_reference_system(&folder.path().join("none.tif")), None);
    }

    #[test]
    fn numbers_and_parameters_of_well_known_texts_are_those_of_the_projected_system() {
        let first = r#"COMPD_CS["a + b",PROJCS["MGI / Austria GK West",GEOGCS["MGI",DATUM["x",SPHEROID["x",6377397,299.15,AUTHORITY["EPSG","7004"]]],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4312"]],PROJECTION["Transverse_Mercator"],PARAMETER["central_meridian",10.3333333333333],PARAMETER["false_easting",0],PARAMETER["false_northing",-5000000],UNIT["metre",1],AUTHORITY["EPSG","31254"]],VERT_CS["b",AUTHORITY["EPSG","5778"]]]"#;
        let second = r#"PROJCRS["WGS 84 / UTM zone 33N",BASEGEOGCRS["WGS 84",ID["EPSG",4326]],CONVERSION["UTM zone 33N",METHOD["Transverse Mercator",ID["EPSG",9807]],PARAMETER["Longitude of natural origin",15,ANGLEUNIT["degree",0.0174532925199433]],PARAMETER["False easting",500000],PARAMETER["False northing",0]],CS[Cartesian,2],ID["EPSG",32633]]"#;
        for (text, code) in [(first, 31254), (second, 32633)] {
            let system = CoordinateReferenceSystem::from_well_known_text(text);
            assert_eq!(system.epsg, Some(code));
            let registered = crate::projection::map_projection::epsg_well_known_text(code)
                .and_then(MapProjection::from_well_known_text)
                .unwrap();
            assert!(!system.projection.unwrap().differs(&registered), "{code}");
        }
    }

    #[test]
    fn geojson_reference_systems_are_read_at_any_level_and_links_are_refused() {
        let of = |text: &str| geojson_system(&text.parse().unwrap());
        let named = r#""crs": {"type": "name", "properties": {"name": "EPSG:31254"}}"#;
        let ring = r#""coordinates": [[[0, 0], [9, 0], [9, 9], [0, 0]]]"#;
        let geometry = |crs: &str| format!(r#"{{"type": "Polygon", {ring}{crs}}}"#);
        let feature = |crs: &str, inner: &str| {
            format!(r#"{{"type": "Feature", "properties": {{}}, "geometry": {}{crs}}}"#, geometry(inner))
        };
        let file = |crs: &str, own: &str, inner: &str| {
            format!(r#"{{"type": "FeatureCollection", "features": [{}]{crs}}}"#, feature(own, inner))
        };
        let (one, none) = (format!(", {named}"), "");
        let texts = [
            geometry(&one),
            feature(&one, none),
            feature(none, &one),
            file(&one, none, none),
            file(none, &one, &one),
            file(none, none, &one),
            format!(r#"{{"type": "GeometryCollection", "geometries": [{}]}}"#, geometry(&one)),
            file(r#", "crs": {"type": "EPSG", "properties": {"code": 31254}}"#, none, none),
            file(r#", "crs": {"type": "EPSG", "properties": {"code": "31254"}}"#, none, none),
        ];
        for text in texts {
            assert_eq!(of(&text).unwrap().unwrap().epsg, Some(31254), "{text}");
        }
        assert_eq!(of(&file(r#", "crs": null"#, none, none)), Ok(None));
        let other = one.replace("31254", "25832");
        assert!(of(&file(&one, none, &other)).unwrap_err().contains("several"));
        let link = r#", "crs": {"type": "link", "properties": {"href": "x.prj", "type": "esriwkt"}}"#;
        assert!(of(&file(link, none, none)).unwrap_err().contains("as a link, \"x.prj\""));
        assert!(of(&file(r#", "crs": {"type": "own"}"#, none, none)).unwrap_err().contains("not supported"));
        let feet = r#", "crs": {"type": "name", "properties": {"name": "+proj=utm +zone=10 +units=us-ft"}}"#;
        let feet = of(&file(feet, none, none)).unwrap().unwrap();
        assert!(feet.check().unwrap_err().contains("us-ft"));
    }
}
