//! Reading and changing the solver between steps of a program.

use colluvium_case::bodies::law_points::law_output;
use colluvium_case::{BodyForce, CaseError, PointColumn, spatial};
use colluvium_constitutive::SymTensor;

use crate::points::point_set::PointSet;
use crate::solver::MpmSolver;
use colluvium_case::CaseErrorKind;

/// Points of a solver, as slices of its arrays, body by body.
///
/// The order of the points changes when the solver sorts them by cells; [`MpmPoints::id`] identifies a point.
#[derive(Clone, Copy)]
pub struct MpmPoints<'a, const D: usize> {
    sets: &'a [PointSet<D>],
}

impl<'a, const D: usize> MpmPoints<'a, D> {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.sets.iter().map(PointSet::len).sum()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Numbers of the points, constant during a run.
    pub fn id(&self) -> PointColumn<'a, u32> {
        self.column(|set| &set.points.id)
    }

    /// Index of the body of each point in [`colluvium_case::Case::bodies`].
    pub fn body(&self) -> impl Iterator<Item = u32> + use<'a, D> {
        self.sets.iter().flat_map(|set| std::iter::repeat_n(set.body, set.len()))
    }

    /// Points of a body, by its index in [`colluvium_case::Case::bodies`]; none where it has been removed.
    #[must_use]
    pub fn of_body(&self, body: u32) -> Self {
        let found = self.sets.iter().position(|set| set.body == body);
        Self { sets: found.map_or(&[], |number| &self.sets[number..=number]) }
    }

    /// Positions (m).
    pub fn position(&self) -> PointColumn<'a, [f64; D]> {
        self.column(|set| &set.points.position)
    }

    /// Velocities (m/s).
    pub fn velocity(&self) -> PointColumn<'a, [f64; D]> {
        self.column(|set| &set.points.velocity)
    }

    /// Cauchy stresses (Pa, tension-positive); effective ones in a body with a pore fluid.
    pub fn stress(&self) -> PointColumn<'a, SymTensor> {
        self.column(|set| &set.points.stress)
    }

    /// Masses (kg; per metre in plane strain, per radian in axisymmetry).
    pub fn mass(&self) -> PointColumn<'a, f64> {
        self.column(|set| &set.points.mass)
    }

    /// Volumes (m³; m² in plane strain, per radian in axisymmetry).
    pub fn volume(&self) -> PointColumn<'a, f64> {
        self.column(|set| &set.points.volume)
    }

    /// Densities, mass over volume (kg/m³).
    pub fn density(&self) -> impl Iterator<Item = f64> + use<'a, D> {
        self.sets.iter().flat_map(|set| {
            set.points.mass.iter().zip(&set.points.volume).map(|(mass, volume)| mass / volume)
        })
    }

    /// Values of an output of the material laws by its name, such as `plastic_strain`, in the order of the points; NaN in
    /// bodies whose law has no such output, `None` where no law has. They are computed by the call.
    pub fn field(&self, name: &str) -> Option<Vec<f64>> {
        law_output(self.sets.iter().map(PointSet::law_points), name)
    }

    /// Column of all sets.
    fn column<T>(&self, of_set: impl Fn(&'a PointSet<D>) -> &'a Vec<T>) -> PointColumn<'a, T> {
        PointColumn::new(self.sets.iter().map(|set| of_set(set).as_slice()))
    }
}

