//! Drucker–Prager cone and its matching to Mohr–Coulomb.

use super::return_map::StressInvariantValues;
use super::{DruckerPrager, Matching, Softening};

/// Drucker–Prager cone `√J2 + α I1 - k` with the slope `α_ψ` of its potential, at a given plastic strain.
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
    /// Returns the cone that matches a Mohr–Coulomb strength; angles in radians, cohesion in Pa.
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

    /// Rates of the parameters of [`Cone::new`] for given rates of friction angle, cohesion and dilatancy angle. Differences are not used
    /// because their round-off would remain in the stress of the forward algorithms.
    pub(super) fn rate(
        matching: Matching,
        (friction_angle, cohesion, dilatancy_angle): (f64, f64, f64),
        (friction_rate, cohesion_rate, dilatancy_rate): (f64, f64, f64),
    ) -> Self {
        let (sin, cos) = friction_angle.sin_cos();
        let root3 = 3f64.sqrt();
        let inscribed = |angle: f64| {
            let tan = angle.tan();
            let square = 1.0 + tan * tan;
            let below = 9.0 + 12.0 * tan * tan;
            9.0 * square / (below * below.sqrt())
        };
        match matching {
            Matching::Compression | Matching::Extension => {
                let sign = if matching == Matching::Compression { -1.0 } else { 1.0 };
                let slope = |angle: f64| 6.0 * angle.cos() / (root3 * (3.0 + sign * angle.sin()).powi(2));
                let below = 3.0 + sign * sin;
                let turning = (3.0 * sin + sign) * friction_rate / below;
                Self {
                    friction: slope(friction_angle) * friction_rate,
                    strength: 6.0 * (cohesion_rate * cos - cohesion * turning) / (root3 * below),
                    dilatancy: slope(dilatancy_angle) * dilatancy_rate,
                }
            }
            Matching::PlaneStrainAssociated => {
                let tan = friction_angle.tan();
                let square = 1.0 + tan * tan;
                let below = 9.0 + 12.0 * tan * tan;
                let turning = 12.0 * tan * square * friction_rate / below;
                Self {
                    friction: inscribed(friction_angle) * friction_rate,
                    strength: 3.0 * (cohesion_rate - cohesion * turning) / below.sqrt(),
                    dilatancy: inscribed(dilatancy_angle) * dilatancy_rate,
                }
            }
            Matching::PlaneStrain => {
                let tan = dilatancy_angle.tan();
                let a = tan / (9.0 + 12.0 * tan * tan).sqrt();
                let dilatancy = inscribed(dilatancy_angle) * dilatancy_rate;
                let root = (1.0 - 3.0 * a * a).sqrt();
                let n = root + a * sin;
                let turning = ((sin - 3.0 * a / root) * dilatancy + a * cos * friction_rate) / n;
                let strength = cohesion_rate * cos - cohesion * (sin * friction_rate + cos * turning);
                Self {
                    friction: (cos * friction_rate - sin * turning) / (3.0 * n),
                    strength: strength / n,
                    dilatancy,
                }
            }
        }
    }

    /// Tolerance of the yield function (Pa), below which a stress returned earlier does not yield again by round-off.
    #[inline]
    pub(super) fn yield_tolerance(&self, trial: &StressInvariantValues) -> f64 {
        8.0 * f64::EPSILON * (trial.root_j2 + self.friction * trial.i1.abs() + self.strength)
    }

    /// Yield function `√J2 + α I1 - k` (Pa).
    #[inline]
    pub fn yield_value(&self, root_j2: f64, i1: f64) -> f64 {
        root_j2 + self.friction * i1 - self.strength
    }
}

impl DruckerPrager {
    /// Cone at plastic strain `kappa`.
    #[inline]
    pub fn cone_at(&self, kappa: f64) -> Cone {
        if self.has_constant_cone {
            return self.peak;
        }
        match self.spec.softening {
            // The strength is proportional to the cohesion.
            Some(softening) if self.only_cohesion_softens(&softening) => {
                let cohesion = self.spec.cohesion;
                let strength = self.peak.strength * (softening.cohesion(cohesion, kappa) / cohesion);
                Cone { strength, ..self.peak }
            }
            _ => self.softened_cone(kappa),
        }
    }

    /// Whether angles of friction and dilatancy keep their peaks.
    #[inline]
    fn only_cohesion_softens(&self, softening: &Softening) -> bool {
        softening.keeps_friction(self.spec.friction_angle.to_radians())
            && self.spec.dilatancy_decay == 0.0
            && self.spec.cohesion > 0.0
    }

    /// Cone at equivalent plastic strain `κ`, with softened friction and cohesion and decayed dilatancy.
    pub(super) fn softened_cone(&self, kappa: f64) -> Cone {
        let spec = &self.spec;
        let peak = (spec.friction_angle.to_radians(), spec.cohesion);
        let (friction, cohesion) = spec.softening.map_or(peak, |s| s.strength(peak, kappa));
        let dilatancy = spec.dilatancy_angle.to_radians() * (-spec.dilatancy_decay * kappa).exp();
        Cone::new(spec.matching, friction, cohesion, dilatancy)
    }

    /// Rate of change of the cone with plastic strain.
    pub(super) fn cone_rate(&self, kappa: f64) -> Cone {
        if self.has_constant_cone {
            return Cone::default();
        }
        let spec = &self.spec;
        let peak = (spec.friction_angle.to_radians(), spec.cohesion);
        let (friction, cohesion) = spec.softening.map_or(peak, |s| s.strength(peak, kappa));
        let (friction_rate, cohesion_rate) = spec.softening.map_or((0.0, 0.0), |s| s.rate(peak, kappa));
        let dilatancy = spec.dilatancy_angle.to_radians() * (-spec.dilatancy_decay * kappa).exp();
        let rates = (friction_rate, cohesion_rate, -spec.dilatancy_decay * dilatancy);
        Cone::rate(spec.matching, (friction, cohesion, dilatancy), rates)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_the_slope_of_the_cone() {
        let (at, rates) = ((0.5, 12e3, 0.2), (-0.7, -9e4, -0.3));
        for matching in [
            Matching::Compression,
            Matching::Extension,
            Matching::PlaneStrainAssociated,
            Matching::PlaneStrain,
        ] {
            let cone =
                |x: f64| Cone::new(matching, at.0 + rates.0 * x, at.1 + rates.1 * x, at.2 + rates.2 * x);
            let rate = Cone::rate(matching, at, rates);
            let near = |found: f64, of: fn(&Cone) -> f64| {
                let exact = (of(&cone(1e-5)) - of(&cone(-1e-5))) / 2e-5;
                assert!((found - exact).abs() < 1e-8 * exact.abs(), "{matching:?}: {found} for {exact}");
            };
            near(rate.friction, |c| c.friction);
            near(rate.strength, |c| c.strength);
            near(rate.dilatancy, |c| c.dilatancy);
        }
    }
}
