//! Surface of revolution of a polygon.

use super::vector::{add_scaled, unit};
use super::{ContactQuery, FacettedSurface, NearestPoint, Surface, SurfaceError};

/// Solid of revolution of a polygon about an axis through the origin.
#[derive(Clone, Debug)]
pub struct RevolvedSurface {
    /// Section (distance from the axis, coordinate along it); a polygon that touches the axis is completed by its mirror image.
    section: FacettedSurface<2>,
    axis: usize,
}

impl RevolvedSurface {
    /// Solid of revolution of the polygon of these corners (m: distance from the axis, coordinate along it) about `axis` (0 is x).
    ///
    /// # Errors
    /// When a corner lies beyond the axis, when the polygon crosses itself or touches the axis in several parts.
    pub fn new(corners: &[[f64; 2]], axis: usize) -> Result<Self, SurfaceError> {
        if let Some(number) = corners.iter().position(|corner| !(corner[0] >= 0.0)) {
            let problem =
                format!("{} is not a distance from the axis, which must be 0 or more", corners[number][0]);
            return Err(SurfaceError::new(format!("points[{number}]"), problem));
        }
        // Errors of the polygon itself are reported first.
        FacettedSurface::polygon(corners)?;
        let count = corners.len();
        let on_axis = |number: usize| corners[number % count][0] == 0.0;
        // Corners at which the polygon leaves the axis.
        let leaves: Vec<usize> = (0..count).filter(|k| on_axis(*k) && !on_axis(k + 1)).collect();
        let section = match leaves[..] {
            [] => corners.to_vec(),
            [first] => {
                let off = (first + 1..first + count).take_while(|k| !on_axis(*k));
                let mut half: Vec<[f64; 2]> = off.map(|k| corners[k % count]).collect();
                let last = corners[(first + 1 + half.len()) % count];
                let mirrored: Vec<[f64; 2]> = half.iter().rev().map(|[r, z]| [-r, *z]).collect();
                half.insert(0, corners[first]);
                if last != corners[first] {
                    half.push(last);
                }
                half.extend(mirrored);
                half
            }
            _ => return Err(SurfaceError::new("points", "touch the axis in several pieces")),
        };
        Ok(Self { section: FacettedSurface::polygon(&section)?, axis })
    }

    /// Distance of a position from the axis, coordinate along the axis, and radial direction.
    fn to_section(&self, x: &[f64; 3]) -> ([f64; 2], [f64; 3]) {
        let mut across = *x;
        across[self.axis] = 0.0;
        let radius = across.iter().map(|c| c * c).sum::<f64>().sqrt();
        let any = std::array::from_fn(|c| f64::from(u8::from(c == (self.axis + 1) % 3)));
        ([radius, x[self.axis]], unit(&across).unwrap_or(any))
    }

    /// Nearest point in space, from the one in the meridian plane through the direction `outward`.
    fn section_to_space(&self, flat: &NearestPoint<2>, outward: &[f64; 3]) -> NearestPoint<3> {
        let full = |[r, z]: [f64; 2]| {
            let mut x = add_scaled(&[0.0; 3], r, outward);
            x[self.axis] = z;
            x
        };
        NearestPoint {
            distance: flat.distance,
            normal: full(flat.normal),
            position: full(flat.position),
            feature_id: flat.feature_id,
        }
    }
}

impl Surface<3> for RevolvedSurface {
    fn contains(&self, x: &[f64; 3]) -> bool {
        self.section.contains(&self.to_section(x).0)
    }

    fn gap(&self, x: &[f64; 3], reach: f64) -> Option<NearestPoint<3>> {
        let (flat, outward) = self.to_section(x);
        self.section.gap(&flat, reach).map(|gap| self.section_to_space(&gap, &outward))
    }

    fn query_contacts(&self, x: &[f64; 3], radius: f64, found: &mut ContactQuery<3>) {
        let (flat, outward) = self.to_section(x);
        found.add_planar_contacts(&self.section, &flat, radius, |place| {
            self.section_to_space(place, &outward)
        });
    }

    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let (low, high) = self.section.bounds();
        let far = high[0].max(-low[0]);
        let corner =
            |side: f64, along: f64| std::array::from_fn(|c| if c == self.axis { along } else { side * far });
        (corner(-1.0, low[1]), corner(1.0, high[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_revolved_rectangle_is_a_cylinder() {
        for corners in [
            [[0.0, -1.0], [2.0, -1.0], [2.0, 1.0], [0.0, 1.0]],
            [[2.0, 1.0], [2.0, -1.0], [0.0, -1.0], [0.0, 1.0]],
        ] {
            let cylinder = RevolvedSurface::new(&corners, 1).unwrap();
            let gap = |x: [f64; 3]| cylinder.gap(&x, 9.0).unwrap();
            let side = gap([3.0, 0.2, 4.0]);
            assert!((side.distance - 3.0).abs() < 1e-12 && (side.normal[0] - 0.6).abs() < 1e-12);
            assert!((side.position[2] - 1.6).abs() < 1e-12);
            assert!((gap([0.0, 0.4, 0.0]).distance + 0.6).abs() < 1e-12, "the axis is no surface");
            assert!(cylinder.contains(&[1.0, 0.0, -1.0]) && !cylinder.contains(&[2.0, 0.0, -1.0]));
            let mut found = ContactQuery::default();
            cylinder.query_contacts(&[0.5, 1.2, 0.0], 0.3, &mut found);
            assert_eq!(found.len(), 1);
            assert_eq!(found.contacts()[0].normal, [0.0, 1.0, 0.0]);
        }
    }

    #[test]
    fn rings_and_cones_revolve_and_profiles_beyond_the_axis_are_refused() {
        let ring = RevolvedSurface::new(&[[2.0, 0.0], [3.0, 0.0], [3.0, 1.0], [2.0, 1.0]], 2).unwrap();
        assert!(!ring.contains(&[0.0, 0.0, 0.5]) && ring.contains(&[0.0, 2.5, 0.5]));
        let cone = RevolvedSurface::new(&[[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]], 2).unwrap();
        assert!(cone.contains(&[0.0, 0.0, 0.9]) && !cone.contains(&[0.2, 0.0, 0.9]));
        assert_eq!(cone.bounds(), ([-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]));
        assert!(RevolvedSurface::new(&[[-0.1, 0.0], [1.0, 0.0], [0.0, 1.0]], 2).is_err());
    }
}
