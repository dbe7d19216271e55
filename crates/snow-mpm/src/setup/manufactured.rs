//! Runs of manufactured solutions (sheet: snow-mpm V14).

use colluvium_case::{Case, CaseError, Manufactured, Solver, spatial};
use colluvium_constitutive::{BLOCK_SIZE, Mat3};
use colluvium_grid::SquareMatrix;

use crate::config::SnowTransfer;
use crate::output::energy_balance::EnergyBalance;
use crate::points::bodies::point_slice;
use crate::solver::SnowSolver;
use crate::{SnowMpm, setup};

impl SnowMpm {
    /// Solver of a case under a manufactured solution. Displacements in its snapshots are relative to the points of the free body. Its
    /// energy balance does not include the work of the force.
    ///
    /// # Errors
    /// Those of building the case itself, and when the law rejects the deformation at the start.
    pub fn manufactured_solver(
        &self,
        case: &Case,
        solution: Manufactured,
    ) -> Result<Box<dyn Solver>, CaseError> {
        setup::build(case, Some(solution))
    }
}

impl<const D: usize> SnowSolver<D> {
    /// Sets positions and deformations of the points to the start of a manufactured solution, whose force acts from then on.
    pub(crate) fn begin_manufactured(&mut self, solution: Manufactured) -> Result<(), CaseError> {
        let cell = self.background.grid.cell;
        for body in &mut self.bodies.bodies {
            let points = &mut body.points;
            let mut motions = Vec::with_capacity(points.len());
            for p in 0..points.len() {
                let begun = (solution.start)(spatial(&points.origin[p]));
                points.position[p] = std::array::from_fn(|c| begun.position[c]);
                points.velocity[p] = std::array::from_fn(|c| begun.velocity[c]);
                points.volume[p] *= Mat3(begun.deformation).determinant();
                motions.push(begun.motion(points.mass[p] / points.volume[p], cell));
            }
            let blocks = motions.chunks(BLOCK_SIZE).zip(points.stress.chunks_mut(BLOCK_SIZE));
            for ((motions, stress), states) in blocks.zip(body.states.blocks_mut()) {
                let deformed = body.material.update(motions, stress, states);
                deformed.map_err(|error| CaseError::new("bodies", error.source.to_string()))?;
            }
            body.points.work = body.stored_energies();
        }
        if self.options.transfer == SnowTransfer::Apic {
            self.set_moments(&solution);
        }
        self.bodies.sort(&mut self.background);
        self.energy_balance = EnergyBalance::new(&self.stored_energies(), self.case.removal_shapes.len());
        self.update_step_bounds();
        self.manufactured_solution = Some(solution);
        Ok(())
    }

    /// Sets the velocity moments of the points to the gradient of the solution times the second moment of the shape functions (sheet:
    /// snow-mpm §3.3).
    fn set_moments(&mut self, solution: &Manufactured) {
        let (sweeps, ground) = (self.background.transfers, self.background.grid_view());
        for body in &mut self.bodies.bodies {
            let (points, extent) = (&mut body.points, [body.width; D]);
            for p in 0..points.len() {
                let mut squares = [[0.0; D]];
                sweeps.second_moments(&ground, &point_slice(&[points.position[p]], &extent), &mut squares);
                let gradient =
                    solution.velocity_gradient(spatial(&points.origin[p]), DIFFERENCE * ground.grid.cell);
                let moment = |i: usize, j: usize| squares[0][j] * gradient.map_or(0.0, |of| of[i][j]);
                let moments: SquareMatrix<D> = std::array::from_fn(|i| std::array::from_fn(|j| moment(i, j)));
                points.affine_velocity[p] = moments;
            }
        }
    }
}

/// Width of the finite differences of the initial velocity field (cells).
const DIFFERENCE: f64 = 1e-3;
