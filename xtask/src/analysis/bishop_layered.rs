//! Bishop's simplified method for a slope of several soils on a firm base (Bishop 1955): the limit-equilibrium check of factors of safety
//! of layered slopes.

use crate::analysis::bishop_circle::{circle_through, solve_safety_factor};
use crate::analysis::statistics::grid_search_minimum;

/// Soil layer, which reaches from its top down to the next layer.
#[derive(Clone, Debug)]
pub struct SoilLayer {
    /// Corners of its top, from left to right (m); level beyond them.
    pub top: Vec<[f64; 2]>,
    /// Unit weight (N/m³).
    pub unit_weight: f64,
    /// Cohesion of the soil (Pa).
    pub cohesion: f64,
    /// Friction angle (degrees).
    pub friction_angle: f64,
}

/// Layered slope that rises towards positive x. The top of the first soil is the surface.
#[derive(Clone, Debug)]
pub struct LayeredSlope {
    /// Soils, from the uppermost to the lowest.
    pub soils: Vec<SoilLayer>,
    /// Level of the firm base (m).
    pub base: f64,
}

/// Number of slices of the sliding mass.
const SLICES: usize = 100;
/// Number of positions per direction in each pass of the search, and the ratio of the search width to that of the previous pass.
const SEARCH_GRID: (usize, f64) = (11, 0.6);
/// Least `cos α + sin α tan φ / F` of a slice: below it the normal force on its base is not meaningful (Whitman & Bailey 1967).
const MIN_SLICE_DENOMINATOR: f64 = 0.2;

/// Height of a line at `x` (m).
fn height(line: &[[f64; 2]], x: f64) -> f64 {
    let after = line.iter().position(|corner| corner[0] >= x).unwrap_or(line.len() - 1).max(1);
    let [[x0, y0], [x1, y1]] = [line[after - 1], line[after]];
    y0 + (y1 - y0) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0)
}

impl LayeredSlope {
    /// Height of the ground surface at `x` (m).
    fn surface(&self, x: f64) -> f64 {
        height(&self.soils[0].top, x)
    }

    /// Weight of the soil above `y` at `x`, per width (N/m²), and the soil at that point.
    fn column_weight(&self, x: f64, y: f64) -> (f64, &SoilLayer) {
        let (mut weight, mut above, mut here) = (0.0, self.surface(x), &self.soils[0]);
        for (number, soil) in self.soils.iter().enumerate() {
            let below = self.soils.get(number + 1).map_or(f64::NEG_INFINITY, |next| height(&next.top, x));
            let bottom = below.max(y).min(above);
            weight += soil.unit_weight * (above - bottom);
            above = bottom;
            here = soil;
            if below <= y {
                break;
            }
        }
        (weight, here)
    }

    /// Factor of safety of the circle through two points of the surface with a sag (m) below their chord. Infinite for an invalid circle.
    fn safety_factor(&self, [exit, entry, sag]: [f64; 3]) -> f64 {
        let (low, high) = ([exit, self.surface(exit)], [entry, self.surface(entry)]);
        let (centre, radius) = circle_through(low, high, sag);
        let deep = centre[0] > exit && centre[1] - radius < self.base;
        if centre[1] < high[1] || deep {
            return f64::INFINITY;
        }
        let width = (entry - exit) / SLICES as f64;
        let (mut slices, mut driving) = (Vec::with_capacity(SLICES), 0.0);
        for k in 0..SLICES {
            let x = exit + (k as f64 + 0.5) * width;
            let y = centre[1] - (radius * radius - (x - centre[0]).powi(2)).max(0.0).sqrt();
            if y > self.surface(x) + 1e-9 {
                return f64::INFINITY;
            }
            let (weight, soil) = self.column_weight(x, y);
            let friction = soil.friction_angle.to_radians().tan();
            let sine = (x - centre[0]) / radius;
            driving += weight * width * sine;
            slices.push([
                (soil.cohesion + weight * friction) * width,
                friction,
                sine,
                (1.0 - sine * sine).sqrt(),
            ]);
        }
        solve_safety_factor(driving, |factor| {
            let mut resisting = 0.0;
            for [strength, friction, sine, cosine] in &slices {
                let share = cosine + sine * friction / factor;
                if share < MIN_SLICE_DENOMINATOR {
                    return f64::INFINITY;
                }
                resisting += strength / share;
            }
            resisting
        })
    }

    /// Least factor of safety of circles whose exit and entry at the surface are in these ranges (m).
    pub fn min_safety_factor(&self, exit: (f64, f64), entry: (f64, f64)) -> f64 {
        let deepest = self.surface(entry.1) - self.base;
        let limits = [exit, entry, (0.02 * deepest, deepest)];
        grid_search_minimum(limits, SEARCH_GRID, |at| self.safety_factor(at))
            .map_or(f64::NAN, |(factor, _)| factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::bishop_circle::HomogeneousSlope;

    #[test]
    fn of_one_soil_it_is_the_factor_of_a_homogeneous_slope() {
        let one = HomogeneousSlope {
            height: 10.0,
            cotangent: 2.0,
            unit_weight: 20e3,
            cohesion: 10e3,
            friction_angle: 20.0,
        };
        let top = vec![[0.0, 0.0], [20.0, 10.0]];
        let soil = SoilLayer { top, unit_weight: 20e3, cohesion: 10e3, friction_angle: 20.0 };
        let slope = LayeredSlope { soils: vec![soil], base: 0.0 };
        let (found, known) = (
            slope.min_safety_factor((0.0, 10.0), (20.0, 50.0)),
            one.critical_circle().unwrap().safety_factor,
        );
        assert!((found / known - 1.0).abs() < 2e-3, "{found} for {known}");
    }

    #[test]
    fn two_equal_layers_have_the_factor_of_one() {
        let soil =
            |top: Vec<[f64; 2]>| SoilLayer { top, unit_weight: 19e3, cohesion: 5e3, friction_angle: 25.0 };
        let surface = vec![[0.0, 0.0], [20.0, 10.0]];
        let factor = |soils| LayeredSlope { soils, base: -5.0 }.min_safety_factor((-5.0, 5.0), (20.0, 40.0));
        let whole = factor(vec![soil(surface.clone())]);
        let cut = factor(vec![soil(surface), soil(vec![[0.0, -1.0], [20.0, 3.0]])]);
        assert!((whole - cut).abs() < 1e-12, "{whole} {cut}");
    }
}
