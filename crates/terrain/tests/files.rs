//! Files written and read again, and files that are refused.

use std::path::PathBuf;

use colluvium_points::{Raster, Surface};
use colluvium_terrain::{read_features, read_mesh, read_outlines, read_raster, write_raster};

fn file(folder: &tempfile::TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Coordinates as the file has them.
fn as_it_is(_axis: usize, x: f64) -> f64 {
    x
}

#[test]
fn a_raster_is_the_same_in_both_formats() {
    let folder = tempfile::tempdir().unwrap();
    let raster = Raster::from_function([5, 4], [1.25, -3.5], [0.5, 0.5], |x, y| (x * 1.7).sin() + y / 3.0);
    for name in ["a.asc", "a.tif"] {
        let path = folder.path().join(name);
        write_raster(&path, &raster).unwrap();
        let back = read_raster(&path).unwrap();
        assert_eq!(
            (back.origin, back.spacing, &back.values),
            (raster.origin, raster.spacing, &raster.values)
        );
    }
    let error = write_raster(&folder.path().join("a.png"), &raster).unwrap_err();
    assert!(error.problem.contains(".asc"), "{error}");
    let missing = read_raster(&folder.path().join("none.asc")).unwrap_err();
    assert!(missing.to_string().contains("none.asc: cannot be read"), "{missing}");
    let blank = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nnodata_value -1\n-1 -1\n-1 -1\n";
    assert!(read_raster(&file(&folder, "b.asc", blank)).unwrap_err().problem.contains("no data"));
}

/// A tetrahedron with a corner at the origin and edges of one along the axes.
const TETRAHEDRON: [[[f64; 3]; 3]; 4] = [
    [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
];

fn stl(triangles: &[[[f64; 3]; 3]]) -> String {
    let mut text = "solid t\n".to_owned();
    for triangle in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for v in triangle {
            text += &format!("vertex {} {} {}\n", v[0], v[1], v[2]);
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid t\n"
}

#[test]
fn closed_meshes_are_read_and_open_ones_refused() {
    let folder = tempfile::tempdir().unwrap();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    for path in [file(&folder, "t.stl", &stl(&TETRAHEDRON)), file(&folder, "t.obj", obj)] {
        let mesh = read_mesh(&path, &as_it_is).unwrap();
        assert_eq!((mesh.vertices().len(), mesh.facets().len()), (4, 4));
        let gap = mesh.gap(&[1.0, 1.0, 1.0], 9.0).unwrap();
        assert!((gap.distance - 2.0 / 3f64.sqrt()).abs() < 1e-12);
        assert!(mesh.contains(&[0.1, 0.1, 0.1]) && !mesh.contains(&[0.5, 0.5, 0.5]));
    }
    let open = read_mesh(&file(&folder, "open.stl", &stl(&TETRAHEDRON[1..])), &as_it_is).unwrap_err();
    assert!(open.problem.contains("open"), "{open}");
    assert!(read_mesh(&file(&folder, "bad.stl", "solid nothing"), &as_it_is).is_err());
    assert!(read_mesh(&file(&folder, "bad.obj", "v 1 2\nf 1 2 3"), &as_it_is).is_err());
}

#[test]
fn outlines_may_have_holes_and_must_not_cross_themselves() {
    let folder = tempfile::tempdir().unwrap();
    let holed = r#"{"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates":
        [[[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]], [[4, 4], [6, 4], [6, 6], [4, 6], [4, 4]]]}}"#;
    let outline = read_outlines(&file(&folder, "a.geojson", holed)).unwrap();
    assert!(outline.contains([1.0, 1.0]) && !outline.contains([5.0, 5.0]) && !outline.contains([11.0, 1.0]));
    let problem = |name: &str, text: &str| read_outlines(&file(&folder, name, text)).unwrap_err().problem;
    let crossed = r#"{"type": "Polygon", "coordinates": [[[0, 0], [10, 10], [10, 0], [0, 10], [0, 0]]]}"#;
    assert!(problem("b.geojson", crossed).contains("cross"));
    let degrees =
        r#"{"type": "Polygon", "coordinates": [[[11.1, 47.2], [11.2, 47.2], [11.2, 47.3], [11.1, 47.2]]]}"#;
    assert!(problem("c.geojson", degrees).contains("degrees"));
    let point = r#"{"type": "Point", "coordinates": [1, 2]}"#;
    assert!(problem("d.geojson", point).contains("no polygon"));
    assert!(problem("e.geojson", "{").contains("not GeoJSON"));
    assert!(problem("f.shp", "nonsense").contains("shapefile"));
}

#[test]
fn a_shapefile_is_read_as_it_was_written() {
    use shapefile::{Point, Polygon, PolygonRing};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.shp");
    let corners = [[0.0, 0.0], [0.0, 3.0], [4.0, 0.0], [0.0, 0.0]];
    let polygon = Polygon::new(PolygonRing::Outer(corners.map(|[x, y]| Point::new(x, y)).to_vec()));
    shapefile::ShapeWriter::from_path(&path).unwrap().write_shapes(&vec![polygon]).unwrap();
    let outline = read_outlines(&path).unwrap();
    assert!(outline.contains([1.0, 1.0]) && !outline.contains([3.0, 2.0]));
}

#[test]
fn features_have_the_numbers_of_their_attributes() {
    use shapefile::dbase::{FieldValue, Record, TableWriterBuilder};
    use shapefile::{Point, Polygon, PolygonRing};
    let folder = tempfile::tempdir().unwrap();
    let square = |at: f64| [[at, 0.0], [at, 4.0], [at + 4.0, 4.0], [at + 4.0, 0.0], [at, 0.0]];
    let feature = |at: f64, properties: &str| {
        format!(
            r#"{{"type": "Feature", "properties": {properties}, "geometry": {{"type": "Polygon", "coordinates": [{:?}]}}}}"#,
            square(at)
        )
    };
    let collection = |features: [String; 2]| {
        format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, features.join(","))
    };
    let two = collection([feature(0.0, r#"{"depth": 1.5}"#), feature(10.0, r#"{"depth": 3}"#)]);
    let map = file(&folder, "a.geojson", &two);
    let shape = folder.path().join("a.shp");
    let fields = TableWriterBuilder::new().add_numeric_field("depth".try_into().unwrap(), 10, 3);
    let mut writer = shapefile::Writer::from_path(&shape, fields).unwrap();
    for (at, depth) in [(0.0, 1.5), (10.0, 3.0)] {
        let ring = PolygonRing::Outer(square(at).map(|[x, y]| Point::new(x, y)).to_vec());
        let mut record = Record::default();
        record.insert("depth".to_owned(), FieldValue::Numeric(Some(depth)));
        writer.write_shape_and_record(&Polygon::new(ring), &record).unwrap();
    }
    drop(writer);
    for path in [&map, &shape] {
        let features = read_features(path, "depth").unwrap();
        let found: Vec<f64> = features.iter().map(|(_, depth)| *depth).collect();
        assert_eq!(found, [1.5, 3.0], "{path:?}");
        assert!(features[1].0.contains([12.0, 2.0]) && !features[0].0.contains([12.0, 2.0]));
        let problem = read_features(path, "height").unwrap_err().problem;
        assert_eq!(problem, "feature 1 has no number under \"height\"");
    }
    let half = collection([feature(0.0, r#"{"depth": 1.5}"#), feature(10.0, r#"{"depth": "deep"}"#)]);
    let problem = read_features(&file(&folder, "b.geojson", &half), "depth").unwrap_err().problem;
    assert!(problem.starts_with("feature 2 has no number"), "{problem}");
}
