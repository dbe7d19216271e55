//! Terrain layer: a layer on terrain, within an outline in plan.

use std::sync::Arc;

use thiserror::Error;

use crate::plan::plan_integral::{PlanGrid, integrate_over_polygons};
use crate::surface::HeightField;
use crate::terrain::layer_options::ThicknessDirection;
use crate::{Outline, Polygon, Raster, Terrain};

/// Smallest and largest number of sampling positions of a layer along an axis.
const SCAN_POINTS: (usize, usize) = (64, 1000);

/// Largest number of cells along an axis for the volume of a layer.
const MAX_CELLS: f64 = 2000.0;

/// Overlap of two features over the area of the smaller one, up to which it is ignored.
const SLIVER_FRACTION: f64 = 1e-3;

/// Thickness of a layer as its files state it (m).
#[derive(Clone, Debug)]
pub enum ThicknessData {
    /// Uniform thickness (m).
    Uniform(f64),
    /// Thickness at the nodes of a raster.
    Raster(Raster),
    /// Thickness of features of the outline. Where features overlap, the last one counts.
    Features(Vec<OutlineFeature>),
}

/// Feature of an outline file, with its own thickness.
#[derive(Clone, Debug)]
pub struct OutlineFeature {
    /// Number in the file, from 1.
    pub number: usize,
    /// Outline of the feature.
    pub outline: Outline,
    /// Thickness of the layer there (m).
    pub thickness: f64,
}

/// Overlap of two features of different thickness.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureOverlap {
    /// Numbers of the features in the file. The thickness of the second one applies in the overlap.
    pub features: [usize; 2],
    /// Area in common (m²).
    pub area: f64,
}

/// Error in a layer, at a key of its shape.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{key}: {problem}")]
pub struct LayerError {
    /// Key of the shape.
    pub key: &'static str,
    /// Description of the error.
    pub problem: String,
}

/// Layer between the ground and a surface above it at the distance of its thickness, within an outline in plan.
#[derive(Clone, Debug)]
pub struct TerrainLayer {
    ground: HeightField,
    slopes: Option<Terrain>,
    outline: Outline,
    depths: ThicknessData,
    low: [f64; 3],
    high: [f64; 3],
    step: [f64; 2],
    volume: f64,
}

