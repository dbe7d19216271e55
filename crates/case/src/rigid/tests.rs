//! Tests of rigid bodies against closed forms.

use serde_json::json;

use super::{
    ContactSystem, ObstacleContact, RigidBodyActions, RigidMass, RigidState, RigidStep, SupportPoints,
    SupportReaction, Twist, multiply, transposed,
};
use crate::Case;
use crate::description::Velocity;

/// Points of a box of cubes of 0.1 m and 1 kg, with these numbers along the axes.
fn points(counts: [usize; 3]) -> (Vec<f64>, Vec<[f64; 3]>) {
    let mut places = Vec::new();
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            places.extend((0..counts[2]).map(|k| [i, j, k].map(|n| 0.1 * n as f64)));
        }
    }
    (vec![1.0; places.len()], places)
}

fn box_mass(counts: [usize; 3]) -> RigidMass {
    let (masses, places) = points(counts);
    RigidMass::of_points(&masses, &places, 0.1)
}

const FREE_BODY: RigidBodyActions =
    RigidBodyActions { free_components: [true; 6], ..RigidBodyActions::AT_REST };

/// Body after a number of steps of `dt` (s) from a state.
fn body_after_steps(
    mass: &RigidMass,
    mut state: RigidState,
    acts: &RigidBodyActions,
    steps: usize,
    dt: f64,
) -> RigidState {
    let inertia = mass.inertia;
    for _ in 0..steps {
        // Moments of inertia in the current orientation.
        let turned: [[f64; 3]; 3] = std::array::from_fn(|i| {
            multiply(&state.axes, &multiply(&inertia, &std::array::from_fn(|k| state.axes[i][k])))
        });
        let here = RigidMass { inertia: transposed(&turned), ..*mass };
        let body = RigidStep::new(here, &state, acts, dt, 0.0);
        body.apply(&mut state);
        body.rotate(dt, &mut state);
    }
    state
}

#[test]
fn a_box_of_cubes_has_the_moments_of_inertia_of_the_box() {
    let mass = box_mass([5, 3, 2]);
    let [a, b, c] = [0.5f64, 0.3, 0.2].map(|edge| edge * edge);
    let exact = [b + c, c + a, a + b].map(|squares| 30.0 * squares / 12.0);
    for (i, row) in mass.inertia.iter().enumerate() {
        for (j, found) in row.iter().enumerate() {
            let exact = if i == j { exact[i] } else { 0.0 };
            assert!((found - exact).abs() < 1e-13, "{i} {j}: {found} {exact}");
        }
    }
}

#[test]
fn points_of_a_rotating_body_have_its_rigid_motion() {
    let (mass, (masses, places)) = (box_mass([5, 3, 2]), points([5, 3, 2]));
    let gradient = [[0.0, -6.0, 3.0], [6.0, 0.0, -5.0], [-3.0, 5.0, 0.0]];
    let given = Velocity::Linear {
        value: vec![0.3, -0.2, 0.1],
        origin: vec![0.1, 0.2, 0.0],
        gradient: gradient.map(|row| row.to_vec()).to_vec(),
    };
    let velocities: Vec<[f64; 3]> = places.iter().map(|x| given.velocity_at(*x)).collect();
    let (one, other) =
        (RigidState::initial(&mass, &given), RigidState::of_points(&mass, &masses, &places, &velocities));
    for c in 0..3 {
        assert!((one.angular_velocity[c] - [5.0, 3.0, 6.0][c]).abs() < 1e-13);
        assert!((one.angular_velocity[c] - other.angular_velocity[c]).abs() < 1e-12);
        assert!((one.velocity[c] - other.velocity[c]).abs() < 1e-13);
        assert!((one.angular_momentum[c] - other.angular_momentum[c]).abs() < 1e-12);
    }
}

#[test]
fn a_moment_about_a_principal_axis_gives_constant_angular_acceleration() {
    let (mass, axis) = (box_mass([5, 3, 2]), 1);
    let mut acts = FREE_BODY;
    acts.moment[axis] = 0.7;
    acts.prescribed_velocities = [None; 3];
    let angle = |steps: usize| {
        let dt = 1.0 / steps as f64;
        let state = body_after_steps(&mass, RigidState::default(), &acts, steps, dt);
        let exact = 0.7 / mass.inertia[axis][axis];
        assert!((state.angular_velocity[axis] / exact - 1.0).abs() < 1e-12);
        // Velocities are those at the end of each step, half a step ahead.
        state.axes[0][2].atan2(state.axes[0][0]) - 0.5 * exact * (1.0 + dt)
    };
    assert!(angle(100).abs() < 1e-12 && angle(200).abs() < 1e-12);
}

