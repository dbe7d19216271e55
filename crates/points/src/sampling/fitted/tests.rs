use std::f64::consts::PI;

use super::*;

fn ball(x: f64, y: f64, radius: f64) -> Shape {
    Shape::Ball { centre: vec![x, y], radius }
}

fn rectangle(min: [f64; 2], max: [f64; 2]) -> Shape {
    Shape::Box { min: min.to_vec(), max: max.to_vec() }
}

fn difference(from: Shape, cut: Shape) -> Shape {
    Shape::Difference { from: Box::new(from), cut: Box::new(cut) }
}

fn ring() -> Shape {
    difference(ball(0.3, -0.2, 2.0), ball(0.3, -0.2, 1.0))
}

fn plate() -> Shape {
    difference(rectangle([-3.0, -2.5], [3.0, 2.5]), ball(0.2, 0.1, 1.0))
}

/// Distance to the nearest other point (m).
fn nearest(samples: &[Sample<2>], i: usize) -> f64 {
    let apart = |other: &Sample<2>| {
        (other.position[0] - samples[i].position[0]).hypot(other.position[1] - samples[i].position[1])
    };
    let others = samples.iter().enumerate().filter(|(j, _)| *j != i);
    others.map(|(_, other)| apart(other)).fold(f64::INFINITY, f64::min)
}

#[test]
fn areas_and_their_moments_are_those_of_the_shape() {
    let corner = difference(rectangle([0.0, 0.0], [3.0, 2.0]), ball(0.0, 0.0, 1.0));
    let askew =
        Shape::Polygon { vertices: vec![[0.0, 0.0], [2.0, 1.0], [1.7, 2.2], [0.9, 1.1], [-0.4, 1.5]].into() };
    let quarter = Shape::Intersection {
        shapes: vec![difference(ball(0.0, 0.0, 2.0), ball(0.0, 0.0, 1.0)), rectangle([0.0, 0.0], [3.0, 3.0])],
    };
    let holes =
        difference(plate(), Shape::Union { shapes: vec![ball(-2.0, -1.5, 0.4), ball(2.3, 1.8, 0.3)] });
    for shape in [ball(0.0, 0.0, 1.0), ring(), plate(), corner, askew, quarter, holes] {
        for spacing in [0.1, 0.137, 0.06] {
            let samples = fitted_rows::<2>(&shape, [0.013, -0.02], spacing).unwrap();
            let sides = shape.boundary_edges().unwrap();
            let mut exact = crate::shape::SectorMoments::default();
            sides.iter().for_each(|side| exact.add(&side.sector_moments([0.0; 2])));
            let sum = |of: &dyn Fn(&Sample<2>) -> f64| samples.iter().map(of).sum::<f64>();
            assert!((sum(&|s| s.volume) - exact.area).abs() < 1e-11, "{shape:?}");
            for c in 0..2 {
                let moment = sum(&|s| s.volume * s.position[c]);
                assert!((moment - exact.first[c]).abs() < 1e-10, "{shape:?}: {moment} for {:?}", exact.first);
            }
            let square = spacing * spacing;
            for (i, sample) in samples.iter().enumerate() {
                let (share, apart) = (sample.volume / square, nearest(&samples, i) / spacing);
                assert!(
                    (0.3..1.9).contains(&share) && (0.5..1.3).contains(&apart),
                    "{shape:?}: {share} {apart} at {:?}",
                    sample.position
                );
                assert!(shape.contains(&sample.position));
            }
            let mean = exact.area / square / samples.len() as f64;
            assert!((0.9..1.1).contains(&mean), "{shape:?} at {spacing}: {mean}");
        }
    }
}

