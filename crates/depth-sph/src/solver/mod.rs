//! Solver of a case: a flow with the outputs and stages of a run.

pub(crate) mod report;

use std::io::{Read, Write};
use std::sync::Arc;

use colluvium_case::description::{Domain, Reset, Stage};
use colluvium_case::measure::ScalarOutput;
use colluvium_case::solver::{restore_value, save_value};
use colluvium_case::{
    Advance, Budget, Case, Dataset, Equilibrium, Frame, FrameRequest, Solver, SolverError, StepLimit,
    TimeStep, spatial,
};
use serde::{Deserialize, Serialize};

use crate::bed::{Bed, ErosionState};
use crate::config::DepthOptions;
use crate::flow::{EnergyBalance, FarField, Flow, FlowFailure, LimitingNode};
use crate::inflow::InflowState;
use crate::output::hazard_rasters::{HazardCell, HazardRasters};
use crate::phases::phase_nodes::{PhaseNodes, PlanVector, norm};
use crate::setup::stages;

/// Version of the layout of a checkpoint.
const FORMAT: u32 = 11;

/// Steps for each check of the criterion, in a stage without motion.
const CHECKS: f64 = 4.0;

/// Detection of the time at which the flow comes to rest (sheet: depth-sph §0, stopping).
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct StopDetection {
    /// Largest kinetic energy so far (J).
    peak: f64,
    /// Time since which all conditions have held (s); NaN while they do not.
    since: f64,
    /// Time at which the flow had stopped (s); NaN before.
    stopped: f64,
}

impl Default for StopDetection {
    fn default() -> Self {
        Self { peak: 0.0, since: f64::NAN, stopped: f64::NAN }
    }
}

/// Depth-integrated SPH over a profile (`D` = 1) or over terrain (`D` = 2).
pub struct DepthSolver<const D: usize> {
    case: Arc<Case>,
    options: DepthOptions,
    flow: Flow<D>,
    stage: usize,
    time: f64,
    steps: u64,
    rest: StopDetection,
    hazard_rasters: Option<HazardRasters>,
    /// Largest distance of the bed from the heights of its raster, and the root mean square of all (m).
    departure: Option<[f64; 2]>,
    /// Limit of the next step, once it has been computed.
    limit: Option<LimitingNode>,
}

#[derive(Serialize, Deserialize)]
struct CheckpointState {
    format: u32,
    dimension: usize,
    time: f64,
    steps: u64,
    flow_time: f64,
    flow_step: u64,
    next_id: u64,
    left: [f64; 2],
    gone: u64,
    entrained: [f64; 2],
    pore_heads: Vec<f64>,
    heads_depth: Vec<f64>,
    heads_time: f64,
    rest: StopDetection,
    energy_balance: EnergyBalance,
    nodes: Vec<Vec<u8>>,
    maps: Option<Vec<HazardCell>>,
    inflows: Vec<InflowState>,
    erosion: Option<[Vec<f64>; 2]>,
    far_fields: Vec<FarField>,
    /// Numbers of the nodes that have not entered yet.
    held: Vec<u64>,
}

impl<const D: usize> DepthSolver<D> {
    pub(crate) fn new(
        case: Arc<Case>,
        options: DepthOptions,
        flow: Flow<D>,
        maps: Option<HazardRasters>,
        departure: Option<[f64; 2]>,
    ) -> Self {
        let mut solver = Self {
            case,
            options,
            flow,
            stage: 0,
            time: 0.0,
            steps: 0,
            rest: StopDetection::default(),
            hazard_rasters: maps,
            departure,
            limit: None,
        };
        solver.update_hazard_rasters();
        solver
    }

    /// Updates the rasters with the current flow.
    fn update_hazard_rasters(&mut self) {
        if let Some(maps) = &mut self.hazard_rasters {
            maps.update(&self.flow);
        }
    }

    /// Flow of the solver.
    pub fn flow(&self) -> &Flow<D> {
        &self.flow
    }

    /// Volume of the nodes of each body within the domain (m³), without those of absorbing layers beyond it.
    pub(crate) fn volumes(&self) -> Vec<f64> {
        let Domain { min, max, .. } = &self.case.domain;
        let inside =
            |place: &[f64; D]| (0..D).all(|axis| place[axis] >= min[axis] && place[axis] <= max[axis]);
        let mut volumes = vec![0.0; self.case.bodies.len()];
        for PhaseNodes { body, volume, position, .. } in self.flow.sets.iter().map(|set| &set.nodes) {
            for node in (0..body.len()).filter(|node| inside(&position[*node])) {
                volumes[body[node] as usize] += volume[node];
            }
        }
        volumes
    }

