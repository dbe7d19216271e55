//! Obstacles: rigid geometry of any shape, for each particle the half spaces behind the nearby faces (sheet: sph §2.13).
//!
//! Behind a face there are the dummy sites of a wall of particles: layers half a spacing behind it and then a spacing apart, along a
//! lattice through the foot point of the particle. They are not stored: a raster needs no wall particles, and a face may have any slope. At
//! an inner corner of two faces the nearer one has the sites behind both.

use std::sync::Arc;

use colluvium_case::description::ObstacleWall;
use colluvium_case::rigid::ObstacleContact;
use colluvium_case::{Case, CaseError, MovingObstacle, ObstacleLaws, PlacedObstacle};
use colluvium_points::surface::{ContactQuery, NearestPoint};
use colluvium_points::{BLOCK_POINTS, Surface};
use rayon::prelude::*;

use crate::boundary::flat_wall::WallContact;
use crate::context::leading_components;
use crate::points::vector_algebra::dot;

/// Tangent plane of an obstacle close to a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObstacleFace<const D: usize> {
    /// Unit normal out of the solid.
    pub normal: [f64; D],
    /// Distance of the particle from the face (m); zero for a particle inside the obstacle.
    pub distance: f64,
    /// Contact condition along the face.
    pub contact: WallContact,
    /// Adhesion (Pa): shear strength beside friction in compression.
    pub adhesion: f64,
    /// Whether material may separate.
    pub allows_separation: bool,
    /// Index of the obstacle.
    pub obstacle: u32,
    /// Velocity of the obstacle, as a rigid body, at the particle (m/s).
    pub velocity: [f64; D],
}

/// Position of a dummy wall particle behind a face.
#[derive(Clone, Copy, Debug)]
pub struct DummySite<'a, const D: usize> {
    /// Face behind which the position is.
    pub face: &'a ObstacleFace<D>,
    /// Depth behind the face (m).
    pub depth: f64,
    /// Position relative to the particle (m).
    pub separation: [f64; D],
}

impl<const D: usize> ObstacleFace<D> {
    /// Returns the face of obstacle `obstacle` at its nearest position to a particle at `x` (m).
    fn at_nearest(solid: &RigidObstacle<D>, near: &NearestPoint<D>, x: &[f64; D], obstacle: u32) -> Self {
        let law = solid.laws.law_at(&near.position);
        let contact = match law.wall {
            ObstacleWall::Rough => WallContact::NoSlip,
            ObstacleWall::Smooth => WallContact::FreeSlip,
            ObstacleWall::Frictional { friction_coefficient, .. } => {
                WallContact::Friction(friction_coefficient)
            }
        };
        let (adhesion, lets_go) = (law.adhesion(), law.allows_separation());
        let distance = near.distance.max(0.0);
        let course = solid.velocity_at(x);
        Self {
            normal: near.normal,
            distance,
            contact,
            adhesion,
            allows_separation: lets_go,
            obstacle,
            velocity: course,
        }
    }

    /// Tangents of the face: one in the plane, two in space.
    fn tangents(&self) -> [[f64; D]; 2] {
        let n = &self.normal;
        let mut along = [[0.0; D]; 2];
        if D == 2 {
            (along[0][0], along[0][1]) = (n[1], -n[0]);
        } else if D == 3 {
            let flattest = (0..D).fold(0, |best, c| if n[c].abs() < n[best].abs() { c } else { best });
            along[0] = std::array::from_fn(|c| f64::from(u8::from(c == flattest)) - n[flattest] * n[c]);
            let size = dot(&along[0], &along[0]).sqrt();
            along[0] = along[0].map(|c| c / size);
            let t = along[0];
            along[1] = std::array::from_fn(|c| {
                let (a, b) = ((c + 1) % D, (c + 2) % D);
                n[a] * t[b] - n[b] * t[a]
            });
        }
        along
    }
}

/// Dummy positions behind `faces` within `reach` of the particle (m), on a lattice with a `spacing` (m). Each has its position relative to
/// the particle and the squared distance.
pub fn dummy_sites<const D: usize>(
    faces: &[ObstacleFace<D>],
    spacing: f64,
    reach: f64,
) -> impl Iterator<Item = (DummySite<'_, D>, ([f64; D], f64))> {
    faces.iter().enumerate().flat_map(move |(number, face)| {
        let along = face.tangents();
        let layers = ((reach - face.distance) / spacing + 0.5).max(0.0) as usize;
        let half = (reach / spacing) as usize;
        let wide = 2 * half + 1;
        (0..layers * wide.pow(D as u32 - 1)).filter_map(move |index| {
            let depth = ((index % layers) as f64 + 0.5) * spacing;
            let mut rest = index / layers;
            let mut apart = face.normal.map(|n| -n * (face.distance + depth));
            for direction in &along[..D - 1] {
                let steps = (rest % wide) as f64 - half as f64;
                rest /= wide;
                (0..D).for_each(|c| apart[c] += steps * spacing * direction[c]);
            }
            let square = dot(&apart, &apart);
            // The nearer face has the sites behind both.
            let taken =
                || faces[..number].iter().any(|nearer| dot(&nearer.normal, &apart) < -nearer.distance);
            (square < reach * reach && !taken())
                .then_some((DummySite { face, depth, separation: apart }, (apart, square)))
        })
    })
}

