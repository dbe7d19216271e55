//! Mohr–Coulomb plasticity (constitutive sheet §2.5, §3.7.2; region form of Clausen et al.).
//!
//! With `σ1 ≥ σ2 ≥ σ3`: `f = k σ1 - σ3 - 2 c √k ≤ 0`, `g = m σ1 - σ3`, with `k = (1 + sin φ)/(1 - sin φ)`
//! and `m` alike from the dilatancy angle; elastic law linear. The return ends on the plane, on one
//! of the two edges or at the apex; the region is decided before the return. Cohesion and friction
//! may soften, dilatancy may decay with the accumulated deviatoric plastic strain. Limits: as all
//! softening laws, no length of its own.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Elasticity;
use super::drucker_prager::{PlasticStrain, Softening};
use super::linear_elastic::stiff_warnings;
use super::multi_surface::{self, ActiveSet, Plane, active_set};
use super::strength_reduced::StrengthReduction;
use crate::hencky::small_strain_tangent;
use crate::lanes::{Lanes, Spectra};
use crate::model::{Facts, Kind, Model, StrainMeasure, check};
use crate::{
    BLOCK, InitialCondition, Material, MaterialError, Motion, Point, PrincipalReturn, SmallStrain, SymTensor,
    Tangent,
};

const NAME: &str = "mohr-coulomb";

/// Points of a batch near yield from which on the spectra of all are found at once.
const WORTH_A_BATCH: usize = 8;

/// Parameters of `mohr-coulomb`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MohrCoulombSpec {
    /// Density (kg/m³), > 0.
    pub density: f64,
    /// Young's modulus (Pa), > 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Friction angle (degrees), 0 to 90 (excluded).
    pub friction_angle: f64,
    /// Cohesion (Pa), not negative.
    #[serde(default)]
    pub cohesion: f64,
    /// Dilatancy angle (degrees), between minus and plus the friction angle.
    #[serde(default)]
    pub dilatancy_angle: f64,
    /// Exponential softening of cohesion and friction; none when absent.
    #[serde(default)]
    pub softening: Option<Softening>,
    /// Rate at which the dilatancy angle decays with plastic strain.
    #[serde(default)]
    pub dilatancy_decay: f64,
    /// Largest principal tension (Pa, Rankine cut-off, associated), 0 to the apex `c / tan φ`; none when absent.
    #[serde(default)]
    pub tensile_strength: Option<f64>,
    /// Small strain in rate form, or logarithmic finite strain.
    #[serde(default)]
    pub strain_measure: StrainMeasure,
}

impl MohrCoulombSpec {
    /// Peak friction angle from the critical-state angle and the dilatancy angle (all in degrees),
    /// `φ = φ_cs + 0.8 ψ` (Bolton's rule, Anura3D manual eq. 7.28); sets both angles.
    #[must_use]
    pub fn from_bolton(self, critical_state_angle: f64, dilatancy_angle: f64) -> Self {
        Self { friction_angle: critical_state_angle + 0.8 * dilatancy_angle, dilatancy_angle, ..self }
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<MohrCoulomb, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        super::check_angles(self.friction_angle, self.dilatancy_angle)?;
        let (cohesion, decay) = (self.cohesion, self.dilatancy_decay);
        Softening::check(self.softening, self.friction_angle, cohesion, decay)?;
        let friction_angle = self.friction_angle.to_radians();
        if let Some(strength) = self.tensile_strength {
            let apex = cohesion / friction_angle.tan();
            let rule = format!("is not between 0 and the apex c / tan φ, {apex:.6} Pa");
            check("tensile_strength", strength, strength >= 0.0 && strength <= apex, &rule)?;
        }
        let constant = self.softening.is_none() && decay == 0.0;
        let peak = Pyramid::new(friction_angle, cohesion, self.dilatancy_angle.to_radians())
            .with_cut_off(self.tensile_strength);
        let (k, m) = (peak.friction, peak.dilatancy);
        let modulus =
            elasticity.lame() * (k - 1.0) * (m - 1.0) + 2.0 * elasticity.shear_modulus * (k * m + 1.0);
        let rule = "contracts faster than this stiffness can follow (aᵀ D b must be positive)";
        check("dilatancy_angle", self.dilatancy_angle, modulus > 0.0, rule)?;
        let peak = peak.returns(&elasticity);
        Ok(MohrCoulomb { name: NAME, elasticity, spec: self.clone(), constant, peak })
    }
}

