//! Flat walls of a stage: their positions and particles.

use crate::boundary::flat_wall::FlatWall;
use crate::boundary::image_particle::{ImageParticle, PeriodicAxis};

/// Flat walls of the stage.
#[derive(Clone, Debug, Default)]
pub struct FlatWalls<const D: usize> {
    /// Mirror walls.
    pub mirrors: Vec<FlatWall<D>>,
    /// Walls of particles.
    pub faces: Vec<FlatWall<D>>,
    /// Periodic axes.
    pub periods: Vec<PeriodicAxis>,
    /// Positions of the wall particles at time zero (m).
    pub particles: Vec<[f64; D]>,
    /// Index of the wall to which each wall particle belongs.
    pub face_of: Vec<u32>,
}

/// Number of particles along each axis of a wall normal to `axis`. Its layers are `reach` deep (m) and extend beyond the box from `low` to
/// `high` by as much. They are real numbers, since a large box may exceed the range of integers.
pub fn particle_counts<const D: usize>(
    axis: usize,
    (low, high): &([f64; D], [f64; D]),
    spacing: f64,
    reach: f64,
) -> [f64; D] {
    let whole = |length: f64| (length / spacing - 1e-9).ceil();
    let layers = whole(reach);
    std::array::from_fn(|c| if c == axis { layers } else { whole(high[c] - low[c]) + 2.0 * layers })
}

impl<const D: usize> FlatWalls<D> {
    /// Flat walls of a domain. Those with particles have layers `reach` deep (m) that extend beyond the box from `low` to `high` by as
    /// much, and match periodic boundaries. Their [`particle_counts`] must not be too large.
    pub fn new(
        mirrors: Vec<FlatWall<D>>,
        faces: Vec<FlatWall<D>>,
        periods: Vec<PeriodicAxis>,
        span: ([f64; D], [f64; D]),
        spacing: f64,
        reach: f64,
    ) -> Self {
        let (mut particles, mut face_of) = (Vec::new(), Vec::new());
        for (number, plane) in faces.iter().enumerate() {
            let counts = particle_counts(plane.axis, &span, spacing, reach).map(|count| count as i64);
            let layers = counts[plane.axis];
            let line = |axis: usize| -> Vec<f64> {
                if axis == plane.axis {
                    let sign = if plane.is_upper { 1.0 } else { -1.0 };
                    return (0..layers).map(|k| plane.position + sign * (k as f64 + 0.5) * spacing).collect();
                }
                let all = -layers..counts[axis] - layers;
                all.map(|k| span.0[axis] + (k as f64 + 0.5) * spacing).collect()
            };
            let lines: [Vec<f64>; D] = std::array::from_fn(line);
            let total: usize = lines.iter().map(Vec::len).product();
            for index in 0..total {
                let mut rest = index;
                let site: [f64; D] = std::array::from_fn(|axis| {
                    let k = rest % lines[axis].len();
                    rest /= lines[axis].len();
                    lines[axis][k]
                });
                // At the corner of two walls, the first has the particles.
                if faces[..number].iter().all(|other| other.distance(&site) > 0.0) {
                    particles.push(site);
                    face_of.push(number as u32);
                }
            }
        }
        Self { mirrors, faces, periods, particles, face_of }
    }

    /// Planes of all flat walls: those with mirror particles and those with faces.
    fn planes(&self) -> impl Iterator<Item = &FlatWall<D>> {
        self.mirrors.iter().chain(&self.faces)
    }

    /// Mutable planes of all flat walls.
    fn planes_mut(&mut self) -> impl Iterator<Item = &mut FlatWall<D>> {
        self.mirrors.iter_mut().chain(&mut self.faces)
    }

    /// Positions of the first faces that bound `axis` below and above at `time` (s) (m).
    pub fn bounding_faces(&self, axis: usize, time: f64) -> (f64, f64) {
        self.planes().filter(|plane| plane.axis == axis).fold(
            (-f64::INFINITY, f64::INFINITY),
            |(low, high), plane| {
                let face = plane.face_at(time);
                if plane.is_upper { (low, high.min(face)) } else { (low.max(face), high) }
            },
        )
    }

