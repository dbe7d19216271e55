//! Adhesion of elastic spheres (Johnson, Kendall and Roberts 1971): with the radius `a` of the contact,
//! `F = 4 E* a³ / 3R - √(8 π w E* a³)` and `δ = a²/R - √(2 π w a / E*)`.

use std::f64::consts::PI;

use super::hertz::Hertz;

/// Bound on Newton iterations, above the number needed.
const MAX_ITERATIONS: usize = 60;

/// Parameters of JKR adhesion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jkr {
    /// Work of adhesion `w` (J/m²).
    pub work: f64,
    /// Effective modulus `E*` (Pa).
    pub modulus: f64,
}

impl Jkr {
    /// Pull-off force of spheres of an effective radius (m) under constant load, `3/2 π w R` (N).
    pub fn pull_off(&self, radius: f64) -> f64 {
        1.5 * PI * self.work * radius
    }

    /// Gap (m) at which the spheres separate under displacement control.
    pub fn rupture_distance(&self, radius: f64) -> f64 {
        // At the separation dδ/da = 0: a³ = π w R² / 8 E*.
        let a = self.tear_radius(radius);
        (2.0 * PI * self.work * a / self.modulus).sqrt() - a * a / radius
    }

    /// Contact radius at separation (m).
    fn tear_radius(&self, radius: f64) -> f64 {
        (PI * self.work * radius * radius / (8.0 * self.modulus)).cbrt()
    }

    /// Normal force at an overlap (N; positive for repulsion), and the pull-off force (N).
    pub fn force(&self, hertz: &Hertz, radius: f64, overlap: f64) -> (f64, f64) {
        let modulus = hertz.modulus;
        let smallest = self.tear_radius(radius);
        let overlap = overlap.max(-self.rupture_distance(radius));
        // Start from above: the function is convex there, and the iterates stay above the root.
        let mut a = (radius * overlap.max(0.0)).sqrt() + 4.0 * smallest;
        for _ in 0..MAX_ITERATIONS {
            let root = (2.0 * PI * self.work * a / modulus).sqrt();
            let (value, slope) = (a * a / radius - root - overlap, 2.0 * a / radius - 0.5 * root / a);
            if slope <= 0.0 {
                break;
            }
            let next = (a - value / slope).max(smallest);
            if (next - a).abs() <= 1e-15 * a {
                a = next;
                break;
            }
            a = next;
        }
        let cube = a * a * a;
        let force = 4.0 * modulus * cube / (3.0 * radius) - (8.0 * PI * self.work * modulus * cube).sqrt();
        (force, self.pull_off(radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minimum_jkr_force_is_the_pull_off_force_and_without_adhesion_hertz_holds() {
        let hertz = Hertz::new([1e7; 2], [0.3; 2], 0.0, 0.0);
        let (radius, law) = (1e-3, Jkr { work: 0.05, modulus: hertz.modulus });
        let bridge = law.rupture_distance(radius);
        let sweep = (0..20_000).map(|k| -bridge + 3.0 * bridge * f64::from(k) / 20_000.0);
        let smallest =
            sweep.map(|overlap| law.force(&hertz, radius, overlap).0).fold(f64::INFINITY, f64::min);
        assert!((smallest / -law.pull_off(radius) - 1.0).abs() < 1e-6, "{smallest}");
        // At separation the force is 5/9 of the pull-off force.
        let torn = law.force(&hertz, radius, -bridge).0;
        assert!((torn / -law.pull_off(radius) - 5.0 / 9.0).abs() < 1e-6, "{torn}");
        let weak = Jkr { work: 1e-14, ..law };
        let plain = 4.0 / 3.0 * hertz.modulus * radius.sqrt() * 1e-5f64.powf(1.5);
        assert!((weak.force(&hertz, radius, 1e-5).0 / plain - 1.0).abs() < 1e-4);
    }
}
