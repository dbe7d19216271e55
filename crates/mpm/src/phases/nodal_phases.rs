//! Operations of a step on the nodes of one phase or of two.

use colluvium_case::SolverError;

use crate::background_grid::BackgroundGrid;
use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::clock::Clock;
use crate::momentum::velocity_fields::VelocitySource;
use crate::points::bodies::Bodies;
use crate::stress::averages::CellAverages;
use crate::transfer::p2g::P2gContent;
use crate::transfer::point_update::UpdateSelection;

/// Nodes of one phase, or of skeleton and pore fluid, with the operations of a step (sheet: mpm §3.3, §3.4).
///
/// Operations that only one phase has do nothing by default.
pub(crate) trait NodalPhases<const D: usize> {
    /// Adds the points' mass, momentum and forces to the nodes (step 1).
    fn p2g(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
        averages: &mut CellAverages<D>,
        content: P2gContent,
    );

    /// Velocities of the nodes at the start of a step, before any stress is updated (stress first; step 1 without forces).
    fn start_velocities(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
        averages: &mut CellAverages<D>,
    );

    /// Corrects the stress of points at a free surface.
    fn correct_free_surface(
        &mut self,
        _background: &BackgroundGrid<D>,
        _bodies: &mut Bodies<D>,
        _averages: &mut CellAverages<D>,
    ) {
    }

    /// Rescales the forces on nodes of small mass.
    fn rescale_small_mass_forces(
        &mut self,
        _clock: &Clock,
        _background: &BackgroundGrid<D>,
        _bodies: &mut Bodies<D>,
    ) {
    }

    /// Solves the equation of motion of the nodes with boundary conditions, contact and damping (steps 2 to 4).
    ///
    /// # Errors
    /// When a system of equations has no solution.
    fn solve_momentum(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
    ) -> Result<(), SolverError>;

    /// Maps the updated velocities of the points to the nodes again (step 6, stress last from re-mapped velocities).
    fn remap(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
    );

    /// Limits the penetration of points into obstacles by the re-mapped velocities.
    fn limit_remapped(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
    );

    /// Averages strain increments over cells or nodes (step 7).
    fn average_strains(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        averages: &mut CellAverages<D>,
        source: VelocitySource,
    );

    /// Updates loads that follow the surface by the deformation of the step.
    fn update_follower_loads(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        source: VelocitySource,
    );

    /// Updates the selected state of the points from nodal velocities (steps 5, 7 to 9). Returns the largest displacement of a point along
    /// an axis (m).
    ///
    /// # Errors
    /// When a point leaves the domain or its state is not finite.
    fn update_points(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &mut Bodies<D>,
        boundary: &mut BoundaryConditions<D>,
        averages: &mut CellAverages<D>,
        update: (VelocitySource, UpdateSelection),
    ) -> Result<f64, SolverError>;
}
