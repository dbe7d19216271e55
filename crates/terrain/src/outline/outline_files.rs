//! Readers of outlines in plan.

use std::path::{Path, PathBuf};

use colluvium_points::{Outline, OutlineFeature, Polygon, Ring};
use geojson::{GeoJson, GeometryValue, Position};
use shapefile::dbase::{self, FieldValue};
use shapefile::{PolygonRing, Shape};

use crate::projection::prj_file;
use crate::reference_system;
use crate::{FileError, Problem, error_in_file, extension, read_text, unknown_format};

/// Reads the polygons of a GeoJSON file (`.geojson`, `.json`) or of a shapefile (`.shp`) as one outline, the union of the polygons.
/// Features without geometry are ignored, as are those whose row in the table of a shapefile is marked as deleted. Coordinates are metres
/// in the frame of the case. Degrees, the standard of GeoJSON, are rejected, and so are units other than metres in a `.prj` beside a
/// shapefile.
///
/// # Errors
/// When the file cannot be read, has no polygon, a feature of another kind, or a self-crossing ring; when it is in degrees.
pub fn read_outlines(file: &Path) -> Result<Outline, FileError> {
    let polygons = features(file, None)?.into_iter().flat_map(|feature| feature.polygons).collect();
    outline(file, polygons)
}

/// Reads the polygons of each feature of a file, as [`read_outlines`] does, with the number under `attribute` as its thickness (m). Without
/// an exact match of the name, a single match without regard to case counts. Features without polygons are skipped.
///
/// # Errors
/// See [`read_outlines`]; when a feature has no such number.
pub fn read_features(file: &Path, attribute: &str) -> Result<Vec<OutlineFeature>, FileError> {
    let features = features(file, Some(attribute))?.into_iter().enumerate();
    let mut found = Vec::new();
    for (number, feature) in features.filter(|(_, feature)| !feature.polygons.is_empty()) {
        let number = number + 1;
        let thickness = feature.number.map_err(|why| {
            error_in_file(file)(format!(
                "feature {number} has no number in the attribute {attribute:?}: {why}"
            ))
        })?;
        found.push(OutlineFeature { number, outline: outline(file, feature.polygons)?, thickness });
    }
    Ok(found)
}

/// Polygons of a feature with the number under the requested attribute, or the reason why it has none.
struct FeaturePolygons {
    polygons: Vec<Polygon>,
    number: Result<f64, String>,
}

/// Reason why a feature with these attribute names has no number.
fn missing_attribute<'n>(names: impl Iterator<Item = &'n String>) -> String {
    let mut names: Vec<&str> = names.map(String::as_str).take(20).collect();
    names.sort_unstable();
    if names.is_empty() {
        "it has no attributes".to_owned()
    } else {
        format!("its attributes are {}", names.join(", "))
    }
}

/// Polygons of each feature of a GeoJSON file or shapefile, with the number that the attribute gives it.
fn features(file: &Path, attribute: Option<&str>) -> Result<Vec<FeaturePolygons>, FileError> {
    match extension(file).as_str() {
        "geojson" | "json" => geojson_features(&read_text(file)?, attribute).map_err(error_in_file(file)),
        "shp" => prj_file::check_metres(file)
            .map_err(Problem::coded("crs-not-metres"))
            .and_then(|()| Ok(shapefile_features(file, attribute)?))
            .map_err(error_in_file(file)),
        _ => Err(unknown_format(file, ".geojson, .json or .shp")),
    }
}

/// Outline of polygons of a file; an error where their coordinates seem to be degrees.
fn outline(file: &Path, polygons: Vec<Polygon>) -> Result<Outline, FileError> {
    let outline =
        Outline::new(polygons).map_err(Problem::coded("invalid-surface")).map_err(error_in_file(file))?;
    let (low, high) = outline.bounds();
    // Terrain in metres is never this small and this close to the origin; coordinates in degrees are.
    let like_degrees =
        extension(file) != "shp" && (0..2).all(|c| low[c].abs() <= 180.0 && high[c] - low[c] < 0.5);
    if like_degrees {
        let problem =
            format!("seems to be in degrees ({low:?} to {high:?}): project it to metres, for example to UTM");
        return Err(error_in_file(file)(Problem::coded("crs-not-metres")(problem)));
    }
    Ok(outline)
}

/// Value under a name, or under the only name that equals it apart from upper and lower case.
fn find_attribute<'a, T>(all: impl Iterator<Item = (&'a String, T)> + Clone, name: &str) -> Option<T> {
    let exact = all.clone().find(|(own, _)| *own == name);
    let mut alike = all.filter(|(own, _)| own.to_lowercase() == name.to_lowercase());
    let only = alike.next().filter(|_| alike.next().is_none());
    exact.or(only).map(|(_, value)| value)
}

/// Error text for a feature that is not a polygon.
fn not_a_polygon(kind: &str) -> String {
    format!("is a {kind}, but only polygons are supported: remove it from the file, or draw it as a polygon")
}

