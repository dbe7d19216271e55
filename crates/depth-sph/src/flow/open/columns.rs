//! Columns of pore pressure beyond open sides (sheet: depth-sph §2.7, §3.9).
//!
//! What passes a side takes its columns with it, and brings back what is left of them. Near the end of what stands beyond a side sums of
//! depth lack neighbours, and would load columns by depths that are none: there they are those of the last nodes before, in shares of
//! their depths, and so are those of new nodes. The material out there thus drains as that at the side does.

use super::super::{Flow, Heads};
use super::side::{OpenEnd, Part};
use super::{SUPPORTS, part_of};
use crate::nodes::{Nodes, Plan};

impl<const D: usize> OpenEnd<D> {
    /// The node of each strip that stands farthest out, `limit` (m) beyond the side at most; of a strip without one that of the nearest which
    /// has one.
    fn last_before(
        &self,
        nodes: &Nodes<D>,
        heads: &Heads,
        limit: f64,
        part: &dyn Fn(&Plan<D>) -> Part,
    ) -> Vec<Option<usize>> {
        let mut last: Vec<Option<(f64, usize)>> = vec![None; self.strips.len()];
        for (i, x) in nodes.position.iter().enumerate() {
            let beyond = self.beyond(x);
            let has_column = heads.depth[i] > 0.0;
            if !has_column || beyond > limit || beyond < -self.reach() || part(x) == Part::Elsewhere {
                continue;
            }
            let entry = &mut last[self.strip(x)];
            // Of equal ones the first by number, whatever the order of the nodes.
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

impl Heads {
    /// Gives node `i`, so deep (m), the column of node `from` in shares of its depth (m).
    fn take_after(&mut self, i: usize, depth: f64, from: usize) {
        let (before, width) = (self.depth[from], self.width);
        for k in 0..width {
            self.values[i * width + k] = self.values[from * width + k] / before * depth;
        }
        self.depth[i] = depth;
    }
}

impl<const D: usize> Flow<D> {
    /// Columns of nodes so near to the end of what stands beyond open sides that sums lack neighbours there.
    pub(super) fn follow_columns(&mut self) {
        self.copy_columns(1.0 - 1.0 / SUPPORTS);
    }

    /// Columns of all nodes beyond open sides when the flow begins.
    pub(in super::super) fn begin_columns(&mut self) {
        self.copy_columns(0.0);
    }

    /// Gives nodes that stand farther beyond sides than this share of the reach of what stands there the columns of the last ones before.
    fn copy_columns(&mut self, share: f64) {
        if self.heads.is_empty() || self.opens.iter().all(OpenEnd::is_fed) {
            return;
        }
        let sides = self.sides();
        let Self { sets, heads, opens, .. } = self;
        let nodes = &sets[0].nodes;
        for (number, end) in opens.iter().enumerate().filter(|(_, end)| !end.is_fed() && end.is_of(0)) {
            let part = |x: &Plan<D>| part_of(&sides, number, x);
            let limit = share * end.reach();
            let last = end.last_before(nodes, heads, limit, &part);
            for (i, x) in nodes.position.iter().enumerate() {
                if (end.beyond(x) > limit || heads.depth[i].is_nan())
                    && part(x) == Part::Beyond
                    && let Some(from) = last[end.strip(x)]
                {
                    heads.take_after(i, nodes.depth[i], from);
                }
            }
        }
    }
}
