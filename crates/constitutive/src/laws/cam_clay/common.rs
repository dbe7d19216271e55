//! Common parts of both Cam-clays: constants, state, elastic trial.

use serde::{Deserialize, Serialize};

use crate::laws::pressure_elastic::{MIN_PRESSURE, VolumeStep, void_ratio_after};
use crate::laws::{check_compressive, check_initial};
use crate::return_maps::radial_return::RadialTrial;
use crate::return_maps::substepping::SubstepResult;
use crate::{MaterialError, Point, SymTensor};

/// Checked parameters common to both Cam-clays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::laws) struct CamClayConstants {
    /// Slope `M` of the critical state line.
    pub critical: f64,
    /// Slope `λ` of normal compression.
    pub compression: f64,
    /// Slope `κ` of the unloading–reloading line.
    pub swelling: f64,
    /// Shear stiffness.
    pub shear: ShearStiffness,
    /// Initial void ratio.
    pub void_ratio: f64,
    /// Size of the initial yield surface.
    pub size: InitialSurfaceSize,
    /// Whether an initial stress outside is moved to the surface.
    pub return_initial_stress_to_yield: bool,
}

/// Shear stiffness of a Cam-clay law, as a ratio or a constant modulus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::laws) enum ShearStiffness {
    /// Ratio `G/K`.
    Ratio(f64),
    /// Shear modulus `G` (Pa).
    Modulus(f64),
}

/// Initial size of a Cam-clay yield surface, as a pressure or a ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::laws) enum InitialSurfaceSize {
    /// Preconsolidation pressure `p_c` (Pa).
    Pressure(f64),
    /// Ratio of `p_c` to that of the surface through the initial stress.
    Ratio(f64),
}

/// Internal variables of the Cam-clay laws.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CamClayState {
    /// Pressure `p_c` at the tip of the yield surface (Pa).
    pub preconsolidation_pressure: f64,
    /// Void ratio: volume of voids over volume of grains.
    pub void_ratio: f64,
    /// Accumulated deviatoric plastic strain.
    pub plastic_strain: f64,
}

/// Elastic trial of a step.
#[derive(Clone, Copy, Debug)]
pub(in crate::laws) struct CamClayTrial {
    /// Factor `θ = v/κ` of the bulk modulus, specific volume over the swelling slope.
    pub theta: f64,
    /// Factor `χ = v/(λ-κ)`.
    pub chi: f64,
    /// Trial pressure (Pa).
    pub pressure: f64,
    /// Derivative `dp_tr/dΔ` of the trial pressure by the volumetric compression `Δ` of the step (Pa).
    pub pressure_slope: f64,
    /// Shear modulus of the step (Pa).
    pub shear: f64,
    /// Derivative `dG/dΔ` of the shear modulus by the volumetric compression `Δ` of the step (Pa).
    pub shear_slope: f64,
    /// Trial deviatoric stress.
    pub radial: RadialTrial,
    /// Deviatoric stress `q` of the trial (Pa).
    pub q: f64,
}

impl CamClayConstants {
    /// State at the start; `size` gives the preconsolidation pressure `p_c` of the yield surface through a stress (Pa).
    pub(in crate::laws) fn initial(
        &self,
        model: &'static str,
        stress: &SymTensor,
        size: impl Fn(f64, f64) -> f64,
    ) -> Result<Point<CamClayState>, MaterialError> {
        check_compressive(model, stress)?;
        let through = size(stress.pressure(), stress.q());
        let preconsolidation_pressure = match self.size {
            InitialSurfaceSize::Pressure(pressure) => pressure,
            InitialSurfaceSize::Ratio(ratio) => ratio * through,
        };
        let state =
            CamClayState { preconsolidation_pressure, void_ratio: self.void_ratio, plastic_strain: 0.0 };
        let excess = through - preconsolidation_pressure;
        if self.return_initial_stress_to_yield && excess > 0.0 {
            let pressure = stress.pressure().min(preconsolidation_pressure);
            let (q, deviator) = (stress.q(), stress.deviator());
            let (mut inside, mut outside) = (0.0, 1.0);
            while outside - inside > f64::EPSILON {
                let share = 0.5 * (inside + outside);
                let fits = size(pressure, share * q) <= preconsolidation_pressure;
                if fits { inside = share } else { outside = share }
            }
            return Ok(Point { stress: deviator * inside - SymTensor::isotropic(pressure), state });
        }
        check_initial(model, stress, excess, preconsolidation_pressure)?;
        Ok(Point { stress: *stress, state })
    }

