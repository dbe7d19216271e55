//! Force curves of contact laws: Mindlin friction, adhesion, bonds (sheet: dem §2.7, §2.8; §5, B15).

use std::f64::consts::PI;

use colluvium::case::Solver;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::{Value, json};

use crate::analysis::{MaxOrNan, max_or_nan};
use crate::benchmarks::dem::case_builders::{
    disk_solver, grain_file, load, method_options, output_value, sphere_solver, step,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, vectors};

/// Benchmark of the force–displacement curves of contact laws.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/contact-laws",
    title: "Curves of force of contacts and bonds, DEM",
    source: "Mindlin 1949; Johnson, Kendall and Roberts 1971; Rabinovich et al. 2005; sheet: dem §2.7, §2.8",
    short_seconds: Some(1),
    full_seconds: 1,
    run,
};

/// Benchmark of a bonded cantilever and of the strength of a bond.
pub const BONDS: Benchmark = Benchmark {
    id: "dem/bonds",
    title: "A bonded cantilever and the strength of a bond, DEM",
    source: "Potyondy and Cundall 2004; sheet: dem §5, B15",
    short_seconds: Some(4),
    full_seconds: 4,
    run: bonds,
};

/// Radius of the spheres (m).
const RADIUS: f64 = 1e-3;
/// Effective modulus E* of the contact of two spheres (Pa).
const MODULUS: f64 = 1e7 / (2.0 * (1.0 - 0.09));
/// Effective shear modulus G* of the contact of two spheres (Pa).
const SHEAR: f64 = 1e7 / (2.0 * 1.3) / (2.0 * 1.7);
/// Effective radius (m).
const EFFECTIVE: f64 = 0.5 * RADIUS;

/// Checks tangential force with friction, adhesion after JKR, liquid bridges and cohesion against closed forms.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    check_tangential_force(&mut outcome)?;
    jkr(&mut outcome)?;
    bridge(&mut outcome)?;
    cohesion(&mut outcome)?;
    Ok(outcome)
}

/// Normal force, repulsion positive, and tangential force (N) over the displacement of a moved sphere (m).
fn move_sphere(value: &Value, steps: usize) -> Result<Vec<([f64; 2], f64, f64)>, String> {
    let mut solver = sphere_solver(value)?;
    let dt = solver.limit().dt;
    let mut curve = Vec::new();
    for _ in 0..steps {
        step(&mut solver, dt)?;
        let x = &solver.snapshot().positions;
        let (gap, displacement) = (x[1][0] - x[0][0] - 2.0 * RADIUS, x[1][1]);
        let contact = solver.contacts().first().map_or((0.0, 0.0), |contact| {
            let all: f64 = contact.force.iter().map(|f| f * f).sum();
            (contact.normal, (all - contact.normal * contact.normal).max(0.0).sqrt())
        });
        curve.push(([gap, displacement], contact.0, contact.1));
    }
    Ok(curve)
}

/// Case of two spheres at an overlap (m), of which one moves with a velocity (m/s), with steps of `dt` (s).
fn contact_case(overlap: f64, velocity: [f64; 2], dt: f64) -> Result<Value, String> {
    let mut value = load("touch")?;
    let moved = (vec![RADIUS - overlap, 0.0, 0.0], RADIUS, vec![velocity[0], velocity[1], 0.0]);
    value["bodies"][0]["points"] = grain_file("held", &[(vec![-RADIUS, 0.0, 0.0], RADIUS, vec![0.0; 3])])?;
    value["bodies"][1]["points"] = grain_file(&format!("moved-{overlap:e}-{dt:e}"), &[moved])?;
    method_options(&mut value)["time_step"] = json!(dt);
    Ok(value)
}

