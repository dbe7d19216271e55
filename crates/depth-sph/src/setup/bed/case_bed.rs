//! Bed of a case: the highest faces of walls and obstacles that face upward.

use std::sync::Arc;

use colluvium_case::description::{Boundary, Obstacle, ObstacleShape, ObstacleWall, Side, Space, Wall};
use colluvium_case::{Case, CaseError};
use colluvium_points::Raster;

use crate::bed::{Bed, BedPoint, BedSurface, ErodibleBed, TerrainBed};
use crate::config::DepthOptions;
use crate::config::choices::TimeScheme;
use crate::output::hazard_rasters::PlanCells;
use crate::setup::bed::face_heights::highest_faces;
use crate::setup::bed::{dams, terrain_holes};
use colluvium_case::CaseErrorKind;
use colluvium_case::Warning;

/// Fewest nodes of a raster along an axis (sheet: depth-sph §7).
const FEWEST_NODES: usize = 4;

/// Slope angle above which there is a warning if half of a survey exceeds it (degrees; sheet: depth-sph §7).
const STEEPEST_TERRAIN: f64 = 48.0;
/// Number of nodes of a raster whose slopes are sampled.
const SAMPLE: usize = 1 << 18;
/// Slope angle of the faces of obstacles above which there is a warning (degrees).
const STEEPEST_FACE: f64 = 60.0;

/// Friction of the bed on the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BedFriction {
    /// No friction.
    Smooth,
    /// Friction of the material.
    Rough,
    /// Friction of the material, limited to this coefficient.
    Frictional(f64),
}

/// Bed of a case.
pub struct CaseBed<const D: usize> {
    /// Bed surface.
    pub bed: Bed<D>,
    /// Cells of the raster, if the bed is one.
    pub grid: Option<PlanCells>,
    /// Largest and root-mean-square difference of the bed surface from the levels of its raster (m).
    pub fit_errors: Option<[f64; 2]>,
    /// Warnings about the bed for the user.
    pub warnings: Vec<Warning>,
}

/// Bed of a case: its obstacles, and upward-facing walls where these are higher.
pub fn case_bed<const D: usize>(case: &Case, options: &DepthOptions) -> Result<CaseBed<D>, CaseError> {
    let floor = highest_wall(case);
    let Some(first) = case.obstacles.first() else {
        let Some((_, level, _)) = floor else {
            let side = lowest(case);
            let problem = format!(
                "there is no bed to flow over: add a wall on the side {side}, or terrain as an obstacle"
            );
            return Err(CaseError::new("boundaries", problem));
        };
        reject_erosion_of_plane(options)?;
        return Ok(CaseBed { bed: Bed::Flat(level), grid: None, fit_errors: None, warnings: Vec::new() });
    };
    if let Some(axis) = (0..D).find(|axis| case.gravity[*axis] != 0.0) {
        let problem = "must be 0 over an obstacle: gravity must be vertical over a bed with slopes";
        return Err(CaseError::new(format!("gravity[{axis}]"), problem));
    }
    check_same_walls(case, first)?;
    if let [Obstacle { shape: ObstacleShape::Plane { point, normal }, .. }] = &case.obstacles[..] {
        let (bed, smallest) = plane(case, point, normal)?;
        if let Some((number, level, _)) = floor.filter(|(_, level, _)| *level > smallest) {
            let problem = format!(
                "the wall at {level} m lies above the lowest point of the plane {:?}, {smallest} m: leave the \
                 wall out or lower it",
                first.name
            );
            let problem = CaseErrorKind::coded("conflicting-keys", problem);
            return Err(CaseError::new(format!("boundaries[{number}]"), problem));
        }
        reject_erosion_of_plane(options)?;
        return Ok(CaseBed { bed, grid: None, fit_errors: None, warnings: Vec::new() });
    }
    let (mut raster, path) = raster::<D>(case, options)?;
    raise_to_wall(case, first, floor, &mut raster)?;
    // Means reduce the noise of a survey; a dam keeps its crest.
    let given = raster;
    let mut raster = TerrainBed::smoothed(&given, options.terrain_smoothing);
    let means: Vec<f64> = given.values.iter().zip(&raster.values).map(|(z, mean)| z - mean).collect();
    let mut warnings = dams::raise_terrain(case, options, &mut raster)?;
    let on_map = path.ends_with("file");
    let wrong = |problem: String| CaseError::new(path.clone(), problem);
    let (columns, rows) = (raster.columns, raster.rows);
    if columns < FEWEST_NODES || rows < FEWEST_NODES {
        let problem =
            format!("{columns} columns and {rows} rows are too few: a bed needs {FEWEST_NODES} of each");
        return Err(wrong(problem));
    }
    let Raster { origin, spacing, ref reference, .. } = raster;
    let grid = PlanCells { counts: [columns, rows], origin, spacing, reference: reference.clone() };
    let ground = TerrainBed::new(raster).map_err(|error| wrong(error.to_string()))?;
    warnings.extend(terrain_warnings(case, &ground));
    warnings.extend(energy_warning(options));
    let fit_errors = Some(fit_errors(&ground, &means));
    let bed = if options.records_erosion() {
        Bed::Erodible(Box::new(ErodibleBed::new(ground, options.lower_bed)))
    } else {
        Bed::Surface(Arc::new(ground))
    };
    Ok(CaseBed { bed, grid: on_map.then_some(grid), fit_errors, warnings })
}

