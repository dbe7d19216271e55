//! Measures of the packing at present, and choices of kernels and searches, for users of the crate.

use crate::output::coarse_graining::{CoarseFields, CoarseGrainingNodes};
use crate::output::fabric::Fabric;
use crate::output::laguerre_tessellation::Tessellation;
use crate::output::void_ratio_bands::{VoidRatioBands, void_ratio_bands};
use crate::solver::DemSolver;
use crate::specimen::Specimen;

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Selects the scalar contact kernel, which the solver always uses for grains with attraction or bonds. The forces are
    /// equal to the last bit; sums over contacts of all grains are equal to round-off.
    pub fn use_scalar_contacts(&mut self) {
        self.laws.scalar_only = true;
    }

    /// Selects the search in uniform cells, whatever the sizes of grains. The lists are equal.
    pub fn use_uniform_cells(&mut self) {
        self.neighbours.pairs.uniform_cells = true;
    }

    /// Bodies that were filled with grains at the start, except single grains, points, specimens from files and bodies filled by
    /// pluviation.
    pub fn specimens(&self) -> &[Specimen] {
        &self.specimen.reports
    }

    /// Number of contacts with a force in the last step.
    pub fn contact_count(&self) -> u64 {
        self.records.energy_balance.contacts[0]
    }

    /// Fabric of the present contacts; `None` without contacts between grains. Held grains are never rattlers and are not counted.
    pub fn fabric(&self) -> Option<Fabric<D>> {
        self.view().fabric()
    }

    /// Contact rose: fraction of the contacts between grains in each of `bins` equal sectors of the half turn from the x axis towards y.
    /// Normals are projected along z. All zero without contacts.
    pub fn contact_rose(&self, bins: usize) -> Vec<f64> {
        self.view().contact_rose(bins)
    }

    /// Force chains as ascending grain numbers, the longest chain first, and of equal ones that with the lowest number.
    pub fn force_chains(&self) -> Vec<Vec<usize>> {
        self.view().force_chains()
    }

    /// Laguerre tessellation of the present disks, within the domain and its plane walls; empty in space.
    pub fn tessellation(&self) -> Tessellation {
        self.view().tessellation()
    }

    /// Solid fraction of all cells except surface cells; not-a-number if there are none.
    pub fn inner_solid_fraction(&self) -> f64 {
        self.view().inner_solid_fraction()
    }

    /// Continuum fields of the grains at `nodes`, by a Lucy kernel of radius `width` (m), periodic images included. Velocities are those
    /// half a step before the positions, as stored.
    pub fn coarse_grained(&self, nodes: &CoarseGrainingNodes<D>, width: f64) -> Vec<CoarseFields<D>> {
        self.view().coarse_grained(nodes, width)
    }
}

impl DemSolver<2, 1> {
    /// Void ratios of horizontal bands of equal height between two heights (m), in a range that contains the disks or is periodic (m).
    /// `None` for fewer than two bands, an empty range, and without disks.
    pub fn void_ratio_bands(
        &self,
        sides: [f64; 2],
        heights: [f64; 2],
        bands: usize,
    ) -> Option<VoidRatioBands> {
        void_ratio_bands(&self.grains, sides, heights, bands)
    }
}
