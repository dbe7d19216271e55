//! Bodies that are held and smooth: where their particles stand (sheet: sph §2.13 b–c).

use std::ops::Range;

use crate::boundary::image_particle::ImageParticle;
use crate::points::particles::ParticleGroup;

/// Where the particles of a smooth body stand, and their images.
#[derive(Clone, Debug)]
pub struct SmoothBodyRanges {
    /// Its own.
    pub own: Range<usize>,
    /// The images of these.
    pub images: Range<usize>,
}

/// The smooth bodies.
#[derive(Clone, Debug, Default)]
pub struct SmoothBodies {
    /// Body by body.
    pub ranges_of_bodies: Vec<SmoothBodyRanges>,
}

impl SmoothBodies {
    /// Finds them among `len` particles, which are followed by their images in the same order.
    pub fn find<const D: usize>(
        &mut self,
        groups: &[ParticleGroup],
        len: usize,
        images: &[ImageParticle<D>],
    ) {
        let before = |end: usize| len + images.partition_point(|image| (image.source as usize) < end);
        self.ranges_of_bodies.clear();
        self.ranges_of_bodies.extend(groups.iter().filter(|group| group.smooth).map(|group| {
            SmoothBodyRanges { own: group.range(), images: before(group.start)..before(group.end) }
        }));
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ranges_of_bodies.is_empty()
    }

    /// Whether particle `j`, or what it is the image of, belongs to one of them.
    #[inline]
    pub fn contain(&self, j: usize) -> bool {
        self.ranges_of_bodies.iter().any(|place| place.own.contains(&j) || place.images.contains(&j))
    }

    /// Their particles and the images of these.
    pub fn particles(&self) -> impl Iterator<Item = usize> {
        self.ranges_of_bodies.iter().flat_map(|place| place.own.clone().chain(place.images.clone()))
    }

    /// Their particles without images, body by body.
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.ranges_of_bodies.iter().map(|place| place.own.clone())
    }
}
