//! Specimens in files: grains, what their contacts remember, the cell and the walls, for another case to begin with.
//!
//! A file is one JSON object: a head with what stands once, and two tables, of the grains and of their contacts. Numbers read back
//! to the last bit. Velocities are half a step behind the places, as the solver has them.

mod contacts;
mod read;
mod write;

use colluvium_case::output::Table;
use serde::{Deserialize, Serialize};

/// What a file says of itself.
const FORMAT: &str = "colluvium-specimen-1";

/// Path of the key that names a file.
const KEY: &str = "methods.dem.specimen";

/// In place of a grain or a wall where a contact has none.
const NO_INDEX: f64 = -1.0;

/// A specimen as its file has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredSpecimen {
    head: SpecimenHeader,
    /// A row for each grain.
    grains: Table,
    /// A row for each contact of two grains, or of a grain with a wall.
    contacts: Table,
}

/// What stands once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SpecimenHeader {
    format: String,
    /// Title of the case that it is from.
    title: String,
    dimension: usize,
    /// Time of that case (s).
    time: f64,
    /// Length of the step before (s); zero after velocities were set.
    step: f64,
    /// From where coordinates are (m).
    origin: Vec<f64>,
    cell: StoredCell,
    /// Bodies, and the kind of the grains of each.
    bodies: Vec<String>,
    kinds: Vec<String>,
    walls: Vec<StoredWall>,
    /// Obstacles that move, whose contacts are not in the file.
    left_out: Vec<String>,
    /// Whether contacts were bonded, or cohesive from the start on.
    bonded: bool,
    /// Largest overlap over the smaller radius.
    overlap: f64,
}

/// The box of the grains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredCell {
    /// Along which axes it repeats itself.
    periodic: Vec<bool>,
    /// A corner (m).
    corner: Vec<f64>,
    /// Its vectors, one after another (m).
    vectors: Vec<Vec<f64>>,
    /// Its velocity gradient, row by row (1/s).
    rates: Vec<Vec<f64>>,
    /// Means of the entries of it that follow a stress (1/s); the entries themselves in files without them.
    #[serde(default)]
    mean_rates: Vec<Vec<f64>>,
    /// Stress of the motion of its grains times its volume, row by row (J).
    motion: Vec<Vec<f64>>,
}

/// A wall or an obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StoredWall {
    name: String,
    /// Of a wall, the axis across it, whether the grains are below it, and where it stands (m); none of an obstacle.
    plane: Option<(usize, bool, f64)>,
    /// Velocity of a wall (m/s).
    velocity: Vec<f64>,
}

/// Names of the columns of a quantity of so many components.
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
