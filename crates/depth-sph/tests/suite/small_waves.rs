//! Linear waves of small amplitude: of two phases, of two layers, over a slide on the bed (sheet: depth-sph §5.5).

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use colluvium_depth_sph::bed::{Bed, BedPoint};
use colluvium_depth_sph::config::choices::{DepthFrame, Phases, PressureForceForm};
use colluvium_depth_sph::config::settings::{FlowSettings, Mixture};
use colluvium_depth_sph::flow::{Flow, PlanBoundaries};
use colluvium_depth_sph::laws::interphase_drag::MixtureDensities;
use colluvium_depth_sph::points::phase_nodes::NewNode;

use crate::flow_runs::advance_flow_to;

const GRAVITY: f64 = 9.81;
const SPACING: f64 = 0.05;
const HALF: f64 = 20.0;
/// Smoothing length over spacing at which sums over a lattice are equal everywhere: two sets of nodes then have no preferred relative
/// position.
const EVEN: f64 = 2.0;

/// Nodes at rest between -20 and 20 m, with a depth at each position.
fn layer(depth: impl Fn(f64) -> f64) -> Vec<NewNode<1>> {
    let count = (2.0 * HALF / SPACING).round() as usize;
    let place = |k: usize| -HALF + SPACING * (k as f64 + 0.5);
    let node = |x: f64| NewNode {
        body: 0,
        position: [x],
        velocity: [0.0],
        volume: depth(x) * SPACING,
        length: EVEN * SPACING,
        scale: EVEN,
    };
    (0..count).map(|k| node(place(k))).collect()
}

fn between_walls() -> PlanBoundaries<1> {
    PlanBoundaries { walls: [[Some(-HALF), Some(HALF)]], ..PlanBoundaries::default() }
}

fn hump(x: f64) -> f64 {
    1e-3 * (-x * x / 2.0).exp()
}

/// Settings of two sets of nodes without drag and viscosity.
fn two(phases: Phases, grain: f64, fluid: f64) -> FlowSettings<1> {
    let mut settings = FlowSettings::single_phase(fluid);
    settings.phases = phases;
    let densities = MixtureDensities { grain, fluid, gravity: GRAVITY };
    settings.material = Mixture { densities, porosity: 0.4, is_saturated: phases == Phases::Two };
    settings.numerics.momentum = PressureForceForm::Node;
    settings.numerics.viscosity = (0.0, 0.0);
    settings
}

/// Position of the right half of a disturbance of the heights of a set (m).
fn centroid(flow: &Flow<1>, set: usize, still: &[f64]) -> f64 {
    let nodes = &flow.nodes.sets[set].nodes;
    let (mut sum, mut moment) = (0.0, 0.0);
    for (i, x) in nodes.position.iter().enumerate() {
        if x[0] > 0.5 && x[0] < HALF - 1.0 {
            let off = nodes.partial_thickness[i] - still[nodes.id[i] as usize % still.len()];
            sum += off;
            moment += off * x[0];
        }
    }
    moment / sum
}

/// Speed of a disturbance of both heights (m/s), from its positions at two times (s).
fn speed(densities: [f64; 2], heights: [f64; 2], mode: [f64; 2], times: [f64; 2]) -> f64 {
    let make = |size: f64| {
        let set = |k: usize| layer(|x| heights[k] + size * mode[k] * hump(x));
        let settings = two(Phases::Two, densities[0], densities[1]);
        Flow::new(settings, Bed::Flat(0.0), between_walls(), &[set(0), set(1)]).unwrap()
    };
    let still = make(0.0).nodes.sets[1].nodes.partial_thickness.clone();
    let mut flow = make(1.0);
    let places = times.map(|time| {
        advance_flow_to(&mut flow, time);
        centroid(&flow, 1, &still)
    });
    (places[1] - places[0]) / (times[1] - times[0])
}

/// V18: `±√(g h)` with constant porosity, and `±√(½ (1 - γ) g h_w)` with heights of the phases that change separately.
#[test]
fn small_waves_of_two_phases_have_their_speeds() {
    // State, γ, external and internal speed of the sheet (m/s).
    let table = [
        ([0.6, 0.4], 2500.0, 3.132_092, 1.084_988),
        ([0.32, 0.72], 2000.0, 3.194_120, 1.328_834),
        ([0.84, 0.54], 2000.0, 3.679_375, 1.150_804),
    ];
    for (heights, grain, external, internal) in table {
        let found = speed([grain, 1000.0], heights, heights, [1.5, 3.5]);
        assert!((found / external - 1.0).abs() < 0.01, "{heights:?}: {found} for {external}");
        // `h_w (a + b) g = c² b`.
        let slow = internal * internal / (GRAVITY * heights[1]);
        let found = speed([grain, 1000.0], heights, [1.0 - slow, -1.0].map(|x| -x), [4.0, 9.0]);
        assert!((found / internal - 1.0).abs() < 0.01, "{heights:?}: {found} for {internal}");
    }
}

