//! Snapshot of the nodes with their fields.

use colluvium_case::{FieldList, FrameRequest, Snapshot};
use colluvium_constitutive::SymTensor;

use crate::bed::BedPoint;
use crate::output::flow_view::FlowView;
use crate::phases::phase::PhaseSet;
use crate::points::phase_nodes::dot;

/// Vector along the bed: its plan components and the rise over a slope.
pub(super) fn along_bed<const D: usize>(v: &[f64; D], slope: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|c| match c.cmp(&D) {
        std::cmp::Ordering::Less => v[c],
        std::cmp::Ordering::Equal => dot(v, slope),
        std::cmp::Ordering::Greater => 0.0,
    })
}

/// Node set and index of each node, in the order of node numbers.
fn in_order<const D: usize>(sets: &[PhaseSet<D>]) -> Vec<(usize, usize)> {
    let numbered = sets.iter().enumerate();
    let mut order: Vec<(usize, usize)> =
        numbered.flat_map(|(set, nodes)| (0..nodes.len()).map(move |i| (set, i))).collect();
    order.sort_by_key(|&(set, i)| sets[set].nodes.id[i]);
    order
}

/// Nodes with the wanted fields, in the order of node numbers, at a time of the case (s).
pub(crate) fn snapshot<const D: usize>(
    flow: &FlowView<'_, D>,
    (time, step): (f64, u64),
    wanted: FrameRequest<'_>,
) -> Snapshot {
    let mut wanted_fields = FieldList::new(wanted);
    let order = in_order(flow.sets());
    let nodes = |set: usize| &flow.sets()[set].nodes;
    let beds: Vec<_> = order.iter().map(|&(set, i)| flow.bed.bed_below(&nodes(set).position[i])).collect();
    let place = |(&(set, i), level): (&(usize, usize), f64)| {
        let x = &nodes(set).position[i];
        std::array::from_fn(|c| match c.cmp(&D) {
            std::cmp::Ordering::Less => x[c],
            std::cmp::Ordering::Equal => level + 0.5 * nodes(set).depth[i],
            std::cmp::Ordering::Greater => 0.0,
        })
    };
    let extent = |&(set, i): &(usize, usize)| -> [f64; 3] {
        let width = (nodes(set).volume[i] / nodes(set).partial_thickness[i]).powf(1.0 / D as f64);
        std::array::from_fn(|c| match c.cmp(&D) {
            std::cmp::Ordering::Less => width,
            std::cmp::Ordering::Equal => nodes(set).depth[i],
            std::cmp::Ordering::Greater => 0.0,
        })
    };
    add_fields(flow, &order, &beds, &mut wanted_fields);
    Snapshot {
        time,
        step,
        ids: order.iter().map(|&(set, i)| nodes(set).id[i]).collect(),
        bodies: order.iter().map(|&(set, i)| nodes(set).body[i]).collect(),
        positions: order.iter().zip(beds.iter().map(|bed| bed.level)).map(place).collect(),
        extents: order.iter().map(extent).collect(),
        fields: wanted_fields.into_fields(),
    }
}

/// Adds the fields of the nodes in the given order; `beds` are the bed points below them.
fn add_fields<const D: usize>(
    flow: &FlowView<'_, D>,
    order: &[(usize, usize)],
    beds: &[BedPoint<D>],
    fields: &mut FieldList<'_>,
) {
    let nodes = |set: usize| &flow.sets()[set].nodes;
    let each = |value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        order.iter().map(|&(set, i)| value(set, i)).collect()
    };
    let stress = |&(set, i): &(usize, usize)| {
        // Half of the pressure at the base: the mean over the depth, taken isotropic.
        let mean = -0.5
            * flow.sets()[set].flow_density(flow.settings, (flow.sets().len(), set), i)
            * nodes(set).effective_gravity[i]
            * nodes(set).depth[i];
        SymTensor([mean, mean, mean, 0.0, 0.0, 0.0])
    };
    let velocity =
        |(&(set, i), bed): (&(usize, usize), &BedPoint<D>)| along_bed(&nodes(set).velocity[i], &bed.slope);
    let displacement = |&(set, i): &(usize, usize)| {
        let (x, origin) = (&nodes(set).position[i], &nodes(set).origin[i]);
        let moved: [f64; D] = std::array::from_fn(|c| x[c] - origin[c]);
        along_bed(&moved, &[0.0; D])
    };
    fields.scalar("depth", "m", || each(&|set, i| nodes(set).depth[i]));
    fields.vector("velocity", "m/s", || order.iter().zip(beds).map(velocity).collect());
    fields.vector("displacement", "m", || order.iter().map(displacement).collect());
    fields.tensor("stress", "Pa", || order.iter().map(stress).collect());
    fields.scalar("mass", "kg", || each(&|set, i| flow.density(set) * nodes(set).volume[i]));
    fields.scalar("volume", "m3", || each(&|set, i| nodes(set).volume[i]));
    fields.scalar("bed", "m", || beds.iter().map(|bed| bed.level).collect());
    fields.scalar("smoothing_length", "m", || each(&|set, i| nodes(set).length[i]));
    if flow.sets().len() > 1 {
        fields.scalar("phase", "", || each(&|set, _| set as f64));
        fields.scalar("height", "m", || each(&|set, i| nodes(set).partial_thickness[i]));
    }
    add_pore_fields(flow, order, fields);
    if flow.boundary.has_openings() {
        let outside = |set: usize, i: usize| f64::from(u8::from(flow.boundary.is_outside(nodes(set).id[i])));
        fields.scalar("outside", "", || each(&outside));
    }
    if flow.has_erosion() {
        fields.scalar("eroded", "m3", || each(&|set, i| nodes(set).eroded_volume[i]));
    }
}

/// Adds the pore-pressure fields of the nodes in the given order, for a case with pore-pressure columns.
fn add_pore_fields<const D: usize>(
    flow: &FlowView<'_, D>,
    order: &[(usize, usize)],
    fields: &mut FieldList<'_>,
) {
    if flow.nodes.pore_columns.is_empty() {
        return;
    }
    let nodes = |set: usize| &flow.sets()[set].nodes;
    let each = |value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        order.iter().map(|&(set, i)| value(set, i)).collect()
    };
    let head = |set: usize, i: usize| if set == 0 { flow.nodes.pore_columns.base_head(i) } else { f64::NAN };
    let submerged = |set: usize, i: usize| flow.sets()[set].submerged_density(flow.settings, set, i);
    let excess = |set: usize, i: usize| submerged(set, i) * nodes(set).bed_gravity[i] * head(set, i);
    let mean = |set: usize, i: usize| {
        let head = if set == 0 { flow.nodes.pore_columns.mean(i) } else { f64::NAN };
        submerged(set, i) * nodes(set).bed_gravity[i] * head
    };
    let fluid = flow.settings.material.densities.fluid;
    let whole =
        |set: usize, i: usize| excess(set, i) + fluid * nodes(set).bed_gravity[i] * nodes(set).depth[i];
    fields.scalar("liquefaction", "", || each(&|set, i| head(set, i) / nodes(set).depth[i]));
    fields.scalar("excess_pore_pressure", "Pa", || each(&excess));
    fields.scalar("mean_excess_pore_pressure", "Pa", || each(&mean));
    fields.scalar("pore_pressure", "Pa", || each(&whole));
}
