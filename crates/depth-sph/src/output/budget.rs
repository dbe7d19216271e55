//! Totals of all phases for the budget of a run.

use colluvium_case::{Budget, PhaseBudget};

use crate::config::choices::Phases;
use crate::output::flow_view::FlowView;
use crate::output::snapshot::along_bed;
use crate::output::totals::{PhaseTotals, totals};

/// Totals of mass, momentum and energy.
pub(crate) fn budget<const D: usize>(flow: &FlowView<'_, D>) -> Budget {
    let spatial = |totals: &PhaseTotals<D>| {
        let mut momentum = along_bed(&totals.momentum, &[0.0; D]);
        momentum[D] = totals.vertical_momentum;
        momentum
    };
    let of_set = |set: usize| totals(flow.settings, flow.bed, flow.sets(), set);
    let all: Vec<PhaseTotals<D>> = (0..flow.sets().len()).map(of_set).collect();
    let sum = |value: &dyn Fn(&PhaseTotals<D>) -> f64| all.iter().map(value).sum();
    let momentum = std::array::from_fn(|c| all.iter().map(|t| spatial(t)[c]).sum());
    let liquid = all.get(1).filter(|_| flow.settings.phases == Phases::Two).map(|t| PhaseBudget {
        mass: t.mass,
        momentum: spatial(t),
        kinetic: t.kinetic,
        elastic: 0.0,
        potential: t.potential,
    });
    Budget {
        mass: sum(&|t| t.mass),
        momentum,
        angular_momentum: [f64::NAN; 3],
        kinetic: sum(&|t| t.kinetic),
        elastic: 0.0,
        potential: sum(&|t| t.potential),
        liquid,
    }
}