/// V30: a lake of two layers stays at rest: level layers over a level bed, and level surfaces over a hump.
#[test]
fn two_layers_stay_at_rest() {
    for over_hump in [false, true] {
        let rise = move |x: f64| if over_hump { 0.2 * (-x * x).exp() } else { 0.0 };
        let bed = Bed::formula(move |x: &[f64; 1]| {
            let level = rise(x[0]);
            let mut point = BedPoint::horizontal(level);
            point.slope[0] = -2.0 * x[0] * level;
            point.curvature[0][0] = (4.0 * x[0] * x[0] - 2.0) * level;
            point
        });
        let mut settings = two(Phases::Layers, 2000.0, 1000.0);
        settings.frame = DepthFrame::SmallSlope;
        settings.numerics.viscosity = (1.0, 0.0);
        settings.numerics.momentum = PressureForceForm::Automatic;
        let sets = [layer(|x| 0.6 - rise(x)), layer(|_| 0.4)];
        let mut flow = Flow::new(settings, bed, between_walls(), &sets).unwrap();
        advance_flow_to(&mut flow, 10.0);
        let all = flow.nodes.sets.iter().flat_map(|set| &set.nodes.velocity);
        let fastest = all.map(|v| v[0].abs()).fold(0.0, f64::max) / GRAVITY.sqrt();
        // V12: round-off over a level bed, 2e-2 with sums and the slope of the bed.
        assert!(fastest < if over_hump { 2e-2 } else { 1e-10 }, "hump {over_hump}: {fastest}");
    }
}

/// Friction between layers slows their slip by `du/dt = -k u²`, `k = ½ C_f ρ₂ (1/(ρ₁ h₁) + 1/(ρ₂ h₂))`, and keeps momentum.
#[test]
fn interface_friction_slows_the_slip_of_layers_and_conserves_momentum() {
    // Slower than the speed at which waves grow between the layers.
    let (slip, friction) = (0.5, 0.05);
    let mut settings = two(Phases::Layers, 2000.0, 1000.0);
    settings.interface_friction = friction;
    settings.numerics.variable_length = false;
    settings.numerics.momentum = PressureForceForm::Automatic;
    settings.numerics.viscosity = (1.0, 0.0);
    let ends = PlanBoundaries { periods: [Some((-HALF, HALF))], ..PlanBoundaries::default() };
    let mut upper = layer(|_| 0.4);
    upper.iter_mut().for_each(|node| node.velocity = [slip]);
    let mut flow = Flow::new(settings, Bed::Flat(0.0), ends, &[layer(|_| 0.6), upper]).unwrap();
    let momentum = |flow: &Flow<1>| flow.totals(0).momentum[0] + flow.totals(1).momentum[0];
    let before = momentum(&flow);
    advance_flow_to(&mut flow, 5.0);
    let mean = |set: usize| {
        let nodes = &flow.nodes.sets[set].nodes;
        nodes.velocity.iter().map(|v| v[0]).sum::<f64>() / nodes.len() as f64
    };
    let rate = 0.5 * friction * 1000.0 * (1.0 / (2000.0 * 0.6) + 1.0 / (1000.0 * 0.4));
    let exact = slip / (1.0 + rate * slip * 5.0);
    let found = mean(1) - mean(0);
    // Steps are implicit, of first order, and sums over a lattice are 0.4 % off.
    assert!((found / exact - 1.0).abs() < 0.01, "{found} for {exact}");
    assert!((momentum(&flow) / before - 1.0).abs() < 1e-3, "{} for {before}", momentum(&flow));
}

/// V30: a slide of small height on the bed that starts at half the celerity.
#[test]
fn a_moving_bed_slide_generates_three_waves() {
    let (height, froude) = (0.005, 0.5);
    let celerity = GRAVITY.sqrt();
    let speed = froude * celerity;
    let now = Arc::new(AtomicU64::new(0f64.to_bits()));
    let clock = Arc::clone(&now);
    let slide = move |x: f64, t: f64| height * (-(x - speed * t).powi(2) / 2.0).exp();
    let bed = Bed::formula(move |x: &[f64; 1]| {
        let time = f64::from_bits(clock.load(Ordering::Relaxed));
        let (at, level) = (x[0] - speed * time, slide(x[0], time));
        let mut point = BedPoint::horizontal(level);
        point.slope[0] = -at * level;
        point
    });
    let mut settings = FlowSettings::single_phase(1000.0);
    settings.frame = DepthFrame::SmallSlope;
    settings.numerics.viscosity = (0.0, 0.0);
    let mut flow = Flow::new(settings, bed, between_walls(), &[layer(|x| 1.0 - slide(x, 0.0))]).unwrap();
    let still = flow.nodes.sets[0].nodes.partial_thickness[200];
    let end = 5.0;
    while flow.clock.time < end {
        let dt = flow.limit().dt.min(end - flow.clock.time);
        // The forces of a step are those of its middle.
        now.store((flow.clock.time + 0.5 * dt).to_bits(), Ordering::Relaxed);
        flow.advance(dt).unwrap();
    }
    let nodes = &flow.nodes.sets[0].nodes;
    let at = |place: f64| {
        let near = |i: &usize| (nodes.position[*i][0] - place).abs();
        let i = (0..nodes.len()).min_by(|a, b| near(a).total_cmp(&near(b))).unwrap();
        (nodes.partial_thickness[i] + slide(nodes.position[i][0], end) - still) / height
    };
    let waves = [
        (speed * end, froude * froude / (froude * froude - 1.0)),
        (celerity * end, -froude / (2.0 * (froude - 1.0))),
        (-celerity * end, -froude / (2.0 * (froude + 1.0))),
    ];
    for (place, exact) in waves {
        let found = at(place);
        assert!((found / exact - 1.0).abs() < 0.03, "at {place} m: {found} for {exact}");
    }
}
