//! Loading of a foreign UMAT: a small one in C, built here.

use std::path::{Path, PathBuf};
use std::process::Command;

use colluvium_constitutive::driver::incremental::{IncrementalInput, IncrementalTest};
use colluvium_constitutive::laws::{LinearElasticSpec, StrainMeasure, UmatSpec, allow_libraries};
use colluvium_constitutive::{InitialCondition, Mat3, Material, MaterialSpec, Motion, States, SymTensor};

/// Builds the C file of the tests as a shared library.
fn built(folder: &Path) -> PathBuf {
    allow_libraries();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/elastic_umat.c");
    let library = folder.join("libelastic_umat.so");
    // The linker required by Rust is a C compiler.
    let compiler = std::env::var("CC").unwrap_or("cc".to_owned());
    let mut command = Command::new(compiler);
    let output = command.args(["-shared", "-fPIC", "-O1", "-o"]).arg(&library).arg(source).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    library
}

fn spec(library: PathBuf) -> UmatSpec {
    UmatSpec {
        density: 2000.0,
        library,
        symbol: "umat_".to_owned(),
        material_name: String::new(),
        props: vec![20e3, 0.3],
        state_variables: vec![0.0, 0.0],
        pascals: Some(1e3),
        wave_modulus: None,
        thread_safe: false,
    }
}

fn start(law: &dyn Material) -> (SymTensor, States) {
    let stress = SymTensor([-60e3, -50e3, -45e3, 3e3, -2e3, 1e3]);
    let (stresses, states) = law.initial(&[InitialCondition { stress, density: 2000.0 }]).unwrap();
    (stresses[0], states)
}

#[test]
fn an_elastic_umat_in_kilopascals_is_the_elastic_law() {
    let folder = tempfile::tempdir().unwrap();
    let umat = MaterialSpec::Umat(spec(built(folder.path()))).build().unwrap();
    let elastic = MaterialSpec::LinearElastic(LinearElasticSpec {
        density: 2000.0,
        youngs_modulus: 20e6,
        poissons_ratio: 0.3,
        strain_measure: StrainMeasure::Rate,
    });
    let elastic = elastic.build().unwrap();
    let (mut here, mut there) = (start(&*umat), start(&*elastic));
    // Without spin, full rotation before the step and half rotations around it are equal.
    let shear = Mat3([[1e-3, 2e-3, -5e-4], [2e-3, -3e-3, 7e-4], [-5e-4, 7e-4, 1.5e-3]]);
    let motion = Motion::from_velocity_gradient(&shear, 1.0, 2000.0, 0.1).unwrap();
    for (law, point) in [(&umat, &mut here), (&elastic, &mut there)] {
        for _ in 0..5 {
            let mut stress = [point.0];
            law.update(&[motion], &mut stress, &mut point.1.blocks_mut()[0]).unwrap();
            point.0 = stress[0];
        }
    }
    assert!((here.0 - there.0).norm() < 1e-9 * there.0.norm(), "{:?} and {:?}", here.0, there.0);
    let tangent = |law: &dyn Material, point: &(SymTensor, States)| {
        law.tangent(&motion, &point.0, &point.1.blocks()[0], 0).unwrap().0
    };
    for (one, other) in
        tangent(&*umat, &here).iter().flatten().zip(tangent(&*elastic, &there).iter().flatten())
    {
        assert!((one - other).abs() < 1e-6, "{one} and {other}");
    }
    let mut modulus = [0.0];
    umat.wave_moduli(&[here.0], &here.1.blocks()[0], &mut modulus);
    assert!((modulus[0] / 26_923_076.923 - 1.1).abs() < 1e-9);
}

