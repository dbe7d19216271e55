//! Coordinate reference systems by what files say of them.

use std::fmt;
use std::path::Path;

use geojson::{GeoJson, JsonObject};

use crate::{ending, geotiff, prj, read_text};

/// Coordinate reference system in plan of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapSystem {
    epsg: Option<u32>,
    name: Option<String>,
    projection: Option<Projection>,
}

/// Transverse Mercator projection.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Projection {
    /// Central meridian (°).
    meridian: f64,
    /// Coordinates of its crossing with the latitude of origin (m).
    origin: [f64; 2],
}

/// Difference of central meridians (°) and of origins (m) that is round-off.
const SAME: [f64; 2] = [1e-6, 0.01];

/// Geographic systems of the EPSG registry that maps come in, in degrees: those of the world, of Europe, and of countries.
const IN_DEGREES: [u32; 16] =
    [4326, 4979, 4258, 4937, 4269, 4267, 4171, 4230, 4312, 4314, 4149, 4150, 4277, 4283, 7844, 4148];

impl MapSystem {
    fn new(epsg: Option<u32>, name: Option<String>, text: Option<&str>) -> Self {
        let projection = text.and_then(Projection::of_text).or(epsg.and_then(Projection::of_epsg));
        Self { epsg, name, projection }
    }

    fn of_well_known_text(text: &str) -> Self {
        let name = text.split('"').nth(1).filter(|_| text.contains(['[', '('])).map(str::to_owned);
        Self::new(prj::epsg(text), name, Some(text))
    }

    /// Whether two systems are known to differ. Where one has a number in the EPSG registry and the other has none, and where no
    /// projection is known, it is not.
    pub fn differs(&self, other: &Self) -> bool {
        if let (Some(a), Some(b)) = (self.epsg, other.epsg) {
            return a != b;
        }
        let (Some(a), Some(b)) = (self.projection, other.projection) else { return false };
        (a.meridian - b.meridian).abs() > SAME[0]
            || (0..2).any(|c| (a.origin[c] - b.origin[c]).abs() > SAME[1])
    }

