//! Bishop's simplified method for a homogeneous slope on a firm base at the level of its toe: the limit-equilibrium check of factors of
//! safety (Bishop 1955; sheet: sph V-40).

use crate::analysis::statistics::grid_search_minimum;

/// Homogeneous slope whose toe is the origin. It rises towards positive x up to its height and is level behind the crest.
#[derive(Clone, Copy, Debug)]
pub struct HomogeneousSlope {
    /// Height of the slope (m).
    pub height: f64,
    /// Horizontal length of the face over its height.
    pub cotangent: f64,
    /// Unit weight (N/m³).
    pub unit_weight: f64,
    /// Cohesion of the soil (Pa).
    pub cohesion: f64,
    /// Friction angle (degrees).
    pub friction_angle: f64,
}

/// Slip circle and its factor of safety.
#[derive(Clone, Copy, Debug)]
pub struct SlipCircle {
    /// Centre of the circle (m).
    pub centre: [f64; 2],
    /// Radius of the circle (m).
    pub radius: f64,
    /// Position at which the slip surface leaves the slope at its face (m).
    pub toe_exit: f64,
    /// Position at which the slip surface enters the slope at its crest (m).
    pub crest_entry: f64,
    /// Factor of safety.
    pub safety_factor: f64,
}

impl SlipCircle {
    /// Height of the slip surface (m).
    pub fn elevation(&self, x: f64) -> f64 {
        self.centre[1] - (self.radius * self.radius - (x - self.centre[0]).powi(2)).max(0.0).sqrt()
    }

    /// Distance of a point from the circle (m), negative inside.
    pub fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        (x - self.centre[0]).hypot(y - self.centre[1]) - self.radius
    }
}

/// Number of slices of the sliding mass.
const SLICES: usize = 200;
/// Number of positions per direction in each pass of the search, and the ratio of the search width to that of the previous pass.
const SEARCH_GRID: (usize, f64) = (11, 0.5);

impl HomogeneousSlope {
    /// Slope with its strength divided by a factor.
    pub fn weakened(&self, factor: f64) -> Self {
        Self {
            cohesion: self.cohesion / factor,
            friction_angle: (self.friction_angle.to_radians().tan() / factor).atan().to_degrees(),
            ..*self
        }
    }

    /// Height of the ground surface at `x` (m).
    fn surface(&self, x: f64) -> f64 {
        (x / self.cotangent).clamp(0.0, self.height)
    }

    /// Slip circle through two points of the surface with a sag (m) below their chord.
    fn slip_circle(&self, exit: f64, entry: f64, sag: f64) -> Option<SlipCircle> {
        let (low, high) = ([exit, self.surface(exit)], [entry, self.surface(entry)]);
        let (centre, radius) = circle_through(low, high, sag);
        // Overhanging at its entry, or below the firm base.
        let lowest = if centre[0] > exit { centre[1] - radius } else { low[1] };
        let sound = centre[1] >= high[1] && lowest >= -1e-9 * self.height;
        sound.then_some(SlipCircle {
            centre,
            radius,
            toe_exit: exit,
            crest_entry: entry,
            safety_factor: f64::NAN,
        })
    }

    /// Factor of safety of a circle, by iteration.
    fn safety_factor(&self, circle: &SlipCircle) -> f64 {
        let width = (circle.crest_entry - circle.toe_exit) / SLICES as f64;
        let friction = self.friction_angle.to_radians().tan();
        let slices: Vec<(f64, f64)> = (0..SLICES)
            .map(|k| {
                let x = circle.toe_exit + (k as f64 + 0.5) * width;
                let depth = (self.surface(x) - circle.elevation(x)).max(0.0);
                (self.unit_weight * depth * width, (x - circle.centre[0]) / circle.radius)
            })
            .collect();
        let driving: f64 = slices.iter().map(|(weight, sine)| weight * sine).sum();
        solve_safety_factor(driving, |factor| {
            let share = |(weight, sine): &(f64, f64)| {
                let cosine = (1.0 - sine * sine).sqrt();
                (self.cohesion * width + weight * friction) / (cosine + sine * friction / factor)
            };
            slices.iter().map(share).sum()
        })
    }

    /// Circle with the least factor of safety.
    pub fn critical_circle(&self) -> Option<SlipCircle> {
        let face = self.height * self.cotangent;
        let limits = [(0.0, 0.5 * face), (face, face + 3.0 * self.height), (1e-3 * self.height, self.height)];
        let circle = |[exit, entry, sag]: [f64; 3]| self.slip_circle(exit, entry, sag);
        let factor = |at: [f64; 3]| circle(at).map_or(f64::INFINITY, |circle| self.safety_factor(&circle));
        let (factor, at) = grid_search_minimum(limits, SEARCH_GRID, factor)?;
        Some(SlipCircle { safety_factor: factor, ..circle(at)? })
    }
}

/// Centre and radius of the circle through two points with a sag (m) below their chord.
pub fn circle_through(low: [f64; 2], high: [f64; 2], sag: f64) -> ([f64; 2], f64) {
    let along = [high[0] - low[0], high[1] - low[1]];
    let chord = along[0].hypot(along[1]);
    let radius = (0.25 * chord * chord + sag * sag) / (2.0 * sag);
    let rise = (radius - sag) / chord;
    let centre = [0.5 * (low[0] + high[0]) - rise * along[1], 0.5 * (low[1] + high[1]) + rise * along[0]];
    (centre, radius)
}

/// Factor of safety at which the resistance `resisting(factor)` balances the driving moment of a circle. Infinite without a driving moment,
/// or where `resisting` is infinite.
pub fn solve_safety_factor(driving: f64, resisting: impl Fn(f64) -> f64) -> f64 {
    let mut factor = 1.0;
    for _ in 0..100 {
        let next = resisting(factor) / driving;
        if next.is_infinite() {
            return f64::INFINITY;
        }
        if (next - factor).abs() < 1e-10 {
            break;
        }
        factor = next;
    }
    if driving > 0.0 && factor > 0.0 { factor } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_of_griffiths_and_lane() {
        let slope = HomogeneousSlope {
            height: 10.0,
            cotangent: 2.0,
            unit_weight: 20e3,
            cohesion: 10e3,
            friction_angle: 20.0,
        };
        let circle = slope.critical_circle().unwrap();
        assert!((circle.safety_factor - 1.379).abs() < 2e-3, "{circle:?}");
    }

    #[test]
    fn a_factor_scales_with_strength() {
        let slope = HomogeneousSlope {
            height: 5.0,
            cotangent: 1.0,
            unit_weight: 18e3,
            cohesion: 12e3,
            friction_angle: 25.0,
        };
        let factor = slope.critical_circle().unwrap().safety_factor;
        assert!((slope.weakened(factor).critical_circle().unwrap().safety_factor - 1.0).abs() < 1e-6);
    }
}
