//! Cell lists and neighbour lists against brute force.

use colluvium_points::{CellList, HalfNeighbourList, NeighbourList, SearchError};
use proptest::prelude::*;

fn agrees_with_brute_force<const D: usize>(points: &[[f64; D]], radius: f64) {
    let mut list = NeighbourList::new();
    list.build(points, radius).unwrap();
    for (i, a) in points.iter().enumerate() {
        let close = |b: &[f64; D]| {
            let square: f64 = (0..D).map(|c| (a[c] - b[c]).powi(2)).sum();
            square <= radius * radius
        };
        let all: Vec<u32> =
            (0..points.len()).filter(|&j| j != i && close(&points[j])).map(|j| j as u32).collect();
        assert_eq!(list.neighbours(i), all);
    }
    let mut first = NeighbourList::new();
    first.build_first(points, points.len() / 2, radius, |_, _| true).unwrap();
    assert!((0..first.len()).all(|i| first.neighbours(i) == list.neighbours(i)));
    assert_eq!(first.len(), points.len() / 2);
    first.build_first(points, points.len(), radius, |i, j| (i + j) % 2 == 1).unwrap();
    let odd =
        |i: usize| list.neighbours(i).iter().copied().filter(|j| (i as u32 + j) % 2 == 1).collect::<Vec<_>>();
    assert!((0..points.len()).all(|i| first.neighbours(i) == odd(i)));
    let mut half = HalfNeighbourList::new();
    half.build(points, radius).unwrap();
    let full = (0..points.len()).flat_map(|i| list.neighbours(i).iter().map(move |&j| (i as u32, j)));
    let once: Vec<(u32, u32)> = full.filter(|(i, j)| i < j).collect();
    assert!(half.pairs().eq(once.iter().copied()));
    assert_eq!((half.len(), half.is_empty()), (once.len(), once.is_empty()));
}

proptest! {
    #[test]
    fn neighbours_are_those_of_brute_force(
        coordinates in proptest::collection::vec(-3.0..3.0f64, 0..240), radius in 0.05..2.0f64,
    ) {
        let (one, two, three) = (coordinates.as_chunks::<1>(), coordinates.as_chunks::<2>(), coordinates.as_chunks::<3>());
        agrees_with_brute_force(one.0, radius);
        agrees_with_brute_force(two.0, radius);
        agrees_with_brute_force(three.0, radius);
    }
}

/// Cells begin at the smallest coordinates: here every point lies on their faces, and pairs are exactly at the radius.
#[test]
fn points_on_the_faces_of_cells_are_found() {
    for edge in [1.0, 0.1, 1.0 / 3.0] {
        let at = |i: u32, step: u32| f64::from(i / step % 5) * edge - 2.0 * edge;
        let line: Vec<[f64; 1]> = (0..5).map(|i| [at(i, 1)]).collect();
        let plane: Vec<[f64; 2]> = (0..25).map(|i| [at(i, 1), at(i, 5)]).collect();
        let space: Vec<[f64; 3]> = (0..125).map(|i| [at(i, 1), at(i, 5), at(i, 25)]).collect();
        // One ulp to either side of the faces too.
        for radius in [edge, edge.next_up(), edge.next_down(), 2.0 * edge] {
            agrees_with_brute_force(&line, radius);
            agrees_with_brute_force(&plane, radius);
            agrees_with_brute_force(&space, radius);
        }
    }
    let mut list = NeighbourList::new();
    list.build(&[[0.0], [1.0], [2.0]], 1.0).unwrap();
    assert_eq!(
        (list.neighbours(0), list.neighbours(1), list.neighbours(2)),
        (&[1][..], &[0, 2][..], &[1][..])
    );
}

#[test]
fn one_point_has_no_neighbours_and_an_empty_set_no_list() {
    agrees_with_brute_force(&[[0.3, -0.2]], 0.5);
    let mut list = NeighbourList::new();
    list.build(&[[1e9, -1e9, 0.0]], 1e-3).unwrap();
    assert_eq!((list.len(), list.neighbours(0)), (1, &[][..]));
    list.build(&[], 1.0).unwrap();
    assert!(list.is_empty());
}

