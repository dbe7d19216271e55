//! Walls of the case: mirrors, layers of particles, and the ends of periodic domains (SPH sheet §2.13).

use crate::particles::Matrix;

/// What a wall of particles does to the motion along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contact {
    /// Nothing slips.
    NoSlip,
    /// Nothing holds.
    FreeSlip,
    /// Coulomb friction; nothing holds in tension.
    Friction(f64),
}

/// A half space that material cannot enter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane<const D: usize> {
    /// Axis normal to the face.
    pub axis: usize,
    /// Coordinate of the face at time zero (m).
    pub position: f64,
    /// True where the wall lies above the face.
    pub upper: bool,
    /// Velocity of the wall (m/s); along the normal it carries the face.
    pub velocity: [f64; D],
    /// What it does along the face.
    pub contact: Contact,
}

impl<const D: usize> Plane<D> {
    /// Coordinate of the face at `time` (m).
    #[inline]
    pub fn face(&self, time: f64) -> f64 {
        self.position + self.velocity[self.axis] * time
    }

    /// Distance of `x` from the face at `time`, positive outside of the wall (m).
    #[inline]
    pub fn distance(&self, x: &[f64; D], time: f64) -> f64 {
        let along = x[self.axis] - self.face(time);
        if self.upper { -along } else { along }
    }
}

/// An image of a particle in mirrors and periods: `x' = flip x + shift`, `v' = turn v + lift`, `σ' = B σ B` with
/// `B = diag bend`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image<const D: usize> {
    /// The particle.
    pub source: u32,
    /// -1 along the axes that are mirrored.
    pub flip: [f64; D],
    /// Twice the coordinate of the mirror, or a period.
    pub shift: [f64; D],
    /// Sign of the velocity: of smooth mirrors `flip`, of rough ones -1 along every axis.
    pub turn: [f64; D],
    /// Twice the velocity of the mirror (m/s).
    pub lift: [f64; D],
    /// Sign of the axes for stress: of smooth mirrors `flip`, of rough ones 1, which keep it.
    pub bend: [f64; D],
}

impl<const D: usize> Image<D> {
    /// The velocity gradient of the image of a particle with the gradient `l` (1/s).
    #[inline]
    pub fn gradient(&self, l: &Matrix<D>) -> Matrix<D> {
        std::array::from_fn(|a| std::array::from_fn(|b| self.turn[a] * l[a][b] * self.flip[b]))
    }

    /// The particle itself.
    fn of(source: u32) -> Self {
        let (none, same) = ([0.0; D], [1.0; D]);
        Self { source, flip: same, shift: none, turn: same, lift: none, bend: same }
    }
}

/// An axis along which the domain repeats itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Period {
    /// The axis.
    pub axis: usize,
    /// Lower end (m).
    pub low: f64,
    /// Upper end (m).
    pub high: f64,
}

/// Walls in force.
#[derive(Clone, Debug, Default)]
pub struct Walls<const D: usize> {
    /// Walls that mirror.
    pub mirrors: Vec<Plane<D>>,
    /// Walls of particles.
    pub faces: Vec<Plane<D>>,
    /// Periodic axes.
    pub periods: Vec<Period>,
    /// Particles of the walls at time zero (m).
    pub particles: Vec<[f64; D]>,
    /// The wall each of them belongs to.
    pub face_of: Vec<u32>,
}

/// How many particles a wall normal to `axis` has along each axis: layers as deep as `reach` (m), over the box from
/// `low` to `high` and as far beyond it. As real numbers: a large box may need more than can be counted.
pub fn sites<const D: usize>(
    axis: usize,
    (low, high): &([f64; D], [f64; D]),
    spacing: f64,
    reach: f64,
) -> [f64; D] {
    let whole = |length: f64| (length / spacing - 1e-9).ceil();
    let layers = whole(reach);
    std::array::from_fn(|c| if c == axis { layers } else { whole(high[c] - low[c]) + 2.0 * layers })
}

