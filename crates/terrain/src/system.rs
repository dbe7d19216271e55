//! Coordinate reference systems by what files say of them.

use std::fmt;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use geojson::{GeoJson, JsonObject};

use crate::projection::{self, Projection};
use crate::{band, ending, geotiff, prj, read_text};

/// Coordinate reference system in plan of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapSystem {
    epsg: Option<u32>,
    name: Option<String>,
    projection: Option<Projection>,
    /// Why its lengths are not those on the ground.
    fault: Option<&'static str>,
}

impl MapSystem {
    fn new(epsg: Option<u32>, name: Option<String>, text: Option<&str>) -> Self {
        // A number may be that of a system in plan with one of heights.
        let in_plan = epsg.and_then(projection::text_of).and_then(prj::epsg);
        let epsg = in_plan.or(epsg);
        let registered = epsg.and_then(projection::text_of);
        let own = text.and_then(Projection::of_text);
        let name = registered.and_then(prj::name_of).or(name);
        let fault = text.and_then(projection::unlike_the_ground);
        Self { epsg, name, projection: own.or(registered.and_then(Projection::of_text)), fault }
    }

    fn of_well_known_text(text: &str) -> Self {
        Self::new(prj::epsg(text), prj::name_of(text), Some(text))
    }

    /// Whether two systems are known to differ. Where one has no number in the EPSG registry, projections are compared.
    pub fn differs(&self, other: &Self) -> bool {
        if let (Some(a), Some(b)) = (self.epsg, other.epsg) {
            return a != b;
        }
        self.projection.as_ref().zip(other.projection.as_ref()).is_some_and(|(a, b)| a.differs(b))
    }

    /// Whether what is known of two systems is enough to tell whether they differ.
    pub fn is_comparable(&self, other: &Self) -> bool {
        self.epsg.is_some() && other.epsg.is_some()
            || self.projection.is_some() && other.projection.is_some()
            || self.name.is_some() && self.name == other.name
    }

    /// Refuses a system in degrees or in units other than the metre.
    pub(crate) fn check(&self) -> Result<(), String> {
        let in_degrees =
            self.name.as_deref().is_some_and(|name| name.ends_with("CRS84") || name.ends_with("CRS83"));
        let text = self.epsg.and_then(projection::text_of);
        if let Some(fault) = self.fault.or(text.and_then(projection::unlike_the_ground)) {
            return Err(format!("says that it {fault}"));
        }
        let other = text.and_then(prj::other_unit).or(in_degrees.then(|| "degree".to_owned()));
        match other {
            None => Ok(()),
            Some(unit) if unit.to_lowercase().contains("deg") => Err(format!(
                "says that it lies in degrees ({self}): project it to metres, for example to UTM"
            )),
            Some(unit) => Err(format!(
                "says that it lies in {unit:?} ({self}), and only metres are known: project it to metres"
            )),
        }
    }
}

