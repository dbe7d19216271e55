use crate::boundary::walls::*;

fn floor(kind: WallKind, separation: bool) -> NodeWall {
    NodeWall { axis: 1, is_upper: false, node: 0, kind, separation, velocity: [0.0; 3] }
}

/// Walls with this one only.
fn single_wall(wall: NodeWall) -> NodeWalls {
    NodeWalls::new(&[1; 3], vec![wall])
}

fn constrain_velocity(
    wall: NodeWall,
    start: &mut [f64; 3],
    end: &mut [f64; 3],
    keep_start: bool,
    lift: &[f64; 3],
) {
    single_wall(wall).constrain_skeleton(&[0; 3], start, end, keep_start, lift);
}

/// Every kind of wall on each axis, and a node that approaches some of them.
#[test]
fn edges_are_independent_of_the_order_of_axes() {
    let kinds = [
        None,
        Some((WallKind::Rough, true)),
        Some((WallKind::Smooth, false)),
        Some((WallKind::Smooth, true)),
        Some((WallKind::Frictional { coefficient: 0.3 }, true)),
        Some((WallKind::Frictional { coefficient: 0.7 }, false)),
        Some((WallKind::StaticAndSliding { static_coefficient: 0.6, sliding_coefficient: 0.4 }, true)),
    ];
    let turned = |v: [f64; 3]| [v[2], v[0], v[1]];
    let (start, end) = ([0.4, -0.1, 0.2], [1.3, -0.8, -0.5]);
    for code in 0..kinds.len().pow(3) {
        let wall = |axis: usize, place: usize| {
            let (kind, separation) = kinds[code / kinds.len().pow(axis as u32) % kinds.len()]?;
            Some(NodeWall { axis: place, ..floor(kind, separation) })
        };
        let here = NodeWalls::new(&[1; 3], (0..3).filter_map(|axis| wall(axis, axis)).collect());
        let there = NodeWalls::new(&[1; 3], (0..3).filter_map(|axis| wall(axis, (axis + 1) % 3)).collect());
        for keep_start in [false, true] {
            let (mut from, mut to) = (start, end);
            here.constrain(&[0; 3], &mut from, &mut to, keep_start);
            let (mut from_turned, mut to_turned) = (turned(start), turned(end));
            there.constrain(&[0; 3], &mut from_turned, &mut to_turned, keep_start);
            let distance = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
            assert!(distance(turned(from), from_turned) < 1e-15, "{here:?}: {from:?}, {from_turned:?}");
            assert!(distance(turned(to), to_turned) < 1e-15, "{here:?}: {to:?}, {to_turned:?}");
        }
    }
}

#[test]
fn force_carried_by_a_smooth_side_does_not_cause_slip_on_the_floor() {
    for [side, floor, along] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        let wall = |axis, kind, separation| NodeWall {
            axis,
            is_upper: false,
            node: 0,
            kind,
            separation,
            velocity: [0.0; 3],
        };
        let smooth = wall(side, WallKind::Smooth, false);
        let walls = NodeWalls::new(
            &[1; 3],
            vec![smooth, wall(floor, WallKind::Frictional { coefficient: 0.5 }, true)],
        );
        let mut end = [0.0; 3];
        (end[side], end[floor], end[along]) = (9.0, -1.0, 0.4);
        walls.constrain(&[0; 3], &mut [0.0; 3], &mut end, false);
        assert_eq!(end, [0.0; 3], "0.4 is less than 0.5 × 1: it sticks, whatever pushes it to the side");
    }
}

#[test]
fn friction_reduces_tangential_velocity_by_the_coulomb_share_of_the_normal_impulse() {
    let wall = floor(WallKind::Frictional { coefficient: 0.5 }, true);
    let (mut start, mut end) = ([3.0, 0.0, 4.0], [3.0, -2.0, 4.0]);
    constrain_velocity(wall, &mut start, &mut end, true, &[0.0; 3]);
    // |v_t| = 5 is reduced by 0.5 × 2.
    assert!((end[0] - 3.0 * 0.8).abs() < 1e-15 && end[1] == 0.0 && (end[2] - 4.0 * 0.8).abs() < 1e-15);
    let mut end = [0.3, -2.0, 0.4];
    constrain_velocity(wall, &mut start, &mut end, true, &[0.0; 3]);
    assert_eq!(end, [0.0; 3], "slower than the friction allows: it sticks");
}

