//! Flow: its nodes, and one step (sheet: depth-sph §3.4).

mod critical_step;

use colluvium_points::{CellList, ScratchBuffers, SearchError};
use rayon::prelude::*;
use thiserror::Error;

use crate::bed::Bed;
use crate::config::choices::{Phases, PressureForceForm, ThicknessEquation};
use crate::config::settings::FlowSettings;
use crate::inflow::{Inflow, WaitingNodes};
use crate::phases::phase::{TASK, copy_with_images};
use crate::phases::phase_nodes::{NewNode, PhaseNodes, norm};

pub use crate::boundary::image_nodes::{ImageNode, PlanBoundaries};
pub use crate::boundary::open::{
    ArrivalHistory, BoundaryState, FarField, Inlet, InteriorFit, OpenBoundary, Opening, StripState,
};
pub use crate::flow::critical_step::{LimitingNode, PhaseTotals};
pub use crate::momentum::pair_forces::{PhaseRole, corrected};
pub use crate::output::energy_balance::{EnergyBalance, EnergyBalanceSummary, FlowEnergies};
pub use crate::phases::phase::PhaseSet;
pub use crate::pore_pressure::pore_pressure_columns::{MOST_CELLS, PorePressureColumns};

/// Depths below this share of the largest initial one, and below a millimetre, have no partner phase.
const MIN_DEPTH_RATIO: f64 = 1e-3;
/// Ratio of the speed of a node to the speed that gravity can give it at which the run ends.
const MAX_SPEED_RATIO: f64 = 3.0;
/// Ratio of the depth of an inflow across a line to that at its largest discharge, or at the start, at which the run ends.
pub(crate) const DEEPEST: f64 = 100.0;
/// Steps between two sorts by cell.
const STEPS_PER_SORT: u64 = 20;

/// Failure of a node that ends the run.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("node {node} at {position:?} m: {reason}")]
pub struct FlowFailure {
    /// Number of the node.
    pub node: u64,
    /// Position (m).
    pub position: Vec<f64>,
    /// Reason.
    pub reason: String,
}

/// Time at which the bed below the nodes is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BedSampling {
    /// The bed has not been sampled since they have moved.
    Now,
    /// The bed was sampled by the drift that moved them.
    Before,
}

/// Treatment of nodes that leave the bed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutsideNodes {
    /// Nodes are removed and counted.
    #[default]
    Remove,
    /// Nodes end the run.
    Fail,
}

/// Flow over a bed.
pub struct Flow<const D: usize> {
    /// Settings that are constant.
    pub settings: FlowSettings<D>,
    /// The bed.
    pub bed: Bed<D>,
    /// Walls and periods.
    pub ends: PlanBoundaries<D>,
    /// Sets of nodes: one, or grains and fluid, or the lower and the upper layer.
    pub sets: Vec<PhaseSet<D>>,
    /// Pore pressure on the nodes of the first set.
    pub pore_columns: PorePressureColumns,
    /// Treatment of nodes that leave the bed.
    pub outside: OutsideNodes,
    /// Time (s).
    pub time: f64,
    /// Number of completed steps.
    pub step: u64,
    /// Number of the next node.
    pub next_id: u64,
    /// Volume of each set that has left (m³; m² in one dimension).
    pub outflow_volume: [f64; 2],
    /// Number of nodes that have left.
    pub removed_nodes: u64,
    /// Volume of each set that has been eroded from the bed.
    pub entrained: [f64; 2],
    /// Depth below which a phase has no partner (m).
    pub min_partner_depth: f64,
    /// Highest initial level, of bed plus depth (m).
    pub max_initial_level: f64,
    /// Largest initial speed (m/s).
    pub fastest_start: f64,
    /// Lines with inflow.
    pub inflows: Vec<Inflow<D>>,
    /// Sides through which waves leave, or with inflow.
    pub open_boundaries: Vec<OpenBoundary<D>>,
    /// Nodes behind the lines of inflow, which have not entered yet.
    pub waiting_nodes: WaitingNodes<D>,
    /// Energy balance.
    pub energy_balance: EnergyBalance,
    /// Factors on resistance and on pressure, for tests that break them.
    #[cfg(test)]
    pub test_factors: [f64; 2],
    cells: CellList<D>,
    pub(crate) scratch: ScratchBuffers,
}

