//! Load vectors of points next to a loaded surface, for all methods (sheet: mpm §2.11).
//!
//! Each point has a vector: for a traction its force, which is constant ("dead load"); for a pressure its force, and for a load on a curved
//! surface its area, both of which follow the motion of the point by Nanson's formula, `dA ← det f f⁻ᵀ dA`.

use colluvium_points::boundary_area_vectors;

use crate::description::{Load, Side, Space};
use crate::{Case, CaseError};

/// Spacing of the lines that detect a surface over that of the points.
const LINE_SPACING: f64 = 0.25;

/// Line spacing over point spacing for points in rows along the surface in the plane, which thus get equal shares of it.
const FINE_LINE_SPACING: f64 = 1.0 / 64.0;

impl Case {
    /// Start times of the loads (s); infinite until their stage begins.
    pub fn load_starts(&self) -> Vec<f64> {
        self.loads.iter().map(|load| if load.stage().is_none() { 0.0 } else { f64::INFINITY }).collect()
    }

    /// Sets the start times (s) of the loads that begin with a stage, whose start is `start` (s).
    pub fn begin_loads(&self, starts: &mut [f64], stage: usize, start: f64) {
        for (load, begins) in self.loads.iter().zip(starts) {
            if load.stage().is_some_and(|name| name == self.stages[stage].name) {
                *begins = start;
            }
        }
    }

    /// Load vectors of points at `positions` (m). For a load on a side they are the full force (N; per metre in the plane, per radian in
    /// axisymmetry), for other loads the area (m²) times the outward normal. Zero within the body.
    ///
    /// # Errors
    /// When a load that is not bound to a side has no surface.
    pub fn load_vectors<const D: usize>(
        &self,
        number: usize,
        positions: &[[f64; D]],
        extent: &[f64; D],
    ) -> Result<Vec<[f64; D]>, CaseError> {
        let load = &self.loads[number];
        if let Some(side) = load.loaded_side() {
            let per_area = load.per_area::<D>();
            let areas = self.side_areas(load, side, positions, extent);
            return Ok(areas.into_iter().map(|area| per_area.map(|t| t * area)).collect());
        }
        let Load::Surface { body, within, .. } = load else { return Ok(vec![[0.0; D]; positions.len()]) };
        let Some(body) = self.bodies.iter().find(|own| own.name == *body) else { return Ok(Vec::new()) };
        let spacing = extent.iter().copied().fold(0.0, f64::max);
        let axisymmetric = self.space == Space::Axisymmetric;
        let share = if body.sampling.is_lattice() { LINE_SPACING } else { FINE_LINE_SPACING };
        let carried = boundary_area_vectors(&body.shape, positions, (spacing, share), |place| match within {
            Some(region) if !region.contains(place) => 0.0,
            _ if axisymmetric => place[0],
            _ => 1.0,
        });
        if carried.iter().all(|vector| *vector == [0.0; D]) {
            let problem = "no part of the surface of the body lies in it";
            return Err(CaseError::new(format!("loads[{number}].within"), problem));
        }
        Ok(carried)
    }

    /// Loaded area of each point (m²; m in the plane, per radian in axisymmetry) times the load profile at its position. Zero within the
    /// body.
    pub fn side_areas<const D: usize>(
        &self,
        load: &Load,
        side: Side,
        positions: &[[f64; D]],
        extent: &[f64; D],
    ) -> Vec<f64> {
        let (axis, sign) = (side.axis(), if side.is_max() { 1.0 } else { -1.0 });
        let outermost = positions.iter().map(|x| sign * x[axis]).fold(f64::NEG_INFINITY, f64::max);
        let across: f64 = (0..D).filter(|c| *c != axis).map(|c| extent[c]).product();
        let area = |position: &[f64; D]| {
            if sign * position[axis] <= outermost - 0.5 * extent[axis] {
                return 0.0;
            }
            let radius = match (self.space, side) {
                (Space::Axisymmetric, Side::XMin | Side::XMax) => position[0] + sign * 0.5 * extent[0],
                (Space::Axisymmetric, _) => position[0],
                _ => 1.0,
            };
            across * radius * load.profile_factor(position)
        };
        positions.iter().map(area).collect()
    }
}

impl Load {
    /// Full load per area (Pa) as a vector; zero for a load that is not bound to a side.
    pub fn per_area<const D: usize>(&self) -> [f64; D] {
        match self {
            Self::Traction { value, .. } => std::array::from_fn(|c| value[c]),
            Self::Pressure { side, value, .. } | Self::PorePressure { side, value, .. } => {
                let outwards = if side.is_max() { 1.0 } else { -1.0 };
                std::array::from_fn(|c| if c == side.axis() { -outwards * value } else { 0.0 })
            }
            Self::Surface { .. } => [0.0; D],
        }
    }

    /// Full force (N) of the load vector of a point.
    #[inline]
    pub fn force<const D: usize>(&self, carried: &[f64; D]) -> [f64; D] {
        let Self::Surface { pressure, shear, axis, .. } = self else { return *carried };
        let push = carried.map(|area| -pressure * area);
        let along = match (D, axis) {
            (3, Some(axis)) => {
                let size = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
                std::array::from_fn(|c| {
                    let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                    (axis[a] * carried[b] - axis[b] * carried[a]) / size
                })
            }
            (2, _) => std::array::from_fn(|c| if c == 0 { -carried[1] } else { carried[0] }),
            _ => [0.0; D],
        };
        std::array::from_fn(|c| push[c] + shear * along[c])
    }
}

