//! Walls of the case: mirrors, layers of particles, and the ends of periodic domains (SPH sheet §2.13).

use crate::config::History;
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
#[derive(Clone, Debug, PartialEq)]
pub struct Plane<const D: usize> {
    /// Index into `Case::boundaries`.
    pub boundary: usize,
    /// Axis normal to the face.
    pub axis: usize,
    /// Coordinate of the face at time zero (m).
    pub position: f64,
    /// True where the wall lies above the face.
    pub upper: bool,
    /// Velocity of the wall (m/s) where the factor on it is one; along the normal it carries the face.
    pub velocity: [f64; D],
    /// The factor on this velocity over time; one without.
    pub history: Option<History>,
    /// Its mean over the step.
    pub factor: f64,
    /// How far the face has moved along its axis since time zero (m).
    pub moved: f64,
    /// What it does along the face.
    pub contact: Contact,
}

impl<const D: usize> Plane<D> {
    /// Coordinate of the face (m).
    #[inline]
    pub fn face(&self) -> f64 {
        self.position + self.moved
    }

    /// Mean velocity over the step (m/s).
    #[inline]
    pub fn pace(&self) -> [f64; D] {
        self.velocity.map(|v| self.factor * v)
    }

    /// Coordinate of the face at `time` (m).
    pub fn face_at(&self, time: f64) -> f64 {
        self.position + self.course(0.0, time)
    }

    /// How far the face moves between two times (m): the integral of its velocity.
    fn course(&self, start: f64, end: f64) -> f64 {
        let elapsed = self.history.as_ref().map_or(end - start, |history| history.area(start, end));
        self.velocity[self.axis] * elapsed
    }

    /// Distance of `x` from the face, positive outside of the wall (m).
    #[inline]
    pub fn distance(&self, x: &[f64; D]) -> f64 {
        let along = x[self.axis] - self.face();
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
    /// Number of the mirror across each axis that is mirrored.
    across: [Option<u32>; D],
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
        Self { source, flip: same, shift: none, turn: same, lift: none, bend: same, across: [None; D] }
    }

    /// The image in the mirror `plane` of this number.
    fn flipped(mut self, number: u32, plane: &Plane<D>) -> Self {
        let axis = plane.axis;
        self.across[axis] = Some(number);
        self.flip[axis] = -1.0;
        if plane.contact == Contact::NoSlip {
            self.turn = self.turn.map(|c| -c);
        } else {
            self.turn[axis] = -self.turn[axis];
            self.bend[axis] = -1.0;
        }
        self.carry(plane);
        self
    }