impl<const D: usize> Flow<D> {
    /// Creates a flow of nodes for each set, with their initial heights.
    ///
    /// # Errors
    /// When a node lies beyond the bed, positions are not finite, or there are neither one nor two dimensions in plan.
    pub fn new(
        settings: FlowSettings<D>,
        bed: Bed<D>,
        ends: PlanBoundaries<D>,
        nodes: &[Vec<NewNode<D>>],
    ) -> Result<Self, FlowFailure> {
        let mut sets: Vec<PhaseSet<D>> = Vec::new();
        let mut next_id = 0;
        for nodes in nodes {
            let mut set = PhaseSet::default();
            for node in nodes {
                set.nodes.push(next_id, node);
                next_id += 1;
            }
            sets.push(set);
        }
        let first = sets.first().map_or(0, PhaseSet::len);
        let heads = settings
            .column
            .as_ref()
            .map_or_else(PorePressureColumns::default, |pore| PorePressureColumns::new(pore.cells, first));
        let mut flow = Self {
            settings,
            bed,
            ends,
            sets,
            pore_columns: heads,
            outside: OutsideNodes::Fail,
            time: 0.0,
            step: 0,
            next_id,
            outflow_volume: [0.0; 2],
            removed_nodes: 0,
            entrained: [0.0; 2],
            min_partner_depth: MIN_DEPTH_RATIO,
            max_initial_level: f64::NEG_INFINITY,
            fastest_start: 0.0,
            inflows: Vec::new(),
            open_boundaries: Vec::new(),
            waiting_nodes: WaitingNodes::default(),
            energy_balance: EnergyBalance::default(),
            #[cfg(test)]
            test_factors: [1.0; 2],
            cells: CellList::new(),
            scratch: ScratchBuffers::default(),
        };
        flow.initialise_thickness()?;
        flow.outside = OutsideNodes::Remove;
        Ok(flow)
    }

    /// Initial heights and smoothing lengths of all nodes (sheet: depth-sph §3.2).
    pub(crate) fn initialise_thickness(&mut self) -> Result<(), FlowFailure> {
        let chosen = self.settings.numerics.continuity;
        // Heights that are integrated begin with their sums.
        if chosen.is_rate() {
            self.settings.numerics.continuity = ThicknessEquation::Summation;
        }
        self.find_heights()?;
        for _ in 0..2 {
            self.repeat_thickness_sum();
        }
        self.settings.numerics.continuity = chosen;
        self.find_depths();
        self.sample_bed(BedSampling::Now);
        let depths = || self.sets.iter().flat_map(|set| set.nodes.depth.iter().zip(&set.bed));
        let deepest = depths().map(|(depth, _)| *depth).fold(0.0, f64::max);
        self.max_initial_level =
            depths().map(|(depth, bed)| depth + bed.level).fold(f64::NEG_INFINITY, f64::max);
        self.min_partner_depth = MIN_DEPTH_RATIO * deepest.min(1.0);
        let speeds = self.sets.iter().flat_map(|set| &set.nodes.velocity).map(norm);
        self.fastest_start = speeds.fold(0.0, f64::max);
        self.find_depths();
        if !self.pore_columns.is_empty() {
            let Self { settings, pore_columns: heads, sets, time, .. } = self;
            heads.advance(settings, &sets[0], *time);
        }
        Ok(())
    }

