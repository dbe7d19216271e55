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
//!
//! A law of the core under its parameters, in the element driver:
//!
//! ```
//! use colluvium_constitutive::driver::{ElementTest, LoadingPath, TestStage};
//! use colluvium_constitutive::MohrCoulombSpec;
//!
//! let sand = MohrCoulombSpec::new(1800.0, 2e7, 0.3, 32.0);
//! let path = ElementTest::new(sand)
//!     .stage(TestStage::new(LoadingPath::Isotropic { pressure: 1e5 }))
//!     .stage(TestStage::new(LoadingPath::TriaxialDrained { axial_compression: 0.05 }))
//!     .run()?;
//! // The stress ratio at failure is (1 + sin φ) / (1 - sin φ).
//! let stress = path.last_stress();
//! let sine = 32_f64.to_radians().sin();
//! assert!((stress[2] / stress[0] - (1.0 + sine) / (1.0 - sine)).abs() < 1e-6);
//! # Ok::<(), colluvium_constitutive::driver::DriverError>(())
//! ```
//!
//! A law of one's own implements [`SmallStrain`] or [`StressUpdate`]: `examples/own_law.rs`. Equations and typical values are in `docs/laws`
//! of the repository, the specification in the sheet `docs/sheets/constitutive.md`.

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
pub use crate::contract::elasticity::Elasticity;
pub use crate::contract::error::{BatchError, MaterialError, UnconvergedStep};
pub use crate::contract::interface::{InterfaceLaw, InterfacePoint};
pub use crate::contract::material::{BLOCK_SIZE, Material, StateBlock, States};
pub use crate::contract::maybe_infinite::{MaybeInfinite, NoneWord};
pub use crate::contract::motion::{Motion, MotionBlock, PoreFluidState};
pub use crate::contract::stress_update::{
    InitialCondition, Law, Point, PointLaw, SmallStrain, StressUpdate, UpdateCost,
};
pub use crate::contract::tangent::Tangent;
pub use crate::contract::warning::Warning;
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