impl TerrainLayer {
    /// Outline of a layer for which the case has none: the box around the raster nodes with a positive thickness. It is extended by one
    /// node spacing where there is ground.
    ///
    /// # Errors
    /// When no node is above zero, or such a node lies beyond the ground.
    pub fn outline_of_thickness(thickness: &Raster, ground: &Raster) -> Result<Outline, String> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (number, _) in thickness.values.iter().enumerate().filter(|(_, depth)| **depth > 0.0) {
            let place = thickness.node_position(number % thickness.columns, number / thickness.columns);
            (low, high) = (
                std::array::from_fn(|c| low[c].min(place[c])),
                std::array::from_fn(|c| high[c].max(place[c])),
            );
        }
        if !(low[0] <= high[0]) {
            return Err("is above zero nowhere".to_owned());
        }
        let ends = [thickness.last_node_position(), ground.last_node_position()];
        if (0..2).any(|c| low[c] < ground.origin[c] || high[c] > ends[1][c]) {
            return Err("is above zero beyond the raster below the layer".to_owned());
        }
        for c in 0..2 {
            low[c] = (low[c] - thickness.spacing[c]).max(thickness.origin[c]).max(ground.origin[c]);
            high[c] = (high[c] + thickness.spacing[c]).min(ends[0][c]).min(ends[1][c]);
        }
        Outline::new(vec![vec![vec![low, [high[0], low[1]], high, [low[0], high[1]]]]])
    }

    /// Layer on the heights of `ground` (m). Error messages give positions relative to `origin` (m).
    ///
    /// # Errors
    /// When the outline extends beyond the ground or the raster of the thickness, or the ground has no data there; when the thickness is
    /// negative or absent.
    pub fn new(
        ground: Raster,
        outline: Outline,
        mut depths: ThicknessData,
        measured: ThicknessDirection,
        origin: [f64; 2],
    ) -> Result<Self, LayerError> {
        if let ThicknessData::Raster(raster) = &mut depths {
            // Nodes without data become zero: the layer ends before the next node, with the volume of the raster.
            raster.values.iter_mut().filter(|depth| depth.is_nan()).for_each(|depth| *depth = 0.0);
        }
        let error = |key, problem: String| LayerError { key, problem };
        let (low, high) = outline.bounds();
        let end = ground.last_node_position();
        if (0..2).any(|c| low[c] < ground.origin[c] || high[c] > end[c]) {
            let map = |x: [f64; 2]| [x[0] + origin[0], x[1] + origin[1]];
            let problem = format!(
                "reaches from {:?} to {:?} m, beyond the raster below the layer, from {:?} to {:?} m",
                map(low),
                map(high),
                map(ground.origin),
                map(end)
            );
            return Err(error("outline", problem));
        }
        let places: [usize; 2] = std::array::from_fn(|c| {
            let cells = 2.0 * (high[c] - low[c]) / ground.spacing[c];
            (cells.ceil() as usize).clamp(SCAN_POINTS.0, SCAN_POINTS.1)
        });
        let slopes = (measured == ThicknessDirection::Normal).then(|| Terrain::new(ground.clone(), 0));
        let slopes = slopes.transpose().map_err(|e| error("on", e.to_string()))?;
        let mut layer = Self {
            ground: HeightField::new(ground).map_err(|e| error("on", e.to_string()))?,
            slopes,
            outline,
            depths,
            low: [low[0], low[1], f64::INFINITY],
            high: [high[0], high[1], f64::NEG_INFINITY],
            step: std::array::from_fn(|c| (high[c] - low[c]) / places[c] as f64),
            volume: 0.0,
        };
        layer.scan(places, origin)?;
        Ok(layer)
    }

    /// Samples the whole layer, and determines its lowest and highest level, its volume, and whether there is data.
    fn scan(&mut self, places: [usize; 2], origin: [f64; 2]) -> Result<(), LayerError> {
        let mut sum = 0.0;
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        for number in 0..places[0] * places[1] {
            let cell = [number % places[0], number / places[0]];
            let [x, y] = std::array::from_fn(|c| self.low[c] + self.step[c] * (cell[c] as f64 + 0.5));
            if !self.outline.contains([x, y]) {
                continue;
            }
            let refuse = |key, what: String| {
                let problem = format!("{what} at [{}, {}] m", x + origin[0], y + origin[1]);
                Err(LayerError { key, problem })
            };
            let Some(thickness) = self.vertical_thickness(x, y) else {
                return refuse("thickness", "does not cover the whole outline: it ends".to_owned());
            };
            if !(thickness >= 0.0) {
                return refuse("thickness", format!("{thickness} m is negative"));
            }
            sum += thickness;
            if thickness == 0.0 {
                continue;
            }
            let Some(ground) = self.ground.height(x, y) else {
                return refuse("on", "the raster below the layer has no data".to_owned());
            };
            (lowest, highest) = (lowest.min(ground), highest.max(ground + thickness));
        }
        if !(sum > 0.0) {
            let problem =
                "is zero in the whole outline, or the outline is too narrow for the raster below the layer";
            return Err(LayerError { key: "thickness", problem: problem.to_owned() });
        }
        (self.low[2], self.high[2]) = (lowest, highest);
        self.volume = self.integrate_volume();
        if !(self.volume > 0.0) {
            let problem = format!("encloses an area of {} m²: there is no volume", self.outline.area());
            return Err(LayerError { key: "outline", problem });
        }
        Ok(())
    }

    /// Volume (m³): the integral of the vertical thickness over the outline. It is exact for uniform thickness on separate areas, and,
    /// apart from cells that the outline cuts, for a raster of vertical thickness.
    fn integrate_volume(&self) -> f64 {
        let ground = self.ground.raster();
        let over = |polygons: &[Polygon], raster: &Raster, depth: &dyn Fn([f64; 2]) -> f64| {
            let step = match &self.slopes {
                Some(_) => std::array::from_fn(|c| raster.spacing[c].min(ground.spacing[c])),
                None => raster.spacing,
            };
            let (low, high) = self.outline.bounds();
            // The number of cells is at most that of the sampling positions of a layer; whole numbers of raster cells form one.
            let step = std::array::from_fn(|c| {
                step[c] * ((high[c] - low[c]) / (MAX_CELLS * step[c])).ceil().max(1.0)
            });
            let grid = PlanGrid { origin: raster.origin, step };
            integrate_over_polygons(polygons, &grid, &mut |place| {
                depth(place) * self.vertical_per_normal(place).unwrap_or(1.0)
            })
        };
        match &self.depths {
            ThicknessData::Uniform(depth) if self.slopes.is_none() => depth * self.outline.area(),
            ThicknessData::Uniform(depth) => over(self.outline.disjoint_polygons(), ground, &|_| *depth),
            ThicknessData::Raster(raster) => over(self.outline.disjoint_polygons(), raster, &|[x, y]| {
                raster.interpolate(x, y).unwrap_or(0.0)
            }),
            ThicknessData::Features(features) => {
                let (mut sum, mut later) = (0.0, Vec::new());
                for feature in features.iter().rev() {
                    sum += over(&feature.outline.difference(&later), ground, &|_| feature.thickness);
                    later = feature.outline.union(&later);
                }
                sum
            }
        }
    }

    /// Ratio of the vertical thickness to the given thickness at a position of the terrain; `None` where the terrain has no slope.
    fn vertical_per_normal(&self, [x, y]: [f64; 2]) -> Option<f64> {
        let Some(slopes) = &self.slopes else { return Some(1.0) };
        let [a, b] = slopes.sample_at(x, y)?.gradient;
        Some((1.0 + a * a + b * b).sqrt())
    }

    /// Vertical thickness at a position of the terrain, in the outline or not (m).
    fn vertical_thickness(&self, x: f64, y: f64) -> Option<f64> {
        let depth = match &self.depths {
            ThicknessData::Uniform(depth) => *depth,
            ThicknessData::Raster(raster) => raster.interpolate(x, y)?,
            ThicknessData::Features(features) => {
                features.iter().rfind(|feature| feature.outline.contains([x, y]))?.thickness
            }
        };
        if depth == 0.0 { Some(0.0) } else { Some(depth * self.vertical_per_normal([x, y])?) }
    }

    /// Vertical thickness at a position in plan (m); zero beyond the outline.
    pub fn thickness(&self, x: f64, y: f64) -> f64 {
        if !self.outline.contains([x, y]) {
            return 0.0;
        }
        self.vertical_thickness(x, y).unwrap_or(0.0)
    }

    /// Overlaps of features of different thickness. Slivers along a common border are left out.
    pub fn overlaps(&self) -> Vec<FeatureOverlap> {
        let ThicknessData::Features(features) = &self.depths else { return Vec::new() };
        let mut found = Vec::new();
        for (later, second) in features.iter().enumerate() {
            for first in features[..later].iter().filter(|first| first.thickness != second.thickness) {
                let area = first.outline.overlap(&second.outline);
                if area > SLIVER_FRACTION * first.outline.area().min(second.outline.area()) {
                    found.push(FeatureOverlap { features: [first.number, second.number], area });
                }
            }
        }
        found
    }

    /// Outline in plan.
    pub fn outline(&self) -> &Outline {
        &self.outline
    }

    /// Lower and upper end of the layer at a position in plan (m).
    pub(crate) fn vertical_range(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let thickness = self.thickness(x, y);
        let ground = self.ground.height(x, y).filter(|_| thickness > 0.0)?;
        Some([ground, ground + thickness])
    }
}

