//! SIMD time integration of grains under contact forces and gravity only, four at once (sheet: dem §3.4).

use std::ops::Range;

use wide::f64x4 as Lanes;

use crate::momentum::time_integration::{ExternalActions, GrainSums, LeapfrogKick};
use crate::points::grains::inertia;
use crate::points::vector::dot;

/// Data of a range of grains that are constant in a step.
pub(crate) struct GrainBlock<'a, const D: usize, const R: usize> {
    /// Number of the first grain.
    pub(crate) first: usize,
    /// Radius of each grain (m).
    pub(crate) radius: &'a [f64],
    /// Mass of each grain (kg).
    pub(crate) mass: &'a [f64],
    /// Force on each grain (N).
    pub(crate) force: &'a [[f64; D]],
    /// Moment on each grain (N m).
    pub(crate) torque: &'a [[f64; R]],
    /// Position of each grain when the neighbour lists were built (m).
    pub(crate) listed_position: &'a [[f64; D]],
}

/// Number of grains that are integrated together.
const SIMD_GRAINS: usize = 4;

/// Entries `4 c` to `4 c + 3` of the components of four grains, `N` each: the number of the grain of each entry.
#[inline(always)]
fn repeat_per_grain<const N: usize>(numbers: Lanes, c: usize) -> Lanes {
    let numbers = numbers.to_array();
    Lanes::new(std::array::from_fn(|k| numbers[(SIMD_GRAINS * c + k) / N]))
}

/// Entries `4 c` to `4 c + 3` of a column.
#[inline(always)]
fn entries(column: &[f64], c: usize) -> Lanes {
    let own = &column[SIMD_GRAINS * c..][..SIMD_GRAINS];
    Lanes::new([own[0], own[1], own[2], own[3]])
}

/// Sums over the components of each of four grains, stored grain by grain.
#[inline(always)]
fn sum_by_grain<const D: usize>(parts: &[Lanes; D]) -> Lanes {
    let mut sum = Lanes::ZERO;
    for axis in 0..D {
        sum += Lanes::new(std::array::from_fn(|grain| {
            let entry = D * grain + axis;
            parts[entry / SIMD_GRAINS].as_array()[entry % SIMD_GRAINS]
        }));
    }
    sum
}

/// Sum of the four lanes.
fn sum_lanes(lanes: Lanes) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    (a + b) + (c + d)
}

/// Index of the first grain with a position or velocity that is not finite, else of the first grain.
fn first_not_finite<const D: usize>(position: &[[f64; D]], velocity: &[[f64; D]]) -> usize {
    let mut sizes = position.iter().zip(velocity).map(|(x, v)| dot(x, x) + dot(v, v));
    sizes.position(|size| !size.is_finite()).unwrap_or(0)
}

/// Largest of the four lanes, at least zero.
fn largest_lane(lanes: Lanes) -> f64 {
    lanes.to_array().into_iter().fold(0.0, f64::max)
}

