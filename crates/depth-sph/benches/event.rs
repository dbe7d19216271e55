//! Benchmark of a whole event, run once: 3000 m³ on 5,000 nodes over 60 s, of one phase, and 10⁵ nodes with columns of pore pressure over a
//! raster of 1000 × 1000 nodes. Time, node-updates per second and memory. And a strip of 500 m by 10 m along the axes and at an angle to
//! them: the possible gain of cells of the search that were rotated with the flow.
//!
//! `cargo bench -p colluvium-depth-sph --bench event [-- event|terrain|strip] [--threads N]`.

use std::path::Path;
use std::time::Instant;

use colluvium_case::{Case, Method};
use colluvium_depth_sph::DepthSph;
use colluvium_depth_sph::bed::Bed;
use colluvium_depth_sph::config::choices::SearchOrientation;
use colluvium_depth_sph::config::settings::FlowSettings;
use colluvium_depth_sph::flow::{Flow, PlanBoundaries};
use colluvium_depth_sph::points::phase_nodes::NewNode;
use serde_json::{Value, json};

/// Area of the outline of the release, an ellipse (m²).
const AREA: f64 = std::f64::consts::PI * 35.6 * 17.6;

/// Release of `depth-sph/yu-tung` as a layer of even thickness with `volume` (m³), on as many nodes.
fn case(folder: &Path, volume: f64, nodes: f64) -> Value {
    let text = std::fs::read_to_string(folder.join("case.json")).expect("the case of the benchmark");
    let mut value: Value = serde_json::from_str(&text).expect("a case");
    value["bodies"][0]["shape"]["thickness"] = json!(volume / AREA);
    let own = value["methods"]["depth-sph"].as_object_mut().expect("options");
    own.insert("spacing".to_owned(), json!((AREA / nodes).sqrt()));
    for key in ["regions", "lower_bed", "column"] {
        own.remove(key);
    }
    value
}

/// Memory in use and its peak (MiB), where the system has them.
fn memory() -> [f64; 2] {
    let text = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    ["VmRSS:", "VmHWM:"].map(|name| {
        let line = text.lines().find_map(|line| line.strip_prefix(name));
        let kibibytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
        kibibytes.unwrap_or(f64::NAN) / 1024.0
    })
}

/// Time of the processor that the process has used (s), in hundredths; not-a-number where the system does not report it.
fn processor() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit(") ").next().unwrap_or_default().split(' ').collect::<Vec<_>>();
    let ticks = |k: usize| fields.get(k).and_then(|field| field.parse::<f64>().ok()).unwrap_or(f64::NAN);
    0.01 * (ticks(11) + ticks(12))
}

/// Runs a case up to `end` (s) and prints its figures.
fn run(name: &str, case: &Case, end: f64) {
    let clock = Instant::now();
    let mut solver = DepthSph.build(case).expect("a solver");
    solver.begin_stage(0, 0.0).expect("a stage");
    let (set_up, nodes) = (clock.elapsed().as_secs_f64(), solver.point_count());
    let (clock, used) = (Instant::now(), processor());
    let mut updates = 0.0;
    while solver.time() < end {
        let dt = solver.limit().dt.min(end - solver.time());
        solver.step(dt).expect("a stable step");
        updates += solver.point_count() as f64;
    }
    let (seconds, used) = (clock.elapsed().as_secs_f64(), processor() - used);
    println!(
        "{name}: {nodes} nodes, {end} s in {} steps: {seconds:.2} s, {used:.2} s of processor time, {:.2} million node-updates in a second of it; set up in {set_up:.2} s, {:.0} MiB in use, {:.0} MiB at most",
        solver.step_count(),
        updates / used * 1e-6,
        memory()[0],
        memory()[1],
    );
}

