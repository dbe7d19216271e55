//! Update of densities and stresses.

use colluvium_case::{FailureReason, SolverError};
use colluvium_constitutive::{BLOCK_SIZE, BatchError, Mat3, Motion};
use rayon::prelude::*;

use crate::clock::Clock;
use crate::config::ContinuityEquation;
use crate::context::SolverContext;
use crate::points::particles::{Bodies, Derivatives, SquareMatrix};

/// Range of the density over its initial value, outside of which the run ends with an error (sheet: sph §7).
const DENSITY_RANGE: std::ops::Range<f64> = 0.2..5.0;

/// Time of the positions for which a velocity gradient was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StageTime {
    /// Start of the step: `1 + dt L` is its deformation, and a rigid rotation causes no strain.
    Start,
    /// Middle of the step.
    Middle,
}

/// Motion of a particle with the velocity gradient `l` (1/s) with respect to positions at the start of the step; `None` if it is singular.
#[inline(always)]
fn motion_from_start<const D: usize>(
    l: &SquareMatrix<D>,
    dt: f64,
    density: f64,
    volume: f64,
) -> Option<Motion> {
    let size = band_length::<D>(volume);
    let deformation = Mat3(std::array::from_fn(|a| {
        std::array::from_fn(|b| f64::from(u8::from(a == b)) + if a < D && b < D { dt * l[a][b] } else { 0.0 })
    }));
    if D == 3 {
        return Motion::from_deformation(&deformation, dt, density, size);
    }
    // In the plane A = 2 (f - 1)(f + 1)⁻¹ has a closed form.
    let half = |a: usize, b: usize| if a < D && b < D { 0.5 * dt * l[a][b] } else { 0.0 };
    let (a, b, c, d) = (half(0, 0), half(0, 1), half(1, 0), half(1, 1));
    let determinant = (1.0 + a) * (1.0 + d) - b * c;
    if !(determinant.abs() > 1e-12) {
        return None;
    }
    let twice = 2.0 / determinant;
    let (xx, yy) = ((a * (1.0 + d) - b * c) * twice, (d * (1.0 + a) - b * c) * twice);
    let gradient = Mat3([[xx, b * twice, 0.0], [c * twice, yy, 0.0], [0.0; 3]]);
    Some(Motion { deformation, velocity_gradient_dt: gradient, dt, density, size, ..Motion::AT_REST })
}

/// Motion of a particle with the velocity gradient over the positions at the middle of the step.
fn motion_from_middle<const D: usize>(
    l: &SquareMatrix<D>,
    dt: f64,
    density: f64,
    volume: f64,
) -> Option<Motion> {
    let l =
        Mat3(std::array::from_fn(|a| std::array::from_fn(|b| if a < D && b < D { l[a][b] } else { 0.0 })));
    Motion::from_velocity_gradient(&l, dt, density, band_length::<D>(volume))
}

/// Band length of a particle from its volume (m). A crack opens two rows of particles, each of which dissipates half of the fracture energy
/// (sheet: sph §0, fracture).
#[inline(always)]
pub fn band_length<const D: usize>(volume: f64) -> f64 {
    2.0 * match D {
        1 => volume,
        2 => volume.sqrt(),
        _ => volume.cbrt(),
    }
}

/// Factor on the density in a step. The continuity equation gives the divergence over the positions at the start
/// of the step; its difference from that at the middle is the same as for the gradient.
#[inline(always)]
fn density_factor<const D: usize>(l: &SquareMatrix<D>, divergence: f64, dt: f64) -> f64 {
    let square: f64 = (0..D).map(|a| (0..D).map(|b| l[a][b] * l[b][a]).sum::<f64>()).sum();
    // ln det(1 + dt L) = dt tr L - dt²/2 tr L² + …
    (-dt * (divergence - 0.5 * dt * square)).exp()
}

/// Updates densities and stresses at the end of the step (steps 7 and 8).
pub fn update_stress<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &mut Bodies<D>,
    rates: &Derivatives<D>,
    dt: f64,
    over: StageTime,
) -> Result<(), SolverError> {
    let follows = setting.options.continuity != ContinuityEquation::Summation;
    let p = &mut bodies.particles;
    let mut failure = None;
    for group in &mut bodies.groups {
        let range = group.range();
        let blocks = group.states.blocks_mut().par_iter_mut();
        let stress = p.stress[range.clone()].par_chunks_mut(BLOCK_SIZE);
        let density = p.density[range.clone()].par_chunks_mut(BLOCK_SIZE);
        let mass = p.mass[range.clone()].par_chunks(BLOCK_SIZE);
        let gradient = rates.gradient[range.clone()].par_chunks(BLOCK_SIZE);
        let divergence = rates.divergence[range.clone()].par_chunks(BLOCK_SIZE);
        let (material, initial) = (&group.material, group.density);
        let all = blocks.zip(stress).zip(density).zip(mass).zip(gradient).zip(divergence).enumerate();
        let error = all
            .map(|(number, (((((states, stress), density), mass), gradient), divergence))| {
                let mut motions = [Motion::AT_REST; BLOCK_SIZE];
                for k in 0..stress.len() {
                    if follows {
                        density[k] *= match over {
                            StageTime::Start => density_factor(&gradient[k], divergence[k], dt),
                            StageTime::Middle => (-dt * divergence[k]).exp(),
                        };
                    }
                    let here = range.start + number * BLOCK_SIZE + k;
                    if !DENSITY_RANGE.contains(&(density[k] / initial)) {
                        return Some((here, crushed(density[k])));
                    }
                    let volume = mass[k] / density[k];
                    let found = match over {
                        StageTime::Start => motion_from_start(&gradient[k], dt, density[k], volume),
                        StageTime::Middle => motion_from_middle(&gradient[k], dt, density[k], volume),
                    };
                    match found {
                        Some(motion) => motions[k] = motion,
                        None => {
                            return Some((
                                here,
                                FailureReason::coded("crushed", "its deformation in the step is singular"),
                            ));
                        }
                    }
                }
                let updated = material.update(&motions[..stress.len()], stress, states);
                updated.err().map(|error| law_failure(range.start + number * BLOCK_SIZE, error))
            })
            .reduce(|| None, Option::or);
        let name = &setting.case.bodies[group.body as usize].material;
        failure = failure.or(error.map(|(index, reason)| (index, reason.of_material(name))));
    }
    failure.map_or(Ok(()), |(index, reason)| Err(p.particle_error(clock, index, reason)))
}

