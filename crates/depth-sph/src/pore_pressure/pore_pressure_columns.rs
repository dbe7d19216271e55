//! Excess pore pressure on the columns of the solid nodes (sheet: depth-sph §2.7, §3.6).

use rayon::prelude::*;

use crate::config::settings::{Consolidation, FlowSettings, PoreColumn};
use crate::laws::pore_pressure_column;
use crate::laws::pore_pressure_column::{BaseCondition, Drainage, LowerBound, MAX_CELLS, PressureProfile};
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::pore_pressure::pressure_transfer::TransferredPressure;

/// Excess pore pressures in the columns of all grain nodes, as heads.
#[derive(Clone, Debug, Default)]
pub struct PorePressureColumns {
    /// Excess pore-pressure heads of each node from the base to the surface (m), `cells + 1` per node; empty without pore pressure.
    pub heads: Vec<f64>,
    /// Values per node.
    pub width: usize,
    /// Depth of the last loading (m); NaN before the first.
    pub depth: Vec<f64>,
    /// Time up to which the pressure has drained (s).
    pub time: f64,
    /// Nodes at a bound in the last step.
    pub limited_nodes: usize,
}

impl PorePressureColumns {
    /// Columns of `cells` intervals for `nodes` nodes; their depth is that of the first step.
    pub fn new(cells: usize, nodes: usize) -> Self {
        let width = cells + 1;
        Self { heads: vec![0.0; width * nodes], width, depth: vec![f64::NAN; nodes], ..Self::default() }
    }

    /// Whether there are columns.
    pub fn is_empty(&self) -> bool {
        self.width == 0
    }

    /// Heads of node `i` (m).
    pub fn column(&self, i: usize) -> &[f64] {
        &self.heads[i * self.width..(i + 1) * self.width]
    }

    /// Excess head at the base of a node (m); zero without pore pressure.
    #[inline]
    pub fn base_head(&self, i: usize) -> f64 {
        self.heads.get(i * self.width).copied().unwrap_or(0.0)
    }

    /// Mean excess head of a node (m); zero without pore pressure.
    pub fn mean(&self, i: usize) -> f64 {
        if self.is_empty() { 0.0 } else { pore_pressure_column::mean(self.column(i)) }
    }

    /// Sorts the columns in the given order and removes those that it does not list.
    pub fn reorder(&mut self, order: &[u32]) {
        if self.is_empty() {
            return;
        }
        let width = self.width;
        self.heads =
            order.iter().flat_map(|&k| self.heads[k as usize * width..][..width].iter().copied()).collect();
        self.depth = order.iter().map(|&k| self.depth[k as usize]).collect();
    }

    /// Adds a column for a new node; its depth is that of the next step.
    pub fn push(&mut self) {
        if !self.is_empty() {
            self.heads.resize(self.heads.len() + self.width, 0.0);
            self.depth.push(f64::NAN);
        }
    }

    /// Loads the columns by the change of depth, and consolidates them up to `time` (s).
    pub fn advance<const D: usize>(&mut self, settings: &FlowSettings<D>, set: &PhaseSet<D>, time: f64) {
        let Some(pore) = &settings.column else { return };
        let dt = time - self.time;
        self.time = time;
        let columns = self.heads.par_chunks_mut(self.width).zip(&mut self.depth).enumerate();
        let advance = |(i, (head, loaded_depth)): (usize, (&mut [f64], &mut f64))| {
            usize::from(NodeColumn::for_node(settings, pore, set, i).advance(head, loaded_depth, dt))
        };
        self.limited_nodes = columns.with_min_len(MIN_NODES_PER_TASK / 4).map(advance).sum();
    }
}

/// Sets the pore pressure in the columns, before the first step. `transferred` has the number of each node and its excess over the
/// hydrostatic pressure. Returns the number of columns that were limited to their bounds.
pub fn set_pore_pressures<const D: usize>(
    settings: &FlowSettings<D>,
    set: &PhaseSet<D>,
    columns: &mut PorePressureColumns,
    transferred: &[(usize, TransferredPressure)],
    time: f64,
) -> usize {
    let width = columns.width;
    for (id, TransferredPressure { depth, pressure }) in transferred {
        // Nodes beyond an open side may have been removed.
        let Ok(i) = set.nodes.id.binary_search(&(*id as u64)) else { continue };
        let gravity = set.nodes.bed_gravity[i];
        let (submerged, fluid) = (set.submerged_density(settings, 0, i), settings.material.densities.fluid);
        let column = &mut columns.heads[i * width..][..width];
        for (k, (head, pressure)) in column.iter_mut().zip(pressure).enumerate() {
            let rest = 1.0 - k as f64 / (width - 1) as f64;
            *head = (pressure / gravity - fluid * depth * rest) / submerged;
        }
    }
    columns.advance(settings, set, time);
    columns.limited_nodes
}

