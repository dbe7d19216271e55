//! Double-scale localisation (constitutive sheet §2.16, §3.7.11; Bui & Nguyen 2021, eqs. 88–109): an
//! elastic point that is cut by one cohesive band.
//!
//! Outside the band `σ̇ = D : (ε̇ - n ⊗ u̇ / H)` with the jump `u` and the effective size `H` of the point
//! (volume over area of the cut); in the band of zero thickness an [`InterfaceLaw`], `σ n = t(u)`. The jump
//! of a step is implicit: surroundings and band are springs in series, which leaves the band a scalar
//! equation. The energy of the band is thus
//! spent per area whatever the size of the points. A band is inserted where the band's own yield
//! function, or the largest principal stress, is first exceeded; of two conjugate planes that are equally
//! close it takes the one the strain shears most, or, where the strain does not tell, the spin. Its
//! normal then turns with the material.
//!
//! Limits: one band a point; snap-back where `H` exceeds `E G/f_t²` (refused unless allowed, and then the
//! step lands on the lower branch). For explicit formulas with a band of finite thickness see
//! [`crate::localisation`].

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cohesive_band::{CohesiveBand, CohesiveBandSpec};
use super::cohesive_damage::CohesiveDamageSpec;
use super::linear_elastic::{Elasticity, stiff_warnings};
use super::substep::{Advance, substepped};
use crate::model::{Facts, Kind, Model, positive};
use crate::{
    Corotational, InitialCondition, InterfaceLaw, InterfacePoint, Mat3, Material, MaterialError, Motion,
    Point, SmallStrain, SymTensor, Tangent,
};

const NAME: &str = "double-scale";

/// Damage at which the intact-reset hypothesis drops a band.
const BROKEN: f64 = 0.999;

/// Parameters of `double-scale`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DoubleScaleSpec {
    /// Density (kg/m³), > 0.
    pub density: f64,
    /// Young's modulus outside the band (Pa), > 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio outside the band, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// What holds the band together.
    pub band: BandSpec,
    /// When a band is inserted, and which way.
    #[serde(default)]
    pub onset: Onset,
    /// Effective size of a point (m), > 0; the size that the method gives when absent. Where a grid carries
    /// the resolution it is the size of a cell.
    #[serde(default)]
    pub size: Option<f64>,
    /// Drop a band that is broken through and start again from the intact material (desiccation networks).
    #[serde(default)]
    pub intact_reset: bool,
    /// Take points so large that they snap back.
    #[serde(default)]
    pub allow_snapback: bool,
}

/// The interface law of a band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case")]
pub enum BandSpec {
    /// Mixed-mode cohesion and friction.
    CohesiveFriction(CohesiveBandSpec),
    /// Damage with exponential softening, no friction.
    CohesiveDamage(CohesiveDamageSpec),
}

/// When a band is inserted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Onset {
    /// Where the band's yield function is exceeded, on the plane where it is largest.
    #[default]
    BandYield,
    /// Where the largest principal stress reaches the tensile strength, across it.
    Rankine,
}

impl DoubleScaleSpec {
    /// Checks the ranges and builds the law around `band`.
    ///
    /// # Errors
    /// The first parameter out of range; a given size that snaps back unless that is allowed.
    pub fn law<B: InterfaceLaw>(&self, band: B) -> Result<DoubleScale<B>, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        if let Some(size) = self.size {
            positive("size", size, "m")?;
            let largest = band.largest_size(self.youngs_modulus, elasticity.shear_modulus);
            if size >= largest && !self.allow_snapback {
                let rule = format!("snaps back: must be less than {largest} m, or allow_snapback be set");
                return Err(MaterialError::Parameter { field: "size", value: size, rule });
            }
        }
        let largest = band.largest_size(self.youngs_modulus, elasticity.shear_modulus);
        Ok(DoubleScale {
            elasticity,
            band,
            onset: self.onset,
            size: self.size,
            largest: if self.allow_snapback { f64::INFINITY } else { largest },
            intact_reset: self.intact_reset,
        })
    }

    /// Size (m) from which a point snaps back; `None` where the parameters are out of range.
    fn largest_size(&self) -> Option<f64> {
        let shear = Elasticity::new(self.youngs_modulus, self.poissons_ratio).ok()?.shear_modulus;
        match &self.band {
            BandSpec::CohesiveFriction(band) => {
                Some(band.law().ok()?.largest_size(self.youngs_modulus, shear))
            }
            BandSpec::CohesiveDamage(band) => Some(band.law().ok()?.largest_size(self.youngs_modulus, shear)),
        }
    }
}

