//! Reference values of `sheet: constitutive §1–3` (kPa where the sheet says so), computed there with
//! independent scripts.

mod drucker_prager;
mod elasticity;
mod mohr_coulomb;

use colluvium_constitutive::{Mat3, Motion, Point, SmallStrain, SymTensor};

fn still() -> Motion {
    Motion::from_deformation(&Mat3::IDENTITY, 1.0, 2.0, 1.0).unwrap()
}

/// Return of a trial stress: a step without strain from it.
fn returned<L: SmallStrain>(law: &L, trial: [f64; 6], state: L::State) -> Point<L::State> {
    law.update(&SymTensor::ZERO, &still(), &Point { stress: SymTensor(trial), state }).unwrap()
}
