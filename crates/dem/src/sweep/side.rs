//! What contacts side by side see: records of the grains, and their laws.

use wide::f64x4 as Lanes;

use crate::config::SpringReset;
use crate::contact::hertz::Hertz;
use crate::contact::linear::Linear;
use crate::contact::rolling::Resistance;
use crate::contact::{Law, Normal};
use crate::grains::{Shown, TASK};

/// Contacts side by side.
pub const WIDTH: usize = 4;

/// What a grain shows its contacts: place and radius, velocity and mass (negative where it is held), spin. In the plane the
/// spin stands third beside the velocity.
#[derive(Clone, Copy, Debug, Default)]
pub struct Record {
    place: Lanes,
    motion: Lanes,
    spin: Lanes,
}

/// Force and moment that a grain receives. In the plane the moment stands third beside the force.
#[derive(Clone, Copy, Debug, Default)]
pub struct Received {
    force: Lanes,
    moment: Lanes,
}

impl Received {
    /// Adds `sign` times a force and a moment, and `across.0` times the moment `across.1`.
    #[inline]
    pub fn take<const D: usize, const R: usize>(
        &mut self,
        sign: f64,
        force: &[f64; D],
        across: (f64, &[f64; R]),
        moment: &[f64; R],
    ) {
        for c in 0..D {
            self.force.as_mut_array()[c] += sign * force[c];
        }
        for c in 0..R {
            let own =
                if D == 3 { &mut self.moment.as_mut_array()[c] } else { &mut self.force.as_mut_array()[D] };
            *own += across.0 * across.1[c] + sign * moment[c];
        }
    }

    /// Adds what another part has received.
    #[inline]
    pub fn join(&mut self, other: &Self) {
        self.force += other.force;
        self.moment += other.moment;
    }

    /// The force (N).
    #[inline]
    pub fn force<const D: usize>(&self) -> [f64; D] {
        let all = self.force.as_array();
        std::array::from_fn(|c| all[c])
    }

    /// The moment (N m).
    #[inline]
    pub fn moment<const R: usize>(&self) -> [f64; R] {
        let all = if R == 3 { self.moment.as_array() } else { self.force.as_array() };
        std::array::from_fn(|c| if R == 3 { all[c] } else { all[2] })
    }

    /// What the first and the second grains of four contacts receive: a force and the moments on either.
    #[inline(always)]
    pub fn of_four<const D: usize, const R: usize>(
        force: &[Lanes; D],
        [one, two]: &[[Lanes; R]; 2],
    ) -> [[Self; WIDTH]; 2] {
        let zero = Lanes::ZERO;
        let side = |force: [Lanes; WIDTH], moment: [Lanes; WIDTH]| -> [Self; WIDTH] {
            std::array::from_fn(|k| Self { force: force[k], moment: moment[k] })
        };
        if D == 3 {
            let on = Lanes::transpose([force[0], force[1], force[2], zero]);
            let moments = [one, two].map(|of| Lanes::transpose([of[0], of[1], of[2], zero]));
            [side(on, moments[0]), side(on.map(|f| -f), moments[1])]
        } else {
            let none = [zero; WIDTH];
            let one = Lanes::transpose([force[0], force[1], one[0], zero]);
            let two = Lanes::transpose([-force[0], -force[1], two[0], zero]);
            [side(one, none), side(two, none)]
        }
    }
}

/// Forces and moments of all grains, column by column.
pub fn deliver<const D: usize, const R: usize>(
    received: &[Received],
    force: &mut [[f64; D]],
    torque: &mut [[f64; R]],
) {
    use rayon::prelude::*;
    let columns = force.par_chunks_mut(TASK).zip(torque.par_chunks_mut(TASK));
    received.par_chunks(TASK).zip(columns).for_each(|(received, (force, torque))| {
        for ((received, force), torque) in received.iter().zip(force).zip(torque) {
            (*force, *torque) = (received.force(), received.moment());
        }
    });
}

/// How contacts are worked on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// One after another, whatever their law.
    Single,
    /// Four side by side: springs and dashpots; whether some resist rolling or twisting.
    Linear(bool),
    /// Four side by side: elastic spheres; whether some resist rolling or twisting.
    Hertz(bool),
}

impl Way {
    /// For contacts with any of these laws.
    pub fn of(laws: &[Law]) -> Self {
        let plain = |law: &Law| law.attraction.is_none() && law.bond.is_none();
        let turns = laws.iter().any(|law| law.rolling.is_some() || law.twisting.is_some());
        if !laws.iter().all(plain) {
            Self::Single
        } else if laws.iter().all(|law| matches!(law.normal, Normal::Linear(_))) {
            Self::Linear(turns)
        } else if laws.iter().all(|law| matches!(law.normal, Normal::Hertz(_))) {
            Self::Hertz(turns)
        } else {
            Self::Single
        }
    }
}

