//! Tangential, rolling and torsion springs of four contacts.

use wide::f64x4 as Lanes;

use crate::contact::coulomb_friction::{
    remaining_displacement_simd, rescaled_displacement_simd, slip_dissipation,
};
use crate::contact::{ContactGeometry, NormalResponse, rolling_and_twisting};
use crate::force_loop::simd::contact_force::ContactOutput;
use crate::force_loop::simd_records::SimdFrictionLaws;
use crate::points::vector::{WIDTH, dot, rotate_with_normal, scaled};

impl<const D: usize, const R: usize> ContactOutput<'_, D, R> {
    /// Moments of rolling and torsion resistance on the first grains of four contacts (N m).
    #[inline(always)]
    pub(super) fn rolling_moments(
        &mut self,
        laws: &SimdFrictionLaws,
        geometry: &ContactGeometry<D, R, Lanes>,
        base: &NormalResponse<Lanes>,
        (cap, dt): (Lanes, Lanes),
        (slots, in_contact): (&[usize; WIDTH], Lanes),
    ) -> [Lanes; R] {
        let history = &mut self.history;
        let (roll, twist) = rolling_and_twisting(&geometry.relative_spin, &geometry.normal);
        let [(rolling, rolls), (twisting, twists)] = &laws.resistance;
        let old: [Lanes; R] = std::array::from_fn(|c| Lanes::new(slots.map(|slot| history.roll[slot][c])));
        let spring = rotate_with_normal(&old, &geometry.normal, geometry.spin * dt);
        let resisted = rolling.moment_simd(geometry, base, cap, (&spring, &roll), dt);
        let here = in_contact & *rolls;
        let lefts = resisted.angle.map(Lanes::to_array);
        let bits = here.to_bitmask();
        for (k, &slot) in slots.iter().enumerate().filter(|(k, _)| bits & (1 << k) != 0) {
            history.roll[slot] = std::array::from_fn(|c| lefts[c][k]);
        }
        let mut moment = resisted.moment.map(|m| here & m);
        self.account.sums.rolling += here & resisted.dissipated_energy;
        self.account.sums.dashpots += here & resisted.dashpots;
        self.account.sums.elastic_rolling += here & resisted.elastic;
        if D == 3 && twists.any() {
            let old = Lanes::new(slots.map(|slot| history.twist[slot]));
            let resisted = twisting.moment_simd(geometry, base, cap, (&[old], &[twist]), dt);
            let here = in_contact & *twists;
            let (left, bits) = (resisted.angle[0].to_array(), here.to_bitmask());
            for (k, &slot) in slots.iter().enumerate().filter(|(k, _)| bits & (1 << k) != 0) {
                history.twist[slot] = left[k];
            }
            for c in 0..D {
                moment[c] += here & (resisted.moment[0] * geometry.normal[c]);
            }
            self.account.sums.rolling += here & resisted.dissipated_energy;
            self.account.sums.dashpots += here & resisted.dashpots;
            self.account.sums.elastic_rolling += here & resisted.elastic;
        }
        moment
    }

    /// Tangential forces (N) and remaining elongations of the springs (m).
    #[inline(always)]
    pub(super) fn tangential_force<const HERTZ: bool>(
        &mut self,
        laws: &SimdFrictionLaws,
        geometry: &ContactGeometry<D, R, Lanes>,
        base: &NormalResponse<Lanes>,
        (cap, dt): (Lanes, Lanes),
        (mut old, in_contact): ([Lanes; R], Lanes),
    ) -> ([Lanes; R], [Lanes; R]) {
        let (stiffness, dashpot) = (base.tangential_stiffness, base.tangential_damping);
        if HERTZ {
            let (rescaled, lost) = rescaled_displacement_simd(
                &old,
                geometry.overlap,
                geometry.overlap + geometry.separation_velocity * dt,
                stiffness,
            );
            old = rescaled;
            self.account.sums.spring_loss += in_contact & lost;
        }
        let mut shear_displacement: [Lanes; R] =
            std::array::from_fn(|c| old[c] + geometry.sliding_velocity[c] * dt);
        let mut force: [Lanes; R] = std::array::from_fn(|c| {
            -stiffness * shear_displacement[c] - dashpot * geometry.sliding_velocity[c]
        });
        let square = dot(&force, &force);
        let limit = laws.at_rest * cap;
        let slips = square.simd_gt(limit * limit);
        if slips.any() {
            let limit = laws.coefficient * cap;
            let capped = scaled(limit / square.sqrt(), &force);
            let left = remaining_displacement_simd(
                &capped,
                &geometry.sliding_velocity,
                (stiffness, dashpot),
                limit,
                laws.spring,
            );
            let lost = slip_dissipation(
                &capped,
                (&geometry.sliding_velocity, dt),
                (stiffness, dashpot),
                (&old, &left),
            );
            for c in 0..R {
                force[c] = slips.bitselect(capped[c], force[c]);
                shear_displacement[c] = slips.bitselect(left[c], shear_displacement[c]);
            }
            self.account.sums.friction += in_contact & slips & lost;
            self.account.energies.sliding += u64::from((in_contact & slips).to_bitmask().count_ones());
        }
        let viscous = dashpot * dot(&geometry.sliding_velocity, &geometry.sliding_velocity);
        self.account.sums.tangential_power += in_contact & slips.bitselect(Lanes::ZERO, viscous);
        self.account.sums.spring_energy +=
            in_contact & (stiffness * dot(&shear_displacement, &shear_displacement));
        (force, shear_displacement)
    }
}
