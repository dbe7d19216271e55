//! Round trips of files, and rejected files.

use std::path::{Path, PathBuf};

use colluvium_points::{Raster, Surface};
use colluvium_terrain::{read_features, read_mesh, read_outlines, read_raster, write_raster};

fn file(folder: &tempfile::TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Coordinates as in the file.
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

/// Tetrahedron with a corner at the origin and edges of length one along the axes.
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
    let cut = stl(&TETRAHEDRON).replace("endsolid t\n", "");
    let cut = read_mesh(&file(&folder, "cut.stl", &cut), &as_it_is).unwrap_err();
    assert!(cut.problem.contains("begins 1 solids and ends 0"), "{cut}");
    let problem =
        |name: &str, text: &str| read_mesh(&file(&folder, name, text), &as_it_is).unwrap_err().problem;
    assert!(problem("bad.obj", "# a\nv 1 2\nf 1 2 3").starts_with("line 2: \"v 1 2\" cannot be read"));
    let commas = stl(&TETRAHEDRON).replacen("vertex 0", "vertex 0,5", 1);
    let commas = problem("comma.stl", &commas);
    assert!(commas.contains("does not have three numbers: write numbers with a decimal point"), "{commas}");
    assert!(problem("none.stl", "not a mesh").contains("is not an STL file, or is truncated: its 10 bytes"));
    let continued = obj.replace("f 1 3 2", "f 1 \\\n3 2");
    assert!(read_mesh(&file(&folder, "on.obj", &continued), &as_it_is).is_ok());
}

#[test]
fn concave_obj_polygons_are_read_and_non_planar_ones_are_refused_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    // Prism over an L, starting at each of its corners.
    let plan = [[-1, 5], [-5, 5], [-5, -5], [5, -5], [5, -1], [-1, -1]];
    for first in 0..6 {
        let mut text = String::new();
        for z in [-5, 0] {
            (0..6).for_each(|k| {
                text += &format!("v {} {} {z}\n", plan[(k + first) % 6][0], plan[(k + first) % 6][1]);
            });
        }
        text += "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
        (0..6).for_each(|k| {
            text += &format!("f {} {} {} {}\n", k + 1, (k + 1) % 6 + 1, (k + 1) % 6 + 7, k + 7);
        });
        let mesh = read_mesh(&file(&folder, "ell.obj", &text), &as_it_is).unwrap();
        assert_eq!(mesh.facets().len(), 20);
        assert!(mesh.contains(&[-3.0, 3.0, -1.0]) && mesh.contains(&[3.0, -3.0, -1.0]), "{first}");
        assert!(!mesh.contains(&[2.0, 2.0, -1.0]) && !mesh.contains(&[0.5, 0.5, -0.1]), "{first}");
    }
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\n\
                f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let read = |text: &str| read_mesh(&file(&folder, "cube.obj", text), &as_it_is);
    assert_eq!(read(cube).unwrap().facets().len(), 12);
    let problem = |from: &str, to: &str| read(&cube.replacen(from, to, 1)).unwrap_err().problem;
    assert!(problem("f 5 6 7 8", "f 5 7 6 8").starts_with("line 10: is a polygon that crosses itself"));
    assert!(read(&cube.replacen("v 1 1 1", "v 1 1 1.1", 1)).is_ok(), "bent as quadrilaterals of terrain are");
    assert!(problem("v 1 1 1", "v 1 1 3").starts_with("line 10: is a polygon whose corners lie up to"));
    // A continued line does not shift the line numbers of the following lines.
    let continued = cube.replace("f 4 3 2 1", "f 4 3 \\\n2 1").replace("f 5 6 7 8", "f 5 7 6 8");
    assert!(read(&continued).unwrap_err().problem.starts_with("line 11: "));
    assert!(problem("v 1 1 1", "v 1 1 1 2").starts_with("line 7: the vertex has the fourth number 2"));
    assert!(read(&cube.replace("v 1 1 1", "v 1 1 1 1.0")).is_ok(), "a weight that changes nothing");
    let coloured: Vec<String> = cube
        .lines()
        .map(|line| if line.starts_with('v') { format!("{line} 1 0.5 2") } else { line.to_owned() })
        .collect();
    assert!(read(&coloured.join("\n")).is_ok(), "six numbers are a vertex with a colour");
}

