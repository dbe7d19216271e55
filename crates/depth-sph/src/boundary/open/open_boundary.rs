//! One open side: its strips, the state beyond each, and the nodes there.

use colluvium_points::CellList;

use crate::boundary::open::absorbing_layer::AbsorbingLayer;
use crate::boundary::open::boundary_state::{
    ArrivalHistory, BoundaryState, InteriorFit, outward_and_tangential,
};
use crate::boundary::open::far_field::{FarField, StripState};
use crate::boundary::open::two_layers::LayerOfSide;
use crate::boundary::open::{FAR_FIELD_SUPPORTS, Inlet, Opening};
use crate::config::settings::FlowSettings;
use crate::inflow::ArrivingFlow;
use crate::phases::phase::PhaseSet;
use crate::points::phase_nodes::{NewNode, PhaseNodes, PlanVector};

/// Least distance of an added node from other nodes, over the node spacing.
const MIN_NODE_DISTANCE: f64 = 0.6;

/// Distance inside a boundary at which the arriving flow is sampled, in kernel supports. Nodes outside have no influence there, which would
/// return as waves.
const PROBE_SUPPORTS: f64 = 2.0;

/// Open boundary: side of the domain through which waves leave or material flows in.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenBoundary<const D: usize> {
    /// Axis normal to the side.
    pub axis: usize,
    /// Position along that axis (m).
    pub coordinate: f64,
    /// Outward direction: 1 at the upper end of the axis, -1 at the lower one.
    pub outward: f64,
    /// Spacing of the nodes outside the boundary (m).
    pub spacing: f64,
    /// Extent of the nodes beyond the side (m).
    node_extent: f64,
    /// Coordinate at which the segments along the boundary begin (m), in plan.
    pub(super) low: f64,
    /// Segments along the boundary, each as long as the node spacing; one in a profile.
    pub(super) strips: Vec<BoundarySegment<D>>,
    /// Number of segments at both ends that are outside another open boundary; they copy the state of the next segment.
    pub(super) corner_strips: [usize; 2],
    /// Whether the last segment is adjacent to the first one.
    pub(super) periodic: bool,
    /// Inflow through the boundary, in place of the far-field state.
    pub(crate) inlet: Option<Inlet>,
    /// Layer to which the boundary belongs; `None` for flows that are not of two layers.
    pub(super) flow_layer: Option<LayerOfSide>,
    /// Absorbing layer inside the boundary.
    pub(super) layer: AbsorbingLayer,
    /// State of the flow outside the boundary.
    pub state: FarField,
}

/// Segment of an open boundary, one node spacing long.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BoundarySegment<const D: usize> {
    /// Templates of nodes that are added outside the segment, for each node set.
    pub(super) template_nodes: [Option<NewNode<D>>; 2],
    /// Far-field state; `None` if there was no material outside at the start.
    pub(super) far_state: Option<BoundaryState>,
    /// Volume of a node over the depth by summation (m; m² in plan).
    pub(super) width: f64,
}

/// Region of a position: inside all open boundaries, outside this one, or outside another.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum SideRegion {
    Interior,
    Outside,
    OutsideOther,
}

impl<const D: usize> OpenBoundary<D> {
    /// Open boundary of a side of the domain; corners belong to the first of two adjacent boundaries.
    pub(crate) fn new(
        opening: &Opening,
        node_extent: f64,
        others: &[Opening],
        flow_layer: Option<LayerOfSide>,
    ) -> Self {
        let Opening { axis, coordinate, outward, spacing, span, periodic, absorbing_length: layer, .. } =
            *opening;
        // Corners of two open sides belong to the first of them.
        let goes_on = |end: f64| {
            others.iter().any(|other| other.axis != axis && (other.coordinate - end).abs() < 0.5 * spacing)
        };
        let more = (node_extent / spacing).ceil() as usize + 1;
        let (beside, count) = if D == 1 {
            ([0; 2], 1)
        } else {
            let beside = [span.0, span.1].map(|end| if goes_on(end) { more } else { 0 });
            (beside, ((span.1 - span.0) / spacing).round().max(1.0) as usize)
        };
        let strip =
            BoundarySegment { template_nodes: [None; 2], far_state: None, width: spacing.powi(D as i32) };
        let count = count + beside[0] + beside[1];
        Self {
            axis,
            coordinate,
            outward,
            spacing,
            node_extent,
            low: span.0 - beside[0] as f64 * spacing,
            strips: vec![strip; count],
            corner_strips: beside,
            periodic,
            inlet: None,
            flow_layer,
            layer: AbsorbingLayer::new(layer),
            state: FarField { strips: vec![StripState::default(); count], ..FarField::default() },
        }
    }

