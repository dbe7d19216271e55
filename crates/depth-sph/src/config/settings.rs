//! Settings of a flow as plain numbers: material, bed and numerics.

use std::fmt;

use colluvium_case::PlanRegion;
use colluvium_constitutive::basal::BasalRheology;

use crate::config::choices::{
    DepthFrame, Metric, Phases, PressureForceForm, SearchOrientation, ThicknessEquation, TimeScheme,
};
use crate::kernel::Kernel;
use crate::laws::erosion::Erosion;
use crate::laws::interphase_drag::{InterphaseDrag, MixtureDensities};
use crate::laws::pore_pressure_column::{Drainage, LowerBound, PressureProfile};

/// Settings that are constant during a flow.
#[derive(Clone, Debug)]
pub struct FlowSettings<const D: usize> {
    /// Number of phases with separate nodes.
    pub phases: Phases,
    /// Gravity normal to the plan (m/s²).
    pub gravity: f64,
    /// Component of gravity along the plan of a tilted frame (m/s²).
    pub plan_gravity: [f64; D],
    /// Axes of plan and depth: horizontal, or along a tilted bed.
    pub frame: DepthFrame,
    /// Effect of depth gradients over steep terrain.
    pub metric: Metric,
    /// Whether curvature of the bed acts on friction and pore pressure. It always rotates the velocity along the bed.
    pub curvature_in_friction: bool,
    /// Components of the material.
    pub material: Mixture,
    /// Drag between two phases.
    pub drag: InterphaseDrag,
    /// Excess pore pressure; none when absent.
    pub column: Option<PoreColumn>,
    /// Zones of the bed with different properties. The first zone that contains a position applies, and the last one contains all
    /// positions.
    pub zones: Vec<BedZone>,
    /// Earth-pressure coefficients; isotropic stress when absent.
    pub earth_pressure: Option<EarthPressure>,
    /// Friction between two layers, `C_f`.
    pub interface_friction: f64,
    /// Numerical parameters.
    pub numerics: Numerics,
}

/// Phase or layer to which a node set belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhaseRole {
    /// Single phase.
    Single,
    /// Grains of a mixture.
    Solid,
    /// Pore fluid of a mixture.
    Fluid,
    /// Avalanche below water.
    Lower,
    /// Water above an avalanche.
    Upper,
}

/// The flowing material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixture {
    /// Densities of grains and fluid, or of the lower and the upper layer (kg/m³). For a single phase without pore fluid the density of
    /// grains is its own, and the porosity is zero.
    pub densities: MixtureDensities,
    /// Initial porosity.
    pub porosity: f64,
    /// Whether pore fluid supports a part of the weight of the grains.
    pub is_saturated: bool,
}

impl Mixture {
    /// Single phase without pore fluid, with a density (kg/m³).
    pub fn single_phase(density: f64, gravity: f64) -> Self {
        let densities = MixtureDensities { grain: density, fluid: 0.0, gravity };
        Self { densities, porosity: 0.0, is_saturated: false }
    }

    /// Initial density of the mixture (kg/m³).
    pub fn density(&self) -> f64 {
        self.densities.mixture(self.porosity)
    }
}

/// Columns of excess pore pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoreColumn {
    /// Number of intervals over the depth.
    pub cells: usize,
    /// Weight of the new time level, ½ to 1.
    pub weight: f64,
    /// Discretisation of the pressure over the depth.
    pub profile: PressureProfile,
    /// Coefficient of consolidation, or its source.
    pub consolidation: Consolidation,
    /// Lower bound of the pressure.
    pub lower_bound: LowerBound,
    /// Initial liquefaction ratio at the base.
    pub excess_ratio: f64,
    /// Stiffness of the skeleton `K_v/α` (Pa), used by loading and dilatancy.
    pub stiffness: f64,
    /// Dilatancy under shear: slope `K_ψ` and critical porosity.
    pub dilatancy: Option<(f64, f64)>,
}

/// Rate of drainage of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Consolidation {
    /// Coefficient of consolidation `c_v` (m²/s).
    Coefficient(f64),
    /// Coefficient from the permeability of the drag law and the stiffness of the skeleton.
    OfDrag,
}

/// Active and passive earth-pressure coefficients of Savage and Hutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarthPressure {
    /// Coefficient where the flow expands.
    pub active_coefficient: f64,
    /// Earth-pressure coefficient where the flow contracts.
    pub passive: f64,
}

