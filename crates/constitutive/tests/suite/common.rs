//! What the tests share.

use colluvium_constitutive::laws::Elasticity;

/// Set R1 of the constitutive sheet, in kPa.
pub fn r1() -> Elasticity {
    Elasticity::new(20_000.0, 0.3).unwrap()
}

/// `found` is within `tolerance` of `exact`.
pub fn near(found: f64, exact: f64, tolerance: f64) {
    assert!((found - exact).abs() <= tolerance, "{found} for {exact}");
}

/// `found` is within `tolerance` of `exact`: relative above one, absolute below.
pub fn close(found: f64, exact: f64, tolerance: f64) {
    near(found, exact, tolerance * exact.abs().max(1.0));
}
