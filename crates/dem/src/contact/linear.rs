//! A spring and a dashpot (sheet: dem §2.3; Cundall and Strack 1979): `F_n = k δ - γ v_n`.

use super::{Elastic, Touch};
use crate::vector::Number;

/// Parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear<T = f64> {
    /// Stiffness (N/m); none where it follows from `modulus`.
    pub stiffness: T,
    /// Twice the modulus of the grains (Pa), of which the stiffness is that times the effective radius (m).
    pub modulus: T,
    /// Damping ratio ζ: `γ = 2 ζ √(k m_eff)`.
    pub damping_ratio: T,
    /// Stiffness across over that along.
    pub across: T,
    /// Damping ratio across.
    pub damping_ratio_across: T,
    /// Root of `across`.
    pub root_across: T,
}

impl<T: Number> Linear<T> {
    /// Stiffness (N/m) between grains of effective radius `radius` (m).
    #[inline]
    pub fn stiffness(&self, radius: T) -> T {
        self.stiffness + self.modulus * radius
    }

    /// What it says of an overlap.
    #[inline]
    pub fn at<const D: usize, const R: usize>(&self, touch: &Touch<D, R, T>) -> Elastic<T> {
        let stiffness = self.stiffness(touch.radius);
        let (half, two, force) = (T::of(0.5), T::of(2.0), stiffness * touch.overlap);
        let root = two * (stiffness * touch.mass).root();
        Elastic {
            force,
            energy: half * force * touch.overlap,
            damping: self.damping_ratio * root,
            across: self.across * stiffness,
            damping_across: self.damping_ratio_across * self.root_across * root,
        }
    }
}
