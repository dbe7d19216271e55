//! Contacts of grains with planes, side by side.

use wide::f64x4 as Lanes;

use super::push::{Account, Work};
use super::spring_lines;
use crate::contact::{Law, Tally, Touch};
use crate::pairs::MemoriesMut;
use crate::sweep::Scene;
use crate::sweep::side::{Laws, seen};
use crate::vector::{WIDTH, follow, moment, times};

/// A grain that touches a plane.
#[derive(Clone, Copy)]
pub struct AtPlane<'a, const D: usize> {
    /// The grain.
    pub grain: usize,
    /// Place of what the contact remembers.
    pub slot: usize,
    /// Distance of the centre (m), and the normal.
    pub seen: (f64, [f64; D]),
    /// Velocity of the plane (m/s).
    pub velocity: [f64; D],
    /// Its law.
    pub law: &'a Law,
}

/// Force (N) and moments (N m) on a grain: that of the force across, and of resistance.
pub type FromPlane<const D: usize, const R: usize> = ([f64; D], [[f64; R]; 2]);

/// Sums over contacts with planes.
pub struct Planes<const D: usize>(Account<D>);

impl<const D: usize> Default for Planes<D> {
    fn default() -> Self {
        Self(Account::new(Tally::default(), [[0.0; D]; D]))
    }
}

impl<const D: usize> Planes<D> {
    /// The sums of a step of `dt` (s).
    pub fn tally(self, dt: f64) -> Tally {
        self.0.sums(dt).0
    }
}

impl<const D: usize, const R: usize> Scene<'_, D, R> {
    /// Forces of four contacts with planes, whose laws are `common` where that is given.
    pub fn at_planes<const HERTZ: bool, const TURNS: bool>(
        &self,
        four: &[AtPlane<'_, D>; WIDTH],
        common: Option<&Laws>,
        memory: MemoriesMut<'_, R>,
        sums: &mut Planes<D>,
    ) -> [FromPlane<D, R>; WIDTH] {
        let lanes = |of: &dyn Fn(&AtPlane<'_, D>) -> f64| Lanes::new(four.each_ref().map(of));
        let radius = lanes(&|own| self.radius[own.grain]);
        let side = seen(four.each_ref().map(|own| &self.records.1[own.grain]), radius);
        let normal = std::array::from_fn(|c| lanes(&|own| own.seen.1[c]));
        let velocity = std::array::from_fn(|c| lanes(&|own| own.velocity[c]));
        let mass = lanes(&|own| self.mass[own.grain]);
        let distance = lanes(&|own| own.seen.0);
        let (touch, arm) = Touch::against((&side, mass), (distance, &normal), &velocity, self.radii);
        let (dt, slots) = (Lanes::splat(self.dt), four.each_ref().map(|own| own.slot));
        let (slide, dash) = spring_lines(memory.spring, &slots);
        let slide = follow(&slide, &normal, touch.spin * dt);
        let own;
        let laws = if let Some(laws) = common {
            laws
        } else {
            own = Laws::of(four.each_ref().map(|own| own.law));
            &own
        };
        let mut work = Work { received: &mut [], memory, account: sums.0, first: 0 };
        let grains = four.each_ref().map(|own| own.grain as u32);
        let force =
            work.force::<HERTZ>(&touch, (slide, dash), laws, (grains, &slots), (WIDTH, self.lane_steps()));
        let lever: [Lanes; R] = times(-arm, &moment(&normal, &force.across));
        let resisted = if TURNS {
            work.resist(laws, &touch, &force.base, (force.cap, dt), (&slots, force.meets))
        } else {
            [Lanes::ZERO; R]
        };
        sums.0 = work.account;
        std::array::from_fn(|k| {
            let moments = [&lever, &resisted].map(|of| std::array::from_fn(|c| of[c].as_array()[k]));
            (std::array::from_fn(|c| force.on[c].as_array()[k]), moments)
        })
    }
}
