//! Bishop's simplified method for a homogeneous slope on a firm base at the level of its toe: the limit-equilibrium
//! check of factors of safety (Bishop 1955; sheet: sph V-40).

/// A slope whose toe is the origin; it rises towards positive x to its height and is level behind.
#[derive(Clone, Copy, Debug)]
pub struct Slope {
    /// Height (m).
    pub height: f64,
    /// Horizontal length of the face over its height.
    pub cotangent: f64,
    /// Weight (N/m³).
    pub unit_weight: f64,
    /// Cohesion (Pa).
    pub cohesion: f64,
    /// Friction angle (degrees).
    pub friction_angle: f64,
}

/// A slip circle and its factor.
#[derive(Clone, Copy, Debug)]
pub struct Circle {
    /// Centre (m).
    pub centre: [f64; 2],
    /// Radius (m).
    pub radius: f64,
    /// Where it leaves the face (m).
    pub exit: f64,
    /// Where it meets the crest (m).
    pub entry: f64,
    /// Factor of safety.
    pub factor: f64,
}

impl Circle {
    /// Height of the slip surface (m).
    pub fn bottom(&self, x: f64) -> f64 {
        self.centre[1] - (self.radius * self.radius - (x - self.centre[0]).powi(2)).max(0.0).sqrt()
    }

    /// Distance of a point from it (m), negative within.
    pub fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        (x - self.centre[0]).hypot(y - self.centre[1]) - self.radius
    }
}

const SLICES: usize = 200;
/// Places per direction of a round of the search, and rounds, each in a finer box around the best circle.
const PLACES: usize = 11;
const ROUNDS: usize = 12;

impl Slope {
    /// The slope with its strength divided by a factor.
    pub fn weakened(&self, factor: f64) -> Self {
        Self {
            cohesion: self.cohesion / factor,
            friction_angle: (self.friction_angle.to_radians().tan() / factor).atan().to_degrees(),
            ..*self
        }
    }

    fn surface(&self, x: f64) -> f64 {
        (x / self.cotangent).clamp(0.0, self.height)
    }

    /// The circle through two points of the surface with a sag (m) below their chord.
    fn circle(&self, exit: f64, entry: f64, sag: f64) -> Option<Circle> {
        let (low, high) = ([exit, self.surface(exit)], [entry, self.surface(entry)]);
        let along = [high[0] - low[0], high[1] - low[1]];
        let chord = along[0].hypot(along[1]);
        let radius = (0.25 * chord * chord + sag * sag) / (2.0 * sag);
        let rise = (radius - sag) / chord;
        let centre = [0.5 * (low[0] + high[0]) - rise * along[1], 0.5 * (low[1] + high[1]) + rise * along[0]];
        // Overhanging at its entry, or below the firm base.
        let lowest = if centre[0] > exit { centre[1] - radius } else { low[1] };
        let sound = centre[1] >= high[1] && lowest >= -1e-9 * self.height;
        sound.then_some(Circle { centre, radius, exit, entry, factor: f64::NAN })
    }

    /// The factor of a circle, by iteration.
    fn factor(&self, circle: &Circle) -> f64 {
        let width = (circle.entry - circle.exit) / SLICES as f64;
        let friction = self.friction_angle.to_radians().tan();
        let slices: Vec<(f64, f64)> = (0..SLICES)
            .map(|k| {
                let x = circle.exit + (k as f64 + 0.5) * width;
                let depth = (self.surface(x) - circle.bottom(x)).max(0.0);
                (self.unit_weight * depth * width, (x - circle.centre[0]) / circle.radius)
            })
            .collect();
        let driving: f64 = slices.iter().map(|(weight, sine)| weight * sine).sum();
        let mut factor = 1.0;
        for _ in 0..100 {
            let resisting: f64 = slices
                .iter()
                .map(|(weight, sine)| {
                    let cosine = (1.0 - sine * sine).sqrt();
                    (self.cohesion * width + weight * friction) / (cosine + sine * friction / factor)
                })
                .sum();
            let next = resisting / driving;
            if (next - factor).abs() < 1e-10 {
                break;
            }
            factor = next;
        }
        if driving > 0.0 && factor > 0.0 { factor } else { f64::INFINITY }
    }

    /// The circle with the least factor.
    pub fn critical(&self) -> Option<Circle> {
        let face = self.height * self.cotangent;
        let limits = [(0.0, 0.5 * face), (face, face + 3.0 * self.height), (1e-3 * self.height, self.height)];
        let mut bounds = limits;
        let mut best: Option<Circle> = None;
        for _ in 0..ROUNDS {
            let place = |axis: usize, k: usize| {
                let (low, high): (f64, f64) = bounds[axis];
                low + (high - low) * k as f64 / (PLACES - 1) as f64
            };
            for number in 0..PLACES.pow(3) {
                let k = [number % PLACES, number / PLACES % PLACES, number / (PLACES * PLACES)];
                let Some(circle) = self.circle(place(0, k[0]), place(1, k[1]), place(2, k[2])) else {
                    continue;
                };
                let factor = self.factor(&circle);
                if best.is_none_or(|b| factor < b.factor) {
                    best = Some(Circle { factor, ..circle });
                }
            }
            let found = best?;
            let middle = (found.centre[0] - 0.5 * (found.exit + found.entry))
                .hypot(found.centre[1] - 0.5 * (self.surface(found.exit) + self.height));
            let at = [found.exit, found.entry, found.radius - middle];
            for axis in 0..3 {
                let half = 0.25 * (bounds[axis].1 - bounds[axis].0);
                let (low, high) = limits[axis];
                bounds[axis] = ((at[axis] - half).max(low), (at[axis] + half).min(high));
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_of_griffiths_and_lane() {
        let slope =
            Slope { height: 10.0, cotangent: 2.0, unit_weight: 20e3, cohesion: 10e3, friction_angle: 20.0 };
        let circle = slope.critical().unwrap();
        assert!((circle.factor - 1.379).abs() < 2e-3, "{circle:?}");
    }

    #[test]
    fn a_factor_scales_with_strength() {
        let slope =
            Slope { height: 5.0, cotangent: 1.0, unit_weight: 18e3, cohesion: 12e3, friction_angle: 25.0 };
        let factor = slope.critical().unwrap().factor;
        assert!((slope.weakened(factor).critical().unwrap().factor - 1.0).abs() < 1e-6);
    }
}
