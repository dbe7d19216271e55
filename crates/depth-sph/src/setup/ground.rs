//! What a flow moves over: the wall below it, or an obstacle above that.

use std::any::Any;
use std::sync::Arc;

use colluvium_case::description::{Boundary, Obstacle, ObstacleShape, ObstacleWall, Side, Space, Wall};
use colluvium_case::{Case, CaseError};
use colluvium_points::{Raster, Terrain};

use crate::bed::{Bed, BedPoint, Surface};
use crate::config::DepthOptions;
use crate::maps::Grid;

/// Fewest nodes of a raster along an axis (sheet: depth-sph §7).
const FEWEST_NODES: usize = 4;

/// How the bed holds what flows over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hold {
    /// Not at all.
    Smooth,
    /// By the friction of the material.
    Rough,
    /// By this coefficient at most.
    Frictional(f64),
}

/// The bed of a case.
pub struct Ground<const D: usize> {
    /// Its surface.
    pub bed: Bed<D>,
    /// The cells of its raster, where it is one.
    pub grid: Option<Grid>,
}

/// The bed of `case`: the obstacle there is, or the highest wall that faces upward.
pub fn ground<const D: usize>(case: &Case, options: &DepthOptions) -> Result<Ground<D>, CaseError> {
    let floor = floor(case);
    let Some(obstacle) = case.obstacles.first() else {
        let Some((_, level, _)) = floor else {
            let side = lowest(case);
            let problem = format!(
                "there is no bed to flow over: add a wall on the side {side}, or terrain as an obstacle"
            );
            return Err(CaseError::new("boundaries", problem));
        };
        return Ok(Ground { bed: Bed::Flat(level), grid: None });
    };
    if case.obstacles.len() > 1 {
        let problem = format!(
            "depth-sph has one bed, and {:?} is it: join both in one raster, or take another method",
            obstacle.name
        );
        return Err(CaseError::new("obstacles[1]", problem));
    }
    if let Some(axis) = (0..D).find(|axis| case.gravity[*axis] != 0.0) {
        let problem = "must be 0 over an obstacle: its slopes are measured against gravity";
        return Err(CaseError::new(format!("gravity[{axis}]"), problem));
    }
    let (bed, least, grid) = surface::<D>(case, options)?;
    if let Some((number, level, _)) = floor.filter(|(_, level, _)| *level > least) {
        let problem = format!(
            "the wall at {level} m stands above the lowest place of the obstacle {:?}, {least} m, and depth-sph has one bed: \
             leave it out or lower it",
            obstacle.name
        );
        return Err(CaseError::new(format!("boundaries[{number}]"), problem));
    }
    Ok(Ground { bed, grid })
}

/// How the bed of `case` holds, without making it; `None` where there is no bed.
pub fn hold(case: &Case) -> Option<Hold> {
    let obstacle = case.obstacles.first().map(of_obstacle);
    obstacle.or_else(|| floor(case).map(|(_, _, wall)| of_wall(wall)))
}

/// The side that the bed is on.
pub fn lowest(case: &Case) -> Side {
    if case.space == Space::PlaneStrain { Side::YMin } else { Side::ZMin }
}

/// The highest wall that faces upward: its number, its level (m), and how it acts.
fn floor(case: &Case) -> Option<(usize, f64, &Wall)> {
    let side = lowest(case);
    let level = |boundary: &Boundary| boundary.position(&case.domain);
    let walls = case.boundaries.iter().enumerate().filter(|(_, boundary)| boundary.side == side);
    let highest = walls.max_by(|a, b| level(a.1).total_cmp(&level(b.1)));
    highest.map(|(number, boundary)| (number, level(boundary), &boundary.wall))
}

fn of_wall(wall: &Wall) -> Hold {
    match wall {
        Wall::Smooth => Hold::Smooth,
        Wall::Frictional { friction_coefficient, .. } => Hold::Frictional(*friction_coefficient),
        _ => Hold::Rough,
    }
}

fn of_obstacle(obstacle: &Obstacle) -> Hold {
    match obstacle.wall {
        ObstacleWall::Smooth => Hold::Smooth,
        ObstacleWall::Rough => Hold::Rough,
        ObstacleWall::Frictional { friction_coefficient, .. } => Hold::Frictional(friction_coefficient),
    }
}

/// A bed, its lowest level over the domain (m), and the cells of its raster.
type Laid<const D: usize> = (Bed<D>, f64, Option<Grid>);

/// The surface of the only obstacle.
fn surface<const D: usize>(case: &Case, options: &DepthOptions) -> Result<Laid<D>, CaseError> {
    let shape = &case.obstacles[0].shape;
    let path = "obstacles[0].shape";
    match shape {
        ObstacleShape::Plane { point, normal } => plane(case, point, normal),
        ObstacleShape::Raster { file, .. } => {
            let raster = case.heights(0)?.filter(|_| D == 2);
            let raster =
                raster.ok_or_else(|| CaseError::new(path, "a raster is the bed of a space of 3d"))?;
            terrain(raster, options)
                .map_err(|problem| CaseError::new(format!("{path}.file"), format!("{file}: {problem}")))
        }
        _ => {
            let problem =
                "depth-sph flows over a plane or a raster: turn the shape into one, or take another method";
            Err(CaseError::new(path, problem))
        }
    }
}

fn plane<const D: usize>(case: &Case, point: &[f64], normal: &[f64]) -> Result<Laid<D>, CaseError> {
    if !(normal[D] > 0.0) {
        let problem = format!("{} must be positive: a bed faces upward", normal[D]);
        return Err(CaseError::new(format!("obstacles[0].shape.normal[{D}]"), problem));
    }
    let slope: [f64; D] = std::array::from_fn(|c| -normal[c] / normal[D]);
    let foot = point[D] - (0..D).map(|c| slope[c] * point[c]).sum::<f64>();
    let level = move |x: &[f64; D]| foot + (0..D).map(|c| slope[c] * x[c]).sum::<f64>();
    let corner =
        std::array::from_fn(|c| if slope[c] > 0.0 { case.domain.min[c] } else { case.domain.max[c] });
    let bed = Bed::formula(move |x: &[f64; D]| BedPoint { slope, ..BedPoint::flat(level(x)) });
    Ok((bed, level(&corner), None))
}

fn terrain<const D: usize>(raster: Raster, options: &DepthOptions) -> Result<Laid<D>, String> {
    let (columns, rows) = (raster.columns, raster.rows);
    if columns < FEWEST_NODES || rows < FEWEST_NODES {
        return Err(format!(
            "{columns} columns and {rows} rows are too few: a bed needs {FEWEST_NODES} of each"
        ));
    }
    let least = raster.values.iter().copied().filter(|z| z.is_finite()).fold(f64::INFINITY, f64::min);
    let Raster { origin, spacing, ref reference, .. } = raster;
    let grid = Grid { counts: [columns, rows], origin, spacing, reference: reference.clone() };
    let terrain = Terrain::new(raster, options.terrain_smoothing).map_err(|error| error.to_string())?;
    let surface: Arc<dyn Surface<2>> = Arc::new(terrain);
    let same = (&surface as &dyn Any).downcast_ref::<Arc<dyn Surface<D>>>();
    let surface = same.ok_or("a raster is the bed of a plan of two coordinates")?;
    Ok((Bed::Surface(Arc::clone(surface)), least, Some(grid)))
}
