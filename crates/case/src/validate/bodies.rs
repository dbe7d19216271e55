//! Rules of bodies: position, initial state, pore fluid.

use std::collections::HashSet;

use colluvium_constitutive::MaterialSpec;
use colluvium_points::{Sampling, SamplingError, Shape, common_interior_point, overlapping_boxes};

use crate::CaseErrorKind;
use crate::Formula;
use crate::description::OVERLAP_RESOLUTION;
use crate::description::{InitialStress, PoreFluid, PorePressure, Velocity};
use crate::error_collector::ErrorCollector;

/// Sample points along each axis of a body at which its formulas are evaluated.
const SAMPLES: usize = 7;

impl ErrorCollector<'_> {
    /// Checks the bodies: names, materials, positions in the domain, initial state.
    pub(super) fn bodies(&mut self) {
        let case = self.case;
        let dimension = case.dimension();
        let materials: Vec<&str> = case.materials.keys().map(String::as_str).collect();
        let mut names = HashSet::new();
        let mut sound = vec![false; case.bodies.len()];
        for (number, body) in case.bodies.iter().enumerate() {
            let path = format!("bodies[{number}]");
            if !names.insert(&body.name) {
                let problem = format!("{:?} is the name of two bodies", body.name);
                self.report(format!("{path}.name"), CaseErrorKind::coded("duplicate-name", problem));
            }
            self.name(&format!("{path}.material"), &body.material, &materials, "defined under materials");
            if self.is_packed_beyond_domain(number) {
                continue;
            }
            match body.shape.validate(dimension) {
                Err(error) => self.report(format!("{path}.shape.{}", error.path), error.problem),
                Ok(()) => {
                    sound[number] = true;
                    self.within_domain(number);
                }
            }
            if let Some(spacing) = body.points.as_ref().and_then(|points| points.spacing) {
                let longest = case.domain.max_extent();
                self.require(
                    spacing > 0.0 && spacing <= longest,
                    format!("{path}.points.spacing"),
                    format!("{spacing:?} must be positive and no longer than the domain, {longest:?} m"),
                );
            }
            self.sampling(number);
            let shape = Some(&body.shape).filter(|_| sound[number]);
            self.velocity(&format!("{path}.velocity"), shape, &body.velocity);
            self.initial_stress(&format!("{path}.stress"), shape, &body.stress);
            let rigid = |problem: &str| CaseErrorKind::coded("rigid-motion", problem);
            let (whole, path_outside) =
                (!(body.rigid && body.remove_outside), format!("{path}.remove_outside"));
            self.require(whole, path_outside, rigid("is not available for a rigid body"));
            self.start_of_rigid(&format!("{path}.velocity"), number);
            let slack = !body.rigid || body.stress == InitialStress::None;
            self.require(slack, format!("{path}.stress"), rigid("a rigid body has no stress"));
            let material = case.materials.get(&body.material);
            let unfit = if let Some(fluid) = &body.pore_fluid {
                self.pore_fluid(&format!("{path}.pore_fluid"), shape, fluid);
                material.and_then(no_skeleton)
            } else {
                material.filter(|_| !body.rigid).and_then(no_soil)
            };
            if let Some(problem) = unfit {
                self.report(format!("{path}.material"), format!("{:?} {problem}", body.material));
            }
        }
        let placed: Vec<usize> = (0..case.bodies.len()).filter(|number| sound[*number]).collect();
        let bounds: Vec<_> =
            placed.iter().map(|number| case.bodies[*number].shape.bounds(dimension)).collect();
        for (first, second) in overlapping_boxes(&bounds) {
            self.no_overlap(placed[first], placed[second]);
        }
    }

    /// Checks the sampling of a body: its shape, its space and its seed must suit it.
    fn sampling(&mut self, number: usize) {
        let body = &self.case.bodies[number];
        let seeded = body.sampling == Sampling::PoissonDisk;
        let problem = "needs `sampling` `poisson-disk`, the only random sampling";
        self.require(
            seeded || body.sampling_seed == 0,
            format!("bodies[{number}].sampling_seed"),
            CaseErrorKind::coded("needs-other-key", problem),
        );
        if body.sampling.is_lattice() {
            return;
        }
        let path = format!("bodies[{number}].sampling");
        self.require(
            body.points.is_none(),
            path.clone(),
            CaseErrorKind::coded(
                "conflicting-keys",
                "the body has its points from a file: leave the sampling out",
            ),
        );
        if seeded {
            let rows = "rows that follow a terrain determine the points: leave the sampling out";
            return self.require(
                !body.shape.follows_terrain(),
                path,
                CaseErrorKind::coded("conflicting-keys", rows),
            );
        }
        // Errors of the shape itself are reported with the shape.
        let sides = self.case.dimension() == 2
            && (body.shape.validate(2).is_err() || body.shape.has_boundary_edges());
        self.require(sides, path, SamplingError::NoBoundaryEdges.to_string());
    }

    /// Checks bodies with terrain layers after the files of the layers are read.
    pub(super) fn layers(&mut self, layered: &[usize]) {
        for &number in layered {
            self.within_domain(number);
            for other in (0..self.case.bodies.len()).filter(|other| *other != number) {
                if !layered.contains(&other) || other < number {
                    self.no_overlap(number.min(other), number.max(other));
                }
            }
        }
    }

    /// Whether a microstructure reaches beyond the domain. It is reported before its spheres are packed, which takes seconds.
    fn is_packed_beyond_domain(&mut self, number: usize) -> bool {
        let dimension = self.case.dimension();
        let Shape::Microstructure { min, max, .. } = &self.case.bodies[number].shape else { return false };
        if [min, max].iter().any(|corner| corner.len() != dimension) {
            return false;
        }
        let before = self.errors.len();
        self.within_domain(number);
        self.errors.len() > before
    }

    /// Checks that a body is in the domain.
    fn within_domain(&mut self, number: usize) {
        let (case, dimension) = (self.case, self.case.dimension());
        let (low, high) = case.bodies[number].shape.bounds(dimension);
        for axis in 0..dimension {
            let Some((min, max)) = self.extent(axis) else { continue };
            let slack = 1e-9 * (max - min);
            if low[axis] < min - slack || high[axis] > max + slack {
                let [low, high, min, max] = [low[axis], high[axis], min, max].map(|x| x + self.origin[axis]);
                let problem = format!(
                    "reaches from {low} to {high} m along {}, beyond the domain from {min} to {max} m",
                    ["x", "y", "z"][axis]
                );
                self.report(
                    format!("bodies[{number}].shape"),
                    CaseErrorKind::coded("outside-domain", problem),
                );
            }
        }
    }

    /// Checks that two bodies do not overlap.
    fn no_overlap(&mut self, first: usize, second: usize) {
        let (a, b) = (&self.case.bodies[first], &self.case.bodies[second]);
        if let Some(place) =
            common_interior_point(&a.shape, &b.shape, self.case.dimension(), OVERLAP_RESOLUTION)
        {
            let place: Vec<f64> = place.iter().zip(self.origin).map(|(x, origin)| x + origin).collect();
            let problem = format!("overlaps the body {:?}, for example at {place:.4?} m", a.name);
            self.report(format!("bodies[{second}].shape"), CaseErrorKind::coded("overlap", problem));
        }
    }

    /// Checks that a formula has coordinates of the space only, and finite values at sample points of `shape`. A value that is not finite
    /// elsewhere appears as a non-finite state at the start of the run.
    fn formula(&mut self, path: impl Into<String>, shape: Option<&Shape>, formula: &Formula) {
        let dimension = self.case.dimension();
        let Some(shape) = shape else { return };
        if let Some(name) = formula.unknown_coordinate(dimension) {
            let problem = format!("has the coordinate {name}, the space has {dimension} dimensions");
            return self.report(path, CaseErrorKind::coded("wrong-dimension", problem));
        }
        let (low, high) = shape.bounds(dimension);
        let at = |number: usize| -> [f64; 3] {
            std::array::from_fn(|axis| {
                let share = (number / SAMPLES.pow(axis as u32) % SAMPLES) as f64 / (SAMPLES - 1) as f64;
                if axis < dimension { low[axis] + share * (high[axis] - low[axis]) } else { 0.0 }
            })
        };
        let mut inside =
            (0..SAMPLES.pow(dimension as u32)).map(at).filter(|x| shape.contains(&x[..dimension]));
        if let Some(place) = inside.find(|x| !formula.evaluate(*x).is_finite()) {
            self.report(
                path,
                CaseErrorKind::coded(
                    "formula",
                    format!("has no finite value at {:?} m", &place[..dimension]),
                ),
            );
        }
    }

    /// Checks an initial velocity field.
    fn velocity(&mut self, path: &str, shape: Option<&Shape>, velocity: &Velocity) {
        match velocity {
            Velocity::Rest => {}
            Velocity::Uniform { value } => self.vector(&format!("{path}.value"), value),
            Velocity::Linear { value, origin, gradient } => {
                self.vector(&format!("{path}.value"), value);
                self.vector(&format!("{path}.origin"), origin);
                let dimension = self.case.dimension();
                let problem = format!("has {} rows, the space has {dimension} dimensions", gradient.len());
                self.require(
                    gradient.len() == dimension,
                    format!("{path}.gradient"),
                    CaseErrorKind::coded("wrong-dimension", problem),
                );
                for (row, values) in gradient.iter().enumerate() {
                    self.vector(&format!("{path}.gradient[{row}]"), values);
                }
            }
            Velocity::Sine { amplitude, wave_vector, phase } => {
                self.vector(&format!("{path}.amplitude"), amplitude);
                self.vector(&format!("{path}.wave_vector"), wave_vector);
                self.finite(format!("{path}.phase"), *phase);
            }
            Velocity::Formula { value } => {
                let dimension = self.case.dimension();
                let problem = format!("has {} components, the space has {dimension} dimensions", value.len());
                self.require(
                    value.len() == dimension,
                    format!("{path}.value"),
                    CaseErrorKind::coded("wrong-dimension", problem),
                );
                for (c, formula) in value.iter().enumerate() {
                    self.formula(format!("{path}.value[{c}]"), shape, formula);
                }
            }
            Velocity::Bending { along, across, clamp, length, tip } => {
                let dimension = self.case.dimension();
                let fits = *along < dimension && *across < dimension && along != across;
                let problem = format!("{across} and along {along} must be two different axes of the space");
                self.require(
                    fits,
                    format!("{path}.across"),
                    CaseErrorKind::coded("wrong-dimension", problem),
                );
                self.finite(format!("{path}.clamp"), *clamp);
                self.positive(format!("{path}.length"), *length, "m");
                self.finite(format!("{path}.tip"), *tip);
            }
        }
    }

    /// Checks an initial stress.
    fn initial_stress(&mut self, path: &str, shape: Option<&Shape>, stress: &InitialStress) {
        match stress {
            InitialStress::None => {}
            InitialStress::Uniform { value } => {
                for (number, component) in value.iter().enumerate() {
                    self.finite(format!("{path}.value[{number}]"), *component);
                }
            }
            InitialStress::Formula { value } => {
                for (c, formula) in value.iter().enumerate() {
                    self.formula(format!("{path}.value[{c}]"), shape, formula);
                }
            }
            InitialStress::K0 { surface, coefficient } => {
                self.finite(format!("{path}.surface"), *surface);
                self.not_negative(format!("{path}.coefficient"), *coefficient, "");
                let along = self.case.gravity.iter().filter(|g| **g != 0.0).count();
                self.require(
                    along == 1,
                    path,
                    CaseErrorKind::coded("needs-other-key", "a K0 stress needs gravity along one axis"),
                );
            }
        }
    }

    /// Checks the initial pressure of a pore fluid.
    fn initial_pore_pressure(&mut self, path: &str, shape: Option<&Shape>, pressure: &PorePressure) {
        match pressure {
            PorePressure::None => {}
            PorePressure::Uniform { value } => self.finite(format!("{path}.value"), *value),
            PorePressure::Formula { value } => self.formula(format!("{path}.value"), shape, value),
            PorePressure::Hydrostatic { surface } => {
                self.finite(format!("{path}.surface"), *surface);
                let along = self.case.gravity.iter().filter(|g| **g != 0.0).count();
                self.require(
                    along == 1,
                    path,
                    CaseErrorKind::coded(
                        "needs-other-key",
                        "a hydrostatic pressure needs gravity along one axis",
                    ),
                );
            }
        }
    }

    /// Checks the pore fluid of a body.
    fn pore_fluid(&mut self, path: &str, shape: Option<&Shape>, fluid: &PoreFluid) {
        let gravity = &self.case.gravity;
        let at = |key: &str| format!("{path}.{key}");
        let problem = format!("{} is not between 0 and 1 (both excluded)", fluid.porosity);
        self.require(fluid.porosity > 0.0 && fluid.porosity < 1.0, at("porosity"), problem);
        self.positive(at("density"), fluid.density, "kg/m³");
        self.positive(at("bulk_modulus"), fluid.bulk_modulus, "Pa");
        self.positive(at("viscosity"), fluid.viscosity, "Pa s");
        match (fluid.permeability, fluid.intrinsic_permeability) {
            (Some(value), None) => {
                self.positive(at("permeability"), value, "m/s");
                let problem = "a hydraulic conductivity depends on gravity, but the case has none: give \
                               intrinsic_permeability (m²)";
                self.require(gravity.iter().any(|g| *g != 0.0), at("permeability"), problem);
            }
            (None, Some(value)) => self.positive(at("intrinsic_permeability"), value, "m²"),
            _ => self.report(
                at("permeability"),
                CaseErrorKind::coded(
                    "conflicting-keys",
                    "give either permeability (m/s) or intrinsic_permeability (m²)",
                ),
            ),
        }
        self.initial_pore_pressure(&at("pressure"), shape, &fluid.pressure);
        if let Some(ratio) = fluid.excess_ratio {
            self.rule((0.0..=1.0).contains(&ratio), at("excess_ratio"), ratio, "is not in 0..=1");
            let problem = "is given in addition to excess_ratio: leave out one of the two";
            self.require(
                fluid.pressure == PorePressure::None,
                at("pressure"),
                CaseErrorKind::coded("conflicting-keys", problem),
            );
        }
        if let Some(velocity) = &fluid.velocity {
            self.velocity(&at("velocity"), shape, velocity);
        }
        if let Some(strength) = fluid.cavitation_strength {
            self.not_negative(at("cavitation_strength"), strength, " (Pa)");
            if let PorePressure::Uniform { value } = fluid.pressure {
                let rule = "is below minus the cavitation strength";
                self.rule(value >= -strength, at("pressure.value"), value, rule);
            }
        }
    }
}

/// Reason why a material cannot be the skeleton around a pore fluid.
fn no_skeleton(material: &MaterialSpec) -> Option<&'static str> {
    if material.is_fluid() {
        return Some("is a fluid and has no pores");
    }
    let problem =
        "already contains its pore water: give the material of its skeleton, or leave out pore_fluid";
    has_layer(material, "undrained").then_some(problem)
}

/// Reason why a material cannot be a soil without a pore fluid.
fn no_soil(material: &MaterialSpec) -> Option<&'static str> {
    let problem =
        "loses strength as its saturation grows, but without a pore_fluid the body has no saturation";
    has_layer(material, "saturation-softened").then_some(problem)
}

/// Whether a material is of the model, or wraps one that is.
fn has_layer(material: &MaterialSpec, model: &str) -> bool {
    material.name() == model || material.inner().is_some_and(|inner| has_layer(inner, model))
}
