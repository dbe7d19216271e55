//! Checkpoint of a run: all that the next step depends on.

use serde::{Deserialize, Serialize};

use crate::bed::{Bed, ErosionState};
use crate::boundary::FlowBoundaries;
use crate::boundary::open::FarField;
use crate::boundary::stages::plan_boundaries;
use crate::config::settings::FlowSettings;
use crate::flow::{EnergyBalance, Flow, PhaseSet, PlanBoundaries};
use crate::flow_nodes::FlowNodes;
use crate::inflow::InflowState;
use crate::momentum::effective_gravity::resample_bed;
use crate::output::hazard_rasters::HazardCell;
use crate::phases::depths::remake_lists;
use crate::points::phase_nodes::PlanVector;
use crate::solver::DepthSolver;
use crate::solver::stop_detection::StopDetection;

/// Version of the layout of a checkpoint.
pub(super) const FORMAT: u32 = 15;

/// Saved state of a run.
#[derive(Serialize, Deserialize)]
pub(super) struct CheckpointState {
    /// Number of the checkpoint format.
    pub(super) format: u32,
    /// Number of plan dimensions.
    pub(super) dimension: usize,
    /// Whether a body force of the program acts.
    pub(super) has_body_force: bool,
    /// Number of the stage.
    stage: usize,
    time: f64,
    steps: u64,
    flow_time: f64,
    flow_step: u64,
    next_id: u64,
    outflow: [f64; 2],
    outflow_count: u64,
    eroded_volume: [f64; 2],
    pore_heads: Vec<f64>,
    heads_depth: Vec<f64>,
    heads_time: f64,
    stop_detection: StopDetection,
    energy_balance: EnergyBalance,
    nodes: Vec<Vec<u8>>,
    /// Positions and smoothing lengths of the nodes of each set at which images and lists of neighbours were made; empty without lists.
    listed_nodes: Vec<Vec<f64>>,
    maps: Option<Vec<HazardCell>>,
    inflows: Vec<InflowState>,
    erosion: Option<[Vec<f64>; 2]>,
    far_fields: Vec<FarField>,
    /// Numbers of the nodes that have not entered yet.
    waiting_nodes: Vec<u64>,
}

impl<const D: usize> DepthSolver<D> {
    /// State of the run.
    pub(super) fn checkpoint_state(&self) -> CheckpointState {
        let Flow { clock, bed, boundary, nodes, records, .. } = &self.flow;
        let bytes = |set: &PhaseSet<D>| {
            let mut bytes = Vec::new();
            set.nodes.write(&mut bytes).expect("memory takes all bytes");
            bytes
        };
        CheckpointState {
            format: FORMAT,
            dimension: D,
            has_body_force: self.flow.body_force.acting.is_some(),
            stage: self.stage,
            time: self.time,
            steps: self.steps,
            flow_time: clock.time,
            flow_step: clock.step,
            next_id: nodes.next_id,
            outflow: records.outflow_volume,
            outflow_count: records.removed_nodes,
            eroded_volume: records.eroded_volume,
            pore_heads: nodes.pore_columns.heads.clone(),
            heads_depth: nodes.pore_columns.depth.clone(),
            heads_time: nodes.pore_columns.time,
            stop_detection: self.stop_detection,
            energy_balance: records.energy_balance,
            nodes: nodes.sets.iter().map(bytes).collect(),
            listed_nodes: listed_nodes(&nodes.sets),
            maps: self.hazard_rasters.as_ref().map(|maps| maps.cells().to_vec()),
            inflows: boundary.inflows.iter().map(|inflow| inflow.state.clone()).collect(),
            far_fields: boundary.open_sides.iter().map(|end| end.state.clone()).collect(),
            waiting_nodes: boundary.waiting_nodes.nodes.iter().map(|node| node.0).collect(),
            erosion: bed.erodible().map(|erodible| {
                [erodible.state().in_surface.clone(), erodible.state().pending_depth.clone()]
            }),
        }
    }

    /// Restores a saved state; `None` if its parts are inconsistent.
    pub(super) fn restore_state(&mut self, saved: CheckpointState) -> Option<()> {
        self.limit = None;
        if saved.maps.is_some() != self.hazard_rasters.is_some() || saved.stage >= self.case.stages.len() {
            return None;
        }
        (self.stage, self.restored_stage) = (saved.stage, Some(saved.stage));
        let Flow { clock, settings, bed, boundary, nodes, records, .. } = &mut self.flow;
        boundary.walls = plan_boundaries(&self.case, saved.stage);
        restore_boundary(boundary, saved.inflows, saved.far_fields, &saved.waiting_nodes)?;
        restore_bed(bed, saved.erosion)?;
        if let (Some(maps), Some(cells)) = (&mut self.hazard_rasters, saved.maps) {
            maps.restore(cells)?;
        }
        restore_sets(nodes, &saved.nodes)?;
        restore_lists(settings, &boundary.walls, &mut nodes.sets, &saved.listed_nodes)?;
        resample_bed(bed, &mut nodes.sets);
        restore_pore_columns(nodes, saved.pore_heads, saved.heads_depth, saved.heads_time)?;
        (clock.time, clock.step, nodes.next_id) = (saved.flow_time, saved.flow_step, saved.next_id);
        (records.outflow_volume, records.removed_nodes) = (saved.outflow, saved.outflow_count);
        (records.eroded_volume, records.energy_balance) = (saved.eroded_volume, saved.energy_balance);
        (self.time, self.steps, self.stop_detection) = (saved.time, saved.steps, saved.stop_detection);
        Some(())
    }
}

