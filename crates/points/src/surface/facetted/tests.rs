use proptest::prelude::*;

use super::*;
use crate::surface::BallSurface;

fn cube() -> FacettedSurface<3> {
    FacettedSurface::around_box([-1.0; 3], [1.0; 3]).unwrap()
}

/// Signed distance from a cube of half edge one about the origin (m), negative inside.
fn from_cube(x: &[f64; 3]) -> f64 {
    let beyond = x.map(|c| c.abs() - 1.0);
    let outside: f64 = beyond.iter().map(|c| c.max(0.0).powi(2)).sum();
    if outside > 0.0 { outside.sqrt() } else { beyond.iter().copied().fold(f64::NEG_INFINITY, f64::max) }
}

proptest! {
    #[test]
    fn the_distance_from_a_cube_is_that_of_the_closed_form(x in proptest::array::uniform3(-3.0..3.0f64)) {
        let gap = cube().gap(&x, f64::INFINITY).unwrap();
        prop_assert!((gap.distance - from_cube(&x)).abs() < 1e-12, "{gap:?}");
        prop_assert!((dot(&gap.normal, &gap.normal) - 1.0).abs() < 1e-12);
        let back: [f64; 3] = std::array::from_fn(|c| gap.position[c] + gap.distance * gap.normal[c]);
        prop_assert!((0..3).all(|c| (back[c] - x[c]).abs() < 1e-12), "{gap:?}");
        prop_assert_eq!(cube().contains(&x), from_cube(&x) <= 0.0);
    }

    #[test]
    fn a_polygon_has_its_inside_where_its_shape_has(x in -1.5..1.5f64, y in -1.5..1.5f64) {
        let corners = [[-0.8, -0.8], [0.9, -0.6], [0.7, 0.8], [0.0, -0.1], [-0.7, 0.6]];
        let shape = crate::Shape::Polygon { vertices: corners.to_vec().into() };
        let mut reversed = corners;
        reversed.reverse();
        for corners in [corners, reversed] {
            let surface = FacettedSurface::polygon(&corners).unwrap();
            prop_assert_eq!(surface.contains(&[x, y]), shape.contains(&[x, y]));
        }
    }
}

fn contacts_of_ball<const D: usize>(
    surface: &dyn Surface<D>,
    x: [f64; D],
    radius: f64,
) -> Vec<NearestPoint<D>> {
    let mut found = ContactQuery::default();
    surface.query_contacts(&x, radius, &mut found);
    found.contacts().to_vec()
}

#[test]
fn a_ball_over_two_facets_of_one_plane_touches_once() {
    let surface = cube();
    // Above the diagonal, beside it, and above the edges and corners of the face.
    for (x, y) in [(0.0, 0.0), (0.01, -0.01), (0.3, 0.2), (-0.6, 0.59), (1.0, 1.0), (1.01, 0.5)] {
        let found = contacts_of_ball(&surface, [x, y, 1.05], 0.2);
        assert_eq!(found.len(), 1, "at {x}, {y}: {found:?}");
    }
    let key = |x: [f64; 3]| contacts_of_ball(&surface, x, 0.2)[0].feature_id;
    assert_eq!(key([1.05, 1.05, 0.3]), key([1.1, 1.02, -0.7]), "along an edge the contact stays the same");
    assert_ne!(key([1.05, 1.05, 0.3]), key([1.05, -1.05, 0.3]));
}

#[test]
fn a_ball_in_a_valley_touches_both_flanks() {
    let ground = FacettedSurface::ground_line(&[[-2.0, 2.0], [0.0, 0.0], [2.0, 2.0]]).unwrap();
    let found = contacts_of_ball(&ground, [0.0, 1.0], 0.8);
    assert_eq!(found.len(), 2);
    for place in &found {
        assert!((place.distance - 0.5f64.sqrt()).abs() < 1e-12);
        assert!((place.normal[1] - 0.5f64.sqrt()).abs() < 1e-12);
    }
    // At the bottom of a ridge's flank there is one contact, at its crest one contact with the corner.
    let ridge = FacettedSurface::ground_line(&[[2.0, -2.0], [0.0, 0.0], [-2.0, -2.0]]).unwrap();
    let crest = contacts_of_ball(&ridge, [0.1, 0.5], 0.8);
    assert_eq!(crest.len(), 1);
    assert!((crest[0].distance - 0.26f64.sqrt()).abs() < 1e-12);
    assert_eq!(contacts_of_ball(&ridge, [0.0, -0.5], 0.8), [], "inside the solid");
}

