//! Ends of a profile that waves leave through, from the invariants `u ± 2c` along characteristics (sheet: depth-sph §2.2, §3.9).
//!
//! Nodes stand beyond the end as far as kernels reach, and move with what its state says: one invariant from within, the other from
//! the material out there, which is as it was at the end when the flow began.

use serde::{Deserialize, Serialize};

use super::Flow;
use super::grow::keep;
use super::set::Set;
use crate::inflow;
use crate::kernel::Kernel;
use crate::nodes::{Node, Nodes};
use crate::settings::Settings;

/// Nodes stand beyond an end as far as this many supports of a kernel: the last ones, which lack neighbours, are not felt within.
const SUPPORTS: f64 = 3.0;

/// An open end of a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenEnd {
    /// Where it is (m).
    pub place: f64,
    /// 1 at the upper end of the axis, -1 at the lower one.
    pub outward: f64,
    /// Distance of the nodes beyond it (m).
    pub spacing: f64,
    /// Volume of a node over the depth that sums have there (m).
    width: f64,
    /// How far nodes stand beyond it (m).
    reach: f64,
    /// A node like those beyond it.
    like: Option<Node<1>>,
    /// Depth (m) and outward speed (m/s) out there; none where there was nothing.
    still: Option<(f64, f64)>,
    /// What flows in through it, in place of what is out there.
    feed: Option<Feed>,
    /// What has happened.
    pub state: Beyond,
}

/// What a kernel at an end reaches within, and how it changes outward.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Within {
    /// Depth at the end (m) and its slope.
    pub depth: [f64; 2],
    /// Outward speed at the end (m/s) and its slope (1/s).
    pub speed: [f64; 2],
    /// Effective gravity (m/s²).
    pub pull: f64,
    /// As far as slopes are followed (m).
    pub reach: f64,
}

/// What flows in through an end.
#[derive(Clone, Debug, PartialEq)]
pub struct Feed {
    /// Times (s) and discharges per width (m²/s), linear between them; none before the first and after the last.
    pub hydrograph: Vec<[f64; 2]>,
    /// Froude number `u/√(g h)` at the end where nothing stands before it, or where what flows in is faster than its waves.
    pub froude: f64,
}

impl Feed {
    /// Discharge per width at a time (m²/s).
    pub fn discharge(&self, time: f64) -> f64 {
        inflow::at_time(&self.hydrograph, time)
    }

    /// Depth (m) and speed (m/s) by the Froude number, at a discharge (m²/s) under gravity `pull` (m/s²).
    pub fn section(&self, discharge: f64, pull: f64) -> (f64, f64) {
        inflow::section(discharge, self.froude, pull)
    }

    /// Its largest speed (m/s) by the Froude number, under gravity `pull` (m/s²).
    fn fastest(&self, pull: f64) -> f64 {
        self.hydrograph.iter().map(|pair| self.section(pair[1], pull).1).fold(0.0, f64::max)
    }

    /// Depth (m) and outward speed (m/s) at an end to which `outgoing` = `u + 2c` (m/s) arrives from within, and nothing where it is
    /// dry: `c² (2c - outgoing) = g q`.
    fn state(&self, time: f64, outgoing: Option<f64>, pull: f64) -> (f64, f64) {
        let discharge = self.discharge(time);
        let rapid = || {
            let (depth, speed) = self.section(discharge, pull);
            (depth, -speed)
        };
        let Some(outgoing) = outgoing else { return rapid() };
        // Above the root, from where Newton's steps fall to it.
        let mut celerity = (0.5 * outgoing).max(0.0) + (pull * discharge).cbrt();
        if celerity <= 0.0 {
            return rapid();
        }
        for _ in 0..60 {
            let value = celerity * celerity * (2.0 * celerity - outgoing) - pull * discharge;
            let change = value / (6.0 * celerity * celerity - 2.0 * celerity * outgoing);
            if !(change.abs() > 1e-14 * celerity) {
                break;
            }
            celerity -= change;
        }
        let speed = outgoing - 2.0 * celerity;
        if -speed > celerity { rapid() } else { (celerity * celerity / pull, speed) }
    }
}

/// What stands beyond an open end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Beyond {
    /// Numbers of the nodes, ascending.
    pub ids: Vec<u64>,
    /// Their depth (m) and outward speed (m/s), where these are the same for all.
    pub fixed: Option<(f64, f64)>,
    /// What arrives from within.
    pub within: Option<Within>,
    /// Volume that has passed outward, less what has come back (m²).
    pub passed: f64,
}