/// Layer on terrain, which is empty before its files are read. Any two compare equal: the shape's own parameters identify them.
#[derive(Clone, Debug, Default)]
pub struct PlacedLayer(Option<Arc<TerrainLayer>>);

impl PartialEq for PlacedLayer {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl From<TerrainLayer> for PlacedLayer {
    fn from(layer: TerrainLayer) -> Self {
        Self(Some(Arc::new(layer)))
    }
}

impl PlacedLayer {
    /// Layer; `None` before its files are read.
    pub fn layer(&self) -> Option<&TerrainLayer> {
        self.0.as_deref()
    }
    pub(crate) fn contains(&self, point: &[f64]) -> bool {
        let stretch = self.layer().and_then(|layer| layer.vertical_range(point[0], point[1]));
        stretch.is_some_and(|[from, to]| (from..=to).contains(&point[2]))
    }

    /// Lower and upper corner of the box around the layer (m).
    pub(crate) fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let of = |layer: &TerrainLayer| (layer.low.to_vec(), layer.high.to_vec());
        self.layer().map_or_else(|| (vec![f64::INFINITY; 3], vec![f64::NEG_INFINITY; 3]), of)
    }

    /// Coordinates along an axis at which a line crosses the layer. They are exact along the vertical, and else at sampling positions.
    pub(crate) fn crossings(&self, point: &[f64], axis: usize) -> Vec<f64> {
        let Some(layer) = self.layer() else { return Vec::new() };
        if axis == 2 {
            return layer.vertical_range(point[0], point[1]).into_iter().flatten().collect();
        }
        let (low, high, step) = (layer.low[axis], layer.high[axis], layer.step[axis]);
        let count = ((high - low) / step).round() as usize;
        (0..=count).map(|k| low + step * k as f64).collect()
    }

