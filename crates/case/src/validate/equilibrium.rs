//! Rules of stages that end at equilibrium.

use crate::CaseErrorKind;
use crate::error_collector::ErrorCollector;

impl ErrorCollector<'_> {
    /// Checks the equilibrium criterion of a stage.
    pub(super) fn equilibrium(&mut self, number: usize) {
        let case = self.case;
        let stage = &case.stages[number];
        let Some(criterion) = &stage.equilibrium else { return };
        let path = format!("stages[{number}]");
        let bounds =
            [("unbalanced_force", criterion.unbalanced_force), ("kinetic_energy", criterion.kinetic_energy)];
        for (key, value) in bounds {
            let path = format!("{path}.equilibrium.{key}");
            self.require(value > 0.0 && value < 1.0, path, format!("{value} is not between 0 and 1"));
        }
        self.require(criterion.hold >= 1, format!("{path}.equilibrium.hold"), "must be at least 1");
        let searched = case.factors_of_safety().find(|(_, search)| search.after == stage.name);
        if let (Some((name, _)), false) = (searched, criterion.required) {
            let problem = format!(
                "the search of measures.{name} begins from rest, so the stage must reach equilibrium: leave \
                 this key out"
            );
            self.require(
                false,
                format!("{path}.equilibrium.required"),
                CaseErrorKind::coded("conflicting-keys", problem),
            );
        }
        for (motion, ramp) in stage.motions.iter().map(|motion| motion.ramp).enumerate() {
            let problem = format!("{ramp} s is longer than the stage, which must come to rest");
            self.require(!(ramp > stage.duration), format!("{path}.motions[{motion}].ramp"), problem);
        }
        for (load, begins, ramp) in case.loads_in(number).map(|(n, begins, load)| (n, begins, load.ramp().0))
        {
            let longest: f64 = case.stages[begins..=number].iter().map(|stage| stage.duration).sum();
            let problem = format!(
                "{ramp} s is longer than the {longest} s until the end of the stage {:?}, which must come to \
                 rest under the load",
                stage.name
            );
            self.require(!(ramp > longest), format!("loads[{load}].ramp"), problem);
        }
    }
}
