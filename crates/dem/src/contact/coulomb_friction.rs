//! Tangential spring with a dashpot and Coulomb friction (sheet: dem §2.4; Cundall and Strack 1979).

use wide::f64x4 as Lanes;

use crate::config::SpringReset;
use crate::contact::{ContactEnergies, ContactGeometry, ContactHistory, NormalResponse};
use crate::points::vector::{SimdNumber, dot, rotate_with_normal, scaled};

/// Coefficient of friction of rough walls, on which no grain slips.
pub const ROUGH_FRICTION: f64 = 1e12;

/// Parameters of Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    /// Coefficient of friction.
    pub coefficient: f64,
    /// Static coefficient of friction, which must be overcome before a contact slips.
    pub at_rest: f64,
    /// Reset rule of the spring when the contact slips.
    pub reset: SpringReset,
}

impl Coulomb {
    /// Tangential force of a contact in tangent coordinates (N). `before` is the overlap of the last step (m) and whether the stiffness
    /// depends on it. The largest force is the friction coefficient times `cap.0`, plus `cap.1` (N).
    #[inline]
    #[allow(clippy::too_many_arguments, reason = "what a contact is and what it changes")]
    pub fn tangential_force<const D: usize, const R: usize>(
        &self,
        geometry: &ContactGeometry<D, R>,
        base: &NormalResponse,
        before: (f64, bool),
        cap: (f64, f64),
        history: &mut ContactHistory<R>,
        dt: f64,
        energies: &mut ContactEnergies,
    ) -> [f64; R] {
        let (stiffness, dashpot) = (base.tangential_stiffness, base.tangential_damping);
        let mut old = rotate_with_normal(&history.shear_displacement, &geometry.normal, geometry.spin * dt);
        if before.1 {
            old = rescaled_displacement(old, geometry.overlap, before.0, stiffness, energies);
        }
        let mut slide = old;
        for c in 0..R {
            slide[c] += geometry.sliding_velocity[c] * dt;
        }
        let mut force: [f64; R] =
            std::array::from_fn(|c| -stiffness * slide[c] - dashpot * geometry.sliding_velocity[c]);
        let square = dot(&force, &force);
        let mut limit = self.at_rest * cap.0 + cap.1;
        if square > limit * limit {
            limit = self.coefficient * cap.0 + cap.1;
            let size = square.sqrt();
            force = scaled(limit / size, &force);
            slide =
                self.remaining_displacement(&force, &geometry.sliding_velocity, (stiffness, dashpot), limit);
            energies.sliding += 1;
            let sliding = (&geometry.sliding_velocity, dt);
            energies.friction += slip_dissipation(&force, sliding, (stiffness, dashpot), (&old, &slide));
        } else if dashpot > 0.0 {
            energies.dashpots += dashpot * dot(&geometry.sliding_velocity, &geometry.sliding_velocity) * dt;
        }
        energies.elastic_tangential += 0.5 * stiffness * dot(&slide, &slide);
        history.shear_displacement = slide;
        force
    }

    /// Remaining elongation (m) of the spring of a contact that slips under `force`, at most `limit` over the stiffness (N).
    #[inline]
    fn remaining_displacement<const R: usize>(
        &self,
        force: &[f64; R],
        sliding: &[f64; R],
        of: (f64, f64),
        limit: f64,
    ) -> [f64; R] {
        let (stiffness, dashpot) = of;
        if stiffness <= 0.0 {
            return [0.0; R];
        }
        let compliance = 1.0 / stiffness;
        if self.reset == SpringReset::Spring || dashpot == 0.0 {
            return scaled(-compliance, force);
        }
        let slide: [f64; R] = std::array::from_fn(|c| -compliance * (force[c] + dashpot * sliding[c]));
        let size = dot(&slide, &slide).sqrt();
        let largest = compliance * limit;
        if size > largest { scaled(largest / size, &slide) } else { slide }
    }
}