    /// Elastic trial of a step with the volumetric compression `Δ = -tr Δε`: `p_tr = p exp(θ Δ)`, and the deviator with the secant shear modulus.
    pub(in crate::laws) fn trial(&self, strain: &SymTensor, old: &Point<CamClayState>) -> CamClayTrial {
        let v = 1.0 + old.state.void_ratio;
        let (theta, chi) = (v / self.swelling, v / (self.compression - self.swelling));
        let p = old.stress.pressure();
        let compression = -strain.trace();
        let modulus = theta * p;
        let growth = (theta * compression).exp_m1();
        let floor = p.min(MIN_PRESSURE);
        let mut volume =
            VolumeStep::new(p, compression, growth, modulus, modulus * (1.0 + growth), theta * modulus);
        if volume.pressure < floor {
            let secant = (floor - p) / compression;
            volume =
                VolumeStep { pressure: floor, tangent: 0.0, secant, secant_slope: -secant / compression };
        }
        // At pressures below the least one the shear modulus is constant.
        let smallest = theta * MIN_PRESSURE;
        let (shear, shear_slope) = match self.shear {
            ShearStiffness::Modulus(modulus) => (modulus, 0.0),
            ShearStiffness::Ratio(ratio) if volume.secant < smallest => (ratio * smallest, 0.0),
            ShearStiffness::Ratio(ratio) => (ratio * volume.secant, ratio * volume.secant_slope),
        };
        let radial = RadialTrial::new(&old.stress, strain, shear, shear_slope);
        let (pressure, pressure_slope) = (volume.pressure, volume.tangent);
        CamClayTrial { theta, chi, pressure, pressure_slope, shear, shear_slope, radial, q: radial.q() }
    }

    /// Point after an elastic step.
    pub(in crate::laws) fn elastic(
        &self,
        trial: &CamClayTrial,
        strain: &SymTensor,
        old: &Point<CamClayState>,
    ) -> SubstepResult<CamClayState> {
        let state =
            CamClayState { void_ratio: void_ratio_after(old.state.void_ratio, strain.trace()), ..old.state };
        SubstepResult {
            point: Point { stress: trial.radial.stress(trial.pressure, 1.0), state },
            dissipated_work: 0.0,
        }
    }

    /// Upper bound of the wave modulus (Pa), see [`SmallStrain::wave_modulus`].
    pub(in crate::laws) fn wave_modulus(&self, point: &Point<CamClayState>) -> f64 {
        let p = point.stress.pressure().max(MIN_PRESSURE);
        let bulk = (1.0 + point.state.void_ratio) * p / self.swelling;
        let shear = match self.shear {
            ShearStiffness::Ratio(ratio) => ratio * bulk,
            ShearStiffness::Modulus(modulus) => modulus,
        };
        1.1 * (bulk + 4.0 / 3.0 * shear)
    }
}

/// Names of the output scalars of the Cam-clays.
pub(in crate::laws) const OUTPUTS: &[&str] = &["void_ratio", "preconsolidation_pressure", "plastic_strain"];

impl CamClayState {
    /// Writes void ratio, preconsolidation pressure (Pa) and plastic strain to `out`.
    pub(in crate::laws) fn outputs(&self, out: &mut [f64]) {
        out.copy_from_slice(&[self.void_ratio, self.preconsolidation_pressure, self.plastic_strain]);
    }
}
