//! What points share before forces and stresses are found.

use crate::background::Background;
use crate::dual::DualNodes;
use crate::free_surface::FreeSurface;
use crate::mixed::CellStresses;
use crate::strain::CellStrains;

/// Averages over cells and nodes; each is empty where the options do not ask for it.
pub struct Averages<const D: usize> {
    pub(crate) strains: CellStrains,
    pub(crate) stresses: CellStresses,
    pub(crate) dual: DualNodes,
    pub(crate) free_surface: Option<Box<FreeSurface<D>>>,
}

impl<const D: usize> Averages<D> {
    /// Empties the active entries.
    pub fn reset(&mut self, background: &Background<D>) {
        let cells = background.cell_layout();
        self.strains.reset([&background.layout, cells]);
        self.stresses.reset(cells);
        self.dual.reset(&background.layout);
    }
}
