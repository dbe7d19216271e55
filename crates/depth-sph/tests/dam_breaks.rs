//! Dam breaks against their closed forms, in few nodes.

use colluvium_depth_sph::bed::Bed;
use colluvium_depth_sph::choices::Continuity;
use colluvium_depth_sph::exact::{Stoker, ritter};
use colluvium_depth_sph::flow::{Ends, Flow};
use colluvium_depth_sph::nodes::Node;
use colluvium_depth_sph::settings::Settings;

/// Nodes of depth `depth` every `spacing` from `from` to `to`.
fn layer(from: f64, to: f64, spacing: f64, depth: f64) -> Vec<Node<1>> {
    let count = ((to - from) / spacing).round() as usize;
    (0..count)
        .map(|k| Node {
            body: 0,
            position: [from + spacing * (k as f64 + 0.5)],
            velocity: [0.0],
            volume: depth * spacing,
            length: 1.5 * spacing,
            scale: 1.5,
        })
        .collect()
}

fn run(flow: &mut Flow<1>, end: f64) {
    while flow.time < end {
        let dt = flow.limit().dt.min(end - flow.time);
        flow.advance(dt).unwrap();
    }
}

#[test]
fn water_leaves_a_reservoir_as_ritter_found() {
    let ends = Ends { walls: [[Some(-20.0), None]], ..Ends::default() };
    let nodes = layer(-20.0, 0.0, 0.05, 10.0);
    let mut flow = Flow::new(Settings::plain(1000.0), Bed::Flat(0.0), ends, &[nodes]).unwrap();
    let volume = flow.sets[0].nodes.total_volume();
    run(&mut flow, 1.0);
    let nodes = &flow.sets[0].nodes;
    assert_eq!(nodes.total_volume(), volume);
    let (mut error, mut count) = (0.0, 0);
    for (x, h) in nodes.position.iter().zip(&nodes.height) {
        if x[0] < 10.0 {
            error += (h - ritter(9.81, 10.0, x[0], 1.0).0).abs() / 10.0;
            count += 1;
        }
    }
    error /= f64::from(count);
    println!("ritter {error}");
    assert!(error < 0.006, "{error}");
}

/// Mean error of the depth one second after a dam of 1 m of water over 0.5 m broke, and the mean velocity between the
/// waves over the exact one.
fn bore(continuity: Continuity) -> (f64, f64) {
    let exact = Stoker::new(9.81, 1.0, 0.5);
    let ends = Ends { walls: [[Some(-5.0), Some(5.0)]], ..Ends::default() };
    let mut nodes = layer(-5.0, 0.0, 0.02, 1.0);
    nodes.extend(layer(0.0, 5.0, 0.02, 0.5));
    let mut settings = Settings::plain(1000.0);
    settings.numerics.continuity = continuity;
    let mut flow = Flow::new(settings, Bed::Flat(0.0), ends, &[nodes]).unwrap();
    run(&mut flow, 1.0);
    let nodes = &flow.sets[0].nodes;
    let mut error = 0.0;
    for (x, h) in nodes.position.iter().zip(&nodes.height) {
        error += (h - exact.at(x[0], 1.0).0).abs();
    }
    error /= nodes.len() as f64;
    let between: Vec<usize> =
        (0..nodes.len()).filter(|&i| (-1.4..2.6).contains(&nodes.position[i][0])).collect();
    let mean = between.iter().map(|&i| nodes.velocity[i][0]).sum::<f64>() / between.len() as f64;
    println!("stoker {continuity:?} {error} {}", mean / exact.velocity);
    (error, mean / exact.velocity)
}

#[test]
fn a_bore_runs_into_still_water_as_stoker_found() {
    let (error, velocity) = bore(Continuity::Summation);
    assert!(error < 0.015, "{error}");
    assert!((velocity - 1.0).abs() < 0.015, "{velocity}");
}

#[test]
fn each_rate_of_height_carries_the_bore_of_stoker() {
    for continuity in [Continuity::RateBasic, Continuity::RateDifference, Continuity::RateVolume] {
        let (error, velocity) = bore(continuity);
        assert!(error < 0.015, "{continuity:?}: {error}");
        assert!((velocity - 1.0).abs() < 0.015, "{continuity:?}: {velocity}");
    }
}
