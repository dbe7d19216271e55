//! Tests of cells against closed forms of regular packings, and against the method on an equal specimen.

use colluvium_case::{Case, Solver};
use colluvium_constitutive::{Mat3, SymTensor};
use colluvium_testkit::assert_relative;
use serde_json::{Value, json};

use super::GranularCellSpec;
use crate::DemSolver;
use crate::material::cell_operations;
use crate::material::cell_operations::CellCase;

/// Diameter of the grains of lattices (m), density (kg/m³), contact stiffness (N/m; of disks Pa), and tangential over normal stiffness.
const SIZE: f64 = 1e-3;
const DENSITY: f64 = 2600.0;
const STIFFNESS: f64 = 5e4;
const STIFFNESS_RATIO: f64 = 0.8;

fn spec(dimension: usize, grains: usize, diameter: &Value, damping_ratio: f64) -> GranularCellSpec {
    let spec = json!({
        "dimension": dimension, "grains": grains, "grain_density": DENSITY, "seed": 3, "diameter": diameter,
        "contact": {
            "normal": { "law": "linear", "stiffness": STIFFNESS, "damping_ratio": damping_ratio },
            "tangential": { "stiffness_ratio": STIFFNESS_RATIO },
            "friction": { "coefficient": 5.0 }
        },
        "preparation": { "pressure": 0.1 * STIFFNESS / SIZE.powi(dimension as i32 - 2) * 0.02 }
    });
    serde_json::from_value(spec).unwrap()
}

fn equal_grains(dimension: usize, grains: usize, damping_ratio: f64) -> GranularCellSpec {
    spec(dimension, grains, &json!({ "distribution": "equal", "value": SIZE }), damping_ratio)
}

/// Cell with grains at these places and these cell vectors.
fn lattice_cell<const D: usize, const R: usize>(
    spec: &GranularCellSpec,
    places: &[[f64; D]],
    vectors: [f64; D],
) -> DemSolver<D, R> {
    let mut solver: DemSolver<D, R> = CellCase::new(spec).unwrap().solver().unwrap();
    solver.begin_stage(2, 0.0).unwrap();
    assert_eq!(solver.grains.len(), places.len());
    solver.grains.position.copy_from_slice(places);
    for c in 0..D {
        solver.cell.geometry.h[c][c] = vectors[c];
    }
    solver.neighbours.since_build.cell = None;
    solver.neighbours.reset_contacts();
    looked_at(&mut solver);
    solver
}

/// Stress after a step without deformation, which belongs to the present positions of the grains.
fn looked_at<const D: usize, const R: usize>(solver: &mut DemSolver<D, R>) -> SymTensor {
    solver.cell.imposed_gradient = Some([[0.0; D]; D]);
    let dt = solver.critical_step().dt;
    solver.advance(dt).unwrap();
    cell_operations::stress(solver)
}

/// Deformation gradient of a strain rate of one over a time.
fn stretch(rates: [f64; 3], shear: f64, time: f64) -> Mat3 {
    let [x, y, z] = rates.map(|rate| (rate * time).exp());
    Mat3([[x, shear * time, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]])
}

/// Deforms a cell like that of a material point, in ten updates.
fn deformed_cell<const D: usize, const R: usize>(
    solver: &mut DemSolver<D, R>,
    spec: &GranularCellSpec,
    f: &Mat3,
) -> SymTensor {
    for _ in 0..10 {
        let before = cell_operations::stress(solver);
        cell_operations::deform(solver, spec, f, &before).unwrap();
    }
    looked_at(solver)
}

/// Initial distance of neighbours (m), with an overlap of 0.2 %.
const APART: f64 = 0.998 * SIZE;

/// Elongation of the tangential spring of a contact whose grains do not rotate, when its branch changes from (`x`, `from`) to
/// (`x`, `to`): the integral of x dz over the length.
fn spring_elongation(x: f64, from: f64, to: f64) -> f64 {
    x * ((to / x).asinh() - (from / x).asinh())
}

/// Spheres on a face-centred cubic lattice of two by two by two unit cells.
fn face_centred(spec: &GranularCellSpec) -> DemSolver<3, 3> {
    let half = APART / 2f64.sqrt();
    let mut places = Vec::new();
    for i in 0..4 {
        for j in 0..4 {
            for k in 0..4 {
                if (i + j + k) % 2 == 0 {
                    places.push([i, j, k].map(|n| (f64::from(n) + 0.5) * half));
                }
            }
        }
    }
    lattice_cell(spec, &places, [4.0 * half; 3])
}

/// Disks in rows along x, four by four.
fn rows_of_disks(spec: &GranularCellSpec, lean: f64, height: f64) -> DemSolver<2, 1> {
    let mut places = Vec::new();
    for j in 0..4 {
        for i in 0..4 {
            places.push([
                (f64::from(i) + 0.25 + lean * f64::from(j % 2)) * APART,
                (f64::from(j) + 0.5) * height * APART,
            ]);
        }
    }
    lattice_cell(spec, &places, [4.0 * APART, 4.0 * height * APART])
}

