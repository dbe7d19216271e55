//! Obstacles with prescribed motion (sheet: sph §2.13).

use colluvium_case::{Case, Method, Solver, spatial};
use colluvium_sph::Sph;
use colluvium_testkit::{
    advance_steps, advance_to, case_with, scalar_output, start_solver, stresses, vectors,
};
use serde_json::{Value, json};

/// Elastic block over the floor `y = 0`, without gravity; `more` adds keys to the case.
fn block(more: &Value) -> Case {
    let text = json!({
        "title": "block", "space": "plane-strain", "gravity": [0, 0],
        "domain": { "min": [-2, -2], "max": [3, 3] },
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 } },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.6, 0.3] } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "sph": { "spacing": 0.05 } }
    });
    case_with(text, more)
}

/// Stored and kinetic energy plus the energy taken by obstacles, less the work of their motion (J).
fn energy(solver: &dyn Solver) -> f64 {
    let budget = solver.budget().unwrap();
    let took = scalar_output(solver, "obstacles.friction") + scalar_output(solver, "obstacles.stopped");
    budget.kinetic + budget.elastic + budget.potential + took - scalar_output(solver, "obstacles.work")
}

/// In the frame of an obstacle the motion does not depend on its velocity. The sums are equal up to the round-off of positions, which the
/// steps amplify to 10⁻¹¹.
#[test]
fn motion_on_a_moving_plane_is_independent_of_the_reference_frame() {
    let carried = [0.4, 0.3];
    for wall in [
        json!({ "kind": "rough" }),
        json!({ "kind": "smooth" }),
        json!({ "kind": "frictional", "friction_coefficient": 0.3 }),
    ] {
        for integration in ["leapfrog", "velocity-verlet", "runge-kutta4"] {
            let run = |course: [f64; 2]| {
                let velocity: Vec<f64> = [0.5, -0.1].iter().zip(course).map(|(v, c)| v + c).collect();
                let mut solver = start_solver(
                    &Sph,
                    &block(&json!({
                        "gravity": [0, -9.81],
                        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.6, 0.3] },
                            "velocity": { "kind": "uniform", "value": velocity } }],
                        "obstacles": [{ "name": "floor", "wall": wall, "motion": { "velocity": course },
                            "shape": { "kind": "plane", "point": [0, 0], "normal": [0, 1] } }],
                        "methods": { "sph": { "spacing": 0.05, "time_step": 2e-4, "integration": integration } }
                    })),
                );
                (0..200).for_each(|_| assert_eq!(solver.step(2e-4).unwrap().dt, 2e-4));
                solver
            };
            let (still, moving) = (run([0.0; 2]), run(carried));
            let (a, b) = (still.snapshot(), moving.snapshot());
            for (k, (a, b)) in a.positions.iter().zip(&b.positions).enumerate() {
                for c in 0..2 {
                    let off = b[c] - carried[c] * moving.time() - a[c];
                    assert!(off.abs() < 1e-11, "{wall} {integration}: particle {k} is off by {off:.2e} m");
                }
            }
            for name in ["obstacles.friction", "obstacles.stopped"] {
                let (a, b) = (scalar_output(&*still, name), scalar_output(&*moving, name));
                assert!((a - b).abs() < 1e-8 * (1.0 + a.abs()), "{wall} {integration}: {name} {a} {b}");
            }
        }
    }
}

/// Block on a plane that tilts by 5 degrees per second, with a friction angle of 20 degrees.
struct Tilting {
    solver: Box<dyn Solver>,
    /// Start of the rotation without the ramp (s).
    start: f64,
}

impl Tilting {
    const RATE: f64 = 5.0;

    /// Returns the problem at the start of the rotation, with particles `spacing` (m) apart.
    fn begin(spacing: f64) -> Self {
        let (begins, ramp) = (0.5, 0.5);
        let case = block(&json!({
            "gravity": [0, -9.81],
            "obstacles": [{ "name": "floor", "wall": { "kind": "frictional", "friction_coefficient": 20f64.to_radians().tan() },
                "motion": { "rotation": -Self::RATE, "centre": [0.3, 0], "start": begins, "ramp": ramp },
                "shape": { "kind": "plane", "point": [0, 0], "normal": [0, 1] } }],
            "measures": { "on": { "kind": "reaction", "target": "floor" } },
            "stages": [{ "name": "settle", "duration": begins, "gravity_ramp": 0.2, "damping": 0.6 }, { "name": "tilt", "duration": 8 }],
            "methods": { "sph": { "spacing": spacing } }
        }));
        let mut solver = start_solver(&Sph, &case);
        advance_to(&mut *solver, begins);
        solver.begin_stage(1, solver.time()).unwrap();
        Self { solver, start: begins + 0.5 * ramp }
    }

