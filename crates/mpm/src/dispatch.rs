//! From the run-time choice of dimension and shape functions to the compiled solver.

use colluvium_case::{Case, CaseError};
use colluvium_grid::{Basis, CubicSpline, Gimp, Linear, QuadraticSpline, WideGimp};

use crate::MpmOptions;
use crate::config::{DomainStretch, ShapeFunctions};
use crate::points::{FixedDomain, PointDomain};
use crate::stretch::{StretchingDomain, TurningDomain};

/// Something done with a concrete dimension, basis and point domain.
pub trait Visitor {
    /// What comes out.
    type Output;

    /// Does it.
    fn visit<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(self) -> Self::Output;
}

/// Calls `visitor` with the types that `case` and `options` ask for.
pub fn dispatch<T>(
    case: &Case,
    options: &MpmOptions,
    visitor: impl Visitor<Output = Result<T, CaseError>>,
) -> Result<T, CaseError> {
    match case.dimension() {
        1 => shape::<1, T>(options, visitor),
        2 => shape::<2, T>(options, visitor),
        _ => shape::<3, T>(options, visitor),
    }
}

fn shape<const D: usize, T>(
    options: &MpmOptions,
    visitor: impl Visitor<Output = Result<T, CaseError>>,
) -> Result<T, CaseError> {
    match options.shape {
        ShapeFunctions::Linear => visitor.visit::<D, 2, Linear, FixedDomain>(),
        ShapeFunctions::Ugimp => visitor.visit::<D, 3, Gimp, FixedDomain>(),
        ShapeFunctions::Cpgimp => match options.domain_stretch {
            DomainStretch::Diagonal => visitor.visit::<D, 4, WideGimp, StretchingDomain<D>>(),
            DomainStretch::RightStretch => visitor.visit::<D, 4, WideGimp, TurningDomain<D>>(),
        },
        ShapeFunctions::Quadratic => visitor.visit::<D, 3, QuadraticSpline, FixedDomain>(),
        ShapeFunctions::Cubic => visitor.visit::<D, 4, CubicSpline, FixedDomain>(),
    }
}
