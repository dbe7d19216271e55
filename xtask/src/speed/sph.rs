//! `cargo xtask bench --sph`: particle-updates per second of smoothed particle hydrodynamics.

use colluvium::case::{Case, Solver};
use serde_json::json;

use crate::speed::mpm::updates_per_second;

/// Problem and number of threads of a measurement.
struct SphBenchSetting {
    dimension: usize,
    model: &'static str,
    motion: BenchMotion,
    points: usize,
    threads: usize,
}

/// Motion of the particles during a measurement.
#[derive(Clone, Copy, PartialEq)]
enum BenchMotion {
    /// The particles settle: neighbours remain.
    Settling,
    /// The particles shear past each other: neighbours change again and again. The block is periodic along the motion, so that the
    /// measurement may take any time.
    Shearing,
}

impl SphBenchSetting {
    /// Name of the setting: its values separated by commas.
    fn name(&self) -> String {
        let Self { dimension, model, points, threads, .. } = self;
        let motion = if self.motion == BenchMotion::Settling { "settling" } else { "shearing" };
        format!("sph,{dimension}d,{motion},{model},{points},{threads}")
    }

    /// Case of a block of particles on a rough floor, with a cubic spline and a smoothing length of 1.2 spacings.
    fn case(&self) -> Result<Case, String> {
        let edge = (self.points as f64).powf(1.0 / self.dimension as f64).round();
        let spacing = 1.0 / edge;
        let all = |value: f64| vec![value; self.dimension];
        let (mut gravity, mut floor) = (all(0.0), all(-4.0 * spacing));
        gravity[1] = -0.1;
        floor[1] = 0.0;
        let mut material =
            json!({ "model": self.model, "density": 2000.0, "youngs_modulus": 1e6, "poissons_ratio": 0.3 });
        if self.model != "linear-elastic" {
            material["friction_angle"] = json!(20.0);
            material["cohesion"] = json!(0.1);
        }
        let (mut velocity, mut ceiling) = (json!({ "kind": "rest" }), all(1.0 + 4.0 * spacing));
        let mut periodic = json!([]);
        if self.motion == BenchMotion::Shearing {
            (floor[0], ceiling[0], periodic) = (0.0, 1.0, json!(["x"]));
            // A wall keeps ejected particles in the domain.
            ceiling[1] = 2.0;
            // At the top a fifth of the speed of sound (26 m/s): neighbour lists are valid for some ten steps.
            let mut gradient = vec![all(0.0); self.dimension];
            gradient[0][1] = 5.0;
            velocity =
                json!({ "kind": "linear", "value": all(0.0), "origin": all(0.0), "gradient": gradient });
        }
        let text = json!({
            "title": "throughput",
            "space": if self.dimension == 2 { "plane-strain" } else { "3d" },
            "domain": { "min": floor, "max": ceiling, "periodic": periodic },
            "gravity": gravity,
            "materials": { "soil": material },
            "bodies": [{ "name": "block", "material": "soil", "velocity": velocity,
                         "shape": { "kind": "box", "min": all(0.0), "max": all(1.0) } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
            "stages": [{ "name": "settle", "duration": 1.0 }],
            "methods": { "sph": { "spacing": spacing } }
        });
        Case::from_json(&text.to_string()).map_err(|errors| errors.to_string())
    }

    /// Number of particles, and particle-updates per second over a duration (s).
    fn measure(&self, seconds: f64) -> Result<(usize, f64), String> {
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(self.threads).build().map_err(|e| e.to_string())?;
        pool.install(|| {
            let method = colluvium::method("sph").ok_or("no method sph")?;
            let mut solver: Box<dyn Solver> =
                method.build(&self.case()?).map_err(|error| error.to_string())?;
            solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
            let points = solver.point_count();
            let rate = updates_per_second(points, seconds, || {
                let dt = solver.limit().dt;
                solver.step(dt).map(drop).map_err(|error| error.to_string())
            })?;
            Ok((points, rate))
        })
    }
}

/// Prints the table of all settings.
pub fn print_table(
    sizes: &[usize],
    seconds: f64,
    threads: &[usize],
    filter: Option<&str>,
) -> Result<(), String> {
    println!("method,dimension,motion,model,points,threads,million_updates_per_second");
    for dimension in [2, 3] {
        for (motion, model) in [
            (BenchMotion::Settling, "linear-elastic"),
            (BenchMotion::Settling, "drucker-prager"),
            (BenchMotion::Shearing, "drucker-prager"),
        ] {
            for &points in sizes {
                for &threads in threads {
                    let setting = SphBenchSetting { dimension, model, motion, points, threads };
                    if filter.is_some_and(|filter| !setting.name().contains(filter)) {
                        continue;
                    }
                    let (points, rate) = setting.measure(seconds)?;
                    let name = SphBenchSetting { points, ..setting }.name();
                    println!("{name},{rate:.3}");
                }
            }
        }
    }
    Ok(())
}
