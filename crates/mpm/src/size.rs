//! How large a problem is, before any of it is made.

use colluvium_case::{Case, CaseError, Size};
use colluvium_constitutive::SymTensor;
use colluvium_grid::Basis;

use crate::points::PointDomain;
use crate::setup::{SORTING, bytes_of_node, options};
use crate::{MpmOptions, dispatch};

/// The size of `case`. In a mesh from a file nothing counts: it has been read by then.
pub fn size(case: &Case) -> Result<Size, CaseError> {
    let options = options(case)?;
    dispatch::dispatch(case, &options, Estimate { case, options: &options })
}

struct Estimate<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
}

impl dispatch::Visitor for Estimate<'_> {
    type Output = Result<Size, CaseError>;

    fn visit<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(self) -> Self::Output {
        let (case, options) = (self.case, self.options);
        if options.mesh.is_some() {
            return Ok(Size::default());
        }
        let points = case.points_at(options.cell_size / options.points_per_cell as f64);
        let cells = |axis: usize| (case.domain.max[axis] - case.domain.min[axis]) / options.cell_size;
        let nodes: f64 = (0..D).map(|axis| cells(axis) + 1.0).product();
        let phases = if case.bodies.iter().any(|body| body.pore_fluid.is_some()) { 2 } else { 1 };
        let per_node = bytes_of_node(phases, false);
        let number = size_of::<f64>();
        // Position, velocity, origin; mass, volume, initial volume; id.
        let per_point = (3 * D + 3) * number + size_of::<u32>() + size_of::<SymTensor>() + size_of::<P>();
        Ok(Size {
            points,
            nodes,
            memory: points * (per_point + SORTING) as f64 + nodes * per_node as f64,
            key: "methods.mpm.cell_size",
        })
    }
}
