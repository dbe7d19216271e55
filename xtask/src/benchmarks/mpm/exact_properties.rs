//! Exact properties: shape functions, conservation, filters, boundary conditions, equilibrium (sheet: mpm §5.1, §5.2).

use colluvium::case::description::InitialStress;
use colluvium::case::{Budget, Case, RunOptions, Solver};
use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::mpm::shape_functions;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, final_measure, load_case, patched_case, run_mpm, set_mpm_option, stresses,
    vectors,
};

/// Benchmark of exact properties of shape functions, conservation, filters, supports and equilibrium.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/units",
    title: "Shape functions, conservation, filters, supports, equilibrium",
    source: "sheet: mpm S-04, S-05, S-08, A-01, A-02, A-03, A-17, A-32, A-33, closed forms",
    short_seconds: Some(6),
    full_seconds: 6,
    run: benchmark,
};

/// Checks exact properties of shape functions, transfers, filters and boundary conditions.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    shape_functions::shape_functions(&mut outcome);
    shape_functions::cell_crossing(&mut outcome);
    integration_by_cells(&mut outcome)?;
    shape_functions::transfers(&mut outcome);
    conservation(&mut outcome)?;
    angular_momentum(&mut outcome)?;
    filters(&mut outcome)?;
    check_affine_velocity(&mut outcome)?;
    oscillator(&mut outcome)?;
    floor_without_material(&mut outcome)?;
    traction(&mut outcome)?;
    settling(&mut outcome)?;
    mass_scaling(&mut outcome)?;
    Ok(outcome)
}

/// Solver at the beginning of its first stage.
fn start(case: &Case) -> Result<Box<dyn Solver>, String> {
    let method = colluvium::method("mpm").ok_or("no method mpm")?;
    let mut solver = method.build(case).map_err(|error| error.to_string())?;
    solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
    Ok(solver)
}

/// Advances a solver by its largest stable step.
fn step(solver: &mut dyn Solver) -> Result<(), String> {
    let dt = solver.limit().dt;
    solver.step(dt).map(drop).map_err(|error| error.to_string())
}

/// Checks integration by cells: cells with three, two and three points under a uniform stress, free at both ends (S-04).
fn integration_by_cells(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for integration in ["points", "mixed", "gauss"] {
        let mut bar = load_case("mpm/crossing-bar")?;
        set_mpm_option(&mut bar, "integration", integration);
        let mut solver = start(&bar)?;
        let dt = solver.limit().dt;
        solver.step(dt).map_err(|error| error.to_string())?;
        let snapshot = solver.snapshot();
        // The forces at the two inner nodes accelerate the points between them.
        let inner = snapshot.positions.iter().zip(vectors(&snapshot, "velocity"));
        let force =
            inner.filter(|(x, _)| (1.0..2.0).contains(&x[0])).map(|(_, v)| (v[0] / dt).abs()).max_or_nan();
        let name = format!("S-04 integration `{integration}`: acceleration within the middle cell (m/s²)");
        if integration == "points" {
            let reason = "the sheet: ± σ Ω_p at the inner nodes, here not balanced";
            outcome.assert_within(name, "not 0", force, (1e-4, f64::INFINITY), reason);
        } else {
            outcome.assert_below(name, "0", force, 1e-12, "the sheet: 0 to round-off");
        }
    }
    Ok(())
}

/// Checks the conservation of momentum over steps.
fn conservation(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let change = |before: &Budget, after: &Budget| {
        (0..2).map(|c| (after.momentum[c] - before.momentum[c]).abs()).max_or_nan()
    };
    for shape in ["linear", "ugimp", "cpgimp", "quadratic", "cubic"] {
        for scheme in ["usf", "usl", "musl"] {
            let mut case = load_case("mpm/spinning-block")?;
            set_mpm_option(&mut case, "shape", shape);
            set_mpm_option(&mut case, "stress_update", scheme);
            if shape == "cpgimp" {
                set_mpm_option(&mut case, "domain_stretch", "right-stretch");
            }
            // Nodes below the cut-off take no force, which is lost momentum: with 10⁻¹² of a point up to 10⁻¹⁰ of it.
            set_mpm_option(&mut case, "node_mass_cutoff", 1e-24);
            if (shape, scheme) == ("linear", "usl") {
                // Unstable at nodes of small mass (P-02); see the page on validation.
                continue;
            }
            let mut solver = start(&case)?;
            let before = solver.totals();
            let speeds: f64 = vectors(&solver.snapshot(), "velocity").iter().map(|v| v[0].hypot(v[1])).sum();
            let scale = speeds * before.mass / solver.point_count() as f64;
            for _ in 0..1000 {
                step(&mut *solver)?;
            }
            let error = change(&before, &solver.totals()) / scale;
            let name = format!("A-02 {shape}, {scheme}: change of momentum in 10³ steps over Σ m|v|");
            outcome.assert_below(name, "0", error, 1e-12, "the sheet's 1e-12");
        }
    }
    Ok(())
}

