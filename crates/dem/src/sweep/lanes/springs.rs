//! Springs across four contacts, and those against rolling and twisting.

use wide::f64x4 as Lanes;

use super::push::Work;
use crate::contact::friction::{left_in_lanes, rescaled_in_lanes, slipped};
use crate::contact::{Elastic, Touch, rolls};
use crate::sweep::side::Laws;
use crate::vector::{WIDTH, dot, follow, times};

impl<const D: usize, const R: usize> Work<'_, D, R> {
    /// Moments of resistance against rolling and twisting on the first grains of four contacts.
    #[inline(always)]
    pub(super) fn resist(
        &mut self,
        laws: &Laws,
        touch: &Touch<D, R, Lanes>,
        base: &Elastic<Lanes>,
        (cap, dt): (Lanes, Lanes),
        (slots, meets): (&[usize; WIDTH], Lanes),
    ) -> [Lanes; R] {
        let memory = &mut self.memory;
        let (roll, twist) = rolls(&touch.turning, &touch.normal);
        let [(rolling, rolls), (twisting, twists)] = &laws.resistance;
        let old: [Lanes; R] = std::array::from_fn(|c| Lanes::new(slots.map(|slot| memory.roll[slot][c])));
        let spring = follow(&old, &touch.normal, touch.spin * dt);
        let resisted = rolling.act_in_lanes(touch, base, cap, (&spring, &roll), dt);
        let here = meets & *rolls;
        let lefts = resisted.left.map(Lanes::to_array);
        let bits = here.to_bitmask();
        for (k, &slot) in slots.iter().enumerate().filter(|(k, _)| bits & (1 << k) != 0) {
            memory.roll[slot] = std::array::from_fn(|c| lefts[c][k]);
        }
        let mut moment = resisted.moment.map(|m| here & m);
        self.account.sums.rolling += here & resisted.lost;
        self.account.sums.dashpots += here & resisted.dashpots;
        self.account.sums.elastic_rolling += here & resisted.elastic;
        if D == 3 && twists.any() {
            let old = Lanes::new(slots.map(|slot| memory.twist[slot]));
            let resisted = twisting.act_in_lanes(touch, base, cap, (&[old], &[twist]), dt);
            let here = meets & *twists;
            let (left, bits) = (resisted.left[0].to_array(), here.to_bitmask());
            for (k, &slot) in slots.iter().enumerate().filter(|(k, _)| bits & (1 << k) != 0) {
                memory.twist[slot] = left[k];
            }
            for c in 0..D {
                moment[c] += here & (resisted.moment[0] * touch.normal[c]);
            }
            self.account.sums.rolling += here & resisted.lost;
            self.account.sums.dashpots += here & resisted.dashpots;
            self.account.sums.elastic_rolling += here & resisted.elastic;
        }
        moment
    }

    /// Force across and what is left of the spring.
    #[inline(always)]
    pub(super) fn friction<const HERTZ: bool>(
        &mut self,
        laws: &Laws,
        touch: &Touch<D, R, Lanes>,
        base: &Elastic<Lanes>,
        (cap, dt): (Lanes, Lanes),
        (mut old, meets): ([Lanes; R], Lanes),
    ) -> ([Lanes; R], [Lanes; R]) {
        let (stiffness, dashpot) = (base.across, base.damping_across);
        if HERTZ {
            let (rescaled, lost) =
                rescaled_in_lanes(&old, touch.overlap, touch.overlap + touch.separation * dt, stiffness);
            old = rescaled;
            self.account.sums.rescaled += meets & lost;
        }
        let mut slide: [Lanes; R] = std::array::from_fn(|c| old[c] + touch.sliding[c] * dt);
        let mut force: [Lanes; R] =
            std::array::from_fn(|c| -stiffness * slide[c] - dashpot * touch.sliding[c]);
        let square = dot(&force, &force);
        let limit = laws.at_rest * cap;
        let slips = square.simd_gt(limit * limit);
        if slips.any() {
            let limit = laws.coefficient * cap;
            let capped = times(limit / square.sqrt(), &force);
            let left = left_in_lanes(&capped, &touch.sliding, (stiffness, dashpot), limit, laws.spring);
            let lost = slipped(&capped, (&touch.sliding, dt), (stiffness, dashpot), (&old, &left));
            for c in 0..R {
                force[c] = slips.bitselect(capped[c], force[c]);
                slide[c] = slips.bitselect(left[c], slide[c]);
            }
            self.account.sums.friction += meets & slips & lost;
            self.account.tally.sliding += u64::from((meets & slips).to_bitmask().count_ones());
        }
        let viscous = dashpot * dot(&touch.sliding, &touch.sliding);
        self.account.sums.across += meets & slips.bitselect(Lanes::ZERO, viscous);
        self.account.sums.springs += meets & (stiffness * dot(&slide, &slide));
        (force, slide)
    }
}