    /// Whether the boundary belongs to a node set.
    pub(super) fn is_of(&self, number: usize) -> bool {
        is_of(self.flow_layer, number)
    }

    /// Node sets of the boundary, with their numbers.
    pub(super) fn own_sets<'a>(
        &self,
        sets: &'a [PhaseSet<D>],
    ) -> impl Iterator<Item = (usize, &'a PhaseSet<D>)> + use<'a, D> {
        let flow_layer = self.flow_layer;
        sets.iter().enumerate().filter(move |(number, _)| is_of(flow_layer, *number))
    }

    /// Depth at the nodes (m): total depth, or depth of the layer to which the boundary belongs.
    pub(super) fn depths<'a>(&self, nodes: &'a PhaseNodes<D>) -> &'a [f64] {
        if self.flow_layer.is_some() { &nodes.partial_thickness } else { &nodes.depth }
    }

    /// Effective gravity for waves at a node (m/s²); for inflow of one of two layers that of waves in this layer.
    pub(super) fn wave_gravity(&self, nodes: &PhaseNodes<D>, i: usize) -> f64 {
        let flow_layer = self.flow_layer.filter(|_| self.has_inlet());
        flow_layer.map_or(nodes.effective_gravity[i], |flow_layer| flow_layer.wave_gravity(nodes, i))
    }

    /// Share of a node set in the depth of a state.
    pub(super) fn depth_share(&self, state: &BoundaryState, sets: usize, number: usize) -> f64 {
        if self.flow_layer.is_some() { 1.0 } else { state.depth_share(sets, number) }
    }

    /// Sets the initial state at the boundary. The material outside continues with the depth inside.
    pub(crate) fn initialise(
        &mut self,
        sets: &[PhaseSet<D>],
        region: &dyn Fn(&PlanVector<D>) -> SideRegion,
        gravity: f64,
        time: f64,
        inlet: Option<&Inlet>,
    ) {
        for (number, set) in self.own_sets(sets) {
            let nodes = &set.nodes;
            let mut last: Vec<Option<(f64, usize)>> = vec![None; self.strips.len()];
            for i in 0..nodes.len() {
                let x = &nodes.position[i];
                let beyond = self.distance_beyond(x);
                if region(x) != SideRegion::Interior || !(-2.0 * self.spacing..0.0).contains(&beyond) {
                    continue;
                }
                let entry = &mut last[self.strip(x)];
                if entry.is_none_or(|(other, _)| beyond >= other) {
                    *entry = Some((beyond, i));
                }
            }
            for (strip, last) in self.strips.iter_mut().zip(last) {
                let Some((_, i)) = last else { continue };
                let node = template_node(nodes, i);
                let depth = node.volume / self.spacing.powi(D as i32);
                let [speed, tangential_speed] =
                    outward_and_tangential(&node.velocity, self.axis, self.outward);
                let still = strip.far_state.get_or_insert(BoundaryState {
                    depth: 0.0,
                    speed,
                    tangential_speed,
                    porosity: 0.0,
                });
                still.depth += depth;
                still.porosity += if number == 1 { depth } else { 0.0 };
                strip.template_nodes[number] = Some(node);
            }
        }
        let own: Vec<_> = self.own_sets(sets).filter(|(_, set)| !set.is_empty()).collect();
        let whole = self.flow_layer.is_some();
        for strip in &mut self.strips {
            if let Some(still) = &mut strip.far_state {
                still.porosity /= still.depth;
            } else if let Some(inlet) = inlet {
                let (depth, speed) = inlet.section_by_froude(inlet.discharge(time), gravity);
                let state =
                    BoundaryState { depth, speed: -speed, tangential_speed: 0.0, porosity: inlet.porosity };
                for (number, set) in &own {
                    let share = if whole { 1.0 } else { state.depth_share(sets.len(), *number) };
                    let volume = share * depth * self.spacing;
                    strip.template_nodes[*number] = Some(NewNode { volume, ..template_node(&set.nodes, 0) });
                }
            }
        }
        self.copy_to_corners();
    }

    /// Copies the state to segments outside other open boundaries from the segment next to them.
    pub(super) fn copy_to_corners(&mut self) {
        for number in 0..self.strips.len() {
            let own = self.strip_with_state(number);
            if own == number {
                continue;
            }
            let mut strip = self.strips[own].clone();
            let along = self.spacing * (number as f64 - own as f64);
            for node in strip.template_nodes.iter_mut().flatten() {
                node.position[1 - self.axis] += along;
            }
            self.strips[number] = strip;
        }
    }

    /// Whether the boundary has inflow.
    pub fn has_inlet(&self) -> bool {
        self.inlet.is_some()
    }

    /// Distance inside the boundary at which the arriving flow is sampled (m).
    pub(super) fn search_distance(&self) -> f64 {
        PROBE_SUPPORTS * self.node_extent / FAR_FIELD_SUPPORTS
    }

    /// Width of the zone with nodes outside the boundary (m).
    pub(super) fn node_extent(&self) -> f64 {
        self.node_extent
    }

    /// Distance beyond the side (m).
    pub(super) fn distance_beyond(&self, x: &PlanVector<D>) -> f64 {
        self.outward * (x[self.axis] - self.coordinate)
    }

    /// Index of the boundary segment at a position.
    pub(super) fn strip(&self, x: &PlanVector<D>) -> usize {
        if D == 1 {
            return 0;
        }
        let along = ((x[1 - self.axis] - self.low) / self.spacing).floor().max(0.0) as usize;
        along.min(self.strips.len() - 1)
    }

    /// Segment whose state applies: the next one for segments in a corner.
    pub(super) fn strip_with_state(&self, strip: usize) -> usize {
        strip.clamp(self.corner_strips[0], self.strips.len() - 1 - self.corner_strips[1])
    }

    /// State at a distance outside a segment (m).
    pub(super) fn state_beyond(&self, strip: usize, beyond: f64) -> BoundaryState {
        let known = &self.state.strips[self.strip_with_state(strip)];
        if let Some(fixed) = known.prescribed {
            return fixed;
        }
        if let (Some(flow_layer), Some(both)) = (&self.flow_layer, &known.layers) {
            return flow_layer.state_beyond(both, beyond);
        }
        let still = self.strips[strip].far_state.as_ref();
        // In plan waves may come at an angle, for which delays along the normal are wrong.
        let there = |within: InteriorFit| {
            if D == 1 {
                known.history.state_beyond(still, beyond)
            } else {
                within.state_beyond(still, beyond)
            }
        };
        known.interior_fit.map_or(BoundaryState::default(), there)
    }

    /// Velocity in plan of a state.
    pub(super) fn velocity(&self, state: &BoundaryState) -> PlanVector<D> {
        std::array::from_fn(
            |c| if c == self.axis { self.outward * state.speed } else { state.tangential_speed },
        )
    }

    /// Counts the volume that has crossed the boundary since the last call. Returns set and index of the nodes that have entered.
    pub(super) fn count_crossings(
        &mut self,
        sets: &[PhaseSet<D>],
        region: &dyn Fn(&PlanVector<D>) -> SideRegion,
    ) -> Vec<(usize, usize)> {
        let (mut ids, mut entered) = (Vec::new(), Vec::new());
        for (number, set) in self.own_sets(sets) {
            let nodes = &set.nodes;
            for i in 0..nodes.len() {
                let is_beyond = region(&nodes.position[i]) == SideRegion::Outside;
                let was = self.state.ids.binary_search(&nodes.id[i]).is_ok();
                if is_beyond != was {
                    self.state.outflow[number] += if is_beyond { nodes.volume[i] } else { -nodes.volume[i] };
                }
                if was && !is_beyond {
                    entered.push((number, i));
                }
                if is_beyond {
                    ids.push(nodes.id[i]);
                }
            }
        }
        ids.sort_unstable();
        self.state.ids = ids;
        entered
    }

    /// Sets depth and velocity of the nodes outside the boundary, for a node set. Returns the distance of the outermost node of each
    /// segment (m), and the numbers of nodes that are no longer needed.
    pub(super) fn set_far_field_nodes(
        &mut self,
        nodes: &mut PhaseNodes<D>,
        (sets, number): (usize, usize),
        region: &dyn Fn(&PlanVector<D>) -> SideRegion,
    ) -> (Vec<f64>, Vec<u64>) {
        let (mut removed, mut farthest) = (Vec::new(), vec![-0.5 * self.spacing; self.strips.len()]);
        for i in 0..nodes.len() {
            let x = nodes.position[i];
            let (beyond, strip) = (self.distance_beyond(&x), self.strip(&x));
            match region(&x) {
                SideRegion::OutsideOther => continue,
                SideRegion::Interior => {
                    farthest[strip] = f64::max(farthest[strip], beyond);
                    continue;
                }
                SideRegion::Outside => {}
            }
            let state = self.state_beyond(strip, beyond);
            if state.depth <= 0.0 || beyond > self.node_extent + self.spacing {
                removed.push(nodes.id[i]);
                continue;
            }
            farthest[strip] = f64::max(farthest[strip], beyond);
            // Where it was dry outside, the flow goes on with its volume, however close its nodes have come.
            if !self.is_dry_outside(strip) {
                nodes.volume[i] =
                    self.depth_share(&state, sets, number) * state.depth * self.strips[strip].width;
            }
            nodes.velocity[i] = self.velocity(&state);
        }
        removed.sort_unstable();
        self.state.ids.retain(|id| removed.binary_search(id).is_err());
        (farthest, removed)
    }

    /// Adds nodes outside the boundary from the outermost node of each segment up to the width of the zone, for a node set.
    pub(super) fn add_far_field_nodes(
        &mut self,
        set: &mut PhaseSet<D>,
        (sets, number): (usize, usize),
        farthest: &[f64],
        next_id: &mut u64,
    ) {
        let mut places = OccupiedPlaces::default();
        let share = |side: &Self, state: &BoundaryState| side.depth_share(state, sets, number);
        for (strip, last) in farthest.iter().enumerate() {
            let Some(like) = self.strips[strip].template_nodes[number] else { continue };
            let mut beyond = *last;
            while beyond + self.spacing <= self.node_extent {
                beyond += self.spacing;
                let state = self.state_beyond(strip, beyond);
                if state.depth <= 0.0 {
                    break;
                }
                let mut node = NewNode {
                    velocity: self.velocity(&state),
                    volume: share(self, &state) * state.depth * self.strips[strip].width,
                    ..like
                };
                node.position[self.axis] = self.outward * beyond + self.coordinate;
                if D > 1 && places.is_occupied(&set.nodes, &node.position, MIN_NODE_DISTANCE * self.spacing) {
                    continue;
                }
                set.nodes.push(*next_id, &node);
                // The node has a height before the next sum.
                let height = share(self, &state) * state.depth;
                if let (Some(own), Some(whole)) =
                    (set.nodes.partial_thickness.last_mut(), set.nodes.depth.last_mut())
                {
                    (*own, *whole) = (height, state.depth);
                }
                set.clear_lists();
                self.state.ids.push(*next_id);
                *next_id += 1;
            }
        }
        self.state.ids.sort_unstable();
    }

    /// Computes the boundary state at a time (s); before the first step it is the far-field state, and `None` if the boundary is dry.
    pub(super) fn find_state(
        &mut self,
        settings: &FlowSettings<D>,
        sets: &[PhaseSet<D>],
        region: &dyn Fn(&PlanVector<D>) -> SideRegion,
        (time, dt, is_first): (f64, f64, bool),
    ) {
        let gravity = settings.gravity;
        if is_first {
            for (known, strip) in self.state.strips.iter_mut().zip(&self.strips) {
                *known = StripState { prescribed: strip.far_state, ..StripState::default() };
            }
        } else {
            let kernel = settings.numerics.kernel;
            let found = self.fit_interior(kernel, sets, region, 0.0);
            let inside = self.search_distance();
            let arriving = if D == 1 && !self.has_inlet() && self.flow_layer.is_none() {
                self.fit_interior(kernel, sets, region, inside)
            } else {
                vec![None; found.len()]
            };
            for ((known, within), arriving) in self.state.strips.iter_mut().zip(found).zip(arriving) {
                (known.prescribed, known.interior_fit) = (None, within);
                match arriving.or(within) {
                    Some(arriving) if D == 1 && self.flow_layer.is_none() => {
                        known.history.record((time, dt), &arriving, inside, self.node_extent);
                    }
                    _ => known.history = ArrivalHistory::default(),
                }
            }
        }
        self.average_tangential_speed();
        let time = self.discharge_time(time, sets.len());
        let Some(inlet) = &self.inlet else { return };
        for known in &mut self.state.strips {
            let here =
                known.interior_fit.map(|within| (within.depth[0], within.speed[0], within.effective_gravity));
            let here = here.or(known.prescribed.map(|still| (still.depth, still.speed, gravity)));
            let effective_gravity = here.map_or(gravity, |(.., effective_gravity)| effective_gravity);
            let arriving = here.map(|(depth, speed, effective_gravity)| {
                ArrivingFlow::from_depth_and_speed(depth, speed, effective_gravity)
            });
            // The Froude number of a layer is that of its own depth, whatever lies on it.
            let effective_gravity = if self.flow_layer.is_some() { gravity } else { effective_gravity };
            known.prescribed = Some(inlet.state(time, arriving, effective_gravity));
        }
    }
}