#[test]
fn rows_follow_round_sides_at_half_a_spacing() {
    let spacing = 0.1;
    for (shape, [x, y], rows) in [(ring(), [0.3, -0.2], 10), (plate(), [0.2, 0.1], 5)] {
        let samples = fitted_rows::<2>(&shape, [0.0; 2], spacing).unwrap();
        let radii: Vec<f64> = samples.iter().map(|s| (s.position[0] - x).hypot(s.position[1] - y)).collect();
        for row in 0..rows {
            let radius = 1.0 + (f64::from(row) + 0.5) * spacing;
            let of_row = radii.iter().filter(|r| (*r - radius).abs() < 0.3 * spacing).count();
            assert_eq!(of_row, (2.0 * PI * radius / spacing).round() as usize, "row {row} of {shape:?}");
        }
        let first = radii.iter().filter(|r| **r < 1.08);
        assert!(first.clone().all(|r| (r - 1.05).abs() < 0.01), "{:?}", first.collect::<Vec<_>>());
    }
}

#[test]
fn a_box_of_whole_spacings_is_the_lattice_and_another_a_stretched_one() {
    let samples = fitted_rows::<2>(&rectangle([0.2, 0.1], [0.7, 0.5]), [0.0; 2], 0.1).unwrap();
    let lattice = super::super::lattice::<2>(&rectangle([0.2, 0.1], [0.7, 0.5]), [0.0; 2], 0.1).unwrap();
    assert_eq!(samples.len(), lattice.len());
    for (a, b) in samples.iter().zip(&lattice) {
        assert!(
            (0..2).all(|c| (a.position[c] - b.position[c]).abs() < 1e-12)
                && (a.volume - b.volume).abs() < 1e-14
        );
    }
    let samples = fitted_rows::<2>(&rectangle([0.0, 0.0], [1.03, 0.44]), [0.05, 0.0], 0.1).unwrap();
    assert_eq!(samples.len(), 40);
    assert!(samples.iter().all(|s| (s.volume - 0.103 * 0.11).abs() < 1e-12));
}

#[test]
fn a_turned_box_has_rows_along_its_sides() {
    let (sine, cosine) = 0.5f64.sin_cos();
    let corner = |x: f64, y: f64| [cosine * x - sine * y, sine * x + cosine * y];
    let shape = Shape::Polygon {
        vertices: vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 0.5), corner(0.0, 0.5)].into(),
    };
    let samples = fitted_rows::<2>(&shape, [0.0; 2], 0.1).unwrap();
    assert_eq!(samples.len(), 50);
    for sample in &samples {
        let y = -sine * sample.position[0] + cosine * sample.position[1];
        assert!((sample.volume - 0.01).abs() < 1e-12 && ((y / 0.1).fract() - 0.5).abs() < 1e-9);
    }
}

#[test]
fn shapes_without_a_fitted_sampling_are_refused() {
    assert_eq!(
        fitted_rows::<3>(&Shape::Ball { centre: vec![0.0; 3], radius: 1.0 }, [0.0; 3], 0.1),
        Err(SamplingError::NoBoundaryEdges)
    );
    assert!(matches!(fitted_rows::<2>(&ball(0.0, 0.0, 1.0), [0.0; 2], 1e-6), Err(SamplingError::TooMany(_))));
    // A thin spike with no point near it.
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.4995], [4.0, 0.5], [1.0, 0.5005], [1.0, 1.0], [0.0, 1.0]];
    let spike = Shape::Polygon { vertices: corners.to_vec().into() };
    let Err(SamplingError::TooThin { lost, .. }) = fitted_rows::<2>(&spike, [0.0; 2], 0.1) else {
        panic!("a point in a spike")
    };
    assert!((1e-3..1.5e-3).contains(&lost), "{lost}");
}

#[test]
fn a_disk_smaller_than_a_spacing_is_one_point() {
    let samples = fitted_rows::<2>(&ball(0.31, 0.2, 0.04), [0.0; 2], 0.1).unwrap();
    assert_eq!(samples.len(), 1);
    assert!((samples[0].volume - PI * 0.0016).abs() < 1e-15);
    assert!((samples[0].position[0] - 0.31).abs() < 1e-12 && (samples[0].position[1] - 0.2).abs() < 1e-12);
}
