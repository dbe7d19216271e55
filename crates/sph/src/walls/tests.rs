//! Images and wall particles, compared with hand-drawn positions.

use crate::boundary::flat_wall::{FlatWall, WallContact};
use crate::boundary::flat_walls::FlatWalls;
use crate::boundary::image_particle::{ImageParticle, PeriodicAxis};
use crate::config::TimeHistory;

fn plane(axis: usize) -> FlatWall<2> {
    FlatWall {
        boundary: 0,
        axis,
        position: 0.0,
        is_upper: false,
        velocity: [0.0; 2],
        history: None,
        factor: 1.0,
        displacement: 0.0,
        contact: WallContact::FreeSlip,
    }
}

#[test]
fn images_in_rough_mirrors_have_opposite_velocity_and_equal_stress() {
    let rough = |axis| FlatWall { velocity: [0.5, 0.25], contact: WallContact::NoSlip, ..plane(axis) };
    let walls = FlatWalls::<2> { mirrors: vec![rough(1), plane(0)], ..FlatWalls::default() };
    let mut images = Vec::new();
    walls.images(&[[0.1, 0.2]], 1.0, &mut images);
    let found: Vec<_> =
        images.iter().map(|i| (i.axis_sign, i.velocity_sign, i.velocity_shift, i.stress_sign)).collect();
    let below = ([1.0, -1.0], [-1.0, -1.0], [1.0, 0.5], [1.0, 1.0]);
    let corner = ([-1.0, -1.0], [1.0, -1.0], [-1.0, 0.5], [-1.0, 1.0]);
    let beside = ([-1.0, 1.0], [-1.0, 1.0], [0.0, 0.0], [-1.0, 1.0]);
    assert_eq!(found, [below, corner, beside]);
}

#[test]
fn a_particle_in_a_corner_has_three_images() {
    let walls = FlatWalls::<2> { mirrors: vec![plane(0), plane(1)], ..FlatWalls::default() };
    let mut images = Vec::new();
    walls.images(&[[0.1, 0.2], [0.1, 5.0], [5.0, 5.0]], 1.0, &mut images);
    let mut flips: Vec<_> = images.iter().map(|image| (image.source, image.axis_sign)).collect();
    flips.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(flips, [(0, [-1.0, -1.0]), (0, [-1.0, 1.0]), (0, [1.0, -1.0]), (1, [-1.0, 1.0])]);
}

#[test]
fn images_of_a_moving_mirror_move_with_it() {
    let moving = FlatWall { velocity: [0.5, 3.0], ..plane(0) };
    let mut walls = FlatWalls::<2> { mirrors: vec![plane(1), moving], ..FlatWalls::default() };
    walls.move_to(2.0);
    let mut images = Vec::new();
    walls.images(&[[1.2, 0.3]], 1.0, &mut images);
    let of = |images: &[ImageParticle<2>]| {
        images.iter().map(|i| (i.axis_sign, i.shift, i.velocity_shift)).collect::<Vec<_>>()
    };
    let below = ([1.0, -1.0], [0.0, 0.0], [0.0, 0.0]);
    let around =
        |shift| [below, ([-1.0, -1.0], [shift, 0.0], [1.0, 0.0]), ([-1.0, 1.0], [shift, 0.0], [1.0, 0.0])];
    assert_eq!(of(&images), around(2.0));
    // Existing images move with the mirror.
    walls.move_to(3.0);
    walls.move_images(&mut images);
    assert_eq!(of(&images), around(3.0));
}

