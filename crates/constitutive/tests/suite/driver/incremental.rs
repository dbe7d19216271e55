//! Tests in the form of incremental driver files.

use colluvium_constitutive::driver::incremental::*;
use colluvium_testkit::assert_close;

use super::*;

/// Initial conditions 11 22 33 12 13 23 in kPa.
const START: &str = "6\n-100.0\n-100.0d0\n-1.0e2\n0\n0\n0\n2\n0.7\n";

fn read(test: &str) -> Result<IncrementalTest, Vec<TestProblem>> {
    let parameters = Some("Elastic # kPa\n 2\n 2.0d4 Young\n 0.3\n");
    IncrementalTest::read(&IncrementalInput {
        parameters,
        initial: START,
        test,
        material: elastic(),
        stress_unit: 1e3,
    })
}

fn run(test: &str) -> ElementPath {
    let read = read(test).unwrap_or_else(|problems| panic!("{problems:?}"));
    let mut path = read.test.run().unwrap();
    read.remove_unwanted_rows(&mut path);
    path
}

#[test]
fn the_three_files_are_read() {
    let test =
        read("out.txt # a heading\n*PureRelaxation\n 10 5 2.0 ninc maxiter dt\n*End\nnever read\n").unwrap();
    assert_eq!(test.test.title, "a heading");
    assert_eq!(test.test.initial_stress, [-1e5, -1e5, -1e5, 0.0, 0.0, 0.0]);
    assert_eq!(test.state, [0.7, 0.0]);
    assert_eq!(test.parameters, UmatProperties { name: "Elastic".into(), values: vec![2e4, 0.3] });
    assert_eq!((test.test.stages.len(), test.test.stages[0].duration), (1, 2.0));
}

#[test]
fn oedometric_steps_have_the_oedometric_modulus() {
    let modulus = BULK + 4.0 / 3.0 * SHEAR;
    let strain = run("o\n*OedometricE1\n20 10 1.0\n-0.01\n");
    assert_close(strain.last("stress_xx"), -100e3 - 0.01 * modulus, 1e-9);
    assert_close(strain.last("strain_yy"), 0.0, 1e-12);
    let stress = run("o\n*OedometricS1\n20 10 1.0\n-50\n");
    assert_close(stress.last("stress_xx"), -150e3, 1e-9);
    assert_close(stress.last("strain_xx"), -50e3 / modulus, 1e-9);
}

#[test]
fn triaxial_steps_have_youngs_modulus() {
    let strain = run("o\n*TriaxialE1\n20 10 1.0\n-0.002\n");
    assert_close(strain.last("stress_xx"), -100e3 - 0.002 * YOUNG, 1e-9);
    assert_close(strain.last("stress_zz"), -100e3, 1e-9);
    let stress = run("o\n*TriaxialS1\n20 10 1.0\n-20\n");
    assert_close(stress.last("strain_xx"), -20e3 / YOUNG, 1e-9);
    assert_close(stress.last("strain_yy"), 0.3 * 20e3 / YOUNG, 1e-9);
}

#[test]
fn undrained_steps_keep_the_volume_and_follow_three_shear_moduli() {
    // ε_q = 2/3 (ε2 - ε1), q = 3 G ε_q.
    let strain = run("o\n*TriaxialUEq\n20 10 1.0\n0.01\n");
    assert_close(strain.last("q"), 3.0 * SHEAR * 0.01, 1e-9);
    assert_close(strain.last("strain_xx"), -0.01, 1e-9);
    assert_close(strain.last("volumetric_strain"), 0.0, 1e-12);
    assert_close(strain.last("p"), 100e3, 1e-9);
    let stress = run("o\n*TriaxialUq\n20 10 1.0\n30\n*UndrainedCreep\n4 10 100.\n");
    assert_close(stress.last("q"), 30e3, 1e-9);
    assert_close(stress.last("strain_yy"), 0.5 * 30e3 / (3.0 * SHEAR), 1e-9);
    assert_close(stress.last("time"), 101.0, 1e-12);
}

