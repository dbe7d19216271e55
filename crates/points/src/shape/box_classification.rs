//! Classification of a box as inside, outside or across a shape.

use crate::Shape;

/// Location of a box with respect to a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoxLocation {
    /// No point of the box is in the shape.
    Outside,
    /// Every point of the box is in the shape.
    Inside,
    /// The box may contain points of both kinds.
    Intersecting,
}

impl BoxLocation {
    /// Location of a box by two tests: wholly outside, wholly inside, otherwise across the boundary.
    fn from_tests(outside: bool, inside: bool) -> Self {
        match (outside, inside) {
            (true, _) => Self::Outside,
            (_, true) => Self::Inside,
            _ => Self::Intersecting,
        }
    }
}

impl Shape {
    /// Location of the box between the corners `low` and `high`. `Outside` and `Inside` are certain; `Intersecting` also results for some
    /// boxes that the boundary of a combination does not cut.
    pub fn classify_box(&self, low: &[f64], high: &[f64]) -> BoxLocation {
        match self {
            Self::Box { min, max } => {
                let mut sides = low.iter().zip(high).zip(min.iter().zip(max));
                let outside = sides.clone().any(|((l, h), (min, max))| h < min || l > max);
                let inside = sides.all(|((l, h), (min, max))| min <= l && h <= max);
                BoxLocation::from_tests(outside, inside)
            }
            Self::Ball { centre, radius } => {
                let axes = 0..low.len();
                let (near, far) = square_distance_range(axes, low, high, |c| centre[c]);
                BoxLocation::from_tests(near > radius * radius, far <= radius * radius)
            }
            Self::Polygon { vertices } | Self::ArcLayer { outline: vertices, .. } => {
                if vertices.any_edge_in_box(low, high, |a, b| edge_may_intersect_box(a, b, low, high)) {
                    return BoxLocation::Intersecting;
                }
                let inside = self.contains(&[0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])]);
                BoxLocation::from_tests(!inside, inside)
            }
            Self::Cylinder { base, axis, radius, height } => {
                let (near, far) = square_distance_range((0..3).filter(|c| c != axis), low, high, |c| base[c]);
                let (bottom, top) = (base[*axis], base[*axis] + height);
                let outside = near > radius * radius || high[*axis] < bottom || low[*axis] > top;
                let inside = far <= radius * radius && bottom <= low[*axis] && high[*axis] <= top;
                BoxLocation::from_tests(outside, inside)
            }
            Self::Layer { .. } | Self::Microstructure { .. } => {
                let (from, to) = self.bounds(low.len());
                let apart = (0..low.len()).any(|c| high[c] < from[c] || low[c] > to[c]);
                BoxLocation::from_tests(apart, false)
            }
            Self::Union { shapes } => {
                let mut places = shapes.iter().map(|shape| shape.classify_box(low, high));
                let outside = places.clone().all(|place| place == BoxLocation::Outside);
                BoxLocation::from_tests(outside, places.any(|place| place == BoxLocation::Inside))
            }
            Self::Intersection { shapes } => {
                let mut places = shapes.iter().map(|shape| shape.classify_box(low, high));
                let outside = places.clone().any(|place| place == BoxLocation::Outside);
                BoxLocation::from_tests(outside, places.all(|place| place == BoxLocation::Inside))
            }
            Self::Difference { from, cut } => {
                let (from, cut) = (from.classify_box(low, high), cut.classify_box(low, high));
                let outside = from == BoxLocation::Outside || cut == BoxLocation::Inside;
                BoxLocation::from_tests(outside, from == BoxLocation::Inside && cut == BoxLocation::Outside)
            }
        }
    }
}

/// Squares of the smallest and the largest distance from `centre` to the box, over some axes (m²).
fn square_distance_range(
    axes: impl Iterator<Item = usize>,
    low: &[f64],
    high: &[f64],
    centre: impl Fn(usize) -> f64,
) -> (f64, f64) {
    axes.fold((0.0, 0.0), |(near, far), c| {
        let (below, above) = (low[c] - centre(c), high[c] - centre(c));
        let closest = below.max(-above).max(0.0);
        (near + closest * closest, far + (below * below).max(above * above))
    })
}

/// Whether the edge from `a` to `b` may intersect the box, by the separating axis test.
fn edge_may_intersect_box(a: &[f64; 2], b: &[f64; 2], low: &[f64], high: &[f64]) -> bool {
    let apart = |c: usize| a[c].max(b[c]) < low[c] || a[c].min(b[c]) > high[c];
    if apart(0) || apart(1) {
        return false;
    }
    let normal = [b[1] - a[1], a[0] - b[0]];
    let corner = |x: f64, y: f64| normal[0] * (x - a[0]) + normal[1] * (y - a[1]);
    let sides =
        [corner(low[0], low[1]), corner(high[0], low[1]), corner(low[0], high[1]), corner(high[0], high[1])];
    !(sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn shapes() -> Vec<(usize, Shape)> {
        let ball = |dimension: usize| Shape::Ball { centre: vec![0.2; dimension], radius: 0.7 };
        let cube = |dimension: usize| Shape::Box { min: vec![-0.6; dimension], max: vec![0.3; dimension] };
        let polygon = Shape::Polygon {
            vertices: vec![[-0.8, -0.8], [0.9, -0.6], [0.7, 0.8], [0.0, -0.1], [-0.7, 0.6]].into(),
        };
        let mut all = vec![
            (2, polygon.clone()),
            (2, Shape::Difference { from: Box::new(polygon), cut: Box::new(ball(2)) }),
            (3, Shape::Cylinder { base: [0.1, -0.5, 0.0], axis: 1, radius: 0.6, height: 1.1 }),
        ];
        for dimension in 1..=3 {
            let both = vec![ball(dimension), cube(dimension)];
            all.push((dimension, ball(dimension)));
            all.push((dimension, cube(dimension)));
            all.push((dimension, Shape::Union { shapes: both.clone() }));
            all.push((dimension, Shape::Intersection { shapes: both }));
        }
        all
    }

    proptest! {
        #[test]
        fn points_of_a_box_agree_with_its_classification(
            corner in proptest::array::uniform3(-1.2..1.0f64), width in proptest::array::uniform3(1e-3..0.8f64),
            places in proptest::collection::vec(proptest::array::uniform3(0.0..=1.0f64), 30),
        ) {
            for (dimension, shape) in shapes() {
                let low = &corner[..dimension];
                let high: Vec<f64> = (0..dimension).map(|c| corner[c] + width[c]).collect();
                let place = shape.classify_box(low, &high);
                for t in &places {
                    let x: Vec<f64> = (0..dimension).map(|c| low[c] + t[c] * width[c]).collect();
                    prop_assert!(place == BoxLocation::Intersecting || shape.contains(&x) == (place == BoxLocation::Inside));
                }
            }
        }
    }

    #[test]
    fn small_boxes_away_from_the_boundary_are_classified_inside_or_outside() {
        for (dimension, shape) in shapes() {
            let (mut inside, mut outside) = (0, 0);
            for number in 0..40usize.pow(dimension as u32) {
                let low: Vec<f64> = (0..dimension)
                    .map(|c| -1.0 + 0.05 * (number / 40usize.pow(c as u32) % 40) as f64)
                    .collect();
                let high: Vec<f64> = low.iter().map(|l| l + 0.05).collect();
                match shape.classify_box(&low, &high) {
                    BoxLocation::Inside => inside += 1,
                    BoxLocation::Outside => outside += 1,
                    BoxLocation::Intersecting => {}
                }
            }
            assert!(inside > 0 && outside > 0, "{shape:?}");
        }
    }
}