/// Points with individual radii: the list of the largest radius contains the neighbours of all points, and those closer than the mean of
/// two radii equal the pairs that brute force finds.
#[test]
fn the_list_of_the_largest_radius_contains_the_pairs_of_all_radii() {
    let noise = |i: u32, k: f64| (f64::from(i + 1) * k).fract();
    let points: Vec<[f64; 2]> = (0..300).map(|i| [noise(i, 0.618_034), noise(i, 0.754_878)]).collect();
    let radii: Vec<f64> = (0..300).map(|i| 0.05 + 0.1 * noise(i, 0.569_840)).collect();
    let close = |i: usize, j: usize| {
        let [a, b] = [points[i], points[j]];
        (a[0] - b[0]).hypot(a[1] - b[1]) < 0.5 * (radii[i] + radii[j])
    };
    let mut list = NeighbourList::new();
    list.build(&points, radii.iter().copied().fold(0.0, f64::max)).unwrap();
    for i in 0..300 {
        let found: Vec<usize> =
            list.neighbours(i).iter().map(|&j| j as usize).filter(|&j| close(i, j)).collect();
        let all: Vec<usize> = (0..300).filter(|&j| j != i && close(i, j)).collect();
        assert_eq!(found, all);
    }
}

#[test]
fn neighbours_from_another_set_are_found_within_the_radius_of_each_point() {
    let noise = |i: u32, k: f64| (f64::from(i + 1) * k).fract();
    let points = |count: u32, k: f64| -> Vec<[f64; 2]> {
        (0..count).map(|i| [noise(i, 0.618_034 * k), noise(i, 0.754_878 * k)]).collect()
    };
    let (targets, sources) = (points(300, 1.0), points(200, 1.7));
    // From a fraction of a cell's edge to many cells.
    let radius = |i: usize| 0.01 + 0.002 * i as f64;
    let mut list = NeighbourList::new();
    list.build_between(&targets, radius, &sources, 0.05, |_, j| j != 7).unwrap();
    for (i, x) in targets.iter().enumerate() {
        let near = |y: &[f64; 2]| (x[0] - y[0]).powi(2) + (x[1] - y[1]).powi(2) <= radius(i).powi(2);
        let all: Vec<u32> = (0..200).filter(|&j| j != 7 && near(&sources[j as usize])).collect();
        assert_eq!(list.neighbours(i), all);
    }
}

#[test]
fn points_at_non_finite_or_distant_positions_are_refused_by_index() {
    let mut list = CellList::new();
    assert_eq!(list.build(&[[0.0, 0.0], [f64::NAN, 0.0]], 1.0), Err(SearchError::NotFinite(1)));
    assert!(matches!(list.build(&[[0.0, 0.0], [1e12, 1e12]], 1.0), Err(SearchError::TooSpread(..))));
    let flier = [[0.0, 0.0], [1.0, 0.0], [3e4, 4e4], [0.0, 1.0]];
    assert!(matches!(list.build(&flier, 1.0), Err(SearchError::TooSpread(cells, 2)) if cells > 1e9));
    assert_eq!(list.build(&[[0.0, 0.0]], 0.0), Err(SearchError::Radius(0.0)));
}

#[test]
fn the_list_does_not_depend_on_the_number_of_threads() {
    let points: Vec<[f64; 2]> =
        (0..2000).map(|i| [f64::from(i % 47) * 0.1, f64::from(i % 53) * 0.1]).collect();
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut list = NeighbourList::new();
        pool.install(|| list.build(&points, 0.25).unwrap());
        let mut half = HalfNeighbourList::new();
        pool.install(|| half.build(&points, 0.25).unwrap());
        let neighbours: usize = list.blocks().iter().map(|rows| rows.indices().len()).sum();
        assert_eq!(2 * half.len(), neighbours);
        (list.blocks().to_vec(), half.pairs().collect::<Vec<_>>())
    };
    assert!(build(1) == build(2));
}
