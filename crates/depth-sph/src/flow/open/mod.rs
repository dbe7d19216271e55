//! Sides that waves leave through, from the invariants `u ± 2c` along characteristics (sheet: depth-sph §2.2, §3.9): ends of profiles,
//! and sides in plan along the axes.
//!
//! Nodes stand beyond the side as far as kernels reach, and move with what its state says: one invariant from within, the other from
//! the material out there, which is as it was at the side when the flow began. A side in plan is cut into strips, each with a state of
//! its own, of waves along its normal.
//!
//! Sums of depth are off by some hundredths of a wave where nodes that move meet nodes whose volume follows the wave, and what is found
//! there comes back. At the end of a profile what arrives is therefore looked at two supports of a kernel before it, and reaches the
//! end and what stands beyond when waves have had the time: less than 1 % of a small wave comes back (V27: 2 %). In plan, where waves
//! come at angles, it is what stands at the side: 4.5 % of small waves come back head-on, 12 % at 30°, 15 % at 45°, and less where they die
//! away in a layer before it.

mod beyond;
mod columns;
mod inlet;
mod layer;
mod look;
mod meter;
mod side;
mod stand;
mod two_layers;

use super::Flow;
use super::grow::keep;
use crate::choices::Phases;
use crate::nodes::{Nodes, Plan};
use side::Part;
pub(super) use two_layers::Stratum;

pub use beyond::{Beyond, Known};
pub use inlet::Feed;
pub use side::OpenEnd;
pub(super) use stand::Moments;
pub use stand::{Past, Stand, Within};

/// Nodes stand beyond a side as far as this many supports of a kernel: the last ones, which lack neighbours, are not felt within.
const SUPPORTS: f64 = 3.0;

/// Where a side is to be opened.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Axis that it stands across.
    pub axis: usize,
    /// Where it is along that axis (m).
    pub place: f64,
    /// 1 at the upper end of the axis, -1 at the lower one.
    pub outward: f64,
    /// Distance of the nodes (m).
    pub spacing: f64,
    /// From where to where it goes along the other axis (m), in plan.
    pub span: (f64, f64),
    /// Whether the other axis repeats itself there.
    pub periodic: bool,
    /// What flows in through it, in place of what is out there: one, or one for each of two layers. In a profile.
    pub feeds: Vec<Feed>,
    /// How far before it waves begin to die away (m); 0 for none.
    pub layer: f64,
}

/// Axis, place and direction of the sides of all layers.
type Sides = Vec<(usize, f64, f64)>;

/// Where a place is to side `number` of all: a corner belongs to the first of its sides. Sides of two layers stand at one place.
fn part_of<const D: usize>(sides: &Sides, number: usize, x: &Plan<D>) -> Part {
    let is_beyond = |(axis, place, outward): &(usize, f64, f64)| outward * (x[*axis] - place) > 0.0;
    match sides.iter().position(is_beyond) {
        None => Part::Within,
        Some(own) if sides[own] == sides[number] => Part::Beyond,
        Some(_) => Part::Elsewhere,
    }
}

impl<const D: usize> Flow<D> {
    /// Opens an end of a profile, before the first step. `spacing` is that of the nodes (m).
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn open(&mut self, place: f64, outward: f64, spacing: f64) -> Result<(), super::Failure> {
        self.open_all(&[Opening {
            axis: 0,
            place,
            outward,
            spacing,
            span: (0.0, 0.0),
            periodic: false,
            feeds: Vec::new(),
            layer: 0.0,
        }])
    }

    /// Opens sides, all of them at once and before the first step. Where they meet, the corner belongs to the first.
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn open_all(&mut self, openings: &[Opening]) -> Result<(), super::Failure> {
        let longest = self.sets.iter().flat_map(|set| &set.nodes.first_length).copied().fold(0.0, f64::max);
        let reach = self.reach_beyond(longest);
        let (gravity, time) = (self.settings.gravity, self.time);
        let known = self.opens.len();
        // Of two layers each has its sides.
        let strata = self.strata();
        let mut sides = self.sides();
        for opening in openings {
            sides.extend(strata.iter().map(|_| (opening.axis, opening.place, opening.outward)));
        }
        let all = openings.iter().flat_map(|opening| strata.iter().map(move |stratum| (opening, *stratum)));
        let mut later = Vec::new();
        for (number, (opening, stratum)) in (known..).zip(all) {
            let mut end = OpenEnd::new(opening, reach, openings, stratum);
            let set = stratum.map(|stratum| stratum.set);
            let feed = opening.feeds.iter().find(|feed| feed.layer == set).cloned();
            end.begin(&self.sets, &|x| part_of(&sides, number, x), gravity, time, feed.as_ref());
            let most = feed.as_ref().map_or(0.0, |feed| feed.fastest(gravity));
            self.fastest_start = self.fastest_start.max(most);
            // What flows in begins after the sums of what stands there are known.
            let stands = end.strips.iter().any(|strip| strip.still.is_some());
            let (now, then) = if stands { (None, feed) } else { (feed, None) };
            end.feed = now;
            later.push(then);
            self.opens.push(end);
        }
        self.pass_ends(0.0);
        self.settle_again()?;
        let kernel = self.settings.numerics.kernel;
        let Self { opens, sets, .. } = self;
        for (number, (end, feed)) in (known..).zip(opens[known..].iter_mut().zip(later)) {
            end.measure(kernel, sets, &|x| part_of(&sides, number, x));
            end.calm(sets, &|x| part_of(&sides, number, x));
            if feed.is_some() {
                end.feed = feed;
            }
        }
        Ok(())
    }

