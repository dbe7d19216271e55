//! Step 10: nodes that flow in (sheet: depth-sph §3.4).

use super::Flow;

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
            for (id, node) in &fresh {
                self.sets[0].nodes.push(*id, node);
            }
            if !fresh.is_empty() {
                self.sets[0].unlist();
            }
        }
        gone.sort_unstable();
        if !gone.is_empty() {
            self.remove_where(|nodes, i| gone.binary_search(&nodes.id[i]).is_ok());
        }
        self.held.nodes = self.inflows.iter().flat_map(|inflow| inflow.held(self.time)).collect();
        self.held.nodes.sort_by_key(|node| node.0);
        let nodes = &mut self.sets[0].nodes;
        for i in 0..nodes.len() {
            if let Some((place, velocity)) = self.held.of(nodes.id[i]) {
                (nodes.position[i], nodes.velocity[i]) = (place, velocity);
            }
        }
    }

    /// Nodes behind the lines keep their velocity, whatever acts on them.
    pub(super) fn hold(&mut self) {
        self.hold_beyond();
        if self.held.nodes.is_empty() {
            return;
        }
        let nodes = &mut self.sets[0].nodes;
        for i in 0..nodes.len() {
            if let Some((_, velocity)) = self.held.of(nodes.id[i]) {
                nodes.velocity[i] = velocity;
            }
        }
    }

    /// Volume that has flowed in (m³).
    pub fn entered(&self) -> f64 {
        let lines: f64 = self.inflows.iter().map(crate::inflow::Inflow::entered).sum();
        self.opens.iter().filter(|end| end.is_fed()).fold(lines, |sum, end| sum - end.state.passed)
    }

    /// Volume that has passed the open ends that nothing flows in through, less what has come back (m²).
    pub fn passed(&self) -> f64 {
        self.opens.iter().filter(|end| !end.is_fed()).map(|end| end.state.passed).sum()
    }

    /// Volume of the nodes that have not flowed in yet, and of those beyond open ends (m³).
    pub fn waiting(&self) -> f64 {
        let waiting: f64 = self.inflows.iter().map(crate::inflow::Inflow::waiting).sum();
        if self.opens.is_empty() { waiting } else { waiting + self.beyond() }
    }
}
