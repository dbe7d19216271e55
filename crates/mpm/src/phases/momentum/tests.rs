//! Tests of the momentum solve of both phases.

use super::*;
use crate::phases::damping::Damping;
use colluvium_grid::{Grid, LinearBasis, NodeWall, WallKind};

/// Node of masses 1590, 400 (liquid) and 1000 kg, with a drag of k = 10⁻³ m/s.
fn moving_node(solid: [f64; 3], liquid: [f64; 3]) -> [NodalState; 2] {
    let lanes = |v: [f64; 3], m: f64| Vector4::new([v[0] * m, v[1] * m, v[2] * m, m]);
    [
        NodalState {
            momentum_and_mass: lanes(solid, 1590.0),
            force: Vector4::new([0.0, 0.0, 0.0, 0.4 * 9.81e6]),
        },
        NodalState { momentum_and_mass: lanes(liquid, 400.0), force: Vector4::new([0.0, 0.0, 0.0, 1000.0]) },
    ]
}

/// The nodes of one cell, of which the tests use the first.
fn cell<const D: usize>() -> Layout<D> {
    Layout::new::<2, LinearBasis>(&Grid::new([0.0; D], [1.0; D], 1.0).unwrap())
}

fn solve<'a>(layout: &'a Layout<3>, walls: [&'a NodeWalls; 2], audit: bool) -> PhaseSolve<'a, 3> {
    PhaseSolve {
        dt: 1e-5,
        gravity: [0.0, -10.0, 0.0],
        keep_initial_velocity: false,
        inertia: 1.0,
        mass_cutoff: [0.0; 2],
        sum_equilibrium: audit,
        constrained_components: &[],
        walls,
        layout,
    }
}

#[test]
fn drag_slows_the_liquid_and_keeps_momentum() {
    let walls = NodeWalls::new(&[1, 1, 1], Vec::new());
    for audit in [false, true] {
        let mut line = [moving_node([1.0, 0.0, 0.0], [3.0, 0.0, 0.5])];
        solve(&cell(), [&walls, &walls], audit).row(0, 0..1, &mut line);
        let [solid, liquid] = line[0].map(|n| n.momentum_and_mass.to_array());
        // the difference shrinks by 1 - a dt, a = n rho g / ((1-n) rho_S k) = 4911.17 1/s (the sheet prints
        // 4910.6); gravity acts on both alike.
        let keep = 1.0 - 0.4 * 1990.0 * 9.81 / (1590.0 * 1e-3) * 1e-5;
        assert!(((liquid[0] - solid[0]) / 2.0 - keep).abs() < 1e-12, "{audit}");
        assert!((liquid[1] - solid[1]).abs() < 1e-15 && (liquid[1] + 1e-4).abs() < 1e-15);
        assert!((1590.0 * solid[0] + 400.0 * liquid[0] - 2790.0).abs() < 1e-9);
        assert!((1590.0 * solid[2] + 400.0 * liquid[2] - 200.0).abs() < 1e-9);
        assert_eq!((solid[3], liquid[3]), (1590.0, 400.0));
    }
}

#[test]
fn an_impermeable_wall_excludes_the_held_liquid_from_the_mixture_equation() {
    let free = NodeWalls::new(&[1, 1, 1], Vec::new());
    let wall = NodeWall {
        axis: 1,
        is_upper: false,
        node: 0,
        kind: WallKind::Smooth,
        separation: false,
        velocity: [0.0; 3],
    };
    let held = NodeWalls::new(&[1, 1, 1], vec![wall]);
    let mut line = [moving_node([0.0; 3], [0.0; 3])];
    solve(&cell(), [&free, &held], false).row(0, 0..1, &mut line);
    let [solid, liquid] = line[0].map(|n| n.force.to_array());
    assert_eq!(liquid[1], 0.0);
    // The skeleton carries the weight of both.
    assert!((solid[1] + 10.0 * 1990.0 / 1590.0).abs() < 1e-11);
}

#[test]
fn a_node_without_liquid_moves_as_a_single_phase() {
    let walls = NodeWalls::new(&[1, 1, 1], Vec::new());
    for audit in [false, true] {
        let [mut solid, _] = moving_node([1.0, 0.0, 0.0], [0.0; 3]);
        solid.force = Vector4::ZERO;
        let mut line = [[solid, NodalState::default()]];
        solve(&cell(), [&walls, &walls], audit).row(0, 0..1, &mut line);
        assert_eq!(line[0][SOLID].force.to_array(), [0.0, -10.0, 0.0, 0.0]);
        assert_eq!(line[0][LIQUID], NodalState::default());
    }
}

#[test]
fn damping_depends_on_the_unbalanced_force_on_the_mixture_and_leaves_seepage_unchanged() {
    // sheet: mpm §2.13: force on the mixture -19 900 + 5000 N, its momentum 1590 × 2 - 400 kg m/s.
    let free = NodeWalls::new(&[1, 1, 1], Vec::new());
    let cell = cell();
    let act = |force: f64, factor: f64| {
        let [mut solid, mut liquid] = moving_node([2.0, 0.0, 0.0], [-1.0, 0.0, 0.0]);
        solid.force = Vector4::new([force, 0.0, 0.0, 0.4 * 9.81e6]);
        liquid.force = Vector4::new([0.0, 0.0, 0.0, 1000.0]);
        let mut line = [[solid, liquid]];
        let solve = PhaseSolve { gravity: [-10.0, 0.0, 0.0], ..solve(&cell, [&free, &free], false) };
        solve.row(0, 0..1, &mut line);
        let PhaseSolve { dt, mass_cutoff: light, constrained_components: held, walls, layout, .. } = solve;
        Damping { dt, factors: [factor; 3], mass_cutoff: light, constrained_components: held, walls, layout }
            .row(0, 0..1, &mut line);
        line[0].map(|n| n.force.to_array()[0])
    };
    let (plain, damped) = (act(5000.0, 0.0), act(5000.0, 0.5));
    // Accelerations are differences of velocities over the step: round-off over 1e-5 s.
    for phase in [SOLID, LIQUID] {
        let change = damped[phase] - plain[phase];
        assert!((change + 0.5 * 14_900.0 / 1990.0).abs() < 1e-8, "{phase}: {change}");
    }
    // Motion by drag alone, in a mixture in balance, is not damped.
    let (plain, damped) = (act(19_900.0, 0.0), act(19_900.0, 0.5));
    assert!(plain[LIQUID].abs() > 1e3);
    assert!((0..2).all(|phase| (damped[phase] - plain[phase]).abs() < 1e-8), "{plain:?} {damped:?}");
}

#[test]
fn scaled_inertia_leaves_weight_and_drag_unchanged() {
    let free = NodeWalls::new(&[1, 1, 1], Vec::new());
    for audit in [false, true] {
        let [plain, heavy] = [1.0, 9.0].map(|inertia| {
            let mut line = [moving_node([1.0, 0.0, 0.0], [3.0, 0.0, 0.5])];
            PhaseSolve { inertia, ..solve(&cell(), [&free, &free], audit) }.row(0, 0..1, &mut line);
            line[0].map(|n| n.force.to_array())
        });
        for phase in [SOLID, LIQUID] {
            for c in 0..3 {
                let (a, b) = (plain[phase][c], heavy[phase][c]);
                assert!((a - 9.0 * b).abs() < 1e-12 * a.abs().max(1.0), "{a}, {b}, {audit}");
            }
        }
    }
}

/// Largest speed over the one at the start in `steps` steps of one lumped element of fixed length, whose ends are
/// free.
fn growth((n, grains, modulus, bulk, k, length): Element, dt: f64, steps: usize) -> f64 {
    let (walls, layout) = (NodeWalls::new(&[2], Vec::new()), cell());
    let solve = PhaseSolve::<1> {
        dt,
        gravity: [0.0; 3],
        keep_initial_velocity: false,
        inertia: 1.0,
        mass_cutoff: [0.0; 2],
        sum_equilibrium: false,
        constrained_components: &[],
        walls: [&walls, &walls],
        layout: &layout,
    };
    let fluid = crate::points::pore_fluid::PoreFluidConstants {
        density: 1000.0,
        bulk_modulus: bulk,
        porosity: n,
        resistance: 9810.0 / k,
        min_pressure: f64::NEG_INFINITY,
    };
    let half = 0.5 * length;
    let masses = [(1.0 - n) * grains, n * fluid.density].map(|density| density * half);
    let mut velocities = [[1e-6, -2e-6], [-1e-6, 2e-6]];
    let (mut stress, mut pressure, mut largest) = (0.0, 0.0, 0f64);
    for _ in 0..steps {
        let mut line = [[NodalState::default(); 2]; 2];
        for (end, sign) in [(0, 1.0), (1, -1.0)] {
            let motion = |phase: usize| {
                let momentum = masses[phase] * velocities[end][phase];
                Vector4::new([momentum, 0.0, 0.0, masses[phase]])
            };
            let of_solid = Vector4::new([sign * (stress - pressure), 0.0, 0.0, n * fluid.resistance * half]);
            let of_liquid = Vector4::new([-sign * pressure, 0.0, 0.0, fluid.density * half]);
            line[end] = [
                NodalState { momentum_and_mass: motion(SOLID), force: of_solid },
                NodalState { momentum_and_mass: motion(LIQUID), force: of_liquid },
            ];
            // A row is a line of nodes across the first axis: in one dimension a single one.
            solve.row(end, 0..1, &mut line[end..=end]);
            velocities[end] = line[end].map(|node| node.momentum_and_mass.to_array()[0]);
        }
        let strain = |phase: usize| dt * (velocities[1][phase] - velocities[0][phase]) / length;
        stress += modulus * strain(SOLID);
        pressure = fluid.pressure_after(pressure, n, strain(SOLID), strain(LIQUID));
        largest = velocities.as_flattened().iter().fold(largest, |a, v| a.max(v.abs() / 1e-6));
    }
    largest
}

/// Porosity, density of grains, moduli of skeleton and fluid, conductivity, length.
type Element = (f64, f64, f64, f64, f64, f64);

#[test]
fn one_element_is_stable_below_the_exact_step_and_not_above_it() {
    // sheet: mpm §2.10: the exact limit of a single lumped element.
    let table: [(Element, f64); 7] = [
        ((0.4, 2650.0, 1e7, 2.15e9, 1e-3, 0.1), 5.368209e-5),
        ((0.4, 2650.0, 1e7, 2.15e9, 1e-5, 0.1), 4.067833e-6),
        ((0.4, 2650.0, 1e7, 2.15e9, 1e-7, 0.1), 4.072349e-8),
        ((0.4, 2650.0, 5e9, 2.0e9, 1e-2, 0.05), 2.230461e-5),
        ((0.4, 2650.0, 5e9, 2.0e9, 1e-5, 0.05), 4.039088e-6),
        ((0.3, 2700.0, 1e8, 3e9, 1e-4, 0.01), 4.190370e-6),
        ((0.4, 2650.0, 1e7, 2.15e9, 1e3, 0.1), 5.447948e-5),
    ];
    for (element, exact) in table {
        let (stable, unstable) =
            (growth(element, 0.95 * exact, 100_000), growth(element, 1.05 * exact, 1000));
        assert!(stable < 100.0, "{element:?}: grows by {stable}");
        assert!(unstable > 1e6, "{element:?}: grows by {unstable} only");
        let (below, above) =
            (growth(element, 0.9999 * exact, 100_000), growth(element, 1.0001 * exact, 100_000));
        assert!(below < 1e3 && above > 1e3, "{element:?}: the limit is that of the sheet, {below}, {above}");
    }
}
