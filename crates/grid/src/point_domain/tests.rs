//! Domains whose nodes are no product of one basis per axis.

use crate::point_domain::convected_domains::{ConvectedDomain, ConvectedQuadrilateral};
use crate::point_domain::reference_domain::inverse;
use crate::point_domain::*;
use crate::{LinearBasis, Mesh};

/// Stand-in for domains that do not use the right stretch.
fn no_stretch<const D: usize>(_deformation: &SquareMatrix<D>) -> [f64; D] {
    [f64::NAN; D]
}

fn numbers<const D: usize>(domain: impl PointDomain<D>) -> Vec<f64> {
    let mut numbers = Vec::new();
    domain.append_numbers(&mut numbers);
    numbers
}

#[test]
fn corners_follow_the_deformation() {
    let mut domain = ConvectedDomain::<2>::default();
    domain.update_deformation(&[[0.0, 1.5], [0.0, 0.0]], no_stretch);
    let edges = domain.edges(&[0.2, 0.4]);
    let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    assert!(apart(edges[0], [0.1, 0.0]) < 1e-15 && apart(edges[1], [0.3, 0.2]) < 1e-15, "{edges:?}");
    assert!(apart(domain.extent(&[0.2, 0.4], 1.0), [0.8, 0.4]) < 1e-15);
    assert!(domain.validity_error(&[0.2, 0.4], 0.21).is_none());
    let fault = domain.validity_error(&[0.2, 0.4], 0.19).unwrap();
    assert!(fault.contains("4.211 cells wide"), "{fault}");
    domain.update_deformation(&[[f64::NAN, 0.0], [0.0, 0.0]], no_stretch);
    assert!(domain.validity_error(&[0.2, 0.4], 1.0).is_some());
}

#[test]
fn corners_move_with_the_velocity_field_at_their_position() {
    // In a linear velocity field the domains deform with the deformation gradient.
    let (initial, place, dt) = ([0.2, 0.4], [0.3, 0.7], 1.0);
    let field = |x: &[f64; 2]| [0.3 + 0.5 * x[0] - 0.2 * x[1], -0.1 + 0.7 * x[0] + 0.1 * x[1]];
    let (mut free, mut convected) = (ConvectedQuadrilateral::default(), ConvectedDomain::<2>::default());
    free.advect_corners(&place, &initial, &field(&place), dt, field);
    convected.update_deformation(&[[0.5, -0.2], [0.7, 0.1]], no_stretch);
    let edges = convected.edges(&initial);
    for (arm, [s, t]) in
        free.corner_vectors(&initial).iter().zip([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    {
        assert!((0..2).all(|c| (arm[c] - s * edges[0][c] - t * edges[1][c]).abs() < 1e-15), "{arm:?}");
    }
    assert!(free.validity_error(&initial, 0.2).is_none());
    assert!(free.validity_error(&initial, 0.1).unwrap().contains("cells from it"));
    assert_eq!(
        <ConvectedQuadrilateral as PointDomain<2>>::from_numbers(&numbers::<2>(free), no_stretch),
        free
    );
    let inward = |x: &[f64; 2]| if x[0] > 0.35 && x[1] > 0.8 { [-0.2, -0.4] } else { [0.0; 2] };
    let mut bent = ConvectedQuadrilateral::default();
    bent.advect_corners(&place, &initial, &[0.0; 2], 1.0, inward);
    assert!(bent.validity_error(&initial, 1.0).unwrap().contains("convex"));
}

#[test]
fn the_inverse_is_one() {
    let f = [[1.1, 0.3, -0.2], [0.1, 0.9, 0.4], [-0.3, 0.2, 1.2]];
    let g = inverse(&f);
    for i in 0..3 {
        for j in 0..3 {
            let product: f64 = (0..3).map(|k| f[i][k] * g[k][j]).sum();
            assert!((product - if i == j { 1.0 } else { 0.0 }).abs() < 1e-14);
        }
    }
    assert_eq!(inverse(&[[4.0]]), [[0.25]]);
    assert_eq!(inverse(&[[2.0, 0.0], [0.0, 4.0]]), [[0.5, 0.0], [0.0, 0.25]]);
}

#[test]
fn gradients_of_reference_functions_are_with_respect_to_the_current_position() {
    // Nodes at x = F X give a position gradient of one.
    let grid = Grid::new([0.0; 2], [1.0; 2], 0.25).unwrap();
    let mesh = Mesh::default();
    let ground = GridView { grid: &grid, mesh: &mesh, strides: [5, 1], ghosts: 0 };
    let f = [[1.3, 0.4], [-0.2, 0.8]];
    let mut point = ReferenceDomain::<2>::default();
    point.initialise(&ground, &[0.37, 0.61]).unwrap();
    point.update_deformation(&[[f[0][0] - 1.0, f[0][1]], [f[1][0], f[1][1] - 1.0]], no_stretch);
    let mut unit = [[0.0; 2]; 2];
    point.support::<2, LinearBasis>(&ground, &[9.0, 9.0], &[0.1; 2]).for_each(&[5, 1], |number, _, g| {
        let node = [0.25 * (number / 5) as f64, 0.25 * (number % 5) as f64];
        for i in 0..2 {
            for j in 0..2 {
                unit[i][j] += (f[i][0] * node[0] + f[i][1] * node[1]) * g[j];
            }
        }
    });
    for i in 0..2 {
        for j in 0..2 {
            assert!((unit[i][j] - if i == j { 1.0 } else { 0.0 }).abs() < 1e-13, "{unit:?}");
        }
    }
    let again = ReferenceDomain::<2>::from_numbers(&numbers::<2>(point), no_stretch);
    assert_eq!(again, point);
}