impl EarthPressure {
    /// Coefficients of an internal and a basal friction angle (rad), the latter not larger.
    pub fn savage_hutter(internal: f64, basal: f64) -> Self {
        let square = internal.cos().powi(2);
        // Round-off of equal angles must not make a root of a negative number.
        let root = (1.0 - square * (1.0 + basal.tan().powi(2))).max(0.0).sqrt();
        let coefficient = |sign: f64| 2.0 / square * (1.0 + sign * root) - 1.0;
        Self { active_coefficient: coefficient(-1.0), passive: coefficient(1.0) }
    }

    /// Coefficient at a rate of divergence (1/s), smooth over `width` (1/s).
    #[inline]
    pub fn coefficient_at(&self, divergence: f64, width: f64) -> f64 {
        self.active_coefficient
            + 0.5 * (self.passive - self.active_coefficient) * (1.0 - (divergence / width).tanh())
    }
}

/// Resistance of the bed to pore fluid, times the porosity (sheet: depth-sph §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FluidResistance {
    /// None.
    #[default]
    None,
    /// `3 μ v/h` (Pa s).
    Laminar(f64),
    /// `ρ g n² v²/h^⅓` (s/m^⅓).
    Manning(f64),
    /// `ρ g v²/ξ` (m/s²), as the turbulent part of Voellmy's law.
    Turbulent(f64),
}

impl FluidResistance {
    /// Shear stress over density (m²/s²) at depth `h` and speed `v`.
    #[inline]
    pub fn over_density(&self, depth: f64, speed: f64, density: f64, gravity: f64) -> f64 {
        match *self {
            Self::None => 0.0,
            Self::Laminar(viscosity) => 3.0 * viscosity * speed / (depth * density),
            Self::Manning(n) => gravity * n * n * speed * speed / depth.cbrt(),
            Self::Turbulent(xi) => gravity * speed * speed / xi,
        }
    }
}

/// Zone of the bed with uniform properties.
#[derive(Clone)]
pub struct BedZone {
    /// Regions whose intersection is the zone; empty for the whole plan.
    pub regions: Vec<PlanRegion>,
    /// Basal resistance; frictionless when absent.
    pub law: Option<BasalRheology>,
    /// Drainage through the base.
    pub drainage: Drainage,
    /// Resistance to the pore fluid.
    pub fluid: FluidResistance,
    /// Erosion of the zone.
    pub erosion: Option<Erosion>,
    /// Erodible depth (m), infinite without a limit.
    pub erodible_depth: f64,
}

impl fmt::Debug for BedZone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let law = self.law.as_ref().map(|law| law.name);
        write!(f, "Zone {{ {:?}, {law:?}, {:?}, {:?} }}", self.regions, self.drainage, self.erosion)
    }
}

impl BedZone {
    /// Zone of the whole bed with a basal law, sealed and without erosion.
    pub fn unbounded(law: Option<BasalRheology>) -> Self {
        Self {
            regions: Vec::new(),
            law,
            drainage: Drainage::Sealed,
            fluid: FluidResistance::None,
            erosion: None,
            erodible_depth: f64::INFINITY,
        }
    }

    /// Whether the zone contains a position.
    #[inline]
    pub fn contains(&self, x: &[f64]) -> bool {
        self.regions.iter().all(|part| part.contains(x))
    }
}

/// Numerical parameters of a flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numerics {
    /// Kernel.
    pub kernel: Kernel,
    /// Whether smoothing lengths follow the heights.
    pub variable_length: bool,
    /// Sums of height per step.
    pub summation_passes: usize,
    /// Bounds of the smoothing length over its initial value.
    pub length_range: (f64, f64),
    /// Lower bound of the smoothing length (m).
    pub shortest: f64,
    /// Equation of the height.
    pub continuity: ThicknessEquation,
    /// Form of the pressure force.
    pub momentum: PressureForceForm,
    /// Whether the pressure force uses the gradient of the free surface, so that a level surface stays at rest.
    pub surface_gradient: bool,
    /// Integration in time.
    pub integration: TimeScheme,
    /// Linear and quadratic artificial viscosity.
    pub viscosity: (f64, f64),
    /// XSPH fraction: share of the neighbours' mean velocity in the motion of nodes (-).
    pub xsph: f64,
    /// Orientation of the cells of the neighbour search.
    pub search: SearchOrientation,
    /// Courant number.
    pub courant: f64,
    /// Whether friction acts along -x for any direction of motion, as similarity solutions assume.
    pub friction_along_x: bool,
    /// Factors on bed resistance and pressure, for tests that detect a wrong factor.
    #[cfg(test)]
    pub test_factors: [f64; 2],
}

