//! One open side: its strips, what stands beyond each, and the nodes there.

use colluvium_points::CellList;

use super::super::set::Set;
use super::beyond::{Beyond, Known};
use super::layer::Layer;
use super::stand::{Past, Stand, Within, turned};
use super::two_layers::Stratum;
use super::{Feed, Opening, SUPPORTS};
use crate::inflow::Arriving;
use crate::nodes::{Node, Nodes, Plan};
use crate::settings::Settings;

/// No node is added closer to another one than this share of their distance.
const CLOSEST: f64 = 0.6;

/// Supports of a kernel before a side where it is seen what comes: nodes beyond the side are not felt there, which would be heard again
/// as waves.
const BEFORE: f64 = 2.0;

/// An open side.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenEnd<const D: usize> {
    /// Axis that it stands across.
    pub axis: usize,
    /// Where it is (m).
    pub place: f64,
    /// 1 at the upper end of the axis, -1 at the lower one.
    pub outward: f64,
    /// Distance of the nodes beyond it (m).
    pub spacing: f64,
    /// How far nodes stand beyond it (m).
    reach: f64,
    /// Where its strips begin along it (m), in plan.
    pub(super) low: f64,
    /// Its parts along it, each of one `spacing`; one in a profile.
    pub(super) strips: Vec<Strip<D>>,
    /// Strips at its ends that stand beyond other open sides: they are as the next one before these.
    pub(super) beside: [usize; 2],
    /// Whether its last strip is next to the first one.
    pub(super) periodic: bool,
    /// What flows in through it, in place of what is out there.
    pub(super) feed: Option<Feed>,
    /// Which of two layers it is of; none of one phase, or of grains and fluid.
    pub(super) stratum: Option<Stratum>,
    /// The layer before it.
    pub(super) layer: Layer,
    /// What has happened.
    pub state: Beyond,
}

/// A part of a side.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Strip<const D: usize> {
    /// Nodes like those beyond it, of each set.
    pub(super) like: [Option<Node<D>>; 2],
    /// What is out there; none where there was nothing.
    pub(super) still: Option<Stand>,
    /// Volume of a node over the depth that sums have there (m; m² in plan).
    pub(super) width: f64,
}

/// Which nodes are before all open sides, which beyond one, and which beyond another.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Within,
    Beyond,
    Elsewhere,
}

impl<const D: usize> OpenEnd<D> {
    pub(super) fn new(opening: &Opening, reach: f64, others: &[Opening], stratum: Option<Stratum>) -> Self {
        let Opening { axis, place, outward, spacing, span, periodic, layer, .. } = *opening;
        // Corners of two open sides belong to the first of them.
        let goes_on = |end: f64| {
            others.iter().any(|other| other.axis != axis && (other.place - end).abs() < 0.5 * spacing)
        };
        let more = (reach / spacing).ceil() as usize + 1;
        let (beside, count) = if D == 1 {
            ([0; 2], 1)
        } else {
            let beside = [span.0, span.1].map(|end| if goes_on(end) { more } else { 0 });
            (beside, ((span.1 - span.0) / spacing).round().max(1.0) as usize)
        };
        let strip = Strip { like: [None; 2], still: None, width: spacing.powi(D as i32) };
        let count = count + beside[0] + beside[1];
        Self {
            axis,
            place,
            outward,
            spacing,
            reach,
            low: span.0 - beside[0] as f64 * spacing,
            strips: vec![strip; count],
            beside,
            periodic,
            feed: None,
            stratum,
            layer: Layer::new(layer),
            state: Beyond { strips: vec![Known::default(); count], ..Beyond::default() },
        }
    }

    /// Whether it is a side of set `number`.
    pub(super) fn is_of(&self, number: usize) -> bool {
        is_of(self.stratum, number)
    }