impl Model for DoubleScaleSpec {
    const FACTS: Facts = Facts {
        source: "Bui & Nguyen 2021, eqs. 88–109; Wang et al. 2020 (band)",
        kind: Kind::Solid,
        strain: "rate",
        tangent: "analytic",
    };

    fn density(&self) -> f64 {
        self.density
    }

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(match &self.band {
            BandSpec::CohesiveFriction(band) => Arc::new(Corotational(self.law(band.law()?)?)),
            BandSpec::CohesiveDamage(band) => Arc::new(Corotational(self.law(band.law()?)?)),
        })
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = stiff_warnings(self.poissons_ratio);
        if let (Some(size), Some(largest)) = (self.size, self.largest_size())
            && size >= largest
        {
            warnings.push(format!("size: snap-back, {size} m is not less than {largest:.4} m"));
        }
        warnings
    }

    fn examples() -> Vec<Self> {
        let band = CohesiveBandSpec {
            cohesion: 20e3,
            tensile_strength: 10e3,
            friction_coefficient: 0.6,
            dilatancy_coefficient: 0.2,
            opening_energy: 10.0,
            sliding_energy: 40.0,
            normal_stiffness: 5e9,
            shear_stiffness: 2e9,
        };
        let with = |band| Self {
            density: 2000.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            band,
            onset: Onset::BandYield,
            size: None,
            intact_reset: false,
            allow_snapback: false,
        };
        let isochoric = CohesiveBandSpec { dilatancy_coefficient: 0.0, ..band };
        let damage = CohesiveDamageSpec { tensile_strength: 10e3, fracture_energy: 10.0, stiffness: 5e9 };
        vec![
            with(BandSpec::CohesiveFriction(band)),
            with(BandSpec::CohesiveFriction(isochoric)),
            Self { onset: Onset::Rankine, ..with(BandSpec::CohesiveFriction(band)) },
            with(BandSpec::CohesiveDamage(damage)),
        ]
    }
}

/// The law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct DoubleScale<B = CohesiveBand> {
    elasticity: Elasticity,
    band: B,
    onset: Onset,
    size: Option<f64>,
    /// Size from which a point is refused (m).
    largest: f64,
    intact_reset: bool,
}

/// Internal variables: the band, if there is one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BandedState<S> {
    /// Whether a band has been inserted.
    pub localised: bool,
    /// Frame of the band, row by row: unit normal and two tangents.
    pub frame: Mat3,
    /// Jump across the band (m) in its frame.
    pub jump: [f64; 3],
    /// Size of the point at the last step (m).
    pub size: f64,
    /// Internal variables of the interface law.
    pub band: S,
}

impl<B: InterfaceLaw> DoubleScale<B> {
    /// Yield value of the intact material (Pa) and `cos 2α` of the plane nearest to it.
    fn intact(&self, stress: &SymTensor) -> (f64, f64) {
        let [highest, _, lowest] = stress.principal_values();
        self.plane(highest, lowest)
    }

    fn plane(&self, highest: f64, lowest: f64) -> (f64, f64) {
        match self.onset {
            Onset::BandYield => self.band.critical_plane(highest, lowest),
            Onset::Rankine => (highest - self.band.tensile_strength(), 1.0),
        }
    }

