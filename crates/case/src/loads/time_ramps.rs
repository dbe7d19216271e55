//! What grows in a stage: gravity, loads, prescribed motions.

use crate::Case;
use crate::description::Load;

impl Case {
    /// The loads that act in stage number `stage`: their numbers, and those of the stages they begin with.
    pub(crate) fn loads_in(&self, stage: usize) -> impl Iterator<Item = (usize, usize, &Load)> {
        self.loads.iter().enumerate().filter_map(move |(number, load)| {
            let begins = load.begins(&self.stages)?;
            (begins <= stage && !self.is_removed(load.body(), stage)).then_some((number, begins, load))
        })
    }

    /// Whether gravity, the motions of the stage and all loads have their full size at `time` (s). `starts` are when the
    /// stages began (s), the one that runs the last.
    pub(crate) fn ramps_are_complete(&self, starts: &[f64], time: f64) -> bool {
        let Some(number) = starts.len().checked_sub(1) else { return false };
        let stage = &self.stages[number];
        let ramps = stage.motions.iter().map(|motion| motion.ramp).chain([stage.gravity_ramp]);
        ramps.into_iter().all(|ramp| time - starts[number] >= ramp)
            && self.loads_in(number).all(|(_, begins, load)| time - starts[begins] >= load.ramp().0)
    }
}
