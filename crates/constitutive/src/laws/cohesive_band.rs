//! Mixed-mode cohesive–frictional band of zero thickness (sheet: constitutive §2.16, eqs. 2.22–2.23, in the
//! family of Wang et al. 2019, 2020).
//!
//! `t_n = K_n (u_n - u_n^p)` (tension-positive), `t_s = K_s (u_s - u_s^p)`; with `z = 1 - D`
//! `y = t_s² - (z c - μ t_n)² + z² b² ≤ 0`, `b = c - μ f_t`, `z c - μ t_n ≥ 0`: a hyperbola in the
//! plane of tractions that shrinks with damage to the wedge of Coulomb friction. Flow
//! `du^p = dλ (2 μ_ψ (z c - μ t_n), 2 t_s)`; `z = e^(-χ)`, `dχ = du_n^p/δ_I + |du_s^p|/δ_II` with
//! `δ_I = G_I/f_t`, `δ_II = G_II/t_s0`, `t_s0 = √(c² - b²)`. The areas under pure opening and pure
//! sliding without normal traction are exactly `G_I` and `G_II`.
//!
//! The return is implicit: on the hyperbola of given χ the point that flows back to the trial is unique;
//! χ follows from an outer scalar equation. Limits: dilation does not fade with slip; the stiffness
//! of contact `K_n` is kept in compression whatever the damage.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::contract::parameter_checks::{check, not_negative, positive};
use crate::laws::model::with_defaults;
use crate::return_maps::scalar_roots::falling_root;
use crate::{InterfaceLaw, InterfacePoint, MaterialError};

/// Value of the key `model` in case files.
const NAME: &str = "cohesive-friction";

/// Largest softening variable; above it the cohesion, which is proportional to its negative exponential, is negligible.
const LARGEST_SOFTENING: f64 = 300.0;

/// Parameters of the cohesive–frictional band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CohesiveBandSpec {
    /// Cohesion `c` (Pa), more than `μ f_t`.
    pub cohesion: f64,
    /// Tensile strength `f_t` (Pa), positive.
    pub tensile_strength: f64,
    /// Friction coefficient `μ`, positive.
    pub friction_coefficient: f64,
    /// Dilation coefficient `μ_ψ`, 0 to `μ`.
    #[serde(default)]
    pub dilatancy_coefficient: f64,
    /// Opening fracture energy `G_I` (J/m²), positive.
    pub opening_energy: f64,
    /// Sliding fracture energy `G_II` (J/m²), positive.
    pub sliding_energy: f64,
    /// Normal stiffness `K_n` (Pa/m), above the softening `f_t²/G_I`.
    pub normal_stiffness: f64,
    /// Shear stiffness `K_s` (Pa/m), above the softening `c t_s0/G_II`.
    pub shear_stiffness: f64,
}

/// Law of the cohesive–frictional band. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CohesiveBand {
    spec: CohesiveBandSpec,
    /// Offset `b = c - μ f_t` (Pa).
    offset: f64,
    /// Softening lengths `δ_I`, `δ_II` (m).
    lengths: [f64; 2],
}

/// Internal variables of the band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CohesiveState {
    /// Softening variable `χ`: damage is `1 - e^(-χ)`.
    pub softening: f64,
    /// Plastic part of the displacement jump (m): normal and two tangential components.
    pub plastic_jump: [f64; 3],
}

/// Elastic trial: normal traction, size of the shear traction, and their decrease with plastic opening
/// and slip (Pa/m).
#[derive(Clone, Copy)]
struct TractionTrial {
    normal: f64,
    shear: f64,
    stiffness: [f64; 2],
}

/// Point of the hyperbola of softening `χ` at shear traction `s`, relative to the trial.
struct HyperbolaPoint {
    normal: f64,
    /// Term `A = z c - μ t_n = √(s² + z² b²)` and its derivatives by `s` and `χ`.
    a: [f64; 3],
    /// Plastic opening and its derivatives by `s` and `χ`.
    opening: [f64; 3],
    /// Plastic slip; its derivative by `s` is `-1/K_s`.
    plastic_slip: f64,
}

