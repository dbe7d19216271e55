//! Laws of the band: cohesive friction and cohesive damage.

use colluvium_constitutive::laws::{CohesiveBand, CohesiveBandSpec, CohesiveDamageSpec, CohesiveState};
use colluvium_constitutive::{InterfaceLaw, InterfacePoint};
use colluvium_testkit::assert_near;

use super::BAND;

#[test]
fn shear_strength_of_the_band_as_it_softens() {
    let band = BAND.law().unwrap();
    assert_near(band.shear_strength(0.0, 0.0), 3.6e6, 1e-6);
    let table = [
        (0.0, 5.019_960_16e6),
        (0.5, 3.571_869_07e6),
        (1.0, 2.677_133_40e6),
        (3.0, 1.417_682_96e6),
        (700.0, 1.2e6),
    ];
    for (slip, exact) in table {
        assert_near(band.shear_strength(-2e6, slip), exact, 5e-3);
    }
}

/// Tractions of a path of jump increments, with a point that starts free of traction.
fn path(band: &CohesiveBand, jump: [f64; 3], steps: usize) -> Vec<InterfacePoint<CohesiveState>> {
    let mut point = InterfacePoint::<CohesiveState>::default();
    let step = |point: &mut InterfacePoint<CohesiveState>| {
        *point = band.update(jump, point).unwrap();
        *point
    };
    (0..steps).map(|_| step(&mut point)).collect()
}

#[test]
fn the_areas_under_opening_and_sliding_are_the_fracture_energies() {
    let stiff = CohesiveBandSpec { normal_stiffness: 1e15, shear_stiffness: 1e15, ..BAND };
    for (jump, energy, component) in [([1e-8, 0.0, 0.0], 100.0, 0), ([0.0, 6e-8, 8e-8], 1000.0, 1)] {
        let band = stiff.law().unwrap();
        let points = path(&band, jump, 60_000);
        let along =
            |point: &InterfacePoint<CohesiveState>| (0..3).map(|k| point.traction[k] * jump[k]).sum::<f64>();
        let mut area = 0.5 * along(&points[0]);
        area += points.windows(2).map(|pair| 0.5 * (along(&pair[0]) + along(&pair[1]))).sum::<f64>();
        assert_near(area, energy, 1e-3 * energy);
        let spent: f64 = points.windows(2).map(|pair| band.dissipation(&pair[0], &pair[1])).sum();
        assert_near(spent, energy, 2e-3 * energy);
        assert!(band.damage(&points[59_999].state) > 0.999, "component {component}");
    }
}

#[test]
fn pure_opening_follows_the_exponential_for_any_dilatancy() {
    for dilatancy_coefficient in [0.0, 0.3] {
        let band = CohesiveBandSpec { dilatancy_coefficient, ..BAND }.law().unwrap();
        for point in path(&band, [1e-6, 0.0, 0.0], 100) {
            let exact = 3e6 * (-point.state.plastic_jump[0] * 3e6 / 100.0).exp();
            assert_near(point.traction[0], exact, 1e-3);
        }
    }
}

#[test]
fn a_broken_band_is_coulomb_friction_and_keeps_contact() {
    let band = CohesiveBandSpec { normal_stiffness: 1e12, shear_stiffness: 1e12, ..BAND }.law().unwrap();
    let broken = CohesiveState { softening: 50.0, ..CohesiveState::default() };
    let pressed = InterfacePoint { traction: [-2e6, 0.0, 0.0], state: broken };
    let slid = band.update([0.0, 3e-5, 4e-5], &pressed).unwrap();
    assert_near(slid.traction[0], -2e6, 1e-6);
    assert_near(slid.traction[1].hypot(slid.traction[2]), 1.2e6, 1.0);
    assert_near(slid.traction[2] / slid.traction[1], 4.0 / 3.0, 1e-12);
    let deeper = band.update([-1e-6, 0.0, 0.0], &pressed).unwrap();
    assert_near(deeper.traction[0], -3e6, 1e-6);
    let open = band.update([1e-3, 1e-5, 0.0], &pressed).unwrap();
    assert!(open.traction.iter().all(|t| t.abs() < 1.0), "{open:?}");
}

