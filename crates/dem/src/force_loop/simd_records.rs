//! Records of grains and laws for the SIMD contact kernels.

use std::ops::Range;

use wide::f64x4 as Lanes;

use crate::config::SpringReset;
use crate::contact::hertz::Hertz;
use crate::contact::linear_spring::LinearSpring;
use crate::contact::rolling_resistance::RollingResistance;
use crate::contact::{ContactBody, NormalForceLaw, PairLaw};
use crate::force_loop::ContactInput;
use crate::points::grains::MIN_GRAINS_PER_TASK;
use crate::points::vector::WIDTH;

/// Grain data of the SIMD kernels.
#[derive(Clone, Debug, Default)]
pub struct GrainRecords {
    /// Position and radius of each grain in one record, for the search for contacts.
    pub position_and_radius: Vec<Lanes>,
    /// Motion of each grain.
    pub motion: Vec<GrainMotion>,
    /// Force and moment of each grain.
    pub forces: Vec<ForceTorque>,
}

/// Velocity, inverse mass and spin of a grain, in one cache line. The inverse mass is zero for a grain with prescribed motion. In the plane
/// the spin is the third component beside the velocity.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub struct GrainMotion {
    velocity: Lanes,
    spin: Lanes,
}

/// Force on a grain (N), and moment over its radius (N). In the plane the latter is the third component beside the force.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub struct ForceTorque {
    force: Lanes,
    torque_over_radius: Lanes,
}

impl ForceTorque {
    /// Adds a force, and a moment over the radius.
    #[inline]
    pub fn add_force<const D: usize, const R: usize>(&mut self, force: &[f64; D], lever: &[f64; R]) {
        for c in 0..D {
            self.force.as_mut_array()[c] += force[c];
        }
        for c in 0..R {
            let own = if D == 3 {
                &mut self.torque_over_radius.as_mut_array()[c]
            } else {
                &mut self.force.as_mut_array()[D]
            };
            *own += lever[c];
        }
    }

    /// Adds another force and moment.
    #[inline]
    pub fn add(&mut self, other: &Self) {
        self.force += other.force;
        self.torque_over_radius += other.torque_over_radius;
    }

    /// Force on the grain (N).
    #[inline]
    pub fn force<const D: usize>(&self) -> [f64; D] {
        let all = self.force.as_array();
        std::array::from_fn(|c| all[c])
    }

    /// Moment on a grain (N m) from its radius (m).
    #[inline]
    pub fn moment<const R: usize>(&self, radius: f64) -> [f64; R] {
        let all = if R == 3 { self.torque_over_radius.as_array() } else { self.force.as_array() };
        std::array::from_fn(|c| radius * if R == 3 { all[c] } else { all[2] })
    }

    /// Forces and moments over radius on the grains of four contacts. The moment of the tangential force is equal on both grains; those of
    /// rolling and torsion resistance differ.
    #[inline(always)]
    pub fn gather_group<const D: usize, const R: usize>(
        force: &[Lanes; D],
        lever: &[Lanes; R],
        resistance: Option<[[Lanes; R]; 2]>,
    ) -> [[Self; WIDTH]; 2] {
        let zero = Lanes::ZERO;
        let [one, two] =
            resistance.map_or([*lever; 2], |of| of.map(|of| std::array::from_fn(|c| lever[c] + of[c])));
        let side = |force: [Lanes; WIDTH], lever: [Lanes; WIDTH]| -> [Self; WIDTH] {
            std::array::from_fn(|k| Self { force: force[k], torque_over_radius: lever[k] })
        };
        if D == 3 {
            let on = Lanes::transpose([force[0], force[1], force[2], zero]);
            let first = Lanes::transpose([one[0], one[1], one[2], zero]);
            let second =
                if resistance.is_some() { Lanes::transpose([two[0], two[1], two[2], zero]) } else { first };
            [side(on, first), side(on.map(|f| -f), second)]
        } else {
            let none = [zero; WIDTH];
            let one = Lanes::transpose([force[0], force[1], one[0], zero]);
            let two = Lanes::transpose([-force[0], -force[1], two[0], zero]);
            [side(one, none), side(two, none)]
        }
    }
}

/// Writes forces and moments of all grains to their columns.
pub fn scatter_forces<const D: usize, const R: usize>(
    received: &[ForceTorque],
    radius: &[f64],
    (force, torque): (&mut [[f64; D]], &mut [[f64; R]]),
) {
    use rayon::prelude::*;
    let columns = force.par_chunks_mut(MIN_GRAINS_PER_TASK).zip(torque.par_chunks_mut(MIN_GRAINS_PER_TASK));
    let received = received.par_chunks(MIN_GRAINS_PER_TASK).zip(radius.par_chunks(MIN_GRAINS_PER_TASK));
    received.zip(columns).for_each(|((received, radius), (force, torque))| {
        for (((received, radius), force), torque) in received.iter().zip(radius).zip(force).zip(torque) {
            (*force, *torque) = (received.force(), received.moment(*radius));
        }
    });
}