    /// What the place and the velocity of its last mirror do to it.
    fn carry(&mut self, plane: &Plane<D>) {
        let (axis, pace) = (plane.axis, plane.pace());
        self.shift[axis] = 2.0 * plane.face();
        if plane.contact == Contact::NoSlip {
            self.lift = std::array::from_fn(|c| 2.0 * pace[c] - self.lift[c]);
        } else {
            self.lift[axis] = 2.0 * pace[axis] - self.lift[axis];
        }
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
                if faces[..number].iter().all(|other| other.distance(&site) > 0.0) {
                    particles.push(site);
                    face_of.push(number as u32);
                }
            }
        }
        Self { mirrors, faces, periods, particles, face_of }
    }

    fn planes(&self) -> impl Iterator<Item = &Plane<D>> {
        self.mirrors.iter().chain(&self.faces)
    }

    fn planes_mut(&mut self) -> impl Iterator<Item = &mut Plane<D>> {
        self.mirrors.iter_mut().chain(&mut self.faces)
    }

    /// Where the first faces stand at `time` (s) that close `axis` below and above (m).
    pub fn ends(&self, axis: usize, time: f64) -> (f64, f64) {
        self.planes().filter(|plane| plane.axis == axis).fold(
            (-f64::INFINITY, f64::INFINITY),
            |(low, high), plane| {
                let face = plane.face_at(time);
                if plane.upper { (low, high.min(face)) } else { (low.max(face), high) }
            },
        )
    }

    /// The first wall that `x` is behind the face of at `time` (s) by more than `margin` (m).
    pub fn passed(&self, x: &[f64; D], time: f64, margin: f64) -> Option<&Plane<D>> {
        self.planes().find(|plane| {
            let (x, face) = (x[plane.axis], plane.face_at(time));
            if plane.upper { x > face + margin } else { x < face - margin }
        })
    }

    /// How far a face has moved at most between two times (m).
    pub fn moved(&self, start: f64, end: f64) -> f64 {
        self.planes().map(|plane| plane.course(start, end).abs()).fold(0.0, f64::max)
    }

    /// Faces to where they are at `time`, and `images` with them.
    pub fn go_to(&mut self, time: f64, images: &mut [Image<D>]) {
        self.planes_mut().for_each(|plane| plane.moved = plane.course(0.0, time));
        self.carry(images);
    }

    /// Walls whose velocities vary in time get those of the step from `start` to `end` (s), and `images` with them.
    pub fn follow_histories(&mut self, start: f64, end: f64, images: &mut [Image<D>]) {
        let mut varies = false;
        for plane in self.planes_mut() {
            let Some(history) = &plane.history else { continue };
            plane.factor = history.mean(start, end);
            varies = true;
        }
        if varies {
            self.carry(images);
        }
    }

    /// Images to where their mirrors are, with the velocities of these.
    fn carry(&self, images: &mut [Image<D>]) {
        if self.mirrors.iter().all(|plane| plane.velocity == [0.0; D]) {
            return;
        }
        for image in images.iter_mut().filter(|image| image.across != [None; D]) {
            image.lift = [0.0; D];
            for (number, plane) in (0..).zip(&self.mirrors) {
                if image.across[plane.axis] == Some(number) {
                    image.carry(plane);
                }
            }
        }
    }

    /// Where the particles of the walls are.
    pub fn place(&self, slots: &mut [[f64; D]]) {
        for ((slot, base), &face) in slots.iter_mut().zip(&self.particles).zip(&self.face_of) {
            *slot = *base;
            let plane = &self.faces[face as usize];
            slot[plane.axis] += plane.moved;
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

    /// Images of the particles within `reach` (m) of mirrors and ends of periods, in the order of the
    /// particles; in corners also those along several axes.
    pub fn images(&self, positions: &[[f64; D]], reach: f64, images: &mut Vec<Image<D>>) {
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
            for (number, plane) in (0..).zip(&self.mirrors) {
                if plane.distance(x) < reach {
                    add(plane.axis, &|image| image.flipped(number, plane));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(axis: usize) -> Plane<2> {
        Plane {
            boundary: 0,
            axis,
            position: 0.0,
            upper: false,
            velocity: [0.0; 2],
            history: None,
            factor: 1.0,
            moved: 0.0,
            contact: Contact::FreeSlip,
        }
    }

    #[test]
    fn images_in_rough_mirrors_go_the_other_way_and_keep_the_stress() {
        let rough = |axis| Plane { velocity: [0.5, 0.25], contact: Contact::NoSlip, ..plane(axis) };
        let walls = Walls::<2> { mirrors: vec![rough(1), plane(0)], ..Walls::default() };
        let mut images = Vec::new();
        walls.images(&[[0.1, 0.2]], 1.0, &mut images);
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
        walls.images(&[[0.1, 0.2], [0.1, 5.0], [5.0, 5.0]], 1.0, &mut images);
        let mut flips: Vec<_> = images.iter().map(|image| (image.source, image.flip)).collect();
        flips.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(flips, [(0, [-1.0, -1.0]), (0, [-1.0, 1.0]), (0, [1.0, -1.0]), (1, [-1.0, 1.0])]);
    }

    #[test]
    fn a_moving_mirror_carries_its_images() {
        let moving = Plane { velocity: [0.5, 3.0], ..plane(0) };
        let mut walls = Walls::<2> { mirrors: vec![plane(1), moving], ..Walls::default() };
        walls.go_to(2.0, &mut []);
        let mut images = Vec::new();
        walls.images(&[[1.2, 0.3]], 1.0, &mut images);
        let of = |images: &[Image<2>]| images.iter().map(|i| (i.flip, i.shift, i.lift)).collect::<Vec<_>>();
        let below = ([1.0, -1.0], [0.0, 0.0], [0.0, 0.0]);
        let around = |shift| {
            [below, ([-1.0, -1.0], [shift, 0.0], [1.0, 0.0]), ([-1.0, 1.0], [shift, 0.0], [1.0, 0.0])]
        };
        assert_eq!(of(&images), around(2.0));
        // Those that are there already go along.
        walls.go_to(3.0, &mut images);
        assert_eq!(of(&images), around(3.0));
    }

    #[test]
    fn a_face_is_where_the_integral_of_its_velocity_is() {
        let history = History { times: vec![1.0, 2.0, 4.0], factors: vec![0.0, 3.0, -1.0] };
        let varying = |axis, contact| Plane {
            velocity: [0.5, 0.25],
            history: Some(history.clone()),
            contact,
            ..plane(axis)
        };
        let mut walls = Walls::<2>::new(
            vec![varying(1, Contact::NoSlip)],
            vec![varying(0, Contact::FreeSlip)],
            Vec::new(),
            ([0.0; 2], [1.0; 2]),
            0.1,
            0.24,
        );
        let mut images = Vec::new();
        walls.images(&[[0.5, 0.1]], 1.0, &mut images);
        let first = walls.particles[0][0];
        // The area under the factor: 1.5 up to 2 s, and 2 more up to 4 s.
        for (time, area) in [(0.5, 0.0), (1.5, 0.375), (2.0, 1.5), (4.0, 3.5), (5.0, 2.5)] {
            walls.go_to(time, &mut images);
            assert!((walls.faces[0].face() - 0.5 * area).abs() < 1e-15, "at {time} s");
            assert!((images[0].shift[1] - 0.5 * area).abs() < 1e-15, "at {time} s");
            let mut slots = vec![[0.0; 2]; walls.particles.len()];
            walls.place(&mut slots);
            assert!((slots[0][0] - first - 0.5 * area).abs() < 1e-15, "at {time} s");
        }
        walls.follow_histories(1.5, 3.0, &mut images);
        let mean = (1.125 + 2.0) / 1.5;
        assert_eq!(walls.faces[0].pace(), [0.5 * mean, 0.25 * mean]);
        assert_eq!(images[0].lift, [mean, 0.5 * mean]);
        assert!((walls.moved(2.0, 5.0) - 0.5).abs() < 1e-15 && walls.moved(0.0, 1.0) == 0.0);
    }

    #[test]
    fn a_doubly_periodic_corner_has_three_images_and_a_mirror_joins_in() {
        let period = |axis| Period { axis, low: 0.0, high: 10.0 };
        let walls = Walls::<2> { periods: vec![period(0), period(1)], ..Walls::default() };
        let mut images = Vec::new();
        walls.images(&[[0.1, 9.9]], 1.0, &mut images);
        let mut shifts: Vec<_> = images.iter().map(|image| image.shift).collect();
        shifts.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(shifts, [[0.0, -10.0], [10.0, -10.0], [10.0, 0.0]]);
        let walls = Walls::<2> { periods: vec![period(0)], mirrors: vec![plane(1)], ..Walls::default() };
        walls.images(&[[0.1, 0.2]], 1.0, &mut images);
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
