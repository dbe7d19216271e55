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

/// Case with its name and method.
struct MemoryCase {
    name: String,
    method: &'static str,
    case: Case,
}

impl MemoryCase {
    fn new(name: &str, space: &str, method: &'static str, options: &Value, change: &Value) -> Self {
        Self { name: name.to_owned(), method, case: block(space, method, options, change) }
    }
}

/// Cases of the material point method and of SPH, on cells of `cell` (m).
fn continuum_cases(space: &str, cell: f64) -> Vec<MemoryCase> {
    let none = json!({});
    let plastic = json!({ "/materials/m": {
        "model": "mohr-coulomb", "density": 1500, "youngs_modulus": 1e5, "poissons_ratio": 0.2, "friction_angle": 30, "cohesion": 1e6
    } });
    let water = json!({ "/bodies/0/pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1e-9, "bulk_modulus": 1e5 } });
    let mpm = [
        ("gimp", json!({}), &none),
        ("law", json!({}), &plastic),
        ("cpdi", json!({ "shape": "cpdi", "stress_update": "usl" }), &none),
        ("apic", json!({ "shape": "quadratic", "transfer": "apic" }), &none),
        ("mesh", json!({ "shape": "linear", "mesh": { "kind": "box" } }), &none),
        ("shared", json!({ "shape": "linear", "volumetric_strain": "nodal" }), &none),
        ("two phases", json!({ "shape": "linear" }), &water),
    ];
    let mpm = mpm.into_iter().map(|(name, mut options, change)| {
        options["cell_size"] = json!(cell);
        MemoryCase::new(name, space, "mpm", &options, change)
    });
    let sph = [("sph", &none), ("sph law", &plastic)];
    let sph = sph
        .map(|(name, change)| MemoryCase::new(name, space, "sph", &json!({ "spacing": 0.5 * cell }), change));
    mpm.chain(sph).collect()
}

/// Cases of grains of `diameter` (m), in a random and in a regular packing.
fn grain_cases(space: &str, diameter: f64) -> Vec<MemoryCase> {
    let random = json!({ "kind": "random", "solid_fraction": if space == "3d" { 0.5 } else { 0.7 } });
    let fills = [("random", random), ("lattice", json!({ "kind": "lattice", "packing": "hexagonal" }))];
    let cases = fills.map(|(name, fill)| {
        let sizes = json!({ "distribution": "uniform", "min": 0.8 * diameter, "max": diameter });
        let options = json!({
            "grains": { "m": { "density": 2600, "diameter": sizes, "fill": fill } },
            "pairs": [{ "between": ["m", "m"], "normal": { "law": "linear", "stiffness": 1e5, "damping_ratio": 0.1 },
                        "friction": { "coefficient": 0.5 } }]
        });
        MemoryCase::new(name, space, "dem", &options, &json!({}))
    });
    cases.into()
}

#[test]
fn memory_estimates_of_a_plan_match_the_memory_of_its_run() {
    let continuum = [("plane-strain", 0.05), ("3d", 0.1)];
    let grains = [("plane-strain", 0.03), ("3d", 0.1)];
    let continuum = continuum.into_iter().flat_map(|(space, cell)| continuum_cases(space, cell));
    let grains = grains.into_iter().flat_map(|(space, diameter)| grain_cases(space, diameter));
    // All are made before any is measured.
    let cases: Vec<MemoryCase> = continuum.chain(grains).collect();
    let mut wrong = Vec::new();
    for MemoryCase { name, method, case } in cases {
        let method_of = colluvium::method(method).unwrap();
        let (size, plan) = (method_of.problem_size(&case).unwrap(), method_of.plan(&case).unwrap());
        let [made, held] = held(&case, method);
        // Grains may take most memory before they move.
        let peak = if method == "dem" { made.max(held) } else { held };
        let (said, before) = (plan.memory as f64 / held, size.memory / peak);
        println!(
            "{name} {:?}: {made:.3e} made, {held:.3e} held, plan {said:.3}, size {before:.3} ({} points)",
            case.space, plan.points
        );
        if !((0.75..1.3).contains(&said) && (0.6..1.3).contains(&before)) {
            wrong.push(format!(
                "{name} {:?}: plan {said:.2}, size {before:.2} of the memory held",
                case.space
            ));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
