//! Cohesive contacts with tensile and shear strength until they break (sheet: dem §2.7, adhesive-frictional contact).

use super::{AttractionLaw, ContactEnergies, ContactGeometry, ContactHistory, ContactState, PairLaw};
use crate::points::vector::dot;

/// Parameters of a cohesive contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cohesion {
    /// Tensile force over the smaller radius to the power `D - 1`.
    pub tension: f64,
    /// Shear force over the smaller radius to the power `D - 1`.
    pub shear: f64,
    /// Whether a shear force above its limit breaks the contact.
    pub is_fragile: bool,
    /// Whether contacts that form later are cohesive too.
    pub new_contacts: bool,
    /// Rupture distance (m): tension over stiffness, of the largest grains.
    pub rupture_distance: f64,
}

impl Cohesion {
    /// Breaks the contact if the tensile strength is exceeded. Returns the shear strength at zero normal force (N).
    #[inline]
    pub fn bound_tension<const D: usize, const R: usize>(
        &self,
        geometry: &ContactGeometry<D, R>,
        history: &mut ContactHistory<R>,
        normal: &mut f64,
        energy: &mut f64,
        energies: &mut ContactEnergies,
    ) -> f64 {
        let size = geometry.min_radius.powi(D as i32 - 1);
        if history.state == ContactState::Bonded && *normal < -self.tension * size {
            history.state = ContactState::Touching;
            if geometry.overlap < 0.0 {
                energies.broken += *energy;
            }
        }
        if history.state == ContactState::Bonded {
            return self.shear * size;
        }
        if geometry.overlap < 0.0 {
            // The contact has broken in this step, and ends with the next.
            (*normal, *energy) = (0.0, 0.0);
        }
        0.0
    }
}

/// Breaks a fragile contact that slips.
#[inline]
pub fn break_by_shear<const R: usize>(
    law: &PairLaw,
    tangential: &[f64; R],
    cap: (f64, f64),
    history: &mut ContactHistory<R>,
) {
    let Some(AttractionLaw::Cohesion(cohesion)) = &law.attraction else { return };
    let limit = law.friction.coefficient * cap.0 + cap.1;
    let slips = dot(tangential, tangential).sqrt() >= limit * (1.0 - 1e-12);
    if cohesion.is_fragile && history.state == ContactState::Bonded && slips {
        history.state = ContactState::Touching;
    }
}
