//! Delayed friction: the normal stress of Coulomb's law with a delay (Prakash & Clifton 1993).
//!
//! Without the delay, the base of a sliding elastic body oscillates along the face (Adams 1995; Ranjith & Rice 2001): waves along it grow,
//! the faster the shorter they are, until the base stops in each oscillation and takes less than its share of the load at rest.

use rayon::prelude::*;

use crate::boundary::flat_wall::WallContact;
use crate::context::SolverContext;
use crate::points::particles::{Bodies, MIN_PARTICLES_PER_TASK, Particles};
use crate::walls::Walls;

/// Delay, in times that a wave takes over a spacing.
const DELAY: f64 = 3.0;

/// Normal pressure for wall friction (Pa): the delayed pressure, limited to twice the current one.
fn friction_pressure(delayed: f64, present: f64) -> f64 {
    if delayed > 0.0 && present > 0.0 { delayed.min(2.0 * present) } else { present }
}

/// Delayed pressure (Pa) after the fraction `share` of the delay. It grows by the part of the present pressure that friction has not used,
/// so that friction uses all of it in the end, if need be in another contact.
fn delayed_pressure(delayed: f64, present: f64, share: f64) -> f64 {
    if delayed == 0.0 {
        present
    } else {
        delayed + share.min(1.0) * (present - friction_pressure(delayed, present))
    }
}

impl<const D: usize> Particles<D> {
    /// Pressure of friction on a face (Pa), where the pressure of particle `i` is `present` (Pa).
    #[inline]
    pub fn friction_pressure(&self, i: usize, present: f64) -> f64 {
        friction_pressure(self.delayed_pressure.get(i).copied().unwrap_or(0.0), present)
    }
}

impl<const D: usize> Walls<D> {
    /// Normal of the closest face with friction at particle `i` within `reach` (m).
    fn frictional_normal(&self, i: usize, x: &[f64; D], reach: f64) -> Option<[f64; D]> {
        let is_frictional = |contact: &WallContact| matches!(contact, WallContact::Friction(_));
        let planes = self.planes.faces.iter().filter(|plane| is_frictional(&plane.contact));
        let planes = planes
            .map(|plane| (plane.distance(x), std::array::from_fn(|c| f64::from(u8::from(c == plane.axis)))));
        let faces = self.obstacles.faces(i).iter().filter(|face| is_frictional(&face.contact));
        let all = planes.chain(faces.map(|face| (face.distance, face.normal)));
        let near = all.filter(|(distance, _)| *distance < reach);
        near.min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, normal)| normal)
    }

    /// Updates the delayed pressures with the pressures at the end of a step of `dt` (s).
    pub fn update_delayed_pressures(&self, setting: &SolverContext<D>, bodies: &mut Bodies<D>, dt: f64) {
        let Particles { delayed_pressure: pressed, position, stress, sound, .. } = &mut bodies.particles;
        let (delay, reach) = (DELAY * setting.options.spacing, setting.smoothing.radius());
        let all = pressed.par_iter_mut().zip(&*position).zip(&*stress).zip(&*sound).enumerate();
        all.with_min_len(MIN_PARTICLES_PER_TASK).for_each(|(i, (((pressed, x), stress), sound))| {
            let across = |n: [f64; D]| -> f64 {
                (0..D).map(|a| (0..D).map(|b| n[a] * stress.component(a, b) * n[b]).sum::<f64>()).sum()
            };
            let present = self.frictional_normal(i, x, reach).map_or(0.0, |n| (-across(n)).max(0.0));
            *pressed = delayed_pressure(*pressed, present, dt * sound / delay);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_pressure_is_the_delayed_pressure_limited_to_twice_the_present_one() {
        let cases =
            [(0.0, 5.0, 5.0), (5.0, -1.0, -1.0), (1.0, 10.0, 1.0), (30.0, 10.0, 20.0), (9.0, 10.0, 9.0)];
        cases.iter().for_each(|(delayed, present, counts)| {
            assert_eq!(friction_pressure(*delayed, *present), *counts);
        });
    }

    /// Contacts of half a delay at intervals of half a delay. The part not yet used by friction is that of one contact, however many there
    /// are: from the eleventh on all is used.
    #[test]
    fn delayed_friction_includes_all_contact_pressure_of_a_bouncing_body() {
        let (mut delayed, mut counts, mut whole) = (0.0, 0.0, 0.0);
        for step in 0..100_000 {
            let phase = f64::from(step % 1000) / 500.0;
            let present = if phase < 1.0 { (std::f64::consts::PI * phase).sin() } else { 0.0 };
            if step >= 10_000 {
                counts += friction_pressure(delayed, present);
                whole += present;
            }
            delayed = delayed_pressure(delayed, present, 1e-3);
        }
        assert!((counts / whole - 1.0).abs() < 0.01, "{counts} of {whole}");
    }
}