#[test]
fn linear_loads_in_every_kind_of_variable() {
    let rows = |variables: &str, rows: &str| format!("o\n*LinearLoad\n10 10 1.0\n{variables}\n{rows}");
    // Isotropic to p + 60 kPa at constant q and z.
    let roscoe = run(&rows("*Roscoe", "1 60\n1 0\n1 0\n0 0\n0 0\n0 0\n"));
    assert_close(roscoe.last("stress_yy"), -160e3, 1e-9);
    assert_close(roscoe.last("volumetric_strain"), -60e3 / BULK, 1e-9);
    let isomorph = run(&rows("*RoscoeIsomorph", "1 60\n1 0\n1 0\n0 0\n0 0\n0 0\n"));
    assert_close(isomorph.last("stress_zz"), -100e3 - 60e3 / 3f64.sqrt(), 1e-9);
    let rendulic = run(&rows("*Rendulic", "1 20\n1 0\n0 0\n0 0\n0 0\n0 0\n"));
    assert_close(rendulic.last("stress_xx"), -120e3, 1e-9);
    assert_close(rendulic.last("stress_yy"), -100e3, 1e-9);
    // Engineering shear, order 12 13 23.
    let shear = run(&rows("*Cartesian", "0 0\n0 0\n0 0\n0 1d-3\n0 2d-3\n1 4\n"));
    assert_close(shear.last("stress_xy"), SHEAR * 1e-3, 1e-9);
    assert_close(shear.last("stress_zx"), SHEAR * 2e-3, 1e-9);
    assert_close(shear.last("stress_yz"), 4e3, 1e-9);
    assert_close(2.0 * shear.last("strain_yz"), 4e3 / SHEAR, 1e-9);
}

#[test]
fn a_circulating_load_is_a_sine_over_its_step() {
    // 1 % drift with a sine of 2 kPa on the shear stress, phase π/2: starts at its top.
    let path = run(
        "o\n*CirculatingLoad\n40 10 1.0\n*Cartesian\n0 0 0 -0.01\n0 0 0 0\n0 0 0 0\n1 2 1.5707963267948966 0\n0 0 0 0\n0 0 0 0\n",
    );
    let shear = path.column("stress_xy").unwrap();
    assert_close(shear[10], -2e3, 1e-9);
    assert_close(shear[20], -4e3, 1e-9);
    assert_close(shear[40], 0.0, 1e-6);
    assert_close(path.last("strain_xx"), -0.01, 1e-12);
}

#[test]
fn a_deformation_gradient_path_rotates_and_stretches() {
    let (c, s) = (30f64.to_radians().cos(), 30f64.to_radians().sin());
    let test = format!("o\n*DeformationGradient\n200 1 1.0\n{c}\n{c}\n1\n{}\n{s}\n0\n0\n0\n0\n", -s);
    let initial = "6\n-100\n-50\n-70\n20\n0\n0\n0\n";
    let material = MaterialSpec::LinearElastic(LinearElasticSpec {
        density: 2000.0,
        youngs_modulus: 20e6,
        poissons_ratio: 0.3,
        strain_measure: StrainMeasure::Hencky,
    });
    let read = IncrementalTest::read(&IncrementalInput {
        parameters: None,
        initial,
        test: &test,
        material,
        stress_unit: 1e3,
    });
    let path = read.unwrap().test.run().unwrap();
    // sheet: constitutive V-02; the linear path to a rotation strains and comes back.
    assert_close(path.last("stress_xx"), -104_820.508_08, 1e-7);
    assert_close(path.last("stress_xy"), -11_650.635_09, 1e-6);
}