/// Cofactor matrix `cof f = det f f⁻ᵀ`.
pub fn cofactor<const D: usize>(f: &[[f64; D]; D]) -> [[f64; D]; D] {
    let at = |a: usize, b: usize| f[a % D][b % D];
    match D {
        1 => [[1.0; D]; D],
        2 => std::array::from_fn(|a| {
            std::array::from_fn(|b| if a == b { at(1 - a, 1 - b) } else { -at(1 - a, 1 - b) })
        }),
        _ => std::array::from_fn(|a| {
            std::array::from_fn(|b| at(a + 1, b + 1) * at(a + 2, b + 2) - at(a + 1, b + 2) * at(a + 2, b + 1))
        }),
    }
}

/// Area vector after a displacement with the gradient `step`: `det f f⁻ᵀ a` for `f = 1 + step`.
pub fn nanson<const D: usize>(step: &[[f64; D]; D], a: &[f64; D]) -> [f64; D] {
    let f = std::array::from_fn(|i| std::array::from_fn(|j| step[i][j] + if i == j { 1.0 } else { 0.0 }));
    cofactor::<D>(&f).map(|row| row.iter().zip(a).map(|(cofactor, a)| cofactor * a).sum())
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    #[test]
    fn area_vectors_follow_nansons_formula() {
        // f = 2 along x, 3 along y, 5 along z: the area normal to x grows by 15.
        let step = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 4.0]];
        assert_eq!(nanson(&step, &[1.0, 1.0, 1.0]), [15.0, 10.0, 6.0]);
        let turned = nanson(&[[-1.0, -1.0], [1.0, -1.0]], &[1.0, 0.0]);
        assert_eq!(turned, [0.0, 1.0], "a quarter turn");
        assert_eq!(nanson(&[[0.5]], &[2.0]), [2.0]);
        // Shear along x does not change the surface normal to y and tilts the one normal to x.
        assert_eq!(nanson(&[[0.0, 0.5], [0.0, 0.0]], &[0.0, 1.0]), [0.0, 1.0]);
        assert_eq!(nanson(&[[0.0, 0.5], [0.0, 0.0]], &[1.0, 0.0]), [1.0, -0.5]);
    }

    /// Forces on the points of a lattice 0.1 m apart in the disk of 1 m at the origin.
    fn on_disk(load: Value) -> Vec<([f64; 2], [f64; 2])> {
        let mut load = load;
        (load["kind"], load["body"]) = (json!("surface"), json!("b"));
        let text = json!({
            "title": "disk", "space": "plane-strain", "domain": { "min": [-2, -2], "max": [2, 2] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0, 0], "radius": 1 } }],
            "loads": [load], "stages": [{ "name": "s", "duration": 1 }]
        });
        let case = Case::from_json(&text.to_string()).unwrap();
        let place = |k: usize| [0.1 * (k % 20) as f64 - 0.95, 0.1 * (k / 20) as f64 - 0.95];
        let points: Vec<[f64; 2]> = (0..400).map(place).filter(|[x, y]| x.hypot(*y) < 1.0).collect();
        let carried = case.load_vectors(0, &points, &[0.1, 0.1]).unwrap();
        points.into_iter().zip(carried.iter().map(|vector| case.loads[0].force(vector))).collect()
    }

    /// A pressure on a disk has no resultant and a virial of its area; a shear has no resultant, and a moment of twice that.
    #[test]
    fn pressure_and_shear_around_a_disk_have_the_resultants_of_the_closed_form() {
        let sums = |forces: &[([f64; 2], [f64; 2])]| {
            let sum =
                |of: &dyn Fn(&[f64; 2], &[f64; 2]) -> f64| forces.iter().map(|(x, f)| of(x, f)).sum::<f64>();
            [
                sum(&|_, f| f[0]),
                sum(&|_, f| f[1]),
                sum(&|x, f| x[0] * f[0] + x[1] * f[1]),
                sum(&|x, f| x[0] * f[1] - x[1] * f[0]),
            ]
        };
        let twice = 2.0 * std::f64::consts::PI;
        // Forces act at points, up to half a spacing within the circle.
        let near = |found: f64, exact: f64| (found / exact - 1.0).abs() < 0.06;
        let [x, y, virial, moment] = sums(&on_disk(json!({ "pressure": 3 })));
        assert!(
            x.abs() + y.abs() + moment.abs() < 1e-12 && near(virial, -3.0 * twice),
            "{x} {y} {virial} {moment}"
        );
        let [x, y, virial, moment] = sums(&on_disk(json!({ "shear": 3 })));
        assert!(
            x.abs() + y.abs() + virial.abs() < 1e-12 && near(moment, 3.0 * twice),
            "{x} {y} {virial} {moment}"
        );
    }

    /// The resultant on the right half is the pressure times the width.
    #[test]
    fn a_part_of_a_surface_carries_its_projection() {
        let half = json!({ "kind": "box", "min": [0, -2], "max": [2, 2] });
        let forces = on_disk(json!({ "pressure": 3, "within": half }));
        let sum: [f64; 2] = std::array::from_fn(|c| forces.iter().map(|(_, f)| f[c]).sum());
        assert!((sum[0] + 6.0).abs() < 1e-9 && sum[1].abs() < 1e-9, "{sum:?}");
        assert!(forces.iter().all(|([x, _], f)| *x > -0.06 || *f == [0.0; 2]));
    }
}