impl Model for MohrCoulombSpec {
    const FACTS: Facts = Facts {
        source: "Anura3D manual 2021, eqs. 7.25–7.28; Clausen et al. 2006 (return)",
        kind: Kind::Solid,
        strain: "rate or Hencky",
        tangent: "analytic",
    };

    fn density(&self) -> f64 {
        self.density
    }

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(self.strain_measure.wrap(self.law()?))
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = stiff_warnings(self.poissons_ratio);
        warnings.extend(super::angle_warnings(self.friction_angle, self.dilatancy_angle));
        warnings
    }

    fn strength_reduced(&self, reduction: &StrengthReduction) -> Option<Result<Self, MaterialError>> {
        let friction_angle = reduction.angle(self.friction_angle);
        let cohesion = self.cohesion / reduction.factor;
        let reduced = Self {
            friction_angle,
            cohesion,
            dilatancy_angle: reduction.dilatancy(self.dilatancy_angle, friction_angle),
            softening: reduction.softening(self.softening),
            // Both the cut-off and the apex c / tan φ stay where they are.
            ..self.clone()
        };
        Some(reduced.law().map(|_| reduced))
    }

    fn examples() -> Vec<Self> {
        let mut all = Vec::new();
        for strain_measure in [StrainMeasure::Rate, StrainMeasure::Hencky] {
            let ways = [
                (None, None),
                (Some(Softening::EXAMPLE), None),
                (None, Some(2e3)),
                (Some(Softening::EXAMPLE), Some(2e3)),
            ];
            all.extend(ways.map(|(softening, tensile_strength)| Self {
                density: 2000.0,
                youngs_modulus: 20e6,
                poissons_ratio: 0.3,
                friction_angle: 30.0,
                cohesion: 10e3,
                dilatancy_angle: 10.0,
                softening,
                dilatancy_decay: if softening.is_some() { 2.0 } else { 0.0 },
                tensile_strength,
                strain_measure,
            }));
        }
        all
    }
}

/// The pyramid at some plastic strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pyramid {
    /// `k = (1 + sin φ)/(1 - sin φ)`.
    pub friction: f64,
    /// `m`, alike from the dilatancy angle.
    pub dilatancy: f64,
    /// Uniaxial compressive strength `2 c √k` (Pa).
    pub strength: f64,
    /// Largest principal tension (Pa); infinite without a cut-off.
    pub cut_off: f64,
}

