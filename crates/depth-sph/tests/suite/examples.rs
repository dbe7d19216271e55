//! Programs of the folder `examples`, each against its closed form.

#[path = "../../examples/seiche.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod seiche;

/// The theory is that of small amplitudes, here a twenty-fifth of the depth.
#[test]
fn a_shaken_tank_has_the_amplitude_of_its_resonance_and_comes_to_rest() {
    let [largest, exact, last] = seiche::amplitudes().unwrap();
    assert!((largest / exact - 1.0).abs() < 0.02, "{largest} {exact}");
    assert!(last.abs() < 0.05 * largest, "{last} of {largest}");
}