impl<const D: usize, const R: usize> GrainBlock<'_, D, R> {
    /// Advances the spins of the grains `own`, from their moments and moments of inertia. Adds twice the kinetic energy of their rotations
    /// to `rotation`.
    #[inline(always)]
    fn integrate_spins(
        &self,
        kick: &LeapfrogKick,
        (inertia, per_inertia): (Lanes, Lanes),
        (spin, own): (&mut [[f64; R]], Range<usize>),
        rotation: &mut Lanes,
    ) {
        let (w, torques) = (spin.as_flattened_mut(), self.torque[own].as_flattened());
        for c in 0..R {
            let old = entries(w, c);
            let new = kick.damping_factor * old
                + kick.force_time * entries(torques, c) * repeat_per_grain::<R>(per_inertia, c);
            let now = old + kick.share_before * (new - old);
            *rotation += repeat_per_grain::<R>(inertia, c) * now * now;
            w[SIMD_GRAINS * c..][..SIMD_GRAINS].copy_from_slice(new.as_array());
        }
    }

    /// Integrates the motion of grains four at a time, with the same results as `Grain::advance`. Returns the number of integrated grains;
    /// up to three at the end remain.
    pub(crate) fn integrate(
        &self,
        (actions, kick): (&ExternalActions<'_, D>, &LeapfrogKick),
        position: &mut [[f64; D]],
        velocity: &mut [[f64; D]],
        spin: &mut [[f64; R]],
        sums: &mut GrainSums<D>,
    ) -> usize {
        let count = position.len() / SIMD_GRAINS * SIMD_GRAINS;
        let gravity: [Lanes; D] = std::array::from_fn(|c| {
            Lanes::new(std::array::from_fn(|k| actions.gravity[(SIMD_GRAINS * c + k) % D]))
        });
        let [mut kinetic, mut rotation, mut work, mut squares, mut places] = [Lanes::ZERO; 5];
        let [mut fastest, mut moved] = [Lanes::ZERO; 2];
        for first in (0..count).step_by(SIMD_GRAINS) {
            let own = first..first + SIMD_GRAINS;
            let (mass, radius) = (entries(&self.mass[own.clone()], 0), entries(&self.radius[own.clone()], 0));
            let inertia = Lanes::splat(inertia(D)) * mass * radius * radius;
            let (per_mass, per_inertia) = (Lanes::ONE / mass, Lanes::ONE / inertia);
            let (mut speeds, mut displacements) = ([Lanes::ZERO; D], [Lanes::ZERO; D]);
            let (x, v) = (position[own.clone()].as_flattened_mut(), velocity[own.clone()].as_flattened_mut());
            let (forces, listed) =
                (self.force[own.clone()].as_flattened(), self.listed_position[own.clone()].as_flattened());
            for c in 0..D {
                let old = entries(v, c);
                let mass = repeat_per_grain::<D>(mass, c);
                let weight = mass * gravity[c];
                let force = entries(forces, c) + weight;
                let new =
                    kick.damping_factor * old + kick.force_time * force * repeat_per_grain::<D>(per_mass, c);
                let now = old + kick.share_before * (new - old);
                let place = entries(x, c) + new * actions.dt;
                let displacement = place - entries(listed, c);
                squares += force * force;
                work += weight * now;
                kinetic += mass * now * now;
                places += place * place;
                (speeds[c], displacements[c]) = (old * old, displacement * displacement);
                x[SIMD_GRAINS * c..][..SIMD_GRAINS].copy_from_slice(place.as_array());
                v[SIMD_GRAINS * c..][..SIMD_GRAINS].copy_from_slice(new.as_array());
            }
            (fastest, moved) =
                (fastest.fast_max(sum_by_grain(&speeds)), moved.fast_max(sum_by_grain(&displacements)));
            let spins = (&mut spin[own.clone()], own);
            self.integrate_spins(kick, (inertia, per_inertia), spins, &mut rotation);
        }
        sums.kinetic += 0.5 * sum_lanes(kinetic);
        sums.rotation += 0.5 * sum_lanes(rotation);
        sums.gravity += sum_lanes(work) * kick.time;
        sums.squares += sum_lanes(squares);
        sums.max_speed_squared = sums.max_speed_squared.max(largest_lane(fastest));
        sums.max_travel_squared = sums.max_travel_squared.max(largest_lane(moved));
        if !(sums.kinetic + sum_lanes(places)).is_finite() {
            sums.not_finite = Some((self.first + first_not_finite(position, velocity)) as u32);
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use crate::config::DampingForm;
    use crate::momentum::time_integration::{ExternalActions, GrainSums, integrate_grains};
    use crate::points::grains::Grains;

    /// Grains of several sizes with velocities, spins and forces; those of the second block are held in part.
    fn grains<const D: usize, const R: usize>() -> Grains<D, R> {
        let mut grains = Grains::default();
        let wave = |k: usize| (k as f64 * 0.7).sin();
        for k in 0..1500 {
            grains.push(0, 0, std::array::from_fn(|c| wave(3 * k + c)), 0.01 + 0.005 * wave(k), 2600.0);
            grains.velocity[k] = std::array::from_fn(|c| wave(5 * k + c));
            grains.spin[k] = std::array::from_fn(|c| wave(7 * k + c));
            grains.force[k] = std::array::from_fn(|c| wave(11 * k + c));
            grains.torque[k] = std::array::from_fn(|c| 0.01 * wave(13 * k + c));
            grains.is_held[k] = k > 1400;
        }
        grains
    }

    /// Actions of gravity and applied forces, without damping.
    fn drive<const D: usize>(applied_force: &[[f64; D]]) -> ExternalActions<'_, D> {
        ExternalActions {
            dt: 1e-4,
            last_step: 0.9e-4,
            gravity: std::array::from_fn(|c| 1.0 - 5.0 * c as f64),
            applied_force,
            damping: [0.0; 3],
            form: DampingForm::Components,
            viscous: 0.0,
            rate: None,
            cell_map: None,
            gradient_change: None,
        }
    }

    fn moved_grains<const D: usize, const R: usize>(applied: &[[f64; D]]) -> (Grains<D, R>, GrainSums<D>) {
        let mut grains = grains::<D, R>();
        let sums = integrate_grains(&mut grains, &drive(applied), &mut Vec::new());
        (grains, sums)
    }

    fn compare<const D: usize, const R: usize>() {
        // Zero applied forces select the scalar path.
        let (together, own) = moved_grains::<D, R>(&[]);
        let (apart, other) = moved_grains::<D, R>(&[[0.0; D]; 1500]);
        assert_eq!(together, apart);
        assert_eq!(
            (own.max_speed_squared, own.max_travel_squared, own.not_finite),
            (other.max_speed_squared, other.max_travel_squared, None)
        );
        for (one, two) in [
            (own.kinetic, other.kinetic),
            (own.rotation, other.rotation),
            (own.gravity, other.gravity),
            (own.squares, other.squares),
            (own.held_work, other.held_work),
        ] {
            assert!((one - two).abs() < 1e-12 * two.abs(), "{one} {two}");
        }
    }

    #[test]
    fn simd_integration_of_grains_equals_scalar_integration() {
        compare::<2, 1>();
        compare::<3, 3>();
    }

    #[test]
    fn a_grain_with_non_finite_force_is_reported_by_its_index() {
        let mut grains = grains::<3, 3>();
        grains.force[1030] = [f64::NAN; 3];
        grains.is_held.fill(false);
        assert_eq!(integrate_grains(&mut grains, &drive(&[]), &mut Vec::new()).not_finite, Some(1030));
    }
}