/// Whether a boundary of this layer, or of all material, belongs to a node set.
fn is_of(flow_layer: Option<LayerOfSide>, number: usize) -> bool {
    flow_layer.is_none_or(|flow_layer| flow_layer.set == number)
}

/// Template for nodes outside the boundary, from node `i`.
fn template_node<const D: usize>(nodes: &PhaseNodes<D>, i: usize) -> NewNode<D> {
    NewNode {
        body: nodes.body[i],
        position: nodes.position[i],
        velocity: nodes.velocity[i],
        volume: nodes.volume[i],
        length: nodes.first_length[i],
        scale: nodes.scale[i],
    }
}

/// Positions of nodes, for distance checks of added ones: the initial nodes in cells, and the nodes added since.
#[derive(Default)]
struct OccupiedPlaces<const D: usize> {
    /// None before the first search, and of positions that are not finite, which the next search reports.
    cells: Option<CellList<D>>,
    /// Number of nodes in cells.
    count: usize,
}

impl<const D: usize> OccupiedPlaces<D> {
    /// Whether a node is within `distance` (m) of a position.
    fn is_occupied(&mut self, nodes: &PhaseNodes<D>, x: &PlanVector<D>, distance: f64) -> bool {
        if self.cells.is_none() {
            let mut cells = CellList::new();
            // The edge is several distances, so that there are fewer cells than nodes.
            if cells.build(&nodes.position, 4.0 * distance).is_ok() {
                (self.cells, self.count) = (Some(cells), nodes.len());
            }
        }
        let is_near = |y: &PlanVector<D>| -> bool {
            (0..D).map(|c| (x[c] - y[c]).powi(2)).sum::<f64>() < distance * distance
        };
        let mut taken = nodes.position[self.count..].iter().any(is_near);
        if let Some(cells) = &self.cells {
            cells.visit_within(x, distance, |i| taken |= is_near(&nodes.position[i as usize]));
        }
        taken
    }
}
