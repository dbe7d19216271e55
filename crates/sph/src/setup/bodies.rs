//! Discretisation of bodies by particles.

use std::ops::Range;

use colluvium_case::bodies::law_points::InitialLawState;
use colluvium_case::description::Body;
use colluvium_case::rigid::{RigidMass, RigidState};
use colluvium_case::{Case, CaseError, PointList, spatial};
use colluvium_constitutive::ModelFamily;
use colluvium_points::HalfNeighbourList;

use crate::config::{SoundSpeed, SphOptions};
use crate::context::leading_components;
use crate::points::particles::{ParticleGroup, Particles};
use crate::points::rigid_body::RigidBody;
use colluvium_case::CaseErrorKind;

/// Largest number of particles, limited by the ids.
const MAX_PARTICLES: usize = u32::MAX as usize;

/// Adds the particles of body `number` in their initial state, with ids from `first_id` on; `listed` are those of a list.
pub(super) fn add_body<const D: usize>(
    case: &Case,
    options: &SphOptions,
    (number, listed): (usize, Option<&PointList>),
    first_id: u32,
    particles: &mut Particles<D>,
) -> Result<ParticleGroup, CaseError> {
    let (body, path) = (&case.bodies[number], format!("bodies[{number}]"));
    let low: [f64; D] = leading_components(&case.domain.min);
    let samples = match listed {
        Some(list) => list.samples(),
        None => case.samples(number, low, options.spacing)?,
    };
    let (start, count) = (particles.len(), samples.len());
    check_count(options, &path, first_id as usize, count)?;
    let positions: Vec<[f64; D]> = samples.iter().map(|sample| sample.position).collect();
    check_places(case, &path, &positions)?;
    let spec = &case.materials[&body.material];
    let youngs_modulus = youngs_modulus_of_speed(case, options, body)?;
    let densities = (0..count).map(|i| case.density_at(number, listed, i));
    let densities = densities.collect::<Result<Vec<f64>, CaseError>>()?;
    let InitialLawState { material, stress, states } = case.initialise_law(number, listed, &positions)?;
    particles.id.extend(first_id..first_id + count as u32);
    let history = options.held_history.get(&body.name).cloned();
    let factor = history.as_ref().map_or(1.0, |history| history.factor_at(0.0));
    let velocities = initial_velocities(options, body, &path, (listed, factor), &positions)?;
    particles.velocity.extend(velocities);
    particles.mass.extend(samples.iter().zip(&densities).map(|(sample, density)| sample.volume * density));
    particles.density.extend(densities);
    particles.sound.extend(std::iter::repeat_n(0.0, count));
    particles.length.extend(std::iter::repeat_n(options.smoothing_length_value(), count));
    particles.stress.extend(stress);
    particles.origin.extend_from_slice(&positions);
    particles.position.extend(positions);
    let end = start + count;
    Ok(ParticleGroup {
        body: number as u32,
        start,
        end,
        material,
        states,
        youngs_modulus,
        density: spec.density(),
        prescribed_velocity: options.held.contains(&body.name).then(|| body.velocity.clone()),
        history,
        factor,
        program_velocity: None,
        rigid: body.rigid.then(|| rigid(particles, start..end, options.spacing)),
        is_smooth: options.smooth_bodies.contains(&body.name),
        is_confined: is_confined(options, body),
        fluid: spec.model_info().kind == ModelFamily::Fluid,
    })
}

/// Initial velocities of the particles of a body (m/s): those of its file, or that of the body with its time history.
fn initial_velocities<const D: usize>(
    options: &SphOptions,
    body: &Body,
    path: &str,
    (listed, factor): (Option<&PointList>, f64),
    positions: &[[f64; D]],
) -> Result<Vec<[f64; D]>, CaseError> {
    let own = listed.and_then(|list| list.velocities.as_ref());
    if own.is_some() && options.held.contains(&body.name) {
        let problem = "has velocities, but a held body moves with its `velocity`";
        return Err(CaseError::new(format!("{path}.points.file"), problem));
    }
    let velocity = |(point, x): (usize, &[f64; D])| match own {
        Some(velocities) => leading_components::<D>(&velocities[point]),
        None => leading_components::<D>(&body.velocity.velocity_at(spatial(x)).map(|v| factor * v)),
    };
    Ok(positions.iter().enumerate().map(velocity).collect())
}

