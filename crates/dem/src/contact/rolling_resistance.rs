//! Resistance to rolling and torsion: spring, dashpot and cap (Iwashita and Oda 1998, Luding 2008, type C of Ai et al.
//! 2011; sheet: dem §2.6).

use wide::f64x4 as Lanes;

use crate::contact::coulomb_friction::slip_dissipation;
use crate::contact::{
    ContactEnergies, ContactGeometry, ContactHistory, NormalResponse, PairLaw, rolling_and_twisting,
};
use crate::points::vector::{dot, rotate_with_normal, scaled};

/// Parameters of rolling or torsion resistance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingResistance<T = f64> {
    /// Largest moment over effective radius and normal force, `μ_r`.
    pub friction: T,
    /// Stiffness over `k_t R²`.
    pub stiffness: T,
    /// Damping ratio `ζ`: the dashpot is `2 ζ √(k m_eff) R²`, with `k` the stiffness over `R²`.
    pub damping_ratio: T,
}

/// Adds the moments of rolling and torsion resistance on `i`.
#[inline]
#[allow(clippy::too_many_arguments, reason = "what a contact is and what it changes")]
pub fn add_rolling_moments<const D: usize, const R: usize>(
    law: &PairLaw,
    geometry: &ContactGeometry<D, R>,
    base: &NormalResponse,
    normal: f64,
    history: &mut ContactHistory<R>,
    moment: &mut [f64; R],
    dt: f64,
    energies: &mut ContactEnergies,
) {
    let (roll, twist) = rolling_and_twisting(&geometry.relative_spin, &geometry.normal);
    if let Some(resistance) = &law.rolling {
        let spring = rotate_with_normal(&history.rolling_angle, &geometry.normal, geometry.spin * dt);
        let (force, angle) = resistance.moment(geometry, base, normal, &spring, &roll, dt, energies);
        history.rolling_angle = angle;
        for c in 0..R {
            moment[c] += force[c];
        }
    }
    if let (3, Some(resistance)) = (D, &law.torsion) {
        let (force, angle) =
            resistance.moment(geometry, base, normal, &[history.torsion_angle], &[twist], dt, energies);
        history.torsion_angle = angle[0];
        for c in 0..D {
            moment[c] += force[0] * geometry.normal[c];
        }
    }
}

impl RollingResistance {
    /// Moment (N m), and elongation of the spring (rad).
    #[inline]
    #[allow(clippy::too_many_arguments, reason = "what a contact is and what it changes")]
    fn moment<const D: usize, const R: usize, const N: usize>(
        &self,
        geometry: &ContactGeometry<D, R>,
        base: &NormalResponse,
        normal: f64,
        spring: &[f64; N],
        rate: &[f64; N],
        dt: f64,
        energies: &mut ContactEnergies,
    ) -> ([f64; N], [f64; N]) {
        let square = geometry.radius * geometry.radius;
        let stiffness = self.stiffness * base.tangential_stiffness * square;
        let dashpot = 2.0
            * self.damping_ratio
            * (self.stiffness * base.tangential_stiffness * geometry.mass).sqrt()
            * square;
        let mut angle: [f64; N] = std::array::from_fn(|c| spring[c] + rate[c] * dt);
        let mut moment: [f64; N] = std::array::from_fn(|c| -stiffness * angle[c] - dashpot * rate[c]);
        let size = dot(&moment, &moment).sqrt();
        let limit = self.friction * geometry.radius * normal;
        if size > limit {
            moment = scaled(limit / size, &moment);
            angle = std::array::from_fn(|c| -(moment[c] + dashpot * rate[c]) / stiffness);
            let length = dot(&angle, &angle).sqrt();
            if length * stiffness > limit {
                angle = scaled(limit / (stiffness * length), &angle);
            }
            energies.rolling += slip_dissipation(&moment, (rate, dt), (stiffness, dashpot), (spring, &angle));
        } else {
            energies.dashpots += dashpot * dot(rate, rate) * dt;
        }
        energies.elastic_rolling += 0.5 * stiffness * dot(&angle, &angle);
        (moment, angle)
    }
}

/// Response of rolling or torsion resistance of four contacts.
pub struct RollingResponse<const N: usize> {
    /// Moment on the first grain (N m).
    pub moment: [Lanes; N],
    /// Elongation of the spring (rad).
    pub angle: [Lanes; N],
    /// Energy dissipated at the largest moment (J).
    pub dissipated_energy: Lanes,
    /// Energy dissipated by dashpots (J).
    pub dashpots: Lanes,
    /// Elastic energy of springs (J).
    pub elastic: Lanes,
}

impl RollingResistance<Lanes> {
    /// Moments and spring angles of four contacts under normal forces (N).
    #[inline(always)]
    pub fn moment_simd<const D: usize, const R: usize, const N: usize>(
        &self,
        geometry: &ContactGeometry<D, R, Lanes>,
        base: &NormalResponse<Lanes>,
        normal: Lanes,
        (spring, rate): (&[Lanes; N], &[Lanes; N]),
        dt: Lanes,
    ) -> RollingResponse<N> {
        let square = geometry.radius * geometry.radius;
        let stiffness = self.stiffness * base.tangential_stiffness * square;
        let dashpot = Lanes::splat(2.0)
            * self.damping_ratio
            * (self.stiffness * base.tangential_stiffness * geometry.mass).sqrt()
            * square;
        let mut angle: [Lanes; N] = std::array::from_fn(|c| spring[c] + rate[c] * dt);
        let mut moment: [Lanes; N] = std::array::from_fn(|c| -stiffness * angle[c] - dashpot * rate[c]);
        let size = dot(&moment, &moment).sqrt();
        let limit = self.friction * geometry.radius * normal;
        let slips = size.simd_gt(limit);
        let mut lost = Lanes::ZERO;
        if slips.any() {
            let capped = scaled(limit / size, &moment);
            let free: [Lanes; N] = std::array::from_fn(|c| -(capped[c] + dashpot * rate[c]) / stiffness);
            let length = dot(&free, &free).sqrt();
            let longer = (length * stiffness).simd_gt(limit);
            let clipped = scaled(limit / (stiffness * length), &free);
            let kept: [Lanes; N] = std::array::from_fn(|c| longer.bitselect(clipped[c], free[c]));
            lost = slip_dissipation(&capped, (rate, dt), (stiffness, dashpot), (spring, &kept));
            for c in 0..N {
                moment[c] = slips.bitselect(capped[c], moment[c]);
                angle[c] = slips.bitselect(kept[c], angle[c]);
            }
        }
        RollingResponse {
            moment,
            angle,
            dissipated_energy: slips & lost,
            dashpots: slips.bitselect(Lanes::ZERO, dashpot * dot(rate, rate) * dt),
            elastic: Lanes::HALF * stiffness * dot(&angle, &angle),
        }
    }
}
