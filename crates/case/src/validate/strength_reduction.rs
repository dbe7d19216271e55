//! Rules of weakened stages and of searches for a factor of safety.

use crate::CaseErrorKind;
use crate::description::{FactorOfSafety, Load};
use crate::error_collector::ErrorCollector;
use crate::measure::{MeasureDefinition, MeasuredState, ScalarOutput};

/// Largest number of trials of a search: more would take impractically long.
const MAX_TRIALS: f64 = 40.0;

impl ErrorCollector<'_> {
    /// Checks the strength reduction of a stage.
    pub(super) fn weakening(&mut self, stage: usize) {
        let Some(weakening) = &self.case.stages[stage].weakening else { return };
        let path = format!("stages[{stage}].weakening");
        self.positive(format!("{path}.factor"), weakening.factor, "strength is divided by it");
        self.weakened_materials(&path, weakening.materials.as_deref());
        let sound = weakening.factor.is_finite() && weakening.factor > 0.0;
        if let (true, Err(error)) = (sound, self.case.with_weakening(stage)) {
            self.report(error.path, error.kind);
        }
    }

    /// Checks a search for the factor of safety.
    fn factor_of_safety(&mut self, path: &str, search: &FactorOfSafety) {
        let stages: Vec<&str> = self.case.stages.iter().map(|stage| stage.name.as_str()).collect();
        self.name(&format!("{path}.after"), &search.after, &stages, "the name of a stage");
        self.loads_before_search(search);
        for (key, value, unit) in [("duration", search.duration, "s"), ("height", search.height, "m")] {
            if let Some(value) = value {
                self.positive(format!("{path}.{key}"), value, unit);
            }
        }
        let weighs = self.case.gravity.iter().any(|g| *g != 0.0);
        let problem = "cannot be determined without gravity: give the longest duration of a trial (s)";
        self.require(weighs || search.duration.is_some(), format!("{path}.duration"), problem);
        self.positive(format!("{path}.tolerance"), search.tolerance, "a width");
        let damping = search.damping;
        let holds = (0.0..1.0).contains(&damping);
        self.rule(holds, format!("{path}.damping"), damping, "is not in 0..1 (1 excluded)");
        let [low, high] = search.range;
        let sound = low.is_finite() && high.is_finite() && 0.0 < low && low < high;
        self.require(
            sound,
            format!("{path}.range"),
            format!("{low} and {high} must be positive and ascending"),
        );
        let trials = ((high - low) / search.tolerance).log2();
        let problem = format!("{} would take {trials:.0} trials", search.tolerance);
        self.require(!(trials > MAX_TRIALS), format!("{path}.tolerance"), problem);
        self.weakened_materials(path, search.materials.as_deref());
        if let (true, Err(problem)) = (sound, self.case.check_search(search)) {
            self.report(format!("{path}.range"), problem);
        }
    }

    /// Requires that all loads begin before a search.
    fn loads_before_search(&mut self, search: &FactorOfSafety) {
        let stage = |name: &str| self.case.stages.iter().position(|stage| stage.name == name);
        let Some(last) = stage(&search.after) else { return };
        let late = |load: &Load| load.stage().and_then(stage).is_some_and(|begin| begin > last);
        let late: Vec<usize> = (0..self.case.loads.len()).filter(|k| late(&self.case.loads[*k])).collect();
        for number in late {
            let problem = format!(
                "begins after the stage {:?}, at whose end a search for the factor of safety begins. Give the stage of \
                 the load, or a later one, as `after` of the search",
                search.after
            );
            self.report(format!("loads[{number}].stage"), CaseErrorKind::coded("conflicting-keys", problem));
        }
    }

    /// Checks the names of the materials whose strength is reduced.
    fn weakened_materials(&mut self, path: &str, names: Option<&[String]>) {
        let materials: Vec<&str> = self.case.materials.keys().map(String::as_str).collect();
        for (number, name) in names.unwrap_or_default().iter().enumerate() {
            self.name(&format!("{path}.materials[{number}]"), name, &materials, "defined under materials");
        }
    }
}

impl MeasureDefinition for FactorOfSafety {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        errors.factor_of_safety(path, self);
    }

    /// No columns: the factor is found after the run.
    fn read(&self, _name: &str, _state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        Vec::new()
    }

    fn is_single_number(&self) -> bool {
        true
    }
}
