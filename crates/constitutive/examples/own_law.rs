//! Law of the program's own in the element driver, against its closed form.

use std::error::Error;
use std::sync::Arc;

use colluvium_constitutive::driver::{ElementTest, LoadingPath, TestStage};
use colluvium_constitutive::{Corotational, Elasticity};
use hardening_metal::HardeningMetal;

#[path = "laws/hardening_metal.rs"]
mod hardening_metal;

/// Axial stress (Pa) of a point compressed without lateral strain, and its closed form.
pub fn axial_stress() -> Result<[f64; 2], Box<dyn Error>> {
    let strain = 0.02;
    let metal = HardeningMetal { elasticity: Elasticity::new(1e7, 0.3)?, yield_stress: 1e5, hardening: 1e6 };
    let test = ElementTest::of_law("hardening-metal", 2000.0, Arc::new(Corotational(metal)))
        .stage(TestStage::new(LoadingPath::Oedometer { axial_compression: strain }));
    let axial = -test.run()?.last_stress()[2];
    Ok([axial, metal.axial_stress(strain)])
}

/// Prints the axial stress.
fn main() -> Result<(), Box<dyn Error>> {
    let [axial, exact] = axial_stress()?;
    println!("axial stress {axial:.0} Pa, closed form {exact:.0} Pa");
    Ok(())
}
