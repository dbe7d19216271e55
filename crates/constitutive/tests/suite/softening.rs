//! Softening so steep that the strength falls nearly as fast as the stress unloads, or faster (sheet: constitutive §2.4,
//! §2.5).

use colluvium_constitutive::driver::{ElementPath, ElementTest, LoadingPath, TestStage};
use colluvium_constitutive::laws::{
    DruckerPragerSpec, Elasticity, Matching, MohrCoulombSpec, PlasticIntegration, PlasticStrain, Softening,
    StrainMeasure,
};
use colluvium_constitutive::{Mat3, MaterialSpec, Motion, Point, SmallStrain, SymTensor};

/// Clay without friction: cohesion of 25 kPa, residual 1 kPa, unless given otherwise.
#[derive(Clone, Copy)]
struct Clay {
    peak: f64,
    residual: f64,
    rate: f64,
}

impl Clay {
    fn steep(rate: f64) -> Self {
        Self { peak: 25e3, residual: 1e3, rate }
    }

    fn elasticity() -> Elasticity {
        Elasticity::new(1e6, 0.3).unwrap()
    }

    fn softening(self) -> Softening {
        Softening::of_cohesion(self.residual, self.rate)
    }

    fn cohesion(self, kappa: f64) -> f64 {
        self.residual + (self.peak - self.residual) * (-self.rate * kappa).exp()
    }

    fn mohr_coulomb(self) -> MaterialSpec {
        MaterialSpec::MohrCoulomb(MohrCoulombSpec {
            density: 2000.0,
            youngs_modulus: 1e6,
            poissons_ratio: 0.3,
            friction_angle: 0.0,
            cohesion: self.peak,
            dilatancy_angle: 0.0,
            softening: Some(self.softening()),
            dilatancy_decay: 0.0,
            tensile_strength: None,
            strain_measure: StrainMeasure::Rate,
            return_initial_stress_to_yield: false,
        })
    }

    fn drucker_prager(self, integration: PlasticIntegration) -> DruckerPragerSpec {
        DruckerPragerSpec {
            density: 2000.0,
            youngs_modulus: 1e6,
            poissons_ratio: 0.3,
            friction_angle: 0.0,
            cohesion: self.peak,
            dilatancy_angle: 0.0,
            matching: Matching::Compression,
            softening: Some(self.softening()),
            dilatancy_decay: 0.0,
            integration,
            strain_measure: StrainMeasure::Rate,
            return_initial_stress_to_yield: false,
        }
    }
}

fn run(material: MaterialSpec, path: LoadingPath, steps: usize) -> ElementPath {
    let stages = vec![TestStage { path, steps, duration: 1.0 }];
    let test = ElementTest { title: String::new(), material, initial_stress: [0.0; 6], stages };
    test.run().unwrap_or_else(|error| panic!("{error}"))
}

/// Path of pure shear: stretch in x, equal compression in y, by `strain` in all.
fn pure_shear(material: MaterialSpec, strain: f64, steps: usize) -> ElementPath {
    run(material, LoadingPath::Strain { increment: [strain, -strain, 0.0, 0.0, 0.0, 0.0] }, steps)
}

#[test]
fn mohr_coulomb_softening_follows_steep_softening_laws_exactly() {
    // σ1 - σ3 = 2c(κ) and κ = 2/√3 of the plastic stretch: ε = c(κ)/2G + √3 κ/2. The fixed-point map of the increment has
    // the slope rate·(c_p - c_r)/(√3 G): 0.97 to 1.15 with the first clay, 0.96 with the second.
    let shear = Clay::elasticity().shear_modulus;
    let slow = [27.0, 28.0, 29.0, 30.0, 31.0, 32.0].map(Clay::steep);
    let stiff = Clay { peak: 20e3, residual: 4e3, rate: 40.0 };
    for clay in slow.into_iter().chain([stiff]) {
        for (strain, steps) in [(0.05, 5000), (0.05, 50), (0.5, 51)] {
            let path = pure_shear(clay.mohr_coulomb(), strain, steps);
            let (stretch, kappa) =
                (path.column("strain_xx").unwrap(), path.column("plastic_strain").unwrap());
            let (q_x, q_y) = (path.column("stress_xx").unwrap(), path.column("stress_yy").unwrap());
            assert!(*kappa.last().unwrap() > 0.02, "the clay yields");
            for row in 1..stretch.len() {
                assert!(kappa[row] >= kappa[row - 1]);
                if kappa[row] == 0.0 {
                    continue;
                }
                let strength = clay.cohesion(kappa[row]);
                assert!((0.5 * (q_x[row] - q_y[row]) / strength - 1.0).abs() < 1e-9);
                let exact = strength / (2.0 * shear) + 0.5 * 3f64.sqrt() * kappa[row];
                assert!(
                    (stretch[row] - exact).abs() < 1e-11,
                    "{} {row}: {} {exact}",
                    clay.rate,
                    stretch[row]
                );
            }
        }
    }
}