/// Largest and root-mean-square difference (m) of the bed surface from the levels of its raster before smoothing. `means` (m) are the
/// raster levels minus the smoothed ones.
fn fit_errors(ground: &TerrainBed, means: &[f64]) -> [f64; 2] {
    let raster = ground.raster();
    let off = |number: usize| {
        let bed: Option<BedPoint<2>> =
            ground.bed_point(&raster.node_position(number % raster.columns, number / raster.columns));
        Some(bed?.level - raster.values[number] - means[number]).filter(|off| off.is_finite())
    };
    let (mut largest, mut square, mut count) = (0.0f64, 0.0, 0.0);
    for off in (0..means.len()).filter_map(off) {
        (largest, square, count) = (largest.max(off.abs()), square + off * off, count + 1.0);
    }
    [largest, (square / f64::max(count, 1.0)).sqrt()]
}

/// Warns of time schemes that do not transport velocities along the bed.
fn energy_warning(options: &DepthOptions) -> Option<Warning> {
    (options.integration != TimeScheme::Leapfrog).then(|| {
        Warning::new("integration-loses-energy", "methods.depth-sph.integration: Runge-Kutta steps lose energy over rough ground: leave the option \
         out over surveyed terrain")
    })
}

/// Rejects obstacles whose walls differ.
fn check_same_walls(case: &Case, first: &Obstacle) -> Result<(), CaseError> {
    let other = case
        .obstacles
        .iter()
        .position(|obstacle| friction_of_obstacle(obstacle) != friction_of_obstacle(first));
    let Some(number) = other else { return Ok(()) };
    let problem = format!(
        "is not that of {:?}, but the bed has one kind of wall: give the parts of it that differ \
         in methods.depth-sph.regions",
        first.name
    );
    Err(CaseError::new(format!("obstacles[{number}].wall"), problem))
}

/// Rejects recorded erosion and dams on a plane bed, which has no raster nodes.
fn reject_erosion_of_plane(options: &DepthOptions) -> Result<(), CaseError> {
    if !options.dams.is_empty() {
        let problem = "the bed is a plane, whose heights cannot be raised: give the bed as a raster";
        return Err(crate::setup::option_error("dams", problem));
    }
    if !options.records_erosion() {
        return Ok(());
    }
    let key = match (options.lower_bed, &options.erodible_depth_raster) {
        (true, _) => "lower_bed",
        (false, Some(_)) => "erodible_depth_raster",
        (false, None) => "erodible_depth",
    };
    let problem = "the bed is a plane, whose heights cannot be lowered: give the bed as a raster";
    Err(crate::setup::option_error(key, problem))
}

