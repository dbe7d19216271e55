//! Critical time step (sheet: depth-sph §3.3, as corrected in use).

use colluvium_depth_sph::bed::{Bed, BedPoint};
use colluvium_depth_sph::config::choices::DepthFrame;
use colluvium_depth_sph::config::settings::FlowSettings;
use colluvium_depth_sph::flow::{Flow, PlanBoundaries};
use colluvium_depth_sph::points::phase_nodes::NewNode;

const SPACING: f64 = 0.5;
const LENGTH: f64 = 1.5 * SPACING;
const GRAVITY: f64 = 9.81;
/// Courant number of the default settings.
const COURANT: f64 = 0.3;

/// Line of 200 nodes of depth `depth` (m) that moves with `velocity` (m/s, of x in m) over a bed.
fn flow(bed: Bed<1>, depth: f64, velocity: impl Fn(f64) -> f64) -> Flow<1> {
    let node = |k: usize| {
        let x = SPACING * (k as f64 + 0.5);
        let velocity = [velocity(x)];
        NewNode { body: 0, position: [x], velocity, volume: depth * SPACING, length: LENGTH, scale: 1.5 }
    };
    let mut settings = FlowSettings::single_phase(1000.0);
    settings.frame = DepthFrame::Horizontal;
    settings.numerics.variable_length = false;
    Flow::new(settings, bed, PlanBoundaries::default(), &[(0..200).map(node).collect()]).unwrap()
}

/// Limit of the step (s) after a very short one, which finds relative speeds and curvatures.
fn limit_after_a_step(mut flow: Flow<1>) -> f64 {
    flow.advance(1e-6).unwrap();
    flow.limit().dt
}

fn close(found: f64, exact: f64) {
    assert!((found / exact - 1.0).abs() < 5e-3, "{found} for {exact}");
}

#[test]
fn waves_limit_the_step_in_the_frame_of_the_flow() {
    let wave = (GRAVITY * 1.0f64).sqrt();
    let still = limit_after_a_step(flow(Bed::Flat(0.0), 1.0, |_| 0.0));
    close(still, COURANT * LENGTH / wave);
    // Carried along at two thirds of the speed at which a node crosses its smoothing length in this step.
    close(limit_after_a_step(flow(Bed::Flat(0.0), 1.0, |_| 7.0)), still);
    // Stretched by 0.04/s: a node at the border of the support, two lengths away, moves apart at up to 0.08 lengths per second.
    let stretched = limit_after_a_step(flow(Bed::Flat(0.0), 1.0, |x| 2.0 * (x - 50.0) / 50.0));
    assert!(stretched < still && stretched > COURANT * LENGTH / (wave + 0.04 * 2.0 * LENGTH), "{stretched}");
}

#[test]
fn an_unknown_relative_speed_is_taken_as_the_speed() {
    let flow = flow(Bed::Flat(0.0), 1.0, |_| 7.0);
    close(flow.limit().dt, COURANT * LENGTH / ((GRAVITY * 1.0f64).sqrt() + 7.0));
}

#[test]
fn nodes_cross_at_most_a_smoothing_length_and_a_turn_of_the_bed() {
    close(limit_after_a_step(flow(Bed::Flat(0.0), 0.01, |_| 50.0)), LENGTH / 50.0);
    // Waves with a crest at the first node, where the curvature is largest.
    let (amplitude, number) = (0.2, std::f64::consts::TAU / 4.0);
    let bed = Bed::formula(move |x: &[f64; 1]| {
        let (sin, cos) = (number * (x[0] - 0.5 * SPACING)).sin_cos();
        BedPoint {
            level: amplitude * cos,
            slope: [-amplitude * number * sin],
            curvature: [[-amplitude * number * number * cos]],
        }
    });
    let turned = limit_after_a_step(flow(bed, 0.01, |_| 50.0));
    assert!((turned / (0.1 / (amplitude * number * number * 50.0)) - 1.0).abs() < 0.02, "{turned}");
}
