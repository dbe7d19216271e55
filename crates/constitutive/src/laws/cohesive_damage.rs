//! Cohesive damage with exponential softening (sheet: constitutive §2.16; a standard law of cohesive-zone
//! models).
//!
//! `t = (1 - D) K₀ u`; the effective opening `δ = √(⟨u_n⟩² + |u_s|²)` drives
//! `D = 1 - (δ₀/κ) exp(-(κ - δ₀)/δ_f)`, `κ = max δ`, `δ₀ = f_t/K₀`. The area under any radial path is
//! `G = f_t (δ₀/2 + δ_f)`. A closed crack has the full normal stiffness. Limits: unloads to the origin;
//! no friction after failure.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::contract::parameter_checks::{check, positive};
use crate::return_maps::scalar_roots::falling_root;
use crate::{InterfaceLaw, InterfacePoint, MaterialError};

/// Value of the key `model` in case files.
const NAME: &str = "cohesive-damage";

/// Parameters of the damage band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CohesiveDamageSpec {
    /// Strength `f_t` (Pa), positive, in opening and sliding.
    pub tensile_strength: f64,
    /// Fracture energy `G` (J/m²), more than `f_t²/(2 K₀)`.
    pub fracture_energy: f64,
    /// Stiffness `K₀` (Pa/m), positive.
    pub stiffness: f64,
}

/// Law of the damage band. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CohesiveDamage {
    spec: CohesiveDamageSpec,
    /// Lengths `δ₀`, `δ_f` (m).
    lengths: [f64; 2],
}

/// Internal variables of the damage band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DamageState {
    /// Displacement jump (m): normal and two tangential components, the elastic jump at insertion included.
    pub jump: [f64; 3],
    /// Largest effective opening in the history, `κ` (m).
    pub max_opening: f64,
}

impl CohesiveDamageSpec {
    /// Parameters from tensile strength (Pa), fracture energy (J/m²) and stiffness (Pa/m).
    #[must_use]
    pub fn new(tensile_strength: f64, fracture_energy: f64, stiffness: f64) -> Self {
        Self { tensile_strength, fracture_energy, stiffness }
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<CohesiveDamage, MaterialError> {
        positive("band.tensile_strength", self.tensile_strength, "Pa")?;
        positive("band.fracture_energy", self.fracture_energy, "J/m²")?;
        positive("band.stiffness", self.stiffness, "Pa/m")?;
        let elastic = self.tensile_strength / self.stiffness;
        let tail = self.fracture_energy / self.tensile_strength - 0.5 * elastic;
        // Softening must not be steeper than the stiffness.
        let smallest = self.tensile_strength * self.tensile_strength * 1.5 / self.fracture_energy;
        let rule = format!("must be more than 3/2 f_t²/G, {smallest} Pa/m");
        check("band.stiffness", self.stiffness, tail > elastic, &rule)?;
        Ok(CohesiveDamage { spec: *self, lengths: [elastic, tail] })
    }
}

/// Effective opening of a displacement jump: norm of the positive normal and the tangential components (m).
fn effective_opening(jump: [f64; 3]) -> f64 {
    jump[0].max(0.0).hypot(jump[1].hypot(jump[2]))
}

impl CohesiveDamage {
    /// Integrity `1 - D` at the largest effective opening `κ` (m).
    fn integrity(&self, largest: f64) -> f64 {
        let [elastic, tail] = self.lengths;
        if largest <= elastic { 1.0 } else { elastic / largest * (-(largest - elastic) / tail).exp() }
    }

    /// Traction of a displacement jump (Pa); `integrity`, one minus the damage, reduces all but a closing normal component.
    fn traction(&self, jump: [f64; 3], integrity: f64) -> [f64; 3] {
        let stiffness = self.spec.stiffness;
        let normal = if jump[0] > 0.0 { integrity * jump[0] } else { jump[0] };
        [stiffness * normal, stiffness * integrity * jump[1], stiffness * integrity * jump[2]]
    }
}

impl InterfaceLaw for CohesiveDamage {
    type State = DamageState;

    fn name(&self) -> &'static str {
        NAME
    }

    fn initial(&self, traction: [f64; 3]) -> DamageState {
        let jump = traction.map(|t| t / self.spec.stiffness);
        DamageState { jump, max_opening: effective_opening(jump) }
    }

    fn update(
        &self,
        jump: [f64; 3],
        old: &InterfacePoint<DamageState>,
    ) -> Result<InterfacePoint<DamageState>, MaterialError> {
        let jump = std::array::from_fn(|k| old.state.jump[k] + jump[k]);
        let largest = old.state.max_opening.max(effective_opening(jump));
        let traction = self.traction(jump, self.integrity(largest));
        Ok(InterfacePoint { traction, state: DamageState { jump, max_opening: largest } })
    }