/// Rigid obstacle of the case.
#[derive(Clone, Debug)]
pub(crate) struct RigidObstacle<const D: usize> {
    name: String,
    /// Contact law of the obstacle.
    pub(crate) laws: ObstacleLaws,
    surface: Arc<dyn Surface<D>>,
    /// Motion of the obstacle; `None` at rest.
    motion: Option<MovingObstacle<D>>,
    /// Whether the reaction is recorded.
    is_recorded: bool,
}

impl<const D: usize> RigidObstacle<D> {
    /// Contact surface of the obstacle for rigid bodies.
    pub(crate) fn rigid_contact(&self) -> ObstacleContact<'_, D> {
        ObstacleContact { surface: self.current_surface(), laws: &self.laws, motion: self.motion.as_ref() }
    }

    /// Surface at its present position.
    pub(crate) fn current_surface(&self) -> &dyn Surface<D> {
        match &self.motion {
            Some(moving) => &moving.surface,
            None => &*self.surface,
        }
    }

    /// Velocity of the obstacle at `x` (m/s).
    pub(crate) fn velocity_at(&self, x: &[f64; D]) -> [f64; D] {
        self.motion.as_ref().map_or([0.0; D], |moving| moving.velocity(x))
    }
}

/// Particle and obstacle that can come into contact before the next list build.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObstacleCandidate<const D: usize> {
    /// Index of the particle in its block.
    particle: u32,
    /// Index of the obstacle.
    pub(crate) solid: u32,
    /// Normal of the obstacle at the position nearest to the listed position of the particle; zero deep inside.
    pub(crate) normal: [f64; D],
}

/// Faces close to the particles of a group of [`ROWS`].
#[derive(Clone, Debug, Default)]
struct FaceBlock<const D: usize> {
    /// Particles that may come into contact with obstacles before the next lists.
    listed_particles: Vec<ObstacleCandidate<D>>,
    /// Faces near the particles, in the order of particles.
    faces: Vec<ObstacleFace<D>>,
    /// End of the faces of each particle.
    row_ends: Vec<u32>,
    contacts: ContactQuery<D>,
    /// Particle deepest in an obstacle, the obstacle, and the depth (m).
    deepest: Option<(u32, u32, f64)>,
}

/// Obstacles with their faces close to each particle.
#[derive(Clone, Debug, Default)]
pub struct ObstacleFaces<const D: usize> {
    /// Rigid obstacles.
    pub(crate) solids: Vec<RigidObstacle<D>>,
    blocks: Vec<FaceBlock<D>>,
    /// Workspace of the contacts of a stopped particle.
    pub(crate) contacts: ContactQuery<D>,
}

impl<const D: usize> ObstacleFaces<D> {
    /// Obstacles of a case. `bodies` has the particle positions of each body (m), none of which may be deeper than `slack` inside an
    /// obstacle (m). `support` is the search radius (m).
    ///
    /// # Errors
    /// An obstacle that cannot be built, or one that covers a particle.
    pub fn new<'a>(
        case: &Case,
        bodies: impl Iterator<Item = (usize, &'a [[f64; D]])>,
        (slack, support): (f64, f64),
    ) -> Result<Self, CaseError> {
        let standing = case.placed_obstacles::<D>()?;
        for (body, places) in bodies {
            case.reject_overlapping_points(&standing, body, places, slack)?;
        }
        let is_measured =
            |name: &str| case.measures.values().any(|measure| measure.reaction_target() == Some(name));
        let (low, high) =
            (leading_components::<D>(&case.domain.min), leading_components::<D>(&case.domain.max));
        let domain = (low.map(|c| c - support), high.map(|c| c + support));
        let solids =
            standing.into_iter().map(|PlacedObstacle { obstacle, surface, laws, .. }| RigidObstacle {
                name: obstacle.name.clone(),
                laws,
                motion: obstacle.motion.as_ref().map(|motion| MovingObstacle::new(motion, &surface, domain)),
                surface,
                is_recorded: is_measured(&obstacle.name),
            });
        Ok(Self { solids: solids.collect(), ..Self::default() })
    }

    /// Returns a copy of the obstacles without faces.
    pub fn empty_like(&self) -> Self {
        Self { solids: self.solids.clone(), ..Self::default() }
    }

