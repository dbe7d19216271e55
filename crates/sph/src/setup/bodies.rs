//! Discretisation of bodies by particles.

use std::ops::Range;

use colluvium_case::bodies::law_points::InitialLawState;
use colluvium_case::description::Body;
use colluvium_case::rigid::{RigidMass, RigidState};
use colluvium_case::{Case, CaseError, spatial};
use colluvium_constitutive::ModelFamily;
use colluvium_points::HalfNeighbourList;

use crate::config::{SoundSpeed, SphOptions};
use crate::context::leading_components;
use crate::points::particles::{ParticleGroup, Particles};
use crate::points::rigid_body::RigidBody;

/// Largest number of particles, limited by the ids.
const MOST_PARTICLES: usize = u32::MAX as usize;

/// Adds the particles of a body, in their initial state.
pub(super) fn add_body<const D: usize>(
    case: &Case,
    options: &SphOptions,
    number: usize,
    body: &Body,
    particles: &mut Particles<D>,
) -> Result<ParticleGroup, CaseError> {
    let path = format!("bodies[{number}]");
    let low: [f64; D] = leading_components(&case.domain.min);
    let listed = case.point_list(number)?;
    let samples = match &listed {
        Some(list) => list.samples(),
        None => case.samples(number, low, options.spacing)?,
    };
    if samples.is_empty() {
        let problem = format!("holds no particle: it is smaller than the spacing of {} m", options.spacing);
        return Err(CaseError::new(format!("{path}.shape"), problem));
    }
    let start = particles.len();
    if start + samples.len() > MOST_PARTICLES {
        return Err(CaseError::new(
            "methods.sph.spacing",
            format!("gives more than {MOST_PARTICLES} particles"),
        ));
    }
    let positions: Vec<[f64; D]> = samples.iter().map(|sample| sample.position).collect();
    check_places(case, &path, &positions)?;
    let spec = &case.materials[&body.material];
    let youngs_modulus = match options.sound_speed {
        SoundSpeed::PWave => None,
        SoundSpeed::YoungsModulus => Some(case.youngs_modulus(&body.material).ok_or_else(|| {
            let problem = format!("material {:?} has no Young's modulus: use p-wave", body.material);
            CaseError::new("methods.sph.sound_speed", problem)
        })?),
    };
    let densities = (0..samples.len()).map(|i| case.density_at(number, listed.as_ref(), i));
    let densities = densities.collect::<Result<Vec<f64>, CaseError>>()?;
    let InitialLawState { material, stress, states } =
        case.initialise_law(number, listed.as_ref(), &positions)?;
    let count = positions.len();
    particles.id.extend(start as u32..(start + count) as u32);
    let history = options.held_history.get(&body.name).cloned();
    let factor = history.as_ref().map_or(1.0, |history| history.at(0.0));
    let own = listed.as_ref().and_then(|list| list.velocities.as_ref());
    if own.is_some() && options.held.contains(&body.name) {
        let problem = "has velocities, but a held body moves with its `velocity`";
        return Err(CaseError::new(format!("{path}.points.file"), problem));
    }
    let velocity = |(point, x): (usize, &[f64; D])| match own {
        Some(velocities) => leading_components::<D>(&velocities[point]),
        None => leading_components::<D>(&body.velocity.at(spatial(x)).map(|v| factor * v)),
    };
    particles.velocity.extend(positions.iter().enumerate().map(velocity));
    particles.mass.extend(samples.iter().zip(&densities).map(|(sample, density)| sample.volume * density));
    particles.density.extend(densities);
    particles.sound.extend(std::iter::repeat_n(0.0, count));
    particles.length.extend(std::iter::repeat_n(options.smoothing_length_value(), count));
    particles.stress.extend(stress);
    particles.origin.extend_from_slice(&positions);
    particles.position.extend(positions);
    let held = options.held.contains(&body.name).then(|| body.velocity.clone());
    let fluid = spec.facts().kind == ModelFamily::Fluid;
    let end = start + count;
    let confined = options.confining.as_ref().is_some_and(|confining| {
        confining.bodies.as_ref().map_or(held.is_none() && !body.rigid, |names| names.contains(&body.name))
    });
    let smooth = options.smooth_bodies.contains(&body.name);
    Ok(ParticleGroup {
        body: number as u32,
        start,
        end,
        material,
        states,
        youngs_modulus,
        density: spec.density(),
        held,
        history,
        factor,
        rigid: body.rigid.then(|| rigid(particles, start..end, options.spacing)),
        smooth,
        confined,
        fluid,
    })
}

/// Returns a rigid body of particles, with their velocities.
fn rigid<const D: usize>(particles: &Particles<D>, range: Range<usize>, spacing: f64) -> RigidBody {
    let Particles { mass, position, velocity, .. } = particles;
    let (masses, positions) = (&mass[range.clone()], &position[range.clone()]);
    let whole = RigidMass::of_points(masses, positions, spacing);
    RigidBody::new(RigidState::of_points(&whole, masses, positions, &velocity[range]))
}

/// Checks that every particle lies in the domain and in no wall.
fn check_places<const D: usize>(case: &Case, path: &str, positions: &[[f64; D]]) -> Result<(), CaseError> {
    let outside = |x: &&[f64; D]| (0..D).any(|c| x[c] < case.domain.min[c] || x[c] > case.domain.max[c]);
    if let Some(x) = positions.iter().find(outside) {
        let problem = format!("the particle at {x:?} m lies outside the domain");
        return Err(CaseError::new(format!("{path}.shape"), problem));
    }
    for (number, boundary) in case.boundaries.iter().enumerate() {
        let (axis, face) = (boundary.side.axis(), boundary.position(&case.domain));
        let sign = if boundary.side.is_max() { -1.0 } else { 1.0 };
        if let Some(x) = positions.iter().find(|x| sign * (x[axis] - face) <= 0.0) {
            let problem = format!("the particle at {x:?} m lies inside the wall boundaries[{number}]");
            return Err(CaseError::new(format!("{path}.shape"), problem));
        }
    }
    Ok(())
}

/// Checks that no two particles coincide.
pub(super) fn check_distances<const D: usize>(
    particles: &Particles<D>,
    options: &SphOptions,
) -> Result<(), CaseError> {
    let mut list = HalfNeighbourList::<D>::new();
    let least = 1e-6 * options.spacing;
    // Search cells must not be much smaller than the spacing.
    list.build(&particles.position, 0.5 * options.spacing)
        .map_err(|error| CaseError::new("bodies", error.to_string()))?;
    let close = |&(i, j): &(u32, u32)| {
        let (a, b) = (&particles.position[i as usize], &particles.position[j as usize]);
        (0..D).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>() < least * least
    };
    match list.pairs().find(close) {
        None => Ok(()),
        Some((i, _)) => {
            let problem = format!(
                "two particles have the same position, {:?} m: check whether bodies overlap",
                particles.position[i as usize]
            );
            Err(CaseError::new("bodies", problem))
        }
    }
}
