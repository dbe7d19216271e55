//! Kinematics, invariants, neighbour lists, sizes and stress (sheet: dem §5, B17; §3.8).

use colluvium::case::Solver;
use colluvium::dem::specimen::size_distributions::incomplete_beta;
use colluvium::dem::{DemSolver, Diameters};
use colluvium::plots::{LineChart, Series, Style};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use crate::analysis::{MaxOrNan, max_or_nan};
use crate::benchmarks::dem::case_builders::{
    GrainData, disk_solver, grain_file, load, method_options, output_value, step,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, scalars, vectors};

/// Benchmark of kinematics, conserved quantities, neighbour lists, grading curves and stress.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/bookkeeping",
    title: "Kinematics, invariants, lists, sizes and stress of DEM",
    source: "sheet: dem §5, B17; §3.8",
    short_seconds: Some(5),
    full_seconds: 5,
    run,
};

/// Number of samples over which distances of grading curves are averaged.
const SAMPLES: u64 = 2;

/// Checks kinematics, conserved quantities, neighbour lists, size distributions and stress.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    gears(&mut outcome)?;
    momentum(&mut outcome)?;
    drift(&mut outcome)?;
    image(&mut outcome)?;
    lists(&mut outcome)?;
    sizes(&mut outcome)?;
    stress(&mut outcome)?;
    block(&mut outcome)?;
    Ok(outcome)
}

/// Case of two disks, each with centre, radius, velocity and spin.
fn pair(grains: [([f64; 2], f64, [f64; 2], f64); 2]) -> Result<Value, String> {
    let mut value = load("bookkeeping")?;
    for (k, name) in ["first", "second"].into_iter().enumerate() {
        let (centre, radius, velocity, spin) = grains[k];
        value["bodies"][k]["shape"] = json!({ "kind": "ball", "centre": centre, "radius": radius });
        value["bodies"][k]["velocity"] = json!({ "kind": "uniform", "value": velocity });
        method_options(&mut value)["bodies"][name] = json!({ "spin": [spin] });
    }
    Ok(value)
}

/// Checks that rolling and rigid rotation cause no slip at the contact (B17.1).
fn gears(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for (name, first, second, spins, slips) in [
        ("gears", [0.01, 0.0], [0.0, 0.0], [1.0, -2.0], false),
        ("a pair that turns as one", [0.01, -1.0], [0.0, 0.5], [1.0, 1.0], false),
        ("equal spins", [0.01, 0.0], [0.0, 0.0], [1.0, 1.0], true),
    ] {
        let mut value = pair([([-1.0, 0.0], 1.0, first, spins[0]), ([0.5, 0.0], 0.5, second, spins[1])])?;
        // Gears touch at their radii: at an overlap of 2e-7 m the contact point is equally near to both.
        method_options(&mut value)["lever_arm"] = json!("radius");
        method_options(&mut value)["pairs"][0]["normal"]["damping_ratio"] = json!(0);
        let mut solver = disk_solver(&value)?;
        for _ in 0..20 {
            step(&mut solver, 1e-6)?;
        }
        let contact = solver.contacts().first().ok_or("no contact")?;
        let share = (contact.force[1] / contact.force[0]).abs();
        if slips {
            let reason = "friction of 0.5 is reached: says that the two rows above could fail";
            outcome.assert_within(
                format!("B17.1, {name}: friction over normal force"),
                "0.5",
                share,
                (0.45, 0.55),
                reason,
            );
        } else {
            let reason = "B17.1: no slip; 1e-4 for the turn of the line of centres over 2e-5 s";
            outcome.assert_below(
                format!("B17.1, {name}: friction over normal force"),
                "0",
                share,
                1e-4,
                reason,
            );
        }
    }
    Ok(())
}

/// Checks that a collision of two disks conserves linear and angular momentum (B17.2).
fn momentum(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut solver =
        disk_solver(&pair([([-0.52, 0.1], 0.5, [1.0, 0.3], 3.0), ([0.32, -0.1], 0.3, [-0.5, 0.0], -7.0)])?)?;
    let start = solver.totals();
    let (mut turn, mut along, mut touched) = (0.0f64, 0.0f64, 0.0f64);
    for _ in 0..2000 {
        let dt = solver.limit().dt;
        step(&mut solver, dt)?;
        touched = touched.max(output_value(&solver, "contacts"));
        let now = solver.totals();
        turn = max_or_nan(turn, (now.angular_momentum[2] / start.angular_momentum[2] - 1.0).abs());
        along = max_or_nan(along, (now.momentum[0] / start.momentum[0] - 1.0).abs());
    }
    outcome.assert_below(
        "B17.2, angular momentum of a colliding pair: relative change",
        "0",
        turn,
        1e-12,
        "B17.2: 1e-12",
    );
    outcome.assert_below("B17.2, linear momentum: relative change", "0", along, 1e-12, "B17.2: 1e-12");
    outcome.assert_within("B17.2, contacts", "1", touched, (1.0, 1.0), "says that they have met");
    Ok(())
}

