//! From the run-time choice of dimension and shape functions to a dimension that the compiler knows.

use colluvium_case::{Case, CaseError};
use colluvium_grid::{Shape, Sweeps};

use crate::MpmOptions;
use crate::config::{DomainStretch, Formulation, ShapeFunctions};

/// The transfers of a case.
#[derive(Clone, Copy, Debug)]
pub struct Chosen<const D: usize> {
    /// Those of its shape functions.
    pub sweeps: &'static dyn Sweeps<D>,
    /// Those of linear functions.
    pub linear: &'static dyn Sweeps<D>,
}

/// Something done in a space of a dimension that the compiler knows.
pub trait Visitor {
    /// What comes out.
    type Output;

    /// Does it.
    fn visit<const D: usize>(self, chosen: Chosen<D>) -> Self::Output;
}

/// Calls `visitor` in the space that `case` asks for, with the transfers of `options`.
pub fn dispatch<T>(
    case: &Case,
    options: &MpmOptions,
    visitor: impl Visitor<Output = Result<T, CaseError>>,
) -> Result<T, CaseError> {
    let shape = shape(options);
    let refuse = || CaseError::new("methods.mpm.shape", "is not available in so many dimensions");
    match case.dimension() {
        1 => visitor.visit(chosen(shape.on_line(), Shape::Linear.on_line()).ok_or_else(refuse)?),
        2 => visitor.visit(chosen(shape.in_plane(), Shape::Linear.in_plane()).ok_or_else(refuse)?),
        _ => visitor.visit(chosen(shape.in_space(), Shape::Linear.in_space()).ok_or_else(refuse)?),
    }
}

type MaybeSweeps<const D: usize> = Option<&'static dyn Sweeps<D>>;

fn chosen<const D: usize>(sweeps: MaybeSweeps<D>, linear: MaybeSweeps<D>) -> Option<Chosen<D>> {
    Some(Chosen { sweeps: sweeps?, linear: linear? })
}

fn shape(options: &MpmOptions) -> Shape {
    let total = options.formulation == Formulation::TotalLagrangian;
    match options.shape {
        _ if options.mesh.is_some() => Shape::Elements,
        ShapeFunctions::Linear if total => Shape::ReferenceLinear,
        ShapeFunctions::Quadratic if total => Shape::ReferenceQuadratic,
        ShapeFunctions::Linear | ShapeFunctions::DualDomain => Shape::Linear,
        ShapeFunctions::Ugimp => Shape::Gimp,
        ShapeFunctions::Cpgimp => match options.domain_stretch {
            DomainStretch::Diagonal => Shape::StretchingGimp,
            DomainStretch::RightStretch => Shape::TurningGimp,
        },
        ShapeFunctions::Quadratic => Shape::Quadratic,
        ShapeFunctions::Cubic => Shape::Cubic,
        ShapeFunctions::Cpdi => Shape::Convected,
        ShapeFunctions::Cpdi2 => Shape::ConvectedCorners,
    }
}

#[cfg(test)]
pub mod tests {
    use std::any::Any;

    use super::*;
    use crate::setup;
    use crate::solver::MpmSolver;

    struct Begin<'a>(&'a Case, &'a MpmOptions);

    impl Visitor for Begin<'_> {
        type Output = Result<Box<dyn Any>, CaseError>;

        fn visit<const D: usize>(self, chosen: Chosen<D>) -> Self::Output {
            Ok(Box::new(setup::solver(self.0, self.1, chosen)?))
        }
    }

    /// The solver of a case in `D` dimensions, at time zero.
    pub fn begun<const D: usize>(case: &Case) -> MpmSolver<D> {
        let options = setup::options(case).unwrap();
        *dispatch(case, &options, Begin(case, &options)).unwrap().downcast().unwrap()
    }
}