/// Checks the tangential force `S_t ξ` up to `μ F_n` at constant overlap.
fn check_tangential_force(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let overlap: f64 = 1e-5;
    let mut value = contact_case(overlap, [0.0, 1e-3], 1e-5)?;
    method_options(&mut value)["grains"]["grain"]["density"] = json!(1e15);
    let curve = move_sphere(&value, 1500)?;
    let normal = 4.0 / 3.0 * MODULUS * EFFECTIVE.sqrt() * overlap.powf(1.5);
    let stiffness = 8.0 * SHEAR * (EFFECTIVE * overlap).sqrt();
    let exact = |displacement: f64| (stiffness * displacement).min(0.5 * normal);
    let worst = curve.iter().map(|(x, _, t)| (t - exact(x[1])).abs() / (0.5 * normal)).max_or_nan();
    outcome.assert_close(
        "§2.8, Hertz: force at an overlap of 1e-5 m (N)",
        normal,
        1e-3,
        curve[0].1,
        "1e-3, as B2 requires",
    );
    let reason = "1 %: the spheres part by 0.6 % of the overlap over the way";
    outcome.assert_below(
        "§2.8, Mindlin: largest error of the force across over μF_n",
        "0",
        worst,
        0.01,
        reason,
    );
    let mut picture = LineChart::new(
        "Friction of two spheres at a constant overlap",
        "way across (µm)",
        "force across (N)",
    );
    let closed = (0..=150)
        .map(|k| 1e-7 * f64::from(k))
        .map(|displacement| (displacement * 1e6, exact(displacement)))
        .collect();
    picture.series.push(Series::new("8 G* √(Rδ) ξ, at most μ F_n", closed, Style::Dashed));
    let found = curve.iter().step_by(60).map(|(x, _, t)| (x[1] * 1e6, *t)).collect();
    picture.series.push(Series::new("DEM", found, Style::Markers));
    outcome.svg("§2.8: a contact sticks, then slips.", &picture)
}

/// Checks the JKR curve in loading and unloading, and the pull-off force.
fn jkr(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let work = 0.05;
    let mut value = contact_case(2e-6, [1e-3, 0.0], 2e-6)?;
    method_options(&mut value)["pairs"][0]["adhesion"] = json!({ "kind": "jkr", "work_of_adhesion": work });
    let curve = move_sphere(&value, 4000)?;
    let pull_off = 1.5 * PI * work * EFFECTIVE;
    let smallest = curve.iter().map(|(_, force, _)| -force).max_or_nan();
    let reason = "1e-3, as B2 requires of forces; closed form";
    outcome.assert_close("§2.7, JKR: pull-off force (N)", pull_off, 1e-3, smallest, reason);
    // Both in terms of the contact radius.
    let at = |a: f64| {
        let cube = a * a * a;
        let force = 4.0 * MODULUS * cube / (3.0 * EFFECTIVE) - (8.0 * PI * work * MODULUS * cube).sqrt();
        (a * a / EFFECTIVE - (2.0 * PI * work * a / MODULUS).sqrt(), force)
    };
    let tear = (PI * work * EFFECTIVE * EFFECTIVE / (8.0 * MODULUS)).cbrt();
    let widths = (0..=4000).map(|k| tear * (1.0 + 0.001 * f64::from(k)));
    let closed: Vec<(f64, f64)> = widths.map(at).collect();
    let overlap_at_tear = closed[0].0;
    let force_at = |overlap: f64| {
        let k = closed.partition_point(|(own, _)| *own < overlap).clamp(1, closed.len() - 1);
        let ((x0, y0), (x1, y1)) = (closed[k - 1], closed[k]);
        y0 + (y1 - y0) * (overlap - x0) / (x1 - x0)
    };
    let touching: Vec<(f64, f64)> =
        curve.iter().filter(|(_, force, _)| *force != 0.0).map(|(x, f, _)| (-x[0], *f)).collect();
    let inner =
        touching.iter().filter(|(overlap, _)| *overlap > overlap_at_tear && *overlap < closed[4000].0);
    let worst = inner.map(|(overlap, force)| (force - force_at(*overlap)).abs() / pull_off).max_or_nan();
    outcome.assert_below(
        "§2.7, JKR: largest error of the force over the pull-off force",
        "0",
        worst,
        1e-3,
        reason,
    );
    let last = touching.last().map_or(f64::NAN, |(overlap, _)| *overlap);
    let reason = "two steps of 2e-9 m beside the closed form";
    let range = (overlap_at_tear - 4e-9, overlap_at_tear + 4e-9);
    outcome.assert_within(
        "§2.7, JKR: overlap at which they part (m)",
        &format!("{overlap_at_tear:.4e}"),
        last,
        range,
        reason,
    );
    let mut picture = LineChart::new("Two adhesive spheres are parted", "overlap (µm)", "force (mN)");
    let shown = closed.iter().filter(|(overlap, _)| *overlap < 2e-6);
    picture.series.push(Series::new("JKR", shown.map(|(x, f)| (x * 1e6, f * 1e3)).collect(), Style::Dashed));
    let found = touching.iter().step_by(60).map(|(x, f)| (x * 1e6, f * 1e3)).collect();
    picture.series.push(Series::new("DEM", found, Style::Markers));
    outcome.svg("§2.7: the pull-off force is 3/2 π w R.", &picture)
}

