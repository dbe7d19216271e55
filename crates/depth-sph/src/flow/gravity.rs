//! Step 3: the bed below the nodes, and gravity as it acts there (sheet: depth-sph §2.9, as amended).

use rayon::prelude::*;

use super::set::{Set, TASK, copy};
use super::{Asked, Flow};
use crate::bed::BedPoint;
use crate::choices::Frame;
use crate::settings::Settings;

/// Effective gravity over a bed (m/s²; sheet: depth-sph §2.9, as amended).
struct Gravity {
    /// That of pressure.
    pressure: f64,
    /// That of what the bed bears: friction and pore pressure.
    bearing: f64,
    /// That of the reaction of the bed along its slope.
    reaction: f64,
}

impl Gravity {
    /// Over a place of the bed, of what turns with this acceleration along its normal (m/s²). Where velocities are `carried` along the bed the
    /// reaction leaves the turning to that.
    fn over<const D: usize>(settings: &Settings<D>, bed: &BedPoint<D>, turning: f64, carried: bool) -> Self {
        let gravity = settings.gravity;
        if settings.frame != Frame::Horizontal {
            return Self { pressure: gravity, bearing: gravity, reaction: gravity };
        }
        let steepness = bed.steepness();
        let still = gravity / steepness;
        let turned = still + turning / steepness.sqrt();
        Self {
            pressure: still,
            bearing: if settings.curvature_in_friction { turned.max(0.0) } else { still },
            reaction: if carried { still } else { turned },
        }
    }
}

impl<const D: usize> Flow<D> {
    /// Step 3: the bed below each node, and gravity as it acts there.
    pub(super) fn sample_bed(&mut self, asked: Asked) {
        for number in 0..self.sets.len() {
            self.sample_bed_below(number, asked);
        }
        if self.settings.numerics.surface_gradient {
            for set in &mut self.sets {
                set.scalars.clear();
                set.scalars.extend(set.bed.iter().map(|bed| bed.level));
                copy(&set.images, &set.scalars, &mut set.seen.level);
            }
        }
    }

    /// Samples the bed at the places of all nodes, after a state was restored; nodes beyond the bed get a flat one.
    pub fn look_below(&mut self) {
        let Self { bed, sets, .. } = self;
        for set in sets {
            let below = set.nodes.position.iter().map(|x| bed.at(x).unwrap_or(BedPoint::flat(0.0)));
            set.bed.clear();
            set.bed.extend(below);
        }
    }

    fn sample_bed_below(&mut self, number: usize, asked: Asked) {
        let carried = asked == Asked::Before && self.carries();
        let Self { bed, sets, settings, .. } = self;
        let Set { nodes, bed: points, reaction, turning, .. } = &mut sets[number];
        points.resize(nodes.len(), BedPoint::flat(0.0));
        reaction.resize(nodes.len(), 0.0);
        turning.resize(nodes.len(), 0.0);
        let (position, velocity) = (&nodes.position, &nodes.velocity);
        let columns = points.par_iter_mut().zip(&mut nodes.pull).zip(&mut nodes.bearing).zip(reaction);
        columns.zip(&*turning).enumerate().with_min_len(TASK).for_each(
            |(i, ((((point, pull), bearing), reaction), turning))| {
                // Nodes beyond the bed keep what was below them until they are removed at the end of the step.
                if asked == Asked::Now
                    && let Some(found) = bed.at(&position[i])
                {
                    *point = found;
                }
                let turning =
                    if carried { *turning } else { point.turning(&velocity[i]) / point.steepness().sqrt() };
                let felt = Gravity::over(settings, point, turning, carried);
                (*pull, *bearing, *reaction) = (felt.pressure, felt.bearing, felt.reaction);
            },
        );
    }
}