impl<const D: usize> MpmSolver<D> {
    /// Points of all bodies.
    pub fn points(&self) -> MpmPoints<'_, D> {
        MpmPoints { sets: &self.bodies.sets }
    }

    /// Velocities of the deformable points (m/s), to be changed between two steps; a velocity that is not finite fails the next step. Affine
    /// velocity fields of APIC and TPIC keep their gradients.
    pub fn velocities_mut(&mut self) -> impl Iterator<Item = &mut [f64; D]> {
        // The limit of the step depends on the velocities.
        self.clock.limit = None;
        self.deformable_sets().flat_map(|set| &mut set.points.velocity)
    }

    /// Stresses of the deformable points (Pa, tension-positive), to be changed between two steps. Internal variables of the laws are kept.
    pub fn stresses_mut(&mut self) -> impl Iterator<Item = &mut SymTensor> {
        self.clock.limit = None;
        self.deformable_sets().flat_map(|set| &mut set.points.stress)
    }

    /// Sets an acceleration (m/s²) by position (m), velocity (m/s) and time (s), which acts on all deformable points in addition to gravity
    /// from the next step on; it replaces an earlier one. A checkpoint does not contain it: set it again before a state with a body force
    /// is restored.
    ///
    /// # Errors
    /// In a case with a pore fluid.
    pub fn set_body_force(
        &mut self,
        acceleration: impl Fn(&[f64; D], &[f64; D], f64) -> [f64; D] + Send + Sync + 'static,
    ) -> Result<(), CaseError> {
        if let Some(body) = self.clock.case.bodies.iter().position(|body| body.pore_fluid.is_some()) {
            let problem =
                "excludes a body force of the program: its share of skeleton and fluid is not defined";
            return Err(CaseError::new(
                format!("bodies[{body}].pore_fluid"),
                CaseErrorKind::coded("incompatible-options", problem),
            ));
        }
        self.boundary.body_force = Some(BodyForce::new(acceleration));
        for set in self.deformable_sets() {
            set.points.body_force.resize(set.points.len(), [0.0; D]);
        }
        Ok(())
    }

    /// Gives an obstacle with a `motion` in the case a velocity (m/s) from the present time on, in place of that motion; a rotation stops. A
    /// checkpoint contains it.
    ///
    /// # Errors
    /// When there is no such obstacle, when it has no motion in the case, and when the velocity is not finite.
    pub fn set_obstacle_velocity(&mut self, name: &str, velocity: [f64; D]) -> Result<(), CaseError> {
        let number = self.clock.case.check_obstacle_velocity(name, &velocity)?;
        if let Some(moving) = self.boundary.moving_obstacles_mut().nth(number) {
            moving.set_program_velocity(self.clock.time, &velocity);
        }
        // The limit of the step depends on the velocity.
        self.clock.limit = None;
        Ok(())
    }

    /// Prescribes the velocity of a rigid body or of a patch (m/s) from the next step on, in place of its motion in the case, until
    /// [`MpmSolver::release_body`]; a rotation stops. A checkpoint contains it. The force on the body is
    /// [`colluvium_case::Solver::reaction`].
    ///
    /// # Errors
    /// When there is no such body or patch, when the body is not rigid, and when the velocity is not finite.
    pub fn set_body_velocity(&mut self, name: &str, velocity: [f64; D]) -> Result<(), CaseError> {
        let number = self.boundary.driven.iter().position(|driven| driven.name == name);
        let required = "only a rigid body or a patch can be moved by the program";
        self.clock.case.check_body_velocity(name, &velocity, number.is_some(), required)?;
        let Some(number) = number else { return Ok(()) };
        self.boundary.driven[number].state.program_velocity = Some(spatial(&velocity));
        for set in self.bodies.sets.iter_mut().filter(|set| set.rigid == Some(number)) {
            set.points.velocity.fill(velocity);
        }
        // The limit of the step depends on the velocity.
        self.clock.limit = None;
        Ok(())
    }

    /// Returns a rigid body or a patch to its motion in the case.
    ///
    /// # Errors
    /// When there is no such body or patch, and when the body is not rigid.
    pub fn release_body(&mut self, name: &str) -> Result<(), CaseError> {
        let driven = self.boundary.driven.iter_mut().find(|driven| driven.name == name);
        let required = "only a rigid body or a patch has a prescribed motion";
        self.clock.case.check_body_velocity(name, &[], driven.is_some(), required)?;
        if let Some(driven) = driven {
            driven.state.program_velocity = None;
            self.clock.limit = None;
        }
        Ok(())
    }

    /// Points of the deformable bodies.
    fn deformable_sets(&mut self) -> impl Iterator<Item = &mut PointSet<D>> {
        self.bodies.sets.iter_mut().filter(|set| set.rigid.is_none())
    }

    /// Removes the body force of the program.
    pub fn clear_body_force(&mut self) {
        self.boundary.body_force = None;
        self.bodies.sets.iter_mut().for_each(|set| set.points.body_force.clear());
    }
}