impl<const D: usize> Walls<D> {
    /// The walls, those of particles in layers as deep as `reach` (m) over the box from `low` to `high` and as
    /// far beyond it, which is also what periods of whole spacings make of them. Their [`sites`] must not be too many.
    pub fn new(
        mirrors: Vec<Plane<D>>,
        faces: Vec<Plane<D>>,
        periods: Vec<Period>,
        span: ([f64; D], [f64; D]),
        spacing: f64,
        reach: f64,
    ) -> Self {
        let (mut particles, mut face_of) = (Vec::new(), Vec::new());
        for (number, plane) in faces.iter().enumerate() {
            let counts = sites(plane.axis, &span, spacing, reach).map(|count| count as i64);
            let layers = counts[plane.axis];
            let line = |axis: usize| -> Vec<f64> {
                if axis == plane.axis {
                    let sign = if plane.upper { 1.0 } else { -1.0 };
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
                // Where two walls meet, the first has the corner.
                if faces[..number].iter().all(|other| other.distance(&site, 0.0) > 0.0) {
                    particles.push(site);
                    face_of.push(number as u32);
                }
            }
        }
        Self { mirrors, faces, periods, particles, face_of }
    }

    /// Largest speed of a face along its normal (m/s).
    pub fn speed(&self) -> f64 {
        let all = self.mirrors.iter().chain(&self.faces);
        all.map(|plane| plane.velocity[plane.axis].abs()).fold(0.0, f64::max)
    }

    /// Where the particles of the walls are at `time`.
    pub fn place(&self, time: f64, slots: &mut [[f64; D]]) {
        for ((slot, base), &face) in slots.iter_mut().zip(&self.particles).zip(&self.face_of) {
            *slot = *base;
            let plane = &self.faces[face as usize];
            slot[plane.axis] += plane.velocity[plane.axis] * time;
        }
    }

    /// Puts positions that left a periodic domain back into it, and what counts displacement as far.
    pub fn wrap(&self, positions: &mut [[f64; D]], origins: &mut [[f64; D]]) {
        for Period { axis, low, high } in &self.periods {
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

    /// Images at `time` of the particles within `reach` (m) of mirrors and ends of periods, in the order of the
    /// particles; in corners also those along several axes.
    pub fn images(&self, positions: &[[f64; D]], reach: f64, time: f64, images: &mut Vec<Image<D>>) {
        images.clear();
        if self.mirrors.is_empty() && self.periods.is_empty() {
            return;
        }
        for (source, x) in positions.iter().enumerate() {
            let first = images.len();
            let itself = Image::of(source as u32);
            // Every image of the particle along other axes has one along this axis.
            let mut add = |axis: usize, change: &dyn Fn(Image<D>) -> Image<D>| {
                let end = images.len();
                for k in first..end {
                    let image = images[k];
                    if image.flip[axis] > 0.0 && image.shift[axis] == 0.0 {
                        images.push(change(image));
                    }
                }
                images.push(change(itself));
            };
            for Period { axis, low, high } in &self.periods {
                for (near, shift) in [(x[*axis] - low, high - low), (high - x[*axis], low - high)] {
                    if near < reach {
                        add(*axis, &|mut image| {
                            image.shift[*axis] = shift;
                            image
                        });
                    }
                }
            }
            for plane in &self.mirrors {
                if plane.distance(x, time) < reach {
                    add(plane.axis, &|image| flipped(image, plane, time));
                }
            }
        }
    }
}

fn flipped<const D: usize>(mut image: Image<D>, plane: &Plane<D>, time: f64) -> Image<D> {
    let axis = plane.axis;
    image.flip[axis] = -1.0;
    image.shift[axis] = 2.0 * plane.face(time);
    if plane.contact == Contact::NoSlip {
        image.turn = image.turn.map(|c| -c);
        image.lift = std::array::from_fn(|c| 2.0 * plane.velocity[c] - image.lift[c]);
    } else {
        image.turn[axis] = -image.turn[axis];
        image.lift[axis] = 2.0 * plane.velocity[axis] - image.lift[axis];
        image.bend[axis] = -1.0;
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(axis: usize) -> Plane<2> {
        Plane { axis, position: 0.0, upper: false, velocity: [0.0; 2], contact: Contact::FreeSlip }
    }

    #[test]
    fn images_in_rough_mirrors_go_the_other_way_and_keep_the_stress() {
        let rough = |axis| Plane { velocity: [0.5, 0.25], contact: Contact::NoSlip, ..plane(axis) };
        let walls = Walls::<2> { mirrors: vec![rough(1), plane(0)], ..Walls::default() };
        let mut images = Vec::new();
        walls.images(&[[0.1, 0.2]], 1.0, 0.0, &mut images);
        let found: Vec<_> = images.iter().map(|i| (i.flip, i.turn, i.lift, i.bend)).collect();
        let below = ([1.0, -1.0], [-1.0, -1.0], [1.0, 0.5], [1.0, 1.0]);
        let corner = ([-1.0, -1.0], [1.0, -1.0], [-1.0, 0.5], [-1.0, 1.0]);
        let beside = ([-1.0, 1.0], [-1.0, 1.0], [0.0, 0.0], [-1.0, 1.0]);
        assert_eq!(found, [below, corner, beside]);
    }

    #[test]
    fn a_particle_in_a_corner_has_three_images() {
        let walls = Walls::<2> { mirrors: vec![plane(0), plane(1)], ..Walls::default() };
        let mut images = Vec::new();
        walls.images(&[[0.1, 0.2], [0.1, 5.0], [5.0, 5.0]], 1.0, 0.0, &mut images);
        let mut flips: Vec<_> = images.iter().map(|image| (image.source, image.flip)).collect();
        flips.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(flips, [(0, [-1.0, -1.0]), (0, [-1.0, 1.0]), (0, [1.0, -1.0]), (1, [-1.0, 1.0])]);
    }

    #[test]
    fn a_moving_mirror_carries_its_images() {
        let moving = Plane { velocity: [0.5, 3.0], ..plane(0) };
        let walls = Walls::<2> { mirrors: vec![moving], ..Walls::default() };
        let mut images = Vec::new();
        walls.images(&[[1.2, 0.0]], 1.0, 2.0, &mut images);
        assert_eq!((images[0].flip, images[0].shift, images[0].lift), ([-1.0, 1.0], [2.0, 0.0], [1.0, 0.0]));
    }

    #[test]
    fn a_doubly_periodic_corner_has_three_images_and_a_mirror_joins_in() {
        let period = |axis| Period { axis, low: 0.0, high: 10.0 };
        let walls = Walls::<2> { periods: vec![period(0), period(1)], ..Walls::default() };
        let mut images = Vec::new();
        walls.images(&[[0.1, 9.9]], 1.0, 0.0, &mut images);
        let mut shifts: Vec<_> = images.iter().map(|image| image.shift).collect();
        shifts.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(shifts, [[0.0, -10.0], [10.0, -10.0], [10.0, 0.0]]);
        let walls = Walls::<2> { periods: vec![period(0)], mirrors: vec![plane(1)], ..Walls::default() };
        walls.images(&[[0.1, 0.2]], 1.0, 0.0, &mut images);
        assert_eq!(images.len(), 3);
        let (mut x, mut origin) = ([[-0.5, 1.0], [21.0, 1.0]], [[0.0, 0.0], [0.0, 0.0]]);
        walls.wrap(&mut x, &mut origin);
        assert_eq!((x, origin), ([[9.5, 1.0], [1.0, 1.0]], [[10.0, 0.0], [-20.0, 0.0]]));
    }

    #[test]
    fn walls_of_particles_share_their_corner() {
        let box_ = ([0.0, 0.0], [1.0, 1.0]);
        let walls = Walls::<2>::new(Vec::new(), vec![plane(0), plane(1)], Vec::new(), box_, 0.1, 0.24);
        // Three layers along both edges, one square of nine at each of the ends.
        assert_eq!(walls.particles.len(), 3 * 16 + 3 * 13);
        let mut sites: Vec<_> =
            walls.particles.iter().map(|x| x.map(|c| (c * 100.0).round() as i64)).collect();
        sites.sort_unstable();
        sites.dedup();
        assert_eq!(sites.len(), walls.particles.len());
    }

    #[test]
    fn walls_go_on_beyond_the_end_of_a_period() {
        let periods = vec![Period { axis: 0, low: 0.0, high: 1.0 }];
        let walls = Walls::<2>::new(Vec::new(), vec![plane(1)], periods, ([0.0, 0.0], [1.0, 1.0]), 0.1, 0.24);
        for x in &walls.particles {
            let image = [if x[0] < 0.5 { x[0] + 1.0 } else { x[0] - 1.0 }, x[1]];
            let near = |y: &[f64; 2]| (y[0] - image[0]).hypot(y[1] - image[1]) < 1e-9;
            assert!(image[0] < -0.3 || image[0] > 1.3 || walls.particles.iter().any(near), "{image:?}");
        }
    }
}
