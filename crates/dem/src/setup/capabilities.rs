//! Capabilities of DEM: features of a case that are supported or rejected, by path.

use colluvium_case::{Capabilities, Case, CaseError, CaseErrorKind, Feature, RequiredInput};
use colluvium_points::Shape;
use serde_json::Value;

use crate::config::{CellControl, DemOptions, PairSpec};

/// Message for an adhesion that the case gives for an obstacle.
const ADHESION: &str = "the adhesion is given in the pair of the grains and the obstacle: leave it out";
/// Message for the sampling of a body.
const PACKING: &str = "is ignored, because grains fill a body by a packing of their own";
/// Message for a space other than plane strain and 3D.
const SPACES: &str = "dem has disks and spheres: use plane-strain or 3d";

/// Rejects clumps of grains, by their key.
pub fn reject_clumps(options: &Value) -> Result<(), CaseError> {
    let named = |own: &Value| {
        let mut keys = own.as_object().into_iter().flatten().map(|(key, _)| key.clone());
        keys.find(|key| key.starts_with("clump"))
    };
    let kinds = options.get("grains").and_then(Value::as_object).into_iter().flatten();
    let of_kind = |(kind, own): (&String, &Value)| Some(format!("grains.{kind}.{}", named(own)?));
    match named(options).or_else(|| kinds.filter_map(of_kind).next()) {
        None => Ok(()),
        Some(key) => {
            let problem = "dem has disks and spheres, but no clumps: for grains that are not round, give \
                           their pair `rolling`";
            Err(CaseError::new(format!("methods.dem.{key}"), problem))
        }
    }
}

/// Features that DEM supports in addition to those of all point methods.
const SUPPORTED: &[Feature] = &[
    Feature::DomainOrigin,
    Feature::Boundaries,
    Feature::BoundariesName,
    Feature::BoundariesPosition,
    Feature::BoundariesSeparation,
    Feature::BoundariesVelocity,
    Feature::BoundariesWallRough,
    Feature::BoundariesWallSmooth,
    Feature::BoundariesWallFrictional,
    Feature::Obstacles,
    Feature::ObstaclesWallRough,
    Feature::ObstaclesWallSmooth,
    Feature::ObstaclesWallFrictional,
    Feature::ObstaclesSeparation,
    Feature::MeasuresReaction,
    Feature::MeasuresImpactPressure,
    Feature::StagesDamping,
    Feature::StagesRayleighDamping,
    Feature::MeasuresDissipation,
    Feature::OutputContacts,
];

/// Features that DEM supports with all their variants and keys, in addition to those of all point methods.
const SUPPORTED_WHOLLY: &[Feature] = &[
    Feature::DomainPeriodic,
    Feature::BoundariesSide,
    Feature::ObstaclesShape,
    Feature::ObstaclesMotion,
    Feature::ObstaclesRegions,
    Feature::StagesExcavate,
];

/// Capabilities of DEM for the features of a case.
pub fn capabilities() -> Capabilities {
    Capabilities::for_point_methods("dem")
        .supports(SUPPORTED)
        .supports_all_of(SUPPORTED_WHOLLY)
        .requires(RequiredInput { materials: false, ..RequiredInput::default() })
        .rejects(Feature::SpaceOneD, SPACES)
        .rejects(Feature::SpaceAxisymmetric, SPACES)
        .rejects(
            Feature::BodiesRigid,
            "dem has no rigid bodies: for a prescribed velocity, set `held` in methods.dem.bodies; for a \
             force, bond the grains and give `forces` in methods.dem.stages",
        )
        .rejects(Feature::BodiesRemoveOutside, "dem cannot remove grains that leave the domain")
        .rejects(Feature::BodiesPoreFluid, "dem has no pore fluid")
        .rejects_all_of(
            Feature::BodiesStress,
            "grains have no initial stress: let the body reach equilibrium under its weight in a first stage",
        )
        .supports(&[Feature::BodiesStressNone])
        .rejects(Feature::BoundariesGroup, "dem has no mesh with groups of nodes")
        .rejects(Feature::BoundariesWallAbsorbing, "dem has no absorbing boundaries")
        .rejects(Feature::BoundariesWallBilateral, "grains can always separate from the walls of dem")
        .rejects(Feature::ObstaclesWallAdhesion, ADHESION)
        .rejects(Feature::ObstaclesRegionsWallAdhesion, ADHESION)
        .rejects(Feature::MeasuresAbout, "dem computes the force on an obstacle, but not its moment")
        .ignores_all_of_with_warning(Feature::BodiesSampling, PACKING)
        .ignores_with_warning(Feature::BodiesSamplingSeed, PACKING)
        .rejects(Feature::BodiesShapeRowsTerrain, "grains fill a layer by a packing of their own")
        .rejects(
            Feature::Loads,
            "dem cannot apply tractions: use a wall, or a periodic cell that follows a stress",
        )
        .rejects(Feature::Patches, "dem cannot prescribe the motion of patches")
        .rejects_all_of(
            Feature::StagesWeakening,
            "grains have no material to weaken: change the pairs of the stage",
        )
        .rejects(Feature::MeasuresFactorOfSafety, "grains have no material with a strength to reduce")
}

