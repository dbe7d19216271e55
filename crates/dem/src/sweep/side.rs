//! What contacts side by side see: records of the grains, and their laws.

use wide::f64x4 as Lanes;

use crate::config::SpringReset;
use crate::contact::hertz::Hertz;
use crate::contact::linear::Linear;
use crate::contact::{Law, Normal};
use crate::grains::{Shown, TASK};

/// Contacts side by side.
pub const WIDTH: usize = 4;

/// What a grain shows its contacts, a line of cache: velocity, spin, mass (negative where it is held) and radius.
pub type Record = [[f64; WIDTH]; 2];

/// How contacts are worked on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// One after another, whatever their law.
    Single,
    /// Four side by side: springs and dashpots.
    Linear,
    /// Four side by side: elastic spheres.
    Hertz,
}

impl Way {
    /// For contacts with any of these laws.
    pub fn of(laws: &[Law]) -> Self {
        let plain = |law: &Law| {
            law.rolling.is_none() && law.twisting.is_none() && law.attraction.is_none() && law.bond.is_none()
        };
        if !laws.iter().all(plain) {
            Self::Single
        } else if laws.iter().all(|law| matches!(law.normal, Normal::Linear(_))) {
            Self::Linear
        } else if laws.iter().all(|law| matches!(law.normal, Normal::Hertz(_))) {
            Self::Hertz
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
    let Shown { mass, radius, held, .. } = grains;
    out.resize(mass.len(), Record::default());
    out.par_chunks_mut(TASK).enumerate().for_each(|(block, out)| {
        for (i, record) in (block * TASK..).zip(out) {
            let mass = if held[i] { -mass[i] } else { mass[i] };
            let (v, w) = (&velocity[i], &spin[i]);
            *record = if D == 3 {
                [[v[0], v[1], v[2], mass], [w[0], w[1], w[2], radius[i]]]
            } else {
                [[v[0], v[1], w[0], mass], [radius[i], 0.0, 0.0, 0.0]]
            };
        }
    });
}

/// What four grains show.
pub struct Seen<const D: usize, const R: usize> {
    pub velocity: [Lanes; D],
    pub spin: [Lanes; R],
    pub mass: Lanes,
    pub radius: Lanes,
}

#[inline(always)]
pub fn seen<const D: usize, const R: usize>([a, b, c, d]: [&Record; WIDTH]) -> Seen<D, R> {
    let lane = |row: usize, k: usize| Lanes::new([a[row][k], b[row][k], c[row][k], d[row][k]]);
    let (spin, radius) = if D == 3 { ((1, 0), (1, 3)) } else { ((0, 2), (1, 0)) };
    Seen {
        velocity: std::array::from_fn(|c| lane(0, c)),
        spin: std::array::from_fn(|c| lane(spin.0, spin.1 + c)),
        mass: lane(0, 3),
        radius: lane(radius.0, radius.1),
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
        }
    }
}