    /// How far nodes with this smoothing length (m) stand beyond an open side (m).
    pub fn reach_beyond(&self, length: f64) -> f64 {
        SUPPORTS * self.settings.numerics.kernel.support() * length
    }

    /// Axis, place and direction of each open side.
    fn sides(&self) -> Sides {
        self.opens.iter().map(|side| (side.axis, side.place, side.outward)).collect()
    }

    /// Which layers have sides of their own; none of one phase, or of grains and fluid.
    fn strata(&self) -> Vec<Option<Stratum>> {
        if self.settings.phases != Phases::Layers {
            return vec![None];
        }
        let densities = &self.settings.material.densities;
        let ratio = densities.fluid / densities.grain;
        (0..2).map(|set| Some(Stratum { set, ratio })).collect()
    }

    /// What has passed the open sides stands beyond them, in the state of the side, with its columns of pore pressure.
    pub(super) fn pass_ends(&mut self, dt: f64) {
        self.pass_nodes(dt);
        self.follow_columns();
    }

    fn pass_nodes(&mut self, dt: f64) {
        let sides = self.sides();
        for number in 0..self.opens.len() {
            let Self { settings, sets, opens, time, step, .. } = self;
            let (end, part) = (&mut opens[number], |x: &Plan<D>| part_of(&sides, number, x));
            let entered = end.count(sets, &part);
            end.meter(sets, &entered, (*time, settings.gravity));
            end.find_state(settings, sets, &part, (*time, dt, *step == 0));
            if end.stratum.is_none() {
                self.stand_beyond(number, &sides);
            }
        }
        self.look_at_layers(&sides, dt);
        for number in 0..self.opens.len() {
            if self.opens[number].stratum.is_some() {
                self.stand_beyond(number, &sides);
            }
        }
    }

    /// Each of two layers knows of the other at its side.
    fn look_at_layers(&mut self, sides: &Sides, dt: f64) {
        let Self { settings, sets, opens, time, .. } = self;
        for (pair, ends) in opens.chunks_mut(2).enumerate() {
            let [lower, upper] = ends else { return };
            if lower.stratum.is_none() {
                return;
            }
            let part = |x: &Plan<D>| part_of(sides, 2 * pair, x);
            let look = |end: &OpenEnd<D>| end.within(settings.numerics.kernel, sets, &part, end.inside());
            // In plan waves may come at an angle, which delays along the normal know nothing of.
            let arriving = (D == 1).then(|| [look(lower), look(upper)]);
            let (inside, reach) = (lower.inside(), lower.reach());
            for strip in 0..lower.strips.len() {
                let still = [lower.strips[strip].still, upper.strips[strip].still];
                let within = [lower.state.strips[strip].within, upper.state.strips[strip].within];
                for end in [&mut *lower, &mut *upper] {
                    let both = end.state.strips[strip].both.get_or_insert_default();
                    both.take(still, within);
                    if let Some([of_lower, of_upper]) = &arriving {
                        both.remember((*time, dt), [of_lower[strip], of_upper[strip]], inside, reach);
                    }
                }
            }
        }
    }

    /// Brings the nodes beyond side `number` into its state.
    fn stand_beyond(&mut self, number: usize, sides: &Sides) {
        let Self { sets, heads, opens, spare, next_id, .. } = self;
        let (end, count) = (&mut opens[number], sets.len());
        let part = |x: &Plan<D>| part_of(sides, number, x);
        for (role, set) in sets.iter_mut().enumerate() {
            if !end.is_of(role) {
                continue;
            }
            let (farthest, gone) = end.place(&mut set.nodes, (count, role), &part);
            if !gone.is_empty() {
                let nodes = &set.nodes;
                let stays = |i: &usize| gone.binary_search(&nodes.id[*i]).is_err();
                let order: Vec<u32> = (0..nodes.len()).filter(stays).map(|i| i as u32).collect();
                keep(set, (role == 0).then_some(&mut *heads), &order, spare);
            }
            let before = set.len();
            end.add(set, (count, role), &farthest, next_id);
            if role == 0 {
                (before..set.len()).for_each(|_| heads.push());
            }
        }
    }

    /// Nodes beyond open sides keep their velocity, whatever acts on them.
    pub(super) fn hold_beyond(&mut self) {
        let Self { opens, sets, .. } = self;
        for end in opens {
            for set in sets.iter_mut() {
                let nodes = &mut set.nodes;
                for i in 0..nodes.len() {
                    if end.state.ids.binary_search(&nodes.id[i]).is_ok() {
                        let x = nodes.position[i];
                        let stand = end.at(end.strip(&x), end.beyond(&x).max(0.0));
                        nodes.velocity[i] = end.velocity(&stand);
                    }
                }
            }
        }
    }

    /// Volume of the nodes beyond open sides (m³; m² in profiles).
    pub fn beyond(&self) -> f64 {
        let beyond = |nodes: &Nodes<D>| -> f64 {
            let own = nodes.id.iter().zip(&nodes.volume).filter(|(id, _)| self.is_beyond(**id));
            own.map(|(_, volume)| volume).sum()
        };
        self.sets.iter().map(|set| beyond(&set.nodes)).sum()
    }

    /// Whether node number `id` stands beyond an open side.
    pub(super) fn is_beyond(&self, id: u64) -> bool {
        self.opens.iter().any(|end| end.state.ids.binary_search(&id).is_ok())
    }

    /// Whether node number `id` stands beyond a side that something flows in through.
    pub(super) fn is_fed(&self, id: u64) -> bool {
        self.opens.iter().any(|end| end.is_fed() && end.state.ids.binary_search(&id).is_ok())
    }
}
