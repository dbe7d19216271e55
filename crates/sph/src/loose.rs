//! Rigid bodies, whose particles keep their places to each other (sheet: sph §2.14, (133), (134), (137)).
//!
//! Their particles act on those of other bodies as particles of their material do, density and stress included. Of the
//! accelerations that come back only what moves the body as a whole is kept, the mean and the turn about the centre of
//! mass, so that pairs give and take the same and momentum is that before. A prescribed component has none.

use colluvium_case::{Case, spatial};
use colluvium_points::parallel::InPieces;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::lanes::set_velocity;
use crate::particles::{Bodies, Particles};
use crate::rates::{Felt, Rates};
use crate::rigid::Rigid;

/// Mass, middle and moment of inertia of particles.
struct Whole<const D: usize> {
    mass: f64,
    centre: [f64; D],
    inertia: f64,
}

/// The vector `spin` × `arm` in the plane; zero elsewhere.
fn turn<const D: usize>(spin: f64, arm: &[f64; D]) -> [f64; D] {
    let mut turned = [0.0; D];
    if D == 2 {
        (turned[0], turned[1]) = (-spin * arm[1], spin * arm[0]);
    }
    turned
}

impl<const D: usize> Whole<D> {
    fn of(p: &Particles<D>, range: &std::ops::Range<usize>) -> Self {
        let mut whole = Self { mass: 0.0, centre: [0.0; D], inertia: 0.0 };
        for i in range.clone() {
            whole.mass += p.mass[i];
            (0..D).for_each(|c| whole.centre[c] += p.mass[i] * p.position[i][c]);
        }
        whole.centre = whole.centre.map(|c| c / whole.mass);
        for i in range.clone() {
            let arm = whole.arm(&p.position[i]);
            whole.inertia += p.mass[i] * arm.iter().map(|a| a * a).sum::<f64>();
        }
        whole
    }

    fn arm(&self, x: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|c| x[c] - self.centre[c])
    }

    /// Sum of a field (per mass) over the particles, and its moment about the centre.
    fn sums(&self, p: &Particles<D>, range: &std::ops::Range<usize>, field: &[[f64; D]]) -> ([f64; D], f64) {
        let (mut sum, mut moment) = ([0.0; D], 0.0);
        for i in range.clone() {
            (0..D).for_each(|c| sum[c] += p.mass[i] * field[i][c]);
            if D == 2 {
                let arm = self.arm(&p.position[i]);
                moment += p.mass[i] * (arm[0] * field[i][1] - arm[1] * field[i][0]);
            }
        }
        (sum, moment)
    }
}

impl<const D: usize> Bodies<D> {
    /// Rigid bodies move in the step of `dt` (s) as the stage says.
    pub fn follow_motions(&mut self, case: &Case, clock: &Clock, dt: f64) {
        for group in &mut self.groups {
            if group.rigid.is_some() {
                group.rigid = Some(Rigid::of(case, group.body, clock, dt));
            }
        }
    }

    /// Gives rigid bodies the velocity of their particles as a whole, or what is prescribed.
    pub fn hold_rigid(&mut self) {
        let p = &mut self.particles;
        for group in &mut self.groups {
            let range = group.range();
            let Some(rigid) = &mut group.rigid else { continue };
            let whole = Whole::of(p, &range);
            let (sum, moment) = whole.sums(p, &range, &p.velocity);
            rigid.spin = if rigid.turns && whole.inertia > 0.0 { moment / whole.inertia } else { 0.0 };
            for i in range {
                let turned = turn(rigid.spin, &whole.arm(&p.position[i]));
                p.velocity[i] =
                    std::array::from_fn(|c| rigid.velocity[c].unwrap_or(sum[c] / whole.mass) + turned[c]);
                set_velocity(&mut self.shown.records[i], &p.velocity[i]);
            }
        }
    }

    /// Takes rigid bodies that have moved along straight lines in a step of `dt` (s) to where they turn.
    pub fn turn_rigid(&mut self, dt: f64) {
        let p = &mut self.particles;
        for group in &self.groups {
            let Some(rigid) = group.rigid.filter(|rigid| rigid.spin != 0.0) else { continue };
            let range = group.range();
            let whole = Whole::of(p, &range);
            let (sum, _) = whole.sums(p, &range, &p.velocity);
            // Along the tangent an arm grows by this factor.
            let longer = (1.0 + (rigid.spin * dt).powi(2)).sqrt();
            let (positions, velocities) = (&mut p.position[range.clone()], &mut p.velocity[range]);
            positions.par_iter_mut().zip(velocities).in_pieces(1, |(x, v)| {
                let arm = whole.arm(x).map(|a| a / longer);
                let turned = turn(rigid.spin, &arm);
                *x = std::array::from_fn(|c| whole.centre[c] + arm[c]);
                *v = std::array::from_fn(|c| sum[c] / whole.mass + turned[c]);
            });
        }
    }

    /// Makes the accelerations of the particles of rigid bodies those of a body, with the forces of the stage, and keeps what is
    /// neither the weight under `gravity` (m/s²) nor a load: the force of the others.
    pub fn stiffen(&self, rates: &mut Rates<D>, gravity: &[f64; D]) {
        let p = &self.particles;
        for group in &self.groups {
            let Some(rigid) = group.rigid else { continue };
            let range = group.range();
            let whole = Whole::of(p, &range);
            let (sum, moment) = whole.sums(p, &range, &rates.of.acceleration);
            let pushed =
                if rates.pushes.is_empty() { [0.0; D] } else { whole.sums(p, &range, &rates.pushes).0 };
            let number = group.body as usize;
            rates.felt.resize(rates.felt.len().max(number + 1), Felt::default());
            rates.felt[number].force =
                spatial(&std::array::from_fn::<f64, D, _>(|c| sum[c] - whole.mass * gravity[c] - pushed[c]));
            let swing = if rigid.turns && whole.inertia > 0.0 {
                (moment + rigid.moment) / whole.inertia
            } else {
                0.0
            };
            let mean: [f64; D] = std::array::from_fn(|c| match rigid.velocity[c] {
                None => (sum[c] + rigid.force[c]) / whole.mass,
                Some(_) => 0.0,
            });
            for i in range {
                let turned = turn(swing, &whole.arm(&p.position[i]));
                rates.of.acceleration[i] = std::array::from_fn(|c| mean[c] + turned[c]);
            }
        }
    }
}