/// Rejects combinations of the case and the options that are not supported, by path.
pub(super) fn check_supported(case: &Case, options: &DemOptions) -> Result<(), CaseError> {
    names(case, options)?;
    check_pluviation(case, options)?;
    cells(case, options)?;
    check_regions(case, options)?;
    crate::setup::stress_checks::check_stresses(case, options)
}

/// Checks that the measuring regions are in the domain.
fn check_regions(case: &Case, options: &DemOptions) -> Result<(), CaseError> {
    for (name, region) in &options.regions {
        let ball =
            case.relative_to_origin(Shape::Ball { centre: region.centre.clone(), radius: region.radius });
        let (mut low, mut high) = ball.bounds(case.dimension());
        for c in (0..case.dimension()).filter(|c| case.domain.is_periodic(*c)) {
            // The region includes images of grains.
            (low[c], high[c]) = (case.domain.min[c], case.domain.max[c]);
        }
        if let Some(problem) = case.outside_domain_problem(&low, &high) {
            return Err(CaseError::new(format!("methods.dem.regions.{name}"), problem));
        }
    }
    Ok(())
}

/// Checks that sources of grains have sizes, and are neither bodies of points nor rigid.
fn check_pluviation(case: &Case, options: &DemOptions) -> Result<(), CaseError> {
    for (number, body) in case.bodies.iter().enumerate() {
        if options.bodies.get(&body.name).is_none_or(|own| own.pluviation.is_none()) {
            continue;
        }
        if options.grains[&body.material].diameter.is_none() {
            let problem = format!("is missing: grains rain into the body {:?}", body.name);
            return Err(CaseError::new(
                format!("methods.dem.grains.{}.diameter", body.material),
                CaseErrorKind::coded("needs-other-key", problem),
            ));
        }
        let path = format!("methods.dem.bodies.{}.rain", body.name);
        if body.points.is_some() {
            return Err(CaseError::new(
                path,
                format!("bodies[{number}] has points: grains enter at random positions"),
            ));
        }
        if body.rigid {
            return Err(CaseError::new(
                path,
                CaseErrorKind::coded(
                    "rigid-motion",
                    format!("bodies[{number}] is rigid: its grains cannot enter one by one"),
                ),
            ));
        }
    }
    Ok(())
}

/// Returns the error of an unknown name.
fn missing(path: String, name: &str, known: &[&str], what: &str) -> Result<(), CaseError> {
    Err(CaseError::new(path, CaseErrorKind::unknown_name(name, known, what)))
}

/// Names allowed in a pair.
struct PairNames<'a> {
    /// Kinds of grains, and walls.
    names: &'a [&'a str],
    walls: &'a [&'a str],
}