#[test]
fn a_lattice_of_spheres_has_its_stress_under_isotropic_and_uniaxial_strain() {
    let spec = equal_grains(3, 32, 0.0);
    let strain = 3e-3;
    // p = (1/3V) Σ k δ l with six contacts a grain in l³/√2.
    let pressure = |apart: f64| 2.0 * 2f64.sqrt() * STIFFNESS * (SIZE - apart) / (apart * apart);
    let mut cube = face_centred(&spec);
    assert_relative(-cell_operations::stress(&cube)[0], pressure(APART), 1e-9);
    let stress = deformed_cell(&mut cube, &spec, &stretch([-strain; 3], 0.0, 0.1));
    for c in 0..3 {
        assert_relative(-stress[c], pressure(APART * (-strain).exp()), 1e-4);
    }

    let mut cube = face_centred(&spec);
    let stress = deformed_cell(&mut cube, &spec, &stretch([0.0, 0.0, -strain], 0.0, 0.1));
    let (x, before) = (APART / 2f64.sqrt(), APART / 2f64.sqrt());
    let z = before * (-strain).exp();
    let (long, volume) = (x.hypot(z), 2.0 * x * x * z);
    let (pushed, slid) =
        (STIFFNESS * (SIZE - long), STIFFNESS_RATIO * STIFFNESS * spring_elongation(x, before, z));
    let along = 2.0 * x * (pushed * x + slid * z) / long;
    let side = (STIFFNESS * (SIZE - APART) * APART + along) / volume;
    let axial = 4.0 * z * (pushed * z - slid * x) / long / volume;
    assert_relative(-stress[0], side, 1e-4);
    assert_relative(-stress[1], side, 1e-4);
    assert_relative(-stress[2], axial, 1e-4);
}

#[test]
fn a_lattice_of_disks_has_its_stress_under_isotropic_uniaxial_and_simple_shear_strain() {
    let spec = equal_grains(2, 16, 0.0);
    let strain = 3e-3;
    let high = 0.75f64.sqrt();
    let pressure = |apart: f64| 3f64.sqrt() * STIFFNESS * (SIZE - apart) / apart;
    let mut cell = rows_of_disks(&spec, 0.5, high);
    let stress = deformed_cell(&mut cell, &spec, &stretch([-strain, -strain, 0.0], 0.0, 0.1));
    assert_relative(-stress[0], pressure(APART * (-strain).exp()), 1e-4);
    assert_relative(-stress[1], pressure(APART * (-strain).exp()), 1e-4);

    let mut cell = rows_of_disks(&spec, 0.5, high);
    let stress = deformed_cell(&mut cell, &spec, &stretch([0.0, -strain, 0.0], 0.0, 0.1));
    let (x, before) = (0.5 * APART, high * APART);
    let y = before * (-strain).exp();
    let (long, volume) = (x.hypot(y), APART * y);
    let (pushed, slid) =
        (STIFFNESS * (SIZE - long), STIFFNESS_RATIO * STIFFNESS * spring_elongation(x, before, y));
    let side = (STIFFNESS * (SIZE - APART) * APART + 2.0 * x * (pushed * x + slid * y) / long) / volume;
    assert_relative(-stress[0], side, 1e-4);
    assert_relative(-stress[1], 2.0 * y * (pushed * y - slid * x) / long / volume, 1e-4);

    // Columns of a square lattice tilt by the strain, and its disks rotate by half of it, so that the moments of their contacts cancel: the
    // springs are elongated by half of it, and the normal forces of the columns increase the tilt.
    let mut cell = rows_of_disks(&spec, 0.0, 1.0);
    let stress = deformed_cell(&mut cell, &spec, &stretch([0.0; 3], strain, 0.1));
    let exact = strain * STIFFNESS * (0.5 * STIFFNESS_RATIO - (SIZE - APART) / APART);
    assert_relative(stress[3], exact, 3e-3);
}

#[test]
fn dashpots_add_the_share_of_stress_that_the_inertial_number_sets() {
    let ratio = 0.4;
    let spec = equal_grains(3, 32, ratio);
    let mut cube = face_centred(&spec);
    let before = cell_operations::stress(&cube);
    cell_operations::deform(&mut cube, &spec, &stretch([-1e-4; 3], 0.0, 1.0), &before).unwrap();
    let rate = -cube.cell.imposed_gradient.unwrap()[0][0];
    // The bound applies to the norm of the strain-rate tensor.
    let bound = spec.inertial_number * (-before[0] / DENSITY).sqrt() / SIZE / 3f64.sqrt();
    assert!(rate <= bound && rate > 0.9 * bound, "{rate} {bound}");
    let apart = APART * (-1e-4f64).exp();
    let mass = DENSITY * std::f64::consts::PI / 6.0 * SIZE.powi(3);
    let viscous = 2.0 * ratio * (0.5 * STIFFNESS * mass).sqrt() * rate * apart;
    // The forces of a step depend on the velocities before it.
    let moving = looked_at(&mut cube)[0];
    let still = looked_at(&mut cube)[0];
    let share = viscous / (STIFFNESS * (SIZE - apart));
    assert_relative(moving / still - 1.0, share, 0.05);
}

