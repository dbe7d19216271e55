//! Loads on the surface of bodies, carried by points (sheet: mpm §2.11).
//!
//! The case finds the load vectors of the outermost points, for any method (`colluvium_case::loads::load_vectors`).

use std::ops::Range;

use colluvium_case::description::Load;
use colluvium_case::loads::load_vectors::nanson;
use colluvium_case::{Case, CaseError, CaseErrorKind, Manufactured, spatial};
use colluvium_constitutive::BLOCK_SIZE;
use colluvium_grid::{InterpolatedMotion, Mesh, PointSlice};

use crate::background_grid::BackgroundGrid;
use crate::boundary::mesh_loads;
use crate::clock::Clock;
use crate::momentum::velocity_fields::{VelocityFields, VelocitySource};
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;
use crate::points::surface_load::SurfaceLoad;

/// Factor of load `number` at `time` (s), with the start times of the loads `starts` (s).
pub fn factor(case: &Case, number: usize, starts: &[f64], time: f64) -> f64 {
    case.loads[number].factor(time - starts[number])
}

/// Point set of the loaded body of load `number`.
pub fn loaded_set<const D: usize>(
    case: &Case,
    number: usize,
    sets: &[PointSet<D>],
) -> Result<usize, CaseError> {
    let body = case.loads[number].body();
    sets.iter().position(|set| case.bodies[set.body as usize].name == body).ok_or_else(|| {
        CaseError::new(format!("loads[{number}].body"), CaseErrorKind::other_name(body, "a body"))
    })
}

/// Area of the domain of each point of a lattice on the loaded surface (m²; m in the plane, per radian in axisymmetry), times the relative
/// load at its position. It is zero for interior points.
pub fn loaded_areas<const D: usize>(case: &Case, load: &Load, set: &PointSet<D>) -> Vec<f64> {
    load.loaded_side()
        .map_or(Vec::new(), |side| case.side_areas(load, side, &set.points.position, &set.extent))
}

/// Adds load `number` to the outermost layer of points at the loaded surface (sheet: mpm §2.11).
pub fn apply<const D: usize>(
    case: &Case,
    number: usize,
    mesh: &Mesh<D>,
    sets: &mut [PointSet<D>],
) -> Result<(), CaseError> {
    let load = &case.loads[number];
    let set = &mut sets[loaded_set(case, number, sets)?];
    let carried = if mesh.is_empty() || load.loaded_side().is_none() {
        case.load_vectors(number, &set.points.position, &set.extent)?
    } else {
        let per_area = load.per_area::<D>();
        mesh_loads::loaded_areas(case, number, mesh, set)?
            .into_iter()
            .map(|area| per_area.map(|t| t * area))
            .collect()
    };
    set.loads.push(SurfaceLoad {
        number,
        liquid: load.is_of_fluid(),
        is_follower: load.is_follower(),
        vectors: carried,
        applied_factor: f64::NAN,
    });
    set.points.traction.resize(set.points.position.len(), [0.0; D]);
    if let Some(pore) = &mut set.pore {
        pore.points.traction.resize(set.points.position.len(), [0.0; D]);
    }
    Ok(())
}

impl<const D: usize> PointSet<D> {
    /// Adds the forces of all loads of the set at `time` to its points; `starts` are the start times of the loads (s).
    fn apply_loads(&mut self, case: &Case, starts: &[f64], time: f64) {
        let factor = |load: &SurfaceLoad<D>| factor(case, load.number, starts, time);
        if self.loads.iter().all(|load| !load.is_follower && load.applied_factor == factor(load)) {
            return;
        }
        self.points.traction.fill([0.0; D]);
        if let Some(pore) = &mut self.pore {
            pore.points.traction.fill([0.0; D]);
        }
        for load in &mut self.loads {
            load.applied_factor = factor(load);
            let forces = match &mut self.pore {
                Some(pore) if load.liquid => &mut pore.points.traction,
                _ => &mut self.points.traction,
            };
            let of_case = &case.loads[load.number];
            for (sum, carried) in forces.iter_mut().zip(&load.vectors) {
                let force = of_case.force(carried);
                for c in 0..D {
                    sum[c] += load.applied_factor * force[c];
                }
            }
        }
    }
}

/// Sets the load forces of all points to those at the end of the step.
pub fn apply_loads<const D: usize>(clock: &Clock, bodies: &mut Bodies<D>, starts: &[f64]) {
    for set in bodies.sets.iter_mut().filter(|set| !set.loads.is_empty()) {
        set.apply_loads(&clock.case, starts, clock.time + clock.dt);
    }
}

/// Sets the forces of the points to the body forces of a manufactured solution in a step that starts at `time` (s).
pub fn set_manufactured_forces<const D: usize>(solution: &Manufactured, bodies: &mut Bodies<D>, time: f64) {
    for set in &mut bodies.sets {
        for p in 0..set.len() {
            let force = (solution.force)(spatial(&set.points.origin[p]), time);
            set.points.traction[p] = std::array::from_fn(|c| set.points.mass[p] * force[c]);
        }
    }
}

/// Rotates and stretches the vectors of follower loads with the interpolated motion of the nodes, before the points move.
pub fn update_follower_vectors<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    read: &GridReader<'_, D>,
) {
    if !bodies.sets.iter().any(|set| set.loads.iter().any(|load| load.is_follower)) {
        return;
    }
    let dt = clock.dt;
    let mut all = [InterpolatedMotion::ZERO; BLOCK_SIZE];
    for set in &mut bodies.sets {
        let points =
            PointSlice { position: &set.points.position, domain: set.domain.as_slice(), extent: &set.extent };
        for load in set.loads.iter_mut().filter(|load| load.is_follower) {
            for run in loaded_ranges(&load.vectors) {
                let (points, reads) = (points.range(run.clone()), &mut all[..run.len()]);
                read(set.field, &points, reads);
                let vectors = load.vectors[run].iter_mut();
                for ((vector, motion), position) in vectors.zip(&*reads).zip(points.position) {
                    let step: [[f64; D]; D] = std::array::from_fn(|i| {
                        std::array::from_fn(|j| dt * motion.gradient[j].as_array()[i])
                    });
                    // In axisymmetry the circumference of the point's circle grows.
                    let hoop = if background.axisymmetric {
                        dt * motion.velocity.as_array()[0] / position[0]
                    } else {
                        0.0
                    };
                    *vector = nanson(&step, vector).map(|c| c * (1.0 + hoop));
                }
            }
        }
    }
}

/// Updates follower loads with the motion of the nodes of one phase.
pub fn update_follower_loads<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    (nodes, read): (&VelocityFields, VelocitySource),
) {
    update_follower_vectors(clock, background, bodies, &|field, points, reads| {
        nodes.g2p(read, background, field, points, reads);
    });
}

/// Interpolates the motion of the points of a velocity field from the nodes.
type GridReader<'a, const D: usize> = dyn Fn(usize, &PointSlice<'_, D>, &mut [InterpolatedMotion<D>]) + 'a;

/// Ranges of points with a load, of at most [`BLOCK`] points each.
fn loaded_ranges<const D: usize>(vectors: &[[f64; D]]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for p in (0..vectors.len()).filter(|p| vectors[*p] != [0.0; D]) {
        match runs.last_mut() {
            Some(run) if run.end == p && run.len() < BLOCK_SIZE => run.end += 1,
            _ => runs.push(p..p + 1),
        }
    }
    runs
}