#[test]
fn all_solids_of_an_stl_file_are_read_with_case_insensitive_keywords() {
    let folder = tempfile::tempdir().unwrap();
    let beside = TETRAHEDRON.map(|triangle| triangle.map(|[x, y, z]| [x + 5.0, y, 1e-3 * z]));
    let both = stl(&TETRAHEDRON) + "\n" + &stl(&beside).replace("solid t", "solid of facet 2");
    for text in [both.clone(), both.to_uppercase(), both.replace('\n', "\r\n")] {
        let mesh = read_mesh(&file(&folder, "two.stl", &text), &as_it_is).unwrap();
        assert_eq!((mesh.vertices().len(), mesh.facets().len()), (8, 8));
        assert!(
            mesh.contains(&[0.1, 0.1, 0.1])
                && mesh.contains(&[5.1, 0.1, 1e-4])
                && !mesh.contains(&[3.0, 0.1, 0.1])
        );
    }
    // Binary file whose header begins with the keyword of a text file.
    let mut binary = b"solid made by a program".to_vec();
    binary.resize(80, b' ');
    binary.extend(4u32.to_le_bytes());
    for triangle in TETRAHEDRON {
        binary.extend([0; 12]);
        binary.extend(triangle.iter().flatten().flat_map(|x| (*x as f32).to_le_bytes()));
        binary.extend([0; 2]);
    }
    let path = folder.path().join("binary.stl");
    std::fs::write(&path, binary).unwrap();
    assert_eq!(read_mesh(&path, &as_it_is).unwrap().facets().len(), 4);
}

/// Feature collection of polygons, each a feature with its rings.
fn collection(features: &[Vec<Vec<[f64; 2]>>]) -> String {
    let feature = |rings: &Vec<Vec<[f64; 2]>>| {
        format!(
            r#"{{"type": "Feature", "properties": {{}}, "geometry": {{"type": "Polygon", "coordinates": {rings:?}}}}}"#
        )
    };
    let all: Vec<String> = features.iter().map(feature).collect();
    format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, all.join(","))
}

fn rectangle(low: [f64; 2], high: [f64; 2]) -> Vec<[f64; 2]> {
    vec![low, [low[0], high[1]], high, [high[0], low[1]], low]
}