/// Checks the conservation of angular momentum by APIC.
fn angular_momentum(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for shape in ["quadratic", "cubic"] {
        let mut case = load_case("mpm/spinning-block")?;
        set_mpm_option(&mut case, "shape", shape);
        set_mpm_option(&mut case, "transfer", "apic");
        set_mpm_option(&mut case, "stress_update", "usl");
        let mut solver = start(&case)?;
        let before = solver.totals();
        let snapshot = solver.snapshot();
        let arms = snapshot.positions.iter().zip(vectors(&snapshot, "velocity"));
        let arms: f64 = arms.map(|(x, v)| x[0].hypot(x[1]) * v[0].hypot(v[1])).sum();
        let scale = arms * before.mass / solver.point_count() as f64;
        for _ in 0..1000 {
            step(&mut *solver)?;
        }
        // Parts of it nearly cancel: relative to the sum of their sizes.
        let turn = (solver.totals().angular_momentum[2] - before.angular_momentum[2]).abs() / scale;
        let name = format!("A-02 APIC, {shape}: change of angular momentum in 10³ steps over Σ m|x||v|");
        outcome.assert_below(name, "0", turn, 1e-10, "the sheet's 1e-10");
    }
    Ok(())
}

/// Checks the reduction of a velocity mode by one step, with one point in the middle of each cell.
fn filters(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let eighth = std::f64::consts::PI / 8.0;
    let rows = [
        ("FLIP, βh = 1", serde_json::json!({}), 1.0, 1.0),
        ("PIC, βh = 1", serde_json::json!({ "flip": 0 }), 1.0, 0.770_151),
        ("PIC, βh = π/8", serde_json::json!({ "flip": 0 }), eighth, 0.961_940),
        ("XPIC(2), βh = 1", serde_json::json!({ "transfer": "xpic" }), 1.0, 0.947_170),
        ("XPIC(2), βh = π/8", serde_json::json!({ "transfer": "xpic" }), eighth, 0.998_551),
        ("XPIC(3), βh = π/8", serde_json::json!({ "transfer": "xpic", "xpic_order": 3 }), eighth, 0.999_945),
    ];
    for (name, options, wave, exact) in rows {
        let mut line = load_case("mpm/mode-on-a-line")?;
        for (key, value) in options.as_object().into_iter().flatten() {
            set_mpm_option(&mut line, key, value.clone());
        }
        let waves = serde_json::json!([wave]);
        let mut solver = start(&patched_case(&line, &[("/bodies/0/velocity/wave_vector", waves)])?)?;
        let before = vectors(&solver.snapshot(), "velocity");
        solver.step(1e-6).map_err(|error| error.to_string())?;
        let after = vectors(&solver.snapshot(), "velocity");
        // The least factor of velocities far from zero, in the middle.
        let factor = (50..70).filter(|p| before[*p][0].abs() > 0.3).map(|p| after[p][0] / before[p][0]);
        let name = format!("A-03 {name}: what one step leaves of the mode");
        outcome.assert_close(
            name,
            exact,
            2e-6,
            factor.fold(f64::INFINITY, f64::min),
            "six digits of the closed form; the step bends it by 1e-9",
        );
    }
    Ok(())
}

/// Checks that a step of APIC preserves a linear velocity field.
fn check_affine_velocity(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for shape in ["quadratic", "cubic"] {
        let mut case = load_case("mpm/patch")?;
        set_mpm_option(&mut case, "shape", shape);
        set_mpm_option(&mut case, "transfer", "apic");
        case.bodies[0].stress = InitialStress::default();
        let before = start(&case)?.snapshot();
        let after = run_mpm(&case)?.snapshot;
        let inside = |x: &[f64; 3]| (0..2).all(|c| x[c].abs() < 0.3);
        let pairs =
            before.positions.iter().zip(vectors(&before, "velocity")).zip(vectors(&after, "velocity"));
        let changes =
            pairs.filter(|((x, _), _)| inside(x)).map(|((_, v), w)| (v[0] - w[0]).hypot(v[1] - w[1]));
        let name = format!("A-03 APIC, {shape}: change of a linear velocity field in one step (m/s)");
        outcome.assert_below(name, "0", changes.max_or_nan(), 1e-12, "exact: round-off");
    }
    Ok(())
}