/// Result of the return of a trial, with the derivatives for the stiffness.
struct BandReturn {
    normal: f64,
    shear: f64,
    softening: f64,
    opening: f64,
    plastic_slip: f64,
    a: f64,
    /// Derivatives of the residuals (flow, softening) by `(s, χ)`.
    jacobian: [[f64; 2]; 2],
}

impl CohesiveBandSpec {
    /// Parameters from cohesion (Pa), tensile strength (Pa), friction coefficient (-), opening energy (J/m²), sliding energy (J/m²),
    /// normal stiffness (Pa/m) and shear stiffness (Pa/m); all others have the defaults of a case file.
    #[must_use]
    pub fn new(
        cohesion: f64,
        tensile_strength: f64,
        friction_coefficient: f64,
        opening_energy: f64,
        sliding_energy: f64,
        normal_stiffness: f64,
        shear_stiffness: f64,
    ) -> Self {
        with_defaults(&[
            ("cohesion", cohesion),
            ("tensile_strength", tensile_strength),
            ("friction_coefficient", friction_coefficient),
            ("opening_energy", opening_energy),
            ("sliding_energy", sliding_energy),
            ("normal_stiffness", normal_stiffness),
            ("shear_stiffness", shear_stiffness),
        ])
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<CohesiveBand, MaterialError> {
        let Self { cohesion, tensile_strength, friction_coefficient: mu, .. } = *self;
        positive("band.tensile_strength", tensile_strength, "Pa")?;
        positive("band.friction_coefficient", mu, "")?;
        positive("band.cohesion", cohesion, "Pa")?;
        let smallest = mu * tensile_strength;
        let rule = format!("must be more than friction coefficient times tensile strength, {smallest} Pa");
        check("band.cohesion", cohesion, cohesion > smallest, &rule)?;
        not_negative("band.dilatancy_coefficient", self.dilatancy_coefficient, "")?;
        let rule = format!("is more than the friction coefficient, {mu}");
        let dilatancy = self.dilatancy_coefficient;
        check("band.dilatancy_coefficient", dilatancy, dilatancy <= mu, &rule)?;
        positive("band.opening_energy", self.opening_energy, "J/m²")?;
        positive("band.sliding_energy", self.sliding_energy, "J/m²")?;
        positive("band.normal_stiffness", self.normal_stiffness, "Pa/m")?;
        positive("band.shear_stiffness", self.shear_stiffness, "Pa/m")?;
        let offset = cohesion - smallest;
        let shear_strength = (cohesion * cohesion - offset * offset).sqrt();
        let rule = "must have a finite square";
        check("band.cohesion", cohesion, shear_strength.is_finite(), rule)?;
        let lengths = [self.opening_energy / tensile_strength, self.sliding_energy / shear_strength];
        for (name, stiffness, softening) in [
            ("band.normal_stiffness", self.normal_stiffness, tensile_strength / lengths[0]),
            ("band.shear_stiffness", self.shear_stiffness, cohesion / lengths[1]),
        ] {
            let rule = format!("must be more than the slope of softening, {softening} Pa/m");
            check(name, stiffness, stiffness > softening, &rule)?;
        }
        Ok(CohesiveBand { spec: *self, offset, lengths })
    }
}

impl CohesiveBand {
    /// Shear strength (Pa) at normal traction `normal` (Pa, tension-positive) and softening `χ`; zero
    /// beyond the tensile strength.
    pub fn shear_strength(&self, normal: f64, softening: f64) -> f64 {
        let z = (-softening).exp();
        let a = z * self.spec.cohesion - self.spec.friction_coefficient * normal;
        (a - z * self.offset).max(0.0).sqrt() * (a + z * self.offset).max(0.0).sqrt()
    }

    /// Yield function as a stress (Pa): `√(t_s² + z² b²) - (z c - μ t_n)`.
    #[inline]
    fn yield_excess(&self, normal: f64, shear: f64, softening: f64) -> f64 {
        let z = (-softening).exp();
        shear.hypot(z * self.offset) - (z * self.spec.cohesion - self.spec.friction_coefficient * normal)
    }

