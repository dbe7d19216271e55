//! Programs of the folder `examples`, each against its closed form.

#[path = "../../examples/column.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod column;

/// The run-out in a channel is `1.2 H` for columns lower than 1.8 widths (Lube et al. 2005). A tolerance of 8 % of the front is one of 15 %
/// of the run-out. No material is faster than in free fall through the height of the column.
#[test]
fn a_column_of_sand_has_the_front_of_experiments_and_one_with_cohesion_stands() {
    let [front, fastest] = column::collapse(20.0).unwrap();
    assert!((front / (0.1 + 1.2 * 0.1) - 1.0).abs() < 0.08, "{front}");
    assert!(fastest < (2.0f64 * 9.81 * 0.1).sqrt(), "{fastest}");
    let [front, _] = column::collapse(500.0).unwrap();
    assert!(front < 0.101, "{front}");
}
