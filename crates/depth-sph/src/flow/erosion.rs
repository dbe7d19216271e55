//! Step 8: erosion of the bed, with its energy (sheet: depth-sph §3.4).

use crate::bed::Bed;
use crate::boundary::FlowBoundaries;
use crate::clock::Clock;
use crate::config::settings::FlowSettings;
use crate::energy_balance::FlowRecords;
use crate::energy_balance::balance::energies;
use crate::momentum::curved_drift::transport_velocities;
use crate::momentum::entrainment::{entrain, extend_paths};
use crate::phases::phase::PhaseSet;

/// Erodes the bed in a step of `dt` (s). The nodes entrain the material, so that their momentum is shared with it.
pub(super) fn erode_bed<const D: usize>(
    clock: &Clock,
    settings: &FlowSettings<D>,
    bed: &mut Bed<D>,
    boundary: &FlowBoundaries<D>,
    sets: &mut [PhaseSet<D>],
    records: &mut FlowRecords,
    dt: f64,
) {
    extend_paths(sets, dt);
    if settings.zones.iter().all(|zone| zone.erosion.is_none()) {
        return;
    }
    let before = energies(settings, bed, boundary, sets);
    entrain(settings, bed, sets, &mut records.eroded_volume, dt);
    let is_lowered = match bed {
        Bed::Erodible(erodible) => erodible.update_surface::<D>(clock.step),
        _ => false,
    };
    if is_lowered {
        transport_velocities(settings, bed, &boundary.walls, sets);
    }
    records.energy_balance.add_erosion(&before, &energies(settings, bed, boundary, sets));
}