impl fmt::Display for MapSystem {
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

/// Coordinate reference system that a raster or an outline says it lies in; `None` where it says nothing, or cannot be read.
pub fn read_system(file: &Path) -> Option<MapSystem> {
    match ending(file).as_str() {
        "tif" | "tiff" => {
            if let Some(text) = band::beside(file).ok()?.crs {
                return prj::is_well_known(&text).then(|| MapSystem::of_well_known_text(&text));
            }
            let (epsg, name) = geotiff::system(BufReader::new(File::open(file).ok()?)).ok()?;
            if epsg.is_none() && name.is_none() {
                return of_text_beside(file);
            }
            let text = name.clone().filter(|text| prj::is_well_known(text));
            let name = text.as_deref().map_or(name, prj::name_of);
            Some(MapSystem::new(epsg, name, text.as_deref()))
        }
        "geojson" | "json" => of_geojson(&read_text(file).ok()?.parse().ok()?),
        "asc" | "grd" | "txt" | "shp" => of_text_beside(file),
        _ => None,
    }
}

/// The system of the `.prj` beside a file, or of the `.aux.xml` of GDAL.
fn of_text_beside(file: &Path) -> Option<MapSystem> {
    let of_gdal = || band::beside(file).ok()?.crs;
    let text = prj::text(file).ok()?.or_else(of_gdal)?;
    prj::is_well_known(&text).then(|| MapSystem::of_well_known_text(&text))
}

/// The system of the member `crs`, which files have that are not in degrees.
pub(crate) fn of_geojson(parsed: &GeoJson) -> Option<MapSystem> {
    let members: &JsonObject = match parsed {
        GeoJson::Geometry(geometry) => geometry.foreign_members.as_ref(),
        GeoJson::Feature(feature) => feature.foreign_members.as_ref(),
        GeoJson::FeatureCollection(all) => all.foreign_members.as_ref(),
    }?;
    let name = members.get("crs")?.get("properties")?.get("name")?.as_str()?;
    if prj::is_well_known(name) {
        return Some(MapSystem::of_well_known_text(name));
    }
    // `EPSG:25832`, `urn:ogc:def:crs:EPSG::25832` or `http://www.opengis.net/def/crs/EPSG/0/25832`.
    let number =
        name.to_uppercase().contains("EPSG").then(|| name.rsplit([':', '/', '#']).next()?.parse().ok());
    Some(MapSystem::new(number.flatten(), Some(name.to_owned()), None))
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
            read_system(&file(folder.path(), "a.geojson", &text)).unwrap()
        };
        let esri = |meridian: f64| {
            let text = format!(
                r#"PROJCS["ETRS_1989_UTM",GEOGCS["x",DATUM["x",SPHEROID["x",6378137.0,298.25]],PRIMEM["x",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",{meridian:.1}],UNIT["Meter",1.0]]"#
            );
            file(folder.path(), "b.prj", &text);
            read_system(&folder.path().join("b.shp")).unwrap()
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
        assert!(json("EPSG:3857").check().unwrap_err().contains("Web Mercator"));
        assert!(!json("ESRI:102100").is_comparable(&utm));
        let own = MapSystem::of_well_known_text(r#"LOCAL_CS["site grid",UNIT["metre",1]]"#);
        assert!(!own.is_comparable(&utm) && own.is_comparable(&own) && esri(9.0).is_comparable(&utm));
        assert_eq!(
            read_system(&file(folder.path(), "c.geojson", r#"{"type": "Point", "coordinates": [0, 0]}"#)),
            None
        );
        assert_eq!(read_system(&folder.path().join("none.tif")), None);
    }

    #[test]
    fn numbers_and_parameters_of_well_known_texts_are_those_of_the_projected_system() {
        let first = r#"COMPD_CS["a + b",PROJCS["MGI / Austria GK West",GEOGCS["MGI",DATUM["x",SPHEROID["x",6377397,299.15,AUTHORITY["EPSG","7004"]]],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4312"]],PROJECTION["Transverse_Mercator"],PARAMETER["central_meridian",10.3333333333333],PARAMETER["false_easting",0],PARAMETER["false_northing",-5000000],UNIT["metre",1],AUTHORITY["EPSG","31254"]],VERT_CS["b",AUTHORITY["EPSG","5778"]]]"#;
        let second = r#"PROJCRS["WGS 84 / UTM zone 33N",BASEGEOGCRS["WGS 84",ID["EPSG",4326]],CONVERSION["UTM zone 33N",METHOD["Transverse Mercator",ID["EPSG",9807]],PARAMETER["Longitude of natural origin",15,ANGLEUNIT["degree",0.0174532925199433]],PARAMETER["False easting",500000],PARAMETER["False northing",0]],CS[Cartesian,2],ID["EPSG",32633]]"#;
        for (text, code) in [(first, 31254), (second, 32633)] {
            let system = MapSystem::of_well_known_text(text);
            assert_eq!(system.epsg, Some(code));
            let registered = projection::text_of(code).and_then(Projection::of_text).unwrap();
            assert!(!system.projection.unwrap().differs(&registered), "{code}");
        }
    }
}