#[test]
fn repetitions_repeat_and_rows_are_thinned() {
    let cycle = "*Repetition\n2 3\n*TriaxialE1\n10 10 1.0 : 4\n-0.001\n*TriaxialE1\n10 10 1.0\n0.0005\n*PureCreep\n5 1 1.0\n";
    let test = read(&format!("o\n{cycle}")).unwrap();
    assert_eq!(test.test.stages.len(), 7);
    assert_eq!(test.output_interval, [4, 1, 4, 1, 4, 1, 1]);
    let path = run(&format!("o\n{cycle}"));
    // Of the ten rows of the first steps 1, 5, 9 and the last are kept.
    assert_eq!(path.rows.len(), 1 + 3 * (4 + 10) + 5);
    assert_close(path.last("stress_xx"), -100e3 - 0.0015 * YOUNG, 1e-9);
}

#[test]
fn keywords_are_case_insensitive_and_may_have_trailing_remarks() {
    let plain = run("o\n*LinearLoad\n10 10 1.0\n*Roscoe\n1 60\n1 0\n1 0\n0 0\n0 0\n0 0\n*End\nnever read\n");
    let odd = "o\n*LINEARLOAD # to 60 kPa\n10 10 1.0\n*ROSCOE\n1 60\n1 0\n1 0\n0 0\n0 0\n0 0\n*END  of all\nnever read\n";
    let odd = run(odd);
    assert_eq!(odd.rows.len(), plain.rows.len());
    assert_eq!(odd.last("stress_yy"), plain.last("stress_yy"));
    let twice = read("o\n*repetition\n1 2\n*oedometrice1\n20 10 1.0\n-0.01\n*end\n").unwrap();
    assert_eq!(twice.test.stages.len(), 2);
}

#[test]
fn mistakes_are_named_with_file_and_line() {
    let wrong = |test: &str| {
        let problems = read(test).unwrap_err();
        problems.iter().map(|problem| format!("{problem}\n")).collect::<String>()
    };
    assert!(
        wrong("o\n\n*Oedometer\n10 1 1\n0.1\n")
            .starts_with("test.inp:3: \"*Oedometer\" is not a supported keyword")
    );
    assert!(wrong("*TriaxialE1\n10 1 1\n0.1\n").starts_with("test.inp:1: the first line names"));
    assert!(wrong("o\n*TriaxialE1\n10 1\n0.1\n").starts_with("test.inp:3: \"10 1\" is not ninc"));
    assert!(wrong("o\n*TriaxialE1\n0 1 1\n0.1\n").starts_with("test.inp:3: ninc: 0"));
    assert!(wrong("o\n*TriaxialE1\n5 1 0\n0.1\n").starts_with("test.inp:3: deltaTime: 0"));
    assert!(wrong("o\n*TriaxialE1\n5 1 1\n").starts_with("test.inp:3: the file ends"));
    assert!(wrong("o\n*TriaxialE1 ? s1 > 5\n5 1 1\n1\n").contains("conditions after ?"));
    assert!(wrong("o\n*LinearLoad\n5 1 1\n*Roscoe\n2 1\n").starts_with("test.inp:5: ifstress: 2"));
    assert!(wrong("o\n*LinearLoad\n5 1 1\n*Polar\n").starts_with("test.inp:4: \"*Polar\""));
    assert!(wrong("o\n*Repetition\n1 2\n*End\n").starts_with("test.inp:4: *End is not allowed"));
    assert!(wrong("o\n*Repetition\n1 1000000\n").starts_with("test.inp:3: 1 steps 1000000 times"));
    assert!(
        wrong("o\n*PureCreep\n5 1 1\n*OedometricE1\n2 1 1\n-5\n").starts_with("test.inp:4: the amount 5")
    );
    assert!(wrong("o\n").starts_with("test.inp: at least one stage"));
    let initial = "7\n";
    let input = IncrementalInput {
        parameters: Some("a\n2\n1\n"),
        initial,
        test: "o\n*End",
        material: elastic(),
        stress_unit: 1.0,
    };
    let problems = IncrementalTest::read(&input).unwrap_err();
    assert_eq!(problems[0].path, "parameters.inp:3");
    assert_eq!(problems[1].to_string(), "initialconditions.inp:1: 7 stress components: there are at most 6");
}
