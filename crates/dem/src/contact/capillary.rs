//! Capillary bridges between spheres (Rabinovich et al. 2005; rupture of Lian et al. 1993):
//! `F = 2 π R_c γ cos θ / (1 + S / 2 d)`, with the depth of immersion `d` from the volume of the bridge and `R_c` twice the
//! effective radius. The bridge forms on contact and breaks at a gap `S = (1 + θ/2) V^(1/3)`.

use std::f64::consts::PI;

/// Parameters of a capillary bridge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capillary {
    /// Surface tension times the cosine of the contact angle (N/m).
    pub tension: f64,
    /// Factor of the rupture distance, `1 + θ/2` with `θ` in radians.
    pub rupture: f64,
    /// Volume of the bridge over the cube of the effective radius.
    pub volume: f64,
}

impl Capillary {
    /// Rupture distance of the bridge (m), for spheres of effective radius `radius` (m).
    pub fn rupture_distance(&self, radius: f64) -> f64 {
        self.rupture * self.volume.cbrt() * radius
    }

    /// Attraction (N) across a gap (m); that at zero gap where the spheres overlap.
    pub fn force(&self, radius: f64, gap: f64) -> f64 {
        let curvature = 2.0 * radius;
        let largest = 2.0 * PI * curvature * self.tension;
        if gap <= 0.0 {
            return largest;
        }
        let volume = self.volume * radius.powi(3);
        let depth = 0.5 * gap * ((1.0 + 2.0 * volume / (PI * curvature * gap * gap)).sqrt() - 1.0);
        largest / (1.0 + gap / (2.0 * depth))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attraction_falls_with_the_gap_and_is_that_of_the_contact_at_none() {
        let law = Capillary { tension: 0.072, rupture: 1.0, volume: 0.01 };
        let radius = 5e-4;
        let touching = 4.0 * PI * radius * 0.072;
        assert!((law.force(radius, 0.0) / touching - 1.0).abs() < 1e-12);
        assert!((law.force(radius, 1e-12) / touching - 1.0).abs() < 1e-3);
        let end = law.rupture_distance(radius);
        let falls = (0..50).map(|k| law.force(radius, end * f64::from(k) / 49.0)).collect::<Vec<_>>();
        assert!(falls.windows(2).all(|pair| pair[1] < pair[0]) && falls[49] > 0.0);
    }
}