/// Polygons of each feature of a GeoJSON text.
fn geojson_features(text: &str, attribute: Option<&str>) -> Result<Vec<FeaturePolygons>, Problem> {
    let parsed: GeoJson = text.parse().map_err(|error| format!("is not GeoJSON: {error}"))?;
    reference_system::geojson_system(&parsed)?
        .map_or(Ok(()), |system| system.check())
        .map_err(Problem::coded("crs-not-metres"))?;
    let feature =
        |(index, geometry, properties): (usize, Option<geojson::Geometry>, Option<geojson::JsonObject>)| {
            let mut polygons = Vec::new();
            let added = geometry.iter().try_for_each(|geometry| add(&geometry.value, &mut polygons));
            added.map_err(|problem| format!("feature {}: {problem}", index + 1))?;
            let number = attribute.map_or(Err(String::new()), |name| {
                let properties = properties.unwrap_or_default();
                let value = find_attribute(properties.iter(), name)
                    .ok_or_else(|| missing_attribute(properties.keys()))?;
                value.as_f64().ok_or_else(|| format!("it is {value}"))
            });
            Ok(FeaturePolygons { polygons, number })
        };
    match parsed {
        GeoJson::Geometry(geometry) => Ok(vec![feature((0, Some(geometry), None))?]),
        GeoJson::Feature(one) => Ok(vec![feature((0, one.geometry, one.properties))?]),
        GeoJson::FeatureCollection(all) => {
            let each = all.features.into_iter().enumerate();
            each.map(|(index, one)| feature((index, one.geometry, one.properties))).collect()
        }
    }
}

/// Adds the polygons of a GeoJSON geometry.
fn add(geometry: &GeometryValue, polygons: &mut Vec<Polygon>) -> Result<(), String> {
    let place = |position: &Position| match position.as_slice() {
        [x, y, ..] => Ok([*x, *y]),
        short => Err(format!("a position has {} coordinates", short.len())),
    };
    let ring = |ring: &Vec<Position>| -> Result<Ring, String> { ring.iter().map(place).collect() };
    let mut take = |polygon: &Vec<Vec<Position>>| {
        polygons.push(polygon.iter().map(ring).collect::<Result<_, _>>()?);
        Ok(())
    };
    match geometry {
        GeometryValue::Polygon { coordinates } => take(coordinates),
        GeometryValue::MultiPolygon { coordinates } => coordinates.iter().try_for_each(take),
        GeometryValue::GeometryCollection { geometries } => {
            geometries.iter().try_for_each(|inner| add(&inner.value, polygons))
        }
        other => Err(not_a_polygon(other.type_name())),
    }
}

/// Polygons of each shape of a shapefile.
fn shapefile_features(file: &Path, attribute: Option<&str>) -> Result<Vec<FeaturePolygons>, String> {
    let wrong = |error: shapefile::Error| format!("is not a readable shapefile: {error}");
    let shapes = shapefile::read_shapes(file).map_err(wrong)?;
    let table = attribute_table(file);
    let is_deleted =
        table.as_ref().map_or_else(|| Ok(vec![false; shapes.len()]), |table| deleted_rows(table))?;
    if is_deleted.len() != shapes.len() {
        return Err(format!(
            "it has {} shapes, but the .dbf beside it has {} rows. Write the shapefile again",
            shapes.len(),
            is_deleted.len()
        ));
    }
    let records = attribute.map_or_else(|| Ok(Vec::new()), |_| attribute_rows(table.as_deref()))?;
    let mut records = records.iter();
    let feature = |((index, shape), is_deleted): ((usize, Shape), bool)| {
        if is_deleted {
            return Ok(FeaturePolygons {
                polygons: Vec::new(),
                number: Err("its row is deleted".to_owned()),
            });
        }
        // Deleted rows are not among the records.
        let record = records.next();
        let number = attribute.map_or(Err(String::new()), |name| {
            let record = record.ok_or("the .dbf beside it has fewer rows")?;
            let fields = record.as_ref();
            let value =
                find_attribute(fields.iter(), name).ok_or_else(|| missing_attribute(fields.keys()))?;
            number(value).ok_or_else(|| format!("it is {value}"))
        });
        let polygons = polygons(&shape).map_err(|problem| format!("feature {}: {problem}", index + 1))?;
        Ok(FeaturePolygons { polygons, number })
    };
    shapes.into_iter().enumerate().zip(is_deleted).map(feature).collect()
}

/// Path of the attribute table beside a shapefile, where there is one.
fn attribute_table(file: &Path) -> Option<PathBuf> {
    ["dbf", "DBF"].map(|ending| file.with_extension(ending)).into_iter().find(|path| path.is_file())
}

/// Rows of an attribute table, without the deleted ones.
fn attribute_rows(table: Option<&Path>) -> Result<Vec<dbase::Record>, String> {
    let table = table.ok_or("has no .dbf beside it, the file with its attributes")?;
    dbase::read(table).map_err(|error| format!("the .dbf beside it cannot be read: {error}"))
}