/// The part of the surface a return ends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// Inside: no return.
    Elastic,
    /// The plane `σ1 > σ2 > σ3`.
    Plane,
    /// The edge `σ1 = σ2` (triaxial compression).
    CompressionEdge,
    /// The edge `σ2 = σ3` (triaxial extension).
    ExtensionEdge,
    /// The apex.
    Apex,
    /// Planes that the tension cut-off has part in, see [`Pyramid::planes`].
    CutOff(ActiveSet),
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl Pyramid {
    /// From friction angle, cohesion and dilatancy angle (rad, Pa, rad).
    pub fn new(friction_angle: f64, cohesion: f64, dilatancy_angle: f64) -> Self {
        let ratio = |angle: f64| (1.0 + angle.sin()) / (1.0 - angle.sin());
        let friction = ratio(friction_angle);
        let strength = 2.0 * cohesion * friction.sqrt();
        Self { friction, dilatancy: ratio(dilatancy_angle), strength, cut_off: f64::INFINITY }
    }

    /// The pyramid cut off at a principal tension (Pa).
    #[must_use]
    pub fn with_cut_off(self, tensile_strength: Option<f64>) -> Self {
        Self { cut_off: tensile_strength.unwrap_or(f64::INFINITY), ..self }
    }

    /// `k σ1 - σ3 - 2 c √k` (Pa), or `σ1 - σ_t` where that is larger.
    #[inline]
    pub fn yield_value(&self, principal: [f64; 3]) -> f64 {
        self.shear_excess(principal).max(principal[0] - self.cut_off)
    }

    #[inline]
    fn shear_excess(&self, principal: [f64; 3]) -> f64 {
        self.friction * principal[0] - principal[2] - self.strength
    }

    /// The planes that sorted stresses can meet: shear across 1–3, 1–2 and 2–3, then the cut-offs of the
    /// three principal stresses.
    pub fn planes(&self) -> [Plane; 6] {
        let (k, m) = (self.friction, self.dilatancy);
        let shear = |normal, flow| Plane { normal, offset: self.strength, flow };
        let tension = |normal| Plane { normal, offset: self.cut_off, flow: normal };
        [
            shear([k, 0.0, -1.0], [m, 0.0, -1.0]),
            shear([k, -1.0, 0.0], [m, -1.0, 0.0]),
            shear([0.0, k, -1.0], [0.0, m, -1.0]),
            tension([1.0, 0.0, 0.0]),
            tension([0.0, 1.0, 0.0]),
            tension([0.0, 0.0, 1.0]),
        ]
    }

    /// Return map in principal stresses (sheet §3.7.2, steps 1–5).
    pub fn return_map(&self, elasticity: &Elasticity, trial: [f64; 3]) -> ([f64; 3], Region) {
        self.returns(elasticity).map(trial)
    }

    /// The part of the surface that the return of `trial` ends on.
    pub fn region(&self, elasticity: &Elasticity, trial: [f64; 3]) -> Region {
        self.returns(elasticity).map(trial).1
    }

    /// Principal stresses of the return of `trial` to the given part of the surface.
    pub fn return_to(&self, region: Region, elasticity: &Elasticity, trial: [f64; 3]) -> [f64; 3] {
        self.returns(elasticity).to(region, trial)
    }

    /// What all returns to the pyramid have in common.
    fn returns(&self, elasticity: &Elasticity) -> Returns {
        let (k, m) = (self.friction, self.dilatancy);
        let db = stiffness(elasticity, [m, 0.0, -1.0]);
        let scale = 1.0 / (k * db[0] - db[2]);
        let direction = db.map(|c| c * scale);
        let edges = [([1.0, 1.0, k], [1.0, 1.0, m]), ([1.0, k, k], [1.0, m, m])];
        let edges = edges.map(|(edge, flow)| {
            // Elastic strain along the edge of the potential is not relaxed by the flow.
            let held = elastic_strain(elasticity, flow);
            let scale = 1.0 / dot(held, edge);
            Edge { direction: edge, position: held.map(|c| c * scale), beside: cross(direction, edge) }
        });
        Returns { pyramid: *self, elasticity: *elasticity, direction, edges, apex: self.strength / (k - 1.0) }
    }

    /// `∂σ_A/∂ε_B` of a return that ends in `region` (sheet §3.10), of constant strength.
    pub fn tangent(&self, elasticity: &Elasticity, region: Region) -> [[f64; 3]; 3] {
        let (k, m) = (self.friction, self.dilatancy);
        let d = elasticity.principal();
        let apply = |v: [f64; 3]| d.map(|row| dot(row, v));
        match region {
            Region::Elastic => d,
            Region::Plane => {
                let (da, db) = (apply([k, 0.0, -1.0]), apply([m, 0.0, -1.0]));
                let scale = 1.0 / dot([k, 0.0, -1.0], db);
                std::array::from_fn(|a| std::array::from_fn(|b| d[a][b] - scale * db[a] * da[b]))
            }
            Region::CompressionEdge | Region::ExtensionEdge => {
                let compression = region == Region::CompressionEdge;
                let along = |x: f64| if compression { [1.0, 1.0, x] } else { [1.0, x, x] };
                let (r, g) = (along(k), along(m));
                let scale = 1.0 / dot(g, elastic_strain(elasticity, r));
                r.map(|r| g.map(|g| scale * r * g))
            }
            Region::Apex => [[0.0; 3]; 3],
            Region::CutOff(set) => multi_surface::tangent(&self.planes(), set, elasticity),
        }
    }
}

