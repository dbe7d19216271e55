//! Rules of removal shapes (cuts).

use crate::error_collector::ErrorCollector;
use std::collections::HashSet;

use crate::CaseErrorKind;
use crate::description::RemovalShape;
use crate::output::{PLAIN_NAME_RULE, is_plain};

impl ErrorCollector<'_> {
    /// Checks the removal shapes.
    pub(super) fn removal_shapes(&mut self) {
        let mut names = HashSet::new();
        for (number, cut) in self.case.removal_shapes.iter().enumerate() {
            let path = format!("removal_shapes[{number}]");
            self.require(is_plain(&cut.name), format!("{path}.name"), PLAIN_NAME_RULE);
            let problem = format!("{:?} is the name of two removal shapes", cut.name);
            self.require(
                names.insert(&cut.name),
                format!("{path}.name"),
                CaseErrorKind::coded("duplicate-name", problem),
            );
            let problem = format!("{:?} is also the name of a measure", cut.name);
            self.require(
                !self.case.measures.contains_key(&cut.name),
                format!("{path}.name"),
                CaseErrorKind::coded("duplicate-name", problem),
            );
            self.removal_shape(&path, cut);
        }
    }

    /// Checks the shape, velocity and times of a removal shape.
    fn removal_shape(&mut self, path: &str, cut: &RemovalShape) {
        let case = self.case;
        if let Err(error) = cut.shape.validate(case.dimension()) {
            self.report(format!("{path}.shape.{}", error.path), error.problem);
        }
        self.vector(&format!("{path}.velocity"), &cut.velocity);
        self.not_negative(format!("{path}.start"), cut.start, " (s)");
        if let Some(stop) = cut.stop {
            let problem = format!("{stop} s must be after start, {} s", cut.start);
            self.require(stop.is_finite() && stop > cut.start, format!("{path}.stop"), problem);
        }
        if let Some(stage) = &cut.stage {
            let stages: Vec<&str> = case.stages.iter().map(|stage| stage.name.as_str()).collect();
            self.name(&format!("{path}.stage"), stage, &stages, "the name of a stage");
        }
        self.counted_bodies(path, cut.bodies.as_deref());
    }
}