    /// Runs until a slope angle (degrees).
    fn turn(&mut self, slope: f64) {
        advance_to(&mut *self.solver, self.start + slope / Self::RATE);
    }

    /// Position of the block centre along the plane (m).
    fn along(&self) -> f64 {
        let (sin, cos) = self.slope().sin_cos();
        let x = self.solver.snapshot().positions;
        let mean = |c: usize| x.iter().map(|x| x[c]).sum::<f64>() / x.len() as f64;
        (mean(0) - 0.3) * cos - mean(1) * sin
    }

    /// Mean tangential and normal forces on the plane over the weight, while the slope increases from one angle to another (degrees).
    fn mean_reaction(&mut self, from: f64, to: f64) -> [f64; 2] {
        self.turn(from);
        let end = self.start + to / Self::RATE;
        self.mean_reaction_while(|tilting| tilting.solver.time() < end)
    }

    /// Mean tangential and normal forces over the weight, in the steps while `condition` is true.
    fn mean_reaction_while(&mut self, condition: impl Fn(&Self) -> bool) -> [f64; 2] {
        let mut sums = [0.0; 2];
        let mut steps = 0.0;
        while condition(self) {
            let (sin, cos) = self.slope().sin_cos();
            advance_steps(&mut *self.solver, 1);
            let [x, y, _] = self.solver.reaction("floor").unwrap().force;
            sums[0] += x * cos - y * sin;
            sums[1] -= x * sin + y * cos;
            steps += 1.0;
        }
        sums.map(|sum| sum / (steps * 180.0 * 9.81))
    }

    /// Slope (radians).
    fn slope(&self) -> f64 {
        (Self::RATE * (self.solver.time() - self.start)).to_radians()
    }

    /// Speed of the block relative to the plane (m/s).
    fn slip(&self) -> f64 {
        let (sin, cos) = self.slope().sin_cos();
        let [x, y, _] = self.solver.totals().momentum;
        // The block centre is 0.15 m over the axis of rotation of the plane.
        (x * cos - y * sin) / 180.0 - 0.15 * Self::RATE.to_radians()
    }
}

/// The plane supports the weight of a block up to the friction angle. Then the block slides, with friction times the normal
/// force.
#[test]
fn a_tilting_plane_holds_a_block_up_to_the_friction_angle_and_dissipates_beyond() {
    let mut tilting = Tilting::begin(0.05);
    // Between 19 and 20 degrees, and a little less than its weight since it rotates with the plane.
    let [along, across] = tilting.mean_reaction(19.0, 20.0);
    let (sin, cos) = 19.5f64.to_radians().sin_cos();
    assert!((along / sin - 1.0).abs() < 5e-3 && (across / cos - 1.0).abs() < 1e-3, "{along} {across}");
    let [along, across] = tilting.mean_reaction(21.0, 28.0);
    let share = along / across / 20f64.to_radians().tan();
    // The base vibrates: 1.1e-3 with corotated sums.
    assert!((share - 1.0).abs() < 2e-3, "{share} of the friction");
}

/// Without the delay of friction the base oscillates, stops in each oscillation, and carries 0.99 of its share with the wider spacing,
/// 0.97 with the other.
#[test]
fn a_slowly_sliding_block_has_full_friction_at_any_spacing() {
    for spacing in [0.05, 0.025] {
        let mut tilting = Tilting::begin(spacing);
        tilting.turn(19.0);
        while tilting.slip() < 0.05 {
            advance_steps(&mut *tilting.solver, 1);
        }
        let [along, across] = tilting.mean_reaction_while(|tilting| tilting.slip() < 0.2);
        let share = along / across / 20f64.to_radians().tan();
        assert!((share - 1.0).abs() < 0.01, "spacing {spacing}: {share} of the friction");
    }
}

