//! Programs of the folder `examples`, each against its closed form.

#[path = "../../examples/column.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod column;

#[test]
fn a_column_of_sand_collapses_and_one_with_cohesion_stands() {
    let ([front, fastest], [standing, _]) =
        (column::collapse(20.0).unwrap(), column::collapse(500.0).unwrap());
    println!("{front} {fastest} {standing}");
}
