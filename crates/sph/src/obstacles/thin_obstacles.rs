//! Obstacles thinner than the support of a particle: particles on opposite sides are no neighbours, and none passes through
//! in a step.

use colluvium_points::surface::{ContactQuery, NearestPoint, path_enters_solid, solid_blocks_path};

use crate::obstacles::obstacle_faces::ObstacleFaces;
use crate::points::vector_algebra::{dot, square};

/// Largest cosine of the angle between the normals of opposite sides of a thin obstacle, which excludes the corners of boxes.
const MAX_OPPOSITE_COSINE: f64 = -0.5;

/// Depth of the probe for solid below a face (spacings).
const PROBE_DEPTH: f64 = 1e-4;

/// Path of a particle in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ParticlePath<const D: usize> {
    /// Initial position (m).
    pub start: [f64; D],
    /// Final position (m).
    pub end: [f64; D],
    /// Time step (s).
    pub dt: f64,
    /// Spacing of the particles (m).
    pub spacing: f64,
}

impl<const D: usize> ObstacleFaces<D> {
    /// Whether an obstacle is between particle `i` and another position (m). `spacing` is the particle spacing (m).
    pub fn separates(
        &self,
        (i, one): (usize, &[f64; D]),
        (j, other): (Option<usize>, &[f64; D]),
        spacing: f64,
    ) -> bool {
        self.candidates(i).iter().any(|meeting| {
            let surface = self.solids[meeting.solid as usize].current_surface();
            let normal = match j {
                Some(j) => {
                    self.candidates(j).iter().find(|own| own.solid == meeting.solid).map(|own| own.normal)
                }
                None => {
                    let away: [f64; D] = std::array::from_fn(|c| other[c] - one[c]);
                    surface.gap(other, square(&away).sqrt()).map(|gap| gap.normal)
                }
            };
            normal.is_some_and(|normal| dot(&normal, &meeting.normal) < MAX_OPPOSITE_COSINE)
                && solid_blocks_path(surface, one, other, PROBE_DEPTH * spacing)
        })
    }

    /// Contacts of a ball of a radius (m) around the final position of particle `i` with each candidate obstacle. For a particle inside an
    /// obstacle it is the closest surface position within `reach` (m). For one that has crossed an obstacle it is the crossing point.
    pub(crate) fn contacts_on_path(
        &self,
        i: usize,
        path: &ParticlePath<D>,
        (radius, reach): (f64, f64),
        found: &mut ContactQuery<D>,
        mut visit: impl FnMut(&NearestPoint<D>, u32),
    ) {
        for meeting in self.candidates(i) {
            let surface = self.solids[meeting.solid as usize].current_surface();
            found.clear();
            surface.query_contacts(&path.end, radius, found);
            let inside = if found.is_empty() { surface.gap(&path.end, reach) } else { None };
            let through = self.crossing(meeting.solid, path, reach);
            let faces = |place: &&NearestPoint<D>| {
                through.is_none_or(|through| dot(&place.normal, &through.normal) > 0.0)
            };
            let mut any = false;
            for place in found.contacts().iter().chain(inside.as_ref()).filter(faces) {
                any |= place.distance < radius;
                visit(place, meeting.solid);
            }
            if let Some(place) = through.filter(|_| !any) {
                visit(&place, meeting.solid);
            }
        }
    }

    /// Position at which the path of a particle crosses the surface of obstacle `number`, in the frame of the obstacle; `None` without a
    /// crossing.
    fn crossing(&self, number: u32, path: &ParticlePath<D>, reach: f64) -> Option<NearestPoint<D>> {
        let solid = &self.solids[number as usize];
        let (surface, course) = (solid.current_surface(), solid.velocity_at(&path.end));
        let from = std::array::from_fn(|c| path.start[c] + path.dt * course[c]);
        let goes = std::array::from_fn(|c| path.end[c] - from[c]);
        let now = surface.gap(&from, reach)?;
        path_enters_solid(surface, &from, &goes, &now, PROBE_DEPTH * path.spacing)
    }
}
