//! The block on an inclined plane (sheet: mpm A-14; sheet: sph §2.13), an obstacle, by all methods.

use colluvium::case::description::{ObstacleShape, ObstacleWall};
use colluvium::case::{Case, RunReport};
use colluvium::plots::{Series, Style};
use serde_json::json;

use super::{Together, chart};
use crate::analysis::{Largest, slope};
use crate::benchmarks::mpm::inclined_block::{ANGLE, LOADED, after, along, speeds, way};
use crate::benchmarks::{Benchmark, Outcome, case, run_by, set_of};

/// The benchmark.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "compare/inclined-block",
    title: "Block on an inclined plane as an obstacle: MPM, SPH, DEM, snow MPM and depth-integrated flow",
    source: "closed form",
    quick: Some(25),
    full: 60,
    run: benchmark,
};

/// Error of the acceleration over g sin θ that each method may have.
const METHODS: [(&str, f64, &str); 4] = [
    ("mpm", 0.01, "1 % of g sin θ"),
    ("sph", 0.03, "3 % of g sin θ"),
    ("snow-mpm", 0.01, "1 % of g sin θ, as mpm"),
    ("dem", 0.01, "1 % of g sin θ: bonded disks that slide on their contacts"),
];

fn benchmark(quick: bool) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let tangent = ANGLE.to_radians().tan();
    let mut picture =
        chart("Velocity along a plane of 30°, friction of 0.3 tan θ", "time (s)", "velocity (m/s)");
    let mut together = Together::default();
    for (method, band, reason) in METHODS {
        // mpm/inclined-block has the rest of MPM.
        let few = quick && method != "sph";
        for share in if few { &[0.3][..] } else { &[0.0, 0.3, 0.6] }.iter().copied() {
            let report = run_by(method, &block(share * tangent, None)?)?;
            let exact = along() * (1.0 - share);
            outcome.within(
                format!("{method}, μ = {share} tan θ: error of the acceleration over g sin θ"),
                &format!("g (sin θ - μ cos θ) = {exact:.4} m/s²"),
                (slope(&after(&report)) - exact) / along(),
                (-band, band),
                reason,
            );
            if share == 0.3 {
                if ["mpm", "sph"].contains(&method) {
                    forms(&mut outcome, method, &report)?;
                }
                picture.series.push(Series::new(method, speeds(&report), Style::Line));
                together.add(method, &report);
            }
        }
        if few {
            continue;
        }
        let report = run_by(method, &block(1.2 * tangent, None)?)?;
        outcome.below(
            format!("{method}, μ = 1.2 tan θ: drift in 1 s over the length of the block"),
            "at rest",
            way(&report).abs(),
            1e-3,
            "a thousandth of its length",
        );
    }
    flow(&mut outcome, &mut together)?;
    let exact = 0.7 * along();
    let line = vec![(LOADED, 0.5 * LOADED * exact), (1.2, 1.1 * exact)];
    picture.series.push(Series::new("closed form", line, Style::Dashed));
    outcome.svg("Velocity of the centre of mass, μ = 0.3 tan θ.", &picture)?;
    together.show(&mut outcome, &block(0.3 * tangent, None)?, "compare/inclined-block")?;
    Ok(outcome)
}

/// The block as depth-integrated flow.
fn flow(outcome: &mut Outcome, together: &mut Together) -> Result<(), String> {
    let friction = 0.3 * ANGLE.to_radians().tan();
    let mut case = block(friction, None)?;
    let basal = json!({ "model": "coulomb", "friction_angle": friction.atan().to_degrees() });
    set_of(&mut case, "depth-sph", "basal", basal);
    let report = run_by("depth-sph", &case)?;
    outcome.show(
        "depth-sph, μ = 0.3 tan θ: error of the acceleration over g sin θ",
        &format!("g (sin θ - μ cos θ) = {:.4} m/s²", 0.7 * along()),
        (slope(&after(&report)) - 0.7 * along()) / along(),
        "not judged: a block half as high as long is outside of shallow flow, and without strength it slumps over twice its length",
    );
    together.add("depth-sph", &report);
    Ok(())
}

/// The same plane as a ground line and as a polygon.
fn forms(outcome: &mut Outcome, method: &str, plane: &RunReport) -> Result<(), String> {
    let tangent = ANGLE.to_radians().tan();
    let at = |x: f64| [x, 2.5 - x * tangent];
    for (name, form) in [
        ("ground line", ObstacleShape::GroundLine { points: vec![at(-1.0), at(6.0)], file: None }),
        ("polygon", ObstacleShape::Polygon { vertices: vec![at(-1.0), at(6.0), [6.0, -3.0], [-1.0, -3.0]] }),
    ] {
        let other = speeds(&run_by(method, &block(0.3 * tangent, Some(form))?)?);
        let apart = speeds(plane).iter().zip(&other).map(|(a, b)| (a.1 - b.1).abs()).largest();
        outcome.below(
            format!("{method}, {name} against half-space: largest difference of velocity (m/s)"),
            "the same plane",
            apart,
            1e-6,
            "round-off that grows",
        );
    }
    Ok(())
}

fn block(friction: f64, form: Option<ObstacleShape>) -> Result<Case, String> {
    let mut case = case("compare/inclined-block")?;
    let obstacle = &mut case.obstacles[0];
    obstacle.wall = ObstacleWall::Frictional { friction_coefficient: friction, adhesion: 0.0 };
    if let Some(form) = form {
        obstacle.shape = form;
    }
    Ok(case)
}