#[test]
fn a_frictional_plane_follows_the_algorithm_of_the_sheet() {
    // Normal impulse of 2 m/s on the floor in the step; (start, end along it, expected end).
    let wall = floor(WallKind::StaticAndSliding { static_coefficient: 0.5, sliding_coefficient: 0.25 }, true);
    let table = [
        ([0.0, 0.0], [0.6, 0.8], [0.0, 0.0]), // at rest: 1 is not more than 0.5 × 2
        ([0.0, 0.0], [3.0, 4.0], [2.4, 3.2]), // sets off: 5 - 0.5 × 2
        ([3.0, 4.0], [3.0, 4.0], [2.7, 3.6]), // slides: 5 - 0.25 × 2
        ([3.0, 4.0], [0.3, 0.4], [0.0, 0.0]), // comes to rest: 0.5 is not more than 0.25 × 2
        ([0.0, 5.0], [3.0, 4.0], [2.7, 3.6]), // friction is along the speed it would end with
    ];
    for (before, after, expected) in table {
        for (approach, keep_start) in [(0.0, false), (0.7, true)] {
            let mut start = [before[0], -approach, before[1]];
            let mut end = [after[0], -approach - 2.0, after[1]];
            constrain_velocity(wall, &mut start, &mut end, keep_start, &[0.0; 3]);
            let close = |a: f64, b: f64| (a - b).abs() < 1e-15;
            assert!(close(end[0], expected[0]) && end[1] == 0.0 && close(end[2], expected[1]), "{end:?}");
            assert_eq!(start[1], -approach, "left, or without acceleration");
        }
    }
    // It approaches the wall without acceleration into it: stopped, without friction.
    let mut end = [3.0, -0.5, 0.0];
    constrain_velocity(wall, &mut [3.0, -0.7, 0.0], &mut end, true, &[0.0; 3]);
    assert_eq!(end, [3.0, 0.0, 0.0]);
}

#[test]
fn force_carried_by_pore_pressure_causes_no_friction() {
    for (kind, friction) in [
        (WallKind::Frictional { coefficient: 0.5 }, 0.5 * (2.0 - 1.5)),
        (
            WallKind::StaticAndSliding { static_coefficient: 0.5, sliding_coefficient: 0.25 },
            0.25 * (2.0 - 1.5),
        ),
    ] {
        let mut end = [3.0, -2.0, 0.0];
        constrain_velocity(floor(kind, true), &mut [3.0, 0.0, 0.0], &mut end, false, &[0.0, 1.5, 0.0]);
        assert!((end[0] - (3.0 - friction)).abs() < 1e-15 && end[1] == 0.0, "{kind:?}: {end:?}");
        // The pore pressure takes all: the wall stops without friction. From above its sign is the opposite.
        let mut end = [3.0, -2.0, 0.0];
        constrain_velocity(floor(kind, true), &mut [3.0, 0.0, 0.0], &mut end, false, &[0.0, 2.5, 0.0]);
        assert_eq!(end, [3.0, 0.0, 0.0], "{kind:?}");
        let mut end = [3.0, 2.0, 0.0];
        let ceiling = NodeWall { is_upper: true, ..floor(kind, true) };
        constrain_velocity(ceiling, &mut [3.0, 0.0, 0.0], &mut end, false, &[0.0, -1.5, 0.0]);
        assert!((end[0] - (3.0 - friction)).abs() < 1e-15 && end[1] == 0.0, "{kind:?}: {end:?}");
    }
}

#[test]
fn the_last_of_many_walls_constrains_its_nodes() {
    let many = (0..300).map(|node| NodeWall { node, ..floor(WallKind::Smooth, false) }).rev().collect();
    let walls = NodeWalls::new(&[1, 400], many);
    assert_eq!(walls.wall_at(1, &[0, 0, 0]).map(|wall| wall.node), Some(0));
    assert_eq!(walls.wall_at(1, &[0, 299, 0]).map(|wall| wall.node), Some(299));
    assert_eq!(walls.wall_at(1, &[0, 300, 0]), None);
}

#[test]
fn unilateral_walls_permit_separation() {
    let plane = WallKind::StaticAndSliding { static_coefficient: 1.0, sliding_coefficient: 0.5 };
    for kind in [WallKind::Rough, WallKind::Smooth, WallKind::Frictional { coefficient: 1.0 }, plane] {
        let mut end = [1.0, 0.5, 0.0];
        constrain_velocity(floor(kind, true), &mut [0.0; 3], &mut end, true, &[0.0; 3]);
        assert_eq!(end, [1.0, 0.5, 0.0]);
    }
}

#[test]
fn bilateral_walls_prevent_separation_without_friction() {
    let plane = WallKind::StaticAndSliding { static_coefficient: 1.0, sliding_coefficient: 0.5 };
    for kind in [WallKind::Frictional { coefficient: 0.5 }, plane] {
        let wall = floor(kind, false);
        let (mut start, mut end) = ([3.0, 0.1, 4.0], [3.0, 2.0, 4.0]);
        constrain_velocity(wall, &mut start, &mut end, true, &[0.0; 3]);
        assert_eq!((start, end), ([3.0, 0.1, 4.0], [3.0, 0.0, 4.0]), "pulled: {kind:?}");
        constrain_velocity(wall, &mut [3.0, 0.0, 4.0], &mut end, false, &[0.0, 1.0, 0.0]);
        assert_eq!(end, [3.0, 0.0, 4.0], "the fluid pushes it off: {kind:?}");
        // Normal impulse of 2 m/s in the step: as for every wall with friction.
        let (mut start, mut pushed) = ([3.0, 0.0, 4.0], [3.0, -2.0, 4.0]);
        constrain_velocity(wall, &mut start, &mut pushed, true, &[0.0; 3]);
        assert!((pushed[0] - 2.4).abs() < 1e-15 && pushed[1] == 0.0 && (pushed[2] - 3.2).abs() < 1e-15);
        assert_eq!(wall.free_components(), [1.0, 0.0, 1.0]);
        assert_eq!(floor(kind, true).free_components(), [1.0; 3]);
        // Re-mapped, and (solved with NaN) before the solve.
        for solved in [[3.0, 0.0, 4.0], [f64::NAN; 3]] {
            let mut velocity = [1.0, 0.2, 0.0];
            single_wall(wall).constrain_remapped(&[0; 3], &solved, &mut velocity);
            assert_eq!(velocity, [1.0, 0.0, 0.0], "{kind:?}");
        }
    }
    // The acceleration form depends on the acceleration into the wall, though the node still separates.
    let (mut start, mut end) = ([3.0, 2.0, 4.0], [3.0, 0.5, 4.0]);
    constrain_velocity(floor(plane, false), &mut start, &mut end, false, &[0.0; 3]);
    assert!((end[0] - 3.0 * 0.85).abs() < 1e-15 && end[1] == 0.0 && start[1] == 0.0, "{end:?}");
}

