//! Contact laws of the kinds of grains.

use serde::{Deserialize, Serialize};

use crate::contact::PairLaw;
use crate::contact::contact_histories::HistoryColumns;
use crate::points::grains::Grains;

/// Kinds of grains with their contact laws in the current stage, and the history columns that these need.
#[derive(Debug)]
pub struct ContactLaws {
    /// Kinds of grains.
    pub kinds: Vec<KindProperties>,
    /// Sizes of the grains for which the laws of the present stage were made.
    pub sizes: GrainSizes,
    /// Laws of the present stage.
    pub stage: StageLaws,
    /// Columns of the contact histories.
    pub columns: HistoryColumns,
    /// Whether the scalar kernel is used even where a SIMD kernel could be.
    pub scalar_only: bool,
}

/// Sizes of the grains at the beginning of a stage, or after the last change of their number. Stable step and reach of the contacts of the
/// stage follow from them; a checkpoint contains them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrainSizes {
    /// Largest radius (m).
    pub largest_radius: f64,
    /// Radius (m) and mass (kg) of the smallest grain of each kind; infinite for a kind without grains.
    pub smallest: Vec<(f64, f64)>,
    /// Whether any grain has a prescribed motion.
    pub any_held: bool,
}

impl GrainSizes {
    /// Sizes of these grains, of a number of kinds.
    pub fn of_grains<const D: usize, const R: usize>(grains: &Grains<D, R>, kinds: usize) -> Self {
        let mut smallest = vec![(f64::INFINITY, f64::INFINITY); kinds];
        for i in 0..grains.len() {
            let kind = grains.kind[i] as usize;
            if grains.radius[i] < smallest[kind].0 {
                smallest[kind] = (grains.radius[i], grains.mass[i]);
            }
        }
        let any_held = grains.is_held.iter().any(|held| *held);
        Self { largest_radius: grains.radii().1, smallest, any_held }
    }
}

/// Properties of a kind of grains.
#[derive(Clone, Debug, PartialEq)]
pub struct KindProperties {
    /// Name of the kind in the case.
    pub name: String,
    /// Density of the grains (kg/m³).
    pub density: f64,
}

/// Contact laws of a stage.
#[derive(Clone, Debug, PartialEq)]
pub struct StageLaws {
    /// Contact laws of all pairs of kinds, as a matrix stored row by row.
    pub pairs: Vec<PairLaw>,
    /// Laws of each kind with each boundary of the case.
    pub walls: Vec<Vec<PairLaw>>,
    /// Stable step of contacts (s), and the upper bound of stable steps (s).
    pub step: [f64; 2],
    /// Overlap over radius to the power 5/2 in a head-on impact of two of the smallest Hertz spheres, divided by the squared speed (s²/m²).
    /// Zero without Hertz spheres.
    pub impact: f64,
    /// Largest rupture distance of the contacts (m).
    pub rupture_distance: f64,
}