    fn relax_with_surroundings(
        &self,
        trial: [f64; 3],
        resistance: [f64; 2],
        old: &InterfacePoint<DamageState>,
    ) -> Result<([f64; 3], InterfacePoint<DamageState>), MaterialError> {
        let k = self.spec.stiffness;
        let r = [resistance[0], resistance[1], resistance[1]];
        let state = &old.state;
        let load: [f64; 3] = std::array::from_fn(|i| trial[i] + r[i] * state.jump[i]);
        // At given integrity w: (w K₀ + R) u = T + R u_old, a closed crack with w = 1.
        let stiff = |i: usize, w: f64| if i == 0 && load[0] <= 0.0 { k + r[0] } else { w * k + r[i] };
        let jump = |w: f64| -> [f64; 3] { std::array::from_fn(|i| load[i] / stiff(i, w)) };
        let mut largest = state.max_opening;
        if effective_opening(jump(self.integrity(largest))) > largest {
            let end = effective_opening(jump(0.0)).max(largest);
            largest = falling_root(largest, end, largest.max(self.lengths[0]), |kappa| {
                let w = self.integrity(kappa);
                let rate =
                    if kappa > self.lengths[0] { -w * (1.0 / kappa + 1.0 / self.lengths[1]) } else { 0.0 };
                let u = jump(w);
                let opening = effective_opening(u);
                let open = [u[0].max(0.0), u[1], u[2]];
                let slope: f64 = (0..3).map(|i| -open[i] * open[i] * k * rate / stiff(i, w)).sum();
                (opening - kappa, slope / opening - 1.0)
            })
            .ok_or(MaterialError::NotConverged { model: NAME, reason: "damage of the band" })?;
        }
        let integrity = self.integrity(largest);
        let total = jump(integrity);
        let point = InterfacePoint {
            traction: self.traction(total, integrity),
            state: DamageState { jump: total, max_opening: largest.max(effective_opening(total)) },
        };
        Ok((std::array::from_fn(|i| total[i] - state.jump[i]), point))
    }

    fn stiffness(
        &self,
        jump: [f64; 3],
        old: &InterfacePoint<DamageState>,
    ) -> Result<[[f64; 3]; 3], MaterialError> {
        let jump: [f64; 3] = std::array::from_fn(|k| old.state.jump[k] + jump[k]);
        let opening = effective_opening(jump);
        let largest = old.state.max_opening.max(opening);
        let integrity = self.integrity(largest);
        let k = self.spec.stiffness;
        let normal = if jump[0] > 0.0 { integrity } else { 1.0 };
        let mut stiffness = [[k * normal, 0.0, 0.0], [0.0, k * integrity, 0.0], [0.0, 0.0, k * integrity]];
        if opening >= largest && largest > self.lengths[0] {
            // d(1 - D)/dκ = -(1 - D)(1/κ + 1/δ_f), dκ/du = u/δ without closure.
            let open = [jump[0].max(0.0), jump[1], jump[2]];
            let slope = -integrity * (1.0 / largest + 1.0 / self.lengths[1]) / opening;
            for (row, a) in stiffness.iter_mut().zip(open) {
                for (entry, b) in row.iter_mut().zip(open) {
                    *entry += k * slope * a * b;
                }
            }
        }
        Ok(stiffness)
    }

    fn yield_value(&self, point: &InterfacePoint<DamageState>) -> f64 {
        let largest = point.state.max_opening.max(self.lengths[0]);
        effective_opening(point.traction) - self.integrity(largest) * self.spec.stiffness * largest
    }

    fn critical_plane(&self, highest: f64, lowest: f64) -> (f64, f64) {
        // The effective traction is largest across the highest stress, or in shear where the mean stress of
        // the circle is compressive.
        if highest + lowest >= 0.0 {
            (highest - self.spec.tensile_strength, 1.0)
        } else {
            (0.5 * (highest - lowest) - self.spec.tensile_strength, 0.0)
        }
    }

    fn tensile_strength(&self) -> f64 {
        self.spec.tensile_strength
    }

    fn damage(&self, state: &DamageState) -> f64 {
        1.0 - self.integrity(state.max_opening)
    }

    fn snap_back_size(&self, youngs_modulus: f64, shear_modulus: f64) -> f64 {
        youngs_modulus.min(shear_modulus) * self.lengths[1] / self.spec.tensile_strength
    }

    fn dissipation(&self, old: &InterfacePoint<DamageState>, new: &InterfacePoint<DamageState>) -> f64 {
        let opening = effective_opening(new.state.jump);
        let lost = self.integrity(old.state.max_opening) - self.integrity(new.state.max_opening);
        0.5 * self.spec.stiffness * opening * opening * lost
    }
}