    /// The frame of the band that a step from `old` to the elastic `trial` asks for, if it does: that of the
    /// stress at which the intact material is first exceeded, which does not depend on the length of the step.
    fn onset(&self, old: &SymTensor, trial: &SymTensor, strain: &SymTensor, motion: &Motion) -> Option<Mat3> {
        if !(self.intact(trial).0 > 16.0 * f64::EPSILON * trial.norm()) {
            return None;
        }
        let on_the_way = |share: f64| *old + (*trial - *old) * share;
        let (mut below, mut above) = (0.0, 1.0);
        while above - below > f64::EPSILON {
            let middle = 0.5 * (below + above);
            if self.intact(&on_the_way(middle)).0 > 0.0 {
                above = middle;
            } else {
                below = middle;
            }
        }
        let spectrum = on_the_way(above).spectrum();
        let [highest, _, lowest] = spectrum.values;
        let (_, cosine) = self.plane(highest, lowest);
        let [first, second, third] = spectrum.directions;
        // Shear strain between the extreme directions tells the two conjugate planes apart, else the spin.
        let across = |v: [f64; 3]| (0..3).map(|i| first[i] * v[i]).sum::<f64>();
        let shear = -cosine * across(strain.apply(third));
        let spin = across(motion.gradient.skew().apply(third));
        let sign = if shear.abs() > 1e-6 * strain.norm() { shear } else { spin };
        let along = (0.5 * (1.0 + cosine)).sqrt();
        let aside = (0.5 * (1.0 - cosine)).sqrt().copysign(sign);
        let normal = std::array::from_fn(|i| along * first[i] + aside * third[i]);
        let tangent = std::array::from_fn(|i| along * third[i] - aside * first[i]);
        Some(Mat3([normal, tangent, second]))
    }

    /// Traction of `stress` on the band, in its frame.
    #[inline]
    fn traction(frame: &Mat3, stress: &SymTensor) -> [f64; 3] {
        frame.apply(stress.apply(frame.0[0]))
    }

    /// The band as it stands under `stress`.
    fn interface(state: &BandedState<B::State>, stress: &SymTensor) -> InterfacePoint<B::State> {
        InterfacePoint { traction: Self::traction(&state.frame, stress), state: state.band }
    }

    /// `n·D·n / H` (Pa/m), opening and sliding: a diagonal in the frame of the band for isotropic elasticity.
    fn resistance(&self, size: f64) -> [f64; 2] {
        [self.elasticity.p_wave_modulus() / size, self.elasticity.shear_modulus / size]
    }

    /// `(K + n·D·n/H)⁻¹` at the jump increment `jump`.
    fn compliance(
        &self,
        size: f64,
        jump: [f64; 3],
        old: &InterfacePoint<B::State>,
    ) -> Result<Mat3, MaterialError> {
        let mut jacobian = Mat3(self.band.stiffness(jump, old)?);
        let [opening, sliding] = self.resistance(size);
        for (k, resistance) in [opening, sliding, sliding].into_iter().enumerate() {
            jacobian.0[k][k] += resistance;
        }
        let singular = MaterialError::NotConverged { model: NAME, reason: "the band has no resistance" };
        jacobian.inverse().ok_or(singular)
    }

    fn step(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<BandedState<B::State>>,
    ) -> Result<Point<BandedState<B::State>>, MaterialError> {
        let trial = old.stress + self.elasticity.stress(strain);
        let mut state = old.state;
        if !state.localised {
            let Some(frame) = self.onset(&old.stress, &trial, strain, motion) else {
                return Ok(Point { stress: trial, state });
            };
            let traction = Self::traction(&frame, &old.stress);
            state = BandedState {
                localised: true,
                frame,
                jump: [0.0; 3],
                size: 0.0,
                band: self.band.initial(traction),
            };
        }
        let size = self.size.unwrap_or(motion.size);
        let invalid = |reason| MaterialError::Motion { model: NAME, reason };
        if !(size > 0.0 && size.is_finite()) {
            return Err(invalid("the size of the point must be positive"));
        }
        if size >= self.largest {
            return Err(invalid("the point is so large that its band snaps back (see allow_snapback)"));
        }
        state.size = size;
        let before = Self::interface(&state, &old.stress);
        let traction = Self::traction(&state.frame, &trial);
        let (jump, new) = self.band.relaxed(traction, self.resistance(size), &before)?;
        let mut stress = trial;
        if jump != [0.0; 3] {
            let across = state.frame.transpose().apply(jump);
            let dyad = SymTensor::symmetric_dyad(state.frame.0[0], across);
            stress -= self.elasticity.stress(&dyad) * (1.0 / size);
        }
        state.band = new.state;
        state.jump = std::array::from_fn(|k| state.jump[k] + jump[k]);
        if self.intact_reset && self.band.damage(&state.band) >= BROKEN && self.intact(&stress).0 <= 0.0 {
            state = BandedState::default();
        }
        Ok(Point { stress, state })
    }
}