    /// First wall whose face a position has crossed at `time` by more than `margin` (m).
    pub fn first_passed(&self, x: &[f64; D], time: f64, margin: f64) -> Option<&FlatWall<D>> {
        self.planes().find(|plane| {
            let (x, face) = (x[plane.axis], plane.face_at(time));
            if plane.is_upper { x > face + margin } else { x < face - margin }
        })
    }

    /// Largest displacement of a face between two times (m).
    pub fn max_displacement(&self, start: f64, end: f64) -> f64 {
        self.planes().map(|plane| plane.displacement_between(start, end).abs()).fold(0.0, f64::max)
    }

    /// Moves the faces to `time` (s).
    pub fn move_to(&mut self, time: f64) {
        self.planes_mut().for_each(|plane| plane.displacement = plane.displacement_between(0.0, time));
    }

    /// Sets the mean velocities of walls with a time history in the step from `start` to `end` (s). Returns whether there are any.
    pub fn update_time_histories(&mut self, start: f64, end: f64) -> bool {
        let mut varies = false;
        for plane in self.planes_mut() {
            let Some(history) = &plane.history else { continue };
            plane.factor = history.mean(start, end);
            varies = true;
        }
        varies
    }

    /// Moves the images with their mirrors, position and velocity.
    pub fn move_images(&self, images: &mut [ImageParticle<D>]) {
        if self.mirrors.iter().all(|plane| plane.velocity == [0.0; D]) {
            return;
        }
        for image in images.iter_mut().filter(|image| image.mirrors != [None; D]) {
            image.velocity_shift = [0.0; D];
            for (number, plane) in (0..).zip(&self.mirrors) {
                if image.mirrors[plane.axis] == Some(number) {
                    image.apply_mirror(plane);
                }
            }
        }
    }

    /// Writes the positions of the wall particles.
    pub fn place_particles(&self, slots: &mut [[f64; D]]) {
        for ((slot, base), &face) in slots.iter_mut().zip(&self.particles).zip(&self.face_of) {
            *slot = *base;
            let plane = &self.faces[face as usize];
            slot[plane.axis] += plane.displacement;
        }
    }

    /// Moves positions outside a periodic domain to the opposite end, with the reference positions of their displacements.
    pub fn wrap_into_period(&self, positions: &mut [[f64; D]], origins: &mut [[f64; D]]) {
        for PeriodicAxis { axis, low, high } in &self.periods {
            let length = high - low;
            for (x, origin) in positions.iter_mut().zip(&mut *origins) {
                let shift = length * ((x[*axis] - low) / length).floor();
                if shift != 0.0 {
                    x[*axis] -= shift;
                    origin[*axis] -= shift;
                }
            }
        }
    }

    /// Finds the images of the particles within `reach` of mirror walls and periodic boundaries (m), in the order of the particles. In
    /// corners there are also images along several axes.
    pub fn images(&self, positions: &[[f64; D]], reach: f64, images: &mut Vec<ImageParticle<D>>) {
        images.clear();
        if self.mirrors.is_empty() && self.periods.is_empty() {
            return;
        }
        for (source, x) in positions.iter().enumerate() {
            let first = images.len();
            let itself = ImageParticle::of_particle(source as u32);
            // Every image of the particle along other axes has one along this axis.
            let mut add = |axis: usize, change: &dyn Fn(ImageParticle<D>) -> ImageParticle<D>| {
                let end = images.len();
                for k in first..end {
                    let image = images[k];
                    if image.axis_sign[axis] > 0.0 && image.shift[axis] == 0.0 {
                        images.push(change(image));
                    }
                }
                images.push(change(itself));
            };
            for PeriodicAxis { axis, low, high } in &self.periods {
                for (near, shift) in [(x[*axis] - low, high - low), (high - x[*axis], low - high)] {
                    if near < reach {
                        add(*axis, &|mut image| {
                            image.shift[*axis] = shift;
                            image
                        });
                    }
                }
            }
            for (number, plane) in (0..).zip(&self.mirrors) {
                if plane.distance(x) < reach {
                    add(plane.axis, &|image| image.flipped(number, plane));
                }
            }
        }
    }
}