/// Kernel of the contact forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceKernel {
    /// One contact after another, any law.
    Scalar,
    /// Four contacts at once, linear spring and dashpot; whether some have rolling or torsion resistance.
    SimdLinear(bool),
    /// Four contacts at once, Hertz contact; whether some have rolling or torsion resistance.
    SimdHertz(bool),
}

impl ForceKernel {
    /// Kernel for contacts with a set of laws.
    pub fn for_laws<'l>(mut laws: impl Iterator<Item = &'l PairLaw> + Clone) -> Self {
        let plain = |law: &PairLaw| law.attraction.is_none() && law.bond.is_none();
        let turns = laws.clone().any(|law| law.rolling.is_some() || law.torsion.is_some());
        if !laws.clone().all(plain) {
            Self::Scalar
        } else if laws.clone().all(|law| matches!(law.normal, NormalForceLaw::Linear(_))) {
            Self::SimdLinear(turns)
        } else if laws.all(|law| matches!(law.normal, NormalForceLaw::Hertz(_))) {
            Self::SimdHertz(turns)
        } else {
            Self::Scalar
        }
    }
}

impl GrainRecords {
    /// Resizes the records to a number of grains. New records are zero until [`ContactInput::fill_records`] sets them.
    pub fn resize(&mut self, count: usize) {
        self.position_and_radius.resize(count, Lanes::ZERO);
        self.motion.resize(count, GrainMotion::default());
        self.forces.resize(count, ForceTorque::default());
    }

    /// Mutable view of all records.
    pub fn view(&mut self) -> GrainRecordsMut<'_> {
        let Self { position_and_radius, motion, forces } = self;
        GrainRecordsMut { position_and_radius, motion, forces }
    }
}

/// Mutable view of the records of a range of grains.
pub struct GrainRecordsMut<'a> {
    /// Positions and radii.
    pub position_and_radius: &'a mut [Lanes],
    /// Motions.
    pub motion: &'a mut [GrainMotion],
    /// Forces and moments.
    pub forces: &'a mut [ForceTorque],
}

impl GrainRecordsMut<'_> {
    /// Reborrows the view.
    pub fn reborrow(&mut self) -> GrainRecordsMut<'_> {
        let Self { position_and_radius, motion, forces } = self;
        GrainRecordsMut { position_and_radius, motion, forces }
    }

    /// Splits the view before the grain with index `at`.
    pub fn split_at(self, at: usize) -> (Self, Self) {
        let (a, b) = self.position_and_radius.split_at_mut(at);
        let (c, d) = self.motion.split_at_mut(at);
        let (e, f) = self.forces.split_at_mut(at);
        (
            Self { position_and_radius: a, motion: c, forces: e },
            Self { position_and_radius: b, motion: d, forces: f },
        )
    }
}

impl<const D: usize, const R: usize> ContactInput<'_, D, R> {
    /// Sets the records of a range of grains, with zero forces.
    pub(super) fn fill_records(&self, grains: Range<usize>, records: GrainRecordsMut<'_>) {
        records.forces.fill(ForceTorque::default());
        let records = records.position_and_radius.iter_mut().zip(records.motion);
        for (i, (place, motion)) in grains.zip(records) {
            let inverse = if self.is_held[i] { 0.0 } else { 1.0 / self.mass[i] };
            let (x, v, w) = (&self.position[i], &self.velocity[i], &self.spin[i]);
            if D == 3 {
                *place = Lanes::new([x[0], x[1], x[2], self.radius[i]]);
                motion.velocity = Lanes::new([v[0], v[1], v[2], inverse]);
                motion.spin = Lanes::new([w[0], w[1], w[2], 0.0]);
            } else {
                *place = Lanes::new([x[0], x[1], 0.0, self.radius[i]]);
                motion.velocity = Lanes::new([v[0], v[1], w[0], inverse]);
            }
        }
    }
}

/// Motion of four grains as contact bodies.
#[inline(always)]
pub fn contact_bodies<const D: usize, const R: usize>(
    four: [&GrainMotion; WIDTH],
    radius: Lanes,
) -> ContactBody<D, R, Lanes> {
    let motion = Lanes::transpose(four.map(|own| own.velocity));
    let spin: [Lanes; R] = if D == 3 {
        let spin = Lanes::transpose(four.map(|own| own.spin));
        std::array::from_fn(|c| spin[c])
    } else {
        [motion[2]; R]
    };
    ContactBody { velocity: std::array::from_fn(|c| motion[c]), spin, radius, inverse_mass: motion[3] }
}