/// A pyramid with what its returns have in common.
#[derive(Clone, Debug, PartialEq)]
struct Returns {
    pyramid: Pyramid,
    elasticity: Elasticity,
    /// `D b / (aᵀ D b)`: change of stress of a return to the plane, per unit of the yield function.
    direction: [f64; 3],
    /// Of triaxial compression and of triaxial extension.
    edges: [Edge; 2],
    /// Principal stress at the apex (Pa); infinite without friction.
    apex: f64,
}

/// An edge of the pyramid; positions are measured from the apex.
#[derive(Clone, Debug, PartialEq)]
struct Edge {
    direction: [f64; 3],
    /// Of a trial, the position along the edge that its return ends at.
    position: [f64; 3],
    /// Normal of the plane through the edge and the direction of return.
    beside: [f64; 3],
}

impl Returns {
    /// Return of `trial` and the part of the surface it ends on.
    #[inline]
    fn map(&self, trial: [f64; 3]) -> ([f64; 3], Region) {
        let region = self.shear_region(trial);
        let stress = self.to(region, trial);
        let slack = 8.0 * f64::EPSILON * (trial[0].abs() + self.pyramid.strength);
        if stress[0] <= self.pyramid.cut_off + slack {
            return (stress, region);
        }
        let set = active_set(&self.pyramid.planes(), &self.elasticity, trial);
        let region = set.map_or(Region::Apex, Region::CutOff);
        (self.to(region, trial), region)
    }

    /// The part of the surface without its cut-off.
    #[inline]
    fn shear_region(&self, trial: [f64; 3]) -> Region {
        let pyramid = &self.pyramid;
        // Round-off of an earlier return is not flow.
        let scale = pyramid.friction * trial[0].abs() + trial[2].abs() + pyramid.strength;
        if pyramid.shear_excess(trial) <= 8.0 * f64::EPSILON * scale {
            return Region::Elastic;
        }
        if pyramid.friction == 1.0 {
            // Without friction there is no apex: the prism of Tresca (sheet §3.7.4).
            let plane = self.to(Region::Plane, trial);
            return if trial[1] > plane[0] {
                Region::CompressionEdge
            } else if trial[1] < plane[2] {
                Region::ExtensionEdge
            } else {
                Region::Plane
            };
        }
        let from_apex = trial.map(|s| s - self.apex);
        let [first, second] = &self.edges;
        if dot(first.position, from_apex) > 0.0 && dot(second.position, from_apex) > 0.0 {
            Region::Apex
        } else if dot(first.beside, from_apex) < 0.0 {
            Region::CompressionEdge
        } else if dot(second.beside, from_apex) > 0.0 {
            Region::ExtensionEdge
        } else {
            Region::Plane
        }
    }

    /// Principal stresses of the return of `trial` to the given part of the surface.
    #[inline]
    fn to(&self, region: Region, trial: [f64; 3]) -> [f64; 3] {
        let pyramid = &self.pyramid;
        match region {
            Region::Elastic => trial,
            Region::Plane => {
                let onto = |s: [f64; 3]| {
                    let excess = pyramid.shear_excess(s);
                    std::array::from_fn(|i| s[i] - excess * self.direction[i])
                };
                // Twice: round-off is then that of the result, not of the trial.
                onto(onto(trial))
            }
            Region::Apex => [pyramid.cut_off.min(self.apex); 3],
            Region::CutOff(set) => {
                let onto = |s| multi_surface::return_to(&pyramid.planes(), set, &self.elasticity, s);
                onto(onto(trial))
            }
            _ if pyramid.friction == 1.0 => {
                let mean = (trial[0] + trial[1] + trial[2]) / 3.0;
                let third = pyramid.strength / 3.0;
                if region == Region::CompressionEdge {
                    [mean + third, mean + third, mean - 2.0 * third]
                } else {
                    [mean + 2.0 * third, mean - third, mean - third]
                }
            }
            Region::CompressionEdge | Region::ExtensionEdge => {
                let edge = &self.edges[usize::from(region == Region::ExtensionEdge)];
                let position = dot(edge.position, trial.map(|s| s - self.apex));
                edge.direction.map(|r| self.apex + position * r)
            }
        }
    }
}