#[test]
fn features_of_a_file_are_united_and_holes_are_those_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let two = [vec![rectangle([0.0; 2], [3.0, 4.0])], vec![rectangle([1.0, 0.0], [4.0; 2])]];
    let map = file(&folder, "over.geojson", &collection(&two));
    let nested = [
        vec![rectangle([0.0; 2], [4.0; 2]), rectangle([1.0; 2], [3.0; 2])],
        vec![rectangle([1.5; 2], [2.5; 2])],
    ];
    let island = file(&folder, "island.geojson", &collection(&nested));
    let parts: Vec<String> = two.iter().map(|rings| format!("{rings:?}")).collect();
    let multi = format!(r#"{{"type": "MultiPolygon", "coordinates": [{}]}}"#, parts.join(","));
    let multi = file(&folder, "multi.geojson", &multi);
    for (path, area) in [(map, 16.0), (multi, 16.0), (island, 13.0)] {
        let outline = read_outlines(&path).unwrap();
        assert!((outline.area() - area).abs() < 1e-12, "{path:?}: {}", outline.area());
        assert!(outline.contains([2.0, 2.0]) && outline.contains([0.5, 2.0]));
    }
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
    assert!(problem("d.geojson", point).starts_with("feature 1: is a Point, but only polygons"));
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
fn rings_of_a_shapefile_in_any_order_are_polygons_with_their_holes() {
    use shapefile::{Point, Polygon, PolygonRing};
    let folder = tempfile::tempdir().unwrap();
    let ring = |low: [f64; 2], high: [f64; 2]| -> Vec<Point> {
        rectangle(low, high).iter().map(|[x, y]| Point::new(*x, *y)).collect()
    };
    let outer = |low: [f64; 2], high: [f64; 2]| PolygonRing::Outer(ring(low, high));
    let hole = |low: [f64; 2], high: [f64; 2]| PolygonRing::Inner(ring(low, high));
    let write = |name: &str, records: Vec<Vec<PolygonRing<Point>>>| {
        let path = folder.path().join(name);
        let shapes: Vec<Polygon> = records.into_iter().map(Polygon::with_rings).collect();
        shapefile::ShapeWriter::from_path(&path).unwrap().write_shapes(&shapes).unwrap();
        read_outlines(&path).unwrap()
    };
    // A hole before its outer ring, with an island in a separate record over it.
    let holed = vec![hole([1.0; 2], [3.0; 2]), outer([0.0; 2], [4.0; 2]), outer([6.0, 0.0], [7.0, 4.0])];
    let outline = write("a.shp", vec![holed, vec![outer([1.5; 2], [2.5; 2])]]);
    assert!((outline.area() - 17.0).abs() < 1e-12, "{}", outline.area());
    assert!(outline.contains([2.0, 2.0]) && !outline.contains([1.2, 2.0]) && outline.contains([6.5, 1.0]));
    // Records that touch, and one whose ring has the wrong sense.
    let outline = write("b.shp", vec![vec![outer([0.0; 2], [2.0, 4.0])], vec![hole([2.0, 0.0], [4.0; 2])]]);
    assert!((outline.area() - 16.0).abs() < 1e-12 && outline.contains([2.0, 1.0]));
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
    let gathered = |features: [String; 2]| {
        format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, features.join(","))
    };
    let two = gathered([feature(0.0, r#"{"depth": 1.5}"#), feature(10.0, r#"{"depth": 3}"#)]);
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
        let found: Vec<f64> = features.iter().map(|feature| feature.thickness).collect();
        assert_eq!(found, [1.5, 3.0], "{path:?}");
        assert!(features[1].outline.contains([12.0, 2.0]) && !features[0].outline.contains([12.0, 2.0]));
        assert_eq!((features[0].number, features[1].number), (1, 2));
        let problem = read_features(path, "height").unwrap_err().problem;
        assert_eq!(problem, "feature 1 has no number in the attribute \"height\": its attributes are depth");
    }
    let half = gathered([feature(0.0, r#"{"depth": 1.5}"#), feature(10.0, r#"{"depth": "deep"}"#)]);
    let problem = read_features(&file(&folder, "b.geojson", &half), "depth").unwrap_err().problem;
    assert_eq!(problem, "feature 2 has no number in the attribute \"depth\": it is \"deep\"");
    std::fs::remove_file(shape.with_extension("dbf")).unwrap();
    let problem = read_features(&shape, "depth").unwrap_err().problem;
    assert!(problem.contains("no .dbf beside it"), "{problem}");
}

#[test]
fn deleted_table_rows_are_skipped_and_shape_counts_must_match() {
    use shapefile::dbase::{FieldValue, Record, TableWriterBuilder};
    use shapefile::{Point, Polygon, PolygonRing, Polyline};
    let folder = tempfile::tempdir().unwrap();
    let shape = folder.path().join("a.shp");
    let fields = TableWriterBuilder::new().add_numeric_field("DEPTH".try_into().unwrap(), 10, 3);
    let mut writer = shapefile::Writer::from_path(&shape, fields).unwrap();
    for (at, depth) in [(0.0, 1.5), (10.0, 3.0)] {
        let ring = rectangle([at, 0.0], [at + 4.0, 4.0]).into_iter().map(|[x, y]| Point::new(x, y)).collect();
        let mut record = Record::default();
        record.insert("DEPTH".to_owned(), FieldValue::Numeric(Some(depth)));
        writer.write_shape_and_record(&Polygon::new(PolygonRing::Outer(ring)), &record).unwrap();
    }
    drop(writer);
    // A name that differs in case matches where it is the only one.
    let found = |path: &Path| {
        read_features(path, "Depth")
            .map(|all| all.into_iter().map(|one| (one.number, one.thickness)).collect::<Vec<_>>())
    };
    assert_eq!(found(&shape).unwrap(), [(1, 1.5), (2, 3.0)]);
    let table = shape.with_extension("dbf");
    let mut bytes = std::fs::read(&table).unwrap();
    let head = usize::from(bytes[8]) + 256 * usize::from(bytes[9]);
    bytes[head] = b'*';
    std::fs::write(&table, &bytes).unwrap();
    assert_eq!(found(&shape).unwrap(), [(2, 3.0)]);
    let outline = read_outlines(&shape).unwrap();
    assert!((outline.area() - 16.0).abs() < 1e-12 && outline.contains([12.0, 2.0]));
    bytes[4] = 1;
    std::fs::write(&table, &bytes).unwrap();
    let problem = read_outlines(&shape).unwrap_err().problem;
    assert!(problem.contains("it has 2 shapes, but the .dbf beside it has 1 rows"), "{problem}");
    bytes.truncate(20);
    std::fs::write(&table, &bytes[..6]).unwrap();
    assert!(read_outlines(&shape).unwrap_err().problem.contains("truncated"));
    let line = folder.path().join("b.shp");
    let diagonal = Polyline::new(vec![Point::new(0.0, 0.0), Point::new(4.0, 4.0)]);
    shapefile::ShapeWriter::from_path(&line).unwrap().write_shapes(&vec![diagonal]).unwrap();
    let problem = read_outlines(&line).unwrap_err().problem;
    assert!(problem.starts_with("feature 1: is a Polyline, but only polygons"), "{problem}");
    let both = r#"{"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {}, "geometry": null},
        {"type": "Feature", "properties": {"Depth": 2, "depth": 3}, "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9, 9], [0, 0]]]}}]}"#;
    let map = file(&folder, "c.geojson", both);
    assert_eq!(found(&map).unwrap(), [(2, 2.0)]);
    let problem = read_features(&map, "DEPTH").unwrap_err().problem;
    assert!(problem.contains("its attributes are Depth, depth"), "{problem}");
    let line = both.replace("null", r#"{"type": "LineString", "coordinates": [[0, 0], [1, 1]]}"#);
    let problem = read_outlines(&file(&folder, "d.geojson", &line)).unwrap_err().problem;
    assert!(problem.starts_with("feature 1: is a LineString, but only polygons"), "{problem}");
}
