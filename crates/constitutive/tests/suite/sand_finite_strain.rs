//! Sand at finite strain against closed forms (sheet: snow-mpm §2.10b, c, W4).

use colluvium_constitutive::laws::{Elasticity, SandHardening, SandSpec, StressInvariants};
use colluvium_constitutive::{InitialCondition, Mat3, Model, Motion, SymTensor};

use crate::snow_paths::{diagonal, walk, within};

fn sand(friction_angle: f64) -> SandSpec {
    SandSpec {
        density: 1600.0,
        youngs_modulus: 353.7e3,
        poissons_ratio: 0.3,
        friction_angle,
        hardening: None,
        volume_correction: true,
        invariants: StressInvariants::Space,
        return_initial_stress_to_yield: false,
    }
}

fn elasticity() -> Elasticity {
    Elasticity::new(353.7e3, 0.3).unwrap()
}

/// Kirchhoff stress and outputs at the end of a path of logarithmic strains.
fn end_of(spec: &SandSpec, path: &[[f64; 3]]) -> (SymTensor, [f64; 3]) {
    let law = spec.build().unwrap();
    let start = InitialCondition { stress: SymTensor::ZERO, density: 1600.0 };
    let (mut stresses, mut states) = law.initial(&[start]).unwrap();
    let mut volume = 1.0;
    for [x, y, z] in path {
        let motion = Motion::from_deformation(&diagonal(*x, *y, *z), 1.0, 1600.0, 1.0).unwrap();
        law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]).unwrap();
        volume *= (x + y + z).exp();
    }
    let mut outputs = [0.0; 3];
    law.outputs(&stresses, &states.blocks()[0], &mut outputs);
    (stresses[0] * volume, outputs)
}

#[test]
fn returns_are_those_of_the_sheet() {
    let table = [
        ([0.01, -0.02, -0.004], [0.0056, -0.0154, -0.0042]),
        ([0.02, -0.01, 0.0], [0.0; 3]),
        ([0.002, -0.02, -0.012], [0.002, -0.02, -0.012]),
    ];
    for (trial, exact) in table {
        let found = walk(&sand(30.0), &diagonal(trial[0], trial[1], trial[2]), 1)[0];
        let exact = elasticity().stress(&SymTensor::diagonal(exact[0], exact[1], exact[2]));
        let off = (found - exact).norm() / (2.0 * elasticity().shear_modulus);
        // The sheet has four decimals of the strain.
        assert!(off < 1e-4, "{trial:?}: off by a strain of {off}");
    }
    let (_, [flow, ..]) = end_of(&sand(30.0), &[[0.01, -0.02, -0.004]]);
    within(flow, 0.006_368_673_3, 1e-7, "plastic strain");
}

#[test]
fn opened_volume_closes_before_the_pressure_rises() {
    let pulls = [[0.03, 0.0, 0.0], [0.0, 0.004, 0.002]];
    let closes = [[-0.01; 3], [-0.012; 3], [-0.01; 3]];
    let path: Vec<[f64; 3]> = pulls.into_iter().chain(closes).collect();
    for steps in [1, 5] {
        let part = |step: &[f64; 3]| step.map(|e| e / f64::from(steps));
        let path: Vec<[f64; 3]> =
            path.iter().flat_map(|step| std::iter::repeat_n(part(step), steps as usize)).collect();
        let (open, [_, opened, _]) = end_of(&sand(30.0), &path[..3 * steps as usize]);
        assert!(open.norm() < 1e-9, "{open:?}");
        within(opened, 0.006, 1e-10, "gap that is still open");
        let (shut, [_, opened, _]) = end_of(&sand(30.0), &path);
        // As if the volume had never opened: p = -K ln J, J the volume since the start.
        within(shut.pressure(), elasticity().bulk_modulus * 0.06, 1e-9, "pressure");
        assert!(opened == 0.0 && shut.q() < 1e-6, "{shut:?}");
        let loose = SandSpec { volume_correction: false, ..sand(30.0) };
        let (shut, _) = end_of(&loose, &path);
        within(shut.pressure(), elasticity().bulk_modulus * 0.096, 1e-9, "pressure without correction");
    }
}

