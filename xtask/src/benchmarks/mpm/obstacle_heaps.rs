//! Sand on obstacles in space: a heap on four forms of one plane, and a slide of 10⁵ points on a raster (sheet: mpm A-14).

use colluvium::case::description::ObstacleShape;
use colluvium::case::{Case, RunReport};
use colluvium::plots::PointCloud;

use super::inclined_block::ANGLE;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, ObstacleEnergyShares, centre_of_mass, load_case, max_penetration,
    obstacle_energy_shares, run_mpm,
};

/// Benchmark of a heap of sand on a plane in four forms.
pub const HEAPS: Benchmark = Benchmark {
    id: "mpm/heap-on-planes",
    title: "Heap of sand on a plane given as half-space, polygon, raster and closed wedge",
    source: "agreement of the forms; sheet: mpm A-14",
    short_seconds: Some(20),
    full_seconds: 40,
    run: heaps,
};

/// Benchmark of a slide of 10⁵ points on a raster of heights.
pub const TERRAIN: Benchmark = Benchmark {
    id: "mpm/terrain-flow",
    title: "Slide of 10⁵ points on a raster of 200 by 200 heights",
    source: "no point under the ground; energy; sheet: mpm A-14",
    short_seconds: None,
    full_seconds: 300,
    run: terrain,
};

/// Checks that a heap has the same shape on four forms of one plane.
fn heaps(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let base = load_case("mpm/heap-on-planes")?;
    let tangent = ANGLE.to_radians().tan();
    let at = |x: f64| [x, 2.5 - x * tangent];
    let file = |name: &str| {
        let path = crate::root().join("validation/mpm/inclined-block-space").join(name);
        path.to_string_lossy().into_owned()
    };
    let vertices = vec![at(-1.0), at(6.0), [6.0, -3.0], [-1.0, -3.0]];
    let forms = [
        ("half-space", base.obstacles[0].shape.clone()),
        ("polygon", ObstacleShape::Extruded { axis: 1, from: -0.5, to: 1.5, vertices }),
        ("raster", ObstacleShape::Raster { file: file("plane.asc"), spacing: None }),
        ("closed wedge", ObstacleShape::Mesh { file: file("wedge.stl") }),
    ];
    let mut displacements: Vec<f64> = Vec::new();
    for (name, shape) in
        forms.into_iter().filter(|(name, _)| !quick || ["half-space", "raster"].contains(name))
    {
        let mut case = base.clone();
        case.obstacles[0].shape = shape;
        let report = run_mpm(&case)?;
        let displacement = downslope_displacement(&report);
        match displacements.first() {
            None => {
                let sliding = 0.5 * 9.81 * (ANGLE.to_radians().sin() - 0.3 * ANGLE.to_radians().cos());
                let reason = "not judged: how far a rigid block slides in a second after a sudden start";
                outcome.info(
                    format!("{name}: way of the centre of mass along the plane (m)"),
                    &format!("{sliding:.2}"),
                    displacement,
                    reason,
                );
            }
            Some(first) => outcome.assert_close(
                format!("{name}: way of the centre of mass along the plane, against the half-space's (m)"),
                *first,
                0.02,
                displacement,
                "2 %: one plane in other words",
            ),
        }
        check_above_ground(&mut outcome, name, &case, &report)?;
        if let Some(cloud) = PointCloud::from_snapshot(&report.snapshot, "displacement", [0, 2]) {
            outcome.png(&format!("The heap on the plane as {name}, from the side."), &cloud)?;
        }
        displacements.push(displacement);
    }
    Ok(outcome)
}

/// Displacement of the centre of mass down the plane (m).
fn downslope_displacement(report: &RunReport) -> f64 {
    let (sine, cosine) = ANGLE.to_radians().sin_cos();
    let [from, to] = [report.frames.first(), report.frames.last()]
        .map(|frame| frame.map_or([f64::NAN; 3], centre_of_mass));
    cosine * (to[0] - from[0]) - sine * (to[2] - from[2])
}

/// Checks that no centre of a point lies under the ground in any frame.
fn check_above_ground(
    outcome: &mut BenchmarkOutcome,
    name: &str,
    case: &Case,
    report: &RunReport,
) -> Result<(), String> {
    outcome.assert_below(
        format!("{name}: largest depth of a point's centre under the ground (m)"),
        "none",
        max_penetration(case, report)?,
        0.0,
        "none may be under it",
    );
    Ok(())
}

/// Checks mass, penetration and energy of a slide of 10⁵ points on a raster.
fn terrain(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let case = load_case("mpm/terrain-flow")?;
    let report = run_mpm(&case)?;
    check_above_ground(&mut outcome, "raster", &case, &report)?;
    outcome.assert_close(
        "mass at the end over that at the start",
        1.0,
        1e-12,
        report.end.mass / report.start.mass,
        "exact",
    );
    energies(&mut outcome, &report);
    let points = report.snapshot.positions.len();
    outcome.info("points", "10⁵", f64::from(u32::try_from(points).unwrap_or(u32::MAX)), "not judged");
    for (caption, axes) in [("from above", [0, 1]), ("from the side", [0, 2])] {
        if let Some(cloud) = PointCloud::from_snapshot(&report.snapshot, "displacement", axes) {
            outcome.png(&format!("The slide after 7 s, {caption}."), &cloud)?;
        }
    }
    Ok(outcome)
}

/// Checks the energy balance of the slide.
fn energies(outcome: &mut BenchmarkOutcome, report: &RunReport) {
    let ObstacleEnergyShares { max_rise, friction, penetration_limit: stopped } =
        obstacle_energy_shares(report);
    outcome.assert_below(
        "largest rise of the total energy over the work of gravity",
        "none",
        max_rise,
        1e-3,
        "0.1 %: what springs and steps exchange",
    );
    outcome.assert_within(
        "work of friction on the ground over that of gravity",
        "above 0, below 1",
        friction,
        (0.0, 1.0),
        "second law",
    );
    outcome.assert_within(
        "energy taken from points stopped before the ground over the work of gravity",
        "not below 0, below 0.05",
        stopped,
        (0.0, 0.05),
        "second law; the springs are to turn back nearly all",
    );
}