/// Heights of the bed, and the key of the case from which they follow.
fn raster<const D: usize>(case: &Case, options: &DepthOptions) -> Result<(Raster, String), CaseError> {
    let is_raster = |obstacle: &Obstacle| matches!(obstacle.shape, ObstacleShape::Raster { .. });
    let spacing = options.terrain_spacing.unwrap_or(options.spacing);
    let Some(number) = case.obstacles.iter().position(is_raster).filter(|_| D == 2) else {
        return Ok((highest_faces::<D>(case, spacing, None)?, "obstacles".to_owned()));
    };
    let path = format!("obstacles[{number}].shape.file");
    let own = case
        .heights(number)?
        .ok_or_else(|| CaseError::new(path.clone(), CaseErrorKind::coded("no-data", "has no heights")))?;
    if case.obstacles.len() == 1 {
        return Ok((own, path));
    }
    Ok((highest_faces::<D>(case, spacing, Some((number, own)))?, path))
}

/// Warnings for terrain that is too steep, and for cells without data inside it.
fn terrain_warnings(case: &Case, ground: &TerrainBed) -> impl Iterator<Item = Warning> {
    too_steep(case, ground).into_iter().chain(terrain_holes::warning(case, ground.raster()))
}

/// Warning for steep faces that a flow may reach, and for terrain so steep everywhere that its levels are probably not in metres.
fn too_steep(case: &Case, ground: &TerrainBed) -> Option<Warning> {
    let raster = ground.raster();
    let place = |number: usize| raster.node_position(number % raster.columns, number / raster.columns);
    let slope = |number: usize| {
        let bed: Option<BedPoint<2>> = ground.bed_point(&place(number));
        bed.map_or(0.0, |bed| bed.slope[0].hypot(bed.slope[1]))
    };
    let of_file = matches!(&case.obstacles[..], [Obstacle { shape: ObstacleShape::Raster { .. }, .. }]);
    // The median of all slopes is that of a sample.
    let apart = if of_file { raster.values.len().div_ceil(SAMPLE) } else { 1 };
    let known = (0..raster.values.len()).step_by(apart).filter(|number| raster.values[*number].is_finite());
    let mut slopes: Vec<(f64, usize)> = known.map(|number| (slope(number), number)).collect();
    if slopes.is_empty() {
        return None;
    }
    if of_file {
        let middle = slopes.len() / 2;
        let angle = slopes.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0)).1.0.atan().to_degrees();
        return (angle > STEEPEST_TERRAIN).then(|| {
            Warning::new("doubtful-unit", format!(
                "obstacles: half of the raster is steeper than {angle:.1}°: check that its heights are in \
                 metres, like the distances of its nodes"
            ))
        });
    }
    let (steepest, number) = slopes.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let angle = steepest.atan().to_degrees();
    let place: Vec<f64> = (0..case.dimension() - 1).map(|c| place(number)[c] + case.origin()[c]).collect();
    (angle > STEEPEST_FACE).then(|| {
        Warning::new("steep-face", format!(
            "obstacles: the slope of the bed reaches {angle:.1}° at {place:?} m: a flow that reaches such \
             a face runs up along it and is not reflected as by a wall; give faces that must stop the flow \
             slopes below {STEEPEST_FACE}°"
        ))
    })
}

/// Raises a bed to the wall below where that is higher.
fn raise_to_wall(
    case: &Case,
    obstacle: &Obstacle,
    floor: Option<(usize, f64, &Wall)>,
    raster: &mut Raster,
) -> Result<(), CaseError> {
    let known = |raster: &Raster| {
        raster.values.iter().copied().filter(|z| z.is_finite()).fold(f64::INFINITY, f64::min)
    };
    let smallest = known(raster);
    let Some((number, level, wall)) = floor.filter(|(_, level, _)| *level > smallest) else { return Ok(()) };
    if wall_friction(wall) != friction_of_obstacle(obstacle) {
        let problem = format!(
            "is at {} m, above the lowest point of the obstacles, {} m, but differs from their wall: the \
             bed has one kind of wall",
            level + case.origin()[case.dimension() - 1],
            smallest + case.origin()[case.dimension() - 1]
        );
        return Err(CaseError::new(
            format!("boundaries[{number}].wall"),
            CaseErrorKind::coded("conflicting-keys", problem),
        ));
    }
    raster.values.iter_mut().filter(|z| z.is_finite()).for_each(|z| *z = z.max(level));
    Ok(())
}