/// Records of all grains.
pub fn records<const D: usize, const R: usize>(
    grains: Shown<'_, D, R>,
    (velocity, spin): (&[[f64; D]], &[[f64; R]]),
    out: &mut Vec<Record>,
) {
    use rayon::prelude::*;
    let Shown { position, mass, radius, held, .. } = grains;
    out.resize(mass.len(), Record::default());
    out.par_chunks_mut(TASK).enumerate().for_each(|(block, out)| {
        for (i, record) in (block * TASK..).zip(out) {
            let mass = if held[i] { -mass[i] } else { mass[i] };
            let (x, v, w) = (&position[i], &velocity[i], &spin[i]);
            *record = if D == 3 {
                Record {
                    place: Lanes::new([x[0], x[1], x[2], radius[i]]),
                    motion: Lanes::new([v[0], v[1], v[2], mass]),
                    spin: Lanes::new([w[0], w[1], w[2], 0.0]),
                }
            } else {
                Record {
                    place: Lanes::new([x[0], x[1], 0.0, radius[i]]),
                    motion: Lanes::new([v[0], v[1], w[0], mass]),
                    spin: Lanes::ZERO,
                }
            };
        }
    });
}

/// What four grains show.
pub struct Seen<const D: usize, const R: usize> {
    pub place: [Lanes; D],
    pub velocity: [Lanes; D],
    pub spin: [Lanes; R],
    pub mass: Lanes,
    pub radius: Lanes,
}

#[inline(always)]
pub fn seen<const D: usize, const R: usize>(four: [&Record; WIDTH]) -> Seen<D, R> {
    let place = Lanes::transpose(four.map(|record| record.place));
    let motion = Lanes::transpose(four.map(|record| record.motion));
    let spin: [Lanes; R] = if D == 3 {
        let spin = Lanes::transpose(four.map(|record| record.spin));
        std::array::from_fn(|c| spin[c])
    } else {
        [motion[2]; R]
    };
    Seen {
        place: std::array::from_fn(|c| place[c]),
        velocity: std::array::from_fn(|c| motion[c]),
        spin,
        mass: motion[3],
        radius: place[3],
    }
}

/// The laws of four contacts.
#[derive(Clone, Copy)]
pub struct Laws {
    pub linear: Linear<Lanes>,
    pub hertz: Hertz<Lanes>,
    pub clamp: Lanes,
    pub coefficient: Lanes,
    pub at_rest: Lanes,
    /// Where the spring is reset to the force of friction.
    pub spring: Lanes,
    /// Resistance against rolling and twisting, and where there is any.
    pub resistance: [(Resistance<Lanes>, Lanes); 2],
}

impl Laws {
    pub fn of(laws: [&Law; WIDTH]) -> Self {
        let lane = |of: &dyn Fn(&Law) -> f64| Lanes::new(laws.map(of));
        let mask = |of: &dyn Fn(&Law) -> bool| lane(&|law| f64::from(u8::from(of(law)))).simd_gt(Lanes::ZERO);
        let linear = |of: fn(&Linear) -> f64| {
            lane(&|law| if let Normal::Linear(linear) = &law.normal { of(linear) } else { 0.0 })
        };
        let hertz = |of: fn(&Hertz) -> f64| {
            lane(&|law| if let Normal::Hertz(hertz) = &law.normal { of(hertz) } else { 0.0 })
        };
        let resistance = |of: fn(&Law) -> &Option<Resistance>| {
            let part = |part: fn(&Resistance) -> f64| lane(&|law| of(law).as_ref().map_or(0.0, part));
            let all = Resistance {
                friction: part(|own| own.friction),
                stiffness: part(|own| own.stiffness),
                damping_ratio: part(|own| own.damping_ratio),
            };
            (all, mask(&|law| of(law).is_some()))
        };
        Self {
            linear: Linear {
                stiffness: linear(|law| law.stiffness),
                modulus: linear(|law| law.modulus),
                damping_ratio: linear(|law| law.damping_ratio),
                across: linear(|law| law.across),
                damping_ratio_across: linear(|law| law.damping_ratio_across),
            },
            hertz: Hertz {
                modulus: hertz(|law| law.modulus),
                shear_modulus: hertz(|law| law.shear_modulus),
                damping: hertz(|law| law.damping),
                damping_across: hertz(|law| law.damping_across),
            },
            clamp: mask(&|law| law.clamp),
            coefficient: lane(&|law| law.friction.coefficient),
            at_rest: lane(&|law| law.friction.at_rest),
            spring: mask(&|law| law.friction.reset == SpringReset::Spring),
            resistance: [resistance(|law| &law.rolling), resistance(|law| &law.twisting)],
        }
    }
}
