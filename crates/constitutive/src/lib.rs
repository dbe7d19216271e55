//! Constitutive laws for geomechanics behind one contract.
//!
//! Every law implements [`StressUpdate`]: given what a material point undergoes in a step
//! ([`Motion`]) and its old stress and state ([`Point`]), it returns the new ones. Small-strain laws
//! implement the smaller [`SmallStrain`] and are made objective by [`Corotational`], or taken to
//! finite strain by [`Hencky`]. Solvers hold `Arc<dyn `[`Material`]`>`: the same law with the
//! state's type erased and updated in batches, so that no virtual call is paid per point. What is no
//! volume, a cohesive band or a contact, obeys the sister trait [`InterfaceLaw`].
//!
//! Conventions: SI units; stress and strain are tension-positive; pressure `p = -tr σ / 3` is
//! compression-positive; stress is always the full 3D tensor, component order xx yy zz xy yz zx,
//! with tensor (not engineering) shear.

pub mod basal;
mod corotational;
pub mod driver;
mod error;
pub mod granular_cell;
mod hencky;
mod interface;
pub mod lanes;
pub mod laws;
pub mod localisation;
mod material;
pub mod measures;
mod model;
mod motion;
mod or_none;
pub mod porous;
mod spec;
mod spectral;
mod tangent;
mod tensor;
mod update;
mod wrapper;

pub use corotational::{Corotational, FirstOrderSpin};
pub use error::{BatchError, MaterialError, UnconvergedStep};
pub use hencky::{Hencky, HenckyState, PrincipalReturn, SimdBatch};
pub use interface::{InterfaceLaw, InterfacePoint};
pub use lanes::spectra;
pub use laws::{MaterialFactory, register_material};
pub use material::{BLOCK_SIZE, Material, StateBlock, States};
pub use model::{Model, ModelFamily, ModelInfo};
pub use motion::{Motion, MotionBlock, PoreFluidState};
pub use or_none::{MaybeInfinite, NoneWord};
pub use spec::MaterialSpec;
pub use spectral::Spectrum;
pub use tangent::Tangent;
pub use tensor::{Mat3, SymTensor};
pub use update::{InitialCondition, Law, Point, PointLaw, SmallStrain, StressUpdate, UpdateCost};
