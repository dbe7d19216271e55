//! Outlines in plan.

use std::path::Path;

use colluvium_points::Outline;
use geojson::{GeoJson, GeometryValue, Position};
use shapefile::dbase::{self, FieldValue};
use shapefile::{PolygonRing, Shape};

use crate::{BYTE_ORDER, FileError, ending, of, prj, text, unknown};

/// Reads the polygons of a GeoJSON file (`.geojson`, `.json`) or of a shapefile (`.shp`) as one outline: what lies in any of them.
/// Coordinates are metres in the frame of the case; degrees, which GeoJSON has by its standard, are refused, and so are units other
/// than metres that a `.prj` beside a shapefile names.
///
/// # Errors
/// When the file cannot be read, holds no polygon, or one that crosses itself; when it lies in degrees.
pub fn read_outlines(file: &Path) -> Result<Outline, FileError> {
    let rings = features(file, None)?.into_iter().flat_map(|feature| feature.rings).collect();
    outline(file, rings)
}

/// Reads the polygons of a file as [`read_outlines`] does, each feature by itself, with the number that it has under `attribute`: a
/// property of GeoJSON, a field of the `.dbf` beside a shapefile. Features without polygons are passed over.
///
/// # Errors
/// As [`read_outlines`]; when a feature has no such number.
pub fn read_features(file: &Path, attribute: &str) -> Result<Vec<(Outline, f64)>, FileError> {
    let features = features(file, Some(attribute))?.into_iter().enumerate();
    let mut found = Vec::new();
    for (number, feature) in features.filter(|(_, feature)| !feature.rings.is_empty()) {
        let value = feature.number.ok_or_else(|| {
            let problem = format!("feature {} has no number under {attribute:?}", number + 1);
            of(file)(problem)
        })?;
        found.push((outline(file, feature.rings)?, value));
    }
    Ok(found)
}

type Ring = Vec<[f64; 2]>;

/// A feature of a file, and the number that it has under the name that is asked for.
struct Feature {
    rings: Vec<Ring>,
    number: Option<f64>,
}

fn features(file: &Path, attribute: Option<&str>) -> Result<Vec<Feature>, FileError> {
    match ending(file).as_str() {
        "geojson" | "json" => {
            of_geojson(text(file)?.trim_start_matches(BYTE_ORDER), attribute).map_err(of(file))
        }
        "shp" => prj::check(file).and_then(|()| of_shapefile(file, attribute)).map_err(of(file)),
        _ => Err(unknown(file, ".geojson, .json or .shp")),
    }
}

fn outline(file: &Path, rings: Vec<Ring>) -> Result<Outline, FileError> {
    let outline = Outline::new(rings).map_err(of(file))?;
    let (low, high) = outline.bounds();
    // No terrain of a case is this small in metres and lies there; degrees do.
    let like_degrees =
        ending(file) != "shp" && (0..2).all(|c| low[c].abs() <= 180.0 && high[c] - low[c] < 0.5);
    if like_degrees {
        let problem = format!(
            "seems to lie in degrees ({low:?} to {high:?}): project it to metres, for example to UTM"
        );
        return Err(of(file)(problem));
    }
    Ok(outline)
}

fn of_geojson(text: &str, attribute: Option<&str>) -> Result<Vec<Feature>, String> {
    let parsed: GeoJson = text.parse().map_err(|error| format!("is not GeoJSON: {error}"))?;
    let feature = |geometry: Option<geojson::Geometry>, properties: Option<geojson::JsonObject>| {
        let mut rings = Vec::new();
        geometry.iter().try_for_each(|geometry| add(&geometry.value, &mut rings))?;
        let number = attribute.and_then(|name| properties?.get(name)?.as_f64());
        Ok(Feature { rings, number })
    };
    match parsed {
        GeoJson::Geometry(geometry) => Ok(vec![feature(Some(geometry), None)?]),
        GeoJson::Feature(one) => Ok(vec![feature(one.geometry, one.properties)?]),
        GeoJson::FeatureCollection(all) => {
            all.features.into_iter().map(|one| feature(one.geometry, one.properties)).collect()
        }
    }
}

fn add(geometry: &GeometryValue, rings: &mut Vec<Ring>) -> Result<(), String> {
    let place = |position: &Position| match position.as_slice() {
        [x, y, ..] => Ok([*x, *y]),
        short => Err(format!("a position has {} coordinates", short.len())),
    };
    let mut take = |polygon: &Vec<Vec<Position>>| {
        for ring in polygon {
            rings.push(ring.iter().map(place).collect::<Result<_, _>>()?);
        }
        Ok(())
    };
    match geometry {
        GeometryValue::Polygon { coordinates } => take(coordinates),
        GeometryValue::MultiPolygon { coordinates } => coordinates.iter().try_for_each(take),
        GeometryValue::GeometryCollection { geometries } => {
            geometries.iter().try_for_each(|inner| add(&inner.value, rings))
        }
        _ => Ok(()),
    }
}

fn of_shapefile(file: &Path, attribute: Option<&str>) -> Result<Vec<Feature>, String> {
    let wrong = |error: shapefile::Error| format!("is not a shapefile that can be read: {error}");
    let shapes = shapefile::read_shapes(file).map_err(wrong)?;
    // Fields that are missing or cannot be read hold no number.
    let records = attribute.and_then(|_| dbase::read(file.with_extension("dbf")).ok()).unwrap_or_default();
    let mut records = records.iter();
    let feature = |shape| {
        let record = records.next();
        let number = attribute.and_then(|name| number(record?.get(name)?));
        Feature { rings: rings(&shape), number }
    };
    Ok(shapes.into_iter().map(feature).collect())
}

fn number(value: &FieldValue) -> Option<f64> {
    match value {
        FieldValue::Numeric(value) => *value,
        FieldValue::Float(value) => value.map(f64::from),
        FieldValue::Integer(value) => Some(f64::from(*value)),
        FieldValue::Double(value) | FieldValue::Currency(value) => Some(*value),
        _ => None,
    }
}

fn rings(shape: &Shape) -> Vec<Ring> {
    match shape {
        Shape::Polygon(polygon) => points(polygon.rings(), |p| [p.x, p.y]),
        Shape::PolygonZ(polygon) => points(polygon.rings(), |p| [p.x, p.y]),
        Shape::PolygonM(polygon) => points(polygon.rings(), |p| [p.x, p.y]),
        _ => Vec::new(),
    }
}

fn points<P>(rings: &[PolygonRing<P>], place: impl Fn(&P) -> [f64; 2]) -> Vec<Ring> {
    rings.iter().map(|ring| ring.points().iter().map(&place).collect()).collect()
}