fn stiffness(elasticity: &Elasticity, v: [f64; 3]) -> [f64; 3] {
    let volumetric = elasticity.lame() * (v[0] + v[1] + v[2]);
    v.map(|c| volumetric + 2.0 * elasticity.shear_modulus * c)
}

fn elastic_strain(elasticity: &Elasticity, v: [f64; 3]) -> [f64; 3] {
    let mean = (v[0] + v[1] + v[2]) / 3.0;
    v.map(|c| (c - mean) / (2.0 * elasticity.shear_modulus) + mean / (3.0 * elasticity.bulk_modulus))
}

/// The law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct MohrCoulomb {
    name: &'static str,
    elasticity: Elasticity,
    spec: MohrCoulombSpec,
    constant: bool,
    peak: Returns,
}

impl MohrCoulomb {
    /// The same law under another name, for models that are a special case of it.
    pub(super) fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// The same law with `share` of its cohesion, peak and residual.
    pub(super) fn scaled_cohesion(&self, share: f64) -> Self {
        let mut law = self.clone();
        law.spec.cohesion *= share;
        law.spec.softening = law.spec.softening.map(|s| s.scaled_cohesion(share));
        let strength = law.peak.pyramid.strength * share;
        law.peak = Pyramid { strength, ..law.peak.pyramid }.returns(&law.elasticity);
        law
    }

    /// The pyramid at plastic strain `kappa`.
    pub fn pyramid_at(&self, kappa: f64) -> Pyramid {
        if self.constant {
            return self.peak.pyramid;
        }
        self.softened(kappa)
    }

    #[inline(never)]
    fn softened(&self, kappa: f64) -> Pyramid {
        let spec = &self.spec;
        let peak = (spec.friction_angle.to_radians(), spec.cohesion);
        let (friction, cohesion) = spec.softening.map_or(peak, |s| s.strength(peak, kappa));
        let dilatancy = spec.dilatancy_angle.to_radians() * (-spec.dilatancy_decay * kappa).exp();
        Pyramid::new(friction, cohesion, dilatancy).with_cut_off(spec.tensile_strength)
    }

    /// Deviatoric plastic strain of a return from `trial` to `stress`.
    fn plastic_increment(&self, trial: [f64; 3], stress: [f64; 3]) -> f64 {
        let change: [f64; 3] = std::array::from_fn(|i| trial[i] - stress[i]);
        let mean = (change[0] + change[1] + change[2]) / 3.0;
        let deviator = change.map(|c| c - mean);
        (2.0 / 3.0 * dot(deviator, deviator)).sqrt() / (2.0 * self.elasticity.shear_modulus)
    }

    /// True where no principal stress can violate yield, from invariants alone.
    #[inline(always)]
    fn surely_elastic(&self, trial: &SymTensor, pyramid: &Pyramid) -> bool {
        let mean = trial.trace() / 3.0;
        let s = trial.deviator();
        // |σ_i - mean| ≤ 2 √(J2/3)
        let radius = (2.0 / 3.0 * s.dot(&s)).sqrt();
        (pyramid.friction - 1.0) * mean + (pyramid.friction + 1.0) * radius <= pyramid.strength
            && mean + radius <= pyramid.cut_off
    }
}

impl SmallStrain for MohrCoulomb {
    type State = PlasticStrain;