impl OpenEnd {
    /// Finds what stands at the end when the flow begins, under `gravity` (m/s²) at `time` (s): the material goes on like that.
    fn begin<const D: usize>(&mut self, nodes: &Nodes<D>, gravity: f64, time: f64, feed: Option<&Feed>) {
        let beyond = |i: usize| self.beyond(nodes.position[i][0]);
        let last = (0..nodes.len())
            .filter(|i| (-2.0 * self.spacing..0.0).contains(&beyond(*i)))
            .max_by(|a, b| beyond(*a).total_cmp(&beyond(*b)));
        let like = |i: usize| Node {
            body: nodes.body[i],
            position: [self.place],
            velocity: [nodes.velocity[i][0]],
            volume: nodes.volume[i],
            length: nodes.first_length[i],
            scale: nodes.scale[i],
        };
        if let Some(i) = last {
            let (depth, node) = (nodes.volume[i] / self.spacing, like(i));
            self.still = Some((depth, self.outward * node.velocity[0]));
            self.like = Some(node);
        } else if let (Some(feed), false) = (feed, nodes.is_empty()) {
            let (depth, speed) = feed.section(feed.discharge(time), gravity);
            let node = Node { velocity: [-self.outward * speed], volume: depth * self.spacing, ..like(0) };
            self.like = Some(node);
        }
    }

    /// Whether something flows in through it.
    pub fn is_fed(&self) -> bool {
        self.feed.is_some()
    }

    /// Distance beyond the end (m).
    fn beyond(&self, x: f64) -> f64 {
        self.outward * (x - self.place)
    }

    /// Depth at a distance beyond the end (m), where what arrives from within goes on as it changes there, and outward speed at the end
    /// (m/s): nodes beyond it move as one, so that their distances stay, and their volumes are those of the depth.
    fn at(&self, beyond: f64) -> (f64, f64) {
        if let Some(fixed) = self.state.fixed {
            return fixed;
        }
        let Some(within) = self.state.within else { return (0.0, 0.0) };
        let far = beyond.min(within.reach);
        let [depth, slope] = within.depth;
        let arriving = (depth + slope * far).clamp(0.5 * depth, 1.5 * depth);
        let speed = within.speed[0] + within.speed[1] * far;
        let (_, at_end) = self.state_at(depth, within.speed[0], within.pull);
        (self.state_at(arriving, speed, within.pull).0, at_end)
    }

    /// Depth (m) and outward speed (m/s) at the end, of those within, where gravity is `pull` (m/s²).
    fn state_at(&self, depth: f64, speed: f64, pull: f64) -> (f64, f64) {
        let celerity = (pull * depth).sqrt();
        let Some((out_depth, out_speed)) = self.still.filter(|_| speed < celerity) else {
            // Nothing comes back against a flow that is faster than its waves.
            return (depth, speed);
        };
        let outgoing = speed + 2.0 * celerity;
        let incoming = out_speed - 2.0 * (pull * out_depth).sqrt();
        let found = 0.25 * (outgoing - incoming);
        (found * found / pull, 0.5 * (outgoing + incoming))
    }
}

impl<const D: usize> Flow<D> {
    /// Opens an end of a profile, before the first step. `spacing` is that of the nodes (m).
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn open(&mut self, place: f64, outward: f64, spacing: f64) -> Result<(), super::Failure> {
        self.open_with(place, outward, spacing, None)
    }

    /// Opens an end through which material flows in.
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn open_with(
        &mut self,
        place: f64,
        outward: f64,
        spacing: f64,
        feed: Option<Feed>,
    ) -> Result<(), super::Failure> {
        let nodes = &self.sets[0].nodes;
        let longest = nodes.first_length.iter().copied().fold(0.0, f64::max);
        let reach = SUPPORTS * self.settings.numerics.kernel.support() * longest;
        let mut end = OpenEnd {
            place,
            outward,
            spacing,
            width: spacing,
            reach,
            like: None,
            still: None,
            feed: None,
            state: Beyond::default(),
        };
        end.begin(nodes, self.settings.gravity, self.time, feed.as_ref());
        let most = feed.as_ref().map_or(0.0, |feed| feed.fastest(self.settings.gravity));
        // What flows in begins after the sums of what stands there are known.
        let (now, later) = if end.still.is_some() { (None, feed) } else { (feed, None) };
        end.feed = now;
        self.opens.push(end);
        self.pass_ends();
        let set = &mut self.sets[0];
        set.nodes.length.clone_from(&set.nodes.first_length);
        set.unlist();
        self.settle()?;
        self.fastest_start = self.fastest_start.max(most);
        // Sums over a lattice are not quite its depth: what is still is what they have.
        let number = self.opens.len() - 1;
        let end = &mut self.opens[number];
        let within = end.within(self.settings.numerics.kernel, &self.sets[0].nodes);
        if let (Some(still), Some(within), Some(like)) = (&mut end.still, within, &end.like) {
            *still = (within.depth[0], within.speed[0]);
            end.width = like.volume / within.depth[0];
        }
        if later.is_some() {
            end.feed = later;
        }
        Ok(())
    }

