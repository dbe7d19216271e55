//! Validation of the options (sheet: dem §7).

use colluvium_case::CaseErrorKind;

use super::{Adhesion, BondSpec, DemOptions, Friction, NormalLaw, PairSpec, RollingSpec, TangentialSpec};

/// Largest damping ratio. The restitution with `clamp` is then 0.009.
const MAX_DAMPING_RATIO: f64 = 5.0;
/// Smallest restitution coefficient: that of the largest damping ratio, with `clamp`.
const MIN_RESTITUTION: f64 = 0.01;

/// Violated rule: path from the options, and problem.
pub type BrokenRule = (String, CaseErrorKind);

/// Whether a number is finite and positive.
fn positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

/// Whether a number is finite and zero or positive.
fn not_negative(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}

/// Collector of the first violated rule.
struct RuleChecker {
    first: Option<BrokenRule>,
}

impl RuleChecker {
    /// Records the first rule that does not hold, with the path of the option.
    fn require(&mut self, holds: bool, path: impl Into<String>, kind: impl Into<CaseErrorKind>) {
        if !holds && self.first.is_none() {
            self.first = Some((path.into(), kind.into()));
        }
    }

    /// Requires a finite positive value.
    fn positive(&mut self, path: impl Into<String>, value: f64, unit: &str) {
        let rule = format!("must be finite and positive{unit}");
        self.require(positive(value), path, CaseErrorKind::out_of_range(value, rule));
    }

    /// Requires a finite value that is zero or positive.
    fn not_negative(&mut self, path: impl Into<String>, value: f64, unit: &str) {
        let rule = format!("must be finite and not negative{unit}");
        self.require(not_negative(value), path, CaseErrorKind::out_of_range(value, rule));
    }

    /// Requires a value between `low` and `high`, bounds included.
    fn in_range(&mut self, path: impl Into<String>, value: f64, low: f64, high: f64) {
        let kind = CaseErrorKind::out_of_range(value, format!("is not in {low}..={high}"));
        self.require((low..=high).contains(&value), path, kind);
    }

    /// Checks the stiffness and the damping of a normal contact law.
    fn normal(&mut self, path: &str, law: &NormalLaw) {
        let (restitution, ratio) = match law {
            NormalLaw::Linear { stiffness, grain_modulus, restitution, damping_ratio, .. } => {
                match (stiffness, grain_modulus) {
                    (Some(value), None) => self.positive(format!("{path}.stiffness"), *value, " (N/m)"),
                    (None, Some(value)) => self.positive(format!("{path}.grain_modulus"), *value, " (Pa)"),
                    _ => self.require(
                        false,
                        format!("{path}.stiffness"),
                        "give either stiffness or grain_modulus",
                    ),
                }
                (restitution, damping_ratio)
            }
            NormalLaw::Hertz {
                youngs_modulus,
                poissons_ratio,
                other_youngs_modulus,
                other_poissons_ratio,
                restitution,
                damping_ratio,
                ..
            } => {
                self.positive(format!("{path}.youngs_modulus"), *youngs_modulus, " (Pa)");
                if let Some(value) = other_youngs_modulus {
                    self.positive(format!("{path}.other_youngs_modulus"), *value, " (Pa)");
                }
                for (key, value) in [
                    ("poissons_ratio", Some(*poissons_ratio)),
                    ("other_poissons_ratio", *other_poissons_ratio),
                ] {
                    let Some(value) = value else { continue };
                    let holds = value > -1.0 && value <= 0.5;
                    self.require(
                        holds,
                        format!("{path}.{key}"),
                        format!("{value} is not in -1..=0.5 (-1 excluded)"),
                    );
                }
                (restitution, damping_ratio)
            }
        };
        if let Some(value) = restitution {
            self.in_range(format!("{path}.restitution"), *value, MIN_RESTITUTION, 1.0);
            let problem = "restitution is given too: leave one of them out";
            self.require(ratio.is_none(), format!("{path}.damping_ratio"), problem);
        }
        if let Some(value) = ratio {
            self.damping_ratio(path, *value);
        }
    }