    fn is_passed_over(&self) -> bool {
        stages::is_passed_over(&self.case.stages[self.stage])
    }

    /// Bound on the step (s) without motion: an idle stage ends when its criterion has been checked as often as required,
    /// and where all of the flow has left, the run goes on to its end.
    fn idle_step(&self) -> f64 {
        let stage = &self.case.stages[self.stage];
        if let Some(criterion) = stage.equilibrium {
            return stage.duration / (CHECKS * f64::from(criterion.hold.max(1)));
        }
        if self.flow.removed_nodes > 0 && self.points() == 0 { self.case.end_time() } else { f64::INFINITY }
    }

    fn failed(&self, failure: FlowFailure) -> SolverError {
        let FlowFailure { node, position, reason } = failure;
        let mut place: [f64; 3] = std::array::from_fn(|c| position.get(c).copied().unwrap_or(0.0));
        if let Ok(plan) = <PlanVector<D>>::try_from(&position[..]) {
            place[D] = self.flow.bed_below(&plan).level;
        }
        SolverError::Point { step: self.steps, time: self.time, point: node, position: place, reason }
    }

    /// Updates the detection of rest.
    fn update_stop_detection(&mut self) {
        let stop = &self.options.stop;
        let (mut kinetic, mut slow, mut whole) = (0.0, 0.0, 0.0);
        for (number, set) in self.flow.sets.iter().enumerate() {
            let density = self.flow.density(number);
            for (velocity, volume) in set.nodes.velocity.iter().zip(&set.nodes.volume) {
                let speed = norm(velocity);
                kinetic += 0.5 * density * volume * speed * speed;
                if number == 0 {
                    whole += volume;
                    slow += if speed < stop.speed { *volume } else { 0.0 };
                }
            }
        }
        self.flow.update_peak_kinetic(kinetic);
        let rest = &mut self.rest;
        rest.peak = rest.peak.max(kinetic);
        let holds =
            rest.peak > 0.0 && kinetic <= stop.kinetic_ratio * rest.peak && slow >= stop.share * whole;
        if !holds {
            (rest.since, rest.stopped) = (f64::NAN, f64::NAN);
        } else if rest.since.is_nan() {
            rest.since = self.time;
        }
        if holds && rest.stopped.is_nan() && self.time - rest.since >= stop.hold {
            rest.stopped = rest.since;
        }
    }

    fn checkpoint_state(&self) -> CheckpointState {
        let flow = &self.flow;
        let bytes = |set: &crate::flow::PhaseSet<D>| {
            let mut bytes = Vec::new();
            set.nodes.write(&mut bytes).expect("memory takes all bytes");
            bytes
        };
        CheckpointState {
            format: FORMAT,
            dimension: D,
            time: self.time,
            steps: self.steps,
            flow_time: flow.time,
            flow_step: flow.step,
            next_id: flow.next_id,
            left: flow.outflow_volume,
            gone: flow.removed_nodes,
            entrained: flow.entrained,
            pore_heads: flow.pore_columns.heads.clone(),
            heads_depth: flow.pore_columns.depth.clone(),
            heads_time: flow.pore_columns.time,
            rest: self.rest,
            energy_balance: flow.energy_balance,
            nodes: flow.sets.iter().map(bytes).collect(),
            maps: self.hazard_rasters.as_ref().map(|maps| maps.cells().to_vec()),
            inflows: flow.inflows.iter().map(|inflow| inflow.state.clone()).collect(),
            far_fields: flow.open_boundaries.iter().map(|end| end.state.clone()).collect(),
            held: flow.waiting_nodes.nodes.iter().map(|node| node.0).collect(),
            erosion: flow
                .erodible_bed()
                .map(|worn| [worn.state().in_surface.clone(), worn.state().pending.clone()]),
        }
    }

