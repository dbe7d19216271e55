//! Step 10: nodes of inflows (sheet: depth-sph §3.4).

use crate::boundary::FlowBoundaries;
use crate::boundary::open::{LayerOfSide, LineFitSums};
use crate::config::settings::FlowSettings;
use crate::flow_nodes::FlowNodes;
use crate::inflow::{ArrivingFlow, Inflow, WaitingNodes};
use crate::phases::failure::FlowFailure;
use crate::phases::phase::PhaseSet;
use colluvium_case::FailureReason;

/// Distance from an inflow line within which the initial flow is sampled, in distances of nodes.
const SAMPLING_DISTANCE: f64 = 2.0;

/// Ratio of the depth at an inflow line to that at the largest discharge, or at the start, above which the run ends with an error.
pub(crate) const MAX_DEPTH_RATIO: f64 = 100.0;

/// Flow that arrives at each inflow line; `None` for a dry line.
type ArrivingFlows = Vec<Option<ArrivingFlow>>;

/// Moves the rows of nodes behind the inflow lines to their positions at `time` (s), and adds new rows.
///
/// # Errors
/// When an inflow would be [`MAX_DEPTH_RATIO`] times too deep.
pub(crate) fn update_inflow_nodes<const D: usize>(
    settings: &FlowSettings<D>,
    time: f64,
    boundary: &mut FlowBoundaries<D>,
    nodes: &mut FlowNodes<D>,
) -> Result<(), FlowFailure> {
    if boundary.inflows.is_empty() {
        return Ok(());
    }
    let arriving: ArrivingFlows =
        boundary.inflows.iter().map(|inflow| arriving_flow(settings, &nodes.sets, inflow)).collect();
    advance_rows(time, &mut boundary.inflows, &arriving, nodes)?;
    place_waiting_nodes(time, boundary, nodes);
    Ok(())
}

/// Adds the first rows behind inflow lines that have flow next to them, before the first step. `initial` is the result of
/// [`initial_state_at_inflow`] for each line.
///
/// # Errors
/// Those of [`update_inflow_nodes`].
pub(crate) fn add_first_rows<const D: usize>(
    settings: &FlowSettings<D>,
    time: f64,
    boundary: &mut FlowBoundaries<D>,
    nodes: &mut FlowNodes<D>,
    initial: &[Option<(f64, f64)>],
) -> Result<(), FlowFailure> {
    let gravity = settings.gravity;
    let arriving = |found: &Option<(f64, f64)>| {
        found.map(|(depth, speed)| ArrivingFlow::from_depth_and_speed(depth, speed, gravity))
    };
    let arriving: ArrivingFlows = initial.iter().map(arriving).collect();
    advance_rows(time, &mut boundary.inflows, &arriving, nodes)?;
    place_waiting_nodes(time, boundary, nodes);
    Ok(())
}

/// Flow that arrives at an inflow line, from the nodes within the kernel support; `None` if it is dry. The flow consists of waves normal to
/// the line, with one state for the whole line (sheet: depth-sph §3.9).
fn arriving_flow<const D: usize>(
    settings: &FlowSettings<D>,
    sets: &[PhaseSet<D>],
    inflow: &Inflow<D>,
) -> Option<ArrivingFlow> {
    let kernel = settings.numerics.kernel;
    let (mut moments, width) = (LineFitSums::default(), inflow.width());
    let densities = &settings.material.densities;
    let layer = inflow.layer.map(|set| LayerOfSide { set, ratio: densities.fluid / densities.grain });
    for PhaseSet { nodes, .. } in sets_of_inflow(sets, inflow) {
        let depths = if layer.is_some() { &nodes.partial_thickness } else { &nodes.depth };
        for i in 0..nodes.len() {
            let (before, along) = inflow.distances(&nodes.position[i]);
            let far = before / nodes.length[i];
            if !(0.0..kernel.support()).contains(&far) || !(0.0..=width).contains(&along) {
                continue;
            }
            let weight = nodes.volume[i] / depths[i] * kernel.profile::<D>(far);
            if weight > 0.0 {
                let velocity = inflow.outward_and_tangential(&nodes.velocity[i]);
                let gravity = layer.map_or(nodes.effective_gravity[i], |layer| layer.wave_gravity(nodes, i));
                let reach = kernel.support() * nodes.length[i];
                moments.add(weight, -before, velocity, depths[i], gravity, reach);
            }
        }
    }
    let within = moments.interior_fit()?;
    Some(ArrivingFlow::from_depth_and_speed(within.depth[0], within.speed[0], within.effective_gravity))
}

/// Sets with nodes of an inflow.
fn sets_of_inflow<'a, const D: usize>(
    sets: &'a [PhaseSet<D>],
    inflow: &'a Inflow<D>,
) -> impl Iterator<Item = &'a PhaseSet<D>> {
    sets.iter().enumerate().filter(|(number, _)| inflow.is_of(*number)).map(|(_, set)| set)
}

