//! Snapshot of the nodes with their fields.

use colluvium_case::{Field, FieldData, Snapshot};
use colluvium_constitutive::SymTensor;

use crate::bed::BedPoint;
use crate::output::flow_view::FlowView;
use crate::phases::phase::PhaseSet;
use crate::points::phase_nodes::dot;

/// Scalar field of a snapshot.
fn scalar(name: &str, unit: &'static str, values: Vec<f64>) -> Field {
    Field { name: name.to_owned(), unit, data: FieldData::Scalar(values) }
}

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

/// Snapshot of all nodes, in the order of node numbers, at a time of the case (s).
pub(crate) fn snapshot<const D: usize>(flow: &FlowView<'_, D>, (time, step): (f64, u64)) -> Snapshot {
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
    Snapshot {
        time,
        step,
        ids: order.iter().map(|&(set, i)| nodes(set).id[i]).collect(),
        bodies: order.iter().map(|&(set, i)| nodes(set).body[i]).collect(),
        positions: order.iter().zip(beds.iter().map(|bed| bed.level)).map(place).collect(),
        extents: order.iter().map(extent).collect(),
        fields: fields(flow, &order, &beds),
    }
}

/// Fields of the nodes in the given order; `beds` are the bed points below them.
fn fields<const D: usize>(
    flow: &FlowView<'_, D>,
    order: &[(usize, usize)],
    beds: &[BedPoint<D>],
) -> Vec<Field> {
    let nodes = |set: usize| &flow.sets()[set].nodes;
    let each = |value: &dyn Fn(usize, usize) -> f64| order.iter().map(|&(set, i)| value(set, i)).collect();
    let stress = |&(set, i): &(usize, usize)| {
        // Half of the pressure at the base: the mean over the depth, taken isotropic.
        let mean = -0.5
            * flow.sets()[set].flow_density(flow.settings, (flow.sets().len(), set), i)
            * nodes(set).effective_gravity[i]
            * nodes(set).depth[i];
        SymTensor([mean, mean, mean, 0.0, 0.0, 0.0])
    };
    let velocity = order
        .iter()
        .zip(beds)
        .map(|(&(set, i), bed)| along_bed(&nodes(set).velocity[i], &bed.slope))
        .collect();
    let displacement = order
        .iter()
        .map(|&(set, i)| {
            let (x, origin) = (&nodes(set).position[i], &nodes(set).origin[i]);
            let moved: [f64; D] = std::array::from_fn(|c| x[c] - origin[c]);
            along_bed(&moved, &[0.0; D])
        })
        .collect();
    let stresses = order.iter().map(stress).collect();
    let mut fields = vec![
        scalar("depth", "m", each(&|set, i| nodes(set).depth[i])),
        Field { name: "velocity".into(), unit: "m/s", data: FieldData::Vector(velocity) },
        Field { name: "displacement".into(), unit: "m", data: FieldData::Vector(displacement) },
        Field { name: "stress".into(), unit: "Pa", data: FieldData::Tensor(stresses) },
        scalar("mass", "kg", each(&|set, i| flow.density(set) * nodes(set).volume[i])),
        scalar("volume", "m3", each(&|set, i| nodes(set).volume[i])),
        scalar("bed", "m", beds.iter().map(|bed| bed.level).collect()),
        scalar("smoothing_length", "m", each(&|set, i| nodes(set).length[i])),
    ];
    if flow.sets().len() > 1 {
        fields.push(scalar("phase", "", each(&|set, _| set as f64)));
        fields.push(scalar("height", "m", each(&|set, i| nodes(set).partial_thickness[i])));
    }
    fields.extend(fields_of_columns(flow, order));
    if flow.boundary.has_openings() {
        let outside = |set: usize, i: usize| f64::from(u8::from(flow.boundary.is_outside(nodes(set).id[i])));
        fields.push(scalar("outside", "", each(&outside)));
    }
    if flow.has_erosion() {
        fields.push(scalar("eroded", "m3", each(&|set, i| nodes(set).eroded_volume[i])));
    }
    fields
}

/// Pore-pressure fields of the nodes in the given order, for a case with pore-pressure columns.
fn fields_of_columns<const D: usize>(flow: &FlowView<'_, D>, order: &[(usize, usize)]) -> Vec<Field> {
    if flow.nodes.pore_columns.is_empty() {
        return Vec::new();
    }
    let nodes = |set: usize| &flow.sets()[set].nodes;
    let each = |value: &dyn Fn(usize, usize) -> f64| order.iter().map(|&(set, i)| value(set, i)).collect();
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
    vec![
        scalar("liquefaction", "", each(&|set, i| head(set, i) / nodes(set).depth[i])),
        scalar("excess_pore_pressure", "Pa", each(&excess)),
        scalar("mean_excess_pore_pressure", "Pa", each(&mean)),
        scalar("pore_pressure", "Pa", each(&whole)),
    ]
}