    /// Restores a saved state; `None` where its parts are inconsistent.
    fn restore_state(&mut self, saved: CheckpointState) -> Option<()> {
        self.limit = None;
        let flow = &mut self.flow;
        if saved.nodes.len() != flow.sets.len() || saved.maps.is_some() != self.hazard_rasters.is_some() {
            return None;
        }
        if saved.inflows.len() != flow.inflows.len() {
            return None;
        }
        if saved.far_fields.len() != flow.open_boundaries.len() {
            return None;
        }
        flow.open_boundaries.iter_mut().zip(saved.far_fields).for_each(|(end, state)| end.state = state);
        for (inflow, state) in flow.inflows.iter_mut().zip(saved.inflows) {
            inflow.state = state;
        }
        match (&mut flow.bed, saved.erosion) {
            (Bed::Erodible(worn), Some([shown, pending])) => {
                worn.restore::<D>(ErosionState { in_surface: shown, pending })?;
            }
            (Bed::Erodible(_), None) | (_, Some(_)) => return None,
            _ => {}
        }
        if let (Some(maps), Some(cells)) = (&mut self.hazard_rasters, saved.maps) {
            maps.restore(cells)?;
        }
        for (set, bytes) in flow.sets.iter_mut().zip(&saved.nodes) {
            set.nodes.read(&mut bytes.as_slice()).ok()?;
            set.clear_lists();
        }
        flow.resample_bed();
        // The next step sets their positions and velocities before it uses them.
        flow.waiting_nodes.nodes = saved.held.iter().map(|id| (*id, [0.0; D], [0.0; D])).collect();
        let count = if flow.pore_columns.is_empty() { 0 } else { flow.sets[0].len() };
        if saved.pore_heads.len() != count * flow.pore_columns.width || saved.heads_depth.len() != count {
            return None;
        }
        (flow.pore_columns.heads, flow.pore_columns.depth) = (saved.pore_heads, saved.heads_depth);
        flow.pore_columns.time = saved.heads_time;
        (flow.time, flow.step, flow.next_id) = (saved.flow_time, saved.flow_step, saved.next_id);
        (flow.outflow_volume, flow.removed_nodes, flow.entrained) = (saved.left, saved.gone, saved.entrained);
        flow.energy_balance = saved.energy_balance;
        (self.time, self.steps, self.rest) = (saved.time, saved.steps, saved.rest);
        Some(())
    }
}

impl<const D: usize> Solver for DepthSolver<D> {
    fn time(&self) -> f64 {
        self.time
    }

    fn step_count(&self) -> u64 {
        self.steps
    }

    fn points(&self) -> usize {
        self.flow.sets.iter().map(crate::flow::PhaseSet::len).sum()
    }

    fn limit(&mut self) -> TimeStep {
        let limit = *self.limit.get_or_insert_with(|| self.flow.limit());
        let node = limit.node.map(|(set, i)| (&self.flow.sets[set].nodes, i));
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
            return TimeStep { dt: longest, limit: StepLimit::FIXED, point: None, position: [0.0; 3] };
        }
        step
    }

    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.limit();
        let dt = limit.limited_to(at_most);
        self.limit = None;
        if !self.is_passed_over() {
            self.flow.advance(dt).map_err(|failure| self.failed(failure))?;
        }
        self.time += dt;
        self.steps += 1;
        if !self.is_passed_over() {
            self.update_stop_detection();
            self.update_hazard_rasters();
        }
        Ok(Advance { dt, limit: limit.limit })
    }

    fn begin_stage(&mut self, stage: usize, _start: f64) -> Result<(), SolverError> {
        self.stage = stage;
        self.limit = None;
        self.flow.ends = stages::plan_boundaries(&self.case, stage);
        let case = Arc::clone(&self.case);
        let gone = |body: u32| case.is_removed(&case.bodies[body as usize].name, stage);
        self.flow.with_external_change(|flow| flow.remove_where(|nodes, i| gone(nodes.body[i])));
        self.flow.sets.iter_mut().for_each(crate::flow::PhaseSet::clear_lists);
        Ok(())
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        self.limit = None;
        self.flow.with_external_change(|flow| {
            for reset in &stage.reset {
                flow.sets.iter_mut().for_each(|set| match reset {
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
        self.collect_scalar_outputs()
    }

    fn warnings_at_end(&self) -> Vec<String> {
        self.warnings_at_end()
    }

    fn frame(&self, _: FrameRequest) -> Frame {
        self.collect_snapshot().into()
    }

    fn gauge(&self, place: &[f64]) -> Option<(f64, [f64; 3])> {
        let (depth, flux) =
            self.flow.depth_and_flux(&std::array::from_fn(|c| place.get(c).copied().unwrap_or(0.0)));
        Some((depth, spatial(&flux).map(|flux| flux / depth)))
    }

    fn discharge(&self, from: [f64; 2], to: [f64; 2]) -> Option<f64> {
        let [from, to] = [from, to].map(|end| std::array::from_fn(|c| end.get(c).copied().unwrap_or(0.0)));
        Some(self.flow.discharge(&from, &to))
    }

    fn products(&self) -> Vec<Dataset> {
        self.collect_rasters().into_iter().map(Dataset::of_raster).collect()
    }

    fn budget(&self) -> Option<Budget> {
        Some(self.collect_budget())
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
        self.restore_state(saved)
            .ok_or_else(|| SolverError::Checkpoint("its arrays do not fit together or the case".to_owned()))
    }
}