#[test]
fn constrained_components_follow_sticking_sliding_and_separation() {
    let frictional = floor(WallKind::Frictional { coefficient: 0.5 }, true);
    assert_eq!(frictional.constrained_components(&[0.0; 3]), [true; 3], "sticks");
    assert_eq!(frictional.constrained_components(&[1.0, 0.0, 0.0]), [false, true, false], "slides");
    assert_eq!(frictional.constrained_components(&[0.0, 0.1, 0.0]), [false; 3], "lifts off");
    assert_eq!(floor(WallKind::Smooth, true).constrained_components(&[0.0; 3]), [false, true, false]);
    assert_eq!(floor(WallKind::Smooth, false).constrained_components(&[1.0, 2.0, 3.0]), [false, true, false]);
    assert_eq!(floor(WallKind::Rough, false).constrained_components(&[1.0, 2.0, 3.0]), [true; 3]);
}

#[test]
fn nodes_in_contact_after_the_solve_do_not_separate_in_remapping() {
    let wall = floor(WallKind::Frictional { coefficient: 0.5 }, true);
    for (solved, remapped, expected) in [
        ([1.0, 0.0, 0.0], [1.1, 0.2, 0.0], [1.1, 0.0, 0.0]), // slides
        ([0.0, 0.0, 0.0], [0.1, 0.2, 0.3], [0.0, 0.0, 0.0]), // sticks
        ([1.0, 0.3, 0.0], [1.1, 0.2, 0.0], [1.1, 0.2, 0.0]), // lifts off
        ([1.0, 0.3, 0.0], [1.1, -0.2, 0.0], [1.1, 0.0, 0.0]), // may not come back
    ] {
        let mut velocity = remapped;
        single_wall(wall).constrain_remapped(&[0; 3], &solved, &mut velocity);
        assert_eq!(velocity, expected);
    }
}

#[test]
fn the_force_variant_leaves_no_acceleration_on_a_held_node() {
    let (mut start, mut end) = ([1.0, -0.1, 0.0], [2.0, -0.7, 0.0]);
    constrain_velocity(floor(WallKind::Smooth, false), &mut start, &mut end, false, &[0.0; 3]);
    assert_eq!((start, end), ([1.0, 0.0, 0.0], [2.0, 0.0, 0.0]));
    constrain_velocity(floor(WallKind::Rough, false), &mut start, &mut end, false, &[0.0; 3]);
    assert_eq!((start, end), ([0.0; 3], [0.0; 3]));
}

#[test]
fn a_bilateral_wall_without_friction_is_a_smooth_one() {
    let plane = WallKind::StaticAndSliding { static_coefficient: 0.0, sliding_coefficient: 0.0 };
    for kind in [WallKind::Frictional { coefficient: 0.0 }, plane] {
        for (keep_start, normal) in [(false, -0.7), (false, 0.7), (true, -0.7), (true, 0.7)] {
            let ends = [kind, WallKind::Smooth].map(|kind| {
                let (mut start, mut end) = ([1.0, -0.1, 0.0], [2.0, normal, 0.3]);
                constrain_velocity(floor(kind, false), &mut start, &mut end, keep_start, &[0.0; 3]);
                (start, end)
            });
            assert_eq!(ends[0], ends[1], "{kind:?}, momentum variant: {keep_start}");
        }
    }
}

#[test]
fn lookup_covers_everything_beyond_the_face() {
    let upper = NodeWall { is_upper: true, node: 3, axis: 0, ..floor(WallKind::Rough, false) };
    let walls = NodeWalls::new(&[6, 5], vec![floor(WallKind::Smooth, false), upper]);
    assert!(walls.wall_at(1, &[2, 0, 0]).is_some() && walls.is_row_free(1, 1));
    assert!(
        walls.is_row_free(0, 2)
            && walls.wall_at(0, &[3, 1, 0]) == walls.wall_at(0, &[5, 1, 0])
            && !walls.is_row_free(0, 5)
    );
}
