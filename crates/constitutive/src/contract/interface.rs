//! Contract of interface laws: traction from a displacement jump (sheet: constitutive §3.1). Cohesive
//! bands inside a continuum point and contacts obey it.

use serde::{Serialize, de::DeserializeOwned};

use crate::MaterialError;

/// Point of an interface: traction and internal variables of the law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InterfacePoint<S> {
    /// Traction (Pa) in the frame of the interface: normal (tension-positive), then two tangential
    /// components.
    pub traction: [f64; 3],
    /// Internal variables of the law.
    pub state: S,
}

/// Law of the traction of an interface that opens and slides. Components are in the frame of the interface, the
/// normal first; the law is isotropic in the plane. Positive opening is a gap.
pub trait InterfaceLaw: Send + Sync + 'static {
    /// Internal variables of one point: a typed struct of plain numbers.
    type State: Copy + Default + Send + Sync + Serialize + DeserializeOwned + 'static;

    /// Name of the law in a case file.
    fn name(&self) -> &'static str;

    /// State of a new interface with the traction `traction` (Pa), without slip or opening.
    fn initial(&self, traction: [f64; 3]) -> Self::State;

    /// Traction and state after an increment `jump` (m) of the jump.
    ///
    /// # Errors
    /// When the local solve fails.
    fn update(
        &self,
        jump: [f64; 3],
        old: &InterfacePoint<Self::State>,
    ) -> Result<InterfacePoint<Self::State>, MaterialError>;

    /// Jump increment (m), traction and state of the interface in equilibrium with the traction
    /// `trial` (Pa) of its elastic surroundings, `trial - resistance · jump = t(jump)`. `resistance` (Pa/m) is
    /// that of opening and of sliding.
    ///
    /// # Errors
    /// When the local solve fails.
    fn relax_with_surroundings(
        &self,
        trial: [f64; 3],
        resistance: [f64; 2],
        old: &InterfacePoint<Self::State>,
    ) -> Result<([f64; 3], InterfacePoint<Self::State>), MaterialError>;

    /// Consistent stiffness `∂t/∂u` (Pa/m) of [`InterfaceLaw::update`].
    ///
    /// # Errors
    /// As [`InterfaceLaw::update`].
    fn stiffness(
        &self,
        jump: [f64; 3],
        old: &InterfacePoint<Self::State>,
    ) -> Result<[[f64; 3]; 3], MaterialError>;

    /// Yield function (Pa), `<= 0` inside.
    fn yield_value(&self, point: &InterfacePoint<Self::State>) -> f64;

    /// Critical plane of an intact body with the extreme principal stresses `highest ≥ lowest` (Pa), the
    /// one nearest to yield: its yield value (Pa) and `cos 2α`, α the angle between its normal and the
    /// direction of `highest`.
    fn critical_plane(&self, highest: f64, lowest: f64) -> (f64, f64);

    /// Strength in pure opening (Pa), intact.
    fn tensile_strength(&self) -> f64;

    /// Damage, 0 intact to 1 cohesionless.
    fn damage(&self, state: &Self::State) -> f64;

    /// Size (m) above which an elastic body of the given moduli (Pa) around the interface stores more energy
    /// than the interface can dissipate: it snaps back.
    fn snap_back_size(&self, youngs_modulus: f64, shear_modulus: f64) -> f64;

    /// Work dissipated from `old` to `new`, per unit area (J/m²).
    fn dissipation(&self, old: &InterfacePoint<Self::State>, new: &InterfacePoint<Self::State>) -> f64;
}
