//! Extruded polygon, as a closed triangle mesh.

use super::{FacettedSurface, SurfaceError};

impl FacettedSurface<3> {
    /// Extrudes the polygon of these corners (m), in the plane of the other two axes in the order x, y, z, along `axis` (0 is x) between
    /// two coordinates (m).
    ///
    /// # Errors
    /// See [`FacettedSurface::polygon`]; when `to` is not larger than `from`.
    pub fn extruded(corners: &[[f64; 2]], axis: usize, from: f64, to: f64) -> Result<Self, SurfaceError> {
        if !(from < to) {
            return Err(SurfaceError::new("to", format!("{to} must be above from, {from}")));
        }
        let section = FacettedSurface::polygon(corners)?;
        let flat = section.vertices();
        let count = flat.len() as u32;
        let at = |[u, v]: [f64; 2], along: f64| {
            let mut rest = [u, v].into_iter();
            std::array::from_fn(|c| if c == axis { along } else { rest.next().unwrap_or_default() })
        };
        let vertices =
            [from, to].iter().flat_map(|along| flat.iter().map(|corner| at(*corner, *along))).collect();
        let caps = triangulate_by_ears(flat);
        let mut triangles: Vec<[u32; 3]> = caps.clone();
        triangles.extend(caps.iter().map(|[a, b, c]| [a + count, c + count, b + count]));
        for k in 0..count {
            let next = (k + 1) % count;
            triangles.extend([[next, k, k + count], [next, k + count, next + count]]);
        }
        Self::closed_surface(vertices, &triangles)
    }
}

/// Ear-clipping triangulation of a clockwise polygon that does not cross itself.
fn triangulate_by_ears(corners: &[[f64; 2]]) -> Vec<[u32; 3]> {
    let area = |a: u32, b: u32, c: u32| {
        let [a, b, c] = [a, b, c].map(|k| corners[k as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut rest: Vec<u32> = (0..corners.len() as u32).collect();
    let mut triangles = Vec::with_capacity(corners.len() - 2);
    while rest.len() > 3 {
        let count = rest.len();
        let around = |k: usize| [rest[(k + count - 1) % count], rest[k], rest[(k + 1) % count]];
        let is_ear = |k: &usize| {
            let [a, b, c] = around(*k);
            let holds = |p: &u32| {
                ![a, b, c].contains(p)
                    && area(a, b, *p) <= 0.0
                    && area(b, c, *p) <= 0.0
                    && area(c, a, *p) <= 0.0
            };
            area(a, b, c) < 0.0 && !rest.iter().any(holds)
        };
        // A polygon that does not cross itself has an ear; the first corner is taken where round-off hides it.
        let ear = (0..count).find(is_ear).unwrap_or_default();
        triangles.push(around(ear));
        rest.remove(ear);
    }
    triangles.extend(<[u32; 3]>::try_from(rest).ok());
    triangles
}

#[cfg(test)]
mod tests {
    use crate::Shape;
    use crate::surface::{FacettedSurface, Surface};

    #[test]
    fn a_drawn_polygon_is_solid_where_the_polygon_is() {
        let corners = [[-0.8, -0.8], [0.9, -0.6], [0.7, 0.8], [0.0, -0.1], [-0.7, 0.6]];
        let flat = Shape::Polygon { vertices: corners.to_vec().into() };
        for axis in 0..3 {
            let solid = FacettedSurface::extruded(&corners, axis, -1.0, 2.0).unwrap();
            for number in 0..400 {
                let (u, v) = (-1.0 + 0.103 * f64::from(number % 20), -1.0 + 0.101 * f64::from(number / 20));
                let mut rest = [u, v].into_iter();
                let x = std::array::from_fn(|c| if c == axis { 0.7 } else { rest.next().unwrap() });
                assert_eq!(solid.contains(&x), flat.contains(&[u, v]), "axis {axis} at {u}, {v}");
            }
            let mut beyond = [0.0; 3];
            beyond[axis] = 2.5;
            beyond[(axis + 1) % 3] = -0.3;
            assert!(!solid.contains(&beyond));
        }
        assert!(FacettedSurface::extruded(&corners, 2, 1.0, 1.0).is_err());
    }
}
