//! Bodies that are held and smooth: where their particles stand (sheet: sph §2.13 b–c).

use std::ops::Range;

use super::image::Image;
use crate::particles::Group;

/// Where the particles of a smooth body stand, and their images.
#[derive(Clone, Debug)]
pub struct Place {
    /// Its own.
    pub own: Range<usize>,
    /// The images of these.
    pub images: Range<usize>,
}

/// The smooth bodies.
#[derive(Clone, Debug, Default)]
pub struct SmoothBodies {
    /// Body by body.
    pub places: Vec<Place>,
}

impl SmoothBodies {
    /// Finds them among `len` particles, which are followed by their images in the same order.
    pub fn find<const D: usize>(&mut self, groups: &[Group], len: usize, images: &[Image<D>]) {
        let before = |end: usize| len + images.partition_point(|image| (image.source as usize) < end);
        self.places.clear();
        self.places.extend(
            groups
                .iter()
                .filter(|group| group.smooth)
                .map(|group| Place { own: group.range(), images: before(group.start)..before(group.end) }),
        );
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Whether particle `j`, or what it is the image of, belongs to one of them.
    #[inline]
    pub fn contain(&self, j: usize) -> bool {
        self.places.iter().any(|place| place.own.contains(&j) || place.images.contains(&j))
    }

    /// Their particles and the images of these.
    pub fn particles(&self) -> impl Iterator<Item = usize> {
        self.places.iter().flat_map(|place| place.own.clone().chain(place.images.clone()))
    }

    /// Their particles without images, body by body.
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.places.iter().map(|place| place.own.clone())
    }
}
