//! Specimen files: grains, contact histories, the cell and the walls, as the start of another case.
//!
//! A file is one JSON object: a head, and two tables, of the grains and of their contacts. Numbers read back
//! to the last bit. Velocities are half a step behind the positions, as in the solver.

mod contacts;
mod read;
mod write;

use colluvium_case::output::Table;
use serde::{Deserialize, Serialize};

/// Format identifier of a file.
const FORMAT: &str = "colluvium-specimen-1";

/// Path of the key in a case that names a file.
const KEY: &str = "methods.dem.specimen";

/// Number that stands for a missing grain or wall index.
const NO_INDEX: f64 = -1.0;

/// Specimen as stored in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredSpecimen {
    head: SpecimenHeader,
    /// Table of the grains, one row each.
    grains: Table,
    /// Table of the contacts of two grains, or of a grain with a wall, one row each.
    contacts: Table,
}

/// First part of a specimen file: cell, walls, materials and largest overlap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SpecimenHeader {
    format: String,
    /// Title of the case that wrote the file.
    title: String,
    dimension: usize,
    /// Time of that case (s).
    time: f64,
    /// Length of the last step (s); zero after velocities were set.
    step: f64,
    /// Origin of the coordinates (m).
    origin: Vec<f64>,
    cell: StoredCell,
    /// Names of the bodies; the next field is the kind of the grains of each.
    bodies: Vec<String>,
    kinds: Vec<String>,
    walls: Vec<StoredWall>,
    /// Names of moving obstacles, whose contacts are not in the file.
    #[serde(rename = "left_out")]
    omitted_obstacles: Vec<String>,
    /// Whether contacts were bonded, or cohesive from the start on.
    #[serde(rename = "bonded")]
    has_bonds: bool,
    /// Largest overlap over the smaller radius.
    overlap: f64,
}

/// Periodic cell in a specimen file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredCell {
    /// Axes along which the cell is periodic.
    periodic: Vec<bool>,
    /// Corner (m).
    corner: Vec<f64>,
    /// Cell vectors, one after another (m).
    vectors: Vec<Vec<f64>>,
    /// Velocity gradient, row by row (1/s).
    rates: Vec<Vec<f64>>,
    /// Means of the stress-controlled entries of the velocity gradient (1/s); the entries themselves in files without means.
    #[serde(default)]
    mean_rates: Vec<Vec<f64>>,
    /// Kinetic stress of the grains times the volume, row by row (J).
    motion: Vec<Vec<f64>>,
}

/// Wall or obstacle in a specimen file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredWall {
    name: String,
    /// Axis across a wall, whether it bounds the grains from above, and its position (m); `None` for an obstacle.
    plane: Option<(usize, bool, f64)>,
    /// Velocity of a wall (m/s).
    velocity: Vec<f64>,
}

/// Names of the columns of a quantity of `N` components.
fn names<const N: usize>(name: &str) -> [String; N] {
    let parts: &[&str] = match N {
        4 => &["w", "x", "y", "z"],
        _ => &["x", "y", "z"],
    };
    std::array::from_fn(|c| match (N, name) {
        (1, _) => name.to_owned(),
        (_, "") => parts[c].to_owned(),
        _ => format!("{name}_{}", parts[c]),
    })
}