impl<B: InterfaceLaw> SmallStrain for DoubleScale<B> {
    type State = BandedState<B::State>;

    fn name(&self) -> &'static str {
        NAME
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<Self::State>, MaterialError> {
        let stress = initial.stress;
        let (excess, _) = self.intact(&stress);
        super::check_initial(NAME, &stress, excess, self.band.tensile_strength() + stress.norm())?;
        Ok(Point { stress, state: BandedState::default() })
    }

    fn update(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<Self::State>,
    ) -> Result<Point<Self::State>, MaterialError> {
        if *strain == SymTensor::ZERO {
            return Ok(*old);
        }
        // The local solve is implicit: only one that fails asks for smaller steps.
        let step = |part: &SymTensor, from: &Point<Self::State>| {
            Ok(Advance { point: self.step(part, motion, from)?, dissipated: 0.0 })
        };
        Ok(substepped(NAME, strain, 1.0, old, step)?.point)
    }

    fn rotate_state(&self, state: &mut Self::State, rotation: &Mat3) {
        if state.localised {
            state.frame = state.frame * rotation.transpose();
        }
    }

    fn wave_modulus(&self, _point: &Point<Self::State>) -> f64 {
        self.elasticity.p_wave_modulus()
    }

    /// `D - (D n)(K + n·D·n/H)⁻¹(n D)/H` (sheet §3.7.11); in the step that inserts the band its direction
    /// moves too, which is left to differences.
    fn tangent(&self, strain: &SymTensor, motion: &Motion, old: &Point<Self::State>) -> Option<Tangent> {
        let mut tangent = self.elasticity.tangent();
        let trial = old.stress + self.elasticity.stress(strain);
        if !old.state.localised {
            return self.onset(&old.stress, &trial, strain, motion).is_none().then_some(tangent);
        }
        let size = self.size.unwrap_or(motion.size);
        let frame = &old.state.frame;
        let before = Self::interface(&old.state, &old.stress);
        let traction = Self::traction(frame, &trial);
        let (jump, new) = self.band.relaxed(traction, self.resistance(size), &before).ok()?;
        if self.intact_reset && self.band.damage(&new.state) >= BROKEN {
            return None;
        }
        let compliance = self.compliance(size, jump, &before).ok()?;
        let pulls = frame.0.map(|a| self.elasticity.stress(&SymTensor::symmetric_dyad(frame.0[0], a)));
        for (row, a) in compliance.0.iter().zip(&pulls) {
            for (value, b) in row.iter().zip(&pulls) {
                tangent.add_dyad(-value / size, a, b);
            }
        }
        Some(tangent)
    }

    fn yield_value(&self, point: &Point<Self::State>) -> Option<f64> {
        Some(if point.state.localised {
            self.band.yield_value(&Self::interface(&point.state, &point.stress))
        } else {
            self.intact(&point.stress).0
        })
    }

    /// Of the material outside the band.
    fn stored_energy(&self, point: &Point<Self::State>) -> Option<f64> {
        Some(self.elasticity.energy(&point.stress))
    }

    fn dissipation(
        &self,
        _strain: &SymTensor,
        _motion: &Motion,
        old: &Point<Self::State>,
        new: &Point<Self::State>,
    ) -> Option<f64> {
        if !new.state.localised {
            // A band that was dropped in this step took its account with it.
            return (!old.state.localised).then_some(0.0);
        }
        let band = if old.state.localised {
            old.state.band
        } else {
            self.band.initial(Self::traction(&new.state.frame, &old.stress))
        };
        let before = InterfacePoint { traction: Self::traction(&new.state.frame, &old.stress), state: band };
        let after = Self::interface(&new.state, &new.stress);
        Some(self.band.dissipation(&before, &after) / new.state.size)
    }

    fn output_names(&self) -> &'static [&'static str] {
        &["localised", "damage", "opening", "slip"]
    }

    fn outputs(&self, point: &Point<Self::State>, out: &mut [f64]) {
        let BandedState { localised, jump, band, .. } = &point.state;
        out[0] = f64::from(u8::from(*localised));
        out[1] = if *localised { self.band.damage(band) } else { 0.0 };
        out[2] = jump[0];
        out[3] = jump[1].hypot(jump[2]);
    }
}
