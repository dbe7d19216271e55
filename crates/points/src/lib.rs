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
//! let most = (0..positions.len()).map(|i| neighbours.neighbours(i).len()).max();
//! assert_eq!(most, Some(4), "left, right, above, below");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod partition;
mod plan;
pub(crate) mod raster;
mod sampling;
mod search;
mod shape;
pub mod struct_of_arrays;
pub mod surface;
mod terrain;

pub use crate::partition::bisection::{Bisection, BoundingBox, halo_points};
pub use crate::plan::outline::{Outline, Polygon, Ring};
pub use crate::plan::polygon::PolygonVertices;
pub use crate::raster::{GeoKey, Georeference, Raster, RasterError};
pub use crate::search::box_overlaps::overlapping_boxes;
pub use crate::search::neighbours::{
    BLOCK_POINTS, CellList, HalfNeighbourList, NeighbourBlock, NeighbourList, SearchError,
    farthest_from_mean, max_cells,
};
pub use crate::search::union_find::UnionFind;
pub use crate::shape::boundary_points::{SurfacePatch, boundary_area_vectors};
pub use crate::shape::box_classification::BoxLocation;
pub use crate::shape::microstructure::CachedPacking;
pub use crate::struct_of_arrays::ScratchBuffers;
pub use crate::terrain::layer_options::{LayerRows, LayerThickness, ThicknessAttribute, ThicknessDirection};
pub use crate::terrain::smooth_terrain::{BilinearWeights, Terrain, TerrainSample};
pub use crate::terrain::terrain_layer::{
    FeatureOverlap, LayerError, OutlineFeature, PlacedLayer, TerrainLayer, ThicknessData,
};
pub use sampling::{
    Sample, Sampling, SamplingError, common_interior_point, fitted_rows, gauss_per_cell, lattice, per_cell,
    poisson_disk, poisson_spaced, random,
};
pub use shape::{Shape, ShapeError};
pub use surface::Surface;
