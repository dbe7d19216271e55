//! Steps 5 and 6: drag, and resistance of the bed (sheet: depth-sph §3.4).

use crate::config::choices::Phases;
use crate::config::settings::FlowSettings;
use crate::flow_nodes::FlowNodes;
use crate::momentum::drag_and_resistance::{apply_drag_and_resistance, apply_resistance_single};
use crate::momentum::interface_friction::apply_interface_friction;
use crate::phases::limits::FlowLimits;
use crate::phases::phase::PhaseSet;

/// Applies drag and the resistance of the bed over a step of `dt` (s).
pub(super) fn apply_resistance<const D: usize>(
    settings: &FlowSettings<D>,
    limits: &FlowLimits,
    nodes: &mut FlowNodes<D>,
    dt: f64,
) {
    match settings.phases {
        Phases::One => apply_resistance_single(settings, nodes, dt),
        Phases::Two => {
            nodes.sets.iter_mut().for_each(PhaseSet::update_image_velocities);
            apply_drag_and_resistance(settings, limits, nodes, dt);
        }
        Phases::Layers => {
            apply_resistance_single(settings, nodes, dt);
            apply_interface_friction(settings, limits, &mut nodes.sets, dt);
        }
    }
}
