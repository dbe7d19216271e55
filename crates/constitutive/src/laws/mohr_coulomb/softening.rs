//! Return with strength at the end of the step (sheet: constitutive §3.7.2, step 7) and its tangent.

use super::pyramid::dot;
use super::return_map::elastic_strain;
use super::{MohrCoulomb, PlasticStrain, Softening};
use crate::return_maps::scalar_roots::first_fixed_point;
use crate::{MaterialError, PrincipalReturn};

impl MohrCoulomb {
    /// Tangent like [`Pyramid::tangent`] with the strength at the end of the step. It follows from `dσ = D dε + σ' dκ` and `dκ = w · (dε -
    /// C dσ)`, where `w` is the direction of the deviatoric plastic strain.
    pub(super) fn softening_tangent(&self, trial: [f64; 3], state: &PlasticStrain) -> Option<[[f64; 3]; 3]> {
        let (stress, new) = self.return_principal(trial, state).ok()?;
        let kappa = new.deviatoric;
        let pyramid = self.pyramid_at(kappa);
        let region = pyramid.region(&self.elasticity, trial);
        let fixed = pyramid.tangent(&self.elasticity, region);
        let increment = kappa - state.deviatoric;
        if increment <= 0.0 {
            return Some(fixed);
        }
        let step = Softening::difference_step(self.spec.softening, self.spec.dilatancy_decay);
        let at = |kappa: f64| self.pyramid_at(kappa).return_to(region, &self.elasticity, trial);
        let (plus, minus) = (at(kappa + step), at(kappa - step));
        let slope: [f64; 3] = std::array::from_fn(|a| (plus[a] - minus[a]) / (2.0 * step));
        let plastic = elastic_strain(&self.elasticity, std::array::from_fn(|a| trial[a] - stress[a]));
        let mean = (plastic[0] + plastic[1] + plastic[2]) / 3.0;
        let w = plastic.map(|e| 2.0 / 3.0 * (e - mean) / increment);
        let modulus = 1.0 + dot(w, elastic_strain(&self.elasticity, slope));
        let driven: [f64; 3] = std::array::from_fn(|b| {
            let column = std::array::from_fn(|a| fixed[a][b]);
            (w[b] - dot(w, elastic_strain(&self.elasticity, column))) / modulus
        });
        Some(std::array::from_fn(|a| std::array::from_fn(|b| fixed[a][b] + slope[a] * driven[b])))
    }

    /// Return with the strength at the end of the step, by a fixed-point iteration of the plastic increment. Where softening snaps back
    /// there can be several fixed points; the result is the smallest. `start` is the plastic increment at the initial strength.
    pub(super) fn softening_return(
        &self,
        trial: [f64; 3],
        kappa: f64,
        start: f64,
    ) -> Result<([f64; 3], f64), MaterialError> {
        let mean = trial.iter().sum::<f64>() / 3.0;
        let small = 1e-13 * self.plastic_increment(trial, [mean; 3]).max(start);
        let mut stress = trial;
        let increment = first_fixed_point(start, small, |increment| {
            stress = self.softened_pyramid(kappa + increment).return_map(&self.elasticity, trial).0;
            self.plastic_increment(trial, stress)
        });
        let failed = MaterialError::NotConverged { model: self.name, reason: "softening return" };
        Ok((stress, increment.ok_or(failed)?))
    }
}
