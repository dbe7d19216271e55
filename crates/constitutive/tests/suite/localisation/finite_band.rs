//! Bands of finite and of zero thickness in explicit form, and loss of ellipticity.

use colluvium_constitutive::localisation::{
    FiniteBand, acoustic_tensor, least_ellipticity, zero_thickness_jump, zero_thickness_stress,
};
use colluvium_constitutive::{Mat3, SymTensor};
use colluvium_testkit::assert_near;

use super::{NORMAL, stiffness};

const STRAIN: SymTensor = SymTensor([1e-4, -4e-5, 0.0, 2e-5, 0.0, 0.0]);

#[test]
fn a_band_of_finite_thickness() {
    let band = FiniteBand::new(1e-3, 20e-3, NORMAL, stiffness(30e9, 0.2), stiffness(0.3e9, 0.3)).unwrap();
    let found = band.response(&STRAIN).unwrap();
    for (jump, exact) in found.jump.into_iter().zip([1.921_471_05e-6, -0.861_514_011e-6, 0.0]) {
        assert_near(jump, exact, 1e-14);
    }
    for (stress, exact) in
        found.mean.0.into_iter().zip([415_826.215, -446_176.697, -2_517.341_95, 348_963.187])
    {
        assert_near(stress, exact, 1e-3);
    }
    // Continuity of traction, and the work of the point shared between band and surroundings (eq. 93).
    let gap = (found.outside - found.inside_stress).apply(NORMAL);
    assert!(gap.iter().all(|t| t.abs() <= 1e-9 * found.mean.norm()), "{gap:?}");
    let share = 1.0 / 20.0;
    let dyad = SymTensor::symmetric_dyad(NORMAL, found.jump);
    let (inside, outside) = (STRAIN + dyad * ((1.0 - share) / 1e-3), STRAIN - dyad * (share / 1e-3));
    let shared = share * found.inside_stress.dot(&inside) + (1.0 - share) * found.outside.dot(&outside);
    assert_near(shared, found.mean.dot(&STRAIN), 1e-12 * shared.abs());
}

#[test]
fn a_band_as_thick_as_the_point_has_its_stress_and_a_thin_elastic_one_no_effect() {
    let (outside, inside) = (stiffness(30e9, 0.2), stiffness(0.3e9, 0.3));
    let whole = FiniteBand::new(0.02, 0.02, NORMAL, outside, inside).unwrap().response(&STRAIN).unwrap();
    let exact = inside.apply(&STRAIN);
    assert!((whole.mean - exact).norm() <= 1e-12 * exact.norm());
    let thin = FiniteBand::new(1e-12, 0.02, NORMAL, outside, inside).unwrap().response(&STRAIN).unwrap();
    let exact = outside.apply(&STRAIN);
    assert!((thin.mean - exact).norm() <= 1e-7 * exact.norm());
    // Without thickness: a stiff band has no jump, and a soft one no traction.
    let stiff = zero_thickness_jump(&outside, &(Mat3::IDENTITY * 1e22), 0.02, NORMAL, &STRAIN).unwrap();
    let stress = zero_thickness_stress(&outside, 0.02, NORMAL, stiff, &STRAIN);
    assert!((stress - exact).norm() <= 1e-9 * exact.norm());
    let soft = zero_thickness_jump(&outside, &Mat3::ZERO, 0.02, NORMAL, &STRAIN).unwrap();
    let traction = zero_thickness_stress(&outside, 0.02, NORMAL, soft, &STRAIN).apply(NORMAL);
    assert!(traction.iter().all(|t| t.abs() <= 1e-12 * exact.norm()));
    // A thin band of finite thickness equals one without thickness, of stiffness n·D·n/h.
    let h = 1e-8;
    let inside = stiffness(3e12 * h, 0.3);
    let interface = acoustic_tensor(&inside, NORMAL) * (1.0 / h);
    let sharp = zero_thickness_jump(&outside, &interface, 0.02, NORMAL, &STRAIN).unwrap();
    let thin = FiniteBand::new(h, 0.02, NORMAL, outside, inside).unwrap().response(&STRAIN).unwrap();
    for (a, b) in sharp.into_iter().zip(thin.jump) {
        assert_near(a, b, 1e-5 * thin.jump[0].abs());
    }
}

#[test]
fn ellipticity_of_elasticity_and_its_loss() {
    let elastic = stiffness(20e6, 0.3);
    let found = least_ellipticity(&elastic, &Mat3::IDENTITY);
    let (m, g) = (26_923_076.923_076_92f64, 7_692_307.692_307_692f64);
    assert_near(found.determinant, m * g * g, 1e-9 * m * g * g);
    // Perfect von Mises plasticity in pure shear: no resistance along the planes of largest shear.
    let direction = SymTensor([1.0, -1.0, 0.0, 0.0, 0.0, 0.0]) * 0.5f64.sqrt();
    let mut plastic = elastic;
    for (i, row) in plastic.0.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry -= 2.0 * g * direction[i] * direction[j];
        }
    }
    for axes in [Mat3::IDENTITY, Mat3::rotation_z(0.3)] {
        let found = least_ellipticity(&plastic, &axes);
        assert!(found.determinant <= 1e-9 * m * g * g, "{found:?}");
        assert_near(found.normal[0].abs(), 0.5f64.sqrt(), 1e-4);
        assert_near(found.normal[1].abs(), 0.5f64.sqrt(), 1e-4);
    }
}
