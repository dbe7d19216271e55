//! Open boundaries, through which waves leave, by the invariants `u ± 2c` along characteristics (sheet: depth-sph §2.2, §3.9): ends of
//! profiles, and sides in plan along the axes.
//!
//! Nodes fill the space beyond the side as far as kernels reach, and move with the state of the side: one invariant comes from within, the
//! other from the material outside, which keeps the initial state at the side. A side in plan is cut into strips, each with a state of its
//! own, of waves along its normal.
//!
//! Sums of depth are off by some hundredths of a wave between nodes that move and nodes whose volume follows the wave, and this error is
//! reflected. At the end of a profile the arriving flow is therefore sampled two supports of a kernel before it, and reaches the end and
//! the nodes beyond with the delay of waves: less than 1 % of a small wave is reflected (V27: 2 %). In plan, where waves come at angles,
//! it is sampled at the side: 4.5 % of small waves are reflected head-on, 12 % at 30°, 15 % at 45°, and less where they decay in an
//! absorbing layer before it.

pub(crate) mod absorbing_layer;
mod boundary_state;
mod far_field;
mod inlet;
mod inlet_volume;
mod interior_fit;
mod open_boundary;
pub(crate) mod pore_columns;
mod two_layers;

use crate::boundary::FlowBoundaries;
pub(crate) use crate::boundary::open::open_boundary::SideRegion;
pub(crate) use crate::boundary::open::two_layers::LayerOfSide;
use crate::clock::Clock;
use crate::config::choices::Phases;
use crate::config::settings::FlowSettings;
use crate::flow_nodes::FlowNodes;
use crate::phases::phase::PhaseSet;
use crate::points::phase_nodes::PlanVector;

pub(crate) use crate::boundary::open::boundary_state::LineFitSums;
pub use crate::boundary::open::far_field::FarField;
pub use crate::boundary::open::inlet::Inlet;
pub use crate::boundary::open::open_boundary::OpenBoundary;

/// Width of the zone with nodes outside a boundary, in kernel supports. Its outermost nodes, which lack neighbours, do not influence the
/// flow.
const FAR_FIELD_SUPPORTS: f64 = 3.0;

/// Open side to be created.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Axis normal to the side.
    pub axis: usize,
    /// Position along that axis (m).
    pub coordinate: f64,
    /// Outward direction: 1 at the upper end of the axis, -1 at the lower one.
    pub outward: f64,
    /// Distance of the nodes (m).
    pub spacing: f64,
    /// Range of the boundary along the other axis (m), in plan.
    pub span: (f64, f64),
    /// Whether the boundary is periodic along the other axis.
    pub periodic: bool,
    /// Inflows through the boundary in place of the far-field state: one, or one per layer. Only in profiles.
    pub inlets: Vec<Inlet>,
    /// Length of the absorbing layer inside the boundary (m); 0 for none.
    pub absorbing_length: f64,
}

/// Axis, coordinate (m) and outward direction of each open boundary.
pub(crate) type OpenSides = Vec<(usize, f64, f64)>;

/// Axis, coordinate (m) and outward direction of the open boundaries.
pub(crate) fn open_sides<const D: usize>(open: &[OpenBoundary<D>]) -> OpenSides {
    open.iter().map(|side| (side.axis, side.coordinate, side.outward)).collect()
}

/// Region of a position relative to an open boundary; a corner belongs to the first of its two boundaries. The boundaries of two layers
/// coincide.
pub(crate) fn region_of<const D: usize>(sides: &OpenSides, number: usize, x: &PlanVector<D>) -> SideRegion {
    let is_beyond = |(axis, place, outward): &(usize, f64, f64)| outward * (x[*axis] - place) > 0.0;
    match sides.iter().position(is_beyond) {
        None => SideRegion::Interior,
        Some(own) if sides[own] == sides[number] => SideRegion::Outside,
        Some(_) => SideRegion::OutsideOther,
    }
}

/// Width of the zone with nodes outside an open boundary (m), for a smoothing length (m).
pub(crate) fn node_extent_beyond<const D: usize>(settings: &FlowSettings<D>, length: f64) -> f64 {
    FAR_FIELD_SUPPORTS * settings.numerics.kernel.support() * length
}

/// Layers that have separate open boundaries; `None` for flows that are not of two layers.
pub(crate) fn layers_of_sides<const D: usize>(settings: &FlowSettings<D>) -> Vec<Option<LayerOfSide>> {
    if settings.phases != Phases::Layers {
        return vec![None];
    }
    let densities = &settings.material.densities;
    let ratio = densities.fluid / densities.grain;
    (0..2).map(|set| Some(LayerOfSide { set, ratio })).collect()
}