    /// Checks a damping ratio, one at critical damping. Steps do not resolve dashpots far above it: grains would bounce from them.
    fn damping_ratio(&mut self, path: &str, ratio: f64) {
        self.in_range(format!("{path}.damping_ratio"), ratio, 0.0, MAX_DAMPING_RATIO);
    }

    /// Checks the friction coefficients; the one at rest must not be below the sliding one.
    fn friction(&mut self, path: &str, friction: &Friction) {
        self.not_negative(format!("{path}.coefficient"), friction.coefficient, "");
        if let Some(at_rest) = friction.at_rest {
            let holds = at_rest.is_finite() && at_rest >= friction.coefficient;
            let problem = format!("{at_rest} must not be below the coefficient, {}", friction.coefficient);
            self.require(holds, format!("{path}.at_rest"), problem);
        }
    }

    /// Checks stiffness and damping ratio of the tangential spring.
    fn tangential(&mut self, path: &str, spec: &TangentialSpec) {
        self.in_range(format!("{path}.stiffness_ratio"), spec.stiffness_ratio.unwrap_or(0.0), 0.0, 3.0);
        self.damping_ratio(path, spec.damping_ratio.unwrap_or(0.0));
    }

    /// Checks friction, stiffness and damping ratio of rolling or torsion resistance.
    fn rolling(&mut self, path: &str, spec: &RollingSpec) {
        self.not_negative(format!("{path}.friction"), spec.friction, "");
        self.positive(format!("{path}.stiffness_ratio"), spec.stiffness_ratio, "");
        self.damping_ratio(path, spec.damping_ratio);
    }

    /// Checks the parameters of an adhesion law and that the normal law supports it.
    fn adhesion(&mut self, path: &str, adhesion: &Adhesion, normal: &NormalLaw) {
        match adhesion {
            Adhesion::Cohesive { tension, shear, .. } => {
                self.not_negative(format!("{path}.tension"), *tension, "");
                self.not_negative(format!("{path}.shear"), *shear, "");
                let linear = matches!(normal, NormalLaw::Linear { .. });
                self.require(
                    linear,
                    format!("{path}.kind"),
                    CaseErrorKind::coded(
                        "needs-other-key",
                        "cohesive requires the linear normal law, whose spring transmits tension",
                    ),
                );
            }
            Adhesion::Jkr { work_of_adhesion } => {
                self.positive(format!("{path}.work_of_adhesion"), *work_of_adhesion, " (J/m²)");
                let hertz = matches!(normal, NormalLaw::Hertz { .. });
                self.require(
                    hertz,
                    format!("{path}.kind"),
                    CaseErrorKind::coded("needs-other-key", "jkr requires the hertz normal law"),
                );
            }
            Adhesion::Capillary { surface_tension, contact_angle, volume_ratio } => {
                self.positive(format!("{path}.surface_tension"), *surface_tension, " (N/m)");
                self.positive(format!("{path}.volume_ratio"), *volume_ratio, "");
                let holds = (0.0..90.0).contains(contact_angle);
                let problem = format!("{contact_angle} is not in 0..90 degrees (90 excluded)");
                self.require(holds, format!("{path}.contact_angle"), problem);
            }
        }
    }

