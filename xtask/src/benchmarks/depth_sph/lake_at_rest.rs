//! Lakes at rest (sheet: depth-sph §5.3, V12).

use colluvium::depth_sph::bed::{Bed, hump};
use colluvium::depth_sph::config::choices::Phases;
use colluvium::depth_sph::config::settings::{FlowSettings, Mixture};
use colluvium::depth_sph::flow::{Flow, PlanBoundaries};
use colluvium::depth_sph::laws::interphase_drag::{InterphaseDrag, MixtureDensities};
use colluvium::depth_sph::points::phase_nodes::NewNode;
use colluvium::plots::{Series, Style};

use crate::benchmarks::depth_sph::common_cases::{chart, closed_form_series, line_node, step_flow_until};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of lakes at rest over level and uneven beds.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/lake",
    title: "Lakes at rest over level and uneven beds, depth-integrated",
    source: "sheet: depth-sph §5.3, V12",
    short_seconds: Some(4),
    full_seconds: 6,
    run,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Half of the length of the lake (m).
const HALF_LENGTH: f64 = 5.0;
/// Spacing of the nodes (m).
const SPACING: f64 = 0.05;
/// Duration of the rest (s).
const TIME: f64 = 10.0;

/// Checks that lakes over level and uneven beds remain at rest.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let flat = speed(&mut lake(&Bed::Flat(0.0), LakeKind::Plain)?)?;
    outcome.assert_below(
        "V12, level bed: largest speed over celerity",
        "0",
        flat,
        1e-10,
        "V12: 1e-10 on a level bed",
    );
    let mut shown = chart("Lake over a hump after 10 s", "level (m)");
    shown.series.push(closed_form_series("bed", -HALF_LENGTH, HALF_LENGTH, |x| 0.2 * (-x * x).exp()));
    let rows = [
        (LakeKind::Plain, "sums and slope", 2e-2),
        (LakeKind::Surface, "gradient of the surface", 1e-3),
        (LakeKind::TwoPhases, "two phases, sums and slope", 2e-2),
        (LakeKind::TwoPhasesSurface, "two phases, gradient of the surface", 1e-3),
    ];
    for (kind, name, bound) in rows {
        let mut flow = lake(&hump(0.2, 1.0), kind)?;
        let found = speed(&mut flow)?;
        let label = format!("V12a, {name}: largest speed over celerity after 10 s");
        outcome.assert_below(
            label,
            "0",
            found,
            bound,
            "V12: 2e-2 by sums, 1e-3 by the gradient of the surface",
        );
        if matches!(kind, LakeKind::Plain | LakeKind::Surface) {
            let nodes = &flow.nodes.sets[0].nodes;
            let mut level: Vec<(f64, f64)> = nodes
                .position
                .iter()
                .zip(&nodes.depth)
                .map(|(x, h)| (x[0], h + 0.2 * (-x[0] * x[0]).exp()))
                .collect();
            level.sort_by(|a, b| a.0.total_cmp(&b.0));
            shown.series.push(Series::new(format!("surface, {name}"), level, Style::Line));
        }
    }
    outcome
        .svg("V12a: level of a lake that was set with 1 m of water above the foot of the hump.", &shown)?;
    Ok(outcome)
}

/// Numerical variant with which a lake is computed.
#[derive(Clone, Copy)]
enum LakeKind {
    /// One phase, with SPH sums of the depth and the slope of the bed.
    Plain,
    /// One phase, with the gradient of the surface level.
    Surface,
    /// Two phases, with SPH sums of the depth and the slope of the bed.
    TwoPhases,
    /// Two phases, with the gradient of the surface level.
    TwoPhasesSurface,
}

/// Lake whose surface is 1 m above the level zero, between two walls.
fn lake(bed: &Bed<1>, kind: LakeKind) -> Result<Flow<1>, String> {
    let ends =
        PlanBoundaries { walls: [[Some(-HALF_LENGTH), Some(HALF_LENGTH)]], ..PlanBoundaries::default() };
    let count = (2.0 * HALF_LENGTH / SPACING).round() as usize;
    let nodes: Vec<NewNode<1>> = (0..count)
        .map(|k| {
            let x = -HALF_LENGTH + SPACING * (k as f64 + 0.5);
            let level = bed.bed_point(&[x]).map_or(0.0, |point| point.level);
            line_node(x, 0.0, (1.0 - level) * SPACING, SPACING)
        })
        .collect();
    let mut settings = FlowSettings::<1>::single_phase(1000.0);
    settings.numerics.surface_gradient = matches!(kind, LakeKind::Surface | LakeKind::TwoPhasesSurface);
    let two = matches!(kind, LakeKind::TwoPhases | LakeKind::TwoPhasesSurface);
    let mut sets = vec![nodes];
    if two {
        settings.phases = Phases::Two;
        settings.material = Mixture {
            densities: MixtureDensities { grain: 2500.0, fluid: 1000.0, gravity: GRAVITY },
            porosity: 0.4,
            is_saturated: true,
        };
        settings.drag = InterphaseDrag::Anderson { settling_velocity: 1e-3.into(), exponent: 1.0 };
        let part = |share: f64| {
            sets[0].iter().map(|node| NewNode { volume: share * node.volume, ..*node }).collect()
        };
        sets = vec![part(0.6), part(0.4)];
    }
    Flow::new(settings, bed.clone(), ends, &sets).map_err(|failure| failure.to_string())
}

/// Largest speed over the celerity of the depth, after ten seconds.
fn speed(flow: &mut Flow<1>) -> Result<f64, String> {
    step_flow_until(flow, TIME)?;
    let all = flow.nodes.sets.iter().flat_map(|set| set.nodes.velocity.iter().zip(&set.nodes.depth));
    Ok(all.map(|(v, h)| v[0].abs() / (GRAVITY * h).sqrt()).fold(0.0, f64::max))
}
