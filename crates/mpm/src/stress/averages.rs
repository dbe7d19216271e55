//! Averages over cells and nodes, before forces and stresses are computed.

use crate::background_grid::BackgroundGrid;
use crate::stress::cell_integration::CellStresses;
use crate::stress::dual_domain::DualDomainNodes;
use crate::stress::free_surface::FreeSurface;
use crate::stress::volumetric_strain::CellStrains;

/// Averages over cells and nodes; those that the options do not need are empty.
pub struct CellAverages<const D: usize> {
    /// Mean volumetric strains of cells.
    pub(crate) strains: CellStrains,
    /// Mean stresses of cells.
    pub(crate) stresses: CellStresses,
    /// Nodal averages of the dual domain method.
    pub(crate) dual_domain: DualDomainNodes,
    /// Cells and nodes at the free surface of liquids.
    pub(crate) free_surface: Option<Box<FreeSurface<D>>>,
}

impl<const D: usize> CellAverages<D> {
    /// Sets the entries of active cells and nodes to zero.
    pub fn reset(&mut self, background: &BackgroundGrid<D>) {
        let cells = background.cell_layout();
        self.strains.reset([&background.layout, cells]);
        self.stresses.reset(cells);
        self.dual_domain.reset(&background.layout);
    }
}