#[test]
fn a_hole_like_box_corner_touches_three_faces() {
    let corner: Vec<[f64; 2]> = vec![[0.0, 3.0], [0.0, 0.0], [3.0, 0.0]];
    let ground = FacettedSurface::ground_line(&corner).unwrap();
    assert_eq!(contacts_of_ball(&ground, [0.4, 0.5], 0.6).len(), 2);
    assert_eq!(contacts_of_ball(&ground, [0.4, 0.7], 0.6).len(), 1);
}

#[test]
fn ground_lines_have_arc_lengths_and_self_crossing_ones_are_refused() {
    let ground = FacettedSurface::ground_line(&[[0.0, 3.0], [4.0, 0.0], [6.0, 0.0]]).unwrap();
    assert_eq!(ground.arc_length(&[5.0, 1.0]), Some(6.0));
    assert!(ground.contains(&[1.0, 1.0]) && !ground.contains(&[4.0, 0.1]));
    let crossing =
        FacettedSurface::ground_line(&[[0.0, 0.0], [4.0, 0.0], [2.0, 1.0], [2.0, -1.0], [5.0, -1.0]]);
    assert!(crossing.unwrap_err().problem.contains("crosses"));
    assert!(FacettedSurface::ground_line(&[[0.0, 0.0], [0.0, 1.0]]).is_err());
    assert!(FacettedSurface::ground_line(&[[0.0, 0.0], [0.0, 0.0]]).is_err());
    let twice = FacettedSurface::ground_line(&[[0.0, 3.0], [4.0, 0.0], [4.0, 0.0], [6.0, 0.0]]).unwrap();
    assert_eq!((twice.facets().len(), twice.arc_length(&[5.0, 1.0])), (2, Some(6.0)));
    assert!(FacettedSurface::polygon(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 2.0]]).is_err());
}

#[test]
fn open_and_twisted_meshes_are_refused() {
    let cube = cube();
    let open = FacettedSurface::closed_surface(cube.vertices().to_vec(), &cube.facets()[1..]).unwrap_err();
    assert!(open.problem.contains("open"), "{open}");
    let mut twisted = cube.facets().to_vec();
    twisted[3].swap(0, 1);
    assert!(FacettedSurface::closed_surface(cube.vertices().to_vec(), &twisted).is_err());
    let mut inside_out = cube.facets().to_vec();
    inside_out.iter_mut().for_each(|t| t.swap(0, 1));
    let turned = FacettedSurface::closed_surface(cube.vertices().to_vec(), &inside_out).unwrap();
    assert!(turned.contains(&[0.0; 3]) && !turned.contains(&[2.0, 0.0, 0.0]));
    let loose: Vec<[[f64; 3]; 3]> =
        cube.facets().iter().map(|t| t.map(|v| cube.vertices()[v as usize])).collect();
    assert_eq!(FacettedSurface::from_triangles(&loose).unwrap().vertices().len(), 8);
}

#[test]
fn the_inside_of_a_hollow_ball_touches_as_a_bowl() {
    let bowl = BallSurface::new([0.0, 0.0], 1.0, true).unwrap();
    let gap = bowl.gap(&[0.0, -0.9], 0.2).unwrap();
    assert!((gap.distance - 0.1).abs() < 1e-15 && gap.normal == [0.0, 1.0]);
    assert!(bowl.contains(&[0.0, -1.1]) && !bowl.contains(&[0.0, 0.0]));
}

#[test]
fn a_mesh_that_passes_through_itself_is_refused_and_one_of_two_pieces_is_not() {
    let boxes = |shift: [f64; 3]| -> Vec<[[f64; 3]; 3]> {
        let cube = cube();
        let all = |shift: [f64; 3]| -> Vec<[[f64; 3]; 3]> {
            let moved = |v: u32| std::array::from_fn(|c| cube.vertices()[v as usize][c] + shift[c]);
            cube.facets().iter().map(|facet| facet.map(moved)).collect()
        };
        [all([0.0; 3]), all(shift)].concat()
    };
    let error = FacettedSurface::from_triangles(&boxes([0.7, 0.6, 0.5])).unwrap_err();
    assert!(error.problem.contains("passes through the one from"), "{error}");
    assert!(FacettedSurface::from_triangles(&boxes([2.5, 0.3, 0.2])).is_ok(), "apart");
    assert!(FacettedSurface::from_triangles(&boxes([2.0, 0.3, 0.2])).is_ok(), "face on face");
}
