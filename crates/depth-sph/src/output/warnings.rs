//! Warnings about the state of a flow at the end of its run.

use colluvium_case::Case;

use crate::output::flow_view::FlowView;
use crate::output::hazard_rasters::HazardRasters;
use crate::output::scalar_outputs::RunState;
use colluvium_case::Warning;

/// Warnings about the state at the end of the run.
pub(crate) fn warnings_at_end<const D: usize>(
    flow: &FlowView<'_, D>,
    case: &Case,
    rasters: Option<&HazardRasters>,
    state: &RunState,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if flow.records.removed_nodes > 0 {
        warnings.push(Warning::new(
            "volume-left-terrain",
            format!(
                "{} nodes with a volume of {:.4e} m³ have left the terrain, over its edge or into cells without data, \
             and were removed. If this volume matters, make the terrain larger or fill the cells without data",
                flow.records.removed_nodes,
                flow.records.outflow_volume.iter().sum::<f64>()
            ),
        ));
    }
    if rasters.is_some_and(HazardRasters::are_empty) {
        let threshold = case.output.rasters.as_ref().map_or(0.0, |rasters| rasters.threshold);
        warnings.push(Warning::new(
            "empty-rasters",
            format!(
                "output.rasters.threshold: the flow was less than {threshold} m deep in all cells, so the \
             rasters are empty. Lower the threshold"
            ),
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
        warnings.push(Warning::new(
            "energy-error",
            format!(
                "the computation has {} {:.2e} J by numerical error, {:.1} % of the {:.2e} J that the flow \
             has exchanged (column energy_error of the measures). To reduce the error, {cure}",
                if account.error > 0.0 { "gained" } else { "lost" },
                account.error.abs(),
                100.0 * account.error.abs() / account.exchanged_energy,
                account.exchanged_energy
            ),
        ));
    }
    warnings.extend(erosion_warning(flow));
    warnings.extend(state.stop_time.is_nan().then(|| stop_warning(flow)));
    warnings
}

/// Warning of a flow that has not stopped.
fn stop_warning<const D: usize>(flow: &FlowView<'_, D>) -> Warning {
    let mut velocities = flow.sets().iter().flat_map(|set| &set.nodes.velocity);
    let text = if velocities.any(|velocity| velocity.iter().any(|component| *component != 0.0)) {
        "the flow still moves at the end of the run: the criterion of methods.depth-sph.stop is not met. Make \
         the last stage longer"
    } else {
        "the flow is at rest at the end of the run, but for a shorter time than methods.depth-sph.stop.hold. \
         Make the last stage longer if you need the time at which it stopped"
    };
    Warning::new("flow-still-moves", text)
}

/// Eroded volume over the released one above which there is a warning. Debris flows entrain up to some ten times their initial volume.
const MAX_ENTRAINMENT: f64 = 10.0;

/// Warning of more erosion than observed debris flows have.
fn erosion_warning<const D: usize>(flow: &FlowView<'_, D>) -> Option<Warning> {
    let eroded: f64 = flow.records.eroded_volume.iter().sum();
    let left: f64 = flow.records.outflow_volume.iter().sum();
    let present: f64 = flow.sets().iter().flat_map(|set| &set.nodes.volume).sum();
    let ratio = eroded / (present + left - eroded);
    let is_excessive = eroded > 0.0 && !(0.0..=MAX_ENTRAINMENT).contains(&ratio);
    is_excessive.then(|| {
        Warning::new(
            "excessive-erosion",
            format!(
                "{eroded:.3e} m³ were eroded from the bed, {ratio:.0} times the volume that was released or flowed in. \
                 Reduce methods.depth-sph.erosion, or limit it with methods.depth-sph.erodible_depth"
            ),
        )
    })
}
