//! Structured grid of a case, and the layout of its nodes.

use colluvium_case::{Case, CaseError};
use colluvium_grid::{Basis1d, Grid, Layout};

use crate::MpmOptions;
use colluvium_case::CaseErrorKind;

/// Returns the grid of the case.
pub fn grid<const D: usize>(case: &Case, options: &MpmOptions) -> Result<Grid<D>, CaseError> {
    let corner = |values: &[f64]| std::array::from_fn(|axis| values[axis]);
    Grid::new(corner(&case.domain.min), corner(&case.domain.max), options.cell_size).map_err(|error| {
        CaseError::new("methods.mpm.cell_size", CaseErrorKind::coded(error.code(), error.to_string()))
    })
}

/// Returns the layout of the nodes of the case.
pub fn layout<const D: usize>(
    case: &Case,
    grid: &Grid<D>,
    axis: &Basis1d,
    options: &MpmOptions,
) -> Result<Layout<D>, CaseError> {
    let layout = Layout::with_basis(grid, axis);
    if case.domain.periodic.is_empty() {
        return Ok(layout);
    }
    if !options.contacts.is_empty() {
        return Err(CaseError::new(
            "domain.periodic",
            CaseErrorKind::coded("incompatible-options", "is not available with contacts"),
        ));
    }
    let periodic = std::array::from_fn(|axis| case.domain.is_periodic(axis));
    layout.periodic(periodic).ok_or_else(|| {
        let problem = CaseErrorKind::coded(
            "needs-other-key",
            "needs shape linear, ugimp or cpgimp, and along a periodic axis at least 3 cells (cpgimp: 5)",
        );
        CaseError::new("domain.periodic", problem)
    })
}
