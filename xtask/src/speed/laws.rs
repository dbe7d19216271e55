//! `cargo xtask bench --laws`: stress updates per second of every law, on one thread.

use std::hint::black_box;
use std::time::Instant;

use colluvium::constitutive::{
    BLOCK_SIZE, InitialCondition, Mat3, Material, MaterialSpec, Motion, States, SymTensor, spectra,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Number of measured points. Their motions, stresses and states fit in the second-level cache.
const POINTS: usize = 16 * BLOCK_SIZE;

/// Strain of each step.
const STRAIN_STEP: f64 = 1e-4;

/// Number of steps before the measurement, after which every point yields.
const WARM_UP: usize = 100;

/// Number of steps that are timed together.
const STEPS_PER_LAP: usize = 20;

/// Measured speed of a law.
struct LawMeasurement {
    /// Million updates per second.
    rate: f64,
    /// Share of the points on their yield surface at the end.
    yielding: f64,
    /// Time of one spectral decomposition of these stresses over that of one update: alone, and in a batch.
    decomposition_share: [f64; 2],
}

/// Motions, stresses and states of the measured points.
#[derive(Clone)]
struct BenchPoints {
    motions: Vec<Motion>,
    stresses: Vec<SymTensor>,
    states: States,
}

/// Measures the laws whose description contains `filter`, and prints the table.
pub fn run(filter: Option<&str>, seconds: f64) -> Result<(), String> {
    println!("model,form,million updates per second,share yielding,share of spectral decomposition");
    for spec in MaterialSpec::examples().into_iter().chain(MaterialSpec::wrapped_examples()) {
        let form = option_text(&spec);
        if filter.is_some_and(|filter| !format!("{} {form}", spec.name()).contains(filter)) {
            continue;
        }
        let law = spec.build().map_err(|error| error.to_string())?;
        let LawMeasurement { rate, yielding, decomposition_share: [alone, batch] } =
            measure(&*law, spec.density(), seconds)?;
        let share = match decomposition(&spec) {
            DecompositionUse::None => 0.0,
            DecompositionUse::Alone => alone,
            DecompositionUse::Batch => batch,
        };
        println!("{},{form},{rate:.2},{yielding:.2},{share:.2}", spec.name());
    }
    Ok(())
}

/// Use of a spectral decomposition by a law in every yielding step, point by point or in batches.
enum DecompositionUse {
    /// No decomposition.
    None,
    /// Decompositions of single points.
    Alone,
    /// Decompositions of batches of points.
    Batch,
}

/// Use of a spectral decomposition in an update of a law.
fn decomposition(spec: &MaterialSpec) -> DecompositionUse {
    if let (Some(inner), false) = (spec.inner(), spec.name() == "saturation-softened") {
        return decomposition(inner);
    }
    let value = serde_json::to_value(spec).unwrap_or_default();
    let softens = value["softening"].is_object() || spec.inner().is_some();
    match spec.name() {
        "snow" | "fixed-corotated" | "cohesive-cam-clay" => DecompositionUse::Alone,
        "hypoplastic" if value["viscous"].is_object() => DecompositionUse::Alone,
        _ if value["strain_measure"] == "hencky" => DecompositionUse::Alone,
        "mohr-coulomb" | "tresca" if !softens => DecompositionUse::Batch,
        "saturation-softened" if value["material"]["model"] == "drucker-prager" => DecompositionUse::None,
        "mohr-coulomb" | "tension-cut" | "saturation-softened" => DecompositionUse::Alone,
        _ => DecompositionUse::None,
    }
}

/// Text that distinguishes the examples of one model by their options.
fn option_text(spec: &MaterialSpec) -> String {
    let value = serde_json::to_value(spec).unwrap_or_default();
    let mut words = Vec::new();
    for (key, value) in value.as_object().into_iter().flatten() {
        match value {
            serde_json::Value::String(text) if key != "model" => words.push(text.clone()),
            serde_json::Value::Object(inner) if inner.contains_key("model") => {
                words.extend(inner["model"].as_str().map(str::to_owned));
            }
            serde_json::Value::Object(inner) => {
                let kind = inner.get("kind").and_then(|kind| kind.as_str());
                words.push(kind.map_or_else(|| key.clone(), str::to_owned));
            }
            serde_json::Value::Number(_) if key == "tensile_strength" => words.push(key.clone()),
            _ => {}
        }
    }
    words.join(" ")
}

/// Initial states that a law admits: sheared where possible, else isotropically compressed.
fn initial_states(law: &dyn Material, density: f64) -> Result<(Vec<SymTensor>, States), String> {
    let sheared = SymTensor([-60e3, -50e3, -45e3, 3e3, -2e3, 1e3]);
    let at = |stress| law.initial(&vec![InitialCondition { stress, density }; POINTS]);
    at(sheared).or_else(|_| at(SymTensor::isotropic(-50e3))).map_err(|error| error.to_string())
}

/// Measures the stress updates per second of a law.
fn measure(law: &dyn Material, density: f64, seconds: f64) -> Result<LawMeasurement, String> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let (stresses, states) = initial_states(law, density)?;
    let motion = |random: &mut ChaCha8Rng| {
        // Shear in a random direction with some spin, no change of volume.
        let a = Mat3(std::array::from_fn(|_| std::array::from_fn(|_| random.random_range(-1.0..1.0))));
        let a = a - Mat3::IDENTITY * (a.trace() / 3.0);
        let a = a * (STRAIN_STEP / a.sym().norm());
        Motion::from_velocity_gradient(&(a * 1e4), 1e-4, density, 0.1).ok_or("a step of this size is regular")
    };
    let motions = (0..POINTS).map(|_| motion(&mut random)).collect::<Result<Vec<_>, _>>()?;
    let mut points = BenchPoints { motions, stresses, states };
    for _ in 0..WARM_UP {
        points.step(law)?;
    }
    // Every lap continues from the same yielding state, so that it measures loading.
    let start = points.clone();
    let (mut best, mut yielding) = (f64::INFINITY, 0.0);
    let began = Instant::now();
    while best.is_infinite() || began.elapsed().as_secs_f64() < seconds {
        points.clone_from(&start);
        let lap = Instant::now();
        for _ in 0..STEPS_PER_LAP {
            points.step(law)?;
        }
        best = best.min(lap.elapsed().as_secs_f64() / (STEPS_PER_LAP * POINTS) as f64);
        yielding = points.yielding(law);
    }
    let smallest = |lap: &mut dyn FnMut()| {
        let laps = (0..50).map(|_| {
            let began = Instant::now();
            lap();
            began.elapsed().as_secs_f64() / POINTS as f64
        });
        laps.fold(f64::INFINITY, f64::min)
    };
    let stresses = &points.stresses;
    let alone = smallest(&mut || {
        for stress in stresses {
            black_box(black_box(stress).spectrum());
        }
    });
    let mut found = vec![SymTensor::ZERO.spectrum(); POINTS];
    let batch = smallest(&mut || spectra(black_box(stresses), black_box(&mut found)));
    let spectrum = [alone / best, batch / best];
    Ok(LawMeasurement { rate: 1e-6 / best, yielding, decomposition_share: spectrum })
}

impl BenchPoints {
    /// Updates the stresses of all points by a step.
    fn step(&mut self, law: &dyn Material) -> Result<(), String> {
        let parts = self.stresses.chunks_mut(BLOCK_SIZE).zip(self.motions.chunks(BLOCK_SIZE));
        for (block, (stresses, motions)) in self.states.blocks_mut().iter_mut().zip(parts) {
            law.update(motions, stresses, block).map_err(|error| error.to_string())?;
        }
        Ok(())
    }

    /// Share of the points on the yield surface.
    fn yielding(&self, law: &dyn Material) -> f64 {
        let mut count = 0;
        for (block, stresses) in self.states.blocks().iter().zip(self.stresses.chunks(BLOCK_SIZE)) {
            let mut values = [0.0; BLOCK_SIZE];
            law.yield_values(stresses, block, &mut values[..stresses.len()]);
            let close = |(value, stress): (&f64, &SymTensor)| *value > -1e-6 * stress.norm();
            count += values.iter().zip(stresses).filter(|pair| close(*pair)).count();
        }
        count as f64 / POINTS as f64
    }
}