    fn name(&self) -> &'static str {
        self.name
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<PlasticStrain>, MaterialError> {
        let principal = initial.stress.principal_values();
        let peak = &self.peak.pyramid;
        let scale = peak.strength + peak.friction * principal[0].abs() + principal[2].abs();
        super::check_initial(self.name, &initial.stress, peak.yield_value(principal), scale)?;
        Ok(Point { stress: initial.stress, state: PlasticStrain::default() })
    }

    #[inline]
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<PlasticStrain>,
    ) -> Result<Point<PlasticStrain>, MaterialError> {
        let trial = old.stress + self.elasticity.stress(strain);
        let pyramid = self.pyramid_at(old.state.deviatoric);
        if self.surely_elastic(&trial, &pyramid) {
            return Ok(Point { stress: trial, state: old.state });
        }
        if !trial.is_finite() {
            return Err(MaterialError::Motion { model: self.name, reason: "the trial stress is not finite" });
        }
        let spectrum = trial.spectrum();
        let (principal, state) = self.return_principal(spectrum.values, &old.state)?;
        if principal == spectrum.values {
            return Ok(Point { stress: trial, state });
        }
        Ok(Point { stress: spectrum.compose(principal), state })
    }

    #[inline]
    fn update_lanes(&self, lanes: &mut Lanes, states: &mut [PlasticStrain]) -> bool {
        if !self.constant {
            return false;
        }
        let mut inside = [0.0; BLOCK];
        lanes.for_each(&mut inside, |strain, stress| {
            let trial = *stress + self.elasticity.stress(strain);
            let elastic = self.surely_elastic(&trial, &self.peak.pyramid);
            (trial, if elastic { 1.0 } else { 0.0 })
        });
        let outside = inside.iter().take(states.len()).filter(|inside| **inside == 0.0).count();
        let mut spectra = Spectra::EMPTY;
        if outside >= WORTH_A_BATCH {
            lanes.spectra(&mut spectra);
        }
        for (index, state) in states.iter_mut().enumerate() {
            if inside[index] == 1.0 {
                continue;
            }
            let spectrum =
                if outside >= WORTH_A_BATCH { spectra.of(index) } else { lanes.stress_of(index).spectrum() };
            let (principal, region) = self.peak.map(spectrum.values);
            if region != Region::Elastic {
                state.deviatoric += self.plastic_increment(spectrum.values, principal);
                lanes.set_stress(index, &spectrum.compose(principal));
            }
        }
        true
    }

    fn wave_modulus(&self, _point: &Point<PlasticStrain>) -> f64 {
        self.elasticity.p_wave_modulus()
    }

    /// Consistent tangent (sheet §3.10).
    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<PlasticStrain>) -> Option<Tangent> {
        small_strain_tangent(self, &(old.stress + self.elasticity.stress(strain)), &old.state)
    }

    fn yield_value(&self, point: &Point<PlasticStrain>) -> Option<f64> {
        Some(self.pyramid_at(point.state.deviatoric).yield_value(point.stress.spectrum().values))
    }

    fn stored_energy(&self, point: &Point<PlasticStrain>) -> Option<f64> {
        Some(self.elasticity.energy(&point.stress))
    }

    fn dissipation(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<PlasticStrain>,
        new: &Point<PlasticStrain>,
    ) -> Option<f64> {
        let trial = old.stress + self.elasticity.stress(strain);
        Some(self.elasticity.dissipation(&trial, &new.stress))
    }

    fn output_names(&self) -> &'static [&'static str] {
        &["plastic_strain"]
    }

    fn outputs(&self, point: &Point<PlasticStrain>, out: &mut [f64]) {
        out[0] = point.state.deviatoric;
    }
}

impl PrincipalReturn for MohrCoulomb {
    fn elasticity(&self) -> &Elasticity {
        &self.elasticity
    }

