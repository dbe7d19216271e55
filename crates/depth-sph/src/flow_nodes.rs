//! Nodes of a flow: the sets of its phases with their columns of pore pressure, which change together.

use colluvium_points::{CellList, ScratchBuffers};

use crate::config::settings::FlowSettings;
use crate::phases::failure::FlowFailure;
use crate::phases::phase::PhaseSet;
use crate::points::phase_nodes::{NewNode, PhaseNodes};
use crate::pore_pressure::pore_pressure_columns::PorePressureColumns;

/// Steps between two sorts by cell.
const STEPS_PER_SORT: u64 = 20;

/// Nodes of a flow.
pub struct FlowNodes<const D: usize> {
    /// Node sets: one, or those of grains and fluid, or those of the lower and upper layer.
    pub sets: Vec<PhaseSet<D>>,
    /// Pore-pressure columns of the nodes of the first set.
    pub pore_columns: PorePressureColumns,
    /// Number of the next node.
    pub next_id: u64,
    workspace: NodeWorkspace<D>,
}

/// Buffers of sorts and removals.
struct NodeWorkspace<const D: usize> {
    /// Cells by which the nodes are sorted.
    cells: CellList<D>,
    /// Columns of the nodes in their new order.
    columns: ScratchBuffers,
}

impl<const D: usize> FlowNodes<D> {
    /// Nodes of each set, numbered in order, with pore-pressure columns if the settings have them.
    pub fn new(settings: &FlowSettings<D>, nodes: &[Vec<NewNode<D>>]) -> Self {
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
        let pore_columns = settings
            .column
            .as_ref()
            .map_or_else(PorePressureColumns::default, |pore| PorePressureColumns::new(pore.cells, first));
        let workspace = NodeWorkspace { cells: CellList::new(), columns: ScratchBuffers::default() };
        Self { sets, pore_columns, next_id, workspace }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.sets.iter().map(PhaseSet::len).sum()
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sorts nodes every few steps so that neighbours are close in memory.
    ///
    /// # Errors
    /// The first node that the search cannot locate.
    pub fn sort(&mut self, settings: &FlowSettings<D>, step: u64) -> Result<(), FlowFailure> {
        if !step.is_multiple_of(STEPS_PER_SORT) {
            return Ok(());
        }
        let support = settings.numerics.kernel.support();
        let Self { sets, pore_columns, workspace: NodeWorkspace { cells, columns }, .. } = self;
        for (number, set) in sets.iter_mut().enumerate() {
            if set.nodes.is_empty() {
                continue;
            }
            let mean = set.nodes.length.iter().sum::<f64>() / set.len() as f64;
            set.sort(support * mean, cells, columns).map_err(|error| FlowFailure::of_search(set, &error))?;
            if number == 0 {
                pore_columns.reorder(cells.order());
            }
        }
        Ok(())
    }

    /// Adds a node to a set, with the thickness (m) and the effective gravity (m/s²) that it has until the next sums.
    pub fn add(&mut self, number: usize, node: &NewNode<D>, thickness: f64, gravity: f64) {
        let set = &mut self.sets[number];
        set.nodes.push(self.next_id, node);
        self.next_id += 1;
        let last = set.nodes.len() - 1;
        (set.nodes.partial_thickness[last], set.nodes.depth[last]) = (thickness, thickness);
        set.nodes.effective_gravity[last] = gravity;
        set.clear_lists();
        if number == 0 {
            self.pore_columns.push();
        }
    }

    /// Removes nodes, with their columns of pore pressure.
    pub fn remove_where(&mut self, is_removed: impl Fn(&PhaseNodes<D>, usize) -> bool) {
        for number in 0..self.sets.len() {
            let nodes = &self.sets[number].nodes;
            let removed: Vec<bool> = (0..nodes.len()).map(|i| is_removed(nodes, i)).collect();
            if removed.contains(&true) {
                self.retain_nodes(number, |i| !removed[i]);
            }
        }
    }

    /// Removes the nodes of a set for which the condition is false, with their pore-pressure columns.
    pub fn retain_nodes(&mut self, number: usize, is_kept: impl Fn(usize) -> bool) {
        let Self { sets, pore_columns, workspace, .. } = self;
        let set = &mut sets[number];
        let order: Vec<u32> = (0..set.nodes.len()).filter(|i| is_kept(*i)).map(|i| i as u32).collect();
        if number == 0 {
            pore_columns.reorder(&order);
        }
        set.nodes.reorder(&order, &mut workspace.columns);
        set.clear_lists();
    }
}