impl PairNames<'_> {
    /// Checks the two names of a pair.
    fn pair(&self, path: &str, between: &[String; 2]) -> Result<(), CaseError> {
        for (side, name) in between.iter().enumerate() {
            if !self.names.contains(&name.as_str()) {
                let path = format!("{path}.between[{side}]");
                return missing(path, name, self.names, "a kind of grains or a wall");
            }
        }
        if between.iter().all(|name| self.walls.contains(&name.as_str())) {
            return Err(CaseError::new(format!("{path}.between"), "names two walls"));
        }
        Ok(())
    }

    /// Checks an entry of the pair options, which must not repeat an earlier pair.
    fn options(&self, pairs: &[PairSpec], number: usize) -> Result<(), CaseError> {
        let (path, pair) = (format!("methods.dem.pairs[{number}]"), &pairs[number]);
        self.pair(&path, &pair.between)?;
        let wall = pair.between.iter().any(|name| self.walls.contains(&name.as_str()));
        if wall && pair.friction.is_some() {
            let problem = "the friction of a wall is given in boundaries: leave it out";
            return Err(CaseError::new(
                format!("{path}.friction"),
                CaseErrorKind::coded("conflicting-keys", problem),
            ));
        }
        if wall && pair.bond.is_some() {
            let problem = "grains cannot be bonded to walls: bond them to held grains";
            return Err(CaseError::new(format!("{path}.bond"), problem));
        }
        let [a, b] = &pair.between;
        let alike = |other: &[String; 2]| other == &pair.between || (&other[0] == b && &other[1] == a);
        if pairs[..number].iter().any(|other| alike(&other.between)) {
            return Err(CaseError::new(
                format!("{path}.between"),
                CaseErrorKind::coded("duplicate-name", "is given twice"),
            ));
        }
        Ok(())
    }
}

/// Checks the names of kinds, walls, stages and pairs.
fn names(case: &Case, options: &DemOptions) -> Result<(), CaseError> {
    let kinds: Vec<&str> = options.grains.keys().map(String::as_str).collect();
    let mut walls: Vec<&str> =
        case.boundaries.iter().map(colluvium_case::description::Boundary::name).collect();
    walls.extend(case.obstacles.iter().map(|obstacle| obstacle.name.as_str()));
    for (number, body) in case.bodies.iter().enumerate() {
        if !kinds.contains(&body.material.as_str()) {
            let path = format!("bodies[{number}].material");
            return missing(path, &body.material, &kinds, "a kind of methods.dem.grains");
        }
    }
    if let Some(name) = walls.iter().find(|name| kinds.contains(name)) {
        let problem = CaseErrorKind::coded("duplicate-name", format!("{name:?} is also the name of a wall"));
        return Err(CaseError::new(format!("methods.dem.grains.{name}"), problem));
    }
    let all: Vec<&str> = kinds.iter().chain(&walls).copied().collect();
    let all: PairNames<'_> = PairNames { names: &all, walls: &walls };
    for number in 0..options.pairs.len() {
        all.options(&options.pairs, number)?;
    }
    let stages: Vec<&str> = case.stages.iter().map(|stage| stage.name.as_str()).collect();
    for (name, stage) in &options.stages {
        if !stages.contains(&name.as_str()) {
            return missing(format!("methods.dem.stages.{name}"), name, &stages, "the name of a stage");
        }
        for (number, pair) in stage.pairs.iter().enumerate() {
            all.pair(&format!("methods.dem.stages.{name}.pairs[{number}]"), &pair.between)?;
        }
        let sides = &walls[..case.boundaries.len()];
        if let Some(wall) = stage.walls.keys().find(|wall| !sides.contains(&wall.as_str())) {
            let path = format!("methods.dem.stages.{name}.walls.{wall}");
            return match no_servo_reason(case, &kinds, name, wall) {
                Some(problem) => Err(CaseError::new(path, problem)),
                None => missing(path, wall, sides, "the name of one of the boundaries"),
            };
        }
    }
    bodies(case, options)
}

/// Reason for which a name other than that of a wall cannot be stress-controlled, with the alternative; `None` for an unknown name.
fn no_servo_reason(case: &Case, kinds: &[&str], stage: &str, name: &str) -> Option<String> {
    if case.obstacles.iter().any(|obstacle| obstacle.name == name) {
        return Some(no_stress_control_message(stage));
    }
    let grains = kinds.contains(&name) || case.bodies.iter().any(|body| body.name == name);
    let force = bonded_stage_message(stage);
    grains.then(|| format!("grains cannot have a prescribed stress: use a wall of boundaries; {force}"))
}

/// Message for a force on bonded grains, with the option to use in a stage.
fn bonded_stage_message(stage: &str) -> String {
    format!("to apply a force to bonded grains that are not held, use methods.dem.stages.{stage}.forces")
}

