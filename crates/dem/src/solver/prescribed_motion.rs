//! Motion that a program prescribes while it runs: of walls, of bodies and of the periodic cell, with the stresses on them.

use colluvium_case::{CaseError, spatial};

use crate::boundary::walls::RigidWall;
use crate::solver::DemSolver;
use colluvium_case::CaseErrorKind;

/// Plane wall of a solver, with the force of the grains on it.
#[derive(Clone, Copy)]
pub struct DemWall<'a, const D: usize> {
    wall: &'a RigidWall<D>,
    area: f64,
}

impl<const D: usize> DemWall<'_, D> {
    /// Coordinate along the axis normal to the wall (m).
    pub fn position(&self) -> f64 {
        self.wall.position
    }

    /// Velocity in the last step (m/s).
    pub fn velocity(&self) -> [f64; D] {
        self.wall.velocity
    }

    /// Force of the grains on the wall in the last step (N; N/m in the plane).
    pub fn force(&self) -> [f64; D] {
        self.wall.reaction[0]
    }

    /// Area between the walls beside it, or of the domain where there are none (m²; m in the plane).
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Normal stress of the grains on the wall (Pa, tension-positive, so that a pressure is negative; N/m in the plane).
    pub fn normal_stress(&self) -> f64 {
        -self.wall.outward_force() / self.area
    }
}

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Plane wall of a name in the current stage; `None` if there is none. The reaction of an obstacle is
    /// [`colluvium_case::Solver::reaction`].
    pub fn wall(&self, name: &str) -> Option<DemWall<'_, D>> {
        let wall = self.boundary.walls.iter().find(|wall| wall.surface.is_none() && wall.name == name)?;
        let area = self.boundary.wall_area(&self.clock, &self.cell.geometry, wall.axis);
        Some(DemWall { wall, area })
    }

    /// Prescribes the velocity of a plane wall (m/s) from the next step on, in place of that of its boundary and of a servo, until
    /// [`DemSolver::release_wall`]. Its normal component moves the wall; the others only act by friction. A checkpoint contains it. The
    /// step is not limited by the speed of a wall: a wall should move by a small part of a radius in a step.
    ///
    /// # Errors
    /// When there is no such wall in the current stage, for an obstacle ([`DemSolver::set_obstacle_velocity`] moves it), and when the velocity is
    /// not finite.
    pub fn set_wall_velocity(&mut self, name: &str, velocity: [f64; D]) -> Result<(), CaseError> {
        let wall = self.plane_wall_mut(name)?;
        check_finite(&format!("boundaries[{}].velocity", wall.boundary), &velocity)?;
        wall.program_velocity = Some(velocity);
        Ok(())
    }

    /// Returns a wall to the velocity of its boundary or to its servo.
    ///
    /// # Errors
    /// When there is no such wall in the current stage.
    pub fn release_wall(&mut self, name: &str) -> Result<(), CaseError> {
        let boundaries = &self.clock.case.boundaries;
        let of_boundary = boundaries.iter().find(|boundary| boundary.name() == name);
        let velocity = of_boundary.and_then(|boundary| boundary.velocity.as_ref());
        let velocity = velocity.map_or([0.0; D], |v| std::array::from_fn(|c| spatial(v)[c]));
        let is_servo = self.clock.stage_options().is_some_and(|stage| stage.walls.contains_key(name));
        let wall = self.plane_wall_mut(name)?;
        wall.program_velocity = None;
        if !is_servo {
            wall.velocity = velocity;
        }
        self.records.energy_balance.begin_stage();
        Ok(())
    }

    /// Gives an obstacle with a `motion` in the case a velocity (m/s) from the present time on, in place of that motion; a rotation stops. A
    /// checkpoint contains it.
    ///
    /// # Errors
    /// When there is no such obstacle, when it has no motion in the case, and when the velocity is not finite.
    pub fn set_obstacle_velocity(&mut self, name: &str, velocity: [f64; D]) -> Result<(), CaseError> {
        self.clock.case.check_obstacle_velocity(name, &velocity)?;
        let time = self.clock.time;
        let of_obstacle = |wall: &&mut RigidWall<D>| wall.motion.is_some() && wall.name == name;
        if let Some(moving) =
            self.boundary.walls.iter_mut().find(of_obstacle).and_then(|wall| wall.motion.as_mut())
        {
            moving.set_program_velocity(time, &velocity);
        }
        Ok(())
    }

    /// Prescribes the velocity of a body whose grains have a prescribed motion (`held` or `rigid`) (m/s) from the next step on, in place of
    /// that of the case, until [`DemSolver::release_body`]. A checkpoint contains it. The force on the body is
    /// [`colluvium_case::Solver::reaction`].
    ///
    /// # Errors
    /// When there is no such body, when its grains are free, and when the velocity is not finite.
    pub fn set_body_velocity(&mut self, name: &str, velocity: [f64; D]) -> Result<(), CaseError> {
        let body = self.body_number(name)?;
        let own = |i: usize| self.grains.body[i] == body;
        if (0..self.grains.len()).any(|i| own(i) && !self.grains.is_held[i]) {
            let problem = "is missing: only a body with prescribed motion can be moved by the program";
            return Err(CaseError::new(
                format!("methods.dem.bodies.{name}.held"),
                CaseErrorKind::coded("needs-other-key", problem),
            ));
        }
        check_finite(&format!("bodies[{body}].velocity"), &velocity)?;
        self.boundary.body_velocities.insert(body, velocity);
        // The step limit depends on the speed.
        let bodies = self.grains.body.iter().zip(&mut self.grains.velocity);
        bodies.filter(|(of, _)| **of == body).for_each(|(_, own)| *own = velocity);
        self.extremes.is_outdated = true;
        Ok(())
    }

    /// Returns a body to the motion of the case: a rigid body to that of the stage. A held body continues at its present velocity.
    ///
    /// # Errors
    /// When there is no such body.
    pub fn release_body(&mut self, name: &str) -> Result<(), CaseError> {
        let body = self.body_number(name)?;
        self.boundary.body_velocities.remove(&body);
        Ok(())
    }

    /// Prescribes the velocity gradient of the periodic cell (1/s), `gradient[i][j] = ∂v_i/∂x_j`, from the next step on, in place of the
    /// control of the stages, until [`DemSolver::release_cell`]. A checkpoint contains it.
    ///
    /// # Errors
    /// When an entry is not finite; when one other than zero is below the diagonal, or has an axis along which the domain is not periodic.
    pub fn set_cell_gradient(&mut self, gradient: [[f64; D]; D]) -> Result<(), CaseError> {
        for (i, row) in gradient.iter().enumerate() {
            check_finite("domain.periodic", row)?;
            for (j, value) in row.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                let refuse = |problem: String| Err(CaseError::new("domain.periodic", problem));
                if j < i {
                    return refuse(format!(
                        "the entry [{i}][{j}] of the velocity gradient, {value}, is below the diagonal: a cell shears above it only"
                    ));
                }
                if [i, j].iter().any(|axis| !self.cell.geometry.periodic[*axis]) {
                    return refuse(format!(
                        "the domain is not periodic along the axes of the entry [{i}][{j}] of the velocity gradient, and cannot deform"
                    ));
                }
            }
        }
        self.cell.program_gradient = Some(gradient);
        Ok(())
    }

    /// Returns the periodic cell to the control of its stage.
    pub fn release_cell(&mut self) {
        self.cell.program_gradient = None;
    }

    /// Stress of the periodic cell at the last forces (Pa, tension-positive; N/m in the plane): that of the contacts over the volume of the
    /// cell, and the kinetic one of its deformation.
    pub fn cell_stress(&self) -> [[f64; D]; D] {
        self.cell.stress()
    }

    /// Plane wall of a name.
    fn plane_wall_mut(&mut self, name: &str) -> Result<&mut RigidWall<D>, CaseError> {
        let boundaries = self.clock.case.boundaries.len();
        let problem = || format!("have no wall {name:?} in the current stage");
        let missing = || CaseError::new("boundaries", problem());
        let wall = self.boundary.walls.iter_mut().find(|wall| wall.name == name).ok_or_else(missing)?;
        match wall.boundary.checked_sub(boundaries) {
            None => Ok(wall),
            Some(obstacle) => {
                let problem = "is an obstacle, not a wall: use `set_obstacle_velocity`";
                Err(CaseError::new(format!("obstacles[{obstacle}]"), problem))
            }
        }
    }

    /// Index of a body of the case by its name.
    fn body_number(&self, name: &str) -> Result<u32, CaseError> {
        let problem = || CaseError::new("bodies", format!("have no body {name:?}"));
        self.clock.body_index(name).ok_or_else(problem)
    }
}

/// Refuses numbers that are not finite.
fn check_finite(path: &str, values: &[f64]) -> Result<(), CaseError> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(CaseError::new(
            path,
            CaseErrorKind::coded("program-request", format!("{value} must be finite")),
        )),
        None => Ok(()),
    }
}