impl Numerics {
    /// The defaults in `D` dimensions of the plan (sheet: depth-sph §0, §2.10, §3.3).
    pub fn defaults<const D: usize>() -> Self {
        Self {
            kernel: Kernel::CubicSpline,
            variable_length: true,
            summation_passes: 2,
            length_range: (0.5, if D == 1 { 50.0 } else { 3.0 }),
            shortest: 0.0,
            continuity: ThicknessEquation::Summation,
            momentum: PressureForceForm::Automatic,
            surface_gradient: false,
            integration: TimeScheme::Leapfrog,
            viscosity: (1.0, 0.0),
            xsph: 0.0,
            search: SearchOrientation::Axes,
            courant: 0.3,
            friction_along_x: false,
            #[cfg(test)]
            test_factors: [1.0; 2],
        }
    }
}

impl<const D: usize> FlowSettings<D> {
    /// Single phase of a density on a horizontal bed without resistance, with gravity 9.81 m/s².
    pub fn single_phase(density: f64) -> Self {
        let gravity = 9.81;
        Self {
            phases: Phases::One,
            gravity,
            plan_gravity: [0.0; D],
            frame: DepthFrame::Horizontal,
            metric: Metric::Blended,
            curvature_in_friction: true,
            material: Mixture::single_phase(density, gravity),
            drag: InterphaseDrag::None,
            column: None,
            zones: vec![BedZone::unbounded(None)],
            earth_pressure: None,
            interface_friction: 0.0,
            numerics: Numerics::defaults::<D>(),
        }
    }

    /// Magnitude of gravity with its component along a tilted frame (m/s²).
    #[inline]
    pub fn total_gravity(&self) -> f64 {
        (self.gravity * self.gravity + self.plan_gravity.iter().map(|g| g * g).sum::<f64>()).sqrt()
    }

    /// Zone of the bed that contains a position.
    #[inline]
    pub fn zone(&self, x: &[f64; D]) -> &BedZone {
        let last = self.zones.len() - 1;
        self.zones[..last].iter().find(|zone| zone.contains(x)).unwrap_or(&self.zones[last])
    }

    /// Erodible depth of the bed at a position (m); zero without erosion.
    pub fn erodible_depth(&self, x: &[f64; D]) -> f64 {
        let zone = self.zone(x);
        if zone.erosion.is_some() { zone.erodible_depth } else { 0.0 }
    }

    /// Whether a term needs a list of neighbours. Sums of heights and forces need none.
    pub fn needs_neighbour_list(&self) -> bool {
        let numerics = &self.numerics;
        self.phases == Phases::Layers
            || self.earth_pressure.is_some()
            || numerics.xsph > 0.0
            || numerics.continuity != ThicknessEquation::Summation
    }

    /// Whether the rotation of velocities along the bed matters, by friction or pore pressure.
    pub fn has_resistance(&self) -> bool {
        self.column.is_some() || self.zones.iter().any(|zone| zone.law.is_some())
    }

    /// Phase or layer of a node set.
    pub fn role(&self, set: usize) -> PhaseRole {
        match (self.phases, set) {
            (Phases::One, _) => PhaseRole::Single,
            (Phases::Two, 0) => PhaseRole::Solid,
            (Phases::Two, _) => PhaseRole::Fluid,
            (Phases::Layers, 0) => PhaseRole::Lower,
            (Phases::Layers, _) => PhaseRole::Upper,
        }
    }

    /// Density of a node set (kg/m³), where `sets` is the number of node sets.
    pub fn set_density(&self, sets: usize, set: usize) -> f64 {
        match (sets, set) {
            (1, _) => self.material.density(),
            (_, 0) => self.material.densities.grain,
            _ => self.material.densities.fluid,
        }
    }

    /// Number of sets of nodes.
    pub fn sets(&self) -> usize {
        if self.phases == Phases::One { 1 } else { 2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn earth_pressure_has_the_values_of_the_sheet() {
        let table = [
            (30, 0, 0.333_333, 3.0),
            (30, 20, 0.631_656, 2.701_678),
            (30, 30, 1.666_667, 1.666_667),
            (38, 25, 0.629_799, 3.811_830),
            (40, 30, 0.818_461, 3.997_892),
        ];
        for (internal, basal, active, passive) in table {
            let angle = |degrees: i32| f64::from(degrees).to_radians();
            let found = EarthPressure::savage_hutter(angle(internal), angle(basal));
            assert!((found.active_coefficient - active).abs() < 1e-6, "{internal} {basal}: {found:?}");
            assert!((found.passive - passive).abs() < 1e-6, "{internal} {basal}: {found:?}");
            assert!(
                (found.coefficient_at(1e3, 0.1) - active).abs() < 1e-6
                    && (found.coefficient_at(-1e3, 0.1) - passive).abs() < 1e-6
            );
        }
    }
}
