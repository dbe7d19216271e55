//! Programs of the folder `examples`, each against its closed form.

#[path = "../../examples/own_law.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod own_law;

/// Radial return is exact on a straight path of strain: round-off remains.
#[test]
fn a_hardening_metal_in_the_driver_has_the_axial_stress_of_the_closed_form() {
    let [axial, exact] = own_law::axial_stress().unwrap();
    assert!((axial / exact - 1.0).abs() < 1e-9, "{axial} {exact}");
}