/// Velocities and spins of a pair after a number of steps.
fn final_motion(value: &Value, steps: usize, dt: f64) -> Result<[f64; 6], String> {
    let mut solver = disk_solver(value)?;
    for _ in 0..steps {
        step(&mut solver, dt)?;
    }
    let snapshot = solver.snapshot();
    let (v, w) = (vectors(&snapshot, "velocity"), scalars(&snapshot, "spin"));
    Ok([v[0][0], v[0][1], v[1][0], v[1][1], w[0], w[1]])
}

/// Checks that a uniform velocity does not change the forces (B17.3).
fn drift(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let with = |drift: [f64; 2]| {
        let first = [1.0 + drift[0], 0.3 + drift[1]];
        let second = [-0.5 + drift[0], drift[1]];
        final_motion(&pair([([-0.5, 0.1], 0.5, first, 3.0), ([0.31, -0.1], 0.3, second, -7.0)])?, 400, 1e-5)
    };
    let drift = [20.0, -8.0];
    let (still, moving) = (with([0.0; 2])?, with(drift)?);
    let shift = |k: usize| if k < 4 { drift[k % 2] } else { 0.0 };
    let error = (0..6).map(|k| (moving[k] - shift(k) - still[k]).abs()).max_or_nan();
    let reason = "B17.3: round-off of places that are 0.08 m apart, over a stiff contact";
    outcome.assert_below(
        "B17.3, drift of 21.5 m/s: change of velocities and spins (m/s, rad/s)",
        "0",
        error,
        1e-8,
        reason,
    );
    Ok(())
}

/// Checks that contact across a periodic boundary equals contact within the cell, also where the cell is sheared (B17.3).
fn image(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for (name, rate) in [("at rest", 0.0), ("in shear", 0.5)] {
        let after = |shift: [f64; 2]| {
            // With the velocity of the shear about the corner.
            let place = |x: [f64; 2]| [x[0] + shift[0], x[1] + shift[1]];
            let (first, second) = (place([-0.52, 0.05]), place([0.32, -0.05]));
            let grain = |x: [f64; 2], r: f64, v: [f64; 2]| -> GrainData {
                let wrapped: Vec<f64> = x.iter().map(|x| if *x >= 5.0 { x - 10.0 } else { *x }).collect();
                // The cell applies the velocity of its gradient when the stage begins.
                (wrapped, r, v.to_vec())
            };
            let mut value = load("bookkeeping")?;
            value["domain"] = json!({ "min": [-5, -5], "max": [5, 5], "periodic": ["x", "y"] });
            value["bodies"].as_array_mut().ok_or("no bodies")?.truncate(1);
            value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [-5, -5], "max": [5, 5] });
            let grains = [grain(first, 0.5, [1.0, 0.3]), grain(second, 0.3, [-0.5, 0.0])];
            value["bodies"][0]["points"] =
                grain_file(&format!("image-{rate}-{}-{}", shift[0], shift[1]), &grains)?;
            if rate > 0.0 {
                method_options(&mut value)["stages"]["s"]["cell"] = json!({ "xy": { "rate": rate } });
            }
            let mut solver = disk_solver(&value)?;
            for _ in 0..600 {
                step(&mut solver, 1e-4)?;
            }
            let (snapshot, budget) = (solver.snapshot(), output_value(&solver, "dissipated.friction"));
            let (v, w) = (vectors(&snapshot, "velocity"), scalars(&snapshot, "spin"));
            let apart = [v[0][0] - v[1][0], v[0][1] - v[1][1]];
            // For a pair across the period of y the velocity jumps by that of the cell.
            let jump = if snapshot.positions[0][1] - snapshot.positions[1][1] > 5.0 {
                rate * 10.0
            } else if snapshot.positions[0][1] - snapshot.positions[1][1] < -5.0 {
                -rate * 10.0
            } else {
                0.0
            };
            Ok::<_, String>([apart[0] - jump, apart[1], w[0], w[1], budget])
        };
        let within = after([0.0, 0.0])?;
        for (axis, shift) in [("x", [5.0, 0.0]), ("y", [0.0, 5.0]), ("x and y", [5.0, 5.0])] {
            let across = after(shift)?;
            let error = (0..5).map(|k| (across[k] - within[k]).abs()).max_or_nan();
            let what =
                format!("B17.3, cell {name}, pair across the period of {axis}: change (m/s, rad/s, J)");
            outcome.assert_below(what, "0", error, 1e-8, "B17.3: round-off over a stiff contact");
        }
    }
    Ok(())
}