    /// Phase of a set.
    pub fn role(&self, set: usize) -> PhaseRole {
        match (self.settings.phases, set) {
            (Phases::One, _) => PhaseRole::Single,
            (Phases::Two, 0) => PhaseRole::Solid,
            (Phases::Two, _) => PhaseRole::Fluid,
            (Phases::Layers, 0) => PhaseRole::Lower,
            (Phases::Layers, _) => PhaseRole::Upper,
        }
    }

    /// Advances the flow by one step of `dt` (s).
    ///
    /// # Errors
    /// The first node that has failed.
    pub fn advance(&mut self, dt: f64) -> Result<(), FlowFailure> {
        self.start_energy_balance();
        if !(self.inflows.is_empty() && self.open_boundaries.is_empty()) {
            self.with_inflow(|flow| {
                flow.update_inflow_nodes()?;
                flow.update_open_boundaries(dt);
                flow.relax_absorbing_layers(dt);
                Ok(())
            })?;
        }
        self.reset_inflow_columns();
        if self.step.is_multiple_of(STEPS_PER_SORT) {
            self.sort()?;
        }
        self.integrate(dt)?;
        self.erode_bed(dt);
        self.time += dt;
        self.step += 1;
        self.check()?;
        self.remove_outside()
    }

    /// Sorts nodes so that neighbours are close in memory.
    fn sort(&mut self) -> Result<(), FlowFailure> {
        let support = self.settings.numerics.kernel.support();
        let Self { sets, pore_columns: heads, cells, scratch: spare, .. } = self;
        for (number, set) in sets.iter_mut().enumerate() {
            if set.nodes.is_empty() {
                continue;
            }
            let mean = set.nodes.length.iter().sum::<f64>() / set.len() as f64;
            set.sort(support * mean, cells, spare).map_err(|error| unlocated_node(set, &error))?;
            if number == 0 {
                heads.reorder(cells.order());
            }
        }
        Ok(())
    }

    /// Steps 1 to 4: all accelerations of the nodes, at their positions and velocities. Pore pressure is advanced to
    /// `time` (s) where that is given.
    pub(crate) fn evaluate(
        &mut self,
        dt: f64,
        time: Option<f64>,
        bed: BedSampling,
    ) -> Result<(), FlowFailure> {
        self.find_heights()?;
        self.find_depths();
        self.sample_bed(bed);
        let Self { settings, pore_columns: heads, sets, .. } = self;
        if let (Some(time), false) = (time, heads.is_empty()) {
            heads.advance(settings, &sets[0], time);
        }
        self.find_pressures();
        self.accelerate(dt);
        Ok(())
    }

    /// Step 1 and the heights of step 2.
    fn find_heights(&mut self) -> Result<(), FlowFailure> {
        self.find_neighbours()?;
        self.repeat_thickness_sum();
        Ok(())
    }

    /// Step 1: neighbours and images at the positions of the nodes.
    pub(crate) fn find_neighbours(&mut self) -> Result<(), FlowFailure> {
        self.check_numbers()?;
        let support = self.settings.numerics.kernel.support();
        let lists = self.settings.asks_for_neighbours();
        if lists && self.sets.iter().all(|set| set.is_listed(support)) {
            self.sets.iter_mut().for_each(PhaseSet::place_images);
        } else {
            self.sets.iter_mut().for_each(|set| set.make_images(&self.ends, support));
            if lists {
                self.list_neighbours(support)?;
            }
        }
        let search = self.settings.numerics.search;
        for set in &mut self.sets {
            set.pack(support, search).map_err(|error| unlocated_node(set, &error))?;
        }
        Ok(())
    }

    fn list_neighbours(&mut self, support: f64) -> Result<(), FlowFailure> {
        for set in &mut self.sets {
            set.list_same_phase(support).map_err(|error| unlocated_node(set, &error))?;
        }
        if let [first, second] = &mut self.sets[..] {
            first
                .list_other_phase(&second.neighbour_data, support)
                .map_err(|error| unlocated_node(first, &error))?;
            second
                .list_other_phase(&first.neighbour_data, support)
                .map_err(|error| unlocated_node(second, &error))?;
        }
        Ok(())
    }

