//! Manufactured solutions: a motion chosen beforehand, with the body force that makes it one.

use std::sync::Arc;

use colluvium_case::{Case, CaseError, Solver, spatial};
use colluvium_constitutive::{BLOCK, Mat3, Motion, Pore};
use colluvium_grid::Square;

use crate::affine::start_affine;
use crate::bodies::Bodies;
use crate::dispatch::Chosen;
use crate::solver::MpmSolver;
use crate::stretch::right_stretch;
use crate::{Mpm, MpmOptions, dispatch, setup};

/// Where a point is, how fast, and how its surroundings are deformed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prescribed {
    /// Position (m).
    pub position: [f64; 3],
    /// Velocity (m/s).
    pub velocity: [f64; 3],
    /// Deformation gradient since the body was free of stress, row by row.
    pub deformation: [[f64; 3]; 3],
}

/// A solution of the equation of motion by choice: points begin as `start` says, and `force` acts on them all along.
pub struct Manufactured {
    /// State at time zero of the point that a body free of stress has at a place (m).
    pub start: Box<dyn Fn([f64; 3]) -> Prescribed + Send + Sync>,
    /// Body force (m/s²) on that point at a time (s).
    pub force: Box<dyn Fn([f64; 3], f64) -> [f64; 3] + Send + Sync>,
}

impl Mpm {
    /// The solver of a case under a manufactured solution. Displacements in its snapshots count from where the points
    /// of the free body are.
    ///
    /// # Errors
    /// As for building the case itself; and when the law refuses the deformation at the start.
    pub fn manufactured(&self, case: &Case, solution: Manufactured) -> Result<Box<dyn Solver>, CaseError> {
        let options = setup::options(case)?;
        dispatch::dispatch(case, &options, Build { case, options: &options, solution: Arc::new(solution) })
    }
}

struct Build<'a> {
    case: &'a Case,
    options: &'a MpmOptions,
    solution: Arc<Manufactured>,
}

impl dispatch::Visitor for Build<'_> {
    type Output = Result<Box<dyn Solver>, CaseError>;

    fn visit<const D: usize>(self, chosen: Chosen<D>) -> Self::Output {
        let mut solver = setup::solver(self.case, self.options, chosen)?;
        solver.start_manufactured(&self.solution).map_err(|reason| CaseError::new("bodies", reason))?;
        solver.manufactured = Some(self.solution);
        Ok(Box::new(solver))
    }
}

impl<const D: usize> MpmSolver<D> {
    fn start_manufactured(&mut self, solution: &Manufactured) -> Result<(), String> {
        for set in &mut self.bodies.sets {
            let mut motions = Vec::with_capacity(set.len());
            let mut gradients: Vec<Square<D>> = Vec::with_capacity(set.len());
            for p in 0..set.len() {
                let Prescribed { position, velocity, deformation } =
                    (solution.start)(spatial(&set.points.origin[p]));
                set.points.position[p] = std::array::from_fn(|c| position[c]);
                set.points.velocity[p] = std::array::from_fn(|c| velocity[c]);
                let stretch = Mat3(deformation).determinant();
                set.points.volume[p] *= stretch;
                let mut gradient = deformation;
                (0..3).for_each(|c| gradient[c][c] -= 1.0);
                gradients.push(std::array::from_fn(|i| std::array::from_fn(|j| gradient[i][j])));
                motions.push(Motion {
                    deformation: Mat3(deformation),
                    gradient: Mat3(gradient),
                    dt: 1.0,
                    density: set.points.mass[p] / set.points.volume[p],
                    size: self.background.grid.cell,
                    pore: Pore::default(),
                });
            }
            set.domain.as_mut().follow(&gradients, right_stretch);
            let blocks = motions.chunks(BLOCK).zip(set.points.stress.chunks_mut(BLOCK));
            for ((motions, stress), states) in blocks.zip(set.states.blocks_mut()) {
                set.material.update(motions, stress, states).map_err(|error| error.source.to_string())?;
            }
            set.points.traction = vec![[0.0; D]; set.len()];
        }
        self.clock.limit = None;
        self.sort();
        start_affine(&self.clock, &self.background, &mut self.bodies);
        Ok(())
    }
}

impl Manufactured {
    /// Sets the body forces of a step from `time` (s) on.
    pub(crate) fn push<const D: usize>(&self, bodies: &mut Bodies<D>, time: f64) {
        for set in &mut bodies.sets {
            for p in 0..set.len() {
                let force = (self.force)(spatial(&set.points.origin[p]), time);
                set.points.traction[p] = std::array::from_fn(|c| set.points.mass[p] * force[c]);
            }
        }
    }
}
