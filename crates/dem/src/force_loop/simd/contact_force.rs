//! Forces and moments of four contacts at once, and sums over contacts.

use wide::f64x4 as Lanes;

use crate::contact::contact_histories::ContactHistoriesMut;
use crate::contact::dashpot::StepLengths;
use crate::contact::{ContactEnergies, ContactGeometry, ContactState, NormalResponse, dashpot};
use crate::force_loop::simd::batch::{ContactBatch, FourContacts, SimdNormalForce};
use crate::force_loop::simd_records::{ForceTorque, SimdFrictionLaws, SimdNormalLaws};
use crate::force_loop::{ContactInput, Virial};
use crate::points::vector::{WIDTH, add, dot, from_tangential, moment, scaled};

/// Sums over contacts, lane by lane.
#[derive(Clone, Copy, Default)]
pub(super) struct SimdContactSums {
    elastic: Lanes,
    /// Twice the energy of tangential springs (J).
    pub(super) spring_energy: Lanes,
    /// Minus twice the power of the normal dashpots; the next field is the power of the tangential ones (W).
    normal_power: Lanes,
    /// Power of the tangential dashpots (W).
    pub(super) tangential_power: Lanes,
    /// Energy dissipated by friction (J).
    pub(super) friction: Lanes,
    /// Energy dissipated by the dashpots whose power is not summed separately (J).
    pub(super) dashpots: Lanes,
    /// Energy lost where tangential springs are rescaled (J).
    pub(super) spring_loss: Lanes,
    /// Energy dissipated by rolling and torsion resistance (J).
    pub(super) rolling: Lanes,
    /// Elastic energy of the rolling and torsion springs (J).
    pub(super) elastic_rolling: Lanes,
    boundary: Lanes,
    squares: Lanes,
}

/// Energies, dissipation and virial, summed over contacts.
#[derive(Clone, Copy)]
pub(super) struct ContactSums<const D: usize> {
    /// Energies of the contacts that are computed one at a time.
    pub(super) energies: ContactEnergies,
    /// Sums of the contacts that are computed four at a time.
    pub(super) sums: SimdContactSums,
    virial: Virial<D>,
}

impl<const D: usize> ContactSums<D> {
    /// Sums that start from given energies and virial.
    pub(super) fn new(energies: ContactEnergies, virial: Virial<D>) -> Self {
        Self { energies, sums: SimdContactSums::default(), virial }
    }

    /// Totals over all lanes in a step of `dt` (s).
    pub(super) fn sums(self, dt: f64) -> (ContactEnergies, Virial<D>) {
        let Self { mut energies, sums, virial } = self;
        let sum = |lanes: Lanes| {
            let [a, b, c, d] = lanes.to_array();
            (a + b) + (c + d)
        };
        energies.elastic += sum(sums.elastic);
        energies.elastic_tangential += 0.5 * sum(sums.spring_energy);
        energies.friction += sum(sums.friction);
        energies.dashpots +=
            sum(sums.dashpots) + dt * (sum(sums.tangential_power) - 0.5 * sum(sums.normal_power));
        energies.spring_loss += sum(sums.spring_loss);
        energies.rolling += sum(sums.rolling);
        energies.elastic_rolling += sum(sums.elastic_rolling);
        energies.boundary += sum(sums.boundary);
        energies.squares += sum(sums.squares);
        (energies, virial)
    }
}

/// Forces of four contacts on the first grains.
pub(super) struct SimdForce<const D: usize, const R: usize> {
    /// Force on the first grain (N); zero for unused lanes.
    pub(super) force: [Lanes; D],
    /// Tangential force in tangent coordinates (N).
    pub(super) tangential: [Lanes; R],
    /// Normal force that friction and rolling resistance scale with (N).
    pub(super) cap: Lanes,
    /// Mask of the used contacts that overlap, and its bits.
    pub(super) in_contact: Lanes,
    bits: u32,
}

/// Output of the contact kernel. It is passed through a batch by value, so that its pointers and sums stay in registers across writes.
pub(super) struct ContactOutput<'r, const D: usize, const R: usize> {
    /// Forces and moments of the grains, from the first grain of the range on.
    pub(super) forces: &'r mut [ForceTorque],
    /// Contact histories, from the first pair of the range on.
    pub(super) history: ContactHistoriesMut<'r, R>,
    /// Energies and virial of the contacts.
    pub(super) account: ContactSums<D>,
    /// Number of the first grain.
    pub(super) first: usize,
}