#[test]
fn stiffnesses_are_the_slopes_of_the_tractions() {
    let with = |dilatancy_coefficient| CohesiveBandSpec {
        dilatancy_coefficient,
        normal_stiffness: 1e12,
        shear_stiffness: 5e11,
        ..BAND
    };
    let jumps = [[4e-6, 1e-6, -2e-6], [-2e-6, 3e-5, 1e-5], [2e-5, 1e-5, 0.0], [1e-6, 0.0, 0.0]];
    fn check<B: InterfaceLaw>(band: &B, jumps: &[[f64; 3]], scale: f64) {
        let start = InterfacePoint { traction: [1e6, 5e5, 0.0], state: band.initial([1e6, 5e5, 0.0]) };
        for jump in jumps {
            let analytic = band.stiffness(*jump, &start).unwrap();
            for column in 0..3 {
                let moved = |amount: f64| {
                    let mut moved = *jump;
                    moved[column] += amount;
                    band.update(moved, &start).unwrap().traction
                };
                let (plus, minus) = (moved(1e-11), moved(-1e-11));
                for row in 0..3 {
                    assert_near(analytic[row][column], (plus[row] - minus[row]) / 2e-11, 1e-5 * scale);
                }
            }
        }
    }
    check(&with(0.0).law().unwrap(), &jumps, 1e12);
    check(&with(0.25).law().unwrap(), &jumps, 1e12);
    let damage = CohesiveDamageSpec { tensile_strength: 3e6, fracture_energy: 100.0, stiffness: 1e12 };
    check(&damage.law().unwrap(), &jumps, 1e12);
}

#[test]
fn a_relaxed_trial_is_shared_by_band_and_surroundings() {
    fn check<B: InterfaceLaw>(band: &B) {
        let mut point = InterfacePoint { traction: [1e6, 5e5, 0.0], state: band.initial([1e6, 5e5, 0.0]) };
        for trial in [[2e6, 6e5, 1e5], [4e6, 3e6, -1e6], [-5e6, 9e6, 0.0], [8e6, 0.0, 0.0], [-1e6, -2e6, 3e6]]
        {
            let (jump, new) = band.relax_with_surroundings(trial, [2e12, 1e12], &point).unwrap();
            let again = band.update(jump, &point).unwrap();
            for k in 0..3 {
                let left = trial[k] - if k == 0 { 2e12 } else { 1e12 } * jump[k];
                assert_near(left, new.traction[k], 1e-2);
                assert_near(again.traction[k], new.traction[k], 1e-2);
            }
            point = new;
        }
    }
    let band = CohesiveBandSpec { normal_stiffness: 1e13, shear_stiffness: 1e13, ..BAND };
    check(&band.law().unwrap());
    check(&CohesiveBandSpec { dilatancy_coefficient: 0.2, ..band }.law().unwrap());
    check(
        &CohesiveDamageSpec { tensile_strength: 3e6, fracture_energy: 100.0, stiffness: 1e13 }.law().unwrap(),
    );
}

#[test]
fn the_area_under_a_radial_path_of_the_damage_law_is_its_energy() {
    let law =
        CohesiveDamageSpec { tensile_strength: 3e6, fracture_energy: 100.0, stiffness: 1e13 }.law().unwrap();
    for jump in [[1e-7, 0.0, 0.0], [0.0, 1e-7, 0.0], [6e-8, 0.0, -8e-8]] {
        let mut point = InterfacePoint::default();
        let mut area = 0.0;
        for _ in 0..6000 {
            let new = law.update(jump, &point).unwrap();
            area += (0..3).map(|k| 0.5 * (new.traction[k] + point.traction[k]) * jump[k]).sum::<f64>();
            assert!(law.yield_value(&new) <= 1e-3);
            assert!(law.dissipation(&point, &new) >= 0.0);
            point = new;
        }
        assert_near(area, 100.0, 0.1);
    }
}
