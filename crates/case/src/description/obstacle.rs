//! Obstacles: rigid geometry in contact with bodies.

use colluvium_points::Shape;
use colluvium_points::surface::RigidTransform;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Wall;

/// Rigid geometry of any shape that bodies meet, at rest or on a prescribed way. It may reach beyond the domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// Name.
    pub name: String,
    /// Its surface; the solid is behind it.
    pub shape: ObstacleShape,
    /// How it acts on what touches it.
    pub wall: ObstacleWall,
    /// Whether material may lift off (rough and smooth obstacles hold it otherwise; from frictional ones it always may).
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub separation: bool,
    /// How it moves; at rest when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<ObstacleMotion>,
    /// Parts of its surface with a wall of their own, seen in plan; the first that holds a place rules there. An obstacle that moves
    /// has none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<ObstacleRegion>,
}

/// A part of an obstacle's surface: all of it that lies in a part of the plan, which is the last coordinate left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObstacleRegion {
    /// Where, in plan: a box of one coordinate in two dimensions, any shape of two dimensions in three. Give this, `outline` or
    /// `raster`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// Where, in three dimensions: a file with polygons in metres, GeoJSON (`.geojson`, `.json`) or a shapefile (`.shp`), from the
    /// folder of the case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outline: Option<String>,
    /// Where, in three dimensions: cells of a raster, as one of land cover.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raster: Option<RasterCellSelection>,
    /// How it acts there.
    pub wall: ObstacleWall,
}

/// The cells of a raster over the plan that hold a number. Each reaches half a cell to all sides of its centre; beyond the raster there
/// are none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RasterCellSelection {
    /// The file, an ESRI ASCII grid (`.asc`, `.grd`, `.txt`) or a GeoTIFF (`.tif`, `.tiff`), from the folder of the case.
    pub file: String,
    /// The number that they hold, one of a raster of classes; any, but no data, when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
}

/// A prescribed motion of an obstacle: it turns about a line that moves along.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObstacleMotion {
    /// Velocity (m/s); none when absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocity: Vec<f64>,
    /// Rate at which it turns (degrees per second): anticlockwise in 2D, about `axis` by the right-hand rule in 3D.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rotation: f64,
    /// A place on the line about which it turns, at the start (m); needed with `rotation`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub centre: Vec<f64>,
    /// In 3D, direction of that line, of any length; needed with `rotation`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub axis: Vec<f64>,
    /// When it begins (s), not negative.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub start: f64,
    /// Time in which velocity and rate grow from zero (s), not negative.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub ramp: f64,
}

impl ObstacleMotion {
    /// Equivalent time of motion at full velocity by `time` (s).
    pub fn full_time(&self, time: f64) -> f64 {
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
        let full = self.full_time(time);
        let at = |values: &[f64], c: usize| values.get(c).copied().unwrap_or(0.0);
        let axis = std::array::from_fn(|c| at(&self.axis, c));
        let centre = std::array::from_fn(|c| at(&self.centre, c));
        let turned = RigidTransform::rotation_about(centre, axis, self.rotation.to_radians() * full);
        turned.shifted(&std::array::from_fn(|c| full * at(&self.velocity, c)))
    }
}

/// How an obstacle acts on what touches it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ObstacleWall {
    /// No slip.
    Rough,
    /// Free slip: only the velocity along the normal is held.
    Smooth,
    /// Coulomb friction; the material may lift off.
    Frictional {
        /// Coefficient of friction, tangent of the friction angle of the interface.
        friction_coefficient: f64,
        /// Adhesion: shear strength beside friction where the material is pressed on it (Pa).
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

/// The surface of an obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ObstacleShape {
    /// A plane (in 2D a line) without end.
    Plane {
        /// A place on it (m).
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
        /// Whether the solid is what lies around the ball, so that its inside is a bowl.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        hollow: bool,
    },
    /// In 2D, ground below a line of straight pieces, from either end. Beyond its ends there is no ground. Either `points` or a
    /// `file` is given.
    GroundLine {
        /// Its points (m).
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        points: Vec<[f64; 2]>,
        /// A CSV file with two columns, x and y: metres, or in the units that a line of names has between brackets, as `x (ft)`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        file: Option<String>,
    },
    /// In 2D, ground below a line of straight pieces and arcs, from left to right.
    Profile {
        /// Where it begins (m).
        start: [f64; 2],
        /// Its pieces, one after another.
        pieces: Vec<ProfilePiece>,
    },
    /// Polygon in 2D, without crossings, in either sense of rotation.
    Polygon {
        /// Corners (m).
        vertices: Vec<[f64; 2]>,
    },
    /// In 3D, a polygon drawn along an axis.
    Extruded {
        /// Corners in the plane of the other two axes, in the order x, y, z (m).
        vertices: Vec<[f64; 2]>,
        /// Axis: 0 is x.
        axis: usize,
        /// Where it begins along the axis (m).
        from: f64,
        /// Where it ends (m).
        to: f64,
    },
    /// In 3D, a polygon turned about a line along an axis.
    Turned {
        /// Corners: distance from the line, coordinate along it (m).
        vertices: Vec<[f64; 2]>,
        /// Axis of the line: 0 is x.
        axis: usize,
        /// A place on the line (m).
        centre: [f64; 3],
    },
    /// In 3D, ground under the heights of a raster: an ESRI ASCII grid (`.asc`, `.grd`, `.txt`) or a GeoTIFF (`.tif`, `.tiff`),
    /// in metres. Contact uses two triangles between four nodes. Beyond the raster, and where it has no data, there is no ground.
    Raster {
        /// The file, from the folder of the case.
        file: String,
        /// Distance of the nodes to resample it to, along x and y (m); that of the file when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        spacing: Option<f64>,
    },
    /// In 3D, a closed triangle mesh: STL (`.stl`) or Wavefront OBJ (`.obj`), in metres. STL has seven digits: a mesh far from
    /// its origin must be an OBJ file.
    Mesh {
        /// The file, from the folder of the case.
        file: String,
    },
}

/// A piece of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfilePiece {
    /// Where it ends (m).
    pub to: [f64; 2],
    /// Centre of an arc, which goes the shorter way round (m); a straight line when absent.
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

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