    /// Repeats the sum of heights.
    fn repeat_thickness_sum(&mut self) {
        let numerics = &self.settings.numerics;
        for set in &mut self.sets {
            if numerics.continuity.is_rate() {
                set.update_smoothing_lengths(numerics);
            } else {
                set.sum_thickness(numerics);
            }
            set.update_image_thickness();
        }
    }

    /// Computes heights of the other phase, total depths and porosities.
    fn find_depths(&mut self) {
        let Self { sets, settings, min_partner_depth: thin, .. } = self;
        let (thin, phases) = (*thin, settings.phases);
        let kernel = settings.numerics.kernel;
        let [first, second] = &mut sets[..] else {
            let set = &mut sets[0];
            set.nodes.depth.clone_from(&set.nodes.partial_thickness);
            copy_with_images(&set.images, &set.nodes.depth, &mut set.neighbour_data.depth);
            return;
        };
        first.sum_partner_thickness(kernel, &second.cell_sorted);
        second.sum_partner_thickness(kernel, &first.cell_sorted);
        [&mut *first, &mut *second]
            .into_iter()
            .for_each(|set| set.cell_sorted.update_thickness(&set.neighbour_data));
        for (role, set) in [first, second].into_iter().enumerate() {
            set.scratch_scalars.clear();
            for i in 0..set.nodes.len() {
                let own = set.nodes.partial_thickness[i];
                let mut partner = set.neighbour_data.partner[i];
                if own < thin || partner < thin {
                    partner = 0.0;
                }
                let depth = own + partner;
                set.nodes.depth[i] = depth;
                let fluid = if role == 0 { partner } else { own };
                set.scratch_scalars.push(if phases == Phases::Two { fluid / depth } else { 0.0 });
            }
            copy_with_images(&set.images, &set.scratch_scalars, &mut set.neighbour_data.porosity);
            copy_with_images(&set.images, &set.nodes.depth, &mut set.neighbour_data.depth);
        }
    }

    /// Computes `P/(g_* h²)` of every node, and excess pressures.
    fn find_pressures(&mut self) {
        self.find_earth_pressure();
        match self.settings.phases {
            Phases::Two => self.find_phase_pressures(),
            Phases::One | Phases::Layers => self.find_single_pressures(),
        }
    }

    /// Computes the accelerations of all nodes.
    fn accelerate(&mut self, dt: f64) {
        let roles = [self.role(0), self.role(1)];
        let Self { sets, settings, .. } = self;
        let settings = &*settings;
        let densities = &settings.material.densities;
        let automatic =
            settings.phases == Phases::Two && settings.numerics.momentum == PressureForceForm::Automatic;
        let weak_at = |porosity: f64| settings.drag.relaxation(porosity, 0.0, densities) * dt < 1.0;
        let [first, second] = &mut sets[..] else {
            sets[0].accelerate(settings, roles[0], |_| false, None);
            return;
        };
        let layers = settings.phases == Phases::Layers;
        for role in 0..2 {
            let (set, other) = if role == 0 { (&mut *first, &*second) } else { (&mut *second, &*first) };
            let porosity = set.neighbour_data.porosity.clone();
            let weak = |i: usize| automatic && weak_at(porosity[i]);
            set.accelerate(settings, roles[role], weak, layers.then_some(&other.neighbour_data));
        }
    }

    fn check(&self) -> Result<(), FlowFailure> {
        for set in &self.sets {
            let failed = |i: usize| self.failure_of(set, i).is_some().then_some(i);
            let found = (0..set.nodes.len()).into_par_iter().with_min_len(TASK).find_map_first(failed);
            if let Some(i) = found {
                return Err(failure(set, i, self.failure_of(set, i).unwrap_or_default()));
            }
        }
        Ok(())
    }

