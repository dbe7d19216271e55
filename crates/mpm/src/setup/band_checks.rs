//! Checks of the cell size for laws with localisation bands.

use colluvium_case::{Case, CaseError};
use colluvium_constitutive::MaterialSpec;
use colluvium_constitutive::laws::DoubleScaleSpec;

use crate::MpmOptions;
use colluvium_case::CaseErrorKind;

/// Rejects cells whose bands snap back. Elements of a mesh are checked when a band begins.
pub(super) fn check_bands(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    for body in case.bodies.iter().filter(|body| !body.rigid && options.mesh.is_none()) {
        let law = case.materials.get(&body.material).and_then(MaterialSpec::double_scale);
        let Some(largest) = law.and_then(DoubleScaleSpec::largest_band) else { continue };
        if options.band_cells() * options.cell_size >= largest {
            let problem = format!(
                "bands of the material {:?}, {} cells long, show snap-back from a length of {largest:.4e} m \
                 on (E G/f_t², or the same with the shear modulus if that is less): make the cells smaller, \
                 or set `allow_snapback` in the material",
                body.material,
                options.band_cells()
            );
            return Err(CaseError::new("methods.mpm.cell_size", CaseErrorKind::coded("snap-back", problem)));
        }
    }
    Ok(())
}