    /// Checks stiffnesses, strengths and factors of a bond.
    fn bond(&mut self, path: &str, bond: &BondSpec) {
        self.positive(format!("{path}.normal_stiffness"), bond.normal_stiffness, " (Pa/m)");
        self.positive(format!("{path}.shear_stiffness"), bond.shear_stiffness, " (Pa/m)");
        self.positive(format!("{path}.radius_factor"), bond.radius_factor, "");
        self.in_range(format!("{path}.moment_factor"), bond.moment_factor, 0.0, 1.0);
        self.in_range(format!("{path}.scatter"), bond.scatter, 0.0, 1.0);
        self.not_negative(format!("{path}.gap"), bond.gap, "");
        for (key, value) in [("tensile_strength", bond.tensile_strength), ("cohesion", bond.cohesion)] {
            if let Some(value) = value {
                self.not_negative(format!("{path}.{key}"), value, " (Pa)");
            }
        }
        let angle = bond.friction_angle;
        let problem = format!("{angle} is not in 0..90 degrees (90 excluded)");
        self.require((0.0..90.0).contains(&angle), format!("{path}.friction_angle"), problem);
    }

    /// Checks all contact laws of a pair of materials.
    fn pair(&mut self, path: &str, pair: &PairSpec) {
        self.normal(&format!("{path}.normal"), &pair.normal);
        self.tangential(&format!("{path}.tangential"), &pair.tangential);
        if let Some(friction) = &pair.friction {
            self.friction(&format!("{path}.friction"), friction);
        }
        for (key, spec) in [("rolling", &pair.rolling), ("twisting", &pair.twisting)] {
            if let Some(spec) = spec {
                self.rolling(&format!("{path}.{key}"), spec);
            }
        }
        if let Some(adhesion) = &pair.adhesion {
            self.adhesion(&format!("{path}.adhesion"), adhesion, &pair.normal);
        }
        if let Some(bond) = &pair.bond {
            self.bond(&format!("{path}.bond"), bond);
        }
    }

    /// Requires a fraction between 0 and 1, bounds excluded.
    fn fraction(&mut self, path: String, fraction: f64) {
        let problem = format!("{fraction} is not in 0..1 (both excluded)");
        self.require(fraction > 0.0 && fraction < 1.0, path, problem);
    }

    /// Checks the options of the filling of a body with grains.
    fn fill(&mut self, path: &str, fill: &super::Fill) {
        match fill {
            super::Fill::Single | super::Fill::DropAndRoll => {}
            super::Fill::Sleeve { columns } => {
                let problem = format!("{columns} is less than three grains around a sleeve");
                self.require(*columns >= 3, format!("{path}.columns"), problem);
            }
            super::Fill::Layers { solid_fraction, layers, first_solid_fraction } => {
                self.fraction(format!("{path}.solid_fraction"), *solid_fraction);
                self.fraction(format!("{path}.first_solid_fraction"), *first_solid_fraction);
                let problem =
                    format!("{first_solid_fraction} must not be above solid_fraction, {solid_fraction}");
                let looser = first_solid_fraction <= solid_fraction;
                self.require(looser, format!("{path}.first_solid_fraction"), problem);
                let problem = format!("{layers} is not in 1..=100");
                self.require((1..=100).contains(layers), format!("{path}.layers"), problem);
            }
            super::Fill::Lattice { pitch, jitter, .. } => {
                if let Some(pitch) = pitch {
                    self.positive(format!("{path}.pitch"), *pitch, " (m)");
                }
                self.in_range(format!("{path}.jitter"), *jitter, 0.0, 0.5);
            }
            super::Fill::Random { solid_fraction } => {
                self.fraction(format!("{path}.solid_fraction"), *solid_fraction);
            }
        }
    }

    /// Checks pressure and number of grains of a membrane.
    fn membrane(&mut self, path: &str, membrane: &super::Membrane, dimension: usize) {
        self.not_negative(
            format!("{path}.pressure"),
            membrane.pressure,
            if dimension == 2 { " (N/m)" } else { " (Pa)" },
        );
        let smallest = if membrane.closed { 3 } else { 2 };
        let (columns, problem) = match membrane.columns {
            None => (
                dimension == 2,
                CaseErrorKind::coded(
                    "needs-other-key",
                    "is missing: give the number of grains in a row of the membrane",
                ),
            ),
            Some(_) if dimension == 2 => (
                false,
                CaseErrorKind::coded("conflicting-keys", "a membrane in the plane is one row: leave it out"),
            ),
            Some(columns) => (
                columns >= smallest,
                CaseErrorKind::coded(
                    "needs-other-key",
                    "a row needs at least two grains, or three if it is closed",
                ),
            ),
        };
        self.require(columns, format!("{path}.columns"), problem);
        let problem =
            CaseErrorKind::coded("conflicting-keys", "a membrane in the plane is one row: leave it out");
        self.require(dimension == 3 || !membrane.closed, format!("{path}.closed"), problem);
    }

