//! Walls and periods along the axes of the plan, and image nodes (sheet: depth-sph §3.9).

use crate::points::phase_nodes::PlanVector;

/// Walls and periodic boundaries at both ends of each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanBoundaries<const D: usize> {
    /// Coordinates of the lower and upper wall of each axis (m); `None` for an open end.
    pub walls: [[Option<f64>; 2]; D],
    /// Coordinates of the lower and upper end of each periodic axis (m).
    pub periods: [Option<(f64, f64)>; D],
}

impl<const D: usize> Default for PlanBoundaries<D> {
    fn default() -> Self {
        Self { walls: [[None; 2]; D], periods: [None; D] }
    }
}

impl<const D: usize> PlanBoundaries<D> {
    /// Whether there are neither walls nor periodic boundaries.
    pub fn are_open(&self) -> bool {
        *self == Self::default()
    }

    /// Reflects a node that has passed a wall, with its velocity.
    #[inline]
    pub fn reflect(&self, position: &mut PlanVector<D>, velocity: &mut PlanVector<D>) {
        for (axis, [low, high]) in self.walls.iter().enumerate() {
            if let Some(wall) = low
                && position[axis] < *wall
            {
                position[axis] = 2.0 * wall - position[axis];
                velocity[axis] = velocity[axis].abs();
            }
            if let Some(wall) = high
                && position[axis] > *wall
            {
                position[axis] = 2.0 * wall - position[axis];
                velocity[axis] = -velocity[axis].abs();
            }
        }
    }

    /// Reflects a position at the walls; returns -1 for axes along which it was reflected, else 1.
    #[inline]
    pub fn mirror(&self, position: &mut PlanVector<D>) -> PlanVector<D> {
        let mut signs = [1.0; D];
        for (axis, walls) in self.walls.iter().enumerate() {
            for (wall, outward) in walls.iter().zip([-1.0, 1.0]) {
                if let Some(wall) = wall
                    && outward * (position[axis] - wall) > 0.0
                {
                    position[axis] = 2.0 * wall - position[axis];
                    signs[axis] = -signs[axis];
                }
            }
        }
        signs
    }

    /// Moves a node that has left a periodic domain to the opposite end.
    pub fn wrap_into_period(&self, position: &mut PlanVector<D>, origin: &mut PlanVector<D>) {
        for (axis, period) in self.periods.iter().enumerate() {
            let Some((low, high)) = period else { continue };
            let turns = ((position[axis] - low) / (high - low)).floor();
            position[axis] -= turns * (high - low);
            origin[axis] -= turns * (high - low);
        }
    }
}

/// Image node: `sign x + offset` of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageNode<const D: usize> {
    /// Index of the node.
    pub source: u32,
    /// Signs of the axes: -1 along mirrored axes, 1 elsewhere.
    pub sign: PlanVector<D>,
    /// Offset (m).
    pub offset: PlanVector<D>,
}

impl<const D: usize> ImageNode<D> {
    /// Position of the image (m).
    #[inline]
    pub fn image_position(&self, x: &PlanVector<D>) -> PlanVector<D> {
        std::array::from_fn(|c| self.sign[c] * x[c] + self.offset[c])
    }

    /// Vector of the image from that of its node.
    #[inline]
    pub fn transform_vector(&self, v: &PlanVector<D>) -> PlanVector<D> {
        std::array::from_fn(|c| self.sign[c] * v[c])
    }
}

/// All images within `reach` of walls and periodic boundaries (m), in a fixed order.
pub fn image_nodes<const D: usize>(
    ends: &PlanBoundaries<D>,
    positions: &[PlanVector<D>],
    reach: f64,
    images: &mut Vec<ImageNode<D>>,
) {
    images.clear();
    for axis in 0..D {
        // Images along the axes before have images of their own, in corners.
        let known = images.len();
        for source in 0..positions.len() {
            let own = ImageNode { source: source as u32, sign: [1.0; D], offset: [0.0; D] };
            push_images(ends, axis, reach, &positions[source], own, images);
        }
        for number in 0..known {
            let image = images[number];
            push_images(ends, axis, reach, &positions[image.source as usize], image, images);
        }
    }
}

/// Adds the images along one axis of a node at `x`, or of an image of it.
fn push_images<const D: usize>(
    ends: &PlanBoundaries<D>,
    axis: usize,
    reach: f64,
    x: &PlanVector<D>,
    image: ImageNode<D>,
    images: &mut Vec<ImageNode<D>>,
) {
    let place = image.image_position(x)[axis];
    for (side, wall) in ends.walls[axis].iter().enumerate() {
        let Some(wall) = wall else { continue };
        let inward = if side == 0 { place - wall } else { wall - place };
        if inward < reach {
            let mut mirrored = image;
            mirrored.sign[axis] = -image.sign[axis];
            mirrored.offset[axis] = 2.0 * wall - image.offset[axis];
            images.push(mirrored);
        }
    }
    let Some((low, high)) = ends.periods[axis] else { return };
    let period = high - low;
    // A reach of more than a period needs more than one image on each side.
    for turn in 1..=(reach / period).ceil() as i32 {
        let shift = f64::from(turn) * period;
        for (shift, gap) in [(shift, place + shift - high), (-shift, low - (place - shift))] {
            if gap < reach {
                let mut moved = image;
                moved.offset[axis] += shift;
                images.push(moved);
            }
        }
    }
}

/// Copies a value of each node, and then the value of the node of each image.
pub fn copy_with_images<const D: usize, T: Copy>(images: &[ImageNode<D>], own: &[T], values: &mut Vec<T>) {
    values.clear();
    values.extend_from_slice(own);
    values.extend(images.iter().map(|image| own[image.source as usize]));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_in_a_corner_has_three_images() {
        let ends =
            PlanBoundaries { walls: [[Some(0.0), None], [None, Some(1.0)]], ..PlanBoundaries::default() };
        let mut found = Vec::new();
        image_nodes(&ends, &[[0.1, 0.8], [5.0, 0.2]], 0.3, &mut found);
        let places: Vec<[f64; 2]> = found.iter().map(|image| image.image_position(&[0.1, 0.8])).collect();
        assert_eq!(places, [[-0.1, 0.8], [0.1, 1.2], [-0.1, 1.2]]);
        assert_eq!(found[2].transform_vector(&[1.0, 2.0]), [-1.0, -2.0]);
    }

    #[test]
    fn image_nodes_of_a_period_lie_beyond_its_ends() {
        let ends = PlanBoundaries { periods: [Some((0.0, 2.0))], ..PlanBoundaries::default() };
        let mut found = Vec::new();
        image_nodes(&ends, &[[0.1], [1.0], [1.9]], 0.5, &mut found);
        let places: Vec<f64> =
            found.iter().map(|i| i.image_position(&[[0.1], [1.0], [1.9]][i.source as usize])[0]).collect();
        assert_eq!(places.len(), 2);
        assert!((places[0] - 2.1).abs() < 1e-12 && (places[1] + 0.1).abs() < 1e-12);
        let (mut x, mut origin) = ([4.5], [1.0]);
        ends.wrap_into_period(&mut x, &mut origin);
        assert!((x[0] - 0.5f64).abs() < 1e-12 && (origin[0] + 3.0f64).abs() < 1e-12);
    }
}
