//! Constitutive laws for geomechanics behind one contract.
//!
//! Every law implements [`StressUpdate`]: from the motion of a material point in a step
//! ([`Motion`]) and its old stress and state ([`Point`]), it returns the new ones. Small-strain laws
//! implement the smaller [`SmallStrain`] and are made objective by [`Corotational`], or extended to
//! finite strain by [`Hencky`]. Solvers own an `Arc<dyn `[`Material`]`>`: the law with the
//! state's type erased and updated in batches, so that no virtual call is paid per point. Interfaces
//! without a volume (cohesive bands, contacts) implement the trait [`InterfaceLaw`].
//!
//! Conventions: SI units; stress and strain are tension-positive; pressure `p = -tr σ / 3` is
//! compression-positive; stress is always the full 3D tensor, component order xx yy zz xy yz zx,
//! with tensor (not engineering) shear.

mod adapters;
pub mod basal;
pub mod contract;
pub mod driver;
pub mod laws;
pub mod localisation;
pub mod porous;
mod return_maps;
pub mod tensors;

pub use crate::adapters::corotational::{Corotational, FirstOrderSpin};
pub use crate::adapters::hencky::{Hencky, HenckyState, PrincipalReturn, SimdBatch};
pub use crate::contract::component_arrays::spectra;
pub use crate::contract::error::{BatchError, MaterialError, UnconvergedStep};
pub use crate::contract::interface::{InterfaceLaw, InterfacePoint};
pub use crate::contract::material::{BLOCK_SIZE, Material, StateBlock, States};
pub use crate::contract::maybe_infinite::{MaybeInfinite, NoneWord};
pub use crate::contract::motion::{Motion, MotionBlock, PoreFluidState};
pub use crate::contract::stress_update::{
    InitialCondition, Law, Point, PointLaw, SmallStrain, StressUpdate, UpdateCost,
};
pub use crate::contract::tangent::Tangent;
pub use crate::laws::model::{Model, ModelFamily, ModelInfo, with_defaults};
pub use crate::laws::spec::MaterialSpec;
pub use crate::tensors::spectral::Spectrum;
pub use crate::tensors::tensor::{Mat3, SymTensor};
pub use laws::{
    BandSpec, BinghamSpec, CamClaySpec, CfdSoilSpec, CohesiveBandSpec, CohesiveCamClaySpec,
    CohesiveDamageSpec, DoubleScaleSpec, DruckerPragerSpec, EigenstrainSpec, ExternalSpec,
    FixedCorotatedSpec, FrictionalFluidSpec, HypoplasticSpec, LinearElasticSpec, MohrCoulombSpec, MuISpec,
    NeoHookeanSpec, NewtonianFluidSpec, OriginalCamClaySpec, PressureElasticSpec, SandSpec,
    SaturationSoftenedSpec, SimsandSpec, SnowSpec, StVenantKirchhoffSpec, StrengthReducedSpec,
    TensionCutSpec, TrescaSpec, UmatSpec, UndrainedSpec, VonMisesSpec,
};
pub use laws::{MaterialFactory, register_material};
