//! Step 10: nodes that flow in (sheet: depth-sph §3.4).

use super::set::Set;
use super::{Flow, OpenEnd};
use crate::inflow::Inflow;

impl<const D: usize> Flow<D> {
    /// Brings the rows behind the lines of inflow to where they are now, with new ones behind them.
    pub(super) fn feed(&mut self) {
        if self.inflows.is_empty() {
            return;
        }
        let mut gone = Vec::new();
        for inflow in &mut self.inflows {
            let (fresh, stale) = inflow.advance(self.time, &mut self.next_id);
            gone.extend(stale);
            for (set, id, node) in &fresh {
                self.sets[*set].nodes.push(*id, node);
                self.sets[*set].unlist();
                if *set == 0 {
                    self.heads.push();
                }
            }
        }
        gone.sort_unstable();
        if !gone.is_empty() {
            self.remove_where(|nodes, i| gone.binary_search(&nodes.id[i]).is_ok());
        }
        self.held.nodes = self.inflows.iter().flat_map(|inflow| inflow.held(self.time)).collect();
        self.held.nodes.sort_by_key(|node| node.0);
        for Set { nodes, .. } in &mut self.sets {
            for i in 0..nodes.len() {
                if let Some((place, velocity)) = self.held.of(nodes.id[i]) {
                    (nodes.position[i], nodes.velocity[i]) = (place, velocity);
                }
            }
        }
    }

    /// Columns of pore pressure of what has not flowed in yet begin with the depth that they see when it does.
    pub(super) fn renew_columns(&mut self) {
        if self.heads.is_empty() {
            return;
        }
        for i in 0..self.sets[0].len() {
            let id = self.sets[0].nodes.id[i];
            if self.held.of(id).is_some() || self.is_beyond(id) {
                self.heads.depth[i] = f64::NAN;
            }
        }
    }

    /// Nodes behind the lines keep their velocity, whatever acts on them.
    pub(super) fn hold(&mut self) {
        self.hold_beyond();
        if self.held.nodes.is_empty() {
            return;
        }
        for Set { nodes, .. } in &mut self.sets {
            for i in 0..nodes.len() {
                if let Some((_, velocity)) = self.held.of(nodes.id[i]) {
                    nodes.velocity[i] = velocity;
                }
            }
        }
    }

    /// Volume that has flowed in (m³).
    pub fn entered(&self) -> f64 {
        let lines: f64 = self.inflows.iter().map(Inflow::entered).sum();
        let passed = |end: &OpenEnd<D>| end.state.passed.iter().sum::<f64>();
        self.opens.iter().filter(|end| end.is_fed()).fold(lines, |sum, end| sum - passed(end))
    }

    /// Volume of pore fluid, on nodes of its own, that has flowed in (m³).
    pub fn fluid_entered(&self) -> f64 {
        let of_line = |inflow: &Inflow<D>| inflow.porosity.unwrap_or(0.0) * inflow.entered();
        let lines: f64 = self.inflows.iter().map(of_line).sum();
        self.opens.iter().filter(|end| end.is_fed()).fold(lines, |sum, end| sum - end.state.passed[1])
    }

    /// Volume that has passed the open sides that nothing flows in through, less what has come back (m³).
    pub fn passed(&self) -> f64 {
        self.opens.iter().filter(|end| !end.is_fed()).flat_map(|end| end.state.passed).sum()
    }

    /// Volume of the nodes that have not flowed in yet, and of those beyond open ends (m³).
    pub fn waiting(&self) -> f64 {
        let waiting: f64 = self.inflows.iter().map(Inflow::waiting).sum();
        if self.opens.is_empty() { waiting } else { waiting + self.beyond() }
    }
}
