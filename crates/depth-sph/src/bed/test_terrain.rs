//! Synthetic terrain for tests of flows over surveys: rough slopes and steps, from a seed (sheet: depth-sph §0, test terrain).

use std::f64::consts::TAU;

use colluvium_points::Raster;

/// Number of waves of a rough slope.
const WAVES: usize = 160;
/// Distance over which the roughness grows (m).
const RAMP: f64 = 50.0;

/// Slope along x with random waves, whose amplitude decreases with the square of the wave number.
#[derive(Clone, Debug)]
pub struct RoughSlope {
    /// Tangent of the mean slope.
    pub slope: f64,
    /// Position from which the slope is rough (m).
    pub start: f64,
    /// Wave numbers (1/m) along x and y, phase and amplitude (m) of each wave.
    waves: Vec<[f64; 4]>,
}

/// Next number in 0..1 of a sequence, by the generator SplitMix64.
fn next_random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

impl RoughSlope {
    /// Slope with the tangent `slope` that is rough from `start` on (m). Waves have lengths within `lengths` (m), and their slopes the root
    /// mean square `rms`.
    pub fn new(slope: f64, start: f64, lengths: [f64; 2], rms: f64, seed: u64) -> Self {
        let mut state = seed;
        let mut wave = || {
            // Wave numbers fill the plane evenly between two circles.
            let [smallest, largest] = [TAU / lengths[1], TAU / lengths[0]];
            let number = (smallest * smallest
                + next_random(&mut state) * (largest * largest - smallest * smallest))
                .sqrt();
            let (sin, cos) = (TAU * next_random(&mut state)).sin_cos();
            [number * cos, number * sin, TAU * next_random(&mut state), 1.0 / (number * number)]
        };
        let mut waves: Vec<[f64; 4]> = (0..WAVES).map(|_| wave()).collect();
        let square = |wave: &[f64; 4]| 0.5 * wave[3] * wave[3] * (wave[0] * wave[0] + wave[1] * wave[1]);
        let factor = rms / waves.iter().map(square).sum::<f64>().sqrt();
        waves.iter_mut().for_each(|wave| wave[3] *= factor);
        Self { slope, start, waves }
    }

    /// Level at a position (m).
    pub fn level(&self, x: f64, y: f64) -> f64 {
        let t = ((x - self.start) / RAMP).clamp(0.0, 1.0);
        let rough: f64 = self.waves.iter().map(|[p, q, phase, a]| a * (p * x + q * y + phase).cos()).sum();
        t * t * (3.0 - 2.0 * t) * rough - self.slope * x
    }

    /// Raster of the slope with the node distance `spacing` (m) between two corners in plan (m).
    pub fn raster(&self, low: [f64; 2], high: [f64; 2], spacing: f64) -> Raster {
        let counts = [0, 1].map(|c| ((high[c] - low[c]) / spacing).round() as usize + 1);
        Raster::from_function(counts, low, [spacing; 2], |x, y| self.level(x, y))
    }
}

/// Level of a slope of 25° that has a step from the position `from` on (m). The step has a `height` (m) and an `angle` (degrees).
pub fn step_profile(from: f64, height: f64, angle: f64) -> impl Fn(f64, f64) -> f64 {
    let [gentle, steep] = [25.0, angle].map(|angle: f64| angle.to_radians().tan());
    let length = height / steep;
    move |x, _| -gentle * x - (steep - gentle) * (x - from).clamp(0.0, length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rough_slopes_have_the_prescribed_roughness_and_are_repeatable_for_a_seed() {
        let slope = RoughSlope::new(0.5, -100.0, [40.0, 200.0], 0.1, 7);
        assert_eq!(
            slope.level(3.0, 4.0),
            RoughSlope::new(0.5, -100.0, [40.0, 200.0], 0.1, 7).level(3.0, 4.0)
        );
        let mut sum = 0.0;
        for k in 0..4000 {
            let (x, y) = (3.7 * f64::from(k % 200), 31.0 * f64::from(k / 200));
            let along = (slope.level(x + 0.01, y) - slope.level(x, y)) / 0.01 + 0.5;
            let across = (slope.level(x, y + 0.01) - slope.level(x, y)) / 0.01;
            sum += (along * along + across * across) / 4000.0;
        }
        assert!((sum.sqrt() / 0.1 - 1.0).abs() < 0.1, "{}", sum.sqrt());
    }
}
