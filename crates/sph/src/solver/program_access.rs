//! Reading and changing the solver between steps of a program.

use std::ops::Range;
use std::sync::Arc;

use colluvium_case::bodies::law_points::law_output;
use colluvium_case::{BodyForce, CaseError, spatial};
use colluvium_constitutive::SymTensor;

use crate::points::packed_particles::set_velocity;
use crate::points::particles::{Bodies, ParticleGroup, Particles};
use crate::solver::SphSolver;
use colluvium_case::CaseErrorKind;

/// Particles of a solver, as slices of its arrays, body after body.
///
/// The order of the particles of a body changes when the solver sorts them by cells; [`SphParticles::id`] identifies a particle. Particles
/// of walls and images in mirrors are not among them.
#[derive(Clone, Copy)]
pub struct SphParticles<'a, const D: usize> {
    particles: &'a Particles<D>,
    groups: &'a [ParticleGroup],
}

impl<'a, const D: usize> SphParticles<'a, D> {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.range().len()
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.range().is_empty()
    }

    /// Numbers of the particles, constant during a run.
    pub fn id(&self) -> &'a [u32] {
        &self.particles.id[self.range()]
    }

    /// Index of the body of each particle in [`colluvium_case::Case::bodies`].
    pub fn body(&self) -> impl Iterator<Item = u32> + use<'a, D> {
        self.groups.iter().flat_map(|group| std::iter::repeat_n(group.body, group.range().len()))
    }

    /// Particles of a body, by its index in [`colluvium_case::Case::bodies`]; none where it has been removed.
    #[must_use]
    pub fn of_body(&self, body: u32) -> Self {
        let found = self.groups.iter().position(|group| group.body == body);
        Self { groups: found.map_or(&[], |number| &self.groups[number..=number]), ..*self }
    }

    /// Positions (m).
    pub fn position(&self) -> &'a [[f64; D]] {
        &self.particles.position[self.range()]
    }

    /// Velocities (m/s) at the time [`SphSolver::velocity_time`].
    pub fn velocity(&self) -> &'a [[f64; D]] {
        &self.particles.velocity[self.range()]
    }

    /// Cauchy stresses (Pa, tension-positive). With `integration` `leapfrog-rates` they are those at [`SphSolver::velocity_time`].
    pub fn stress(&self) -> &'a [SymTensor] {
        &self.particles.stress[self.range()]
    }

    /// Masses (kg; per metre in plane strain, per square metre in one dimension).
    pub fn mass(&self) -> &'a [f64] {
        &self.particles.mass[self.range()]
    }

    /// Volumes, mass over density (m³; m² in plane strain, m in one dimension).
    pub fn volume(&self) -> impl Iterator<Item = f64> + use<'a, D> {
        self.mass().iter().zip(self.density()).map(|(mass, density)| mass / density)
    }

    /// Densities (kg/m³). With `integration` `leapfrog-rates` they are those at [`SphSolver::velocity_time`].
    pub fn density(&self) -> &'a [f64] {
        &self.particles.density[self.range()]
    }

    /// Values of an output of the material laws by its name, such as `plastic_strain`, in the order of the particles; NaN in
    /// bodies whose law has no such output, `None` where no law has. They are computed by the call.
    pub fn field(&self, name: &str) -> Option<Vec<f64>> {
        law_output(self.groups.iter().map(|group| self.particles.law_points(group)), name)
    }

    /// Index range in the arrays.
    fn range(&self) -> Range<usize> {
        match self.groups {
            [] => 0..0,
            [one] => one.range(),
            [first, .., last] => first.start..last.end,
        }
    }
}

