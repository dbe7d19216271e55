//! Memory that a plan estimates against the memory that a run takes.

// Counting allocated bytes requires an allocator of our own.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use colluvium::case::Case;
use serde_json::{Value, json};

static HELD: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

/// System allocator with a count of bytes.
struct Counting;

fn taken(bytes: usize) {
    let held = HELD.fetch_add(bytes, Ordering::Relaxed) + bytes;
    MOST.fetch_max(held, Ordering::Relaxed);
}

// SAFETY: every call is passed unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        taken(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Largest memory of the solver of a case while it is built, and while it steps and sorts (bytes).
fn held(case: &Case, method: &str) -> [f64; 2] {
    let before = HELD.load(Ordering::Relaxed);
    MOST.store(before, Ordering::Relaxed);
    let mut solver = colluvium::method(method).unwrap().build(case).unwrap();
    let made = (MOST.load(Ordering::Relaxed) - before) as f64;
    solver.begin_stage(0, 0.0).unwrap();
    MOST.store(HELD.load(Ordering::Relaxed), Ordering::Relaxed);
    // Enough steps for points to be sorted.
    for _ in 0..12 {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    }
    [made, (MOST.load(Ordering::Relaxed) - before) as f64]
}

/// Block that moves faster than its speed of sound, so that it crosses a cell in a few steps.
fn block(space: &str, method: &str, options: &Value, change: &Value) -> Case {
    let (domain, upper, velocity) = match space {
        "3d" => ([4.0, 2.0, 2.0].as_slice(), [1.9, 1.7, 1.7].as_slice(), [30.0, 0.0, 0.0].as_slice()),
        _ => ([8.0, 4.0].as_slice(), [5.0, 3.5].as_slice(), [30.0, 0.0].as_slice()),
    };
    let lower = vec![0.5; domain.len()];
    let mut case = json!({
        "title": "memory", "space": space, "domain": { "min": vec![0.0; domain.len()], "max": domain },
        "gravity": vec![0.0; domain.len()],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.2 } },
        "bodies": [{ "name": "b", "material": "m", "velocity": { "kind": "uniform", "value": velocity }, "pore_fluid": null,
                     "shape": { "kind": "box", "min": lower, "max": upper } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { method: options }
    });
    for (pointer, value) in change.as_object().into_iter().flatten() {
        *case.pointer_mut(pointer).unwrap() = value.clone();
    }
    Case::from_json(&case.to_string()).unwrap()
}

#[test]
fn a_plan_knows_what_its_run_will_hold() {
    let law = |law: Value| json!({ "/materials/m": law });
    let none = json!({});
    let plastic = law(json!({
        "model": "mohr-coulomb", "density": 1500, "youngs_modulus": 1e5, "poissons_ratio": 0.2, "friction_angle": 30, "cohesion": 1e6
    }));
    let water = json!({ "/bodies/0/pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1e-9, "bulk_modulus": 1e5 } });
    let mut cases = Vec::new();
    let mut add = |name: &str, space: &str, method: &'static str, options: Value, change: &Value| {
        cases.push((name.to_owned(), method, block(space, method, &options, change)));
    };
    for (space, cell) in [("plane-strain", 0.05), ("3d", 0.1)] {
        add("gimp", space, "mpm", json!({ "cell_size": cell }), &none);
        add("law", space, "mpm", json!({ "cell_size": cell }), &plastic);
        add(
            "cpdi",
            space,
            "mpm",
            json!({ "cell_size": cell, "shape": "cpdi", "stress_update": "usl" }),
            &none,
        );
        add(
            "apic",
            space,
            "mpm",
            json!({ "cell_size": cell, "shape": "quadratic", "transfer": "apic" }),
            &none,
        );
        add(
            "mesh",
            space,
            "mpm",
            json!({ "cell_size": cell, "shape": "linear", "mesh": { "kind": "box" } }),
            &none,
        );
        add(
            "shared",
            space,
            "mpm",
            json!({ "cell_size": cell, "shape": "linear", "volumetric_strain": "nodal" }),
            &none,
        );
        add("two phases", space, "mpm", json!({ "cell_size": cell, "shape": "linear" }), &water);
        add("sph", space, "sph", json!({ "spacing": 0.5 * cell }), &none);
        add("sph law", space, "sph", json!({ "spacing": 0.5 * cell }), &plastic);
    }
    for (space, diameter) in [("plane-strain", 0.03), ("3d", 0.1)] {
        let random = json!({ "kind": "random", "solid_fraction": if space == "3d" { 0.5 } else { 0.7 } });
        for (name, fill) in
            [("random", random), ("lattice", json!({ "kind": "lattice", "packing": "hexagonal" }))]
        {
            let sizes = json!({ "distribution": "uniform", "min": 0.8 * diameter, "max": diameter });
            add(
                name,
                space,
                "dem",
                json!({
                    "grains": { "m": { "density": 2600, "diameter": sizes, "fill": fill } },
                    "pairs": [{ "between": ["m", "m"], "normal": { "law": "linear", "stiffness": 1e5, "damping_ratio": 0.1 },
                                "friction": { "coefficient": 0.5 } }]
                }),
                &none,
            );
        }
    }
    let mut wrong = Vec::new();
    for (name, method, case) in cases {
        let method_of = colluvium::method(method).unwrap();
        let (size, plan) = (method_of.problem_size(&case).unwrap(), method_of.plan(&case).unwrap());
        let [made, held] = held(&case, method);
        // Grains may take most memory before they move.
        let most = if method == "dem" { made.max(held) } else { held };
        let (said, before) = (plan.memory as f64 / held, size.memory / most);
        println!(
            "{name} {:?}: {made:.3e} made, {held:.3e} held, plan {said:.3}, size {before:.3} ({} points)",
            case.space, plan.points
        );
        if !((0.75..1.3).contains(&said) && (0.6..1.3).contains(&before)) {
            wrong.push(format!("{name} {:?}: plan {said:.2}, size {before:.2} of what is held", case.space));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
