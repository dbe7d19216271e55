//! A spring and a dashpot (sheet: dem §2.3; Cundall and Strack 1979): `F_n = k δ - γ v_n`.

use super::{Elastic, Touch};

/// Parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// Stiffness (N/m); none where it follows from `modulus`.
    pub stiffness: f64,
    /// Twice the modulus of the grains (Pa), of which the stiffness is that times the effective radius (m).
    pub modulus: f64,
    /// Damping ratio ζ: `γ = 2 ζ √(k m_eff)`.
    pub damping_ratio: f64,
    /// Stiffness across over that along.
    pub across: f64,
    /// Damping ratio across.
    pub damping_ratio_across: f64,
}

impl Linear {
    /// Stiffness (N/m) between grains of effective radius `radius` (m).
    #[inline]
    pub fn stiffness(&self, radius: f64) -> f64 {
        self.stiffness + self.modulus * radius
    }

    /// What it says of an overlap.
    #[inline]
    pub fn at<const D: usize, const R: usize>(&self, touch: &Touch<D, R>) -> Elastic {
        let stiffness = self.stiffness(touch.radius);
        let across = self.across * stiffness;
        let damping = 2.0 * (stiffness * touch.mass).sqrt();
        Elastic {
            force: stiffness * touch.overlap,
            energy: 0.5 * stiffness * touch.overlap * touch.overlap,
            damping: self.damping_ratio * damping,
            across,
            damping_across: if self.damping_ratio_across > 0.0 {
                2.0 * self.damping_ratio_across * (across * touch.mass).sqrt()
            } else {
                0.0
            },
        }
    }
}
