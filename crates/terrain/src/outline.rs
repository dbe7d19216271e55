//! Outlines in plan.

use std::path::Path;

use colluvium_points::Outline;
use geojson::{GeoJson, GeometryValue, Position};
use shapefile::{PolygonRing, Shape};

use crate::{BYTE_ORDER, FileError, ending, of, prj, text, unknown};

/// Reads the polygons of a GeoJSON file (`.geojson`, `.json`) or of a shapefile (`.shp`) as one outline: what lies in any of them.
/// Coordinates are metres in the frame of the case; degrees, which GeoJSON has by its standard, are refused, and so are units other
/// than metres that a `.prj` beside a shapefile names.
///
/// # Errors
/// When the file cannot be read, holds no polygon, or one that crosses itself; when it lies in degrees.
pub fn read_outlines(file: &Path) -> Result<Outline, FileError> {
    let rings = match ending(file).as_str() {
        "geojson" | "json" => geojson_rings(text(file)?.trim_start_matches(BYTE_ORDER)),
        "shp" => prj::check(file).and_then(|()| shapefile_rings(file)),
        _ => return Err(unknown(file, ".geojson, .json or .shp")),
    };
    let outline = Outline::new(rings.map_err(of(file))?).map_err(of(file))?;
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

fn geojson_rings(text: &str) -> Result<Vec<Vec<[f64; 2]>>, String> {
    let parsed: GeoJson = text.parse().map_err(|error| format!("is not GeoJSON: {error}"))?;
    let mut rings = Vec::new();
    match &parsed {
        GeoJson::Geometry(geometry) => add(&geometry.value, &mut rings)?,
        GeoJson::Feature(feature) => {
            feature.geometry.iter().try_for_each(|geometry| add(&geometry.value, &mut rings))?;
        }
        GeoJson::FeatureCollection(all) => {
            let geometries = all.features.iter().filter_map(|feature| feature.geometry.as_ref());
            geometries.into_iter().try_for_each(|geometry| add(&geometry.value, &mut rings))?;
        }
    }
    Ok(rings)
}

fn add(geometry: &GeometryValue, rings: &mut Vec<Vec<[f64; 2]>>) -> Result<(), String> {
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

fn shapefile_rings(file: &Path) -> Result<Vec<Vec<[f64; 2]>>, String> {
    let shapes = shapefile::read_shapes(file)
        .map_err(|error| format!("is not a shapefile that can be read: {error}"))?;
    let mut rings = Vec::new();
    for shape in shapes {
        match shape {
            Shape::Polygon(polygon) => {
                rings.extend(polygon.rings().iter().map(|ring| points(ring, |p| [p.x, p.y])));
            }
            Shape::PolygonZ(polygon) => {
                rings.extend(polygon.rings().iter().map(|ring| points(ring, |p| [p.x, p.y])));
            }
            Shape::PolygonM(polygon) => {
                rings.extend(polygon.rings().iter().map(|ring| points(ring, |p| [p.x, p.y])));
            }
            _ => {}
        }
    }
    Ok(rings)
}

fn points<P>(ring: &PolygonRing<P>, place: impl Fn(&P) -> [f64; 2]) -> Vec<[f64; 2]> {
    ring.points().iter().map(place).collect()
}