/// Column of a node: its surroundings in a step.
struct NodeColumn<'a, const D: usize> {
    settings: &'a FlowSettings<D>,
    pore: &'a PoreColumn,
    set: &'a PhaseSet<D>,
    /// Index of the node.
    i: usize,
    /// Depth (m).
    depth: f64,
    /// Porosity of the flow.
    porosity: f64,
    /// Submerged density of the flow (kg/m³).
    submerged_density: f64,
}

impl<'a, const D: usize> NodeColumn<'a, D> {
    /// Column of node `i` with its depth, porosity and submerged density.
    fn for_node(settings: &'a FlowSettings<D>, pore: &'a PoreColumn, set: &'a PhaseSet<D>, i: usize) -> Self {
        let porosity = set.neighbour_data.porosity.get(i).copied().unwrap_or(settings.material.porosity);
        let submerged_density = settings.material.densities.submerged_density(porosity);
        Self { settings, pore, set, i, depth: set.nodes.depth[i], porosity, submerged_density }
    }

    /// Advances the heads of a column by loading, consolidation and bounds over `dt` (s). Returns whether a bound was reached.
    fn advance(&self, head: &mut [f64], loaded_depth: &mut f64, dt: f64) -> bool {
        let Self { settings, pore, set, i, depth, porosity, submerged_density } = *self;
        let densities = &settings.material.densities;
        if submerged_density <= 0.0 || depth <= 0.0 {
            head.fill(0.0);
            *loaded_depth = depth;
            return false;
        }
        if loaded_depth.is_nan() {
            pore_pressure_column::set_linear_profile(head, pore.excess_ratio * depth);
        } else {
            pore_pressure_column::load_undrained(head, depth - *loaded_depth);
        }
        *loaded_depth = depth;
        let coefficient = match pore.consolidation {
            Consolidation::Coefficient(value) => value,
            Consolidation::OfDrag => pore.stiffness * settings.drag.permeability(porosity, densities),
        };
        let air = -densities.fluid / submerged_density;
        self.apply_dilatancy(head, dt);
        self.drain(coefficient, air, head, dt);
        let (drainage, bearing) = (settings.zone(&set.nodes.position[i]).drainage, set.nodes.bed_gravity[i]);
        pore_pressure_column::limit_head(head, depth, |rest| match (drainage, pore.lower_bound) {
            // Over a drained base the whole column may fall to the pressure of the air.
            (Drainage::Atmospheric, _) => air * depth,
            (_, LowerBound::NoSuction) => 0.0,
            (_, LowerBound::Total { cavitation }) if bearing > 0.0 => {
                air * depth * rest - cavitation / (submerged_density * bearing)
            }
            (_, LowerBound::Total { .. }) => air * depth * rest,
        })
    }

    /// Consolidates a column with the drainage condition of its base; `air` is the head of the air pressure over the depth.
    fn drain(&self, coefficient: f64, air: f64, head: &mut [f64], dt: f64) {
        let Self { settings, pore, set, i, depth, .. } = *self;
        let normal = depth * depth / set.bed[i].steepness();
        let densities = &settings.material.densities;
        let base = match settings.zone(&set.nodes.position[i]).drainage {
            Drainage::Sealed => BaseCondition::Sealed,
            Drainage::Hydrostatic => BaseCondition::Head(0.0),
            Drainage::Atmospheric => BaseCondition::Head(air * depth),
            Drainage::Partly { conductance } => {
                let weight = densities.fluid * densities.gravity;
                let permeability = coefficient / pore.stiffness * weight;
                BaseCondition::Partly(conductance * normal.sqrt() / permeability)
            }
        };
        let factor = coefficient * dt / normal;
        match pore.profile {
            PressureProfile::FiniteDifference => {
                let mut scratch = [0.0; MAX_CELLS + 1];
                let scratch = &mut scratch[..head.len()];
                pore_pressure_column::diffuse_head(head, factor, pore.weight, base, scratch);
            }
            PressureProfile::ShapeFunction => pore_pressure_column::relax_amplitude(head, factor, base),
        }
    }

    /// Adds the dilatancy term `-(K_v/α) γ' K_ψ (n_crit - n)`: shear dilates dense skeletons and compacts loose ones.
    fn apply_dilatancy(&self, head: &mut [f64], dt: f64) {
        let Self { settings, pore, set, i, depth, porosity, submerged_density } = *self;
        let Some((slope, critical)) = pore.dilatancy else { return };
        let rate = 2.0 * set.bed[i].speed(&set.nodes.velocity[i]) / depth;
        let strain = rate * slope * (critical - porosity) * dt;
        let change = -pore.stiffness * strain
            / (submerged_density * set.nodes.bed_gravity[i].max(1e-3 * settings.gravity));
        // Excess pressure stays zero at the surface.
        let last = head.len() - 1;
        head[..last].iter_mut().for_each(|value| *value += change);
    }
}