impl<const D: usize, const R: usize> ContactOutput<'_, D, R> {
    /// Reborrows the output.
    #[inline(always)]
    pub(super) fn reborrow(&mut self) -> ContactOutput<'_, D, R> {
        let mut history = self.history.reborrow();
        // Equal lengths: one bounds check serves both.
        history.state = &mut history.state[..history.spring.len()];
        ContactOutput { forces: self.forces, history, account: self.account, first: self.first }
    }

    /// Normal forces of four contacts.
    #[inline(always)]
    pub(super) fn normal_force<const HERTZ: bool>(
        &self,
        geometry: &ContactGeometry<D, R, Lanes>,
        laws: &SimdNormalLaws,
        slots: &[usize; WIDTH],
        steps: &StepLengths<Lanes>,
    ) -> SimdNormalForce {
        let mut response = if HERTZ { laws.hertz.response(geometry) } else { laws.linear.response(geometry) };
        response.damping = self.dashpots::<HERTZ>(&response, geometry, laws, slots, steps);
        let viscous = response.force - response.damping * geometry.separation_velocity;
        let force = (laws.no_tension & viscous.simd_lt(Lanes::ZERO)).bitselect(Lanes::ZERO, viscous);
        SimdNormalForce { response, force }
    }

    /// Forces of four contacts on their first grains, of which the first `valid` are used; the tangential springs are stored.
    #[inline(always)]
    pub(super) fn force<const HERTZ: bool>(
        &mut self,
        (geometry, normal): (&ContactGeometry<D, R, Lanes>, &SimdNormalForce),
        (shear_displacement, damping_force): ([Lanes; R], Lanes),
        laws: &SimdFrictionLaws,
        (grains, slots): ([u32; WIDTH], &[usize; WIDTH]),
        (valid, last_step): (usize, Lanes),
    ) -> SimdForce<D, R> {
        let SimdNormalForce { response, force: normal } = *normal;
        let lane = Lanes::new([0.0, 1.0, 2.0, 3.0]);
        let in_contact = geometry.overlap.simd_gt(Lanes::ZERO) & lane.simd_lt(Lanes::splat(valid as f64));
        let dissipative = normal - response.force;
        let sums = &mut self.account.sums;
        sums.normal_power += in_contact & ((damping_force + dissipative) * geometry.separation_velocity);
        sums.elastic += in_contact & response.energy;
        let cap = normal.fast_max(Lanes::ZERO);
        let (tangential, shear_displacement) = self.tangential_force::<HERTZ>(
            laws,
            geometry,
            &response,
            (cap, last_step),
            (shear_displacement, in_contact),
        );
        let bits = in_contact.to_bitmask();
        self.store_springs(slots, &shear_displacement, dissipative, bits);
        let mut on: [Lanes; D] = from_tangential(&tangential, &geometry.normal);
        add(&mut on, normal, &geometry.normal);
        self.count(geometry, &on, (grains, bits), in_contact);
        SimdForce { force: on.map(|f| in_contact & f), tangential, cap, in_contact, bits }
    }

    /// Normal dashpots of four contacts in the step (N s/m).
    #[inline(always)]
    fn dashpots<const HERTZ: bool>(
        &self,
        base: &NormalResponse<Lanes>,
        geometry: &ContactGeometry<D, R, Lanes>,
        laws: &SimdNormalLaws,
        slots: &[usize; WIDTH],
        steps: &StepLengths<Lanes>,
    ) -> Lanes {
        let in_contact = geometry.overlap.simd_gt(Lanes::ZERO);
        let damping = dashpot::lagged_dashpot(base.damping, geometry.inverse_mass, laws.lag * steps.lag_step);
        let mut all = damping;
        let approach = -geometry.separation_velocity * steps.last;
        if (in_contact & (approach + approach).simd_gt(geometry.overlap)).any() {
            let is_new =
                slots.map(|slot| f64::from(u8::from(self.history.state[slot] == ContactState::Apart)));
            let onset = dashpot::onset_dashpot(damping, geometry, steps, HERTZ);
            all = Lanes::new(is_new).simd_gt(Lanes::ZERO).bitselect(onset, damping);
        }
        if !laws.no_tension.all() {
            let damped = NormalResponse { damping: all, ..*base };
            // All other contacts persist, with the dashpot unchanged.
            let ends = dashpot::opening(&damped, geometry, steps).simd_gt(geometry.overlap)
                & geometry.separation_velocity.simd_gt(Lanes::ZERO);
            if (in_contact & ends).any() {
                let release = dashpot::release_dashpot(&damped, geometry, steps, HERTZ);
                all = laws.no_tension.bitselect(all, release);
            }
        }
        all
    }

    /// Adds forces and moments of up to four contacts, of which the first `valid` are used. Returns the bits of the contacts with overlap.
    #[inline(always)]
    pub(super) fn contact_forces<const HERTZ: bool, const TURNS: bool>(
        &mut self,
        batch: &ContactBatch<D, R>,
        group: usize,
        (input, periodic): (&ContactInput<'_, D, R>, bool),
        laws: &SimdFrictionLaws,
        valid: usize,
    ) -> u32 {
        let pairs = batch.pairs(group);
        let slots = pairs.map(|pair| pair.slot as usize);
        let FourContacts { geometry, lever_arm, apart, radii, shear_displacement, damping_force, normal } =
            &batch.groups[group];
        let dt = Lanes::splat(input.dt);
        let firsts = pairs.each_ref().map(|pair| pair.first);
        let SimdForce { force, tangential, cap, in_contact, bits } = self.force::<HERTZ>(
            (geometry, normal),
            (*shear_displacement, *damping_force),
            laws,
            (firsts, &slots),
            (valid, dt),
        );
        if input.growth != 0.0 {
            let sum = geometry.overlap + dot(apart, apart).sqrt();
            self.account.sums.boundary += in_contact & (normal.force * Lanes::splat(input.growth) * sum * dt);
        }
        if periodic {
            let [_, velocity] = input.images(pairs);
            self.account.sums.boundary += in_contact & (dot(&force, &velocity) * dt);
            self.add_stress(valid, &force, apart);
        }
        let lever: [Lanes; R] =
            scaled(-*lever_arm, &moment(&geometry.normal, &tangential)).map(|own: Lanes| in_contact & own);
        let resistance = TURNS.then(|| {
            let turned =
                self.rolling_moments(laws, geometry, &normal.response, (cap, dt), (&slots, in_contact));
            let [a, b] = radii.map(|radius| Lanes::ONE / radius);
            [scaled(a, &turned), scaled(b, &turned).map(|own| -own)]
        });
        // Grains of lanes that do not count receive nothing.
        let [one, two] = ForceTorque::gather_group(&force, &lever, resistance);
        for (k, pair) in pairs.iter().enumerate() {
            self.forces[pair.first as usize].add(&one[k]);
            self.forces[pair.second as usize].add(&two[k]);
        }
        bits
    }

    /// Stores the springs of those of four contacts whose bits are set.
    #[inline(always)]
    fn store_springs(
        &mut self,
        slots: &[usize; WIDTH],
        shear_displacement: &[Lanes; R],
        damping_force: Lanes,
        bits: u32,
    ) {
        let part = |c: usize| if c < R { shear_displacement[c] } else { Lanes::ZERO };
        let lines = Lanes::transpose([part(0), part(1), part(2), damping_force]);
        let all = bits == (1 << WIDTH) - 1;
        for (k, &slot) in slots.iter().enumerate() {
            if all || bits & (1 << k) != 0 {
                self.history.spring[slot] = lines[k].to_array();
                self.history.state[slot] = ContactState::Touching;
            }
        }
    }

    /// Adds the stress of up to four contacts to the virial, one contact at a time.
    #[inline(always)]
    fn add_stress(&mut self, valid: usize, on: &[Lanes; D], apart: &[Lanes; D]) {
        let (on, apart) = (on.map(Lanes::to_array), apart.map(Lanes::to_array));
        for k in 0..valid {
            for c in 0..D {
                for d in 0..D {
                    self.account.virial[c][d] -= on[c][k] * apart[d][k];
                }
            }
        }
    }

    /// Counts contacts, and adds up their squared forces.
    #[inline(always)]
    fn count(
        &mut self,
        geometry: &ContactGeometry<D, R, Lanes>,
        on: &[Lanes; D],
        (firsts, bits): ([u32; WIDTH], u32),
        in_contact: Lanes,
    ) {
        let ContactSums { energies, sums, .. } = &mut self.account;
        energies.contacts += u64::from(bits.count_ones());
        sums.squares += in_contact & dot(on, on);
        let deeper =
            geometry.overlap.simd_gt(Lanes::splat(energies.overlap) * geometry.min_radius) & in_contact;
        if deeper.any() {
            let ratios = (geometry.overlap / geometry.min_radius).to_array();
            for (k, ratio) in ratios.into_iter().enumerate() {
                if bits & (1 << k) != 0 && ratio > energies.overlap {
                    (energies.overlap, energies.max_overlap_grain) = (ratio, self.first as u32 + firsts[k]);
                }
            }
        }
    }
}