    /// Point of the hyperbolic yield surface at a shear traction (Pa) and softening variable, with its derivatives.
    fn on_surface(&self, trial: &TractionTrial, shear: f64, softening: f64) -> HyperbolaPoint {
        let CohesiveBandSpec { cohesion, friction_coefficient: mu, .. } = self.spec;
        let [normal_stiffness, shear_stiffness] = trial.stiffness;
        let z = (-softening).exp();
        let a = shear.hypot(z * self.offset);
        let (by_shear, by_softening) = (shear / a, -z * self.offset * (z * self.offset / a));
        let normal = (z * cohesion - a) / mu;
        let stiff = mu * normal_stiffness;
        HyperbolaPoint {
            normal,
            a: [a, by_shear, by_softening],
            opening: [
                (trial.normal - normal) / normal_stiffness,
                by_shear / stiff,
                (z * cohesion + by_softening) / stiff,
            ],
            plastic_slip: (trial.shear - shear) / shear_stiffness,
        }
    }

    /// Residual of the direction of flow, `d_n s - μ_ψ A d_s`, and its derivatives by `s` and `χ`.
    fn flow(&self, trial: &TractionTrial, on: &HyperbolaPoint, shear: f64) -> [f64; 3] {
        let psi = self.spec.dilatancy_coefficient;
        [
            on.opening[0] * shear - psi * on.a[0] * on.plastic_slip,
            on.opening[0] + shear * on.opening[1] - psi * on.a[1] * on.plastic_slip
                + psi * on.a[0] / trial.stiffness[1],
            shear * on.opening[2] - psi * on.a[2] * on.plastic_slip,
        ]
    }

    /// Shear traction (Pa) at the end of the return to the yield hyperbola at a given softening variable.
    fn shear_at_softening(&self, trial: &TractionTrial, softening: f64, start: f64) -> Option<f64> {
        if trial.shear == 0.0 {
            return Some(0.0);
        }
        if self.spec.dilatancy_coefficient == 0.0 {
            return Some(self.shear_strength(trial.normal, softening).min(trial.shear));
        }
        falling_root(0.0, trial.shear, start, |shear| {
            let [value, slope, _] = self.flow(trial, &self.on_surface(trial, shear, softening), shear);
            (-value, -slope)
        })
    }

    /// Residual of the softening, `χ - χ_old - d_n/δ_I - d_s/δ_II`, and derivatives of both residuals.
    fn residual(
        &self,
        trial: &TractionTrial,
        on: &HyperbolaPoint,
        shear: f64,
        softening: f64,
        old: f64,
    ) -> (f64, [[f64; 2]; 2]) {
        let [i, ii] = self.lengths;
        let value = softening - old - on.opening[0] / i - on.plastic_slip / ii;
        let [_, flow_shear, flow_softening] = self.flow(trial, on, shear);
        let by_shear = -on.opening[1] / i + 1.0 / (trial.stiffness[1] * ii);
        (value, [[flow_shear, flow_softening], [by_shear, 1.0 - on.opening[2] / i]])
    }

    /// Implicit return of a trial outside the surface.
    fn return_map(&self, trial: &TractionTrial, old: f64) -> Result<BandReturn, MaterialError> {
        let failed = MaterialError::NotConverged { model: NAME, reason: "return to the band's surface" };
        let mu = self.spec.friction_coefficient;
        // Normal traction on the surface is never below that of pure friction.
        let widest = (trial.normal + trial.shear / mu) / (trial.stiffness[0] * self.lengths[0])
            + trial.shear / (trial.stiffness[1] * self.lengths[1]);
        let end = (old + widest).min(LARGEST_SOFTENING.max(old));
        let mut shear = trial.shear;
        let softening = falling_root(old, end, old, |softening| {
            let Some(found) = self.shear_at_softening(trial, softening, shear) else {
                return (f64::NAN, 0.0);
            };
            shear = found;
            let on = self.on_surface(trial, shear, softening);
            let (value, j) = self.residual(trial, &on, shear, softening, old);
            let turn = if j[0][0] == 0.0 { 0.0 } else { j[0][1] / j[0][0] };
            (-value, -(j[1][1] - j[1][0] * turn))
        })
        .ok_or_else(|| failed.clone())?;
        let shear = self.shear_at_softening(trial, softening, shear).ok_or(failed)?;
        let on = self.on_surface(trial, shear, softening);
        let (_, mut jacobian) = self.residual(trial, &on, shear, softening, old);
        if softening >= LARGEST_SOFTENING {
            jacobian[1] = [0.0, 1.0];
        }
        let (opening, plastic_slip) = (on.opening[0].max(0.0), on.plastic_slip);
        Ok(BandReturn { normal: on.normal, shear, softening, opening, plastic_slip, a: on.a[0], jacobian })
    }