/// The sliding distance on a tilting plane grows with the third power of the angle beyond the friction angle, and so determines the angle
/// at which sliding began. The elastic oscillation and the slip of its corners, 3 mm a second at 20 degrees, are 0.15 degrees of it.
#[test]
fn a_block_on_a_plane_that_tilts_slides_at_the_angle_of_friction() {
    let (rate, friction) = (Tilting::RATE.to_radians(), 20f64.to_radians().tan());
    let mut tilting = Tilting::begin(0.05);
    tilting.turn(19.0);
    let held = tilting.along();
    assert!(held.abs() < 0.005 * 0.6, "at 19°: it slid {held} m");
    tilting.turn(20.0);
    let began = tilting.along();
    tilting.turn(28.0);
    // Newton's law along the plane, in its frame; the block centre is 0.15 m over the axis of rotation.
    let (mut place, mut speed, dt) = (0.0, 0.0f64, 1e-5);
    for step in 0..160_000 {
        let angle = rate * (4.0 + f64::from(step) * dt);
        let normal = 9.81 * angle.cos() - rate * rate * 0.15 + 2.0 * rate * speed;
        speed += dt * (9.81 * angle.sin() + rate * rate * place - friction * normal);
        speed = speed.max(0.0);
        place += dt * speed;
    }
    let slid = tilting.along() - began;
    let onset = 28.0 - 8.0 * (slid / place).cbrt();
    assert!((onset - 20.0).abs() < 0.25, "from {onset}°: {slid} m for {place} m");
}

/// A piston starts at once against a laterally confined bar: a wave of the stress ρ c V propagates into it.
#[test]
fn the_force_of_a_piston_is_the_impedance_and_its_impulse_the_momentum() {
    let (speed, modulus) = (0.05, 1e6 * 0.8 / (1.2 * 0.6));
    let case = block(&json!({
        "domain": { "min": [-1, 0], "max": [3, 0.2], "periodic": ["y"] },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [2, 0.2] } }],
        "obstacles": [{ "name": "piston", "wall": { "kind": "smooth" }, "motion": { "velocity": [speed, 0] },
            "shape": { "kind": "plane", "point": [0, 0], "normal": [1, 0] } }],
        "measures": { "on": { "kind": "reaction", "target": "piston" } },
        "methods": { "sph": { "spacing": 0.02 } }
    }));
    let mut solver = start_solver(&Sph, &case);
    let wave = (modulus / 1000.0f64).sqrt();
    let (from, to) = (0.4 / wave, 1.6 / wave);
    advance_to(&mut *solver, from);
    let (first, start) = (solver.reaction("piston").unwrap().impulse, solver.time());
    advance_to(&mut *solver, to);
    let impulse = solver.reaction("piston").unwrap().impulse;
    let force = (impulse[0] - first[0]) / (solver.time() - start);
    let exact = -1000.0 * wave * speed * 0.2;
    let budget = solver.budget().unwrap();
    assert!((force / exact - 1.0).abs() < 0.01, "{force} N for {exact} N");
    // The momentum is that at the end of a step, and the force of the last step that at its start.
    assert!((budget.momentum[0] / -impulse[0] - 1.0).abs() < 5e-3, "{:?} {impulse:?}", budget.momentum);
    let work = scalar_output(&*solver, "obstacles.work");
    assert!((work / (-impulse[0] * speed) - 1.0).abs() < 1e-9, "{work}");
    // Only the viscosity of the wave front dissipates energy.
    let kept = (budget.kinetic + budget.elastic) / work;
    assert!(kept < 1.0 && kept > 0.97, "{kept}");
}