/// Restores inflows, far fields and waiting nodes of the boundaries; `None` if their numbers do not fit.
fn restore_boundary<const D: usize>(
    boundary: &mut FlowBoundaries<D>,
    inflows: Vec<InflowState>,
    far_fields: Vec<FarField>,
    waiting: &[u64],
) -> Option<()> {
    if inflows.len() != boundary.inflows.len() || far_fields.len() != boundary.open_sides.len() {
        return None;
    }
    boundary.open_sides.iter_mut().zip(far_fields).for_each(|(end, state)| end.state = state);
    boundary.inflows.iter_mut().zip(inflows).for_each(|(inflow, state)| inflow.state = state);
    // The next step sets their positions and velocities before it uses them.
    boundary.waiting_nodes.nodes = waiting.iter().map(|id| (*id, [0.0; D], [0.0; D])).collect();
    Some(())
}

/// Restores the erosion of the bed; `None` if the bed of the case differs in kind.
fn restore_bed<const D: usize>(bed: &mut Bed<D>, erosion: Option<[Vec<f64>; 2]>) -> Option<()> {
    match (bed, erosion) {
        (Bed::Erodible(erodible), Some([in_surface, pending_depth])) => {
            erodible.restore::<D>(ErosionState { in_surface, pending_depth })
        }
        (Bed::Erodible(_), None) | (_, Some(_)) => None,
        _ => Some(()),
    }
}

/// Restores the node sets; `None` if their number does not fit.
fn restore_sets<const D: usize>(nodes: &mut FlowNodes<D>, saved: &[Vec<u8>]) -> Option<()> {
    if saved.len() != nodes.sets.len() {
        return None;
    }
    for (set, bytes) in nodes.sets.iter_mut().zip(saved) {
        set.nodes.read(&mut bytes.as_slice()).ok()?;
        set.clear_lists();
    }
    Some(())
}

/// Positions and smoothing lengths at which the lists of all sets were made; empty where there are none, or where the next step makes new
/// ones because a set has changed.
fn listed_nodes<const D: usize>(sets: &[PhaseSet<D>]) -> Vec<Vec<f64>> {
    if !sets.iter().all(PhaseSet::has_lists) {
        return Vec::new();
    }
    let numbers = |(x, length): &(PlanVector<D>, f64)| x.iter().copied().chain([*length]).collect::<Vec<_>>();
    sets.iter().map(|set| set.listed_nodes().iter().flat_map(numbers).collect()).collect()
}

/// Makes images and lists at the saved positions again; `None` if their sizes do not fit or a position is not finite.
fn restore_lists<const D: usize>(
    settings: &FlowSettings<D>,
    walls: &PlanBoundaries<D>,
    sets: &mut [PhaseSet<D>],
    saved: &[Vec<f64>],
) -> Option<()> {
    if saved.is_empty() || !settings.needs_neighbour_list() {
        return Some(());
    }
    let is_of_set = |(set, numbers): (&PhaseSet<D>, &Vec<f64>)| numbers.len() == (D + 1) * set.len();
    if saved.len() != sets.len() || !sets.iter().zip(saved).all(is_of_set) {
        return None;
    }
    let place = |numbers: &[f64]| (std::array::from_fn(|c| numbers[c]), numbers[D]);
    let listed = saved.iter().map(|numbers| numbers.chunks_exact(D + 1).map(place).collect()).collect();
    remake_lists(settings, walls, sets, listed).ok()
}

/// Restores the pore-pressure columns; `None` if their sizes do not fit.
fn restore_pore_columns<const D: usize>(
    nodes: &mut FlowNodes<D>,
    heads: Vec<f64>,
    depth: Vec<f64>,
    time: f64,
) -> Option<()> {
    let FlowNodes { sets, pore_columns, .. } = nodes;
    let count = if pore_columns.is_empty() { 0 } else { sets[0].len() };
    if heads.len() != count * pore_columns.width || depth.len() != count {
        return None;
    }
    (pore_columns.heads, pore_columns.depth, pore_columns.time) = (heads, depth, time);
    Some(())
}