    /// What is wrong with a system in degrees.
    pub(crate) fn check(&self) -> Result<(), String> {
        let geographic = self.epsg.is_some_and(|code| IN_DEGREES.contains(&code))
            || self.name.as_deref().is_some_and(|name| name.ends_with("CRS84") || name.ends_with("CRS83"));
        if geographic {
            return Err(format!(
                "says that it lies in degrees ({self}): project it to metres, for example to UTM"
            ));
        }
        Ok(())
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

impl Projection {
    fn of_epsg(code: u32) -> Option<Self> {
        let zone = |zone: u32, north: f64| Self {
            meridian: f64::from(zone) * 6.0 - 183.0,
            origin: [500_000.0, north],
        };
        let gauss = |meridian: f64, east: f64| Self { meridian, origin: [east, -5e6] };
        Some(match code {
            32601..=32660 | 25828..=25838 | 23028..=23038 | 26901..=26923 | 26701..=26722 => {
                zone(code % 100, 0.0)
            }
            32701..=32760 => zone(code % 100, 1e7),
            28348..=28358 => zone(code - 28300, 1e7),
            7846..=7859 => zone(code - 7800, 1e7),
            31254..=31256 => gauss(31.0 / 3.0 + 3.0 * f64::from(code - 31254), 0.0),
            31257 => gauss(31.0 / 3.0, 150_000.0),
            31258 => gauss(40.0 / 3.0, 450_000.0),
            31259 => gauss(49.0 / 3.0, 750_000.0),
            31466..=31469 => {
                let zone = f64::from(code - 31464);
                Self { meridian: 3.0 * zone, origin: [1e6 * zone + 500_000.0, 0.0] }
            }
            _ => return None,
        })
    }

    /// The parameters of a well-known text, where it has them.
    fn of_text(text: &str) -> Option<Self> {
        let plain = text.to_lowercase().replace(' ', "_");
        if !plain.contains("transverse_mercator") {
            return None;
        }
        let parameter = |names: [&str; 2]| {
            let at =
                names.iter().find_map(|name| Some(plain.find(&format!("\"{name}\""))? + name.len() + 2))?;
            plain[at..]
                .trim_start_matches(['_', ','])
                .split([',', ']', ')'])
                .next()?
                .trim_matches('_')
                .parse()
                .ok()
        };
        Some(Self {
            meridian: parameter(["central_meridian", "longitude_of_natural_origin"])?,
            origin: [
                parameter(["false_easting", "false_easting"])?,
                parameter(["false_northing", "false_northing"])?,
            ],
        })
    }
}

/// Coordinate reference system that a raster or an outline says it lies in; `None` where it says nothing, or cannot be read.
pub fn read_system(file: &Path) -> Option<MapSystem> {
    match ending(file).as_str() {
        "tif" | "tiff" => {
            let (epsg, name) = geotiff::system(&std::fs::read(file).ok()?).ok()?;
            let text = name.clone();
            (epsg.is_some() || name.is_some()).then(|| MapSystem::new(epsg, name, text.as_deref()))
        }
        "geojson" | "json" => of_geojson(&read_text(file).ok()?.parse().ok()?),
        "asc" | "grd" | "txt" | "shp" => {
            let text = prj::text(file).ok()??;
            Some(MapSystem::of_well_known_text(&text))
        }
        _ => None,
    }
}

/// The system of the member `crs`, which files have that are not in degrees.
pub(crate) fn of_geojson(parsed: &GeoJson) -> Option<MapSystem> {
    let members: &JsonObject = match parsed {
        GeoJson::Geometry(geometry) => geometry.foreign_members.as_ref(),
        GeoJson::Feature(feature) => feature.foreign_members.as_ref(),
        GeoJson::FeatureCollection(all) => all.foreign_members.as_ref(),
    }?;
    let name = members.get("crs")?.get("properties")?.get("name")?.as_str()?;
    let number =
        name.to_uppercase().contains("EPSG").then(|| name.rsplit(':').next()?.parse().ok()).flatten();
    Some(MapSystem::new(number, Some(name.to_owned()), None))
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
                r#"PROJCS["ETRS_1989_UTM",GEOGCS["x",DATUM["x",SPHEROID["x",6378137.0,298.25]],PRIMEM["x",0.0],UNIT["Degree",0.017]],PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",{meridian:.1}],UNIT["Meter",1.0]]"#
            );
            file(folder.path(), "b.prj", &text);
            read_system(&folder.path().join("b.shp")).unwrap()
        };
        let utm = json("urn:ogc:def:crs:EPSG::25832");
        assert!(utm.differs(&json("EPSG:31254")) && !utm.differs(&json("EPSG:25832")));
        assert!(
            !utm.differs(&esri(9.0)) && utm.differs(&esri(15.0)) && json("EPSG:31254").differs(&esri(9.0))
        );
        assert!(!json("EPSG:2056").differs(&esri(9.0)), "an oblique projection is not known");
        assert_eq!(utm.to_string(), "EPSG:25832");
        assert_eq!(esri(9.0).to_string(), "ETRS_1989_UTM");
        assert!(json("urn:ogc:def:crs:OGC:1.3:CRS84").check().unwrap_err().contains("degrees"));
        assert!(json("EPSG:4326").check().is_err() && utm.check().is_ok());
        assert_eq!(
            read_system(&file(folder.path(), "c.geojson", r#"{"type": "Point", "coordinates": [0, 0]}"#)),
            None
        );
        assert_eq!(read_system(&folder.path().join("none.tif")), None);
    }

    #[test]
    fn numbers_and_parameters_of_well_known_texts_are_those_of_the_projected_system() {
        let first = r#"COMPD_CS["a + b",PROJCS["MGI / Austria GK West",GEOGCS["MGI",DATUM["x",SPHEROID["x",6377397,299.15,AUTHORITY["EPSG","7004"]]],UNIT["degree",0.01,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4312"]],PROJECTION["Transverse_Mercator"],PARAMETER["central_meridian",10.3333333333333],PARAMETER["false_easting",0],PARAMETER["false_northing",-5000000],UNIT["metre",1],AUTHORITY["EPSG","31254"]],VERT_CS["b",AUTHORITY["EPSG","5778"]]]"#;
        let second = r#"PROJCRS["WGS 84 / UTM zone 33N",BASEGEOGCRS["WGS 84",ID["EPSG",4326]],CONVERSION["UTM zone 33N",METHOD["Transverse Mercator",ID["EPSG",9807]],PARAMETER["Longitude of natural origin",15,ANGLEUNIT["degree",0.01]],PARAMETER["False easting",500000],PARAMETER["False northing",0]],CS[Cartesian,2],ID["EPSG",32633]]"#;
        for (text, code) in [(first, 31254), (second, 32633)] {
            let system = MapSystem::of_well_known_text(text);
            assert_eq!(system.epsg, Some(code));
            let (said, known) = (system.projection.unwrap(), Projection::of_epsg(code).unwrap());
            assert!(
                (said.meridian - known.meridian).abs() < 1e-9 && said.origin == known.origin,
                "{said:?} {known:?}"
            );
        }
    }
}
