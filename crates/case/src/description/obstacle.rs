//! Obstacles: rigid geometry in contact with bodies.

use colluvium_points::Shape;
use colluvium_points::surface::RigidTransform;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Wall;

/// Rigid geometry in contact with bodies, at rest or moving, also beyond the domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// Obstacle name.
    pub name: String,
    /// Surface; the solid is behind it.
    pub shape: ObstacleShape,
    /// Action on material.
    pub wall: ObstacleWall,
    /// Whether material may separate from a rough or smooth obstacle; from frictional ones it may.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub separation: bool,
    /// Motion; at rest when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<ObstacleMotion>,
    /// Parts of the surface with own walls, in plan; the first of overlapping ones applies. Not for moving obstacles.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<ObstacleRegion>,
}

/// Part of an obstacle's surface, by a region in plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObstacleRegion {
    /// Region in plan: a box of one coordinate in 2D, any two-dimensional shape in 3D. Or give `outline` or `raster`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// Outline in plan (m), GeoJSON or shapefile, 3D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outline: Option<String>,
    /// Raster cells in plan, as of land cover, 3D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raster: Option<RasterCellSelection>,
    /// Action in the part.
    pub wall: ObstacleWall,
}

/// Raster cells in plan of a given value, each half a cell around its centre; none beyond the raster.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RasterCellSelection {
    /// ESRI ASCII grid or GeoTIFF.
    pub file: String,
    /// Cell value; any except no data when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
}

/// Prescribed motion: rotation about a line that moves with the velocity. None by default, for obstacles moved by a program.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObstacleMotion {
    /// Velocity (m/s); none when absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocity: Vec<f64>,
    /// Rotation rate (degrees per second): anticlockwise in 2D, right-handed about `axis` in 3D.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rotation: f64,
    /// Initial point on the line (m), with `rotation`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub centre: Vec<f64>,
    /// Line direction in 3D, of any length, with `rotation`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub axis: Vec<f64>,
    /// Start (s), non-negative.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub start: f64,
    /// Time of growth of velocity and rate from zero (s), non-negative.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub ramp: f64,
}

impl ObstacleMotion {
    /// Time at full velocity in which the obstacle would move as far as it does until `time`, its start and ramp included (s).
    pub fn equivalent_full_speed_time(&self, time: f64) -> f64 {
        let since = (time - self.start).max(0.0);
        if since < self.ramp { 0.5 * since * since / self.ramp } else { since - 0.5 * self.ramp }
    }

    /// Share of its full velocity at `time` (s), 0 to 1.
    pub fn ramp_factor(&self, time: f64) -> f64 {
        let since = time - self.start;
        if since < 0.0 {
            0.0
        } else if since < self.ramp {
            since / self.ramp
        } else {
            1.0
        }
    }

    /// Position and rotation at `time` (s).
    pub fn transform<const D: usize>(&self, time: f64) -> RigidTransform<D> {
        let full = self.equivalent_full_speed_time(time);
        let at = |values: &[f64], c: usize| values.get(c).copied().unwrap_or(0.0);
        let axis = std::array::from_fn(|c| at(&self.axis, c));
        let centre = std::array::from_fn(|c| at(&self.centre, c));
        let turned = RigidTransform::rotation_about(centre, axis, self.rotation.to_radians() * full);
        turned.shifted(&std::array::from_fn(|c| full * at(&self.velocity, c)))
    }
}

/// Action of an obstacle on material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ObstacleWall {
    /// No slip.
    Rough,
    /// Free slip: only normal velocity is constrained.
    Smooth,
    /// Coulomb friction; the material may separate.
    Frictional {
        /// Interface friction coefficient.
        friction_coefficient: f64,
        /// Adhesion (Pa) besides friction, under pressure.
        #[serde(default, skip_serializing_if = "is_zero")]
        adhesion: f64,
    },
}

impl From<ObstacleWall> for Wall {
    /// Wall with the same friction law but without adhesion.
    fn from(wall: ObstacleWall) -> Self {
        match wall {
            ObstacleWall::Rough => Self::Rough,
            ObstacleWall::Smooth => Self::Smooth,
            ObstacleWall::Frictional { friction_coefficient, .. } => {
                Self::Frictional { friction_coefficient, bilateral: false }
            }
        }
    }
}

/// Obstacle surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ObstacleShape {
    /// Infinite plane (2D line).
    Plane {
        /// Point on the plane (m).
        point: Vec<f64>,
        /// Normal out of the solid, of any length.
        normal: Vec<f64>,
    },
    /// Axis-aligned box.
    Box {
        /// Lower corner (m).
        min: Vec<f64>,
        /// Upper corner (m).
        max: Vec<f64>,
    },
    /// Ball (disk in 2D).
    Ball {
        /// Centre (m).
        centre: Vec<f64>,
        /// Radius (m).
        radius: f64,
        /// Whether the solid is outside, as a bowl.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        hollow: bool,
    },
    /// Ground below a line of straight pieces in 2D, from either end; none beyond. Give `points` or a `file`.
    GroundLine {
        /// Points (m).
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        points: Vec<[f64; 2]>,
        /// CSV file of x and y in metres, or units in brackets in a line of names, as `x (ft)`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        file: Option<String>,
    },
    /// Ground below straight pieces and arcs in 2D, from left to right.
    Profile {
        /// First point (m).
        start: [f64; 2],
        /// Pieces, in order.
        pieces: Vec<ProfilePiece>,
    },
    /// Polygon in 2D, without crossings, in either sense.
    Polygon {
        /// Corners (m).
        vertices: Vec<[f64; 2]>,
    },
    /// Extruded polygon in 3D.
    Extruded {
        /// Corners along the other two axes, in the order x, y, z (m).
        vertices: Vec<[f64; 2]>,
        /// Extrusion axis: 0 is x.
        axis: usize,
        /// First coordinate along the axis (m).
        from: f64,
        /// Last coordinate along the axis (m).
        to: f64,
    },
    /// Solid of revolution in 3D: a polygon rotated about an axis-parallel line.
    Turned {
        /// Corners: distance from the line, coordinate along it (m).
        vertices: Vec<[f64; 2]>,
        /// Axis of the line: 0 is x.
        axis: usize,
        /// Point on the line (m).
        centre: [f64; 3],
    },
    /// Ground in 3D from a raster in metres, two triangles between four nodes; none beyond or without data.
    Raster {
        /// ESRI ASCII grid or GeoTIFF.
        file: String,
        /// Resampling distance along x and y (m); the file's when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        spacing: Option<f64>,
    },
    /// Closed triangle mesh in 3D, in metres: STL (`.stl`) or Wavefront OBJ (`.obj`). STL has seven digits: far from the origin use OBJ.
    Mesh {
        /// File.
        file: String,
    },
}

/// Piece of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfilePiece {
    /// End (m).
    pub to: [f64; 2],
    /// Arc centre (m), the shorter way round; straight when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre: Option<[f64; 2]>,
}

impl ObstacleShape {
    /// Whether it has a file.
    pub fn has_file(&self) -> bool {
        matches!(self, Self::GroundLine { file: Some(_), .. } | Self::Raster { .. } | Self::Mesh { .. })
    }

    /// Name of its file, mutable.
    pub fn file_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::GroundLine { file, .. } => file.as_mut(),
            Self::Raster { file, .. } | Self::Mesh { file } => Some(file),
            _ => None,
        }
    }
}

/// Whether a number is zero, its default, so that a written case leaves it out.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde requires a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
