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

mod absorbing_layer;
mod boundary_state;
mod far_field;
mod inlet;
mod inlet_volume;
mod interior_fit;
mod open_boundary;
mod pore_columns;
mod two_layers;

use crate::boundary::open::open_boundary::SideRegion;
pub(crate) use crate::boundary::open::two_layers::LayerOfSide;
use crate::config::choices::Phases;
use crate::flow::Flow;
use crate::phases::erosion_and_interface::keep_nodes;
use crate::phases::phase_nodes::{PhaseNodes, PlanVector};

pub(crate) use crate::boundary::open::boundary_state::LineFitSums;
pub use crate::boundary::open::boundary_state::{ArrivalHistory, BoundaryState, InteriorFit};
pub use crate::boundary::open::far_field::{FarField, StripState};
pub use crate::boundary::open::inlet::Inlet;
pub use crate::boundary::open::open_boundary::OpenBoundary;

/// Extent of the nodes beyond a side, in supports of a kernel: the last ones, which lack neighbours, have no influence within.
const FAR_FIELD_SUPPORTS: f64 = 3.0;

/// Open side to be created.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Axis normal to the side.
    pub axis: usize,
    /// Position along that axis (m).
    pub place: f64,
    /// Outward direction: 1 at the upper end of the axis, -1 at the lower one.
    pub outward: f64,
    /// Distance of the nodes (m).
    pub spacing: f64,
    /// Begin and end along the other axis (m), in plan.
    pub span: (f64, f64),
    /// Whether the other axis is periodic there.
    pub periodic: bool,
    /// Inflow through the side, in place of the far state: one, or one for each of two layers. In a profile.
    pub inlets: Vec<Inlet>,
    /// Length of the absorbing layer before the side (m); 0 for none.
    pub absorbing_length: f64,
}

/// Axis, position and direction of the sides of all layers.
type OpenSides = Vec<(usize, f64, f64)>;

/// Region of a position for side `number` of all: a corner belongs to the first of its sides. Sides of two layers are at one position.
fn region_of<const D: usize>(sides: &OpenSides, number: usize, x: &PlanVector<D>) -> SideRegion {
    let is_beyond = |(axis, place, outward): &(usize, f64, f64)| outward * (x[*axis] - place) > 0.0;
    match sides.iter().position(is_beyond) {
        None => SideRegion::Interior,
        Some(own) if sides[own] == sides[number] => SideRegion::Outside,
        Some(_) => SideRegion::OutsideOther,
    }
}

impl<const D: usize> Flow<D> {
    /// Opens an end of a profile, before the first step. `spacing` is that of the nodes (m).
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn open_end(
        &mut self,
        place: f64,
        outward: f64,
        spacing: f64,
    ) -> Result<(), crate::flow::FlowFailure> {
        self.open_sides(&[Opening {
            axis: 0,
            place,
            outward,
            spacing,
            span: (0.0, 0.0),
            periodic: false,
            inlets: Vec::new(),
            absorbing_length: 0.0,
        }])
    }

    /// Opens sides, all of them at once and before the first step. A common corner belongs to the first of its sides.
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn open_sides(&mut self, openings: &[Opening]) -> Result<(), crate::flow::FlowFailure> {
        let longest = self.sets.iter().flat_map(|set| &set.nodes.first_length).copied().fold(0.0, f64::max);
        let reach = self.reach_beyond(longest);
        let (gravity, time) = (self.settings.gravity, self.time);
        let known = self.open_boundaries.len();
        // Each of two layers has its sides.
        let strata = self.layers_of_sides();
        let mut sides = self.open_side_list();
        for opening in openings {
            sides.extend(strata.iter().map(|_| (opening.axis, opening.place, opening.outward)));
        }
        let all = openings.iter().flat_map(|opening| strata.iter().map(move |stratum| (opening, *stratum)));
        let mut later = Vec::new();
        for (number, (opening, stratum)) in (known..).zip(all) {
            let mut end = OpenBoundary::new(opening, reach, openings, stratum);
            let set = stratum.map(|stratum| stratum.set);
            let feed = opening.inlets.iter().find(|feed| feed.layer == set).cloned();
            end.initialise(&self.sets, &|x| region_of(&sides, number, x), gravity, time, feed.as_ref());
            let most = feed.as_ref().map_or(0.0, |feed| feed.max_speed(gravity));
            self.fastest_start = self.fastest_start.max(most);
            // Inflow begins after the sums of the initial state are known.
            let stands = end.strips.iter().any(|strip| strip.far_state.is_some());
            let (now, then) = if stands { (None, feed) } else { (feed, None) };
            end.inlet = now;
            later.push(then);
            self.open_boundaries.push(end);
        }
        self.update_open_boundaries(0.0);
        self.reinitialise_thickness()?;
        let kernel = self.settings.numerics.kernel;
        let Self { open_boundaries: opens, sets, .. } = self;
        for (number, (end, feed)) in (known..).zip(opens[known..].iter_mut().zip(later)) {
            end.calibrate_lattice_sum(kernel, sets, &|x| region_of(&sides, number, x));
            end.store_undisturbed(sets, &|x| region_of(&sides, number, x));
            if feed.is_some() {
                end.inlet = feed;
            }
        }
        Ok(())
    }

    /// Extent of nodes with this smoothing length (m) beyond an open side (m).
    pub fn reach_beyond(&self, length: f64) -> f64 {
        FAR_FIELD_SUPPORTS * self.settings.numerics.kernel.support() * length
    }

    /// Axis, position and direction of each open side.
    fn open_side_list(&self) -> OpenSides {
        self.open_boundaries.iter().map(|side| (side.axis, side.place, side.outward)).collect()
    }