#[test]
fn the_position_of_a_moving_face_is_the_integral_of_its_velocity() {
    let history = TimeHistory { times: vec![1.0, 2.0, 4.0], factors: vec![0.0, 3.0, -1.0] };
    let varying = |axis, contact| FlatWall {
        velocity: [0.5, 0.25],
        history: Some(history.clone()),
        contact,
        ..plane(axis)
    };
    let mut walls = FlatWalls::<2>::new(
        vec![varying(1, WallContact::NoSlip)],
        vec![varying(0, WallContact::FreeSlip)],
        Vec::new(),
        ([0.0; 2], [1.0; 2]),
        0.1,
        0.24,
    );
    let mut images = Vec::new();
    walls.images(&[[0.5, 0.1]], 1.0, &mut images);
    let first = walls.particles[0][0];
    // Integral of the factor: 1.5 up to 2 s, and 2 more up to 4 s.
    for (time, area) in [(0.5, 0.0), (1.5, 0.375), (2.0, 1.5), (4.0, 3.5), (5.0, 2.5)] {
        walls.move_to(time);
        walls.move_images(&mut images);
        assert!((walls.faces[0].face() - 0.5 * area).abs() < 1e-15, "at {time} s");
        assert!((images[0].shift[1] - 0.5 * area).abs() < 1e-15, "at {time} s");
        let mut slots = vec![[0.0; 2]; walls.particles.len()];
        walls.place_particles(&mut slots);
        assert!((slots[0][0] - first - 0.5 * area).abs() < 1e-15, "at {time} s");
    }
    assert!(walls.update_time_histories(1.5, 3.0));
    walls.move_images(&mut images);
    let mean = (1.125 + 2.0) / 1.5;
    assert_eq!(walls.faces[0].mean_velocity(), [0.5 * mean, 0.25 * mean]);
    assert_eq!(images[0].velocity_shift, [mean, 0.5 * mean]);
    assert!(
        (walls.max_displacement(2.0, 5.0) - 0.5).abs() < 1e-15 && walls.max_displacement(0.0, 1.0) == 0.0
    );
}

#[test]
fn a_doubly_periodic_corner_has_three_images_and_a_mirror_joins_in() {
    let period = |axis| PeriodicAxis { axis, low: 0.0, high: 10.0 };
    let walls = FlatWalls::<2> { periods: vec![period(0), period(1)], ..FlatWalls::default() };
    let mut images = Vec::new();
    walls.images(&[[0.1, 9.9]], 1.0, &mut images);
    let mut shifts: Vec<_> = images.iter().map(|image| image.shift).collect();
    shifts.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(shifts, [[0.0, -10.0], [10.0, -10.0], [10.0, 0.0]]);
    let walls = FlatWalls::<2> { periods: vec![period(0)], mirrors: vec![plane(1)], ..FlatWalls::default() };
    walls.images(&[[0.1, 0.2]], 1.0, &mut images);
    assert_eq!(images.len(), 3);
    let (mut x, mut origin) = ([[-0.5, 1.0], [21.0, 1.0]], [[0.0, 0.0], [0.0, 0.0]]);
    walls.wrap_into_period(&mut x, &mut origin);
    assert_eq!((x, origin), ([[9.5, 1.0], [1.0, 1.0]], [[10.0, 0.0], [-20.0, 0.0]]));
}

#[test]
fn walls_of_particles_share_their_corner() {
    let box_ = ([0.0, 0.0], [1.0, 1.0]);
    let walls = FlatWalls::<2>::new(Vec::new(), vec![plane(0), plane(1)], Vec::new(), box_, 0.1, 0.24);
    // Three layers along both edges, one square of nine at each of the ends.
    assert_eq!(walls.particles.len(), 3 * 16 + 3 * 13);
    let mut sites: Vec<_> = walls.particles.iter().map(|x| x.map(|c| (c * 100.0).round() as i64)).collect();
    sites.sort_unstable();
    sites.dedup();
    assert_eq!(sites.len(), walls.particles.len());
}

#[test]
fn wall_particles_continue_across_a_periodic_boundary() {
    let periods = vec![PeriodicAxis { axis: 0, low: 0.0, high: 1.0 }];
    let walls = FlatWalls::<2>::new(Vec::new(), vec![plane(1)], periods, ([0.0, 0.0], [1.0, 1.0]), 0.1, 0.24);
    for x in &walls.particles {
        let image = [if x[0] < 0.5 { x[0] + 1.0 } else { x[0] - 1.0 }, x[1]];
        let near = |y: &[f64; 2]| (y[0] - image[0]).hypot(y[1] - image[1]) < 1e-9;
        assert!(image[0] < -0.3 || image[0] > 1.3 || walls.particles.iter().any(near), "{image:?}");
    }
}