/// Block in the path of a rotating paddle, in the plane or in space.
fn paddle(space: &str, integration: &str) -> Case {
    let solid = space == "3d";
    let at = |plane: [f64; 2], last: f64| if solid { vec![plane[0], plane[1], last] } else { plane.to_vec() };
    let mut motion = json!({ "rotation": 120, "centre": at([0.0, 0.0], 0.0), "start": 0.02, "ramp": 0.1 });
    if solid {
        motion["axis"] = json!([0, 0, 1]);
    }
    block(&json!({
        "space": space, "gravity": at([0.0, 0.0], 0.0),
        "domain": { "min": at([-2.0, -2.0], -1.0), "max": at([2.0, 2.0], 1.0) },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": at([0.3, 0.15], -0.15), "max": at([0.6, 0.45], 0.15) } }],
        "obstacles": [{ "name": "paddle", "wall": { "kind": "frictional", "friction_coefficient": 0.4 }, "motion": motion,
            "shape": { "kind": "box", "min": at([-0.7, -0.1], -0.4), "max": at([0.7, 0.1], 0.4) } }],
        "measures": { "on": { "kind": "reaction", "target": "paddle" } },
        "methods": { "sph": { "spacing": 0.05, "integration": integration } }
    }))
}

#[test]
fn a_paddle_throws_a_block_in_the_plane_and_in_space_and_the_balances_close() {
    for space in ["plane-strain", "3d"] {
        let case = paddle(space, "leapfrog");
        let mut solver = start_solver(&Sph, &case);
        let start = energy(&*solver);
        advance_to(&mut *solver, 0.4);
        let budget = solver.budget().unwrap();
        let impulse = solver.reaction("paddle").unwrap().impulse;
        let work = scalar_output(&*solver, "obstacles.work");
        let size = budget.momentum.iter().map(|p| p * p).sum::<f64>().sqrt();
        assert!(size > 0.3 * budget.mass, "{space}: it is thrown: {size}");
        for c in 0..3 {
            assert!(
                (budget.momentum[c] + impulse[c]).abs() < 0.01 * size,
                "{space}: {:?} {impulse:?}",
                budget.momentum
            );
        }
        let off = (energy(&*solver) - start) / work;
        assert!(off < 0.02 && off > -0.1, "{space}: {off} of the work");
        // No particle is in the paddle.
        let angle: f64 = -(120f64.to_radians()) * (0.4 - 0.02 - 0.05);
        let (sin, cos) = angle.sin_cos();
        for x in solver.snapshot().positions {
            let [a, b] = [cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]];
            assert!(a.abs() > 0.7 || b.abs() > 0.1, "{space}: {x:?}");
        }
    }
}

/// A plate hits a row of particles at a speed above their wave speed.
#[test]
fn a_fast_thin_plate_carries_the_particles_it_meets() {
    for integration in ["leapfrog", "predictor-corrector", "velocity-verlet", "verlet", "runge-kutta4"] {
        let case = block(&json!({
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e4, "poissons_ratio": 0.2 } },
            "obstacles": [{ "name": "plate", "wall": { "kind": "smooth" }, "motion": { "velocity": [0, 20] },
                "shape": { "kind": "box", "min": [-1, -0.5], "max": [2, -0.48] } }],
            "methods": { "sph": { "spacing": 0.05, "integration": integration } }
        }));
        let mut solver = start_solver(&Sph, &case);
        assert_eq!(solver.limit().limit.to_string(), "motion of an obstacle");
        let start = energy(&*solver);
        advance_to(&mut *solver, 0.08);
        let (above, work) = (-0.48 + 20.0 * solver.time(), scalar_output(&*solver, "obstacles.work"));
        let lowest = solver.snapshot().positions.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
        assert!(lowest > above, "{integration}: {lowest} m under {above} m");
        let off = (energy(&*solver) - start) / work;
        assert!(off < 0.02, "{integration}: {off} of the work");
    }
    let mut fixed = block(&json!({
        "obstacles": [{ "name": "plate", "wall": { "kind": "smooth" }, "motion": { "velocity": [0, 200] },
            "shape": { "kind": "box", "min": [-1, -0.5], "max": [2, -0.48] } }]
    }));
    fixed.methods.get_mut("sph").unwrap()["time_step"] = json!(1e-4);
    let error = Sph.build(&fixed).err().unwrap().to_string();
    assert!(error.starts_with("methods.sph.time_step") && error.contains("motion of an obstacle"), "{error}");
}