    /// Normal and tangential parts of a trial traction (Pa), and whether it is outside the yield surface.
    fn trial(&self, traction: [f64; 3], stiffness: [f64; 2], softening: f64) -> (TractionTrial, bool) {
        let [normal, s, t] = traction;
        let shear = s.hypot(t);
        let excess = self.yield_excess(normal, shear, softening);
        // Round-off of an earlier return does not count as flow.
        let scale =
            shear + self.spec.friction_coefficient * normal.abs() + self.spec.cohesion * (-softening).exp();
        (TractionTrial { normal, shear, stiffness }, !(excess <= 8.0 * f64::EPSILON * scale))
    }

    /// Elastic traction after a displacement jump (m): normal and two tangential components (Pa).
    fn elastic_traction(&self, jump: [f64; 3], old: [f64; 3]) -> [f64; 3] {
        let CohesiveBandSpec { normal_stiffness: kn, shear_stiffness: ks, .. } = self.spec;
        [old[0] + kn * jump[0], old[1] + ks * jump[1], old[2] + ks * jump[2]]
    }

    /// Traction and state after the return of a trial traction, for given normal and shear stiffnesses (Pa/m).
    fn state_after_return(
        &self,
        traction: [f64; 3],
        stiffness: [f64; 2],
        state: &CohesiveState,
    ) -> Result<InterfacePoint<CohesiveState>, MaterialError> {
        let (trial, outside) = self.trial(traction, stiffness, state.softening);
        if !outside {
            return Ok(InterfacePoint { traction, state: *state });
        }
        let end = self.return_map(&trial, state.softening)?;
        let share = if trial.shear > 0.0 { 1.0 / trial.shear } else { 0.0 };
        let direction = [traction[1] * share, traction[2] * share];
        let [n, s, t] = state.plastic_jump;
        Ok(InterfacePoint {
            traction: [end.normal, end.shear * direction[0], end.shear * direction[1]],
            state: CohesiveState {
                softening: end.softening,
                plastic_jump: [
                    n + end.opening,
                    s + end.plastic_slip * direction[0],
                    t + end.plastic_slip * direction[1],
                ],
            },
        })
    }
}

impl InterfaceLaw for CohesiveBand {
    type State = CohesiveState;

    fn name(&self) -> &'static str {
        NAME
    }

    fn initial(&self, _traction: [f64; 3]) -> CohesiveState {
        CohesiveState::default()
    }

    fn update(
        &self,
        jump: [f64; 3],
        old: &InterfacePoint<CohesiveState>,
    ) -> Result<InterfacePoint<CohesiveState>, MaterialError> {
        let stiffness = [self.spec.normal_stiffness, self.spec.shear_stiffness];
        self.state_after_return(self.elastic_traction(jump, old.traction), stiffness, &old.state)
    }

    fn relax_with_surroundings(
        &self,
        trial: [f64; 3],
        resistance: [f64; 2],
        old: &InterfacePoint<CohesiveState>,
    ) -> Result<([f64; 3], InterfacePoint<CohesiveState>), MaterialError> {
        // The band and its surroundings are springs in series: the return with their common stiffness.
        let [rn, rs] = resistance;
        let (kn, ks) = (self.spec.normal_stiffness, self.spec.shear_stiffness);
        let series = [kn * rn / (kn + rn), ks * rs / (ks + rs)];
        let (k, r) = ([kn, ks, ks], [rn, rs, rs]);
        let shared =
            std::array::from_fn(|i| old.traction[i] + k[i] / (k[i] + r[i]) * (trial[i] - old.traction[i]));
        let new = self.state_after_return(shared, series, &old.state)?;
        Ok((std::array::from_fn(|i| (trial[i] - new.traction[i]) / r[i]), new))
    }

