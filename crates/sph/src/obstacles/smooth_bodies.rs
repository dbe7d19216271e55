//! Held smooth bodies: index ranges of their particles (sheet: sph §2.13 b–c).

use std::ops::Range;

use crate::boundary::image_particle::ImageParticle;
use crate::points::particles::ParticleGroup;

/// Index ranges of the particles of a smooth body and of their images.
#[derive(Clone, Debug)]
pub struct SmoothBodyRanges {
    /// Range of the particles of the body.
    pub body_particles: Range<usize>,
    /// Range of their images.
    pub images: Range<usize>,
}

/// Index ranges of all smooth bodies.
#[derive(Clone, Debug, Default)]
pub struct SmoothBodies {
    /// Ranges, body by body.
    pub ranges_of_bodies: Vec<SmoothBodyRanges>,
}

impl SmoothBodies {
    /// Finds the index ranges among `len` particles, which their images follow in the same order.
    pub fn find_ranges<const D: usize>(
        &mut self,
        groups: &[ParticleGroup],
        len: usize,
        images: &[ImageParticle<D>],
    ) {
        let before = |end: usize| len + images.partition_point(|image| (image.source as usize) < end);
        self.ranges_of_bodies.clear();
        self.ranges_of_bodies.extend(groups.iter().filter(|group| group.is_smooth).map(|group| {
            SmoothBodyRanges { body_particles: group.range(), images: before(group.start)..before(group.end) }
        }));
    }

    /// Whether there are no smooth bodies.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ranges_of_bodies.is_empty()
    }

    /// Whether particle `j`, or the source of image `j`, belongs to a smooth body.
    #[inline]
    pub fn contain(&self, j: usize) -> bool {
        self.ranges_of_bodies
            .iter()
            .any(|place| place.body_particles.contains(&j) || place.images.contains(&j))
    }

    /// Particles of smooth bodies and their images.
    pub fn particles(&self) -> impl Iterator<Item = usize> {
        self.ranges_of_bodies
            .iter()
            .flat_map(|place| place.body_particles.clone().chain(place.images.clone()))
    }

    /// Particle ranges without images, body by body.
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.ranges_of_bodies.iter().map(|place| place.body_particles.clone())
    }
}
