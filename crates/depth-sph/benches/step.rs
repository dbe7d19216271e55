//! Node-updates per second of one step of a debris flow of 5,000 nodes over a raster, on one thread, ten seconds after its release.

use std::path::Path;

use colluvium_case::{Case, Method, Solver};
use colluvium_depth_sph::DepthSph;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use serde_json::{Value, json};

/// Case of the benchmark `depth-sph/yu-tung` with nodes 0.61 m apart and other options; those that are null are left out.
fn case(options: &[(&str, Value)]) -> Case {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation/depth-sph/debris-flow");
    let text = std::fs::read_to_string(folder.join("case.json")).expect("the case of the benchmark");
    let mut value: Value = serde_json::from_str(&text).expect("a case");
    value["output"] = json!({});
    let own = &mut value["methods"]["depth-sph"];
    own["spacing"] = json!(120.0 / 196.0);
    for (key, option) in options {
        own[*key] = option.clone();
    }
    own.as_object_mut().expect("options").retain(|_, option| !option.is_null());
    Case::from_value(&value, &folder).expect("a valid case")
}

/// Number of nodes of a case at its start; few leave or are added.
fn nodes(case: &Case) -> u64 {
    DepthSph.build(case).expect("a solver").point_count() as u64
}

/// Flow ten seconds after its release.
fn flowing(case: &Case) -> Box<dyn Solver> {
    let mut solver = DepthSph.build(case).expect("a solver");
    solver.begin_stage(0, 0.0).expect("a stage");
    while solver.time() < 10.0 {
        let dt = solver.limit().dt;
        solver.step(dt).expect("a stable step");
    }
    solver
}

fn all(criterion: &mut Criterion) {
    // Rayon would use all cores.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first and only pool");
    let column = json!({ "cells": 20, "consolidation": 0.01, "excess_ratio": 1 });
    let still = [("lower_bed", json!(false)), ("regions", json!([]))];
    let with = |more: &[(&'static str, Value)]| [&still[..], more].concat();
    let settings = [
        ("one phase", with(&[("column", Value::Null)])),
        ("20-point columns", with(&[("column", column.clone())])),
        ("20-point columns, bed lowered", vec![("column", column.clone())]),
        ("two phases, 20-point columns", with(&[("column", column), ("phases", json!("two"))])),
    ];
    let mut group = criterion.benchmark_group("step");
    group.sample_size(10);
    for (name, options) in settings {
        // Built where a filter selects a measurement, and once.
        let mut made = None;
        group.throughput(Throughput::Elements(nodes(&case(&options))));
        group.bench_function(BenchmarkId::new("debris flow", name), |bencher| {
            let solver = made.get_or_insert_with(|| flowing(&case(&options)));
            bencher.iter(|| {
                let dt = solver.limit().dt;
                solver.step(dt).expect("a stable step");
            });
        });
    }
    group.finish();
}

criterion_group!(benches, all);
criterion_main!(benches);
