//! One law of the program in the element driver, in MPM and in SPH, against its closed form: compression without lateral strain.

use std::error::Error;
use std::sync::Arc;

use colluvium::case::{Body, Case, Domain, Space, Stage, Velocity};
use colluvium::constitutive::driver::{ElementTest, LoadingPath, TestStage};
use colluvium::constitutive::{Corotational, Elasticity, SymTensor};
use colluvium::mpm::{Mpm, MpmOptions};
use colluvium::sph::{Sph, SphOptions};
use law::HardeningMetal;

#[path = "../../constitutive/examples/laws/hardening_metal.rs"]
mod law;

/// Axial strain (logarithmic, compression-positive), and axial velocity over distance from the centre (1/s). A wave of 82 m/s from the free
/// sides of the block travels 0.16 m in the time of the compression.
const STRAIN: f64 = 0.02;
const RATE: f64 = 10.0;

/// Mean axial stress (Pa, compression-positive) within 0.2 m of the centre, 0.3 m from the free sides.
fn stress_at_centre<'a>(points: impl Iterator<Item = (&'a [f64; 2], &'a SymTensor)>) -> f64 {
    let inner = points.filter(|(x, _)| x[0].hypot(x[1]) < 0.2);
    let stresses: Vec<f64> = inner.map(|(_, stress)| -stress[1]).collect();
    stresses.iter().sum::<f64>() / stresses.len() as f64
}

/// Axial stresses (Pa) by the driver, MPM and SPH, and the closed form.
pub fn axial_stresses() -> Result<[f64; 4], Box<dyn Error>> {
    let metal = HardeningMetal { elasticity: Elasticity::new(1e7, 0.3)?, yield_stress: 1e5, hardening: 1e6 };
    let path = LoadingPath::Oedometer { axial_compression: STRAIN };
    let test = ElementTest::of_law("metal", 2e3, Arc::new(Corotational(metal))).stage(TestStage::new(path));
    let gradient = vec![vec![0.0, 0.0], vec![0.0, -RATE]];
    let velocity = Velocity::Linear { value: vec![0.0; 2], origin: vec![0.0; 2], gradient };
    // A point keeps its velocity: its distance from the centre shrinks by `1 - RATE t`.
    let case = Case::new(Space::PlaneStrain, Domain::new([-1.0, -1.0], [1.0, 1.0]))
        .law("metal", 2e3, Arc::new(Corotational(metal)))
        .body(Body { velocity, ..Body::block("block", "metal", [-0.5, -0.5], [0.5, 0.5]) })
        .stage(Stage::new("compression", (1.0 - (-STRAIN).exp()) / RATE));
    let mut mpm = Mpm::new(MpmOptions::new(0.1)).solver::<2>(&case)?;
    let mut sph = Sph::new(SphOptions::new(0.05)).solver::<2>(&case)?;
    while !mpm.is_complete() {
        mpm.step_at_most(5e-5)?;
    }
    while !sph.is_complete() {
        sph.step_at_most(5e-5)?;
    }
    let by_mpm = stress_at_centre(mpm.points().position().iter().zip(mpm.points().stress().iter()));
    let by_sph = stress_at_centre(sph.particles().position().iter().zip(sph.particles().stress()));
    Ok([-test.run()?.last_stress()[2], by_mpm, by_sph, metal.axial_stress(STRAIN)])
}

/// Prints the stresses.
fn main() -> Result<(), Box<dyn Error>> {
    let [driver, mpm, sph, exact] = axial_stresses()?;
    println!("driver {driver:.0} Pa, MPM {mpm:.0} Pa, SPH {sph:.0} Pa, closed form {exact:.0} Pa");
    Ok(())
}