#[test]
fn softening_drucker_prager_does_not_exceed_its_peak_with_any_integration() {
    let peak = 2.0 * 25e3;
    let shear = |rate: f64, integration| {
        let law = Clay::steep(rate).drucker_prager(integration);
        run(MaterialSpec::DruckerPrager(law), LoadingPath::SimpleShearConstantVolume { shear: 0.3 }, 300)
    };
    // From nearly no softening to a strength that falls three times as fast as the stress unloads.
    for rate in [0.1, 5.0, 11.0, 14.0, 20.0, 23.5, 24.5, 30.0, 72.0] {
        let returned = shear(rate, PlasticIntegration::ClosestPoint);
        for integration in [PlasticIntegration::SemiImplicit, PlasticIntegration::Explicit] {
            let path = shear(rate, integration);
            let said = format!("{integration:?}, {rate}");
            let column = |name: &str| path.column(name).unwrap();
            assert!(column("q").iter().all(|q| *q <= peak * (1.0 + 1e-9)), "{said}");
            assert!(column("plastic_strain").is_sorted(), "{said}: plastic strain falls");
            assert!(column("dissipated_work").is_sorted_by(|a, b| *b >= a - 1e-5), "{said}: work is gained");
            let q = column("q");
            let top = q.iter().copied().fold(0.0, f64::max);
            let (found, exact) = (path.last("q"), returned.last("q"));
            assert!((found - exact).abs() < 0.02 * exact, "{said}: {found} for {exact}");
            let first = q.iter().position(|q| *q == top).unwrap();
            assert!(q[first..].is_sorted_by(|a, b| *b <= a + 1e-3 * peak), "{said}: strength comes back");
        }
    }
}

#[test]
fn no_step_of_drucker_prager_gains_work() {
    // Associated flow of a stiff sand that loses its cohesion within a step: too large a multiplier would dilate against
    // the pressure by more than the remaining shear stress.
    let still = Motion::from_deformation(&Mat3::IDENTITY, 1.0, 2000.0, 1.0).unwrap();
    for rate in [100.0, 200.0, 400.0, 600.0, 800.0, 1000.0, 3000.0] {
        for integration in
            [PlasticIntegration::ClosestPoint, PlasticIntegration::SemiImplicit, PlasticIntegration::Explicit]
        {
            let clay = Clay { peak: 10e3, residual: 0.0, rate };
            let law = DruckerPragerSpec {
                youngs_modulus: 20e6,
                friction_angle: 20.0,
                dilatancy_angle: 20.0,
                softening: Some(Softening { residual_friction_angle: 20.0, ..clay.softening() }),
                ..clay.drucker_prager(integration)
            };
            let law = law.law().unwrap();
            for steps in [2, 4, 8, 20] {
                let strain = SymTensor([0.02, -0.02, 0.0, 0.0, 0.0, 0.0]) * (1.0 / f64::from(steps));
                let mut old = Point { stress: SymTensor::isotropic(-20e3), state: PlasticStrain::default() };
                for _ in 0..steps {
                    let new = law.update(&strain, &still, &old).unwrap();
                    let lost = law.dissipation(&strain, &still, &old, &new).unwrap();
                    let said = format!("{integration:?}, {rate}, {steps}: {lost} J/m³");
                    assert!(lost >= -1e-9 && new.state.deviatoric >= old.state.deviatoric, "{said}");
                    old = new;
                }
            }
        }
    }
}