/// Checks that the skin of neighbour lists does not affect the results, for grain sizes of 1 : 6 (B17.4).
fn lists(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let with = |skin: f64| -> Result<DemSolver<2, 1>, String> {
        let mut value = load("gas")?;
        let own = method_options(&mut value);
        own["grains"]["grain"] = json!({ "density": 1,
            "diameter": { "distribution": "equal-mass", "min": 0.5, "max": 3 },
            "fill": { "kind": "random", "solid_fraction": 0.7 } });
        own["skin"] = json!(skin);
        own["pairs"][0]["friction"] = json!({ "coefficient": 0.5 });
        own["pairs"][0]["normal"]["damping_ratio"] = json!(0.2);
        let mut solver = disk_solver(&value)?;
        for _ in 0..1000 {
            step(&mut solver, 5e-4)?;
        }
        Ok(solver)
    };
    // Lists with the widest skin contain all pairs within 2 diameters beyond contact, and are not rebuilt.
    let (near, far) = (with(0.05)?, with(2.0)?);
    let force = |solver: &DemSolver<2, 1>| vectors(&solver.snapshot(), "force");
    let (a, b) = (force(&near), force(&far));
    let size = a.iter().map(|f| f[0].hypot(f[1])).max_or_nan();
    let error = a.iter().zip(&b).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).max_or_nan() / size;
    let reason = "B17.4: the same forces after 1000 steps; 1e-9 for sums in another order";
    outcome.assert_below(
        "B17.4, thin and thick lists: change of forces over the largest",
        "0",
        error,
        1e-9,
        reason,
    );
    Ok(())
}

/// Checks generated grading curves against the requested ones (B17.7 and §3.8.1).
fn sizes(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let table = [
        (0.1, 0.00272800),
        (0.25, 0.07055664),
        (0.4, 0.28979200),
        (0.5, 0.5),
        (0.75, 0.92944336),
        (0.9, 0.99727200),
    ];
    let error = table.iter().map(|(x, exact)| (incomplete_beta(4.0, 4.0, *x) - exact).abs()).max_or_nan();
    outcome.assert_below("§3.8.1, I_x(4,4): largest error", "0", error, 1e-8, "the sheet's digits");
    let mut picture =
        LineChart::new("Grading of 10 000 grains", "size between smallest and largest", "mass that passes");
    let exact = (0..=100).map(|k| 0.01 * f64::from(k)).map(|x| (x, incomplete_beta(4.0, 4.0, x))).collect();
    picture.series.push(Series::new("I_x(4,4)", exact, Style::Dashed));
    for (ratio, dimension, mean) in [(1.5, 2usize, 1.23879), (6.0, 2, 3.04663), (6.0, 3, 2.80389)] {
        let curve = Diameters::CumulativeBeta { min: 1.0, max: ratio, a: 4.0, b: 4.0, classes: None };
        let (mut maximum, mut found, mut passing) = (0.0, 0.0, Vec::new());
        for seed in 0..SAMPLES {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let drawn = curve.sample(10_000, dimension, &mut random)?;
            found += drawn.iter().sum::<f64>() / 1e4 / SAMPLES as f64;
            let (distance, curve) = distance(drawn, ratio, dimension);
            maximum += distance / SAMPLES as f64;
            passing = curve;
        }
        let name =
            |what: &str| format!("B17.7, ratio {ratio}, {dimension}D, mean of {SAMPLES} samples: {what}");
        outcome.assert_close(name("mean diameter by number"), mean, 0.01, found, "B17.7: 1 %");
        outcome.assert_below(name("distance of the curves"), "0", maximum, 0.02, "B17.7: 0.02");
        if ratio > 5.0 {
            let shown = passing.into_iter().step_by(250).collect();
            picture.series.push(Series::new(format!("ratio 6, {dimension}D"), shown, Style::Markers));
        }
    }
    outcome.svg("B17.7: drawn by number, weighed by mass.", &picture)
}

