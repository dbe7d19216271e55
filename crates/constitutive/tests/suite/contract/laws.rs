//! Laws under test: the registered ones, bands with yielding surroundings, and steep softening.

use std::sync::LazyLock;

use colluvium_constitutive::laws::{
    DoubleScaleSpec, DruckerPragerSpec, Matching, MohrCoulombSpec, OutsideStrength, PlasticIntegration,
    Softening, StrainMeasure,
};
use colluvium_constitutive::{InitialCondition, MaterialSpec, SymTensor};

use super::Subject;

fn all() -> Vec<Subject> {
    let subject = |spec: MaterialSpec| {
        let law = spec.build().expect("an example builds");
        let start = SymTensor([-60e3, -50e3, -45e3, 3e3, -2e3, 1e3]);
        let mean = SymTensor::isotropic(start.trace() / 3.0);
        let fluid = law.initial(&[InitialCondition { stress: start, density: spec.density() }]).is_err();
        Subject { start: if fluid { mean } else { start }, spec, law, scale: 1.0 }
    };
    let registered =
        MaterialSpec::examples().into_iter().chain(MaterialSpec::wrapped_examples()).map(subject);
    let banded = yielding_surroundings().map(|spec| Subject { scale: SMALL, ..subject(spec) });
    registered.chain(banded).chain(steeply_softening().map(subject)).collect()
}

pub(super) fn subjects() -> &'static [Subject] {
    static SUBJECTS: LazyLock<Vec<Subject>> = LazyLock::new(all);
    &SUBJECTS
}

/// Steps of 0.1 % in place of 10 %.
const SMALL: f64 = 0.01;

/// Bands with yielding surroundings, without and with softening. They lose ellipticity, so that a long step may end
/// at one of several equilibria, or at none.
fn yielding_surroundings() -> [MaterialSpec; 2] {
    let banded = MaterialSpec::examples().into_iter().find_map(|spec| match spec {
        MaterialSpec::DoubleScale(spec) => Some(DoubleScaleSpec { local_solve: None, ..spec }),
        _ => None,
    });
    let banded = banded.expect("there is a sample");
    let softening = Softening {
        residual_friction_angle: 28.0,
        residual_cohesion: 12e3,
        friction_rate: 3.0,
        cohesion_rate: 5.0,
        hardening: false,
    };
    [None, Some(softening)].map(|softening| {
        let outside = OutsideStrength {
            friction_angle: 30.0,
            cohesion: 15e3,
            dilatancy_angle: 10.0,
            matching: Matching::Compression,
            softening,
        };
        MaterialSpec::DoubleScale(DoubleScaleSpec { outside: Some(outside), ..banded.clone() })
    })
}

/// Strength that falls faster than the stress unloads in yielding, 1.1 times for the pyramid, 1.3 times for the cone:
/// the step beyond the peak snaps back, and no single slope predicts its end.
fn steeply_softening() -> [MaterialSpec; 4] {
    let softening = Softening {
        residual_friction_angle: 2.0,
        residual_cohesion: 1e3,
        friction_rate: 10.0,
        cohesion_rate: 30.0,
        hardening: false,
    };
    let cone = |integration| {
        MaterialSpec::DruckerPrager(DruckerPragerSpec {
            density: 2000.0,
            youngs_modulus: 1e6,
            poissons_ratio: 0.3,
            friction_angle: 5.0,
            cohesion: 25e3,
            dilatancy_angle: 1.0,
            matching: Matching::Compression,
            softening: Some(softening),
            dilatancy_decay: 0.0,
            integration,
            strain_measure: StrainMeasure::Rate,
            return_initial_stress_to_yield: false,
        })
    };
    let pyramid = MaterialSpec::MohrCoulomb(MohrCoulombSpec {
        density: 2000.0,
        youngs_modulus: 1e6,
        poissons_ratio: 0.3,
        friction_angle: 5.0,
        cohesion: 25e3,
        dilatancy_angle: 1.0,
        softening: Some(softening),
        dilatancy_decay: 0.0,
        tensile_strength: None,
        strain_measure: StrainMeasure::Rate,
        return_initial_stress_to_yield: false,
    });
    let [returned, semi_implicit, explicit] =
        [PlasticIntegration::ClosestPoint, PlasticIntegration::SemiImplicit, PlasticIntegration::Explicit]
            .map(cone);
    [pyramid, returned, semi_implicit, explicit]
}

pub(super) fn solids() -> impl Iterator<Item = &'static Subject> {
    subjects().iter().filter(|subject| subject.is_solid())
}

/// Laws that declare isotropy.
pub(super) fn isotropic() -> impl Iterator<Item = &'static Subject> {
    subjects().iter().filter(|subject| subject.law.is_isotropic())
}

/// Laws, and those with a cohesion also without it, where that is a valid law.
pub(super) fn with_and_without_cohesion() -> Vec<Subject> {
    let bare = |subject: &Subject| {
        let mut spec = serde_json::to_value(&subject.spec).ok()?;
        *spec.get_mut("cohesion")? = 0.into();
        let spec: MaterialSpec = serde_json::from_value(spec).ok()?;
        Some(Subject { law: spec.build().ok()?, spec, start: SymTensor::ZERO, scale: 1.0 })
    };
    let subjects = all();
    let without: Vec<Subject> = subjects.iter().filter_map(bare).collect();
    assert!(without.len() >= 3, "laws have a cohesion");
    subjects.into_iter().chain(without).collect()
}
