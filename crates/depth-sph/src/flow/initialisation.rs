//! Initial state of a flow: heights, depths and bed below its nodes (sheet: depth-sph §3.2).

use crate::bed::Bed;
use crate::boundary::body_force::ProgramForce;
use crate::boundary::inflow_nodes::{add_first_rows, count_nodes_behind, initial_state_at_inflow};
use crate::boundary::open::pore_columns::initialise_far_field_columns;
use crate::boundary::{FlowBoundaries, OutsideNodes};
use crate::clock::Clock;
use crate::config::choices::ThicknessEquation;
use crate::config::settings::FlowSettings;
use crate::energy_balance::FlowRecords;
use crate::flow::Flow;
use crate::flow::enter_and_leave::change_nodes_externally;
use crate::flow_nodes::FlowNodes;
use crate::inflow::Inflow;
use crate::momentum::effective_gravity::{BedSampling, sample_bed};
use crate::phases::depths::{find_depths, find_heights, repeat_thickness_sum};
use crate::phases::failure::FlowFailure;
use crate::phases::limits::FlowLimits;
use crate::points::image_nodes::PlanBoundaries;
use crate::points::phase_nodes::NewNode;
use crate::pore_pressure::pore_pressure_columns::set_pore_pressures;
use crate::pore_pressure::pressure_transfer::TransferredPressure;

impl<const D: usize> Flow<D> {
    /// Flow of the given nodes, one list per node set, with their initial heights.
    ///
    /// # Errors
    /// When a node lies beyond the bed, positions are not finite, or there are neither one nor two dimensions in plan.
    pub fn new(
        settings: FlowSettings<D>,
        bed: Bed<D>,
        walls: PlanBoundaries<D>,
        nodes: &[Vec<NewNode<D>>],
    ) -> Result<Self, FlowFailure> {
        let nodes = FlowNodes::new(&settings, nodes);
        let mut flow = Self {
            clock: Clock::default(),
            settings,
            bed,
            boundary: FlowBoundaries { outside: OutsideNodes::Fail, ..FlowBoundaries::from_walls(walls) },
            nodes,
            limits: FlowLimits::default(),
            records: FlowRecords::default(),
            body_force: ProgramForce::default(),
        };
        flow.initialise_thickness()?;
        flow.boundary.outside = OutsideNodes::Remove;
        Ok(flow)
    }

    /// Computes the initial heights and smoothing lengths of all nodes.
    fn initialise_thickness(&mut self) -> Result<(), FlowFailure> {
        let Self { clock, settings, bed, boundary, nodes, limits, .. } = self;
        let FlowNodes { sets, pore_columns, .. } = nodes;
        let chosen = settings.numerics.continuity;
        // Heights that are integrated begin with their sums.
        if chosen.is_rate() {
            settings.numerics.continuity = ThicknessEquation::Summation;
        }
        find_heights(settings, &boundary.walls, sets)?;
        for _ in 0..2 {
            repeat_thickness_sum(&settings.numerics, sets);
        }
        settings.numerics.continuity = chosen;
        find_depths(settings, limits, sets);
        sample_bed(settings, bed, sets, BedSampling::Required);
        *limits = FlowLimits::for_sets(sets);
        find_depths(settings, limits, sets);
        if !pore_columns.is_empty() {
            pore_columns.advance(settings, &sets[0], clock.time);
        }
        Ok(())
    }

    /// Recomputes the initial heights after nodes have been added, and starts the pore-pressure columns with them.
    pub(super) fn reinitialise_thickness(&mut self) -> Result<(), FlowFailure> {
        for set in &mut self.nodes.sets {
            set.nodes.length.clone_from(&set.nodes.first_length);
            set.clear_lists();
        }
        self.nodes.pore_columns.depth.fill(f64::NAN);
        let FlowLimits { max_initial_level, max_initial_speed, .. } = self.limits;
        self.initialise_thickness()?;
        self.limits.include(max_initial_level, max_initial_speed);
        Ok(())
    }

    /// Mean initial depth (m) and speed away from the line (m/s) of the flow next to an inflow line; `None` if it is dry there.
    pub fn initial_state_at_inflow(&self, inflow: &Inflow<D>) -> Option<(f64, f64)> {
        initial_state_at_inflow(&self.nodes.sets, inflow)
    }

    /// Number of nodes that lie where the rows of an inflow line are to be placed.
    pub fn count_nodes_behind(&self, inflow: &Inflow<D>) -> usize {
        count_nodes_behind(&self.nodes.sets, inflow)
    }

    /// Adds the first rows behind inflow lines that have flow next to them, before the first step. `initial` is the result of
    /// [`Flow::initial_state_at_inflow`] for each line.
    ///
    /// # Errors
    /// Those of [`Flow::new`].
    pub fn initialise_inflows(&mut self, initial: &[Option<(f64, f64)>]) -> Result<(), FlowFailure> {
        let Self { clock, settings, boundary, nodes, .. } = self;
        add_first_rows(settings, clock.time, boundary, nodes, initial)?;
        self.reinitialise_thickness()
    }

    /// Sets the pore pressure in the columns of the first node set, before the first step. `transferred` has the number of each node and
    /// its excess over the hydrostatic pressure. Returns the number of columns that were limited to their bounds.
    pub fn set_pore_pressures(&mut self, transferred: &[(usize, TransferredPressure)]) -> usize {
        let Self { clock, settings, boundary, nodes, .. } = self;
        if nodes.pore_columns.is_empty() {
            return 0;
        }
        let FlowNodes { sets, pore_columns, .. } = &mut *nodes;
        let limited = set_pore_pressures(settings, &sets[0], pore_columns, transferred, clock.time);
        initialise_far_field_columns(&boundary.open_sides, nodes);
        limited
    }

    /// Adds, removes or resets nodes between two stages; the energy that they bring or take counts as inflow in the balance.
    pub(crate) fn change_nodes_externally(&mut self, change: impl FnOnce(&mut FlowNodes<D>)) {
        let Self { settings, bed, boundary, nodes, records, .. } = self;
        change_nodes_externally(settings, bed, boundary, nodes, &mut records.energy_balance, change);
    }
}