    /// Checks the options of a stage, with the contact laws that it changes.
    fn stage(&mut self, path: &str, stage: &super::GrainStage, dimension: usize) {
        for (number, pair) in stage.pairs.iter().enumerate() {
            let path = format!("{path}.pairs[{number}]");
            if let Some(law) = &pair.normal {
                self.normal(&format!("{path}.normal"), law);
            }
            if let Some(spec) = &pair.tangential {
                self.tangential(&format!("{path}.tangential"), spec);
            }
            if let Some(friction) = &pair.friction {
                self.friction(&format!("{path}.friction"), friction);
            }
            if let Some(rolling) = &pair.rolling {
                self.rolling(&format!("{path}.rolling"), rolling);
            }
        }
        let mut vector = |key: String, vector: &[f64], unit: &str| {
            let fits = vector.len() == dimension && vector.iter().all(|c| c.is_finite());
            let problem = format!("must be {dimension} finite numbers ({unit})");
            self.require(fits, format!("{path}.{key}"), CaseErrorKind::coded("wrong-dimension", problem));
        };
        if let Some(gravity) = &stage.gravity {
            vector("gravity".to_owned(), gravity, "m/s²");
        }
        stage.forces.iter().for_each(|(body, force)| vector(format!("forces.{body}"), force, "N"));
        if let Some(shaking) = &stage.shaking {
            vector("shaking.acceleration".to_owned(), &shaking.acceleration, "m/s²");
            for (key, value) in
                [("frequency", Some(shaking.frequency)), ("last_frequency", shaking.last_frequency)]
            {
                self.not_negative(format!("{path}.shaking.{key}"), value.unwrap_or(0.0), " (Hz)");
            }
        }
        for (body, membrane) in &stage.membranes {
            self.membrane(&format!("{path}.membranes.{body}"), membrane, dimension);
        }
        self.not_negative(format!("{path}.agitation"), stage.agitation, " (m/s)");
        let finite = CaseErrorKind::coded("not-finite", "must be finite (1/s)");
        self.require(stage.growth.is_finite(), format!("{path}.growth"), finite);
        for (name, press) in &stage.walls {
            let path = format!("{path}.walls.{name}");
            let pushes = press.stress.is_finite() && press.stress < 0.0;
            let problem = format!(
                "{} must be finite and negative (Pa): grains can push a wall but not pull it",
                press.stress
            );
            self.require(pushes, format!("{path}.stress"), CaseErrorKind::coded("out-of-range", problem));
            self.positive(format!("{path}.speed"), press.speed, " (m/s)");
            self.positive(format!("{path}.area"), press.area.unwrap_or(1.0), " (m²)");
            let problem = "is given together with area: leave one of them out";
            let (one, twice) = (
                press.area.is_none() || press.sleeve.is_none(),
                CaseErrorKind::coded("conflicting-keys", problem),
            );
            self.require(one, format!("{path}.sleeve"), twice);
            let stable = press.gain > 0.0 && press.gain <= 0.1;
            let problem = format!("{} is not in 0..=0.1 (0 excluded): the wall would oscillate", press.gain);
            self.require(stable, format!("{path}.gain"), problem);
        }
    }
}

