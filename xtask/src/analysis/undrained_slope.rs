//! Upper bounds of limit analysis for slopes of undrained clays: a slip circle, which is a kinematically admissible motion of frictionless
//! soil, and a block that slides along a weak layer, pushed by a wedge. The least of such factors is at least the exact one.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::analysis::statistics::grid_search_minimum;

/// Slope in layered clay whose toe is the origin. It rises towards positive x up to its height and is level behind the crest; the clays are
/// level.
#[derive(Clone, Debug)]
pub struct LayeredClaySlope {
    /// Height of the slope (m).
    pub height: f64,
    /// Horizontal length of the face over its height.
    pub cotangent: f64,
    /// Unit weight (N/m³).
    pub unit_weight: f64,
    /// Levels of the tops of the clays (m; infinite for the uppermost) and their undrained strengths (Pa), from the uppermost down.
    pub layers: Vec<(f64, f64)>,
    /// Level of the firm base (m).
    pub base: f64,
}

/// Number of segments into which a slip circle is divided.
const ARC_SEGMENTS: usize = 400;
/// Number of positions per direction in each pass of a search, and the ratio of the search width to that of the previous pass.
const SEARCH_GRID: (usize, f64) = (11, 0.6);

impl LayeredClaySlope {
    /// Height of the ground surface at `x` (m).
    fn surface(&self, x: f64) -> f64 {
        (x / self.cotangent).clamp(0.0, self.height)
    }

    /// Undrained strength at a height (Pa).
    fn strength(&self, y: f64) -> f64 {
        self.layers.iter().rev().find(|(top, _)| y <= *top).map_or(f64::NAN, |(_, strength)| *strength)
    }

    /// Factor of safety of a circle: the moment of the strengths along it over that of the weight above it.
    fn circle_safety_factor(&self, centre: [f64; 2], radius: f64) -> f64 {
        if centre[1] < self.height || radius <= 0.0 {
            return f64::INFINITY;
        }
        let width = PI / ARC_SEGMENTS as f64;
        let (mut resisting, mut driving, mut within) = (0.0, 0.0, Vec::new());
        for k in 0..ARC_SEGMENTS {
            let (sine, cosine) = (-FRAC_PI_2 + (k as f64 + 0.5) * width).sin_cos();
            let [x, y] = [centre[0] + radius * sine, centre[1] - radius * cosine];
            let depth = self.surface(x) - y;
            if depth > 0.0 {
                within.push(k);
                resisting += radius * radius * width * self.strength(y);
                driving += self.unit_weight * depth * radius * cosine * width * (x - centre[0]);
            }
        }
        let in_one_piece = within.first().zip(within.last()).is_some_and(|(a, b)| b - a + 1 == within.len());
        if in_one_piece && driving > 0.0 { resisting / driving } else { f64::INFINITY }
    }

    /// Least factor of safety of circles above the firm base.
    pub fn min_circle_safety_factor(&self) -> f64 {
        let (h, base) = (self.height, self.base);
        let limits = [(-h, 4.0 * h), (h, 6.0 * h), (0.2 * h, 9.0 * h)];
        let found = grid_search_minimum(limits, SEARCH_GRID, |[x, y, radius]| {
            self.circle_safety_factor([x, y], radius.min(y - base))
        });
        found.map_or(f64::INFINITY, |(factor, _)| factor)
    }

    /// Integral of the strength along a line (N/m).
    fn strength_integral(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let piece = |k: usize| {
            let share = (k as f64 + 0.5) / ARC_SEGMENTS as f64;
            self.strength(from[1] + share * (to[1] - from[1]))
        };
        (0..ARC_SEGMENTS).map(piece).sum::<f64>() / ARC_SEGMENTS as f64
            * (to[0] - from[0]).hypot(to[1] - from[1])
    }

