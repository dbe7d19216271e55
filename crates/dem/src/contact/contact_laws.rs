//! Contact laws of the kinds of grains.

use crate::contact::PairLaw;
use crate::contact::contact_histories::HistoryColumns;

/// Kinds of grains with their contact laws in the current stage, and the history columns that these need.
#[derive(Debug)]
pub struct ContactLaws {
    /// Kinds of grains.
    pub kinds: Vec<KindProperties>,
    /// Laws of the present stage.
    pub stage: StageLaws,
    /// Columns of the contact histories.
    pub columns: HistoryColumns,
    /// Whether the scalar kernel is used even where a SIMD kernel could be.
    pub scalar_only: bool,
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