/// Mean initial depth (m) and speed away from the line (m/s) of the flow next to an inflow line; `None` if it is dry there.
pub(crate) fn initial_state_at_inflow<const D: usize>(
    sets: &[PhaseSet<D>],
    inflow: &Inflow<D>,
) -> Option<(f64, f64)> {
    let (width, near) = (inflow.width(), SAMPLING_DISTANCE * inflow.spacing);
    let (mut volume, mut moved, mut count) = (0.0, 0.0, 0);
    for (number, PhaseSet { nodes, .. }) in sets_of_inflow(sets, inflow).enumerate() {
        for i in 0..nodes.len() {
            let (before, along) = inflow.distances(&nodes.position[i]);
            if (0.0..near).contains(&before) && (0.0..=width).contains(&along) {
                volume += nodes.volume[i];
                moved += nodes.volume[i] * inflow.outward_and_tangential(&nodes.velocity[i])[0];
                count += usize::from(number == 0);
            }
        }
    }
    let area = count as f64 * inflow.spacing.powi(D as i32);
    (count > 0).then(|| (volume / area, moved / volume))
}

/// Number of nodes that lie where the rows of an inflow line are to be placed.
pub(crate) fn count_nodes_behind<const D: usize>(sets: &[PhaseSet<D>], inflow: &Inflow<D>) -> usize {
    let is_behind = |x: &_| {
        let (before, along) = inflow.distances(x);
        (-inflow.row_extent..0.0).contains(&before) && (0.0..=inflow.width()).contains(&along)
    };
    sets_of_inflow(sets, inflow).flat_map(|set| &set.nodes.position).filter(|x| is_behind(x)).count()
}

/// Adds rows of nodes behind the inflow lines, and removes rows that are no longer needed.
fn advance_rows<const D: usize>(
    time: f64,
    inflows: &mut [Inflow<D>],
    arriving: &[Option<ArrivingFlow>],
    nodes: &mut FlowNodes<D>,
) -> Result<(), FlowFailure> {
    let mut removed = Vec::new();
    for (inflow, arriving) in inflows.iter_mut().zip(arriving) {
        let section = inflow.section(inflow.discharge(time), *arriving);
        // The number of rows grows with the depth. The depth at the largest discharge is computed only above `MAX_DEPTH_RATIO` mean
        // depths.
        let deepest = section.max_depth;
        let is_bounded = deepest <= MAX_DEPTH_RATIO * inflow.depth
            || deepest <= MAX_DEPTH_RATIO * inflow.max_section().max_depth;
        if !is_bounded {
            let reason = FailureReason::coded(
                "flow-too-fast",
                format!(
                    "the inflow across the line that begins here would be {deepest:.3e} m deep, more than \
                 {MAX_DEPTH_RATIO} times its depth at the largest discharge, because of the flow ahead of the \
                 line: reduce `courant` or `spacing`"
                ),
            );
            return Err(FlowFailure { node_id: nodes.next_id, position: inflow.start.to_vec(), reason });
        }
        let (fresh, stale) = inflow.advance(time, section, &mut nodes.next_id);
        removed.extend(stale);
        for (set, id, node) in &fresh {
            let PhaseSet { nodes: own, .. } = &mut nodes.sets[*set];
            own.push(*id, node);
            // Friction and XSPH divide by the height before the next sum.
            if let Some(height) = own.partial_thickness.last_mut() {
                *height = inflow.height(node.volume);
            }
            nodes.sets[*set].clear_lists();
            if *set == 0 {
                nodes.pore_columns.push();
            }
        }
    }
    removed.sort_unstable();
    if !removed.is_empty() {
        nodes.remove_where(|nodes, i| removed.binary_search(&nodes.id[i]).is_ok());
    }
    Ok(())
}

/// Sets positions and velocities of the nodes behind the inflow lines at `time` (s).
fn place_waiting_nodes<const D: usize>(
    time: f64,
    boundary: &mut FlowBoundaries<D>,
    nodes: &mut FlowNodes<D>,
) {
    let FlowBoundaries { inflows, waiting_nodes, .. } = boundary;
    waiting_nodes.nodes = inflows.iter().flat_map(|inflow| inflow.waiting_nodes(time)).collect();
    waiting_nodes.nodes.sort_by_key(|node| node.0);
    for PhaseSet { nodes, .. } in &mut nodes.sets {
        for i in 0..nodes.len() {
            if let Some((place, velocity)) = waiting_nodes.position_and_velocity(nodes.id[i]) {
                (nodes.position[i], nodes.velocity[i]) = (place, velocity);
            }
        }
    }
}

/// Resets the pore-pressure columns of nodes behind the inflow lines, so that they start with the depth at which the node enters.
pub(crate) fn reset_inflow_columns<const D: usize>(boundary: &FlowBoundaries<D>, nodes: &mut FlowNodes<D>) {
    if nodes.pore_columns.is_empty() {
        return;
    }
    for i in 0..nodes.sets[0].len() {
        let id = nodes.sets[0].nodes.id[i];
        if boundary.waiting_nodes.position_and_velocity(id).is_some() || boundary.is_inlet_node(id) {
            nodes.pore_columns.depth[i] = f64::NAN;
        }
    }
}

impl<const D: usize> FlowBoundaries<D> {
    /// Restores the prescribed velocities of the nodes behind the inflow lines.
    pub(super) fn hold_waiting_velocities(&self, sets: &mut [PhaseSet<D>]) {
        let WaitingNodes { nodes: waiting } = &self.waiting_nodes;
        if waiting.is_empty() {
            return;
        }
        for PhaseSet { nodes, .. } in sets {
            for i in 0..nodes.len() {
                if let Some((_, velocity)) = self.waiting_nodes.position_and_velocity(nodes.id[i]) {
                    nodes.velocity[i] = velocity;
                }
            }
        }
    }
}
