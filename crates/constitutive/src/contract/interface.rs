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
    /// Internal variables of a point of the interface.
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

    /// Equilibrium of the interface with its elastic surroundings, `trial - resistance · jump = t(jump)`: jump increment (m), traction and
    /// state. `trial` is the traction without a jump (Pa), `resistance` the stiffness of the surroundings in opening and sliding (Pa/m).
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

    /// Plane closest to yield in an intact body with the principal stresses `highest ≥ lowest` (Pa): its yield value (Pa) and `cos 2α`,
    /// where `α` is the angle of its normal to the direction of `highest`.
    fn critical_plane(&self, highest: f64, lowest: f64) -> (f64, f64);

    /// Strength in pure opening (Pa), intact.
    fn tensile_strength(&self) -> f64;

    /// Damage, 0 intact to 1 cohesionless.
    fn damage(&self, state: &Self::State) -> f64;

    /// Size (m) above which an elastic body around the interface snaps back: it stores more energy than the interface can dissipate.
    fn snap_back_size(&self, youngs_modulus: f64, shear_modulus: f64) -> f64;

    /// Dissipated work per unit area between two states (J/m²).
    fn dissipation(&self, old: &InterfacePoint<Self::State>, new: &InterfacePoint<Self::State>) -> f64;
}
