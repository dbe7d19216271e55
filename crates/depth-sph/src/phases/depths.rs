//! Steps 1 and 2: neighbours, heights, total depths and porosities (sheet: depth-sph §3.4).

use crate::config::choices::Phases;
use crate::config::settings::{FlowSettings, Numerics};
use crate::phases::failure::FlowFailure;
use crate::phases::limits::FlowLimits;
use crate::phases::node_checks::check_numbers;
use crate::phases::phase::PhaseSet;
use crate::points::image_nodes::{PlanBoundaries, copy_with_images};
use crate::points::phase_nodes::PlanVector;

/// Lists neighbours and computes heights and smoothing lengths from them.
///
/// # Errors
/// The first node that a neighbour search cannot locate.
pub fn find_heights<const D: usize>(
    settings: &FlowSettings<D>,
    walls: &PlanBoundaries<D>,
    sets: &mut [PhaseSet<D>],
) -> Result<(), FlowFailure> {
    find_neighbours(settings, walls, sets)?;
    repeat_thickness_sum(&settings.numerics, sets);
    Ok(())
}

/// Step 1: finds neighbours and images at the positions of the nodes.
///
/// # Errors
/// The first node that a neighbour search cannot locate.
pub fn find_neighbours<const D: usize>(
    settings: &FlowSettings<D>,
    walls: &PlanBoundaries<D>,
    sets: &mut [PhaseSet<D>],
) -> Result<(), FlowFailure> {
    check_numbers(sets)?;
    let support = settings.numerics.kernel.support();
    let lists = settings.needs_neighbour_list();
    if lists && sets.iter().all(|set| set.is_listed(support)) {
        sets.iter_mut().for_each(PhaseSet::place_images);
    } else {
        sets.iter_mut().for_each(|set| set.make_images(walls, support));
        if lists {
            list_neighbours(sets, support)?;
        }
    }
    let search = settings.numerics.search;
    for set in sets {
        set.pack(support, search).map_err(|error| FlowFailure::of_search(set, &error))?;
    }
    Ok(())
}

/// Makes the images and lists of neighbours again that were made at `listed`: positions (m) and smoothing lengths (m) of the nodes of each
/// set, which may have moved since. The cells of later sums, and with them the order of these sums, depend on the images.
///
/// # Errors
/// The first node that a neighbour search cannot locate.
pub fn remake_lists<const D: usize>(
    settings: &FlowSettings<D>,
    walls: &PlanBoundaries<D>,
    sets: &mut [PhaseSet<D>],
    mut listed: Vec<Vec<(PlanVector<D>, f64)>>,
) -> Result<(), FlowFailure> {
    let support = settings.numerics.kernel.support();
    for (set, places) in sets.iter_mut().zip(&mut listed) {
        set.exchange_places(places);
        set.make_images_in_place(walls, support);
    }
    list_neighbours(sets, support)?;
    for (set, places) in sets.iter_mut().zip(&mut listed) {
        set.exchange_places(places);
        set.place_images();
    }
    Ok(())
}

/// Lists the neighbours of each node in its own and in the other phase.
fn list_neighbours<const D: usize>(sets: &mut [PhaseSet<D>], support: f64) -> Result<(), FlowFailure> {
    for set in &mut *sets {
        set.list_same_phase(support).map_err(|error| FlowFailure::of_search(set, &error))?;
    }
    if let [first, second] = sets {
        first
            .list_other_phase(&second.neighbour_data, support)
            .map_err(|error| FlowFailure::of_search(first, &error))?;
        second
            .list_other_phase(&first.neighbour_data, support)
            .map_err(|error| FlowFailure::of_search(second, &error))?;
    }
    Ok(())
}

/// Step 2: repeats the sum of heights.
pub fn repeat_thickness_sum<const D: usize>(numerics: &Numerics, sets: &mut [PhaseSet<D>]) {
    for set in sets {
        if numerics.continuity.is_rate() {
            set.update_smoothing_lengths(numerics);
        } else {
            set.sum_thickness(numerics);
        }
        set.update_image_thickness();
    }
}

/// Computes height of the other phase, total depth and porosity at each node.
pub fn find_depths<const D: usize>(
    settings: &FlowSettings<D>,
    limits: &FlowLimits,
    sets: &mut [PhaseSet<D>],
) {
    let (min_depth, phases) = (limits.min_partner_depth, settings.phases);
    let kernel = settings.numerics.kernel;
    let [first, second] = sets else {
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
            let mut partner = set.neighbour_data.partner_height[i];
            if own < min_depth || partner < min_depth {
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