impl DemOptions {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first violated rule.
    pub fn validate(&self, dimension: usize) -> Result<(), BrokenRule> {
        let mut rules = RuleChecker { first: None };
        self.grain_rules(&mut rules, dimension);
        for (number, pair) in self.pairs.iter().enumerate() {
            rules.pair(&format!("pairs[{number}]"), pair);
            let flat = dimension == 2 && pair.twisting.is_some();
            let problem = "disks have no twisting: leave it out, or use space 3d";
            rules.require(
                !flat,
                format!("pairs[{number}].twisting"),
                CaseErrorKind::coded("conflicting-keys", problem),
            );
        }
        for (name, stage) in &self.stages {
            rules.stage(&format!("stages.{name}"), stage, dimension);
        }
        for (name, region) in &self.regions {
            rules.positive(format!("regions.{name}.radius"), region.radius, " (m)");
            let fits = region.centre.len() == dimension && region.centre.iter().all(|x| x.is_finite());
            let problem =
                CaseErrorKind::coded("wrong-dimension", format!("must be {dimension} finite numbers"));
            rules.require(fits, format!("regions.{name}.centre"), problem);
        }
        rules.in_range("skin", self.skin, 0.01, 2.0);
        rules.require(
            self.step_fraction > 0.0 && self.step_fraction <= 0.12,
            "step_fraction",
            format!("{} is not in 0..=0.12 (0 excluded)", self.step_fraction),
        );
        if let Some(step) = self.time_step {
            rules.positive("time_step", step, " (s)");
        }
        rules.require(
            !self.voronoi || dimension == 2,
            "voronoi",
            CaseErrorKind::coded("needs-other-key", "is available only for disks in plane-strain"),
        );
        rules.in_range("coarse_graining", self.coarse_graining, 0.5, 20.0);
        rules.in_range("initial_overlap", self.initial_overlap, 0.0, 0.3);
        rules.first.map_or(Ok(()), Err)
    }

    /// Checks the kinds of grains and the bodies that they fill.
    fn grain_rules(&self, rules: &mut RuleChecker, dimension: usize) {
        for (name, kind) in &self.grains {
            let path = format!("grains.{name}");
            rules.positive(format!("{path}.density"), kind.density, " (kg/m³)");
            if let Some((key, problem)) = kind.diameter.as_ref().and_then(super::Diameters::problem) {
                rules.require(false, format!("{path}.diameter.{key}"), problem);
            }
            if let Some(fill) = &kind.fill {
                rules.fill(&format!("{path}.fill"), fill);
            }
        }
        rules.require(!self.grains.is_empty(), "grains", "at least one kind is needed");
        for (name, body) in &self.bodies {
            let path = format!("bodies.{name}");
            if let Some(fill) = &body.fill {
                rules.fill(&format!("{path}.fill"), fill);
            }
            let count = if dimension == 2 { 1 } else { 3 };
            let fits = body.spin.is_empty() || body.spin.len() == count;
            let problem = format!("has {} entries, {count} needed", body.spin.len());
            rules.require(fits, format!("{path}.spin"), problem);
            if let Some(rain) = &body.pluviation {
                let path = format!("{path}.rain");
                rules.positive(format!("{path}.rate"), rain.rate, " (kg/s)");
                rules.not_negative(format!("{path}.start"), rain.start, " (s)");
                let problem = format!("must come after the start, {} s", rain.start);
                let ends = rain.end.is_none_or(|end| end.is_finite() && end > rain.start);
                rules.require(ends, format!("{path}.end"), problem);
                rules.require(
                    !body.held,
                    path.clone(),
                    CaseErrorKind::coded("conflicting-keys", "held grains cannot enter: leave held out"),
                );
                let problem = "a body with rain is empty at the start, and its grains enter one by one: \
                               leave fill out";
                rules.require(body.fill.is_none(), format!("bodies.{name}.fill"), problem);
            }
            let finite = body.spin.iter().all(|spin| spin.is_finite());
            rules.require(
                finite,
                format!("{path}.spin"),
                CaseErrorKind::coded("out-of-range", "must be finite (rad/s)"),
            );
        }
    }
}
