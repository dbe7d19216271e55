//! Step 3: bed below the nodes, and effective gravity there (sheet: depth-sph §2.9, as amended).

use rayon::prelude::*;

use crate::bed::{Bed, BedPoint};
use crate::config::choices::DepthFrame;
use crate::config::settings::FlowSettings;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::image_nodes::copy_with_images;

/// Effective gravity normal to the bed (m/s²; sheet: depth-sph §2.9, as amended).
struct EffectiveGravity {
    /// Effective gravity on pressure.
    pressure: f64,
    /// Effective gravity on the load of the bed: friction and pore pressure.
    normal: f64,
    /// Effective gravity of the reaction of the bed along its slope.
    reaction: f64,
}

impl EffectiveGravity {
    /// Effective gravity at a bed point, with an acceleration along the normal (m/s²). Where velocities are `carried` along the bed, the
    /// reaction leaves their rotation to that transport.
    fn at_bed_point<const D: usize>(
        settings: &FlowSettings<D>,
        bed: &BedPoint<D>,
        turning: f64,
        carried: bool,
    ) -> Self {
        let gravity = settings.gravity;
        if settings.frame != DepthFrame::Horizontal {
            return Self { pressure: gravity, normal: gravity, reaction: gravity };
        }
        let steepness = bed.steepness();
        let still = gravity / steepness;
        let turned = still + turning / steepness.sqrt();
        Self {
            pressure: still,
            normal: if settings.curvature_in_friction { turned.max(0.0) } else { still },
            reaction: if carried { still } else { turned },
        }
    }
}

/// Time at which the bed below the nodes is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BedSampling {
    /// The bed has not been sampled since they have moved.
    Required,
    /// The bed was sampled by the drift that moved them.
    AlreadySampled,
}

/// Step 3: samples the bed below each node and updates the effective gravity.
pub(crate) fn sample_bed<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    sets: &mut [PhaseSet<D>],
    sampling: BedSampling,
) {
    for set in &mut *sets {
        sample_bed_below(settings, bed, set, sampling);
    }
    if settings.numerics.surface_gradient {
        for set in sets {
            set.scratch_scalars.clear();
            set.scratch_scalars.extend(set.bed.iter().map(|bed| bed.level));
            copy_with_images(&set.images, &set.scratch_scalars, &mut set.neighbour_data.level);
        }
    }
}

/// Samples the bed below all nodes after a restart; nodes outside the bed get a horizontal one.
pub(crate) fn resample_bed<const D: usize>(bed: &Bed<D>, sets: &mut [PhaseSet<D>]) {
    for set in sets {
        let below = set.nodes.position.iter().map(|x| bed.bed_below(x));
        set.bed.clear();
        set.bed.extend(below);
    }
}

/// Samples the bed below all nodes of a set and updates their effective gravity and bed reaction.
fn sample_bed_below<const D: usize>(
    settings: &FlowSettings<D>,
    bed: &Bed<D>,
    set: &mut PhaseSet<D>,
    sampling: BedSampling,
) {
    let carried = sampling == BedSampling::AlreadySampled && bed.transports_velocities(settings);
    let PhaseSet { nodes, bed: points, reaction, curvature_acceleration, .. } = set;
    points.resize(nodes.len(), BedPoint::horizontal(0.0));
    reaction.resize(nodes.len(), 0.0);
    curvature_acceleration.resize(nodes.len(), 0.0);
    let (position, velocity) = (&nodes.position, &nodes.velocity);
    let columns =
        points.par_iter_mut().zip(&mut nodes.effective_gravity).zip(&mut nodes.bed_gravity).zip(reaction);
    columns.zip(&*curvature_acceleration).enumerate().with_min_len(MIN_NODES_PER_TASK).for_each(
        |(i, ((((point, gravity), bearing), reaction), turning))| {
            // Nodes beyond the bed keep the last bed below them until they are removed at the end of the step.
            if sampling == BedSampling::Required
                && let Some(found) = bed.bed_point(&position[i])
            {
                *point = found;
            }
            let turning = if carried {
                *turning
            } else {
                point.curvature_acceleration(&velocity[i]) / point.steepness().sqrt()
            };
            let effective = EffectiveGravity::at_bed_point(settings, point, turning, carried);
            (*gravity, *bearing, *reaction) = (effective.pressure, effective.normal, effective.reaction);
        },
    );
}
