//! Length, area or volume of a shape.

use crate::plan::polygon::{first_moment, signed_area};
use crate::shape::Shape;

impl Shape {
    /// Length, area or volume of a valid shape (m, m², m³). Where the first axis is a `radius`, the volume per radian (m³). Without a
    /// closed form it is the sum of exact chords along the last axis, at positions close enough for three digits.
    pub fn volume(&self, dimension: usize, radius: bool) -> f64 {
        let exact = if radius { self.volume_of_revolution() } else { self.measure(dimension) };
        if let Some(exact) = exact {
            return exact;
        }
        let (low, high) = self.bounds(dimension);
        let (along, places) = (dimension - 1, if dimension == 3 { 256 } else { 1024 });
        let chord = |number: usize| {
            let mut x = low.clone();
            let (mut rest, mut area) = (number, 1.0);
            for c in 0..along {
                let width = (high[c] - low[c]) / places as f64;
                x[c] += width * ((rest % places) as f64 + 0.5);
                (rest, area) = (rest / places, area * width);
            }
            let mut cuts = self.crossings(&x, along);
            cuts.sort_by(f64::total_cmp);
            let inside = cuts.windows(2).filter(|pair| {
                let mut middle = x.clone();
                middle[along] = 0.5 * (pair[0] + pair[1]);
                self.contains(&middle)
            });
            let length: f64 = inside.map(|pair| pair[1] - pair[0]).sum();
            length * area * if radius { x[0] } else { 1.0 }
        };
        (0..places.pow(along as u32)).map(chord).sum()
    }

    /// Length, area or volume of a shape in closed form (m, m², m³); `None` where it has none.
    pub fn measure(&self, dimension: usize) -> Option<f64> {
        match self {
            Self::Box { min, max } => Some(min.iter().zip(max).map(|(low, high)| high - low).product()),
            Self::Ball { radius: r, .. } => match dimension {
                1 => Some(2.0 * r),
                2 => Some(std::f64::consts::PI * r * r),
                _ => Some(4.0 / 3.0 * std::f64::consts::PI * r.powi(3)),
            },
            Self::Polygon { vertices } | Self::ArcLayer { outline: vertices, .. } => {
                Some(signed_area(vertices).abs())
            }
            Self::Cylinder { radius, height, .. } => Some(std::f64::consts::PI * radius * radius * height),
            Self::Microstructure { min, max, .. } => {
                let space: f64 = min.iter().zip(max).map(|(low, high)| high - low).product();
                Some(space * self.packing()?.fraction)
            }
            Self::Layer { laid, .. } => laid.volume(),
            Self::Union { .. } | Self::Intersection { .. } | Self::Difference { .. } => None,
        }
    }

    /// Volume per radian (m³) of the solid of revolution of a plane shape about the axis where its first coordinate is zero. `None` where
    /// it has no closed form.
    fn volume_of_revolution(&self) -> Option<f64> {
        match self {
            Self::Box { min, max } => Some(0.5 * (min[0] + max[0]) * self.measure(2)?),
            // Parts beyond the axis do not count.
            Self::Ball { centre, radius } if centre[0] >= *radius => Some(centre[0] * self.measure(2)?),
            Self::Polygon { vertices } => Some(first_moment(vertices).abs()),
            _ => None,
        }
    }
}