#[test]
fn the_step_number_is_passed_as_four_numbers_of_which_the_first_counts() {
    let folder = tempfile::tempdir().unwrap();
    let routine =
        UmatSpec { symbol: "jstep_".to_owned(), state_variables: vec![0.0; 4], ..spec(built(folder.path())) };
    let law = MaterialSpec::Umat(routine).build().unwrap();
    let (stress, mut states) = start(&*law);
    let motion =
        Motion::from_velocity_gradient(&Mat3([[1e-3, 0.0, 0.0], [0.0; 3], [0.0; 3]]), 1.0, 2000.0, 0.1);
    law.update(&[motion.unwrap()], &mut [stress], &mut states.blocks_mut()[0]).unwrap();
    // Number of the step, static, of large deformations, no perturbation.
    let saved: serde_json::Value = serde_json::to_value(law.save(&states)).unwrap();
    let bytes: Vec<u8> = serde_json::from_value(saved).unwrap();
    let numbers: Vec<u8> = [1.0f64, 1.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    assert!(bytes.windows(numbers.len()).any(|part| part == numbers), "{bytes:?}");
}

#[test]
fn a_rigid_rotation_rotates_the_stress_of_a_umat() {
    let folder = tempfile::tempdir().unwrap();
    let umat = MaterialSpec::Umat(spec(built(folder.path()))).build().unwrap();
    let (stress, mut states) = start(&*umat);
    let q = Mat3::rotation_z(0.7);
    let motion = Motion::from_deformation(&q, 1.0, 2000.0, 0.1).unwrap();
    let mut turned = [stress];
    umat.update(&[motion], &mut turned, &mut states.blocks_mut()[0]).unwrap();
    assert!((turned[0] - stress.rotated(&q)).norm() < 1e-9 * stress.norm());
}

#[test]
fn errors_in_user_libraries_name_the_key_and_the_cause() {
    let folder = tempfile::tempdir().unwrap();
    let library = built(folder.path());
    let fail = |spec: UmatSpec| MaterialSpec::Umat(spec).build().err().expect("refused").to_string();
    let missing = fail(spec(folder.path().join("none.so")));
    assert!(missing.starts_with("library: ") && missing.contains("none.so"), "{missing}");
    let text = folder.path().join("text.so");
    std::fs::write(&text, "no library").unwrap();
    let not_one = fail(spec(text));
    assert!(not_one.starts_with("library: ") && not_one.contains("cannot be loaded"), "{not_one}");
    // The system's loader gives the reason.
    #[cfg(target_os = "linux")]
    assert!(not_one.contains("file too short") || not_one.contains("invalid ELF header"), "{not_one}");
    let no_file = fail(spec(folder.path().to_owned()));
    assert!(no_file.contains("is not a regular file"), "{no_file}");
    let symbol = fail(UmatSpec { symbol: "vumat_".to_owned(), ..spec(library.clone()) });
    assert!(symbol.starts_with("symbol: \"vumat_\" is not in"), "{symbol}");
    #[cfg(target_os = "linux")]
    assert!(symbol.contains("undefined symbol: vumat_"), "{symbol}");
    let props = fail(UmatSpec { props: vec![1.0, f64::NAN], ..spec(library.clone()) });
    assert!(props.starts_with("props: NaN"), "{props}");
    // Too few properties: this library then requests a shorter step.
    let law = MaterialSpec::Umat(UmatSpec { props: vec![1.0], ..spec(library) }).build().unwrap();
    let condition = InitialCondition { stress: SymTensor::ZERO, density: 2000.0 };
    let error = law.initial(&[condition]).expect_err("refused").to_string();
    assert!(error.contains("shorter step"), "{error}");
}

#[test]
fn a_non_finite_stiffness_of_a_umat_fails_the_step() {
    let folder = tempfile::tempdir().unwrap();
    // Also with a user-defined modulus for the time step.
    for wave_modulus in [None, Some(1e8)] {
        let broken = UmatSpec { symbol: "nan_".to_owned(), wave_modulus, ..spec(built(folder.path())) };
        let law = MaterialSpec::Umat(broken).build().unwrap();
        let (stress, mut states) = start(&*law);
        let shear = Mat3([[1e-3, 0.0, 0.0], [0.0; 3], [0.0; 3]]);
        let motion = Motion::from_velocity_gradient(&shear, 1.0, 2000.0, 0.1).unwrap();
        let error = law.update(&[motion], &mut [stress], &mut states.blocks_mut()[0]).expect_err("stopped");
        assert!(error.to_string().contains("DDSDDE"), "{error}");
    }
}

/// The files of incrementalDriver supply values that a user material omits; its own values, a unit of one pascal too, have priority.
#[test]
fn driver_files_supply_only_omitted_values_of_a_user_material() {
    let folder = tempfile::tempdir().unwrap();
    let library = built(folder.path());
    let read = |more: UmatSpec| {
        let input = IncrementalInput {
            parameters: Some("Elastic # kPa\n 2\n 2.0d4 Young\n 0.3\n"),
            initial: "6\n-100.0\n-100.0d0\n-1.0e2\n0\n0\n0\n2\n0.7\n",
            test: "o\n*PureCreep\n5 1 1\n*End",
            material: MaterialSpec::Umat(more),
            stress_unit: 1e3,
        };
        let read = IncrementalTest::read(&input).unwrap();
        let MaterialSpec::Umat(umat) = read.test.material else { panic!("another law") };
        (umat.props, umat.state_variables, umat.pascals, read.uses_file_values)
    };
    let open =
        UmatSpec { props: Vec::new(), state_variables: Vec::new(), pascals: None, ..spec(library.clone()) };
    assert_eq!(read(open), (vec![2e4, 0.3], vec![0.7, 0.0], Some(1e3), [true; 2]));
    let given =
        UmatSpec { props: vec![1.0, 0.1], state_variables: vec![3.0], pascals: Some(1.0), ..spec(library) };
    assert_eq!(read(given), (vec![1.0, 0.1], vec![3.0], Some(1.0), [false; 2]));
}