/// Updates nodes and pore-pressure columns outside the open boundaries to the boundary states over a step of `dt` (s).
pub(crate) fn update_open_boundaries<const D: usize>(
    settings: &FlowSettings<D>,
    clock: &Clock,
    open: &mut [OpenBoundary<D>],
    nodes: &mut FlowNodes<D>,
    dt: f64,
) {
    pass_nodes(settings, clock, open, nodes, dt);
    pore_columns::update_far_field_columns(open, nodes);
}

/// Counts the nodes that have crossed the open boundaries, and computes state and inflow of each boundary.
fn pass_nodes<const D: usize>(
    settings: &FlowSettings<D>,
    clock: &Clock,
    open: &mut [OpenBoundary<D>],
    nodes: &mut FlowNodes<D>,
    dt: f64,
) {
    let sides = open_sides(open);
    for (number, end) in open.iter_mut().enumerate() {
        let region = |x: &PlanVector<D>| region_of(&sides, number, x);
        let sets = &mut nodes.sets;
        let entered = end.count_crossings(sets, &region);
        end.set_inlet_volumes(sets, &entered, (clock.time, settings.gravity));
        end.find_state(settings, sets, &region, (clock.time, dt, clock.step == 0));
        if end.flow_layer.is_none() {
            update_far_field_nodes(end, nodes, &region);
        }
    }
    exchange_layer_states(settings, open, &nodes.sets, &sides, (clock.time, dt));
    for (number, end) in open.iter_mut().enumerate() {
        if end.flow_layer.is_some() {
            update_far_field_nodes(end, nodes, &|x| region_of(&sides, number, x));
        }
    }
}

/// Exchanges the states of two layers at their common boundary segments.
fn exchange_layer_states<const D: usize>(
    settings: &FlowSettings<D>,
    open: &mut [OpenBoundary<D>],
    sets: &[PhaseSet<D>],
    sides: &OpenSides,
    time: (f64, f64),
) {
    for (pair, ends) in open.chunks_mut(2).enumerate() {
        let [lower, upper] = ends else { return };
        if lower.flow_layer.is_none() {
            return;
        }
        let region = |x: &PlanVector<D>| region_of(sides, 2 * pair, x);
        let fit = |end: &OpenBoundary<D>| {
            end.fit_interior(settings.numerics.kernel, sets, &region, end.search_distance())
        };
        // In plan waves may come at an angle, for which delays along the normal are wrong.
        let arriving = (D == 1).then(|| [fit(lower), fit(upper)]);
        let (inside, reach) = (lower.search_distance(), lower.node_extent());
        for strip in 0..lower.strips.len() {
            let still = [lower.strips[strip].far_state, upper.strips[strip].far_state];
            let within = [lower.state.strips[strip].interior_fit, upper.state.strips[strip].interior_fit];
            for end in [&mut *lower, &mut *upper] {
                let both = end.state.strips[strip].layers.get_or_insert_default();
                both.set_states(still, within);
                if let Some([of_lower, of_upper]) = &arriving {
                    both.record(time, [of_lower[strip], of_upper[strip]], inside, reach);
                }
            }
        }
    }
}

/// Updates the nodes outside an open boundary to its state.
fn update_far_field_nodes<const D: usize>(
    end: &mut OpenBoundary<D>,
    nodes: &mut FlowNodes<D>,
    region: &dyn Fn(&PlanVector<D>) -> SideRegion,
) {
    let count = nodes.sets.len();
    for role in 0..count {
        if !end.is_of(role) {
            continue;
        }
        let (farthest, removed) = end.set_far_field_nodes(&mut nodes.sets[role].nodes, (count, role), region);
        if !removed.is_empty() {
            let kept: Vec<bool> =
                nodes.sets[role].nodes.id.iter().map(|id| removed.binary_search(id).is_err()).collect();
            nodes.retain_nodes(role, |i| kept[i]);
        }
        let FlowNodes { sets, pore_columns, next_id, .. } = nodes;
        let set = &mut sets[role];
        let before = set.len();
        end.add_far_field_nodes(set, (count, role), &farthest, next_id);
        if role == 0 {
            (before..set.len()).for_each(|_| pore_columns.push());
        }
    }
}

impl<const D: usize> FlowBoundaries<D> {
    /// Restores the prescribed velocities of the nodes outside open boundaries.
    pub(super) fn hold_far_field_velocities(&self, sets: &mut [PhaseSet<D>]) {
        for end in &self.open_sides {
            for set in sets.iter_mut() {
                let nodes = &mut set.nodes;
                for i in 0..nodes.len() {
                    if end.state.ids.binary_search(&nodes.id[i]).is_ok() {
                        let x = nodes.position[i];
                        let state = end.state_beyond(end.strip(&x), end.distance_beyond(&x).max(0.0));
                        nodes.velocity[i] = end.velocity(&state);
                    }
                }
            }
        }
    }
}