    /// What has passed the open ends stands beyond them, in the state of the end.
    pub(super) fn pass_ends(&mut self) {
        let Self { settings, sets, heads, opens, spare, next_id, time, step, .. } = self;
        for end in opens {
            end.count(&sets[0].nodes);
            end.find_state(settings, &sets[0].nodes, *time, *step == 0);
            let (farthest, gone) = end.place(&mut sets[0].nodes);
            if !gone.is_empty() {
                let nodes = &sets[0].nodes;
                let stays = |i: &usize| gone.binary_search(&nodes.id[*i]).is_err();
                let order: Vec<u32> = (0..nodes.len()).filter(stays).map(|i| i as u32).collect();
                keep(&mut sets[0], Some(&mut *heads), &order, spare);
            }
            end.add(&mut sets[0], farthest, next_id);
        }
    }

    /// Nodes beyond open ends keep their velocity, whatever acts on them.
    pub(super) fn hold_beyond(&mut self) {
        let nodes = &mut self.sets[0].nodes;
        for end in &self.opens {
            for i in 0..nodes.len() {
                if end.state.ids.binary_search(&nodes.id[i]).is_ok() {
                    let (_, speed) = end.at(end.beyond(nodes.position[i][0]).max(0.0));
                    nodes.velocity[i][0] = end.outward * speed;
                }
            }
        }
    }

    /// Volume of the nodes beyond open ends (m²).
    pub fn beyond(&self) -> f64 {
        let nodes = &self.sets[0].nodes;
        let is_beyond =
            |i: &usize| self.opens.iter().any(|end| end.state.ids.binary_search(&nodes.id[*i]).is_ok());
        (0..nodes.len()).filter(is_beyond).map(|i| nodes.volume[i]).sum()
    }
}

impl OpenEnd {
    /// Counts what has passed the end since it was last looked at.
    fn count<const D: usize>(&mut self, nodes: &Nodes<D>) {
        let mut ids = Vec::new();
        for i in 0..nodes.len() {
            let is_beyond = self.beyond(nodes.position[i][0]) > 0.0;
            let was = self.state.ids.binary_search(&nodes.id[i]).is_ok();
            if is_beyond != was {
                self.state.passed += if is_beyond { nodes.volume[i] } else { -nodes.volume[i] };
            }
            if is_beyond {
                ids.push(nodes.id[i]);
            }
        }
        ids.sort_unstable();
        self.state.ids = ids;
    }

    /// Gives the nodes beyond the end their depth and speed. How far the last one stands (m), and the numbers of those that are not needed.
    fn place<const D: usize>(&mut self, nodes: &mut Nodes<D>) -> (f64, Vec<u64>) {
        let (mut gone, mut farthest) = (Vec::new(), -0.5 * self.spacing);
        for i in 0..nodes.len() {
            let beyond = self.beyond(nodes.position[i][0]);
            if beyond <= 0.0 {
                farthest = f64::max(farthest, beyond);
                continue;
            }
            let (depth, speed) = self.at(beyond);
            if depth <= 0.0 || beyond > self.reach + self.spacing {
                gone.push(nodes.id[i]);
                continue;
            }
            farthest = f64::max(farthest, beyond);
            nodes.volume[i] = depth * self.width;
            nodes.velocity[i][0] = self.outward * speed;
        }
        gone.sort_unstable();
        self.state.ids.retain(|id| gone.binary_search(id).is_err());
        (farthest, gone)
    }

    /// Adds nodes beyond the end, from the last one (m) on as far as they are felt.
    fn add<const D: usize>(&mut self, set: &mut Set<D>, mut farthest: f64, next_id: &mut u64) {
        let Some(like) = self.like else { return };
        while farthest + self.spacing <= self.reach {
            farthest += self.spacing;
            let (depth, speed) = self.at(farthest);
            if depth <= 0.0 {
                return;
            }
            let along = |x: f64| std::array::from_fn(|c| if c == 0 { self.outward * x } else { 0.0 });
            let mut node = Node {
                body: like.body,
                position: along(farthest),
                velocity: along(speed),
                volume: depth * self.width,
                length: like.length,
                scale: like.scale,
            };
            node.position[0] += self.place;
            set.nodes.push(*next_id, &node);
            // It has a height before the next sum.
            for heights in [&mut set.nodes.height, &mut set.nodes.depth] {
                if let Some(height) = heights.last_mut() {
                    *height = depth;
                }
            }
            set.unlist();
            self.state.ids.push(*next_id);
            *next_id += 1;
        }
    }