    /// Layers with sides of their own; none of one phase, or of grains and fluid.
    fn layers_of_sides(&self) -> Vec<Option<LayerOfSide>> {
        if self.settings.phases != Phases::Layers {
            return vec![None];
        }
        let densities = &self.settings.material.densities;
        let ratio = densities.fluid / densities.grain;
        (0..2).map(|set| Some(LayerOfSide { set, ratio })).collect()
    }

    /// Updates the nodes beyond the open sides to the state of their side, with their columns of pore pressure.
    pub(crate) fn update_open_boundaries(&mut self, dt: f64) {
        self.pass_nodes(dt);
        self.update_far_field_columns();
    }

    fn pass_nodes(&mut self, dt: f64) {
        let sides = self.open_side_list();
        for number in 0..self.open_boundaries.len() {
            let Self { settings, sets, open_boundaries: opens, time, step, .. } = self;
            let (end, part) = (&mut opens[number], |x: &PlanVector<D>| region_of(&sides, number, x));
            let entered = end.count_crossings(sets, &part);
            end.set_inlet_volumes(sets, &entered, (*time, settings.gravity));
            end.find_state(settings, sets, &part, (*time, dt, *step == 0));
            if end.flow_layer.is_none() {
                self.update_far_field_nodes(number, &sides);
            }
        }
        self.exchange_layer_states(&sides, dt);
        for number in 0..self.open_boundaries.len() {
            if self.open_boundaries[number].flow_layer.is_some() {
                self.update_far_field_nodes(number, &sides);
            }
        }
    }

    /// Exchanges the states of two layers at their sides.
    fn exchange_layer_states(&mut self, sides: &OpenSides, dt: f64) {
        let Self { settings, sets, open_boundaries: opens, time, .. } = self;
        for (pair, ends) in opens.chunks_mut(2).enumerate() {
            let [lower, upper] = ends else { return };
            if lower.flow_layer.is_none() {
                return;
            }
            let part = |x: &PlanVector<D>| region_of(sides, 2 * pair, x);
            let look = |end: &OpenBoundary<D>| {
                end.fit_interior(settings.numerics.kernel, sets, &part, end.search_distance())
            };
            // In plan waves may come at an angle, for which delays along the normal are wrong.
            let arriving = (D == 1).then(|| [look(lower), look(upper)]);
            let (inside, reach) = (lower.search_distance(), lower.reach());
            for strip in 0..lower.strips.len() {
                let still = [lower.strips[strip].far_state, upper.strips[strip].far_state];
                let within = [lower.state.strips[strip].interior_fit, upper.state.strips[strip].interior_fit];
                for end in [&mut *lower, &mut *upper] {
                    let both = end.state.strips[strip].layers.get_or_insert_default();
                    both.set(still, within);
                    if let Some([of_lower, of_upper]) = &arriving {
                        both.record((*time, dt), [of_lower[strip], of_upper[strip]], inside, reach);
                    }
                }
            }
        }
    }

    /// Updates the nodes beyond side `number` to its state.
    fn update_far_field_nodes(&mut self, number: usize, sides: &OpenSides) {
        let Self { sets, pore_columns: heads, open_boundaries: opens, scratch: spare, next_id, .. } = self;
        let (end, count) = (&mut opens[number], sets.len());
        let part = |x: &PlanVector<D>| region_of(sides, number, x);
        for (role, set) in sets.iter_mut().enumerate() {
            if !end.is_of(role) {
                continue;
            }
            let (farthest, gone) = end.set_far_field_nodes(&mut set.nodes, (count, role), &part);
            if !gone.is_empty() {
                let nodes = &set.nodes;
                let stays = |i: &usize| gone.binary_search(&nodes.id[*i]).is_err();
                let order: Vec<u32> = (0..nodes.len()).filter(stays).map(|i| i as u32).collect();
                keep_nodes(set, (role == 0).then_some(&mut *heads), &order, spare);
            }
            let before = set.len();
            end.add_far_field_nodes(set, (count, role), &farthest, next_id);
            if role == 0 {
                (before..set.len()).for_each(|_| heads.push());
            }
        }
    }

    /// Restores the prescribed velocity of nodes beyond open sides, whatever forces act on them.
    pub(crate) fn hold_far_field_velocities(&mut self) {
        let Self { open_boundaries: opens, sets, .. } = self;
        for end in opens {
            for set in sets.iter_mut() {
                let nodes = &mut set.nodes;
                for i in 0..nodes.len() {
                    if end.state.ids.binary_search(&nodes.id[i]).is_ok() {
                        let x = nodes.position[i];
                        let stand = end.at(end.strip(&x), end.distance_beyond(&x).max(0.0));
                        nodes.velocity[i] = end.velocity(&stand);
                    }
                }
            }
        }
    }

    /// Volume of the nodes beyond open sides (m³; m² in profiles).
    pub fn far_field_volume(&self) -> f64 {
        let beyond = |nodes: &PhaseNodes<D>| -> f64 {
            let own = nodes.id.iter().zip(&nodes.volume).filter(|(id, _)| self.is_far_field_node(**id));
            own.map(|(_, volume)| volume).sum()
        };
        self.sets.iter().map(|set| beyond(&set.nodes)).sum()
    }

    /// Whether node number `id` is beyond an open side.
    pub(crate) fn is_far_field_node(&self, id: u64) -> bool {
        self.open_boundaries.iter().any(|end| end.state.ids.binary_search(&id).is_ok())
    }

    /// Whether node number `id` is beyond a side with inflow.
    pub(crate) fn is_inlet_node(&self, id: u64) -> bool {
        self.open_boundaries.iter().any(|end| end.has_inlet() && end.state.ids.binary_search(&id).is_ok())
    }
}