#[test]
fn in_the_plane_the_cone_has_two_thirds_of_its_slope() {
    let spec = SandSpec { invariants: StressInvariants::Plane, ..sand(30.0) };
    let trial = [0.01, -0.02];
    let found = walk(&spec, &diagonal(trial[0], trial[1], 0.0), 1)[0];
    let (lame, mu) = (elasticity().lame(), elasticity().shear_modulus);
    // The formula of the source with d = 2.
    let alpha = (2.0f64 / 3.0).sqrt() * 2.0 * 0.5 / 2.5;
    let (trace, deviator) = (-0.01, [0.015, -0.015]);
    let norm = 0.015 * 2f64.sqrt();
    let multiplier = norm + (2.0 * lame + 2.0 * mu) / (2.0 * mu) * trace * alpha;
    assert!(multiplier > 0.0);
    for c in 0..2 {
        let kept = trial[c] - multiplier * deviator[c] / norm;
        let exact = lame * trace + 2.0 * mu * kept;
        within(found[c], exact, 1e-10, "stress");
    }
    let pressure = -0.5 * (found[0] + found[1]);
    within(3f64.sqrt() * 0.5 * (found[0] - found[1]), 1.2 * 2.0 / 3.0 * pressure, 1e-10, "slope");
    assert!(found[3] == 0.0);
}

#[test]
fn the_friction_angle_follows_flow() {
    let hardening = SandHardening { growth: 9.0, fading: 0.2, below: 10.0 };
    let spec = SandSpec { hardening: Some(hardening), ..sand(35.0) };
    // First confined, then sheared far: friction rises and then falls.
    let shear = [0.02, -0.02, 0.0];
    let path: Vec<[f64; 3]> = [[-0.005; 3]].into_iter().chain(std::iter::repeat_n(shear, 400)).collect();
    for count in [2, 40, 400] {
        let (stress, [flow, _, angle]) = end_of(&spec, &path[..count]);
        let exact = 35.0 + (9.0 * flow - 10.0) * (-0.2 * flow).exp();
        within(angle, exact, 1e-12, "friction angle");
        let sine = angle.to_radians().sin();
        within(stress.q(), 6.0 * sine / (3.0 - sine) * stress.pressure(), 1e-9, "slope of the cone");
        within(stress.pressure(), elasticity().bulk_modulus * 0.015, 1e-9, "pressure");
    }
    let (_, [_, _, start]) = end_of(&spec, &path[..1]);
    within(start, 25.0, 1e-12, "friction angle before flow");
}

#[test]
fn parameters_out_of_range_are_refused_by_name() {
    let refused = |spec: SandSpec| spec.law().unwrap_err().to_string();
    assert!(refused(sand(0.0)).contains("friction_angle"));
    let steep = SandHardening { growth: 100.0, fading: 0.2, below: 10.0 };
    let error = refused(SandSpec { hardening: Some(steep), ..sand(35.0) });
    assert!(error.contains("hardening.growth") && error.contains("below 90"), "{error}");
    let low = SandHardening { growth: 9.0, fading: 0.2, below: 40.0 };
    assert!(refused(SandSpec { hardening: Some(low), ..sand(35.0) }).contains("hardening.below"));
}

#[test]
fn a_motion_out_of_the_plane_is_refused_by_its_name() {
    let law = SandSpec { invariants: StressInvariants::Plane, ..sand(30.0) }.build().unwrap();
    let start = InitialCondition { stress: SymTensor::ZERO, density: 1600.0 };
    let (mut stresses, mut states) = law.initial(&[start]).unwrap();
    let f = Mat3([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.01]]);
    let motion = Motion::from_deformation(&f, 1.0, 1600.0, 1.0).unwrap();
    let refused = law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]).unwrap_err().to_string();
    assert!(refused.contains("sand") && refused.contains("leaves the plane"), "{refused}");
}