/// Heights of the channel of the benchmark on 1000 × 1000 nodes half a metre apart, as an ASCII raster.
fn fine_terrain() -> String {
    let mut text =
        "ncols 1000\nnrows 1000\nxllcenter -60\nyllcenter -250\ncellsize 0.5\nnodata_value -9999\n"
            .to_owned();
    for row in (0..1000).rev() {
        let y = -250.0 + 0.5 * f64::from(row);
        for column in 0..1000 {
            let x = -60.0 + 0.5 * f64::from(column);
            let along = (1.0 - x / 440.0).max(0.0);
            let side = 8.0 * (y / 30.0).powi(2).min(4.0);
            text += &format!("{:.3} ", 156.0 * along * along + side);
        }
        text.push('\n');
    }
    text
}

/// Strip of water of 500 m by 10 m and 1 m deep that spreads for 300 steps, at an angle (degrees) to the axes.
fn strip(degrees: f64, search: SearchOrientation) {
    let (spacing, (sin, cos)) = (0.6, degrees.to_radians().sin_cos());
    let mut nodes = Vec::new();
    for i in 0..833 {
        for j in 0..17 {
            let [along, across] = [i, j].map(|k| spacing * f64::from(k));
            nodes.push(NewNode {
                body: 0,
                position: [cos * along - sin * across, sin * along + cos * across],
                velocity: [5.0 * cos, 5.0 * sin],
                volume: spacing * spacing,
                length: 1.3 * spacing,
                scale: 1.69,
            });
        }
    }
    let mut settings = FlowSettings::<2>::single_phase(1000.0);
    settings.numerics.search = search;
    let mut flow = Flow::new(settings, Bed::Flat(0.0), PlanBoundaries::default(), &[nodes]).expect("a flow");
    let (used, mut updates) = (processor(), 0.0);
    for _ in 0..300 {
        flow.advance(flow.limit().dt).expect("a stable step");
        updates += flow.nodes.sets[0].len() as f64;
    }
    let used = processor() - used;
    println!(
        "strip at {degrees} degrees, cells {search:?}: {used:.2} s of processor time, {:.2} million node-updates in a second of it",
        updates / used * 1e-6,
    );
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let after = |name: &str| words.iter().position(|word| word == name).and_then(|k| words.get(k + 1));
    let threads = after("--threads").map_or(1, |count| count.parse().expect("a number of threads"));
    // Within a pool, as runs are: calls from outside wake a thread for each sum.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let asked = |name: &str| {
        !words.iter().any(|word| ["event", "terrain", "strip"].contains(&word.as_str()))
            || words.iter().any(|word| word == name)
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation/depth-sph/debris-flow");
    if asked("event") {
        let mut value = case(&folder, 3000.0, 5000.0);
        value["stages"][0]["duration"] = json!(60);
        value["methods"]["depth-sph"]["shortest_smoothing"] = json!(0.7);
        let case = Case::from_value(&value, &folder).expect("a valid case");
        pool.install(|| run("event with rasters", &case, 60.0));
        value["output"] = json!({});
        let case = Case::from_value(&value, &folder).expect("a valid case");
        pool.install(|| run("event", &case, 60.0));
        value["methods"]["depth-sph"]["search"] = json!("turned");
        let case = Case::from_value(&value, &folder).expect("a valid case");
        pool.install(|| run("event, cells turned", &case, 60.0));
    }
    if asked("strip") {
        for search in [
            SearchOrientation::Axes,
            SearchOrientation::Turned,
            SearchOrientation::Axes,
            SearchOrientation::Turned,
        ] {
            pool.install(|| [0.0, 45.0, 90.0].map(|degrees| strip(degrees, search)));
        }
    }
    if asked("terrain") {
        let own = tempfile::tempdir().expect("a folder");
        std::fs::write(own.path().join("terrain.asc"), fine_terrain()).expect("a raster");
        std::fs::copy(folder.join("release.geojson"), own.path().join("release.geojson"))
            .expect("an outline");
        let mut value = case(&folder, 3000.0, 1e5);
        value["domain"] = json!({ "min": [-60, -240, -5], "max": [430, 240, 400] });
        value["output"] = json!({});
        value["measures"] = json!({});
        value["methods"]["depth-sph"]["column"] =
            json!({ "cells": 20, "consolidation": 0.01, "excess_ratio": 1 });
        let case = Case::from_value(&value, own.path()).expect("a valid case");
        pool.install(|| run("10^5 nodes with columns", &case, 2.0));
    }
}
