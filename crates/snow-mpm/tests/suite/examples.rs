//! Programs of the folder `examples`, each against its closed form.

#[path = "../../examples/snowball.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod snowball;

/// Steps of first order resolve the growth of the drag to a thousandth. Snow of 400 kg/m³ that comes to rest from 3 m/s is compacted.
#[test]
fn a_snowball_hits_the_ground_with_the_velocity_of_the_closed_form_and_is_compacted() {
    let [impact, exact, densest] = snowball::impact().unwrap();
    assert!((impact / exact - 1.0).abs() < 1e-3, "{impact} {exact}");
    assert!(densest > 1.05 * 400.0, "{densest}");
}
