use super::*;
use proptest::prelude::*;

fn simplex_mesh<const D: usize>(cells: [usize; D]) -> Mesh<D> {
    Mesh::of_grid(&Grid { origin: [-1.0; D], cell: 0.5, cells }).unwrap()
}

#[test]
fn the_reference_tetrahedron_has_the_height_of_the_sheet() {
    let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
    let mesh = Mesh::new(&nodes, &[vec![0, 1, 2, 3]], &BTreeMap::new()).unwrap();
    assert!((mesh.elements[0].volume - 1.0).abs() < 1e-15);
    assert!((mesh.height() - 0.857_143).abs() < 5e-7, "3 V / A_max, A_max = 3.5");
    let areas: Vec<f64> = (0..4).map(|k| mesh.facet_area(0, k)).collect();
    assert!(areas.iter().any(|a| (a - 3.5).abs() < 1e-14), "{areas:?}");
    // A right triangle: 2 A / l_max.
    let flat = Mesh::new(&[[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]], &[vec![0, 1, 2]], &BTreeMap::new()).unwrap();
    assert!((flat.height() - 12.0 / 5.0).abs() < 1e-15);
}

#[test]
fn elements_of_a_subdivided_box_fill_it() {
    let flat = simplex_mesh([4, 3]);
    let volume: f64 = flat.elements.iter().map(|e| e.volume).sum();
    assert!(flat.elements.len() == 24 && (volume - 3.0).abs() < 1e-14);
    assert_eq!(flat.boundary(|_| true).count(), 14);
    let solid = simplex_mesh([2, 3, 2]);
    let volume: f64 = solid.elements.iter().map(|e| e.volume).sum();
    assert!(solid.elements.len() == 72 && (volume - 12.0 * 0.125).abs() < 1e-14);
    assert_eq!(solid.boundary(|_| true).count(), 2 * 2 * (6 + 4 + 6), "two triangles a face of a cell");
}

fn shape_functions<const D: usize>(mesh: &Mesh<D>, x: &[f64; D]) {
    let element = mesh.locate(x).unwrap();
    let n = mesh.barycentric(element, x);
    let e = &mesh.elements[element as usize];
    assert!((n.iter().sum::<f64>() - 1.0).abs() < 1e-13);
    for i in 0..D {
        let place: f64 = (0..=D).map(|k| n[k] * mesh.nodes[e.nodes[k] as usize][i]).sum();
        assert!((place - x[i]).abs() < 1e-13);
        for j in 0..D {
            let unit: f64 = (0..=D).map(|k| mesh.nodes[e.nodes[k] as usize][i] * e.gradients[k][j]).sum();
            assert!((unit - if i == j { 1.0 } else { 0.0 }).abs() < 1e-12);
        }
    }
}

proptest! {
    #[test]
    fn linear_fields_are_reproduced(x in proptest::array::uniform3(-1.0..0.5f64)) {
        shape_functions(&simplex_mesh([3, 3]), &[x[0], x[1]]);
        shape_functions(&simplex_mesh([3, 3, 3]), &x);
    }

    #[test]
    fn point_location_by_walking_agrees_with_bins(start in 0u32..162, x in proptest::array::uniform3(-1.0..0.5f64)) {
        let mesh = simplex_mesh([3, 3, 3]);
        let found = mesh.locate_from(start, &x).unwrap();
        prop_assert!(lowest_entry::<3>(&mesh.barycentric(found, &x)).1 >= -BARYCENTRIC_TOLERANCE);
        prop_assert_eq!(mesh.locate_from(start, &[x[0] + 2.0, x[1], x[2]]), None);
    }
}

#[test]
fn bad_meshes_are_refused() {
    let none = BTreeMap::new();
    let nodes = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let refuse = |nodes: &[[f64; 2]], elements: &[Vec<usize>]| Mesh::new(nodes, elements, &none).unwrap_err();
    assert_eq!(refuse(&nodes, &[]), MeshError::Empty("triangle"));
    assert!(matches!(refuse(&nodes, &[vec![0, 1, 7]]), MeshError::UnknownNode { node: 7, .. }));
    assert!(matches!(refuse(&nodes, &[vec![0, 2, 1]]), MeshError::Volume { .. }), "clockwise");
    let line = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]];
    assert!(matches!(refuse(&line, &[vec![0, 1, 2]]), MeshError::Volume { .. }));
    let twice = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.0]];
    assert!(matches!(
        refuse(&twice, &[vec![0, 1, 2], vec![0, 3, 2]]),
        MeshError::Duplicate { first: 1, second: 3, .. }
    ));
    let infinite = [[0.0, 0.0], [f64::NAN, 0.0], [0.0, 1.0]];
    assert!(matches!(refuse(&infinite, &[vec![0, 1, 2]]), MeshError::NotFinite { node: 1, .. }));
    let thrice = [vec![0, 1, 2], vec![0, 1, 3], vec![0, 1, 2]];
    assert!(matches!(refuse(&nodes, &thrice), MeshError::SharedFacet { .. }));
}

#[test]
fn nodes_are_numbered_along_the_first_axis_and_groups_follow() {
    let nodes = [[1.0, 0.0], [9.0, 9.0], [0.0, 0.0], [0.0, 1.0]];
    let groups = BTreeMap::from([("left".to_owned(), vec![3, 2, 1])]);
    let mesh = Mesh::new(&nodes, &[vec![2, 0, 3]], &groups).unwrap();
    assert_eq!(mesh.nodes(), [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
    assert_eq!(mesh.group("left"), Some(&[0, 1][..]), "and the node of no element is gone");
}
