//! Yield surface of Cohesive Cam Clay: an ellipse in pressure and deviatoric stress, and the return to it.

use crate::laws::Elasticity;

/// Yield ellipse at a given compressive strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YieldEllipse {
    /// Slope `M` of the critical state line.
    pub slope: f64,
    /// Cohesion ratio `β`.
    pub cohesion_ratio: f64,
    /// Isotropic compressive strength `p0` (Pa).
    pub strength: f64,
}

/// Result of a projection onto an [`YieldEllipse`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EllipseReturn {
    /// Mean pressure (Pa).
    pub pressure: f64,
    /// Deviatoric stress `q` (Pa).
    pub q: f64,
    /// Plastic multiplier `Δγ` of `y` (1/Pa); infinite where the surface is a point.
    pub multiplier: f64,
    /// Plastic volumetric strain of the step, expansion positive.
    pub volumetric: f64,
}

impl YieldEllipse {
    /// Mean pressure at the centre of the ellipse, `½ (1 - β) p0` (Pa).
    fn centre(&self) -> f64 {
        0.5 * (1.0 - self.cohesion_ratio) * self.strength
    }

    /// Half axis along `p` times `M`.
    pub(super) fn radius(&self) -> f64 {
        0.5 * self.slope * (1.0 + self.cohesion_ratio) * self.strength
    }

    /// Factor `1 + 2β` of `q²` in the yield function.
    fn flattening(&self) -> f64 {
        1.0 + 2.0 * self.cohesion_ratio
    }

    /// Yield value `√((1 + 2β) q² + M² (p - p_c)²) - M a` (Pa) with centre `p_c` and half axis `a`. It has the sign of the yield function
    /// `y`, which is its product with the sum of the two terms.
    #[inline]
    pub fn yield_value(&self, pressure: f64, q: f64) -> f64 {
        (self.flattening().sqrt() * q).hypot(self.slope * (pressure - self.centre())) - self.radius()
    }

    /// Decay of `M (p - p_c)` and of `√(1 + 2β) q` with the multiplier.
    pub(super) fn rates(&self, elasticity: &Elasticity) -> (f64, f64) {
        (
            2.0 * elasticity.bulk_modulus * self.slope * self.slope,
            6.0 * elasticity.shear_modulus * self.flattening(),
        )
    }

    /// Associated return of a trial stress to an ellipse of fixed size (sheet: constitutive §3.7.6). A trial inside the ellipse is
    /// unchanged.
    pub fn return_map(&self, elasticity: &Elasticity, pressure: f64, q: f64) -> EllipseReturn {
        // Also where the strength is infinite.
        if !(self.yield_value(pressure, q) > 0.0) {
            return EllipseReturn { pressure, q, multiplier: 0.0, volumetric: 0.0 };
        }
        let radius = self.radius();
        if radius == 0.0 {
            let volumetric = -pressure / elasticity.bulk_modulus;
            return EllipseReturn { pressure: 0.0, q: 0.0, multiplier: f64::INFINITY, volumetric };
        }
        let (a, b) = self.rates(elasticity);
        let (x, y) = (self.slope * (pressure - self.centre()), self.flattening().sqrt() * q);
        // From below the root of 1/‖v(γ)‖ = 1/radius, which is nearly linear and concave in γ.
        let mut gamma = ((x.abs() / radius - 1.0) / a)
            .max((y / radius - 1.0) / b)
            .max((x.hypot(y) / radius - 1.0) / a.max(b))
            .max(0.0);
        for _ in 0..50 {
            let (u, v) = (1.0 + a * gamma, 1.0 + b * gamma);
            let (x, y) = (x / u, y / v);
            let norm = x.hypot(y);
            let step = (norm - radius) * norm * norm / (radius * (a * x * x / u + b * y * y / v));
            gamma += step;
            // From below it only rises, but for round-off. Written so that NaN ends it.
            if !(step > 2.0 * f64::EPSILON * gamma) {
                break;
            }
        }
        let u = 1.0 + a * gamma;
        let change = -(pressure - self.centre()) * (a * gamma / u);
        EllipseReturn {
            pressure: self.centre() + x / (self.slope * u),
            q: q / (1.0 + b * gamma),
            multiplier: gamma,
            volumetric: change / elasticity.bulk_modulus,
        }
    }
}

/// Return to the yield surface at the end of the step.
pub(super) struct HardeningReturn {
    /// Yield ellipse at the end of the step.
    pub(super) ellipse: YieldEllipse,
    /// Slope `dp0/dx` with the plastic volumetric strain `x` of the step (Pa).
    pub(super) hardening: f64,
    /// Trial pressure and deviatoric stress (Pa).
    pub(super) trial: (f64, f64),
    /// Projection of the trial onto the ellipse, with its plastic multiplier.
    pub(super) projection: EllipseReturn,
}

/// Derivatives of the flow condition and the yield condition of a return with respect to the plastic volumetric strain `x`, the multiplier
/// `γ`, and `p` and `q` of the trial.
pub(super) struct ReturnConditions {
    /// Derivatives of the flow condition with respect to `x`, `γ`, the trial's `p` and the trial's `q`.
    pub(super) flow: [f64; 4],
    /// Derivatives of the yield condition with respect to `x`, `γ`, the trial's `p` and the trial's `q`.
    pub(super) yielding: [f64; 4],
}

impl HardeningReturn {
    /// Derivatives of the two return conditions at the solution, from which the consistent tangent follows.
    pub(super) fn conditions(&self, elasticity: &Elasticity) -> ReturnConditions {
        let (slope, k) = (self.ellipse.slope, elasticity.bulk_modulus);
        let beta = self.ellipse.cohesion_ratio;
        let (a, b) = self.ellipse.rates(elasticity);
        let gamma = self.projection.multiplier;
        let (u, v) = (1.0 + a * gamma, 1.0 + b * gamma);
        let taken = a * gamma / u;
        let (distance, root) = (self.trial.0 - self.ellipse.centre(), self.ellipse.flattening().sqrt());
        let (x, y) = (slope * distance / u, root * self.trial.1 / v);
        let centre = 0.5 * (1.0 - beta) * self.hardening;
        let radius = 0.5 * slope * (1.0 + beta) * self.hardening;
        ReturnConditions {
            flow: [1.0 - centre * taken / k, distance * a / (k * u * u), taken / k, 0.0],
            yielding: [
                -x * slope * centre / u - self.ellipse.radius() * radius,
                -a * x * x / u - b * y * y / v,
                x * slope / u,
                y * root / v,
            ],
        }
    }

    /// Derivatives `∂(p, q)/∂(p, q)` by the trial, from the implicit-function theorem.
    pub(super) fn slopes(&self, elasticity: &Elasticity) -> [[f64; 2]; 2] {
        let ReturnConditions { flow, yielding } = self.conditions(elasticity);
        let (_, b) = self.ellipse.rates(elasticity);
        let v = 1.0 + b * self.projection.multiplier;
        let determinant = flow[0] * yielding[1] - flow[1] * yielding[0];
        let columns: [(f64, f64); 2] = [2, 3].map(|c| {
            let strain = -(flow[c] * yielding[1] - flow[1] * yielding[c]) / determinant;
            let multiplier = -(flow[0] * yielding[c] - yielding[0] * flow[c]) / determinant;
            (elasticity.bulk_modulus * strain, -self.projection.q * b / v * multiplier)
        });
        [[1.0 + columns[0].0, columns[1].0], [columns[0].1, 1.0 / v + columns[1].1]]
    }
}