    /// Checks that positions, velocities and smoothing lengths are finite before lists are made; the error is the first such node.
    fn check_numbers(&self) -> Result<(), FlowFailure> {
        for set in &self.sets {
            let PhaseNodes { position, velocity, length, .. } = &set.nodes;
            let failed = |i: usize| {
                let all = position[i].iter().chain(&velocity[i]).chain([&length[i]]);
                (!all.fold(0.0, |sum, x| sum + 0.0 * x).is_finite()).then_some(i)
            };
            let Some(i) = (0..set.len()).into_par_iter().with_min_len(TASK).find_map_first(failed) else {
                continue;
            };
            let reason = if position[i].iter().all(|x| x.is_finite()) {
                format!(
                    "its velocity, {:?} m/s, or its smoothing length, {} m, is not finite",
                    velocity[i], length[i]
                )
            } else {
                "its position is not finite".to_owned()
            };
            return Err(failure(set, i, reason));
        }
        Ok(())
    }

    /// Failure of a node (sheet: depth-sph §2.9, item 8 as amended): not finite, or faster than three times the speed gravity can give.
    fn failure_of(&self, set: &PhaseSet<D>, i: usize) -> Option<String> {
        let nodes = &set.nodes;
        let speed = norm(&nodes.velocity[i]);
        let place = nodes.position[i];
        if !(speed.is_finite()
            && place.iter().all(|x| x.is_finite())
            && nodes.partial_thickness[i].is_finite())
        {
            return Some(format!(
                "its position, its velocity, {:?} m/s, or its height, {} m, is not finite",
                nodes.velocity[i], nodes.partial_thickness[i]
            ));
        }
        if nodes.partial_thickness[i] < 0.0 {
            return Some(format!("its height, {} m, is negative", nodes.partial_thickness[i]));
        }
        let bed = &set.bed[i];
        let speed = bed.speed(&nodes.velocity[i]);
        // Within a step the level changes by no more than the slope over a cell.
        let cell = self.bed.cell().unwrap_or(0.0) * bed.steepness().sqrt();
        let fall = (self.max_initial_level - bed.level).max(0.0) + nodes.depth[i] + cell;
        let push = norm(&self.settings.plan_gravity);
        // Along a tilted frame the bed does not fall: gravity does its work along it.
        let run = (0..D).map(|c| (place[c] - nodes.origin[i][c]).abs()).fold(0.0, f64::max);
        let given = (2.0 * (self.settings.gravity * fall + push * run)).sqrt();
        (speed > MAX_SPEED_RATIO * (given + self.fastest_start)).then(|| {
            format!(
                "its speed along the bed, {speed:.3e} m/s, is more than {MAX_SPEED_RATIO} times the speed \
                 that it can gain by gravity, {given:.3e} m/s: reduce `courant` or `spacing`, or increase \
                 `terrain_smoothing`"
            )
        })
    }
}

/// Error of a node that ends the run.
pub(crate) fn failure<const D: usize>(set: &PhaseSet<D>, i: usize, reason: String) -> FlowFailure {
    FlowFailure { node: set.nodes.id[i], position: set.nodes.position[i].to_vec(), reason }
}

/// Error of the node that a neighbour search reports.
fn unlocated_node<const D: usize>(set: &PhaseSet<D>, error: &SearchError) -> FlowFailure {
    match error {
        SearchError::NotFinite(number) if *number < set.nodes.len() => {
            failure(set, *number, "its position is not finite".to_owned())
        }
        SearchError::TooSpread(_, number) if *number < set.nodes.len() => {
            failure(set, *number, error.to_string())
        }
        _ => FlowFailure { node: 0, position: Vec::new(), reason: error.to_string() },
    }
}

impl<const D: usize> PhaseSet<D> {
    /// Index of the node of entry `j` of the neighbour data.
    #[inline]
    pub fn number(&self, j: usize) -> usize {
        match j.checked_sub(self.nodes.len()) {
            Some(image) => self.images[image].source as usize,
            None => j,
        }
    }
}
