//! Factors of safety of the slopes of the ACADS survey, by MPM and SPH (sheet: sph §3.5).

use colluvium::case::Case;

use super::draw_failure;
use crate::analysis::bishop_layered::{LayeredSlope, SoilLayer};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_in_memory};

/// Benchmark of the factor of safety of a slope of one soil, ACADS problem 1(a).
pub const ONE_SOIL: Benchmark = Benchmark {
    id: "compare/acads-1a",
    title: "Factor of safety of a slope of one soil, ACADS problem 1(a), MPM and SPH",
    source: "Giam & Donald 1989 (ACADS U255), problem EX1(a); Bishop 1955; Davis 1968",
    short_seconds: None,
    full_seconds: 300,
    run: run_one_soil,
};

/// Benchmark of the factor of safety of a slope of three soils, ACADS problem 1(c).
pub const THREE_SOILS: Benchmark = Benchmark {
    id: "compare/acads-1c",
    title: "Factor of safety of a slope of three soils, ACADS problem 1(c), MPM and SPH",
    source: "Giam & Donald 1989 (ACADS U255), problem EX1(c); Bishop 1955; Davis 1968",
    short_seconds: None,
    full_seconds: 300,
    run: run_three_soils,
};

/// Factor by which the strengths of the cases exceed those of the survey, since the first slope would not be stable.
const STRENGTH_FACTOR: f64 = 1.5;

/// Surface of both slopes (m): 10 m high with a gradient of 2:1, on soil of 5 m above the base.
fn surface() -> Vec<[f64; 2]> {
    vec![[0.0, 5.0], [10.0, 5.0], [30.0, 15.0], [50.0, 15.0]]
}

/// Layer of soil below the line `top`, angles in degrees.
fn soil(top: Vec<[f64; 2]>, unit_weight: f64, cohesion: f64, friction_angle: f64) -> SoilLayer {
    SoilLayer { top, unit_weight, cohesion, friction_angle }
}

/// Least factor of Bishop's circles, and the factor with the reduced strength of soil without dilatancy (Davis 1968). The friction angle is
/// in degrees.
fn bounds(slope: &LayeredSlope, friction_angle: f64) -> [f64; 2] {
    let bishop = slope.min_safety_factor((1.0, 20.0), (30.5, 45.0));
    [bishop, bishop * (friction_angle.to_radians().tan() / bishop).atan().cos()]
}

/// Checks the factors of safety of a slope against the referees' factor, and against the factors of Bishop's circles and of Davis's
/// strength.
fn judge(
    outcome: &mut BenchmarkOutcome,
    case: &Case,
    referee: f64,
    [bishop, davis]: [f64; 2],
) -> Result<(), String> {
    outcome.assert_within(
        "least factor of Bishop's circles",
        &format!("{referee:.2}, the referees' factor"),
        bishop,
        (referee - 0.02, referee + 0.02),
        "programs of limit equilibrium differ by that",
    );
    for method in ["mpm", "sph"] {
        let report = run_in_memory(method, case)?;
        let found = report.safety.get("safety").ok_or("no factor of safety")?;
        outcome.assert_within(
            format!("{method}: factor of safety"),
            &format!("{referee:.2}, the referees' factor"),
            found.factor().unwrap_or(f64::NAN) / STRENGTH_FACTOR,
            (referee - 0.05, referee + 0.05),
            "± 0.05 on 20 cells over the height, without dilatancy",
        );
        outcome.assert_within(
            format!("{method}: largest factor with which it stands"),
            "at most that of Bishop's circles",
            found.stable_factor / STRENGTH_FACTOR,
            (0.0, bishop),
            "an upper end of what soil without dilatancy can have",
        );
        outcome.assert_within(
            format!("{method}: least factor with which it fails"),
            &format!("at least {davis:.3}, by Davis's strength"),
            found.failing_factor / STRENGTH_FACTOR,
            (davis, f64::INFINITY),
            "the lower end",
        );
        draw_failure(outcome, method, &report)?;
    }
    Ok(())
}

/// Checks the factor of safety of the slope of ACADS problem 1(a).
fn run_one_soil(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let slope = LayeredSlope { soils: vec![soil(surface(), 20e3, 3e3, 19.6)], base: 0.0 };
    judge(&mut outcome, &load_case("compare/acads-1a")?, 1.0, bounds(&slope, 19.6))?;
    Ok(outcome)
}

/// Checks the factor of safety of the slope of ACADS problem 1(c).
fn run_three_soils(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let toe = [10.0, 5.0];
    let middle = vec![toe, [20.0, 7.0], [30.0, 9.0], [34.0, 11.0], [50.0, 11.0]];
    let lower = vec![toe, [20.0, 7.0], [32.0, 4.0], [50.0, 4.0]];
    let soils = vec![
        soil(surface(), 19.5e3, 0.0, 38.0),
        soil(middle, 19.5e3, 5.3e3, 23.0),
        soil(lower, 19.5e3, 7.2e3, 20.0),
    ];
    // Most of the slip surface lies in the middle soil.
    let bounds = bounds(&LayeredSlope { soils, base: 0.0 }, 23.0);
    judge(&mut outcome, &load_case("compare/acads-1c")?, 1.39, bounds)?;
    Ok(outcome)
}
