//! Tests of shapes against closed forms.

use super::*;

fn box2(min: [f64; 2], max: [f64; 2]) -> Shape {
    Shape::Box { min: min.to_vec(), max: max.to_vec() }
}

#[test]
fn volumes_are_those_of_the_closed_forms() {
    // A union has no closed form, even with a single shape.
    let near = |shape: &Shape, dimension: usize, exact: f64| {
        for shape in [shape.clone(), Shape::Union { shapes: vec![shape.clone()] }] {
            let found = shape.volume(dimension, false);
            assert!((found / exact - 1.0).abs() < 1e-3, "{shape:?}: {found} for {exact}");
        }
    };
    let ball = |dimension: usize| Shape::Ball { centre: vec![0.3; dimension], radius: 0.7 };
    for dimension in 1..=3 {
        near(&ball(dimension), dimension, ball(dimension).measure(dimension).unwrap());
    }
    for axis in 0..3 {
        let cylinder = Shape::Cylinder { base: [1.0; 3], axis, radius: 0.5, height: 2.0 };
        near(&cylinder, 3, cylinder.measure(3).unwrap());
    }
    let (from, cut) = (box2([0.0, 0.0], [2.0, 2.0]), box2([1.0, 1.0], [2.0, 2.0]));
    near(&Shape::Difference { from: Box::new(from), cut: Box::new(cut) }, 2, 3.0);
    // Ring from 1 m to 2 m: ∫ r dr.
    let ring = box2([1.0, 0.0], [2.0, 3.0]);
    assert!((ring.volume(2, true) - 4.5).abs() < 1e-9);
}

#[test]
fn a_difference_of_boxes_is_an_l() {
    let cut = Box::new(box2([1.0, 1.0], [3.0, 3.0]));
    let shape = Shape::Difference { from: Box::new(box2([0.0, 0.0], [2.0, 2.0])), cut };
    assert!(shape.contains(&[0.5, 1.5]) && shape.contains(&[1.5, 0.5]) && !shape.contains(&[1.5, 1.5]));
}

#[test]
fn a_polygon_contains_the_points_enclosed_by_its_edges() {
    let polygon =
        Shape::Polygon { vertices: vec![[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 1.0], [0.0, 3.0]].into() };
    assert!(polygon.validate(2).is_ok());
    assert_eq!(polygon.measure(2), Some(8.0));
    assert!(polygon.contains(&[2.0, 0.9]) && !polygon.contains(&[2.0, 1.1]) && polygon.contains(&[0.2, 2.5]));
    assert!(polygon.contains(&[4.0, 1.0]), "an edge belongs to the polygon");
}

#[test]
fn errors_name_the_value_within_a_combination() {
    let bad = Shape::Union {
        shapes: vec![box2([0.0; 2], [1.0; 2]), Shape::Ball { centre: vec![0.0, 0.0], radius: -1.0 }],
    };
    assert_eq!(bad.validate(2).unwrap_err().path, "shapes[1].radius");
    let crossed = Shape::Polygon { vertices: vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 2.0]].into() };
    assert!(crossed.validate(2).unwrap_err().problem.contains("cross"));
    assert_eq!(box2([0.0; 2], [1.0; 2]).validate(3).unwrap_err().path, "min");
    let inverted = Shape::Box { min: vec![1.0, 0.0], max: vec![0.0, 1.0] };
    assert_eq!(inverted.validate(2).unwrap_err().path, "max[0]");
}

#[test]
fn a_line_through_a_shape_is_inside_between_its_crossings() {
    let length = |shape: &Shape, point: [f64; 3], axis: usize| -> f64 {
        let mut cuts = shape.crossings(&point, axis);
        cuts.sort_by(f64::total_cmp);
        let inside = |pair: &&[f64]| {
            let mut middle = point;
            middle[axis] = 0.5 * (pair[0] + pair[1]);
            shape.contains(&middle)
        };
        cuts.windows(2).filter(inside).map(|pair| pair[1] - pair[0]).sum()
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} for {b}");
    let ball = Shape::Ball { centre: vec![0.0, 0.0, 1.0], radius: 5.0 };
    near(length(&ball, [3.0, 0.0, 1.0], 1), 8.0);
    near(length(&ball, [6.0, 0.0, 1.0], 1), 0.0);
    let cylinder = Shape::Cylinder { base: [0.0; 3], axis: 2, radius: 5.0, height: 2.0 };
    near(length(&cylinder, [3.0, 0.0, 1.0], 1), 8.0);
    near(length(&cylinder, [3.0, 0.0, 1.0], 2), 2.0);
    let polygon =
        Shape::Polygon { vertices: vec![[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 1.0], [0.0, 3.0]].into() };
    near(length(&polygon, [1.0, 0.5, 0.0], 1), 2.0);
    near(length(&polygon, [2.0, 2.0, 0.0], 0), 2.0);
    let both = Shape::Union { shapes: vec![box2([0.0, 0.0], [2.0, 2.0]), box2([1.0, 1.0], [3.0, 4.0])] };
    near(length(&both, [1.5, 0.0, 0.0], 1), 4.0);
    let hollow = Shape::Difference {
        from: Box::new(both),
        cut: Box::new(Shape::Ball { centre: vec![1.5, 2.0], radius: 0.5 }),
    };
    near(length(&hollow, [1.5, 0.0, 0.0], 1), 3.0);
}

#[test]
fn an_upright_cylinder_has_round_sections() {
    let shape = Shape::Cylinder { base: [0.0; 3], axis: 1, radius: 1.0, height: 2.0 };
    assert!(shape.contains(&[0.7, 1.9, 0.7]) && !shape.contains(&[0.8, 1.0, 0.8]));
    assert_eq!(shape.bounds(3), (vec![-1.0, 0.0, -1.0], vec![1.0, 2.0, 1.0]));
}
