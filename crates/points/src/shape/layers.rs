//! The layers that a shape consists of.

use super::Shape;
use crate::layer::LayerRows;

impl Shape {
    /// Every layer that it consists of, and where it stands below `path`.
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

    /// Whether its points lie in rows that follow the terrain.
    pub fn follows_terrain(&self) -> bool {
        matches!(
            self,
            Self::Layer { rows: LayerRows::Terrain, .. } | Self::ArcLayer { rows: LayerRows::Terrain, .. }
        )
    }
}