/// Checks the capillary bridge: force on contact, and the rupture distance.
fn bridge(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (tension, ratio) = (0.072, 0.01);
    let mut value = contact_case(1e-8, [1e-3, 0.0], 2e-5)?;
    method_options(&mut value)["pairs"][0]["adhesion"] =
        json!({ "kind": "capillary", "surface_tension": tension, "volume_ratio": ratio });
    let curve = move_sphere(&value, 5600)?;
    let maximum = 4.0 * PI * EFFECTIVE * tension;
    let reason = "1e-3, as B2 requires of forces";
    let first = curve.iter().find(|(x, ..)| x[0] >= 0.0).map_or(f64::NAN, |(_, force, _)| -force);
    outcome.assert_close(
        "§2.7, liquid bridge: force of spheres that touch, 4πRγ (N)",
        maximum,
        2e-2,
        first,
        "the gap of the first step",
    );
    let volume = ratio * EFFECTIVE.powi(3);
    let closed = |gap: f64| {
        let depth = 0.5 * gap * ((1.0 + volume / (PI * EFFECTIVE * gap * gap)).sqrt() - 1.0);
        maximum / (1.0 + gap / (2.0 * depth))
    };
    let parted: Vec<(f64, f64)> =
        curve.iter().filter(|(x, f, _)| x[0] > 1e-8 && *f < 0.0).map(|(x, f, _)| (x[0], -f)).collect();
    let worst = parted.iter().map(|(gap, force)| (force - closed(*gap)).abs() / maximum).max_or_nan();
    outcome.assert_below(
        "§2.7, liquid bridge: largest error over the force on contact",
        "0",
        worst,
        1e-3,
        reason,
    );
    let last = parted.last().map_or(f64::NAN, |(gap, _)| *gap);
    let rupture = volume.cbrt();
    outcome.assert_close(
        "§2.7, liquid bridge: gap at which it breaks (m)",
        rupture,
        1e-3,
        last,
        "1e-3: five steps of 2e-8 m",
    );
    let mut picture = LineChart::new("A bridge of liquid between two spheres", "gap (µm)", "attraction (mN)");
    let exact =
        (1..=100).map(|k| rupture * 0.01 * f64::from(k)).map(|gap| (gap * 1e6, closed(gap) * 1e3)).collect();
    picture.series.push(Series::new("Rabinovich et al.", exact, Style::Dashed));
    let found = parted.iter().step_by(120).map(|(gap, force)| (gap * 1e6, force * 1e3)).collect();
    picture.series.push(Series::new("DEM", found, Style::Markers));
    outcome.svg("§2.7: attraction falls with the gap and ends where the bridge breaks.", &picture)
}

/// Checks that a cohesive contact breaks at its strength.
fn cohesion(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut value = contact_case(1e-6, [1e-3, 0.0], 1e-6)?;
    let own = &mut method_options(&mut value)["pairs"][0];
    own["normal"] = json!({ "law": "linear", "stiffness": 1e3, "damping_ratio": 0 });
    own["adhesion"] = json!({ "kind": "cohesive", "tension": 1e3, "shear": 1e3 });
    let curve = move_sphere(&value, 4000)?;
    let maximum = curve.iter().map(|(_, force, _)| -force).max_or_nan();
    // 1e3 Pa on the square of the radius; a step loads by 1e3 N/m times 1e-9 m.
    outcome.assert_close(
        "§2.7, cohesion: largest tension (N)",
        1e3 * RADIUS * RADIUS,
        2e-3,
        maximum,
        "two steps of 1e-9 m",
    );
    Ok(())
}