    /// Indices and names of obstacles with recorded reactions.
    pub fn recorded_obstacles(&self) -> impl Iterator<Item = (usize, &str)> {
        self.solids
            .iter()
            .enumerate()
            .filter(|(_, own)| own.is_recorded)
            .map(|(number, own)| (number, own.name.as_str()))
    }

    /// Indices of obstacles with recorded reactions or motion, and whether the reaction is recorded.
    pub fn recorded_or_moving(&self) -> impl Iterator<Item = (usize, bool)> {
        let watched = |own: &RigidObstacle<D>| own.is_recorded || own.motion.is_some();
        self.solids
            .iter()
            .enumerate()
            .filter(move |(_, own)| watched(own))
            .map(|(number, own)| (number, own.is_recorded))
    }

    /// Moving obstacles.
    pub fn moving_obstacles(&self) -> impl Iterator<Item = &MovingObstacle<D>> {
        self.solids.iter().filter_map(|own| own.motion.as_ref())
    }

    /// Moving obstacles, to be changed.
    pub fn moving_obstacles_mut(&mut self) -> impl Iterator<Item = &mut MovingObstacle<D>> {
        self.solids.iter_mut().filter_map(|own| own.motion.as_mut())
    }

    /// Whether any obstacle moves.
    pub fn are_moving(&self) -> bool {
        self.moving_obstacles().next().is_some()
    }

    /// Moves the obstacles to `time` (s).
    pub fn move_to(&mut self, time: f64) {
        self.moving_obstacles_mut().for_each(|moving| moving.move_to(time));
    }

    /// Sets the mean obstacle velocities of a step of `dt` (s) that ends at `end` (s).
    pub fn set_mean_velocity(&mut self, end: f64, dt: f64) {
        self.moving_obstacles_mut().for_each(|moving| moving.set_mean_velocity(end, dt));
    }

    /// Largest displacement of an obstacle between two times (m).
    pub fn max_displacement(&self, start: f64, end: f64) -> f64 {
        self.moving_obstacles().map(|moving| moving.max_displacement(start, end)).fold(0.0, f64::max)
    }

    /// Velocity of obstacle `number` at `x` (m/s).
    pub fn velocity_at(&self, number: usize, x: &[f64; D]) -> [f64; D] {
        self.solids[number].velocity_at(x)
    }

    /// Velocity difference of obstacle `number` between two positions with the distance vector `apart` (m/s); `None` without rotation.
    #[inline]
    pub fn rotational_velocity(&self, number: u32, apart: &[f64; D]) -> Option<[f64; D]> {
        self.solids[number as usize].motion.as_ref().map(|moving| moving.rotational_velocity(apart))
    }

    /// Whether the reaction of obstacle `number` is recorded.
    pub(crate) fn is_recorded(&self, number: u32) -> bool {
        self.solids[number as usize].is_recorded
    }