#[test]
fn moving_obstacles_are_bit_identical_on_threads_and_ranks_and_after_a_restart() {
    for (space, integration) in
        [("plane-strain", "leapfrog"), ("plane-strain", "runge-kutta4"), ("3d", "leapfrog")]
    {
        let mut case = paddle(space, integration);
        case.measures.clear();
        let on = |threads: usize, ranks: u32| {
            let mut case = case.clone();
            case.methods.get_mut("sph").unwrap()["ranks"] = json!(ranks);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut solver = start_solver(&Sph, &case);
                advance_steps(&mut *solver, 300);
                solver.checkpoint_bytes().unwrap()
            })
        };
        let one = on(1, 1);
        let shared: &[_] = if integration == "leapfrog" { &[(2, 2), (3, 3)] } else { &[] };
        for &(threads, ranks) in [(2, 1), (3, 1)].iter().chain(shared) {
            assert!(one == on(threads, ranks), "{space}: other bits on {threads} threads in {ranks} ranks");
        }
        let mut first = start_solver(&Sph, &case);
        advance_steps(&mut *first, 137);
        let mut then = start_solver(&Sph, &case);
        then.restore(&mut first.checkpoint_bytes().unwrap().as_slice()).unwrap();
        then.begin_stage(0, 0.0).unwrap();
        advance_steps(&mut *then, 163);
        assert!(one == then.checkpoint_bytes().unwrap(), "{space}: other bits after a restart");
    }
}

#[test]
fn obstacle_motions_incompatible_with_periodic_domains_are_refused() {
    let problem = |motion: Value, shape: Value| {
        let case = block(&json!({
            "domain": { "min": [-2, -2], "max": [3, 3], "periodic": ["x"] },
            "obstacles": [{ "name": "o", "wall": { "kind": "rough" }, "motion": motion, "shape": shape }]
        }));
        Sph.build(&case).map(|_| ()).err().map(|error| error.to_string())
    };
    let (plane, ram) = (
        json!({ "kind": "plane", "point": [0, 0], "normal": [0, 1] }),
        json!({ "kind": "box", "min": [0, -1], "max": [1, -0.5] }),
    );
    assert_eq!(problem(json!({ "velocity": [1, 0.5] }), plane.clone()), None);
    assert_eq!(problem(json!({ "velocity": [0, 0.5] }), ram.clone()), None);
    let over = problem(json!({ "velocity": [1, 0] }), ram.clone()).unwrap();
    assert!(over.starts_with("obstacles[0].motion.velocity: moves the obstacle across the end"), "{over}");
    let turns = problem(json!({ "rotation": 5, "centre": [0, 0] }), ram).unwrap();
    assert!(turns.starts_with("obstacles[0].motion.rotation"), "{turns}");
}

/// A body at rest on a rotating obstacle rotates with it: it does not strain, and its stress rotates too.
#[test]
fn a_body_rotating_with_an_obstacle_remains_free_of_stress() {
    // Steady rotation from the start: each particle has the velocity of the floor at its position.
    let rate = 30f64.to_radians();
    let case = block(&json!({
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.6, 0.3] },
            "velocity": { "kind": "linear", "value": [0, 0], "origin": [0, 0], "gradient": [[0, -rate], [rate, 0]] } }],
        "obstacles": [{ "name": "floor", "wall": { "kind": "rough" }, "motion": { "rotation": 30, "centre": [0, 0] },
            "shape": { "kind": "plane", "point": [0, 0], "normal": [0, 1] } }],
        "methods": { "sph": { "spacing": 0.05, "velocity_gradient": "corrected" } }
    }));
    let mut solver = start_solver(&Sph, &case);
    solver.step(1e-6).unwrap();
    let snapshot = solver.snapshot();
    let (v, x) = (vectors(&snapshot, "velocity"), &snapshot.positions);
    for (v, x) in v.iter().zip(x) {
        let exact = spatial(&[-rate * x[1], rate * x[0]]);
        assert!((0..2).all(|c| (v[c] - exact[c]).abs() < 1e-4), "{v:?} {exact:?}");
    }
    let all = stresses(&snapshot);
    let largest = all.as_flattened().iter().fold(0.0f64, |largest, s| largest.max(s.abs()));
    // A modulus of 1 MPa over 1 µs gives 0.5 Pa for a strain at the rate of rotation; the remaining stress scales with the angle of a step.
    assert!(largest < 1e-6, "{largest} Pa");
}
