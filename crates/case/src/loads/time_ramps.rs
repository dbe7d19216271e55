//! Ramps in a stage: gravity, loads, prescribed motions.

use crate::Case;
use crate::description::Load;

impl Case {
    /// Loads that act in stage number `stage`. Each entry has the index of the load, the index of the stage with which it begins, and the
    /// load.
    pub(crate) fn loads_in(&self, stage: usize) -> impl Iterator<Item = (usize, usize, &Load)> {
        self.loads.iter().enumerate().filter_map(move |(number, load)| {
            let begins = load.first_stage(&self.stages)?;
            (begins <= stage && !self.is_removed(load.body(), stage)).then_some((number, begins, load))
        })
    }

    /// Whether the ramps of gravity, of the motions of the stage and of all loads are complete at `time` (s). `starts` are the start times
    /// of the stages (s), up to the current one.
    pub(crate) fn ramps_are_complete(&self, starts: &[f64], time: f64) -> bool {
        let Some(number) = starts.len().checked_sub(1) else { return false };
        let stage = &self.stages[number];
        let ramps = stage.motions.iter().map(|motion| motion.ramp).chain([stage.gravity_ramp]);
        ramps.into_iter().all(|ramp| time - starts[number] >= ramp)
            && self.loads_in(number).all(|(_, begins, load)| time - starts[begins] >= load.ramp().0)
    }
}
