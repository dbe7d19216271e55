//! Columns of pore pressure beyond open sides (sheet: depth-sph §2.7, §3.9).
//!
//! Flow that passes a side takes its columns with it, and on return brings back their remaining pressure. Near the outer end of the nodes
//! sums of depth lack neighbours, and would load columns by wrong depths: there columns are those of the last nodes before, in shares of
//! their depths, and so are those of new nodes. The material outside thus drains as that at the side does.

use crate::boundary::open::open_boundary::{OpenBoundary, SideRegion};
use crate::boundary::open::{FAR_FIELD_SUPPORTS, open_sides, region_of};
use crate::flow_nodes::FlowNodes;
use crate::points::phase_nodes::{PhaseNodes, PlanVector};
use crate::pore_pressure::pore_pressure_columns::PorePressureColumns;

impl<const D: usize> OpenBoundary<D> {
    /// Outermost node of each segment, at most `limit` outside the boundary (m). A segment without nodes has that of the nearest segment.
    fn last_before(
        &self,
        nodes: &PhaseNodes<D>,
        columns: &PorePressureColumns,
        limit: f64,
        region: &dyn Fn(&PlanVector<D>) -> SideRegion,
    ) -> Vec<Option<usize>> {
        let mut last: Vec<Option<(f64, usize)>> = vec![None; self.strips.len()];
        for (i, x) in nodes.position.iter().enumerate() {
            let beyond = self.distance_beyond(x);
            let has_column = columns.depth[i] > 0.0;
            if !has_column
                || beyond > limit
                || beyond < -self.node_extent()
                || region(x) == SideRegion::OutsideOther
            {
                continue;
            }
            let entry = &mut last[self.strip(x)];
            // Of nodes at equal distance the first by number, whatever the order of the nodes.
            let is_last = |(other, k): &(f64, usize)| {
                beyond > *other || (beyond == *other && nodes.id[i] < nodes.id[*k])
            };
            if entry.as_ref().is_none_or(is_last) {
                *entry = Some((beyond, i));
            }
        }
        let count = last.len();
        let nearest = |strip: usize| {
            if last[strip].is_some() {
                return Some(strip);
            }
            let apart = |other: &usize| other.abs_diff(strip);
            (0..count).filter(|other| last[*other].is_some()).min_by_key(apart)
        };
        (0..count).map(|strip| nearest(strip).and_then(|own| last[own]).map(|(_, i)| i)).collect()
    }
}

impl PorePressureColumns {
    /// Sets the pore-pressure column of a node to that of node `from`, scaled to its depth (m).
    fn copy_column(&mut self, i: usize, depth: f64, from: usize) {
        let (before, width) = (self.depth[from], self.width);
        for k in 0..width {
            self.heads[i * width + k] = self.heads[from * width + k] / before * depth;
        }
        self.depth[i] = depth;
    }
}

/// Updates the pore-pressure columns of nodes near the outer edge of the zone, whose kernel sums lack neighbours.
pub(super) fn update_far_field_columns<const D: usize>(open: &[OpenBoundary<D>], nodes: &mut FlowNodes<D>) {
    copy_columns(open, nodes, 1.0 - 1.0 / FAR_FIELD_SUPPORTS);
}

/// Sets the initial pore-pressure columns of all nodes outside open boundaries.
pub(crate) fn initialise_far_field_columns<const D: usize>(
    open: &[OpenBoundary<D>],
    nodes: &mut FlowNodes<D>,
) {
    copy_columns(open, nodes, 0.0);
}

/// Copies pore-pressure columns to the nodes outside boundaries that are farther out than a share of the width of the zone, from the
/// outermost nodes closer in.
fn copy_columns<const D: usize>(open: &[OpenBoundary<D>], nodes: &mut FlowNodes<D>, share: f64) {
    if nodes.pore_columns.is_empty() || open.iter().all(OpenBoundary::has_inlet) {
        return;
    }
    let sides = open_sides(open);
    let FlowNodes { sets, pore_columns, .. } = nodes;
    let nodes = &sets[0].nodes;
    for (number, end) in open.iter().enumerate().filter(|(_, end)| !end.has_inlet() && end.is_of(0)) {
        let region = |x: &PlanVector<D>| region_of(&sides, number, x);
        let limit = share * end.node_extent();
        let last = end.last_before(nodes, pore_columns, limit, &region);
        for (i, x) in nodes.position.iter().enumerate() {
            if (end.distance_beyond(x) > limit || pore_columns.depth[i].is_nan())
                && region(x) == SideRegion::Outside
                && let Some(from) = last[end.strip(x)]
            {
                pore_columns.copy_column(i, nodes.depth[i], from);
            }
        }
    }
}
