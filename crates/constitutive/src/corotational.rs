//! The co-rotational adapter: an objective stress update from a small-strain law.

use crate::{InitialCondition, Mat3, MaterialError, Motion, Point, SmallStrain, StressUpdate, Tangent};

/// Makes a [`SmallStrain`] law objective (constitutive sheet §3.2): stress is carried by half the
/// Hughes–Winget rotation of the step, updated with the strain increment in that frame, and carried
/// by the other half. Second-order accurate, exact for a rigid step, and keeps the yield condition
/// of isotropic laws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corotational<L>(pub L);

/// Half of the Hughes–Winget rotation `Q = (1 - W/2)⁻¹(1 + W/2)` of the spin increment `W = dt W`:
/// `Q_h² = Q` to machine precision. `None` where there is no spin.
#[inline]
pub fn half_rotation(gradient: &Mat3) -> Option<Mat3> {
    let g = &gradient.0;
    // Axial vector of the skew part.
    let w = [0.5 * (g[2][1] - g[1][2]), 0.5 * (g[0][2] - g[2][0]), 0.5 * (g[1][0] - g[0][1])];
    let square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    if square == 0.0 {
        return None;
    }
    // tan of a quarter of the rotation angle, per unit of the axial vector.
    let t2 = 0.25 * square;
    let factor = 0.5 / (1.0 + (1.0 + t2).sqrt());
    let a = w.map(|c| factor * c);
    let a2 = factor * factor * square;
    // Cayley map of the axial vector a = tan(angle/2) axis: Q_h = 1 + 2/(1+a²) (X + X²).
    let c = 2.0 / (1.0 + a2);
    Some(Mat3([
        [1.0 - c * (a[1] * a[1] + a[2] * a[2]), c * (a[0] * a[1] - a[2]), c * (a[0] * a[2] + a[1])],
        [c * (a[0] * a[1] + a[2]), 1.0 - c * (a[0] * a[0] + a[2] * a[2]), c * (a[1] * a[2] - a[0])],
        [c * (a[0] * a[2] - a[1]), c * (a[1] * a[2] + a[0]), 1.0 - c * (a[0] * a[0] + a[1] * a[1])],
    ]))
}

impl<L: SmallStrain> Corotational<L> {
    #[inline]
    fn finite(&self, point: Point<L::State>) -> Result<Point<L::State>, MaterialError> {
        // NaN and infinity make the sum NaN.
        if point.stress.0.iter().sum::<f64>() * 0.0 == 0.0 {
            Ok(point)
        } else {
            Err(MaterialError::Motion { model: self.0.name(), reason: "the stress is not finite" })
        }
    }
}

impl<L: SmallStrain> StressUpdate for Corotational<L> {
    type State = L::State;

    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<L::State>, MaterialError> {
        self.0.initial(initial)
    }

    #[inline]
    fn update(&self, motion: &Motion, old: &Point<L::State>) -> Result<Point<L::State>, MaterialError> {
        let strain = motion.strain_increment();
        // One comparison for all components: NaN and infinity make the sum NaN.
        if !((motion.gradient.0.as_flattened().iter().sum::<f64>() * 0.0) == 0.0) {
            return Err(MaterialError::Motion { model: self.0.name(), reason: "the motion is not finite" });
        }
        if strain.dot(&strain) >= 1.0 {
            return Err(MaterialError::Motion {
                model: self.0.name(),
                reason: "a strain of more than 1 in one step",
            });
        }
        let Some(half) = half_rotation(&motion.gradient) else {
            return self.finite(self.0.update(&strain, motion, old)?);
        };
        let mut turned = Point { stress: old.stress.rotated(&half), state: old.state.clone() };
        self.0.rotate_state(&mut turned.state, &half);
        let mut new = self.0.update(&strain, motion, &turned)?;
        new.stress = new.stress.rotated(&half);
        self.0.rotate_state(&mut new.state, &half);
        self.finite(new)
    }

    fn wave_modulus(&self, point: &Point<L::State>) -> f64 {
        self.0.wave_modulus(point)
    }

    fn tangent(&self, motion: &Motion, old: &Point<L::State>) -> Result<Tangent, MaterialError> {
        if half_rotation(&motion.gradient).is_none()
            && let Some(tangent) = self.0.tangent(&motion.strain_increment(), motion, old)
        {
            return Ok(tangent);
        }
        crate::tangent::numerical_tangent(motion, |m| self.update(m, old).map(|p| p.stress))
    }

    fn yield_value(&self, point: &Point<L::State>) -> Option<f64> {
        self.0.yield_value(point)
    }

    fn stored_energy(&self, point: &Point<L::State>) -> Option<f64> {
        self.0.stored_energy(point)
    }

    fn viscosity(&self, point: &Point<L::State>) -> f64 {
        self.0.viscosity(point)
    }

    fn dissipation(&self, motion: &Motion, old: &Point<L::State>, new: &Point<L::State>) -> Option<f64> {
        let strain = motion.strain_increment();
        let Some(half) = half_rotation(&motion.gradient) else {
            return self.0.dissipation(&strain, motion, old, new);
        };
        let turned = |point: &Point<L::State>, by: &Mat3| {
            let mut turned = Point { stress: point.stress.rotated(by), state: point.state.clone() };
            self.0.rotate_state(&mut turned.state, by);
            turned
        };
        self.0.dissipation(&strain, motion, &turned(old, &half), &turned(new, &half.transpose()))
    }

    fn output_names(&self) -> &'static [&'static str] {
        self.0.output_names()
    }

    fn outputs(&self, point: &Point<L::State>, out: &mut [f64]) {
        self.0.outputs(point, out);
    }
}

/// The one-term spin update of Algorithms 1 and 2 of Bui & Nguyen 2021, with the sign mended (sheet
/// §3.2): `σ + ΔW σ - σ ΔW`, then the small-strain law. For comparison only: a full turn in steps of ten
/// degrees ends at twice the stress, and the yield condition is not kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstOrderSpin<L>(pub L);

impl<L: SmallStrain> StressUpdate for FirstOrderSpin<L> {
    type State = L::State;

    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<L::State>, MaterialError> {
        self.0.initial(initial)
    }

    fn update(&self, motion: &Motion, old: &Point<L::State>) -> Result<Point<L::State>, MaterialError> {
        let (spin, stress) = (motion.gradient.skew(), old.stress.to_matrix());
        // W σ - σ W is symmetric, and twice the symmetric part of W σ.
        let turned = Point { stress: old.stress + (spin * stress).sym() * 2.0, state: old.state.clone() };
        self.0.update(&motion.strain_increment(), motion, &turned)
    }

    fn wave_modulus(&self, point: &Point<L::State>) -> f64 {
        self.0.wave_modulus(point)
    }
}