/// Largest distance of the grading curve of generated diameters from the requested one, and that curve.
fn distance(mut drawn: Vec<f64>, ratio: f64, dimension: usize) -> (f64, Vec<(f64, f64)>) {
    drawn.sort_by(f64::total_cmp);
    let total: f64 = drawn.iter().map(|d| d.powi(dimension as i32)).sum();
    let (mut sum, mut largest, mut passing) = (0.0, 0.0f64, Vec::new());
    for d in drawn {
        let x = (d - 1.0) / (ratio - 1.0);
        let exact = incomplete_beta(4.0, 4.0, x);
        largest = max_or_nan(largest, (sum / total - exact).abs());
        sum += d.powi(dimension as i32);
        largest = max_or_nan(largest, (sum / total - exact).abs());
        passing.push((x, sum / total));
    }
    (largest, passing)
}

/// Checks the stress of two disks in contact in a periodic cell, `σ = -f l / V` (B17.8).
fn stress(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut value = load("bookkeeping")?;
    value["domain"] = json!({ "min": [-5, -5], "max": [5, 5], "periodic": ["x", "y"] });
    value["bodies"].as_array_mut().ok_or("no bodies")?.truncate(1);
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [-5, -5], "max": [5, 5] });
    let (overlap, angle) = (1e-4, 0.4f64);
    let half = 0.5 * (1.0 - overlap);
    let end = |side: f64| -> GrainData {
        (vec![side * half * angle.cos(), 5.0 * 0.9 + side * half * angle.sin()], 0.5, vec![0.0; 2])
    };
    value["bodies"][0]["points"] = grain_file("stress", &[end(1.0), end(-1.0)])?;
    let mut solver = disk_solver(&value)?;
    // A step without notable motion; the stress is that of the forces.
    step(&mut solver, 1e-9)?;
    let force = 1e6 * overlap;
    for (entry, share) in
        [("xx", angle.cos().powi(2)), ("yy", angle.sin().powi(2)), ("xy", angle.cos() * angle.sin())]
    {
        let exact = -force * 2.0 * half * share / 100.0;
        let found = output_value(&solver, &format!("cell_stress.{entry}"));
        outcome.assert_close(
            format!("B17.8, stress of a pair in a cell: {entry} (N/m)"),
            exact,
            1e-9,
            found,
            "B17.8: closed form",
        );
    }
    Ok(())
}

/// Checks that a row of bonded disks slides on a slope with little friction, and sticks with more (B17.9).
fn block(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (slope, gravity, time) = (0.5f64, 9.81, 1.5);
    for (share, slides) in [(0.5, true), (1.03, false)] {
        let friction = share * slope.tan();
        let mut value = load("wall")?;
        let cosine = slope.cos();
        value["gravity"] = json!([gravity * slope.sin(), -gravity * cosine]);
        value["boundaries"][0]["wall"] = json!({ "kind": "frictional", "friction_coefficient": friction });
        if !slides {
            // Slowly, so that the normal force does not oscillate.
            value["stages"][0]["gravity_ramp"] = json!(0.5);
        }
        let body = value["bodies"][0].clone();
        let bodies: Vec<Value> = (0..5)
            .map(|k| {
                let mut own = body.clone();
                own["name"] = json!(format!("grain {k}"));
                own["shape"]["centre"] = json!([f64::from(k) - 8.0, 0.5]);
                own["velocity"]["value"] = json!([0, 0]);
                own
            })
            .collect();
        value["bodies"] = json!(bodies);
        let own = &mut method_options(&mut value)["pairs"][0];
        own["normal"] = json!({ "law": "linear", "stiffness": 1e6, "damping_ratio": 0.3 });
        own["tangential"] = json!({ "damping_ratio": 0.3 });
        own["bond"] = json!({ "normal_stiffness": 1e6, "shear_stiffness": 1e6 });
        let mut solver = disk_solver(&value)?;
        while solver.time() < time {
            let dt = solver.limit().dt;
            step(&mut solver, dt)?;
        }
        let snapshot = solver.snapshot();
        let velocity = vectors(&snapshot, "velocity").iter().map(|v| v[0]).sum::<f64>() / 5.0;
        if slides {
            let exact = gravity * (slope.sin() - friction * cosine);
            let reason = "B17.9; 1 % for the first contact, as in B6";
            outcome.assert_close(
                "B17.9, bonded row, μ = tan β / 2: acceleration (m/s²)",
                exact,
                0.01,
                velocity / solver.time(),
                reason,
            );
        } else {
            let reason = "B17.9: static where μ > tan β; 3 % as in B9";
            outcome.assert_below(
                "B17.9, bonded row, μ = 1.03 tan β: velocity (m/s)",
                "0",
                velocity.abs(),
                1e-3,
                reason,
            );
        }
    }
    Ok(())
}
