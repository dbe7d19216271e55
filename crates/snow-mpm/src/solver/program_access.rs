//! Reading and changing the solver between steps of a program.

use colluvium_case::bodies::law_points::law_output;
use colluvium_case::{BodyForce, CaseError, PointColumn};
use colluvium_constitutive::SymTensor;

use crate::points::bodies::BodyPoints;
use crate::solver::SnowSolver;

/// Points of a solver, as slices of its arrays, body by body.
///
/// The order of the points changes when the solver sorts them by cells; [`SnowPoints::id`] identifies a point.
#[derive(Clone, Copy)]
pub struct SnowPoints<'a, const D: usize> {
    bodies: &'a [BodyPoints<D>],
}

impl<'a, const D: usize> SnowPoints<'a, D> {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.bodies.iter().map(|body| body.points.len()).sum()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Numbers of the points, constant during a run.
    pub fn id(&self) -> PointColumn<'a, u32> {
        self.column(|body| &body.points.id)
    }

    /// Index of the body of each point in [`colluvium_case::Case::bodies`].
    pub fn body(&self) -> impl Iterator<Item = u32> + use<'a, D> {
        self.bodies.iter().flat_map(|body| std::iter::repeat_n(body.number, body.points.len()))
    }

    /// Points of a body, by its index in [`colluvium_case::Case::bodies`]; none where it has been removed.
    #[must_use]
    pub fn of_body(&self, body: u32) -> Self {
        let found = self.bodies.iter().position(|own| own.number == body);
        Self { bodies: found.map_or(&[], |number| &self.bodies[number..=number]) }
    }

    /// Positions (m).
    pub fn position(&self) -> PointColumn<'a, [f64; D]> {
        self.column(|body| &body.points.position)
    }

    /// Velocities (m/s).
    pub fn velocity(&self) -> PointColumn<'a, [f64; D]> {
        self.column(|body| &body.points.velocity)
    }

    /// Cauchy stresses (Pa, tension-positive).
    pub fn stress(&self) -> PointColumn<'a, SymTensor> {
        self.column(|body| &body.points.stress)
    }

    /// Masses (kg; per metre in plane strain, per square metre in one dimension).
    pub fn mass(&self) -> PointColumn<'a, f64> {
        self.column(|body| &body.points.mass)
    }

    /// Volumes (m³; m² in plane strain, m in one dimension).
    pub fn volume(&self) -> PointColumn<'a, f64> {
        self.column(|body| &body.points.volume)
    }

    /// Densities, mass over volume (kg/m³).
    pub fn density(&self) -> impl Iterator<Item = f64> + use<'a, D> {
        self.bodies.iter().flat_map(|body| {
            body.points.mass.iter().zip(&body.points.volume).map(|(mass, volume)| mass / volume)
        })
    }

    /// Values of an output of the material laws by its name, such as `plastic_strain`, in the order of the points; NaN in
    /// bodies whose law has no such output, `None` where no law has. They are computed by the call.
    pub fn field(&self, name: &str) -> Option<Vec<f64>> {
        law_output(self.bodies.iter().map(BodyPoints::law_points), name)
    }

    /// Column of all bodies.
    fn column<T>(&self, of_body: impl Fn(&'a BodyPoints<D>) -> &'a Vec<T>) -> PointColumn<'a, T> {
        PointColumn::new(self.bodies.iter().map(|body| of_body(body).as_slice()))
    }
}

impl<const D: usize> SnowSolver<D> {
    /// Points of all bodies.
    pub fn points(&self) -> SnowPoints<'_, D> {
        SnowPoints { bodies: &self.bodies.bodies }
    }

    /// Velocities of the points (m/s), to be changed between two steps; a velocity that is not finite fails the next step. Affine velocity
    /// fields of APIC keep their gradients. The energy balance counts the change as removed energy.
    pub fn velocities_mut(&mut self) -> impl Iterator<Item = &mut [f64; D]> {
        self.expect_changes();
        self.bodies.bodies.iter_mut().flat_map(|body| &mut body.points.velocity)
    }

    /// Stresses of the points (Pa, tension-positive), to be changed between two steps. Internal variables of the laws are kept. A law that
    /// computes its stress from these, as all laws of large strains do, replaces the stress at the end of the next step. A stress that is
    /// not finite fails the next step.
    pub fn stresses_mut(&mut self) -> impl Iterator<Item = &mut SymTensor> {
        self.expect_changes();
        self.bodies.bodies.iter_mut().flat_map(|body| &mut body.points.stress)
    }

    /// Sets an acceleration (m/s²) by position (m), velocity (m/s) and time (s), which acts on all points in addition to gravity from the
    /// next step on; it replaces an earlier one. Its work enters the energy balance (`work_of_body_force`). The unbalanced force of a stage
    /// with an equilibrium criterion is still compared with the weight alone. A checkpoint does not contain the function: set it again
    /// before a state with a body force is restored.
    ///
    /// # Errors
    /// None, since all bodies of this method deform; the result is that of the other methods.
    pub fn set_body_force(
        &mut self,
        acceleration: impl Fn(&[f64; D], &[f64; D], f64) -> [f64; D] + Send + Sync + 'static,
    ) -> Result<(), CaseError> {
        self.body_force = Some(BodyForce::new(acceleration));
        for body in &mut self.bodies.bodies {
            body.points.body_force.resize(body.points.id.len(), [0.0; D]);
        }
        Ok(())
    }

    /// Removes the body force of the program.
    pub fn clear_body_force(&mut self) {
        self.body_force = None;
        self.bodies.bodies.iter_mut().for_each(|body| body.points.body_force.clear());
    }

    /// Gives an obstacle with a `motion` in the case a velocity (m/s) from the present time on, in place of that motion; a rotation stops. A
    /// checkpoint contains it.
    ///
    /// # Errors
    /// When there is no such obstacle, when it has no motion in the case, and when the velocity is not finite.
    pub fn set_obstacle_velocity(&mut self, name: &str, velocity: [f64; D]) -> Result<(), CaseError> {
        let number = self.case.check_obstacle_velocity(name, &velocity)?;
        if let Some(moving) = self.obstacles.moving_mut().nth(number) {
            moving.set_program_velocity(self.clock.time, &velocity);
        }
        // The limit of the step depends on the velocity.
        self.update_step_bounds();
        Ok(())
    }

    /// Records the energies before a change of the points by the program.
    fn expect_changes(&mut self) {
        if self.energies_before_changes.is_none() {
            self.energies_before_changes = Some(self.stored_energies());
        }
    }

    /// Adds changes of the points by the program to the energy balance, and updates the time step.
    pub(crate) fn settle_changes(&mut self) {
        if let Some(before) = self.energies_before_changes.take() {
            let after = self.stored_energies();
            self.energy_balance.add_change(&before, &after);
            self.update_step_bounds();
        }
    }
}