/// Energy dissipated by a slipping contact (J): the work of `force` in the step minus the change of the spring energy. The work is that of
/// the mean of this force and the last one, which moves the grains in leap-frog steps; the last one is that of the spring. With a dashpot
/// it is not known, and the work is that of this force. The result includes the share of the dashpot, and the energy lost by resetting the
/// spring.
#[inline(always)]
pub fn slip_dissipation<T: SimdNumber, const R: usize>(
    force: &[T; R],
    (sliding, dt): (&[T; R], T),
    (stiffness, dashpot): (T, T),
    (old, left): (&[T; R], &[T; R]),
) -> T {
    let none = T::broadcast(0.0);
    let both: [T; R] =
        std::array::from_fn(|c| force[c] + dashpot.select_above(none, force[c], none - stiffness * old[c]));
    T::broadcast(0.5) * (stiffness * (dot(old, old) - dot(left, left)) - dt * dot(&both, sliding))
}

/// Elongation of a tangential spring after a change of its stiffness with the overlap (m). In loading the force is conserved, in unloading
/// the elongation, so that no energy is generated.
#[inline]
fn rescaled_displacement<const R: usize>(
    old: [f64; R],
    overlap: f64,
    before: f64,
    stiffness: f64,
    energies: &mut ContactEnergies,
) -> [f64; R] {
    let square = dot(&old, &old);
    if square == 0.0 || before <= 0.0 {
        return old;
    }
    // The stiffness is proportional to the square root of the overlap.
    let ratio = (before / overlap.max(f64::MIN_POSITIVE)).sqrt();
    if ratio < 1.0 {
        energies.spring_loss += 0.5 * stiffness * square * ratio * (1.0 - ratio);
        scaled(ratio, &old)
    } else {
        energies.spring_loss += 0.5 * stiffness * square * (ratio - 1.0);
        old
    }
}

/// `Coulomb::remaining_displacement` of four contacts, with a mask `spring` of those whose spring is reset to the friction force.
#[inline(always)]
pub fn remaining_displacement_simd<const R: usize>(
    force: &[Lanes; R],
    sliding: &[Lanes; R],
    (stiffness, dashpot): (Lanes, Lanes),
    limit: Lanes,
    spring: Lanes,
) -> [Lanes; R] {
    let compliance = Lanes::ONE / stiffness;
    let slide: [Lanes; R] = std::array::from_fn(|c| -compliance * (force[c] + dashpot * sliding[c]));
    let size = dot(&slide, &slide).sqrt();
    let largest = compliance * limit;
    let clipped = scaled(largest / size, &slide);
    let plain = scaled(-compliance, force);
    let whole = spring | dashpot.simd_eq(Lanes::ZERO);
    let (longer, stiff) = (size.simd_gt(largest), stiffness.simd_gt(Lanes::ZERO));
    std::array::from_fn(|c| stiff & whole.bitselect(plain[c], longer.bitselect(clipped[c], slide[c])))
}

/// `rescaled_displacement` of four contacts, and the energy that is lost (J).
#[inline(always)]
pub fn rescaled_displacement_simd<const R: usize>(
    old: &[Lanes; R],
    overlap: Lanes,
    before: Lanes,
    stiffness: Lanes,
) -> ([Lanes; R], Lanes) {
    let square = dot(old, old);
    let goes_on = before.simd_gt(Lanes::ZERO) & square.simd_ne(Lanes::ZERO);
    let ratio = (before / overlap.fast_max(Lanes::splat(f64::MIN_POSITIVE))).sqrt();
    let opens = ratio.simd_lt(Lanes::ONE);
    let half = Lanes::HALF * stiffness * square;
    let lost = opens.bitselect(half * ratio * (Lanes::ONE - ratio), half * (ratio - Lanes::ONE));
    let shrinks = goes_on & opens;
    (std::array::from_fn(|c| shrinks.bitselect(ratio * old[c], old[c])), goes_on & lost)
}
