//! Step 10: nodes of inflows (sheet: depth-sph §3.4).

use crate::boundary::open::{LayerOfSide, LineFitSums};
use crate::flow::{DEEPEST, Flow, FlowFailure, OpenBoundary};
use crate::inflow::{ArrivingFlow, Inflow};
use crate::phases::phase::PhaseSet;

/// Distance before a line within which the initial flow is sampled (distances of nodes).
const NEAR: f64 = 2.0;

impl<const D: usize> Flow<D> {
    /// Moves the rows behind the lines of inflow to their current positions, with new ones behind them.
    ///
    /// # Errors
    /// When an inflow would be [`DEEPEST`] times too deep.
    pub(crate) fn update_inflow_nodes(&mut self) -> Result<(), FlowFailure> {
        if self.inflows.is_empty() {
            return Ok(());
        }
        let arriving: Vec<_> = self.inflows.iter().map(|inflow| self.arriving_flow(inflow)).collect();
        self.update_inflow_nodes_with(&arriving)
    }

    /// Flow that arrives at a line, within the reach of kernels; `None` where it is dry. Waves along the normal, and one state
    /// for all of the line (sheet: depth-sph §3.9).
    fn arriving_flow(&self, inflow: &Inflow<D>) -> Option<ArrivingFlow> {
        let kernel = self.settings.numerics.kernel;
        let (mut moments, width) = (LineFitSums::default(), inflow.width());
        let densities = &self.settings.material.densities;
        let stratum = inflow.layer.map(|set| LayerOfSide { set, ratio: densities.fluid / densities.grain });
        for PhaseSet { nodes, .. } in self.sets_of_inflow(inflow) {
            let depths = if stratum.is_some() { &nodes.partial_thickness } else { &nodes.depth };
            for i in 0..nodes.len() {
                let (before, along) = inflow.distances(&nodes.position[i]);
                let far = before / nodes.length[i];
                if !(0.0..kernel.support()).contains(&far) || !(0.0..=width).contains(&along) {
                    continue;
                }
                let weight = nodes.volume[i] / depths[i] * kernel.profile::<D>(far);
                if weight > 0.0 {
                    let velocity = inflow.outward_and_tangential(&nodes.velocity[i]);
                    let pull =
                        stratum.map_or(nodes.effective_gravity[i], |stratum| stratum.wave_gravity(nodes, i));
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
        let within = moments.interior_fit()?;
        Some(ArrivingFlow::of(within.depth[0], within.speed[0], within.effective_gravity))
    }

    /// Sets with nodes of an inflow.
    fn sets_of_inflow<'a>(&'a self, inflow: &'a Inflow<D>) -> impl Iterator<Item = &'a PhaseSet<D>> {
        self.sets.iter().enumerate().filter(|(number, _)| inflow.is_of(*number)).map(|(_, set)| set)
    }

    /// Initial depth (m) and outward speed (m/s) of the flow before a line; `None` where it is dry.
    pub fn initial_state_before(&self, inflow: &Inflow<D>) -> Option<(f64, f64)> {
        let (width, near) = (inflow.width(), NEAR * inflow.spacing);
        let (mut volume, mut moved, mut count) = (0.0, 0.0, 0);
        for (number, PhaseSet { nodes, .. }) in self.sets_of_inflow(inflow).enumerate() {
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

    /// Number of nodes at the positions of those behind a line.
    pub fn nodes_behind(&self, inflow: &Inflow<D>) -> usize {
        let is_behind = |x: &_| {
            let (before, along) = inflow.distances(x);
            (-inflow.reach..0.0).contains(&before) && (0.0..=inflow.width()).contains(&along)
        };
        self.sets_of_inflow(inflow).flat_map(|set| &set.nodes.position).filter(|x| is_behind(x)).count()
    }

    /// Adds the first rows behind lines with flow before them, by the result of [`Flow::initial_state_before`], before the first step.
    ///
    /// # Errors
    /// Those of [`Flow::new`].
    pub fn initialise_inflows(&mut self, standing: &[Option<(f64, f64)>]) -> Result<(), FlowFailure> {
        let pull = self.settings.gravity;
        let arriving =
            |found: &Option<(f64, f64)>| found.map(|(depth, speed)| ArrivingFlow::of(depth, speed, pull));
        let arriving: Vec<_> = standing.iter().map(arriving).collect();
        self.update_inflow_nodes_with(&arriving)?;
        self.reinitialise_thickness()
    }

    /// Recomputes initial heights, with nodes that have been added; columns of pore pressure begin with them.
    pub(crate) fn reinitialise_thickness(&mut self) -> Result<(), FlowFailure> {
        for set in &mut self.sets {
            set.nodes.length.clone_from(&set.nodes.first_length);
            set.clear_lists();
        }
        self.pore_columns.depth.fill(f64::NAN);
        let (fastest, top) = (self.fastest_start, self.max_initial_level);
        self.initialise_thickness()?;
        (self.fastest_start, self.max_initial_level) =
            (self.fastest_start.max(fastest), self.max_initial_level.max(top));
        Ok(())
    }

    fn update_inflow_nodes_with(&mut self, arriving: &[Option<ArrivingFlow>]) -> Result<(), FlowFailure> {
        let mut gone = Vec::new();
        for (inflow, arriving) in self.inflows.iter_mut().zip(arriving) {
            let section = inflow.section(inflow.discharge(self.time), *arriving);
            // The number of rows grows with the depth. The depth at the largest discharge is computed only above `DEEPEST` mean depths.
            let deepest = section.max_depth;
            let is_bounded =
                deepest <= DEEPEST * inflow.depth || deepest <= DEEPEST * inflow.max_section().max_depth;
            if !is_bounded {
                let reason = format!(
                    "the inflow across the line that begins here would be {deepest:.3e} m deep, more than \
                     {DEEPEST} times its depth at the largest discharge, because of the flow ahead of the \
                     line: reduce `courant` or `spacing`"
                );
                return Err(FlowFailure { node: self.next_id, position: inflow.from.to_vec(), reason });
            }
            let (fresh, stale) = inflow.advance(self.time, section, &mut self.next_id);
            gone.extend(stale);
            for (set, id, node) in &fresh {
                let PhaseSet { nodes, .. } = &mut self.sets[*set];
                nodes.push(*id, node);
                // Friction and XSPH divide by the height before the next sum.
                if let Some(height) = nodes.partial_thickness.last_mut() {
                    *height = inflow.height(node.volume);
                }
                self.sets[*set].clear_lists();
                if *set == 0 {
                    self.pore_columns.push();
                }
            }
        }
        gone.sort_unstable();
        if !gone.is_empty() {
            self.remove_where(|nodes, i| gone.binary_search(&nodes.id[i]).is_ok());
        }
        self.waiting_nodes.nodes =
            self.inflows.iter().flat_map(|inflow| inflow.waiting_nodes(self.time)).collect();
        self.waiting_nodes.nodes.sort_by_key(|node| node.0);
        for PhaseSet { nodes, .. } in &mut self.sets {
            for i in 0..nodes.len() {
                if let Some((place, velocity)) = self.waiting_nodes.of(nodes.id[i]) {
                    (nodes.position[i], nodes.velocity[i]) = (place, velocity);
                }
            }
        }
        Ok(())
    }

    /// Resets columns of pore pressure of nodes that have not entered yet, so that they begin with the depth at entry.
    pub(crate) fn reset_inflow_columns(&mut self) {
        if self.pore_columns.is_empty() {
            return;
        }
        for i in 0..self.sets[0].len() {
            let id = self.sets[0].nodes.id[i];
            if self.waiting_nodes.of(id).is_some() || self.is_inlet_node(id) {
                self.pore_columns.depth[i] = f64::NAN;
            }
        }
    }

    /// Whether node number `id` has not entered yet, or is beyond an open side.
    pub fn is_outside(&self, id: u64) -> bool {
        self.waiting_nodes.of(id).is_some() || self.is_far_field_node(id)
    }

    /// Restores the prescribed velocity of nodes behind the lines, whatever forces act on them.
    pub(crate) fn hold_inflow_velocities(&mut self) {
        self.hold_far_field_velocities();
        if self.waiting_nodes.nodes.is_empty() {
            return;
        }
        for PhaseSet { nodes, .. } in &mut self.sets {
            for i in 0..nodes.len() {
                if let Some((_, velocity)) = self.waiting_nodes.of(nodes.id[i]) {
                    nodes.velocity[i] = velocity;
                }
            }
        }
    }

    /// Volume that has entered (m³).
    pub fn entered(&self) -> f64 {
        let lines: f64 = self.inflows.iter().map(Inflow::entered).sum();
        let passed = |end: &OpenBoundary<D>| end.state.passed.iter().sum::<f64>();
        self.open_boundaries.iter().filter(|end| end.has_inlet()).fold(lines, |sum, end| sum - passed(end))
    }

    /// Volume of pore fluid, on nodes of its own, that has entered (m³).
    pub fn fluid_entered(&self) -> f64 {
        let of_line = |inflow: &Inflow<D>| inflow.porosity.unwrap_or(0.0) * inflow.entered();
        let lines: f64 = self.inflows.iter().map(of_line).sum();
        self.open_boundaries
            .iter()
            .filter(|end| end.has_inlet())
            .fold(lines, |sum, end| sum - end.state.passed[1])
    }

    /// Volume that has passed the open sides without inflow, less that which has returned (m³).
    pub fn passed(&self) -> f64 {
        self.open_boundaries.iter().filter(|end| !end.has_inlet()).flat_map(|end| end.state.passed).sum()
    }

    /// Volume of the nodes that have not entered yet, and of those beyond open ends (m³).
    pub fn waiting_volume(&self) -> f64 {
        let waiting: f64 = self.inflows.iter().map(Inflow::waiting_volume).sum();
        if self.open_boundaries.is_empty() { waiting } else { waiting + self.far_field_volume() }
    }
}
