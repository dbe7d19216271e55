//! Order of the time schemes (sheet: depth-sph §3.4, integrators).

use colluvium_case::FailureReason;
use colluvium_depth_sph::bed::{Bed, BedPoint};
use colluvium_depth_sph::config::choices::{DepthFrame, ThicknessEquation, TimeScheme};
use colluvium_depth_sph::config::settings::FlowSettings;
use colluvium_depth_sph::flow::{Flow, PlanBoundaries};
use colluvium_depth_sph::kernel::Kernel;
use colluvium_depth_sph::points::phase_nodes::NewNode;

const SPACING: f64 = 0.25;
/// Half of the width of the water (m), whose largest depth is 1 m.
const HALF: f64 = 10.0;
/// Time of the runs (s), a ninth of the canal's period.
const END: f64 = 1.6;

/// Water in the parabolic canal of V10, which oscillates and expands. Its kernel has four derivatives and its smoothing lengths are
/// constant, so that rates are smooth functions of positions.
fn canal(integration: TimeScheme) -> Flow<1> {
    let bed = Bed::formula(|x: &[f64; 1]| BedPoint {
        level: (x[0] / HALF).powi(2),
        slope: [2.0 * x[0] / (HALF * HALF)],
        curvature: [[2.0 / (HALF * HALF)]],
    });
    let count = (2.0 * HALF / SPACING).round() as usize;
    let node = |k: usize| {
        let x = -HALF + SPACING * (k as f64 + 0.5);
        NewNode {
            body: 0,
            position: [x],
            velocity: [0.6 + 0.1 * x],
            volume: (1.0 - (x / HALF).powi(2)) * SPACING,
            length: 1.5 * SPACING,
            scale: 1.5,
        }
    };
    let mut settings = FlowSettings::single_phase(1000.0);
    settings.frame = DepthFrame::SmallSlope;
    settings.numerics.kernel = Kernel::QuinticSpline;
    settings.numerics.variable_length = false;
    settings.numerics.viscosity = (0.0, 0.0);
    settings.numerics.integration = integration;
    Flow::new(settings, bed, PlanBoundaries::default(), &[(0..count).map(node).collect()]).unwrap()
}

/// Positions (m) and velocities (m/s) of all nodes, by number, after this number of equal steps.
fn after(integration: TimeScheme, steps: u32) -> Vec<[f64; 2]> {
    let mut flow = canal(integration);
    for _ in 0..steps {
        flow.advance(END / f64::from(steps)).unwrap();
    }
    let nodes = &flow.nodes.sets[0].nodes;
    let mut order: Vec<usize> = (0..nodes.len()).collect();
    order.sort_by_key(|&i| nodes.id[i]);
    order.iter().map(|&i| [nodes.position[i][0], nodes.velocity[i][0]]).collect()
}

/// The nodes are kept while the step is halved, so that no error of space enters.
#[test]
fn leapfrog_and_the_midpoint_rule_are_of_second_order_and_runge_kutta_of_fourth() {
    let exact = after(TimeScheme::RungeKutta4, 640);
    for (integration, order) in
        [(TimeScheme::Leapfrog, 2.0), (TimeScheme::RungeKutta2, 2.0), (TimeScheme::RungeKutta4, 4.0)]
    {
        let errors = [40, 80, 160].map(|steps| {
            let own = after(integration, steps);
            let apart = own.iter().zip(&exact).flat_map(|(a, b)| [0, 1].map(|c| (a[c] - b[c]).powi(2)));
            apart.sum::<f64>().sqrt()
        });
        let found = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
        println!("{integration:?}: errors {errors:.3?}, orders {found:.3?}");
        // Order of the finer pair; terms of the next order are a few per cent of it there.
        assert!((found[1] - order).abs() < 0.15, "{integration:?}: {found:?} for {order}, errors {errors:?}");
    }
}

/// A node whose velocity is lost between the stages of a step ends the run there, by its number, before lists are made of it.
#[test]
fn a_node_that_is_lost_between_stages_ends_the_run() {
    for integration in [TimeScheme::RungeKutta2, TimeScheme::RungeKutta4] {
        let mut flow = canal(integration);
        // So that lists of neighbours are needed.
        flow.settings.numerics.continuity = ThicknessEquation::RateDifference;
        flow.advance(1e-3).unwrap();
        flow.nodes.sets[0].nodes.volume[40] = f64::NAN;
        let failure = flow.advance(1e-3).unwrap_err();
        let FailureReason::NotFinite(reason) = &failure.reason else { panic!("{failure}") };
        assert!(reason.starts_with("its velocity, [NaN] m/s, or its smoothing length"), "{failure}");
        assert!(failure.position[0].is_finite(), "{failure}");
    }
}
