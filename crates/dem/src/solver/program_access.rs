//! Reading and changing the solver between steps of a program: grains, contacts, velocities, body force.

use colluvium_case::BodyForce;

use crate::contact::Contact;
use crate::output::packing_view::PackingView;
use crate::points::grains::Grains;
use crate::solver::DemSolver;

/// Grains of a solver, as slices of its arrays.
///
/// The order of the grains changes when the solver builds its lists of neighbours, and their number where grains enter or are removed;
/// [`DemGrains::id`] identifies a grain. Velocities are those half of the last step before the positions, those of the case at the start.
#[derive(Clone, Copy)]
pub struct DemGrains<'a, const D: usize, const R: usize> {
    grains: &'a Grains<D, R>,
}

impl<'a, const D: usize, const R: usize> DemGrains<'a, D, R> {
    /// Number of grains.
    pub fn len(&self) -> usize {
        self.grains.len()
    }

    /// Whether there are no grains.
    pub fn is_empty(&self) -> bool {
        self.grains.is_empty()
    }

    /// Numbers of the grains, constant during a run.
    pub fn id(&self) -> &'a [u32] {
        &self.grains.id
    }

    /// Index of the body of each grain in [`colluvium_case::Case::bodies`].
    pub fn body(&self) -> &'a [u32] {
        &self.grains.body
    }

    /// Index of the kind of each grain in the order of their names, [`crate::kinds`].
    pub fn kind(&self) -> &'a [u32] {
        &self.grains.kind
    }

    /// Whether each grain has a prescribed motion, which forces do not change.
    pub fn is_held(&self) -> &'a [bool] {
        &self.grains.is_held
    }

    /// Positions of the centres (m).
    pub fn position(&self) -> &'a [[f64; D]] {
        &self.grains.position
    }

    /// Velocities (m/s), half of the last step before the positions.
    pub fn velocity(&self) -> &'a [[f64; D]] {
        &self.grains.velocity
    }

    /// Angular velocities (rad/s), half of the last step before the positions: one number in the plane, anticlockwise positive, and a
    /// vector in space.
    pub fn angular_velocity(&self) -> &'a [[f64; R]] {
        &self.grains.spin
    }

    /// Radii (m).
    pub fn radius(&self) -> &'a [f64] {
        &self.grains.radius
    }

    /// Masses (kg; per metre in the plane).
    pub fn mass(&self) -> &'a [f64] {
        &self.grains.mass
    }

    /// Resultants of the contact forces at the start of the last step (N; N/m in the plane), without gravity and other applied forces.
    pub fn force(&self) -> &'a [[f64; D]] {
        &self.grains.force
    }

    /// Moments of the contact forces about the centres at the start of the last step (N m; N in the plane).
    pub fn moment(&self) -> &'a [[f64; R]] {
        &self.grains.torque
    }
}

/// Contacts of a solver at its present positions and velocities. Each is computed when an iterator reaches it.
#[derive(Clone, Copy)]
pub struct DemContacts<'a, const D: usize, const R: usize> {
    view: PackingView<'a, D, R>,
}

impl<'a, const D: usize, const R: usize> DemContacts<'a, D, R> {
    /// Iterator over the contacts: those of grains first, then those with walls and obstacles.
    pub fn iter(&self) -> impl Iterator<Item = Contact<D>> + use<'a, D, R> {
        self.view.contact_iter()
    }

    /// First contact; `None` without contacts.
    pub fn first(&self) -> Option<Contact<D>> {
        self.iter().next()
    }

    /// Number of contacts, for which all of them are computed.
    pub fn len(&self) -> usize {
        self.iter().count()
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.first().is_none()
    }
}

impl<'a, const D: usize, const R: usize> IntoIterator for DemContacts<'a, D, R> {
    type Item = Contact<D>;
    type IntoIter = Box<dyn Iterator<Item = Contact<D>> + 'a>;

    fn into_iter(self) -> Self::IntoIter {
        Box::new(self.view.contact_iter())
    }
}

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// All grains.
    pub fn grains(&self) -> DemGrains<'_, D, R> {
        DemGrains { grains: &self.grains }
    }

    /// All present contacts of grains with each other, with walls and with obstacles.
    pub fn contacts(&self) -> DemContacts<'_, D, R> {
        DemContacts { view: self.view() }
    }

    /// Velocities of the grains (m/s), half of the last step before the positions, to be changed between two steps; a velocity that is not
    /// finite fails the next step. That of a grain with prescribed motion is its motion, except in a body whose velocity the case or
    /// [`DemSolver::set_body_velocity`] prescribes. The change of energy counts as one between stages (`work.stages`).
    pub fn velocities_mut(&mut self) -> &mut [[f64; D]] {
        self.count_changes();
        &mut self.grains.velocity
    }

    /// Angular velocities of the grains (rad/s), half of the last step before the positions, to be changed between two steps.
    pub fn angular_velocities_mut(&mut self) -> &mut [[f64; R]] {
        self.count_changes();
        &mut self.grains.spin
    }

    /// Records that a program changes grains or their velocities: the energy balance continues with them, and the step limit follows.
    pub(crate) fn count_changes(&mut self) {
        self.extremes.is_outdated = true;
        self.records.energy_balance.begin_stage();
    }

    /// Sets an acceleration (m/s²) by position (m), velocity (m/s) and time (s), which acts on all grains without prescribed motion in
    /// addition to gravity from the next step on; it replaces an earlier one. Velocities are those half of the last step before the
    /// positions. Its work is among that of applied forces (`work.forces`). A checkpoint does not contain it: set it again before a state
    /// with a body force is restored.
    pub fn set_body_force(
        &mut self,
        acceleration: impl Fn(&[f64; D], &[f64; D], f64) -> [f64; D] + Send + Sync + 'static,
    ) {
        self.boundary.body_force.acting = Some(BodyForce::new(acceleration));
    }

    /// Removes the body force of the program.
    pub fn clear_body_force(&mut self) {
        self.boundary.body_force.acting = None;
        self.grains.body_force.clear();
    }
}
