//! Walls of the case: mirrors where they are smooth, layers of particles where they are rough
//! (SPH sheet §2.13).

/// A half space that material cannot enter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Axis normal to the face.
    pub axis: usize,
    /// Coordinate of the face (m).
    pub position: f64,
    /// True where the wall lies above the face.
    pub upper: bool,
}

impl Plane {
    /// Distance of `x` from the face, positive outside of the wall (m).
    #[inline]
    pub fn distance<const D: usize>(&self, x: &[f64; D]) -> f64 {
        let along = x[self.axis] - self.position;
        if self.upper { -along } else { along }
    }
}

/// A mirror image of a particle: `x' = flip x + shift` along each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image<const D: usize> {
    /// The particle.
    pub source: u32,
    /// -1 along the axes that are mirrored.
    pub flip: [f64; D],
    /// Twice the coordinate of the mirror.
    pub shift: [f64; D],
}

/// Walls in force.
#[derive(Clone, Debug, Default)]
pub struct Walls<const D: usize> {
    /// Smooth walls.
    pub mirrors: Vec<Plane>,
    /// Particles of the rough walls (m).
    pub particles: Vec<[f64; D]>,
}

impl<const D: usize> Walls<D> {
    /// Smooth walls at `mirrors` and layers of particles behind the faces `rough`, as deep as `reach` (m),
    /// over the box from `low` to `high` and as far beyond it.
    pub fn new(
        mirrors: Vec<Plane>,
        rough: &[Plane],
        (low, high): ([f64; D], [f64; D]),
        spacing: f64,
        reach: f64,
    ) -> Self {
        let layers = (reach / spacing - 1e-9).ceil() as i64;
        let mut particles = Vec::new();
        for (number, plane) in rough.iter().enumerate() {
            let line = |axis: usize| -> Vec<f64> {
                if axis == plane.axis {
                    let sign = if plane.upper { 1.0 } else { -1.0 };
                    (0..layers).map(|k| plane.position + sign * (k as f64 + 0.5) * spacing).collect()
                } else {
                    let count = ((high[axis] - low[axis]) / spacing - 1e-9).ceil() as i64;
                    (-layers..count + layers).map(|k| low[axis] + (k as f64 + 0.5) * spacing).collect()
                }
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
                if rough[..number].iter().all(|other| other.distance(&site) > 0.0) {
                    particles.push(site);
                }
            }
        }
        Self { mirrors, particles }
    }

    /// Images of the particles within `reach` (m) of the mirrors, in the order of the particles; in corners
    /// also those mirrored along several axes.
    pub fn images(&self, positions: &[[f64; D]], reach: f64, images: &mut Vec<Image<D>>) {
        images.clear();
        if self.mirrors.is_empty() {
            return;
        }
        for (source, x) in positions.iter().enumerate() {
            let first = images.len();
            for plane in &self.mirrors {
                if plane.distance(x) >= reach {
                    continue;
                }
                // The image in this mirror of the particle and of its images along other axes.
                let end = images.len();
                for k in first..end {
                    if images[k].flip[plane.axis] > 0.0 {
                        let image = flipped(images[k], plane);
                        images.push(image);
                    }
                }
                let itself = Image { source: source as u32, flip: [1.0; D], shift: [0.0; D] };
                images.push(flipped(itself, plane));
            }
        }
    }
}

fn flipped<const D: usize>(mut image: Image<D>, plane: &Plane) -> Image<D> {
    image.flip[plane.axis] = -1.0;
    image.shift[plane.axis] = 2.0 * plane.position;
    image
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_particle_in_a_corner_has_three_images() {
        let plane = |axis| Plane { axis, position: 0.0, upper: false };
        let walls = Walls::<2> { mirrors: vec![plane(0), plane(1)], particles: Vec::new() };
        let mut images = Vec::new();
        walls.images(&[[0.1, 0.2], [0.1, 5.0], [5.0, 5.0]], 1.0, &mut images);
        let mut flips: Vec<_> = images.iter().map(|image| (image.source, image.flip)).collect();
        flips.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(flips, [(0, [-1.0, -1.0]), (0, [-1.0, 1.0]), (0, [1.0, -1.0]), (1, [-1.0, 1.0])]);
    }

    #[test]
    fn rough_walls_share_their_corner() {
        let plane = |axis| Plane { axis, position: 0.0, upper: false };
        let box_ = ([0.0, 0.0], [1.0, 1.0]);
        let walls = Walls::<2>::new(Vec::new(), &[plane(0), plane(1)], box_, 0.1, 0.24);
        // Three layers along both edges, one square of nine at each of the ends.
        assert_eq!(walls.particles.len(), 3 * 16 + 3 * 13);
        let mut sites: Vec<_> =
            walls.particles.iter().map(|x| x.map(|c| (c * 100.0).round() as i64)).collect();
        sites.sort_unstable();
        sites.dedup();
        assert_eq!(sites.len(), walls.particles.len());
    }
}
