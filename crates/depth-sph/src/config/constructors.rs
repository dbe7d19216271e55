//! Constructors of the options: required values are arguments, all others are those of a case file without them.

use colluvium_case::MethodOptions;
use colluvium_case::description::Side;
use colluvium_constitutive::with_defaults;

use crate::config::{
    ColumnOptions, DamOptions, DepthOptions, DilatancyOptions, EarthPressureOptions, InflowOptions,
    MixtureOptions, SkeletonConfinement, SkeletonOptions, StopOptions, default_column_cells, default_factor,
};
use crate::laws::interphase_drag::InterphaseDrag;

impl MethodOptions for DepthOptions {
    const METHOD: &'static str = crate::NAME;
    const REQUIRED: &'static [&'static str] = &["spacing"];

    fn default_options(&self) -> Self {
        Self::new(self.spacing)
    }
}

impl DepthOptions {
    /// Options with an initial distance of neighbouring nodes (m), and all others as a case file without them.
    #[must_use]
    pub fn new(spacing: f64) -> Self {
        with_defaults(&[("spacing", spacing)])
    }
}

impl DamOptions {
    /// Dam of a height (m, vertical) along the corners of a line (m), with a sharp crest and sides of 45°.
    #[must_use]
    pub fn new(line: impl Into<Vec<[f64; 2]>>, height: f64) -> Self {
        Self { line: line.into(), height, width: 0.0, side_slope: default_factor() }
    }
}

impl Default for InflowOptions {
    /// Inflow without place and hydrograph, at a Froude number of 1.
    fn default() -> Self {
        Self {
            from: None,
            to: None,
            side: None,
            discharge: Vec::new(),
            hydrograph: None,
            froude: default_factor(),
            across: Default::default(),
            layer: None,
            porosity: None,
        }
    }
}

impl InflowOptions {
    /// Inflow across a line in plan from a start to an end (m), to the right of its direction, by pairs of time (s) and discharge (m³/s).
    #[must_use]
    pub fn across_line(from: [f64; 2], to: [f64; 2], discharge: impl Into<Vec<[f64; 2]>>) -> Self {
        Self { from: Some(from), to: Some(to), discharge: discharge.into(), ..Self::default() }
    }

    /// Inflow through an end of a profile, by pairs of time (s) and discharge (m²/s).
    #[must_use]
    pub fn through_end(side: Side, discharge: impl Into<Vec<[f64; 2]>>) -> Self {
        Self { side: Some(side), discharge: discharge.into(), ..Self::default() }
    }
}

impl MixtureOptions {
    /// Mixture of grains, or a lower layer, of a density (kg/m³), with water.
    #[must_use]
    pub fn new(grain_density: f64) -> Self {
        with_defaults(&[("grain_density", grain_density)])
    }
}

impl InterphaseDrag {
    /// Law of Anderson and Jackson, with a settling velocity of a grain (m/s).
    #[must_use]
    pub fn anderson(settling_velocity: f64) -> Self {
        Self::Anderson { settling_velocity: settling_velocity.into(), exponent: default_factor() }
    }
}

impl Default for ColumnOptions {
    /// Column without consolidation and excess pressure; one of `consolidation` and `skeleton` must be set.
    fn default() -> Self {
        Self {
            cells: default_column_cells(),
            weight: default_factor(),
            profile: Default::default(),
            consolidation: None,
            skeleton: None,
            lower_bound: Default::default(),
            excess_ratio: 0.0,
            dilatancy: None,
        }
    }
}

impl ColumnOptions {
    /// Column of a coefficient of consolidation (m²/s), without excess pressure at the start.
    #[must_use]
    pub fn new(consolidation: f64) -> Self {
        Self { consolidation: Some(consolidation), ..Self::default() }
    }
}

impl SkeletonOptions {
    /// Skeleton of a Young's modulus (Pa) and a Poisson's ratio (-), without lateral strain.
    #[must_use]
    pub fn new(youngs_modulus: f64, poissons_ratio: f64) -> Self {
        Self { youngs_modulus, poissons_ratio, confinement: SkeletonConfinement::default() }
    }
}

impl DilatancyOptions {
    /// Dilatancy of a slope of `tan ψ` over porosity (-) about a critical porosity (-).
    #[must_use]
    pub fn new(slope: f64, critical_porosity: f64) -> Self {
        Self { slope, critical_porosity }
    }
}

impl EarthPressureOptions {
    /// Earth pressure of an internal and a basal friction angle (degrees).
    #[must_use]
    pub fn new(internal_friction_angle: f64, basal_friction_angle: f64) -> Self {
        Self { internal_friction_angle, basal_friction_angle }
    }
}

impl Default for StopOptions {
    fn default() -> Self {
        Self { speed: 0.05, share: 0.99, kinetic_ratio: 0.01, hold: 1.0 }
    }
}
