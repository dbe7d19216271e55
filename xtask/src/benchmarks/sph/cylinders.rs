//! Collapse of cylinders in three dimensions (sheet: sph B-11).

use colluvium::case::Snapshot;
use colluvium::plots::PointCloud;
use colluvium::points::Shape;

use crate::analysis::{MaxOrNan, farthest_connected, mass_quantile_position};
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, run_in_memory, set_material, set_method_option,
};

/// Benchmark of the collapse of cylinders in three dimensions.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/cylinders",
    title: "Collapse of cylinders, SPH in three dimensions",
    source: "Lube et al. 2004; Bui & Nguyen 2021, Fig. 30; sheet: sph B-11",
    short_seconds: None,
    full_seconds: 1400,
    run,
};

/// Radius of the cylinder (m).
const RADIUS: f64 = 0.097;
/// Yield surface: material of the case, matching of its cone to Mohr–Coulomb (that of the case where `None`), and label of the checks.
type ConeMatching = (&'static str, Option<&'static str>, &'static str);
/// Drucker–Prager cone through triaxial compression, the strongest, which the source has.
const CONE: ConeMatching = ("sand", None, "");
/// Drucker–Prager cone through triaxial extension, the weakest.
const WEAKEST: ConeMatching = ("sand", Some("extension"), ", cone through extension");
/// Mohr–Coulomb pyramid, with one friction angle in every direction.
const PYRAMID: ConeMatching = ("pyramid", None, ", Mohr–Coulomb");

/// Distance from the axis within which 99.9 % of the particles lie, plus half a spacing (m): the run-out of sheet: mpm §3.9, A-28.
fn outer_radius(snapshot: &Snapshot, spacing: f64) -> f64 {
    mass_quantile_position(snapshot, 0.999, radius) + 0.5 * spacing
}

/// Distance from the axis (m).
fn radius(x: &[f64; 3]) -> f64 {
    x[0].hypot(x[1])
}

/// Checks run-outs of cylinders of sand with three yield surfaces.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    for (ratio, spacing, (material, matching, law)) in [
        (0.55, 0.0097, CONE),
        (0.55, 0.005, CONE),
        (0.9, 0.005, CONE),
        (0.55, 0.005, WEAKEST),
        (0.9, 0.005, WEAKEST),
        (0.55, 0.005, PYRAMID),
        (0.9, 0.005, PYRAMID),
    ] {
        let mut case = load_case("sph/cylinder")?;
        case.bodies[0].material = material.into();
        if let Some(matching) = matching {
            set_material(&mut case, material, &[("matching", matching.into())])?;
        }
        set_method_option(&mut case, "sph", "spacing", spacing);
        let height = ratio * RADIUS;
        case.domain.max[2] = 1.5 * height;
        let column = Shape::Cylinder { base: [0.0; 3], axis: 2, radius: RADIUS, height };
        let quarter = Shape::Box { min: vec![0.0; 3], max: case.domain.max.clone() };
        case.bodies[0].shape = Shape::Intersection { shapes: vec![column, quarter] };
        let snapshot = run_in_memory("sph", &case)?.snapshot;
        let name = |what: &str| format!("a = {ratio}, spacing {} mm{law}: {what}", spacing * 1e3);
        let expected = 1.24 * ratio;
        let found = outer_radius(&snapshot, spacing) / RADIUS - 1.0;
        let layers = height / spacing;
        if spacing > 0.06 * RADIUS {
            let reason = "not judged: five layers of particles; judged at 5 mm";
            outcome.info(name("run-out over radius"), &format!("{expected:.3}"), found, reason);
        } else {
            let reason = "B-11: 1.24 a of Lube et al. 2004 ± 15 %";
            outcome.assert_close(name("run-out over radius"), expected, 0.15, found, reason);
        }
        let held = (farthest_connected(&snapshot, spacing, radius) + 0.5 * spacing) / RADIUS - 1.0;
        let reason = "not judged: set S is plane; the layer at the edge of a cylinder thins in two directions, to \
                      distances beyond 1.5 spacings";
        outcome.info(name("the same by the front of set S"), &format!("{expected:.3}"), held, reason);
        outcome.info(name("layers of particles"), "", layers.round(), "how coarse it is");
        let top = |x: &&[f64; 3]| radius(x) < 0.15 * RADIUS;
        let crest = snapshot.positions.iter().filter(top).map(|x| x[2]).max_or_nan() + 0.5 * spacing;
        let label = name("height at the axis over the initial height");
        let found = crest / (layers.round() * spacing);
        if ratio < 0.74 && spacing <= 0.06 * RADIUS {
            let reason = "B-11: the plateau stays undisturbed for a < 0.74; 1 %, as set S has it";
            outcome.assert_close(label, 1.0, 0.01, found, reason);
        } else {
            let reason = "not judged: B-11 has it for a < 0.74, judged at 5 mm";
            outcome.info(label, if ratio < 0.74 { "1" } else { "" }, found, reason);
        }
        if let Some(cloud) = PointCloud::from_snapshot(&snapshot, "displacement", [0, 2]) {
            outcome.png(&format!("Displacement at rest, aspect ratio {ratio}."), &cloud)?;
        }
    }
    Ok(outcome)
}