    /// The sets that it is a side of, with their numbers.
    pub(super) fn own<'a>(
        &self,
        sets: &'a [Set<D>],
    ) -> impl Iterator<Item = (usize, &'a Set<D>)> + use<'a, D> {
        let stratum = self.stratum;
        sets.iter().enumerate().filter(move |(number, _)| is_of(stratum, *number))
    }

    /// Depths at nodes of its sets (m): of both phases, or of its layer.
    pub(super) fn depths<'a>(&self, nodes: &'a Nodes<D>) -> &'a [f64] {
        if self.stratum.is_some() { &nodes.height } else { &nodes.depth }
    }

    /// Effective gravity at node `i` of one of its sets (m/s²): for what flows into one of two layers that on waves of its own depth.
    pub(super) fn pull(&self, nodes: &Nodes<D>, i: usize) -> f64 {
        let stratum = self.stratum.filter(|_| self.is_fed());
        stratum.map_or(nodes.pull[i], |stratum| stratum.pull(nodes, i))
    }

    /// Share of set `number` of all in a depth that stands there.
    pub(super) fn share(&self, stand: &Stand, sets: usize, number: usize) -> f64 {
        if self.stratum.is_some() { 1.0 } else { stand.share(sets, number) }
    }

    /// Finds what stands at the side when the flow begins, under `gravity` (m/s²) at `time` (s): the material goes on like that.
    pub(super) fn begin(
        &mut self,
        sets: &[Set<D>],
        part: &dyn Fn(&Plan<D>) -> Part,
        gravity: f64,
        time: f64,
        feed: Option<&Feed>,
    ) {
        for (number, set) in self.own(sets) {
            let nodes = &set.nodes;
            let mut last: Vec<Option<(f64, usize)>> = vec![None; self.strips.len()];
            for i in 0..nodes.len() {
                let x = &nodes.position[i];
                let beyond = self.beyond(x);
                if part(x) != Part::Within || !(-2.0 * self.spacing..0.0).contains(&beyond) {
                    continue;
                }
                let entry = &mut last[self.strip(x)];
                if entry.is_none_or(|(other, _)| beyond >= other) {
                    *entry = Some((beyond, i));
                }
            }
            for (strip, last) in self.strips.iter_mut().zip(last) {
                let Some((_, i)) = last else { continue };
                let node = like(nodes, i);
                let depth = node.volume / self.spacing.powi(D as i32);
                let [speed, along] = turned(&node.velocity, self.axis, self.outward);
                let still = strip.still.get_or_insert(Stand { depth: 0.0, speed, along, porosity: 0.0 });
                still.depth += depth;
                still.porosity += if number == 1 { depth } else { 0.0 };
                strip.like[number] = Some(node);
            }
        }
        let own: Vec<_> = self.own(sets).filter(|(_, set)| !set.is_empty()).collect();
        let whole = self.stratum.is_some();
        for strip in &mut self.strips {
            if let Some(still) = &mut strip.still {
                still.porosity /= still.depth;
            } else if let Some(feed) = feed {
                let (depth, speed) = feed.section(feed.discharge(time), gravity);
                let stand = Stand { depth, speed: -speed, along: 0.0, porosity: feed.porosity };
                for (number, set) in &own {
                    let share = if whole { 1.0 } else { stand.share(sets.len(), *number) };
                    let volume = share * depth * self.spacing;
                    strip.like[*number] = Some(Node { volume, ..like(&set.nodes, 0) });
                }
            }
        }
        self.copy_to_corners();
    }

    /// Strips beyond other open sides are as the next one before these.
    pub(super) fn copy_to_corners(&mut self) {
        for number in 0..self.strips.len() {
            let own = self.known(number);
            if own == number {
                continue;
            }
            let mut strip = self.strips[own].clone();
            let along = self.spacing * (number as f64 - own as f64);
            for node in strip.like.iter_mut().flatten() {
                node.position[1 - self.axis] += along;
            }
            self.strips[number] = strip;
        }
    }

    /// Whether something flows in through it.
    pub fn is_fed(&self) -> bool {
        self.feed.is_some()
    }

    /// How far before it one looks for what comes (m).
    pub(super) fn inside(&self) -> f64 {
        BEFORE * self.reach / SUPPORTS
    }

    /// How far nodes stand beyond it (m).
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// Distance beyond the side (m).
    pub(super) fn beyond(&self, x: &Plan<D>) -> f64 {
        self.outward * (x[self.axis] - self.place)
    }

    /// The strip that a place belongs to.
    pub(super) fn strip(&self, x: &Plan<D>) -> usize {
        if D == 1 {
            return 0;
        }
        let along = ((x[1 - self.axis] - self.low) / self.spacing).floor().max(0.0) as usize;
        along.min(self.strips.len() - 1)
    }

    /// The strip whose state a strip has: that of the next one before a corner.
    pub(super) fn known(&self, strip: usize) -> usize {
        strip.clamp(self.beside[0], self.strips.len() - 1 - self.beside[1])
    }

    /// What stands at a distance beyond a strip (m).
    pub(super) fn at(&self, strip: usize, beyond: f64) -> Stand {
        let known = &self.state.strips[self.known(strip)];
        if let Some(fixed) = known.fixed {
            return fixed;
        }
        if let (Some(stratum), Some(both)) = (&self.stratum, &known.both) {
            return stratum.at(both, beyond);
        }
        let still = self.strips[strip].still.as_ref();
        // In plan waves may come at an angle, which delays along the normal know nothing of.
        let there =
            |within: Within| if D == 1 { known.past.at(still, beyond) } else { within.at(still, beyond) };
        known.within.map_or(Stand::default(), there)
    }

    /// Velocity in plan of what stands there.
    pub(super) fn velocity(&self, stand: &Stand) -> Plan<D> {
        std::array::from_fn(|c| if c == self.axis { self.outward * stand.speed } else { stand.along })
    }

    /// Counts what has passed the side since it was last looked at; set and index of nodes that have come in.
    pub(super) fn count(&mut self, sets: &[Set<D>], part: &dyn Fn(&Plan<D>) -> Part) -> Vec<(usize, usize)> {
        let (mut ids, mut entered) = (Vec::new(), Vec::new());
        for (number, set) in self.own(sets) {
            let nodes = &set.nodes;
            for i in 0..nodes.len() {
                let is_beyond = part(&nodes.position[i]) == Part::Beyond;
                let was = self.state.ids.binary_search(&nodes.id[i]).is_ok();
                if is_beyond != was {
                    self.state.passed[number] += if is_beyond { nodes.volume[i] } else { -nodes.volume[i] };
                }
                if was && !is_beyond {
                    entered.push((number, i));
                }
                if is_beyond {
                    ids.push(nodes.id[i]);
                }
            }
        }
        ids.sort_unstable();
        self.state.ids = ids;
        entered
    }

    /// Gives the nodes of set `number` of all beyond the side their depth and speed. How far the last one of each strip stands (m), and the numbers of
    /// those that are not needed.
    pub(super) fn place(
        &mut self,
        nodes: &mut Nodes<D>,
        (sets, number): (usize, usize),
        part: &dyn Fn(&Plan<D>) -> Part,
    ) -> (Vec<f64>, Vec<u64>) {
        let (mut gone, mut farthest) = (Vec::new(), vec![-0.5 * self.spacing; self.strips.len()]);
        for i in 0..nodes.len() {
            let x = nodes.position[i];
            let (beyond, strip) = (self.beyond(&x), self.strip(&x));
            match part(&x) {
                Part::Elsewhere => continue,
                Part::Within => {
                    farthest[strip] = f64::max(farthest[strip], beyond);
                    continue;
                }
                Part::Beyond => {}
            }
            let stand = self.at(strip, beyond);
            if stand.depth <= 0.0 || beyond > self.reach + self.spacing {
                gone.push(nodes.id[i]);
                continue;
            }
            farthest[strip] = f64::max(farthest[strip], beyond);
            // Where nothing stood out there what has passed goes on with its volume, however close its nodes have come.
            if !self.leaves_dry(strip) {
                nodes.volume[i] = self.share(&stand, sets, number) * stand.depth * self.strips[strip].width;
            }
            nodes.velocity[i] = self.velocity(&stand);
        }
        gone.sort_unstable();
        self.state.ids.retain(|id| gone.binary_search(id).is_err());
        (farthest, gone)
    }

    /// Adds nodes of set `number` beyond the side, from the last one of each strip (m) on as far as they are felt.
    pub(super) fn add(
        &mut self,
        set: &mut Set<D>,
        (sets, number): (usize, usize),
        farthest: &[f64],
        next_id: &mut u64,
    ) {
        let mut places = Places::default();
        let share = |side: &Self, stand: &Stand| side.share(stand, sets, number);
        for (strip, last) in farthest.iter().enumerate() {
            let Some(like) = self.strips[strip].like[number] else { continue };
            let mut beyond = *last;
            while beyond + self.spacing <= self.reach {
                beyond += self.spacing;
                let stand = self.at(strip, beyond);
                if stand.depth <= 0.0 {
                    break;
                }
                let mut node = Node {
                    velocity: self.velocity(&stand),
                    volume: share(self, &stand) * stand.depth * self.strips[strip].width,
                    ..like
                };
                node.position[self.axis] = self.outward * beyond + self.place;
                if D > 1 && places.are_taken(&set.nodes, &node.position, CLOSEST * self.spacing) {
                    continue;
                }
                set.nodes.push(*next_id, &node);
                // It has a height before the next sum.
                let height = share(self, &stand) * stand.depth;
                if let (Some(own), Some(whole)) = (set.nodes.height.last_mut(), set.nodes.depth.last_mut()) {
                    (*own, *whole) = (height, stand.depth);
                }
                set.unlist();
                self.state.ids.push(*next_id);
                *next_id += 1;
            }
        }
        self.state.ids.sort_unstable();
    }

    /// Finds the state of the side at `time` (s): that of its outside before the first step, none where there is nothing.
    pub(super) fn find_state(
        &mut self,
        settings: &Settings<D>,
        sets: &[Set<D>],
        part: &dyn Fn(&Plan<D>) -> Part,
        (time, dt, is_first): (f64, f64, bool),
    ) {
        let gravity = settings.gravity;
        if is_first {
            for (known, strip) in self.state.strips.iter_mut().zip(&self.strips) {
                *known = Known { fixed: strip.still, ..Known::default() };
            }
        } else {
            let kernel = settings.numerics.kernel;
            let found = self.within(kernel, sets, part, 0.0);
            let inside = self.inside();
            let arriving = if D == 1 && !self.is_fed() && self.stratum.is_none() {
                self.within(kernel, sets, part, inside)
            } else {
                vec![None; found.len()]
            };
            for ((known, within), arriving) in self.state.strips.iter_mut().zip(found).zip(arriving) {
                (known.fixed, known.within) = (None, within);
                match arriving.or(within) {
                    Some(arriving) if D == 1 && self.stratum.is_none() => {
                        known.past.take((time, dt), &arriving, inside, self.reach);
                    }
                    _ => known.past = Past::default(),
                }
            }
        }
        self.level_drift();
        let time = self.time_of_feed(time, sets.len());
        let Some(feed) = &self.feed else { return };
        for known in &mut self.state.strips {
            let here = known.within.map(|within| (within.depth[0], within.speed[0], within.pull));
            let here = here.or(known.fixed.map(|still| (still.depth, still.speed, gravity)));
            let pull = here.map_or(gravity, |(.., pull)| pull);
            let arriving = here.map(|(depth, speed, pull)| Arriving::of(depth, speed, pull));
            // The Froude number of a layer is that of its own depth, whatever stands on it.
            let pull = if self.stratum.is_some() { gravity } else { pull };
            known.fixed = Some(feed.state(time, arriving, pull));
        }
    }
}

