//! Solver of a case: a flow with the outputs and stages of a run.

mod checkpoint;
mod program_access;
mod stop_detection;

use std::io::{Read, Write};
use std::sync::Arc;

use crate::boundary::stages;
use crate::config::DepthOptions;
use crate::config::choices::DepthFrame;
use crate::flow::{Flow, FlowFailure, LimitingNode, PhaseSet};
use crate::output::budget::budget;
use crate::output::gauges::{depth_and_flux, discharge};
use crate::output::hazard_rasters::HazardRasters;
use crate::output::scalar_outputs::{RunState, scalar_outputs};
use crate::output::snapshot::snapshot;
use crate::output::warnings::warnings_at_end;
use crate::points::phase_nodes::{PhaseNodes, PlanVector};
use crate::solver::checkpoint::{CheckpointState, FORMAT};
pub use crate::solver::program_access::DepthNodes;
use crate::solver::stop_detection::{FlowMotion, StopDetection};
use colluvium_case::Warning;
use colluvium_case::description::{Domain, Reset, Stage};
use colluvium_case::measure::ScalarOutput;
use colluvium_case::solver::{restore_value, save_value};
use colluvium_case::{
    Advance, Budget, Case, Dataset, Equilibrium, Frame, FrameRequest, PlanRaster, Solver, SolverError,
    StepLimit, TimeStep, check_saved_body_force, spatial,
};

/// Steps for each check of the criterion, in a stage without motion.
const CHECKS: f64 = 4.0;

/// Depth-integrated SPH over a profile (`D` = 1) or over terrain (`D` = 2).
pub struct DepthSolver<const D: usize> {
    /// Case of the run.
    pub(crate) case: Arc<Case>,
    /// Options of the method.
    pub(crate) options: DepthOptions,
    /// Flow: its nodes, its bed and its boundaries.
    pub(crate) flow: Flow<D>,
    /// Index of the current stage.
    pub(crate) stage: usize,
    /// Stage of the checkpoint that has been restored, until the next stage begins.
    restored_stage: Option<usize>,
    time: f64,
    steps: u64,
    stop_detection: StopDetection,
    hazard_rasters: Option<HazardRasters>,
    /// Largest and root-mean-square difference of the bed surface from the levels of its raster (m).
    fit_errors: Option<[f64; 2]>,
    /// Limit of the next step, once it has been computed.
    pub(crate) limit: Option<LimitingNode>,
}

impl<const D: usize> DepthSolver<D> {
    /// Solver of a flow at time zero.
    pub(crate) fn new(
        case: Arc<Case>,
        options: DepthOptions,
        flow: Flow<D>,
        maps: Option<HazardRasters>,
        fit_errors: Option<[f64; 2]>,
    ) -> Self {
        let mut solver = Self {
            case,
            options,
            flow,
            stage: 0,
            restored_stage: None,
            time: 0.0,
            steps: 0,
            stop_detection: StopDetection::default(),
            hazard_rasters: maps,
            fit_errors,
            limit: None,
        };
        solver.update_hazard_rasters();
        solver
    }

    /// Updates the rasters with the current flow.
    fn update_hazard_rasters(&mut self) {
        if let Some(maps) = &mut self.hazard_rasters {
            maps.update(&self.flow.view());
        }
    }

    /// Flow of the solver.
    pub fn flow(&self) -> &Flow<D> {
        &self.flow
    }

    /// Volume of the nodes of each body within the domain (m³), without those outside open boundaries.
    pub(crate) fn volumes(&self) -> Vec<f64> {
        let Domain { min, max, .. } = &self.case.domain;
        let inside =
            |place: &[f64; D]| (0..D).all(|axis| place[axis] >= min[axis] && place[axis] <= max[axis]);
        let mut volumes = vec![0.0; self.case.bodies.len()];
        for PhaseNodes { body, volume, position, .. } in self.flow.nodes.sets.iter().map(|set| &set.nodes) {
            for node in (0..body.len()).filter(|node| inside(&position[*node])) {
                volumes[body[node] as usize] += volume[node];
            }
        }
        volumes
    }

    /// Whether the current stage relaxes the flow to its initial equilibrium.
    fn is_equilibration_stage(&self) -> bool {
        stages::is_equilibration_stage(&self.case.stages[self.stage])
    }

    /// Bound of the time step for a flow without motion (s). An idle stage ends when its criterion has been checked as often as required;
    /// without any material the run continues to its end.
    fn idle_step(&self) -> f64 {
        let stage = &self.case.stages[self.stage];
        if let Some(criterion) = stage.equilibrium {
            return stage.duration / (CHECKS * f64::from(criterion.hold.max(1)));
        }
        if self.flow.records.removed_nodes > 0 && self.point_count() == 0 {
            self.case.end_time()
        } else {
            f64::INFINITY
        }
    }

    /// Error of the solver for a failure at a node, with its position in space.
    fn solver_error(&self, failure: FlowFailure) -> SolverError {
        let FlowFailure { node_id, position, reason } = failure;
        let mut place: [f64; 3] = std::array::from_fn(|c| position.get(c).copied().unwrap_or(0.0));
        if let Ok(plan) = <PlanVector<D>>::try_from(&position[..]) {
            place[D] = self.flow.bed_below(&plan).level;
        }
        SolverError::Point { step: self.steps, time: self.time, point: node_id, position: place, reason }
    }

    /// Updates the detection of rest.
    fn update_stop_detection(&mut self) {
        let stop = &self.options.stop;
        let motion = FlowMotion::of_flow(&self.flow.view(), stop.speed);
        self.flow.records.energy_balance.update_peak_kinetic(motion.kinetic);
        self.stop_detection.update(stop, &motion, self.time);
    }