/// Failure of a particle with a density (kg/m³) out of range.
fn crushed(density: f64) -> FailureReason {
    let problem = format!("its density {density} kg/m³ is outside 0.2 to 5 times the initial density");
    FailureReason::coded("crushed", problem)
}

/// Index and reason of a particle whose law refuses the step, in a block that begins with the particle `first`.
fn law_failure(first: usize, error: BatchError) -> (usize, FailureReason) {
    (first + error.index, error.source.into())
}

/// Returns smoothed stresses that violate the yield criterion to the yield surface, by a step without motion. For time-dependent laws that
/// would add relaxation; their stresses return in the next step with motion.
pub fn return_to_yield<const D: usize>(
    setting: &SolverContext<D>,
    clock: &Clock,
    bodies: &mut Bodies<D>,
    dt: f64,
) -> Result<(), SolverError> {
    let p = &mut bodies.particles;
    let mut failure = None;
    for group in &mut bodies.groups {
        let material = &group.material;
        if !material.is_hypoelastic() || material.is_time_dependent() {
            continue;
        }
        let range = group.range();
        let blocks = group.states.blocks_mut().par_iter_mut();
        let stress = p.stress[range.clone()].par_chunks_mut(BLOCK_SIZE);
        let density = p.density[range.clone()].par_chunks(BLOCK_SIZE);
        let mass = p.mass[range.clone()].par_chunks(BLOCK_SIZE);
        let all = blocks.zip(stress).zip(density).zip(mass).enumerate();
        let error = all
            .map(|(number, (((states, stress), density), mass))| {
                let mut motions = [Motion::AT_REST; BLOCK_SIZE];
                for ((motion, density), mass) in motions.iter_mut().zip(density).zip(mass) {
                    *motion = Motion {
                        dt,
                        density: *density,
                        size: band_length::<D>(mass / density),
                        ..Motion::AT_REST
                    };
                }
                let updated = material.update(&motions[..stress.len()], stress, states);
                updated.err().map(|error| law_failure(range.start + number * BLOCK_SIZE, error))
            })
            .reduce(|| None, Option::or);
        let name = &setting.case.bodies[group.body as usize].material;
        failure = failure.or(error.map(|(index, reason)| (index, reason.of_material(name))));
    }
    failure.map_or(Ok(()), |(index, reason)| Err(p.particle_error(clock, index, reason)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motion_in_the_plane_is_that_of_space() {
        let (l, dt) = ([[0.3, -0.7], [1.1, 0.2]], 0.1);
        let plane = motion_from_start::<2>(&l, dt, 1000.0, 0.25).unwrap();
        let f = Mat3([[1.03, -0.07, 0.0], [0.11, 1.02, 0.0], [0.0, 0.0, 1.0]]);
        let space = Motion::from_deformation(&f, dt, 1000.0, 1.0).unwrap();
        for (a, b) in plane
            .velocity_gradient_dt
            .0
            .as_flattened()
            .iter()
            .zip(space.velocity_gradient_dt.0.as_flattened())
        {
            assert!((a - b).abs() < 1e-15, "{plane:?} {space:?}");
        }
        for (a, b) in plane.deformation.0.as_flattened().iter().zip(space.deformation.0.as_flattened()) {
            assert!((a - b).abs() < 1e-15, "{plane:?} {space:?}");
        }
        let line = motion_from_start::<1>(&[[0.4]], dt, 1000.0, 0.5).unwrap();
        assert!((line.velocity_gradient_dt.0[0][0] - 2.0 * 0.04 / 2.04).abs() < 1e-15);
        let compression = density_factor(&l, 0.5, dt);
        assert!((compression * f.determinant() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_rigid_rotation_causes_no_strain() {
        let (sin, cos) = 0.3f64.sin_cos();
        let turn = motion_from_start::<2>(&[[cos - 1.0, -sin], [sin, cos - 1.0]], 1.0, 1.0, 1.0).unwrap();
        assert!(turn.strain_increment().norm() < 1e-15);
        assert!(motion_from_start::<2>(&[[-20.0, 0.0], [0.0, 0.0]], 0.1, 1.0, 1.0).is_none());
    }
}
