//! Forces on grains that the case gives: on bodies, and on membranes (sheet: dem §2.1).

use super::DemSolver;
use crate::config::GrainStage;
use crate::vector::{add, dot, minus};

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Forces on the grains that are neither gravity nor of contacts (N); empty where the stage has none.
    pub(crate) fn applied(&self) -> Vec<[f64; D]> {
        let stage = self.options.stages.get(&self.case.stages[self.stage].name);
        let Some(stage) = stage.filter(|own| !(own.forces.is_empty() && own.membranes.is_empty())) else {
            return Vec::new();
        };
        let mut applied = vec![[0.0; D]; self.grains.len()];
        self.push_bodies(stage, &mut applied);
        for (name, membrane) in &stage.membranes {
            self.press_membrane((name, &membrane.against), membrane.pressure, &mut applied);
        }
        applied
    }

    /// Shares forces on bodies among their grains by mass.
    fn push_bodies(&self, stage: &GrainStage, applied: &mut [[f64; D]]) {
        let g = &self.grains;
        for (name, force) in &stage.forces {
            let Some(body) = self.number_of(name) else { continue };
            let own = || (0..g.len()).filter(|&i| g.body[i] == body);
            let mass: f64 = own().map(|i| g.mass[i]).sum();
            let force: [f64; D] = std::array::from_fn(|c| force[c]);
            own().for_each(|i| add(&mut applied[i], g.mass[i] / mass, &force));
        }
    }

    /// Presses a row of grains towards a body: half of what acts on the line between two of them each.
    fn press_membrane(&self, (name, against): (&str, &str), pressure: f64, applied: &mut [[f64; D]]) {
        let g = &self.grains;
        let (Some(own), Some(other)) = (self.number_of(name), self.number_of(against)) else { return };
        let mut row: Vec<usize> = (0..g.len()).filter(|&i| g.body[i] == own).collect();
        row.sort_unstable_by_key(|&i| g.id[i]);
        let (Some(first), Some(last)) = (row.first(), row.last()) else { return };
        let Some(centre) = self.centre(|i| g.body[i] == other) else { return };
        // A quarter turn to the left of the row, or the other way where the body lies to its right.
        let left =
            |way: &[f64; D]| -> [f64; D] { std::array::from_fn(|c| if c == 0 { -way[1] } else { way[0] }) };
        let chord = minus(&g.position[*last], &g.position[*first]);
        let Some(middle) = self.centre(|i| g.body[i] == own) else { return };
        let side = dot(&left(&chord), &minus(&centre, &middle));
        let half = 0.5 * pressure * if side < 0.0 { -1.0 } else { 1.0 };
        for pair in row.windows(2) {
            let push = left(&minus(&g.position[pair[1]], &g.position[pair[0]]));
            pair.iter().for_each(|&i| add(&mut applied[i], half, &push));
        }
    }

    /// Mean place of some grains by mass (m); none where there are none.
    fn centre(&self, holds: impl Fn(usize) -> bool) -> Option<[f64; D]> {
        let g = &self.grains;
        let (mut mass, mut moment) = (0.0, [0.0; D]);
        for i in (0..g.len()).filter(|&i| holds(i)) {
            mass += g.mass[i];
            add(&mut moment, g.mass[i], &g.position[i]);
        }
        (mass > 0.0).then(|| moment.map(|c| c / mass))
    }

    fn number_of(&self, body: &str) -> Option<u32> {
        Some(self.case.bodies.iter().position(|own| own.name == body)? as u32)
    }
}