/// Whether each row of an attribute table is marked as deleted (dBASE III: the first byte of a row).
fn deleted_rows(table: &Path) -> Result<Vec<bool>, String> {
    let bytes =
        std::fs::read(table).map_err(|error| format!("the .dbf beside it cannot be read: {error}"))?;
    let cut = || "the .dbf beside it is truncated".to_owned();
    let short = |at: usize| {
        let two: [u8; 2] = bytes.get(at..at + 2)?.try_into().ok()?;
        Some(usize::from(u16::from_le_bytes(two)))
    };
    let count: [u8; 4] = bytes.get(4..8).and_then(|four| four.try_into().ok()).ok_or_else(cut)?;
    let (head, row) = short(8).zip(short(10)).ok_or_else(cut)?;
    let mark = |number: usize| bytes.get(head + number * row).map(|mark| *mark == b'*').ok_or_else(cut);
    (0..u32::from_le_bytes(count) as usize).map(mark).collect()
}

/// Number in a cell of an attribute table.
fn number(value: &FieldValue) -> Option<f64> {
    match value {
        FieldValue::Numeric(value) => *value,
        FieldValue::Float(value) => value.map(f64::from),
        FieldValue::Integer(value) => Some(f64::from(*value)),
        FieldValue::Double(value) | FieldValue::Currency(value) => Some(*value),
        _ => None,
    }
}

/// Polygons of a shapefile record; empty where it has no geometry.
fn polygons(shape: &Shape) -> Result<Vec<Polygon>, String> {
    let found = match shape {
        Shape::NullShape => Some(Vec::new()),
        Shape::Polygon(polygon) => group_rings(polygon.rings(), |p| [p.x, p.y]),
        Shape::PolygonZ(polygon) => group_rings(polygon.rings(), |p| [p.x, p.y]),
        Shape::PolygonM(polygon) => group_rings(polygon.rings(), |p| [p.x, p.y]),
        other => return Err(not_a_polygon(&other.shapetype().to_string())),
    };
    found.ok_or_else(|| {
        "a ring within another has the same orientation, so it is not a hole: repair the geometry (in QGIS \
         with “Fix geometries”)"
            .to_owned()
    })
}

/// Groups the rings of a record into polygons. Clockwise rings are outer ones, and each other ring is a hole of the smallest outer ring
/// around it. A hole within no outer ring is a polygon drawn in the wrong sense. `None` where an outer ring lies within another one and in
/// no hole of it.
fn group_rings<P>(rings: &[PolygonRing<P>], place: impl Fn(&P) -> [f64; 2]) -> Option<Vec<Polygon>> {
    let corners = |ring: &PolygonRing<P>| -> Ring { ring.points().iter().map(&place).collect() };
    let is_outer = |ring: &&PolygonRing<P>| matches!(ring, PolygonRing::Outer(_));
    let (outer, inner): (Vec<_>, Vec<_>) = rings.iter().partition(is_outer);
    let mut polygons: Vec<Polygon> = outer.into_iter().map(|ring| vec![corners(ring)]).collect();
    let whole: Vec<Option<(Outline, f64)>> = polygons
        .iter()
        .map(|polygon| {
            let outline = Outline::new(vec![polygon.clone()]).ok()?;
            let area = outline.area();
            Some((outline, area))
        })
        .collect();
    for hole in inner.into_iter().map(corners) {
        let around = |outline: &Outline| hole.iter().all(|corner| outline.contains(*corner));
        let found = whole.iter().enumerate().filter_map(|(number, outer)| {
            outer.as_ref().filter(|(outline, _)| around(outline)).map(|(_, area)| (number, *area))
        });
        match found.min_by(|(_, a), (_, b)| a.total_cmp(b)) {
            Some((number, _)) => polygons[number].push(hole),
            None => polygons.push(vec![hole]),
        }
    }
    let within = |ring: &Ring, around: &Ring| {
        Outline::new(vec![vec![around.clone()]])
            .is_ok_and(|outline| ring.iter().all(|corner| outline.contains(*corner)))
    };
    let is_doubtful = polygons.iter().enumerate().any(|(number, inner)| {
        polygons.iter().enumerate().any(|(other, outer)| {
            number != other
                && within(&inner[0], &outer[0])
                && !within(&outer[0], &inner[0])
                && !outer[1..].iter().any(|hole| within(&inner[0], hole))
        })
    });
    (!is_doubtful).then_some(polygons)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_within_another_is_a_hole_an_island_or_in_doubt() {
        let square = |size: f64| {
            let at = |x: f64, y: f64| shapefile::Point::new(size * x, size * y);
            vec![at(-1.0, -1.0), at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0), at(-1.0, -1.0)]
        };
        let (outer, hole) =
            (|size| PolygonRing::Outer(square(size)), |size| PolygonRing::Inner(square(size)));
        let found = |rings: &[PolygonRing<shapefile::Point>]| group_rings(rings, |p| [p.x, p.y]);
        let area = |polygons: Vec<Polygon>| Outline::new(polygons).unwrap().area();
        assert!((area(found(&[outer(4.0), hole(3.0)]).unwrap()) - 28.0).abs() < 1e-9);
        assert!((area(found(&[outer(4.0), hole(3.0), outer(1.0)]).unwrap()) - 32.0).abs() < 1e-9);
        assert_eq!(found(&[outer(4.0), outer(3.0)]), None);
    }
}
