//! What the tests share.

/// `found` is within `tolerance` of `exact`.
pub fn near(found: f64, exact: f64, tolerance: f64) {
    assert!((found - exact).abs() <= tolerance, "{found} for {exact}");
}

/// `found` is within `tolerance` of `exact`: relative above one, absolute below.
pub fn close(found: f64, exact: f64, tolerance: f64) {
    near(found, exact, tolerance * exact.abs().max(1.0));
}
