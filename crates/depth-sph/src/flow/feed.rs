//! Step 10: nodes that flow in (sheet: depth-sph §3.4).

use super::open::{Moments, Stratum};
use super::set::Set;
use super::{DEEPEST, Failure, Flow, OpenEnd};
use crate::inflow::{Arriving, Inflow};

/// How far before a line one looks for what stands there at the start (distances of nodes).
const NEAR: f64 = 2.0;

impl<const D: usize> Flow<D> {
    /// Brings the rows behind the lines of inflow to where they are now, with new ones behind them.
    ///
    /// # Errors
    /// When an inflow would be [`DEEPEST`] times too deep.
    pub(super) fn feed(&mut self) -> Result<(), Failure> {
        if self.inflows.is_empty() {
            return Ok(());
        }
        let arriving: Vec<_> = self.inflows.iter().map(|inflow| self.arriving(inflow)).collect();
        self.feed_with(&arriving)
    }

    /// What arrives at a line from the flow before it, as far as kernels reach; `None` where it is dry. Waves along its normal, and one state
    /// for all of the line (sheet: depth-sph §3.9).
    fn arriving(&self, inflow: &Inflow<D>) -> Option<Arriving> {
        let kernel = self.settings.numerics.kernel;
        let (mut moments, width) = (Moments::default(), inflow.width());
        let densities = &self.settings.material.densities;
        let stratum = inflow.layer.map(|set| Stratum { set, ratio: densities.fluid / densities.grain });
        for Set { nodes, .. } in self.fed_by(inflow) {
            let depths = if stratum.is_some() { &nodes.height } else { &nodes.depth };
            for i in 0..nodes.len() {
                let (before, along) = inflow.before(&nodes.position[i]);
                let far = before / nodes.length[i];
                if !(0.0..kernel.support()).contains(&far) || !(0.0..=width).contains(&along) {
                    continue;
                }
                let weight = nodes.volume[i] / depths[i] * kernel.shape::<D>(far);
                if weight > 0.0 {
                    let velocity = inflow.turned(&nodes.velocity[i]);
                    let pull = stratum.map_or(nodes.pull[i], |stratum| stratum.pull(nodes, i));
                    moments.add(
                        weight,
                        -before,
                        velocity,
                        depths[i],
                        pull,
                        kernel.support() * nodes.length[i],
                    );
                }
            }
        }
        let within = moments.within()?;
        Some(Arriving::of(within.depth[0], within.speed[0], within.pull))
    }

    /// The sets that a line brings nodes of.
    fn fed_by<'a>(&'a self, inflow: &'a Inflow<D>) -> impl Iterator<Item = &'a Set<D>> {
        self.sets.iter().enumerate().filter(|(number, _)| inflow.is_of(*number)).map(|(_, set)| set)
    }

    /// Depth (m) and outward speed (m/s) of what stands before a line when the flow begins; `None` where it is dry.
    pub fn standing(&self, inflow: &Inflow<D>) -> Option<(f64, f64)> {
        let (width, near) = (inflow.width(), NEAR * inflow.spacing);
        let (mut volume, mut moved, mut count) = (0.0, 0.0, 0);
        for (number, Set { nodes, .. }) in self.fed_by(inflow).enumerate() {
            for i in 0..nodes.len() {
                let (before, along) = inflow.before(&nodes.position[i]);
                if (0.0..near).contains(&before) && (0.0..=width).contains(&along) {
                    volume += nodes.volume[i];
                    moved += nodes.volume[i] * inflow.turned(&nodes.velocity[i])[0];
                    count += usize::from(number == 0);
                }
            }
        }
        let area = count as f64 * inflow.spacing.powi(D as i32);
        (count > 0).then(|| (volume / area, moved / volume))
    }

    /// Number of nodes that stand where those behind a line do.
    pub fn behind(&self, inflow: &Inflow<D>) -> usize {
        let is_behind = |x: &_| {
            let (before, along) = inflow.before(x);
            (-inflow.reach..0.0).contains(&before) && (0.0..=inflow.width()).contains(&along)
        };
        self.fed_by(inflow).flat_map(|set| &set.nodes.position).filter(|x| is_behind(x)).count()
    }

    /// Puts the first rows behind lines with standing flow before them, as [`Flow::standing`] has it, before the first step.
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn begin_lines(&mut self, standing: &[Option<(f64, f64)>]) -> Result<(), Failure> {
        let pull = self.settings.gravity;
        let arriving =
            |found: &Option<(f64, f64)>| found.map(|(depth, speed)| Arriving::of(depth, speed, pull));
        let arriving: Vec<_> = standing.iter().map(arriving).collect();
        self.feed_with(&arriving)?;
        self.settle_again()
    }

    /// First heights once more, with nodes that have been added; columns of pore pressure begin with them.
    pub(super) fn settle_again(&mut self) -> Result<(), Failure> {
        for set in &mut self.sets {
            set.nodes.length.clone_from(&set.nodes.first_length);
            set.unlist();
        }
        self.heads.depth.fill(f64::NAN);
        let (fastest, top) = (self.fastest_start, self.top);
        self.settle()?;
        (self.fastest_start, self.top) = (self.fastest_start.max(fastest), self.top.max(top));
        Ok(())
    }

    fn feed_with(&mut self, arriving: &[Option<Arriving>]) -> Result<(), Failure> {
        let mut gone = Vec::new();
        for (inflow, arriving) in self.inflows.iter_mut().zip(arriving) {
            let section = inflow.section(inflow.discharge(self.time), *arriving);
            // The number of rows grows with the depth. The depth at the largest discharge is computed only where the mean depth is exceeded.
            let deepest = section.deepest;
            let is_bounded =
                deepest <= DEEPEST * inflow.depth || deepest <= DEEPEST * inflow.deepest().deepest;
            if !is_bounded {
                let reason = format!(
                    "the inflow across the line from here would be {deepest:.3e} m deep, more than {DEEPEST} times its depth at the largest \
                     discharge, because of the flow before the line: take a smaller `courant` or a finer `spacing`"
                );
                return Err(Failure { node: self.next_id, position: inflow.from.to_vec(), reason });
            }
            let (fresh, stale) = inflow.advance(self.time, section, &mut self.next_id);
            gone.extend(stale);
            for (set, id, node) in &fresh {
                let Set { nodes, .. } = &mut self.sets[*set];
                nodes.push(*id, node);
                // Friction and XSPH divide by it before the next sum.
                if let Some(height) = nodes.height.last_mut() {
                    *height = inflow.height(node.volume);
                }
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
        Ok(())
    }

    /// Columns of pore pressure of what has not flowed in yet begin with the depth that they see when it does.
    pub(super) fn renew_columns(&mut self) {
        if self.heads.is_empty() {
            return;
        }
        for i in 0..self.sets[0].len() {
            let id = self.sets[0].nodes.id[i];
            if self.held.of(id).is_some() || self.is_fed(id) {
                self.heads.depth[i] = f64::NAN;
            }
        }
    }

    /// Whether node number `id` has not flowed in yet, or stands beyond an open side.
    pub fn is_outside(&self, id: u64) -> bool {
        self.held.of(id).is_some() || self.is_beyond(id)
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