    /// Factor of safety of a block that slides along `level` (m) from `rear` (m) to below the toe. It is the dissipated work over the work
    /// of the weight. A wedge on a plane at `angle` (rad) pushes it along an interface that leans by `lean` (rad) into the slope; in front
    /// of the toe the block pushes up a wedge of 45°.
    fn block_safety_factor(&self, level: f64, [rear, angle, lean]: [f64; 3]) -> f64 {
        let foot = [rear, level];
        let direction = |angle: f64| [angle.cos(), angle.sin()];
        let Some((front, back)) = self
            .surface_intersection(foot, direction(FRAC_PI_2 - lean))
            .zip(self.surface_intersection(foot, direction(angle)))
        else {
            return f64::INFINITY;
        };
        let crest = [self.cotangent * self.height, self.height];
        let mut corners = vec![foot, back];
        corners.extend((front[0] < crest[0] && crest[0] < back[0]).then_some(crest));
        corners.push(front);
        // Velocities over that of the wedge behind: of the block, and along the interface.
        let (block, between) = (angle.cos() - angle.sin() * lean.tan(), angle.sin() / lean.cos());
        let (heel, toe) = ([0.0, level], [0.0, 0.0]);
        let lifted = 0.5 * level * level * block;
        let work = self.unit_weight * (polygon_area(&corners) * angle.sin() - lifted);
        if work <= 0.0 || block <= 0.0 || back[0] <= front[0] {
            return f64::INFINITY;
        }
        let behind = self.strength_integral(foot, back) + self.strength_integral(foot, front) * between;
        // The weaker of the clays at the boundary.
        let near = 1e-9 * self.height;
        let below = self.strength(level + near).min(self.strength(level - near)) * rear * block;
        let before = (self.strength_integral(heel, [level, 0.0]) * 2f64.sqrt()
            + self.strength_integral(heel, toe))
            * block;
        (behind + below + before) / work
    }

    /// Least factor of safety of blocks that slide along `level` (m), which is at the toe or below it.
    pub fn min_block_safety_factor(&self, level: f64) -> f64 {
        let limits = [(0.1 * self.height, 4.0 * self.height), (0.4, 1.4), (-1.2, 1.2)];
        grid_search_minimum(limits, SEARCH_GRID, |at| self.block_safety_factor(level, at))
            .map_or(f64::INFINITY, |(factor, _)| factor)
    }

    /// Intersection of a line from an interior point with the surface (m).
    fn surface_intersection(&self, from: [f64; 2], direction: [f64; 2]) -> Option<[f64; 2]> {
        let at = |t: f64| [from[0] + t * direction[0], from[1] + t * direction[1]];
        let below = |t: f64| at(t)[1] < self.surface(at(t)[0]);
        let far = 20.0 * self.height;
        let beyond = (1..=400).map(|k| far * f64::from(k) / 400.0).find(|t| !below(*t))?;
        let (mut low, mut high) = (beyond - far / 400.0, beyond);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if below(middle) { low = middle } else { high = middle }
        }
        Some(at(high))
    }
}

/// Area of a polygon (m²).
fn polygon_area(corners: &[[f64; 2]]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    0.5 * corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>().abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clays(lower: &[(f64, f64)], base: f64) -> LayeredClaySlope {
        let clays = [&[(f64::INFINITY, 50e3)], lower].concat();
        LayeredClaySlope { height: 10.0, cotangent: 2.0, unit_weight: 20e3, layers: clays, base }
    }

    #[test]
    fn one_clay_has_the_factor_of_taylor() {
        // Stability number 0.170 of a slope of 26.6° on a foundation of a depth equal to its height (Taylor 1937).
        assert!((clays(&[], -10.0).min_circle_safety_factor() - 0.25 / 0.170).abs() < 0.01);
    }

    #[test]
    fn safety_factor_scales_with_strength_and_decreases_with_weak_clay_below() {
        let one = clays(&[], -10.0).min_circle_safety_factor();
        let twice = LayeredClaySlope { layers: vec![(f64::INFINITY, 100e3)], ..clays(&[], -10.0) };
        assert!((twice.min_circle_safety_factor() / one - 2.0).abs() < 1e-6);
        let weaker = clays(&[(0.0, 30e3)], -10.0).min_circle_safety_factor();
        assert!(weaker < 0.75 * one && weaker > 0.6 * one, "{weaker}");
    }

    #[test]
    fn the_block_safety_factor_is_least_at_the_base_of_a_weak_layer() {
        let layered = clays(&[(0.0, 10e3), (-1.0, 50e3)], -5.0);
        let [top, base] = [0.0, -1.0].map(|level| layered.min_block_safety_factor(level));
        assert!((top - 1.2118).abs() < 5e-3 && (base - 1.0484).abs() < 5e-3, "{top} {base}");
        assert!(base < layered.min_circle_safety_factor());
    }

    #[test]
    fn a_vertical_shear_plane_raises_the_wedge_factor_by_half() {
        // 4 c / (γ H) of a wedge of 45° behind a vertical cut, and 2 c / (γ H) along the plane in front of it.
        let cut = LayeredClaySlope { cotangent: 1e-3, ..clays(&[], 0.0) };
        assert!((cut.block_safety_factor(0.0, [0.011, 0.25 * PI, 0.0]) / (4.0 * 0.25) - 1.5).abs() < 0.02);
    }
}
