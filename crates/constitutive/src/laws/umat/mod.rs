//! User material of Abaqus/Standard as a law: a shared library that exports `umat_` (Fortran or C), as published
//! by the SoilModels project and many authors.
//!
//! The library receives the arguments of Abaqus: stress and strain in the order 11 22 33 12 13 23 with engineering
//! shear, tension-positive, already rotated by `DROT` of the step (Hughes–Winget), strain
//! increments at mid-step, `DFGRD0` and `DFGRD1`, its `PROPS` and `STATEV`. A `PNEWDT` below 1 counts as a
//! step that did not converge. Many of these libraries have COMMON or SAVE variables, so calls into one
//! library are serialised unless `thread_safe` is set. Limits: three-dimensional stress
//! (`NTENS = 6`), no temperature, no utility routines of Abaqus.
//!
//! The library is foreign code: it can do anything, a wrong number of state variables included. It is loaded only
//! where [`allow_libraries`](super::allow_libraries) or the environment allows it.

mod parameters;
#[cfg(feature = "umat")]
pub(crate) mod shared_library;
#[cfg(feature = "umat")]
mod umat_routine;

use std::sync::Arc;

use crate::contract::parameter_checks::{check, positive};
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::{Material, MaterialError};

pub use crate::laws::umat::parameters::UmatSpec;
#[cfg(feature = "umat")]
use crate::laws::umat::umat_routine::build;

/// Value of the key `model` in case files.
#[cfg(feature = "umat")]
const NAME: &str = "umat";

impl Model for UmatSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "a user library",
        kind: ModelFamily::Solid,
        strain: "the library's",
        tangent: "the library's (DDSDDE)",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        positive("pascals", self.unit(), "")?;
        if let Some(modulus) = self.wave_modulus {
            positive("wave_modulus", modulus, "Pa")?;
        }
        for (field, values) in [("props", &self.props), ("state_variables", &self.state_variables)] {
            if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                check(field, *value, false, "must be finite")?;
            }
        }
        if self.material_name.len() > 80 {
            let rule = format!("{:?} has more than 80 bytes", self.material_name);
            return Err(MaterialError::incompatible_options("material_name", rule));
        }
        build(self)
    }

    /// No examples, as the behaviour of a library is unknown and it may be absent.
    fn examples() -> Vec<Self> {
        Vec::new()
    }
}

/// Refuses a library in a build that cannot load one.
#[cfg(not(feature = "umat"))]
fn build(spec: &UmatSpec) -> Result<Arc<dyn Material>, MaterialError> {
    let problem = format!(
        "{}: loading a library needs the feature `umat` of the crate colluvium-constitutive",
        spec.library.display()
    );
    Err(MaterialError::incompatible_options("library", problem))
}