/// Friction of the bed of a case; `None` without a bed.
pub fn bed_friction(case: &Case) -> Option<BedFriction> {
    let obstacle = case.obstacles.first().map(friction_of_obstacle);
    obstacle.or_else(|| highest_wall(case).map(|(_, _, wall)| wall_friction(wall)))
}

/// Whether the whole bed of a case is smooth, or there is no bed.
pub fn is_smooth(case: &Case) -> bool {
    let regions = case.obstacles.iter().flat_map(|obstacle| &obstacle.regions);
    let mut holds =
        bed_friction(case).into_iter().chain(regions.map(|region| obstacle_friction(region.wall)));
    holds.all(|hold| hold == BedFriction::Smooth)
}

/// Side of the domain at which the bed is.
pub fn lowest(case: &Case) -> Side {
    if case.space == Space::PlaneStrain { Side::YMin } else { Side::ZMin }
}

/// Highest wall that faces upward: its number, its level (m), and its kind.
pub fn highest_wall(case: &Case) -> Option<(usize, f64, &Wall)> {
    let side = lowest(case);
    let level = |boundary: &Boundary| boundary.wall_coordinate(&case.domain);
    let walls = case.boundaries.iter().enumerate().filter(|(_, boundary)| boundary.side == side);
    let highest = walls.max_by(|a, b| level(a.1).total_cmp(&level(b.1)));
    highest.map(|(number, boundary)| (number, level(boundary), &boundary.wall))
}

/// Bed friction of a wall of the case.
fn wall_friction(wall: &Wall) -> BedFriction {
    match wall {
        Wall::Smooth => BedFriction::Smooth,
        Wall::Frictional { friction_coefficient, .. } => BedFriction::Frictional(*friction_coefficient),
        _ => BedFriction::Rough,
    }
}

/// Bed friction of an obstacle of the case.
fn friction_of_obstacle(obstacle: &Obstacle) -> BedFriction {
    obstacle_friction(obstacle.wall)
}

/// Friction of a wall of an obstacle.
pub fn obstacle_friction(wall: ObstacleWall) -> BedFriction {
    match wall {
        ObstacleWall::Smooth => BedFriction::Smooth,
        ObstacleWall::Rough => BedFriction::Rough,
        ObstacleWall::Frictional { friction_coefficient, .. } => {
            BedFriction::Frictional(friction_coefficient)
        }
    }
}

/// Plane bed, and its lowest level over the domain (m).
fn plane<const D: usize>(case: &Case, point: &[f64], normal: &[f64]) -> Result<(Bed<D>, f64), CaseError> {
    if !(normal[D] > 0.0) {
        let problem = format!("{} must be positive: a bed faces upward", normal[D]);
        return Err(CaseError::new(format!("obstacles[0].shape.normal[{D}]"), problem));
    }
    let slope: [f64; D] = std::array::from_fn(|c| -normal[c] / normal[D]);
    let foot = point[D] - (0..D).map(|c| slope[c] * point[c]).sum::<f64>();
    let level = move |x: &[f64; D]| foot + (0..D).map(|c| slope[c] * x[c]).sum::<f64>();
    let corner =
        std::array::from_fn(|c| if slope[c] > 0.0 { case.domain.min[c] } else { case.domain.max[c] });
    let bed = Bed::formula(move |x: &[f64; D]| BedPoint { slope, ..BedPoint::horizontal(level(x)) });
    Ok((bed, level(&corner)))
}
