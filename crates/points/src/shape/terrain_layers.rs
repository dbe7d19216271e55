//! Layers within a shape.

use crate::shape::Shape;
use crate::terrain::layer_options::{LayerRows, LayerThickness};

impl Shape {
    /// All layers within the shape, with their paths below `path`.
    pub fn layers_mut(&mut self, path: String) -> Vec<(String, &mut Self)> {
        match self {
            Self::Layer { .. } | Self::ArcLayer { .. } => vec![(path, self)],
            Self::Union { shapes } | Self::Intersection { shapes } => {
                let each = shapes.iter_mut().enumerate();
                each.flat_map(|(number, shape)| shape.layers_mut(format!("{path}.shapes[{number}]")))
                    .collect()
            }
            Self::Difference { from, cut } => {
                let mut all = from.layers_mut(format!("{path}.from"));
                all.extend(cut.layers_mut(format!("{path}.cut")));
                all
            }
            _ => Vec::new(),
        }
    }

    /// Largest thickness of a layer (m), in its direction of measurement; `None` for other shapes, and before its files are read.
    pub fn layer_thickness(&self) -> Option<f64> {
        /// Sampling positions along each axis of a layer of variable thickness.
        const SAMPLES_PER_AXIS: usize = 64;
        match self {
            Self::ArcLayer { from, to, .. } => Some(to - from),
            Self::Layer { thickness: LayerThickness::Uniform(thickness), .. } => Some(*thickness),
            Self::Layer { laid, .. } => {
                let (layer, (low, high)) = (laid.layer()?, laid.bounds());
                let at = |axis: usize, k: usize| {
                    low[axis] + (high[axis] - low[axis]) * (k as f64 + 0.5) / SAMPLES_PER_AXIS as f64
                };
                let places = (0..SAMPLES_PER_AXIS * SAMPLES_PER_AXIS)
                    .map(|k| (at(0, k % SAMPLES_PER_AXIS), at(1, k / SAMPLES_PER_AXIS)));
                Some(places.map(|(x, y)| layer.thickness(x, y)).fold(0.0, f64::max))
            }
            _ => None,
        }
    }

    /// Whether the points of the shape lie in rows that follow the terrain.
    pub fn follows_terrain(&self) -> bool {
        matches!(
            self,
            Self::Layer { rows: LayerRows::Terrain, .. } | Self::ArcLayer { rows: LayerRows::Terrain, .. }
        )
    }
}