/// Checks the motion of a point in a cell with local damping.
fn oscillator(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let rows = [
        (0.05, 0.951_190, 3.144_543),
        (0.1, 0.904_534, 3.153_460),
        (0.5, 0.577_350, 3.503_991),
        (0.7, 0.420_084, 4.072_614),
    ];
    let mut chart = LineChart::new(
        "Local damping of one degree of freedom",
        "time (√(m/k))",
        "displacement over speed at the start",
    );
    for (damping, ratio, half_period) in rows {
        let mut point = load_case("mpm/one-point")?;
        point.stages[0].damping = damping;
        let mut solver = start(&point)?;
        let (mut turns, mut last, mut curve) = (Vec::new(), (0.0, 1e-7), Vec::new());
        while turns.len() < 3 {
            solver.step(1e-3).map_err(|error| error.to_string())?;
            let snapshot = solver.snapshot();
            let now = (vectors(&snapshot, "displacement")[0][0], vectors(&snapshot, "velocity")[0][0]);
            if now.1 * last.1 < 0.0 {
                let share = last.1 / (last.1 - now.1);
                turns.push((snapshot.time - 1e-3 * (1.0 - share), last.0 + share * (now.0 - last.0)));
            }
            curve.push((snapshot.time, now.0 / 1e-7));
            last = now;
        }
        let name = |what: &str| format!("A-17 α = {damping}: {what}");
        outcome.assert_close(
            name("amplitude ratio of half a cycle"),
            ratio,
            1e-3,
            -turns[2].1 / turns[1].1,
            "the sheet's 0.1 %",
        );
        outcome.assert_close(
            name("half period (√(m/k))"),
            half_period,
            1e-3,
            turns[2].0 - turns[1].0,
            "the sheet's 0.1 %",
        );
        chart.series.push(Series::new(format!("α = {damping}"), curve, Style::Line));
    }
    outcome.svg("A degree of freedom under local damping.", &chart)
}

/// Checks that supports constrain nodes before material reaches them; without them the block leaves the domain (S-08).
fn floor_without_material(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let patch = load_case("mpm/drop")?;
    let mut free = patch.clone();
    free.stages[0].motions.clear();
    let mut wall = free.clone();
    let floor = serde_json::json!([{ "side": "y-min", "position": 0.5, "wall": { "kind": "rough" } }]);
    wall.boundaries = serde_json::from_value(floor).map_err(|error| error.to_string())?;
    for (support, case) in [("a patch", patch), ("a wall", wall)] {
        let (lowest, error) = lowest_position(&case)?;
        if let Some(error) = error {
            return Err(error);
        }
        outcome.assert_within(
            format!("S-08 fall onto {support} without material: lowest place (m)"),
            "0.5, at least 0.4",
            lowest,
            (0.4, 0.6),
            "the sheet: no penetration by more than a cell, 0.1 m",
        );
    }
    let (lowest, error) = lowest_position(&free)?;
    let reason = "without the support it must fail";
    let left = error.is_some_and(|error| error.contains("it left the domain"));
    outcome.assert_close(
        "S-08 the same without a support: leaves the domain (1: yes)",
        1.0,
        0.0,
        f64::from(left),
        reason,
    );
    let name = "S-08 the same without a support: lowest place before (m)";
    outcome.assert_below(name, "0: falls through", lowest, 0.1, "within a cell of the end of the domain");
    Ok(())
}

/// Lowest position of a case's points (m), and the error that ends the run, if any.
fn lowest_position(case: &Case) -> Result<(f64, Option<String>), String> {
    let mut solver = start(case)?;
    let mut lowest = f64::INFINITY;
    while solver.time() < case.stages[0].duration {
        if let Err(error) = step(&mut *solver) {
            return Ok((lowest, Some(error)));
        }
        let snapshot = solver.snapshot();
        let ends = snapshot.positions.iter().zip(&snapshot.extents).map(|(x, e)| x[1] - 0.5 * e[1]);
        lowest = ends.fold(lowest, f64::min);
    }
    Ok((lowest, None))
}