    /// State of the run that is not part of the flow.
    fn run_state(&self) -> RunState {
        RunState { stop_time: self.stop_detection.stop_time, fit_errors: self.fit_errors }
    }
}

impl<const D: usize> Solver for DepthSolver<D> {
    fn time(&self) -> f64 {
        self.time
    }

    fn step_count(&self) -> u64 {
        self.steps
    }

    fn point_count(&self) -> usize {
        self.flow.nodes.len()
    }

    fn limit(&mut self) -> TimeStep {
        let limit = *self.limit.get_or_insert_with(|| self.flow.limit());
        let node = limit.limiting_node.map(|(set, i)| (&self.flow.nodes.sets[set].nodes, i));
        let step = TimeStep {
            dt: limit.dt,
            limit: StepLimit::new("surface wave"),
            point: node.map(|(nodes, i)| nodes.id[i]),
            position: node.map_or([0.0; 3], |(nodes, i)| {
                let x = &nodes.position[i];
                let mut place = spatial(x);
                place[D] = self.flow.bed_below(x).level + 0.5 * nodes.depth[i];
                place
            }),
        };
        let longest = self.options.max_time_step.unwrap_or(f64::INFINITY).min(self.idle_step());
        if longest < step.dt {
            return TimeStep { dt: longest, limit: StepLimit::FIXED_STEP, point: None, position: [0.0; 3] };
        }
        step
    }

    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.limit();
        let dt = limit.limited_to(at_most);
        self.limit = None;
        if !self.is_equilibration_stage() {
            self.flow.advance(dt).map_err(|failure| self.solver_error(failure))?;
        }
        self.time += dt;
        self.steps += 1;
        if !self.is_equilibration_stage() {
            self.update_stop_detection();
            self.update_hazard_rasters();
        }
        Ok(Advance { dt, limit: limit.limit })
    }

    fn begin_stage(&mut self, stage: usize, _start: f64) -> Result<(), SolverError> {
        self.stage = stage;
        self.limit = None;
        self.flow.boundary.walls = stages::plan_boundaries(&self.case, stage);
        let case = Arc::clone(&self.case);
        let removed = |body: u32| case.is_removed(&case.bodies[body as usize].name, stage);
        self.flow.change_nodes_externally(|nodes| nodes.remove_where(|nodes, i| removed(nodes.body[i])));
        // A restored stage continues with the lists of the checkpoint.
        if self.restored_stage.take() != Some(stage) {
            self.flow.nodes.sets.iter_mut().for_each(PhaseSet::clear_lists);
        }
        Ok(())
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        self.limit = None;
        self.flow.change_nodes_externally(|nodes| {
            for reset in &stage.reset {
                nodes.sets.iter_mut().for_each(|set| match reset {
                    Reset::Velocity => set.nodes.velocity.fill([0.0; D]),
                    Reset::Displacement => set.nodes.origin.clone_from(&set.nodes.position),
                    // Nodes have no state of a material law.
                    Reset::State => {}
                });
            }
        });
        Ok(())
    }

    fn steps_between_checks(&self) -> u64 {
        1
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        // A stage that only equilibrates stress ends at once.
        self.case.stages[self.stage].equilibrium?;
        Some(Equilibrium { unbalanced_force: 0.0, kinetic_ratio: 0.0, kinetic: 0.0 })
    }

    fn scalar_outputs(&self) -> Vec<ScalarOutput> {
        scalar_outputs(&self.flow.view(), self.hazard_rasters.as_ref(), &self.run_state())
    }

    fn warnings_at_end(&self) -> Vec<Warning> {
        warnings_at_end(&self.flow.view(), &self.case, self.hazard_rasters.as_ref(), &self.run_state())
    }

    fn frame(&self, wanted: FrameRequest<'_>) -> Frame {
        snapshot(&self.flow.view(), (self.time, self.steps), wanted).into()
    }

    fn gauge(&self, place: &[f64]) -> Option<(f64, [f64; 3])> {
        let x = std::array::from_fn(|c| place.get(c).copied().unwrap_or(0.0));
        let (depth, flux) = depth_and_flux(self.flow.settings.numerics.kernel, &self.flow.nodes.sets, &x);
        Some((depth, spatial(&flux).map(|flux| flux / depth)))
    }

    fn discharge(&self, from: [f64; 2], to: [f64; 2]) -> Option<f64> {
        let [from, to] = [from, to].map(|end| std::array::from_fn(|c| end.get(c).copied().unwrap_or(0.0)));
        Some(discharge(self.flow.settings.numerics.kernel, &self.flow.nodes.sets, &from, &to))
    }

    fn products(&self) -> Vec<Dataset> {
        let Some(maps) = &self.hazard_rasters else { return Vec::new() };
        let along = if self.flow.settings.frame == DepthFrame::BedFitted { "normal" } else { "vertical" };
        let rasters = maps.rasters(&self.flow.view(), along).into_iter();
        rasters.map(|(name, unit, raster)| Dataset::of_raster(PlanRaster { name, unit, raster })).collect()
    }

    fn budget(&self) -> Option<Budget> {
        Some(budget(&self.flow.view()))
    }

    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        save_value(&self.checkpoint_state(), out)
    }

    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        let saved: CheckpointState = restore_value(input)?;
        if saved.format != FORMAT || saved.dimension != D {
            let problem = "was written by another version or for another case";
            return Err(SolverError::Checkpoint(problem.to_owned()));
        }
        check_saved_body_force(saved.has_body_force, self.flow.body_force.acting.is_some())?;
        self.restore_state(saved)
            .ok_or_else(|| SolverError::Checkpoint("its arrays do not fit together or the case".to_owned()))
    }
}
