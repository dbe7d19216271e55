//! Rules of measures.

use crate::error_collector::ErrorCollector;
use crate::output::{PLAIN_NAME_RULE, is_plain};

impl ErrorCollector<'_> {
    /// Checks the measures.
    pub(super) fn measures(&mut self) {
        for (name, measure) in &self.case.measures {
            let path = format!("measures.{name}");
            self.require(is_plain(name), path.clone(), PLAIN_NAME_RULE);
            measure.check(&path, self);
        }
    }
}