    fn stiffness(
        &self,
        jump: [f64; 3],
        old: &InterfacePoint<CohesiveState>,
    ) -> Result<[[f64; 3]; 3], MaterialError> {
        let CohesiveBandSpec { normal_stiffness: kn, shear_stiffness: ks, friction_coefficient: mu, .. } =
            self.spec;
        let traction = self.elastic_traction(jump, old.traction);
        let (trial, outside) = self.trial(traction, [kn, ks], old.state.softening);
        if !outside {
            return Ok([[kn, 0.0, 0.0], [0.0, ks, 0.0], [0.0, 0.0, ks]]);
        }
        let end = self.return_map(&trial, old.state.softening)?;
        let [[a, b], [c, d]] = end.jacobian;
        let determinant = a * d - b * c;
        // Derivatives of the residuals by the trial, and of (s, χ) by them.
        let saturated = end.softening >= LARGEST_SOFTENING;
        let softening = if saturated { [0.0; 2] } else { self.lengths.map(|length| -1.0 / length) };
        let by = |flow: f64, soften: f64| {
            if determinant == 0.0 {
                return [0.0; 2];
            }
            [(b * soften - d * flow) / determinant, (c * flow - a * soften) / determinant]
        };
        let psi = self.spec.dilatancy_coefficient;
        let by_normal = by(end.shear / kn, softening[0] / kn);
        let by_shear = by(-psi * end.a / ks, softening[1] / ks);
        let z = (-end.softening).exp();
        let a_softening = -z * self.offset * (z * self.offset / end.a);
        // t_n = (z c - A)/μ
        let normal = |[shear, soft]: [f64; 2]| {
            -(end.shear / end.a * shear + (z * self.spec.cohesion + a_softening) * soft) / mu
        };
        let (nn, ns) = (normal(by_normal) * kn, normal(by_shear) * ks);
        let (sn, ss) = (by_normal[0] * kn, by_shear[0] * ks);
        if trial.shear == 0.0 {
            return Ok([[nn, 0.0, 0.0], [0.0, ss, 0.0], [0.0, 0.0, ss]]);
        }
        let (e, across) =
            ([traction[1] / trial.shear, traction[2] / trial.shear], end.shear / trial.shear * ks);
        let plane = |i: usize, j: usize| {
            let unit = if i == j { across } else { 0.0 };
            unit + (ss - across) * e[i] * e[j]
        };
        Ok([
            [nn, ns * e[0], ns * e[1]],
            [sn * e[0], plane(0, 0), plane(0, 1)],
            [sn * e[1], plane(1, 0), plane(1, 1)],
        ])
    }

    fn yield_value(&self, point: &InterfacePoint<CohesiveState>) -> f64 {
        let [n, s, t] = point.traction;
        self.yield_excess(n, s.hypot(t), point.state.softening)
    }

    fn critical_plane(&self, highest: f64, lowest: f64) -> (f64, f64) {
        let mu = self.spec.friction_coefficient;
        let (mean, radius) = (0.5 * (highest + lowest), 0.5 * (highest - lowest));
        // y = r²(1 - x²) - (c - μ m - μ r x)² + b² is largest at x = μ (c - μ m)/(r (1 + μ²)).
        let a = self.spec.cohesion - mu * mean;
        let limit = radius * (1.0 + mu * mu);
        let cosine = if mu * a.max(0.0) < limit && a > 0.0 { mu * a / limit } else { 1.0 };
        let shear = radius * (1.0 - cosine * cosine).sqrt();
        (self.yield_excess(mean + radius * cosine, shear, 0.0), cosine)
    }

    fn tensile_strength(&self) -> f64 {
        self.spec.tensile_strength
    }

    fn damage(&self, state: &CohesiveState) -> f64 {
        -(-state.softening).exp_m1()
    }

    fn snap_back_size(&self, youngs_modulus: f64, shear_modulus: f64) -> f64 {
        let opening = youngs_modulus * self.lengths[0] / self.spec.tensile_strength;
        opening.min(shear_modulus * self.lengths[1] / self.spec.cohesion)
    }

    fn dissipation(&self, old: &InterfacePoint<CohesiveState>, new: &InterfacePoint<CohesiveState>) -> f64 {
        (0..3).map(|k| new.traction[k] * (new.state.plastic_jump[k] - old.state.plastic_jump[k])).sum()
    }
}
