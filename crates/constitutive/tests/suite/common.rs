//! What the tests share.

use colluvium_constitutive::MaterialError;
use colluvium_constitutive::laws::Elasticity;

pub use colluvium_testkit::{close, near};

/// Set R1 of the constitutive sheet, in kPa.
pub fn r1() -> Elasticity {
    Elasticity::new(20_000.0, 0.3).unwrap()
}

/// `found` agrees with `exact` to `digits` significant digits as printed: half a unit of the last one.
pub fn digits(found: f64, exact: f64, digits: i32) {
    let unit = 10f64.powi(exact.abs().log10().floor() as i32 + 1 - digits);
    assert!((found - exact).abs() <= 0.5 * unit * (1.0 + 1e-9), "{found} for {exact}");
}

/// `result` refuses the parameter `name`.
pub fn assert_field<T>(result: Result<T, MaterialError>, name: &str) {
    match result {
        Err(MaterialError::Parameter { field, .. }) => assert_eq!(field, name),
        Err(error) => panic!("{name}: {error}"),
        Ok(_) => panic!("{name}: accepted"),
    }
}