/// Checks the momentum that a traction adds in a step (S-08).
fn traction(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    for shape in ["linear", "ugimp", "quadratic"] {
        let mut case = load_case("mpm/drop")?;
        case.gravity = vec![0.0, 0.0];
        case.stages[0].motions.clear();
        let load =
            serde_json::json!([{ "kind": "traction", "body": "block", "side": "y-max", "value": [30, -70] }]);
        case.loads = serde_json::from_value(load).map_err(|error| error.to_string())?;
        set_mpm_option(&mut case, "shape", shape);
        let mut solver = start(&case)?;
        let before = solver.totals();
        let dt = 1e-3;
        solver.step(dt).map_err(|error| error.to_string())?;
        let after = solver.totals();
        // On 0.4 m, a metre thick.
        let exact = [30.0 * 0.4, -70.0 * 0.4];
        let force = [0, 1].map(|c| (after.momentum[c] - before.momentum[c]) / dt);
        let error = (0..2).map(|c| (force[c] / exact[c] - 1.0).abs()).max_or_nan();
        outcome.assert_below(
            format!("S-08 {shape}: force of a traction, relative error"),
            "0",
            error,
            1e-12,
            "the sheet's 1e-12",
        );
        // About the middle of the loaded side, (0.5, 1.4) m.
        let moment =
            (after.angular_momentum[2] - before.angular_momentum[2]) / dt - (0.5 * force[1] - 1.4 * force[0]);
        let bound = 30f64.hypot(70.0) * 0.4 * 0.05;
        outcome.assert_below(
            format!("S-08 {shape}: moment of a traction about the middle of its side (N m)"),
            "0, at most τ S h/2",
            moment.abs(),
            bound,
            "the sheet's bound",
        );
    }
    Ok(())
}

/// Checks that a column settles to equilibrium, and that a run that does not is reported.
fn settling(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let case = load_case("mpm/settling-column")?;
    let report = run_mpm(&case)?;
    for (column, what) in [("unbalanced_force", "unbalanced force"), ("kinetic_ratio", "kinetic energy")] {
        let last = final_measure(&report, column);
        let name = format!("A-32 column: {what} at the end over what acts from outside");
        outcome.assert_below(name, "below 1e-2", last, 1e-2, "the sheet's criterion");
    }
    let base = stresses(&report.snapshot)[0][1];
    let depth = 1.0 - report.snapshot.positions[0][1];
    let ratio = base / (1e4 * depth);
    let name = "A-32 column: stress of the lowest point over ρ g depth";
    outcome.info(name, "-1", ratio, "the sheet judges the criteria");
    let mut short = case;
    short.stages[0].duration = 0.05;
    let method = colluvium::method("mpm").ok_or("no method mpm")?;
    let solver = method.build(&short).map_err(|error| error.to_string())?;
    let says = match colluvium::case::run(&short, solver, &RunOptions::default()) {
        Err(error) => f64::from(error.to_string().contains("no equilibrium")),
        Ok(_) => 0.0,
    };
    let name = "A-32 a run that does not converge reports it (1: yes)";
    outcome.assert_close(name, 1.0, 0.0, says, "the sheet");
    Ok(())
}

/// Checks that mass scaling changes the time step and not the settlement.
fn mass_scaling(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let settlement = |case: &Case| -> Result<f64, String> {
        let displacement = vectors(&run_mpm(case)?.snapshot, "displacement");
        Ok(displacement.iter().map(|u| u[1]).fold(0.0, f64::min))
    };
    let mut fine = load_case("mpm/settling-column")?;
    let criterion = serde_json::json!({ "unbalanced_force": 1e-5, "kinetic_energy": 1e-8 });
    fine.stages[0].equilibrium = serde_json::from_value(criterion).map_err(|error| error.to_string())?;
    let mut scaled = fine.clone();
    set_mpm_option(&mut scaled, "mass_scaling", 100.0);
    let dt = |case: &Case| start(case).map(|mut solver| solver.limit().dt);
    let name = "A-33 mass scaling 100: time step over that without";
    outcome.assert_close(name, 10.0, 1e-9, dt(&scaled)? / dt(&fine)?, "√β");
    let (plain, heavy) = (settlement(&fine)?, settlement(&scaled)?);
    let name = "A-33 mass scaling 100: settlement over that without";
    outcome.assert_close(name, 1.0, 1e-3, heavy / plain, "the sheet's 0.1 %");
    Ok(())
}
