//! From the run-time choice of dimension and shape functions to the compiled solver.

use colluvium_case::{Case, CaseError};
use colluvium_grid::{Basis, Corners, CubicSpline, Gimp, Linear, QuadraticSpline, Simplex, WideGimp};

use crate::MpmOptions;
use crate::config::{DomainStretch, Formulation, ShapeFunctions};
use crate::domains::{ConvectedCorners, ConvectedDomain, ReferencePoint};
use crate::mesh::InElement;
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
    if options.mesh.is_some() {
        return match case.dimension() {
            2 => visitor.visit::<2, 3, Simplex, InElement>(),
            _ => visitor.visit::<3, 4, Simplex, InElement>(),
        };
    }
    if options.shape == ShapeFunctions::Cpdi {
        return match case.dimension() {
            1 => visitor.visit::<1, 4, Corners, ConvectedDomain<1>>(),
            2 => visitor.visit::<2, 16, Corners, ConvectedDomain<2>>(),
            _ => visitor.visit::<3, 64, Corners, ConvectedDomain<3>>(),
        };
    }
    if options.shape == ShapeFunctions::Cpdi2 {
        return visitor.visit::<2, 16, Corners, ConvectedCorners>();
    }
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
        ShapeFunctions::Linear if options.formulation == Formulation::TotalLagrangian => {
            visitor.visit::<D, 2, Linear, ReferencePoint<D>>()
        }
        ShapeFunctions::Quadratic if options.formulation == Formulation::TotalLagrangian => {
            visitor.visit::<D, 3, QuadraticSpline, ReferencePoint<D>>()
        }
        ShapeFunctions::Linear | ShapeFunctions::DualDomain => visitor.visit::<D, 2, Linear, FixedDomain>(),
        ShapeFunctions::Ugimp => visitor.visit::<D, 3, Gimp, FixedDomain>(),
        ShapeFunctions::Cpgimp => match options.domain_stretch {
            DomainStretch::Diagonal => visitor.visit::<D, 4, WideGimp, StretchingDomain<D>>(),
            DomainStretch::RightStretch => visitor.visit::<D, 4, WideGimp, TurningDomain<D>>(),
        },
        ShapeFunctions::Quadratic => visitor.visit::<D, 3, QuadraticSpline, FixedDomain>(),
        ShapeFunctions::Cubic => visitor.visit::<D, 4, CubicSpline, FixedDomain>(),
        ShapeFunctions::Cpdi | ShapeFunctions::Cpdi2 => {
            unreachable!("have as many nodes as the dimension says")
        }
    }
}
