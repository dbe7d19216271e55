//! Runs of manufactured solutions.

use std::sync::Arc;

use colluvium_case::{Case, CaseError, Manufactured, Solver, spatial};
use colluvium_constitutive::{BLOCK_SIZE, Mat3};
use colluvium_grid::SquareMatrix;

use crate::background_grid::dimension_dispatch;
use crate::background_grid::dimension_dispatch::SelectedTransfers;
use crate::points::right_stretch::right_stretch;
use crate::solver::MpmSolver;
use crate::transfer::affine_transfer::initialise_affine;
use crate::{Mpm, MpmOptions, setup};

impl Mpm {
    /// Returns the solver of a case under a manufactured solution. Displacements in its snapshots are relative to the positions of the
    /// undeformed body.
    ///
    /// # Errors
    /// As for building the case itself; and when the law refuses the deformation at the start.
    pub fn manufactured_solver(
        &self,
        case: &Case,
        solution: Manufactured,
    ) -> Result<Box<dyn Solver>, CaseError> {
        let options = setup::options(case)?;
        dimension_dispatch::dispatch(
            case,
            &options,
            BuildManufactured { case, options: &options, solution: Arc::new(solution) },
        )
    }
}

/// Setup of a solver for a manufactured solution, in any dimension.
struct BuildManufactured<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
    solution: Arc<Manufactured>,
}

impl dimension_dispatch::DimensionVisitor for BuildManufactured<'_> {
    type Output = Result<Box<dyn Solver>, CaseError>;

    fn visit<const D: usize>(self, chosen: SelectedTransfers<D>) -> Self::Output {
        let mut solver = setup::solver(self.case, self.options, chosen)?;
        solver.initialise_manufactured(&self.solution).map_err(|reason| CaseError::new("bodies", reason))?;
        solver.manufactured_solution = Some(self.solution);
        Ok(Box::new(solver))
    }
}

impl<const D: usize> MpmSolver<D> {
    /// Sets position, velocity, volume and stress of all points to those of the manufactured solution at the start.
    fn initialise_manufactured(&mut self, solution: &Manufactured) -> Result<(), String> {
        for set in &mut self.bodies.sets {
            let mut motions = Vec::with_capacity(set.len());
            let mut gradients: Vec<SquareMatrix<D>> = Vec::with_capacity(set.len());
            for p in 0..set.len() {
                let begun = (solution.start)(spatial(&set.points.origin[p]));
                set.points.position[p] = std::array::from_fn(|c| begun.position[c]);
                set.points.velocity[p] = std::array::from_fn(|c| begun.velocity[c]);
                set.points.volume[p] *= Mat3(begun.deformation).determinant();
                let density = set.points.mass[p] / set.points.volume[p];
                let motion = begun.motion(density, self.background.grid.cell);
                gradients.push(std::array::from_fn(|i| {
                    std::array::from_fn(|j| motion.velocity_gradient_dt.0[i][j])
                }));
                motions.push(motion);
            }
            set.domain.as_mut().update_deformation(&gradients, right_stretch);
            let blocks = motions.chunks(BLOCK_SIZE).zip(set.points.stress.chunks_mut(BLOCK_SIZE));
            for ((motions, stress), states) in blocks.zip(set.states.blocks_mut()) {
                set.material.update(motions, stress, states).map_err(|error| error.source.to_string())?;
            }
            set.points.traction = vec![[0.0; D]; set.len()];
        }
        self.clock.limit = None;
        self.sort();
        initialise_affine(&self.clock, &self.background, &mut self.bodies);
        Ok(())
    }
}