/// Whether a side of a layer, or of all there is, is one of set `number`.
fn is_of(stratum: Option<Stratum>, number: usize) -> bool {
    stratum.is_none_or(|stratum| stratum.set == number)
}

/// A node like node `i`.
fn like<const D: usize>(nodes: &Nodes<D>, i: usize) -> Node<D> {
    Node {
        body: nodes.body[i],
        position: nodes.position[i],
        velocity: nodes.velocity[i],
        volume: nodes.volume[i],
        length: nodes.first_length[i],
        scale: nodes.scale[i],
    }
}

/// Where nodes stand: those that there were at first, in cells, and those that have been added since.
#[derive(Default)]
struct Places<const D: usize> {
    /// None before the first question, and of places that are not finite, which the next search names.
    cells: Option<CellList<D>>,
    /// How many are in cells.
    count: usize,
}

impl<const D: usize> Places<D> {
    /// Whether a node stands within `distance` (m) of a place.
    fn are_taken(&mut self, nodes: &Nodes<D>, x: &Plan<D>, distance: f64) -> bool {
        if self.cells.is_none() {
            let mut cells = CellList::new();
            // Of several distances, so that there are fewer of them than nodes.
            if cells.build(&nodes.position, 4.0 * distance).is_ok() {
                (self.cells, self.count) = (Some(cells), nodes.len());
            }
        }
        let is_near = |y: &Plan<D>| -> bool {
            (0..D).map(|c| (x[c] - y[c]).powi(2)).sum::<f64>() < distance * distance
        };
        let mut taken = nodes.position[self.count..].iter().any(is_near);
        if let Some(cells) = &self.cells {
            cells.visit_within(x, distance, |i| taken |= is_near(&nodes.position[i as usize]));
        }
        taken
    }
}
