//! Rejection of options and cases that the method does not support.

use colluvium_case::Method;
use colluvium_mpm::Mpm;
use serde_json::{Value, json};

use crate::solver::elastic_block;

#[test]
fn unsupported_options_are_rejected_by_path() {
    let refused = |more: Value, path: &str, words: &str| {
        let error = Mpm.plan(&elastic_block().with(more).build()).unwrap_err();
        assert!(error.path == path && error.problem().contains(words), "{error}");
    };
    refused(json!({ "methods": {} }), "methods.mpm", "cell_size");
    let mpm = |options: Value| json!({ "methods": { "mpm": options } });
    refused(mpm(json!({ "cell_size": 0.3 })), "methods.mpm.cell_size", "whole number");
    refused(mpm(json!({ "cell_size": -1 })), "methods.mpm.cell_size", "positive");
    refused(mpm(json!({ "cell_size": 0.1, "flip": 1.5 })), "methods.mpm.flip", "0..=1");
    refused(mpm(json!({ "cell_size": 0.1, "time_step": 1.0 })), "methods.mpm.time_step", "critical");
    refused(mpm(json!({ "cell_size": 0.1, "shape": "round" })), "methods.mpm.shape", "not one of");
    refused(mpm(json!({ "cell_size": 0.1, "cellsize": 1 })), "methods.mpm.cellsize", "unknown key");
    refused(mpm(json!({ "cell_size": 0.1, "node_mass_cutoff": 1 })), "methods.mpm.node_mass_cutoff", "0..1");
    let still = mpm(json!({ "cell_size": 0.1, "static_friction_ratio": 2 }));
    refused(still, "methods.mpm.static_friction_ratio", "wall_friction");
    let turning = mpm(json!({ "cell_size": 0.1, "domain_stretch": "right-stretch" }));
    refused(turning, "methods.mpm.domain_stretch", "cpgimp");
    let gate = json!([{ "side": "x-max", "position": 0.55, "wall": { "kind": "smooth" } }]);
    refused(json!({ "boundaries": gate }), "boundaries[0].position", "grid line");
    let gate = json!([{ "side": "x-max", "position": 0.9, "wall": { "kind": "smooth" } }]);
    let spline = json!({ "mpm": { "cell_size": 0.1, "shape": "cubic" } });
    refused(
        json!({ "boundaries": gate, "methods": spline }),
        "boundaries[0].position",
        "sides of the domain",
    );
    let speck = json!([{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.5, 0.5], "radius": 1e-3 } }]);
    refused(json!({ "bodies": speck }), "bodies[0].shape", "no point");
}