    fn return_principal(
        &self,
        trial: [f64; 3],
        state: &PlasticStrain,
    ) -> Result<([f64; 3], PlasticStrain), MaterialError> {
        let kappa = state.deviatoric;
        let (mut stress, region) = if self.constant {
            self.peak.map(trial)
        } else {
            self.softened(kappa).return_map(&self.elasticity, trial)
        };
        if region == Region::Elastic {
            return Ok((trial, *state));
        }
        let mut increment = self.plastic_increment(trial, stress);
        if !self.constant {
            (stress, increment) = self.softening_return(trial, kappa, increment)?;
        }
        Ok((stress, PlasticStrain { deviatoric: kappa + increment }))
    }

    fn principal_tangent(&self, trial: [f64; 3], state: &PlasticStrain) -> Option<[[f64; 3]; 3]> {
        let pyramid = self.pyramid_at(state.deviatoric);
        let (_, region) = pyramid.return_map(&self.elasticity, trial);
        if region == Region::Elastic || self.constant {
            return Some(pyramid.tangent(&self.elasticity, region));
        }
        self.softening_tangent(trial, state)
    }
}

impl MohrCoulomb {
    /// As [`Pyramid::tangent`], with strength at the end of the step: from `dσ = D dε + σ' dκ` and
    /// `dκ = w · (dε - C dσ)`, `w` the direction of the deviatoric plastic strain.
    fn softening_tangent(&self, trial: [f64; 3], state: &PlasticStrain) -> Option<[[f64; 3]; 3]> {
        let (stress, new) = self.return_principal(trial, state).ok()?;
        let kappa = new.deviatoric;
        let pyramid = self.pyramid_at(kappa);
        let region = pyramid.region(&self.elasticity, trial);
        let fixed = pyramid.tangent(&self.elasticity, region);
        let increment = kappa - state.deviatoric;
        if increment <= 0.0 {
            return Some(fixed);
        }
        let step = Softening::difference_step(self.spec.softening, self.spec.dilatancy_decay);
        let at = |kappa: f64| self.pyramid_at(kappa).return_to(region, &self.elasticity, trial);
        let (plus, minus) = (at(kappa + step), at(kappa - step));
        let slope: [f64; 3] = std::array::from_fn(|a| (plus[a] - minus[a]) / (2.0 * step));
        let plastic = elastic_strain(&self.elasticity, std::array::from_fn(|a| trial[a] - stress[a]));
        let mean = (plastic[0] + plastic[1] + plastic[2]) / 3.0;
        let w = plastic.map(|e| 2.0 / 3.0 * (e - mean) / increment);
        let modulus = 1.0 + dot(w, elastic_strain(&self.elasticity, slope));
        let driven: [f64; 3] = std::array::from_fn(|b| {
            let column = std::array::from_fn(|a| fixed[a][b]);
            (w[b] - dot(w, elastic_strain(&self.elasticity, column))) / modulus
        });
        Some(std::array::from_fn(|a| std::array::from_fn(|b| fixed[a][b] + slope[a] * driven[b])))
    }

    /// The plastic increment that reproduces itself when strength is taken at its end: it lies between
    /// nothing and the increment that takes all of the deviator.
    fn softening_return(
        &self,
        trial: [f64; 3],
        kappa: f64,
        start: f64,
    ) -> Result<([f64; 3], f64), MaterialError> {
        let mean = trial.iter().sum::<f64>() / 3.0;
        let largest = self.plastic_increment(trial, [mean; 3]);
        let (mut low, mut high) = (0.0, largest.max(start));
        let mut increment = start;
        for _ in 0..200 {
            let stress = self.pyramid_at(kappa + increment).return_map(&self.elasticity, trial).0;
            let mapped = self.plastic_increment(trial, stress);
            if (mapped - increment).abs() <= 1e-13 * high || high - low <= 1e-15 * high {
                return Ok((stress, increment));
            }
            if mapped > increment {
                low = increment;
            } else {
                high = increment;
            }
            increment = if mapped > low && mapped < high { mapped } else { 0.5 * (low + high) };
        }
        Err(MaterialError::NotConverged { model: self.name, reason: "softening return" })
    }
}
