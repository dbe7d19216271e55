//! Monitor of the total energy of a run, which warns of spurious growth.

use serde::{Deserialize, Serialize};

use crate::Budget;
use colluvium_constitutive::Warning;

/// Relative growth of the total energy without a warning, over the largest exchange of energy.
const GROWTH_TOLERANCE: f64 = 0.01;

/// Least exchange of energy over the largest recoverable energy: smaller exchanges are within the accuracy of the energies.
const MIN_EXCHANGE: f64 = 0.1;

/// Monitor of the total energy of a stage, the sum of kinetic, recoverable and potential energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct EnergyMonitor {
    /// Kinetic, recoverable and potential energy at the first row (J).
    first: Option<[f64; 3]>,
    /// Least total energy so far (J).
    min_total: f64,
    /// Largest change of one of the three energies since the first row (J).
    exchange: f64,
    /// Largest recoverable energy so far (J).
    max_recoverable: f64,
    /// Largest rise of the total energy above an earlier value (J), and its time (s).
    growth: (f64, f64),
}

impl EnergyMonitor {
    /// Whether the energy of the stage is monitored: no external work is done on its bodies.
    pub(super) fn is_followed(&self) -> bool {
        self.first.is_some()
    }

    /// Adds the energies of a row at `time` (s).
    pub(super) fn add_row(&mut self, budget: &Budget, time: f64) {
        let now = [budget.kinetic, budget.elastic, budget.potential];
        let total = budget.total();
        if !total.is_finite() {
            return;
        }
        self.max_recoverable = self.max_recoverable.max(budget.elastic);
        let Some(first) = self.first else {
            (self.first, self.min_total) = (Some(now), total);
            return;
        };
        let changes = now.iter().zip(first).map(|(now, first)| (now - first).abs());
        self.exchange = changes.fold(self.exchange, f64::max);
        self.min_total = self.min_total.min(total);
        if total - self.min_total > self.growth.0 {
            self.growth = (total - self.min_total, time);
        }
    }

    /// Returns a warning if the total energy has grown beyond the tolerance.
    pub(super) fn warning(&self) -> Option<Warning> {
        let (growth, time) = self.growth;
        if growth <= GROWTH_TOLERANCE * self.exchange.max(MIN_EXCHANGE * self.max_recoverable) {
            return None;
        }
        Some(Warning::new(
            "energy-gain",
            format!(
                "the total energy has grown by {growth:.2e} J until {time:.4} s, {:.1} % of the largest change \
             of kinetic, recoverable or potential energy, without external work. The growth is a numerical \
             error (column total_energy of the measures). To find its source, try a shorter step, other \
             shape functions or schemes, or some damping",
                100.0 * growth / self.exchange
            ),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warning_for(total: impl Fn(f64) -> f64) -> Option<Warning> {
        let mut watch = EnergyMonitor::default();
        for step in 0..200 {
            let time = 0.01 * f64::from(step);
            let kinetic = total(time) * (5.0 * time).sin().powi(2);
            watch.add_row(&Budget { kinetic, elastic: total(time) - kinetic, ..Budget::default() }, time);
        }
        watch.warning()
    }

    #[test]
    fn only_growth_of_the_total_energy_causes_a_warning() {
        assert_eq!(warning_for(|_| 3.0), None);
        assert_eq!(warning_for(|time| 3.0 * (-time).exp()), None);
        assert_eq!(warning_for(|time| 3.0 + 0.01 * (40.0 * time).sin()), None);
        let warning = warning_for(|time| 3.0 + 0.1 * time).unwrap();
        assert!(warning.text.contains("grown by 1.99e-1 J until 1.9900 s"), "{warning}");
        // Growth after a decrease of the energy.
        assert!(warning_for(|time| if time < 1.0 { 3.0 - time } else { 2.0 + 0.2 * (time - 1.0) }).is_some());
    }
}
