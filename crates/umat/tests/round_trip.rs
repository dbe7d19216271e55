//! Every law of Colluvium called as a UMAT through the UMAT loader gives the stresses of the law itself.

#![allow(unsafe_code, reason = "setting an environment variable is unsafe; this file has one test only")]

use std::collections::BTreeMap;
use std::path::PathBuf;

use colluvium_constitutive::laws::{UmatSpec, allow_libraries};
use colluvium_constitutive::{InitialCondition, Mat3, Material, MaterialSpec, Motion, States, SymTensor};

/// Shared library of this package, built beside its tests.
fn library() -> PathBuf {
    let deps = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let name = format!("{}colluvium_umat{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    [deps.join(&name), deps.parent().unwrap().join(&name)].into_iter().find(|p| p.exists()).expect("built")
}

fn start(law: &dyn Material, spec: &MaterialSpec) -> (SymTensor, States) {
    let sheared = SymTensor([-60e3, -50e3, -45e3, 3e3, -2e3, 1e3]);
    let density = spec.density();
    let admissible = |stress| law.initial(&[InitialCondition { stress, density }]);
    let isotropic = SymTensor::isotropic(sheared.trace() / 3.0);
    let (stresses, states) = admissible(sheared).or_else(|_| admissible(isotropic)).unwrap();
    (stresses[0], states)
}

fn path() -> Vec<Mat3> {
    (0..6)
        .map(|k| {
            let t = f64::from(k);
            Mat3([
                [-4e-3 * t.cos(), 6e-3, 1e-3 * t],
                [-2e-3 * t.sin(), 3e-3, -2e-3],
                [1e-3, 4e-3 * (0.5 * t).cos(), -2e-3],
            ])
        })
        .collect()
}

#[test]
fn every_law_as_a_umat_gives_its_own_stresses() {
    allow_libraries();
    let folder = tempfile::tempdir().unwrap();
    let specs: BTreeMap<String, MaterialSpec> = MaterialSpec::examples()
        .into_iter()
        .chain(MaterialSpec::wrapped_examples())
        .enumerate()
        .map(|(index, spec)| (format!("Material-{index}"), spec))
        .collect();
    let file = folder.path().join("materials.json");
    std::fs::write(&file, serde_json::to_string(&specs).unwrap()).unwrap();
    // SAFETY: no other thread of this process reads the environment at this time.
    unsafe { std::env::set_var(colluvium_umat::MATERIALS, &file) };
    for (name, spec) in &specs {
        let umat = MaterialSpec::Umat(UmatSpec {
            density: spec.density(),
            library: library(),
            symbol: "umat_".to_owned(),
            // Abaqus passes names in capitals.
            material_name: name.to_uppercase(),
            props: Vec::new(),
            state_variables: vec![0.0; 80],
            pascals: Some(1.0),
            wave_modulus: Some(1e9),
            thread_safe: true,
        });
        let umat = umat.build().unwrap();
        let law = spec.build().unwrap();
        let (mut here, mut there) = (start(&*law, spec), start(&*law, spec));
        let (stresses, states) =
            umat.initial(&[InitialCondition { stress: there.0, density: spec.density() }]).unwrap();
        there = (stresses[0], states);
        let mut density = spec.density();
        for a in path() {
            let mut motion = Motion::from_velocity_gradient(&(a * 100.0), 0.01, density, 0.1).unwrap();
            density /= motion.deformation.determinant();
            motion.density = density;
            for (law, point) in [(&law, &mut here), (&umat, &mut there)] {
                let mut stress = [point.0];
                law.update(&[motion], &mut stress, &mut point.1.blocks_mut()[0])
                    .unwrap_or_else(|error| panic!("{spec:?}: {error}"));
                point.0 = stress[0];
            }
            let difference = (here.0 - there.0).norm();
            assert!(difference <= 1e-9 * (here.0.norm() + 1e3), "{spec:?}: {difference} of {:?}", here.0);
        }
    }
}
