//! SIMD kernel of contacts of grains with planes.

use wide::f64x4 as Lanes;

use crate::contact::contact_histories::ContactHistoriesMut;
use crate::contact::{ContactEnergies, ContactGeometry, PairLaw};
use crate::force_loop::ContactInput;
use crate::force_loop::simd::contact_force::{ContactOutput, ContactSums};
use crate::force_loop::simd::load_springs;
use crate::force_loop::simd_records::{SimdLaws, contact_bodies};
use crate::points::vector::{WIDTH, moment, rotate_with_normal, scaled};

/// Contact of a grain with a plane.
#[derive(Clone, Copy)]
pub struct PlaneContact<'a, const D: usize> {
    /// Number of the grain.
    pub grain: usize,
    /// Index of the contact history.
    pub slot: usize,
    /// Distance of the centre (m), and the normal.
    pub nearest: (f64, [f64; D]),
    /// Velocity of the plane (m/s).
    pub velocity: [f64; D],
    /// Contact law.
    pub law: &'a PairLaw,
}

/// Force (N) and moments on a grain (N m): that of the tangential force, and that of rolling and torsion resistance.
pub type PlaneForce<const D: usize, const R: usize> = ([f64; D], [[f64; R]; 2]);

/// Sums over contacts with planes.
pub struct PlaneSums<const D: usize>(ContactSums<D>);

impl<const D: usize> Default for PlaneSums<D> {
    fn default() -> Self {
        Self(ContactSums::new(ContactEnergies::default(), [[0.0; D]; D]))
    }
}

impl<const D: usize> PlaneSums<D> {
    /// Totals of a step of `dt` (s).
    pub fn energies(self, dt: f64) -> ContactEnergies {
        self.0.sums(dt).0
    }
}

impl<const D: usize, const R: usize> ContactInput<'_, D, R> {
    /// Adds the forces of four contacts with planes; `common` is their contact law, if all have the same.
    pub fn plane_forces<const HERTZ: bool, const TURNS: bool>(
        &self,
        four: &[PlaneContact<'_, D>; WIDTH],
        common: Option<&SimdLaws>,
        history: ContactHistoriesMut<'_, R>,
        sums: &mut PlaneSums<D>,
    ) -> [PlaneForce<D, R>; WIDTH] {
        let lanes = |of: &dyn Fn(&PlaneContact<'_, D>) -> f64| Lanes::new(four.each_ref().map(of));
        let radius = lanes(&|own| self.radius[own.grain]);
        let side = contact_bodies(four.each_ref().map(|own| &self.motions[own.grain]), radius);
        let normal = std::array::from_fn(|c| lanes(&|own| own.nearest.1[c]));
        let velocity = std::array::from_fn(|c| lanes(&|own| own.velocity[c]));
        let mass = lanes(&|own| self.mass[own.grain]);
        let distance = lanes(&|own| own.nearest.0);
        let (geometry, arm) =
            ContactGeometry::with_wall((&side, mass), (distance, &normal), &velocity, self.radii);
        let (dt, slots) = (Lanes::splat(self.dt), four.each_ref().map(|own| own.slot));
        let (shear_displacement, damping_force) = load_springs(history.spring, &slots);
        let shear_displacement = rotate_with_normal(&shear_displacement, &normal, geometry.spin * dt);
        let own;
        let laws = if let Some(laws) = common {
            laws
        } else {
            own = SimdLaws::gather(four.each_ref().map(|own| own.law));
            &own
        };
        let mut work = ContactOutput { forces: &mut [], history, account: sums.0, first: 0 };
        let grains = four.each_ref().map(|own| own.grain as u32);
        let response = work.normal_force::<HERTZ>(&geometry, &laws.normal, &slots, &self.simd_steps());
        let force = work.force::<HERTZ>(
            (&geometry, &response),
            (shear_displacement, damping_force),
            &laws.friction,
            (grains, &slots),
            (WIDTH, dt),
        );
        let lever: [Lanes; R] = scaled(-arm, &moment(&normal, &force.tangential));
        let resisted = if TURNS {
            work.rolling_moments(
                &laws.friction,
                &geometry,
                &response.response,
                (force.cap, dt),
                (&slots, force.in_contact),
            )
        } else {
            [Lanes::ZERO; R]
        };
        sums.0 = work.account;
        std::array::from_fn(|k| {
            let moments = [&lever, &resisted].map(|of| std::array::from_fn(|c| of[c].as_array()[k]));
            (std::array::from_fn(|c| force.force[c].as_array()[k]), moments)
        })
    }
}
