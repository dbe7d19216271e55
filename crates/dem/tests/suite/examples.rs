//! Programs of the folder `examples`, each against its closed form.

#[path = "../../examples/servo_cell.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod servo_cell;

/// The tolerance is that of a proportional servo, whose error decays with time.
#[test]
fn walls_of_a_servo_cell_reach_their_stress() {
    for (wall, stress) in servo_cell::wall_stresses().unwrap() {
        assert!((stress / servo_cell::TARGET - 1.0).abs() < 0.01, "{wall}: {stress}");
    }
}
