//! Reading and changing the solver between steps of a program: nodes, velocities, body force.

use colluvium_case::{BodyForce, CaseError, PointColumn};

use crate::NAME;
use crate::config::choices::Phases;
use crate::flow::{Flow, PhaseSet};
use crate::points::phase_nodes::{PhaseNodes, PlanVector};
use crate::solver::DepthSolver;
use colluvium_case::CaseErrorKind;

/// Nodes of a solver, as slices of its arrays, phase by phase.
///
/// The order of the nodes changes when the solver sorts them by cells, and their number where nodes enter or leave; [`DepthNodes::id`]
/// identifies a node. Positions and velocities are those in plan. With inflows and open boundaries some nodes are outside the flow.
#[derive(Clone, Copy)]
pub struct DepthNodes<'a, const D: usize> {
    flow: &'a Flow<D>,
    /// First phase, and the number of phases.
    phases: (usize, usize),
}

impl<'a, const D: usize> DepthNodes<'a, D> {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.sets().iter().map(PhaseSet::len).sum()
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of phases with separate nodes: 2 for grains and pore fluid, and for two layers.
    pub fn phase_count(&self) -> usize {
        self.phases.1
    }

    /// Nodes of a phase: 0 for a single phase, the grains or the lower layer, 1 for the pore fluid or the upper layer; none beyond.
    #[must_use]
    pub fn of_phase(&self, phase: usize) -> Self {
        let (first, count) = self.phases;
        let phases = if phase < count { (first + phase, 1) } else { (first, 0) };
        Self { phases, ..*self }
    }

    /// Numbers of the nodes, constant during a run.
    pub fn id(&self) -> PointColumn<'a, u64> {
        self.column(|nodes| &nodes.id)
    }

    /// Index of the body of each node in [`colluvium_case::Case::bodies`].
    pub fn body(&self) -> PointColumn<'a, u32> {
        self.column(|nodes| &nodes.body)
    }

    /// Positions in plan (m).
    pub fn position(&self) -> PointColumn<'a, PlanVector<D>> {
        self.column(|nodes| &nodes.position)
    }

    /// Velocities in plan, means over the depth (m/s).
    pub fn velocity(&self) -> PointColumn<'a, PlanVector<D>> {
        self.column(|nodes| &nodes.velocity)
    }

    /// Depths of the flow with all its phases (m): vertical, or normal to a tilted bed.
    pub fn depth(&self) -> PointColumn<'a, f64> {
        self.column(|nodes| &nodes.depth)
    }

    /// Parts of the depth that the phase of each node fills (m): the whole depth in a single phase, `(1 - n) h` of grains and `n h` of fluid
    /// with a porosity `n`, and the thickness of a layer.
    pub fn thickness(&self) -> PointColumn<'a, f64> {
        self.column(|nodes| &nodes.partial_thickness)
    }

    /// Volumes of the phase (m³; m² per metre of width in a profile).
    pub fn volume(&self) -> PointColumn<'a, f64> {
        self.column(|nodes| &nodes.volume)
    }

    /// Smoothing lengths (m).
    pub fn smoothing_length(&self) -> PointColumn<'a, f64> {
        self.column(|nodes| &nodes.length)
    }

    /// Densities of the phase (kg/m³): of the grains or the fluid themselves where these are separate phases.
    pub fn density(&self) -> impl Iterator<Item = f64> + use<'a, D> {
        let nodes = *self;
        nodes.numbers().flat_map(move |set| {
            std::iter::repeat_n(nodes.set_density(set), nodes.flow.nodes.sets[set].len())
        })
    }

    /// Masses, density times volume (kg; per metre of width in a profile).
    pub fn mass(&self) -> impl Iterator<Item = f64> + use<'a, D> {
        let nodes = *self;
        nodes.numbers().flat_map(move |set| {
            let density = nodes.set_density(set);
            nodes.flow.nodes.sets[set].nodes.volume.iter().map(move |volume| density * volume)
        })
    }

    /// Levels of the bed below the nodes (m), positive upwards; zero beyond the bed.
    pub fn bed_level(&self) -> impl Iterator<Item = f64> + use<'a, D> {
        let flow = self.flow;
        self.sets()
            .iter()
            .flat_map(move |set| set.nodes.position.iter().map(move |x| flow.bed_below(x).level))
    }

    /// Numbers of the node sets.
    fn numbers(&self) -> std::ops::Range<usize> {
        self.phases.0..self.phases.0 + self.phases.1
    }

    /// Node sets of the phases.
    fn sets(&self) -> &'a [PhaseSet<D>] {
        &self.flow.nodes.sets[self.numbers()]
    }

    /// Density of a node set (kg/m³).
    fn set_density(&self, set: usize) -> f64 {
        self.flow.settings.set_density(self.flow.nodes.sets.len(), set)
    }

    /// Column of all sets.
    fn column<T>(&self, of_set: impl Fn(&'a PhaseNodes<D>) -> &'a Vec<T>) -> PointColumn<'a, T> {
        PointColumn::new(self.sets().iter().map(|set| of_set(&set.nodes).as_slice()))
    }
}

impl<const D: usize> DepthSolver<D> {
    /// Nodes of all phases.
    pub fn nodes(&self) -> DepthNodes<'_, D> {
        DepthNodes { flow: &self.flow, phases: (0, self.flow.nodes.sets.len()) }
    }

    /// Velocities of the nodes in plan (m/s), in the order of [`DepthNodes::velocity`], to be changed between two steps; a velocity that is
    /// not finite fails the next step. Inflows and open boundaries set those of the nodes outside the flow. The change of energy counts as
    /// inflow in the energy balance.
    pub fn velocities_mut(&mut self) -> impl Iterator<Item = &mut PlanVector<D>> {
        // The limit of the step depends on the velocities.
        self.limit = None;
        self.flow.begin_program_change();
        for set in &mut self.flow.nodes.sets {
            // Unknown until the next forces.
            set.nodes.relative_speed.fill(f64::NAN);
        }
        self.flow.nodes.sets.iter_mut().flat_map(|set| &mut set.nodes.velocity)
    }

    /// Sets an acceleration in plan (m/s²) by position in plan (m), velocity in plan (m/s) and time since the start of the flow (s), which
    /// acts on all nodes in addition to gravity from the next step on; it replaces an earlier one. It is that at the start of a step. The
    /// time does not count stages that only equilibrate. Its work counts in the energy balance. A checkpoint does not contain it: set it
    /// again before a state with a body force is restored.
    ///
    /// # Errors
    /// In a case of two phases or layers.
    pub fn set_body_force(
        &mut self,
        acceleration: impl Fn(&[f64; D], &[f64; D], f64) -> [f64; D] + Send + Sync + 'static,
    ) -> Result<(), CaseError> {
        if self.flow.settings.phases != Phases::One {
            let problem = "excludes a body force of the program: its share of each phase is not defined";
            return Err(CaseError::new(
                format!("methods.{NAME}.phases"),
                CaseErrorKind::coded("incompatible-options", problem),
            ));
        }
        self.flow.body_force.acting = Some(BodyForce::new(acceleration));
        Ok(())
    }

    /// Removes the body force of the program.
    pub fn clear_body_force(&mut self) {
        self.flow.body_force.acting = None;
        self.flow.nodes.sets.iter_mut().for_each(|set| set.nodes.body_acceleration.clear());
    }
}