    /// Volume of the layer (m³).
    pub(crate) fn volume(&self) -> Option<f64> {
        self.layer().map(|layer| layer.volume)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LayerRows, LayerThickness, Shape};

    fn slope() -> Raster {
        Raster::from_function([41, 31], [0.0; 2], [1.0; 2], |x, _| 20.0 - 0.75 * x)
    }

    fn square(low: f64, high: f64) -> Outline {
        Outline::new(vec![vec![vec![[low, low], [high, low], [high, high], [low, high]]]]).unwrap()
    }

    fn shape(layer: TerrainLayer) -> Shape {
        Shape::Layer {
            on: "slope".into(),
            outline: Some("outline.geojson".into()),
            thickness: LayerThickness::Uniform(1.0),
            measured: ThicknessDirection::Vertical,
            rows: LayerRows::Level,
            laid: layer.into(),
        }
    }

    #[test]
    fn volumes_of_layers_are_those_of_prisms() {
        let layer = |depths, measured| {
            TerrainLayer::new(slope(), square(5.0, 25.0), depths, measured, [0.0; 2]).unwrap()
        };
        let volume = |layer| shape(layer).measure(3).unwrap();
        assert!(
            (volume(layer(ThicknessData::Uniform(1.5), ThicknessDirection::Vertical)) - 600.0).abs() < 1e-9
        );
        // The cosine of the slope is 0.8.
        assert!(
            (volume(layer(ThicknessData::Uniform(1.5), ThicknessDirection::Normal)) - 750.0).abs() < 1e-9
        );
        let wedge = Raster::from_function([41, 31], [0.0; 2], [1.0; 2], |x, _| 0.1 * (x - 5.0).max(0.0));
        let found = volume(layer(ThicknessData::Raster(wedge), ThicknessDirection::Vertical));
        assert!((found - 400.0).abs() < 1e-9, "{found}");
        // A fine raster on coarse ground, within an outline that cuts its cells.
        let fine = Raster::from_function([101, 101], [10.0; 2], [0.1; 2], |x, y| (x - 10.0) * (y - 10.0));
        let cut = TerrainLayer::new(
            slope(),
            square(11.03, 18.57),
            ThicknessData::Raster(fine),
            ThicknessDirection::Vertical,
            [0.0; 2],
        );
        let exact = (0.5 * (8.57f64.powi(2) - 1.03f64.powi(2))).powi(2);
        assert!((volume(cut.unwrap()) / exact - 1.0).abs() < 1e-12);
        // A union is integrated by chords, like any shape.
        let chords = Shape::Union {
            shapes: vec![shape(layer(ThicknessData::Uniform(1.5), ThicknessDirection::Normal))],
        };
        assert!((chords.volume(3, false) / 750.0 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn overlapping_layer_features_use_the_last_thickness_and_the_overlap_is_reported() {
        let feature =
            |number, low, high, thickness| OutlineFeature { number, outline: square(low, high), thickness };
        let laid = |features: Vec<OutlineFeature>| {
            let polygons = features.iter().flat_map(|f| f.outline.polygons().to_vec()).collect();
            let outline = Outline::new(polygons).unwrap();
            TerrainLayer::new(
                slope(),
                outline,
                ThicknessData::Features(features),
                ThicknessDirection::Vertical,
                [0.0; 2],
            )
            .unwrap()
        };
        // 3 m on 100 m² within 1 m on 400 m²; the sampling positions divide both evenly.
        let within = laid(vec![feature(1, 5.0, 25.0, 1.0), feature(4, 10.0, 20.0, 3.0)]);
        assert!((within.volume - 600.0).abs() < 1e-9, "{}", within.volume);
        assert_eq!((within.thickness(15.0, 15.0), within.thickness(6.0, 15.0)), (3.0, 1.0));
        let [overlap] = &within.overlaps()[..] else { panic!("{:?}", within.overlaps()) };
        assert!(overlap.features == [1, 4] && (overlap.area - 100.0).abs() < 1e-9, "{overlap:?}");
        let hidden = laid(vec![feature(1, 10.0, 20.0, 3.0), feature(2, 5.0, 25.0, 1.0)]);
        assert!((hidden.volume - 400.0).abs() < 1e-9 && hidden.overlaps().len() == 1);
        // Far apart, of different size and thickness, at positions that no lattice divides evenly.
        let apart = laid(vec![feature(1, 1.3, 2.4, 10.0), feature(2, 11.7, 28.9, 1.0)]);
        assert!((apart.volume - (10.0 * 1.1 * 1.1 + 17.2 * 17.2)).abs() < 1e-9, "{}", apart.volume);
        // Features of equal thickness are no conflict, nor is a border drawn twice.
        assert_eq!(laid(vec![feature(1, 5.0, 25.0, 2.0), feature(2, 10.0, 20.0, 2.0)]).overlaps(), []);
        assert_eq!(laid(vec![feature(1, 5.0, 15.001, 1.0), feature(2, 15.0, 25.0, 2.0)]).overlaps(), []);
    }

    #[test]
    fn a_layer_lies_on_its_ground_within_its_outline() {
        let layer = TerrainLayer::new(
            slope(),
            square(5.0, 25.0),
            ThicknessData::Uniform(2.0),
            ThicknessDirection::Vertical,
            [0.0; 2],
        );
        let shape = shape(layer.unwrap());
        for (point, inside) in [
            ([15.0, 15.0, 8.75 + 0.01], true),
            ([15.0, 15.0, 8.75 - 0.01], false),
            ([15.0, 15.0, 10.74], true),
            ([15.0, 15.0, 10.76], false),
            ([4.9, 15.0, 17.0], false),
        ] {
            assert_eq!(shape.contains(&point), inside, "{point:?}");
        }
        assert_eq!(shape.crossings(&[15.0, 15.0, 0.0], 2), [8.75, 10.75]);
        let (low, high) = shape.bounds(3);
        assert!(low[0] == 5.0 && high[1] == 25.0 && low[2] > 1.2 && high[2] < 18.3, "{low:?} {high:?}");
    }

    #[test]
    fn no_data_of_a_thickness_raster_is_zero_thickness() {
        let dry = |x: f64, y: f64| {
            if (10.0..=20.0).contains(&x) && (8.0..=19.0).contains(&y) { 2.0 } else { f64::NAN }
        };
        let deposit = Raster::from_function([41, 31], [0.0; 2], [1.0; 2], dry);
        let sum: f64 = deposit.values.iter().filter(|depth| depth.is_finite()).sum();
        let layer = TerrainLayer::new(
            slope(),
            square(5.0, 25.0),
            ThicknessData::Raster(deposit),
            ThicknessDirection::Vertical,
            [0.0; 2],
        )
        .unwrap();
        for (x, y, depth) in
            [(15.0, 15.0, 2.0), (9.5, 15.0, 1.0), (9.0, 15.0, 0.0), (6.5, 15.0, 0.0), (20.5, 19.5, 0.5)]
        {
            assert!((layer.thickness(x, y) - depth).abs() < 1e-12, "{x} {y}");
        }
        // Sampling positions are the centres of cells of 0.3125 m.
        assert!((layer.volume / sum - 1.0).abs() < 2e-3, "{} {sum}", layer.volume);
    }

    #[test]
    fn a_layer_without_ground_or_thickness_is_none() {
        let refused = |ground: Raster, outline: Outline, depths: ThicknessData| {
            TerrainLayer::new(ground, outline, depths, ThicknessDirection::Vertical, [1000.0, 0.0])
                .unwrap_err()
                .to_string()
        };
        let off = refused(slope(), square(20.0, 32.0), ThicknessData::Uniform(1.0));
        assert!(off.starts_with("outline: reaches from [1020.0, 20.0]"), "{off}");
        let mut gap = slope();
        gap.values[15 * 41 + 15] = f64::NAN;
        let gap = refused(gap, square(5.0, 25.0), ThicknessData::Uniform(1.0));
        assert!(gap.starts_with("on: the raster below the layer has no data at [1014."), "{gap}");
        let raster = |z: f64, columns| Raster::from_function([columns, 31], [0.0; 2], [1.0; 2], |_, _| z);
        let none = |depths| refused(slope(), square(5.0, 25.0), ThicknessData::Raster(depths));
        assert!(none(raster(0.0, 41)).contains("is zero in the whole outline"));
        assert!(none(raster(f64::NAN, 41)).contains("is zero in the whole outline"));
        assert!(none(raster(-1.0, 41)).contains("-1 m is negative"));
        assert!(
            none(raster(1.0, 20))
                .starts_with("thickness: does not cover the whole outline: it ends at [1019.")
        );
    }
}
