//! Shapes, surfaces, terrain, sampling, neighbour search and partition for point-based methods.
//!
//! ```
//! use colluvium_points::{NeighbourList, Shape, lattice};
//!
//! let disk = Shape::Ball { centre: vec![0.0, 0.0], radius: 0.5 };
//! let samples = lattice(&disk, [0.0, 0.0], 0.05)?;
//! let positions: Vec<[f64; 2]> = samples.iter().map(|sample| sample.position).collect();
//!
//! let mut neighbours = NeighbourList::new();
//! neighbours.build(&positions, 0.051)?;
//! let most = (0..positions.len()).map(|i| neighbours.of(i).len()).max();
//! assert_eq!(most, Some(4), "left, right, above, below");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bisection;
mod boxes;
pub mod columns;
mod layer;
mod layer_options;
mod meeting;
mod microstructure;
mod neighbours;
mod outline;
mod pieces;
mod plan_integral;
mod polygon;
mod raster;
mod sampling;
mod shape;
mod skin;
pub mod surface;
mod terrain;

pub use bisection::{Bisection, Bounds, halo};
pub use boxes::Place;
pub use columns::Spare;
pub use layer::{Depths, Feature, Laid, Layer, LayerError, Overlap};
pub use layer_options::{Attribute, LayerRows, Measured, Thickness};
pub use meeting::meeting_boxes;
pub use microstructure::Grains;
pub use neighbours::{CellList, HalfList, NeighbourList, ROWS, Rows, SearchError, farthest, most_cells};
pub use outline::{Outline, Polygon, Ring};
pub use pieces::Pieces;
pub use polygon::Corners;
pub use raster::{GeoKey, Georeference, Raster, RasterError};
pub use sampling::{
    Sample, Sampling, SamplingError, fitted, gauss_per_cell, lattice, overlap, per_cell, poisson_disk,
    poisson_spaced, random,
};
pub use shape::{Shape, ShapeError};
pub use skin::{Piece, area_vectors};
pub use surface::Surface;
pub use terrain::{Bed, Terrain, Weights};