impl<const D: usize> SphSolver<D> {
    /// Particles of all bodies.
    pub fn particles(&self) -> SphParticles<'_, D> {
        SphParticles { particles: &self.bodies.particles, groups: &self.bodies.groups }
    }

    /// Time (s) of the velocities: that of the positions, or half a step before it with `integration` `leapfrog` (the default) and
    /// `leapfrog-rates`. A velocity at the time of the positions is later by the acceleration times the difference.
    pub fn velocity_time(&self) -> f64 {
        let delay = if self.setting.has_half_step_velocities() { 0.5 * self.clock.last_step } else { 0.0 };
        self.clock.time - delay
    }

    /// Velocities (m/s, at [`SphSolver::velocity_time`]) of the particles of all bodies that are neither rigid nor `held`, in the order of
    /// [`SphSolver::particles`], to be changed between two steps. A velocity that is not finite fails the next step. With `integration`
    /// `verlet` the next step uses the velocities of one step only.
    pub fn velocities_mut(&mut self) -> impl Iterator<Item = &mut [f64; D]> {
        self.bodies.particles.previous.clear();
        self.state_has_changed();
        let Particles { velocity, .. } = &mut self.bodies.particles;
        of_free_bodies(&self.bodies.groups, velocity)
    }

    /// Stresses (Pa, tension-positive) of the particles of all bodies that are neither rigid nor `held`, in the order of
    /// [`SphSolver::particles`], to be changed between two steps. Internal variables of the laws are kept. A law that computes its stress
    /// from these or from the motion, such as those of large strains and of fluids, replaces the stress at the end of the next step. A
    /// stress that is not finite fails the next step.
    pub fn stresses_mut(&mut self) -> impl Iterator<Item = &mut SymTensor> {
        self.state_has_changed();
        let Particles { stress, .. } = &mut self.bodies.particles;
        of_free_bodies(&self.bodies.groups, stress)
    }

    /// Sets an acceleration (m/s²) by position (m), velocity (m/s, at the time of [`SphSolver::velocity_time`] with `leapfrog`) and time
    /// (s). It acts on all bodies that are neither rigid nor `held`, in addition to gravity, from the next step on, and replaces an earlier
    /// one. Options that use the weight between particles, `stress_diffusion` and `wall_stress` `extrapolated`, do not include it. A
    /// checkpoint does not contain it: set it again before a state with a body force is restored.
    ///
    /// # Errors
    /// When all bodies are rigid or `held`.
    pub fn set_body_force(
        &mut self,
        acceleration: impl Fn(&[f64; D], &[f64; D], f64) -> [f64; D] + Send + Sync + 'static,
    ) -> Result<(), CaseError> {
        if !self.bodies.groups.iter().any(ParticleGroup::is_free) {
            let problem = "are all rigid or held: a body force of the program has no effect on them";
            return Err(CaseError::new("bodies", CaseErrorKind::coded("nothing-moves", problem)));
        }
        self.bodies.loads.body_force = Some(Arc::new(BodyForce::new(acceleration)));
        let particles = &mut self.bodies.particles;
        particles.body_force.resize(particles.id.len(), [0.0; D]);
        self.state_has_changed();
        Ok(())
    }

    /// Removes the body force of the program.
    pub fn clear_body_force(&mut self) {
        self.bodies.loads.body_force = None;
        self.bodies.particles.body_force.clear();
        self.rates.external_accelerations.clear();
        self.state_has_changed();
    }

    /// Gives an obstacle with a `motion` in the case a velocity (m/s) from the present time on, in place of that motion; a rotation stops. A
    /// checkpoint contains it.
    ///
    /// # Errors
    /// When there is no such obstacle, when it has no motion in the case, and when the velocity is not finite.
    pub fn set_obstacle_velocity(&mut self, name: &str, velocity: [f64; D]) -> Result<(), CaseError> {
        let number = self.setting.case.check_obstacle_velocity(name, &velocity)?;
        if let Some(moving) = self.walls.obstacles.moving_obstacles_mut().nth(number) {
            moving.set_program_velocity(self.clock.time, &velocity);
        }
        self.state_has_changed();
        Ok(())
    }

    /// Prescribes the velocity of a rigid or `held` body (m/s) from the next step on, in place of its motion in the case, until
    /// [`SphSolver::release_body`]; a rotation stops. A checkpoint contains it. The force on a rigid body is
    /// [`colluvium_case::Solver::reaction`].
    ///
    /// # Errors
    /// When there is no such body, when it is neither rigid nor `held`, and when the velocity is not finite.
    pub fn set_body_velocity(&mut self, name: &str, velocity: [f64; D]) -> Result<(), CaseError> {
        let required = "only a rigid or `held` body can be moved by the program";
        let Some(number) = self.prescribed_group(name, &velocity, required)? else { return Ok(()) };
        let Bodies { groups, particles, pair_data, .. } = &mut self.bodies;
        groups[number].program_velocity = Some(spatial(&velocity));
        for i in groups[number].range() {
            particles.velocity[i] = velocity;
            set_velocity(&mut pair_data.records[i], &velocity);
        }
        self.state_has_changed();
        Ok(())
    }

    /// Returns a rigid or `held` body to its motion in the case.
    ///
    /// # Errors
    /// When there is no such body, and when it is neither rigid nor `held`.
    pub fn release_body(&mut self, name: &str) -> Result<(), CaseError> {
        let required = "only a rigid or `held` body has a prescribed motion";
        if let Some(number) = self.prescribed_group(name, &[], required)? {
            self.bodies.groups[number].program_velocity = None;
            self.state_has_changed();
        }
        Ok(())
    }

    /// Index of the group of a rigid or `held` body; `None` if it has been removed.
    fn prescribed_group(
        &self,
        name: &str,
        velocity: &[f64],
        required: &str,
    ) -> Result<Option<usize>, CaseError> {
        let (case, options) = (&self.setting.case, &self.setting.options);
        let body = case.bodies.iter().position(|body| body.name == name);
        let is_prescribed = body
            .is_some_and(|number| case.bodies[number].rigid || options.held.iter().any(|held| held == name));
        case.check_body_velocity(name, velocity, is_prescribed, required)?;
        Ok(self.bodies.groups.iter().position(|group| Some(group.body as usize) == body))
    }

    /// Discards the stable step and the accelerations of the state before.
    pub(crate) fn state_has_changed(&mut self) {
        self.clock.limit = None;
        self.rates.is_current = false;
    }
}

/// Entries of a column for the particles of bodies that are neither rigid nor of prescribed motion.
fn of_free_bodies<'a, T>(
    groups: &'a [ParticleGroup],
    column: &'a mut [T],
) -> impl Iterator<Item = &'a mut T> {
    let mut rest = (0, column);
    groups.iter().filter(|group| group.is_free()).flat_map(move |group| {
        let (start, column) = std::mem::take(&mut rest);
        let (_, column) = column.split_at_mut(group.start - start);
        let (own, column) = column.split_at_mut(group.range().len());
        rest = (group.end, column);
        own
    })
}
