//! Linear spring and dashpot (sheet: dem §2.3; Cundall and Strack 1979): `F_n = k δ - γ v_n`.

use crate::contact::{ContactGeometry, NormalResponse};
use crate::points::vector::SimdNumber;

/// Parameters of a linear contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearSpring<T = f64> {
    /// Stiffness (N/m); zero if it is given by `modulus`.
    pub stiffness: T,
    /// Twice the modulus of the grains (Pa); its product with the effective radius (m) is the stiffness.
    pub modulus: T,
    /// Damping ratio ζ: `γ = 2 ζ √(k m_eff)`.
    pub damping_ratio: T,
    /// Tangential over normal stiffness.
    pub tangential_ratio: T,
    /// Tangential damping ratio.
    pub tangential_damping_ratio: T,
    /// Square root of `tangential_ratio`.
    pub tangential_ratio_root: T,
}

impl<T: SimdNumber> LinearSpring<T> {
    /// Stiffness (N/m) between grains of effective radius `radius` (m).
    #[inline]
    pub fn stiffness(&self, radius: T) -> T {
        self.stiffness + self.modulus * radius
    }

    /// Normal force, energy, stiffness and dashpots at an overlap.
    #[inline]
    pub fn response<const D: usize, const R: usize>(
        &self,
        geometry: &ContactGeometry<D, R, T>,
    ) -> NormalResponse<T> {
        let stiffness = self.stiffness(geometry.radius);
        let (half, two, force) = (T::broadcast(0.5), T::broadcast(2.0), stiffness * geometry.overlap);
        let root = two * (stiffness * geometry.mass).root();
        NormalResponse {
            force,
            energy: half * force * geometry.overlap,
            damping: self.damping_ratio * root,
            tangential_stiffness: self.tangential_ratio * stiffness,
            tangential_damping: self.tangential_damping_ratio * self.tangential_ratio_root * root,
        }
    }
}
