//! Dispatch from the run-time choice of dimension and shape functions to compile-time dimensions.

use colluvium_case::{Case, CaseError};
use colluvium_grid::{ShapeFunctionKind, Transfers};

use crate::MpmOptions;
use crate::config::{DomainStretch, LagrangianFormulation, ShapeFunctions};
use colluvium_case::CaseErrorKind;

/// Transfers between points and grid with the shape functions of a case.
#[derive(Clone, Copy, Debug)]
pub struct SelectedTransfers<const D: usize> {
    /// Transfers with its shape functions.
    pub transfers: &'static dyn Transfers<D>,
    /// Transfers with linear functions.
    pub linear: &'static dyn Transfers<D>,
}

/// Visitor of a space with a compile-time dimension.
pub trait DimensionVisitor {
    /// Result of the operation.
    type Output;

    /// Runs the operation in `D` dimensions with the selected transfers.
    fn visit<const D: usize>(self, chosen: SelectedTransfers<D>) -> Self::Output;
}

/// Calls `visitor` in the space of `case`, with the transfers of `options`.
pub fn dispatch<T>(
    case: &Case,
    options: &MpmOptions,
    visitor: impl DimensionVisitor<Output = Result<T, CaseError>>,
) -> Result<T, CaseError> {
    let shape = shape_function_kind(options);
    let refuse = || {
        CaseError::new(
            "methods.mpm.shape",
            CaseErrorKind::coded("wrong-dimension", "is not available in so many dimensions"),
        )
    };
    match case.dimension() {
        1 => visitor.visit(
            selected_transfers(shape.on_line(), ShapeFunctionKind::Linear.on_line()).ok_or_else(refuse)?,
        ),
        2 => visitor.visit(
            selected_transfers(shape.in_plane(), ShapeFunctionKind::Linear.in_plane()).ok_or_else(refuse)?,
        ),
        _ => visitor.visit(
            selected_transfers(shape.in_space(), ShapeFunctionKind::Linear.in_space()).ok_or_else(refuse)?,
        ),
    }
}

/// Transfers of a kind of shape functions; `None` if they are not compiled for this dimension.
type MaybeTransfers<const D: usize> = Option<&'static dyn Transfers<D>>;

/// Transfers of the selected and of the linear shape functions; `None` if either is missing.
fn selected_transfers<const D: usize>(
    transfers: MaybeTransfers<D>,
    linear: MaybeTransfers<D>,
) -> Option<SelectedTransfers<D>> {
    Some(SelectedTransfers { transfers: transfers?, linear: linear? })
}

/// Kind of shape functions that formulation, shape option and mesh select.
fn shape_function_kind(options: &MpmOptions) -> ShapeFunctionKind {
    let total = options.formulation == LagrangianFormulation::TotalLagrangian;
    match options.shape {
        _ if options.mesh.is_some() => ShapeFunctionKind::Elements,
        ShapeFunctions::Linear if total => ShapeFunctionKind::ReferenceLinear,
        ShapeFunctions::Quadratic if total => ShapeFunctionKind::ReferenceQuadratic,
        ShapeFunctions::Linear | ShapeFunctions::DualDomain => ShapeFunctionKind::Linear,
        ShapeFunctions::Ugimp => ShapeFunctionKind::Gimp,
        ShapeFunctions::Cpgimp => match options.domain_stretch {
            DomainStretch::Diagonal => ShapeFunctionKind::StretchingGimp,
            DomainStretch::RightStretch => ShapeFunctionKind::RightStretchGimp,
        },
        ShapeFunctions::Quadratic => ShapeFunctionKind::Quadratic,
        ShapeFunctions::Cubic => ShapeFunctionKind::Cubic,
        ShapeFunctions::Cpdi => ShapeFunctionKind::Convected,
        ShapeFunctions::Cpdi2 => ShapeFunctionKind::ConvectedQuadrilateral,
    }
}
