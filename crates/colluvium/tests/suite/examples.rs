//! Programs of the folder `examples`, each against its closed form.

use colluvium::case::Solver;

#[path = "../../examples/coupled_flow.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod coupled_flow;

#[path = "../../examples/frictional_column.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod frictional_column;

#[path = "../../examples/hardening_metal.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod hardening_metal;

#[path = "../../examples/lowered_water.rs"]
#[expect(dead_code, reason = "tests call the functions of a program, and not its main")]
mod lowered_water;

/// Momentum across a bore is conserved whatever its thickness; a ripple behind it and the slow part of the wall's oscillation remain.
#[test]
fn water_behind_a_reflected_bore_loads_the_foundation_of_a_wall_with_its_hydrostatic_force() {
    let [force, exact] = coupled_flow::force_on_foundation().unwrap();
    assert!((force / exact - 1.0).abs() < 0.01, "{force} {exact}");
}

/// No point has more than its strength, and a solver that continues from the checkpoint ends with the same bits.
#[test]
fn a_column_with_a_law_of_the_program_keeps_to_its_strength_and_continues_from_its_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let solver = frictional_column::collapse(folder.path()).unwrap();
    for stress in solver.points().stress().iter() {
        let strength = frictional_column::STRESS_RATIO * stress.pressure();
        assert!(stress.pressure() >= 0.0 && stress.q() <= strength + 1e-6, "{stress:?}");
    }
    let mut again = frictional_column::column().unwrap();
    again.restore(&mut std::fs::File::open(folder.path().join("column.checkpoint")).unwrap()).unwrap();
    again.step_to(0.6).unwrap();
    assert_eq!(again.snapshot().hash(), solver.snapshot().hash());
    assert!(std::fs::read(folder.path().join("column.png")).unwrap().starts_with(b"\x89PNG"));
}

/// Radial return is exact on a straight path of strain. Steps of MPM and SPH integrate the motion with a relative error below a hundredth.
#[test]
fn a_hardening_metal_has_the_axial_stress_of_the_closed_form_in_the_driver_in_mpm_and_in_sph() {
    let [driver, mpm, sph, exact] = hardening_metal::axial_stresses().unwrap();
    assert!((driver / exact - 1.0).abs() < 1e-9, "{driver} {exact}");
    assert!((mpm / exact - 1.0).abs() < 0.01, "{mpm} {exact}");
    assert!((sph / exact - 1.0).abs() < 0.01, "{sph} {exact}");
}

/// Beside the left side, two heights from the crest, the ground is level: `σ'` is the weight of the soil above, less that of the water in
/// its place. Cells of an eighth of the height leave an error of less than a hundredth, and the slide changes `σ'` by two hundredths.
#[test]
fn a_lowered_water_level_raises_effective_stresses_and_a_slope_slides_if_water_remains_in_it() {
    let mean = |density: f64| 0.5 * density * 9.81 * 4.0;
    let [[before, start], [after, end]] = lowered_water::drawdown(0.0).unwrap();
    assert!((before / mean(2000.0 - 1000.0) - 1.0).abs() < 0.01, "below water {before}");
    assert!((after / mean(2000.0) - 1.0).abs() < 0.01, "drained {after}");
    assert!(end - start < 0.01, "{start} {end}");
    let [_, [after, end]] = lowered_water::drawdown(1.0).unwrap();
    assert!((after / mean(2000.0 - 1000.0) - 1.0).abs() < 0.03, "with the water in the slope {after}");
    assert!(end - start > 0.5, "{start} {end}");
}