/// Contact laws of four contacts, one in each SIMD lane.
#[derive(Clone, Copy)]
pub struct SimdLaws {
    /// Laws along the normals.
    pub normal: SimdNormalLaws,
    /// Laws of friction and of resistance to rolling and torsion.
    pub friction: SimdFrictionLaws,
}

impl SimdLaws {
    /// Gathers the laws of four pairs, one in each SIMD lane.
    pub fn gather(laws: [&PairLaw; WIDTH]) -> Self {
        Self { normal: SimdNormalLaws::gather(laws), friction: SimdFrictionLaws::gather(laws) }
    }
}

/// Number in the laws of four contacts, one in each SIMD lane.
fn lanes(laws: [&PairLaw; WIDTH], of: &dyn Fn(&PairLaw) -> f64) -> Lanes {
    Lanes::new(laws.map(of))
}

/// Mask of those of four contacts whose law has a property.
fn mask(laws: [&PairLaw; WIDTH], of: &dyn Fn(&PairLaw) -> bool) -> Lanes {
    lanes(laws, &|law| f64::from(u8::from(of(law)))).simd_gt(Lanes::ZERO)
}

/// Normal laws of four contacts, one in each SIMD lane.
#[derive(Clone, Copy)]
pub struct SimdNormalLaws {
    /// Linear normal law; zero for pairs with another law.
    pub linear: LinearSpring<Lanes>,
    /// Hertz law; zero for pairs with another law.
    pub hertz: Hertz<Lanes>,
    /// Mask of the laws whose normal force is never attractive.
    pub no_tension: Lanes,
    /// Lag of the velocities in the dashpots over half a step: 1 for lagged, 0 for predicted velocities.
    pub lag: Lanes,
}

/// Laws of friction and of resistance to rolling and torsion of four contacts, one in each SIMD lane.
#[derive(Clone, Copy)]
pub struct SimdFrictionLaws {
    /// Sliding friction coefficient.
    pub coefficient: Lanes,
    /// Friction coefficient at rest.
    pub at_rest: Lanes,
    /// Mask of the laws whose spring is reset to the friction force.
    pub spring: Lanes,
    /// Rolling and torsion resistance, with masks of the laws that have them.
    pub resistance: [(RollingResistance<Lanes>, Lanes); 2],
}

impl SimdNormalLaws {
    /// Gathers the normal laws of four pairs, one in each SIMD lane.
    pub fn gather(laws: [&PairLaw; WIDTH]) -> Self {
        let linear = |of: fn(&LinearSpring) -> f64| {
            let own = |law: &PairLaw| {
                if let NormalForceLaw::Linear(linear) = &law.normal { of(linear) } else { 0.0 }
            };
            lanes(laws, &own)
        };
        let hertz = |of: fn(&Hertz) -> f64| {
            let own =
                |law: &PairLaw| if let NormalForceLaw::Hertz(hertz) = &law.normal { of(hertz) } else { 0.0 };
            lanes(laws, &own)
        };
        Self {
            linear: LinearSpring {
                stiffness: linear(|law| law.stiffness),
                modulus: linear(|law| law.modulus),
                damping_ratio: linear(|law| law.damping_ratio),
                tangential_ratio: linear(|law| law.tangential_ratio),
                tangential_damping_ratio: linear(|law| law.tangential_damping_ratio),
                tangential_ratio_root: linear(|law| law.tangential_ratio_root),
            },
            hertz: Hertz {
                modulus: hertz(|law| law.modulus),
                shear_modulus: hertz(|law| law.shear_modulus),
                grain_shear_modulus: hertz(|law| law.grain_shear_modulus),
                damping: hertz(|law| law.damping),
                tangential_damping: hertz(|law| law.tangential_damping),
                tangential_stiffness_root: hertz(|law| law.tangential_stiffness_root),
            },
            no_tension: mask(laws, &|law| law.no_tension),
            lag: lanes(laws, &|law| law.velocity_lag),
        }
    }
}

impl SimdFrictionLaws {
    /// Gathers the laws of friction and resistance of four pairs, one in each SIMD lane.
    pub fn gather(laws: [&PairLaw; WIDTH]) -> Self {
        let resistance = |of: fn(&PairLaw) -> &Option<RollingResistance>| {
            let part =
                |part: fn(&RollingResistance) -> f64| lanes(laws, &|law| of(law).as_ref().map_or(0.0, part));
            let all = RollingResistance {
                friction: part(|own| own.friction),
                stiffness: part(|own| own.stiffness),
                damping_ratio: part(|own| own.damping_ratio),
            };
            (all, mask(laws, &|law| of(law).is_some()))
        };
        Self {
            coefficient: lanes(laws, &|law| law.friction.coefficient),
            at_rest: lanes(laws, &|law| law.friction.at_rest),
            spring: mask(laws, &|law| law.friction.reset == SpringReset::Spring),
            resistance: [resistance(|law| &law.rolling), resistance(|law| &law.torsion)],
        }
    }
}
