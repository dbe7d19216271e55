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

pub use bisection::{Bisection, BoundingBox, halo};
pub use boxes::BoxLocation;
pub use columns::ScratchBuffers;
pub use layer::{FeatureOverlap, LayerError, OutlineFeature, PlacedLayer, TerrainLayer, ThicknessData};
pub use layer_options::{LayerRows, LayerThickness, ThicknessAttribute, ThicknessDirection};
pub use meeting::overlapping_boxes;
pub use microstructure::CachedPacking;
pub use neighbours::{
    BLOCK_POINTS, CellList, HalfNeighbourList, NeighbourBlock, NeighbourList, SearchError,
    farthest_from_mean, max_cells,
};
pub use outline::{Outline, Polygon, Ring};
pub use pieces::UnionFind;
pub use polygon::PolygonVertices;
pub use raster::{GeoKey, Georeference, Raster, RasterError};
pub use sampling::{
    Sample, Sampling, SamplingError, common_interior_point, fitted, gauss_per_cell, lattice, per_cell,
    poisson_disk, poisson_spaced, random,
};
pub use shape::{Shape, ShapeError};
pub use skin::{SurfacePatch, boundary_area_vectors};
pub use surface::Surface;
pub use terrain::{BilinearWeights, Terrain, TerrainSample};