    /// Finds the state of the end at `time` (s): that of its outside before the first step, none where there is nothing.
    fn find_state<const D: usize>(
        &mut self,
        settings: &Settings<D>,
        nodes: &Nodes<D>,
        time: f64,
        is_first: bool,
    ) {
        let gravity = settings.gravity;
        (self.state.fixed, self.state.within) = (None, None);
        if is_first {
            self.state.fixed = self.still;
        } else {
            self.state.within = self.within(settings.numerics.kernel, nodes);
        }
        let Some(feed) = &self.feed else { return };
        let here = self.state.within.map(|within| (within.depth[0], within.speed[0], within.pull));
        let here = here.or(self.state.fixed.map(|(depth, speed)| (depth, speed, gravity)));
        let pull = here.map_or(gravity, |(.., pull)| pull);
        let outgoing = here.map(|(depth, speed, pull)| speed + 2.0 * (pull * depth).sqrt());
        self.state.fixed = Some(feed.state(time, outgoing, pull));
    }

    /// What a kernel at the end reaches within: a line through depths and speeds by least squares.
    fn within<const D: usize>(&self, kernel: Kernel, nodes: &Nodes<D>) -> Option<Within> {
        let (mut moments, mut depths, mut speeds, mut pull) = ([0.0; 3], [0.0; 2], [0.0; 2], 0.0);
        let mut reach: f64 = 0.0;
        for i in 0..nodes.len() {
            let beyond = self.beyond(nodes.position[i][0]);
            let far = -beyond / nodes.length[i];
            if beyond <= 0.0 && far < kernel.support() {
                let weight = nodes.volume[i] / nodes.height[i] * kernel.shape::<D>(far);
                let speed = self.outward * nodes.velocity[i][0];
                let powers = [weight, weight * beyond, weight * beyond * beyond];
                (0..3).for_each(|k| moments[k] += powers[k]);
                for k in 0..2 {
                    depths[k] += powers[k] * nodes.depth[i];
                    speeds[k] += powers[k] * speed;
                }
                pull += weight * nodes.pull[i];
                reach = reach.max(kernel.support() * nodes.length[i]);
            }
        }
        let [weight, first, second] = moments;
        if !(weight > 0.0) {
            return None;
        }
        let spread = weight * second - first * first;
        let line = |[sum, moment]: [f64; 2]| {
            // Of one node, or of some at one place, there is no slope.
            let is_line = spread > 1e-6 * weight * second;
            let slope = if is_line { (weight * moment - first * sum) / spread } else { 0.0 };
            [(sum - slope * first) / weight, slope]
        };
        Some(Within { depth: line(depths), speed: line(speeds), pull: pull / weight, reach })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(still: Option<(f64, f64)>) -> OpenEnd {
        let state = Beyond::default();
        OpenEnd {
            place: 10.0,
            outward: 1.0,
            spacing: 0.1,
            width: 0.1,
            reach: 0.9,
            like: None,
            still,
            feed: None,
            state,
        }
    }

    #[test]
    fn a_simple_wave_passes_as_it_is_and_a_rapid_flow_too() {
        let celerity = |depth: f64| (9.81 * depth).sqrt();
        let still = end(Some((1.0, 0.0)));
        for depth in [0.8, 1.0, 1.3] {
            let speed = 2.0 * (celerity(depth) - celerity(1.0));
            let (h, u) = still.state_at(depth, speed, 9.81);
            assert!((h - depth).abs() < 1e-12 && (u - speed).abs() < 1e-12);
        }
        // A wave that comes in from the end itself is not let in: the material out there rests.
        let (h, u) = still.state_at(1.1, -2.0 * (celerity(1.1) - celerity(1.0)), 9.81);
        assert!((h - 1.0).abs() < 1e-12 && u.abs() < 1e-12);
        assert_eq!(still.state_at(0.2, 3.0, 9.81), (0.2, 3.0));
        assert_eq!(end(None).state_at(0.2, 0.1, 9.81), (0.2, 0.1));
    }

    #[test]
    fn what_flows_in_meets_what_stands_there() {
        let feed = Feed { hydrograph: vec![[0.0, 0.5], [10.0, 0.5]], froude: 2.0 };
        // The sheet's: 0.5 m²/s into still water 1 m deep.
        let (h, u) = feed.state(1.0, Some(2.0 * 9.81f64.sqrt()), 9.81);
        assert!((h - 1.144_364).abs() < 1e-6 && (u + 0.436_924).abs() < 1e-6, "{h} {u}");
        let (h, u) = feed.state(1.0, None, 9.81);
        assert!((h * u + 0.5).abs() < 1e-12 && (u * u / (9.81 * h) - 4.0).abs() < 1e-9, "onto a dry bed");
        let (h, u) = feed.state(11.0, Some(2.0 * 9.81f64.sqrt()), 9.81);
        assert!((h - 1.0).abs() < 1e-9 && u.abs() < 1e-9, "nothing: as a wall");
    }
}
