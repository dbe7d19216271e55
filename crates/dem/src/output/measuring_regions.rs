//! Measuring regions: circles, in space spheres, at fixed places in the packing (sheet: dem §3.9).

use std::f64::consts::PI;

use colluvium_case::measure::ScalarOutput;
use colluvium_case::spatial;
use colluvium_points::Shape;

use crate::boundary::periodic_cell::{PeriodicCell, apply, inverse};
use crate::output::packing_view::PackingView;
use crate::points::grains::volume;
use crate::points::vector::{add, difference, norm};

/// Common area of two disks (m²), or common volume of two balls (m³), from radii and distance of the centres (m).
pub fn overlap_volume(dimension: usize, [a, b]: [f64; 2], distance: f64) -> f64 {
    if distance >= a + b {
        return 0.0;
    }
    if distance <= (a - b).abs() {
        return volume(dimension, a.min(b));
    }
    let d = distance;
    if dimension == 3 {
        let (sum, difference) = (a + b - d, a - b);
        return PI * sum * sum * (d * d + 2.0 * d * (a + b) - 3.0 * difference * difference) / (12.0 * d);
    }
    // Four times the area of the triangle of the centres and an intersection, from which the angles at the centres follow.
    let area = ((a + b - d) * (d + a - b) * (d - a + b) * (d + a + b)).max(0.0).sqrt();
    let angle = |r: f64, other: f64| area.atan2((d - other) * (d + other) + r * r);
    a * a * angle(a, b) + b * b * angle(b, a) - 0.5 * area
}

/// Distance up to which a grain may be outside the cell, in cells.
const OUTSIDE_TOLERANCE: f64 = 0.5;

impl<const D: usize> PeriodicCell<D> {
    /// Displacements of all images that can have grains within `reach` of a point (m).
    fn shifts_around(&self, place: &[f64; D], reach: f64) -> Vec<[f64; D]> {
        let (middle, widths) = (self.reduced(&inverse(&self.h).0, place), self.widths());
        let ends = |c: usize| {
            let far = reach / widths[c] + OUTSIDE_TOLERANCE;
            let ends = [(middle[c] - far - 1.0).ceil() as i32, (middle[c] + far).floor() as i32];
            if self.periodic[c] { ends } else { [0, 0] }
        };
        let mut all = vec![[0; D]];
        for c in 0..D {
            let [first, last] = ends(c);
            let at = |mut steps: [i32; D], own| {
                steps[c] = own;
                steps
            };
            all = all.into_iter().flat_map(|steps| (first..=last).map(move |own| at(steps, own))).collect();
        }
        all.iter().map(|steps| self.shift(steps)).collect()
    }
}

impl<const D: usize, const R: usize> PackingView<'_, D, R> {
    /// Scalar outputs of each region of the options: porosity, coordination, velocity and stress.
    pub(crate) fn region_outputs(&self) -> Vec<ScalarOutput> {
        if self.clock.options.regions.is_empty() {
            return Vec::new();
        }
        let (stresses, counts) = self.grain_stresses();
        let g = &self.grains;
        let mut readings = Vec::new();
        for (name, region) in &self.clock.options.regions {
            let ball = Shape::Ball { centre: region.centre.clone(), radius: region.radius };
            let Shape::Ball { centre, radius } = self.clock.case.relative_to_origin(ball) else { continue };
            let centre: [f64; D] = std::array::from_fn(|c| centre[c]);
            // Area or volume of grains in the region; number, contacts, mass, momentum and stress of those with their centre there.
            let (mut solid, mut inside, mut touching, mut mass) = (0.0, 0.0, 0.0, 0.0);
            let (mut momentum, mut stress, mut own) = ([0.0; D], [0.0; 6], 0.0);
            let shifts = self.cell.geometry.shifts_around(&centre, radius + self.grains.radii().1);
            for i in 0..g.len() {
                for shift in &shifts {
                    let mut place = g.position[i];
                    add(&mut place, 1.0, shift);
                    let distance = norm(&difference(&place, &centre));
                    solid += overlap_volume(D, [radius, g.radius[i]], distance);
                    if distance > radius {
                        continue;
                    }
                    let v = volume(D, g.radius[i]);
                    (inside, touching, own) = (inside + 1.0, touching + counts[i], own + v);
                    mass += g.mass[i];
                    add(&mut momentum, g.mass[i], &g.velocity[i]);
                    add(&mut momentum, g.mass[i], &apply(&self.cell.geometry.velocity_gradient, shift));
                    (0..6).for_each(|c| stress[c] += v * stresses[i][c]);
                }
            }
            let mut read = |what: &str, unit: &str, value: f64| {
                readings.push((format!("{name}.{what}"), unit.to_owned(), value));
            };
            let share = solid / volume(D, radius);
            read("porosity", "", 1.0 - share);
            read("grains", "", inside);
            read("coordination", "", touching / inside);
            let velocity = spatial(&momentum.map(|p| p / mass));
            (0..D).for_each(|c| read(&format!("velocity.{}", ["x", "y", "z"][c]), "m/s", velocity[c]));
            let components: &[(usize, &str)] = match D {
                2 => &[(0, "xx"), (1, "yy"), (3, "xy")],
                _ => &[(0, "xx"), (1, "yy"), (2, "zz"), (3, "xy"), (4, "yz"), (5, "zx")],
            };
            components
                .iter()
                .for_each(|(c, axes)| read(&format!("stress.{axes}"), "Pa", share * stress[*c] / own));
        }
        readings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use colluvium_testkit::assert_near;

    #[test]
    fn a_lens_has_the_area_and_the_volume_of_the_textbook() {
        // Radii and distance 1: 2π/3 - √3/2, and 5π/12.
        assert_near(overlap_volume(2, [1.0, 1.0], 1.0), 2.0 * PI / 3.0 - 0.75f64.sqrt(), 1e-14);
        assert_near(overlap_volume(3, [1.0, 1.0], 1.0), 5.0 * PI / 12.0, 1e-14);
        // A sphere that a much larger one cuts at its middle, as a plane would.
        assert_near(overlap_volume(2, [1e5, 1.0], 1e5), 0.5 * PI, 1e-4);
        assert_near(overlap_volume(3, [1e4, 1.0], 1e4), 2.0 / 3.0 * PI, 1e-3);
        for dimension in [2, 3] {
            assert_near(overlap_volume(dimension, [2.0, 0.5], 1.2), volume(dimension, 0.5), 1e-14);
            assert_near(overlap_volume(dimension, [2.0, 0.5], 2.5), 0.0, 1e-14);
        }
    }
}