/// Symmetric top without moments: its axis precesses about its angular momentum at L over its transverse moment of inertia.
#[test]
fn precession_of_a_free_symmetric_top_converges_to_second_order() {
    let mass = box_mass([2, 2, 6]);
    let (across, along) = (mass.inertia[0][0], mass.inertia[2][2]);
    let spin = [3.0, 0.0, 5.0];
    let turning = multiply(&mass.inertia, &spin);
    let size = turning.iter().map(|l| l * l).sum::<f64>().sqrt();
    assert!((turning[0] - 3.0 * across).abs() < 1e-12 && (turning[2] - 5.0 * along).abs() < 1e-12);
    let (end, rate) = (2.0, size / across);
    let error = |steps: usize| {
        let start = RigidState { angular_velocity: spin, angular_momentum: turning, ..RigidState::default() };
        let acts = RigidBodyActions { prescribed_velocities: [None; 3], ..FREE_BODY };
        let state = body_after_steps(&mass, start, &acts, steps, end / steps as f64);
        // The angular momentum is constant.
        assert!((0..3).all(|c| (state.angular_momentum[c] - turning[c]).abs() < 1e-12 * size));
        // Initial axis z, rotated about the angular momentum.
        let about = super::rotation(&turning.map(|l| l / size * rate * end));
        let exact = multiply(&about, &[0.0, 0.0, 1.0]);
        let found: [f64; 3] = std::array::from_fn(|c| state.axes[c][2]);
        (0..3).map(|c| (found[c] - exact[c]).powi(2)).sum::<f64>().sqrt()
    };
    let (coarse, fine) = (error(400), error(800));
    assert!(coarse < 1e-3 && fine < 0.27 * coarse, "{coarse} {fine}");
}

/// Ground with sticking contacts for any argument.
struct Sticky<'a>(&'a SupportPoints);

impl ContactSystem for Sticky<'_> {
    fn impulse(&self, motion: &Twist, _: bool) -> Twist {
        self.0.impulse(motion, true)
    }

    fn stiffness(&self, motion: &Twist, _: bool) -> [Twist; 6] {
        self.0.stiffness(motion, true)
    }
}

/// Box that falls obliquely on a half-space with friction: support points, and the box in the step before contact.
fn falling_box() -> (SupportPoints, RigidStep) {
    let (_, places) = points([5, 3, 2]);
    let mut planks = SupportPoints::default();
    let mut body = RigidStep::new(box_mass([5, 3, 2]), &RigidState::default(), &FREE_BODY, 0.01, 0.0);
    body.start = [2.0, 0.3, -1.0, 0.2, -0.4, 0.1];
    body.motion = body.start;
    let plane = json!([{ "name": "ground", "shape": { "kind": "plane", "point": [0, 0, -0.051], "normal": [0, 0, 1] },
        "wall": { "kind": "frictional", "friction_coefficient": 0.2 } }]);
    let case = Case::from_json(&json!({
        "title": "box", "space": "3d", "domain": { "min": [-1, -1, -1], "max": [2, 2, 2] }, "gravity": [0, 0, -9.81],
        "materials": { "rock": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 5e6, "poissons_ratio": 0.2 } },
        "bodies": [{ "name": "box", "material": "rock", "rigid": true, "shape": { "kind": "box", "min": [0, 0, 0], "max": [1, 1, 1] } }],
        "obstacles": plane, "stages": [{ "name": "s", "duration": 1 }]
    }).to_string())
    .unwrap();
    let standing = case.placed_obstacles::<3>().unwrap();
    let rocks =
        standing.iter().map(|own| ObstacleContact { surface: &*own.surface, laws: &own.laws, motion: None });
    planks.list((&body, 0.01), (&places, 0.05), std::iter::empty(), rocks);
    (planks, body)
}

#[test]
fn impulse_on_obstacles_equals_the_momentum_loss_of_the_body_in_sliding_and_sticking() {
    let (planks, body) = falling_box();
    assert!(!planks.is_empty());
    for stuck in [false, true] {
        let (motion, done) =
            if stuck { body.solve_contact(&Sticky(&planks)) } else { body.solve_contact(&planks) };
        assert!(done);
        let stood: Vec<SupportReaction> = planks.reactions(&RigidStep { motion, ..body }, stuck).collect();
        let size = body.mass.mass * body.start[0];
        for c in 0..3 {
            let lost = body.mass.mass * (body.motion[c] - motion[c]);
            let received: f64 = stood.iter().map(|own| own.impulse[c]).sum();
            assert!((received - lost).abs() < 1e-8 * size, "{stuck} {c}: {received} for {lost}");
        }
        let friction: f64 = stood.iter().map(|own| own.friction).sum();
        // It slides after the impact; sticking contacts have no friction work.
        let slip = body.mass.mass * body.start[0].powi(2);
        assert!(if stuck { friction < 1e-5 * slip } else { friction > 1e-2 * slip }, "{stuck}: {friction}");
    }
}
