//! The cone and how it is matched to Mohr–Coulomb.

use super::return_map::Invariants;
use super::{DruckerPrager, Matching, Softening};

/// The cone at some plastic strain: `√J2 + α I1 - k`, potential slope `α_ψ`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cone {
    /// Friction coefficient `α`.
    pub friction: f64,
    /// Strength at zero mean stress `k` (Pa).
    pub strength: f64,
    /// Dilatancy coefficient `α_ψ`.
    pub dilatancy: f64,
}

impl Cone {
    /// The cone of the given matching, angles in radians, cohesion in Pa.
    pub fn new(matching: Matching, friction_angle: f64, cohesion: f64, dilatancy_angle: f64) -> Self {
        let (sin, cos) = friction_angle.sin_cos();
        let root3 = 3f64.sqrt();
        // Slope of the edges for the two triaxial matchings; `sign` is -1 in compression.
        let triaxial = |angle: f64, sign: f64| 2.0 * angle.sin() / (root3 * (3.0 + sign * angle.sin()));
        let inscribed = |angle: f64| angle.tan() / (9.0 + 12.0 * angle.tan().powi(2)).sqrt();
        match matching {
            Matching::Compression | Matching::Extension => {
                let sign = if matching == Matching::Compression { -1.0 } else { 1.0 };
                Self {
                    friction: triaxial(friction_angle, sign),
                    strength: 6.0 * cohesion * cos / (root3 * (3.0 + sign * sin)),
                    dilatancy: triaxial(dilatancy_angle, sign),
                }
            }
            Matching::PlaneStrainAssociated => Self {
                friction: inscribed(friction_angle),
                strength: 3.0 * cohesion / (9.0 + 12.0 * friction_angle.tan().powi(2)).sqrt(),
                dilatancy: inscribed(dilatancy_angle),
            },
            Matching::PlaneStrain => {
                let dilatancy = inscribed(dilatancy_angle);
                let n = (1.0 - 3.0 * dilatancy * dilatancy).sqrt() + dilatancy * sin;
                Self { friction: sin / (3.0 * n), strength: cohesion * cos / n, dilatancy }
            }
        }
    }

    /// Round-off of an earlier return, which is not flow (Pa).
    #[inline]
    pub(super) fn fuzz(&self, trial: &Invariants) -> f64 {
        8.0 * f64::EPSILON * (trial.root_j2 + self.friction * trial.i1.abs() + self.strength)
    }

    /// `√J2 + α I1 - k` (Pa).
    #[inline]
    pub fn yield_value(&self, root_j2: f64, i1: f64) -> f64 {
        root_j2 + self.friction * i1 - self.strength
    }
}

impl DruckerPrager {
    /// The cone at plastic strain `kappa`.
    #[inline]
    pub fn cone_at(&self, kappa: f64) -> Cone {
        if self.constant { self.peak } else { self.softened_cone(kappa) }
    }

    pub(super) fn softened_cone(&self, kappa: f64) -> Cone {
        let spec = &self.spec;
        let peak = (spec.friction_angle.to_radians(), spec.cohesion);
        let (friction, cohesion) = spec.softening.map_or(peak, |s| s.strength(peak, kappa));
        let dilatancy = spec.dilatancy_angle.to_radians() * (-spec.dilatancy_decay * kappa).exp();
        Cone::new(spec.matching, friction, cohesion, dilatancy)
    }

    /// Rate of change of the cone with plastic strain.
    pub(super) fn cone_rate(&self, kappa: f64) -> Cone {
        if self.constant {
            return Cone::default();
        }
        let step = Softening::difference_step(self.spec.softening, self.spec.dilatancy_decay);
        let (plus, minus) = (self.softened_cone(kappa + step), self.softened_cone(kappa - step));
        let rate = |plus: f64, minus: f64| (plus - minus) / (2.0 * step);
        Cone {
            friction: rate(plus.friction, minus.friction),
            strength: rate(plus.strength, minus.strength),
            dilatancy: rate(plus.dilatancy, minus.dilatancy),
        }
    }
}