/// Case of the method with the grains of a law, drawn in a cell of this side (m) that deforms at these rates (1/s).
fn case_of(spec: &GranularCellSpec, side: f64, rates: [[f64; 3]; 3]) -> Case {
    let d = spec.dimension;
    let (low, high, axes) = (vec![0.0; d], vec![side; d], &["x", "y", "z"][..d]);
    let mut pair = serde_json::to_value(&spec.contact).unwrap();
    pair["between"] = json!(["grain", "grain"]);
    let mut cell = json!({});
    for (name, i, j) in [("xx", 0, 0), ("yy", 1, 1), ("zz", 2, 2), ("xy", 0, 1)] {
        if i < d && j < d {
            cell[name] = json!({ "rate": rates[i][j] });
        }
    }
    let case = json!({
        "title": "the same cell", "space": if d == 3 { "3d" } else { "plane-strain" }, "gravity": low,
        "domain": { "min": low, "max": high, "periodic": axes },
        "materials": { "grain": { "model": "linear-elastic", "density": DENSITY, "youngs_modulus": 1e9, "poissons_ratio": 0 } },
        "bodies": [{ "name": "cell", "material": "grain", "shape": { "kind": "box", "min": low, "max": high } }],
        "stages": [{ "name": "deform", "duration": 1, "damping": spec.damping }],
        "methods": { "dem": {
            "grains": { "grain": { "density": DENSITY, "diameter": spec.diameter,
                "fill": { "kind": "random", "solid_fraction": spec.solid_fraction() } } },
            "pairs": [pair], "seed": spec.seed, "stages": { "deform": { "cell": cell } }
        } }
    });
    Case::from_json(&case.to_string()).unwrap()
}

/// Deforms a specimen as the cell of a point and as a cell of the method, and compares all that both store.
fn compare_cells<const D: usize, const R: usize>(spec: &GranularCellSpec, f: &Mat3) {
    let mut law: DemSolver<D, R> = CellCase::new(spec).unwrap().solver().unwrap();
    let side = law.cell.geometry.h[0][0];
    cell_operations::prepare(&mut law, spec, 0.0).unwrap();
    let specimen = cell_operations::bytes(&law).unwrap();
    let (before, first) = (cell_operations::stress(&law), law.clock.step);
    cell_operations::deform(&mut law, spec, f, &before).unwrap();
    let rates = law.cell.imposed_gradient.unwrap();
    let rates =
        std::array::from_fn(|i| std::array::from_fn(|j| if i < D && j < D { rates[i][j] } else { 0.0 }));
    let mut method: DemSolver<D, R> = crate::setup::solver(&case_of(spec, side, rates)).unwrap();
    method.begin_stage(0, 0.0).unwrap();
    method.restore(&mut &specimen[..]).unwrap();
    assert!(law.clock.step - first > 100, "{}", law.clock.step - first);
    for _ in first..law.clock.step {
        method.step(f64::INFINITY).unwrap();
    }
    // More than the round-off tolerance: the stress has changed.
    let (after, own) = (cell_operations::stress(&law), cell_operations::stress(&method));
    assert!((after - before).norm() > 0.05 * before.norm(), "{before:?} {after:?}");
    assert_eq!(after, own);
    assert!(cell_operations::bytes(&law).unwrap() == cell_operations::bytes(&method).unwrap());
}

#[test]
fn a_cell_deforms_to_the_bits_of_the_same_specimen_in_the_method() {
    let sizes = json!({ "distribution": "uniform", "min": 0.8e-3, "max": 1.2e-3 });
    let (disks, spheres) = (spec(2, 60, &sizes, 0.4), spec(3, 60, &sizes, 0.4));
    for (rates, shear) in [([-1.0, -1.0, -1.0], 0.0), ([0.5, 0.5, -1.0], 0.0), ([0.0; 3], 1.0)] {
        compare_cells::<3, 3>(&spheres, &stretch(rates, shear, 1e-3));
    }
    for (rates, shear) in [([-1.0, -1.0, 0.0], 0.0), ([1.0, -1.0, 0.0], 0.0), ([0.0; 3], 1.0)] {
        compare_cells::<2, 1>(&disks, &stretch(rates, shear, 1e-3));
    }
}
