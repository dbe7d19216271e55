//! Programs of the folder `examples`, each against its closed form.

#[path = "../../examples/dynamic_relaxation.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod dynamic_relaxation;

#[path = "../../examples/channel_flow.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod channel_flow;

/// The settlement is that of the uppermost particles, half a spacing of a layer of 20 below the surface.
#[test]
fn a_relaxed_layer_has_the_stress_and_the_settlement_of_its_weight() {
    let [[stress, settlement], exact] = dynamic_relaxation::settled_layer().unwrap();
    assert!((stress / exact[0] - 1.0).abs() < 0.02, "{stress} {exact:?}");
    assert!((settlement / exact[1] - 1.0).abs() < 0.05, "{settlement} {exact:?}");
}

/// The particles next to the middle are half a spacing away from it, and the rates below 0.1 1/s have a constant viscosity.
#[test]
fn a_shear_thinning_liquid_has_the_velocity_of_the_closed_form() {
    let [fastest, exact] = channel_flow::velocity_in_the_middle().unwrap();
    assert!((fastest / exact - 1.0).abs() < 0.05, "{fastest} {exact}");
}