/// Checks the number of particles of a body, after `start` particles of other bodies.
fn check_count(options: &SphOptions, path: &str, start: usize, count: usize) -> Result<(), CaseError> {
    if count == 0 {
        let problem = format!("holds no particle: it is smaller than the spacing of {} m", options.spacing);
        return Err(CaseError::new(format!("{path}.shape"), CaseErrorKind::coded("empty-body", problem)));
    }
    if start + count > MAX_PARTICLES {
        let problem =
            CaseErrorKind::coded("too-many-points", format!("gives more than {MAX_PARTICLES} particles"));
        return Err(CaseError::new("methods.sph.spacing", problem));
    }
    Ok(())
}

/// Young's modulus for the speed of sound of a body (Pa); `None` if it follows from the wave modulus.
fn youngs_modulus_of_speed(case: &Case, options: &SphOptions, body: &Body) -> Result<Option<f64>, CaseError> {
    if options.sound_speed == SoundSpeed::PWave {
        return Ok(None);
    }
    let modulus = case.youngs_modulus(&body.material).ok_or_else(|| {
        let problem = format!("material {:?} has no Young's modulus: use p-wave", body.material);
        CaseError::new("methods.sph.sound_speed", problem)
    })?;
    Ok(Some(modulus))
}

/// Whether the confining pressure acts on a body: one that the case names, or by default any without prescribed motion and not rigid.
fn is_confined(options: &SphOptions, body: &Body) -> bool {
    let by_default = || !options.held.contains(&body.name) && !body.rigid;
    options.confining.as_ref().is_some_and(|confining| {
        confining.bodies.as_ref().map_or_else(by_default, |names| names.contains(&body.name))
    })
}

/// Returns a rigid body of particles, with their velocities.
fn rigid<const D: usize>(particles: &Particles<D>, range: Range<usize>, spacing: f64) -> RigidBody {
    let Particles { mass, position, velocity, .. } = particles;
    let (masses, positions) = (&mass[range.clone()], &position[range.clone()]);
    let whole = RigidMass::of_points(masses, positions, spacing);
    RigidBody::new(RigidState::of_points(&whole, masses, positions, &velocity[range]))
}

/// Checks that all particles are in the domain and outside walls.
fn check_places<const D: usize>(case: &Case, path: &str, positions: &[[f64; D]]) -> Result<(), CaseError> {
    let outside = |x: &&[f64; D]| (0..D).any(|c| x[c] < case.domain.min[c] || x[c] > case.domain.max[c]);
    if let Some(x) = positions.iter().find(outside) {
        let problem = format!("the particle at {x:?} m lies outside the domain");
        return Err(CaseError::new(format!("{path}.shape"), CaseErrorKind::coded("outside-domain", problem)));
    }
    for (number, boundary) in case.boundaries.iter().enumerate() {
        let (axis, face) = (boundary.side.axis(), boundary.wall_coordinate(&case.domain));
        let sign = if boundary.side.is_max() { -1.0 } else { 1.0 };
        if let Some(x) = positions.iter().find(|x| sign * (x[axis] - face) <= 0.0) {
            let problem = format!("the particle at {x:?} m lies inside the wall boundaries[{number}]");
            return Err(CaseError::new(
                format!("{path}.shape"),
                CaseErrorKind::coded("outside-domain", problem),
            ));
        }
    }
    Ok(())
}

/// Checks that no two particles coincide.
pub(super) fn check_distances<const D: usize>(
    position: &[[f64; D]],
    options: &SphOptions,
) -> Result<(), CaseError> {
    let mut list = HalfNeighbourList::<D>::new();
    let smallest = 1e-6 * options.spacing;
    // Search cells must not be much smaller than the spacing.
    list.build(position, 0.5 * options.spacing)
        .map_err(|error| CaseError::new("bodies", CaseErrorKind::coded(error.code(), error.to_string())))?;
    let close = |&(i, j): &(u32, u32)| {
        let (a, b) = (&position[i as usize], &position[j as usize]);
        (0..D).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>() < smallest * smallest
    };
    match list.pairs().find(close) {
        None => Ok(()),
        Some((i, _)) => {
            let problem = CaseErrorKind::coded(
                "overlap",
                format!(
                    "two particles have the same position, {:?} m: check whether bodies overlap",
                    position[i as usize]
                ),
            );
            Err(CaseError::new("bodies", problem))
        }
    }
}