    /// Whether there are no obstacles.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.solids.is_empty()
    }

    /// Lists the particles that can come within a kernel radius of an obstacle while no particle moves farther than `reach` permits (m).
    pub fn list_candidates(&mut self, positions: &[[f64; D]], reach: f64) {
        let Self { solids, blocks, .. } = self;
        if solids.is_empty() {
            return;
        }
        blocks.resize_with(positions.len().div_ceil(BLOCK_POINTS), FaceBlock::default);
        blocks.par_iter_mut().zip(positions.par_chunks(BLOCK_POINTS)).for_each(|(block, positions)| {
            block.listed_particles.clear();
            for (k, x) in positions.iter().enumerate() {
                for (number, solid) in solids.iter().enumerate() {
                    let gap = solid.current_surface().gap(x, reach);
                    if gap.is_some() || solid.current_surface().contains(x) {
                        let normal = gap.map_or([0.0; D], |gap| gap.normal);
                        block.listed_particles.push(ObstacleCandidate {
                            particle: k as u32,
                            solid: number as u32,
                            normal,
                        });
                    }
                }
            }
        });
    }

    /// Finds the faces within `support` (m) of the particles at `positions`.
    pub fn find_faces(&mut self, positions: &[[f64; D]], support: f64) {
        let Self { solids, blocks, .. } = self;
        blocks.par_iter_mut().zip(positions.par_chunks(BLOCK_POINTS)).for_each(|(block, positions)| {
            block.faces.clear();
            block.row_ends.clear();
            block.deepest = None;
            let mut listed = block.listed_particles.iter().peekable();
            for (k, x) in positions.iter().enumerate() {
                while let Some(ObstacleCandidate { solid: number, .. }) =
                    listed.next_if(|own| own.particle as usize == k)
                {
                    let solid = &solids[*number as usize];
                    let surface = solid.current_surface();
                    block.contacts.clear();
                    surface.query_contacts(x, support, &mut block.contacts);
                    let touched = block.contacts.contacts().iter();
                    block.faces.extend(touched.map(|near| ObstacleFace::at_nearest(solid, near, x, *number)));
                    if block.contacts.is_empty()
                        && let Some(deeper) = surface.gap(x, support).filter(|gap| gap.distance < 0.0)
                    {
                        block.faces.push(ObstacleFace::at_nearest(solid, &deeper, x, *number));
                        let depth = -deeper.distance;
                        if block.deepest.is_none_or(|(.., largest)| depth > largest) {
                            block.deepest = Some((k as u32, *number, depth));
                        }
                    }
                }
                block.row_ends.push(block.faces.len() as u32);
            }
        });
    }

    /// Obstacles that can come into contact with particle `i`.
    pub(crate) fn candidates(&self, i: usize) -> &[ObstacleCandidate<D>] {
        let Some(block) = self.blocks.get(i / BLOCK_POINTS) else { return &[] };
        let k = (i % BLOCK_POINTS) as u32;
        let first = block.listed_particles.partition_point(|own| own.particle < k);
        let count = block.listed_particles[first..].iter().take_while(|own| own.particle == k).count();
        &block.listed_particles[first..first + count]
    }

    /// First particle deeper than `margin` (m) in an obstacle, with the obstacle's name.
    pub fn first_inside(&self, margin: f64) -> Option<(usize, &str)> {
        self.blocks.iter().enumerate().find_map(|(number, block)| {
            let (k, solid, _) = block.deepest.filter(|(.., depth)| *depth > margin)?;
            Some((number * BLOCK_POINTS + k as usize, self.solids[solid as usize].name.as_str()))
        })
    }

    /// Faces close to particle `i`, for each obstacle the closest first.
    #[inline]
    pub fn faces(&self, i: usize) -> &[ObstacleFace<D>] {
        let Some(block) = self.blocks.get(i / BLOCK_POINTS) else { return &[] };
        let k = i % BLOCK_POINTS;
        let Some(&end) = block.row_ends.get(k) else { return &[] };
        let start = if k == 0 { 0 } else { block.row_ends[k - 1] };
        &block.faces[start as usize..end as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face<const D: usize>(normal: [f64; D], distance: f64) -> ObstacleFace<D> {
        ObstacleFace {
            normal,
            distance,
            contact: WallContact::FreeSlip,
            adhesion: 0.0,
            allows_separation: false,
            obstacle: 0,
            velocity: [0.0; D],
        }
    }

    #[test]
    fn dummy_sites_behind_a_face_are_a_rotated_wall_of_particles() {
        let flat: Vec<_> =
            dummy_sites(&[face([0.0, 1.0], 0.05)], 0.1, 0.25).map(|(_, (apart, _))| apart).collect();
        // Layers 0.1 and 0.2 below the particle: five sites within 0.25 m in the first, three in the second.
        assert_eq!(flat.len(), 8);
        assert!(flat.iter().all(|apart| apart[1] < -0.09 && apart[0].hypot(apart[1]) < 0.25));
        let (sin, cos) = 0.5f64.sin_cos();
        let turned: Vec<_> =
            dummy_sites(&[face([sin, cos], 0.05)], 0.1, 0.25).map(|(_, (apart, _))| apart).collect();
        for (a, b) in flat.iter().zip(&turned) {
            let back = [cos * b[0] - sin * b[1], sin * b[0] + cos * b[1]];
            assert!((a[0] - back[0]).abs() < 1e-15 && (a[1] - back[1]).abs() < 1e-15, "{a:?} {back:?}");
        }
        let leaning = [face([0.0, 0.6, 0.8], 0.05)];
        let space = dummy_sites(&leaning, 0.1, 0.15).map(|(site, (apart, square))| {
            let depth = -(0.6 * apart[1] + 0.8 * apart[2]) - 0.05;
            assert!((depth - site.depth).abs() < 1e-15 && (square.sqrt() - 0.15) < 0.0);
        });
        // The foot point and its four neighbours at √(0.1² + 0.1²) = 0.141.
        assert_eq!(space.count(), 5);
    }

    #[test]
    fn dummy_sites_in_an_inner_corner_do_not_overlap() {
        let both = [face([0.0, 1.0], 0.05), face([1.0, 0.0], 0.06)];
        let found: Vec<_> =
            dummy_sites(&both, 0.1, 0.3).map(|(site, (apart, _))| (site.face.normal, apart)).collect();
        assert!(found.iter().any(|(normal, _)| normal[0] == 1.0));
        assert!(found.iter().all(|(normal, apart)| normal[0] == 0.0 || apart[1] >= -0.05));
    }
}
