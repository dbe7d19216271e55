//! Warnings about the state of a flow at the end of its run.

use colluvium_case::Case;

use crate::output::flow_view::FlowView;
use crate::output::hazard_rasters::HazardRasters;
use crate::output::scalar_outputs::RunState;

/// Warnings about the state at the end of the run.
pub(crate) fn warnings_at_end<const D: usize>(
    flow: &FlowView<'_, D>,
    case: &Case,
    rasters: Option<&HazardRasters>,
    state: &RunState,
) -> Vec<String> {
    let mut warnings = Vec::new();
    if flow.records.removed_nodes > 0 {
        warnings.push(format!(
            "{} nodes with a volume of {:.4e} m³ have left the terrain and were removed. If this \
             volume matters, make the terrain larger",
            flow.records.removed_nodes,
            flow.records.outflow_volume.iter().sum::<f64>()
        ));
    }
    if rasters.is_some_and(HazardRasters::are_empty) {
        let threshold = case.output.rasters.as_ref().map_or(0.0, |rasters| rasters.threshold);
        warnings.push(format!(
            "output.rasters.threshold: the flow was less than {threshold} m deep in all cells, so the \
             rasters are empty"
        ));
    }
    let account = flow.energy_balance();
    if account.is_off() {
        let cure = match (state.fit_errors.is_some(), flow.settings.numerics.variable_length) {
            (true, true) => {
                "set `variable_smoothing` to false, increase `terrain_smoothing` or reduce `spacing`"
            }
            (true, false) => "increase `terrain_smoothing` or reduce `spacing`",
            (false, true) => "set `variable_smoothing` to false, or `momentum` to `variational`",
            (false, false) => "set `momentum` to `variational`, or reduce `spacing`",
        };
        warnings.push(format!(
            "the computation has {} {:.2e} J by numerical error, {:.1} % of the {:.2e} J that the flow \
             has exchanged (column energy_error of the measures). To reduce the error, {cure}",
            if account.error > 0.0 { "gained" } else { "lost" },
            account.error.abs(),
            100.0 * account.error.abs() / account.exchanged_energy,
            account.exchanged_energy
        ));
    }
    if state.stop_time.is_nan() {
        warnings.push(
            "the flow still moves at the end of the run: the criterion of methods.depth-sph.stop is \
             not met"
                .to_owned(),
        );
    }
    warnings
}