/// Checks the deflection of a bonded cantilever and the strength of a bond.
fn bonds(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut solver = disk_solver(&load("beam")?)?;
    for _ in 0..400_000 {
        let dt = solver.limit().dt;
        step(&mut solver, dt)?;
    }
    let displacement = vectors(&solver.snapshot(), "displacement");
    let (rotation, shear) = (1e3, 1e4);
    let load_at_end = 1e-3
        * (beam(10, 10, rotation, shear) + (1..10).map(|k| 0.01 * beam(k, 10, rotation, shear)).sum::<f64>());
    let reason = "B15, small rotations; 1e-3 for the contacts beside the bonds and what still swings";
    outcome.assert_close(
        "B15, cantilever: the sheet's deflection under the load (m)",
        3.335e-4,
        1e-6,
        1e-3 * beam(10, 10, rotation, shear),
        "closed form of this code and of the sheet",
    );
    outcome.assert_close(
        "B15, cantilever: deflection of the end (m)",
        load_at_end,
        1e-3,
        -displacement[10][1],
        reason,
    );
    let mut picture = LineChart::new("A bonded cantilever", "place (m)", "deflection (mm)");
    let exact = (0..=10).map(|at| (f64::from(at), -1e3 * line(at, rotation, shear))).collect();
    picture.series.push(Series::new("closed form", exact, Style::Dashed));
    let found = displacement.iter().enumerate().map(|(k, u)| (k as f64, 1e3 * u[1])).collect();
    picture.series.push(Series::new("DEM", found, Style::Markers));
    outcome.svg("B15: ten disks bonded to a held one.", &picture)?;
    check_bond_strength(&mut outcome)?;
    Ok(outcome)
}

/// Deflection of the last one of `n` links of a metre under a unit load on link `at`. Each joint lies half a link behind its link.
fn beam(at: u32, n: u32, rotation: f64, shear: f64) -> f64 {
    let joint = |k: u32| f64::from(k) - 0.5;
    (1..=at.min(n))
        .map(|k| (f64::from(at) - joint(k)) * (f64::from(n) - joint(k)) / rotation + 1.0 / shear)
        .sum()
}

/// Deflection of disk `at` of a row of ten disks bonded to a fixed one (m). Each disk carries a transverse load, the last one the largest.
fn line(at: u32, rotation: f64, shear: f64) -> f64 {
    (1..=10)
        .map(|k| {
            let (load, low, high) = (if k == 10 { 1e-3 } else { 1e-5 }, at.min(k), at.max(k));
            load * beam(low, high, rotation, shear)
        })
        .sum()
}

/// Checks the tension and the shear at which a bond breaks, and the stiffness of the bond.
fn check_bond_strength(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let reason = "0.2 %: the force of two steps";
    let mut picture = LineChart::default();
    for (name, velocity) in [("tension", [1e-3, 0.0]), ("shear", [0.0, 1e-3])] {
        let mut value = load("bonded")?;
        value["bodies"][1]["velocity"]["value"] = json!(velocity);
        let own = method_options(&mut value);
        own["time_step"] = json!(1e-4);
        if name == "shear" {
            // Without moments in the stresses, the lever arm of the shear is the radius.
            own["pairs"][0]["bond"]["moment_factor"] = json!(0);
        }
        let mut solver = disk_solver(&value)?;
        let mut curve = Vec::new();
        for _ in 0..1200 {
            step(&mut solver, 1e-4)?;
            let force =
                solver.contacts().first().map_or(0.0, |c| max_or_nan(c.force[0].abs(), c.force[1].abs()));
            curve.push((solver.time() * 1e-3 * 1e6, force));
        }
        let largest = curve.iter().map(|(_, force)| *force).max_or_nan();
        outcome.assert_close(
            format!("B15, {name} at which a bond of 100 Pa over 1 m² breaks (N)"),
            100.0,
            2e-3,
            largest,
            reason,
        );
        let stiffness = curve[499].1 / (curve[499].0 * 1e-6);
        outcome.assert_close(
            format!("§2.7, stiffness of a bond in {name} (N/m)"),
            1e6,
            3e-3,
            stiffness,
            reason,
        );
        outcome.assert_within(
            format!("B15, {name}: bonds broken"),
            "1",
            output_value(&solver, "broken_bonds"),
            (1.0, 1.0),
            "one bond",
        );
        picture.series.push(Series::new(name, curve, Style::Line));
    }
    (picture.title, picture.x_label, picture.y_label) =
        ("A bond is parted".into(), "way (µm)".into(), "force (N)".into());
    outcome.svg("B15: it breaks at its strength.", &picture)
}
