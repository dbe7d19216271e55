//! Step 10: material that enters and leaves, with its energy (sheet: depth-sph §3.4).

use colluvium_case::FailureReason;
use rayon::prelude::*;

use crate::bed::Bed;
use crate::boundary::inflow_nodes::update_inflow_nodes;
use crate::boundary::open::absorbing_layer::relax_absorbing_layers;
use crate::boundary::open::update_open_boundaries;
use crate::boundary::{FlowBoundaries, OutsideNodes};
use crate::clock::Clock;
use crate::config::settings::FlowSettings;
use crate::energy_balance::FlowRecords;
use crate::energy_balance::balance::{EnergyBalance, energies};
use crate::flow_nodes::FlowNodes;
use crate::phases::failure::FlowFailure;
use crate::points::MIN_NODES_PER_TASK;

/// Updates inflow lines and open boundaries at the beginning of a step of `dt` (s). Their energy is added to the balance.
///
/// # Errors
/// When an inflow would be too deep.
pub(super) fn update_openings<const D: usize>(
    clock: &Clock,
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    boundary: &mut FlowBoundaries<D>,
    nodes: &mut FlowNodes<D>,
    balance: &mut EnergyBalance,
    dt: f64,
) -> Result<(), FlowFailure> {
    if !boundary.has_openings() {
        return Ok(());
    }
    let before = energies(settings, bed, boundary, &nodes.sets);
    update_inflow_nodes(settings, clock.time, boundary, nodes)?;
    update_open_boundaries(settings, clock, &mut boundary.open_sides, nodes, dt);
    relax_absorbing_layers(&mut boundary.open_sides, &mut nodes.sets, dt);
    balance.add_inflow(&before, &energies(settings, bed, boundary, &nodes.sets));
    Ok(())
}

/// Removes the nodes that have left the bed.
///
/// # Errors
/// The first such node, where that is an error.
pub(super) fn remove_outside<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    boundary: &FlowBoundaries<D>,
    nodes: &mut FlowNodes<D>,
    records: &mut FlowRecords,
) -> Result<(), FlowFailure> {
    if bed.is_flat() {
        return Ok(());
    }
    for number in 0..nodes.sets.len() {
        let set = &nodes.sets[number];
        let is_out = |i: &usize| !bed.is_defined(&set.nodes.position[*i]);
        let out: Vec<usize> =
            (0..set.nodes.len()).into_par_iter().with_min_len(MIN_NODES_PER_TASK).filter(is_out).collect();
        let Some(first) = out.first() else { continue };
        if boundary.outside == OutsideNodes::Fail {
            let reason = "it has left the terrain, which is an error by `leaving_is_an_error`";
            return Err(FlowFailure::at_node(set, *first, FailureReason::LeftDomain(reason.to_owned())));
        }
        records.outflow_volume[number] += out.iter().map(|&i| set.nodes.volume[i]).sum::<f64>();
        records.removed_nodes += out.len() as u64;
        change_nodes_externally(settings, bed, boundary, nodes, &mut records.energy_balance, |nodes| {
            nodes.retain_nodes(number, |i| out.binary_search(&i).is_err());
        });
    }
    Ok(())
}

/// Adds, removes or resets nodes by the function `change`; the energy that they bring or take counts as inflow in the balance.
pub(super) fn change_nodes_externally<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    boundary: &FlowBoundaries<D>,
    nodes: &mut FlowNodes<D>,
    balance: &mut EnergyBalance,
    change: impl FnOnce(&mut FlowNodes<D>),
) {
    if !balance.has_started() {
        return change(nodes);
    }
    let before = energies(settings, bed, boundary, &nodes.sets).total();
    change(nodes);
    balance.add_external_change(before, energies(settings, bed, boundary, &nodes.sets).total());
}