/// Message on alternatives to stress or force control of an obstacle.
fn no_stress_control_message(stage: &str) -> String {
    format!(
        "an obstacle has a prescribed `motion`, and cannot have a prescribed stress or force: for a \
         stress, use a wall of boundaries and methods.dem.stages.{stage}.walls; {}",
        bonded_stage_message(stage)
    )
}

/// Checks the names of bodies, and that forces act only on grains that are free.
fn bodies(case: &Case, options: &DemOptions) -> Result<(), CaseError> {
    let bodies: Vec<&str> = case.bodies.iter().map(|body| body.name.as_str()).collect();
    let known = |path: String, name: &str| match bodies.contains(&name) {
        true => Ok(()),
        false => missing(path, name, &bodies, "the name of a body"),
    };
    for name in options.bodies.keys() {
        known(format!("methods.dem.bodies.{name}"), name)?;
    }
    let held = |name: &str| {
        let rigid = case.bodies.iter().any(|body| body.name == name && body.rigid);
        rigid || options.bodies.get(name).is_some_and(|own| own.held)
    };
    for (stage, own) in &options.stages {
        let path = format!("methods.dem.stages.{stage}");
        let number = case.stages.iter().position(|other| other.name == *stage).unwrap_or(0);
        let there = |path: &str, name: &str| match case.is_removed(name, number) {
            true => Err(CaseError::new(path, format!("the body {name:?} has been removed"))),
            false => Ok(()),
        };
        let pushed = own.forces.keys().map(|name| (format!("{path}.forces.{name}"), name));
        let pressed = own.membranes.keys().map(|name| (format!("{path}.membranes.{name}"), name));
        for (path, name) in pushed.chain(pressed) {
            if case.obstacles.iter().any(|obstacle| obstacle.name == *name) {
                return Err(CaseError::new(path, no_stress_control_message(stage)));
            }
            known(path.clone(), name)?;
            there(&path, name)?;
            if held(name) {
                return Err(CaseError::new(
                    path,
                    CaseErrorKind::coded(
                        "conflicting-keys",
                        "its grains are held, so that a force cannot move them: leave held out, and bond them \
                     to each other",
                    ),
                ));
            }
        }
        for (name, membrane) in &own.membranes {
            let path = format!("{path}.membranes.{name}.against");
            known(path.clone(), &membrane.against)?;
            there(&path, &membrane.against)?;
            if membrane.against == *name {
                return Err(CaseError::new(path, "must be another body than the membrane"));
            }
        }
    }
    Ok(())
}

/// Checks that deforming cells are periodic along the axes of the deformation.
fn cells(case: &Case, options: &DemOptions) -> Result<(), CaseError> {
    for (name, stage) in &options.stages {
        let path = format!("methods.dem.stages.{name}");
        if stage.grow_until.is_some() && case.domain.periodic.len() < case.dimension() {
            let problem = "is available only if the domain is periodic along all axes";
            return Err(CaseError::new(
                format!("{path}.grow_until"),
                CaseErrorKind::coded("needs-other-key", problem),
            ));
        }
        let Some(CellControl { xx, yy, zz, xy, yz, xz, damping }) = stage.cell else { continue };
        let flat = case.dimension() == 2;
        for (key, on, axes) in [
            ("xx", xx, [0, 0]),
            ("yy", yy, [1, 1]),
            ("zz", zz, [2, 2]),
            ("xy", xy, [0, 1]),
            ("yz", yz, [1, 2]),
            ("xz", xz, [0, 2]),
        ] {
            let Some(on) = on else { continue };
            if let Some(problem) = on.validation_error() {
                return Err(CaseError::new(format!("{path}.cell.{key}"), problem));
            }
            if flat && axes.contains(&2) {
                return Err(CaseError::new(
                    format!("{path}.cell.{key}"),
                    CaseErrorKind::coded("wrong-dimension", "the plane has no z axis"),
                ));
            }
            if axes.iter().any(|axis| !case.domain.is_periodic(*axis)) {
                let problem = "the domain is not periodic along its axes, and cannot deform";
                return Err(CaseError::new(format!("{path}.cell.{key}"), problem));
            }
        }
        if let Some(damping) = damping
            && !(damping.is_finite() && damping >= 0.0)
        {
            let problem =
                CaseErrorKind::coded("out-of-range", format!("{damping} must be finite and not negative"));
            return Err(CaseError::new(format!("{path}.cell.damping"), problem));
        }
    }
    Ok(())
}
