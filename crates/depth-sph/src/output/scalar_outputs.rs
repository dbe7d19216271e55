//! Scalar outputs of a flow in each row of the measures.

use colluvium_case::measure::ScalarOutput;

use crate::boundary::open::OpenBoundary;
use crate::config::choices::Phases;
use crate::output::flow_view::FlowView;
use crate::output::hazard_rasters::HazardRasters;
use crate::phases::phase::PhaseSet;

/// State of a run that is not part of the flow: stopping time and errors of the bed surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RunState {
    /// Time at which the flow had stopped (s); NaN before.
    pub stop_time: f64,
    /// Largest and root-mean-square difference of the bed surface from the levels of its raster (m).
    pub fit_errors: Option<[f64; 2]>,
}

/// Scalar output with its name, unit and value.
fn output(name: &str, unit: &str, value: f64) -> ScalarOutput {
    (name.to_owned(), unit.to_owned(), value)
}

/// Energy balance (J): energies of bed and pressure, dissipation, inflow, and the error.
fn energy_outputs<const D: usize>(flow: &FlowView<'_, D>) -> [(&'static str, f64); 7] {
    let (account, ledger) = (flow.energy_balance(), &flow.records.energy_balance);
    [
        ("energy_bed", account.current_energy.bed),
        ("energy_pressure", account.current_energy.pressure),
        ("energy_friction", ledger.friction),
        ("energy_viscosity", ledger.viscosity),
        ("energy_entered", ledger.inflow),
        ("energy_error", account.error),
        ("pressure_work_difference", account.difference),
    ]
}

/// Scalar outputs of the method, one per column of the table of measures.
pub(crate) fn scalar_outputs<const D: usize>(
    flow: &FlowView<'_, D>,
    rasters: Option<&HazardRasters>,
    state: &RunState,
) -> Vec<ScalarOutput> {
    let mut outputs = flow_outputs(flow);
    outputs.push(output("stopped", "s", state.stop_time));
    outputs.extend(energy_outputs(flow).map(|(name, value)| output(name, "J", value)));
    if let Some([largest, mean]) = state.fit_errors {
        outputs.push(output("bed_off_raster", "m", largest));
        outputs.push(output("bed_off_raster_rms", "m", mean));
    }
    outputs.extend(inflow_outputs(flow));
    outputs.extend(erosion_outputs(flow));
    if let Some(areas) = rasters.and_then(HazardRasters::score) {
        let names = ["mapped_hit", "mapped_missed", "mapped_beyond"];
        outputs.extend(names.iter().zip(areas).map(|(name, area)| output(name, "m2", area)));
        outputs.push(output("mapped_fit", "", areas[0] / areas.iter().sum::<f64>()));
    }
    outputs.extend(mean_liquefaction(flow));
    outputs
}

/// Volumes, largest depth and largest speed.
fn flow_outputs<const D: usize>(flow: &FlowView<'_, D>) -> Vec<ScalarOutput> {
    let sets = flow.sets();
    let volume: f64 = sets.iter().map(|set| set.nodes.total_volume()).sum();
    let left: f64 = flow.records.outflow_volume.iter().sum();
    let boundary = flow.boundary;
    let depth = |set: &PhaseSet<D>| set.nodes.depth.iter().copied().fold(0.0, f64::max);
    let speed = |set: &PhaseSet<D>| {
        let speed = |i: usize| set.bed[i].speed(&set.nodes.velocity[i]);
        (0..set.len()).map(speed).fold(0.0, f64::max)
    };
    vec![
        output("flow_volume", "m3", volume - boundary.waiting_volume(sets)),
        output(
            "volume_left",
            "m3",
            if boundary.open_sides.is_empty() { left } else { left + boundary.outflow_volume() },
        ),
        output("largest_depth", "m", sets.iter().map(depth).fold(0.0, f64::max)),
        output("largest_speed", "m/s", sets.iter().map(speed).fold(0.0, f64::max)),
    ]
}

/// Volumes that have entered, for a case with inflow.
fn inflow_outputs<const D: usize>(flow: &FlowView<'_, D>) -> Vec<ScalarOutput> {
    let boundary = flow.boundary;
    if boundary.inflows.is_empty() && !boundary.open_sides.iter().any(OpenBoundary::has_inlet) {
        return Vec::new();
    }
    let mut outputs = vec![output("volume_entered", "m3", boundary.inflow_volume())];
    if flow.settings.phases == Phases::Two {
        outputs.push(output("fluid_entered", "m3", boundary.fluid_entered()));
    }
    outputs
}

/// Eroded volume and depth, where the bed is eroded.
fn erosion_outputs<const D: usize>(flow: &FlowView<'_, D>) -> Vec<ScalarOutput> {
    let mut outputs = Vec::new();
    if flow.has_erosion() {
        outputs.push(output("volume_eroded", "m3", flow.records.eroded_volume.iter().sum()));
    }
    if let Some(erodible) = flow.bed.erodible() {
        outputs.push(output("deepest_erosion", "m", erodible.eroded_depths().fold(0.0, f64::max)));
    }
    outputs
}

/// Mean liquefaction ratio of the grains, for a case with pore-pressure columns.
fn mean_liquefaction<const D: usize>(flow: &FlowView<'_, D>) -> Option<ScalarOutput> {
    let columns = &flow.nodes.pore_columns;
    if columns.is_empty() {
        return None;
    }
    let (mut weighted, mut whole) = (0.0, 0.0);
    let solid = &flow.sets()[0].nodes;
    for i in (0..solid.len()).filter(|i| !flow.boundary.is_outside(solid.id[*i])) {
        weighted += solid.volume[i] * columns.base_head(i) / solid.depth[i];
        whole += solid.volume[i];
    }
    Some(output("mean_liquefaction", "", weighted / whole))
}
